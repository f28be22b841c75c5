//! Step response: an oscillator fitted to a record, and what is read from it.

mod first_order;
mod fit;
mod profile;
mod response;
mod starts;
#[cfg(test)]
mod tests;

pub use first_order::FirstOrderStep;
pub use response::{risen_response, step_response};

use crate::findings;
use fit::{P, Samples, Unit, cost, left_out, sandwich, settled};
use proofmass_core::Error;
use proofmass_uncertainty::adjustment::Equations;
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding, Influence,
    Severity, student_quantile,
};
use std::f64::consts::PI;
use std::ops::Range;

/// Places of frequency (by its logarithm) and damping among the parameters.
const FREQUENCY: usize = 3;
const DAMPING: usize = 4;
/// U of the frequency, as a share, from which on it is not stated.
const FREQUENCY_KNOWN: f64 = 0.5;
/// U of the logarithm of the frequency, and of the damping, below which the squares are taken for a parabola.
const NEARLY_LINEAR: f64 = 0.01;

/// A step response as fitted and as read.
///
/// The step may take some time: the variance of its rise is fitted too ([`risen_response`]), and what is not known of it is in the uncertainty
/// of the others. Samples from a twentieth of a period before the instant to a sixth after it are left
/// out of the last fit.
///
/// **Uncertainty** of the parameters from the residuals, their autocorrelation included: J⁺ Ω J⁺ᵀ with Ω by Bartlett's window. Where U of frequency
/// or damping is more than 0.01, the squares are no parabola: U is then the larger distance at which they have grown by as much with all
/// other parameters fitted anew.
///
/// **Assumes** a rise, and filters behind the device, that are short beside the period.
///
/// **Errors** [`Error::TooFew`] below 40 samples, [`Error::Unobservable`] where U of the frequency is half of it or more, [`Error::NotFinite`], [`Error::Constant`], [`Error::NotConverged`].
///
/// **Accuracy** the table of docs/dynamic-tests.md, by the example `step_map` of proofmass-jobs.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StepFit {
    /// `baseline`, `height` (unit of the record), `instant` (s, the middle of the rise), `frequency` (Hz), `damping`.
    pub estimate: Estimate,
    /// From 10 % to 90 % of the height, s.
    pub rise_time: f64,
    /// Greatest excess over the final value, as a share of the height: e^{−πζ/√(1 − ζ²)}.
    pub overshoot: f64,
    /// From the step until the response stays within 2 % of its final value, s; of a swing that is not seen to decay none.
    pub settling_time: Option<f64>,
    /// Root mean square of the residuals over that of the samples before the step.
    pub residual_ratio: f64,
    /// The fitted record.
    pub fitted: Vec<f64>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl StepFit {
    /// The best of the oscillators to which the starts lead on the whole record, with the squares that it leaves.
    fn found(samples: &Samples) -> Option<(f64, Unit, Vec<f64>)> {
        let early = samples.values[..4].iter().sum::<f64>() / 4.0;
        let onset = starts::onset(&samples.values, early);
        let mut best: Option<(f64, Unit, Vec<f64>)> = None;
        for start in starts::starts(samples, onset).iter().take(3) {
            let time = start.unit;
            let fit = settled(&start.parameters, 60, |p| time.equations(samples, p));
            if let Some((p, equations, _)) = fit
                && best.as_ref().is_none_or(|b| cost(&equations) < b.0)
            {
                best = Some((cost(&equations), time, p));
            }
        }
        best
    }

    /// Least squares of an oscillator on the whole record, in squares of the height.
    fn least(samples: &Samples) -> Option<f64> {
        Self::found(samples).map(|(squares, ..)| squares)
    }

    /// Fits a step to a record, in `unit`, sampled at `rate`.
    ///
    /// # Errors
    /// Those of the type.
    pub fn of(record: &[f64], rate: f64, unit: &str) -> Result<Self, Error> {
        let n = record.len();
        let height = checked(record, rate)?;
        let samples = Samples {
            values: record.iter().map(|v| v / height).collect(),
            rate,
            begin: 0.0,
        };
        let best = Self::found(&samples);
        // While it rises the record is that of the rise and the filter; after it any of them is absorbed by instant and variance.
        let best = best.and_then(|(_, time, p)| {
            let rising = time.rising(&samples, &p);
            let without = |p: &[f64]| time.equations(&samples, p).map(|e| left_out(e, &rising));
            let (p, equations, done) = settled(&p, 300, without)?;
            Some((time, p, equations, done))
        });
        // Of one that creeps another fast pole may do as well beside the same slow one.
        let (best, others) = best.map_or((None, Vec::new()), |(time, p, equations, done)| {
            let ((p, equations), others) = creeping(&samples, time, (p, equations));
            (Some((time, p, equations, done)), others)
        });
        let Some((time, p, equations, true)) = best else {
            return Err(Error::NotConverged {
                name: "step fit",
                iterations: 60,
                step: f64::INFINITY,
            });
        };
        let (frequency, damping) = (time.frequency(&p), p[4]);
        let value = [
            p[0] * height,
            p[1] * height,
            time.instant(&p),
            frequency,
            damping,
        ];
        let unobservable = Error::Unobservable {
            parameter: "step.frequency",
            condition: f64::INFINITY,
        };
        let (covariance, inverse, freedom) = sandwich(&equations).ok_or(unobservable)?;
        let t = student_quantile(0.975, freedom);
        let linear = |parameter: usize| t * covariance[parameter * (P + 1)].sqrt();
        let rising = time.rising(&samples, &p);
        let without = |p: &[f64]| time.equations(&samples, p).map(|e| left_out(e, &rising));
        let least = cost(&equations);
        // By how much U is larger than that of a parabola.
        let wider = [FREQUENCY, DAMPING].map(|parameter| {
            let linear = linear(parameter);
            if linear < NEARLY_LINEAR && others.is_empty() {
                return 1.0;
            }
            let growth = linear * linear / inverse[parameter * (P + 1)];
            let [down, up] = profile::reach(&p, least, parameter, growth, linear, without);
            let far = match parameter {
                FREQUENCY => (1.0 - (-down).exp()).max(up.exp_m1()),
                _ => down.max(up),
            };
            // Other minima that the record admits are within U as well.
            let admitted = others
                .iter()
                .filter(|(squares, _)| *squares < least + growth);
            let apart = admitted.map(|(_, other)| match parameter {
                FREQUENCY => (other[FREQUENCY] - p[FREQUENCY]).exp_m1().abs(),
                _ => (other[parameter] - p[parameter]).abs(),
            });
            (apart.fold(far, f64::max) / linear).max(1.0)
        });
        // Records of which most do not determine it answer by chance, and wrongly.
        if !(wider[0] * linear(FREQUENCY) < FREQUENCY_KNOWN && wider[1].is_finite()) {
            return Err(unobservable);
        }
        let mut scale = [height, height, 1.0 / time.frequency, frequency, 1.0];
        scale[FREQUENCY] *= wider[0];
        scale[DAMPING] *= wider[1];
        let stated = value.len();
        let mut rows = vec![0.0; stated * stated];
        for a in 0..stated {
            for b in 0..stated {
                rows[a * stated + b] =
                    0.5 * (covariance[a * P + b] + covariance[b * P + a]) * scale[a] * scale[b];
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
                dof: DegreesOfFreedom::new(freedom).unwrap_or(DegreesOfFreedom::INFINITE),
                effect: Effect::Joint {
                    covariance: Covariance::try_from_rows(stated, &rows)
                        .map_err(|_| unobservable)?,
                },
            }],
        )?;
        let fitted: Vec<f64> = time
            .response(&samples, &p)
            .map(|share| height * (p[0] + p[1] * share))
            .collect();
        let instant = time.instant(&p);
        let length = n as f64 / rate;
        let quiet = ((instant * rate).max(0.0) as usize).min(n);
        let residual: Vec<f64> = equations.residual.iter().map(|r| r * height).collect();
        // The swing says whether it is one of an oscillator; long after it a record says nothing.
        let swing = settling(frequency, damping).unwrap_or(length);
        let swing = quiet..(((instant + swing) * rate).ceil() as usize).min(n);
        let (residual_ratio, mut findings) = misfit(
            record,
            &residual,
            [quiet..n, swing],
            &rising,
            value[1].abs(),
        );
        if quiet < 16 {
            findings.push(
                findings::record_starts_late(
                    "it holds too little before the step to know the noise",
                    &format!("{quiet} samples"),
                )
                .at(Severity::Note),
            );
        }
        let periods = frequency * (length - instant);
        if periods < 2.0 {
            findings.push(
                findings::record_ends_early(
                    "the step has settled",
                    &format!("{periods:.2} periods after the step"),
                    "final value and damping are extrapolated",
                )
                .at(Severity::Warning),
            );
        }
        for (name, words) in [
            ("frequency", "the natural frequency"),
            ("damping", "the damping ratio"),
        ] {
            let relative = estimate
                .get(name)
                .map_or(0.0, |q| q.standard_uncertainty / q.value.abs());
            if relative > 0.2 {
                findings.push(findings::parameter_ill_determined(words, 100.0 * relative));
            }
        }
        let reach = |level: f64| {
            // Monotonic up to its first passage: on a grid of a thousandth of a period.
            (0..)
                .map(|k| f64::from(k) * 1e-3)
                .take_while(|s| *s < 50.0)
                .find(|s| step_response(s / frequency, frequency, damping) >= level)
                .map_or(0.0, |s| s / frequency)
        };
        Ok(Self {
            rise_time: reach(0.9) - reach(0.1),
            overshoot: if damping < 1.0 {
                (-PI * damping / (1.0 - damping * damping).sqrt()).exp()
            } else {
                0.0
            },
            settling_time: settling(frequency, damping),
            residual_ratio,
            fitted,
            estimate,
            findings,
        })
    }
}

