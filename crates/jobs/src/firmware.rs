//! What of a result firmware needs: the filter of a bias, the gains of a velocity, the map of an encoder.

use crate::bias::{BiasOutcome, OnChip};
use crate::outcome::Outcome;
use crate::stored_result::read_section;
use crate::trouble::{Result, Trouble};
use crate::velocity::{StoredMap, TunedGains, VelocityMap, VelocityTuning};
use proofmass_core::velocity::{Kalman, ProcessNoise, SteadyKalman};
use proofmass_core::{Error, Matrix3};
use proofmass_io::{FirmwareBlock, ResultDocument};
use proofmass_motion::{EncoderMap, KalmanModel, Method, ReadingSource};

/// Which gains of a tuning are wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[non_exhaustive]
pub enum GainsOf {
    /// Kalman filter with its steady gain.
    #[default]
    Kalman,
    /// Observer.
    Observer,
    /// Two channels.
    TwoChannel,
}

/// What is written for firmware, and what must be done beside it, line by line.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Firmware {
    /// The filter, gains or map.
    pub block: FirmwareBlock,
    /// Further lines of its heading.
    pub notes: Vec<String>,
}

/// Reads a result.json and takes from it what firmware needs: `bias`, `velocity-tuning`, `velocity-map`.
///
/// # Errors
/// Another kind of result; gains that do not settle.
pub fn firmware(bytes: &[u8], gains: GainsOf) -> Result<Firmware> {
    let kind = ResultDocument::from_json(bytes)?.kind;
    match kind.as_str() {
        BiasOutcome::KIND => {
            let (filter, _) = read_section::<OnChip>(bytes, &kind, OnChip::SECTION)?;
            Ok(filter.firmware())
        }
        VelocityTuning::KIND => {
            let (tuned, _) = read_section::<TunedGains>(bytes, &kind, TunedGains::SECTION)?;
            tuned.firmware(gains)
        }
        VelocityMap::KIND => Ok(StoredMap::read(bytes)?.firmware()),
        other => Err(Trouble::data(format!(
            "a result of kind `{other}` has nothing for firmware"
        ))
        .with_hint("export a calibration.json, or the result.json of `proofmass bias`, `velocity tune` or `velocity map`")),
    }
}

/// The map with its unit.
pub(crate) fn encoder_map(map: &EncoderMap, angular: bool) -> Firmware {
    Firmware {
        block: FirmwareBlock::EncoderMap {
            turn: map.turn,
            lines: map
                .lines
                .iter()
                .map(|l| proofmass_core::encoder::ErrorLine {
                    order: l.order,
                    cosine: l.cosine,
                    sine: l.sine,
                })
                .collect(),
            unit: if angular { "rad" } else { "m" },
        },
        notes: vec!["Set the reading to zero at the index, as it was in the recording.".to_owned()],
    }
}

/// A tuned method as a filter of the chip.
pub(crate) fn of_method(
    method: &Method,
    source: ReadingSource,
    sample_time: f64,
) -> Result<FirmwareBlock> {
    Ok(match *method {
        Method::Kalman { model } | Method::SteadyKalman { model } => {
            steady(&model, source, sample_time)?
        }
        Method::Observer { k_x, k_v } => FirmwareBlock::Observer {
            k_x,
            k_v,
            k_b: 0.0,
            sample_time,
        },
        Method::OffsetObserver { k_x, k_v, k_b } => FirmwareBlock::Observer {
            k_x,
            k_v,
            k_b,
            sample_time,
        },
        Method::TwoChannel { k1, k2 } => FirmwareBlock::TwoChannel {
            k1,
            k2,
            sample_time,
        },
        _ => {
            return Err(
                Trouble::request(format!("{} has no constant gains", method.label()))
                    .with_hint("choose --method observer or two-channel"),
            );
        }
    })
}

/// How fast the offset behind a corner may walk, over the walk of an acceleration that is given back: little enough to cost nothing, and
/// enough that the gain does not fall to zero.
const OFFSET_WALK: f64 = 0.1;

/// The Kalman filter of an accelerometer with a low corner of first order, which is a state of it.
///
/// The noise of the accelerometer enters velocity and shown velocity alike, so that the offset of what is given back walks by (2πf)² q of
/// itself; the offset behind the corner walks by a hundredth of that.
pub(crate) fn with_low_corner(
    model: &KalmanModel,
    source: ReadingSource,
    corner: f64,
    sample_time: f64,
) -> Result<FirmwareBlock> {
    let noise = model.noise();
    let density = match model.noise_form {
        ProcessNoise::SampleConstant => model.acceleration_noise * sample_time,
        ProcessNoise::Continuous => model.acceleration_noise,
    };
    let rate = OFFSET_WALK * std::f64::consts::TAU * corner;
    let walk = rate * rate * density;
    let kalman =
        Kalman::<f64, 4>::with_low_corner(&noise, walk, corner, model.interpolation, sample_time)?;
    let component = usize::from(source == ReadingSource::Speed);
    let filter = kalman.steady_for(component).map_err(|e| {
        Trouble::from(e).with_hint(
            "the gain does not settle with the corner as a state: choose --method observer, and give back the slow accelerations before",
        )
    })?;
    Ok(FirmwareBlock::VelocityCorner {
        filter,
        corner,
        sample_time,
    })
}

