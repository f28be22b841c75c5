//! Scale and curvature at many g on a rotating arm.

use super::StaticFit;
use super::linearity::{Inputs, Linearity};
use super::readings::{CommonError, check, not_negative, positive};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// Output against a = r ω² (1 + s ω²) cos ψ along the sensitive axis, by the polynomial error model.
///
/// The radius at rest is that of the proof mass; the arm stretches by s ω². Gravity that leans into the axis adds a
/// constant, which is in the bias. A misalignment ψ lowers the acceleration and lets gravity and the tangential
/// direction in; its square is carried as an uncertainty of scale.
///
/// **Units** angular speed in rad/s, radius in m, stretch in s².
/// **Accuracy** `coverage_centrifuge`. **Source** `[IEEE836]`, `[IEEE1293]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Centrifuge {
    /// Radius of the proof mass at rest, m.
    pub radius: f64,
    /// Its standard uncertainty, m.
    pub radius_uncertainty: f64,
    /// Relative standard uncertainty of all speeds together.
    pub speed_uncertainty: f64,
    /// Relative stretch of the arm per ω², s².
    pub stretch: f64,
    /// Its standard uncertainty, s².
    pub stretch_uncertainty: f64,
    /// Standard uncertainty of the angle between sensitive axis and radius, rad.
    pub misalignment: f64,
    /// Standard uncertainty of the inclination of the axis against the horizontal, rad.
    pub inclination: f64,
    /// Full scale, m/s²; the largest acceleration of the test unless told.
    pub full_scale: Option<f64>,
    /// Largest order, 1 to 3.
    pub largest_order: usize,
}

impl Centrifuge {
    /// A rigid arm of exact radius.
    pub fn new(radius: f64) -> Self {
        Self {
            radius,
            radius_uncertainty: 0.0,
            speed_uncertainty: 0.0,
            stretch: 0.0,
            stretch_uncertainty: 0.0,
            misalignment: 0.0,
            inclination: 0.0,
            full_scale: None,
            largest_order: 3,
        }
    }

    /// Acceleration along the radius at an angular speed, m/s².
    pub fn acceleration(&self, speed: f64) -> f64 {
        let square = speed * speed;
        self.radius * square * (1.0 + self.stretch * square)
    }

    /// Fits bias, sensitivity and curvature.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for settings without meaning; those of [`Linearity::fit`].
    pub fn fit(&self, speed: &[f64], output: &[f64], unit: &str) -> Result<StaticFit, Error> {
        self.fit_weighed(speed, output, None, unit)
    }

    /// As [`Self::fit`] with standard uncertainties of the outputs, of which only the ratios count, as weights: the scatter is that
    /// of the residuals, for a reading of mean weight.
    ///
    /// # Errors
    /// Those of [`Self::fit`]; an uncertainty that is not positive.
    pub fn fit_weighed(
        &self,
        speed: &[f64],
        output: &[f64],
        uncertainty: Option<&[f64]>,
        unit: &str,
    ) -> Result<StaticFit, Error> {
        check(speed, output, "speed")?;
        positive("radius, m", self.radius)?;
        for (name, value) in [
            ("uncertainty of the radius", self.radius_uncertainty),
            ("uncertainty of the speed", self.speed_uncertainty),
            ("uncertainty of the elongation", self.stretch_uncertainty),
            ("misalignment", self.misalignment),
            ("inclination", self.inclination),
        ] {
            not_negative(name, value)?;
        }
        let a: Vec<f64> = speed.iter().map(|w| self.acceleration(*w)).collect();
        let with = |f: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
            speed.iter().zip(&a).map(|(w, a)| f(*w, *a)).collect()
        };
        let error = |key, description, unit, value, u, effect| CommonError {
            key,
            description,
            unit,
            value,
            standard_uncertainty: u,
            effect,
        };
        let common = vec![
            error(
                "radius",
                "radius of the proof mass",
                "m",
                self.radius,
                self.radius_uncertainty,
                with(&|_, a| a / self.radius),
            ),
            error(
                "speed",
                "scale of the angular speed",
                "1",
                1.0,
                self.speed_uncertainty,
                with(&|w, a| 2.0 * a + 2.0 * self.radius * self.stretch * w.powi(4)),
            ),
            error(
                "stretch",
                "elongation of the arm",
                "s²",
                self.stretch,
                self.stretch_uncertainty,
                with(&|w, _| self.radius * w.powi(4)),
            ),
            error(
                "misalignment",
                "angle between sensitive axis and radius",
                "rad",
                0.0,
                self.misalignment,
                with(&|_, a| -0.5 * self.misalignment * a),
            ),
            error(
                "inclination",
                "gravity along the sensitive axis",
                "rad",
                0.0,
                self.inclination,
                vec![proofmass_core::STANDARD_GRAVITY; a.len()],
            ),
        ];
        let model = Linearity {
            full_scale: self.full_scale,
            largest_order: self.largest_order,
            ..Linearity::default()
        };
        model.evaluate(Inputs {
            acceleration: &a,
            output,
            temperature: None,
            uncertainty,
            unit,
            label: "acceleration, m/s²",
            common,
        })
    }
}
