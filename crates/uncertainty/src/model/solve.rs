//! Equations of a model file that are solved for their unknowns.

use crate::expression::Program;
use crate::implicit::Branch;
use crate::{Implicit, Model, Number, Solved};
use proofmass_core::Error;

/// Equations h(y, x) = 0 with y the unknowns and x results of the formulas before.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Solve {
    pub(crate) unknown: Vec<String>,
    pub(crate) start: Vec<f64>,
    /// Variables: the unknowns, then the captured results.
    pub(crate) program: Program,
    /// Results of the program that are to be 0.
    pub(crate) residuals: Vec<u32>,
    /// Results of the formulas before that the equations speak of.
    pub(crate) captured: Vec<u32>,
    /// The solution at the estimates, from which those of the trials are followed.
    pub(crate) branch: Option<Branch>,
}

impl Solve {
    /// The unknowns, not numbers where the search does not settle.
    pub fn evaluate<T: Number>(&self, before: &[T], unknowns: &mut [T]) {
        let x: Vec<T> = self.captured.iter().map(|&k| before[k as usize]).collect();
        Solved::on(self, self.start.clone(), self.branch.clone()).evaluate(&x, unknowns);
    }

    /// From here on solutions are followed from this one.
    pub fn settle(&mut self, before: &[f64], solution: Vec<f64>) -> Result<(), Error> {
        let x: Vec<f64> = self.captured.iter().map(|&k| before[k as usize]).collect();
        let branch = Branch::of(&&*self, &solution, &x, &self.start)?;
        self.start = solution;
        self.branch = Some(branch);
        Ok(())
    }
}

impl Implicit for &Solve {
    fn outputs(&self) -> Vec<(String, String)> {
        let names = self.unknown.iter().cloned();
        names.map(|name| (name, String::new())).collect()
    }

    fn residual<T: Number>(&self, y: &[T], x: &[T], h: &mut [T]) {
        let variables: Vec<T> = y.iter().chain(x).copied().collect();
        let mut results = vec![T::from(0.0); self.program.ops.len()];
        self.program
            .run(&variables, &mut results, |_, angle| angle, |_, _, _| ());
        for (h, &place) in h.iter_mut().zip(&self.residuals) {
            *h = results[place as usize];
        }
    }
}
