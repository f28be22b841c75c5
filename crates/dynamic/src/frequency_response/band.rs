//! One real matrix in place of K over a band.

use super::FrequencyResponse;
use super::compensation_error::{CompensationError, Judge};
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_core::numeric::golden_section;
use std::f64::consts::TAU;

/// A constant real matrix M and a delay τ that stand for K over a band: K(f) ≈ M e^{−j2πfτ}.
///
/// M and τ minimise ∫ ‖K e^{j2πfτ} − M‖² d ln f: M is the mean over the band of the real part, each octave weighing
/// alike, after the delay. The compensated acceleration M⁻¹ õ is that of τ earlier.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BandMatrix {
    /// M, outputs × axes, row by row, in the unit of K.
    pub matrix: Vec<f64>,
    /// M⁻¹, axes × outputs, row by row.
    pub inverse: Vec<f64>,
    /// What the compensation with M⁻¹ states about itself.
    pub error: CompensationError,
}

impl BandMatrix {
    /// M⁻¹ in one line, each number with all its digits, rows apart by semicolons.
    pub fn inverse_line(&self) -> String {
        let outputs = (self.inverse.len() as f64).sqrt().round().max(1.0) as usize;
        let row = |row: &[f64]| -> String {
            let numbers: Vec<String> = row.iter().map(|v| format!("{v:e}")).collect();
            numbers.join(" ")
        };
        let rows: Vec<String> = self.inverse.chunks(outputs).map(row).collect();
        format!("[{}]", rows.join("; "))
    }

    /// Accelerations of samples, M⁻¹ õ.
    ///
    /// **Shapes** one slice per output, of one length; one column per axis.
    pub fn apply_columns(&self, outputs: &[&[f64]]) -> Vec<Vec<f64>> {
        self.inverse
            .chunks_exact(outputs.len())
            .map(|m| {
                let value = |row: usize| m.iter().zip(outputs).map(|(m, o)| m * o[row]).sum();
                (0..outputs[0].len()).map(value).collect()
            })
            .collect()
    }
}

/// Frequencies at which a band is looked at: the cubic between two points has one inflection, so that 12 of them per
/// interval and 200 in all miss no extremum by more than a thousandth of its size.
fn grid(response: &FrequencyResponse, [low, high]: [f64; 2]) -> Vec<f64> {
    if low == high {
        return vec![low];
    }
    let inside = response
        .frequencies()
        .filter(|f| (low..=high).contains(f))
        .count();
    let n = (12 * (inside + 1)).max(200);
    let step = (high / low).ln() / n as f64;
    (0..=n)
        .map(|i| (low * (step * i as f64).exp()).clamp(low, high))
        .collect()
}

impl FrequencyResponse {
    /// The constant real matrix of a band, with its stated error.
    ///
    /// **Accuracy** `coverage_of_the_stated_error_of_a_band`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a band that is reversed or beyond the calibrated range, [`Error::Length`] unless
    /// there are as many outputs as axes (one to three), [`Error::Singular`] for a matrix without inverse.
    pub fn band_matrix(&self, band: [f64; 2]) -> Result<BandMatrix, Error> {
        self.check_band(band)?;
        let judge = Judge::new(self)?;
        let frequencies = grid(self, band);
        let k: Vec<Vec<Complex64>> = frequencies
            .iter()
            .map(|&f| judge.interpolation.matrix(f))
            .collect();
        let elements = k[0].len();
        // Trapezoidal in ln f: the ends of an even grid weigh half.
        let weight = |i: usize| {
            if k.len() > 1 && (i == 0 || i == k.len() - 1) {
                0.5
            } else {
                1.0
            }
        };
        let total: f64 = (0..k.len()).map(weight).sum();
        let mean = |delay: f64| -> Vec<f64> {
            let mut sum = vec![0.0; elements];
            for (i, (k, f)) in k.iter().zip(&frequencies).enumerate() {
                let turn = Complex64::cis(TAU * f * delay) * (weight(i) / total);
                for (sum, k) in sum.iter_mut().zip(k) {
                    *sum += (k * turn).re;
                }
            }
            sum
        };
        // What M explains of Σ‖K‖²; the rest is its residual.
        let explained = |delay: f64| mean(delay).iter().map(|m| m * m).sum::<f64>();
        let delay = if band[0] == band[1] {
            0.0
        } else {
            // A quarter of a turn at the highest frequency on either side of the slope of the phase.
            let about = self.delay();
            let step = 0.25 / band[1] / 50.0;
            let coarse = (-50..=50)
                .map(|i| about + f64::from(i) * step)
                .max_by(|a, b| explained(*a).total_cmp(&explained(*b)))
                .unwrap_or(about);
            {
                let lower = |a: f64, b: f64| Ok::<_, Error>(!(explained(a) < explained(b)));
                golden_section([coarse - step, coarse + step], |k, _| k < 44, lower)?
            }
        };
        let matrix = mean(delay);
        let complex: Vec<Complex64> = matrix.iter().map(|&m| m.into()).collect();
        let axes = judge.axes();
        let one = (0..axes * axes)
            .map(|i| Complex64::from(f64::from(u8::from(i % (axes + 1) == 0))))
            .collect();
        let inverse = super::complex_matrix::solve(complex, one, axes).ok_or(Error::Singular {
            name: "sensitivity over the band",
            condition: f64::INFINITY,
        })?;
        let error = judge.over(band, delay, &frequencies, |_| inverse.clone())?;
        Ok(BandMatrix {
            matrix,
            inverse: inverse.iter().map(|v| v.re).collect(),
            error,
        })
    }

    pub(super) fn check_band(&self, [low, high]: [f64; 2]) -> Result<(), Error> {
        let [first, last] = self.range();
        for value in [low, high] {
            if !(first..=last).contains(&value) {
                return Err(Error::OutOfRange {
                    name: "band in Hz",
                    value,
                    min: first,
                    max: last,
                });
            }
        }
        if low > high {
            return Err(Error::OutOfRange {
                name: "lower end of the band in Hz",
                value: low,
                min: first,
                max: high,
            });
        }
        Ok(())
    }
}

impl BandMatrix {
    /// Compensation: M⁻¹ õ of one sample.
    pub fn apply(&self, output: &[f64]) -> Vec<f64> {
        self.inverse
            .chunks_exact(output.len().max(1))
            .map(|row| row.iter().zip(output).map(|(m, o)| m * o).sum())
            .collect()
    }
}
