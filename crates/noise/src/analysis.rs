//! The whole noise analysis of a record at rest: curve, density, coefficients, and what to doubt.

use crate::coefficients::figure;
use crate::record::check_count;
use crate::spectrum_bins::SpectrumBins;
use crate::{
    CoefficientFit, ConsistencyPoint, DeviationCurve, DeviationOptions, Disturbance,
    DisturbanceKind, FitOptions, Gap, Gaps, InUnit, KalmanNoise, Record, Sensor, Statistic, Term,
    chi_square_interval, consistency, deviation, disturbances, gaps, in_units, kalman_noise,
    whittle,
};
use proofmass_core::Error;
use proofmass_signal::{Density, Detrend, Trend, Welch};
use proofmass_uncertainty::{Finding, Severity};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Fewest samples of which a stability is computed at all.
const FEWEST_SAMPLES: usize = 10;

/// One channel of a recording.
#[derive(Clone, Copy, Debug)]
pub struct Channel<'a> {
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
pub struct AnalysisOptions {
    /// Statistic of the curve.
    pub statistic: Statistic,
    /// Further statistics, each with a curve of its own.
    pub further: Vec<Statistic>,
    /// Averaging times, probability, bias.
    pub deviation: DeviationOptions,
    /// Terms sought and how strictly; its unit is replaced by each channel's.
    pub fit: FitOptions,
    /// What is done about gaps.
    pub gaps: Gaps,
    /// Trend removed before the curve and the fits. The default removes nothing: drift is part of what a curve shows.
    pub detrend: Detrend,
    /// Probability that a record without a disturbance is reported to have one, per channel.
    pub disturbance_false_alarm_rate: f64,
    /// Samples per segment of the Welch density; chosen from the record when `None` (at most 4096).
    pub segment: Option<usize>,
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
        }
    }
}

/// One point of the spectrum of the whole record: a multitaper estimate averaged over a tenth of its frequency.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpectrumPoint {
    /// Centre of the bin in Hz.
    pub frequency: f64,
    /// One-sided density, U²/Hz.
    pub density: f64,
    /// Its limits at the probability of the curve.
    pub interval: Option<(f64, f64)>,
}

/// One coefficient in every unit in use.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TermUnits {
    /// Which.
    pub term: Term,
    /// The value in each unit.
    pub units: Vec<InUnit>,
}

/// What was found of one channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Welch density with its confidence.
    pub density: Option<Density>,
    /// Multitaper spectrum of the whole record in few bins, for the plot over all frequencies.
    pub spectrum: Vec<SpectrumPoint>,
    /// Coefficients by maximum likelihood on the spectrum: the ones to use.
    pub whittle: Option<CoefficientFit>,
    /// The identified coefficients in every unit in use.
    pub units: Vec<TermUnits>,
    /// Q and R of a Kalman filter at this sample rate.
    pub kalman: Option<KalmanNoise>,
    /// Allan variance directly and through the density.
    pub consistency: Vec<ConsistencyPoint>,
    /// Steps, bursts and spikes.
    pub disturbances: Vec<Disturbance>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

/// What was found of a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Analysis {
    /// Samples per second.
    pub sample_rate: f64,
    /// First row analysed and one past the last.
    pub rows: (usize, usize),
    /// Samples averaged into one before spectrum, coefficients and disturbances were sought; 1 but for a
    /// [`LongRecord`](crate::LongRecord).
    pub averaged: usize,
    /// Interruptions of the record.
    pub gaps: Vec<Gap>,
    /// One entry per channel.
    pub channels: Vec<ChannelAnalysis>,
    /// What concerns all channels.
    pub findings: Vec<Finding>,
}

