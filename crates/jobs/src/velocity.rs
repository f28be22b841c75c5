//! Velocity of an axis from its encoder (or wheel speed) and its accelerometer: estimate, comparison, tuning, encoder map.

mod clock;
mod drift;
mod drift_results;
mod integrator;
mod map;
mod offered;
mod outcome;
mod page;
mod reading;
mod reference;
mod sensors;
mod turning;

pub use drift::{VelocityDrift, VelocityDriftJob};
pub use drift_results::{DriftResults, TakenFrom};
pub use integrator::{VelocityIntegrator, VelocityIntegratorJob};
pub(crate) use map::StoredMap;
pub use map::{VelocityMap, VelocityMapJob};
pub(crate) use outcome::TunedGains;
pub use outcome::{VelocityComparison, VelocityEstimate, VelocityTuning};
pub use reading::Reading;
pub use reference::Reference;
pub use sensors::{AxisRecordings, AxisSensors, SensorAxis};
pub use turning::Turning;

use crate::outcome::Job;
use crate::trouble::{Result, Trouble};
use proofmass_core::{Error, Watch};
use proofmass_motion::{
    Method, MotionRecord, ReadingNoise, Tuning, compare_turning, conditions, estimate_turning,
    tune_turning,
};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Both sensors of an axis on one time base, and what is known beside them.
#[derive(Clone, Copy, Debug)]
pub struct AxisData<'a> {
    /// Both sensors, SI.
    pub record: &'a MotionRecord,
    /// Time of the first sample in the clock of the recording, s.
    pub start: f64,
    /// First and last time of what was recorded, s, where gaps leave a part of it.
    pub recorded: Option<[f64; 2]>,
    /// Whether it is an angle: rad and rad/s in place of m and m/s.
    pub angular: bool,
    /// Way or angle of one turn of the encoder, where the reading says it.
    pub turn: Option<f64>,
    /// What was stated of the encoder, in words: counts of a turn, radius.
    pub encoder: Option<&'a str>,
    /// Time by which the accelerometer was stated to be late, s: it was shifted back by it.
    pub latency: f64,
    /// Reference velocity per sample, m/s.
    pub reference: Option<&'a [f64]>,
    /// What to doubt about the data.
    pub findings: &'a [Finding],
    /// The recording in messages and titles.
    pub name: &'a str,
}

impl<'a> AxisData<'a> {
    /// A record that begins at zero, without a reference.
    pub fn new(record: &'a MotionRecord) -> Self {
        Self {
            record,
            start: 0.0,
            recorded: None,
            angular: false,
            turn: None,
            encoder: None,
            latency: 0.0,
            reference: None,
            findings: &[],
            name: "an axis",
        }
    }
}

/// The longest stretch of a record without a long gap, for what cannot leave one out.
struct Piece {
    record: MotionRecord,
    samples: Range<usize>,
}

impl Piece {
    /// `None` where there is no long gap.
    fn of(whole: &AxisData<'_>) -> Option<Self> {
        let samples = whole.record.in_one_piece()?;
        let record = whole.record.within(samples.clone())?;
        Some(Self { record, samples })
    }

    fn data<'a>(&'a self, whole: &AxisData<'a>) -> AxisData<'a> {
        let dt = whole.record.sample_time;
        let time = |k: usize| whole.start + dt * k as f64;
        let all = [time(0), time(whole.record.reading.len() - 1)];
        AxisData {
            record: &self.record,
            start: time(self.samples.start),
            recorded: whole.recorded.or(Some(all)),
            reference: whole.reference.map(|r| &r[self.samples.clone()]),
            ..*whole
        }
    }
}

/// The velocity with its uncertainty.
///
/// ```
/// use proofmass_jobs::{Job, Outcome, Unwatched, velocity::{AxisData, VelocityEstimateJob}};
/// use proofmass_motion::{MotionRecord, ReadingSource};
/// use proofmass_rig::{DrivenAxis, AxisMotion};
///
/// let recording = DrivenAxis::new(AxisMotion::servo(5.0)).simulate(1)?;
/// let (x, a) = (recording.position(), recording.acceleration.clone());
/// let mut record = MotionRecord::new(recording.sample_time, ReadingSource::Position, x, a)?;
/// record.increment = Some(recording.increment);
/// let outcome = VelocityEstimateJob::default().evaluate(&AxisData::new(&record), &Unwatched)?;
/// let fastest = &outcome.quantities()[0];
/// assert!(fastest.value > 0.0 && fastest.expanded < fastest.value);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct VelocityEstimateJob {
    /// Method with its settings; where there is none the Kalman filter, tuned.
    pub method: Option<Method>,
    /// Distance of one turn of the wheel, m.
    pub circumference: Option<f64>,
}

impl VelocityEstimateJob {
    /// By a method, or by the tuned Kalman filter.
    pub fn new(method: Option<Method>, circumference: Option<f64>) -> Self {
        Self {
            method,
            circumference,
        }
    }
}

