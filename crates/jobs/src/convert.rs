//! Recordings written in another format, several that continue each other as one.

mod outcome;
mod plan;

pub use outcome::ConvertOutcome;

use crate::destination::Destination;
use crate::outcome::Job;
use crate::recording::RecordingReading;
use crate::trouble::{Result, Trouble};
use plan::Plan;
use proofmass_core::Watch;
use proofmass_io::formats::write::WavForm;
use proofmass_io::{
    Conversion, Input, RecordingOptions, Source, Survey, Surveyed, TargetForm, TimedRows, Written,
};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Formats that are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum ConvertFormat {
    /// Text with headings and units, the time in the first column
    Csv,
    /// Array of numpy, the time in the first column; no names, no units
    Npy,
    /// Samples of one steady rate in whole hertz; no names, no units
    Wav,
    /// Universal file of modal analysis: one steady rate, a data set for each signal
    Uff,
}

/// How a WAV file stores its samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum WavSamples {
    /// Whole numbers of 16 bits
    Int16,
    /// Whole numbers of 24 bits
    Int24,
    /// Whole numbers of 32 bits
    Int32,
    /// Single precision: numbers are rounded
    Float32,
    /// Double precision: every number as it is
    #[default]
    Float64,
}

/// What becomes of places where samples are missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum GapTreatment {
    /// Each missing sample is the number before the gap
    Hold,
    /// Missing samples are put in as NaN, or as empty fields (csv, npy)
    Nan,
    /// What follows a gap comes at once, and the time in between is lost (wav, uff)
    Close,
}

/// Recordings to be written in another format.
///
/// ```
/// use proofmass_io::Source;
/// use proofmass_jobs::convert::{ConvertData, ConvertFormat, ConvertJob};
/// use proofmass_jobs::{Destination, Job, Unwatched};
///
/// let mut job = ConvertJob::default();
/// job.to = Some(ConvertFormat::Csv);
/// let mut written = Vec::new();
/// let text = "t (ms);a (g);label\n0;1,5;still\n10;-2;moved\n";
/// let recording = || Source::from_bytes("raw.csv", text);
/// let data = ConvertData::new(vec![&recording], Destination::Bytes(&mut written));
/// let outcome = job.evaluate(&data, &Unwatched)?;
/// assert_eq!(outcome.lost(), ["columns without numbers: label"]);
/// drop(data);
/// assert_eq!(String::from_utf8(written)?, "time_s,a_g\n0,1.5\n0.01,-2\n");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[serde(default)]
#[non_exhaustive]
pub struct ConvertJob {
    /// Format to be written [default: by the ending of the output: .csv, .npy, .wav, .uff]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "FORMAT"))]
    pub to: Option<ConvertFormat>,
    /// How a WAV file stores its samples [default: float64]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "FORM"))]
    pub wav_form: Option<WavSamples>,
    /// What becomes of gaps; without it they stay in csv and npy, whose rows have times, and are refused for wav and uff
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "HOW"))]
    pub gaps: Option<GapTreatment>,
    /// Write numbers whose units are known into a format that has no place for units (npy, wav)
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[cfg_attr(feature = "clap", arg(long))]
    pub without_units: bool,
    /// How the recordings are read; every column of numbers where none is named.
    #[serde(flatten)]
    #[cfg_attr(feature = "clap", command(flatten))]
    pub reading: RecordingReading,
}

/// Opens a recording, each time from its beginning.
pub type Opening<'a> = dyn Fn() -> proofmass_io::Result<Source> + Send + Sync + 'a;

/// Recordings, which are read more than once, and where they go.
pub struct ConvertData<'a> {
    recordings: Vec<&'a Opening<'a>>,
    to: Mutex<Option<Destination<'a>>>,
}

impl<'a> ConvertData<'a> {
    /// What is written is written once: the data serve one evaluation.
    pub fn new(recordings: Vec<&'a Opening<'a>>, to: Destination<'a>) -> Self {
        Self {
            recordings,
            to: Mutex::new(Some(to)),
        }
    }
}

