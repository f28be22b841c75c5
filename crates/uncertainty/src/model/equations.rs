//! The formulas of a model as a [`Model`].

use super::entries::{FitScatter, FitWeights};
use super::fit::Fit;
use super::solve::Solve;
use crate::expression::{Op, Program};
use crate::propagation::derivatives;
use crate::{Dual, Finding, JointInputs, Model, Number, Refusal};

/// Equations read from formulas.
#[derive(Clone, Debug, PartialEq)]
pub struct Equations {
    outputs: Vec<(String, String)>,
    /// Results that are the outputs.
    places: Vec<u32>,
    program: Program,
    blocks: Vec<Block>,
    /// The angles of `atan2` at the estimates.
    angles: Vec<f64>,
}

/// What gives several results at once.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Block {
    Solve(Box<Solve>),
    Fit(Box<Fit>),
}

/// Trials that are made in any case: one block of Monte Carlo.
const FEWEST: usize = 10_000;

/// Results up to this many live on the stack during an evaluation.
const NEAR: usize = 48;

/// Points of a fit, abscissae and ordinates, up to which each is held against its uncertainty.
const MOST_POINTS: usize = 4000;

impl Equations {
    pub(super) fn new(
        outputs: Vec<(String, String)>,
        places: Vec<u32>,
        program: Program,
        blocks: Vec<Block>,
    ) -> Self {
        Self {
            outputs,
            places,
            program,
            blocks,
            angles: Vec::new(),
        }
    }

    /// The same equations, in which every angle of `atan2` is counted from its value at these inputs, half a turn to
    /// either side: the cut at ± π then divides no distribution.
    #[must_use]
    pub(super) fn about(mut self, inputs: &[f64]) -> Self {
        self.angles.clear();
        let mut angles = Vec::new();
        let mut results = vec![0.0; self.program.ops.len()];
        self.program.run(
            inputs,
            &mut results,
            |_, angle| {
                angles.push(angle);
                angle
            },
            |number, before, out| self.blocks[number].evaluate(before, out),
        );
        self.angles = angles;
        self
    }

    /// Only some of the outputs, by position.
    #[must_use]
    pub(crate) fn only(&self, kept: &[usize]) -> Self {
        Self {
            outputs: kept.iter().map(|&k| self.outputs[k].clone()).collect(),
            places: kept.iter().map(|&k| self.places[k]).collect(),
            ..self.clone()
        }
    }

    pub(super) fn run<T: Number>(&self, x: &[T], results: &mut [T]) {
        self.program.run(
            x,
            results,
            |number, angle| unwrapped(angle, self.angles.get(number).copied()),
            |number, before, out| self.blocks[number].evaluate(before, out),
        );
    }

    /// The place of a block among the results.
    pub(super) fn place_of(&self, block: usize) -> usize {
        let here = |op: &Op| *op == Op::Block(block);
        self.program.ops.iter().position(here).unwrap_or(0)
    }

    /// Trials that a calculation may make of its own accord: what is solved anew in each of them costs, and so do draws
    /// and operations by the thousand.
    pub(crate) fn affordable(&self, most: usize, draws: usize) -> usize {
        let blocks = self.program.ops.iter().filter_map(|op| match op {
            Op::Block(number) => self.blocks.get(*number),
            _ => None,
        });
        let cost: f64 = blocks
            .map(|block| match block {
                Block::Fit(fit) => fit.cost(),
                Block::Solve(solve) => {
                    let m = solve.start.len() as f64;
                    50.0 * (1.0 + m) * (solve.program.ops.len() as f64 + m * m)
                }
            })
            .sum();
        let cost = cost + 20.0 * draws as f64 + 2.0 * self.program.ops.len() as f64;
        most.min(((2e10 / cost.max(1.0)) as usize).max(FEWEST))
    }

    pub(super) fn program(&self) -> &Program {
        &self.program
    }

    /// Results that are the outputs.
    pub(super) fn places(&self) -> &[u32] {
        &self.places
    }

    /// Other operations for the same outputs.
    pub(super) fn rewritten(&self, places: Vec<u32>, program: Program, blocks: Vec<Block>) -> Self {
        Self {
            outputs: self.outputs.clone(),
            places,
            program,
            blocks,
            angles: self.angles.clone(),
        }
    }

