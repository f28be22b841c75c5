//! Which run does not belong, and what probably happened to it.

use super::adjustment::Adjustment;
use super::budget::Budget;
use super::fit::upper_tail;
use super::geometry::Configuration;
use super::matrix::{AXES, Matrix, row_times};
use super::observation::{PhasorRow, SpuriousTable};
use faer::{Mat, Side, linalg::solvers::Solve};
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};

/// What would explain a run that the others contradict.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Suspicion {
    /// Outputs read in another order and sign: output j of the device was found on channel `channel[j]` with
    /// `sign[j]`.
    Channels {
        /// Channel on which each output was found.
        channel: [usize; 3],
        /// Its sign.
        sign: [i8; 3],
    },
    /// The device was mounted as in another configuration of the plan.
    Mounting {
        /// That configuration.
        configuration: Configuration,
    },
    /// None of these.
    Unexplained,
}

/// A run that all others contradict.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Suspect {
    /// Index of the row.
    pub row: usize,
    /// Name of the run.
    pub run: String,
    /// χ² of its departure from what the other runs predict, six degrees of freedom.
    pub statistic: f64,
    /// The same under the explanation.
    pub explained: f64,
    /// The explanation.
    pub suspicion: Suspicion,
}

/// Probability, over all runs of a frequency, of calling a good run suspect.
const FALSE_ALARM: f64 = 1e-4;
/// An explanation must leave no more than this χ²: ten per degree of freedom, for the run was predicted with the
/// angle its fault suggested …
const EXPLAINED: f64 = 60.0;
/// … and be this much better than the run as it stands.
const BETTER: f64 = 10.0;

/// Looks for runs that contradict the others, one at a time, each against a fit without those already found.
///
/// Nothing is removed from any result by this: the suspects are named.
///
/// # Errors
/// As [`super::complex`].
pub fn suspects(
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
) -> Result<Vec<Suspect>, Error> {
    let mut frequencies: Vec<f64> = rows.iter().map(|r| r.frequency).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup();
    let mut result = vec![];
    for frequency in frequencies {
        let mut kept: Vec<usize> = (0..rows.len())
            .filter(|&i| rows[i].frequency == frequency)
            .collect();
        let most = kept.len() / 4;
        let alarm = FALSE_ALARM / kept.len() as f64;
        for _ in 0..=most {
            let subset: Vec<PhasorRow> = kept.iter().map(|&i| rows[i].clone()).collect();
            let adjustment = match Adjustment::new(&subset, spurious, budget) {
                // After a removal the rest may no longer span; what was found so far stands.
                Err(Error::TooFew { .. } | Error::Unobservable { .. }) if !result.is_empty() => {
                    break;
                }
                other => other?,
            };
            let deletions = match adjustment.deletions() {
                // A plan of so few runs that none can be spared has nothing to compare with.
                Err(Error::Unobservable { .. }) => break,
                other => other?,
            };
            let Some((worst, deletion)) = deletions
                .iter()
                .enumerate()
                .max_by(|a, b| a.1.statistic.total_cmp(&b.1.statistic))
            else {
                break;
            };
            if upper_tail(deletion.statistic, 6.0) >= alarm {
                break;
            }
            let row = &subset[worst];
            let plan: Vec<Configuration> = subset.iter().map(|r| r.configuration).collect();
            let (suspicion, explained) = explain(
                row,
                &deletion.prediction_error,
                &deletion.covariance,
                adjustment.scale,
                &sensitivity_without(&adjustment, worst)?,
                &plan,
                deletion.statistic,
            )?;
            result.push(Suspect {
                row: kept[worst],
                run: row.run.clone(),
                statistic: deletion.statistic,
                explained,
                suspicion,
            });
            kept.remove(worst);
        }
    }
    Ok(result)
}

/// S of the frequency of a run, from all other runs.
fn sensitivity_without(adjustment: &Adjustment, row: usize) -> Result<Matrix, Error> {
    let f = adjustment.of_row[row];
    let change = &adjustment.deletions()?[row].influence;
    let mut s = super::matrix::to_real(&adjustment.sensitivity(f));
    for (s, c) in s.iter_mut().zip(change) {
        *s += c;
    }
    Ok(super::matrix::from_real(&s))
}

