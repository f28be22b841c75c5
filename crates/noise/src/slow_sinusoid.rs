//! Sinusoids of few cycles: sought beside all noise terms, by the likelihood of the coloured model and not against a floor.

use crate::averaged_record::{AveragedFit, AveragedRecord};
use crate::coefficients::Limits;
use crate::cosine_spectrum::Form;
use crate::effects::Effects;
use crate::fit_record::FitRecord;
use crate::profile::{Fitted, Profile, form_level};
use crate::{FitOptions, Sinusoid, Verdict};
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
    let (profile, phase) = in_phase(fitted, places, options)?;
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

/// The profile of the part in phase of a sinusoid whose cosine and sine stand at these places, and the phase.
pub(crate) fn in_phase(
    fitted: &Fitted,
    places: (usize, usize),
    options: &FitOptions,
) -> Option<(Profile, f64)> {
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
        .first(form_level(options.probability), true)?;
    Some((profile, phase))
}

/// Sinusoids of 1.5 to 32 cycles in the record that chance does not explain, the strongest first.
pub(crate) fn find(
    record: &FitRecord<'_>,
    known: &[Form],
    sample_rate: f64,
    options: &FitOptions,
) -> Vec<SlowSinusoid> {
    let mut averages = AveragedRecord::of(record, known, sample_rate);
    let Some(search) = AveragedFit::new(&averages, options) else {
        return Vec::new();
    };
    let mut found: Vec<SlowSinusoid> = Vec::new();
    // Every cycle holds two independent sinusoids at most.
    let chances = 2.0 * (MOST - FEWEST) / (0.5 * options.false_alarm_rate);
    let needed = 2.0 * chances.ln() + EXCESS;
    while found.len() < AT_MOST {
        let Some(without) = search.least(&averages, &[]) else {
            break;
        };
        let gain = |frequency: f64| -> f64 {
            search
                .least(&averages, &sinusoid(&averages, frequency))
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
        let further = sinusoid(&averages, best);
        averages.known.extend(further);
    }
    found
}

/// Cosine and sine over the averages.
pub(crate) fn sinusoid(averages: &AveragedRecord, frequency: f64) -> [Form; 2] {
    forms(
        &averages.lengths(),
        &averages.starts,
        averages.sample_rate,
        frequency,
    )
}
