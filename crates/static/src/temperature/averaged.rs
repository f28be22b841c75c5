//! A linear model, or alternatives of one, fitted under every noise of a grid and averaged by evidence.

use super::correlated_noise::Noise;
use proofmass_core::Error;
use proofmass_uncertainty::adjustment::{cholesky, solve};

/// Estimates of one model, averaged over the noises.
#[derive(Clone, Debug)]
pub(super) struct Averaged {
    pub(crate) estimate: Vec<f64>,
    /// p × p: within the noises and between them.
    pub(crate) covariance: Vec<f64>,
    /// Degrees of freedom of its scale: independent values less parameters, averaged like the rest.
    pub(crate) dof: f64,
    /// Log-likelihood (not restricted) of the best noise: what orders are compared by.
    pub(crate) log_likelihood: f64,
    /// Weight of each alternative, over all noises.
    pub(crate) alternatives: Vec<f64>,
    /// The noise with the largest weight.
    pub(crate) noise: usize,
}

impl Averaged {
    /// The alternative with the largest weight.
    pub fn best(&self) -> usize {
        let weights = self.alternatives.iter().enumerate();
        weights
            .max_by(|a, b| a.1.total_cmp(b.1))
            .map_or(0, |(index, _)| index)
    }
}

/// One alternative under one noise.
struct Run {
    estimate: Vec<f64>,
    covariance: Vec<f64>,
    /// ln of the restricted likelihood with the weight before the data, and of the full one.
    restricted: f64,
    full: f64,
    dof: f64,
    /// Which alternative, and which noise.
    design: usize,
    noise: usize,
}

/// `designs`: alternatives of p columns of n values each, the coefficients of which mean the same.
pub(super) fn fit(
    designs: &[Vec<Vec<f64>>],
    y: &[f64],
    noises: &[Noise],
) -> Result<Averaged, Error> {
    let (n, p) = (y.len(), designs.first().map_or(0, Vec::len));
    if n < p + 3 {
        return Err(Error::TooFew {
            name: "blocks of a temperature sweep",
            needed: p + 3,
            got: n,
        });
    }
    let mut runs = Vec::with_capacity(noises.len() * designs.len());
    let seen: Vec<Vec<f64>> = noises.iter().map(|noise| noise.whiten(y)).collect();
    let pairs = designs.iter().enumerate();
    for ((design, columns), (index, noise)) in
        pairs.flat_map(|d| noises.iter().enumerate().map(move |noise| (d, noise)))
    {
        let x: Vec<Vec<f64>> = columns.iter().map(|c| noise.whiten(c)).collect();
        let y = &seen[index];
        let mut normal = vec![0.0; p * p];
        let mut right = vec![0.0; p];
        for a in 0..p {
            right[a] = x[a].iter().zip(y).map(|(u, v)| u * v).sum();
            for b in 0..=a {
                normal[a * p + b] = x[a].iter().zip(&x[b]).map(|(u, v)| u * v).sum();
            }
        }
        if cholesky(&mut normal, p).is_none() {
            continue;
        }
        solve(&normal, &mut right);
        let residual: f64 = (0..n)
            .map(|i| {
                let model: f64 = (0..p).map(|a| x[a][i] * right[a]).sum();
                (y[i] - model).powi(2)
            })
            .sum();
        // Exact data leave nothing to weigh by: rounding of the outputs bounds it.
        let residual = residual.max(1e-30);
        let log_normal: f64 = (0..p).map(|a| 2.0 * normal[a * p + a].ln()).sum();
        let (nf, df) = (n as f64, (n - p) as f64);
        let restricted =
            noise.weight.ln() - 0.5 * (df * residual.ln() + noise.log_determinant + log_normal);
        let full = -0.5 * (nf * (residual / nf).ln() + noise.log_determinant);
        // E of a scaled inverse χ²: the variance of Student's t, so that the mixture has the right second moment.
        let variance = residual / (df - 2.0).max(1.0);
        let mut covariance = vec![0.0; p * p];
        for a in 0..p {
            let mut unit = vec![0.0; p];
            unit[a] = variance;
            solve(&normal, &mut unit);
            covariance[a * p..(a + 1) * p].copy_from_slice(&unit);
        }
        let own = (noise.effective - p as f64).max(2.0);
        runs.push(Run {
            estimate: right,
            covariance,
            restricted,
            full,
            dof: own,
            design,
            noise: index,
        });
    }
    let best = runs
        .iter()
        .map(|r| r.restricted)
        .fold(f64::NEG_INFINITY, f64::max);
    if !best.is_finite() {
        return Err(Error::Unobservable {
            parameter: "temperature coefficient",
            condition: f64::INFINITY,
        });
    }
    let weights: Vec<f64> = runs.iter().map(|r| (r.restricted - best).exp()).collect();
    let parts = runs
        .iter()
        .map(|r| (r.estimate.as_slice(), r.covariance.as_slice()));
    let (estimate, covariance) = mixture(parts, &weights, p);
    let total: f64 = weights.iter().sum();
    let dof = runs
        .iter()
        .zip(&weights)
        .map(|(r, w)| w / total * r.dof)
        .sum();
    let mut alternatives = vec![0.0; designs.len()];
    for (run, w) in runs.iter().zip(&weights) {
        alternatives[run.design] += w / total;
    }
    Ok(Averaged {
        alternatives,
        noise: runs
            .iter()
            .max_by(|a, b| a.restricted.total_cmp(&b.restricted))
            .map_or(0, |r| r.noise),
        estimate,
        covariance,
        dof,
        log_likelihood: runs
            .iter()
            .map(|r| r.full)
            .fold(f64::NEG_INFINITY, f64::max),
    })
}

/// Mean and covariance of a mixture: within its parts and between them.
fn mixture<'a>(
    parts: impl Iterator<Item = (&'a [f64], &'a [f64])> + Clone,
    weights: &[f64],
    p: usize,
) -> (Vec<f64>, Vec<f64>) {
    let total: f64 = weights.iter().sum();
    let mut mean = vec![0.0; p];
    for ((x, _), w) in parts.clone().zip(weights) {
        for a in 0..p {
            mean[a] += w / total * x[a];
        }
    }
    let mut covariance = vec![0.0; p * p];
    for ((x, c), w) in parts.zip(weights) {
        for a in 0..p {
            for b in 0..p {
                covariance[a * p + b] +=
                    w / total * (c[a * p + b] + (x[a] - mean[a]) * (x[b] - mean[b]));
            }
        }
    }
    (mean, covariance)
}
