//! The lag of the output behind the thermometer, where nobody says it: sought by the likelihood of the coloured model.

use crate::FitOptions;
use crate::averaged_record::{AveragedFit, AveragedRecord, means};
use crate::cosine_spectrum::Form;
use crate::fit_family::ACROSS;
use crate::fit_record::FitRecord;
use crate::profile::form_level;
use crate::temperature_effect::Temperature;

/// Lags tried per decade.
const PER_DECADE: f64 = 6.0;

/// Shortest lag that is tried, as a share of the record; one that is shorter is as good as none.
const SHORTEST: f64 = 1.0 / 1000.0;

/// Longest lag, as a share of the record, behind which a sensitivity is stated.
pub(crate) const LONGEST: f64 = 0.2;

/// Lags per decade at which intervals are taken.
const COARSE: f64 = 3.0;

/// What a lag must gain to be as good as none: about what the best of all, and what settles over it, gain by chance.
pub(crate) fn price(lag: f64) -> f64 {
    if lag > 0.0 { 5.0 } else { 0.0 }
}

/// What the record says of the lag.
#[derive(Clone, Debug)]
pub(crate) struct Lag {
    /// The most likely one, s.
    pub(crate) best: f64,
    /// Its limits; from zero where none is as good, to infinity where the record is too short.
    pub(crate) interval: (f64, f64),
    /// Rise of −2 ln L without a lag.
    pub(crate) gain: f64,
    /// Others that the data admit.
    pub(crate) admitted: Vec<f64>,
}

impl Lag {
    /// One that is known.
    pub(crate) fn given(lag: f64) -> Self {
        Self {
            best: lag,
            interval: (lag, lag),
            gain: 0.0,
            admitted: Vec::new(),
        }
    }

    /// Seeks it beside all noise terms.
    pub(crate) fn seek(
        record: &FitRecord<'_>,
        temperature: &Temperature,
        sample_rate: f64,
        options: &FitOptions,
    ) -> Self {
        let averages = AveragedRecord::of(record, &[], sample_rate);
        let Some(fit) = AveragedFit::new(&averages, options) else {
            return Self::given(0.0);
        };
        let given: Vec<Vec<f64>> = record
            .temperature
            .unwrap_or_default()
            .iter()
            .map(|s| means(s, averages.factor))
            .collect();
        let given: Vec<&[f64]> = given.iter().map(Vec::as_slice).collect();
        let value = |lag: f64| -> f64 {
            let forms = behind(
                &given,
                &averages.starts,
                averages.sample_rate,
                lag,
                temperature.form.highest,
            );
            fit.least(&averages, &forms)
                .map_or(f64::INFINITY, |m| m.value + price(lag))
        };
        let shortest = SHORTEST * averages.span;
        let decades = -SHORTEST.log10();
        let count = (decades * PER_DECADE) as usize;
        let place = |i: usize| shortest * 10_f64.powf(decades * i as f64 / count as f64);
        let none = value(0.0);
        let mut tried: Vec<(f64, f64)> = vec![(0.0, none)];
        tried.extend((0..=count).map(|i| (place(i), value(place(i)))));
        let Some(&(mut best, mut least)) = tried.iter().min_by(|a, b| a.1.total_cmp(&b.1)) else {
            return Self::given(0.0);
        };
        let mut step = 10_f64.powf(0.5 / PER_DECADE);
        for _ in 0..5 {
            if best > 0.0 {
                for lag in [best * step, best / step] {
                    let v = value(lag);
                    if v < least && lag <= averages.span {
                        (best, least) = (lag, v);
                    }
                }
            }
            step = step.sqrt();
        }
        let level = form_level(options.probability);
        // The outermost lag tried that is admitted, and where beyond it the likelihood leaves the level.
        let edge = |inside: f64, outside: f64| -> f64 {
            let (mut inside, mut outside) =
                (inside.max(0.3 * shortest), outside.max(0.3 * shortest));
            for _ in 0..5 {
                let middle = (inside * outside).sqrt();
                if value(middle) - least <= level {
                    inside = middle;
                } else {
                    outside = middle;
                }
            }
            outside
        };
        let admitted = |v: f64| v - least <= level;
        let near = |k: usize| tried[k].0;
        let first = tried.iter().position(|t| admitted(t.1) || t.0 > best);
        let low = match first {
            Some(0) => 0.0,
            Some(k) => edge(near(k).min(best), near(k - 1)),
            None => best,
        };
        let last = tried.iter().rposition(|t| admitted(t.1) || t.0 < best);
        let high = match last {
            Some(k) if k + 1 == tried.len() => f64::INFINITY,
            Some(k) => edge(near(k).max(best), near(k + 1)),
            None => best,
        };
        Self {
            best,
            interval: (low, high),
            gain: none - least + price(best),
            admitted: others(best, (low, high), shortest, averages.span),
        }
    }

    /// Whether the record is too short for it.
    pub(crate) fn is_open(&self, span: f64) -> bool {
        self.interval.1 > LONGEST * span
    }
}

/// Lags over an interval, without the best.
fn others(best: f64, (low, high): (f64, f64), shortest: f64, span: f64) -> Vec<f64> {
    let (from, to) = (low.max(shortest), high.min(span));
    let mut lags: Vec<f64> = Vec::new();
    if low <= 0.0 {
        lags.push(0.0);
    }
    if (to / from).log10() * COARSE > ACROSS.len() as f64 {
        let count = ((to / from).log10() * COARSE).ceil() as usize;
        lags.extend((0..=count).map(|i| from * (to / from).powf(i as f64 / count as f64)));
    } else if to > from {
        for share in ACROSS {
            let end: f64 = if share < 0.0 { from } else { to };
            if best > 0.0 {
                lags.push(best * (end / best).powf(share.abs()));
            }
        }
        if best <= 0.0 {
            lags.extend([from, (from * to).sqrt(), to]);
        }
    }
    lags.retain(|l| *l != best);
    lags
}

/// The temperature behind a first-order lag from the temperature at its start, and what differs where the sensor was not yet at it:
/// e^{−t/lag} of unknown size. Starts in s; across a gap the last temperature before it is held.
pub(crate) fn behind(
    given: &[&[f64]],
    starts: &[f64],
    sample_rate: f64,
    lag: f64,
    highest: f64,
) -> Vec<Form> {
    let mut form = Form::new(lagged(given, starts, sample_rate, lag));
    form.highest = highest;
    let mut forms = vec![form];
    if lag > 0.0 {
        let lengths: Vec<usize> = given.iter().map(|s| s.len()).collect();
        let state = crate::CourseShape::Exponential { time: lag };
        forms.extend(state.forms(&lengths, starts, sample_rate));
    }
    forms
}

fn lagged(given: &[&[f64]], starts: &[f64], sample_rate: f64, lag: f64) -> Vec<Vec<f64>> {
    if lag <= 0.0 {
        return given.iter().map(|s| s.to_vec()).collect();
    }
    // Value, temperature and time of the sample before.
    let mut state: Option<(f64, f64, f64)> = None;
    given
        .iter()
        .zip(starts)
        .map(|(stretch, start)| {
            stretch
                .iter()
                .enumerate()
                .map(|(i, t)| {
                    let now = start + i as f64 / sample_rate;
                    let value = match state {
                        None => *t,
                        Some((value, before, at)) => {
                            let steps = (now - at) * sample_rate;
                            let kept = (-(now - at) / lag).exp();
                            // The temperature goes in a straight line over one sampling interval.
                            let mean = if steps < 1.5 {
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
