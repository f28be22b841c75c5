//! From the files of a campaign to the job and its runs.

use super::{ShakerPrimaryFiles, ShakerPrimaryJob, ShakerPrimaryRun};
use crate::bench_runs::BenchFiles;
use crate::campaign::{RunData, ShakerPrimaryCampaign, ShakerRun};
use crate::campaign::{RunTable, SingleAxisSeat};
use crate::observed::{Observed, place};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use num_complex::Complex64;
use proofmass_core::Watch;
use proofmass_io::{Input, Waveform, WaveformOptions};
use proofmass_shaker::findings::{
    interferometer_unusable, phase_too_fast, quadrature_arc, signal_dropout, wavelength_assumed,
};
use proofmass_shaker::interferometer::{
    HELIUM_NEON, HELIUM_NEON_UNCERTAINTY, SineApproximationMethod, Unusable,
};
use proofmass_shaker::primary::PrimaryRun;
use proofmass_uncertainty::{Finding, Severity};
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// A run, or why there is none; the recording and what reading it found.
struct Seen {
    run: std::result::Result<ShakerPrimaryRun, Finding>,
    input: Input,
    findings: Vec<Finding>,
}

impl ShakerPrimaryCampaign {
    /// Reads the tables of the campaign and its recordings.
    ///
    /// # Errors
    /// A file that cannot be read, recordings of which none gives a motion, or `watch` wanted it to stop.
    pub fn load(&self, watch: &dyn Watch) -> Result<ShakerPrimaryFiles> {
        let table = self.read_runs()?;
        let options = self.waveform_options()?;
        let wavelength = self
            .interferometer
            .wavelength_nm
            .map_or(HELIUM_NEON, |nm| 1e-9 * nm);
        let done = Mutex::new(0u64);
        let told = |more: u64| {
            let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
            *done += more;
            watch.step("recordings", *done, table.runs.len() as u64)
        };
        let seen = table
            .runs
            .par_iter()
            .map(|run| {
                told(0)?;
                let seen = self.see(&table, run, &options, wavelength)?;
                told(1)?;
                Ok(seen)
            })
            .collect::<Vec<Result<Seen>>>();
        let mut observed = Observed {
            runs: Vec::new(),
            inputs: vec![table.input.clone()],
            findings: Vec::new(),
        };
        let (mut runs, mut lost) = (Vec::new(), Vec::new());
        // Of several that fail the first in the table is named, whichever thread was first.
        for seen in seen {
            let seen = seen?;
            observed.inputs.push(seen.input);
            observed.findings.extend(seen.findings);
            match seen.run {
                Ok(run) => runs.push(run),
                Err(why) => lost.push(why),
            }
        }
        if let (true, Some(why)) = (runs.is_empty(), lost.first()) {
            return Err(
                Trouble::data(format!("{}: no run gives a motion", table.path.display()))
                    .detail(why.what().to_owned())
                    .detail(why.evidence_text().to_owned())
                    .with_hint(why.advice_text().to_owned()),
            );
        }
        observed.findings.extend(lost);
        let mut findings = Vec::new();
        let (stated, budget) = (self.interferometer.wavelength_nm, self.budget());
        if stated.is_none() {
            findings.push(wavelength_assumed(
                1e9 * HELIUM_NEON,
                HELIUM_NEON_UNCERTAINTY,
            ));
        }
        let mut job = ShakerPrimaryJob::new(wavelength, budget);
        let datasheet = self.datasheet.as_ref().map(|d| d.si(&self.source));
        if let Some((output, datasheet)) = datasheet.transpose()? {
            if output != crate::DeviceOutput::Volt {
                return Err(Trouble::data(
                    "[datasheet] is not in volts, and the device gives volts",
                )
                .detail(self.source.path.display().to_string())
                .with_hint("state unit in [datasheet] in V or mV per m/s² or g"));
            }
            job.datasheet = Some(datasheet);
        }
        job.excluded = table.excluded(&self.runs.exclude);
        job.coverage_factor = self.method.coverage_factor;
        let inputs = vec![self.source.input.clone()];
        Ok(BenchFiles::new(
            (job, runs),
            &table.path,
            (findings, inputs),
            observed,
        ))
    }

    /// What the result is filed with.
    pub fn record(&self, files: &ShakerPrimaryFiles, date: Option<String>) -> Record {
        self.filed(date, files.inputs.clone())
    }

