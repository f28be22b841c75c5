//! What may have happened to a run, and how likely that is before anything is known.

use super::super::budget::Acts;
use super::super::geometry::Configuration;
use super::super::observation::PhasorRow;
use super::Suspicion;
use super::trial::Trial;
use std::f64::consts::PI;

/// A cause: its prior, and the run as it would have been without it.
pub(super) struct Cause {
    pub(super) suspicion: Suspicion,
    pub(super) prior: f64,
    /// Causes that differ by a number alone, of which the nearest stands for all.
    pub(super) family: Option<u8>,
    pub(super) row: PhasorRow,
}

const ORDERS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 0, 2],
    [2, 1, 0],
    [0, 2, 1],
    [1, 2, 0],
    [2, 0, 1],
];

/// Rotation in radians by which a mounting counts as another one, far below what any mark can show.
const GLUED_ANEW: f64 = 3e-6;

/// Every cause that is thought of, with its prior.
pub(super) fn causes(trial: &Trial<'_>, row: &PhasorRow, frequencies: &[f64]) -> Vec<Cause> {
    let mut list = vec![];
    let mut add = |suspicion, prior: f64, family: Option<u8>, row: PhasorRow| {
        list.push(Cause {
            suspicion,
            prior,
            family,
            row,
        });
    };
    for channel in ORDERS {
        for bits in 0..8u8 {
            let sign: [i8; 3] = std::array::from_fn(|j| if bits >> j & 1 == 1 { -1 } else { 1 });
            let swapped = channel != [0, 1, 2];
            let prior = match (swapped, bits.count_ones()) {
                (false, 0) => continue,
                (true, 0) => 0.15 / 5.0,
                (true, _) => 0.01 / 35.0,
                (false, 1) => 0.08 / 3.0,
                (false, 2) => 0.01 / 3.0,
                (false, _) => 0.04,
            };
            let outputs = std::array::from_fn(|j| row.outputs[channel[j]] * f64::from(sign[j]));
            add(
                Suspicion::Channels { channel, sign },
                prior,
                None,
                PhasorRow {
                    outputs,
                    ..row.clone()
                },
            );
        }
    }
    for j in 0..3 {
        if let Some(row) = row.with_reference_on(j) {
            add(Suspicion::ReferenceSwapped { channel: j }, 0.03, None, row);
        }
    }
    // A gain that is taken back takes the additive noise with it.
    let additive = trial
        .budget
        .inputs
        .iter()
        .filter(|i| i.acts == Acts::OutputAdditive);
    let floor: f64 = additive
        .map(|i| i.standard_uncertainty_at(row.frequency).powi(2))
        .sum();
    let gained = |channel: Option<usize>, factor: f64| {
        let mut row = row.clone();
        for j in (0..3).filter(|&j| channel.is_none_or(|k| k == j)) {
            row.outputs[j] /= factor;
            let more = floor * (1.0 / (factor * factor) - 1.0).max(0.0);
            row.covariance[j + 1][0] += more;
            row.covariance[j + 1][2] += more;
        }
        row
    };
    for (factor, share) in [(10.0, 0.45), (0.1, 0.45), (100.0, 0.05), (0.01, 0.05)] {
        add(
            Suspicion::Gain {
                channel: None,
                factor,
            },
            0.12 * share,
            None,
            gained(None, factor),
        );
        for j in 0..3 {
            let channel = Some(j);
            add(
                Suspicion::Gain { channel, factor },
                0.08 / 3.0 * share,
                None,
                gained(channel, factor),
            );
        }
    }
    // A gain that no switch has: its size is taken from the run itself, which costs its prior a range of ln 1000
    // in steps of about a per cent.
    let m = trial.prediction(row);
    let y = row.nearest(&m);
    for channel in [None, Some(0), Some(1), Some(2)] {
        let of = |j: &usize| channel.is_none_or(|k| k == *j);
        let along: f64 = (0..3).filter(of).map(|j| (y[j] * m[j].conj()).re).sum();
        let square: f64 = (0..3).filter(of).map(|j| m[j].norm_sqr()).sum();
        let factor = along / square;
        if factor > 0.03 && factor < 30.0 && (factor - 1.0).abs() > 0.02 {
            let prior = if channel.is_none() { 0.02 } else { 0.01 };
            add(
                Suspicion::Gain { channel, factor },
                prior / 40.0,
                None,
                gained(channel, factor),
            );
        }
    }
    if let Some((level, outputs)) = unclipped(row, &m) {
        let suspicion = Suspicion::Clipped { level };
        let row = PhasorRow {
            outputs,
            ..row.clone()
        };
        add(suspicion, 0.06 / 20.0, None, row);
    }
    for j in 0..3 {
        // Without any signal; the channel then says nothing, and stands in as what is expected of it.
        if y[j].norm() < 1e-2 * m[j].norm() {
            let mut outputs = row.outputs;
            outputs[j] = m[j] * row.reference;
            add(
                Suspicion::Dead { channel: j },
                0.024 / 3.0,
                None,
                PhasorRow {
                    outputs,
                    ..row.clone()
                },
            );
        }
    }
    let mut others: Vec<Configuration> = vec![];
    for c in &trial.plan {
        if !c.same_as(&row.configuration) && !others.iter().any(|o| o.same_as(c)) {
            others.push(*c);
        }
    }
    let near = |c: &Configuration| {
        let d = |a: f64, b: f64| (a - b).abs() < 1e-6;
        d(c.inclination, row.configuration.inclination) || d(c.rotation, row.configuration.rotation)
    };
    let beside = others.iter().filter(|c| near(c)).count().max(1) as f64;
    let count = others.len().max(1) as f64;
    for configuration in others {
        let prior = if near(&configuration) {
            0.15 / beside
        } else {
            0.05 / count
        };
        // Glued anew on that wedge: the wedge is the same, the gluing is not that of the run that belongs there. What
        // differs by more than a microradian of rotation has a gluing of its own.
        let glued = Configuration {
            rotation: configuration.rotation + GLUED_ANEW,
            ..configuration
        };
        add(
            Suspicion::Mounting { configuration },
            prior,
            None,
            PhasorRow {
                configuration: glued,
                ..row.clone()
            },
        );
    }
    let c = row.configuration;
    for rotation in [-c.rotation, PI - c.rotation] {
        let configuration = Configuration {
            inclination: PI - c.inclination,
            rotation,
        };
        add(
            Suspicion::UpsideDown,
            0.01,
            None,
            PhasorRow {
                configuration,
                ..row.clone()
            },
        );
    }
    // Beside the mark, by more than a gluing may be: half a step of the plan in rotation, a tenth of a right angle in
    // inclination.
    let near = |inclination: f64, rotation: f64| Configuration {
        inclination: c.inclination + inclination.to_radians(),
        rotation: c.rotation + rotation.to_radians(),
    };
    let turned = (2..=44)
        .step_by(2)
        .flat_map(|d| [f64::from(d), -f64::from(d)]);
    let inclined = (1..=22).flat_map(|d| [0.5 * f64::from(d), -0.5 * f64::from(d)]);
    let beside = turned
        .map(|d| (near(0.0, d), 1))
        .chain(inclined.map(|d| (near(d, 0.0), 2)));
    for (configuration, family) in beside {
        add(
            Suspicion::Mounting { configuration },
            0.015 / 44.0,
            Some(family),
            PhasorRow {
                configuration,
                ..row.clone()
            },
        );
    }
    for &frequency in frequencies {
        add(
            Suspicion::Frequency { frequency },
            0.05 / frequencies.len() as f64,
            None,
            PhasorRow {
                frequency,
                ..row.clone()
            },
        );
    }
    list
}

