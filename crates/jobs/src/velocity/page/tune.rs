//! The report of a tuning: noise, gains, and what the innovations say.

use super::{VelocityReport, facts, figures, noise};
use proofmass_motion::{Crossover, TuneResult};
use proofmass_report::{Cell, Column, Report, Section, Table, scientific};

impl VelocityReport<'_> {
    /// What is worth a look in the terminal.
    pub(crate) fn tune_summary(&self, result: &TuneResult) -> Report {
        let w = &result.tuned.whiteness;
        let mut rows = noise(&result.tuned.model, self.angular, self.alone);
        rows.push((
            "innovations white with probability".to_owned(),
            scientific(w.p_white, 2),
        ));
        rows.push((
            "mean square of the normalised innovations".to_owned(),
            format!("{} (1 is due)", scientific(w.mean_square, 4)),
        ));
        self.head(result.samples.end).section(
            Section::new("Gains")
                .table(gains(result, &self.unit("m/s")))
                .table(facts("Noise, by maximum likelihood", rows)),
        )
    }

    /// The whole report.
    pub(crate) fn tune(&self, result: &TuneResult) -> Report {
        let mut tests = Section::new("Tests").figure(
            "Correlation of the innovations: of a model that describes both sensors 95 % lie within the lines",
            figures::whiteness(&result.tuned),
        );
        if let Some(plot) = figures::profile(&result.tuned, self.angular) {
            tests = tests.figure("Likelihood of the acceleration's noise", plot);
        }
        let methods = [
            ("two channels".to_owned(), result.two_channel.method),
            ("observer".to_owned(), result.observer.method),
        ];
        if let Some(plot) = figures::bode(&methods, self.sample_time) {
            tests = tests.figure(
                "Gain of the encoder's and the accelerometer's channel on the true velocity; the two of one filter add to one",
                plot,
            );
        }
        self.foot(self.tune_summary(result).section(tests))
    }
}

fn gains(result: &TuneResult, unit: &str) -> Table {
    let mut table = Table::new(
        "Gains, and the RMS difference of each filter to the smoother",
        [
            Column::text("filter"),
            Column::text("on the command line"),
            Column::number("RMS difference", unit),
        ],
    );
    for (name, found) in [
        ("Kalman filter", &result.kalman),
        ("two channels", &result.two_channel),
        ("observer", &result.observer),
    ] {
        table = table.row([
            Cell::text(name),
            Cell::text(word(found)),
            Cell::number(scientific(found.rms, 3)),
        ]);
    }
    table
}

/// The method as `proofmass velocity estimate --method` takes it.
fn word(found: &Crossover) -> String {
    found.method.word().unwrap_or_else(|| found.method.label())
}
