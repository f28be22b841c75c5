//! The whole noise analysis of a record at rest: curve, density, coefficients, and what to doubt.

use crate::channel_analysis::analyse_channel;
use crate::findings;
use crate::record::check_count;
use crate::separation::separated;
use crate::steps::Steps;
use crate::{
    CoefficientFit, ConsistencyPoint, ConverterTrace, CourseShape, DeviationCurve,
    DeviationOptions, Disturbance, DynamicWindow, FitOptions, FitRecord, FittedPoint, Gaps, InUnit,
    JointInfluence, KalmanNoise, RecordGap, RobustFit, Sensor, SeparatedPoint, StateSpace,
    Statistic, Term, gaps,
};
use proofmass_core::{Error, Unwatched, Watch};
use proofmass_signal::{Density, Detrend, Trend, clock};
use proofmass_uncertainty::{Finding, Severity};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Fewest samples of which a stability is computed at all.
const FEWEST_SAMPLES: usize = 10;

/// One channel of a recording.
#[derive(Clone, Copy, Debug)]
pub struct NoiseChannel<'a> {
    /// Name as in the recording.
    pub name: &'a str,
    /// What it measures, for conversion to the units in use; `None` for anything else.
    pub sensor: Option<Sensor>,
    /// Unit of the samples (SI), as printed.
    pub unit: &'a str,
    /// Rate samples; NaN marks a missing value.
    pub rate: &'a [f64],
}

/// How a record is analysed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct AnalysisOptions {
    /// Statistic of the curve.
    pub statistic: Statistic,
    /// Further statistics, each with a curve of its own.
    pub further: Vec<Statistic>,
    /// Averaging times, probability, bias.
    pub deviation: DeviationOptions,
    /// Terms of the model and how they are called; its unit is replaced by each channel's.
    pub fit: FitOptions,
    /// What is done about gaps.
    pub gaps: Gaps,
    /// Trend removed before the curve and the fits. The default removes nothing: drift is part of what a curve shows.
    pub detrend: Detrend,
    /// Probability that a record without a disturbance is reported to have one, per channel.
    pub disturbance_false_alarm_rate: f64,
    /// Samples per segment of the Welch density; chosen from the record when `None` (at most 4096).
    pub segment: Option<usize>,
    /// Windows of the dynamic Allan deviation; none when 0.
    pub windows: usize,
    /// Separate the noise of three channels that see the same (two: clocks measured against a third).
    pub separate: bool,
    /// Fit once more without gross outliers, beside the ordinary fit.
    pub robust: bool,
}

impl Default for AnalysisOptions {
    fn default() -> Self {
        Self {
            statistic: Statistic::OverlappingAllan,
            further: Vec::new(),
            deviation: DeviationOptions::default(),
            fit: FitOptions::default(),
            gaps: Gaps::default(),
            detrend: Detrend::None,
            disturbance_false_alarm_rate: 1e-4,
            segment: None,
            windows: 0,
            separate: false,
            robust: false,
        }
    }
}

/// One point of the spectrum of the whole record: neighbouring cosines together, as the likelihood sees them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SpectrumPoint {
    /// Centre of the bin in Hz.
    pub frequency: f64,
    /// One-sided density, U²/Hz.
    pub density: f64,
    /// Its limits at the probability of the curve.
    pub interval: Option<(f64, f64)>,
    /// Density of the fitted model, where there is one.
    pub model: Option<f64>,
}

/// One coefficient in every unit in use.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TermUnits {
    /// Which.
    pub term: Term,
    /// The value in each unit.
    pub units: Vec<InUnit>,
}

