//! Slow counted axes after tuning: filter and smoother at the edges, gain and latency with their uncertainty.

use crate::counting::{Counted, CountingModel, CountingRun, CountingTuned, counts, is_slow};
use crate::{MotionRecord, Tuned, TunedValue};
use proofmass_core::{Error, Watch};

/// Filter and smoother that take counts for what they are, and the noise found with them in place of that of the
/// likelihood of all readings. `None` for records that are no slow counts.
///
/// A gain or latency that was found is found anew from the edges (to all readings rounding is noise, and on a slow axis
/// it is none), and left out where the edges do not pay for it; what moving them by their uncertainty does to the velocity is added to its variance.
///
/// An axis that moves by nearly a whole number of counts from sample to sample rounds alike for many samples, as a slow one does:
/// less that even speed it is one.
///
/// # Errors
/// [`Error::Cancelled`], and of the record.
pub(crate) fn on_edges(
    tuned: &mut Tuned,
    part: &MotionRecord,
    record: &MotionRecord,
    watch: &dyn Watch,
) -> Result<Option<(CountingModel, CountingRun)>, Error> {
    let Some(per_sample) = whole_counts(part) else {
        return at_edges(tuned, part, record, watch);
    };
    let (part, _) = less_even_speed(part, per_sample);
    let (record, speed) = less_even_speed(record, per_sample);
    let mut found = at_edges(tuned, &part, &record, watch)?;
    if let Some((_, run)) = &mut found {
        for (velocity, _) in [&mut run.filtered, &mut run.smoothed] {
            velocity.iter_mut().for_each(|v| *v += speed);
        }
    }
    Ok(found)
}

/// Share of the samples in which the count moves by the same whole number, above which the rest is a slow axis.
const ALIKE: f64 = 0.75;

/// The whole number of counts, not zero, by which most samples move.
pub(crate) fn whole_counts(record: &MotionRecord) -> Option<i32> {
    let counts = counts(record).filter(|c| record.edges.is_none() && !is_slow(c))?;
    let mut steps: Vec<i32> = counts
        .windows(2)
        .filter_map(|w| w[1]?.checked_sub(w[0]?))
        .collect();
    let n = steps.len();
    steps.sort_unstable();
    let most = *steps.get(n / 2)?;
    let alike = steps.iter().filter(|s| **s == most).count();
    (most != 0 && alike as f64 > ALIKE * n as f64).then_some(most)
}

/// The record less an even speed of so many counts a sample, and that speed.
fn less_even_speed(record: &MotionRecord, per_sample: i32) -> (MotionRecord, f64) {
    let step = f64::from(per_sample) * record.increment.unwrap_or(0.0);
    let speed = step / record.sample_time;
    let mut less = record.clone();
    for (k, reading) in less.reading.iter_mut().enumerate() {
        *reading = reading.map(|r| r - k as f64 * step);
    }
    less.initial_velocity = record.initial_velocity.map(|v| v - speed);
    (less, speed)
}

