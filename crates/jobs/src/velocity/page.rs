//! Reports of velocities from an encoder and an accelerometer.

mod compare;
mod drift;
mod estimate;
mod figures;
mod map;
mod tune;

pub(crate) use drift::DriftReport;

use proofmass_motion::{KalmanModel, Pairing, ReadingSource};
use proofmass_report::{Cell, Column, Head, Report, Section, Table};

use proofmass_report::scientific;

/// What the readings are, readings and accelerations as they entered.
pub(crate) type Entered<'a> = (ReadingSource, &'a [Option<f64>], &'a [f64]);

/// What a velocity report tells beside the result itself.
///
/// **Units** m, s, m/s, m/s² throughout, as the result has them.
#[derive(Clone, Debug, Default)]
pub(crate) struct VelocityReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// Time of the first sample in the clock of the recording, s.
    pub start: f64,
    /// Sample time, s.
    pub sample_time: f64,
    /// Whether it is an angle: rad in place of m.
    pub angular: bool,
    /// What the readings are, readings and accelerations as they entered, where the page shows them.
    pub sensors: Option<Entered<'a>>,
    /// Whether there is no accelerometer, so that the acceleration itself is what walks.
    pub alone: bool,
}

/// A unit or heading of a length (m, mm/s, m/s², velocity_m/s) as it is of an angle, where it is one.
pub(crate) fn unit_of(of_length: &str, angular: bool) -> String {
    if !angular {
        return of_length.to_owned();
    }
    let letter = |c: Option<char>| c.is_some_and(char::is_alphanumeric);
    let mut out = String::new();
    let mut rest = of_length;
    // The last m of a word of one or two is the metre.
    while let Some(at) = rest.find('m') {
        let before = rest[..at].chars().next_back();
        let tail = &rest[at + 1..];
        let milli = tail.starts_with('m') && !letter(tail[1..].chars().next());
        let metre = !letter(tail.chars().next());
        out.push_str(&rest[..at]);
        if !letter(before) && (milli || metre) {
            out.push_str(if milli { "mrad" } else { "rad" });
            rest = if milli { &tail[1..] } else { tail };
        } else {
            out.push('m');
            rest = tail;
        }
    }
    out.push_str(rest);
    out
}

impl VelocityReport<'_> {
    /// A unit of a length as it is of an angle, where it is one.
    fn unit(&self, of_length: &str) -> String {
        unit_of(of_length, self.angular)
    }

    /// Head of every velocity report.
    fn head(&self, samples: usize) -> Report {
        let report = self.head.open().subtitle(format!(
            "{samples} samples at {} Hz, {} s",
            scientific(1.0 / self.sample_time, 5),
            scientific(samples as f64 * self.sample_time, 5)
        ));
        report.findings(self.head.findings.iter().cloned())
    }

    /// Inputs and last line.
    fn foot(&self, report: Report) -> Report {
        let mut inputs = Table::new("Inputs", [Column::text("file"), Column::text("SHA-256")]);
        for (name, digest) in &self.head.inputs {
            inputs = inputs.row([Cell::text(name.clone()), Cell::text(digest.clone())]);
        }
        report
            .section(Section::new("Inputs").table(inputs))
            .footer(self.head.footer.clone())
    }

    /// Time of a sample.
    fn time(&self, sample: usize) -> f64 {
        self.start + self.sample_time * sample as f64
    }

    /// Times of samples.
    fn times(&self, samples: std::ops::Range<usize>) -> Vec<f64> {
        samples.map(|k| self.time(k)).collect()
    }
}

/// Two columns: a quantity and its value.
fn facts(caption: &str, rows: impl IntoIterator<Item = (String, String)>) -> Table {
    let mut table = Table::new(caption, [Column::text("quantity"), Column::text("value")]);
    for (name, value) in rows {
        table = table.row([Cell::text(name), Cell::text(value)]);
    }
    table
}

/// The noise of a model in words.
fn noise(model: &KalmanModel, angular: bool, alone: bool) -> Vec<(String, String)> {
    use proofmass_motion::{BiasModel, ProcessNoise};
    let mut rows = vec![
        match model.noise_form {
            ProcessNoise::SampleConstant => (
                "noise of an acceleration sample by likelihood, √q".to_owned(),
                format!("{} m/s²", scientific(model.acceleration_noise.sqrt(), 3)),
            ),
            ProcessNoise::Continuous => (
                "density of the acceleration's noise by likelihood, √q".to_owned(),
                format!(
                    "{} (m/s²)/√Hz, two-sided",
                    scientific(model.acceleration_noise.sqrt(), 3)
                ),
            ),
        },
        (
            "noise of a reading by likelihood, √R".to_owned(),
            format!(
                "{} m, or m/s where a speed is read",
                scientific(model.reading_noise.sqrt(), 3)
            ),
        ),
    ];
    rows.push((
        match alone {
            false => "offset of the accelerometer".to_owned(),
            true => "acceleration of the axis".to_owned(),
        },
        match model.bias {
            None => "not a state: its likelihood does not pay for it".to_owned(),
            Some(BiasModel::RandomWalk { density: 0.0, .. }) => "an unknown constant".to_owned(),
            Some(BiasModel::RandomWalk { density, .. }) => {
                format!("random walk, {} (m/s²)/√s", scientific(density.sqrt(), 3))
            }
            Some(BiasModel::GaussMarkov { deviation, time }) => format!(
                "Gauss–Markov, {} m/s² over {} s",
                scientific(deviation, 3),
                scientific(time, 3)
            ),
        },
    ));
    for (_, value) in &mut rows {
        *value = unit_of(value, angular);
    }
    rows
}

/// Gain, latency and correlation of the two sensors.
fn pairing(pairing: &Pairing) -> Table {
    facts(
        "Do both sensors see one motion?",
        [
            (
                "velocity changes of the readings over those of the accelerometer".to_owned(),
                format!(
                    "{} with standard uncertainty {}",
                    scientific(pairing.gain, 5),
                    scientific(pairing.gain_uncertainty, 2)
                ),
            ),
            (
                "accelerometer later than the readings by".to_owned(),
                format!(
                    "{} ms with standard uncertainty {} ms",
                    scientific(1e3 * pairing.latency, 3),
                    scientific(1e3 * pairing.latency_uncertainty, 2)
                ),
            ),
            (
                "correlation".to_owned(),
                format!(
                    "{} over windows of {} s",
                    scientific(pairing.correlation, 4),
                    scientific(pairing.window, 3)
                ),
            ),
        ],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_units_of_an_angle() {
        assert_eq!(unit_of("smoothed_m/s", true), "smoothed_rad/s");
        assert_eq!(unit_of("mm/s²", true), "mrad/s²");
        assert_eq!(unit_of("m/s", false), "m/s");
    }
}
