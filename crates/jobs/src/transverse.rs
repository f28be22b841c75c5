//! Transverse sensitivity of a single-axis accelerometer.

mod page;

use crate::bench_runs::{BenchFiles, BenchRuns};
use crate::campaign::{Certificate, TransverseCampaign};
use crate::device_output::DeviceOutput;
use crate::measured_within::MeasuredWithin;
use crate::observed::observe;
use crate::outcome::{Job, Outcome};
use crate::record::Record;
use crate::shaker_triaxial::stated;
use crate::trouble::{Result, Trouble};
use num_complex::Complex64;
use proofmass_core::Watch;
use proofmass_documents::StatedQuantity;
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_report::Report;
use proofmass_shaker::copied_readings::{Reading, copies};
use proofmass_shaker::findings::{excluded_run, transverse_motion_unknown};
use proofmass_shaker::recording::{Assessed, Quality, QualityLimits, assess};
use proofmass_shaker::reference_gap;
use proofmass_shaker::transverse::{
    AxialSensitivity, Motion, SeatUncertainty, TransverseRow, TransverseSensitivity,
    TransverseTest, Untold, keeps_to, like_radians, untold,
};
use proofmass_uncertainty::{DegreesOfFreedom, Finding};
use serde::{Deserialize, Serialize};

/// What is to be evaluated, and how well the device sits.
///
/// ```
/// use num_complex::Complex64;
/// use proofmass_shaker::recording::Quality;
/// use proofmass_shaker::transverse::{Motion, SeatUncertainty};
/// use proofmass_jobs::transverse::{TransverseData, TransverseJob, TransverseRun};
/// use proofmass_jobs::{Job, Outcome, Unwatched};
///
/// // 10 mV/(m/s²) along the axis, 2 % of it across, strongest at 30°; the reference gives m/s².
/// let run = |name: &str, motion, output| TransverseRun {
///     run: name.into(), frequency: 160.0, motion,
///     reference: Complex64::new(10.0, 0.0), output: Complex64::new(output, 0.0),
///     transverse: Some(0.0), target: None, quality: Quality::default(), place: "line 1".into(),
/// };
/// let mut runs = vec![run("axis", Motion::Axial, 0.1)];
/// for k in 0..12 {
///     let rotation = f64::from(k) * 30f64.to_radians();
///     let output = 0.002 * (rotation - 30f64.to_radians()).cos();
///     runs.push(run(&format!("across {k}"), Motion::Transverse { rotation }, output));
/// }
/// let job = TransverseJob::new(SeatUncertainty::new(1e-3));
/// let outcome = job.evaluate(&TransverseData::new(&runs), &Unwatched)?;
/// let t = &outcome.quantities()[0];
/// assert!((t.value - 0.02).abs() < 1e-12 && (t.expanded - 0.00196).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct TransverseJob {
    /// Certificate of the reference; `None` when the runs carry accelerations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceTable>,
    /// Which standard it is and who calibrated it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_description: Option<String>,
    /// What the device gives.
    #[serde(default)]
    pub output: DeviceOutput,
    /// Sensitivity along the axis, used where no run is along it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<ReferenceTable>,
    /// How well the device sits.
    pub seat: SeatUncertainty,
    /// Largest transverse sensitivity of the datasheet, relative.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
    /// Rules of a sound run.
    pub limits: QualityLimits,
    /// Runs to be left out, by name.
    #[serde(default)]
    pub excluded: Vec<String>,
    /// A coverage factor such as 2 that U is stated with, instead of that of 95 %.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coverage_factor: Option<f64>,
}

impl TransverseJob {
    /// Runs that carry accelerations, and a device in volts that sits this well.
    pub fn new(seat: SeatUncertainty) -> Self {
        Self {
            reference: None,
            reference_description: None,
            output: DeviceOutput::default(),
            axis: None,
            seat,
            limit: None,
            limits: QualityLimits::default(),
            excluded: Vec::new(),
            coverage_factor: None,
        }
    }
}

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct TransverseRun {
    /// Name.
    pub run: String,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Along which direction the device was shaken.
    pub motion: Motion,
    /// Reference, V or m/s².
    pub reference: Complex64,
    /// Output of the device.
    pub output: Complex64,
    /// Motion of the table across the vibration relative to it, where it was measured.
    pub transverse: Option<f64>,
    /// Acceleration wanted, m/s².
    pub target: Option<f64>,
    /// What the samples said.
    pub quality: Quality,
    /// Where it stands, for messages.
    pub place: String,
}

