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
/// Harmonics that are taken away with one reading.
const AT_ONCE: usize = 5;

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
    fn with_simd<S: Simd>(self, simd: S) -> Look {
        let Self {
            tables,
            x,
            fit,
            blocks,
            ask,
        } = self;
        let harmonics = fit.amplitudes.len();
        let scale = tables.scale();
        let zero = Complex64::new(0.0, 0.0);
        let mut total = Look {
            demodulated: vec![zero; harmonics],
            weighted: vec![zero; usize::from(ask.weighted)],
            series: Vec::with_capacity(blocks.len()),
            ..Look::default()
        };
        let mut r = vec![0.0; tables.block];
        let mut turned = vec![zero; harmonics];
        for &block in blocks {
            let start = block * tables.block;
            let x = &x[start..(start + tables.block).min(tables.samples)];
            let tau = tables.tau(block);
            let r = &mut r[..x.len()];
            for (h, (turned, a)) in turned.iter_mut().zip(&fit.amplitudes).enumerate() {
                *turned = a * tables.anchor(h + 1, block);
            }
            let trend = [fit.offset + fit.drift * tau, fit.drift * scale];
            let (first, others) = turned.split_at(AT_ONCE.min(harmonics));
            let [mut power, mut sum] = subtract_all::<S, true>(simd, x, trend, tables, 0, first, r);
            for (k, group) in others.chunks(AT_ONCE).enumerate() {
                let from = AT_ONCE * (k + 1);
                [power, sum] = subtract_all::<S, false>(simd, x, trend, tables, from, group, r);
            }
            total.power += power;
            total.sum += sum;
            if ask.drift {
                let [along] = products(simd, r, [&tables.ramp]);
                total.slope += tau * sum + scale * along;
            }
            let mut fundamental = zero;
            for h in (0..harmonics).step_by(2) {
                let (cosine, sine) = (&tables.cosine, &tables.sine);
                let sums = if h + 1 < harmonics {
                    products(
                        simd,
                        r,
                        [&cosine[h], &sine[h], &cosine[h + 1], &sine[h + 1]],
                    )
                } else {
                    let [c, s] = products(simd, r, [&cosine[h], &sine[h]]);
                    [c, s, 0.0, 0.0]
                };
                for (k, sums) in sums.chunks_exact(2).enumerate().take(harmonics - h) {
                    let anchor = tables.anchor(h + k + 1, block).conj();
                    let z = Complex64::new(sums[0], -sums[1]) * anchor;
                    total.demodulated[h + k] += z;
                    if h + k == 0 {
                        fundamental = z;
                    }
                }
            }
            if x.len() == tables.block {
                total.series.push(fundamental);
            }
            if ask.weighted {
                // τ is that of the first sample and a ramp within the block.
                let [c, s] = products(simd, r, [&tables.ramped[0], &tables.ramped[1]]);
                let within = Complex64::new(c, -s) * tables.anchor(1, block).conj();
                total.weighted[0] += fundamental * tau + within * scale;
            }
        }
        total
    }
}

/// Numbers that are summed side by side, in as many registers as they take.
#[derive(Clone, Copy)]
struct Lanes<S: Simd> {
    simd: S,
    /// The first of these, as many as it takes.
    registers: [S::f64s; LANES],
}

impl<S: Simd> Lanes<S> {
    const REGISTERS: usize = LANES / S::F64_LANES;

    #[inline(always)]
    fn new(simd: S, x: f64) -> Self {
        let registers = [simd.splat_f64s(x); LANES];
        Self { simd, registers }
    }

    #[inline(always)]
    fn load(simd: S, x: &[f64; LANES]) -> Self {
        let mut lanes = Self::new(simd, 0.0);
        for (register, part) in lanes.registers.iter_mut().zip(S::as_simd_f64s(x).0) {
            *register = *part;
        }
        lanes
    }

    #[inline(always)]
    fn store(self, x: &mut [f64; LANES]) {
        for (part, register) in S::as_mut_simd_f64s(x).0.iter_mut().zip(self.registers) {
            *part = register;
        }
    }

    #[inline(always)]
    fn plus(mut self, b: Self) -> Self {
        for k in 0..Self::REGISTERS {
            self.registers[k] = self.simd.add_f64s(self.registers[k], b.registers[k]);
        }
        self
    }

    #[inline(always)]
    fn minus(mut self, b: Self) -> Self {
        for k in 0..Self::REGISTERS {
            self.registers[k] = self.simd.sub_f64s(self.registers[k], b.registers[k]);
        }
        self
    }

    #[inline(always)]
    fn times(mut self, b: Self) -> Self {
        for k in 0..Self::REGISTERS {
            self.registers[k] = self.simd.mul_f64s(self.registers[k], b.registers[k]);
        }
        self
    }

    #[inline(always)]
    fn sum(self) -> f64 {
        let mut x = [0.0; LANES];
        self.store(&mut x);
        x.iter().sum()
    }
}

