//! The noise that matters to an amplitude is the noise beside its frequency.

use super::residue::Residue;
use super::tables::Tables;
use num_complex::Complex64;

/// Bins on each side of the drive that are averaged.
const BINS: usize = 10;

/// Covariance `[rr, ri, ii]` of a complex amplitude from the residuals in the bins beside it, with its degrees
/// of freedom.
///
/// The residuals are demodulated block by block; the series z_b they leave has mean zero by the fit, and its
/// periodogram at the bins m = 2 … M + 1 estimates the variance of Σ z_b, of which the error of the amplitude
/// is 2/N times. Real and imaginary parts are taken apart, so noise of amplitude and noise of phase may differ.
/// The first bin is left out: a fitted frequency takes part of it away.
///
/// cov(Re X, Im X) = (2/N)² · 1/M Σ_m Re\[Z(m) Z(m)ᴴ\], 2M degrees of freedom.
pub(crate) fn local(residue: &Residue, tables: &Tables) -> ([f64; 3], f64) {
    let blocks = residue.series.len();
    let bins = BINS.min((blocks / 2).saturating_sub(2)).max(1);
    let mut power = [0.0; 3];
    for m in 2..bins + 2 {
        let (mut zr, mut zi) = (Complex64::new(0.0, 0.0), Complex64::new(0.0, 0.0));
        for (b, z) in residue.series.iter().enumerate() {
            let e = tables.circle[(m * b) % blocks];
            zr += e * z.re;
            zi += e * z.im;
        }
        power[0] += zr.norm_sqr();
        power[1] += (zr * zi.conj()).re;
        power[2] += zi.norm_sqr();
    }
    let n = tables.samples as f64;
    // Blocks cover a little less than the record.
    let cover = n / (blocks * tables.block) as f64;
    let scale = 4.0 / (n * n) * cover / bins as f64;
    (power.map(|p| p * scale), 2.0 * bins as f64)
}
