//! A triaxial campaign on the shaker, with its truth.

use super::Desk;
use super::fault::{Practice, PracticeFault};
use super::sensor::{Sensor, SensorTruth};
use super::wedge_motion::bent;
use crate::campaign::SpuriousFile;
use crate::stored_result::as_filed;
use crate::trouble::{Result, Trouble};
use num_complex::Complex64;
use proofmass_io::{Cell, Table, f32_bytes};
use proofmass_rig::bench::laboratory::{Laboratory, PreparedRun, Setup, Truth, Unreached};
use proofmass_rig::bench::waveform::Acquisition;
use proofmass_rig::bench::{Bench, Bending, session_gains};
use proofmass_shaker::geometry::{self, Configuration};
use proofmass_shaker::plan::best;
use proofmass_shaker::recording::Drive;
use proofmass_shaker::sample_clock::SampleClock;
use proofmass_shaker::spurious::{RatioRepeats, ratio_from_velocity, table};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::Mutex;

/// Standard deviation of a gain from session to session, relative and in rad.
const SESSION: f64 = 1e-3;

/// A triaxial accelerometer on wedges on a shaker: campaign.toml, runs.csv, one recording per run, reference.csv,
/// spurious.csv, truth.json.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct SimulatedShaker {
    /// The same seed makes the same campaign on every machine
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedShaker::default().seed))]
    pub seed: u64,
    /// Drive frequencies, Hz
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "LIST",
            value_delimiter = ',',
            default_value = "5,10,20,40,80,160,315,630,1000"
        )
    )]
    pub frequencies: Vec<f64>,
    /// Number of configurations: the best ones of the published 44
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedShaker::default().configurations))]
    pub configurations: u32,
    /// Duration of a recording, s
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedShaker::default().duration))]
    pub duration: f64,
    /// Sampling rate, Hz
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedShaker::default().sampling_rate))]
    pub sampling_rate: f64,
    /// Write phasors into runs.csv instead of recordings
    #[cfg_attr(feature = "clap", arg(long))]
    pub phasors: bool,
    /// A table and wedges that move along the excitation alone
    #[cfg_attr(feature = "clap", arg(long))]
    pub ideal_table: bool,
    /// Bending of wedges by inclination and frequency, in place of the standard one
    #[cfg_attr(feature = "clap", arg(skip))]
    pub wedge_motion: Vec<Bending>,
    /// The device as a digital sensor with files of its own, by whose clock it samples: own, shared
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "CLOCK", value_parser = clock_word))]
    pub sensor: Option<SampleClock>,
    /// How a recording is driven: sine (one frequency each), multi-sine or stepped (all frequencies in one)
    #[cfg_attr(feature = "clap", arg(long, value_name = "DRIVE", default_value = "sine", value_parser = drive_word))]
    pub drive: Drive,
    /// Sessions that the mountings are measured in, in turn; each has gains of its own, by 0.1 % and 1 mrad
    #[cfg_attr(feature = "clap", arg(long, value_name = "NUMBER", default_value_t = SimulatedShaker::default().sessions))]
    pub sessions: u32,
    /// Repeats of every vibrometer reading
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedShaker::default().repeats))]
    pub repeats: u32,
    /// Something that goes wrong, for practice: swapped-cables, inverted-channel, clipped, wrong-frequency,
    /// wrong-mounting, missing-run, double-run; in the run in the middle, or in run 17 with `swapped-cables:17`
    #[cfg_attr(feature = "clap", arg(long, value_name = "FAULT[:RUN]"))]
    pub fault: Vec<PracticeFault>,
}

impl Default for SimulatedShaker {
    fn default() -> Self {
        Self {
            seed: 1,
            frequencies: vec![5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 315.0, 630.0, 1000.0],
            configurations: 44,
            duration: 2.0,
            sampling_rate: 51_200.0,
            phasors: false,
            ideal_table: false,
            wedge_motion: Vec::new(),
            sensor: None,
            drive: Drive::Sine,
            sessions: 1,
            repeats: 10,
            fault: Vec::new(),
        }
    }
}

