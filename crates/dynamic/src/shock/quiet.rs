//! The quiet stretch before a pulse: what it says of the noise of anything linear in the samples.

/// Samples of several channels before anything happens, freed from their means.
#[derive(Clone, Debug)]
pub(super) struct Quiet {
    channels: Vec<Vec<f64>>,
    /// Means that were taken away, one per channel.
    pub(super) baseline: Vec<f64>,
}

/// Covariance of linear readings of the noise, one per channel, with its degrees of freedom.
pub(super) struct NoiseCovariance {
    pub(super) covariance: Vec<f64>,
    pub(super) dof: f64,
}

impl Quiet {
    /// Shortest stretch that is one.
    pub(super) const SHORTEST: usize = 16;

    pub(super) fn new(channels: &[&[f64]]) -> Option<Self> {
        let n = channels.iter().map(|c| c.len()).min()?;
        if n < Self::SHORTEST {
            return None;
        }
        let baseline: Vec<f64> = channels
            .iter()
            .map(|c| c[..n].iter().sum::<f64>() / n as f64)
            .collect();
        let channels = channels
            .iter()
            .zip(&baseline)
            .map(|(c, b)| c[..n].iter().map(|v| v - b).collect())
            .collect();
        Some(Self { channels, baseline })
    }

    pub(super) fn len(&self) -> usize {
        self.channels[0].len()
    }

    pub(super) fn channel(&self, channel: usize) -> &[f64] {
        &self.channels[channel]
    }

    /// Covariance of Σ w_k (x_k − baseline) of each channel, `weights` one list per channel, all as long, from the same
    /// weights slid over the quiet stretch: colour and what the channels share are in it. The error of the baselines, means
    /// over n samples, is added as (Σw)² of the long-run variance over n.
    ///
    /// Windows that do not overlap count as independent; of fewer than six nothing is learned, and the samples are then
    /// taken as white.
    pub(super) fn covariance(&self, weights: &[Vec<f64>]) -> NoiseCovariance {
        let (n, m, l) = (self.len(), self.channels.len(), weights[0].len().max(1));
        let sums: Vec<f64> = weights.iter().map(|w| w.iter().sum()).collect();
        let independent = n / l;
        let mut covariance = vec![0.0; m * m];
        let white = |a: usize, b: usize| {
            let product: f64 = self.channels[a]
                .iter()
                .zip(&self.channels[b])
                .map(|(p, q)| p * q)
                .sum();
            product / (n - 1) as f64
        };
        if independent < 6 {
            for a in 0..m {
                for b in 0..m {
                    let shared: f64 = weights[a].iter().zip(&weights[b]).map(|(p, q)| p * q).sum();
                    covariance[a * m + b] = white(a, b) * (shared + sums[a] * sums[b] / n as f64);
                }
            }
            return NoiseCovariance {
                covariance,
                dof: (n - 1) as f64,
            };
        }
        let step = (l / 4).max(1);
        let (mut readings, mut flat) = (Vec::new(), Vec::new());
        for start in (0..=n - l).step_by(step) {
            readings.push(
                (0..m)
                    .map(|a| {
                        let window = &self.channels[a][start..start + l];
                        window.iter().zip(&weights[a]).map(|(x, w)| x * w).sum()
                    })
                    .collect::<Vec<f64>>(),
            );
            flat.push(
                (0..m)
                    .map(|a| self.channels[a][start..start + l].iter().sum())
                    .collect::<Vec<f64>>(),
            );
        }
        let count = readings.len() as f64;
        // The mean was taken from the same stretch: n/l windows leave n/l − 1 of freedom.
        let bessel = independent as f64 / (independent as f64 - 1.0);
        let mean_product = |r: &[Vec<f64>], a: usize, b: usize| {
            r.iter().map(|v| v[a] * v[b]).sum::<f64>() / count * bessel
        };
        for a in 0..m {
            for b in 0..m {
                let long_run = mean_product(&flat, a, b) / l as f64;
                covariance[a * m + b] =
                    mean_product(&readings, a, b) + sums[a] * sums[b] * long_run / n as f64;
            }
        }
        NoiseCovariance {
            covariance,
            dof: (independent - 1) as f64,
        }
    }
}
