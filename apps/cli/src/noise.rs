//! `proofmass noise`: stability and noise of a sensor at rest.

use crate::delivery::{Delivery, Results};
use crate::{Failure, Outcome, clock, console};
use proofmass::io::{
    AtomicFile, Cell, ColumnRef, Layout, LayoutOptions, OutputFolder, Recording, RecordingOptions,
    ResultDocument, Software, Table, TimeSource, TimeUnit, Unit,
};
use proofmass::noise::{
    Analysis, AnalysisOptions, Channel, DeviationOptions, FitOptions, Gaps, ImuPart, Sensor,
    Statistic, Term, analyse, imu_yaml,
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
    /// Statistic of the curve: adev, oadev, mdev, tdev, hdev, ohdev, totdev, mtotdev, ttotdev, htotdev, theo1
    #[arg(long, default_value = "oadev", value_parser = statistic)]
    statistic: Statistic,
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
    /// Refuse a recording with gaps instead of analysing its longest stretch
    #[arg(long)]
    refuse_gaps: bool,
    /// Write imu.yaml for visual–inertial programs, units in its comments
    #[arg(long, value_name = "FILE")]
    imu_yaml: Option<PathBuf>,
    #[command(flatten)]
    delivery: Delivery,
}

impl Noise {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let folder = self.delivery.begin()?;
        let mut recording = self.read()?;
        self.convert(&mut recording)?;
        let units: Vec<String> = recording
            .columns
            .iter()
            .map(|c| c.unit.map_or_else(|| "U".to_owned(), |u| u.to_string()))
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
            TimeSource::Column(seconds) => Some(seconds.as_slice()),
            _ => None,
        };
        let analysis = analyse(&channels, stamps, rate(&recording), &self.options())
            .map_err(|e| self.failure(e))?;
        if let Some(path) = &self.imu_yaml {
            self.write_imu_yaml(path, &channels, &analysis)?;
        }
        self.write(folder, &recording, &analysis)
    }

    fn read(&self) -> Result<Recording, Failure> {
        let layout = LayoutOptions::default();
        let time = self.time.as_deref().map(ColumnRef::from_word);
        let columns = match &self.columns {
            Some(names) => names.iter().map(|n| ColumnRef::from_word(n)).collect(),
            None => {
                let columns = signals(
                    &Layout::sniff_with(&self.recording, &layout)?,
                    time.as_ref(),
                )?;
                if columns.is_empty() {
                    return Err(Failure::new("no column holds a signal")
                        .detail(self.recording.display().to_string())
                        .hint("name the columns with --columns"));
                }
                columns
            }
        };
        Ok(Recording::read(
            &self.recording,
            &RecordingOptions {
                layout,
                columns,
                time,
                time_unit: self.time_unit,
                sampling_rate_hz: self.rate,
                temperature: None,
                // With a scale, --unit is the unit after scaling.
                unit: self.unit.filter(|_| self.scale.is_none()),
            },
        )?)
    }

    /// Brings every column to SI, raw outputs through `--scale`.
    fn convert(&self, recording: &mut Recording) -> Result<(), Failure> {
        for column in &mut recording.columns {
            let (unit, factor) = match (self.scale, self.unit) {
                (Some(scale), Some(unit)) => {
                    if let Some(stated) = column.unit.filter(|u| !u.is_raw()) {
                        return Err(Failure::new(format!(
                            "column {:?} is in {stated} by its heading: --scale is for raw outputs",
                            column.name
                        ))
                        .hint("remove --scale and --unit, or correct the heading"));
                    }
                    if !(scale.is_finite() && scale > 0.0) {
                        return Err(Failure::new(format!("--scale {scale} must be positive")));
                    }
                    let (si, factor) = unit.si();
                    (si, scale * factor)
                }
                _ => match column.unit {
                    Some(unit) => unit.si(),
                    None => continue,
                },
            };
            if factor != 1.0 {
                column.data.iter_mut().for_each(|v| *v *= factor);
            }
            column.unit = Some(unit);
        }
        Ok(())
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
            statistic: self.statistic,
            deviation: DeviationOptions {
                probability: self.probability,
                ..DeviationOptions::default()
            },
            fit,
            gaps: if self.refuse_gaps {
                Gaps::Refuse
            } else {
                Gaps::LongestStretch
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
            _ if self.refuse_gaps => "leave out --refuse-gaps to analyse the longest stretch",
            _ => "see `proofmass inspect` for what the file holds",
        };
        Failure::from(error)
            .detail(self.recording.display().to_string())
            .hint(hint)
    }

    fn write_imu_yaml(
        &self,
        path: &PathBuf,
        channels: &[Channel<'_>],
        analysis: &Analysis,
    ) -> Result<(), Failure> {
        let fits = |sensor: Sensor| -> Vec<_> {
            channels
                .iter()
                .zip(&analysis.channels)
                .filter(|(channel, _)| channel.sensor == Some(sensor))
                .filter_map(|(_, found)| found.whittle.as_ref())
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
        file.write_all(imu_yaml(&parts, analysis.sample_rate).as_bytes())?;
        file.commit()?;
        console::note(format!("written: {}", path.display()));
        Ok(())
    }

    fn write(
        &self,
        folder: Option<OutputFolder>,
        recording: &Recording,
        analysis: &Analysis,
    ) -> Result<Outcome, Failure> {
        let findings = findings(recording, analysis);
        let json = ResultDocument::new("noise")
            .findings(&findings)
            .input(recording.input())
            .section("date", &clock::today())?
            .section("options", &self.options())?
            .section("noise", analysis)?
            .to_json()?;
        let text = NoiseReport {
            title: format!("Noise of {}", self.recording.display()),
            meta: vec![("Evaluated on".to_owned(), clock::today())],
            inputs: vec![(
                recording.path.display().to_string(),
                recording.sha256.clone(),
            )],
            findings: &findings,
            samples: recording
                .columns
                .iter()
                .map(|c| &c.data[analysis.rows.0..analysis.rows.1])
                .collect(),
            footer: Software::default().to_string(),
        };
        self.delivery.hand_over(
            folder,
            &Results {
                json,
                summary: &|| text.summary(analysis),
                report: &|| text.full(analysis),
                files: vec![
                    ("deviation.csv", deviations(analysis)?),
                    ("spectrum.csv", spectra(analysis)?),
                ],
                findings: &findings,
            },
        )
    }
}

/// Every numeric column that is neither a time nor a temperature.
fn signals(layout: &Layout, time: Option<&ColumnRef>) -> Result<Vec<ColumnRef>, Failure> {
    let time = match time {
        Some(column) => Some(layout.find(column)?),
        None => layout.time_column(),
    };
    let is_signal = |i: &usize| {
        let other = |u: Unit| u.is_time() || matches!(u, Unit::DegreeCelsius | Unit::Kelvin);
        layout.numeric[*i] && Some(*i) != time && !layout.unit(*i).is_some_and(other)
    };
    Ok((0..layout.columns)
        .filter(is_signal)
        .map(|i| ColumnRef::Index(i + 1))
        .collect())
}

/// Samples per second: the stated rate, or the mean over the steps that are not gaps, which the resolution of the
/// time stamps does not bias.
fn rate(recording: &Recording) -> f64 {
    let time = &recording.time;
    match time.source() {
        TimeSource::Column(seconds) => {
            let missing: f64 = time.gaps().iter().map(|g| g.step_s).sum();
            let steps = seconds.len() - 1 - time.gaps().len();
            steps as f64 / (seconds[seconds.len() - 1] - seconds[0] - missing)
        }
        _ => time.rate_hz(),
    }
}

fn sensor(unit: Option<Unit>) -> Option<Sensor> {
    match unit? {
        Unit::MetrePerSecondSquared => Some(Sensor::Accelerometer),
        Unit::RadianPerSecond => Some(Sensor::Gyroscope),
        _ => None,
    }
}

/// Those of the recording, of the whole analysis, and of each channel with its name.
fn findings(recording: &Recording, analysis: &Analysis) -> Vec<Finding> {
    let mut findings = recording.findings().to_vec();
    findings.extend(analysis.findings.iter().cloned());
    for channel in &analysis.channels {
        findings.extend(channel.findings.iter().map(|f| {
            Finding::new(
                f.severity(),
                f.code(),
                format!("{}: {}", channel.name, f.what()),
            )
            .evidence(f.evidence_text())
            .advice(f.advice_text())
        }));
    }
    findings
}

fn deviations(analysis: &Analysis) -> Result<Vec<u8>, Failure> {
    let mut table = Table::new([
        "channel",
        "unit",
        "statistic",
        "factor",
        "tau_s",
        "deviation",
        "low",
        "high",
        "edf",
    ]);
    for channel in &analysis.channels {
        let Some(curve) = &channel.curve else {
            continue;
        };
        for p in &curve.points {
            table.push([
                Cell::from(channel.name.as_str()),
                Cell::from(channel.unit.as_str()),
                Cell::from(curve.statistic.abbreviation()),
                Cell::from(p.factor),
                Cell::from(p.tau),
                Cell::from(p.deviation),
                Cell::from(p.interval.map(|i| i.0)),
                Cell::from(p.interval.map(|i| i.1)),
                Cell::from(p.edf),
            ])?;
        }
    }
    Ok(table.to_csv()?)
}

fn spectra(analysis: &Analysis) -> Result<Vec<u8>, Failure> {
    let mut table = Table::new([
        "channel",
        "unit",
        "frequency_Hz",
        "density_one_sided",
        "low",
        "high",
    ]);
    for channel in &analysis.channels {
        for p in &channel.spectrum {
            table.push([
                Cell::from(channel.name.as_str()),
                Cell::from(format!("({})²/Hz", channel.unit).as_str()),
                Cell::from(p.frequency),
                Cell::from(p.density),
                Cell::from(p.interval.map(|i| i.0)),
                Cell::from(p.interval.map(|i| i.1)),
            ])?;
        }
    }
    Ok(table.to_csv()?)
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

fn detrend(text: &str) -> Result<Detrend, String> {
    match text {
        "none" => Ok(Detrend::None),
        "linear" => Ok(Detrend::Linear),
        "quadratic" => Ok(Detrend::Quadratic),
        _ => Err(format!("{text:?} is no trend (none, linear, quadratic)")),
    }
}
