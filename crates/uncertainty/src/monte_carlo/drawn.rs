//! Trials row by row: outputs beside the inputs they come from.

use super::{BLOCK, MonteCarlo, Portion, Trial, Trials, circles};
use crate::sampler::Sampler;
use crate::{JointInputs, Refusal};

/// Columns of trials, of equal length: row k of all is one trial.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Drawn {
    /// One column per output.
    pub outputs: Vec<Vec<f64>>,
    /// One column per draw of the inputs that was asked for.
    pub inputs: Vec<Vec<f64>>,
}

/// A procedure whose inputs are seen beside its outputs.
struct Seen<'a, M> {
    model: &'a M,
    outputs: usize,
    inputs: &'a [usize],
}

impl<M: Trial> Trial for Seen<'_, M> {
    fn names(&self) -> Vec<(String, String)> {
        let mut names = self.model.names();
        names.resize(self.outputs + self.inputs.len(), Default::default());
        names
    }
    fn trial(&self, x: &[f64], y: &mut [f64]) {
        let (y, seen) = y.split_at_mut(self.outputs);
        self.model.trial(x, y);
        for (seen, &d) in seen.iter_mut().zip(self.inputs) {
            *seen = x[d];
        }
    }
    fn trials(&self, x: &[&[f64]], y: &mut [&mut [f64]]) {
        let (y, seen) = y.split_at_mut(self.outputs);
        self.model.trials(x, y);
        for (seen, &d) in seen.iter_mut().zip(self.inputs) {
            let count = seen.len();
            seen.copy_from_slice(&x[d][..count]);
        }
    }
    fn circles(&self) -> Vec<Option<f64>> {
        let mut periods = self.model.circles();
        periods.resize(self.outputs + self.inputs.len(), None);
        periods
    }
}

impl MonteCarlo {
    /// This many trials as they are drawn, without those in which an output is not a finite number: the first ones of
    /// [`MonteCarlo::run`] with the same seed. `seen` are the draws of the inputs that are wanted beside the outputs, by their
    /// place in [`JointInputs::draws`].
    ///
    /// # Errors
    /// As [`MonteCarlo::run`].
    pub fn drawn<M: Trial + Sync>(
        &self,
        model: &M,
        inputs: &JointInputs,
        trials: usize,
        seen: &[usize],
    ) -> Result<Drawn, Refusal> {
        let seen = Seen {
            model,
            outputs: model.names().len(),
            inputs: seen,
        };
        let sampler = Sampler::new(inputs)?;
        let circles = circles(&seen, inputs);
        let portion = Portion {
            trials: BLOCK,
            shared: false,
        };
        let plain = self.trials(Trials::Fixed(trials));
        let mut columns = vec![Vec::with_capacity(trials); circles.len()];
        for number in 0..trials.div_ceil(BLOCK) {
            let block = plain.block(&seen, &sampler, inputs, &circles, portion, number);
            let part = BLOCK.min(trials - number * BLOCK);
            for row in 0..part {
                let outputs = &block.columns[..seen.outputs];
                if outputs.iter().all(|column| column[row].is_finite()) {
                    for (all, column) in columns.iter_mut().zip(&block.columns) {
                        all.push(column[row]);
                    }
                }
            }
        }
        let inputs = columns.split_off(seen.outputs);
        Ok(Drawn {
            outputs: columns,
            inputs,
        })
    }
}
