//! Channels of several wheels that never change while the others move.

use crate::several_wheels::smallest_step;
use proofmass_uncertainty::Finding;

/// How far a wheel goes when it moves, in its smallest steps and in its changes from reading to reading (RMS): noise from
/// reading to reading reaches seven of the latter in a million readings, a count that trembles one of the former.
const MOVES: f64 = 10.0;

/// Wheels that hold one value throughout, by their place, where another one moves; and what is to be said of them.
///
/// None where all are alike: then the axis rests, or the whole record is dead.
pub fn dead_wheels(readings: &[Vec<Option<f64>>], names: &[&str]) -> (Vec<usize>, Option<Finding>) {
    if !readings.iter().any(|r| moves(r)) {
        return (Vec::new(), None);
    }
    let held: Vec<(usize, f64)> = readings
        .iter()
        .enumerate()
        .filter_map(|(i, r)| constant(r).map(|v| (i, v)))
        .collect();
    if held.is_empty() {
        return (Vec::new(), None);
    }
    let told: Vec<String> = held
        .iter()
        .map(|(i, v)| format!("{}: {v} in all readings", names.get(*i).unwrap_or(&"")))
        .collect();
    let finding = proofmass_uncertainty::findings::constant_channel(
        "the channel of a wheel",
        &told.join("; "),
        " while others move: it is left out of the mean",
    );
    (held.into_iter().map(|(i, _)| i).collect(), Some(finding))
}

fn constant(readings: &[Option<f64>]) -> Option<f64> {
    let mut known = readings.iter().flatten();
    let first = *known.next()?;
    known.all(|r| *r == first).then_some(first)
}

fn moves(readings: &[Option<f64>]) -> bool {
    let known: Vec<f64> = readings.iter().flatten().copied().collect();
    let Some(pairs) = known.len().checked_sub(1).filter(|n| *n > 0) else {
        return false;
    };
    let least = known.iter().copied().fold(f64::INFINITY, f64::min);
    let most = known.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let squares: f64 = known.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum();
    let change = (squares / pairs as f64).sqrt();
    let span = most - least;
    span > 0.0 && span >= MOVES * smallest_step(readings).max(change)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: [&str; 4] = ["fl", "fr", "rl", "rr"];

    fn wheel(value: impl Fn(usize) -> f64) -> Vec<Option<f64>> {
        (0..2000).map(|k| Some(value(k))).collect()
    }

    #[test]
    fn law_dead_wheels_are_named_where_others_move() {
        let ramp = |k: usize| (0.1 * k as f64).round() / 10.0;
        let mut four = vec![wheel(ramp), wheel(ramp), wheel(|_| 0.0), wheel(ramp)];
        let (dead, finding) = dead_wheels(&four, &NAMES);
        assert_eq!(dead, [2]);
        let finding = finding.unwrap();
        assert_eq!(finding.code(), "constant-channel");
        assert!(finding.evidence_text().starts_with("rl: 0 in all"));
        four[0] = wheel(|_| 3.5);
        assert_eq!(dead_wheels(&four, &NAMES).0, [0, 2]);
    }

    #[test]
    fn known_wheels_at_rest_are_not_dead() {
        let rest = || wheel(|_| 0.0);
        let tremble = wheel(|k| f64::from(u8::from(k % 97 < 40)));
        let noise = wheel(|k| (k * 7919 % 101) as f64);
        for last in [rest(), tremble, noise] {
            let (dead, finding) = dead_wheels(&[rest(), rest(), rest(), last], &NAMES);
            assert!(dead.is_empty() && finding.is_none());
        }
        assert!(dead_wheels(&[vec![None; 9], vec![]], &NAMES).0.is_empty());
    }
}
