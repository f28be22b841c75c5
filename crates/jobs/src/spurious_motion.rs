//! Motion of table and wedges beside the excitation, by a vibrometer and a reference.

mod page;

use crate::bench_runs::{BenchFiles, BenchRuns};
use crate::campaign::{SpuriousFile, SpuriousMotionCampaign};
use crate::observed::{listed, observe};
use crate::outcome::{Job, Outcome};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use num_complex::Complex64;
use page::SpuriousReport;
use proofmass_core::Watch;
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_io::{Cell, StatedQuantity, Table};
use proofmass_report::Report;
use proofmass_shaker::recording::{Assessed, Quality, QualityLimits, assess};
use proofmass_shaker::spurious::{
    Average, Comparison, RatioRepeats, RatioSummary, compare, ratio_from_velocity, summaries, table,
};
use proofmass_shaker::{Correction, SpuriousTable};
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The decoder of a vibrometer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Vibrometer {
    /// Sensitivity in V/(m/s).
    pub sensitivity: f64,
    /// Delay behind the motion, s.
    pub delay: f64,
}

/// How the runs are to be read.
///
/// ```
/// use proofmass_jobs::campaign::Campaign;
/// use proofmass_jobs::simulate::{SimulateJob, SimulatedSpuriousMotion};
/// use proofmass_jobs::{Gathered, Job, Outcome, Sink, Unwatched};
/// use std::sync::Arc;
///
/// let mut bench = SimulatedSpuriousMotion::default();
/// bench.frequencies = vec![160.0];
/// let files = Gathered::default();
/// SimulateJob::SpuriousMotion(bench).evaluate(&(&files as &dyn Sink), &Unwatched)?;
/// let campaign = Campaign::read(Arc::new(files.into_memory()), "campaign.toml")?;
/// let Campaign::SpuriousMotion(campaign) = campaign else { panic!() };
/// let files = campaign.load(&Unwatched)?;
/// let outcome = files.job.evaluate(&files.data(), &Unwatched)?;
/// assert!(!outcome.measurements().is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SpuriousMotionJob {
    /// Certificate of the reference; `None` when the runs carry accelerations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceTable>,
    /// The vibrometer; `None` when the runs carry velocities.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vibrometer: Option<Vibrometer>,
    /// Standard uncertainty of the delay between the two channels of the front end, s.
    #[serde(default)]
    pub front_end: f64,
    /// Rules of a sound run.
    #[serde(default)]
    pub limits: QualityLimits,
    /// Runs to be left out, by name.
    #[serde(default)]
    pub excluded: Vec<String>,
    /// Calculated motions, as by a model of a wedge, to set beside the first measurement.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub models: Vec<Correction>,
}

/// One repeat along one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct SpuriousRun {
    /// Name.
    pub run: String,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Inclination in radians.
    pub inclination: f64,
    /// Axis of the bench, 0 for x′ to 2 for z′.
    pub axis: usize,
    /// Label of the measurement it belongs to.
    pub measurement: String,
    /// Reference, V or m/s², and velocity, V or m/s.
    pub phasors: [Complex64; 2],
    /// What the samples said.
    pub quality: Quality,
    /// Where it stands, for messages.
    pub place: String,
}

/// The runs of a vibrometer as phasors.
pub type SpuriousMotionData<'a> = BenchRuns<'a, SpuriousRun>;

/// One measurement, by its label.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Label.
    pub label: String,
    /// Ratios of every place, repeat by repeat.
    pub repeats: Vec<RatioRepeats>,
    /// Names of the runs of each ratio.
    pub runs: Vec<Vec<String>>,
    /// What a campaign is corrected with.
    pub table: SpuriousTable,
    /// What the repeats of each ratio say.
    pub summaries: Vec<RatioSummary>,
}

/// Spurious motion of a bench, measurement by measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpuriousMotionOutcome {
    measurements: Vec<Measurement>,
    /// The first measurement against each of the others and against calculated motions, by label.
    comparisons: Vec<(String, Vec<Comparison>)>,
    findings: Vec<Finding>,
    recordings: usize,
}

/// Files of the corrections, measurement by measurement.
const CORRECTIONS: [&str; 4] = [
    "spurious.csv",
    "spurious-2.csv",
    "spurious-3.csv",
    "spurious-4.csv",
];

impl SpuriousMotionOutcome {
    /// Measurements in the order of the runs; there is one at least.
    pub fn measurements(&self) -> &[Measurement] {
        &self.measurements
    }

