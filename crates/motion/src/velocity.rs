//! Three questions to a record, answered as plain data: estimate, compare, tune.

mod beside_reference;
mod compare;
mod disagreement;
mod disc;
mod encoder_alone;
pub(crate) mod ground;
mod low_corner;
mod tune;

pub use beside_reference::BesideReference;
pub use compare::{
    CompareResult, TunedAtRate, compare, compare_turning, published_sweep, single_sensor_methods,
};
pub use tune::{TuneResult, tune, tune_turning};

use crate::condition::dead;
use crate::diffuse::Trajectory;
use crate::edges::on_edges;
use crate::findings;
use crate::rest::{model_at_rest, rests_once};
use crate::tuning::Constants;
use crate::{
    EncoderMap, KalmanModel, LowCorner, Method, MotionRecord, Pairing, ReadingSource, Ripple,
    SlipReport, Tuned, TunedValue, Tuning, VelocityTrace, conditions, ripple,
};
use disagreement::Disagreement;
use ground::{
    Ground, check_sensors, doubts, margin, on_line_kalman, part_finding, sensors, with_blows,
};
pub(crate) use low_corner::tied;
use proofmass_core::{Error, Watch};
use proofmass_uncertainty::{Finding, normal_quantile};
use std::ops::Range;

/// Answer of [`estimate`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct EstimateResult {
    /// Velocity by the chosen method.
    pub trace: VelocityTrace,
    /// Velocity by the smoother of the same (or the tuned) model, with its uncertainty.
    pub smoother: VelocityTrace,
    /// The model the smoother rests on.
    pub model: KalmanModel,
    /// How it was found; `None` when it was given.
    pub tuned: Option<Tuned>,
    /// Offset of the accelerometer by the smoother with its standard uncertainty, when it is a state.
    pub offset: Option<(Vec<f64>, Vec<f64>)>,
    /// Innovation over its standard deviation at the samples of the readings (of edges the last one of a sample), with the
    /// constants of the whole record; empty where there are none.
    pub innovations: Vec<Option<f64>>,
    /// Share of the samples away from slip where filter and smoother agree within two standard uncertainties of
    /// their difference, √(u_f² − u_s²); `None` when the method states no uncertainty.
    pub agreement: Option<f64>,
    /// Whether both sensors see one motion; `None` where one of them sees none.
    pub pairing: Option<Pairing>,
    /// Slip and collisions; `None` for a record too short to look.
    pub slip: Option<SlipReport>,
    /// Repeating errors of the encoder; `None` when the axis hardly moves.
    pub ripple: Option<Ripple>,
    /// Corner of the accelerometer that was taken account of.
    pub low_corner: Option<LowCorner>,
    /// Samples of which nothing is known but what lies around them: they are left out of what is stated.
    pub left_out: Vec<Range<usize>>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl EstimateResult {
    /// The samples that are not left out.
    pub fn stated(&self) -> impl Iterator<Item = usize> + '_ {
        let out = |k: &usize| {
            let next = self.left_out.partition_point(|r| r.end <= *k);
            self.left_out.get(next).is_some_and(|r| r.contains(k))
        };
        (0..self.smoother.velocity.len()).filter(move |k| !out(k))
    }

    /// The sample at which the smoother is fastest: whose interval lies farthest from rest, so that what is not known (a start, a blow)
    /// does not pass for fast. What a filter knows at each moment is no measure of it: the largest of many values with large errors
    /// is too large.
    pub fn fastest(&self) -> usize {
        let sure = |k: usize| {
            let (v, u) = speed_at(&self.smoother, k);
            v - 2.0 * u
        };
        self.stated()
            .max_by(|&i, &j| sure(i).total_cmp(&sure(j)))
            .unwrap_or(0)
    }

    /// Largest speed by the smoother.
    pub fn largest_speed(&self, probability: f64) -> LargestSpeed {
        self.largest_by(&self.smoother, probability)
    }

    /// Largest speed by the method: its speed at the sample at which the smoother is fastest.
    pub fn speed_by_method(&self, probability: f64) -> LargestSpeed {
        self.largest_by(&self.trace, probability)
    }

    /// The fastest sample is chosen by what was found, and its error with it: for the lower end the factor is that of all samples together
    /// that may be the fastest (Bonferroni). Which sample truly is the fastest has nothing to do with the errors, and its interval reaches
    /// as far as the farthest one: for the upper end the factor is that of one sample.
    fn largest_by(&self, trace: &VelocityTrace, probability: f64) -> LargestSpeed {
        let tail = 0.5 * (1.0 - probability);
        let factor = |samples: usize| normal_quantile(1.0 - tail / samples.max(1) as f64);
        let end = |trace: &VelocityTrace, k: usize, factor: f64| {
            let (v, u) = speed_at(trace, k);
            v + factor * u
        };
        let one = factor(1);
        let every = factor(self.stated().count());
        let lowest = self.stated().map(|k| end(&self.smoother, k, -every));
        let lowest = lowest.fold(f64::NEG_INFINITY, f64::max);
        let may_be = self
            .stated()
            .filter(|k| end(&self.smoother, *k, one) >= lowest);
        let may_be: Vec<usize> = may_be.collect();
        let (value, standard_uncertainty) = speed_at(trace, self.fastest());
        let together = factor(may_be.len());
        let farthest = may_be.iter().map(|k| end(trace, *k, one));
        LargestSpeed {
            value,
            standard_uncertainty,
            interval: [
                (value - together * standard_uncertainty).max(0.0),
                farthest.fold(value, f64::max),
            ],
        }
    }
}

