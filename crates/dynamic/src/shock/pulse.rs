//! Finding a pulse in a record, and what is read from it.

use super::quiet::Quiet;
use proofmass_core::numeric::upper_median;
use proofmass_core::{Error, Watch};
use proofmass_signal::{Extremes, Peaks, PulseShape, ShockSpectrum};
use serde::{Deserialize, Serialize};

/// Share of the peak between whose passages the duration of a pulse is taken.
pub(crate) const LEVEL: f64 = 0.1;

/// How a pulse is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct PulseSearch {
    /// Share of the peak between whose passages the duration is taken.
    pub level: f64,
    /// Least peak, in multiples of the noise.
    pub least_ratio: f64,
    /// Share of the main peak from which another excursion to the same side is a pulse of its own.
    pub another: f64,
}

impl Default for PulseSearch {
    fn default() -> Self {
        Self {
            level: LEVEL,
            least_ratio: 8.0,
            another: 0.25,
        }
    }
}

/// Where the pulse of a record lies.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Pulse {
    /// +1 or −1: the side to which it goes.
    pub sign: f64,
    /// Sample of the greatest value.
    pub(crate) top: usize,
    /// First passage through the level, in samples; `None` when the record begins within the pulse.
    pub start: Option<f64>,
    /// Last passage through the level, in samples; `None` when the record ends within the pulse.
    pub end: Option<f64>,
    /// Samples before the pulse that are quiet.
    pub quiet: usize,
    /// Level the pulse stands on.
    pub baseline: f64,
    /// Standard deviation of the quiet samples, or of what is not the pulse where there are too few.
    pub noise: f64,
    /// Samples of the peaks of other pulses.
    pub(crate) others: Vec<usize>,
}

/// Why there is no pulse: the numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct NoPulse {
    /// Largest excursion from the median.
    pub largest: f64,
    /// Spread of the record, as the standard deviation of normal noise with the same median deviation.
    pub noise: f64,
    /// Least ratio that was asked for.
    pub least_ratio: f64,
}

impl PulseSearch {
    /// The greatest pulse of a record, or why there is none.
    ///
    /// # Errors
    /// [`Error::TooFew`] below 16 samples, [`Error::NotFinite`], [`Error::Constant`].
    pub fn find(&self, record: &[f64]) -> Result<Result<Pulse, NoPulse>, Error> {
        let n = record.len();
        if n < Quiet::SHORTEST {
            return Err(Error::TooFew {
                name: "samples",
                needed: Quiet::SHORTEST,
                got: n,
            });
        }
        proofmass_core::check::finite("record", record)?;
        if record.iter().all(|v| *v == record[0]) {
            return Err(Error::Constant {
                name: "record",
                value: record[0],
            });
        }
        let mut sorted = record.to_vec();
        let middle = upper_median(&mut sorted).unwrap_or(0.0);
        let mut deviations: Vec<f64> = record.iter().map(|v| (v - middle).abs()).collect();
        let spread = 1.4826 * upper_median(&mut deviations).unwrap_or(0.0);
        let first = self.around(record, middle);
        // The median leans towards a pulse that fills much of the record: the quiet before it knows better.
        let baseline = match first.quiet {
            q if q >= Quiet::SHORTEST => record[..q].iter().sum::<f64>() / q as f64,
            _ => middle,
        };
        let mut pulse = self.around(record, baseline);
        let peak = (record[pulse.top] - baseline).abs();
        let quiet = &record[..pulse.quiet];
        pulse.noise = if quiet.len() >= Quiet::SHORTEST {
            let squares: f64 = quiet.iter().map(|v| (v - baseline).powi(2)).sum();
            (squares / (quiet.len() - 1) as f64).sqrt()
        } else {
            spread
        };
        // Against both: the quiet may be a lull of what is no shock, and the spread of a record that is nearly all
        // pulse is the pulse's.
        let filled = pulse.end.unwrap_or(n as f64) - pulse.start.unwrap_or(0.0) > 0.4 * n as f64;
        let noise = if filled {
            pulse.noise
        } else {
            spread.max(pulse.noise)
        };
        if !(peak > self.least_ratio * noise) {
            return Ok(Err(NoPulse {
                largest: peak,
                noise,
                least_ratio: self.least_ratio,
            }));
        }
        Ok(Ok(pulse))
    }

