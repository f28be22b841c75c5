//! The inner loop: oscillators side by side, so that their states stay in vector registers.

use super::{Extremes, Peaks};
use crate::oscillator::{Oscillator, Reading, widen};
use num_complex::Complex64;
use proofmass_core::Error;
use pulp::{Arch, Simd, WithSimd};

/// Oscillators that are stepped together. Results do not depend on the width of the registers.
pub(super) const LANES: usize = 8;

/// Samples between two looks at the onlooker.
const STRETCH: usize = 1 << 16;

type Lanes = [f64; LANES];

/// Eight oscillators in the shifted and turned state w = κ(z + Tφ₂ a), which one sample drives: w₁ = e^μ w₀ + c a₀,
/// c = −κT(φ₁ − φ₂ + e^μ φ₂), and y = Re w + γ a. After the last sample w is κ times the state one step later, the
/// acceleration having run down to zero.
#[derive(Clone, Copy)]
struct Bank {
    turn: [Lanes; 2],
    drive: [Lanes; 2],
    direct: Lanes,
    state: [Lanes; 2],
}

impl Bank {
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

/// Extremes of one block of oscillators.
pub(super) fn extremes(
    block: &[Oscillator],
    kappas: &[Reading],
    record: &[f64],
    end: usize,
    peaks: Peaks,
    look: &dyn Fn() -> Result<(), Error>,
) -> Result<Vec<Extremes>, Error> {
    let mut bank = Bank::new(block, kappas, record[0]);
    let mut ranges = [[[0.0; LANES]; 2]; 2];
    for (part, range) in [&record[..end], &record[end..]]
        .into_iter()
        .zip(&mut ranges)
    {
        for stretch in part.chunks(STRETCH) {
            look()?;
            Arch::new().dispatch(Steps {
                bank: &mut bank,
                stretch,
                range,
            });
        }
    }
    let mut result = Vec::with_capacity(block.len());
    for (k, (o, kappa)) in block.iter().zip(kappas).enumerate() {
        let [mut primary, mut recorded] = [0, 1].map(|p| [ranges[p][0][k], ranges[p][1][k]]);
        if peaks == Peaks::BetweenSamples {
            look()?;
            between(o, *kappa, record, end, &mut primary, &mut recorded);
        }
        let state = Complex64::new(bank.state[0][k], bank.state[1][k]);
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

/// A stretch of samples through a bank.
struct Steps<'a> {
    bank: &'a mut Bank,
    stretch: &'a [f64],
    range: &'a mut [Lanes; 2],
}

impl WithSimd for Steps<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Bank {
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
