//! Square matrices of a few rows.

use std::array::from_fn;

pub(crate) type Square<const N: usize> = [[f64; N]; N];

pub(crate) fn matrix<const N: usize>(of: impl Fn(usize, usize) -> f64) -> Square<N> {
    from_fn(|i| from_fn(|j| of(i, j)))
}

pub(crate) fn product<const N: usize>(a: &Square<N>, b: &Square<N>) -> Square<N> {
    matrix(|i, j| (0..N).map(|k| a[i][k] * b[k][j]).sum())
}

pub(crate) fn sum<const N: usize>(a: &Square<N>, b: &Square<N>) -> Square<N> {
    matrix(|i, j| a[i][j] + b[i][j])
}

/// Inverse of a small matrix by Gauss and Jordan with pivots.
pub(crate) fn inverse<const N: usize>(mut a: Square<N>) -> Option<Square<N>> {
    let largest = a.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    let mut b: Square<N> = matrix(|i, j| f64::from(u8::from(i == j)));
    for i in 0..N {
        let at = (i..N).max_by(|&p, &q| a[p][i].abs().total_cmp(&a[q][i].abs()))?;
        a.swap(i, at);
        b.swap(i, at);
        let pivot = a[i][i];
        if !(pivot.abs() > 1e-12 * largest) {
            return None;
        }
        for j in 0..N {
            a[i][j] /= pivot;
            b[i][j] /= pivot;
        }
        for k in (0..N).filter(|k| *k != i) {
            let factor = a[k][i];
            for j in 0..N {
                a[k][j] -= factor * a[i][j];
                b[k][j] -= factor * b[i][j];
            }
        }
    }
    Some(b)
}
