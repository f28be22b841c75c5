//! A single-axis accelerometer against a reference on the shaker.

use crate::bench_runs::{BenchFiles, BenchRuns};
use crate::campaign::ShakerSingleCampaign;
use crate::frequency_response;
use crate::observed::observe;
use crate::outcome::{Job, Outcome};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_calibration::FrequencyResponse;
use proofmass_calibration::shaker::derived::PROBABILITY;
use proofmass_calibration::shaker::recording::{Assessed, Quality, QualityLimits, assess};
use proofmass_calibration::shaker::reference::ReferenceTable;
use proofmass_calibration::shaker::single_axis::{
    ComparisonBudget, ComparisonRow, SingleAxis, combine, compare,
};
use proofmass_core::Watch;
use proofmass_io::{AnyCalibration, Cell, StatedQuantity, Table, Unit};
use proofmass_report::{Report, SingleAxisReport};
use proofmass_uncertainty::{DegreesOfFreedom, Finding, Quantity, Severity};
use serde::{Deserialize, Serialize};

/// What is to be compared, and how well a reading is known.
///
/// ```
/// use num_complex::Complex64;
/// use proofmass_calibration::shaker::recording::Quality;
/// use proofmass_calibration::shaker::reference::{ReferencePoint, ReferenceTable};
/// use proofmass_calibration::shaker::single_axis::{ComparisonBudget, ComparisonRow};
/// use proofmass_jobs::shaker_single::{ShakerSingleData, ShakerSingleJob, ShakerSingleRun};
/// use proofmass_jobs::{Job, Outcome, Unwatched};
/// use proofmass_uncertainty::DegreesOfFreedom;
///
/// let certificate = ReferenceTable::new(vec![ReferencePoint {
///     frequency: 160.0, sensitivity: 0.01, phase: 0.0, modulus_uncertainty: 0.002, phase_uncertainty: 0.001,
/// }])?;
/// let reading = ComparisonBudget { ratio: 0.001, phase: 0.002, dof: DegreesOfFreedom::INFINITE };
/// let runs = [ShakerSingleRun {
///     row: ComparisonRow {
///         run: "a".into(), frequency: 160.0, transverse: Some(0.02),
///         reference: Complex64::new(0.1, 0.0), output: Complex64::new(0.2, 0.0),
///     },
///     target: None, quality: Quality::default(), place: "line 1".into(),
/// }];
/// let outcome = ShakerSingleJob::new(certificate, reading).evaluate(&ShakerSingleData::new(&runs), &Unwatched)?;
/// let modulus = &outcome.quantities()[0];
/// assert!((modulus.value - 0.02).abs() < 1e-12 && modulus.expanded > 8e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ShakerSingleJob {
    /// Certificate of the reference.
    pub reference: ReferenceTable,
    /// Which standard it is and who calibrated it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_description: Option<String>,
    /// Uncertainty of a reading.
    pub budget: ComparisonBudget,
    /// Rules of a sound run.
    pub limits: QualityLimits,
    /// Datasheet sensitivity and its tolerance, V/(m/s²).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub datasheet: Option<(f64, f64)>,
    /// Runs to be left out, by name.
    #[serde(default)]
    pub excluded: Vec<String>,
}

impl ShakerSingleJob {
    /// A comparison with this reference.
    pub fn new(reference: ReferenceTable, budget: ComparisonBudget) -> Self {
        Self {
            reference,
            reference_description: None,
            budget,
            limits: QualityLimits::default(),
            datasheet: None,
            excluded: Vec::new(),
        }
    }
}

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct ShakerSingleRun {
    /// Name, frequency and the two phasors in volts.
    pub row: ComparisonRow,
    /// Acceleration wanted, m/s².
    pub target: Option<f64>,
    /// What the samples said.
    pub quality: Quality,
    /// Where it stands, for messages.
    pub place: String,
}

/// The runs of a comparison as phasors.
pub type ShakerSingleData<'a> = BenchRuns<'a, ShakerSingleRun>;

