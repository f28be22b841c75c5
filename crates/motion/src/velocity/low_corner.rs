//! The low-frequency corner of the accelerometer beside an estimate: the one that is stated, or the one that the readings tell.

use super::ground::{Ground, paired_tuning, tuning_part};
use super::{Settled, once};
use crate::diffuse::{Noise, Prepared, Unknowns};
use crate::findings;
use crate::search::line;
use crate::tuning::Constants;
use crate::{LowCorner, Method, MotionRecord, Pairing, ReadingSource, Tuned, Tuning};
use proofmass_core::numeric::upper_median;
use proofmass_core::{Error, Watch};
use proofmass_uncertainty::Finding;
use std::f64::consts::LN_10;

/// Corners that are looked for, Hz, as decades.
const DECADES: (f64, f64) = (-2.5, 1.0);
/// Probability of correlated innovations below which a corner is looked for at all.
const DOUBT: f64 = 0.05;
/// By how much ln L of the readings has to be higher at least, at noise that was not tuned.
const BETTER: f64 = 6.0;
/// Point of χ²(1) that one of a thousand passes.
const CHANCE: f64 = 10.83;

/// The corner that makes the readings most probable, where that is clearly above zero.
///
/// It is looked for where something speaks against the model without one: innovations that are correlated, an offset that walks, slip.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn seen(
    record: &MotionRecord,
    ground: &Ground,
    watch: &dyn Watch,
) -> Result<Option<LowCorner>, Error> {
    // One that was given back already is looked for no more.
    if !of_positions(record) || record.low_corner.is_some() || record.given_back.is_some() {
        return Ok(None);
    }
    let slips = ground.slip.as_ref().is_some_and(|s| !s.slip.is_empty());
    let own = ground.tuned.noise();
    let white = ground
        .tuned
        .whiteness
        .p_short
        .min(ground.tuned.whiteness.p_white)
        > DOUBT;
    if white && own.walk.is_none() && !slips {
        return Ok(None);
    }
    // What the corner took passes for slip: both models are held against all of the readings.
    let (part, plain) = match slips {
        false => (ground.part.clone(), ground.tuned.clone()),
        true => {
            let (part, _) = tuning_part(record, None);
            match tuned(&part, watch)? {
                Some(plain) => (part, plain),
                None => return Ok(None),
            }
        }
    };
    // At the noise that was found, and at that of the accelerometer alone.
    let floor = plain.noise_floor.unwrap_or(own.q).min(own.q);
    let quick = |decade: Option<f64>| -> f64 {
        let moved = decade.map_or_else(|| part.clone(), |d| at(&part, d));
        let prepared = Prepared::new(&moved, &plain.model);
        let unknowns = Unknowns {
            offset: true,
            ..plain.unknowns
        };
        let found = plain.noise();
        let small = part.increment.map_or(found.r, |d| d * d / 12.0);
        // A corner that is off by a tenth leaves a hundredth of the variance of what it took.
        let walked = |share: f64| found.walk.map(|walk| share * walk);
        let all = [
            (found.q, found.r, walked(1.0)),
            (floor, found.r, walked(1e-2)),
            (floor, found.r, walked(1e-4)),
            (found.q, found.r, None),
            (floor, found.r, None),
            (floor, small.min(found.r), None),
        ];
        all.into_iter()
            .filter_map(|(q, r, walk)| {
                let noise = Noise {
                    q,
                    r,
                    walk: walk.or(tied(&moved, q, plain.model.noise_form)),
                    ..found
                };
                let sums = prepared.sums(&noise, unknowns.gain || unknowns.latency);
                let found = sums.solve_concentrated(&moved, unknowns, f64::MIN_POSITIVE);
                found.map(|(_, value, _)| value)
            })
            .fold(f64::NEG_INFINITY, f64::max)
    };
    let nothing = quick(None);
    let steps = 14;
    let place = |k: usize| DECADES.0 + (DECADES.1 - DECADES.0) * k as f64 / steps as f64;
    let mut best = (f64::NEG_INFINITY, 0.0);
    for k in 0..=steps {
        watch.step("low corner", k as u64, steps as u64)?;
        let value = quick(Some(place(k)));
        if value > best.0 {
            best = (value, place(k));
        }
    }
    if best.0 < nothing + BETTER {
        return Ok(None);
    }
    // The noise is tuned anew at every corner.
    let near = line(best.1 - 0.25, best.1 + 0.25, 0.1, 0.01, |decade| {
        Ok(quick(Some(decade)))
    })?;
    let Some(right) = Local::around(&part, near.at, 0.04, watch)? else {
        return Ok(None);
    };
    let price = 0.5 * right.tuned.effective_readings.ln().max(CHANCE) * right.repeats;
    // What a model without a corner needs beside it is paid for like the corner: gain, latency, an offset that walks.
    let constants = |t: &Tuned| {
        let both = [t.gain.is_some(), t.latency.is_some()];
        both.map(f64::from).iter().sum::<f64>()
    };
    let walks = f64::from(plain.noise().walk.is_some());
    let more = 1.0 + constants(&right.tuned) - constants(&plain) - walks;
    // Tuning takes no reading for nearer than its rounding, of one model and not of the other: at one noise for both they are alike.
    let gained = (right.value - plain.log_likelihood).max(near.value - nothing);
    if gained < (more * price).max(BETTER) {
        return Ok(None);
    }
    right.corner(&part, watch)
}

