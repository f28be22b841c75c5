//! Motion of table and wedges beside the excitation, by a vibrometer and a reference.

mod page;

use crate::bench_runs::{BenchFiles, BenchRuns};
use crate::campaign::{Certificate, SpuriousMotionCampaign};
use crate::findings;
use crate::observed::{observe, of_channel};
use crate::outcome::{Job, Outcome};
use crate::page::AXES;
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use num_complex::Complex64;
use proofmass_core::Watch;
use proofmass_documents::StatedQuantity;
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_report::Report;
use proofmass_shaker::copied_readings::{Reading, copies};
use proofmass_shaker::recording::{Assessed, Quality, QualityLimits, assess};
pub use proofmass_shaker::spurious::Vibrometer;
use proofmass_shaker::spurious::{
    Average, Comparison, RatioRepeats, RatioSummary, compare, disagreeing, gather,
    ratio_from_velocity, summaries, table,
};
use proofmass_shaker::{CommonCauses, CommonMotion, Correction, SpuriousTable, reference_gap};
use proofmass_uncertainty::{DegreesOfFreedom, Finding, welch_satterthwaite};
use serde::{Deserialize, Serialize};

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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Label.
    pub(crate) label: String,
    /// Ratios of every place, repeat by repeat.
    pub(crate) repeats: Vec<RatioRepeats>,
    /// Names of the runs of each ratio.
    pub(crate) runs: Vec<Vec<String>>,
    /// What a campaign is corrected with.
    pub(crate) table: SpuriousTable,
    /// What the repeats of each ratio say.
    pub(crate) summaries: Vec<RatioSummary>,
}

/// The largest ratio of a kind, with its uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct LargestMotion {
    /// Axis of the bench, 0 for x′ to 2 for z′.
    pub axis: usize,
    /// Inclination in radians.
    pub inclination: f64,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Modulus of the ratio to the excitation, along z′ of what departs from it.
    pub modulus: f64,
    /// Its expanded uncertainty at 95 %, along the ratio: the scatter of the repeats, and the calibrations of vibrometer and reference.
    pub expanded: f64,
    /// Coverage factor.
    pub coverage_factor: f64,
}

impl Measurement {
    /// The largest motion along some of the axes that was averaged.
    pub(crate) fn largest(&self, axes: &[usize]) -> Option<LargestMotion> {
        let known = |inclination: f64, frequency: f64, axis: usize| {
            let pairs = self.repeats.iter().zip(&self.summaries);
            pairs.into_iter().any(|(r, s)| {
                let here = (r.inclination - inclination).abs() < 1e-6 && r.frequency == frequency;
                here && r.axis == axis && matches!(s.average, Average::Coherent(_))
            })
        };
        let all = self.table.entries.iter().flat_map(|e| {
            let axes = axes
                .iter()
                .filter(|axis| known(e.inclination, e.frequency, **axis));
            axes.map(move |&axis| (e, axis))
        });
        let (entry, axis) =
            all.max_by(|(a, i), (b, k)| a.ratio[*i].norm().total_cmp(&b.ratio[*k].norm()))?;
        let z = entry.ratio[axis];
        let [rr, ri, ii] = entry.covariance[axis];
        let modulus = z.norm();
        let along = match modulus > 0.0 {
            true => (z.re * z.re * rr + 2.0 * z.re * z.im * ri + z.im * z.im * ii) / z.norm_sqr(),
            false => rr.max(ii),
        };
        let scatter = along.max(0.0).sqrt();
        // Along z′ the whole motion has the error of the calibrations.
        let whole = modulus + f64::from(axis == 2);
        let common = self.table.common.at(entry.frequency);
        let common = common.map_or(0.0, |c| whole * c.vibrometer[0].hypot(c.reference[0]));
        let (u, dof) = (
            scatter.hypot(common),
            welch_satterthwaite(&[(scatter, entry.dof), (common, DegreesOfFreedom::INFINITE)]),
        );
        let k = dof.coverage_factor(0.95);
        Some(LargestMotion {
            axis,
            inclination: entry.inclination,
            frequency: entry.frequency,
            modulus,
            expanded: k * u,
            coverage_factor: k,
        })
    }
}

