//! The two rigorous methods and what they give.

use super::adjustment::{Adjustment, Deletion};
use super::budget::{Acts, Budget};
use super::matrix::{AXES, Matrix, inverse, inverse_jacobian, to_real};
use super::observation::{PhasorRow, SpuriousTable};
use faer::{Mat, Side};
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding, Influence,
    Severity, SharedEffect,
};
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// S at one frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct FrequencyFit {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Sensitivity S in V/(m/s²).
    pub sensitivity: Matrix,
    /// Exploitation A = S⁻¹ in (m/s²)/V.
    pub exploitation: Matrix,
    /// The 18 reals `S.xx.re`, `S.xx.im`, `S.xy.re` … with one influence per input of the budget.
    pub estimate: Estimate,
    /// The 18 reals `A.xx.re` …, carried over by dA = −A dS A.
    pub inverse_estimate: Estimate,
}

/// One run as the fit sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct RunResidual {
    /// Name of the run.
    pub run: String,
    /// Index of its row.
    pub row: usize,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Inclination and rotation in radians.
    pub configuration: super::Configuration,
    /// Measured minus predicted from all other runs, per output, V/(m/s²).
    pub prediction_error: [Complex64; 3],
    /// The same over the root of its own variance: the studentised residuals, real and imaginary.
    pub studentised: [[f64; 2]; 3],
    /// χ² of the six together, six degrees of freedom.
    pub statistic: f64,
    /// Largest change of a component of S when the run is left out, in its standard uncertainties.
    pub influence: f64,
    /// Change of S when the run is left out, 18 reals, V/(m/s²).
    pub change: Vec<f64>,
    /// Covariance of the prediction error in the units of the statistic, for tests of alternatives.
    pub(crate) deletion: Deletion,
}

/// One mounting angle as the data see it.
#[derive(Clone, Debug, PartialEq)]
pub struct AngleEstimate {
    /// Key of the input.
    pub key: String,
    /// A configuration that has it.
    pub configuration: super::Configuration,
    /// Estimated error in radians.
    pub value: f64,
    /// Its standard uncertainty after the data.
    pub standard_uncertainty: f64,
    /// Its standard uncertainty before.
    pub prior: f64,
}

/// A fit over all frequencies.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Frequencies in ascending order.
    pub frequencies: Vec<FrequencyFit>,
    /// Σ over the frequencies of the weighted sum of squares.
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub dof: usize,
    /// Runs in the order of the rows.
    pub runs: Vec<RunResidual>,
    /// Mounting angles (per frequency for [`complex`], one set for [`joint`]).
    pub angles: Vec<AngleEstimate>,
    /// Doubts.
    pub findings: Vec<Finding>,
    /// What the sensitivities of the frequencies have in common, in the order of the 18 reals; `None` where every
    /// frequency was fitted by itself and nobody knows.
    pub shared: Option<Vec<SharedEffect>>,
    pub(crate) scale: f64,
}

impl Fit {
    /// Probability of a χ² at least as large, were the budget right.
    pub fn p_value(&self) -> f64 {
        upper_tail(self.chi_squared, self.dof as f64)
    }

    /// The result of one frequency.
    pub fn at(&self, frequency: f64) -> Option<&FrequencyFit> {
        self.frequencies
            .iter()
            .find(|f| (f.frequency / frequency - 1.0).abs() < 1e-9)
    }
}

