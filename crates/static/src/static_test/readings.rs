//! Readings at known inputs, a model linear in its parameters, and what every reading has in common.

use proofmass_core::Error;
pub(super) use proofmass_core::check::{not_negative, positive};
use proofmass_uncertainty::adjustment::{cholesky, solve};
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding, Influence,
};
use serde::Serialize;

/// An error that all readings share, so that no residual shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct CommonError {
    /// Stable name.
    pub key: &'static str,
    /// What it is.
    pub description: &'static str,
    /// Unit of the input.
    pub unit: &'static str,
    /// Estimate of the input.
    pub value: f64,
    /// Standard uncertainty of the input.
    pub standard_uncertainty: f64,
    /// ∂(reading)/∂(input) of every reading.
    pub effect: Vec<f64>,
}

/// One reading against the model.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ReadingResidual {
    /// Input: an angle in rad, an acceleration in m/s², a time in s.
    pub input: f64,
    /// Output.
    pub output: f64,
    /// What the model gives.
    pub model: f64,
}

impl ReadingResidual {
    /// Output less model.
    pub fn residual(&self) -> f64 {
        self.output - self.model
    }
}

/// One order that was compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PolynomialOrder {
    /// Order.
    pub order: usize,
    /// Akaike's criterion, corrected for the number of readings, less that of the best order.
    pub aicc: f64,
    /// Weight by AICc among the orders.
    pub weight: f64,
    /// F of the last power; `None` for the first order.
    pub f: Option<f64>,
    /// What one in twenty exceeds without such a power.
    pub f_limit: f64,
    /// RMS error of each reading predicted from all others, output unit.
    pub cross_validation: f64,
}

/// What a static test found.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StaticFit {
    /// The quantities with one covariance.
    pub estimate: Estimate,
    /// Every reading against the model.
    pub readings: Vec<ReadingResidual>,
    /// What the input is, with its unit.
    pub input: String,
    /// Unit of the outputs.
    pub unit: String,
    /// Standard deviation of one reading about the model, output unit, where more readings than parameters show it.
    pub scatter: Option<f64>,
    /// Largest departure from the straight line of the test, as a share of the full scale.
    pub nonlinearity: Option<f64>,
    /// Orders that were compared, where the test has a polynomial.
    pub orders: Vec<PolynomialOrder>,
    /// Departures of the fitted curve from straight lines, by their definitions, where the test has a polynomial.
    pub departures: Vec<super::Departure>,
    /// Harmonics of the residuals over the angle, where they were tested.
    pub harmonics: Vec<super::Harmonic>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

/// Least squares with the scatter of the residuals: Student's t is exact for it. Weights are of mean 1, so that the scatter is that
/// of a reading of mean weight.
pub(super) struct Solved {
    pub(crate) parameters: Vec<f64>,
    /// (XᵀWX)⁻¹.
    pub(crate) inverse: Vec<f64>,
    /// (XᵀWX)⁻¹ XᵀW, p × n.
    pub(crate) gain: Vec<f64>,
    pub(crate) fitted: Vec<f64>,
    /// Diagonal of X (XᵀWX)⁻¹ XᵀW.
    pub(crate) leverage: Vec<f64>,
    /// Weight of each reading.
    pub(crate) weights: Vec<f64>,
    /// Σ w r².
    pub(crate) squares: f64,
    pub(crate) dof: usize,
}

/// Weights of mean 1 from standard uncertainties of the readings, of which only the ratios count; 1 for each without.
pub(super) fn weights(uncertainty: Option<&[f64]>, n: usize) -> Result<Vec<f64>, Error> {
    let Some(u) = uncertainty else {
        return Ok(vec![1.0; n]);
    };
    if u.len() != n {
        return Err(Error::Length {
            name: "standard uncertainties of the readings",
            expected: n,
            got: u.len(),
        });
    }
    for value in u {
        positive("standard uncertainty of a reading", *value)?;
    }
    let raw: Vec<f64> = u
        .iter()
        .map(|v| (v / u[0].max(f64::MIN_POSITIVE)).powi(-2))
        .collect();
    let mean = raw.iter().sum::<f64>() / n.max(1) as f64;
    Ok(raw.iter().map(|w| w / mean).collect())
}

