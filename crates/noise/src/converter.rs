//! What a converter leaves in a record: steps as coarse as the noise, rails, samples that stand twice.

use crate::findings;
use proofmass_signal::saturation::rails;
use proofmass_uncertainty::{Figure, Finding};
use serde::{Deserialize, Serialize};

/// Fewest samples of which traces are sought.
const FEWEST: usize = 1000;

/// Share of neighbours that are equal from which samples are said to be repeated.
const REPEATED: f64 = 0.15;

/// Equal samples one after the other, at least, that are taken for an output that stood still.
const SHORTEST_STANDSTILL: usize = 20;

/// Chance of a record that a run of equal samples as long as a standstill comes about by itself.
const BY_ITSELF: f64 = 1e-6;

/// One trace with its size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
#[non_exhaustive]
pub enum ConverterTrace {
    /// The step between neighbouring values is large against the noise.
    Coarse {
        /// The step, U.
        step: f64,
        /// Standard deviation of one sample about its neighbours, U.
        scatter: f64,
    },
    /// Samples stand at the largest or smallest value far more often than beside it.
    Clipped {
        /// The value, U.
        rail: f64,
        /// Share of the samples.
        share: f64,
    },
    /// Neighbouring samples are equal though the values are fine: the sensor is slower than the recording.
    Repeated {
        /// Share of samples that equal the one before.
        share: f64,
    },
    /// The output stood still: runs of equal samples that chance does not bring.
    Frozen {
        /// First sample of the longest run.
        first: usize,
        /// Its length.
        longest: usize,
        /// Samples in all such runs.
        samples: usize,
    },
}

/// Traces of the converter in a record of a sensor at rest.
///
/// A step of one standard deviation of the noise raises the variance by a twelfth; below half a standard deviation it does
/// no harm (1 %). **Accuracy** none of 500 records of white noise, of noise in steps of 0.4 σ, or of a random walk shows one
/// (`law_healthy_records_show_no_trace`).
pub fn converter_traces(rate: &[f64]) -> Vec<ConverterTrace> {
    let mut traces = Vec::new();
    if rate.len() < FEWEST {
        return traces;
    }
    let step = converter_step(rate);
    let scatter = difference_scatter(rate);
    if let Some(step) = step.filter(|s| *s > scatter) {
        traces.push(ConverterTrace::Coarse { step, scatter });
    }
    traces.extend(rails(rate).iter().map(|r| ConverterTrace::Clipped {
        rail: r.level,
        share: r.share,
    }));
    let (frozen, share) = standstills(rate);
    // Steps as large as the noise stand still by themselves.
    traces.extend(frozen.filter(|_| step.is_none_or(|s| s < scatter)));
    let fine = step.is_none_or(|s| s < 0.2 * scatter.max(f64::MIN_POSITIVE));
    if fine && share > REPEATED {
        traces.push(ConverterTrace::Repeated { share });
    }
    traces
}

/// Runs of equal samples beyond chance, and the share of equal neighbours elsewhere.
///
/// With a share p of equal neighbours a run of L has the chance n p^{L−1}; p is doubled, since it may be larger in places. Where a third of
/// the neighbours or more are equal anyway, by a coarse step or samples that stand twice, no run says anything.
fn standstills(rate: &[f64]) -> (Option<ConverterTrace>, f64) {
    let n = rate.len() as f64;
    let runs = || {
        rate.chunk_by(|a, b| a == b).scan(0, |first, run| {
            let at = *first;
            *first += run.len();
            Some((at, run.len()))
        })
    };
    let in_short: usize = runs()
        .filter(|r| r.1 < SHORTEST_STANDSTILL)
        .map(|r| r.1 - 1)
        .sum();
    let share = in_short as f64 / n;
    let all = runs().map(|r| r.1 - 1).sum::<usize>() as f64 / n;
    if share > 1.0 / 3.0 {
        return (None, all);
    }
    let chance = (2.0 * share).max(0.1);
    let needed = 1.0 + (BY_ITSELF / n).ln() / chance.ln();
    let still = || runs().filter(|r| r.1 >= SHORTEST_STANDSTILL && r.1 as f64 >= needed);
    let Some((first, longest)) = still().max_by_key(|r| r.1) else {
        return (None, all);
    };
    let samples = still().map(|r| r.1).sum();
    let frozen = ConverterTrace::Frozen {
        first,
        longest,
        samples,
    };
    (Some(frozen), share)
}

/// Step between neighbouring values, when the record has few distinct ones: the median distance.
pub(crate) fn converter_step(rate: &[f64]) -> Option<f64> {
    // Of a converter's record even a part shows few values; fine data give up early.
    let part = &rate[..rate.len().min(20_000)];
    let mut sorted = part.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    if sorted.len() < 2 || sorted.len() * 4 > part.len() {
        return None;
    }
    let mut distances: Vec<f64> = sorted.windows(2).map(|w| w[1] - w[0]).collect();
    let middle = distances.len() / 2;
    let (_, step, _) = distances.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*step)
}

/// Root mean square of the differences of neighbours over √2: the noise of one sample, drift left aside.
pub(crate) fn difference_scatter(rate: &[f64]) -> f64 {
    let n = rate.len().saturating_sub(1).max(1) as f64;
    let sum: f64 = rate.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum();
    (0.5 * sum / n).sqrt()
}

/// The traces as findings.
pub(crate) fn converter_findings(traces: &[ConverterTrace], unit: &str) -> Vec<Finding> {
    traces
        .iter()
        .map(|trace| match *trace {
            ConverterTrace::Coarse { step, scatter } => {
                findings::coarse_resolution(Figure(step), Figure(scatter), unit)
            }
            ConverterTrace::Clipped { rail, share } => proofmass_uncertainty::findings::clipped(
                "the channel is clipped",
                &format!(
                    "{:.2} % of the samples are exactly {} {unit}",
                    100.0 * share,
                    Figure(rail)
                ),
                "the white noise of a clipped record is too low",
            ),
            ConverterTrace::Repeated { share } => {
                proofmass_uncertainty::findings::repeated_samples(
                    "; densities below a tenth of its rate are valid",
                    &format!(
                        "{:.0} % of the samples equal the one before: about one new value in {:.1} rows",
                        100.0 * share,
                        1.0 / (1.0 - share).max(1e-9)
                    ),
                )
            }
            ConverterTrace::Frozen {
                first,
                longest,
                samples,
            } => proofmass_uncertainty::findings::frozen(
                "the output",
                &format!(
                    "{samples} samples in runs of equal values, the longest of {longest} from sample {} of the longest stretch",
                    first + 1
                ),
                "leave these fields empty, so that they count as a gap; with them N is too small, and K may be spurious",
            ),
        })
        .collect()
}
