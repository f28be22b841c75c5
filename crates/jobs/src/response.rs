//! Frequency response of a device from recorded input and output: random, impact, sweep, steps.

mod hits;
mod model;
mod outcome;
mod page;
mod points;
mod recordings;
mod steps;
#[cfg(test)]
mod tests;

pub use model::{ModelData, ModelJob};
pub use outcome::{ResponseOutcome, ResponsePower};
pub use points::{PointColumns, RecordedPoints};
pub use recordings::ResponseRecordings;

use crate::channels::Channel;
use crate::outcome::Job;
use crate::trouble::{Result, Trouble};
use num_complex::Complex64;
use proofmass_core::Watch;
use proofmass_dynamic::model::{
    FitProblem, ModelFit, ModelStructure, ResponseFigures, ResponsePoints,
};
use proofmass_dynamic::modes::resonances;
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_signal::transfer::{
    CrossSpectra, Estimator, Hit, LocalPolynomial, ResponseEstimate, turned,
};
use proofmass_signal::{Welch, Window};
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};

/// What drives the device.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Excitation {
    /// Noise that goes on.
    Random,
    /// Blows of a hammer, one or several to a recording.
    Impact,
    /// A swept sine.
    Sweep,
    /// A sine that stays at one frequency after the other, in one recording or in several.
    Steps,
    /// Not recorded here: points of a response, one by one, as of stepped sines.
    Points,
}

/// What is asked of recorded input and output.
///
/// ```
/// use proofmass_jobs::response::{Excitation, ResponseData, ResponseJob};
/// use proofmass_jobs::{Channel, Job, Unwatched};
/// use rand::{RngExt, SeedableRng};
///
/// let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(1);
/// let x: Vec<f64> = (0..40_000).map(|_| rng.random::<f64>() - 0.5).collect();
/// let y: Vec<f64> = x.iter().map(|x| 2.0 * x + 0.1 * (rng.random::<f64>() - 0.5)).collect();
/// let channel = |name, data| Channel { name, unit: "m/s²", data };
/// let data = ResponseData {
///     recordings: vec![[channel("in", &x), channel("out", &y)]],
///     rate: 1000.0,
///     findings: &[],
///     name: "noise",
/// };
/// let outcome = ResponseJob::new(Excitation::Random).evaluate(&data, &Unwatched)?;
/// let response = outcome.response();
/// // One of the two thousand lines is known to 0.02, their mean to 0.0005.
/// let mean = response.value.iter().map(|h| h.norm()).sum::<f64>() / response.value.len() as f64;
/// assert!((mean - 2.0).abs() < 2e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ResponseJob {
    /// What drives the device.
    pub excitation: Excitation,
    /// Where the noise is.
    #[serde(default)]
    pub estimator: Estimator,
    /// Samples per segment (random), of a hit (impact); chosen by the record when `None`.
    #[serde(default)]
    pub segment: Option<usize>,
    /// Lowest and highest frequency given, Hz.
    #[serde(default)]
    pub band: Option<[f64; 2]>,
    /// Samples around a blow's greatest force that are kept of the force; all when `None`.
    #[serde(default)]
    pub force_window: Option<usize>,
    /// Model to fit.
    #[serde(default)]
    pub model: Option<ModelStructure>,
    /// Frequency to which departures refer, Hz.
    #[serde(default)]
    pub reference_frequency: Option<f64>,
    /// Relative standard uncertainty of the input, common to all frequencies.
    #[serde(default)]
    pub input_uncertainty: f64,
    /// Calibration over frequency of the transducer at the input, whose channel is then in volts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard: Option<ReferenceTable>,
}

/// Recordings with one input and one output each.
#[derive(Clone, Debug)]
pub struct ResponseData<'a> {
    /// Input and output; several recordings for blows, else one.
    pub recordings: Vec<[Channel<'a>; 2]>,
    /// Samples per second.
    pub rate: f64,
    /// What reading the data found.
    pub findings: &'a [Finding],
    /// What the recordings are called in messages.
    pub name: &'a str,
}

/// Causes of an error of the input that all frequencies have in common: keys and what they are.
const COMMON: [(&str, &str); 2] = [
    (
        "reference.modulus",
        "relative error of the input that its frequencies have in common",
    ),
    (
        "reference.phase",
        "phase of the input that its frequencies have in common",
    ),
];

impl ResponseJob {
    /// This excitation, everything else by its default: H₁, all frequencies, no model.
    pub fn new(excitation: Excitation) -> Self {
        Self {
            excitation,
            estimator: Estimator::H1,
            segment: None,
            band: None,
            force_window: None,
            model: None,
            reference_frequency: None,
            input_uncertainty: 0.0,
            standard: None,
        }
    }

