//! What follows the calibration, as it is asked for.

use crate::trouble::{Result, Trouble};
use proofmass_core::{Matrix3, TaitBryan};
use proofmass_static::static_test::MountedTurn;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Largest standard uncertainty of an angle, rad: 30°.
const LARGEST_UNCERTAINTY: f64 = TAU / 12.0;

/// What follows the calibration, in this order: a tracked bias is subtracted, the axes are turned, a low-pass runs, samples are left out.
///
/// A bias is one of the calibrated axes of the sensor, so that it goes before they are turned. A low-pass that is the same for all axes
/// gives the same before and after a turn; the turn stands first, where it is one matrix with the calibration on the chip. Samples are left
/// out last, when the low-pass has taken away what would fold.
///
/// ```
/// use proofmass_jobs::apply::{Chain, LowPass};
/// let mut chain = Chain::default();
/// chain.low_pass = Some(LowPass::new(40.0));
/// chain.decimation = Some(10);
/// assert!(chain.check(3).is_ok());
/// chain.decimation = Some(1);
/// assert!(chain.check(3).is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct Chain {
    /// How the sensor sits on the machine or vehicle, in whose frame the acceleration is wanted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<Rotation>,
    /// The low-pass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub low_pass: Option<LowPass>,
    /// Of so many samples one is kept, a whole number from 2 on. It needs a low-pass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decimation: Option<u32>,
    /// What decimation folds into the band up to the corner must be weaker by this, in dB.
    pub attenuation: f64,
}

impl Default for Chain {
    fn default() -> Self {
        Self {
            rotation: None,
            low_pass: None,
            decimation: None,
            attenuation: 60.0,
        }
    }
}

/// Angles that turn the frame of a machine into that of the sensor on it.
///
/// The frame of the machine is turned about its z axis by yaw, about its new y axis by pitch, about its new x axis by roll (ISO 8855, x
/// forward, y to the left, z up): a_machine = R_z(yaw) R_y(pitch) R_x(roll) a_sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Rotation {
    /// Roll, pitch and yaw, rad.
    pub angles: [f64; 3],
    /// Their standard uncertainties, rad; zeros where none are stated.
    #[serde(default)]
    pub uncertainty: [f64; 3],
    /// Covariance of a small turn about x, y, z of the machine, rad²; in the place of the uncertainties where it was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<[[f64; 3]; 3]>,
}

impl From<MountedTurn> for Rotation {
    fn from(turn: MountedTurn) -> Self {
        Self {
            angles: turn.angles,
            uncertainty: [0.0; 3],
            covariance: Some(turn.covariance),
        }
    }
}

impl Rotation {
    /// The matrix from the frame of the sensor to that of the machine.
    ///
    /// # Errors
    /// An angle or uncertainty that is none.
    pub fn matrix(&self) -> Result<Matrix3<f64>> {
        Ok(self.turn()?.matrix())
    }

    /// Largest standard uncertainty of a component over the acceleration; 0 where none is stated.
    pub(super) fn largest_uncertainty(&self) -> f64 {
        if let Some(c) = &self.covariance {
            return largest_eigenvalue(c).max(0.0).sqrt();
        }
        let turn = self.turn();
        turn.map_or(0.0, |turn| turn.largest_uncertainty(self.uncertainty))
    }

    fn turn(&self) -> Result<TaitBryan> {
        let [roll, pitch, yaw] = self.angles;
        let hint = "state roll, pitch and yaw of the sensor in the frame of the machine, as finite angles within a turn";
        let refused = |e| Trouble::from(e).with_hint(hint);
        // In degrees, as people state them.
        if let Some(angle) = self.angles.iter().find(|a| a.abs() > TAU) {
            return Err(Trouble::request(format!(
                "an angle of the rotation is {}°, more than a turn",
                angle.to_degrees()
            ))
            .with_hint(hint));
        }
        let turn = TaitBryan::new(roll, pitch, yaw).map_err(refused)?;
        // Beyond it an angle is not known at all, and the law of propagation says nothing.
        let wrong = |u: &&f64| !(0.0..=LARGEST_UNCERTAINTY).contains(*u);
        match self.uncertainty.iter().find(wrong) {
            Some(u) => Err(Trouble::request(format!(
                "the standard uncertainty of an angle of the rotation cannot be {}°",
                u.to_degrees()
            ))
            .with_hint("state a number from 0° to 30° for each of roll, pitch and yaw")),
            None => Ok(turn),
        }
    }
}

