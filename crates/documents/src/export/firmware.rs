//! Filters, gains of a velocity and maps of an encoder, for firmware.

mod c;
mod rust;
mod vectors;

use super::{ExportForm, ExportNumber, ExportOptions, unable};
use proofmass_core::encoder::ErrorLine;
use proofmass_core::velocity::SteadyKalman;
use proofmass_core::{Butterworth, Error as CoreError};
use proofmass_io::{Input, Result, Software};
use serde::Serialize;
use vectors::Vectors;

/// Coefficients that are designed or found off line and run on the chip.
///
/// Every one is a type of `proofmass-core`; what is written for other languages computes the same.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum FirmwareBlock {
    /// Second-order Butterworth low-pass.
    LowPass {
        /// Corner, Hz.
        corner: f64,
        /// Samples per second.
        rate: f64,
    },
    /// Low-pass of linear phase.
    LinearPhase {
        /// Symmetric impulse response, of odd length.
        taps: Vec<f64>,
        /// End of the band that passes, Hz.
        corner: f64,
        /// Largest difference of the gain from one up to it.
        ripple: f64,
        /// From where on it stops, Hz.
        stop: f64,
        /// Largest gain there.
        stop_gain: f64,
        /// Samples per second.
        rate: f64,
    },
    /// Mean of the last samples.
    MovingAverage {
        /// How many.
        samples: usize,
        /// Samples per second.
        rate: f64,
    },
    /// Bias filter of three axes.
    Bias {
        /// Samples per second.
        rate: f64,
        /// φ, Q and R of x, y, z.
        coefficients: [[f64; 3]; 3],
        /// Bias and its variance to begin with.
        state: [[f64; 2]; 3],
    },
    /// Velocity by a Kalman filter with its steady gain: position and velocity.
    Velocity {
        /// The filter.
        filter: SteadyKalman<f64, 2>,
        /// Time between samples, s.
        sample_time: f64,
    },
    /// The same with the offset of the accelerometer.
    VelocityOffset {
        /// The filter.
        filter: SteadyKalman<f64, 3>,
        /// Offset with which it begins: a gain of zero leaves it there.
        offset: f64,
        /// Time between samples, s.
        sample_time: f64,
    },
    /// The same of an accelerometer with a low corner: position, velocity, what it has shown of the velocity, its offset.
    VelocityCorner {
        /// The filter.
        filter: SteadyKalman<f64, 4>,
        /// Corner of first order, Hz.
        corner: f64,
        /// Time between samples, s.
        sample_time: f64,
    },
    /// The same behind two stages of one corner: position, velocity, what either stage has shown of the velocity, the offset.
    VelocitySecondOrderCorner {
        /// The filter.
        filter: SteadyKalman<f64, 5>,
        /// Corner of either stage, Hz.
        corner: f64,
        /// Time between samples, s.
        sample_time: f64,
    },
    /// Velocity by an observer.
    Observer {
        /// 1/s
        k_x: f64,
        /// 1/s²
        k_v: f64,
        /// 1/s³; 0 in the second order.
        k_b: f64,
        /// Time between samples, s.
        sample_time: f64,
    },
    /// Velocity by two channels.
    TwoChannel {
        /// rad/s
        k1: f64,
        /// rad/s
        k2: f64,
        /// Time between samples, s.
        sample_time: f64,
    },
    /// Errors of an encoder that repeat with its reading.
    EncoderMap {
        /// Way or angle of one turn, in the unit of the readings.
        turn: f64,
        /// Lines that are subtracted.
        lines: Vec<ErrorLine<f64>>,
        /// Unit of the readings.
        unit: &'static str,
    },
}

/// What a filter on a chip can have.
const POSSIBLE: &str = "a corner lies below 0.49 of the sampling rate: lower it or raise --rate; a moving average has 1 to 4096 samples";

/// Most samples of a moving average.
pub const LONGEST_AVERAGE: usize = 4096;

