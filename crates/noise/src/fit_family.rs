//! Fits of one record that differ in what no column of the likelihood shows: a corner, a correlation time.

use crate::FitOptions;
use crate::cosine_spectrum::CosineSpectrum;
use crate::front_end::{Described, FrontEnd, divided};
use crate::markov::{Markov, times};
use crate::profile::{Fitted, Profile, square_level};
use crate::term_density::{Process, column};
use crate::variance_fit::Likelihood;

/// Where in the interval of a parameter it is varied, in half intervals from its best value.
pub(crate) const ACROSS: [f64; 6] = [-0.93, -0.7, -0.35, 0.35, 0.7, 0.93];

/// Correlation times per decade of a process that does not stand out.
const COARSE: f64 = 3.0;

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
    /// Other fits, with what their −2 ln L lies above the least of their kin.
    others: Vec<(Fitted, f64)>,
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
        self.others.push((fitted, above.max(0.0)));
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

    /// Interval of square j where −2 ln L, at its best over all else and all members, rises by `level`.
    pub(crate) fn square(&self, j: usize, level: f64) -> Profile {
        let mut profile = self.fitted.square(j, level);
        for (other, above) in &self.others {
            if *above < level {
                join(&mut profile, &other.square(j, level - above), *above);
            } else {
                profile.gain = profile.gain.min(above + other.gain(j));
            }
        }
        profile
    }
}

fn join(profile: &mut Profile, further: &Profile, above: f64) {
    profile.interval = (
        profile.interval.0.min(further.interval.0),
        profile.interval.1.max(further.interval.1),
    );
    profile.gain = profile.gain.min(further.gain + above);
}
