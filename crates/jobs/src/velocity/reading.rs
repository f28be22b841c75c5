//! The slow, drift-free sensor: encoder, resolver, wheel speed.

mod signal;

use super::sensors::{stated_unit, unknown_unit};
use crate::trouble::Trouble;
use proofmass_core::Error;
use proofmass_core::encoder::Decoding;
use proofmass_io::{ColumnRef, RecordedColumn, Recording, Unit};
pub(super) use proofmass_motion::Samples;
use proofmass_motion::{
    AbsoluteCode, ReadingSource, absolute, continued, counter_words, indexed, interval, levels,
    mean_of, rollover, turns_anew,
};
use proofmass_odometry::{Wheels, dead_wheels};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// What names the column of a reading.
pub(super) const NAMED: &str =
    "add --position COLUMN, --speed COLUMN, --quadrature A,B, --teeth LEVEL or --resolver SIN,COS";

/// The encoder or the wheel speed: which columns hold it, and what they mean.
///
/// One of `position`, `speed`, `quadrature`, `teeth` and `resolver` is named.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(
    feature = "clap",
    derive(clap::Args),
    group(id = "reading", required = false)
)]
#[serde(default)]
#[non_exhaustive]
pub struct Reading {
    /// Column of the position (count, length or angle); of several columns the mean, as of two wheels
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN,…", value_delimiter = ',', conflicts_with_all = ["speed", "quadrature", "resolver"]))]
    pub position: Option<Vec<String>>,
    /// Column of a speed instead of a position (wheel, tachogenerator); of several columns the mean
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN,…", value_delimiter = ',', conflicts_with_all = ["quadrature", "resolver"]))]
    pub speed: Option<Vec<String>>,
    /// Columns of the logic levels A,B or A,B,Z of an incremental encoder
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "A,B[,Z]",
            value_delimiter = ',',
            conflicts_with = "resolver"
        )
    )]
    pub quadrature: Option<Vec<String>>,
    /// Columns of the voltages of a resolver, sine and cosine: demodulated, or with their carrier
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "SIN,COS", value_delimiter = ',')
    )]
    pub resolver: Option<Vec<String>>,
    /// Column of the excitation of a resolver whose voltages still have their carrier
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "COLUMN",
            requires = "resolver",
            conflicts_with = "carrier"
        )
    )]
    pub excitation: Option<String>,
    /// Frequency of that carrier in hertz, where the excitation is not recorded: the angle is then ambiguous by half a turn
    #[cfg_attr(feature = "clap", arg(long, value_name = "HZ", requires = "resolver"))]
    pub carrier: Option<f64>,
    /// Column of the level of a toothed wheel's pick-up: every tooth is a count; the direction is not available
    #[cfg_attr(feature = "clap", arg(long, value_name = "LEVEL", conflicts_with_all = ["position", "speed", "quadrature", "resolver"]))]
    pub teeth: Option<String>,
    /// Unit of position or speed, where the heading does not say it: count, m, mm, rad, °, turn, m/s, km/h, rad/s, …
    #[cfg_attr(feature = "clap", arg(long, value_name = "UNIT"))]
    pub unit: Option<Unit>,
    /// Factor from the column to that unit: speed per volt of a tachogenerator, half a wavelength per hertz of Doppler
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "FACTOR",
            requires = "unit",
            allow_negative_numbers = true
        )
    )]
    pub scale: Option<f64>,
    /// Counts per turn of the encoder (four times its lines with fourfold decoding)
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "N", conflicts_with = "counts_per_metre")
    )]
    pub counts_per_turn: Option<f64>,
    /// Counts per metre of a linear encoder
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub counts_per_metre: Option<f64>,
    /// Radius that turns an angle into a length, m: of the wheel, or where the accelerometer sits
    #[cfg_attr(feature = "clap", arg(long, value_name = "METRES"))]
    pub radius: Option<f64>,
    /// Lead of a screw, its travel per turn, m: in place of --radius for an encoder or a resolver on its shaft
    #[cfg_attr(feature = "clap", arg(long, value_name = "METRES", conflicts_with_all = ["radius", "counts_per_metre", "angular"]))]
    pub lead: Option<f64>,
    /// Bits of the counter or of the absolute encoder, which rolls over
    #[cfg_attr(feature = "clap", arg(long, value_name = "BITS", value_parser = clap::value_parser!(u32).range(1..=32)))]
    pub bits: Option<u32>,
    /// The words are Gray code
    #[cfg_attr(feature = "clap", arg(long, requires = "bits"))]
    pub gray: bool,
    /// Edges counted per line of the logic levels: 1, 2 or 4
    #[cfg_attr(feature = "clap", arg(long, value_name = "EDGES", default_value = "4"))]
    pub decoding: Decoding,
    /// Column of the index pulse beside counts of a turn: zero of the position, and lost counts put back at every turn
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "COLUMN", requires_all = ["position", "counts_per_turn"])
    )]
    pub index: Option<String>,
    /// Positions or speeds are positive against the acceleration: reverse them
    #[cfg_attr(feature = "clap", arg(long))]
    pub reverse: bool,
    /// Each row is an edge of the encoder with its time stamp, not a sample
    #[cfg_attr(feature = "clap", arg(long))]
    pub edges: bool,
    /// Velocity in rad/s: angles stay angles, and --radius is that of the accelerometer
    #[cfg_attr(feature = "clap", arg(long))]
    pub angular: bool,
    /// Angles restart after each turn, as those of an absolute encoder in degrees
    #[cfg_attr(feature = "clap", arg(long))]
    pub wraps: bool,
}

