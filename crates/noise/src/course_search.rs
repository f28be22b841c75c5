//! Courses beside noise are sought by the likelihood of the coloured model, as slow sinusoids are.

use crate::FitOptions;
use crate::averaged_record::{AveragedFit, AveragedRecord};
use crate::cosine_spectrum::Form;
use crate::course::{CourseShape, DAY};
use crate::edf::chi_square_quantile;
use crate::effects::Effects;
use crate::fit_record::FitRecord;
use crate::profile::form_level;
use crate::slow_sinusoid;
use crate::variance_fit::{Likelihood, Minimum};

/// Courses found at most.
const AT_MOST: usize = 3;

/// Steps tried at first, evenly over the record.
const STEPS: usize = 48;

/// Time constants tried per decade at first.
const PER_DECADE: f64 = 5.0;

/// Longest time constant as a share of the record: what settles more slowly is a ramp as far as the record tells.
const SLOWEST: f64 = 0.25;

/// Shortest, as a share of the record.
const FASTEST: f64 = 1.0 / 400.0;

/// Tries between the neighbours of the best, in each of two refinements.
const BETWEEN: usize = 9;

/// Shapes weighed at once: products of each with each other are not needed.
const TOGETHER: usize = 6;

/// Rise of −2 ln L beyond that of as many independent chances: a random walk takes the place of a course, and the lowest cosines are
/// few. Held against simulations (`examples/courses.rs`).
const EXCESS: f64 = 4.0;

/// Independent chances of steps and of exponentials in a record.
const CHANCES: (f64, f64) = (64.0, 8.0);

/// What a course that is not found must gain to be as good as none: about what the best of its kind gains by chance.
pub(crate) fn price(shape: CourseShape) -> f64 {
    match shape {
        CourseShape::Step { .. } => 8.0,
        CourseShape::Exponential { .. } => 4.0,
        CourseShape::DayCycle => 2.0,
    }
}

/// A course that chance does not explain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FoundCourse {
    pub(crate) shape: CourseShape,
    /// Limits of its time.
    pub(crate) interval: Option<(f64, f64)>,
    pub(crate) gain: f64,
}

/// What was found, and what the data admit beside it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Courses {
    pub(crate) found: Vec<FoundCourse>,
    pub(crate) near: Vec<Vec<CourseShape>>,
}

/// Seeks courses beside what is known.
pub(crate) fn seek(
    record: &FitRecord<'_>,
    known: &[Form],
    sample_rate: f64,
    options: &FitOptions,
) -> Courses {
    let mut courses = Courses::default();
    if !options.courses {
        return courses;
    }
    let mut averages = AveragedRecord::of(record, known, sample_rate);
    let Some(fit) = AveragedFit::new(&averages, options) else {
        return courses;
    };
    while let Some(search) = Search::of(&averages, &fit) {
        let mut best = search.best();
        best.sort_by(|a, b| {
            let excess = |c: &(CourseShape, f64)| c.1 - needed(c.0, options.false_alarm_rate);
            excess(b).total_cmp(&excess(a))
        });
        let Some(&(shape, gain)) = best.first() else {
            break;
        };
        let found = gain > needed(shape, options.false_alarm_rate)
            && courses.found.len() < AT_MOST
            && (shape == CourseShape::DayCycle || !search.oscillates(gain));
        if !found {
            let level = form_level(options.probability);
            let admitted: Vec<(CourseShape, f64)> = best
                .into_iter()
                .filter(|c| c.1 > price(c.0) - level)
                .collect();
            courses.near = search.near(&admitted);
            break;
        }
        courses.found.push(FoundCourse {
            shape: sharpened(shape, record, sample_rate, averages.factor),
            interval: search.interval(shape, gain, form_level(options.probability)),
            gain,
        });
        let further = search.forms(shape);
        averages.known.extend(further);
    }
    courses
}

/// What a course must gain for chance not to explain it: each kind has a third of the false alarms.
fn needed(shape: CourseShape, false_alarm_rate: f64) -> f64 {
    let (chances, parts) = match shape {
        CourseShape::Step { .. } => (CHANCES.0, 1.0),
        CourseShape::Exponential { .. } => (CHANCES.1, 1.0),
        CourseShape::DayCycle => (1.0, 2.0),
    };
    let quantile = chi_square_quantile(1.0 - false_alarm_rate / (3.0 * chances), parts);
    quantile.unwrap_or(f64::INFINITY) + EXCESS
}

struct Search<'a> {
    averages: &'a AveragedRecord,
    fit: &'a AveragedFit,
    /// The likelihood without a further course, and the forms in it.
    base: Likelihood,
    before: usize,
    /// Its least −2 ln L.
    none: Minimum,
}

