//! Velocity by a Kalman filter with its steady gain, sample time 0.001 s, no delay, by proofmass 0.1.0.

use proofmass_core::velocity::{KalmanState, SteadyKalman};

/// Designed off line; nothing is computed at start-up.
pub const VELOCITY: SteadyKalman<f32, 2> = SteadyKalman {
    f: [[1e0, 1e-3], [0e0, 1e0]],
    g: [[4.1666667e-7, 6.6666666e-4], [1.25e-7, 4.1666668e-4], [-4.1666667e-8, -8.333333e-5]],
    k: [4.373521e-2, 9.778879e-1],
    component: 0,
    velocity_variance: 4.4224155e-8,
};

/// Number of the first step that this compiler computes otherwise than the desk did.
pub fn self_check() -> Option<usize> {
    const FIRST: [f32; 16] = [2.2945267e-6, 5.0990144e-7, -1.5145383e-6, -2.826667e-6, -2.80937e-6, -1.4707824e-6, 5.595371e-7, 2.3266975e-6, 2.9995758e-6, 2.2617069e-6, 4.6012158e-7, -1.557866e-6, -2.8431648e-6, -2.7912788e-6, -1.4266108e-6, 6.090146e-7];
    const SECOND: [f32; 16] = [6.4421767e-1, 9.8544973e-1, 8.6320937e-1, 3.3498815e-1, -3.5078323e-1, -8.715758e-1, -9.8245263e-1, -6.3126665e-1, 1.68139e-2, 6.569866e-1, 9.8816824e-1, 8.545989e-1, 3.1909835e-1, -3.6647913e-1, -8.796958e-1, -9.791777e-1];
    const EXPECTED: [f32; 16] = [2.7058908e-4, 1.1103492e-3, 2.069447e-3, 2.6950322e-3, 2.690563e-3, 2.0552997e-3, 1.0846788e-3, 2.313893e-4, -1.07509484e-4, 2.226924e-4, 1.0616162e-3, 2.0092456e-3, 2.6140823e-3, 2.5855144e-3, 1.9305159e-3, 9.50387e-4];
    let mut state = KalmanState::new([0.0; 2], [0.0; 2], 0.0);
    for step in 0..16 {
        let (first, second) = (FIRST[step], SECOND[step]);
        let result = VELOCITY.step(&mut state, Some(first), second);
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
