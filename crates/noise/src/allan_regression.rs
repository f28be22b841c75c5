//! Coefficients from the whole Allan curve, with the covariance between averaging times.

use crate::allan_covariance::allan_covariance;
use crate::coefficients::identified;
use crate::model::{allan_response, term_density};
use crate::record::{Record, check_count, check_finite, check_sample_rate};
use crate::whittle::{normal_quantile, refuse_constant};
use crate::{
    Coefficient, CoefficientFit, DeviationCurve, DeviationOptions, FitOptions, Method, NoiseModel,
    Reason, Statistic, Term, Verdict, deviation,
};
use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};
use proofmass_core::Error;
use proofmass_uncertainty::{Covariance, Finding, Severity};
use std::f64::consts::{LN_2, PI};

/// Noise coefficients by regression on the overlapping Allan variance at octave averaging times.
///
/// The model σ²(τ) = 3Q²/τ² + N²/τ + (2 ln 2/π) B² + K²τ/3 + R²τ²/2 (in its sampled form at small m) is fitted to the
/// whole curve. The covariance between averaging times is that of the fitted noise in a record of this length, its
/// ends included, and is iterated with the fit. Residuals are formed of cube roots, in which
/// χ²-distributed variances of few degrees of freedom are nearly Gaussian. Terms enter as in
/// [`whittle`](crate::whittle()): every combination with positive squares is tried, and a term must gain more than chance.
///
/// Against [`whittle`](crate::whittle()) it is less efficient (a curve of some twenty numbers) but sees what the eye sees
/// in the plot. Gauss–Markov processes and sinusoids are not sought here.
///
/// **Units**, **Errors** as [`whittle`](crate::whittle()).
///
/// **Accuracy** `coverage_allan_regression`.
///
/// **Source** covariance `[Greenhall1991]`; cube root `[Wilson1931]`.
pub fn allan_regression(
    rate: &[f64],
    sample_rate: f64,
    options: &FitOptions,
) -> Result<CoefficientFit, Error> {
    check_sample_rate(sample_rate)?;
    check_finite("rate", rate)?;
    check_count("rate samples", rate.len(), 64)?;
    crate::deviation::check_probability(options.probability)?;
    crate::deviation::check_probability(options.false_alarm_rate)?;
    refuse_constant(rate)?;
    let curve = deviation(
        Record::Rate(rate),
        sample_rate,
        Statistic::OverlappingAllan,
        &DeviationOptions::default(),
    )?;
    fit_curve(&curve, options)
}

