//! Equations of a model file that are solved for their unknowns.

use crate::expression::Program;
use crate::implicit::{Branch, Found, Lost, Root};
use crate::{Implicit, Model, Number, Refusal, Solved};

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

    /// Looks for the solution at the estimates, from where the search starts: solutions are followed from it then.
    pub fn settle(&mut self, before: &[f64]) -> Result<(), Refusal> {
        let x: Vec<f64> = self.captured.iter().map(|&k| before[k as usize]).collect();
        let refuse = |what: &str| Refusal::Equation {
            name: self.unknown.join(", "),
            what: what.to_owned(),
        };
        let Found { y, scale } = Root::search(&&*self, &self.start, &x).map_err(|lost| {
            refuse(match lost {
                Lost::Stationary => {
                    "the search starts where the equations do not tell the unknowns apart from their neighbours (a stationary \
                     point, or too few equations); start beside the solution that is meant"
                }
                Lost::Ended => {
                    "no solution was found at the estimates from where the search starts, without crossing a fold to another \
                     branch; begin nearer to the one that is meant, and check that the equations determine each unknown"
                }
            })
        })?;
        self.branch = Some(Branch::of(&&*self, &y, &x, &scale)?);
        self.start = y;
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
