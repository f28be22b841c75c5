//! How a recording was read: its columns, their units, its rate, and who said so of each.

use crate::time_unit::{hertz, short, significant};
use crate::{ClockUnit, Layout, SaidBy, Thermometer, TimeUnit, Unit, UnitRatio};
use serde::{Deserialize, Serialize};
use std::fmt;

/// How a recording was read. Its display is one line, with which every summary, report and error about it begins.
///
/// `columns 2 acc_x, 3 acc_y, 4 acc_z in g by the headings; 100 Hz by column 1 timestamp in ms as stated`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Reading {
    /// The signals, in the order in which they were asked for.
    pub columns: Vec<ReadColumn>,
    /// The clock.
    pub time: ReadTime,
    /// The thermometer, where its temperatures were read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature: Option<ReadColumn>,
    /// Other quantities of the surroundings that were read.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub surroundings: Vec<ReadQuantity>,
    /// The format and the stream, where it is no text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stream: Option<ReadStream>,
    /// The stretch that was read, s, where it is not all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub between_s: Option<[f64; 2]>,
    /// Local gravity, where the job needs it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<ReadGravity>,
}

/// A column of signals.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ReadColumn {
    /// Number from one.
    pub number: usize,
    /// Heading without unit; none in a file without headings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heading: Option<String>,
    /// What it is taken for, where a campaign says so: `reference`, `output`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<String>,
    /// Unit as it stands in the file, where it is known.
    pub unit: Option<Unit>,
    /// A unit over another in its place, as a sensitivity has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ratio: Option<UnitRatio>,
    /// Who says the unit.
    pub unit_by: SaidBy,
    /// How its numbers became those of the result, such as `to m/s² by 0.5 mV/(m/s²)`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conversion: Option<String>,
}

/// A column of humidity, pressure, supply voltage or the like.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ReadQuantity {
    /// What it is.
    pub quantity: String,
    /// Number of the column from one.
    pub number: usize,
    /// Heading without unit; none in a file without headings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heading: Option<String>,
    /// Its unit, which may be one that no signal has.
    pub unit: String,
    /// Who says the unit.
    pub unit_by: SaidBy,
}

impl ReadQuantity {
    /// A quantity in the column of this index, in a unit that was stated or that the heading says.
    pub fn of(layout: &Layout, index: usize, quantity: &str, unit: &str, stated: bool) -> Self {
        Self {
            quantity: quantity.to_owned(),
            number: index + 1,
            heading: layout.header.is_some().then(|| layout.name(index)),
            unit: unit.to_owned(),
            unit_by: match stated {
                true => SaidBy::Person,
                false => SaidBy::Heading,
            },
        }
    }
}

/// The clock of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ReadTime {
    /// Samples per second; none for a table, whose rows have an order alone.
    pub rate_hz: Option<f64>,
    /// Number of the column of times, from one; none where the rate was stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<usize>,
    /// Its heading without unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heading: Option<String>,
    /// What it counts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<TimeUnit>,
    /// Who says the unit, or the rate.
    pub by: SaidBy,
}

/// A stream of another format than text.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ReadStream {
    /// Word for the format.
    pub format: String,
    /// Name of the stream, where the file has several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Kinds of scales that the file declares for the columns, applied once.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scaling: Vec<String>,
}

impl ReadStream {
    fn of(layout: &Layout, signals: &[usize]) -> Option<Self> {
        let stream = layout.stream.as_ref()?;
        let mut scaling: Vec<String> = Vec::new();
        for words in signals
            .iter()
            .filter_map(|&i| stream.scaling.get(i)?.as_ref())
        {
            if !scaling.contains(words) {
                scaling.push(words.clone());
            }
        }
        Some(Self {
            format: stream.format.clone(),
            name: stream.name.clone(),
            scaling,
        })
    }
}

/// Local gravity as a job uses it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ReadGravity {
    /// Value, m/s².
    pub value: f64,
    /// Standard uncertainty, m/s².
    pub standard_uncertainty: f64,
    /// Where it comes from, such as `by latitude 48° and height 520 m`.
    pub by: String,
    /// Latitude, °, and height, m, where it is normal gravity there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal_at: Option<[f64; 2]>,
}

