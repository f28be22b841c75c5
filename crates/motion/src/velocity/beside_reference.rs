//! Scale and delay of an estimate beside a reference velocity.

use crate::findings;
use proofmass_uncertainty::Finding;
use serde::Serialize;

/// How an estimate differs from a reference by a factor and a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct BesideReference {
    /// The estimate is this times the reference.
    pub scale: f64,
    /// Its standard uncertainty.
    pub scale_uncertainty: f64,
    /// Time by which the estimate is later, s.
    pub delay: f64,
    /// Its standard uncertainty, s.
    pub delay_uncertainty: f64,
    /// Root of the mean square that is left.
    pub rms: f64,
}

/// Longest delay that is looked for, s.
const FARTHEST: f64 = 0.5;
/// Blocks that are left out in turn.
const BLOCKS: usize = 20;

impl BesideReference {
    /// Least squares of estimate(t + delay) = scale · reference(t).
    ///
    /// The delay in whole samples first, then its rest and the scale by Gauss and Newton. The uncertainty is that of leaving
    /// out each of twenty blocks in turn, so that errors that last for less than a block are counted as they are.
    ///
    /// `None` for a reference that does not move, or fewer than 400 samples.
    ///
    /// **Source** `[Efron82]` for leaving out blocks.
    pub fn of(estimate: &[f64], reference: &[f64], sample_time: f64) -> Option<Self> {
        let n = estimate.len();
        let reach = ((FARTHEST / sample_time).round() as usize).min(n / 10);
        if reference.len() != n || n < 20 * BLOCKS || reach < 1 {
            return None;
        }
        let inner = reach + 1..n - reach - 1;
        let all = |_: usize| true;
        let lag = nearest(estimate, reference, &inner, reach as i64)?;
        let solve = |keep: &dyn Fn(usize) -> bool, start: (f64, f64)| {
            let (mut delay, mut scale) = start;
            for _ in 0..8 {
                let sums = Sums::of(estimate, reference, &inner, delay, scale, keep);
                let (s, d) = sums.solved()?;
                delay = (delay + d.clamp(-1.0, 1.0)).clamp(-(reach as f64), reach as f64);
                scale = s;
            }
            Some((delay, scale))
        };
        let (delay, scale) = solve(&all, (lag as f64, 1.0))?;
        let block = |k: usize| (k - inner.start) * BLOCKS / inner.len();
        let mut spread = [0.0; 2];
        for b in 0..BLOCKS {
            let (d, s) = solve(&|k| block(k) != b, (delay, scale))?;
            spread[0] += (s - scale) * (s - scale);
            spread[1] += (d - delay) * (d - delay);
        }
        let share = (BLOCKS - 1) as f64 / BLOCKS as f64;
        let sums = Sums::of(estimate, reference, &inner, delay, scale, all);
        let rms = (sums.square / inner.len() as f64).sqrt();
        let found = Self {
            scale,
            scale_uncertainty: (share * spread[0]).sqrt(),
            delay: delay * sample_time,
            delay_uncertainty: (share * spread[1]).sqrt() * sample_time,
            rms,
        };
        [found.scale, found.scale_uncertainty, found.delay, found.rms]
            .iter()
            .all(|x| x.is_finite())
            .then_some(found)
    }

    /// That the estimate is high or low, where that is significant and more than a thousandth.
    pub fn finding(&self) -> Option<Finding> {
        let off = self.scale - 1.0;
        if off.abs() < (4.0 * self.scale_uncertainty).max(1e-3) {
            return None;
        }
        let what = if off < 0.0 { "low" } else { "high" };
        Some(findings::reference_scale(
            100.0 * off.abs(),
            what,
            self.scale,
            self.scale - 1.96 * self.scale_uncertainty,
            self.scale + 1.96 * self.scale_uncertainty,
            1e3 * self.delay,
            1e3 * self.delay_uncertainty,
            self.rms,
        ))
    }
}