/// Largest speed of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LargestSpeed {
    /// Speed at the sample whose interval lies farthest from rest.
    pub value: f64,
    /// Its standard uncertainty at that sample.
    pub standard_uncertainty: f64,
    /// Interval that holds the largest of the true speeds with the probability that was asked for.
    pub interval: [f64; 2],
}

fn speed_at(trace: &VelocityTrace, sample: usize) -> (f64, f64) {
    let u = trace.standard_uncertainty.as_ref();
    let v = trace.velocity.get(sample).map_or(0.0, |v| v.abs());
    (v, u.and_then(|u| u.get(sample)).copied().unwrap_or(0.0))
}

/// Velocity of a record by a method, or by the Kalman filter with tuned gains when none is given.
///
/// The record is searched for slip and collisions first, beside the gain and the latency of the accelerometer; noise is tuned on
/// the longest stretch without slip, so that slip does not pass for noise. `circumference` is the distance of one turn, when
/// known: what repeats with it is then told by itself.
///
/// # Errors
/// Of the record, the search and the method.
pub fn estimate(
    record: &MotionRecord,
    method: Option<Method>,
    circumference: Option<f64>,
    watch: &dyn Watch,
) -> Result<EstimateResult, Error> {
    estimate_turning(record, method, circumference, None, watch)
}

/// The same for an encoder whose turn is known as exactly as its readings, as that of counts with so many to a turn: errors once
/// and twice per turn are looked for as by [`MapSearch`](crate::MapSearch), and subtracted where they are seen.
///
/// # Errors
/// Of the record, the search and the method.
pub fn estimate_turning(
    record: &MotionRecord,
    method: Option<Method>,
    circumference: Option<f64>,
    turn: Option<f64>,
    watch: &dyn Watch,
) -> Result<EstimateResult, Error> {
    record.check()?;
    check_sensors(record, method.as_slice())?;
    let tuning = &Tuning::default();
    let settled = beside_corner(record, method, circumference, tuning, watch)?;
    let asked = (method, circumference, turn);
    let settled = beside_disc(settled, record, asked, tuning, watch)?;
    // A disc that is not known speaks against the accelerometer: it is taken out before.
    if method.is_none()
        && settled.result.low_corner.is_none()
        && let Some(alone) = encoder_alone::better(&settled.plain, &settled.result, watch)?
    {
        return Ok(match &settled.map {
            Some(map) => disc::beside(alone, record, map),
            None => alone,
        });
    }
    Ok(settled.result)
}