impl Reading {
    /// The reading of some columns of a text; a clock of `None` with a `rate` is a stated one.
    pub fn of(
        layout: &Layout,
        signals: &[usize],
        stated: Option<Unit>,
        clock: Option<(usize, &ClockUnit)>,
        rate_hz: Option<f64>,
    ) -> Self {
        let heading = |index: usize| layout.header.is_some().then(|| layout.name(index));
        let columns = signals
            .iter()
            .map(|&index| {
                let own = layout.unit(index);
                ReadColumn {
                    number: index + 1,
                    heading: heading(index),
                    role: None,
                    unit: own.or(stated),
                    unit_by: match (own, stated) {
                        (Some(_), _) if layout.stream.is_some() => SaidBy::File,
                        (Some(_), _) => SaidBy::Heading,
                        (None, Some(_)) => SaidBy::Person,
                        (None, None) => SaidBy::Nobody,
                    },
                    ratio: None,
                    conversion: None,
                }
            })
            .collect();
        Self {
            columns,
            time: ReadTime {
                rate_hz,
                column: clock.map(|(index, _)| index + 1),
                heading: clock.and_then(|(index, _)| heading(index)),
                unit: clock.map(|(_, unit)| unit.unit),
                by: match clock {
                    Some((_, unit))
                        if layout.stream.is_some() && unit.said_by == SaidBy::Heading =>
                    {
                        SaidBy::File
                    }
                    Some((_, unit)) => unit.said_by,
                    None => SaidBy::Person,
                },
            },
            temperature: None,
            surroundings: Vec::new(),
            stream: ReadStream::of(layout, signals),
            between_s: None,
            gravity: None,
        }
    }

    /// The column of a thermometer.
    pub fn thermometer(layout: &Layout, index: usize, thermometer: &Thermometer) -> ReadColumn {
        ReadColumn {
            role: None,
            number: index + 1,
            heading: layout.header.is_some().then(|| layout.name(index)),
            unit: Some(thermometer.unit),
            unit_by: thermometer.said_by,
            ratio: None,
            conversion: None,
        }
    }

    /// States the unit of a column whose heading does not say it, counted from zero in their order.
    pub fn state_unit(&mut self, column: usize, unit: Option<Unit>, by: SaidBy) {
        if let (Some(column), Some(unit)) = (self.columns.get_mut(column), unit)
            && column.unit.is_none()
        {
            (column.unit, column.unit_by) = (Some(unit), by);
        }
    }

    /// States the unit of a column as one over another.
    pub(crate) fn state_ratio(&mut self, column: usize, ratio: UnitRatio, by: SaidBy) {
        if let Some(column) = self.columns.get_mut(column) {
            let itself = ratio.under == Unit::One;
            column.unit = itself.then_some(ratio.over);
            column.ratio = (!itself).then_some(ratio);
            column.unit_by = by;
        }
    }

    /// The reading of samples in volts, side by side in a file without headings.
    pub(crate) fn of_volts(numbers: &[usize], rate_hz: f64, rate_by: SaidBy) -> Self {
        let column = |&number: &usize| ReadColumn {
            number,
            heading: None,
            role: None,
            ratio: None,
            conversion: None,
            unit: Some(Unit::Volt),
            unit_by: SaidBy::Person,
        };
        Self {
            columns: numbers.iter().map(column).collect(),
            time: ReadTime {
                rate_hz: Some(rate_hz),
                column: None,
                heading: None,
                unit: None,
                by: rate_by,
            },
            temperature: None,
            surroundings: Vec::new(),
            stream: None,
            between_s: None,
            gravity: None,
        }
    }

    /// States the size of one count or volt of the signals.
    pub fn state_scale(&mut self, factor: f64, unit: Unit) {
        for column in 0..self.columns.len() {
            self.state_scale_of(column, factor, unit);
        }
    }

    /// States the size of one of what a column is recorded in.
    pub fn state_scale_of(&mut self, column: usize, factor: f64, unit: Unit) {
        if let Some(column) = self.columns.get_mut(column) {
            let said = format!("one of which is {} {unit} as stated", short(factor));
            column.conversion = Some(said);
        }
    }

    /// Says what each column is taken for, in their order.
    pub(crate) fn name_roles<'a>(&mut self, roles: impl IntoIterator<Item = &'a str>) {
        for (column, role) in self.columns.iter_mut().zip(roles) {
            // A heading that is the role says it already.
            let said = column.heading.as_deref() == Some(role);
            column.role = (!said).then(|| role.to_owned());
        }
    }

    /// The file and how it was read, in one line.
    pub fn line(&self, file: &str) -> String {
        format!("{file}: {self}")
    }
}

