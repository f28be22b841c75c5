//! The page of a recorded motion.

use super::{MotionOutcome, MotionSpectrum};
use crate::page::measures::measures;
use proofmass_core::STANDARD_GRAVITY;
use proofmass_report::number::{concise, plain, two_digits};
use proofmass_report::{Axis, Cell, Field, Report, Section, Series, Table, XyPlot, scientific};
use proofmass_uncertainty::Quantity;

pub(super) fn add(page: Report, motion: &MotionOutcome) -> Report {
    let spectrum = motion.spectrum();
    let damping = plain(100.0 * motion.request.damping);
    let peak = motion.figures().peak_acceleration.abs();
    let duration = motion.figures().duration_5_95;
    let judged = motion.required();
    let answer = judged.map_or(String::new(), |j| format!("{} ", j.verdict()));
    let mut page = page.verdict(format!(
        "{answer}The acceleration reaches {} g; 5 % to 95 % of the motion take {} s.",
        two_digits(peak / STANDARD_GRAVITY),
        two_digits(duration)
    ));
    if let Some(judged) = judged {
        page = page.section(judged.section());
    }
    page.section(Section::new("Result").table(figures(motion)).summarised())
    .section(Section::new("Time history").figure(
        "Acceleration as corrected, and its integrals from rest",
        history(motion),
    ))
    .section(Section::new("Response spectrum").figure(
        format!(
            "Greatest response within the record of oscillators with a damping ratio of {damping} %"
        ),
        plot(spectrum),
    ))
    .section(Section::filed(
        [table(spectrum)]
            .into_iter()
            .chain(judged.map(|j| j.table())),
    ))
}

fn figures(motion: &MotionOutcome) -> Table {
    let quantity = |q: Quantity| {
        // Without an uncertainty of the acceleration none of its figures has one: four digits then, and no claim.
        let value = match q.standard_uncertainty > 0.0 {
            true => concise(q.value, q.standard_uncertainty),
            false => scientific(q.value, 4),
        };
        (q.name.replace('_', " "), Cell::number(value), q.unit)
    };
    let f = motion.figures();
    let durations = [
        ("duration 5–75 %", Some(f.duration_5_75)),
        ("duration 5–95 %", Some(f.duration_5_95)),
        ("bracketed duration", f.bracketed_duration),
    ];
    let durations = durations.into_iter().filter_map(|(name, d)| {
        let value = Cell::number(format!("{:.3}", d?));
        Some((name.to_owned(), value, "s".to_owned()))
    });
    let rows = motion.all().into_iter().map(quantity).chain(durations);
    measures("Figures of the record", "figure", rows)
}

fn history(motion: &MotionOutcome) -> XyPlot {
    let [a, v, x] = &motion.traces;
    XyPlot::new(
        Axis::linear("time", "s"),
        Axis::linear("acceleration", "m/s²"),
    )
    .series(Series::line("", &a.x, &a.y))
    .below(Axis::linear("velocity", "m/s"))
    .series(Series::line("", &v.x, &v.y))
    .below(Axis::linear("displacement", "m"))
    .series(Series::line("", &x.x, &x.y))
}

fn plot(spectrum: &MotionSpectrum) -> XyPlot {
    let line = |name: &str, y: &[f64]| {
        let pairs = spectrum.period.iter().copied().zip(y.iter().copied());
        let (x, y): (Vec<f64>, Vec<f64>) = pairs.filter(|(_, y)| *y > 0.0).unzip();
        Series::line(name, &x, &y)
    };
    XyPlot::new(Axis::log("period", "s"), Axis::log("acceleration", "m/s²"))
        .series(line("pseudo-acceleration", &spectrum.pseudo_acceleration()))
        .series(line("absolute acceleration", &spectrum.acceleration))
        .below(Axis::log("relative displacement", "m"))
        .series(line("", &spectrum.displacement))
}

fn table(spectrum: &MotionSpectrum) -> Table {
    let fields = [
        Field::series("period_s", &spectrum.period),
        Field::series("displacement_m", &spectrum.displacement),
        Field::series("velocity_m/s", &spectrum.velocity),
        Field::series("acceleration_m/s2", &spectrum.acceleration),
        Field::series(
            "pseudo_velocity_m/s",
            spectrum.pseudo(1, &spectrum.displacement),
        ),
        Field::series("pseudo_acceleration_m/s2", spectrum.pseudo_acceleration()),
        Field::series(
            "pseudo_acceleration_at_samples_m/s2",
            spectrum.pseudo(2, &spectrum.displacement_at_samples),
        ),
    ];
    Table::of("", fields, 0..spectrum.period.len()).file("response_spectrum.csv")
}
