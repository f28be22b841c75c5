//! The threshold of the standstill search, chosen by what the fit makes of it.

use crate::hold::Holds;
use crate::{MultiPosition, Pose, Samples, Segment, Standstill, WindowedVariance};
use proofmass_core::{Error, Watch};
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::sync::{Mutex, PoisonError};

/// One threshold of a sweep and what came of it.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct Candidate {
    /// Largest windowed variance of a standstill, in multiples of the noise floor.
    pub threshold: f64,
    /// Standstills found, each hold of the sensor once.
    pub standstills: usize,
    /// Pieces beyond one for each of them: how often the search cut a hold.
    pub fragments: usize,
    /// Samples in them.
    pub samples: usize,
    /// Root mean square residual per degree of freedom, in units of g; `None` where the fit failed.
    pub residual: Option<f64>,
    /// Typical half-width of the parameters' 95 % intervals in natural units.
    pub figure: Option<f64>,
}

/// Standstills found at the threshold that determines the parameters best.
///
/// A strict threshold breaks standstills up and loses them; a loose one lets motion in and the residual grows.
/// Each threshold of the ladder is fitted, weighted by the number of samples, and its figure is the typical
/// half-width of the parameters' intervals: t₀.₉₇₅(ν) · s · √(tr C/p), with s² the residual variance per degree
/// of freedom and C the cofactor matrix. (The residual alone would favour thresholds that leave few
/// standstills.) The residual itself scatters by 1/√(2ν), so thresholds within twice that of the smallest
/// figure are alike. Of those the one that cuts fewest standstills into pieces is taken, and among equals the strictest: it
/// lets the least motion in. A rest that is hardly longer than the window is lost or loses most of its samples: half and a quarter of the
/// window are tried too, and the longest is taken whose figure is within 15 % of the best. Pieces of one hold of the sensor are one standstill at every threshold, so that ν counts attitudes.
///
/// **Source** after `[Tedaldi2014]` III-C, with the figure above in place of the residual norm.
#[doc(alias("static detector"))]
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct ThresholdSweep {
    /// The standstills of the chosen threshold.
    pub segments: Vec<Segment>,
    /// The chosen threshold, in multiples of the noise floor; `None` when the standstills were given.
    pub threshold: Option<f64>,
    /// Length of the window, s; `None` when the standstills were given.
    pub window: Option<f64>,
    /// The thresholds that were tried with this window; empty when the threshold or the standstills were given.
    pub candidates: Vec<Candidate>,
    /// Standstills that were left out on request.
    pub excluded: Vec<String>,
}

impl ThresholdSweep {
    /// Searches a recording for the standstills that `fit` makes the most of.
    ///
    /// `rate` in Hz; `breaks` are samples before which time jumps.
    ///
    /// # Errors
    /// Those of [`WindowedVariance::new`]; else the error of the fit at the threshold that found most
    /// standstills, when no threshold led to a fit; [`Error::Cancelled`].
    pub fn run(
        samples: &Samples<'_>,
        rate: f64,
        breaks: &[usize],
        search: &Standstill,
        fit: &MultiPosition,
        watch: &dyn Watch,
    ) -> Result<Self, Error> {
        if let Some(threshold) = search.threshold {
            proofmass_core::check::positive("threshold", threshold)?;
            let windowed = WindowedVariance::new(samples, rate, breaks, search)?;
            return Ok(Self {
                segments: windowed.holds(samples, threshold),
                threshold: Some(threshold),
                window: Some(search.window),
                candidates: Vec::new(),
                excluded: Vec::new(),
            });
        }
        let mut found: Vec<(f64, Self)> = Vec::new();
        let mut refused = None;
        let all = WindowedVariance::ladder().count() as u64;
        let windows = search.windows(rate).count() as u64;
        for (number, search) in (0..).zip(search.windows(rate)) {
            let done = Mutex::new(number * all);
            let told = || {
                let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
                *done += 1;
                watch.step("standstills", *done, windows * all)
            };
            match Self::with_window(samples, rate, breaks, &search, fit, &told) {
                Ok(sweep) => found.push(sweep),
                Err(cancelled @ Error::Cancelled { .. }) => return Err(cancelled),
                Err(error) => refused = refused.or(Some(error)),
            }
        }
        let best = found
            .iter()
            .map(|(figure, _)| *figure)
            .fold(f64::INFINITY, f64::min);
        match found
            .into_iter()
            .find(|(figure, _)| *figure <= ALIKE * best)
        {
            Some((_, sweep)) => Ok(sweep),
            None => Err(refused.unwrap_or(NOTHING)),
        }
    }

