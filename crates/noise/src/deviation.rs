//! A stability curve: a statistic at chosen averaging times, each with its interval.

use crate::bias;
use crate::noise_type::{self, NoiseBasis};
use crate::overlapping::{overlapping, overlapping_family};
use crate::phase::Phase;
use crate::record::Record;
use crate::{
    Bias, EdfFormula, NoiseType, Statistic, Taus, allan, chi_square_interval, equivalent_dof,
    hadamard, theo, total,
};
use proofmass_core::Error;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How a curve is computed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DeviationOptions {
    /// Averaging times.
    pub taus: Taus,
    /// Probability of the intervals; 0.95 by default (clock tables use 0.683).
    pub probability: f64,
    /// Noise type for bias and degrees of freedom; identified at each τ when `None`.
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
pub struct DeviationPoint {
    /// Averaging factor m.
    pub factor: usize,
    /// Effective averaging time in seconds.
    pub tau: f64,
    /// The deviation, in the unit of the rate (times s for the time deviations).
    pub deviation: f64,
    /// Number of terms averaged.
    pub terms: usize,
    /// Noise type used for bias and degrees of freedom.
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
/// σ(τ) by the formula of the chosen [`Statistic`]; interval σ√(ν/χ²) with the equivalent degrees of freedom ν for
/// the noise type identified at that τ.
///
/// **Units** deviation in the unit of the rate (of the phase for the time deviations), τ in s, `sample_rate` in Hz.
///
/// **Assumes** even sampling without gaps, Gaussian noise of one dominant power law at each τ.
///
/// **Errors** [`Error::NotFinite`] for NaN, [`Error::TooFew`] for a record the statistic cannot be computed from,
/// [`Error::OutOfRange`] for a chosen τ beyond the record.
///
/// **Accuracy** printed digits of the Stable32 tables of PHASE.DAT at every τ, intervals within 1 %
/// (`published_phase_dat_…`).
///
/// **Source** `[SP1065]`, `[GR2003]`, `[RG2004]`.
///
/// ```
/// use proofmass_noise::{deviation, DeviationOptions, Record, Statistic, Taus};
///
/// // The nine NBS frequency values, `[SP1065]` 12.2.
/// let rate = [892.0, 809.0, 823.0, 798.0, 671.0, 644.0, 883.0, 903.0, 677.0];
/// let options = DeviationOptions { taus: Taus::Factors(vec![1, 2]), ..Default::default() };
/// let curve = deviation(Record::Rate(&rate), 1.0, Statistic::OverlappingAllan, &options).unwrap();
/// assert!((curve.points[0].deviation - 91.22945).abs() < 5e-6);
/// assert!((curve.points[1].deviation - 85.95287).abs() < 5e-6);
/// ```
pub fn deviation(
    record: Record<'_>,
    sample_rate: f64,
    statistic: Statistic,
    options: &DeviationOptions,
) -> Result<DeviationCurve, Error> {
    check_probability(options.probability)?;
    let phase = Phase::new(record, sample_rate)?;
    let n = phase.len();
    let factors = options.taus.factors(statistic, n, sample_rate)?;
    let mut record_ratio = None;
    let squares: Vec<_> = match statistic {
        Statistic::OverlappingAllan => overlapping_family(&phase, &factors),
        _ => {
            let points = phase.to_vec();
            if statistic == Statistic::Theo1 && options.bias == Bias::FromRecord {
                record_ratio = bias::record_ratio(&points);
            }
            factors
                .par_iter()
                .map(|&m| mean_square(&points, statistic, m))
                .collect()
        }
    };
    let noises = identify(&phase, statistic, &factors, options.noise);
    let points = factors
        .iter()
        .zip(squares)
        .zip(noises)
        .map(|((&m, (square, terms)), (noise, basis))| {
            let ratio = match options.bias {
                Bias::AsDefined => 1.0,
                Bias::FromRecord if statistic == Statistic::Theo1 => record_ratio.unwrap_or(1.0),
                _ => bias::ratio(statistic, noise, m, n),
            };
            let tau = statistic.tau(m, sample_rate);
            let scale = match statistic {
                Statistic::Time | Statistic::TimeTotal => tau / 3.0_f64.sqrt(),
                _ => 1.0,
            };
            let deviation = scale * (square / ratio).sqrt();
            let edf = equivalent_dof(statistic, noise, m, n, options.edf);
            DeviationPoint {
                factor: m,
                tau,
                deviation,
                terms,
                noise,
                basis,
                edf,
                interval: edf
                    .and_then(|edf| chi_square_interval(deviation, edf, options.probability)),
            }
        })
        .collect();
    Ok(DeviationCurve {
        statistic,
        sample_rate,
        phase_points: n,
        probability: options.probability,
        points,
    })
}

pub(crate) fn check_probability(probability: f64) -> Result<(), Error> {
    if probability > 0.0 && probability < 1.0 {
        Ok(())
    } else {
        Err(Error::OutOfRange {
            name: "probability",
            value: probability,
            min: 0.0,
            max: 1.0,
        })
    }
}

fn mean_square(phase: &[f64], statistic: Statistic, m: usize) -> allan::MeanSquare {
    match statistic {
        Statistic::Allan => allan::allan(phase, m),
        Statistic::OverlappingAllan => overlapping(phase, m),
        Statistic::ModifiedAllan | Statistic::Time => allan::modified(phase, m),
        Statistic::Hadamard => hadamard::hadamard(phase, m),
        Statistic::OverlappingHadamard => hadamard::overlapping(phase, m),
        Statistic::Total => total::total(phase, m),
        Statistic::ModifiedTotal | Statistic::TimeTotal => total::modified_total(phase, m),
        Statistic::HadamardTotal => total::hadamard_total(phase, m),
        Statistic::Theo1 => theo::theo1(phase, m),
    }
}

/// Noise type at each factor, carried over to longer times than can be identified.
fn identify(
    phase: &Phase<'_>,
    statistic: Statistic,
    factors: &[usize],
    given: Option<NoiseType>,
) -> Vec<(NoiseType, NoiseBasis)> {
    if let Some(noise) = given {
        return vec![(noise, NoiseBasis::Given); factors.len()];
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
    let longest = (phase.len().saturating_sub(1)) / (noise_type::FEWEST_AVERAGES - 1);
    let carried = (longest >= 1).then(|| at(longest)).flatten();
    factors
        .par_iter()
        .map(|&m| match at(m) {
            Some(noise) => (noise, NoiseBasis::Identified),
            None => match carried.filter(|_| m > longest) {
                Some(noise) => (noise, NoiseBasis::CarriedOver),
                None => (NoiseType::White, NoiseBasis::Assumed),
            },
        })
        .collect()
}
