//! A model ready to be evaluated: joint inputs, and equations that know them.

use super::{Equations, UncertaintyModel};
use crate::{Distribution, Finding, Input, Inputs, JointInputs, Labels, Refusal};

/// The scatter of the points of a fit, as a cause of its own.
struct Scatter {
    block: usize,
    points: usize,
    name: String,
    unit: String,
    dof: f64,
    /// Standard deviation of one point, once it is known.
    s: f64,
}

/// A model ready to be evaluated.
pub(crate) struct Prepared {
    pub(crate) joint: JointInputs,
    pub(crate) equations: Equations,
    /// Outputs, complex ones and vectors taken apart.
    pub(crate) outputs: Vec<super::OutputEntry>,
    /// What to doubt in the fits.
    pub(crate) findings: Vec<Finding>,
}

impl UncertaintyModel {
    /// The joint inputs, with the scatter of every fit that tells it, and the equations about them: what a library user
    /// gives to [`propagate`](crate::propagate) and [`MonteCarlo`](crate::MonteCarlo).
    ///
    /// # Errors
    /// As [`UncertaintyModel::inputs`] and [`UncertaintyModel::equations`]; [`Refusal::Equation`] for equations without a
    /// solution at the estimates and fits that their points do not determine.
    pub fn prepared(&self) -> Result<(JointInputs, Equations), Refusal> {
        let prepared = self.prepare()?;
        Ok((prepared.joint, prepared.equations))
    }

    pub(crate) fn prepare(&self) -> Result<Prepared, Refusal> {
        let compiled = self.compiled()?;
        let inputs = self.inputs()?;
        let mut scatters: Vec<Scatter> = Vec::new();
        for &(block, points) in &compiled.scatter {
            let super::equations::Block::Fit(fit) = &compiled.blocks[block] else {
                continue;
            };
            let y = fit.entry.y.trim();
            let vector = self.input.iter().find(|input| input.name == y);
            scatters.push(Scatter {
                block,
                points,
                name: format!("scatter of {}", fit.entry.name),
                unit: vector.map_or_else(|| "1".to_owned(), |input| input.unit.clone()),
                dof: (points - fit.degree - 1) as f64,
                s: 0.0,
            });
        }
        let outputs = compiled.outputs.clone();
        self.check_requests(&outputs)?;
        let mut findings: Vec<Finding> = compiled.shared.clone();
        let mut equations = compiled.equations();
        let mut joint = with_scatter(&inputs, &scatters)?;
        for block in 0..equations.blocks().len() {
            let found = equations.prepare(block, &joint, &mut findings)?;
            if let (Some(s), Some(scatter)) =
                (found, scatters.iter_mut().find(|s| s.block == block))
            {
                scatter.s = s;
                joint = with_scatter(&inputs, &scatters)?;
            }
        }
        let equations = equations.about(&joint.estimates());
        Ok(Prepared {
            joint,
            equations,
            outputs,
            findings,
        })
    }
}

/// One draw per point and fit, which share the estimate of their σ.
fn with_scatter(inputs: &Inputs, scatters: &[Scatter]) -> Result<JointInputs, Refusal> {
    if scatters.is_empty() {
        return inputs.single();
    }
    let mut inputs = inputs.clone();
    for scatter in scatters {
        let distribution = if scatter.s > 0.0 {
            Distribution::StudentT {
                location: 0.0,
                scale: scatter.s,
                dof: scatter.dof,
            }
        } else {
            Distribution::Normal { mean: 0.0, u: 0.0 }
        };
        let input = Input::new(&scatter.name, &scatter.unit, distribution);
        inputs = inputs.add(input.varies_with([scatter.name.clone()]));
    }
    let most = scatters.iter().map(|s| s.points).max().unwrap_or(1);
    let points: Vec<Labels> = (0..most)
        .map(|i| {
            scatters.iter().fold(Labels::new(), |labels, s| {
                labels.with(s.name.clone(), i.min(s.points - 1) + 1)
            })
        })
        .collect();
    inputs.joint(&points)
}
