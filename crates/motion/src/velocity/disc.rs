//! Errors of the encoder once and twice per turn, as a disc off its axis and a bent shaft make them, beside an estimate.

use super::EstimateResult;
use super::ground::Ground;
use crate::edges::whole_counts;
use crate::findings;
use crate::{EncoderMap, MapSearch, MotionRecord, ReadingSource};
use proofmass_core::{Error, Watch};
use std::f64::consts::TAU;

/// Probability of a line by chance, where rounding is no white noise either.
const CERTAIN: f64 = 1e-9;
/// Share of an increment up to which a line may be that of a rounding which repeats with the motion.
const ROUNDING: f64 = 0.05;
/// Largest error of a velocity over it: a disc off its axis by a tenth of its radius. More is a motion that the accelerometer does
/// not show.
const LARGEST: f64 = 0.1;

/// The map of a record whose readings show one; one pass over the tuned record tells whether it is looked for at all.
///
/// # Errors
/// [`Error::Cancelled`]. A record that does not tell the lines apart has no map.
pub(super) fn seen(
    record: &MotionRecord,
    ground: &Ground,
    turn: f64,
    watch: &dyn Watch,
) -> Result<Option<EncoderMap>, Error> {
    let positions = record.source == ReadingSource::Position && record.edges.is_none();
    if !(positions && record.accelerometer) || record.rests_only() {
        return Ok(None);
    }
    // Over a part of a turn two orders and a gain are hardly told apart.
    let known = record.reading.iter().flatten();
    let (low, high) = known.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), r| {
        (a.min(*r), b.max(*r))
    });
    let orders = match high - low > 2.0 * turn {
        true => vec![1.0, 2.0],
        false => vec![1.0],
    };
    let search = MapSearch {
        turn,
        orders,
        ..MapSearch::default()
    };
    let told = |error: Error| match error.is_cancelled() {
        true => Err(error),
        false => Ok(None),
    };
    // What slips is no more looked through by one pass: a large map passes for slip.
    let slip = ground.slip.as_ref().map_or(0.0, |s| s.slip_share);
    if slip == 0.0 {
        match search.shows(record, ground.clone()) {
            Ok(true) => {}
            Ok(false) => return Ok(None),
            Err(error) => return told(error),
        }
    }
    match search.search(record, true, watch) {
        Ok(found) => {
            let less = found.slip.as_ref().map_or(0.0, |s| s.slip_share) <= slip;
            let mut map = found.map;
            let own = match whole_counts(record) {
                // Counts that stand still in phase have lines of an increment over π at most.
                Some(_) => 0.5,
                None => ROUNDING,
            } * record.increment.unwrap_or(0.0);
            map.lines.retain(|line| {
                let clear = line.chance < CERTAIN && line.amplitude() > own;
                clear && TAU * line.order * line.amplitude() < LARGEST * turn
            });
            Ok(Some(map).filter(|m| less && !m.lines.is_empty()))
        }
        Err(error) => told(error),
    }
}

/// The estimate from readings less their map: how uncertain the map is adds to the velocity, and the map is told.
pub(super) fn beside(
    mut result: EstimateResult,
    record: &MotionRecord,
    map: &EncoderMap,
) -> EstimateResult {
    for trace in [&mut result.trace, &mut result.smoother] {
        let Some(u) = &mut trace.standard_uncertainty else {
            continue;
        };
        let mut last = 0.0;
        for (k, u) in u.iter_mut().enumerate() {
            last = record.reading[k].unwrap_or(last);
            *u = u.hypot(trace.velocity[k] * map.slope_uncertainty(last));
        }
    }
    let told: Vec<String> = map
        .lines
        .iter()
        .map(|line| {
            format!(
                "{} per turn: {:.3e} (u = {:.1e})",
                line.order,
                line.amplitude(),
                line.amplitude_uncertainty()
            )
        })
        .collect();
    let finding = findings::encoder_map_subtracted(&told.join("; "));
    result.findings.insert(0, finding);
    result
}
