//! The one engine behind both rigorous methods: a least-squares adjustment in which every shared error is an
//! unknown with its prior.
//!
//! Observations y = o/a (complex, three per run) obey y = \[R(α + δα, ω + δω) e\]ᵀ S with e = (ε_x, ε_y, 1 + ε_z).
//! An error that several runs share is one unknown z ~ N(0, 1) per draw; errors within a run make its 6 × 6
//! weight. Minimising r ᵀN⁻¹r + zᵀz over S and z is generalised least squares with the joint covariance
//! V = N + G Gᵀ, without ever forming V; and because the angles are unknowns, it can be solved with the angles
//! where they are (errors in variables) and not where the drawing has them.

mod components;
pub(crate) mod model;
mod parts;

pub(crate) use parts::Part;

use super::budget::{Acts, Budget, Key, ShakerInput};
use super::free_phase;
use super::matrix::{Matrix, from_real, to_real};
use super::observation::{OutputPhases, PhasorRow, Share, SpuriousTable, ascending};
use super::unread_phases;
use faer::Mat;
pub(crate) use model::Link;
use model::{Model, phasor_noise, run_columns};
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::adjustment::descend;
use proofmass_uncertainty::algebra::{cholesky, product};

/// One shared error: its input and the draw.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Draw {
    /// Index of the input in the budget; `None` for the components of a spurious ratio.
    pub(crate) input: Option<usize>,
    /// First row that has it, for messages.
    pub(crate) row: usize,
    /// Output channel, or axis of a tilt.
    pub(crate) part: usize,
    /// Frequency it belongs to; `None` when shared by all.
    pub(crate) frequency: Option<usize>,
    /// What it is common to, where it is motion of the bench that nobody measured.
    pub(crate) share: Option<Share>,
}

/// Derivative of the six reals of one row by one parameter.
type Column = (usize, [f64; 6]);

/// A row at the current point of the iteration.
struct Linear {
    /// y as S and the angles predict it, in units of `scale`.
    prediction: [Complex64; 3],
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
    /// Prediction of every row with which its N was evaluated.
    weighed: Vec<[Complex64; 3]>,
    /// N⁻¹ of every row.
    pub(crate) weights: Vec<[[f64; 6]; 6]>,
    /// Draws of every row.
    pub(crate) links: Vec<Vec<Link>>,
    /// How many reals every row tells.
    reals: Vec<f64>,
    /// Parameters that stay zero: imaginary parts of the terms that phases are counted from.
    real: Vec<usize>,
}

/// What one draw of a missing angle belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Group {
    /// A gluing: wedge and rotation.
    Configuration,
    /// A wedge.
    Inclination,
}

/// What the residuals say of an angle that is not in the budget.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Score {
    /// About χ² with `dof` degrees of freedom when there is no such error.
    pub(crate) statistic: f64,
    pub(crate) dof: f64,
    /// Estimate of its variance, rad²; negative where the residuals are smaller than expected.
    pub(crate) variance: f64,
}

/// Columns beside those of the model: GᵀN⁻¹r̂ and its information GᵀN⁻¹G − GᵀN⁻¹X C XᵀN⁻¹G.
pub(crate) struct Projected {
    pub(crate) seen: Vec<f64>,
    pub(crate) p: Mat<f64>,
    /// Largest of the diagonal of GᵀN⁻¹G: what is small beside it is rounding.
    pub(crate) largest: f64,
}

/// What leaving one run out would say about it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Deletion {
    /// Measured minus predicted by all other runs, V/(m/s²).
    pub(crate) prediction_error: [Complex64; 3],
    /// (prediction error)ᵀ (its covariance)⁻¹ (prediction error): χ² with six degrees of freedom.
    pub(crate) statistic: f64,
    /// The covariance of the prediction error, in units of `scale`².
    pub(crate) covariance: [[f64; 6]; 6],
    /// Change of the 18 reals of S of its frequency when the run is left out, V/(m/s²).
    pub(crate) influence: Vec<f64>,
}