#[derive(Serialize)]
struct FaultTruth {
    fault: Practice,
    run: String,
}

#[derive(Serialize)]
struct TruthFile {
    scenario: &'static str,
    faults: Vec<FaultTruth>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sensor: Option<SensorTruth>,
    /// Gains of the outputs x, y, z in each session, real and imaginary part.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    session_gains: Vec<[Complex64; 3]>,
    #[serde(flatten)]
    truth: Truth,
}

impl SimulatedShaker {
    pub(super) fn simulate(&self, desk: &Desk<'_>) -> Result<serde_json::Value> {
        let faults = self.check()?;
        let laboratory = self.laboratory()?;
        let plan = self.plan()?;
        let setup = laboratory.set_up(&plan, &self.frequencies, self.seed);
        let sensor = self.sensor.map(|clock| Sensor::new(clock, self.duration));
        let gains = self.session_gains();
        let digits = setup.len().to_string().len();
        let name = |run: usize| format!("run-{:0digits$}", run + 1);
        let done = Mutex::new(0);
        // Each run is prepared, recorded and written before its samples are let go.
        let prepared: Vec<PreparedRun> = (0..setup.len())
            .into_par_iter()
            .map(|run| {
                let fault = faults.iter().find(|f| f.1 == run);
                let mut prepared = setup
                    .prepare(run, fault.and_then(|f| f.0.on_the_bench()))
                    .map_err(unreached)?;
                if let Some(gains) = gains.get(self.session_of(run)) {
                    for (volts, gain) in prepared.volts[1..].iter_mut().zip(gains) {
                        *volts = volts.map(|v| v * gain);
                    }
                }
                if !self.phasors && self.drive == Drive::Sine {
                    let samples = setup.record(run, &prepared);
                    let views: [&[f64]; 4] = std::array::from_fn(|k| samples[k].as_slice());
                    let channels = if sensor.is_some() {
                        &views[..1]
                    } else {
                        &views[..]
                    };
                    desk.write(&format!("{}.f32", name(run)), f32_bytes(channels)?)?;
                    if let Some(sensor) = &sensor {
                        let file = format!("{}-sensor.csv", name(run));
                        sensor.record(desk, (run, self.seed), &file, &prepared)?;
                    }
                }
                desk.one_more("runs", &done, setup.len())?;
                Ok(prepared)
            })
            .collect::<Result<_>>()?;
        if self.drive != Drive::Sine {
            self.several(desk, &setup, &prepared, plan.len())?;
        }
        desk.write("runs.csv", self.runs(&prepared, &name, &faults)?.to_csv()?)?;
        desk.write("reference.csv", reference(&laboratory, &self.frequencies)?)?;
        if laboratory.bench.wedge.is_some() {
            desk.write(
                "spurious.csv",
                spurious(&setup, &plan, &self.frequencies, self.repeats as usize)?,
            )?;
        }
        let truth = TruthFile {
            scenario: "shaker",
            faults: faults
                .iter()
                .map(|&(fault, run)| FaultTruth {
                    fault,
                    run: name(run),
                })
                .collect(),
            sensor: sensor.map(|s| s.truth()),
            session_gains: gains,
            truth: setup.truth(),
        };
        desk.write("campaign.toml", self.campaign(&laboratory).into_bytes())?;
        desk.truth(&truth)
    }

