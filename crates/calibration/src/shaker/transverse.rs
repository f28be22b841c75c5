//! Transverse sensitivity of a single-axis accelerometer: shaken across its axis, in several directions.
//!
//! The device is mounted with its sensitive axis across the vibration and turned about that axis by ω. Per unit
//! acceleration it gives
//!
//! ```text
//! y(ω) = c + S_x cos ω + S_y sin ω
//! ```
//!
//! with complex S_x and S_y, the sensitivities along two directions of its base, and a constant c, which is what the
//! motion along its own axis makes: the table is not quite square to the vibration, and it moves a little along the axis.
//! From three directions on c is fitted, and what is constant does not matter. With two (the x and the y axis of a shaker)
//! it cannot be told, and the squareness of the mounting is an uncertainty of both.
//!
//! What turns with the device cannot be told from the device: a base that does not sit flat, by ε, adds ε S.
//!
//! **Source** `[ISO16063-31]`.

use super::derived::{Expanded, largest_response, propagate};
use super::near_zero::{Kind, size};
use faer::linalg::solvers::Solve as _;
use faer::{Mat, Side};
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::{
    Complex, Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding,
    Influence, Model, Number, Severity, f_quantile,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Along which direction of the device it was shaken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "motion")]
pub enum Motion {
    /// Along the sensitive axis.
    Axial,
    /// Across it, at this angle from the x direction of the base towards y, rad: the device was turned clockwise by it, seen
    /// from above.
    Transverse {
        /// Angle in radians.
        rotation: f64,
    },
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransverseRow {
    /// Name of the run.
    pub run: String,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Along which direction it was shaken.
    #[serde(flatten)]
    pub motion: Motion,
    /// Output per acceleration of the table along the vibration.
    pub ratio: Complex64,
    /// Motion of the table across the vibration relative to it, where it was measured.
    pub transverse: Option<f64>,
}

/// How well the device sits, standard uncertainties.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SeatUncertainty {
    /// Tilt of its base against the axis it is turned about, rad, in each of two directions.
    pub tilt: f64,
    /// Angle by which that axis is not square to the vibration, rad: needed with two directions, not used with more, which
    /// show it.
    pub squareness: Option<f64>,
    /// Zero of the angles of rotation, rad.
    pub rotation: f64,
    /// Real and imaginary part of one reading, relative to the sensitivity along the axis, and its degrees of freedom: used
    /// where no runs are left to show the scatter.
    pub reading: Option<(f64, DegreesOfFreedom)>,
}

impl SeatUncertainty {
    /// A base known to sit flat to `tilt` (rad); everything else exact.
    pub fn new(tilt: f64) -> Self {
        Self {
            tilt,
            squareness: None,
            rotation: 0.0,
            reading: None,
        }
    }
}

/// The sensitivity along the axis, where it was not measured among the runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxialSensitivity {
    /// Complex sensitivity.
    pub value: Complex64,
    /// Relative standard uncertainty of the modulus.
    pub relative: f64,
    /// Standard uncertainty of the phase, rad.
    pub phase: f64,
}

/// Transverse sensitivity at one frequency.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransverseSensitivity {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Runs across the axis.
    pub runs: usize,
    /// Different directions among them.
    pub directions: usize,
    /// Whether the constant was fitted.
    pub constant_fitted: bool,
    /// The constant over the sensitivity along the axis: squareness and motion along the axis; zero where it is not fitted.
    pub constant: Complex64,
    /// Scatter of a run about the fit, relative to the sensitivity along the axis; `None` where no runs are left to show it.
    pub scatter: Option<f64>,
    /// T = max_ω |S_x cos ω + S_y sin ω|/|S|.
    pub ratio: Expanded,
    /// Direction of the largest response from x towards y, rad, modulo π; `None` where T does not exceed its expanded
    /// uncertainty.
    pub direction: Option<Expanded>,
    /// Components `S.re`, `S.im`, `x.re`, `x.im`, `y.re`, `y.im` with every influence.
    pub estimate: Estimate,
}