impl Reading {
    /// Way or angle of one turn in the unit of the readings, where the reading says it.
    pub fn turn(&self) -> Option<f64> {
        match self.angular {
            true => Some(TAU),
            false => self.lead.or(self.radius.map(|r| TAU * r)),
        }
    }

    /// What position or speed is multiplied by, so that it is positive as the acceleration is.
    pub(super) fn sense(&self) -> f64 {
        if self.reverse { -1.0 } else { 1.0 }
    }

    /// Counts and radius as they were stated, in words.
    pub(super) fn stated(&self) -> Option<String> {
        let told: Vec<String> = [
            self.counts_per_turn.map(|n| format!("{n} counts per turn")),
            self.counts_per_metre
                .map(|n| format!("{n} counts per metre")),
            self.bits.map(|n| format!("{n} bits")),
            self.radius.map(|r| format!("radius {r} m")),
            self.lead.map(|l| format!("lead {l} m")),
            self.reverse.then(|| "reversed".to_owned()),
        ]
        .into_iter()
        .flatten()
        .collect();
        (!told.is_empty()).then(|| told.join(", "))
    }

    /// The columns it needs, in the order in which [`Reading::decode`] takes them.
    pub(super) fn columns(&self) -> Result<Vec<ColumnRef>, Trouble> {
        if let Some(name) = &self.teeth {
            return Ok(vec![ColumnRef::from_word(name)]);
        }
        let (names, least, most) = match (
            &self.position,
            &self.speed,
            &self.quadrature,
            &self.resolver,
        ) {
            (Some(n), ..) | (_, Some(n), ..) => (n, 1, 16),
            (_, _, Some(n), _) => (n, 2, 3),
            (.., Some(n)) => (n, 2, 2),
            _ => {
                return Err(
                    Trouble::data("no column of a position or a speed is named").with_hint(NAMED)
                );
            }
        };
        if !(least..=most).contains(&names.len()) {
            return Err(Trouble::data(format!(
                "{} columns are named, {least} to {most} are needed",
                names.len()
            )));
        }
        let excitation = self.excitation.iter().filter(|_| self.resolver.is_some());
        if self.index.is_some() && (self.position.is_none() || names.len() != 1) {
            return Err(Trouble::request(
                "an index belongs to the counts of one encoder",
            )
            .with_hint("name one column: --position COUNT --index COLUMN; logic levels have theirs as --quadrature A,B,Z"));
        }
        let all = names.iter().chain(excitation).chain(&self.index);
        Ok(all.map(|n| ColumnRef::from_word(n)).collect())
    }

