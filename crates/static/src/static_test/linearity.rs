//! Polynomial error model from readings at known accelerations and temperatures.

use super::StaticFit;
use super::departures::{Branches, Polynomial, branches};
use super::readings::{
    CommonError, PolynomialOrder, Solved, check, not_negative, positive, weighed_least_squares,
    weights,
};
use crate::findings;
use proofmass_core::Error;
use proofmass_uncertainty::{Component, Severity, f_quantile};
use serde::{Deserialize, Serialize};

/// ã = b₀ + k₁ (a + k₂ a² + k₃ a³) + k_T (T − T̄).
///
/// What is stated is the largest order, so that no choice stands between data and interval
/// (`coverage_linearity_whatever_the_order`); the evidence for each order (AICc, F, cross-validation) stands beside it. The
/// sensitivity is the slope at zero.
///
/// **Units** accelerations in m/s², temperatures in °C; k₂ in 1/(m/s²), k₃ in 1/(m/s²)².
/// **Source** `[IEEE1293]` (model equation), `[BurnhamAnderson2002]` ch. 2 (AICc).
#[doc(alias("K2", "polynomial error model", "nonlinearity"))]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Linearity {
    /// Relative standard uncertainty of all accelerations together (gravity, radius).
    pub scale_uncertainty: f64,
    /// Full scale, m/s²; the largest acceleration of the test unless told.
    pub full_scale: Option<f64>,
    /// Largest order, 1 to 3.
    pub largest_order: usize,
}

impl Default for Linearity {
    fn default() -> Self {
        Self {
            scale_uncertainty: 0.0,
            full_scale: None,
            largest_order: 3,
        }
    }
}

/// Names of the readings' inputs and what else moves them.
pub(super) struct Inputs<'a> {
    pub(crate) acceleration: &'a [f64],
    pub(crate) output: &'a [f64],
    pub(crate) temperature: Option<&'a [f64]>,
    /// Standard uncertainties of the outputs, of which only the ratios count.
    pub(crate) uncertainty: Option<&'a [f64]>,
    pub(crate) unit: &'a str,
    pub(crate) label: &'static str,
    /// Errors all readings share, as relative or absolute errors of the acceleration: ∂a/∂x of every reading.
    pub(crate) common: Vec<CommonError>,
}

impl Linearity {
    /// Fits bias, sensitivity, curvature and temperature coefficient.
    ///
    /// # Errors
    /// [`Error::TooFew`], [`Error::Unobservable`] for accelerations that do not spread, [`Error::OutOfRange`],
    /// [`Error::Length`], [`Error::NotFinite`].
    pub fn fit(
        &self,
        acceleration: &[f64],
        output: &[f64],
        temperature: Option<&[f64]>,
        unit: &str,
    ) -> Result<StaticFit, Error> {
        self.fit_weighed(acceleration, output, temperature, None, unit)
    }

    /// As [`Self::fit`] with standard uncertainties of the outputs, of which only the ratios count, as weights: the scatter is that
    /// of the residuals, for a reading of mean weight.
    ///
    /// # Errors
    /// Those of [`Self::fit`]; an uncertainty that is not positive.
    pub fn fit_weighed(
        &self,
        acceleration: &[f64],
        output: &[f64],
        temperature: Option<&[f64]>,
        uncertainty: Option<&[f64]>,
        unit: &str,
    ) -> Result<StaticFit, Error> {
        let u = not_negative("uncertainty of the accelerations", self.scale_uncertainty)?;
        self.evaluate(Inputs {
            acceleration,
            output,
            temperature,
            uncertainty,
            unit,
            label: "acceleration, m/s²",
            common: vec![CommonError {
                key: "acceleration.scale",
                description: "scale of the reference accelerations",
                unit: "1",
                value: 1.0,
                standard_uncertainty: u,
                effect: acceleration.to_vec(),
            }],
        })
    }

