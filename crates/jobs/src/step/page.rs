//! The page of a step response.

use super::StepOutcome;
use crate::page::parameters::parameters;
use proofmass_report::number::{scientific, two_digits};
use proofmass_report::{Axis, KeyFigure, Report, Section, Series, XyPlot};

pub(super) fn add(page: Report, step: &StepOutcome) -> Report {
    let [rise, overshoot] = step.figures;
    let settling = step.settling_time.map(|t| 1e3 * t);
    let mut figures = vec![
        KeyFigure::new("rise time", scientific(1e3 * rise, 4), "ms").note("10 % to 90 %"),
        KeyFigure::new("overshoot", format!("{:.2}", 100.0 * overshoot), "%"),
    ];
    if let Some(settling) = settling {
        let figure = KeyFigure::new("settling time", scientific(settling, 4), "ms");
        figures.push(figure.note("to 2 %"));
    }
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
    let overshoot = two_digits(100.0 * overshoot);
    page.verdict(match settling {
        Some(settling) => format!(
            "The step settles to 2 % within {} ms with an overshoot of {overshoot} %.",
            two_digits(settling)
        ),
        None => format!("The swing is not seen to decay; the overshoot is {overshoot} %."),
    })
    .section(result.summarised())
    .section(Section::new("Time history").figure(caption, plot))
}