/// What was found of one channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ChannelAnalysis {
    /// Name of the channel.
    pub name: String,
    /// Unit of the samples.
    pub unit: String,
    /// Samples analysed.
    pub samples: usize,
    /// Mean, U.
    pub mean: f64,
    /// Standard deviation, U.
    pub standard_deviation: f64,
    /// Least-squares straight line through the record, for the time plot.
    pub trend: Trend,
    /// The stability curve.
    pub curve: Option<DeviationCurve>,
    /// The curves of further statistics, in the order asked for.
    pub further: Vec<DeviationCurve>,
    /// The curve of the main statistic without what follows the temperature, where a sensitivity to it is given, and without courses
    /// that were found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compensated: Option<DeviationCurve>,
    /// The curve over time, where windows were asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub windows: Vec<DynamicWindow>,
    /// The fitted noise as states of a filter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub states: Option<StateSpace>,
    /// Welch density with its confidence.
    pub density: Option<Density>,
    /// Spectrum of the whole record in few bins, for the plot over all frequencies.
    pub spectrum: Vec<SpectrumPoint>,
    /// Coefficients by maximum likelihood on the spectrum.
    pub whittle: Option<CoefficientFit>,
    /// The fit without gross outliers, where that was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robust: Option<RobustFit>,
    /// The fitted model beside the curve; beside the compensated one where there is one.
    pub fitted: Vec<FittedPoint>,
    /// The coefficients given as values, in every unit in use.
    pub units: Vec<TermUnits>,
    /// Q and R of a Kalman filter at this sample rate.
    pub kalman: Option<KalmanNoise>,
    /// Allan variance directly and through the density.
    pub consistency: Vec<ConsistencyPoint>,
    /// Steps, bursts and spikes; samples and seconds count from the first row analysed, missing samples included.
    pub disturbances: Vec<Disturbance>,
    /// What all of them together add to the Allan variance, in the stretch where they add most.
    pub(crate) joint_influence: Option<JointInfluence>,
    /// What the converter leaves in the samples.
    pub(crate) converter: Vec<ConverterTrace>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl ChannelAnalysis {
    /// What the compensated curve is without, in words: `temperature`, `temperature and step`.
    pub fn taken_off(&self) -> String {
        let mut words: Vec<&str> = Vec::new();
        let fit = self.whittle.as_ref();
        let follows = fit.and_then(|f| f.temperature.as_ref()?.taken_off());
        if follows.is_some() {
            words.push("temperature");
        }
        for course in fit.iter().flat_map(|f| &f.courses) {
            let word = match course.shape {
                CourseShape::Exponential { .. } => "warm-up",
                CourseShape::Step { .. } => "step",
                CourseShape::DayCycle => "cycle of the day",
            };
            if !words.contains(&word) {
                words.push(word);
            }
        }
        match words.split_last() {
            Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
            _ => words.concat(),
        }
    }
}

/// What was found of a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Analysis {
    /// Samples per second.
    pub sample_rate: f64,
    /// First row analysed and one past the last.
    pub rows: (usize, usize),
    /// Samples averaged into one before spectrum, coefficients and disturbances were sought; 1 but for a
    /// [`LongRecord`](crate::LongRecord).
    pub averaged: usize,
    /// The stretches analysed, rows from and one past the last.
    pub stretches: Vec<(usize, usize)>,
    /// Interruptions of the record.
    pub gaps: Vec<RecordGap>,
    /// One entry per channel.
    pub channels: Vec<ChannelAnalysis>,
    /// The noise of three sensors by themselves, where that was asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub separated: Vec<SeparatedPoint>,
    /// What concerns all channels.
    pub findings: Vec<Finding>,
}

