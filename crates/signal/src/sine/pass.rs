//! The two passes over the samples: moments against the harmonics, then the residuals.

use super::Coefficients;
use faer::c64;
use rayon::prelude::*;

/// Samples per block: the tables of a few harmonics stay in the first-level cache.
const BLOCK: usize = 512;
/// Blocks that one task takes; sums over tasks are added in order, so the thread count changes nothing.
const BLOCKS_PER_TASK: usize = 128;

/// cos(hωl) and sin(hωl) for one block, and the exact anchor of every block.
pub(crate) struct Tables {
    pub(crate) omega: f64,
    pub(crate) samples: usize,
    pub(crate) block: usize,
    middle: f64,
    cosine: Vec<Vec<f64>>,
    sine: Vec<Vec<f64>>,
    ramp: Vec<f64>,
}

impl Tables {
    pub(crate) fn new(omega: f64, samples: usize, harmonics: usize) -> Self {
        // At least sixteen blocks, so that the demodulated series has bins beside the drive.
        let block = (samples / 16).clamp(8, BLOCK);
        let table = |f: fn(f64) -> f64| -> Vec<Vec<f64>> {
            (1..=harmonics)
                .map(|h| (0..block).map(|l| f(h as f64 * omega * l as f64)).collect())
                .collect()
        };
        Self {
            omega,
            samples,
            block,
            middle: 0.5 * (samples - 1) as f64,
            cosine: table(f64::cos),
            sine: table(f64::sin),
            ramp: (0..block).map(|l| l as f64).collect(),
        }
    }

    /// e^{jkω(n − middle)} for the first sample n of a block.
    fn anchor(&self, k: usize, start: usize) -> c64 {
        let (s, c) = (k as f64 * self.omega * (start as f64 - self.middle)).sin_cos();
        c64::new(c, s)
    }

    /// τ of a sample: −1 … 1 over the record.
    fn tau(&self, n: f64) -> f64 {
        2.0 * (n - self.middle) / self.samples as f64
    }

    /// Σ_n τᵖ e^{jkω(n − middle)} for p = 0, 1, 2 and k = 0 … `highest`, block by block.
    pub(crate) fn power_sums(&self, highest: usize) -> [Vec<c64>; 3] {
        let scale = 2.0 / self.samples as f64;
        let inside = |k: usize, length: usize| -> [c64; 3] {
            let mut sums = [c64::new(0.0, 0.0); 3];
            for l in 0..length {
                let (s, c) = (k as f64 * self.omega * l as f64).sin_cos();
                let (e, t) = (c64::new(c, s), scale * l as f64);
                sums[0] += e;
                sums[1] += e * t;
                sums[2] += e * (t * t);
            }
            sums
        };
        let mut result = [vec![], vec![], vec![]];
        for k in 0..=highest {
            let full = inside(k, self.block);
            let last = inside(k, self.samples % self.block);
            let mut sums = [c64::new(0.0, 0.0); 3];
            for start in (0..self.samples).step_by(self.block) {
                let part = if start + self.block <= self.samples {
                    full
                } else {
                    last
                };
                let (e, t) = (self.anchor(k, start), self.tau(start as f64));
                sums[0] += e * part[0];
                sums[1] += e * (part[1] + part[0] * t);
                sums[2] += e * (part[2] + part[1] * (2.0 * t) + part[0] * (t * t));
            }
            for (r, s) in result.iter_mut().zip(sums) {
                r.push(s);
            }
        }
        result
    }
}

/// Samples that are summed side by side, so that the compiler can keep the sums in vector registers.
const LANES: usize = 8;

