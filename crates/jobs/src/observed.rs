//! The runs of a campaign on the shaker: recordings or a table in, phasors out.

mod doubts;
mod sensor_files;

pub(crate) use sensor_files::SensorFiles;

use crate::campaign::{RunData, RunPhasor, RunTable, ShakerRecording, ShakerRun};
use crate::findings;
use crate::trouble::{Result, Trouble};
use doubts::{durations, named, uneven, unusable};
use num_complex::Complex64;
use proofmass_core::Watch;
use proofmass_io::{Input, Waveform, WaveformOptions};
use proofmass_shaker::recording::{Drive, Line, PhasorReading, Phasors, Quality, multiplied};
use proofmass_uncertainty::Finding;
use rayon::prelude::*;
use sensor_files::{elsewhere, together, tolerance};
use std::sync::{Mutex, PoisonError};

/// Phasors of all runs, in the order of the table, and what was noticed on the way.
pub(crate) struct Observed {
    pub(crate) runs: Vec<ObservedRun>,
    /// Table and recordings.
    pub(crate) inputs: Vec<Input>,
    pub(crate) findings: Vec<Finding>,
}

pub(crate) struct ObservedRun {
    /// Complex peak amplitudes, channel by channel.
    pub(crate) phasors: Vec<Complex64>,
    pub(crate) covariances: Vec<[f64; 3]>,
    /// What the samples say; `None` for a table of phasors.
    pub(crate) recorded: Option<Recorded>,
}

pub(crate) struct Recorded {
    pub(crate) phasors: Phasors,
    duration: f64,
    rate: f64,
    path: String,
    /// Error of the sensor's clock and its standard uncertainty.
    clock_error: Option<(f64, f64)>,
}

/// One recording, at each of its frequencies.
struct Lines {
    lines: Vec<Line>,
    /// When the even grid of its samples begins, s.
    begin: f64,
    duration: f64,
    rate: f64,
    /// Standard uncertainty of that rate by the stamps, relative.
    rate_uncertainty: f64,
    input: Input,
    findings: Vec<Finding>,
}

/// Runs of one row of the table, which share their recordings.
type Row<'a, S> = &'a [ShakerRun<S>];
/// Phasors of the runs of a row, with the runs whose frequency is not in the recording; recordings and findings.
struct RowOutcome {
    runs: Vec<Option<ObservedRun>>,
    inputs: Vec<Input>,
    findings: Vec<Finding>,
}

/// Takes the phasors of a table, or reads and approximates the recordings, row by row and on all cores. Runs whose
/// frequency is not found in their recording are taken out of the table, with a finding.
///
/// `options` tells how recordings are read, and is asked only where there are some.
pub(crate) fn observe<S: Sync + Clone>(
    table: &mut RunTable<S>,
    settings: Option<&ShakerRecording>,
    options: impl FnOnce() -> proofmass_io::Result<WaveformOptions>,
    sensor: Option<SensorFiles<'_>>,
    watch: &dyn Watch,
) -> Result<Observed> {
    let recording = if table.quantities.is_empty() {
        let options = options()?;
        settings.map(|s| (s, options))
    } else {
        None
    };
    paired(table, settings, sensor.as_ref())?;
    let mut observed = Observed {
        runs: Vec::with_capacity(table.runs.len()),
        inputs: vec![table.input.clone()],
        findings: Vec::new(),
    };
    let done = Mutex::new(0);
    let rows: Vec<Row<'_, S>> = table.runs.chunk_by(|a, b| a.line == b.line).collect();
    let all = rows.len() as u64;
    let told = |more: u64| {
        let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
        *done += more;
        watch.step("recordings", *done, all)
    };
    let outcomes = rows
        .par_iter()
        .map(|row| match (&row[0].data, &recording) {
            (RunData::Recording(name), Some((settings, options))) => {
                told(0)?;
                let bench = Bench { settings, options };
                let outcome = bench.row(table, row, name, sensor.as_ref())?;
                told(1)?;
                Ok(outcome)
            }
            (RunData::Phasors(phasors), _) => Ok(RowOutcome {
                runs: vec![Some(of_phasors(phasors))],
                inputs: vec![],
                findings: vec![],
            }),
            (RunData::Recording(name), None) => Err(Trouble::data(format!(
                "{}: `[recording]` does not state how recordings are read",
                table.source.resolve(name).display()
            ))
            .with_hint("add [recording] to campaign.toml")),
        })
        .collect::<Vec<Result<RowOutcome>>>();
    // Of several that fail the first in the table is named, whichever thread was first.
    let mut kept = Vec::with_capacity(table.runs.len());
    let mut stamps = vec![];
    for (row, outcome) in rows.into_iter().zip(outcomes) {
        let outcome = outcome?;
        observed.inputs.extend(outcome.inputs);
        observed.findings.extend(outcome.findings);
        for (run, seen) in row.iter().zip(outcome.runs) {
            if let Some(seen) = seen {
                let uneven = seen.recorded.as_ref().and_then(|r| r.phasors.stamps);
                stamps.extend(uneven.map(|s| (run.run.clone(), s)));
                kept.push(run.clone());
                observed.runs.push(seen);
            }
        }
    }
    table.runs = kept;
    observed.findings.extend(uneven(&stamps));
    observed.findings.extend(durations(table, &observed.runs));
    if let Some((
        ShakerRecording {
            full_scale_v: None, ..
        },
        _,
    )) = recording
    {
        observed.findings.push(findings::clipping_unchecked());
    }
    Ok(observed)
}

