//! Tests of added terms where the covariance of the residuals has several forms, each with a weight.

use super::{AddedTerms, Test};

/// One linearised fit for each form of the covariance.
#[derive(Clone, Debug)]
pub(crate) struct WeighedTerms<'a> {
    /// Weights add to one.
    forms: Vec<(f64, AddedTerms<'a>)>,
}

impl<'a> WeighedTerms<'a> {
    /// `forms`: at least one, with weights in any unit.
    pub fn new(forms: Vec<(f64, AddedTerms<'a>)>) -> Self {
        let total: f64 = forms.iter().map(|(w, _)| w).sum();
        let forms = forms.into_iter();
        Self {
            forms: forms.map(|(w, terms)| (w / total, terms)).collect(),
        }
    }

    /// The fit of independent errors, which comes first.
    pub fn independent(&self) -> Option<&AddedTerms<'a>> {
        self.forms.first().map(|(_, terms)| terms)
    }

    /// F test of columns: the mean probability over the forms, the amplitudes of the likeliest.
    pub fn test(&self, columns: &[Vec<f64>]) -> Option<Test> {
        let mut best: Option<(f64, Test)> = None;
        let mut p_value = 0.0;
        for (weight, terms) in &self.forms {
            let test = terms.test(columns)?;
            p_value += weight * test.p_value;
            if best.as_ref().is_none_or(|(w, _)| weight > w) {
                best = Some((*weight, test));
            }
        }
        let (_, mut test) = best?;
        test.p_value = p_value;
        Some(test)
    }

    /// Takes a group of terms into the model.
    pub fn accept(&mut self, columns: &[Vec<f64>]) {
        for (_, terms) in &mut self.forms {
            if let Some(test) = terms.test(columns) {
                terms.accept(&test);
            }
        }
    }

    /// Takes an observation of `each` equations out of the residuals.
    pub fn leave_out(&mut self, index: usize, each: usize) {
        for (_, terms) in &mut self.forms {
            terms.leave_out(index, each);
        }
    }
}
