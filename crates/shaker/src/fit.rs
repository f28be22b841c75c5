//! The two rigorous methods and what they give.

mod angles;
mod bending;
mod delays;
mod drift;
mod excess;
mod identifiability;
pub(crate) mod missing;
mod reproducibility;
mod supported;

pub use delays::OutputDelay;
pub use drift::GainDrift;
pub use identifiability::{AngleInformation, FrameTurn, Identifiability};
pub use reproducibility::{Reproducibility, SessionGain};
pub(crate) use supported::Supported;
pub use supported::{BetweenSessions, VarianceComponent};

use super::adjustment::{Adjustment, Deletion};
use super::budget::Budget;
use super::matrix::{AXES, Matrix, inverse, inverse_jacobian, to_real};
use super::observation::{
    Basis, OutputPhases, PhasorRow, Share, Spurious, SpuriousTable, UnmeasuredAt, ascending,
};
use super::unread_phases::{self, quadrature};
use faer::Mat;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::algebra::symmetric_eigen;
use proofmass_uncertainty::chi_squared_chance;
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding, Influence,
    SharedEffect,
};
use rayon::prelude::*;
use std::borrow::Cow;

/// Keys of the motion beside the excitation in a budget: as it was measured, and where nobody measured it.
pub(crate) const SPURIOUS_MOTION: &str = "spurious.motion";
pub(crate) const UNMEASURED_MOTION: &str = "unmeasured.motion";
/// Key of what is open where the phases of the outputs were not read.
const UNREAD_PHASES: &str = "unread.phases";

/// S at one frequency.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
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
#[non_exhaustive]
pub struct RunResidual {
    /// Name of the run.
    pub run: String,
    /// Session in which it was measured.
    pub session: Option<String>,
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
#[non_exhaustive]
pub struct AngleEstimate {
    /// Key of the input.
    pub key: String,
    /// A configuration that has it.
    pub configuration: super::Configuration,
    /// Estimated error in radians.
    pub value: f64,
    /// Its standard uncertainty after the data.
    pub standard_uncertainty: f64,
    /// Its standard uncertainty before, as it was used.
    pub prior: f64,
}

/// A fit over all frequencies.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
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
    /// What the runs tell of the mounting angles; `None` without such angles, or where every frequency has its own.
    pub identifiability: Option<Identifiability>,
    /// What the runs tell of the declared uncertainties.
    pub components: Vec<VarianceComponent>,
    /// Drifts of the gains in the order of the runs, of [`joint`].
    pub drifts: Vec<GainDrift>,
    /// Delays between the outputs, of [`joint`] from three frequencies on.
    pub delays: Vec<OutputDelay>,
    /// Motion of the bench that nobody measured, as the runs have it.
    pub motion: Vec<UnmeasuredAt>,
    /// Gains of the sessions against each other, of [`joint`] where the runs name two sessions or more.
    pub reproducibility: Option<Reproducibility>,
    pub(crate) scale: f64,
}

