//! What is done to every sample, for three axes or one.

use proofmass_core::{AxisCompensation, Compensation};

/// The compensation of a calibration, of as many axes as it has.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one for a recording, and it stays Copy as what it holds"
)]
pub enum AnyCompensation {
    /// A single axis.
    OneAxis(AxisCompensation<f64>),
    /// Three axes and what they see of each other.
    ThreeAxes(Compensation<f64>),
}

impl AnyCompensation {
    /// Number of axes.
    pub fn axes(&self) -> usize {
        match self {
            Self::OneAxis(_) => 1,
            Self::ThreeAxes(_) => 3,
        }
    }

    /// That of three axes, where it is one.
    pub fn three_axes(&self) -> Option<&Compensation<f64>> {
        match self {
            Self::OneAxis(_) => None,
            Self::ThreeAxes(model) => Some(model),
        }
    }

    /// Reference temperature, °C, where it follows the temperature.
    pub fn reference(&self) -> Option<f64> {
        match self {
            Self::OneAxis(model) => model.thermal().map(|t| t.reference),
            Self::ThreeAxes(model) => model.thermal().map(|t| t.reference),
        }
    }

    /// Every sample; at the reference temperature where none is given.
    ///
    /// **Shapes** a column of outputs for each axis and one of temperatures in °C, of one length; as many columns of accelerations.
    pub fn apply_columns(&self, outputs: &[&[f64]], temperature: Option<&[f64]>) -> Vec<Vec<f64>> {
        let reference = self.reference().unwrap_or(0.0);
        let at = |row: usize| temperature.map_or(reference, |t| t[row]);
        match self {
            Self::OneAxis(model) => {
                let rows = outputs[0].iter().enumerate();
                vec![rows.map(|(row, o)| model.apply(*o, at(row))).collect()]
            }
            Self::ThreeAxes(model) => {
                let rows = outputs[0].len();
                let mut columns: Vec<Vec<f64>> = (0..3).map(|_| Vec::with_capacity(rows)).collect();
                for row in 0..rows {
                    let a = model.apply(std::array::from_fn(|i| outputs[i][row]), at(row));
                    for (column, value) in columns.iter_mut().zip(a) {
                        column.push(value);
                    }
                }
                columns
            }
        }
    }

    /// The sensor itself: outputs from accelerations and the temperature.
    ///
    /// **Shapes** one value for each axis.
    pub fn invert(&self, acceleration: &[f64], temperature: f64) -> Vec<f64> {
        match self {
            Self::OneAxis(model) => vec![model.invert(acceleration[0], temperature)],
            Self::ThreeAxes(model) => {
                let a = std::array::from_fn(|i| acceleration[i]);
                model.invert(a, temperature).to_vec()
            }
        }
    }

    /// K, by rows.
    pub fn k(&self) -> Vec<Vec<f64>> {
        match self {
            Self::OneAxis(model) => vec![vec![model.scale()]],
            Self::ThreeAxes(model) => model.sensor().k().0.map(|r| r.to_vec()).to_vec(),
        }
    }

    /// K⁻¹, by rows.
    pub fn k_inverse(&self) -> Vec<Vec<f64>> {
        match self {
            Self::OneAxis(model) => vec![vec![1.0 / model.scale()]],
            Self::ThreeAxes(model) => model.sensor().k_inverse().0.map(|r| r.to_vec()).to_vec(),
        }
    }

    /// b.
    pub fn bias(&self) -> Vec<f64> {
        match self {
            Self::OneAxis(model) => vec![model.bias()],
            Self::ThreeAxes(model) => model.sensor().bias().to_vec(),
        }
    }
}