/// Whether a corner is looked for: a wheel that slips a little, slopes and suspensions are no white noise of a speed either.
fn of_positions(record: &MotionRecord) -> bool {
    let positions = record.source == ReadingSource::Position;
    record.accelerometer && positions && !record.rests_only()
}

/// The corner that is found once more without what slips beside it, where something does.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn refined(
    record: &MotionRecord,
    corner: LowCorner,
    ground: &Ground,
    watch: &dyn Watch,
) -> Result<Option<LowCorner>, Error> {
    if ground.samples.len() == record.reading.len() {
        return Ok(None);
    }
    let Some(part) = record.within(ground.samples.clone()) else {
        return Ok(None);
    };
    match Local::around(&part, corner.frequency.log10(), 0.1, watch)? {
        Some(found) => found.corner(&part, watch),
        None => Ok(None),
    }
}

/// A part with the slow accelerations given back that a corner of this decade took.
fn at(part: &MotionRecord, decade: f64) -> MotionRecord {
    let corner = LowCorner {
        frequency: 10f64.powf(decade),
        uncertainty: 0.0,
        order: 1,
    };
    part.given_back(&corner, offset_behind(part, corner))
}

/// The most probable corner in a neighbourhood, the noise tuned anew at each.
struct Local {
    decade: f64,
    /// ln L there.
    value: f64,
    tuned: Tuned,
    /// How often the same rounding comes: that of the innovations of the model that holds.
    repeats: f64,
}

impl Local {
    fn around(
        part: &MotionRecord,
        decade: f64,
        half: f64,
        watch: &dyn Watch,
    ) -> Result<Option<Self>, Error> {
        let readings = part.reading.iter().flatten().count() as f64;
        let mut best: Option<Self> = None;
        line(decade - half, decade + half, half, 0.001, |decade| {
            let Some(tuned) = tuned(&at(part, decade), watch)? else {
                return Ok(-1e300);
            };
            let value = tuned.log_likelihood;
            if best.as_ref().is_none_or(|b| value > b.value) {
                best = Some(Self {
                    decade,
                    value,
                    repeats: (readings / tuned.effective_readings).max(1.0),
                    tuned,
                });
            }
            Ok(value)
        })?;
        Ok(best)
    }

    /// The corner with its standard uncertainty, by the fall of ln L on both sides; nothing where it does not fall.
    fn corner(&self, part: &MotionRecord, watch: &dyn Watch) -> Result<Option<LowCorner>, Error> {
        let beside = |by: f64| -> Result<f64, Error> {
            let found = tuned(&at(part, self.decade + by), watch)?;
            Ok(self.value - found.map_or(-1e300, |t| t.log_likelihood))
        };
        let mut step = 0.02;
        let mut fall = 0.5 * (beside(step)? + beside(-step)?);
        while fall < 1.0 && step < 0.3 {
            step *= 2.0;
            fall = 0.5 * (beside(step)? + beside(-step)?);
        }
        if fall <= 0.0 {
            return Ok(None);
        }
        let relative = LN_10 * step / (2.0 * fall / self.repeats).sqrt();
        let frequency = 10f64.powf(self.decade);
        LowCorner::new(frequency, (relative * frequency).min(0.5 * frequency), 1).map(Some)
    }
}

/// The walk that the integrated noise of the accelerometer makes of the offset.
pub(crate) fn tied(record: &MotionRecord, q: f64, form: crate::ProcessNoise) -> Option<f64> {
    let sample = match form {
        crate::ProcessNoise::SampleConstant => record.sample_time,
        crate::ProcessNoise::Continuous => 1.0,
    };
    let walk = |corner: LowCorner| corner.total_rate().powi(2) * q * sample;
    record.given_back.map(walk)
}

/// Tuning of a part beside its own pairing; nothing where it is not to be tuned.
fn tuned(part: &MotionRecord, watch: &dyn Watch) -> Result<Option<Tuned>, Error> {
    let pairing = Pairing::of(part).ok();
    match paired_tuning(part, &Tuning::default(), pairing.as_ref(), watch) {
        Ok(tuned) => Ok(Some(tuned)),
        Err(error) if error.is_cancelled() => Err(error),
        Err(_) => Ok(None),
    }
}

/// Blocks of which the slope of the offset is the median over their pairs.
const BLOCKS: usize = 120;
/// Seconds over which a velocity is that of the readings, for the offset behind a corner.
const SPAN: f64 = 0.05;

