//! What shapes the noise in front of the converter: low-pass filters and averages that overlap, sought in the spectrum.

use crate::effects::Effects;
use crate::fit_family::ACROSS;
use crate::usable_band::{Candidate, ENOUGH, STEP, below, misfit};
use crate::variance_fit::{Likelihood, Minimum};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::fmt;

/// Chance of a departure from terms and front end as large as the one at which they do not describe the spectrum.
const DESCRIBED: f64 = 1e-3;

/// Butterworth low-pass filter in front of the converter: |H|² = 1/(1 + (tan(πf/f_s)/tan(πf_c/f_s))^{2p}).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LowPass {
    /// Order p.
    pub order: i32,
    /// Corner frequency f_c in Hz, where |H|² = ½.
    pub corner: f64,
}

impl LowPass {
    /// |H|² at a frequency in Hz.
    pub fn response(self, frequency: f64, sample_rate: f64) -> f64 {
        let warp = |f: f64| (PI * (f / sample_rate).min(0.499_999)).tan();
        let ratio = warp(frequency) / warp(self.corner);
        1.0 / (1.0 + ratio.powi(2 * self.order))
    }
}

/// tan²(πf/f_s), the square of the frequency of a continuous filter that the bilinear transform made digital.
fn warped(frequency: f64, sample_rate: f64) -> f64 {
    (PI * (frequency / sample_rate).min(0.499_9)).tan().powi(2)
}

/// What shapes the noise between its origin and the converter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FrontEnd {
    /// A low-pass filter: 1/|H|² = 1 + Σ aₖ tan²ᵏ(πf/f_s), k = 1, 2, 3, none of them negative. Filters of first and second order
    /// without a peak are of this form; others are where they have taken off little.
    LowPass {
        /// a₁, a₂, a₃.
        coefficients: [f64; 3],
    },
    /// Averages that reach into those of the neighbouring samples, as the decimator of many a digital sensor makes them:
    /// |H|² = 1 − a sin²(πf/f_s). White noise is then correlated between neighbours, by a/4 of its density, and no further.
    Overlap {
        /// Share a of the density that is lost at half the sample rate, at most one: the mean of two neighbours.
        loss: f64,
    },
}

impl FrontEnd {
    /// A Butterworth filter of first or second order.
    pub(crate) fn butterworth(filter: LowPass, sample_rate: f64) -> Self {
        let mut coefficients = [0.0; 3];
        let place = filter.order.clamp(1, 3) - 1;
        coefficients[place as usize] = warped(filter.corner, sample_rate).powi(-filter.order);
        Self::LowPass { coefficients }
    }

    /// |H|² at a frequency in Hz.
    pub fn response(self, frequency: f64, sample_rate: f64) -> f64 {
        match self {
            Self::LowPass { coefficients } => {
                let w = warped(frequency, sample_rate);
                let [a, b, c] = coefficients;
                1.0 / (1.0 + w * (a + w * (b + w * c)))
            }
            Self::Overlap { loss } => 1.0 - loss * (PI * frequency / sample_rate).sin().powi(2),
        }
    }

    /// Where |H|² = ½, if a frequency below half the rate is it, Hz.
    pub fn half_power(self, sample_rate: f64) -> Option<f64> {
        let (mut low, mut high) = (0.0, 0.5 * sample_rate);
        if self.response(high, sample_rate) > 0.5 {
            return None;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.response(middle, sample_rate) > 0.5 {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(high)
    }

    /// Multiplies densities over these frequencies with the response.
    pub(crate) fn apply(self, column: &mut [f64], frequencies: &[f64], sample_rate: f64) {
        for (g, f) in column.iter_mut().zip(frequencies) {
            *g *= self.response(*f, sample_rate);
        }
    }
}

impl fmt::Display for FrontEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LowPass { .. } => f.write_str("a low-pass filter"),
            Self::Overlap { loss } => write!(
                f,
                "an overlap of neighbouring averages (at half the rate {:.1} % of the density is lost)",
                100.0 * loss
            ),
        }
    }
}

