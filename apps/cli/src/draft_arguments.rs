//! What a person says of a recording that has no campaign.

use crate::Failure;
use clap::builder::PossibleValuesParser;
use proofmass::io::{TimeUnit, Unit};
use proofmass::jobs::StatedMarks;
use proofmass::jobs::campaign::{Draft, MethodModel, RowsAre};

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
    #[arg(long, value_name = "X,Y,Z", value_parser = axes)]
    columns: Option<[String; 3]>,
    /// Unit of these columns, where the headings do not say it: count, m/s², g, mg, V, …
    #[arg(long)]
    unit: Option<Unit>,
    /// Time column by name or number
    #[arg(long, value_name = "COLUMN")]
    time: Option<String>,
    /// Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with --rate)
    #[arg(long, value_name = "UNIT")]
    time_unit: Option<TimeUnit>,
    /// Sampling rate in hertz, where there is no time column
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// Stream of a file that holds several, by its name as `proofmass inspect` lists it
    #[arg(long, value_name = "NAME")]
    source: Option<String>,
    #[command(flatten)]
    marks: StatedMarks,
    /// Read the rows from one time on and before another, in seconds
    #[arg(long, num_args = 2, value_names = ["FROM", "TO"], allow_negative_numbers = true)]
    between: Option<Vec<f64>>,
    /// What a row is: a sample (static intervals are found), one reading in one position, a sample of a slow tumble
    #[arg(
        long,
        value_enum,
        default_value = "samples",
        conflicts_with = "free_living"
    )]
    rows: Rows,
    /// Temperature column in °C by name or number
    #[arg(long, value_name = "COLUMN")]
    temperature: Option<String>,
    /// Model: bias, bias-scale, triangular, symmetric; with given attitudes also full
    #[arg(
        long,
        value_name = "MODEL",
        hide_possible_values = true,
        value_parser = PossibleValuesParser::new(MethodModel::ALL.map(MethodModel::name))
    )]
    model: Option<String>,
    /// Standard uncertainty of the attitudes that a table of readings gives, in degrees
    #[arg(long, value_name = "DEGREES")]
    attitude_uncertainty: Option<f64>,
    /// Standard uncertainty of each component of the true accelerations a_true_x … of a table of readings, in m/s²
    #[arg(long, value_name = "M_PER_S2")]
    a_true_uncertainty: Option<f64>,
    /// Days of a logger on a wrist or a machine: calibrate from its still moments
    #[arg(long)]
    free_living: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Rows {
    Samples,
    Readings,
    Tumble,
}

impl DraftArguments {
    pub(crate) fn draft(&self) -> Draft {
        let mut draft = Draft::default();
        draft.columns = self.columns.clone();
        draft.unit = self.unit;
        draft.time = self.time.clone();
        draft.time_unit = self.time_unit;
        draft.rate_hz = self.rate;
        draft.source = self.source.clone();
        draft.marks = self.marks.clone();
        draft.between = self
            .between
            .as_deref()
            .and_then(|b| b.first_chunk().copied());
        draft.rows = match self.rows {
            Rows::Samples => RowsAre::Samples,
            Rows::Readings => RowsAre::Readings,
            Rows::Tumble => RowsAre::Tumble,
        };
        draft.temperature = self.temperature.clone();
        draft.gravity = self.gravity.zip(self.gravity_uncertainty);
        draft.latitude_deg = self.latitude;
        draft.height_m = self.height;
        draft.model = self.model.clone();
        draft.attitude_uncertainty_deg = self.attitude_uncertainty;
        draft.a_true_uncertainty = self.a_true_uncertainty;
        draft.free_living = self.free_living;
        draft
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

fn axes(text: &str) -> Result<[String; 3], String> {
    let words: Vec<String> = text.split(',').map(|w| w.trim().to_owned()).collect();
    <[String; 3]>::try_from(words).map_err(|words| {
        format!(
            "{} columns are named; x, y and z are three, such as 2,3,4",
            words.len()
        )
    })
}