impl ConvertJob {
    /// The format, as asked for or by the ending of a name.
    ///
    /// # Errors
    /// Neither tells it, or a form of WAV samples is asked for in another format.
    pub fn target(&self, file: Option<&Path>) -> Result<TargetForm> {
        let ending = file.and_then(Path::extension).and_then(|e| e.to_str());
        let by_ending = match ending.map(str::to_ascii_lowercase).as_deref() {
            Some("csv") => Some(ConvertFormat::Csv),
            Some("npy") => Some(ConvertFormat::Npy),
            Some("wav") => Some(ConvertFormat::Wav),
            Some("uff" | "unv") => Some(ConvertFormat::Uff),
            _ => None,
        };
        let Some(format) = self.to.or(by_ending) else {
            let name = file.map_or_else(String::new, |f| format!(": {}", f.display()));
            return Err(Trouble::request(format!(
                "the ending of the output does not tell its format{name}"
            ))
            .with_hint("say --to csv, npy, wav or uff, or end its name so"));
        };
        if self.wav_form.is_some() && format != ConvertFormat::Wav {
            return Err(Trouble::request("--wav-form is about WAV files alone")
                .with_hint("leave it away, or add --to wav"));
        }
        Ok(match format {
            ConvertFormat::Csv => TargetForm::Csv,
            ConvertFormat::Npy => TargetForm::Npy,
            ConvertFormat::Uff => TargetForm::Uff,
            ConvertFormat::Wav => TargetForm::Wav(match self.wav_form.unwrap_or_default() {
                WavSamples::Int16 => WavForm::Int16,
                WavSamples::Int24 => WavForm::Int24,
                WavSamples::Int32 => WavForm::Int32,
                WavSamples::Float32 => WavForm::Float32,
                WavSamples::Float64 => WavForm::Float64,
            }),
        })
    }
}

impl Job for ConvertJob {
    type Data<'a> = ConvertData<'a>;
    type Outcome = ConvertOutcome;

    fn evaluate(&self, data: &ConvertData<'_>, watch: &dyn Watch) -> Result<ConvertOutcome> {
        let to = data.to.lock().ok().and_then(|mut to| to.take());
        let to = to.ok_or_else(|| Trouble::data("the recordings were written already"))?;
        let form = self.target(match &to {
            Destination::File { path, .. } => Some(path),
            Destination::Bytes(_) => None,
        })?;
        let passes = Passes {
            recordings: &data.recordings,
            options: self
                .reading
                .reading_of(self.reading.columns.clone().unwrap_or_default())?,
            watch,
        };
        let mut survey = Survey::new(form);
        let seen = passes.survey(&mut survey)?;
        let surveyed = survey.finish()?;
        let seen = with_rate(seen, &surveyed);
        let names: Vec<String> = seen.iter().map(|s| s.input.path.clone()).collect();
        let plan = Plan::of(self, form, &surveyed, &names, &seen)?;
        let written = match &to {
            Destination::File { path, inputs, .. } => Written::create(path, inputs)?,
            Destination::Bytes(_) => Written::Bytes(Vec::new()),
        };
        let mut conversion = Conversion::begin(written, &plan.writing, &surveyed)?;
        let parts = plan.writing.parts();
        for (pass, part) in parts.iter().enumerate() {
            conversion.begin_pass(part)?;
            let pass = (pass, parts.len());
            passes.write(&mut conversion, part, plan.writing.is_timed(), &seen, pass)?;
            conversion.end_pass()?;
        }
        let mut written = conversion.into_written();
        let sha256 = written.is_kept().then(|| written.sha256());
        let (mut findings, mut inputs) = (surveyed.findings.clone(), Vec::new());
        for recording in seen {
            findings.extend(recording.findings);
            inputs.push(recording.input);
        }
        match to {
            Destination::File { beside, .. } => {
                written.settle()?;
                if let Some(sha256) = &sha256 {
                    beside(&inputs, sha256)?;
                }
                written.commit()?;
            }
            Destination::Bytes(bytes) => *bytes = written.into_bytes().unwrap_or_default(),
        }
        Ok(ConvertOutcome::new(form, plan, inputs, sha256, findings))
    }
}