/// What estimate, tuning and comparison share: the record as everything runs over it, and all that was found of it.
pub(super) struct Settled {
    /// The estimate.
    pub(super) result: EstimateResult,
    /// The ground of what was tuned; none where a model was given.
    pub(super) ground: Option<Ground>,
    /// The record less the map of its encoder, with the slow accelerations given back, and with the blows that were found.
    pub(super) record: MotionRecord,
    /// The same before rests and blows were looked for.
    plain: MotionRecord,
    /// The map that was subtracted.
    map: Option<EncoderMap>,
}

/// The one way of all questions to a tuned record.
pub(super) fn settled(
    record: &MotionRecord,
    turn: Option<f64>,
    tuning: &Tuning,
    watch: &dyn Watch,
) -> Result<Settled, Error> {
    let settled = beside_corner(record, None, None, tuning, watch)?;
    beside_disc(settled, record, (None, None, turn), tuning, watch)
}

/// The estimate beside the corner of the accelerometer that is stated or found.
fn beside_corner(
    record: &MotionRecord,
    method: Option<Method>,
    circumference: Option<f64>,
    tuning: &Tuning,
    watch: &dyn Watch,
) -> Result<Settled, Error> {
    let asked = (method, circumference);
    // One that never changes has lost nothing that could be given back.
    let mut settled = match record.low_corner.filter(|_| dead(record).is_none()) {
        None => once(record, method, circumference, tuning, watch)?,
        Some(corner) => low_corner::beside(record, corner, asked, tuning, watch)?,
    };
    let found = match &settled.ground {
        Some(ground) => low_corner::seen(record, ground, watch)?,
        None => None,
    };
    if let Some(found) = found {
        let share = |s: &Settled| s.result.slip.as_ref().map_or(0.0, |s| s.slip_share);
        let mut other = low_corner::beside(record, found, asked, tuning, watch)?;
        if let Some(ground) = other.ground.as_ref().filter(|_| share(&other) > 0.0)
            && let Some(refined) = low_corner::refined(record, found, ground, watch)?
        {
            other = low_corner::beside(record, refined, asked, tuning, watch)?;
        }
        // What makes more of the record slip is no better model of it.
        if share(&other) <= share(&settled) + 0.02 {
            settled = other;
        }
    }
    Ok(settled)
}

/// The same less the errors of the encoder that repeat every turn, where its turn is known and they are seen.
fn beside_disc(
    settled: Settled,
    record: &MotionRecord,
    (method, circumference, turn): (Option<Method>, Option<f64>, Option<f64>),
    tuning: &Tuning,
    watch: &dyn Watch,
) -> Result<Settled, Error> {
    let (Some(ground), Some(turn), None) = (&settled.ground, turn, settled.result.low_corner)
    else {
        return Ok(settled);
    };
    match disc::seen(record, ground, turn, watch)? {
        None => Ok(settled),
        Some(map) => {
            let corrected = map.corrected(record)?;
            let mut again = once(&corrected, method, circumference, tuning, watch)?;
            again.result = disc::beside(again.result, record, &map);
            again.map = Some(map);
            Ok(again)
        }
    }
}

