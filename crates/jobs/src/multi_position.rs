//! Bias, scale factors and misalignment of a triaxial accelerometer from standstills.

mod attitudes;
mod explanation;
mod outcome;
mod page;
mod recordings;
mod saturated_rests;

pub use outcome::{Figures, MultiPositionOutcome};
pub use recordings::{MultiPositionRecordings, segment};
pub(crate) use recordings::{gravity, state_gravity};
pub(crate) use recordings::{pauses, shortest_pause};

use self::saturated_rests::saturated_rests;
use crate::campaign::MethodModel;
use crate::outcome::Job;
use crate::trouble::{Result, Trouble};
use proofmass_core::{Gravity, Watch};
use proofmass_io::{ColumnRef, Unit};
use proofmass_static::{
    AttitudeUncertainty, Model, MultiPosition, Samples, Segment, Standstill, StandstillCalibration,
    StandstillEstimator, Terms, ThresholdSweep, WindowedVariance, clipping, frozen,
    temperature_drift,
};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

/// What is to be calibrated, and how.
///
/// ```
/// use proofmass_core::Gravity;
/// use proofmass_io::Unit;
/// use proofmass_jobs::{Job, Outcome, Unwatched, multi_position::{MultiPositionData, MultiPositionJob}};
/// use proofmass_rig::HandHeld;
///
/// let recording = HandHeld::default().simulate(1);
/// let [x, y, z] = &recording.outputs;
/// let data = MultiPositionData::new([x, y, z], recording.rate, Unit::Count);
/// let job = MultiPositionJob::new(Gravity::given(9.80665, 1e-5)?);
/// let outcome = job.evaluate(&data, &Unwatched)?;
/// let scale = outcome.quantities().into_iter().find(|q| q.name == "scale.x").unwrap();
/// assert!((scale.value - 415.2).abs() < 2.0 * scale.expanded);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias("six-position test", "tumble test"))]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MultiPositionJob {
    /// Model and estimator.
    #[serde(default)]
    pub method: MethodModel,
    /// What is fitted beside the matrix: terms that follow the temperature, curvature.
    #[serde(default, skip_serializing_if = "Terms::is_none")]
    pub terms: Terms,
    /// Probability of the intervals.
    pub probability: f64,
    /// Local gravity.
    pub gravity: Gravity,
    /// How standstills are found where none are given.
    #[serde(default)]
    pub search: Standstill,
    /// Standard uncertainty of a given attitude about each transverse axis, rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub attitude_uncertainty: Option<f64>,
    /// Standard uncertainty of the frame of all given attitudes about each of its axes, rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame_uncertainty: Option<f64>,
    /// Where given attitudes are true accelerations in units of gravity whose lengths count, as on a centrifuge: the relative
    /// standard uncertainty common to them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub true_accelerations: Option<f64>,
    /// Smallest and largest output that the converter knows, in the unit of the data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Temperature where none was recorded, °C.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature: Option<f64>,
    /// Largest standard uncertainty at which a parameter is a result, in units of the scale and of g.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_uncertainty: Option<f64>,
    /// Standstills that are left out, by label or by number counted from one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub exclude: Vec<String>,
    /// Whether the page opens with the standstills to add, as that of a plan does.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub plan: bool,
}

impl MultiPositionJob {
    /// The default model (bias and a triangular matrix) with 95 % intervals.
    pub fn new(gravity: Gravity) -> Self {
        Self {
            method: MethodModel::default(),
            terms: Terms::default(),
            probability: 0.95,
            gravity,
            search: Standstill::default(),
            attitude_uncertainty: None,
            frame_uncertainty: None,
            true_accelerations: None,
            range: None,
            temperature: None,
            largest_uncertainty: None,
            exclude: Vec::new(),
            plan: false,
        }
    }