    /// Whether a resolver's voltages still have their carrier.
    pub(super) fn is_modulated(&self) -> bool {
        self.resolver.is_some() && (self.excitation.is_some() || self.carrier.is_some())
    }

    /// Way of one turn of a resolver.
    pub(super) fn resolver_turn(&self) -> Option<f64> {
        self.resolver.as_ref().and_then(|_| self.turn())
    }

    /// Whether a column is named.
    pub(super) fn is_named(&self) -> bool {
        self.position.is_some()
            || self.speed.is_some()
            || self.quadrature.is_some()
            || self.resolver.is_some()
            || self.teeth.is_some()
    }

    /// Position or speed.
    pub(super) fn source(&self) -> ReadingSource {
        if self.speed.is_some() {
            ReadingSource::Speed
        } else {
            ReadingSource::Position
        }
    }

    /// Whether rows are edges.
    pub(super) fn edges(&self) -> bool {
        self.edges
    }

    /// Whether the reading is no count, so that a repeated value was not read anew.
    pub(super) fn is_analogue(&self) -> bool {
        !self.counts() && !self.edges
    }

    /// Whether logic levels are read.
    pub(super) fn is_level(&self) -> bool {
        self.quadrature.is_some() || self.teeth.is_some()
    }

    fn counts(&self) -> bool {
        self.is_level()
            || self.bits.is_some()
            || self.counts_per_turn.is_some()
            || self.counts_per_metre.is_some()
    }

    /// Length of one count, m, where counts are read.
    pub(super) fn increment(&self) -> Option<f64> {
        self.counts().then(|| self.count_length().ok()).flatten()
    }

    /// Length of one count, m.
    fn count_length(&self) -> Result<f64, Trouble> {
        let positive = |name: &str, value: f64| {
            if value.is_finite() && value > 0.0 {
                Ok(value)
            } else {
                Err(Trouble::data(format!("{name} {value} must be positive")))
            }
        };
        match (self.counts_per_metre, self.counts_per_turn) {
            (Some(_), _) if self.angular => Err(Trouble::data(
                "--counts-per-metre is that of a linear encoder, --angular asks for an angle",
            )
            .with_hint("give --counts-per-turn, or leave out --angular")),
            (Some(n), _) => Ok(1.0 / positive("--counts-per-metre", n)?),
            (None, Some(n)) => {
                Ok(TAU / positive("--counts-per-turn", n)? * self.radius("counts of a turn")?)
            }
            (None, None) => Err(Trouble::data("the length of one count is not known")
                .with_hint("add --counts-per-turn N with --radius R (of a screw with --lead L), or --counts-per-metre N")),
        }
    }

    /// Counts of a turn, which are whole where an index comes at one of them.
    pub(super) fn whole_turn(&self) -> Result<i64, Trouble> {
        let turn = self.counts_per_turn.unwrap_or_default();
        match turn.fract() == 0.0 && (8.0..=1e9).contains(&turn) {
            true => Ok(turn as i64),
            false => Err(Trouble::request(format!(
                "--counts-per-turn {turn} is no whole number from 8 on, and an index comes once a turn"
            ))
            .with_hint("give the counts of a turn after decoding: four times the lines with fourfold decoding")),
        }
    }

    /// Whether the readings turn: counts of a turn, angles, a resolver.
    pub(super) fn turns(&self, recording: &Recording) -> Result<bool, Trouble> {
        if self.resolver.is_some() {
            return Ok(true);
        }
        if self.counts_per_metre.is_some() {
            return Ok(false);
        }
        if self.counts_per_turn.is_some() {
            return Ok(true);
        }
        let Some(column) = recording.columns.first() else {
            return Ok(false);
        };
        let unit = match self.scale {
            Some(_) => self.unit,
            None => stated_unit(recording, column, (self.unit, "--unit"))?,
        };
        Ok(unit.is_some_and(|u| matches!(u.si().0, Unit::Radian | Unit::RadianPerSecond)))
    }

