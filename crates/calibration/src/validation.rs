//! Does a calibration hold on new standstills?

use crate::direction_coverage::unit;
use crate::multi_position::{BIAS, ELEMENT};
use crate::{Pose, Triple};
use faer::prelude::*;
use faer::{Mat, Side};
use proofmass_core::{Error, Gravity, STANDARD_GRAVITY, SensorModel, norm};
use proofmass_uncertainty::{Effect, Estimate, Finding, Severity};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// One new standstill under a calibration.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct AttitudeCheck {
    /// Name of the standstill.
    pub name: String,
    /// First sample and one past the last.
    pub samples: (usize, usize),
    /// Compensated acceleration, m/s².
    pub acceleration: Triple,
    /// ‖a‖ − g, m/s².
    pub residual: f64,
    /// Standard uncertainty of that residual: noise of the mean, calibration, gravity, m/s².
    pub standard_uncertainty: f64,
    /// │‖a‖ − g│/g.
    pub relative: f64,
    /// Whether it meets the 0.1 % rule.
    pub within_rule: bool,
}

/// A calibration put to the test on standstills it was not made from.
///
/// **Source** the 0.1 % rule: good practice of accelerometer compensation; χ²: `[GUM]` H.3 in matrix form.
#[doc(alias("verification", "cross-validation"))]
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Validation {
    /// One per standstill.
    pub attitudes: Vec<AttitudeCheck>,
    /// Root mean square of ‖ã/s‖ − g with the nominal sensitivity s and no compensation, in mg (10⁻³ standard
    /// gravity); `None` for raw outputs without nominal sensitivity.
    pub rms_before_mg: Option<f64>,
    /// Root mean square of ‖a‖ − g after compensation, in mg.
    pub rms_after_mg: f64,
    /// χ² of the residuals against their joint covariance.
    pub chi_square: f64,
    /// Its degrees of freedom: the number of standstills.
    pub degrees_of_freedom: usize,
    /// Probability that a χ² at least this large arises when the stated covariance is right.
    pub p_value: f64,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

/// Share of g within which a compensated standstill must lie.
const RULE: f64 = 1e-3;

/// A calibration as validation needs it.
#[derive(Clone, Copy, Debug)]
pub struct Calibrated<'a> {
    /// The compensation.
    pub sensor: &'a SensorModel<f64>,
    /// Its quantities (`bias.x`, …) with their joint covariance.
    pub estimate: &'a Estimate,
    /// Gravity it was made with.
    pub gravity: Gravity,
    /// Standard deviation of one standstill about the model beyond its noise, m/s².
    pub repeatability: f64,
    /// Output per m/s² of an uncompensated sensor, for the comparison before and after.
    pub nominal_sensitivity: Option<f64>,
}

impl Validation {
    /// Compares new standstills with gravity.
    ///
    /// `gravity`: at the place of validation; `None` when it is the very gravity of the calibration, whose error
    /// is then common to both and nearly cancels.
    ///
    /// # Errors
    /// [`Error::TooFew`] without a standstill; [`Error::NotFinite`] for an output that is not a number.
    pub fn run(
        calibration: &Calibrated<'_>,
        gravity: Option<Gravity>,
        poses: &[Pose],
    ) -> Result<Self, Error> {
        if poses.is_empty() {
            return Err(Error::TooFew {
                name: "standstills",
                needed: 1,
                got: 0,
            });
        }
        let here = gravity.unwrap_or(calibration.gravity);
        let g = here.value();
        let n = poses.len();
        let accelerations: Vec<Triple> = poses
            .iter()
            .map(|p| calibration.sensor.apply(p.mean))
            .collect();
        let residuals: Vec<f64> = accelerations.iter().map(|a| norm(*a) - g).collect();
        if let Some(index) = residuals.iter().position(|r| !r.is_finite()) {
            return Err(Error::NotFinite {
                name: "compensated acceleration",
                index,
            });
        }
        let v = covariance(calibration, gravity, poses, &accelerations)?;
        let r = Mat::from_fn(n, 1, |i, _| residuals[i]);
        let llt = v.llt(Side::Lower).map_err(|_| Error::NotPositiveDefinite {
            name: "covariance of the residuals",
            row: 0,
            column: 0,
            value: v[(0, 0)],
        })?;
        let solved = llt.solve(&r);
        let chi_square: f64 = (0..n).map(|i| solved[(i, 0)] * residuals[i]).sum();
        let p_value = ChiSquared::new(n as f64).map_or(0.0, |d| 1.0 - d.cdf(chi_square));
        let rms = |values: &mut dyn Iterator<Item = f64>| {
            1e3 / STANDARD_GRAVITY * (values.map(|v| v * v).sum::<f64>() / n as f64).sqrt()
        };
        let attitudes: Vec<AttitudeCheck> = (0..n)
            .map(|i| AttitudeCheck {
                name: poses[i].name(i),
                samples: (poses[i].segment.start, poses[i].segment.end),
                acceleration: accelerations[i],
                residual: residuals[i],
                standard_uncertainty: v[(i, i)].sqrt(),
                relative: residuals[i].abs() / g,
                within_rule: residuals[i].abs() <= RULE * g,
            })
            .collect();
        let rms_before_mg = calibration
            .nominal_sensitivity
            .map(|s| rms(&mut poses.iter().map(|p| norm(p.mean) / s - g)));
        let mut validation = Self {
            attitudes,
            rms_before_mg,
            rms_after_mg: rms(&mut residuals.iter().copied()),
            chi_square,
            degrees_of_freedom: n,
            p_value,
            findings: Vec::new(),
        };
        validation.findings = validation.doubts(g);
        Ok(validation)
    }

