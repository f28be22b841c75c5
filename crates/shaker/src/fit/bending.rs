//! Wedges that bend where nobody measured how they move: a part of the uncertainty beside the adjustment.
//!
//! The runs tell how the wedges differ along the excitation, and the adjustment takes that from them. What all of them have in common they do
//! not tell: it acts as the gain of the reference. As an unknown of each wedge in the adjustment it would take from the runs what they
//! tell of the motion across the excitation, so it stands beside it.

use super::{Effect, Evaluation, Supported, UNMEASURED_MOTION, symmetric};
use crate::adjustment::Adjustment;
use crate::matrix::row_times;
use crate::observation::bending;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::{Covariance, DegreesOfFreedom, Influence, SharedEffect};
use rayon::prelude::*;

/// The error of every frequency by wedges that all bend by their standard uncertainty, V/(m/s²); `None` where every motion was
/// measured or stated.
pub(super) fn error(adjustment: &Adjustment, supported: &Supported) -> Option<SharedEffect> {
    let Supported { rows, spurious, .. } = supported;
    let changes: Vec<(usize, [f64; 6])> = (0..rows.len())
        .filter_map(|i| {
            let configuration = rows[i].configuration;
            let entry = spurious.get(configuration.inclination, rows[i].frequency)?;
            let more = bending(entry);
            let along = configuration.matrix();
            let along = along.map(|axis| Complex64::new(more * axis[2], 0.0));
            let change = row_times(along, &adjustment.sensitivity(adjustment.of_row[i]));
            let [x, y, z] = change.map(|v| [v.re, v.im]);
            (more > 0.0).then_some((i, [x[0], x[1], y[0], y[1], z[0], z[1]]))
        })
        .collect();
    let of = |f: usize| {
        let mut sum = vec![0.0; 18];
        for (i, change) in &changes {
            for (total, gain) in sum.iter_mut().zip(adjustment.gain(f, *i)) {
                let parts = gain.iter().zip(change);
                *total += parts.map(|(g, c)| g * c).sum::<f64>();
            }
        }
        sum
    };
    (!changes.is_empty()).then(|| SharedEffect {
        key: format!("{UNMEASURED_MOTION}.bending"),
        effects: (0..adjustment.frequencies.len())
            .into_par_iter()
            .map(of)
            .collect(),
    })
}

/// The line that it is in the budget of a frequency.
pub(super) fn influence(error: &SharedEffect, f: usize) -> Result<Influence, Error> {
    let effect = &error.effects[f];
    let elements = (0..18 * 18).map(|k| effect[k / 18] * effect[k % 18]);
    Ok(Influence {
        key: error.key.clone(),
        description: "bending of the wedges, which nobody measured".to_owned(),
        evaluation: Evaluation::B,
        distribution: "normal".to_owned(),
        dof: DegreesOfFreedom::INFINITE,
        effect: Effect::Joint {
            covariance: Covariance::try_from_rows(18, &symmetric(elements.collect()))?,
        },
    })
}