/// Files of a sensor and their description come together; several frequencies need a drive that has them.
fn paired<S>(
    table: &RunTable<S>,
    settings: Option<&ShakerRecording>,
    sensor: Option<&SensorFiles<'_>>,
) -> Result<()> {
    let place = |run: &ShakerRun<S>| format!("{}:{}", table.path.display(), run.line);
    for rows in table.runs.windows(2) {
        let one = settings.is_none_or(|s| s.drive() == Drive::Sine);
        if rows[0].line == rows[1].line && one {
            return Err(Trouble::data(format!(
                "{}: the recording is to hold several frequencies, and the drive is a sine",
                place(&rows[0])
            ))
            .with_hint("write drive = \"multi-sine\" (all at once) or \"stepped\" (one after another) into [recording]"));
        }
    }
    let Some(run) = table.runs.first() else {
        return Ok(());
    };
    match (run.output_file.is_some(), sensor.is_some()) {
        (true, false) => Err(Trouble::data(format!(
            "{}: the runs name files of the sensor, and `[output_recording]` does not state how they are read",
            place(run)
        ))
        .with_hint("add [output_recording] with clock, unit and channels to campaign.toml")),
        (false, true) => Err(Trouble::data(format!(
            "{}: [output_recording] describes files of the sensor, and the runs name none",
            place(run)
        ))
        .with_hint(
            "add a column `output_file` to the table of runs, or take [output_recording] out",
        )),
        _ => Ok(()),
    }
}

fn of_phasors(phasors: &[RunPhasor]) -> ObservedRun {
    ObservedRun {
        phasors: phasors
            .iter()
            .map(|p| Complex64::from_polar(p.amplitude, p.phase))
            .collect(),
        covariances: phasors
            .iter()
            .map(|p| {
                let v = p.standard_uncertainty.powi(2);
                [v, 0.0, v]
            })
            .collect(),
        recorded: None,
    }
}

/// How the recordings of the bench are read.
struct Bench<'a> {
    settings: &'a ShakerRecording,
    options: &'a WaveformOptions,
}

