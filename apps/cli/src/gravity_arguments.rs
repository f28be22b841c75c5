//! Local gravity as options.

use crate::Failure;
use proofmass::core::{Gravity, STANDARD_GRAVITY};

/// Local gravity.
#[derive(clap::Args)]
pub(crate) struct GravityArguments {
    /// Local gravity in m/s² [default: standard gravity, 9.80665]
    #[arg(long, value_name = "M_PER_S2")]
    gravity: Option<f64>,
    /// Its standard uncertainty in m/s² [default: 0.03 without a stated gravity, which covers the ground]
    #[arg(long, value_name = "M_PER_S2")]
    gravity_uncertainty: Option<f64>,
}

impl GravityArguments {
    /// Whether nobody states it, so that standard gravity stands for it.
    pub(crate) fn is_standard(&self) -> bool {
        self.gravity.is_none()
    }

    pub(crate) fn value(&self) -> Result<Gravity, Failure> {
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
