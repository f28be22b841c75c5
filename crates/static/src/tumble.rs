//! A continuous slow tumble as readings: every sample counts, and none of them as more independent than it is.

use crate::direction_coverage::unit;
use crate::multi_position::Problem;
use crate::{
    MultiPosition, Pose, Samples, Segment, StandstillCalibration, ThresholdSweep, Triple, findings,
};
use proofmass_core::numeric::median;
use proofmass_core::{Error, Matrix3, SensorModel, dot, norm};
use proofmass_uncertainty::Finding;

/// Blocks wanted: enough for their correlation to be seen.
const BLOCKS: usize = 240;
/// Largest median turn from block to block, rad: within a block the direction counts as one.
const TURN: f64 = 0.2;
/// Samples that the first fit is made of.
const FIRST: usize = 2000;
const ITERATIONS: usize = 8;
/// A sensor held in the hand lies about this far from the axis it is turned about, m.
const LEVER: f64 = 0.05;
/// Share of g beyond which what the motion adds is worth a warning.
const RULE: f64 = 1e-3;

/// A tumble cut into blocks, each with the mean magnitude of its samples in its mean direction.
///
/// Averages of the outputs would be short, for the directions in a block differ; averages of the magnitude are not.
/// The blocks share errors with their neighbours (a hand that sways), so that they count as fewer: n/λ, with
/// λ = 1 + 2 Σ ρ_k of the residuals, summed over pairs of lags while the pairs are positive.
///
/// Accelerations across gravity lengthen a magnitude by s²/g in the mean, s² the variance of the magnitudes: this is
/// taken off, and half of it stands in the budget.
///
/// **Assumes** slow turning about an axis near the sensor: ω² r of a lever arm r stays in the readings.
///
/// **Source** `[Geyer1992]` (initial positive sequence).
#[derive(Clone, Debug)]
struct Tumble {
    segments: Vec<Segment>,
    poses: Vec<Pose>,
    /// Blocks that count as independent.
    effective: f64,
    /// By how much a magnitude is too long in the mean, m/s².
    lengthened: f64,
    /// Median rate of turning, rad/s.
    turning: f64,
}

impl StandstillCalibration {
    /// Fits the model to all samples of a continuous slow tumble.
    ///
    /// `rate` in samples per second; `breaks` are samples before which time jumps.
    ///
    /// # Errors
    /// [`Error::TooFew`] for a tumble whose independent parts are fewer than the parameters; those of
    /// [`MultiPosition::fit`].
    pub fn of_tumble(
        samples: &Samples<'_>,
        rate: f64,
        breaks: &[usize],
        settings: &MultiPosition,
    ) -> Result<Self, Error> {
        let tumble = Tumble::of(samples, rate, breaks, settings)?;
        let settings = settings
            .clone()
            .successive(tumble.effective, 0.5 * tumble.lengthened);
        let mut fit = settings.fit(&tumble.poses)?;
        fit.findings
            .extend(tumble.findings(settings.gravity_value()));
        Ok(Self {
            sweep: ThresholdSweep::given(tumble.segments),
            noise: None,
            fit,
        })
    }
}

