//! The channels of a dynamic test on the command line.

use crate::Failure;
use proofmass::io::{ColumnRef, Source, TimeUnit, Unit};
use proofmass::jobs::{ChannelReading, RecordedChannels, WantedChannel};
use std::path::Path;

/// Clock of the recording.
#[derive(clap::Args)]
pub(super) struct ClockArguments {
    /// Time column by name or number [default: the one that is named as a time]
    #[arg(long, value_name = "COLUMN")]
    time: Option<String>,
    /// Unit of the time column, where the heading does not say it: s, ms, us, ns
    #[arg(long, value_name = "UNIT", requires = "time")]
    time_unit: Option<TimeUnit>,
    /// Sampling rate in hertz [default: that of the time stamps]
    #[arg(long, value_name = "HZ", value_parser = positive)]
    rate: Option<f64>,
}

impl ClockArguments {
    pub(super) fn reading(&self) -> ChannelReading {
        let mut reading = ChannelReading::default();
        reading.time = self.time.as_deref().map(ColumnRef::from_word);
        reading.time_unit = self.time_unit;
        reading.rate = self.rate;
        reading
    }
}

/// The one channel of a recording.
#[derive(clap::Args)]
pub(super) struct ChannelArguments {
    /// Column of the sensor, by name or number (from 1)
    #[arg(long, value_name = "COLUMN")]
    column: String,
    /// Its unit, where the heading does not say it
    #[arg(long, value_name = "UNIT")]
    unit: Option<Unit>,
    #[command(flatten)]
    clock: ClockArguments,
}

impl ChannelArguments {
    /// The recording with that channel alone.
    pub(super) fn read(&self, path: &Path) -> Result<RecordedChannels, Failure> {
        let wanted = [wanted(&self.column, self.unit)];
        Ok(self.clock.reading().read(Source::open(path)?, &wanted)?)
    }
}

/// A column with a unit that may be stated.
pub(super) fn wanted(column: &str, unit: Option<Unit>) -> WantedChannel {
    WantedChannel {
        column: ColumnRef::from_word(column),
        unit,
    }
}

pub(super) fn unit(text: &str) -> Result<Unit, String> {
    Unit::recognise(text)
        .ok_or_else(|| format!("{text:?} is no known unit (m/s², g, mg, N, V, mV, m/s, m, count)"))
}

pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v > 0.0 && v.is_finite() => Ok(v),
        _ => Err(format!("{text:?} is no positive number")),
    }
}

pub(crate) fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v >= 0.0 && v.is_finite() => Ok(v),
        _ => Err(format!("{text:?} is no number from zero on")),
    }
}

/// Two numbers, the second larger: `10,2000`.
pub(super) fn band(text: &str) -> Result<[f64; 2], String> {
    let refused = || format!("{text:?} is no band such as 10,2000");
    let (low, high) = text.split_once(',').ok_or_else(refused)?;
    let number = |t: &str| positive(t.trim()).map_err(|_| refused());
    let (low, high) = (number(low)?, number(high)?);
    if low < high {
        Ok([low, high])
    } else {
        Err(refused())
    }
}
