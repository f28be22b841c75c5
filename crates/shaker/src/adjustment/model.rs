//! How the errors of the bench reach the six reals of a run.

use super::{Column, Draw, Linear};
use crate::budget::{Acts, Budget, Key, ShakerInput};
use crate::geometry::Seat;
use crate::matrix::{Matrix, from_real, row_times};
use crate::observation::{Basis, PhasorRow, Share, SpuriousTable, sessions};
use faer::Mat;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::algebra::{hermitian_eigenvalues, solve_complex};

pub(super) struct Model<'a> {
    pub(super) rows: &'a [PhasorRow],
    pub(super) of_row: &'a [usize],
    pub(super) spurious: &'a SpuriousTable,
    pub(super) budget: &'a Budget,
    pub(super) scale: f64,
    pub(super) offset: usize,
}

/// A shared draw as one row has it.
#[derive(Clone, Copy)]
pub(crate) struct Link {
    pub(crate) draw: usize,
    pub(crate) input: Option<usize>,
    /// Output channel, or component of the spurious ratios (2 k + part).
    pub(crate) part: usize,
    /// What the component of a spurious ratio is common to.
    pub(crate) share: Share,
}

impl Model<'_> {
    /// Which draws every row has, and all draws: one per distinct value of the keys.
    pub(super) fn draws(&self) -> (Vec<Vec<Link>>, Vec<Draw>) {
        let mut links: Vec<Vec<Link>> = vec![vec![]; self.rows.len()];
        let mut draws: Vec<Draw> = vec![];
        let mut known: std::collections::HashMap<Vec<i64>, usize> = Default::default();
        let mut link = |row: usize,
                        input: Option<usize>,
                        part: usize,
                        frequency,
                        share: Option<Share>,
                        value: Vec<i64>| {
            let draw = *known.entry(value).or_insert_with(|| {
                draws.push(Draw {
                    input,
                    row,
                    part,
                    frequency,
                    share,
                });
                draws.len() - 1
            });
            let share = share.unwrap_or(Share::Own);
            links[row].push(Link {
                draw,
                input,
                part,
                share,
            });
        };
        let sessions = sessions(self.rows);
        // Angles to a microradian, rotations modulo a turn: what a plan calls the same.
        let angle = |a: f64| (a.rem_euclid(std::f64::consts::TAU) * 1e6).round() as i64 % 6_283_185;
        for (i, row) in self.rows.iter().enumerate() {
            let f = self.of_row[i];
            for (index, input) in self.budget.inputs.iter().enumerate() {
                if input.within_a_run() || input.standard_uncertainty() == 0.0 {
                    continue;
                }
                let tilt = input.acts == Acts::Tilt;
                for part in input.on_parts() {
                    let mut value = vec![index as i64];
                    for key in &input.varies_with {
                        value.push(match key {
                            Key::Frequency => f as i64,
                            Key::Inclination => angle(row.configuration.inclination),
                            Key::Rotation => angle(row.configuration.rotation),
                            Key::Channel => part as i64,
                            Key::Run => i as i64,
                            Key::Session => {
                                let name = row.session.as_deref();
                                let place = sessions.iter().position(|s| Some(*s) == name);
                                place.map_or(-1, |k| k as i64)
                            }
                        });
                    }
                    if tilt {
                        value.push(-2 - part as i64);
                    }
                    let frequency = (!input.shared_by_frequencies()).then_some(f);
                    link(i, Some(index), part, frequency, None, value.clone());
                    if input.acts == Acts::OutputAdditive {
                        // Imaginary part: a second draw.
                        value.push(-1);
                        link(i, Some(index), part + 3, frequency, None, value);
                    }
                }
            }
            if let Some(s) = self
                .spurious
                .get(row.configuration.inclination, row.frequency)
            {
                for part in 0..6 {
                    let unmeasured = s.basis[part / 2] != Basis::Measured;
                    for share in Share::ALL {
                        if self.spurious.step(s, share, part) == Complex64::new(0.0, 0.0)
                            || !unmeasured && share != Share::Own
                        {
                            continue;
                        }
                        let mut value = vec![-1 - share as i64, part as i64];
                        value.extend(share.varies_with().iter().map(|key| match key {
                            Key::Frequency => f as i64,
                            _ => angle(row.configuration.inclination),
                        }));
                        let frequency = share.varies_with().contains(&Key::Frequency).then_some(f);
                        link(i, None, part, frequency, unmeasured.then_some(share), value);
                    }
                }
            }
        }
        (links, draws)
    }

    /// Ordinary least squares at the drawn angles.
    pub(super) fn start(&self, parameters: &mut [f64], frequencies: usize) -> Result<(), Error> {
        for f in 0..frequencies {
            let rows: Vec<usize> = (0..self.rows.len())
                .filter(|&i| self.of_row[i] == f)
                .collect();
            let d: Vec<[Complex64; 3]> = rows
                .iter()
                .map(|&i| {
                    direction(
                        &self.excitation(i, &[], &[]),
                        &self.rows[i].configuration.matrix(),
                    )
                })
                .collect();
            let mut gram = Mat::<Complex64>::zeros(3, 3);
            let mut right = Mat::<Complex64>::zeros(3, 3);
            for (d, &i) in d.iter().zip(&rows) {
                let y = self.rows[i].ratios();
                for a in 0..3 {
                    for b in 0..3 {
                        gram[(a, b)] += d[a].conj() * d[b];
                        right[(a, b)] += d[a].conj() * y[b] / self.scale;
                    }
                }
            }
            let eigen = hermitian_eigenvalues(&gram, "eigenvalues of the plan")?;
            let condition = (eigen[2] / eigen[0]).abs().sqrt();
            if !(condition < 1e6) {
                return Err(Error::Unobservable {
                    parameter: "sensitivity",
                    condition,
                });
            }
            let solution = solve_complex(&gram, &right);
            for k in 0..9 {
                let s = solution[(k / 3, k % 3)];
                parameters[18 * f + 2 * k] = s.re;
                parameters[18 * f + 2 * k + 1] = s.im;
            }
        }
        Ok(())
    }

    /// Motion of the seat over that of the table where the adjustment now has it.
    fn excitation(&self, row: usize, links: &[Link], parameters: &[f64]) -> [Complex64; 3] {
        let row = &self.rows[row];
        let entry = self
            .spurious
            .get(row.configuration.inclination, row.frequency);
        let mut e = [
            Complex64::new(0.0, 0.0),
            Complex64::new(0.0, 0.0),
            Complex64::new(1.0, 0.0),
        ];
        if let Some(entry) = entry {
            for (e, ratio) in e.iter_mut().zip(entry.ratio) {
                *e += ratio;
            }
            for link in links.iter().filter(|l| l.input.is_none()) {
                let step = self.spurious.step(entry, link.share, link.part);
                e[link.part / 2] += step * parameters[self.offset + link.draw];
            }
        }
        e
    }

    /// The angles of a row where the adjustment now has them.
    fn seat(&self, i: usize, links: &[Link], parameters: &[f64]) -> Seat {
        let mut seat = Seat::drawn(self.rows[i].configuration);
        for link in links {
            let Some(input) = link.input.map(|k| &self.budget.inputs[k]) else {
                continue;
            };
            let angle = parameters[self.offset + link.draw] * input.standard_uncertainty();
            match input.acts {
                Acts::Inclination => seat.configuration.inclination += angle,
                Acts::Rotation => seat.configuration.rotation += angle,
                Acts::Lean => seat.lean += angle,
                Acts::Tilt => seat.tilt[link.part] += angle,
                _ => {}
            }
        }
        seat
    }

    /// Derivative of a row by an angle, or by the gain of the reference, of standard deviation `u`, at the current point.
    pub(super) fn error_column(
        &self,
        i: usize,
        links: &[Link],
        parameters: &[f64],
        acts: Acts,
        part: usize,
        u: f64,
    ) -> [f64; 6] {
        let f = self.of_row[i];
        let s = from_real(&parameters[18 * f..18 * f + 18]);
        let (seat, e) = (
            self.seat(i, links, parameters),
            self.excitation(i, links, parameters),
        );
        let turned = match acts {
            Acts::ReferenceModulus => seat.matrix(),
            angle => seat.derivative(angle, part),
        };
        real(row_times(direction(&e, &turned), &s), u)
    }

    pub(super) fn linear(&self, i: usize, links: &[Link], parameters: &[f64]) -> Linear {
        let (row, f) = (&self.rows[i], self.of_row[i]);
        let s = from_real(&parameters[18 * f..18 * f + 18]);
        let z = |link: &Link| parameters[self.offset + link.draw];
        let input = |link: &Link| link.input.map(|k| &self.budget.inputs[k]);
        let seat = self.seat(i, links, parameters);
        let (r, e) = (seat.matrix(), self.excitation(i, links, parameters));
        let d = direction(&e, &r);
        let prediction = row_times(d, &s);
        let y = row.nearest(&prediction);
        let mut residual = [0.0; 6];
        for j in 0..3 {
            let e = y[j] / self.scale - prediction[j];
            (residual[2 * j], residual[2 * j + 1]) = (e.re, e.im);
        }
        let mut columns: Vec<Column> = Vec::with_capacity(18 + links.len());
        for a in 0..3 {
            for j in 0..3 {
                let p = 18 * f + 2 * (3 * a + j);
                let (mut re, mut im) = ([0.0; 6], [0.0; 6]);
                (re[2 * j], re[2 * j + 1]) = (d[a].re, d[a].im);
                (im[2 * j], im[2 * j + 1]) = (-d[a].im, d[a].re);
                columns.push((p, re));
                columns.push((p + 1, im));
            }
        }
        for link in links {
            let column = match input(link) {
                Some(k) if k.acts.is_angle() => {
                    let d = direction(&e, &seat.derivative(k.acts, link.part));
                    real(row_times(d, &s), k.standard_uncertainty())
                }
                Some(k) => column(k, link.part, row, &prediction, self.scale),
                None => self.spurious_column(i, link, &r, &s),
            };
            // Angles and the motion of the seat already moved the prediction; the other draws act linearly.
            let moved = input(link).is_none_or(|k| k.acts.is_angle());
            if !moved {
                for (e, c) in residual.iter_mut().zip(&column) {
                    *e -= c * z(link);
                }
            }
            columns.push((self.offset + link.draw, column));
        }
        let mut noise = phasor_noise(row, &prediction, self.scale);
        for input in self.budget.inputs.iter().filter(|k| k.within_a_run()) {
            for c in run_columns(input, row, &prediction, self.scale) {
                for a in 0..6 {
                    for b in 0..6 {
                        noise[a][b] += c[a] * c[b];
                    }
                }
            }
        }
        Linear {
            prediction,
            residual,
            columns,
            noise,
        }
    }

    /// Derivative of a row by one component of its spurious ratios, through the Cholesky factor of each ratio.
    fn spurious_column(&self, i: usize, link: &Link, r: &[[f64; 3]; 3], s: &Matrix) -> [f64; 6] {
        let row = &self.rows[i];
        let Some(entry) = self
            .spurious
            .get(row.configuration.inclination, row.frequency)
        else {
            return [0.0; 6];
        };
        let draw = self.spurious.step(entry, link.share, link.part);
        let k = link.part / 2;
        let d = std::array::from_fn(|axis| draw * r[axis][k]);
        real(row_times(d, s), 1.0)
    }
}

