//! First-order Gauss–Markov processes beside the power laws: sought over their correlation time.

use crate::cosine_spectrum::CosineSpectrum;
use crate::effects::Effects;
use crate::profile::{Fitted, square_level};
use crate::term_density::{Process, column};
use crate::variance_fit::Likelihood;
use crate::{FitOptions, FrontEnd};

/// Processes sought at most.
const MOST: usize = 3;

/// Correlation times tried per decade.
const PER_DECADE: f64 = 6.0;

/// A process found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Markov {
    /// Correlation time in s.
    pub(crate) time: f64,
    /// Its limits at the probability of the fit.
    pub(crate) interval: (f64, f64),
    /// Gain over the model without it.
    pub(crate) gain: f64,
}

/// Correlation times that a band can show: from a period of its highest frequency (two samples of the whole spectrum) to a fifth of the
/// record. What is correlated for less is white noise behind a front end.
pub(crate) fn times(highest: f64, record: f64, per_decade: f64) -> impl Iterator<Item = f64> {
    let (shortest, longest) = (1.0 / highest, 0.2 * record);
    let steps = ((longest / shortest).log10() * per_decade).floor().max(0.0) as usize;
    (0..=steps).map(move |i| shortest * 10_f64.powf(i as f64 / per_decade))
}

pub(crate) struct Search<'a> {
    pub(crate) spectrum: &'a CosineSpectrum,
    pub(crate) highest: f64,
    pub(crate) walk: Option<usize>,
    /// What shapes all processes alike.
    pub(crate) front_end: Option<FrontEnd>,
}

impl Search<'_> {
    /// The likelihood with the columns of the processes that chance does not explain, and the processes.
    ///
    /// A further process must gain what chance does at the false-alarm rate shared among all correlation times tried.
    /// The time's interval is where the likelihood, at its best over all squares, has not fallen further than that of a
    /// square may.
    pub(crate) fn add(
        &self,
        mut likelihood: Likelihood,
        held: &[Option<f64>],
        options: &FitOptions,
    ) -> (Likelihood, Vec<Markov>) {
        let mut held = held.to_vec();
        let mut found: Vec<Markov> = Vec::new();
        let tried: Vec<f64> = times(self.highest, self.spectrum.longest, PER_DECADE).collect();
        let (Some(&shortest), Some(&longest)) = (tried.first(), tried.last()) else {
            return (likelihood, found);
        };
        let count = tried.len();
        let needed = square_level(1.0 - options.false_alarm_rate / count as f64);
        while found.len() < MOST {
            let Some(before) = Fitted::new(likelihood.clone(), held.clone(), self.walk) else {
                break;
            };
            let mut free = held.clone();
            free.push(None);
            let value = |time: f64| -> f64 {
                let with = self.with(&likelihood, time);
                let crude = with.start();
                let mut near = before.best.squares.clone();
                let place = likelihood.columns.len();
                near.insert(place, crude[place]);
                with.minimise(&[&near, &crude], &free, Effects::Restricted)
                    .map_or(f64::INFINITY, |m| m.value)
            };
            let grid: Vec<(f64, f64)> = tried.iter().map(|t| (*t, value(*t))).collect();
            let Some(&(mut best, mut least)) = grid.iter().min_by(|a, b| a.1.total_cmp(&b.1))
            else {
                break;
            };
            let gain = before.best.value - least;
            if gain <= needed {
                break;
            }
            let mut step = 10_f64.powf(0.5 / PER_DECADE);
            for _ in 0..8 {
                for time in [best * step, best / step] {
                    let v = value(time);
                    if v < least {
                        (best, least) = (time, v);
                    }
                }
                step = step.sqrt();
            }
            let level = square_level(options.probability);
            let reach = |factor: f64| {
                let (mut inside, mut outside) = (best, best * factor);
                while outside > 0.1 * shortest && outside < 20.0 * longest {
                    if value(outside) - least > level {
                        break;
                    }
                    inside = outside;
                    outside *= factor;
                }
                for _ in 0..8 {
                    let middle = (inside * outside).sqrt();
                    if value(middle) - least > level {
                        outside = middle;
                    } else {
                        inside = middle;
                    }
                }
                outside
            };
            found.push(Markov {
                time: best,
                interval: (reach(1.0 / 1.3), reach(1.3)),
                gain: before.best.value - least,
            });
            likelihood = self.with(&likelihood, best);
            held.push(None);
        }
        (likelihood, found)
    }

    /// With one more column.
    fn with(&self, likelihood: &Likelihood, time: f64) -> Likelihood {
        let mut with = likelihood.clone();
        let whole = column(self.spectrum, Process::Markov(time), 1);
        let (frequencies, mut column): (Vec<f64>, Vec<f64>) = self
            .spectrum
            .bins
            .iter()
            .map(|b| b.frequency)
            .zip(whole)
            .filter(|(f, _)| *f <= self.highest)
            .unzip();
        // Behind a filter all columns are divided together.
        if let Some(shape @ FrontEnd::Overlap { .. }) = self.front_end {
            shape.apply(&mut column, &frequencies, self.spectrum.sample_rate);
        }
        with.columns.push(column);
        with
    }
}