impl TransverseSensitivity {
    /// S, S_x and S_y.
    pub fn sensitivities(&self) -> [Complex64; 3] {
        let c = self.estimate.components();
        std::array::from_fn(|k| Complex64::new(c[2 * k].value, c[2 * k + 1].value))
    }
}

/// What is common to the frequencies of one evaluation.
#[derive(Clone, Debug)]
pub struct TransverseTest<'a> {
    /// How the device sits.
    pub seat: SeatUncertainty,
    /// Unit of the sensitivities.
    pub unit: &'a str,
    /// Probability at which a sound device may be said to follow no cosine at one frequency.
    pub false_alarm_rate: f64,
}

/// T and its direction from S, S_x and S_y.
struct Ratio;

impl Model for Ratio {
    fn outputs(&self) -> Vec<(String, String)> {
        let of = |name: &str, unit: &str| (name.to_owned(), unit.to_owned());
        vec![of("transverse", "1"), of("transverse.angle", "rad")]
    }

    fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
        let at = |k: usize| Complex::new(x[2 * k], x[2 * k + 1]);
        let (root, angle) = largest_response(at(1), at(2));
        y[0] = root / at(0).abs();
        y[1] = angle;
    }
}

impl TransverseTest<'_> {
    /// T at one frequency from its runs, by ordinary least squares of the complex ratios.
    ///
    /// `certificate`: relative standard uncertainty of the modulus and standard uncertainty of the phase (rad) of the
    /// reference, common to all runs. `axial` is needed where no run is along the axis; its phase is relative to the same
    /// reference.
    ///
    /// **Accuracy** intervals hold in 94 % and more from T = 0 to 5 % (`coverage_of_transverse_sensitivity`).
    ///
    /// # Errors
    /// [`Error::TooFew`] with fewer than two directions across the axis that are neither one line nor opposite, with two of
    /// unknown squareness, or without anything that shows the scatter of a reading; [`Error::NotFinite`] for an output that is no number or a sensitivity
    /// of zero along the axis.
    pub fn evaluate(
        &self,
        frequency: f64,
        rows: &[&TransverseRow],
        certificate: (f64, f64),
        axial: Option<AxialSensitivity>,
    ) -> Result<(TransverseSensitivity, Vec<Finding>), Error> {
        if let Some(index) = rows.iter().position(|r| !r.ratio.is_finite()) {
            return Err(Error::NotFinite {
                name: "output over acceleration",
                index,
            });
        }
        let axial_runs: Vec<Complex64> = rows
            .iter()
            .filter(|r| r.motion == Motion::Axial)
            .map(|r| r.ratio)
            .collect();
        let mut across: Vec<(f64, Complex64)> = Vec::new();
        for row in rows {
            if let Motion::Transverse { rotation } = row.motion {
                across.push((rotation, row.ratio));
            }
        }
        let measured = !axial_runs.is_empty();
        let s = if measured {
            axial_runs.iter().sum::<Complex64>() / axial_runs.len() as f64
        } else {
            axial.map_or(Complex64::ZERO, |a| a.value)
        };
        if !(s.norm() > 0.0) {
            return Err(Error::NotFinite {
                name: "sensitivity along the axis",
                index: 0,
            });
        }
        let fit = Fit::new(&across)?;
        let scatter = match (fit.scatter(), self.seat.reading) {
            (Some((s, dof)), _) => (s, dof),
            (None, Some((relative, dof))) => (relative * s.norm(), dof),
            (None, None) => {
                return Err(Error::TooFew {
                    name: "runs across the axis, or an uncertainty of the reading",
                    needed: fit.parameters() + 1,
                    got: across.len(),
                });
            }
        };
        let [x, y] = fit.transverse;
        let parts = [s, x, y].map(|z| [z.re, z.im]).concat();
        let components = ["S.re", "S.im", "x.re", "x.im", "y.re", "y.im"]
            .iter()
            .zip(&parts)
            .map(|(name, value)| Component::new(*name, self.unit, *value))
            .collect();
        let mut influences = vec![self.scatter(&fit, scatter)?];
        influences.extend(self.of_axis(&axial_runs, s)?);
        influences.extend(of_reference(certificate, [s, x, y], measured, axial));
        influences.extend(self.of_seat([s, x, y], &fit, rows)?);
        let estimate = Estimate::new(components, influences)?;
        let (ratio, direction) = derive(&estimate, s)?;
        let mut findings = Vec::new();
        findings.extend(self.not_a_cosine(frequency, &across, s)?);
        findings.extend(disagreement(frequency, &axial_runs, s));
        let result = TransverseSensitivity {
            frequency,
            runs: across.len(),
            directions: fit.directions.len(),
            constant_fitted: fit.constant.is_some(),
            constant: fit.constant.map_or(Complex64::ZERO, |c| c / s),
            scatter: fit.scatter().map(|(u, _)| u / s.norm()),
            ratio,
            direction,
            estimate,
        };
        Ok((result, findings))
    }

    fn scatter(&self, fit: &Fit, (u, dof): (f64, DegreesOfFreedom)) -> Result<Influence, Error> {
        let mut covariance = [0.0; 36];
        for (a, row) in fit.cofactor.iter().enumerate() {
            for (b, q) in row.iter().enumerate() {
                for part in 0..2 {
                    covariance[6 * (2 + 2 * a + part) + 2 + 2 * b + part] = u * u * q;
                }
            }
        }
        Ok(Influence {
            key: "scatter".to_owned(),
            description: "scatter of the runs across the axis".to_owned(),
            evaluation: Evaluation::A,
            distribution: "normal".to_owned(),
            dof,
            effect: Effect::Joint {
                covariance: Covariance::try_from_rows(6, &covariance)?,
            },
        })
    }

    /// Scatter of the runs along the axis; of one run the declared reading.
    fn of_axis(&self, runs: &[Complex64], s: Complex64) -> Result<Option<Influence>, Error> {
        let n = runs.len() as f64;
        let (v, dof) = match (runs.len(), self.seat.reading) {
            (0, _) | (1, None) => return Ok(None),
            (1, Some((relative, dof))) => ((relative * s.norm()).powi(2), dof),
            _ => {
                let sum: f64 = runs.iter().map(|r| (r - s).norm_sqr()).sum();
                let dof = DegreesOfFreedom::new(2.0 * (n - 1.0));
                (
                    sum / (2.0 * (n - 1.0)) / n,
                    dof.unwrap_or(DegreesOfFreedom::INFINITE),
                )
            }
        };
        let mut covariance = [0.0; 36];
        (covariance[0], covariance[7]) = (v, v);
        Ok(Some(Influence {
            key: "axial.scatter".to_owned(),
            description: "scatter of the runs along the axis".to_owned(),
            evaluation: Evaluation::A,
            distribution: "normal".to_owned(),
            dof,
            effect: Effect::Joint {
                covariance: Covariance::try_from_rows(6, &covariance)?,
            },
        }))
    }

    fn of_seat(
        &self,
        [s, x, y]: [Complex64; 3],
        fit: &Fit,
        rows: &[&TransverseRow],
    ) -> Result<Vec<Influence>, Error> {
        let mut list = Vec::new();
        let zero = Complex64::ZERO;
        let tilted = "tilt of the base of the device against the axis it is turned about";
        for (key, effect) in [
            ("device.tilt.x", [zero, s, zero]),
            ("device.tilt.y", [zero, zero, s]),
        ] {
            list.extend(scalar(key, tilted, self.seat.tilt, effect));
        }
        // The largest motion across the vibration that was seen, of unknown direction and phase.
        let largest = rows.iter().filter_map(|r| r.transverse).fold(0.0, f64::max);
        let part = FRAC_1_SQRT_2 * largest;
        if fit.constant.is_none() {
            // Each direction may be a mounting of its own, or one mounting that was turned, whose error both have in
            // common. I + ½ 1 1ᵀ bounds the one, I, and the other, 1 1ᵀ.
            let Some(squareness) = self.seat.squareness else {
                return Err(Error::TooFew {
                    name: "directions across the axis, or an uncertainty of the squareness",
                    needed: 3,
                    got: 2,
                });
            };
            let u = squareness.hypot(part);
            let mut covariance = [0.0; 36];
            let common: [f64; 2] = std::array::from_fn(|a| fit.weights.iter().map(|w| w[a]).sum());
            let each = fit.weights.iter().map(|w| (1.0, *w));
            for (share, w) in each.chain([(0.5, common)]) {
                let effect = [zero, w[0] * s, w[1] * s].map(|z| [z.re, z.im]).concat();
                for a in 0..6 {
                    for b in 0..6 {
                        covariance[6 * a + b] += share * u * u * effect[a] * effect[b];
                    }
                }
            }
            if u > 0.0 {
                list.push(Influence {
                    key: "seat.squareness".to_owned(),
                    description: "motion along the axis: mounting not square to the vibration, and what the table adds"
                        .to_owned(),
                    evaluation: Evaluation::B,
                    distribution: "normal".to_owned(),
                    dof: DegreesOfFreedom::INFINITE,
                    effect: Effect::Joint {
                        covariance: Covariance::try_from_rows(6, &covariance)?,
                    },
                });
            }
        }
        let turned = [zero, -y, x];
        let zero_of_angles = "zero of the angles of rotation";
        list.extend(scalar(
            "rotation.zero",
            zero_of_angles,
            self.seat.rotation,
            turned,
        ));
        let motion = "motion of the table across the vibration";
        list.extend(scalar("table.transverse", motion, part, turned));
        let quadrature = turned.map(|z| Complex64::i() * z);
        list.extend(scalar(
            "table.transverse.quadrature",
            motion,
            part,
            quadrature,
        ));
        Ok(list)
    }

    /// Whether a second harmonic of the rotation stands out of the scatter (F test with four and 2 (n − 5) degrees of
    /// freedom).
    fn not_a_cosine(
        &self,
        frequency: f64,
        across: &[(f64, Complex64)],
        s: Complex64,
    ) -> Result<Option<Finding>, Error> {
        let directions = directions(across).len();
        let n = across.len();
        if directions < 6 || n < 7 {
            return Ok(None);
        }
        let design = |harmonics: usize| {
            Mat::from_fn(n, 1 + 2 * harmonics, |i, j| {
                let angle = j.div_ceil(2) as f64 * across[i].0;
                if j % 2 == 1 {
                    angle.cos()
                } else if j == 0 {
                    1.0
                } else {
                    angle.sin()
                }
            })
        };
        let (one, _) = least_squares(&design(1), across)?;
        let (two, parameters) = least_squares(&design(2), across)?;
        let freedom = 2.0 * (n as f64 - 5.0);
        let gained = (one - two) / 4.0;
        let rest = two / freedom;
        let largest = parameters[3].norm().hypot(parameters[4].norm()) / s.norm();
        // Below the rounding of the ratios there is nothing to test.
        let floor = (1e-12 * s.norm()).powi(2);
        let limit = f_quantile(1.0 - self.false_alarm_rate, 4.0, freedom);
        Ok((gained > limit * rest.max(floor)).then(|| {
            Finding::new(
                Severity::Warning,
                "not-a-cosine",
                format!("the output at {frequency} Hz does not follow the direction as a transverse sensitivity does"),
            )
            .evidence(format!(
                "twice per turn {:.2} % of the sensitivity along the axis; the runs scatter by {:.2} %",
                100.0 * largest,
                100.0 * rest.sqrt() / s.norm()
            ))
            .advice("look at cable, mounting and angles; a resonance of the fixture does this too")
        }))
    }
}