    fn around(&self, record: &[f64], baseline: f64) -> Pulse {
        let height = |k: usize| record[k] - baseline;
        let top = (0..record.len())
            .max_by(|a, b| height(*a).abs().total_cmp(&height(*b).abs()))
            .unwrap_or(0);
        let sign = height(top).signum();
        let level = self.level * height(top).abs();
        let up = |k: usize| sign * height(k) >= level;
        let cross = |low: usize, high: usize| {
            let (a, b) = (sign * height(low), sign * height(high));
            low as f64 + (level - a) / (b - a) * (high as f64 - low as f64)
        };
        let before = (0..top).rev().find(|k| !up(*k));
        let after = (top + 1..record.len()).find(|k| !up(*k));
        let start = before.map(|k| cross(k, k + 1));
        let end = after.map(|k| cross(k, k - 1));
        let duration = end.unwrap_or(record.len() as f64) - start.unwrap_or(0.0);
        // A half-sine takes 3 % of its 10 % duration below the level; a haversine 13 %.
        let quiet = start.map_or(0, |s| (s - 0.5 * duration).max(0.0) as usize);
        let mut pulse = Pulse {
            sign,
            top,
            start,
            end,
            quiet,
            baseline,
            noise: 0.0,
            others: Vec::new(),
        };
        pulse.others = self.others(record, &pulse);
        pulse
    }

    /// Peaks of other excursions to the same side with a fifth of the area: ringing swings to both sides and has none.
    fn others(&self, record: &[f64], pulse: &Pulse) -> Vec<usize> {
        let height = |k: usize| pulse.sign * (record[k] - pulse.baseline);
        let area = |from: usize, to: usize| (from..to).map(height).sum::<f64>();
        let from = pulse.start.map_or(0, |s| s as usize + 1);
        let to = pulse.end.map_or(record.len(), |e| e as usize + 1);
        let main = area(from, to);
        let level = self.another * height(pulse.top);
        let mut found = Vec::new();
        let mut k = 0;
        while k < record.len() {
            if height(k) < level || (from..to).contains(&k) {
                k += 1;
                continue;
            }
            let start = k;
            while k < record.len() && height(k) >= level {
                k += 1;
            }
            if area(start, k) >= 0.2 * main
                && let Some(top) = (start..k).max_by(|a, b| height(*a).total_cmp(&height(*b)))
            {
                found.push(top);
            }
        }
        found
    }
}

/// What is read from one pulse. **Source** `[ISO16063-22]`, `[IEC60068-2-27]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PulseMeasures {
    /// Greatest value above the baseline, by a polynomial through the top, with the sign of the pulse; unit of the record.
    pub peak: f64,
    /// Its standard uncertainty from the noise; `None` without a quiet stretch.
    pub peak_uncertainty: Option<f64>,
    /// Its instant, s from the first sample.
    pub peak_time: f64,
    /// Between the passages through a tenth of the peak, s.
    pub duration: Option<f64>,
    /// From a tenth to nine tenths of the peak, s.
    pub rise_time: Option<f64>,
    /// Integral over the pulse, between the passages through the baseline, unit × s.
    pub velocity_change: Option<f64>,
    /// Greatest excursion to the other side within five durations after the pulse, as a share of the peak.
    pub overshoot: Option<f64>,
    /// Mean after the pulse less mean before, unit of the record: value and standard uncertainty.
    pub zero_shift: Option<(f64, f64)>,
    /// Amplitude of an oscillation that remains after the pulse, as a share of the peak, and its frequency in Hz.
    pub ringing: Option<(f64, f64)>,
    /// Samples within the pulse.
    pub samples: usize,
}

/// A linear reading of samples from `first` on.
pub(crate) struct Functional {
    pub(crate) first: usize,
    pub(crate) weights: Vec<f64>,
}

impl Functional {
    pub(crate) fn read(&self, record: &[f64], baseline: f64) -> f64 {
        self.weights
            .iter()
            .zip(&record[self.first..])
            .map(|(w, v)| w * (v - baseline))
            .sum()
    }

    /// What it reads of a level of one.
    pub(crate) fn sum(&self) -> f64 {
        self.weights.iter().sum()
    }
}

impl Pulse {
    /// Its length in samples; a quarter of the record where an end is not seen.
    pub fn duration_in(&self, samples: usize) -> f64 {
        self.start
            .zip(self.end)
            .map_or(samples as f64 / 4.0, |(s, e)| e - s)
    }

    /// Interval of samples over which the pulse is integrated: out to the baseline, at most half a duration beyond the level.
    pub(super) fn whole(&self, record: &[f64]) -> Option<(usize, usize)> {
        let (start, end) = (self.start?, self.end?);
        let reach = 0.5 * (end - start);
        let up = |k: usize| self.sign * (record[k] - self.baseline) > 0.0;
        let least = (start - reach).max(0.0) as usize;
        let most = ((end + reach) as usize).min(record.len() - 1);
        let from = (least..=start as usize)
            .rev()
            .find(|k| !up(*k))
            .unwrap_or(least);
        let to = (end as usize + 1..=most).find(|k| !up(*k)).unwrap_or(most);
        Some((from, to))
    }

