//! The inner loop: oscillators side by side, so that their states stay in vector registers.

use super::{Extremes, Peaks};
use crate::oscillator::{Oscillator, Reading, widen};
use num_complex::Complex64;
use proofmass_core::Error;
use pulp::{Arch, Simd, WithSimd};

/// Oscillators that are stepped together: so many that no step waits for the one before it. Results do not depend on the width of the
/// registers.
pub(super) const LANES: usize = 16;

/// Samples between two looks at the onlooker.
const STRETCH: usize = 1 << 16;

type Lanes = [f64; LANES];

/// Oscillators as displacement and increment, which one sample drives: u₁ = p u₀ − q x₀ + a₀, x₁ = x₀ + u₁, p = |λ|²,
/// q = |1 − λ|², λ = e^μ, and y = g (x₀ + b u₀ + c u₁), or g (b u₀ + c u₁) of a reading that a constant acceleration leaves at
/// zero: eleven operations a sample, where the complex state takes fourteen.
///
/// It is the ramp-invariant filter w₁ = λ w₀ + d a₀, y = Re w + γ a, d = −κT(φ₁ − φ₂ + λφ₂), γ = −Re κTφ₂, in another state:
/// w = d [(1 − λ̄) x + λ̄ u]. Since |1 − λ| is known to all its digits, none is lost at low frequencies. The two real states
/// tell the two poles apart by Im λ: near half the sampling rate and above, [`Turning`] steps the complex state itself.
#[derive(Clone, Copy)]
struct Rising {
    p: Lanes,
    q: Lanes,
    b: Lanes,
    c: Lanes,
    state: [Lanes; 2],
}

/// What turns the state and the values of [`Rising`] into those of an oscillator.
#[derive(Clone, Copy)]
struct Scale {
    drive: Complex64,
    gain: f64,
}

impl Scale {
    /// κ times the state.
    fn reading(self, o: &Oscillator, x: f64, u: f64) -> Complex64 {
        let away = (o.pole * (o.gains[0] + o.gains[1])).conj();
        self.drive * (away * x + o.turn.conj() * u)
    }

    /// Least and greatest y.
    fn range(self, low: f64, high: f64) -> [f64; 2] {
        let [a, b] = [self.gain * low, self.gain * high];
        if self.gain < 0.0 { [b, a] } else { [a, b] }
    }
}

impl Rising {
    fn new(
        block: &[Oscillator],
        kappas: &[Reading],
        first: f64,
        settles: bool,
    ) -> (Self, Vec<Scale>) {
        let zero = [0.0; LANES];
        let mut bank = Self {
            p: zero,
            q: zero,
            b: zero,
            c: zero,
            state: [zero; 2],
        };
        let mut scales = Vec::with_capacity(block.len());
        for (k, (o, kappa)) in block.iter().zip(kappas).enumerate() {
            // 1 − λ = −μφ₁.
            let away = o.pole * (o.gains[0] + o.gains[1]);
            let drive = kappa * (o.gains[0] + o.turn * o.gains[1]);
            let direct = (kappa * o.gains[1]).re;
            let (p, q) = ((2.0 * o.pole.re * o.step).exp(), away.norm_sqr());
            let of_x = (drive * away.conj()).re + direct * q;
            let of_u = (drive * o.turn.conj()).re - direct * p;
            let gain = if settles { of_x } else { 1.0 };
            (bank.p[k], bank.q[k]) = (p, q);
            (bank.b[k], bank.c[k]) = (of_u / gain, direct / gain);
            // At rest on the first sample z = 0: w = γ-part of it alone.
            let start = -kappa * o.gains[1] * first / drive;
            let apart = start.im / o.turn.im;
            let x = start.re + o.turn.re * apart;
            (bank.state[0][k], bank.state[1][k]) = (x, x - apart);
            scales.push(Scale { drive, gain });
        }
        (bank, scales)
    }
}

/// Oscillators in the shifted and turned state w = κ(z + Tφ₂ a), which one sample drives: w₁ = e^μ w₀ + c a₀,
/// c = −κT(φ₁ − φ₂ + e^μ φ₂), and y = Re w + γ a. After the last sample w is κ times the state one step later, the
/// acceleration having run down to zero.
#[derive(Clone, Copy)]
struct Turning {
    turn: [Lanes; 2],
    drive: [Lanes; 2],
    direct: Lanes,
    state: [Lanes; 2],
}

impl Turning {
    fn new(block: &[Oscillator], kappas: &[Reading], first: f64) -> Self {
        let zero = [0.0; LANES];
        let mut bank = Self {
            turn: [zero; 2],
            drive: [zero; 2],
            direct: zero,
            state: [zero; 2],
        };
        for (k, (o, kappa)) in block.iter().zip(kappas).enumerate() {
            let drive = kappa * (o.gains[0] + o.turn * o.gains[1]);
            // At rest on the first sample z = 0.
            let start = -kappa * o.gains[1] * first;
            bank.turn[0][k] = o.turn.re;
            bank.turn[1][k] = o.turn.im;
            bank.drive[0][k] = drive.re;
            bank.drive[1][k] = drive.im;
            bank.direct[k] = (kappa * o.gains[1]).re;
            bank.state[0][k] = start.re;
            bank.state[1][k] = start.im;
        }
        bank
    }
}

/// Whether an oscillator is slow enough against the samples for [`Rising`]: its two poles stand apart.
pub(super) fn slow(o: &Oscillator) -> bool {
    o.pole.im * o.step < 2.8
}

