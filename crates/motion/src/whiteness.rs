//! Are the innovations what the model promised: white, with unit variance?

use proofmass_core::Error;
use proofmass_uncertainty::chi_squared_chance;

/// Ljung–Box test of the autocorrelation and chi-square test of the size of normalised innovations.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Whiteness {
    /// Number of innovations.
    pub samples: usize,
    /// Number of lags m.
    pub lags: usize,
    /// n(n + 2) Σ ρ_k²/(n − k).
    pub ljung_box: f64,
    /// Probability of a value as large when the innovations are white.
    pub p_white: f64,
    /// Largest |ρ_k| and its lag.
    pub largest_correlation: (usize, f64),
    /// The same of the first five lags alone: what a model lacks shows there first, and signs do not cancel.
    pub short_correlation: (usize, f64),
    /// Probability of correlations as large at these lags when the innovations are white.
    pub p_short: f64,
    /// Mean of ν²/S; one when q and R are right.
    pub mean_square: f64,
    /// Two-sided probability of a mean square as far from one.
    pub p_size: f64,
}

/// Lags at which a model that lacks something shows it.
const SHORT: usize = 5;

impl Whiteness {
    /// Tests normalised innovations, over m = min(40, n/5) lags.
    ///
    /// Q ~ χ²(m) and n · mean square ~ χ²(n) for a matched model: the parameters were found from the same data,
    /// which takes one or two degrees of freedom off a number of 40 and is neglected.
    ///
    /// # Errors
    /// [`Error::TooFew`] below 20 innovations, [`Error::NotFinite`].
    ///
    /// **Source** `[LjungBox78]`.
    pub fn test(innovations: &[f64]) -> Result<Self, Error> {
        let n = innovations.len();
        if n < 20 {
            return Err(Error::TooFew {
                name: "innovations",
                needed: 20,
                got: n,
            });
        }
        if let Some(index) = innovations.iter().position(|v| !v.is_finite()) {
            return Err(Error::NotFinite {
                name: "innovations",
                index,
            });
        }
        let lags = (n / 5).min(40);
        let rho = autocorrelation(innovations, lags);
        let square: f64 = innovations.iter().map(|v| v * v).sum();
        // The statistic over so many lags, and the largest correlation among them.
        let ljung_box = |lags: usize| {
            let (mut q, mut largest) = (0.0, (0usize, 0.0f64));
            for (k, rho) in rho.iter().copied().enumerate().take(lags + 1).skip(1) {
                q += rho * rho / (n - k) as f64;
                if rho.abs() > largest.1.abs() {
                    largest = (k, rho);
                }
            }
            (q * (n as f64 * (n + 2) as f64), largest)
        };
        let (q, largest) = ljung_box(lags);
        let (five, short) = ljung_box(SHORT.min(lags));
        let upper = |x: f64, dof: usize| chi_squared_chance(x, dof as f64);
        let above = upper(square, n);
        Ok(Self {
            samples: n,
            lags,
            ljung_box: q,
            p_white: upper(q, lags),
            largest_correlation: largest,
            short_correlation: short,
            p_short: upper(five, lags.min(SHORT)),
            mean_square: square / n as f64,
            p_size: (2.0 * above.min(1.0 - above)).min(1.0),
        })
    }
}

/// ρ_k = Σ (ν_i − ν̄)(ν_{i+k} − ν̄)/Σ (ν_i − ν̄)² for k = 0…lags; one everywhere for a constant.
pub(crate) fn autocorrelation(innovations: &[f64], lags: usize) -> Vec<f64> {
    let n = innovations.len();
    let mean = innovations.iter().sum::<f64>() / n as f64;
    let at = |k: usize| -> f64 {
        let pairs = innovations[k..].iter().zip(innovations);
        pairs.map(|(a, b)| (a - mean) * (b - mean)).sum()
    };
    let power = at(0);
    (0..=lags.min(n.saturating_sub(1)))
        .map(|k| if power > 0.0 { at(k) / power } else { 1.0 })
        .collect()
}

/// ρ_k for every lag below the number of values, each over the pairs there are; `None` for a constant.
///
/// By the Fourier transform of the values and as many zeros (Wiener and Khinchin).
pub(crate) fn spectrum_correlation(values: &[f64]) -> Option<Vec<f64>> {
    let n = values.len();
    let size = (2 * n).next_power_of_two();
    let mean = values.iter().sum::<f64>() / n as f64;
    let centred: Vec<f64> = values.iter().map(|v| v - mean).collect();
    let sums = proofmass_signal::fourier::autocorrelation(&centred, size);
    let power = sums.first()? / n as f64;
    let rho = (0..n).map(|k| sums[k] / ((n - k) as f64 * power));
    (power > 0.0).then(|| rho.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn coverage_white_noise_is_refused_at_the_stated_rate() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(20);
        let (mut white, mut short, mut size) = (0, 0, 0);
        for _ in 0..1000 {
            let v: Vec<f64> = (0..500).map(|_| StandardNormal.sample(&mut rng)).collect();
            let test = Whiteness::test(&v).unwrap();
            white += usize::from(test.p_white < 0.05);
            short += usize::from(test.p_short < 0.05);
            size += usize::from(test.p_size < 0.05);
        }
        // Binomial(1000, 0.05): σ = 6.9; four σ either way. Ljung–Box is slightly liberal at n = 500.
        assert!((23..=90).contains(&white), "{white}");
        assert!((23..=78).contains(&short), "{short}");
        assert!((23..=78).contains(&size), "{size}");
    }

    #[test]
    fn law_coloured_noise_is_refused() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(21);
        let mut x = 0.0;
        let v: Vec<f64> = (0..1000)
            .map(|_| {
                let e: f64 = StandardNormal.sample(&mut rng);
                x = 0.4 * x + e;
                x
            })
            .collect();
        let test = Whiteness::test(&v).unwrap();
        assert!(test.p_white < 1e-10);
        assert_eq!(test.largest_correlation.0, 1);
        // 0.4, known to 1/√n.
        let (lag, rho) = test.short_correlation;
        assert!(lag == 1 && (rho - 0.4).abs() < 0.1 && test.p_short < 1e-10);
        assert!(Whiteness::test(&v[..10]).is_err());
    }
}
