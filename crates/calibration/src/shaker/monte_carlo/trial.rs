//! Trials of the observations: every error drawn, the geometry exact, eight trials side by side.

use crate::shaker::budget::{Acts, Budget, Key};
use crate::shaker::matrix::Matrix;
use crate::shaker::observation::PhasorRow;
use faer::c64;
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// Trials that are calculated side by side, so that the compiler can keep them in vector registers.
pub(super) const LANES: usize = 8;
/// One number of every trial of a group.
pub(super) type Lanes = [f64; LANES];

/// One input that several observations share: where its draws are for a row and an output.
struct Shared {
    acts: Acts,
    u: f64,
    rectangular: bool,
    /// First draw of the input, and for each row the group it belongs to; outputs follow each other.
    first: usize,
    group: Vec<usize>,
    groups: usize,
    per_output: bool,
}

pub(super) struct Model {
    inputs: Vec<Shared>,
    /// Rectangular inputs of a run: action, u, one draw per output or one for all.
    of_run: Vec<(Acts, f64, bool)>,
    /// Draws of all shared inputs of one trial.
    pub(super) shared: usize,
    rows: Vec<RowModel>,
    s: Matrix,
}

struct RowModel {
    angles: [(f64, f64); 2],
    expected: [c64; 3],
    per_volt: c64,
}

impl Model {
    pub(super) fn new(rows: &[PhasorRow], s: &Matrix, budget: &Budget, scale: f64) -> Self {
        let (mut inputs, mut of_run, mut shared) = (vec![], vec![], 0);
        let frequency = rows.first().map_or(0.0, |r| r.frequency);
        for input in &budget.inputs {
            let rectangular = input.distribution == "rectangular";
            let u = input.standard_uncertainty_at(frequency);
            if input.within_a_run() {
                let each = input.acts.on_one_output() && input.varies_with.contains(&Key::Channel);
                // Normal errors within a run are drawn together, see `within_runs`.
                if rectangular {
                    of_run.push((input.acts, u, each));
                }
                continue;
            }
            let key = |i: usize| -> Vec<i64> {
                let c = rows[i].configuration;
                let angle = |a: f64| (a.rem_euclid(std::f64::consts::TAU) * 1e6).round() as i64;
                input
                    .varies_with
                    .iter()
                    .map(|k| match k {
                        Key::Inclination => angle(c.inclination),
                        Key::Rotation => angle(c.rotation),
                        Key::Run => i as i64,
                        Key::Frequency | Key::Channel => 0,
                    })
                    .collect()
            };
            let mut keys: Vec<Vec<i64>> = vec![];
            let group = (0..rows.len())
                .map(|i| {
                    let k = key(i);
                    keys.iter().position(|v| *v == k).unwrap_or_else(|| {
                        keys.push(k);
                        keys.len() - 1
                    })
                })
                .collect();
            let per_output =
                input.acts.on_one_output() && input.varies_with.contains(&Key::Channel);
            let groups = keys.len();
            inputs.push(Shared {
                acts: input.acts,
                u,
                rectangular,
                first: shared,
                group,
                groups,
                per_output,
            });
            // Three outputs, and real and imaginary part where an error is additive.
            shared += groups * if per_output { 3 } else { 1 } * 2;
        }
        let rows = rows
            .iter()
            .map(|r| RowModel {
                angles: [
                    r.configuration.inclination.sin_cos(),
                    r.configuration.rotation.sin_cos(),
                ],
                expected: r.ratios().map(|y| y / scale),
                per_volt: 1.0 / (r.reference * scale),
            })
            .collect();
        Self {
            inputs,
            of_run,
            shared,
            rows,
            s: s.map(|row| row.map(|v| v / scale)),
        }
    }

    /// Some trials side by side: the change of the 18 reals of S.
    #[inline(always)]
    pub(super) fn trials<R: Rng>(
        &self,
        gains: &[[[f64; 6]; 18]],
        draws: &mut [Lanes],
        rng: &mut R,
    ) -> [Lanes; 18] {
        for input in &self.inputs {
            let outputs = if input.per_output { 3 } else { 1 };
            let parts = if input.acts == Acts::OutputAdditive {
                2
            } else {
                1
            };
            for d in &mut draws[input.first..input.first + input.groups * outputs * parts] {
                *d = draw(input.u, input.rectangular, rng);
            }
        }
        let mut change = [[0.0; LANES]; 18];
        for (index, row) in self.rows.iter().enumerate() {
            let mut seen = Errors::NONE;
            for input in &self.inputs {
                let outputs = if input.per_output { 3 } else { 1 };
                let first = input.first + input.group[index] * outputs;
                let second = first + input.groups * outputs;
                let each = usize::from(outputs == 3);
                seen.add(input.acts, |j, imaginary| {
                    draws[if imaginary { second } else { first } + j * each]
                });
            }
            for &(acts, u, each) in &self.of_run {
                // One draw for the three outputs, or one for each.
                let count = if each { 3 } else { 1 };
                let parts = if acts == Acts::OutputAdditive { 2 } else { 1 };
                let mut own = [[0.0; LANES]; 6];
                for d in &mut own[..count * parts] {
                    *d = draw(u, true, rng);
                }
                let step = usize::from(each);
                seen.add(acts, |j, imaginary| {
                    own[if imaginary { count } else { 0 } + j * step]
                });
            }
            let e = row.departures(&self.s, &seen);
            for (c, g) in change.iter_mut().zip(&gains[index]) {
                for l in 0..LANES {
                    let sum: f64 = (0..6).map(|k| g[k] * e[k][l]).sum();
                    c[l] += sum;
                }
            }
        }
        change
    }
}

