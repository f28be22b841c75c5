//! A recording reduced to block means, and the attitudes the sensor was in.

use super::{SweepData, means};
use crate::Triple;
use proofmass_core::{Error, check, norm};
use serde::{Deserialize, Serialize};

/// Change of the output between two blocks that no temperature makes: 3 mg, and 2 mg for each kelvin between them.
///
/// Forty times the typical coefficient of a consumer part, twice that of the worst one met.
const SUDDEN: f64 = 3e-3 * proofmass_core::STANDARD_GRAVITY;
const SUDDEN_PER_KELVIN: f64 = 2e-3 * proofmass_core::STANDARD_GRAVITY;
/// And this many times the median change between blocks, so that noise and vibration are not taken for a turn.
const MEDIANS: f64 = 12.0;
/// Blocks that an attitude must hold to carry information.
const FEWEST: usize = 4;
/// Shares of the whole temperature range that a turned sensor must have gone through in one attitude.
const SPAN: f64 = 0.1;

/// Block means in order of time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Blocks {
    /// Middle of each block, s.
    pub time: Vec<f64>,
    /// Mean temperature, °C.
    pub temperature: Vec<f64>,
    /// Mean outputs, m/s².
    pub output: Vec<Triple>,
    /// Attitude of each block, its number in `attitudes`.
    pub attitude: Vec<usize>,
    /// The attitudes.
    pub attitudes: Vec<Attitude>,
    /// Samples in a block.
    pub samples: usize,
    /// Duration of a block, s.
    pub duration: f64,
    /// Variance of the mean temperature of a block from the noise of the thermometer, K².
    pub temperature_noise: f64,
}

/// A stretch in which the sensor was not turned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Attitude {
    /// First and last time, s.
    pub time: [f64; 2],
    /// Mean output, m/s².
    pub output: Triple,
    /// Lowest and highest block temperature, °C.
    pub range: [f64; 2],
    /// Change of the output at its beginning, m/s²; `None` for the first.
    pub step: Option<f64>,
}

impl Blocks {
    pub(super) fn of(data: &SweepData<'_>, aim: usize) -> Result<Self, Error> {
        let n = data.temperature.len();
        for (name, column) in ["x", "y", "z"].into_iter().zip(data.outputs) {
            check::column(name, column, n)?;
        }
        check::finite("temperature", data.temperature)?;
        let samples = n.div_ceil(aim).max(1);
        let count = n / samples;
        if count < 40 {
            return Err(Error::TooFew {
                name: "samples of a temperature sweep",
                needed: 40,
                got: n,
            });
        }
        let mut blocks = Self {
            time: Vec::with_capacity(count),
            temperature: Vec::with_capacity(count),
            output: Vec::with_capacity(count),
            attitude: Vec::new(),
            attitudes: Vec::new(),
            samples,
            duration: samples as f64 / data.rate,
            temperature_noise: 0.0,
        };
        let mut differences = 0.0;
        for b in 0..count {
            let (start, end) = (b * samples, (b + 1) * samples);
            blocks
                .time
                .push((start as f64 + 0.5 * samples as f64) / data.rate);
            let column = &data.temperature[start..end];
            blocks
                .temperature
                .push(column.iter().sum::<f64>() / samples as f64);
            // Successive differences: a ramp within the block is no noise.
            differences += column
                .windows(2)
                .map(|w| (w[1] - w[0]).powi(2))
                .sum::<f64>();
            blocks.output.push(means(data.outputs, start, end));
        }
        if samples > 1 {
            let pairs = (count * (samples - 1)) as f64;
            blocks.temperature_noise = 0.5 * differences / pairs / samples as f64;
        }
        let [low, high] = blocks.range();
        // Below five times the noise of a block mean nothing is left to fit.
        if !(high - low > 5.0 * blocks.temperature_noise.sqrt()) {
            return Err(Error::Constant {
                name: "temperature",
                value: blocks.temperature[0],
            });
        }
        blocks.find_attitudes();
        blocks.check_attitudes()?;
        Ok(blocks)
    }

