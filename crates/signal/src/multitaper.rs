//! Multitaper densities: several orthogonal windows on the same data.

use crate::welch::{check, one_sided, segment_powers};
use crate::{Density, Detrend};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Family of tapers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Tapers {
    /// Slepian sequences (DPSS) of time–bandwidth product NW; the resolution is ±NW bins.
    Slepian {
        /// Time–bandwidth product NW, usually 2 to 4.
        time_bandwidth: f64,
        /// Number of tapers, at most 2 NW − 1 to keep the side lobes low.
        count: usize,
    },
    /// Sine tapers of Riedel and Sidorenko: closed form, no parameter but their number.
    Sine {
        /// Number of tapers.
        count: usize,
    },
}

/// A multitaper estimate, averaged over segments that follow one another without overlap.
#[doc(alias("DPSS", "Thomson"))]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Multitaper {
    /// Samples per segment; the whole record when equal to its length.
    pub segment: usize,
    /// The tapers.
    pub tapers: Tapers,
    /// Trend removed from every segment.
    pub detrend: Detrend,
}

impl Multitaper {
    /// One-sided density: the mean of the eigenspectra, ν = 2 (tapers) (segments).
    ///
    /// S(f) = 1/K Σ_k 2/rate |Σ_n v_n^{(k)} x_n e^{−2πifn/rate}|² with Σ v² = 1.
    ///
    /// **Units** signal in U, rate in Hz, density in U²/Hz.
    ///
    /// **Errors** as [`Welch::density`](crate::Welch::density), and [`Error::OutOfRange`] for tapers that do not
    /// exist (none, more than 2 NW, NW not in (0, N/2)).
    ///
    /// **Source** `[Percival1993] ch. 7`.
    pub fn density(&self, signal: &[f64], rate: f64) -> Result<Density, Error> {
        let l = self.segment;
        check(signal, rate, l)?;
        let tapers = match self.tapers {
            Tapers::Slepian {
                time_bandwidth,
                count,
            } => slepian(l, time_bandwidth, count)?.0,
            Tapers::Sine { count } => {
                check_count(count, l as f64 / 2.0)?;
                sine_tapers(l, count)
            }
        };
        let segments = signal.len() / l;
        let mut powers = vec![0.0; l / 2 + 1];
        for taper in &tapers {
            let part = segment_powers(signal, taper, l, segments, self.detrend, rate);
            for (sum, value) in powers.iter_mut().zip(part) {
                *sum += value;
            }
        }
        let averages = tapers.len() * segments;
        // Σ_n (Σ_k v_k²/K)² generalises the bandwidth of one window: 1/∫ of the squared mean spectral window.
        let noise_bins = match self.tapers {
            Tapers::Slepian { time_bandwidth, .. } => 2.0 * time_bandwidth,
            Tapers::Sine { count } => count as f64 + 1.0,
        };
        let scale = 1.0 / averages as f64;
        Ok(one_sided(
            powers,
            l,
            rate,
            scale,
            2.0 * averages as f64,
            noise_bins,
            averages,
        ))
    }
}

fn check_count(count: usize, max: f64) -> Result<(), Error> {
    if count == 0 || count as f64 > max {
        return Err(Error::OutOfRange {
            name: "number of tapers",
            value: count as f64,
            min: 1.0,
            max,
        });
    }
    Ok(())
}

/// v_n^{(k)} = √(2/(N+1)) sin(π (k+1)(n+1)/(N+1)). **Source** `[Riedel1995]`.
fn sine_tapers(n: usize, count: usize) -> Vec<Vec<f64>> {
    let last = n as f64 + 1.0;
    (1..=count)
        .map(|k| {
            (1..=n)
                .map(|i| (2.0 / last).sqrt() * (PI * k as f64 * i as f64 / last).sin())
                .collect()
        })
        .collect()
}

/// The first `count` discrete prolate spheroidal sequences of length n and their energy concentrations.
///
/// Eigenvectors of the symmetric tridiagonal matrix with diagonal ((n − 1)/2 − i)² cos 2πW and off-diagonal
/// i(n − i)/2, W = NW/n, that commutes with the concentration problem; each eigenvalue by bisection on the Sturm
/// count, each vector by inverse iteration, O(n) apiece. Sequences have unit energy; symmetric ones a positive
/// sum, antisymmetric ones a positive first lobe.
///
/// **Errors** [`Error::OutOfRange`] for `time_bandwidth` outside (0, n/2) or `count` outside 1 … 2 NW.
///
/// **Accuracy** 1e-9 against SciPy (`crosscheck_scipy_slepian`).
///
/// **Source** `[Slepian1978]`, `[Percival1993] 8.3`.
pub fn slepian(
    n: usize,
    time_bandwidth: f64,
    count: usize,
) -> Result<(Vec<Vec<f64>>, Vec<f64>), Error> {
    if !(time_bandwidth > 0.0 && time_bandwidth < n as f64 / 2.0) {
        return Err(Error::OutOfRange {
            name: "time–bandwidth product",
            value: time_bandwidth,
            min: 0.0,
            max: n as f64 / 2.0,
        });
    }
    check_count(count, (2.0 * time_bandwidth).floor().max(1.0).min(n as f64))?;
    let w = time_bandwidth / n as f64;
    let cosine = (2.0 * PI * w).cos();
    // Divided by n² the entries stay near one and tolerances are absolute.
    let scale = 1.0 / (n as f64 * n as f64);
    let diagonal: Vec<f64> = (0..n)
        .map(|i| (0.5 * (n as f64 - 1.0) - i as f64).powi(2) * cosine * scale)
        .collect();
    let off: Vec<f64> = (1..n).map(|i| 0.5 * (i * (n - i)) as f64 * scale).collect();
    let mut tapers: Vec<Vec<f64>> = Vec::with_capacity(count);
    let mut concentrations = Vec::with_capacity(count);
    for k in 0..count {
        let eigenvalue = kth_largest(&diagonal, &off, k);
        let mut v = inverse_iteration(&diagonal, &off, eigenvalue, k);
        orient(&mut v, k);
        concentrations.push(concentration(&v, w));
        tapers.push(v);
    }
    Ok((tapers, concentrations))
}