/// The estimate from the readings as they are.
fn once(
    record: &MotionRecord,
    method: Option<Method>,
    circumference: Option<f64>,
    tuning: &Tuning,
    watch: &dyn Watch,
) -> Result<Settled, Error> {
    let (mut slip, mut pairing) = sensors(record);
    let mut findings = conditions(record);
    let plain = record.clone();
    let settled = rests_once(&with_blows(record, slip.as_ref()));
    let record = &settled;
    let margin = margin(record);
    let mut ground = None;
    let given = match method {
        Some(
            Method::Kalman { model } | Method::SteadyKalman { model } | Method::Smoother { model },
        ) => Some(model),
        _ if record.rests_only() => Some(model_at_rest(record)),
        _ => None,
    };
    let smoother_trace = |method: Method, velocity, uncertainty| VelocityTrace {
        method,
        label: method.label(),
        velocity,
        standard_uncertainty: Some(uncertainty),
        stated_delay: 0.0,
    };
    let mut readings = 0;
    let (model, tuned, mut trace, smoother, (offset, innovations)) = match given {
        Some(model) => {
            let found = Method::Kalman { model };
            let run = model.smooth(record)?;
            let smoother = smoother_trace(
                Method::Smoother { model },
                run.velocity,
                run.velocity_uncertainty,
            );
            let trace = method.unwrap_or(found).run(record)?;
            (model, None, trace, smoother, (run.offset, run.innovations))
        }
        None => {
            let found = Ground::of(record, (slip, pairing), tuning, watch)?;
            let found = &*ground.insert(found);
            let (part, samples) = (&found.part, &found.samples);
            let mut tuned = found.tuned.clone();
            (slip, pairing) = (found.slip.clone(), found.pairing.clone());
            readings = part.reading.iter().flatten().count();
            watch.step("velocity", 0, 2)?;
            let edges = on_edges(&mut tuned, part, record, watch)?;
            findings.extend(part_finding(record, samples));
            findings.extend(tuned.findings.iter().cloned());
            watch.step("velocity", 1, 2)?;
            let model = tuned.model;
            if let Some((counted, run)) = edges {
                let trace = match method {
                    Some(method) => method.run(record)?,
                    None => smoother_trace(
                        Method::Counting { model: counted },
                        run.filtered.0,
                        run.filtered.1,
                    ),
                };
                let smoother = smoother_trace(
                    Method::CountingSmoother { model: counted },
                    run.smoothed.0,
                    run.smoothed.1,
                );
                let mut innovations = vec![None; record.reading.len()];
                for (k, z) in run.innovations {
                    innovations[k] = Some(z);
                }
                (model, Some(tuned), trace, smoother, (None, innovations))
            } else {
                let trace = match method {
                    Some(method) => method.run(record)?,
                    None => {
                        let kalman = on_line_kalman(&tuned, part)?;
                        on_line(&tuned, kalman.method, record)?
                    }
                };
                // Slip would pass for an offset.
                let constants = match slip.as_ref().is_some_and(|s| !s.slip.is_empty()) {
                    true => Constants::Held,
                    false => Constants::Fitted,
                };
                let run = match tuned.smooth(record, constants) {
                    // Readings that hardly scatter leave no constants to be found beside them.
                    Err(Error::TooFew { .. }) => Trajectory::of(model.smooth(record)?),
                    run => run?,
                };
                let smoother =
                    smoother_trace(Method::Smoother { model }, run.velocity, run.uncertainty);
                let beside = (run.offset, run.innovations);
                (model, Some(tuned), trace, smoother, beside)
            }
        }
    };
    let (mut tuned, mut smoother, mut offset) = (tuned, smoother, offset);
    if !record.accelerometer {
        // The state that is an offset beside an accelerometer is the acceleration here.
        offset = None;
        if let Some(tuned) = &mut tuned {
            tuned.offset = None;
        }
        for trace in [&mut trace, &mut smoother] {
            trace.label = trace.label.replace("offset", "acceleration");
        }
    }
    watch.step("velocity", 2, 2)?;
    let slips = |k: usize| slip.as_ref().is_some_and(|s| s.slips(k, margin)) || record.gapes(k, 0);
    // Filter and smoother of one model on one record: what is found beside it is in both.
    let own = match (&tuned, &smoother.method) {
        // Noise that is correlated in time is no state of a filter on line.
        (Some(tuned), Method::Smoother { .. }) if tuned.coloured.is_none() => {
            let run = model.smooth(&tuned.corrected(record))?;
            (run.velocity, run.velocity_uncertainty)
        }
        _ => (
            smoother.velocity.clone(),
            smoother.standard_uncertainty.clone().unwrap_or_default(),
        ),
    };
    let disagreement = match record.rests_only() {
        true => None,
        false => Disagreement::of(&trace, &own, &slips),
    };
    let agreement = disagreement.as_ref().map(|d| d.share);
    if let Some(disagreement) = disagreement.filter(|d| d.matters()) {
        let share = disagreement.share;
        findings.push(findings::filter_and_smoother_disagree(100.0 * share));
    }
    if trace.standard_uncertainty.is_none() {
        trace.standard_uncertainty = Some(beside(&trace, &smoother));
    }
    findings.extend(doubts(record, pairing.as_ref(), tuned.as_ref(), readings));
    findings.extend(slip.iter().flat_map(|s| s.findings.iter().cloned()));
    let ripple = match record.source {
        _ if !record.accelerometer || record.rests_only() => None,
        // Between two edges of a slow axis the accelerometer's walk is longer than any line.
        ReadingSource::Position if matches!(smoother.method, Method::CountingSmoother { .. }) => {
            None
        }
        ReadingSource::Position => {
            // A latency that is known is no error of the encoder.
            let corrected = tuned.as_ref().map(|tuned| tuned.corrected(record));
            let record = corrected.as_ref().unwrap_or(record);
            ripple(record, circumference, |k| !slips(k)).ok()
        }
        // A wheel that is not round turns with the distance as well, but a speed shows no place on it.
        ReadingSource::Speed => None,
    };
    findings.extend(ripple.iter().flat_map(|r| r.findings.iter().cloned()));
    let result = EstimateResult {
        trace,
        smoother,
        model,
        tuned,
        offset,
        innovations,
        agreement,
        pairing,
        slip,
        ripple,
        low_corner: None,
        left_out: record.blind(),
        findings,
    };
    Ok(Settled {
        result,
        ground,
        record: settled,
        plain,
        map: None,
    })
}