fn steady(model: &KalmanModel, source: ReadingSource, sample_time: f64) -> Result<FirmwareBlock> {
    let noise = model.noise();
    let component = usize::from(source == ReadingSource::Speed);
    let unsettled = |e: Error| {
        Trouble::from(e)
            .with_hint("the gain of the Kalman filter does not settle: choose --method observer")
    };
    Ok(match model.bias {
        None => {
            let kalman = Kalman::<f64, 2>::new(&noise, model.interpolation, sample_time)?;
            FirmwareBlock::Velocity {
                filter: kalman.steady_for(component).map_err(unsettled)?,
                sample_time,
            }
        }
        Some(bias) => {
            let kalman =
                Kalman::<f64, 3>::with_bias(&noise, bias, model.interpolation, sample_time)?;
            // An offset that hardly walks settles in more steps than are iterated; doubling gets there in some thirty.
            let filter = match kalman.steady_for(component) {
                Err(Error::NotConverged { .. }) if component == 0 => doubled(&kalman),
                iterated => iterated,
            };
            FirmwareBlock::VelocityOffset {
                filter: filter.map_err(unsettled)?,
                sample_time,
            }
        }
    })
}

/// Steady gain for readings of the position, by the structure-preserving doubling algorithm of the Riccati equation: after k
/// steps the covariance is that after 2ᵏ samples.
///
/// **Source** `[Anderson78]`.
fn doubled(kalman: &Kalman<f64, 3>) -> core::result::Result<SteadyKalman<f64, 3>, Error> {
    const STEPS: usize = 60;
    let matrix = |of: &dyn Fn(usize, usize) -> f64| -> Matrix3<f64> {
        Matrix3(std::array::from_fn(|i| std::array::from_fn(|j| of(i, j))))
    };
    let sum = |a: &Matrix3<f64>, b: &Matrix3<f64>| matrix(&|i, j| a.0[i][j] + b.0[i][j]);
    // In units of the sample time the states are of one size.
    let t = kalman.f[0][1];
    let size = [1.0, 1.0 / t, 1.0 / (t * t)];
    let mut a = matrix(&|i, j| kalman.f[j][i] * size[i] / size[j]);
    let mut p = matrix(&|i, j| kalman.q[i][j] / (size[i] * size[j] * kalman.r));
    let mut g = matrix(&|i, j| f64::from(u8::from(i == 0 && j == 0)));
    let mut change = f64::INFINITY;
    for _ in 0..STEPS {
        let w = sum(&Matrix3::identity(), &g.product(&p)).inverse()?;
        let aw = a.product(&w);
        let more = a.transpose().product(&p).product(&w).product(&a);
        g = sum(&g, &aw.product(&g).product(&a.transpose()));
        a = aw.product(&a);
        change = (0..3)
            .map(|i| more.0[i][i].abs() / p.0[i][i].abs().max(f64::MIN_POSITIVE))
            .fold(0.0, f64::max);
        p = sum(&p, &more);
        if change < 1e-12 {
            let p = p.0;
            let k: [f64; 3] = std::array::from_fn(|i| p[i][0] / (p[0][0] + 1.0));
            let left = p[1][1] - k[1] * p[0][1];
            return Ok(SteadyKalman {
                f: kalman.f,
                g: kalman.g,
                k: std::array::from_fn(|i| k[i] * size[i]),
                component: 0,
                velocity_variance: left * kalman.r * size[1] * size[1],
            });
        }
    }
    Err(Error::NotConverged {
        name: "steady gain",
        iterations: STEPS,
        step: change,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_core::velocity::{BiasModel, Hold, MotionNoise};

    fn kalman(density: f64) -> core::result::Result<Kalman<f64, 3>, Error> {
        let noise = MotionNoise {
            acceleration: 1e-3,
            form: ProcessNoise::SampleConstant,
            position: 1e-9,
        };
        let walk = BiasModel::RandomWalk {
            density,
            initial: 0.1,
        };
        Kalman::<f64, 3>::with_bias(&noise, walk, Hold::Second, 1e-3)
    }

    #[test]
    fn law_doubling_and_iteration_agree() -> core::result::Result<(), Error> {
        for density in [1e-4, 1e-5, 1e-6] {
            let kalman = kalman(density)?;
            let (fast, slow) = (doubled(&kalman)?, kalman.steady()?);
            for i in 0..3 {
                assert!(
                    (fast.k[i] / slow.k[i] - 1.0).abs() < 1e-6,
                    "{density} {fast:?} {slow:?}"
                );
            }
            assert!((fast.velocity_variance / slow.velocity_variance - 1.0).abs() < 1e-6);
        }
        Ok(())
    }

    /// A walk ten times as small is followed ten times as slowly.
    #[test]
    fn known_an_offset_that_hardly_walks_settles() -> core::result::Result<(), Error> {
        let slow = doubled(&kalman(1e-12)?)?;
        let slower = doubled(&kalman(1e-14)?)?;
        assert!(
            (slow.k[2] / slower.k[2] - 10.0).abs() < 0.1,
            "{slow:?} {slower:?}"
        );
        Ok(())
    }
}