impl Job for VelocityEstimateJob {
    type Data<'a> = AxisData<'a>;
    type Outcome = VelocityEstimate;

    fn evaluate(&self, data: &AxisData<'_>, watch: &dyn Watch) -> Result<VelocityEstimate> {
        lacking(data, self.method.as_slice())?;
        let (own, turn) = (self.circumference, data.turn);
        let estimate = |data: &AxisData<'_>| {
            let result = estimate_turning(data.record, self.method, own, turn, watch)
                .map_err(|e| explain(e, data.name))?;
            Ok(VelocityEstimate::new(data, result, self.method.is_some()))
        };
        // Slow accelerations are given back from the first sample on: behind a long gap they are not known.
        let piece = Piece::of(data);
        let piece = piece.as_ref().map(|piece| piece.data(data));
        match (piece, data.record.low_corner) {
            (Some(piece), Some(_)) => estimate(&piece),
            (None, _) => estimate(data),
            (Some(piece), None) => match estimate(data)? {
                whole if whole.result.low_corner.is_none() => Ok(whole),
                _ => estimate(&piece),
            },
        }
    }
}

/// Methods side by side.
///
/// ```
/// use proofmass_jobs::{Job, Unwatched, velocity::{AxisData, VelocityCompareJob}};
/// use proofmass_motion::{MotionRecord, ReadingSource};
/// use proofmass_rig::{DrivenAxis, AxisMotion};
///
/// let mut axis = DrivenAxis::new(AxisMotion::servo(5.0));
/// axis.duration = 1.0;
/// let recording = axis.simulate(1)?;
/// let (x, a) = (recording.position(), recording.acceleration.clone());
/// let mut record = MotionRecord::new(recording.sample_time, ReadingSource::Position, x, a)?;
/// record.increment = Some(recording.increment);
/// let truth: Vec<f64> = recording.truth.iter().map(|p| p.velocity).collect();
/// let data = AxisData { reference: Some(&truth), ..AxisData::new(&record) };
/// let job = VelocityCompareJob::new(Vec::new(), vec![1000.0, 100.0], None);
/// assert!(job.evaluate(&data, &Unwatched).is_ok());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct VelocityCompareJob {
    /// Methods with their settings; none stands for all.
    pub methods: Vec<Method>,
    /// Sample rates, Hz, to which the recording is thinned; none stands for its own.
    pub rates: Vec<f64>,
    /// Seconds at the start that are not compared; where there is none one, at most a tenth of the record.
    pub skip: Option<f64>,
}

impl VelocityCompareJob {
    /// Methods at rates.
    pub fn new(methods: Vec<Method>, rates: Vec<f64>, skip: Option<f64>) -> Self {
        Self {
            methods,
            rates,
            skip,
        }
    }

    /// Rates as whole fractions of that of the recording.
    fn decimations(&self, record: &MotionRecord) -> Result<Vec<usize>> {
        let own = 1.0 / record.sample_time;
        if self.rates.is_empty() {
            return Ok(vec![1]);
        }
        let mut list = Vec::new();
        for &rate in &self.rates {
            let n = (own / rate).round();
            let fits = rate.is_finite() && rate > 0.0 && n >= 1.0;
            if !fits || (own / n / rate - 1.0).abs() > 0.01 {
                return Err(Trouble::request(format!(
                    "{rate} Hz is not the rate of the recording, {own:.6} Hz, over a whole number"
                ))
                .with_hint(if fits {
                    format!(
                        "the nearest are {:.6} Hz and {:.6} Hz",
                        own / n,
                        own / (n + 1.0)
                    )
                } else {
                    format!("give rates from {own:.6} Hz down")
                }));
            }
            if !list.contains(&(n as usize)) {
                list.push(n as usize);
            }
        }
        Ok(list)
    }
}

impl Job for VelocityCompareJob {
    type Data<'a> = AxisData<'a>;
    type Outcome = VelocityComparison;

    fn evaluate(&self, data: &AxisData<'_>, watch: &dyn Watch) -> Result<VelocityComparison> {
        let piece = Piece::of(data);
        let data = &piece.as_ref().map_or(*data, |piece| piece.data(data));
        lacking(data, &self.methods)?;
        let decimations = self.decimations(data.record)?;
        let duration = data.record.sample_time * data.record.reading.len() as f64;
        let skip = self.skip.unwrap_or((0.1 * duration).min(1.0));
        if !(skip >= 0.0 && skip < duration) {
            return Err(Trouble::request(format!(
                "without the first {skip} s nothing of {duration:.3} s is left to compare"
            )));
        }
        let result = compare_turning(
            data.record,
            data.reference,
            &self.methods,
            &decimations,
            (skip, data.turn),
            watch,
        )
        .map_err(|e| explain(e, data.name))?;
        Ok(VelocityComparison::new(data, result))
    }
}