    /// Relative errors of the response that all its frequencies have in common, at one of them: a cause for the modulus, one for
    /// the phase.
    fn common(&self, frequency: f64) -> Result<[Complex64; 2]> {
        let of_standard = match &self.standard {
            Some(standard) => standard.shares_at(frequency)?.common,
            None => [0.0; 2],
        };
        Ok([
            Complex64::new(self.input_uncertainty.hypot(of_standard[0]), 0.0),
            Complex64::new(0.0, of_standard[1]),
        ])
    }

    /// The response to the acceleration behind the volts of the standard, as far as its calibration reaches.
    fn by_standard(
        &self,
        response: ResponseEstimate,
        power: &mut Option<ResponsePower>,
        name: &str,
        findings: &mut Vec<Finding>,
    ) -> Result<ResponseEstimate> {
        let Some(standard) = &self.standard else {
            return Ok(response);
        };
        let [first, last] = standard.range();
        let [low, high] = standard.reach();
        let mut kept = response.within(low, high);
        let lost = response.lines() - kept.lines();
        if kept.lines() == 0 {
            return Err(
                Trouble::data("the calibration of the input reaches no line")
                    .detail(name)
                    .detail(format!("it covers {first} Hz to {last} Hz"))
                    .with_hint("have the transducer at the input calibrated there"),
            );
        }
        if lost > 0 {
            findings.push(
                Finding::new(
                    Severity::Note,
                    "reference-out-of-range",
                    "the calibration of the input does not reach all lines",
                )
                .evidence(format!(
                    "{lost} lines of {} were left out; it covers {first} Hz to {last} Hz",
                    response.lines()
                ))
                .advice("have the transducer at the input calibrated there, or state the band"),
            );
        }
        for k in 0..kept.lines() {
            let point = standard.at(kept.frequency[k])?;
            let s = Complex64::from_polar(point.sensitivity, point.phase);
            kept.value[k] *= s;
            kept.covariance[k] = turned(kept.covariance[k], s);
            // What its calibration has of this frequency alone, beside the noise.
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
        if let Some(power) = power {
            power.seen_by(standard)?;
        }
        Ok(kept)
    }

    /// With what the input has in common at all frequencies.
    fn with_reference(&self, mut points: ResponsePoints) -> Result<ResponsePoints> {
        let common = points.frequency.iter().map(|f| self.common(*f));
        let common = common.collect::<Result<Vec<_>>>()?;
        for (part, (key, description)) in COMMON.into_iter().enumerate() {
            let relative: Vec<Complex64> = common.iter().map(|c| c[part]).collect();
            points = points.with_common(key, description, &relative)?;
        }
        Ok(points)
    }

    fn estimate(
        &self,
        data: &ResponseData<'_>,
        watch: &dyn Watch,
        findings: &mut Vec<Finding>,
    ) -> Result<(ResponseEstimate, Option<CrossSpectra>)> {
        let rate = data.rate;
        let band = self.band.unwrap_or([0.0, 0.5 * rate]);
        let one = || match data.recordings.as_slice() {
            [one] => Ok(one),
            more => Err(Trouble::request(format!(
                "{} recordings were given: noise and sweeps are evaluated one by one",
                more.len()
            ))),
        };
        let named = |e: proofmass_core::Error| Trouble::from(e).detail(data.name);
        match self.excitation {
            Excitation::Random => {
                let [x, y] = one()?;
                // Some thirty segments of a short record, lines no finer than needed of a long one.
                let segment = self
                    .segment
                    .unwrap_or_else(|| (x.data.len() / 16).next_power_of_two().clamp(64, 8192));
                let welch = Welch {
                    window: Window::Hann,
                    ..Welch::new(segment)
                };
                let spectra =
                    CrossSpectra::welch(x.data, &[y.data], rate, &welch, watch).map_err(named)?;
                let response = spectra.response(0, self.estimator).map_err(named)?;
                // A mean removed from each segment takes the two lowest lines with it.
                let lowest = 2.0 * rate / segment as f64;
                Ok((response.within(band[0].max(lowest), band[1]), Some(spectra)))
            }
            Excitation::Impact => {
                let hits = hits::find(data, self.segment, findings)?;
                let outputs: Vec<[&[f64]; 1]> = hits.pieces.iter().map(|h| [h.1]).collect();
                let pieces: Vec<Hit<'_>> = hits
                    .pieces
                    .iter()
                    .zip(&outputs)
                    .map(|((input, _), outputs)| Hit { input, outputs })
                    .collect();
                let spectra =
                    CrossSpectra::hits(&pieces, rate, hits.length, self.force_window, None)
                        .map_err(named)?;
                let response = spectra.response(0, self.estimator).map_err(named)?;
                let lowest = rate / hits.length as f64;
                Ok((response.within(band[0].max(lowest), band[1]), Some(spectra)))
            }
            Excitation::Steps => Ok((steps::response(data, self.band, findings)?, None)),
            Excitation::Points => Err(Trouble::request("points of a response are no recording")
                .with_hint("fit a model to them with `proofmass test model`")),
            Excitation::Sweep => {
                let [x, y] = one()?;
                let mut method = LocalPolynomial::default();
                method.band = self.band.unwrap_or_else(|| driven(x.data, rate));
                if let Some(wide) = self.segment {
                    method.half_width = wide / 2;
                }
                let response = method
                    .estimate(x.data, y.data, rate, watch)
                    .map_err(named)?;
                Ok((response, None))
            }
        }
    }
}

/// The band that holds the sweep: where the input's density stays above a thousandth of its greatest.
fn driven(input: &[f64], rate: f64) -> [f64; 2] {
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

impl Job for ResponseJob {
    type Data<'a> = ResponseData<'a>;
    type Outcome = ResponseOutcome;

    fn evaluate(&self, data: &ResponseData<'_>, watch: &dyn Watch) -> Result<ResponseOutcome> {
        watch.step("response", 0, 2)?;
        let Some([x, y]) = data.recordings.first() else {
            return Err(Trouble::request("no recording was given"));
        };
        let mut findings = data.findings.to_vec();
        for [x, y] in &data.recordings {
            for c in [x, y] {
                saturation(c, &mut findings);
            }
        }
        let (response, spectra) = self.estimate(data, watch, &mut findings)?;
        let input_unit = match &self.standard {
            Some(_) if x.unit != "V" => {
                return Err(Trouble::data(format!(
                    "the input {:?} is in {}: a calibrated transducer at the input gives volts",
                    x.name, x.unit
                ))
                .detail(data.name)
                .with_hint("state its unit (--input-unit V), or leave --standard out"));
            }
            Some(_) => "m/s²",
            None => x.unit,
        };
        let mut power = spectra.as_ref().map(|s| {
            let low = response.frequency.first().copied().unwrap_or(0.0);
            let high = response.frequency.last().copied().unwrap_or(0.0);
            ResponsePower::of(s, low, high)
        });
        let response = self.by_standard(response, &mut power, data.name, &mut findings)?;
        if response.value.is_empty() {
            return Err(Trouble::data("no line lies within the band")
                .detail(data.name)
                .with_hint("widen --band, or give longer segments"));
        }
        watch.step("response", 1, 2)?;
        quality(&response, &mut findings);
        if input_unit == y.unit {
            order(&response, &mut findings);
        }
        if self.standard.is_none() && x.unit == "V" && y.unit == "m/s²" {
            findings.push(
                Finding::new(
                    Severity::Note,
                    "input-in-volts",
                    "the input is a voltage and the output an acceleration",
                )
                .evidence(format!("{} in V, {} in m/s²", x.name, y.name))
                .advice("of an exciter that is so; of a device the two columns may be swapped, or --standard tells the acceleration behind the volts"),
            );
        }
        let unit = match (y.unit, input_unit) {
            (a, b) if a == b => "1".to_owned(),
            (a, b) if b.contains('/') => format!("{a}/({b})"),
            (a, b) => format!("{a}/{b}"),
        };
        let fit: Option<ModelFit> = match self.model {
            Some(structure) => {
                let points = ResponsePoints::of(&response, &unit);
                let seen = match &spectra {
                    Some(spectra) => {
                        points.seen_through(&response, spectra.smearing(self.estimator))
                    }
                    None => points,
                };
                let seen = self.with_reference(seen)?;
                let fit = FitProblem::new(structure)
                    .fit(&seen)
                    .map_err(|e| Trouble::from(e).about("the model").detail(data.name))?;
                findings.extend(fit.findings.iter().cloned());
                Some(fit)
            }
            None => None,
        };
        let points = self.with_reference(ResponsePoints::of(&response, &unit))?;
        let fitted = fit.as_ref().and_then(|f| {
            let q = f.estimate.get("mode.1.damping")?;
            Some((q.value, q.standard_uncertainty))
        });
        let figures = ResponseFigures::of(&points, self.reference_frequency, fitted);
        if let Some(figures) = &figures {
            findings.extend(figures.findings.iter().cloned());
        }
        let low = response.frequency.first().copied().unwrap_or(0.0);
        let high = response.frequency.last().copied().unwrap_or(0.0);
        let modes = resonances(&response, low, high);
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        Ok(ResponseOutcome::new(
            self.clone(),
            [(x.name, input_unit), (y.name, y.unit)]
                .map(|(name, unit)| (name.to_owned(), unit.to_owned())),
            unit,
            spectra.map_or(0.0, |s| s.independent),
            response,
            power,
            modes,
            figures,
            fit,
            findings,
        ))
    }
}

/// Samples that stay at the very end of the range.
fn saturation(channel: &Channel<'_>, findings: &mut Vec<Finding>) {
    for (side, extreme) in [
        (
            "upper",
            channel.data.iter().copied().fold(f64::MIN, f64::max),
        ),
        (
            "lower",
            channel.data.iter().copied().fold(f64::MAX, f64::min),
        ),
    ] {
        let (mut longest, mut run, mut elsewhere, mut other) = (0usize, 0usize, 1usize, 1usize);
        for (k, v) in channel.data.iter().enumerate() {
            run = if *v == extreme { run + 1 } else { 0 };
            longest = longest.max(run);
            other = if k > 0 && *v == channel.data[k - 1] && *v != extreme {
                other + 1
            } else {
                1
            };
            elsewhere = elsewhere.max(other);
        }
        if longest >= 4 && longest > 2 * elsewhere {
            findings.push(
                Finding::new(
                    Severity::Decision,
                    "saturated",
                    format!("{} stays at the {side} end of its range", channel.name),
                )
                .evidence(format!(
                    "{longest} samples at {extreme:.6}, at most {elsewhere} equal elsewhere"
                ))
                .advice("widen the range and record again"),
            );
        }
    }
}

/// The output of a device comes after its input. Up to where the phase has turned by a quarter, it falls with frequency; where it
/// rises by five standard uncertainties, the channels are swapped or not sampled together.
fn order(response: &ResponseEstimate, findings: &mut Vec<Finding>) {
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
        return;
    }
    let weight: f64 = lines.iter().map(|(.., u)| u.powi(-2)).sum();
    let mean = |of: fn(&(f64, f64, f64)) -> f64| -> f64 {
        lines.iter().map(|l| of(l) * l.2.powi(-2)).sum::<f64>() / weight
    };
    let (f0, p0) = (mean(|l| l.0), mean(|l| l.1));
    let spread: f64 = lines.iter().map(|(f, _, u)| ((f - f0) / u).powi(2)).sum();
    if !(spread > 0.0) {
        return;
    }
    let slope = lines
        .iter()
        .map(|(f, p, u)| (f - f0) * (p - p0) / (u * u))
        .sum::<f64>()
        / spread;
    let rise = slope * (lines[lines.len() - 1].0 - lines[0].0);
    if slope * spread.sqrt() > 5.0 && rise > 0.02 {
        findings.push(
            Finding::new(
                Severity::Warning,
                "output-leads",
                "the output comes before the input",
            )
            .evidence(format!(
                "the phase rises by {:.2} rad from {:.1} Hz to {:.1} Hz, as if {:.2e} s early; standard uncertainty {:.1e} s",
                rise,
                lines[0].0,
                lines[lines.len() - 1].0,
                slope / std::f64::consts::TAU,
                spread.powf(-0.5) / std::f64::consts::TAU
            ))
            .advice("look whether the two channels are swapped, or sampled one after the other"),
        );
    }
}

fn quality(response: &ResponseEstimate, findings: &mut Vec<Finding>) {
    let n = response.value.len();
    if response.coherence.len() == n && n > 0 {
        let poor = response.coherence.iter().filter(|c| **c < 0.75).count();
        if 10 * poor > 3 * n {
            findings.push(
                Finding::new(Severity::Warning, "low-coherence", "input and output are hardly related over much of the band")
                    .evidence(format!("coherence below 0.75 at {poor} of {n} lines"))
                    .advice("raise the excitation, check the channels, or narrow --band; noise on the input asks for H2 or Hv"),
            );
        }
    }
    let worst = (0..n)
        .map(|k| (k, response.leakage[k].norm() / response.value[k].norm()))
        .max_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((k, share)) = worst {
        let noise = (response.covariance[k][0] + response.covariance[k][2]
            - response.leakage[k].norm_sqr())
        .max(0.0)
        .sqrt();
        if share > 0.02 && response.leakage[k].norm() > 3.0 * noise {
            findings.push(
                Finding::new(
                    Severity::Warning,
                    "leakage",
                    "a resonance is narrower than the lines resolve",
                )
                .evidence(format!(
                    "bias of {:.1} % of the modulus at {:.2} Hz",
                    100.0 * share,
                    response.frequency[k]
                ))
                .advice("give longer segments (--segment)"),
            );
        }
    }
    if response.dof.first().is_some_and(|d| *d < 10.0) {
        findings.push(
            Finding::new(Severity::Note, "few-averages", "the bands rest on few averages")
                .evidence(format!("{:.0} degrees of freedom to a line", response.dof[0]))
                .advice("average more segments or blows: an uncertainty that is itself uncertain makes wide intervals"),
        );
    }
}
