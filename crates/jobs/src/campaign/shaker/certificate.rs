//! `reference.csv` or `calibration.json`: what is known of the reference standard over frequency.

use crate::campaign::CampaignFile;
use crate::device_output::DeviceOutput;
use crate::findings;
use crate::frequency_response::{ResponseDocument, read_document};
use crate::laboratory_table::{LaboratoryTable, is_table};
use crate::trouble::{Result as JobResult, Trouble};
use proofmass_dynamic::model::{FitProblem, ModelStructure, ResponsePoints};
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_io::{Error, ErrorKind, Input, Result, Source};
use proofmass_uncertainty::{Finding, Severity};
use serde::Deserialize;

/// `[reference]`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CertificateTable {
    /// The table of a laboratory (`.csv`), a digital calibration certificate (`.xml`), a calibration.json or a result.json, relative to the
    /// campaign.
    #[serde(alias = "certificate")]
    pub(crate) file: String,
    /// Coverage factor of the columns `U_…`.
    pub(crate) k: Option<f64>,
    /// Which standard it is and who calibrated it, for the report.
    pub(crate) description: Option<String>,
    /// Axis of a calibration of several, such as `z`: what output and acceleration along it have to do with each other.
    pub(crate) axis: Option<String>,
    /// Elements of a model that stands for the points, such as `1mode+delay`.
    pub(crate) model: Option<String>,
    /// Number of a certificate that is taken although nobody checked its signature.
    pub(crate) accept_unchecked_signature: Option<String>,
}

/// How a calibration over frequency is read as that of a reference standard.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct CertificateOptions {
    /// Coverage factor of expanded uncertainties in a table.
    pub coverage: Option<f64>,
    /// Axis of a calibration of several.
    pub axis: Option<String>,
    /// Model that is fitted and stands for the points.
    pub model: Option<ModelStructure>,
    /// Which standard it is and who calibrated it.
    pub description: Option<String>,
    /// What the device gives: a reference of a campaign is a channel in volts.
    pub output: DeviceOutput,
    /// Number of a certificate that is taken although nobody checked its signature.
    pub accept_unchecked_signature: Option<String>,
}

/// The certificate of the reference standard.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Certificate {
    /// Path and digest.
    pub input: Input,
    /// Which standard it is.
    pub(crate) description: Option<String>,
    /// Sensitivity against frequency.
    pub table: ReferenceTable,
    /// What it does not say.
    pub findings: Vec<Finding>,
}

impl Certificate {
    /// That of the reference, where `[reference]` names one.
    pub(crate) fn of_reference(
        source: &CampaignFile,
        table: Option<&CertificateTable>,
    ) -> Result<Option<Self>> {
        let read = |table| Self::read_as(source, "reference", table, DeviceOutput::Volt);
        table.map(read).transpose()
    }

    /// The calibration of a device with this output, named by this section of the campaign.
    pub(crate) fn read_as(
        source: &CampaignFile,
        section: &str,
        table: &CertificateTable,
        output: DeviceOutput,
    ) -> Result<Self> {
        if let Some(k) = table.k
            && !(1.0..=5.0).contains(&k)
        {
            return Err(source
                .refuse(
                    section,
                    "k",
                    format!("a coverage factor of {k} is out of range: from 1 to 5"),
                )
                .with_hint(
                    "certificates state k = 2 for 95 %; leave it out for standard uncertainties",
                ));
        }
        let model = table.model.as_deref().map(str::parse).transpose();
        let model = model.map_err(|what: String| {
            source
                .refuse(section, "model", what)
                .with_hint("elements joined by +: 1mode … 4modes, high-pass, delay, low-pass=ORDER")
        })?;
        let options = CertificateOptions {
            coverage: table.k,
            axis: table.axis.clone(),
            model,
            description: table.description.clone(),
            output,
            accept_unchecked_signature: table.accept_unchecked_signature.clone(),
        };
        Self::from_document(source.source(&table.file)?, &options).map_err(|trouble| {
            let mut what = trouble.to_string();
            for place in trouble.place() {
                what = format!("{what} ({place})");
            }
            let error = Error::new(ErrorKind::Format, what);
            match trouble.hint() {
                Some(hint) => error.with_hint(hint),
                None => error,
            }
        })
    }