    fn page(&self, record: &Record) -> SpuriousReport<'_> {
        let mut head = record.head(self.title(record), &self.findings);
        head.inputs = listed(record, self.recordings);
        SpuriousReport {
            head,
            comparisons: self
                .comparisons
                .iter()
                .map(|(label, list)| (label.as_str(), list.as_slice()))
                .collect(),
        }
    }
}

impl Outcome for SpuriousMotionOutcome {
    const KIND: &'static str = "spurious-motion";

    fn title(&self, record: &Record) -> String {
        record.title("Spurious motion of", "Spurious motion of a shaker bench")
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        Vec::new()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn tables(&self) -> Result<Vec<(String, Table)>> {
        let mut list = vec![("ratios.csv".to_owned(), ratios(&self.measurements)?)];
        for (name, measurement) in CORRECTIONS.iter().zip(&self.measurements) {
            list.push(((*name).to_owned(), SpuriousFile::table(&measurement.table)?));
        }
        if let (Some(first), false) = (self.measurements.first(), self.comparisons.is_empty()) {
            list.push((
                "comparison.csv".to_owned(),
                comparison_table(&first.label, &self.comparisons)?,
            ));
        }
        Ok(list)
    }

    fn summary(&self, record: &Record) -> Report {
        match self.measurements.first() {
            Some(first) => self.page(record).summary(&first.summaries, &first.table),
            None => Report::new(self.title(record)),
        }
    }

    fn report(&self, record: &Record) -> Report {
        match self.measurements.first() {
            Some(first) => self.page(record).full(&first.summaries, &first.table),
            None => Report::new(self.title(record)),
        }
    }
}

impl Job for SpuriousMotionJob {
    type Data<'a> = SpuriousMotionData<'a>;
    type Outcome = SpuriousMotionOutcome;

