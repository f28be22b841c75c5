//! Disturbances of a standing record: steps, bursts and spikes that are not noise.

use crate::allan::MeanSquare;
use crate::converter::{converter_step, difference_scatter};
use crate::overlapping::overlapping_family;
use crate::phase::Phase;
use crate::record::{NoiseRecord, check_count, check_finite, check_sample_rate};
use crate::steps::Steps;
use crate::whittle::refuse_constant;
use proofmass_core::Error;
use proofmass_uncertainty::normal_quantile;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// What a disturbance looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DisturbanceKind {
    /// The mean jumps from one block to the next.
    Step,
    /// The scatter within a block is larger than elsewhere.
    Burst,
    /// The scatter within a block is smaller than elsewhere: saturation, a frozen converter.
    Lull,
    /// Single samples far from their neighbours.
    Spike,
}

/// One disturbance of a record.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Disturbance {
    /// What it looks like.
    pub kind: DisturbanceKind,
    /// First sample and one past the last.
    pub samples: (usize, usize),
    /// Start and end in s from the first sample.
    pub seconds: (f64, f64),
    /// Largest deviation in robust standard deviations of the statistic that saw it.
    pub strength: f64,
    /// What would have been needed.
    pub threshold: f64,
    /// Largest share by which it raises the Allan variance at any octave τ up to 16 times its own length.
    pub influence: f64,
    /// The same in standard uncertainties of that Allan variance: above three the curve shows the disturbance.
    pub displacement: f64,
}

/// Blocks below which a length is not tested: the robust scale would be too uncertain.
const FEWEST_BLOCKS: usize = 40;

/// Finds what is not noise in a record of a sensor at rest.
///
/// The record is cut into blocks of 16, 64, 256, … samples. At each length the changes of the block mean and the
/// logarithms of the block scatter are compared with their own robust scale (median absolute deviation), found over the
/// whole record; single samples are compared with the second differences around them. Slow drift and random walk
/// change neighbouring blocks alike and enter the scale; a knock, a step or an attitude change does not.
///
/// `false_alarm_rate` is the probability that a record of Gaussian noise without a disturbance shows one at all;
/// it is shared evenly among all comparisons (Student quantiles for the uncertainty of the scale).
///
/// **Errors** [`Error::NotFinite`], [`Error::TooFew`] below 640 samples, [`Error::OutOfRange`] for a constant channel
/// or a probability outside (0, 1).
///
/// **Accuracy** the stated rate is kept for white noise with flicker and random walk
/// (`law_disturbance_false_alarms`), power by `law_disturbances_are_found_every_time`).
pub fn disturbances(
    rate: &[f64],
    sample_rate: f64,
    false_alarm_rate: f64,
) -> Result<Vec<Disturbance>, Error> {
    check_sample_rate(sample_rate)?;
    check_finite("rate", rate)?;
    check_count("rate samples", rate.len(), 16 * FEWEST_BLOCKS)?;
    proofmass_core::check::probability(false_alarm_rate)?;
    refuse_constant(rate)?;
    let lengths: Vec<usize> = (2..16)
        .map(|k| 1_usize << (2 * k))
        .take_while(|l| rate.len() / l >= FEWEST_BLOCKS)
        .collect();
    // Spikes, and changes and scatter at each length.
    let families = 1.0 + 2.0 * lengths.len() as f64;
    let share = false_alarm_rate / families;
    let mut found = spikes(rate, share);
    for &l in &lengths {
        let blocks: Vec<&[f64]> = rate.chunks_exact(l).collect();
        let means: Vec<f64> = blocks
            .iter()
            .map(|b| b.iter().sum::<f64>() / l as f64)
            .collect();
        found.extend(steps(&means, l, share));
        found.extend(bursts(&blocks, &means, l, share));
    }
    // Where a step of the converter is as large as the noise, a block without a change is nothing special.
    if converter_step(rate).is_some_and(|q| q > 0.5 * difference_scatter(rate)) {
        found.retain(|d| d.kind != DisturbanceKind::Lull);
    }
    let mut merged = merge(found);
    let phase = Phase::new(NoiseRecord::Rate(rate), sample_rate)?;
    let factors: Vec<usize> = (0..)
        .map(|k| 1 << k)
        .take_while(|m| 10 * m < rate.len())
        .collect();
    let whole = overlapping_family(&phase, &factors, &Steps::unwatched());
    let points = phase.to_vec();
    for d in &mut merged {
        weigh(d, &points, &factors, &whole);
        d.seconds = (
            d.samples.0 as f64 / sample_rate,
            d.samples.1 as f64 / sample_rate,
        );
    }
    Ok(merged)
}

