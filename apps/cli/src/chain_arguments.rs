//! What follows a calibration, as options.

use crate::number_arguments::positive;
use proofmass::jobs::apply::{Chain, LowPass, LowPassForm, Rotation};

/// Options of the commands that put steps behind a calibration.
#[derive(clap::Args)]
pub(crate) struct ChainArguments {
    /// Turn to the frame of a machine or vehicle: roll, pitch and yaw of the sensor in it, in degrees
    ///
    /// The frame of the machine is turned about its z axis by yaw, about its new y axis by pitch and about its new x axis by roll
    /// (right-handed; ISO 8855 with x forward, y to the left, z up), and is then that of the sensor.
    #[arg(long, value_name = "ROLL,PITCH,YAW", value_parser = angles, allow_hyphen_values = true)]
    rotate: Option<[f64; 3]>,
    /// Standard uncertainties of these angles, in degrees
    #[arg(long, value_name = "ROLL,PITCH,YAW", value_parser = angles, requires = "rotate", allow_hyphen_values = true)]
    rotate_uncertainty: Option<[f64; 3]>,
    /// Low-pass of all axes with this corner in hertz: a Butterworth of second order, as `proofmass filter` writes it
    #[arg(long, value_name = "HZ", value_parser = positive)]
    low_pass: Option<f64>,
    /// Low-pass with one delay at all frequencies, flat up to --low-pass, in place of the Butterworth
    #[arg(long, requires = "low_pass")]
    linear_phase: bool,
    /// Keep one of M samples behind the low-pass
    #[arg(long, value_name = "M")]
    decimate: Option<u32>,
    /// What decimation folds into the band up to the corner must be weaker by this, in dB [default: 60]
    #[arg(long, value_name = "DB", value_parser = positive, requires = "low_pass")]
    attenuation: Option<f64>,
}

/// Three finite numbers: `0,-90,12.5`.
fn angles(text: &str) -> Result<[f64; 3], String> {
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    numbers
        .and_then(|n| n.try_into().ok())
        .ok_or_else(|| format!("{text:?} is no three angles in degrees such as 0,-90,12.5"))
}

impl ChainArguments {
    /// As a request has it.
    pub(crate) fn chain(&self) -> Chain {
        let mut chain = Chain::default();
        chain.rotation = self.rotate.map(|angles| Rotation {
            angles: angles.map(f64::to_radians),
            uncertainty: self
                .rotate_uncertainty
                .unwrap_or_default()
                .map(f64::to_radians),
        });
        chain.low_pass = self.low_pass.map(|corner| {
            let mut low_pass = LowPass::new(corner);
            if self.linear_phase {
                low_pass.form = LowPassForm::LinearPhase;
            }
            low_pass
        });
        chain.decimation = self.decimate;
        if let Some(attenuation) = self.attenuation {
            chain.attenuation = attenuation;
        }
        chain
    }
}