/// Frequency by frequency: generalised least squares on signed phasors with the joint covariance of the budget,
/// angles as errors in variables with their priors.
///
/// ŝ = argmin (y − X s)ᵀ V⁻¹ (y − X s), V = Σ over inputs and draws of J u² Jᵀ.
///
/// **Units** V/(m/s²).
///
/// **Accuracy** 95 % regions hold the truth in 95 % of simulated campaigns
/// (`coverage_complex_without_and_with_spurious_motion`).
///
/// **Source** `[GUM]` 5.2, `[S2]` 6; errors in variables after `[ISO28037]` 10.
///
/// # Errors
/// [`Error::TooFew`] below three configurations at a frequency, [`Error::Unobservable`] when they do not span
/// three dimensions, [`Error::NotFinite`] for a row with a NaN.
pub fn complex(
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
) -> Result<Fit, Error> {
    let mut frequencies: Vec<f64> = rows.iter().map(|r| r.frequency).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup();
    let fits: Vec<Fit> = frequencies
        .par_iter()
        .map(|&f| {
            let index: Vec<usize> = (0..rows.len())
                .filter(|&i| rows[i].frequency == f)
                .collect();
            let subset: Vec<PhasorRow> = index.iter().map(|&i| rows[i].clone()).collect();
            let mut fit = adjust(&subset, spurious, budget)?;
            for run in &mut fit.runs {
                run.row = index[run.row];
            }
            Ok(fit)
        })
        .collect::<Result<_, Error>>()?;
    let mut fits = fits.into_iter();
    let mut total = fits.next().ok_or(Error::TooFew {
        name: "configurations at a frequency",
        needed: 3,
        got: 0,
    })?;
    for fit in fits {
        total.shared = None;
        total.frequencies.extend(fit.frequencies);
        total.chi_squared += fit.chi_squared;
        total.dof += fit.dof;
        total.runs.extend(fit.runs);
        total.angles.extend(fit.angles);
        total.findings.extend(fit.findings);
    }
    total.runs.sort_by_key(|r| r.row);
    Ok(total)
}

/// All frequencies at once: mounting angles and every other error that the frequencies share are one set of
/// unknowns with their priors, estimated together with all S(f).
///
/// What no data can tell is a rotation of the whole device against the bench: it keeps its prior.
///
/// **Accuracy** `coverage_joint_and_its_gain`.
///
/// # Errors
/// As [`complex`].
pub fn joint(rows: &[PhasorRow], spurious: &SpuriousTable, budget: &Budget) -> Result<Fit, Error> {
    adjust(rows, spurious, budget)
}

fn adjust(rows: &[PhasorRow], spurious: &SpuriousTable, budget: &Budget) -> Result<Fit, Error> {
    let adjustment = Adjustment::new(rows, spurious, budget)?;
    let (chi_squared, dof) = (adjustment.chi_squared, adjustment.dof());
    // By how much the variance of the residuals exceeds what the budget allows; zero within one case in a thousand.
    let excess = if upper_tail(chi_squared, dof as f64) < 1e-3 {
        (chi_squared / dof as f64 - 1.0).max(0.0)
    } else {
        0.0
    };
    let frequencies = (0..adjustment.frequencies.len())
        .map(|f| frequency_fit(&adjustment, f, rows, (spurious, budget), excess))
        .collect::<Result<Vec<_>, _>>()?;
    let deletions = match adjustment.deletions() {
        // Runs of which none can be spared have nothing to be compared with.
        Err(Error::Unobservable { .. }) => vec![],
        other => other?,
    };
    let runs = deletions
        .into_iter()
        .enumerate()
        .map(|(row, deletion)| {
            let f = adjustment.of_row[row];
            let scale = adjustment.scale;
            let studentised = std::array::from_fn(|j| {
                let e = deletion.prediction_error[j] / scale;
                let v = &deletion.covariance;
                [
                    e.re / v[2 * j][2 * j].sqrt(),
                    e.im / v[2 * j + 1][2 * j + 1].sqrt(),
                ]
            });
            let covariance = frequencies[f].estimate.covariance();
            let influence = deletion
                .influence
                .iter()
                .enumerate()
                .map(|(p, c)| (c / covariance.standard_uncertainty(p)).abs())
                .fold(0.0, f64::max);
            RunResidual {
                run: rows[row].run.clone(),
                row,
                frequency: rows[row].frequency,
                configuration: rows[row].configuration,
                prediction_error: deletion.prediction_error,
                studentised,
                statistic: deletion.statistic,
                influence,
                change: deletion.influence.clone(),
                deletion,
            }
        })
        .collect();
    let (angles, mut findings) = angles(&adjustment, rows, budget)?;
    findings.extend(missing_angles(&adjustment, rows, spurious, budget));
    if excess > 0.0 {
        let place = if frequencies.len() == 1 {
            format!("at {} Hz", adjustment.frequencies[0])
        } else {
            "over all frequencies".to_owned()
        };
        findings.push(
            Finding::new(
                Severity::Warning,
                "excess-residuals",
                format!("the residuals {place} are larger than the budget allows"),
            )
            .evidence(format!(
                "χ² = {chi_squared:.1} with {dof} degrees of freedom, a factor of {:.2} in u",
                (chi_squared / dof as f64).sqrt()
            ))
            .advice(
                "the uncertainties are enlarged by that factor; look at the runs with the largest statistic, then at the \
                 repeatability in the budget",
            ),
        );
    }
    Ok(Fit {
        frequencies,
        chi_squared,
        dof,
        runs,
        angles,
        findings,
        shared: Some(shared_effects(&adjustment, excess)?),
        scale: adjustment.scale,
    })
}

