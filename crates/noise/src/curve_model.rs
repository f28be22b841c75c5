//! Degrees of freedom of a curve under the noise of the record itself, not under a power law read off few points.

use crate::allan_covariance::degrees_of_freedom;
use crate::cosine_spectrum::CosineSpectrum;
use crate::model::{allan_response, term_density};
use crate::phase::{Phase, STEP};
use crate::quick_fit::{POWERS, quick_model};
use crate::{EdfFormula, NoiseModel, NoiseRecord, NoiseType, Statistic, Term, equivalent_dof};

/// Averages, and samples, of which a model is fitted.
const FITTED: usize = 16_384;

/// Averaging factor up to which the model of neighbouring samples serves, in long records.
const SHORT: usize = 64;

/// Points of the integral over frequency that gives the share of each term in a variance.
const GRID: usize = 400;

/// Noise of a record as its curve needs it: one model for short, one for long averaging times.
pub(crate) struct CurveModel {
    short: NoiseModel,
    long: NoiseModel,
    /// What the spectrum shows beside the model for short averaging times: a filter takes degrees of freedom.
    seen: Seen,
    sample_rate: f64,
}

/// A spectrum and the model of it: frequency, number of cosines, density seen and of the model.
type Seen = Vec<(f64, f64, f64, f64)>;

/// Cosines that the model counts for against what is seen.
const TRUST: f64 = 30.0;

