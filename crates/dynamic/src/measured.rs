//! A frequency response as it was measured: the standard at its input, what its errors have in common, what is doubtful in it.

use crate::FrequencyResponse;
use crate::input_noise::InputNoise;
use crate::model::ResponsePoints;
use crate::reference_table::ReferenceTable;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_signal::Welch;
use proofmass_signal::transfer::{CrossSpectra, ResponseEstimate, turned};
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, EstimateSeries, Evaluation,
    Influence, SeriesPoint, SharedEffect,
};
use std::f64::consts::TAU;

/// Densities of input and output.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ResponsePower {
    /// Hz.
    pub frequency: Vec<f64>,
    /// Input, U²/Hz.
    pub input: Vec<f64>,
    /// Output, U²/Hz.
    pub output: Vec<f64>,
    /// Root mean square of input and output within the band.
    pub rms: [f64; 2],
}

impl ResponsePower {
    /// Of one input and its first output, within a band.
    pub fn of(spectra: &CrossSpectra, low: f64, high: f64) -> Self {
        let mut power = Self::default();
        let width = spectra.frequency.get(1).copied().unwrap_or(0.0);
        let mut sums = [0.0; 2];
        for (k, f) in spectra.frequency.iter().enumerate() {
            let Some(output) = spectra.outputs.first() else {
                break;
            };
            if !(low..=high).contains(f) {
                continue;
            }
            power.frequency.push(*f);
            power.input.push(spectra.input[k]);
            power.output.push(output.auto[k]);
            sums[0] += spectra.input[k] * width;
            sums[1] += output.auto[k] * width;
        }
        power.rms = sums.map(f64::sqrt);
        power
    }

    /// With the acceleration behind the volts of the input; lines that its calibration does not reach are left out.
    ///
    /// # Errors
    /// As [`ReferenceTable::at`].
    pub fn seen_by(&mut self, standard: &ReferenceTable) -> Result<(), Error> {
        let width = match self.frequency.as_slice() {
            [a, b, ..] => b - a,
            _ => 0.0,
        };
        let [low, high] = standard.reach();
        let keep: Vec<usize> = (0..self.frequency.len())
            .filter(|k| (low..=high).contains(&self.frequency[*k]))
            .collect();
        let input = keep.iter().map(|k| {
            let s = standard.at(self.frequency[*k])?.sensitivity;
            Ok(self.input[*k] / (s * s))
        });
        self.input = input.collect::<Result<_, Error>>()?;
        self.output = keep.iter().map(|k| self.output[*k]).collect();
        self.frequency = keep.iter().map(|k| self.frequency[*k]).collect();
        let rms = |of: &[f64]| (width * of.iter().sum::<f64>()).sqrt();
        self.rms = [rms(&self.input), rms(&self.output)];
        Ok(())
    }
}

/// The response to the acceleration behind the volts of a standard at the input, as far as its calibration reaches.
///
/// What the calibration has of a frequency alone stands beside the noise; what its frequencies have in common is [`CommonInput`].
///
/// # Errors
/// As [`ReferenceTable::at`].
pub fn by_standard(
    response: &ResponseEstimate,
    standard: &ReferenceTable,
) -> Result<ResponseEstimate, Error> {
    let [low, high] = standard.reach();
    let mut kept = response.within(low, high);
    for k in 0..kept.lines() {
        let point = standard.at(kept.frequency[k])?;
        let s = Complex64::from_polar(point.sensitivity, point.phase);
        kept.value[k] *= s;
        kept.covariance[k] = turned(kept.covariance[k], s);
        let own = standard.shares_at(kept.frequency[k])?.own;
        let z = kept.value[k];
        for e in [z * own[0], Complex64::i() * z * own[1]] {
            kept.covariance[k][0] += e.re * e.re;
            kept.covariance[k][1] += e.re * e.im;
            kept.covariance[k][2] += e.im * e.im;
        }
        if let Some(leakage) = kept.leakage.get_mut(k) {
            *leakage *= s;
        }
    }
    Ok(kept)
}

/// Causes of an error of the input that all frequencies have in common: keys and what they are.
const COMMON: [(&str, &str); 3] = [
    (
        "reference.modulus",
        "relative error of the input that its frequencies have in common",
    ),
    (
        "reference.phase",
        "phase of the input that its frequencies have in common",
    ),
    (
        "input.noise",
        "noise that may be on the input: the response by H1 would be too small",
    ),
];