/// What is read, and how, of every block alike.
#[derive(Clone, Copy)]
pub(super) struct Task<'a> {
    pub(super) record: &'a [f64],
    /// First sample after the shock.
    pub(super) end: usize,
    pub(super) peaks: Peaks,
    /// Whether a constant acceleration leaves the reading at another value than zero.
    pub(super) settles: bool,
}

/// Extremes of one block of oscillators, all of them [`slow`] or none.
pub(super) fn extremes(
    block: &[Oscillator],
    kappas: &[Reading],
    task: &Task<'_>,
    look: &dyn Fn() -> Result<(), Error>,
) -> Result<Vec<Extremes>, Error> {
    let record = task.record;
    let parts = [&record[..task.end], &record[task.end..]];
    let mut ranges = [[[0.0; LANES]; 2]; 2];
    // Range of each part and state after the last sample.
    let seen: Vec<([[f64; 2]; 2], Complex64)> = if block.iter().all(slow) {
        let (mut bank, scales) = Rising::new(block, kappas, record[0], task.settles);
        for (part, range) in parts.into_iter().zip(&mut ranges) {
            for stretch in part.chunks(STRETCH) {
                look()?;
                let bank = &mut bank;
                if task.settles {
                    Arch::new().dispatch(Rise::<true> {
                        bank,
                        stretch,
                        range,
                    });
                } else {
                    Arch::new().dispatch(Rise::<false> {
                        bank,
                        stretch,
                        range,
                    });
                }
            }
        }
        let each = block.iter().zip(&scales).enumerate();
        each.map(|(k, (o, scale))| {
            let range = |p: usize| scale.range(ranges[p][0][k], ranges[p][1][k]);
            let state = scale.reading(o, bank.state[0][k], bank.state[1][k]);
            ([range(0), range(1)], state)
        })
        .collect()
    } else {
        let mut bank = Turning::new(block, kappas, record[0]);
        for (part, range) in parts.into_iter().zip(&mut ranges) {
            for stretch in part.chunks(STRETCH) {
                look()?;
                Arch::new().dispatch(Turn {
                    bank: &mut bank,
                    stretch,
                    range,
                });
            }
        }
        let state = |k: usize| Complex64::new(bank.state[0][k], bank.state[1][k]);
        (0..block.len())
            .map(|k| ([0, 1].map(|p| [ranges[p][0][k], ranges[p][1][k]]), state(k)))
            .collect()
    };
    let mut result = Vec::with_capacity(block.len());
    for ((o, kappa), ([mut primary, mut recorded], state)) in block.iter().zip(kappas).zip(seen) {
        if task.peaks == Peaks::BetweenSamples {
            look()?;
            between(o, *kappa, record, task.end, &mut primary, &mut recorded);
        }
        let mut free = [0.0; 2];
        widen(&mut free, state.re);
        for y in o.free_extremes(state).unwrap_or_default() {
            widen(&mut free, y);
        }
        result.push(Extremes {
            primary,
            recorded,
            free,
        });
    }
    Ok(result)
}

/// A stretch of samples through [`Rising`].
struct Rise<'a, const SETTLES: bool> {
    bank: &'a mut Rising,
    stretch: &'a [f64],
    range: &'a mut [Lanes; 2],
}

impl<const SETTLES: bool> WithSimd for Rise<'_, SETTLES> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Rising {
            p,
            q,
            b,
            c,
            state: [mut x, mut u],
        } = *self.bank;
        let [mut low, mut high] = *self.range;
        for &a in self.stretch {
            for k in 0..LANES {
                let next = (p[k] * u[k] + a) - q[k] * x[k];
                let y = if SETTLES {
                    x[k] + b[k] * u[k] + c[k] * next
                } else {
                    b[k] * u[k] + c[k] * next
                };
                low[k] = if y < low[k] { y } else { low[k] };
                high[k] = if y > high[k] { y } else { high[k] };
                u[k] = next;
                x[k] += next;
            }
        }
        self.bank.state = [x, u];
        *self.range = [low, high];
    }
}

/// A stretch of samples through [`Turning`].
struct Turn<'a> {
    bank: &'a mut Turning,
    stretch: &'a [f64],
    range: &'a mut [Lanes; 2],
}

impl WithSimd for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Turning {
            turn: [er, ei],
            drive: [cr, ci],
            direct,
            state: [mut wr, mut wi],
        } = *self.bank;
        let [mut low, mut high] = *self.range;
        for &a in self.stretch {
            for k in 0..LANES {
                let (r, i) = (wr[k], wi[k]);
                let y = r + direct[k] * a;
                low[k] = if y < low[k] { y } else { low[k] };
                high[k] = if y > high[k] { y } else { high[k] };
                wr[k] = er[k] * r - ei[k] * i + cr[k] * a;
                wi[k] = er[k] * i + ei[k] * r + ci[k] * a;
            }
        }
        self.bank.state = [wr, wi];
        *self.range = [low, high];
    }
}

/// Widens both ranges by the extremes between samples.
fn between(
    o: &Oscillator,
    kappa: Reading,
    record: &[f64],
    end: usize,
    primary: &mut [f64; 2],
    recorded: &mut [f64; 2],
) {
    let mut z = Complex64::new(0.0, 0.0);
    for (n, pair) in record.windows(2).enumerate() {
        let range = if n + 1 < end {
            &mut *primary
        } else {
            &mut *recorded
        };
        o.widen_within(kappa, z, (pair[0], pair[1]), range);
        z = o.next(z, pair[0], pair[1]);
    }
    let last = record[record.len() - 1];
    let range = if end == record.len() {
        primary
    } else {
        recorded
    };
    o.widen_within(kappa, z, (last, 0.0), range);
}