impl FirmwareBlock {
    /// Name of the constant where none is asked for.
    fn default_name(&self) -> &'static str {
        match self {
            Self::LowPass { .. } | Self::LinearPhase { .. } => "low_pass",
            Self::MovingAverage { .. } => "moving_average",
            Self::Bias { .. } => "bias_filter",
            Self::EncoderMap { .. } => "encoder_map",
            _ => "velocity",
        }
    }

    /// Whether a step takes two numbers.
    fn takes_two(&self) -> bool {
        !matches!(
            self,
            Self::LowPass { .. }
                | Self::LinearPhase { .. }
                | Self::MovingAverage { .. }
                | Self::EncoderMap { .. }
        )
    }

    /// Delay at low frequency, s; `None` for what has none, or is no filter of a signal.
    ///
    /// # Errors
    /// A corner or rate that no filter can be designed for.
    pub fn group_delay(&self) -> std::result::Result<Option<f64>, CoreError> {
        Ok(match self {
            Self::LowPass { corner, rate } => {
                Some(Butterworth::<f64>::new(*corner, *rate)?.group_delay() / rate)
            }
            Self::LinearPhase { taps, rate, .. } => Some((taps.len() / 2) as f64 / rate),
            Self::MovingAverage { samples, rate } => Some(0.5 * (*samples as f64 - 1.0) / rate),
            _ => None,
        })
    }

    /// What a reader of the text must know, line by line.
    fn heading(&self, software: &Software, options: &ExportOptions) -> Result<Vec<String>> {
        let mut lines = vec![format!("{}, by {software}.", self.what())];
        if let Some(source) = &options.source {
            lines.push(format!("From {}, SHA-256 {}.", source.path, source.sha256));
        }
        let delay = self
            .group_delay()
            .map_err(|e| unable(&e.to_string(), POSSIBLE))?;
        let rate = match self {
            Self::LowPass { rate, .. }
            | Self::LinearPhase { rate, .. }
            | Self::MovingAverage { rate, .. } => Some(*rate),
            _ => None,
        };
        if let (Some(delay), Some(rate)) = (delay, rate) {
            lines.push(format!(
                "Group delay at low frequency: {:.6} samples, {delay:.6e} s.",
                delay * rate
            ));
        }
        lines.extend(options.notes.iter().cloned());
        Ok(super::plain_lines(&lines))
    }

    fn what(&self) -> String {
        match self {
            Self::LowPass { corner, rate } => {
                format!(
                    "Butterworth low-pass of second order, -3.01 dB at {corner:?} Hz, {rate:?} Hz"
                )
            }
            Self::LinearPhase {
                taps,
                corner,
                ripple,
                stop,
                stop_gain,
                rate,
            } => {
                format!(
                    "Low-pass of linear phase, {} samples: gain within {ripple:.2e} of one up to {corner:?} Hz, below {stop_gain:.2e} from {stop:.6} Hz on, {rate:?} Hz",
                    taps.len()
                )
            }
            Self::MovingAverage { samples, rate } => {
                format!("Mean of the last {samples} samples, {rate:?} Hz")
            }
            Self::Bias { rate, .. } => {
                format!("Bias of an accelerometer in m/s^2, three axes, {rate:?} Hz")
            }
            Self::Velocity { sample_time, .. } => {
                format!(
                    "Velocity by a Kalman filter with its steady gain, sample time {sample_time:?} s, no delay"
                )
            }
            Self::VelocityOffset { sample_time, .. } => format!(
                "Velocity and offset of the accelerometer by a Kalman filter with its steady gain, sample time {sample_time:?} s, no delay"
            ),
            Self::VelocityCorner {
                corner,
                sample_time,
                ..
            } => format!(
                "Velocity, with the low corner of the accelerometer at {corner:?} Hz as a state, by a Kalman filter with its steady gain, sample time {sample_time:?} s, no delay; states: position, velocity, what the accelerometer has shown of the velocity, its offset"
            ),
            Self::VelocitySecondOrderCorner {
                corner,
                sample_time,
                ..
            } => format!(
                "Velocity, with the low corner of second order of the accelerometer, two stages at {corner:?} Hz, as states, by a Kalman filter with its steady gain, sample time {sample_time:?} s, no delay; states: position, velocity, what the accelerometer has shown of the velocity, the same between the stages, its offset"
            ),
            Self::Observer {
                k_x,
                k_v,
                k_b,
                sample_time,
            } => format!(
                "Velocity by an observer, k_x = {k_x:?} 1/s, k_v = {k_v:?} 1/s^2, k_b = {k_b:?} 1/s^3, sample time {sample_time:?} s, no delay"
            ),
            Self::TwoChannel {
                k1,
                k2,
                sample_time,
            } => format!(
                "Velocity by two channels, k1 = {k1:?} rad/s, k2 = {k2:?} rad/s, sample time {sample_time:?} s, no delay"
            ),
            Self::EncoderMap { turn, lines, unit } => format!(
                "Errors of an encoder, lines: {}, over a turn of {turn:?} {unit}, from the zero of its readings",
                lines.len()
            ),
        }
    }
}