/// R e for a rotation matrix (or a derivative of one).
fn direction(e: &[Complex64; 3], r: &[[f64; 3]; 3]) -> [Complex64; 3] {
    std::array::from_fn(|i| (0..3).map(|k| e[k] * r[i][k]).sum())
}

/// How one draw (standard deviation one) of an input that is not an angle acts on a row.
fn column(
    input: &ShakerInput,
    part: usize,
    row: &PhasorRow,
    y: &[Complex64; 3],
    scale: f64,
) -> [f64; 6] {
    let j = Complex64::new(0.0, 1.0);
    let u = input.standard_uncertainty_at(row.frequency);
    let channel = part % 3;
    let only = |v: Complex64| -> [Complex64; 3] {
        std::array::from_fn(|k| {
            if k == channel {
                v
            } else {
                Complex64::new(0.0, 0.0)
            }
        })
    };
    let values = match input.acts {
        Acts::ReferenceModulus => y.map(|y| -y),
        Acts::ReferencePhase => y.map(|y| -j * y),
        Acts::OutputModulus => only(y[channel]),
        Acts::OutputPhase => only(j * y[channel]),
        Acts::OutputAdditive => {
            let unit = if part >= 3 {
                j
            } else {
                Complex64::new(1.0, 0.0)
            };
            only(unit / (row.reference * scale))
        }
        Acts::Inclination | Acts::Rotation | Acts::Lean | Acts::Tilt => {
            [Complex64::new(0.0, 0.0); 3]
        }
    };
    real(values, u)
}

