//! Recordings written in another format, several that continue each other as one.

mod devices;
mod outcome;
mod plan;

pub use devices::{Device, DeviceTable};
pub use outcome::ConvertOutcome;

use crate::destination::Destination;
use crate::outcome::Job;
use crate::recording::RecordingReading;
use crate::stored_result::doubts_of_inputs;
use crate::trouble::{Result, Trouble};
use plan::Plan;
use proofmass_core::Watch;
use proofmass_io::formats::write::{PARQUET, WavForm};
use proofmass_io::{
    Conversion, ConversionPlan, Input, RecordingOptions, Source, Survey, Surveyed, TargetForm,
    TimedRows, Written,
};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Formats that are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    /// Columns of Parquet with names and units, the time first (builds with the feature `parquet`)
    Parquet,
}

/// How a WAV file stores its samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum GapTreatment {
    /// Each missing sample is the number before the gap
    Hold,
    /// Missing samples are put in as NaN, empty fields or nulls (csv, npy, parquet)
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct ConvertJob {
    /// Format to be written [default: by the ending of the output: .csv, .npy, .wav, .uff, .parquet]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "FORMAT"))]
    pub to: Option<ConvertFormat>,
    /// How a WAV file stores its samples [default: float64]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "FORM"))]
    pub wav_form: Option<WavSamples>,
    /// What becomes of gaps; without it they stay in csv, npy and parquet, whose rows have times, and are refused for wav and uff
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
    devices: Option<&'a DeviceTable>,
    to: Mutex<Option<Destination<'a>>>,
}

impl<'a> ConvertData<'a> {
    /// What is written is written once: the data serve one evaluation.
    pub fn new(recordings: Vec<&'a Opening<'a>>, to: Destination<'a>) -> Self {
        Self {
            recordings,
            devices: None,
            to: Mutex::new(Some(to)),
        }
    }

