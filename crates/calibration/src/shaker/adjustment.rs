//! The one engine behind both rigorous methods: a least-squares adjustment in which every shared error is an
//! unknown with its prior.
//!
//! Observations y = o/a (complex, three per run) obey y = \[R(α + δα, ω + δω) e\]ᵀ S with e = (ε_x, ε_y, 1 + ε_z).
//! An error that several runs share is one unknown z ~ N(0, 1) per draw; errors within a run make its 6 × 6
//! weight. Minimising r ᵀN⁻¹r + zᵀz over S and z is generalised least squares with the joint covariance
//! V = N + G Gᵀ, without ever forming V; and because the angles are unknowns, it can be solved with the angles
//! where they are (errors in variables) and not where the drawing has them.

use super::budget::{Acts, Budget, Input, Key};
use super::matrix::{Matrix, from_real, row_times};
use super::observation::{PhasorRow, SpuriousTable};
use faer::{Mat, Side, c64, linalg::solvers::Solve};
use proofmass_core::Error;

/// One shared error: its input and the draw.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Draw {
    /// Index of the input in the budget; `None` for the components of a spurious ratio.
    pub(crate) input: Option<usize>,
    /// First row that has it, for messages.
    pub(crate) row: usize,
    /// Frequency it belongs to; `None` when shared by all.
    pub(crate) frequency: Option<usize>,
}

/// Derivative of the six reals of one row by one parameter.
type Column = (usize, [f64; 6]);

/// A row at the current point of the iteration.
struct Linear {
    residual: [f64; 6],
    columns: Vec<Column>,
    noise: [[f64; 6]; 6],
}

/// The solved adjustment. Parameters: 18 reals of S per frequency (in units of `scale`), then the draws.
pub(crate) struct Adjustment {
    pub(crate) frequencies: Vec<f64>,
    /// Frequency index of every row.
    pub(crate) of_row: Vec<usize>,
    /// Unit of y, V/(m/s²).
    pub(crate) scale: f64,
    pub(crate) parameters: Vec<f64>,
    /// Covariance of the parameters, row-major.
    covariance: Vec<f64>,
    pub(crate) draws: Vec<Draw>,
    pub(crate) chi_squared: f64,
    rows: Vec<Linear>,
    /// N⁻¹ of every row.
    weights: Vec<[[f64; 6]; 6]>,
}

/// What leaving one run out would say about it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Deletion {
    /// Measured minus predicted by all other runs, V/(m/s²).
    pub(crate) prediction_error: [c64; 3],
    /// (prediction error)ᵀ (its covariance)⁻¹ (prediction error): χ² with six degrees of freedom.
    pub(crate) statistic: f64,
    /// The covariance of the prediction error, in units of `scale`².
    pub(crate) covariance: [[f64; 6]; 6],
    /// Change of the 18 reals of S of its frequency when the run is left out, V/(m/s²).
    pub(crate) influence: Vec<f64>,
}

const ITERATIONS: usize = 60;
/// Iterations in which the noise of the runs is evaluated anew.
const REWEIGHTED: usize = 5;

