//! A triaxial accelerometer on a single-axis shaker, by wedges and rotations.

mod explanation;
mod outcome;
mod page;
mod tables;

pub use outcome::ShakerTriaxialOutcome;
pub(crate) use tables::stated;

use crate::bench_runs::{BenchFiles, BenchRuns};
use crate::campaign::{
    Certificate, Conditioner, Mounting, MountingRatio, RunTable, ShakerBudget, ShakerRecording,
    ShakerTriaxialCampaign,
};
use crate::observed::{SensorFiles, observe};
use crate::outcome::Job;
use crate::record::Record;
use crate::sensor_clock::SensorClock;
use crate::trouble::{Result, Trouble};
use num_complex::Complex64;
use proofmass_core::{Error, Watch};
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_shaker::datasheet::{Datasheet, kept};
use proofmass_shaker::monte_carlo::{self, CheckOptions};
use proofmass_shaker::published::MagnitudeBudget;
use proofmass_shaker::recording::{QualityLimits, RunInput};
use proofmass_shaker::sample_clock::SampleClock;
use proofmass_shaker::{
    Acts, Budget, Configuration, Correction, Key, OutputPhases, ShakerCalibration, ShakerCampaign,
    ShakerInput, ShakerMethod, UnmeasuredMotion, adopt, applied, calibrate, check,
};
use proofmass_uncertainty::{Finding, Refusal};
use serde::{Deserialize, Serialize};

/// What is to be calibrated, and how.
///
/// ```
/// use num_complex::Complex64;
/// use proofmass_shaker::geometry::published_plan;
/// use proofmass_shaker::recording::{Quality, RunInput};
/// use proofmass_shaker::{Acts, Budget, ShakerInput, Key};
/// use proofmass_jobs::{Job, Outcome, Unwatched, shaker_triaxial::{ShakerTriaxialData, ShakerTriaxialJob}};
///
/// // Runs of a device of 10 mV/(m/s²) along every axis at 10 m/s², the reference already in m/s².
/// let runs: Vec<RunInput> = published_plan().into_iter().enumerate().map(|(i, configuration)| RunInput {
///     run: format!("run {i}"),
///     session: None,
///     frequency: 160.0,
///     configuration,
///     reference: Complex64::new(10.0, 0.0),
///     outputs: configuration.direction().map(|d| Complex64::new(0.1 * d, 0.0)),
///     covariance: [[0.0; 3]; 4],
///     quality: Quality::default(),
/// }).collect();
/// let budget = Budget::new(vec![
///     ShakerInput::new("reading", Acts::OutputModulus, 0.003, &[Key::Run, Key::Channel]),
///     ShakerInput::new("noise", Acts::OutputAdditive, 5e-5, &[Key::Run, Key::Channel]),
/// ])?;
/// let outcome = ShakerTriaxialJob::new(budget).evaluate(&ShakerTriaxialData::new(&runs), &Unwatched)?;
/// let s = &outcome.quantities()[0];
/// assert_eq!(s.name, "S.xx.modulus[frequency=160]");
/// assert!((s.value - 0.01).abs() < s.expanded);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ShakerTriaxialJob {
    /// Calculations to set side by side; the first is the result.
    pub methods: Vec<ShakerMethod>,
    /// How the stated intervals are checked; no trials for no check.
    pub monte_carlo: CheckOptions,
    /// What is uncertain.
    pub budget: Budget,
    /// Certificate of the reference; `None` when the runs carry accelerations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceTable>,
    /// Which standard it is and who calibrated it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_description: Option<String>,
    /// Corrections of the spurious motion to set side by side; without one nothing is corrected.
    #[serde(default)]
    pub corrections: Vec<Correction>,
    /// How large the motion of the bench may be where the corrections say nothing; the runs tell it when `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unmeasured_motion: Option<UnmeasuredMotion>,
    /// Budget of the published method.
    pub magnitude_budget: MagnitudeBudget,
    /// What should have been measured at every frequency.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plan: Option<Vec<Configuration>>,
    /// Target amplitudes (Hz, m/s²).
    #[serde(default)]
    pub targets: Vec<(f64, f64)>,
    /// Rules of a sound run.
    pub limits: QualityLimits,
    /// What the maker states, per m/s².
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub datasheet: Option<Datasheet>,
    /// Runs to be left out, by name.
    #[serde(default)]
    pub excluded: Vec<String>,
    /// By whose clock the device samples that has a file of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample_clock: Option<SampleClock>,
    /// Whether the outputs are moduli, of which nobody read the phases.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub moduli: bool,
    /// A coverage factor such as 2 that U is stated with, instead of that of 95 %.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coverage_factor: Option<f64>,
}

