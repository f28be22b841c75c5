//! What every question begins with: slip, pairing of the sensors, the part that is tuned on.

use crate::crossover::kalman_beside;
use crate::findings;
use crate::pairing::{OPPOSITE, OVER, decoding};
use crate::tuning::Constants;
use crate::{
    Blow, Crossover, Episode, Method, MotionRecord, Pairing, ReadingSource, SlipReport, SlipSearch,
    Tuned, TunedValue, Tuning, kalman_by_smoother,
};
use proofmass_core::numeric::upper_median;
use proofmass_core::{Error, Watch};
use proofmass_uncertainty::{Finding, Severity};
use std::ops::Range;

/// Refuses methods that need a sensor that is not there.
pub(super) fn check_sensors(record: &MotionRecord, methods: &[Method]) -> Result<(), Error> {
    let lacks = |name| {
        Err(Error::TooFew {
            name,
            needed: 1,
            got: 0,
        })
    };
    if !record.accelerometer && methods.iter().any(Method::needs_accelerometer) {
        return lacks("accelerometers");
    }
    if record.rests_only() && methods.iter().any(Method::needs_readings) {
        return lacks("readings of position or speed");
    }
    Ok(())
}

/// Slip, and whether both sensors see one motion; nothing where there is one sensor.
///
/// What a gain or a latency of the accelerometer explains is no slip.
pub(crate) fn sensors(record: &MotionRecord) -> (Option<SlipReport>, Option<Pairing>) {
    if !record.accelerometer || record.rests_only() {
        return (None, None);
    }
    let search = search_of(record);
    let mut slip = search.run(record).ok();
    if record.source == ReadingSource::Position
        && let Some(plain) = slip.as_ref().filter(|s| !s.slip.is_empty())
        && let Some(other) = search.alternative(record, &[])
        && let Ok(beside) = search.run(&record.corrected(other.gain, other.latency))
        && plain.explained_by(&beside)
    {
        slip = Some(plain.decided(&beside, &other));
    }
    let pairing = pairing_beside(record, slip.as_ref());
    (slip, pairing)
}

/// What is told of a record before its velocity: slip, pairing, and the noise of the part without slip.
#[derive(Clone)]
pub(crate) struct Ground {
    pub(crate) slip: Option<SlipReport>,
    pub(crate) pairing: Option<Pairing>,
    /// The part that was tuned on.
    pub(crate) part: MotionRecord,
    /// Its samples.
    pub(crate) samples: Range<usize>,
    pub(crate) tuned: Tuned,
}

impl Ground {
    /// Tunes on the part without slip, and asks anew what is slip beside the gain and the latency that were found: what they
    /// explain is none, and the part is longer.
    pub(crate) fn of(
        record: &MotionRecord,
        (mut slip, mut pairing): (Option<SlipReport>, Option<Pairing>),
        tuning: &Tuning,
        watch: &dyn Watch,
    ) -> Result<Self, Error> {
        let (mut part, mut samples) = tuning_part(record, slip.as_ref());
        let mut tuned = paired_tuning(&part, tuning, pairing.as_ref(), watch)?;
        if let Some(less) = slip.as_ref().and_then(|s| less_slip(record, s, &tuned)) {
            pairing = pairing_beside(record, Some(&less));
            slip = Some(less);
            (part, samples) = tuning_part(record, slip.as_ref());
            tuned = paired_tuning(&part, tuning, pairing.as_ref(), watch)?;
        }
        Ok(Self {
            slip,
            pairing,
            part,
            samples,
            tuned,
        })
    }
}

/// What is still slip beside gain and latency that were tuned, where that is less.
fn less_slip(record: &MotionRecord, slip: &SlipReport, tuned: &Tuned) -> Option<SlipReport> {
    let constants = tuned.gain.is_some() || tuned.latency.is_some();
    if record.source != ReadingSource::Position || slip.slip.is_empty() || !constants {
        return None;
    }
    let beside = search_of(record).run(&tuned.corrected(record)).ok()?;
    slip.explained_by(&beside)
        .then(|| slip.with_slip_of(&beside))
}

