//! `proofmass noise`: stability and noise of a sensor at rest.

mod columns;
mod stream;
mod tables;

use crate::delivery::{Delivery, Results};
use crate::{Failure, Outcome, clock, console};
use proofmass::io::{
    AtomicFile, Input, OutputFolder, ResultDocument, Software, TimeSource, TimeUnit, Unit,
};
use proofmass::noise::{
    Analysis, AnalysisOptions, Channel, DeviationOptions, FitOptions, Gaps, ImuPart, Sensor,
    Statistic, Taus, Term, analyse, imu_yaml,
};
use proofmass::report::NoiseReport;
use proofmass::signal::Detrend;
use proofmass::uncertainty::Finding;
use std::path::PathBuf;

/// Noise and stability of a sensor at rest: Allan deviation, spectrum, coefficients with intervals.
///
/// Each coefficient (quantisation Q, white noise N, bias instability B, random walk K, ramp R) comes with an
/// interval, or as "not identifiable" with the reason. Steps, bursts and spikes are found and named. With -o, a
/// folder gets result.json (everything), report.html, deviation.csv and spectrum.csv.
#[derive(clap::Args)]
pub(crate) struct Noise {
    /// Recording of a sensor at rest: delimited text of any common shape
    recording: PathBuf,
    /// Columns by name or number (from 1) [default: every column that is neither time nor temperature]
    #[arg(long, value_name = "A,B,…", value_delimiter = ',')]
    columns: Option<Vec<String>>,
    /// Unit of these columns, where the headings do not say it: m/s², g, mg, rad/s, °/s, V, count, …
    #[arg(long, value_parser = unit)]
    unit: Option<Unit>,
    /// Size of one count (or volt) in the unit of --unit, for raw outputs
    #[arg(long, value_name = "FACTOR", requires = "unit")]
    scale: Option<f64>,
    /// Time column by name or number
    #[arg(long, value_name = "COLUMN")]
    time: Option<String>,
    /// Unit of the time column, where the heading does not say it: s, ms, us, ns
    #[arg(long, value_name = "UNIT", requires = "time", value_parser = crate::recording_arguments::time_unit)]
    time_unit: Option<TimeUnit>,
    /// Sampling rate in hertz, for recordings without a time column
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// The columns hold integrals of the rate: velocities (m/s) of an accelerometer, angles of a gyroscope
    ///
    /// They are differenced. With --unit, state the unit of the rate.
    #[arg(long)]
    phase: bool,
    /// Statistics, the one plotted first: adev, oadev, mdev, tdev, hdev, ohdev, totdev, mtotdev, ttotdev, htotdev, theo1
    #[arg(long, value_name = "A,B,…", value_delimiter = ',', default_value = "oadev", value_parser = statistic)]
    statistic: Vec<Statistic>,
    /// Averaging times: octave, decade, all, a number of them per decade (10/decade), or a list in seconds (0.1,1,10)
    #[arg(long, default_value = "octave", value_parser = taus)]
    taus: Taus,
    /// Trend removed first: none, linear or quadratic
    #[arg(long, default_value = "none", value_parser = detrend)]
    detrend: Detrend,
    /// Probability of the intervals
    #[arg(long, value_name = "P", default_value_t = 0.95)]
    probability: f64,
    /// Also seek a first-order Gauss–Markov process
    #[arg(long)]
    gauss_markov: bool,
    /// Also seek sinusoids
    #[arg(long)]
    sinusoids: bool,
    /// Refuse a recording with gaps instead of analysing the stretches between them
    #[arg(long)]
    refuse_gaps: bool,
    /// Read the recording as a stream, in memory that does not grow with it [default: above 2 GB]
    ///
    /// Gives OADEV at octaves of all samples; spectrum, coefficients and disturbances of its averages.
    #[arg(long)]
    stream: bool,
    /// Write imu.yaml for visual–inertial programs, units in its comments
    #[arg(long, value_name = "FILE")]
    imu_yaml: Option<PathBuf>,
    #[command(flatten)]
    delivery: Delivery,
}

