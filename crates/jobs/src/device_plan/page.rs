//! The report of a plan for a data sheet.

use super::noise::spoken;
use super::{DevicePlanOutcome, Measured, PlannedLimit};
use crate::certificate::RuleWord;
use crate::data_sheet::ReadLimit;
use crate::page::columns::filed;
use proofmass_report::{Cell, Field, KeyFigure, Report, Rounding, Section, Table, scientific};

pub(super) fn add(page: Report, plan: &DevicePlanOutcome) -> Report {
    let page = page.verdict(plan.verdict()).answers(plan.answer());
    page.section(
        Section::new("What to measure")
            .table(plan.measurements())
            .summarised(),
    )
    .section(Section::new("Limits").table(plan.planned()).summarised())
    .section(Section::new("What is known before").table(plan.known()))
}

/// A limit with what it needs.
type Row<'a> = (&'a ReadLimit, &'a PlannedLimit);

impl DevicePlanOutcome {
    /// Time that is known, and whether some is not.
    fn time(&self) -> (f64, bool) {
        let known = self.measurements.iter().filter_map(|m| m.duration).sum();
        (
            known,
            self.measurements.iter().any(|m| m.duration.is_none()),
        )
    }

    fn verdict(&self) -> String {
        let all = self.planned.len();
        let reached = self.planned.iter().filter(|p| p.reached).count();
        let (time, more) = self.time();
        let more = match (more, time > 0.0) {
            (false, _) => format!(" after {}", spoken(time)),
            (true, true) => format!(" after {} and the tests whose length is open", spoken(time)),
            (true, false) => String::new(),
        };
        let p = 100.0 * self.given.decided;
        match all - reached {
            0 => format!(
                "Planned: a device with its typical values is decided by all {all} limits{more}, each in {p:.0} % of measurements or more."
            ),
            left => format!(
                "Planned in part: {left} of {all} limits are out of reach; the others are decided{more}, each in {p:.0} % of measurements or more."
            ),
        }
    }

    fn answer(&self) -> Vec<KeyFigure> {
        let reached = self.planned.iter().filter(|p| p.reached).count();
        let (time, more) = self.time();
        let note = match more {
            true => "of the measurements whose length is known",
            false => "recording and turning, without the work between",
        };
        vec![
            KeyFigure::new("limits decided", reached.to_string(), "")
                .note(format!("of {}", self.planned.len())),
            KeyFigure::new("measurements", self.measurements.len().to_string(), ""),
            KeyFigure::new("time", spoken(time), "").note(note),
        ]
    }

    fn measurements(&self) -> Table {
        let fields = [
            Field::new("command", |m: &Measured| m.shown_by.command().into()).page("command", ""),
            Field::new("what", |m: &Measured| m.what.as_str().into()).page("what", ""),
            Field::new("duration_s", |m: &Measured| {
                Cell::from(m.duration).worded(m.duration.map_or("–".to_owned(), spoken))
            })
            .page("time", ""),
            Field::new("limits", |m: &Measured| m.limits.into()).page("limits", ""),
        ];
        Table::of(
            "Measurements that decide the limits",
            fields,
            &self.measurements,
        )
        .file("measurements.csv")
    }

    fn rule(&self) -> String {
        let p = 100.0 * self.given.decided;
        match self.sheet.decision.rule {
            RuleWord::GuardBand => format!(
                "U needed: {} U and what the value scatters by in {p:.0} % of measurements fit between the typical value and the nearer limit.",
                self.sheet.decision.r
            ),
            RuleWord::Simple => format!(
                "U needed: what the value scatters by in {p:.0} % of measurements fits between the typical value and the nearer limit."
            ),
        }
    }

