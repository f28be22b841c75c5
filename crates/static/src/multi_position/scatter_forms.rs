//! Forms that the scatter between standstills may have, each with the weight that the residuals give it.

use super::solved::{Solved, factored_normal, gain};
use super::{MultiPosition, Problem};
use crate::Triple;
use crate::added_terms::AddedTerms;
use faer::Mat;
use proofmass_core::Error;
use proofmass_core::numeric::dot;
use proofmass_uncertainty::adjustment::{cholesky, solve};
use proofmass_uncertainty::algebra::symmetric_eigen;
use proofmass_uncertainty::{BetweenScatter, DegreesOfFreedom, Linearised};
use serde::Serialize;
use std::fmt;

/// What the scatter between the standstills may come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum ScatterForm {
    /// Each standstill for itself.
    Independent,
    /// Biases that walk at random from standstill to standstill.
    Walk,
    /// Biases with the sign of the last change of the acceleration of each axis: hysteresis.
    LastMotion,
    /// A term of each axis in the square of its acceleration.
    Square,
    /// A term in the third power.
    Cube,
}

impl fmt::Display for ScatterForm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Independent => "each standstill for itself",
            Self::Walk => "biases that walk",
            Self::LastMotion => "biases that follow the last motion",
            Self::Square => "a term in the square of the acceleration",
            Self::Cube => "a term in the third power of the acceleration",
        })
    }
}

/// How likely one form is by the residuals.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FormWeight {
    /// The form.
    pub form: ScatterForm,
    /// Its weight among all.
    pub weight: f64,
    /// What of the biases walks, m/s²/√s, where it is a walk.
    pub walk: Option<f64>,
}

/// More equations than this are not asked for a form: their covariance is a matrix of as many rows.
const MOST: usize = 600;
/// Of one degree or two every form explains the residuals alike.
const FEWEST: usize = 3;
/// A form of which less than this share lies outside the model cannot be seen in the residuals.
const VISIBLE: f64 = 1e-3;
/// Weight before the data of all forms but the independent one: half, and less with more degrees of freedom, of which a
/// few tell forms apart where there is one.
const MOST_BEFORE: f64 = 0.5;
const FREEDOM: f64 = 7.0;
/// Shares of a form beside independent scatter, and of what the forms weigh together.
const FORMS: [(ScatterForm, f64, f64); 5] = [
    (ScatterForm::Walk, 0.5, 0.15),
    (ScatterForm::Walk, 0.95, 0.25),
    (ScatterForm::LastMotion, 0.98, 0.3),
    (ScatterForm::Square, 0.98, 0.15),
    (ScatterForm::Cube, 0.98, 0.15),
];

/// The fit with scatter of one form: V = Σ + τ² R, in coordinates in which it is diagonal.
#[derive(Clone, Debug)]
pub(crate) struct FormFit {
    form: ScatterForm,
    pub(crate) weight: f64,
    /// ln of the restricted likelihood.
    likelihood: f64,
    /// Of τ, the size of the walk in natural units per √s.
    walk: Option<f64>,
    /// Rows are the new equations in the old ones; empty where they are the old ones.
    turned: Vec<f64>,
    jacobian: Vec<f64>,
    residuals: Vec<f64>,
    variances: Vec<f64>,
    excess: f64,
    /// G in the new equations.
    gain: Vec<f64>,
    /// By how much the parameters differ from those of independent scatter.
    shift: Vec<f64>,
    covariance: Vec<f64>,
    dof: DegreesOfFreedom,
}

impl FormFit {
    pub(crate) fn is_independent(&self) -> bool {
        self.form == ScatterForm::Independent
    }

    /// For tests of terms that the model leaves out, where the scatter walks.
    pub(crate) fn terms(&self, freedom: usize) -> Option<AddedTerms<'_>> {
        (self.form == ScatterForm::Walk).then(|| {
            AddedTerms::new(
                &self.jacobian,
                &self.gain,
                &self.residuals,
                &self.variances,
                self.excess,
                freedom,
            )
            .turned(&self.turned)
        })
    }
}

