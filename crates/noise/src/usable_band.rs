//! Up to which frequency a spectrum follows the noise terms: what lies behind a filter is left out.

use crate::effects::Effects;
use crate::front_end::{Described, FrontEnd, LowPass, Trial, describe, overlap};
use crate::variance_fit::Likelihood;

/// Rise of the likelihood by a filter above which the band is made narrower.
pub(crate) const ENOUGH: f64 = 2.7;

/// The same where quantisation is seen, without a filter, over the whole spectrum: two terms of the upper spectrum leave a filter more room
/// for chance, and taking Q out, as a filter would, makes N wrong. One record in 500 rises so far.
const ENOUGH_BESIDE_QUANTISATION: f64 = 9.5;

/// Steps of the highest frequency: ten per decade.
pub(crate) const STEP: f64 = 1.258_925_411_794_167_2;

/// Chance of a residual in the upper decade of the band as large as the one that makes it narrower.
const RESIDUAL_CHANCE: f64 = 1e-4;

/// The band that is fitted.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Band {
    /// Highest frequency used, Hz; half the sample rate when nothing was cut.
    pub(crate) highest: f64,
    /// What made it narrower: the filter of most likelihood over the last band that was refused, and its gain.
    pub(crate) filter: Option<(LowPass, f64)>,
    /// What shapes the noise, where something simple does: it is part of the fit.
    pub(crate) front_end: Option<Described>,
    /// Whether something else than a low-pass filter did.
    pub(crate) resonance: bool,
}

/// A spectrum with the columns of its terms; which of them a filter acts upon.
pub(crate) struct Candidate<'a> {
    pub(crate) likelihood: &'a Likelihood,
    pub(crate) frequencies: &'a [f64],
    /// Position of quantisation, which no filter in front of the converter touches.
    pub(crate) quantisation: Option<usize>,
    pub(crate) sample_rate: f64,
    /// 100/T: nothing below is given up.
    pub(crate) lowest: f64,
    /// Rise of −2 ln L up to which another front end is admitted.
    pub(crate) level: f64,
}

/// Highest frequency below which no low-pass filter is seen.
///
/// While a filter of first or second order brings more than 2.7 of −2 ln L over 0 … f, f is made smaller; where it was, f
/// is halved once more, because what a filter takes off is seen later than it harms. Where the terms
/// with a front end describe more, the band is what that admits, and the front end is part of the fit. Else the same is then asked of the
/// residual of the upper decade (resonances, decimators), and answered only if it comes to an end.
pub(crate) fn usable_band(candidate: &Candidate<'_>) -> Band {
    let nyquist = 0.5 * candidate.sample_rate;
    let mut highest = nyquist;
    let mut filter = None;
    let mut cut = false;
    while highest > candidate.lowest {
        let Some(trial) = Trial::new(candidate, highest, cut) else {
            break;
        };
        let Some(found) = filter_gain(candidate, &trial, highest) else {
            break;
        };
        let enough = if trial.behind() > ENOUGH_BESIDE_QUANTISATION {
            ENOUGH_BESIDE_QUANTISATION
        } else {
            ENOUGH
        };
        if found.1 <= enough {
            break;
        }
        // The filter is best described by the widest band that shows it.
        filter = filter.or(Some(found));
        highest /= STEP;
        cut = true;
    }
    let mut band = Band {
        highest: if cut { 0.5 * highest } else { nyquist },
        filter,
        front_end: if cut {
            describe(candidate, highest)
        } else {
            None
        },
        resonance: false,
    };
    if let Some(described) = &band.front_end {
        band.highest = band.highest.max(described.usable(candidate.sample_rate));
        return band;
    }
    let mut narrower = band.highest;
    let mut moved = band.filter.is_some();
    while narrower > candidate.lowest {
        if !residual_in_upper_decade(candidate, narrower, moved) {
            if narrower < band.highest {
                band.resonance = true;
                band.highest = narrower;
            }
            return band;
        }
        if !moved {
            // Averages that overlap are no filter of the forms above, but may be what is left; they describe the whole spectrum or nothing.
            band.front_end = overlap(candidate);
            if band.front_end.is_some() {
                return band;
            }
        }
        narrower /= STEP;
        moved = true;
    }
    band
}

