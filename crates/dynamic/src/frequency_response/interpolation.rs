//! K between the calibrated frequencies, never beyond them.

use super::FrequencyResponse;
use crate::monotone_cubic::{MonotoneCubic, interval};
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::Covariance;
use std::f64::consts::TAU;

/// K at one frequency.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Interpolated {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Elements, row by row.
    pub matrix: Vec<Complex64>,
    /// Covariance of their real and imaginary parts, in the order of the components.
    pub covariance: Covariance,
}

/// The response ready to be asked at many frequencies.
pub(crate) struct Interpolation<'a> {
    response: &'a FrequencyResponse,
    /// ln f of the points.
    knots: Vec<f64>,
    /// Real parts and imaginary parts of every element with the delay taken out; none for a single point.
    curves: Vec<[MonotoneCubic; 2]>,
    delay: f64,
}

/// A generator set to the last point may be read back with rounding.
const SLACK: f64 = 1e-9;

impl<'a> Interpolation<'a> {
    pub(crate) fn new(response: &'a FrequencyResponse) -> Self {
        let indices: Vec<usize> = (0..response.frequencies().len()).collect();
        Self::of(response, &indices, response.delay())
    }

    /// Through some of the points alone.
    fn of(response: &'a FrequencyResponse, indices: &[usize], delay: f64) -> Self {
        let points = response.series.points();
        let knots: Vec<f64> = indices.iter().map(|&i| points[i].at.ln()).collect();
        let elements = response.series.dimension() / 2;
        let curve = |element: usize| {
            let straight: Vec<Complex64> = indices
                .iter()
                .map(|&i| {
                    let c = points[i].estimate.components();
                    let k = Complex64::new(c[2 * element].value, c[2 * element + 1].value);
                    k * Complex64::cis(TAU * points[i].at * delay)
                })
                .collect();
            let part = |of: fn(&Complex64) -> f64| {
                MonotoneCubic::new(&knots, &straight.iter().map(of).collect::<Vec<_>>())
            };
            [part(|k| k.re), part(|k| k.im)]
        };
        let curves = if knots.len() < 2 {
            Vec::new()
        } else {
            (0..elements).map(curve).collect()
        };
        Self {
            response,
            knots,
            curves,
            delay,
        }
    }

    /// The elements within the range, at its ends beyond it.
    pub(crate) fn matrix(&self, frequency: f64) -> Vec<Complex64> {
        if self.curves.is_empty() {
            return self.response.matrix(0).unwrap_or_default();
        }
        let (k, t) = interval(&self.knots, frequency.ln());
        let back = Complex64::cis(-TAU * frequency * self.delay);
        self.curves
            .iter()
            .map(|[re, im]| back * Complex64::new(re.at(k, t), im.at(k, t)))
            .collect()
    }

    /// The points on either side of a frequency; the same one twice where there is but one.
    pub(crate) fn neighbours(&self, frequency: f64) -> (usize, usize) {
        if self.knots.len() < 2 {
            return (0, 0);
        }
        let (k, _) = interval(&self.knots, frequency.ln());
        (k, k + 1)
    }

    /// (1 − t) C_k + t C_{k+1}: what no correlation of the two neighbours can exceed.
    pub(crate) fn covariance(&self, frequency: f64) -> Result<Covariance, Error> {
        let points = self.response.series.points();
        if self.knots.len() < 2 {
            return Ok(points[0].estimate.covariance().clone());
        }
        let (k, t) = interval(&self.knots, frequency.ln());
        let part = |i: usize, w: f64| points[i].estimate.covariance().scaled(w);
        part(k, 1.0 - t)?.plus(&part(k + 1, t)?)
    }
}

impl FrequencyResponse {
    /// K between the points: monotone cubics over ln f of real and imaginary parts, after the common
    /// [`delay`](FrequencyResponse::delay) is taken out of the phases. Uncertainty as the weighted mean of the two
    /// neighbouring covariances: an interpolated value is never better known than its neighbours.
    ///
    /// **Accuracy** [`FrequencyResponse::interpolation_error`].
    ///
    /// **Source** `[FritschCarlson1980]`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] beyond the first and the last point.
    pub fn at(&self, frequency: f64) -> Result<Interpolated, Error> {
        let [first, last] = self.range();
        if !(first * (1.0 - SLACK)..=last * (1.0 + SLACK)).contains(&frequency) {
            return Err(Error::OutOfRange {
                name: "frequency for the calibration",
                value: frequency,
                min: first,
                max: last,
            });
        }
        let interpolation = Interpolation::new(self);
        Ok(Interpolated {
            frequency,
            matrix: interpolation.matrix(frequency),
            covariance: interpolation.covariance(frequency)?,
        })
    }

    /// Common delay of the main elements (output i, axis i) in seconds: minus the slope of their phase over the
    /// whole range, over 2π. Zero for a single frequency.
    ///
    /// Phases are followed from point to point, so neighbours must be less than half a turn apart.
    pub fn delay(&self) -> f64 {
        let points = self.series.points();
        let (rows, columns) = (self.outputs.len(), self.axes.len());
        let mut turned = 0.0;
        for pair in points.windows(2) {
            // Σ over the main elements: weighted by their size, so that a dead channel does not count.
            let step: Complex64 = (0..rows.min(columns))
                .map(|i| {
                    let at = |p: usize| {
                        let c = pair[p].estimate.components();
                        let e = 2 * (columns * i + i);
                        Complex64::new(c[e].value, c[e + 1].value)
                    };
                    at(1) * at(0).conj()
                })
                .sum();
            turned += step.arg();
        }
        let [first, last] = self.range();
        if last > first {
            -turned / (TAU * (last - first))
        } else {
            0.0
        }
    }

