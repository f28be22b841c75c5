//! Courses beside noise that are known but for their size: settling after the start, a lasting step, the cycle of the day.

use crate::coefficients::Limits;
use crate::cosine_spectrum::Form;
use crate::course_search::FoundCourse;
use crate::effects::Effects;
use crate::fit_family::{Family, SLACK};
use crate::profile::{Profile, form_level};
use crate::slow_sinusoid;
use crate::{FitOptions, Verdict};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Seconds of a day.
pub(crate) const DAY: f64 = 86_400.0;

/// What a course looks like. Times in s from the first sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
#[non_exhaustive]
pub enum CourseShape {
    /// e^{−t/T}: the sensor warms up, or settles after it was moved.
    Exponential {
        /// T, s.
        time: f64,
    },
    /// The level changes once.
    Step {
        /// When, s.
        at: f64,
    },
    /// A sinusoid with the period of a day.
    DayCycle,
}

/// A course found in a record.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Course {
    /// What it looks like.
    pub shape: CourseShape,
    /// Limits of its time at the probability of the fit, s; of a day's cycle there are none.
    pub interval: Option<(f64, f64)>,
    /// Its size at the start of the record, its height, or its amplitude.
    pub size: Verdict,
    /// Sizes of its parts: one, or of a cycle those of cosine and sine.
    pub parts: [f64; 2],
    /// Gain over the model without it.
    pub gain: f64,
}

/// Courses of a fit with their sizes, whose forms begin at a place of it.
pub(crate) fn sizes(
    family: &Family,
    first: usize,
    found: &[FoundCourse],
    options: &FitOptions,
) -> Vec<Course> {
    let fitted = &family.fitted;
    let sizes = fitted
        .likelihood
        .density(&fitted.best.squares)
        .map(|d| {
            fitted
                .likelihood
                .eliminated(&d, Effects::Restricted)
                .sizes()
        })
        .unwrap_or_default();
    let size = |k: usize| sizes.get(k).copied().unwrap_or(0.0);
    let limits = Limits {
        needed: 0.0,
        excludes_zero: 0.0,
        forced: true,
        probability: options.probability,
    };
    let mut place = first;
    let mut courses = Vec::new();
    for one in found {
        let is_cycle = one.shape == CourseShape::DayCycle;
        let (profile, parts) = if is_cycle {
            let parts = [size(place), size(place + 1)];
            let profile = slow_sinusoid::in_phase(fitted, (place, place + 1), options);
            (profile.map(|p| p.0), parts)
        } else {
            let profiles = family.form(place, form_level(options.probability), SLACK);
            (profiles.map(|p| p.up_to(f64::INFINITY)), [size(place), 0.0])
        };
        if let Some(profile) = profile {
            courses.push(Course {
                shape: one.shape,
                interval: one.interval,
                size: limits.verdict(&Profile {
                    gain: one.gain,
                    ..profile
                }),
                parts,
                gain: one.gain,
            });
        }
        place += 1 + usize::from(is_cycle);
    }
    courses
}

impl fmt::Display for CourseShape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exponential { .. } => f.write_str("exponential from the start on"),
            Self::Step { .. } => f.write_str("lasting step"),
            Self::DayCycle => f.write_str("cycle of the day"),
        }
    }
}

impl CourseShape {
    /// Its time, s.
    pub fn time(self) -> Option<f64> {
        match self {
            Self::Exponential { time } => Some(time),
            Self::Step { at } => Some(at),
            Self::DayCycle => None,
        }
    }

    /// Over stretches of these lengths that begin at these times in s; one form, or two of a cycle.
    pub(crate) fn forms(self, lengths: &[usize], starts: &[f64], sample_rate: f64) -> Vec<Form> {
        let first = starts.first().copied().unwrap_or(0.0);
        let of = |value: &dyn Fn(f64) -> f64| {
            let samples = lengths.iter().zip(starts).map(|(n, start)| {
                (0..*n)
                    .map(|i| value(start - first + i as f64 / sample_rate))
                    .collect()
            });
            vec![Form::new(samples.collect())]
        };
        match self {
            Self::Exponential { time } => of(&|t| (-t / time).exp()),
            // A quarter of a sample for what the times are rounded to.
            Self::Step { at } => of(&|t| f64::from(u8::from(t >= at - 0.25 / sample_rate))),
            Self::DayCycle => slow_sinusoid::forms(lengths, starts, sample_rate, 1.0 / DAY).into(),
        }
    }
}
