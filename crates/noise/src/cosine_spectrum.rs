//! The record in cosines: the coordinates in which white noise and random walk are independent.

use proofmass_signal::fourier::{self, Complex};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Lowest coefficients that are kept one by one when the record is one stretch.
const SINGLE: usize = 64;

/// Singly kept coefficients of all stretches together, at most (and at least four of each stretch).
const SINGLE_OF_ALL: usize = 4096;

/// Relative width of a bin above.
const WIDTH: f64 = 0.05;

/// Nodes over which a density is averaged within a bin: for 1/f² the midpoint rule is good to 4e-5.
const NODES: usize = 4;

/// One place at which densities are evaluated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    /// Frequency in Hz.
    pub(crate) frequency: f64,
    /// Number of the cosine (half periods in the stretch).
    pub(crate) k: f64,
    /// Samples of the stretch.
    pub(crate) n: f64,
    /// Share in the bin.
    pub(crate) weight: f64,
}

/// Neighbouring cosines together: mean products of the coefficients of the record, of a unit ramp, and of further known forms.
#[derive(Clone, Debug)]
pub(crate) struct Bin {
    /// Mean frequency in Hz.
    pub(crate) frequency: f64,
    /// How many coefficients.
    pub(crate) count: f64,
    /// Mean products x_a x_b at [`pair`]`(a, b)`: x_0 is the record, x_1 a unit ramp, x_2 … the further forms.
    pub(crate) products: Vec<f64>,
    /// Where densities are taken.
    pub(crate) nodes: Vec<Node>,
}

/// Place of a product among the packed lower triangle, a ≥ b.
pub(crate) fn pair(a: usize, b: usize) -> usize {
    let (a, b) = if a < b { (b, a) } else { (a, b) };
    a * (a + 1) / 2 + b
}

impl Bin {
    /// Mean square of the record without a ramp of this slope.
    pub(crate) fn freed_of_ramp(&self, slope: f64) -> f64 {
        let p = &self.products;
        p[0] - 2.0 * slope * p[1] + slope * slope * p[2]
    }
}

/// Cosine spectrum of a record of one or several stretches.
///
/// c_k = √(2/f_s) √(2/n) Σ y_i cos(πk(i+½)/n) for k = 1 … n−1 of each stretch: with white noise and a random walk the
/// c_k are independent with the one-sided density at f_k = k f_s/2n as variance (the Karhunen–Loève coordinates of a
/// walk without its mean), with flicker noise nearly so. Nothing leaks, the lowest cycles are kept, the mean is gone
/// with k = 0, and a ramp is one known vector.
#[derive(Clone, Debug)]
pub(crate) struct CosineSpectrum {
    /// Samples per second.
    pub(crate) sample_rate: f64,
    /// Longest stretch in s.
    pub(crate) longest: f64,
    /// How many forms are known beside the record: the ramp, then what the caller gave.
    pub(crate) forms: usize,
    /// The bins; the single ones first, then by frequency.
    pub(crate) bins: Vec<Bin>,
}

impl CosineSpectrum {
    /// Of stretches without frequencies (from, to); stretches of fewer than three samples tell nothing.
    pub(crate) fn new(stretches: &[&[f64]], sample_rate: f64, without: &[(f64, f64)]) -> Self {
        Self::beside(stretches, &[], sample_rate, without)
    }

    /// Beside forms that are known but for their size, each by its samples over the same stretches.
    pub(crate) fn beside(
        stretches: &[&[f64]],
        forms: &[Form],
        sample_rate: f64,
        without: &[(f64, f64)],
    ) -> Self {
        let long: Vec<usize> = (0..stretches.len())
            .filter(|i| stretches[*i].len() > 2)
            .collect();
        let used: Vec<&[f64]> = long.iter().map(|i| stretches[*i]).collect();
        let single = (SINGLE_OF_ALL / used.len().max(1)).clamp(4, SINGLE);
        let parts: Vec<Vec<Bin>> = long
            .par_iter()
            .map(|&i| {
                let known = forms.iter().map(|f| f.cosines(i, sample_rate)).collect();
                bins_of(stretches[i], known, sample_rate, single, without)
            })
            .collect();
        let mut bins: Vec<Bin> = Vec::new();
        let mut shared: Vec<Bin> = Vec::new();
        for part in parts {
            for bin in part {
                if used.len() > 1 && bin.count > 1.0 {
                    shared.push(bin);
                } else {
                    bins.push(bin);
                }
            }
        }
        bins.extend(pool(shared));
        Self {
            sample_rate,
            longest: used.iter().map(|s| s.len()).max().unwrap_or(0) as f64 / sample_rate,
            forms: 1 + forms.len(),
            bins,
        }
    }

