//! The acceleration behind a device's output, from its fitted model, with the uncertainty of every sample.

mod page;

use crate::channels::{Channel, RecordedChannels};
use crate::findings;
use crate::frequency_response;
use crate::outcome::{Job, Outcome, section};
use crate::record::Record;
use crate::response::{ResponseOutcome, StoredModel};
use crate::shock::integral_unit;
use crate::stored_result::read_section;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_documents::{AnyCalibration, Device, StatedQuantity};
use proofmass_dynamic::deconvolution::{Deconvolution, Deconvolved};
use proofmass_dynamic::model::{FitProblem, ModelFit, ModelStructure, ResponsePoints};
use proofmass_dynamic::shock::PulseSearch;
use proofmass_io::{Input, LARGEST_DOCUMENT, Source, UnitRatio};
use proofmass_report::{Report, scientific};
use proofmass_signal::saturation;
use proofmass_uncertainty::{DegreesOfFreedom, Finding, Quantity, Severity};
use serde::{Deserialize, Serialize};

/// How an output is turned back.
///
/// ```
/// use proofmass_dynamic::model::{FitProblem, Mode, ModelStructure, ResponsePoints, TransducerModel};
/// use proofmass_jobs::deconvolution::{DeconvolutionData, DeconvolutionJob};
/// use proofmass_jobs::{Channel, Job, Outcome, Unwatched};
/// use proofmass_signal::PulseShape;
///
/// // 0.02 V/(m/s²) and a mass at 900 Hz, from points of its response.
/// let mode = Mode { frequency: 900.0, damping: 0.3, share: 1.0 };
/// let model = TransducerModel { modes: vec![mode], ..TransducerModel::flat(0.02) };
/// let frequency: Vec<f64> = (1..=40).map(|k| 40.0 * f64::from(k)).collect();
/// let response: Vec<_> = frequency.iter().map(|f| model.response(*f)).collect();
/// let modulus: Vec<f64> = response.iter().map(|s| s.norm()).collect();
/// let phase: Vec<f64> = response.iter().map(|s| s.arg()).collect();
/// let u: Vec<f64> = modulus.iter().map(|m| 1e-3 * m).collect();
/// let points = ResponsePoints::polar(frequency, &modulus, &u, &phase, &[1e-3; 40], "V/(m/s²)")?;
/// let fit = FitProblem::new(ModelStructure::modes(1)).fit(&points)?;
///
/// // Half a sine of 11 ms is slow for it: the output is the acceleration over the sensitivity.
/// let pulse = PulseShape::HalfSine.record(500.0, 0.011, 0.1, 6000, 20e3);
/// let noisy = pulse.iter().enumerate().map(|(k, a)| 0.02 * a + 1e-4 * (7.3 * k as f64).sin());
/// let record: Vec<f64> = noisy.collect();
/// let data = DeconvolutionData {
///     fit: &fit,
///     unit: "V/(m/s²)",
///     channel: Channel { name: "u", unit: "V", data: &record },
///     rate: 20e3,
///     findings: &[],
///     name: "pulse",
/// };
/// let outcome = DeconvolutionJob::default().evaluate(&data, &Unwatched)?;
/// let peak = &outcome.quantities()[0];
/// assert!((peak.value / 500.0 - 1.0).abs() < 0.05);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct DeconvolutionJob {
    /// Corner of the low-pass, Hz; where noise and bias together are least when `None`.
    pub corner: Option<f64>,
    /// Seconds before anything happens; up to the pulse when `None`.
    pub quiet: Option<f64>,
}

/// An output and the model of the device that gave it.
#[derive(Clone, Copy, Debug)]
pub struct DeconvolutionData<'a> {
    /// The fitted model with its covariance.
    pub fit: &'a ModelFit,
    /// Unit of the model's sensitivity, output over input.
    pub unit: &'a str,
    /// The output.
    pub channel: Channel<'a>,
    /// Samples per second.
    pub rate: f64,
    /// What reading the data found.
    pub findings: &'a [Finding],
    /// What the recording is called in messages.
    pub name: &'a str,
}

/// A fitted model and where it is from.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FittedModel {
    /// The model with its covariance.
    pub(crate) fit: ModelFit,
    /// Unit of its sensitivity, output over input.
    pub(crate) unit: String,
    /// The device.
    pub device: Device,
    /// The file.
    pub input: Input,
    /// What reading it found.
    pub(crate) findings: Vec<Finding>,
}

