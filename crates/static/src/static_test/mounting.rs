//! How a sensor sits on a machine or vehicle: gravity tells the vertical, a straight acceleration the direction of travel.

use super::readings::not_negative;
use super::{ReadingResidual, StaticFit};
use crate::direction_coverage::unit;
use crate::findings;
use crate::{MeanNoise, Samples, Segment, Triple};
use proofmass_core::{Error, Matrix3, STANDARD_GRAVITY, TaitBryan, check, dot};
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding, Influence,
};
use serde::{Deserialize, Serialize};

/// Parts into which the accelerations along the travel are cut.
const BLOCKS: usize = 16;
/// Least mean acceleration along the travel, m/s².
const WEAKEST: f64 = 0.1;
/// Standard uncertainty of the direction of travel beyond which there is none, rad.
const NO_DIRECTION: f64 = 0.2;
/// By which the means of parts of a rest may differ, rad.
const STILL: f64 = 4.4e-3;
/// Largest standard uncertainty of an angle, rad.
const LARGEST: f64 = 0.5;

/// Roll, pitch and yaw of a sensor in the frame of a machine or vehicle, x forward, y to the left, z up, from a rest on level ground and from
/// accelerations on a straight line.
///
/// ```text
/// z = r/|r|,   h = d − (d·z) z,   x = h/|h|,   y = z × x,   R = (x, y, z)ᵀ
/// ```
///
/// r is the mean output at rest, d the mean of accelerating outputs less r, turned round for braking. A bias is in z by b/g, and not in d.
///
/// **Uncertainty**: noise of the rest with its autocorrelation ([`MeanNoise`]), scatter of the direction over sixteen parts of the travel
/// (Student's t), and what is stated of ground, bias and straightness, under one covariance of a small turn about the axes of the machine.
/// **Units** outputs in m/s², angles in rad. **Assumes** the same inclination of the body at rest and in the mean of the travel along y: a body
/// that squats about y changes the length of h alone. **Source** `[ISO8855]`, axes and angles. **Accuracy** `coverage_mounting`.
#[doc(alias("alignment", "installation angles", "misalignment"))]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct Mounting {
    /// Samples at rest: the first, and one past the last.
    pub rest: [usize; 2],
    /// Samples while the machine accelerates forward on a straight line.
    pub forward: Vec<[usize; 2]>,
    /// Samples while it brakes, or accelerates backward, on a straight line.
    pub braking: Vec<[usize; 2]>,
    /// Standard uncertainty of the level of the ground at rest about each horizontal axis, rad.
    pub levelling: f64,
    /// Standard uncertainty of the bias of each axis, m/s².
    pub bias: f64,
    /// Standard uncertainty of the direction of travel in the frame of the machine, rad.
    pub straightness: f64,
}

/// A turn as it was found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MountedTurn {
    /// Roll, pitch and yaw, rad.
    pub angles: Triple,
    /// Covariance of a small turn about x, y, z of the machine, rad².
    pub covariance: [Triple; 3],
}

impl MountedTurn {
    /// Whether the covariance is one: finite, symmetric, no negative variance in any direction.
    pub fn is_sound(&self) -> bool {
        let c = &self.covariance;
        let rows = c.as_flattened();
        let symmetric = (0..3).all(|i| (0..i).all(|j| c[i][j] == c[j][i]));
        let finite = rows.iter().chain(&self.angles).all(|v| v.is_finite());
        finite && symmetric && Covariance::try_from_rows(3, rows).is_ok()
    }
}

/// Rows x, y, z of the machine in the axes of the sensor, from the mean at rest and along the travel.
fn axes(rest: Triple, travel: Triple) -> Option<Matrix3<f64>> {
    let z = unit(rest)?;
    let change: Triple = std::array::from_fn(|i| travel[i] - rest[i]);
    let up = dot(change, z);
    let x = unit(std::array::from_fn(|i| change[i] - up * z[i]))?;
    let y = cross(z, x);
    Some(Matrix3([x, y, z]))
}

