//! Motions of known position, velocity and acceleration that tests and examples share.

// Each of them uses some.
#![allow(dead_code)]

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

/// Position, velocity and acceleration at a time.
pub type Motion = Box<dyn Fn(f64) -> [f64; 3] + Sync>;

/// A speed that swings by a fifth at 0.7 Hz.
pub fn creeping(speed: f64) -> Motion {
    let w = TAU * 0.7;
    Box::new(move |t| {
        let (s, c) = (w * t).sin_cos();
        [
            speed * (t - 0.2 * c / w),
            speed * (1.0 + 0.2 * s),
            0.2 * speed * w * c,
        ]
    })
}

/// A sine of this amplitude and frequency.
pub fn sine(amplitude: f64, frequency: f64) -> Motion {
    let w = TAU * frequency;
    Box::new(move |t| {
        let (s, c) = (w * t).sin_cos();
        [amplitude * s, amplitude * w * c, -amplitude * w * w * s]
    })
}

/// Moves of random speed, up to this, and length with starts and stops of 80 ms, and rests of random length, for `until` s.
pub fn hard_stops(speed: f64, seed: u64, until: f64) -> Motion {
    const RAMP: f64 = 0.08;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let (mut moves, mut at) = (Vec::new(), 0.5);
    while at < until {
        let h = speed * rng.random_range(-1.0..1.0);
        let cruise: f64 = rng.random_range(0.22..0.92);
        moves.push((at, h, cruise + RAMP));
        at += cruise + 2.0 * RAMP + rng.random_range(0.2..0.8);
    }
    // Way, velocity and acceleration of a start to 1 m/s along q³(10 − 15q + 6q²).
    let start = |t: f64| -> [f64; 3] {
        let q = (t / RAMP).clamp(0.0, 1.0);
        [
            RAMP * q.powi(4) * (2.5 - 3.0 * q + q * q) + (t - RAMP).max(0.0),
            q.powi(3) * (10.0 - 15.0 * q + 6.0 * q * q),
            30.0 / RAMP * (q * (1.0 - q)).powi(2),
        ]
    };
    Box::new(move |t| {
        let mut sum = [0.0; 3];
        for (at, h, long) in &moves {
            let (a, b) = (start(t - at), start(t - at - long));
            for i in 0..3 {
                sum[i] += h * (a[i] - b[i]);
            }
        }
        sum
    })
}