/// `columns`: p columns of n values, of comparable size.
pub(super) fn least_squares(
    columns: &[Vec<f64>],
    y: &[f64],
    name: &'static str,
) -> Result<Solved, Error> {
    weighed_least_squares(columns, y, vec![1.0; y.len()], name)
}

/// As [`least_squares`], with a weight of each reading.
pub(super) fn weighed_least_squares(
    columns: &[Vec<f64>],
    y: &[f64],
    weights: Vec<f64>,
    name: &'static str,
) -> Result<Solved, Error> {
    let (n, p) = (y.len(), columns.len());
    if n < p {
        return Err(Error::TooFew {
            name: "readings",
            needed: p,
            got: n,
        });
    }
    proofmass_core::check::finite("output", y)?;
    // Columns of unit length, so that the limit of the factorisation is one of direction.
    let length: Vec<f64> = columns
        .iter()
        .map(|c| {
            c.iter()
                .zip(&weights)
                .map(|(v, w)| w * v * v)
                .sum::<f64>()
                .sqrt()
        })
        .collect();
    let undetermined = Error::Unobservable {
        parameter: name,
        condition: f64::INFINITY,
    };
    if length.iter().any(|l| !(*l > 0.0 && l.is_finite())) {
        return Err(undetermined);
    }
    let x: Vec<Vec<f64>> = columns
        .iter()
        .zip(&length)
        .map(|(c, l)| {
            c.iter()
                .zip(&weights)
                .map(|(v, w)| w.sqrt() * v / l)
                .collect()
        })
        .collect();
    let mut normal = vec![0.0; p * p];
    for a in 0..p {
        for b in 0..=a {
            normal[a * p + b] = x[a].iter().zip(&x[b]).map(|(u, v)| u * v).sum();
        }
    }
    cholesky(&mut normal, p).ok_or(undetermined)?;
    // A pivot below 10⁻⁵ of its column: that direction is seen in less than a hundred-thousandth of the signal.
    if (0..p).any(|a| normal[a * p + a] < 1e-5) {
        return Err(undetermined);
    }
    let mut inverse = vec![0.0; p * p];
    for a in 0..p {
        let mut unit = vec![0.0; p];
        unit[a] = 1.0;
        solve(&normal, &mut unit);
        for b in 0..p {
            inverse[a * p + b] = unit[b] / (length[a] * length[b]);
        }
    }
    let mut gain = vec![0.0; p * n];
    for a in 0..p {
        for i in 0..n {
            let row: f64 = (0..p).map(|b| inverse[a * p + b] * columns[b][i]).sum();
            gain[a * n + i] = weights[i] * row;
        }
    }
    // About the first reading: counts on a large pedestal lose no digits. The first column is the constant.
    let pedestal = y[0];
    let mut parameters: Vec<f64> = (0..p)
        .map(|a| (0..n).map(|i| gain[a * n + i] * (y[i] - pedestal)).sum())
        .collect();
    let deviations: Vec<f64> = (0..n)
        .map(|i| (0..p).map(|a| columns[a][i] * parameters[a]).sum())
        .collect();
    let squares = (0..n)
        .map(|i| weights[i] * (y[i] - pedestal - deviations[i]).powi(2))
        .sum();
    parameters[0] += pedestal;
    let leverage = (0..n)
        .map(|i| (0..p).map(|a| columns[a][i] * gain[a * n + i]).sum())
        .collect();
    Ok(Solved {
        parameters,
        inverse,
        gain,
        fitted: deviations.iter().map(|d| d + pedestal).collect(),
        leverage,
        weights,
        squares,
        dof: n - p,
    })
}

impl Solved {
    /// By how much a reading is off the fit of all others, and what its deletion takes off Σ w r².
    pub fn deleted(&self, i: usize, y: f64) -> (f64, f64) {
        let rest = (1.0 - self.leverage[i]).max(1e-9);
        let residual = y - self.fitted[i];
        (
            residual / rest,
            self.weights[i] * residual * residual / rest,
        )
    }

