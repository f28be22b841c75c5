//! Bias of axes that lie level.

use super::readings::not_negative;
use super::{ReadingResidual, StaticFit};
use crate::findings;
use crate::{MeanNoise, Samples, Segment};
use proofmass_core::{Error, Gravity};
use proofmass_uncertainty::{
    Component, Covariance, Effect, Estimate, Evaluation, Finding, Influence,
};
use serde::{Deserialize, Serialize};

/// Samples below which the mean of a bias is no mean. **Source** the practice of a hundred samples per position.
const FEWEST: usize = 100;

/// Mean outputs of a resting sensor less what gravity puts on them.
///
/// b_i = mean ã_i − g u_i. The standard uncertainty of a mean counts the autocorrelation of the samples
/// ([`MeanNoise`]); the levelling of the surface turns gravity into the level axes, δ g.
///
/// **Units** outputs in m/s². **Accuracy** `coverage_zero_g`.
#[doc(alias("zero-g offset"))]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ZeroG {
    /// Local gravity.
    pub gravity: Gravity,
    /// Axis that points up (0 x, 1 y, 2 z).
    pub up: usize,
    /// Standard uncertainty of the levelling about each horizontal axis, rad.
    pub levelling: f64,
}

impl ZeroG {
    /// With z up on a perfectly level surface.
    pub fn new(gravity: Gravity) -> Self {
        Self {
            gravity,
            up: 2,
            levelling: 0.0,
        }
    }

    /// Bias of all three axes; that of the axis that points up holds the error of its scale times g.
    ///
    /// # Errors
    /// [`Error::TooFew`] below a hundred samples, [`Error::OutOfRange`], [`Error::Length`], [`Error::NotFinite`].
    pub fn fit(&self, outputs: [&[f64]; 3]) -> Result<StaticFit, Error> {
        not_negative("levelling", self.levelling)?;
        if self.up > 2 {
            return Err(Error::OutOfRange {
                name: "axis that points up",
                value: self.up as f64,
                min: 0.0,
                max: 2.0,
            });
        }
        let [x, y, z] = outputs;
        let samples = Samples::new(x, y, z)?;
        let n = samples.len();
        if n < FEWEST {
            return Err(Error::TooFew {
                name: "samples",
                needed: FEWEST,
                got: n,
            });
        }
        let whole = Segment {
            start: 0,
            end: n,
            attitude: None,
            force_uncertainty: None,
            label: None,
        };
        let noise = MeanNoise::estimate(&samples, &[whole])?;
        let mean = samples.mean(0, n);
        let g = self.gravity.value();
        let components = ["x", "y", "z"].into_iter().enumerate().map(|(i, name)| {
            let pull = if i == self.up { g } else { 0.0 };
            Component::new(format!("bias.{name}"), "m/s²", mean[i] - pull)
        });
        let mut up = vec![0.0; 3];
        up[self.up] = -1.0;
        let mut influences = vec![
            Influence {
                key: "noise".to_owned(),
                description: "noise of the mean, autocorrelation included".to_owned(),
                evaluation: Evaluation::A,
                distribution: "t".to_owned(),
                dof: noise.dof(),
                effect: Effect::Joint {
                    covariance: Covariance::try_from_rows(3, noise.of_mean(n).as_flattened())?,
                },
            },
            Influence::normal(
                "gravity",
                "local gravity",
                Effect::Scalar {
                    value: g,
                    unit: "m/s²".to_owned(),
                    standard_uncertainty: self.gravity.standard_uncertainty(),
                    sensitivity: up,
                },
            ),
        ];
        for axis in (0..3).filter(|a| *a != self.up && self.levelling > 0.0) {
            let mut sensitivity = vec![0.0; 3];
            sensitivity[axis] = g;
            influences.push(Influence::normal(
                format!("levelling.{}", ["x", "y", "z"][axis]),
                "the surface is not level",
                Effect::of_zero("rad", self.levelling, sensitivity),
            ));
        }
        let estimate = Estimate::new(components.collect(), influences)?;
        let mut findings = drift(&samples, &noise);
        findings.extend(self.elsewhere(mean));
        if self.levelling == 0.0 {
            findings.push(proofmass_uncertainty::findings::level_taken_as_exact(
                "the surface",
                "0.05° are 0.87 mg",
                "state the standard uncertainty of the levelling, or turn the sensor by 180° and average",
            ));
        }
        Ok(StaticFit {
            estimate,
            readings: tenths(&samples, mean),
            input: "part of the recording".to_owned(),
            unit: "m/s²".to_owned(),
            scatter: None,
            nonlinearity: None,
            orders: Vec::new(),
            departures: Vec::new(),
            harmonics: Vec::new(),
            findings,
        })
    }
}

/// Share of g beyond which a bias is none of a sensor: parts of the cheapest kind have a tenth.
const IMPLAUSIBLE: f64 = 0.3;

impl ZeroG {
    /// Gravity lies along another axis, or in another unit.
    fn elsewhere(&self, mean: [f64; 3]) -> Option<Finding> {
        const AXES: [&str; 3] = ["x", "y", "z"];
        let g = self.gravity.value();
        let mut bias = mean;
        bias[self.up] -= g;
        let largest = bias.iter().fold(0.0f64, |m, b| m.max(b.abs()));
        if !(largest > IMPLAUSIBLE * g) {
            return None;
        }
        let read = mean
            .iter()
            .zip(AXES)
            .map(|(m, axis)| format!("{axis} {:.4} g", m / g))
            .collect::<Vec<_>>();
        Some(findings::gravity_elsewhere(AXES[self.up], &read.join(", ")))
    }
}

/// Means of ten equal parts of each axis against the whole mean, x first.
fn tenths(samples: &Samples<'_>, mean: [f64; 3]) -> Vec<ReadingResidual> {
    let n = samples.len();
    (0..3)
        .flat_map(|axis| (0..10).map(move |k| (axis, k)))
        .map(|(axis, k)| ReadingResidual {
            input: f64::from(k) + 1.0,
            output: samples.mean(k as usize * n / 10, (k as usize + 1) * n / 10)[axis],
            model: mean[axis],
        })
        .collect()
}

/// The halves of the recording must agree within what the noise of their means allows.
fn drift(samples: &Samples<'_>, noise: &MeanNoise) -> Vec<Finding> {
    let n = samples.len();
    let (first, last) = (samples.mean(0, n / 2), samples.mean(n / 2, n));
    let half = noise.of_mean(n / 2);
    let mut findings = Vec::new();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let difference = last[axis] - first[axis];
        let u = (2.0 * half[axis][axis]).sqrt();
        // Four standard uncertainties: once in sixteen thousand, three axes.
        if difference.abs() > noise.dof().coverage_factor(0.99994) * u {
            findings.push(
                findings::bias_drift(
                    &format!(
                        "second half less first: {:.3} mg, {:.0} standard uncertainties",
                        difference / 9.80665e-3,
                        difference.abs() / u
                    ),
                    "`proofmass noise` tells its stability",
                )
                .of_part(name),
            );
        }
    }
    findings
}
