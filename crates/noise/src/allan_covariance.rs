//! Covariance between overlapping Allan variances of one record at different averaging times.

use crate::term_density::Process;
use crate::{NoiseModel, Term};
use faer::Mat;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Lags summed one by one; a longer stretch is integrated.
const ONE_BY_ONE: usize = 32;

/// Longest lag at which the covariance of sampled flicker noise is tabulated.
const SAMPLED: usize = 4096;

/// Generalised covariance of the phase of sampled flicker noise at whole lags, up to multiples of l².
///
/// Twice summed V/2 with the variogram of the samples V(h) = Σ_{i≤h} (γ_0 + 2 Σ_{j<i} γ_j), γ_0 = 4/π,
/// γ_h = γ_{h−1} (h − 3/2)/(h + 1/2): the half difference of white noise. Between whole lags, where only quadrature asks, a
/// straight line.
fn sampled_flicker(lag: f64) -> f64 {
    static TABLE: LazyLock<Vec<f64>> = LazyLock::new(|| {
        let mut table = vec![0.0; SAMPLED + 2];
        let (mut gamma, mut within, mut variogram) = (4.0 / PI, 0.0, 0.0);
        for l in 1..=SAMPLED {
            // γ_0 + 2 Σ_{0<j<l} γ_j.
            within += if l == 1 { gamma } else { 2.0 * gamma };
            variogram += within;
            let h = l as f64;
            gamma *= (h - 1.5) / (h + 0.5);
            table[l + 1] = 2.0 * table[l] - table[l - 1] + 0.5 * variogram;
        }
        table
    });
    let below = lag.floor();
    let share = lag - below;
    let at = |i: usize| TABLE.get(i).copied().unwrap_or(0.0);
    let index = below as usize;
    (1.0 - share) * at(index) + share * at(index + 1)
}

/// Nodes and weights of Gauss–Legendre quadrature of eight points on (−1, 1), positive half. **Source** `[AS] table 25.4`.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_650, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887),
    (0.796_666_477_413_627, 0.222_381_034_453_374),
    (0.960_289_856_497_536, 0.101_228_536_290_376),
];

/// Covariance of the Allan variances at `factors` of a record of n rate samples, for unit squares of each pair of terms.
///
/// With D_a(i) = x_{i+2a} − 2 x_{i+a} + x_i the variances are means of D²/2a², and for Gaussian noise
///
/// Cov(σ̂²_a, σ̂²_b) = 1/(2 a² b² M_a M_b) Σ_c W(c) C_ab(c)²,
///
/// C_ab(c) the covariance of D_a and D_b with centres c apart, W(c) the number of such pairs of the M_a and M_b
/// differences in the record. C_ab = Σ w_p w_q G(c + p a − q b) with w = 1, −2, 1 at −1, 0, 1 and the generalised
/// covariance of the phase: −|l|/2 (white), l² ln|l|/2π (flicker), (|l|³ − |l|)/12 (random walk), 1 at zero
/// (quantisation). Being quadratic in the sum of the terms, the covariance of a mixture follows from pairs of terms; a
/// ramp has none. The ends of the record are exact; nothing supposes it long against τ.
///
/// **Shapes** `[t][u]` for u ≤ t, each with a row and a column per factor.
///
/// **Accuracy** the double sum over all pairs within 1 % (`law_every_pair_is_counted_once`), degrees of freedom of
/// `[GR2003]` (`crosscheck_degrees_of_freedom`).
///
/// **Source** `[Greenhall1991]`.
pub(crate) fn allan_covariance(
    terms: &[Process],
    factors: &[usize],
    n: usize,
    sample_rate: f64,
) -> Vec<Vec<Mat<f64>>> {
    let k = factors.len();
    let mut all: Vec<Vec<Mat<f64>>> = (0..terms.len())
        .map(|t| vec![Mat::zeros(k, k); t + 1])
        .collect();
    for i in 0..k {
        for j in 0..=i {
            let (a, b) = (factors[i].max(factors[j]), factors[i].min(factors[j]));
            let pair = Pair {
                a,
                b,
                points: n + 1,
            };
            let sums = pair.sums(terms, sample_rate);
            let (m_a, m_b) = ((n + 1 - 2 * a) as f64, (n + 1 - 2 * b) as f64);
            let scale = 0.5 / ((a as f64 * b as f64).powi(2) * m_a * m_b);
            for (t, row) in all.iter_mut().enumerate() {
                for (u, part) in row.iter_mut().enumerate() {
                    // Both orders of a mixed pair are added by the caller.
                    let value = scale * sums[t][u];
                    part[(i, j)] = value;
                    part[(j, i)] = value;
                }
            }
        }
    }
    all
}

