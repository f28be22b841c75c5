//! How a recording of a calibrated sensor is to be read.

use crate::campaign::{Unsaid, axes, no_axes};
use crate::channels::{ChannelReading, WantedChannel};
use crate::findings;
use crate::stream_choice::StreamChoice;
use crate::trouble::{Result, Trouble};
use proofmass_documents::{AnyCalibration, CalibrationFile};
use proofmass_io::{
    ClockUnit, ColumnRef, Layout, LayoutOptions, Reading, Recording, RecordingOptions, Source,
    TimeUnit, Unit,
};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

/// Columns, units and time of a recording, as far as it does not say them itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct RecordingReading {
    /// Columns of the outputs (x, y and z of a triaxial sensor) by name or number (from 1); `convert` and
    /// `inspect` take patterns (`acc_*`) too [default: those of the calibration]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "X,Y,Z", value_delimiter = ',')
    )]
    pub columns: Option<Vec<ColumnRef>>,
    /// Unit of these columns, where the headings do not say it: count, m/s², g, mg, V, …
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(long))]
    pub unit: Option<Unit>,
    /// Time column by name or number
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN"))]
    pub time: Option<ColumnRef>,
    /// Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with --rate)
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "UNIT"))]
    pub time_unit: Option<TimeUnit>,
    /// Sampling rate in hertz, for recordings without a time column
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "HZ"))]
    pub rate: Option<f64>,
    /// Read the rows from one time on and before another, in seconds
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(
        feature = "clap",
        arg(long, num_args = 2, value_names = ["FROM", "TO"], allow_negative_numbers = true)
    )]
    pub between: Option<Vec<f64>>,
    /// Which stream of the file.
    #[serde(flatten)]
    #[cfg_attr(feature = "clap", command(flatten))]
    pub choice: StreamChoice,
}

/// The stretch that two words of a command line name.
pub(crate) fn stretch(between: Option<&[f64]>) -> Result<Option<[f64; 2]>> {
    match between {
        None => Ok(None),
        Some(&[from, to]) if from < to && from.is_finite() && to.is_finite() => {
            Ok(Some([from, to]))
        }
        Some(_) => Err(Trouble::request("a stretch of time ends before it begins")
            .with_hint("write --between FROM TO in seconds, FROM before TO")),
    }
}

