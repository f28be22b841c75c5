//! Standstills in a hand-held recording: windowed variance against a multiple of the noise floor.

use crate::{Samples, Segment, Triple};
use proofmass_core::Error;

/// How standstills are looked for.
///
/// ```
/// use proofmass_static::Standstill;
/// let search = Standstill { minimum_duration: 2.0, ..Standstill::default() };
/// assert_eq!(search.window, 1.0);
/// ```
#[doc(alias("static interval", "stationary interval", "zero motion"))]
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Standstill {
    /// Length of the window over which the variance is taken, s; a sweep tries half and a quarter of it too.
    pub window: f64,
    /// Shortest standstill that counts, s; [`Self::MINIMUM_SAMPLES`] at least.
    pub minimum_duration: f64,
    /// Largest windowed variance of a standstill in multiples of the noise floor; `None`: chosen by the
    /// residual of the fit over a sweep.
    pub threshold: Option<f64>,
}

impl Default for Standstill {
    fn default() -> Self {
        Self {
            window: 1.0,
            minimum_duration: 1.0,
            threshold: None,
        }
    }
}

impl Standstill {
    /// Fewest samples a mean is taken over: what it is worth is told by its noise, not by their number.
    pub const MINIMUM_SAMPLES: usize = 5;

    /// Fewest samples on each side of the middle of a window: five in all, of three axes.
    const HALF_WINDOW: usize = 2;

    /// Fewest samples of a window that is shorter than asked.
    const SHORTENED: f64 = 12.0;

    /// Shortest hold of the sensor that will do at this sampling rate, s: 1.6 times what the shortest window can see.
    ///
    /// A window reaches half its length into what was before and behind a hold, so that a hold is seen once it lasts a window and
    /// the shortest standstill; noise and a settling sensor shorten it (`law_the_shortest_hold_is_found`).
    pub fn shortest_hold(&self, rate: f64) -> f64 {
        let seen = self.windows(rate).map(|search| {
            let [half, fewest] = search.samples(rate);
            (2 * half + fewest) as f64 / rate
        });
        1.6 * seen.fold(f64::INFINITY, f64::min)
    }

    /// Half a window and the shortest standstill, samples.
    fn samples(&self, rate: f64) -> [usize; 2] {
        let half = ((0.5 * self.window * rate).round() as usize).max(Self::HALF_WINDOW);
        let fewest = ((self.minimum_duration * rate).round() as usize).max(Self::MINIMUM_SAMPLES);
        [half, fewest]
    }

    /// The search with its own window, with half of it and with a quarter, as far as enough samples are left in one.
    ///
    /// A run that a window of w finds is that much shorter than the rest: a shorter window needs the shortest standstill less w.
    pub(crate) fn windows(&self, rate: f64) -> impl Iterator<Item = Self> {
        let whole = *self;
        let shorter = [0.5, 0.25].map(move |part| Self {
            window: part * whole.window,
            minimum_duration: (whole.minimum_duration - part * whole.window)
                .max(part * whole.window),
            ..whole
        });
        let enough = move |search: &Self| search.window * rate >= Self::SHORTENED;
        std::iter::once(whole).chain(shorter.into_iter().filter(enough))
    }
}

/// The windowed variance of a recording, computed once and cut at any threshold.
///
/// At each sample the variance of the three outputs over a centred window, each divided by its noise floor,
/// averaged over the axes: about 1 at rest. The noise floor is the tenth percentile of the windowed variance.
///
/// **Assumes** that the sensor rests for more than a tenth of the recording.
///
/// **Source** after `[Tedaldi2014]` III-B; the noise floor is a percentile instead of an initial rest, so that
/// no part of the recording has to be set apart.
#[derive(Clone, Debug)]
pub struct WindowedVariance {
    statistic: Vec<f64>,
    floor: Triple,
    minimum_samples: usize,
    breaks: Vec<usize>,
}