    /// Lowest and highest block temperature, °C.
    pub fn range(&self) -> [f64; 2] {
        range(self.temperature.iter().copied())
    }

    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Largest change of the temperature between two neighbouring blocks as a share of the range, with the change of
    /// direction of the specific force there, rad.
    pub fn largest_jump(&self) -> (f64, f64) {
        let [low, high] = self.range();
        let steps = self.temperature.windows(2).map(|w| (w[1] - w[0]).abs());
        let largest = steps.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
        largest.map_or((0.0, 0.0), |(i, step)| {
            let angle = angle(self.output[i], self.output[i + 1]);
            (step / (high - low), angle)
        })
    }

    fn find_attitudes(&mut self) {
        let change = |a: Triple, b: Triple| norm([b[0] - a[0], b[1] - a[1], b[2] - a[2]]);
        let changes: Vec<f64> = self.output.windows(2).map(|w| change(w[0], w[1])).collect();
        let typical = crate::multi_position::median(changes.clone());
        let mut number = 0;
        self.attitude = vec![0; self.len()];
        let mut steps = vec![None];
        for (i, size) in changes.iter().enumerate() {
            let kelvin = (self.temperature[i + 1] - self.temperature[i]).abs();
            if *size > SUDDEN + SUDDEN_PER_KELVIN * kelvin && *size > MEDIANS * typical {
                number += 1;
                steps.push(Some(*size));
            }
            self.attitude[i + 1] = number;
        }
        // A block in which the turn happened is between attitudes: it, and every other short stretch, is left out.
        let mut kept = Vec::new();
        let mut renamed = vec![None; number + 1];
        let mut attitudes = Vec::new();
        let mut pending: Option<f64> = None;
        for s in 0..=number {
            let members: Vec<usize> = (0..self.len()).filter(|i| self.attitude[*i] == s).collect();
            if let Some(step) = steps[s] {
                pending = Some(pending.map_or(step, |p: f64| p.max(step)));
            }
            if number > 0 && members.len() < FEWEST {
                continue;
            }
            renamed[s] = Some(attitudes.len());
            let count = members.len() as f64;
            let mut mean = [0.0; 3];
            for i in &members {
                for axis in 0..3 {
                    mean[axis] += self.output[*i][axis] / count;
                }
            }
            attitudes.push(Attitude {
                time: [
                    members.first().map_or(0.0, |i| self.time[*i]),
                    members.last().map_or(0.0, |i| self.time[*i]),
                ],
                output: mean,
                range: range(members.iter().map(|i| self.temperature[*i])),
                step: pending.take(),
            });
            kept.extend(members);
        }
        let pick = |v: &[f64]| kept.iter().map(|i| v[*i]).collect::<Vec<f64>>();
        self.time = pick(&self.time);
        self.temperature = pick(&self.temperature);
        self.output = kept.iter().map(|i| self.output[*i]).collect();
        self.attitude = kept
            .iter()
            .filter_map(|i| renamed[self.attitude[*i]])
            .collect();
        self.attitudes = attitudes;
    }

    /// A sensor that was turned shows its coefficients only while it lies still and the temperature changes.
    fn check_attitudes(&self) -> Result<(), Error> {
        if self.len() < 40 {
            return Err(Error::TooFew {
                name: "blocks between the turns of the sensor",
                needed: 40,
                got: self.len(),
            });
        }
        let [low, high] = self.range();
        let widest = self
            .attitudes
            .iter()
            .map(|a| a.range[1] - a.range[0])
            .fold(0.0, f64::max);
        if self.attitudes.len() > 1
            && !(widest > SPAN * (high - low) && widest > 5.0 * self.temperature_noise.sqrt())
        {
            return Err(Error::Unobservable {
                parameter: "a temperature coefficient: the sensor was turned between the temperatures",
                condition: f64::INFINITY,
            });
        }
        Ok(())
    }
}

fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| {
        [a.min(v), b.max(v)]
    })
}

/// Angle between two vectors, rad.
pub(super) fn angle(a: Triple, b: Triple) -> f64 {
    let cross = [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ];
    norm(cross).atan2(proofmass_core::dot(a, b))
}
