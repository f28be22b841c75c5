//! A single-axis accelerometer against a reference on the shaker.

mod files;
pub(crate) mod page;

use crate::bench_runs::{BenchFiles, BenchRuns};
use crate::device_output::DeviceOutput;
use crate::frequency_response;
use crate::measured_within::MeasuredWithin;
use crate::outcome::{Job, Outcome};
use crate::record::Record;
use crate::sensor_clock::SensorClock;
use crate::shaker_triaxial::stated;
use crate::trouble::{Result, Trouble};
use num_complex::Complex64;
use proofmass_core::Watch;
use proofmass_documents::{AnyCalibration, StatedQuantity};
use proofmass_dynamic::FrequencyResponse;
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_report::Report;
use proofmass_shaker::check_standard::{CheckPoint, against_known};
use proofmass_shaker::datasheet::{OffDatasheet, off_datasheet_over_frequency};
use proofmass_shaker::derived::{Expanded, PROBABILITY};
use proofmass_shaker::findings::{excluded_run, reference_out_of_range};
use proofmass_shaker::recording::{Assessed, Quality, QualityLimits, assess};
use proofmass_shaker::sample_clock::SampleClock;
use proofmass_shaker::single_axis::{
    ComparisonBudget, ComparisonRow, SingleAxis, combine, compare,
};
use proofmass_shaker::{reference_gap, swapped_cables};
use proofmass_uncertainty::{Estimate, EvidenceValue, Finding, Quantity};
use serde::{Deserialize, Serialize};

/// What is to be compared, and how well a reading is known.
///
/// ```
/// use num_complex::Complex64;
/// use proofmass_shaker::recording::Quality;
/// use proofmass_dynamic::reference_table::{ReferencePoint, ReferenceTable};
/// use proofmass_shaker::single_axis::{ComparisonBudget, ComparisonRow};
/// use proofmass_jobs::shaker_single::{ShakerSingleData, ShakerSingleJob, ShakerSingleRun};
/// use proofmass_jobs::{Job, Outcome, Unwatched};
/// use proofmass_uncertainty::DegreesOfFreedom;
///
/// let certificate = ReferenceTable::new(vec![ReferencePoint {
///     frequency: 160.0, sensitivity: 0.01, phase: 0.0, modulus_uncertainty: 0.002, phase_uncertainty: 0.001,
/// }])?;
/// let reading = ComparisonBudget {
///     ratio: 0.001, phase: 0.002, dof: DegreesOfFreedom::INFINITE, transverse: None, front_end: 0.0, free_phase: false,
/// };
/// let runs = [ShakerSingleRun {
///     row: ComparisonRow {
///         run: "a".into(), frequency: 160.0, transverse: Some(0.02), covariance: [[0.0; 3]; 2],
///         reference: Complex64::new(0.1, 0.0), output: Complex64::new(0.2, 0.0),
///     },
///     check: None, target: None, quality: Quality::default(), place: "line 1".into(),
/// }];
/// let outcome = ShakerSingleJob::new(Some(certificate), reading).evaluate(&ShakerSingleData::new(&runs), &Unwatched)?;
/// let modulus = &outcome.quantities()[0];
/// assert!((modulus.value - 0.02).abs() < 1e-12 && modulus.expanded > 8e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ShakerSingleJob {
    /// Certificate of the reference; `None` when the runs carry accelerations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceTable>,
    /// Which standard it is and who calibrated it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_description: Option<String>,
    /// What the device gives.
    #[serde(default)]
    pub output: DeviceOutput,
    /// Calibration of a check standard on the same table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub check_standard: Option<ReferenceTable>,
    /// Unit of what the check standard gives.
    #[serde(default)]
    pub check_output: DeviceOutput,
    /// By whose clock the device samples that has a file of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample_clock: Option<SampleClock>,
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
    /// A coverage factor such as 2 that U is stated with, instead of that of 95 %.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coverage_factor: Option<f64>,
}

