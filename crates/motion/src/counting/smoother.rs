//! The smoother of a counted axis.

// Matrix algebra reads by its indices.
#![allow(clippy::needless_range_loop)]

use super::Step;

/// Rauch, Tung and Striebel's smoother on the stored moments.
///
/// **Source** `[RauchTungStriebel65]`.
pub(super) fn smooth(steps: &[Step], unit: f64) -> (Vec<f64>, Vec<f64>) {
    let n = steps.len();
    let (mut v, mut u) = (vec![0.0; n], vec![0.0; n]);
    let Some(last) = steps.last() else {
        return (v, u);
    };
    let (mut x, mut p) = (last.filtered.x, last.filtered.p);
    for k in (0..n).rev() {
        if k + 1 < n {
            let (here, next) = (&steps[k].filtered, &steps[k + 1]);
            // C = P Fᵀ (P⁻)⁻¹, row by row; F = [[1, 1, −½], [0, 1, −1], [0, 0, 1]].
            let pf = here
                .p
                .map(|r| [r[0] + r[1] - 0.5 * r[2], r[1] - r[2], r[2]]);
            let Some(c) = divided(&pf, &next.predicted.p) else {
                (x, p) = (here.x, here.p);
                v[k] = x[1] * unit;
                u[k] = p[1][1].max(0.0).sqrt() * unit;
                continue;
            };
            // The cell's frame moves with the count.
            let mut off: [f64; 3] = std::array::from_fn(|i| x[i] - next.predicted.x[i]);
            off[0] += next.change;
            let gap: [[f64; 3]; 3] =
                std::array::from_fn(|i| std::array::from_fn(|j| p[i][j] - next.predicted.p[i][j]));
            let mut new = here.p;
            for i in 0..3 {
                for j in 0..3 {
                    for l in 0..3 {
                        for m in 0..3 {
                            new[i][j] += c[i][l] * gap[l][m] * c[j][m];
                        }
                    }
                }
            }
            x = std::array::from_fn(|i| here.x[i] + (0..3).map(|j| c[i][j] * off[j]).sum::<f64>());
            p = new;
        }
        v[k] = x[1] * unit;
        u[k] = p[1][1].max(1e-12 * steps[k].filtered.p[1][1]).sqrt() * unit;
    }
    (v, u)
}

/// A B⁻¹ for a covariance B, by Cholesky after its diagonal was scaled to one; `None` when it is singular.
fn divided(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let mut d = [0.0; 3];
    for i in 0..3 {
        if !(b[i][i] > 0.0) {
            return None;
        }
        d[i] = 1.0 / b[i][i].sqrt();
    }
    let mut l = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..=i {
            let mut sum = b[i][j] * d[i] * d[j];
            for k in 0..j {
                sum -= l[i][k] * l[j][k];
            }
            if i == j {
                if !(sum > 1e-14) {
                    return None;
                }
                l[i][i] = sum.sqrt();
            } else {
                l[i][j] = sum / l[j][j];
            }
        }
    }
    Some(std::array::from_fn(|row| {
        let mut y: [f64; 3] = std::array::from_fn(|j| a[row][j] * d[j]);
        for i in 0..3 {
            for k in 0..i {
                y[i] -= l[i][k] * y[k];
            }
            y[i] /= l[i][i];
        }
        for i in (0..3).rev() {
            for k in i + 1..3 {
                y[i] -= l[k][i] * y[k];
            }
            y[i] /= l[i][i];
        }
        std::array::from_fn(|j| y[j] * d[j])
    }))
}