    /// Writes a recording of all frequencies for each configuration.
    fn several(
        &self,
        desk: &Desk<'_>,
        setup: &Setup,
        prepared: &[PreparedRun],
        configurations: usize,
    ) -> Result<()> {
        let digits = prepared.len().to_string().len();
        for place in 0..configurations {
            let runs = (0..self.frequencies.len()).map(|f| f * configurations + place);
            let parts: Vec<[Vec<f64>; 4]> =
                runs.map(|run| setup.record(run, &prepared[run])).collect();
            // Tones at once share the full scale.
            let share = 1.0 / parts.len() as f64;
            let joined: Vec<Vec<f64>> = (0..4)
                .map(|k| match self.drive {
                    Drive::Stepped => parts.iter().flat_map(|p| p[k].iter().copied()).collect(),
                    _ => (0..parts[0][k].len())
                        .map(|i| share * parts.iter().map(|p| p[k][i]).sum::<f64>())
                        .collect(),
                })
                .collect();
            let views: Vec<&[f64]> = joined.iter().map(Vec::as_slice).collect();
            desk.write(
                &format!("run-{:0digits$}.f32", place + 1),
                f32_bytes(&views)?,
            )?;
        }
        Ok(())
    }

    /// Session of a run, from zero: that of its mounting.
    fn session_of(&self, run: usize) -> usize {
        run % self.configurations as usize % self.sessions as usize
    }

    /// Gains of the outputs in each session; none where there is one.
    fn session_gains(&self) -> Vec<[Complex64; 3]> {
        match self.sessions {
            0 | 1 => Vec::new(),
            count => session_gains(count as usize, SESSION, self.seed),
        }
    }

    /// Numbers that can be simulated; the faults with the index of their run.
    fn check(&self) -> Result<Vec<(Practice, usize)>> {
        for (name, value, low, high) in [
            ("duration", self.duration, 0.01, 600.0),
            ("sampling rate", self.sampling_rate, 100.0, 1e6),
            ("configurations", f64::from(self.configurations), 3.0, 44.0),
            ("repeats", f64::from(self.repeats), 2.0, 1000.0),
            ("sessions", f64::from(self.sessions), 1.0, 44.0),
        ] {
            if !(low..=high).contains(&value) {
                return Err(Trouble::request(format!("{name} {value} is out of range"))
                    .with_hint(format!("from {low} to {high}")));
            }
        }
        let several = self.drive != Drive::Sine;
        if several && (self.phasors || self.sensor.is_some() || !self.fault.is_empty()) {
            return Err(Trouble::request("several frequencies in one recording are simulated without phasors, sensor and faults")
                .with_hint("leave --phasors, --sensor and --fault out, or --drive"));
        }
        if self.phasors && self.sensor.is_some() {
            return Err(Trouble::request(
                "a sensor with files of its own has no phasors in the table",
            )
            .with_hint("leave --phasors or --sensor out"));
        }
        if self.sensor.is_some() {
            Sensor::new(SampleClock::Own, self.duration).check(&self.frequencies)?;
        }
        let highest = 0.5 * self.sampling_rate;
        for (i, &f) in self.frequencies.iter().enumerate() {
            // The certificate and the models of the bench reach this far.
            if !(1.0..=10e3).contains(&f) || f >= highest {
                return Err(Trouble::request(format!("{f} Hz cannot be simulated"))
                    .with_hint("from 1 Hz to 10 kHz, below half the sampling rate"));
            }
            if self.frequencies[..i].contains(&f) {
                return Err(Trouble::request(format!("{f} Hz is given twice")));
            }
            if !self.phasors && f * self.duration < 2.0 {
                return Err(Trouble::request(format!(
                    "{} s hold less than two periods of {f} Hz",
                    self.duration
                ))
                .with_hint("raise the duration"));
            }
        }
        let count = self.frequencies.len() * self.configurations as usize;
        self.fault
            .iter()
            .map(|chosen| {
                let run = chosen.run.map_or(count / 2, |number| number - 1);
                if run >= count {
                    return Err(Trouble::request(format!(
                        "there is no run {}, the campaign has {count}",
                        run + 1
                    )));
                }
                if self.phasors && chosen.practice.needs_samples() {
                    return Err(Trouble::request("this fault shows in recordings only")
                        .with_hint("write recordings, not phasors"));
                }
                Ok((chosen.practice, run))
            })
            .collect()
    }

