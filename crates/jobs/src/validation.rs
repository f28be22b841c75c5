//! Does a calibration hold on standstills it was not made from?

mod averages;
mod page;
mod recording;

pub use recording::ValidationRecording;

use crate::findings;
use crate::outcome::{Job, Outcome, section};
use crate::record::{Record, read_gravity};
use crate::standstills::found;
use crate::trouble::{Result, Trouble};
use proofmass_core::{Gravity, Matrix3, SensorModel, Watch};
use proofmass_documents::{CalibrationFile, StatedQuantity};
use proofmass_io::ReadGravity;
use proofmass_report::Report;
use proofmass_static::{
    Calibrated, MeanNoise, NominalOutput, Samples, Segment, Standstill, Validation,
};
use proofmass_uncertainty::{Estimate, Finding};
use serde::{Deserialize, Serialize};

/// How new standstills are looked for, and where they were recorded.
///
/// ```
/// use proofmass_static::{MultiPosition, Samples, Standstill, StandstillCalibration};
/// use proofmass_core::Gravity;
/// use proofmass_documents::CalibrationFile;
/// use proofmass_io::Unit;
/// use proofmass_jobs::validation::{ValidationData, ValidationJob};
/// use proofmass_jobs::{Job, Unwatched};
/// use proofmass_rig::HandHeld;
///
/// // Calibrated on one recording, validated on another.
/// let gravity = Gravity::given(9.80665, 1e-5)?;
/// let first = HandHeld::default().simulate(1);
/// let [x, y, z] = &first.outputs;
/// let settings = MultiPosition::new(gravity);
/// let search = Standstill::default();
/// let fit = StandstillCalibration::run(&Samples::new(x, y, z)?, first.rate, &[], &search, &settings)?.fit;
/// let (k, b) = (fit.model().k().0, fit.model().bias());
/// let calibration = CalibrationFile::new("triangular", Unit::Count, k, b, fit.estimate().clone());
/// let second = HandHeld::default().simulate(2);
/// let [x, y, z] = &second.outputs;
/// let mut job = ValidationJob::default();
/// job.gravity = Some(gravity);
/// let data = ValidationData {
///     calibration: &calibration, outputs: [x, y, z], rate: second.rate, breaks: &[], segments: None,
///     findings: &[], sha256: None, name: "the second recording",
/// };
/// let outcome = job.evaluate(&data, &Unwatched)?;
/// assert!(outcome.validation().attitudes.iter().all(|a| a.within_rule));
/// // Counts with one scale and one zero for all axes are off by some per cent of g, compensated by some hundredths of a per cent.
/// assert!(outcome.validation().reduction_percent().is_some_and(|r| r > 95.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ValidationJob {
    /// Largest windowed variance of a standstill in multiples of the noise floor.
    pub threshold: f64,
    /// Local gravity where it is not that of the calibration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Gravity>,
    /// How standstills are found where none are given.
    #[serde(default)]
    pub search: Standstill,
    /// Nominal output per m/s² and output at no acceleration of an uncompensated sensor, in the unit of its outputs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nominal: Option<[f64; 2]>,
}

impl Default for ValidationJob {
    fn default() -> Self {
        Self {
            threshold: 6.0,
            gravity: None,
            search: Standstill::default(),
            nominal: None,
        }
    }
}

/// A calibration and a recording of the same sensor.
#[derive(Clone, Debug)]
pub struct ValidationData<'a> {
    /// The calibration.
    pub calibration: &'a CalibrationFile,
    /// Outputs x, y, z in the input unit of the calibration; that of a single axis three times.
    pub outputs: [&'a [f64]; 3],
    /// Samples per second.
    pub rate: f64,
    /// Samples before which time pauses, in increasing order.
    pub breaks: &'a [usize],
    /// Standstills that are given; without them they are found.
    pub segments: Option<&'a [Segment]>,
    /// What reading the data found.
    pub findings: &'a [Finding],
    /// Digest of the recording, to tell whether the calibration was made from it.
    pub sha256: Option<&'a str>,
    /// What the recording is called in messages.
    pub name: &'a str,
}

impl ValidationJob {
    fn standstills(
        &self,
        data: &ValidationData<'_>,
        samples: &Samples<'_>,
    ) -> Result<Vec<Segment>> {
        match data.segments {
            Some(given) => Ok(given.to_vec()),
            None => found(
                samples,
                (data.rate, data.breaks),
                (&self.search, self.threshold),
                data.name,
            ),
        }
    }

    /// Output of the uncompensated sensor: as stated; of outputs that are accelerations themselves; else the mean scale and the mean bias
    /// of its three axes, which a single axis has for itself.
    fn nominal(&self, file: &CalibrationFile) -> Result<Option<NominalOutput>> {
        if let Some([sensitivity, zero]) = self.nominal {
            if !(sensitivity != 0.0 && sensitivity.is_finite() && zero.is_finite()) {
                return Err(Trouble::request(format!(
                    "a nominal output of {sensitivity} per m/s² with {zero} at rest is out of range: both must be finite, and the sensitivity not zero"
                ))
                .with_hint("give --nominal-sensitivity in the unit of the outputs per m/s², and --nominal-zero"));
            }
            return Ok(Some(NominalOutput { sensitivity, zero }));
        }
        let mean = |of: &dyn Fn(usize) -> f64| (0..3).map(of).sum::<f64>() / 3.0;
        Ok(match (file.input_unit.is_acceleration(), file.axes()) {
            (true, _) => Some(NominalOutput {
                sensitivity: 1.0,
                zero: 0.0,
            }),
            (false, 3) => Some(NominalOutput {
                sensitivity: mean(&|i| file.k[i][i].abs()),
                zero: mean(&|i| file.b[i]),
            }),
            (false, _) => None,
        })
    }

