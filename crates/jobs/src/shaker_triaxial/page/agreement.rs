//! Whether the runs agree: residuals and Monte Carlo.

use super::super::tables::session_gain;
use super::sign;
use crate::page::columns::{frequency, printed, words};
use proofmass_report::number::two_digits;
use proofmass_report::{Axis, Section, Series, SpherePlot, Table, XyPlot, scientific};
use proofmass_shaker::{
    ComponentCheck, FrequencyCheck, MethodResult, Reproducibility, RunResult, SessionGain,
    ShakerCalibration, Suspicion,
};
use proofmass_uncertainty::Verdict;

/// Runs of one direction with the root mean square of their 18 studentised residuals … of every frequency.
struct Direction<'a> {
    direction: [f64; 3],
    runs: Vec<&'a RunResult>,
}

impl Direction<'_> {
    fn root_mean_square(&self) -> f64 {
        let all = || self.runs.iter().flat_map(|r| r.studentised.as_flattened());
        (all().map(|v| v * v).sum::<f64>() / all().count().max(1) as f64).sqrt()
    }
}

fn directions(result: &MethodResult) -> Vec<Direction<'_>> {
    let mut list: Vec<Direction> = vec![];
    for run in &result.runs {
        let same = |d: &Direction| (0..3).all(|k| (d.direction[k] - run.direction[k]).abs() < 1e-6);
        match list.iter_mut().find(|d| same(d)) {
            Some(d) => d.runs.push(run),
            None => list.push(Direction {
                direction: run.direction,
                runs: vec![run],
            }),
        }
    }
    list
}

pub(super) fn residuals(calibration: &ShakerCalibration, result: &MethodResult) -> Section {
    let chi = result.chi_squared.map_or(String::new(), |(chi, dof)| {
        format!(
            "χ² = {} with {dof} degrees of freedom (a factor of {:.2} in u). ",
            scientific(chi, 3),
            (chi / dof.max(1) as f64).sqrt()
        )
    });
    let mut sphere = SpherePlot::new("rms studentised residual", "");
    for d in directions(result) {
        sphere = sphere.point(d.direction, d.root_mean_square(), "");
    }
    let number: Vec<f64> = (1..=result.runs.len()).map(|i| i as f64).collect();
    let statistic: Vec<f64> = result.runs.iter().map(|r| r.statistic).collect();
    let mut plot = XyPlot::new(
        Axis::linear("run", "").range(0.0, result.runs.len() as f64 + 1.0),
        Axis::linear("χ² of the run", ""),
    )
    .height(220.0)
    // χ² with six degrees of freedom: 95 % and 99.9 %.
    .horizontal(12.59, "95 %")
    .horizontal(22.46, "99.9 %")
    .series(Series::markers("", &number, &statistic));
    let mut last = None;
    for (i, run) in result.runs.iter().enumerate() {
        if last != Some(run.frequency) && i > 0 {
            plot = plot.vertical(i as f64 + 0.5, "");
        }
        last = Some(run.frequency);
    }
    let mut worst: Vec<&RunResult> = result.runs.iter().collect();
    worst.sort_by(|a, b| b.statistic.total_cmp(&a.statistic));
    type R = RunResult;
    let residuals = |run: &R| {
        let parts = run.studentised.iter();
        let parts = parts.map(|[re, im]| sign(format!("{re:.1}, {im:.1}")));
        parts.collect::<Vec<_>>().join("; ")
    };
    let explanation = |run: &R| {
        let mut suspects = calibration.suspects.iter();
        let suspect = suspects.find(|s| s.run == run.run);
        suspect.map_or("", |s| match s.suspicion {
            Suspicion::Channels { .. } => "channels exchanged or inverted",
            Suspicion::Mounting { .. } | Suspicion::UpsideDown => {
                "mounted as another configuration"
            }
            Suspicion::Gain { .. } => "read with another gain",
            Suspicion::Dead { .. } => "without signal",
            Suspicion::Frequency { .. } => "taken at another frequency",
            Suspicion::Copied { .. } => "copied from another run",
            Suspicion::Clipped { .. } => "cut off",
            Suspicion::Either(..) => "one of two, see the findings",
            _ => "none found",
        })
    };
    let mut fields = vec![words("run", |r: &R| r.run.clone())];
    if result.runs.iter().any(|r| r.session.is_some()) {
        let session = |r: &R| r.session.clone().unwrap_or_default();
        fields.push(words("session", session));
    }
    fields.extend([
        frequency(|r: &R| r.frequency),
        printed("χ²", "", |r: &R| format!("{:.1}", r.statistic)),
        words("studentised residuals x, y, z (real, imaginary)", residuals),
        printed("influence", "u", |r: &R| format!("{:.2}", r.influence)),
        words("explanation", explanation),
    ]);
    let caption = "The runs that differ most from what the others predict";
    let table = Table::of(caption, fields, worst.into_iter().take(8)).note(
        "Influence: largest change of a component of S without the run, in its standard uncertainties.",
    );
    Section::new("Agreement of the runs")
        .paragraph(format!(
            "{chi}Each run is compared with what all other runs predict for it: six real numbers, studentised, and their χ². \
             One is the value to be expected of a studentised residual."
        ))
        .figure(
            "Directions of the excitation in the axes of the device, coloured by the root mean square of the studentised \
             residuals of all runs in that direction",
            sphere,
        )
        .figure(
            "χ² of every run in the order of the campaign; vertical lines part the frequencies",
            plot,
        )
        .table(table)
}

