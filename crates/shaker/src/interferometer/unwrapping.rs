//! The phase of an interferometer from sample to sample.

use super::Unusable;
use std::f64::consts::{PI, TAU};

/// Part of half a turn up to which a step is followed: beyond it noise may choose the wrong turn.
const FOLLOWED: f64 = 0.9;
/// Part of half a turn that a step has at the rate that is asked for instead.
const COMFORTABLE: f64 = 0.7;

/// Phases within a turn, made one that goes on: every step is the one of less than half a turn.
///
/// ```
/// use proofmass_shaker::interferometer::unwrap;
/// let phases = unwrap(&[3.0, -3.0, -2.0])?;
/// assert!((phases[1] - (std::f64::consts::TAU - 3.0)).abs() < 1e-12);
/// # Ok::<(), proofmass_shaker::interferometer::Unusable>(())
/// ```
///
/// # Errors
/// [`Unusable::TooFast`] for a step of more than nine tenths of half a turn. The factor comes from the steps themselves, which are
/// followed as the phases are: a motion that is sampled often in every period changes its steps slowly.
pub fn unwrap(phases: &[f64]) -> Result<Vec<f64>, Unusable> {
    let wrap = |step: f64| step - TAU * (step / TAU).round();
    let mut on = Vec::with_capacity(phases.len());
    let (mut total, mut largest) = (phases.first().copied().unwrap_or(0.0), 0.0f64);
    for (k, phase) in phases.iter().enumerate() {
        if k > 0 {
            let step = wrap(phase - phases[k - 1]);
            largest = largest.max(step.abs());
            total += step;
        }
        on.push(total);
    }
    if largest <= FOLLOWED * PI {
        return Ok(on);
    }
    let mut steps = Vec::with_capacity(phases.len());
    let mut step = 0.0;
    for pair in phases.windows(2) {
        step += wrap(pair[1] - pair[0] - step);
        steps.push(step);
    }
    // The motion comes back: its mean step is none.
    let mean = steps.iter().sum::<f64>() / steps.len().max(1) as f64;
    let turns = TAU * (mean / TAU).round();
    let fastest = steps.iter().fold(0.0f64, |m, s| m.max((s - turns).abs()));
    let fastest = fastest.max(largest);
    Err(Unusable::TooFast(fastest, fastest / (COMFORTABLE * PI)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_sine_is_followed_up_to_its_fastest_step_and_refused_beyond() {
        for (amplitude, follows) in [(400.0, true), (900.0, false)] {
            let truth = |k: usize| amplitude * (TAU * k as f64 / 1000.0).sin();
            let wrapped: Vec<f64> = (0..3000)
                .map(|k| truth(k).sin().atan2(truth(k).cos()))
                .collect();
            match unwrap(&wrapped) {
                Ok(on) => {
                    assert!(follows);
                    assert!(
                        on.iter()
                            .enumerate()
                            .all(|(k, p)| (p - truth(k)).abs() < 1e-9)
                    );
                }
                Err(Unusable::TooFast(step, factor)) => {
                    assert!(!follows);
                    // The fastest step of the sine, although it is beyond half a turn.
                    let fastest = amplitude * TAU / 1000.0;
                    assert!((step / fastest - 1.0).abs() < 1e-3, "{step} {fastest}");
                    assert!((factor - fastest / (COMFORTABLE * PI)).abs() < 1e-2);
                }
                Err(other) => panic!("{other:?}"),
            }
        }
    }
}