/// The spectrum up to a frequency, without and with something in front of the converter.
pub(crate) struct Trial {
    plain: Likelihood,
    none: Minimum,
    frequencies: Vec<f64>,
    /// Position of the term that arises behind it: quantisation.
    behind: Option<usize>,
    sample_rate: f64,
}

impl Trial {
    /// `cut`: whether this is less than the whole spectrum, where quantisation is no longer told from the rest.
    pub(crate) fn new(candidate: &Candidate<'_>, highest: f64, cut: bool) -> Option<Self> {
        let without = candidate.quantisation.filter(|_| cut);
        let plain = below(
            candidate.likelihood,
            candidate.frequencies,
            highest,
            without,
        );
        let crude = plain.start();
        let none = plain.minimise(&[&crude], &vec![None; plain.terms()], Effects::Restricted)?;
        let frequencies = candidate.frequencies.iter().copied();
        Some(Self {
            plain,
            none,
            frequencies: frequencies.filter(|f| *f <= highest).collect(),
            behind: candidate.quantisation.filter(|_| !cut),
            sample_rate: candidate.sample_rate,
        })
    }

    fn with(&self, front_end: FrontEnd) -> Likelihood {
        let mut shaped = self.plain.clone();
        for (t, column) in shaped.columns.iter_mut().enumerate() {
            if Some(t) != self.behind {
                front_end.apply(column, &self.frequencies, self.sample_rate);
            }
        }
        shaped
    }

    fn fitted(&self, shaped: &Likelihood) -> Option<Minimum> {
        let free = vec![None; shaped.terms()];
        shaped.minimise(&[&self.none.squares], &free, Effects::Restricted)
    }

    /// What the term that arises behind a front end explains: the rise of −2 ln L without it and without a front end.
    pub(crate) fn behind(&self) -> f64 {
        let Some(behind) = self.behind else {
            return 0.0;
        };
        let mut held = vec![None; self.plain.terms()];
        held[behind] = Some(0.0);
        self.plain
            .minimise(&[&self.none.squares], &held, Effects::Restricted)
            .map_or(0.0, |m| m.value - self.none.value)
    }

    /// Fall of −2 ln L.
    pub(crate) fn gain(&self, front_end: FrontEnd) -> f64 {
        self.fitted(&self.with(front_end))
            .map_or(0.0, |m| self.none.value - m.value)
    }

    /// Whether this leaves no more than chance does.
    fn describes(&self, shaped: &Likelihood, best: &Minimum) -> bool {
        let (statistic, groups, _) = misfit(shaped, &self.frequencies, &best.squares, 0.0);
        let free = 1 + shaped.forms.max(1) + best.squares.iter().filter(|v| **v > 0.0).count();
        groups > free + 4
            && crate::edf::chi_square_quantile(1.0 - DESCRIBED, (groups - free) as f64)
                .is_some_and(|q| statistic <= q)
    }

    /// The low-pass filter that describes the band, if one does, and the powers it was sought in: one alone where that is enough far
    /// beyond its corner, where another filter would show; else all.
    fn low_pass(&self) -> Option<([f64; 3], &'static [i32])> {
        const FAMILIES: [Family; 3] = [
            |x| FrontEnd::LowPass {
                coefficients: [(-x).exp(), 0.0, 0.0],
            },
            |x| FrontEnd::LowPass {
                coefficients: [0.0, (-2.0 * x).exp(), 0.0],
            },
            |x| FrontEnd::LowPass {
                coefficients: [0.0, 0.0, (-3.0 * x).exp()],
            },
        ];
        let end = *self.frequencies.last()?;
        // ln w at the corner: from far above the end of the band to far below.
        let top = (100.0 * warped(end, self.sample_rate)).ln();
        let grid: Vec<f64> = (0..=18).map(|k| top - f64::from(k)).collect();
        let mut singles: Vec<(FrontEnd, f64, usize)> = Vec::new();
        for (index, family) in FAMILIES.into_iter().enumerate() {
            let (x, gain) = self.best(&grid, family)?;
            singles.push((family(x), gain, index));
        }
        singles.sort_by(|a, b| b.1.total_cmp(&a.1));
        let (single, _, index) = singles[0];
        let far = single
            .half_power(self.sample_rate)
            .is_some_and(|corner| FAR * corner < end);
        if far && let Some(found) = self.fitted_low_pass(single, &SINGLE[index]) {
            return Some((found, &SINGLE[index]));
        }
        self.fitted_low_pass(single, &ALL)
            .map(|found| (found, &ALL[..]))
    }