    /// The reading of the greatest value: least squares of a polynomial (fourth degree, second where samples are few)
    /// through all neighbours of the top above nine tenths of it, read where the polynomial is greatest.
    pub(super) fn peak_functional(&self, record: &[f64]) -> (Functional, f64) {
        let height = |k: usize| self.sign * (record[k] - self.baseline);
        let level = 0.9 * height(self.top);
        let first = (0..=self.top)
            .rev()
            .find(|k| height(*k) < level)
            .map_or(0, |k| k + 1);
        let last = (self.top..record.len())
            .find(|k| height(*k) < level)
            .map_or(record.len() - 1, |k| k - 1);
        let n = last - first + 1;
        let degree = match n {
            0..=3 => {
                let single = Functional {
                    first: self.top,
                    weights: vec![1.0],
                };
                return (single, self.top as f64);
            }
            4..=9 => 2,
            _ => 4,
        };
        let half = 0.5 * (n - 1) as f64;
        let s = |k: usize| (k as f64 - half) / half;
        let basis = |x: f64| (0..=degree).map(move |d| x.powi(d));
        let size = degree as usize + 1;
        let mut normal = vec![0.0; size * size];
        for k in 0..n {
            let row: Vec<f64> = basis(s(k)).collect();
            for a in 0..size {
                for b in 0..size {
                    normal[a * size + b] += row[a] * row[b];
                }
            }
        }
        let mut right = vec![0.0; size];
        for k in 0..n {
            for (r, p) in right.iter_mut().zip(basis(s(k))) {
                *r += p * height(first + k);
            }
        }
        let single = (
            Functional {
                first: self.top,
                weights: vec![1.0],
            },
            self.top as f64,
        );
        if proofmass_uncertainty::adjustment::cholesky(&mut normal, size).is_none() {
            return single;
        }
        proofmass_uncertainty::adjustment::solve(&normal, &mut right);
        let value = |x: f64| basis(x).zip(&right).map(|(p, c)| p * c).sum::<f64>();
        // The greatest value of a quartic on a fine grid: an error of 1/400 in its place is second order in its value.
        let at = (0..=800)
            .map(|k| -1.0 + 2.0 * f64::from(k) / 800.0)
            .max_by(|a, b| value(*a).total_cmp(&value(*b)))
            .unwrap_or(0.0);
        let mut reading: Vec<f64> = basis(at).collect();
        proofmass_uncertainty::adjustment::solve(&normal, &mut reading);
        let weights = (0..n)
            .map(|k| basis(s(k)).zip(&reading).map(|(p, c)| p * c).sum())
            .collect();
        (
            Functional { first, weights },
            first as f64 + half * (1.0 + at),
        )
    }

    /// The reading of the integral over an interval of samples, in sample steps, by the trapezoidal rule.
    pub(super) fn integral_functional((from, to): (usize, usize)) -> Functional {
        let n = to - from + 1;
        let weights = (0..n)
            .map(|k| if k == 0 || k + 1 == n { 0.5 } else { 1.0 })
            .collect();
        Functional {
            first: from,
            weights,
        }
    }

    /// Everything that is read from the pulse.
    pub fn measure(&self, record: &[f64], rate: f64) -> PulseMeasures {
        let quiet = Quiet::new(&[&record[..self.quiet]]);
        let (reading, at) = self.peak_functional(record);
        let peak = reading.read(record, self.baseline);
        let height = |k: usize| self.sign * (record[k] - self.baseline);
        let duration = self.start.zip(self.end).map(|(s, e)| e - s);
        let integral = self
            .whole(record)
            .map(|range| Self::integral_functional(range).read(record, self.baseline) / rate);
        let rise = self.start.and_then(|start| {
            let level = 0.9 * height(self.top);
            let k = (start as usize + 1..=self.top).find(|k| height(*k) >= level)?;
            let (a, b) = (height(k - 1), height(k));
            let share = if b > a { (level - a) / (b - a) } else { 0.0 };
            Some((k as f64 - 1.0 + share - start) / rate)
        });
        let u_of = |f: &Functional| {
            let q = quiet.as_ref()?;
            Some(
                q.covariance(std::slice::from_ref(&f.weights)).covariance[0]
                    .max(0.0)
                    .sqrt(),
            )
        };
        PulseMeasures {
            peak,
            peak_uncertainty: u_of(&reading),
            peak_time: at / rate,
            duration: duration.map(|d| d / rate),
            rise_time: rise,
            velocity_change: integral,
            overshoot: self.overshoot(record),
            zero_shift: self.zero_shift(record, quiet.as_ref()),
            ringing: self.ringing(record, rate),
            samples: duration.map_or(0, |d| d as usize + 1),
        }
    }

