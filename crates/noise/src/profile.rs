//! Intervals of noise coefficients from profile likelihoods: every term is in the model, none is selected.

use crate::edf::chi_square_quantile;
use crate::effects::Effects;
use crate::variance_fit::{Likelihood, Minimum};

/// A square held at a value costs up to this much more likelihood than χ² of one degree of freedom: the other squares
/// cannot become negative, and the lowest cosines are few. Calibrated by simulation (`examples/coverage.rs`).
const SQUARE_STRETCH: f64 = 1.2;

/// Likelihood that the slope costs beyond χ² of one degree of freedom, by probability: in the worst case over the length
/// of the record a random walk takes its place. Calibrated by simulation (`examples/coverage.rs`).
const SLOPE_EXCESS: [(f64, f64); 6] = [
    (0.0, 0.0),
    (0.683, 1.5),
    (0.90, 2.7),
    (0.95, 3.06),
    (0.99, 3.67),
    (0.999, 5.5),
];

/// Rise of −2 ln L at the ends of the interval of a square.
pub(crate) fn square_level(probability: f64) -> f64 {
    SQUARE_STRETCH * chi_square_quantile(probability, 1.0).unwrap_or(f64::INFINITY)
}

/// Rise of −2 ln L at the ends of the interval of the slope.
pub(crate) fn slope_level(probability: f64) -> f64 {
    let excess = SLOPE_EXCESS
        .windows(2)
        .find(|w| probability <= w[1].0)
        .map_or(5.5, |w| {
            let share = (probability - w[0].0) / (w[1].0 - w[0].0);
            w[0].1 + share * (w[1].1 - w[0].1)
        });
    chi_square_quantile(probability, 1.0).unwrap_or(f64::INFINITY) + excess
}

/// Rise of −2 ln L at the ends of the interval of the size of another form.
pub(crate) fn form_level(probability: f64) -> f64 {
    slope_level(probability)
}

/// What the profile of one parameter says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Profile {
    /// Its best value.
    pub(crate) best: f64,
    /// Limits of the interval; a square's lower limit may be zero.
    pub(crate) interval: (f64, f64),
    /// Rise of −2 ln L at zero.
    pub(crate) gain: f64,
}

/// The fit of all terms, from which profiles start.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    pub(crate) likelihood: Likelihood,
    /// Values that are not to be fitted.
    pub(crate) held: Vec<Option<f64>>,
    /// Which column is the random walk, if any: a ramp takes its place.
    pub(crate) walk: Option<usize>,
    pub(crate) best: Minimum,
}

impl Fitted {
    pub(crate) fn new(
        likelihood: Likelihood,
        held: Vec<Option<f64>>,
        walk: Option<usize>,
    ) -> Option<Self> {
        let crude = likelihood.start();
        let low: Vec<f64> = crude.iter().map(|v| 0.1 * v).collect();
        let best = likelihood.minimise(&[&crude, &low], &held, Effects::Restricted)?;
        Some(Self {
            likelihood,
            held,
            walk,
            best,
        })
    }

    /// With another form ahead: the one whose size [`Fitted::first`] profiles.
    pub(crate) fn led_by(&self, form: usize) -> Self {
        Self {
            likelihood: self.likelihood.led_by(form),
            ..self.clone()
        }
    }

    /// D_j(x): least −2 ln L with square j at x, over the least of all.
    fn rise(&self, j: usize, x: f64, near: &Minimum) -> Minimum {
        let mut held = self.held.clone();
        held[j] = Some(x);
        let crude = self.likelihood.start();
        let starts: [&[f64]; 3] = [&near.squares, &self.best.squares, &crude];
        let mut found = self
            .likelihood
            .minimise(&starts, &held, Effects::Restricted)
            .unwrap_or(Minimum {
                squares: near.squares.clone(),
                value: f64::INFINITY,
            });
        found.value -= self.best.value;
        found
    }

    /// Rise of −2 ln L where square j is zero.
    pub(crate) fn gain(&self, j: usize) -> f64 {
        self.rise(j, 0.0, &self.best).value.clamp(0.0, f64::MAX)
    }