impl Solved {
    /// Takes the forms of the scatter into parameters and covariance, by their restricted likelihoods.
    ///
    /// V = Σ + τ² R has R = I for independent scatter; R = (1 − φ) I + φ W for the others, W scaled so that the residuals grow
    /// alike. Where the residuals are no larger than the noise τ̂² is zero for all, and nothing changes.
    ///
    /// **Source** `[Patterson1971]` (restricted likelihood), `[PauleMandel1982]` (τ²).
    pub(crate) fn with_forms(mut self, settings: &MultiPosition, problem: &Problem<'_>) -> Self {
        let n = self.weighting.variances.len();
        let motion = settings.effective.is_some();
        if self.freedom < FEWEST || n > MOST || self.excess <= 0.0 || motion {
            return self;
        }
        let Some(loads) = Loads::of(problem, &self) else {
            return self;
        };
        let before = (FREEDOM / self.freedom as f64).min(MOST_BEFORE);
        let independent = (ScatterForm::Independent, 1.0 - before);
        let mut fits: Vec<FormFit> = Vec::with_capacity(FORMS.len() + 1);
        match self.of_form(independent, None, None, settings) {
            Some(fit) => fits.push(fit),
            None => return self,
        }
        for (form, phi, share) in FORMS {
            let Some(covariance) = loads.covariance(form) else {
                continue;
            };
            let Some(size) = self.visible(&covariance) else {
                continue;
            };
            let scale = phi / size;
            let mixed = Mat::from_fn(n, n, |i, j| {
                scale * covariance[(i, j)] + if i == j { 1.0 - phi } else { 0.0 }
            });
            let walk = (form == ScatterForm::Walk).then_some(scale);
            fits.extend(self.of_form((form, before * share), Some(&mixed), walk, settings));
        }
        if fits.len() < 2 {
            return self;
        }
        let best = fits
            .iter()
            .map(|f| f.likelihood)
            .fold(f64::NEG_INFINITY, f64::max);
        for fit in &mut fits {
            fit.weight *= (fit.likelihood - best).exp();
        }
        let total: f64 = fits.iter().map(|f| f.weight).sum();
        for fit in &mut fits {
            fit.weight /= total;
        }
        self.mix(fits);
        self
    }

    /// Parameters, gain and covariance as the mean over the forms.
    fn mix(&mut self, fits: Vec<FormFit>) {
        let p = self.solution.parameters.len();
        let n = self.weighting.variances.len();
        let mean =
            |of: &dyn Fn(&FormFit) -> f64| fits.iter().map(|f| f.weight * of(f)).sum::<f64>();
        let shift: Vec<f64> = (0..p).map(|a| mean(&|f| f.shift[a])).collect();
        let mixed = Mat::from_fn(p, p, |a, b| {
            mean(&|f| {
                let apart = (f.shift[a] - shift[a]) * (f.shift[b] - shift[b]);
                f.covariance[a * p + b] + apart
            })
        });
        let mut gain = vec![0.0; p * n];
        for fit in &fits {
            for a in 0..p {
                let row = &mut gain[a * n..(a + 1) * n];
                for k in 0..n {
                    let g = fit.weight * fit.gain[a * n + k];
                    if fit.turned.is_empty() {
                        row[k] += g;
                        continue;
                    }
                    let old = &fit.turned[k * n..(k + 1) * n];
                    row.iter_mut().zip(old).for_each(|(r, t)| *r += g * t);
                }
            }
        }
        let inverse: f64 = mean(&|f| 1.0 / f.dof.get());
        self.dof = DegreesOfFreedom::new(1.0 / inverse).unwrap_or(DegreesOfFreedom::INFINITE);
        for (value, by) in self.solution.parameters.iter_mut().zip(&shift) {
            *value += by;
        }
        self.mixed = Some(mixed);
        self.mean_gain = gain;
        self.forms = fits;
    }

    /// The weights of the forms, those of one form together, the likeliest first; empty where only one was asked for.
    pub(crate) fn form_weights(&self, gravity: f64) -> Vec<FormWeight> {
        let mut all: Vec<FormWeight> = Vec::new();
        for fit in &self.forms {
            // What walks: rms over the shares.
            let squared = fit.walk.map(|w| fit.weight * (w * gravity).powi(2));
            match all.iter_mut().find(|w| w.form == fit.form) {
                Some(known) => {
                    known.weight += fit.weight;
                    known.walk = known.walk.zip(squared).map(|(a, b)| a + b);
                }
                None => all.push(FormWeight {
                    form: fit.form,
                    weight: fit.weight,
                    walk: squared,
                }),
            }
        }
        for one in &mut all {
            one.walk = one.walk.map(|squares| (squares / one.weight).sqrt());
        }
        all.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        all
    }

    /// tr(P W)/ν, where enough of W lies outside the model.
    fn visible(&self, form: &Mat<f64>) -> Option<f64> {
        let n = form.nrows();
        let p = self.solution.parameters.len();
        let jacobian = &self.solution.equations.jacobian;
        let (mut whole, mut inside) = (0.0, 0.0);
        for i in 0..n {
            whole += form[(i, i)];
            for c in 0..p {
                let gain = &self.gain[c * n..(c + 1) * n];
                let through: f64 = (0..n).map(|j| gain[j] * form[(j, i)]).sum();
                inside += jacobian[i * p + c] * through;
            }
        }
        let outside = whole - inside;
        (outside > VISIBLE * whole).then(|| outside / self.freedom as f64)
    }