const ORDERS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 0, 2],
    [2, 1, 0],
    [0, 2, 1],
    [1, 2, 0],
    [2, 0, 1],
];

fn explain(
    row: &PhasorRow,
    prediction_error: &[Complex64; 3],
    covariance: &[[f64; 6]; 6],
    scale: f64,
    sensitivity: &Matrix,
    plan: &[Configuration],
    statistic: f64,
) -> Result<(Suspicion, f64), Error> {
    let matrix = Mat::from_fn(6, 6, |a, b| covariance[a][b]);
    let llt = matrix
        .llt(Side::Lower)
        .map_err(|_| Error::NotPositiveDefinite {
            name: "covariance of a prediction error",
            row: 0,
            column: 0,
            value: 0.0,
        })?;
    let distance = |e: [Complex64; 3]| -> f64 {
        let v = Mat::from_fn(6, 1, |a, _| {
            let z = e[a / 2] / scale;
            if a % 2 == 0 { z.re } else { z.im }
        });
        (v.transpose() * llt.solve(&v))[(0, 0)]
    };
    let y = row.ratios();
    let predicted: [Complex64; 3] = std::array::from_fn(|j| y[j] - prediction_error[j]);
    // Order and signs: the fewer changes, the more credible, so a further change must pay.
    let mut best = (Suspicion::Unexplained, statistic, f64::INFINITY);
    for channel in ORDERS {
        for bits in 0..8u8 {
            let sign: [i8; 3] = std::array::from_fn(|j| if bits >> j & 1 == 1 { -1 } else { 1 });
            let changes = (0..3).filter(|&j| channel[j] != j || sign[j] < 0).count();
            if changes == 0 {
                continue;
            }
            let q = distance(std::array::from_fn(|j| {
                y[channel[j]] * f64::from(sign[j]) - predicted[j]
            }));
            let cost = q + 10.0 * changes as f64;
            if cost < best.2 {
                best = (Suspicion::Channels { channel, sign }, q, cost);
            }
        }
    }
    for &configuration in plan {
        if configuration.same_as(&row.configuration) {
            continue;
        }
        let d = configuration.direction().map(|d| Complex64::new(d, 0.0));
        let other = row_times(d, sensitivity);
        let q = distance(std::array::from_fn(|j| y[j] - other[j]));
        let cost = q + 25.0;
        if cost < best.2 {
            best = (Suspicion::Mounting { configuration }, q, cost);
        }
    }
    // The covariance belongs to the run as predicted, so an explanation only has to be near.
    if best.1 < (statistic / BETTER).max(EXPLAINED).min(statistic / 2.0) {
        Ok((best.0, best.1))
    } else {
        Ok((Suspicion::Unexplained, statistic))
    }
}

/// Everything that can be said about a phasor table before its result is used: runs missing or twice, phases in
/// the wrong unit, runs that contradict the others, channels swapped or inverted throughout.
///
/// `plan` is what should have been measured at every frequency; without it, all configurations that occur.
///
/// # Errors
/// As [`super::complex`].
pub fn diagnose(
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
    plan: Option<&[Configuration]>,
) -> Result<(Vec<Suspect>, Vec<Finding>), Error> {
    let mut findings = completeness(rows, plan);
    if let Some(finding) = phase_unit(rows, spurious, budget)? {
        // With wrong phases every run is suspect; naming them all would hide the cause.
        findings.push(finding);
        return Ok((vec![], findings));
    }
    let suspects = suspects(rows, spurious, budget)?;
    findings.extend(suspects.iter().map(|s| describe(s, &rows[s.row])));
    findings.extend(throughout(rows, spurious, budget, &suspects)?);
    Ok((suspects, findings))
}

fn degrees(c: &Configuration) -> String {
    let (a, w) = (c.inclination.to_degrees(), c.rotation.to_degrees());
    format!("inclination {a:.0}°, rotation {w:.0}°")
}

