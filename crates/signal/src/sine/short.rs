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
const LEFT: f64 = 0.3;

/// Covariance `[rr, ri, ii]` of a complex amplitude about the middle of the record with its degrees of freedom.
///
/// Bins m of the demodulated residuals that are those of positive frequencies; each is divided by the part of white
/// noise that the fit leaves there, 1 − cᴴ(ΦᵀΦ)⁻¹c/M, and their mean density σ² gives σ² (ΦᵀΦ)⁻¹.
pub(super) fn covariance(
    residue: &Residue,
    tables: &Tables,
    basis: &Basis,
    inverse: &Mat<f64>,
) -> ([f64; 3], f64) {
    let blocks = residue.series.len();
    let covered = (blocks * tables.block) as f64;
    let periods = tables.omega * covered / std::f64::consts::TAU;
    let most = ((blocks / 2) as isize - 1).clamp(1, BINS);
    let (mut power, mut left) = (0.0, 0.0);
    for m in (-most..=most).filter(|&m| m != 0 && m as f64 + periods > 0.5) {
        let turn = |b: usize| tables.circle[(m.rem_euclid(blocks as isize) as usize * b) % blocks];
        let kept = 1.0 - taken(basis, inverse, tables, blocks, turn) / covered;
        if kept > LEFT {
            let z: Complex64 = (0..blocks).map(|b| turn(b) * residue.series[b]).sum();
            power += z.norm_sqr();
            left += kept;
        }
    }
    let (c, s) = basis.fundamental();
    let n = tables.samples as f64;
    // Where nothing is left beside the drive, the residuals of the whole record have to do.
    let (density, dof) = if left > 1.0 {
        (power / (left * covered), 2.0 * left)
    } else {
        let dof = (n - basis.terms().len() as f64).max(1.0);
        (residue.power / dof, dof)
    };
    let shape = [inverse[(c, c)], -inverse[(c, s)], inverse[(s, s)]];
    (shape.map(|q| density * q), dof)
}

/// cᴴ(ΦᵀΦ)⁻¹c with c = Σ φ e^{−jωn} e^{−j2πmb/B}: what the fit takes from a bin of white noise.
fn taken(
    basis: &Basis,
    inverse: &Mat<f64>,
    tables: &Tables,
    blocks: usize,
    turn: impl Fn(usize) -> Complex64,
) -> f64 {
    let c: Vec<Complex64> = basis
        .terms()
        .iter()
        .map(|term| {
            (0..blocks)
                .map(|b| turn(b) * term.demodulated(tables, b))
                .sum()
        })
        .collect();
    let mut sum = 0.0;
    for (i, a) in c.iter().enumerate() {
        for (j, b) in c.iter().enumerate() {
            sum += (a.conj() * b).re * inverse[(i, j)];
        }
    }
    sum
}
