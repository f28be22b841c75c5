//! Frequency responses between the mathematics and their files.

use crate::findings;
use crate::laboratory_table::{LaboratoryTable, is_table};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_documents::{AnyCalibration, Device, FrequencyResponseFile};
use proofmass_dynamic::FrequencyResponse;
use proofmass_io::{Input, Source, Unit};
use proofmass_uncertainty::Finding;

/// Finding on a table without phases.
pub(crate) const PHASE_NOT_STATED: &str = "phase-not-stated";

/// A frequency response as a file has it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ResponseDocument {
    /// The response.
    pub response: FrequencyResponse,
    /// The device it belongs to.
    pub(crate) device: Device,
    /// Files it was computed from.
    inputs: Vec<Input>,
    /// The file with its digest.
    pub input: Input,
    /// What reading it found.
    pub findings: Vec<Finding>,
}

/// Reads a frequency response: a calibration.json of that kind, the result.json of a test or calibration that gives one, or the
/// table of a laboratory (`.csv`), whose expanded uncertainties have the factor `coverage`.
///
/// # Errors
/// As [`read_calibration`]; a result without a calibration, a calibration of another kind.
pub fn read_document(source: Source, coverage: Option<f64>) -> Result<ResponseDocument> {
    let place = source.name().display().to_string();
    let (calibration, input, findings) = read_calibration(source, coverage)?;
    let AnyCalibration::FrequencyResponse(file) = calibration else {
        return Err(Trouble::data(format!("{place} is no frequency response")).with_hint(
            "give a calibration.json of kind frequency-response, its result.json, or a certificate (.csv, .xml)",
        ));
    };
    Ok(ResponseDocument {
        response: of_file(&file)?,
        device: file.device,
        inputs: file.inputs,
        input,
        findings,
    })
}

/// Files that two calibrations were both computed from, by their digests.
pub fn files_of_both(documents: &[ResponseDocument]) -> Option<Finding> {
    let [one, other] = documents else {
        return None;
    };
    let both = |i: &&Input| other.inputs.iter().any(|o| o.sha256 == i.sha256);
    let mut names: Vec<&str> = one
        .inputs
        .iter()
        .filter(both)
        .map(|i| i.path.as_str())
        .collect();
    names.dedup();
    (!names.is_empty()).then(|| findings::files_of_both(&names.join(", ")))
}

/// Whether the documents, by these names, say that they are of several devices: serial numbers differ, or types where a serial number is not
/// stated in both.
pub fn devices_apart(documents: &[ResponseDocument], names: &[String]) -> Option<Finding> {
    let apart = |a: &Device, b: &Device| match (&a.serial, &b.serial) {
        (Some(a), Some(b)) if a != b => {
            Some((format!("serial number {a}"), format!("serial number {b}")))
        }
        (Some(_), Some(_)) | (_, None) | (None, _)
            if a.model.is_some() && b.model.is_some() && a.model != b.model =>
        {
            let of = |d: &Device| format!("type {}", d.model.as_deref().unwrap_or_default());
            Some((of(a), of(b)))
        }
        _ => None,
    };
    let (first, others) = documents.split_first()?;
    let (name, other_names) = names.split_first()?;
    let differing: Vec<_> = others
        .iter()
        .zip(other_names)
        .filter_map(|(d, n)| Some((apart(&first.device, &d.device)?, n)))
        .collect();
    let ((own, other), other_name) = differing.first()?;
    let found = findings::devices_differ(
        "differences of the calibrations are those of the devices too",
        own,
        name,
        other,
        other_name,
        differing.len(),
        "compare calibrations of one device, or correct its serial number in the campaigns",
    );
    Some(found.at(proofmass_uncertainty::Severity::Warning))
}

/// The file of a response.
pub fn to_file(
    response: &FrequencyResponse,
    model: &str,
    input_unit: Unit,
    record: &Record,
) -> FrequencyResponseFile {
    let mut file = FrequencyResponseFile::new(
        model,
        input_unit,
        response.outputs().to_vec(),
        response.axes().to_vec(),
        response.series().clone(),
    );
    file.software = record.software.clone();
    file.device = record.device.clone();
    file.inputs = record.inputs.clone();
    file
}

/// A calibration of any kind: a calibration.json, or the table of a laboratory (`.csv`, or a digital calibration certificate, `.xml`) as
/// one over frequency.
///
/// `coverage` is the factor k of expanded uncertainties in such a table, where it has no column of it.
///
/// # Errors
/// As [`AnyCalibration::from_source`]; of a table a missing column, an expanded uncertainty without its coverage factor, a row that
/// cannot be.
pub fn read_calibration(
    source: Source,
    coverage: Option<f64>,
) -> Result<(AnyCalibration, Input, Vec<Finding>)> {
    if !is_table(source.name()) {
        let (calibration, input) = AnyCalibration::from_source(source)?;
        return Ok((calibration, input, Vec::new()));
    }
    let table = LaboratoryTable::from_source(source, coverage, None)?;
    let record = Record {
        inputs: vec![table.input.clone()],
        ..Record::default()
    };
    let file = to_file(
        &table.response()?,
        "certificate",
        table.output.of_device(),
        &record,
    );
    let mut findings = table.findings;
    if !table.phase_stated {
        findings.push(findings::phase_not_stated(
            &table.input.path,
            "it is taken as zero, and delays are unknown",
        ));
    }
    Ok((file.into(), table.input, findings))
}

/// The response of a file.
///
/// ```
/// use proofmass_dynamic::FrequencyResponse;
/// use proofmass_dynamic::reference_table::{ReferencePoint, ReferenceTable};
/// use proofmass_documents::FrequencyResponseFile;
/// use proofmass_io::Unit;
/// use proofmass_jobs::{Record, frequency_response};
///
/// let line = |frequency: f64| ReferencePoint {
///     frequency, sensitivity: 0.01, phase: 0.0, modulus_uncertainty: 0.005, phase_uncertainty: 0.005,
/// };
/// let table = ReferenceTable::new(vec![line(10.0), line(1000.0)])?;
/// let response = FrequencyResponse::try_from(&table)?;
/// let file = frequency_response::to_file(&response, "certificate", Unit::Volt, &Record::default());
/// let read = FrequencyResponseFile::from_json(&file.to_json()?)?;
/// assert_eq!(frequency_response::of_file(&read)?, response);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Components of other names or in another order.
pub fn of_file(file: &FrequencyResponseFile) -> Result<FrequencyResponse> {
    Ok(FrequencyResponse::new(
        file.outputs.clone(),
        file.axes.clone(),
        file.series.clone(),
    )?)
}