/// Scatter of the runs along the axis, relative, at which one of them is no repeat.
const LARGEST_AXIAL_SCATTER: f64 = 0.05;

fn disagreement(frequency: f64, runs: &[Complex64], s: Complex64) -> Option<Finding> {
    let worst = runs
        .iter()
        .map(|r| (r / s - 1.0).norm())
        .fold(0.0, f64::max);
    (worst > LARGEST_AXIAL_SCATTER).then(|| {
        Finding::new(
            Severity::Decision,
            "axial-runs-disagree",
            format!("the runs along the axis at {frequency} Hz are no repeats of each other"),
        )
        .evidence(format!("one is {:.0} % from their mean", 100.0 * worst))
        .advice("the transverse sensitivity is relative to their mean: measure them again, or leave one out by name")
    })
}

/// T with its interval, and its direction where it has one.
fn derive(estimate: &Estimate, s: Complex64) -> Result<(Expanded, Option<Expanded>), Error> {
    let linear = propagate(estimate, &Ratio)?;
    let covariance = estimate.covariance();
    let largest = Mat::from_fn(4, 4, |a, b| covariance[(2 + a, 2 + b)])
        .self_adjoint_eigenvalues(Side::Lower)
        .map_err(|_| Error::NotConverged {
            name: "eigenvalues of the covariance of the transverse sensitivity",
            iterations: 0,
            step: f64::INFINITY,
        })?[3];
    let (Some(value), Some(angle)) = (linear.get("transverse"), linear.get("transverse.angle"))
    else {
        return Err(Error::NotFinite {
            name: "transverse sensitivity",
            index: 0,
        });
    };
    let ratio = size(
        Kind::Transverse,
        (value.name, value.unit),
        value.value,
        value.standard_uncertainty,
        largest.max(0.0).sqrt() / s.norm(),
        value.dof,
    );
    let known = ratio.value > ratio.expanded;
    Ok((ratio, known.then(|| Expanded::from(angle))))
}