fn describe(s: &Suspect, row: &PhasorRow) -> Finding {
    let (run, place) = (
        &s.run,
        format!("{}, {} Hz", degrees(&row.configuration), row.frequency),
    );
    let evidence = format!(
        "{place}: χ² = {:.0} against the other runs with 6 degrees of freedom; {:.0} under this explanation",
        s.statistic, s.explained
    );
    match &s.suspicion {
        Suspicion::Channels { channel, sign } => {
            let swapped: Vec<&str> = (0..3)
                .filter(|&j| channel[j] != j)
                .map(|j| AXES[j])
                .collect();
            let inverted: Vec<&str> = (0..3).filter(|&j| sign[j] < 0).map(|j| AXES[j]).collect();
            if swapped.is_empty() {
                Finding::new(
                    Severity::Decision,
                    "inverted-channel",
                    format!(
                        "run {run} looks as if channel {} were inverted",
                        inverted.join(" and ")
                    ),
                )
            } else {
                let inverted = if inverted.is_empty() {
                    String::new()
                } else {
                    format!(", and {} inverted", inverted.join(" and "))
                };
                Finding::new(
                    Severity::Decision,
                    "swapped-channels",
                    format!(
                        "run {run} looks as if the cables of {} were swapped{inverted}",
                        swapped.join(" and ")
                    ),
                )
            }
            .evidence(evidence)
            .advice("check the cables in the record of the run; measure it again or leave it out")
        }
        Suspicion::Mounting { configuration } => Finding::new(
            Severity::Decision,
            "wrong-configuration",
            format!(
                "run {run} looks as if it were mounted at {}",
                degrees(configuration)
            ),
        )
        .evidence(evidence)
        .advice("check the plan against the record of the run"),
        Suspicion::Unexplained => Finding::new(
            Severity::Decision,
            "outlier-configuration",
            format!("run {run} contradicts all other runs of its frequency"),
        )
        .evidence(format!(
            "{place}: χ² = {:.0} against the other runs with 6 degrees of freedom",
            s.statistic
        ))
        .advice("measure it again or leave it out; it was kept in the result"),
    }
}

/// Runs that are missing or there twice.
fn completeness(rows: &[PhasorRow], plan: Option<&[Configuration]>) -> Vec<Finding> {
    let mut findings = vec![];
    let plan: Vec<Configuration> = plan.map_or_else(
        || {
            let mut all: Vec<Configuration> = vec![];
            for row in rows {
                if !all.iter().any(|c| c.same_as(&row.configuration)) {
                    all.push(row.configuration);
                }
            }
            all
        },
        <[_]>::to_vec,
    );
    let mut frequencies: Vec<f64> = rows.iter().map(|r| r.frequency).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup();
    for &f in &frequencies {
        let here: Vec<&PhasorRow> = rows.iter().filter(|r| r.frequency == f).collect();
        for c in &plan {
            let same: Vec<&str> = here
                .iter()
                .filter(|r| r.configuration.same_as(c))
                .map(|r| r.run.as_str())
                .collect();
            if same.is_empty() {
                findings.push(
                    Finding::new(
                        Severity::Warning,
                        "missing-configuration",
                        format!("there is no run at {}, {f} Hz", degrees(c)),
                    )
                    .evidence(format!(
                        "{} runs at {f} Hz, {} in the plan",
                        here.len(),
                        plan.len()
                    ))
                    .advice("the uncertainty already tells what it costs; measure it if it can be"),
                );
            } else if same.len() > 1 {
                findings.push(
                    Finding::new(
                        Severity::Warning,
                        "duplicate-configuration",
                        format!("{} at {f} Hz was measured {} times", degrees(c), same.len()),
                    )
                    .evidence(format!("runs {}", same.join(", ")))
                    .advice("if it is one run entered twice, take one out; true repeats share their mounting error"),
                );
            }
        }
        for r in &here {
            if !plan.iter().any(|c| c.same_as(&r.configuration)) {
                findings.push(
                    Finding::new(
                        Severity::Note,
                        "unplanned-configuration",
                        format!("run {} is not in the plan", r.run),
                    )
                    .evidence(degrees(&r.configuration))
                    .advice("it was used"),
                );
            }
        }
    }
    findings
}