impl ShakerSingleJob {
    /// A comparison with this reference, or with runs that carry accelerations, of a device in volts.
    pub fn new(reference: Option<ReferenceTable>, budget: ComparisonBudget) -> Self {
        Self {
            reference,
            reference_description: None,
            output: DeviceOutput::default(),
            check_standard: None,
            check_output: DeviceOutput::default(),
            sample_clock: None,
            budget,
            limits: QualityLimits::default(),
            datasheet: None,
            excluded: Vec::new(),
            coverage_factor: None,
        }
    }
}

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct ShakerSingleRun {
    /// Name, frequency and the two phasors.
    pub row: ComparisonRow,
    /// Output of the check standard with its covariance rr, ri, ii, where there is one.
    pub check: Option<(Complex64, [f64; 3])>,
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
#[derive(Clone, Debug, PartialEq)]
pub struct ShakerSingleOutcome {
    quantities: Vec<StatedQuantity>,
    findings: Vec<Finding>,
    results: Vec<SingleAxis>,
    /// Run by run, before the mean of repeats.
    single: Vec<SingleAxis>,
    runs: Vec<ComparisonRow>,
    output: DeviceOutput,
    check_standard: Vec<CheckPoint>,
    reference: Option<String>,
    clock: Option<SensorClock>,
    within: MeasuredWithin,
    coverage_factor: Option<f64>,
}

impl ShakerSingleOutcome {
    /// Sensitivities that were found against another reference, stated as those of a comparison: run by run, and their means.
    pub(crate) fn stated(
        (single, results): (Vec<SingleAxis>, Vec<SingleAxis>),
        runs: Vec<ComparisonRow>,
        (output, reference): (DeviceOutput, String),
        findings: Vec<Finding>,
        coverage_factor: Option<f64>,
    ) -> Self {
        Self {
            quantities: quantities(&results, coverage_factor).collect(),
            findings,
            results,
            single,
            within: MeasuredWithin::amplitudes(runs.iter().map(|r| r.reference.norm())),
            runs,
            output,
            check_standard: Vec::new(),
            reference: Some(reference),
            clock: None,
            coverage_factor,
        }
    }

    /// Sensitivity at every frequency, repeats averaged.
    pub fn results(&self) -> &[SingleAxis] {
        &self.results
    }

    /// The frequency response, found by this method.
    pub(crate) fn calibration_by(
        &self,
        method: &str,
        record: &Record,
    ) -> Result<Option<AnyCalibration>> {
        let points: Vec<_> = self
            .results
            .iter()
            .map(|r| (r.frequency, &r.estimate))
            .collect();
        // Without a phase there is nothing to compensate with.
        let known = |p: &(f64, &Estimate)| p.1.index_of("phase").is_some();
        if points.is_empty() || !points.iter().all(known) {
            return Ok(None);
        }
        // The certificate behind them says nothing of the correlation of its lines.
        let response = FrequencyResponse::from_polar("axis", &points, None)?;
        let file = frequency_response::to_file(&response, method, self.output.of_device(), record);
        Ok(Some(file.into()))
    }

    /// The check standard against what is known of it, where there is one.
    pub fn check_standard(&self) -> &[CheckPoint] {
        &self.check_standard
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

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![self.within.section()?])
    }

    fn calibration(&self, record: &Record) -> Result<Option<AnyCalibration>> {
        self.calibration_by("comparison", record)
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
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
        let (single, doubts) = compare(
            &runs,
            self.reference.as_ref(),
            self.output.unit(),
            &self.budget,
        )?;
        findings.extend(doubts);
        findings.extend(reference_gap(
            self.reference.as_ref(),
            runs.iter().map(|r| r.frequency),
        ));
        let (results, doubts) = combine(&runs, &single, &self.budget)?;
        findings.extend(doubts);
        findings.extend(against_datasheet(self.datasheet, &results));
        if let (Some(table), DeviceOutput::Volt) = (&self.reference, self.output) {
            let swapped = swapped_cables(&runs, &single, table, self.datasheet);
            // A run whose cables were exchanged is no repeat for that reason.
            let named = |f: &Finding| match f.evidence_fields().get("run") {
                Some(EvidenceValue::Text(run)) => {
                    swapped.iter().any(|s| s.evidence_text().contains(run))
                }
                _ => false,
            };
            findings.retain(|f| f.code() != "no-repeat" || !named(f));
            findings.extend(swapped);
        }
        let check_standard = self.check(data, &runs, &mut findings)?;
        let clock = self.clock(data, &results, &mut findings);
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        watch.step("comparison", 1, 1)?;
        Ok(ShakerSingleOutcome {
            quantities: quantities(&results, self.coverage_factor)
                .chain(clock.iter().flat_map(SensorClock::quantities))
                .collect(),
            findings,
            results,
            single,
            within: MeasuredWithin::runs(
                self.reference.as_ref(),
                runs.iter().map(|r| (r.frequency, r.reference)),
            ),
            runs,
            output: self.output,
            check_standard,
            reference: self.reference_description.clone(),
            clock,
            coverage_factor: self.coverage_factor,
        })
    }
}

