//! Step response: rise, overshoot, settling, natural frequency, damping.

mod page;

use crate::channels::Channel;
use crate::outcome::{Job, Outcome, section};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_core::{Error, Watch};
use proofmass_documents::StatedQuantity;
use proofmass_dynamic::step::{FirstOrderStep, StepFit};
use proofmass_report::{Report, scientific};
use proofmass_signal::{Trace, saturation};
use proofmass_uncertainty::{Effect, Estimate, Finding, Influence};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// What is asked of a recorded step.
///
/// ```
/// use proofmass_dynamic::step::step_response;
/// use proofmass_jobs::step::{StepData, StepJob};
/// use proofmass_jobs::{Channel, Job, Unwatched};
///
/// // A mass at 100 Hz with a damping of 0.2, at 5 kHz.
/// let record: Vec<f64> = (0..1500)
///     .map(|k| {
///         let (t, noise) = ((f64::from(k) - 300.0) / 5000.0, 1e-3 * (7.3 * f64::from(k)).sin());
///         noise + if t > 0.0 { step_response(t, 100.0, 0.2) } else { 0.0 }
///     })
///     .collect();
/// let channel = Channel { name: "u", unit: "V", data: &record };
/// let data = StepData { channel, rate: 5000.0, findings: &[], name: "step" };
/// let outcome = StepJob::default().evaluate(&data, &Unwatched)?;
/// let [_, overshoot] = outcome.figures();
/// assert!((overshoot - (-0.2 * std::f64::consts::PI / 0.96f64.sqrt()).exp()).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct StepJob {
    /// Relative standard uncertainty of the scale of the channel, an acceleration.
    pub relative_uncertainty: f64,
}

/// A recorded step.
#[derive(Clone, Copy, Debug)]
pub struct StepData<'a> {
    /// The device.
    pub channel: Channel<'a>,
    /// Samples per second.
    pub rate: f64,
    /// What reading the data found.
    pub findings: &'a [Finding],
    /// What the recording is called in messages.
    pub name: &'a str,
}

/// Samples that are fitted: a step has a hundred times fewer that say anything.
const MOST: usize = 200_000;

impl Job for StepJob {
    type Data<'a> = StepData<'a>;
    type Outcome = StepOutcome;

    fn evaluate(&self, data: &StepData<'_>, watch: &dyn Watch) -> Result<StepOutcome> {
        watch.step("step", 0, 1)?;
        let record = data.channel.data;
        if record.len() > MOST {
            return Err(Trouble::data(format!(
                "{} samples: a step of at most {MOST} is fitted",
                record.len()
            ))
            .detail(data.name)
            .with_hint("cut the record to the step and what settles after it"));
        }
        let fit = StepFit::of(record, data.rate, data.channel.unit)
            .map_err(|e| refused(e, record, data.rate).detail(data.name))?;
        watch.step("step", 1, 1)?;
        seen(&fit, data)?;
        let estimate = with_scale(fit.estimate, data.channel.unit, self.relative_uncertainty)?;
        let mut findings = data.findings.to_vec();
        let consequence = "damping and natural frequency come out wrong";
        findings.extend(saturation::clipped(data.name, record, consequence));
        findings.extend(fit.findings.iter().cloned());
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        let time: Vec<f64> = (0..record.len()).map(|k| k as f64 / data.rate).collect();
        let residual: Vec<f64> = record.iter().zip(&fit.fitted).map(|(y, f)| y - f).collect();
        let traces = [record, &fit.fitted, &residual].map(|y| Trace::new(&time, y, Trace::RUNS));
        Ok(StepOutcome {
            channel: (data.channel.name.to_owned(), data.channel.unit.to_owned()),
            figures: [fit.rise_time, fit.overshoot],
            settling_time: fit.settling_time,
            residual_ratio: fit.residual_ratio,
            estimate,
            traces,
            findings,
        })
    }
}

/// By how many of its standard uncertainties a height has to differ from zero. The greatest of the steps that noise alone offers, one at
/// every sample, reaches five with a chance of 6 × 10⁻⁷ a sample.
const SEEN: f64 = 5.0;

