//! The page of a step response.

use super::StepOutcome;
use crate::page::parameters::parameters;
use proofmass_report::number::{scientific, two_digits};
use proofmass_report::{Axis, KeyFigure, Report, Section, Series, XyPlot};

pub(super) fn add(page: Report, step: &StepOutcome) -> Report {
    let [rise, overshoot, settling] = step.figures;
    let figures = [
        KeyFigure::new("rise time", scientific(1e3 * rise, 4), "ms").note("10 % to 90 %"),
        KeyFigure::new("overshoot", format!("{:.2}", 100.0 * overshoot), "%"),
        KeyFigure::new("settling time", scientific(1e3 * settling, 4), "ms").note("to 2 %"),
    ];
    let table = parameters("Fitted oscillator", &step.estimate.quantities());
    let [record, fit, residual] = &step.traces;
    let (name, unit) = &step.channel;
    let plot = XyPlot::new(Axis::linear("time", "s"), Axis::linear(name, unit))
        .series(Series::line("recorded", &record.x, &record.y))
        .series(Series::line("fitted", &fit.x, &fit.y))
        .below(Axis::linear("recorded − fitted", unit))
        .series(Series::line("", &residual.x, &residual.y));
    let caption = "The step, the fitted oscillator, and what is left";
    let result = Section::new("Result").key_figures(figures).table(table);
    page.verdict(format!(
        "The step settles to 2 % within {} ms with an overshoot of {} %.",
        two_digits(1e3 * settling),
        two_digits(100.0 * overshoot)
    ))
    .section(result.summarised())
    .section(Section::new("Time history").figure(caption, plot))
}