/// A fit, and minima beside it with the squares that they leave.
type Beside = ((Vec<f64>, Equations), Vec<(f64, Vec<f64>)>);

/// The best of the minima on a line of one slow pole, and the others: beyond critical damping a fast pole that is gone within a sample is hardly
/// told from another.
fn creeping(samples: &Samples, time: Unit, found: (Vec<f64>, Equations)) -> Beside {
    let (mut best, mut others) = (found, Vec::new());
    let begin = best.0.clone();
    let slow = |z: f64| z - (z * z - 1.0).max(0.0).sqrt();
    let damping = begin[DAMPING];
    let factors: &[f64] = match damping > 0.9 {
        true => &[0.6, 0.8, 1.3, 1.7],
        false => &[],
    };
    let rising = time.rising(samples, &begin);
    let without = |p: &[f64]| time.equations(samples, p).map(|e| left_out(e, &rising));
    for factor in factors {
        let mut start = begin.clone();
        start[DAMPING] = damping * factor;
        start[FREQUENCY] += (slow(damping) / slow(damping * factor)).ln();
        let Some((p, equations, true)) = settled(&start, 100, without) else {
            continue;
        };
        let other = (p, equations);
        let [now, then] = [&best, &other].map(|f| cost(&f.1));
        let (kept, left) = match then < now {
            true => (other, best),
            false => (best, other),
        };
        others.push((cost(&left.1), left.0));
        best = kept;
    }
    // What has come back to the same place is no other minimum.
    let place = best.0.clone();
    others.retain(|(_, p)| (p[DAMPING] - place[DAMPING]).abs() > 1e-3 * place[DAMPING]);
    (best, others)
}