fn scalar(key: &str, description: &str, u: f64, effect: [Complex64; 3]) -> Option<Influence> {
    (u > 0.0).then(|| Influence {
        key: key.to_owned(),
        description: description.to_owned(),
        evaluation: Evaluation::B,
        distribution: "normal".to_owned(),
        dof: DegreesOfFreedom::INFINITE,
        effect: Effect::Scalar {
            value: 0.0,
            unit: "1".to_owned(),
            standard_uncertainty: u,
            sensitivity: effect.map(|z| [z.re, z.im]).concat(),
        },
    })
}

/// The reference enters what was measured with it; a sensitivity that was given has uncertainties of its own.
fn of_reference(
    (modulus, phase): (f64, f64),
    [s, x, y]: [Complex64; 3],
    measured: bool,
    axial: Option<AxialSensitivity>,
) -> Vec<Influence> {
    let zero = Complex64::ZERO;
    let along = if measured { s } else { zero };
    let i = Complex64::i();
    let mut list = Vec::new();
    let certificate = "calibration of the reference standard";
    list.extend(scalar(
        "reference.calibration",
        certificate,
        modulus,
        [along, x, y],
    ));
    let turned = [along, x, y].map(|z| i * z);
    list.extend(scalar("reference.phase", certificate, phase, turned));
    if let (false, Some(axial)) = (measured, axial) {
        let given = "sensitivity along the axis, as given";
        list.extend(scalar(
            "axis.calibration",
            given,
            axial.relative,
            [s, zero, zero],
        ));
        list.extend(scalar(
            "axis.phase",
            given,
            axial.phase,
            [i * s, zero, zero],
        ));
    }
    list
}