/// Noise and gains from the recording alone.
///
/// ```
/// use proofmass_jobs::{Job, Outcome, Unwatched, velocity::{AxisData, VelocityTuneJob}};
/// use proofmass_motion::{MotionRecord, ReadingSource};
/// use proofmass_rig::{DrivenAxis, AxisMotion};
///
/// let mut axis = DrivenAxis::new(AxisMotion::servo(5.0));
/// axis.duration = 1.0;
/// let recording = axis.simulate(1)?;
/// let (x, a) = (recording.position(), recording.acceleration.clone());
/// let mut record = MotionRecord::new(recording.sample_time, ReadingSource::Position, x, a)?;
/// record.increment = Some(recording.increment);
/// let outcome = VelocityTuneJob::default().evaluate(&AxisData::new(&record), &Unwatched)?;
/// assert!(!outcome.quantities().is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct VelocityTuneJob {
    /// What is tuned.
    pub tuning: Tuning,
    /// Take the noise of a count as known, increment/√12, instead of finding it.
    pub known_increment: bool,
}

impl VelocityTuneJob {
    /// Tunes this.
    pub fn new(tuning: Tuning, known_increment: bool) -> Self {
        Self {
            tuning,
            known_increment,
        }
    }
}

impl Job for VelocityTuneJob {
    type Data<'a> = AxisData<'a>;
    type Outcome = VelocityTuning;

    fn evaluate(&self, data: &AxisData<'_>, watch: &dyn Watch) -> Result<VelocityTuning> {
        let piece = Piece::of(data);
        let data = &piece.as_ref().map_or(*data, |piece| piece.data(data));
        lacking_two(data, "the gains are those of two sensors")?;
        let mut tuning = self.tuning;
        if self.known_increment {
            let Some(increment) = data.record.increment else {
                return Err(Trouble::request("a known increment needs counts")
                    .with_hint("state --counts-per-turn or --counts-per-metre"));
            };
            tuning.reading_noise = ReadingNoise::Known {
                variance: increment * increment / 12.0,
            };
        }
        let result = tune_turning(data.record, data.turn, &tuning, watch)
            .map_err(|e| explain(e, data.name))?;
        Ok(VelocityTuning::new(data, tuning, result))
    }
}

/// Refuses one sensor alone, and an axis that stands still, where a job compares both in motion.
fn lacking_two(data: &AxisData<'_>, why: &str) -> Result<()> {
    if !data.record.accelerometer || data.record.rests_only() {
        return Err(Trouble::request(format!("{why}, and one is named"))
            .detail(data.name)
            .with_hint("name a position or a speed and --acceleration; `velocity estimate` serves one sensor alone"));
    }
    let still = |f: &Finding| f.code() == "readings-never-change";
    if conditions(data.record).iter().any(still) {
        return Err(
            Trouble::data("the axis never moves: nothing can be found on a standstill")
                .detail(data.name)
                .with_hint(
                    "record a motion of many increments, or check the column of the position",
                ),
        );
    }
    Ok(())
}

/// Refuses methods that say nothing without a sensor that is not there.
fn lacking(data: &AxisData<'_>, methods: &[Method]) -> Result<()> {
    let record = data.record;
    let refuse = |method: &Method, what: &str, hint: &str| {
        Err(Trouble::request(format!(
            "{} needs {what}, and none is named",
            method.label()
        ))
        .detail(data.name)
        .with_hint(hint.to_owned()))
    };
    for method in methods {
        if !record.accelerometer && method.needs_accelerometer() {
            return refuse(
                method,
                "an accelerometer",
                "add --acceleration COLUMN, or take fixed-time, savitzky-golay, tracking-loop or kalman",
            );
        }
        if record.edges.is_none() && method.needs_edges() {
            return refuse(
                method,
                "counts whose edges are timed",
                "add --edges where each row is an edge of counts, or take fixed-time or tracking-loop",
            );
        }
        if record.turn.is_none() && method.needs_resolver() {
            return refuse(
                method,
                "the voltages of a resolver",
                "add --resolver SIN,COS, or take tracking-loop for the angle of another encoder",
            );
        }
        if record.rests_only() && method.needs_readings() {
            return refuse(
                method,
                "a position or a speed",
                "add --position COLUMN or --speed COLUMN, or take trapezoid, simpson or tick",
            );
        }
    }
    Ok(())
}

/// A refusal of the calculation, with the recording and a remedy.
fn explain(error: Error, name: &str) -> Trouble {
    let hint = match error {
        Error::TooFew { .. } => "record longer, or use a part with more readings",
        Error::NotFinite { .. } => {
            "gains too high for this rate make a filter run away: lower them, or leave them to `velocity tune`"
        }
        Error::Singular { .. } => {
            "turn the axis through two turns or more, or look for fewer --orders"
        }
        Error::OutOfRange { .. } => {
            "see `proofmass velocity estimate --help` for what a method takes"
        }
        _ => "see `proofmass inspect` for what the file holds",
    };
    let cancelled = error.is_cancelled();
    let trouble = Trouble::from(error);
    if cancelled {
        trouble
    } else {
        trouble.detail(name).with_hint(hint)
    }
}