    /// Standard deviation of one reading: from the residuals, or as given where there are none to spare.
    pub fn scatter(&self, given: Option<f64>) -> Result<(f64, DegreesOfFreedom), Error> {
        match (DegreesOfFreedom::new(self.dof as f64), given) {
            (Some(nu), _) => Ok(((self.squares / self.dof as f64).sqrt(), nu)),
            (None, Some(u)) => Ok((u, DegreesOfFreedom::INFINITE)),
            (None, None) => Err(Error::TooFew {
                name: "readings (or give the standard uncertainty of one)",
                needed: self.parameters.len() + 1,
                got: self.fitted.len(),
            }),
        }
    }

    /// Influences of the parameters: what the readings scatter, and what they share.
    pub fn influences(
        &self,
        scatter: f64,
        dof: DegreesOfFreedom,
        common: &[CommonError],
    ) -> Result<Vec<Influence>, Error> {
        let p = self.parameters.len();
        let n = self.fitted.len();
        let rows: Vec<f64> = self.inverse.iter().map(|v| v * scatter * scatter).collect();
        let type_a = !dof.is_infinite();
        let mut influences = vec![Influence {
            key: "readings".to_owned(),
            description: "scatter of the readings about the model".to_owned(),
            evaluation: if type_a { Evaluation::A } else { Evaluation::B },
            distribution: if type_a { "t" } else { "normal" }.to_owned(),
            dof,
            effect: Effect::Joint {
                covariance: Covariance::try_from_rows(p, &rows)?,
            },
        }];
        for error in common.iter().filter(|e| e.standard_uncertainty > 0.0) {
            if error.effect.len() != n {
                return Err(Error::Length {
                    name: error.key,
                    expected: n,
                    got: error.effect.len(),
                });
            }
            // y is read, its input believed: where the input is larger, the parameters are the smaller.
            let sensitivity = (0..p)
                .map(|a| {
                    -(0..n)
                        .map(|i| self.gain[a * n + i] * error.effect[i])
                        .sum::<f64>()
                })
                .collect();
            influences.push(Influence::normal(
                error.key,
                error.description,
                Effect::Scalar {
                    value: error.value,
                    unit: error.unit.to_owned(),
                    standard_uncertainty: error.standard_uncertainty,
                    sensitivity,
                },
            ));
        }
        Ok(influences)
    }

    /// Components for parameters that are not shown by themselves.
    pub fn raw(&self, influences: Vec<Influence>) -> Result<Estimate, Error> {
        let components = self
            .parameters
            .iter()
            .enumerate()
            .map(|(i, v)| Component::new(format!("parameter.{i}"), "", *v));
        Estimate::new(components.collect(), influences)
    }

    /// Readings against the model.
    pub fn readings(&self, input: &[f64], y: &[f64]) -> Vec<ReadingResidual> {
        input
            .iter()
            .zip(y)
            .zip(&self.fitted)
            .map(|((input, output), model)| ReadingResidual {
                input: *input,
                output: *output,
                model: *model,
            })
            .collect()
    }
}

/// An angle of the fixture that is zero but for its uncertainty `u`, rad, and what it does to the parameters in second order.
pub(super) fn fixture_angle(
    key: &str,
    description: &str,
    u: f64,
    sensitivity: Vec<f64>,
) -> Option<Influence> {
    (u > 0.0).then(|| Influence::normal(key, description, Effect::of_zero("rad", u, sensitivity)))
}

/// Unit of a sensitivity of outputs in this unit.
pub(super) fn per_acceleration(unit: &str) -> String {
    match unit {
        "m/s²" => "1".to_owned(),
        unit => format!("{unit}/(m/s²)"),
    }
}

/// Equal lengths and finite inputs.
pub(super) fn check(input: &[f64], output: &[f64], name: &'static str) -> Result<(), Error> {
    proofmass_core::check::column(name, input, output.len())
}
