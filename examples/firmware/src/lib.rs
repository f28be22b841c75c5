//! What firmware does with a calibration: read, compensate, take the bias out, integrate to velocity.
//!
//! The calibration is a constant as `proofmass export --rust` writes it: nothing is inverted, allocated or checked at start-up. The
//! same functions run on the desk; `examples/qemu` runs them on an emulated Cortex-M4 and CI compares the bits.
//!
//! ```text
//! cargo build -p proofmass-example-firmware --target thumbv7em-none-eabihf
//! ```
#![cfg_attr(not(test), no_std)]

pub mod drive;

use proofmass_core::velocity::{
    BiasModel, Hold, Integrator, IntegratorRule, IntegratorState, Kalman, KalmanState, MotionNoise,
    ProcessNoise,
};
use proofmass_core::{
    BiasFilter, BiasState, Butterworth, Compensation, Error, FirDecimator, FirDecimatorState,
    LowPassState, Matrix3, SensorModel, ThermalTerms,
};

/// Unit 0300, from calibration.json: K, its inverse, b and the temperature.
pub const SENSOR: Compensation<f32> = Compensation::constant(
    SensorModel::constant(
        Matrix3([[415.0, 1.25, 4.0], [0.0, 412.5, 8.75], [0.0, 0.0, 414.0]]),
        Matrix3([
            [2.409_638_5e-3, -7.301_935e-6, -2.312_720_4e-5],
            [0.0, 2.424_242_4e-3, -5.123_701e-5],
            [0.0, 0.0, 2.415_459e-3],
        ]),
        [33_120.0, 33_271.0, 32_366.0],
    ),
    Some(ThermalTerms {
        reference: 25.0,
        range: [-40.0, 85.0],
        bias: [
            [0.41, -1.1e-3, 2e-6],
            [-0.22, 3e-4, 0.0],
            [0.13, 0.0, -1e-6],
        ],
        scale: [[2e-4, 0.0, 0.0], [-1e-4, 0.0, 0.0], [3e-4, 0.0, 0.0]],
    }),
    None,
);

/// Samples per second.
pub const RATE: f64 = 1000.0;

/// Acceleration, m/s², from one reading of the converter and of the thermometer.
pub fn compensate(counts: [u16; 3], temperature: f32) -> [f32; 3] {
    SENSOR.apply(counts.map(f32::from), temperature)
}

/// Everything behind the converter for the axis of motion, x.
#[derive(Clone, Copy, Debug)]
pub struct Pipeline {
    filter: BiasFilter<f32>,
    bias: BiasState<f32>,
    low_pass: Butterworth<f32>,
    smooth: LowPassState<f32>,
    integrator: Integrator<f32>,
    motion: IntegratorState<f32>,
}

impl Pipeline {
    /// The bias as `proofmass noise` found it; a corner of 100 Hz against noise.
    ///
    /// # Errors
    /// None for these numbers.
    pub fn new() -> Result<Self, Error> {
        let model = BiasModel::GaussMarkov {
            deviation: 5e-3,
            time: 300.0,
        };
        let (filter, bias) = BiasFilter::new(model, 4e-4, 1.0 / RATE)?;
        Ok(Self {
            filter,
            bias,
            low_pass: Butterworth::new(100.0, RATE)?,
            smooth: LowPassState::at(0.0),
            integrator: Integrator::new(IntegratorRule::Trapezoid, 1.0 / RATE)?,
            motion: IntegratorState::new(0.0),
        })
    }

    /// One sample: velocity along x in m/s. While the machine is known to stand, the bias is learnt and velocity is zero.
    pub fn step(&mut self, counts: [u16; 3], temperature: f32, stands: bool) -> f32 {
        let a = compensate(counts, temperature)[0];
        self.filter.predict(&mut self.bias);
        if stands {
            self.filter.update(&mut self.bias, a, 0.0);
        }
        let a = self
            .low_pass
            .step(&mut self.smooth, self.filter.correct(&self.bias, a));
        if stands {
            self.motion = IntegratorState::new(0.0);
        }
        self.integrator.step(&mut self.motion, a)
    }

    /// The bias that was learnt, m/s².
    pub fn bias(&self) -> f32 {
        self.bias.bias()
    }
}

/// An encoder beside the accelerometer, taken as one whose output falls below 0.5 Hz: the corner is a state of the filter, and the
/// velocity comes out through a low-pass of linear phase, one of ten.
#[derive(Clone, Copy, Debug)]
pub struct Aided {
    filter: Kalman<f32, 4>,
    state: KalmanState<f32, 4>,
    smooth: FirDecimatorState<f32, 1, 9>,
}

/// A low-pass of linear phase, four samples late.
pub const LINEAR_PHASE: FirDecimator<f32, 1, 9> =
    FirDecimator::constant([0.01, 0.05, 0.12, 0.2, 0.24, 0.2, 0.12, 0.05, 0.01], 10);

