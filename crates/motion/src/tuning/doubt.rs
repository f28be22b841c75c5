//! What to doubt about a tuning.

use super::likelihood::RATIO;
use crate::counting::LONG_RUN;
use crate::diffuse::Noise;
use crate::findings;
use crate::{MotionRecord, Whiteness};
use proofmass_uncertainty::Finding;

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

/// Innovations that are alike from one to the next ones.
pub(super) fn short_correlation(accelerometer: bool, whiteness: &Whiteness) -> Option<Finding> {
    let (lag, rho) = whiteness.short_correlation;
    let matters = rho.abs() > SHORT && whiteness.p_short < 1e-3 && whiteness.mean_square > 0.25;
    matters.then(|| {
        correlated(
            accelerometer,
            &format!(
                "correlation {rho:.3} at lag {lag} of {} innovations (five lags: Ljung-Box p = {:.1e}); the intervals do not hold",
                whiteness.samples, whiteness.p_short
            ),
        )
    })
}

fn correlated(accelerometer: bool, evidence: &str) -> Finding {
    let (model, remedy) = match accelerometer {
        true => (
            "the model does not describe both sensors",
            "look for slip, a gain error, a latency that changes, or an error of the encoder that repeats",
        ),
        false => (
            "the motion does not change at random",
            "add an accelerometer, which would show the motion",
        ),
    };
    proofmass_uncertainty::findings::innovations_correlated(model, evidence, remedy)
}

/// Correlated innovations, where the correlation is large enough to matter, whatever its significance. Where rounding repeats
/// with the motion it is the rounding that is correlated, which the number of effective readings accounts for.
pub(super) fn not_white(
    record: &MotionRecord,
    whiteness: &Whiteness,
    correlation: &[f64],
    effective: f64,
) -> Option<Finding> {
    if effective < 0.5 * whiteness.samples as f64 {
        return None;
    }
    let short = short_correlation(record.accelerometer, whiteness);
    if short.is_some() {
        return short;
    }
    let sum: f64 = correlation.iter().skip(1).sum();
    let inflation = 1.0 + 2.0 * sum;
    // Innovations of half the stated size and less are correlated, not understated.
    let matters = inflation > INFLATION && whiteness.mean_square > 0.25;
    (whiteness.p_white < 1e-3 && matters).then(|| {
        let (lag, rho) = whiteness.largest_correlation;
        let evidence = format!(
            "the variance of their mean over {} lags is {inflation:.2} times that of white ones; correlation {rho:.3} at lag {lag} (Ljung-Box p = {:.1e})",
            whiteness.lags, whiteness.p_white
        );
        correlated(record.accelerometer, &evidence)
    })
}
