//! Figures of one recorded acceleration: strong motion, response spectrum, machine vibration.

mod outcome;
mod page;

pub use outcome::{MotionOutcome, MotionSpectrum};

use crate::channels::Channel;
use crate::findings;
use crate::outcome::Job;
use crate::required_density::JudgedDensity;
use crate::trouble::{Result, Trouble};
use proofmass_core::{STANDARD_GRAVITY, Watch};
use proofmass_dynamic::required_density::RequiredDensity;
use proofmass_signal::saturation;
use proofmass_signal::{
    Baseline, Extremes, Peaks, Response, ShockSpectrum, StrongMotion, Trace, Vibration,
};
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};

/// What is asked of a recorded acceleration.
///
/// ```
/// use proofmass_jobs::motion::{MotionData, MotionJob};
/// use proofmass_jobs::{Channel, Job, Outcome, Unwatched};
///
/// let record: Vec<f64> = (0..20_000).map(|k| (0.3 * f64::from(k)).sin()).collect();
/// let data = MotionData {
///     channel: Channel { name: "a", unit: "m/s²", data: &record },
///     rate: 1000.0,
///     findings: &[],
///     name: "machine",
/// };
/// let mut job = MotionJob::default();
/// job.relative_uncertainty = 0.01;
/// let outcome = job.evaluate(&data, &Unwatched)?;
/// let rms = outcome.quantities().into_iter().find(|q| q.name == "rms").unwrap();
/// assert!((rms.value - 0.5f64.sqrt()).abs() < 1e-3 && (rms.u.unwrap() - 0.00707).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct MotionJob {
    /// Relative standard uncertainty of the acceleration, from the calibration of its sensor.
    pub relative_uncertainty: f64,
    /// Gravity of intensity and durations, m/s².
    pub gravity: f64,
    /// What is removed before velocity and displacement.
    pub baseline: Baseline,
    /// Periods of the response spectrum, s; a hundred from twice the sample time to ten seconds when empty.
    pub periods: Vec<f64>,
    /// Damping ratio of the response spectrum.
    pub damping: f64,
    /// Band of the vibration velocity, Hz.
    pub vibration_band: [f64; 2],
    /// Density that is required of the acceleration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub required: Option<RequiredDensity>,
    /// Distance of the lines that are held against it, Hz; 5 Hz, or half of its lowest frequency, unless stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resolution: Option<f64>,
    /// Full scale of the sensor to either side, m/s²: samples there are cut off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub full_scale: Option<f64>,
}

impl Default for MotionJob {
    fn default() -> Self {
        Self {
            relative_uncertainty: 0.0,
            gravity: STANDARD_GRAVITY,
            baseline: Baseline::None,
            periods: Vec::new(),
            damping: 0.05,
            vibration_band: [10.0, 1000.0],
            required: None,
            resolution: None,
            full_scale: None,
        }
    }
}

/// One recorded acceleration.
#[derive(Clone, Debug)]
pub struct MotionData<'a> {
    /// The acceleration, m/s².
    pub channel: Channel<'a>,
    /// Samples per second.
    pub rate: f64,
    /// What reading the data found.
    pub findings: &'a [Finding],
    /// What the recording is called in messages.
    pub name: &'a str,
}

impl Job for MotionJob {
    type Data<'a> = MotionData<'a>;
    type Outcome = MotionOutcome;

