//! A run on trial: what each cause would add to the contradictions of the sound ones.

use super::super::adjustment::Adjustment;
use super::super::budget::Budget;
use super::super::excitation::directions;
use super::super::geometry::Configuration;
use super::super::matrix::{Matrix, row_times};
use super::super::observation::{PhasorRow, SpuriousTable};

/// The sound runs of a frequency, and what a further one would add to their contradictions.
pub(super) struct Trial<'a> {
    pub(super) frequency: f64,
    pub(super) sound: Vec<PhasorRow>,
    pub(super) chi_squared: f64,
    pub(super) sensitivity: Matrix,
    /// Of the declared variance, by which the sound runs scatter more.
    pub(super) factor: f64,
    pub(super) plan: Vec<Configuration>,
    pub(super) spurious: &'a SpuriousTable,
    pub(super) budget: &'a Budget,
}

impl Trial<'_> {
    /// χ² with the run less χ² without it, over the factor: six degrees of freedom when it belongs to them.
    pub(super) fn increase(&self, row: &PhasorRow) -> f64 {
        let mut rows = self.sound.clone();
        rows.push(row.clone());
        match Adjustment::new(&rows, self.spurious, self.budget) {
            Ok(adjustment) => (adjustment.chi_squared - self.chi_squared).max(0.0) / self.factor,
            // So far off that no angles reconcile it with the others.
            Err(_) => 1e9,
        }
    }

    /// Outputs per unit acceleration that the sound runs predict for a run.
    pub(super) fn prediction(&self, row: &PhasorRow) -> [num_complex::Complex64; 3] {
        let d = directions(std::slice::from_ref(row), self.spurious)[0];
        row_times(d, &self.sensitivity)
    }

    /// Mean square of the main sensitivities.
    fn main(&self) -> f64 {
        let all = self.sensitivity.iter().flatten();
        all.map(|z| z.norm_sqr()).sum::<f64>() / 3.0
    }

    /// Distance of a run from its prediction, in units of two per cent of the main sensitivity: a gluing by a degree.
    pub(super) fn distance(&self, row: &PhasorRow) -> f64 {
        let (y, m) = (row.ratios(), self.prediction(row));
        let off: f64 = (0..3).map(|j| (y[j] - m[j]).norm_sqr()).sum();
        off / (4e-4 * self.main())
    }
}
