//! What a time column counts: said by its heading or by a person, or so plain that it can be assumed and told.

use crate::layout::Layout;
use crate::{Error, ErrorKind, Result, Unit, findings};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};
use std::fmt;

/// What a time column counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum TimeUnit {
    /// s.
    #[serde(rename = "s")]
    Second,
    /// ms.
    #[serde(rename = "ms")]
    Millisecond,
    /// µs.
    #[serde(rename = "us", alias = "µs")]
    Microsecond,
    /// ns.
    #[serde(rename = "ns")]
    Nanosecond,
    /// min.
    #[serde(rename = "min")]
    Minute,
    /// h.
    #[serde(rename = "h")]
    Hour,
    /// d, as spreadsheets count.
    #[serde(rename = "d", alias = "day", alias = "days")]
    Day,
    /// Number of the sample; needs a sampling rate.
    #[serde(rename = "index", alias = "sample")]
    Index,
}

/// Symbols, as they are typed.
const SYMBOLS: [(&str, TimeUnit); 8] = [
    ("s", TimeUnit::Second),
    ("ms", TimeUnit::Millisecond),
    ("us", TimeUnit::Microsecond),
    ("ns", TimeUnit::Nanosecond),
    ("min", TimeUnit::Minute),
    ("h", TimeUnit::Hour),
    ("d", TimeUnit::Day),
    ("index", TimeUnit::Index),
];

impl fmt::Display for TimeUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let symbol = SYMBOLS.iter().find(|(_, unit)| unit == self);
        f.write_str(symbol.map_or("", |(symbol, _)| symbol))
    }
}

impl std::str::FromStr for TimeUnit {
    type Err = String;

    /// By its symbol: s, ms, us, ns, min, h, d, index.
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let text = text.replace(['µ', 'μ'], "u");
        let known = SYMBOLS.iter().find(|(symbol, _)| *symbol == text);
        known
            .map(|(_, unit)| *unit)
            .ok_or_else(|| format!("{text:?} is no unit of time (s, ms, us, ns, min, h, d, index)"))
    }
}

impl TimeUnit {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Second,
        Self::Millisecond,
        Self::Microsecond,
        Self::Nanosecond,
        Self::Minute,
        Self::Hour,
        Self::Day,
        Self::Index,
    ];

    /// The unit of time that a heading names.
    pub fn of(unit: Unit) -> Option<Self> {
        match unit {
            Unit::Second => Some(Self::Second),
            Unit::Millisecond => Some(Self::Millisecond),
            Unit::Microsecond => Some(Self::Microsecond),
            Unit::Nanosecond => Some(Self::Nanosecond),
            Unit::Minute => Some(Self::Minute),
            Unit::Hour => Some(Self::Hour),
            Unit::Day => Some(Self::Day),
            _ => None,
        }
    }

    /// Units per second: dividing by a power of ten rounds once, multiplying by its inverse twice.
    pub fn per_second(self, rate: Option<f64>) -> Option<f64> {
        match self {
            Self::Second => Some(1.0),
            Self::Millisecond => Some(1e3),
            Self::Microsecond => Some(1e6),
            Self::Nanosecond => Some(1e9),
            Self::Minute => Some(1.0 / 60.0),
            Self::Hour => Some(1.0 / 3600.0),
            Self::Day => Some(1.0 / 86_400.0),
            Self::Index => rate,
        }
    }
}

/// Where something comes from that a recording need not say.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum SaidBy {
    /// The heading.
    Heading,
    /// The file, in a format that has a place for it.
    File,
    /// A person, by an option or in a campaign.
    Person,
    /// The field itself: a date with a time, or a time of day.
    Field,
    /// Nobody: it is assumed, which is told.
    Nobody,
}

impl fmt::Display for SaidBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Heading => "by the heading",
            Self::File => "by the file",
            Self::Person => "as stated",
            Self::Field => "by date or time of day",
            Self::Nobody => "assumed",
        })
    }
}

/// The unit of a time column.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ClockUnit {
    /// The unit.
    pub unit: TimeUnit,
    /// Units in a second.
    pub per_second: f64,
    /// Who says so.
    pub said_by: SaidBy,
    /// That it is assumed.
    pub finding: Option<Finding>,
}

/// Rates that a recording without a unit is believed to have, Hz.
const USUAL: std::ops::RangeInclusive<f64> = 5.0..=2e5;
/// Rates from which on stamps without a unit are seconds, Hz: below, a converter may as well have counted milliseconds.
const SECONDS: f64 = 30.0;
/// Most rates lie about it, Hz.
const TYPICAL: f64 = 200.0;