/// Directions that differ, modulo a turn.
fn directions(across: &[(f64, Complex64)]) -> Vec<f64> {
    let mut list: Vec<f64> = Vec::new();
    for (rotation, _) in across {
        if !list.iter().any(|other| same(*rotation, *other)) {
            list.push(*rotation);
        }
    }
    list
}

fn same(a: f64, b: f64) -> bool {
    let apart = (a - b).rem_euclid(TAU);
    apart.min(TAU - apart) <= 1e-6
}

/// Sum of the squared residuals (both parts), and the parameters.
fn least_squares(
    design: &Mat<f64>,
    across: &[(f64, Complex64)],
) -> Result<(f64, Vec<Complex64>), Error> {
    let n = across.len();
    let values = Mat::from_fn(n, 2, |i, part| {
        if part == 0 {
            across[i].1.re
        } else {
            across[i].1.im
        }
    });
    let normal = design.transpose() * design;
    let llt = normal.llt(Side::Lower).map_err(|_| Error::TooFew {
        name: "directions across the axis that are neither one line nor opposite",
        needed: 2,
        got: directions(across).len(),
    })?;
    let solution = llt.solve(design.transpose() * &values);
    let rest = &values - design * &solution;
    Ok((
        rest.squared_norm_l2(),
        (0..design.ncols())
            .map(|j| Complex64::new(solution[(j, 0)], solution[(j, 1)]))
            .collect(),
    ))
}

