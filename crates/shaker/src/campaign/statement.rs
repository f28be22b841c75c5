//! Expanded uncertainties at another coverage factor than that of 95 %.

use super::{FrequencyResult, ShakerCalibration};

impl FrequencyResult {
    /// States every expanded uncertainty as U = k u, with the probability that it then has.
    pub fn state_with(&mut self, k: f64) {
        for term in self.sensitivity.iter_mut().chain(&mut self.exploitation) {
            let parts = [&mut term.modulus, &mut term.real];
            for part in parts.into_iter().chain(&mut term.phase) {
                part.state_with(k);
            }
        }
        let lists = [
            &mut self.normalised,
            &mut self.normalised_exploitation,
            &mut self.transverse,
            &mut self.misalignment,
            &mut self.intrinsic,
        ];
        for quantity in lists.into_iter().flatten() {
            quantity.state_with(k);
        }
    }
}

impl ShakerCalibration {
    /// States every expanded uncertainty of the rigorous methods as U = k u, with the probability that it then has by the
    /// effective degrees of freedom. What was decided at 95 % stays: findings, E_n, limits of the data sheet.
    pub fn state_with(&mut self, k: f64) {
        for result in &mut self.results {
            for f in &mut result.frequencies {
                f.state_with(k);
            }
        }
    }
}
