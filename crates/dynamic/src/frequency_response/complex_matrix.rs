//! Small complex matrices by rows: up to three outputs and three axes.

use num_complex::Complex64;

/// A B for A (m × k) and B (k × n).
pub(super) fn product(a: &[Complex64], b: &[Complex64], inner: usize) -> Vec<Complex64> {
    let columns = b.len() / inner;
    a.chunks_exact(inner)
        .flat_map(|row| {
            (0..columns).map(move |j| {
                row.iter()
                    .zip(b.iter().skip(j).step_by(columns))
                    .map(|(x, y)| x * y)
                    .sum()
            })
        })
        .collect()
}

/// (KᴴK + λ² 1)⁻¹ Kᴴ for K with `axes` columns: the inverse of a square K for λ = 0, and never larger than 1/(2λ).
///
/// `None` when it does not exist.
pub(super) fn regularised_inverse(
    k: &[Complex64],
    axes: usize,
    lambda2: f64,
) -> Option<Vec<Complex64>> {
    let outputs = k.len() / axes;
    let adjoint: Vec<Complex64> = (0..axes)
        .flat_map(|j| (0..outputs).map(move |i| k[i * axes + j].conj()))
        .collect();
    let mut normal = product(&adjoint, k, outputs);
    for j in 0..axes {
        normal[j * axes + j] += lambda2;
    }
    solve(normal, adjoint, axes)
}

/// X with A X = B, by elimination with pivots, for a square A of n rows.
pub(super) fn solve(
    mut a: Vec<Complex64>,
    mut b: Vec<Complex64>,
    n: usize,
) -> Option<Vec<Complex64>> {
    let columns = b.len() / n;
    let largest = a.iter().map(|v| v.norm()).fold(0.0, f64::max);
    for c in 0..n {
        let pivot = (c..n).max_by(|&p, &q| a[p * n + c].norm().total_cmp(&a[q * n + c].norm()))?;
        let size = a[pivot * n + c].norm();
        if !(size.is_finite() && size > 1e-14 * largest) {
            return None;
        }
        for j in 0..n {
            a.swap(c * n + j, pivot * n + j);
        }
        for j in 0..columns {
            b.swap(c * columns + j, pivot * columns + j);
        }
        let inverse = 1.0 / a[c * n + c];
        for i in (0..n).filter(|&i| i != c) {
            let factor = a[i * n + c] * inverse;
            for j in c..n {
                let upper = a[c * n + j];
                a[i * n + j] -= factor * upper;
            }
            for j in 0..columns {
                let upper = b[c * columns + j];
                b[i * columns + j] -= factor * upper;
            }
        }
        for j in 0..n {
            a[c * n + j] *= inverse;
        }
        for j in 0..columns {
            b[c * columns + j] *= inverse;
        }
    }
    Some(b)
}

/// Largest singular value of a square matrix of one to three rows: the largest factor by which it lengthens a vector.
///
/// Largest eigenvalue of EᴴE by the roots of its characteristic polynomial.
pub(super) fn spectral_norm(e: &[Complex64], n: usize) -> f64 {
    if n == 1 {
        return e[0].norm();
    }
    let adjoint: Vec<Complex64> = (0..n)
        .flat_map(|j| (0..n).map(move |i| e[i * n + j].conj()))
        .collect();
    let h = product(&adjoint, e, n);
    let trace: f64 = (0..n).map(|i| h[i * n + i].re).sum();
    let mean = trace / n as f64;
    let off: f64 = h.iter().map(|v| v.norm_sqr()).sum::<f64>() - n as f64 * mean * mean;
    if off <= 0.0 {
        return mean.max(0.0).sqrt();
    }
    let largest = if n == 2 {
        mean + (0.5 * off).sqrt()
    } else {
        let p = (off / 6.0).sqrt();
        let b = |i: usize, j: usize| {
            let v = h[i * 3 + j];
            (if i == j { v - mean } else { v }) / p
        };
        let determinant = b(0, 0) * (b(1, 1) * b(2, 2) - b(1, 2) * b(2, 1))
            - b(0, 1) * (b(1, 0) * b(2, 2) - b(1, 2) * b(2, 0))
            + b(0, 2) * (b(1, 0) * b(2, 1) - b(1, 1) * b(2, 0));
        let angle = (0.5 * determinant.re).clamp(-1.0, 1.0).acos() / 3.0;
        mean + 2.0 * p * angle.cos()
    };
    largest.max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_an_inverse_undoes_and_a_norm_is_the_largest_stretch() {
        let k: Vec<Complex64> = (0..9)
            .map(|i| Complex64::new(f64::from((7 * i) % 5), 0.3 * f64::from((3 * i) % 4)))
            .collect();
        let inverse = regularised_inverse(&k, 3, 0.0).unwrap();
        for (i, v) in product(&inverse, &k, 3).iter().enumerate() {
            let one = if i % 4 == 0 { 1.0 } else { 0.0 };
            assert!((v - one).norm() < 1e-12);
        }
        // Against the power iteration.
        let mut x = vec![
            Complex64::new(0.3, 0.1),
            Complex64::new(0.5, -0.2),
            Complex64::new(0.4, 0.7),
        ];
        let mut stretch = 0.0;
        for _ in 0..500 {
            let y = product(&k, &x, 3);
            let adjoint: Vec<Complex64> = (0..3)
                .flat_map(|j| {
                    (0..3).map({
                        let k = &k;
                        move |i| k[i * 3 + j].conj()
                    })
                })
                .collect();
            let norm = |v: &[Complex64]| v.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
            stretch = norm(&y) / norm(&x);
            let z = product(&adjoint, &y, 3);
            let size = norm(&z);
            x = z.iter().map(|v| v / size).collect();
        }
        assert!((spectral_norm(&k, 3) / stretch - 1.0).abs() < 1e-9);
        let two = [
            Complex64::new(3.0, 0.0),
            Complex64::new(0.0, 0.0),
            Complex64::new(0.0, 0.0),
            Complex64::new(0.0, 4.0),
        ];
        assert!((spectral_norm(&two, 2) - 4.0).abs() < 1e-14);
        assert!((spectral_norm(&two[..1], 1) - 3.0).abs() < 1e-14);
    }

    #[test]
    fn law_a_regularised_inverse_is_bounded() {
        for size in [0.0, 1e-6, 1e-3, 0.1, 10.0] {
            let inverse = regularised_inverse(&[Complex64::new(size, 0.0)], 1, 0.01).unwrap();
            assert!(inverse[0].norm() <= 1.0 / (2.0 * 0.1) + 1e-12);
        }
        assert!(regularised_inverse(&[Complex64::new(0.0, 0.0)], 1, 0.0).is_none());
    }
}
