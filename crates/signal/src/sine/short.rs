//! Noise of an amplitude where the record has few periods: the bins beside it are then those of the offset, of its own
//! mirror and of the harmonics, and a fit takes part of the noise away.

use super::basis::Basis;
use super::residue::Residue;
use super::tables::Tables;
use faer::Mat;
use num_complex::Complex64;

/// Periods from which the plain estimate of [`super::noise`] holds: its bins then reach neither offset nor mirror.
pub(super) const FEW: f64 = 13.0;
/// Bins above the drive that are looked at.
const BINS: isize = 12;
/// A bin of which the fit leaves less than this says little.
const LEAST: f64 = 0.3;

/// What the fit leaves of white noise in the bins beside the drive, which is the same in every channel.
pub(super) struct Left {
    /// Bins m and the part that is left there, 1 − cᴴ(ΦᵀΦ)⁻¹c/M.
    bins: Vec<(isize, f64)>,
    /// Samples in whole blocks.
    covered: f64,
}

impl Left {
    /// Bins of the demodulated residuals that are those of positive frequencies.
    pub(super) fn new(tables: &Tables, basis: &Basis, inverse: &Mat<f64>) -> Self {
        let blocks = tables.circle.len();
        let covered = (blocks * tables.block) as f64;
        let periods = tables.omega * covered / std::f64::consts::TAU;
        let most = ((blocks / 2) as isize - 1).clamp(1, BINS);
        let terms: Vec<Vec<Complex64>> = basis
            .terms()
            .iter()
            .map(|term| (0..blocks).map(|b| term.demodulated(tables, b)).collect())
            .collect();
        let bins = (-most..=most)
            .filter(|&m| m != 0 && m as f64 + periods > 0.5)
            .map(|m| {
                let c: Vec<Complex64> = terms.iter().map(|t| tables.bin(t, m)).collect();
                // cᴴ(ΦᵀΦ)⁻¹c with c = Σ φ e^{−jωn} e^{−j2πmb/B}: what the fit takes from a bin of white noise.
                let mut taken = 0.0;
                for (i, a) in c.iter().enumerate() {
                    for (j, b) in c.iter().enumerate() {
                        taken += (a.conj() * b).re * inverse[(i, j)];
                    }
                }
                (m, 1.0 - taken / covered)
            })
            .filter(|(_, left)| *left > LEAST)
            .collect();
        Self { bins, covered }
    }
}

/// Covariance `[rr, ri, ii]` of a complex amplitude about the middle of the record with its degrees of freedom.
///
/// Bins m of the demodulated residuals are divided by the part of white noise that the fit leaves there, and their mean
/// density σ² gives σ² (ΦᵀΦ)⁻¹.
pub(super) fn covariance(
    residue: &Residue,
    tables: &Tables,
    basis: &Basis,
    inverse: &Mat<f64>,
    left: &Left,
) -> ([f64; 3], f64) {
    let (mut power, mut kept) = (0.0, 0.0);
    for &(m, left) in &left.bins {
        power += tables.bin(&residue.series, m).norm_sqr();
        kept += left;
    }
    let (c, s) = basis.fundamental();
    let n = tables.samples as f64;
    // Where nothing is left beside the drive, the residuals of the whole record have to do.
    let (density, dof) = if kept > 1.0 {
        (power / (kept * left.covered), 2.0 * kept)
    } else {
        let dof = (n - basis.terms().len() as f64).max(1.0);
        (residue.power / dof, dof)
    };
    let shape = [inverse[(c, c)], -inverse[(c, s)], inverse[(s, s)]];
    (shape.map(|q| density * q), dof)
}