impl ShakerTriaxialJob {
    /// The joint and the complex method, uncorrected, with 10 000 trials of the Monte Carlo check.
    pub fn new(budget: Budget) -> Self {
        Self {
            methods: vec![ShakerMethod::Joint, ShakerMethod::Complex],
            monte_carlo: CheckOptions::default(),
            budget,
            reference: None,
            reference_description: None,
            corrections: Vec::new(),
            unmeasured_motion: None,
            magnitude_budget: MagnitudeBudget::published(0.0035),
            plan: None,
            targets: Vec::new(),
            limits: QualityLimits::default(),
            datasheet: None,
            excluded: Vec::new(),
            sample_clock: None,
            moduli: false,
            coverage_factor: None,
        }
    }

    fn campaign(&self, runs: &[RunInput]) -> ShakerCampaign {
        let mut campaign = ShakerCampaign::new(runs.to_vec(), self.budget.clone());
        campaign.reference = self.reference.clone();
        campaign.corrections = self.corrections.clone();
        campaign.unmeasured_motion = self.unmeasured_motion;
        campaign.methods = self.methods.clone();
        campaign.magnitude_budget = self.magnitude_budget;
        campaign.plan = self.plan.clone();
        campaign.targets = self.targets.clone();
        campaign.limits = self.limits;
        campaign.datasheet = self.datasheet.clone();
        campaign.excluded = self.excluded.clone();
        campaign.phases = match (self.moduli, self.sample_clock) {
            (true, _) => OutputPhases::Unread,
            (false, Some(SampleClock::Own)) => OutputPhases::InCommon,
            (false, _) => OutputPhases::Measured,
        };
        campaign
    }
}

/// The runs of a triaxial accelerometer as phasors.
pub type ShakerTriaxialData<'a> = BenchRuns<'a, RunInput>;

impl Job for ShakerTriaxialJob {
    type Data<'a> = ShakerTriaxialData<'a>;
    type Outcome = ShakerTriaxialOutcome;

    fn evaluate(
        &self,
        data: &ShakerTriaxialData<'_>,
        watch: &dyn Watch,
    ) -> Result<ShakerTriaxialOutcome> {
        watch.step("adjustment", 0, 1)?;
        let campaign = self.campaign(data.runs);
        let explain = |e: Error| explanation::explain(e, &campaign, data);
        let mut calibration = calibrate(&campaign).map_err(explain)?;
        watch.step("adjustment", 1, 1)?;
        let checks = if self.monte_carlo.trials == 0 {
            Vec::new()
        } else {
            check(&campaign, &calibration, &self.monte_carlo, &mut |p| {
                watch.progress("Monte Carlo", p.done as u64, p.most as u64)
            })
            .map_err(|refusal| match refusal {
                Refusal::Core(e) => explain(e),
                Refusal::Cancelled => Error::Cancelled {
                    stage: "Monte Carlo",
                }
                .into(),
                other => other.into(),
            })?
        };
        let applied = applied(&campaign).map_err(explain)?;
        watch.step("Monte Carlo", 1, 1)?;
        adopt(&mut calibration, &checks);
        if let Some(sheet) = &self.datasheet {
            calibration.hold_against(sheet).map_err(explain)?;
        }
        // Those of files and runs, then of the first result, the gravest first.
        let mut findings = data.findings.to_vec();
        findings.extend(calibration.findings.iter().cloned());
        let principal = calibration.results.first().into_iter();
        findings.extend(principal.flat_map(|r| r.findings.clone()));
        // The page shows a rigorous method where the first is not one.
        for finding in page::principal(&calibration).map_or(&[][..], |r| &r.findings) {
            if !findings.contains(finding) {
                findings.push(finding.clone());
            }
        }
        if let (Some(sheet), Some(shown)) = (&self.datasheet, page::principal(&calibration)) {
            findings.extend(kept(sheet, &shown.datasheet));
        }
        findings.extend(monte_carlo::findings(&checks, self.monte_carlo.digits));
        let clock = self.clock(data, &calibration, &mut findings);
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        // Decisions are taken at 95 % before; this is the statement alone.
        if let Some(k) = self.coverage_factor {
            calibration.state_with(k);
        }
        Ok(
            ShakerTriaxialOutcome::new(self, data, calibration, checks, clock, findings)
                .with_applied(applied),
        )
    }
}

