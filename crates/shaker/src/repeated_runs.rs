//! Runs of one frequency: their mean, with the scatter of the runs in place of what is drawn anew in each.

use crate::derived::PROBABILITY;
use crate::findings;
use crate::observation::ascending;
use crate::single_axis::SingleAxis;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding, Influence,
    Repeats,
};

/// Positions of the runs of each frequency, in ascending frequency.
pub(crate) fn by_frequency(runs: &[SingleAxis]) -> Vec<Vec<usize>> {
    let of = |frequency: f64| {
        let all = 0..runs.len();
        all.filter(|&i| runs[i].frequency == frequency).collect()
    };
    ascending(runs.iter().map(|r| r.frequency))
        .into_iter()
        .map(of)
        .collect()
}

/// Where every frequency has one run alone.
pub(crate) fn unrepeated(groups: &[Vec<usize>]) -> Option<Finding> {
    let alone = !groups.is_empty() && groups.iter().all(|g| g.len() == 1);
    alone.then(|| findings::repeatability_unseen(groups.len()))
}

/// The mean of the complex sensitivities of repeats.
pub(crate) struct MeanOfRuns {
    pub(crate) result: SingleAxis,
    /// Departure of each run from the mean, along and across it: of the modulus, relative, and of the phase, rad.
    pub(crate) departures: Vec<[f64; 2]>,
}

impl MeanOfRuns {
    /// What the runs have in common stays, that of the first scaled to the mean; influences that are drawn anew in every run
    /// (`own`, by their keys) give way to `repeatability` and `repeatability.phase`. These are the scatter, never less than `noise`:
    /// the root mean square over the runs of what is told of it, for modulus and phase, with its degrees of freedom
    /// ([`Repeats::mean_of`]).
    ///
    /// # Errors
    /// As [`Estimate::new`].
    pub(crate) fn of(
        runs: &[&SingleAxis],
        own: &[&str],
        (noise, dof): ([f64; 2], DegreesOfFreedom),
    ) -> Result<Self, Error> {
        let first = runs[0];
        let sum: Complex64 = runs.iter().map(|r| r.sensitivity).sum();
        let mean = sum / runs.len() as f64;
        let departures: Vec<[f64; 2]> = runs
            .iter()
            .map(|r| {
                let d = r.sensitivity / mean - 1.0;
                [d.re, d.im]
            })
            .collect();
        let modulus = mean.norm();
        let of_one = first.estimate.components();
        // Where the clock is another's there is no phase.
        let size = of_one.len();
        let components = [
            Component::new("modulus", of_one[0].unit.clone(), modulus),
            Component::new("phase", "rad", mean.arg()),
        ];
        let components = components[..size].to_vec();
        let scale = modulus / first.sensitivity.norm();
        let jacobian = &[scale, 0.0, 0.0, 1.0][..size * size];
        let scaled = first.estimate.propagate(components.clone(), jacobian)?;
        let mut influences = scaled.influences().to_vec();
        influences.retain(|i| !own.contains(&i.key.as_str()));
        let parts = ["repeatability", "repeatability.phase"];
        for (part, key) in parts.into_iter().enumerate().take(size) {
            let along: Vec<f64> = departures.iter().map(|d| d[part]).collect();
            let declared = (noise[part] > 0.0).then_some((noise[part], dof));
            let scatter = Repeats::pool(&[&along])?.mean_of(runs.len(), declared, PROBABILITY);
            let u = scatter.standard_uncertainty * [modulus, 1.0][part];
            let mut rows = vec![0.0; size * size];
            rows[part * size + part] = u * u;
            influences.push(Influence {
                key: key.to_owned(),
                description: "scatter of the repeats, or the noise of their recordings".to_owned(),
                evaluation: Evaluation::A,
                distribution: "normal".to_owned(),
                dof: scatter.dof,
                effect: Effect::Joint {
                    covariance: Covariance::try_from_rows(size, &rows)?,
                },
            });
        }
        Ok(Self {
            result: SingleAxis {
                frequency: first.frequency,
                sensitivity: mean,
                estimate: Estimate::new(components, influences)?,
            },
            departures,
        })
    }
}