    /// The fit at Σ + τ² R, linear about the one of independent scatter; `None` where it fails. Noise that is not known is part
    /// of the scatter: Σ is zero then.
    fn of_form(
        &self,
        (form, weight): (ScatterForm, f64),
        scatter: Option<&Mat<f64>>,
        walk: Option<f64>,
        settings: &MultiPosition,
    ) -> Option<FormFit> {
        let n = self.weighting.variances.len();
        let p = self.solution.parameters.len();
        let known = self.scatter.is_some();
        let noise = match known {
            true => self.weighting.variances.clone(),
            false => vec![1.0; n],
        };
        let (turned, variances) = match scatter {
            Some(scatter) => turn(scatter, &noise)?,
            None => (Vec::new(), noise),
        };
        let jacobian = times(&turned, &self.solution.equations.jacobian, p);
        let residuals = times(&turned, &self.solution.equations.residual, 1);
        let mut fit = FormFit {
            form,
            weight,
            likelihood: 0.0,
            walk: None,
            turned,
            residuals: Vec::new(),
            variances: vec![0.0; n],
            excess: 0.0,
            gain: Vec::new(),
            shift: Vec::new(),
            covariance: Vec::new(),
            dof: self.dof,
            jacobian,
        };
        if known {
            let refit = |weights: &[f64]| -> Result<Linearised, Error> {
                (fit.shift, fit.residuals) = least_squares(&fit.jacobian, &residuals, weights)?;
                Ok(Linearised {
                    jacobian: fit.jacobian.clone(),
                    residuals: fit.residuals.clone(),
                })
            };
            let noise = settings.noise();
            let of =
                BetweenScatter::evaluate(&variances, noise, settings.probability, refit).ok()?;
            fit.excess = of.excess_variance;
            fit.covariance = of.covariance;
            fit.gain = of.gain;
            fit.dof = of.dof;
        } else {
            let weights = vec![1.0; n];
            (fit.shift, fit.residuals) = least_squares(&fit.jacobian, &residuals, &weights).ok()?;
            fit.excess = dot(&fit.residuals, &fit.residuals) / self.freedom as f64;
            fit.gain = gain(&fit.jacobian, &weights, p).ok()?;
            let rows: Vec<&[f64]> = fit.gain.chunks(n).collect();
            let pairs = rows.iter().flat_map(|a| rows.iter().map(move |b| (a, b)));
            fit.covariance = pairs.map(|(a, b)| fit.excess * dot(a, b)).collect();
        }
        fit.walk = walk.map(|scale| (fit.excess * scale).sqrt());
        let mut factor = fit.covariance.clone();
        cholesky(&mut factor, p)?;
        // ln|V| − ln|C| + rᵀV⁻¹r, without what all forms have alike.
        let mut sum = -(0..p).map(|a| 2.0 * factor[a * p + a].ln()).sum::<f64>();
        if known {
            sum += variances
                .iter()
                .map(|v| (fit.excess / v).ln_1p())
                .sum::<f64>();
            let squares = fit.residuals.iter().zip(&variances);
            sum += squares.map(|(r, v)| r * r / (v + fit.excess)).sum::<f64>();
            fit.variances = variances;
        } else {
            sum += variances.iter().map(|v| (fit.excess / v).ln()).sum::<f64>();
        }
        fit.likelihood = -0.5 * sum;
        fit.likelihood.is_finite().then_some(fit)
    }
}

/// Equations in which Σ + τ² R is diagonal, rows in the old ones, and their variances beside τ².
fn turn(scatter: &Mat<f64>, variances: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
    let n = variances.len();
    let root: Vec<f64> = variances.iter().map(|v| v.sqrt().recip()).collect();
    let whitened = Mat::from_fn(n, n, |i, j| root[i] * scatter[(i, j)] * root[j]);
    let eigen = symmetric_eigen(&whitened, "eigenvalues of the scatter").ok()?;
    let sizes: Vec<f64> = eigen.S().column_vector().iter().copied().collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    let sizes: Vec<f64> = sizes.iter().map(|d| d.max(1e-9 * largest)).collect();
    let mut turned = vec![0.0; n * n];
    for (k, size) in sizes.iter().enumerate() {
        for i in 0..n {
            turned[k * n + i] = eigen.U()[(i, k)] * root[i] / size.sqrt();
        }
    }
    let variances = sizes.iter().map(|d| 1.0 / d);
    (largest > 0.0).then(|| (turned, variances.collect()))
}

/// T times p columns that stand by rows; T itself where it is empty is the identity.
fn times(turned: &[f64], columns: &[f64], p: usize) -> Vec<f64> {
    if turned.is_empty() {
        return columns.to_vec();
    }
    let n = columns.len() / p;
    let mut out = vec![0.0; n * p];
    for (row, new) in turned.chunks(n).zip(out.chunks_mut(p)) {
        for (t, old) in row.iter().zip(columns.chunks(p)) {
            new.iter_mut().zip(old).for_each(|(x, o)| *x += t * o);
        }
    }
    out
}