/// Refuses an oscillator that was fitted to noise.
fn seen(fit: &StepFit, data: &StepData<'_>) -> Result<()> {
    let Some(height) = fit.estimate.get("height") else {
        return Ok(());
    };
    if height.value.abs() >= SEEN * height.standard_uncertainty {
        return Ok(());
    }
    let expanded = StatedQuantity::new(&height, 0.95).expanded;
    Err(Trouble::data(format!(
        "there is no step in {:?}: the height is {} ± {} {}",
        data.channel.name,
        scientific(height.value, 2),
        scientific(expanded, 2),
        data.channel.unit
    ))
    .detail(data.name)
    .with_hint(STEP_NEEDED))
}

const STEP_NEEDED: &str =
    "a step from one level to another, the first before it and the second at the end, is needed";

/// With the error of the scale in all that has the unit of the channel.
fn with_scale(estimate: Estimate, unit: &str, relative: f64) -> Result<Estimate> {
    if relative == 0.0 {
        return Ok(estimate);
    }
    let components = estimate.components().to_vec();
    let scaled = components.iter().map(|c| match c.unit == unit {
        true => c.value,
        false => 0.0,
    });
    let mut influences = estimate.influences().to_vec();
    influences.push(Influence::normal(
        "sensitivity",
        "relative error of the sensitivity",
        Effect::of_zero("1", relative, scaled.collect()),
    ));
    Ok(Estimate::new(components, influences)?)
}

/// Why no oscillator is stated, as far as the record proves it.
fn refused(error: Error, record: &[f64], rate: f64) -> Trouble {
    let plain = match error {
        Error::Unobservable { .. } => Trouble::data(
            "the step response does not determine the natural frequency: U is half of it or more. Either there is no clear step, or a first-order element describes it as well",
        ),
        _ => Trouble::from(error),
    }
    .with_hint(STEP_NEEDED);
    if !matches!(
        error,
        Error::Unobservable { .. } | Error::NotConverged { .. }
    ) {
        return plain;
    }
    match FirstOrderStep::of(record, rate) {
        Ok(first) if first.as_good => Trouble::data(format!(
            "the step is that of a first-order element, time constant {} s (corner {} Hz): an oscillator describes it no better, so that neither natural frequency nor damping is in it",
            scientific(first.time_constant, 5),
            scientific(1.0 / (TAU * first.time_constant), 4)
        ))
        .with_hint("a low-pass behind the device, strong damping or noise hides the resonance: record with less noise and more samples, or measure it by `proofmass test sweep`"),
        Ok(first) if first.rise_samples < 4.0 => Trouble::data(format!(
            "natural frequency and damping cannot be separated: only {:.1} samples lie between a tenth and nine tenths of the step",
            first.rise_samples
        ))
        .with_hint("sample faster"),
        Ok(first) if matches!(error, Error::Unobservable { .. }) => Trouble::data(format!(
            "the step response does not determine the natural frequency, whose expanded uncertainty is half of it or more: a first-order element, time constant {} s, describes it almost as well",
            scientific(first.time_constant, 4)
        ))
        .with_hint("record with less noise and more samples"),
        _ => plain,
    }
}

/// The answer.
#[derive(Clone, Debug, PartialEq)]
pub struct StepOutcome {
    channel: (String, String),
    figures: [f64; 2],
    settling_time: Option<f64>,
    residual_ratio: f64,
    estimate: Estimate,
    traces: [Trace; 3],
    findings: Vec<Finding>,
}

impl StepOutcome {
    /// Rise time (s), overshoot as a share of the height.
    pub fn figures(&self) -> [f64; 2] {
        self.figures
    }

    /// Settling time to 2 %, s; of a swing that is not seen to decay none.
    pub fn settling_time(&self) -> Option<f64> {
        self.settling_time
    }
}

impl Outcome for StepOutcome {
    const KIND: &'static str = "step";

    fn title(&self, record: &Record) -> String {
        record.title("Step response of", "Step response")
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        StatedQuantity::list(&self.estimate.quantities(), 0.95)
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn estimate(&self) -> Option<&Estimate> {
        Some(&self.estimate)
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        let [rise, overshoot] = self.figures;
        Ok(vec![section(
            "step",
            &serde_json::json!({
                "rise_time_s": rise,
                "overshoot": overshoot,
                "settling_time_s": self.settling_time,
                "residual_ratio": self.residual_ratio,
            }),
        )?])
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }
}
