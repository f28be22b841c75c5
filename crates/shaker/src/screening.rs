//! What goes into the fits: runs in m/s² and V with the whole budget, and what was left out and why.

use super::budget::{Acts, Budget, Key, ShakerInput};
use super::campaign::ShakerCampaign;
use super::geometry::Configuration;
use super::hum::hidden;
use super::observation::{Basis, CommonCauses, PhasorRow, SpuriousTable, ascending, sessions};
use super::plan::conditioning;
use super::recording::{Assessed, CHANNELS, RunInput, assess};
use super::reference_gap::reference_gap;
use crate::findings;
use proofmass_core::Error;
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_uncertainty::Finding;

/// What the fits work on: runs in m/s² and V, and the whole budget.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Observations {
    /// Runs, without those that were left out.
    pub rows: Vec<PhasorRow>,
    /// Budget with the calibration of the reference.
    pub budget: Budget,
    /// What was left out, and doubts about single runs.
    pub findings: Vec<Finding>,
}

/// Runs in m/s² and V, without those that were excluded, that the certificate does not reach, or whose frequency
/// has too few directions for S; each of these comes with a finding that names the runs.
///
/// # Errors
/// [`Error::OutOfRange`] for an impossible budget, [`Error::TooFew`] when no run is left.
pub fn observations(campaign: &ShakerCampaign) -> Result<Observations, Error> {
    let mut findings = vec![];
    let rows = determined(rows(campaign, &mut findings), &mut findings);
    findings.extend(reference_gap(
        campaign.reference.as_ref(),
        rows.iter().map(|r| r.frequency),
    ));
    let budget = with_certificate(
        &campaign.budget,
        campaign.reference.as_ref(),
        rows.iter().map(|r| r.frequency),
    )?;
    let budget = with_sessions(budget, &rows);
    Ok(Observations {
        rows,
        budget,
        findings,
    })
}

/// Phasor rows in m/s² and V, without what the certificate does not reach and what was decided to leave out.
fn rows(campaign: &ShakerCampaign, findings: &mut Vec<Finding>) -> Vec<PhasorRow> {
    let mut rows = vec![];
    let mut beyond: Vec<&RunInput> = vec![];
    let mut doubts: Vec<(&str, Finding)> = vec![];
    let (hum, about) = hidden(&campaign.runs);
    findings.extend(about);
    for run in &campaign.runs {
        if campaign.excluded.contains(&run.run) {
            findings.push(findings::excluded_run(&run.run, run.frequency));
            continue;
        }
        let scale = match &campaign.reference {
            Some(table) => match table.at(run.frequency) {
                Ok(p) => num_complex::Complex64::from_polar(p.sensitivity, p.phase).inv(),
                Err(_) => {
                    beyond.push(run);
                    continue;
                }
            },
            None => num_complex::Complex64::new(1.0, 0.0),
        };
        let mut covariance = run.covariance;
        for (_, loud) in hum.iter().filter(|(name, _)| *name == run.run) {
            for (c, a) in covariance.iter_mut().zip(loud) {
                c[0] += 0.5 * a * a;
                c[2] += 0.5 * a * a;
            }
        }
        // A turn by the certificate's phase would mix the parts; the noise of a sine is round enough for its
        // mean to be turned instead.
        let mean = 0.5 * (covariance[0][0] + covariance[0][2]) * scale.norm_sqr();
        if campaign.reference.is_some() {
            covariance[0] = [mean, 0.0, mean];
        }
        let reference = run.reference * scale;
        let target = campaign
            .targets
            .iter()
            .find(|(f, _)| (f / run.frequency - 1.0).abs() < 1e-6)
            .map(|t| t.1);
        let assessed = Assessed {
            run: &run.run,
            frequency: run.frequency,
            quality: &run.quality,
            channels: &CHANNELS,
            amplitude: reference.norm(),
            target,
        };
        let about = assess(&assessed, &campaign.limits);
        doubts.extend(about.into_iter().map(|f| (run.run.as_str(), f)));
        rows.push(PhasorRow {
            run: run.run.clone(),
            session: run.session.clone(),
            frequency: run.frequency,
            configuration: run.configuration,
            reference,
            outputs: run.outputs,
            covariance,
            phases: campaign.phases,
            reference_sensitivity: campaign.reference.is_some().then(|| scale.inv()),
        });
    }
    findings.extend(told_once(doubts));
    if let (Some(table), Some(first)) = (&campaign.reference, beyond.first()) {
        let points = table.points();
        let mut frequencies: Vec<String> = beyond
            .iter()
            .map(|r| format!("{} Hz", r.frequency))
            .collect();
        frequencies.dedup();
        findings.push(findings::reference_out_of_range(
            &frequencies.join(", "),
            &format!(
                "{} runs from {} on were left out; the certificate covers {} Hz to {} Hz",
                beyond.len(),
                first.run,
                points[0].frequency,
                points[points.len() - 1].frequency
            ),
        ));
    }
    rows
}

/// Doubts of one kind about more runs than this are told once.
const MANY: usize = 3;

