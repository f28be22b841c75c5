//! The estimator of the adjustment, applied to trials side by side.

use super::envelope::{Envelope, Group};
use super::lanes::{
    Complex, Motion, Real, WIDEST, leaning, motion, response, tilted, turned, turned_back, wedge,
};
use crate::adjustment::Adjustment;
use crate::budget::{Acts, Budget};
use crate::matrix::Matrix;
use crate::observation::{PhasorRow, SpuriousTable};
use num_complex::Complex64;
use proofmass_core::Error;
use pulp::Simd;

/// What an unknown of the adjustment does to a row.
enum Unknown {
    Inclination(f64),
    Rotation(f64),
    Lean(f64),
    /// About x (0) or y (1) of the device.
    Tilt(usize, f64),
    /// Relative change of all outputs, or of one.
    Factor(Option<usize>, Complex64),
    /// Added to an output over the reference.
    Additive(usize, Complex64),
    Spurious(usize, Complex64),
}

struct Row {
    frequency: usize,
    angles: [(f64, f64); 2],
    excitation: [Complex64; 3],
    weight: [[f64; 6]; 6],
    unknowns: Vec<(usize, Unknown)>,
    /// Whether an unknown tilts the device; whether one leans the wedge or is a motion of the table.
    tilts: bool,
    leans: bool,
    /// Whether all that moves is in phase with the table.
    in_phase: bool,
}

/// Minimises the sum of squares of the adjustment by steps with the normal equations of its solution.
///
/// The gradient is taken where the parameters are, so the point found is the minimum itself; that the normal equations
/// stay as they are only costs a few steps more.
pub(super) struct Estimator {
    rows: Vec<Row>,
    frequencies: Vec<f64>,
    /// Solution of the noise-free campaign, in units of `scale`.
    start: Vec<f64>,
    truth: Vec<Matrix>,
    /// What gives a step from a gradient.
    normal: Envelope,
    scale: f64,
    first_draw: usize,
}

/// Largest number of gradients; three or four are the rule, angles of 15° need some ten.
const EVALUATIONS: usize = 200;
/// Share of its u by which a parameter may be off at the end.
const ENOUGH: f64 = 0.002;
/// Share of a step that the next one is taken to have at least: the first two do not tell it, since the second is what
/// the first left by curvature.
const LEAST_SHARE: f64 = 0.1;

