//! Counts whose edges were timed: from the list of a capture to the samples of a record, and methods that live on edges.

use crate::{MotionRecord, PassedAt, ReadingSource, TimedEdges};
use proofmass_core::velocity::{Edge, FixedPosition, MixedTime, MixedTimeState, ReadingKind};
use proofmass_core::{Error, check};
use std::collections::VecDeque;

/// Puts every edge where it is: at the larger of the counts before and after it, in both senses.
///
/// `places` holds the count after each edge times the increment. The count after an edge that is passed up is another one
/// than after the same edge passed down; its place is not.
pub fn edge_places(places: &mut [f64], increment: f64) {
    let mut before = places.first().copied().unwrap_or(0.0);
    for place in places {
        let after = *place;
        // Down by one count: the edge is the upper end of the cell it leads to.
        if (after - before + increment).abs() < 1e-6 * increment {
            *place += increment;
        }
        before = after;
    }
}

/// Rows of a capture as counts after each edge, in increments; rows that are no edge are left out.
///
/// A log of counts says the count after each edge. A log of places says the place of each edge: where the axis turns back, the
/// same place stands in two rows. `decoded` are counts of logic levels, of which a repeated one is no edge. Which of the two
/// another log is follows from its repeated rows: those of places come where, and only where, the sense changes.
pub fn edge_counts(rows: &[f64], decoded: bool) -> Vec<(usize, f64)> {
    if !decoded && let Some(list) = from_places(rows) {
        return list;
    }
    let mut list: Vec<(usize, f64)> = Vec::with_capacity(rows.len());
    for (k, count) in rows.iter().enumerate() {
        if list.last().is_none_or(|last| last.1 != *count) {
            list.push((k, *count));
        }
    }
    list
}

/// `None` for rows that are not the places of edges.
fn from_places(rows: &[f64]) -> Option<Vec<(usize, f64)>> {
    let mut list: Vec<(usize, f64)> = Vec::with_capacity(rows.len());
    let mut sense = None::<bool>;
    let mut turned = false;
    for (k, place) in rows.iter().enumerate() {
        if let Some(before) = k.checked_sub(1).map(|j| rows[j]) {
            if *place == before {
                turned = true;
                sense = sense.map(|up| !up);
            } else {
                let up = *place > before;
                if sense.is_some_and(|s| s != up) {
                    return None;
                }
                if sense.is_none() {
                    // The rows before were passed in the same sense, or turned back as often as they repeat.
                    let turns = list.len().saturating_sub(1);
                    for (j, row) in list.iter_mut().enumerate() {
                        let same = (turns - j).is_multiple_of(2) == up;
                        row.1 = if same { row.1 } else { row.1 - 1.0 };
                    }
                }
                sense = Some(up);
            }
        }
        let after = if sense == Some(false) {
            place - 1.0
        } else {
            *place
        };
        list.push((k, after));
    }
    turned.then_some(list)
}

/// Gives a record the counts at its samples, and the edges with their ages.
///
/// `time` are the times of the edges after the record's first sample, `count` the counts after each of them in increments; a
/// row whose count is that of the row before is no edge ([`edge_counts`]). Before the first row nothing is known: samples there have no
/// reading. Where a row jumps by more than a count, edges were lost, and none of its sample is used.
///
/// # Errors
/// [`Error::Length`] for lists of unequal length; [`Error::NotIncreasing`] for times that run back; [`Error::OutOfRange`]
/// for a tick or an increment that is not positive, or counts beyond 2³¹; of the record.
pub fn time_edges(
    record: &MotionRecord,
    time: &[f64],
    count: &[f64],
    increment: f64,
    tick: f64,
) -> Result<MotionRecord, Error> {
    if time.len() != count.len() {
        return Err(Error::Length {
            name: "counts of the edges",
            expected: time.len(),
            got: count.len(),
        });
    }
    if let Some(k) = time.windows(2).position(|w| !(w[1] >= w[0])) {
        return Err(Error::NotIncreasing {
            name: "edge time",
            index: k + 1,
        });
    }
    check::positive("increment", increment)?;
    check::positive("tick", tick)?;
    let origin = count.first().copied().unwrap_or(0.0);
    if let Some(far) = count.iter().find(|c| !((**c - origin).abs() < 2e9)) {
        return Err(Error::OutOfRange {
            name: "count of an edge",
            value: *far,
            min: origin - 2e9,
            max: origin + 2e9,
        });
    }
    let step = record.sample_time;
    let n = record.acceleration.len();
    let mut list = Vec::with_capacity(time.len());
    let mut next = 0;
    let mut now = None;
    let mut reading = Vec::with_capacity(n);
    for k in 0..n {
        let at = step * k as f64;
        while let Some(t) = time.get(next).filter(|t| **t <= at) {
            if let Some(before) = now {
                let change: f64 = count[next] - before;
                if (change.abs() - 1.0).abs() < 1e-6 {
                    list.push(PassedAt {
                        sample: k,
                        age: at - t,
                        upwards: change > 0.0,
                    });
                }
            }
            now = Some(count[next]);
            next += 1;
        }
        reading.push(now.map(|c| c * increment));
    }
    let mut timed = record.clone();
    timed.source = ReadingSource::Position;
    timed.reading = reading;
    timed.increment = Some(increment);
    timed.edges = Some(TimedEdges { tick, list });
    timed.check()?;
    Ok(timed)
}

/// Edges of a record as a timer captures them, sample by sample.
struct Captures {
    increment: f64,
    tick: f64,
    /// Clock at each sample, and the edges before it; `None` where edges were lost.
    samples: Vec<(u32, Option<Vec<Edge>>)>,
}

