//! The errors of a trial: which draw of the general engine reaches which phasor of which run.

use crate::shaker::adjustment::model::root;
use crate::shaker::budget::{Acts, Budget, Key, PART};
use crate::shaker::geometry::tilted;
use crate::shaker::matrix::{AXES, Matrix};
use crate::shaker::observation::{PhasorRow, SpuriousTable};
use num_complex::Complex64;
use proofmass_uncertainty::{DegreesOfFreedom, Distribution, Input, JointInputs, Labels, Refusal};

const SPURIOUS: &str = "measurement of the spurious motion";
const NOISE: &str = "noise of the sine approximations";

/// What one draw does to one run.
enum Error {
    ReferenceModulus(f64),
    ReferencePhase(f64),
    OutputModulus(usize, f64),
    OutputPhase(usize, f64),
    /// Volts in output j.
    Additive(usize, Complex64),
    Inclination(f64),
    Rotation(f64),
    Lean(f64),
    /// About x (0) or y (1) of the device.
    Tilt(usize, f64),
    /// Component k of the spurious ratios.
    Spurious(usize, Complex64),
    /// m/s² in the reference.
    Reference(Complex64),
}

struct Row {
    angles: [(f64, f64); 2],
    /// Whole motion of the seat over the motion of the table.
    excitation: [Complex64; 3],
    reference: Complex64,
    errors: Vec<(usize, Error)>,
}

/// All errors of all runs.
pub(super) struct Errors {
    joint: JointInputs,
    rows: Vec<Row>,
}

impl Errors {
    /// The draws of a budget for these rows, of a spurious table and of the covariances of the phasors.
    ///
    /// # Errors
    /// As [`Inputs::joint`](proofmass_uncertainty::Inputs::joint).
    pub(super) fn new(
        rows: &[PhasorRow],
        spurious: &SpuriousTable,
        budget: &Budget,
    ) -> Result<Self, Refusal> {
        let unit = Distribution::Normal { mean: 0.0, u: 1.0 };
        let fewest = rows
            .iter()
            .map(|r| spurious.dof_at(r.frequency))
            .fold(DegreesOfFreedom::INFINITE, |a, b| if b < a { b } else { a });
        let inputs = budget
            .inputs()
            .add(
                Input::new(SPURIOUS, "1", unit.clone())
                    .dof(fewest)
                    .varies_with([
                        Key::Frequency.name(),
                        Key::Inclination.name(),
                        Key::Channel.name(),
                        PART,
                    ]),
            )
            .add(Input::new(NOISE, "1", unit).varies_with([
                Key::Run.name(),
                Key::Channel.name(),
                PART,
            ]));
        // Angles to a microradian, rotations modulo a turn: what a plan calls the same.
        let angle = |a: f64| (a.rem_euclid(std::f64::consts::TAU) * 1e6).round() as i64 % 6_283_185;
        let mut observations = Vec::with_capacity(rows.len() * 8);
        for (i, row) in rows.iter().enumerate() {
            for channel in ["x", "y", "z", "reference"] {
                for part in ["re", "im"] {
                    observations.push(
                        Labels::new()
                            .with(Key::Frequency.name(), row.frequency)
                            .with(
                                Key::Inclination.name(),
                                angle(row.configuration.inclination),
                            )
                            .with(Key::Rotation.name(), angle(row.configuration.rotation))
                            .with(Key::Channel.name(), channel)
                            .with(Key::Run.name(), i)
                            .with(PART, part),
                    );
                }
            }
        }
        let joint = inputs.joint(&observations)?;
        let place = |row: usize, channel: usize, part: usize| 8 * row + 2 * channel + part;
        let draw = |observation: usize, input: &str| {
            joint
                .index_of(observation, input)
                .ok_or_else(|| Refusal::Unknown {
                    what: "input",
                    name: input.to_owned(),
                })
        };
        let mut model = vec![];
        for (i, row) in rows.iter().enumerate() {
            let mut errors = vec![];
            for input in &budget.inputs {
                let u = input.standard_uncertainty();
                if u == 0.0 {
                    continue;
                }
                let factor = input.standard_uncertainty_at(row.frequency) / u;
                let channels = if input.acts.on_one_output() { 3 } else { 1 };
                for j in 0..channels {
                    if input.acts.parts() > 1 {
                        let second = draw(place(i, j, 1), &input.key)?;
                        errors.push((
                            second,
                            match input.acts {
                                Acts::Tilt => Error::Tilt(1, factor),
                                _ => Error::Additive(j, Complex64::new(0.0, factor)),
                            },
                        ));
                    }
                    let error = match input.acts {
                        Acts::ReferenceModulus => Error::ReferenceModulus(factor),
                        Acts::ReferencePhase => Error::ReferencePhase(factor),
                        Acts::OutputModulus => Error::OutputModulus(j, factor),
                        Acts::OutputPhase => Error::OutputPhase(j, factor),
                        Acts::Inclination => Error::Inclination(factor),
                        Acts::Rotation => Error::Rotation(factor),
                        Acts::Lean => Error::Lean(factor),
                        Acts::Tilt => Error::Tilt(0, factor),
                        Acts::OutputAdditive => Error::Additive(j, Complex64::new(factor, 0.0)),
                    };
                    errors.push((draw(place(i, j, 0), &input.key)?, error));
                }
            }
            let mut excitation = [Complex64::new(0.0, 0.0); 3];
            if let Some(s) = spurious.get(row.configuration.inclination, row.frequency) {
                excitation = s.ratio;
                for (k, _) in AXES.iter().enumerate() {
                    for (part, r) in root(s.covariance[k]).into_iter().enumerate() {
                        if r != Complex64::new(0.0, 0.0) {
                            errors
                                .push((draw(place(i, k, part), SPURIOUS)?, Error::Spurious(k, r)));
                        }
                    }
                }
            }
            excitation[2] += 1.0;
            for channel in 0..4 {
                // Outputs are channels 0 to 2 here, the reference is 3; in a row the reference is first.
                for (part, r) in root(row.covariance[(channel + 1) % 4])
                    .into_iter()
                    .enumerate()
                {
                    if r != Complex64::new(0.0, 0.0) {
                        errors.push((
                            draw(place(i, channel, part), NOISE)?,
                            if channel < 3 {
                                Error::Additive(channel, r)
                            } else {
                                Error::Reference(r)
                            },
                        ));
                    }
                }
            }
            model.push(Row {
                angles: [
                    row.configuration.inclination.sin_cos(),
                    row.configuration.rotation.sin_cos(),
                ],
                excitation,
                reference: row.reference,
                errors,
            });
        }
        Ok(Self { joint, rows: model })
    }