    /// Interval of square j where −2 ln L rises by `level`.
    pub(crate) fn square(&self, j: usize, level: f64) -> Profile {
        let best = self.best.squares[j];
        let gain = self.gain(j);
        // Scale of the search: where the term by itself would fill the lowest bins.
        let scale = if best > 0.0 {
            best
        } else {
            1e-3 * self.likelihood.start()[j].max(f64::MIN_POSITIVE)
        };
        let (mut inside, mut outside) = (best, scale);
        let mut near = self.best.clone();
        for _ in 0..200 {
            if outside > best {
                let found = self.rise(j, outside, &near);
                if found.value > level {
                    break;
                }
                inside = outside;
                near = found;
            }
            outside *= 1.7;
        }
        let high = self.crossing(j, inside, outside, level, &near);
        let low = if gain <= level {
            0.0
        } else {
            let (mut inside, mut outside) = (best, 0.6 * best);
            let mut near = self.best.clone();
            for _ in 0..60 {
                let found = self.rise(j, outside, &near);
                if found.value > level {
                    break;
                }
                inside = outside;
                near = found;
                outside *= 0.6;
            }
            self.crossing(j, inside, outside, level, &near)
        };
        Profile {
            best,
            interval: (low, high),
            gain,
        }
    }

    /// Where the rise crosses the level, between a value inside and one outside.
    fn crossing(
        &self,
        j: usize,
        mut inside: f64,
        mut outside: f64,
        level: f64,
        near: &Minimum,
    ) -> f64 {
        let mut near = near.clone();
        for _ in 0..12 {
            let middle = if inside > 0.0 && outside > 0.0 {
                (inside * outside).sqrt()
            } else {
                0.5 * (inside + outside)
            };
            let found = self.rise(j, middle, &near);
            if found.value > level {
                outside = middle;
            } else {
                inside = middle;
                near = found;
            }
        }
        outside
    }

    /// Whether square j may lie outside an interval at this level.
    pub(crate) fn square_reaches_beyond(
        &self,
        j: usize,
        (low, high): (f64, f64),
        level: f64,
    ) -> bool {
        let best = self.best.squares[j];
        best >= high
            || self.rise(j, high, &self.best).value <= level
            || low > 0.0 && (best <= low || self.rise(j, low, &self.best).value <= level)
    }

    /// Whether the size of the first form may lie outside an interval at this level.
    pub(crate) fn first_reaches_beyond(&self, (low, high): (f64, f64), level: f64) -> bool {
        let crude = self.likelihood.start();
        let starts: [&[f64]; 2] = [&self.best.squares, &crude];
        let least = |effects| self.likelihood.minimise(&starts, &self.held, effects);
        let Some(best) = least(Effects::Best(1)) else {
            return false;
        };
        let Some((size, _)) = self.likelihood.first(&best.squares) else {
            return false;
        };
        let admits = |x| {
            let there = least(Effects::FirstAt(x));
            there.is_some_and(|m| m.value - best.value <= level)
        };
        size <= low || size >= high || admits(low) || admits(high)
    }

    /// Rise of −2 ln L without the first form.
    pub(crate) fn gain_of_first(&self) -> Option<f64> {
        let crude = self.likelihood.start();
        let starts: [&[f64]; 2] = [&self.best.squares, &crude];
        let least = |effects| self.likelihood.minimise(&starts, &self.held, effects);
        let (flat, best) = (least(Effects::FirstAt(0.0))?, least(Effects::Best(1))?);
        Some((flat.value - best.value).max(0.0))
    }