    /// Bins of a record that is not there yet: what is known of its ramp, and nothing of its squares.
    pub(crate) fn of_length(samples: usize, sample_rate: f64) -> Self {
        let bins = spans(samples, SINGLE).map(|(start, end)| {
            let nodes = nodes(start, end, samples, sample_rate);
            // Above the single ones every other cosine of a ramp is zero, and all are small.
            let ramp = match end - start {
                1 => ramp_cosine(start, samples, sample_rate).powi(2),
                _ => {
                    let odd = ((start + end) / 2) | 1;
                    0.5 * ramp_cosine(odd, samples, sample_rate).powi(2)
                }
            };
            Bin {
                frequency: 0.25 * (start + end - 1) as f64 * sample_rate / samples as f64,
                count: (end - start) as f64,
                products: vec![0.0, 0.0, ramp],
                nodes,
            }
        });
        Self {
            sample_rate,
            longest: samples as f64 / sample_rate,
            forms: 1,
            bins: bins.collect(),
        }
    }

    /// Mean over each bin of a density.
    pub(crate) fn average(&self, density: impl Fn(&Node) -> f64) -> Vec<f64> {
        self.bins
            .iter()
            .map(|b| b.nodes.iter().map(|n| n.weight * density(n)).sum())
            .collect()
    }
}

/// Bins of several stretches that lie at the same frequency become one.
fn pool(mut bins: Vec<Bin>) -> Vec<Bin> {
    let cell = |b: &Bin| (b.frequency.ln() / WIDTH).floor() as i64;
    bins.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
    let mut pooled: Vec<Bin> = Vec::new();
    for bin in bins {
        match pooled.last_mut() {
            Some(last) if cell(last) == cell(&bin) => {
                let all = last.count + bin.count;
                let (a, b) = (last.count / all, bin.count / all);
                for (sum, one) in last.products.iter_mut().zip(&bin.products) {
                    *sum = a * *sum + b * one;
                }
                last.nodes.iter_mut().for_each(|n| n.weight *= a);
                last.nodes.extend(bin.nodes.into_iter().map(|n| Node {
                    weight: n.weight * b,
                    ..n
                }));
                // The frequency stays that of the first, so that the cell does not wander.
                last.count = all;
                thin(&mut last.nodes);
            }
            _ => pooled.push(bin),
        }
    }
    pooled
}

/// Many nodes of nearly one frequency become fewer.
fn thin(nodes: &mut Vec<Node>) {
    if nodes.len() < 64 {
        return;
    }
    let halved: Vec<Node> = nodes
        .chunks(2)
        .map(|pair| {
            let weight: f64 = pair.iter().map(|n| n.weight).sum();
            let mean =
                |f: fn(&Node) -> f64| pair.iter().map(|n| n.weight * f(n)).sum::<f64>() / weight;
            Node {
                frequency: mean(|n| n.frequency),
                k: mean(|n| n.k),
                n: mean(|n| n.n),
                weight,
            }
        })
        .collect();
    *nodes = halved;
}

/// A course that is known but for its size, by its samples over every stretch.
#[derive(Clone, Debug)]
pub(crate) struct Form {
    /// Samples of each stretch.
    pub(crate) samples: Vec<Vec<f64>>,
    /// Frequency in Hz from which on it is taken as zero (a thermometer's own noise).
    pub(crate) highest: f64,
}

impl Form {
    pub(crate) fn new(samples: Vec<Vec<f64>>) -> Self {
        Self {
            samples,
            highest: f64::INFINITY,
        }
    }

    fn cosines(&self, stretch: usize, sample_rate: f64) -> Vec<f64> {
        let mut c = cosines(&self.samples[stretch], sample_rate);
        self.clear_above(&mut c, sample_rate);
        c
    }

    /// Without what lies above the highest frequency, about its mean.
    pub(crate) fn quiet(&self, sample_rate: f64) -> Self {
        if self.highest.is_infinite() {
            return self.clone();
        }
        let samples = self.samples.iter().map(|s| {
            let mut c = cosines(s, sample_rate);
            self.clear_above(&mut c, sample_rate);
            inverse_cosines(&c, sample_rate)
        });
        Self {
            samples: samples.collect(),
            highest: self.highest,
        }
    }

