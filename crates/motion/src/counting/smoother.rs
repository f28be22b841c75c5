//! The smoother of a counted axis.

use super::Read;
use proofmass_core::state_space::Adjoint;
use proofmass_core::velocity::{CountingKalman, CountingState};

/// Velocity and standard uncertainty from all counts: [`Adjoint`] goes back over the steps and what was read in each.
///
/// `steps` are the states before what was read, and how many readings were before. A cell's frame moves with the count, which the adjoint does not feel.
pub(super) fn smooth<const N: usize>(
    steps: &[(CountingState<f64, N>, usize)],
    read: &[Read<N>],
    unit: f64,
) -> (Vec<f64>, Vec<f64>) {
    let f = CountingKalman::<f64, N>::transition();
    let (mut v, mut u) = (vec![0.0; steps.len()], vec![0.0; steps.len()]);
    let mut after = Adjoint::<f64, N>::default();
    let mut last = read.len();
    for (k, (predicted, first)) in steps.iter().enumerate().rev() {
        for (gain, innovation) in read[*first..last].iter().rev() {
            after.update(gain, &[*innovation]);
        }
        last = *first;
        v[k] = after.value(0, 1, &predicted.x, &predicted.p) * unit;
        u[k] = after.variance(1, &predicted.p).sqrt() * unit;
        after.predict(&f, 1);
    }
    (v, u)
}