/// One finding for many runs with the same doubt: the first with its numbers, the others by their names.
pub(crate) fn told_once(doubts: Vec<(&str, Finding)>) -> Vec<Finding> {
    let mut codes: Vec<String> = vec![];
    for (_, finding) in &doubts {
        if !codes.iter().any(|c| c == finding.code()) {
            codes.push(finding.code().to_owned());
        }
    }
    let mut findings = vec![];
    for code in codes {
        let of_kind: Vec<&(&str, Finding)> =
            doubts.iter().filter(|(_, f)| f.code() == code).collect();
        match of_kind.as_slice() {
            [(_, first), others @ ..] if others.len() >= MANY => {
                let names: Vec<&str> = others.iter().map(|(run, _)| *run).collect();
                findings.push(first.clone().likewise(&names));
            }
            few => findings.extend(few.iter().map(|(_, f)| f.clone())),
        }
    }
    findings
}

/// Rows of frequencies whose directions determine S; one run alone at its frequency is mostly a slip of the table.
fn determined(rows: Vec<PhasorRow>, findings: &mut Vec<Finding>) -> Vec<PhasorRow> {
    let frequencies = ascending(rows.iter().map(|r| r.frequency));
    let (mut lost, mut kept) = (vec![], vec![]);
    for &f in &frequencies {
        let here: Vec<&PhasorRow> = rows.iter().filter(|r| r.frequency == f).collect();
        let plan: Vec<Configuration> = here.iter().map(|r| r.configuration).collect();
        let why = match (distinct(&here), here.len()) {
            (_, 1) => "one configuration".to_owned(),
            // Copies of one recording fit no S, and what a fit makes of them is rounding.
            (n, all) if n < 3 && all > n => format!("{n} readings under {all} names"),
            (_, n) if conditioning(&plan).is_err() => {
                format!("{n} configurations that do not span three dimensions")
            }
            _ => {
                kept.push(f);
                continue;
            }
        };
        lost.push((f, here, why));
    }
    for (f, here, why) in &lost {
        let names: Vec<&str> = here.iter().take(6).map(|r| r.run.as_str()).collect();
        let more = if here.len() > 6 { " …" } else { "" };
        findings.push(findings::frequency_undetermined(
            *f,
            why,
            &format!("{}{more}", names.join(", ")),
        ));
    }
    rows.into_iter()
        .filter(|r| kept.contains(&r.frequency))
        .collect()
}

/// How many of these rows have phasors of their own; two readings never agree to a millionth.
fn distinct(rows: &[&PhasorRow]) -> usize {
    let far = |a: num_complex::Complex64, b: num_complex::Complex64| {
        (a - b).norm() > 1e-6 * a.norm().max(b.norm())
    };
    let differ = |a: &PhasorRow, b: &PhasorRow| {
        far(a.reference, b.reference) || (0..3).any(|j| far(a.outputs[j], b.outputs[j]))
    };
    let mut kinds: Vec<&PhasorRow> = vec![];
    for row in rows {
        // More than a few are enough.
        if kinds.len() > 3 {
            break;
        }
        if kinds.iter().all(|k| differ(k, row)) {
            kinds.push(row);
        }
    }
    kinds.len()
}

/// The budget with the reference calibration of the certificate at these frequencies, where it has none of its own: what the
/// certificate has in common as one error of the whole campaign, the rest as one of each frequency.
///
/// # Errors
/// [`Error::OutOfRange`] for an impossible budget or a frequency the certificate does not reach.
pub fn with_certificate(
    budget: &Budget,
    reference: Option<&ReferenceTable>,
    frequencies: impl IntoIterator<Item = f64>,
) -> Result<Budget, Error> {
    let mut budget = Budget::new(budget.inputs.clone())?.of_outputs(budget.output);
    let Some(table) = reference else {
        return Ok(budget);
    };
    let frequencies = ascending(frequencies);
    let mut shares = vec![];
    for frequency in frequencies {
        shares.push((frequency, table.shares_at(frequency)?));
    }
    let stated = budget.inputs.clone();
    for (part, acts, key, text) in [
        (
            0,
            Acts::ReferenceModulus,
            CERTIFIED[0],
            "calibration of the reference standard",
        ),
        (
            1,
            Acts::ReferencePhase,
            CERTIFIED[1],
            "phase of the reference standard",
        ),
    ] {
        if stated.iter().any(|i| i.acts == acts) {
            continue;
        }
        let common = shares.iter().map(|(f, s)| (*f, s.common[part])).collect();
        let own = shares.iter().map(|(f, s)| (*f, s.own[part])).collect();
        budget
            .inputs
            .extend(over_frequency(key, acts, common, &[]).map(|i| i.described(text)));
        let alone = format!("{text}, of each frequency alone");
        budget.inputs.extend(
            over_frequency(&format!("{key}.own"), acts, own, &[Key::Frequency])
                .map(|i| i.described(&alone)),
        );
    }
    Ok(budget)
}

/// What a gain may change by from one session to the next, to begin with where nobody declares it: relative, and rad.
const BETWEEN_SESSIONS: f64 = 0.01;

