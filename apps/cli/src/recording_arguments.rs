//! How a recording outside a campaign is to be read.

use crate::Failure;
use proofmass::io::{
    CalibrationFile, Column, ColumnRef, LayoutOptions, RecordingOptions, TimeUnit, Unit,
};

/// Three columns by name or number.
#[derive(Clone, Debug)]
struct Columns([String; 3]);

fn three_columns(text: &str) -> Result<Columns, String> {
    let names: Vec<String> = text.split(',').map(|name| name.trim().to_owned()).collect();
    names
        .try_into()
        .map(Columns)
        .map_err(|_| format!("{text:?} names not three columns: write X,Y,Z, by name or number"))
}

/// Options for commands that read a recording on their own.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct RecordingArguments {
    /// Columns of x, y and z by name or number (from 1) [default: those of the calibration]
    #[arg(long, value_name = "X,Y,Z", value_parser = three_columns)]
    columns: Option<Columns>,
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
    /// The columns of the signals: as asked for, else as the calibration found them.
    pub(crate) fn signals(&self, calibration: &CalibrationFile) -> Result<Vec<ColumnRef>, Failure> {
        match (&self.columns, &calibration.columns) {
            (Some(names), _) => Ok(names
                .0
                .iter()
                .map(|name| ColumnRef::from_word(name))
                .collect()),
            (None, Some(columns)) => Ok(columns.to_vec()),
            (None, None) => Err(Failure::new(
                "the calibration does not say which columns x, y and z are",
            )
            .hint("add --columns X,Y,Z")),
        }
    }

    /// Everything a reader needs; without a calibration the columns must be named.
    pub(crate) fn options_with(
        &self,
        calibration: Option<&CalibrationFile>,
    ) -> Result<RecordingOptions, Failure> {
        if let Some(calibration) = calibration {
            return self.options(calibration);
        }
        let names = self.columns.as_ref().ok_or_else(|| {
            Failure::new("which columns are x, y and z is not known").hint("add --columns X,Y,Z")
        })?;
        Ok(self.reading_of(names.0.iter().map(|n| ColumnRef::from_word(n)).collect()))
    }

    /// The one unit of three columns: that of their headings, else of --unit.
    pub(crate) fn common_unit(&self, columns: [&Column; 3]) -> Result<Unit, Failure> {
        let mut common = self.unit;
        for column in columns {
            match (column.unit, common) {
                (Some(own), Some(unit)) if own != unit => {
                    return Err(Failure::new(format!(
                        "column {:?} is in {own}, not in {unit}",
                        column.name
                    ))
                    .hint("x, y and z need one unit; remove --unit, or correct the heading"));
                }
                (Some(own), _) => common = Some(own),
                (None, _) => {}
            }
        }
        common.ok_or_else(|| {
            Failure::new("the unit of the outputs is not known")
                .hint("add --unit, such as --unit mg")
        })
    }

    /// Everything a reader needs.
    pub(crate) fn options(
        &self,
        calibration: &CalibrationFile,
    ) -> Result<RecordingOptions, Failure> {
        Ok(self.reading_of(self.signals(calibration)?))
    }

    fn reading_of(&self, columns: Vec<ColumnRef>) -> RecordingOptions {
        RecordingOptions {
            layout: LayoutOptions::default(),
            columns,
            time: self.time.as_deref().map(ColumnRef::from_word),
            time_unit: self.time_unit,
            sampling_rate_hz: self.rate,
            unit: self.unit,
            ..RecordingOptions::default()
        }
    }

    /// Factor from the unit of a column to the input unit of the calibration, or why there is none.
    ///
    /// `heading` is the unit that stands in the heading of the column.
    pub(crate) fn factor(
        &self,
        calibration: &CalibrationFile,
        name: &str,
        heading: Option<Unit>,
    ) -> Result<f64, Failure> {
        let wanted = calibration.input_unit;
        let unit = match (heading, self.unit) {
            (Some(heading), Some(given)) if heading != given => {
                return Err(Failure::new(format!(
                    "column {name:?} is in {heading} by its heading, in {given} by --unit"
                ))
                .hint("remove --unit, or correct the heading"));
            }
            (Some(unit), _) | (None, Some(unit)) => unit,
            (None, None) => {
                return Err(Failure::new(format!("the unit of column {name:?} is not known"))
                    .hint(format!("the calibration takes {wanted}: add --unit {} if that is what it holds", wanted.ascii())));
            }
        };
        let (si, factor) = unit.si();
        if si == wanted {
            Ok(factor)
        } else {
            Err(Failure::new(format!(
                "column {name:?} is in {unit}, the calibration takes {wanted}"
            ))
            .hint("name the columns of the uncompensated outputs with --columns X,Y,Z, or calibrate in this unit"))
        }
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