impl Noise {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let folder = self.delivery.begin(&[&self.recording])?;
        let size = std::fs::metadata(&self.recording).map_or(0, |m| m.len());
        let stream = self.stream || size > LARGEST_IN_MEMORY;
        if stream && !self.stream {
            console::note(format!(
                "the recording has {:.1} GB: read as a stream (--stream)",
                size as f64 * 1e-9
            ));
        }
        let found = if stream {
            stream::analyse(&self)?
        } else {
            self.analyse_in_memory()?
        };
        if let Some(path) = &self.imu_yaml {
            self.write_imu_yaml(path, &found)?;
        }
        self.write(folder, &found)
    }

    fn analyse_in_memory(&self) -> Result<Found, Failure> {
        let recording = columns::read(self)?;
        let units: Vec<String> = recording
            .columns
            .iter()
            .map(|c| unit_name(c.unit))
            .collect();
        let channels: Vec<Channel<'_>> = recording
            .columns
            .iter()
            .zip(&units)
            .map(|(column, unit)| Channel {
                name: &column.name,
                sensor: sensor(column.unit),
                unit,
                rate: &column.data,
            })
            .collect();
        let stamps = match recording.time.source() {
            // The rate between two integrals belongs to the later stamp.
            TimeSource::Column(seconds) => Some(&seconds[usize::from(self.phase)..]),
            _ => None,
        };
        let analysis = analyse(
            &channels,
            stamps,
            columns::rate(&recording),
            &self.options(),
        )
        .map_err(|e| self.failure(e))?;
        let rows = analysis.rows.0..analysis.rows.1;
        Ok(Found {
            input: recording.input(),
            findings: tables::findings(recording.findings(), &analysis),
            sensors: recording.columns.iter().map(|c| sensor(c.unit)).collect(),
            samples: recording
                .columns
                .into_iter()
                .map(|c| c.data[rows.clone()].to_vec())
                .collect(),
            analysis,
        })
    }

    fn options(&self) -> AnalysisOptions {
        let mut fit = FitOptions {
            probability: self.probability,
            ..FitOptions::default()
        };
        fit.terms
            .extend(self.gauss_markov.then_some(Term::GaussMarkov));
        fit.terms.extend(self.sinusoids.then_some(Term::Sinusoid));
        AnalysisOptions {
            statistic: self.statistic[0],
            further: self.statistic[1..].to_vec(),
            deviation: DeviationOptions {
                taus: self.taus.clone(),
                probability: self.probability,
                ..DeviationOptions::default()
            },
            fit,
            gaps: if self.refuse_gaps {
                Gaps::Refuse
            } else {
                Gaps::default()
            },
            detrend: self.detrend,
            ..AnalysisOptions::default()
        }
    }

    /// A refusal of the analysis, with the file and a remedy.
    fn failure(&self, error: proofmass::core::Error) -> Failure {
        use proofmass::core::Error;
        let hint = match error {
            Error::TooFew { .. } => {
                "record longer: coefficients need thousands of samples, a curve at least ten"
            }
            Error::OutOfRange { name: "tau", .. } => {
                "an averaging time is a whole number of sample intervals, at most a half or a third of the record by statistic"
            }
            _ if self.refuse_gaps => {
                "leave out --refuse-gaps to analyse the stretches between the gaps"
            }
            _ => "see `proofmass inspect` for what the file holds",
        };
        Failure::from(error)
            .detail(self.recording.display().to_string())
            .hint(hint)
    }

    fn write_imu_yaml(&self, path: &PathBuf, found: &Found) -> Result<(), Failure> {
        let fits = |wanted: Sensor| -> Vec<_> {
            found
                .sensors
                .iter()
                .zip(&found.analysis.channels)
                .filter(|(sensor, _)| **sensor == Some(wanted))
                .filter_map(|(_, channel)| channel.whittle.as_ref())
                .collect()
        };
        let accelerometers = fits(Sensor::Accelerometer);
        let gyroscopes = fits(Sensor::Gyroscope);
        let parts: Vec<ImuPart<'_>> = [
            (Sensor::Accelerometer, &accelerometers),
            (Sensor::Gyroscope, &gyroscopes),
        ]
        .into_iter()
        .filter(|(_, axes)| !axes.is_empty())
        .map(|(sensor, axes)| ImuPart { sensor, axes })
        .collect();
        if parts.is_empty() {
            return Err(Failure::new(
                "imu.yaml needs coefficients of accelerations or angular rates; there are none",
            )
            .hint("state the unit with --unit, and --scale for raw outputs"));
        }
        let mut file = AtomicFile::create(path, &[&self.recording])?;
        file.write_all(imu_yaml(&parts, found.analysis.sample_rate).as_bytes())?;
        file.commit()?;
        console::note(format!("written: {}", path.display()));
        Ok(())
    }

    fn write(&self, folder: Option<OutputFolder>, found: &Found) -> Result<Outcome, Failure> {
        let (analysis, findings) = (&found.analysis, &found.findings);
        let json = ResultDocument::new("noise")
            .findings(findings)
            .input(found.input.clone())
            .section("date", &clock::today())?
            .section("options", &self.options())?
            .section("noise", analysis)?
            .to_json()?;
        let text = NoiseReport {
            title: format!("Noise of {}", self.recording.display()),
            meta: vec![("Evaluated on".to_owned(), clock::today())],
            inputs: vec![(found.input.path.clone(), found.input.sha256.clone())],
            findings,
            samples: found.samples.iter().map(Vec::as_slice).collect(),
            footer: Software::default().to_string(),
        };
        self.delivery.hand_over(
            folder,
            &Results {
                json,
                summary: &|| text.summary(analysis),
                report: &|| text.full(analysis),
                files: vec![
                    ("deviation.csv", tables::deviations(analysis)?),
                    ("spectrum.csv", tables::spectra(analysis)?),
                ],
                findings,
            },
        )
    }
}

