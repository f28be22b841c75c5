//! Bias of an accelerometer in m/s^2, three axes, 100.0 Hz, by proofmass 0.1.0.

use proofmass_core::{BiasFilter, BiasState};

/// Designed off line; nothing is computed at start-up.
pub const BIAS: [BiasFilter<f32>; 3] = [
    BiasFilter::constant(9.999667e-1, 2.6665778e-10, 4e-4),
    BiasFilter::constant(9.999667e-1, 2.6665778e-10, 4e-4),
    BiasFilter::constant(9.999667e-1, 2.6665778e-10, 4e-4),
];

/// Bias and variance at the end of the recording.
pub const BIAS_STATE: [BiasState<f32>; 3] = [
    BiasState::known(2e-2, 4e-6),
    BiasState::known(-1e-2, 4e-6),
    BiasState::known(3e-2, 4e-6),
];

/// Number of the first step that this compiler computes otherwise than the desk did.
pub fn self_check() -> Option<usize> {
    const FIRST: [f32; 16] = [7.897691e-1, 9.837021e-1, 4.3601197e-1, -4.3917057e-1, -9.81038e-1, -7.8148025e-1, 6.989374e-3, 7.873552e-1, 9.7005796e-1, 4.1868836e-1, -4.4765422e-1, -9.7239023e-1, -7.587926e-1, 2.9958256e-2, 7.949875e-1, 9.55866e-1];
    const SECOND: [f32; 16] = [7.833269e-1, 9.738476e-1, 4.2737988e-1, -4.4252044e-1, -9.775301e-1, -7.727645e-1, 1.68139e-2, 7.9366785e-1, 9.698898e-1, 4.121185e-1, -4.575359e-1, -9.809362e-1, -7.619836e-1, 3.3623047e-2, 8.0378443e-1, 9.656578e-1];
    const EXPECTED: [f32; 16] = [1.9865103e-2, 1.9766305e-2, 1.9657552e-2, 1.9500097e-2, 1.928033e-2, 1.9015577e-2, 1.8745411e-2, 1.8512769e-2, 1.8343855e-2, 1.823621e-2, 1.816034e-2, 1.8073894e-2, 1.7941585e-2, 1.7751452e-2, 1.7519994e-2, 1.7283952e-2];
    let mut state = BIAS_STATE[0];
    for step in 0..16 {
        let (first, second) = (FIRST[step], SECOND[step]);
        let result = {
            BIAS[0].predict(&mut state);
            BIAS[0].update(&mut state, first, second);
            state.bias()
        };
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
