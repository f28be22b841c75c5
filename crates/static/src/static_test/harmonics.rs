//! Harmonics two and three of the residuals over the angle, with what a test of this size would find.

use super::ReadingResidual;
use super::readings::least_squares;
use crate::findings;
use proofmass_uncertainty::{DegreesOfFreedom, Finding, f_quantile, normal_quantile};
use serde::Serialize;

/// A part of the residuals that goes k times around with the angle.
///
/// The second is a square of the acceleration or a table that is not round, the third a cube: k₃ x³ on S g cos θ is k₃/4 of the
/// third harmonic and 3 k₃/4 of the first, which the sensitivity takes up.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Harmonic {
    /// Turns per turn.
    pub order: usize,
    /// Amplitude, relative to the output at 1 g.
    pub size: f64,
    /// F of the two parts that make it.
    pub f: f64,
    /// What one healthy test in two hundred exceeds.
    pub f_limit: f64,
    /// Amplitude that nine of ten tests of this size and scatter find, relative to the output at 1 g.
    pub found: f64,
}

/// Level of the test of each of both, so that one healthy test in a hundred has a finding.
const LEVEL: f64 = 0.005;
/// Probability that a harmonic of the size [`Harmonic::found`] is found.
const POWER: f64 = 0.9;
/// Three readings to spare beside seven parameters, or nothing is tested.
const FEWEST: usize = 10;

/// What the residuals show; `None` where the readings are too few or their angles do not tell the harmonics apart.
pub(super) fn harmonics(
    angle: &[f64],
    readings: &[ReadingResidual],
    reach: f64,
) -> Option<Vec<Harmonic>> {
    if angle.len() < FEWEST {
        return None;
    }
    let y: Vec<f64> = readings.iter().map(ReadingResidual::residual).collect();
    let columns = |orders: &[usize]| {
        let mut columns = vec![vec![1.0; angle.len()]];
        for k in orders.iter().map(|k| *k as f64) {
            columns.push(angle.iter().map(|t| (k * t).cos()).collect());
            columns.push(angle.iter().map(|t| (k * t).sin()).collect());
        }
        columns
    };
    let full = least_squares(&columns(&[1, 2, 3]), &y, "harmonics").ok()?;
    let nu = full.dof as f64;
    let variance = full.squares / nu;
    if !(variance > 0.0) {
        return Some(Vec::new());
    }
    let f_limit = f_quantile(1.0 - LEVEL, 2.0, nu);
    let tested = [(2, 3, [1, 3]), (3, 5, [1, 2])].map(|(order, at, others)| {
        let without = least_squares(&columns(&others), &y, "harmonics").ok()?;
        let size = full.parameters[at].hypot(full.parameters[at + 1]);
        let spread = [at, at + 1].map(|i| full.inverse[i * 7 + i]);
        // The root of the non-centrality: √(2 F) is one standard deviation wide, and its limit as wide as the scatter is known.
        let root = (2.0 * f_limit).sqrt() + normal_quantile(POWER) * (1.0 + f_limit / nu).sqrt();
        let found = root * (0.5 * (spread[0] + spread[1]) * variance).sqrt();
        Some(Harmonic {
            order,
            size: size / reach,
            f: (without.squares - full.squares) / 2.0 / variance,
            f_limit,
            found: found / reach,
        })
    });
    tested.into_iter().collect()
}

/// What is to be doubted of them.
pub(super) fn doubts(harmonics: &[Harmonic]) -> impl Iterator<Item = Finding> {
    let beyond = harmonics.iter().filter(|h| h.f > h.f_limit);
    beyond.map(|h| match h.order {
        2 => findings::second_harmonic(1e2 * h.size, h.f, h.f_limit, 1e2 * h.found),
        _ => findings::third_harmonic(3e2 * h.size, 1e2 * h.size, h.f, h.f_limit, 1e2 * h.found),
    })
}

/// Size of a third harmonic in phase with the axis that readings too few for a test leave open, output unit, with the degrees of
/// freedom that tell it; `None` where the angles do not tell it from the first.
///
/// √(h² + u²): what they show of it and what they cannot exclude.
pub(super) fn hidden(
    angle: &[f64],
    phase: f64,
    readings: &[ReadingResidual],
) -> Option<(f64, DegreesOfFreedom)> {
    let y: Vec<f64> = readings.iter().map(ReadingResidual::residual).collect();
    let columns = [
        vec![1.0; angle.len()],
        angle.iter().map(|t| t.cos()).collect(),
        angle.iter().map(|t| t.sin()).collect(),
        angle.iter().map(|t| (3.0 * (t + phase)).cos()).collect(),
    ];
    let solved = least_squares(&columns, &y, "third harmonic").ok()?;
    let dof = DegreesOfFreedom::new(solved.dof as f64)?;
    let variance = solved.squares / solved.dof as f64;
    let open = solved.parameters[3].powi(2) + variance * solved.inverse[15];
    Some((open.sqrt(), dof))
}
