//! A stability curve: a statistic at chosen averaging times, each with its interval.

use crate::bias;
use crate::curve_model::CurveModel;
use crate::noise_type::{self, NoiseBasis};
use crate::overlapping::{overlapping, overlapping_family};
use crate::phase::Phase;
use crate::record::NoiseRecord;
use crate::steps::Steps;
use crate::{
    Bias, EdfFormula, NoiseType, Statistic, Taus, allan, chi_square_interval, equivalent_dof,
    hadamard, parabolic, theo, total,
};
use proofmass_core::{Error, Watch};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How a curve is computed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DeviationOptions {
    /// Averaging times.
    pub taus: Taus,
    /// Probability of the intervals; 0.95 by default (clock tables use 0.683).
    pub probability: f64,
    /// Noise type for bias and degrees of freedom; identified, and the degrees of freedom modelled, when `None`.
    pub noise: Option<NoiseType>,
    /// Correction of known biases.
    pub bias: Bias,
    /// Formulas for the degrees of freedom of the total family.
    pub edf: EdfFormula,
}

impl Default for DeviationOptions {
    fn default() -> Self {
        Self {
            taus: Taus::Octave,
            probability: 0.95,
            noise: None,
            bias: Bias::default(),
            edf: EdfFormula::default(),
        }
    }
}

/// The statistic at one averaging time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct DeviationPoint {
    /// Averaging factor m.
    pub factor: usize,
    /// Effective averaging time in seconds.
    pub tau: f64,
    /// The deviation, in the unit of the rate (times s for the time deviations).
    pub deviation: f64,
    /// Number of terms averaged.
    pub terms: usize,
    /// Noise type that rules at this τ.
    pub noise: NoiseType,
    /// What the noise type rests on.
    pub basis: NoiseBasis,
    /// Equivalent degrees of freedom, where a formula exists.
    pub edf: Option<f64>,
    /// Lower and upper limit at the chosen probability, where degrees of freedom exist.
    pub interval: Option<(f64, f64)>,
}

/// A statistic against averaging time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct DeviationCurve {
    /// Which statistic.
    pub statistic: Statistic,
    /// Samples per second.
    pub sample_rate: f64,
    /// Phase points the record has (one more than rate samples).
    pub phase_points: usize,
    /// Probability of the intervals.
    pub probability: f64,
    /// The points, in the order of the averaging times asked for.
    pub points: Vec<DeviationPoint>,
}

/// A stability statistic of evenly spaced data, with χ² intervals.
///
/// σ(τ) by the formula of the chosen [`Statistic`]; interval σ√(ν/χ²) with equivalent degrees of freedom ν. Unless a noise
/// type is given, ν is that of a noise model fitted to the record itself: for OADEV 2σ⁴/Var with the covariance of all
/// its differences, for the others the published degrees of freedom of each term, weighed by its share in the
/// variance. The noise type stated at each τ is a label, and serves for bias corrections.
///
/// **Units** deviation in the unit of the rate (of the phase for the time deviations), τ in s, `sample_rate` in Hz.
///
/// **Assumes** even sampling without gaps ([`deviation_stretches`] takes them), Gaussian noise.
///
/// **Errors** [`Error::NotFinite`] for NaN, [`Error::TooFew`] for a record the statistic cannot be computed from,
/// [`Error::OutOfRange`] for a chosen τ beyond the record.
///
/// **Accuracy** printed digits of the Stable32 tables of PHASE.DAT at every τ, intervals within 1 %
/// (`published_phase_dat_…`); intervals hold in 93 to 98 % of simulated records at every octave
/// (`coverage_of_curve_intervals`).
///
/// **Source** `[SP1065]`, `[GR2003]`, `[RG2004]`.
///
/// ```
/// use proofmass_noise::{deviation, DeviationOptions, NoiseRecord, Statistic, Taus};
///
/// // The nine NBS frequency values, `[SP1065]` 12.2.
/// let rate = [892.0, 809.0, 823.0, 798.0, 671.0, 644.0, 883.0, 903.0, 677.0];
/// let options = DeviationOptions { taus: Taus::Factors(vec![1, 2]), ..Default::default() };
/// let curve = deviation(NoiseRecord::Rate(&rate), 1.0, Statistic::OverlappingAllan, &options).unwrap();
/// assert!((curve.points[0].deviation - 91.22945).abs() < 5e-6);
/// assert!((curve.points[1].deviation - 85.95287).abs() < 5e-6);
/// ```
pub fn deviation(
    record: NoiseRecord<'_>,
    sample_rate: f64,
    statistic: Statistic,
    options: &DeviationOptions,
) -> Result<DeviationCurve, Error> {
    deviation_stretches(&[record], sample_rate, statistic, options)
}