/// How much a disturbance adds to the Allan variance: the squares of all differences that touch it, beyond their
/// share in number.
fn weigh(d: &mut Disturbance, phase: &[f64], factors: &[usize], whole: &[MeanSquare]) {
    let length = d.samples.1 - d.samples.0;
    for (&m, &(variance, terms)) in factors.iter().zip(whole) {
        if m > 16 * length || variance <= 0.0 {
            break;
        }
        let first = d.samples.0.saturating_sub(2 * m);
        let last = d.samples.1.min(terms);
        let touching: f64 = (first..last)
            .map(|i| (phase[i + 2 * m] - 2.0 * phase[i + m] + phase[i]).powi(2))
            .sum();
        let m = m as f64;
        let total = 2.0 * m * m * variance * terms as f64;
        let share = touching / total - (last - first) as f64 / terms as f64;
        // White noise: ν = 3/2 of the number of τ in the record.
        let uncertainty = (2.0 / (1.5 * terms as f64 / m)).sqrt();
        d.influence = d.influence.max(share);
        d.displacement = d.displacement.max(share / uncertainty);
    }
}

/// What all disturbances together add to the Allan variance of a record.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointInfluence {
    /// Averaging time in s at which they show most.
    pub(crate) tau: f64,
    /// Share of the Allan variance there that the differences touching a disturbance add beyond their number.
    pub(crate) influence: f64,
    /// The same in standard uncertainties of that Allan variance.
    pub(crate) displacement: f64,
}

/// The joint influence of disturbances at octave averaging times that leave half of the differences untouched.
///
/// `rate` and the places of the disturbances as given to and by [`disturbances`]. `None` without disturbances.
///
/// **Errors** those of the record.
pub fn joint_influence(
    rate: &[f64],
    sample_rate: f64,
    found: &[Disturbance],
) -> Result<Option<JointInfluence>, Error> {
    if found.is_empty() {
        return Ok(None);
    }
    let phase = Phase::new(NoiseRecord::Rate(rate), sample_rate)?.to_vec();
    // Disturbed samples before each place.
    let mut before = vec![0_u32; rate.len() + 1];
    for d in found {
        for k in d.samples.0..d.samples.1.min(rate.len()) {
            before[k + 1] = 1;
        }
    }
    for k in 0..rate.len() {
        before[k + 1] += before[k];
    }
    let mut worst: Option<JointInfluence> = None;
    let mut m = 1;
    while 10 * m < rate.len() {
        let terms = rate.len() + 1 - 2 * m;
        let (mut all, mut touching, mut touched) = (0.0, 0.0, 0_usize);
        for i in 0..terms {
            let square = (phase[i + 2 * m] - 2.0 * phase[i + m] + phase[i]).powi(2);
            all += square;
            if before[i + 2 * m] > before[i] {
                touching += square;
                touched += 1;
            }
        }
        if 2 * touched > terms {
            break;
        }
        if all > 0.0 {
            let influence = touching / all - touched as f64 / terms as f64;
            let uncertainty = (2.0 / (1.5 * terms as f64 / m as f64)).sqrt();
            let displacement = influence / uncertainty;
            if worst.is_none_or(|w| displacement > w.displacement) {
                worst = Some(JointInfluence {
                    tau: m as f64 / sample_rate,
                    influence,
                    displacement,
                });
            }
        }
        m *= 2;
    }
    Ok(worst)
}

fn disturbance(
    kind: DisturbanceKind,
    samples: (usize, usize),
    strength: f64,
    threshold: f64,
) -> Disturbance {
    Disturbance {
        kind,
        samples,
        seconds: (0.0, 0.0),
        strength,
        threshold,
        influence: 0.0,
        displacement: 0.0,
    }
}

/// Changes of the mean between neighbouring blocks.
fn steps(means: &[f64], l: usize, share: f64) -> Vec<Disturbance> {
    let changes: Vec<f64> = means.windows(2).map(|w| w[1] - w[0]).collect();
    let Some((centre, scale)) = robust_scale(&changes) else {
        return Vec::new();
    };
    let threshold = student_threshold(changes.len(), share);
    changes
        .iter()
        .enumerate()
        .filter_map(|(i, c)| {
            let strength = (c - centre).abs() / scale;
            (strength > threshold).then(|| {
                disturbance(
                    DisturbanceKind::Step,
                    (i * l, (i + 2) * l),
                    strength,
                    threshold,
                )
            })
        })
        .collect()
}

