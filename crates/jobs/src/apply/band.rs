//! A calibration over frequency as one matrix for a band, to be written out for firmware.

use super::{CompensationMethod, CompensationStream};
use crate::trouble::{Result, Trouble};
use proofmass_core::Unwatched;
use proofmass_documents::{AnyCalibration, CalibrationFile};
use proofmass_dynamic::frequency_response::CompensationError;
use proofmass_io::Unit;
use proofmass_uncertainty::{Component, DegreesOfFreedom, Effect, Estimate, Evaluation, Influence};

/// The constant matrix of a band as a calibration, and what is to be said of it: the band, the stated error of the acceleration, the
/// delay that it leaves, and that there is no bias. Its inverse is what [`CompensationMethod::Band`] applies.
///
/// **Shapes** `band` is the lowest and the highest frequency in Hz; one frequency twice is that frequency alone.
///
/// # Errors
/// A calibration by one matrix already; one without three outputs and axes, or one of each; a band that is reversed or beyond the calibrated
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
    let [low, high] = band;
    let at = match low == high {
        true => format!("{low} Hz"),
        false => format!("{low} Hz to {high} Hz"),
    };
    let e = matrix.error;
    let empty = Estimate::new(Vec::new(), Vec::new())?;
    let model = format!("constant matrix, {at}");
    let unit = calibration.input_unit();
    let rows =
        |i: usize| -> Option<[f64; 3]> { matrix.matrix.get(3 * i..3 * i + 3)?.try_into().ok() };
    let mut one = match (matrix.matrix.as_slice(), [0, 1, 2].map(rows)) {
        (&[k], _) => CalibrationFile::new(model, unit, [[k]], [0.0], scale_factor(k, unit, &e)?),
        (all, [Some(x), Some(y), Some(z)]) if all.len() == 9 => {
            CalibrationFile::new(model, unit, [x, y, z], [0.0; 3], empty)
        }
        _ => {
            return Err(Trouble::request(format!(
                "the calibration is one of {} outputs and {} axes: three of each, or one, can be written out",
                file.outputs.len(),
                file.axes.len()
            ))
            .with_hint(
                "`proofmass apply --band LOW,HIGH` uses it on recordings, and prints its matrix",
            ));
        }
    };
    one.device = file.device.clone();
    one.columns = file.columns.clone();
    one.inputs = file.inputs.clone();
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
        "Without a bias, which a shaker does not measure: subtract the mean at rest, or filter it out.".to_owned(),
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

/// The scale factor of one axis with what its stated error is made of: the calibration (95 %), and what lies between its limits in
/// the band and between its frequencies.
fn scale_factor(k: f64, unit: Unit, error: &CompensationError) -> Result<Estimate> {
    let normal = DegreesOfFreedom::INFINITE.coverage_factor(0.95);
    let parts = [
        (
            "calibration",
            "uncertainty of the calibration",
            "normal",
            error.uncertainty / normal,
        ),
        (
            "band",
            "departure from the constant in the band",
            "rectangular",
            error.departure / 3f64.sqrt(),
        ),
        (
            "interpolation",
            "between the frequencies of the calibration",
            "rectangular",
            error.interpolation.unwrap_or(0.0) / 3f64.sqrt(),
        ),
    ];
    let influences = parts
        .into_iter()
        .filter(|p| p.3 > 0.0)
        .map(|(key, what, distribution, u)| Influence {
            key: key.to_owned(),
            description: what.to_owned(),
            evaluation: Evaluation::B,
            distribution: distribution.to_owned(),
            dof: DegreesOfFreedom::INFINITE,
            effect: Effect::of_zero("1", u, vec![k]),
        });
    let component = Component::new("scale", format!("{unit}/(m/s²)"), k);
    Ok(Estimate::new(vec![component], influences.collect())?)
}