    /// Estimated relative error of the interpolation in every interval between two points: what the other points
    /// say of a point that is left out, ‖K̂ − K‖/‖K‖ (Frobenius norm), a quarter of it (half the distance, an error
    /// of second order; half of it in the first and the last interval), the larger of the two ends of the interval. `None` below three points, where nothing can be
    /// left out.
    pub fn interpolation_error(&self) -> Option<Vec<f64>> {
        let n = self.frequencies().len();
        if n < 3 {
            return None;
        }
        let delay = self.delay();
        let frequencies: Vec<f64> = self.frequencies().collect();
        let norm = |m: &[Complex64]| m.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
        let inner: Vec<f64> = (1..n - 1)
            .map(|left_out| {
                // Two neighbours on either side settle the cubic here.
                let near = left_out.saturating_sub(2)..(left_out + 3).min(n);
                let others: Vec<usize> = near.filter(|&i| i != left_out).collect();
                let guess = Interpolation::of(self, &others, delay).matrix(frequencies[left_out]);
                let truth = self.matrix(left_out).unwrap_or_default();
                let difference: Vec<Complex64> =
                    guess.iter().zip(&truth).map(|(a, b)| a - b).collect();
                let size = norm(&truth);
                if size > 0.0 {
                    0.25 * norm(&difference) / size
                } else {
                    0.0
                }
            })
            .collect();
        let at_end = |i: usize| {
            i.checked_sub(1)
                .and_then(|i| inner.get(i))
                .copied()
                .unwrap_or(0.0)
        };
        // A tangent at the first and the last point has a neighbour on one side only: of first order there.
        let outer = |i: usize| if i == 0 || i == n - 2 { 2.0 } else { 1.0 };
        Some(
            (0..n - 1)
                .map(|i| outer(i) * at_end(i).max(at_end(i + 1)))
                .collect(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_uncertainty::{
        Component, Effect, Estimate, EstimateSeries, Influence, SeriesPoint,
    };

    /// A resonance at 5 kHz with a delay of 20 µs.
    fn truth(f: f64) -> Complex64 {
        let x = f / 5000.0;
        Complex64::cis(-TAU * f * 20e-6) / Complex64::new(1.0 - x * x, 2.0 * 0.05 * x)
    }

    fn response(per_octave: f64) -> FrequencyResponse {
        let points = (0..)
            .map(|i| 20.0 * 2f64.powf(f64::from(i) / per_octave))
            .take_while(|f| *f <= 2600.0)
            .map(|at| {
                let k = truth(at);
                let influence = Influence::normal(
                    "reading",
                    "reading",
                    Effect::Joint {
                        covariance: Covariance::from_standard_uncertainties(&[0.01; 2]).unwrap(),
                    },
                );
                let components = vec![
                    Component::new("K.re", "V/(m/s²)", k.re),
                    Component::new("K.im", "V/(m/s²)", k.im),
                ];
                SeriesPoint {
                    at,
                    estimate: Estimate::new(components, vec![influence]).unwrap(),
                }
            })
            .collect();
        let one = vec!["z".to_owned()];
        FrequencyResponse::new(one.clone(), one, EstimateSeries::new(points, None).unwrap())
            .unwrap()
    }

    #[test]
    fn known_error_of_interpolation_is_stated_within_a_factor() {
        let response = response(3.0);
        let stated = response.interpolation_error().unwrap();
        let frequencies: Vec<f64> = response.frequencies().collect();
        let mut largest: f64 = 0.0;
        for (pair, stated) in frequencies.windows(2).zip(&stated) {
            for i in 1..20 {
                let f = pair[0] * (pair[1] / pair[0]).powf(f64::from(i) / 20.0);
                let k = response.at(f).unwrap();
                let error = (k.matrix[0] / truth(f) - 1.0).norm();
                largest = largest.max(error);
                // Below 100 Hz the error is that of the tangents at the first point, some 1e-6.
                assert!(error <= *stated + 2e-5, "{f} Hz: {error:e} > {stated:e}");
            }
        }
        // What is stated is of the size of the error, not a bound far above it.
        let most = stated.iter().fold(0.0, |m: f64, s| m.max(*s));
        assert!(most < 10.0 * largest, "{most} against {largest}");
        assert!((response.delay() - 20e-6).abs() < 15e-6);
        // At the points themselves nothing changes.
        let k = response.at(20.0).unwrap();
        assert!((k.matrix[0] - truth(20.0)).norm() < 1e-14);
        assert!((k.covariance.standard_uncertainty(0) - 0.01).abs() < 1e-15);
    }

    #[test]
    fn refuses_frequencies_beyond_the_calibration() {
        let response = response(3.0);
        for f in [19.9, 2600.0, f64::NAN, f64::INFINITY] {
            assert!(response.at(f).is_err());
        }
    }
}
