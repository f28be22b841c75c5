//! A triaxial campaign on the shaker, with its truth.

use super::bench_arguments::BenchArguments;
use super::fault::{Chosen, Practice};
use super::hand_over;
use crate::{Failure, Outcome, console};
use proofmass::calibration::shaker::geometry::{self, Configuration};
use proofmass::calibration::shaker::plan::best;
use proofmass::calibration::shaker::spurious::{Repeats, ratio_from_velocity, table};
use proofmass::io::{Cell, OutputFolder, Table, write_f32};
use proofmass::jobs::campaign::SpuriousFile;
use proofmass::rig::bench::Bench;
use proofmass::rig::bench::laboratory::{Laboratory, PreparedRun, Setup, Truth, Unreached};
use proofmass::rig::bench::waveform::Acquisition;
use rayon::prelude::*;
use serde::Serialize;

/// A triaxial accelerometer on wedges on a shaker: campaign.toml, runs.csv, one recording per run, reference.csv,
/// spurious.csv, truth.json.
#[derive(clap::Args)]
pub(super) struct Shaker {
    #[command(flatten)]
    bench: BenchArguments,
    /// Number of configurations: the best ones of the published 44
    #[arg(long, default_value_t = 44, value_parser = clap::value_parser!(u32).range(3..=44))]
    configurations: u32,
    /// Duration of a recording, s
    #[arg(long, default_value_t = 2.0)]
    duration: f64,
    /// Sampling rate, Hz
    #[arg(long, default_value_t = 51_200.0)]
    sampling_rate: f64,
    /// Write phasors into runs.csv instead of recordings
    #[arg(long)]
    phasors: bool,
    /// A table and wedges that move along the excitation alone
    #[arg(long)]
    ideal_table: bool,
    /// Repeats of every vibrometer reading
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(2..=1000))]
    repeats: u32,
    /// Something that goes wrong, for practice: swapped-cables, inverted-channel, clipped, wrong-frequency,
    /// wrong-mounting, missing-run, double-run; in the run in the middle, or in run 17 with `swapped-cables:17`
    #[arg(long, value_name = "FAULT[:RUN]")]
    fault: Vec<Chosen>,
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
    #[serde(flatten)]
    truth: Truth,
}

impl Shaker {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let faults = self.check()?;
        let folder = OutputFolder::create(&self.bench.output, false)?;
        let laboratory = self.laboratory();
        let plan = self.plan()?;
        let setup = laboratory.set_up(&plan, &self.bench.frequencies, self.bench.seed);
        let digits = setup.len().to_string().len();
        let name = |run: usize| format!("run-{:0digits$}", run + 1);
        let bar = console::progress(setup.len() as u64, "runs");
        // Each run is prepared, recorded and written before its samples are let go.
        let prepared: Vec<PreparedRun> = (0..setup.len())
            .into_par_iter()
            .map(|run| {
                let fault = faults.iter().find(|f| f.1 == run);
                let prepared = setup
                    .prepare(run, fault.and_then(|f| f.0.on_the_bench()))
                    .map_err(unreached)?;
                if !self.phasors {
                    let samples = setup.record(run, &prepared);
                    let views: [&[f64]; 4] = std::array::from_fn(|k| samples[k].as_slice());
                    write_f32(&folder.file(&format!("{}.f32", name(run))), &views)?;
                }
                bar.inc(1);
                Ok(prepared)
            })
            .collect::<Result<_, Failure>>()?;
        bar.finish_and_clear();
        folder.write("runs.csv", self.runs(&prepared, &name, &faults)?.to_csv()?)?;
        folder.write(
            "reference.csv",
            reference(&laboratory, &self.bench.frequencies)?,
        )?;
        if laboratory.bench.wedge.is_some() {
            folder.write(
                "spurious.csv",
                spurious(
                    &setup,
                    &plan,
                    &self.bench.frequencies,
                    self.repeats as usize,
                )?,
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
            truth: setup.truth(),
        };
        hand_over(folder, self.campaign(&laboratory), &truth)
    }

    /// Numbers that can be simulated; the faults with the index of their run.
    fn check(&self) -> Result<Vec<(Practice, usize)>, Failure> {
        for (name, value, low, high) in [
            ("--duration", self.duration, 0.01, 600.0),
            ("--sampling-rate", self.sampling_rate, 100.0, 1e6),
        ] {
            if !(low..=high).contains(&value) {
                return Err(Failure::new(format!("{name} {value} is out of range"))
                    .hint(format!("from {low} to {high}")));
            }
        }
        let highest = 0.5 * self.sampling_rate;
        for (i, &f) in self.bench.frequencies.iter().enumerate() {
            // The certificate and the models of the bench reach this far.
            if !(1.0..=10e3).contains(&f) || f >= highest {
                return Err(Failure::new(format!("{f} Hz cannot be simulated"))
                    .hint("from 1 Hz to 10 kHz, below half the sampling rate"));
            }
            if self.bench.frequencies[..i].contains(&f) {
                return Err(Failure::new(format!("{f} Hz is given twice")));
            }
            if !self.phasors && f * self.duration < 2.0 {
                return Err(Failure::new(format!(
                    "{} s hold less than two periods of {f} Hz",
                    self.duration
                ))
                .hint("raise --duration"));
            }
        }
        let count = self.bench.frequencies.len() * self.configurations as usize;
        self.fault
            .iter()
            .map(|chosen| {
                let run = chosen.run.map_or(count / 2, |number| number - 1);
                if run >= count {
                    return Err(Failure::new(format!(
                        "there is no run {}, the campaign has {count}",
                        run + 1
                    )));
                }
                if self.phasors && chosen.practice.needs_samples() {
                    return Err(Failure::new("this fault shows in recordings only")
                        .hint("leave out --phasors"));
                }
                Ok((chosen.practice, run))
            })
            .collect()
    }

