//! The whole job: runs, certificate, corrections and budget in; results side by side with their doubts out.

mod doubts;
mod request;
mod statement;
mod undecided;

pub use request::{ShakerCampaign, ShakerMethod};
pub use undecided::Contested;

use super::budget::Budget;
use super::datasheet::{Datasheet, SheetDeviation};
use super::derived::{
    Expanded, PROBABILITY, SensitivityTerm, expanded, intrinsic, misalignment, normalised, terms,
    transverse,
};
use super::diagnosis::{SuspectRun, diagnose};
use super::fit::{
    AngleEstimate, Fit, FrequencyFit, Identifiability, Reproducibility, SPURIOUS_MOTION,
    UNMEASURED_MOTION, VarianceComponent, complex, joint,
};
use super::geometry::Configuration;
use super::observation::{Correction, PhasorRow, UnmeasuredAt, ascending};
use super::published::{self, MagnitudeRow, PublishedFit, SpuriousMagnitude};
use super::screening::{MOTION, Observations, is_certified, observations, with_motion};
use super::spurious::pooled;
use crate::findings;
use proofmass_core::Error;
use proofmass_dynamic::FrequencyResponse;
use proofmass_uncertainty::{
    DegreesOfFreedom, Estimate, Finding, SharedEffect, welch_satterthwaite,
};
use rayon::prelude::*;
use serde::Serialize;

/// Everything about S at one frequency.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FrequencyResult {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Terms of S, row by row.
    pub sensitivity: Vec<SensitivityTerm>,
    /// Terms of A, row by row.
    pub exploitation: Vec<SensitivityTerm>,
    /// Real parts of S_ij/S_ii.
    pub normalised: Vec<Expanded>,
    /// Real parts of A_ij/A_ii.
    pub normalised_exploitation: Vec<Expanded>,
    /// Transverse sensitivity and its direction per output.
    pub transverse: Vec<Expanded>,
    /// Leaning of each sensitive axis.
    pub misalignment: Vec<Expanded>,
    /// What no rotation of the device can change.
    pub intrinsic: Vec<Expanded>,
    /// S as an estimate with its joint covariance and influences.
    pub estimate: Estimate,
    /// A likewise.
    pub inverse_estimate: Estimate,
}

/// One run in one result, for a plot on the sphere of directions.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RunResult {
    /// Name of the run.
    pub run: String,
    /// Session in which it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub session: Option<String>,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Direction of the excitation in the device.
    pub direction: [f64; 3],
    /// Measured minus predicted from the other runs, per output, real and imaginary, V/(m/s²).
    pub prediction_error: [[f64; 2]; 3],
    /// The same over its standard deviation.
    pub studentised: [[f64; 2]; 3],
    /// χ² with six degrees of freedom.
    pub statistic: f64,
    /// Largest change of S without the run, in standard uncertainties.
    pub influence: f64,
}

/// One mounting angle.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AngleResult {
    /// Key of the input.
    pub key: String,
    /// Mounting.
    pub configuration: Configuration,
    /// Estimated error in radians.
    pub value: f64,
    /// Standard uncertainty after the data.
    pub standard_uncertainty: f64,
    /// Declared standard uncertainty.
    pub prior: f64,
}

/// The published method at one frequency.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PublishedResult {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Matrices on magnitudes.
    pub fit: PublishedFit,
}

/// One method with one correction.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct MethodResult {
    /// The method.
    pub method: ShakerMethod,
    /// Label of the correction.
    pub correction: String,
    /// Results of the rigorous methods.
    pub frequencies: Vec<FrequencyResult>,
    /// Results of the published method.
    pub published: Vec<PublishedResult>,
    /// χ² and its degrees of freedom; `None` for the published method.
    pub chi_squared: Option<(f64, usize)>,
    /// Runs.
    pub runs: Vec<RunResult>,
    /// Mounting angles.
    pub angles: Vec<AngleResult>,
    /// Doubts that belong to this result.
    pub findings: Vec<Finding>,
    /// What the datasheet promises, and what was measured of it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub datasheet: Vec<SheetDeviation>,
    /// What the frequencies have in common, where the method knows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) shared: Option<Vec<SharedEffect>>,
    /// What the runs tell of the mounting and what no run can, for the joint method.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub identifiability: Option<Identifiability>,
    /// What the runs tell of the declared uncertainties, and what was used.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub components: Vec<VarianceComponent>,
    /// Motion of the bench that nobody measured, as the runs have it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub motion: Vec<UnmeasuredAt>,
    /// Gains of the sessions against each other, of the joint method where the runs name two sessions or more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reproducibility: Option<Reproducibility>,
}