    fn settings(&self, data: &MultiPositionData<'_>) -> Result<MultiPosition> {
        let model = match self.method {
            MethodModel::Bias => Model::Bias,
            MethodModel::BiasScale => Model::BiasScale,
            MethodModel::Triangular => Model::Triangular,
            MethodModel::Symmetric | MethodModel::Ellipsoid => Model::Symmetric,
            MethodModel::Full | MethodModel::SixPosition | MethodModel::Ferraris => Model::Full,
        };
        let closed = matches!(
            self.method,
            MethodModel::SixPosition | MethodModel::Ferraris
        );
        if !self.terms.is_none() && (closed || data.tumble) {
            let what = if closed {
                "the closed form of six positions"
            } else {
                "a tumble"
            };
            return Err(
                Trouble::request(format!("{what} has no terms beyond the matrix"))
                    .with_hint("remove `[terms]`, or fit `full` or `triangular` to standstills"),
            );
        }
        if self.terms.follow_temperature() && data.temperature.is_none() {
            return Err(Trouble::request(
                "terms that follow the temperature need a recording with a temperature",
            )
            .detail(data.name)
            .with_hint("add `temperature = \"COLUMN\"` to [recording]"));
        }
        let mut settings = MultiPosition::new(self.gravity)
            .model(model)
            .terms(self.terms)
            .probability(self.probability)
            .output_unit(data.unit.to_string());
        if data.unit.is_acceleration() {
            settings = settings.nominal_sensitivity(1.0);
        } else if model == Model::Bias {
            return Err(Trouble::request(format!(
                "model `bias` needs outputs in m/s² or g; {} holds {}",
                data.name, data.unit
            ))
            .with_hint(
                "fit `bias-scale`, or convert the recording with the nominal sensitivity first",
            ));
        }
        if let Some(limit) = self.largest_uncertainty {
            settings = settings.largest_uncertainty(limit);
        }
        settings = settings.attitude_uncertainty(AttitudeUncertainty {
            independent: self.attitude_uncertainty.unwrap_or(0.0),
            common: self.frame_uncertainty.unwrap_or(0.0),
        });
        if let Some(common) = self.true_accelerations {
            if closed {
                return Err(Trouble::request(
                    "the closed form of six positions assumes 1 g in every position",
                )
                .with_hint("fit --model full (`model = \"full\"` in [method]) to true accelerations of other lengths"));
            }
            settings = settings.true_accelerations(common);
        }
        Ok(settings)
    }

    fn calibrate(
        &self,
        data: &MultiPositionData<'_>,
        samples: &Samples<'_>,
        settings: &MultiPosition,
        watch: &dyn Watch,
    ) -> Result<StandstillCalibration> {
        let explain =
            |error, given: Option<&[Segment]>| explanation::explain(error, self, data, given);
        if data.tumble {
            return StandstillCalibration::of_tumble(samples, data.rate, data.breaks, settings)
                .map_err(|error| explain(error, None));
        }
        let mut sweep = match data.segments {
            Some(given) => ThresholdSweep::given(given.to_vec()),
            None => ThresholdSweep::run(
                samples,
                data.rate,
                data.breaks,
                &self.search,
                settings,
                watch,
            )
            .map_err(|error| explain(error, None))?,
        };
        watch.step("fit", 0, 3)?;
        sweep.exclude(&self.exclude).map_err(|unknown| {
            Trouble::request(format!("no standstill is called {unknown:?}")).with_hint(
                "`exclude` in [standstill] lists numbers as in standstills.csv, or labels",
            )
        })?;
        if self.method.needs_attitudes() && sweep.segments.iter().any(|s| s.attitude.is_none()) {
            return Err(Trouble::request(format!(
                "method `{}` needs given attitudes",
                self.method.name()
            ))
            .with_hint("fit --model triangular (`model = \"triangular\"` in a campaign), which needs none; attitudes are given in a campaign, which `proofmass init` writes: `segments = \"segments.csv\"` in [standstill], with a column `direction` (+x, -x, …) or up_x, up_y, up_z, or roll_deg, pitch_deg, or a_true_x_m/s2 …; the same columns in a table of readings; or `directions` where each file or row is a standstill"));
        }
        let estimator = match self.method {
            MethodModel::SixPosition | MethodModel::Ferraris => StandstillEstimator::SixPositions,
            _ => StandstillEstimator::LeastSquares,
        };
        let used = sweep.segments.clone();
        match data.readings {
            Some(Readings { uncertainty }) => {
                StandstillCalibration::of_readings(samples, sweep, uncertainty, settings, estimator)
            }
            None => StandstillCalibration::of_sweep(samples, sweep, settings, estimator),
        }
        .map_err(|error| explain(error, Some(&used)))
    }

    /// What the samples themselves give reason to doubt, whether or not they can be fitted.
    fn doubts_of_the_samples(
        &self,
        data: &MultiPositionData<'_>,
        samples: &Samples<'_>,
        segments: &[Segment],
    ) -> Vec<Finding> {
        let mut findings = data.findings.to_vec();
        if data.readings.is_some() {
            return findings;
        }
        findings.extend(match self.range {
            Some([low, high]) => clipping(samples, (low, high), segments),
            None => saturated_rests(samples, segments),
        });
        findings.extend(frozen(samples));
        findings
    }

