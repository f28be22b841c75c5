//! A comparison with a reference from its files to its results.

use super::{Calibrate, heading};
use crate::delivery::Results;
use crate::shaker::inputs;
use crate::shaker::runs::{Observed, observe};
use crate::{Failure, Outcome, clock};
use proofmass::calibration::shaker::derived::PROBABILITY;
use proofmass::calibration::shaker::recording::{Assessed, Limits, Quality, assess};
use proofmass::calibration::shaker::reference::ReferenceTable;
use proofmass::calibration::shaker::single_axis::{
    ComparisonBudget, ComparisonRow, SingleAxis, combine, compare,
};
use proofmass::io::{Cell, Input, ResultDocument, Software, Table};
use proofmass::jobs::campaign::{Certificate, RunTable, ShakerSingleCampaign, SingleAxisSeat};
use proofmass::report::SingleAxisReport;
use proofmass::uncertainty::{Finding, Quantity, Severity};

pub(super) fn run(
    arguments: &Calibrate,
    campaign: &ShakerSingleCampaign,
) -> Result<Outcome, Failure> {
    let folder = arguments.begin(&campaign.source)?;
    let table = campaign.read_runs()?;
    let certificate = campaign.read_reference()?;
    let observed = observe(&table, campaign.recording.as_ref(), || {
        campaign.waveform_options()
    })?;
    let reference = inputs::reference(&certificate)?;
    let mut findings = certificate.findings.clone();
    findings.extend(observed.findings.iter().cloned());
    let rows = rows(campaign, &table, &observed, &reference, &mut findings)?;
    let reading = &campaign.reading;
    let budget = ComparisonBudget {
        ratio: reading.u_relative,
        phase: reading.u_phase_deg.to_radians(),
        dof: reading.dof.unwrap_or(f64::INFINITY),
    };
    let (single, doubts) = compare(&rows, &reference, &budget)?;
    findings.extend(doubts);
    let (results, doubts) = combine(&rows, &single, &budget)?;
    findings.extend(doubts);
    findings.extend(against_datasheet(campaign, &results));
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
    let title = heading::title(
        campaign.title.as_ref(),
        &campaign.device,
        "Calibration of an accelerometer by comparison",
    );
    let mut meta = heading::meta(&campaign.device, &campaign.ambient);
    meta.extend(
        certificate
            .description
            .clone()
            .map(|d| ("Reference".to_owned(), d)),
    );
    let text = SingleAxisReport {
        title: title.clone(),
        meta,
        inputs: listed(campaign, &certificate, &observed),
        findings: &findings,
        runs: &rows,
        footer: Software::default().to_string(),
    };
    let mut document = ResultDocument::new("shaker-single")
        .title(title)
        .device(&campaign.device)
        .findings(&findings);
    for input in [&campaign.source.input, &certificate.input]
        .into_iter()
        .chain(&observed.inputs)
    {
        document = document.input(input.clone());
    }
    for result in &results {
        for quantity in result.estimate.quantities() {
            let name = format!("S.{}[frequency={}]", quantity.name, result.frequency);
            document = document.quantity(&Quantity { name, ..quantity }, PROBABILITY);
        }
    }
    let json = document
        .section("date", &clock::today())?
        .section("probability", &PROBABILITY)?
        .section(
            "estimates",
            &results.iter().map(|r| &r.estimate).collect::<Vec<_>>(),
        )?
        .to_json()?;
    arguments.delivery.hand_over(
        Some(folder),
        &Results {
            json,
            summary: &|| text.summary(&results),
            report: &|| text.full(&results),
            files: vec![
                ("sensitivity.csv", sensitivity(None, &results)?.to_csv()?),
                ("repeats.csv", sensitivity(Some(&rows), &single)?.to_csv()?),
            ],
            findings: &findings,
        },
    )
}