/// A column by its number, and its heading where it has one.
fn column_by(f: &mut fmt::Formatter<'_>, number: usize, heading: Option<&str>) -> fmt::Result {
    write!(f, "{number}")?;
    heading.map_or(Ok(()), |heading| write!(f, " {heading}"))
}

impl fmt::Display for Reading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = if self.columns.len() == 1 {
            "column"
        } else {
            "columns"
        };
        // A long row of alike columns is told by its ends.
        const SHOWN: usize = 6;
        write!(f, "{words} ")?;
        let mut from = 0;
        for (i, column) in self.columns.iter().enumerate() {
            let skipped =
                self.columns.len() > SHOWN && i >= SHOWN - 1 && i + 1 < self.columns.len();
            let next = self.columns.get(i + 1);
            let how = |n: &ReadColumn| (n.unit, n.ratio, n.unit_by, n.conversion.clone());
            let same = |n: &ReadColumn| how(n) == how(column);
            // Behind the last one that is shown only the end of the row is.
            let ends = self.columns.len() > SHOWN && i + 2 == SHOWN;
            let alike = match ends {
                true => self.columns[i + 1..].iter().all(same),
                false => next.is_some_and(same),
            };
            if !skipped {
                write!(f, "{}", if i > from { ", " } else { "" })?;
                column_by(f, column.number, column.heading.as_deref())?;
                if let Some(role) = &column.role {
                    write!(f, " as {role}")?;
                }
            } else if i == SHOWN - 1 {
                write!(f, "{}…", if i > from { ", " } else { "" })?;
            }
            // What is told by "…" has no unit of its own here, but at the end.
            if alike || (skipped && next.is_some()) {
                continue;
            }
            let unit = column.unit.map(|unit| unit.to_string());
            let ratio = column.ratio.map(|ratio| ratio.to_string());
            match (unit.or(ratio), column.unit_by) {
                (Some(unit), by) => write!(f, " in {unit} {by}")?,
                // What one of them is was stated.
                (None, _) if column.conversion.is_some() => write!(f, " in units of its own")?,
                (None, _) => write!(f, " in a unit that is not said")?,
            }
            if let Some(conversion) = &column.conversion {
                write!(f, ", {conversion}")?;
            }
            if next.is_some() {
                write!(f, ", ")?;
            }
            from = i + 1;
        }
        let time = &self.time;
        match time.rate_hz {
            Some(rate) => write!(f, "; {}", hertz(rate))?,
            None if time.column.is_some() => write!(f, "; times")?,
            None => write!(f, "; rows in their order")?,
        }
        match (time.column, time.unit) {
            (Some(column), unit) => {
                write!(f, " by column ")?;
                column_by(f, column, time.heading.as_deref())?;
                match (unit, time.by) {
                    (_, SaidBy::Field) | (None, _) => write!(f, " {}", SaidBy::Field)?,
                    (Some(unit), by) => write!(f, " in {unit} {by}")?,
                }
            }
            (None, _) if time.rate_hz.is_some() => write!(f, " {}", time.by)?,
            _ => {}
        }
        if let Some(column) = &self.temperature {
            write!(f, "; temperature by column ")?;
            column_by(f, column.number, column.heading.as_deref())?;
            if let Some(unit) = column.unit {
                write!(f, " in {unit} {}", column.unit_by)?;
            }
        }
        for read in &self.surroundings {
            write!(f, "; {} by column ", read.quantity)?;
            let heading = read.heading.as_deref();
            column_by(f, read.number, heading.filter(|h| *h != read.quantity))?;
            write!(f, " in {} {}", read.unit, read.unit_by)?;
        }
        if let Some(stream) = &self.stream {
            write!(f, "; {} file", stream.format)?;
            if let Some(name) = &stream.name {
                write!(f, ", stream {name}")?;
            }
            if !stream.scaling.is_empty() {
                let words = stream.scaling.join(", ");
                write!(f, ", its own scaling ({words}) applied")?;
            }
        }
        if let Some([from, to]) = self.between_s {
            write!(f, "; between {from} s and {to} s")?;
        }
        if let Some(g) = &self.gravity {
            let u = match g.standard_uncertainty {
                u if u > 1e-8 => significant(u, 2),
                u => short(u),
            };
            write!(f, "; g = {:.5} m/s², u = {u} m/s², {}", g.value, g.by)?;
        }
        Ok(())
    }
}