/// Offset behind the corner before anything is tuned: the slope of what the integral of the accelerometer is above the velocity of the
/// readings behind the same corner. The median over pairs of blocks passes slip by, which comes and goes.
fn offset_behind(record: &MotionRecord, corner: LowCorner) -> f64 {
    let (n, dt) = (record.reading.len(), record.sample_time);
    let path = record.positions();
    let span = ((SPAN / dt) as usize)
        .max(record.reading_stride())
        .clamp(1, n);
    let decay = (-corner.rate() * dt).exp();
    let (mut sum, mut velocity) = (0.0, 0.0);
    let mut stages = [[0.0; 2]; 2];
    let mut above = Vec::with_capacity(n);
    for k in 0..n {
        if k > 0 {
            sum += 0.5 * dt * (record.acceleration[k - 1] + record.acceleration[k]);
        }
        if let (Some(Some(before)), Some(now)) = (k.checked_sub(span).map(|j| path[j]), path[k]) {
            velocity = (now - before) / (span as f64 * dt);
        }
        let mut passed = velocity;
        for [input, output] in stages.iter_mut().take(usize::from(corner.order)) {
            *output = decay * (*output + passed - *input);
            *input = passed;
            passed = *output;
        }
        above.push(sum - passed);
    }
    let length = n / BLOCKS;
    if length == 0 {
        return 0.0;
    }
    let mut centres: Vec<(f64, f64)> = Vec::with_capacity(BLOCKS);
    for (i, block) in above.chunks_exact(length).enumerate() {
        let mut block = block.to_vec();
        if let Some(middle) = upper_median(&mut block) {
            centres.push(((i as f64 + 0.5) * length as f64 * dt, middle));
        }
    }
    let pairs = centres.iter().enumerate();
    let mut slopes: Vec<f64> = pairs
        .flat_map(|(i, a)| {
            centres[i + 1..]
                .iter()
                .map(move |b| (b.1 - a.1) / (b.0 - a.0))
        })
        .collect();
    upper_median(&mut slopes).unwrap_or(0.0)
}

/// Offset behind the corner, where the readings tell one: it is a ramp of what was given back, behind two stages a parabola, which no filter
/// on line knows.
fn behind(tuned: &Tuned, corner: LowCorner) -> Option<f64> {
    let shown = match corner.order {
        1 => tuned.ramp,
        _ => tuned.bend,
    };
    let shown = shown.filter(|r| r.value.abs() > 2.0 * r.uncertainty)?;
    Some(shown.value / corner.of_offset())
}

fn told(corner: &LowCorner) -> Finding {
    findings::low_corner_found(corner.frequency, corner.uncertainty, 1.0 / corner.rate())
}

/// The estimate with the slow accelerations given back; how uncertain the corner is adds to the velocity. One that nobody stated is told.
pub(super) fn beside(
    record: &MotionRecord,
    corner: LowCorner,
    (method, circumference): (Option<Method>, Option<f64>),
    tuning: &Tuning,
    watch: &dyn Watch,
) -> Result<Settled, Error> {
    let estimate = |offset: f64| {
        let right = record.given_back(&corner, offset);
        once(&right, method, circumference, tuning, watch)
    };
    let mut offset = offset_behind(record, corner);
    let mut settled = estimate(offset)?;
    let tuned = settled.result.tuned.as_ref();
    if let Some(rest) = tuned.and_then(|t| behind(t, corner)) {
        offset += rest;
        settled = estimate(offset)?;
    }
    let result = &mut settled.result;
    if corner.uncertainty > 0.0 {
        let off = LowCorner {
            frequency: corner.frequency + corner.uncertainty,
            ..corner
        };
        let moved = record.given_back(&off, offset);
        let by = |trace: &[f64], other: &[f64], u: &mut [f64]| {
            for ((u, a), b) in u.iter_mut().zip(trace).zip(other) {
                *u = u.hypot(a - b);
            }
        };
        let corrected = result.tuned.as_ref().map(|t| t.corrected(&moved));
        let corrected = corrected.as_ref().unwrap_or(&moved);
        let smoother = match (&result.smoother.method, &result.tuned) {
            (Method::Smoother { .. }, Some(tuned)) => tuned
                .smooth(&moved, Constants::Fitted)
                .map(|run| run.velocity),
            (method, _) => method.run(corrected).map(|run| run.velocity),
        };
        if let (Ok(other), Some(u)) = (smoother, &mut result.smoother.standard_uncertainty) {
            by(&result.smoother.velocity, &other, u);
        }
        let other = result.trace.method.run(corrected);
        if let (Ok(other), Some(u)) = (other, &mut result.trace.standard_uncertainty) {
            by(&result.trace.velocity, &other.velocity, u);
        }
    }
    result.low_corner = Some(corner);
    if record.low_corner.is_none() {
        result.findings.insert(0, told(&corner));
    }
    Ok(settled)
}
