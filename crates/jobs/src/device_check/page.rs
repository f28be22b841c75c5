//! The report of devices against their data sheet.

use super::judged::{Shown, of_axis};
use super::{DeviceCheckOutcome, DeviceVerdict, JudgedLimit, SheetVerdict, UsedResult};
use crate::certificate::RuleWord;
use crate::data_sheet::{Grade, ReadLimit};
use crate::page::columns::filed;
use crate::plural::count;
use proofmass_report::{Cell, Field, KeyFigure, Report, Section, Table, scientific};

/// Verdicts in the order in which they are told.
const WORDS: [SheetVerdict; 4] = [
    SheetVerdict::Pass,
    SheetVerdict::Fail,
    SheetVerdict::Undecided,
    SheetVerdict::NotShown,
];

pub(super) fn add(page: Report, outcome: &DeviceCheckOutcome) -> Report {
    let mut page = page.verdict(outcome.verdict()).answers(outcome.answer());
    let verdicts = Section::new("Limits").table(outcome.verdicts());
    page = page
        .section(
            Section::new("Devices")
                .table(outcome.summary())
                .summarised(),
        )
        .section(verdicts.summarised());
    page.section(
        Section::new("Grades")
            .table(outcome.graded())
            .table(outcome.grade_limits()),
    )
    .section(Section::new("Results that were read").table(outcome.used()))
}

/// A limit of a device.
type Row<'a> = (&'a DeviceVerdict, &'a ReadLimit, &'a JudgedLimit);

fn value(shown: &Shown) -> String {
    match shown.value {
        Some(v) => scientific(v, 4),
        None => format!("below {}", scientific(shown.high, 3)),
    }
}

impl DeviceCheckOutcome {
    fn total(&self, verdict: SheetVerdict) -> usize {
        self.devices.iter().map(|d| d.count(verdict)).sum()
    }

    fn verdict(&self) -> String {
        let all: usize = WORDS.into_iter().map(|v| self.total(v)).sum();
        let [pass, fail, open, missing] = WORDS.map(|v| self.total(v));
        let devices = match self.devices.len() {
            1 => String::new(),
            n => {
                let failed = self
                    .devices
                    .iter()
                    .filter(|d| d.verdict() == SheetVerdict::Fail);
                match failed.count() {
                    0 => format!(" of {n} devices"),
                    bad => format!(" of {bad} of {n} devices"),
                }
            }
        };
        let also = |counts: &[(usize, &str)]| -> String {
            let told = counts.iter().filter(|(n, _)| *n > 0);
            told.map(|(n, word)| format!("; {n} {word}")).collect()
        };
        match SheetVerdict::over(self.devices.iter().map(DeviceVerdict::verdict)) {
            SheetVerdict::Pass => format!("Passed: all {all} limits{devices} are met."),
            SheetVerdict::Fail => format!(
                "Failed: {fail} of {all} limits{devices} exceeded ({}){}.",
                self.failed(),
                also(&[(pass, "met"), (open, "undecided"), (missing, "not shown")])
            ),
            SheetVerdict::Undecided => format!(
                "Undecided: {open} of {all} limits{devices} lie within the interval{}.",
                also(&[(pass, "met"), (missing, "not shown")])
            ),
            SheetVerdict::NotShown => format!(
                "Not shown: {missing} of {all} limits{devices} measured by no result{}.",
                also(&[(pass, "met")])
            ),
        }
    }

