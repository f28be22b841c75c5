//! Step response: an oscillator fitted to a record, and what is read from it.

use crate::findings;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_signal::sine::dominant_frequency;
use proofmass_uncertainty::adjustment::{Equations, cholesky, descend, solve};
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding, Influence,
    Severity,
};
use std::f64::consts::{PI, TAU};

/// Response of an oscillator to a step, as a share of its final value, t seconds after the step.
///
/// 1 − e^{−ζω t}(cos ω_d t + ζ/√(1 − ζ²) sin ω_d t), ω_d = ω√(1 − ζ²), continued to ζ ≥ 1.
///
/// ```
/// use proofmass_dynamic::step::step_response;
/// assert!((step_response(0.5, 1.0, 0.0) - 2.0).abs() < 1e-12);
/// assert!((step_response(0.25, 1.0, 1.0) - (1.0 - (-1.570_796_3f64).exp() * 2.570_796_3)).abs() < 1e-7);
/// ```
pub fn step_response(t: f64, frequency: f64, damping: f64) -> f64 {
    if t <= 0.0 {
        return 0.0;
    }
    let w = TAU * frequency;
    // One formula on either side of ζ = 1: the root is imaginary there.
    let d = Complex64::new(1.0 - damping * damping, 0.0).sqrt();
    let angle = d * w * t;
    // e^{−ζωt} cosh overflows before it decays: the two exponentials are taken apart.
    let decay = -damping * w * t;
    let plus = (Complex64::i() * angle + decay).exp();
    let minus = (-Complex64::i() * angle + decay).exp();
    let cosine = 0.5 * (plus + minus);
    let sine_over_d = if d.norm() * w * t < 1e-4 {
        (w * t) * decay.exp() * Complex64::new(1.0, 0.0)
    } else {
        (plus - minus) / (2.0 * Complex64::i() * d)
    };
    1.0 - (cosine + damping * sine_over_d).re
}

