//! One axis turned through known angles in the field of gravity.

use super::StaticFit;
use super::harmonics::{doubts, harmonics, hidden};
use super::readings::{
    CommonError, check, fixture_angle, not_negative, per_acceleration, weighed_least_squares,
    weights,
};
use crate::findings;
use proofmass_core::{Error, Gravity};
use proofmass_uncertainty::{
    Component, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding, Influence,
};
use serde::{Deserialize, Serialize};

/// Output V = b + S g cos(θ + φ) at angles θ between the sensitive axis and the vertical.
///
/// Linear in b, S cos φ and S sin φ; φ is how far the axis lies beside the zero of the angle scale.
///
/// **Units** angles in rad, gravity in m/s².
/// An axis of the table that leans by ψ off the level and a sensitive axis that lies χ out of the plane of turning lower S
/// by ψ²/2 and χ²/2 and, together, shift the bias by S g χ ψ: what no angle and no residual shows. Both stand in the
/// budget, 1° and 1° as 0.3 mg.
///
/// A cube of the acceleration lies in S by three times its third harmonic. From ten readings on harmonics two and three are tested,
/// with the size that such a test finds; with fewer, what they leave open of the third is in U of S, and where the angles cannot
/// show it (steps of 90°) a finding says so.
///
/// **Accuracy** Student's t is exact for scatter of the readings and of each angle (`coverage_tilt`).
/// **Source** `[IEEE1293]` (multi-point tumble test).
///
/// ```
/// use proofmass_static::static_test::Tilt;
/// use proofmass_core::Gravity;
///
/// // ADXL355: 256 000 counts per g, 300 µg bias, the axis 1° beside the zero of the table.
/// let angle: Vec<f64> = (0..12).map(|i| f64::from(30 * i).to_radians()).collect();
/// let output: Vec<f64> = angle
///     .iter()
///     .map(|t| 256_000.0 * (300e-6 + (t + 1f64.to_radians()).cos()) + 2.0 * (7.0 * t).sin())
///     .collect();
/// let gravity = Gravity::given(9.80665, 1e-5)?;
/// let fit = Tilt::new(gravity).fit(&angle, &output, "count")?;
/// let q = |name: &str| fit.estimate.get(name).unwrap().value;
/// assert!((q("sensitivity") * 9.80665 - 256_000.0).abs() < 1.0);
/// assert!((q("bias") - 76.8).abs() < 1.0);
/// assert!((q("misalignment").to_degrees() - 1.0).abs() < 1e-4);
/// // Level by the table, this axis reads sin 1° of gravity: 17 mg.
/// assert!((1e3 * q("misalignment").sin() - 17.45).abs() < 0.01);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Tilt {
    /// Local gravity.
    pub gravity: Gravity,
    /// Standard uncertainty of the zero of the angle scale, rad.
    pub zero_uncertainty: f64,
    /// Full scale of the output, output unit; twice the largest departure from the bias unless told.
    pub full_scale: Option<f64>,
    /// Standard uncertainty of the inclination of the axis of rotation off the level, rad.
    #[serde(default)]
    pub lean: f64,
    /// Standard uncertainty of the angle between the sensitive axis and the plane of turning, rad.
    #[serde(default)]
    pub out_of_plane: f64,
    /// Standard uncertainty of one reading, output unit: needed where there are three readings.
    #[serde(default)]
    pub reading: Option<f64>,
}

impl Tilt {
    /// With an angle scale whose zero is exact.
    pub fn new(gravity: Gravity) -> Self {
        Self {
            gravity,
            zero_uncertainty: 0.0,
            full_scale: None,
            lean: 0.0,
            out_of_plane: 0.0,
            reading: None,
        }
    }

    /// Fits bias, sensitivity and misalignment.
    ///
    /// # Errors
    /// [`Error::TooFew`] for fewer than four readings (three, where the uncertainty of one is given),
    /// [`Error::Unobservable`] for angles that do not spread,
    /// [`Error::Length`], [`Error::NotFinite`], [`Error::OutOfRange`].
    pub fn fit(&self, angle: &[f64], output: &[f64], unit: &str) -> Result<StaticFit, Error> {
        self.fit_weighed(angle, output, None, unit)
    }