fn at_edges(
    tuned: &mut Tuned,
    part: &MotionRecord,
    record: &MotionRecord,
    watch: &dyn Watch,
) -> Result<Option<(CountingModel, CountingRun)>, Error> {
    let right = tuned.corrected(part);
    let Some(counted) = Counted::new(&right).filter(Counted::is_slow) else {
        return Ok(None);
    };
    let heard = |tuned: &Tuned| -> Vec<f64> {
        let gain = tuned.gain.map_or(1.0, |g| g.value);
        part.acceleration.iter().map(|a| a / gain).collect()
    };
    let mut found = counted.tune(&heard(tuned), watch)?;
    let mut columns = Vec::new();
    if tuned.gain.is_some() || tuned.latency.is_some() {
        for _ in 0..2 {
            let Some(constants) = constants(tuned, part, &found.model, watch)? else {
                columns = own_columns(tuned);
                break;
            };
            let [gain, latency] = constants.found;
            (tuned.gain, tuned.latency) = (gain, latency);
            columns = constants.columns;
            let right = tuned.corrected(part);
            let Some(counted) = Counted::new(&right) else {
                return Ok(None);
            };
            found = counted.tune(&heard(tuned), watch)?;
        }
        if let Some(without) = paid_for(tuned, part, &found.model, watch)? {
            (tuned.gain, tuned.latency) = (None, None);
            (columns, found) = (Vec::new(), without);
        }
    }
    let whole = tuned.corrected(record);
    let Some(all) = Counted::new(&whole) else {
        return Ok(None);
    };
    let mut run = all.run_tuned(&found)?;
    for [gain, latency] in columns {
        let moved = record.corrected(
            tuned.gain.map_or(1.0, |g| g.value) + gain,
            tuned.latency.map_or(0.0, |t| t.value) + latency,
        );
        let Some(moved) = Counted::new(&moved).map(|c| c.run(&found.model)) else {
            continue;
        };
        let moved = moved?;
        for (own, moved) in [
            (&mut run.filtered, &moved.filtered),
            (&mut run.smoothed, &moved.smoothed),
        ] {
            for k in 0..own.1.len() {
                own.1[k] = own.1[k].hypot(moved.0[k] - own.0[k]);
            }
        }
    }
    let innovations: Vec<f64> = run.innovations.iter().map(|i| i.1).collect();
    tuned.counted(&found, &innovations, part)?;
    if let Some(counted) = Counted::new(&tuned.corrected(part)) {
        tuned.log_likelihood = counted.log_likelihood(&found.model)?;
    }
    Ok(Some((found.model, run)))
}

/// The noise without gain and latency, where the edges do not pay for these: to all readings of an axis that rests, its
/// rounding may have posed as one.
fn paid_for(
    tuned: &Tuned,
    part: &MotionRecord,
    model: &CountingModel,
    watch: &dyn Watch,
) -> Result<Option<CountingTuned>, Error> {
    if part.gain_uncertainty.is_some() {
        return Ok(None);
    }
    let with = match Counted::new(&tuned.corrected(part)) {
        Some(counted) => counted.log_likelihood(model)?,
        None => f64::NEG_INFINITY,
    };
    let Some(plain) = Counted::new(part) else {
        return Ok(None);
    };
    let without = plain.tune(&part.acceleration, watch)?;
    let constants = [tuned.gain, tuned.latency].into_iter().flatten().count();
    let readings = part.reading.iter().flatten().count() as f64;
    let effective = tuned.effective_readings;
    let price = 0.5 * effective.ln().max(10.83) * (readings / effective).max(1.0);
    let brings = with - plain.log_likelihood(&without.model)?;
    Ok((brings < constants as f64 * price).then_some(without))
}

/// Gain and latency each moved by its uncertainty, as all readings have it.
fn own_columns(tuned: &Tuned) -> Vec<[f64; 2]> {
    let u = |found: Option<TunedValue>| found.map(|f| f.uncertainty);
    let gain = u(tuned.gain).map(|u| [u, 0.0]);
    let latency = u(tuned.latency).map(|u| [0.0, u]);
    gain.into_iter().chain(latency).collect()
}

/// Gain and latency as the edges have them.
struct EdgeConstants {
    found: [Option<TunedValue>; 2],
    /// Columns of a square root of their covariance.
    columns: Vec<[f64; 2]>,
}