/// A step response as fitted and as read.
///
/// **Uncertainty** of the parameters from the residuals, their autocorrelation included: J⁺ Ω J⁺ᵀ with Ω by Bartlett's window.
///
/// **Errors** [`Error::TooFew`] below 40 samples, [`Error::NotFinite`], [`Error::Constant`], [`Error::NotConverged`].
///
/// **Accuracy** f_n, ζ and height within their 95 % intervals in 120 simulated steps (`coverage_step_parameters`).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StepFit {
    /// `baseline`, `height` (unit of the record), `instant` (s), `frequency` (Hz), `damping`.
    pub estimate: Estimate,
    /// From 10 % to 90 % of the height, s.
    pub rise_time: f64,
    /// Greatest excess over the final value, as a share of the height: e^{−πζ/√(1 − ζ²)}.
    pub overshoot: f64,
    /// From the step until the response stays within 2 % of its final value, s.
    pub settling_time: f64,
    /// Root mean square of the residuals over that of the samples before the step.
    pub residual_ratio: f64,
    /// The fitted record.
    pub fitted: Vec<f64>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl StepFit {
    /// Fits a step to a record, in `unit`, sampled at `rate`.
    ///
    /// # Errors
    /// Those of the type.
    pub fn of(record: &[f64], rate: f64, unit: &str) -> Result<Self, Error> {
        let n = record.len();
        if n < 40 {
            return Err(Error::TooFew {
                name: "samples",
                needed: 40,
                got: n,
            });
        }
        if let Some(index) = record.iter().position(|v| !v.is_finite()) {
            return Err(Error::NotFinite {
                name: "record",
                index,
            });
        }
        if !(rate > 0.0 && rate.is_finite()) {
            return Err(Error::OutOfRange {
                name: "sample rate",
                value: rate,
                min: f64::MIN_POSITIVE,
                max: f64::MAX,
            });
        }
        let tail = (n / 10).max(8);
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len().max(1) as f64;
        let (early, after) = (mean(&record[..8]), mean(&record[n - tail..]));
        let passed = |level: f64| {
            let up = |k: &usize| (record[*k] - level) / (after - level) > 0.5;
            (0..n).find(up).unwrap_or(n / 2)
        };
        // However early it comes.
        let before = mean(&record[..(4 * passed(early) / 5).clamp(4, tail)]);
        let height = after - before;
        if height == 0.0 {
            return Err(Error::Constant {
                name: "record",
                value: before,
            });
        }
        let half = passed(before);
        // Natural units: levels by the height, time by the record, logarithms of what is positive. Each start is looked at where it
        // would be seen, over a dozen of its periods from the step on, on a thinned record; those that come nearest are followed there,
        // and the one that is best on the whole is followed on the whole.
        let length = n as f64 / rate;
        let mut starts: Vec<(f64, [f64; 5], Seen)> = Vec::new();
        let start = |f: f64, damping: f64| {
            [
                before / height,
                1.0,
                (half as f64 / rate - 0.2 / f) / length,
                f64::ln(f * length),
                f64::ln(damping),
            ]
        };
        let mut look = |f: f64| {
            let seen = Seen::of(record, rate, half, f);
            let spread = seen.spread(height);
            for damping in [0.03, 0.15, 0.5, 1.2] {
                let start = start(f, damping);
                if let Ok(e) = seen.equations(height, length, &start) {
                    starts.push((cost(&e) / spread, start, seen.clone()));
                }
            }
        };
        let mut f = 0.5 / length;
        while f < 0.3 * rate {
            look(f);
            f *= 1.6;
        }
        // One that rings says its frequency.
        if let Ok(f) = dominant_frequency(rate, &record[half..]) {
            look(f.max(0.5 / length));
        }
        let rings = starts.len().saturating_sub(4);
        starts[..rings].sort_by(|a, b| a.0.total_cmp(&b.0));
        let misfit = |p: &[f64]| {
            let model = |k: usize| {
                let t = k as f64 / rate - p[2] * length;
                p[0] + p[1] * step_response(t, p[3].exp() / length, p[4].exp())
            };
            let squares = record.iter().enumerate();
            squares
                .map(|(k, y)| (model(k) - y / height).powi(2))
                .sum::<f64>()
        };
        // Noise of a sample, where enough of them come before.
        let quiet = &record[..4 * half / 5];
        let noise = quiet.iter().map(|v| ((v - mean(quiet)) / height).powi(2));
        let noise = noise.sum::<f64>() / quiet.len().max(1) as f64;
        let mut near: Option<(f64, Vec<f64>)> = None;
        for (_, start, seen) in starts[rings..].iter().chain(starts[..rings].iter().take(5)) {
            let on_few = |p: &[f64]| seen.equations(height, length, p);
            let Some((parameters, equations)) = settled(start, on_few) else {
                continue;
            };
            let left = cost(&equations) / seen.samples.len() as f64;
            let misfit = misfit(&parameters);
            if near.as_ref().is_none_or(|b| misfit < b.0) {
                near = Some((misfit, parameters));
                // Nothing but noise is left.
                if quiet.len() >= 32 && left < 1.2 * noise {
                    break;
                }
            }
        }
        let whole = |p: &[f64]| equations(record, rate, height, length, p);
        let best = near.and_then(|(_, start)| settled(&start, whole));
        let Some((p, equations)) = best else {
            return Err(Error::NotConverged {
                name: "step fit",
                iterations: 60,
                step: f64::INFINITY,
            });
        };
        let frequency = p[3].exp() / length;
        let damping = p[4].exp();
        let scale = [height, height, length, frequency, damping];
        let value = [
            p[0] * height,
            p[1] * height,
            p[2] * length,
            frequency,
            damping,
        ];
        let covariance = sandwich(&equations).ok_or(Error::Unobservable {
            parameter: "step.frequency",
            condition: f64::INFINITY,
        })?;
        let mut rows = vec![0.0; 25];
        for a in 0..5 {
            for b in 0..5 {
                rows[a * 5 + b] =
                    0.5 * (covariance[a * 5 + b] + covariance[b * 5 + a]) * scale[a] * scale[b];
            }
        }
        let components = [
            ("baseline", unit),
            ("height", unit),
            ("instant", "s"),
            ("frequency", "Hz"),
            ("damping", "1"),
        ]
        .into_iter()
        .zip(value)
        .map(|((name, unit), v)| Component::new(name, unit, v))
        .collect();
        let estimate = Estimate::new(
            components,
            vec![Influence {
                key: "residuals".into(),
                description: "what the fitted step leaves of the record".into(),
                evaluation: Evaluation::A,
                distribution: "normal".into(),
                dof: DegreesOfFreedom::new((n - 5) as f64).unwrap_or(DegreesOfFreedom::INFINITE),
                effect: Effect::Joint {
                    covariance: Covariance::try_from_rows(5, &rows)?,
                },
            }],
        )?;
        let fitted: Vec<f64> = record
            .iter()
            .zip(&equations.residual)
            .map(|(y, r)| y + r * height)
            .collect();
        let quiet = ((value[2] * rate).max(0.0) as usize).min(n);
        let rms = |v: &mut dyn Iterator<Item = f64>| {
            let (mut sum, mut count) = (0.0, 0usize);
            for x in v {
                sum += x * x;
                count += 1;
            }
            (sum / count.max(1) as f64).sqrt()
        };
        let early = if quiet >= 16 {
            let level = record[..quiet].iter().sum::<f64>() / quiet as f64;
            rms(&mut record[..quiet].iter().map(|v| v - level))
        } else {
            0.0
        };
        let late = rms(&mut equations.residual[quiet..].iter().map(|r| r * height));
        let residual_ratio = if early > 0.0 { late / early } else { 1.0 };
        let mut findings = Vec::new();
        // The ratio of two noise variances from q and n − q samples has a relative spread of √(2/q + 2/(n − q)).
        let spread = (0.5 / quiet.max(1) as f64 + 0.5 / (n - quiet).max(1) as f64).sqrt();
        if early > 0.0 && residual_ratio > 1.0 + 5.0 * spread && late > 1e-3 * height.abs() {
            findings.push(
                findings::model_does_not_describe(
                    "the step response: it is not that of one oscillator",
                    &format!(
                        "residuals {residual_ratio:.2} times the noise before the step, {:.2} % of the height",
                        100.0 * late / height.abs()
                    ),
                    "the step itself may not be one (a slow release), or a second resonance answers",
                )
                .at(Severity::Warning),
            );
        }
        if early == 0.0 {
            findings.push(
                findings::record_starts_late(
                    "it holds too little before the step to know the noise",
                    &format!("{quiet} samples"),
                )
                .at(Severity::Note),
            );
        }
        if frequency * (length - value[2]) < 2.0 {
            findings.push(
                findings::record_ends_early(
                    "the step has settled",
                    &format!(
                        "{:.2} periods after the step",
                        frequency * (length - value[2])
                    ),
                    "final value and damping are extrapolated",
                )
                .at(Severity::Warning),
            );
        }
        let reach = |level: f64| {
            // Monotonic up to its first passage: on a grid of a thousandth of a period.
            (0..)
                .map(|k| f64::from(k) * 1e-3)
                .take_while(|s| *s < 50.0)
                .find(|s| step_response(s / frequency, frequency, damping) >= level)
                .map_or(0.0, |s| s / frequency)
        };
        let settle = (0..20_000)
            .rev()
            .map(|k| f64::from(k) * 1e-3 * (1.0 + 1.0 / damping))
            .find(|s| (step_response(s / frequency, frequency, damping) - 1.0).abs() > 0.02)
            .map_or(0.0, |s| s / frequency);
        Ok(Self {
            rise_time: reach(0.9) - reach(0.1),
            overshoot: if damping < 1.0 {
                (-PI * damping / (1.0 - damping * damping).sqrt()).exp()
            } else {
                0.0
            },
            settling_time: settle,
            residual_ratio,
            fitted,
            estimate,
            findings,
        })
    }
}

