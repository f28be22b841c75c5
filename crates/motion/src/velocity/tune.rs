//! The model and the gains of every fused method, found without a truth.

use super::ground::{Ground, on_line_kalman, settle};
use super::{Settled, settled};
use crate::crossover::{crossover_beside, kalman_beside};
use crate::{
    CountingModel, Crossover, Filter, LowCorner, Method, MotionRecord, Tuned, Tuning,
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
    /// Kalman filter on edges, of an axis that is slow for its counts.
    pub counting: Option<CountingModel>,
    /// Corner of the accelerometer of which the slow accelerations were given back before.
    pub low_corner: Option<LowCorner>,
    /// Samples it was found on.
    pub samples: Range<usize>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl TuneResult {
    /// The tuned methods: Kalman, two channels, observer, smoother; of a slow axis the filter on edges, and its smoother.
    pub fn methods(&self) -> Vec<Method> {
        let on_line = [
            self.kalman.method,
            self.two_channel.method,
            self.observer.method,
        ];
        let rest = match self.counting {
            Some(model) => vec![
                Method::Counting { model },
                Method::CountingSmoother { model },
            ],
            None => vec![Method::Smoother {
                model: self.tuned.model,
            }],
        };
        on_line.into_iter().chain(rest).collect()
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
    tune_turning(record, None, tuning, watch)
}

/// The same for an encoder whose turn is known, as [`estimate_turning`](crate::estimate_turning) has it.
///
/// # Errors
/// As [`tune`].
pub fn tune_turning(
    record: &MotionRecord,
    turn: Option<f64>,
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
    gains(&settled(record, turn, tuning, watch)?, watch)
}

/// The gains of every filter on line beside what an estimate found.
///
/// # Errors
/// Of the search; [`Error::TooFew`] where nothing was tuned.
pub(super) fn gains(settled: &Settled, watch: &dyn Watch) -> Result<TuneResult, Error> {
    let result = &settled.result;
    let (Some(ground), Some(tuned)) = (&settled.ground, &result.tuned) else {
        return Err(Error::TooFew {
            name: "sensors beside the one",
            needed: 1,
            got: 0,
        });
    };
    let Ground { part, samples, .. } = ground;
    let skip = settle(part);
    let right = tuned.corrected(part);
    let smoother = &result.smoother;
    // Of a slow axis the smoother is that of its edges.
    let counted = match (result.trace.method, &smoother.standard_uncertainty) {
        (Method::Counting { model }, Some(u)) => {
            let (v, u) = (&smoother.velocity[samples.clone()], &u[samples.clone()]);
            Some((model, v, u))
        }
        _ => None,
    };
    let other = |filter| match counted {
        Some((_, velocity, _)) => crossover_beside(filter, &right, velocity, skip),
        None => crossover_by_smoother(filter, &tuned.model, &right, skip),
    };
    let kalman = match counted {
        Some((_, v, u)) => kalman_beside(&tuned.model, &right, (v, u), skip, 0.3)?,
        None => on_line_kalman(tuned, part)?,
    };
    watch.step("gains", 1, 3)?;
    let two_channel = other(Filter::TwoChannel)?;
    watch.step("gains", 2, 3)?;
    let observer = other(Filter::Observer)?;
    watch.step("gains", 3, 3)?;
    // What is said of the velocity of the estimate is no matter of the gains.
    let of_estimate = ["filter-and-smoother-disagree", "encoder-ripple"];
    let told = result.findings.iter();
    Ok(TuneResult {
        tuned: tuned.clone(),
        kalman,
        two_channel,
        observer,
        counting: counted.map(|(model, ..)| model),
        low_corner: result.low_corner,
        samples: samples.clone(),
        findings: told
            .filter(|f| !of_estimate.contains(&f.code()))
            .cloned()
            .collect(),
    })
}