    fn evaluate(&self, data: &MotionData<'_>, watch: &dyn Watch) -> Result<MotionOutcome> {
        let channel = data.channel;
        if channel.unit != "m/s²" {
            return Err(Trouble::data(format!(
                "{:?} is in {}, not in a unit of acceleration",
                channel.name, channel.unit
            ))
            .detail(data.name)
            .with_hint(
                "state its unit with --unit, or calibrate it with `proofmass apply` first",
            ));
        }
        let named = |e: proofmass_core::Error| Trouble::from(e).detail(data.name);
        let record = channel.data;
        let figures = StrongMotion::of(record, data.rate, self.gravity).map_err(named)?;
        let motion = self.baseline.integrate(record, data.rate).map_err(named)?;
        let mut findings = data.findings.to_vec();
        let consequence = "peak, velocity and displacement are lower bounds";
        let clipped = saturation::clipped(channel.name, record, consequence);
        match self.full_scale.filter(|_| clipped.is_empty()) {
            Some(scale) => {
                findings.extend(at_full_scale(channel.name, record, scale, consequence)?)
            }
            None => findings.extend(clipped),
        }
        let required = self.required.as_ref().map(|required| {
            let judged = JudgedDensity::of(
                required,
                (channel.name, record),
                data.rate,
                self.resolution,
                self.relative_uncertainty,
            );
            judged.map_err(|e| e.detail(data.name))
        });
        let required = required.transpose()?;
        findings.extend(required.as_ref().and_then(JudgedDensity::finding));
        let periods = if self.periods.is_empty() {
            let (low, high) = (
                2.0 / data.rate,
                (0.5 * record.len() as f64 / data.rate).min(10.0),
            );
            (0..100)
                .map(|k| low * (high / low).powf(f64::from(k) / 99.0))
                .collect()
        } else {
            self.periods.clone()
        };
        if periods.iter().any(|t| !(*t > 0.0 && t.is_finite())) {
            return Err(Trouble::request(
                "every period of the spectrum must be positive",
            ));
        }
        let of = |response: Response, peaks: Peaks| -> Result<Vec<Extremes>> {
            let spectrum = ShockSpectrum {
                damping: self.damping,
                response,
                peaks,
                ..ShockSpectrum::new(periods.iter().map(|t| 1.0 / t).collect(), 10.0)
            };
            let result = spectrum.evaluate_watched(record, data.rate, watch);
            Ok(result.map_err(named)?.extremes)
        };
        let displacement = of(Response::RelativeDisplacement, Peaks::BetweenSamples)?;
        let at_samples = of(Response::RelativeDisplacement, Peaks::AtSamples)?;
        let velocity = of(Response::RelativeVelocity, Peaks::BetweenSamples)?;
        let acceleration = of(Response::AbsoluteAcceleration, Peaks::BetweenSamples)?;
        let curve = |e: &[Extremes]| e.iter().map(Extremes::recorded_maximax).collect();
        let spectrum = MotionSpectrum {
            displacement: curve(&displacement),
            displacement_at_samples: curve(&at_samples),
            velocity: curve(&velocity),
            acceleration: curve(&acceleration),
            period: periods,
        };
        let later = displacement
            .iter()
            .zip(&spectrum.period)
            .filter(|(e, _)| e.maximax() > 1.01 * e.recorded_maximax())
            .map(|(_, t)| *t)
            .fold(f64::INFINITY, f64::min);
        if later.is_finite() {
            findings.push(
                proofmass_dynamic::findings::record_ends_early(
                    "slow oscillators reach their peak",
                    &format!("from a period of {later:.3} s on"),
                    "the spectrum is that of the record alone; read it below that period",
                )
                .at(Severity::Note),
            );
        }
        let high = self.vibration_band[1].min(0.45 * data.rate);
        let vibration = match Vibration::of(record, data.rate, [self.vibration_band[0], high]) {
            Ok(v) => Some(v),
            Err(why) => {
                findings.push(findings::vibration_band_not_resolved(
                    "its figures are not given",
                    &why.to_string(),
                ));
                None
            }
        };
        if vibration.is_some() && high < self.vibration_band[1] {
            findings.push(findings::vibration_band_not_resolved(
                "its velocity is that of a narrower one",
                &format!(
                    "up to {high:.1} Hz instead of {:.1} Hz",
                    self.vibration_band[1]
                ),
            ));
        }
        let mean = record.iter().sum::<f64>() / record.len() as f64;
        let end = motion.velocity.last().copied().unwrap_or(0.0);
        let greatest = motion.velocity.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        if greatest > 0.0 && end.abs() > 0.5 * greatest && record.len() > 100 {
            findings.push(findings::velocity_drifts(end, mean));
        }
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        let time: Vec<f64> = (0..record.len()).map(|k| k as f64 / data.rate).collect();
        let trace = |y: &[f64]| Trace::new(&time, y, Trace::RUNS);
        let extreme = |y: &[f64]| y.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        Ok(MotionOutcome {
            request: self.clone(),
            figures,
            peaks: [extreme(&motion.velocity), extreme(&motion.displacement)],
            traces: [&motion.acceleration, &motion.velocity, &motion.displacement]
                .map(|y| trace(y)),
            spectrum,
            vibration,
            required,
            findings,
        })
    }
}

/// Samples at the full scale that is stated, of which the record alone shows too few to tell.
fn at_full_scale(
    name: &str,
    record: &[f64],
    scale: f64,
    consequence: &str,
) -> Result<Option<Finding>> {
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(Trouble::request(format!(
            "a full scale of {scale} m/s² is out of range: it must be positive"
        ))
        .with_hint("give the end of the range of the sensor, above zero, such as 2g"));
    }
    // A thousandth below, as a converter rounds.
    let there = record.iter().filter(|v| v.abs() >= 0.999 * scale).count();
    Ok((there > 0).then(|| {
        proofmass_uncertainty::findings::clipped(
            &format!("{name} reaches the full scale that is stated"),
            &format!("{there} samples at ±{scale:.4} m/s²"),
            consequence,
        )
    }))
}
