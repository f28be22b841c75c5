//! Fits of one record that differ in what no column of the likelihood shows: a corner, a correlation time.

use crate::FitOptions;
use crate::cosine_spectrum::CosineSpectrum;
use crate::effects::Effects;
use crate::front_end::{Described, FrontEnd, divided};
use crate::known_forms::KnownForms;
use crate::markov::{Markov, times};
use crate::profile::{Fitted, Profile, square_level};
use crate::term_density::{Process, column};
use crate::variance_fit::Likelihood;

/// Where in the interval of a parameter it is varied, in half intervals from its best value.
pub(crate) const ACROSS: [f64; 6] = [-0.93, -0.7, -0.35, 0.35, 0.7, 0.93];

/// Correlation times per decade of a process that does not stand out.
const COARSE: f64 = 3.0;

/// Rise of −2 ln L at which a fit with other slow courses has the whole level for its own parameters. Held against simulations
/// (`examples/courses.rs`).
pub(crate) const SLACK: f64 = 2.0;

/// Builds the likelihood of a band for a front end and for processes of given times. A low-pass filter is fitted with the terms,
/// from these coefficients on.
#[derive(Clone, Debug)]
pub(crate) struct Builder<'a> {
    /// The power laws, as they are in front of the front end.
    pub(crate) base: Likelihood,
    /// Frequencies of the band, Hz.
    pub(crate) frequencies: Vec<f64>,
    /// Powers of the low-pass filter.
    pub(crate) powers: &'static [i32],
    pub(crate) spectrum: &'a CosineSpectrum,
}

impl Builder<'_> {
    pub(crate) fn likelihood(&self, front_end: Option<FrontEnd>, times: &[f64]) -> Likelihood {
        let highest = self.frequencies.iter().copied().fold(0.0, f64::max);
        let mut built = self.base.clone();
        for time in times {
            let whole = column(self.spectrum, Process::Markov(*time), 1);
            let bins = self.spectrum.bins.iter().zip(whole);
            built.columns.push(
                bins.filter(|(b, _)| b.frequency <= highest)
                    .map(|(_, g)| g)
                    .collect(),
            );
        }
        let rate = self.spectrum.sample_rate;
        match front_end {
            None => built,
            Some(FrontEnd::LowPass { coefficients }) => {
                divided(built, &self.frequencies, rate, coefficients, self.powers)
            }
            Some(shape) => {
                for column in &mut built.columns {
                    shape.apply(column, &self.frequencies, rate);
                }
                built
            }
        }
    }
}

/// The fit whose values are given, and others that the data admit.
///
/// An interval is the union of those of all members, each from the least −2 ln L of its kin: the profile over what differs
/// between them. With one member it is that of the fit itself.
#[derive(Clone, Debug)]
pub(crate) struct Family {
    pub(crate) fitted: Fitted,
    /// Other fits.
    others: Vec<Member>,
}

/// Another fit that the data admit.
#[derive(Clone, Debug)]
struct Member {
    fitted: Fitted,
    /// What its −2 ln L lies above the least of its kin.
    above: f64,
    /// Whether it differs in slow courses alone, which fast noise does not see.
    slow: bool,
    /// Its lag behind the temperature, s.
    lag: Option<f64>,
}

impl Family {
    pub(crate) fn new(fitted: Fitted) -> Self {
        Self {
            fitted,
            others: Vec::new(),
        }
    }

    /// Adds a fit whose −2 ln L lies so far above the least of its kin.
    pub(crate) fn add(&mut self, fitted: Fitted, above: f64) {
        self.others.push(Member {
            fitted,
            above: above.max(0.0),
            slow: false,
            lag: None,
        });
    }

    /// Adds a fit that differs in slow courses: of these forms, behind this lag.
    pub(crate) fn add_slow(&mut self, fitted: Fitted, above: f64, lag: Option<f64>) {
        self.others.push(Member {
            fitted,
            above: above.max(0.0),
            slow: true,
            lag,
        });
    }

    /// Adds the other front ends that the data admit.
    pub(crate) fn vary_front_end(
        &mut self,
        builder: &Builder<'_>,
        described: &Described,
        processes: &[Markov],
    ) {
        let times: Vec<f64> = processes.iter().map(|p| p.time).collect();
        for (shape, above) in &described.admitted {
            let likelihood = builder.likelihood(Some(*shape), &times);
            let held = self.fitted.held.clone();
            if let Some(fitted) = Fitted::new(likelihood, held, self.fitted.walk) {
                self.add(fitted, *above);
            }
        }
    }

