//! The search for runs that contradict the others.

use super::super::adjustment::Adjustment;
use super::super::budget::Budget;
use super::super::observation::{PhasorRow, SpuriousTable, ascending};
use super::super::robust::strangeness;
use super::trial::Trial;
use super::{SuspectRun, Suspicion, completeness};
use proofmass_core::Error;
use proofmass_uncertainty::chi_squared_chance;
use rayon::prelude::*;

/// Probability, over all runs of a frequency, of calling a good run suspect.
const FALSE_ALARM: f64 = 1e-4;
/// Median of χ² with six degrees of freedom: runs that scatter more than declared widen the alarm for all of them.
const MEDIAN: f64 = 5.348_121;
/// The same with five, where the phase of a run is free.
const MEDIAN_OF_FIVE: f64 = 4.351_460;

/// The runs of one frequency, and which of them agree.
struct Sorted<'a> {
    /// Indices of its rows in the campaign.
    all: Vec<usize>,
    here: Vec<PhasorRow>,
    kept: Vec<usize>,
    alarm: f64,
    trial: Option<Trial<'a>>,
}

/// Looks for runs that contradict the others, one at a time, each against a fit without those already found, and puts
/// every cause side by side: the run as that cause would have it is fitted together with the sound ones, and the
/// increase of χ² is its likelihood.
///
/// It begins with the runs that most others agree about, so that a wild one pulls no angle and stops no fit.
/// Nothing is removed from any result by this: the suspects are named.
///
/// # Errors
/// As [`crate::complex`].
pub fn suspects(
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
) -> Result<Vec<SuspectRun>, Error> {
    let frequencies = ascending(rows.iter().map(|r| r.frequency));
    let sorted: Vec<Sorted<'_>> = frequencies
        .par_iter()
        .map(|&frequency| sort(rows, frequency, spurious, budget))
        .collect::<Result<_, _>>()?;
    let trials: Vec<&Trial<'_>> = sorted.iter().filter_map(|s| s.trial.as_ref()).collect();
    let mut doubted: Vec<(usize, &PhasorRow, &Trial<'_>, f64)> = vec![];
    for s in &sorted {
        let Some(trial) = &s.trial else { continue };
        for i in (0..s.here.len()).filter(|i| !s.kept.contains(i)) {
            doubted.push((s.all[i], &s.here[i], trial, s.alarm));
        }
    }
    let mut result: Vec<SuspectRun> = doubted
        .par_iter()
        .filter_map(|(row, run, trial, alarm)| {
            let statistic = trial.increase(run);
            if chi_squared_chance(statistic, run.reals()) >= *alarm {
                return None;
            }
            let (suspicion, explained) = match completeness::twin(rows, *row) {
                Some(twin) => (
                    Suspicion::Copied {
                        run: rows[twin].run.clone(),
                    },
                    0.0,
                ),
                None => trial.explain(run, statistic, &trials),
            };
            Some(SuspectRun {
                row: *row,
                run: run.run.clone(),
                statistic,
                explained,
                suspicion,
            })
        })
        .collect();
    result.sort_by_key(|s| s.row);
    Ok(result)
}

/// The runs of each frequency that an adjustment of it would stumble over, at most three of each and the strangest first:
/// those that are far from what most others agree about at the nominal angles. None where all are near.
///
/// Unlike [`suspects`] it needs no adjustment to converge.
pub fn strangest(
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
) -> Vec<(String, f64)> {
    let frequencies = ascending(rows.iter().map(|r| r.frequency));
    let mut list = vec![];
    for frequency in frequencies {
        let here = rows.iter().filter(|r| r.frequency == frequency);
        let here: Vec<PhasorRow> = here.cloned().collect();
        let strange = strangeness(&here, spurious, budget);
        let mut order: Vec<usize> = (0..here.len()).filter(|&i| strange[i] > 0.05).collect();
        order.sort_by(|&a, &b| strange[b].total_cmp(&strange[a]));
        let three = order.into_iter().take(3);
        list.extend(three.map(|i| (here[i].run.clone(), frequency)));
    }
    list
}

/// Leaves out the worst run of a frequency until all others agree.
fn sort<'a>(
    rows: &[PhasorRow],
    frequency: f64,
    spurious: &'a SpuriousTable,
    budget: &'a Budget,
) -> Result<Sorted<'a>, Error> {
    let all: Vec<usize> = (0..rows.len())
        .filter(|&i| rows[i].frequency == frequency)
        .collect();
    let here: Vec<PhasorRow> = all.iter().map(|&i| rows[i].clone()).collect();
    let strange = strangeness(&here, spurious, budget);
    let mut kept: Vec<usize> = (0..here.len()).filter(|&i| strange[i] <= 1.0).collect();
    let subset =
        |kept: &[usize]| -> Vec<PhasorRow> { kept.iter().map(|&i| here[i].clone()).collect() };
    let most = here.len() / 3;
    let reals = here.first().map_or(6.0, PhasorRow::reals);
    let median = if reals < 6.0 { MEDIAN_OF_FIVE } else { MEDIAN };
    let alarm = FALSE_ALARM / here.len() as f64;
    let mut factor = 1.0f64;
    let mut sound = None;
    for _ in 0..=most {
        let adjustment = match Adjustment::new(&subset(&kept), spurious, budget) {
            // After a removal the rest may no longer span; what was found so far stands.
            Err(Error::TooFew { .. } | Error::Unobservable { .. }) if kept.len() < here.len() => {
                break;
            }
            // A run that is far off, though not wild, may turn the angles in circles: the strangest leaves first.
            Err(Error::NotConverged { .. }) => {
                let strange = strangeness(&subset(&kept), spurious, budget);
                let Some(worst) =
                    (0..kept.len()).max_by(|&a, &b| strange[a].total_cmp(&strange[b]))
                else {
                    break;
                };
                kept.remove(worst);
                continue;
            }
            other => other?,
        };
        let deletions = match adjustment.deletions() {
            // A plan of so few runs that none can be spared has nothing to compare with.
            Err(Error::Unobservable { .. }) => break,
            other => other?,
        };
        let mut statistics: Vec<f64> = deletions.iter().map(|d| d.statistic).collect();
        let worst = (0..statistics.len()).max_by(|&a, &b| statistics[a].total_cmp(&statistics[b]));
        let Some(worst) = worst else {
            break;
        };
        let largest = statistics[worst];
        statistics.sort_by(f64::total_cmp);
        factor = (statistics[statistics.len() / 2] / median).max(1.0);
        sound = Some((
            adjustment.chi_squared,
            adjustment.sensitivity(0),
            kept.clone(),
        ));
        if chi_squared_chance(largest / factor, reals) >= alarm {
            break;
        }
        kept.remove(worst);
    }
    let trial = match sound {
        None => None,
        Some((mut chi_squared, mut sensitivity, of)) => {
            if of != kept
                && let Ok(adjustment) = Adjustment::new(&subset(&kept), spurious, budget)
            {
                (chi_squared, sensitivity) = (adjustment.chi_squared, adjustment.sensitivity(0));
            }
            Some(Trial {
                frequency,
                sound: subset(&kept),
                chi_squared,
                sensitivity,
                factor,
                plan: here.iter().map(|r| r.configuration).collect(),
                spurious,
                budget,
            })
        }
    };
    Ok(Sorted {
        all,
        here,
        kept,
        alarm,
        trial,
    })
}