/// What the head of a column says of its unit.
enum Guess {
    Assumed(TimeUnit, &'static str),
    /// Two units or more are possible, or none is: all with their rates, the likely one first; and whether it may count the rows.
    Open(Vec<(TimeUnit, f64)>, bool),
}

impl ClockUnit {
    /// The unit of a time column: stated, by the heading, or such that no other gives a usual rate.
    ///
    /// `rate` is for a column that counts samples; `events` come when they come.
    ///
    /// # Errors
    /// A unit that contradicts the heading; none, where the stamps may count more than one or none is plausible: the
    /// likely one is named.
    pub fn of(
        layout: &Layout,
        index: usize,
        stated: Option<TimeUnit>,
        rate: Option<f64>,
        events: bool,
    ) -> Result<Self> {
        Self::consider(layout, index, stated, rate, events).map_err(|open| *open.error)
    }

    /// The same for a look at a recording: the likely unit instead of a question, with a finding that asks.
    pub(crate) fn likely(
        layout: &Layout,
        index: usize,
        stated: Option<TimeUnit>,
        rate: Option<f64>,
    ) -> Result<Self> {
        Self::consider(layout, index, stated, rate, false).or_else(|open| {
            let Some((unit, evidence)) = open.likely else {
                return Err(*open.error);
            };
            Ok(Self {
                unit,
                per_second: unit.per_second(rate).unwrap_or(1.0),
                said_by: SaidBy::Nobody,
                finding: Some(findings::time_unit_open(
                    &layout.name(index),
                    &unit.to_string(),
                    &evidence,
                )),
            })
        })
    }

    /// The likely unit where it has to be asked for, and what each amounts to; `None` where it is known, assumed, or impossible.
    pub fn open(
        layout: &Layout,
        index: usize,
        stated: Option<TimeUnit>,
        rate: Option<f64>,
    ) -> Option<(TimeUnit, String)> {
        let asked = Self::consider(layout, index, stated, rate, false).err()?;
        let counts = asked.counts_rows.then_some(TimeUnit::Index);
        asked
            .likely
            .map(|(unit, rates)| (counts.unwrap_or(unit), rates))
    }

