//! The runs of a campaign on the shaker: recordings or a table in, phasors out.

use crate::campaign::{DriveFrequency, RunData, RunTable, ShakerRecording, ShakerRun};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use num_complex::Complex64;
use proofmass_calibration::shaker::recording::{PhasorReading, Phasors, Quality};
use proofmass_core::Watch;
use proofmass_io::{Input, Waveform, WaveformOptions};
use proofmass_signal::sine::Frequency;
use proofmass_uncertainty::{Finding, Severity};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Phasors of all runs, in the order of the table, and what was noticed on the way.
pub(crate) struct Observed {
    pub runs: Vec<ObservedRun>,
    /// Table and recordings.
    pub inputs: Vec<Input>,
    pub findings: Vec<Finding>,
}

pub(crate) struct ObservedRun {
    /// Complex peak amplitudes, channel by channel.
    pub phasors: Vec<Complex64>,
    pub covariances: Vec<[f64; 3]>,
    /// What the samples say; `None` for a table of phasors.
    pub recorded: Option<Recorded>,
}

pub(crate) struct Recorded {
    pub phasors: Phasors,
    duration: f64,
    rate: f64,
    input: Input,
    findings: Vec<Finding>,
}

/// Takes the phasors of a table, or reads and approximates the recordings, run by run and on all cores.
///
/// `options` tells how recordings are read, and is asked only where there are some.
pub(crate) fn observe<S: Sync>(
    table: &RunTable<S>,
    settings: Option<&ShakerRecording>,
    options: impl FnOnce() -> proofmass_io::Result<WaveformOptions>,
    watch: &dyn Watch,
) -> Result<Observed> {
    let recording = if table.quantities.is_empty() {
        let options = options()?;
        settings.map(|s| (s, options))
    } else {
        None
    };
    let mut observed = Observed {
        runs: Vec::with_capacity(table.runs.len()),
        inputs: vec![table.input.clone()],
        findings: Vec::new(),
    };
    let done = AtomicU64::new(0);
    let all = table.runs.len() as u64;
    let runs = table
        .runs
        .par_iter()
        .map(|run| match (&run.data, &recording) {
            (RunData::Recording(name), Some((settings, options))) => {
                watch.step("recordings", done.load(Ordering::Relaxed), all)?;
                let recorded = approximate(table, run, name, settings, options)?;
                watch.step("recordings", done.fetch_add(1, Ordering::Relaxed) + 1, all)?;
                Ok(ObservedRun {
                    phasors: recorded.phasors.amplitudes.clone(),
                    covariances: recorded.phasors.covariances.clone(),
                    recorded: Some(recorded),
                })
            }
            (RunData::Phasors(phasors), _) => Ok(ObservedRun {
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
            }),
            (RunData::Recording(name), None) => Err(Trouble::data(format!(
                "{}: it is not said how recordings are read",
                table.source.resolve(name).display()
            ))
            .with_hint("add [recording] to campaign.toml")),
        })
        .collect::<Vec<Result<ObservedRun>>>();
    // Of several that fail the first in the table is named, whichever thread was first.
    observed.runs = runs.into_iter().collect::<Result<_>>()?;
    for (run, seen) in table.runs.iter().zip(&observed.runs) {
        if let Some(recorded) = &seen.recorded {
            observed.inputs.push(recorded.input.clone());
            for finding in &recorded.findings {
                observed.findings.push(
                    Finding::new(
                        finding.severity(),
                        finding.code(),
                        format!("run {}: {}", run.run, finding.what()),
                    )
                    .evidence(finding.evidence_text())
                    .advice(finding.advice_text()),
                );
            }
        }
    }
    observed.findings.extend(durations(table, &observed.runs));
    if let Some((
        ShakerRecording {
            full_scale_v: None, ..
        },
        _,
    )) = recording
    {
        observed.findings.push(
            Finding::new(
                Severity::Note,
                "clipping-unchecked",
                "the full scale of the recordings is not known, so clipped samples go unnoticed",
            )
            .evidence("[recording] has no full_scale_V")
            .advice("add full_scale_V = … to [recording]"),
        );
    }
    Ok(observed)
}