    fn laboratory(&self) -> Result<Laboratory> {
        let standard = Laboratory::default();
        let wedge = standard.bench.wedge.clone().filter(|_| !self.ideal_table);
        Ok(Laboratory {
            bench: Bench {
                wedge: bent(wedge, &self.wedge_motion, &self.frequencies)?,
                ..standard.bench.clone()
            },
            acquisition: Acquisition {
                sampling_frequency: self.sampling_rate,
                duration: self.duration,
                ..standard.acquisition.clone()
            },
            ..standard
        })
    }

    /// Inclinations and rotations in degrees.
    fn plan(&self) -> Result<Vec<(f64, f64)>> {
        let all = geometry::published_plan();
        let chosen = best(&all, self.configurations as usize)
            .map_err(|e| Trouble::request(format!("no plan of that size: {e}")))?;
        let degrees = |c: &Configuration| {
            let round = |a: f64| (a.to_degrees() * 1e6).round() * 1e-6;
            (round(c.inclination), round(c.rotation))
        };
        Ok(chosen.iter().map(|&k| degrees(&all[k])).collect())
    }

    fn runs(
        &self,
        prepared: &[PreparedRun],
        name: &dyn Fn(usize) -> String,
        faults: &[(Practice, usize)],
    ) -> Result<Table> {
        let mut columns: Vec<String> = [
            "run",
            "frequency_Hz",
            "inclination_deg",
            "rotation_deg",
            "target_m/s2",
            "transverse_%",
        ]
        .map(String::from)
        .to_vec();
        if self.sessions > 1 {
            columns.insert(1, "session".into());
        }
        if self.phasors {
            for channel in ["reference", "x", "y", "z"] {
                columns.extend([format!("{channel}_V"), format!("{channel}_phase_deg")]);
            }
        } else {
            columns.push("file".into());
            if self.sensor.is_some() {
                columns.push("output_file".into());
            }
        }
        let several = self.drive != Drive::Sine;
        let mut table = Table::new(columns);
        let mut again = vec![];
        let rows = if several {
            prepared.len() / self.frequencies.len()
        } else {
            prepared.len()
        };
        let list: Vec<String> = self.frequencies.iter().map(f64::to_string).collect();
        for (run, p) in prepared.iter().take(rows).enumerate() {
            let mut row = vec![
                Cell::from(name(run).as_str()),
                match several {
                    true => Cell::from(list.join(" ").as_str()),
                    false => Cell::from(p.frequency),
                },
                Cell::from(p.inclination_deg),
                Cell::from(p.rotation_deg),
                match several {
                    true => Cell::Missing,
                    false => Cell::from(p.target),
                },
                Cell::from((p.transverse * 1e4).round() * 1e-2),
            ];
            if self.sessions > 1 {
                let session = format!("day-{}", self.session_of(run) + 1);
                row.insert(1, Cell::from(session.as_str()));
            }
            if self.phasors {
                for volts in &p.volts {
                    row.push(Cell::from(volts[0].norm()));
                    row.push(Cell::from(volts[0].arg().to_degrees()));
                }
            } else {
                row.push(Cell::from(format!("{}.f32", name(run)).as_str()));
                if self.sensor.is_some() {
                    row.push(Cell::from(format!("{}-sensor.csv", name(run)).as_str()));
                }
            }
            let mine = |practice| faults.contains(&(practice, run));
            if mine(Practice::DoubleRun) {
                let mut second = row.clone();
                second[0] = Cell::from(format!("{}-again", name(run)).as_str());
                again.push(second);
            }
            if !mine(Practice::MissingRun) {
                table.push(row)?;
            }
        }
        for row in again {
            table.push(row)?;
        }
        Ok(table)
    }

