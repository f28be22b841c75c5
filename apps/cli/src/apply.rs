//! `proofmass apply`: compensated recording, streamed.

use crate::at_arguments::AtArguments;
use crate::chain_arguments::ChainArguments;
use crate::console::Progress;
use crate::written_file::{Replacement, WrittenFile, read};
use crate::{Failure, Outcome, console};
use proofmass::dynamic::frequency_response::{Beyond, FilterDesign};
use proofmass::dynamic::model::ModelStructure;
use proofmass::io::{AtomicFile, ColumnRef, Input, Source};
use proofmass::jobs::apply::{
    ApplyData, ApplyJob, ApplyOutcome, CompensationMethod, Destination, FollowedColumn, OutOfRange,
};
use proofmass::jobs::bias::TrackedBias;
use proofmass::jobs::deconvolution::{DeconvolutionJob, FittedModel};
use proofmass::jobs::{
    Job, Outcome as _, Record, RecordingReading, StoredResult, frequency_response,
};
use std::path::PathBuf;

/// Compensate a recording with a calibration.
///
/// a = K⁻¹ (output − b), row by row: a recording of any size needs no more memory than a small one. All other columns
/// are kept as they are. The same function runs in firmware. A calibration over frequency (from a shaker, or the table
/// of a laboratory) is used through the constant matrix of a band, or through a filter; both state their error.
///
/// Steps may follow, always in this order: a tracked bias is subtracted, the axes are turned, a low-pass runs, samples are left out. Their
/// delay is stated and taken out.
#[derive(clap::Args)]
pub(crate) struct Apply {
    /// calibration.json (of three axes or one), a result.json that holds it, the folder of either, or a laboratory's table (.csv) over frequency
    calibration: PathBuf,
    /// Recording with uncompensated outputs; `-` is standard input
    recording: PathBuf,
    #[command(flatten)]
    file: WrittenFile,
    /// Calibration over frequency: the constant real matrix of this band in hertz; one frequency twice is that alone
    #[arg(long, value_name = "LOW,HIGH", value_parser = crate::number_arguments::band_or_frequency)]
    band: Option<[f64; 2]>,
    /// Calibration over frequency: an inverse filter (whole range, or --band)
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
    /// Column of another quantity that the calibration follows (humidity, pressure, supply voltage), with its unit where the heading does
    /// not say it; more than once
    #[arg(long, value_name = "[NAME=]COLUMN[:UNIT]")]
    environment: Vec<FollowedColumn>,
    #[command(flatten)]
    at: AtArguments,
    /// Refuse a recording with samples beyond the range in which the calibration was tested, instead of reporting them
    #[arg(long)]
    within_range: bool,
    /// Subtract a bias that was tracked over this recording: the result.json of `proofmass bias`
    #[arg(long, value_name = "FILE")]
    bias: Option<PathBuf>,
    #[command(flatten)]
    chain: ChainArguments,
    /// Acceleration behind one channel (--columns) by the inverse of a fitted model, each sample with its uncertainty
    ///
    /// The calibration is then the result.json of a test with a model, or a calibration over frequency that --model is
    /// fitted to.
    #[arg(long, requires = "columns", conflicts_with_all = ["band", "filter", "temperature", "environment", "at", "within_range", "bias", "rotate", "low_pass", "decimate"])]
    dynamic: bool,
    #[command(flatten)]
    turning: Turning,
    #[command(flatten)]
    reading: RecordingReading,
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

impl Apply {
    pub(crate) fn run(mut self) -> Result<Outcome, Failure> {
        self.calibration = StoredResult::calibration_place(&self.calibration);
        let mut inputs = vec![self.recording.as_path(), self.calibration.as_path()];
        inputs.extend(self.bias.as_deref());
        inputs.extend(self.chain.mounting());
        let replacement = self.file.begin(&inputs)?;
        if self.dynamic {
            return self.turn_back(&replacement);
        }
        let source = Source::open(&self.calibration)?;
        let (calibration, calibration_input, findings) =
            frequency_response::read_calibration(source, self.coverage).map_err(|e| {
                match e.to_string().contains("kind \"bias\"") {
                    true => e.with_hint(
                        "name the calibration first, and subtract this bias with --bias FILE",
                    ),
                    false => e,
                }
            })?;
        let named = |(name, _): &&(String, f64)| {
            let read = self.environment.iter();
            read.filter_map(|e| e.quantity.as_ref()).any(|q| q == name)
        };
        if let Some((name, _)) = self.at.at.iter().find(named) {
            return Err(Failure::new(format!(
                "{name} is stated with --at and read with --environment"
            ))
            .hint("leave one of them out"));
        }
        let held = self.at.words(&calibration);
        let calibration = calibration
            .at_environment(&self.at.at)
            .map_err(|e| e.at(&self.calibration))?;
        console::doubt(&calibration_input);
        findings.iter().for_each(console::finding);
        let tracked = self.bias.as_deref();
        let tracked = tracked.map(|path| TrackedBias::read(Source::open(path)?));
        let (bias, bias_input) = tracked.transpose()?.unzip();
        bias_input.iter().for_each(console::doubt);
        let (job, mounting_input) = self.job()?;
        mounting_input.iter().for_each(console::doubt);
        let beside = |recordings: &[Input], sha256: &str, steps: &[String]| {
            let mut read = recordings.to_vec();
            read.push(calibration_input.clone());
            read.extend(bias_input.clone());
            read.extend(mounting_input.clone());
            self.file.write_beside(
                &replacement,
                &inputs,
                read,
                (sha256, &[&held, steps].concat()),
            )
        };
        let mut data = ApplyData::new(
            &calibration,
            Source::open(&self.recording)?,
            Destination::File {
                path: &self.file.output,
                inputs: &inputs,
                beside: &beside,
            },
        );
        if let Some(bias) = &bias {
            data = data.with_bias(bias);
        }
        let outcome = job.evaluate(&data, &Progress::new())?;
        let device = match calibration.device().line() {
            none if none.is_empty() => "a device that it does not name".to_owned(),
            device => device,
        };
        console::note(format!(
            "calibration: {} of {device}",
            self.calibration.display()
        ));
        if !held.is_empty() {
            console::note(format!("calibration {}", held.join(", ")));
        }
        self.tell(&outcome);
        Ok(Outcome::Done)
    }