impl WindowedVariance {
    /// Computes the statistic.
    ///
    /// `rate` is the number of samples per second, on the average: a window counts samples, so that uneven stamps, a few
    /// lost rows and packets do not matter. `breaks` are samples before which time jumps by more than a window
    /// (sorted): no standstill reaches across one.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a rate, window or duration that is not positive; [`Error::TooFew`] for a
    /// recording shorter than a window; [`Error::Constant`] naming the first output that never changes.
    pub fn new(
        samples: &Samples<'_>,
        rate: f64,
        breaks: &[usize],
        search: &Standstill,
    ) -> Result<Self, Error> {
        for (name, value) in [
            ("sampling rate", rate),
            ("window", search.window),
            ("minimum duration", search.minimum_duration),
        ] {
            proofmass_core::check::positive(name, value)?;
        }
        let [half, minimum_samples] = search.samples(rate);
        let n = samples.len();
        let needed = (2 * half + 1).max(minimum_samples);
        if n < needed {
            return Err(Error::TooFew {
                name: "samples in the recording",
                needed,
                got: n,
            });
        }
        const NAMES: [&str; 3] = ["output x", "output y", "output z"];
        let mut statistic = vec![0.0; n];
        let mut floor = [0.0; 3];
        for (axis, column) in samples.columns().into_iter().enumerate() {
            let first = column[0];
            if column.iter().all(|v| *v == first) {
                return Err(Error::Constant {
                    name: NAMES[axis],
                    value: first,
                });
            }
            let variance = windowed_variance(column, half);
            floor[axis] = noise_floor(&variance, column);
            for (s, v) in statistic.iter_mut().zip(&variance) {
                *s += v / floor[axis] / 3.0;
            }
        }
        Ok(Self {
            statistic,
            floor,
            minimum_samples,
            breaks: breaks.to_vec(),
        })
    }

    /// Variance of the noise floor per axis, output units squared.
    pub fn floor(&self) -> Triple {
        self.floor
    }

    /// The statistic at each sample, about 1 at rest.
    pub fn statistic(&self) -> &[f64] {
        &self.statistic
    }

    /// The standstills at one threshold.
    ///
    /// Runs of samples whose windows stay below it. A run ends half a window inside the rest: the margin in which
    /// a hand lets go and the sensor settles.
    pub fn segments(&self, threshold: f64) -> Vec<Segment> {
        let n = self.statistic.len();
        let mut segments: Vec<Segment> = Vec::new();
        let mut lower = 0;
        for upper in self.breaks.iter().copied().chain([n]) {
            let mut start = None;
            for i in lower..=upper.min(n) {
                let still = i < upper.min(n) && self.statistic[i] < threshold;
                match (still, start) {
                    (true, None) => start = Some(i),
                    (false, Some(s)) => {
                        if i >= s + self.minimum_samples {
                            segments.push(Segment {
                                start: s,
                                end: i,
                                attitude: None,
                                force_uncertainty: None,
                                label: None,
                            });
                        }
                        start = None;
                    }
                    _ => {}
                }
            }
            lower = upper;
        }
        segments
    }

    /// Whether a half-open range of samples stays below a threshold, and time does not jump in it.
    pub(crate) fn stays_below(&self, start: usize, end: usize, threshold: f64) -> bool {
        self.statistic[start..end].iter().all(|s| *s < threshold)
            && !self.breaks.iter().any(|b| (start..=end).contains(b))
    }

    /// The ladder of thresholds a sweep tries, each √2 of the one before.
    pub fn ladder() -> impl Iterator<Item = f64> {
        (0..22).map(|i| 1.5 * 2f64.powf(0.5 * f64::from(i)))
    }
}

/// Variance over the window [i − half, i + half], clipped at the ends, by sliding sums.
fn windowed_variance(column: &[f64], half: usize) -> Vec<f64> {
    let n = column.len();
    // Sums against the overall mean; they are rebuilt every 4096 samples so that rounding cannot pile up.
    let pedestal = column.iter().sum::<f64>() / n as f64;
    let mut sum = 0.0;
    let mut square = 0.0;
    let mut lower = 0;
    let mut upper = 0;
    let mut variance = Vec::with_capacity(n);
    for i in 0..n {
        let to = (i + half + 1).min(n);
        let from = i.saturating_sub(half);
        while upper < to {
            let v = column[upper] - pedestal;
            sum += v;
            square += v * v;
            upper += 1;
        }
        while lower < from {
            let v = column[lower] - pedestal;
            sum -= v;
            square -= v * v;
            lower += 1;
        }
        if i % 4096 == 0 {
            sum = column[lower..upper].iter().map(|v| v - pedestal).sum();
            square = column[lower..upper]
                .iter()
                .map(|v| (v - pedestal).powi(2))
                .sum();
        }
        let count = (upper - lower) as f64;
        variance.push(((square - sum * sum / count) / (count - 1.0)).max(0.0));
    }
    variance
}