impl ShakerTriaxialJob {
    /// Error of the device's clock, and its delay where the clock is shared.
    fn clock(
        &self,
        data: &ShakerTriaxialData<'_>,
        calibration: &ShakerCalibration,
        findings: &mut Vec<Finding>,
    ) -> Option<SensorClock> {
        let clock = self.sample_clock?;
        let used = data.runs.iter().filter(|r| !self.excluded.contains(&r.run));
        let runs = used.map(|r| (r.run.as_str(), &r.quality));
        let mut rigorous = calibration
            .results
            .iter()
            .filter(|r| !r.frequencies.is_empty());
        let frequencies = rigorous.next().map_or(&[][..], |r| &r.frequencies);
        let phases = frequencies.iter().flat_map(|f| {
            let main = [0, 4, 8].into_iter();
            main.filter_map(|k| {
                let phase = f.sensitivity[k].phase.as_ref()?;
                Some((f.frequency, phase.value, phase.standard_uncertainty))
            })
        });
        let own = [
            "phases are those among the axes of the sensor, not against the reference",
            "at each frequency phases count from that of S_xx (of the next axis where x is faint), which is real by \
             definition; calibration.json, which needs them over frequency, is not written",
        ];
        let found = SensorClock::of(clock, runs, || phases.collect(), own, findings);
        Some(found)
    }
}

/// Everything the files of a campaign say.
pub type ShakerTriaxialFiles = BenchFiles<ShakerTriaxialJob, RunInput>;

impl ShakerTriaxialCampaign {
    /// Reads the tables of the campaign and its recordings, which become phasors one by one on all cores.
    ///
    /// # Errors
    /// A file that cannot be read, a recording without a sine, or `watch` wanted it to stop.
    pub fn load(&self, watch: &dyn Watch) -> Result<ShakerTriaxialFiles> {
        let mut table = self.read_runs()?;
        // Small tables before the large recordings: their mistakes are told at once.
        let certificate = Certificate::of_reference(&self.source, self.reference.as_ref())?;
        let corrections = self.read_corrections()?;
        self.meets(&corrections, &table.runs)?;
        let budget = self.read_budget()?;
        let plan = self.read_plan()?;
        let frequencies = frequencies(&table);
        budget.reaches(&self.source, frequencies.iter().copied())?;
        let named = table.runs.iter().all(|r| r.session.is_some());
        budget.finds_sessions(&self.source, &table.path, named)?;
        let conditioner = Conditioner::read(&self.source, &self.conditioner, &Self::CHANNELS)?;
        let gains = conditioner
            .budget(&Self::CHANNELS[1..], &frequencies)
            .map_err(|e| e.at(&self.source.path))?;
        let mut inputs = vec![self.source.input.clone()];
        inputs.extend(certificate.iter().map(|c| c.input.clone()));
        inputs.extend(corrections.iter().filter_map(|c| c.input.clone()));
        if let ShakerBudget::Inputs(_, Some(input)) = &budget {
            inputs.push(input.clone());
        }
        inputs.extend(plan.iter().filter_map(|plan| plan.input.clone()));
        inputs.extend(conditioner.inputs.iter().cloned());
        let mounting = self.mounting.as_ref();
        let mounting = mounting
            .map(|table| MountingRatio::read(&self.source, table))
            .transpose()?;
        let corrected = mounting
            .as_ref()
            .map(|m| Ok::<_, Trouble>((m.budget(&frequencies)?, m.finding(&frequencies)?)))
            .transpose()?;
        inputs.extend(mounting.iter().map(|m| m.input.clone()));
        let sensor = SensorFiles::of(
            &self.source,
            self.output_recording.as_ref(),
            &Self::CHANNELS,
        )?;
        let output = self.output()?;
        let mut observed = observe(
            &mut table,
            self.recording.as_ref(),
            || self.waveform_options(),
            sensor,
            watch,
        )?;
        for (run, seen) in table.runs.iter().zip(&mut observed.runs) {
            for (k, channel) in Self::CHANNELS.into_iter().enumerate() {
                if let Some(gain) = conditioner.gain(channel, run.frequency_hz)? {
                    seen.divide(k, gain);
                }
                if let Some(mounting) = mounting.as_ref().filter(|_| k > 0) {
                    let (ratio, _) = mounting.at(run.frequency_hz)?;
                    seen.divide(k, Complex64::new(1.0 / ratio, 0.0));
                }
            }
        }
        let runs = table
            .runs
            .iter()
            .zip(&observed.runs)
            .map(|(run, seen)| RunInput {
                run: run.run.clone(),
                session: run.session.clone(),
                frequency: run.frequency_hz,
                configuration: run.seat.configuration,
                reference: seen.phasors[0],
                outputs: [seen.phasors[1], seen.phasors[2], seen.phasors[3]],
                covariance: std::array::from_fn(|k| seen.covariances[k]),
                quality: seen.quality(run.seat.transverse),
            })
            .collect();
        let mut budget = budget
            .budget(certificate.is_some())
            .of_outputs(output.triaxial());
        if let Some(recording) = &self.recording {
            budget.inputs.extend(front_end(recording, &frequencies));
        }
        let (of_mounting, stated_mounting) = corrected.unzip();
        let of_mounting = of_mounting.flatten();
        for (input, table) in gains
            .iter()
            .map(|input| (input, "conditioner"))
            .chain(of_mounting.iter().map(|input| (input, "mounting")))
        {
            if let Some(other) = budget.inputs.iter().find(|i| i.key == input.key) {
                return Err(self
                    .source
                    .refuse(
                        "budget",
                        "name",
                        format!(
                            "\"{}\" stands in the budget, and [{table}] states it too",
                            other.key
                        ),
                    )
                    .with_hint("take it out of one of the two")
                    .into());
            }
        }
        budget.inputs.extend(gains);
        budget.inputs.extend(of_mounting);
        let mut job = ShakerTriaxialJob::new(budget);
        job.sample_clock = self.output_recording.as_ref().map(|s| s.clock);
        job.moduli = table.moduli;
        job.methods = self.method.methods.clone();
        let alone = job.methods == [ShakerMethod::PublishedMagnitude];
        if alone {
            job.methods.insert(0, ShakerMethod::Joint);
        }
        job.monte_carlo.trials = self.method.trials;
        job.monte_carlo.seed = self.method.seed;
        job.coverage_factor = self.method.coverage_factor;
        job.corrections = corrections.into_iter().map(|c| c.correction).collect();
        job.unmeasured_motion = self.unmeasured_motion;
        let published = &self.published;
        job.magnitude_budget = MagnitudeBudget {
            reference: published.reference,
            inclination: published.inclination_deg.to_radians() / 3f64.sqrt(),
            rotation: published.rotation_deg.to_radians() / 3f64.sqrt(),
            ..MagnitudeBudget::published(published.output)
        };
        job.plan = plan.map(|plan| plan.configurations);
        for run in &table.runs {
            if let Some(target) = run.seat.target
                && !job.targets.iter().any(|t| t.0 == run.frequency_hz)
            {
                job.targets.push((run.frequency_hz, target));
            }
        }
        job.datasheet = self.datasheet()?;
        job.excluded = self
            .runs
            .as_ref()
            .map(|r| table.excluded(&r.exclude))
            .unwrap_or_default();
        let mut findings = Vec::new();
        if let Some(certificate) = certificate {
            findings = certificate.findings;
            job.reference = Some(certificate.table);
            job.reference_description = certificate.description;
        }
        findings.extend(alone.then(proofmass_shaker::findings::published_alone));
        findings.extend(stated_mounting);
        let points = table.runs.iter();
        let points = points.map(|r| (r.seat.configuration.inclination, r.frequency_hz));
        findings.extend(self.fixture_findings(&points.collect::<Vec<_>>())?);
        let said = (findings, inputs);
        Ok(BenchFiles::new((job, runs), &table.path, said, observed))
    }

