//! What follows a calibration, as options.

use crate::Failure;
use crate::number_arguments::positive;
use proofmass::io::{Input, Source};
use proofmass::jobs::apply::{Chain, LowPass, LowPassForm, Rotation};
use proofmass::jobs::static_test::mounted_turn;
use std::path::{Path, PathBuf};

/// Options of the commands that put steps behind a calibration.
#[derive(clap::Args)]
pub(crate) struct ChainArguments {
    /// Turn to the frame of a machine or vehicle: roll, pitch and yaw of the sensor in it, in degrees
    ///
    /// The frame of the machine is turned about its z axis by yaw, about its new y axis by pitch and about its new x axis by roll
    /// (right-handed; ISO 8855 with x forward, y to the left, z up), and is then that of the sensor. Or the result.json of
    /// `proofmass test mounting`, with its uncertainty.
    #[arg(long, value_name = "ROLL,PITCH,YAW|FILE", value_parser = turn, allow_hyphen_values = true)]
    rotate: Option<Turn>,
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

/// A turn by its angles in degrees, or the result that measured it.
#[derive(Clone, Debug)]
enum Turn {
    Angles([f64; 3]),
    Measured(PathBuf),
}

/// Angles where the text begins like a number; a file otherwise.
fn turn(text: &str) -> Result<Turn, String> {
    match text
        .trim_start()
        .starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c))
        && !text.ends_with(".json")
    {
        true => angles(text).map(Turn::Angles),
        false => Ok(Turn::Measured(text.into())),
    }
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
    /// The file of a measured turn.
    pub(crate) fn mounting(&self) -> Option<&Path> {
        match &self.rotate {
            Some(Turn::Measured(file)) => Some(file),
            _ => None,
        }
    }

    /// As a request has it, and the file of a measured turn, which is read.
    pub(crate) fn chain(&self) -> Result<(Chain, Option<Input>), Failure> {
        let mut chain = Chain::default();
        let mut mounting = None;
        chain.rotation = match &self.rotate {
            None => None,
            Some(Turn::Angles(angles)) => Some(Rotation {
                angles: angles.map(f64::to_radians),
                uncertainty: self
                    .rotate_uncertainty
                    .unwrap_or_default()
                    .map(f64::to_radians),
                covariance: None,
            }),
            Some(Turn::Measured(file)) => {
                if self.rotate_uncertainty.is_some() {
                    return Err(Failure::new(
                        "the turn was measured, with its uncertainty, and --rotate-uncertainty states another one",
                    )
                    .detail(file.display().to_string())
                    .hint("leave out --rotate-uncertainty"));
                }
                let (turn, input) = mounted_turn(Source::open(file)?)?;
                mounting = Some(input);
                Some(turn.into())
            }
        };
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
        Ok((chain, mounting))
    }
}
