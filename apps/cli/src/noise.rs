//! `proofmass noise`: stability and noise of a sensor at rest.

mod compare;

use crate::clock::{named, record};
use crate::console::Progress;
use crate::delivery::Delivery;
use crate::number_arguments::false_alarm_rate;
use crate::{Failure, Outcome, console};
use proofmass::io::{AtomicFile, Source, spelling};
use proofmass::jobs::noise::{NoiseJob, NoiseOutcome, NoiseReading};
use proofmass::jobs::{Job, Outcome as _, StoredResult};
use proofmass::noise::{
    AnalysisOptions, Bias, DeviationOptions, EdfFormula, FitOptions, Gaps, NoiseType, Statistic,
    Taus, Term,
};
use proofmass::signal::Detrend;
use std::path::{Path, PathBuf};

/// Noise of a sensor at rest: Allan deviation, spectrum, N, B, K with intervals.
///
/// Quantisation noise Q, white noise N, bias instability B, random walk K and ramp R are fitted together. Each has an
/// interval that allows for all others, or, where that reaches zero, an upper limit. Steps, bursts and spikes are
/// reported. With
/// -o, a folder gets result.json (everything), report.html, tables, and imu.yaml where the sensors are inertial.
#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct Noise {
    #[command(subcommand)]
    question: Option<Question>,
    /// Recording of a sensor at rest: delimited text of any common shape
    #[arg(required = true)]
    recording: Option<PathBuf>,
    #[command(flatten)]
    reading: NoiseReading,
    /// Statistics, the first is plotted: adev, oadev, mdev, tdev, hdev, totdev, theo1, pdev and more with --help
    ///
    /// All: adev, oadev, mdev, tdev, hdev, ohdev, totdev, mtotdev, ttotdev, htotdev, theo1, theoh, pdev.
    #[arg(
        long,
        value_name = "A,B,…",
        value_delimiter = ',',
        value_parser = statistic,
        default_value = "oadev"
    )]
    statistic: Vec<Statistic>,
    /// Averaging times: octave, decade, all, a number of them per decade (10/decade), or a list in seconds (0.1,1,10)
    #[arg(long, default_value = "octave")]
    taus: Taus,
    /// Trend removed first: none, linear or quadratic
    #[arg(long, default_value = "none")]
    detrend: Detrend,
    /// Probability of the intervals
    #[arg(long, value_name = "P", default_value_t = 0.95)]
    probability: f64,
    /// Terms of the model: Q, N, B, K, R, G (Gauss–Markov), A (sinusoids); terms not named are not fitted
    #[arg(
        long,
        value_name = "N,B,…",
        value_delimiter = ',',
        default_value = "Q,N,B,K,R"
    )]
    terms: Vec<Term>,
    /// Also seek first-order Gauss–Markov processes
    #[arg(long)]
    gauss_markov: bool,
    /// Also seek sinusoids, from one and a half cycles in the record on
    #[arg(long)]
    sinusoids: bool,
    /// First-order lag of the output behind the thermometer, in seconds [default: found in the record]
    #[arg(
        long,
        value_name = "SECONDS",
        requires = "temperature",
        allow_negative_numbers = true
    )]
    temperature_lag: Option<f64>,
    /// Take no warm-up, lasting step or cycle of the day out of the noise
    #[arg(long)]
    no_courses: bool,
    /// Also fit without gross outliers
    #[arg(long)]
    robust: bool,
    /// Terms to report with a value even where their interval reaches zero
    #[arg(long = "report-terms", value_name = "K,…", value_delimiter = ',')]
    forced: Vec<Term>,
    /// Coefficients that are known, in SI: held at their value
    #[arg(long, value_name = "N=1e-3,…", value_delimiter = ',', value_parser = fixed)]
    fix: Vec<(Term, f64)>,
    /// Highest frequency of the fit in hertz [default: the highest below which no filter shows]
    #[arg(long, value_name = "HZ")]
    highest_frequency: Option<f64>,
    /// Probability that an absent term is called identified
    #[arg(long, value_name = "P", default_value_t = 0.002, value_parser = false_alarm_rate, allow_negative_numbers = true)]
    false_alarm_rate: f64,
    /// Correction of the biases of TOTDEV, MTOTDEV, HTOTDEV and THEO1: by-noise-type, from-record, as-defined
    #[arg(long, default_value = "by-noise-type")]
    bias: Bias,
    /// Degrees of freedom of MTOTDEV and HTOTDEV: published or stable32
    #[arg(long, default_value = "published")]
    edf: EdfFormula,
    /// Dominant noise type at every τ, by its exponent α from -4 to 2 [default: from the record]
    #[arg(long, value_name = "ALPHA", allow_negative_numbers = true)]
    noise_type: Option<NoiseType>,
    /// Samples per segment of the Welch density [default: an eighth of the record, at most 4096]
    #[arg(long, value_name = "SAMPLES")]
    segment: Option<usize>,
    /// Dynamic Allan deviation: OADEV of this number of equal windows in succession
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    windows: usize,
    /// Noise of each of three channels side by side, without what they have in common; with --phase, of clocks
    ///
    /// Groslambert covariance, which from one recording is the three-cornered hat.
    #[arg(long, conflicts_with = "stream")]
    separate: bool,
    /// Refuse a recording with gaps instead of analysing the segments between them
    #[arg(long)]
    refuse_gaps: bool,
    /// Read the recording as a stream, in bounded memory [default: above some 20 million samples, or 48 MiB through a pipe]
    ///
    /// Gives OADEV at octaves of all samples; spectrum, coefficients and disturbances of its averages.
    #[arg(long)]
    stream: bool,
    /// Write imu.yaml for Kalibr and its like, units and reasons in its comments
    #[arg(long, value_name = "FILE")]
    imu_yaml: Option<PathBuf>,
    /// Topic written into imu.yaml
    #[arg(long, value_name = "TOPIC", default_value = "/imu0")]
    rostopic: String,
    #[command(flatten)]
    delivery: Delivery,
}

