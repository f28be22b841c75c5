//! When a calculation may stop.

use crate::numerical_tolerance;

/// The stopping rule of `[S1] 7.9.4`: twice the standard deviation of the average over blocks below δ.
pub(super) struct Stability {
    count: f64,
    mean: Vec<[f64; 4]>,
    squares: Vec<[f64; 4]>,
}

impl Stability {
    pub fn new(m: usize) -> Self {
        Self {
            count: 0.0,
            mean: vec![[0.0; 4]; m],
            squares: vec![[0.0; 4]; m],
        }
    }

    pub fn add(&mut self, figures: &[[f64; 4]]) {
        self.count += 1.0;
        for (k, figures) in figures.iter().enumerate() {
            for (f, value) in figures.iter().enumerate() {
                let step = value - self.mean[k][f];
                self.mean[k][f] += step / self.count;
                self.squares[k][f] += step * (value - self.mean[k][f]);
            }
        }
    }

    pub fn stable(&self, digits: u32, tolerances: &[f64]) -> bool {
        let h = self.count;
        let columns = self.mean.iter().zip(&self.squares).enumerate();
        columns.into_iter().all(|(k, (mean, squares))| {
            let asked = tolerances.get(k).filter(|t| **t > 0.0);
            let asked = asked.map_or(f64::INFINITY, |t| 0.5 * t);
            let delta = numerical_tolerance(mean[1], digits).min(asked);
            // An output without valid trials has nothing to wait for.
            squares
                .iter()
                .all(|s| s.is_nan() || 2.0 * (s / (h * (h - 1.0))).sqrt() <= delta)
        })
    }
}