impl ShakerSingleJob {
    /// Error of the device's clock, and its delay where the clock is shared.
    fn clock(
        &self,
        data: &ShakerSingleData<'_>,
        results: &[SingleAxis],
        findings: &mut Vec<Finding>,
    ) -> Option<SensorClock> {
        let clock = self.sample_clock?;
        let runs = data.runs.iter();
        let used = runs.filter(|r| !self.excluded.contains(&r.row.run));
        let qualities = used.map(|r| (r.row.run.as_str(), &r.quality));
        let phases = results.iter().filter_map(|r| {
            let phase = r.estimate.get("phase")?;
            Some((r.frequency, phase.value, phase.standard_uncertainty))
        });
        let own = [
            "the phase against the reference is not determined",
            "moduli are calibrated; calibration.json, which needs a phase, is not written",
        ];
        let found = SensorClock::of(clock, qualities, || phases.collect(), own, findings);
        Some(found)
    }

    /// The check standard in the runs that were used.
    fn check(
        &self,
        data: &ShakerSingleData<'_>,
        used: &[ComparisonRow],
        findings: &mut Vec<Finding>,
    ) -> Result<Vec<CheckPoint>> {
        let Some(known) = &self.check_standard else {
            return Ok(Vec::new());
        };
        let rows: Vec<ComparisonRow> = used
            .iter()
            .filter_map(|row| {
                let run = data.runs.iter().find(|r| r.row.run == row.run)?;
                let (output, noise) = run.check?;
                Some(ComparisonRow {
                    output,
                    covariance: [row.covariance[0], noise],
                    ..row.clone()
                })
            })
            .collect();
        let unit = self.check_output.unit();
        let (single, _) = compare(&rows, self.reference.as_ref(), unit, &self.budget)?;
        let (means, _) = combine(&rows, &single, &self.budget)?;
        let (points, doubts) = against_known(&means, known).map_err(|e| {
            Trouble::from(e)
                .detail("the calibration of the check standard reaches no run")
                .with_hint(
                    "name the calibration of [check_standard] at these frequencies, or take it out",
                )
        })?;
        findings.extend(doubts);
        Ok(points)
    }

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
                findings.push(excluded_run(&row.run, row.frequency));
                continue;
            }
            let Ok(point) = self
                .reference
                .as_ref()
                .map(|t| t.at(row.frequency))
                .transpose()
            else {
                beyond.push(format!("{} ({} Hz, {})", row.run, row.frequency, run.place));
                continue;
            };
            for (channel, amplitude) in [
                ("reference", Some(row.reference.norm())),
                ("device", Some(row.output.norm())),
                ("check standard", run.check.map(|c| c.0.norm())),
            ] {
                if amplitude == Some(0.0) {
                    return Err(Trouble::data(format!(
                        "{}: run {} has no signal of the {channel}",
                        run.place, row.run
                    ))
                    .with_hint("measure the run again, or take its row out"));
                }
            }
            let assessed = Assessed {
                run: &row.run,
                frequency: row.frequency,
                quality: &run.quality,
                channels: &CHANNELS,
                amplitude: row.reference.norm() / point.map_or(1.0, |p| p.sensitivity),
                target: run.target,
            };
            findings.extend(assess(&assessed, &self.limits));
            rows.push(row.clone());
        }
        if let (false, Some(table)) = (beyond.is_empty(), &self.reference) {
            let points = table.points();
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
            findings.push(reference_out_of_range(
                "some runs, which were left out",
                &format!("{covers}; runs {}", beyond.join(", ")),
            ));
        }
        Ok(rows)
    }
}

/// Modulus and phase at every frequency, as they are stated.
fn quantities(
    results: &[SingleAxis],
    coverage_factor: Option<f64>,
) -> impl Iterator<Item = StatedQuantity> {
    results.iter().flat_map(move |result| {
        result.estimate.quantities().into_iter().map(move |q| {
            let name = format!("S.{}", q.name);
            let quantity = Expanded::of(Quantity { name, ..q }, coverage_factor);
            stated(&quantity, result.frequency)
        })
    })
}

/// A sensitivity off its datasheet by more than tolerance and uncertainty together. At the frequency nearest to 160 Hz, where datasheets are
/// made, it may be a decision; it stands for frequencies that are off by the same factor.
pub(crate) fn against_datasheet(
    datasheet: Option<(f64, f64)>,
    results: &[SingleAxis],
) -> Vec<Finding> {
    let Some((nominal, tolerance)) = datasheet else {
        return Vec::new();
    };
    let of = |result: &SingleAxis| {
        let q = result.estimate.get("modulus")?;
        let off = OffDatasheet {
            name: None,
            relative: q.value / nominal - 1.0,
            allowed: tolerance.hypot(q.expanded(PROBABILITY)) / nominal,
        };
        Some((result.frequency, off))
    };
    off_datasheet_over_frequency(results.iter().filter_map(of).collect())
}

/// Names of the channels that the quality of a run is about.
const CHANNELS: [&str; 2] = ["reference", "output"];

/// Everything the files of a campaign say.
pub type ShakerSingleFiles = BenchFiles<ShakerSingleJob, ShakerSingleRun>;
