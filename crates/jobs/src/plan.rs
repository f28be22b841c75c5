//! What a campaign on the shaker will achieve, before anything is measured.

mod page;

use crate::campaign::{Certificate, ShakerBudget, ShakerTable, ShakerTriaxialCampaign};
use crate::findings;
use crate::outcome::{Job, Outcome};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_core::{Error, Watch};
use proofmass_documents::StatedQuantity;
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_io::Input;
use proofmass_report::Report;
use proofmass_shaker::geometry::published_plan;
use proofmass_shaker::plan::{
    Conditioning, Expected, ExpectedSpurious, PlanCost, Predicted, best, conditioning, costs,
    predict, sound_matrix, usual_sizes,
};
use proofmass_shaker::{Budget, Configuration, Correction, SpuriousTable, with_certificate};
use proofmass_uncertainty::Finding;
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct PlanJob {
    /// Configurations to choose from.
    pub candidates: Vec<Configuration>,
    /// Session of each candidate; all are of one session where it is empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sessions: Vec<String>,
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
    /// What the shaker can do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shaker: Option<ShakerTable>,
    /// Frequencies that are to be measured, with the accelerations wanted, (Hz, m/s²).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<(f64, f64)>,
    /// What is doubtful about the bench beforehand, such as a resonance of a wedge.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub findings: Vec<Finding>,
}

impl PlanJob {
    /// All 44 published configurations at 10 m/s² and 160 Hz.
    pub fn new(budget: Budget) -> Self {
        Self {
            candidates: published_plan(),
            sessions: Vec::new(),
            origin: "the published ones".to_owned(),
            budget,
            reference: None,
            frequency: 160.0,
            best: None,
            sizes: Vec::new(),
            sensitivity: None,
            amplitude: 10.0,
            correction: None,
            shaker: None,
            points: Vec::new(),
            findings: Vec::new(),
        }
    }

    /// Points that the shaker does not reach.
    fn beyond_shaker(&self) -> Option<Finding> {
        let shaker = self.shaker.as_ref()?;
        let heavy = match (shaker.payload, shaker.largest_payload) {
            (Some(payload), Some(most)) if payload > most => {
                Some(format!("a payload of {payload} kg, {most} kg at most"))
            }
            _ => None,
        };
        let of =
            |(f, a): &(f64, f64)| Some(format!("{f} Hz at {a} m/s²: {}", shaker.beyond(*f, *a)?));
        let told: Vec<String> = heavy
            .into_iter()
            .chain(self.points.iter().filter_map(of))
            .collect();
        (!told.is_empty()).then(|| findings::beyond_the_shaker(told.len(), &told.join("; ")))
    }

    /// What the correction says of the spurious motion at the frequency of the plan: of its nearest frequency, and of an
    /// inclination that it does not have as little as of the one it knows least.
    fn spurious(&self) -> (SpuriousTable, Option<Finding>) {
        let Some(correction) = &self.correction else {
            return (SpuriousTable::default(), None);
        };
        let Some(expected) =
            ExpectedSpurious::of(&correction.table, self.frequency, &self.candidates)
        else {
            return (SpuriousTable::default(), None);
        };
        let ExpectedSpurious {
            table,
            at,
            missing,
            root,
            ..
        } = expected;
        let told = findings::spurious_motion_expected(&correction.label, at, root, missing);
        (table, Some(told))
    }

    fn sizes(&self) -> Result<Vec<usize>> {
        let count = self.candidates.len();
        if self.sizes.is_empty() {
            return Ok(usual_sizes(count));
        }
        let mut sizes = self.sizes.clone();
        sizes.sort_unstable();
        sizes.dedup();
        match sizes.iter().find(|n| !(3..=count).contains(*n)) {
            Some(n) => Err(Trouble::request(format!(
                "a plan of {n} configurations is out of range: from 3 to {count}, the number of candidates"
            ))
            .with_hint(format!("give numbers from 3 to {count}"))),
            None => Ok(sizes),
        }
    }
}

