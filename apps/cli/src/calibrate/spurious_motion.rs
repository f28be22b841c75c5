//! A measurement of the spurious motion from its files to its results.

mod documents;

use super::{Calibrate, heading};
use crate::delivery::Results;
use crate::shaker::inputs;
use crate::shaker::runs::{Observed, observe};
use crate::{Failure, Outcome};
use proofmass::calibration::shaker::recording::{Assessed, Limits, Quality, assess};
use proofmass::calibration::shaker::spurious::{
    Comparison, RatioSummary, Repeats, compare, ratio_from_velocity, summaries, table,
};
use proofmass::calibration::shaker::{Complex64, SpuriousTable};
use proofmass::io::Software;
use proofmass::jobs::campaign::{Certificate, Direction, RunTable, SpuriousMotionCampaign};
use proofmass::report::SpuriousReport;
use proofmass::uncertainty::{Finding, Severity};
use std::f64::consts::TAU;

/// One measurement, by its label.
struct Measurement {
    label: String,
    repeats: Vec<Repeats>,
    /// Names of the runs of each ratio.
    runs: Vec<Vec<String>>,
    table: SpuriousTable,
    summaries: Vec<RatioSummary>,
}

/// Files of the corrections, measurement by measurement.
const CORRECTIONS: [&str; 4] = [
    "spurious.csv",
    "spurious-2.csv",
    "spurious-3.csv",
    "spurious-4.csv",
];

pub(super) fn run(
    arguments: &Calibrate,
    campaign: &SpuriousMotionCampaign,
) -> Result<Outcome, Failure> {
    let folder = arguments.begin(&campaign.source)?;
    let table = campaign.read_runs()?;
    let certificate = campaign.read_reference()?;
    let observed = observe(&table, campaign.recording.as_ref(), || {
        campaign.waveform_options()
    })?;
    let mut findings: Vec<Finding> = certificate
        .iter()
        .flat_map(|c| c.findings.clone())
        .chain(observed.findings.iter().cloned())
        .collect();
    let measurements = measurements(
        campaign,
        &table,
        &observed,
        certificate.as_ref(),
        &mut findings,
    )?;
    let first = &measurements[0];
    let comparisons: Vec<(&str, Vec<Comparison>)> = measurements[1..]
        .iter()
        .map(|other| (other.label.as_str(), compare(&first.table, &other.table)))
        .collect();
    findings.extend(disagreements(&first.label, &comparisons));
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
    let title = heading::title(
        campaign.title.as_ref(),
        &campaign.device,
        "Spurious motion of a shaker bench",
    );
    let text = SpuriousReport {
        title: title.clone(),
        meta: heading::meta(&campaign.device, &campaign.ambient),
        inputs: documents::listed(campaign, certificate.as_ref(), &observed),
        findings: &findings,
        comparison: comparisons.first().map(|(label, c)| (*label, c.as_slice())),
        footer: Software::default().to_string(),
    };
    let json = documents::result(
        &title,
        campaign,
        certificate.as_ref(),
        &observed,
        &measurements,
        &comparisons,
        &findings,
    )?;
    let mut files = vec![("ratios.csv", documents::ratios(&measurements)?.to_csv()?)];
    for (name, measurement) in CORRECTIONS.iter().zip(&measurements) {
        files.push((name, documents::correction(measurement)?.to_csv()?));
    }
    if !comparisons.is_empty() {
        files.push((
            "comparison.csv",
            documents::comparison(&first.label, &comparisons)?.to_csv()?,
        ));
    }
    arguments.delivery.hand_over(
        Some(folder),
        &Results {
            json,
            summary: &|| text.summary(&first.summaries, &first.table),
            report: &|| text.full(&first.summaries, &first.table),
            files,
            findings: &findings,
        },
    )
}

