//! Outputs that live on a circle.

use super::Trial;
use crate::JointInputs;

/// The value counted half a period to either side of the estimate, for an output that lives on a circle.
pub(crate) fn nearest_turn(y: f64, circle: Option<(f64, f64)>) -> f64 {
    circle.map_or(y, |(centre, period)| {
        y - period * ((y - centre) / period).round()
    })
}

/// Estimate and period of the outputs that live on a circle.
pub(crate) fn circles<M: Trial>(model: &M, inputs: &JointInputs) -> Vec<Option<(f64, f64)>> {
    let m = model.names().len();
    let periods = model.circles();
    let mut centre = vec![0.0; m];
    if periods.iter().any(Option::is_some) {
        model.trial(&inputs.estimates(), &mut centre);
    }
    (0..m)
        .map(|k| {
            let period = periods.get(k).copied().flatten()?;
            (centre[k].is_finite() && period > 0.0).then_some((centre[k], period))
        })
        .collect()
}
