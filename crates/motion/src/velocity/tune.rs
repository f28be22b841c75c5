//! The model and the gains of every fused method, found without a truth.

use super::ground::{Ground, doubts, on_line_kalman, part_finding, sensors, settle, with_blows};
use super::low_corner;
use crate::{
    Crossover, Filter, LowCorner, Method, MotionRecord, Tuned, Tuning, conditions,
    crossover_by_smoother,
};
use proofmass_core::{Error, Watch};
use proofmass_uncertainty::Finding;
use std::ops::Range;

/// Answer of [`tune`]: the model and the gains of every fused method, found without a truth.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TuneResult {
    /// Noise by maximum likelihood; the smoother's model.
    pub tuned: Tuned,
    /// Kalman filter, closest to the smoother.
    pub kalman: Crossover,
    /// Two channels, closest to the smoother.
    pub two_channel: Crossover,
    /// Observer, closest to the smoother.
    pub observer: Crossover,
    /// Corner of the accelerometer of which the slow accelerations were given back before.
    pub low_corner: Option<LowCorner>,
    /// Samples it was found on.
    pub samples: Range<usize>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl TuneResult {
    /// The tuned methods: Kalman, two channels, observer, smoother.
    pub fn methods(&self) -> Vec<Method> {
        vec![
            self.kalman.method,
            self.two_channel.method,
            self.observer.method,
            Method::Smoother {
                model: self.tuned.model,
            },
        ]
    }
}

/// Finds noise parameters and gains from the record alone.
///
/// The noise is that of the largest likelihood of the longest stretch without slip; the gains of each on-line filter
/// are those that come closest to the smoother with this noise, on the accelerometer with its gain and latency put
/// right. Of more than 20 000 samples the 20 000 with the most motion are used: by then R is known to one per cent.
///
/// # Errors
/// Of the record and of the search ([`Tuning::run`], [`crate::crossover`]); [`Error::TooFew`] without accelerometer.
pub fn tune(
    record: &MotionRecord,
    tuning: &Tuning,
    watch: &dyn Watch,
) -> Result<TuneResult, Error> {
    record.check()?;
    if !record.accelerometer || record.rests_only() {
        return Err(Error::TooFew {
            name: "sensors beside the one",
            needed: 1,
            got: 0,
        });
    }
    let low_corner::Settled {
        record,
        corner: low_corner,
        finding,
        ground,
    } = low_corner::settled(record, tuning, watch)?;
    let (slip, pairing) = sensors(&record);
    let record = &with_blows(&record, slip.as_ref());
    let Ground {
        pairing,
        part,
        samples,
        tuned,
        ..
    } = match ground {
        Some(ground) => ground,
        None => Ground::of(record, (slip, pairing), tuning, watch)?,
    };
    let readings = part.reading.iter().flatten().count();
    let skip = settle(&part);
    let kalman = on_line_kalman(&tuned, &part)?;
    let part = tuned.corrected(&part);
    watch.step("gains", 1, 3)?;
    let two_channel = crossover_by_smoother(Filter::TwoChannel, &tuned.model, &part, skip)?;
    watch.step("gains", 2, 3)?;
    let observer = crossover_by_smoother(Filter::Observer, &tuned.model, &part, skip)?;
    watch.step("gains", 3, 3)?;
    // Wrong units and senses first: the gains are worth nothing with them.
    let mut findings = doubts(pairing.as_ref(), Some(&tuned), readings);
    findings.extend(finding);
    findings.extend(conditions(record));
    findings.extend(part_finding(record, &samples));
    findings.extend(tuned.findings.iter().cloned());
    Ok(TuneResult {
        tuned,
        kalman,
        two_channel,
        observer,
        low_corner,
        samples,
        findings,
    })
}