/// The budget with what the gains of the outputs differ by from session to session, where the runs name sessions and nobody declares
/// it: how large that is the runs tell, or it goes out of the result.
fn with_sessions(mut budget: Budget, rows: &[PhasorRow]) -> Budget {
    use Acts::{OutputModulus, OutputPhase, ReferenceModulus, ReferencePhase};
    let named = rows.iter().all(|r| r.session.is_some());
    if !named || sessions(rows).len() < 2 {
        return budget;
    }
    let phases = rows.iter().all(|r| r.reals() == 6.0);
    for (acts, reference, key, text) in [
        (
            OutputModulus,
            ReferenceModulus,
            "session.reproducibility",
            "gain of each output from session to session, which nobody declared",
        ),
        (
            OutputPhase,
            ReferencePhase,
            "session.reproducibility.phase",
            "phase of each output from session to session, which nobody declared",
        ),
    ] {
        let declared = |i: &ShakerInput| {
            i.varies_between_sessions() && (i.acts == acts || i.acts == reference) || i.key == key
        };
        if (acts == OutputPhase && !phases) || budget.inputs.iter().any(declared) {
            continue;
        }
        let keys = [Key::Session, Key::Channel];
        let mut input = ShakerInput::new(key, acts, BETWEEN_SESSIONS, &keys).described(text);
        input.evaluation = proofmass_uncertainty::Evaluation::A;
        input.assumed = true;
        budget.inputs.push(input);
    }
    budget
}

/// Names of what the certificate of the reference gives the budget, of modulus and phase.
const CERTIFIED: [&str; 2] = ["reference.calibration", "reference.phase"];
/// What the keys begin with of the calibrations behind a measured motion.
pub(crate) const MOTION: &str = "motion.";

/// Whether a key is that of what the certificate of the reference gives the budget.
pub(crate) fn is_certified(key: &str) -> bool {
    CERTIFIED.iter().any(|name| {
        key.strip_prefix(name)
            .is_some_and(|rest| matches!(rest, "" | ".own"))
    })
}

/// The budget of a correction: a motion that was read too large makes every sensitivity too small by as much, as an acceleration does that
/// was read too large. So the calibrations behind its ratios count as that of the reference does.
///
/// Where the ratios were read beside the same reference, with the same calibration, and along the excitation at every place of the runs,
/// what is certified of it goes out: the vibrometer alone then says how large the motion was.
pub(crate) fn with_motion(
    budget: &Budget,
    table: &SpuriousTable,
    rows: &[PhasorRow],
) -> Result<Budget, Error> {
    let common = &table.common;
    if common.at.is_empty() {
        return Ok(budget.clone());
    }
    let along = |row: &PhasorRow| {
        let entry = table.get(row.configuration.inclination, row.frequency);
        entry.is_some_and(|e| e.basis[2] == Basis::Measured)
    };
    let cancels = common.same_reference && rows.iter().all(along);
    let mut budget = budget.clone();
    if cancels {
        budget.inputs.retain(|input| !is_certified(&input.key));
    }
    // At the frequencies at which a ratio along the excitation was measured: a gain across it changes what is small already.
    let frequencies = ascending(rows.iter().filter(|r| along(r)).map(|r| r.frequency));
    let all = ascending(rows.iter().map(|r| r.frequency));
    let mut of =
        |part: usize, acts: Acts, key: &str, text: &str, u: &dyn Fn(&CommonCauses) -> [f64; 2]| {
            let at = |f: &f64| match frequencies.contains(f) {
                true => common.at(*f).map_or(0.0, |c| u(c)[part]),
                false => 0.0,
            };
            let stated = all.iter().map(|f| (*f, at(f))).collect();
            let input = over_frequency(key, acts, stated, &[]);
            budget.inputs.extend(input.map(|i| i.described(text)));
        };
    let vibrometer = |c: &CommonCauses| c.vibrometer;
    of(
        0,
        Acts::ReferenceModulus,
        "motion.vibrometer",
        "calibration of the vibrometer",
        &vibrometer,
    );
    of(
        1,
        Acts::ReferencePhase,
        "motion.delay",
        "delay of the vibrometer",
        &vibrometer,
    );
    if !common.same_reference {
        let reference = |c: &CommonCauses| c.reference;
        let text = "calibration of the reference beside the vibrometer";
        of(
            0,
            Acts::ReferenceModulus,
            "motion.reference",
            text,
            &reference,
        );
        let text = "phase of the reference beside the vibrometer";
        of(1, Acts::ReferencePhase, "motion.phase", text, &reference);
    }
    Budget::new(budget.inputs).map(|whole| whole.of_outputs(budget.output))
}

/// An input with another uncertainty at every frequency; `None` where it is zero at all.
fn over_frequency(
    key: &str,
    acts: Acts,
    stated: Vec<(f64, f64)>,
    varies_with: &[Key],
) -> Option<ShakerInput> {
    let largest = stated.iter().map(|s| s.1).fold(0.0, f64::max);
    if !(largest > 0.0) {
        return None;
    }
    let mut input = ShakerInput::new(key, acts, largest, varies_with);
    if stated.iter().any(|s| s.1 != largest) {
        input.at_frequencies = stated;
    }
    Some(input)
}