/// Ratios of all runs, gathered by measurement, inclination, frequency and axis.
fn measurements(
    campaign: &SpuriousMotionCampaign,
    runs: &RunTable<Direction>,
    observed: &Observed,
    certificate: Option<&Certificate>,
    findings: &mut Vec<Finding>,
) -> Result<Vec<Measurement>, Failure> {
    let reference = certificate.map(inputs::reference).transpose()?;
    let mut list: Vec<Measurement> = Vec::new();
    for (run, seen) in runs.runs.iter().zip(&observed.runs) {
        if campaign.runs.exclude.contains(&run.run) {
            continue;
        }
        let place = || format!("{}:{}: run {}", runs.path.display(), run.line, run.run);
        let (f, seat) = (run.frequency_hz, &run.seat);
        let acceleration = match &reference {
            Some(table) => table.acceleration(seen.phasors[0], f).map_err(|e| {
                Failure::new(format!("{}: {e}", place()))
                    .hint("have the reference calibrated there, or take the run out")
            })?,
            None => seen.phasors[0],
        };
        if acceleration.norm() == 0.0 {
            return Err(
                Failure::new(format!("{} has no signal of the reference", place()))
                    .hint("measure the run again, or take its row out"),
            );
        }
        let velocity = match &campaign.vibrometer {
            // The decoder speaks late by its delay.
            Some(v) => {
                seen.phasors[1] / v.sensitivity * Complex64::from_polar(1.0, TAU * f * v.delay_s)
            }
            None => seen.phasors[1],
        };
        let quality = seen
            .recorded
            .as_ref()
            .map_or_else(Quality::default, |r| r.phasors.quality(None));
        let assessed = Assessed {
            run: &run.run,
            frequency: f,
            quality: &quality,
            channels: &SpuriousMotionCampaign::CHANNELS,
            amplitude: acceleration.norm(),
            target: None,
        };
        findings.extend(assess(&assessed, &Limits::default()));
        let m = list
            .iter()
            .position(|m| m.label == seat.measurement)
            .unwrap_or_else(|| {
                list.push(Measurement {
                    label: seat.measurement.clone(),
                    repeats: Vec::new(),
                    runs: Vec::new(),
                    table: SpuriousTable::default(),
                    summaries: Vec::new(),
                });
                list.len() - 1
            });
        let measurement = &mut list[m];
        let same = |r: &Repeats| {
            (r.inclination - seat.inclination).abs() < 1e-6
                && r.frequency == f
                && r.axis == seat.axis
        };
        let k = measurement
            .repeats
            .iter()
            .position(same)
            .unwrap_or_else(|| {
                measurement.repeats.push(Repeats {
                    inclination: seat.inclination,
                    frequency: f,
                    axis: seat.axis,
                    ratios: Vec::new(),
                });
                measurement.runs.push(Vec::new());
                measurement.repeats.len() - 1
            });
        measurement.repeats[k]
            .ratios
            .push(ratio_from_velocity(velocity, acceleration, f));
        measurement.runs[k].push(run.run.clone());
    }
    if list.is_empty() {
        return Err(
            Failure::new(format!("{}: every run was left out", runs.path.display()))
                .hint("shorten `exclude` in [runs]"),
        );
    }
    if list.len() > CORRECTIONS.len() {
        return Err(Failure::new(format!(
            "{}: {} measurements are too many for one campaign",
            runs.path.display(),
            list.len()
        ))
        .hint(format!("compare {} at a time", CORRECTIONS.len())));
    }
    for measurement in &mut list {
        for (repeats, runs) in measurement.repeats.iter().zip(&measurement.runs) {
            if let [only] = runs.as_slice() {
                return Err(Failure::new(format!(
                    "{}: run {only} is the only repeat along {}′ at inclination {:.0}°, {} Hz",
                    campaign.source.path.display(),
                    ["x", "y", "z"][repeats.axis],
                    repeats.inclination.to_degrees(),
                    repeats.frequency
                ))
                .hint("a ratio needs two repeats at least, and ten to be trusted; measure again, or take the run out"));
            }
        }
        let (table, doubts) = table(&measurement.repeats)?;
        measurement.table = table;
        measurement.summaries = summaries(&measurement.repeats)?;
        findings.extend(doubts.into_iter().map(|f| {
            let text = f.evidence_text();
            // The finding knows the place, the table of runs its names.
            let runs = measurement
                .repeats
                .iter()
                .zip(&measurement.runs)
                .find(|(r, _)| {
                    f.what().contains(&format!(
                        "{}′ at inclination {:.0}°, {} Hz",
                        ["x", "y", "z"][r.axis],
                        r.inclination.to_degrees(),
                        r.frequency
                    ))
                })
                .map_or(String::new(), |(_, runs)| {
                    format!("; runs {}", runs.join(", "))
                });
            Finding::new(f.severity(), f.code(), f.what())
                .evidence(format!("{}: {text}{runs}", measurement.label))
                .advice(f.advice_text())
        }));
    }
    Ok(list)
}

/// Two measurements that do not agree within their uncertainties.
fn disagreements(first: &str, comparisons: &[(&str, Vec<Comparison>)]) -> Vec<Finding> {
    comparisons
        .iter()
        .filter_map(|(label, list)| {
            let apart: Vec<&Comparison> =
                list.iter().filter(|c| c.e_n.is_some_and(|e| e > 1.0)).collect();
            let worst = apart
                .iter()
                .max_by(|a, b| a.e_n.unwrap_or(0.0).total_cmp(&b.e_n.unwrap_or(0.0)))?;
            Some(
                Finding::new(
                    Severity::Warning,
                    "measurements-disagree",
                    format!("the measurements {first} and {label} disagree"),
                )
                .evidence(format!(
                    "E_n > 1 for {} of {} ratios; the worst along {}′ at inclination {:.0}°, {} Hz: E_n = {:.1}, difference {:.3} %",
                    apart.len(),
                    list.len(),
                    worst.axis,
                    worst.inclination.to_degrees(),
                    worst.frequency,
                    worst.e_n.unwrap_or(0.0),
                    100.0 * worst.difference
                ))
                .advice("repeats in a row do not see what changes between two set-ups; take their difference into the uncertainty"),
            )
        })
        .collect()
}
