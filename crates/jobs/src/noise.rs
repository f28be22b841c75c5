//! Noise and stability of a sensor at rest.

mod blocks;
mod outcome;
mod page;
mod reading;
mod stream;

pub use blocks::{NoiseBlock, NoiseBlocks};
pub use outcome::NoiseOutcome;
pub(crate) use outcome::{noise_of, read_noise};
pub use reading::{NoiseReading, NoiseRecording};
pub use stream::NoiseStream;

use crate::outcome::Job;
use crate::trouble::{Result, Trouble};
use proofmass_core::{Error, Watch};
use proofmass_documents::ImuYaml;
use proofmass_noise::{
    AnalysisOptions, ChannelName, Gaps, LongRecord, NoiseChannel, analyse_beside_temperature,
};
use proofmass_signal::{Trace, clock};
use proofmass_uncertainty::findings::gaps_in_record;
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};
use std::sync::Mutex;

/// What is asked of a recording of a sensor at rest.
///
/// ```
/// use proofmass_jobs::noise::{NoiseData, NoiseJob};
/// use proofmass_jobs::{Job, Outcome, Unwatched};
/// use proofmass_noise::{NoiseChannel, NoiseModel, Sensor, simulate};
/// use rand::SeedableRng;
///
/// let truth = NoiseModel { white: 2.5e-3, ..Default::default() };
/// let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(7);
/// let rate = simulate(&truth, 20_000, 50.0, &mut rng)?;
/// let channel = NoiseChannel { name: "x", sensor: Some(Sensor::Accelerometer), unit: "m/s²", rate: &rate };
/// let outcome = NoiseJob::default().evaluate(&NoiseData::samples(vec![channel], 50.0), &Unwatched)?;
/// let white = outcome.quantities().into_iter().find(|q| q.name == "x.N").unwrap();
/// assert!((white.value - 2.5e-3).abs() < 2.0 * white.expanded);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct NoiseJob {
    /// Statistics, averaging times, terms, band, gaps, rates of false alarms.
    pub options: AnalysisOptions,
    /// Topic written into imu.yaml.
    pub rostopic: String,
    /// The channels are clocks, from their phases: two to be separated were measured against a third.
    pub clocks: bool,
}

/// What to do where a recording has gaps and they are refused.
const GAPS_REFUSED: &str =
    "leave --refuse-gaps out: no statistic uses samples from both sides of a gap";

impl Default for NoiseJob {
    fn default() -> Self {
        Self {
            options: AnalysisOptions::default(),
            rostopic: "/imu0".to_owned(),
            clocks: false,
        }
    }
}

impl NoiseJob {
    /// A request with these options.
    pub fn new(options: AnalysisOptions) -> Self {
        Self {
            options,
            ..Self::default()
        }
    }
}

/// A recording of a sensor at rest.
#[non_exhaustive]
pub struct NoiseData<'a> {
    /// The samples, or where they come from.
    pub samples: NoiseSamples<'a>,
    /// What reading the data found.
    pub findings: &'a [Finding],
    /// What the data are called in messages.
    pub name: &'a str,
}

/// Samples in memory, or blocks of them that are seen once.
#[non_exhaustive]
pub enum NoiseSamples<'a> {
    /// Channels of equal length; NaN marks a missing value.
    Slices {
        /// The channels.
        channels: Vec<NoiseChannel<'a>>,
        /// Temperature of every row, K or °C.
        temperature: Option<&'a [f64]>,
        /// Time of every row in s, compared with the line of an even clock.
        stamps: Option<&'a [f64]>,
        /// Samples per second; that of the stamps when `None`.
        rate: Option<f64>,
    },
    /// A recording larger than memory.
    Stream {
        /// What its columns are.
        channels: Vec<ChannelName>,
        /// Gives the blocks, one after the other; a job that is evaluated again finds it at its end.
        blocks: Mutex<&'a mut (dyn NoiseBlocks + Send)>,
    },
}

impl<'a> NoiseData<'a> {
    /// Channels at an even rate in Hz.
    pub fn samples(channels: Vec<NoiseChannel<'a>>, rate: f64) -> Self {
        Self {
            samples: NoiseSamples::Slices {
                channels,
                temperature: None,
                stamps: None,
                rate: Some(rate),
            },
            findings: &[],
            name: "the recording",
        }
    }

    /// Blocks that are seen once.
    pub fn stream(channels: Vec<ChannelName>, blocks: &'a mut (dyn NoiseBlocks + Send)) -> Self {
        Self {
            samples: NoiseSamples::Stream {
                channels,
                blocks: Mutex::new(blocks),
            },
            findings: &[],
            name: "the recording",
        }
    }
}

