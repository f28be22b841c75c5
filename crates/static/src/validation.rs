//! Does a calibration hold on new standstills?

use crate::direction_coverage::unit;
use crate::findings;
use crate::multi_position::{BIAS, ELEMENT};
use crate::{Pose, Triple};
use faer::Mat;
use proofmass_core::{Error, Gravity, STANDARD_GRAVITY, SensorModel, norm};
use proofmass_uncertainty::algebra::{cholesky, product, symmetric_eigen};
use proofmass_uncertainty::{Effect, Estimate, Finding};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// One new standstill under a calibration.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
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
#[non_exhaustive]
pub struct Validation {
    /// One per standstill.
    pub attitudes: Vec<AttitudeCheck>,
    /// Root mean square of ‖(ã − z)/s‖ − g with the nominal output, one sensitivity s and one zero z of all axes, and no compensation,
    /// in mg (10⁻³ standard gravity); `None` where no nominal output is known.
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
    /// Output of an uncompensated sensor, for the comparison before and after.
    pub nominal: Option<NominalOutput>,
}

/// What an uncompensated sensor gives: the same for all axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NominalOutput {
    /// Output per m/s².
    pub sensitivity: f64,
    /// Output at no acceleration.
    pub zero: f64,
}

impl Validation {
    /// What compensation takes off the error, per cent of that before; below zero where it adds to it.
    pub fn reduction_percent(&self) -> Option<f64> {
        let before = self.rms_before_mg.filter(|b| *b > 0.0)?;
        Some(100.0 * (1.0 - self.rms_after_mg / before))
    }

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
        proofmass_core::check::finite("compensated acceleration", &residuals)?;
        let v = ResidualCovariance::of(calibration, gravity, poses, &accelerations)?;
        let chi_square = v.square(&residuals)?;
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
                standard_uncertainty: v.variance(i).sqrt(),
                relative: residuals[i].abs() / g,
                within_rule: residuals[i].abs() <= RULE * g,
            })
            .collect();
        let rms_before_mg = calibration.nominal.map(|n| {
            let length = |p: &Pose| norm(p.mean.map(|v| v - n.zero)) / n.sensitivity.abs();
            rms(&mut poses.iter().map(|p| length(p) - g))
        });
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
            findings.push(findings::beyond_one_per_mille(
                beyond.len(),
                self.attitudes.len(),
                &worst.name,
                1e2 * worst.relative,
                1e3 * worst.residual,
                g,
            ));
        }
        if self.p_value < 0.01 {
            findings.push(findings::inconsistent_with_covariance(
                self.chi_square,
                self.degrees_of_freedom,
                self.p_value,
            ));
        }
        findings
    }
}

/// Joint covariance of the residuals, D + B Bᵀ: noise and repeatability on the diagonal, calibration and gravity common.
///
/// Never formed: thousands of standstills take no more than their number times that of the causes.
struct ResidualCovariance {
    /// D.
    own: Vec<f64>,
    /// B, one column per cause.
    common: Mat<f64>,
}

impl ResidualCovariance {
    fn of(
        calibration: &Calibrated<'_>,
        gravity: Option<Gravity>,
        poses: &[Pose],
        accelerations: &[Triple],
    ) -> Result<Self, Error> {
        let n = poses.len();
        let estimate = calibration.estimate;
        let p = estimate.components().len();
        let k = calibration.sensor.k();
        let inverse_transpose = calibration.sensor.k_inverse().transpose();
        let index = |name: &str| estimate.index_of(name);
        let mut j = Mat::<f64>::zeros(n, p);
        let mut own = Vec::with_capacity(n);
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
            own.push(noise.max(0.0) + calibration.repeatability.powi(2));
        }
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for influence in estimate.influences() {
            match &influence.effect {
                Effect::Scalar {
                    standard_uncertainty: u,
                    sensitivity,
                    ..
                } => {
                    // The very gravity of the calibration is in both.
                    let shared = influence.key == "gravity" && gravity.is_none();
                    let own = |row: usize| {
                        let c: f64 = (0..p).map(|i| j[(row, i)] * sensitivity[i]).sum();
                        u * (c - f64::from(u8::from(shared)))
                    };
                    columns.push((0..n).map(own).collect());
                }
                joint => {
                    let covariance = joint.covariance(p)?.to_mat();
                    let eigen = symmetric_eigen(&covariance, "eigenvalues of the covariance")
                        .map_err(|_| Error::NotPositiveDefinite {
                            name: "covariance of the calibration",
                            row: 0,
                            column: 0,
                            value: covariance[(0, 0)],
                        })?;
                    let (vectors, values) = (eigen.U(), eigen.S());
                    for k in 0..p {
                        // Rounding leaves an eigenvalue of zero on either side of it.
                        let root = values[k].max(0.0).sqrt();
                        let along = |row: usize| -> f64 {
                            root * (0..p).map(|i| j[(row, i)] * vectors[(i, k)]).sum::<f64>()
                        };
                        columns.push((0..n).map(along).collect());
                    }
                }
            }
        }
        if let Some(g) = gravity {
            columns.push(vec![g.standard_uncertainty(); n]);
        }
        let common = Mat::from_fn(n, columns.len(), |row, c| columns[c][row]);
        Ok(Self { own, common })
    }

    fn variance(&self, row: usize) -> f64 {
        let common = (0..self.common.ncols()).map(|c| self.common[(row, c)].powi(2));
        self.own[row] + common.sum::<f64>()
    }

    /// rᵀ (D + B Bᵀ)⁻¹ r, by Woodbury's identity where D can be inverted.
    fn square(&self, residuals: &[f64]) -> Result<f64, Error> {
        let refused = || Error::NotPositiveDefinite {
            name: "covariance of the residuals",
            row: 0,
            column: 0,
            value: self.variance(0),
        };
        let (n, q) = (self.common.nrows(), self.common.ncols());
        if self.own.iter().any(|d| !(*d > 0.0)) {
            let mut v = product([self.common.as_ref(), self.common.transpose()]);
            (0..n).for_each(|i| v[(i, i)] += self.own[i]);
            let r = Mat::from_fn(n, 1, |i, _| residuals[i]);
            let solved = cholesky(&v).map_err(|_| refused())?.solve(&r);
            return Ok((0..n).map(|i| solved[(i, 0)] * residuals[i]).sum());
        }
        let w = Mat::from_fn(n, q, |i, c| self.common[(i, c)] / self.own[i].sqrt());
        let r = Mat::from_fn(n, 1, |i, _| residuals[i] / self.own[i].sqrt());
        let mut a = product([w.transpose(), w.as_ref()]);
        (0..q).for_each(|c| a[(c, c)] += 1.0);
        let along = product([w.transpose(), r.as_ref()]);
        let solved = cholesky(&a).map_err(|_| refused())?.solve(&along);
        let plain: f64 = (0..n).map(|i| r[(i, 0)].powi(2)).sum();
        let explained: f64 = (0..q).map(|c| along[(c, 0)] * solved[(c, 0)]).sum();
        Ok((plain - explained).max(0.0))
    }
}