/// The record with the collisions that were found as blows, unless its own are stated.
///
/// What an accelerometer misses of a blow, by its rate, its bandwidth or its range, may be as much as what it shows.
pub(super) fn with_blows(record: &MotionRecord, slip: Option<&SlipReport>) -> MotionRecord {
    let mut record = record.clone();
    if record.blows.is_empty() {
        let found = slip.iter().flat_map(|s| &s.collisions);
        record.blows = found.map(|e| blow(&record.acceleration, e)).collect();
    }
    record
}

/// The blow of a collision: where the acceleration is a tenth of its highest value and more, and the samples through which a curve
/// brings it to the steps beside; what rings on is seen.
fn blow(acceleration: &[f64], episode: &Episode) -> Blow {
    const BESIDE: usize = 3;
    let n = acceleration.len();
    let last = episode.to.clamp(1, n);
    let inside = episode.from.min(last - 1)..last;
    let mut sorted = acceleration[inside.clone()].to_vec();
    let level = upper_median(&mut sorted).unwrap_or(0.0);
    let size = |k: usize| (acceleration[k] - level).abs();
    let peak = inside
        .max_by(|a, b| size(*a).total_cmp(&size(*b)))
        .unwrap_or(0);
    let strong = |k: &usize| size(*k) > 0.1 * size(peak);
    let from = (0..=peak).rev().take_while(strong).last();
    let to = (peak..n).take_while(strong).last();
    Blow {
        from: from.unwrap_or(peak).saturating_sub(BESIDE),
        to: (to.unwrap_or(peak) + 1 + BESIDE).min(n),
        velocity: episode.velocity.abs(),
    }
}

/// Tuning in which a latency of more than half a step is taken off first: the likelihood knows it only as a slope.
pub(crate) fn paired_tuning(
    part: &MotionRecord,
    tuning: &Tuning,
    pairing: Option<&Pairing>,
    watch: &dyn Watch,
) -> Result<Tuned, Error> {
    let half = 0.5 * part.sample_time;
    // Slope and pitch take from the correlation of a vehicle's sensors, and leave the time of its maximum.
    let clear = |p: &Pairing| match part.source {
        ReadingSource::Position => p.is_clear(),
        ReadingSource::Speed => p.correlation.abs() > 0.4,
    };
    let told = pairing.filter(|p| {
        tuning.pairing && clear(p) && p.latency.abs() > (4.0 * p.latency_uncertainty).max(half)
    });
    // Between its samples the noise of the accelerometer is not what it is at them; a speed leaves the rest to a slope.
    let step = part.sample_time;
    let taken = |latency: f64| match part.source {
        ReadingSource::Position => latency,
        ReadingSource::Speed => (latency / step).round() * step,
    };
    let mut before = told.map_or(0.0, |p| taken(p.latency));
    // Once there is a latency, its rest is unknown, however small.
    let run = |shift: f64, late: bool| {
        let moved = part.corrected(1.0, shift);
        // By whole samples the noise stays what it is.
        let heard = match part.source {
            ReadingSource::Position => &part.acceleration,
            ReadingSource::Speed => &moved.acceleration,
        };
        tuning.search(&moved, late, heard, watch)
    };
    let mut tuned = run(before, told.is_some())?;
    if part.source == ReadingSource::Speed && tuning.pairing && part.accelerometer {
        for _ in 0..2 {
            let Some(latency) = tuned.likely_latency(part).map(taken) else {
                break;
            };
            if (latency - before).abs() < 0.5 * step {
                break;
            }
            before = latency;
            tuned = run(before, true)?;
        }
    }
    for _ in 0..2 {
        match tuned.latency {
            Some(rest) if rest.value.abs() > half => {
                before += taken(rest.value);
                tuned = run(before, true)?;
            }
            _ => break,
        }
    }
    tuned.shifted_before(before);
    Ok(tuned)
}

/// Tolerance of the sensitivity of accelerometers by their data sheets: a gain within it that was found and used is no fault.
const TOLERANCE: f64 = 0.03;