/// The runs of a transverse test as phasors.
pub type TransverseData<'a> = BenchRuns<'a, TransverseRun>;

/// Transverse sensitivity at every frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct TransverseOutcome {
    quantities: Vec<StatedQuantity>,
    findings: Vec<Finding>,
    results: Vec<TransverseSensitivity>,
    runs: Vec<TransverseRow>,
    output: DeviceOutput,
    limit: Option<f64>,
    reference: Option<String>,
    within: MeasuredWithin,
}

impl TransverseOutcome {
    /// Transverse sensitivities in ascending frequency.
    pub fn results(&self) -> &[TransverseSensitivity] {
        &self.results
    }
}

impl Outcome for TransverseOutcome {
    const KIND: &'static str = "transverse-sensitivity";
    const PRINCIPAL_TABLE: &'static str = "transverse.csv";

    fn title(&self, record: &Record) -> String {
        record.title(
            "Transverse sensitivity of",
            "Transverse sensitivity of an accelerometer",
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

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }
}

/// Probability at which one of a healthy campaign's frequencies may be said to follow no cosine.
const FALSE_ALARM_RATE: f64 = 1e-3;

impl Job for TransverseJob {
    type Data<'a> = TransverseData<'a>;
    type Outcome = TransverseOutcome;

    fn evaluate(&self, data: &TransverseData<'_>, watch: &dyn Watch) -> Result<TransverseOutcome> {
        let mut findings = data.findings.to_vec();
        let rows = self.rows(data, &mut findings)?;
        let used = data.runs.iter().filter(|r| !self.excluded.contains(&r.run));
        let readings = used.map(|r| Reading::new(&r.run, r.frequency, &[r.reference, r.output]));
        findings.extend(copies(&readings.collect::<Vec<_>>()));
        let mut frequencies: Vec<f64> = rows.iter().map(|r| r.frequency).collect();
        frequencies.sort_by(f64::total_cmp);
        frequencies.dedup();
        findings.extend(reference_gap(
            self.reference.as_ref(),
            frequencies.iter().copied(),
        ));
        let unit = self.output.unit();
        let test = TransverseTest {
            seat: self.seat,
            unit,
            false_alarm_rate: FALSE_ALARM_RATE / frequencies.len().max(1) as f64,
        };
        let mut results = Vec::with_capacity(frequencies.len());
        for (done, &frequency) in frequencies.iter().enumerate() {
            watch.step("frequencies", done as u64, frequencies.len() as u64)?;
            let group: Vec<&TransverseRow> =
                rows.iter().filter(|r| r.frequency == frequency).collect();
            let (axial, certificate) =
                self.known_at(data.name, frequency, &group, &mut findings)?;
            self.can_be_told(data.name, frequency, &group)?;
            let (result, doubts) = test
                .evaluate(frequency, &group, certificate, axial)
                .map_err(|e| Trouble::from(e).detail(format!("{}, {frequency} Hz", data.name)))?;
            findings.extend(doubts);
            results.push(result);
        }
        let all = frequencies.len() as u64;
        watch.step("frequencies", all, all)?;
        findings.extend(self.against_datasheet(&results));
        if let Some(k) = self.coverage_factor {
            for result in &mut results {
                result.ratio.state_with(k);
                if let Some(direction) = &mut result.direction {
                    direction.state_with(k);
                }
            }
        }
        findings.extend(motion_unknown(&rows));
        findings.extend(rotation_unit(&rows));
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        let used = data.runs.iter();
        let used = used.filter(|r| !self.excluded.contains(&r.run));
        let quantities = results.iter().flat_map(|r| {
            let both = std::iter::once(&r.ratio).chain(&r.direction);
            both.map(|q| stated(q, r.frequency))
        });
        Ok(TransverseOutcome {
            quantities: quantities.collect(),
            findings,
            results,
            runs: rows,
            output: self.output,
            limit: self.limit,
            reference: self.reference_description.clone(),
            within: MeasuredWithin::runs(
                self.reference.as_ref(),
                used.map(|r| (r.frequency, r.reference)),
            ),
        })
    }
}

impl TransverseJob {
    fn rows(
        &self,
        data: &TransverseData<'_>,
        findings: &mut Vec<Finding>,
    ) -> Result<Vec<TransverseRow>> {
        let mut rows = Vec::with_capacity(data.runs.len());
        for run in data.runs {
            if self.excluded.contains(&run.run) {
                findings.push(excluded_run(&run.run, run.frequency));
                continue;
            }
            if run.reference.norm() == 0.0 {
                return Err(Trouble::data(format!(
                    "{}: run {} has no signal of the reference",
                    run.place, run.run
                ))
                .with_hint("measure the run again, or take its row out"));
            }
            if run.motion == Motion::Axial && run.output.norm() == 0.0 {
                return Err(Trouble::data(format!(
                    "{}: run {} is along the axis and has no signal of the device",
                    run.place, run.run
                ))
                .with_hint("measure the run again, or take its row out"));
            }
            let acceleration = match &self.reference {
                Some(table) => table.acceleration(run.reference, run.frequency).map_err(|e| {
                    Trouble::from(e)
                        .detail(format!("{}: run {}", run.place, run.run))
                        .with_hint("have the reference calibrated there, or leave the run out with exclude")
                })?,
                None => run.reference,
            };
            // Across the axis the output is small and carries more of harmonics and noise: only the reference is judged.
            let quality = Quality {
                signal_to_noise: run
                    .quality
                    .signal_to_noise
                    .iter()
                    .take(1)
                    .copied()
                    .collect(),
                ..run.quality.clone()
            };
            let assessed = Assessed {
                run: &run.run,
                frequency: run.frequency,
                quality: &quality,
                channels: &TransverseCampaign::CHANNELS,
                amplitude: acceleration.norm(),
                target: run.target,
            };
            findings.extend(assess(&assessed, &self.limits));
            rows.push(TransverseRow {
                run: run.run.clone(),
                frequency: run.frequency,
                motion: run.motion,
                ratio: run.output / acceleration,
                transverse: run.transverse,
            });
        }
        Ok(rows)
    }