    /// Radius that turns the acceleration into an angular one.
    pub(super) fn lever(&self) -> Result<f64, Trouble> {
        if !self.angular {
            return Ok(1.0);
        }
        let length = Self {
            angular: false,
            ..self.clone()
        };
        length.radius("--angular and readings in angles")
    }

    fn radius(&self, of: &str) -> Result<f64, Trouble> {
        if self.angular {
            if self.lead.is_some() {
                return Err(Trouble::request(
                    "--lead makes a length of a turn, --angular asks for an angle",
                )
                .with_hint("leave out one of them"));
            }
            return Ok(1.0);
        }
        let (option, stated, per_turn) = match (self.radius, self.lead) {
            (Some(_), Some(_)) => {
                return Err(
                    Trouble::request("--radius and --lead both state the way of a turn")
                        .with_hint("leave out one of them: a screw has a lead, a wheel a radius"),
                );
            }
            (Some(r), None) => ("--radius", r, TAU),
            (None, Some(lead)) => ("--lead", lead, 1.0),
            (None, None) => {
                return Err(Trouble::data(format!(
                    "{of} give an angle, the accelerometer measures along a line"
                ))
                .with_hint("add --radius R in metres: of the wheel, or where the accelerometer sits; of a screw --lead L, its travel per turn"));
            }
        };
        match stated.is_finite() && stated > 0.0 {
            true => Ok(stated * per_turn / TAU),
            false => Err(Trouble::data(format!("{option} {stated} must be positive"))),
        }
    }

    /// Readings in m or m/s with their times.
    pub(super) fn decode(
        &self,
        recording: &Recording,
        clock: &[f64],
        findings: &mut Vec<Finding>,
    ) -> Result<Samples, Trouble> {
        let all = self.columns()?.len();
        let n = all - usize::from(self.index.is_some());
        let columns = &recording.columns[..n];
        let missing: Vec<&[usize]> = (0..n).map(|i| recording.missing(i)).collect();
        if self.wraps && (self.is_level() || self.resolver.is_some()) {
            return Err(Trouble::request(
                "--wraps is about an angle that restarts after each turn, and none is read",
            )
            .with_hint("leave out --wraps: levels and a resolver are counted over their turns"));
        }
        if self.is_level() {
            return self.logic(recording, columns, clock, &missing, findings);
        }
        if self.resolver.is_some() {
            return self.resolved(recording, columns, clock, &missing, findings);
        }
        let mut values: Vec<Vec<f64>> = columns
            .iter()
            .map(|column| self.length(recording, column, findings))
            .collect::<Result<_, _>>()?;
        if self.index.is_some() {
            let pulse = levels(&recording.columns[n].data);
            let step = self.count_length()?;
            let count: Vec<i64> = values[0]
                .iter()
                .map(|v| (v / step).round() as i64)
                .collect();
            let place = |e: Error| Trouble::from(e).detail(recording.path.display().to_string());
            let found = indexed(&count, &pulse, self.whole_turn()?, &[], &|k| clock[k]);
            let found = found.map_err(place)?;
            findings.extend(found.findings);
            values[0] = found.count.iter().map(|c| step * *c as f64).collect();
        }
        let (dead, finding) = match n {
            1 => (Vec::new(), None),
            _ => {
                let names: Vec<&str> = columns.iter().map(|c| c.name.as_str()).collect();
                dead_wheels(&self.each(recording, n)?, &names)
            }
        };
        findings.extend(finding);
        let used: Vec<usize> = (0..n).filter(|i| !dead.contains(i)).collect();
        let mean = mean_of(&values, &used, clock.len());
        let missing: Vec<&[usize]> = used.iter().map(|i| missing[*i]).collect();
        Ok(Samples::present(clock, &mean, &missing))
    }