    fn doubts(&self, g: f64) -> Vec<Finding> {
        let mut findings = Vec::new();
        let beyond: Vec<&AttitudeCheck> =
            self.attitudes.iter().filter(|a| !a.within_rule).collect();
        if let Some(worst) = beyond
            .iter()
            .max_by(|a, b| a.relative.total_cmp(&b.relative))
        {
            findings.push(
                Finding::new(
                    Severity::Decision,
                    "beyond-one-per-mille",
                    format!("{} of {} standstills miss the 0.1 % rule", beyond.len(), self.attitudes.len()),
                )
                .evidence(format!(
                    "worst is standstill {}: │‖a‖ − g│/g = {:.3} % ({:+.2} mm/s²)",
                    worst.name,
                    1e2 * worst.relative,
                    1e3 * worst.residual
                ))
                .advice(format!(
                    "calibrate again, at the temperature of use; check that g = {g:.4} m/s² holds here"
                )),
            );
        }
        if self.p_value < 0.01 {
            findings.push(
                Finding::new(
                    Severity::Warning,
                    "inconsistent-with-covariance",
                    "the residuals are larger than the stated covariance explains",
                )
                .evidence(format!(
                    "χ² = {:.1} with {} degrees of freedom, probability {:.1e}",
                    self.chi_square, self.degrees_of_freedom, self.p_value
                ))
                .advice("the sensor has moved since (temperature, time, mounting), or the standstills were not still"),
            );
        }
        findings
    }
}

/// Joint covariance of the residuals: noise and repeatability on the diagonal, calibration and gravity common.
fn covariance(
    calibration: &Calibrated<'_>,
    gravity: Option<Gravity>,
    poses: &[Pose],
    accelerations: &[Triple],
) -> Result<Mat<f64>, Error> {
    let n = poses.len();
    let estimate = calibration.estimate;
    let p = estimate.components().len();
    let k = calibration.sensor.k();
    let inverse_transpose = calibration.sensor.k_inverse().transpose();
    let index = |name: &str| estimate.index_of(name);
    let mut j = Mat::<f64>::zeros(n, p);
    let mut v = Mat::<f64>::zeros(n, n);
    for (row, (pose, a)) in poses.iter().zip(accelerations).enumerate() {
        let Some(direction) = unit(*a) else {
            return Err(Error::NotFinite {
                name: "direction of a standstill",
                index: row,
            });
        };
        let w = inverse_transpose.times(direction);
        // dr = −wᵀ (dK a + db), with K_ij = misalignment_ij · scale_i.
        for i in 0..3 {
            if let Some(c) = index(BIAS[i]) {
                j[(row, c)] = -w[i];
            }
            if let Some(c) = index(ELEMENT[i][i]) {
                let along: f64 = (0..3).map(|l| k.0[i][l] / k.0[i][i] * a[l]).sum();
                j[(row, c)] = -w[i] * along;
            }
            for l in (0..3).filter(|l| *l != i) {
                if let Some(c) = index(ELEMENT[i][l]) {
                    j[(row, c)] = -w[i] * k.0[i][i] * a[l];
                }
            }
        }
        let noise = pose
            .covariance
            .map_or(0.0, |c| crate::multi_position::quadratic_form(&c, w));
        v[(row, row)] = noise.max(0.0) + calibration.repeatability.powi(2);
    }
    let ones = Mat::from_fn(n, 1, |_, _| 1.0);
    for influence in estimate.influences() {
        match &influence.effect {
            Effect::Scalar {
                standard_uncertainty: u,
                sensitivity,
                ..
            } => {
                let s = Mat::from_fn(p, 1, |i, _| sensitivity[i]);
                let mut c = &j * &s;
                if influence.key == "gravity" && gravity.is_none() {
                    c -= &ones;
                }
                v += &c * c.transpose() * faer::Scale(u * u);
            }
            joint => {
                v += &j * joint.covariance(p)?.to_mat() * j.transpose();
            }
        }
    }
    if let Some(g) = gravity {
        v += &ones * ones.transpose() * faer::Scale(g.standard_uncertainty().powi(2));
    }
    Ok(v)
}
