//! What clocks and transports do to the time stamps of samples that were taken evenly.

use rand::RngExt;
use rand_distr::{Distribution, Exp1, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus as Random;
use std::fmt::Write;

/// Samples taken for a recording.
const SAMPLES: usize = 4000;
/// Rates between which they are drawn, evenly in their logarithm, Hz.
const RATES: (f64, f64) = (50.0, 400.0);

/// One kind of recording.
#[derive(Clone, Copy)]
pub struct Cell {
    /// What is done to the stamps.
    pub name: &'static str,
    loss: f64,
    /// Rows that are lost together.
    together: usize,
    /// Standard deviation of the stamps, intervals.
    jitter: f64,
    /// Mean time, intervals, until a busy computer puts a stamp on; one waits for the one before.
    host: f64,
    /// Samples that are handed over together.
    packet: usize,
    /// Change of the rate over the recording, evenly and as a clock that warms up.
    drift: f64,
    warming: f64,
    /// Decimals of a second that are written.
    decimals: usize,
    /// Rows that stand there twice.
    doubled: f64,
    /// Counter of so many bits, of milliseconds or of microseconds, that begins again within the recording.
    counter: Option<(u32, f64, &'static str)>,
}

const EVEN: Cell = Cell {
    name: "even",
    loss: 0.0,
    together: 1,
    jitter: 0.0,
    host: 0.0,
    packet: 1,
    drift: 0.0,
    warming: 0.0,
    decimals: 6,
    doubled: 0.0,
    counter: None,
};

/// Every cell of the map.
#[rustfmt::skip]
pub const CELLS: &[Cell] = &[
    EVEN,
    Cell { name: "1 % of the rows lost", loss: 0.01, ..EVEN },
    Cell { name: "5 % lost", loss: 0.05, ..EVEN },
    Cell { name: "10 % lost", loss: 0.1, ..EVEN },
    Cell { name: "20 % lost", loss: 0.2, ..EVEN },
    Cell { name: "40 % lost", loss: 0.4, ..EVEN },
    Cell { name: "20 % lost, eight at a time", loss: 0.2, together: 8, ..EVEN },
    Cell { name: "jitter of 1 % of a step", jitter: 0.01, ..EVEN },
    Cell { name: "jitter of 5 %", jitter: 0.05, ..EVEN },
    Cell { name: "jitter of 10 %", jitter: 0.1, ..EVEN },
    Cell { name: "jitter of 20 %", jitter: 0.2, ..EVEN },
    Cell { name: "jitter of 30 %", jitter: 0.3, ..EVEN },
    Cell { name: "jitter of 50 %", jitter: 0.5, ..EVEN },
    Cell { name: "jitter of 5 %, 10 % lost", jitter: 0.05, loss: 0.1, ..EVEN },
    Cell { name: "jitter of 5 %, 40 % lost", jitter: 0.05, loss: 0.4, ..EVEN },
    Cell { name: "jitter of 10 %, 5 % lost", jitter: 0.1, loss: 0.05, ..EVEN },
    Cell { name: "jitter of 10 %, 10 % lost", jitter: 0.1, loss: 0.1, ..EVEN },
    Cell { name: "jitter of 10 %, 40 % lost", jitter: 0.1, loss: 0.4, ..EVEN },
    Cell { name: "jitter of 20 %, 1 % lost", jitter: 0.2, loss: 0.01, ..EVEN },
    Cell { name: "jitter of 20 %, 10 % lost", jitter: 0.2, loss: 0.1, ..EVEN },
    Cell { name: "jitter of 20 %, 40 % lost", jitter: 0.2, loss: 0.4, ..EVEN },
    Cell { name: "jitter of 30 %, 1 % lost", jitter: 0.3, loss: 0.01, ..EVEN },
    Cell { name: "jitter of 30 %, 10 % lost", jitter: 0.3, loss: 0.1, ..EVEN },
    Cell { name: "jitter of 30 %, 40 % lost", jitter: 0.3, loss: 0.4, ..EVEN },
    Cell { name: "jitter of 50 %, 10 % lost", jitter: 0.5, loss: 0.1, ..EVEN },
    Cell { name: "jitter of 50 %, 40 % lost", jitter: 0.5, loss: 0.4, ..EVEN },
    Cell { name: "host, late by 0.2 steps", host: 0.2, ..EVEN },
    Cell { name: "host, 1 step", host: 1.0, ..EVEN },
    Cell { name: "host, 3 steps", host: 3.0, ..EVEN },
    Cell { name: "host, 0.2 steps, 10 % lost", host: 0.2, loss: 0.1, ..EVEN },
    Cell { name: "host, 1 step, 10 % lost", host: 1.0, loss: 0.1, ..EVEN },
    Cell { name: "host, 3 steps, 10 % lost", host: 3.0, loss: 0.1, ..EVEN },
    Cell { name: "packets of 8", packet: 8, ..EVEN },
    Cell { name: "packets of 8, host, 0.2 steps", packet: 8, host: 0.2, ..EVEN },
    Cell { name: "packets of 8, host, 10 % lost", packet: 8, host: 0.2, loss: 0.1, ..EVEN },
    Cell { name: "drift of 50 ppm", drift: 50e-6, ..EVEN },
    Cell { name: "drift of 200 ppm", drift: 200e-6, ..EVEN },
    Cell { name: "warming by 200 ppm", warming: 200e-6, ..EVEN },
    Cell { name: "drift of 200 ppm, jitter of 10 %", drift: 200e-6, jitter: 0.1, ..EVEN },
    Cell { name: "drift of 200 ppm, 10 % lost", drift: 200e-6, loss: 0.1, ..EVEN },
    Cell { name: "rounded to 1 ms", decimals: 3, ..EVEN },
    Cell { name: "rounded to 1 ms, 10 % lost", decimals: 3, loss: 0.1, ..EVEN },
    Cell { name: "rounded to 1 ms, 40 % lost", decimals: 3, loss: 0.4, ..EVEN },
    Cell { name: "rounded to 1 ms, jitter of 10 %, 10 % lost", decimals: 3, jitter: 0.1, loss: 0.1, ..EVEN },
    Cell { name: "rounded to 1 ms, drift of 200 ppm", decimals: 3, drift: 200e-6, ..EVEN },
    Cell { name: "rounded to 10 ms", decimals: 2, ..EVEN },
    Cell { name: "rounded to 10 ms, jitter of 10 %", decimals: 2, jitter: 0.1, ..EVEN },
    Cell { name: "rounded to 10 ms, 1 % lost", decimals: 2, loss: 0.01, ..EVEN },
    Cell { name: "rounded to 10 ms, 10 % lost", decimals: 2, loss: 0.1, ..EVEN },
    Cell { name: "rounded to 10 ms, 40 % lost", decimals: 2, loss: 0.4, ..EVEN },
    Cell { name: "1 % of the rows doubled", doubled: 0.01, ..EVEN },
    Cell { name: "20 % doubled", doubled: 0.2, ..EVEN },
    Cell { name: "1 % doubled, 10 % lost", doubled: 0.01, loss: 0.1, ..EVEN },
    Cell { name: "counter of 16 bits, ms", counter: Some((16, 1e3, "ms")), ..EVEN },
    Cell { name: "counter of 32 bits, µs, jitter of 10 %", counter: Some((32, 1e6, "us")), jitter: 0.1, ..EVEN },
    Cell { name: "counter of 32 bits, µs, 10 % lost", counter: Some((32, 1e6, "us")), loss: 0.1, ..EVEN },
];

impl Cell {
    /// A recording as text, and its true rate, Hz: samples over their time, by the clock that stamps them.
    pub fn recording(&self, random: &mut Random) -> (String, f64) {
        let rate = RATES.0 * (RATES.1 / RATES.0).powf(random.random());
        let start = 100.0 * random.random::<f64>();
        let last = (SAMPLES - 1) as f64;
        // Time of a sample in intervals: a rate that changes by so much from end to end, or as 1 − e^(−5 t).
        let taken = |k: usize| {
            let x = k as f64 / last;
            let drift = 0.5 * self.drift * x * (x - 1.0);
            let warming = self.warming * (x + (-5.0 * x).exp_m1() / 5.0);
            last * (x + drift + warming)
        };
        let true_rate = rate * last / (taken(SAMPLES - 1) - taken(0));
        let mut busy = f64::NEG_INFINITY;
        let mut stamps = Vec::with_capacity(SAMPLES);
        for k in 0..SAMPLES {
            let packet = (k / self.packet + 1) * self.packet - 1;
            let noise: f64 = StandardNormal.sample(random);
            let late: f64 = Exp1.sample(random);
            let mut t = taken(packet.min(SAMPLES - 1)) + self.jitter * noise;
            if self.host > 0.0 {
                busy = (t + self.host * late).max(busy + 0.02);
                t = busy;
            }
            stamps.push(start + t / rate);
        }
        let mut gone = 0;
        stamps.retain(|_| {
            if gone == 0 && random.random::<f64>() < self.loss / self.together as f64 {
                gone = self.together;
            }
            let there = gone == 0;
            gone = gone.saturating_sub(1);
            there
        });
        (self.text(&stamps, random), true_rate)
    }

    fn text(&self, stamps: &[f64], random: &mut Random) -> String {
        let mut text = match self.counter {
            Some((.., unit)) => format!("t_{unit},a_m/s2\n"),
            None => "t_s,a_m/s2\n".to_owned(),
        };
        // A counter begins again in the middle.
        let middle = stamps[stamps.len() / 2];
        for t in stamps {
            let a: f64 = StandardNormal.sample(random);
            let stamp = match self.counter {
                Some((bits, per_second, _)) => {
                    let turn = 2_f64.powi(bits as i32);
                    let count = ((t - middle) * per_second).floor().rem_euclid(turn);
                    format!("{count:.0}")
                }
                None => format!("{t:.*}", self.decimals),
            };
            let rows = 1 + usize::from(random.random::<f64>() < self.doubled);
            for _ in 0..rows {
                let _ = writeln!(text, "{stamp},{a:.3}");
            }
        }
        text
    }

    /// Where its random numbers begin.
    pub fn seed(&self) -> u64 {
        self.name.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, b| {
            (hash ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)
        })
    }
}
