//! What to doubt about a tuning.

use super::likelihood::RATIO;
use crate::counting::LONG_RUN;
use crate::diffuse::Noise;
use crate::findings;
use crate::{MotionRecord, Whiteness};
use proofmass_uncertainty::findings::innovations_correlated;
use proofmass_uncertainty::{Finding, Severity};

/// Rounding that repeats with the motion (whole samples per period, or an axis that rests) passes for motion: the
/// readings then fit better than their increment allows.
///
/// Less than a fifth of R is chance.
pub(super) fn rounding_repeats(found: f64, rounding: f64) -> Option<Finding> {
    let note = findings::rounding_repeats(found.sqrt(), rounding.sqrt());
    (found < 0.8 * rounding).then_some(note)
}

pub(super) fn at_bound(noise: &Noise, unit: f64) -> Option<Finding> {
    let ratio = (noise.q * unit / noise.r).log10();
    (ratio <= RATIO.0 + 0.1 || ratio >= RATIO.1 - 0.1)
        .then(|| findings::likelihood_at_bound(ratio, RATIO.0, RATIO.1))
}

/// Readings that mostly stand in long runs of equal ones.
pub(super) fn resting(record: &MotionRecord) -> Option<Finding> {
    let readings: Vec<f64> = record.reading.iter().flatten().copied().collect();
    let resting: usize = readings
        .chunk_by(|a, b| a == b)
        .map(<[f64]>::len)
        .filter(|&n| n >= LONG_RUN)
        .sum();
    let share = resting as f64 / readings.len().max(1) as f64;
    (share > 0.1).then(|| findings::slow_quantised_readings(100.0 * share, LONG_RUN))
}

/// Largest inflation of a variance by correlation that is still called white: the standard uncertainty is then wrong
/// by less than half.
const INFLATION: f64 = 2.25;

/// Correlation at a lag of up to five from which innovations are told as correlated, whatever comes after: where ρ is that of a first
/// order, (1 + ρ)/(1 − ρ) times the variance of a mean. Rounding that repeats makes as much in healthy records.
const SHORT: f64 = 0.4;

/// Correlation at any lag that is never harmless where chance does not make it, and the one from which the result waits for a decision.
const STRONG: f64 = 0.3;
const DECISIVE: f64 = 0.6;
const NO_CHANCE: f64 = 1e-6;

/// Variance of the readings over that of their rounding, beyond which it is not the rounding that repeats.
const ROUNDING: f64 = 4.0;

/// Whether what is correlated is the rounding that repeats with the motion, for which the number of effective readings accounts. Where
/// the increment is not known it is taken for that.
pub(super) fn rounding_explains(
    record: &MotionRecord,
    reading_noise: f64,
    effective: f64,
    readings: f64,
) -> bool {
    let small = |d: f64| reading_noise < ROUNDING * d * d / 12.0;
    effective < 0.5 * readings && record.increment.is_none_or(small)
}

/// Correlated innovations, where the correlation is large enough to matter, whatever its significance. A note where something else
/// accounts for it: rounding that repeats with the motion, or innovations of half the stated size and less, which are not understated.
/// `correlation` is that at the lags over which a mean is judged; none where only single lags are.
pub(super) fn not_white(
    accelerometer: bool,
    whiteness: &Whiteness,
    correlation: &[f64],
    by_rounding: bool,
) -> Option<Finding> {
    let (lag, rho) = whiteness.largest_correlation;
    let strong = rho.abs() > STRONG && whiteness.p_white < NO_CHANCE;
    let small = whiteness.mean_square <= 0.25;
    if by_rounding || small {
        let (model, remedy) = match by_rounding {
            true => (
                "an error of the readings repeats with the motion, as their rounding does, and fewer of them count as new",
                "choose a sampling rate that is no multiple of the motion's frequency",
            ),
            false => (
                "the readings scatter by less than half of the noise they are taken to have, and the intervals are wide",
                "state a finer increment where the readings have one",
            ),
        };
        let evidence = format!(
            "correlation {rho:.3} at lag {lag} of {} innovations (Ljung-Box p = {:.1e}), mean square {:.3}",
            whiteness.samples, whiteness.p_white, whiteness.mean_square
        );
        return strong.then(|| innovations_correlated(model, &evidence, remedy).at(Severity::Note));
    }
    let (near, short) = whiteness.short_correlation;
    let inflation = 1.0 + 2.0 * correlation.iter().skip(1).sum::<f64>();
    let evidence = if short.abs() > SHORT && whiteness.p_short < 1e-3 {
        format!(
            "correlation {short:.3} at lag {near} of {} innovations (five lags: Ljung-Box p = {:.1e}); the intervals do not hold",
            whiteness.samples, whiteness.p_short
        )
    } else if strong || (inflation > INFLATION && whiteness.p_white < 1e-3) {
        format!(
            "the variance of their mean over {} lags is {inflation:.2} times that of white ones; correlation {rho:.3} at lag {lag} (Ljung-Box p = {:.1e})",
            whiteness.lags, whiteness.p_white
        )
    } else {
        return None;
    };
    let (model, remedy) = match accelerometer {
        true => (
            "the model does not describe both sensors",
            "look for slip, a gain error, a latency that changes, or an error of the encoder that repeats; the stated uncertainty is a lower bound",
        ),
        false => (
            "the motion does not change at random",
            "add an accelerometer, which would show the motion; the stated uncertainty is a lower bound",
        ),
    };
    let found = innovations_correlated(model, &evidence, remedy);
    Some(match strong && rho.abs() > DECISIVE {
        true => found.at(Severity::Decision),
        false => found,
    })
}
