//! Blows: something stops the axis short.

use super::SlipSearch;
use crate::MotionRecord;
use crate::episode::{Episode, episodes, held, quiet};
use proofmass_core::numeric::upper_median;

impl SlipSearch {
    /// Jumps of the mean acceleration over the blow's duration, against the motion, far outside the quiet part.
    pub(super) fn collisions(&self, record: &MotionRecord, dt: f64) -> Vec<Episode> {
        let b = ((self.blow / dt).round() as usize).max(2);
        let n = record.acceleration.len();
        if n < 8 * b {
            return Vec::new();
        }
        let mean: Vec<f64> = record
            .acceleration
            .windows(b)
            .map(|a| a.iter().sum::<f64>() / b as f64)
            .collect();
        let mut sorted = mean.clone();
        let level = upper_median(&mut sorted).unwrap_or(0.0);
        // The mean after a sample minus that before it: braking is slow against it, and an offset drops out.
        let jump: Vec<f64> = (b..mean.len()).map(|k| mean[k] - mean[k - b]).collect();
        let (centre, deviation) = quiet(&jump);
        // An accelerometer without noise is dead for the most part: it tells of no blow.
        if !(deviation > 0.0) {
            return Vec::new();
        }
        let positions = held(&record.positions());
        let velocity: Vec<f64> = (0..n)
            .map(|k| {
                let (a, c) = (k.saturating_sub(2 * b), k.max(1));
                (positions[c] - positions[a]) / ((c - a).max(1) as f64 * dt)
            })
            .collect();
        let span = b as f64 * dt;
        let z: Vec<f64> = jump
            .iter()
            .enumerate()
            .map(|(k, a)| {
                let against = (a - centre) * velocity[k + b] < 0.0;
                if against {
                    (a - centre) / deviation
                } else {
                    0.0
                }
            })
            .collect();
        // Where nothing is noisy everything stands out: a blow also changes the velocity by a part of itself.
        let typical = velocity.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let hard = |z: f64| z.abs() > self.threshold && z.abs() * deviation * span > 0.02 * typical;
        let mut found = episodes(&z, hard, b, 2 * b, n, |z| (z * deviation * span, z));
        // A blow is over where a drive's own swing goes on: the acceleration around it is small against its own.
        let short = |e: &Episode| {
            let inside = e.from.min(mean.len() - 1)..e.to.min(mean.len());
            let size = |k: usize| (mean[k] - level).abs();
            let Some(peak) = inside.max_by(|a, b| size(*a).total_cmp(&size(*b))) else {
                return false;
            };
            let beside = [peak.checked_sub(b + b / 2), Some(peak + b + b / 2)];
            beside
                .into_iter()
                .flatten()
                .filter(|k| *k < mean.len())
                .all(|k| size(k) < 0.4 * size(peak))
        };
        found.retain(short);
        // Half of the change comes in half the time of a blow; a drive that brakes within four blows has a quarter there.
        let change = |from: usize, to: usize| -> f64 {
            let part = &record.acceleration[from..to.min(n)];
            part.iter().map(|a| a - level).sum()
        };
        let sudden = |e: &Episode| {
            let half = (b / 2).max(1);
            let starts = e.from.min(n - 1)..e.to.min(n);
            let Some(hardest) = starts.max_by(|i, j| {
                let size = |k: usize| change(k, k + half).abs();
                size(*i).total_cmp(&size(*j))
            }) else {
                return false;
            };
            let middle = hardest + half / 2;
            let all = change(middle.saturating_sub(2 * b), middle + 2 * b);
            change(hardest, hardest + half).abs() > 0.45 * all.abs()
        };
        found.retain(sudden);
        // A drive brakes as hard as it starts: a blow exceeds what the motion does by itself, away from the hardest.
        let mut hardest: Vec<Episode> = found.clone();
        hardest.sort_by(|a, b| b.deviations.abs().total_cmp(&a.deviations.abs()));
        hardest.truncate(5);
        let away = |k: usize| {
            let near = |e: &Episode| k + 6 * b >= e.from && k < e.to + 6 * b;
            !hardest.iter().any(near)
        };
        let own = jump
            .iter()
            .enumerate()
            .filter(|(k, a)| away(k + b) && (*a - centre) * velocity[k + b] > 0.0)
            .fold(0.0f64, |m, (_, a)| m.max((a - centre).abs()));
        found.retain(|e| e.velocity.abs() > 1.5 * own * span);
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ReadingSource;
    use proofmass_rig::{AxisMotion, DrivenAxis};

    #[test]
    fn law_a_collision_is_found() {
        let recording = DrivenAxis::new(AxisMotion::impact()).simulate(12).unwrap();
        let record = MotionRecord::new(
            1e-3,
            ReadingSource::Position,
            recording.position(),
            recording.acceleration,
        )
        .unwrap();
        let report = SlipSearch::default().run(&record).unwrap();
        let e = report.collisions.first().expect("the impact at 1 s");
        assert!(e.from.abs_diff(1000) < 30, "{e:?}");
        assert!(e.velocity < -0.4, "{e:?}");
    }
}
