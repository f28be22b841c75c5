//! The estimator of the adjustment, applied to one trial after another.

use super::draws::{leaning, plus, turned};
use crate::shaker::adjustment::Adjustment;
use crate::shaker::adjustment::model::root;
use crate::shaker::budget::{Acts, Budget};
use crate::shaker::geometry::tilted;
use crate::shaker::matrix::{Matrix, from_real};
use crate::shaker::observation::{PhasorRow, SpuriousTable};
use num_complex::Complex64;

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
}

/// Minimises the sum of squares of the adjustment by steps with the covariance of its solution.
///
/// The gradient is taken where the parameters are, so the point found is the minimum itself; the fixed covariance
/// only costs a few steps more.
pub(super) struct Estimator {
    rows: Vec<Row>,
    frequencies: Vec<f64>,
    /// Solution of the noise-free campaign, in units of `scale`.
    start: Vec<f64>,
    truth: Vec<Matrix>,
    covariance: Vec<f64>,
    /// Standard deviation of each parameter.
    unit: Vec<f64>,
    scale: f64,
    first_draw: usize,
}

/// Largest number of steps; two to four are the rule, angles of 15° need some ten.
const STEPS: usize = 60;
/// A step that moves no parameter by this share of its u is the last.
const ENOUGH: f64 = 0.01;