/// The part of a record in which a step of some frequency is seen, thinned.
#[derive(Clone)]
struct Seen {
    samples: Vec<f64>,
    rate: f64,
    /// When it begins, s.
    begin: f64,
}

impl Seen {
    /// Samples of it at most.
    const MOST: usize = 600;

    fn of(record: &[f64], rate: f64, half: usize, frequency: f64) -> Self {
        let period = (rate / frequency).ceil() as usize;
        let from = half.saturating_sub(2 * period.max(8));
        let to = half
            .saturating_add(12 * period)
            .max(half + 40)
            .min(record.len());
        let every = (to - from).div_ceil(Self::MOST);
        Self {
            samples: record[from..to].iter().copied().step_by(every).collect(),
            rate: rate / every as f64,
            begin: from as f64 / rate,
        }
    }

    /// Sum of the squared departures from its mean, in heights.
    fn spread(&self, height: f64) -> f64 {
        let mean = self.samples.iter().sum::<f64>() / self.samples.len() as f64;
        let squares = self.samples.iter().map(|v| ((v - mean) / height).powi(2));
        squares.sum::<f64>().max(f64::MIN_POSITIVE)
    }

    fn equations(&self, height: f64, length: f64, p: &[f64]) -> Result<Equations, Error> {
        let mut own = p.to_vec();
        own[2] -= self.begin / length;
        equations(&self.samples, self.rate, height, length, &own)
    }
}