    /// The columns one by one in m or m/s.
    fn each(&self, recording: &Recording, count: usize) -> Result<Vec<Vec<Option<f64>>>, Trouble> {
        let wheel = |i: usize| -> Result<Vec<Option<f64>>, Trouble> {
            // What is to be said of the columns is said where they are read for the velocity.
            let value = self.length(recording, &recording.columns[i], &mut Vec::new())?;
            let mut wheel: Vec<Option<f64>> = value.into_iter().map(Some).collect();
            for &k in recording.missing(i) {
                wheel[k] = None;
            }
            Ok(wheel)
        };
        (0..count).map(wheel).collect()
    }

    /// Left and right wheel in m or m/s, where two are named.
    pub(super) fn wheels(&self, recording: &Recording) -> Result<[Vec<Option<f64>>; 2], Trouble> {
        let named = self.position.as_ref().or(self.speed.as_ref());
        let refused = || {
            Trouble::request("--yaw-rate is compared with two wheels in metres, sample by sample")
                .with_hint("name them as --position LEFT,RIGHT or --speed LEFT,RIGHT, without --edges and --angular")
        };
        if self.edges || self.angular || named.is_none_or(|n| n.len() != 2) {
            return Err(refused());
        }
        let wheels = self.each(recording, 2)?;
        <[Vec<Option<f64>>; 2]>::try_from(wheels).map_err(|_| refused())
    }

    /// What is to be said of three columns and more, which are the wheels of one vehicle: one that departs from the others.
    pub(super) fn departures(
        &self,
        recording: &Recording,
        clock: &[f64],
    ) -> Result<Vec<Finding>, Trouble> {
        let named = self.position.as_ref().or(self.speed.as_ref());
        let Some(names) = named.filter(|n| n.len() > 2 && !self.edges) else {
            return Ok(Vec::new());
        };
        let mut readings = self.each(recording, names.len())?;
        let mut names: Vec<&str> = names.iter().map(String::as_str).collect();
        let (dead, _) = dead_wheels(&readings, &names);
        for &i in dead.iter().rev() {
            readings.remove(i);
            names.remove(i);
        }
        // Of more than four the place tells the side.
        if !dead.is_empty() && !(3..=4).contains(&names.len()) {
            return Ok(Vec::new());
        }
        let wheels = Wheels {
            sample_time: interval(clock).unwrap_or(0.0),
            source: self.source(),
            readings: &readings,
            names: &names,
            increment: self.increment(),
        };
        match wheels.slip() {
            Ok(departures) => Ok(departures.findings),
            // A recording of a second tells too little of its wheels.
            Err(Error::TooFew { .. }) => Ok(Vec::new()),
            Err(e) => Err(Trouble::from(e).detail(recording.path.display().to_string())),
        }
    }