    pub(super) fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Gives a block what it needs to know of the inputs: where a search starts, how the points of a fit are weighed.
    /// For a fit whose residuals are a cause of their own, their standard deviation.
    ///
    /// # Errors
    /// [`Refusal::Equation`] where there is no solution, or points that no polynomial goes through.
    pub(super) fn prepare(
        &mut self,
        block: usize,
        joint: &JointInputs,
        findings: &mut Vec<Finding>,
    ) -> Result<Option<f64>, Refusal> {
        let x = joint.estimates();
        let place = self.place_of(block);
        let mut before = vec![0.0; place];
        self.run(&x, &mut before);
        match self.blocks[block].clone() {
            Block::Solve(mut solve) => {
                solve.settle(&before)?;
                self.blocks[block] = Block::Solve(solve);
                Ok(None)
            }
            Block::Fit(mut fit) => {
                let name = fit.entry.name.clone();
                let refuse = |what| Refusal::Equation { name, what };
                let points: Vec<u32> = fit.x.iter().chain(&fit.y).copied().collect();
                let weighed = fit.entry.weights != FitWeights::Equal;
                // What a fit that is not weighed is held against afterwards.
                let judged = fit.entry.scatter == FitScatter::None && points.len() <= MOST_POINTS;
                let slopes = (weighed || judged).then(|| self.slopes(&points, &x, place));
                let covariance = slopes.as_ref().filter(|_| weighed);
                let covariance = covariance.map(|jacobian| joint.seen_in(jacobian));
                fit.prepare(&before, covariance.as_ref()).map_err(refuse)?;
                let mut parameters = vec![0.0; fit.degree + 1];
                fit.evaluate(&before, &mut parameters);
                let u = slopes.filter(|_| !weighed);
                let u = u.map(|jacobian| uncertainties(&jacobian, joint));
                findings.extend(fit.doubt(&before, &parameters, u.as_deref()));
                let scatter = (fit.entry.scatter == FitScatter::Residuals)
                    .then(|| fit.scatter(&before, &parameters));
                self.blocks[block] = Block::Fit(fit);
                Ok(scatter)
            }
        }
    }

    /// Derivatives of some results with respect to every draw, row by row; zero where there is none.
    fn slopes(&self, results: &[u32], x: &[f64], place: usize) -> Vec<f64> {
        let (_, mut jacobian) = derivatives::<8>(x, results.len(), |x, y| {
            let mut all = vec![Dual::from(0.0); place];
            self.run(x, &mut all);
            for (y, &k) in y.iter_mut().zip(results) {
                *y = all[k as usize];
            }
        });
        let none = jacobian.iter_mut().filter(|j| !j.is_finite());
        none.for_each(|j| *j = 0.0);
        jacobian
    }
}

/// Standard uncertainty of each row of results; what correlates its draws is no reason for less.
fn uncertainties(jacobian: &[f64], joint: &JointInputs) -> Vec<f64> {
    let draws = joint.draws();
    let of = |row: &[f64]| {
        let terms = row.iter().zip(draws);
        let squares = terms.map(|(j, d)| (j * d.standard_uncertainty).powi(2));
        squares.sum::<f64>().sqrt()
    };
    jacobian.chunks(draws.len().max(1)).map(of).collect()
}

impl Block {
    /// The results it takes.
    pub(super) fn takes(&self) -> impl Iterator<Item = u32> + '_ {
        let (first, second): (&[u32], &[u32]) = match self {
            Self::Solve(solve) => (&solve.captured, &[]),
            Self::Fit(fit) => (&fit.x, &fit.y),
        };
        first.iter().chain(second).copied()
    }

    /// The same with other numbers of what it takes.
    pub(super) fn renumbered(&self, place: &[u32]) -> Self {
        let mut block = self.clone();
        let parts = match &mut block {
            Self::Solve(solve) => [Some(&mut solve.captured), None],
            Self::Fit(fit) => [Some(&mut fit.x), Some(&mut fit.y)],
        };
        for k in parts.into_iter().flatten().flatten() {
            *k = place[*k as usize];
        }
        block
    }

    fn evaluate<T: Number>(&self, before: &[T], out: &mut [T]) {
        match self {
            Self::Solve(solve) => solve.evaluate(before, out),
            Self::Fit(fit) => fit.evaluate(before, out),
        }
    }
}

impl Model for Equations {
    fn outputs(&self) -> Vec<(String, String)> {
        self.outputs.clone()
    }

    fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
        let length = self.program.ops.len();
        let mut near = [T::from(0.0); NEAR];
        let mut far = Vec::new();
        let results: &mut [T] = if length <= NEAR {
            &mut near[..length]
        } else {
            far.resize(length, T::from(0.0));
            &mut far
        };
        self.run(x, results);
        for (y, &place) in y.iter_mut().zip(&self.places) {
            *y = results[place as usize];
        }
    }

    fn evaluate_columns(&self, x: &[&[f64]], y: &mut [&mut [f64]]) {
        let lengths = x.iter().map(|column| column.len());
        let lengths = lengths.chain(y.iter().map(|column| column.len()));
        let trials = lengths.min().unwrap_or(0);
        let most = self.program.columns_width(trials);
        let mut results = vec![0.0; self.program.ops.len() * most];
        let mut part: Vec<&[f64]> = Vec::with_capacity(x.len());
        for start in (0..trials).step_by(most) {
            let width = most.min(trials - start);
            part.clear();
            part.extend(x.iter().map(|column| &column[start..start + width]));
            self.program.run_columns(
                &part,
                &mut results,
                width,
                |number, angle| unwrapped(angle, self.angles.get(number).copied()),
                |number, before, out| self.blocks[number].evaluate(before, out),
            );
            for (column, &place) in y.iter_mut().zip(&self.places) {
                let from = place as usize * width;
                column[start..start + width].copy_from_slice(&results[from..from + width]);
            }
        }
    }
}

/// The angle within half a turn of another.
fn unwrapped<T: Number>(angle: T, about: Option<f64>) -> T {
    let turn = std::f64::consts::TAU;
    let turns = about.map_or(0.0, |about| ((about - angle.value()) / turn).round());
    if turns != 0.0 && turns.is_finite() {
        angle + T::from(turns * turn)
    } else {
        angle
    }
}
