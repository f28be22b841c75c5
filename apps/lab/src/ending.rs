//! Why a run ended before its last sample.

use crate::device::DeviceError;

/// Every reason by name.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// Somebody pressed stop, or ended the program.
    Stopped,
    /// The walk through the plan gave no sign of life.
    Controller,
    /// The page gave no sign of life.
    Page,
    /// The device failed.
    Device(DeviceError),
    /// A sample is no number.
    NotANumber {
        /// Name of the channel.
        channel: String,
        /// Number of the sample.
        sample: u64,
    },
    /// A block has another length than the drive, or other channels.
    ShortBlock {
        /// Samples that came.
        got: usize,
        /// Samples of a block.
        wanted: usize,
    },
    /// The counter of samples jumped.
    Counter {
        /// Number that was due.
        due: u64,
        /// Number that came.
        got: u64,
    },
    /// A channel is beyond its full scale.
    Overload {
        /// Name of the channel.
        channel: String,
    },
    /// The drive that was to leave is above its limit.
    DriveLimit,
    /// The acceleration is above its limit.
    Limit {
        /// Acceleration seen, m/s².
        seen: f64,
        /// Limit, m/s².
        limit: f64,
    },
    /// The reference gives no signal.
    ReferenceLost,
    /// The reference changed its sign.
    Reversed,
    /// The level is not reached.
    NotReached {
        /// Acceleration that was reached, m/s².
        reached: f64,
        /// Acceleration wanted, m/s².
        wanted: f64,
        /// What kept it.
        why: &'static str,
    },
    /// The level left its tolerance while it was recorded.
    LevelLost {
        /// Departure, relative.
        by: f64,
    },
    /// The recorder does not keep up with the device.
    Behind,
}

impl Ending {
    /// The word of it, for files.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Stopped => "stopped",
            Self::Controller => "controller-silent",
            Self::Page => "page-silent",
            Self::Device(DeviceError::Stalled) => "device-stalled",
            Self::Device(DeviceError::Gone(_)) => "device-gone",
            Self::Device(DeviceError::Nonsense(_)) => "device-nonsense",
            Self::NotANumber { .. } => "not-a-number",
            Self::ShortBlock { .. } => "short-block",
            Self::Counter { .. } => "counter-jump",
            Self::Overload { .. } => "overload",
            Self::DriveLimit => "drive-limit",
            Self::Limit { .. } => "acceleration-limit",
            Self::ReferenceLost => "reference-lost",
            Self::Reversed => "reference-reversed",
            Self::NotReached { .. } => "level-not-reached",
            Self::LevelLost { .. } => "level-lost",
            Self::Behind => "recorder-behind",
        }
    }
}

impl std::fmt::Display for Ending {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Stopped => write!(f, "stopped by the operator"),
            Self::Controller => write!(
                f,
                "the program that walks the plan gave no sign of life for half a second"
            ),
            Self::Page => write!(
                f,
                "the page gave no sign of life for half a second: keep it in front, or start with --unattended"
            ),
            Self::Device(error) => write!(
                f,
                "{error}: look at its cable and its power, then start again"
            ),
            Self::NotANumber { channel, sample } => {
                write!(
                    f,
                    "sample {sample} of channel {channel} is no number: the device or its driver is faulty"
                )
            }
            Self::ShortBlock { got, wanted } => write!(
                f,
                "a block has {got} samples of {wanted}: the device lost samples"
            ),
            Self::Counter { due, got } => write!(
                f,
                "the counter of samples says {got} where {due} is due: the device lost samples"
            ),
            Self::Overload { channel } => {
                write!(
                    f,
                    "channel {channel} is beyond its full scale: lower the gain of its conditioner, or the target in the plan"
                )
            }
            Self::DriveLimit => write!(f, "the drive would have been above its limit"),
            Self::Limit { seen, limit } => write!(
                f,
                "{seen:.3} m/s² were seen, above the limit of {limit:.3} m/s²: look at the gain of the power amplifier"
            ),
            Self::ReferenceLost => write!(
                f,
                "the reference gives no signal: look at its cable and its conditioner"
            ),
            Self::Reversed => write!(
                f,
                "the reference changed its sign: look at the polarity of its conditioner"
            ),
            Self::NotReached {
                reached,
                wanted,
                why,
            } => write!(
                f,
                "{reached:.3} m/s² of {wanted:.3} m/s² were reached: {why}"
            ),
            Self::LevelLost { by } => write!(
                f,
                "the level left the target by {:.1} % while it was recorded",
                100.0 * by
            ),
            Self::Behind => write!(
                f,
                "the recorder does not keep up with the device: look at the disk"
            ),
        }
    }
}