/// The lag in samples at which the best scale leaves least; of several that leave hardly more, as a periodic motion has them,
/// the one nearest to none. A scale below zero only where no other describes the two.
fn nearest(
    estimate: &[f64],
    reference: &[f64],
    inner: &std::ops::Range<usize>,
    reach: i64,
) -> Option<i64> {
    let places: Vec<(i64, f64, bool)> = (-reach..=reach)
        .map(|lag| {
            let sums = Sums::of(estimate, reference, inner, lag as f64, 1.0, |_| true);
            Some((lag, sums.left_of_scale()?, sums.vr > 0.0))
        })
        .collect::<Option<_>>()?;
    let least = |alike: bool| {
        let own = places.iter().filter(|p| p.2 || !alike);
        own.map(|p| p.1).fold(f64::INFINITY, f64::min)
    };
    let alike = least(true) <= 4.0 * least(false);
    let bound = 1.5 * least(alike);
    let lowest = |i: usize| {
        let beside = [i.checked_sub(1), Some(i + 1)];
        let beside = beside.into_iter().flatten();
        beside
            .filter_map(|j| places.get(j))
            .all(|p| p.1 >= places[i].1)
    };
    (0..places.len())
        .filter(|&i| (places[i].2 || !alike) && places[i].1 <= bound && lowest(i))
        .map(|i| places[i].0)
        .min_by_key(|lag| lag.abs())
}

/// Normal equations of scale and delay around a place.
struct Sums {
    rr: f64,
    rd: f64,
    dd: f64,
    vr: f64,
    vd: f64,
    vv: f64,
    square: f64,
}

impl Sums {
    /// The estimate is what is taken between its samples: it is smooth, and a line between two samples of a noisy reference
    /// has less noise in its middle, to which least squares would be drawn. Its slope is that of central differences, taken
    /// between samples with the same weights: noise of the estimate that is stationary does not correlate with it.
    fn of(
        estimate: &[f64],
        reference: &[f64],
        inner: &std::ops::Range<usize>,
        delay: f64,
        scale: f64,
        keep: impl Fn(usize) -> bool,
    ) -> Self {
        let last = estimate.len() as i64 - 1;
        let (whole, part) = (delay.floor(), delay - delay.floor());
        let mut sums = Self {
            rr: 0.0,
            rd: 0.0,
            dd: 0.0,
            vr: 0.0,
            vd: 0.0,
            vv: 0.0,
            square: 0.0,
        };
        for k in inner.clone().filter(|k| keep(*k)) {
            let at = |i: i64| estimate[(k as i64 + whole as i64 + i).clamp(0, last) as usize];
            let between = |a: f64, b: f64| a * (1.0 - part) + b * part;
            // estimate(t + delay) lies `part` samples after the sample `whole` on.
            let v = between(at(0), at(1));
            // What one sample less of delay does to it.
            let d = -0.5 * between(at(1) - at(-1), at(2) - at(0));
            let r = reference[k];
            sums.rr += r * r;
            sums.rd += r * d;
            sums.dd += d * d;
            sums.vr += v * r;
            sums.vd += v * d;
            sums.vv += v * v;
            sums.square += (v - scale * r) * (v - scale * r);
        }
        sums
    }

    /// Squares that the best scale leaves.
    fn left_of_scale(&self) -> Option<f64> {
        (self.rr > 0.0).then(|| self.vv - self.vr * self.vr / self.rr)
    }