/// Spurious motion of a bench, measurement by measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct SpuriousMotionOutcome {
    measurements: Vec<Measurement>,
    /// The first measurement against each of the others and against calculated motions, by label.
    comparisons: Vec<(String, Vec<Comparison>)>,
    findings: Vec<Finding>,
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

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
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
        let used = data.runs.iter().filter(|r| !self.excluded.contains(&r.run));
        let readings =
            used.map(|r| Reading::new(&r.run, r.frequency, &r.phasors).at(r.measurement.clone()));
        findings.extend(copies(&readings.collect::<Vec<_>>()));
        findings.extend(reference_gap(
            self.reference.as_ref(),
            data.runs.iter().map(|r| r.frequency),
        ));
        let measurements = self.measurements(data, &mut findings)?;
        let mut comparisons = Vec::new();
        if let [first, others @ ..] = measurements.as_slice() {
            comparisons = others
                .iter()
                .map(|other| (other.label.clone(), compare(&first.table, &other.table)))
                .collect();
            findings.extend(comparisons.iter().filter_map(|(label, list)| {
                disagreement(list)
                    .map(|evidence| findings::measurements_disagree(&first.label, label, &evidence))
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
                findings.extend(disagreement(&list).map(|evidence| {
                    findings::calculated_motion_disagrees(&model.label, &first.label, &evidence)
                }));
                comparisons.push((model.label.clone(), list));
            }
        }
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        watch.step("ratios", 1, 1)?;
        Ok(SpuriousMotionOutcome {
            measurements,
            comparisons,
            findings,
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
                Some(v) => v.velocity(run.phasors[1], f),
                None => run.phasors[1],
            };
            let assessed = Assessed {
                run: &run.run,
                frequency: f,
                quality: &run.quality,
                channels: &CHANNELS,
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
            let ratio = ratio_from_velocity(velocity, acceleration, f);
            let k = gather(
                &mut measurement.repeats,
                (run.inclination, f, run.axis),
                ratio,
            );
            if k == measurement.runs.len() {
                measurement.runs.push(Vec::new());
            }
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
                    AXES[repeats.axis],
                    repeats.inclination.to_degrees(),
                    repeats.frequency
                ))
                .with_hint("a ratio needs two repeats at least, and ten to be trusted; measure again, or take the run out"));
                }
            }
            let (mut table, doubts) = table(&measurement.repeats)?;
            table.delayed(self.front_end);
            table.common = self.common(&table)?;
            measurement.table = table;
            measurement.summaries = summaries(&measurement.repeats)?;
            findings.extend(doubts.into_iter().map(|f| {
                // The finding knows the place, the table of runs its names.
                let runs = measurement
                    .repeats
                    .iter()
                    .zip(&measurement.runs)
                    .find(|(r, _)| {
                        f.what().contains(&format!(
                            "{}′ at inclination {:.0}°, {} Hz",
                            AXES[r.axis],
                            r.inclination.to_degrees(),
                            r.frequency
                        ))
                    })
                    .map_or(String::new(), |(_, runs)| {
                        format!("; runs {}", runs.join(", "))
                    });
                f.with_evidence(|text| format!("{}: {text}{runs}", measurement.label))
            }));
        }
        Ok(list)
    }
}

/// What the two phasors of a run are, in messages.
const CHANNELS: [&str; 2] = ["reference", "velocity"];

impl SpuriousMotionJob {
    /// What the calibrations of vibrometer and reference leave open of all ratios, at every frequency.
    fn common(&self, table: &SpuriousTable) -> Result<CommonMotion> {
        let mut list: Vec<CommonCauses> = Vec::new();
        for frequency in table.entries.iter().map(|e| e.frequency) {
            if list.iter().any(|c| c.frequency == frequency) {
                continue;
            }
            let vibrometer = self.vibrometer;
            let reference = self
                .reference
                .as_ref()
                .map(|r| r.at(frequency))
                .transpose()?;
            list.push(CommonCauses {
                frequency,
                vibrometer: vibrometer.map_or([0.0; 2], |v| v.standard_uncertainty(frequency)),
                reference: reference
                    .map_or([0.0; 2], |p| [p.modulus_uncertainty, p.phase_uncertainty]),
            });
        }
        Ok(CommonMotion::new(list))
    }
}

/// Two measurements that do not agree within their uncertainties.
fn disagreement(list: &[Comparison]) -> Option<String> {
    let (apart, worst) = disagreeing(list)?;
    Some(format!(
        "E_n > 1 for {} of {} ratios; the worst along {}′ at inclination {:.0}°, {} Hz: E_n = {:.1}, difference {:.3} %",
        apart,
        list.len(),
        worst.axis,
        worst.inclination.to_degrees(),
        worst.frequency,
        worst.e_n.unwrap_or(0.0),
        100.0 * worst.difference
    ))
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
        let certificate = Certificate::of_reference(&self.source, self.reference.as_ref())?;
        let observed = observe(
            &mut table,
            self.recording.as_ref(),
            || self.waveform_options(),
            None,
            watch,
        )?;
        let name = table.path.display().to_string();
        let velocities = self.velocities()?;
        // A record of several axes is a run of each.
        let named = |run: &str, axis: Option<usize>| {
            axis.map_or(run.to_owned(), |axis| format!("{run}@{}", AXES[axis]))
        };
        let rows = table.runs.iter().zip(&observed.runs);
        let runs = rows
            .flat_map(|(run, seen)| {
                let place = format!("{name}:{}", run.line);
                let quality = seen.quality(None);
                velocities
                    .iter()
                    .enumerate()
                    .map(move |(k, &(_, axis))| SpuriousRun {
                        run: named(&run.run, axis),
                        frequency: run.frequency_hz,
                        inclination: run.seat.inclination,
                        axis: axis.or(run.seat.axis).unwrap_or_default(),
                        measurement: run.seat.measurement.clone(),
                        phasors: [seen.phasors[0], seen.phasors[1 + k]],
                        quality: of_channel(&quality, 1 + k),
                        place: place.clone(),
                    })
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
        job.vibrometer = self.vibrometer.map(|v| Vibrometer {
            // A velocity is the volts of a decoder of one.
            sensitivity: v.sensitivity.unwrap_or(1.0),
            delay: v.delay_s,
            sensitivity_uncertainty: v.relative_standard_uncertainty,
            delay_uncertainty: v.delay_standard_uncertainty_s,
        });
        job.front_end = self.front_end()?;
        let excluded = table.excluded(&self.runs.exclude);
        let each = |run: &String| {
            velocities
                .iter()
                .map(|v| named(run, v.1))
                .collect::<Vec<_>>()
        };
        job.excluded = excluded.iter().flat_map(each).collect();
        for model in self.read_models()? {
            inputs.extend(model.input);
            job.models.push(model.correction);
        }
        let said = (findings, inputs);
        Ok(BenchFiles::new((job, runs), &table.path, said, observed))
    }

    /// What the result is filed with.
    pub fn record(&self, files: &SpuriousMotionFiles, date: Option<String>) -> Record {
        self.filed(date, files.inputs.clone())
    }
}
