//! Velocity by two channels, k1 = 0.1 rad/s, k2 = 40.0 rad/s, sample time 0.001 s, no delay, by proofmass 0.1.0.

use proofmass_core::velocity::{TwoChannel, TwoChannelState};

/// Designed off line; nothing is computed at start-up.
pub const TWO_CHANNEL: TwoChannel<f32> = TwoChannel::constant([4.01e1, 4e0, 5e-4, 9.8034316e-1]);

/// Number of the first step that this compiler computes otherwise than the desk did.
pub fn self_check() -> Option<usize> {
    const FIRST: [f32; 16] = [2.2945267e-6, 5.0990144e-7, -1.5145383e-6, -2.826667e-6, -2.80937e-6, -1.4707824e-6, 5.595371e-7, 2.3266975e-6, 2.9995758e-6, 2.2617069e-6, 4.6012158e-7, -1.557866e-6, -2.8431648e-6, -2.7912788e-6, -1.4266108e-6, 6.090146e-7];
    const SECOND: [f32; 16] = [6.4421767e-1, 9.8544973e-1, 8.6320937e-1, 3.3498815e-1, -3.5078323e-1, -8.715758e-1, -9.8245263e-1, -6.3126665e-1, 1.68139e-2, 6.569866e-1, 9.8816824e-1, 8.545989e-1, 3.1909835e-1, -3.6647913e-1, -8.796958e-1, -9.791777e-1];
    const EXPECTED: [f32; 16] = [4.059836e-4, 1.1186874e-3, 1.9012778e-3, 2.3622536e-3, 2.2622931e-3, 1.6267754e-3, 7.338075e-4, -1.6604046e-5, -2.907169e-4, 2.1953292e-5, 7.566406e-4, 1.5507925e-3, 2.0145564e-3, 1.914108e-3, 1.2815966e-3, 4.0000098e-4];
    let mut state = TwoChannelState::new(0.0, 0.0, 0.0);
    for step in 0..16 {
        let (first, second) = (FIRST[step], SECOND[step]);
        let result = TWO_CHANNEL.step(&mut state, first, second);
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