impl Adjustment {
    pub(crate) fn new(
        rows: &[PhasorRow],
        spurious: &SpuriousTable,
        budget: &Budget,
    ) -> Result<Self, Error> {
        for (index, row) in rows.iter().enumerate() {
            row.check(index)?;
        }
        let mut frequencies: Vec<f64> = rows.iter().map(|r| r.frequency).collect();
        frequencies.sort_by(f64::total_cmp);
        frequencies.dedup();
        let of_row: Vec<usize> = rows
            .iter()
            .map(|r| frequencies.partition_point(|&f| f < r.frequency))
            .collect();
        for f in 0..frequencies.len() {
            let got = of_row.iter().filter(|&&k| k == f).count();
            if got < 3 {
                return Err(Error::TooFew {
                    name: "configurations at a frequency",
                    needed: 3,
                    got,
                });
            }
        }
        let mean_square = rows
            .iter()
            .flat_map(|r| r.ratios())
            .map(|y| y.norm_sqr())
            .sum::<f64>()
            / rows.len() as f64;
        let scale = if mean_square > 0.0 {
            mean_square.sqrt()
        } else {
            1.0
        };
        let model = Model {
            rows,
            of_row: &of_row,
            spurious,
            budget,
            scale,
            offset: 18 * frequencies.len(),
        };
        let (links, draws) = model.draws();
        let count = model.offset + draws.len();
        let mut parameters = vec![0.0; count];
        model.start(&mut parameters, frequencies.len())?;
        let objective = |linear: &[Linear], weights: &[[[f64; 6]; 6]], z: &[f64]| -> f64 {
            let rows: f64 = linear
                .iter()
                .zip(weights)
                .map(|(l, w)| dot(&times(w, &l.residual), &l.residual))
                .sum();
            rows + z.iter().map(|z| z * z).sum::<f64>()
        };
        let linearise = |parameters: &[f64]| -> Vec<Linear> {
            (0..rows.len())
                .map(|i| model.linear(i, &links[i], parameters))
                .collect()
        };
        let mut step = f64::INFINITY;
        let mut linear = linearise(&parameters);
        let mut weights = weights_of(&linear)?;
        for iteration in 0..ITERATIONS {
            if iteration > 0 && iteration < REWEIGHTED {
                // Relative noise follows the prediction; once it is near, it stays, so that the end is a minimum.
                weights = weights_of(&linear)?;
            }
            let before = objective(&linear, &weights, &parameters[model.offset..]);
            let mut normal = vec![0.0; count * count];
            let mut right = vec![0.0; count];
            for (row, w) in linear.iter().zip(&weights) {
                let weighted: Vec<[f64; 6]> =
                    row.columns.iter().map(|(_, c)| times(w, c)).collect();
                for (a, (i, _)) in row.columns.iter().enumerate() {
                    right[*i] += dot(&weighted[a], &row.residual);
                    for (j, column) in &row.columns {
                        if j <= i {
                            normal[i * count + j] += dot(&weighted[a], column);
                        }
                    }
                }
            }
            for i in model.offset..count {
                normal[i * count + i] += 1.0;
                right[i] -= parameters[i];
            }
            let normal = Mat::from_fn(count, count, |i, j| normal[i.max(j) * count + i.min(j)]);
            let llt = normal.llt(Side::Lower).map_err(|_| Error::Unobservable {
                parameter: "sensitivity",
                condition: f64::INFINITY,
            })?;
            if step < 1e-6 {
                // The last step was rounding: this is the point at which everything is reported.
                let chi_squared = before;
                let inverse = llt.solve(Mat::<f64>::identity(count, count));
                let covariance = (0..count * count)
                    .map(|k| {
                        0.5 * (inverse[(k / count, k % count)] + inverse[(k % count, k / count)])
                    })
                    .collect();
                return Ok(Self {
                    frequencies,
                    of_row,
                    scale,
                    parameters,
                    covariance,
                    draws,
                    chi_squared,
                    rows: linear,
                    weights,
                });
            }
            let delta = llt.solve(Mat::from_fn(count, 1, |i, _| right[i]));
            // Shorter steps while the sum of squares rises: runs that contradict each other turn the angles far.
            let mut length = 1.0;
            let (next, trial) = loop {
                let trial: Vec<f64> = (0..count)
                    .map(|i| parameters[i] + length * delta[(i, 0)])
                    .collect();
                let next = linearise(&trial);
                let after = objective(&next, &weights, &trial[model.offset..]);
                if after <= before * (1.0 + 1e-9) + 1e-9 || length < 1e-3 {
                    break (next, trial);
                }
                length *= 0.5;
            };
            step = (0..count)
                .map(|i| {
                    // Sensitivities against the unit of y, draws against a thousand of their priors.
                    let unit = if i < model.offset { 1.0 } else { 1e3 };
                    length * delta[(i, 0)].abs() / unit
                })
                .fold(0.0, f64::max);
            (linear, parameters) = (next, trial);
            if !step.is_finite() {
                break;
            }
        }
        Err(Error::NotConverged {
            name: "adjustment of the sensitivity matrix",
            iterations: ITERATIONS,
            step,
        })
    }

    /// The sensitivity matrix of a frequency in V/(m/s²).
    pub(crate) fn sensitivity(&self, f: usize) -> Matrix {
        from_real(&self.parameters[18 * f..18 * f + 18]).map(|row| row.map(|s| s * self.scale))
    }

    /// Covariance of two parameters.
    pub(crate) fn covariance(&self, i: usize, j: usize) -> f64 {
        self.covariance[i * self.parameters.len() + j]
    }

    /// Degrees of freedom of χ²: 6 per run less 18 per frequency.
    pub(crate) fn dof(&self) -> usize {
        6 * self.rows.len() - 18 * self.frequencies.len()
    }