    /// Gravity of the calibration, and that of the validation where it is another.
    fn gravities(&self, file: &CalibrationFile) -> Result<(Gravity, Option<Gravity>)> {
        let there = match (&file.gravity, self.gravity) {
            (Some(q), _) => Gravity::given(q.value, q.standard_uncertainty)?,
            (None, Some(here)) => here,
            (None, None) => {
                return Err(Trouble::request(
                    "the calibration does not say which gravity it was made with",
                )
                .with_hint("give local gravity with its uncertainty"));
            }
        };
        Ok((there, self.gravity))
    }
}

impl Job for ValidationJob {
    type Data<'a> = ValidationData<'a>;
    type Outcome = ValidationOutcome;

    fn evaluate(&self, data: &ValidationData<'_>, watch: &dyn Watch) -> Result<ValidationOutcome> {
        watch.step("comparison", 0, 2)?;
        let file = data.calibration;
        let (sensor, estimate) = as_three(file)?;
        let [x, y, z] = data.outputs;
        let samples = Samples::new(x, y, z)?;
        let segments = self.standstills(data, &samples)?;
        if segments.is_empty() {
            return Err(
                Trouble::data("no standstill was found").detail(data.name).with_hint(
                    "a standstill takes two seconds or more; raise the threshold, or give the standstills",
                ),
            );
        }
        watch.step("comparison", 1, 2)?;
        let noise = MeanNoise::estimate(&samples, &segments)?;
        let (gravity, here) = self.gravities(file)?;
        let calibrated = Calibrated {
            sensor: &sensor,
            estimate: &estimate,
            gravity,
            repeatability: file.repeatability.unwrap_or(0.0),
            nominal: self.nominal(file)?,
        };
        let mut poses = noise.poses(&samples, &segments);
        if file.curvature.is_some() || file.axes() == 1 {
            let compensation = file.compensation()?;
            // As a sensor without curvature would have read it, and without what it does not see.
            for pose in &mut poses {
                let outputs = pose.mean.each_ref().map(std::slice::from_ref);
                let a = compensation
                    .apply_columns(&outputs[..file.axes()], None)
                    .concat();
                let a = std::array::from_fn(|i| a.get(i).copied().unwrap_or(0.0));
                pose.mean = sensor.invert(a);
            }
        }
        let validation = Validation::run(&calibrated, here, &poses)?;
        let mut findings = data.findings.to_vec();
        findings.extend(validation.findings.iter().cloned());
        if file.inputs.iter().any(|i| data.sha256 == Some(&i.sha256)) {
            findings.push(findings::same_recording());
        }
        findings.extend(findings::taken_at_reference(file));
        if file.estimate.components().is_empty() {
            findings.push(findings::calibration_without_uncertainty());
        }
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        watch.step("comparison", 2, 2)?;
        Ok(ValidationOutcome {
            model: file.model.clone(),
            gravity: match here {
                Some(here) => read_gravity(here, "as stated"),
                None => read_gravity(gravity, "that of the calibration"),
            },
            findings,
            before: match (self.nominal, file.input_unit.is_acceleration()) {
                (Some(_), _) => "by the nominal output",
                (None, true) => "uncompensated",
                (None, false) => "one scale and one zero of all axes",
            },
            validation,
        })
    }
}

/// Linear model and estimate of three axes. One axis at rest up or down reads all of gravity, as the first of three of which the others
/// read nothing.
fn as_three(file: &CalibrationFile) -> Result<(SensorModel<f64>, Estimate)> {
    if file.axes() != 1 {
        return Ok((file.sensor()?, file.estimate.clone()));
    }
    let (k, b) = (file.k[0][0], file.b[0]);
    let sensor = SensorModel::new(Matrix3::diagonal([k; 3]), [b, 0.0, 0.0])?;
    let mut components = file.estimate.components().to_vec();
    for component in &mut components {
        if matches!(component.name.as_str(), "bias" | "scale") {
            component.name.push_str(".x");
        }
    }
    let influences = file.estimate.influences().to_vec();
    Ok((sensor, Estimate::new(components, influences)?))
}

/// How a calibration did on new standstills.
#[derive(Clone, Debug, PartialEq)]
pub struct ValidationOutcome {
    model: String,
    gravity: ReadGravity,
    findings: Vec<Finding>,
    /// What "before" is.
    before: &'static str,
    validation: Validation,
}

impl ValidationOutcome {
    /// The comparison itself.
    pub fn validation(&self) -> &Validation {
        &self.validation
    }
}

impl Outcome for ValidationOutcome {
    const KIND: &'static str = "validation";

    fn title(&self, record: &Record) -> String {
        record
            .title
            .clone()
            .unwrap_or_else(|| "Validation of a calibration".to_owned())
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        Vec::new()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn gravity(&self) -> Option<ReadGravity> {
        Some(self.gravity.clone())
    }

    fn model(&self) -> Option<String> {
        Some(self.model.clone())
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![section("validation", &self.validation)?])
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, &self.validation, self.before)
    }
}
