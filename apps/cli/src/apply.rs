//! `proofmass apply`: compensated recording, streamed.

use crate::console::Progress;
use crate::{Failure, Outcome, console};
use proofmass::dynamic::frequency_response::{Beyond, FilterDesign};
use proofmass::dynamic::model::ModelStructure;
use proofmass::io::{AtomicFile, ColumnRef, Input, Provenance, SigningKey, Source};
use proofmass::jobs::apply::{
    ApplyData, ApplyJob, ApplyOutcome, CompensationMethod, Destination, OutOfRange,
};
use proofmass::jobs::deconvolution::{DeconvolutionJob, FittedModel};
use proofmass::jobs::{
    Job, Outcome as _, Record, RecordingReading, StoredResult, frequency_response,
};
use std::path::{Path, PathBuf};

/// Compensate a recording with a calibration.
///
/// a = K⁻¹ (output − b), row by row: a recording of any size needs no more memory than a small one. All other columns
/// are kept as they are. The same function runs in firmware. A calibration over frequency (from a shaker, or the table
/// of a laboratory) is used through the constant matrix of a band, or through a filter; both state their error.
#[derive(clap::Args)]
pub(crate) struct Apply {
    /// calibration.json of `proofmass calibrate`, or a laboratory's table (.csv) over frequency
    calibration: PathBuf,
    /// Recording with uncompensated outputs; `-` is standard input
    recording: PathBuf,
    /// File for the compensated recording (CSV), replaced if it is there; `-` is standard output
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Calibration over frequency: the constant real matrix of this band in hertz
    #[arg(long, value_name = "LOW,HIGH", value_parser = band)]
    band: Option<Band>,
    /// Calibration over frequency: an inverse filter over the whole range (or over --band)
    ///
    /// Samples at either end of the recording, for which the filter needs others before or after, are left out.
    #[arg(long)]
    filter: bool,
    /// Below and above the calibrated frequencies, take the sensitivity of the nearest one instead of filtering them out
    #[arg(long, requires = "filter")]
    hold: bool,
    /// Coverage factor of the expanded uncertainties (U_…) in the table of a laboratory
    #[arg(
        short = 'k',
        long = "coverage-factor",
        alias = "coverage",
        value_name = "K",
        value_parser = crate::number_arguments::coverage_factor
    )]
    coverage: Option<f64>,
    /// Column of the temperature in °C, for a calibration over temperature
    #[arg(long, value_name = "COLUMN")]
    temperature: Option<String>,
    /// Refuse a recording with samples beyond the range in which the calibration was tested, instead of reporting them
    #[arg(long)]
    within_range: bool,
    /// Acceleration behind one channel (--columns) by the inverse of a fitted model, each sample with its uncertainty
    ///
    /// The calibration is then the result.json of a test with a model, or a calibration over frequency that --model is
    /// fitted to.
    #[arg(long, requires = "columns", conflicts_with_all = ["band", "filter", "temperature", "within_range"])]
    dynamic: bool,
    #[command(flatten)]
    turning: Turning,
    /// Replace a file that `proofmass apply` did not write or that was changed since
    #[arg(long)]
    force: bool,
    /// Sign where the file came from with a private key (PEM, Ed25519), as `proofmass keygen` makes it
    #[arg(long, value_name = "KEY")]
    sign: Option<PathBuf>,
    #[command(flatten)]
    reading: RecordingReading,
}

/// Says how a recording was read.
fn read(input: &Input) {
    console::doubt(input);
    if let Some(reading) = &input.reading {
        console::note(format!("read: {}", reading.line(&input.path)));
    }
}

/// How --dynamic works.
#[derive(clap::Args)]
struct Turning {
    /// Model to fit to a calibration over frequency: 1mode … 4modes, delay, low-pass=ORDER, joined by + [default: 1mode]
    #[arg(long, value_name = "ELEMENTS", requires = "dynamic")]
    model: Option<ModelStructure>,
    /// Corner of the low-pass in hertz [default: where noise and bias together are least]
    #[arg(long, value_name = "HZ", requires = "dynamic", value_parser = crate::number_arguments::positive)]
    corner: Option<f64>,
    /// Seconds at the beginning in which nothing happens [default: up to the pulse]
    #[arg(long, value_name = "SECONDS", requires = "dynamic", value_parser = crate::number_arguments::not_negative)]
    quiet: Option<f64>,
}

/// Two frequencies.
#[derive(Clone, Copy, Debug)]
struct Band([f64; 2]);

fn band(text: &str) -> Result<Band, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    let numbers = numbers.and_then(|n| <[f64; 2]>::try_from(n).ok());
    numbers
        .map(Band)
        .ok_or_else(|| format!("{text:?} is no band: write LOW,HIGH in hertz"))
}