impl Fit {
    /// Probability of a χ² at least as large, were the budget right.
    pub fn p_value(&self) -> f64 {
        chi_squared_chance(self.chi_squared, self.dof as f64)
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
    let frequencies = ascending(rows.iter().map(|r| r.frequency));
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
        total.reproducibility = None;
        total.identifiability = None;
        total.frequencies.extend(fit.frequencies);
        total.chi_squared += fit.chi_squared;
        total.dof += fit.dof;
        total.runs.extend(fit.runs);
        total.angles.extend(fit.angles);
        total.findings.extend(fit.findings);
        total.components.extend(fit.components);
        total.motion.extend(fit.motion);
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
    let (declared, spurious) = declared(rows, spurious, budget)?;
    let (mut fit, supported) = reported(&declared, rows, &spurious, budget)?;
    fit.reproducibility = reproducibility::of(&supported, budget)?;
    fit.findings.extend(reproducibility::findings(
        rows,
        fit.reproducibility.as_ref(),
    ));
    fit.drifts = drift::drifts(&declared);
    fit.findings.extend(drift::finding(&fit.drifts));
    if !rows.iter().any(|r| r.is_free()) {
        fit.delays = delays::delays(&fit);
        fit.findings.extend(delays::finding(&fit));
    }
    Ok(fit)
}

fn adjust(rows: &[PhasorRow], spurious: &SpuriousTable, budget: &Budget) -> Result<Fit, Error> {
    let (declared, spurious) = declared(rows, spurious, budget)?;
    reported(&declared, rows, &spurious, budget).map(|(fit, _)| fit)
}

/// Rounds in which the size of the motion is estimated anew: a quiet bench needs three, since one step reaches a seventh.
const ROUNDS: usize = 4;

/// The adjustment by what is declared, and the motion of the bench in it: where nobody measured or stated that, it is as large
/// as the runs have it, so that no other error is judged against a guess.
pub(crate) fn declared<'a>(
    rows: &[PhasorRow],
    spurious: &'a SpuriousTable,
    budget: &Budget,
) -> Result<(Adjustment, Cow<'a, SpuriousTable>), Error> {
    let adjustment = Adjustment::new(rows, spurious, budget)?;
    let assumed = |e: &Spurious| e.basis.contains(&Basis::Assumed);
    if !spurious.entries.iter().any(assumed) {
        return Ok((adjustment, Cow::Borrowed(spurious)));
    }
    let (mut adjustment, mut table) = (adjustment, spurious.clone());
    for _ in 0..ROUNDS {
        let found = adjustment.components(budget)?.motion;
        let mut settled = true;
        for motion in found {
            let factors = motion.ways.map(|c| c.map_or(1.0, |c| c.ratio));
            table.scale(motion.share, adjustment.frequency_of(&motion), factors);
            settled &= factors.iter().all(|f| (0.5..2.0).contains(f));
        }
        adjustment = Adjustment::new(rows, &table, budget)?;
        if settled {
            break;
        }
    }
    Ok((adjustment, Cow::Owned(table)))
}

