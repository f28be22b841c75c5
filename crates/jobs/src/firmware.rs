//! What of a result firmware needs: the filter of a bias, the gains of a velocity, the map of an encoder.

use crate::bias::{BiasOutcome, OnChip};
use crate::outcome::Outcome;
use crate::stored_result::read_section;
use crate::trouble::{Result, Trouble};
use crate::velocity::{StoredMap, TunedGains, VelocityMap, VelocityTuning};
use proofmass_core::Error;
use proofmass_core::velocity::Kalman;
use proofmass_documents::{FirmwareBlock, ResultDocument};
use proofmass_motion::{EncoderMap, KalmanModel, LowCorner, Method, ReadingSource, steady_gain};

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
            TunedGains::read(bytes)?.firmware(gains)
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

/// A tuned method as a filter of the chip, which begins with this offset of the accelerometer where that is a state.
pub(crate) fn of_method(
    method: &Method,
    source: ReadingSource,
    offset: f64,
    sample_time: f64,
) -> Result<FirmwareBlock> {
    Ok(match *method {
        Method::Kalman { model } | Method::SteadyKalman { model } => {
            steady(&model, source, offset, sample_time)?
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

/// The Kalman filter of an accelerometer with a low corner, which is one state of it for each stage.
pub(crate) fn with_low_corner(
    model: &KalmanModel,
    source: ReadingSource,
    corner: &LowCorner,
    sample_time: f64,
) -> Result<FirmwareBlock> {
    let unsettled = |e: Error| {
        Trouble::from(e).with_hint(
            "the gain does not settle with the corner as a state: choose --method observer, and give back the slow accelerations before",
        )
    };
    Ok(if corner.order == 1 {
        let kalman = model.behind_one_stage(corner, sample_time)?;
        FirmwareBlock::VelocityCorner {
            filter: steady_gain(&kalman, source).map_err(unsettled)?,
            corner: corner.frequency,
            sample_time,
        }
    } else {
        let kalman = model.behind_two_stages(corner, sample_time)?;
        FirmwareBlock::VelocitySecondOrderCorner {
            filter: steady_gain(&kalman, source).map_err(unsettled)?,
            corner: corner.frequency,
            sample_time,
        }
    })
}

fn steady(
    model: &KalmanModel,
    source: ReadingSource,
    offset: f64,
    sample_time: f64,
) -> Result<FirmwareBlock> {
    let (noise, hold) = (model.noise(), model.interpolation);
    let unsettled = |e: Error| {
        Trouble::from(e)
            .with_hint("the gain of the Kalman filter does not settle: choose --method observer")
    };
    Ok(match model.bias {
        None => {
            let kalman = Kalman::<f64, 2>::new(&noise, hold, sample_time)?;
            FirmwareBlock::Velocity {
                filter: steady_gain(&kalman, source).map_err(unsettled)?,
                sample_time,
            }
        }
        Some(bias) => {
            let kalman = Kalman::<f64, 3>::with_bias(&noise, bias, hold, sample_time)?;
            FirmwareBlock::VelocityOffset {
                filter: steady_gain(&kalman, source).map_err(unsettled)?,
                offset,
                sample_time,
            }
        }
    })
}
