//! The table of a required shock response spectrum.

use crate::trouble::{Result, Trouble};
use proofmass_io::sheet::{ACCELERATION, FREQUENCY, Sheet};
use proofmass_io::{Input, Source};

/// Reads columns `frequency_Hz` and `acceleration_m/s2` (or `_g`): points of a spectrum, straight in the logarithms between them.
///
/// # Errors
/// As the table says, with line and column; frequencies that do not ascend, fewer than two points.
pub fn required_spectrum(source: Source) -> Result<(Vec<(f64, f64)>, Input)> {
    let name = source.name().display().to_string();
    let mut sheet = Sheet::from_source(source, "required spectrum")?;
    let frequency = sheet.quantity("frequency", FREQUENCY)?;
    let acceleration = sheet.quantity("acceleration", ACCELERATION)?;
    sheet.finish()?;
    let frequency = sheet.required(frequency, "frequency_Hz")?;
    let acceleration = sheet.required(acceleration, "acceleration_m/s2")?;
    let mut points: Vec<(f64, f64)> = Vec::new();
    for row in sheet.rows() {
        let point = (row.positive(frequency)?, row.positive(acceleration)?);
        if points.last().is_some_and(|last| last.0 >= point.0) {
            return Err(row
                .refuse(frequency, "the frequencies do not ascend")
                .with_hint("one line for each frequency, in order")
                .into());
        }
        points.push(point);
    }
    if points.len() < 2 {
        return Err(
            Trouble::data(format!("{name} has fewer than two points of a spectrum"))
                .with_hint("at least its lowest and its highest frequency"),
        );
    }
    Ok((points, sheet.input.clone()))
}