/// The likelihood up to a frequency.
pub(crate) fn below(
    likelihood: &Likelihood,
    frequencies: &[f64],
    highest: f64,
    without: Option<usize>,
) -> Likelihood {
    let kept: Vec<usize> = (0..frequencies.len())
        .filter(|i| frequencies[*i] <= highest)
        .collect();
    let pick = |v: &[f64]| kept.iter().map(|i| v[*i]).collect::<Vec<f64>>();
    Likelihood {
        count: pick(&likelihood.count),
        products: likelihood.products.iter().map(|row| pick(row)).collect(),
        forms: likelihood.forms,
        columns: likelihood
            .columns
            .iter()
            .enumerate()
            .filter(|(t, _)| Some(*t) != without)
            .map(|(_, c)| pick(c))
            .collect(),
        divisors: likelihood.divisors.iter().map(|w| pick(w)).collect(),
        divisor_start: likelihood.divisor_start.clone(),
    }
}

/// The filter that describes the spectrum up to a frequency best, and what it gains over none.
fn filter_gain(candidate: &Candidate<'_>, trial: &Trial, highest: f64) -> Option<(LowPass, f64)> {
    let mut best: Option<(LowPass, f64)> = None;
    for (order, widest) in [(1, 12.0), (2, 4.0)] {
        let limit = f64::min(widest * highest, 0.4999 * candidate.sample_rate);
        let at = |corner: f64| {
            let filter = LowPass { order, corner };
            (
                filter,
                trial.gain(FrontEnd::butterworth(filter, candidate.sample_rate)),
            )
        };
        let mut coarse: Option<(LowPass, f64)> = None;
        let mut corner = limit;
        while corner > 0.06 * highest {
            let found = at(corner);
            if coarse.is_none_or(|c| found.1 > c.1) {
                coarse = Some(found);
            }
            corner /= 1.6;
        }
        let Some(mut peak) = coarse else { continue };
        // Two refinements between the neighbours of the best corner.
        for step in [1.26, 1.12] {
            let corner = peak.0.corner;
            for near in [corner * step, corner / step] {
                if near <= limit {
                    let found = at(near);
                    if found.1 > peak.1 {
                        peak = found;
                    }
                }
            }
        }
        if best.is_none_or(|b| peak.1 > b.1) {
            best = Some(peak);
        }
    }
    best
}

/// Whether the bins of the upper decade depart from the fit beyond chance.
fn residual_in_upper_decade(candidate: &Candidate<'_>, highest: f64, cut: bool) -> bool {
    let without = candidate.quantisation.filter(|_| cut);
    let plain = below(
        candidate.likelihood,
        candidate.frequencies,
        highest,
        without,
    );
    let crude = plain.start();
    let free = vec![None; plain.terms()];
    let Some(fit) = plain.minimise(&[&crude], &free, Effects::Restricted) else {
        return false;
    };
    let frequencies: Vec<f64> = candidate
        .frequencies
        .iter()
        .copied()
        .filter(|f| *f <= highest)
        .collect();
    let (statistic, groups, _) = misfit(&plain, &frequencies, &fit.squares, 0.1 * highest);
    groups > 4
        && crate::edf::chi_square_quantile(1.0 - RESIDUAL_CHANCE, groups as f64)
            .is_some_and(|q| statistic > q)
}

/// Departure of the bins above a frequency from a fit: Σ ν (x − 1 − ln x) over groups of at least twelve cosines, which is
/// about χ² of as many degrees of freedom as groups; the groups; and the root mean square departure beyond chance.
pub(crate) fn misfit(
    likelihood: &Likelihood,
    frequencies: &[f64],
    squares: &[f64],
    from: f64,
) -> (f64, usize, f64) {
    let Some(density) = likelihood.density(squares) else {
        return (0.0, 0, 0.0);
    };
    let left = likelihood.freed(&density);
    let mut order: Vec<usize> = (0..frequencies.len())
        .filter(|i| frequencies[*i] >= from)
        .collect();
    order.sort_by(|a, b| frequencies[*a].total_cmp(&frequencies[*b]));
    let (mut statistic, mut groups, mut excess) = (0.0, 0, 0.0);
    let (mut ratio, mut count) = (0.0, 0.0);
    for i in order {
        ratio += likelihood.count[i] * left[i] / density[i];
        count += likelihood.count[i];
        if count >= 12.0 {
            let x: f64 = ratio / count;
            if x > 0.0 {
                // The mean of ν (x − 1 − ln x) is 1 + 1/(3ν).
                statistic += count * (x - 1.0 - x.ln()) / (1.0 + 1.0 / (3.0 * count));
                excess += (x - 1.0).powi(2) - 2.0 / count;
                groups += 1;
            }
            (ratio, count) = (0.0, 0.0);
        }
    }
    let rms = (excess / f64::max(groups as f64, 1.0)).max(0.0).sqrt();
    (statistic, groups, rms)
}