/// [`deviation`] with an onlooker who may stop it: every averaging time of a long record takes its time.
///
/// **Errors** as [`deviation`], and [`Error::Cancelled`].
///
/// ```
/// use proofmass_core::Unwatched;
/// use proofmass_noise::{DeviationOptions, NoiseRecord, Statistic, deviation_watched};
///
/// let rate = [892.0, 809.0, 823.0, 798.0, 671.0, 644.0, 883.0, 903.0, 677.0];
/// let (record, options) = (NoiseRecord::Rate(&rate), DeviationOptions::default());
/// let curve = deviation_watched(record, 1.0, Statistic::OverlappingAllan, &options, &Unwatched)?;
/// assert!((curve.points[0].deviation - 91.22945).abs() < 5e-6);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
pub fn deviation_watched(
    record: NoiseRecord<'_>,
    sample_rate: f64,
    statistic: Statistic,
    options: &DeviationOptions,
    watch: &dyn Watch,
) -> Result<DeviationCurve, Error> {
    let steps = Steps::new(watch, "stability of the signal", 0);
    curve_of(&[record], sample_rate, statistic, options, None, &steps)
}

/// The overlapping Allan deviation of a signal, a point to every octave of the averaging time.
///
/// **Units** `sampling_rate` in Hz; the deviation in the unit of the samples.
///
/// **Errors** as [`deviation`].
///
/// ```
/// use proofmass_noise::allan_deviation;
///
/// let gyro: Vec<f64> = (0..4096).map(|k| f64::from(k * 7919 % 4093) / 4093.0 - 0.5).collect();
/// for p in allan_deviation(&gyro, 100.0)?.points {
///     println!("{} s: {:.3e}, 95 %: {:?}", p.tau, p.deviation, p.interval);
/// }
/// # Ok::<(), proofmass_core::Error>(())
/// ```
pub fn allan_deviation(samples: &[f64], sampling_rate: f64) -> Result<DeviationCurve, Error> {
    deviation(
        NoiseRecord::Rate(samples),
        sampling_rate,
        Statistic::OverlappingAllan,
        &DeviationOptions::default(),
    )
}

