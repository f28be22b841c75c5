//! The report of a tuning: noise, gains, and what the innovations say.

use super::{facts, figures, given_back, noise};
use crate::page::answer::stated;
use crate::page::columns::filed;
use crate::page::measures::lines;
use crate::velocity::VelocityTuning;
use proofmass_motion::{Crossover, TuneResult};
use proofmass_report::{Cell, KeyFigure, Report, Section, Table, scientific};
use proofmass_uncertainty::Severity;

pub(in crate::velocity) fn tune(page: Report, outcome: &VelocityTuning) -> Report {
    let (head, result) = (&outcome.head, &outcome.result);
    let w = &result.tuned.whiteness;
    let mut rows = noise(&result.tuned.model, head);
    rows.extend([
        [
            "innovations white with probability".to_owned(),
            scientific(w.p_white, 2),
        ],
        [
            "mean square of the normalised innovations".to_owned(),
            format!("{} (1 is expected)", scientific(w.mean_square, 4)),
        ],
    ]);
    let profile = [
        filed(head.unit("q_(m/s2)2"), |p: &(f64, f64)| p.0),
        filed("log_likelihood_below_maximum", |p: &(f64, f64)| p.1),
    ];
    let profile = Table::of("", profile, &result.tuned.profile).file("likelihood.csv");
    let mut tests = Section::new("Tests").figure(
        "Correlation of the innovations: of a model that describes both sensors 95 % lie within the lines",
        figures::whiteness(&result.tuned),
    );
    if let Some(plot) = figures::profile(&result.tuned, head.angular) {
        tests = tests.figure("Likelihood of the acceleration's noise", plot);
    }
    let methods = [
        ("two channels".to_owned(), result.two_channel.method),
        ("observer".to_owned(), result.observer.method),
    ];
    if let Some(plot) = figures::bode(&methods, head.sample_time) {
        tests = tests.figure(
            "Gain of the encoder's and the accelerometer's channel on the true velocity; the two of one filter add to one",
            plot,
        );
    }
    let p = scientific(w.p_white, 2);
    let page = head.opened(page, result.samples.end);
    let corner = result.low_corner.map_or(String::new(), given_back);
    let corner = corner + &head.part().unwrap_or_default();
    // What is told of the innovations is decided with the finding: by the size of their correlation, not by its significance.
    let correlated = head
        .findings
        .iter()
        .find(|f| f.code() == "innovations-correlated");
    let page = match (correlated, w.p_white < 0.05) {
        (Some(note), _) if note.severity() == Severity::Note => page.verdict(format!(
            "Noise and gains stand, though {}.{corner}",
            note.what()
        )),
        (Some(_), _) => page.question(format!(
            "The innovations are correlated (p = {p}): the model does not describe both sensors, and the gains are the best of it.{corner}"
        )),
        (None, true) => page.verdict(format!(
            "The model describes both sensors: the largest correlation of the innovations, {}, does not matter (p = {p}).{corner}",
            scientific(w.largest_correlation.1, 2)
        )),
        (None, false) => page.verdict(format!(
            "The model describes both sensors: the innovations are white (p = {p}).{corner}"
        )),
    };
    let page = page
        .answers(
            filters(result)
                .map(|(name, found)| KeyFigure::new(name, word(found), "").note("--method")),
        )
        .answers(head.quantities.iter().map(stated));
    page.section(
        Section::new("Gains")
            .table(gains(result, &head.unit("m/s")))
            .table(facts("Noise, by maximum likelihood", rows))
            .summarised(),
    )
    .section(tests)
    .section(Section::filed([profile]))
}

fn filters(result: &TuneResult) -> [(&'static str, &Crossover); 3] {
    [
        ("Kalman filter", &result.kalman),
        ("two channels", &result.two_channel),
        ("observer", &result.observer),
    ]
}

fn gains(result: &TuneResult, unit: &str) -> Table {
    lines(
        "Gains, and the RMS difference of each filter to the smoother",
        [
            ("filter", ""),
            ("on the command line", ""),
            ("RMS difference", unit),
        ],
        filters(result).map(|(name, found)| {
            [
                name.into(),
                word(found).into(),
                Cell::number(scientific(found.rms, 3)),
            ]
        }),
    )
}

/// The method as `proofmass velocity estimate --method` takes it.
fn word(found: &Crossover) -> String {
    found.method.word().unwrap_or_else(|| found.method.label())
}