    /// Makes the coefficients above the highest frequency zero.
    pub(crate) fn clear_above(&self, c: &mut [f64], sample_rate: f64) {
        let last = 2.0 * self.highest * c.len() as f64 / sample_rate;
        if last + 1.0 < c.len() as f64 {
            c[last as usize + 1..].fill(0.0);
        }
    }
}

/// Bins of one stretch, without the frequencies in `without` (from, to).
fn bins_of(
    rate: &[f64],
    known: Vec<Vec<f64>>,
    sample_rate: f64,
    single: usize,
    without: &[(f64, f64)],
) -> Vec<Bin> {
    let n = rate.len();
    let c = cosines(rate, sample_rate);
    let order = 2 + known.len();
    let mut x = vec![0.0; order];
    let frequency = |k: f64| 0.5 * k * sample_rate / n as f64;
    let clear = |k: usize| {
        let f = frequency(k as f64);
        without.iter().all(|(low, high)| f < *low || f > *high)
    };
    let mut bins = Vec::new();
    for (start, end) in spans(n, single) {
        let mut products = vec![0.0; pair(order, 0)];
        let mut count = 0_usize;
        for k in (start..end).filter(|k| clear(*k)) {
            x[0] = c[k];
            x[1] = ramp_cosine(k, n, sample_rate);
            for (x, form) in x[2..].iter_mut().zip(&known) {
                *x = form[k];
            }
            let mut sums = products.iter_mut();
            for a in 0..order {
                for b in 0..=a {
                    if let Some(sum) = sums.next() {
                        *sum += x[a] * x[b];
                    }
                }
            }
            count += 1;
        }
        if count > 0 {
            let m = count as f64;
            bins.push(Bin {
                frequency: frequency(0.5 * (start + end - 1) as f64),
                count: m,
                products: products.into_iter().map(|s| s / m).collect(),
                nodes: nodes(start, end, n, sample_rate),
            });
        }
    }
    bins
}

/// First cosine of each bin and one past its last.
fn spans(n: usize, single: usize) -> impl Iterator<Item = (usize, usize)> {
    let mut start = 1;
    std::iter::from_fn(move || {
        if start >= n {
            return None;
        }
        let end = if start <= single {
            start + 1
        } else {
            let end = start + ((start as f64 * WIDTH) as usize).max(1);
            // A narrow last bin joins the one before.
            if n - end.min(n) < (end - start) / 2 {
                n
            } else {
                end
            }
        };
        Some((std::mem::replace(&mut start, end), end))
    })
}

/// Where the densities of a bin are taken.
fn nodes(start: usize, end: usize, n: usize, sample_rate: f64) -> Vec<Node> {
    let points = (end - start).min(NODES);
    let step = (end - start) as f64 / points as f64;
    let node = |p: usize| {
        let k = start as f64 + (p as f64 + 0.5) * step - 0.5;
        Node {
            frequency: 0.5 * k * sample_rate / n as f64,
            k,
            n: n as f64,
            weight: 1.0 / points as f64,
        }
    };
    (0..points).map(node).collect()
}

/// The coefficients c_k, k = 0 … n−1 (c_0 means nothing).
///
/// One transform of length n of the samples with even index followed by those with odd index backwards. **Source**
/// `[Makhoul1980]`.
pub(crate) fn cosines(rate: &[f64], sample_rate: f64) -> Vec<f64> {
    let n = rate.len();
    let mean = rate.iter().sum::<f64>() / n as f64;
    let mut folded: Vec<f64> = rate.iter().step_by(2).map(|y| y - mean).collect();
    folded.extend(rate.iter().skip(1).step_by(2).rev().map(|y| y - mean));
    let spectrum = fourier::forward_owned(folded);
    let scale = 2.0 / (sample_rate * n as f64).sqrt();
    let mut c = vec![0.0; n];
    for (k, v) in spectrum.iter().enumerate() {
        let (sin, cos) = (0.5 * PI * k as f64 / n as f64).sin_cos();
        if k < n {
            c[k] = scale * (v.re * cos + v.im * sin);
        }
        if k > 0 && k < n {
            c[n - k] = -scale * (v.im * cos - v.re * sin);
        }
    }
    c
}