impl MethodResult {
    /// S over frequency as K = Sᵀ of the column convention; `None` for a method without a covariance.
    ///
    /// # Errors
    /// As [`FrequencyResponse::from_row_convention`].
    pub fn frequency_response(&self) -> Result<Option<FrequencyResponse>, Error> {
        if self.frequencies.is_empty() {
            return Ok(None);
        }
        let points: Vec<(f64, &Estimate)> = self
            .frequencies
            .iter()
            .map(|f| (f.frequency, &f.estimate))
            .collect();
        FrequencyResponse::from_row_convention(&points, self.shared.clone()).map(Some)
    }
}

/// Difference of one term between two results.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct TermDifference {
    /// Labels of the two corrections.
    pub between: [String; 2],
    /// Frequency in Hz.
    pub frequency: f64,
    /// Term as letters.
    pub term: String,
    /// Relative difference of the moduli.
    pub relative: f64,
    /// The difference over the expanded uncertainty it has from the two measurements of the spurious motion:
    /// all else is common to both. `None` when neither has an uncertainty.
    pub e_n: Option<f64>,
}

/// What [`calibrate`] gives.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ShakerCalibration {
    /// Methods and corrections side by side.
    pub results: Vec<MethodResult>,
    /// Differences of the main terms between the corrections, for the first rigorous method.
    pub differences: Vec<TermDifference>,
    /// Runs that contradict the others.
    pub suspects: Vec<SuspectRun>,
    /// Those of them that the results are without.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub set_aside: Vec<String>,
    /// The results with them beside those without, at their frequencies.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub contested: Vec<Contested>,
    /// Doubts about the campaign.
    pub findings: Vec<Finding>,
}

/// Calibrates a triaxial accelerometer from a campaign on the shaker.
///
/// Frequencies that the certificate does not reach, or that have too few directions, are left out with a finding
/// that names their runs. Uncertainties of the spurious motion from few repeats are pooled ([`SpuriousTable::pooled`](super::observation::SpuriousTable::pooled)).
/// Runs that contradict the others are named; the result is without them, and at their frequencies
/// its intervals reach the result with them until they are in `excluded`. Errors that are larger in the runs than
/// declared have the uncertainty that the runs support. Motion of the bench that the corrections do not have is taken as
/// [`UnmeasuredMotion`](crate::UnmeasuredMotion) has it: an unknown of each wedge and frequency, as large as the runs tell.
///
/// # Errors
/// As [`complex`], when no frequency is left.
pub fn calibrate(campaign: &ShakerCampaign) -> Result<ShakerCalibration, Error> {
    let Observations {
        rows,
        budget,
        mut findings,
    } = observations(campaign)?;
    let none = [Correction::none()];
    let (pooled, scatter) = pooled(&campaign.corrections);
    findings.extend(scatter);
    let corrections: &[Correction] = if pooled.is_empty() { &none } else { &pooled };
    let places: Vec<(f64, f64)> = rows
        .iter()
        .map(|r| (r.configuration.inclination, r.frequency))
        .collect();
    let stated = campaign.unmeasured_motion;
    if let Some(motion) = stated {
        motion.check()?;
    }
    // What moved beside the excitation, known or not, must not look like a fault of a run.
    let best = corrections
        .iter()
        .max_by_key(|c| c.table.entries.len())
        .unwrap_or(&corrections[0]);
    let completed = |c: &Correction| c.table.completed(places.iter().copied(), stated);
    let plan = campaign.plan.as_deref();
    let (suspects, doubts) = diagnose(&rows, &completed(best), &budget, plan)?;
    let corrections: &[Completed] = &corrections
        .iter()
        .map(|c| Completed {
            measured: c,
            whole: Correction {
                label: c.label.clone(),
                table: completed(c),
            },
        })
        .collect::<Vec<_>>();
    findings.extend(doubts);
    findings.extend(
        corrections
            .iter()
            .filter_map(|c| doubts::gaps(c.measured, &rows)),
    );
    let (kept, set_aside) = undecided::parted(&rows, &suspects);
    let mut results = methods(campaign, corrections, &kept, &budget)?;
    let mut contested = vec![];
    if !set_aside.is_empty() {
        for correction in corrections {
            contested.extend(undecided::contested(
                &correction.whole,
                &rows,
                &set_aside,
                &mut results,
                &budget,
            )?);
        }
        findings.push(undecided::finding(&set_aside, &contested));
    }
    findings.extend(doubts::exact_motion(&campaign.corrections));
    findings.extend(doubts::unmeasured_motion(&results, stated));
    findings.extend(doubts::high_frequencies(&results));
    let mut calibration = ShakerCalibration {
        differences: differences(&results),
        results,
        suspects,
        set_aside,
        contested,
        findings,
    };
    if let Some(sheet) = &campaign.datasheet {
        calibration.hold_against(sheet)?;
        let found = doubts::against_datasheet(sheet, &calibration.results);
        calibration.findings.extend(found);
    }
    Ok(calibration)
}

