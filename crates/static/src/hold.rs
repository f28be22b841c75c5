//! Holds: what the search cut out of one rest of the sensor is one reading.

use crate::{Ellipsoid, Samples, Segment, Triple, WindowedVariance};

/// Largest distance between the means of two pieces of one hold, in units of g: 1.7°.
const SAME_ATTITUDE: f64 = 0.03;

/// Largest windowed variance between two pieces of one hold, in multiples of the threshold that cut them apart.
pub(crate) const STILL_BETWEEN: f64 = 3.0;

/// The rests of a search, each once.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Holds {
    /// One segment for each hold of the sensor.
    pub(crate) segments: Vec<Segment>,
    /// Pieces beyond one for each hold.
    pub(crate) cuts: usize,
}

impl Holds {
    /// Joins neighbouring segments in the same attitude.
    ///
    /// Two neighbours whose means lie within 3 % of g are one hold: pieces of it share its errors, and would pose as independent
    /// attitudes. Where the sensor was still between them too, the hold reaches from the first sample to the last; where it was
    /// touched, the longer piece stands for it.
    pub(crate) fn of(samples: &Samples<'_>, windowed: &WindowedVariance, threshold: f64) -> Self {
        let pieces = windowed.segments(threshold);
        let means: Vec<Triple> = pieces
            .iter()
            .map(|s| samples.mean(s.start, s.end))
            .collect();
        let near = Ellipsoid::sphere(&means).map_or(0.0, |sphere| SAME_ATTITUDE * sphere.radius());
        let segments = joined(&pieces, |hold, k| {
            let alike = distance(&samples.mean(hold.start, hold.end), &means[k]) < near;
            let quiet =
                || windowed.stays_below(hold.end, pieces[k].start, STILL_BETWEEN * threshold);
            alike.then(quiet)
        });
        let cuts = pieces.len() - segments.len();
        Self { segments, cuts }
    }
}

/// Pieces of one hold as one: `same` tells of a hold and the number of the next piece whether they are one, and whether the sensor was
/// still between them. Where it was touched the longer piece stands for both.
pub(crate) fn joined(
    pieces: &[Segment],
    same: impl Fn(&Segment, usize) -> Option<bool>,
) -> Vec<Segment> {
    let mut holds: Vec<Segment> = Vec::with_capacity(pieces.len());
    for (k, piece) in pieces.iter().enumerate() {
        let before = holds
            .last_mut()
            .and_then(|hold| same(hold, k).map(|still| (hold, still)));
        match before {
            None => holds.push(piece.clone()),
            Some((hold, true)) => hold.end = piece.end,
            Some((hold, false)) if piece.len() > hold.len() => *hold = piece.clone(),
            Some(_) => {}
        }
    }
    holds
}

impl WindowedVariance {
    /// The standstills at one threshold, each hold of the sensor once.
    ///
    /// As [`WindowedVariance::segments`]; neighbours in the same attitude, within 3 % of g, are one.
    pub fn holds(&self, samples: &Samples<'_>, threshold: f64) -> Vec<Segment> {
        Holds::of(samples, self, threshold).segments
    }
}

fn distance(a: &Triple, b: &Triple) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}