/// Errors of the input that all frequencies have in common.
#[derive(Clone, Copy, Debug)]
pub struct CommonInput<'a> {
    /// Relative standard uncertainty of the input.
    pub relative: f64,
    /// Calibration over frequency of the transducer at the input.
    pub standard: Option<&'a ReferenceTable>,
    /// Noise that may be on the input, where nobody said that there is none.
    pub noise: Option<&'a InputNoise>,
}

impl CommonInput<'_> {
    /// Relative errors of the response that all its frequencies have in common, at one of them: a cause for the modulus, one for
    /// the phase, and the noise of the input.
    ///
    /// # Errors
    /// As [`ReferenceTable::shares_at`].
    pub fn at(&self, frequency: f64) -> Result<[Complex64; 3], Error> {
        let of_standard = match &self.standard {
            Some(standard) => standard.shares_at(frequency)?.common,
            None => [0.0; 2],
        };
        let noise = self
            .noise
            .map_or(0.0, |n| n.standard_uncertainty(frequency));
        Ok([
            Complex64::new(self.relative.hypot(of_standard[0]), 0.0),
            Complex64::new(0.0, of_standard[1]),
            Complex64::new(noise, 0.0),
        ])
    }

    /// Points with what the input has in common at all frequencies.
    ///
    /// # Errors
    /// As [`CommonInput::at`].
    pub fn on(&self, mut points: ResponsePoints) -> Result<ResponsePoints, Error> {
        let common = points.frequency.iter().map(|f| self.at(*f));
        let common = common.collect::<Result<Vec<_>, Error>>()?;
        for (part, (key, description)) in COMMON.into_iter().enumerate() {
            let relative: Vec<Complex64> = common.iter().map(|c| c[part]).collect();
            points = points.with_common(key, description, &relative)?;
        }
        Ok(points)
    }

    /// The sensitivity of one output along one axis with its covariance, from lines whose errors are independent; of more than
    /// `most` every n-th. `None` without lines.
    ///
    /// # Errors
    /// As [`CommonInput::at`]; a covariance that is none.
    pub fn frequency_response(
        &self,
        r: &ResponseEstimate,
        unit: &str,
        most: usize,
    ) -> Result<Option<FrequencyResponse>, Error> {
        let every = r.independent_every.max(1) * r.lines().div_ceil(most).max(1);
        let mut points = Vec::new();
        let mut shared = COMMON.map(|(key, _)| SharedEffect {
            key: key.into(),
            effects: Vec::new(),
        });
        for k in (0..r.lines()).step_by(every) {
            let (z, [rr, ri, ii]) = (r.value[k], r.covariance[k]);
            let components = vec![
                Component::new("K.re", unit.to_owned(), z.re),
                Component::new("K.im", unit.to_owned(), z.im),
            ];
            let mut influences = vec![Influence {
                key: "noise".into(),
                description: "noise of the recording, and the width of its lines".into(),
                evaluation: Evaluation::A,
                distribution: "normal".into(),
                dof: DegreesOfFreedom::new(r.dof[k]).unwrap_or(DegreesOfFreedom::INFINITE),
                effect: Effect::Joint {
                    covariance: Covariance::try_from_rows(2, &[rr, ri, ri, ii])?,
                },
            }];
            let common = self.at(r.frequency[k])?;
            for (i, (relative, (key, description))) in common.iter().zip(COMMON).enumerate() {
                let effect = relative * z;
                shared[i].effects.push(vec![effect.re, effect.im]);
                if effect.norm() > 0.0 {
                    influences.push(Influence::normal(
                        key,
                        description,
                        Effect::of_zero(
                            "1",
                            relative.norm(),
                            [effect.re, effect.im].map(|v| v / relative.norm()).to_vec(),
                        ),
                    ));
                }
            }
            points.push(SeriesPoint {
                at: r.frequency[k],
                estimate: Estimate::new(components, influences)?,
            });
        }
        if points.is_empty() {
            return Ok(None);
        }
        let shared = shared
            .into_iter()
            .filter(|s| s.effects.iter().any(|e| e.iter().any(|v| *v != 0.0)))
            .collect();
        let axis = vec!["axis".to_owned()];
        let series = EstimateSeries::new(points, Some(shared))?;
        FrequencyResponse::new(axis.clone(), axis, series).map(Some)
    }
}