/// Text above which a recording is not held in memory, where it would take some ten times as much.
const LARGEST_IN_MEMORY: u64 = 2_000_000_000;

/// What was found of a recording, however it was read.
struct Found {
    input: Input,
    analysis: Analysis,
    findings: Vec<Finding>,
    sensors: Vec<Option<Sensor>>,
    /// What is drawn against time: the samples that were analysed, or their averages.
    samples: Vec<Vec<f64>>,
}

fn unit_name(unit: Option<Unit>) -> String {
    unit.map_or_else(|| "U".to_owned(), |u| u.to_string())
}

fn sensor(unit: Option<Unit>) -> Option<Sensor> {
    match unit? {
        Unit::MetrePerSecondSquared => Some(Sensor::Accelerometer),
        Unit::RadianPerSecond => Some(Sensor::Gyroscope),
        _ => None,
    }
}

fn unit(text: &str) -> Result<Unit, String> {
    Unit::recognise(text)
        .ok_or_else(|| format!("{text:?} is no known unit (m/s², g, mg, rad/s, °/s, V, count)"))
}

fn statistic(text: &str) -> Result<Statistic, String> {
    Statistic::ALL
        .into_iter()
        .find(|s| s.abbreviation().eq_ignore_ascii_case(text))
        .ok_or_else(|| format!("{text:?} is no known statistic"))
}

fn taus(text: &str) -> Result<Taus, String> {
    let refused = || format!("{text:?} is none of octave, decade, all, 10/decade, 0.1,1,10");
    match text {
        "octave" => Ok(Taus::Octave),
        "decade" => Ok(Taus::Decade),
        "all" => Ok(Taus::All),
        _ => match text.strip_suffix("/decade") {
            Some(count) => match count.trim().parse() {
                Ok(count @ 1..=1000) => Ok(Taus::PerDecade(count)),
                _ => Err(refused()),
            },
            None => {
                let seconds = text.split(',').map(|t| t.trim().parse::<f64>());
                let seconds = seconds.collect::<Result<Vec<_>, _>>();
                seconds.map(Taus::Chosen).map_err(|_| refused())
            }
        },
    }
}

fn detrend(text: &str) -> Result<Detrend, String> {
    match text {
        "none" => Ok(Detrend::None),
        "linear" => Ok(Detrend::Linear),
        "quadratic" => Ok(Detrend::Quadratic),
        _ => Err(format!("{text:?} is no trend (none, linear, quadratic)")),
    }
}
