//! Frequency response of a device from recorded input and output: random, impact, sweep, steps.

mod answer;
mod hits;
mod model;
mod outcome;
mod page;
mod points;
mod recordings;
mod steps;
mod sweep;
#[cfg(test)]
mod tests;

pub use model::{ModelData, ModelJob};
pub use outcome::ResponseOutcome;
pub(crate) use outcome::StoredModel;
pub use points::{PointColumns, RecordedPoints};
pub use proofmass_dynamic::measured::ResponsePower;
pub use recordings::ResponseRecordings;

use crate::channels::Channel;
use crate::findings;
use crate::outcome::Job;
use crate::required_density::JudgedDensity;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_dynamic::input_noise::InputNoise;
use proofmass_dynamic::measured::{
    CommonInput, Lead, by_standard, driven_band, leaking, swept_band, swept_over,
};
use proofmass_dynamic::model::{
    FitProblem, ModelFit, ModelStructure, ResponseFigures, ResponsePoints,
};
use proofmass_dynamic::modes::{Resonance, resonances};
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_dynamic::required_density::RequiredDensity;
use proofmass_report::scientific;
use proofmass_signal::saturation;
use proofmass_signal::transfer::{CrossSpectra, Estimator, Hit, LocalPolynomial, ResponseEstimate};
use proofmass_signal::{Welch, Window};
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};

/// What drives the device.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ResponseJob {
    /// What drives the device.
    pub excitation: Excitation,
    /// Where the noise is; `None` where nobody knows: H₁, with what noise of the input the coherence allows in its uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub estimator: Option<Estimator>,
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
    /// Density that is required of the input, an acceleration: what the device was to be driven with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub required: Option<RequiredDensity>,
    /// Distance of the lines that are held against it, Hz; 5 Hz, or half of its lowest frequency, unless stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resolution: Option<f64>,
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

impl ResponseJob {
    /// This excitation, everything else by its default: H₁ with noise anywhere, all frequencies, no model.
    pub fn new(excitation: Excitation) -> Self {
        Self {
            excitation,
            estimator: None,
            segment: None,
            band: None,
            force_window: None,
            model: None,
            reference_frequency: None,
            input_uncertainty: 0.0,
            standard: None,
            required: None,
            resolution: None,
        }
    }

    /// The input against what is required of it.
    fn judged(&self, x: &Channel<'_>, data: &ResponseData<'_>) -> Result<Option<JudgedDensity>> {
        let Some(required) = &self.required else {
            return Ok(None);
        };
        if self.excitation != Excitation::Random {
            return Err(Trouble::request(
                "a required spectrum is one of a random excitation",
            ));
        }
        if x.unit != "m/s²" {
            return Err(Trouble::request(format!(
                "the input {:?} is in {}, and the required spectrum is one of an acceleration",
                x.name, x.unit
            ))
            .detail(data.name)
            .with_hint("name the acceleration of the table as the input, or hold it against the spectrum by `proofmass test motion`"));
        }
        let judged = JudgedDensity::of(
            required,
            (x.name, x.data),
            data.rate,
            self.resolution,
            self.input_uncertainty,
        );
        judged.map(Some).map_err(|e| e.detail(data.name))
    }

    /// What the errors of the input have in common.
    fn input<'a>(&'a self, noise: Option<&'a InputNoise>) -> CommonInput<'a> {
        CommonInput {
            relative: self.input_uncertainty,
            standard: self.standard.as_ref(),
            noise,
        }
    }