impl ShakerCalibration {
    /// Holds every result against a datasheet, with the uncertainties that it has now.
    ///
    /// # Errors
    /// As [`Datasheet::against`].
    pub fn hold_against(&mut self, sheet: &Datasheet) -> Result<(), Error> {
        for result in &mut self.results {
            result.datasheet = sheet.against(result)?;
        }
        Ok(())
    }
}

/// A correction as it was measured, and with what is assumed where it was not.
struct Completed<'a> {
    measured: &'a Correction,
    whole: Correction,
}

/// Every method with every correction.
fn methods(
    campaign: &ShakerCampaign,
    corrections: &[Completed<'_>],
    rows: &[PhasorRow],
    budget: &Budget,
) -> Result<Vec<MethodResult>, Error> {
    let with = |method: ShakerMethod| corrections.iter().map(move |c| (method, c));
    let all: Vec<(ShakerMethod, &Completed<'_>)> =
        campaign.methods.iter().copied().flat_map(with).collect();
    let results: Vec<Result<MethodResult, Error>> = all
        .into_par_iter()
        .map(|(method, correction)| {
            let Completed { measured, whole } = correction;
            let table = &whole.table;
            let budget = &with_motion(budget, table, rows)?;
            match method {
                ShakerMethod::PublishedMagnitude => by_magnitudes(campaign, rows, measured),
                ShakerMethod::Complex => rigorous(method, whole, complex(rows, table, budget)?),
                ShakerMethod::Joint => rigorous(method, whole, joint(rows, table, budget)?),
            }
        })
        .collect();
    // The first error of all, whichever came first in time.
    results.into_iter().collect()
}

fn rigorous(
    method: ShakerMethod,
    correction: &Correction,
    fit: Fit,
) -> Result<MethodResult, Error> {
    let chi_squared = Some((fit.chi_squared, fit.dof));
    let frequencies = fit
        .frequencies
        .iter()
        .map(frequency_result)
        .collect::<Result<Vec<_>, _>>()?;
    let pair = |z: num_complex::Complex64| [z.re, z.im];
    Ok(MethodResult {
        method,
        correction: correction.label.clone(),
        frequencies,
        published: vec![],
        chi_squared,
        runs: fit
            .runs
            .iter()
            .map(|r| RunResult {
                run: r.run.clone(),
                session: r.session.clone(),
                frequency: r.frequency,
                direction: r.configuration.direction(),
                prediction_error: r.prediction_error.map(pair),
                studentised: r.studentised,
                statistic: r.statistic,
                influence: r.influence,
            })
            .collect(),
        angles: fit.angles.iter().map(angle_result).collect(),
        findings: fit.findings,
        datasheet: vec![],
        shared: fit.shared,
        identifiability: fit.identifiability,
        components: fit.components,
        motion: fit.motion,
        reproducibility: fit.reproducibility,
    })
}

fn angle_result(a: &AngleEstimate) -> AngleResult {
    AngleResult {
        key: a.key.clone(),
        configuration: a.configuration,
        value: a.value,
        standard_uncertainty: a.standard_uncertainty,
        prior: a.prior,
    }
}

/// Everything derived from S at one frequency.
///
/// # Errors
/// As [`terms`].
pub fn frequency_result(f: &FrequencyFit) -> Result<FrequencyResult, Error> {
    Ok(FrequencyResult {
        frequency: f.frequency,
        sensitivity: without_origin(terms("S", &f.sensitivity, &f.estimate)?),
        exploitation: terms("A", &f.exploitation, &f.inverse_estimate)?,
        normalised: expanded(&normalised("S", &f.estimate)?),
        normalised_exploitation: expanded(&normalised("A", &f.inverse_estimate)?),
        transverse: transverse(&f.estimate)?,
        misalignment: expanded(&misalignment(&f.estimate)?),
        intrinsic: expanded(&intrinsic(&f.estimate)?),
        estimate: f.estimate.clone(),
        inverse_estimate: f.inverse_estimate.clone(),
    })
}

/// A main term that is real by definition has no phase to state.
fn without_origin(mut terms: Vec<SensitivityTerm>) -> Vec<SensitivityTerm> {
    for term in &mut terms {
        if term.im.abs() < 1e-9 * term.re {
            let exact = |p: &Expanded| p.standard_uncertainty < 1e-5;
            term.phase = term.phase.take().filter(|p| !exact(p));
        }
    }
    terms
}

fn by_magnitudes(
    campaign: &ShakerCampaign,
    rows: &[PhasorRow],
    correction: &Correction,
) -> Result<MethodResult, Error> {
    let frequencies = ascending(rows.iter().map(|r| r.frequency));
    let published = frequencies
        .into_iter()
        .map(|frequency| {
            let rows: Vec<MagnitudeRow> = rows
                .iter()
                .filter(|r| r.frequency == frequency)
                .map(|r| MagnitudeRow {
                    reference: r.reference.norm(),
                    configuration: r.configuration,
                    outputs: r.outputs.map(|o| o.norm()),
                    spurious: correction
                        .table
                        .get(r.configuration.inclination, frequency)
                        .map(|s| SpuriousMagnitude {
                            modulus: s.ratio.map(|e| e.norm()),
                            modulus_uncertainty: s.covariance.map(|c| (0.5 * (c[0] + c[2])).sqrt()),
                            phase: s.ratio.map(|e| e.arg()),
                            phase_uncertainty: std::array::from_fn(|k| {
                                let modulus = s.ratio[k].norm();
                                let u = (0.5 * (s.covariance[k][0] + s.covariance[k][2])).sqrt();
                                // A ratio of zero has no phase: the whole circle, π/√3.
                                (u / modulus.max(f64::MIN_POSITIVE))
                                    .min(std::f64::consts::PI / 3f64.sqrt())
                            }),
                        }),
                })
                .collect();
            Ok(PublishedResult {
                frequency,
                fit: published::fit(&rows, &campaign.magnitude_budget)?,
            })
        })
        .collect::<Result<Vec<_>, Error>>()?;
    Ok(MethodResult {
        method: ShakerMethod::PublishedMagnitude,
        correction: correction.label.clone(),
        frequencies: vec![],
        published,
        chi_squared: None,
        runs: vec![],
        angles: vec![],
        findings: vec![findings::published_method()],
        datasheet: vec![],
        shared: None,
        identifiability: None,
        components: vec![],
        motion: vec![],
        reproducibility: None,
    })
}

/// Main terms with one correction against another.
fn differences(results: &[MethodResult]) -> Vec<TermDifference> {
    let Some(method) = results
        .iter()
        .map(|r| r.method)
        .find(|m| *m != ShakerMethod::PublishedMagnitude)
    else {
        return vec![];
    };
    let same: Vec<&MethodResult> = results.iter().filter(|r| r.method == method).collect();
    let mut list = vec![];
    for (k, a) in same.iter().enumerate() {
        for b in &same[k + 1..] {
            for (fa, fb) in a.frequencies.iter().zip(&b.frequencies) {
                for (ta, tb) in fa.sensitivity.iter().zip(&fb.sensitivity) {
                    if ta.name.as_bytes()[0] == ta.name.as_bytes()[1] {
                        let difference = tb.modulus.value - ta.modulus.value;
                        let causes = not_in_common(ta, tb);
                        let u = causes.iter().map(|(u, _)| u * u).sum::<f64>().sqrt();
                        let k = welch_satterthwaite(&causes).coverage_factor(PROBABILITY);
                        list.push(TermDifference {
                            between: [a.correction.clone(), b.correction.clone()],
                            frequency: fa.frequency,
                            term: ta.name.clone(),
                            relative: difference / ta.modulus.value,
                            e_n: (u > 0.0).then(|| difference.abs() / (k * u)),
                        });
                    }
                }
            }
        }
    }
    list
}

/// Standard uncertainties of two moduli, with their degrees of freedom, from what the results of two corrections do not have in common: the
/// motion of the bench, measured or not, with the calibrations behind it, and that of the reference where one correction has it
/// within its ratios.
fn not_in_common(a: &SensitivityTerm, b: &SensitivityTerm) -> Vec<(f64, DegreesOfFreedom)> {
    let has = |term: &SensitivityTerm, key: &str| term.budget.iter().any(|l| l.key == key);
    let own = |key: &str| {
        [SPURIOUS_MOTION, UNMEASURED_MOTION, MOTION]
            .iter()
            .any(|of| key.starts_with(of))
    };
    let of = |term: &SensitivityTerm, other: &SensitivityTerm| {
        let lines = term.budget.iter();
        let lines = lines.filter(|l| own(&l.key) || is_certified(&l.key) && !has(other, &l.key));
        lines.map(|l| (l.contribution, l.dof)).collect::<Vec<_>>()
    };
    [of(a, b), of(b, a)].concat()
}
