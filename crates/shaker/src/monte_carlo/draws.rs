//! The errors of a trial: which draw of the general engine reaches which phasor of which run.

use super::lanes::{Complex, Motion, Real, leaning, motion, response, tilted, turned, wedge};
use crate::budget::{Acts, Budget, Key, PART};
use crate::matrix::{AXES, Matrix};
use crate::observation::{Basis, PhasorRow, Share, Spurious, SpuriousTable, root};
use num_complex::Complex64;
use proofmass_uncertainty::{DegreesOfFreedom, Distribution, Input, JointInputs, Labels, Refusal};
use pulp::Simd;

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
    /// Whether a draw tilts the device.
    tilts: bool,
    /// Whether all that moves is in phase with the table.
    in_phase: bool,
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
            .add(Input::new(NOISE, "1", unit.clone()).varies_with([
                Key::Run.name(),
                Key::Channel.name(),
                PART,
            ]));
        let some = |e: &Spurious| e.basis.iter().any(|b| *b != Basis::Measured);
        let unmeasured = match spurious.entries.iter().any(some) {
            true => &Share::ALL[..],
            false => &[],
        };
        let inputs = unmeasured.iter().fold(inputs, |inputs, share| {
            let keys = share.varies_with().iter().map(|k| k.name());
            let keys: Vec<&str> = keys.chain([Key::Channel.name(), PART]).collect();
            inputs.add(Input::new(share.description(), "1", unit.clone()).varies_with(keys))
        });
        // Angles to a microradian, rotations modulo a turn: what a plan calls the same.
        let angle = |a: f64| (a.rem_euclid(std::f64::consts::TAU) * 1e6).round() as i64 % 6_283_185;
        let mut observations = Vec::with_capacity(rows.len() * 8);
        for (i, row) in rows.iter().enumerate() {
            for channel in ["x", "y", "z", "reference"] {
                for part in ["re", "im"] {
                    let session = row.session.as_deref().unwrap_or_default();
                    observations.push(
                        Labels::new()
                            .with(Key::Session.name(), session)
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
                let outputs = match input.acts.on_one_output() {
                    true => input.on_parts(),
                    false => 0..1,
                };
                for j in outputs {
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
                    let inputs = match s.basis[k] {
                        Basis::Measured => vec![(Share::Own, SPURIOUS.to_owned())],
                        Basis::Declared | Basis::Assumed => Share::ALL
                            .map(|share| (share, share.description()))
                            .to_vec(),
                    };
                    for (share, input) in inputs {
                        for part in 0..2 {
                            let r = spurious.step(s, share, 2 * k + part);
                            if r != Complex64::new(0.0, 0.0) {
                                errors.push((
                                    draw(place(i, k, part), &input)?,
                                    Error::Spurious(k, r),
                                ));
                            }
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
                in_phase: excitation.iter().all(|e| e.im == 0.0)
                    && !errors.iter().any(|(_, e)| matches!(e, Error::Spurious(..))),
                tilts: errors.iter().any(|(_, e)| matches!(e, Error::Tilt(..))),
                errors,
            });
        }
        Ok(Self { joint, rows: model })
    }

    /// What the engine draws.
    pub(super) fn inputs(&self) -> &JointInputs {
        &self.joint
    }

    /// Outputs over reference of one run in some trials, for a device of this S: the trials from `first` on, a column
    /// of them per draw.
    #[inline(always)]
    pub(super) fn observe<S: Simd>(
        &self,
        simd: S,
        row: usize,
        x: &[&[f64]],
        first: usize,
        s: &Matrix,
    ) -> [Complex<S>; 3] {
        let row = &self.rows[row];
        if row.in_phase {
            row.observe::<S, Real<S>>(simd, x, first, s)
        } else {
            row.observe::<S, Complex<S>>(simd, x, first, s)
        }
    }
}

impl Row {
    #[inline(always)]
    fn observe<S: Simd, M: Motion<S>>(
        &self,
        simd: S,
        x: &[&[f64]],
        first: usize,
        s: &Matrix,
    ) -> [Complex<S>; 3] {
        let [zero, one] = [Real::new(simd, 0.0), Real::new(simd, 1.0)];
        let (mut alpha, mut omega, mut lean, mut tilt) = (zero, zero, zero, [zero; 2]);
        let (mut modulus, mut phase) = ([one; 3], [zero; 3]);
        let (mut reference, mut turn) = (one, zero);
        let mut added = [Complex { re: zero, im: zero }; 3];
        let measured = Complex::new(simd, self.reference);
        let mut read = measured;
        let mut e: [M; 3] = motion(simd, self.excitation);
        for (draw, error) in &self.errors {
            let x = Real::load(simd, &x[*draw][first..]);
            match error {
                Error::ReferenceModulus(c) => reference = reference * (x * *c + 1.0),
                Error::ReferencePhase(c) => turn += x * *c,
                Error::OutputModulus(j, c) => modulus[*j] = modulus[*j] * (x * *c + 1.0),
                Error::OutputPhase(j, c) => phase[*j] += x * *c,
                Error::Additive(j, c) => added[*j].add_times(*c, x),
                Error::Inclination(c) => alpha += x * *c,
                Error::Rotation(c) => omega += x * *c,
                Error::Lean(c) => lean += x * *c,
                Error::Tilt(k, c) => tilt[*k] += x * *c,
                Error::Spurious(k, c) => e[*k] = e[*k] + M::of(Complex::new(simd, *c) * x),
                Error::Reference(c) => read.add_times(*c, x),
            }
        }
        let mut d = turned(&wedge(self.angles, alpha, omega), &leaning(lean.turn(), &e));
        if self.tilts {
            d = turned(&tilted(tilt), &d);
        }
        let inverse = (read * (turn.turn() * reference)).reciprocal();
        let mut seen = added;
        for j in 0..3 {
            let s = [
                Complex::new(simd, s[0][j]),
                Complex::new(simd, s[1][j]),
                Complex::new(simd, s[2][j]),
            ];
            let error = phase[j].turn() * modulus[j];
            seen[j] = (response(&d, s) * error * measured + added[j]) * inverse;
        }
        seen
    }
}