    fn overshoot(&self, record: &[f64]) -> Option<f64> {
        let (start, end) = (self.start?, self.end?);
        let from = end as usize + 1;
        let to = ((end + 5.0 * (end - start)) as usize + 1).min(record.len());
        let least = record
            .get(from..to)?
            .iter()
            .map(|v| self.sign * (v - self.baseline))
            .fold(0.0, f64::min);
        Some(-least / (self.sign * (record[self.top] - self.baseline)))
    }

    /// Stretch after the pulse over which nothing more should happen: from five durations after it on.
    fn aftermath(&self, record: &[f64]) -> Option<(usize, usize)> {
        let (start, end) = (self.start?, self.end?);
        let duration = end - start;
        let from = (end + 5.0 * duration) as usize;
        let others = self.others.iter().filter(|k| **k > self.top).min();
        let stop = others.map_or(record.len(), |k| {
            (*k as f64 - 2.0 * duration).max(0.0) as usize
        });
        let stop = stop.min(record.len());
        (stop > from + Quiet::SHORTEST && (stop - from) as f64 >= duration).then_some((from, stop))
    }

    fn zero_shift(&self, record: &[f64], quiet: Option<&Quiet>) -> Option<(f64, f64)> {
        let (from, stop) = self.aftermath(record)?;
        let quiet = quiet?;
        // Whole windows of the quiet stretch must tell how much such a mean wanders: no longer than a sixth of it.
        let n = (stop - from).min((quiet.len() / 6).max(Quiet::SHORTEST));
        // The last one: what decays after the pulse is no shift.
        let last = &record[stop - n..stop];
        let weights = vec![vec![1.0 / n as f64; n]];
        let noise = quiet.covariance(&weights).covariance[0].max(0.0);
        let left = still_to_come(&record[from..stop], 4.0 * noise.sqrt());
        Some((mean(last) - self.baseline, noise.sqrt().hypot(left)))
    }

    /// Oscillation just after the pulse: the strongest line of five durations, freed from a parabola, where it has most of
    /// what is not noise.
    fn ringing(&self, record: &[f64], rate: f64) -> Option<(f64, f64)> {
        let (start, end) = (self.start?, self.end?);
        let duration = end - start;
        let from = (end + 0.3 * duration) as usize + 1;
        let stop = ((end + 4.0 * duration) as usize).min(record.len());
        if stop < from + 24 {
            return None;
        }
        let mut part = record[from..stop].to_vec();
        proofmass_signal::Detrend::Quadratic
            .remove(&mut part, rate)
            .ok()?;
        let n = part.len();
        let power: f64 = part.iter().map(|v| v * v).sum::<f64>() / n as f64;
        let spectrum = proofmass_signal::fourier::forward(&part);
        let strongest = (1..spectrum.len())
            .max_by(|a, b| spectrum[*a].norm_sqr().total_cmp(&spectrum[*b].norm_sqr()))?;
        let near = strongest.saturating_sub(2).max(1)..(strongest + 3).min(spectrum.len());
        let line: f64 = near.map(|k| 2.0 * spectrum[k].norm_sqr()).sum::<f64>() / (n * n) as f64;
        // A line that holds most of the power, well above the noise, is an oscillation and not the pulse's own tail.
        if line < 0.5 * power || line < 16.0 * self.noise * self.noise {
            return None;
        }
        let peak = (record[self.top] - self.baseline).abs();
        // It decays: its greatest swing counts, not its mean power.
        let swing = part.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        Some((swing / peak, strongest as f64 * rate / n as f64))
    }
}

fn mean(part: &[f64]) -> f64 {
    part.iter().sum::<f64>() / part.len().max(1) as f64
}

/// How far a decay has still to go: from the last third to where the means of three equal parts lead, which follow a geometric course where
/// it is exponential; zero where they differ by less than what is seen.
fn still_to_come(stretch: &[f64], seen: f64) -> f64 {
    let third = stretch.len() / 3;
    let [first, second, last] = [0, 1, 2].map(|k| mean(&stretch[k * third..(k + 1) * third]));
    let (before, now) = (second - first, last - second);
    if third == 0 || (last - first).abs() <= seen {
        return 0.0;
    }
    match now / before {
        q if q > 0.0 && q < 1.0 => (now * q / (1.0 - q)).abs().max(now.abs()),
        // It does not come to rest within the record.
        _ => (last - first).abs().max(now.abs()),
    }
}