    /// The best threshold for one window, and its figure.
    fn with_window(
        samples: &Samples<'_>,
        rate: f64,
        breaks: &[usize],
        search: &Standstill,
        fit: &MultiPosition,
        told: &(dyn Fn() -> Result<(), Error> + Sync),
    ) -> Result<(f64, Self), Error> {
        let windowed = WindowedVariance::new(samples, rate, breaks, search)?;
        let thresholds: Vec<f64> = WindowedVariance::ladder().collect();
        let tried: Vec<(Candidate, Vec<Segment>, Option<Error>)> = thresholds
            .into_par_iter()
            .map(|threshold| {
                let tried = try_threshold(samples, &windowed, threshold, fit);
                told().map(|()| tried)
            })
            .collect::<Result<_, _>>()?;
        let figures = || tried.iter().filter_map(|(c, ..)| Some((c, c.figure?)));
        let limit = figures()
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(c, figure)| {
                let freedom = c.standstills.saturating_sub(fit.parameters()).max(1) as f64;
                figure * (1.0 + 2.0 / (2.0 * freedom).sqrt())
            });
        let alike = tried.iter().filter_map(|(c, segments, _)| {
            let figure = c.figure.filter(|f| limit.is_some_and(|l| *f <= l))?;
            Some((c, segments, figure))
        });
        let best = alike.min_by(|a, b| {
            let by_fragments = a.0.fragments.cmp(&b.0.fragments);
            let by_number = b.0.standstills.cmp(&a.0.standstills);
            let by_threshold = a.0.threshold.total_cmp(&b.0.threshold);
            by_fragments.then(by_number).then(by_threshold)
        });
        let Some((candidate, segments, figure)) = best else {
            let most = tried.iter().max_by_key(|(c, ..)| c.standstills);
            return Err(most.and_then(|(.., error)| *error).unwrap_or(NOTHING));
        };
        let sweep = Self {
            segments: segments.clone(),
            threshold: Some(candidate.threshold),
            window: Some(search.window),
            candidates: tried.iter().map(|(c, ..)| c.clone()).collect(),
            excluded: Vec::new(),
        };
        // What the choice of the window is made by knows the design and not the residual: of windows that find other rests the one
        // whose rests happen to scatter little would be taken else.
        Ok((figure / candidate.residual.unwrap_or(1.0), sweep))
    }
}

/// No standstill at any threshold.
const NOTHING: Error = Error::TooFew {
    name: "standstills",
    needed: 1,
    got: 0,
};

/// Figures of two windows up to this ratio are alike: nearly the same samples are behind both.
const ALIKE: f64 = 1.15;

impl ThresholdSweep {
    /// Standstills that were given.
    pub fn given(segments: Vec<Segment>) -> Self {
        Self {
            segments,
            threshold: None,
            window: None,
            candidates: Vec::new(),
            excluded: Vec::new(),
        }
    }

    /// Leaves standstills out by label, or by number counted from one. The others keep their names.
    ///
    /// # Errors
    /// The name that no standstill has.
    pub fn exclude<'a>(&mut self, names: &'a [String]) -> Result<(), &'a str> {
        let named: Vec<(String, Segment)> = std::mem::take(&mut self.segments)
            .into_iter()
            .enumerate()
            .map(|(index, segment)| {
                let name = segment.label.clone();
                (name.unwrap_or_else(|| (index + 1).to_string()), segment)
            })
            .collect();
        if let Some(unknown) = names
            .iter()
            .find(|n| named.iter().all(|(name, _)| name != *n))
        {
            return Err(unknown);
        }
        self.segments = named
            .into_iter()
            .filter(|(name, _)| !names.contains(name))
            .map(|(name, mut segment)| {
                if !names.is_empty() {
                    segment.label = Some(name);
                }
                segment
            })
            .collect();
        self.excluded = names.to_vec();
        Ok(())
    }

    /// The most standstills that any threshold finds: what there is when no fit could be made.
    pub fn most(samples: &Samples<'_>, windowed: &WindowedVariance) -> Vec<Segment> {
        let mut most = Vec::new();
        for threshold in WindowedVariance::ladder() {
            let found = windowed.holds(samples, threshold);
            if found.len() > most.len() {
                most = found;
            }
        }
        most
    }
}

fn try_threshold(
    samples: &Samples<'_>,
    windowed: &WindowedVariance,
    threshold: f64,
    fit: &MultiPosition,
) -> (Candidate, Vec<Segment>, Option<Error>) {
    let Holds { segments, cuts } = Holds::of(samples, windowed, threshold);
    let poses: Vec<Pose> = segments
        .iter()
        .map(|segment| Pose {
            temperature: samples.mean_temperature(segment.start, segment.end),
            ..Pose::reading(segment.clone(), samples.mean(segment.start, segment.end))
        })
        .collect();
    let mut candidate = Candidate {
        threshold,
        standstills: segments.len(),
        fragments: cuts,
        samples: segments.iter().map(Segment::len).sum(),
        residual: None,
        figure: None,
    };
    // One residual at least must judge.
    let needed = fit.parameters() + 1;
    if poses.len() < needed {
        let error = Error::TooFew {
            name: "standstills",
            needed,
            got: poses.len(),
        };
        return (candidate, segments, Some(error));
    }
    let error = match fit.relative_quality(&poses) {
        Ok((sum_of_squares, spread)) => {
            let freedom = (poses.len() - fit.parameters()) as f64;
            let residual = (sum_of_squares / freedom).sqrt();
            let t = StudentsT::new(0.0, 1.0, freedom).map_or(f64::MAX, |d| d.inverse_cdf(0.975));
            candidate.residual = Some(residual);
            candidate.figure = Some(t * residual * spread.sqrt());
            None
        }
        Err(error) => Some(error),
    };
    (candidate, segments, error)
}