    fn campaign(&self, laboratory: &Laboratory) -> String {
        let bench = &laboratory.bench;
        let sensor = self.sensor.map(|clock| Sensor::new(clock, self.duration));
        let channels = match sensor {
            Some(_) => "{ reference = 1 }",
            None => "{ reference = 1, x = 2, y = 3, z = 4 }",
        };
        let drive = match self.drive {
            Drive::Sine => "",
            Drive::MultiSine => "drive = \"multi-sine\"\n",
            Drive::Stepped => "drive = \"stepped\"\n",
        };
        let recording = if self.phasors {
            String::new()
        } else {
            format!(
                r#"
[recording]
format = "f32"
sampling_rate_Hz = {}
full_scale_V = {}
channels = {channels}
{drive}{}"#,
                self.sampling_rate,
                laboratory.acquisition.full_scale,
                sensor.map_or(String::new(), |s| s.table())
            )
        };
        let corrections = if bench.wedge.is_some() {
            r#"
[[correction]]
label = "vibrometer"
file = "spurious.csv"

[[correction]]
label = "none"
"#
        } else {
            r#"
# The table was asked to move along the excitation alone.
[unmeasured_motion]
across = 0
along = 0
"#
        };
        let (factor, unit) = match sensor {
            Some(sensor) => (1e-3 * sensor.counts_per_volt(), "count/(m/s²)"),
            None => (1.0, "mV/(m/s²)"),
        };
        format!(
            r#"# A triaxial campaign of a simulated laboratory (seed {seed}); its truth is in truth.json.
kind = "shaker-triaxial"
title = "Triaxial accelerometer, simulated campaign on the shaker"

[device]
manufacturer = "proofmass"
model = "simulated triaxial accelerometer"
serial = "{seed}"

[runs]
file = "runs.csv"
{recording}
[reference]
file = "reference.csv"
k = 2
{corrections}
[method]
methods = ["joint", "complex", "published"]

[datasheet]
sensitivity = {}
tolerance = {}
unit = "{unit}"
# "transverse_%" = 5             # what else the maker prints: largest transverse sensitivity,
# reference_Hz = 160             # the frequency from which the bands count,
# [datasheet.x]                  # an axis by itself,
# sensitivity = 10.3
# "tolerance_%" = 5
# [[datasheet.band]]             # and bands of frequencies
# frequency_Hz = [10, 1000]
# "tolerance_%" = 5

# [mounting]                     # the result of another mounting: frequency_Hz, ratio, u_ratio
# file = "mounting.csv"
{budget}"#,
            10.2 * factor,
            1.02 * factor,
            seed = self.seed,
            budget = budget(bench, sensor, self.sessions > 1),
        )
    }
}

/// The budget that describes the bench, as entries of campaign.toml.
fn budget(bench: &Bench, sensor: Option<Sensor>, sessions: bool) -> String {
    let (floor, unit) = match sensor {
        Some(sensor) => (bench.floor * sensor.counts_per_volt(), "count"),
        None => (bench.floor, "V"),
    };
    let rectangular =
        |half: f64| format!("{{ kind = \"rectangular\", lower = -{half}, upper = {half} }}");
    let normal = |u: f64| format!("{{ kind = \"normal\", mean = 0.0, u = {u} }}");
    let degrees = |a: f64| rectangular((a.to_degrees() * 1e9).round() * 1e-9);
    let run = "\"run\", \"channel\"";
    let session = "\"session\", \"channel\"";
    let between = [
        (
            "session.gain",
            "gain of each output from session to session",
            "output-modulus",
            "1",
            normal(SESSION),
            session,
        ),
        (
            "session.phase",
            "phase of each output from session to session",
            "output-phase",
            "rad",
            normal(SESSION),
            session,
        ),
    ];
    [
        (
            "wedge.angle",
            "machining tolerance of the wedge faces",
            "inclination",
            "deg",
            degrees(bench.wedge_angle),
            "\"inclination\"",
        ),
        (
            "gluing.angle",
            "angle at which the device was glued",
            "rotation",
            "deg",
            degrees(bench.gluing_angle),
            "\"inclination\", \"rotation\"",
        ),
        (
            "conditioner.gain",
            "gain stability of the conditioner",
            "output-modulus",
            "1",
            rectangular(bench.gain),
            "\"channel\"",
        ),
        (
            "reading",
            "repeatability and reproducibility of one reading",
            "output-modulus",
            "1",
            normal(bench.reading),
            run,
        ),
        (
            "reading.phase",
            "phase of one reading",
            "output-phase",
            "rad",
            normal(bench.reading_phase),
            run,
        ),
        (
            "noise",
            "noise of the conditioner",
            "output-additive",
            unit,
            normal(floor),
            run,
        ),
    ]
    .iter()
    .chain(if sessions { &between[..] } else { &[] })
    .map(|(name, description, acts, unit, distribution, keys)| {
        format!(
            "\n[[budget]]\nname = \"{name}\"\ndescription = \"{description}\"\nacts = \"{acts}\"\nunit = \"{unit}\"\n\
             distribution = {distribution}\nvaries_with = [{keys}]\n"
        )
    })
    .collect()
}