/// c, S_x and S_y.
struct Fit {
    constant: Option<Complex64>,
    transverse: [Complex64; 2],
    directions: Vec<f64>,
    /// (XᵀX)⁻¹ of the two.
    cofactor: [[f64; 2]; 2],
    /// What a constant error of each direction does to the two.
    weights: Vec<[f64; 2]>,
    square: f64,
    runs: usize,
}

/// Smallest share of a circle that the directions have to span: below it cosine and sine are one.
const SMALLEST_SPAN: f64 = 1e-3;

impl Fit {
    fn new(across: &[(f64, Complex64)]) -> Result<Self, Error> {
        let directions = directions(across);
        let too_few = Error::TooFew {
            name: "directions across the axis that are neither one line nor opposite",
            needed: 2,
            got: directions.len().min(1),
        };
        let spread = directions
            .iter()
            .fold(0.0_f64, |most, a| most.max((a - directions[0]).sin().abs()));
        if spread < SMALLEST_SPAN {
            return Err(too_few);
        }
        let free = usize::from(directions.len() > 2);
        let design = Mat::from_fn(across.len(), 2 + free, |i, j| match j + 1 - free {
            0 => 1.0,
            1 => across[i].0.cos(),
            _ => across[i].0.sin(),
        });
        let (square, parameters) = least_squares(&design, across)?;
        let normal = design.transpose() * &design;
        let inverse = normal
            .llt(Side::Lower)
            .map_err(|_| too_few)?
            .solve(Mat::<f64>::identity(2 + free, 2 + free));
        let cofactor =
            std::array::from_fn(|a| std::array::from_fn(|b| inverse[(a + free, b + free)]));
        let gain = &inverse * design.transpose();
        let weights = directions
            .iter()
            .map(|d| {
                std::array::from_fn(|a| {
                    (0..across.len())
                        .filter(|&i| same(across[i].0, *d))
                        .map(|i| gain[(a + free, i)])
                        .sum()
                })
            })
            .collect();
        Ok(Self {
            constant: (free == 1).then(|| parameters[0]),
            transverse: [parameters[free], parameters[free + 1]],
            directions,
            cofactor,
            weights,
            square,
            runs: across.len(),
        })
    }

    fn parameters(&self) -> usize {
        2 + usize::from(self.constant.is_some())
    }

    /// Standard deviation of each part of a run, and its degrees of freedom.
    fn scatter(&self) -> Option<(f64, DegreesOfFreedom)> {
        let freedom = 2.0 * (self.runs as f64 - self.parameters() as f64);
        let dof = DegreesOfFreedom::new(freedom)?;
        (freedom > 0.0).then(|| ((self.square / freedom).sqrt(), dof))
    }
}