    /// What the result is filed with.
    pub fn record(&self, files: &ShakerTriaxialFiles, date: Option<String>) -> Record {
        self.filed(date, files.inputs.clone())
    }
}

/// Frequencies of the runs, ascending.
fn frequencies(table: &RunTable<Mounting>) -> Vec<f64> {
    let mut frequencies: Vec<f64> = table.runs.iter().map(|r| r.frequency_hz).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup();
    frequencies
}

/// What is left of the delays of the channels, as errors of phase that grow with the frequency: that of the reference is
/// common to the outputs; for each output on its own the largest of the three stands.
fn front_end(recording: &ShakerRecording, frequencies: &[f64]) -> Vec<ShakerInput> {
    let of = |key: &str, text: &str, delay: f64, keys: &[Key]| {
        let highest = *frequencies.last()?;
        (delay > 0.0).then(|| {
            let phase = |f: f64| std::f64::consts::TAU * f * delay;
            let mut input =
                ShakerInput::new(key, Acts::OutputPhase, phase(highest), keys).described(text);
            input.at_frequencies = frequencies.iter().map(|f| (*f, phase(*f))).collect();
            input
        })
    };
    let outputs = ["x", "y", "z"].map(|c| recording.delay_uncertainty(c));
    let largest = outputs.into_iter().fold(0.0, f64::max);
    [
        of(
            "front_end.delay.reference",
            "delay of the reference channel of the front end",
            recording.delay_uncertainty("reference"),
            &[],
        ),
        of(
            "front_end.delay",
            "delay of each output channel of the front end",
            largest,
            &[Key::Channel],
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}
