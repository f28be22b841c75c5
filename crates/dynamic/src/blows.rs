//! Blows of a hammer in recordings of force and output.

use proofmass_core::numeric::upper_median;

/// Share of the greatest force from which on a blow is one.
const LEVEL: f64 = 0.2;

/// Why a blow is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlowFault {
    /// Cut off, or followed too soon by the next.
    Short,
    /// The force comes back after it has once gone.
    Doubled,
}

/// A blow that is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct DroppedBlow {
    /// Which of all, counted from 1.
    pub number: usize,
    /// When, samples of its recording.
    pub at: usize,
    /// Why.
    pub why: BlowFault,
}

/// A recording without a blow.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct NoBlow {
    /// Which recording.
    pub recording: usize,
    /// Its greatest force.
    pub greatest: f64,
    /// Median modulus of its force.
    pub noise: f64,
}

/// Stretches of force and output, one for each blow.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Blows<'a> {
    /// Those that can be used.
    pub pieces: Vec<(&'a [f64], &'a [f64])>,
    /// Those that cannot.
    pub dropped: Vec<DroppedBlow>,
}

impl<'a> Blows<'a> {
    /// Finds the blows in recordings of force and output, and leaves out doubled and unfinished ones.
    ///
    /// **Shapes** force and output of one recording have one length.
    ///
    /// # Errors
    /// [`NoBlow`] for a recording whose force stays below twenty times its median.
    pub fn find(recordings: &[(&'a [f64], &'a [f64])]) -> Result<Self, NoBlow> {
        let mut candidates: Vec<(&'a [f64], &'a [f64], usize)> = Vec::new();
        for (recording, (x, y)) in recordings.iter().copied().enumerate() {
            let greatest = x.iter().fold(0.0f64, |m, v| m.max(v.abs()));
            // A pause of a hundredth of the record parts two blows; what comes sooner is one that bounced.
            let pause = (x.len() / 100).max(32);
            let mut starts: Vec<usize> = Vec::new();
            let mut last: Option<usize> = None;
            for (k, v) in x.iter().enumerate() {
                if v.abs() >= LEVEL * greatest && greatest > 0.0 {
                    if last.is_none_or(|l| k - l > pause) {
                        starts.push(k);
                    }
                    last = Some(k);
                }
            }
            let mut sizes: Vec<f64> = x.iter().map(|v| v.abs()).collect();
            let noise = upper_median(&mut sizes).unwrap_or(0.0);
            if greatest < 20.0 * noise {
                return Err(NoBlow {
                    recording,
                    greatest,
                    noise,
                });
            }
            // As far before each blow as the first one has.
            let lead = starts.first().copied().unwrap_or(0).min(pause / 2);
            for (i, s) in starts.iter().enumerate() {
                let from = s - lead.min(*s);
                let to = starts.get(i + 1).map_or(x.len(), |n| n - lead);
                candidates.push((&x[from..to], &y[from..to], *s));
            }
        }
        let mut lengths: Vec<usize> = candidates.iter().map(|c| c.0.len()).collect();
        lengths.sort_unstable();
        let median = lengths.get(lengths.len() / 2).copied().unwrap_or(0);
        let mut blows = Self {
            pieces: Vec::new(),
            dropped: Vec::new(),
        };
        for (number, (x, y, at)) in candidates.into_iter().enumerate() {
            let why = if x.len() < median / 2 {
                BlowFault::Short
            } else if doubled(x) {
                BlowFault::Doubled
            } else {
                blows.pieces.push((x, y));
                continue;
            };
            blows.dropped.push(DroppedBlow {
                number: number + 1,
                at,
                why,
            });
        }
        Ok(blows)
    }

    /// Samples that all have: as many as wanted, else as the shortest has; 16 at least.
    pub fn length(&self, wanted: Option<usize>) -> usize {
        let shortest = self.pieces.iter().map(|p| p.0.len()).min().unwrap_or(0);
        wanted.unwrap_or(shortest).max(16)
    }

    /// Blows whose output has not decayed after so many samples.
    pub fn undecayed(&self, length: usize) -> usize {
        self.pieces
            .iter()
            .filter(|(_, y)| !decayed(&y[..length.min(y.len())]))
            .count()
    }
}

/// Whether the force comes back after it has once gone.
fn doubled(x: &[f64]) -> bool {
    let greatest = x.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let above = |v: &f64| v.abs() >= 0.1 * greatest;
    let Some(first) = x.iter().position(above) else {
        return true;
    };
    let width = x[first..].iter().position(|v| !above(v)).unwrap_or(0);
    // Ringing of the force sensor dies within a few widths; a second blow comes later.
    let later = first + width + 6 * width.max(1);
    x.get(later..).is_some_and(|rest| rest.iter().any(above))
}

fn decayed(y: &[f64]) -> bool {
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    let greatest = y.iter().fold(0.0f64, |m, v| m.max((v - mean).abs()));
    let tail = &y[y.len() - y.len() / 20 - 1..];
    let level = tail.iter().sum::<f64>() / tail.len() as f64;
    tail.iter().all(|v| (v - level).abs() < 0.05 * greatest)
}
