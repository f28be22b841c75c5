//! Where the fit of a step starts.

use super::fit::{P, Samples, Unit, cost, levels, settled};
use proofmass_signal::sine::dominant_frequency;

/// A step as it is seen near its beginning.
pub(super) struct Start {
    /// The fit on part of the record.
    pub(super) parameters: Vec<f64>,
    pub(super) unit: Unit,
}

/// First sample that is away from the first ones by a third of what is greatest.
pub(super) fn onset(values: &[f64], before: f64) -> usize {
    let away = |v: &f64| (v - before).abs();
    let most = values.iter().map(away).fold(0.0f64, f64::max);
    let passed = values.iter().position(|v| away(v) > most / 3.0);
    passed.unwrap_or(values.len() / 2)
}

/// Starts of all frequencies that a record can show, fitted where each would be seen, the best first on the whole record.
///
/// One that rings says its frequency, in some part of the record that is not much longer than it rings.
pub(super) fn starts(whole: &Samples, onset: usize) -> Vec<Start> {
    let (n, rate) = (whole.values.len(), whole.rate);
    let length = n as f64 / rate;
    let mut frequencies = Vec::new();
    let parts = std::iter::successors(Some(16), |part| (onset + part < n).then_some(2 * part));
    for part in parts {
        let seen = &whole.values[onset.min(n)..(onset + part).min(n)];
        frequencies.extend(dominant_frequency(rate, seen).ok());
    }
    let rings = frequencies.len();
    let mut f = 0.3 / length;
    while f < 0.45 * rate {
        frequencies.push(f);
        f *= 1.6;
    }
    let mut seen: Vec<(f64, bool, Start, Samples)> = Vec::new();
    for (i, f) in frequencies.iter().enumerate() {
        if !(*f > 0.0) || frequencies[..i].iter().any(|g| (f / g - 1.0).abs() < 0.02) {
            continue;
        }
        if let Some((left, start, part)) = look(whole, onset, *f) {
            seen.push((left, i < rings, start, part));
        }
    }
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut counts = [0; 2];
    seen.retain(|(_, ring, ..)| {
        let count = &mut counts[usize::from(*ring)];
        *count += 1;
        *count <= 4
    });
    let mut followed: Vec<(f64, Start)> = Vec::new();
    for (_, _, start, part) in seen {
        let unit = start.unit;
        let Some((parameters, equations, _)) =
            settled(&start.parameters, 15, |p| unit.equations(&part, p))
        else {
            continue;
        };
        let response: Vec<f64> = unit.response(whole, &parameters).collect();
        let here = cost(&equations);
        if let Some(([baseline, height], left)) = levels(whole, &response)
            && here.is_finite()
        {
            let mut parameters = parameters;
            (parameters[0], parameters[1]) = (baseline, height);
            followed.push((left, Start { parameters, unit }));
        }
    }
    followed.sort_by(|a, b| a.0.total_cmp(&b.0));
    followed.into_iter().map(|(_, start)| start).collect()
}

/// The best of some dampings and instants at a frequency, with the share of the squares that it leaves, and the samples in which it is seen:
/// a dozen periods, thinned.
fn look(whole: &Samples, onset: usize, frequency: f64) -> Option<(f64, Start, Samples)> {
    const MOST: usize = 600;
    let n = whole.values.len();
    let period = (whole.rate / frequency).ceil() as usize;
    let from = onset.saturating_sub(2 * period.max(8));
    let to = onset.saturating_add(12 * period).max(onset + 40).min(n);
    let every = (to - from).div_ceil(MOST);
    let part = Samples {
        values: whole.values[from..to]
            .iter()
            .copied()
            .step_by(every)
            .collect(),
        rate: whole.rate / every as f64,
        begin: whole.begin + from as f64 / whole.rate,
    };
    let unit = Unit {
        instant: whole.begin + onset as f64 / whole.rate,
        frequency,
    };
    let mean = part.values.iter().sum::<f64>() / part.values.len() as f64;
    let spread = part.values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
    let mut best: Option<(f64, Vec<f64>)> = None;
    for damping in [0.01, 0.05, 0.15, 0.4, 0.8, 1.3] {
        for early in [0.02, 0.1, 0.2, 0.35] {
            let mut p = vec![0.0; P];
            (p[2], p[4]) = (-early, damping);
            let response: Vec<f64> = unit.response(&part, &p).collect();
            let Some(([baseline, height], left)) = levels(&part, &response) else {
                continue;
            };
            (p[0], p[1]) = (baseline, height);
            if best.as_ref().is_none_or(|(least, _)| left < *least) {
                best = Some((left, p));
            }
        }
    }
    let (left, parameters) = best?;
    let share = left / spread.max(f64::MIN_POSITIVE);
    Some((share, Start { parameters, unit }, part))
}