/// Of a symmetric matrix that is positive semi-definite, by the cosine of its characteristic angle.
fn largest_eigenvalue(c: &[[f64; 3]; 3]) -> f64 {
    let mean = (c[0][0] + c[1][1] + c[2][2]) / 3.0;
    let b: [[f64; 3]; 3] =
        std::array::from_fn(|i| std::array::from_fn(|j| c[i][j] - if i == j { mean } else { 0.0 }));
    let square = b.iter().flatten().map(|v| v * v).sum::<f64>() / 6.0;
    if !(square > 0.0) {
        return mean;
    }
    let p = square.sqrt();
    let m = Matrix3(b.map(|row| row.map(|v| v / p)));
    let half = 0.5 * m.determinant();
    mean + 2.0 * p * (half.clamp(-1.0, 1.0).acos() / 3.0).cos()
}

/// A low-pass for all axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct LowPass {
    /// Corner in Hz: −3.01 dB of a Butterworth low-pass; of one of linear phase the end of the band that passes.
    pub corner: f64,
    /// Which one.
    #[serde(default)]
    pub form: LowPassForm,
}

impl LowPass {
    /// The one of the chip, with this corner in Hz.
    pub fn new(corner: f64) -> Self {
        Self {
            corner,
            form: LowPassForm::default(),
        }
    }
}

/// Kinds of low-pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum LowPassForm {
    /// Butterworth of second order, as it runs on the chip.
    #[default]
    Butterworth,
    /// Finite impulse response with one delay at all frequencies, which is taken out exactly. Its gain differs from one, and behind the edge
    /// from zero, by what the attenuation of the chain allows.
    LinearPhase,
}

impl Chain {
    /// Whether anything is asked for.
    pub fn is_empty(&self) -> bool {
        self.rotation.is_none() && self.low_pass.is_none() && self.decimation.is_none()
    }

    /// What a reader of exported code must know, line by line.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if let Some(rotation) = &self.rotation {
            let [roll, pitch, yaw] = rotation.angles.map(f64::to_degrees);
            notes.push(format!(
                "In the frame of the machine: K is K R^T with R = R_z(yaw) R_y(pitch) R_x(roll), roll {roll:.6}, pitch {pitch:.6}, yaw {yaw:.6} deg."
            ));
            notes.push(
                "A bias that is tracked along the axes of the sensor is not to be subtracted behind this matrix."
                    .to_owned(),
            );
        }
        if self.low_pass.is_some() {
            let kept = match self.decimation {
                Some(factor) => format!(", one of {factor} samples"),
                None => String::new(),
            };
            notes.push(format!(
                "Order: calibration, rotation in its matrix, low-pass{kept}."
            ));
        }
        notes
    }

    /// Refuses what cannot be done with so many axes, before anything is read.
    ///
    /// # Errors
    /// A rotation of other axes than three, angles that are none, a corner that is none, a decimation by 0 or 1 or without a low-pass, an
    /// attenuation outside 20 to 160 dB.
    pub fn check(&self, axes: usize) -> Result<()> {
        if let Some(rotation) = &self.rotation {
            if axes != 3 {
                return Err(Trouble::request(format!(
                    "a rotation turns three axes, and the calibration is of {}",
                    match axes {
                        1 => "one".to_owned(),
                        n => n.to_string(),
                    }
                ))
                .with_hint("leave the rotation out, or give a calibration of three axes"));
            }
            rotation.matrix()?;
        }
        if let Some(low_pass) = &self.low_pass
            && !(low_pass.corner > 0.0 && low_pass.corner.is_finite())
        {
            return Err(Trouble::request(format!(
                "the corner of a low-pass cannot be {} Hz",
                low_pass.corner
            ))
            .with_hint("give a positive frequency below half of the sampling rate"));
        }
        if !(20.0..=160.0).contains(&self.attenuation) {
            return Err(Trouble::request(format!(
                "an attenuation of {} dB is not offered",
                self.attenuation
            ))
            .with_hint("give one from 20 dB to 160 dB"));
        }
        match (self.decimation, self.low_pass) {
            (Some(factor @ (0 | 1)), _) => Err(Trouble::request(format!(
                "the decimation factor is {factor}, and must be 2 or more"
            ))
            .with_hint("give a whole number from 2 on, or leave --decimate out")),
            (Some(factor), None) => Err(Trouble::request(format!(
                "a decimation by {factor} needs a low-pass: what lies above half of the new rate would appear as another frequency"
            ))
            .with_hint("add --low-pass HZ with the highest frequency that is wanted; with --linear-phase the band may be wider")),
            _ => Ok(()),
        }
    }
}