/// A recording that was surveyed.
struct Seen {
    input: Input,
    findings: Vec<Finding>,
    /// Word for its format, where it is no text.
    format: Option<String>,
}

/// Parts of a file that its progress is told in.
const PARTS: u64 = 1000;

/// What goes over the recordings.
struct Passes<'a> {
    recordings: &'a [&'a Opening<'a>],
    options: RecordingOptions,
    watch: &'a dyn Watch,
}

impl Passes<'_> {
    /// Tells how far a stage is: so many files of all are behind, and of the next one so many bytes of all.
    fn tell(
        &self,
        stage: &'static str,
        files: usize,
        of: usize,
        (done, size): (u64, u64),
    ) -> Result<()> {
        let part = (PARTS * done).checked_div(size).unwrap_or(0).min(PARTS);
        let done = PARTS * files as u64 + part;
        Ok(self.watch.step(stage, done, PARTS * of as u64)?)
    }

    fn survey(&self, survey: &mut Survey) -> Result<Vec<Seen>> {
        let mut seen = Vec::new();
        let (mut window, mut rows) = (None, 0);
        for (number, open) in self.recordings.iter().enumerate() {
            let mut reader = TimedRows::open(open()?, &self.options, None, true, window)?;
            let file: PathBuf = reader.name().to_path_buf();
            let layout = reader.layout().clone();
            survey.begin(&file, &layout)?;
            while let Some(block) = reader.next_block()? {
                survey.block(&file, &block)?;
                rows += block.rows();
                self.tell("survey", number, self.recordings.len(), reader.progress())?;
            }
            self.tell("survey", number + 1, self.recordings.len(), (0, 0))?;
            let (input, findings, next) = reader.finish()?;
            window = next;
            seen.push(Seen {
                format: layout.reading.stream.as_ref().map(|s| s.format.clone()),
                input: input.with_reading(layout.reading),
                findings,
            });
        }
        match (rows, window) {
            (0, Some(window)) => Err(Trouble::data(window.nothing())
                .with_hint("give another --between FROM TO; `proofmass inspect` shows the times")),
            (0, None) => Err(Trouble::data("no recording with rows was named")),
            _ => Ok(seen),
        }
    }

    fn write(
        &self,
        conversion: &mut Conversion<'_>,
        part: &Range<usize>,
        timed: bool,
        seen: &[Seen],
        (pass, passes): (usize, usize),
    ) -> Result<()> {
        let mut window = None;
        let (before, of) = (pass * seen.len(), passes * seen.len());
        for (number, (open, seen)) in self.recordings.iter().zip(seen).enumerate() {
            let part = Some(part.clone());
            let mut reader = TimedRows::open(open()?, &self.options, part, timed, window)?;
            while let Some(block) = reader.next_block()? {
                conversion.block(&block)?;
                self.tell("conversion", before + number, of, reader.progress())?;
            }
            self.tell("conversion", before + number + 1, of, (0, 0))?;
            let (input, _, next) = reader.finish()?;
            window = next;
            if input.sha256 != seen.input.sha256 {
                return Err(
                    Trouble::data("the recording became another while it was read")
                        .detail(input.path)
                        .with_hint("wait until it is complete, then run again"),
                );
            }
        }
        Ok(())
    }
}

/// The recordings, for messages.
fn named(names: &[String]) -> String {
    match names {
        [one] => one.clone(),
        [first, .., last] => format!("{first} to {last}"),
        [] => "the recording".to_owned(),
    }
}

/// How the rows were read, with the rate that was found.
fn with_rate(mut seen: Vec<Seen>, surveyed: &Surveyed) -> Vec<Seen> {
    for recording in &mut seen {
        if let Some(reading) = &mut recording.input.reading {
            reading.time.rate_hz = surveyed.rate_hz();
        }
    }
    seen
}
