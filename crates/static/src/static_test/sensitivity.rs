//! Sensitivity and bias of one axis from readings up and down.

use super::StaticFit;
use super::readings::{
    CommonError, check, fixture_angle, not_negative, per_acceleration, weighed_least_squares,
    weights,
};
use crate::findings;
use proofmass_core::{Error, Gravity};
use proofmass_uncertainty::{Component, Estimate, Finding};
use serde::{Deserialize, Serialize};

/// S = (V₊ − V₋)/2g and b = (V₊ + V₋)/2; repeated readings are averaged and their scatter counts.
///
/// **Accuracy** Student's t is exact for the scatter (`coverage_sensitivity`); levelling by δ about each of two
/// axes lowers a reading by g δ² in the mean, which is added to the sensitivity, and as much again as standard uncertainty where
/// both positions tilt alike; in the bias it is δ²/√2 of g, where they tilt differently.
/// **Source** `[IEEE1293]` (two-point test).
///
/// ```
/// use proofmass_static::static_test::Sensitivity;
/// use proofmass_core::Gravity;
///
/// // QA700: 10 mV per g, 50 µg.
/// let test = Sensitivity::new(Gravity::given(9.80665, 1e-5)?);
/// let fit = test.fit(&[1.0, 1.0, -1.0, -1.0], &[10.0006, 10.0004, -9.9994, -9.9996], "mV")?;
/// assert!((fit.estimate.get("sensitivity").unwrap().value * 9.80665 - 10.0).abs() < 1e-12);
/// assert!((fit.estimate.get("bias").unwrap().value - 5e-4).abs() < 1e-12);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Sensitivity {
    /// Local gravity.
    pub gravity: Gravity,
    /// Standard uncertainty of the levelling of each position about each of two axes, rad.
    pub levelling: f64,
    /// Standard uncertainty of one reading, output unit: needed where each position is read once.
    pub reading: Option<f64>,
}

impl Sensitivity {
    /// With perfect levelling.
    pub fn new(gravity: Gravity) -> Self {
        Self {
            gravity,
            levelling: 0.0,
            reading: None,
        }
    }

    /// `position`: +1 where the axis points up, −1 where it points down.
    ///
    /// # Errors
    /// [`Error::Unobservable`] when a position is missing, [`Error::OutOfRange`] for another position than ±1,
    /// [`Error::TooFew`] for two readings whose uncertainty is not given, [`Error::Length`], [`Error::NotFinite`].
    pub fn fit(&self, position: &[f64], output: &[f64], unit: &str) -> Result<StaticFit, Error> {
        self.fit_weighed(position, output, None, unit)
    }

    /// As [`Self::fit`] with standard uncertainties of the outputs, of which only the ratios count, as weights: the scatter is that
    /// of the residuals, for a reading of mean weight.
    ///
    /// # Errors
    /// Those of [`Self::fit`]; an uncertainty that is not positive.
    pub fn fit_weighed(
        &self,
        position: &[f64],
        output: &[f64],
        uncertainty: Option<&[f64]>,
        unit: &str,
    ) -> Result<StaticFit, Error> {
        check(position, output, "position")?;
        not_negative("levelling", self.levelling)?;
        if let Some(other) = position.iter().find(|p| p.abs() != 1.0) {
            return Err(Error::OutOfRange {
                name: "position (1 up, −1 down)",
                value: *other,
                min: -1.0,
                max: 1.0,
            });
        }
        let g = self.gravity.value();
        let input: Vec<f64> = position.iter().map(|p| p * g).collect();
        let columns = [vec![1.0; input.len()], input.clone()];
        let solved = weighed_least_squares(
            &columns,
            output,
            weights(uncertainty, output.len())?,
            "sensitivity: up or down is missing",
        )?;
        let (scatter, dof) = solved.scatter(self.reading)?;
        let [b, s] = [solved.parameters[0], solved.parameters[1]];
        let common = [CommonError {
            key: "gravity",
            description: "local gravity",
            unit: "m/s²",
            value: g,
            standard_uncertainty: self.gravity.standard_uncertainty(),
            effect: position.iter().map(|p| p * s).collect(),
        }];
        let mut influences = solved.influences(scatter, dof, &common)?;
        // 1 − cos of a tilt of two components is exponential with mean δ². The half sum of two that are alike scatters by δ², the
        // half difference of two that are independent by δ²/√2.
        let s = s * (1.0 + self.levelling * self.levelling);
        for (key, description, sensitivity) in [
            (
                "levelling",
                "angle between the axis and the vertical",
                [0.0, s * self.levelling],
            ),
            (
                "levelling.difference",
                "difference of that angle between up and down",
                [
                    std::f64::consts::FRAC_1_SQRT_2 * s * g * self.levelling,
                    0.0,
                ],
            ),
        ] {
            influences.extend(fixture_angle(
                key,
                description,
                self.levelling,
                sensitivity.to_vec(),
            ));
        }
        let estimate = Estimate::new(
            vec![
                Component::new("bias", unit, b),
                Component::new("sensitivity", per_acceleration(unit), s),
            ],
            influences,
        )?;
        let findings = doubts(&estimate, unit).into_iter().collect();
        Ok(StaticFit {
            estimate,
            readings: solved.readings(&input, output),
            input: "acceleration, m/s²".to_owned(),
            unit: unit.to_owned(),
            scatter: (solved.dof > 0).then_some(scatter),
            nonlinearity: None,
            orders: Vec::new(),
            departures: Vec::new(),
            harmonics: Vec::new(),
            findings,
        })
    }
}

/// An output that does not follow the position, follows it backwards, or by another factor than its unit says.
fn doubts(estimate: &Estimate, unit: &str) -> Option<Finding> {
    let s = estimate.get("sensitivity")?;
    let (value, expanded) = (s.value, s.expanded(0.95));
    let unit_says = unit == "m/s²" && !(0.5..2.0).contains(&value.abs());
    let per = per_acceleration(unit);
    if value.abs() <= expanded {
        Some(findings::no_response(value, expanded, &per))
    } else if value < 0.0 {
        let evidence = format!("sensitivity {value:.3e}, U = {expanded:.1e} {per}");
        Some(findings::axis_inverted(&evidence))
    } else {
        unit_says.then(|| {
            proofmass_uncertainty::findings::unit_suspected(
                "the output is no acceleration in its unit, by more than a factor of two",
                &format!("sensitivity {value:.3e}, U = {expanded:.1e} {per}"),
            )
        })
    }
}