    /// As [`Self::fit`] with standard uncertainties of the outputs, of which only the ratios count, as weights: the scatter is that
    /// of the residuals, for a reading of mean weight.
    ///
    /// # Errors
    /// Those of [`Self::fit`]; an uncertainty that is not positive.
    pub fn fit_weighed(
        &self,
        angle: &[f64],
        output: &[f64],
        uncertainty: Option<&[f64]>,
        unit: &str,
    ) -> Result<StaticFit, Error> {
        check(angle, output, "angle")?;
        not_negative(
            "uncertainty of the zero of the angles",
            self.zero_uncertainty,
        )?;
        not_negative("inclination of the axis of rotation", self.lean)?;
        not_negative("angle out of the plane of turning", self.out_of_plane)?;
        let g = self.gravity.value();
        let columns = [
            vec![1.0; angle.len()],
            angle.iter().map(|t| g * t.cos()).collect(),
            angle.iter().map(|t| -g * t.sin()).collect(),
        ];
        let solved = weighed_least_squares(
            &columns,
            output,
            weights(uncertainty, output.len())?,
            "sensitivity or bias: the angles do not spread",
        )?;
        let (scatter, dof) = solved.scatter(self.reading)?;
        let [b, p, q] = [0, 1, 2].map(|i| solved.parameters[i]);
        let s = p.hypot(q);
        if !(s > 0.0) {
            return Err(Error::Constant {
                name: "output",
                value: output[0],
            });
        }
        let phase = q.atan2(p);
        let n = angle.len();
        let force: Vec<f64> = solved.fitted.iter().map(|v| v - b).collect();
        let common = [
            CommonError {
                key: "gravity",
                description: "local gravity",
                unit: "m/s²",
                value: g,
                standard_uncertainty: self.gravity.standard_uncertainty(),
                effect: force.iter().map(|f| f / g).collect(),
            },
            CommonError {
                key: "angle.zero",
                description: "zero of the angle scale",
                unit: "rad",
                value: 0.0,
                standard_uncertainty: self.zero_uncertainty,
                effect: (0..n).map(|i| -s * g * (angle[i] + phase).sin()).collect(),
            },
        ];
        let raw = solved.raw(solved.influences(scatter, dof, &common)?)?;
        let estimate = raw.propagate(
            vec![
                Component::new("bias", unit, b),
                Component::new("sensitivity", per_acceleration(unit), s),
                Component::new("misalignment", "rad", phase),
            ],
            &[
                1.0,
                0.0,
                0.0,
                0.0,
                p / s,
                q / s,
                0.0,
                -q / (s * s),
                p / (s * s),
            ],
        )?;
        let estimate = self.with_fixture(estimate, s)?;
        let reach = force.iter().map(|f| f.abs()).fold(0.0, f64::max);
        let full_scale = self.full_scale.unwrap_or(2.0 * reach);
        let readings = solved.readings(angle, output);
        let largest = readings
            .iter()
            .map(|r| r.residual().abs())
            .fold(0.0, f64::max);
        let harmonics = harmonics(angle, &readings, reach);
        let mut findings: Vec<Finding> = doubts(harmonics.as_deref().unwrap_or_default()).collect();
        let estimate = match (&harmonics, hidden(angle, phase, &readings)) {
            (Some(_), _) => estimate,
            (None, Some(open)) => self.with_cubic(estimate, open)?,
            (None, None) => {
                findings.push(findings::cubic_not_tested(n));
                estimate
            }
        };
        Ok(StaticFit {
            estimate,
            readings,
            input: "angle, rad".to_owned(),
            unit: unit.to_owned(),
            scatter: (solved.dof > 0).then_some(scatter),
            nonlinearity: (solved.dof > 0).then_some(largest / full_scale),
            orders: Vec::new(),
            departures: Vec::new(),
            harmonics: harmonics.unwrap_or_default(),
            findings,
        })
    }
}

impl Tilt {
    /// The estimate with a cube of the acceleration that the readings leave open: h of the third harmonic is 3 h of the first.
    fn with_cubic(
        &self,
        estimate: Estimate,
        (open, dof): (f64, DegreesOfFreedom),
    ) -> Result<Estimate, Error> {
        let u = 3.0 * open / self.gravity.value();
        let mut influences = estimate.influences().to_vec();
        if u > 0.0 {
            influences.push(Influence {
                key: "cubic".to_owned(),
                description: "a cube of the acceleration that these angles do not show".to_owned(),
                evaluation: Evaluation::A,
                distribution: "t".to_owned(),
                dof,
                effect: Effect::of_zero("1", u, vec![0.0, 1.0, 0.0]),
            });
        }
        Estimate::new(estimate.components().to_vec(), influences)
    }

    /// The estimate of bias, sensitivity and misalignment with what the fixture does in second order.
    fn with_fixture(&self, estimate: Estimate, s: f64) -> Result<Estimate, Error> {
        let mut influences = estimate.influences().to_vec();
        let product = s * self.gravity.value() * self.out_of_plane;
        for (key, description, u, bias) in [
            (
                "lean",
                "the axis of turning is not level",
                self.lean,
                product,
            ),
            (
                "plane",
                "angle between the sensitive axis and the plane of rotation",
                self.out_of_plane,
                0.0,
            ),
        ] {
            let sensitivity = vec![bias, s * u, 0.0];
            influences.extend(fixture_angle(key, description, u, sensitivity));
        }
        Estimate::new(estimate.components().to_vec(), influences)
    }
}
