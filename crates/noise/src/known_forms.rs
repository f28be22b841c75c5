//! What stands beside the noise of a record and is known but for its size: of the fit, and in others that the data admit.

use crate::FitOptions;
use crate::Term;
use crate::cosine_spectrum::Form;
use crate::course::CourseShape;
use crate::course_search::{self, Courses};
use crate::fit_record::FitRecord;
use crate::quick_fit::sinusoid_forms;
use crate::slow_sinusoid::{self, SlowSinusoid};
use crate::temperature_effect::Temperature;
use crate::temperature_lag::{self, Lag};
use crate::variance_fit::Likelihood;

/// Where in the interval of its time a course is varied, in half intervals from its best value.
const ACROSS: [f64; 2] = [-0.8, 0.8];

/// Forms of a record, the ramp not among them.
pub(crate) struct KnownForms {
    pub(crate) temperature: Option<Temperature>,
    pub(crate) lag: Lag,
    pub(crate) slow: Vec<SlowSinusoid>,
    pub(crate) courses: Courses,
    /// All of them.
    pub(crate) forms: Vec<Form>,
    /// Those of the fit: temperature, sinusoids, what settles over the lag, courses.
    pub(crate) best: Vec<usize>,
    /// Those of other fits.
    pub(crate) kin: Vec<Kin>,
}

/// Forms of another fit.
#[derive(Clone, Debug)]
pub(crate) struct Kin {
    pub(crate) forms: Vec<usize>,
    /// What it must gain to be as good as the fit.
    pub(crate) price: f64,
    /// Its lag behind the temperature.
    pub(crate) lag: Option<f64>,
}

impl KnownForms {
    pub(crate) fn of(record: &FitRecord<'_>, sample_rate: f64, options: &FitOptions) -> Self {
        let temperature = Temperature::of(record, sample_rate);
        let lag = match (&temperature, options.temperature_lag) {
            (_, Some(lag)) => Lag::given(lag),
            (None, None) => Lag::given(0.0),
            (Some(temperature), None) => Lag::seek(record, temperature, sample_rate, options),
        };
        let behind = |lag: f64| -> Vec<Form> {
            let forms = temperature
                .as_ref()
                .map(|t| t.behind(record, sample_rate, lag));
            forms.unwrap_or_default()
        };
        let followed = behind(lag.best);
        let mut courses = course_search::seek(record, &followed, sample_rate, options);
        let (lengths, starts) = record.lengths_and_starts(sample_rate);
        let course = |shape: CourseShape| shape.forms(&lengths, &starts, sample_rate);
        let mut slow: Vec<SlowSinusoid> = Vec::new();
        if options.seeks(Term::Sinusoid) {
            let mut known = followed.clone();
            known.extend(courses.found.iter().flat_map(|c| course(c.shape)));
            slow = slow_sinusoid::find(record, &known, sample_rate, options);
            if !slow.is_empty() {
                // What a sinusoid is may have looked like a course.
                let mut known = followed.clone();
                for found in &slow {
                    known.extend(sinusoid_forms(record, sample_rate, found.frequency));
                }
                courses = course_search::seek(record, &known, sample_rate, options);
            }
        }

        let mut all: Vec<Form> = Vec::new();
        let mut add = |forms: Vec<Form>| -> Vec<usize> {
            let first = all.len();
            all.extend(forms);
            (first..all.len()).collect()
        };
        let followed = add(followed);
        let mut sinusoids = Vec::new();
        for found in &slow {
            sinusoids.extend(add(
                sinusoid_forms(record, sample_rate, found.frequency).into()
            ));
        }
        let found: Vec<Vec<usize>> = courses.found.iter().map(|c| add(course(c.shape))).collect();
        let joined = |followed: &[usize], courses: &[Vec<usize>]| -> Vec<usize> {
            let (first, settling) = followed.split_at(followed.len().min(1));
            [first, &sinusoids, settling, &courses.concat()].concat()
        };
        let best = joined(&followed, &found);
        let mut kin = Vec::new();
        for other in &lag.admitted {
            kin.push(Kin {
                forms: joined(&add(behind(*other)), &found),
                price: temperature_lag::price(*other),
                lag: Some(*other),
            });
        }
        let of_the_lag = temperature_lag::price(lag.best);
        let lag_of_fit = temperature.is_some().then_some(lag.best);
        for shapes in &courses.near {
            let mut with = found.clone();
            with.extend(shapes.iter().map(|s| add(course(*s))));
            let prices = shapes.iter().map(|s| course_search::price(*s));
            kin.push(Kin {
                forms: joined(&followed, &with),
                price: of_the_lag + prices.sum::<f64>(),
                lag: lag_of_fit,
            });
        }
        for (index, one) in courses.found.iter().enumerate() {
            let (Some(time), Some((low, high))) = (one.shape.time(), one.interval) else {
                continue;
            };
            for share in ACROSS {
                let end: f64 = if share < 0.0 { low } else { high };
                let moved = match one.shape {
                    CourseShape::Exponential { .. } if end > 0.0 => CourseShape::Exponential {
                        time: time * (end / time).powf(f64::abs(share)),
                    },
                    CourseShape::Step { .. } => CourseShape::Step {
                        at: time + f64::abs(share) * (end - time),
                    },
                    _ => continue,
                };
                let mut with = found.clone();
                with[index] = add(course(moved));
                kin.push(Kin {
                    forms: joined(&followed, &with),
                    price: of_the_lag,
                    lag: lag_of_fit,
                });
            }
        }
        Self {
            temperature,
            lag,
            slow,
            courses,
            forms: all,
            best,
            kin,
        }
    }

