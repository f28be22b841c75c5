//! Three sensors against each other: the noise of each from their differences.

use crate::phase::Phase;
use crate::record::NoiseRecord;
use proofmass_core::Error;

/// Groslambert covariance of two phases measured together: ⟨D_a D_b⟩/2τ² at factor m, the Allan variance of what they share.
///
/// With a = clock 1 − clock 3 and b = clock 2 − clock 3 it is the Allan variance of clock 3, with the noise of the two others and
/// of the counters averaged out. It may come out negative.
///
/// **Units** those of the phase over s, squared; `sample_rate` in Hz.
///
/// **Errors** [`Error::Length`] for phases of different length, [`Error::NotFinite`], [`Error::TooFew`] for fewer than 2m + 1
/// points.
///
/// **Source** `[Groslambert1981]`.
///
/// ```
/// let x: Vec<f64> = (0..50).map(|k| f64::from(k * k * 7 % 11)).collect();
/// // With itself it is the Allan variance.
/// let shared = proofmass_noise::groslambert_covariance(&x, &x, 4, 1.0).unwrap();
/// let direct = proofmass_noise::groslambert_covariance(&x, &x.iter().map(|v| v + 3.0).collect::<Vec<_>>(), 4, 1.0).unwrap();
/// assert!((shared - direct).abs() < 1e-12 && shared > 0.0);
/// ```
pub fn groslambert_covariance(
    a: &[f64],
    b: &[f64],
    m: usize,
    sample_rate: f64,
) -> Result<f64, Error> {
    if a.len() != b.len() {
        return Err(Error::Length {
            name: "phase",
            expected: a.len(),
            got: b.len(),
        });
    }
    crate::record::check_count("phase samples", a.len(), 2 * m.max(1) + 1)?;
    let (a, b) = (
        Phase::new(NoiseRecord::Phase(a), sample_rate)?.to_vec(),
        Phase::new(NoiseRecord::Phase(b), sample_rate)?.to_vec(),
    );
    let m = m.max(1);
    let terms = a.len() - 2 * m;
    let second = |x: &[f64], i: usize| x[i + 2 * m] - 2.0 * x[i + m] + x[i];
    let sum: f64 = (0..terms).map(|i| second(&a, i) * second(&b, i)).sum();
    Ok(crate::allan::scaled(sum, terms, m))
}

/// Variances of three independent clocks from those of their differences: σ₁² = ½(σ₁₂² + σ₁₃² − σ₂₃²) and so on.
///
/// A clock much steadier than the others may come out negative: then only a limit is known.
///
/// ```
/// let [a, b, c] = proofmass_noise::three_cornered_hat([5.0, 10.0, 13.0]);
/// assert_eq!([a, b, c], [1.0, 4.0, 9.0]);
/// ```
pub fn three_cornered_hat([v12, v13, v23]: [f64; 3]) -> [f64; 3] {
    [
        0.5 * (v12 + v13 - v23),
        0.5 * (v12 + v23 - v13),
        0.5 * (v13 + v23 - v12),
    ]
}