    /// The fit for any source of accelerations.
    pub(super) fn evaluate(&self, inputs: Inputs<'_>) -> Result<StaticFit, Error> {
        let (a, y) = (inputs.acceleration, inputs.output);
        check(a, y, "acceleration")?;
        if let Some(t) = inputs.temperature {
            check(t, y, "temperature")?;
        }
        let top = self.largest_order;
        if !(1..=3).contains(&top) {
            return Err(Error::OutOfRange {
                name: "largest order",
                value: top as f64,
                min: 1.0,
                max: 3.0,
            });
        }
        let n = y.len();
        let reach = a.iter().map(|v| v.abs()).fold(0.0, f64::max);
        positive("largest acceleration, m/s²", reach)?;
        let z: Vec<f64> = a.iter().map(|v| v / reach).collect();
        let mut extra = Vec::new();
        if let Some(t) = inputs.temperature {
            let mean = t.iter().sum::<f64>() / n as f64;
            extra.push(t.iter().map(|v| v - mean).collect::<Vec<f64>>());
        }
        let others = extra.len();
        let size = 1 + others + top;
        // Two readings more than parameters at the largest order: AICc has no meaning below.
        if n < size + 3 {
            return Err(Error::TooFew {
                name: "readings",
                needed: size + 3,
                got: n,
            });
        }
        let weight = weights(inputs.uncertainty, n)?;
        let columns = |order: usize| {
            let mut columns = vec![vec![1.0; n]];
            columns.extend(extra.clone());
            columns.extend((1..=order).map(|k| z.iter().map(|v| v.powi(k as i32)).collect()));
            columns
        };
        let runs: Vec<Solved> = (1..=top)
            .map(|order| {
                weighed_least_squares(
                    &columns(order),
                    y,
                    weight.clone(),
                    "curvature: the accelerations do not spread",
                )
            })
            .collect::<Result<_, _>>()?;
        let criterion = |order: usize| {
            let k = (1 + others + order + 1) as f64;
            let nf = n as f64;
            nf * (runs[order - 1].squares.max(1e-300) / nf).ln()
                + 2.0 * k
                + 2.0 * k * (k + 1.0) / (nf - k - 1.0)
        };
        let aicc: Vec<f64> = (1..=top).map(criterion).collect();
        let best = aicc.iter().copied().fold(f64::INFINITY, f64::min);
        let weights: Vec<f64> = aicc.iter().map(|v| (-0.5 * (v - best)).exp()).collect();
        let total: f64 = weights.iter().sum();
        let orders = (1..=top)
            .map(|order| {
                let run = &runs[order - 1];
                let f = (order > 1 && run.squares > 0.0).then(|| {
                    (runs[order - 2].squares - run.squares) / (run.squares / run.dof as f64)
                });
                let press: f64 = (0..n)
                    .map(|i| weight[i] * run.deleted(i, y[i]).0.powi(2))
                    .sum();
                PolynomialOrder {
                    order,
                    aicc: aicc[order - 1] - best,
                    weight: weights[order - 1] / total,
                    f,
                    f_limit: f_quantile(0.95, 1.0, run.dof as f64),
                    cross_validation: (press / n as f64).sqrt(),
                }
            })
            .collect();
        // The largest order states the result: an average over orders is short of its interval where a power is small.
        let largest = &runs[top - 1];
        let (x, fitted) = (&largest.parameters, &largest.fitted);
        let first = 1 + others;
        let k1 = x[first] / reach;
        if !(k1.abs() > 0.0) {
            return Err(Error::Unobservable {
                parameter: "sensitivity",
                condition: f64::INFINITY,
            });
        }
        // An error of the acceleration is one of the output by the local slope.
        let slope = |i: usize| {
            (1..=top)
                .map(|k| k as f64 * x[first + k - 1] * z[i].powi(k as i32 - 1))
                .sum::<f64>()
                / reach
        };
        let common: Vec<CommonError> = inputs
            .common
            .iter()
            .map(|error| CommonError {
                effect: (0..n).map(|i| slope(i) * error.effect[i]).collect(),
                ..error.clone()
            })
            .collect();
        let (scatter, dof) = largest.scatter(None)?;
        let raw = largest.raw(largest.influences(scatter, dof, &common)?)?;
        let unit = inputs.unit;
        let mut named = vec![
            Component::new("bias", unit, x[0]),
            Component::new("sensitivity", format!("{unit}/(m/s²)"), k1),
        ];
        let mut jacobian = vec![0.0; size * (2 + others + top - 1)];
        jacobian[0] = 1.0;
        jacobian[size + first] = 1.0 / reach;
        for k in 2..=top {
            let value = x[first + k - 1] / x[first] / reach.powi(k as i32 - 1);
            let row = named.len() * size;
            jacobian[row + first + k - 1] = 1.0 / x[first] / reach.powi(k as i32 - 1);
            jacobian[row + first] = -value / x[first];
            let exponent = ["", "²"][k - 2];
            named.push(Component::new(
                format!("curvature.{k}"),
                format!("1/(m/s²){exponent}"),
                value,
            ));
        }
        if others > 0 {
            let row = named.len() * size;
            jacobian[row + 1] = 1.0;
            named.push(Component::new("temperature", format!("{unit}/K"), x[1]));
        }
        let estimate = raw.propagate(named, &jacobian)?;
        let full_scale = positive("full scale, m/s²", self.full_scale.unwrap_or(reach))?;
        // Against the straight line, temperature taken out.
        let line = &runs[0];
        let departure = (0..n)
            .map(|i| (fitted[i] - line.fitted[i]).abs())
            .fold(0.0, f64::max);
        let departure = departure.max(
            (0..n)
                .map(|i| (y[i] - line.fitted[i]).abs())
                .fold(0.0, f64::max),
        );
        let readings: Vec<super::ReadingResidual> = a
            .iter()
            .zip(y)
            .zip(fitted)
            .map(|((input, output), model)| super::ReadingResidual {
                input: *input,
                output: *output,
                model: *model,
            })
            .collect();
        let mut findings = Vec::new();
        let powers = Polynomial {
            first,
            reach,
            solved: largest,
            scatter,
        };
        let departures = powers.departures(&z, k1.abs() * full_scale);
        let branches = branches(&columns(top), y, &weight, a, k1.abs() * full_scale);
        findings.extend(
            branches
                .filter(Branches::seen)
                .map(|b| findings::rising_and_falling(1e2 * b.difference, 1e2 * b.expanded)),
        );
        let share = departure / (k1.abs() * full_scale);
        if share > 1e-3 {
            let finding = findings::nonlinear_output(
                "it leaves the straight line by more than 0.1 % of full scale",
                &format!("{:.3} %", 1e2 * share),
                "the sensitivity is that of the line",
            );
            findings.push(finding.at(Severity::Note));
        }
        Ok(StaticFit {
            estimate,
            readings,
            input: inputs.label.to_owned(),
            unit: unit.to_owned(),
            scatter: Some(scatter),
            nonlinearity: Some(share),
            orders,
            departures,
            harmonics: Vec::new(),
            findings,
        })
    }
}