/// Runs that contradict each other leave large residuals, with which every step gains only a share of the last one.
const ITERATIONS: usize = 150;
/// A step of 10⁻⁶ u ends the iteration, whatever it is in volts or radians.
const NEGLIGIBLE: f64 = 1e-12;
/// Iterations in which the noise of the runs is evaluated anew.
const REWEIGHTED: usize = 5;
/// Weight with which a term is kept real, in units of S: a millionth of it is all it may be off.
const REAL: f64 = 1e12;
/// What no run tells of a sensor with a clock of its own.
const UNTIED: &str = "phase between the axes of a sensor with a clock of its own: runs are needed that excite two axes together";
/// Standard uncertainty of a phase between two axes, rad, from which on nobody can tell it.
const UNTOLD: f64 = 0.2;

impl Adjustment {
    pub(crate) fn new(
        rows: &[PhasorRow],
        spurious: &SpuriousTable,
        budget: &Budget,
    ) -> Result<Self, Error> {
        for (index, row) in rows.iter().enumerate() {
            row.check(index)?;
        }
        let named = rows.iter().filter(|r| r.session.is_some()).count();
        let by_session = |i: &ShakerInput| i.varies_with.contains(&Key::Session);
        if named < rows.len() && budget.inputs.iter().any(by_session) {
            return Err(Error::TooFew {
                name: "runs that name their session, which an input of the budget varies with",
                needed: rows.len(),
                got: named,
            });
        }
        let turned;
        let rows = if rows.iter().any(PhasorRow::is_free) {
            if !free_phase::tied(rows, spurious) {
                return Err(Error::Unobservable {
                    parameter: UNTIED,
                    condition: f64::INFINITY,
                });
            }
            turned = free_phase::aligned(rows, spurious);
            turned.as_slice()
        } else {
            rows
        };
        let frequencies = ascending(rows.iter().map(|r| r.frequency));
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
        // A common phase of S is one with those of the runs: a main term is real, as nothing else can be known.
        let mut real: Vec<usize> = vec![];
        for f in 0..frequencies.len() {
            let here: Vec<&PhasorRow> = rows
                .iter()
                .zip(&of_row)
                .filter(|(_, of)| **of == f)
                .map(|(row, _)| row)
                .collect();
            if here.iter().any(|r| r.phases == OutputPhases::Unread) {
                unread_phases::determined(&here)?;
            }
            let s = &mut parameters[18 * f..18 * f + 18];
            let matrix = from_real(s);
            let terms = free_phase::real_terms(&here, &matrix);
            if let [origin] = terms.as_slice() {
                let z = Complex64::new(s[origin - 1], s[*origin]);
                let turn = z.conj() / z.norm().max(f64::MIN_POSITIVE);
                s.copy_from_slice(&to_real(&matrix.map(|row| row.map(|z| z * turn))));
            }
            real.extend(terms.iter().map(|p| 18 * f + p));
        }
        for &p in &real {
            parameters[p] = 0.0;
        }
        let objective = |linear: &[Linear], weights: &[[[f64; 6]; 6]], z: &[f64]| -> f64 {
            // The real terms stay real, so that they add nothing.
            let rows: f64 = linear
                .iter()
                .zip(weights)
                .map(|(l, w)| dot6(&times(w, &l.residual), &l.residual))
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
        let predictions = |linear: &[Linear]| linear.iter().map(|l| l.prediction).collect();
        let mut weights = weights_of(&linear)?;
        let mut weighed: Vec<[Complex64; 3]> = predictions(&linear);
        for iteration in 0..ITERATIONS {
            if iteration > 0 && iteration < REWEIGHTED {
                // Relative noise follows the prediction; once it is near, it stays, so that the end is a minimum.
                weights = weights_of(&linear)?;
                weighed = predictions(&linear);
            }
            let before = objective(&linear, &weights, &parameters[model.offset..]);
            let mut normal = vec![0.0; count * count];
            let mut right = vec![0.0; count];
            for (row, w) in linear.iter().zip(&weights) {
                let weighted: Vec<[f64; 6]> =
                    row.columns.iter().map(|(_, c)| times(w, c)).collect();
                for (a, (i, _)) in row.columns.iter().enumerate() {
                    right[*i] += dot6(&weighted[a], &row.residual);
                    for (j, column) in &row.columns {
                        if j <= i {
                            normal[i * count + j] += dot6(&weighted[a], column);
                        }
                    }
                }
            }
            for i in model.offset..count {
                normal[i * count + i] += 1.0;
                right[i] -= parameters[i];
            }
            for &p in &real {
                normal[p * count + p] += REAL;
                right[p] -= REAL * parameters[p];
            }
            let normal = Mat::from_fn(count, count, |i, j| normal[i.max(j) * count + i.min(j)]);
            let llt = cholesky(&normal).map_err(|_| Error::Unobservable {
                parameter: "sensitivity",
                condition: f64::INFINITY,
            })?;
            let delta = llt.solve(&Mat::from_fn(count, 1, |i, _| right[i]));
            // What the step would gain in the sum of squares: its length in units of u, squared.
            let gain: f64 = (0..count).map(|i| right[i] * delta[(i, 0)]).sum();
            if iteration >= REWEIGHTED && (gain < NEGLIGIBLE || step < 1e-6) {
                // The last step was rounding: this is the point at which everything is reported.
                let chi_squared = before;
                let inverse = llt.inverse();
                let covariance = (0..count * count)
                    .map(|k| {
                        0.5 * (inverse[(k / count, k % count)] + inverse[(k % count, k / count)])
                    })
                    .collect();
                let adjustment = Self {
                    real,
                    reals: rows.iter().map(PhasorRow::reals).collect(),
                    frequencies,
                    of_row,
                    scale,
                    parameters,
                    covariance,
                    draws,
                    chi_squared,
                    rows: linear,
                    weighed,
                    weights,
                    links,
                };
                adjustment.check_phases()?;
                return Ok(adjustment);
            }
            // Runs that contradict each other turn the angles far: the step is damped.
            let back: Vec<f64> = (0..count).map(|i| -delta[(i, 0)]).collect();
            let taken = descend(
                &parameters,
                &back,
                before,
                // Of a sum of some thousand terms; more would let large residuals turn in a circle.
                before * 1e-13 + 1e-11,
                |trial| Ok(linearise(trial)),
                |next, trial| objective(next, &weights, &trial[model.offset..]),
            )?;
            step = (0..count)
                .map(|i| {
                    // Sensitivities against the unit of y, draws against a thousand of their priors.
                    let unit = if i < model.offset { 1.0 } else { 1e3 };
                    taken.share * delta[(i, 0)].abs() / unit
                })
                .fold(0.0, f64::max);
            (linear, parameters) = (taken.equations, taken.parameters);
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

    /// Outputs over the reference as they are predicted for a row, V/(m/s²).
    pub(crate) fn predicted(&self, row: usize) -> [Complex64; 3] {
        self.rows[row].prediction.map(|y| y * self.scale)
    }

    /// The draws of an input of the budget.
    pub(crate) fn draws_of(&self, input: usize) -> impl Iterator<Item = usize> {
        let own = move |d: &usize| self.draws[*d].input == Some(input);
        (0..self.draws.len()).filter(own)
    }

    /// Place of the first draw among the parameters.
    pub(crate) fn first_draw(&self) -> usize {
        18 * self.frequencies.len()
    }

    /// Covariance of all parameters, row-major.
    pub(crate) fn covariances(&self) -> &[f64] {
        &self.covariance
    }

    /// Covariance of two parameters.
    pub(crate) fn covariance(&self, i: usize, j: usize) -> f64 {
        self.covariance[i * self.parameters.len() + j]
    }

    /// Degrees of freedom of χ²: 6 per run less 18 per frequency; with a phase in common 5 less 17, without phases 3 less 9, or what of the
    /// three is told.
    pub(crate) fn dof(&self) -> usize {
        let told: f64 = self.reals.iter().sum();
        (told as usize + self.real.len()).saturating_sub(18 * self.frequencies.len())
    }

    /// Where the phases of the runs are free, those between the axes must be told by runs that excite two of them together.
    fn check_phases(&self) -> Result<(), Error> {
        for &p in &self.real {
            let first = p / 18 * 18;
            for k in 0..3 {
                let q = first + 8 * k;
                let size = self.parameters[q].hypot(self.parameters[q + 1]);
                let across = Complex64::new(-self.parameters[q + 1], self.parameters[q]) / size;
                let variance = across.re * across.re * self.covariance(q, q)
                    + 2.0 * across.re * across.im * self.covariance(q, q + 1)
                    + across.im * across.im * self.covariance(q + 1, q + 1);
                if q + 1 != p && !(variance.sqrt() < UNTOLD * size) {
                    return Err(Error::Unobservable {
                        parameter: UNTIED,
                        condition: variance.sqrt() / size,
                    });
                }
            }
        }
        Ok(())
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
    /// phasors, by the spurious ratios that were measured, and by those that were not, in the order of [`Share::ALL`]. They sum to
    /// the covariance of the adjustment.
    pub(crate) fn contributions(
        &self,
        f: usize,
        rows: &[PhasorRow],
        budget: &Budget,
    ) -> Vec<Vec<f64>> {
        let inputs = budget.inputs.len();
        let mut sums = vec![vec![0.0; 18 * 18]; inputs + 2 + Share::ALL.len()];
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
            let prediction = &self.weighed[row];
            for (index, input) in budget.inputs.iter().enumerate() {
                if input.within_a_run() {
                    for column in run_columns(input, &rows[row], prediction, self.scale) {
                        add(&mut sums[index], &gain.map(|g| dot6(&g, &column)));
                    }
                }
            }
            // Noise of the phasors: the rest of the 6 × 6 weight, as its own covariance.
            let noise = phasor_noise(&rows[row], prediction, self.scale);
            for p in 0..18 {
                let half: [f64; 6] =
                    std::array::from_fn(|k| (0..6).map(|l| gain[p][l] * noise[l][k]).sum());
                for q in 0..18 {
                    sums[inputs][18 * p + q] += scale2 * dot6(&gain[q], &half);
                }
            }
        }
        for (draw, v) in self.draws.iter().zip(&shared) {
            let motion = inputs + 1 + draw.share.map_or(0, |share| 1 + share as usize);
            add(&mut sums[draw.input.unwrap_or(motion)], v);
        }
        sums
    }

    /// Score test of an angle that the budget does not have, as one draw per member of a group (two for a tilt) of
    /// standard uncertainty `u`, without another fit.
    ///
    /// q = ‖GᵀN⁻¹r̂‖², P = GᵀN⁻¹G − GᵀN⁻¹X C XᵀN⁻¹G; under no such error q is about (tr P/ν) χ²_ν with
    /// ν = (tr P)²/tr P². `None` when the data cannot see it at all.
    ///
    /// **Source** `[Rao1948]`, `[Lin1997]`; `[Satterthwaite1946]` for ν.
    pub(crate) fn score(
        &self,
        acts: Acts,
        u: f64,
        by: Group,
        rows: &[PhasorRow],
        spurious: &SpuriousTable,
        budget: &Budget,
    ) -> Option<Score> {
        let model = Model {
            rows,
            of_row: &self.of_row,
            spurious,
            budget,
            scale: self.scale,
            offset: self.first_draw(),
        };
        let mut places: Vec<super::Configuration> = vec![];
        let group: Vec<usize> = rows
            .iter()
            .map(|r| {
                let same = |c: &super::Configuration| match by {
                    Group::Configuration => c.same_as(&r.configuration),
                    Group::Inclination => {
                        (c.inclination - r.configuration.inclination).abs() < 1e-6
                    }
                };
                places.iter().position(same).unwrap_or_else(|| {
                    places.push(r.configuration);
                    places.len() - 1
                })
            })
            .collect();
        let parts = acts.parts();
        let m = parts * places.len();
        let column = |i: usize, part: usize| {
            model.error_column(i, &self.links[i], &self.parameters, acts, part, u)
        };
        let Projected { seen, p, .. } = self.projected(m, |i| {
            let own = (0..parts).map(|part| (parts * group[i] + part, column(i, part)));
            own.collect()
        });
        let q: f64 = seen.iter().map(|v| v * v).sum();
        let trace: f64 = (0..m).map(|i| p[(i, i)]).sum();
        let square: f64 = (0..m)
            .flat_map(|i| (0..m).map(move |j| (i, j)))
            .map(|(i, j)| p[(i, j)] * p[(j, i)])
            .sum();
        (trace > 0.0 && square > 0.0).then(|| {
            let nu = trace * trace / square;
            Score {
                statistic: q * nu / trace,
                dof: nu,
                variance: u * u * (q - trace) / square,
            }
        })
    }

    /// Further columns G of the model with everything else projected out; `columns` are those of a row, by their place among `count`.
    pub(crate) fn projected(
        &self,
        count: usize,
        columns: impl Fn(usize) -> Vec<Column>,
    ) -> Projected {
        let parameters = self.parameters.len();
        let (mut seen, mut own, mut shared) = (
            vec![0.0; count],
            Mat::<f64>::zeros(count, count),
            Mat::<f64>::zeros(count, parameters),
        );
        for (i, linear) in self.rows.iter().enumerate() {
            let w = &self.weights[i];
            let columns = columns(i);
            for (a, column) in &columns {
                let weighted = times(w, column);
                seen[*a] += dot6(&weighted, &linear.residual);
                for (b, other) in &columns {
                    own[(*a, *b)] += dot6(&weighted, other);
                }
                for (j, x) in &linear.columns {
                    shared[(*a, *j)] += dot6(&weighted, x);
                }
            }
        }
        let covariance = Mat::from_fn(parameters, parameters, |i, j| self.covariance(i, j));
        let largest = (0..count).map(|i| own[(i, i)]).fold(0.0, f64::max);
        let p = own - product([shared.as_ref(), covariance.as_ref(), shared.transpose()]);
        Projected { seen, p, largest }
    }

    /// Relative changes of the modulus and of the phase of each output of a row, as columns: twice the output, and one more.
    pub(crate) fn gain_columns(&self, row: usize) -> [[f64; 6]; 6] {
        std::array::from_fn(|k| {
            let m = self.weighed[row][k / 2];
            let along = if k % 2 == 0 { m } else { Complex64::i() * m };
            let mut column = [0.0; 6];
            (column[k - k % 2], column[k - k % 2 + 1]) = (along.re, along.im);
            column
        })
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
                let llt = cholesky(&q).map_err(|_| Error::Unobservable {
                    parameter: "sensitivity without one of the runs",
                    condition: f64::INFINITY,
                })?;
                let error = llt.solve(&right);
                let covariance = llt.inverse();
                let statistic = (0..6).map(|a| error[(a, 0)] * right[(a, 0)]).sum();
                let gain = self.gain(self.of_row[row], row);
                Ok(Deletion {
                    prediction_error: std::array::from_fn(|j| {
                        Complex64::new(error[(2 * j, 0)], error[(2 * j + 1, 0)]) * self.scale
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

fn weights_of(rows: &[Linear]) -> Result<Vec<[[f64; 6]; 6]>, Error> {
    rows.iter()
        .enumerate()
        .map(|(index, row)| {
            let n = Mat::from_fn(6, 6, |a, b| row.noise[a][b]);
            let llt = cholesky(&n).map_err(|_| Error::NotPositiveDefinite {
                name: "covariance of a run",
                row: index,
                column: index,
                value: 0.0,
            })?;
            let w = llt.inverse();
            Ok(std::array::from_fn(|a| {
                std::array::from_fn(|b| 0.5 * (w[(a, b)] + w[(b, a)]))
            }))
        })
        .collect()
}

fn times(w: &[[f64; 6]; 6], v: &[f64; 6]) -> [f64; 6] {
    std::array::from_fn(|a| dot6(&w[a], v))
}

fn dot6(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    (0..6).map(|k| a[k] * b[k]).sum()
}