/// The fundamental that is left of a sine of amplitude one cut off at a level: (2/π)(asin ρ + ρ √(1 − ρ²)).
fn cut(level: f64) -> f64 {
    if level >= 1.0 {
        return 1.0;
    }
    2.0 / PI * (level.asin() + level * (1.0 - level * level).sqrt())
}

/// The level at which the outputs would have been cut off, and what they would have been without; `None` where they are
/// not smaller than predicted.
fn unclipped(
    row: &PhasorRow,
    prediction: &[num_complex::Complex64; 3],
) -> Option<(f64, [num_complex::Complex64; 3])> {
    let expected = prediction.map(|m| m.norm() * row.reference.norm());
    let largest = (0..3).max_by(|&a, &b| expected[a].total_cmp(&expected[b]))?;
    let left = row.outputs[largest].norm() / expected[largest];
    if !(left > 0.05 && left < 0.98) {
        return None;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if cut(middle) < left {
            low = middle;
        } else {
            high = middle;
        }
    }
    let level = low * expected[largest];
    let outputs = std::array::from_fn(|j| row.outputs[j] / cut(level / expected[j].max(1e-300)));
    Some((level, outputs))
}

#[cfg(test)]
mod tests {
    use super::cut;

    #[test]
    fn known_what_a_clipped_sine_leaves() {
        assert!((cut(0.5) - 0.608998).abs() < 1e-6);
        assert!((cut(0.9) - 0.962614).abs() < 1e-6);
        assert_eq!(cut(1.0), 1.0);
    }
}