    /// The acceleration behind one channel, as a recording with the uncertainty of every sample.
    fn turn_back(&self, replacement: &Replacement) -> Result<Outcome, Failure> {
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
        let mut file = AtomicFile::create(&self.file.output, &inputs)?;
        file.write_all(&result.table("input.csv")?)?;
        if file.is_kept() {
            let read = vec![recording.input.clone(), model.input.clone()];
            self.file
                .write_beside(replacement, &inputs, read, (&file.sha256(), &[]))?;
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
            self.file.output.display(),
            outcome.plain().len()
        ));
        Ok(Outcome::Done)
    }

    /// The request, and the file of a measured turn.
    fn job(&self) -> Result<(ApplyJob, Option<Input>), Failure> {
        let mut job = ApplyJob::default();
        job.reading = self.reading.clone();
        job.temperature = self.temperature.as_deref().map(ColumnRef::from_word);
        job.environment = self.environment.clone();
        let mounting;
        (job.chain, mounting) = self.chain.chain()?;
        job.method = match (self.filter, self.band) {
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
        Ok((job, mounting))
    }

    fn tell(&self, outcome: &ApplyOutcome) {
        read(outcome.recording());
        outcome.findings().iter().for_each(console::finding);
        if let Some(statement) = outcome.statement() {
            console::note(statement);
        }
        outcome.matrix().into_iter().for_each(console::note);
        if let Some(chain) = outcome.chain() {
            console::note(format!("steps: {}", chain.steps.join("; ")));
            for line in chain.statements() {
                console::note(line);
            }
        }
        console::note(format!(
            "written: {} ({} samples, columns {})",
            self.file.output.display(),
            outcome.rows(),
            outcome.columns().join(", ")
        ));
    }
}