    /// Gain of the estimator from the six reals of a row to the 18 of S of a frequency: C_s· Xᵀ N⁻¹.
    pub(crate) fn gain(&self, f: usize, row: usize) -> [[f64; 6]; 18] {
        let mut gain = [[0.0; 6]; 18];
        for (j, column) in &self.rows[row].columns {
            let w = times(&self.weights[row], column);
            for (p, g) in gain.iter_mut().enumerate() {
                let c = self.covariance(18 * f + p, *j);
                for k in 0..6 {
                    g[k] += c * w[k];
                }
            }
        }
        gain
    }

    /// Covariance of S of a frequency, V²/(m/s²)², caused by each input of the budget; then by the noise of the
    /// phasors, then by the spurious ratios. They sum to the covariance of the adjustment.
    pub(crate) fn contributions(
        &self,
        f: usize,
        rows: &[PhasorRow],
        budget: &Budget,
    ) -> Vec<Vec<f64>> {
        let inputs = budget.inputs.len();
        let mut sums = vec![vec![0.0; 18 * 18]; inputs + 2];
        let scale2 = self.scale * self.scale;
        let add = |sum: &mut [f64], v: &[f64; 18]| {
            for p in 0..18 {
                for q in 0..18 {
                    sum[18 * p + q] += scale2 * v[p] * v[q];
                }
            }
        };
        // How every shared draw appears in S: Σ over the rows that have it.
        let offset = 18 * self.frequencies.len();
        let mut shared = vec![[0.0; 18]; self.draws.len()];
        for row in 0..self.rows.len() {
            let gain = self.gain(f, row);
            for (j, column) in self.rows[row].columns.iter().filter(|(j, _)| *j >= offset) {
                for p in 0..18 {
                    shared[j - offset][p] += dot6(&gain[p], column);
                }
            }
            let prediction = self.prediction(row, rows);
            for (index, input) in budget.inputs.iter().enumerate() {
                if input.within_a_run() {
                    for column in run_columns(input, &rows[row], &prediction, self.scale) {
                        add(&mut sums[index], &gain.map(|g| dot6(&g, &column)));
                    }
                }
            }
            // Noise of the phasors: the rest of the 6 × 6 weight, as its own covariance.
            let noise = phasor_noise(&rows[row], &prediction, self.scale);
            for p in 0..18 {
                let half: [f64; 6] =
                    std::array::from_fn(|k| (0..6).map(|l| gain[p][l] * noise[l][k]).sum());
                for q in 0..18 {
                    sums[inputs][18 * p + q] += scale2 * dot6(&gain[q], &half);
                }
            }
        }
        for (draw, v) in self.draws.iter().zip(&shared) {
            add(&mut sums[draw.input.unwrap_or(inputs + 1)], v);
        }
        sums
    }

    fn prediction(&self, row: usize, rows: &[PhasorRow]) -> [c64; 3] {
        let y = rows[row].ratios();
        let r = &self.rows[row].residual;
        std::array::from_fn(|j| y[j] / self.scale - c64::new(r[2 * j], r[2 * j + 1]))
    }

    /// What every run looks like from all the others.
    pub(crate) fn deletions(&self) -> Result<Vec<Deletion>, Error> {
        (0..self.rows.len())
            .map(|row| {
                let (linear, w) = (&self.rows[row], &self.weights[row]);
                // Q = N⁻¹ − N⁻¹ X C Xᵀ N⁻¹; its inverse is the covariance of the prediction error.
                let weighted: Vec<(usize, [f64; 6])> = linear
                    .columns
                    .iter()
                    .map(|(j, c)| (*j, times(w, c)))
                    .collect();
                let mut q = *w;
                for (i, u) in &weighted {
                    let mut half = [0.0; 6];
                    for (j, v) in &weighted {
                        let c = self.covariance(*i, *j);
                        for b in 0..6 {
                            half[b] += c * v[b];
                        }
                    }
                    for a in 0..6 {
                        for b in 0..6 {
                            q[a][b] -= u[a] * half[b];
                        }
                    }
                }
                let q = Mat::from_fn(6, 6, |a, b| q[a][b]);
                let right = times(w, &linear.residual);
                let right = Mat::from_fn(6, 1, |a, _| right[a]);
                let llt = q.llt(Side::Lower).map_err(|_| Error::Unobservable {
                    parameter: "sensitivity without one of the runs",
                    condition: f64::INFINITY,
                })?;
                let error = llt.solve(&right);
                let covariance = llt.solve(Mat::<f64>::identity(6, 6));
                let statistic = (0..6).map(|a| error[(a, 0)] * right[(a, 0)]).sum();
                let gain = self.gain(self.of_row[row], row);
                Ok(Deletion {
                    prediction_error: std::array::from_fn(|j| {
                        c64::new(error[(2 * j, 0)], error[(2 * j + 1, 0)]) * self.scale
                    }),
                    statistic,
                    covariance: std::array::from_fn(|a| {
                        std::array::from_fn(|b| covariance[(a, b)])
                    }),
                    influence: gain
                        .iter()
                        .map(|g| -self.scale * (0..6).map(|a| g[a] * error[(a, 0)]).sum::<f64>())
                        .collect(),
                })
            })
            .collect()
    }
}