/// How the sensitivities of different frequencies depend on each other through the draws g that all share:
/// C_fg = B_f B_gᵀ with B = C_sg C_gg^{−1/2}, exact because the normal equations have no other term between two
/// frequencies. An excess of the residuals enlarges it as it enlarges the rest.
fn shared_effects(adjustment: &Adjustment, excess: f64) -> Result<Vec<SharedEffect>, Error> {
    let offset = adjustment.first_draw();
    let common: Vec<usize> = (0..adjustment.draws.len())
        .filter(|&d| adjustment.draws[d].frequency.is_none())
        .map(|d| offset + d)
        .collect();
    if common.is_empty() {
        return Ok(Vec::new());
    }
    let c = Mat::from_fn(common.len(), common.len(), |i, j| {
        adjustment.covariance(common[i], common[j])
    });
    let eigen = c
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| Error::NotConverged {
            name: "eigenvalues of the shared errors",
            iterations: 0,
            step: f64::INFINITY,
        })?;
    let largest = eigen.S()[common.len() - 1];
    let size = adjustment.scale * (1.0 + excess).sqrt();
    Ok((0..common.len())
        .filter(|&e| eigen.S()[e] > 1e-14 * largest)
        .map(|e| {
            let root = eigen.S()[e].sqrt();
            let along = |p: usize| -> f64 {
                let sum: f64 = common
                    .iter()
                    .enumerate()
                    .map(|(i, &g)| adjustment.covariance(p, g) * eigen.U()[(i, e)])
                    .sum();
                size * sum / root
            };
            SharedEffect {
                key: format!("adjustment.{}", e + 1),
                effects: (0..adjustment.frequencies.len())
                    .map(|f| (18 * f..18 * f + 18).map(along).collect())
                    .collect(),
            }
        })
        .collect())
}