/// Conditioning, predicted uncertainties and what fewer configurations would cost.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanOutcome {
    findings: Vec<Finding>,
    budget: Budget,
    candidates: Vec<Configuration>,
    origin: String,
    configurations: Vec<Configuration>,
    sessions: Vec<String>,
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

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
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
                    "--best is {n}, and there are {count} candidates; three are needed at least"
                ))
                .with_hint(format!("give a number from 3 to {count}")));
            }
            Some(n) => Some(best(&self.candidates, n).map_err(hopeless)?),
            None => None,
        };
        let named = self.sessions.len();
        if named != 0 && named != count {
            return Err(Trouble::request(format!(
                "{named} sessions are named for {count} candidates"
            ))
            .with_hint("name a session for each candidate, or none at all"));
        }
        let plan: Vec<Configuration> = match &chosen {
            Some(list) => list.iter().map(|&k| self.candidates[k]).collect(),
            None => self.candidates.clone(),
        };
        let sessions: Vec<String> = match &chosen {
            Some(list) => {
                let of = |&k: &usize| self.sessions.get(k).cloned();
                list.iter().filter_map(of).collect()
            }
            None => self.sessions.clone(),
        };
        let s = sound_matrix(self.sensitivity.unwrap_or(0.01));
        let quality = conditioning(&plan).map_err(hopeless)?;
        let (spurious, told) = self.spurious();
        let expected = Expected {
            budget: &budget,
            spurious: &spurious,
            sensitivity: &s,
            amplitude: self.amplitude,
            frequency: self.frequency,
            sessions: &self.sessions,
        };
        let of_plan = Expected {
            sessions: &sessions,
            ..expected
        };
        let predicted = predict(&plan, &of_plan).map_err(hopeless)?;
        let sizes = self.sizes()?;
        let mut list = Vec::with_capacity(sizes.len());
        for (k, size) in sizes.iter().enumerate() {
            watch.step("plans", k as u64, sizes.len() as u64)?;
            list.extend(costs(&self.candidates, &[*size], &expected).map_err(hopeless)?);
        }
        watch.step("plans", sizes.len() as u64, sizes.len() as u64)?;
        let mut findings = self.findings.clone();
        findings.extend(self.beyond_shaker());
        findings.extend(told);
        let one_session = self.sessions.iter().all(|s| *s == self.sessions[0]);
        let between = budget.inputs.iter().find(|i| i.varies_between_sessions());
        if let Some(input) = between.filter(|_| one_session) {
            findings.push(findings::plan_of_one_session(&input.key));
        }
        if self.sensitivity.is_none() {
            findings.push(findings::sensitivity_assumed());
        }
        Ok(PlanOutcome {
            findings,
            budget,
            candidates: self.candidates.clone(),
            origin: self.origin.clone(),
            configurations: plan,
            sessions,
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
        budget.reaches(&self.source, [frequency])?;
        let certificate = Certificate::of_reference(&self.source, self.reference.as_ref())?;
        let mut job = PlanJob::new(budget.budget(certificate.is_some()));
        let mut frequencies = vec![frequency];
        let plan = self.read_plan()?;
        // A plan is made before there are runs, too.
        let runs = self.runs.as_ref();
        let measured = runs.is_some_and(|r| plan.is_none() || self.source.holds(&r.file));
        if measured {
            let table = self.read_runs()?;
            let mut list: Vec<Configuration> = Vec::new();
            let mut sessions: Vec<String> = Vec::new();
            let amplitude = self.plan.as_ref().and_then(|p| p.amplitude);
            for run in &table.runs {
                let wanted = run.seat.target.or(amplitude).unwrap_or(job.amplitude);
                let point = (run.frequency_hz, wanted);
                if !job.points.contains(&point) {
                    job.points.push(point);
                }
                frequencies.push(run.frequency_hz);
                let c = run.seat.configuration;
                let session = run.session.as_ref();
                let same = |k: usize| list[k].same_as(&c) && sessions.get(k) == session;
                if !(0..list.len()).any(same) {
                    list.push(c);
                    sessions.extend(session.cloned());
                }
            }
            inputs.push(table.input);
            (job.candidates, job.sessions) = (list, sessions);
            "those of the runs".clone_into(&mut job.origin);
        }
        if let Some(plan) = plan {
            inputs.extend(plan.input);
            (job.candidates, job.sessions) = (plan.configurations, plan.sessions);
            "the plan of the campaign".clone_into(&mut job.origin);
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
        job.sensitivity = self
            .datasheet()?
            .and_then(|d| d.axes.iter().flatten().map(|a| a.value).next());
        if let Some(amplitude) = self.plan.as_ref().and_then(|p| p.amplitude) {
            job.amplitude = amplitude;
        }
        job.frequency = frequency;
        job.shaker = self.shaker;
        let asked = (frequency, job.amplitude);
        if job.shaker.is_none() {
            job.points.clear();
        } else if !job.points.iter().any(|p| p.0 == frequency) {
            job.points.push(asked);
        }
        job.points.sort_by(|a, b| a.0.total_cmp(&b.0));
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
