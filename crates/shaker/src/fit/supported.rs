//! The budget as the runs have it: every declared uncertainty they can tell, where it is too small, and how well they tell.

use crate::adjustment::Adjustment;
use crate::budget::Budget;
use crate::derived::PROBABILITY;
use crate::observation::{PhasorRow, SpuriousTable};
use proofmass_core::Error;
use proofmass_uncertainty::{DegreesOfFreedom, dof_of_coverage_factor};
use serde::Serialize;

/// A kind of error of which the runs tell how large it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct VarianceComponent {
    /// Key of the input; `readings` for all that differs from run to run, with its noise.
    pub key: String,
    /// Frequency in Hz, where it is that of one frequency.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency: Option<f64>,
    /// Standard uncertainty by the runs over the declared one.
    pub estimated: f64,
    /// The one that was used over the declared one: the larger of the two.
    pub used: f64,
    /// Degrees of freedom that the runs have for it, with those of the declaration where it has any.
    pub freedom: f64,
    /// Degrees of freedom in the result: those with which t·û is the half width, or infinite where the declared one with
    /// the normal factor is larger; no more than `freedom` where the declaration has degrees of freedom.
    pub dof: DegreesOfFreedom,
}

/// Runs and budget with the uncertainties that were used.
pub(crate) struct Supported {
    pub(crate) rows: Vec<PhasorRow>,
    pub(crate) budget: Budget,
    pub(crate) components: Vec<VarianceComponent>,
    /// Degrees of freedom of the readings, by frequency.
    readings: Vec<f64>,
    /// Degrees of freedom of each input of the budget.
    inputs: Vec<f64>,
    /// Whether anything was enlarged.
    enlarged: bool,
}

/// Key of what differs from run to run.
const READINGS: &str = "readings";

impl Supported {
    /// U = max(t(ν) û, 1.96 u) for each kind of error by itself, u the declared uncertainty: what the readings say with
    /// the freedom they have, or what was declared, and nothing is decided in between.
    ///
    /// **Source** restricted maximum likelihood `[Harville1977]` for û; the rule is that of
    /// [`BetweenScatter`](proofmass_uncertainty::BetweenScatter).
    pub(crate) fn new(
        adjustment: &Adjustment,
        rows: &[PhasorRow],
        budget: &Budget,
    ) -> Result<Self, Error> {
        let found = adjustment.components(budget)?;
        let mut supported = Self {
            rows: rows.to_vec(),
            budget: budget.clone(),
            components: vec![],
            readings: vec![f64::INFINITY; adjustment.frequencies.len()],
            inputs: budget.inputs.iter().map(|i| i.dof.get()).collect(),
            enlarged: false,
        };
        // `declared`: degrees of freedom of the declaration, which are in `freedom`.
        let mut told = |key: &str, frequency, declared: f64, ratio: f64, freedom: f64| {
            let t = DegreesOfFreedom::new(freedom)
                .unwrap_or(DegreesOfFreedom::INFINITE)
                .coverage_factor(PROBABILITY);
            let dof = match dof_of_coverage_factor(t * ratio.min(1.0).sqrt(), PROBABILITY) {
                dof if declared.is_finite() => dof.min(freedom),
                dof => dof,
            };
            supported.components.push(VarianceComponent {
                key: key.to_owned(),
                frequency,
                estimated: ratio.sqrt(),
                used: ratio.max(1.0).sqrt(),
                freedom,
                dof: DegreesOfFreedom::new(dof).unwrap_or(DegreesOfFreedom::INFINITE),
            });
            dof
        };
        let only = match adjustment.frequencies[..] {
            [frequency] => Some(frequency),
            _ => None,
        };
        let mut enlarged = vec![1.0; adjustment.frequencies.len()];
        for (f, component) in found.readings.iter().enumerate() {
            if let Some(c) = component {
                let frequency = Some(adjustment.frequencies[f]);
                supported.readings[f] =
                    told(READINGS, frequency, f64::INFINITY, c.ratio, c.freedom);
                enlarged[f] = c.ratio.max(1.0);
            }
        }
        let mut factors = vec![1.0; budget.inputs.len()];
        for (index, component) in found.inputs.iter().enumerate() {
            if let Some(c) = component {
                let input = &budget.inputs[index];
                supported.inputs[index] =
                    told(&input.key, only, input.dof.get(), c.ratio, c.freedom);
                factors[index] = c.ratio.max(1.0).sqrt();
            }
        }
        supported.enlarged = enlarged.iter().chain(&factors).any(|&f| f > 1.0);
        if supported.enlarged {
            let largest = enlarged.iter().copied().fold(1.0, f64::max).sqrt();
            for (input, factor) in supported.budget.inputs.iter_mut().zip(&factors) {
                if input.within_a_run() {
                    let at = adjustment.frequencies.iter().zip(&enlarged);
                    let at = at.map(|(&f, e)| (f, input.standard_uncertainty_at(f) * e.sqrt()));
                    input.at_frequencies = at.collect();
                    input.distribution = input.distribution.scaled(largest, 0.0);
                } else {
                    input.scale(*factor);
                }
            }
            for (row, &f) in supported.rows.iter_mut().zip(&adjustment.of_row) {
                for v in row.covariance.iter_mut().flatten() {
                    *v *= enlarged[f];
                }
            }
        }
        Ok(supported)
    }

    /// The adjustment with what was enlarged; `None` where the declared one is it.
    pub(crate) fn adjusted(&self, spurious: &SpuriousTable) -> Result<Option<Adjustment>, Error> {
        let again = || Adjustment::new(&self.rows, spurious, &self.budget);
        self.enlarged.then(again).transpose()
    }

    /// The same uncertainties as if nobody had estimated them.
    pub(crate) fn taken_as_declared(self) -> Self {
        Self {
            readings: vec![f64::INFINITY; self.readings.len()],
            inputs: self.budget.inputs.iter().map(|i| i.dof.get()).collect(),
            ..self
        }
    }

    /// Degrees of freedom of an influence at a frequency: of an input of the budget, or of the noise of the phasors
    /// (`None`). What differs from run to run is known as one thing, of which each influence has its `share`.
    pub(super) fn dof(&self, f: usize, input: Option<usize>, share: f64) -> DegreesOfFreedom {
        let readings = self.readings[f] * share;
        let nu = match input {
            Some(k) if self.budget.inputs[k].within_a_run() => self.inputs[k].min(readings),
            Some(k) => self.inputs[k],
            None => readings,
        };
        DegreesOfFreedom::new(nu).unwrap_or(DegreesOfFreedom::INFINITE)
    }
}