struct Model<'a> {
    rows: &'a [PhasorRow],
    of_row: &'a [usize],
    spurious: &'a SpuriousTable,
    budget: &'a Budget,
    scale: f64,
    offset: usize,
}

/// A shared draw as one row has it.
#[derive(Clone, Copy)]
struct Link {
    draw: usize,
    input: Option<usize>,
    /// Output channel, or component of the spurious ratios (2 k + part).
    part: usize,
}

impl Model<'_> {
    /// Which draws every row has, and all draws: one per distinct value of the keys.
    fn draws(&self) -> (Vec<Vec<Link>>, Vec<Draw>) {
        let mut links: Vec<Vec<Link>> = vec![vec![]; self.rows.len()];
        let mut draws: Vec<Draw> = vec![];
        let mut known: std::collections::HashMap<Vec<i64>, usize> = Default::default();
        let mut link =
            |row: usize, input: Option<usize>, part: usize, frequency, value: Vec<i64>| {
                let draw = *known.entry(value).or_insert_with(|| {
                    draws.push(Draw {
                        input,
                        row,
                        frequency,
                    });
                    draws.len() - 1
                });
                links[row].push(Link { draw, input, part });
            };
        // Angles to a microradian, rotations modulo a turn: what a plan calls the same.
        let angle = |a: f64| (a.rem_euclid(std::f64::consts::TAU) * 1e6).round() as i64 % 6_283_185;
        for (i, row) in self.rows.iter().enumerate() {
            let f = self.of_row[i];
            for (index, input) in self.budget.inputs.iter().enumerate() {
                if input.within_a_run() || input.standard_uncertainty == 0.0 {
                    continue;
                }
                let parts = if input.acts.on_one_output() { 3 } else { 1 };
                for part in 0..parts {
                    let mut value = vec![index as i64];
                    for key in &input.varies_with {
                        value.push(match key {
                            Key::Frequency => f as i64,
                            Key::Inclination => angle(row.configuration.inclination),
                            Key::Rotation => angle(row.configuration.rotation),
                            Key::Channel => part as i64,
                            Key::Run => i as i64,
                        });
                    }
                    let frequency = (!input.shared_by_frequencies()).then_some(f);
                    link(i, Some(index), part, frequency, value.clone());
                    if input.acts == Acts::OutputAdditive {
                        // Imaginary part: a second draw.
                        value.push(-1);
                        link(i, Some(index), part + 3, frequency, value);
                    }
                }
            }
            if let Some(s) = self
                .spurious
                .get(row.configuration.inclination, row.frequency)
            {
                for part in 0..6 {
                    if s.covariance[part / 2] != [0.0; 3] {
                        let value = vec![
                            -1,
                            f as i64,
                            angle(row.configuration.inclination),
                            part as i64,
                        ];
                        link(i, None, part, Some(f), value);
                    }
                }
            }
        }
        (links, draws)
    }

    /// Ordinary least squares at the drawn angles.
    fn start(&self, parameters: &mut [f64], frequencies: usize) -> Result<(), Error> {
        for f in 0..frequencies {
            let rows: Vec<usize> = (0..self.rows.len())
                .filter(|&i| self.of_row[i] == f)
                .collect();
            let d: Vec<[c64; 3]> = rows
                .iter()
                .map(|&i| self.direction(i, &self.rows[i].configuration.matrix()))
                .collect();
            let mut gram = Mat::<c64>::zeros(3, 3);
            let mut right = Mat::<c64>::zeros(3, 3);
            for (d, &i) in d.iter().zip(&rows) {
                let y = self.rows[i].ratios();
                for a in 0..3 {
                    for b in 0..3 {
                        gram[(a, b)] += d[a].conj() * d[b];
                        right[(a, b)] += d[a].conj() * y[b] / self.scale;
                    }
                }
            }
            let eigen =
                gram.self_adjoint_eigenvalues(Side::Lower)
                    .map_err(|_| Error::NotConverged {
                        name: "eigenvalues of the plan",
                        iterations: 0,
                        step: f64::INFINITY,
                    })?;
            let condition = (eigen[2] / eigen[0]).abs().sqrt();
            if !(condition < 1e6) {
                return Err(Error::Unobservable {
                    parameter: "sensitivity",
                    condition,
                });
            }
            let solution = gram.partial_piv_lu().solve(&right);
            for k in 0..9 {
                let s = solution[(k / 3, k % 3)];
                parameters[18 * f + 2 * k] = s.re;
                parameters[18 * f + 2 * k + 1] = s.im;
            }
        }
        Ok(())
    }

    /// R e for a rotation matrix (or a derivative of one).
    fn direction(&self, row: usize, r: &[[f64; 3]; 3]) -> [c64; 3] {
        let e = self.excitation(row);
        std::array::from_fn(|i| (0..3).map(|k| e[k] * r[i][k]).sum())
    }

    fn excitation(&self, row: usize) -> [c64; 3] {
        let row = &self.rows[row];
        let mut e = self
            .spurious
            .get(row.configuration.inclination, row.frequency)
            .map_or([c64::new(0.0, 0.0); 3], |s| s.ratio);
        e[2] += 1.0;
        e
    }

    fn linear(&self, i: usize, links: &[Link], parameters: &[f64]) -> Linear {
        let (row, f) = (&self.rows[i], self.of_row[i]);
        let s = from_real(&parameters[18 * f..18 * f + 18]);
        let z = |link: &Link| parameters[self.offset + link.draw];
        let input = |link: &Link| link.input.map(|k| &self.budget.inputs[k]);
        // The angles where the adjustment now has them.
        let mut configuration = row.configuration;
        for link in links {
            match input(link) {
                Some(k) if k.acts == Acts::Inclination => {
                    configuration.inclination += z(link) * k.standard_uncertainty;
                }
                Some(k) if k.acts == Acts::Rotation => {
                    configuration.rotation += z(link) * k.standard_uncertainty;
                }
                _ => {}
            }
        }
        let r = configuration.matrix();
        let d = self.direction(i, &r);
        let prediction = row_times(d, &s);
        let y = row.ratios();
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
                Some(k) if k.acts == Acts::Inclination => {
                    let d = self.direction(i, &configuration.inclination_derivative());
                    real(row_times(d, &s), k.standard_uncertainty)
                }
                Some(k) if k.acts == Acts::Rotation => {
                    let d = self.direction(i, &configuration.rotation_derivative());
                    real(row_times(d, &s), k.standard_uncertainty)
                }
                Some(k) => column(k, link.part, row, &prediction, self.scale),
                None => self.spurious_column(i, link.part, &r, &s),
            };
            // Angles already moved the prediction; the other draws act linearly.
            let moved = input(link).is_some_and(|k| k.acts.is_angle());
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
        for (a, n) in noise.iter_mut().enumerate() {
            // A purely relative budget gives infinite weight to an output that passes through zero: one part per
            // million of the typical output is always there.
            n[a] += 1e-12;
        }
        Linear {
            residual,
            columns,
            noise,
        }
    }

    /// Derivative of a row by one component of its spurious ratios, through the Cholesky factor of each ratio.
    fn spurious_column(&self, i: usize, part: usize, r: &[[f64; 3]; 3], s: &Matrix) -> [f64; 6] {
        let row = &self.rows[i];
        let Some(entry) = self
            .spurious
            .get(row.configuration.inclination, row.frequency)
        else {
            return [0.0; 6];
        };
        let (k, second) = (part / 2, part % 2 == 1);
        let [rr, ri, ii] = entry.covariance[k];
        let l11 = rr.max(0.0).sqrt();
        let l21 = if l11 > 0.0 { ri / l11 } else { 0.0 };
        let draw = if second {
            c64::new(0.0, (ii - l21 * l21).max(0.0).sqrt())
        } else {
            c64::new(l11, l21)
        };
        let d = std::array::from_fn(|axis| draw * r[axis][k]);
        real(row_times(d, s), 1.0)
    }
}