impl FittedModel {
    /// From the result of a test with a fitted model, or from a calibration over frequency (a calibration.json, the table of a
    /// laboratory), to which the model of this structure is fitted; the model of a result is the result's.
    ///
    /// `coverage` is the factor k of expanded uncertainties in a table.
    ///
    /// # Errors
    /// A file that is neither, a result without a model, a model that the calibration does not determine.
    pub fn read(
        source: Source,
        structure: Option<ModelStructure>,
        coverage: Option<f64>,
    ) -> Result<Self> {
        let name = source.name().to_path_buf();
        let place = name.display().to_string();
        let (bytes, input) = source.into_bytes(LARGEST_DOCUMENT)?;
        let stored = read_section::<Option<StoredModel>>(
            &bytes,
            ResponseOutcome::KIND,
            StoredModel::SECTION,
        );
        if let Ok((stored, document)) = stored {
            let Some(model) = stored else {
                return Err(Trouble::data(format!("{place} holds no fitted model"))
                    .with_hint("evaluate it again with --model 1mode"));
            };
            return Ok(Self {
                fit: model.fit,
                unit: model.unit,
                device: document.device,
                input,
                findings: Vec::new(),
            });
        }
        let (calibration, _, findings) =
            frequency_response::read_calibration(Source::from_bytes(name, bytes)?, coverage)?;
        let AnyCalibration::FrequencyResponse(file) = calibration else {
            return Err(Trouble::data(format!("{place} is no frequency response")).with_hint(
                "give the result.json of a test with a fitted model, or a calibration over frequency",
            ));
        };
        let response = frequency_response::of_file(&file)?;
        let named =
            |e: proofmass_core::Error| Trouble::from(e).about("the model").detail(place.clone());
        let points = ResponsePoints::of_response(&response, 0, 0).map_err(named)?;
        let fit = FitProblem::new(structure.unwrap_or_default())
            .fit(&points)
            .map_err(named)?;
        Ok(Self {
            fit,
            unit: points.unit,
            device: file.device,
            input,
            findings,
        })
    }
}

impl DeconvolutionJob {
    /// What is behind the first channel of a recording.
    ///
    /// # Errors
    /// As [`Job::evaluate`]; a recording of no channel.
    pub fn evaluate_recording(
        &self,
        model: &FittedModel,
        recording: &RecordedChannels,
        watch: &dyn Watch,
    ) -> Result<DeconvolutionOutcome> {
        let Some(channel) = recording.channels.first() else {
            return Err(Trouble::data("no column was chosen").with_hint("add --column COLUMN"));
        };
        let findings = [&model.findings[..], &recording.findings].concat();
        let data = DeconvolutionData {
            fit: &model.fit,
            unit: &model.unit,
            channel: channel.view(),
            rate: recording.rate,
            findings: &findings,
            name: &recording.name,
        };
        let inputs = [model.input.clone(), recording.input.clone()];
        self.answer(&data, &inputs, watch)
    }
}

/// Samples of which every one is filed.
const MOST: usize = 1 << 20;

impl Job for DeconvolutionJob {
    type Data<'a> = DeconvolutionData<'a>;
    type Outcome = DeconvolutionOutcome;