impl Tumble {
    fn of(
        samples: &Samples<'_>,
        rate: f64,
        breaks: &[usize],
        settings: &MultiPosition,
    ) -> Result<Self, Error> {
        let n = samples.len();
        let needed = 4 * settings.parameters();
        if n < needed {
            return Err(Error::TooFew {
                name: "samples of the tumble",
                needed,
                got: n,
            });
        }
        let mut sensor = first(samples, settings)?;
        let mut length = n.div_ceil(BLOCKS);
        let mut segments = cut(n, length, breaks);
        while length > 1 && turns(samples, &sensor, &segments) > TURN {
            length = length.div_ceil(2);
            segments = cut(n, length, breaks);
        }
        let g = settings.gravity_value();
        let mut tumble = Self {
            poses: Vec::new(),
            effective: segments.len() as f64,
            lengthened: 0.0,
            turning: turns(samples, &sensor, &segments) * rate / length as f64,
            segments,
        };
        let mut residuals = Vec::new();
        for _ in 0..ITERATIONS {
            tumble.reduce(samples, &sensor, g);
            let problem = Problem::new(settings, &tumble.poses)?;
            let (solution, _) = problem.first()?;
            let next = problem.sensor(&solution.parameters)?;
            let moved = difference(&sensor, &next);
            sensor = next;
            residuals = solution.equations.residual;
            // A thousandth of the smallest uncertainty that a tumble could have.
            if moved < 1e-8 {
                break;
            }
        }
        // The fit has taken its parameters out of the residuals, and with them that much of what they share.
        tumble.effective =
            residuals.len() as f64 / inefficiency(&residuals) - settings.parameters() as f64;
        let needed = settings.parameters() + 2;
        if tumble.effective < needed as f64 {
            return Err(Error::TooFew {
                name: "independent parts of the tumble",
                needed,
                got: tumble.effective as usize,
            });
        }
        Ok(tumble)
    }

    /// The blocks as this sensor sees them.
    fn reduce(&mut self, samples: &Samples<'_>, sensor: &SensorModel<f64>, g: f64) {
        let [x, y, z] = samples.columns();
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
        let mut means: Vec<(f64, Triple)> = Vec::with_capacity(self.segments.len());
        for segment in &self.segments {
            let (mut length, mut direction) = (0.0, [0.0; 3]);
            for i in segment.start..segment.end {
                let a = sensor.apply([x[i], y[i], z[i]]);
                let magnitude = norm(a);
                length += magnitude;
                for (d, a) in direction.iter_mut().zip(a) {
                    *d += a;
                }
                sum += magnitude - g;
                squares += (magnitude - g).powi(2);
                count += 1.0;
            }
            let up = unit(direction).unwrap_or([0.0, 0.0, 1.0]);
            means.push((length / segment.len() as f64, up));
        }
        let mean = sum / count;
        self.lengthened = (squares / count - mean * mean).max(0.0) / g;
        let at = |values: &[f64], s: &Segment| {
            values[s.start..s.end].iter().sum::<f64>() / s.len() as f64
        };
        self.poses = means
            .into_iter()
            .zip(&self.segments)
            .map(|((length, up), segment)| Pose {
                time: samples.time().map(|t| at(t, segment)),
                temperature: samples.temperature().map(|t| at(t, segment)),
                ..Pose::reading(
                    segment.clone(),
                    sensor.invert(up.map(|u| u * (length - self.lengthened))),
                )
            })
            .collect();
    }

    fn findings(&self, g: f64) -> Vec<Finding> {
        let mut findings = Vec::new();
        let pull = self.turning.powi(2) * LEVER;
        if pull > RULE * g {
            findings.push(findings::tumble_fast(self.turning, 1e3 * pull / g, LEVER));
        }
        if self.lengthened > RULE * g {
            findings.push(findings::tumble_shaken(
                (self.lengthened * g).sqrt(),
                1e3 * self.lengthened / g,
            ));
        }
        findings
    }
}

/// A fit to samples here and there.
fn first(samples: &Samples<'_>, settings: &MultiPosition) -> Result<SensorModel<f64>, Error> {
    let poses: Vec<Pose> = (0..samples.len())
        .step_by(samples.len().div_ceil(FIRST))
        .map(|i| {
            let segment = Segment {
                start: i,
                end: i + 1,
                attitude: None,
                force_uncertainty: None,
                label: None,
            };
            Pose::reading(segment, samples.mean(i, i + 1))
        })
        .collect();
    let problem = Problem::new(settings, &poses)?;
    let (solution, _) = problem.first()?;
    problem.sensor(&solution.parameters)
}

/// Blocks of a length that reach across no break; a rest shorter than half a block is left out.
fn cut(n: usize, length: usize, breaks: &[usize]) -> Vec<Segment> {
    let mut segments = Vec::new();
    let mut lower = 0;
    for upper in breaks.iter().copied().filter(|b| *b < n).chain([n]) {
        let mut start = lower;
        while upper > start && 2 * (upper - start) >= length {
            let end = (start + length).min(upper);
            segments.push(Segment {
                start,
                end,
                attitude: None,
                force_uncertainty: None,
                label: None,
            });
            start = end;
        }
        lower = upper;
    }
    segments
}

