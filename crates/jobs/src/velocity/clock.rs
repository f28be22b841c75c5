//! Clocks of the sensors: rounded stamps, rows that are edges, a clock for an encoder alone.

use super::reading::Samples;
use crate::findings;
use proofmass_core::Error;
use proofmass_io::{Recording, TimeSource};
use proofmass_motion::{
    HoledClock, MotionRecord, Stamped, edge_counts, even_clock, even_rows, even_times, stamp_digit,
    time_edges,
};
use proofmass_uncertainty::Finding;

/// No acceleration at the rows of a recording: zeros on its clock, of edges on one of their median distance.
pub(super) fn nothing(clock: &[f64], edges: bool) -> Samples {
    let mut time = clock.to_vec();
    if let (true, Some(first), Some(last)) = (edges, clock.first(), clock.last()) {
        let mut steps: Vec<f64> = clock.windows(2).map(|w| w[1] - w[0]).collect();
        steps.sort_by(f64::total_cmp);
        let step = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
        let count = (last - first) / step;
        // Edges bunched in a few bursts would ask for a clock without end.
        if count.is_finite() && count < 100.0 * clock.len() as f64 {
            time = (0..=count as usize)
                .map(|k| first + step * k as f64)
                .collect();
        }
    }
    Samples {
        value: vec![0.0; time.len()],
        time,
    }
}

/// Times of the rows after an origin: of an even clock behind rounded stamps, the clock.
pub(super) fn clock(recording: &Recording, main: &Recording, origin: f64, edges: bool) -> Vec<f64> {
    // Recordings with stamps since 1970 count from their own first one.
    let origin = origin - recording.time.offset_s(&main.time);
    let own: Vec<f64> = (0..recording.samples())
        .map(|k| recording.time.seconds(k) - origin)
        .collect();
    let TimeSource::Column(stamps) = recording.time.source() else {
        return own;
    };
    if edges {
        return own;
    }
    match (even_clock(stamps), HoledClock::of(stamps)) {
        (Some(step), _) => even_times(&own, step),
        (None, Some(holed)) => holed.times(&own),
        _ => own,
    }
}

/// The clock of accelerations of which some are missing in rows on an even one: their own, which may be slower, or that of the rows.
pub(super) fn holed(time: &[f64], rows: &[f64]) -> Option<HoledClock> {
    if even_clock(time).is_some() {
        return None;
    }
    let step = || even_clock(rows).or_else(|| HoledClock::of(rows).map(|clock| clock.step));
    HoledClock::of(time).or_else(|| HoledClock::known(time, step()?))
}

/// Puts rows and the readings in them on the even clock behind stamps that scatter, where the samples do not.
pub(super) fn evened(clock: &mut Vec<f64>, reading: &mut Samples) -> Option<Finding> {
    let own = Stamped {
        time: &reading.time,
        value: &reading.value,
    };
    let (even, finding) = even_rows(clock, own)?;
    for t in &mut reading.time {
        let row = clock.partition_point(|s| *s < *t);
        *t = even.get(row).copied().unwrap_or(*t);
    }
    *clock = even;
    Some(finding)
}

/// Rows that are edges as the counts after them, in lengths, and whether edges are missing; `decoded` from logic levels.
pub(super) fn counted(rows: &Samples, increment: f64, decoded: bool) -> (Samples, Option<Finding>) {
    let counts: Vec<f64> = rows.value.iter().map(|x| (x / increment).round()).collect();
    let kept = edge_counts(&counts, decoded);
    let steps = kept.windows(2).map(|w| (w[1].1 - w[0].1).abs());
    let (lost, largest) = steps
        .filter(|s| *s > 1.5)
        .fold((0usize, 0.0f64), |(n, most), s| (n + 1, most.max(s)));
    let finding = (lost > 0).then(|| findings::edges_lost(lost, kept.len(), largest));
    let samples = Samples {
        time: kept.iter().map(|(k, _)| rows.time[*k]).collect(),
        value: kept.iter().map(|(_, count)| increment * count).collect(),
    };
    (samples, finding)
}

/// The counts at the samples of a record that begins at `start`, and the edges between them with their ages.
pub(super) fn timed(
    record: &MotionRecord,
    edges: &Samples,
    increment: f64,
    start: f64,
) -> Result<MotionRecord, Error> {
    let time: Vec<f64> = edges.time.iter().map(|t| t - start).collect();
    let count: Vec<f64> = edges
        .value
        .iter()
        .map(|x| (x / increment).round())
        .collect();
    // Digits of the stamps; beyond a nanosecond they are those of the arithmetic.
    let tick = stamp_digit(&edges.time).unwrap_or(1e-9);
    time_edges(record, &time, &count, increment, tick)
}