impl RecordingReading {
    /// The columns of the signals: as asked for, else as the calibration found them.
    ///
    /// # Errors
    /// Neither says it, or their number is not that of the outputs.
    pub fn signals(&self, calibration: &AnyCalibration) -> Result<Vec<ColumnRef>> {
        let outputs = match calibration {
            AnyCalibration::FrequencyResponse(file) => file.outputs.clone(),
            AnyCalibration::Constant(file) if file.axes() == 1 => vec!["output".to_owned()],
            AnyCalibration::Constant(_) => ["x", "y", "z"].map(str::to_owned).to_vec(),
            _ => return Err(Trouble::request("a calibration of an unknown kind")),
        };
        let known = calibration.columns();
        let names = outputs.join(",").to_uppercase();
        match self.columns.clone().or(known) {
            Some(columns) if columns.len() == outputs.len() => Ok(columns),
            Some(columns) => Err(Trouble::request(format!(
                "the calibration is of {}, and {} named",
                match outputs.len() {
                    1 => "one axis".to_owned(),
                    n => format!("{n} axes"),
                },
                match columns.len() {
                    1 => "one column is".to_owned(),
                    n => format!("{n} columns are"),
                }
            ))
            .with_hint(format!("add --columns {names}"))),
            None => Err(Trouble::request(format!(
                "the calibration does not say which columns {} are",
                match outputs.as_slice() {
                    [one] => one.clone(),
                    [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
                    [] => "the outputs".to_owned(),
                }
            ))
            .with_hint(format!("add --columns {names}"))),
        }
    }

    /// Why a column is not there, with the option that names others where it is one of the calibration.
    pub(crate) fn not_of_calibration(
        &self,
        error: proofmass_io::Error,
        calibration: &AnyCalibration,
    ) -> Trouble {
        let named = self.columns.is_none().then(|| calibration.columns());
        let Some(columns) = named.flatten() else {
            return error.into();
        };
        // A name brings its quotes.
        let words: Vec<String> = columns.iter().map(ColumnRef::to_string).collect();
        let option = match columns.len() {
            1 => "--columns COLUMN",
            3 => "--columns X,Y,Z",
            _ => "--columns A,B,…",
        };
        let there = Trouble::from(error);
        let hint = there.hint().map_or(String::new(), |h| format!("; {h}"));
        Trouble::data(format!(
            "the calibration was made with {} {}, and the recording has no column of that name",
            match columns.len() {
                1 => "the column",
                _ => "the columns",
            },
            words.join(", ")
        ))
        .with_hint(format!(
            "name the columns of the recording with {option}{hint}"
        ))
    }

    /// That the columns are those of the calibration in another order.
    pub(crate) fn exchanged(
        &self,
        calibration: &AnyCalibration,
        layout: &Layout,
    ) -> Option<Finding> {
        let indices = |columns: &[ColumnRef]| -> Option<Vec<usize>> {
            columns.iter().map(|c| layout.find(c).ok()).collect()
        };
        let (given, known) = (
            indices(self.columns.as_deref()?)?,
            indices(&calibration.columns()?)?,
        );
        let sorted = |columns: &[usize]| {
            let mut sorted = columns.to_vec();
            sorted.sort_unstable();
            sorted
        };
        let names = |columns: &[usize]| {
            let names: Vec<String> = columns.iter().map(|i| layout.name(*i)).collect();
            names.join(", ")
        };
        (given != known && sorted(&given) == sorted(&known))
            .then(|| findings::columns_exchanged(&names(&given), &names(&known)))
    }

    /// The same for a job of one channel.
    ///
    /// # Errors
    /// No column is named, or several.
    pub fn one_channel(&self) -> Result<(ChannelReading, WantedChannel)> {
        let Some([column]) = self.columns.as_deref() else {
            return Err(
                Trouble::request("the inverse filter works on one column at a time")
                    .with_hint("name one with --columns COLUMN"),
            );
        };
        let reading = ChannelReading {
            time: self.time.clone(),
            time_unit: self.time_unit,
            rate: self.rate,
            between: self.between.clone(),
            choice: self.choice.clone(),
            table: false,
        };
        let wanted = WantedChannel::new(column.clone(), self.unit, "--unit");
        Ok((reading, wanted))
    }

    /// Everything a reader of a whole recording needs.
    ///
    /// # Errors
    /// As [`RecordingReading::signals`].
    pub fn options(&self, calibration: &CalibrationFile) -> Result<RecordingOptions> {
        self.reading_of(self.signals(&calibration.clone().into())?)
    }

    /// The same without a calibration: x, y and z are named, or told by their headings.
    ///
    /// # Errors
    /// They are neither, or not three; everything else that nobody says is asked for with them.
    pub fn options_alone(&self, source: &mut Source) -> Result<RecordingOptions> {
        match &self.columns_of_axes(source)? {
            Some(columns) if columns.len() == 3 => self.reading_of(columns.clone()),
            Some(columns) if columns.len() == 1 => Err(Trouble::request(
                "one column is named, and the directions of three axes are needed here",
            )
            .with_hint(
                "name the columns of x, y and z; one axis is measured by `proofmass test tilt`, `sensitivity` or `linearity`",
            )),
            _ => Err(
                Trouble::request("which columns are x, y and z is not known")
                    .with_hint("add --columns X,Y,Z"),
            ),
        }
    }

    /// The columns as they are named, else those of three axes by their headings.
    fn columns_of_axes(&self, source: &mut Source) -> Result<Option<Vec<ColumnRef>>> {
        let name = source.name().to_path_buf();
        self.choice.marks.mark(source);
        let layout = Layout::of(source, &LayoutOptions::default())?;
        let at = |e: proofmass_io::Error| Trouble::from(e.at(&name));
        let (columns, unknown) = match (&self.columns, axes(&layout)) {
            (Some(columns), _) => (Some(columns.clone()), None),
            (None, Ok(names)) => {
                let list = names.iter().map(|name| ColumnRef::from_word(name));
                (Some(list.collect::<Vec<_>>()), None)
            }
            (None, Err(several)) => (None, Some(no_axes(&layout, several))),
        };
        let find = |column: &ColumnRef| layout.find(column).map_err(at);
        let signals = columns
            .iter()
            .flatten()
            .map(find)
            .collect::<Result<Vec<_>>>()?;
        let unsaid = Unsaid {
            signals: &signals,
            unit: self.unit,
            time: self.time.as_ref().map(find).transpose()?,
            time_unit: self.time_unit,
            rate_hz: self.rate,
            timeless: false,
        };
        let asked = unknown.as_ref().map(|error| (error, "--columns X,Y,Z"));
        unsaid.ask_beside(&layout, asked).map_err(at)?;
        match unknown {
            Some(error) => Err(at(error)),
            None => Ok(columns),
        }
    }

    /// The same for a sensor of three axes or of one.
    ///
    /// # Errors
    /// Neither one column is named nor three.
    pub(crate) fn options_of_axes(&self, source: &mut Source) -> Result<RecordingOptions> {
        match &self.columns_of_axes(source)? {
            Some(columns) if matches!(columns.len(), 1 | 3) => self.reading_of(columns.clone()),
            _ => Err(
                Trouble::request("which columns are the outputs is not known").with_hint(
                    "add --columns X,Y,Z, or the one column of a sensor with a single axis",
                ),
            ),
        }
    }

    /// The same for a look at whatever columns are named.
    ///
    /// # Errors
    /// A stretch that ends before it begins.
    pub(crate) fn reading_of(&self, columns: Vec<ColumnRef>) -> Result<RecordingOptions> {
        Ok(RecordingOptions {
            columns,
            time: self.time.clone(),
            time_unit: self.time_unit,
            sampling_rate_hz: self.rate,
            unit: self.unit,
            between: stretch(self.between.as_deref())?,
            ..self.choice.options()
        })
    }

    /// The one unit of three columns, or of one: that of their headings, else the one that is given.
    ///
    /// # Errors
    /// Units that differ, or that nobody states.
    pub fn common_unit(&self, recording: &Recording) -> Result<Unit> {
        recording.need_units(&vec!["--unit"; recording.columns.len().min(3)])?;
        let mut common = self.unit;
        for column in recording.columns.iter().take(3) {
            match (column.unit, common) {
                (Some(own), Some(unit)) if own != unit => {
                    return Err(Trouble::request(format!(
                        "column {:?} is in {own}, not in {unit}",
                        column.name
                    ))
                    .with_hint(match self.unit {
                        Some(_) => "x, y and z need one unit; remove --unit, or correct the heading",
                        None => "x, y and z need one unit: correct the heading, or export the columns in one unit",
                    }));
                }
                (Some(own), _) => common = Some(own),
                (None, _) => {}
            }
        }
        common.ok_or_else(|| {
            Trouble::request("the unit of the outputs is not known")
                .with_hint("add --unit, such as --unit mg")
        })
    }

    /// How the columns of a recording that goes by as a stream are read, with the rate once it is known.
    pub(crate) fn of_stream(
        &self,
        layout: &Layout,
        signals: &[usize],
        clock: Option<(usize, &ClockUnit)>,
    ) -> Result<Reading> {
        layout.refuse_grouped(signals, self.unit)?;
        let mut reading = Reading::of(layout, signals, self.unit, clock, self.rate);
        reading.between_s = stretch(self.between.as_deref())?;
        Ok(reading)
    }

    /// Factors from the units of columns to the input unit of the calibration.
    ///
    /// # Errors
    /// Units that contradict each other or the calibration; a unit that nobody states is asked for by the one that the numbers show.
    pub(crate) fn factors(
        &self,
        wanted: Unit,
        layout: &Layout,
        signals: &[usize],
    ) -> Result<Vec<f64>> {
        let open = |i: &&usize| layout.unit(**i).is_none();
        let open: Vec<usize> = signals.iter().filter(open).copied().collect();
        let likely = layout.likely_unit(&open).filter(|u| u.is_acceleration());
        let likely = likely.or_else(|| layout.gravity_unit(&open));
        if self.unit.is_none() && !open.is_empty() && likely.is_some() {
            return Err(layout.ask_unit(&open).into());
        }
        let factor = |&i: &usize| self.factor(wanted, &layout.name(i), layout.unit(i));
        signals.iter().map(factor).collect()
    }

    /// Factor from the unit of a column to the input unit of the calibration, or why there is none.
    ///
    /// `heading` is the unit that stands in the heading of the column.
    ///
    /// # Errors
    /// Units that contradict each other or the calibration, or one that nobody states.
    fn factor(&self, wanted: Unit, name: &str, heading: Option<Unit>) -> Result<f64> {
        let unit = match (heading, self.unit) {
            (Some(heading), Some(given)) if heading != given => {
                return Err(Trouble::request(format!(
                    "column {name:?} is in {heading} by its heading, in {given} by --unit"
                ))
                .with_hint("remove --unit, or correct the heading"));
            }
            (Some(unit), _) | (None, Some(unit)) => unit,
            (None, None) => {
                return Err(Trouble::request(format!("the unit of column {name:?} is not known"))
                    .with_hint(format!(
                        "the calibration takes {wanted}: add --unit {} if that is what it holds",
                        wanted.ascii()
                    )));
            }
        };
        let (si, factor) = unit.si();
        if si == wanted {
            return Ok(factor);
        }
        Err(Trouble::request(format!(
            "column {name:?} is in {unit}, the calibration takes {wanted}"
        ))
        .with_hint("name the columns of the uncompensated outputs with --columns X,Y,Z, or calibrate in this unit"))
    }
}
