//! Temperature as a cause of drift: one more form beside the ramp, whose size is the sensitivity.

use crate::coefficients::Limits;
use crate::cosine_spectrum::{Form, cosines, inverse_cosines};
use crate::findings;
use crate::fit_record::FitRecord;
use crate::profile::{Fitted, form_level};
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
    /// First-order lag of the output behind the thermometer, s.
    pub lag: f64,
    /// Correlation of its estimate with that of the ramp, both fitted.
    pub ramp_correlation: Option<f64>,
    /// Frequency in Hz from which on the thermometer shows its own noise, which is left out.
    pub highest_frequency: f64,
    /// Smallest and largest temperature.
    pub range: (f64, f64),
}

impl TemperatureSensitivity {
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
    pub(crate) fn of(record: &FitRecord<'_>, sample_rate: f64, lag: f64) -> Option<Self> {
        let given = record.temperature?;
        let all = || given.iter().flat_map(|s| s.iter().copied());
        let range = (
            all().fold(f64::INFINITY, f64::min),
            all().fold(f64::NEG_INFINITY, f64::max),
        );
        if range.0 >= range.1 {
            return None;
        }
        let samples = lagged(given, &record.starts(), sample_rate, lag);
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

    /// What is known of the sensitivity; `place` and `ramp` are the forms of the fit.
    pub(crate) fn sensitivity(
        &self,
        fitted: &Fitted,
        place: usize,
        ramp: Option<usize>,
        options: &FitOptions,
    ) -> (TemperatureSensitivity, Vec<Finding>) {
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
        let verdict = if collinear {
            Verdict::NotIdentifiable {
                reason: Reason::Collinear,
                estimate: None,
                upper_limit: None,
            }
        } else {
            match fitted.led_by(place).first(level) {
                Some(profile) => limits.verdict(&profile),
                None => Verdict::NotIdentifiable {
                    reason: Reason::OtherTermsSuffice,
                    estimate: None,
                    upper_limit: None,
                },
            }
        };
        let sensitivity = TemperatureSensitivity {
            unit,
            verdict,
            lag: options.temperature_lag,
            ramp_correlation: correlation,
            highest_frequency: self.form.highest.min(f64::MAX),
            range: self.range,
        };
        let findings = self.findings(&sensitivity, collinear);
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

    /// The temperature without the thermometer's noise, about its mean, over every stretch.
    pub(crate) fn courses(&self, sample_rate: f64) -> Vec<Vec<f64>> {
        self.form
            .samples
            .iter()
            .map(|s| {
                let mut c = cosines(s, sample_rate);
                self.form.clear_above(&mut c, sample_rate);
                inverse_cosines(&c, sample_rate)
            })
            .collect()
    }
}

/// The temperature behind a first-order lag; across a gap the last temperature before it is held.
fn lagged(given: &[&[f64]], starts: &[usize], sample_rate: f64, lag: f64) -> Vec<Vec<f64>> {
    if lag <= 0.0 {
        return given.iter().map(|s| s.to_vec()).collect();
    }
    let mut state: Option<(f64, f64, usize)> = None;
    given
        .iter()
        .zip(starts)
        .map(|(stretch, start)| {
            stretch
                .iter()
                .enumerate()
                .map(|(i, t)| {
                    let now = start + i;
                    let value = match state {
                        None => *t,
                        Some((value, before, at)) => {
                            let steps = now.saturating_sub(at) as f64;
                            let kept = (-steps / (lag * sample_rate)).exp();
                            // The temperature goes in a straight line over one sampling interval.
                            let mean = if steps <= 1.0 {
                                0.5 * (before + t)
                            } else {
                                before
                            };
                            mean + (value - mean) * kept
                        }
                    };
                    state = Some((value, *t, now));
                    value
                })
                .collect()
        })
        .collect()
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