    /// The sensitivity along the axis where it is given, and the uncertainty of the reference.
    fn known_at(
        &self,
        name: &str,
        frequency: f64,
        group: &[&TransverseRow],
        findings: &mut Vec<Finding>,
    ) -> Result<(Option<AxialSensitivity>, (f64, f64))> {
        let certificate = match &self.reference {
            Some(table) => {
                let point = table.at(frequency)?;
                (point.modulus_uncertainty, point.phase_uncertainty)
            }
            None => (0.0, 0.0),
        };
        let along: Vec<Complex64> = group
            .iter()
            .filter(|r| r.motion == Motion::Axial)
            .map(|r| r.ratio)
            .collect();
        if !along.is_empty() {
            let known = self.axis.as_ref().and_then(|t| t.at(frequency).ok());
            if let Some(known) = known {
                let mean = along.iter().sum::<Complex64>() / along.len() as f64;
                let off = mean.norm() / known.sensitivity - 1.0;
                if off.abs() > 0.05 {
                    findings.push(proofmass_shaker::findings::not_as_calibrated(
                        "the device along its axis",
                        " by [axis]; its runs were used",
                        &format!("{frequency} Hz: {:+.1} %", 100.0 * off),
                    ));
                }
            }
            return Ok((None, certificate));
        }
        let Some(table) = &self.axis else {
            return Err(Trouble::data(format!(
                "{name}: no run at {frequency} Hz is along the axis, to which the transverse sensitivity is relative"
            ))
            .with_hint(
                "add a run with inclination_deg 0 at this frequency, or [axis] with the calibration of the device",
            ));
        };
        let point = table.at(frequency).map_err(|e| {
            Trouble::from(e)
                .detail(format!("[axis], {frequency} Hz"))
                .with_hint(
                    "the calibration of the device along its axis has to reach every frequency",
                )
        })?;
        let axial = AxialSensitivity {
            value: Complex64::from_polar(point.sensitivity, point.phase),
            relative: point.modulus_uncertainty,
            phase: point.phase_uncertainty,
        };
        Ok((Some(axial), certificate))
    }

    /// Refuses with words what the evaluation would refuse with numbers.
    fn can_be_told(&self, name: &str, frequency: f64, group: &[&TransverseRow]) -> Result<()> {
        let what = match untold(&self.seat, group) {
            None => return Ok(()),
            Some(what) => what,
        };
        let at = format!("{name}: at {frequency} Hz");
        Err(match what {
            Untold::OneLine => Trouble::data(format!(
                "{at} the device was shaken along one line across its axis, which is half of a transverse sensitivity"
            ))
            .with_hint("measure two directions at a right angle at least; twelve around the circle separate the table from the device"),
            Untold::Squareness => Trouble::data(format!(
                "{at} the device was shaken in two directions, which do not show whether its axis was square to the vibration"
            ))
            .with_hint(
                "state u_squareness_deg in [mounting], or measure a third direction (180° opposite one of the two is one)",
            ),
            Untold::Scatter { across } => Trouble::data(format!(
                "{at} {across} runs across the axis leave none to show their scatter"
            ))
            .with_hint("repeat a direction, measure one more, or state u_relative in [reading]"),
        })
    }