/// Newton's method on the likelihood of the edges, for the constants that were found, in units of their uncertainty.
/// `None` where the edges do not determine them.
fn constants(
    tuned: &Tuned,
    part: &MotionRecord,
    model: &CountingModel,
    watch: &dyn Watch,
) -> Result<Option<EdgeConstants>, Error> {
    let start = [tuned.gain, tuned.latency];
    let least = [1e-5, 1e-5 * part.sample_time];
    let free: Vec<usize> = (0..2).filter(|&i| start[i].is_some()).collect();
    let mut at = [1.0, 0.0];
    let mut scale = least;
    for &i in &free {
        if let Some(found) = start[i] {
            at[i] = found.value;
            scale[i] = found.uncertainty.max(least[i]);
        }
    }
    let mut passes = 0;
    let mut value = |at: [f64; 2]| -> Result<f64, Error> {
        passes += 1;
        watch.step("gain and latency at the edges", passes, 0)?;
        let moved = part.corrected(at[0], at[1]);
        let off = part.gain_uncertainty.map_or(0.0, |u| (at[0] - 1.0) / u);
        match Counted::new(&moved) {
            Some(counted) => Ok(counted.log_likelihood(model)? - 0.5 * off * off),
            None => Ok(-1e300),
        }
    };
    for _ in 0..8 {
        let moved = |steps: &[(usize, f64)]| {
            let mut at = at;
            for &(i, by) in steps {
                at[i] += by * scale[i];
            }
            at
        };
        let centre = value(at)?;
        let d = free.len();
        let (mut slope, mut curvature) = ([0.0; 2], [[0.0; 2]; 2]);
        for (p, &i) in free.iter().enumerate() {
            let (up, down) = (value(moved(&[(i, 1.0)]))?, value(moved(&[(i, -1.0)]))?);
            slope[p] = 0.5 * (up - down);
            curvature[p][p] = 2.0 * centre - up - down;
        }
        if d == 2 {
            let (i, j) = (free[0], free[1]);
            let mut corner = |a: f64, b: f64| value(moved(&[(i, a), (j, b)]));
            let mixed =
                corner(1.0, 1.0)? - corner(1.0, -1.0)? - corner(-1.0, 1.0)? + corner(-1.0, -1.0)?;
            curvature[0][1] = -0.25 * mixed;
            curvature[1][0] = curvature[0][1];
        } else {
            curvature[1][1] = 1.0;
        }
        let [[a, b], [_, c]] = curvature;
        let determinant = a * c - b * b;
        if !(a > 0.0 && determinant > 0.0 && determinant.is_finite()) {
            return Ok(None);
        }
        let covariance = [[c / determinant, -b / determinant], [0.0, a / determinant]];
        let step = [
            covariance[0][0] * slope[0] + covariance[0][1] * slope[1],
            covariance[0][1] * slope[0] + covariance[1][1] * slope[1],
        ];
        let far = step[..d].iter().fold(0.0f64, |m, s| m.max(s.abs()));
        let shorter = (4.0 / far).min(1.0);
        for (p, &i) in free.iter().enumerate() {
            at[i] += shorter * step[p] * scale[i];
        }
        // Within a tenth of a standard uncertainty, by differences that span about one: the likelihood of edges is not
        // smooth over much less.
        let done = (0..d).all(|p| {
            let u = covariance[p][p].sqrt();
            step[p].abs() < 0.1 * u && (0.5..2.0).contains(&u)
        });
        if done {
            // Edges that repeat with the motion tell the same again.
            let readings = part.reading.iter().flatten().count() as f64;
            let repeated = (readings / tuned.effective_readings).max(1.0);
            let covariance = covariance.map(|row| row.map(|c| c * repeated));
            let first = covariance[0][0].sqrt();
            let lower = covariance[0][1] / first;
            let second = (covariance[1][1] - lower * lower).max(0.0).sqrt();
            let mut columns = vec![[0.0; 2]; d];
            columns[0][free[0]] = first * scale[free[0]];
            if d == 2 {
                columns[0][1] = lower * scale[1];
                columns[1][1] = second * scale[1];
            }
            let found = std::array::from_fn(|i| {
                free.iter().position(|&f| f == i).map(|p| TunedValue {
                    value: at[i],
                    uncertainty: covariance[p][p].sqrt() * scale[i],
                })
            });
            return Ok(Some(EdgeConstants { found, columns }));
        }
        // The next differences span a standard uncertainty.
        for (p, &i) in free.iter().enumerate() {
            scale[i] = (scale[i] * covariance[p][p].sqrt()).max(least[i]);
        }
    }
    Ok(None)
}