/// What gain and latency between the sensors make one doubt; where they were found and used, that.
///
/// Of the readings that were tuned on fewer are new where rounding repeats with the motion; the regression takes all of them for new.
pub(crate) fn doubts(
    record: &MotionRecord,
    pairing: Option<&Pairing>,
    tuned: Option<&Tuned>,
    readings: usize,
) -> Vec<Finding> {
    let repeated = tuned.map_or(1.0, |t| (readings as f64 / t.effective_readings).max(1.0));
    let told =
        |p: &Pairing| (p.gain.abs() - 1.0).abs() > 4.0 * p.gain_uncertainty * repeated.sqrt();
    // A constant that paid for itself in one model may be told less well in the one that was chosen.
    let beyond = |found: &TunedValue, expected: f64| {
        (found.value - expected).abs() > 3.0 * found.uncertainty
    };
    let gain = tuned.and_then(|t| t.gain);
    let found = pairing.iter().flat_map(|p| &p.findings);
    let opposite = found.clone().any(|f| f.code() == OPPOSITE);
    // Of the other sense the size is one doubt, and the sense another.
    let used = gain.filter(|g| beyond(g, if opposite { -1.0 } else { 1.0 }));
    let latency = tuned.and_then(|t| t.latency);
    let decides = |f: &Finding| f.severity() == Severity::Decision;
    let mut findings: Vec<Finding> = pairing
        .iter()
        .flat_map(|p| p.findings.iter().map(move |f| (p, f)))
        .filter(|(p, f)| match f.code() {
            // One gain is one doubt: that which is used.
            "gain-mismatch" => used.is_none() && (decides(f) || (gain.is_none() && told(p))),
            "latency" => latency.is_none(),
            _ => true,
        })
        .map(|(_, f)| f.clone())
        .collect();
    if let Some(gain) = used {
        let decoding = decoding(record, gain.value, gain.uncertainty).unwrap_or_default();
        let finding = findings::gain_mismatch(
            &format!("{decoding}; the gain was estimated and is used"),
            gain.value,
            gain.uncertainty,
            OVER,
        );
        let mut wrong = found.filter(|f| f.code() == "gain-mismatch");
        let wrong = wrong.any(decides);
        let usual = (gain.value.abs() - 1.0).abs() < TOLERANCE + 3.0 * gain.uncertainty;
        findings.push(match (wrong, usual) {
            (true, _) => finding.at(Severity::Decision),
            (false, true) => finding.at(Severity::Note),
            (false, false) => finding,
        });
    }
    if let Some(latency) = latency.filter(|t| beyond(t, 0.0)) {
        let late = if latency.value > 0.0 {
            "later"
        } else {
            "earlier"
        };
        findings.push(
            findings::latency(
                late,
                "; the time was estimated and is used",
                1e3 * latency.value,
                1e3 * latency.uncertainty,
                "",
            )
            .at(Severity::Note),
        );
    }
    findings
}

/// The Kalman filter closest to the smoother of a tuned model on the part it was tuned on.
///
/// On line a part of the readings' noise that is correlated in time counts as white noise of its density at low
/// frequencies; the smoother knows it as it is.
pub(crate) fn on_line_kalman(tuned: &Tuned, part: &MotionRecord) -> Result<Crossover, Error> {
    let right = tuned.corrected(part);
    let Some(coloured) = tuned.coloured else {
        return kalman_by_smoother(&tuned.model, &right, settle(part));
    };
    let reference = tuned.smooth(part, Constants::Fitted)?;
    let variance = coloured.deviation * coloured.deviation;
    let readings = part.reading.iter().flatten().count().max(1) as f64;
    let between = part.sample_time * part.reading.len() as f64 / readings;
    let alike = (-between / coloured.time).exp();
    let mut model = tuned.model;
    model.reading_noise += variance * ((1.0 + alike) / (1.0 - alike) - 1.0);
    kalman_beside(
        &model,
        &right,
        (&reference.velocity, &reference.uncertainty),
        settle(part),
        0.01,
    )
}

/// A tenth of the record, at most a second: filters that start with a wrong velocity settle there.
pub(super) fn settle(record: &MotionRecord) -> usize {
    let n = record.reading.len();
    ((1.0 / record.sample_time) as usize).min(n / 10)
}

/// The search for slip with windows that hold several readings of this record.
pub(crate) fn search_of(record: &MotionRecord) -> SlipSearch {
    let search = SlipSearch::default();
    let step = record.sample_time;
    let between = record.reading_stride() as f64 * step;
    SlipSearch {
        window: search.window.max(5.0 * step).max(4.0 * between),
        blow: search.blow.max(2.0 * step),
        ..search
    }
}