/// Takes the harmonics from `from` on away, Re Σ a e^{jhωl}: at first from the samples less their trend (its value at the
/// first sample and its slope), then from what is left of them. Σ r² and Σ r of what is left now.
#[inline(always)]
fn subtract_all<S: Simd, const FIRST: bool>(
    simd: S,
    x: &[f64],
    trend: [f64; 2],
    tables: &Tables,
    from: usize,
    amplitudes: &[Complex64],
    r: &mut [f64],
) -> [f64; 2] {
    match *amplitudes {
        [a] => subtract::<S, FIRST, 1>(simd, x, trend, tables, from, [a], r),
        [a, b] => subtract::<S, FIRST, 2>(simd, x, trend, tables, from, [a, b], r),
        [a, b, c] => subtract::<S, FIRST, 3>(simd, x, trend, tables, from, [a, b, c], r),
        [a, b, c, d] => subtract::<S, FIRST, 4>(simd, x, trend, tables, from, [a, b, c, d], r),
        [a, b, c, d, e, ..] => {
            subtract::<S, FIRST, 5>(simd, x, trend, tables, from, [a, b, c, d, e], r)
        }
        [] => subtract::<S, FIRST, 0>(simd, x, trend, tables, from, [], r),
    }
}

/// The same for so many that one reading of r does for all.
#[inline(always)]
fn subtract<S: Simd, const FIRST: bool, const H: usize>(
    simd: S,
    x: &[f64],
    [trend, slope]: [f64; 2],
    tables: &Tables,
    from: usize,
    amplitudes: [Complex64; H],
    r: &mut [f64],
) -> [f64; 2] {
    let (x8, x_rest) = x.as_chunks::<LANES>();
    let (r8, r_rest) = r.as_chunks_mut::<LANES>();
    let ramp = &tables.ramp.as_chunks::<LANES>().0[..x8.len()];
    let (mut cosine, mut sine) = ([ramp; H], [ramp; H]);
    let [mut re, mut im] = [[Lanes::new(simd, 0.0); H]; 2];
    for h in 0..H {
        cosine[h] = &tables.cosine[from + h].as_chunks::<LANES>().0[..x8.len()];
        sine[h] = &tables.sine[from + h].as_chunks::<LANES>().0[..x8.len()];
        re[h] = Lanes::new(simd, amplitudes[h].re);
        im[h] = Lanes::new(simd, amplitudes[h].im);
    }
    let (start, rise) = (Lanes::new(simd, trend), Lanes::new(simd, slope));
    let [mut square, mut sum] = [Lanes::new(simd, 0.0); 2];
    for (k, (x, r)) in x8.iter().zip(r8).enumerate() {
        let mut left = if FIRST {
            let ramp = Lanes::load(simd, &ramp[k]).times(rise);
            Lanes::load(simd, x).minus(start).minus(ramp)
        } else {
            Lanes::load(simd, r)
        };
        for h in 0..H {
            let c = Lanes::load(simd, &cosine[h][k]).times(re[h]);
            let s = Lanes::load(simd, &sine[h][k]).times(im[h]);
            left = left.minus(c.minus(s));
        }
        left.store(r);
        square = square.plus(left.times(left));
        sum = sum.plus(left);
    }
    let mut sums = [0.0; 2];
    let done = LANES * x8.len();
    for (k, (x, r)) in x_rest.iter().zip(r_rest).enumerate() {
        if FIRST {
            *r = x - trend - slope * tables.ramp[done + k];
        }
        for h in 0..H {
            let (c, s) = (
                tables.cosine[from + h][done + k],
                tables.sine[from + h][done + k],
            );
            *r -= amplitudes[h].re * c - amplitudes[h].im * s;
        }
        sums[0] += *r * *r;
        sums[1] += *r;
    }
    [square.sum() + sums[0], sum.sum() + sums[1]]
}

/// Σ r b over the length of r, for some b that may be longer: the last block of a record is shorter than the tables.
#[inline(always)]
fn products<S: Simd, const D: usize>(simd: S, r: &[f64], b: [&[f64]; D]) -> [f64; D] {
    let (whole, rest) = r.as_chunks::<LANES>();
    let none: &[[f64; LANES]] = &[];
    let mut others = [none; D];
    for (others, b) in others.iter_mut().zip(b) {
        *others = &b.as_chunks::<LANES>().0[..whole.len()];
    }
    let mut lanes = [Lanes::new(simd, 0.0); D];
    for (k, r) in whole.iter().enumerate() {
        let r = Lanes::load(simd, r);
        for d in 0..D {
            lanes[d] = lanes[d].plus(r.times(Lanes::load(simd, &others[d][k])));
        }
    }
    let mut sums = [0.0; D];
    for d in 0..D {
        for (r, b) in rest.iter().zip(&b[d][LANES * whole.len()..]) {
            sums[d] += r * b;
        }
        sums[d] += lanes[d].sum();
    }
    sums
}
