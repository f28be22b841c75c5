//! Samples that a slower sensor holds until its next one, so that each stands in several rows.

use crate::findings;
use proofmass_uncertainty::Finding;

/// How a slower sensor holds its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Held {
    /// Rows in which each value stands.
    pub rows: usize,
    /// The first row with a new one.
    pub first: usize,
}

impl Held {
    /// What is told of an accelerometer of so many new values a second.
    pub fn finding(&self, rate: f64) -> Finding {
        findings::accelerometer_held(self.rows, rate)
    }
}

/// Changes below which it is not told.
const LEAST: usize = 50;
/// Share of the changes that come in step.
const IN_STEP: f64 = 0.98;

/// Rows for which every value is held, and the first row with a new one; nothing where values change as they like.
///
/// A value may repeat by itself, then the next change is two steps away: of every two steps one brings another value at least.
///
/// ```
/// let values: Vec<f64> = (0..1000).map(|k| ((k / 10) as f64).sin()).collect();
/// let held = proofmass_motion::held(&values).unwrap();
/// assert_eq!((held.rows, held.first), (10, 0));
/// let changing: Vec<f64> = (0..1000).map(|k| (k as f64).sin()).collect();
/// assert_eq!(proofmass_motion::held(&changing), None);
/// ```
pub fn held(values: &[f64]) -> Option<Held> {
    let pairs = values.windows(2).enumerate();
    let changes: Vec<usize> = pairs
        .filter(|(_, w)| w[0] != w[1])
        .map(|(k, _)| k + 1)
        .collect();
    if changes.len() < LEAST {
        return None;
    }
    let mut gaps: Vec<usize> = changes.windows(2).map(|w| w[1] - w[0]).collect();
    gaps.sort_unstable();
    let step = gaps[gaps.len() / 2];
    let phase = changes[changes.len() / 2] % step.max(1);
    let in_step = changes.iter().filter(|c| *c % step == phase).count() as f64;
    let all = changes.len() as f64;
    let often = changes[changes.len() - 1] - changes[0] < 2 * step * changes.len();
    (step > 1 && in_step >= IN_STEP * all && often).then_some(Held {
        rows: step,
        first: phase,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_holds() {
        let noise = |k: usize| ((k * 7919) % 101) as f64;
        let of = |f: &dyn Fn(usize) -> f64| {
            let found = held(&(0..2000).map(f).collect::<Vec<_>>());
            found.map(|h| (h.rows, h.first))
        };
        assert_eq!(of(&|k| noise((k + 3) / 5)), Some((5, 2)));
        // Every other value of a coarse sensor is the one before.
        assert_eq!(of(&|k| (noise(k / 4) / 40.0).floor()), Some((4, 0)));
        // A coarse sensor that holds nothing, one that stands still, one that changes now and then.
        assert_eq!(of(&|k| (noise(k) / 40.0).floor()), None);
        assert_eq!(of(&|_| 1.0), None);
        assert_eq!(of(&|k| f64::from(u8::from(k % 97 < 48))), None);
        assert_eq!(held(&[]), None);
    }
}