    fn estimator(&self) -> Estimator {
        self.estimator.unwrap_or_default()
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
        let kept = by_standard(&response, standard)?;
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
                proofmass_shaker::findings::reference_out_of_range(
                    "all lines",
                    &format!(
                        "{lost} lines of {} were left out; it covers {first} Hz to {last} Hz",
                        response.lines()
                    ),
                )
                .at(Severity::Note),
            );
        }
        if let Some(power) = power {
            power.seen_by(standard)?;
        }
        Ok(kept)
    }

    fn estimate(
        &self,
        data: &ResponseData<'_>,
        driven: [f64; 2],
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
        let named = |e: proofmass_core::Error| {
            let few = matches!(e, proofmass_core::Error::TooFew { .. });
            let trouble = Trouble::from(e).detail(data.name);
            match few {
                true if self.excitation == Excitation::Sweep => trouble.with_hint(
                    "record the sweep with more samples, or give fewer lines to join with --smoothing",
                ),
                true => trouble.with_hint("record longer, or choose a shorter --segment"),
                false => trouble,
            }
        };
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
                let response = spectra.response(0, self.estimator()).map_err(named)?;
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
                let response = spectra.response(0, self.estimator()).map_err(named)?;
                let lowest = rate / hits.length as f64;
                Ok((response.within(band[0].max(lowest), band[1]), Some(spectra)))
            }
            Excitation::Steps => Ok((steps::response(data, self.band, findings)?, None)),
            Excitation::Points => Err(Trouble::request("points of a response are no recording")
                .with_hint("fit a model to them with `proofmass test model`")),
            Excitation::Sweep => {
                let [x, y] = one()?;
                let mut method = LocalPolynomial::default();
                method.band = self.band.unwrap_or_else(|| {
                    let [low, high] = driven;
                    match swept_band(x.data, rate) {
                        Some([first, last]) if first < last => [first.max(low), last.min(high)],
                        _ => [low, high],
                    }
                });
                if let Some(wide) = self.segment {
                    method.half_width = wide / 2;
                }
                let response = method
                    .estimate(x.data, y.data, rate, watch)
                    .map_err(named)?;
                sweep::ends([x.data, y.data], rate, method.band, &response, findings);
                Ok((response, None))
            }
        }
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
            for (c, role) in [(x, "input"), (y, "output")] {
                if c.data.iter().all(|v| *v == c.data[0]) {
                    return Err(Trouble::data(format!(
                        "the {role} {:?} is constant: no response can be determined",
                        c.name
                    ))
                    .detail(data.name)
                    .with_hint("check the column and its cable"));
                }
                findings.extend(saturation::clipped(c.name, c.data, "the response is distorted: its gain is too small, for a random excitation by the share that is cut off"));
            }
        }
        let judged = self.judged(x, data)?;
        findings.extend(judged.as_ref().and_then(JudgedDensity::finding));
        if self.excitation == Excitation::Random
            && let Some([from, to]) = swept_over(x.data, data.rate)
        {
            findings.push(findings::input_is_swept(x.name, from, to));
        }
        let driven = driven_band(x.data, data.rate);
        let (response, spectra) = self.estimate(data, driven, watch, &mut findings)?;
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
            let band = match self.band {
                Some([low, high]) => format!("the band {low} Hz to {high} Hz"),
                None => "the response".to_owned(),
            };
            return Err(Trouble::data(format!(
                "{band} holds no frequency line; the recording reaches {} Hz",
                0.5 * data.rate
            ))
            .detail(data.name)
            .with_hint("widen --band, or give longer segments"));
        }
        watch.step("response", 1, 2)?;
        quality(&response, driven, &mut findings);
        if input_unit == y.unit {
            order(&response, &mut findings);
            let lowest = response.value.first().map_or(1.0, |v| v.norm());
            findings.extend(of_one_size(y.unit, lowest).map(|f| f.at(Severity::Note)));
        }
        if self.standard.is_none() && x.unit == "V" && y.unit == "m/s²" {
            findings.push(findings::input_in_volts(x.name, y.name));
        }
        let unit = match (y.unit, input_unit) {
            (a, b) if a == b => "1".to_owned(),
            (a, b) if b.contains('/') => format!("{a}/({b})"),
            (a, b) => format!("{a}/{b}"),
        };
        let input_noise = match (&spectra, self.estimator, response.frequency.first()) {
            (Some(spectra), None, Some(lowest)) => Some(InputNoise::allowed(spectra, 0, *lowest)),
            _ => None,
        };
        let noise = input_noise.as_ref();
        findings.extend(noise.and_then(|n| unsaid(n, &response)));
        let fit: Option<ModelFit> = match self.model {
            Some(structure) => {
                let points = ResponsePoints::of(&response, &unit);
                let seen = match &spectra {
                    Some(spectra) => {
                        points.seen_through(&response, spectra.smearing(self.estimator()))
                    }
                    None => points,
                };
                let seen = self.input(noise).on(seen)?;
                match FitProblem::new(structure).fit(&seen) {
                    Ok(fit) => {
                        findings.extend(fit.findings.iter().cloned());
                        Some(fit)
                    }
                    // The response is known all the same.
                    Err(e) => {
                        findings.push(findings::model_not_fitted(&e.to_string()));
                        None
                    }
                }
            }
            None => None,
        };
        watch.step("response", 2, 2)?;
        let points = self.input(noise).on(ResponsePoints::of(&response, &unit))?;
        let fitted = fit.as_ref().and_then(|f| {
            let q = f.estimate.get("mode.1.damping")?;
            Some((q.value, q.standard_uncertainty))
        });
        let independent = spectra.as_ref().map_or(0.0, |s| s.independent);
        // Departures refer to a line that is known, and a peak that the input does not explain is none.
        let reference = answer::stated_line(&response, independent, self.reference_frequency)
            .map(|k| response.frequency[k])
            .or(self.reference_frequency);
        let mut figures = ResponseFigures::of(&points, reference, fitted);
        if let Some(figures) = &mut figures
            && let Some((peak, _)) = figures.resonance
            && !answer::explained_at(&response, independent, peak)
        {
            figures.without_the_peak();
        }
        let low = response.frequency.first().copied().unwrap_or(0.0);
        let high = response.frequency.last().copied().unwrap_or(0.0);
        let smearing = spectra.as_ref().map(|s| s.smearing(self.estimator()));
        let modes = resonances(&response, smearing.as_ref(), low, high);
        if let Some(figures) = &mut figures {
            // Width, peak and phase are read from the first resonance where that is the highest.
            let peak = figures.resonance.map_or(f64::NAN, |(peak, _)| peak);
            let first = modes.first();
            let near = |m: &&Resonance| (m.frequency / peak - 1.0).abs() < m.damping.max(0.02);
            if let (Some(first), None) = (first.filter(near), fitted) {
                figures.beside(first.damping, first.damping_uncertainty);
            }
            findings.extend(figures.findings.iter().cloned());
        }
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        let channels = [(x.name, input_unit), (y.name, y.unit)];
        Ok(ResponseOutcome {
            request: self.clone(),
            channels: channels.map(|(name, unit)| (name.to_owned(), unit.to_owned())),
            unit,
            independent,
            response,
            judged,
            input_noise,
            power,
            modes,
            figures,
            fit,
            findings,
        })
    }
}

