//! The pass over the samples: what is left of them after a provisional fit, and its moments.

use super::Coefficients;
use super::tables::Tables;
use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Blocks that one task takes; sums over tasks are added in order, so the thread count changes nothing.
const BLOCKS_PER_TASK: usize = 64;

/// Samples that are summed side by side, so that the compiler can keep the sums in vector registers: their order is
/// the same whatever the width of the registers.
const LANES: usize = 8;

/// What the pass knows of r = x − (provisional fit) in one channel.
#[derive(Clone, Debug, Default)]
pub(crate) struct Look {
    /// Σ r².
    pub(crate) power: f64,
    /// Σ r and Σ τ r.
    pub(crate) sum: f64,
    pub(crate) slope: f64,
    /// Σ r e^{−jhωn} per harmonic.
    pub(crate) demodulated: Vec<Complex64>,
    /// Σ τ r e^{−jhωn} per harmonic, when the frequency is sought.
    pub(crate) weighted: Vec<Complex64>,
    /// Σ r e^{−jωn} per full block.
    pub(crate) series: Vec<Complex64>,
}

impl Look {
    fn add(&mut self, part: Self) {
        self.power += part.power;
        self.sum += part.sum;
        self.slope += part.slope;
        for (mine, theirs) in [
            (&mut self.demodulated, part.demodulated),
            (&mut self.weighted, part.weighted),
        ] {
            mine.resize(theirs.len(), Complex64::new(0.0, 0.0));
            for (t, p) in mine.iter_mut().zip(theirs) {
                *t += p;
            }
        }
        self.series.extend(part.series);
    }
}

/// What is asked of a pass.
#[derive(Clone, Copy)]
pub(crate) struct Ask {
    /// Whether a drift is fitted.
    pub(crate) drift: bool,
    /// Whether the frequency is sought.
    pub(crate) weighted: bool,
}

/// One reading of some blocks of every channel.
pub(crate) fn look(
    tables: &Tables,
    channels: &[&[f64]],
    provisional: &[Coefficients],
    blocks: &[usize],
    ask: Ask,
) -> Vec<Look> {
    let arch = Arch::new();
    let tasks: Vec<&[usize]> = blocks.chunks(BLOCKS_PER_TASK).collect();
    let parts: Vec<Look> = (0..channels.len() * tasks.len())
        .into_par_iter()
        .map(|task| {
            let channel = task / tasks.len();
            arch.dispatch(Stretch {
                tables,
                x: channels[channel],
                fit: &provisional[channel],
                blocks: tasks[task % tasks.len()],
                ask,
            })
        })
        .collect();
    let mut looks = vec![Look::default(); channels.len()];
    for (task, part) in parts.into_iter().enumerate() {
        looks[task / tasks.len()].add(part);
    }
    looks
}

/// Some blocks of one channel; a type of its own rather than a closure, so that it is compiled as a whole for the
/// widest vectors.
struct Stretch<'a> {
    tables: &'a Tables,
    x: &'a [f64],
    fit: &'a Coefficients,
    blocks: &'a [usize],
    ask: Ask,
}

impl WithSimd for Stretch<'_> {
    type Output = Look;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Look {
        let Self {
            tables,
            x,
            fit,
            blocks,
            ask,
        } = self;
        let harmonics = fit.amplitudes.len();
        let scale = tables.scale();
        let zeros = || vec![Complex64::new(0.0, 0.0); harmonics];
        let mut total = Look {
            demodulated: zeros(),
            weighted: if ask.weighted {
                vec![Complex64::new(0.0, 0.0)]
            } else {
                vec![]
            },
            series: Vec::with_capacity(blocks.len()),
            ..Look::default()
        };
        let mut r = vec![0.0; tables.block];
        for &block in blocks {
            let start = block * tables.block;
            let x = &x[start..(start + tables.block).min(tables.samples)];
            let tau = tables.tau(block);
            let r = &mut r[..x.len()];
            let trend = fit.offset + fit.drift * tau;
            let simple = fit.drift == 0.0 && harmonics == 1;
            let sums = if simple {
                let a = fit.amplitudes[0] * tables.anchor(1, block);
                subtract(x, &tables.cosine[0], &tables.sine[0], trend, a, r)
            } else {
                let slope = fit.drift * scale;
                for ((r, x), l) in r.iter_mut().zip(x).zip(&tables.ramp) {
                    *r = x - trend - slope * l;
                }
                for (h, amplitude) in fit.amplitudes.iter().enumerate() {
                    let a = amplitude * tables.anchor(h + 1, block);
                    for ((r, c), s) in r.iter_mut().zip(&tables.cosine[h]).zip(&tables.sine[h]) {
                        *r -= a.re * c - a.im * s;
                    }
                }
                moments(r, &tables.cosine[0], &tables.sine[0])
            };
            total.power += sums[0];
            total.sum += sums[1];
            if ask.drift {
                total.slope += tau * sums[1] + scale * dot(r, &tables.ramp);
            }
            let z = Complex64::new(sums[2], -sums[3]) * tables.anchor(1, block).conj();
            total.demodulated[0] += z;
            if x.len() == tables.block {
                total.series.push(z);
            }
            for h in 1..harmonics {
                total.demodulated[h] += harmonic(tables, r, h, block);
            }
            if ask.weighted {
                // τ is that of the first sample and a ramp within the block.
                let [c, s] = pair(r, &tables.ramped[0], &tables.ramped[1]);
                let within = Complex64::new(c, -s) * tables.anchor(1, block).conj();
                total.weighted[0] += z * tau + within * scale;
            }
        }
        total
    }
}

/// Σ r e^{−j(h + 1)ωn} over one block.
#[inline(always)]
fn harmonic(tables: &Tables, r: &[f64], h: usize, block: usize) -> Complex64 {
    let [c, s] = pair(r, &tables.cosine[h], &tables.sine[h]);
    Complex64::new(c, -s) * tables.anchor(h + 1, block).conj()
}

/// Σ a b over the length of `a`.
#[inline(always)]
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

/// Σ a over the length of `a`, in the order of [`dot`].
#[inline(always)]
fn total(a: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    let (a8, a_rest) = a.as_chunks::<LANES>();
    for a in a8 {
        for i in 0..LANES {
            lanes[i] += a[i];
        }
    }
    lanes.iter().sum::<f64>() + a_rest.iter().sum::<f64>()
}

/// Σ r c and Σ r s.
#[inline(always)]
fn pair(r: &[f64], c: &[f64], s: &[f64]) -> [f64; 2] {
    [dot(r, c), dot(r, s)]
}

/// Σ r², Σ r, Σ r c, Σ r s: one after the other, since together they are not kept in vector registers, and a block is near at hand.
#[inline(always)]
fn moments(r: &[f64], c: &[f64], s: &[f64]) -> [f64; 4] {
    [dot(r, r), total(r), dot(r, c), dot(r, s)]
}

/// r = x − (trend + re c − im s) with the moments of r.
#[inline(always)]
fn subtract(x: &[f64], c: &[f64], s: &[f64], trend: f64, a: Complex64, r: &mut [f64]) -> [f64; 4] {
    for (((r, x), c), s) in r.iter_mut().zip(x).zip(c).zip(s) {
        *r = x - trend - (a.re * c - a.im * s);
    }
    moments(r, c, s)
}
