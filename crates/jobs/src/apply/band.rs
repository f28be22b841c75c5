//! A calibration over frequency as one matrix for a band, to be written out for firmware.

use super::{CompensationMethod, CompensationStream};
use crate::trouble::{Result, Trouble};
use proofmass_core::Unwatched;
use proofmass_io::{AnyCalibration, CalibrationFile};
use proofmass_uncertainty::Estimate;

/// The constant matrix of a band as a calibration, and what is to be said of it: the band, the stated error of the acceleration, the
/// delay that it leaves, and that there is no bias. Its inverse is what [`CompensationMethod::Band`] applies.
///
/// **Shapes** `band` is the lowest and the highest frequency in Hz; one frequency twice is that frequency alone.
///
/// # Errors
/// A calibration by one matrix already; one without three outputs and axes; a band that is reversed or beyond the calibrated
/// frequencies.
pub fn calibration_of_band(
    calibration: &AnyCalibration,
    band: [f64; 2],
) -> Result<(CalibrationFile, Vec<String>)> {
    let stream = CompensationStream::new(
        calibration,
        CompensationMethod::Band(band),
        None,
        &Unwatched,
    )?;
    let (AnyCalibration::FrequencyResponse(file), Some(matrix)) = (calibration, stream.band())
    else {
        return Err(Trouble::request("the calibration has no bands"));
    };
    let rows: Vec<[f64; 3]> = matrix
        .matrix
        .chunks(3)
        .filter_map(|row| row.try_into().ok())
        .collect();
    let Ok(k) = <[[f64; 3]; 3]>::try_from(rows) else {
        return Err(Trouble::request(format!(
            "the calibration is one of {} outputs and {} axes: three of each can be written out",
            file.outputs.len(),
            file.axes.len()
        ))
        .with_hint(
            "`proofmass apply --band LOW,HIGH` uses it on recordings, and prints its matrix",
        ));
    };
    let [low, high] = band;
    let at = match low == high {
        true => format!("{low} Hz"),
        false => format!("{low} Hz to {high} Hz"),
    };
    let empty = Estimate::new(Vec::new(), Vec::new())?;
    let mut one = CalibrationFile::new(
        format!("constant matrix, {at}"),
        calibration.input_unit(),
        k,
        [0.0; 3],
        empty,
    );
    one.device = file.device.clone();
    one.columns = file
        .columns
        .as_ref()
        .and_then(|c| c.clone().try_into().ok());
    one.inputs = file.inputs.clone();
    let e = matrix.error;
    let percent = |share: f64| format!("{:.3}", 100.0 * share);
    let mut notes = vec![
        format!("Constant real matrix for {at} of a calibration over frequency; outside this band nothing is stated."),
        format!(
            "Error of the acceleration at most {} % of its size (95 %): uncertainty of the calibration {} %, departure from it in the band {} %{}.",
            percent(e.stated),
            percent(e.uncertainty),
            percent(e.departure),
            e.interpolation.map_or(String::new(), |i| format!(
                ", between its frequencies {} %",
                percent(i)
            ))
        ),
        "Without a bias, which a shaker does not measure: take the mean at rest away, or filter it out.".to_owned(),
    ];
    if e.delay.abs() > 1e-9 {
        notes.push(format!(
            "The acceleration comes {:.3} us late; with that left in, the departure is {} %.",
            1e6 * e.delay,
            percent(e.departure_with_delay)
        ));
    }
    Ok((one, notes))
}