/// Regression on a curve that has been computed.
///
/// **Errors** [`Error::TooFew`] below four usable points (τ up to a sixth of the record).
pub fn fit_curve(curve: &DeviationCurve, options: &FitOptions) -> Result<CoefficientFit, Error> {
    let mut problem = Regression::new(curve, options)?;
    let needed = options.needed_gain();
    let mut fits = problem.combinations();
    let Some(floor) = fits
        .iter()
        .map(|f| f.residual_square)
        .min_by(f64::total_cmp)
    else {
        return Err(Error::NotConverged {
            name: "Allan regression",
            iterations: 0,
            step: f64::NAN,
        });
    };
    // A model that cannot describe the curve is wrong by a relative amount δ at every τ, as in the spectral fit.
    let expected = (problem.roots.len() as f64 - 3.0).max(1.0);
    let limit = crate::edf::chi_square_quantile(0.999, expected).unwrap_or(f64::INFINITY);
    if floor > limit {
        // The combinations nearest to the curve stay so: δ is sought with them alone.
        fits.sort_by(|a, b| a.residual_square.total_cmp(&b.residual_square));
        let nearest: Vec<Vec<usize>> = fits.iter().take(4).map(|f| f.chosen.clone()).collect();
        let (mut low, mut high) = (1e-3_f64, 3.0_f64);
        for _ in 0..8 {
            problem.discrepancy = (low * high).sqrt();
            let best = nearest
                .iter()
                .filter_map(|chosen| problem.fit(chosen.clone()))
                .map(|f| f.residual_square)
                .fold(f64::INFINITY, f64::min);
            if best > expected {
                low = problem.discrepancy;
            } else {
                high = problem.discrepancy;
            }
        }
        problem.discrepancy = high;
        fits = problem.combinations();
    }
    fits.sort_by(|a, b| {
        let cost = |f: &Fit| f.deviance + needed * f.chosen.len() as f64;
        cost(a).total_cmp(&cost(b))
    });
    if fits.is_empty() {
        return Err(Error::NotConverged {
            name: "Allan regression",
            iterations: 60,
            step: problem.discrepancy,
        });
    }
    let best = &fits[0];
    let gain_of = |chosen: &[usize]| {
        fits.iter()
            .find(|f| f.chosen == chosen)
            .map_or(0.0, |f| (best.deviance - f.deviance).max(0.0))
    };

    let mut findings = Vec::new();
    if problem.discrepancy > 0.0 {
        findings.push(
            Finding::new(
                Severity::Warning,
                "allan-curve-misfit",
                "the Allan curve departs from every combination of the noise terms",
            )
            .evidence(format!(
                "it departs by {:.1} % beyond its scatter",
                50.0 * problem.discrepancy
            ))
            .advice("look at the curve for a bump (Gauss–Markov process, sinusoid, filter); the departure was taken as an uncertainty at every τ, which widens the intervals"),
        );
    }
    let mut model = NoiseModel::default();
    let mut coefficients = Vec::new();
    for (index, &term) in problem.terms.iter().enumerate() {
        let verdict = match best.chosen.iter().position(|c| *c == index) {
            Some(p) => {
                let v = best.squares[p];
                let u2 = v * v * best.covariance[(p, p)];
                model.set(term, v.sqrt());
                let without: Vec<usize> = best
                    .chosen
                    .iter()
                    .copied()
                    .filter(|c| *c != index)
                    .collect();
                let gain = fits
                    .iter()
                    .find(|f| f.chosen == without)
                    .map_or(f64::MAX, |f| (f.deviance - best.deviance).max(0.0));
                identified(v, u2, gain, options.probability)
            }
            None => {
                let mut with = best.chosen.clone();
                with.push(index);
                with.sort_unstable();
                let gain = gain_of(&with);
                Verdict::NotIdentifiable {
                    reason: if gain > needed {
                        Reason::OtherTermsSuffice
                    } else {
                        Reason::NoSupport { gain, needed }
                    },
                    upper_limit: problem.upper_limit(best, index, options.probability),
                }
            }
        };
        coefficients.push(Coefficient {
            term,
            unit: term.unit(&options.unit),
            verdict,
            parameter: None,
        });
    }
    // Covariance of coefficients: θ = ln c², so u(c_i, c_j) = c_i c_j Cov(θ)/4.
    let p = best.chosen.len();
    let rows: Vec<f64> = (0..p * p)
        .map(|k| {
            let (i, j) = (k / p, k % p);
            let root = (best.squares[i] * best.squares[j]).sqrt();
            0.125 * root * (best.covariance[(i, j)] + best.covariance[(j, i)])
        })
        .collect();
    Ok(CoefficientFit {
        method: Method::AllanRegression,
        probability: options.probability,
        false_alarm_rate: options.false_alarm_rate,
        coefficients,
        model,
        covariance: Covariance::try_from_rows(p, &rows)?,
        discrepancy: problem.discrepancy,
        findings,
    })
}

struct Regression {
    terms: Vec<Term>,
    /// Allan variance of a unit square of each term at each point.
    basis: Vec<Vec<f64>>,
    /// Cube roots of the observed variances.
    roots: Vec<f64>,
    variances: Vec<f64>,
    /// Covariance of the variances for unit squares of each pair of terms, (i, j) of the points.
    covariances: Vec<Vec<Mat<f64>>>,
    /// Relative standard departure of the variances from every model, zero unless one is needed.
    discrepancy: f64,
}

struct Fit {
    chosen: Vec<usize>,
    squares: Vec<f64>,
    /// Covariance of the logarithms of the squares.
    covariance: Mat<f64>,
    residual_square: f64,
    deviance: f64,
}

/// Residuals of the cube roots, their derivative by the mean, the factor of their covariance, its log-determinant.
type Roots = (Vec<f64>, Vec<f64>, Llt<f64>, f64);

impl Regression {
    fn new(curve: &DeviationCurve, options: &FitOptions) -> Result<Self, Error> {
        let n = curve.phase_points - 1;
        let rate = curve.sample_rate;
        let points: Vec<_> = curve
            .points
            .iter()
            .filter(|p| 6 * p.factor <= n && p.deviation > 0.0)
            .collect();
        check_count("averaging times", points.len(), 4)?;
        let mut terms: Vec<Term> = options
            .terms
            .iter()
            .copied()
            .filter(|t| !matches!(t, Term::GaussMarkov | Term::Sinusoid))
            .collect();
        terms.sort();
        terms.dedup();
        let factors: Vec<usize> = points.iter().map(|p| p.factor).collect();
        let basis = terms
            .iter()
            .map(|&t| factors.iter().map(|&m| unit_variance(t, m, rate)).collect())
            .collect();
        let variances: Vec<f64> = points.iter().map(|p| p.deviation * p.deviation).collect();
        Ok(Self {
            covariances: allan_covariance(&terms, &factors, n, rate),
            roots: variances.iter().map(|v| v.cbrt()).collect(),
            terms,
            basis,
            variances,
            discrepancy: 0.0,
        })
    }