    /// Each recording is of one device: they become one table with columns of serial number and batch, each recording with its own clock.
    /// They are those of the table, in its order.
    #[must_use]
    pub fn with_devices(self, devices: &'a DeviceTable) -> Self {
        Self {
            devices: Some(devices),
            ..self
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
            Some("parquet" | "pq") => Some(ConvertFormat::Parquet),
            _ => None,
        };
        let Some(format) = self.to.or(by_ending) else {
            let name = file.map_or_else(String::new, |f| format!(": {}", f.display()));
            return Err(Trouble::request(format!(
                "the file extension of the output does not tell its format{name}"
            ))
            .with_hint("add --to csv, npy, wav, uff or parquet, or use one of these as the extension, such as .csv"));
        };
        if self.wav_form.is_some() && format != ConvertFormat::Wav {
            return Err(Trouble::request("--wav-form is about WAV files alone")
                .with_hint("leave it out, or add --to wav"));
        }
        if format == ConvertFormat::Parquet && !PARQUET {
            return Err(Trouble::request("this build does not write Parquet")
                .with_hint("build it from the source with the feature parquet, or write csv"));
        }
        Ok(match format {
            ConvertFormat::Csv => TargetForm::Csv,
            ConvertFormat::Npy => TargetForm::Npy,
            ConvertFormat::Uff => TargetForm::Uff,
            ConvertFormat::Parquet => TargetForm::Parquet,
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
        let recordings = data.recordings.len();
        let alone: Vec<Range<usize>> = match data.devices {
            Some(devices) => data.check(devices, form)?,
            None => std::iter::once(0..recordings).collect(),
        };
        let passes = Passes {
            recordings: &data.recordings,
            options: self
                .reading
                .reading_of(self.reading.columns.clone().unwrap_or_default())?,
            watch,
        };
        let mut surveys: Vec<(Surveyed, Vec<Seen<'_>>)> = Vec::new();
        for recordings in &alone {
            let mut survey = Survey::new(form);
            let seen = passes.survey(&mut survey, recordings.clone())?;
            let surveyed = survey.finish()?;
            if let Some((first, of)) = surveys.first() {
                let behind = surveyed.stands_behind(first, Path::new(&of[0].input.path));
                behind.map_err(|e| e.at(Path::new(&seen[0].input.path)))?;
            }
            let seen = with_rate(seen, &surveyed);
            surveys.push((surveyed, seen));
        }
        let mut plans = Vec::new();
        for (i, (surveyed, seen)) in surveys.iter().enumerate() {
            let device = data.devices.and_then(|table| table.devices.get(i));
            plans.push(Plan::of(self, form, surveyed, seen, device)?);
        }
        let Some((first, (surveyed, _))) = plans.first().zip(surveys.first()) else {
            return Err(Trouble::data("no recording was named"));
        };
        let written = match &to {
            Destination::File { path, inputs, .. } => Written::create(path, inputs)?,
            Destination::Bytes(_) => Written::Bytes(Vec::new()),
        };
        let mut conversion = Conversion::begin(written, &first.writing, surveyed)?;
        for (i, (plan, (surveyed, seen))) in plans.iter().zip(&surveys).enumerate() {
            if i > 0 {
                conversion.next_recording(&plan.writing, surveyed)?;
            }
            passes.write(&mut conversion, &plan.writing, alone[i].start, seen)?;
        }
        let mut written = conversion.end()?;
        let sha256 = written.is_kept().then(|| written.sha256());
        let mut inputs: Vec<Input> = data.devices.iter().map(|d| d.input.clone()).collect();
        let mut findings = Vec::new();
        for (surveyed, seen) in surveys {
            let of_seen = seen.iter().flat_map(|s| s.findings.clone());
            let all = surveyed.findings.into_iter().chain(of_seen);
            findings.extend(all.map(|finding| match &data.devices {
                Some(_) => finding.of_part(&seen[0].input.path),
                None => finding,
            }));
            inputs.extend(seen.into_iter().map(|s| s.input));
        }
        findings.extend(doubts_of_inputs(&inputs));
        match to {
            Destination::File { beside, .. } => {
                written.settle()?;
                if let Some(sha256) = &sha256 {
                    beside(&inputs, sha256, &[])?;
                }
                written.commit()?;
            }
            Destination::Bytes(bytes) => *bytes = written.into_bytes().unwrap_or_default(),
        }
        Ok(ConvertOutcome::new(form, plans, inputs, sha256, findings))
    }
}

impl ConvertData<'_> {
    /// Each recording by itself.
    fn check(&self, devices: &DeviceTable, form: TargetForm) -> Result<Vec<Range<usize>>> {
        if form != TargetForm::Parquet {
            let what = format!("{} has no place for serial numbers", form.name());
            return Err(Trouble::request(what).with_hint("write Parquet: --to parquet"));
        }
        if self.recordings.len() != devices.devices.len() {
            return Err(Trouble::request(
                "the recordings are not those of the table of devices",
            ));
        }
        Ok((0..self.recordings.len()).map(|i| i..i + 1).collect())
    }
}

/// A recording that was surveyed.
struct Seen<'a> {
    open: &'a Opening<'a>,
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

impl<'a> Passes<'a> {
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

    fn survey(&self, survey: &mut Survey, recordings: Range<usize>) -> Result<Vec<Seen<'a>>> {
        let mut seen = Vec::new();
        let (mut window, mut rows) = (None, 0);
        for number in recordings {
            let open = &self.recordings[number];
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
                open,
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

    /// Recordings that continue each other, of all the first one is `first`.
    fn write(
        &self,
        conversion: &mut Conversion<'_>,
        plan: &ConversionPlan,
        first: usize,
        seen: &[Seen<'_>],
    ) -> Result<()> {
        let parts = plan.parts();
        for (pass, part) in parts.iter().enumerate() {
            conversion.begin_pass(part)?;
            self.write_part(conversion, part, plan.is_timed(), seen, |number| {
                let before = first + pass * seen.len() + number;
                (before, parts.len() * self.recordings.len())
            })?;
            conversion.end_pass()?;
        }
        Ok(())
    }

    fn write_part(
        &self,
        conversion: &mut Conversion<'_>,
        part: &Range<usize>,
        timed: bool,
        seen: &[Seen<'_>],
        place: impl Fn(usize) -> (usize, usize),
    ) -> Result<()> {
        let mut window = None;
        for (number, seen) in seen.iter().enumerate() {
            let ((before, of), part) = (place(number), Some(part.clone()));
            let mut reader = TimedRows::open((seen.open)()?, &self.options, part, timed, window)?;
            while let Some(block) = reader.next_block()? {
                conversion.block(&block)?;
                self.tell("conversion", before, of, reader.progress())?;
            }
            self.tell("conversion", before + 1, of, (0, 0))?;
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
fn named(seen: &[Seen<'_>]) -> String {
    match seen {
        [one] => one.input.path.clone(),
        [first, .., last] => format!("{} to {}", first.input.path, last.input.path),
        [] => "the recording".to_owned(),
    }
}

/// How the rows were read, with the rate that was found.
fn with_rate<'a>(mut seen: Vec<Seen<'a>>, surveyed: &Surveyed) -> Vec<Seen<'a>> {
    for recording in &mut seen {
        if let Some(reading) = &mut recording.input.reading {
            reading.time.rate_hz = surveyed.rate_hz();
        }
    }
    seen
}