/// Sensitivity at every frequency.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShakerSingleOutcome {
    quantities: Vec<StatedQuantity>,
    findings: Vec<Finding>,
    results: Vec<SingleAxis>,
    /// Run by run, before the mean of repeats.
    single: Vec<SingleAxis>,
    runs: Vec<ComparisonRow>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reference: Option<String>,
}

impl ShakerSingleOutcome {
    /// Sensitivity at every frequency, repeats averaged.
    pub fn results(&self) -> &[SingleAxis] {
        &self.results
    }

    fn page(&self, record: &Record) -> SingleAxisReport<'_> {
        let mut head = record.head(self.title(record), &self.findings);
        if let Some(reference) = &self.reference {
            head.meta.push(("Reference".to_owned(), reference.clone()));
        }
        SingleAxisReport {
            head,
            runs: &self.runs,
        }
    }
}

impl Outcome for ShakerSingleOutcome {
    const KIND: &'static str = "shaker-single";
    const PRINCIPAL_TABLE: &'static str = "sensitivity.csv";

    fn title(&self, record: &Record) -> String {
        record.title(
            "Calibration of",
            "Calibration of an accelerometer by comparison",
        )
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.quantities.clone()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn tables(&self) -> Result<Vec<(String, Table)>> {
        Ok(vec![
            (
                "sensitivity.csv".to_owned(),
                sensitivity(None, &self.results)?,
            ),
            (
                "repeats.csv".to_owned(),
                sensitivity(Some(&self.runs), &self.single)?,
            ),
        ])
    }

    fn calibration(&self, record: &Record) -> Result<Option<AnyCalibration>> {
        let points: Vec<_> = self
            .results
            .iter()
            .map(|r| (r.frequency, &r.estimate))
            .collect();
        if points.is_empty() {
            return Ok(None);
        }
        // The certificate behind them says nothing of the correlation of its lines.
        let response = FrequencyResponse::from_polar("axis", &points, None)?;
        let file = frequency_response::to_file(&response, "comparison", Unit::Volt, record);
        Ok(Some(file.into()))
    }

    fn summary(&self, record: &Record) -> Report {
        self.page(record).summary(&self.results)
    }

    fn report(&self, record: &Record) -> Report {
        self.page(record).full(&self.results)
    }
}

impl Job for ShakerSingleJob {
    type Data<'a> = ShakerSingleData<'a>;
    type Outcome = ShakerSingleOutcome;