/// How one draw (standard deviation one) of an input that is not an angle acts on a row.
fn column(input: &Input, part: usize, row: &PhasorRow, y: &[c64; 3], scale: f64) -> [f64; 6] {
    let j = c64::new(0.0, 1.0);
    let u = input.standard_uncertainty;
    let channel = part % 3;
    let only = |v: c64| -> [c64; 3] {
        std::array::from_fn(|k| if k == channel { v } else { c64::new(0.0, 0.0) })
    };
    let values = match input.acts {
        Acts::ReferenceModulus => y.map(|y| -y),
        Acts::ReferencePhase => y.map(|y| -j * y),
        Acts::OutputModulus => only(y[channel]),
        Acts::OutputPhase => only(j * y[channel]),
        Acts::OutputAdditive => {
            let unit = if part >= 3 { j } else { c64::new(1.0, 0.0) };
            only(unit / (row.reference * scale))
        }
        Acts::Inclination | Acts::Rotation => [c64::new(0.0, 0.0); 3],
    };
    real(values, u)
}

/// All independent draws of an input that belong to one run alone.
fn run_columns(input: &Input, row: &PhasorRow, y: &[c64; 3], scale: f64) -> Vec<[f64; 6]> {
    let per_output = input.acts.on_one_output();
    let parts: usize = match (per_output, input.acts) {
        (true, Acts::OutputAdditive) => 6,
        (true, _) => 3,
        (false, _) => 1,
    };
    let columns: Vec<[f64; 6]> = (0..parts)
        .map(|p| column(input, p, row, y, scale))
        .collect();
    if per_output && !input.varies_with.contains(&Key::Channel) {
        // One draw for the three outputs together (and one for each part).
        return columns
            .chunks(3)
            .map(|c| std::array::from_fn(|a| c.iter().map(|v| v[a]).sum()))
            .collect();
    }
    columns
}

