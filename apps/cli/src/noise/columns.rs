//! Which columns of a recording are analysed, and in which unit.

use super::Noise;
use crate::Failure;
use proofmass::io::{
    ColumnRef, Layout, LayoutOptions, Recording, RecordingOptions, TimeSource, Unit,
};

/// The recording with every column as a rate in SI.
pub(super) fn read(noise: &Noise) -> Result<Recording, Failure> {
    let layout = LayoutOptions::default();
    let columns = chosen(noise, &Layout::sniff_with(&noise.recording, &layout)?)?;
    let mut recording = Recording::read(
        &noise.recording,
        &RecordingOptions {
            layout,
            columns,
            time: noise.time.as_deref().map(ColumnRef::from_word),
            time_unit: noise.time_unit,
            sampling_rate_hz: noise.rate,
            // With a scale or for integrals, --unit is not the unit of the columns as they stand.
            unit: noise.unit.filter(|_| noise.scale.is_none() && !noise.phase),
            ..RecordingOptions::default()
        },
    )?;
    let rate = rate(&recording);
    for column in &mut recording.columns {
        let (unit, factor) = conversion(noise, &column.name, column.unit)?;
        column.unit = unit;
        let factor = if noise.phase {
            column.data = column.data.windows(2).map(|w| w[1] - w[0]).collect();
            // A difference across a gap is no rate.
            for gap in recording.time.gaps() {
                column.data[gap.after_sample] = f64::NAN;
            }
            factor * rate
        } else {
            factor
        };
        if factor != 1.0 {
            column.data.iter_mut().for_each(|v| *v *= factor);
        }
    }
    Ok(recording)
}

/// The columns asked for, else every numeric one that is neither a time nor a temperature.
pub(super) fn chosen(noise: &Noise, layout: &Layout) -> Result<Vec<ColumnRef>, Failure> {
    if let Some(names) = &noise.columns {
        return Ok(names.iter().map(|n| ColumnRef::from_word(n)).collect());
    }
    let time = time(noise, layout)?;
    let is_signal = |i: &usize| {
        let other = |u: Unit| u.is_time() || matches!(u, Unit::DegreeCelsius | Unit::Kelvin);
        layout.numeric[*i] && Some(*i) != time && !layout.unit(*i).is_some_and(other)
    };
    let columns: Vec<ColumnRef> = (0..layout.columns)
        .filter(is_signal)
        .map(|i| ColumnRef::Index(i + 1))
        .collect();
    if columns.is_empty() {
        return Err(Failure::new("no column holds a signal")
            .detail(noise.recording.display().to_string())
            .hint("name the columns with --columns"));
    }
    Ok(columns)
}

/// The time column, as asked for or as its heading says.
pub(super) fn time(noise: &Noise, layout: &Layout) -> Result<Option<usize>, Failure> {
    Ok(match &noise.time {
        Some(name) => Some(layout.find(&ColumnRef::from_word(name))?),
        None => layout.time_column(),
    })
}

/// SI unit of the rate in a column, and the factor that brings its numbers there; `stated` stands in its heading.
pub(super) fn conversion(
    noise: &Noise,
    name: &str,
    stated: Option<Unit>,
) -> Result<(Option<Unit>, f64), Failure> {
    let raw = stated.is_none_or(Unit::is_raw);
    match (noise.scale, noise.unit) {
        (Some(scale), Some(unit)) => {
            if let Some(stated) = stated.filter(|_| !raw) {
                return Err(Failure::new(format!(
                    "column {name:?} is in {stated} by its heading: --scale is for raw outputs"
                ))
                .hint("remove --scale and --unit, or correct the heading"));
            }
            if !(scale.is_finite() && scale > 0.0) {
                return Err(Failure::new(format!("--scale {scale} must be positive")));
            }
            let (si, factor) = unit.si();
            Ok((Some(si), scale * factor))
        }
        (_, given) if noise.phase => Ok(match (stated.map(Unit::si), given) {
            (Some((Unit::MetrePerSecond, factor)), _) => {
                (Some(Unit::MetrePerSecondSquared), factor)
            }
            (Some((Unit::Radian, factor)), _) => (Some(Unit::RadianPerSecond), factor),
            (_, Some(unit)) => {
                let (si, factor) = unit.si();
                (Some(si), factor)
            }
            // Counts times seconds have no name.
            (_, None) => (None, 1.0),
        }),
        (_, given) => {
            if let (Some(stated), Some(given)) = (stated, given)
                && stated != given
            {
                return Err(Failure::new(format!(
                    "column {name:?} is in {stated} by its heading, in {given} by --unit"
                ))
                .hint("remove --unit, or correct the heading"));
            }
            Ok(match stated.or(given).map(Unit::si) {
                Some((si, factor)) => (Some(si), factor),
                None => (None, 1.0),
            })
        }
    }
}

/// Samples per second: the stated rate, or the mean over the steps that are not gaps, which the resolution of the
/// time stamps does not bias.
pub(super) fn rate(recording: &Recording) -> f64 {
    let time = &recording.time;
    match time.source() {
        TimeSource::Column(seconds) => {
            let missing: f64 = time.gaps().iter().map(|g| g.step_s).sum();
            let steps = seconds.len() - 1 - time.gaps().len();
            steps as f64 / (seconds[seconds.len() - 1] - seconds[0] - missing)
        }
        _ => time.rate_hz(),
    }
}