/// All independent draws of an input that belong to one run alone.
pub(super) fn run_columns(
    input: &ShakerInput,
    row: &PhasorRow,
    y: &[Complex64; 3],
    scale: f64,
) -> Vec<[f64; 6]> {
    let per_output = input.acts.on_one_output();
    let parts: usize = match (per_output, input.acts) {
        (true, Acts::OutputAdditive) => 6,
        (true, _) => 3,
        (false, _) => 1,
    };
    let has = |p: &usize| !per_output || input.output.is_none_or(|k| p % 3 == k);
    let columns: Vec<[f64; 6]> = (0..parts)
        .filter(has)
        .map(|p| column(input, p, row, y, scale))
        .collect();
    if per_output && input.output.is_none() && !input.varies_with.contains(&Key::Channel) {
        // One draw for the three outputs together (and one for each part).
        return columns
            .chunks(3)
            .map(|c| std::array::from_fn(|a| c.iter().map(|v| v[a]).sum()))
            .collect();
    }
    columns
}

/// Covariance of the six reals of a row from the sine approximations: outputs apart, the reference in common.
pub(super) fn phasor_noise(row: &PhasorRow, y: &[Complex64; 3], scale: f64) -> [[f64; 6]; 6] {
    let mut noise = [[0.0; 6]; 6];
    for (a, n) in noise.iter_mut().enumerate() {
        // A purely relative budget gives infinite weight to an output that passes through zero: one part per
        // million of the typical output is always there.
        n[a] = 1e-12;
    }
    let gain = 1.0 / (row.reference * scale);
    let mut add = |g: [Complex64; 3], [rr, ri, ii]: [f64; 3]| {
        // Columns for the real and the imaginary error: g and j g.
        let (a, b) = (
            real(g, 1.0),
            real(g.map(|g| g * Complex64::new(0.0, 1.0)), 1.0),
        );
        for p in 0..6 {
            for q in 0..6 {
                noise[p][q] +=
                    rr * a[p] * a[q] + ri * (a[p] * b[q] + b[p] * a[q]) + ii * b[p] * b[q];
            }
        }
    };
    for j in 0..3 {
        let g = std::array::from_fn(|k| {
            if k == j {
                gain
            } else {
                Complex64::new(0.0, 0.0)
            }
        });
        add(g, row.covariance[j + 1]);
    }
    add(y.map(|y| -y / row.reference), row.covariance[0]);
    for unknown in row.unknown(y) {
        let turn = real(unknown, 1.0);
        for p in 0..6 {
            for q in 0..6 {
                noise[p][q] += turn[p] * turn[q];
            }
        }
    }
    noise
}

fn real(v: [Complex64; 3], u: f64) -> [f64; 6] {
    std::array::from_fn(|k| u * if k % 2 == 0 { v[k / 2].re } else { v[k / 2].im })
}