    /// All doubts, those of the recording included, the gravest first.
    fn findings(
        &self,
        data: &MultiPositionData<'_>,
        samples: &Samples<'_>,
        calibration: &StandstillCalibration,
    ) -> Vec<Finding> {
        let segments = &calibration.sweep.segments;
        let mut findings = self.doubts_of_the_samples(data, samples, segments);
        if let Some(temperature) = data
            .temperature
            .filter(|_| !self.terms.follow_temperature())
        {
            let residuals = calibration.fit.residuals();
            findings.extend(temperature_drift(temperature, segments, residuals));
        }
        findings.extend(calibration.fit.findings().iter().cloned());
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        findings
    }
}

/// A table of readings or means in place of a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Readings {
    /// Standard uncertainty of each output from its noise, in the unit of the data; without it the scatter about the
    /// model is all that is known.
    pub(crate) uncertainty: Option<f64>,
}

/// The samples of a triaxial accelerometer, all recordings one after the other.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MultiPositionData<'a> {
    /// Outputs x, y, z.
    pub outputs: [&'a [f64]; 3],
    /// Time of every sample, s; without it the samples follow one another at the rate.
    pub time: Option<&'a [f64]>,
    /// Sampling rate, Hz.
    pub rate: f64,
    /// Samples before which time jumps: gaps and the seams between recordings, in increasing order.
    pub breaks: &'a [usize],
    /// Unit of the outputs: m/s² or a raw unit.
    pub unit: Unit,
    /// Temperature of every sample, °C.
    pub temperature: Option<&'a [f64]>,
    /// Standstills that are given; without them they are found.
    pub segments: Option<&'a [Segment]>,
    /// Where every sample is a reading of its own: what is known of it.
    pub readings: Option<Readings>,
    /// Whether the sensor was turned slowly all the time, without standstills.
    pub tumble: bool,
    /// What reading the data found.
    pub findings: &'a [Finding],
    /// What the data are called in messages.
    pub name: &'a str,
    /// How x, y, z are called in the recording, for compensating others of its kind.
    pub columns: Option<[ColumnRef; 3]>,
}

impl<'a> MultiPositionData<'a> {
    /// Samples at a steady rate.
    pub fn new(outputs: [&'a [f64]; 3], rate: f64, unit: Unit) -> Self {
        Self {
            outputs,
            time: None,
            rate,
            breaks: &[],
            unit,
            temperature: None,
            segments: None,
            readings: None,
            tumble: false,
            findings: &[],
            name: "the recording",
            columns: None,
        }
    }
}

impl Job for MultiPositionJob {
    type Data<'a> = MultiPositionData<'a>;
    type Outcome = MultiPositionOutcome;

    fn evaluate(
        &self,
        data: &MultiPositionData<'_>,
        watch: &dyn Watch,
    ) -> Result<MultiPositionOutcome> {
        watch.step("standstills", 0, 1)?;
        let settings = self.settings(data)?;
        let [x, y, z] = data.outputs;
        let steady: Vec<f64>;
        let time = match data.time {
            Some(time) => time,
            None => {
                steady = (0..x.len()).map(|i| i as f64 / data.rate).collect();
                &steady
            }
        };
        let mut samples = Samples::new(x, y, z)?;
        if data.readings.is_none() || data.time.is_some() {
            samples = samples.at_times(time)?;
        }
        let samples = match data.temperature {
            Some(temperature) => samples.at_temperatures(temperature)?,
            None => samples,
        };
        let calibration = self.calibrate(data, &samples, &settings, watch)?;
        watch.step("fit", 1, 3)?;
        let findings = self.findings(data, &samples, &calibration);
        let searched = calibration.sweep.threshold.is_some();
        let windowed = searched
            .then(|| {
                let search = Standstill {
                    window: calibration.sweep.window.unwrap_or(self.search.window),
                    ..self.search
                };
                WindowedVariance::new(&samples, data.rate, data.breaks, &search).ok()
            })
            .flatten();
        let figures = Figures::new(data, windowed.as_ref(), &calibration);
        watch.step("fit", 2, 3)?;
        let models = calibration.fit.models(&settings);
        watch.step("fit", 3, 3)?;
        Ok(MultiPositionOutcome::new(
            self,
            data,
            calibration,
            findings,
            figures,
            models,
        ))
    }
}