/// Whether input and output of one unit are not of one size.
pub(crate) fn of_one_size(unit: &str, gain: f64) -> Option<Finding> {
    let gain = gain.abs();
    (unit == "m/s²" && !(0.5..=2.0).contains(&gain)).then(|| findings::gain_not_one(unit, gain))
}

/// Noise that may be on the input, where it is more than what is left of the noise in a mean over the lines.
fn unsaid(noise: &InputNoise, response: &ResponseEstimate) -> Option<Finding> {
    let mut ratios: Vec<(f64, f64, f64)> = (0..response.lines())
        .map(|k| {
            let f = response.frequency[k];
            let (u, _) = response.polar_uncertainty(k);
            let share = noise.standard_uncertainty(f);
            (share * response.value[k].norm() / u, noise.at(f), f)
        })
        .collect();
    let middle = ratios.len() / 2;
    let (_, (ratio, share, frequency), _) = ratios
        .get(middle)
        .is_some()
        .then(|| ratios.select_nth_unstable_by(middle, |a, b| a.0.total_cmp(&b.0)))?;
    let lines = (response.lines() / response.independent_every.max(1)) as f64;
    (*ratio * lines.sqrt() > 2.0 && *share > 1e-3)
        .then(|| findings::input_noise_unsaid(100.0 * *share, *frequency))
}

/// Where the output seems to come before the input.
fn order(response: &ResponseEstimate, findings: &mut Vec<Finding>) {
    if let Some(lead) = Lead::of(response) {
        findings.push(
            proofmass_dynamic::findings::output_leads(
                "input",
                &format!(
                    "the phase rises by {:.2} rad from {:.1} Hz to {:.1} Hz, as if {} s early; standard uncertainty {} s",
                    lead.rise,
                    lead.band[0],
                    lead.band[1],
                    scientific(lead.time, 3),
                    scientific(lead.time_uncertainty, 2)
                ),
            )
            .at(Severity::Warning),
        );
    }
}

fn quality(response: &ResponseEstimate, driven: [f64; 2], findings: &mut Vec<Finding>) {
    // Where nothing drives the device, nothing is related to it.
    let lines = response.frequency.iter().zip(&response.coherence);
    let coherence = lines.filter(|(f, _)| (driven[0]..=driven[1]).contains(f));
    let coherence: Vec<f64> = coherence.map(|(_, c)| *c).collect();
    let poor = coherence.iter().filter(|c| **c < answer::EXPLAINED).count();
    if 10 * poor > 3 * coherence.len() {
        findings.push(findings::low_coherence(
            answer::EXPLAINED,
            poor,
            coherence.len(),
        ));
    }
    if let Some((frequency, share)) = leaking(response) {
        findings.push(findings::leakage(100.0 * share, frequency));
    }
    if response.dof.first().is_some_and(|d| *d < 10.0) {
        let few = proofmass_uncertainty::findings::few_degrees_of_freedom(
            "every line",
            response.dof[0],
            "average more segments or impacts",
        );
        findings.push(few.at(Severity::Note));
    }
}