fn equations(
    record: &[f64],
    rate: f64,
    height: f64,
    length: f64,
    p: &[f64],
) -> Result<Equations, Error> {
    const STEP: f64 = 1e-6;
    let model = |p: &[f64], k: usize| {
        let frequency = p[3].exp() / length;
        p[0] + p[1] * step_response(k as f64 / rate - p[2] * length, frequency, p[4].exp())
    };
    let n = record.len();
    let mut equations = Equations {
        residual: Vec::with_capacity(n),
        jacobian: Vec::with_capacity(5 * n),
    };
    if p.iter().any(|v| !v.is_finite()) || p[3] > 20.0 || p[4].abs() > 10.0 {
        return Err(Error::NotConverged {
            name: "step fit",
            iterations: 0,
            step: f64::INFINITY,
        });
    }
    let shifted: Vec<[Vec<f64>; 2]> = (2..5)
        .map(|j| {
            [-STEP, STEP].map(|h| {
                let mut q = p.to_vec();
                q[j] += h;
                q
            })
        })
        .collect();
    for (k, y) in record.iter().enumerate() {
        let value = model(p, k);
        equations.residual.push(value - y / height);
        equations.jacobian.push(1.0);
        equations.jacobian.push((value - p[0]) / p[1]);
        for [low, high] in &shifted {
            equations
                .jacobian
                .push((model(high, k) - model(low, k)) / (2.0 * STEP));
        }
    }
    Ok(equations)
}

fn cost(e: &Equations) -> f64 {
    e.residual.iter().map(|r| r * r).sum()
}

/// Gauss–Newton until the squares fall no further. With a few samples a period the second derivative jumps where the instant passes a
/// sample, so that the last digits of the step need not settle.
fn settled(
    start: &[f64],
    equations: impl Fn(&[f64]) -> Result<Equations, Error>,
) -> Option<(Vec<f64>, Equations)> {
    let mut parameters = start.to_vec();
    let mut here = equations(&parameters).ok()?;
    for _ in 0..60 {
        let mut factor = normal(&here);
        cholesky(&mut factor, P)?;
        let mut step = vec![0.0; P];
        for (row, r) in here.jacobian.chunks_exact(P).zip(&here.residual) {
            step.iter_mut().zip(row).for_each(|(s, j)| *s += j * r);
        }
        solve(&factor, &mut step);
        let before = cost(&here);
        let squares = |e: &Equations, _: &[f64]| cost(e);
        let taken = descend(&parameters, &step, before, 1e-18, &equations, squares).ok()?;
        let fallen = before - cost(&taken.equations);
        if fallen > 0.0 {
            (parameters, here) = (taken.parameters, taken.equations);
        }
        if fallen <= 1e-9 * before {
            return Some((parameters, here));
        }
    }
    None
}

/// Parameters of the fit.
const P: usize = 5;

/// JᵀJ.
fn normal(equations: &Equations) -> Vec<f64> {
    let mut normal = vec![0.0; P * P];
    for row in equations.jacobian.chunks_exact(P) {
        for a in 0..P {
            for b in 0..P {
                normal[a * P + b] += row[a] * row[b];
            }
        }
    }
    normal
}