/// Covariance of the six reals of a row from the sine approximations: outputs apart, the reference in common.
fn phasor_noise(row: &PhasorRow, y: &[c64; 3], scale: f64) -> [[f64; 6]; 6] {
    let mut noise = [[0.0; 6]; 6];
    let gain = 1.0 / (row.reference * scale);
    let mut add = |g: [c64; 3], [rr, ri, ii]: [f64; 3]| {
        // Columns for the real and the imaginary error: g and j g.
        let (a, b) = (real(g, 1.0), real(g.map(|g| g * c64::new(0.0, 1.0)), 1.0));
        for p in 0..6 {
            for q in 0..6 {
                noise[p][q] +=
                    rr * a[p] * a[q] + ri * (a[p] * b[q] + b[p] * a[q]) + ii * b[p] * b[q];
            }
        }
    };
    for j in 0..3 {
        let g = std::array::from_fn(|k| if k == j { gain } else { c64::new(0.0, 0.0) });
        add(g, row.covariance[j + 1]);
    }
    add(y.map(|y| -y / row.reference), row.covariance[0]);
    noise
}

fn real(v: [c64; 3], u: f64) -> [f64; 6] {
    std::array::from_fn(|k| u * if k % 2 == 0 { v[k / 2].re } else { v[k / 2].im })
}

fn weights_of(rows: &[Linear]) -> Result<Vec<[[f64; 6]; 6]>, Error> {
    rows.iter()
        .enumerate()
        .map(|(index, row)| {
            let n = Mat::from_fn(6, 6, |a, b| row.noise[a][b]);
            let llt = n.llt(Side::Lower).map_err(|_| Error::NotPositiveDefinite {
                name: "covariance of a run",
                row: index,
                column: index,
                value: 0.0,
            })?;
            let w = llt.solve(Mat::<f64>::identity(6, 6));
            Ok(std::array::from_fn(|a| {
                std::array::from_fn(|b| 0.5 * (w[(a, b)] + w[(b, a)]))
            }))
        })
        .collect()
}

fn times(w: &[[f64; 6]; 6], v: &[f64; 6]) -> [f64; 6] {
    std::array::from_fn(|a| dot6(&w[a], v))
}

fn dot(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    dot6(a, b)
}

fn dot6(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    (0..6).map(|k| a[k] * b[k]).sum()
}
