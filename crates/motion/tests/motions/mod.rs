//! Motions of known position, velocity and acceleration that tests and examples share.

// Each of them uses some.
#![allow(dead_code)]

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::{PI, TAU};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// Position, velocity and acceleration at a time.
pub type Motion = Box<dyn Fn(f64) -> [f64; 3] + Sync>;

/// Steps of a [`HighPass`], s.
pub const STEP: f64 = 1e-4;

/// A high-pass of first order, as of an accelerometer with a low corner.
pub struct HighPass {
    decay: f64,
    last: f64,
    taken: f64,
}

impl HighPass {
    /// With a corner, Hz, at rest in this acceleration.
    pub fn new(corner: f64, last: f64) -> Self {
        Self {
            decay: (-TAU * corner * STEP).exp(),
            last,
            taken: 0.0,
        }
    }

    /// A step on.
    pub fn pass(&mut self, a: f64) -> f64 {
        self.taken = self.taken * self.decay + 0.5 * (a + self.last) * (1.0 - self.decay);
        self.last = a;
        a - self.taken
    }
}

/// What is made of so many seeds, by two threads and in the order in which they come to an end.
pub fn of_seeds<T: Send>(seeds: u64, run: impl Fn(u64) -> T + Sync) -> Vec<T> {
    const FIRST: u64 = 100;
    let next = AtomicU64::new(0);
    let found = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let k = next.fetch_add(1, Ordering::Relaxed);
                    if k >= seeds {
                        break;
                    }
                    let one = run(FIRST + k);
                    found.lock().expect("no panic").push(one);
                }
            });
        }
    });
    found.into_inner().expect("no panic")
}

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

/// A move of sin² from rest to rest: length speed · time/2.
fn hop(t: f64, speed: f64, time: f64) -> [f64; 3] {
    let s = t.clamp(0.0, time);
    let phase = TAU * s / time;
    [
        0.5 * speed * (s - time / TAU * phase.sin()),
        0.5 * speed * (1.0 - phase.cos()),
        if s == t {
            PI * speed / time * phase.sin()
        } else {
            0.0
        },
    ]
}

/// Out and back by such moves, with rests as long as they are.
pub fn stop_and_go(speed: f64, time: f64) -> Motion {
    Box::new(move |t| {
        let cycle = (t / (4.0 * time)).floor();
        let s = t - 4.0 * time * cycle;
        let (out, back) = (
            hop(s - 0.5 * time, speed, time),
            hop(s - 2.5 * time, speed, time),
        );
        std::array::from_fn(|i| out[i] - back[i])
    })
}

/// To and fro with accelerations that rise and fall along lines: seven phases each way.
pub fn s_curve(speed: f64, most: f64, jerk: f64) -> Motion {
    let rise = most / jerk;
    let hold = speed / most - rise;
    let run = 2.0 * rise + hold;
    let cruise = 0.5;
    // Velocity and way of the start, its acceleration a trapezoid.
    let start = move |t: f64| -> [f64; 3] {
        let s = t.clamp(0.0, run);
        let ramp = |u: f64| {
            let u = u.max(0.0);
            [jerk * u.powi(3) / 6.0, 0.5 * jerk * u * u, jerk * u]
        };
        let parts = [
            (1.0, s),
            (-1.0, s - rise),
            (-1.0, s - rise - hold),
            (1.0, s - run),
        ];
        let mut sum = [0.0; 3];
        for (sign, u) in parts {
            let r = ramp(u);
            for (total, part) in sum.iter_mut().zip(r) {
                *total += sign * part;
            }
        }
        [
            sum[0] + speed * (t - run).max(0.0),
            sum[1],
            if s == t { sum[2] } else { 0.0 },
        ]
    };
    // A start, a cruise, a stop and a rest as long as the cruise.
    let way = 2.0 * (run + cruise);
    Box::new(move |t| {
        let cycle = (t / way).floor();
        let s = t - way * cycle;
        let one = |s: f64, sign: f64| -> [f64; 3] {
            let (a, b) = (start(s), start(s - run - cruise));
            std::array::from_fn(|i| sign * (a[i] - b[i]))
        };
        // Out in even cycles, back in odd ones.
        let length = speed * (run + cruise);
        let even = (cycle as i64).rem_euclid(2) == 0;
        let [x, v, a] = one(s, if even { 1.0 } else { -1.0 });
        [if even { x } else { length + x }, v, a]
    })
}

/// A hand that leads an axis to and fro: twelve sines between 0.3 and 4 Hz, of random phase, their accelerations alike.
pub fn hand(acceleration: f64, seed: u64) -> Motion {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let lines: Vec<[f64; 3]> = (0..12)
        .map(|i| {
            let low = 0.3 * (4.0f64 / 0.3).powf(f64::from(i) / 12.0);
            let w = TAU * low * rng.random_range(1.0..1.2);
            [
                w,
                TAU * rng.random::<f64>(),
                acceleration / 12f64.sqrt() * 2f64.sqrt(),
            ]
        })
        .collect();
    Box::new(move |t| {
        let mut sum = [0.0; 3];
        for [w, phase, a] in &lines {
            let (s, c) = (w * t + phase).sin_cos();
            sum[0] -= a * s / (w * w);
            sum[1] -= a * c / w;
            sum[2] += a * s;
        }
        sum
    })
}

/// An even speed.
pub fn even(speed: f64) -> Motion {
    Box::new(move |t| [speed * t, speed, 0.0])
}

/// Even speed with short moves up and down by a share of it, every two seconds.
pub fn nearly_even(speed: f64, share: f64) -> Motion {
    Box::new(move |t| {
        let cycle = (t / 4.0).floor();
        let s = t - 4.0 * cycle;
        let (up, down) = (
            hop(s - 0.5, share * speed, 0.4),
            hop(s - 2.5, share * speed, 0.4),
        );
        let even = [speed * t, speed, 0.0];
        std::array::from_fn(|i| even[i] + up[i] - down[i])
    })
}
