pub mod calibration {
//! Calibration of example by proofmass 0.1.0.
//! Input: count; output: m/s^2.

use proofmass_core::{Matrix3, SensorModel};

/// Compensation of the sensor; K, its inverse and b, nothing is computed at start-up.
pub const CHAIN: SensorModel<f64> = SensorModel::constant(
    Matrix3([[-1.515082050492162e2, 3.290223244042585e2, 2.0256390682049837e2], [-3.62463874948649e2, -1.9218746833942004e2, 4.378046220055935e1], [1.1972867950784968e2, -1.6289129410593992e2, 3.6128628829198436e2]]),
    Matrix3([[-8.791010302968901e-4, -2.1428511120485305e-3, 7.525587328119003e-4], [1.9217165487482857e-3, -1.1145595225492489e-3, -9.423952469340655e-4], [1.1577646719429229e-3, 2.07615659581112e-4, 2.0936005042202295e-3]]),
    [3.312e4, 3.3271e4, 3.2366e4],
);

/// Number of the first vector that this compiler computes otherwise than the desk did.
pub fn self_check() -> Option<usize> {
    const OUTPUTS: [[f64; 3]; 8] = [
        [3.312e4, 3.3271e4, 3.2366e4],
        [3.1634e4, 2.9716e4, 3.354e4],
        [3.4606e4, 3.6826e4, 3.1192e4],
        [3.6347e4, 3.1386e4, 3.0769e4],
        [2.9893e4, 3.5156e4, 3.3963e4],
        [3.5106e4, 3.37e4, 3.5909e4],
        [3.1134e4, 3.2842e4, 2.8823e4],
        [3.1633e4, 3.2882e4, 3.6037e4]
    ];
    const TEMPERATURES: [f64; 8] = [0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0];
    const EXPECTED: [[f64; 3]; 8] = [
        [0e0, 0e0, 0e0],
        [9.807683786674875e0, 2.162913220342677e-4, -6.249803634870155e-4],
        [-9.807683786674875e0, -2.162913220342677e-4, 6.249803634870155e-4],
        [5.790251428108295e-4, 9.807329212169755e0, 1.2710728097093948e-3],
        [-5.790251428108295e-4, -9.807329212169755e0, -1.2710728097093948e-3],
        [1.1378171141198656e-3, -5.233292469259965e-4, 9.806014342891215e0],
        [-1.1378171141198656e-3, 5.233292469259965e-4, -9.806014342891215e0],
        [4.9034354227908405e0, -5.883561805211997e0, 5.883248892236284e0]
    ];
    for vector in 0..8 {
        let (output, _) = (OUTPUTS[vector], TEMPERATURES[vector]);
        let a = CHAIN.apply(output);
        for axis in 0..3 {
            let e = a[axis] - EXPECTED[vector][axis];
            if !(-1.7473320014573468e-12..=1.7473320014573468e-12).contains(&e) {
                return Some(vector);
            }
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
}

pub mod low_pass {
//! Butterworth low-pass of second order, -3.01 dB at 10.0 Hz, 1000.0 Hz, by proofmass 0.1.0.
//! Group delay at low frequency: 22.500503 samples, 2.250050e-2 s.

use proofmass_core::{Butterworth, LowPassState};

/// Designed off line; nothing is computed at start-up.
pub const CHAIN_LOW_PASS: Butterworth<f64> = Butterworth::constant([9.446918438401507e-4, 1.8893836876803015e-3, 9.446918438401507e-4], [-1.9111970674260732e0, 9.149758348014337e-1]);

/// Number of the first step that this compiler computes otherwise than the desk did.
pub fn self_check() -> Option<usize> {
    const FIRST: [f64; 16] = [6.442176699638367e-1, 9.854497313499451e-1, 8.632093667984009e-1, 3.3498814702033997e-1, -3.5078322887420654e-1, -8.715757727622986e-1, -9.824526309967041e-1, -6.312666535377502e-1, 1.681390032172203e-2, 6.569865942001343e-1, 9.881682395935059e-1, 8.54598879814148e-1, 3.190983533859253e-1, -3.6647912859916687e-1, -8.796957731246948e-1, -9.79177713394165e-1];
    const SECOND: [f64; 16] = [0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0, 0e0];
    const EXPECTED: [f64; 16] = [6.085871784725426e-4, 3.3112507114356773e-3, 9.057556761790935e-3, 1.715940212792308e-2, 2.5624559399904254e-2, 3.210347042840157e-2, 3.5003967818244726e-2, 3.424962802962972e-2, 3.1325068024065594e-2, 2.8586861473629335e-2, 2.816414373467397e-2, 3.096595289222863e-2, 3.626215670372348e-2, 4.203505092415536e-2, 4.593625745610597e-2, 4.6398870841287077e-2];
    let mut state = LowPassState::at(0.0);
    for step in 0..16 {
        let (first, _) = (FIRST[step], SECOND[step]);
        let result = CHAIN_LOW_PASS.step(&mut state, first);
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
}

use proofmass_core::{Decimator, DecimatorState};

/// Low-pass, and one result for 5 samples.
pub const DECIMATOR: Decimator<f64, 3> = Decimator::constant(low_pass::CHAIN_LOW_PASS, 5);

/// One sample: an acceleration in m/s² where one is due. The state is `None` before the first sample and after a gap.
pub fn step(state: &mut Option<DecimatorState<f64, 3>>, output: [f64; 3]) -> Option<[f64; 3]> {
    let a = calibration::CHAIN.apply(output);
    let state = state.get_or_insert(DecimatorState::at(a, 0));
    DECIMATOR.step(state, a)
}