#[derive(clap::Subcommand)]
enum Question {
    Compare(compare::Compare),
}

/// Samples, all channels together, above which a recording is not held in memory: the analysis takes some eighty bytes of
/// each, and minutes.
const MOST_IN_MEMORY: u64 = 20_000_000;

impl Noise {
    pub(crate) fn run(mut self) -> Result<Outcome, Failure> {
        if let Some(Question::Compare(compare)) = self.question.take() {
            return compare.run();
        }
        let Some(path) = self.recording.take() else {
            return Err(
                Failure::new("there is no recording").hint("name one: proofmass noise RECORDING")
            );
        };
        self.analyse(&path)
    }

    fn analyse(&self, path: &Path) -> Result<Outcome, Failure> {
        for (k, (term, _)) in self.fix.iter().enumerate() {
            if self.fix[..k].iter().any(|f| f.0 == *term) {
                return Err(Failure::new(format!("--fix gives {} twice", term.symbol()))
                    .hint("give each coefficient once"));
            }
        }
        let folder = self.delivery.begin(NoiseOutcome::KIND, &[path])?;
        let mut source = self.reading.choice.stream_of(Source::open(path)?);
        let channels = self.reading.columns.as_ref().map_or(1, Vec::len) as u64;
        let stream = self.stream || source.is_longer_than(MOST_IN_MEMORY / channels.max(1))?;
        if stream && !self.stream {
            let how_long = match source.lines_expected()? {
                Some(lines) => format!("has about {:.0} million rows", lines as f64 * 1e-6),
                None => "goes on beyond what is kept of a pipe".to_owned(),
            };
            console::note(format!(
                "the recording {how_long}: read as a stream (--stream)"
            ));
        }
        let (job, watch) = (self.job(), Progress::new());
        if let Some(yaml) = &self.imu_yaml {
            self.delivery.keep(yaml)?;
        }
        let (outcome, input) = if stream {
            let mut recording = self.reading.stream(source)?;
            let outcome = job.evaluate(&recording.data(), &watch)?;
            (outcome, recording.finish()?)
        } else {
            let recording = self.reading.read(source)?;
            let input = recording.input();
            let read = std::slice::from_ref(&input);
            (job.answer(&recording.data(), read, &watch)?, input)
        };
        drop(watch);
        if let Some(yaml) = &self.imu_yaml {
            let Some(imu) = outcome.imu_yaml() else {
                return Err(Failure::new(
                    "imu.yaml needs coefficients of accelerations or angular rates; there are none",
                )
                .hint("state the unit with --unit, and --scale for raw outputs"));
            };
            write_imu_yaml(yaml, path, &imu.to_text())?;
        }
        let record = record(format!("Noise of {}", named(path)), vec![input]);
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }

    fn job(&self) -> NoiseJob {
        let mut terms = self.terms.clone();
        terms.extend(self.gauss_markov.then_some(Term::GaussMarkov));
        terms.extend(self.sinusoids.then_some(Term::Sinusoid));
        terms.extend(self.forced.iter().chain(self.fix.iter().map(|f| &f.0)));
        terms.sort();
        terms.dedup();
        let mut job = NoiseJob::new(AnalysisOptions {
            statistic: self.statistic[0],
            further: self.statistic[1..].to_vec(),
            deviation: DeviationOptions {
                taus: self.taus.clone(),
                probability: self.probability,
                noise: self.noise_type,
                bias: self.bias,
                edf: self.edf,
            },
            fit: FitOptions {
                terms,
                forced: self.forced.clone(),
                fixed: self.fix.clone(),
                probability: self.probability,
                false_alarm_rate: self.false_alarm_rate,
                highest_frequency: self.highest_frequency,
                temperature_lag: self.temperature_lag,
                courses: !self.no_courses,
                ..FitOptions::default()
            },
            gaps: if self.refuse_gaps {
                Gaps::Refuse
            } else {
                Gaps::default()
            },
            detrend: self.detrend,
            segment: self.segment,
            windows: self.windows,
            separate: self.separate,
            robust: self.robust,
            ..AnalysisOptions::default()
        });
        job.clocks = self.reading.phase;
        job.rostopic.clone_from(&self.rostopic);
        job
    }
}

/// Never over the recording.
fn write_imu_yaml(path: &Path, recording: &Path, text: &str) -> Result<(), Failure> {
    let mut file = AtomicFile::create(path, &[recording])?;
    file.write_all(text.as_bytes())?;
    file.commit()?;
    console::note(format!("written: {}", path.display()));
    Ok(())
}

fn statistic(text: &str) -> Result<Statistic, String> {
    text.parse().map_err(|_| {
        let names = Statistic::ALL.map(|s| s.abbreviation().to_lowercase());
        let near = spelling::nearest(text, names.iter().map(String::as_str));
        let near = near.map_or(String::new(), |near| format!("did you mean {near}? "));
        format!("{near}known are {}", names.join(", "))
    })
}

fn fixed(text: &str) -> Result<(Term, f64), String> {
    let refused = || format!("{text:?} is no coefficient such as N=1.5e-3");
    let (name, value) = text.split_once('=').ok_or_else(refused)?;
    let term = name.parse()?;
    if matches!(term, Term::GaussMarkov | Term::Sinusoid) {
        return Err(format!("{name} cannot be held: only Q, N, B, K and R can"));
    }
    let value: f64 = value.trim().parse().map_err(|_| refused())?;
    if value.is_finite() {
        Ok((term, value))
    } else {
        Err(refused())
    }
}