/// A nominal pulse and how far a measured one may depart from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct Tolerance {
    /// Shape.
    pub shape: PulseShape,
    /// Nominal peak, unit of the record.
    pub peak: f64,
    /// Nominal duration, s.
    pub duration: f64,
    /// Half-width of the band as a share of the nominal peak: 0.2 in IEC 60068-2-27.
    pub band: f64,
    /// Greatest departure of the velocity change as a share: 0.15 there.
    pub velocity: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self {
            shape: PulseShape::HalfSine,
            peak: 0.0,
            duration: 0.0,
            band: 0.2,
            velocity: 0.15,
        }
    }
}

/// Whether a pulse keeps its tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ToleranceResult {
    /// What was asked.
    pub tolerance: Tolerance,
    /// Instant at which the nominal pulse begins, laid where it fits best, s.
    pub nominal_start: f64,
    /// Largest departure from the nominal pulse, as a share of its peak.
    pub largest_departure: f64,
    /// Measured velocity change over the nominal one, less one.
    pub velocity_departure: Option<f64>,
    /// Both within.
    pub kept: bool,
}

impl Tolerance {
    /// Greatest absolute accelerations of oscillators that the nominal pulse drives, with a duration of rest to either side, sampled
    /// as the record or finer.
    ///
    /// # Errors
    /// As [`ShockSpectrum::evaluate_watched`].
    pub fn spectrum(
        &self,
        frequencies: &[f64],
        quality: f64,
        peaks: Peaks,
        rate: f64,
        watch: &dyn Watch,
    ) -> Result<Vec<f64>, Error> {
        let fine = rate.max(400.0 / self.duration);
        let samples = (3.0 * self.duration * fine) as usize;
        let pulse = self
            .shape
            .record(self.peak, self.duration, self.duration, samples, fine);
        let spectrum = ShockSpectrum {
            peaks,
            ..ShockSpectrum::new(frequencies.to_vec(), quality)
        };
        Ok(spectrum
            .evaluate_watched(&pulse, fine, watch)?
            .curve(Extremes::maximax))
    }

    /// Lays the nominal pulse where its largest departure is least, from 0.4 of its duration before to one after.
    pub fn judge(
        &self,
        pulse: &Pulse,
        record: &[f64],
        rate: f64,
        velocity: Option<f64>,
    ) -> Option<ToleranceResult> {
        if !(self.peak > 0.0 && self.duration > 0.0 && self.duration.is_finite()) {
            return None;
        }
        let (start, end) = (pulse.start? / rate, pulse.end? / rate);
        let centre = 0.5 * (start + end) - 0.5 * self.duration;
        let near = |begin: f64| {
            let from = ((begin - 0.4 * self.duration) * rate).max(0.0) as usize;
            let to = (((begin + 2.0 * self.duration) * rate) as usize).min(record.len());
            (from..to)
                .map(|k| {
                    // A flank without width is nowhere exactly: the nominal pulse counts as wide as two hundredths of its
                    // duration, or a sample, to either side.
                    let slack = (0.02 * self.duration).max(1.0 / rate);
                    let t = k as f64 / rate - begin;
                    let at = |t: f64| self.peak * self.shape.at(t / self.duration);
                    let three = [at(t - slack), at(t), at(t + slack)];
                    let low = three.into_iter().fold(f64::INFINITY, f64::min);
                    let high = three.into_iter().fold(0.0, f64::max);
                    let v = pulse.sign * (record[k] - pulse.baseline);
                    (low - v).max(v - high).max(0.0)
                })
                .fold(0.0, f64::max)
                / self.peak
        };
        let (nominal_start, largest) = (-60..=60)
            .map(|k| centre + 0.005 * f64::from(k) * self.duration)
            .map(|begin| (begin, near(begin)))
            .min_by(|a, b| a.1.total_cmp(&b.1))?;
        let nominal_velocity = self.shape.area() * self.peak * self.duration;
        let velocity_departure = velocity.map(|v| v.abs() / nominal_velocity - 1.0);
        Some(ToleranceResult {
            tolerance: *self,
            nominal_start,
            largest_departure: largest,
            velocity_departure,
            kept: largest <= self.band
                && velocity_departure.is_none_or(|d| d.abs() <= self.velocity),
        })
    }
}
