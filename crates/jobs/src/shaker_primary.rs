//! A single-axis accelerometer against a laser interferometer on the shaker.

mod files;
mod page;

use crate::bench_runs::{BenchFiles, BenchRuns};
use crate::device_output::DeviceOutput;
use crate::outcome::{Job, Outcome};
use crate::record::Record;
use crate::shaker_single::{ShakerSingleOutcome, against_datasheet};
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_documents::{AnyCalibration, StatedQuantity};
use proofmass_report::Report;
use proofmass_report::number::plain;
use proofmass_shaker::findings::excluded_run;
use proofmass_shaker::interferometer::QuadratureFit;
use proofmass_shaker::primary::{
    MethodCheck, PrimaryBudget, PrimaryRun, means, method_checks, quadrature_doubts, sensitivities,
    sign_of_motion, undeclared,
};
use proofmass_shaker::recording::{Assessed, Quality, QualityLimits, assess};
use proofmass_shaker::single_axis::{ComparisonRow, SingleAxis};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

/// What is to be calibrated, and what is known of the bench beside the recordings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ShakerPrimaryJob {
    /// Wavelength that the accelerations were found with, m.
    pub wavelength: f64,
    /// What is known of the bench.
    pub budget: PrimaryBudget,
    /// Rules of a sound run.
    #[serde(default)]
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

impl ShakerPrimaryJob {
    /// Of a device in volts.
    pub fn new(wavelength: f64, budget: PrimaryBudget) -> Self {
        Self {
            wavelength,
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
pub struct ShakerPrimaryRun {
    /// Name, frequency and the two phasors with what is known of them.
    pub run: PrimaryRun,
    /// The ellipse of the quadrature signals.
    pub quadrature: QuadratureFit,
    /// Acceleration wanted, m/s².
    pub target: Option<f64>,
    /// What the samples said.
    pub quality: Quality,
}

/// The runs of a primary calibration as phasors.
pub type ShakerPrimaryData<'a> = BenchRuns<'a, ShakerPrimaryRun>;

/// Sensitivity at every frequency, and what other methods say of its modulus.
#[derive(Clone, Debug, PartialEq)]
pub struct ShakerPrimaryOutcome {
    stated: ShakerSingleOutcome,
    runs: Vec<ShakerPrimaryRun>,
    checks: Vec<MethodCheck>,
}

impl ShakerPrimaryOutcome {
    /// Sensitivity at every frequency, repeats averaged.
    pub fn results(&self) -> &[SingleAxis] {
        self.stated.results()
    }

    /// Fringe counting and minimum point beside the sine approximation, where the data allow.
    pub fn checks(&self) -> &[MethodCheck] {
        &self.checks
    }
}

impl Outcome for ShakerPrimaryOutcome {
    const KIND: &'static str = "shaker-primary";
    const PRINCIPAL_TABLE: &'static str = "sensitivity.csv";

    fn title(&self, record: &Record) -> String {
        record.title(
            "Primary calibration of",
            "Primary calibration of an accelerometer by laser interferometry",
        )
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.stated.quantities()
    }

    fn findings(&self) -> &[Finding] {
        self.stated.findings()
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        self.stated.sections()
    }

    fn calibration(&self, record: &Record) -> Result<Option<AnyCalibration>> {
        self.stated.calibration_by("interferometry", record)
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }
}

impl Job for ShakerPrimaryJob {
    type Data<'a> = ShakerPrimaryData<'a>;
    type Outcome = ShakerPrimaryOutcome;

    fn evaluate(
        &self,
        data: &ShakerPrimaryData<'_>,
        watch: &dyn Watch,
    ) -> Result<ShakerPrimaryOutcome> {
        watch.step("sensitivities", 0, 1)?;
        let mut findings = data.findings.to_vec();
        let mut runs = Vec::new();
        for run in data.runs {
            let PrimaryRun {
                run: name,
                frequency,
                ..
            } = &run.run;
            if self.excluded.contains(name) {
                findings.push(excluded_run(name, *frequency));
                continue;
            }
            let assessed = Assessed {
                run: name,
                frequency: *frequency,
                quality: &run.quality,
                channels: &CHANNELS,
                amplitude: run.run.acceleration.norm(),
                target: run.target,
            };
            findings.extend(assess(&assessed, &self.limits));
            findings.extend(quadrature_doubts(&run.run, &run.quadrature));
            runs.push(run.clone());
        }
        if runs.is_empty() {
            return Err(Trouble::data(format!("{}: no run is left", data.name))
                .with_hint("take names out of `exclude` in [runs], or measure again"));
        }
        let own: Vec<PrimaryRun> = runs.iter().map(|r| r.run.clone()).collect();
        let output = DeviceOutput::Volt;
        let single = sensitivities(&own, output.unit(), &self.budget)?;
        let (results, doubts) = means(&own, &single)?;
        findings.extend(doubts);
        let (checks, doubts) = method_checks(&own, &results);
        findings.extend(doubts);
        findings.extend(sign_of_motion(&results));
        findings.extend(undeclared(&self.budget));
        findings.extend(against_datasheet(self.datasheet, &results));
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        watch.step("sensitivities", 1, 1)?;
        let rows = own.iter().map(|run| ComparisonRow {
            run: run.run.clone(),
            frequency: run.frequency,
            reference: run.acceleration,
            output: run.output,
            transverse: run.transverse,
            covariance: run.noise,
        });
        let reference = format!(
            "laser interferometer, λ = {} nm",
            plain(1e9 * self.wavelength)
        );
        Ok(ShakerPrimaryOutcome {
            stated: ShakerSingleOutcome::stated(
                (single, results),
                rows.collect(),
                (output, reference),
                findings,
                self.coverage_factor,
            ),
            runs,
            checks,
        })
    }
}

/// Names of the channels that the quality of a run is about.
const CHANNELS: [&str; 2] = ["interferometer", "output"];

/// Everything the files of a campaign say.
pub type ShakerPrimaryFiles = BenchFiles<ShakerPrimaryJob, ShakerPrimaryRun>;