/// Tenth percentile of the windowed variance, never below what rounding to the last digit would give.
fn noise_floor(variance: &[f64], column: &[f64]) -> f64 {
    let mut sorted = variance.to_vec();
    let rank = sorted.len() / 10;
    let (_, &mut percentile, _) = sorted.select_nth_unstable_by(rank, f64::total_cmp);
    // A resolution coarser than the noise leaves windows with little or no change: a twelfth of the squared step.
    let step = column
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .filter(|change| *change > 0.0)
        .fold(f64::INFINITY, f64::min);
    percentile.max(if step.is_finite() {
        step * step / 12.0
    } else {
        0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(i: usize) -> f64 {
        // A deterministic "noise" of unit amplitude and zero mean.
        [0.9, -0.4, 0.1, -1.0, 0.6, 0.3, -0.8, 0.3][i % 8]
    }

    #[test]
    fn known_rests_between_motions_are_found() {
        let n = 3000;
        let moving = |i: usize| (1000..1200).contains(&i) || (2000..2300).contains(&i);
        let x: Vec<f64> = (0..n)
            .map(|i| {
                triangle(i)
                    + if moving(i) {
                        50.0 * (i as f64 * 0.05).sin()
                    } else {
                        0.0
                    }
            })
            .collect();
        let samples = Samples::new(&x, &x, &x).unwrap();
        let windowed = WindowedVariance::new(&samples, 100.0, &[], &Standstill::default()).unwrap();
        let found = windowed.segments(3.0);
        assert_eq!(found.len(), 3);
        for (segment, (start, end)) in found.iter().zip([(0, 1000), (1200, 2000), (2300, 3000)]) {
            // Inside the true rest, and half a window (50 samples) short where it borders on motion.
            assert!(
                segment.start >= start && segment.start <= start + 51,
                "{segment:?}"
            );
            assert!(segment.end <= end && segment.end + 51 >= end, "{segment:?}");
        }
    }

    #[test]
    fn law_no_standstill_reaches_across_a_gap_in_time() {
        let x: Vec<f64> = (0..1000).map(triangle).collect();
        let samples = Samples::new(&x, &x, &x).unwrap();
        let windowed =
            WindowedVariance::new(&samples, 100.0, &[400], &Standstill::default()).unwrap();
        let found = windowed.segments(3.0);
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].end, found[1].start), (400, 400));
    }

    #[test]
    fn law_sliding_sums_agree_with_the_definition() {
        let x: Vec<f64> = (0..5000)
            .map(|i| 33000.0 + triangle(i) + (i as f64 * 0.01).sin())
            .collect();
        let fast = windowed_variance(&x, 25);
        for i in (0..5000usize).step_by(37) {
            let window = &x[i.saturating_sub(25)..(i + 26).min(5000)];
            let mean = window.iter().sum::<f64>() / window.len() as f64;
            let slow =
                window.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (window.len() - 1) as f64;
            // Squares of about 1 summed at most 4096 + 51 times.
            assert!((fast[i] - slow).abs() < 1e-11);
        }
    }

    #[test]
    fn refuses_constant_and_short() {
        let zeros = vec![0.0; 500];
        let samples = Samples::new(&zeros, &zeros, &zeros).unwrap();
        let search = Standstill::default();
        assert!(matches!(
            WindowedVariance::new(&samples, 100.0, &[], &search),
            Err(Error::Constant {
                name: "output x",
                value: 0.0
            })
        ));
        let short: Vec<f64> = (0..40).map(triangle).collect();
        let samples = Samples::new(&short, &short, &short).unwrap();
        assert!(matches!(
            WindowedVariance::new(&samples, 100.0, &[], &search),
            Err(Error::TooFew { .. })
        ));
    }
}