/// (JᵀJ)⁻¹ JᵀΩJ (JᵀJ)⁻¹ with the residuals' autocovariance under Bartlett's window.
fn sandwich(equations: &Equations) -> Option<Vec<f64>> {
    let n = equations.residual.len();
    let mut factor = normal(equations);
    cholesky(&mut factor, P)?;
    // As many lags as an autocorrelation of some samples needs; far below the length.
    let lags = ((n as f64).powf(1.0 / 3.0) as usize).min(n / 4);
    let r = &equations.residual;
    let autocovariance: Vec<f64> = (0..=lags)
        .map(|l| {
            let sum: f64 = r[l..].iter().zip(r).map(|(a, b)| a * b).sum();
            sum / (n - P) as f64 * (1.0 - l as f64 / (lags + 1) as f64)
        })
        .collect();
    let mut meat = [0.0; P * P];
    for (l, c) in autocovariance.iter().enumerate() {
        for k in l..n {
            let (x, y) = (
                &equations.jacobian[k * P..(k + 1) * P],
                &equations.jacobian[(k - l) * P..(k - l + 1) * P],
            );
            for a in 0..P {
                for b in 0..P {
                    meat[a * P + b] += if l == 0 {
                        c * x[a] * y[b]
                    } else {
                        c * (x[a] * y[b] + y[a] * x[b])
                    };
                }
            }
        }
    }
    // Columns, then rows.
    let mut half = [0.0; P * P];
    for b in 0..P {
        let mut column: Vec<f64> = (0..P).map(|a| meat[a * P + b]).collect();
        solve(&factor, &mut column);
        for a in 0..P {
            half[a * P + b] = column[a];
        }
    }
    let mut result = vec![0.0; P * P];
    for a in 0..P {
        let mut row = half[a * P..(a + 1) * P].to_vec();
        solve(&factor, &mut row);
        result[a * P..(a + 1) * P].copy_from_slice(&row);
    }
    (0..P).all(|a| result[a * P + a] > 0.0).then_some(result)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn record(seed: u64, frequency: f64, damping: f64, pole: f64) -> Vec<f64> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut state = 0.0;
        (0..2000)
            .map(|k| {
                let e: f64 = StandardNormal.sample(&mut rng);
                state = pole * state + (1.0 - pole * pole).sqrt() * e;
                let t = f64::from(k) / 10e3 - 0.040_03;
                0.2 + 3.0 * step_response(t, frequency, damping) + 0.02 * state
            })
            .collect()
    }

    #[test]
    fn coverage_step_parameters() {
        for pole in [0.0, 0.5] {
            let (mut inside, mut doubted) = ([0; 3], 0);
            for seed in 0..60 {
                let fit = StepFit::of(&record(seed, 120.0, 0.2, pole), 10e3, "V").unwrap();
                for (count, (name, truth)) in
                    inside
                        .iter_mut()
                        .zip([("height", 3.0), ("frequency", 120.0), ("damping", 0.2)])
                {
                    let q = fit.estimate.get(name).unwrap();
                    *count += usize::from((q.value - truth).abs() <= q.expanded(0.95));
                }
                doubted += usize::from(!fit.findings.is_empty());
            }
            // 95 % of 60: 51 at least (1e-3).
            assert!(inside.iter().all(|c| *c >= 51), "{pole} {inside:?}");
            assert!(doubted <= 2, "{doubted}");
        }
    }

    #[test]
    fn known_figures_of_steps() {
        let fit = StepFit::of(&record(1, 120.0, 0.2, 0.0), 10e3, "V").unwrap();
        assert!((fit.overshoot - 0.527).abs() < 0.01, "{}", fit.overshoot);
        // 4/(ζω) bounds the settling: 26.5 ms.
        assert!(
            fit.settling_time > 0.018 && fit.settling_time < 0.0275,
            "{}",
            fit.settling_time
        );
        let dull = StepFit::of(&record(1, 120.0, 1.4, 0.0), 10e3, "V").unwrap();
        let zeta = dull.estimate.get("damping").unwrap();
        assert!(
            (zeta.value - 1.4).abs() < 4.0 * zeta.standard_uncertainty && dull.overshoot == 0.0
        );
        // A second resonance that answers as well.
        let two: Vec<f64> = record(1, 120.0, 0.2, 0.0)
            .iter()
            .zip(record(2, 700.0, 0.01, 0.0))
            .map(|(a, b)| a + 0.1 * b)
            .collect();
        let fit = StepFit::of(&two, 10e3, "V").unwrap();
        assert!(
            fit.findings
                .iter()
                .any(|f| f.code() == "model-does-not-describe")
        );
    }

    #[test]
    fn coverage_of_steps_anywhere_and_of_any_frequency() {
        // From four samples a period to a twentieth of a record, early, in the middle and late, at 1 % of noise.
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let (mut inside, mut all) = (0, 0);
        for frequency in [8.0, 50.0, 500.0, 2500.0] {
            for damping in [0.02, 0.2, 0.7] {
                for place in [0.02, 0.3, 0.7] {
                    let record: Vec<f64> = (0..10_000)
                        .map(|k| {
                            let t = f64::from(k) / 10e3 - place;
                            0.2 - 3.0 * step_response(t, frequency, damping) + 0.03 * normal()
                        })
                        .collect();
                    let fit = StepFit::of(&record, 10e3, "V");
                    let fit = fit.unwrap_or_else(|e| panic!("{frequency} {damping} {place}: {e}"));
                    for (name, truth) in [("frequency", frequency), ("damping", damping)] {
                        let q = fit.estimate.get(name).unwrap();
                        all += 1;
                        inside += usize::from((q.value - truth).abs() <= q.expanded(0.95));
                    }
                }
            }
        }
        // 72 intervals: 61 at least (1e-3).
        assert!(all == 72 && inside >= 61, "{inside}");
    }

    #[test]
    fn refuses_what_is_no_step() {
        assert!(StepFit::of(&[1.0; 100], 1.0, "V").is_err());
        assert!(StepFit::of(&[1.0; 10], 1.0, "V").is_err());
        assert!(StepFit::of(&[f64::NAN; 100], 1.0, "V").is_err());
        assert!(StepFit::of(&record(1, 120.0, 0.2, 0.0), 0.0, "V").is_err());
    }
}