/// Phases that were radians but read as degrees leave nothing outside ±π/180 rad · π.
fn phase_unit(
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
) -> Result<Option<Finding>, Error> {
    let phasors = || {
        rows.iter()
            .flat_map(|r| r.outputs.iter().chain([&r.reference]))
    };
    let largest = phasors().map(|z| z.arg().abs()).fold(0.0, f64::max);
    let limit = std::f64::consts::PI.to_radians() * 1.01;
    if largest > limit || largest < 0.3 * limit {
        return Ok(None);
    }
    let turn = |z: Complex64| Complex64::from_polar(z.norm(), z.arg().to_degrees());
    let reread: Vec<PhasorRow> = rows
        .iter()
        .map(|r| PhasorRow {
            reference: turn(r.reference),
            outputs: r.outputs.map(turn),
            ..r.clone()
        })
        .collect();
    let (as_given, as_radians) = (
        total_chi_squared(rows, spurious, budget)?,
        total_chi_squared(&reread, spurious, budget)?,
    );
    Ok((as_radians < 0.1 * as_given).then(|| {
        let runs = match (rows.first(), rows.last()) {
            (Some(a), Some(b)) => format!("runs {} to {}", a.run, b.run),
            _ => String::new(),
        };
        Finding::new(
            Severity::Decision,
            "phase-unit",
            "the phases of the table look like radians that were declared as degrees",
        )
        .evidence(format!(
            "{runs}: no phase exceeds {:.2}°, χ² = {as_given:.0} as declared and {as_radians:.0} as radians",
            largest.to_degrees()
        ))
        .advice("declare the phase column in radians and calibrate again")
    }))
}

fn total_chi_squared(
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
) -> Result<f64, Error> {
    let mut frequencies: Vec<f64> = rows.iter().map(|r| r.frequency).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup();
    let mut sum = 0.0;
    for f in frequencies {
        let subset: Vec<PhasorRow> = rows.iter().filter(|r| r.frequency == f).cloned().collect();
        match Adjustment::new(&subset, spurious, budget) {
            Ok(adjustment) => sum += adjustment.chi_squared,
            // Nonsense phases may not even converge: infinitely bad.
            Err(Error::NotConverged { .. }) => return Ok(f64::INFINITY),
            Err(other) => return Err(other),
        }
    }
    Ok(sum)
}

/// Channels swapped or inverted in every run show in S itself.
fn throughout(
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
    suspects: &[Suspect],
) -> Result<Vec<Finding>, Error> {
    let mut findings = vec![];
    let kept: Vec<PhasorRow> = rows
        .iter()
        .enumerate()
        .filter(|(i, _)| !suspects.iter().any(|s| s.row == *i))
        .map(|(_, r)| r.clone())
        .collect();
    let fit = super::complex(&kept, spurious, budget)?;
    // Far below resonance the phase of a channel is 0 or π: one frequency, the lowest, tells.
    let Some(lowest) = fit.frequencies.first() else {
        return Ok(findings);
    };
    let s = &lowest.sensitivity;
    for j in 0..3 {
        let largest = (0..3)
            .max_by(|&a, &b| s[a][j].norm().total_cmp(&s[b][j].norm()))
            .unwrap_or(j);
        if largest != j {
            findings.push(
                Finding::new(
                    Severity::Decision,
                    "swapped-channels",
                    format!(
                        "channel {} follows the {} axis in every run",
                        AXES[j], AXES[largest]
                    ),
                )
                .evidence(format!(
                    "at {} Hz: |S_{}{}| = {:.4e}, |S_{}{}| = {:.4e} V/(m/s²)",
                    lowest.frequency,
                    AXES[largest],
                    AXES[j],
                    s[largest][j].norm(),
                    AXES[j],
                    AXES[j],
                    s[j][j].norm()
                ))
                .advice("check the cables against the axes marked on the device"),
            );
        } else if s[j][j].re < 0.0 {
            findings.push(
                Finding::new(
                    Severity::Warning,
                    "inverted-channel",
                    format!("channel {} is inverted in every run", AXES[j]),
                )
                .evidence(format!(
                    "at {} Hz: phase of S_{}{} {:.1}°",
                    lowest.frequency,
                    AXES[j],
                    AXES[j],
                    s[j][j].arg().to_degrees()
                ))
                .advice("right for an inverting amplifier; otherwise check the polarity"),
            );
        }
    }
    Ok(findings)
}