/// Noise analysis of a sensor at rest: the stability curve, the density, the coefficients two ways, their agreement,
/// and disturbances.
///
/// `stamps` (s), when given, are checked against `sample_rate`; rows with a missing value and jumps of the stamps
/// are gaps, handled as `options.gaps` says and never bridged. A channel that cannot be analysed (constant) gets a
/// finding and empty results; the others are unaffected.
///
/// **Units** samples in the channel's unit (SI), `sample_rate` in Hz.
///
/// **Errors** [`Error::Length`] for channels of different length, [`Error::TooFew`] below ten usable samples,
/// [`Error::OutOfRange`] for a sample rate, a probability, or a chosen τ beyond the record; under [`Gaps::Refuse`] those
/// of the first gap.
///
/// ```
/// use proofmass_noise::{analyse, simulate, AnalysisOptions, Channel, NoiseModel, Sensor, Term};
/// use rand::SeedableRng;
///
/// let truth = NoiseModel { white: 1.0e-3, ..Default::default() };
/// let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(4);
/// let rate = simulate(&truth, 20_000, 100.0, &mut rng).unwrap();
/// let channel = Channel { name: "x", sensor: Some(Sensor::Accelerometer), unit: "m/s²", rate: &rate };
/// let analysis = analyse(&[channel], None, 100.0, &AnalysisOptions::default()).unwrap();
/// let fit = analysis.channels[0].whittle.as_ref().unwrap();
/// assert!((fit.value(Term::White).unwrap() / 1.0e-3 - 1.0).abs() < 0.03);
/// assert_eq!(fit.value(Term::RandomWalk), None); // not identifiable: no number
/// ```
pub fn analyse(
    channels: &[Channel<'_>],
    stamps: Option<&[f64]>,
    sample_rate: f64,
    options: &AnalysisOptions,
) -> Result<Analysis, Error> {
    let rates: Vec<&[f64]> = channels.iter().map(|c| c.rate).collect();
    let (runs, gaps) = gaps::stretches(&rates, stamps, sample_rate)?;
    let rows = gaps::choose(options.gaps, &runs, &gaps)?;
    check_count(
        "rate samples without a gap",
        rows.1 - rows.0,
        FEWEST_SAMPLES,
    )?;
    // A wrong request is an error of the call, not a finding of each channel.
    for &statistic in std::iter::once(&options.statistic).chain(&options.further) {
        let points = rows.1 - rows.0 + 1;
        options
            .deviation
            .taus
            .factors(statistic, points, sample_rate)?;
    }
    crate::deviation::check_probability(options.deviation.probability)?;

    let mut findings = Vec::new();
    let total = rates.first().map_or(0, |r| r.len());
    if !gaps.is_empty() {
        findings.push(
            Finding::new(
                Severity::Warning,
                "gaps-in-record",
                "the record is interrupted; only its longest stretch was analysed",
            )
            .evidence(format!(
                "{} gaps, the first at row {}; rows {} to {} of {} used",
                gaps.len(),
                gaps[0].row,
                rows.0,
                rows.1,
                total
            ))
            .advice("look for lost packets or a logger that pauses"),
        );
    }
    findings.extend(stamps.and_then(|s| stamp_finding(&s[rows.0..rows.1], sample_rate)));
    let channels = channels
        .par_iter()
        .map(|c| analyse_channel(c, &c.rate[rows.0..rows.1], sample_rate, options))
        .collect::<Result<Vec<_>, Error>>()?;
    Ok(Analysis {
        sample_rate,
        rows,
        averaged: 1,
        gaps,
        channels,
        findings,
    })
}

/// Jitter or a mean rate that is not the stated one.
fn stamp_finding(stamps: &[f64], sample_rate: f64) -> Option<Finding> {
    let n = stamps.len();
    if n < 3 {
        return None;
    }
    let measured = (n as f64 - 1.0) / (stamps[n - 1] - stamps[0]);
    let off = (measured / sample_rate - 1.0).abs();
    let interval = 1.0 / measured;
    let jitter = (stamps
        .windows(2)
        .map(|w| (w[1] - w[0] - interval).powi(2))
        .sum::<f64>()
        / (n as f64 - 1.0))
        .sqrt()
        * measured;
    (off > 1e-3 || jitter > 0.1).then(|| {
        Finding::new(
            Severity::Warning,
            "uneven-time-stamps",
            "the time stamps do not follow the stated sample rate evenly",
        )
        .evidence(format!(
            "mean rate {measured:.6} Hz against {sample_rate} Hz stated, jitter {:.1} % of the interval",
            100.0 * jitter
        ))
        .advice("densities scale with the true rate; state the measured one if it is stable")
    })
}

fn analyse_channel(
    channel: &Channel<'_>,
    rate: &[f64],
    sample_rate: f64,
    options: &AnalysisOptions,
) -> Result<ChannelAnalysis, Error> {
    let n = rate.len() as f64;
    let mut detrended = rate.to_vec();
    let trend = Detrend::Linear.remove(&mut detrended, sample_rate)?;
    let variance = rate.iter().map(|y| (y - trend.mean).powi(2)).sum::<f64>() / (n - 1.0);
    let mut result = ChannelAnalysis {
        name: channel.name.to_owned(),
        unit: channel.unit.to_owned(),
        samples: rate.len(),
        mean: trend.mean,
        standard_deviation: variance.sqrt(),
        trend,
        curve: None,
        further: Vec::new(),
        density: None,
        spectrum: Vec::new(),
        whittle: None,
        units: Vec::new(),
        kalman: None,
        consistency: Vec::new(),
        disturbances: Vec::new(),
        findings: Vec::new(),
    };
    if rate.iter().all(|y| *y == rate[0]) {
        result.findings.push(
            Finding::new(
                Severity::Decision,
                "constant-channel",
                "the channel does not vary: it has no noise to describe",
            )
            .evidence(format!("all {} samples are {}", rate.len(), rate[0]))
            .advice("check that the channel is connected and its range not saturated"),
        );
        return Ok(result);
    }
    let mut prepared = rate.to_vec();
    options.detrend.remove(&mut prepared, sample_rate)?;

    result.curve = Some(deviation(
        Record::Rate(&prepared),
        sample_rate,
        options.statistic,
        &options.deviation,
    )?);
    result.further = options
        .further
        .iter()
        .map(|&s| deviation(Record::Rate(&prepared), sample_rate, s, &options.deviation))
        .collect::<Result<_, Error>>()?;
    let mut fit_options = options.fit.clone();
    channel.unit.clone_into(&mut fit_options.unit);
    result.whittle = outcome(
        whittle(&prepared, sample_rate, &fit_options),
        &mut result.findings,
    );

    let probability = options.deviation.probability;
    let bins = SpectrumBins::new(detrended, sample_rate);
    result.spectrum = bins
        .bins
        .iter()
        .map(|b| SpectrumPoint {
            frequency: bins.frequency(0.5 * (b.range.0 + b.range.1 - 1) as f64),
            density: b.mean,
            // The interval of a deviation, squared, is that of its square.
            interval: chi_square_interval(b.mean.sqrt(), b.dof, probability)
                .map(|(low, high)| (low * low, high * high)),
        })
        .collect();
    densities(&prepared, sample_rate, options, &mut result)?;

    match disturbances(&prepared, sample_rate, options.disturbance_false_alarm_rate) {
        Ok(found) => result.disturbances = found,
        Err(Error::TooFew { .. }) => {}
        Err(error) => return Err(error),
    }
    result
        .findings
        .extend(disturbance_findings(&result.disturbances, options));
    if let Some(fit) = &result.whittle {
        result.kalman = Some(kalman_noise(&fit.model, sample_rate)?);
        if let Some(sensor) = channel.sensor {
            result.units = fit
                .coefficients
                .iter()
                .filter_map(|c| {
                    let value = c.verdict.value()?;
                    Some(TermUnits {
                        term: c.term,
                        units: in_units(c.term, value, sensor, sample_rate),
                    })
                })
                .collect();
        }
    }
    Ok(result)
}

/// A fit, or a finding that says why there is none.
fn outcome(
    fit: Result<CoefficientFit, Error>,
    findings: &mut Vec<Finding>,
) -> Option<CoefficientFit> {
    match fit {
        Ok(fit) => {
            findings.extend(fit.findings.iter().cloned());
            Some(fit)
        }
        Err(error) => {
            findings.push(
                Finding::new(
                    Severity::Warning,
                    "no-coefficients",
                    "coefficients could not be estimated",
                )
                .evidence(error.to_string())
                .advice("record longer"),
            );
            None
        }
    }
}

/// Welch density for the result, a finer one for the comparison with the Allan curve.
fn densities(
    rate: &[f64],
    sample_rate: f64,
    options: &AnalysisOptions,
    result: &mut ChannelAnalysis,
) -> Result<(), Error> {
    let longest = (rate.len() / 8).max(4);
    let power_of_two = |n: usize| 1_usize << n.max(1).ilog2();
    let segment = options
        .segment
        .unwrap_or_else(|| power_of_two(longest.min(4096)));
    result.density = Some(Welch::new(segment).density(rate, sample_rate)?);
    let fine = power_of_two(longest.min(65_536));
    if let Some(curve) = &result.curve
        && fine >= 64
    {
        // Straight lines are removed piecewise: a walk leaks less.
        let welch = Welch {
            detrend: Detrend::Linear,
            ..Welch::new(fine)
        };
        result.consistency = consistency(&welch.density(rate, sample_rate)?, curve);
        let worst = result
            .consistency
            .iter()
            .filter(|p| (p.ratio() - 1.0).abs() > 0.1 + 4.0 * p.relative_uncertainty)
            .max_by(|a, b| (a.ratio() - 1.0).abs().total_cmp(&(b.ratio() - 1.0).abs()));
        if let Some(p) = worst {
            result.findings.push(
                Finding::new(
                    Severity::Warning,
                    "density-and-allan-differ",
                    "the Allan variance does not follow from the density",
                )
                .evidence(format!("ratio {:.3} at τ = {} s", p.ratio(), figure(p.tau)))
                .advice("the record is not stationary: look at the time plot for a disturbance"),
            );
        }
    }
    Ok(())
}

/// Spikes everywhere are a property of the sensor; what moves the curve needs a decision, the rest a look.
fn disturbance_findings(found: &[Disturbance], options: &AnalysisOptions) -> Vec<Finding> {
    let quiet_spike = |d: &&Disturbance| d.kind == DisturbanceKind::Spike && d.displacement < 3.0;
    let spikes = found.iter().filter(quiet_spike).count();
    let mut findings = Vec::new();
    if spikes > 0 {
        findings.push(
            Finding::new(
                if spikes > 3 { Severity::Note } else { Severity::Warning },
                "isolated-spikes",
                "single samples lie further out than Gaussian noise allows",
            )
            .evidence(format!("{spikes} samples; none of them moves the Allan curve"))
            .advice("many of them over the whole record mean noise with heavy tails, few of them lost bits"),
        );
    }
    let mut rest: Vec<&Disturbance> = found.iter().filter(|d| !quiet_spike(d)).collect();
    rest.sort_by(|a, b| b.displacement.total_cmp(&a.displacement));
    let Some(worst) = rest.first() else {
        return findings;
    };
    let decisive = worst.displacement >= 3.0;
    findings.push(
        Finding::new(
            if decisive { Severity::Decision } else { Severity::Warning },
            if decisive { "disturbance" } else { "weak-disturbance" },
            if decisive {
                "the record is disturbed: something other than noise happened, and the curve shows it"
            } else {
                "something other than noise happened, too little to move the curve"
            },
        )
        .evidence(format!(
            "{} places; the worst a {} from {:.2} s to {:.2} s, {:.1} robust standard deviations where {:.1} occur by chance in one record of {:.0}; it raises the Allan variance by up to {:.1} %, {:.1} times its standard uncertainty",
            rest.len(),
            match worst.kind {
                DisturbanceKind::Step => "step",
                DisturbanceKind::Burst => "burst",
                DisturbanceKind::Lull => "lull",
                DisturbanceKind::Spike => "spike",
            },
            worst.seconds.0,
            worst.seconds.1,
            worst.strength,
            worst.threshold,
            1.0 / options.disturbance_false_alarm_rate,
            100.0 * worst.influence,
            worst.displacement,
        ))
        .advice("cut the record there and analyse the longer part; coefficients of a disturbed record describe the disturbance"),
    );
    findings
}
