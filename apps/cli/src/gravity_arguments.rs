//! Local gravity as options.

use crate::Failure;
use proofmass::core::{Gravity, STANDARD_GRAVITY};

/// Height in metres of a place that nobody stated, with its standard uncertainty.
const SOMEWHERE: (f64, f64) = (300.0, 300.0);

/// Local gravity.
#[derive(clap::Args)]
pub(crate) struct GravityArguments {
    /// Local gravity in m/s² [default: standard gravity, 9.80665]
    #[arg(long, value_name = "M_PER_S2", conflicts_with = "latitude")]
    gravity: Option<f64>,
    /// Its standard uncertainty in m/s² [default: 0.03 without a stated gravity, which covers the ground]
    #[arg(long, value_name = "M_PER_S2")]
    gravity_uncertainty: Option<f64>,
    /// Latitude of the place in degrees north: normal gravity there, in the place of --gravity
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    latitude: Option<f64>,
    /// Height of the place above the sea in metres [default: 300 with a standard uncertainty of 300]
    #[arg(
        long,
        value_name = "METRES",
        allow_negative_numbers = true,
        requires = "latitude"
    )]
    height: Option<f64>,
}

impl GravityArguments {
    /// Whether nobody states it, so that standard gravity stands for it.
    pub(crate) fn is_standard(&self) -> bool {
        self.gravity.is_none() && self.latitude.is_none()
    }

    /// Latitude in degrees and height in metres, where gravity is that of a place.
    pub(crate) fn place(&self) -> Option<[f64; 2]> {
        let height = self.height.unwrap_or(SOMEWHERE.0);
        self.latitude.map(|latitude| [latitude, height])
    }

    pub(crate) fn value(&self) -> Result<Gravity, Failure> {
        if let Some([latitude, height]) = self.place() {
            let give_or_take = self.height.map_or(SOMEWHERE.1, |_| 0.0);
            let normal = Gravity::normal(latitude, height, 0.0, give_or_take)?;
            return Ok(match self.gravity_uncertainty {
                Some(u) => Gravity::given(normal.value(), u)?,
                None => normal,
            });
        }
        let gravity = self.gravity.unwrap_or(STANDARD_GRAVITY);
        let u = match self.gravity_uncertainty {
            Some(u) => u,
            None if gravity == STANDARD_GRAVITY => 0.03,
            None => {
                return Err(
                    Failure::new("the uncertainty of the stated gravity is not known")
                        .hint("add --gravity-uncertainty; from a map it is 0.0001 m/s² or so"),
                );
            }
        };
        Ok(Gravity::given(gravity, u)?)
    }
}