impl Estimator {
    pub(super) fn new(
        adjustment: &Adjustment,
        rows: &[PhasorRow],
        spurious: &SpuriousTable,
        budget: &Budget,
    ) -> Result<Self, Error> {
        let first_draw = adjustment.first_draw();
        let j = Complex64::new(0.0, 1.0);
        let one = Complex64::new(1.0, 0.0);
        let model: Vec<Row> = rows
            .iter()
            .enumerate()
            .map(|(i, row)| {
                let entry = spurious.get(row.configuration.inclination, row.frequency);
                let unknowns = adjustment.links[i]
                    .iter()
                    .map(|link| {
                        let unknown = match link.input.map(|k| &budget.inputs[k]) {
                            Some(input) => {
                                let u = input.standard_uncertainty_at(row.frequency);
                                let channel = link.part % 3;
                                match input.acts {
                                    Acts::Inclination => {
                                        Unknown::Inclination(input.standard_uncertainty())
                                    }
                                    Acts::Rotation => {
                                        Unknown::Rotation(input.standard_uncertainty())
                                    }
                                    Acts::Lean => Unknown::Lean(input.standard_uncertainty()),
                                    Acts::Tilt => {
                                        Unknown::Tilt(link.part, input.standard_uncertainty())
                                    }
                                    Acts::ReferenceModulus => Unknown::Factor(None, -one * u),
                                    Acts::ReferencePhase => Unknown::Factor(None, -j * u),
                                    Acts::OutputModulus => Unknown::Factor(Some(channel), one * u),
                                    Acts::OutputPhase => Unknown::Factor(Some(channel), j * u),
                                    Acts::OutputAdditive => {
                                        let part = if link.part >= 3 { j } else { one };
                                        Unknown::Additive(
                                            channel,
                                            part * u / (row.reference * adjustment.scale),
                                        )
                                    }
                                }
                            }
                            None => Unknown::Spurious(
                                link.part / 2,
                                entry.map_or(Complex64::new(0.0, 0.0), |s| {
                                    spurious.step(s, link.share, link.part)
                                }),
                            ),
                        };
                        (first_draw + link.draw, unknown)
                    })
                    .collect::<Vec<_>>();
                let has = |what: &dyn Fn(&Unknown) -> bool| unknowns.iter().any(|(_, u)| what(u));
                let mut excitation = entry.map_or([Complex64::new(0.0, 0.0); 3], |s| s.ratio);
                excitation[2] += 1.0;
                Row {
                    frequency: adjustment.of_row[i],
                    angles: [
                        row.configuration.inclination.sin_cos(),
                        row.configuration.rotation.sin_cos(),
                    ],
                    excitation,
                    weight: adjustment.weights[i],
                    tilts: has(&|u| matches!(u, Unknown::Tilt(..))),
                    leans: has(&|u| matches!(u, Unknown::Lean(_) | Unknown::Spurious(..))),
                    in_phase: excitation.iter().all(|e| e.im == 0.0)
                        && !has(&|u| matches!(u, Unknown::Spurious(..))),
                    unknowns,
                }
            })
            .collect();
        let groups: Vec<Group> = model
            .iter()
            .map(|row| {
                let terms = 18 * row.frequency..18 * row.frequency + 18;
                Group {
                    block: row.frequency,
                    unknowns: terms.chain(row.unknowns.iter().map(|u| u.0)).collect(),
                }
            })
            .collect();
        Ok(Self {
            rows: model,
            frequencies: adjustment.frequencies.clone(),
            truth: (0..adjustment.frequencies.len())
                .map(|f| adjustment.sensitivity(f))
                .collect(),
            start: adjustment.parameters.clone(),
            normal: Envelope::new(adjustment.covariances(), &groups)?,
            scale: adjustment.scale,
            first_draw,
        })
    }

    pub(super) fn frequencies(&self) -> &[f64] {
        &self.frequencies
    }

    /// The true S of each row, V/(m/s²).
    pub(super) fn truths(&self) -> impl Iterator<Item = &Matrix> {
        self.rows.iter().map(|row| &self.truth[row.frequency])
    }

    /// Estimate less the truth, 18 reals per frequency, V/(m/s²), for what each row showed in some trials: a column of
    /// them per real.
    #[inline(always)]
    pub(super) fn change<S: Simd>(
        &self,
        simd: S,
        mut observed: Vec<[Complex<S>; 3]>,
        change: &mut [&mut [f64]],
    ) {
        let zero = Real::new(simd, 0.0);
        let over = Real::new(simd, 1.0 / self.scale);
        for y in observed.iter_mut().flatten() {
            *y = *y * over;
        }
        let count = self.start.len();
        let mut next = vec![zero; count];
        for (next, start) in next.iter_mut().zip(&self.start) {
            *next = Real::new(simd, *start);
        }
        let mut at = next.clone();
        let mut step = vec![zero; count];
        let mut newton = vec![zero; count];
        let mut work = vec![zero; count];
        let mut gradient = vec![zero; count];
        let mut trials = [Descent::START; WIDEST];
        let trials = &mut trials[..S::F64_LANES];
        let [mut sums, mut largest] = [[0.0; WIDEST]; 2];
        let [mut taken, mut length] = [[0.0; WIDEST]; 2];
        for _ in 0..EVALUATIONS {
            self.gradient(simd, &observed, &next, &mut gradient)
                .store(&mut sums[..S::F64_LANES]);
            self.normal
                .solve(simd, &gradient, &mut work, &mut newton)
                .store(&mut largest[..S::F64_LANES]);
            for (k, trial) in trials.iter_mut().enumerate() {
                taken[k] = f64::from(u8::from(trial.takes(sums[k], largest[k])));
                length[k] = trial.length;
            }
            // A trial that takes the step goes on from there, the others try a shorter one from where they were.
            let taken = Real::load(simd, &taken[..S::F64_LANES]);
            let length = Real::load(simd, &length[..S::F64_LANES]);
            for (k, next) in next.iter_mut().enumerate() {
                at[k] = at[k].unless(taken, *next);
                step[k] = step[k].unless(taken, newton[k]);
                *next = at[k] + step[k] * length;
            }
            if trials.iter().all(|trial| trial.ended) {
                break;
            }
        }
        for ((change, a), s) in change.iter_mut().zip(&next).zip(&self.start) {
            ((*a - *s) * self.scale).store(change);
        }
    }