/// Runs that the certificate reaches and nobody excluded, with what is doubtful about each.
fn rows(
    campaign: &ShakerSingleCampaign,
    table: &RunTable<SingleAxisSeat>,
    observed: &Observed,
    reference: &ReferenceTable,
    findings: &mut Vec<Finding>,
) -> Result<Vec<ComparisonRow>, Failure> {
    let mut rows = Vec::new();
    let mut beyond = Vec::new();
    for (run, seen) in table.runs.iter().zip(&observed.runs) {
        if campaign.runs.exclude.contains(&run.run) {
            findings.push(
                Finding::new(
                    Severity::Note,
                    "excluded-run",
                    format!("run {} was left out as asked", run.run),
                )
                .evidence(format!("{} Hz", run.frequency_hz)),
            );
            continue;
        }
        let Ok(point) = reference.at(run.frequency_hz) else {
            beyond.push(format!(
                "{} ({} Hz, line {})",
                run.run, run.frequency_hz, run.line
            ));
            continue;
        };
        if seen.phasors[0].norm() == 0.0 {
            return Err(Failure::new(format!(
                "{}:{}: run {} has no signal of the reference",
                table.path.display(),
                run.line,
                run.run
            ))
            .hint("measure the run again, or take its row out"));
        }
        let quality = seen
            .recorded
            .as_ref()
            .map_or_else(Quality::default, |r| r.phasors.quality(None));
        let assessed = Assessed {
            run: &run.run,
            frequency: run.frequency_hz,
            quality: &quality,
            channels: &ShakerSingleCampaign::CHANNELS,
            amplitude: seen.phasors[0].norm() / point.sensitivity,
            target: run.seat.target,
        };
        findings.extend(assess(&assessed, &Limits::default()));
        rows.push(ComparisonRow {
            run: run.run.clone(),
            frequency: run.frequency_hz,
            reference: seen.phasors[0],
            output: seen.phasors[1],
            transverse: run.seat.transverse,
        });
    }
    if !beyond.is_empty() {
        let points = reference.points();
        let covers = format!(
            "it covers {} Hz to {} Hz",
            points[0].frequency,
            points[points.len() - 1].frequency
        );
        if rows.is_empty() {
            return Err(Failure::new(format!(
                "{}: the certificate of the reference reaches no run",
                table.path.display()
            ))
            .detail(format!("{covers}; runs {}", beyond.join(", ")))
            .hint("have the reference calibrated there"));
        }
        findings.push(
            Finding::new(
                Severity::Decision,
                "reference-out-of-range",
                "the certificate of the reference does not reach some runs, which were left out",
            )
            .evidence(format!("{covers}; runs {}", beyond.join(", ")))
            .advice("have the reference calibrated there, or take these runs out"),
        );
    }
    Ok(rows)
}

/// A sensitivity off its datasheet by more than tolerance and uncertainty together.
fn against_datasheet(campaign: &ShakerSingleCampaign, results: &[SingleAxis]) -> Vec<Finding> {
    let Some((nominal, tolerance)) = campaign.datasheet else {
        return Vec::new();
    };
    results
        .iter()
        .filter_map(|result| {
            let q = result.estimate.get("modulus")?;
            let off = q.value - nominal;
            (off.abs() > tolerance.hypot(q.expanded(PROBABILITY))).then(|| {
                Finding::new(
                    Severity::Warning,
                    "off-datasheet",
                    format!(
                        "the sensitivity at {} Hz is not that of the datasheet",
                        result.frequency
                    ),
                )
                .evidence(format!(
                    "{:+.1} %, tolerance {:.1} %, U = {:.2} %",
                    100.0 * off / nominal,
                    100.0 * tolerance / nominal,
                    100.0 * q.expanded(PROBABILITY) / q.value
                ))
                .advice("check gain and cables; near a resonance the datasheet does not hold")
            })
        })
        .collect()
}

fn listed(
    campaign: &ShakerSingleCampaign,
    certificate: &Certificate,
    observed: &Observed,
) -> Vec<(String, String)> {
    let pair = |i: &Input| (i.path.clone(), i.sha256.clone());
    [&campaign.source.input, &certificate.input]
        .into_iter()
        .chain(&observed.inputs)
        .map(pair)
        .collect()
}

/// Sensitivities, run by run where the runs are given.
fn sensitivity(runs: Option<&[ComparisonRow]>, results: &[SingleAxis]) -> Result<Table, Failure> {
    let mut header = vec![
        "frequency_Hz",
        "real_V/(m/s2)",
        "imaginary_V/(m/s2)",
        "modulus_V/(m/s2)",
        "u_modulus_V/(m/s2)",
        "U_modulus_V/(m/s2)",
        "k",
        "nu_eff",
        "phase_deg",
        "u_phase_deg",
        "U_phase_deg",
    ];
    if runs.is_some() {
        header.insert(0, "run");
    }
    let mut table = Table::new(header);
    for (i, result) in results.iter().enumerate() {
        let (Some(m), Some(p)) = (result.estimate.get("modulus"), result.estimate.get("phase"))
        else {
            continue;
        };
        let mut cells: Vec<Cell> = runs
            .iter()
            .map(|runs| Cell::from(runs[i].run.as_str()))
            .collect();
        cells.extend(
            [
                result.frequency,
                result.sensitivity.re,
                result.sensitivity.im,
                m.value,
                m.standard_uncertainty,
                m.expanded(PROBABILITY),
                m.coverage_factor(PROBABILITY),
            ]
            .map(Cell::from),
        );
        cells.push(Cell::from((!m.dof.is_infinite()).then(|| m.dof.get())));
        cells.extend(
            [p.value, p.standard_uncertainty, p.expanded(PROBABILITY)]
                .map(|v| Cell::from(v.to_degrees())),
        );
        table.push(cells)?;
    }
    Ok(table)
}