/// Everything that is told of a campaign: doubts by what is declared, the result by what the runs support.
fn reported(
    declared: &Adjustment,
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
) -> Result<(Fit, Supported), Error> {
    let supported = Supported::new(declared, rows, spurious, budget)?;
    let again = supported.adjusted()?;
    let adjustment = again.as_ref().unwrap_or(declared);
    let judged = match supported.as_declared(budget) {
        Some(budget) => Some((Adjustment::new(rows, spurious, &budget)?, budget)),
        None => None,
    };
    let (declared, budget) = judged.as_ref().map_or((declared, budget), |(a, b)| (a, b));
    let bent = bending::error(adjustment, &supported);
    let frequencies = frequency_fits(adjustment, &supported)?
        .into_par_iter()
        .enumerate()
        .map(|(f, fit)| fit.with(beside(adjustment, f, &supported.rows, bent.as_ref(), &fit)?))
        .collect::<Result<Vec<_>, Error>>()?;
    let deletions = match declared.deletions() {
        // Runs of which none can be spared have nothing to be compared with.
        Err(Error::Unobservable { .. }) => vec![],
        other => other?,
    };
    let runs = deletions
        .into_iter()
        .enumerate()
        .map(|(row, deletion)| {
            let f = declared.of_row[row];
            let scale = declared.scale;
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
                session: rows[row].session.clone(),
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
    let mut findings = angles::findings(declared, budget)?;
    // With what the runs support: readings noisier than declared are no missing tilt.
    findings.extend(missing::missing_inputs(
        adjustment,
        &supported.rows,
        &supported.spurious,
        &supported.budget,
    ));
    findings.extend(excess::finding(declared));
    let identifiability = Identifiability::new(declared, &frequencies, budget);
    let mut shared = shared_effects(adjustment)?;
    shared.extend(bent);
    let fit = Fit {
        frequencies,
        chi_squared: declared.chi_squared,
        dof: declared.dof(),
        runs,
        angles: angles::estimates(adjustment, rows, &supported.budget),
        findings,
        shared: Some(shared),
        identifiability,
        components: supported.components.clone(),
        drifts: vec![],
        delays: vec![],
        motion: supported.spurious.unmeasured(&declared.frequencies),
        reproducibility: None,
        scale: declared.scale,
    };
    Ok((fit, supported))
}

/// The result of every frequency by the adjustment alone.
pub(crate) fn frequency_fits(
    adjustment: &Adjustment,
    supported: &Supported,
) -> Result<Vec<FrequencyFit>, Error> {
    (0..adjustment.frequencies.len())
        .into_par_iter()
        .map(|f| frequency_fit(adjustment, f, supported))
        .collect()
}

/// How the sensitivities of different frequencies depend on each other through the draws g that all share:
/// C_fg = B_f B_gᵀ with B = C_sg C_gg^{−1/2}, exact because the normal equations have no other term between two
/// frequencies.
fn shared_effects(adjustment: &Adjustment) -> Result<Vec<SharedEffect>, Error> {
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
    let eigen = symmetric_eigen(&c, "eigenvalues of the shared errors")?;
    let largest = eigen.S()[common.len() - 1];
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
                adjustment.scale * sum / root
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
    supported: &Supported,
) -> Result<FrequencyFit, Error> {
    let Supported { rows, budget, .. } = supported;
    let sensitivity = adjustment.sensitivity(f);
    let exploitation = inverse(&sensitivity)?;
    let contributions = adjustment.contributions(f, rows, budget);
    let size = |elements: &[f64]| (0..18).map(|p| elements[19 * p]).sum::<f64>();
    let differs = |index: usize| match budget.inputs.get(index) {
        Some(input) => input.within_a_run(),
        None => index == budget.inputs.len(),
    };
    let readings: f64 = contributions
        .iter()
        .enumerate()
        .filter(|(index, _)| differs(*index))
        .map(|(_, elements)| size(elements))
        .sum();
    let mut influences = Vec::with_capacity(contributions.len());
    for (index, elements) in contributions.into_iter().enumerate() {
        if elements.iter().all(|&v| v == 0.0) {
            continue;
        }
        let share = size(&elements) / readings;
        let (key, description, evaluation, distribution, dof) = match budget.inputs.get(index) {
            Some(i) => (
                i.key.clone(),
                i.description.clone(),
                i.evaluation,
                i.distribution.name().to_owned(),
                supported.dof(f, Some(index), share),
            ),
            None if index == budget.inputs.len() => (
                "phasor.noise".to_owned(),
                "noise of the sine approximations".to_owned(),
                Evaluation::A,
                "normal".to_owned(),
                supported.dof(f, None, share),
            ),
            None if index == budget.inputs.len() + 1 => (
                SPURIOUS_MOTION.to_owned(),
                "measurement of the spurious motion".to_owned(),
                Evaluation::A,
                "normal".to_owned(),
                supported.spurious.dof_at(adjustment.frequencies[f]),
            ),
            None => {
                let share = Share::ALL[index - budget.inputs.len() - 2];
                (
                    format!("{UNMEASURED_MOTION}.{}", share.name()),
                    share.description(),
                    Evaluation::B,
                    "normal".to_owned(),
                    supported.motion_dof(f, share),
                )
            }
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
    let estimate = Estimate::new(
        components("S", budget.output.sensitivity(), &sensitivity),
        influences,
    )?;
    let inverse_estimate = estimate.propagate(
        components("A", budget.output.exploitation(), &exploitation),
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

/// What is uncertain of a result beside the adjustment, and no part of what its Monte Carlo trials check.
fn beside(
    adjustment: &Adjustment,
    f: usize,
    rows: &[PhasorRow],
    bent: Option<&SharedEffect>,
    fit: &FrequencyFit,
) -> Result<Vec<Influence>, Error> {
    let bending = bent.map(|bent| bending::influence(bent, f)).transpose()?;
    let all = bending.into_iter();
    Ok(all.chain(unread(adjustment, f, rows, fit)?).collect())
}

/// What moduli leave open where no phase was read: the parts of the cross terms that are out of phase with the main term of their output,
/// and their squares in what is in phase.
fn unread(
    adjustment: &Adjustment,
    f: usize,
    rows: &[PhasorRow],
    fit: &FrequencyFit,
) -> Result<Option<Influence>, Error> {
    let here = (0..rows.len()).filter(|&i| adjustment.of_row[i] == f);
    let (of, predictions): (Vec<&PhasorRow>, Vec<[Complex64; 3]>) =
        here.map(|i| (&rows[i], adjustment.predicted(i))).unzip();
    if !of.iter().any(|r| r.phases == OutputPhases::Unread) {
        return Ok(None);
    }
    let known = fit.estimate.covariance();
    let mut variance = [0.0; 18];
    for j in 0..3 {
        let term = |axis: usize| 2 * (3 * axis + j);
        let across = (0..3).filter(|axis| *axis != j);
        let u = across.clone().map(|a| known.standard_uncertainty(term(a)));
        let main = fit.sensitivity[j][j].norm();
        let out_of_phase = quadrature(&of, &predictions, j, u.fold(0.0, f64::max))
            .unwrap_or(unread_phases::ASSUMED * main);
        for axis in 0..3 {
            // |p + j q| = p + q²/2p, with p a share of the main term.
            variance[term(axis)] = (out_of_phase.powi(2) / main).powi(2);
        }
        for axis in across {
            variance[term(axis) + 1] = out_of_phase.powi(2);
        }
    }
    let elements: Vec<f64> = (0..18 * 18)
        .map(|k| {
            if k / 18 == k % 18 {
                variance[k / 18]
            } else {
                0.0
            }
        })
        .collect();
    Ok(Some(Influence {
        key: UNREAD_PHASES.to_owned(),
        description: "cross terms out of phase, which moduli do not tell".to_owned(),
        evaluation: Evaluation::B,
        distribution: "normal".to_owned(),
        dof: DegreesOfFreedom::INFINITE,
        effect: Effect::Joint {
            covariance: Covariance::try_from_rows(18, &elements)?,
        },
    }))
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

impl FrequencyFit {
    /// The same S with an uncertainty whose interval reaches another one: U² = (k u)² + ΔS², component by component.
    ///
    /// For runs about which it is not decided whether they belong.
    ///
    /// # Errors
    /// As [`Estimate::new`].
    pub fn reaching(&self, other: &Matrix, description: &str) -> Result<Self, Error> {
        let (here, there) = (to_real(&self.sensitivity), to_real(other));
        let d: Vec<f64> = (0..18).map(|p| (there[p] - here[p]) / 1.959_964).collect();
        let elements = (0..18 * 18).map(|k| d[k / 18] * d[k % 18]).collect();
        self.with(vec![Influence {
            key: "undecided.runs".to_owned(),
            description: description.to_owned(),
            evaluation: Evaluation::B,
            distribution: "two values".to_owned(),
            dof: DegreesOfFreedom::INFINITE,
            effect: Effect::Joint {
                covariance: Covariance::try_from_rows(18, &symmetric(elements))?,
            },
        }])
    }

    /// The same S with more that is uncertain about it.
    fn with(&self, more: Vec<Influence>) -> Result<Self, Error> {
        if more.is_empty() {
            return Ok(self.clone());
        }
        let influences = [self.estimate.influences().to_vec(), more].concat();
        let estimate = Estimate::new(self.estimate.components().to_vec(), influences)?;
        let inverse_estimate = estimate.propagate(
            self.inverse_estimate.components().to_vec(),
            &inverse_jacobian(&self.exploitation),
        )?;
        Ok(Self {
            estimate,
            inverse_estimate,
            ..self.clone()
        })
    }
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