    fn against_datasheet(&self, results: &[TransverseSensitivity]) -> Vec<Finding> {
        let Some(limit) = self.limit else {
            return Vec::new();
        };
        let list = |verdict: Option<bool>| -> Vec<String> {
            results
                .iter()
                .filter(|r| keeps_to(r, limit) == verdict)
                .map(|r| {
                    format!(
                        "{:.2} % ± {:.2} % at {} Hz",
                        100.0 * r.ratio.value,
                        100.0 * r.ratio.expanded,
                        r.frequency
                    )
                })
                .collect()
        };
        let (beyond, undecided) = (list(Some(false)), list(None));
        let mut findings = Vec::new();
        if !beyond.is_empty() {
            findings.push(proofmass_uncertainty::findings::beyond_limit(
                &format!("the transverse sensitivity is, at {:.2} %,", 100.0 * limit),
                &beyond.join("; "),
                "look at the mounting surface and the torque; else the device does not keep to its datasheet",
            ));
        }
        if !undecided.is_empty() {
            findings.push(proofmass_uncertainty::findings::limit_undecided(
                &format!("the transverse sensitivity ({:.2} %)", 100.0 * limit),
                &undecided.join("; "),
                "the budget shows which contribution to reduce",
            ));
        }
        findings
    }
}

fn rotation_unit(rows: &[TransverseRow]) -> Option<Finding> {
    like_radians(rows).map(|(count, [first, last])| {
        proofmass_shaker::findings::radians_as_degrees(
            "directions",
            &format!("{count} directions from {first}° to {last}°"),
            "call the column rotation_rad",
        )
    })
}

fn motion_unknown(rows: &[TransverseRow]) -> Option<Finding> {
    let unknown = rows.iter().filter(|r| r.transverse.is_none()).count();
    (unknown > 0).then(|| transverse_motion_unknown(unknown, rows.len()))
}

/// Everything the files of a campaign say.
pub type TransverseFiles = BenchFiles<TransverseJob, TransverseRun>;

impl TransverseCampaign {
    /// Reads the tables of the campaign and its recordings.
    ///
    /// # Errors
    /// A file that cannot be read, a recording without a sine, or `watch` wanted it to stop.
    pub fn load(&self, watch: &dyn Watch) -> Result<TransverseFiles> {
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
        let runs = table
            .runs
            .iter()
            .zip(&observed.runs)
            .map(|(run, seen)| TransverseRun {
                run: run.run.clone(),
                frequency: run.frequency_hz,
                motion: run.seat.motion,
                reference: seen.phasors[0],
                output: seen.phasors[1],
                transverse: run.seat.transverse,
                target: run.seat.target,
                quality: seen.quality(None),
                place: format!("{name}:{}", run.line),
            })
            .collect();
        let mut findings = Vec::new();
        let mut inputs = vec![self.source.input.clone()];
        let mounting = &self.mounting;
        let mut seat = SeatUncertainty::new(mounting.u_tilt_deg.to_radians());
        seat.squareness = mounting.u_squareness_deg.map(f64::to_radians);
        seat.rotation = mounting.u_rotation_deg.to_radians();
        seat.reading = self.reading.map(|r| {
            let dof = r.dof.and_then(DegreesOfFreedom::new);
            (r.u_relative, dof.unwrap_or(DegreesOfFreedom::INFINITE))
        });
        let mut job = TransverseJob::new(seat);
        job.output = DeviceOutput::of(table.quantities.get(1).copied());
        if let Some(certificate) = certificate {
            findings.extend(certificate.findings);
            inputs.push(certificate.input);
            job.reference = Some(certificate.table);
            job.reference_description = certificate.description;
        }
        if let Some(axis) = self.read_axis(job.output)? {
            findings.extend(axis.findings);
            inputs.push(axis.input);
            job.axis = Some(axis.table);
        }
        job.limit = self.datasheet.map(|d| d.transverse / 100.0);
        job.excluded = table.excluded(&self.runs.exclude);
        job.coverage_factor = self.method.coverage_factor;
        let said = (findings, inputs);
        Ok(BenchFiles::new((job, runs), &table.path, said, observed))
    }

    /// What the result is filed with.
    pub fn record(&self, files: &TransverseFiles, date: Option<String>) -> Record {
        self.filed(date, files.inputs.clone())
    }
}
