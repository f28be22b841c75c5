//! Temperature as a cause of drift: one more form beside the ramp, whose size is the sensitivity.

use crate::coefficients::Limits;
use crate::cosine_spectrum::{Form, cosines};
use crate::effects::Effects;
use crate::findings;
use crate::fit_family::{Family, SLACK};
use crate::fit_record::FitRecord;
use crate::profile::{Fitted, form_level, slope_level};
use crate::temperature_lag::{self, LONGEST, Lag};
use crate::{FitOptions, Reason, Verdict};
use proofmass_uncertainty::{Figure, Finding, Severity};
use serde::{Deserialize, Serialize};

/// Mean square of the temperature's cosines, in multiples of the thermometer's noise, below which only that noise is left.
const ABOVE_NOISE: f64 = 4.0;

/// Squared correlation of the temperature's size with that of the ramp beyond which neither is told.
const COLLINEAR: f64 = 0.999;

/// Share of a thermometer's noise in the power of the temperature that is used, from which it is a finding.
const NOISY: f64 = 0.01;

/// Sensitivity of the output to temperature.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TemperatureSensitivity {
    /// Unit, of the rate per kelvin.
    pub unit: String,
    /// The sensitivity with its interval, or why there is none.
    pub verdict: Verdict,
    /// First-order lag of the output behind the thermometer, s: the stated one, or the most likely.
    pub lag: f64,
    /// Limits of the lag where it was found; without an upper one where the record is too short.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lag_interval: Option<(f64, Option<f64>)>,
    /// How far the output was from where the first temperature would have it, U: it settles over the lag.
    #[serde(default)]
    pub(crate) settling: f64,
    /// Correlation of its estimate with that of the ramp, both fitted.
    pub ramp_correlation: Option<f64>,
    /// Frequency in Hz from which on the thermometer shows its own noise, which is left out.
    pub highest_frequency: f64,
    /// Smallest and largest temperature.
    pub range: (f64, f64),
}

impl TemperatureSensitivity {
    /// What is taken out of the record: the sensitivity, or behind a lag too long for the record the most likely one.
    pub(crate) fn taken_off(&self) -> Option<f64> {
        match self.verdict {
            Verdict::NotIdentifiable {
                reason: Reason::LagOpen { .. },
                estimate,
                ..
            } => estimate,
            verdict => verdict.value(),
        }
    }

    pub(crate) fn is_collinear(&self) -> bool {
        matches!(
            self.verdict,
            Verdict::NotIdentifiable {
                reason: Reason::Collinear,
                ..
            }
        )
    }
}

/// The temperature of a record as the fit takes it.
pub(crate) struct Temperature {
    pub(crate) form: Form,
    range: (f64, f64),
    /// Share of the thermometer's noise in the power that is used.
    noise_share: f64,
}

impl Temperature {
    /// `None` when it does not vary beyond its own noise.
    pub(crate) fn of(record: &FitRecord<'_>, sample_rate: f64) -> Option<Self> {
        let given = record.temperature?;
        let all = || given.iter().flat_map(|s| s.iter().copied());
        let range = (
            all().fold(f64::INFINITY, f64::min),
            all().fold(f64::NEG_INFINITY, f64::max),
        );
        if range.0 >= range.1 {
            return None;
        }
        let samples: Vec<Vec<f64>> = given.iter().map(|s| s.to_vec()).collect();
        let longest = samples.iter().max_by_key(|s| s.len())?;
        let c = cosines(longest, sample_rate);
        let squares: Vec<f64> = c.iter().map(|c| c * c).collect();
        let n = squares.len();
        let mean = |from: usize, to: usize| {
            squares[from..to].iter().sum::<f64>() / (to - from).max(1) as f64
        };
        let noise = mean(n / 2, n);
        // From the top downwards to the first half octave that shows more than noise.
        let mut last = n;
        while last > 8 {
            let from = ((last as f64 / std::f64::consts::SQRT_2) as usize).max(1);
            if mean(from, last) > ABOVE_NOISE * noise {
                break;
            }
            last = from;
        }
        let signal: f64 = squares[1..last].iter().sum();
        if last <= 8 && mean(1, last) <= ABOVE_NOISE * noise {
            return None;
        }
        let mut form = Form::new(samples);
        if last < n {
            form.highest = 0.5 * last as f64 * sample_rate / n as f64;
        }
        Some(Self {
            form,
            range,
            noise_share: noise * last as f64 / signal,
        })
    }

    /// The temperature behind a lag, and what settles over it.
    pub(crate) fn behind(&self, record: &FitRecord<'_>, sample_rate: f64, lag: f64) -> Vec<Form> {
        let (_, starts) = record.lengths_and_starts(sample_rate);
        let given = record.temperature.unwrap_or_default();
        temperature_lag::behind(given, &starts, sample_rate, lag, self.form.highest)
    }