fn captures(record: &MotionRecord) -> Result<Captures, Error> {
    let (Some(timed), Some(increment)) = (&record.edges, record.increment) else {
        return Err(Error::TooFew {
            name: "timed edges",
            needed: 1,
            got: 0,
        });
    };
    let clock = |t: f64| (t / timed.tick).round() as i64 as u32;
    let mut samples = Vec::with_capacity(record.reading.len());
    let mut next = 0;
    let mut before = None::<i32>;
    for (k, reading) in record.reading.iter().enumerate() {
        let at = record.sample_time * k as f64;
        let count = reading.map(|r| (r / increment).round() as i64 as i32);
        let mut edges = Vec::new();
        let mut now = before;
        while let Some(edge) = timed.list.get(next).filter(|e| e.sample <= k) {
            now = now.map(|n| n.wrapping_add(if edge.upwards { 1 } else { -1 }));
            edges.push(Edge {
                count: now.unwrap_or(0),
                ticks: clock(at - edge.age),
                upwards: edge.upwards,
            });
            next += 1;
        }
        let whole = now == count && count.is_some();
        samples.push((clock(at), whole.then_some(edges)));
        before = count.or(before);
    }
    Ok(Captures {
        increment,
        tick: timed.tick,
        samples,
    })
}

/// Mean of the delays that were stated.
fn mean(delays: &[f64]) -> f64 {
    delays.iter().sum::<f64>() / delays.len().max(1) as f64
}

/// M/T as the chip runs it, and its mean delay.
pub(crate) fn mixed_time(record: &MotionRecord, timeout: f64) -> Result<(Vec<f64>, f64), Error> {
    let captures = captures(record)?;
    let filter = MixedTime::<f64>::new(captures.increment, 1.0 / captures.tick, timeout)?;
    let mut state = None::<MixedTimeState<f64>>;
    let mut v = record.start_velocity().0;
    let (mut velocity, mut delays) = (Vec::new(), Vec::new());
    for (clock, edges) in &captures.samples {
        match (&mut state, edges) {
            // Where edges were lost the next interval begins anew.
            (_, None) => state = None,
            (Some(state), Some(edges)) => {
                let reading = filter.step(state, *clock, edges.last().copied());
                v = reading.velocity;
                if reading.kind == ReadingKind::Measured {
                    delays.push(reading.delay);
                }
            }
            (None, Some(edges)) => state = edges.last().map(|e| MixedTimeState::new(*e)),
        }
        velocity.push(v);
    }
    Ok((velocity, mean(&delays)))
}

/// T over n edges in one sense; held between them.
pub(crate) fn fixed_position(record: &MotionRecord, n: usize) -> Result<(Vec<f64>, f64), Error> {
    if !(1..=100_000).contains(&n) {
        return Err(Error::OutOfRange {
            name: "edges of an interval",
            value: n as f64,
            min: 1.0,
            max: 1e5,
        });
    }
    let captures = captures(record)?;
    let filter = FixedPosition::<f64>::new(n as f64 * captures.increment, 1.0 / captures.tick)?;
    let mut past: VecDeque<Edge> = VecDeque::new();
    let mut v = record.start_velocity().0;
    let (mut velocity, mut delays) = (Vec::new(), Vec::new());
    for (_, edges) in &captures.samples {
        match edges {
            None => past.clear(),
            Some(edges) => {
                for edge in edges {
                    // A reversal: the way since is no whole number of increments.
                    if past.back().is_some_and(|last| last.upwards != edge.upwards) {
                        past.clear();
                    }
                    past.push_back(*edge);
                    if past.len() <= n {
                        continue;
                    }
                    if let Some(first) = past.pop_front() {
                        let ticks = edge.ticks.wrapping_sub(first.ticks);
                        if let Some(reading) = filter.velocity(ticks, edge.upwards) {
                            v = reading.velocity;
                            delays.push(reading.delay);
                        }
                    }
                }
            }
        }
        velocity.push(v);
    }
    Ok((velocity, mean(&delays)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_places_and_counts_are_the_same_edges() {
        // Up over 1, 2, 3, back over 3, 2, up over 2, back over 2, 1.
        let places = [1.0, 2.0, 3.0, 3.0, 2.0, 2.0, 2.0, 1.0];
        let counts = [1.0, 2.0, 3.0, 2.0, 1.0, 2.0, 1.0, 0.0];
        let after = |rows: &[f64], decoded| -> Vec<f64> {
            edge_counts(rows, decoded).iter().map(|r| r.1).collect()
        };
        assert_eq!(after(&places, false), counts);
        assert_eq!(after(&counts, false), counts);
        // The first row repeated: the axis was turned back before it moved on.
        assert_eq!(after(&[5.0, 5.0, 5.0, 6.0], false), [5.0, 4.0, 5.0, 6.0]);
        assert_eq!(after(&[5.0, 5.0, 4.0], false), [5.0, 4.0, 3.0]);
        // Rows of a logger that repeats itself, and levels of which one in four is counted.
        assert_eq!(
            after(&[1.0, 2.0, 2.0, 3.0, 2.0], false),
            [1.0, 2.0, 3.0, 2.0]
        );
        assert_eq!(after(&[0.0, 0.0, 0.0, 1.0, 1.0], true), [0.0, 1.0]);
        let mut drawn = counts.to_vec();
        edge_places(&mut drawn, 1.0);
        assert_eq!(drawn[1..], places[1..]);
    }
}
