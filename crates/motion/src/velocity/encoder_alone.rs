//! The encoder alone, where the accelerometer adds nothing but its noise.

use super::{EstimateResult, once};
use crate::counting::{counts, is_slow};
use crate::findings;
use crate::floor::variance;
use crate::{Method, MotionRecord, ReadingSource, Tuning};
use proofmass_core::{Error, Watch};

/// Motion over noise of the accelerometer, in variance, below which it is asked whether the readings alone tell the velocity better.
const FAINT: f64 = 20.0;
/// By how much ln L of the readings alone has to be higher.
const BETTER: f64 = 6.0;

/// The estimate of the readings alone, where they are more probable without the accelerometer: beside a motion that is fainter than
/// the accelerometer's own noise.
///
/// Both likelihoods are those of the same readings: with the motion that the accelerometer shows, and with one that changes at
/// random. Of counts that stand still in phase it is that of their edges; slow ones, which tell of the motion at few times only, keep
/// the accelerometer.
pub(super) fn better(
    record: &MotionRecord,
    fused: &EstimateResult,
    watch: &dyn Watch,
) -> Result<Option<EstimateResult>, Error> {
    let Some(tuned) = fused.tuned.as_ref().filter(|_| record.accelerometer) else {
        return Ok(None);
    };
    let shown = variance(&record.acceleration);
    let faint = tuned.noise_floor.is_some_and(|q| shown < FAINT * q);
    let of_positions = record.source == ReadingSource::Position && record.edges.is_none();
    let slow = counts(record).is_some_and(|c| is_slow(&c));
    if !(faint && of_positions) || slow {
        return Ok(None);
    }
    let mut readings = MotionRecord {
        accelerometer: false,
        acceleration: vec![0.0; record.acceleration.len()],
        gain_uncertainty: None,
        ..record.clone()
    };
    // What a line misses of accelerations that are not used is nothing.
    readings.holes.iter_mut().for_each(|h| h.velocity = 0.0);
    let mut alone = match once(&readings, None, None, &Tuning::default(), watch) {
        Err(error) if error.is_cancelled() => return Err(error),
        Err(_) => return Ok(None),
        Ok(alone) => alone.result,
    };
    let Some(found) = &alone.tuned else {
        return Ok(None);
    };
    let gained = found.log_likelihood - tuned.log_likelihood;
    // Of the same readings, or of nearly the same edges.
    let counted = |r: &EstimateResult| matches!(r.smoother.method, Method::CountingSmoother { .. });
    let samples = (
        found.whiteness.samples as f64,
        tuned.whiteness.samples as f64,
    );
    let same = counted(&alone) == counted(fused) && (samples.0 / samples.1 - 1.0).abs() < 0.01;
    let mean = |u: &Option<Vec<f64>>| -> f64 {
        let u = u.as_deref().unwrap_or_default();
        let sum: f64 = u.iter().map(|u| u * u).sum();
        (sum / u.len().max(1) as f64).sqrt()
    };
    let own = mean(&alone.smoother.standard_uncertainty);
    let both = mean(&fused.smoother.standard_uncertainty);
    if !(same && gained > BETTER && own < both) {
        return Ok(None);
    }
    let finding = findings::encoder_alone(gained, own, both);
    alone.findings.insert(0, finding);
    Ok(Some(alone))
}
