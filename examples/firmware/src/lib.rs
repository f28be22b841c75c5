//! A calibration as a constant of firmware: nothing is inverted, allocated or checked at start-up.
//!
//! ```text
//! cargo build -p proofmass-example-firmware --target thumbv7em-none-eabihf
//! ```
#![cfg_attr(not(test), no_std)]

use proofmass_core::{Matrix3, SensorModel};

/// Unit 0300, from `K`, its inverse and `b` of calibration.json.
pub const SENSOR: SensorModel<f32> = SensorModel::constant(
    Matrix3([[415.0, 1.25, 4.0], [0.0, 412.5, 8.75], [0.0, 0.0, 414.0]]),
    Matrix3([
        [2.40963855e-03, -7.30193501e-06, -2.31272036e-05],
        [0.0, 2.42424242e-03, -5.12370078e-05],
        [0.0, 0.0, 2.41545894e-03],
    ]),
    [33_120.0, 33_271.0, 32_366.0],
);

/// Acceleration, m/s², from one reading of the converter.
pub fn compensate(counts: [u16; 3]) -> [f32; 3] {
    SENSOR.apply(counts.map(f32::from))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The constant is the model it says it is: K⁻¹ K differs from the identity by the digits that were kept.
    #[test]
    fn law_the_constant_agrees_with_the_inverted_model() {
        let inverted = SensorModel::new(*SENSOR.k(), SENSOR.bias()).unwrap();
        for counts in [
            [33_120, 33_271, 36_436],
            [37_100, 33_000, 32_000],
            [0, 65_535, 32_366],
        ] {
            let a = compensate(counts);
            let b = inverted.apply(counts.map(f32::from));
            for axis in 0..3 {
                // Seven digits of elements of 2.4e-3 against 33 000 counts: 33 000 · 2.4e-10 · 3.
                assert!((a[axis] - b[axis]).abs() < 5e-4, "{a:?} {b:?}");
            }
        }
    }
}