fn frequency_fit(
    adjustment: &Adjustment,
    f: usize,
    rows: &[PhasorRow],
    (spurious, budget): (&SpuriousTable, &Budget),
    excess: f64,
) -> Result<FrequencyFit, Error> {
    let sensitivity = adjustment.sensitivity(f);
    let exploitation = inverse(&sensitivity)?;
    let contributions = adjustment.contributions(f, rows, budget);
    let mut influences = Vec::with_capacity(contributions.len() + 1);
    let mut total = vec![0.0; 18 * 18];
    for (index, elements) in contributions.into_iter().enumerate() {
        if elements.iter().all(|&v| v == 0.0) {
            continue;
        }
        for (sum, v) in total.iter_mut().zip(&elements) {
            *sum += v;
        }
        let (key, description, evaluation, distribution, dof) = match budget.inputs.get(index) {
            Some(i) => (
                i.key.clone(),
                i.description.clone(),
                i.evaluation,
                i.distribution.name().to_owned(),
                i.dof,
            ),
            None if index == budget.inputs.len() => (
                "phasor.noise".to_owned(),
                "noise of the sine approximations".to_owned(),
                Evaluation::A,
                "normal".to_owned(),
                DegreesOfFreedom::INFINITE,
            ),
            None => (
                "spurious.motion".to_owned(),
                "measurement of the spurious motion".to_owned(),
                Evaluation::A,
                "normal".to_owned(),
                spurious.dof_at(adjustment.frequencies[f]),
            ),
        };
        influences.push(Influence {
            key,
            description,
            evaluation,
            distribution,
            dof,
            effect: Effect::Joint {
                covariance: Covariance::try_from_rows(18, &symmetric(elements))?,
            },
        });
    }
    // What contradicts the budget by this much is no part of it: the residuals say how large it is, not where.
    if excess > 0.0 {
        total.iter_mut().for_each(|v| *v *= excess);
        influences.push(Influence {
            key: "excess.residuals".to_owned(),
            description: "residuals beyond the budget".to_owned(),
            evaluation: Evaluation::A,
            distribution: "normal".to_owned(),
            dof: DegreesOfFreedom::new(adjustment.dof() as f64)
                .unwrap_or(DegreesOfFreedom::INFINITE),
            effect: Effect::Joint {
                covariance: Covariance::try_from_rows(18, &symmetric(total))?,
            },
        });
    }
    let estimate = Estimate::new(components("S", "V/(m/s²)", &sensitivity), influences)?;
    let inverse_estimate = estimate.propagate(
        components("A", "(m/s²)/V", &exploitation),
        &inverse_jacobian(&exploitation),
    )?;
    Ok(FrequencyFit {
        frequency: adjustment.frequencies[f],
        sensitivity,
        exploitation,
        estimate,
        inverse_estimate,
    })
}

/// Rounding makes the two triangles of a sum of outer products differ in the last digit.
fn symmetric(mut v: Vec<f64>) -> Vec<f64> {
    for p in 0..18 {
        for q in 0..p {
            let mean = 0.5 * (v[18 * p + q] + v[18 * q + p]);
            (v[18 * p + q], v[18 * q + p]) = (mean, mean);
        }
    }
    v
}

fn components(symbol: &str, unit: &str, m: &Matrix) -> Vec<Component> {
    let values = to_real(m);
    (0..18)
        .map(|p| {
            let (i, j) = (p / 6, p / 2 % 3);
            let part = if p % 2 == 0 { "re" } else { "im" };
            let name = format!("{symbol}.{}{}.{part}", AXES[i], AXES[j]);
            Component::new(name, unit, values[p])
        })
        .collect()
}

/// Standard uncertainty that a missing angle is tried with: ±0.1° rectangular.
const TRIAL: f64 = 0.1 * std::f64::consts::PI / 180.0 / 1.732_050_807_568_877_2;

/// Angles that a glued device on wedges has and the budget does not: what the runs say of them.
fn missing_angles(
    adjustment: &Adjustment,
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
) -> Vec<Finding> {
    let declared = |acts: Acts| {
        let of = |i: &&super::ShakerInput| i.acts == acts && i.standard_uncertainty() > 0.0;
        budget.inputs.iter().find(of)
    };
    // A budget without a gluing is not one of a glued device.
    if declared(Acts::Rotation).is_none() || declared(Acts::Tilt).is_some() {
        return vec![];
    }
    let Some(score) = adjustment.score(Acts::Tilt, TRIAL, rows, spurious, budget) else {
        return vec![];
    };
    let p = upper_tail(score.statistic, score.dof);
    let size = score.variance.max(0.0).sqrt().to_degrees();
    let seen = p < 1e-4;
    vec![
        Finding::new(
            if seen {
                Severity::Decision
            } else {
                Severity::Note
            },
            "missing-gluing-tilt",
            if seen {
                "the budget has no tilt of the glued device, and the runs want one".to_owned()
            } else {
                "the budget has no tilt of the glued device".to_owned()
            },
        )
        .evidence(format!(
            "the device may turn on the wedge face but not tilt in its adhesive; the runs want u = {size:.3}° per gluing \
             (score χ² = {:.1}, ν = {:.1}, p = {p:.1e})",
            score.statistic, score.dof
        ))
        .advice(
            "declare `gluing.tilt` (acts = \"tilt\") with inclination and rotation, and `device.tilt.mean` with no key for \
             what all gluings have in common: no data can show that, and S_xz, S_yz, S_zx, S_zy carry it undiminished",
        ),
    ]
}