    fn evaluate(
        &self,
        data: &DeconvolutionData<'_>,
        watch: &dyn Watch,
    ) -> Result<DeconvolutionOutcome> {
        watch.step("inverse filter", 0, 1)?;
        // Output over input; a pure number is one of two accelerations.
        let unit = match data.unit.parse::<UnitRatio>() {
            Ok(ratio) if ratio.over.to_string() == data.channel.unit => ratio.under.to_string(),
            _ if data.unit == "1" && data.channel.unit == "m/s²" => data.channel.unit.to_owned(),
            _ => {
                let hint = match data.unit {
                    "1" => {
                        "fit the model with the unit of its modulus: proofmass test model TABLE … --unit V/(m/s2)"
                    }
                    _ => "state the unit of the column with --unit, or name another column",
                };
                return Err(Trouble::data(format!(
                    "column {:?} is in {}, the model's sensitivity in {}",
                    data.channel.name, data.channel.unit, data.unit
                ))
                .detail(data.name)
                .with_hint(hint));
            }
        };
        let record = data.channel.data;
        if record.len() > MOST {
            return Err(Trouble::data(format!(
                "{} samples: a record of at most {MOST} is turned back sample by sample",
                record.len()
            ))
            .detail(data.name)
            .with_hint("cut it to the motion and a quiet interval before it"));
        }
        let named = |e: proofmass_core::Error| Trouble::from(e).detail(data.name);
        let pulse = PulseSearch::default().find(record).map_err(named)?;
        let quiet =
            match (self.quiet, &pulse) {
                (Some(seconds), pulse) => {
                    let quiet = (seconds * data.rate).max(0.0) as usize;
                    let begin = pulse.as_ref().ok().map(|p| p.start.unwrap_or(0.0));
                    if let Some(begin) = begin.filter(|begin| quiet as f64 > *begin) {
                        return Err(Trouble::data(format!(
                            "the first {seconds} s are not quiet: a pulse begins at {:.6} s",
                            begin / data.rate
                        ))
                        .detail(data.name)
                        .with_hint("say how long nothing happens before it (--quiet SECONDS)"));
                    }
                    quiet
                }
                (None, Ok(pulse)) => pulse.quiet,
                (None, Err(_)) => {
                    return Err(Trouble::data(
                        "no pulse is found, and so no quiet interval before it",
                    )
                    .detail(data.name)
                    .with_hint("say how long nothing happens at the beginning (--quiet SECONDS)"));
                }
            };
        let mut method = Deconvolution::default();
        method.corner = self.corner;
        method.quiet = quiet;
        let fit = data.fit;
        let result = method
            .apply(&fit.model, &fit.problem.structure, &fit.estimate, record, data.rate)
            .map_err(|e| {
                named(e).with_hint(
                    "a model without high-pass and an interval of at least 32 quiet samples are needed",
                )
            })?;
        watch.step("inverse filter", 1, 1)?;
        let mut findings = data.findings.to_vec();
        findings.extend(fit.findings.iter().cloned());
        let consequence = "what was cut off is not in the acceleration either";
        findings.extend(saturation::clipped(data.name, record, consequence));
        let top = result.top;
        let highest = fit.residuals.iter().map(|r| r[0]).fold(0.0, f64::max);
        if result.corner > 1.05 * highest {
            findings.push(
                proofmass_dynamic::findings::model_extrapolated(
                    "the corner of the inverse",
                    result.corner,
                    highest,
                    "measure the response at higher frequencies, or set the corner (--corner)",
                )
                .at(Severity::Warning),
            );
        }
        let plain = method.plain(fit.model.sensitivity, record);
        let peak = result.value[top].abs();
        let greatest = plain.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let u = result.standard_uncertainty[top];
        // What the low-pass may have removed is stated with its own warning.
        let blurred = result.noise.hypot(result.model);
        // Below its resonances a device answers a motion by twice its greatest value at most.
        let slowest = fit.model.modes.iter().map(|m| m.frequency);
        let below = result.corner < slowest.fold(f64::INFINITY, f64::min);
        if !(peak > 4.0 * blurred) || (below && 2.0 * (peak + 2.0 * u) < greatest) {
            return Err(Trouble::data(format!(
                "the low-pass of {} Hz removes the peak: {} with U = {} is left, where the output divided by the static sensitivity reaches {}",
                scientific(result.corner, 4),
                scientific(peak, 4),
                scientific(2.0 * u, 2),
                scientific(greatest, 4)
            ))
            .detail(data.name)
            .with_hint(
                "cut the record to the motion and the quiet before it, set the corner (--corner), or take the plain reading of `test shock`",
            ));
        }
        if result.regularisation > 0.1 * result.value[top].abs() {
            findings.push(findings::little_is_left(
                result.regularisation,
                result.value[top].abs(),
            ));
        }
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        Ok(DeconvolutionOutcome {
            request: *self,
            rate: data.rate,
            unit,
            result,
            plain,
            findings,
        })
    }
}

/// The answer.
#[derive(Clone, Debug, PartialEq)]
pub struct DeconvolutionOutcome {
    request: DeconvolutionJob,
    rate: f64,
    unit: String,
    result: Deconvolved,
    plain: Vec<f64>,
    findings: Vec<Finding>,
}

impl DeconvolutionOutcome {
    /// Value and uncertainty of every sample.
    pub fn deconvolved(&self) -> &Deconvolved {
        &self.result
    }

    /// The output over the static sensitivity, as one reads it without a model.
    pub fn plain(&self) -> &[f64] {
        &self.plain
    }

    fn peak(&self) -> Quantity {
        let at = |list: &[f64]| list.get(self.result.top).copied().unwrap_or(0.0);
        let u = at(&self.result.standard_uncertainty);
        quantity("peak", &self.unit, at(&self.result.value), u)
    }

    fn duration(&self) -> Option<Quantity> {
        let read = self.result.duration?;
        Some(quantity(
            "duration",
            "s",
            read.value,
            read.standard_uncertainty(),
        ))
    }

    fn velocity_change(&self) -> Option<Quantity> {
        let read = self.result.velocity_change?;
        let unit = integral_unit(&self.unit);
        Some(quantity(
            "velocity_change",
            &unit,
            read.value,
            read.standard_uncertainty(),
        ))
    }
}

fn quantity(name: &str, unit: &str, value: f64, standard_uncertainty: f64) -> Quantity {
    Quantity {
        name: name.into(),
        unit: unit.into(),
        value,
        standard_uncertainty,
        dof: DegreesOfFreedom::INFINITE,
    }
}

impl Outcome for DeconvolutionOutcome {
    const KIND: &'static str = "deconvolution";

    fn title(&self, record: &Record) -> String {
        record.title("Input of", "Input behind an output")
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        let others = [self.duration(), self.velocity_change()];
        std::iter::once(self.peak())
            .chain(others.into_iter().flatten())
            .map(|q| StatedQuantity::new(&q, 0.95))
            .collect()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![section("corner_Hz", &self.result.corner)?])
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }
}