/// Number of eigenvalues above x, from the signs of the pivots of T − x.
fn above(diagonal: &[f64], off: &[f64], x: f64) -> usize {
    let mut pivot = diagonal[0] - x;
    let mut count = usize::from(pivot > 0.0);
    for (d, e) in diagonal[1..].iter().zip(off) {
        let safe = if pivot.abs() < 1e-300 { 1e-300 } else { pivot };
        pivot = d - x - e * e / safe;
        count += usize::from(pivot > 0.0);
    }
    count
}

fn kth_largest(diagonal: &[f64], off: &[f64], k: usize) -> f64 {
    // Gershgorin: every row sum is at most one after scaling.
    let (mut low, mut high) = (-2.0_f64, 2.0_f64);
    while high - low > 4.0 * f64::EPSILON * (low.abs() + high.abs()).max(1e-3) {
        let middle = 0.5 * (low + high);
        if middle == low || middle == high {
            break;
        }
        if above(diagonal, off, middle) > k {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Three inverse iterations from a start of the right symmetry, with partial pivoting.
fn inverse_iteration(diagonal: &[f64], off: &[f64], eigenvalue: f64, k: usize) -> Vec<f64> {
    let n = diagonal.len();
    let mut v: Vec<f64> = (0..n)
        .map(|i| (PI * (k as f64 + 1.0) * (i as f64 + 1.0) / (n as f64 + 1.0)).sin())
        .collect();
    for _ in 0..4 {
        solve_shifted(diagonal, off, eigenvalue, &mut v);
        let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v.iter_mut().for_each(|x| *x /= norm);
    }
    v
}

/// Solves (T − λ) x = v in place by Gaussian elimination with row exchanges.
fn solve_shifted(diagonal: &[f64], off: &[f64], lambda: f64, v: &mut [f64]) {
    let n = v.len();
    let mut d: Vec<f64> = diagonal.iter().map(|x| x - lambda).collect();
    let mut upper = off.to_vec();
    upper.push(0.0);
    let mut second = vec![0.0; n];
    for i in 0..n - 1 {
        let below = off[i];
        if below.abs() > d[i].abs() {
            // Exchange rows i and i + 1.
            let factor = d[i] / below;
            let (old_upper, next_d, next_upper) = (upper[i], d[i + 1], upper[i + 1]);
            d[i] = below;
            upper[i] = next_d;
            second[i] = next_upper;
            d[i + 1] = old_upper - factor * next_d;
            upper[i + 1] = -factor * next_upper;
            v.swap(i, i + 1);
            v[i + 1] -= factor * v[i];
        } else {
            let factor = if d[i] == 0.0 { 0.0 } else { below / d[i] };
            d[i + 1] -= factor * upper[i];
            v[i + 1] -= factor * v[i];
        }
    }
    for i in (0..n).rev() {
        let mut x = v[i];
        if i + 1 < n {
            x -= upper[i] * v[i + 1];
        }
        if i + 2 < n {
            x -= second[i] * v[i + 2];
        }
        // A vanishing pivot is what an exact eigenvalue gives; its size only scales the vector.
        let pivot = if d[i].abs() < 1e-18 { 1e-18 } else { d[i] };
        v[i] = x / pivot;
    }
}

fn orient(v: &mut [f64], k: usize) {
    let positive = if k.is_multiple_of(2) {
        v.iter().sum::<f64>() > 0.0
    } else {
        let n = v.len() as f64;
        v.iter()
            .enumerate()
            .map(|(i, x)| (0.5 * (n - 1.0) - i as f64) * x)
            .sum::<f64>()
            > 0.0
    };
    if !positive {
        v.iter_mut().for_each(|x| *x = -*x);
    }
}

/// Share of the energy within ±W: Σ_l 2W sinc(2Wl) r_l with the autocorrelation r of v.
fn concentration(v: &[f64], w: f64) -> f64 {
    let n = v.len();
    let padded = (2 * n).next_power_of_two();
    let autocorrelation = crate::fourier::autocorrelation(v, padded);
    let mut sum = 2.0 * w * autocorrelation[0];
    for (l, r) in autocorrelation.iter().enumerate().take(n).skip(1) {
        sum += 2.0 * r * (2.0 * PI * w * l as f64).sin() / (PI * l as f64);
    }
    sum
}