impl Job for NoiseJob {
    type Data<'a> = NoiseData<'a>;
    type Outcome = NoiseOutcome;

    fn evaluate(&self, data: &NoiseData<'_>, watch: &dyn Watch) -> Result<NoiseOutcome> {
        if !ImuYaml::is_topic(&self.rostopic) {
            return Err(
                Trouble::request(format!("{:?} is the name of no topic", self.rostopic))
                    .with_hint("letters, digits and / ~ _ - . are allowed, such as /imu0"),
            );
        }
        match &data.samples {
            NoiseSamples::Slices {
                channels,
                temperature,
                stamps,
                rate,
            } => self.in_memory(data, channels, *temperature, *stamps, *rate, watch),
            NoiseSamples::Stream { channels, blocks } => {
                let mut blocks = blocks
                    .lock()
                    .map_err(|_| Trouble::data("the blocks of the recording were lost"))?;
                self.streamed(data, channels, &mut **blocks, watch)
            }
        }
    }
}

impl NoiseJob {
    fn in_memory(
        &self,
        data: &NoiseData<'_>,
        channels: &[NoiseChannel<'_>],
        temperature: Option<&[f64]>,
        stamps: Option<&[f64]>,
        rate: Option<f64>,
        watch: &dyn Watch,
    ) -> Result<NoiseOutcome> {
        let rate = match (rate, stamps) {
            (Some(rate), _) => rate,
            (None, Some(stamps)) => {
                let finite: Vec<f64> = stamps.iter().copied().filter(|t| t.is_finite()).collect();
                let (clock, _) =
                    clock::read(&finite, None).map_err(|e| self.explain(e, data.name))?;
                clock.rate_hz
            }
            (None, None) => {
                return Err(Trouble::request(format!(
                    "neither time stamps nor a sampling rate of {} are known",
                    data.name
                ))
                .with_hint(
                    "give the rate in hertz (--rate HZ), or a time column (--time COLUMN)",
                ));
            }
        };
        if self.options.separate {
            self.separable(channels)?;
        }
        let analysis =
            analyse_beside_temperature(channels, temperature, stamps, rate, &self.options, watch)
                .map_err(|e| self.explain(e, data.name))?;
        let steady: Vec<f64> = match stamps {
            Some(stamps) => stamps.to_vec(),
            None => (0..channels.first().map_or(0, |c| c.rate.len()))
                .map(|i| i as f64 / rate)
                .collect(),
        };
        let course = |values: &[f64]| {
            let rows = analysis.rows.0..analysis.rows.1.min(values.len());
            trace(&steady[rows.clone()], &values[rows])
        };
        let traces = channels.iter().map(|c| course(c.rate)).collect();
        let temperature = temperature.map(course);
        let sensors = channels.iter().map(|c| c.sensor).collect();
        Ok(NoiseOutcome::new(self, data, analysis, sensors, traces).with_temperature(temperature))
    }

    /// Refuses channels whose differences say nothing of each by itself.
    fn separable(&self, channels: &[NoiseChannel<'_>]) -> Result<()> {
        if channels.len() == 2 && !self.clocks {
            return Err(Trouble::request(format!(
                "two channels, {} and {}, cannot be separated: their difference does not say which of them is the noisier",
                channels[0].name, channels[1].name
            ))
            .with_hint("three channels side by side are needed; two suffice only of clocks measured against a third (phases, --phase)"));
        }
        for (k, b) in channels.iter().enumerate() {
            for a in &channels[..k] {
                if a.unit != b.unit {
                    return Err(Trouble::request(format!(
                        "channels of different units cannot be separated: {} is in {}, {} in {}",
                        a.name, a.unit, b.name, b.unit
                    ))
                    .with_hint("choose three of the same unit with --columns"));
                }
                if constant_difference(a.rate, b.rate) {
                    return Err(Trouble::data(format!(
                        "{} and {} cannot be separated: their difference never changes",
                        a.name, b.name
                    ))
                    .with_hint("the same column is given twice, or two channels stand still: choose others with --columns"));
                }
            }
        }
        Ok(())
    }

    fn streamed(
        &self,
        data: &NoiseData<'_>,
        channels: &[ChannelName],
        blocks: &mut dyn NoiseBlocks,
        watch: &dyn Watch,
    ) -> Result<NoiseOutcome> {
        if self.options.separate {
            return Err(Trouble::request(
                "channels of a recording that is read as a stream cannot be separated",
            )
            .with_hint("give a shorter recording: a separation needs all samples in memory"));
        }
        let mut record = LongRecord::new(channels.to_vec());
        while let Some(block) = blocks.next_block()? {
            if block.behind_gap {
                record.gap();
            }
            let slices: Vec<&[f64]> = block.columns.iter().map(Vec::as_slice).collect();
            record
                .push(&slices)
                .map_err(|e| self.explain(e, data.name))?;
            let (done, of) = blocks.progress();
            watch.step("reading the recording", done, of)?;
        }
        let gaps = blocks.gaps();
        if self.options.gaps == Gaps::Refuse && gaps > 0 {
            return Err(Trouble::data(format!(
                "the recording has {gaps} gaps in time, and gaps are refused"
            ))
            .detail(data.name)
            .with_hint(GAPS_REFUSED));
        }
        let rate = blocks.rate().ok_or_else(|| {
            Trouble::request(format!(
                "the sampling rate of {} is not known, or its clock stands still",
                data.name
            ))
            .with_hint("give the rate in hertz (--rate HZ), or a time column whose times advance")
        })?;
        let mut analysis = record
            .analyse(rate, &self.options)
            .map_err(|e| self.explain(e, data.name))?;
        if gaps > 0 {
            analysis.findings.retain(|f| f.code() != "gaps-in-record");
            analysis.findings.push(
                gaps_in_record(
                    ": no statistic reaches across a gap",
                    &format!("{gaps} gaps; all {} rows used", record.samples()),
                    "averaging times longer than the segments between gaps are lost",
                )
                .at(Severity::Note),
            );
        }
        let step = analysis.averaged as f64 / rate;
        let traces = (0..channels.len())
            .map(|c| {
                let averages = record.averages(c);
                let time: Vec<f64> = (0..averages.len()).map(|i| i as f64 * step).collect();
                trace(&time, averages)
            })
            .collect();
        Ok(NoiseOutcome::new(
            self,
            data,
            analysis,
            channels.iter().map(|c| c.sensor).collect(),
            traces,
        ))
    }

    /// A refusal of the analysis with its remedy.
    fn explain(&self, error: Error, name: &str) -> Trouble {
        let hint = match error {
            Error::Cancelled { .. } => return Trouble::from(error),
            Error::TooFew { .. } => {
                "record longer or read more of it with --between FROM TO (coefficients need thousands of samples, a curve at least ten), or choose a shorter --segment"
            }
            Error::OutOfRange {
                name: "statistics or averaging times beyond the octaves of OADEV",
                ..
            } => {
                return Trouble::request(
                    "a recording that is read as a stream has OADEV at octave averaging times alone",
                )
                .detail(name)
                .with_hint("leave --statistic and --taus out, or read it into memory, without --stream");
            }
            Error::OutOfRange {
                name: "highest frequency in Hz",
                ..
            } => {
                "give --highest-frequency above a hundred cycles of the record, and at most half the sampling rate"
            }
            Error::OutOfRange {
                name: "probability",
                ..
            } => "give a probability between zero and one, such as 0.95",
            Error::Length {
                name: "channels to be separated",
                ..
            } => "three channels side by side are needed: choose them with --columns",
            Error::OutOfRange {
                name: "range of a temperature that never changes, K",
                ..
            } => "leave --temperature out: a constant temperature explains nothing",
            Error::OutOfRange { name: "tau", .. } => {
                "an averaging time is a whole number of sample intervals, at most a half or a third of the record by statistic"
            }
            _ if self.options.gaps == Gaps::Refuse => GAPS_REFUSED,
            _ => "see `proofmass inspect` for what the file holds",
        };
        Trouble::from(error).detail(name).with_hint(hint)
    }
}

/// Whether two channels have one and the same difference wherever both have a value.
fn constant_difference(a: &[f64], b: &[f64]) -> bool {
    let mut differences = a.iter().zip(b).map(|(a, b)| a - b).filter(|d| !d.is_nan());
    match differences.next() {
        Some(first) => differences.all(|d| d == first),
        None => false,
    }
}

/// What is drawn against time, without the rows that are missing.
fn trace(time: &[f64], values: &[f64]) -> Trace {
    let start = time.first().copied().unwrap_or(0.0);
    let (x, y): (Vec<f64>, Vec<f64>) = time
        .iter()
        .zip(values)
        .filter(|(t, v)| t.is_finite() && v.is_finite())
        .map(|(t, v)| (t - start, *v))
        .unzip();
    Trace::new(&x, &y, Trace::RUNS)
}
