//! A recording reduced to block means, and the attitudes the sensor was in.

use super::{EnvironmentalQuantity, SweepData, means};
use crate::Triple;
use proofmass_core::numeric::median;
use proofmass_core::{Error, check, norm};
use serde::{Deserialize, Serialize};

/// Change of the output between two blocks that no temperature makes: 3 mg, and 2 mg for each kelvin between them.
///
/// Forty times the typical coefficient of a consumer part, twice that of the worst one met.
const SUDDEN: f64 = 3e-3 * proofmass_core::STANDARD_GRAVITY;
const SUDDEN_PER_KELVIN: f64 = 2e-3 * proofmass_core::STANDARD_GRAVITY;
/// And this many times the median change between blocks, so that noise and vibration are not taken for a turn.
const MEDIANS: f64 = 12.0;
/// A smaller change where another quantity of the surroundings changes as abruptly is its doing, and no turn: a tenth of g, as by 6°.
const TURNED: f64 = 0.1 * proofmass_core::STANDARD_GRAVITY;
/// Blocks that an attitude must hold to carry information.
const FEWEST: usize = 4;
/// Shares of the whole temperature range that a turned sensor must have gone through in one attitude.
const SPAN: f64 = 0.1;
/// A change of the temperature from one sample to the next by more than this share of the range, four times as large as
/// those beside it, is no warming: the recording was interrupted there.
const JUMP: f64 = 0.04;
const ABRUPT: f64 = 4.0;

/// Block means in order of time.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Blocks {
    /// Middle of each block, s.
    pub time: Vec<f64>,
    /// Mean temperature, °C.
    pub temperature: Vec<f64>,
    /// Mean outputs, m/s²; y and z are zero where there is one axis.
    pub output: Vec<Triple>,
    /// Means of other quantities of the surroundings, each over all blocks.
    pub environment: Vec<Vec<f64>>,
    /// Number of axes: three, or one.
    pub axes: usize,
    /// Attitude of each block, its number in `attitudes`.
    pub attitude: Vec<usize>,
    /// Number of jumps of the temperature before each block: between them nobody saw whether the sensor lay still.
    pub(crate) stretch: Vec<usize>,
    /// The attitudes.
    pub attitudes: Vec<Attitude>,
    /// Samples in a block.
    pub(crate) samples: usize,
    /// Duration of a block, s.
    pub duration: f64,
    /// Variance of the mean temperature of a block from the noise of the thermometer, K².
    pub(crate) temperature_noise: f64,
}

/// A stretch in which the sensor was not turned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Attitude {
    /// First and last time, s.
    pub time: [f64; 2],
    /// Mean output, m/s².
    pub output: Triple,
    /// Lowest and highest block temperature, °C.
    pub range: [f64; 2],
    /// Change of the output at its beginning, m/s²; `None` for the first.
    pub(crate) step: Option<f64>,
}

