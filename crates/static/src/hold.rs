//! Holds: what the search cut out of one rest of the sensor is one reading.

use crate::{Ellipsoid, Samples, Segment, Triple, WindowedVariance};

/// Largest distance between the means of two pieces of one hold, in units of g: 1.7°.
const SAME_ATTITUDE: f64 = 0.03;

/// Largest windowed variance between two pieces of one hold, in multiples of the threshold that cut them apart.
const STILL_BETWEEN: f64 = 3.0;

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
        let found = pieces.len();
        let mut segments: Vec<Segment> = Vec::with_capacity(found);
        for (piece, mean) in pieces.into_iter().zip(&means) {
            let before = segments
                .last_mut()
                .filter(|hold| distance(&samples.mean(hold.start, hold.end), mean) < near);
            let Some(hold) = before else {
                segments.push(piece);
                continue;
            };
            if windowed.stays_below(hold.end, piece.start, STILL_BETWEEN * threshold) {
                hold.end = piece.end;
            } else if piece.len() > hold.len() {
                *hold = piece;
            }
        }
        let cuts = found - segments.len();
        Self { segments, cuts }
    }
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
