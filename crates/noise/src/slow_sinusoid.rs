//! Sinusoids of few cycles: sought beside all noise terms, by the likelihood of the coloured model and not against a floor.

use crate::coefficients::Limits;
use crate::cosine_spectrum::{CosineSpectrum, Form};
use crate::effects::Effects;
use crate::fit_record::FitRecord;
use crate::markov;
use crate::profile::{Fitted, Profile, form_level};
use crate::term_density::{Process, column};
use crate::variance_fit::{Likelihood, Minimum};
use crate::{FitOptions, Sinusoid, Term, Verdict};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Fewest cycles in the record.
const FEWEST: f64 = 1.5;

/// Most cycles; faster ones are lines of the spectrum.
pub(crate) const MOST: f64 = 32.0;

/// Candidates per cycle.
const PER_CYCLE: f64 = 4.0;

/// Sinusoids sought at most.
const AT_MOST: usize = 4;

/// Averages of which they are sought.
const AVERAGES: usize = 4096;

/// Rise of −2 ln L beyond that of two further parameters: the lowest cosines are few, and a random walk takes the place of a
/// sinusoid. Held against simulations (`examples/beside_noise.rs`).
const EXCESS: f64 = 4.0;

/// A sinusoid found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlowSinusoid {
    /// Hz.
    pub(crate) frequency: f64,
    /// Its limits at the probability of the fit.
    pub(crate) interval: (f64, f64),
    /// Gain over the model without it.
    pub(crate) gain: f64,
}

/// Cosine and sine over stretches of these lengths, which begin at these times in s.
pub(crate) fn forms(
    lengths: &[usize],
    starts: &[f64],
    sample_rate: f64,
    frequency: f64,
) -> [Form; 2] {
    let course = |phase: f64| {
        let samples = lengths.iter().zip(starts).map(|(n, start)| {
            (0..*n)
                .map(|i| {
                    let t = start + i as f64 / sample_rate;
                    (2.0 * PI * frequency * t + phase).cos()
                })
                .collect()
        });
        Form::new(samples.collect())
    };
    [course(0.0), course(-0.5 * PI)]
}

/// Amplitude and phase of a sinusoid whose cosine and sine stand at these places of the fit.
///
/// The interval is that of the part in phase, profiled as the slope of a ramp is; the part out of phase is integrated out.
pub(crate) fn amplitude(
    fitted: &Fitted,
    places: (usize, usize),
    found: &SlowSinusoid,
    options: &FitOptions,
) -> Option<(Sinusoid, Verdict)> {
    let density = fitted.likelihood.density(&fitted.best.squares)?;
    let sizes = fitted
        .likelihood
        .eliminated(&density, Effects::Restricted)
        .sizes();
    let (c, s) = (*sizes.get(places.0)?, *sizes.get(places.1)?);
    let phase = s.atan2(c);
    let turned = Fitted {
        likelihood: fitted.likelihood.turned(places.0, places.1, phase),
        ..fitted.clone()
    };
    let profile = turned
        .led_by(places.0)
        .first(form_level(options.probability))?;
    let limits = Limits {
        needed: 0.0,
        excludes_zero: 0.0,
        forced: true,
        probability: options.probability,
    };
    let verdict = limits.verdict(&Profile {
        interval: (profile.interval.0.max(0.0), profile.interval.1),
        gain: found.gain,
        ..profile
    });
    let sinusoid = Sinusoid {
        amplitude: profile.best,
        frequency: found.frequency,
        // a cos(ωt − φ) as a sine.
        phase: 0.5 * PI - phase,
    };
    Some((sinusoid, verdict))
}

/// The record in averages, in which slow sinusoids are sought.
struct Averages {
    stretches: Vec<Vec<f64>>,
    /// Middle of the first average of each stretch, s.
    starts: Vec<f64>,
    sample_rate: f64,
    factor: usize,
    span: f64,
    /// What stands beside: the temperature, and sinusoids found.
    known: Vec<Form>,
}

/// Sinusoids of 1.5 to 32 cycles in the record that chance does not explain, the strongest first.
pub(crate) fn find(
    record: &FitRecord<'_>,
    temperature: Option<&Form>,
    sample_rate: f64,
    options: &FitOptions,
) -> Vec<SlowSinusoid> {
    let mut averages = Averages::of(record, temperature, sample_rate);
    let Some(search) = Base::new(&averages, options) else {
        return Vec::new();
    };
    let mut found: Vec<SlowSinusoid> = Vec::new();
    // Every cycle holds two independent sinusoids at most.
    let chances = 2.0 * (MOST - FEWEST) / (0.5 * options.false_alarm_rate);
    let needed = 2.0 * chances.ln() + EXCESS;
    while found.len() < AT_MOST {
        let Some(without) = search.least(&averages, None) else {
            break;
        };
        let gain = |frequency: f64| -> f64 {
            search
                .least(&averages, Some(frequency))
                .map_or(0.0, |m| without.value - m.value)
        };
        let count = ((MOST - FEWEST) * PER_CYCLE) as usize + 1;
        let grid: Vec<(f64, f64)> = (0..count)
            .into_par_iter()
            .map(|i| {
                let frequency = (FEWEST + i as f64 / PER_CYCLE) / averages.span;
                (frequency, gain(frequency))
            })
            .collect();
        let Some(&(mut best, mut most)) = grid.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else {
            break;
        };
        if most < needed - 4.0 {
            break;
        }
        let mut step = 0.5 / (PER_CYCLE * averages.span);
        for _ in 0..7 {
            for frequency in [best - step, best + step] {
                let g = gain(frequency);
                if g > most {
                    (best, most) = (frequency, g);
                }
            }
            step *= 0.5;
        }
        // A maximum at the slow end is drift, not an oscillation.
        if most <= needed || best * averages.span < FEWEST + 0.5 / PER_CYCLE {
            break;
        }
        // As of the other number of a known form: the terms take its place as far as they can.
        let level = form_level(options.probability);
        let reach = |side: f64| {
            let (mut inside, mut step) = (best, 0.02 / averages.span);
            let mut outside = best + side * step;
            for _ in 0..12 {
                if most - gain(outside) > level || outside * averages.span < 0.5 {
                    break;
                }
                inside = outside;
                step *= 1.6;
                outside = inside + side * step;
            }
            for _ in 0..7 {
                let middle = 0.5 * (inside + outside);
                if most - gain(middle) > level {
                    outside = middle;
                } else {
                    inside = middle;
                }
            }
            outside
        };
        found.push(SlowSinusoid {
            frequency: best,
            interval: (reach(-1.0), reach(1.0)),
            gain: most,
        });
        averages.known.extend(averages.sinusoid(best));
    }
    found
}

