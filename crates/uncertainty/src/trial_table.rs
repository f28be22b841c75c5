//! Trials of a stated result, kept so that whoever reads it again draws from the distribution that was stated.

use crate::{Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Influence};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// Rows of trials, one column per quantity of the result and per cause behind it.
///
/// Location and spread of the columns are what was stated; the rows say the shape, and what depends on what.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TrialTable {
    /// The columns, of equal length.
    pub columns: Vec<TrialColumn>,
}

/// One quantity of a [`TrialTable`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TrialColumn {
    /// Name of the quantity, or of the cause.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Stated value.
    pub value: f64,
    /// The stated u, or U where a distribution has no u.
    pub scale: f64,
    /// Whether it is a cause behind the result, not a quantity of it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub cause: bool,
    /// Degrees of freedom of a cause.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dof: Option<DegreesOfFreedom>,
    /// Whether the quantity is stated otherwise than by the law of propagation.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub by_trials: bool,
    /// Whether the law of propagation states it, but so far from the trials that others had better draw these.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub loose: bool,
    /// The value in each trial.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub trials: Vec<f64>,
}

impl TrialColumn {
    /// Whether a reader draws these trials rather than the causes behind them.
    pub(crate) fn drawn(&self) -> bool {
        self.by_trials || self.loose
    }

    /// The column of these values: as they are, or brought to the stated value and u.
    pub(crate) fn of(mut self, values: Vec<f64>, as_they_are: bool) -> Self {
        self.trials = values;
        if as_they_are || !(self.scale > 0.0) {
            return self;
        }
        let n = self.trials.len() as f64;
        let mean = self.trials.iter().sum::<f64>() / n;
        let squares: f64 = self.trials.iter().map(|v| (v - mean).powi(2)).sum();
        let factor = self.scale / (squares / (n - 1.0)).sqrt();
        if factor.is_finite() {
            let (value, scale) = (self.value, self.scale);
            for v in &mut self.trials {
                // No more digits than a file needs.
                *v = value + (1e7 * (*v - mean) * factor / scale).round() * 1e-7 * scale;
            }
        }
        self
    }

    /// The trials counted from the value in standard uncertainties.
    fn counted(&self) -> Vec<f64> {
        let per = if self.scale > 0.0 {
            1.0 / self.scale
        } else {
            0.0
        };
        let at = |v: &f64| (v - self.value) * per;
        self.trials.iter().map(at).collect()
    }
}

impl TrialTable {
    /// Trials in it.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |c| c.trials.len())
    }

    /// A quantity of the result.
    pub fn quantity(&self, name: &str) -> Option<&TrialColumn> {
        self.columns.iter().find(|c| !c.cause && c.name == name)
    }

    /// The estimate of what is stated: the causes of the quantities that are stated by y ± U, as `linear` has them, and for
    /// the others what depends on those causes linearly, the rest as one cause.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub(crate) fn estimate(&self, linear: Option<&Estimate>) -> Result<Estimate, Error> {
        let quantities: Vec<&TrialColumn> = self.columns.iter().filter(|c| !c.cause).collect();
        let n = quantities.len();
        let components: Vec<Component> = quantities
            .iter()
            .map(|c| Component::new(&c.name, &c.unit, c.value))
            .collect();
        let place = |i: usize| linear.and_then(|l| l.index_of(&quantities[i].name));
        // Places in `linear`, absent for what is stated by its trials.
        let kept: Vec<Option<usize>> = (0..n)
            .map(|i| place(i).filter(|_| !quantities[i].by_trials))
            .collect();
        let mut rest: Vec<Vec<f64>> = quantities.iter().map(|c| c.counted()).collect();
        let causes: Vec<&Influence> = linear.into_iter().flat_map(Estimate::influences).collect();
        let mut slopes = vec![vec![0.0; n]; causes.len()];
        let mut explained = vec![0.0; n];
        for i in (0..n).filter(|i| kept[*i].is_none()) {
            let own = &quantities[i].counted();
            for (slopes, cause) in slopes.iter_mut().zip(&causes) {
                slopes[i] = self.slope(cause, own, &mut rest[i]);
                explained[i] += slopes[i] * slopes[i];
            }
            // No more than there is.
            let most = explained[i].max(1.0);
            slopes.iter_mut().for_each(|s| s[i] /= most.sqrt());
            explained[i] /= most;
        }
        let mut influences = Vec::new();
        for (influence, slopes) in causes.into_iter().zip(&slopes) {
            let m = linear.map_or(0, |l| l.components().len());
            let pick: Vec<f64> = (0..n * m)
                .map(|k| f64::from(u8::from(kept[k / m] == Some(k % m))))
                .collect();
            let effect = match (&influence.effect, m) {
                (
                    Effect::Scalar {
                        value,
                        unit,
                        standard_uncertainty: u,
                        sensitivity,
                    },
                    _,
                ) => Effect::Scalar {
                    value: *value,
                    unit: unit.clone(),
                    standard_uncertainty: *u,
                    sensitivity: (0..n)
                        .map(|i| match kept[i] {
                            Some(k) => sensitivity[k],
                            None if *u > 0.0 => slopes[i] * quantities[i].scale / u,
                            None => 0.0,
                        })
                        .collect(),
                },
                (other, m) => other.propagate(&pick, m)?,
            };
            influences.push(Influence {
                effect,
                ..influence.clone()
            });
        }
        let rows = self.rows() as f64;
        let mut covariance = vec![0.0; n * n];
        let left = |i: usize| {
            let own: f64 = rest[i].iter().map(|z| z * z).sum();
            // What the causes do not explain, so that the whole is the stated variance.
            let share = (1.0 - explained[i]).max(0.0);
            if own > 0.0 {
                (share * rows / own).sqrt()
            } else {
                0.0
            }
        };
        for i in (0..n).filter(|i| kept[*i].is_none()) {
            for j in (0..=i).filter(|j| kept[*j].is_none()) {
                let product: f64 = rest[i].iter().zip(&rest[j]).map(|(a, b)| a * b).sum();
                let v =
                    product / rows * left(i) * left(j) * quantities[i].scale * quantities[j].scale;
                (covariance[i * n + j], covariance[j * n + i]) = (v, v);
            }
        }
        influences.push(Influence {
            key: "trials".to_owned(),
            description: "what no cause explains linearly".to_owned(),
            evaluation: Evaluation::B,
            distribution: "trials".to_owned(),
            dof: DegreesOfFreedom::INFINITE,
            effect: Effect::Joint {
                covariance: Covariance::try_from_rows(n, &covariance)?,
            },
        });
        Estimate::new(components, influences)
    }

    /// How a quantity follows a scalar cause, both in their standard uncertainties; taken out of `rest`. What chance alone may
    /// leave is none.
    fn slope(&self, influence: &Influence, trials: &[f64], rest: &mut [f64]) -> f64 {
        if !matches!(influence.effect, Effect::Scalar { .. }) {
            return 0.0;
        }
        let cause = self
            .columns
            .iter()
            .find(|c| c.cause && c.name == influence.key);
        let Some(cause) = cause.map(TrialColumn::counted) else {
            return 0.0;
        };
        let squares: f64 = cause.iter().map(|x| x * x).sum();
        let own: f64 = trials.iter().map(|z| z * z).sum();
        let product: f64 = cause.iter().zip(trials).map(|(x, z)| x * z).sum();
        if !(product.abs() > 4.0 * (squares * own / trials.len() as f64).sqrt()) {
            return 0.0;
        }
        let slope = product / squares;
        for (z, x) in rest.iter_mut().zip(&cause) {
            *z -= slope * x;
        }
        slope
    }
}
