//! What a bench is made of: channels in blocks on one clock, and a drive.
//!
//! A device gives blocks of equal length with a counter of samples, and takes a drive of that length for each.
//! It never waits longer than it is asked to: a device that has no block by then says so.

use serde::{Deserialize, Serialize};
use std::time::Duration;

/// What a device says of itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// Who made it.
    #[serde(default)]
    pub maker: String,
    /// Which model it is.
    #[serde(default)]
    pub model: String,
    /// Serial number.
    #[serde(default)]
    pub serial: String,
    /// Names of the channels, in the order of a block.
    pub channels: Vec<String>,
    /// Sampling rate in Hz, the same for every channel and the drive.
    #[serde(rename = "rate_Hz")]
    pub rate: f64,
    /// Samples of a block.
    pub block: usize,
    /// Full scale of the channels in V.
    #[serde(rename = "full_scale_V")]
    pub full_scale: f64,
    /// Largest drive in V; none where the device has no output.
    #[serde(rename = "drive_V", default)]
    pub drive: Option<f64>,
    /// Whether the device keeps the time of the clock on the wall; a simulation may run faster.
    #[serde(default = "yes")]
    pub paced: bool,
}

fn yes() -> bool {
    true
}

impl Identity {
    /// Duration of a block in s.
    pub fn block_seconds(&self) -> f64 {
        self.block as f64 / self.rate
    }

    /// One line that names the device.
    pub fn line(&self) -> String {
        let words = [&self.maker, &self.model, &self.serial];
        let words: Vec<&str> = words.iter().map(|w| w.trim()).collect();
        let words: Vec<&str> = words.into_iter().filter(|w| !w.is_empty()).collect();
        match words.is_empty() {
            true => "a device that does not name itself".to_owned(),
            false => words.join(" "),
        }
    }

    /// Refuses numbers that no device can have.
    ///
    /// # Errors
    /// [`DeviceError::Nonsense`] with what is wrong.
    pub fn check(&self) -> Result<(), DeviceError> {
        let nonsense = |what: String| Err(DeviceError::Nonsense(what));
        if !(self.rate >= 100.0 && self.rate <= 1e7) {
            return nonsense(format!("a sampling rate of {} Hz", self.rate));
        }
        if !(0.001..=0.1).contains(&self.block_seconds()) {
            return nonsense(format!(
                "blocks of {} samples last {:.4} s; from 0.001 s to 0.1 s are taken, so that a stop acts in time",
                self.block,
                self.block_seconds()
            ));
        }
        if !(self.full_scale > 0.0 && self.full_scale.is_finite()) {
            return nonsense(format!("a full scale of {} V", self.full_scale));
        }
        if self.drive.is_some_and(|v| !(v > 0.0 && v.is_finite())) {
            return nonsense("a largest drive that is not above zero".to_owned());
        }
        if self.channels.is_empty() || self.channels.len() > 64 {
            return nonsense(format!("{} channels", self.channels.len()));
        }
        Ok(())
    }
}

/// Samples of all channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Number of the first sample since the start of the device.
    pub first: u64,
    /// Samples in V, channel by channel.
    pub channels: Vec<Vec<f64>>,
    /// Channels that the device itself calls overloaded.
    pub overloaded: Vec<usize>,
}

/// How the device under test is mounted, and what is measured next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Arrangement {
    /// Name of the run.
    pub run: String,
    /// Frequency in Hz.
    #[serde(rename = "frequency_Hz")]
    pub frequency: f64,
    /// Inclination in degrees, where the plan has one.
    #[serde(rename = "inclination_deg", default)]
    pub inclination: Option<f64>,
    /// Rotation in degrees, where the plan has one.
    #[serde(rename = "rotation_deg", default)]
    pub rotation: Option<f64>,
}

/// Why a device gives no block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DeviceError {
    /// No block came in the time asked for.
    Stalled,
    /// The connection ended.
    Gone(String),
    /// What it said cannot be.
    Nonsense(String),
}

impl std::fmt::Display for DeviceError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Stalled => write!(f, "the device delivers no samples"),
            Self::Gone(why) => write!(f, "the device is gone: {why}"),
            Self::Nonsense(what) => write!(f, "the device says what cannot be: {what}"),
        }
    }
}

impl std::error::Error for DeviceError {}

/// A bench: synchronous channels in blocks on one clock, and perhaps a drive.
pub trait Device: Send {
    /// What the device is; the same from start to end.
    fn identity(&self) -> &Identity;

    /// Begins anew: the counter starts where the device likes, and samples from before are let go.
    ///
    /// # Errors
    /// The device is gone or does not answer.
    fn start(&mut self) -> Result<(), DeviceError>;

    /// Tells how the device under test is mounted. A bench of metal has no use for it; a simulated one moves.
    ///
    /// # Errors
    /// The device is gone or does not answer.
    fn arrange(&mut self, arrangement: &Arrangement) -> Result<(), DeviceError> {
        let _ = arrangement;
        Ok(())
    }

    /// Takes the drive of one block, in V, and gives the next block of samples.
    ///
    /// What a device keeps between the two must be 0.2 s at most.
    ///
    /// # Errors
    /// [`DeviceError::Stalled`] when `wait` is over, and every other reason that there is no block.
    fn exchange(&mut self, drive: &[f64], wait: Duration) -> Result<Block, DeviceError>;

    /// Commands zero drive, beside the blocks: the last thing that is said to a device that failed.
    ///
    /// # Errors
    /// The device takes nothing any more: an alarm is due.
    fn silence(&mut self, wait: Duration) -> Result<(), DeviceError>;
}