/// The terms of the model over the bins of the averages.
struct Base {
    columns: Vec<Vec<f64>>,
    ramp: Option<f64>,
    sought: bool,
    held: Vec<Option<f64>>,
}

impl Base {
    fn new(averages: &Averages, options: &FitOptions) -> Option<Self> {
        let spectrum = averages.spectrum(&[]);
        if spectrum.bins.len() < 12 {
            return None;
        }
        let averaged = options.averaged * averages.factor;
        let mut terms: Vec<Term> = options.terms.clone();
        terms.retain(|t| crate::quick_fit::POWERS.contains(t));
        let mut held: Vec<Option<f64>> = terms
            .iter()
            .map(|t| options.fixed(*t).map(|c| c * c))
            .collect();
        let mut columns: Vec<Vec<f64>> = terms
            .iter()
            .map(|t| column(&spectrum, Process::Power(*t), averaged))
            .collect();
        let (sought, ramp) = (options.seeks(Term::Ramp), options.fixed(Term::Ramp));
        if options.seeks(Term::GaussMarkov) {
            let search = markov::Search {
                spectrum: &spectrum,
                highest: 0.5 * averages.sample_rate,
                walk: terms.iter().position(|t| *t == Term::RandomWalk),
                front_end: None,
            };
            let plain = Likelihood::new(&spectrum, columns);
            columns = search.add(plain, &held, options).0.columns;
            held.resize(columns.len(), None);
        }
        Some(Self {
            columns,
            ramp,
            sought,
            held,
        })
    }

    /// Least −2 ln L with a sinusoid, or without.
    fn least(&self, averages: &Averages, frequency: Option<f64>) -> Option<Minimum> {
        let further = frequency.map(|f| averages.sinusoid(f));
        let spectrum = averages.spectrum(further.as_ref().map_or(&[][..], |f| &f[..]));
        let mut likelihood = Likelihood::new(&spectrum, self.columns.clone());
        let mut ahead = likelihood.forms;
        match self.ramp {
            Some(slope) => {
                likelihood = likelihood.given(0, slope);
                ahead -= 1;
            }
            None if !self.sought => {
                likelihood = likelihood.given(0, 0.0);
                ahead -= 1;
            }
            None => {}
        }
        let effects = if further.is_some() {
            // The sinusoid was put last.
            let mut order = vec![ahead - 2, ahead - 1];
            order.extend(0..ahead - 2);
            likelihood = likelihood.with_forms(&order);
            Effects::Best(2)
        } else {
            Effects::Restricted
        };
        let crude = likelihood.start();
        let weak: Vec<f64> = crude.iter().map(|v| 0.03 * v).collect();
        likelihood.minimise(&[&crude, &weak], &self.held, effects)
    }
}

impl Averages {
    fn of(record: &FitRecord<'_>, temperature: Option<&Form>, sample_rate: f64) -> Self {
        let factor = (record.samples() / AVERAGES).max(1);
        let mean = |s: &[f64]| -> Vec<f64> {
            s.chunks_exact(factor)
                .map(|c| c.iter().sum::<f64>() / factor as f64)
                .collect()
        };
        let middle = 0.5 * (factor - 1) as f64;
        Self {
            stretches: record.stretches.iter().map(|s| mean(s)).collect(),
            starts: record
                .starts()
                .iter()
                .map(|s| (*s as f64 + middle) / sample_rate)
                .collect(),
            sample_rate: sample_rate / factor as f64,
            factor,
            span: record.span() as f64 / sample_rate,
            known: temperature
                .map(|t| Form {
                    samples: t.samples.iter().map(|s| mean(s)).collect(),
                    highest: t.highest,
                })
                .into_iter()
                .collect(),
        }
    }

    fn spectrum(&self, further: &[Form]) -> CosineSpectrum {
        let parts: Vec<&[f64]> = self.stretches.iter().map(Vec::as_slice).collect();
        let forms: Vec<Form> = self.known.iter().chain(further).cloned().collect();
        CosineSpectrum::beside(&parts, &forms, self.sample_rate, &[])
    }

    fn sinusoid(&self, frequency: f64) -> [Form; 2] {
        let lengths: Vec<usize> = self.stretches.iter().map(Vec::len).collect();
        forms(&lengths, &self.starts, self.sample_rate, frequency)
    }
}