impl CurveModel {
    /// Fitted to stretches of phase points; `None` when they are too short or do not vary.
    ///
    /// A long record is fitted twice: 16 384 neighbouring samples for the short averaging times, and as many averages
    /// that span it for the long ones. The cost does not grow with the record.
    pub(crate) fn fit(stretches: &[Phase<'_>], sample_rate: f64) -> Option<Self> {
        let samples: usize = stretches.iter().map(|p| p.len() - 1).sum();
        let factor = match samples.div_ceil(FITTED).max(1) {
            // The phase is at hand at every so many points.
            factor if factor > STEP => factor.next_multiple_of(STEP),
            factor => factor,
        };
        let of = |factor, most| fitted(&averages(stretches, factor, most), sample_rate, factor);
        let ((long, _), (short, seen)) = if factor == 1 {
            let fit = of(1, usize::MAX)?;
            (fit.clone(), fit)
        } else {
            let (long, short) = rayon::join(|| of(factor, usize::MAX), || of(1, FITTED));
            (long?, short?)
        };
        Some(Self {
            short,
            long,
            seen,
            sample_rate,
        })
    }

    /// With a model known for the long averaging times.
    pub(crate) fn with(
        long: &NoiseModel,
        records: &[NoiseRecord<'_>],
        sample_rate: f64,
    ) -> Option<Self> {
        let phases: Vec<Phase<'_>> = records
            .iter()
            .filter(|r| r.len() > 2)
            .filter_map(|r| Phase::new(*r, sample_rate).ok())
            .collect();
        let near = Self::fit(&phases, sample_rate)?;
        let some = long.white + long.flicker + long.random_walk + long.quantisation > 0.0
            || !long.gauss_markov.is_empty();
        some.then(|| Self {
            long: long.clone(),
            ..near
        })
    }

    fn at(&self, m: usize) -> &NoiseModel {
        if m <= SHORT { &self.short } else { &self.long }
    }

    /// ν of a statistic at factor m from stretches of so many rate samples.
    ///
    /// OADEV: exactly, from the covariance of all its differences. Others: with p_t the share of term t in the variance and
    /// ν_t the published degrees of freedom for that noise alone, 1/√ν = Σ p_t/√ν_t, as if the terms' estimates were
    /// fully correlated.
    pub(crate) fn dof(
        &self,
        statistic: Statistic,
        m: usize,
        lengths: &[usize],
        formula: EdfFormula,
    ) -> Option<f64> {
        let model = self.at(m);
        let filtered = self.filtered(m);
        if statistic == Statistic::OverlappingAllan {
            return degrees_of_freedom(model, m, lengths, self.sample_rate).map(|nu| nu * filtered);
        }
        let shares = shares(model, statistic, m, self.sample_rate);
        let of = |n: usize| -> Option<f64> {
            let mut root = 0.0;
            for (term, share) in POWERS.into_iter().zip(shares) {
                if share > 1e-6 {
                    let nu = equivalent_dof(statistic, noise_type(term), m, n + 1, formula)?;
                    root += share / nu.sqrt();
                }
            }
            (root > 0.0).then(|| 1.0 / (root * root))
        };
        let longest = lengths.iter().max()?;
        let smallest = statistic.points_needed(m);
        let all: Vec<f64> = lengths
            .iter()
            .filter(|n| **n + 1 >= smallest)
            .filter_map(|n| of(*n))
            .collect();
        let nu = if all.is_empty() {
            of(*longest)
        } else {
            Some(all.iter().sum())
        };
        nu.map(|nu| nu * filtered)
    }

    /// Degrees of freedom at factor m of the spectrum that is seen, relative to those of the model.
    ///
    /// Of a long record ν ∝ (∫ S|H|² df)²/∫ S²|H|⁴ df. Few cosines are believed less than the model: where it holds the ratio is
    /// one.
    fn filtered(&self, m: usize) -> f64 {
        if m > SHORT {
            return 1.0;
        }
        let (mut seen, mut seen2, mut model, mut model2) = (0.0, 0.0, 0.0, 0.0);
        for &(frequency, count, density, expected) in &self.seen {
            let h: f64 = (0..8)
                .map(|j| {
                    let f = frequency * (1.0 + 0.05 * ((f64::from(j) + 0.5) / 8.0 - 0.5));
                    allan_response(m, f.min(0.5 * self.sample_rate), self.sample_rate)
                })
                .sum::<f64>()
                / 8.0;
            let trust = count / (count + TRUST);
            let s = trust * density + (1.0 - trust) * expected;
            seen += count * s * h;
            seen2 += count * s * s * h * h / (1.0 + 2.0 * trust * trust / count);
            model += count * expected * h;
            model2 += count * (expected * h).powi(2);
        }
        let ratio = seen * seen * model2 / (seen2 * model * model);
        if ratio.is_finite() && ratio > 0.0 {
            ratio.clamp(0.01, 1.2)
        } else {
            1.0
        }
    }

    /// The term with the largest share in a statistic at factor m.
    pub(crate) fn dominating(&self, statistic: Statistic, m: usize) -> NoiseType {
        let shares = shares(self.at(m), statistic, m, self.sample_rate);
        POWERS
            .into_iter()
            .zip(shares)
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map_or(NoiseType::White, |(t, _)| noise_type(t))
    }
}

fn noise_type(term: Term) -> NoiseType {
    match term {
        Term::Quantisation => NoiseType::WhitePhase,
        Term::Flicker => NoiseType::Flicker,
        Term::RandomWalk => NoiseType::RandomWalk,
        _ => NoiseType::White,
    }
}

fn fitted(stretches: &[Vec<f64>], sample_rate: f64, factor: usize) -> Option<(NoiseModel, Seen)> {
    let parts: Vec<&[f64]> = stretches.iter().map(Vec::as_slice).collect();
    let varies = parts.iter().any(|s| s.iter().any(|v| *v != s[0]));
    let spectrum = CosineSpectrum::new(&parts, sample_rate / factor as f64, &[]);
    if !varies || spectrum.bins.len() < 8 {
        return None;
    }
    let model = quick_model(&spectrum, factor);
    let some = model.white + model.flicker + model.random_walk + model.quantisation > 0.0;
    some.then(|| {
        let seen = spectrum
            .bins
            .iter()
            .map(|b| {
                let expected = model.density(b.frequency, spectrum.sample_rate);
                (b.frequency, b.count, b.products[0], expected)
            })
            .collect();
        (model, seen)
    })
}

/// Averages of so many samples from each stretch, at most so many from the middle of each.
fn averages(stretches: &[Phase<'_>], factor: usize, most: usize) -> Vec<Vec<f64>> {
    let mut left = most;
    stretches
        .iter()
        .map(|phase| {
            let all = (phase.len() - 1) / factor;
            let count = all.min(left);
            left -= count;
            if count == 0 {
                return Vec::new();
            }
            let first = (all - count) / 2 * factor;
            phase
                .thinned(first, factor, count + 1)
                .windows(2)
                .map(|w| (w[1] - w[0]) / factor as f64)
                .collect()
        })
        .collect()
}

/// Shares of Q, N, B, K in the variance of a statistic at factor m.
fn shares(model: &NoiseModel, statistic: Statistic, m: usize, sample_rate: f64) -> [f64; 4] {
    let squares = [
        model.quantisation.powi(2),
        model.white.powi(2),
        model.flicker.powi(2),
        model.random_walk.powi(2),
    ];
    let (low, high) = (1e-3 / m as f64, 0.5_f64);
    let width = (high / low).ln() / GRID as f64;
    let mut sums = [0.0; 4];
    for i in 0..GRID {
        // Jittered by the golden ratio, so that the oscillation averages out.
        let jitter = (i as f64 * 0.618_033_988_749_895).fract();
        let f = low * ((i as f64 + jitter) * width).exp() * sample_rate;
        let response = response(statistic, m, f, sample_rate) * f * width;
        for ((sum, term), square) in sums.iter_mut().zip(POWERS).zip(squares) {
            *sum += square * term_density(term, f, sample_rate) * response;
        }
    }
    let total: f64 = sums.iter().sum();
    if total > 0.0 {
        sums.map(|s| s / total)
    } else {
        [0.0, 1.0, 0.0, 0.0]
    }
}

/// Response of a variance to a one-sided density.
fn response(statistic: Statistic, m: usize, f: f64, sample_rate: f64) -> f64 {
    let x = std::f64::consts::PI * f / sample_rate;
    let mf = m as f64;
    let window = ((mf * x).sin() / (mf * x.sin())).powi(2);
    let two_sample = allan_response(m, f, sample_rate);
    match statistic {
        Statistic::ModifiedAllan
        | Statistic::Time
        | Statistic::ModifiedTotal
        | Statistic::TimeTotal => two_sample * window,
        Statistic::Hadamard | Statistic::OverlappingHadamard | Statistic::HadamardTotal => {
            two_sample * 4.0 / 3.0 * (mf * x).sin().powi(2)
        }
        _ => two_sample,
    }
}
