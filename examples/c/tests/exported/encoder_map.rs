//! Errors of an encoder, lines: 3, over a turn of 6.283185307179586 rad, from the zero of its readings, by proofmass 0.1.0.

use proofmass_core::encoder::ErrorLine;

/// Designed off line; nothing is computed at start-up.
pub const ENCODER_MAP: [ErrorLine<f32>; 3] = [
    ErrorLine { order: 1e0, cosine: 6e-3, sine: 8e-3 },
    ErrorLine { order: 2e0, cosine: -1e-3, sine: 4e-4 },
    ErrorLine { order: 3.7e-1, cosine: 2e-4, sine: 0e0 },
];

/// Way or angle of one turn, rad.
pub const ENCODER_MAP_TURN: f32 = 6.2831855e0;

/// What the encoder shows too much at a reading.
pub fn error(reading: f32) -> f32 {
    let turns = reading / ENCODER_MAP_TURN;
    ENCODER_MAP.iter().map(|line| line.at(turns)).sum()
}

/// Number of the first step that this compiler computes otherwise than the desk did.
pub fn self_check() -> Option<usize> {
    const FIRST: [f32; 16] = [4.047739e0, 6.1917634e0, 5.4237046e0, 2.1047926e0, -2.204036e0, -5.476272e0, -6.172932e0, -3.9663653e0, 1.0564485e-1, 4.1279683e0, 6.208844e0, 5.369603e0, 2.004954e0, -2.3026562e0, -5.527292e0, -6.152355e0];
    const SECOND: [f32; 16] = [0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0];
    const EXPECTED: [f32; 16] = [-9.355602e-3, 4.056625e-3, -2.4754964e-3, 4.106121e-3, -9.181109e-3, 1.0282306e-2, 5.824662e-3, 1.5033266e-3, 6.1161113e-3, -9.21453e-3, 4.208177e-3, -2.8822669e-3, 5.222181e-3, -9.32471e-3, 1.0102453e-2, 6.0001994e-3];
    for step in 0..16 {
        let (first, _) = (FIRST[step], SECOND[step]);
        let result = error(first);
        let e = result - EXPECTED[step];
        if !(-1.1901856e-6..=1.1901856e-6).contains(&e) {
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