impl<'a> Search<'a> {
    fn of(averages: &'a AveragedRecord, fit: &'a AveragedFit) -> Option<Self> {
        let (base, before) = fit.likelihood(averages, &[]);
        let none = fit.minimum(&base, 0)?;
        Some(Self {
            averages,
            fit,
            base,
            before,
            none,
        })
    }

    /// What further forms gain; nothing where they cannot be fitted.
    fn gain(&self, further: &[Form]) -> Option<f64> {
        let with = self.fit.least(self.averages, further)?;
        Some(self.none.value - with.value)
    }

    fn forms(&self, shape: CourseShape) -> Vec<Form> {
        let a = self.averages;
        shape.forms(&a.lengths(), &a.starts, a.sample_rate)
    }

    /// The boundary of two averages that is nearest, s from the first sample.
    fn boundary(&self, at: f64) -> f64 {
        (at * self.averages.sample_rate).round() / self.averages.sample_rate
    }

    /// The best of each kind with its gain.
    fn best(&self) -> Vec<(CourseShape, f64)> {
        let span = self.averages.span;
        let steps: Vec<CourseShape> = (1..STEPS)
            .map(|i| CourseShape::Step {
                at: self.boundary(span * i as f64 / STEPS as f64),
            })
            .collect();
        let decades = (SLOWEST / FASTEST).log10();
        let count = (decades * PER_DECADE).ceil();
        let times: Vec<CourseShape> = (0..=count as usize)
            .map(|i| CourseShape::Exponential {
                time: span * FASTEST * 10_f64.powf(decades * i as f64 / count),
            })
            .collect();
        let plain = self.fit.without_colour(&self.base);
        let densities: Vec<Vec<f64>> = [Some(&self.none), plain.as_ref()]
            .into_iter()
            .flatten()
            .filter_map(|m| self.base.density(&m.squares))
            .collect();
        let gain = |shape: CourseShape| self.gain(&self.forms(shape)).unwrap_or(0.0);
        let mut best: Vec<(CourseShape, f64)> = Vec::new();
        for kind in [&steps, &times] {
            let mut tried = self.refined(kind, &densities);
            tried.dedup();
            let gains = tried.into_iter().map(|shape| (shape, gain(shape)));
            best.extend(gains.max_by(|a, b| a.1.total_cmp(&b.1)));
        }
        if (0.5 * DAY..32.0 * DAY).contains(&span) {
            best.push((CourseShape::DayCycle, gain(CourseShape::DayCycle)));
        }
        best
    }

    /// Courses that may be there, by themselves and together; beside the best exponential the slowest, which is most like a ramp.
    fn near(&self, admitted: &[(CourseShape, f64)]) -> Vec<Vec<CourseShape>> {
        let mut near: Vec<Vec<CourseShape>> = admitted.iter().map(|c| vec![c.0]).collect();
        if near.len() > 1 {
            near.push(admitted.iter().map(|c| c.0).collect());
        }
        let slowest = SLOWEST * self.averages.span;
        let is_fast = |c: &(CourseShape, f64)| match c.0 {
            CourseShape::Exponential { time } => time < 0.7 * slowest,
            _ => false,
        };
        if admitted.iter().any(is_fast) {
            near.push(vec![CourseShape::Exponential { time: slowest }]);
        }
        near
    }

    /// Weights of shapes under each density.
    fn weights(&self, grid: &[CourseShape], densities: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut all = vec![Vec::new(); densities.len()];
        for some in grid.chunks(TOGETHER) {
            let forms: Vec<Form> = some.iter().flat_map(|s| self.forms(*s)).collect();
            let (likelihood, _) = self.fit.likelihood(self.averages, &forms);
            for (weights, density) in all.iter_mut().zip(densities) {
                weights.extend(
                    (0..some.len())
                        .map(|i| weight(&likelihood, self.before + i, self.before, density)),
                );
            }
        }
        all
    }

    /// The shape of most weight under each density, among these and then twice between the neighbours of the best.
    fn refined(&self, grid: &[CourseShape], densities: &[Vec<f64>]) -> Vec<CourseShape> {
        let best = |weights: &[f64]| -> Option<usize> {
            (0..weights.len()).max_by(|a, b| weights[*a].total_cmp(&weights[*b]))
        };
        let first = self.weights(grid, densities);
        let one = |(density, weights): (&Vec<f64>, &Vec<f64>)| -> Option<CourseShape> {
            let mut grid = grid.to_vec();
            let mut at = best(weights)?;
            for _ in 0..2 {
                let shape = *grid.get(at)?;
                let beside = |k: Option<usize>| k.and_then(|k| grid.get(k)).unwrap_or(&shape);
                let (low, high) = (*beside(at.checked_sub(1)), *beside(Some(at + 1)));
                grid = (0..=BETWEEN + 1)
                    .map(|i| self.between(low, high, i as f64 / (BETWEEN + 1) as f64))
                    .chain([shape])
                    .collect();
                grid.sort_by(|a, b| {
                    let time = |s: &CourseShape| s.time().unwrap_or(0.0);
                    time(a).total_cmp(&time(b))
                });
                grid.dedup();
                at = best(self.weights(&grid, std::slice::from_ref(density)).first()?)?;
            }
            grid.get(at).copied()
        };
        densities.iter().zip(&first).filter_map(one).collect()
    }