    fn planned(&self) -> Table {
        let fields = [
            Field::new("characteristic", |(l, _): &Row<'_>| {
                l.characteristic.name().into()
            })
            .page("characteristic", ""),
            filed("channels", |(l, _): &Row<'_>| l.channels.join(" ")),
            Field::shown("limit", "", |(l, _): &Row<'_>| {
                match (l.where_it_holds().as_str(), l.channels.join(", ").as_str()) {
                    ("", "") => l.words(),
                    (place, "") => format!("{} ({place})", l.words()),
                    ("", axes) => format!("{} ({axes})", l.words()),
                    (place, axes) => format!("{} ({axes}; {place})", l.words()),
                }
                .into()
            }),
            filed("where", |(l, _): &Row<'_>| l.where_it_holds()),
            filed("lower_limit", |(l, _): &Row<'_>| l.limits.lower),
            filed("upper_limit", |(l, _): &Row<'_>| l.limits.upper),
            Field::new("typical", |(_, p): &Row<'_>| {
                Cell::from(p.needed.typical).worded(
                    p.needed
                        .typical
                        .map_or("–".to_owned(), |t| scientific(t, 3)),
                )
            })
            .page("typical", ""),
            filed("margin", |(_, p): &Row<'_>| p.needed.margin),
            Field::new("U_needed", |(_, p): &Row<'_>| p.needed.expanded.into())
                .page("U needed", "")
                .rounded(Rounding::Significant(3)),
            Field::new("unit", |(l, _): &Row<'_>| l.unit.as_str().into()).page("unit", ""),
            Field::new("ratio", |(_, p): &Row<'_>| p.needed.ratio.into())
                .page("tolerance over U", "")
                .decimals(1),
            Field::new("command", |(_, p): &Row<'_>| p.command.into()),
            Field::new("what", |(_, p): &Row<'_>| {
                let told = match p.reached {
                    true => p.what.clone(),
                    false => format!("out of reach: {}", p.why),
                };
                Cell::from(p.what.as_str()).worded(told)
            })
            .page("what it takes", ""),
            filed("duration_s", |(_, p): &Row<'_>| p.duration),
            Field::new("reached", |(_, p): &Row<'_>| {
                if p.reached { "yes" } else { "no" }.into()
            }),
            Field::new("why", |(_, p): &Row<'_>| p.why.as_str().into()),
        ];
        let rows = self.planned.iter().map(|p| (&self.limits[p.limit], p));
        Table::of("Limits, and the expanded uncertainty that decides them; in the unit of the limit", fields, rows)
            .note(self.rule())
            .note("Tolerance over U: half the width of the tolerance over U; of one limit its distance from the typical value over U.")
            .file("planned.csv")
    }

    fn known(&self) -> Table {
        type Of = (&'static str, String);
        let fields = [
            Field::shown("what", "", |(what, _): &Of| (*what).into()),
            Field::shown("value", "", |(_, value): &Of| value.as_str().into()),
        ];
        let given = &self.given;
        let mut rows: Vec<Of> = Vec::new();
        let mut add = |what, value: Option<String>| rows.extend(value.map(|v| (what, v)));
        add("sampling rate", given.rate.map(|r| format!("{r} Hz")));
        let noise = |value: f64, unit: &str| {
            (value > 0.0).then(|| format!("{} {unit}", scientific(value, 3)))
        };
        add(
            "white noise N, two-sided",
            self.noise.and_then(|n| noise(n.white, "(m/s²)/√Hz")),
        );
        add(
            "bias instability B",
            self.noise.and_then(|n| noise(n.flicker, "m/s²")),
        );
        add(
            "random walk K",
            self.noise.and_then(|n| noise(n.walk, "(m/s²)·√Hz")),
        );
        add(
            "u of gravity",
            given.gravity_uncertainty.map(|u| format!("{u} m/s²")),
        );
        add(
            "u of the reference",
            given.reference_uncertainty.map(|u| format!("{u} %")),
        );
        add(
            "temperatures",
            given.temperature_range.as_ref().map(|r| {
                let ends: Vec<String> = r.iter().map(f64::to_string).collect();
                format!("{} °C", ends.join(" to "))
            }),
        );
        add(
            "largest acceleration",
            given.acceleration.map(|a| format!("{a} m/s²")),
        );
        add(
            "what varies between attitudes",
            (given.wander > 0.0).then(|| format!("{} m/s²", given.wander)),
        );
        add(
            "soak at each temperature",
            Some(format!("{} min", given.soak)),
        );
        Table::of("What the plan rests on", fields, rows)
    }
}
