//! What a person says of a recording that has no campaign.

use crate::Failure;
use crate::recording_arguments::{time_unit, unit};
use proofmass::io::{TimeUnit, Unit};
use proofmass::jobs::campaign::Draft;

/// Options of a recording without a campaign.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "A recording without a campaign")]
pub(crate) struct DraftArguments {
    /// Latitude in degrees north
    #[arg(
        long,
        value_name = "DEGREES",
        allow_negative_numbers = true,
        conflicts_with = "gravity"
    )]
    latitude: Option<f64>,
    /// Height above the sea in metres [default: 300 with a standard uncertainty of 300]
    #[arg(
        long,
        value_name = "METRES",
        allow_negative_numbers = true,
        requires = "latitude"
    )]
    height: Option<f64>,
    /// Local gravity in m/s²
    #[arg(long, value_name = "M_PER_S2", requires = "gravity_uncertainty")]
    gravity: Option<f64>,
    /// Its standard uncertainty in m/s²
    #[arg(long, value_name = "M_PER_S2", requires = "gravity")]
    gravity_uncertainty: Option<f64>,
    /// Columns of x, y and z by name or number (from 1) [default: found by their headings]
    #[arg(long, value_name = "X,Y,Z", value_delimiter = ',', num_args = 1)]
    columns: Option<Vec<String>>,
    /// Unit of these columns, where the headings do not say it: count, m/s², g, mg, V, …
    #[arg(long, value_parser = unit)]
    unit: Option<Unit>,
    /// Time column by name or number
    #[arg(long, value_name = "COLUMN")]
    time: Option<String>,
    /// Unit of the time column, where the heading does not say it: s, ms, us, ns
    #[arg(long, value_name = "UNIT", requires = "time", value_parser = time_unit)]
    time_unit: Option<TimeUnit>,
    /// Sampling rate in hertz, where there is no time column
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// Model: bias, bias-scale, triangular, symmetric
    #[arg(long, value_name = "MODEL")]
    model: Option<String>,
    /// Days of a logger on a wrist or a machine: calibrate from its still moments
    #[arg(long)]
    free_living: bool,
}

impl DraftArguments {
    pub(crate) fn draft(&self) -> Draft {
        Draft {
            columns: self
                .columns
                .as_ref()
                .and_then(|c| <[String; 3]>::try_from(c.clone()).ok()),
            unit: self.unit,
            time: self.time.clone(),
            time_unit: self.time_unit,
            rate_hz: self.rate,
            gravity: self.gravity.zip(self.gravity_uncertainty),
            latitude_deg: self.latitude,
            height_m: self.height,
            model: self.model.clone(),
            free_living: self.free_living,
        }
    }

    /// A campaign says all of this itself.
    pub(crate) fn refuse_with_a_campaign(&self) -> Result<(), Failure> {
        if self.draft() == Draft::default() {
            return Ok(());
        }
        Err(
            Failure::new("a campaign says itself what its recordings are and where they were made")
                .hint("write it into campaign.toml, or name the recording instead of the campaign"),
        )
    }
}