    /// One recording.
    fn see(
        &self,
        table: &RunTable<SingleAxisSeat>,
        run: &ShakerRun<SingleAxisSeat>,
        options: &WaveformOptions,
        wavelength: f64,
    ) -> Result<Seen> {
        let place = || place(table, run);
        let RunData::Recording(name) = &run.data else {
            return Err(Trouble::data("a primary calibration needs recordings").detail(place()));
        };
        let waveform = table
            .source
            .source(name)
            .and_then(|source| Waveform::from_source(source, options))
            .map_err(|e| Trouble::from(e).detail(place()))?;
        let rate = waveform.sampling_rate_hz;
        let recording = &self.recording;
        let method = SineApproximationMethod {
            wavelength,
            reading: recording.phasor_reading(rate),
        };
        let frequency = run.frequency_hz;
        let [cosine, sine, output] = [0, 1, 2].map(|k| waveform.channels[k].as_slice());
        let named = |f: &Finding| f.clone().of_part(format_args!("run {}", run.run));
        let mut findings: Vec<Finding> = waveform.findings.iter().map(named).collect();
        if [cosine, sine]
            .iter()
            .any(|c| method.reading.at_full_scale(c))
        {
            findings.push(proofmass_uncertainty::findings::clipped(
                &format!("run {} is clipped", run.run),
                "samples at full scale on a channel of the interferometer",
                "the phase of the interference is wrong there",
            ));
        }
        let found = match method.evaluate(frequency, [cosine, sine], output) {
            Ok(found) => found,
            Err(why) => {
                return Ok(Seen {
                    run: Err(left_out(
                        &run.run,
                        &why,
                        rate,
                        waveform.duration_s(),
                        frequency,
                    )),
                    input: waveform.input(),
                    findings,
                });
            }
        };
        if found.output.norm() == 0.0 {
            return Err(Trouble::data(format!(
                "{}: channel output carries no signal at all",
                table.source.resolve(name).display()
            ))
            .detail(place())
            .with_hint("check its cable and the channels in [recording]"));
        }
        let sign = if self.interferometer.motion.against() {
            -1.0
        } else {
            1.0
        };
        let lag = |channel: &str| recording.delays.get(channel).map_or(0.0, |d| d.lag());
        let late = lag("output") - 0.5 * (lag("cosine") + lag("sine"));
        let turn = Complex64::from_polar(1.0, std::f64::consts::TAU * frequency * late);
        Ok(Seen {
            run: Ok(ShakerPrimaryRun {
                run: PrimaryRun {
                    run: run.run.clone(),
                    frequency,
                    acceleration: sign * found.acceleration,
                    output: found.output * turn,
                    noise: [
                        found.noise[0],
                        proofmass_signal::transfer::turned(found.noise[1], turn),
                    ],
                    correction: found.correction,
                    remainder: found.remainder,
                    transverse: run.seat.transverse,
                    checks: found.checks,
                },
                quadrature: found.quadrature,
                target: run.seat.target,
                quality: found.phasors.quality(None),
            }),
            input: waveform.input(),
            findings,
        })
    }
}

/// Why a run is not used.
fn left_out(run: &str, why: &Unusable, rate: f64, duration: f64, frequency: f64) -> Finding {
    let channel = |k: &usize| ["cosine", "sine"][*k];
    let words = match why {
        Unusable::Arc(arc, u) => {
            let u = 100.0 * u.min(10.0);
            return quadrature_arc(run, *arc, u, ", and it was left out").at(Severity::Decision);
        }
        Unusable::Dropout(samples, first) => {
            return signal_dropout(run, *samples, *first as f64 / rate);
        }
        Unusable::TooFast(step, factor) => {
            return phase_too_fast(run, *step, rate, factor * rate);
        }
        Unusable::Constant(k) => {
            format!("channel {} is constant: no light moves in it", channel(k))
        }
        Unusable::NoCircle(residual) => format!(
            "the channels cosine and sine draw no ellipse: they are {:.0} % of the radius off it, as where another signal stands in one of them or the motion is a small part of a fringe",
            100.0 * residual
        ),
        Unusable::Short(periods, needed) => format!(
            "{duration:.4} s hold {periods:.1} periods of {frequency} Hz, and {needed:.0} are needed"
        ),
        Unusable::Fit(error) => error.to_string(),
        _ => "its samples cannot be used".to_owned(),
    };
    interferometer_unusable(run, &words)
}