    /// Scale, and change of the delay in samples.
    fn solved(&self) -> Option<(f64, f64)> {
        let determinant = self.rr * self.dd - self.rd * self.rd;
        (determinant > 1e-12 * self.rr * self.dd).then(|| {
            (
                (self.dd * self.vr - self.rd * self.vd) / determinant,
                (self.rr * self.vd - self.rd * self.vr) / determinant,
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// A drive of a minute at 100 Hz, and an estimate with errors that last for 0.3 s.
    fn drive(seed: u64, scale: f64, delay: f64) -> (Vec<f64>, Vec<f64>) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let phase = [normal(), normal()];
        let speed = |t: f64| 12.0 + 6.0 * (0.35 * t + phase[0]).sin() + (1.3 * t + phase[1]).sin();
        let alike = (-0.01f64 / 0.3).exp();
        let mut error = 0.0;
        let times = || (0..6000).map(|k| 0.01 * f64::from(k));
        let estimate = times()
            .map(|t| {
                error = alike * error + 0.03 * (1.0 - alike * alike).sqrt() * normal();
                scale * speed(t - delay) + error
            })
            .collect();
        (estimate, times().map(speed).collect())
    }

    #[test]
    fn coverage_of_scale_and_delay() {
        let (mut scales, mut delays) = (0, 0);
        for seed in 0..100 {
            let (v, r) = drive(seed, 0.9828, 0.1134);
            let found = BesideReference::of(&v, &r, 0.01).unwrap();
            scales += usize::from((found.scale - 0.9828).abs() < 1.96 * found.scale_uncertainty);
            delays += usize::from((found.delay - 0.1134).abs() < 1.96 * found.delay_uncertainty);
            let finding = found.finding().unwrap();
            assert!(finding.what().contains("% low"));
        }
        println!("scale {scales}, delay {delays} of 100");
        // At 95 %: fewer than 88 of 100 by chance in one of 300.
        assert!(scales >= 88 && delays >= 88, "{scales} {delays}");
    }

    /// A reference with white noise of its own, at delays between whole samples.
    #[test]
    fn law_noise_of_the_reference_does_not_draw_the_delay() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let speed = |t: f64| 12.0 + 6.0 * (0.35 * t).sin() + (1.3 * t).sin();
        for delay in [0.0912, 0.0953, 0.0970, 0.0988] {
            let times = || (0..6000).map(|k| 0.01 * f64::from(k));
            let estimate: Vec<f64> = times().map(|t| speed(t - delay)).collect();
            let reference: Vec<f64> = times().map(|t| speed(t) + 0.05 * normal()).collect();
            let found = BesideReference::of(&estimate, &reference, 0.01).unwrap();
            // σ/(√n · 1.8 m/s²) = 0.36 ms, and four of it.
            assert!(
                (found.delay - delay).abs() < 1.5e-3,
                "{delay}: {}",
                found.delay
            );
        }
    }

    /// Half a period later the other sign fits a sine as well, and a period later the same.
    #[test]
    fn regress_a_periodic_motion_keeps_its_sense() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(8);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let speed = |t: f64| (31.4159 * t).sin();
        let times = || (0..4000).map(|k| 1e-3 * f64::from(k));
        for delay in [0.0, 0.013, -0.04] {
            let estimate: Vec<f64> = times()
                .map(|t| speed(t - delay) + 1e-4 * normal())
                .collect();
            let reference: Vec<f64> = times().map(speed).collect();
            let found = BesideReference::of(&estimate, &reference, 1e-3).unwrap();
            assert!((found.scale - 1.0).abs() < 1e-3, "{found:?}");
            assert!((found.delay - delay).abs() < 1e-4, "{found:?}");
        }
    }

    #[test]
    fn known_false_alarms_of_a_right_scale() {
        let alarms = (200..500).filter(|seed| {
            let (v, r) = drive(*seed, 1.0, 0.05);
            BesideReference::of(&v, &r, 0.01)
                .unwrap()
                .finding()
                .is_some()
        });
        let alarms = alarms.count();
        assert!(alarms <= 3, "{alarms} of 300");
    }

    #[test]
    fn refuses_a_reference_that_does_not_move() {
        let still = vec![0.0; 1000];
        assert!(BesideReference::of(&still, &still, 0.01).is_none());
        let even = vec![3.0; 1000];
        assert!(BesideReference::of(&even, &even, 0.01).is_none());
        assert!(BesideReference::of(&still[..50], &still[..50], 0.01).is_none());
    }
}