/// The band that holds the sweep: where the input's density stays above a thousandth of its greatest.
pub fn driven_band(input: &[f64], rate: f64) -> [f64; 2] {
    let segment = (input.len() / 8).clamp(64, 4096);
    let Ok(density) = Welch::new(segment).density(input, rate) else {
        return [0.0, 0.5 * rate];
    };
    let greatest = density.density.iter().skip(1).copied().fold(0.0, f64::max);
    let inside: Vec<f64> = density
        .frequency
        .iter()
        .zip(&density.density)
        .skip(1)
        .filter(|(_, g)| **g > 1e-3 * greatest)
        .map(|(f, _)| *f)
        .collect();
    match (inside.first(), inside.last()) {
        (Some(low), Some(high)) => [*low, *high],
        _ => [0.0, 0.5 * rate],
    }
}

/// Lowest and highest frequency of a sweep from its first to its last cycles, Hz, whichever way it goes; `None` with less than eight
/// periods.
pub fn swept_band(input: &[f64], rate: f64) -> Option<[f64; 2]> {
    let passed = passed(input, rate)?;
    let low = passed.iter().copied().fold(f64::INFINITY, f64::min);
    Some([low, passed.iter().copied().fold(0.0, f64::max)])
}

/// Least and greatest frequency of an input that is a swept sine, Hz: from one period to the next it changes by less than a tenth, in
/// nine periods of ten, and over all of them by a half and more. Of white noise neighbouring periods differ by half of their length, of
/// narrow-band noise all are alike.
pub fn swept_over(input: &[f64], rate: f64) -> Option<[f64; 2]> {
    let periods = periods(input)?;
    let pairs = periods.windows(2);
    let steady = pairs.filter(|w| (w[1] / w[0] - 1.0).abs() < 0.1).count();
    let mut sorted = periods.clone();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| sorted[(share * (sorted.len() - 1) as f64) as usize];
    let (short, long) = (at(0.02), at(0.98));
    (10 * steady > 9 * (periods.len() - 1) && long > 1.5 * short)
        .then_some([rate / long, rate / short])
}

/// Frequencies of a sweep in their order, Hz: the median of so many periods. `None` with less than eight.
fn passed(input: &[f64], rate: f64) -> Option<Vec<f64>> {
    let periods = periods(input)?;
    let wide = (periods.len() / 100).clamp(3, 51);
    let medians = periods.windows(wide).map(|some| {
        let mut some = some.to_vec();
        let (_, middle, _) = some.select_nth_unstable_by(wide / 2, f64::total_cmp);
        rate / *middle
    });
    Some(medians.collect())
}

/// Periods between rising passages, in samples, those that noise would make left out by a band of a quarter of the largest values. `None`
/// with less than eight.
fn periods(input: &[f64]) -> Option<Vec<f64>> {
    let mean = input.iter().sum::<f64>() / input.len().max(1) as f64;
    let mut sizes: Vec<f64> = input.iter().map(|v| (v - mean).abs()).collect();
    let largest = sizes.len().checked_sub(1 + sizes.len() / 20)?;
    let (_, largest, _) = sizes.select_nth_unstable_by(largest, f64::total_cmp);
    let least = 0.25 * *largest;
    let (mut passages, mut below, mut crossed) = (Vec::new(), false, 0.0);
    for k in 1..input.len() {
        let (a, b) = (input[k - 1] - mean, input[k] - mean);
        below |= b < -least;
        if a < 0.0 && b >= 0.0 {
            crossed = (k - 1) as f64 + a / (a - b);
        }
        if below && b > least {
            passages.push(crossed);
            below = false;
        }
    }
    let periods: Vec<f64> = passages.windows(2).map(|w| w[1] - w[0]).collect();
    (periods.len() >= 8).then_some(periods)
}

/// The end of the record of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SweepEnd {
    /// Frequency of the first and of the last cycles, Hz.
    pub frequency: [f64; 2],
    /// Root mean square of input and output over the last two periods, over that of the whole record.
    pub level: [f64; 2],
}

impl SweepEnd {
    /// Of a record; `None` with less than eight periods.
    pub fn of(input: &[f64], output: &[f64], rate: f64) -> Option<Self> {
        let passed = passed(input, rate)?;
        let frequency = [*passed.first()?, *passed.last()?];
        let two = (2.0 * rate / frequency[1]).ceil().max(16.0) as usize;
        let rms = |values: &[f64]| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let squares = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
            (squares / values.len() as f64).sqrt()
        };
        let level = [input, output].map(|values| {
            let last = &values[values.len().saturating_sub(two)..];
            rms(last) / rms(values).max(f64::MIN_POSITIVE)
        });
        Some(Self { frequency, level })
    }

    /// Whether the input still drives, or the response still swings, when the record ends: by a tenth and a fifth of their levels.
    pub fn is_cut(&self) -> bool {
        self.level[0] > 0.1 || self.level[1] > 0.2
    }
}