fn cross(a: Triple, b: Triple) -> Triple {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Small turn about the axes of the machine that takes one frame to another near it.
fn turn_between(from: &Matrix3<f64>, to: &Matrix3<f64>) -> Triple {
    let d = to.product(&from.transpose()).0;
    [
        0.5 * (d[2][1] - d[1][2]),
        0.5 * (d[0][2] - d[2][0]),
        0.5 * (d[1][0] - d[0][1]),
    ]
}

impl Mounting {
    /// The angles with their covariance.
    ///
    /// # Errors
    /// [`Error::TooFew`] without a rest of a hundred samples or without travel; [`Error::OutOfRange`] for samples beyond the recording and
    /// negative uncertainties; [`Error::Unobservable`] where the travel has no acceleration of 0.1 m/s² or no direction.
    pub fn fit(&self, outputs: [&[f64]; 3]) -> Result<(StaticFit, MountedTurn), Error> {
        not_negative("uncertainty of the bias", self.bias)?;
        // Beyond it the ground has no level, and the angles no linear law of propagation.
        check::within("levelling", self.levelling, 0.0, LARGEST)?;
        check::within("straightness", self.straightness, 0.0, LARGEST)?;
        self.apart()?;
        let [x, y, z] = outputs;
        let samples = Samples::new(x, y, z)?;
        let rest = self.stretch(self.rest, 100, samples.len())?;
        let noise = MeanNoise::estimate(&samples, std::slice::from_ref(&rest))?;
        let at_rest = samples.mean(rest.start, rest.end);
        let parts = self.parts(&samples, at_rest)?;
        let n = parts.len();
        let mean: Triple =
            std::array::from_fn(|i| parts.iter().map(|p| p[i]).sum::<f64>() / n as f64);
        let travel: Triple = std::array::from_fn(|i| at_rest[i] + mean[i]);
        let unobservable = Error::Unobservable {
            parameter: "direction of travel",
            condition: f64::INFINITY,
        };
        let frame = axes(at_rest, travel).ok_or(unobservable)?;
        let [along, _, up] = frame.times(mean);
        // Scatter of the parts about their mean, in the axes of the machine.
        let turned: Vec<Triple> = parts.iter().map(|p| frame.times(*p)).collect();
        let freedom = (n - 1) as f64;
        let sideways = turned.iter().map(|p| p[1] * p[1]).sum::<f64>() / (freedom * n as f64);
        if !(along >= WEAKEST && sideways.sqrt() / along < NO_DIRECTION) {
            return Err(unobservable);
        }
        let mut of_mean = vec![0.0; 9];
        for i in 0..3 {
            for j in 0..3 {
                let sum = parts.iter().map(|p| (p[i] - mean[i]) * (p[j] - mean[j]));
                of_mean[3 * i + j] = sum.sum::<f64>() / (freedom * n as f64);
            }
        }
        let stated = TaitBryan::of_matrix(&frame).angles();
        // Derivatives of a small turn, and of the angles, by what is shifted.
        let derivative = |shift: &dyn Fn(f64) -> Option<Matrix3<f64>>, step: f64| -> [Triple; 2] {
            let [low, high] = [-step, step].map(|h| shift(h).unwrap_or(frame));
            let turn = turn_between(&low, &high).map(|v| v / (2.0 * step));
            let [low, high] = [low, high].map(|f| TaitBryan::of_matrix(&f).angles());
            let angle = std::array::from_fn(|i| {
                let turn = std::f64::consts::TAU;
                let d = high[i] - low[i];
                (d - turn * (d / turn).round()) / (2.0 * step)
            });
            [angle, turn]
        };
        let moved = |v: Triple, axis: usize, h: f64| -> Triple {
            std::array::from_fn(|i| v[i] + if i == axis { h } else { 0.0 })
        };
        let small = 1e-5 * along;
        let by_rest: [[Triple; 2]; 3] = std::array::from_fn(|axis| {
            derivative(&|h| axes(moved(at_rest, axis, h), travel), small)
        });
        let by_travel: [[Triple; 2]; 3] = std::array::from_fn(|axis| {
            derivative(&|h| axes(at_rest, moved(travel, axis, h)), small)
        });
        let by_bias: [[Triple; 2]; 3] = std::array::from_fn(|axis| {
            derivative(
                &|h| axes(moved(at_rest, axis, h), moved(travel, axis, h)),
                small,
            )
        });
        // Small turns of the frame itself: unlevel ground about x and y, a direction that is off about z.
        let by_turn: [[Triple; 2]; 3] = std::array::from_fn(|axis| {
            derivative(&|h| Some(small_turn(axis, h).product(&frame)), 1e-5)
        });
        let mut covariance = [[0.0; 3]; 3];
        let mut influences = Vec::new();
        let mut joint = |key: &str, description: &str, by: &[[Triple; 2]; 3], of: &[f64], dof| {
            let through = |which: usize| -> Vec<f64> {
                let mut out = vec![0.0; 9];
                for a in 0..3 {
                    for b in 0..3 {
                        for i in 0..3 {
                            for j in 0..3 {
                                out[3 * a + b] += by[i][which][a] * of[3 * i + j] * by[j][which][b];
                            }
                        }
                    }
                }
                symmetric(out)
            };
            let turn = through(1);
            for a in 0..3 {
                for b in 0..3 {
                    covariance[a][b] += turn[3 * a + b];
                }
            }
            let covariance = Covariance::try_from_rows(3, &through(0))?;
            influences.push(Influence {
                key: key.to_owned(),
                description: description.to_owned(),
                evaluation: if key == "rest" || key == "travel" {
                    Evaluation::A
                } else {
                    Evaluation::B
                },
                distribution: if key == "travel" { "t" } else { "normal" }.to_owned(),
                dof,
                effect: Effect::Joint { covariance },
            });
            Ok::<(), Error>(())
        };
        let known = DegreesOfFreedom::INFINITE;
        let independent = |u: Triple| -> Vec<f64> {
            (0..9)
                .map(|k| if k % 4 == 0 { u[k / 4] * u[k / 4] } else { 0.0 })
                .collect()
        };
        let own = noise.of_mean(rest.len());
        joint(
            "rest",
            "noise of the mean at rest",
            &by_rest,
            own.as_flattened(),
            noise.dof(),
        )?;
        let dof = DegreesOfFreedom::new(freedom).unwrap_or(known);
        joint(
            "travel",
            "scatter of the direction of travel",
            &by_travel,
            &of_mean,
            dof,
        )?;
        for (key, description, by, u) in [
            ("bias", "bias of the axes", &by_bias, [self.bias; 3]),
            (
                "levelling",
                "the ground is not level",
                &by_turn,
                [self.levelling, self.levelling, 0.0],
            ),
            (
                "straightness",
                "the travel is not along the x axis of the machine",
                &by_turn,
                [0.0, 0.0, self.straightness],
            ),
        ] {
            if u != [0.0; 3] {
                joint(key, description, by, &independent(u), known)?;
            }
        }
        let components = ["roll", "pitch", "yaw"].into_iter().zip(stated);
        let components = components.map(|(name, value)| Component::new(name, "rad", value));
        let estimate = Estimate::new(components.collect(), influences)?;
        let residual = |(k, p): (usize, &Triple)| ReadingResidual {
            input: k as f64 + 1.0,
            output: (p[1] / p[0]).atan().to_degrees(),
            model: 0.0,
        };
        let fit = StaticFit {
            estimate,
            readings: turned.iter().enumerate().map(residual).collect(),
            input: "part of the travel".to_owned(),
            unit: "°".to_owned(),
            scatter: None,
            nonlinearity: None,
            orders: Vec::new(),
            departures: Vec::new(),
            harmonics: Vec::new(),
            findings: {
                let mut findings = self.doubts(at_rest, [along, up], covariance[2][2]);
                findings.extend(Self::moves(&samples, &rest));
                findings
            },
        };
        let turn = MountedTurn {
            angles: stated,
            covariance,
        };
        Ok((fit, turn))
    }

    /// No sample is in two stretches.
    fn apart(&self) -> Result<(), Error> {
        let mut all: Vec<[usize; 2]> = [&[self.rest][..], &self.forward, &self.braking].concat();
        all.sort_unstable();
        match all.windows(2).find(|w| w[1][0] < w[0][1]) {
            None => Ok(()),
            Some(w) => Err(Error::OutOfRange {
                name: "first sample of a stretch behind another",
                value: w[1][0] as f64,
                min: w[0][1] as f64,
                max: f64::MAX,
            }),
        }
    }

    fn stretch(
        &self,
        [start, end]: [usize; 2],
        least: usize,
        all: usize,
    ) -> Result<Segment, Error> {
        if end > all || start >= end {
            return Err(Error::OutOfRange {
                name: "end of a stretch",
                value: end as f64,
                min: start as f64 + 1.0,
                max: all as f64,
            });
        }
        if end - start < least {
            return Err(Error::TooFew {
                name: "samples of a stretch",
                needed: least,
                got: end - start,
            });
        }
        Ok(Segment {
            start,
            end,
            attitude: None,
            force_uncertainty: None,
            label: None,
        })
    }

    /// Means of parts of the travel less the rest, all as if they were forward.
    fn parts(&self, samples: &Samples<'_>, rest: Triple) -> Result<Vec<Triple>, Error> {
        let ways = [(&self.forward, 1.0), (&self.braking, -1.0)];
        let mut stretches = Vec::new();
        for (way, sign) in ways {
            for range in way {
                stretches.push((self.stretch(*range, BLOCKS, samples.len())?, sign));
            }
        }
        let all: usize = stretches.iter().map(|(s, _)| s.len()).sum();
        if all == 0 {
            return Err(Error::TooFew {
                name: "stretches of travel",
                needed: 1,
                got: 0,
            });
        }
        let mut parts = Vec::new();
        for (stretch, sign) in &stretches {
            let count = ((BLOCKS * stretch.len()).div_ceil(all)).max(2);
            for k in 0..count {
                let at = |k: usize| stretch.start + k * stretch.len() / count;
                let mean = samples.mean(at(k), at(k + 1));
                parts.push(std::array::from_fn(|i| sign * (mean[i] - rest[i])));
            }
        }
        Ok(parts)
    }

    /// The means of sixteen parts of the rest differ by more than a quarter of a degree, and by more than the noise from sample to sample
    /// tells.
    fn moves(samples: &Samples<'_>, rest: &Segment) -> Option<Finding> {
        let at = |k: usize| rest.start + k * rest.len() / BLOCKS;
        let parts: Vec<Triple> = (0..BLOCKS)
            .map(|k| samples.mean(at(k), at(k + 1)))
            .collect();
        let axes = samples.columns();
        let mut seen = false;
        let mut most = [0.0f64; 3];
        for (axis, most) in most.iter_mut().enumerate() {
            let column = &axes[axis][rest.start..rest.end];
            let steps = column.windows(2).map(|w| (w[1] - w[0]).powi(2));
            let noise = (0.5 * steps.sum::<f64>() / (column.len() - 1) as f64).sqrt();
            let of_part = noise / ((rest.len() / BLOCKS) as f64).sqrt();
            let fold = |f: fn(f64, f64) -> f64, from| parts.iter().map(|p| p[axis]).fold(from, f);
            *most = fold(f64::max, f64::NEG_INFINITY) - fold(f64::min, f64::INFINITY);
            // The range of sixteen normal means passes eight standard deviations in one of 10⁶ rests.
            seen |= *most > 8.0 * of_part;
        }
        let angle = dot(most, most).sqrt() / STANDARD_GRAVITY;
        (seen && angle > STILL).then(|| findings::rest_moves(angle.to_degrees()))
    }

    fn doubts(&self, rest: Triple, [along, up]: [f64; 2], about_z: f64) -> Vec<Finding> {
        let mut findings = Vec::new();
        let read = dot(rest, rest).sqrt();
        if (read / STANDARD_GRAVITY - 1.0).abs() > 0.05 {
            findings.push(findings::rest_is_not_gravity(read));
        }
        // A body that squats, or a road that rises, by five degrees changes the vertical by this much.
        if up.abs() > 0.1 * along && up.abs() > 0.2 {
            findings.push(findings::travel_leaves_the_level(up, along));
        }
        let u = about_z.sqrt().to_degrees();
        if u > 2.0 {
            findings.push(findings::travel_not_straight(u));
        }
        if self.levelling == 0.0 {
            findings.push(proofmass_uncertainty::findings::level_taken_as_exact(
                "the ground at rest",
                "a slope of 1 % is 0.6° of roll or pitch",
                "state the standard uncertainty of its level, or turn the vehicle by 180° and average",
            ));
        }
        findings
    }
}

/// A small turn about an axis, exact to second order.
fn small_turn(axis: usize, angle: f64) -> Matrix3<f64> {
    let (s, c) = angle.sin_cos();
    let mut m = Matrix3::identity();
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    m.0[i][i] = c;
    m.0[j][j] = c;
    m.0[i][j] = -s;
    m.0[j][i] = s;
    m
}

fn symmetric(rows: Vec<f64>) -> Vec<f64> {
    (0..9)
        .map(|k| 0.5 * (rows[k] + rows[3 * (k % 3) + k / 3]))
        .collect()
}
