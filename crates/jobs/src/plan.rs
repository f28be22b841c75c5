//! What a campaign on the shaker will achieve, before anything is measured.

mod page;

use crate::campaign::{ShakerBudget, ShakerTriaxialCampaign};
use crate::outcome::{Job, Outcome};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use num_complex::Complex64;
use page::PlanReport;
use proofmass_core::{Error, Watch};
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_io::{Cell, Input, StatedQuantity, Table};
use proofmass_report::Report;
use proofmass_shaker::geometry::published_plan;
use proofmass_shaker::matrix::Matrix;
use proofmass_shaker::plan::{
    Conditioning, Expected, PlanCost, Predicted, best, conditioning, costs, predict,
};
use proofmass_shaker::{
    Budget, Configuration, Correction, Spurious, SpuriousTable, with_certificate,
};
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};

/// Most candidates: their joint prediction is adjusted as one campaign, which grows with the cube of their number.
pub const MOST_CANDIDATES: usize = 1000;

/// Which plan is asked about.
///
/// ```
/// use proofmass_shaker::{Acts, Budget, ShakerInput, Key};
/// use proofmass_jobs::{Job, Unwatched, plan::PlanJob};
/// let noise = ShakerInput::new("noise", Acts::OutputAdditive, 5e-5, &[Key::Run, Key::Channel]);
/// let mut job = PlanJob::new(Budget::new(vec![noise])?);
/// job.best = Some(12);
/// let outcome = job.evaluate(&(), &Unwatched)?;
/// assert_eq!(outcome.configurations().len(), 12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PlanJob {
    /// Configurations to choose from.
    pub candidates: Vec<Configuration>,
    /// Where they come from, for the report.
    pub origin: String,
    /// What will be uncertain.
    pub budget: Budget,
    /// Certificate of the reference.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceTable>,
    /// Frequency whose uncertainty of the reference counts, Hz.
    pub frequency: f64,
    /// Choose the best of so many; `None` is all candidates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub best: Option<usize>,
    /// Numbers of configurations to compare; empty is a series up to all candidates.
    #[serde(default)]
    pub sizes: Vec<usize>,
    /// Expected main sensitivity, V/(m/s²); `None` reckons with 10 mV/(m/s²).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensitivity: Option<f64>,
    /// Acceleration, m/s².
    pub amplitude: f64,
    /// Spurious motion as it will be known: the correction that the campaign will be made with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correction: Option<Correction>,
    /// What is doubtful about the bench beforehand, such as a resonance of a wedge.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub findings: Vec<Finding>,
}

impl PlanJob {
    /// All 44 published configurations at 10 m/s² and 160 Hz.
    pub fn new(budget: Budget) -> Self {
        Self {
            candidates: published_plan(),
            origin: "the published ones".to_owned(),
            budget,
            reference: None,
            frequency: 160.0,
            best: None,
            sizes: Vec::new(),
            sensitivity: None,
            amplitude: 10.0,
            correction: None,
            findings: Vec::new(),
        }
    }

    /// What the correction says of the spurious motion at the frequency of the plan: of its nearest frequency, and of an
    /// inclination that it does not have as little as of the one it knows least.
    fn spurious(&self) -> (SpuriousTable, Option<Finding>) {
        let Some(correction) = &self.correction else {
            return (SpuriousTable::default(), None);
        };
        let entries = &correction.table.entries;
        let far = |e: &Spurious| (e.frequency / self.frequency).ln().abs();
        let Some(nearest) = entries.iter().min_by(|a, b| far(a).total_cmp(&far(b))) else {
            return (SpuriousTable::default(), None);
        };
        let at = nearest.frequency;
        let mut table = SpuriousTable {
            entries: entries
                .iter()
                .filter(|e| e.frequency == at)
                .cloned()
                .collect(),
        };
        for e in &mut table.entries {
            e.frequency = self.frequency;
        }
        let size = |e: &Spurious| e.covariance.iter().map(|c| c[0] + c[2]).sum::<f64>();
        let worst = table
            .entries
            .iter()
            .max_by(|a, b| size(a).total_cmp(&size(b)))
            .cloned();
        let mut missing = 0;
        for c in &self.candidates {
            if table.get(c.inclination, self.frequency).is_none()
                && let Some(worst) = &worst
            {
                missing += 1;
                table.entries.push(Spurious {
                    inclination: c.inclination,
                    ratio: [Complex64::new(0.0, 0.0); 3],
                    ..worst.clone()
                });
            }
        }
        let root = (worst.as_ref().map_or(0.0, size) / 6.0).sqrt();
        let told = Finding::new(
            Severity::Note,
            "spurious-motion-expected",
            format!(
                "the uncertainty of the spurious motion is that of the correction \"{}\" at {at} Hz",
                correction.label
            ),
        )
        .evidence(format!(
            "u = {root:.1e} of the excitation in each part of a ratio where it is known least; {missing} inclinations are not \
             in the table and were reckoned with that"
        ))
        .advice("more repeats of the measurement of the spurious motion bring the cross terms down");
        (table, Some(told))
    }