/// Samples before and after an episode that its windows still touch.
pub(crate) fn margin(record: &MotionRecord) -> usize {
    (search_of(record).window / record.sample_time).round() as usize
}

/// Gain and latency on the longest stretch without slip. Where that is too short to tell, on the whole record, and
/// then only of one motion beyond doubt: a wrong unit looks like slip all over.
fn pairing_beside(record: &MotionRecord, slip: Option<&SlipReport>) -> Option<Pairing> {
    let margin = margin(record);
    let clean = longest(record.reading.len(), |k| {
        !slip.is_some_and(|s| s.slips(k, margin)) && !record.gapes(k, 0)
    });
    let whole = clean.len() == record.reading.len();
    let inside = part(record, clean).and_then(|part| Pairing::of(&part).ok());
    if whole || inside.as_ref().is_some_and(Pairing::is_clear) {
        return inside;
    }
    let all = Pairing::of(record).ok();
    all.filter(|p| p.correlation.abs() > 0.97).or(inside)
}

/// Most samples a search for the noise needs.
const ENOUGH: usize = 20_000;

/// The longest stretch without slip, or the liveliest part of it.
pub(crate) fn tuning_part(
    record: &MotionRecord,
    slip: Option<&SlipReport>,
) -> (MotionRecord, Range<usize>) {
    let n = record.reading.len();
    let margin = margin(record);
    let clear = |k: usize| !slip.is_some_and(|s| s.slips(k, margin)) && !record.gapes(k, 0);
    let hit = |b: &Blow, k: usize| k + margin >= b.from && k < b.to + margin;
    let clean = longest(n, clear);
    let without = longest(n, |k| clear(k) && !record.blows.iter().any(|b| hit(b, k)));
    // What is heard in a blow is no noise; but many short parts tell less than all of them.
    let clean = match 2 * without.len() > clean.len() {
        true => without,
        false => clean,
    };
    let range = if clean.len() <= ENOUGH {
        clean
    } else {
        let mut last = None::<f64>;
        let path: Vec<f64> = record.reading[clean.clone()]
            .iter()
            .map(|r| {
                let step = match (r, last) {
                    (Some(r), Some(l)) => (r - l).abs(),
                    _ => 0.0,
                };
                last = r.or(last);
                step
            })
            .collect();
        let block = |k: &usize| path[*k..*k + ENOUGH].iter().sum::<f64>();
        let liveliest = (0..=path.len() - ENOUGH)
            .step_by(ENOUGH / 2)
            .max_by(|a, b| block(a).total_cmp(&block(b)))
            .unwrap_or(0);
        clean.start + liveliest..clean.start + liveliest + ENOUGH
    };
    match part(record, range.clone()) {
        Some(part) => (part, range),
        None => (record.clone(), 0..n),
    }
}

pub(crate) fn part_finding(record: &MotionRecord, samples: &Range<usize>) -> Option<Finding> {
    let n = record.reading.len();
    let dt = record.sample_time;
    (samples.len() < n).then(|| {
        findings::tuned_on_a_part(
            record.start + samples.start as f64 * dt,
            record.start + samples.end as f64 * dt,
            n as f64 * dt,
        )
    })
}

/// Longest run of samples for which `good` holds.
pub(crate) fn longest(n: usize, good: impl Fn(usize) -> bool) -> Range<usize> {
    let mut best = 0..0;
    for run in runs(n, good) {
        if run.len() > best.len() {
            best = run;
        }
    }
    best
}

/// Runs of samples for which `good` holds.
pub(crate) fn runs(n: usize, good: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let (mut list, mut from) = (Vec::new(), 0);
    for k in 0..=n {
        if k == n || !good(k) {
            if k > from {
                list.push(from..k);
            }
            from = k + 1;
        }
    }
    list
}

/// A stretch of a record; the velocity at its start is unknown unless it is the beginning.
pub(crate) fn part(record: &MotionRecord, range: Range<usize>) -> Option<MotionRecord> {
    let part = record.within(range)?;
    (part.reading.iter().flatten().count() >= 100).then_some(part)
}
