//! Which run does not belong, and what probably happened to it.

use super::adjustment::Adjustment;
use super::budget::Budget;
use super::fit::upper_tail;
use super::geometry::Configuration;
use super::matrix::{AXES, Matrix, row_times};
use super::observation::{PhasorRow, SpuriousTable};
use super::robust::{directions, wild};
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};

/// What would explain a run that the others contradict.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
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
    /// One output, or all of them against the reference, read with another gain.
    Gain {
        /// The output; `None` for all.
        channel: Option<usize>,
        /// Read over true.
        factor: f64,
    },
    /// An output without any signal.
    Dead {
        /// The output.
        channel: usize,
    },
    /// The device lay on its top.
    UpsideDown,
    /// One of two, which the run does not tell apart.
    Either(Box<Suspicion>, Box<Suspicion>),
    /// None of these.
    Unexplained,
}

/// A run that all others contradict.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SuspectRun {
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
/// Median of χ² with six degrees of freedom: runs that scatter more than declared widen the alarm for all of them.
const MEDIAN: f64 = 5.348_121;
/// A cause is named when its odds against the next are 20 to 1 …
const MARGIN: f64 = 3.0;
/// … and what it leaves is no more than this χ².
const EXPLAINED: f64 = 30.0;
/// Causes that are refitted, after a look at all of them by their distance.
const REFITTED: usize = 8;

/// Looks for runs that contradict the others, one at a time, each against a fit without those already found, and puts
/// every cause side by side: the run as that cause would have it is fitted together with the sound ones, and the
/// increase of χ² is its likelihood.
///
/// It begins with the runs that most others agree about, so that a wild one pulls no angle and stops no fit.
/// Nothing is removed from any result by this: the suspects are named.
///
/// # Errors
/// As [`super::complex`].
pub fn suspects(
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
) -> Result<Vec<SuspectRun>, Error> {
    let mut frequencies: Vec<f64> = rows.iter().map(|r| r.frequency).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup();
    let mut result = vec![];
    for frequency in frequencies {
        let all: Vec<usize> = (0..rows.len())
            .filter(|&i| rows[i].frequency == frequency)
            .collect();
        let here: Vec<PhasorRow> = all.iter().map(|&i| rows[i].clone()).collect();
        let wild = wild(&here, spurious, budget);
        let mut kept: Vec<usize> = (0..here.len()).filter(|&i| !wild[i]).collect();
        let subset =
            |kept: &[usize]| -> Vec<PhasorRow> { kept.iter().map(|&i| here[i].clone()).collect() };
        let most = here.len() / 4;
        let alarm = FALSE_ALARM / here.len() as f64;
        let mut factor = 1.0f64;
        let mut sound = None;
        for _ in 0..=most {
            let adjustment = match Adjustment::new(&subset(&kept), spurious, budget) {
                // After a removal the rest may no longer span; what was found so far stands.
                Err(Error::TooFew { .. } | Error::Unobservable { .. })
                    if kept.len() < here.len() =>
                {
                    break;
                }
                other => other?,
            };
            let deletions = match adjustment.deletions() {
                // A plan of so few runs that none can be spared has nothing to compare with.
                Err(Error::Unobservable { .. }) => break,
                other => other?,
            };
            let mut statistics: Vec<f64> = deletions.iter().map(|d| d.statistic).collect();
            let worst =
                (0..statistics.len()).max_by(|&a, &b| statistics[a].total_cmp(&statistics[b]));
            let Some(worst) = worst else {
                break;
            };
            let largest = statistics[worst];
            statistics.sort_by(f64::total_cmp);
            factor = (statistics[statistics.len() / 2] / MEDIAN).max(1.0);
            sound = Some(adjustment);
            if upper_tail(largest / factor, 6.0) >= alarm {
                break;
            }
            kept.remove(worst);
        }
        let Some(sound) = sound else {
            continue;
        };
        if kept.len() == here.len() {
            continue;
        }
        let sound = Adjustment::new(&subset(&kept), spurious, budget).unwrap_or(sound);
        let trial = Trial {
            sound: subset(&kept),
            chi_squared: sound.chi_squared,
            sensitivity: sound.sensitivity(0),
            factor,
            plan: here.iter().map(|r| r.configuration).collect(),
            spurious,
            budget,
        };
        for i in (0..here.len()).filter(|i| !kept.contains(i)) {
            let statistic = trial.increase(&here[i]);
            if upper_tail(statistic, 6.0) < alarm {
                let (suspicion, explained) = trial.explain(&here[i], statistic);
                result.push(SuspectRun {
                    row: all[i],
                    run: here[i].run.clone(),
                    statistic,
                    explained,
                    suspicion,
                });
            }
        }
    }
    result.sort_by_key(|s| s.row);
    Ok(result)
}

