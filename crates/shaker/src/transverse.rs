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

mod cosine;
#[cfg(test)]
mod tests;

use super::derived::{Expanded, largest_response, propagate};
use super::near_zero::{Kind, size};
use crate::departing::{DeclaredReading, Repeats, in_words, judge};
use crate::findings;
use cosine::{Fit, directions, least_squares};
use faer::Mat;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::algebra::symmetric_eigenvalues;
use proofmass_uncertainty::{
    Complex, Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding,
    Influence, Model, Number, f_quantile,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_1_SQRT_2;

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
#[derive(Clone, Debug, PartialEq)]
pub struct TransverseRow {
    /// Name of the run.
    pub run: String,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Along which direction it was shaken.
    pub motion: Motion,
    /// Output per acceleration of the table along the vibration.
    pub ratio: Complex64,
    /// Motion of the table across the vibration relative to it, where it was measured.
    pub transverse: Option<f64>,
}

/// How well the device sits, standard uncertainties.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxialSensitivity {
    /// Complex sensitivity.
    pub value: Complex64,
    /// Relative standard uncertainty of the modulus.
    pub relative: f64,
    /// Standard uncertainty of the phase, rad.
    pub phase: f64,
}

/// Transverse sensitivity at one frequency.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
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
        findings.extend(self.disagreement(frequency, rows, s));
        findings.extend(self.off_cosine(frequency, rows, s));
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
                list.push(Influence::normal("seat.squareness", "motion along the axis: mounting not square to the vibration, and what the table adds"
                        , Effect::Joint {
                        covariance: Covariance::try_from_rows(6, &covariance)?,
                    }));
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
        let (one, ..) = least_squares(&design(1), across)?;
        let (two, parameters, _) = least_squares(&design(2), across)?;
        let freedom = 2.0 * (n as f64 - 5.0);
        let gained = (one - two) / 4.0;
        let rest = two / freedom;
        let largest = parameters[3].norm().hypot(parameters[4].norm()) / s.norm();
        // Below the rounding of the ratios there is nothing to test.
        let floor = (1e-12 * s.norm()).powi(2);
        let limit = f_quantile(1.0 - self.false_alarm_rate, 4.0, freedom);
        Ok((gained > limit * rest.max(floor)).then(|| {
            findings::not_a_cosine(frequency, 100.0 * largest, 100.0 * rest.sqrt() / s.norm())
        }))
    }

    /// Runs along the axis that are no repeats of the others.
    fn disagreement(&self, frequency: f64, rows: &[&TransverseRow], s: Complex64) -> Vec<Finding> {
        let along: Vec<&TransverseRow> = rows
            .iter()
            .filter(|r| r.motion == Motion::Axial)
            .copied()
            .collect();
        let values: Vec<Complex64> = along.iter().map(|r| r.ratio).collect();
        if let Repeats::Without(list) = judge(&values, &DeclaredReading::NOTHING, 1) {
            let cause = "look at gain, range and cable of that run along the axis";
            let told = list
                .iter()
                .map(|d| d.told(&along[d.index].run, frequency, cause));
            return told.collect();
        }
        let off = values.iter().map(|r| (r / s - 1.0).norm());
        let worst = off.fold(0.0, f64::max);
        let apart = worst > LARGEST_AXIAL_SCATTER;
        apart
            .then(|| findings::axial_runs_disagree(frequency, 100.0 * worst))
            .into_iter()
            .collect()
    }

    /// The run across the axis that departs most from what the others say of its direction, where that is more than a half per cent of the
    /// sensitivity and beyond their scatter (F test with two and 2 (n − 1 − p) degrees of freedom, and one chance for each run).
    fn off_cosine(&self, frequency: f64, rows: &[&TransverseRow], s: Complex64) -> Option<Finding> {
        let across: Vec<(&str, f64, Complex64)> = rows
            .iter()
            .filter_map(|r| match r.motion {
                Motion::Transverse { rotation } => Some((r.run.as_str(), rotation, r.ratio)),
                Motion::Axial => None,
            })
            .collect();
        let n = across.len();
        let mut worst: Option<(f64, Finding)> = None;
        for (index, &(run, rotation, ratio)) in across.iter().enumerate() {
            let others = across.iter().enumerate().filter(|(i, _)| *i != index);
            let others: Vec<(f64, Complex64)> = others.map(|(_, r)| (r.1, r.2)).collect();
            let Ok(fit) = Fit::new(&others) else {
                continue;
            };
            let Some((scatter, dof)) = fit.scatter() else {
                continue;
            };
            let (expected, variance) = fit.at(rotation);
            let departure = (ratio - expected).norm();
            // Below the rounding of the ratios there is nothing to test.
            let scatter = scatter.max(1e-9 * s.norm());
            let statistic = (departure / scatter).powi(2) / (2.0 * (1.0 + variance));
            let rate = OFF_COSINE * self.false_alarm_rate / n as f64;
            if departure < SMALLEST_OFF * s.norm()
                || statistic <= f_quantile(1.0 - rate, 2.0, dof.get())
                || worst.as_ref().is_some_and(|w| w.0 >= statistic)
            {
                continue;
            }
            let factor = match expected.norm() > 3.0 * scatter {
                true => format!("it is {} theirs", in_words(ratio / expected)),
                false => "they say next to nothing there".to_owned(),
            };
            let finding = findings::run_off_cosine(
                run,
                frequency,
                100.0 * departure / s.norm(),
                100.0 * scatter / s.norm(),
                &factor,
            );
            worst = Some((statistic, finding));
        }
        worst.map(|w| w.1)
    }
}