    /// The sum of squares, and −½ of its gradient.
    #[inline(always)]
    fn gradient<S: Simd>(
        &self,
        simd: S,
        observed: &[[Complex<S>; 3]],
        at: &[Real<S>],
        gradient: &mut [Real<S>],
    ) -> Real<S> {
        let zero = Real::new(simd, 0.0);
        let mut sum = zero;
        gradient.fill(zero);
        for (g, z) in gradient.iter_mut().zip(at).skip(self.first_draw) {
            sum += *z * *z;
            *g = -*z;
        }
        for (row, y) in self.rows.iter().zip(observed) {
            sum += if row.in_phase {
                row.gradient::<S, Real<S>>(simd, y, at, gradient)
            } else {
                row.gradient::<S, Complex<S>>(simd, y, at, gradient)
            };
        }
        sum
    }
}

impl Row {
    /// What this row adds to the sum of squares, and to −½ of its gradient.
    #[inline(always)]
    fn gradient<S: Simd, M: Motion<S>>(
        &self,
        simd: S,
        y: &[Complex<S>; 3],
        at: &[Real<S>],
        gradient: &mut [Real<S>],
    ) -> Real<S> {
        let zero = Real::new(simd, 0.0);
        let p = 18 * self.frequency;
        let none = Complex { re: zero, im: zero };
        let mut s = [[none; 3]; 3];
        for (k, z) in s.as_flattened_mut().iter_mut().enumerate() {
            (z.re, z.im) = (at[p + 2 * k], at[p + 2 * k + 1]);
        }
        let mut sum = zero;
        let (mut alpha, mut omega, mut lean, mut tilt) = (zero, zero, zero, [zero; 2]);
        let (mut factor, mut added) = ([none; 3], [none; 3]);
        for factor in &mut factor {
            factor.re = Real::new(simd, 1.0);
        }
        let mut e: [M; 3] = motion(simd, self.excitation);
        for (index, unknown) in &self.unknowns {
            let z = at[*index];
            match unknown {
                Unknown::Inclination(u) => alpha += z * *u,
                Unknown::Rotation(u) => omega += z * *u,
                Unknown::Lean(u) => lean += z * *u,
                Unknown::Tilt(k, u) => tilt[*k] += z * *u,
                Unknown::Spurious(k, c) => e[*k] = e[*k] + M::of(Complex::new(simd, *c) * z),
                Unknown::Factor(Some(j), c) => factor[*j].add_times(*c, z),
                Unknown::Factor(None, c) => {
                    for factor in &mut factor {
                        factor.add_times(*c, z);
                    }
                }
                Unknown::Additive(j, c) => added[*j].add_times(*c, z),
            }
        }
        let wedge = wedge(self.angles, alpha, omega);
        let lean = lean.turn();
        let leant = leaning(lean, &e);
        let moved = turned(&wedge, &leant);
        let tilt = if self.tilts { Some(tilted(tilt)) } else { None };
        let d = match &tilt {
            Some(tilt) => turned(tilt, &moved),
            None => moved,
        };
        let (mut plain, mut residual) = ([none; 3], [none; 3]);
        for j in 0..3 {
            plain[j] = response(&d, [s[0][j], s[1][j], s[2][j]]);
            residual[j] = y[j] - plain[j] * factor[j] - added[j];
        }
        // The conjugate of N⁻¹ r as three complex numbers: the inner product with a column c is Re Σ c_j w_j. With
        // it the same for a change of d, of what is moved, and of what has leant: carried back once for all unknowns.
        let (mut w, mut of_plain, mut of_factor) = (plain, plain, plain);
        let mut of_d = d;
        for j in 0..3 {
            w[j] = Complex {
                re: weighted(&self.weight[2 * j], &residual),
                im: -weighted(&self.weight[2 * j + 1], &residual),
            };
            sum += residual[j].inner(w[j]);
            of_plain[j] = factor[j] * w[j];
            of_factor[j] = plain[j] * w[j];
        }
        for i in 0..3 {
            of_d[i] = M::of(response(&of_plain, s[i]));
            for j in 0..3 {
                let c = d[i].times(of_plain[j]);
                let k = p + 2 * (3 * i + j);
                gradient[k] += c.re;
                gradient[k + 1] += -c.im;
            }
        }
        let of_moved = match &tilt {
            Some(tilt) => turned_back(tilt, &of_d),
            None => of_d,
        };
        let (mut of_leant, mut of_e) = (of_moved, of_moved);
        if self.leans {
            of_leant = turned_back(&wedge, &of_moved);
            of_e = leaning(lean.conj(), &of_leant);
        }
        for (index, unknown) in &self.unknowns {
            gradient[*index] += match unknown {
                Unknown::Inclination(u) => {
                    let [
                        [_, minus_sin, _],
                        [_, cos, _],
                        [minus_sin_alpha, _, cos_alpha],
                    ] = wedge;
                    let across = leant[2] * cos_alpha + leant[0] * minus_sin_alpha;
                    let down = leant[2] * minus_sin_alpha - leant[0] * cos_alpha;
                    let level =
                        across.inner(of_moved[0]) * cos - across.inner(of_moved[1]) * minus_sin;
                    (level + down.inner(of_moved[2])) * *u
                }
                Unknown::Rotation(u) => {
                    (moved[0].inner(of_moved[1]) - moved[1].inner(of_moved[0])) * *u
                }
                // Q′ e = (0, e_z, −e_y) of what has leant already.
                Unknown::Lean(u) => {
                    (leant[2].inner(of_leant[1]) - leant[1].inner(of_leant[2])) * *u
                }
                Unknown::Tilt(0, u) => (d[2].inner(of_d[1]) - d[1].inner(of_d[2])) * *u,
                Unknown::Tilt(_, u) => (d[0].inner(of_d[2]) - d[2].inner(of_d[0])) * *u,
                Unknown::Spurious(k, c) => of_e[*k].inner(M::of(Complex::new(simd, *c))),
                Unknown::Factor(Some(j), c) => of_factor[*j].inner(Complex::new(simd, *c)),
                Unknown::Factor(None, c) => {
                    let all = of_factor[0] + of_factor[1] + of_factor[2];
                    all.inner(Complex::new(simd, *c))
                }
                Unknown::Additive(j, c) => w[*j].inner(Complex::new(simd, *c)),
            };
        }
        sum
    }
}