const ORDERS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 0, 2],
    [2, 1, 0],
    [0, 2, 1],
    [1, 2, 0],
    [2, 0, 1],
];

/// The sound runs of a frequency, and what a further one would add to their contradictions.
struct Trial<'a> {
    sound: Vec<PhasorRow>,
    chi_squared: f64,
    sensitivity: Matrix,
    /// Of the declared variance, by which the sound runs scatter more.
    factor: f64,
    plan: Vec<Configuration>,
    spurious: &'a SpuriousTable,
    budget: &'a Budget,
}

/// A cause: its prior, and the run as it would have been without it.
struct Cause {
    suspicion: Suspicion,
    prior: f64,
    row: PhasorRow,
}

impl Trial<'_> {
    /// χ² with the run less χ² without it, over the factor: six degrees of freedom when it belongs to them.
    fn increase(&self, row: &PhasorRow) -> f64 {
        let mut rows = self.sound.clone();
        rows.push(row.clone());
        match Adjustment::new(&rows, self.spurious, self.budget) {
            Ok(adjustment) => (adjustment.chi_squared - self.chi_squared).max(0.0) / self.factor,
            // So far off that no angles reconcile it with the others.
            Err(_) => 1e9,
        }
    }

    fn causes(&self, row: &PhasorRow) -> Vec<Cause> {
        let mut list = vec![];
        let mut add = |suspicion, prior: f64, row: PhasorRow| {
            list.push(Cause {
                suspicion,
                prior,
                row,
            });
        };
        for channel in ORDERS {
            for bits in 0..8u8 {
                let sign: [i8; 3] =
                    std::array::from_fn(|j| if bits >> j & 1 == 1 { -1 } else { 1 });
                let swapped = channel != [0, 1, 2];
                let prior = match (swapped, bits.count_ones()) {
                    (false, 0) => continue,
                    (true, 0) => 0.15 / 5.0,
                    (true, _) => 0.01 / 35.0,
                    (false, 1) => 0.08 / 3.0,
                    (false, 2) => 0.01 / 3.0,
                    (false, _) => 0.04,
                };
                let outputs = std::array::from_fn(|j| row.outputs[channel[j]] * f64::from(sign[j]));
                add(
                    Suspicion::Channels { channel, sign },
                    prior,
                    PhasorRow {
                        outputs,
                        ..row.clone()
                    },
                );
            }
        }
        let gained = |channel: Option<usize>, factor: f64| PhasorRow {
            outputs: std::array::from_fn(|j| {
                if channel.is_none_or(|k| k == j) {
                    row.outputs[j] / factor
                } else {
                    row.outputs[j]
                }
            }),
            ..row.clone()
        };
        for (factor, share) in [(10.0, 0.45), (0.1, 0.45), (100.0, 0.05), (0.01, 0.05)] {
            add(
                Suspicion::Gain {
                    channel: None,
                    factor,
                },
                0.12 * share,
                gained(None, factor),
            );
            for j in 0..3 {
                let channel = Some(j);
                add(
                    Suspicion::Gain { channel, factor },
                    0.08 / 3.0 * share,
                    gained(channel, factor),
                );
            }
        }
        // A gain that no switch has: its size is taken from the run itself, which costs its prior a range of ln 1000
        // in steps of about a per cent.
        let direction = |row: &PhasorRow| directions(std::slice::from_ref(row), self.spurious)[0];
        let m = row_times(direction(row), &self.sensitivity);
        let y = row.ratios();
        for channel in [None, Some(0), Some(1), Some(2)] {
            let of = |j: &usize| channel.is_none_or(|k| k == *j);
            let along: f64 = (0..3).filter(of).map(|j| (y[j] * m[j].conj()).re).sum();
            let square: f64 = (0..3).filter(of).map(|j| m[j].norm_sqr()).sum();
            let factor = along / square;
            if factor > 0.03 && factor < 30.0 && (factor - 1.0).abs() > 0.02 {
                let prior = if channel.is_none() { 0.02 } else { 0.01 };
                add(
                    Suspicion::Gain { channel, factor },
                    prior / 40.0,
                    gained(channel, factor),
                );
            }
        }
        for j in 0..3 {
            // Without any signal; the channel then says nothing, and stands in as what is expected of it.
            if y[j].norm() < 1e-2 * m[j].norm() {
                let mut outputs = row.outputs;
                outputs[j] = m[j] * row.reference;
                add(
                    Suspicion::Dead { channel: j },
                    0.024 / 3.0,
                    PhasorRow {
                        outputs,
                        ..row.clone()
                    },
                );
            }
        }
        let mut others: Vec<Configuration> = vec![];
        for c in &self.plan {
            if !c.same_as(&row.configuration) && !others.iter().any(|o| o.same_as(c)) {
                others.push(*c);
            }
        }
        let near = |c: &Configuration| {
            let d = |a: f64, b: f64| (a - b).abs() < 1e-6;
            d(c.inclination, row.configuration.inclination)
                || d(c.rotation, row.configuration.rotation)
        };
        let beside = others.iter().filter(|c| near(c)).count().max(1) as f64;
        let count = others.len().max(1) as f64;
        for configuration in others {
            let prior = if near(&configuration) {
                0.15 / beside
            } else {
                0.05 / count
            };
            add(
                Suspicion::Mounting { configuration },
                prior,
                PhasorRow {
                    configuration,
                    ..row.clone()
                },
            );
        }
        let c = row.configuration;
        let pi = std::f64::consts::PI;
        for rotation in [-c.rotation, pi - c.rotation] {
            let configuration = Configuration {
                inclination: pi - c.inclination,
                rotation,
            };
            add(
                Suspicion::UpsideDown,
                0.01,
                PhasorRow {
                    configuration,
                    ..row.clone()
                },
            );
        }
        list
    }

    /// The cause that explains the run best, when it is clearly the best, and the χ² it leaves.
    fn explain(&self, row: &PhasorRow, statistic: f64) -> (Suspicion, f64) {
        let main = self
            .sensitivity
            .iter()
            .flatten()
            .map(|z| z.norm_sqr())
            .sum::<f64>()
            / 3.0;
        let mut causes: Vec<(f64, Cause)> = self
            .causes(row)
            .into_iter()
            .map(|cause| {
                let d = directions(std::slice::from_ref(&cause.row), self.spurious)[0];
                let m = row_times(d, &self.sensitivity);
                let y = cause.row.ratios();
                let off: f64 = (0..3).map(|j| (y[j] - m[j]).norm_sqr()).sum();
                // Two per cent of the main sensitivity: a gluing by a degree.
                (0.5 * off / (4e-4 * main) - cause.prior.ln(), cause)
            })
            .collect();
        causes.sort_by(|a, b| a.0.total_cmp(&b.0));
        causes.truncate(REFITTED);
        let mut judged: Vec<(f64, f64, Suspicion)> = causes
            .into_iter()
            .map(|(_, cause)| {
                let left = self.increase(&cause.row);
                (0.5 * left - cause.prior.ln(), left, cause.suspicion)
            })
            .collect();
        // Something else, of whatever size it has: a normal error of all six reals as large as it looks.
        let unexplained = 3.0 + 3.0 * (statistic / 6.0).max(1.0).ln() - (0.05f64 / 8.0).ln();
        judged.push((unexplained, statistic, Suspicion::Unexplained));
        judged.sort_by(|a, b| a.0.total_cmp(&b.0));
        match judged.as_slice() {
            [(cost, left, suspicion), (next, ..), ..]
                if next - cost > MARGIN && *left <= EXPLAINED =>
            {
                (suspicion.clone(), *left)
            }
            [(_, left, a), (_, other, b), ..] if *left <= EXPLAINED && *other <= EXPLAINED => (
                Suspicion::Either(Box::new(a.clone()), Box::new(b.clone())),
                *left,
            ),
            _ => (Suspicion::Unexplained, statistic),
        }
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
) -> Result<(Vec<SuspectRun>, Vec<Finding>), Error> {
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

impl Suspicion {
    /// Code of the finding and what the run looks like, after "run … looks as if".
    fn words(&self) -> (&'static str, String) {
        match self {
            Self::Channels { channel, sign } => {
                let swapped: Vec<&str> = (0..3)
                    .filter(|&j| channel[j] != j)
                    .map(|j| AXES[j])
                    .collect();
                let inverted: Vec<&str> =
                    (0..3).filter(|&j| sign[j] < 0).map(|j| AXES[j]).collect();
                match (swapped.is_empty(), inverted.len()) {
                    (true, 3) => ("inverted-channel", "the reference were inverted".to_owned()),
                    (true, _) => (
                        "inverted-channel",
                        format!("channel {} were inverted", inverted.join(" and ")),
                    ),
                    (false, 0) => (
                        "swapped-channels",
                        format!("the cables of {} were swapped", swapped.join(" and ")),
                    ),
                    (false, _) => (
                        "swapped-channels",
                        format!(
                            "the cables of {} were swapped, and {} inverted",
                            swapped.join(" and "),
                            inverted.join(" and ")
                        ),
                    ),
                }
            }
            Self::Mounting { configuration } => (
                "wrong-configuration",
                format!("it were mounted at {}", degrees(configuration)),
            ),
            Self::Gain { channel, factor } => (
                "wrong-gain",
                match channel {
                    Some(j) => format!(
                        "output {} were read with {factor:.3} times its gain",
                        AXES[*j]
                    ),
                    None => format!(
                        "all outputs were read with {factor:.3} times their gain, or the reference with {:.3}",
                        1.0 / factor
                    ),
                },
            ),
            Self::Dead { channel } => (
                "dead-channel",
                format!("output {} carried no signal", AXES[*channel]),
            ),
            Self::UpsideDown => (
                "wrong-configuration",
                "the device lay upside down".to_owned(),
            ),
            Self::Either(a, b) => {
                let ((code, a), (_, b)) = (a.words(), b.words());
                (code, format!("{a}, or {b}"))
            }
            Self::Unexplained => ("outlier-configuration", String::new()),
        }
    }
}

fn describe(s: &SuspectRun, row: &PhasorRow) -> Finding {
    let place = format!("{}, {} Hz", degrees(&row.configuration), row.frequency);
    let (code, words) = s.suspicion.words();
    if s.suspicion == Suspicion::Unexplained {
        return Finding::new(
            Severity::Decision,
            code,
            format!("run {} contradicts all other runs of its frequency", s.run),
        )
        .evidence(format!(
            "{place}: χ² = {:.0} against the other runs with 6 degrees of freedom; no single cause explains it",
            s.statistic
        ))
        .advice("measure it again or leave it out; it was kept in the result");
    }
    Finding::new(
        Severity::Decision,
        code,
        format!("run {} looks as if {words}", s.run),
    )
    .evidence(format!(
        "{place}: χ² = {:.0} against the other runs with 6 degrees of freedom; {:.0} under this explanation",
        s.statistic, s.explained
    ))
    .advice("check the record of the run; measure it again or leave it out")
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
    suspects: &[SuspectRun],
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