impl Bench<'_> {
    /// The runs of one row.
    fn row<S: Sync>(
        &self,
        table: &RunTable<S>,
        row: Row<'_, S>,
        name: &str,
        sensor: Option<&SensorFiles<'_>>,
    ) -> Result<RowOutcome> {
        let reading = |rate: f64| {
            let mut reading = self.settings.phasor_reading(rate);
            reading.mains = listens(table, &row[0]);
            reading
        };
        let frequencies: Vec<f64> = row.iter().map(|r| r.frequency_hz).collect();
        let drive = self.settings.drive();
        let mut bench = lines(
            table,
            &row[0],
            name,
            self.options,
            &frequencies,
            drive,
            reading,
        )?;
        for (line, f) in bench.lines.iter_mut().zip(&frequencies) {
            if let Line::Found(phasors) = line {
                self.take_delays_out(phasors, *f);
            }
        }
        let mut inputs = vec![bench.input.clone()];
        let mut findings = named(&row[0].run, &bench.findings);
        let other = match (sensor, &row[0].output_file) {
            (Some(sensor), Some(file)) => {
                let reading = |rate: f64| {
                    let mut reading = PhasorReading::new(rate);
                    reading.harmonics = self.settings.harmonics;
                    reading.drift = self.settings.drift;
                    reading.full_scale = sensor.settings.full_scale();
                    // The oscillators of sensors are good for some per cent.
                    reading.tolerance = tolerance(sensor.settings.clock);
                    reading.with_reference = false;
                    reading.mains = false;
                    reading
                };
                let options = &sensor.options;
                let lines = lines(table, &row[0], file, options, &frequencies, drive, reading)?;
                inputs.push(lines.input.clone());
                findings.extend(named(&row[0].run, &lines.findings));
                Some((sensor, lines))
            }
            _ => None,
        };
        let mut runs = Vec::with_capacity(row.len());
        for (k, run) in row.iter().enumerate() {
            let doubt = |line: &Line, input: &Input| unusable(run, line, input);
            let phasors = match &bench.lines[k] {
                Line::Found(phasors) => (**phasors).clone(),
                line => {
                    findings.extend(doubt(line, &bench.input));
                    runs.push(None);
                    continue;
                }
            };
            let (phasors, clock_error) = match &other {
                None => (phasors, None),
                Some((sensor, own)) => match &own.lines[k] {
                    Line::Found(seen) if elsewhere(sensor, run.frequency_hz, seen) => {
                        let why = format!(
                            "the strongest line in the file of the sensor is at {:.4} Hz",
                            seen.measured_frequency
                        );
                        findings.extend(doubt(&Line::Missing(why), &own.input));
                        runs.push(None);
                        continue;
                    }
                    Line::Found(seen) => {
                        let both = together(sensor, (&bench, phasors), (own, (**seen).clone()))
                            .map_err(|t| t.detail(place(table, run)))?;
                        (both.0, Some(both.1))
                    }
                    line => {
                        findings.extend(doubt(line, &own.input));
                        runs.push(None);
                        continue;
                    }
                },
            };
            let names = match &other {
                Some((sensor, _)) => sensor.names.clone(),
                None => self.options.channels.iter().map(|c| c.0.as_str()).collect(),
            };
            if let Some(k) = phasors.amplitudes.iter().position(|a| a.norm() == 0.0) {
                return Err(Trouble::data(format!(
                    "{}: channel {} carries no signal at all",
                    table.source.resolve(name).display(),
                    names[k]
                ))
                .detail(place(table, run))
                .with_hint("check its cable and the channels in [recording]; measure the run again, or take its row out"));
            }
            runs.push(Some(ObservedRun {
                phasors: phasors.amplitudes.clone(),
                covariances: phasors.covariances.clone(),
                recorded: Some(Recorded {
                    phasors,
                    duration: bench.duration,
                    rate: bench.rate,
                    path: bench.input.path.clone(),
                    clock_error,
                }),
            }));
        }
        if runs.iter().all(Option::is_none) {
            let why = findings.last().map(|f| f.evidence_text().to_owned());
            return Err(Trouble::data(format!(
                "{}: none of its frequencies can be used",
                table.source.resolve(name).display()
            ))
            .detail(place(table, &row[0]))
            .detail(why.unwrap_or_default())
            .with_hint("check `drive` in [recording] and the frequencies in the table; measure the run again, or take its row out"));
        }
        Ok(RowOutcome {
            runs,
            inputs,
            findings,
        })
    }

    /// Turns the phasors by the declared delays of their channels.
    fn take_delays_out(&self, phasors: &mut Phasors, frequency: f64) {
        for (k, (name, _)) in self.options.channels.iter().enumerate() {
            let Some(delay) = self.settings.delays.get(name) else {
                continue;
            };
            phasors.turn(k, std::f64::consts::TAU * frequency * delay.lag());
        }
    }
}

/// Where a run stands.
pub(crate) fn place<S>(table: &RunTable<S>, run: &ShakerRun<S>) -> String {
    format!("run {}, {}:{}", run.run, table.path.display(), run.line)
}