/// Words of the command line.
#[cfg(feature = "clap")]
fn clock_word(word: &str) -> std::result::Result<SampleClock, String> {
    match word {
        "own" => Ok(SampleClock::Own),
        "shared" => Ok(SampleClock::Shared),
        _ => Err("own or shared".to_owned()),
    }
}

#[cfg(feature = "clap")]
fn drive_word(word: &str) -> std::result::Result<Drive, String> {
    match word {
        "sine" => Ok(Drive::Sine),
        "multi-sine" => Ok(Drive::MultiSine),
        "stepped" => Ok(Drive::Stepped),
        _ => Err("sine, multi-sine or stepped".to_owned()),
    }
}

fn unreached(u: Unreached) -> Trouble {
    Trouble::request(format!(
        "the shaker does not reach {} m/s² at {} Hz",
        u.target, u.frequency
    ))
}

/// The certificate: nominal sensitivities with their expanded uncertainties (k = 2).
fn reference(laboratory: &Laboratory, frequencies: &[f64]) -> Result<Vec<u8>> {
    let mut table = Table::new([
        "frequency_Hz",
        "sensitivity_mV/(m/s2)",
        "phase_deg",
        "U_relative_%",
        "U_phase_deg",
    ]);
    let mut sorted = frequencies.to_vec();
    sorted.sort_by(f64::total_cmp);
    for f in sorted {
        let s = laboratory.reference.at(f);
        table.push([
            f,
            1e3 * s.norm(),
            s.arg().to_degrees(),
            200.0 * laboratory.bench.reference_modulus,
            2.0 * laboratory.bench.reference_phase.to_degrees(),
        ])?;
    }
    Ok(table.to_csv()?)
}

/// The correction as a laboratory finds it: means of repeated complex ratios with their covariance.
fn spurious(
    setup: &Setup,
    plan: &[(f64, f64)],
    frequencies: &[f64],
    repeats: usize,
) -> Result<Vec<u8>> {
    let mut measured = vec![];
    for inclination in inclinations(plan) {
        for &frequency in frequencies {
            for axis in 0..3 {
                let readings = setup.vibrometer(inclination, frequency, axis, repeats);
                measured.push(RatioRepeats {
                    inclination: inclination.to_radians(),
                    frequency,
                    axis,
                    ratios: readings
                        .iter()
                        .map(|r| ratio_from_velocity(r.velocity, r.reference, frequency))
                        .collect(),
                });
            }
        }
    }
    let (table, _) = table(&measured)
        .map_err(|e| Trouble::request(format!("the spurious motion cannot be averaged: {e}")))?;
    as_filed(&SpuriousFile::table(&table))
}

/// The inclinations of a plan, each once.
pub(super) fn inclinations(plan: &[(f64, f64)]) -> Vec<f64> {
    let mut list: Vec<f64> = plan.iter().map(|p| p.0).collect();
    list.sort_by(f64::total_cmp);
    list.dedup();
    list
}