    fn between(&self, low: CourseShape, high: CourseShape, share: f64) -> CourseShape {
        match (low, high) {
            (CourseShape::Step { at: a }, CourseShape::Step { at: b }) => CourseShape::Step {
                at: self.boundary(a + share * (b - a)),
            },
            (CourseShape::Exponential { time: a }, CourseShape::Exponential { time: b }) => {
                CourseShape::Exponential {
                    time: a * (b / a).powf(share),
                }
            }
            _ => low,
        }
    }

    /// Whether a sinusoid of few cycles describes the record as well: then it is no course of these.
    fn oscillates(&self, gain: f64) -> bool {
        (6..=24_u32).any(|quarters| {
            let frequency = 0.25 * f64::from(quarters) / self.averages.span;
            let forms = slow_sinusoid::sinusoid(self.averages, frequency);
            self.gain(&forms).is_some_and(|with| with > gain)
        })
    }

    /// Where the likelihood, at its best over all else, has not fallen by more than the level.
    fn interval(&self, shape: CourseShape, gain: f64, level: f64) -> Option<(f64, f64)> {
        let best = shape.time()?;
        let span = self.averages.span;
        let with = |time: f64| match shape {
            CourseShape::Step { .. } => CourseShape::Step {
                at: self.boundary(time),
            },
            _ => CourseShape::Exponential { time },
        };
        let inside = |time: f64| {
            let found = self.gain(&self.forms(with(time)));
            found.is_some_and(|with| gain - with <= level)
        };
        let is_step = matches!(shape, CourseShape::Step { .. });
        let resolution = 1.0 / self.averages.sample_rate;
        let reach = |side: f64| {
            let at = |distance: f64| match is_step {
                true => best + side * distance * resolution,
                false => best * (side * 0.1 * distance).exp(),
            };
            let (mut near, mut far) = (0.0, 1.0);
            for _ in 0..14 {
                let time = at(far);
                if !(time > 0.0 && time < span && inside(time)) {
                    break;
                }
                (near, far) = (far, 2.0 * far);
            }
            for _ in 0..5 {
                let middle = 0.5 * (near + far);
                if inside(at(middle)) {
                    near = middle;
                } else {
                    far = middle;
                }
            }
            at(far).clamp(0.0, span)
        };
        Some((reach(-1.0), reach(1.0)))
    }
}

/// Square of the size of a form in its standard uncertainties under a density, those before it at their best.
fn weight(likelihood: &Likelihood, form: usize, before: usize, density: &[f64]) -> f64 {
    let mut order = vec![form];
    order.extend(0..before);
    let led = likelihood.with_forms(&order);
    let first = led.eliminated(density, Effects::Best(1)).first();
    first.map_or(0.0, |(size, u)| (size / u).powi(2))
}

/// A step at the sample where it is, and not between two averages: the split of least squares within two averages.
fn sharpened(
    shape: CourseShape,
    record: &FitRecord<'_>,
    sample_rate: f64,
    factor: usize,
) -> CourseShape {
    let CourseShape::Step { at } = shape else {
        return shape;
    };
    let starts = record.starts();
    let first = starts.first().copied().unwrap_or(0);
    let place = (at * sample_rate).round() as usize + first;
    let stretch = record.stretches.iter().zip(&starts);
    let Some((samples, middle)) = stretch
        .map(|(s, start)| (*s, place.wrapping_sub(*start)))
        .find(|(s, middle)| *middle < s.len())
    else {
        return shape;
    };
    let (from, to) = (
        middle.saturating_sub(8 * factor),
        (middle + 8 * factor).min(samples.len()),
    );
    let window = &samples[from..to];
    let total: f64 = window.iter().sum();
    let mut before: f64 = 0.0;
    let mut best = (f64::NEG_INFINITY, middle);
    for (i, y) in window.iter().enumerate() {
        let k = from + i;
        let (m, n) = (i as f64, (window.len() - i) as f64);
        if i > 0 && k.abs_diff(middle) <= factor {
            // Sums of squares of the means on either side.
            let explained = before * before / m + (total - before).powi(2) / n;
            if explained > best.0 {
                best = (explained, k);
            }
        }
        before += y;
    }
    let moved = (best.1 as f64 - middle as f64) / sample_rate;
    CourseShape::Step { at: at + moved }
}
