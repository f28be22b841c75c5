//! Coefficients as data sheets quote them: read off the Allan curve by its slopes, each by itself.

use crate::deviation::{DeviationCurve, DeviationPoint};
use crate::model::{FLICKER, Term};
use crate::statistic::Statistic;

/// How far a slope between neighbouring averaging times may lie from that of its term.
const SLACK: f64 = 0.1;

/// A coefficient read off the curve. It has no interval, and whatever else bends the curve there is in it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CurveReading {
    /// White noise, flicker noise or random walk.
    pub term: Term,
    /// The coefficient, in the unit of [`Term::unit`].
    pub value: f64,
    /// First and last averaging time that it was read from, s.
    pub taus: [f64; 2],
}

/// N from the stretch of slope −½, at 1 s; B from the minimum over 0.664; K from the stretch of slope +½, at 3 s. What the curve does not
/// show is left out: no such stretch, a minimum at an end. Of a curve that is no Allan deviation nothing is read.
///
/// **Source** `[IEEE952] annex C`: the usual procedure.
///
/// ```
/// use proofmass_noise::{DeviationOptions, NoiseRecord, Statistic, curve_readings, deviation};
///
/// // Uniform between 0 and 1: σ = 1/√12.
/// let mut state = 1_u64;
/// let mut chance = || {
///     state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
///     (state >> 11) as f64 / (1_u64 << 53) as f64
/// };
/// let samples: Vec<f64> = (0..40_000).map(|_| chance()).collect();
/// let curve = deviation(NoiseRecord::Rate(&samples), 100.0, Statistic::OverlappingAllan, &DeviationOptions::default())?;
/// let n = curve_readings(&curve)[0].value;
/// assert!((n / (1.0 / 12_f64.sqrt() / 10.0) - 1.0).abs() < 0.05, "{n}");
/// # Ok::<(), proofmass_core::Error>(())
/// ```
pub fn curve_readings(curve: &DeviationCurve) -> Vec<CurveReading> {
    let allan = [Statistic::Allan, Statistic::OverlappingAllan];
    let points: Vec<&DeviationPoint> = curve.points.iter().filter(|p| p.deviation > 0.0).collect();
    if !allan.contains(&curve.statistic) || points.len() < 3 {
        return Vec::new();
    }
    let white = stretch(&points, -0.5).map(|part| CurveReading {
        term: Term::White,
        value: mean(part, |p| p.deviation * p.tau.sqrt()),
        taus: ends(part),
    });
    let walk = stretch(&points, 0.5).map(|part| CurveReading {
        term: Term::RandomWalk,
        value: mean(part, |p| p.deviation * (3.0 / p.tau).sqrt()),
        taus: ends(part),
    });
    let lowest =
        (0..points.len()).min_by(|a, b| points[*a].deviation.total_cmp(&points[*b].deviation));
    let flicker = lowest
        .filter(|at| *at > 0 && *at + 1 < points.len())
        .map(|at| CurveReading {
            term: Term::Flicker,
            value: points[at].deviation / FLICKER.sqrt(),
            taus: [points[at].tau; 2],
        });
    [white, flicker, walk].into_iter().flatten().collect()
}

/// The longest stretch, in octaves, in which every slope is near this one.
fn stretch<'a, 'b>(
    points: &'a [&'b DeviationPoint],
    slope: f64,
) -> Option<&'a [&'b DeviationPoint]> {
    let near = |pair: &[&DeviationPoint]| {
        let rise = (pair[1].deviation / pair[0].deviation).ln();
        (rise / (pair[1].tau / pair[0].tau).ln() - slope).abs() <= SLACK
    };
    let mut longest: Option<(f64, &[&DeviationPoint])> = None;
    let mut start = None;
    for i in 0..points.len() {
        let goes_on = points.get(i..i + 2).is_some_and(near);
        match (start, goes_on) {
            (None, true) => start = Some(i),
            (Some(first), false) => {
                let part = &points[first..=i];
                let length = (points[i].tau / points[first].tau).ln();
                if longest.is_none_or(|(before, _)| length > before) {
                    longest = Some((length, part));
                }
                start = None;
            }
            _ => {}
        }
    }
    longest.map(|(_, part)| part)
}

/// Geometric mean.
fn mean(part: &[&DeviationPoint], value: impl Fn(&DeviationPoint) -> f64) -> f64 {
    let sum: f64 = part.iter().map(|p| value(p).ln()).sum();
    (sum / part.len() as f64).exp()
}

fn ends(part: &[&DeviationPoint]) -> [f64; 2] {
    [part[0].tau, part[part.len() - 1].tau]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise_type::{NoiseBasis, NoiseType};

    fn curve(sigma: impl Fn(f64) -> f64) -> DeviationCurve {
        let points = (0..20).map(|k| {
            let tau = 0.01 * 2f64.powi(k);
            DeviationPoint {
                factor: 1 << k,
                tau,
                deviation: sigma(tau),
                terms: 1,
                noise: NoiseType::White,
                basis: NoiseBasis::Given,
                edf: None,
                interval: None,
            }
        });
        DeviationCurve {
            statistic: Statistic::OverlappingAllan,
            sample_rate: 100.0,
            phase_points: 1 << 22,
            probability: 0.68,
            points: points.collect(),
        }
    }

    /// Of N, B, K far apart each is read within what the others add where it rules.
    #[test]
    fn known_coefficients_are_read_off_their_curve() {
        let (n, b, k) = (1e-3, 5e-4, 2e-6_f64);
        let of = |tau: f64| (n * n / tau + FLICKER * b * b + k * k * tau / 3.0).sqrt();
        let read = curve_readings(&curve(of));
        let value = |term: Term| read.iter().find(|r| r.term == term).map(|r| r.value);
        assert!((value(Term::White).unwrap() / n - 1.0).abs() < 0.1);
        assert!((value(Term::Flicker).unwrap() / b - 1.0).abs() < 0.02);
        assert_eq!(value(Term::RandomWalk), None, "the curve does not rise yet");
        let of = |tau: f64| (n * n / tau + (1e-3 * tau.sqrt()).powi(2) / 3.0).sqrt();
        let read = curve_readings(&curve(of));
        let walk = read.iter().find(|r| r.term == Term::RandomWalk).unwrap();
        assert!((walk.value / 1e-3 - 1.0).abs() < 0.02 && walk.taus[1] > 5000.0);
        // White noise alone has its minimum at the end: no B.
        let read = curve_readings(&curve(|tau| n / tau.sqrt()));
        assert_eq!(read.len(), 1);
        assert!((read[0].value / n - 1.0).abs() < 1e-12);
    }
}