    /// From a filter to the best of these powers, where that describes the band and is needed.
    fn fitted_low_pass(&self, from: FrontEnd, powers: &[i32]) -> Option<[f64; 3]> {
        let FrontEnd::LowPass { coefficients } = from else {
            return None;
        };
        let shaped = divided(
            self.plain.clone(),
            &self.frequencies,
            self.sample_rate,
            coefficients,
            powers,
        );
        let mut start = self.fitted(&self.with(from))?.squares;
        start.extend(&shaped.divisor_start);
        let free = vec![None; shaped.terms()];
        let best = shaped.minimise(&[&start], &free, Effects::Restricted)?;
        if self.none.value - best.value <= ENOUGH || !self.describes(&shaped, &best) {
            return None;
        }
        let mut found = [0.0; 3];
        let fitted = &best.squares[shaped.columns.len()..];
        for (power, a) in powers.iter().zip(fitted) {
            found[*power as usize - 1] = *a;
        }
        Some(found)
    }

    /// The best of a family of one parameter, first on a grid, then between the neighbours of its best (golden section).
    fn best(&self, grid: &[f64], family: Family) -> Option<(f64, f64)> {
        let gain = |x: f64| self.gain(family(x));
        let gains: Vec<f64> = grid.iter().map(|x| gain(*x)).collect();
        let top = (0..grid.len()).max_by(|a, b| gains[*a].total_cmp(&gains[*b]))?;
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let mut low = grid[top.saturating_sub(1)];
        let mut high = grid[(top + 1).min(grid.len() - 1)];
        let mut found = (grid[top], gains[top]);
        let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
        let (mut left, mut right) = (gain(a), gain(b));
        for _ in 0..16 {
            let better = if left > right { (a, left) } else { (b, right) };
            if better.1 > found.1 {
                found = better;
            }
            if left > right {
                (high, b, right) = (b, a, left);
                a = high - golden * (high - low);
                left = gain(a);
            } else {
                (low, a, left) = (a, b, right);
                b = low + golden * (high - low);
                right = gain(b);
            }
        }
        Some(found)
    }

    /// Others of a family that the data admit, with what −2 ln L rises by: across the interval where that is `level`.
    fn admitted(
        &self,
        found: (f64, f64),
        range: (f64, f64),
        family: Family,
        level: f64,
    ) -> Vec<(FrontEnd, f64)> {
        let rise = |x: f64| found.1 - self.gain(family(x));
        let reach = |end: f64| {
            let (mut inside, mut outside) = (found.0, end);
            for share in [0.003, 0.01, 0.03, 0.1, 0.3] {
                let x = found.0 + share * (end - found.0);
                if rise(x) > level {
                    outside = x;
                    break;
                }
                inside = x;
            }
            for _ in 0..7 {
                let middle = 0.5 * (inside + outside);
                if rise(middle) > level {
                    outside = middle;
                } else {
                    inside = middle;
                }
            }
            inside - found.0
        };
        let (down, up) = (reach(range.0), reach(range.1));
        ACROSS
            .into_iter()
            .map(|share| found.0 + share.abs() * if share < 0.0 { down } else { up })
            .map(|x| (family(x), rise(x)))
            .collect()
    }
}

/// All powers of the polynomial, and each of them alone.
const ALL: [i32; 3] = [1, 2, 3];
const SINGLE: [[i32; 1]; 3] = [[1], [2], [3]];

/// A band that ends so many corners up shows whether a filter is that of one power.
const FAR: f64 = 3.0;

/// A likelihood behind a low-pass filter whose coefficients of these powers are fitted with the squares.
pub(crate) fn divided(
    mut likelihood: Likelihood,
    frequencies: &[f64],
    sample_rate: f64,
    start: [f64; 3],
    powers: &[i32],
) -> Likelihood {
    likelihood.divisors = powers
        .iter()
        .map(|k| {
            let powers = frequencies.iter().map(|f| warped(*f, sample_rate).powi(*k));
            powers.collect()
        })
        .collect();
    likelihood.divisor_start = powers.iter().map(|k| start[*k as usize - 1]).collect();
    likelihood
}