    /// Forms of the fit before what settles and the courses, the ramp not counted.
    pub(crate) fn head(&self) -> usize {
        usize::from(self.temperature.is_some()) + 2 * self.slow.len()
    }

    /// Whether something settles over the lag of the fit.
    pub(crate) fn settles(&self) -> bool {
        self.temperature.is_some() && self.lag.best > 0.0
    }

    /// What the fit must gain to be as good as one without a lag.
    pub(crate) fn price(&self) -> f64 {
        temperature_lag::price(self.lag.best)
    }

    /// Forms that the fit has beside ramp, temperature and sinusoids.
    pub(crate) fn further(&self) -> usize {
        self.best.len() - self.head()
    }

    /// Times and frequencies that are fitted beside the sizes of the forms.
    pub(crate) fn times(&self) -> usize {
        let courses = self.courses.found.iter();
        usize::from(self.settles())
            + self.slow.len()
            + courses.filter(|c| c.shape.time().is_some()).count()
    }

    /// The forms of the fit themselves.
    pub(crate) fn of_the_fit(&self) -> Vec<Form> {
        self.best.iter().map(|k| self.forms[*k].clone()).collect()
    }

    /// A likelihood of all forms behind `ramp` others, with those of a fit alone.
    pub(crate) fn chosen(&self, all: &Likelihood, ramp: usize, forms: &[usize]) -> Likelihood {
        let mut order: Vec<usize> = (0..ramp).collect();
        order.extend(forms.iter().map(|k| ramp + k));
        all.with_forms(&order)
    }

    /// The likelihood of a fit with temperature, what settles and courses ahead, and how many these are.
    pub(crate) fn ahead(&self, chosen: &Likelihood, ramp: usize) -> (Likelihood, usize) {
        let temperature = usize::from(self.temperature.is_some());
        let mut order: Vec<usize> = (ramp..ramp + temperature).collect();
        order.extend(ramp + self.head()..chosen.forms);
        let count = order.len();
        order.extend(
            (0..chosen.forms)
                .filter(|f| *f < ramp || (*f >= ramp + temperature && *f < ramp + self.head())),
        );
        (chosen.with_forms(&order), count)
    }
}
