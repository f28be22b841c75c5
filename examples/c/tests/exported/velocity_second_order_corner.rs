//! Velocity, with the low corner of second order of the accelerometer, two stages at 0.5 Hz, as states, by a Kalman filter with its steady gain, sample time 0.001 s, no delay; states: position, velocity, what the accelerometer has shown of the velocity, the same between the stages, its offset, by proofmass 0.1.0.

use proofmass_core::velocity::{KalmanState, SteadyKalman};

/// Designed off line; nothing is computed at start-up.
pub const VELOCITY_SECOND_ORDER_CORNER: SteadyKalman<f32, 5> = SteadyKalman {
    f: [[1e0, 1e-3, 1.5724413e-6, 1.5707964e-6, -5.010476e-7], [0e0, 1e0, 3.1465276e-3, 3.1415927e-3, -1.0031433e-3], [0e0, 0e0, 1e0, 0e0, -1e-3], [0e0, 0e0, 3.1415927e-3, 1e0, -1.0015708e-3], [0e0, 0e0, 0e0, 0e0, 1e0]],
    g: [[4.1760953e-7, 6.692861e-4, 6.6666666e-4, 6.679757e-4, 0e0], [1.2518332e-7, 4.1745236e-4, 4.1666668e-4, 4.1705937e-4, 0e0], [-4.1745235e-8, -8.359526e-5, -8.333333e-5, -8.3464234e-5, 0e0]],
    k: [5.0456673e-2, 1.3061033e0, 1.0178373e0, 1.1571928e0, -9.7444516e-1],
    component: 0,
    velocity_variance: 6.049356e-8,
};

/// Number of the first step that this compiler computes otherwise than the desk did.
pub fn self_check() -> Option<usize> {
    const FIRST: [f32; 16] = [2.2945267e-6, 5.0990144e-7, -1.5145383e-6, -2.826667e-6, -2.80937e-6, -1.4707824e-6, 5.595371e-7, 2.3266975e-6, 2.9995758e-6, 2.2617069e-6, 4.6012158e-7, -1.557866e-6, -2.8431648e-6, -2.7912788e-6, -1.4266108e-6, 6.090146e-7];
    const SECOND: [f32; 16] = [6.4421767e-1, 9.8544973e-1, 8.6320937e-1, 3.3498815e-1, -3.5078323e-1, -8.715758e-1, -9.8245263e-1, -6.3126665e-1, 1.68139e-2, 6.569866e-1, 9.8816824e-1, 8.545989e-1, 3.1909835e-1, -3.6647913e-1, -8.796958e-1, -9.791777e-1];
    const EXPECTED: [f32; 16] = [2.7182174e-4, 1.1156182e-3, 2.0834734e-3, 2.721868e-3, 2.7314927e-3, 2.108049e-3, 1.144302e-3, 2.9241713e-4, -4.8668997e-5, 2.7915245e-4, 1.1188299e-3, 2.0720428e-3, 2.686564e-3, 2.668976e-3, 2.0226948e-3, 1.0463875e-3];
    let mut state = KalmanState::new([0.0; 5], [0.0; 5], 0.0);
    for step in 0..16 {
        let (first, second) = (FIRST[step], SECOND[step]);
        let result = VELOCITY_SECOND_ORDER_CORNER.step(&mut state, Some(first), second);
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
