//! Duration and velocity change of a deconvolved pulse, each a linear reading of its samples.

use super::{Inverse, low_pass};
use crate::limit;
use crate::shock::{Functional, LEVEL};
use num_complex::Complex64;
use proofmass_signal::{Density, fourier};
use proofmass_uncertainty::{Covariance, student_quantile};

/// What is read from the pulse, with the parts of its standard uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PulseReading {
    /// s for a duration, unit of the input × s for a velocity change.
    pub value: f64,
    /// Part of the noise of the output and of its level.
    pub noise: f64,
    /// Part of the model.
    pub model: f64,
    /// Part of what the low-pass removes.
    pub regularisation: f64,
}

impl PulseReading {
    /// All parts together.
    pub fn standard_uncertainty(&self) -> f64 {
        self.noise.hypot(self.model).hypot(self.regularisation)
    }
}

/// Share of that level within which the standard uncertainty of a sample must lie: the outermost of a thousand samples passes the
/// level by chance once in ten.
const CLEAR: f64 = 0.5;
/// Fewer windows of the quiet stretch than this say nothing of a reading.
const WINDOWS: usize = 6;

/// Passages through the level, in samples, and the change per sample there.
struct Passages {
    start: (f64, f64),
    end: (f64, f64),
}

/// First and last passage through the level among the samples of a range, on the side of the peak.
fn passages(value: &[f64], top: usize, [from, to]: [usize; 2]) -> Option<Passages> {
    let level = LEVEL * value[top];
    let up = |k: &usize| value[*k] * value[top].signum() >= level.abs();
    let first = (from..=top).find(up)?;
    let last = (top..to).rev().find(up)?;
    if first == from || last + 1 >= to {
        return None;
    }
    let cross = |low: usize| {
        let slope = value[low + 1] - value[low];
        (low as f64 + between(value, low, level), slope)
    };
    Some(Passages {
        start: cross(first - 1),
        end: cross(last),
    })
}

/// Where between a sample and the next one a curve passes a level: of the cubic through these two and their neighbours.
fn between(value: &[f64], low: usize, level: f64) -> f64 {
    let at = |k: usize| value[k.min(value.len() - 1)] - level;
    let [a, b, c, d] = [at(low.saturating_sub(1)), at(low), at(low + 1), at(low + 2)];
    let cubic = |s: f64| {
        let outer = a * s * (s - 1.0) * (2.0 - s) + d * s * (s * s - 1.0);
        let inner = b * (s + 1.0) * (s - 1.0) * (s - 2.0) - c * (s + 1.0) * s * (s - 2.0);
        outer / 6.0 + inner / 2.0
    };
    let (mut from, mut to) = (0.0, 1.0);
    for _ in 0..40 {
        let middle = 0.5 * (from + to);
        match (cubic(middle) < 0.0) == (b < 0.0) {
            true => from = middle,
            false => to = middle,
        }
    }
    0.5 * (from + to)
}

impl Passages {
    fn duration(&self) -> f64 {
        self.end.0 - self.start.0
    }

    /// Of the duration in samples: what moves a passage is the value there less its share of the peak, over the slope.
    fn reading(&self, top: usize) -> Functional {
        let first = self.start.0 as usize;
        let mut weights = vec![0.0; self.end.0 as usize + 2 - first];
        let mut add = |(at, slope): (f64, f64), sign: f64| {
            let low = at as usize;
            let share = at - low as f64;
            weights[low - first] -= sign * (1.0 - share) / slope;
            weights[low + 1 - first] -= sign * share / slope;
            weights[top - first] += sign * LEVEL / slope;
        };
        add(self.end, 1.0);
        add(self.start, -1.0);
        Functional { first, weights }
    }
}

/// What the readings stand on.
pub(super) struct Deconvolution<'a> {
    pub inverse: &'a Inverse,
    pub noise: &'a Density,
    pub corner: f64,
    pub rate: f64,
    /// Samples before anything happens.
    pub quiet: usize,
    /// How far a level that goes on as it changes may be off at a sample, as a standard uncertainty of the input; with a change that the
    /// noise may hide where that is asked for.
    pub moved: &'a dyn Fn(usize, bool) -> f64,
    pub value: &'a [f64],
    pub sensitivities: &'a [Vec<f64>],
    pub covariance: &'a Covariance,
    /// Standard uncertainty of a sample.
    pub sample: f64,
    pub event: [usize; 2],
    pub top: usize,
}