/// Degrees of freedom ν = 2σ⁴/Var of the overlapping Allan variance at factor m of stretches of so many rate samples.
///
/// σ² and its variance are those of the model, ends of the stretches included; stretches are independent. `None` where no
/// stretch is long enough.
pub(crate) fn degrees_of_freedom(
    model: &NoiseModel,
    m: usize,
    lengths: &[usize],
    sample_rate: f64,
) -> Option<f64> {
    let mut processes: Vec<(Process, f64)> = [
        (Term::Quantisation, model.quantisation),
        (Term::White, model.white),
        (Term::Flicker, model.flicker),
        (Term::RandomWalk, model.random_walk),
    ]
    .into_iter()
    .filter(|(_, c)| *c > 0.0)
    .map(|(t, c)| (Process::Power(t), c * c))
    .collect();
    processes.extend(model.gauss_markov.iter().map(|g| {
        (
            Process::Markov(g.correlation_time),
            g.standard_deviation.powi(2),
        )
    }));
    let (terms, squares): (Vec<Process>, Vec<f64>) = processes.into_iter().unzip();
    let mut known: Vec<(usize, f64)> = Vec::new();
    let (mut sum, mut count) = (0.0, 0.0);
    for &n in lengths.iter().filter(|n| **n >= 2 * m) {
        let differences = (n + 1 - 2 * m) as f64;
        let variance = match known.iter().find(|k| k.0 == n) {
            Some(k) => k.1,
            None => {
                let parts = allan_covariance(&terms, &[m], n, sample_rate);
                let mut variance = 0.0;
                for (t, a) in squares.iter().enumerate() {
                    for (u, b) in squares.iter().enumerate() {
                        variance += a * b * parts[t.max(u)][t.min(u)][(0, 0)];
                    }
                }
                known.push((n, variance));
                variance
            }
        };
        sum += differences * differences * variance;
        count += differences;
    }
    let variance = sum / (count * count);
    let sigma2 = model.sampled_allan_variance(m, sample_rate) - ramp_share(model, m, sample_rate);
    let nu = 2.0 * sigma2 * sigma2 / variance;
    (nu.is_finite() && nu > 0.0).then_some(nu)
}

fn ramp_share(model: &NoiseModel, m: usize, sample_rate: f64) -> f64 {
    0.5 * (model.ramp * m as f64 / sample_rate).powi(2)
}

/// Two averaging factors a ≥ b on a record of so many phase points.
struct Pair {
    a: usize,
    b: usize,
    points: usize,
}

impl Pair {
    /// Σ_c W(c) C_t(c) C_u(c) over all lags of either sign.
    fn sums(&self, terms: &[Process], sample_rate: f64) -> Vec<Vec<f64>> {
        let count = terms.len();
        let mut sums: Vec<Vec<f64>> = (0..count).map(|t| vec![0.0; t + 1]).collect();
        let mut add = |lag: f64, weight: f64, c: &[f64]| {
            let w = weight * self.pairs_at(lag);
            for t in 0..count {
                for u in 0..=t {
                    sums[t][u] += w * c[t] * c[u];
                }
            }
        };
        let smooth = |lag: f64| -> Vec<f64> {
            terms
                .iter()
                .map(|&t| self.covariance(t, lag, sample_rate))
                .collect()
        };
        // Between these lags the covariances are smooth; beyond a + b only that of flicker is left, and falls as c⁻².
        let (a, b) = (self.a, self.b);
        let end = self.points - 1 - a - b;
        let mut corners = vec![0, b, a - b, a, a + b];
        corners.extend([2, 4, 8, 16].map(|k| k * (a + b)));
        corners.iter_mut().for_each(|c| *c = (*c).min(end));
        corners.sort_unstable();
        corners.dedup();
        if end == 0 {
            // One difference of each: they meet once.
            add(0.0, 1.0, &smooth(0.0));
        }
        for w in corners.windows(2) {
            let (from, to) = (w[0], w[1]);
            if to - from <= ONE_BY_ONE {
                for lag in from..=to {
                    // Twice for either sign, half at the corners, which two stretches share.
                    let weight = if lag == from || lag == to { 1.0 } else { 2.0 };
                    let lag = lag as f64;
                    add(lag, weight, &smooth(lag));
                }
            } else {
                let half = 0.5 * (to - from) as f64;
                let centre = from as f64 + half;
                for (node, weight) in GAUSS {
                    for lag in [centre - half * node, centre + half * node] {
                        add(lag, 2.0 * half * weight, &smooth(lag));
                    }
                }
            }
        }
        // White noise of the phase correlates at single lags.
        if let Some(q) = terms
            .iter()
            .position(|t| *t == Process::Power(Term::Quantisation))
        {
            for (lag, value) in self.single_lags() {
                let mut c = smooth(lag);
                let w = self.pairs_at(lag);
                c[q] = value * sample_rate * sample_rate;
                for t in 0..count {
                    let (row, column) = (t.max(q), t.min(q));
                    sums[row][column] += w * c[t] * c[q];
                }
            }
        }
        sums
    }