/// A phase that rises with frequency, as if the output came before the input.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Lead {
    /// By how much the phase rises over the band, rad.
    pub rise: f64,
    /// Lowest and highest frequency looked at, Hz.
    pub band: [f64; 2],
    /// By how much the output seems early, s.
    pub time: f64,
    /// Its standard uncertainty, s.
    pub time_uncertainty: f64,
}

impl Lead {
    /// The output of a device comes after its input. Up to where the phase has turned by a quarter, it falls with frequency; where
    /// it rises by five standard uncertainties, the channels are swapped or not sampled together.
    pub fn of(response: &ResponseEstimate) -> Option<Self> {
        let step = response.independent_every.max(1);
        let lines: Vec<(f64, f64, f64)> = (0..response.lines())
            .step_by(step)
            .take_while(|k| response.value[*k].arg().abs() < std::f64::consts::FRAC_PI_2)
            .filter(|k| response.coherence.get(*k).is_none_or(|c| *c > 0.5))
            .map(|k| {
                let (_, u) = response.polar_uncertainty(k);
                (response.frequency[k], response.value[k].arg(), u)
            })
            .filter(|(.., u)| *u > 0.0 && u.is_finite())
            .collect();
        if lines.len() < 8 {
            return None;
        }
        let weight: f64 = lines.iter().map(|(.., u)| u.powi(-2)).sum();
        let mean = |of: fn(&(f64, f64, f64)) -> f64| -> f64 {
            lines.iter().map(|l| of(l) * l.2.powi(-2)).sum::<f64>() / weight
        };
        let (f0, p0) = (mean(|l| l.0), mean(|l| l.1));
        let spread: f64 = lines.iter().map(|(f, _, u)| ((f - f0) / u).powi(2)).sum();
        if !(spread > 0.0) {
            return None;
        }
        let slope = lines
            .iter()
            .map(|(f, p, u)| (f - f0) * (p - p0) / (u * u))
            .sum::<f64>()
            / spread;
        let rise = slope * (lines[lines.len() - 1].0 - lines[0].0);
        (slope * spread.sqrt() > 5.0 && rise > 0.02).then(|| Self {
            rise,
            band: [lines[0].0, lines[lines.len() - 1].0],
            time: slope / TAU,
            time_uncertainty: spread.powf(-0.5) / TAU,
        })
    }
}

/// The line whose leakage is the greatest share of its modulus, where that is more than 2 % and three times the noise: frequency in
/// Hz and share.
pub fn leaking(response: &ResponseEstimate) -> Option<(f64, f64)> {
    let (k, share) = (0..response.value.len())
        .map(|k| (k, response.leakage[k].norm() / response.value[k].norm()))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    let noise = (response.covariance[k][0] + response.covariance[k][2]
        - response.leakage[k].norm_sqr())
    .max(0.0)
    .sqrt();
    let told = share > 0.02 && response.leakage[k].norm() > 3.0 * noise;
    told.then(|| (response.frequency[k], share))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn known_sweeps_and_what_is_none() {
        let rate = 1000.0;
        for seed in 0..100 {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
            let white: Vec<f64> = (0..20_000).map(|_| normal()).collect();
            // Poles of Q = 20 at 100 Hz.
            let (mut y1, mut y2) = (0.0, 0.0);
            let narrow = white.iter().map(|x| {
                let step = TAU * 0.1;
                let radius = (-0.025 * step).exp();
                (y1, y2) = (
                    2.0 * radius * step.cos() * y1 - radius * radius * y2 + x,
                    y1,
                );
                y1
            });
            let narrow: Vec<f64> = narrow.collect();
            let sines = |second: f64| -> Vec<f64> {
                let at = |k: usize| TAU * k as f64 / rate;
                let noise = white.iter().enumerate();
                noise
                    .map(|(k, n)| (50.0 * at(k)).sin() + second * (137.0 * at(k)).sin() + 0.02 * n)
                    .collect()
            };
            for record in [&white, &narrow, &sines(0.0), &sines(0.8)] {
                assert_eq!(swept_over(record, rate), None, "{seed}");
            }
            let mut phase = 0.0;
            let swept = white.iter().enumerate().map(|(k, n)| {
                phase += TAU * 5.0 * 40f64.powf(k as f64 / 2e4) / rate;
                phase.sin() + 0.05 * n
            });
            let swept: Vec<f64> = swept.collect();
            let [low, high] = swept_over(&swept, rate).unwrap();
            assert!(
                low > 4.5 && low < 20.0 && high > 150.0 && high < 210.0,
                "{low} {high}"
            );
        }
    }
}
