//! One of every filter, gain and map that can be exported.

use proofmass_core::encoder::ErrorLine;
use proofmass_core::velocity::{BiasModel, Hold, Kalman, MotionNoise, ProcessNoise};
use proofmass_core::{BiasFilter, Error};
use proofmass_documents::FirmwareBlock;

/// Name and block.
///
/// # Errors
/// None for these numbers.
pub fn filters() -> Result<Vec<(&'static str, FirmwareBlock)>, Error> {
    let noise = MotionNoise {
        acceleration: 1e-3,
        form: ProcessNoise::SampleConstant,
        position: 1e-9,
    };
    let sample_time = 1e-3;
    let walk = BiasModel::RandomWalk {
        density: 1e-6,
        initial: 0.1,
    };
    let kalman = Kalman::<f64, 2>::new(&noise, Hold::Second, sample_time)?;
    let offset = Kalman::<f64, 3>::with_bias(&noise, walk, Hold::Second, sample_time)?;
    let corner = Kalman::<f64, 4>::with_low_corner(&noise, 1e-6, 0.5, Hold::Second, sample_time)?;
    let second =
        Kalman::<f64, 5>::with_second_order_corner(&noise, 1e-6, 0.5, Hold::Second, sample_time)?;
    let markov = BiasModel::GaussMarkov {
        deviation: 2e-3,
        time: 300.0,
    };
    let (bias, _) = BiasFilter::<f64>::new(markov, 4e-4, 0.01)?;
    let line = |order, cosine, sine| ErrorLine {
        order,
        cosine,
        sine,
    };
    Ok(vec![
        (
            "low_pass",
            FirmwareBlock::LowPass {
                corner: 50.0,
                rate: 1000.0,
            },
        ),
        (
            "linear_phase",
            FirmwareBlock::LinearPhase {
                taps: raised_cosine(),
                corner: 20.0,
                ripple: 0.1,
                stop: 125.0,
                stop_gain: 3e-3,
                rate: 1000.0,
            },
        ),
        (
            "velocity_corner",
            FirmwareBlock::VelocityCorner {
                filter: corner.steady()?,
                corner: 0.5,
                sample_time,
            },
        ),
        (
            "velocity_second_order_corner",
            FirmwareBlock::VelocitySecondOrderCorner {
                filter: second.steady()?,
                corner: 0.5,
                sample_time,
            },
        ),
        (
            "mean",
            FirmwareBlock::MovingAverage {
                samples: 8,
                rate: 1000.0,
            },
        ),
        (
            "bias",
            FirmwareBlock::Bias {
                rate: 100.0,
                coefficients: [bias.coefficients(); 3],
                state: [[0.02, 4e-6], [-0.01, 4e-6], [0.03, 4e-6]],
            },
        ),
        (
            "velocity",
            FirmwareBlock::Velocity {
                filter: kalman.steady()?,
                sample_time,
            },
        ),
        (
            "velocity_offset",
            FirmwareBlock::VelocityOffset {
                filter: offset.steady()?,
                offset: 0.0192,
                sample_time,
            },
        ),
        (
            "observer",
            FirmwareBlock::Observer {
                k_x: 60.0,
                k_v: 1800.0,
                k_b: 100.0,
                sample_time,
            },
        ),
        (
            "two_channel",
            FirmwareBlock::TwoChannel {
                k1: 0.1,
                k2: 40.0,
                sample_time,
            },
        ),
        (
            "encoder_map",
            FirmwareBlock::EncoderMap {
                turn: std::f64::consts::TAU,
                lines: vec![
                    line(1.0, 0.006, 0.008),
                    line(2.0, -1e-3, 4e-4),
                    line(0.37, 2e-4, 0.0),
                ],
                unit: "rad",
            },
        ),
    ])
}

/// Seventeen samples of a raised cosine, whose sum is one.
pub fn raised_cosine() -> Vec<f64> {
    (1..18)
        .map(|k| (1.0 - (std::f64::consts::TAU * f64::from(k) / 18.0).cos()) / 18.0)
        .collect()
}
