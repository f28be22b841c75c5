//! The fit with the scatter of its parameters: noise within the standstills and whatever varies between them.

use super::observability::observability;
use super::scatter_forms::FormFit;
use super::{MultiPosition, Problem, problem::Weighting};
use crate::added_terms::{AddedTerms, WeighedTerms};
use faer::Mat;
use proofmass_core::Error;
use proofmass_uncertainty::adjustment::{Solution, cholesky, solve};
use proofmass_uncertainty::{BetweenScatter, DegreesOfFreedom, Linearised};

/// Where the fit ended and how well its parameters are known, in natural units.
#[derive(Clone, Debug)]
pub(crate) struct Solved {
    pub(crate) solution: Solution,
    pub(crate) weighting: Weighting,
    /// Equations less parameters.
    pub(crate) freedom: usize,
    /// χ² against the noise alone; `None` where the noise is not known.
    pub(crate) chi_square: Option<f64>,
    /// What the rule for scatter of unknown size says; `None` without freedom or without known noise.
    pub(crate) scatter: Option<BetweenScatter>,
    /// Variance between the standstills; of readings that share errors with their neighbours, as much more as they are
    /// fewer.
    pub(crate) excess: f64,
    /// Variance of one of them for itself.
    pub(crate) own: f64,
    /// G, p × n by rows: θ moves by −G r where the residuals move by r.
    pub(crate) gain: Vec<f64>,
    /// Degrees of freedom at which Student's t has the factor U/u of the scatter.
    pub(crate) dof: DegreesOfFreedom,
    pub(crate) condition: f64,
    /// The fits at each form of the scatter; empty where independent scatter is all that was asked for.
    pub(crate) forms: Vec<FormFit>,
    /// The mean of G over the forms.
    pub(crate) mean_gain: Vec<f64>,
    /// Covariance of the parameters over the forms.
    pub(crate) mixed: Option<Mat<f64>>,
}

impl Solved {
    /// With scatter of every form that it may have.
    pub(crate) fn of(settings: &MultiPosition, problem: &Problem<'_>) -> Result<Self, Error> {
        Ok(Self::independent(settings, problem)?.with_forms(settings, problem))
    }

    /// With scatter of each standstill for itself.
    pub(crate) fn independent(
        settings: &MultiPosition,
        problem: &Problem<'_>,
    ) -> Result<Self, Error> {
        let (mut solution, mut weighting) = problem.first()?;
        let p = problem.parameters();
        let n = problem.rows();
        let condition = observability(&solution.equations, p, |i| problem.parameter_name(i))?;
        let mut solved = Self {
            freedom: n - p,
            chi_square: None,
            scatter: None,
            excess: 0.0,
            own: 0.0,
            gain: Vec::new(),
            dof: settings.noise_dof,
            condition,
            forms: Vec::new(),
            mean_gain: Vec::new(),
            mixed: None,
            weighting: Weighting::default(),
            solution: solution.clone(),
        };
        if !problem.noise_is_known() {
            // All of the scatter is in the residuals: one unknown variance, plain Student t. Readings that share errors with
            // their neighbours count as fewer, and each for as much more variance.
            if let Some(effective) = settings.effective {
                solved.freedom = (effective.floor() as usize).min(n).saturating_sub(p);
            }
            if solved.freedom == 0 {
                return Err(Error::TooFew {
                    name: "readings of unknown noise",
                    needed: p + 1,
                    got: n,
                });
            }
            solved.excess = sum_of_squares(&solution) / solved.freedom as f64;
            solved.own = sum_of_squares(&solution) / (n - p) as f64;
            solved.gain = gain(&solution.equations.jacobian, &vec![1.0; n], p)?;
            solved.dof =
                DegreesOfFreedom::new(solved.freedom as f64).unwrap_or(DegreesOfFreedom::INFINITE);
            weighting.variances = vec![0.0; n];
            weighting.tilt = vec![0.0; n];
        } else if n == p {
            let weights: Vec<f64> = weighting.variances.iter().map(|v| 1.0 / v).collect();
            solved.gain = gain(&solution.equations.jacobian, &weights, p)?;
            solved.chi_square = Some(0.0);
        } else {
            let mut scatter = BetweenScatter::evaluate(
                &weighting.variances,
                settings.noise(),
                settings.probability,
                |weights| -> Result<Linearised, Error> {
                    let before = solution.iterations;
                    solution = problem.adjust(&solution.parameters, &weighting, weights)?;
                    solution.iterations += before;
                    Ok(Linearised {
                        jacobian: solution.equations.jacobian.clone(),
                        residuals: solution.equations.residual.clone(),
                    })
                },
            )?;
            solved.chi_square = Some(scatter.chi_squared);
            solved.excess = scatter.excess_variance;
            solved.own = scatter.excess_variance;
            solved.gain = std::mem::take(&mut scatter.gain);
            solved.dof = scatter.dof;
            solved.scatter = Some(scatter);
        }
        solved.solution = solution;
        solved.weighting = weighting;
        Ok(solved)
    }

