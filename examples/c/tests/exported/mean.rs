//! Mean of the last 8 samples, 1000.0 Hz, by proofmass 0.1.0.
//! Group delay at low frequency: 3.500000 samples, 3.500000e-3 s.

use proofmass_core::MovingAverage;

/// Designed off line; nothing is computed at start-up.
pub type Mean<T> = MovingAverage<T, 8>;

/// Number of the first step that this compiler computes otherwise than the desk did.
pub fn self_check() -> Option<usize> {
    const FIRST: [f64; 16] = [6.442176699638367e-1, 9.854497313499451e-1, 8.632093667984009e-1, 3.3498814702033997e-1, -3.5078322887420654e-1, -8.715757727622986e-1, -9.824526309967041e-1, -6.312666535377502e-1, 1.681390032172203e-2, 6.569865942001343e-1, 9.881682395935059e-1, 8.54598879814148e-1, 3.190983533859253e-1, -3.6647912859916687e-1, -8.796957731246948e-1, -9.79177713394165e-1];
    const SECOND: [f64; 16] = [0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0];
    const EXPECTED: [f64; 16] = [6.442176699638367e-1, 8.148337006568909e-1, 8.309589227040609e-1, 7.069662287831306e-1, 4.9541633725166323e-1, 2.6758431891600293e-1, 8.90076117856162e-2, -1.0266713798046112e-3, -7.945214258506894e-2, -1.2051003472879529e-1, -1.0489017562940717e-1, -3.993883403018117e-2, 4.379636375233531e-2, 1.0693344427272677e-1, 1.1977805150672793e-1, 7.628916902467608e-2];
    let mut state = Mean::<f64>::new();
    for step in 0..16 {
        let (first, _) = (FIRST[step], SECOND[step]);
        let result = state.step(first);
        let e = result - EXPECTED[step];
        if !(-7.105427357601002e-14..=7.105427357601002e-14).contains(&e) {
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