/// Noise analysis of a sensor at rest: the stability curve, the density, the coefficients two ways, their agreement,
/// and disturbances.
///
/// `stamps` (s), when given, are compared with the line of an even clock; rows with a missing value and lost samples
/// are gaps, handled as `options.gaps` says and never bridged; jitter interrupts nothing. A channel that cannot be analysed (constant) gets a
/// finding and empty results; the others are unaffected.
///
/// **Units** samples in the channel's unit (SI), `sample_rate` in Hz.
///
/// **Errors** [`Error::Length`] for channels of different length, [`Error::TooFew`] below ten usable samples,
/// [`Error::OutOfRange`] for a sample rate, a probability, or a chosen τ beyond the record; under [`Gaps::Refuse`] those
/// of the first gap.
///
/// ```
/// use proofmass_noise::{analyse, simulate, AnalysisOptions, NoiseChannel, NoiseModel, Sensor, Term};
/// use rand::SeedableRng;
///
/// let truth = NoiseModel { white: 1.0e-3, ..Default::default() };
/// let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(4);
/// let rate = simulate(&truth, 20_000, 100.0, &mut rng).unwrap();
/// let channel = NoiseChannel { name: "x", sensor: Some(Sensor::Accelerometer), unit: "m/s²", rate: &rate };
/// let analysis = analyse(&[channel], None, 100.0, &AnalysisOptions::default()).unwrap();
/// let fit = analysis.channels[0].whittle.as_ref().unwrap();
/// assert!((fit.value(Term::White).unwrap() / 1.0e-3 - 1.0).abs() < 0.03);
/// assert_eq!(fit.value(Term::RandomWalk), None); // not identifiable: no number
/// ```
pub fn analyse(
    channels: &[NoiseChannel<'_>],
    stamps: Option<&[f64]>,
    sample_rate: f64,
    options: &AnalysisOptions,
) -> Result<Analysis, Error> {
    analyse_watched(channels, stamps, sample_rate, options, &Unwatched)
}

/// [`analyse`] with an onlooker who is told how far it is and may stop it.
///
/// **Errors** as [`analyse`], and [`Error::Cancelled`].
pub fn analyse_watched(
    channels: &[NoiseChannel<'_>],
    stamps: Option<&[f64]>,
    sample_rate: f64,
    options: &AnalysisOptions,
    watch: &dyn Watch,
) -> Result<Analysis, Error> {
    analyse_beside_temperature(channels, None, stamps, sample_rate, options, watch)
}

/// [`analyse_watched`] of channels with the temperature that was recorded beside them, K or °C, one value a row.
///
/// How each channel follows the temperature is fitted together with its noise ([`whittle_record`](crate::whittle_record)). Where a
/// sensitivity is given, spectrum, disturbances and the fitted model are those of the record without it, and the curve stands
/// twice: as recorded, and compensated. A missing temperature (NaN) is a gap.
///
/// **Errors** as [`analyse_watched`]; [`Error::OutOfRange`] for a temperature that never changes.
pub fn analyse_beside_temperature(
    channels: &[NoiseChannel<'_>],
    temperature: Option<&[f64]>,
    stamps: Option<&[f64]>,
    sample_rate: f64,
    options: &AnalysisOptions,
    watch: &dyn Watch,
) -> Result<Analysis, Error> {
    let mut rates: Vec<&[f64]> = channels.iter().map(|c| c.rate).collect();
    if let Some(temperature) = temperature {
        let mut known = temperature.iter().filter(|t| !t.is_nan());
        let first = known.next().copied().unwrap_or(0.0);
        if known.all(|t| *t == first) {
            return Err(Error::OutOfRange {
                name: "range of a temperature that never changes, K",
                value: 0.0,
                min: f64::MIN_POSITIVE,
                max: f64::MAX,
            });
        }
        rates.push(temperature);
    }
    let (runs, gaps) = gaps::stretches(&rates, stamps, sample_rate)?;
    let rows = (
        runs.first().map_or(0, |r| r.0),
        runs.last().map_or(0, |r| r.1),
    );
    let chosen = gaps::choose(options.gaps, runs, &gaps)?;
    let longest = chosen.iter().map(|r| r.1 - r.0).max().unwrap_or(0);
    check_count(
        "samples without a gap between them",
        longest,
        FEWEST_SAMPLES,
    )?;
    // A wrong request is an error of the call, not a finding of each channel.
    for &statistic in std::iter::once(&options.statistic).chain(&options.further) {
        options
            .deviation
            .taus
            .factors(statistic, longest + 1, sample_rate)?;
    }
    proofmass_core::check::probability(options.deviation.probability)?;
    options.fit.check(sample_rate)?;

    let mut findings = Vec::new();
    let total = rates.first().map_or(0, |r| r.len());
    if !gaps.is_empty() {
        findings.push(gap_finding(&gaps, &chosen, total, options.gaps));
    }
    findings.extend(stamps.and_then(|s| stamp_finding(s, sample_rate)));
    // Places of the stretches on the sampling clock, missing samples counted.
    let starts: Vec<usize> = chosen
        .iter()
        .map(|run| {
            let lost: usize = gaps
                .iter()
                .filter(|g| g.row <= run.0 && g.kind != crate::GapKind::Missing)
                .map(|g| g.rows)
                .sum();
            run.0 - rows.0 + lost
        })
        .collect();
    // Four steps for each channel.
    let steps = Steps::new(watch, "noise of the channels", 4 * channels.len() as u64);
    steps.check()?;
    let separated = separate(
        &rates[..channels.len()],
        &chosen,
        sample_rate,
        options,
        &steps,
    )?;
    let channels = channels
        .par_iter()
        .map(|c| {
            let stretches: Vec<&[f64]> = chosen.iter().map(|r| &c.rate[r.0..r.1]).collect();
            let beside: Option<Vec<&[f64]>> =
                temperature.map(|t| chosen.iter().map(|r| &t[r.0..r.1]).collect());
            let record = FitRecord {
                stretches: &stretches,
                starts: &starts,
                temperature: beside.as_deref(),
            };
            analyse_channel(c, &record, sample_rate, options, &steps)
        })
        .collect::<Result<Vec<_>, Error>>()?;
    Ok(Analysis {
        sample_rate,
        rows: if options.gaps == Gaps::LongestStretch {
            chosen.first().copied().unwrap_or(rows)
        } else {
            rows
        },
        averaged: 1,
        stretches: chosen,
        gaps,
        channels,
        separated,
        findings,
    })
}

/// Three channels by themselves, over the longest stretch.
fn separate(
    rates: &[&[f64]],
    chosen: &[(usize, usize)],
    sample_rate: f64,
    options: &AnalysisOptions,
    steps: &Steps<'_>,
) -> Result<Vec<SeparatedPoint>, Error> {
    if !options.separate {
        return Ok(Vec::new());
    }
    let Some((from, to)) = chosen.iter().copied().max_by_key(|r| r.1 - r.0) else {
        return Ok(Vec::new());
    };
    let none = vec![0.0; to - from];
    let three = match *rates {
        [a, b, c] => [&a[from..to], &b[from..to], &c[from..to]],
        [a, b] => [&a[from..to], &b[from..to], &none[..]],
        _ => {
            return Err(Error::Length {
                name: "channels to be separated",
                expected: 3,
                got: rates.len(),
            });
        }
    };
    separated(three, sample_rate, &options.deviation, steps)
}

fn gap_finding(gaps: &[RecordGap], used: &[(usize, usize)], total: usize, policy: Gaps) -> Finding {
    let rows: usize = used.iter().map(|r| r.1 - r.0).sum();
    let (severity, treatment) = match policy {
        Gaps::LongestStretch => (Severity::Warning, ": only the longest stretch was analysed"),
        _ => (Severity::Note, ": no statistic reaches across a gap"),
    };
    let number = match gaps.len() {
        1 => "1 gap".to_owned(),
        n => format!("{n} gaps"),
    };
    let evidence = format!(
        "{number}, the first at row {}; {rows} of {total} rows used",
        gaps[0].row
    );
    let remedy = "averaging times longer than the segments between gaps are lost";
    proofmass_uncertainty::findings::gaps_in_record(treatment, &evidence, remedy).at(severity)
}

/// Jitter, or a rate that is not the stated one.
fn stamp_finding(stamps: &[f64], sample_rate: f64) -> Option<Finding> {
    let finite: Vec<f64> = stamps.iter().copied().filter(|t| t.is_finite()).collect();
    let (clock, _) = clock::read(&finite, Some(sample_rate)).ok()?;
    if (clock.rate_hz / sample_rate - 1.0).abs() > 1e-3 {
        return Some(findings::rate_contradicts_stamps(
            clock.rate_hz,
            clock.rate_u_hz,
            sample_rate,
        ));
    }
    let jitter = clock.scatter_s * clock.rate_hz;
    (jitter > 0.1).then(|| {
        proofmass_uncertainty::findings::uneven_stamps(
            "they scatter about the line of an even clock; the samples are taken as even",
            &format!(
                "by {:.0} % of the sampling interval; {} samples lost by the line",
                100.0 * jitter,
                clock.missing
            ),
            "this is usual where a computer stamps on arrival; if the sampling itself jitters, frequencies near half the rate are blurred",
        )
    })
}
