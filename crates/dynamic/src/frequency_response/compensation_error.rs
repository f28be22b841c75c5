//! How far a compensated acceleration is from the true one, frequency by frequency.

use super::interpolation::Interpolation;
use super::{FrequencyResponse, complex_matrix};
use num_complex::Complex64;
use proofmass_core::Error;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// What a compensation over a band states about itself. Every number is relative to the acceleration.
///
/// The compensated vector at a frequency is (1 + E) a e^{−j2πfd}, with the stated delay d and a matrix E that nobody
/// knows exactly. ‖E‖ (spectral norm: the worst direction) is at most [`stated`](Self::stated) at any one frequency of
/// the band with 95 % probability; by Parseval's theorem this bounds the root mean square of the error of any signal
/// within the band, not its largest instantaneous value.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CompensationError {
    /// Lowest and highest frequency for which it holds, Hz.
    pub band: [f64; 2],
    /// Delay d of the compensated signal, s: after it is taken into account the following holds.
    pub delay: f64,
    /// Largest departure of the compensation from the inverse of the estimated K.
    pub departure: f64,
    /// The same when the delay is not taken into account.
    pub departure_with_delay: f64,
    /// Largest expanded uncertainty from that of K, 95 %.
    pub uncertainty: f64,
    /// Largest estimated error of K between its points; `None` when it has too few points to tell.
    pub interpolation: Option<f64>,
    /// Largest sum of the three at one frequency.
    pub stated: f64,
    /// The same when the delay is not taken into account.
    pub stated_with_delay: f64,
}

/// Probability of the expanded uncertainty.
const PROBABILITY: f64 = 0.95;
/// Coverage factor of a normal distribution for it.
const NORMAL: f64 = 1.959_963_984_540_054;

/// Points of the response, ready to judge compensations H(f): axes × outputs.
pub(super) struct Judge<'a> {
    response: &'a FrequencyResponse,
    pub(super) interpolation: Interpolation<'a>,
    errors: Option<Vec<f64>>,
    /// Largest coverage factor of the elements that carry weight, per point.
    coverage: Vec<f64>,
}

impl<'a> Judge<'a> {
    /// # Errors
    /// [`Error::Length`] unless there are as many outputs as axes, one to three.
    pub(super) fn new(response: &'a FrequencyResponse) -> Result<Self, Error> {
        let (outputs, axes) = (response.outputs().len(), response.axes().len());
        if outputs != axes || axes > 3 {
            return Err(Error::Length {
                name: "outputs of a response that is to be inverted",
                expected: axes.min(3),
                got: outputs,
            });
        }
        let coverage = response.series().points().iter().map(|p| {
            let quantities = p.estimate.quantities();
            let largest = quantities
                .iter()
                .map(|q| q.standard_uncertainty)
                .fold(0.0, f64::max);
            quantities
                .iter()
                .filter(|q| q.standard_uncertainty > 0.03 * largest)
                .map(|q| q.coverage_factor(PROBABILITY))
                .fold(NORMAL, f64::max)
        });
        Ok(Self {
            interpolation: Interpolation::new(response),
            errors: response.interpolation_error(),
            coverage: coverage.collect(),
            response,
        })
    }

    pub(super) fn axes(&self) -> usize {
        self.response.axes().len()
    }

    pub(super) fn knows_interpolation(&self) -> bool {
        self.errors.is_some()
    }

    /// ‖H K e^{j2πfd} − 1‖.
    fn departure(&self, f: f64, h: &[Complex64], delay: f64) -> f64 {
        let n = self.axes();
        let k = self.interpolation.matrix(f);
        let turn = Complex64::cis(std::f64::consts::TAU * f * delay);
        let mut e: Vec<Complex64> = complex_matrix::product(h, &k, n);
        for (i, v) in e.iter_mut().enumerate() {
            *v = *v * turn - if i % (n + 1) == 0 { 1.0 } else { 0.0 };
        }
        complex_matrix::spectral_norm(&e, n)
    }