impl Aided {
    /// Counts of a tenth of a millimetre, 0.02 m/s² of noise.
    ///
    /// # Errors
    /// None for these numbers.
    pub fn new() -> Result<Self, Error> {
        let noise = MotionNoise {
            acceleration: 4e-4,
            form: ProcessNoise::SampleConstant,
            position: 1e-8 / 12.0,
        };
        let filter = Kalman::with_low_corner(&noise, 1e-8, 0.5, Hold::Second, 1.0 / RATE)?;
        Ok(Self {
            filter,
            state: KalmanState::new([0.0; 4], [1e-8, 1e-8, 1e-2, 1e-4], 0.0),
            smooth: FirDecimatorState::new(),
        })
    }

    /// One sample: velocity along x in m/s with every tenth.
    pub fn step(&mut self, sample: u32) -> Option<f32> {
        let (counts, temperature, _) = reading(sample);
        let a = compensate(counts, temperature)[0];
        // Half a metre per second squared from the first second to the second.
        let driven = sample.clamp(1000, 2000) - 1000;
        let coasted = sample.max(2000) - 2000;
        let count = driven * driven / 400 + 5 * coasted;
        self.filter
            .step(&mut self.state, Some(1e-4 * count as f32), a);
        let velocity = LINEAR_PHASE.step(&mut self.smooth, [self.state.x[1]]);
        velocity.map(|[v]| v)
    }
}

/// Readings of a machine that stands for a second, speeds up for one, coasts for one: counts, °C, whether it stands.
///
/// Integers from a linear congruence, so that every platform has the same.
pub fn reading(sample: u32) -> ([u16; 3], f32, bool) {
    let state = sample.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let noise = |shift: u32| ((state >> shift) & 7) as u16;
    // 0.5 m/s² are 207 counts; the bias of the day is 2 counts.
    let drive = if (1000..2000).contains(&sample) {
        207
    } else {
        0
    };
    // At rest, gravity along z shows with 39 counts in x and 86 in y; x has 0.41 counts more for every kelvin.
    let warm = (sample * 82 / 100_000) as u16;
    let x = 33_120 + 39 + 2 + warm + drive + noise(8) - 4;
    let y = 33_271 + 86 + noise(14) - 4;
    let z = 36_426 + noise(20) - 4;
    ([x, y, z], 25.0 + sample as f32 * 0.002, sample < 1000)
}

/// Samples of [`reading`].
pub const SAMPLES: u32 = 3000;

#[cfg(test)]
mod tests {
    use super::*;

    /// The constant is the model it says it is: K⁻¹ K differs from the identity by the digits that were kept.
    #[test]
    fn law_the_constant_agrees_with_the_inverted_model() {
        let inverted = SensorModel::new(*SENSOR.sensor().k(), SENSOR.sensor().bias()).unwrap();
        for counts in [
            [33_120, 33_271, 36_436],
            [37_100, 33_000, 32_000],
            [0, 65_535, 32_366],
        ] {
            let a = compensate(counts, 25.0);
            let b = inverted.apply(counts.map(f32::from));
            for axis in 0..3 {
                // Seven digits of elements of 2.4e-3 against 33 000 counts: 33 000 · 2.4e-10 · 3.
                assert!((a[axis] - b[axis]).abs() < 5e-4, "{a:?} {b:?}");
            }
        }
    }

    /// 207 counts for a second are 0.499 m/s; then the velocity stays.
    #[test]
    fn known_velocity_of_the_machine() {
        let mut pipeline = Pipeline::new().unwrap();
        let velocity: Vec<f32> = (0..SAMPLES)
            .map(|i| {
                let (counts, t, stands) = reading(i);
                pipeline.step(counts, t, stands)
            })
            .collect();
        assert_eq!(velocity[999], 0.0);
        // Temperature moves the bias by 0.4 count/K over 4 K against what was learnt cold: K(T) takes it out, and what
        // stays is the noise of ±4 counts over a thousand samples.
        assert!((velocity[2100] - 0.4988).abs() < 5e-3, "{}", velocity[2100]);
        assert!(
            (velocity[2999] - velocity[2100]).abs() < 5e-3,
            "{} to {}",
            velocity[2100],
            velocity[2999]
        );
        assert!(pipeline.bias().abs() < 0.02);
    }

    /// Beside the encoder the velocity is 0.5 m/s at two seconds; results come with every tenth sample from the ninth on.
    #[test]
    fn known_velocity_beside_an_encoder() {
        let mut aided = Aided::new().unwrap();
        let velocity: Vec<f32> = (0..SAMPLES).filter_map(|i| aided.step(i)).collect();
        assert_eq!(velocity.len(), (SAMPLES as usize - 8).div_ceil(10));
        assert!((velocity[210] - 0.5).abs() < 0.02, "{}", velocity[210]);
        assert!((velocity[298] - 0.5).abs() < 0.02, "{}", velocity[298]);
    }
}