    /// Adds the other correlation times that the data admit; where no process stands out, one of any time, which may be there all
    /// the same.
    pub(crate) fn vary_times(
        &mut self,
        builder: &Builder<'_>,
        front_end: Option<FrontEnd>,
        processes: &[Markov],
        options: &FitOptions,
    ) {
        let best: Vec<f64> = processes.iter().map(|p| p.time).collect();
        let mut held = self.fitted.held.clone();
        let mut sets: Vec<Vec<f64>> = Vec::new();
        if best.is_empty() {
            held.push(None);
            let highest = builder.frequencies.iter().copied().fold(0.0, f64::max);
            // Faster, and it would be white noise by another name.
            let slower = 0.25 * highest;
            sets.extend(times(slower, builder.spectrum.longest, COARSE).map(|t| vec![t]));
        }
        for (index, process) in processes.iter().enumerate() {
            for share in ACROSS {
                let mut set = best.clone();
                let end = if share < 0.0 {
                    process.interval.0
                } else {
                    process.interval.1
                };
                set[index] = process.time * (end / process.time).powf(share.abs());
                sets.push(set);
            }
        }
        let kin: Vec<Fitted> = sets
            .into_iter()
            .filter_map(|set| {
                let likelihood = builder.likelihood(front_end, &set);
                Fitted::new(likelihood, held.clone(), self.fitted.walk)
            })
            .collect();
        let floor = if best.is_empty() {
            f64::INFINITY
        } else {
            self.fitted.best.value
        };
        let least = kin.iter().map(|f| f.best.value).fold(floor, f64::min);
        // A member so far off neither widens an interval nor makes a term doubtful.
        let reach = square_level(1.0 - options.false_alarm_rate);
        for fitted in kin {
            let above = fitted.best.value - least;
            if above <= reach {
                self.add(fitted, above);
            }
        }
    }

    /// Adds fits with other courses beside the noise that the data admit; `all` has every form, `ramp` of them not among the known ones.
    pub(crate) fn vary_courses(
        &mut self,
        builder: &Builder<'_>,
        (all, ramp): (&Likelihood, usize),
        (front_end, processes): (Option<FrontEnd>, &[Markov]),
        known: &KnownForms,
        options: &FitOptions,
    ) {
        let times: Vec<f64> = processes.iter().map(|p| p.time).collect();
        let value = |fitted: &Fitted| -> f64 {
            let (ahead, count) = known.ahead(&fitted.likelihood, ramp);
            let crude = ahead.start();
            ahead
                .minimise(
                    &[&fitted.best.squares, &crude],
                    &fitted.held,
                    Effects::Best(count),
                )
                .map_or(f64::INFINITY, |m| m.value)
        };
        let of_the_fit = value(&self.fitted) + known.price();
        let kin: Vec<(Fitted, f64, Option<f64>)> = known
            .kin
            .iter()
            .filter_map(|kin| {
                let other = Builder {
                    base: known.chosen(all, ramp, &kin.forms),
                    ..builder.clone()
                };
                let likelihood = other.likelihood(front_end, &times);
                let held = self.fitted.held.clone();
                let fitted = Fitted::new(likelihood, held, self.fitted.walk)?;
                let value = value(&fitted) + kin.price;
                Some((fitted, value, kin.lag))
            })
            .collect();
        let least = kin.iter().map(|k| k.1).fold(of_the_fit, f64::min);
        let reach = square_level(1.0 - options.false_alarm_rate);
        for (fitted, value, lag) in kin {
            if value - least <= reach {
                self.add_slow(fitted, value - least, lag);
            }
        }
    }

    /// Interval of square j where −2 ln L, at its best over all else and all members, rises by `level`; of what is fast without those
    /// that differ in slow courses.
    pub(crate) fn square(&self, j: usize, level: f64, is_fast: bool) -> Profile {
        let mut profile = self.fitted.square(j, level);
        for member in self.others.iter().filter(|m| !(m.slow && is_fast)) {
            let (above, left) = (member.above, member.left(level));
            if left > 0.0
                && member
                    .fitted
                    .square_reaches_beyond(j, profile.interval, left)
            {
                join(&mut profile, &member.fitted.square(j, left), above);
            } else {
                profile.gain = profile.gain.min(above + member.fitted.gain(j));
            }
        }
        profile
    }

    /// Profiles of the size of a form: of the fit, and of the members that differ in slow courses, each with its lag.
    /// A fit is admitted whole up to `slack` above the best.
    pub(crate) fn form(&self, place: usize, level: f64, slack: f64) -> Option<FormProfiles> {
        let of_the_fit = self.fitted.led_by(place).first(level, true)?;
        let mut others = Vec::new();
        for member in self.others.iter().filter(|m| m.slow) {
            let left = level.min(level + slack - member.above);
            let led = member.fitted.led_by(place);
            let beyond = left > 0.0 && led.first_reaches_beyond(of_the_fit.interval, left);
            let further = match beyond {
                true => led.first(left, false),
                // It makes doubtful what it does not widen.
                false => led
                    .gain_of_first()
                    .map(|gain| Profile { gain, ..of_the_fit }),
            };
            others.extend(further.map(|f| (f, member.above, member.lag)));
        }
        Some(FormProfiles { of_the_fit, others })
    }
}

/// Profiles of the size of a form.
pub(crate) struct FormProfiles {
    of_the_fit: Profile,
    others: Vec<(Profile, f64, Option<f64>)>,
}

impl FormProfiles {
    /// One profile of all whose lag is no longer.
    pub(crate) fn up_to(&self, longest: f64) -> Profile {
        let mut profile = self.of_the_fit;
        for (further, above, lag) in &self.others {
            if lag.is_none_or(|l| l <= longest) {
                join(&mut profile, further, *above);
            }
        }
        profile
    }
}

impl Member {
    /// What is left of the level for its parameters. The best of some courses that chance brings is better than the true one by more
    /// than the rise of its own parameters tells.
    fn left(&self, level: f64) -> f64 {
        let slack = if self.slow { SLACK } else { 0.0 };
        level.min(level + slack - self.above)
    }
}

fn join(profile: &mut Profile, further: &Profile, above: f64) {
    profile.interval = (
        profile.interval.0.min(further.interval.0),
        profile.interval.1.max(further.interval.1),
    );
    profile.gain = profile.gain.min(further.gain + above);
}