/// Coefficients as plain data.
#[derive(Serialize)]
struct Plain<'a> {
    schema: proofmass_io::Schema,
    software: &'a Software,
    #[serde(skip_serializing_if = "Option::is_none")]
    source: Option<&'a Input>,
    block: serde_json::Value,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    notes: &'a [String],
    #[serde(skip_serializing_if = "Option::is_none")]
    group_delay_s: Option<f64>,
    check: Vectors,
}

/// Writes a filter, gains or a map as constants of Rust, a C99 header or plain JSON.
///
/// ```
/// use proofmass_documents::{ExportForm, ExportOptions, FirmwareBlock, export_block};
///
/// let block = FirmwareBlock::LowPass { corner: 50.0, rate: 1000.0 };
/// let header = export_block(&block, ExportForm::C, &ExportOptions::default())?;
/// assert!(header.contains("static inline float low_pass_step(low_pass_state *state, float input)"));
/// assert!(header.contains("Group delay at low frequency: 4.464497"));
/// # Ok::<(), proofmass_io::Error>(())
/// ```
///
/// # Errors
/// A filter that cannot be designed; integers, Python and imu.yaml; a name that is no identifier.
pub fn export_block(
    block: &FirmwareBlock,
    form: ExportForm,
    options: &ExportOptions,
) -> Result<String> {
    if options.number == ExportNumber::Fixed {
        return Err(unable(
            "filters are written in floating point",
            "choose single or double precision",
        ));
    }
    let single = options.number == ExportNumber::Float;
    let name = match &options.name {
        Some(name) => super::identifier(name)?,
        None => block.default_name().to_owned(),
    };
    let refused = |e: CoreError| unable(&e.to_string(), POSSIBLE);
    let vectors = Vectors::of(block, single).map_err(refused)?;
    let software = Software::default();
    let heading = block.heading(&software, options)?;
    match form {
        ExportForm::C => c::text(block, &name, single, &heading, &vectors).map_err(refused),
        ExportForm::Rust => rust::text(block, &name, single, &heading, &vectors).map_err(refused),
        ExportForm::Json => {
            let delay = block.group_delay().map_err(refused)?;
            let bytes = proofmass_io::finite::to_json(&Plain {
                schema: proofmass_io::Schema::new("proofmass.firmware", 1),
                software: &software,
                source: options.source.as_ref(),
                block: vectors::plain(block).map_err(refused)?,
                notes: &options.notes,
                group_delay_s: delay,
                check: vectors,
            })?;
            Ok(String::from_utf8_lossy(&bytes).into_owned())
        }
        ExportForm::Python | ExportForm::ImuYaml | ExportForm::MemoryReader => Err(unable(
            "a filter is written as C, Rust or JSON",
            "choose --c, --rust or --json",
        )),
    }
}
