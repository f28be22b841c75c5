//! Channels of a dynamic test as files have them: several columns on one steady clock, in SI.

use crate::recording::stretch;
use crate::stream_choice::StreamChoice;
use crate::trouble::{Result, Trouble};
use proofmass_io::{
    ColumnRef, Error, Input, Layout, LayoutOptions, Recording, RecordingOptions, SaidBy,
    Sensitivity, Source, TimeUnit, Unit, UnitRatio,
};
use proofmass_report::number::plain;
use proofmass_uncertainty::Finding;

/// A channel that is wanted, and its unit where the heading does not say it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct WantedChannel {
    /// Column by name or number.
    pub(crate) column: ColumnRef,
    /// Unit, where the heading does not say it.
    pub(crate) unit: Option<Unit>,
    /// The option that says this unit, by which it is asked for; none where the numbers need no unit.
    pub(crate) option: Option<&'static str>,
    /// What turns it into an acceleration, with its relative standard uncertainty.
    pub(crate) sensitivity: Option<(Sensitivity, f64)>,
    /// Its unit where that may be one over another, and who says it.
    pub(crate) ratio: Option<(UnitRatio, SaidBy)>,
}

impl WantedChannel {
    /// A channel whose unit is asked for by an option where neither heading nor `unit` says it.
    pub fn new(column: ColumnRef, unit: Option<Unit>, option: &'static str) -> Self {
        Self {
            column,
            unit,
            option: Some(option),
            sensitivity: None,
            ratio: None,
        }
    }

    /// In a unit that is assumed, and said to be, where the heading has none.
    pub fn assumed(column: ColumnRef, unit: Unit) -> Self {
        Self {
            unit: Some(unit),
            ..Self::bare(column)
        }
    }

    /// As an acceleration, by the sensitivity of its transducer and the relative standard uncertainty of that.
    #[must_use]
    pub fn by(mut self, sensitivity: Sensitivity, relative_uncertainty: f64) -> Self {
        self.sensitivity = Some((sensitivity, relative_uncertainty));
        self
    }

    /// Numbers that need no unit, or have it from elsewhere.
    pub fn bare(column: ColumnRef) -> Self {
        Self {
            column,
            unit: None,
            option: None,
            sensitivity: None,
            ratio: None,
        }
    }

    /// In a unit that may be one over another, known before the column is read.
    pub(crate) fn of_ratio(column: ColumnRef, ratio: UnitRatio, by: SaidBy) -> Self {
        Self {
            ratio: Some((ratio, by)),
            ..Self::bare(column)
        }
    }
}

/// How the channels of a recording are to be read.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[non_exhaustive]
pub struct ChannelReading {
    /// Time column by name or number [default: the one that is named as a time]
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN"))]
    pub time: Option<ColumnRef>,
    /// Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with --rate)
    #[cfg_attr(feature = "clap", arg(long, value_name = "UNIT"))]
    pub time_unit: Option<TimeUnit>,
    /// Sampling rate in hertz [default: that of the time stamps]
    #[cfg_attr(feature = "clap", arg(long, value_name = "HZ", value_parser = crate::arguments::positive))]
    pub rate: Option<f64>,
    /// Read the rows from one time on and before another, in seconds
    #[cfg_attr(
        feature = "clap",
        arg(long, num_args = 2, value_names = ["FROM", "TO"], allow_negative_numbers = true)
    )]
    pub between: Option<Vec<f64>>,
    /// Which stream of the file.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub choice: StreamChoice,
    /// Rows have an order and no clock.
    #[cfg_attr(feature = "clap", arg(skip))]
    pub table: bool,
}

/// One channel in SI, or in its raw unit.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RecordedChannel {
    /// Name without unit.
    pub name: String,
    /// Unit of the numbers; 1 where none is needed.
    pub unit: String,
    /// One number per sample.
    pub data: Vec<f64>,
}

/// A view of a channel.
#[derive(Clone, Copy, Debug)]
pub struct Channel<'a> {
    /// Name.
    pub name: &'a str,
    /// Unit of the numbers.
    pub unit: &'a str,
    /// One number per sample.
    pub data: &'a [f64],
}

impl RecordedChannel {
    /// A view.
    pub fn view(&self) -> Channel<'_> {
        Channel {
            name: &self.name,
            unit: &self.unit,
            data: &self.data,
        }
    }
}

/// Channels in memory.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RecordedChannels {
    /// As asked for, in their order.
    pub channels: Vec<RecordedChannel>,
    /// Samples per second.
    pub rate: f64,
    /// What reading found.
    pub findings: Vec<Finding>,
    /// The file and its digest.
    pub input: Input,
    /// What it is called in messages.
    pub name: String,
}

impl ChannelReading {
    /// A table, which has an order and no clock.
    pub fn table() -> Self {
        Self {
            table: true,
            ..Self::default()
        }
    }