    fn laboratory(&self) -> Laboratory {
        let standard = Laboratory::default();
        Laboratory {
            bench: Bench {
                wedge: standard.bench.wedge.clone().filter(|_| !self.ideal_table),
                ..standard.bench.clone()
            },
            acquisition: Acquisition {
                sampling_frequency: self.sampling_rate,
                duration: self.duration,
                ..standard.acquisition.clone()
            },
            ..standard
        }
    }

    /// Inclinations and rotations in degrees.
    fn plan(&self) -> Result<Vec<(f64, f64)>, Failure> {
        let all = geometry::published_plan();
        let chosen = best(&all, self.configurations as usize)
            .map_err(|e| Failure::new(format!("no plan of that size: {e}")))?;
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
    ) -> Result<Table, Failure> {
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
        if self.phasors {
            for channel in ["reference", "x", "y", "z"] {
                columns.extend([format!("{channel}_V"), format!("{channel}_phase_deg")]);
            }
        } else {
            columns.push("file".into());
        }
        let mut table = Table::new(columns);
        let mut again = vec![];
        for (run, p) in prepared.iter().enumerate() {
            let mut row = vec![
                Cell::from(name(run).as_str()),
                Cell::from(p.frequency),
                Cell::from(p.inclination_deg),
                Cell::from(p.rotation_deg),
                Cell::from(p.target),
                Cell::from((p.transverse * 1e4).round() * 1e-2),
            ];
            if self.phasors {
                for volts in &p.volts {
                    row.push(Cell::from(volts[0].norm()));
                    row.push(Cell::from(volts[0].arg().to_degrees()));
                }
            } else {
                row.push(Cell::from(format!("{}.f32", name(run)).as_str()));
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
        let recording = if self.phasors {
            String::new()
        } else {
            format!(
                r#"
[recording]
format = "f32"
sampling_rate_Hz = {}
full_scale_V = {}
channels = {{ reference = 1, x = 2, y = 3, z = 4 }}
"#,
                self.sampling_rate, laboratory.acquisition.full_scale
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
            ""
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
sensitivity = 10.2
tolerance = 1.02
unit = "mV/(m/s²)"
{budget}"#,
            seed = self.bench.seed,
            budget = budget(bench),
        )
    }
}

/// The budget that describes the bench, as entries of campaign.toml.
fn budget(bench: &Bench) -> String {
    let rectangular =
        |half: f64| format!("{{ kind = \"rectangular\", lower = -{half}, upper = {half} }}");
    let normal = |u: f64| format!("{{ kind = \"normal\", mean = 0.0, u = {u} }}");
    let degrees = |a: f64| rectangular((a.to_degrees() * 1e9).round() * 1e-9);
    let run = "\"run\", \"channel\"";
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
            "V",
            normal(bench.floor),
            run,
        ),
    ]
    .iter()
    .map(|(name, description, acts, unit, distribution, keys)| {
        format!(
            "\n[[budget]]\nname = \"{name}\"\ndescription = \"{description}\"\nacts = \"{acts}\"\nunit = \"{unit}\"\n\
             distribution = {distribution}\nvaries_with = [{keys}]\n"
        )
    })
    .collect()
}

fn unreached(u: Unreached) -> Failure {
    Failure::new(format!(
        "the shaker does not reach {} m/s² at {} Hz",
        u.target, u.frequency
    ))
}

/// The certificate: nominal sensitivities with their expanded uncertainties (k = 2).
fn reference(laboratory: &Laboratory, frequencies: &[f64]) -> Result<Vec<u8>, Failure> {
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
) -> Result<Vec<u8>, Failure> {
    let mut measured = vec![];
    for inclination in inclinations(plan) {
        for &frequency in frequencies {
            for axis in 0..3 {
                let readings = setup.vibrometer(inclination, frequency, axis, repeats);
                measured.push(Repeats {
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
        .map_err(|e| Failure::new(format!("the spurious motion cannot be averaged: {e}")))?;
    Ok(SpuriousFile::table(&table)?.to_csv()?)
}

/// The inclinations of a plan, each once.
pub(super) fn inclinations(plan: &[(f64, f64)]) -> Vec<f64> {
    let mut list: Vec<f64> = plan.iter().map(|p| p.0).collect();
    list.sort_by(f64::total_cmp);
    list.dedup();
    list
}