/// Gains of the sessions against each other.
pub(super) fn sessions(told: &Reproducibility) -> Section {
    let percent = |u: f64| two_digits(100.0 * u);
    let degrees = |u: f64| two_digits(u.to_degrees());
    let mut words = "The gain of each output in each session over its mean of the sessions that are compared, with everything else \
         fitted. u is what readings, mountings and the inputs of the budget that vary with the session make of it."
        .to_owned();
    if !told.gains.is_empty() {
        words += &format!(
            " All differences together: F = {:.2} with {:.0} and {:.0} degrees of freedom, p = {:.2}. Beyond u the sessions scatter by {} % \
             and {}° (standard deviations).",
            told.statistic,
            told.dof[0],
            told.dof[1],
            told.p_value,
            percent(told.spread[0]),
            degrees(told.spread[1]),
        );
    }
    for between in &told.between {
        let (what, size) = match between.phase {
            true => (
                "phase",
                format!("{}°", degrees(between.standard_uncertainty)),
            ),
            false => (
                "gain",
                format!("{} %", percent(between.standard_uncertainty)),
            ),
        };
        words += &format!(
            " How far the {what} of an output changes from session to session was not declared: it is {size} by restricted maximum likelihood \
             (ν = {:.1}), and U has it.",
            between.dof.get()
        );
    }
    for (session, why) in &told.uncompared {
        words += &format!(" Session {session} is not compared: {why}.");
    }
    let section = Section::new("Reproducibility between sessions").paragraph(words);
    match told.gains.is_empty() {
        true => section,
        false => section.table(Table::of(
            "Gains of the sessions",
            session_gain(|g: &SessionGain| g),
            &told.gains,
        )),
    }
}

/// Verdicts of the law of propagation against Monte Carlo.
pub(super) fn monte_carlo(checks: &[FrequencyCheck]) -> Option<Section> {
    let first = checks.first()?;
    let total: usize = checks.iter().map(|c| c.components.len()).sum();
    let count = |verdict| -> usize { checks.iter().map(|c| c.count(verdict)).sum() };
    type R = FrequencyCheck;
    let departure = |v: &ComponentCheck| {
        (0..2)
            .map(|e| (v.interval[e] - v.linear_interval[e]).abs() / v.linear)
            .fold(0.0, f64::max)
    };
    let of =
        |heading: &str, verdict| printed(heading, "", move |c: &R| c.count(verdict).to_string());
    let fields = [
        frequency(|c: &R| c.frequency),
        printed("trials", "", |c: &R| c.trials.to_string()),
        of("agree", Verdict::Validated),
        of("differ", Verdict::NotValidated),
        of("open", Verdict::Undecided),
        words("largest departure of an end of an interval", |c: &R| {
            let components = c.components.iter();
            let worst = components.max_by(|a, b| departure(a).total_cmp(&departure(b)));
            worst.map_or(String::new(), |v| {
                format!(
                    "{} u at {}",
                    two_digits(departure(v)),
                    component(&v.component)
                )
            })
        }),
    ];
    let table = Table::of(
        "Law of propagation against Monte Carlo, per frequency",
        fields,
        checks,
    );
    Some(
        Section::new("Monte Carlo check")
            .paragraph(format!(
                "Every input drawn from its distribution with its degrees of freedom and what shares it, angles through sines \
                 and products through products, the spurious motion within what is known of it, and the estimator applied \
                 anew in each of {} trials. Of {total} components of S, {} have 95 % intervals that agree with the stated ones \
                 within half a unit of the first digit of u (JCGM 101:2008, clause 8), {} differ, and for {} so many trials \
                 cannot tell.",
                first.trials,
                count(Verdict::Validated),
                count(Verdict::NotValidated),
                count(Verdict::Undecided),
            ))
            .table(table),
    )
}

/// `xx.re` as Re S_xx.
fn component(name: &str) -> String {
    match name.split_once('.') {
        Some((term, "re")) => format!("Re S_{term}"),
        Some((term, "im")) => format!("Im S_{term}"),
        _ => name.to_owned(),
    }
}