    /// How many pairs of differences have centres this far apart.
    fn pairs_at(&self, lag: f64) -> f64 {
        let fewer = (self.points - 2 * self.a) as f64;
        (fewer - (lag.abs() - (self.a - self.b) as f64).max(0.0)).max(0.0)
    }

    /// Covariance of differences whose centres are `lag` apart, without that of quantisation.
    fn covariance(&self, process: Process, lag: f64, sample_rate: f64) -> f64 {
        // Sampled flicker noise differs from the continuous one over a few samples.
        let near = self.a <= 16 && lag.abs() + (self.a + self.b) as f64 <= SAMPLED as f64;
        let g = |l: f64| match process {
            Process::Power(Term::White) => -0.5 * l * sample_rate,
            Process::Power(Term::Flicker) if near => sampled_flicker(l),
            Process::Power(Term::Flicker) if l > 0.0 => l * l * l.ln() / (2.0 * PI),
            Process::Power(Term::RandomWalk) => (l * l * l - l) / (12.0 * sample_rate),
            Process::Markov(time) => {
                let t = time * sample_rate;
                let u = l / t;
                // −σ²T²(u − 1 + e^{−u}); the series where the terms cancel.
                let v = if u < 1e-3 {
                    0.5 * u * u * (1.0 - u / 3.0)
                } else {
                    u - 1.0 + (-u).exp()
                };
                -t * t * v
            }
            Process::Power(_) => 0.0,
        };
        let (a, b) = (self.a as f64, self.b as f64);
        let row = |shift: f64| {
            g((lag + shift - b).abs()) - 2.0 * g((lag + shift).abs()) + g((lag + shift + b).abs())
        };
        row(-a) - 2.0 * row(0.0) + row(a)
    }