/// Scatter about the mean within blocks.
fn bursts(blocks: &[&[f64]], means: &[f64], l: usize, share: f64) -> Vec<Disturbance> {
    // Cube root of the variance: within a percent of Gaussian for 16 samples and more.
    let scatter: Vec<f64> = blocks
        .iter()
        .zip(means)
        .map(|(b, mean)| {
            let sum: f64 = b.iter().map(|y| (y - mean) * (y - mean)).sum();
            (sum / (l as f64 - 1.0)).cbrt()
        })
        .collect();
    let Some((centre, scale)) = robust_scale(&scatter) else {
        return Vec::new();
    };
    let threshold = student_threshold(scatter.len(), share);
    scatter
        .iter()
        .enumerate()
        .filter_map(|(i, s)| {
            let z = (s - centre) / scale;
            let kind = if z > 0.0 {
                DisturbanceKind::Burst
            } else {
                DisturbanceKind::Lull
            };
            (z.abs() > threshold)
                .then(|| disturbance(kind, (i * l, (i + 1) * l), z.abs(), threshold))
        })
        .collect()
}

/// Second differences of samples: a single sample off by a stands out by 2a against √6 σ.
fn spikes(rate: &[f64], share: f64) -> Vec<Disturbance> {
    let curvature: Vec<f64> = rate
        .windows(3)
        .map(|w| w[1] - 0.5 * (w[0] + w[2]))
        .collect();
    let Some((centre, scale)) = robust_scale(&curvature) else {
        return Vec::new();
    };
    let threshold = normal_threshold(curvature.len(), share);
    curvature
        .iter()
        .enumerate()
        .filter_map(|(i, c)| {
            let strength = (c - centre).abs() / scale;
            (strength > threshold)
                .then(|| disturbance(DisturbanceKind::Spike, (i + 1, i + 2), strength, threshold))
        })
        .collect()
}

/// Median, and the larger of the scaled median absolute deviation and the scaled 95th percentile.
///
/// The second holds for counts: when most values sit on two or three steps of the converter the median deviation says
/// little. Both are untouched by a disturbance of less than a twentieth of the record. `None` when there is no scatter.
fn robust_scale(values: &[f64]) -> Option<(f64, f64)> {
    let mut sorted = values.to_vec();
    let centre = quantile(&mut sorted, 0.5)?;
    let mut deviations: Vec<f64> = values.iter().map(|v| (v - centre).abs()).collect();
    let middle = 1.4826 * quantile(&mut deviations, 0.5)?;
    let outer = quantile(&mut deviations, 0.95)? / 1.96;
    let scale = middle.max(outer);
    (scale > 0.0).then_some((centre, scale))
}

fn quantile(values: &mut [f64], p: f64) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    // With the numbers compared here a fraction of a place does not matter.
    let place = ((values.len() - 1) as f64 * p).round() as usize;
    let (_, value, _) = values.select_nth_unstable_by(place, f64::total_cmp);
    Some(*value)
}

fn normal_threshold(n: usize, share: f64) -> f64 {
    normal_quantile(1.0 - 0.5 * share / n as f64)
}

/// Two-sided quantile for the largest of n, with the scale itself estimated: the median absolute deviation is worth
/// 0.37 n degrees of freedom.
fn student_threshold(n: usize, share: f64) -> f64 {
    let p = 1.0 - 0.5 * share / n as f64;
    StudentsT::new(0.0, 1.0, 0.37 * n as f64)
        .map_or_else(|_| normal_threshold(n, share), |t| t.inverse_cdf(p))
}

/// Joins detections that overlap or touch; the kind and strength of the strongest stay, the place of the shortest.
fn merge(mut found: Vec<Disturbance>) -> Vec<Disturbance> {
    found.sort_by_key(|d| d.samples);
    let mut merged: Vec<Disturbance> = Vec::new();
    let mut reach = 0;
    for d in found {
        match merged.last_mut() {
            Some(last) if d.samples.0 <= reach => {
                let relative = |d: &Disturbance| d.strength / d.threshold;
                if relative(&d) > relative(last) {
                    last.kind = d.kind;
                    last.strength = d.strength;
                    last.threshold = d.threshold;
                }
                last.samples.1 = last.samples.1.max(d.samples.1);
            }
            _ => merged.push(d),
        }
        reach = reach.max(d.samples.1);
    }
    merged
}