impl Blocks {
    pub(super) fn of(
        data: &SweepData<'_>,
        environment: &[EnvironmentalQuantity<'_>],
        aim: usize,
    ) -> Result<Self, Error> {
        let n = data.temperature.len();
        let axes = data.outputs.len();
        if !matches!(axes, 1 | 3) {
            return Err(Error::OutOfRange {
                name: "number of axes (one or three)",
                value: axes as f64,
                min: 1.0,
                max: 3.0,
            });
        }
        for (name, column) in names(axes).iter().zip(&data.outputs) {
            check::column(name, column, n)?;
        }
        check::finite("temperature", data.temperature)?;
        for quantity in environment {
            check::column("environmental quantity", quantity.values, n)?;
        }
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
            environment: vec![Vec::with_capacity(count); environment.len()],
            axes,
            attitude: Vec::new(),
            stretch: Vec::with_capacity(count),
            attitudes: Vec::new(),
            samples,
            duration: samples as f64 / data.rate,
            temperature_noise: 0.0,
        };
        let jumps = jumps(data.temperature);
        let mut differences = 0.0;
        for b in 0..count {
            let (start, end) = (b * samples, (b + 1) * samples);
            let before = jumps.partition_point(|j| *j <= start);
            if jumps.get(before).is_some_and(|j| *j < end) {
                continue; // half of it before a jump, half behind
            }
            blocks.stretch.push(before);
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
            blocks.output.push(means(&data.outputs, start, end));
            for (means, quantity) in blocks.environment.iter_mut().zip(environment) {
                means.push(quantity.values[start..end].iter().sum::<f64>() / samples as f64);
            }
        }
        if samples > 1 {
            let pairs = (blocks.len() * (samples - 1)).max(1) as f64;
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

    /// Names of the axes for people.
    pub fn names(&self) -> &'static [&'static str] {
        names(self.axes)
    }

    /// Name of a parameter of an axis: `slope.x`, or `slope` where there is one axis.
    pub fn parameter(&self, kind: &str, axis: usize) -> String {
        match self.axes {
            1 => kind.to_owned(),
            _ => format!("{kind}.{}", self.names()[axis]),
        }
    }

    /// Size of the specific force in an attitude, m/s²: of one axis at least that of gravity, most of which it may not see.
    pub(super) fn force(&self, attitude: &Attitude) -> f64 {
        let size = norm(attitude.output);
        match self.axes {
            1 => size.max(proofmass_core::STANDARD_GRAVITY),
            _ => size.max(f64::MIN_POSITIVE),
        }
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

    /// Jumps of the temperature within an attitude: the first block behind each, the change of the temperature in K, and that
    /// of the output, m/s².
    pub fn jumps(&self) -> Vec<(usize, f64, Triple)> {
        (1..self.len())
            .filter(|i| {
                self.stretch.get(*i) != self.stretch.get(i - 1)
                    && self.attitude[*i] == self.attitude[i - 1]
            })
            .map(|i| {
                let (before, after) = (self.side(i, false), self.side(i, true));
                let change = std::array::from_fn(|axis| after.1[axis] - before.1[axis]);
                (i, after.0 - before.0, change)
            })
            .collect()
    }

    /// Mean temperature and output of up to five blocks before or behind a place, of the same stretch.
    fn side(&self, at: usize, behind: bool) -> (f64, Triple) {
        let here = if behind { at } else { at - 1 };
        let same = |i: &usize| {
            self.stretch[*i] == self.stretch[here] && self.attitude[*i] == self.attitude[here]
        };
        let members: Vec<usize> = if behind {
            (at..self.len()).take_while(same).take(5).collect()
        } else {
            (0..at).rev().take_while(same).take(5).collect()
        };
        let count = members.len().max(1) as f64;
        let mut mean = (0.0, [0.0; 3]);
        for i in members {
            mean.0 += self.temperature[i] / count;
            for axis in 0..3 {
                mean.1[axis] += self.output[i][axis] / count;
            }
        }
        mean
    }

    fn find_attitudes(&mut self) {
        let change = |a: Triple, b: Triple| norm([b[0] - a[0], b[1] - a[1], b[2] - a[2]]);
        let changes: Vec<f64> = self.output.windows(2).map(|w| change(w[0], w[1])).collect();
        let typical = median(&mut changes.clone()).unwrap_or(0.0);
        let stepped: Vec<Vec<bool>> = self.environment.iter().map(|e| abrupt(e)).collect();
        let mut number = 0;
        self.attitude = vec![0; self.len()];
        let mut steps = vec![None];
        for (i, size) in changes.iter().enumerate() {
            let kelvin = (self.temperature[i + 1] - self.temperature[i]).abs();
            let sudden = SUDDEN + SUDDEN_PER_KELVIN * kelvin;
            let surroundings = *size < TURNED && stepped.iter().any(|s| s[i]);
            if *size > sudden && *size > MEDIANS * typical && !surroundings {
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
        self.environment = self.environment.iter().map(|e| pick(e)).collect();
        self.stretch = kept.iter().map(|i| self.stretch[*i]).collect();
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

/// Between which two blocks a quantity goes through more than its share of the range, far above the usual change.
fn abrupt(quantity: &[f64]) -> Vec<bool> {
    let [low, high] = range(quantity.iter().copied());
    let changes: Vec<f64> = quantity.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    let usual = median(&mut changes.clone()).unwrap_or(0.0);
    let most = (JUMP * (high - low)).max(ABRUPT * usual);
    changes.iter().map(|c| *c > most).collect()
}

fn names(axes: usize) -> &'static [&'static str] {
    match axes {
        1 => &["output"],
        _ => &["x", "y", "z"],
    }
}

fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| {
        [a.min(v), b.max(v)]
    })
}

/// Samples before which the temperature jumps.
fn jumps(temperature: &[f64]) -> Vec<usize> {
    let [low, high] = range(temperature.iter().copied());
    let steps: Vec<f64> = temperature
        .windows(2)
        .map(|w| (w[1] - w[0]).abs())
        .collect();
    let typical = median(&mut steps.clone()).unwrap_or(0.0);
    let moved = steps.iter().copied().filter(|s| *s > 0.0);
    // A thermometer of few digits goes in steps of its own.
    let digit = moved.fold(f64::INFINITY, f64::min);
    let least = (JUMP * (high - low)).max(12.0 * typical).max(3.0 * digit);
    let beside = |i: usize| steps.get(i).copied().unwrap_or(0.0);
    (0..steps.len())
        .filter(|&i| {
            let neighbours = beside(i + 1).max(if i > 0 { beside(i - 1) } else { 0.0 });
            steps[i] > least && steps[i] > ABRUPT * neighbours
        })
        .map(|i| i + 1)
        .collect()
}