    fn consider(
        layout: &Layout,
        index: usize,
        stated: Option<TimeUnit>,
        rate: Option<f64>,
        events: bool,
    ) -> std::result::Result<Self, Open> {
        let heading = layout.unit(index).and_then(TimeUnit::of);
        let name = layout.name(index);
        let error = |what: String| Error::new(ErrorKind::Time, what).column(name.clone());
        if let (Some(given), Some(heading)) = (stated, heading)
            && given != heading
        {
            let what = format!("the heading says {heading}, {given} is stated");
            return Err(error(what)
                .with_hint(
                    "leave --time-unit (`time_unit` in a campaign) out, or correct the heading",
                )
                .into());
        }
        let head = layout.head.get(index);
        let known = |unit, per_second, said_by| Self {
            unit,
            per_second,
            said_by,
            finding: None,
        };
        // A date with a time, or a time of day, is one whatever the heading says.
        if head.and_then(|h| h.first).is_some_and(|f| f.dated) {
            return Ok(known(TimeUnit::Second, 1.0, SaidBy::Field));
        }
        let by = match stated {
            Some(_) => SaidBy::Person,
            None => SaidBy::Heading,
        };
        if let Some(unit) = stated.or(heading) {
            return match unit.per_second(rate) {
                Some(scale) if scale.is_finite() && scale > 0.0 => Ok(known(unit, scale, by)),
                Some(rate) => Err(error(format!(
                    "a sampling rate of {rate} Hz is out of range: it must be positive"
                ))
                .into()),
                None => Err(
                    error("a column that counts samples needs the sampling rate".into())
                        .with_hint("add --rate HZ (`sampling_rate_Hz` in a campaign)")
                        .into(),
                ),
            };
        }
        match guess(head, events) {
            Guess::Assumed(unit, why) => Ok(Self {
                finding: Some(findings::time_unit_assumed(&name, why)),
                ..known(unit, unit.per_second(None).unwrap_or(1.0), SaidBy::Nobody)
            }),
            Guess::Open(all, counts_rows) => {
                let likely = all.first().map_or(TimeUnit::Second, |a| a.0);
                let rates = all
                    .iter()
                    .map(|(unit, rate)| format!("{} as {unit}", hertz(*rate)));
                let rates = rates.collect::<Vec<_>>().join(", ");
                let hint = match counts_rows {
                    true => format!(
                        "they may count the rows: say --time-unit index (`time_unit = \"index\"` in a campaign) and --rate HZ (`sampling_rate_Hz = HZ` in a campaign); \
                         or that is {rates}: say --time-unit {likely} (`time_unit = \"{likely}\"` in a campaign)"
                    ),
                    false => format!(
                        "that is {rates}; likely it is {likely}: say --time-unit {likely} (`time_unit = \"{likely}\"` in a campaign), \
                         or --rate HZ if the column counts something else"
                    ),
                };
                let step = head.and_then(|h| h.step).unwrap_or(0.0);
                let what = format!(
                    "the unit of the times is not said; from row to row they rise by about {}",
                    short(step)
                );
                let rates = match counts_rows {
                    true => format!("{rates}, or rows counted"),
                    false => rates,
                };
                Err(Open {
                    error: Box::new(error(what).with_hint(hint)),
                    likely: Some((likely, rates)),
                    counts_rows,
                })
            }
        }
    }
}

/// A unit that has to be asked for.
struct Open {
    error: Box<Error>,
    /// The likely unit, and what every unit amounts to.
    likely: Option<(TimeUnit, String)>,
    /// Whether it may count the rows, one by one from 0 or 1.
    counts_rows: bool,
}

impl From<Error> for Open {
    fn from(error: Error) -> Self {
        Self {
            error: Box::new(error),
            likely: None,
            counts_rows: false,
        }
    }
}

fn guess(head: Option<&crate::column_head::ColumnHead>, events: bool) -> Guess {
    use TimeUnit::*;
    let seconds = Guess::Assumed(Second, "seconds");
    let Some((first, step)) = head.and_then(|h| h.first.zip(h.step)) else {
        return seconds;
    };
    let whole = head.is_some_and(|h| h.whole);
    let first = first.value();
    let rate = |unit: TimeUnit| unit.per_second(None).unwrap_or(1.0) / step;
    // Between 2001 and 2286.
    let epoch = match first.abs().log10().floor() {
        9.0 => Some((Second, "seconds since 1970")),
        12.0 => Some((Millisecond, "milliseconds since 1970")),
        15.0 => Some((Microsecond, "microseconds since 1970")),
        18.0 => Some((Nanosecond, "nanoseconds since 1970")),
        _ => None,
    };
    if let Some((unit, why)) = epoch
        && (events || USUAL.contains(&rate(unit)))
    {
        return Guess::Assumed(unit, why);
    }
    // Days since 1900, as spreadsheets count: 1954 to 2119.
    if (2e4..8e4).contains(&first) && !whole && rate(Second) > *USUAL.end() && rate(Day) > 0.01 {
        return Guess::Assumed(Day, "days, as spreadsheets count them");
    }
    // Events have no rate that could be absurd, but counts of a counter are no seconds.
    if events && !whole || !events && (SECONDS..=*USUAL.end()).contains(&rate(Second)) {
        return seconds;
    }
    // Seconds since 1970 of a slow logger are no milliseconds of 1970.
    let epoch = epoch.map(|(unit, _)| unit);
    let mut all: Vec<(TimeUnit, f64)> = [Second, Millisecond, Microsecond, Nanosecond]
        .into_iter()
        .chain(
            (!whole)
                .then_some([Minute, Hour, Day])
                .into_iter()
                .flatten(),
        )
        .map(|unit| (unit, rate(unit)))
        .filter(|(unit, rate)| {
            *unit == Second || Some(*unit) == epoch || (0.5..=1e6).contains(rate)
        })
        .collect();
    let distance = |rate: f64| (rate / TYPICAL).ln().abs();
    all.sort_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
    all.sort_by_key(|(unit, _)| Some(*unit) != epoch);
    all.truncate(3);
    // Rows that are missing make the typical step a little longer.
    let one_by_one = whole && (1.0..1.05).contains(&step);
    let counts_rows = !events && one_by_one && (first == 0.0 || first == 1.0);
    Guess::Open(all, counts_rows)
}

/// A rate with three digits.
pub(crate) fn hertz(rate: f64) -> String {
    match rate {
        r if r >= 1e6 => format!("{} MHz", short(r / 1e6)),
        r if r >= 1e3 => format!("{} kHz", short(r / 1e3)),
        r => format!("{} Hz", short(r)),
    }
}

/// Three or four digits without zeros at the end.
pub(crate) fn short(v: f64) -> String {
    if v == 0.0 || !(1e-4..1e9).contains(&v.abs()) {
        return format!("{v:.3e}");
    }
    significant(v, 4)
}

/// So many significant digits in plain decimals, nine behind the point at most, without zeros behind the last one that counts.
pub(crate) fn significant(v: f64, digits: i32) -> String {
    let decimals = (digits - 1 - v.abs().log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{v:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}
