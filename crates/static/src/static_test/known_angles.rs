//! Rests at known angles in the recording of one axis.

use super::readings::{Solved, least_squares};
use crate::hold::{STILL_BETWEEN, joined};
use crate::{Samples, Segment, Standstill, WindowedVariance, findings};
use proofmass_core::Error;
use proofmass_uncertainty::{Finding, student_quantile};

/// Rests at angles that are known in order, by the most stable choice of window and threshold that finds as many as there are.
///
/// Every threshold of the ladder and every window gives a list of rests; neighbours of like mean are pieces of one hold where the
/// axis was still between them, and where the number asks for it also where it was touched. Lists in which every rest meets its
/// like are one choice. Of the choices whose residuals about the cosine are alike (within a factor of three) the one is taken
/// that most thresholds give; its rests are those in the first third of its thresholds, with the longest window.
///
/// What remains doubtful is a finding that asks for a decision: residuals beyond 1 % of the output at 1 g, one rest far off its
/// angle, neighbours of like output at unlike angles, a misalignment of half a step of the angles, a second choice of like merit
/// and another result.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct KnownAngles {
    /// One rest for each angle.
    pub segments: Vec<Segment>,
    /// Threshold, multiples of the noise floor.
    pub threshold: f64,
    /// Length of the window, s.
    pub window: f64,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

/// Residuals alike, as a ratio.
const ALIKE: f64 = 3.0;
/// Means of two pieces of one hold, as a share of half the range of the outputs.
const SAME: f64 = 3e-3;
/// Largest RMS residual that needs no decision, as a share of the output at 1 g: an angle set to 0.6°.
const LARGE: f64 = 1e-2;
/// Probability that one healthy recording has a rest far off its angle.
const LEVEL: f64 = 1e-3;

/// The rests of one window and one threshold.
#[derive(Clone, Debug)]
struct Cut {
    segments: Vec<Segment>,
    threshold: f64,
    window: f64,
    /// Pieces beyond one for each hold.
    cuts: usize,
}

/// Lists in which every rest meets its like.
struct Choice {
    cuts: Vec<Cut>,
    means: Vec<f64>,
    fit: Option<Solved>,
    /// RMS residual about the cosine; zero where there is none to spare.
    residual: f64,
}

/// Number of rests that the thresholds find, lowest and highest.
pub type Counts = [usize; 2];