/// An on-line method on the record with gain and latency put right; their uncertainty adds what moving each by it does.
fn on_line(tuned: &Tuned, method: Method, record: &MotionRecord) -> Result<VelocityTrace, Error> {
    let mut trace = method.run(&tuned.corrected(record))?;
    let value = |found: Option<TunedValue>, other: f64| {
        found.map_or((other, 0.0), |f| (f.value, f.uncertainty))
    };
    let (gain, u_gain) = value(tuned.gain, 1.0);
    let (latency, u_latency) = value(tuned.latency, 0.0);
    for (gain, latency, u) in [
        (gain + u_gain, latency, u_gain),
        (gain, latency + u_latency, u_latency),
    ] {
        if u == 0.0 {
            continue;
        }
        let moved = method.run(&record.corrected(gain, latency))?;
        if let Some(own) = &mut trace.standard_uncertainty {
            for (k, u) in own.iter_mut().enumerate() {
                *u = u.hypot(moved.velocity[k] - trace.velocity[k]);
            }
        }
    }
    Ok(trace)
}

/// Half the window in which a method is held against the smoother, samples.
const WINDOW: usize = 100;

/// Standard uncertainty of a method that states none: the root of its mean square distance from the smoother over the
/// 201 samples around each, and of the smoother's own variance there.
///
/// What the method makes of noise, rounding, delay and bending is in the distance. Off line only: the window looks ahead.
/// **Accuracy** `tests/method_coverage.rs`.
fn beside(trace: &VelocityTrace, smoother: &VelocityTrace) -> Vec<f64> {
    let n = trace.velocity.len();
    let mut sums = Vec::with_capacity(n + 1);
    sums.push(0.0);
    for (v, s) in trace.velocity.iter().zip(&smoother.velocity) {
        let last = sums[sums.len() - 1];
        sums.push(last + (v - s) * (v - s));
    }
    (0..n)
        .map(|k| {
            let (from, to) = (k.saturating_sub(WINDOW), (k + WINDOW + 1).min(n));
            let own = smoother.standard_uncertainty.as_ref().map_or(0.0, |u| u[k]);
            let mean = (sums[to] - sums[from]).max(0.0) / (to - from) as f64;
            (mean + own * own).sqrt()
        })
        .collect()
}