/// A row of N⁻¹ times a residual.
#[inline(always)]
fn weighted<S: Simd>(weight: &[f64; 6], r: &[Complex<S>; 3]) -> Real<S> {
    let [x, y, z] = r;
    (x.re * weight[0] + x.im * weight[1])
        + (y.re * weight[2] + y.im * weight[3])
        + (z.re * weight[4] + z.im * weight[5])
}

/// How far the descent of one trial has come.
#[derive(Clone, Copy)]
struct Descent {
    /// The sum of squares where it is.
    sum: f64,
    /// The full step from there, largest change of a parameter over its u.
    step: f64,
    /// Share of it that is tried.
    length: f64,
    ended: bool,
}

impl Descent {
    const START: Self = Self {
        sum: f64::INFINITY,
        step: 0.0,
        length: 1.0,
        ended: false,
    };

    /// Whether the step that was tried is taken, given the sum it reaches and the full step from there. Shorter steps
    /// while the sum rises: angles far from where the covariance is of. Steps shrink by about the same share each
    /// time, so that the last is the one after which all others together would not move a parameter by [`ENOUGH`].
    #[inline(always)]
    fn takes(&mut self, reached: f64, step: f64) -> bool {
        if self.ended {
            return false;
        }
        if !(reached <= self.sum * (1.0 + 1e-9) + 1e-9) && self.length >= 1e-3 {
            self.length *= 0.5;
            return false;
        }
        let share = (step / (self.length * self.step)).max(LEAST_SHARE);
        let left = if share < 0.5 {
            step * share / (1.0 - share)
        } else {
            step
        };
        *self = Self {
            sum: reached,
            step,
            length: 1.0,
            ended: left < ENOUGH,
        };
        true
    }
}