    /// Every combination of terms with positive squares.
    fn combinations(&self) -> Vec<Fit> {
        let candidates = self.terms.len();
        (1_usize..1 << candidates)
            .filter_map(|subset| {
                self.fit((0..candidates).filter(|i| subset >> i & 1 == 1).collect())
            })
            .collect()
    }

    fn mean(&self, chosen: &[usize], squares: &[f64]) -> Vec<f64> {
        (0..self.roots.len())
            .map(|i| {
                chosen
                    .iter()
                    .zip(squares)
                    .map(|(&t, c)| c * self.basis[t][i])
                    .sum()
            })
            .collect()
    }

    /// Covariance of the variances under a combination.
    fn covariance(&self, chosen: &[usize], squares: &[f64]) -> Mat<f64> {
        let n = self.roots.len();
        let mut sum = Mat::<f64>::zeros(n, n);
        for (&t, a) in chosen.iter().zip(squares) {
            for (&u, b) in chosen.iter().zip(squares) {
                let part = &self.covariances[t.max(u)][t.min(u)];
                for i in 0..n {
                    for j in 0..n {
                        sum[(i, j)] += a * b * part[(i, j)];
                    }
                }
            }
        }
        sum
    }

    /// Residuals of the cube roots, their derivative by the mean, and the factor of their covariance.
    fn roots_at(&self, chosen: &[usize], squares: &[f64]) -> Option<Roots> {
        let mean = self.mean(chosen, squares);
        let c = self.covariance(chosen, squares);
        let slope: Vec<f64> = mean.iter().map(|m| m.powf(-2.0 / 3.0) / 3.0).collect();
        let n = mean.len();
        // A ramp alone has no scatter of its own: a floor of 1e-6 keeps the matrix regular.
        let v = Mat::from_fn(n, n, |i, j| {
            let own = 1e-12 + self.discrepancy * self.discrepancy;
            let own = if i == j { own * mean[i] * mean[i] } else { 0.0 };
            slope[i] * slope[j] * (c[(i, j)] + own)
        });
        let residual = (0..n)
            .map(|i| {
                // E(z^{1/3}) of a χ² variance with ν = 2μ²/C degrees of freedom.
                let shift = (c[(i, i)] / (9.0 * mean[i] * mean[i])).min(0.5);
                self.roots[i] - mean[i].cbrt() * (1.0 - shift)
            })
            .collect();
        let llt = v.llt(Side::Lower).ok()?;
        let log_det = 2.0 * (0..n).map(|i| llt.L()[(i, i)].ln()).sum::<f64>();
        Some((residual, slope, llt, log_det))
    }