/// The samples about their mean that have these coefficients.
///
/// The transform of [`cosines`] backwards: X_k = ½ e^{iπk/2n}(C_k − i C_{n−k}) is that of the folded samples.
pub(crate) fn inverse_cosines(c: &[f64], sample_rate: f64) -> Vec<f64> {
    let n = c.len();
    if n < 2 {
        return vec![0.0; n];
    }
    let scale = 0.5 * (sample_rate * n as f64).sqrt();
    let spectrum = (0..=n / 2)
        .map(|k| {
            if k == 0 {
                return Complex::new(0.0, 0.0);
            }
            let (sin, cos) = (0.5 * PI * k as f64 / n as f64).sin_cos();
            let (a, b) = (scale * c[k], -scale * c[n - k]);
            Complex::new(a * cos - b * sin, a * sin + b * cos)
        })
        .collect();
    let folded = fourier::inverse(spectrum, n).unwrap_or_else(|| vec![0.0; n]);
    let mut rate = vec![0.0; n];
    let half = n.div_ceil(2);
    for (i, v) in folded.into_iter().enumerate() {
        let place = if i < half { 2 * i } else { 2 * (n - i) - 1 };
        rate[place] = v;
    }
    rate
}

/// Coefficient k of the ramp i/f_s: zero for even k.
fn ramp_cosine(k: usize, n: usize, sample_rate: f64) -> f64 {
    if k.is_multiple_of(2) {
        return 0.0;
    }
    // Σ i cos(πk(i+½)/n) = −cos(θ)/(2 sin²θ)·… with θ = πk/2n; in closed form −1/(2 sin²θ)·cos θ.
    let theta = 0.5 * PI * k as f64 / n as f64;
    let sum = -theta.cos() / (2.0 * theta.sin().powi(2));
    2.0 / (sample_rate * n as f64).sqrt() * sum / sample_rate
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn example() -> Vec<f64> {
        (0..64_u32)
            .map(|i| {
                f64::from((7 * i * i + 3 * i) % 17) / 17.0
                    + 0.05 * f64::from(i)
                    + 0.5 * f64::from(i / 23)
            })
            .collect()
    }

    #[test]
    fn known_cosines_of_a_short_record() {
        let c = cosines(&example(), 1.0);
        for (k, expected) in [
            (1, -14.930_364),
            (2, 0.345_367_29),
            (3, -1.686_600_3),
            (4, 0.491_440_44),
        ] {
            assert!((c[k] - expected).abs() < 6e-7, "{k}: {}", c[k]);
        }
        assert!((ramp_cosine(1, 64, 1.0) + 207.484_95).abs() < 6e-6);
        assert!((ramp_cosine(3, 64, 1.0) + 23.035_325).abs() < 6e-7);
    }

    /// The sum itself, for even and odd lengths.
    #[test]
    fn law_cosines_are_the_sum() {
        for n in [9_usize, 10, 31] {
            let y: Vec<f64> = (0..n).map(|i| ((i * i * 7 + 3) % 11) as f64).collect();
            let ramp: Vec<f64> = (0..n).map(|i| i as f64 / 4.0).collect();
            let c = cosines(&y, 4.0);
            for k in 1..n {
                let sum = |y: &[f64]| -> f64 {
                    let scale = 2.0 / (4.0 * n as f64).sqrt();
                    scale
                        * y.iter()
                            .enumerate()
                            .map(|(i, v)| v * (PI * k as f64 * (i as f64 + 0.5) / n as f64).cos())
                            .sum::<f64>()
                };
                assert!((c[k] - sum(&y)).abs() < 1e-12, "{n} {k}");
                assert!(
                    (ramp_cosine(k, n, 4.0) - sum(&ramp)).abs() < 1e-12,
                    "{n} {k}"
                );
            }
        }
    }

    #[test]
    fn law_cosines_come_back() {
        for n in [2_usize, 3, 9, 10, 31] {
            let y: Vec<f64> = (0..n).map(|i| ((i * i * 7 + 3) % 11) as f64).collect();
            let mean = y.iter().sum::<f64>() / n as f64;
            let back = inverse_cosines(&cosines(&y, 4.0), 4.0);
            for (a, b) in y.iter().zip(back) {
                assert!((a - mean - b).abs() < 1e-12, "{n}: {a} {b}");
            }
        }
    }
}