    /// What the engine draws.
    pub(super) fn inputs(&self) -> &JointInputs {
        &self.joint
    }

    /// Outputs over reference of one run in a trial, for a device of this S.
    pub(super) fn observe(&self, row: usize, x: &[f64], s: &Matrix) -> [Complex64; 3] {
        let row = &self.rows[row];
        let (mut alpha, mut omega, mut lean, mut tilt) = (0.0, 0.0, 0.0, [0.0; 2]);
        let (mut modulus, mut phase) = ([1.0; 3], [0.0; 3]);
        let (mut reference, mut turn) = (1.0, 0.0);
        let mut added = [Complex64::new(0.0, 0.0); 3];
        let mut read = row.reference;
        let mut e = row.excitation;
        for (draw, error) in &row.errors {
            let x = x[*draw];
            match error {
                Error::ReferenceModulus(c) => reference *= 1.0 + c * x,
                Error::ReferencePhase(c) => turn += c * x,
                Error::OutputModulus(j, c) => modulus[*j] *= 1.0 + c * x,
                Error::OutputPhase(j, c) => phase[*j] += c * x,
                Error::Additive(j, c) => added[*j] += c * x,
                Error::Inclination(c) => alpha += c * x,
                Error::Rotation(c) => omega += c * x,
                Error::Lean(c) => lean += c * x,
                Error::Tilt(k, c) => tilt[*k] += c * x,
                Error::Spurious(k, c) => e[*k] += c * x,
                Error::Reference(c) => read += c * x,
            }
        }
        let (sa, ca) = plus(row.angles[0], alpha);
        let (sw, cw) = plus(row.angles[1], omega);
        let m = [
            [ca * cw, -sw, sa * cw],
            [ca * sw, cw, sa * sw],
            [-sa, 0.0, ca],
        ];
        let d = turned(&tilted(tilt), turned(&m, leaning(lean, e)));
        let seen = read * reference * small(turn);
        std::array::from_fn(|j| {
            let response = d[0] * s[0][j] + d[1] * s[1][j] + d[2] * s[2][j];
            (row.reference * response * modulus[j] * small(phase[j]) + added[j]) / seen
        })
    }
}

/// m e.
#[inline]
pub(super) fn turned(m: &[[f64; 3]; 3], e: [Complex64; 3]) -> [Complex64; 3] {
    std::array::from_fn(|i| e[0] * m[i][0] + e[1] * m[i][1] + e[2] * m[i][2])
}

/// Q(ℓ) e.
#[inline]
pub(super) fn leaning(lean: f64, e: [Complex64; 3]) -> [Complex64; 3] {
    if lean == 0.0 {
        return e;
    }
    let w = small(lean);
    [e[0], e[1] * w.re + e[2] * w.im, e[2] * w.re - e[1] * w.im]
}

/// e^{jx}; by its series to 2e-11 where x is as small as an error is.
#[inline]
fn small(x: f64) -> Complex64 {
    if x.abs() > 0.1 {
        return Complex64::from_polar(1.0, x);
    }
    let q = x * x;
    Complex64::new(
        1.0 - q * (0.5 - q * (1.0 / 24.0 - q * (1.0 / 720.0))),
        x * (1.0 - q * (1.0 / 6.0 - q * (1.0 / 120.0))),
    )
}

/// Sine and cosine of an angle with an error.
#[inline]
pub(super) fn plus((s, c): (f64, f64), x: f64) -> (f64, f64) {
    let d = small(x);
    (s * d.re + c * d.im, c * d.re - s * d.im)
}
