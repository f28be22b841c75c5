//! Butterworth low-pass of second order, -3.01 dB at 50.0 Hz, 1000.0 Hz, by proofmass 0.1.0.
//! Group delay at low frequency: 4.464497 samples, 4.464497e-3 s.

use proofmass_core::{Butterworth, LowPassState};

/// Designed off line; nothing is computed at start-up.
pub const LOW_PASS: Butterworth<f32> = Butterworth::constant([2.0083366e-2, 4.0166732e-2, 2.0083366e-2], [-1.5610181e0, 6.413515e-1]);

/// Number of the first step that this compiler computes otherwise than the desk did.
pub fn self_check() -> Option<usize> {
    const FIRST: [f32; 16] = [6.4421767e-1, 9.8544973e-1, 8.6320937e-1, 3.3498815e-1, -3.5078323e-1, -8.715758e-1, -9.8245263e-1, -6.3126665e-1, 1.68139e-2, 6.569866e-1, 9.8816824e-1, 8.545989e-1, 3.1909835e-1, -3.6647913e-1, -8.796958e-1, -9.791777e-1];
    const SECOND: [f32; 16] = [0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0];
    const EXPECTED: [f32; 16] = [1.2938059e-2, 6.586381e-2, 1.6437326e-1, 2.7553892e-1, 3.4844682e-1, 3.4234816e-1, 2.4915054e-1, 9.971893e-2, -4.8879236e-2, -1.3906436e-1, -1.3916078e-1, -5.7994142e-2, 5.930183e-2, 1.523861e-1, 1.7386518e-1, 1.1131381e-1];
    let mut state = LowPassState::at(0.0);
    for step in 0..16 {
        let (first, _) = (FIRST[step], SECOND[step]);
        let result = LOW_PASS.step(&mut state, first);
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
