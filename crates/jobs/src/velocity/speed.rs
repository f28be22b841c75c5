//! Readings of a speed before they share a time base with the accelerometer.

use super::clock::median_step;
use super::reading::Samples;
use proofmass_core::Error;
use proofmass_motion::{MotionRecord, ReadingSource, leave_out_threshold, speed_increment, thin};
use proofmass_uncertainty::Finding;

/// Keeps one of the rows in which a slower sensor stands several times, and leaves out the zeros below its threshold;
/// gives back the step of its digits.
///
/// # Errors
/// Readings that make no record.
pub(super) fn digits(
    reading: &mut Samples,
    findings: &mut Vec<Finding>,
) -> Result<Option<f64>, Error> {
    let step = median_step(&reading.time);
    if reading.time.len() > 3 && step > 0.0 {
        let values = reading.value.iter().copied().map(Some).collect();
        let nothing = vec![0.0; reading.value.len()];
        let mut rows = MotionRecord::new(step, ReadingSource::Speed, values, nothing)?;
        if let Some(finding) = thin(&mut rows) {
            findings.push(finding);
            let (time, value) = reading
                .time
                .iter()
                .zip(&rows.reading)
                .filter_map(|(t, r)| r.map(|r| (*t, r)))
                .unzip();
            (reading.time, reading.value) = (time, value);
        }
    }
    let increment = speed_increment(&reading.value);
    findings.extend(leave_out_threshold(&mut reading.time, &mut reading.value));
    Ok(increment)
}