/// Scatter of the runs along the axis, relative, at which one of them is no repeat.
const LARGEST_AXIAL_SCATTER: f64 = 0.05;
/// Departure of a run across the axis, relative to the sensitivity, below which it is not a fault of the run.
const SMALLEST_OFF: f64 = 0.005;
/// Share of the false alarms that a run across the axis has.
const OFF_COSINE: f64 = 0.1;

/// T with its interval, and its direction where it has one.
fn derive(estimate: &Estimate, s: Complex64) -> Result<(Expanded, Option<Expanded>), Error> {
    let linear = propagate(estimate, &Ratio)?;
    let covariance = estimate.covariance();
    let largest = symmetric_eigenvalues(
        &Mat::from_fn(4, 4, |a, b| covariance[(2 + a, 2 + b)]),
        "eigenvalues of the covariance of the transverse sensitivity",
    )?[3];
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
    (u > 0.0).then(|| {
        Influence::normal(
            key,
            description,
            Effect::of_zero("1", u, effect.map(|z| [z.re, z.im]).concat()),
        )
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

/// What the runs of a frequency leave untold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Untold {
    /// All of them lie along one line.
    OneLine,
    /// Two directions do not tell how square the device sat.
    Squareness,
    /// So many runs across the axis leave none to show their scatter.
    Scatter {
        /// Runs across the axis.
        across: usize,
    },
}

/// Whether the runs of a frequency tell a transverse sensitivity: what [`TransverseTest::evaluate`] refuses with numbers.
pub fn untold(seat: &SeatUncertainty, rows: &[&TransverseRow]) -> Option<Untold> {
    let mut directions: Vec<f64> = Vec::new();
    let mut across = 0;
    for row in rows {
        if let Motion::Transverse { rotation } = row.motion {
            across += 1;
            let turn = std::f64::consts::TAU;
            let apart = |d: &f64| {
                let off = (rotation - d).rem_euclid(turn);
                off.min(turn - off) > 1e-6
            };
            if directions.iter().all(apart) {
                directions.push(rotation);
            }
        }
    }
    let first = directions.first().copied().unwrap_or(0.0);
    let spread = directions.iter().map(|d| (d - first).sin().abs());
    if spread.fold(0.0, f64::max) < 1e-3 {
        return Some(Untold::OneLine);
    }
    let needed = directions.len().min(3);
    if needed == 2 && seat.squareness.is_none() {
        return Some(Untold::Squareness);
    }
    (needed >= 2 && across <= needed && seat.reading.is_none())
        .then_some(Untold::Scatter { across })
}

/// Many directions within six degrees are a circle in radians: how many, the first and the last in degrees.
pub fn like_radians(rows: &[TransverseRow]) -> Option<(usize, [f64; 2])> {
    let mut turns: Vec<f64> = rows
        .iter()
        .filter_map(|r| match r.motion {
            Motion::Transverse { rotation } => Some(rotation.to_degrees()),
            Motion::Axial => None,
        })
        .collect();
    turns.sort_by(f64::total_cmp);
    turns.dedup();
    let (first, last) = (*turns.first()?, *turns.last()?);
    let alike = turns.len() > 2 && last - first > 1.0 && first.abs().max(last.abs()) <= 6.3;
    alike.then_some((turns.len(), [first, last]))
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