    /// G diag(v) Gᵀ.
    pub(crate) fn through_gain(&self, variances: impl Fn(usize) -> f64) -> Mat<f64> {
        let n = self.weighting.variances.len();
        let p = self.solution.parameters.len();
        let v: Vec<f64> = (0..n).map(variances).collect();
        let gain = self.stated_gain();
        let row = |c: usize| &gain[c * n..(c + 1) * n];
        Mat::from_fn(p, p, |a, b| {
            let pair = row(a.max(b)).iter().zip(row(a.min(b)));
            pair.zip(&v).map(|((g, h), v)| g * h * v).sum()
        })
    }

    /// G of the stated parameters.
    fn stated_gain(&self) -> &[f64] {
        match self.mixed {
            Some(_) => &self.mean_gain,
            None => &self.gain,
        }
    }

    /// Covariance of the parameters from noise, own errors of the attitudes, and scatter between the standstills.
    pub(crate) fn covariance(&self) -> Mat<f64> {
        match &self.mixed {
            Some(mixed) => mixed.clone(),
            None => self.through_gain(|i| self.weighting.variances[i] + self.excess),
        }
    }

    /// The residuals, for tests of what the model leaves out. Of the forms of the scatter those count that are no such terms.
    pub(crate) fn terms(&self) -> WeighedTerms<'_> {
        let independent = AddedTerms::new(
            &self.solution.equations.jacobian,
            &self.gain,
            &self.solution.equations.residual,
            &self.weighting.variances,
            self.excess,
            self.freedom,
        );
        let mut all = Vec::new();
        for fit in &self.forms {
            match fit.is_independent() {
                true => all.insert(0, (fit.weight, independent.clone())),
                false => all.extend(fit.terms(self.freedom).map(|terms| (fit.weight, terms))),
            }
        }
        if all.is_empty() {
            all.push((1.0, independent));
        }
        WeighedTerms::new(all)
    }

    /// −G d: how an input appears in the parameters whose derivative in the residuals is d.
    pub(crate) fn through(&self, derivative: &[f64]) -> Vec<f64> {
        self.stated_gain()
            .chunks(derivative.len().max(1))
            .map(|row| -row.iter().zip(derivative).map(|(g, d)| g * d).sum::<f64>())
            .collect()
    }
}

fn sum_of_squares(solution: &Solution) -> f64 {
    solution.equations.residual.iter().map(|r| r * r).sum()
}

/// The factor of JᵀWJ.
pub(super) fn factored_normal(
    jacobian: &[f64],
    weights: &[f64],
    p: usize,
) -> Result<Vec<f64>, Error> {
    let mut normal = vec![0.0; p * p];
    for (row, w) in jacobian.chunks_exact(p).zip(weights) {
        for a in 0..p {
            for b in 0..=a {
                normal[a * p + b] += w * row[a] * row[b];
            }
        }
    }
    cholesky(&mut normal, p).ok_or(Error::Singular {
        name: "equations of the fit",
        condition: f64::INFINITY,
    })?;
    Ok(normal)
}

/// (JᵀWJ)⁻¹JᵀW by rows.
pub(super) fn gain(jacobian: &[f64], weights: &[f64], p: usize) -> Result<Vec<f64>, Error> {
    let n = weights.len();
    let normal = factored_normal(jacobian, weights, p)?;
    let mut gain = vec![0.0; p * n];
    let mut column = vec![0.0; p];
    for (i, (row, w)) in jacobian.chunks_exact(p).zip(weights).enumerate() {
        for (c, j) in column.iter_mut().zip(row) {
            *c = w * j;
        }
        solve(&normal, &mut column);
        for (a, c) in column.iter().enumerate() {
            gain[a * n + i] = *c;
        }
    }
    Ok(gain)
}

impl Problem<'_> {
    /// χ² of a fit at the variances of the problem, and the mean variance of its parameters.
    pub(crate) fn quality(&self) -> Result<(f64, f64), Error> {
        let (solution, weighting) = self.first()?;
        let p = self.parameters();
        let weights: Vec<f64> = weighting.variances.iter().map(|v| 1.0 / v).collect();
        let gain = gain(&solution.equations.jacobian, &weights, p)?;
        let residuals = solution.equations.residual.iter().zip(&weights);
        let chi_square = residuals.map(|(r, w)| w * r * r).sum();
        let spread: f64 = gain
            .chunks(weights.len())
            .flat_map(|row| row.iter().zip(&weighting.variances))
            .map(|(g, v)| g * g * v)
            .sum();
        Ok((chi_square, spread / p as f64))
    }
}