/// The errors of one row in every trial of a group.
struct Errors {
    alpha: Lanes,
    omega: Lanes,
    modulus: [Lanes; 3],
    phase: [Lanes; 3],
    additive: [[Lanes; 2]; 3],
    reference: Lanes,
    turn: Lanes,
}

impl Errors {
    const NONE: Self = Self {
        alpha: [0.0; LANES],
        omega: [0.0; LANES],
        modulus: [[1.0; LANES]; 3],
        phase: [[0.0; LANES]; 3],
        additive: [[[0.0; LANES]; 2]; 3],
        reference: [1.0; LANES],
        turn: [0.0; LANES],
    };

    /// Adds an input whose draw for output j (and its imaginary part, where it has one) is given.
    #[inline(always)]
    fn add(&mut self, acts: Acts, draw: impl Fn(usize, bool) -> Lanes) {
        #[inline(always)]
        fn plus(a: &mut Lanes, b: Lanes) {
            for l in 0..LANES {
                a[l] += b[l];
            }
        }
        #[inline(always)]
        fn times(a: &mut Lanes, b: Lanes) {
            for l in 0..LANES {
                a[l] *= 1.0 + b[l];
            }
        }
        match acts {
            Acts::Inclination => plus(&mut self.alpha, draw(0, false)),
            Acts::Rotation => plus(&mut self.omega, draw(0, false)),
            Acts::ReferenceModulus => times(&mut self.reference, draw(0, false)),
            Acts::ReferencePhase => plus(&mut self.turn, draw(0, false)),
            Acts::OutputModulus => {
                for j in 0..3 {
                    times(&mut self.modulus[j], draw(j, false));
                }
            }
            Acts::OutputPhase => {
                for j in 0..3 {
                    plus(&mut self.phase[j], draw(j, false));
                }
            }
            Acts::OutputAdditive => {
                for j in 0..3 {
                    plus(&mut self.additive[j][0], draw(j, false));
                    plus(&mut self.additive[j][1], draw(j, true));
                }
            }
        }
    }
}

impl RowModel {
    /// What the six reals of the row are beside what is expected of them.
    #[inline(always)]
    fn departures(&self, s: &Matrix, seen: &Errors) -> [Lanes; 6] {
        let mut e = [[0.0; LANES]; 6];
        for l in 0..LANES {
            let (sa, ca) = sum(self.angles[0], seen.alpha[l]);
            let (sw, cw) = sum(self.angles[1], seen.omega[l]);
            let d = [sa * cw, sa * sw, ca];
            let per_reference = 1.0 / seen.reference[l];
            for j in 0..3 {
                let (mut re, mut im) = (0.0, 0.0);
                for i in 0..3 {
                    re += s[i][j].re * d[i];
                    im += s[i][j].im * d[i];
                }
                let (sin, cos) = small(seen.phase[j][l] - seen.turn[l]);
                let (cos, sin) = (cos * seen.modulus[j][l], sin * seen.modulus[j][l]);
                let ([a, b], v) = (
                    [seen.additive[j][0][l], seen.additive[j][1][l]],
                    self.per_volt,
                );
                let (re, im) = (
                    re * cos - im * sin + a * v.re - b * v.im,
                    re * sin + im * cos + a * v.im + b * v.re,
                );
                e[2 * j][l] = re * per_reference - self.expected[j].re;
                e[2 * j + 1][l] = im * per_reference - self.expected[j].im;
            }
        }
        e
    }
}

/// Adds the normal vector that the columns are a square root of the covariance of.
#[inline(always)]
pub(super) fn add_columns<R: Rng>(columns: &[[f64; 18]], delta: &mut [Lanes; 18], rng: &mut R) {
    for column in columns {
        let z: Lanes = draw(1.0, false, rng);
        for (d, c) in delta.iter_mut().zip(column) {
            for l in 0..LANES {
                d[l] += c * z[l];
            }
        }
    }
}

#[inline(always)]
fn draw<R: Rng>(u: f64, rectangular: bool, rng: &mut R) -> Lanes {
    let mut z = [0.0; LANES];
    if rectangular {
        // 32 bits for each: 5e-10 of the width is far below what a trial can show. The bits become a number as the
        // mantissa of 2⁵², which vectors can do.
        let scale = u * 3f64.sqrt() * 2f64.powi(-31);
        let mut halves = [0u64; LANES];
        for pair in halves.as_chunks_mut::<2>().0 {
            let bits = rng.next_u64();
            *pair = [bits & 0xffff_ffff, bits >> 32];
        }
        let (whole, middle) = (2f64.powi(52), 2f64.powi(31) - 0.5);
        for (z, half) in z.iter_mut().zip(halves) {
            *z = scale * (f64::from_bits(0x4330_0000_0000_0000 | half) - whole - middle);
        }
    } else {
        for z in &mut z {
            let normal: f64 = StandardNormal.sample(rng);
            *z = u * normal;
        }
    }
    z
}

/// Sine and cosine of a small angle: series to the sixth order, 2e-11 at 0.1 rad.
#[inline(always)]
fn small(x: f64) -> (f64, f64) {
    let q = x * x;
    (
        x * (1.0 - q * (1.0 / 6.0 - q * (1.0 / 120.0))),
        1.0 - q * (0.5 - q * (1.0 / 24.0 - q * (1.0 / 720.0))),
    )
}

/// Sine and cosine of a sum with a small angle.
#[inline(always)]
fn sum((s, c): (f64, f64), x: f64) -> (f64, f64) {
    let (ds, dc) = small(x);
    (s * dc + c * ds, c * dc - s * ds)
}