    /// Equal main terms and cross terms of 1 %: what a sound device has.
    fn matrix(&self) -> Matrix {
        let main = self.sensitivity.unwrap_or(0.01);
        std::array::from_fn(|i| {
            std::array::from_fn(|j| Complex64::new(main * if i == j { 1.0 } else { 0.01 }, 0.0))
        })
    }

    fn sizes(&self) -> Result<Vec<usize>> {
        let count = self.candidates.len();
        if self.sizes.is_empty() {
            let mut sizes: Vec<usize> = [4, 6, 8, 10, 12, 16, 20, 24, 32, 40, 60, 100]
                .into_iter()
                .filter(|&n| n < count)
                .collect();
            sizes.push(count);
            return Ok(sizes);
        }
        let mut sizes = self.sizes.clone();
        sizes.sort_unstable();
        sizes.dedup();
        match sizes.iter().find(|n| !(3..=count).contains(*n)) {
            Some(n) => Err(Trouble::request(format!(
                "a plan of {n}: there are {count} candidates, and three are needed"
            ))
            .with_hint(format!("give numbers from 3 to {count}"))),
            None => Ok(sizes),
        }
    }
}

/// Conditioning, predicted uncertainties and what fewer configurations would cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanOutcome {
    findings: Vec<Finding>,
    budget: Budget,
    candidates: Vec<Configuration>,
    origin: String,
    configurations: Vec<Configuration>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    chosen: Option<Vec<usize>>,
    conditioning: Conditioning,
    predicted: Vec<Predicted>,
    costs: Vec<PlanCost>,
    sensitivity: f64,
    amplitude: f64,
    frequency: f64,
}

impl PlanOutcome {
    /// The plan.
    pub fn configurations(&self) -> &[Configuration] {
        &self.configurations
    }

    /// Predicted uncertainty of every term of S.
    pub fn predicted(&self) -> &[Predicted] {
        &self.predicted
    }

    /// The best plans of other sizes.
    pub fn costs(&self) -> &[PlanCost] {
        &self.costs
    }

    fn page(&self, record: &Record) -> PlanReport<'_> {
        let mut head = record.head(self.title(record), &self.findings);
        head.meta = vec![
            (
                "Candidates".to_owned(),
                format!("{}, {}", self.candidates.len(), self.origin),
            ),
            (
                "Expected".to_owned(),
                format!(
                    "{} mV/(m/s²) at {} m/s², reference as at {} Hz",
                    1e3 * self.sensitivity,
                    self.amplitude,
                    self.frequency
                ),
            ),
        ];
        if let Some(date) = &record.date {
            head.meta.push(("Evaluated on".to_owned(), date.clone()));
        }
        PlanReport {
            head,
            candidates: &self.candidates,
            chosen: self.chosen.as_deref(),
            costs: &self.costs,
        }
    }
}

impl Outcome for PlanOutcome {
    const KIND: &'static str = "plan";

