//! How a recording outside a campaign is to be read.

use crate::Failure;
use proofmass::io::{ColumnRef, TimeUnit, Unit};
use proofmass::jobs::{ChannelReading, RecordingReading, WantedChannel};

/// Options for commands that read a recording on their own.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct RecordingArguments {
    /// Columns of the outputs (x, y and z of a triaxial sensor) by name or number (from 1) [default: those of the
    /// calibration]
    #[arg(long, value_name = "X,Y,Z", value_delimiter = ',')]
    columns: Option<Vec<String>>,
    /// Unit of these columns, where the headings do not say it: count, m/s², g, mg, V, …
    #[arg(long, value_parser = unit)]
    unit: Option<Unit>,
    /// Time column by name or number
    #[arg(long, value_name = "COLUMN")]
    time: Option<String>,
    /// Unit of the time column, where the heading does not say it: s, ms, us, ns
    #[arg(long, value_name = "UNIT", requires = "time", value_parser = time_unit)]
    time_unit: Option<TimeUnit>,
    /// Sampling rate in hertz, for recordings without a time column
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
}

impl RecordingArguments {
    /// What a job needs of them.
    pub(crate) fn reading(&self) -> RecordingReading {
        let mut reading = RecordingReading::default();
        reading.columns = self.columns.as_ref().map(|names| {
            let names = names.iter().map(|name| ColumnRef::from_word(name.trim()));
            names.collect()
        });
        reading.unit = self.unit;
        reading.time = self.time.as_deref().map(ColumnRef::from_word);
        reading.time_unit = self.time_unit;
        reading.rate = self.rate;
        reading
    }
}

impl RecordingArguments {
    /// What a job of one channel needs of them.
    pub(crate) fn one_channel(&self) -> Result<(ChannelReading, WantedChannel), Failure> {
        let Some([column]) = self.columns.as_deref() else {
            return Err(Failure::new("one column is turned back at a time")
                .hint("name it with --columns COLUMN"));
        };
        let mut reading = ChannelReading::default();
        reading.time = self.time.as_deref().map(ColumnRef::from_word);
        reading.time_unit = self.time_unit;
        reading.rate = self.rate;
        let wanted = WantedChannel {
            column: ColumnRef::from_word(column.trim()),
            unit: self.unit,
        };
        Ok((reading, wanted))
    }
}

pub(crate) fn unit(text: &str) -> Result<Unit, String> {
    Unit::recognise(text)
        .ok_or_else(|| format!("{text:?} is no known unit (count, m/s², g, mg, µg, V, mV)"))
}

pub(crate) fn time_unit(text: &str) -> Result<TimeUnit, String> {
    match text {
        "s" => Ok(TimeUnit::Second),
        "ms" => Ok(TimeUnit::Millisecond),
        "us" | "µs" => Ok(TimeUnit::Microsecond),
        "ns" => Ok(TimeUnit::Nanosecond),
        _ => Err(format!("{text:?} is no unit of time (s, ms, us, ns)")),
    }
}