    /// Interval of the size of the first form (the slope of a ramp) where −2 ln L, at its best over all squares and with the other
    /// forms integrated out, rises by `level`.
    ///
    /// A record of a walk and one of a ramp resemble each other: the likelihood has an optimum for either, and the
    /// interval spans both where both are admitted. With fewer starts the walk is looked for less often.
    pub(crate) fn first(&self, level: f64, thorough: bool) -> Option<Profile> {
        let likelihood = &self.likelihood;
        if likelihood.forms == 0 {
            return None;
        }
        let crude = likelihood.start();
        let flat = likelihood.minimise(
            &[&self.best.squares, &crude],
            &self.held,
            Effects::FirstAt(0.0),
        )?;
        let mut weak = self.best.squares.clone();
        if let Some(walk) = self.walk {
            weak[walk] *= 0.03;
        }
        let starts: [&[f64]; 4] = [&self.best.squares, &flat.squares, &crude, &weak];
        let mut optima: Vec<(f64, f64, Minimum)> = starts
            .iter()
            .filter_map(|s| likelihood.minimise_from(s, &self.held, Effects::Best(1)))
            .filter_map(|m| {
                let (size, u) = likelihood.first(&m.squares)?;
                Some((size, u, m))
            })
            .collect();
        optima.sort_by(|a, b| a.2.value.total_cmp(&b.2.value));
        let (best, u, least) = optima.first()?.clone();
        let rise = |x: f64, near: &[f64]| -> (f64, Vec<f64>) {
            let starts: [&[f64]; 4] = [near, &flat.squares, &self.best.squares, &crude];
            let starts = if thorough { &starts[..] } else { &starts[..2] };
            likelihood
                .minimise(starts, &self.held, Effects::FirstAt(x))
                .map_or((f64::INFINITY, near.to_vec()), |m| {
                    (m.value - least.value, m.squares)
                })
        };
        let admitted = |o: &&(f64, f64, Minimum)| o.2.value - least.value <= level;
        let reach = |side: f64| {
            let from = optima
                .iter()
                .filter(admitted)
                .map(|o| side * o.0)
                .fold(side * best, f64::max);
            let (mut inside, mut step) = (from, u);
            let mut near = least.squares.clone();
            let mut outside = inside + step;
            for _ in 0..80 {
                let (value, squares) = rise(side * outside, &near);
                if value > level {
                    break;
                }
                inside = outside;
                near = squares;
                step *= 1.6;
                outside = inside + step;
            }
            for _ in 0..12 {
                let middle = 0.5 * (inside + outside);
                let (value, squares) = rise(side * middle, &near);
                if value > level {
                    outside = middle;
                } else {
                    inside = middle;
                    near = squares;
                }
            }
            side * outside
        };
        Some(Profile {
            best,
            interval: (reach(-1.0), reach(1.0)),
            gain: (flat.value - least.value).max(0.0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Term;
    use crate::cosine_spectrum::CosineSpectrum;
    use crate::term_density::{Process, column};

    fn fixture() -> Likelihood {
        let y: Vec<f64> = (0..64_u32)
            .map(|i| {
                f64::from((7 * i * i + 3 * i) % 17) / 17.0
                    + 0.05 * f64::from(i)
                    + 0.5 * f64::from(i / 23)
            })
            .collect();
        let spectrum = CosineSpectrum::new(&[&y], 1.0, &[]);
        let terms = [
            Term::Quantisation,
            Term::White,
            Term::Flicker,
            Term::RandomWalk,
        ];
        let columns = terms
            .iter()
            .map(|t| column(&spectrum, Process::Power(*t), 1))
            .collect();
        Likelihood::new(&spectrum, columns)
    }

    /// Values worked out by an independent program.
    #[test]
    fn known_likelihood_of_a_short_record() {
        let l = fixture();
        let v = [0.0, 0.1, 0.05, 0.01];
        let (slope, u) = l.first(&v).unwrap();
        assert!((slope - 0.073_001_4).abs() < 1e-6 && (u - 0.014_581_1).abs() < 1e-6);
        assert!((l.value(&v, Effects::Best(1)) + 26.1337).abs() < 2e-3);
        assert!((l.value(&v, Effects::FirstAt(0.0)) + 1.067_73).abs() < 2e-3);
        assert!((l.value(&v, Effects::Restricted) + 17.6776).abs() < 2e-3);
    }

    #[test]
    fn known_fit_of_a_short_record() {
        let fit = Fitted::new(fixture(), vec![None; 4], Some(3)).unwrap();
        println!("{:?}", fit.best);
        assert!((fit.best.value + 31.5391).abs() < 2e-3);
        for (v, expected) in fit
            .best
            .squares
            .iter()
            .zip([0.019_384_1, 0.0, 0.0, 0.034_263_4])
        {
            assert!((v - expected).abs() < 1e-4, "{v} {expected}");
        }
        let limits = [
            (0.003_349_35, 0.034_710_2),
            (0.0, 0.052_617_9),
            (0.0, 0.089_094_0),
            (0.0, 0.069_182_7),
        ];
        for (j, (low, high)) in limits.into_iter().enumerate() {
            let p = fit.square(j, 4.6);
            assert!((p.interval.0 - low).abs() < 2e-4, "{j} {p:?}");
            assert!((p.interval.1 / high - 1.0).abs() < 5e-3, "{j} {p:?}");
        }
        assert!((fit.square(0, 4.6).gain - 5.667_65).abs() < 5e-3);
        assert!((fit.square(3, 4.6).gain - 4.267_64).abs() < 5e-3);
        let r = fit.first(6.9, true).unwrap();
        assert!((r.gain - 8.184_04).abs() < 5e-3, "{r:?}");
    }
}