    /// Every limit of every device.
    fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.devices.iter().flat_map(move |d| {
            let limits = d.limits.iter();
            limits.map(move |row| (d, &self.limits[row.limit], row))
        })
    }

    /// The characteristics that some device exceeds, each once, the first of them by name.
    fn failed(&self) -> String {
        const NAMED: usize = 5;
        let mut names: Vec<String> = Vec::new();
        for (_, limit, row) in self.rows() {
            let name = of_axis(limit.characteristic.name(), &row.axis);
            if row.verdict == SheetVerdict::Fail && !names.contains(&name) {
                names.push(name);
            }
        }
        let more = names.len().saturating_sub(NAMED);
        names.truncate(NAMED);
        match more {
            0 => names.join(", "),
            n => format!("{} and {n} more", names.join(", ")),
        }
    }

    fn answer(&self) -> Vec<KeyFigure> {
        let mut figures = vec![KeyFigure::new(
            "devices",
            self.devices.len().to_string(),
            "",
        )];
        figures.extend(WORDS.map(|v| {
            let note = "limits, axis by axis";
            KeyFigure::new(v.word(), self.total(v).to_string(), "").note(note)
        }));
        if let [one] = &self.devices[..] {
            let grade = one.grade().unwrap_or("none reached");
            figures
                .push(KeyFigure::new("grade", grade, "").note("by published limits, no standard"));
        }
        figures
    }

    fn summary(&self) -> Table {
        let mut fields = vec![
            Field::new("device", |d: &DeviceVerdict| d.name().into()).page("device", ""),
            Field::new("verdict", |d: &DeviceVerdict| d.verdict().word().into())
                .page("verdict", ""),
        ];
        for (name, verdict) in [
            ("pass", SheetVerdict::Pass),
            ("fail", SheetVerdict::Fail),
            ("undecided", SheetVerdict::Undecided),
            ("not_shown", SheetVerdict::NotShown),
        ] {
            let count = move |d: &DeviceVerdict| d.count(verdict).into();
            fields.push(Field::new(name, count).page(verdict.word(), ""));
        }
        fields.push(
            Field::new("grade", |d: &DeviceVerdict| d.grade().unwrap_or("–").into())
                .page("grade", ""),
        );
        Table::of(
            "Devices, with the number of their limits",
            fields,
            &self.devices,
        )
        .file("devices.csv")
    }

    fn rule(&self) -> String {
        let decision = self.sheet.decision;
        match decision.rule {
            RuleWord::Simple => "Rule: simple acceptance with shared risk. The value alone decides; at its limit a device passes with 50 %.".to_owned(),
            RuleWord::GuardBand => format!(
                "Rule: guard band w = {} U. Pass: the interval lies within the limit; fail: all of it lies beyond; undecided: the limit lies in it. With U of \
                 95 % and w = U a device beyond its limit passes with 2.5 % at most, and one within it fails with as much.",
                decision.r
            ),
        }
    }

    fn verdicts(&self) -> Table {
        let device = Field::new("device", |(d, ..): &Row<'_>| d.name().into());
        let fields = [
            match self.devices.len() {
                1 => device,
                _ => device.page("device", ""),
            },
            Field::new("characteristic", |(_, l, _): &Row<'_>| {
                l.characteristic.name().into()
            }),
            Field::new("axis", |(.., row): &Row<'_>| row.axis.as_str().into()),
            Field::shown("characteristic", "", |(_, l, row): &Row<'_>| {
                of_axis(l.characteristic.name(), &row.axis).into()
            }),
            Field::new("verdict", |(.., row): &Row<'_>| row.verdict.word().into())
                .page("verdict", ""),
            Field::shown("limit", "", |(_, l, _): &Row<'_>| {
                match l.where_it_holds().as_str() {
                    "" => l.words(),
                    place => format!("{} ({place})", l.words()),
                }
                .into()
            }),
            filed("where", |(_, l, _): &Row<'_>| l.where_it_holds()),
            filed("lower_limit", |(_, l, _): &Row<'_>| l.limits.lower),
            filed("upper_limit", |(_, l, _): &Row<'_>| l.limits.upper),
            Field::new("value", |(.., row): &Row<'_>| {
                let shown = row.shown.as_ref();
                let said = shown.map_or("–".to_owned(), value);
                Cell::from(shown.and_then(|s| s.value)).worded(said)
            })
            .page("value", ""),
            Field::shown("interval, or why", "", |(.., row): &Row<'_>| {
                match (&row.shown, row.why.as_str()) {
                    (Some(s), "") => {
                        format!("{} to {}", scientific(s.low, 4), scientific(s.high, 4))
                    }
                    (_, why) => why.to_owned(),
                }
                .into()
            }),
            filed("low", |(.., row): &Row<'_>| {
                row.shown.as_ref().map(|s| s.low)
            }),
            filed("high", |(.., row): &Row<'_>| {
                row.shown.as_ref().map(|s| s.high)
            }),
            Field::new("unit", |(_, l, _): &Row<'_>| l.unit.as_str().into()),
            Field::new("conforms_%", |(.., row): &Row<'_>| {
                let conforms = row.shown.as_ref().and_then(|s| s.conforms);
                conforms.map(|p| 100.0 * p).into()
            })
            .page("conforms", "%")
            .decimals(1),
            filed("frequency_Hz", |(.., row): &Row<'_>| {
                row.shown.as_ref().and_then(|s| s.frequency)
            }),
            filed("quantity", |(.., row): &Row<'_>| {
                row.shown.as_ref().map(|s| s.quantity.clone())
            }),
            filed("result", |(.., row): &Row<'_>| {
                row.shown.as_ref().map(|s| s.result.clone())
            }),
            Field::new("why", |(.., row): &Row<'_>| row.why.as_str().into()),
        ];
        let rows = self.rows();
        Table::of("Limits, one by one; values in the unit of the limit", fields, rows)
            .note(self.rule())
            .note("Conforms: the probability that the limit holds, by the interval alone. Over frequency the gravest point stands here.")
            .file("verdicts.csv")
    }

    fn graded(&self) -> Table {
        type Of<'a> = (&'a DeviceVerdict, &'a super::GradeVerdict);
        let fields = [
            Field::new("device", |(d, _): &Of<'_>| d.name().into()).page("device", ""),
            Field::new("grade", |(_, g): &Of<'_>| g.name.as_str().into()).page("grade", ""),
            Field::new("verdict", |(_, g): &Of<'_>| g.verdict.word().into()).page("verdict", ""),
            Field::new("why", |(_, g): &Of<'_>| g.why.as_str().into()).page("against it", ""),
        ];
        let rows = self
            .devices
            .iter()
            .flat_map(|d| d.grades.iter().map(move |g| (d, g)));
        Table::of("Grades that the devices reach", fields, rows)
            .note("No standard fixes the limits of a grade. A grade is reached where all of the limits below are met, by the rule above.")
            .file("grades.csv")
    }

    fn grade_limits(&self) -> Table {
        type Of<'a> = (&'a Grade, String);
        let fields = [
            Field::shown("grade", "", |(g, _): &Of<'_>| g.name.as_str().into()),
            Field::shown("limits", "", |(_, words): &Of<'_>| words.as_str().into()),
            Field::shown("source", "", |(g, _): &Of<'_>| g.source.as_str().into()),
        ];
        let words = |grade: &Grade| -> String {
            let read = grade.limit.iter().filter_map(|l| l.read().ok());
            let told = read.map(|l| match l.where_it_holds().as_str() {
                "" => format!("{} {}", l.characteristic.name(), l.words()),
                place => format!("{} {} ({place})", l.characteristic.name(), l.words()),
            });
            match grade.limit.is_empty() {
                true => "none are published".to_owned(),
                false => told.collect::<Vec<_>>().join("; "),
            }
        };
        let rows = self.grades.iter().map(|g| (g, words(g)));
        Table::of("Limits of the grades", fields, rows)
    }

    fn used(&self) -> Table {
        let fields = [
            Field::new("result", |r: &UsedResult| r.name.as_str().into()).page("result", ""),
            Field::new("kind", |r: &UsedResult| r.kind.as_str().into()).page("kind", ""),
            Field::new("states_device", |r: &UsedResult| r.device.as_str().into())
                .page("device as stated", ""),
            Field::new("quantities", |r: &UsedResult| r.quantities.into())
                .page("quantities of a device", ""),
        ];
        let caption = format!("{} in all", count(self.results.len(), "result"));
        Table::of(caption, fields, &self.results).file("results.csv")
    }
}
