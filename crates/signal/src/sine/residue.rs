//! From one reading of the samples to the fit and the residuals it leaves.

use super::Coefficients;
use super::basis::{Basis, Term};
use super::pass::{Ask, Look, look};
use super::tables::Tables;
use faer::Mat;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::algebra::{Cholesky, cholesky, product};

/// What is known of the residuals of a channel.
#[derive(Clone, Debug, Default)]
pub(crate) struct Residue {
    /// Σ r².
    pub(crate) power: f64,
    /// Σ τ r e^{−jhωn} per harmonic, when the frequency is sought.
    pub(crate) weighted: Vec<Complex64>,
    /// Σ r e^{−jωn} per full block.
    pub(crate) series: Vec<Complex64>,
}

/// Blocks that the first, provisional fit is made from.
const SKETCH: usize = 16;
/// Largest part of the power that may be taken away from it: four digits of the variance are left by rounding.
const LOSS: f64 = 1e10;
/// Readings of the samples at most: the second starts from the fit of the first.
const READINGS: usize = 3;

/// A provisional fit from a few blocks spread over the record; zero where they do not determine it.
pub(crate) fn sketch(
    tables: &Tables,
    channels: &[&[f64]],
    drift: bool,
    harmonics: usize,
) -> Vec<Coefficients> {
    let zero = vec![Coefficients::zero(harmonics); channels.len()];
    let all = tables.blocks();
    // Steps of the golden section: no period of the vibration is a multiple of all their distances.
    let golden = 0.618_033_988_749_895;
    let mut blocks: Vec<usize> = (0..SKETCH.min(all))
        .map(|i| ((i as f64 * golden).fract() * all as f64) as usize)
        .collect();
    blocks.sort_unstable();
    blocks.dedup();
    let basis = Basis::new(tables, drift, harmonics, blocks.iter().copied());
    let Ok(llt) = cholesky(&basis.gram()) else {
        return zero;
    };
    let ask = Ask {
        drift,
        weighted: false,
    };
    look(tables, channels, &zero, &blocks, ask)
        .iter()
        .map(|look| {
            let fit = basis.coefficients(&llt.solve(&basis.project(look)));
            if fit.is_finite() {
                fit
            } else {
                Coefficients::zero(harmonics)
            }
        })
        .collect()
}

/// The least-squares fit of every channel and its residuals, from one reading of the samples where the provisional
/// fit is near: with δ the step from it, Σ r² = Σ r₀² − δᵀ Φᵀ r₀, which loses digits only by the ratio of the two.
///
/// # Errors
/// [`Error::NotFinite`] for a channel with a NaN.
pub(crate) fn refine(
    tables: &Tables,
    basis: &Basis,
    llt: &Cholesky,
    channels: &[&[f64]],
    mut fitted: Vec<Coefficients>,
    ask: Ask,
) -> Result<(Vec<Coefficients>, Vec<Residue>), Error> {
    let blocks: Vec<usize> = (0..tables.blocks()).collect();
    let mut reading = 1;
    loop {
        let looks = look(tables, channels, &fitted, &blocks, ask);
        let mut residues = Vec::with_capacity(channels.len());
        let mut lost = false;
        for (index, (look, fit)) in looks.into_iter().zip(&mut fitted).enumerate() {
            let right = basis.project(&look);
            if (0..right.nrows()).any(|i| !right[(i, 0)].is_finite()) || !look.power.is_finite() {
                return Err(Error::NotFinite {
                    name: "channel",
                    index,
                });
            }
            let step = llt.solve(&right);
            let taken = product([step.transpose(), right.as_ref()])[(0, 0)];
            let power = look.power - taken;
            lost |= !(taken <= LOSS * power);
            let change = basis.coefficients(&step);
            residues.push(corrected(
                tables,
                basis,
                look,
                power.max(0.0),
                &step,
                &change,
            ));
            fit.add(&change);
        }
        // Without any noise every reading leaves rounding only, and there is nothing to lose.
        if !lost || reading == READINGS {
            return Ok((fitted, residues));
        }
        reading += 1;
    }
}

/// The residue after a step of the coefficients, from what was seen before it.
fn corrected(
    tables: &Tables,
    basis: &Basis,
    look: Look,
    power: f64,
    step: &Mat<f64>,
    change: &Coefficients,
) -> Residue {
    let Look {
        mut weighted,
        mut series,
        ..
    } = look;
    let j = Complex64::new(0.0, -1.0);
    for (h, w) in weighted.iter_mut().enumerate() {
        for (i, term) in basis.terms().iter().enumerate() {
            let part = |u| basis.inner(term, &Term::new(u, h + 1, 1));
            *w -= Complex64::new(part(Complex64::new(1.0, 0.0)), -part(j)) * step[(i, 0)];
        }
    }
    for (block, z) in series.iter_mut().enumerate() {
        // Σ (o + d τ) e^{−jωn}.
        let [zeroth, first, _] = tables.block_sums(1, block);
        *z -= zeroth.conj() * change.offset + first.conj() * change.drift;
        // Σ Re(u e^{jkωn}) e^{−jωn} = ½ (u E(k − 1) + ū Ē(k + 1)).
        for (i, u) in change.amplitudes.iter().enumerate() {
            let below = tables.block_sums(i, block)[0];
            let above = tables.block_sums(i + 2, block)[0].conj();
            *z -= (u * below + u.conj() * above) * 0.5;
        }
    }
    Residue {
        power,
        weighted,
        series,
    }
}