/// Median angle between the directions of successive blocks, rad.
fn turns(samples: &Samples<'_>, sensor: &SensorModel<f64>, segments: &[Segment]) -> f64 {
    let directions: Vec<Triple> = segments
        .iter()
        .filter_map(|s| unit(sensor.apply(samples.mean(s.start, s.end))))
        .collect();
    let angles = directions
        .windows(2)
        .map(|pair| dot(pair[0], pair[1]).clamp(-1.0, 1.0).acos());
    median(&mut angles.collect::<Vec<_>>()).unwrap_or(0.0)
}

/// Largest difference of K (relative to its size) and b (relative to its output under 1 g).
fn difference(a: &SensorModel<f64>, b: &SensorModel<f64>) -> f64 {
    let size = a.k().0[0][0].abs();
    let of_k = a.k().0.as_flattened().iter().zip(b.k().0.as_flattened());
    let of_b = a.bias().into_iter().zip(b.bias());
    of_k.map(|(x, y)| (x - y).abs() / size)
        .chain(of_b.map(|(x, y)| (x - y).abs() / (9.8 * size)))
        .fold(0.0, f64::max)
}

/// λ = 1 + 2 Σ ρ_k, by how much the variance of a mean exceeds that of independent values; at least 1.
fn inefficiency(values: &[f64]) -> f64 {
    let n = values.len();
    let variance = values.iter().map(|v| v * v).sum::<f64>();
    if !(variance > 0.0) {
        return 1.0;
    }
    let correlation = |lag: usize| {
        let pairs = values.iter().zip(&values[lag..]);
        pairs.map(|(a, b)| a * b).sum::<f64>() / variance
    };
    // ρ₀ + ρ₁, ρ₂ + ρ₃, … of a reversible process are positive and fall; the first that is not is noise.
    let mut sum = -1.0;
    let mut smallest = f64::INFINITY;
    let mut lag = 0;
    while lag + 1 < n / 2 {
        let pair = correlation(lag) + correlation(lag + 1);
        if pair <= 0.0 {
            break;
        }
        smallest = smallest.min(pair);
        sum += 2.0 * smallest;
        lag += 2;
    }
    sum.max(1.0)
}

impl Problem<'_> {
    /// K and b of these parameters.
    fn sensor(&self, parameters: &[f64]) -> Result<SensorModel<f64>, Error> {
        let scale = self.radius / self.gravity;
        let k = self
            .model
            .matrix(parameters)
            .map(|row| row.map(|v| v * scale));
        let bias = std::array::from_fn(|i| self.centre[i] + self.radius * parameters[i]);
        SensorModel::new(Matrix3(k), bias)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_inefficiency_of_a_first_order_process() {
        // ρ_k = 0.8^k: λ = 1.8/0.2 = 9. Of 20 000 values its estimate scatters by some 5 %.
        let mut state = 1u64;
        let mut draw = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let mut v = 0.0;
        let values: Vec<f64> = (0..20_000)
            .map(|_| {
                v = 0.8 * v + draw();
                v
            })
            .collect();
        assert!((inefficiency(&values) / 9.0 - 1.0).abs() < 0.2);
        let white: Vec<f64> = (0..20_000).map(|_| draw()).collect();
        assert!(inefficiency(&white) < 1.2);
    }

    #[test]
    fn known_blocks_end_at_breaks() {
        let blocks = cut(100, 30, &[50]);
        let edges: Vec<(usize, usize)> = blocks.iter().map(|s| (s.start, s.end)).collect();
        assert_eq!(edges, [(0, 30), (30, 50), (50, 80), (80, 100)]);
        // Ten samples before a break are less than half a block.
        assert_eq!(cut(40, 30, &[10])[0].start, 10);
    }
}
