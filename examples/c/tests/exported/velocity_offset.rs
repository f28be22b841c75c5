//! Velocity and offset of the accelerometer by a Kalman filter with its steady gain, sample time 0.001 s, no delay, by proofmass 0.1.0.

use proofmass_core::velocity::{KalmanState, SteadyKalman};

/// Designed off line; nothing is computed at start-up.
pub const VELOCITY_OFFSET: SteadyKalman<f32, 3> = SteadyKalman {
    f: [[1e0, 1e-3, -5e-7], [0e0, 1e0, -1e-3], [0e0, 0e0, 1e0]],
    g: [[4.1666667e-7, 6.6666666e-4, 0e0], [1.25e-7, 4.1666668e-4, 0e0], [-4.1666667e-8, -8.333333e-5, 0e0]],
    k: [4.4680327e-2, 1.0211078e0, -9.7740453e-1],
    component: 0,
    velocity_variance: 4.6211525e-8,
};

/// States to begin with: position and velocity are those of the start, the offset is that of the recording.
pub const VELOCITY_OFFSET_BEGIN: [f32; 3] = [0e0, 0e0, 1.92e-2];

/// Number of the first step that this compiler computes otherwise than the desk did.
pub fn self_check() -> Option<usize> {
    const FIRST: [f32; 16] = [2.2945267e-6, 5.0990144e-7, -1.5145383e-6, -2.826667e-6, -2.80937e-6, -1.4707824e-6, 5.595371e-7, 2.3266975e-6, 2.9995758e-6, 2.2617069e-6, 4.6012158e-7, -1.557866e-6, -2.8431648e-6, -2.7912788e-6, -1.4266108e-6, 6.090146e-7];
    const SECOND: [f32; 16] = [6.4421767e-1, 9.8544973e-1, 8.6320937e-1, 3.3498815e-1, -3.5078323e-1, -8.715758e-1, -9.8245263e-1, -6.3126665e-1, 1.68139e-2, 6.569866e-1, 9.8816824e-1, 8.545989e-1, 3.1909835e-1, -3.6647913e-1, -8.796958e-1, -9.791777e-1];
    const EXPECTED: [f32; 16] = [2.5149458e-4, 1.0720792e-3, 2.0118926e-3, 2.6181042e-3, 2.5942386e-3, 1.9396483e-3, 9.498523e-4, 7.758177e-5, -2.801139e-4, 3.14253e-5, 8.5176114e-4, 1.7808429e-3, 2.3671857e-3, 2.3202386e-3, 1.6470606e-3, 6.490271e-4];
    let mut state = KalmanState::new(VELOCITY_OFFSET_BEGIN, [0.0; 3], 0.0);
    for step in 0..16 {
        let (first, second) = (FIRST[step], SECOND[step]);
        let result = VELOCITY_OFFSET.step(&mut state, Some(first), second);
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
