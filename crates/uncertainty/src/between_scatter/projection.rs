//! Weighted least squares at one solution: gain, projection of the residuals, and what they say of the variances.

use super::NoiseDof;
use proofmass_core::Error;
use proofmass_core::numeric::dot;

/// G = (JᵀWJ)⁻¹JᵀW and the squares of P = W − WJ(JᵀWJ)⁻¹JᵀW.
pub(super) struct Projection {
    /// p × n by rows.
    pub(crate) gain: Vec<f64>,
    /// P_ij², n × n by rows.
    squares: Vec<f64>,
    /// tr P².
    pub(crate) information: f64,
    n: usize,
    p: usize,
}

/// Columns whose part outside the span of the others is smaller than this share of them are not determined.
const RANK: f64 = 1e-11;

impl Projection {
    /// √W J = Q R by Gram–Schmidt, twice, which keeps Q orthogonal to rounding.
    pub fn new(jacobian: &[f64], variances: &[f64], excess: f64) -> Result<Self, Error> {
        let n = variances.len();
        let p = jacobian.len() / n;
        if p == 0 || jacobian.len() != n * p {
            return Err(Error::Length {
                name: "Jacobian",
                expected: n * p.max(1),
                got: jacobian.len(),
            });
        }
        proofmass_core::check::finite("Jacobian", jacobian)?;
        let root: Vec<f64> = variances
            .iter()
            .map(|v| (v + excess).sqrt().recip())
            .collect();
        let mut q: Vec<Vec<f64>> = Vec::with_capacity(p);
        let mut r = vec![0.0; p * p];
        for c in 0..p {
            let mut column: Vec<f64> = (0..n).map(|i| jacobian[i * p + c] * root[i]).collect();
            let before = dot(&column, &column).sqrt();
            for _ in 0..2 {
                for (k, other) in q.iter().enumerate() {
                    let share = dot(other, &column);
                    r[k * p + c] += share;
                    for (x, o) in column.iter_mut().zip(other) {
                        *x -= share * o;
                    }
                }
            }
            let norm = dot(&column, &column).sqrt();
            if !(norm > RANK * before) {
                return Err(Error::Singular {
                    name: "equations of the fit",
                    condition: before / norm,
                });
            }
            r[c * p + c] = norm;
            column.iter_mut().for_each(|x| *x /= norm);
            q.push(column);
        }
        // R G = Qᵀ √W by back substitution.
        let mut gain = vec![0.0; p * n];
        for i in 0..n {
            for c in (0..p).rev() {
                let rest: f64 = (c + 1..p).map(|k| r[c * p + k] * gain[k * n + i]).sum();
                gain[c * n + i] = (q[c][i] * root[i] - rest) / r[c * p + c];
            }
        }
        let mut squares = vec![0.0; n * n];
        let mut information = 0.0;
        for i in 0..n {
            for j in 0..n {
                let hat: f64 = q.iter().map(|q| q[i] * q[j]).sum();
                let element = (if i == j { 1.0 - hat } else { -hat }) * root[i] * root[j];
                squares[i * n + j] = element * element;
                information += element * element;
            }
        }
        Ok(Self {
            gain,
            squares,
            information,
            n,
            p,
        })
    }

    /// G y.
    pub fn estimates(&self, y: &[f64]) -> Vec<f64> {
        self.gain.chunks(self.n).map(|row| dot(row, y)).collect()
    }

    /// GΣGᵀ and τ²GGᵀ.
    pub fn parts(&self, variances: &[f64], excess: f64) -> (Vec<f64>, Vec<f64>) {
        let (n, p) = (self.n, self.p);
        let (mut noise, mut between) = (vec![0.0; p * p], vec![0.0; p * p]);
        for a in 0..p {
            for b in 0..=a {
                let (g, h) = (
                    &self.gain[a * n..(a + 1) * n],
                    &self.gain[b * n..(b + 1) * n],
                );
                let weighted: f64 = (0..n).map(|i| g[i] * h[i] * variances[i]).sum();
                let plain = excess * dot(g, h);
                for place in [a * p + b, b * p + a] {
                    (noise[place], between[place]) = (weighted, plain);
                }
            }
        }
        (noise, between)
    }

    /// m_c = 2u⁴ / var(u²): how well the residuals, and the knowledge of the noise, fix the variance of each parameter.
    pub fn component_dof(&self, variances: &[f64], excess: f64, dof: &NoiseDof) -> Vec<f64> {
        let n = self.n;
        let shares: Vec<f64> = self
            .squares
            .chunks(n)
            .map(|row| row.iter().sum::<f64>() / self.information)
            .collect();
        let rows = self.gain.chunks(n);
        rows.map(|g| {
            let a = dot(g, g);
            let variance: f64 = (0..n).map(|i| g[i] * g[i] * (variances[i] + excess)).sum();
            let leverage = |i: usize| (g[i] * g[i] - a * shares[i]) * variances[i];
            let noise: f64 = match dof {
                NoiseDof::Known => 0.0,
                NoiseDof::Each(each) => (0..n)
                    .map(|i| 2.0 * leverage(i).powi(2) / each[i].get())
                    .sum(),
                NoiseDof::Pooled(nu) => 2.0 * (0..n).map(leverage).sum::<f64>().powi(2) / nu.get(),
            };
            2.0 * variance * variance / (2.0 * a * a / self.information + noise)
        })
        .collect()
    }
}
