//! Where χ² comes from: the runs of each frequency, and the errors that frequencies share.

use super::{Adjustment, dot6, times};

/// A part of χ² and the degrees of freedom it has.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Part {
    pub(crate) chi_squared: f64,
    pub(crate) dof: f64,
}

impl Adjustment {
    /// χ² of each frequency, with the draws it has for itself, and that of the draws that frequencies share.
    ///
    /// E rᵀN⁻¹r = 6 − tr(N⁻¹ X C Xᵀ) of a run (5 where its phase is free) and E z² = 1 − C_zz of a draw; together 6 n − 18 per frequency.
    pub(crate) fn parts(&self) -> (Vec<Part>, Part) {
        let mut own = vec![Part::default(); self.frequencies.len()];
        for (row, linear) in self.rows.iter().enumerate() {
            let w = &self.weights[row];
            let part = &mut own[self.of_row[row]];
            part.chi_squared += dot6(&times(w, &linear.residual), &linear.residual);
            let mut trace = 0.0;
            for (i, x) in &linear.columns {
                let weighted = times(w, x);
                for (j, other) in &linear.columns {
                    trace += self.covariance(*i, *j) * dot6(&weighted, other);
                }
            }
            part.dof += self.reals[row] - trace;
        }
        let mut shared = Part::default();
        let offset = self.first_draw();
        for (d, draw) in self.draws.iter().enumerate() {
            let p = offset + d;
            let part = match draw.frequency {
                Some(f) => &mut own[f],
                None => &mut shared,
            };
            part.chi_squared += self.parameters[p].powi(2);
            part.dof += 1.0 - self.covariance(p, p);
        }
        (own, shared)
    }

    /// Slope of a relative change of the outputs in `time` (one value per run) and its variance, with everything else
    /// projected out; `None` where nothing can see it.
    pub(crate) fn trend(&self, time: &[f64], channel: Option<usize>) -> Option<(f64, f64)> {
        let (mut along, mut square) = (0.0, 0.0);
        let mut cross = vec![0.0; self.parameters.len()];
        for (row, linear) in self.rows.iter().enumerate() {
            let column: [f64; 6] = std::array::from_fn(|k| {
                let m = self.weighed[row][k / 2];
                let part = if k % 2 == 0 { m.re } else { m.im };
                if channel.is_none_or(|c| c == k / 2) {
                    time[row] * part
                } else {
                    0.0
                }
            });
            let weighted = times(&self.weights[row], &column);
            along += dot6(&weighted, &linear.residual);
            square += dot6(&weighted, &column);
            for (j, x) in &linear.columns {
                cross[*j] += dot6(&weighted, x);
            }
        }
        let n = cross.len();
        let taken: f64 = (0..n)
            .filter(|&i| cross[i] != 0.0)
            .map(|i| {
                let sum: f64 = (0..n).map(|j| self.covariance(i, j) * cross[j]).sum();
                cross[i] * sum
            })
            .sum();
        let left = square - taken;
        (left > 1e-9 * square && left > 0.0).then(|| (along / left, 1.0 / left))
    }
}