fn approximate<S>(
    table: &RunTable<S>,
    run: &ShakerRun<S>,
    name: &str,
    settings: &ShakerRecording,
    options: &WaveformOptions,
) -> Result<Recorded> {
    let path = table.source.resolve(name);
    let place = || format!("run {}, {}:{}", run.run, table.path.display(), run.line);
    let source = table.source.source(name);
    let waveform = source
        .and_then(|source| Waveform::from_source(source, options))
        .map_err(|e| Trouble::from(e).detail(place()))?;
    let reading = PhasorReading {
        frequency: match settings.frequency {
            DriveFrequency::Known => Frequency::Known,
            DriveFrequency::Common => Frequency::Common,
        },
        harmonics: settings.harmonics,
        drift: settings.drift,
        full_scale: settings.full_scale_v,
        ..PhasorReading::new(waveform.sampling_rate_hz)
    };
    let channels: Vec<&[f64]> = waveform.channels.iter().map(Vec::as_slice).collect();
    let phasors = reading.phasors(run.frequency_hz, &channels).map_err(|e| {
        Trouble::data(format!(
            "{}: no sine of {} Hz can be approximated: {e}",
            path.display(),
            run.frequency_hz
        ))
        .detail(place())
        .detail(format!(
            "{} samples at {} Hz, {:.4} s",
            waveform.samples(),
            waveform.sampling_rate_hz,
            waveform.duration_s()
        ))
        .with_hint("check the frequency in the table and the sampling rate; measure the run again, or take its row out")
    })?;
    if let Some(k) = phasors.amplitudes.iter().position(|a| a.norm() == 0.0) {
        return Err(Trouble::data(format!(
            "{}: channel {} carries no signal at all",
            path.display(),
            options.channels[k].0
        ))
        .detail(place())
        .with_hint("check its cable and the channels in [recording]; measure the run again, or take its row out"));
    }
    Ok(Recorded {
        phasors,
        duration: waveform.duration_s(),
        rate: waveform.sampling_rate_hz,
        input: waveform.input(),
        findings: waveform.findings,
    })
}

/// A recording that ended early still gives a phasor; it is named.
fn durations<S>(table: &RunTable<S>, runs: &[ObservedRun]) -> Vec<Finding> {
    let mut all: Vec<f64> = runs
        .iter()
        .filter_map(|r| r.recorded.as_ref().map(|r| r.duration))
        .collect();
    all.sort_by(f64::total_cmp);
    let Some(&median) = all.get(all.len() / 2) else {
        return Vec::new();
    };
    table
        .runs
        .iter()
        .zip(runs)
        .filter_map(|(run, seen)| {
            let recorded = seen.recorded.as_ref()?;
            (recorded.duration < 0.9 * median).then(|| {
                Finding::new(
                    Severity::Warning,
                    "short-recording",
                    format!("the recording of run {} is shorter than the others", run.run),
                )
                .evidence(format!(
                    "{:.4} s at {} Hz in {}, {median:.4} s in the middle of all runs",
                    recorded.duration, recorded.rate, recorded.input.path
                ))
                .advice("it may have been cut short; its phasors were used with the uncertainty they have")
            })
        })
        .collect()
}

impl ObservedRun {
    /// What the samples say about the run; `transverse` is the transverse motion, where it was measured.
    pub(crate) fn quality(&self, transverse: Option<f64>) -> Quality {
        match &self.recorded {
            Some(recorded) => recorded.phasors.quality(transverse),
            None => Quality {
                transverse,
                ..Quality::default()
            },
        }
    }
}

/// Names and digests for a report: hundreds of recordings stand in result.json, one by one.
pub(crate) fn listed(record: &Record, recordings: usize) -> Vec<(String, String)> {
    let mut list = record.digests();
    if recordings > 0 && recordings <= list.len() {
        list.truncate(list.len() - recordings);
        list.push((
            format!("{recordings} recordings"),
            "each in result.json".to_owned(),
        ));
    }
    list
}