    /// One column in m or m/s.
    fn length(
        &self,
        recording: &Recording,
        column: &RecordedColumn,
        findings: &mut Vec<Finding>,
    ) -> Result<Vec<f64>, Trouble> {
        let name = &column.name;
        let stated = match self.scale {
            // The heading is that of the raw column.
            Some(_) => self.unit,
            None => stated_unit(recording, column, (self.unit, "--unit"))?,
        };
        let unit = match stated {
            Some(unit) => unit,
            None if self.scale.is_some() => {
                return Err(Trouble::data("--scale needs the unit it leads to")
                    .with_hint("add --unit m/s, rad/s, r/min, mm, …"));
            }
            None if self.counts() => Unit::Count,
            None => {
                let hint =
                    "add --unit m, mm, rad, turn, m/s, km/h, …, or --counts-per-turn N for counts";
                return Err(unknown_unit(recording, column, hint));
            }
        };
        let speed = self.source() == ReadingSource::Speed;
        let (si, mut factor) = unit.si();
        if let Some(scale) = self.scale {
            if !(scale.is_finite() && scale != 0.0) {
                return Err(Trouble::data(format!(
                    "--scale {scale} is out of range: it must be finite and not zero"
                ))
                .with_hint("leave --scale out where the unit of the column is right"));
            }
            if si == Unit::Count {
                return Err(Trouble::data("counts have no --scale")
                    .with_hint("give --counts-per-turn or --counts-per-metre"));
            }
            factor *= scale;
        }
        let scale = match (si, speed) {
            (Unit::Metre | Unit::MetrePerSecond, _) if self.angular => {
                return Err(Trouble::data(format!(
                    "column {name:?} is in {unit}, --angular asks for an angle"
                ))
                .with_hint("leave out --angular"));
            }
            (Unit::Metre, false) | (Unit::MetrePerSecond, true) => factor,
            (Unit::Radian, false) | (Unit::RadianPerSecond, true) => {
                factor * self.radius("readings in angles")?
            }
            (Unit::Count, false) if self.wraps => return Err(self.no_angle(name, unit)),
            (Unit::Count, false) => {
                let step = self.count_length()?;
                let count = self.continued(recording, column, findings)?;
                return Ok(count.into_iter().map(|c| step * c as f64).collect());
            }
            _ => {
                let what = if speed { "speed" } else { "position" };
                return Err(Trouble::data(format!(
                    "column {name:?} is in {unit}, which is no {what}"
                ))
                .with_hint("a position is in m, mm, rad, °, turn or count and is named with --position, a speed in m/s, rad/s or r/min with --speed; --unit says the unit where no heading does"));
            }
        };
        if self.wraps && (si, speed) != (Unit::Radian, false) {
            return Err(self.no_angle(name, unit));
        }
        if (si, speed) == (Unit::Radian, false) {
            let turn = (TAU / factor).abs();
            if self.wraps {
                let angle = continued(&column.data, turn);
                return Ok(angle.into_iter().map(|v| scale * v).collect());
            }
            findings.extend(turns_anew(&column.data, turn));
        }
        Ok(column.data.iter().map(|v| scale * v).collect())
    }

    /// An angle that restarts is asked for, and the column holds none.
    fn no_angle(&self, column: &str, unit: Unit) -> Trouble {
        let hint = match unit {
            Unit::Count => {
                "leave out --wraps; a counter rolls over with --bits N, its width, as 12 for 0 to 4095"
            }
            _ => "leave out --wraps",
        };
        Trouble::data(format!(
            "--wraps is about angles, column {column:?} is in {unit}"
        ))
        .with_hint(hint)
    }

    /// Whole numbers, continued over the rollovers of a counter.
    fn continued(
        &self,
        recording: &Recording,
        column: &RecordedColumn,
        findings: &mut Vec<Finding>,
    ) -> Result<Vec<i64>, Trouble> {
        let refuse = |k: usize, what: &str, hint: &str| {
            Trouble::data(format!(
                "{}:{}: column {:?}: {} {what}",
                recording.path.display(),
                recording.line(k),
                column.name,
                column.data[k]
            ))
            .with_hint(hint.to_owned())
        };
        let mut counts = Vec::with_capacity(column.data.len());
        for (k, v) in column.data.iter().enumerate() {
            if v.fract() != 0.0 || v.abs() > 9e15 {
                return Err(refuse(
                    k,
                    "is no count",
                    "counts are whole numbers; state another --unit if these are lengths or angles",
                ));
            }
            counts.push(*v as i64);
        }
        let Some(bits) = self.bits else {
            findings.extend(rollover(&counts, None));
            return Ok(counts);
        };
        let words = counter_words(&counts, bits).map_err(|k| {
            refuse(
                k,
                &format!("does not fit into {bits} bits"),
                "give the width of the counter with --bits, or leave it out for counts that do not roll over",
            )
        })?;
        let code = if self.gray {
            AbsoluteCode::Gray
        } else {
            AbsoluteCode::Binary
        };
        // Without a reading the row repeats the count before it: no step.
        let decoded = absolute(code, bits, &words)?;
        findings.extend(decoded.findings);
        // Words of a Gray code jump as they like; what they stand for does not.
        let shown = if self.gray { &decoded.count } else { &counts };
        findings.extend(rollover(shown, Some(bits)));
        Ok(decoded.count)
    }
}
