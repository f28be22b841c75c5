//! One input with another estimate or another uncertainty, in the words of its statement.

use super::InputEntry;
use crate::Refusal;

impl InputEntry {
    /// Another estimate; its uncertainty moves along, and the part of an accuracy that goes with the reading follows it.
    pub(super) fn move_to(&mut self, estimate: f64) -> Result<(), Refusal> {
        if self.value.is_some() {
            self.value = Some(estimate);
            return Ok(());
        }
        let offset = estimate - self.input()?.estimate();
        self.each_number(|x, _| x + offset);
        if let Some(distribution) = &mut self.distribution {
            *distribution = distribution.scaled(1.0, offset);
        }
        Ok(())
    }

    /// The same input with its standard uncertainty multiplied: all that states it, about the estimate.
    pub(crate) fn with_uncertainty_times(&self, factor: f64) -> Self {
        let mut entry = self.clone();
        for spread in [
            &mut entry.u,
            &mut entry.expanded,
            &mut entry.half_width,
            &mut entry.resolution,
        ] {
            *spread = spread.map(|s| factor * s);
        }
        if let Some(accuracy) = &mut entry.accuracy {
            accuracy.reading_percent *= factor;
            accuracy.range_percent *= factor;
            accuracy.constant *= factor;
        }
        if let Some(each) = &mut entry.u_of_each {
            each.iter_mut().for_each(|u| *u *= factor);
        }
        entry.each_number(|x, mean| mean + factor * (x - mean));
        if let Some(distribution) = &mut entry.distribution {
            let middle = (1.0 - factor) * distribution.estimate();
            *distribution = distribution.scaled(factor, middle);
        }
        entry
    }

    /// Changes every observation, knowing their mean; of groups that of their means.
    fn each_number(&mut self, change: impl Fn(f64, f64) -> f64) {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        if let Some(values) = &mut self.observations {
            let middle = mean(values);
            values.iter_mut().for_each(|x| *x = change(*x, middle));
        }
        if let Some(groups) = &mut self.groups {
            let means: Vec<f64> = groups.iter().map(|g| mean(g)).collect();
            let middle = mean(&means);
            let all = groups.iter_mut().flatten();
            all.for_each(|x| *x = change(*x, middle));
        }
    }
}