    /// Reads a calibration over frequency as that of a device with the output asked for: a calibration.json, the
    /// result.json of a calibration or test that gives one, or the table of a laboratory (`.csv`).
    ///
    /// # Errors
    /// As [`Certificate::from_source`] and [`read_document`]; an axis that is not there or not named, a response in another unit
    /// than that output per m/s², a model that the points do not determine.
    pub fn from_document(source: Source, options: &CertificateOptions) -> JobResult<Self> {
        if is_table(source.name()) && options.model.is_none() {
            return Ok(Self::from_source(source, options)?);
        }
        let name = source.name().display().to_string();
        let document = read_document(source, options.coverage)?;
        if let Some(unchecked) = document.findings.iter().find(|f| f.code() == UNCHECKED) {
            return Err(Trouble::data(unchecked.what().to_owned()).with_hint(
                "take its points as they are, without `model`, and accept the certificate by its number",
            ));
        }
        let scale = scale(document.response.unit(), options.output).ok_or_else(|| {
            Trouble::data(format!(
                "{name} is a calibration in {}, not in {}",
                document.response.unit(),
                options.output.unit()
            ))
            .with_hint(hint(options.output))
        })?;
        let (output, axis) = element(&document, options.axis.as_deref(), &name)?;
        let response = &document.response;
        let about = |e: proofmass_core::Error| Trouble::from(e).detail(&name);
        let mut findings = document.findings.clone();
        let reference = match options.model {
            Some(structure) => {
                let points = ResponsePoints::of_response(response, output, axis).map_err(about)?;
                let fit = FitProblem::new(structure)
                    .fit(&points)
                    .map_err(|e| about(e).about("the model of the reference"))?;
                findings.extend(fit.findings.iter().cloned());
                ReferenceTable::of_model(&fit, scale).map_err(about)?
            }
            None => {
                if response.series().shared().is_none() {
                    findings.push(correlation_unknown(&name));
                }
                ReferenceTable::of_response(response, output, axis, scale).map_err(about)?
            }
        };
        let device = [
            &document.device.manufacturer,
            &document.device.model,
            &document.device.serial,
        ];
        let device: Vec<&str> = device.into_iter().flatten().map(String::as_str).collect();
        Ok(Self {
            input: document.input,
            description: options
                .description
                .clone()
                .or_else(|| (!device.is_empty()).then(|| device.join(" "))),
            table: reference,
            findings,
        })
    }

    /// Reads the table of a laboratory: `frequency_Hz`, `sensitivity_V/(m/s2)`, `phase_deg` where it is known, and
    /// standard (`u_relative_%`, `u_phase_deg`) or expanded uncertainties (`U_…`, with `k` or a column of it); or a digital
    /// calibration certificate (`.xml`).
    ///
    /// # Errors
    /// A signature that nobody checked, unless its certificate is accepted by its number; a missing column, an expanded uncertainty without its coverage factor, a row that cannot be.
    pub fn from_source(source: Source, options: &CertificateOptions) -> Result<Self> {
        let path = source.name().to_path_buf();
        let LaboratoryTable {
            input,
            output,
            table,
            phase_stated,
            findings: mut list,
            description,
            signed,
        } = LaboratoryTable::from_source(source, options.coverage, options.axis.as_deref())?;
        if let Some(number) =
            signed.filter(|n| options.accept_unchecked_signature.as_ref() != Some(n))
        {
            return Err(Error::new(
                ErrorKind::Format,
                "the certificate has a signature that this program does not check: a value may have been changed after it was signed",
            )
            .at(&path)
            .with_hint(format!(
                "check it with the program of the laboratory, then accept it by its number: --accept-unchecked-signature {number} (`accept_unchecked_signature = {number:?}` beside the name of the file in a campaign)"
            )));
        }
        if output != options.output {
            return Err(Error::new(
                ErrorKind::Format,
                format!("the certificate is in {}", output.unit()),
            )
            .at(&path)
            .with_hint(hint(options.output)));
        }
        if !phase_stated {
            list.push(
                findings::phase_not_stated(
                    &path.display().to_string(),
                    "phases are relative to that of the reference",
                )
                .at(Severity::Note),
            );
        }
        Ok(Self {
            input,
            description: options.description.clone().or(description),
            table,
            findings: list,
        })
    }
}

/// Finding on a signature that nobody checked.
const UNCHECKED: &str = "signature-not-checked";

fn hint(output: DeviceOutput) -> &'static str {
    match output {
        DeviceOutput::Volt => {
            "the runs give volts of it: a column `sensitivity_V/(m/s2)` or `sensitivity_mV/g`"
        }
        DeviceOutput::Acceleration => {
            "the runs give its acceleration: a column `sensitivity_(m/s2)/(m/s2)`"
        }
        DeviceOutput::Count => "the runs give its counts: a column `sensitivity_count/(m/s2)`",
    }
}

/// Factor from a unit to the one of an output.
fn scale(unit: &str, output: DeviceOutput) -> Option<f64> {
    if unit == output.unit() {
        return Some(1.0);
    }
    match (output, unit.strip_suffix("/(m/s²)")?) {
        (DeviceOutput::Volt, "mV") => Some(1e-3),
        (DeviceOutput::Volt, "µV") => Some(1e-6),
        _ => None,
    }
}

/// Output and axis of a calibration.
fn element(
    document: &ResponseDocument,
    axis: Option<&str>,
    name: &str,
) -> JobResult<(usize, usize)> {
    let (outputs, axes) = (document.response.outputs(), document.response.axes());
    let Some(axis) = axis else {
        if outputs.len() == 1 && axes.len() == 1 {
            return Ok((0, 0));
        }
        return Err(Trouble::request(format!(
            "{name} is a calibration of {} outputs and {} axes",
            outputs.len(),
            axes.len()
        ))
        .with_hint(format!("name the axis that was used: {}", axes.join(", "))));
    };
    let find = |names: &[String]| names.iter().position(|n| n == axis);
    match (find(outputs), find(axes)) {
        (Some(output), Some(axis)) => Ok((output, axis)),
        _ => Err(
            Trouble::request(format!("{name} has no output along an axis {axis:?}"))
                .with_hint(format!("there are {}", axes.join(", "))),
        ),
    }
}

fn correlation_unknown(name: &str) -> Finding {
    proofmass_dynamic::findings::correlation_not_stated(
        "the calibration of the reference",
        name,
        "its whole uncertainty is taken as common: at each frequency nothing changes, between frequencies nothing of it is averaged away",
    )
}