    /// Lags of either sign at which white phase noise correlates, with the covariance of unit variance.
    fn single_lags(&self) -> Vec<(f64, f64)> {
        let (a, b) = (self.a as i64, self.b as i64);
        let mut lags: Vec<(i64, f64)> = Vec::new();
        for (p, wp) in [(-1, 1.0), (0, -2.0), (1, 1.0)] {
            for (q, wq) in [(-1, 1.0), (0, -2.0), (1, 1.0)] {
                let lag = p * a + q * b;
                match lags.iter_mut().find(|l| l.0 == lag) {
                    Some(known) => known.1 += wp * wq,
                    None => lags.push((lag, wp * wq)),
                }
            }
        }
        lags.into_iter().map(|(lag, v)| (lag as f64, v)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EdfFormula, NoiseModel, NoiseType, Statistic, equivalent_dof};

    /// ν = 2σ⁴/Var of one term alone is that of the combined formula of Greenhall and Riley: 2 % for its fits, and 0.8/m
    /// because it averages the phase over the sample interval.
    #[test]
    fn crosscheck_degrees_of_freedom() {
        let terms = [
            Term::Quantisation,
            Term::White,
            Term::Flicker,
            Term::RandomWalk,
        ];
        let types = [
            NoiseType::WhitePhase,
            NoiseType::White,
            NoiseType::Flicker,
            NoiseType::RandomWalk,
        ];
        let n = 4096;
        let factors: Vec<usize> = (0..11).map(|k| 1 << k).collect();
        let covariance = allan_covariance(&terms.map(Process::Power), &factors, n, 1.0);
        for (t, noise) in types.into_iter().enumerate() {
            for (i, &m) in factors.iter().enumerate() {
                if m < 8 {
                    continue;
                }
                let tau = m as f64;
                let variance = match terms[t] {
                    Term::Quantisation => 3.0 / (tau * tau),
                    Term::White => 1.0 / tau,
                    Term::RandomWalk => tau / 3.0 * (1.0 + 0.5 / (tau * tau)),
                    _ => NoiseModel {
                        flicker: 1.0,
                        ..Default::default()
                    }
                    .allan_variance(tau),
                };
                let nu = 2.0 * variance * variance / covariance[t][t][(i, i)];
                let known = equivalent_dof(
                    Statistic::OverlappingAllan,
                    noise,
                    m,
                    n + 1,
                    EdfFormula::Published,
                )
                .unwrap();
                assert!(
                    (nu / known - 1.0).abs() < 0.02 + 0.8 / tau,
                    "{noise:?}, m = {m}: {nu}, published {known}"
                );
            }
        }
    }

    /// Values worked out by an independent program from the variograms.
    #[test]
    fn known_degrees_of_freedom() {
        let model = |white, flicker, random_walk| NoiseModel {
            white,
            flicker,
            random_walk,
            ..Default::default()
        };
        for (model, expected) in [
            (model(1.0, 0.0, 0.0), [45.7677, 9.819_62, 4.000_65]),
            (model(0.0, 1.0, 0.0), [35.5978, 7.586_95, 2.999_40]),
            (model(0.0, 0.0, 1.0), [28.1383, 5.899_09, 2.235_96]),
            (model(1.0, 1.0, 0.01), [35.8287, 7.639_60, 2.953_73]),
        ] {
            for (m, nu) in [256, 1024, 2048].into_iter().zip(expected) {
                let found = degrees_of_freedom(&model, m, &[8192], 1.0).unwrap();
                // Quadrature in place of the sum.
                assert!(
                    (found / nu - 1.0).abs() < 5e-3,
                    "{model:?} {m}: {found} {nu}"
                );
            }
        }
        let mixed = model(1.0, 1.0, 0.01);
        // Every noise counts towards the variance of the others: the terms' own variances lie below the mixture's.
        for m in [1, 4, 8, 16, 17] {
            let single =
                |f: f64, w: f64| degrees_of_freedom(&model(w, f, 0.0), m, &[8192], 1.0).unwrap();
            let (b, w, both) = (single(1.0, 0.0), single(0.0, 1.0), single(1.0, 1.0));
            assert!(
                both < 1.3 * b.max(w) && both > b.min(w),
                "{m}: {b} {w} {both}"
            );
        }
        for (m, expected) in [(256, 0.453_724), (1024, 0.476_382), (2048, 0.510_026)] {
            let found = mixed.sampled_allan_variance(m, 1.0);
            assert!((found / expected - 1.0).abs() < 1e-4, "{m}: {found}");
        }
    }

    /// The double sum over all pairs of differences of a short record.
    #[test]
    fn law_every_pair_is_counted_once() {
        let terms = [
            Term::Quantisation,
            Term::White,
            Term::Flicker,
            Term::RandomWalk,
        ];
        let n = 400;
        for (a, b) in [(1, 1), (2, 1), (30, 30), (40, 3), (64, 32), (60, 44)] {
            let found = allan_covariance(&terms.map(Process::Power), &[a, b], n, 2.0);
            let pair = Pair {
                a,
                b,
                points: n + 1,
            };
            let single = pair.single_lags();
            let (m_a, m_b) = (n + 1 - 2 * a, n + 1 - 2 * b);
            let mut sums = [[0.0; 4]; 4];
            for i in 0..m_a {
                for j in 0..m_b {
                    let lag = (j + b) as f64 - (i + a) as f64;
                    let mut c = terms.map(|t| pair.covariance(Process::Power(t), lag, 2.0));
                    let hit = single.iter().find(|s| s.0 == lag);
                    c[0] = hit.map_or(0.0, |s| 4.0 * s.1);
                    for t in 0..4 {
                        for u in 0..4 {
                            sums[t][u] += c[t] * c[u];
                        }
                    }
                }
            }
            let scale = 0.5 / (((a * b) as f64).powi(2) * (m_a * m_b) as f64);
            for t in 0..4 {
                for u in 0..=t {
                    let expected = scale * sums[t][u];
                    let size = scale * (sums[t][t] * sums[u][u]).sqrt();
                    let got = found[t][u][(0, 1)];
                    // Integrals stand for sums over more than 32 lags; the flicker tail ends at 16 (a + b).
                    assert!(
                        (got - expected).abs() < 0.01 * size,
                        "{a}, {b}: {:?} {:?} {got:e}, {expected:e}",
                        terms[t],
                        terms[u]
                    );
                }
            }
        }
    }
}