    /// What is known of the sensitivity; `place` and `ramp` are the forms of the fit, `settling` the one that stands beside a lag.
    pub(crate) fn sensitivity(
        &self,
        family: &Family,
        (place, settling): (usize, Option<usize>),
        ramp: Option<usize>,
        (lag, span): (&Lag, f64),
        options: &FitOptions,
    ) -> (TemperatureSensitivity, Vec<Finding>) {
        let fitted = &family.fitted;
        let unit = crate::Term::Ramp
            .unit(&options.unit)
            .trim_end_matches("/s")
            .to_owned()
            + "/K";
        let correlation = ramp.and_then(|r| correlation(fitted, place, r));
        let level = form_level(options.probability);
        let limits = Limits {
            needed: form_level(1.0 - options.false_alarm_rate),
            excludes_zero: level,
            forced: false,
            probability: options.probability,
        };
        let collinear = correlation.is_some_and(|r| r * r > COLLINEAR);
        let mut open = false;
        let verdict = if collinear {
            Verdict::NotIdentifiable {
                reason: Reason::Collinear,
                estimate: None,
                upper_limit: None,
            }
        } else {
            let short = LONGEST * span;
            // What a lag must gain to be preferred is no reason to doubt the size behind it.
            let slack = SLACK + temperature_lag::price(f64::INFINITY);
            match family.form(place, level, slack) {
                Some(profiles) => {
                    let (near, all) = (profiles.up_to(short), profiles.up_to(f64::INFINITY));
                    // Behind a longer lag the output may follow by any amount.
                    open = lag.is_open(span)
                        && all.gain > level
                        && (lag.best > short
                            || all.interval.0 < near.interval.0
                            || all.interval.1 > near.interval.1);
                    match open {
                        true => Verdict::NotIdentifiable {
                            reason: Reason::LagOpen {
                                at_least: lag.interval.0,
                            },
                            estimate: Some(near.best),
                            upper_limit: None,
                        },
                        false => limits.verdict(&all),
                    }
                }
                None => Verdict::NotIdentifiable {
                    reason: Reason::OtherTermsSuffice,
                    estimate: None,
                    upper_limit: None,
                },
            }
        };
        let sizes = fitted.likelihood.density(&fitted.best.squares).map(|d| {
            fitted
                .likelihood
                .eliminated(&d, Effects::Restricted)
                .sizes()
        });
        let sensitivity = TemperatureSensitivity {
            unit,
            verdict,
            lag: lag.best,
            lag_interval: options.temperature_lag.is_none().then(|| {
                (
                    lag.interval.0,
                    Some(lag.interval.1).filter(|h| h.is_finite()),
                )
            }),
            settling: sizes
                .zip(settling)
                .and_then(|(s, place)| s.get(place).copied())
                .unwrap_or(0.0),
            ramp_correlation: correlation,
            highest_frequency: self.form.highest.min(f64::MAX),
            range: self.range,
        };
        let mut findings = self.findings(&sensitivity, collinear);
        let needed = slope_level(1.0 - options.false_alarm_rate) + temperature_lag::price(lag.best);
        if open {
            findings.push(findings::temperature_lag_open(
                Figure(lag.interval.0),
                Figure(span),
            ));
        } else if options.temperature_lag.is_none() && lag.gain > needed && !collinear {
            findings.push(findings::temperature_lag_found(
                Figure(lag.best),
                Figure(lag.interval.0),
                Figure(lag.interval.1),
                lag.gain,
                needed,
            ));
        }
        (sensitivity, findings)
    }

    fn findings(&self, found: &TemperatureSensitivity, collinear: bool) -> Vec<Finding> {
        let mut findings = Vec::new();
        match found.ramp_correlation {
            Some(r) if collinear => {
                findings.push(findings::temperature_like_ramp(
                    "not",
                    r,
                    "neither is given",
                ));
            }
            Some(r) if r * r > 0.8 => findings.push(
                findings::temperature_like_ramp("poorly", r, "both intervals allow for it")
                    .at(Severity::Note),
            ),
            _ => {}
        }
        if self.noise_share > NOISY {
            findings.push(proofmass_uncertainty::findings::noisy_thermometer(
                "the temperature coefficient",
                &format!(
                    "by up to {:.0} %, the fraction of noise in the power of the temperature, over a range of {} K",
                    100.0 * (self.noise_share / (1.0 + self.noise_share)).min(1.0),
                    Figure(self.range.1 - self.range.0)
                ),
            ));
        }
        findings
    }
}

/// Correlation of the sizes of two forms in the fit, all others at their best.
fn correlation(fitted: &Fitted, a: usize, b: usize) -> Option<f64> {
    let density = fitted.likelihood.density(&fitted.best.squares)?;
    let information = fitted
        .likelihood
        .with_forms(&[a, b])
        .information_of_forms(&density);
    let r = -information[1] / (information[0] * information[2]).sqrt();
    r.is_finite().then_some(r.clamp(-1.0, 1.0))
}
