//! What to doubt about a tuning.

use super::likelihood::RATIO;
use crate::counting::LONG_RUN;
use crate::diffuse::Noise;
use crate::{MotionRecord, Whiteness};
use proofmass_uncertainty::{Finding, Severity};

/// Rounding that repeats with the motion (whole samples per period, or an axis that rests) passes for motion: the
/// readings then fit better than their increment allows.
///
/// Less than a fifth of R is chance.
pub(super) fn rounding_repeats(found: f64, rounding: f64) -> Option<Finding> {
    let note = Finding::new(
        Severity::Note,
        "rounding-repeats",
        "the readings seem better than their increment: its rounding repeats with the motion, and the noise of a reading was set to it",
    )
    .evidence(format!(
        "found {:.2e}, increment over the root of twelve {:.2e}",
        found.sqrt(),
        rounding.sqrt()
    ))
    .advice("a sample rate that is no multiple of the motion's frequency lets the rounding average");
    (found < 0.8 * rounding).then_some(note)
}

pub(super) fn at_bound(noise: &Noise, unit: f64) -> Option<Finding> {
    let ratio = (noise.q * unit / noise.r).log10();
    (ratio <= RATIO.0 + 0.1 || ratio >= RATIO.1 - 0.1).then(|| {
        Finding::new(
            Severity::Warning,
            "likelihood-at-bound",
            "one sensor is ignored: the likelihood has no maximum inside the searched range",
        )
        .evidence(format!("log10(q T^4/R) = {ratio:.1} of {RATIO:?}"))
        .advice("check that both sensors move and share unit and sense")
    })
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
    (share > 0.1).then(|| {
        Finding::new(
            Severity::Note,
            "slow-quantised-readings",
            "the readings rest on one value for long stretches: they were used at the edges, where they change",
        )
        .evidence(format!(
            "{:.0} % of the readings lie in runs of {LONG_RUN} and more equal ones",
            100.0 * share
        ))
        .advice("timed edges know more where the axis is slow")
    })
}

/// Largest inflation of a variance by correlation that is still called white: the standard uncertainty is then wrong
/// by less than half.
const INFLATION: f64 = 2.25;

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
    let sum: f64 = correlation.iter().skip(1).sum();
    let inflation = 1.0 + 2.0 * sum;
    // Innovations of half the stated size and less are correlated, not understated.
    let matters = inflation > INFLATION && whiteness.mean_square > 0.25;
    (whiteness.p_white < 1e-3 && matters).then(|| {
        let (lag, rho) = whiteness.largest_correlation;
        Finding::new(
            Severity::Warning,
            "innovations-not-white",
            match record.accelerometer {
                true => "the innovations are correlated: the model does not describe both sensors",
                false => "the innovations are correlated: the motion does not change at random",
            },
        )
        .evidence(format!(
            "the variance of their mean over {} lags is {inflation:.2} times that of white ones; correlation {rho:.3} at lag {lag} (Ljung-Box p = {:.1e})",
            whiteness.lags, whiteness.p_white
        ))
        .advice(match record.accelerometer {
            true => "look for slip, a gain error, a latency that changes, or an error of the encoder that repeats; the stated uncertainty is then a lower bound",
            false => "an accelerometer would show the motion; where it bends, the stated uncertainty is a lower bound",
        })
    })
}