/// Σ a b over the length of `a`.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    // The last block of a record is shorter than the tables.
    let b = &b[..a.len()];
    let mut lanes = [0.0; LANES];
    let ((a8, a_rest), (b8, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in a8.iter().zip(b8) {
        for i in 0..LANES {
            lanes[i] += a[i] * b[i];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    lanes.iter().sum::<f64>() + rest
}

/// Σ x, Σ x c, Σ x s in one reading of the block.
fn sums(x: &[f64], c: &[f64], s: &[f64]) -> [f64; 3] {
    let (c, s) = (&c[..x.len()], &s[..x.len()]);
    let mut lanes = [[0.0; LANES]; 3];
    let (x8, x_rest) = x.as_chunks::<LANES>();
    let (c8, c_rest) = c.as_chunks::<LANES>();
    let (s8, s_rest) = s.as_chunks::<LANES>();
    for ((x, c), s) in x8.iter().zip(c8).zip(s8) {
        for i in 0..LANES {
            lanes[0][i] += x[i];
            lanes[1][i] += x[i] * c[i];
            lanes[2][i] += x[i] * s[i];
        }
    }
    let mut total = lanes.map(|l| l.iter().sum::<f64>());
    for ((x, c), s) in x_rest.iter().zip(c_rest).zip(s_rest) {
        total[0] += x;
        total[1] += x * c;
        total[2] += x * s;
    }
    total
}

/// r = x − (trend + re c − im s): residuals without drift, with Σ r², Σ r c, Σ r s.
fn subtract(x: &[f64], c: &[f64], s: &[f64], trend: f64, a: c64, r: &mut [f64]) -> [f64; 3] {
    let (c, s, r) = (&c[..x.len()], &s[..x.len()], &mut r[..x.len()]);
    let mut lanes = [[0.0; LANES]; 3];
    let (x8, x_rest) = x.as_chunks::<LANES>();
    let (c8, c_rest) = c.as_chunks::<LANES>();
    let (s8, s_rest) = s.as_chunks::<LANES>();
    let (r8, r_rest) = r.as_chunks_mut::<LANES>();
    for (((x, c), s), r) in x8.iter().zip(c8).zip(s8).zip(r8) {
        for i in 0..LANES {
            let residual = x[i] - trend - (a.re * c[i] - a.im * s[i]);
            r[i] = residual;
            lanes[0][i] += residual * residual;
            lanes[1][i] += residual * c[i];
            lanes[2][i] += residual * s[i];
        }
    }
    let mut total = lanes.map(|l| l.iter().sum::<f64>());
    for (((x, c), s), r) in x_rest.iter().zip(c_rest).zip(s_rest).zip(r_rest) {
        *r = x - trend - (a.re * c - a.im * s);
        total[0] += *r * *r;
        total[1] += *r * c;
        total[2] += *r * s;
    }
    total
}

/// What the first pass knows of a channel.
#[derive(Clone, Debug)]
pub(crate) struct Moments {
    pub(crate) sum: f64,
    pub(crate) slope: f64,
    pub(crate) demodulated: Vec<c64>,
}

/// What the second pass knows of the residuals of a channel.
#[derive(Clone, Debug, Default)]
pub(crate) struct Residue {
    pub(crate) power: f64,
    /// Σ τ r e^{−jhωn} per harmonic, when the frequency is sought.
    pub(crate) weighted: Vec<c64>,
    /// Σ r e^{−jωn} per full block.
    pub(crate) series: Vec<c64>,
}

fn tasks<T: Send>(
    tables: &Tables,
    channels: &[&[f64]],
    work: impl Fn(usize, usize, &[f64]) -> T + Sync,
) -> Vec<Vec<T>> {
    let stretch = tables.block * BLOCKS_PER_TASK;
    let per_channel = tables.samples.div_ceil(stretch);
    let mut parts: Vec<T> = (0..channels.len() * per_channel)
        .into_par_iter()
        .map(|task| {
            let (channel, start) = (task / per_channel, task % per_channel * stretch);
            let end = (start + stretch).min(tables.samples);
            work(channel, start, &channels[channel][start..end])
        })
        .collect();
    let mut result = Vec::with_capacity(channels.len());
    for _ in channels {
        let rest = parts.split_off(per_channel);
        result.push(parts);
        parts = rest;
    }
    result
}

pub(crate) fn moments(tables: &Tables, channels: &[&[f64]], drift: bool) -> Vec<Moments> {
    let harmonics = tables.cosine.len();
    let empty = || Moments {
        sum: 0.0,
        slope: 0.0,
        demodulated: vec![c64::new(0.0, 0.0); harmonics],
    };
    let parts = tasks(tables, channels, |_, first, x| {
        let mut total = empty();
        for (b, x) in x.chunks(tables.block).enumerate() {
            let start = first + b * tables.block;
            let [s, c, q] = sums(x, &tables.cosine[0], &tables.sine[0]);
            total.sum += s;
            total.demodulated[0] += c64::new(c, -q) * tables.anchor(1, start).conj();
            if drift {
                let scale = 2.0 / tables.samples as f64;
                total.slope += tables.tau(start as f64) * s + scale * dot(x, &tables.ramp);
            }
            for h in 1..harmonics {
                let z = c64::new(dot(x, &tables.cosine[h]), -dot(x, &tables.sine[h]));
                total.demodulated[h] += z * tables.anchor(h + 1, start).conj();
            }
        }
        total
    });
    parts
        .into_iter()
        .map(|parts| {
            parts.into_iter().fold(empty(), |mut total, part| {
                total.sum += part.sum;
                total.slope += part.slope;
                for (t, p) in total.demodulated.iter_mut().zip(part.demodulated) {
                    *t += p;
                }
                total
            })
        })
        .collect()
}

pub(crate) fn residues(
    tables: &Tables,
    channels: &[&[f64]],
    fitted: &[Coefficients],
    weighted: bool,
) -> Vec<Residue> {
    let parts = tasks(tables, channels, |channel, first, x| {
        let fit = &fitted[channel];
        let mut r = vec![0.0; tables.block];
        let mut part = Residue::default();
        if weighted {
            part.weighted = vec![c64::new(0.0, 0.0); fit.amplitudes.len()];
        }
        let scale = 2.0 / tables.samples as f64;
        let mut product = vec![0.0; tables.block];
        for (b, x) in x.chunks(tables.block).enumerate() {
            let start = first + b * tables.block;
            let tau = tables.tau(start as f64);
            let r = &mut r[..x.len()];
            let trend = fit.offset + fit.drift * tau;
            let (c, s) = (&tables.cosine[0], &tables.sine[0]);
            let anchored = |h: usize| fit.amplitudes[h] * tables.anchor(h + 1, start);
            let mut totals = subtract(x, c, s, trend, anchored(0), r);
            if fit.drift != 0.0 || fit.amplitudes.len() > 1 {
                let slope = fit.drift * scale;
                for (r, l) in r.iter_mut().zip(&tables.ramp) {
                    *r -= slope * l;
                }
                for h in 1..fit.amplitudes.len() {
                    let a = anchored(h);
                    for ((r, c), s) in r.iter_mut().zip(&tables.cosine[h]).zip(&tables.sine[h]) {
                        *r -= a.re * c - a.im * s;
                    }
                }
                totals = [dot(r, r), dot(r, c), dot(r, s)];
            }
            part.power += totals[0];
            let z = c64::new(totals[1], -totals[2]) * tables.anchor(1, start).conj();
            if x.len() == tables.block {
                part.series.push(z);
            }
            if weighted {
                let product = &mut product[..r.len()];
                for ((p, r), l) in product.iter_mut().zip(&*r).zip(&tables.ramp) {
                    *p = r * (tau + scale * l);
                }
                for (h, w) in part.weighted.iter_mut().enumerate() {
                    let z = c64::new(
                        dot(product, &tables.cosine[h]),
                        -dot(product, &tables.sine[h]),
                    );
                    *w += z * tables.anchor(h + 1, start).conj();
                }
            }
        }
        part
    });
    parts
        .into_iter()
        .map(|parts| {
            parts
                .into_iter()
                .fold(Residue::default(), |mut total, part| {
                    total.power += part.power;
                    total.series.extend(part.series);
                    if total.weighted.is_empty() {
                        total.weighted = part.weighted;
                    } else {
                        for (t, p) in total.weighted.iter_mut().zip(part.weighted) {
                            *t += p;
                        }
                    }
                    total
                })
        })
        .collect()
}