/// [`deviation`] of a record with gaps: no difference reaches across one, every stretch long enough contributes its terms.
///
/// Averaging times are those that the longest stretch can give.
///
/// **Errors** as [`deviation`]; stretches too short for a phase are left out.
pub fn deviation_stretches(
    records: &[NoiseRecord<'_>],
    sample_rate: f64,
    statistic: Statistic,
    options: &DeviationOptions,
) -> Result<DeviationCurve, Error> {
    let steps = Steps::unwatched();
    curve_of(records, sample_rate, statistic, options, None, &steps)
}

/// The curve, with the degrees of freedom of a model already known.
pub(crate) fn curve_of(
    records: &[NoiseRecord<'_>],
    sample_rate: f64,
    statistic: Statistic,
    options: &DeviationOptions,
    known: Option<&CurveModel>,
    steps: &Steps<'_>,
) -> Result<DeviationCurve, Error> {
    proofmass_core::check::probability(options.probability)?;
    let several = records.len() > 1;
    let phases = records
        .iter()
        .filter(|r| {
            let fewest = if matches!(r, NoiseRecord::Rate(_)) {
                2
            } else {
                3
            };
            !several || r.len() >= fewest
        })
        .map(|r| match statistic {
            Statistic::OverlappingAllan => Phase::unread(*r, sample_rate),
            _ => Phase::new(*r, sample_rate),
        })
        .collect::<Result<Vec<_>, Error>>()?;
    let longest = phases.iter().max_by_key(|p| p.len()).ok_or(Error::TooFew {
        name: "rate samples",
        needed: 2,
        got: 0,
    })?;
    let n = longest.len();
    let factors = options.taus.factors(statistic, n, sample_rate)?;
    if statistic == Statistic::TheoHybrid {
        return hybrid(records, sample_rate, &factors, n, options, known, steps);
    }
    let parts: Vec<Squares> = phases
        .iter()
        .map(|phase| Squares::of(phase, statistic, &factors, options.bias, steps))
        .collect::<Result<_, Error>>()?;
    phases.iter().try_for_each(Phase::check_finite)?;
    let lengths: Vec<usize> = phases.iter().map(|p| p.len() - 1).collect();
    // A noise type that is given needs no model; otherwise the model gives the degrees of freedom of every τ.
    let fitted = match (options.noise, known) {
        (Some(_), _) | (_, Some(_)) => None,
        (None, None) => CurveModel::fit(&phases, sample_rate),
    };
    let model = known.or(fitted.as_ref());
    steps.check()?;
    let noises = identify(longest, statistic, &factors, options.noise, model, steps)?;
    let points = factors
        .par_iter()
        .enumerate()
        .zip(noises)
        .map(|((index, &m), (noise, basis))| {
            steps.check()?;
            let (mut sum, mut terms) = (0.0, 0);
            for part in &parts {
                if let Some((square, count)) = part.squares[index] {
                    sum += square * count as f64;
                    terms += count;
                }
            }
            let ratio = match options.bias {
                Bias::AsDefined => 1.0,
                Bias::FromRecord if statistic == Statistic::Theo1 => {
                    parts.iter().find_map(|p| p.ratio).unwrap_or(1.0)
                }
                _ => bias::ratio(statistic, noise, m, n),
            };
            let tau = statistic.tau(m, sample_rate);
            let scale = match statistic {
                Statistic::Time | Statistic::TimeTotal => tau / 3.0_f64.sqrt(),
                _ => 1.0,
            };
            let square = if parts.len() == 1 {
                parts[0].squares[index].map_or(0.0, |s| s.0)
            } else {
                sum / f64::max(terms as f64, 1.0)
            };
            let deviation = scale * (square / ratio).sqrt();
            let edf = match model {
                Some(model) if basis != NoiseBasis::Given => {
                    model.dof(statistic, m, &lengths, options.edf)
                }
                _ => equivalent_dof(statistic, noise, m, n, options.edf),
            };
            Ok(DeviationPoint {
                factor: m,
                tau,
                deviation,
                terms,
                noise,
                basis,
                edf,
                interval: edf
                    .and_then(|edf| chi_square_interval(deviation, edf, options.probability)),
            })
        })
        .collect::<Result<_, Error>>()?;
    Ok(DeviationCurve {
        statistic,
        sample_rate,
        phase_points: n,
        probability: options.probability,
        points,
    })
}

/// THEOH: OADEV up to a fifth of the record, beyond it THEO1 at 0.75 of an even factor, scaled to the Allan variance of the record.
///
/// **Source** `[SP1065] eq. 34`.
fn hybrid(
    records: &[NoiseRecord<'_>],
    sample_rate: f64,
    factors: &[usize],
    phase_points: usize,
    options: &DeviationOptions,
    known: Option<&CurveModel>,
    steps: &Steps<'_>,
) -> Result<DeviationCurve, Error> {
    let last = (phase_points - 1) / 5;
    let short: Vec<usize> = factors.iter().copied().filter(|m| *m <= last).collect();
    let mut long: Vec<usize> = factors
        .iter()
        .filter(|m| **m > last)
        .map(|m| 2 * (2 * m).div_ceil(3))
        .filter(|m| (10..phase_points).contains(m))
        .collect();
    long.dedup();
    let of = |statistic, factors: Vec<usize>, bias| {
        if factors.is_empty() {
            return Ok(Vec::new());
        }
        let options = DeviationOptions {
            taus: crate::Taus::Factors(factors),
            bias,
            ..options.clone()
        };
        curve_of(records, sample_rate, statistic, &options, known, steps).map(|c| c.points)
    };
    let mut points = of(Statistic::OverlappingAllan, short, options.bias)?;
    points.extend(of(Statistic::Theo1, long, Bias::FromRecord)?);
    Ok(DeviationCurve {
        statistic: Statistic::TheoHybrid,
        sample_rate,
        phase_points,
        probability: options.probability,
        points,
    })
}

/// Mean squares of one stretch at each factor, with their number of terms; `None` where it is too short.
struct Squares {
    squares: Vec<Option<allan::MeanSquare>>,
    /// Ratio of THEO1 to the Allan variance, when it is asked for.
    ratio: Option<f64>,
}

impl Squares {
    fn of(
        phase: &Phase<'_>,
        statistic: Statistic,
        factors: &[usize],
        bias: Bias,
        steps: &Steps<'_>,
    ) -> Result<Self, Error> {
        let (min, max) = statistic.factor_range(phase.len());
        let fits = |m: &usize| (min..=max).contains(m);
        let possible: Vec<usize> = factors.iter().copied().filter(fits).collect();
        let mut ratio = None;
        let found: Vec<_> = match statistic {
            Statistic::OverlappingAllan => overlapping_family(phase, &possible, steps),
            _ => {
                let points = phase.to_vec();
                if statistic == Statistic::Theo1 && bias == Bias::FromRecord {
                    ratio = bias::record_ratio(&points, steps);
                }
                possible
                    .par_iter()
                    .map(|&m| match steps.goes_on() {
                        true => mean_square(&points, statistic, m, steps),
                        false => (f64::NAN, 1),
                    })
                    .collect()
            }
        };
        steps.check()?;
        let mut found = found.into_iter();
        Ok(Self {
            squares: factors
                .iter()
                .map(|m| if fits(m) { found.next() } else { None })
                .collect(),
            ratio,
        })
    }
}

fn mean_square(
    phase: &[f64],
    statistic: Statistic,
    m: usize,
    steps: &Steps<'_>,
) -> allan::MeanSquare {
    match statistic {
        Statistic::Allan => allan::allan(phase, m),
        Statistic::OverlappingAllan | Statistic::TheoHybrid => overlapping(phase, m),
        Statistic::ModifiedAllan | Statistic::Time => allan::modified(phase, m),
        Statistic::Hadamard => hadamard::hadamard(phase, m),
        Statistic::OverlappingHadamard => hadamard::overlapping(phase, m),
        Statistic::Total => total::total(phase, m),
        Statistic::ModifiedTotal | Statistic::TimeTotal => total::modified_total(phase, m, steps),
        Statistic::HadamardTotal => total::hadamard_total(phase, m, steps),
        Statistic::Theo1 => theo::theo1(phase, m, steps),
        Statistic::Parabolic => parabolic::parabolic(phase, m),
    }
}

/// Noise type at each factor: by the lag-1 autocorrelation where enough averages are left, else the term that rules there
/// in the model of the record.
fn identify(
    phase: &Phase<'_>,
    statistic: Statistic,
    factors: &[usize],
    given: Option<NoiseType>,
    model: Option<&CurveModel>,
    steps: &Steps<'_>,
) -> Result<Vec<(NoiseType, NoiseBasis)>, Error> {
    if let Some(noise) = given {
        return Ok(vec![(noise, NoiseBasis::Given); factors.len()]);
    }
    let most_differences = match statistic {
        Statistic::Hadamard | Statistic::OverlappingHadamard | Statistic::HadamardTotal => 3,
        _ => 2,
    };
    let lowest = if most_differences == 3 { -4 } else { -2 };
    let at = |m: usize| {
        let alpha = noise_type::exponent(phase, m, most_differences)?.round();
        NoiseType::from_alpha((alpha as i32).clamp(lowest, 2))
    };
    factors
        .par_iter()
        .map(|&m| {
            steps.check()?;
            Ok(match (at(m), model) {
                (Some(noise), _) => (noise, NoiseBasis::Identified),
                (None, Some(model)) => (model.dominating(statistic, m), NoiseBasis::Model),
                (None, None) => (NoiseType::White, NoiseBasis::Assumed),
            })
        })
        .collect()
}