    fn title(&self, record: &Record) -> String {
        record
            .title
            .clone()
            .unwrap_or_else(|| "Plan of a campaign on the shaker".to_owned())
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        Vec::new()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn tables(&self) -> Result<Vec<(String, Table)>> {
        Ok(vec![
            ("plan.csv".to_owned(), configurations(&self.configurations)?),
            ("predicted.csv".to_owned(), prediction(&self.predicted)?),
            ("costs.csv".to_owned(), cost_table(&self.costs)?),
        ])
    }

    fn summary(&self, record: &Record) -> Report {
        self.page(record)
            .summary(&self.conditioning, &self.predicted)
    }

    fn report(&self, record: &Record) -> Report {
        self.page(record).full(&self.conditioning, &self.predicted)
    }
}

impl Job for PlanJob {
    type Data<'a> = ();
    type Outcome = PlanOutcome;

    fn evaluate(&self, (): &(), watch: &dyn Watch) -> Result<PlanOutcome> {
        let count = self.candidates.len();
        if count > MOST_CANDIDATES {
            return Err(Trouble::request(format!(
                "{count} candidates, {}; {MOST_CANDIDATES} at most",
                self.origin
            ))
            .with_hint("neighbouring directions are alike: choose a grid of a degree or two, or divide the plan"));
        }
        let hopeless = |e: Error| {
            Trouble::from(e)
                .detail(format!("{count} candidates, {}", self.origin))
                .with_hint("three directions that span space are needed; add configurations to the plan, or check that [[budget]] has an additive noise (acts = \"output-additive\")")
        };
        let budget = with_certificate(&self.budget, self.reference.as_ref(), [self.frequency])
            .map_err(|e| {
                Trouble::from(e)
                    .detail(format!("at {} Hz", self.frequency))
                    .with_hint("give a frequency that the certificate of the reference reaches")
            })?;
        let chosen = match self.best {
            Some(n) if !(3..=count).contains(&n) => {
                return Err(Trouble::request(format!(
                    "the best {n}: there are {count} candidates, and three are needed"
                ))
                .with_hint(format!("give a number from 3 to {count}")));
            }
            Some(n) => Some(best(&self.candidates, n).map_err(hopeless)?),
            None => None,
        };
        let plan: Vec<Configuration> = match &chosen {
            Some(list) => list.iter().map(|&k| self.candidates[k]).collect(),
            None => self.candidates.clone(),
        };
        let s = self.matrix();
        let quality = conditioning(&plan).map_err(hopeless)?;
        let (spurious, told) = self.spurious();
        let expected = Expected {
            budget: &budget,
            spurious: &spurious,
            sensitivity: &s,
            amplitude: self.amplitude,
            frequency: self.frequency,
        };
        let predicted = predict(&plan, &expected).map_err(hopeless)?;
        let sizes = self.sizes()?;
        let mut list = Vec::with_capacity(sizes.len());
        for (k, size) in sizes.iter().enumerate() {
            watch.step("plans", k as u64, sizes.len() as u64)?;
            list.extend(costs(&self.candidates, &[*size], &expected).map_err(hopeless)?);
        }
        watch.step("plans", sizes.len() as u64, sizes.len() as u64)?;
        let mut findings = self.findings.clone();
        findings.extend(told);
        if self.sensitivity.is_none() {
            findings.push(
                Finding::new(
                    Severity::Note,
                    "sensitivity-assumed",
                    "the expected sensitivity is not stated, so 10 mV/(m/s²) was reckoned with",
                )
                .evidence("the campaign has no [datasheet]")
                .advice("it matters where additive noise does; add [datasheet] with sensitivity, tolerance and unit"),
            );
        }
        Ok(PlanOutcome {
            findings,
            budget,
            candidates: self.candidates.clone(),
            origin: self.origin.clone(),
            configurations: plan,
            chosen,
            conditioning: quality,
            predicted,
            costs: list,
            sensitivity: self.sensitivity.unwrap_or(0.01),
            amplitude: self.amplitude,
            frequency: self.frequency,
        })
    }
}

impl ShakerTriaxialCampaign {
    /// The question about the plan of the campaign at a frequency, Hz, and the files it was read from. The candidates are its plan, or
    /// else the configurations of its runs, or else the 44 published ones.
    ///
    /// # Errors
    /// A table that cannot be read.
    pub fn plan_job(&self, frequency: f64) -> Result<(PlanJob, Vec<Input>)> {
        let mut inputs = vec![self.source.input.clone()];
        let budget = self.read_budget()?;
        let certificate = self.read_reference()?;
        let mut job = PlanJob::new(budget.budget(certificate.is_some()));
        let mut frequencies = vec![frequency];
        match self.read_plan()? {
            Some((plan, input)) => {
                inputs.extend(input);
                (job.candidates, job.origin) = (plan, "the plan of the campaign".to_owned());
            }
            None if self.runs.is_some() => {
                let table = self.read_runs()?;
                let mut list: Vec<Configuration> = Vec::new();
                for run in &table.runs {
                    frequencies.push(run.frequency_hz);
                    let c = run.seat.configuration;
                    if !list.iter().any(|o| o.same_as(&c)) {
                        list.push(c);
                    }
                }
                inputs.push(table.input);
                (job.candidates, job.origin) = (list, "those of the runs".to_owned());
            }
            None => {}
        }
        if let ShakerBudget::Inputs(_, Some(input)) = &budget {
            inputs.push(input.clone());
        }
        if let Some(certificate) = certificate {
            inputs.push(certificate.input);
            job.reference = Some(certificate.table);
        }
        // Of several corrections the last is the best known; one without a file corrects nothing.
        for file in self.read_corrections()? {
            inputs.extend(file.input);
            if !file.correction.table.entries.is_empty() {
                let Correction { label, table } = file.correction;
                let (table, _) = table.pooled(&label);
                job.correction = Some(Correction { label, table });
            }
        }
        job.sensitivity = self.datasheet.map(|d| d.0);
        if let Some(amplitude) = self.plan.as_ref().and_then(|p| p.amplitude) {
            job.amplitude = amplitude;
        }
        job.frequency = frequency;
        frequencies.sort_by(f64::total_cmp);
        frequencies.dedup();
        let points = job
            .candidates
            .iter()
            .flat_map(|c| frequencies.iter().map(|f| (c.inclination, *f)));
        job.findings = self.fixture_findings(&points.collect::<Vec<_>>())?;
        Ok((job, inputs))
    }
}

/// The plan as a campaign reads it.
fn configurations(plan: &[Configuration]) -> Result<Table> {
    let mut table = Table::new(["configuration", "inclination_deg", "rotation_deg"]);
    for (i, c) in plan.iter().enumerate() {
        // Radians of whole degrees come back with rounding in the last digit.
        let degrees = |angle: f64| Cell::from((angle.to_degrees() * 1e9).round() / 1e9);
        table.push([
            Cell::from(i + 1),
            degrees(c.inclination),
            degrees(c.rotation),
        ])?;
    }
    Ok(table)
}

fn prediction(predicted: &[Predicted]) -> Result<Table> {
    let mut table = Table::new(["term", "u_real_%", "u_imaginary_%"]);
    for p in predicted {
        table.push([
            Cell::from(p.term.as_str()),
            Cell::from(100.0 * p.relative_real),
            Cell::from(100.0 * p.relative_imaginary),
        ])?;
    }
    Ok(table)
}

fn cost_table(costs: &[PlanCost]) -> Result<Table> {
    let mut table = Table::new([
        "configurations",
        "u_main_%",
        "u_cross_%",
        "condition",
        "D_efficiency",
        "A_efficiency",
        "candidates",
    ]);
    for c in costs {
        let chosen: Vec<String> = c.chosen.iter().map(|k| (k + 1).to_string()).collect();
        table.push([
            Cell::from(c.conditioning.count),
            Cell::from(100.0 * c.main),
            Cell::from(100.0 * c.cross),
            Cell::from(c.conditioning.condition),
            Cell::from(c.conditioning.d_efficiency),
            Cell::from(c.conditioning.a_efficiency),
            Cell::Text(chosen.join(" ")),
        ])?;
    }
    Ok(table)
}