/// Angles after the data, and whether the data agree with their priors.
fn angles(
    adjustment: &Adjustment,
    rows: &[PhasorRow],
    budget: &Budget,
) -> Result<(Vec<AngleEstimate>, Vec<Finding>), Error> {
    let offset = 18 * adjustment.frequencies.len();
    let (mut estimates, mut findings) = (vec![], vec![]);
    for (index, input) in budget.inputs.iter().enumerate() {
        if !input.acts.is_angle() {
            continue;
        }
        let draws: Vec<usize> = (0..adjustment.draws.len())
            .filter(|&d| adjustment.draws[d].input == Some(index))
            .collect();
        let prior = input.standard_uncertainty();
        for &d in &draws {
            let p = offset + d;
            let about = ["x", "y"][adjustment.draws[d].part % 2];
            estimates.push(AngleEstimate {
                key: match input.acts {
                    Acts::Tilt => format!("{}.{about}", input.key),
                    _ => input.key.clone(),
                },
                configuration: rows[adjustment.draws[d].row].configuration,
                value: adjustment.parameters[p] * prior,
                standard_uncertainty: adjustment.covariance(p, p).sqrt() * prior,
                prior,
            });
        }
        // Under the prior the estimates have covariance 1 − C; the directions the data see well are tested.
        let m = draws.len();
        if m == 0 {
            continue;
        }
        let spread = Mat::from_fn(m, m, |a, b| {
            let c = adjustment.covariance(offset + draws[a], offset + draws[b]);
            f64::from(a == b) - c
        });
        let eigen = spread
            .self_adjoint_eigen(Side::Lower)
            .map_err(|_| Error::NotConverged {
                name: "eigenvalues of the angles",
                iterations: 0,
                step: f64::INFINITY,
            })?;
        let (mut statistic, mut seen) = (0.0, 0usize);
        for e in 0..m {
            let lambda = eigen.S()[e];
            if lambda > 0.05 {
                let along: f64 = (0..m)
                    .map(|a| eigen.U()[(a, e)] * adjustment.parameters[offset + draws[a]])
                    .sum();
                statistic += along * along / lambda;
                seen += 1;
            }
        }
        if seen == 0 {
            continue;
        }
        let nu = seen as f64;
        let ratio = (statistic / nu).sqrt();
        let evidence = format!(
            "the data want {ratio:.2} times the declared {:.3}°: χ² = {statistic:.1} with {seen} degrees of freedom",
            prior.to_degrees()
        );
        if upper_tail(statistic, nu) < 1e-4 {
            findings.push(
                Finding::new(
                    Severity::Decision,
                    "angle-prior-too-small",
                    format!("the mounting angles of {} scatter more than declared", input.key),
                )
                .evidence(evidence)
                .advice("declare a larger uncertainty, or look for a configuration that was mounted wrongly"),
            );
        } else if 1.0 - upper_tail(statistic, nu) < 1e-4 {
            findings.push(
                Finding::new(
                    Severity::Note,
                    "angle-prior-too-large",
                    format!(
                        "the mounting angles of {} scatter less than declared",
                        input.key
                    ),
                )
                .evidence(evidence)
                .advice("a smaller declared uncertainty would be defensible"),
            );
        }
    }
    Ok((estimates, findings))
}

/// P(χ²_ν ≥ x).
pub(crate) fn upper_tail(x: f64, nu: f64) -> f64 {
    match ChiSquared::new(nu) {
        Ok(d) => d.sf(x),
        Err(_) => 1.0,
    }
}