    fn evaluate(
        &self,
        data: &ShakerSingleData<'_>,
        watch: &dyn Watch,
    ) -> Result<ShakerSingleOutcome> {
        watch.step("comparison", 0, 1)?;
        let mut findings = data.findings.to_vec();
        let runs = self.rows(data, &mut findings)?;
        let (single, doubts) = compare(&runs, &self.reference, &self.budget)?;
        findings.extend(doubts);
        let (results, doubts) = combine(&runs, &single, &self.budget)?;
        findings.extend(doubts);
        findings.extend(against_datasheet(self.datasheet, &results));
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        watch.step("comparison", 1, 1)?;
        let quantities = results.iter().flat_map(|result| {
            result.estimate.quantities().into_iter().map(|q| {
                let name = format!("S.{}[frequency={}]", q.name, result.frequency);
                StatedQuantity::new(&Quantity { name, ..q }, PROBABILITY)
            })
        });
        Ok(ShakerSingleOutcome {
            quantities: quantities.collect(),
            findings,
            results,
            single,
            runs,
            reference: self.reference_description.clone(),
        })
    }
}

impl ShakerSingleJob {
    /// Runs that the certificate reaches and nobody excluded, with what is doubtful about each.
    fn rows(
        &self,
        data: &ShakerSingleData<'_>,
        findings: &mut Vec<Finding>,
    ) -> Result<Vec<ComparisonRow>> {
        let mut rows = Vec::new();
        let mut beyond = Vec::new();
        for run in data.runs {
            let row = &run.row;
            if self.excluded.contains(&row.run) {
                findings.push(
                    Finding::new(
                        Severity::Note,
                        "excluded-run",
                        format!("run {} was left out as asked", row.run),
                    )
                    .evidence(format!("{} Hz", row.frequency)),
                );
                continue;
            }
            let Ok(point) = self.reference.at(row.frequency) else {
                beyond.push(format!("{} ({} Hz, {})", row.run, row.frequency, run.place));
                continue;
            };
            if row.reference.norm() == 0.0 {
                return Err(Trouble::data(format!(
                    "{}: run {} has no signal of the reference",
                    run.place, row.run
                ))
                .with_hint("measure the run again, or take its row out"));
            }
            let assessed = Assessed {
                run: &row.run,
                frequency: row.frequency,
                quality: &run.quality,
                channels: &ShakerSingleCampaign::CHANNELS,
                amplitude: row.reference.norm() / point.sensitivity,
                target: run.target,
            };
            findings.extend(assess(&assessed, &self.limits));
            rows.push(row.clone());
        }
        if !beyond.is_empty() {
            let points = self.reference.points();
            let covers = format!(
                "it covers {} Hz to {} Hz",
                points[0].frequency,
                points[points.len() - 1].frequency
            );
            if rows.is_empty() {
                return Err(Trouble::data(format!(
                    "{}: the certificate of the reference reaches no run",
                    data.name
                ))
                .detail(format!("{covers}; runs {}", beyond.join(", ")))
                .with_hint("have the reference calibrated there"));
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
}

/// A sensitivity off its datasheet by more than tolerance and uncertainty together.
fn against_datasheet(datasheet: Option<(f64, f64)>, results: &[SingleAxis]) -> Vec<Finding> {
    let Some((nominal, tolerance)) = datasheet else {
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

/// Everything the files of a campaign say.
pub type ShakerSingleFiles = BenchFiles<ShakerSingleJob, ShakerSingleRun>;

impl ShakerSingleCampaign {
    /// Reads the tables of the campaign and its recordings.
    ///
    /// # Errors
    /// A file that cannot be read, a recording without a sine, or `watch` wanted it to stop.
    pub fn load(&self, watch: &dyn Watch) -> Result<ShakerSingleFiles> {
        let table = self.read_runs()?;
        let certificate = self.read_reference()?;
        let observed = observe(
            &table,
            self.recording.as_ref(),
            || self.waveform_options(),
            watch,
        )?;
        let name = table.path.display().to_string();
        let runs = table
            .runs
            .iter()
            .zip(&observed.runs)
            .map(|(run, seen)| ShakerSingleRun {
                row: ComparisonRow {
                    run: run.run.clone(),
                    frequency: run.frequency_hz,
                    reference: seen.phasors[0],
                    output: seen.phasors[1],
                    transverse: run.seat.transverse,
                },
                target: run.seat.target,
                quality: seen.quality(None),
                place: format!("{name}:{}", run.line),
            })
            .collect();
        let reading = &self.reading;
        let budget = ComparisonBudget {
            ratio: reading.u_relative,
            phase: reading.u_phase_deg.to_radians(),
            dof: reading
                .dof
                .and_then(DegreesOfFreedom::new)
                .unwrap_or(DegreesOfFreedom::INFINITE),
        };
        let mut findings = certificate.findings;
        findings.extend(observed.findings);
        let mut inputs = vec![self.source.input.clone(), certificate.input];
        let recordings = observed.inputs.len() - 1;
        inputs.extend(observed.inputs);
        let mut job = ShakerSingleJob::new(certificate.table, budget);
        job.reference_description = certificate.description;
        job.datasheet = self.datasheet;
        job.excluded = self.runs.exclude.clone();
        Ok(ShakerSingleFiles {
            job,
            runs,
            findings,
            name,
            inputs,
            recordings,
        })
    }

    /// What the result is filed with.
    pub fn record(&self, files: &ShakerSingleFiles, date: Option<String>) -> Record {
        files.record(&self.title, &self.device, &self.ambient, date)
    }
}

/// Sensitivities, run by run where the runs are given.
fn sensitivity(runs: Option<&[ComparisonRow]>, results: &[SingleAxis]) -> Result<Table> {
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