impl Estimator {
    pub(super) fn new(
        adjustment: &Adjustment,
        rows: &[PhasorRow],
        spurious: &SpuriousTable,
        budget: &Budget,
    ) -> Self {
        let first_draw = adjustment.first_draw();
        let count = adjustment.parameters.len();
        let covariance = adjustment.covariances().to_vec();
        let j = Complex64::new(0.0, 1.0);
        let one = Complex64::new(1.0, 0.0);
        let model = rows
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
                                    root(s.covariance[link.part / 2])[link.part % 2]
                                }),
                            ),
                        };
                        (first_draw + link.draw, unknown)
                    })
                    .collect();
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
                    unknowns,
                }
            })
            .collect();
        Self {
            rows: model,
            frequencies: adjustment.frequencies.clone(),
            truth: (0..adjustment.frequencies.len())
                .map(|f| adjustment.sensitivity(f))
                .collect(),
            start: adjustment.parameters.clone(),
            unit: (0..count)
                .map(|i| covariance[i * count + i].sqrt())
                .collect(),
            covariance,
            scale: adjustment.scale,
            first_draw,
        }
    }

    pub(super) fn frequencies(&self) -> &[f64] {
        &self.frequencies
    }

    /// Estimate less the truth, 18 reals per frequency, V/(m/s²), for what each row shows of the true S.
    pub(super) fn change(
        &self,
        observe: impl Fn(usize, &Matrix) -> [Complex64; 3],
        change: &mut [f64],
    ) {
        let observed: Vec<[Complex64; 3]> = self
            .rows
            .iter()
            .enumerate()
            .map(|(i, row)| observe(i, &self.truth[row.frequency]).map(|y| y / self.scale))
            .collect();
        let count = self.start.len();
        let mut at = self.start.clone();
        let mut gradient = vec![0.0; count];
        let mut sum = self.gradient(&observed, &at, &mut gradient);
        let mut step = vec![0.0; count];
        let mut next = vec![0.0; count];
        for _ in 0..STEPS {
            for (step, row) in step.iter_mut().zip(self.covariance.chunks_exact(count)) {
                *step = row.iter().zip(&gradient).map(|(c, g)| c * g).sum();
            }
            // Shorter steps while the sum of squares rises: angles far from where the covariance is of.
            let mut length = 1.0;
            let reached = loop {
                for ((next, a), step) in next.iter_mut().zip(&at).zip(&step) {
                    *next = a + length * step;
                }
                let reached = self.gradient(&observed, &next, &mut gradient);
                if reached <= sum * (1.0 + 1e-9) + 1e-9 || length < 1e-3 {
                    break reached;
                }
                length *= 0.5;
            };
            std::mem::swap(&mut at, &mut next);
            sum = reached;
            let largest = step
                .iter()
                .zip(&self.unit)
                .map(|(step, unit)| (length * step / unit).abs())
                .fold(0.0, f64::max);
            if largest < ENOUGH {
                break;
            }
        }
        for (c, (a, s)) in change.iter_mut().zip(at.iter().zip(&self.start)) {
            *c = (a - s) * self.scale;
        }
    }

    /// The sum of squares, and −½ of its gradient.
    fn gradient(&self, observed: &[[Complex64; 3]], at: &[f64], gradient: &mut [f64]) -> f64 {
        gradient.fill(0.0);
        let mut sum: f64 = at[self.first_draw..].iter().map(|z| z * z).sum();
        for (g, z) in gradient.iter_mut().zip(at).skip(self.first_draw) {
            *g = -z;
        }
        let zero = Complex64::new(0.0, 0.0);
        for (row, y) in self.rows.iter().zip(observed) {
            let p = 18 * row.frequency;
            let s = from_real(&at[p..p + 18]);
            let (mut alpha, mut omega, mut lean, mut tilt) = (0.0, 0.0, 0.0, [0.0; 2]);
            let mut e = row.excitation;
            let mut factor = [Complex64::new(1.0, 0.0); 3];
            let mut added = [zero; 3];
            for (index, unknown) in &row.unknowns {
                let z = at[*index];
                match unknown {
                    Unknown::Inclination(u) => alpha += u * z,
                    Unknown::Rotation(u) => omega += u * z,
                    Unknown::Lean(u) => lean += u * z,
                    Unknown::Tilt(k, u) => tilt[*k] += u * z,
                    Unknown::Spurious(k, c) => e[*k] += c * z,
                    Unknown::Factor(Some(j), c) => factor[*j] += c * z,
                    Unknown::Factor(None, c) => factor.iter_mut().for_each(|f| *f += c * z),
                    Unknown::Additive(j, c) => added[*j] += c * z,
                }
            }
            let (sa, ca) = plus(row.angles[0], alpha);
            let (sw, cw) = plus(row.angles[1], omega);
            let m = [
                [ca * cw, -sw, sa * cw],
                [ca * sw, cw, sa * sw],
                [-sa, 0.0, ca],
            ];
            let leant = leaning(lean, e);
            let device = tilted(tilt);
            let moved = turned(&m, leant);
            let d = turned(&device, moved);
            let plain: [Complex64; 3] =
                std::array::from_fn(|j| d[0] * s[0][j] + d[1] * s[1][j] + d[2] * s[2][j]);
            let mut r = [0.0; 6];
            for j in 0..3 {
                let residual = y[j] - plain[j] * factor[j] - added[j];
                (r[2 * j], r[2 * j + 1]) = (residual.re, residual.im);
            }
            // N⁻¹ r as three complex numbers: the inner product with a column c is Re Σ conj(c_j) w_j.
            let w: [Complex64; 3] = std::array::from_fn(|j| {
                let dot = |a: usize| (0..6).map(|k| row.weight[a][k] * r[k]).sum::<f64>();
                Complex64::new(dot(2 * j), dot(2 * j + 1))
            });
            sum += (0..3)
                .map(|j| r[2 * j] * w[j].re + r[2 * j + 1] * w[j].im)
                .sum::<f64>();
            let along = |c: [Complex64; 3]| -> f64 {
                (0..3).map(|j| c[j].re * w[j].re + c[j].im * w[j].im).sum()
            };
            // The same inner product for a change of d, of what is moved, and of what has leant: carried back once for all unknowns.
            let of_d: [Complex64; 3] =
                std::array::from_fn(|i| (0..3).map(|j| s[i][j] * factor[j] * w[j].conj()).sum());
            let of_moved = turned(&transposed(&device), of_d);
            let of_leant = turned(&transposed(&m), of_moved);
            let inner = |a: &[Complex64; 3], b: &[Complex64; 3]| -> f64 {
                (0..3).map(|i| a[i].re * b[i].re - a[i].im * b[i].im).sum()
            };
            for i in 0..3 {
                for j in 0..3 {
                    let c = d[i] * factor[j];
                    let k = p + 2 * (3 * i + j);
                    gradient[k] += c.re * w[j].re + c.im * w[j].im;
                    gradient[k + 1] += c.re * w[j].im - c.im * w[j].re;
                }
            }
            for (index, unknown) in &row.unknowns {
                gradient[*index] += match unknown {
                    Unknown::Inclination(u) => {
                        let across = leant[2] * ca - leant[0] * sa;
                        let down = -leant[0] * ca - leant[2] * sa;
                        u * inner(&[across * cw, across * sw, down], &of_moved)
                    }
                    Unknown::Rotation(u) => u * inner(&[-moved[1], moved[0], zero], &of_moved),
                    // Q′ e = (0, e_z, −e_y) of what has leant already.
                    Unknown::Lean(u) => u * inner(&[zero, leant[2], -leant[1]], &of_leant),
                    Unknown::Tilt(0, u) => u * inner(&[zero, d[2], -d[1]], &of_d),
                    Unknown::Tilt(_, u) => u * inner(&[-d[2], zero, d[0]], &of_d),
                    Unknown::Spurious(k, c) => {
                        let mut t = [zero; 3];
                        t[*k] = *c;
                        inner(&leaning(lean, t), &of_leant)
                    }
                    Unknown::Factor(Some(j), c) => {
                        let v = plain[*j] * c;
                        v.re * w[*j].re + v.im * w[*j].im
                    }
                    Unknown::Factor(None, c) => along(plain.map(|v| v * c)),
                    Unknown::Additive(j, c) => c.re * w[*j].re + c.im * w[*j].im,
                };
            }
        }
        sum
    }
}

fn transposed(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}