impl Apply {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let replaced = self.may_replace()?;
        let signer = self.sign.as_deref().map(SigningKey::read).transpose()?;
        let replaced_key = Provenance::of(&self.output)
            .ok()
            .flatten()
            .and_then(|p| Some(p.signature?.key));
        let key = signer.as_ref().map(|s| s.public().to_string());
        if let Some(old) = replaced_key.filter(|old| key.as_ref() != Some(old)) {
            console::unsigned(&self.output.display().to_string(), &old, key.is_some());
        }
        if self.dynamic {
            return self.turn_back(replaced, signer.as_ref());
        }
        let source = Source::open(&self.calibration)?;
        let (calibration, calibration_input, findings) =
            frequency_response::read_calibration(source, self.coverage)?;
        console::doubt(&calibration_input);
        findings.iter().for_each(console::finding);
        let inputs = [self.recording.as_path(), self.calibration.as_path()];
        // Before the recording itself: a run that is killed in between leaves a recording that the next may replace.
        let beside = |recording: &Input, sha256: &str| {
            let read = vec![recording.clone(), calibration_input.clone()];
            let mut provenance = Provenance::new(sha256.to_owned(), read);
            provenance.replaces = replaced.clone();
            self.write_beside(provenance, signer.as_ref())
        };
        let data = ApplyData::new(
            &calibration,
            Source::open(&self.recording)?,
            Destination::File {
                path: &self.output,
                inputs: &inputs,
                beside: &beside,
            },
        );
        let outcome = self.job().evaluate(&data, &Progress::new())?;
        self.tell(&outcome);
        Ok(Outcome::Done)
    }

    /// The acceleration behind one channel, as a recording with the uncertainty of every sample.
    fn turn_back(
        &self,
        replaced: Option<String>,
        signer: Option<&SigningKey>,
    ) -> Result<Outcome, Failure> {
        let inputs = [self.recording.as_path(), self.calibration.as_path()];
        let model = FittedModel::read(
            Source::open(&self.calibration)?,
            self.turning.model,
            self.coverage,
        )?;
        let (reading, wanted) = self.reading.one_channel()?;
        let recording = reading.read(Source::open(&self.recording)?, &[wanted])?;
        let mut job = DeconvolutionJob::default();
        job.corner = self.turning.corner;
        job.quiet = self.turning.quiet;
        let outcome = job.evaluate_recording(&model, &recording, &Progress::new())?;
        read(&recording.input);
        console::doubt(&model.input);
        outcome.findings().iter().for_each(console::finding);
        let result = StoredResult::new(Record::default(), &outcome)?;
        let mut file = AtomicFile::create(&self.output, &inputs)?;
        file.write_all(&result.table("input.csv")?)?;
        if file.is_kept() {
            let read = vec![recording.input.clone(), model.input.clone()];
            let mut provenance = Provenance::new(file.sha256(), read);
            provenance.replaces = replaced;
            self.write_beside(provenance, signer)?;
        }
        file.commit()?;
        for q in outcome.quantities() {
            console::note(format!(
                "{}: {:.6} {} ± {:.2} (95 %)",
                q.name, q.value, q.unit, q.expanded
            ));
        }
        console::note(format!(
            "written: {} ({} samples)",
            self.output.display(),
            outcome.plain().len()
        ));
        Ok(Outcome::Done)
    }

    /// The list beside the recording, signed where there is a key.
    fn write_beside(
        &self,
        provenance: Provenance,
        signer: Option<&SigningKey>,
    ) -> proofmass::io::Result<()> {
        let inputs = [self.recording.as_path(), self.calibration.as_path()];
        let provenance = match signer {
            Some(key) => provenance.signed(key),
            None => provenance,
        };
        let mut beside = AtomicFile::create(Provenance::place(&self.output), &inputs)?;
        beside.write_all(&provenance.to_json()?)?;
        beside.commit()
    }

    fn job(&self) -> ApplyJob {
        let band = self.band.map(|b| b.0);
        let mut job = ApplyJob::default();
        job.reading = self.reading.clone();
        job.temperature = self.temperature.as_deref().map(ColumnRef::from_word);
        job.method = match (self.filter, band) {
            (true, band) => {
                let mut design = FilterDesign::default();
                design.band = band;
                if self.hold {
                    design.beyond = Beyond::Hold;
                }
                CompensationMethod::Filter(design)
            }
            (false, Some(band)) => CompensationMethod::Band(band),
            (false, None) => CompensationMethod::Model,
        };
        if self.within_range {
            job.out_of_range = OutOfRange::Refuse;
        }
        job
    }

    fn tell(&self, outcome: &ApplyOutcome) {
        read(outcome.recording());
        outcome.findings().iter().for_each(console::finding);
        if let Some(statement) = outcome.statement() {
            console::note(statement);
        }
        console::note(format!(
            "written: {} ({} samples, columns {})",
            self.output.display(),
            outcome.rows(),
            outcome.columns().join(", ")
        ));
    }

    /// Whether what stands at the place may go: what an earlier run wrote there and nobody changed, or what the user says.
    /// Its digest, where something stands there.
    fn may_replace(&self) -> Result<Option<String>, Failure> {
        if !console::stands(&self.output) || self.output == Path::new("-") {
            return Ok(None);
        }
        let there = Input::of(&self.output)?.sha256;
        let own = match Provenance::of(&self.output) {
            Ok(Some(provenance)) => provenance.wrote(&there),
            _ => false,
        };
        if console::may_replace(&self.output, self.force || own) {
            return Ok(Some(there));
        }
        Err(Failure::new(format!(
            "{} is there, and was not written by `proofmass apply` or was changed since",
            self.output.display()
        ))
        .hint("name another file, or replace it with --force"))
    }
}