/// What a record departs most from its beginning, with its sign: the scale of the fit.
fn checked(record: &[f64], rate: f64) -> Result<f64, Error> {
    let n = record.len();
    if n < 40 {
        return Err(Error::TooFew {
            name: "samples",
            needed: 40,
            got: n,
        });
    }
    proofmass_core::check::finite("record", record)?;
    proofmass_core::check::positive("sample rate", rate)?;
    let before = record[..4].iter().sum::<f64>() / 4.0;
    let away = record.iter().map(|v| v - before);
    let height = away.fold(
        0.0f64,
        |most, v| if v.abs() > most.abs() { v } else { most },
    );
    if height == 0.0 {
        return Err(Error::Constant {
            name: "record",
            value: before,
        });
    }
    Ok(height)
}

/// Residuals after the step over the noise before it, and whether they are more: over all that follows, or over the swing.
fn misfit(
    record: &[f64],
    residual: &[f64],
    [after, swing]: [Range<usize>; 2],
    rising: &Range<usize>,
    height: f64,
) -> (f64, Vec<Finding>) {
    let quiet = after.start;
    if quiet < 16 || quiet == record.len() {
        return (1.0, Vec::new());
    }
    let level = record[..quiet].iter().sum::<f64>() / quiet as f64;
    let early = record[..quiet].iter().map(|v| (v - level) * (v - level));
    let early = (early.sum::<f64>() / quiet as f64).sqrt();
    if !(early > 0.0) {
        return (1.0, Vec::new());
    }
    let within = |samples: Range<usize>, least: f64| {
        let fitted = samples.filter(|k| !rising.contains(k));
        let (sum, count) = fitted.fold((0.0, 0usize), |(sum, count), k| {
            (sum + residual[k] * residual[k], count + 1)
        });
        let late = (sum / count.max(1) as f64).sqrt();
        // The ratio of two noise variances from q and m samples has a relative spread of √(2/q + 2/m).
        let spread = (0.5 / quiet as f64 + 0.5 / count.max(1) as f64).sqrt();
        (
            late,
            late / early,
            late / early > 1.0 + 5.0 * spread && late > least * height,
        )
    };
    let all = within(after, 1e-3);
    // What the swing is off by a ten-thousandth is a hundredth of the damping.
    let of_swing = within(swing, 1e-4);
    let (late, ratio, off) = if all.2 { all } else { of_swing };
    if !off {
        return (all.1, Vec::new());
    }
    let finding = findings::model_does_not_describe(
        "the step response: it is not that of one oscillator",
        &format!(
            "residuals {ratio:.2} times the noise before the step, {:.2} % of the height",
            100.0 * late / height
        ),
        "the step itself may not be one (a slow release), a second resonance answers, or the output is not linear",
    );
    (ratio, vec![finding.at(Severity::Warning)])
}

/// From the step on until the response stays within 2 %.
fn settling(frequency: f64, damping: f64) -> Option<f64> {
    if !(damping > 0.0) {
        return None;
    }
    (0..20_000)
        .rev()
        .map(|k| f64::from(k) * 1e-3 * (1.0 + 1.0 / damping))
        .find(|s| (step_response(s / frequency, frequency, damping) - 1.0).abs() > 0.02)
        .map(|s| s / frequency)
}