impl KnownAngles {
    /// Searches one axis (`output`, `rate` in Hz, `breaks` as of [`WindowedVariance::new`]) for rests at `angles`, rad.
    ///
    /// Where no threshold finds as many, the numbers that they do find.
    ///
    /// # Errors
    /// Those of [`WindowedVariance::new`].
    pub fn find(
        output: &[f64],
        rate: f64,
        breaks: &[usize],
        search: &Standstill,
        angles: &[f64],
    ) -> Result<Result<Self, Counts>, Error> {
        let samples = Samples::new(output, output, output)?;
        let mean = |s: &Segment| samples.mean(s.start, s.end)[0];
        let mut counts = [usize::MAX, 0];
        let mut choices: Vec<Choice> = Vec::new();
        for (number, search) in search.windows(rate).enumerate() {
            let windowed = match WindowedVariance::new(&samples, rate, breaks, &search) {
                Ok(windowed) => windowed,
                Err(error) if number == 0 => return Err(error),
                Err(_) => continue,
            };
            for threshold in WindowedVariance::ladder() {
                let pieces = windowed.segments(threshold);
                let means: Vec<f64> = pieces.iter().map(mean).collect();
                let near = SAME * half_range(&means);
                let holds = [true, false].map(|still| {
                    joined(&pieces, |hold, k| {
                        let alike = (mean(hold) - means[k]).abs() < near;
                        let (from, to) = (hold.end, pieces[k].start);
                        let quiet = || windowed.stays_below(from, to, STILL_BETWEEN * threshold);
                        alike.then(quiet).filter(|quiet| *quiet || !still)
                    })
                });
                let least = holds.iter().chain([&pieces]).map(Vec::len).min();
                counts[0] = counts[0].min(least.unwrap_or(0));
                counts[1] = counts[1].max(pieces.len());
                let Some(segments) = holds.into_iter().find(|h| h.len() == angles.len()) else {
                    continue;
                };
                let cut = Cut {
                    cuts: pieces.len() - segments.len(),
                    segments,
                    threshold,
                    window: search.window,
                };
                match choices
                    .iter_mut()
                    .find(|c| c.cuts.iter().any(|k| k.meets(&cut)))
                {
                    Some(choice) => choice.cuts.push(cut),
                    None => choices.push(Choice::of(cut)),
                }
            }
        }
        for choice in &mut choices {
            choice.settle(&mean, angles);
        }
        let reach = choices
            .iter()
            .map(|c| half_range(&c.means))
            .fold(0.0, f64::max);
        let least = choices
            .iter()
            .map(|c| c.residual)
            .fold(f64::INFINITY, f64::min);
        let limit = ALIKE * least.max(1e-4 * reach);
        let alike = choices.iter().filter(|c| c.residual <= limit);
        let best = alike.max_by(|a, b| {
            let by_number = a.cuts.len().cmp(&b.cuts.len());
            by_number.then(b.residual.total_cmp(&a.residual))
        });
        let Some(best) = best else {
            return Ok(Err(counts));
        };
        let mut doubts = best.doubts(angles);
        let second = choices.iter().find(|c| {
            !std::ptr::eq(*c, best)
                && c.residual <= ALIKE * best.residual.max(1e-4 * reach)
                && 2 * c.cuts.len() >= best.cuts.len()
                && c.differs(best, reach)
        });
        doubts.extend(second.map(|c| {
            findings::angles_in_doubt(
                "two choices of the rests are alike",
                &format!(
                    "{} thresholds find these rests, {} find others, with residuals of {:.2e} and {:.2e}",
                    best.cuts.len(),
                    c.cuts.len(),
                    best.residual,
                    c.residual
                ),
            )
        }));
        let cut = best.typical();
        Ok(Ok(Self {
            segments: cut.segments.clone(),
            threshold: cut.threshold,
            window: cut.window,
            findings: doubts,
        }))
    }
}

impl Cut {
    /// Whether every rest overlaps its like.
    fn meets(&self, other: &Self) -> bool {
        let pairs = self.segments.iter().zip(&other.segments);
        pairs
            .into_iter()
            .all(|(a, b)| a.start < b.end && b.start < a.end)
    }
}

impl Choice {
    fn of(cut: Cut) -> Self {
        Self {
            cuts: vec![cut],
            means: Vec::new(),
            fit: None,
            residual: 0.0,
        }
    }

    /// The rests that stand for all: of the longest window those least cut to pieces, a third of the way up.
    fn typical(&self) -> &Cut {
        let longest = self.cuts.iter().map(|c| c.window).fold(0.0, f64::max);
        let of_window = || self.cuts.iter().filter(|c| c.window == longest);
        let whole = of_window().map(|c| c.cuts).min();
        let kept: Vec<&Cut> = of_window().filter(|c| Some(c.cuts) == whole).collect();
        kept[kept.len() / 3]
    }

    /// Means and the cosine about them.
    fn settle(&mut self, mean: &dyn Fn(&Segment) -> f64, angles: &[f64]) {
        self.means = self.typical().segments.iter().map(mean).collect();
        let columns = [
            vec![1.0; angles.len()],
            angles.iter().map(|t| t.cos()).collect(),
            angles.iter().map(|t| t.sin()).collect(),
        ];
        // Up and down alone have no sine.
        self.fit = least_squares(&columns, &self.means, "angles")
            .or_else(|_| least_squares(&columns[..2], &self.means, "angles"))
            .ok()
            .filter(|fit| fit.dof > 0);
        self.residual = self
            .fit
            .as_ref()
            .map_or(0.0, |fit| (fit.squares / fit.dof as f64).sqrt());
    }

