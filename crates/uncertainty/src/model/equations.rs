//! The formulas of a model as a [`Model`].

use crate::{Expression, Model, Number};

/// Equations read from formulas.
#[derive(Clone, Debug, PartialEq)]
pub struct Equations {
    outputs: Vec<(String, String)>,
    /// Positions of the outputs among the steps.
    places: Vec<usize>,
    inputs: usize,
    steps: Vec<Expression>,
    /// Per step: the angles of its `atan2` at the estimates.
    angles: Vec<Vec<f64>>,
}

/// Names up to this many live on the stack during an evaluation.
const NAMES: usize = 24;

impl Equations {
    /// Formulas in the order of evaluation, of which the last are the outputs.
    pub(super) fn new(
        outputs: Vec<(String, String)>,
        inputs: usize,
        steps: Vec<Expression>,
    ) -> Self {
        Self {
            places: (steps.len() - outputs.len()..steps.len()).collect(),
            angles: vec![Vec::new(); steps.len()],
            outputs,
            inputs,
            steps,
        }
    }

    /// The same equations, in which every angle of `atan2` is counted from its value at these inputs, half a turn to
    /// either side: the cut at ± π then divides no distribution.
    #[must_use]
    pub fn about(mut self, inputs: &[f64]) -> Self {
        let mut values = inputs.to_vec();
        for (step, angles) in self.steps.iter().zip(&mut self.angles) {
            angles.clear();
            values.push(step.evaluate_with(&values, |_, angle| {
                angles.push(angle);
                angle
            }));
        }
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
}

impl Model for Equations {
    fn outputs(&self) -> Vec<(String, String)> {
        self.outputs.clone()
    }

    fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
        let total = self.inputs + self.steps.len();
        let mut near = [T::from(0.0); NAMES];
        let mut far = Vec::new();
        let values: &mut [T] = if total <= NAMES {
            &mut near[..total]
        } else {
            far.resize(total, T::from(0.0));
            &mut far
        };
        values[..self.inputs].copy_from_slice(&x[..self.inputs]);
        for (k, (step, angles)) in self.steps.iter().zip(&self.angles).enumerate() {
            let place = self.inputs + k;
            values[place] = step.evaluate_with(&values[..place], |number, angle| {
                unwrapped(angle, angles.get(number).copied())
            });
        }
        for (y, place) in y.iter_mut().zip(&self.places) {
            *y = values[self.inputs + place];
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
