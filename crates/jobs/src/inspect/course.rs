//! The course of the signals of a recording as a picture: a panel for each unit.

use proofmass_io::{ColumnSummary, Gap, Inspection, Trace, Unit};
use proofmass_report::{Axis, Series, XyPlot};

/// Panels under each other, and signals in one.
const PANELS: usize = 6;
const SIGNALS: usize = 4;

/// A column and its course.
type Signal<'a> = (&'a ColumnSummary, &'a Trace);

/// The picture with what stands below it; nothing where no signal has a number.
pub(super) fn plot(inspection: &Inspection, traces: &[Trace]) -> Option<(String, XyPlot)> {
    let column = |trace: &Trace| inspection.columns.iter().find(|c| c.number == trace.number);
    let drawn = traces.iter().filter(|trace| !trace.x.is_empty());
    let mut panels: Vec<(Option<Unit>, Vec<Signal<'_>>)> = Vec::new();
    let mut left_out = 0;
    for trace in drawn {
        let Some(column) = column(trace) else {
            continue;
        };
        let fits = |(unit, signals): &&mut (Option<Unit>, Vec<_>)| {
            *unit == column.unit && unit.is_some() && signals.len() < SIGNALS
        };
        let full = panels.len() == PANELS;
        match panels.iter_mut().rev().find(fits) {
            Some((_, signals)) => signals.push((column, trace)),
            None if full => left_out += 1,
            None => panels.push((column.unit, vec![(column, trace)])),
        }
    }
    let time = inspection.time.as_ref().map(|time| time.column.as_str());
    let signals = inspection
        .columns
        .iter()
        .filter(|c| Some(c.name.as_str()) != time);
    let seen = signals.filter(|c| c.statistics.is_some());
    left_out += seen.count().saturating_sub(traces.len());
    let x = match inspection.time.is_some() || inspection.reading.time.rate_hz.is_some() {
        true => Axis::linear("time from the first sample on", "s"),
        false => Axis::linear("row", ""),
    };
    let axis = |unit: Option<Unit>, signals: &[Signal<'_>]| {
        let unit = unit.map_or(String::new(), |u| u.to_string());
        match signals {
            [(column, _)] => Axis::linear(column.name.clone(), unit),
            _ => Axis::linear(unit, ""),
        }
    };
    let gaps: Vec<(f64, f64)> = inspection.time.as_ref().map_or_else(Vec::new, |time| {
        let begin = |gap: &Gap| gap.at_s - time.first_s;
        let ends = |gap: &Gap| (begin(gap), begin(gap) + gap.step_s);
        time.gaps.iter().map(ends).collect()
    });
    let mut plot: Option<XyPlot> = None;
    for (unit, signals) in &panels {
        let y = axis(*unit, signals);
        let mut panel = match plot {
            Some(plot) => plot.below(y),
            None => XyPlot::new(x.clone(), y),
        };
        for (column, trace) in signals {
            panel = panel.series(Series::line(column.name.clone(), &trace.x, &trace.y));
        }
        plot = Some(panel.shade("gap", &gaps));
    }
    let more = match left_out {
        0 => String::new(),
        1 => "; one more is not drawn".to_owned(),
        n => format!("; {n} more are not drawn: choose them with --columns"),
    };
    let caption = format!("The signals, smallest and largest values kept{more}");
    plot.map(|plot| (caption, plot))
}