    fn evaluate(
        &self,
        data: &SpuriousMotionData<'_>,
        watch: &dyn Watch,
    ) -> Result<SpuriousMotionOutcome> {
        watch.step("ratios", 0, 1)?;
        let mut findings = data.findings.to_vec();
        let measurements = self.measurements(data, &mut findings)?;
        let mut comparisons = Vec::new();
        if let [first, others @ ..] = measurements.as_slice() {
            comparisons = others
                .iter()
                .map(|other| (other.label.clone(), compare(&first.table, &other.table)))
                .collect();
            findings.extend(comparisons.iter().filter_map(|(label, list)| {
                disagreement(
                    list,
                    "measurements-disagree",
                    format!("the measurements {} and {label} disagree", first.label),
                    "repeats in a row do not see what changes between two set-ups; take their difference into the uncertainty",
                )
            }));
            for model in &self.models {
                let list = compare(&first.table, &model.table);
                if list.is_empty() {
                    return Err(Trouble::data(format!(
                        "the calculated motion {} has no inclination and frequency in common with the measurement {}",
                        model.label, first.label
                    ))
                    .with_hint("calculate it at the frequencies of the runs: frequencies_Hz in [transfer]"));
                }
                findings.extend(disagreement(
                    &list,
                    "calculated-motion-disagrees",
                    format!(
                        "the calculated motion {} and the measurement {} disagree",
                        model.label, first.label
                    ),
                    "a model of the wedge alone knows nothing of the table's own motion, which is nearly the same at all frequencies; \
                     what grows with frequency is the base or the gluing",
                ));
                comparisons.push((model.label.clone(), list));
            }
        }
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        watch.step("ratios", 1, 1)?;
        Ok(SpuriousMotionOutcome {
            measurements,
            comparisons,
            findings,
            recordings: data.recordings,
        })
    }
}

impl SpuriousMotionJob {
    /// Ratios of all runs, gathered by measurement, inclination, frequency and axis.
    fn measurements(
        &self,
        data: &SpuriousMotionData<'_>,
        findings: &mut Vec<Finding>,
    ) -> Result<Vec<Measurement>> {
        let mut list: Vec<Measurement> = Vec::new();
        for run in data.runs {
            if self.excluded.contains(&run.run) {
                continue;
            }
            let place = || format!("{}: run {}", run.place, run.run);
            let f = run.frequency;
            let acceleration = match &self.reference {
                Some(table) => table.acceleration(run.phasors[0], f).map_err(|e| {
                    Trouble::data(format!("{}: {e}", place()))
                        .with_hint("have the reference calibrated there, or take the run out")
                })?,
                None => run.phasors[0],
            };
            if acceleration.norm() == 0.0 {
                return Err(
                    Trouble::data(format!("{} has no signal of the reference", place()))
                        .with_hint("measure the run again, or take its row out"),
                );
            }
            let velocity = match &self.vibrometer {
                // The decoder speaks late by its delay.
                Some(v) => {
                    run.phasors[1] / v.sensitivity * Complex64::from_polar(1.0, TAU * f * v.delay)
                }
                None => run.phasors[1],
            };
            let assessed = Assessed {
                run: &run.run,
                frequency: f,
                quality: &run.quality,
                channels: &SpuriousMotionCampaign::CHANNELS,
                amplitude: acceleration.norm(),
                target: None,
            };
            findings.extend(assess(&assessed, &self.limits));
            let m = list
                .iter()
                .position(|m| m.label == run.measurement)
                .unwrap_or_else(|| {
                    list.push(Measurement {
                        label: run.measurement.clone(),
                        repeats: Vec::new(),
                        runs: Vec::new(),
                        table: SpuriousTable::default(),
                        summaries: Vec::new(),
                    });
                    list.len() - 1
                });
            let measurement = &mut list[m];
            let same = |r: &RatioRepeats| {
                (r.inclination - run.inclination).abs() < 1e-6
                    && r.frequency == f
                    && r.axis == run.axis
            };
            let k = measurement
                .repeats
                .iter()
                .position(same)
                .unwrap_or_else(|| {
                    measurement.repeats.push(RatioRepeats {
                        inclination: run.inclination,
                        frequency: f,
                        axis: run.axis,
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
                Trouble::data(format!("{}: every run was left out", data.name))
                    .with_hint("shorten `exclude` in [runs]"),
            );
        }
        if list.len() > CORRECTIONS.len() {
            return Err(Trouble::data(format!(
                "{}: {} measurements are too many for one campaign",
                data.name,
                list.len()
            ))
            .with_hint(format!("compare {} at a time", CORRECTIONS.len())));
        }
        for measurement in &mut list {
            for (repeats, runs) in measurement.repeats.iter().zip(&measurement.runs) {
                if let [only] = runs.as_slice() {
                    return Err(Trouble::data(format!(
                    "{}: run {only} is the only repeat along {}′ at inclination {:.0}°, {} Hz",
                    data.name,
                    ["x", "y", "z"][repeats.axis],
                    repeats.inclination.to_degrees(),
                    repeats.frequency
                ))
                .with_hint("a ratio needs two repeats at least, and ten to be trusted; measure again, or take the run out"));
                }
            }
            let (mut table, doubts) = table(&measurement.repeats)?;
            delayed(&mut table, self.front_end);
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
}

/// What is not known of the delay between the channels turns every ratio: along z′ the whole motion, of which the departure
/// from the excitation is the small part.
fn delayed(table: &mut SpuriousTable, delay: f64) {
    for entry in &mut table.entries {
        let phase = TAU * entry.frequency * delay;
        for (axis, (z, c)) in entry.ratio.iter().zip(&mut entry.covariance).enumerate() {
            // An axis that was not measured has no ratio to turn.
            if c[0] + c[2] > 0.0 {
                let turn = Complex64::new(0.0, phase) * (z + f64::from(axis == 2));
                c[0] += turn.re * turn.re;
                c[1] += turn.re * turn.im;
                c[2] += turn.im * turn.im;
            }
        }
    }
}

/// P(X ≥ `count`) of `of` ratios that each lie beyond their 95 % limit by chance.
fn by_chance(count: usize, of: usize) -> f64 {
    let mut probability = 0.95f64.powi(of as i32);
    let mut below = 0.0;
    for k in 0..count {
        below += probability;
        probability *= (of - k) as f64 / (k + 1) as f64 * 0.05 / 0.95;
    }
    1.0 - below
}

/// Two measurements that do not agree within their uncertainties: more ratios apart than chance has in one campaign of two hundred, or one far apart (E_n above 3).
fn disagreement(
    list: &[Comparison],
    code: &'static str,
    what: String,
    advice: &'static str,
) -> Option<Finding> {
    let apart: Vec<&Comparison> = list
        .iter()
        .filter(|c| c.e_n.is_some_and(|e| e > 1.0))
        .collect();
    let worst = apart
        .iter()
        .max_by(|a, b| a.e_n.unwrap_or(0.0).total_cmp(&b.e_n.unwrap_or(0.0)))?;
    if by_chance(apart.len(), list.len()) > 0.005 && worst.e_n.unwrap_or(0.0) <= 3.0 {
        return None;
    }
    Some(
        Finding::new(Severity::Warning, code, what)
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
            .advice(advice),
    )
}

fn ratios(measurements: &[Measurement]) -> Result<Table> {
    let mut table = Table::new([
        "measurement",
        "inclination_deg",
        "frequency_Hz",
        "axis",
        "repeats",
        "averaged",
        "real",
        "imaginary",
        "u_real",
        "u_imaginary",
        "mean_resultant_length",
        "rayleigh_p",
        "circular_standard_deviation_deg",
    ]);
    for m in measurements {
        for (repeats, summary) in m.repeats.iter().zip(&m.summaries) {
            let estimate = match &summary.average {
                Average::Coherent(estimate) => Some(estimate),
                Average::Incoherent { .. } => None,
            };
            let mut row = vec![
                Cell::from(m.label.as_str()),
                Cell::from((repeats.inclination.to_degrees() * 1e9).round() / 1e9),
                Cell::from(repeats.frequency),
                Cell::from(summary.axis.as_str()),
                Cell::from(repeats.ratios.len()),
                Cell::from(if estimate.is_some() { "yes" } else { "no" }),
            ];
            row.push(Cell::from(estimate.map(|e| e.mean.re)));
            row.push(Cell::from(estimate.map(|e| e.mean.im)));
            row.extend([0, 2].map(|k| Cell::from(estimate.map(|e| e.covariance[k].sqrt()))));
            row.extend(
                [
                    summary.phases.resultant,
                    summary.phases.rayleigh_p,
                    summary.phases.standard_deviation.to_degrees(),
                ]
                .map(Cell::from),
            );
            table.push(row)?;
        }
    }
    Ok(table)
}

fn comparison_table(first: &str, comparisons: &[(String, Vec<Comparison>)]) -> Result<Table> {
    let mut table = Table::new([
        "first",
        "second",
        "inclination_deg",
        "frequency_Hz",
        "axis",
        "difference",
        "E_n",
    ]);
    for (label, list) in comparisons {
        for c in list {
            table.push([
                Cell::from(first),
                Cell::from(label.as_str()),
                Cell::from(c.inclination.to_degrees()),
                Cell::from(c.frequency),
                Cell::from(c.axis.as_str()),
                Cell::from(c.difference),
                Cell::from(c.e_n),
            ])?;
        }
    }
    Ok(table)
}

/// Everything the files of a campaign say.
pub type SpuriousMotionFiles = BenchFiles<SpuriousMotionJob, SpuriousRun>;

impl SpuriousMotionCampaign {
    /// Reads the tables of the campaign and its recordings.
    ///
    /// # Errors
    /// A file that cannot be read, a recording without a sine, or `watch` wanted it to stop.
    pub fn load(&self, watch: &dyn Watch) -> Result<SpuriousMotionFiles> {
        let mut table = self.read_runs()?;
        let certificate = self.read_reference()?;
        let observed = observe(
            &mut table,
            self.recording.as_ref(),
            || self.waveform_options(),
            None,
            watch,
        )?;
        let name = table.path.display().to_string();
        let runs = table
            .runs
            .iter()
            .zip(&observed.runs)
            .map(|(run, seen)| SpuriousRun {
                run: run.run.clone(),
                frequency: run.frequency_hz,
                inclination: run.seat.inclination,
                axis: run.seat.axis,
                measurement: run.seat.measurement.clone(),
                phasors: [seen.phasors[0], seen.phasors[1]],
                quality: seen.quality(None),
                place: format!("{name}:{}", run.line),
            })
            .collect();
        let mut job = SpuriousMotionJob::default();
        let mut findings = Vec::new();
        let mut inputs = vec![self.source.input.clone()];
        if let Some(certificate) = certificate {
            findings = certificate.findings;
            inputs.push(certificate.input);
            job.reference = Some(certificate.table);
        }
        findings.extend(observed.findings);
        job.vibrometer = self.vibrometer.map(|v| Vibrometer {
            sensitivity: v.sensitivity,
            delay: v.delay_s,
        });
        job.front_end = self.recording.as_ref().map_or(0.0, |r| {
            r.delay_uncertainty("reference")
                .hypot(r.delay_uncertainty("velocity"))
        });
        job.excluded = table.excluded(&self.runs.exclude);
        for model in self.read_models()? {
            inputs.extend(model.input);
            job.models.push(model.correction);
        }
        let recordings = observed.inputs.len() - 1;
        inputs.extend(observed.inputs);
        Ok(SpuriousMotionFiles {
            job,
            runs,
            findings,
            name,
            inputs,
            recordings,
        })
    }

    /// What the result is filed with.
    pub fn record(&self, files: &SpuriousMotionFiles, date: Option<String>) -> Record {
        files.record(&self.title, &self.device, &self.ambient, date)
    }
}