/// Runs of each frequency that listen for the mains: hum is alike in all of them.
const LISTENING: usize = 4;

/// Whether the record of a run is searched for hum far from its drive: a few of each frequency are, where some drive of the
/// table lies so near to a harmonic of the mains that it may hide one.
fn listens<S>(table: &RunTable<S>, run: &ShakerRun<S>) -> bool {
    let near = |f: f64| {
        [50.0, 60.0].iter().any(|mains| {
            let order = (f / mains).round().clamp(1.0, 20.0);
            (f - order * mains).abs() < 3.0 + 3e-3 * f
        })
    };
    let same = |r: &&ShakerRun<S>| r.frequency_hz == run.frequency_hz;
    let place = table
        .runs
        .iter()
        .filter(same)
        .position(|r| r.run == run.run);
    let count = table.runs.iter().filter(same).count();
    table.runs.iter().any(|r| near(r.frequency_hz))
        && place.is_some_and(|k| k.is_multiple_of(count.div_ceil(LISTENING)))
}

/// Reads a recording and takes its phasors at every frequency.
fn lines<S>(
    table: &RunTable<S>,
    run: &ShakerRun<S>,
    name: &str,
    options: &WaveformOptions,
    frequencies: &[f64],
    drive: Drive,
    reading: impl Fn(f64) -> PhasorReading,
) -> Result<Lines> {
    let path = table.source.resolve(name);
    let source = table.source.source(name);
    let waveform = source
        .and_then(|source| Waveform::from_source(source, options))
        .map_err(|e| Trouble::from(e).detail(place(table, run)))?;
    let channels: Vec<&[f64]> = waveform.channels.iter().map(Vec::as_slice).collect();
    let late = waveform.times.as_ref().map_or(&[][..], |t| &t.late_s);
    let reading = reading(waveform.sampling_rate_hz);
    let lines = reading.lines(drive, frequencies, late, &channels).map_err(|e| {
        let list: Vec<String> = frequencies.iter().map(|f| format!("{f}")).collect();
        Trouble::data(format!(
            "{}: no sine of {} Hz can be approximated: {e}",
            path.display(),
            list.join(", ")
        ))
        .detail(place(table, run))
        .detail(format!(
            "{} samples at {} Hz, {:.4} s",
            waveform.samples(),
            waveform.sampling_rate_hz,
            waveform.duration_s()
        ))
        .with_hint("check the frequency in the table and the sampling rate; measure the run again, or take its row out")
    })?;
    let times = waveform.times.as_ref();
    Ok(Lines {
        lines,
        begin: waveform.begin_s,
        rate_uncertainty: times.map_or(0.0, |t| t.rate_u_hz / waveform.sampling_rate_hz),
        duration: waveform.duration_s(),
        rate: waveform.sampling_rate_hz,
        input: waveform.input(),
        findings: waveform.findings,
    })
}

impl ObservedRun {
    /// Divides the reading of a channel by the gain of its conditioner.
    pub(crate) fn divide(&mut self, channel: usize, gain: Complex64) {
        if let Some(phasor) = self.phasors.get_mut(channel) {
            *phasor /= gain;
        }
        if let Some(covariance) = self.covariances.get_mut(channel) {
            *covariance = multiplied(*covariance, gain.inv());
        }
    }

    /// What the samples say about the run; `transverse` is the transverse motion, where it was measured.
    pub(crate) fn quality(&self, transverse: Option<f64>) -> Quality {
        match &self.recorded {
            Some(recorded) => Quality {
                clock_error: recorded.clock_error,
                ..recorded.phasors.quality(transverse)
            },
            None => Quality {
                transverse,
                ..Quality::default()
            },
        }
    }
}

/// What the samples of the reference and of one other channel say.
pub(crate) fn of_channel(quality: &Quality, own: usize) -> Quality {
    let noise = &quality.signal_to_noise;
    let both = [noise.first(), noise.get(own)];
    let mut clipped: Vec<usize> = Vec::new();
    for (place, channel) in [(0, 0), (1, own)] {
        if quality.clipped.contains(&channel) {
            clipped.push(place);
        }
    }
    Quality {
        signal_to_noise: both.into_iter().flatten().copied().collect(),
        clipped,
        ..quality.clone()
    }
}
