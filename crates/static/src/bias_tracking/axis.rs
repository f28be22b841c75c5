//! One axis: the filter forwards, the smoother backwards, the constant beside the process.

use super::consistency::Consistency;
use super::{BiasNoise, RestMean};
use proofmass_core::velocity::BiasModel;
use proofmass_core::{BiasFilter, BiasState, Error};

/// A bias with its standard uncertainty, m/s².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct BiasEstimate {
    /// The bias.
    pub bias: f64,
    /// Its standard uncertainty: noise, motion of the bias, and the known acceleration.
    pub u: f64,
}

/// The bias of one axis over the recording.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct AxisTrack {
    /// The noise it was tracked with.
    pub noise: BiasNoise,
    /// From what came before each time, as on line.
    pub filtered: Vec<BiasEstimate>,
    /// From the whole recording.
    pub smoothed: Vec<BiasEstimate>,
    /// Part of the uncertainty at the end that the known acceleration has, m/s².
    pub known_part: f64,
    /// The innovations, in the order of the means, m/s².
    pub innovations: Vec<f64>,
    /// The same over their stated standard deviations.
    pub normalised: Vec<f64>,
    /// Whether they are what the noise lets expect.
    pub consistency: Consistency,
}

impl AxisTrack {
    /// At the end of the recording.
    pub fn end(&self) -> BiasEstimate {
        self.filtered.last().copied().unwrap_or_default()
    }
}

/// What the filter knows at one time: of the data, of ones, and the variance of both.
#[derive(Clone, Copy, Default)]
struct Known {
    data: f64,
    ones: f64,
    variance: f64,
}

impl Known {
    fn of(data: &BiasState<f64>, ones: &BiasState<f64>) -> Self {
        Self {
            data: data.bias(),
            ones: ones.bias(),
            variance: data.variance(),
        }
    }
}

/// The constant beside the process: its information and what it is multiplied with.
#[derive(Clone, Copy)]
struct Constant {
    prior: f64,
    information: f64,
    product: f64,
    /// The same of data that are all one.
    product_of_ones: f64,
}

impl Constant {
    fn new(offset: f64) -> Self {
        let prior = if offset > 0.0 {
            1.0 / (offset * offset)
        } else {
            f64::INFINITY
        };
        Self {
            prior,
            information: prior,
            product: 0.0,
            product_of_ones: 0.0,
        }
    }

    fn learn(&mut self, data: f64, ones: f64, variance: f64) {
        if self.prior.is_finite() {
            self.information += ones * ones / variance;
            self.product += ones * data / variance;
            self.product_of_ones += ones * ones / variance;
        }
    }

    /// Estimate and variance.
    fn value(&self) -> (f64, f64) {
        if self.prior.is_finite() {
            (self.product / self.information, 1.0 / self.information)
        } else {
            (0.0, 0.0)
        }
    }

    /// What it answers to data that are all one.
    fn of_ones(&self) -> f64 {
        if self.prior.is_finite() {
            self.product_of_ones / self.information
        } else {
            0.0
        }
    }

    /// What an error common to all known accelerations does: it is an offset of all data.
    fn shared(&self, known: &Known, common: f64) -> f64 {
        common * (known.ones + (1.0 - known.ones) * self.of_ones())
    }

    /// Process and constant together.
    fn total(&self, known: &Known, common: f64) -> BiasEstimate {
        let (constant, variance) = self.value();
        let rest = 1.0 - known.ones;
        let shared = self.shared(known, common);
        BiasEstimate {
            bias: known.data + constant * rest,
            u: (known.variance + rest * rest * variance + shared * shared)
                .max(0.0)
                .sqrt(),
        }
    }
}

impl AxisTrack {
    pub(super) fn new(
        noise: &BiasNoise,
        common: f64,
        time: &[f64],
        mean: &[Option<usize>],
        axis: usize,
        means: &[RestMean],
    ) -> Result<Self, Error> {
        let n = time.len();
        let mut filtered = Vec::with_capacity(n);
        let mut innovations = Vec::with_capacity(means.len());
        let mut normalised = Vec::with_capacity(means.len());
        let mut constant = Constant::new(noise.offset);
        // What the smoother goes back through: after each time, before each time, and φ towards it.
        let mut after: Vec<Known> = Vec::with_capacity(n);
        let mut before: Vec<(Known, f64)> = Vec::with_capacity(n);
        let start = state(&noise.model);
        let (mut data, mut ones) = (start, start);
        let mut last = time.first().copied().unwrap_or(0.0);
        for (at, index) in time.iter().zip(mean) {
            let update = index.map(|i| &means[i]);
            let variance = update.map_or(1.0, |m| noise.white * noise.white / m.duration);
            let mut keep = 1.0;
            if *at > last {
                let (filter, _) = BiasFilter::new(noise.model, variance, at - last)?;
                filter.predict(&mut data);
                filter.predict(&mut ones);
                keep = filter.coefficients()[0];
                last = *at;
            }
            before.push((Known::of(&data, &ones), keep));
            if let Some(m) = update {
                // The period plays no part in an update.
                let (filter, _) = BiasFilter::new(noise.model, variance, 1.0)?;
                let of_data = filter.update(&mut data, m.mean[axis], m.known[axis]);
                let of_ones = filter.update(&mut ones, 1.0, 0.0);
                let (c, v) = constant.value();
                let innovation = of_data.value - c * of_ones.value;
                let expected = of_data.variance + of_ones.value * of_ones.value * v;
                innovations.push(innovation);
                normalised.push(innovation / expected.sqrt());
                constant.learn(of_data.value, of_ones.value, of_data.variance);
            }
            let now = Known::of(&data, &ones);
            after.push(now);
            filtered.push(constant.total(&now, common));
        }
        let smoothed = smooth(&after, &before, &constant, common);
        let known_part = after
            .last()
            .map_or(0.0, |known| constant.shared(known, common).abs());
        let rests: Vec<usize> = means.iter().map(|m| m.rest).collect();
        Ok(Self {
            noise: *noise,
            filtered,
            smoothed,
            known_part,
            consistency: Consistency::new(&innovations, &normalised, &rests),
            innovations,
            normalised,
        })
    }
}

/// The state before the first mean.
fn state(model: &BiasModel) -> BiasState<f64> {
    BiasState::known(0.0, model.initial() * model.initial())
}

/// Fixed-interval smoother.
fn smooth(
    after: &[Known],
    before: &[(Known, f64)],
    constant: &Constant,
    common: f64,
) -> Vec<BiasEstimate> {
    let n = after.len();
    let mut smoothed = vec![BiasEstimate::default(); n];
    let mut next = after.last().copied().unwrap_or_default();
    for i in (0..n).rev() {
        if i + 1 < n {
            let (predicted, keep) = before[i + 1];
            let gain = keep * after[i].variance / predicted.variance;
            next = Known {
                data: after[i].data + gain * (next.data - predicted.data),
                ones: after[i].ones + gain * (next.ones - predicted.ones),
                variance: after[i].variance + gain * gain * (next.variance - predicted.variance),
            };
        }
        smoothed[i] = constant.total(&next, common);
    }
    smoothed
}
