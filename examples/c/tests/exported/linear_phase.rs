//! Low-pass of linear phase, 17 samples: gain within 1.00e-1 of one up to 20.0 Hz, below 3.00e-3 from 125.000000 Hz on, 1000.0 Hz, by proofmass 0.1.0.
//! Group delay at low frequency: 8.000000 samples, 8.000000e-3 s.

use proofmass_core::{FirDecimator, FirDecimatorState};

/// Designed off line; nothing is computed at start-up.
pub const LINEAR_PHASE_TAPS: [f32; 17] = [3.35041e-3, 1.2997531e-2, 2.7777778e-2, 4.5908436e-2, 6.5202676e-2, 8.3333336e-2, 9.811358e-2, 1.077607e-1, 1.1111111e-1, 1.077607e-1, 9.811358e-2, 8.3333336e-2, 6.5202676e-2, 4.5908436e-2, 2.7777778e-2, 1.2997531e-2, 3.35041e-3];

pub const LINEAR_PHASE: FirDecimator<f32, 1, 17> = FirDecimator::constant(LINEAR_PHASE_TAPS, 1);

/// Number of the first step that this compiler computes otherwise than the desk did.
pub fn self_check() -> Option<usize> {
    const FIRST: [f32; 16] = [6.4421767e-1, 9.8544973e-1, 8.6320937e-1, 3.3498815e-1, -3.5078323e-1, -8.715758e-1, -9.8245263e-1, -6.3126665e-1, 1.68139e-2, 6.569866e-1, 9.8816824e-1, 8.545989e-1, 3.1909835e-1, -3.6647913e-1, -8.796958e-1, -9.791777e-1];
    const SECOND: [f32; 16] = [0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0];
    const EXPECTED: [f32; 16] = [2.1583932e-3, 1.16749e-2, 3.3595454e-2, 6.929057e-2, 1.1440195e-1, 1.5939312e-1, 1.9262573e-1, 2.0468481e-1, 1.9205713e-1, 1.5852338e-1, 1.13640085e-1, 6.89949e-2, 3.3905048e-2, 1.2444193e-2, 3.0255236e-3, 5.571754e-4];
    let mut state = FirDecimatorState::at([0.0]);
    for step in 0..16 {
        let (first, _) = (FIRST[step], SECOND[step]);
        let result = LINEAR_PHASE.step(&mut state, [first]).map_or(0.0, |[v]| v);
        let e = result - EXPECTED[step];
        if !(-3.8146973e-5..=3.8146973e-5).contains(&e) {
            return Some(step);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    #[test]
    fn law_the_constant_computes_what_the_desk_computed() {
        assert_eq!(super::self_check(), None);
    }
}
