//! Wedges that bend where nobody measured how they move: a part of the uncertainty beside the adjustment.
//!
//! The runs tell how the wedges differ along the excitation, and the adjustment takes that from them. What all of them have in common they do
//! not tell: it acts as the gain of the reference. As an unknown of each wedge in the adjustment it would take from the runs what they
//! tell of the motion across the excitation, so it stands beside it.

use super::{Effect, Evaluation, UNMEASURED_MOTION, symmetric};
use crate::adjustment::Adjustment;
use crate::matrix::row_times;
use crate::observation::{PhasorRow, SpuriousTable, bending};
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::{Covariance, DegreesOfFreedom, Influence, SharedEffect};

/// What it adds to the 18 reals of S of a frequency, V/(m/s²), where every wedge bends by its standard uncertainty at every frequency;
/// `None` where every motion was measured or stated.
fn effect(
    adjustment: &Adjustment,
    f: usize,
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
) -> Option<[f64; 18]> {
    let mut sum = [0.0; 18];
    let mut any = false;
    for (i, row) in rows.iter().enumerate() {
        let entry = spurious.get(row.configuration.inclination, row.frequency);
        let more = entry.map_or(0.0, |e| bending(e, 2));
        if more == 0.0 {
            continue;
        }
        any = true;
        let turned = row.configuration.matrix();
        let along = turned.map(|axis| Complex64::new(more * axis[2], 0.0));
        let change = row_times(along, &adjustment.sensitivity(adjustment.of_row[i]));
        let parts = change.map(|v| [v.re, v.im]);
        for (total, gain) in sum.iter_mut().zip(adjustment.gain(f, i)) {
            let of_row = gain.iter().zip(parts.as_flattened());
            *total += of_row.map(|(g, c)| g * c).sum::<f64>();
        }
    }
    any.then_some(sum)
}

/// The line of the budget at a frequency.
pub(super) fn influence(
    adjustment: &Adjustment,
    f: usize,
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
) -> Result<Option<Influence>, Error> {
    let Some(effect) = effect(adjustment, f, rows, spurious) else {
        return Ok(None);
    };
    let elements = (0..18 * 18).map(|k| effect[k / 18] * effect[k % 18]);
    Ok(Some(Influence {
        key: format!("{UNMEASURED_MOTION}.bending"),
        description: "bending of the wedges, which nobody measured".to_owned(),
        evaluation: Evaluation::B,
        distribution: "normal".to_owned(),
        dof: DegreesOfFreedom::INFINITE,
        effect: Effect::Joint {
            covariance: Covariance::try_from_rows(18, &symmetric(elements.collect()))?,
        },
    }))
}

/// The same error at all frequencies.
pub(super) fn shared(
    adjustment: &Adjustment,
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
) -> Option<SharedEffect> {
    let all = 0..adjustment.frequencies.len();
    let effects = all.map(|f| effect(adjustment, f, rows, spurious).map(|e| e.to_vec()));
    Some(SharedEffect {
        key: format!("{UNMEASURED_MOTION}.bending"),
        effects: effects.collect::<Option<_>>()?,
    })
}