    /// How well it is known: the 95 % quantile of ‖H δK‖ (Frobenius norm, which no direction exceeds), and the error of
    /// the interpolation.
    ///
    /// ‖H δK‖² is a sum of χ² with the eigenvalues λ of its covariance as weights, taken as (Σλ²/Σλ) χ²_ν with
    /// ν = (Σλ)²/Σλ².
    ///
    /// **Source** `[Satterthwaite1946]`.
    fn doubt(&self, f: f64, h: &[Complex64]) -> Result<(f64, f64), Error> {
        let n = self.axes();
        let reals = 2 * n * n;
        let mut jacobian = vec![0.0; reals * reals];
        for (i, j, o) in
            (0..n).flat_map(|i| (0..n).flat_map(move |j| (0..n).map(move |o| (i, j, o))))
        {
            let (row, column) = (2 * (i * n + j), 2 * (o * n + j));
            let h = h[i * n + o];
            jacobian[row * reals + column] = h.re;
            jacobian[row * reals + column + 1] = -h.im;
            jacobian[(row + 1) * reals + column] = h.im;
            jacobian[(row + 1) * reals + column + 1] = h.re;
        }
        let c = self.interpolation.covariance(f)?.propagate(&jacobian)?;
        let trace: f64 = (0..reals).map(|i| c[(i, i)]).sum();
        let squares: f64 = c.elements().iter().map(|v| v * v).sum();
        let quantile = match ChiSquared::new(trace * trace / squares) {
            Ok(chi) => squares / trace * chi.inverse_cdf(PROBABILITY),
            // Nothing is uncertain.
            Err(_) => 0.0,
        };
        let (first, second) = self.interpolation.neighbours(f);
        let coverage = self.coverage[first].max(self.coverage[second]);
        let between = self.errors.as_ref().and_then(|e| e.get(first));
        Ok((
            coverage / NORMAL * quantile.sqrt(),
            between.copied().unwrap_or(0.0),
        ))
    }

    /// (λ)², a hundredth of the mean variance of the elements: the larger one of the two neighbours.
    pub(super) fn regularisation(&self, f: f64) -> f64 {
        let points = self.response.series().points();
        let mean = |i: usize| {
            let c = points[i].estimate.covariance();
            (0..c.dimension()).map(|i| c[(i, i)]).sum::<f64>() / c.dimension() as f64
        };
        let (first, second) = self.interpolation.neighbours(f);
        0.01 * mean(first).max(mean(second))
    }

    /// The largest over the frequencies, for the H of each.
    pub(super) fn over(
        &self,
        band: [f64; 2],
        delay: f64,
        frequencies: &[f64],
        h: impl Fn(usize) -> Vec<Complex64>,
    ) -> Result<CompensationError, Error> {
        let mut error = CompensationError {
            band,
            delay,
            departure: 0.0,
            departure_with_delay: 0.0,
            uncertainty: 0.0,
            interpolation: self.knows_interpolation().then_some(0.0),
            stated: 0.0,
            stated_with_delay: 0.0,
        };
        let mut doubt = (0.0, 0.0);
        for (index, &f) in frequencies.iter().enumerate() {
            let h = h(index);
            let departure = self.departure(f, &h, delay);
            error.departure = error.departure.max(departure);
            let raw = self.departure(f, &h, 0.0);
            error.departure_with_delay = error.departure_with_delay.max(raw);
            // The uncertainty changes slowly: of many frequencies some five hundred say enough.
            if index % (1 + frequencies.len() / 500) == 0 {
                doubt = self.doubt(f, &h)?;
                error.uncertainty = error.uncertainty.max(doubt.0);
                error.interpolation = error.interpolation.map(|e| e.max(doubt.1));
            }
            let known = doubt.0 + doubt.1;
            error.stated = error.stated.max(departure + known);
            error.stated_with_delay = error.stated_with_delay.max(raw + known);
        }
        Ok(error)
    }
}