/// Whether a transverse sensitivity keeps to a limit, and how surely: `None` while the interval holds the limit.
pub fn keeps_to(result: &TransverseSensitivity, limit: f64) -> Option<bool> {
    let q = &result.ratio;
    if q.value + q.expanded <= limit {
        Some(true)
    } else if q.value - q.expanded > limit {
        Some(false)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn test(tilt: f64) -> TransverseTest<'static> {
        TransverseTest {
            seat: SeatUncertainty::new(tilt),
            unit: "V/(m/s²)",
            false_alarm_rate: 1e-3,
        }
    }

    fn row(motion: Motion, ratio: Complex64) -> TransverseRow {
        TransverseRow {
            run: "a".into(),
            frequency: 160.0,
            motion,
            ratio,
            transverse: None,
        }
    }

    fn across(degrees: f64, ratio: Complex64) -> TransverseRow {
        let rotation = degrees.to_radians();
        row(Motion::Transverse { rotation }, ratio)
    }

    fn evaluated(
        test: &TransverseTest<'_>,
        rows: &[TransverseRow],
    ) -> Result<TransverseSensitivity, Error> {
        let rows: Vec<&TransverseRow> = rows.iter().collect();
        test.evaluate(160.0, &rows, (0.0, 0.0), None).map(|r| r.0)
    }

    #[test]
    fn known_transverse_sensitivity_of_a_tilt_on_a_turned_table() {
        // The axis leans by 2 % towards 30°; the table is 1 % off square, in quadrature.
        let s = Complex64::from_polar(0.01, 0.4);
        let mut rows = vec![row(Motion::Axial, s)];
        for k in 0..12 {
            let degrees = 30.0 * f64::from(k);
            let y = s * (0.02 * (degrees - 30.0).to_radians().cos() + Complex64::new(0.0, 0.01));
            rows.push(across(degrees, y));
        }
        let t = evaluated(&test(1e-3), &rows).expect("a result");
        assert!((t.ratio.value - 0.02).abs() < 1e-15);
        let direction = t.direction.expect("a direction");
        assert!((direction.value - 30f64.to_radians()).abs() < 1e-12);
        assert!((t.constant - Complex64::new(0.0, 0.01)).norm() < 1e-15);
        // No scatter: the tilt of 1 mrad alone, far from zero, along and across.
        assert!((t.ratio.standard_uncertainty - 1e-3).abs() < 1e-8);
        assert!((direction.standard_uncertainty - 0.05).abs() < 1e-6);
    }

    #[test]
    fn known_uncertainty_of_two_directions() {
        let s = Complex64::new(0.01, 0.0);
        let rows = [
            row(Motion::Axial, s),
            across(0.0, s * 0.5),
            across(90.0, s * 0.0),
        ];
        let mut test = test(0.003);
        // Nothing shows the scatter, and nothing was declared.
        assert!(matches!(evaluated(&test, &rows), Err(Error::TooFew { .. })));
        test.seat.reading = Some((0.002, DegreesOfFreedom::INFINITE));
        // Two directions do not show how square the device sits.
        assert!(matches!(evaluated(&test, &rows), Err(Error::TooFew { .. })));
        test.seat.squareness = Some(0.006);
        let t = evaluated(&test, &rows).expect("a result");
        assert!(!t.constant_fitted);
        // √(3² + 2² + 6² · 3/2 + (0.5 · 2)²) mrad, far from zero: tilt, reading, squareness, reading along the axis.
        assert!((t.ratio.value - 0.5).abs() < 1e-15);
        assert!((t.ratio.standard_uncertainty - 68f64.sqrt() * 1e-3).abs() < 1e-9);
    }

    #[test]
    fn refuses_directions_that_are_one_line() {
        let s = Complex64::new(0.01, 0.0);
        for degrees in [
            vec![0.0],
            vec![0.0, 180.0],
            vec![45.0, 405.0, 225.0],
            vec![],
        ] {
            let mut rows = vec![row(Motion::Axial, s)];
            rows.extend(degrees.iter().map(|d| across(*d, s * 0.01)));
            let failed = evaluated(&test(1e-3), &rows);
            assert!(matches!(failed, Err(Error::TooFew { .. })), "{degrees:?}");
        }
        let rows = [
            across(0.0, s),
            across(90.0, s),
            across(180.0, s),
            across(270.0, s),
        ];
        assert!(matches!(
            evaluated(&test(1e-3), &rows),
            Err(Error::NotFinite { .. })
        ));
    }

    #[test]
    fn coverage_of_transverse_sensitivity() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(31);
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let trials = 1000;
        // 94 % and more, four standard deviations of the count below.
        let least = 0.94 * f64::from(trials) - 4.0 * (f64::from(trials) * 0.05 * 0.95).sqrt();
        let mut alarms = 0;
        for (directions, tilt, noise) in [(4, 1e-3, 1e-3), (12, 2e-3, 1e-3), (12, 0.5e-3, 5e-3)] {
            for t in [0.0, 0.002, 0.005, 0.02, 0.05] {
                let mut hits = 0;
                let mut angles = [0, 0];
                for trial in 0..trials {
                    let s = Complex64::from_polar(0.01, 0.3);
                    let angle = f64::from(trial) * 0.01;
                    let base = [draw() * tilt, draw() * tilt];
                    let constant = Complex64::new(draw(), draw()) * 0.02;
                    let mut rows = vec![row(Motion::Axial, s)];
                    for k in 0..directions {
                        let w = TAU * f64::from(k) / f64::from(directions);
                        let clean = t * (w - angle).cos() + base[0] * w.cos() + base[1] * w.sin();
                        let y = clean + constant + Complex64::new(draw(), draw()) * noise;
                        rows.push(across(w.to_degrees(), s * y));
                    }
                    let list: Vec<&TransverseRow> = rows.iter().collect();
                    let (found, findings) = test(tilt)
                        .evaluate(160.0, &list, (0.0, 0.0), None)
                        .expect("a result");
                    hits += i32::from((found.ratio.value - t).abs() <= found.ratio.expanded);
                    alarms += findings.len();
                    if let Some(direction) = found.direction {
                        let off = (direction.value - angle).rem_euclid(TAU / 2.0);
                        let off = off.min(TAU / 2.0 - off);
                        angles[0] += i32::from(off <= direction.expanded);
                        angles[1] += 1;
                    }
                }
                println!("{directions} {tilt} {noise} {t}: {hits} {angles:?} of {trials}");
                assert!(
                    f64::from(hits) >= least,
                    "{directions} {tilt} {noise} {t}: {hits}"
                );
                if t >= 0.02 {
                    let n = f64::from(angles[1]);
                    let least = 0.93 * n - 4.0 * (n * 0.05 * 0.95).sqrt();
                    assert!(
                        f64::from(angles[0]) >= least,
                        "{directions} {t}: {angles:?}"
                    );
                }
            }
        }
        // One in a thousand where there are directions enough: ten of 10 000, and four standard deviations.
        assert!(alarms <= 23, "{alarms} of 10 000");
    }

    /// One mounting that is turned has one error for both directions, two mountings have two: the interval holds either way.
    #[test]
    fn coverage_of_two_directions_with_one_error_or_two() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(33);
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let trials = 2000;
        let least = 0.94 * f64::from(trials) - 4.0 * (f64::from(trials) * 0.05 * 0.95).sqrt();
        let s = Complex64::new(0.01, 0.0);
        let mut test = test(1e-3);
        test.seat.squareness = Some(2e-3);
        test.seat.reading = Some((1e-3, DegreesOfFreedom::INFINITE));
        for shared in [false, true] {
            for degrees in [0.0, 45.0, 135.0] {
                let mut hits = 0;
                for _ in 0..trials {
                    let angle = f64::to_radians(degrees);
                    let first = 2e-3 * draw();
                    let second = if shared { first } else { 2e-3 * draw() };
                    let mut read = |clean: f64, c: f64| {
                        let noise = Complex64::new(draw(), draw()) * 1e-3;
                        s * (clean + c + 1e-3 * draw() + noise)
                    };
                    let rows = [
                        row(Motion::Axial, s),
                        across(0.0, read(0.03 * angle.cos(), first)),
                        across(90.0, read(0.03 * angle.sin(), second)),
                    ];
                    let t = evaluated(&test, &rows).expect("a result");
                    hits += i32::from((t.ratio.value - 0.03).abs() <= t.ratio.expanded);
                }
                println!("{shared} {degrees}: {hits} of {trials}");
                assert!(f64::from(hits) >= least, "{shared} {degrees}: {hits}");
            }
        }
    }

    #[test]
    fn law_a_second_harmonic_is_told() {
        let s = Complex64::new(0.01, 0.0);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(32);
        let mut rows = vec![row(Motion::Axial, s)];
        for k in 0..12 {
            let w = TAU * f64::from(k) / 12.0;
            let noise: f64 = StandardNormal.sample(&mut rng);
            let y = 0.02 * w.cos() + 0.01 * (2.0 * w).sin() + 1e-3 * noise;
            rows.push(across(w.to_degrees(), s * y));
        }
        let list: Vec<&TransverseRow> = rows.iter().collect();
        let (_, findings) = test(1e-3)
            .evaluate(160.0, &list, (0.0, 0.0), None)
            .expect("a result");
        assert_eq!(findings[0].code(), "not-a-cosine");
    }
}