/// The step δ that makes Σ w (r + J δ)² least, and r + J δ.
fn least_squares(
    jacobian: &[f64],
    residuals: &[f64],
    weights: &[f64],
) -> Result<(Vec<f64>, Vec<f64>), Error> {
    let p = jacobian.len() / residuals.len().max(1);
    let normal = factored_normal(jacobian, weights, p)?;
    let mut step = vec![0.0; p];
    for ((row, r), w) in jacobian.chunks_exact(p).zip(residuals).zip(weights) {
        step.iter_mut().zip(row).for_each(|(s, j)| *s -= w * j * r);
    }
    solve(&normal, &mut step);
    let left = jacobian.chunks_exact(p).zip(residuals);
    let left = left.map(|(row, r)| r + dot(row, &step)).collect();
    Ok((step, left))
}

/// Unit causes of each form in the equations: what of the axes each equation sees, and by how much.
struct Loads {
    /// What each equation sees of an error of each axis.
    seen: Vec<Triple>,
    /// Directions of the specific force, one for each standstill.
    directions: Vec<Triple>,
    times: Option<Vec<f64>>,
    each: usize,
    /// Largest power of the acceleration in the model beyond the first.
    curvature: usize,
}

impl Loads {
    fn of(problem: &Problem<'_>, solved: &Solved) -> Option<Self> {
        let parameters = &solved.solution.parameters;
        let axes: Option<Vec<Vec<f64>>> = (0..3)
            .map(|axis| {
                let mut error = [0.0; 3];
                error[axis] = 1.0;
                problem.in_equations(parameters, &solved.weighting, |_| error)
            })
            .collect();
        let axes = axes?;
        Some(Self {
            seen: (0..axes[0].len())
                .map(|r| [axes[0][r], axes[1][r], axes[2][r]])
                .collect(),
            directions: problem.directions(parameters)?,
            times: problem.poses.iter().map(|p| p.time).collect(),
            each: problem.each(),
            curvature: problem.terms.curvature_order(),
        })
    }

    /// Covariance of the equations for scatter of one form and any size; `None` where the standstills cannot show it, or the
    /// model has it.
    fn covariance(&self, form: ScatterForm) -> Option<Mat<f64>> {
        let rows = self.seen.len();
        match form {
            ScatterForm::Independent => None,
            ScatterForm::Walk => {
                let walk = centred_walk(self.times.as_ref()?);
                Some(Mat::from_fn(rows, rows, |i, j| {
                    walk[(i / self.each, j / self.each)]
                        * proofmass_core::dot(self.seen[i], self.seen[j])
                }))
            }
            ScatterForm::LastMotion => {
                self.times.as_ref()?;
                Some(self.of_axes(|pose, axis| last_motion(&self.directions, pose, axis)))
            }
            ScatterForm::Square if self.curvature < 2 => {
                Some(self.of_axes(|pose, axis| self.directions[pose][axis].powi(2)))
            }
            ScatterForm::Cube if self.curvature < 3 => {
                Some(self.of_axes(|pose, axis| self.directions[pose][axis].powi(3)))
            }
            ScatterForm::Square | ScatterForm::Cube => None,
        }
    }

    /// Of one coefficient for each axis, all of one size.
    fn of_axes(&self, of: impl Fn(usize, usize) -> f64) -> Mat<f64> {
        let columns: Vec<Triple> = self
            .seen
            .iter()
            .enumerate()
            .map(|(row, seen)| std::array::from_fn(|axis| seen[axis] * of(row / self.each, axis)))
            .collect();
        let rows = columns.len();
        Mat::from_fn(rows, rows, |i, j| {
            proofmass_core::dot(columns[i], columns[j])
        })
    }
}

/// The sign of the last change of the acceleration of an axis.
pub(super) fn last_motion(directions: &[Triple], pose: usize, axis: usize) -> f64 {
    match pose.checked_sub(1) {
        Some(before) => (directions[pose][axis] - directions[before][axis]).signum(),
        None => 0.0,
    }
}

/// Covariance of a random walk of 1/√s less its mean over the standstills.
fn centred_walk(times: &[f64]) -> Mat<f64> {
    let n = times.len();
    let start = times.iter().copied().fold(f64::INFINITY, f64::min);
    let walk = Mat::from_fn(n, n, |i, j| times[i].min(times[j]) - start);
    let means: Vec<f64> = (0..n)
        .map(|i| (0..n).map(|j| walk[(i, j)]).sum::<f64>() / n as f64)
        .collect();
    let mean = means.iter().sum::<f64>() / n as f64;
    Mat::from_fn(n, n, |i, j| walk[(i, j)] - means[i] - means[j] + mean)
}