    /// Levenberg–Marquardt in the logarithms of the squares.
    fn fit(&self, chosen: Vec<usize>) -> Option<Fit> {
        let n = self.roots.len();
        let p = chosen.len();
        // Every term starts at the largest value the curve admits.
        let mut theta: Vec<f64> = chosen
            .iter()
            .map(|&t| {
                let bound = (0..n)
                    .map(|i| self.variances[i] / self.basis[t][i])
                    .fold(f64::INFINITY, f64::min);
                (0.7 * bound).ln()
            })
            .collect();
        let squares_of = |theta: &[f64]| -> Vec<f64> { theta.iter().map(|t| t.exp()).collect() };
        let objective = |theta: &[f64]| -> Option<(f64, f64)> {
            let (r, _, llt, log_det) = self.roots_at(&chosen, &squares_of(theta))?;
            let r = Mat::from_fn(n, 1, |i, _| r[i]);
            let solved = llt.solve(&r);
            let square: f64 = (0..n).map(|i| r[(i, 0)] * solved[(i, 0)]).sum();
            Some((square + log_det, square))
        };
        let (mut value, mut square) = objective(&theta)?;
        let mut damping = 1e-3;
        let mut information = Mat::<f64>::identity(p, p);
        for _ in 0..60 {
            let squares = squares_of(&theta);
            let (r, slope, llt, _) = self.roots_at(&chosen, &squares)?;
            let jacobian = Mat::from_fn(n, p, |i, k| {
                slope[i] * squares[k] * self.basis[chosen[k]][i]
            });
            let weighted = llt.solve(&jacobian);
            let r = Mat::from_fn(n, 1, |i, _| r[i]);
            information = jacobian.transpose() * &weighted;
            let right = weighted.transpose() * &r;
            let mut moved = false;
            for _ in 0..12 {
                let damped = Mat::from_fn(p, p, |i, j| {
                    information[(i, j)]
                        + if i == j {
                            damping * (information[(i, i)] + 1e-9)
                        } else {
                            0.0
                        }
                });
                let step = damped.llt(Side::Lower).ok()?.solve(&right);
                let trial: Vec<f64> = (0..p)
                    .map(|k| theta[k] + step[(k, 0)].clamp(-2.0, 2.0))
                    .collect();
                match objective(&trial) {
                    Some((v, s)) if v < value => {
                        moved = value - v > 1e-9;
                        theta = trial;
                        value = v;
                        square = s;
                        damping = (damping * 0.2).max(1e-9);
                        break;
                    }
                    _ => damping *= 5.0,
                }
            }
            if !moved {
                break;
            }
        }
        let squares = squares_of(&theta);
        let mean = self.mean(&chosen, &squares);
        // A term that vanished everywhere has left the combination.
        for (k, &t) in chosen.iter().enumerate() {
            let share = (0..n)
                .map(|i| squares[k] * self.basis[t][i] / mean[i])
                .fold(0.0, f64::max);
            if share < 1e-3 {
                return None;
            }
        }
        let covariance = information
            .llt(Side::Lower)
            .ok()?
            .solve(&Mat::<f64>::identity(p, p));
        Some(Fit {
            chosen,
            squares,
            covariance,
            residual_square: square,
            deviance: value,
        })
    }

    /// One linear step with the term added at zero: its square, and so what it cannot exceed.
    fn upper_limit(&self, best: &Fit, index: usize, probability: f64) -> Option<f64> {
        let (r, slope, llt, _) = self.roots_at(&best.chosen, &best.squares)?;
        let n = r.len();
        let p = best.chosen.len();
        let jacobian = Mat::from_fn(n, p + 1, |i, k| {
            slope[i]
                * if k < p {
                    best.squares[k] * self.basis[best.chosen[k]][i]
                } else {
                    self.basis[index][i] * self.variances[0] / self.basis[index][0]
                }
        });
        let weighted = llt.solve(&jacobian);
        let information = jacobian.transpose() * &weighted;
        let r = Mat::from_fn(n, 1, |i, _| r[i]);
        let right = weighted.transpose() * &r;
        let factor = information.llt(Side::Lower).ok()?;
        let step = factor.solve(&right);
        let variance = factor.solve(&Mat::<f64>::identity(p + 1, p + 1))[(p, p)];
        let unit = self.variances[0] / self.basis[index][0];
        let square =
            unit * (step[(p, 0)].max(0.0) + normal_quantile(probability) * variance.sqrt());
        (square.is_finite() && square > 0.0).then_some(square.sqrt())
    }
}

/// Allan variance of the sampled process of a unit coefficient.
fn unit_variance(term: Term, m: usize, sample_rate: f64) -> f64 {
    let tau = m as f64 / sample_rate;
    let mf = m as f64;
    match term {
        Term::Quantisation => 3.0 / (tau * tau),
        Term::White => 1.0 / tau,
        Term::Flicker => sampled_flicker(m),
        // Steps between samples instead of within them.
        Term::RandomWalk => tau / 3.0 * (1.0 + 0.5 / (mf * mf)),
        Term::Ramp => 0.5 * tau * tau,
        Term::GaussMarkov | Term::Sinusoid => 0.0,
    }
}

/// ∫ 2/s |H|² df for the sampled flicker density; 2 ln 2/π for m beyond 64, within 1e-4 (4/π · ½ at m = 1).
fn sampled_flicker(m: usize) -> f64 {
    if m > 64 {
        return 2.0 * LN_2 / PI;
    }
    let points = 256 * m;
    let step = 0.5 / points as f64;
    (0..points)
        .map(|k| {
            let f = (k as f64 + 0.5) * step;
            term_density(Term::Flicker, f, 1.0) * allan_response(m, f, 1.0) * step
        })
        .sum()
}