    /// The columns of some roles, each with the option that names it: those that are not named are the ones that the file has besides, in its
    /// order, where these are exactly so many.
    ///
    /// # Errors
    /// A file that cannot be looked at; more columns than roles, or fewer.
    pub fn columns(
        &self,
        source: &mut Source,
        roles: &[(&str, Option<&ColumnRef>)],
    ) -> Result<Vec<ColumnRef>> {
        let open: Vec<&str> = roles
            .iter()
            .filter(|r| r.1.is_none())
            .map(|r| r.0)
            .collect();
        if open.is_empty() {
            return Ok(roles.iter().filter_map(|r| r.1.cloned()).collect());
        }
        let name = source.name().display().to_string();
        self.choice.marks.mark(source);
        let layout = Layout::of(source, &LayoutOptions::default())?;
        let mut taken: Vec<usize> = layout.time_column().into_iter().collect();
        let named = self.time.iter().chain(roles.iter().filter_map(|r| r.1));
        taken.extend(named.filter_map(|column| layout.find(column).ok()));
        let free: Vec<usize> = (0..layout.columns).filter(|i| !taken.contains(i)).collect();
        if free.len() != open.len() {
            let names: Vec<String> = free.iter().map(|i| layout.name(*i)).collect();
            return Err(Trouble::request(format!(
                "{} {} missing, and the file has {} columns to choose from",
                open.join(" and "),
                if open.len() == 1 { "is" } else { "are" },
                free.len()
            ))
            .detail(name)
            .with_hint(format!(
                "add {}; the columns are {}",
                open.iter()
                    .map(|o| format!("{o} COLUMN"))
                    .collect::<Vec<_>>()
                    .join(" "),
                names.join(", ")
            )));
        }
        let mut free = free.into_iter().map(|i| ColumnRef::Index(i + 1));
        Ok(roles
            .iter()
            .filter_map(|r| r.1.cloned().or_else(|| free.next()))
            .collect())
    }

    /// Reads the wanted channels.
    ///
    /// # Errors
    /// What the reader refuses; a unit that contradicts its heading, or that nobody says; samples that are missing or a clock with gaps, over
    /// which no transform holds.
    pub fn read(&self, source: Source, wanted: &[WantedChannel]) -> Result<RecordedChannels> {
        let name = source.name().display().to_string();
        let mut recording = Recording::from_source(
            source,
            &RecordingOptions {
                columns: wanted.iter().map(|w| w.column.clone()).collect(),
                time: self.time.clone(),
                time_unit: self.time_unit,
                sampling_rate_hz: self.rate,
                between: stretch(self.between.as_deref())?,
                table: self.table,
                ..self.choice.options()
            },
        )?;
        if let Some(gap) = recording.time.gaps().first() {
            return Err(Trouble::data("samples are missing: the clock of a dynamic test must run on")
                .detail(format!("{name}:{}", gap.line))
                .detail(format!("a step of {:.6} s at {:.6} s", gap.step_s, gap.at_s))
                .with_hint("cut the recording to a segment without gaps with --between FROM TO, or give --rate if only the time stamps are wrong"));
        }
        let rate = self.rate.unwrap_or_else(|| recording.time.rate_hz());
        for (i, wanted) in wanted.iter().enumerate() {
            if let Some((ratio, by)) = wanted.ratio {
                recording.state_ratio(i, ratio, by);
                continue;
            }
            let bare = wanted.option.is_none().then_some(Unit::One);
            let by = bare.map_or(SaidBy::Person, |_| SaidBy::Nobody);
            recording
                .state_unit(i, wanted.unit.or(bare), by)
                .map_err(|e| by_option(e, wanted.option))?;
        }
        let options: Vec<&str> = wanted
            .iter()
            .map(|w| w.option.unwrap_or_default())
            .collect();
        recording.need_units(&options)?;
        let mut channels = Vec::with_capacity(wanted.len());
        let mut input = recording.input();
        for (i, (column, wanted)) in recording.columns.iter().zip(wanted).enumerate() {
            let (mut si, mut factor) = column.unit.unwrap_or(Unit::One).si();
            if let Some((sensitivity, relative)) = &wanted.sensitivity {
                if si != sensitivity.unit {
                    return Err(Trouble::data(format!(
                        "a sensitivity of {sensitivity} turns {} into an acceleration, and the column {:?} is in {si}",
                        sensitivity.unit, column.name
                    ))
                    .detail(name)
                    .with_hint("state the unit of the column (--unit), or leave --sensitivity out"));
                }
                factor /= sensitivity.value;
                si = Unit::MetrePerSecondSquared;
                let read = input.reading.as_mut().and_then(|r| r.columns.get_mut(i));
                if let Some(read) = read {
                    let u = match *relative {
                        0.0 => "no uncertainty stated".to_owned(),
                        u => format!("u = {} %", plain(100.0 * u)),
                    };
                    read.conversion = Some(format!("to m/s² by {sensitivity} ({u})"));
                }
            }
            let unit = match wanted.ratio {
                Some((ratio, _)) => {
                    let (ratio, to_si) = ratio.si();
                    factor = to_si;
                    ratio.to_string()
                }
                None => si.to_string(),
            };
            let data = match factor {
                1.0 => column.data.clone(),
                f => column.data.iter().map(|v| f * v).collect(),
            };
            channels.push(RecordedChannel {
                name: column.name.clone(),
                unit,
                data,
            });
        }
        Ok(RecordedChannels {
            channels,
            rate,
            findings: recording.findings().to_vec(),
            input,
            name,
        })
    }
}

/// A unit that contradicts its heading, with the option that states it.
pub(crate) fn by_option(error: Error, option: Option<&str>) -> Error {
    let hint = error
        .hint()
        .zip(option)
        .map(|(hint, option)| hint.replace("the option that states it", option));
    match hint {
        Some(hint) => error.with_hint(hint),
        None => error,
    }
}