/// A front end by one parameter: the logarithm of w at a corner, or a loss.
type Family = fn(f64) -> FrontEnd;

/// What shapes the noise of a band.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Described {
    pub(crate) shape: FrontEnd,
    /// End of the band that terms and front end together describe, Hz.
    pub(crate) end: f64,
    /// The powers of a filter, which are fitted with the terms.
    pub(crate) powers: &'static [i32],
    /// Other overlaps that the data admit, with what −2 ln L rises by.
    pub(crate) admitted: Vec<(FrontEnd, f64)>,
}

impl Described {
    /// Up to which frequency a fit may rest on it.
    ///
    /// An overlap describes all of the spectrum or is none. Of a filter what lies above the frequency of half the power is left
    /// out, and half of the band that it describes: one that is slightly another harms less in half of the band in which that
    /// does not show.
    pub(crate) fn usable(&self, sample_rate: f64) -> f64 {
        match self.shape {
            FrontEnd::LowPass { .. } => {
                let corner = self.shape.half_power(sample_rate).unwrap_or(f64::MAX);
                f64::min(corner, 0.5 * self.end)
            }
            FrontEnd::Overlap { .. } => self.end,
        }
    }
}

/// What shapes the noise, from the widest band that terms and front end together describe.
///
/// Sought from half the sample rate down to `lowest`, without quantisation. In a narrower band the noise is shaped by less, and
/// less is known of what shapes it: where nothing describes even that, nothing is said.
pub(crate) fn describe(candidate: &Candidate<'_>, lowest: f64) -> Option<Described> {
    if let Some(overlap) = overlap(candidate) {
        return Some(overlap);
    }
    let mut highest = 0.5 * candidate.sample_rate;
    while highest > 0.999 * lowest {
        let trial = Trial::new(candidate, highest, true)?;
        if let Some((coefficients, powers)) = trial.low_pass() {
            return Some(Described {
                shape: FrontEnd::LowPass { coefficients },
                end: highest,
                powers,
                admitted: Vec::new(),
            });
        }
        highest /= STEP;
    }
    None
}

/// Averages that overlap, where they describe the whole spectrum.
pub(crate) fn overlap(candidate: &Candidate<'_>) -> Option<Described> {
    let end = 0.5 * candidate.sample_rate;
    let whole = Trial::new(candidate, end, true)?;
    let losses: Vec<f64> = (0..=10).map(|k| 0.1 * f64::from(k)).collect();
    let family: Family = |loss| FrontEnd::Overlap { loss };
    let found = whole.best(&losses, family)?;
    let shape = family(found.0);
    let shaped = whole.with(shape);
    let best = whole.fitted(&shaped)?;
    whole.describes(&shaped, &best).then(|| Described {
        shape,
        end,
        powers: &[],
        admitted: whole.admitted(found, (0.0, 1.0), family, candidate.level),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean of two neighbours: cos²(πf/f_s).
    #[test]
    fn known_mean_of_two_neighbours() {
        let mean = FrontEnd::Overlap { loss: 1.0 };
        for f in [0.0, 12.5, 25.0, 50.0] {
            let expected = (PI * f / 100.0).cos().powi(2);
            assert!((mean.response(f, 100.0) - expected).abs() < 1e-15);
        }
    }

    /// Butterworth filters of first and second order are of the form that is sought.
    #[test]
    fn known_half_power_at_the_corner() {
        for order in [1, 2] {
            let filter = LowPass { order, corner: 7.0 };
            let shape = FrontEnd::butterworth(filter, 100.0);
            assert!((shape.half_power(100.0).unwrap() - 7.0).abs() < 1e-9);
            for f in [0.1, 3.0, 20.0, 40.0] {
                let expected = filter.response(f, 100.0);
                assert!((shape.response(f, 100.0) / expected - 1.0).abs() < 1e-12);
            }
        }
    }
}
