//! Frequency responses between the mathematics and their files.

use crate::campaign::Certificate;
use crate::record::Record;
use crate::trouble::Result;
use proofmass_calibration::FrequencyResponse;
use proofmass_io::{AnyCalibration, FrequencyResponseFile, Input, Source, Unit};
use proofmass_uncertainty::Finding;

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

/// A calibration of any kind: a calibration.json, or the table of a laboratory (`.csv`) as one over frequency.
///
/// `coverage` is the factor k of expanded uncertainties in such a table, where it has no column of it.
///
/// # Errors
/// As [`AnyCalibration::from_source`] and [`Certificate::from_source`].
pub fn read_calibration(
    source: Source,
    coverage: Option<f64>,
) -> Result<(AnyCalibration, Input, Vec<Finding>)> {
    let table = source
        .name()
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("csv"));
    if !table {
        let (calibration, input) = AnyCalibration::from_source(source)?;
        return Ok((calibration, input, Vec::new()));
    }
    let certificate = Certificate::from_source(source, coverage, None)?;
    let response = FrequencyResponse::try_from(&certificate.table)?;
    let record = Record {
        inputs: vec![certificate.input.clone()],
        ..Record::default()
    };
    let file = to_file(&response, "certificate", Unit::Volt, &record);
    Ok((file.into(), certificate.input, certificate.findings))
}

/// The response of a file.
///
/// ```
/// use proofmass_calibration::FrequencyResponse;
/// use proofmass_calibration::shaker::reference::{ReferencePoint, ReferenceTable};
/// use proofmass_io::{FrequencyResponseFile, Unit};
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