    /// Whether the result is another than that of the better choice.
    fn differs(&self, best: &Self, reach: f64) -> bool {
        match (&self.fit, &best.fit) {
            (Some(a), Some(b)) => {
                let limit = best.residual.max(1e-4 * reach);
                let pairs = a.fitted.iter().zip(&b.fitted);
                pairs.into_iter().any(|(a, b)| (a - b).abs() > limit)
            }
            _ => {
                let pairs = self.means.iter().zip(&best.means);
                pairs.into_iter().any(|(a, b)| (a - b).abs() > SAME * reach)
            }
        }
    }

    /// What speaks against these rests at these angles.
    fn doubts(&self, angles: &[f64]) -> Vec<Finding> {
        let Some(fit) = &self.fit else {
            return Vec::new();
        };
        let reach = fit.parameters[1..]
            .iter()
            .map(|v| v * v)
            .sum::<f64>()
            .sqrt();
        let mut doubts = Vec::new();
        if self.residual > LARGE * reach {
            doubts.push(findings::angles_in_doubt(
                "the rests lie far off the cosine of their angles",
                &format!(
                    "RMS residual {:.2} % of the output at 1 g",
                    1e2 * self.residual / reach
                ),
            ));
        } else if let Some((rest, off)) = self.outlier(fit, reach) {
            doubts.push(findings::angles_in_doubt(
                "one rest lies far off its angle",
                &format!(
                    "rest {}, {:.2} % of the output at 1 g",
                    rest + 1,
                    1e2 * off / reach
                ),
            ));
        }
        let expected = |i: usize| fit.fitted[i + 1] - fit.fitted[i];
        let equal = (0..angles.len().saturating_sub(1)).find(|i| {
            let found = self.means[i + 1] - self.means[*i];
            expected(*i).abs() > 5e-3 * reach && found.abs() < 0.3 * expected(*i).abs()
        });
        doubts.extend(equal.map(|i| {
            findings::angles_in_doubt(
                "two rests in a row are alike though their angles differ",
                &format!(
                    "rests {} and {}, expected {:.2} % of the output at 1 g apart",
                    i + 1,
                    i + 2,
                    1e2 * expected(i).abs() / reach
                ),
            )
        }));
        if let [_, p, q] = fit.parameters[..] {
            let steps = angles.windows(2).map(|w| (w[1] - w[0]).abs());
            let step = steps.filter(|s| *s > 0.0).fold(f64::INFINITY, f64::min);
            let phase = q.atan2(p);
            // −sin: the parameter of the sine is −S g sin φ; a sensor built in upside down is turned by half a turn.
            let off = phase.abs().min(std::f64::consts::PI - phase.abs());
            if off > 0.5 * step {
                doubts.push(findings::angles_in_doubt(
                    "the axis lies half a step of the angles or more beside their zero: the list may begin one rest too early or too late",
                    &format!("{:.1}°", off.to_degrees()),
                ));
            }
        }
        doubts
    }

    /// The reading whose deletion explains most, where that is no chance.
    fn outlier(&self, fit: &Solved, reach: f64) -> Option<(usize, f64)> {
        let n = self.means.len();
        let nu = fit.dof as f64 - 1.0;
        if nu < 1.0 {
            return None;
        }
        let limit = student_quantile(1.0 - 0.5 * LEVEL / n as f64, nu);
        let (rest, off, t) = (0..n)
            .map(|i| {
                let off = fit.deleted(i, self.means[i]);
                let spare = (fit.squares - off.1) / nu;
                (i, off.0.abs(), (off.1 / spare.max(1e-300)).sqrt())
            })
            .max_by(|a, b| a.2.total_cmp(&b.2))?;
        (t > limit && off > SAME * reach).then_some((rest, off))
    }
}

/// Half the range of values.
fn half_range(values: &[f64]) -> f64 {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (0.5 * (high - low)).max(0.0)
}