impl Deconvolution<'_> {
    /// Of the low-pass, in samples.
    fn reach(&self) -> usize {
        (1.5 * self.rate / self.corner).ceil() as usize
    }

    fn about_the_event(&self) -> [usize; 2] {
        let reach = self.reach();
        let end = (self.event[1] + reach).min(self.value.len());
        [self.event[0].saturating_sub(reach), end]
    }

    fn passages(&self, value: &[f64]) -> Option<Passages> {
        passages(value, self.top, self.about_the_event())
    }

    /// Seconds from the first to the last passage through a tenth of the peak; `None` where the uncertainty of a sample lets noise pass
    /// that level, or an end is not in the record.
    pub fn duration(&self) -> Option<PulseReading> {
        if self.sample > CLEAR * LEVEL * self.value[self.top].abs() {
            return None;
        }
        let found = self.passages(self.value)?;
        let coarse = self.passages(&self.coarse())?;
        let removed = found.duration() - coarse.duration();
        let mut reading = found.reading(self.top);
        for w in &mut reading.weights {
            *w /= self.rate;
        }
        Some(self.stated(&reading, found.duration() / self.rate, removed / self.rate))
    }

    /// Integral over the event and what of it the low-pass spreads; `None` where the record does not hold that.
    pub fn velocity_change(&self) -> Option<PulseReading> {
        let passages = self.passages(self.value);
        let [from, to] =
            passages.map_or(self.event, |p| [p.start.0 as usize, p.end.0 as usize + 1]);
        let reach = self.reach().max((to - from) / 4);
        let from = from.checked_sub(reach)?;
        let to = Some(to + reach).filter(|to| *to <= self.value.len())?;
        let reading = Functional {
            first: from,
            weights: vec![1.0 / self.rate; to - from],
        };
        let value = reading.read(self.value, 0.0);
        Some(self.stated(&reading, value, value - reading.read(&self.coarse(), 0.0)))
    }

    /// With half the corner: of a spectrum that falls as f⁻² that loses as much again.
    fn coarse(&self) -> Vec<f64> {
        self.inverse.at(0.5 * self.corner, &|_| Complex64::ONE)
    }

    fn stated(&self, reading: &Functional, value: f64, removed: f64) -> PulseReading {
        let parts: Vec<f64> = self
            .sensitivities
            .iter()
            .map(|s| reading.read(s, 0.0))
            .collect();
        let mut model = 0.0;
        for (a, p) in parts.iter().enumerate() {
            for (b, q) in parts.iter().enumerate() {
                model += p * self.covariance[(a, b)] * q;
            }
        }
        let middle = reading.first + reading.weights.len() / 2;
        // A quiet stretch shorter than the reading hides a drift in its noise.
        let hidden = self.quiet < reading.weights.len();
        let level = reading.sum().abs() * (self.moved)(middle, hidden);
        PulseReading {
            value,
            noise: self.noise(reading).hypot(level),
            model: model.max(0.0).sqrt(),
            regularisation: limit::standard_uncertainty(removed.abs()),
        }
    }

    /// Standard uncertainty of a reading by the noise: by its density through the filter and the weights, or by what the same reading makes of
    /// the quiet samples, where that is more (hum, a drift). The mean of the quiet samples, from which all is counted, is part of both.
    ///
    /// A few quiet samples know the density at no single line: it counts as at least its mean up to the corner.
    fn noise(&self, reading: &Functional) -> f64 {
        let density = &self.noise.density;
        let bin = |f: f64| ((f / self.noise.bin_width).round() as usize).min(density.len() - 1);
        let band =
            &density[1.min(density.len() - 1)..=bin(self.corner).max(4).min(density.len() - 1)];
        let mean = band.iter().sum::<f64>() / band.len() as f64;
        let n = fourier::fast_length(2 * reading.weights.len().max(density.len()));
        let mut padded = reading.weights.clone();
        padded.resize(n, 0.0);
        let line = self.rate / n as f64;
        let variance: f64 = fourier::forward_owned(padded)
            .iter()
            .enumerate()
            .map(|(k, w)| {
                let f = k as f64 * line;
                let gain =
                    low_pass(f, self.corner).powi(2) / self.inverse.response_at(f).norm_sqr();
                density[bin(f)].max(mean) * gain * w.norm_sqr() * line
            })
            .sum();
        let of_mean =
            0.5 * mean * self.rate / (self.quiet as f64 * self.inverse.response_at(0.0).norm_sqr());
        let freedom = (2.0 * self.quiet as f64 * self.corner / self.rate).max(1.0);
        let by_density = (variance + reading.sum().powi(2) * of_mean).sqrt()
            * student_quantile(0.975, freedom)
            / 1.96;
        let length = reading.weights.len();
        let quiet = &self.value[..self.quiet - self.reach().min(self.quiet / 2)];
        let windows = quiet.len() / length;
        if windows < WINDOWS {
            return by_density;
        }
        let (mut count, mut squares) = (0.0, 0.0);
        for first in (0..=quiet.len() - length).step_by((length / 4).max(1)) {
            let slid = quiet[first..].iter().zip(&reading.weights);
            squares += slid.map(|(v, w)| v * w).sum::<f64>().powi(2);
            count += 1.0;
        }
        let factor = student_quantile(0.975, windows as f64) / 1.96;
        by_density.max(factor * (squares / count).sqrt())
    }
}
