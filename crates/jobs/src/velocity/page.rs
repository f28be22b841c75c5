//! Reports of velocities from an encoder and an accelerometer.

mod compare;
mod drift;
mod estimate;
mod figures;
mod integrator;
mod map;
mod tune;

pub(super) use compare::compare;
pub(super) use drift::drift;
pub(super) use estimate::estimate;
pub(super) use integrator::integrator;
pub(super) use map::map;
pub(super) use tune::tune;

use super::outcome::Head;
use crate::page::words::words;
use proofmass_motion::{KalmanModel, LowCorner, Pairing, ReadingSource, Tuned};
use proofmass_report::{Report, Table, scientific};

/// The sentence, behind another, that a corner of the accelerometer was taken account of.
fn given_back(corner: LowCorner) -> String {
    let stages = if corner.order > 1 {
        "two stages"
    } else {
        "one stage"
    };
    let u = match corner.uncertainty > 0.0 {
        true => format!(" (u = {})", scientific(corner.uncertainty, 2)),
        false => String::new(),
    };
    format!(
        " What the accelerometer loses below a corner of {} Hz{u}, of {stages}, is given back.",
        scientific(corner.frequency, 4)
    )
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

impl Head {
    /// The line under the title of every velocity page.
    fn opened(&self, page: Report, samples: usize) -> Report {
        let encoder = self.encoder.as_ref();
        let encoder = encoder.map_or(String::new(), |told| format!("; {told}"));
        page.subtitle(format!(
            "{samples} samples at {} Hz, {} s{encoder}",
            scientific(1.0 / self.sample_time, 5),
            scientific(samples as f64 * self.sample_time, 5)
        ))
    }

    /// Times of samples.
    fn times(&self, samples: std::ops::Range<usize>) -> Vec<f64> {
        samples.map(|k| self.time(k)).collect()
    }
}

/// Two columns: a quantity and its value.
fn facts(caption: &str, rows: impl IntoIterator<Item = [String; 2]>) -> Table {
    words(caption, ["quantity", "value"], rows)
}

/// The noise of a model in words.
fn noise(model: &KalmanModel, head: &Head) -> Vec<[String; 2]> {
    use proofmass_motion::{BiasModel, ProcessNoise};
    let (angular, alone) = (head.angular, head.alone);
    let read = match head.source {
        ReadingSource::Position => "m",
        ReadingSource::Speed => "m/s",
    };
    let mut rows = vec![
        match model.noise_form {
            ProcessNoise::SampleConstant => [
                "noise of an acceleration sample by likelihood, √q".to_owned(),
                format!("{} m/s²", scientific(model.acceleration_noise.sqrt(), 3)),
            ],
            ProcessNoise::Continuous => [
                "density of the acceleration's noise by likelihood, √q".to_owned(),
                format!(
                    "{} (m/s²)/√Hz, two-sided",
                    scientific(model.acceleration_noise.sqrt(), 3)
                ),
            ],
        },
        [
            "noise of a reading by likelihood, √R".to_owned(),
            format!("{} {read}", scientific(model.reading_noise.sqrt(), 3)),
        ],
    ];
    rows.push([
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
    ]);
    for [_, value] in &mut rows {
        *value = unit_of(value, angular);
    }
    rows
}

/// Gain, latency and correlation of the two sensors: what windows of the record tell, and the latency that is used, where the
/// likelihood of all readings tells it better.
fn pairing(pairing: &Pairing, tuned: Option<&Tuned>) -> Table {
    let ms = |value: f64, u: f64| {
        format!(
            "{} ms with standard uncertainty {} ms",
            scientific(1e3 * value, 3),
            scientific(1e3 * u, 2)
        )
    };
    let used = tuned.and_then(|tuned| tuned.latency);
    let gain = format!(
        "{} with standard uncertainty {}",
        scientific(pairing.gain, 5),
        scientific(pairing.gain_uncertainty, 2)
    );
    let mut rows = vec![[
        "gain of the accelerometer: its velocity changes over those of the readings".to_owned(),
        gain,
    ]];
    rows.extend(used.map(|used| {
        [
            "accelerometer later than the readings by, from the likelihood of all readings; this is used".to_owned(),
            ms(used.value, used.uncertainty),
        ]
    }));
    rows.push([
        match used {
            Some(_) => "the same from velocity changes alone, as a check".to_owned(),
            None => "accelerometer later than the readings by".to_owned(),
        },
        ms(pairing.latency, pairing.latency_uncertainty),
    ]);
    rows.push([
        "correlation".to_owned(),
        format!(
            "{} over windows of {} s",
            scientific(pairing.correlation, 4),
            scientific(pairing.window, 3)
        ),
    ]);
    facts("Do both sensors see one motion?", rows)
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
