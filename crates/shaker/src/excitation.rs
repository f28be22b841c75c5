//! Directions of the excitation in the device, and the sensitivity by least squares over them.

use super::geometry::Seat;
use super::matrix::Matrix;
use super::observation::{PhasorRow, SpuriousTable};
use faer::Mat;
use num_complex::Complex64;
use proofmass_uncertainty::algebra::solve_complex;

/// Directions of the excitation in the device at the drawn angles, with the spurious motion.
pub(super) fn directions(rows: &[PhasorRow], spurious: &SpuriousTable) -> Vec<[Complex64; 3]> {
    rows.iter()
        .map(|row| {
            let mut e = spurious
                .get(row.configuration.inclination, row.frequency)
                .map_or([Complex64::new(0.0, 0.0); 3], |s| s.ratio);
            e[2] += 1.0;
            let m = Seat::drawn(row.configuration).matrix();
            std::array::from_fn(|i| (0..3).map(|k| e[k] * m[i][k]).sum())
        })
        .collect()
}

/// Least squares over some rows; `None` when they do not span.
pub(super) fn solve(d: &[[Complex64; 3]], y: &[[Complex64; 3]], of: &[usize]) -> Option<Matrix> {
    let mut gram = Mat::<Complex64>::zeros(3, 3);
    let mut right = Mat::<Complex64>::zeros(3, 3);
    for &i in of {
        for a in 0..3 {
            for b in 0..3 {
                gram[(a, b)] += d[i][a].conj() * d[i][b];
                right[(a, b)] += d[i][a].conj() * y[i][b];
            }
        }
    }
    let s = solve_complex(&gram, &right);
    let matrix: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| s[(i, j)]));
    let finite = |z: &Complex64| z.re.is_finite() && z.im.is_finite();
    matrix.iter().flatten().all(finite).then_some(matrix)
}
