//! A campaign written from a recording: what can be seen in it, and what has to be said.

use super::{Campaign, CampaignFile, RowsAre};
use crate::store::{Folder, Store};
use proofmass_io::{
    ColumnRef, Error, ErrorKind, Layout, LayoutOptions, Result, Source, TimeUnit, Unit,
    split_heading,
};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What is known of a recording beside the recording itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Draft {
    /// Columns of x, y, z by name or number; found by their headings where they are not given.
    pub columns: Option<[String; 3]>,
    /// Unit of the outputs, where the headings do not say it.
    pub unit: Option<Unit>,
    /// Time column by name or number.
    pub time: Option<String>,
    /// Unit of the time column.
    pub time_unit: Option<TimeUnit>,
    /// Samples per second, where there is no time column.
    pub rate_hz: Option<f64>,
    /// What a row is.
    pub rows: RowsAre,
    /// Temperature column by name or number, °C.
    pub temperature: Option<String>,
    /// Local gravity and its standard uncertainty, m/s².
    pub gravity: Option<(f64, f64)>,
    /// Latitude, degrees north.
    pub latitude_deg: Option<f64>,
    /// Height above the sea, m; unknown: 300 m with a standard uncertainty of 300 m.
    pub height_m: Option<f64>,
    /// Model of the fit.
    pub model: Option<String>,
    /// Whether it is days of a logger, calibrated from its still moments.
    pub free_living: bool,
}

impl Draft {
    /// The text of a campaign for a recording, with comments.
    ///
    /// # Errors
    /// A file that cannot be read, or whose columns cannot be told.
    pub fn text(&self, recording: &Path) -> Result<String> {
        let mut source = Source::open(recording)?;
        let layout = Layout::of(&mut source, &LayoutOptions::default())?;
        let columns = match &self.columns {
            Some(columns) => columns.clone(),
            None => axes(&layout).ok_or_else(|| {
                Error::new(
                    ErrorKind::Column,
                    "the columns of x, y and z cannot be told",
                )
                .at(recording)
                .with_hint(format!(
                    "name them, by heading or number; the file has {} columns{}",
                    layout.columns,
                    layout
                        .header
                        .as_ref()
                        .map_or(String::new(), |h| format!(": {}", h.join(", ")))
                ))
            })?,
        };
        let first = layout.find(&ColumnRef::from_word(&columns[0]))?;
        let time = match &self.time {
            Some(time) => Some(time.clone()),
            None if self.rate_hz.is_some() => None,
            None => layout.time_column().map(|i| {
                layout
                    .header
                    .as_ref()
                    .map_or((i + 1).to_string(), |h| h[i].clone())
            }),
        };
        let name = recording
            .file_name()
            .map(|n| n.to_string_lossy().into_owned())
            .unwrap_or_default();
        let mut text = String::new();
        let mut line = |s: String| {
            let _ = writeln!(text, "{s}");
        };
        let kind = if self.free_living {
            "free-living"
        } else {
            "multi-position"
        };
        line(format!("kind = {kind:?}"));
        line("# title = \"…\"".into());
        line(String::new());
        line("[device]".into());
        for key in ["manufacturer", "model", "serial"] {
            line(format!("# {key} = \"…\""));
        }
        line(String::new());
        line("[recording]".into());
        line(format!("file = {name:?}"));
        let column = |word: &str| match word.parse::<usize>() {
            Ok(number) => number.to_string(),
            Err(_) => format!("{word:?}"),
        };
        line(format!(
            "columns = {{ x = {}, y = {}, z = {} }}",
            column(&columns[0]),
            column(&columns[1]),
            column(&columns[2])
        ));
        match (&time, self.rate_hz) {
            (Some(time), _) => {
                line(format!("time = {}", column(time)));
                if let Some(unit) = self.time_unit {
                    let word = match unit {
                        TimeUnit::Millisecond => "ms",
                        TimeUnit::Microsecond => "us",
                        TimeUnit::Nanosecond => "ns",
                        TimeUnit::Index => "index",
                        _ => "s",
                    };
                    line(format!("time_unit = {word:?}"));
                }
            }
            (None, Some(rate)) => line(format!("sampling_rate_Hz = {rate}")),
            (None, None) if self.rows == RowsAre::Readings => {}
            (None, None) => line(
                "sampling_rate_Hz = 100 # no time column was found: say how many samples a second"
                    .into(),
            ),
        }
        match (self.unit, layout.unit(first)) {
            (Some(unit), _) => line(format!("unit = \"{}\"", unit.ascii())),
            (None, Some(unit)) => line(format!("# unit: {unit}, by the heading")),
            (None, None) => {
                line("unit = \"count\" # or \"m/s²\", \"g\", \"mg\": what the outputs are".into())
            }
        }
        match &self.temperature {
            Some(temperature) => line(format!("temperature = {}", column(temperature))),
            None => line("# temperature = \"…\"            # a column in °C".into()),
        }
        if self.free_living {
            line(String::new());
            if self.gravity.is_none() && self.latitude_deg.is_none() {
                line("# [gravity] # where it was worn; without it anywhere on the ground, 0.3 % of every scale factor".into());
                line("# latitude_deg = 45".into());
                line("# height_m = 100".into());
            } else {
                self.place(&mut line);
            }
            return Ok(text);
        }
        line("# range = [-32768, 32767]       # of the converter".into());
        match self.rows {
            RowsAre::Samples => {
                line("# rows = \"readings\"           # every row a mean or a single reading in an attitude of its own".into());
                line(
                    "# rows = \"tumble\"             # turned slowly all the time, no standstills"
                        .into(),
                );
            }
            RowsAre::Readings => line("rows = \"readings\"".into()),
            RowsAre::Tumble => line("rows = \"tumble\"".into()),
        }
        line(
            "# files = [\"a.csv\", …] with each_file = \"standstill\": one file per attitude"
                .into(),
        );
        line(String::new());
        self.place(&mut line);
        line(String::new());
        line("[standstill]".into());
        line("# exclude = [13]                # by number, or by label".into());
        line("# segments = \"segments.csv\"    # where standstills and attitudes are known".into());
        line(String::new());
        line("[method]".into());
        match &self.model {
            Some(model) => line(format!("model = {model:?}")),
            None => line("# model = \"triangular\"        # bias, bias-scale, triangular, symmetric, full, six-position".into()),
        }
        Ok(text)
    }

    /// Samples have a time; a rate is not made up.
    fn check_time(&self, recording: &Path) -> Result<()> {
        if self.rate_hz.is_some() || self.time.is_some() || self.rows == RowsAre::Readings {
            return Ok(());
        }
        let layout = Layout::of(&mut Source::open(recording)?, &LayoutOptions::default())?;
        match layout.time_column() {
            Some(_) => Ok(()),
            None => Err(Error::new(
                ErrorKind::Column,
                "no time column is found, and the sampling rate is not known",
            )
            .at(recording)
            .with_hint("add --rate HZ or --time COLUMN; or --rows readings, where every row is a mean or a single reading in an attitude of its own")),
        }
    }

    /// Table `[gravity]`.
    fn place(&self, line: &mut dyn FnMut(String)) {
        line("[gravity]".into());
        match (self.gravity, self.latitude_deg) {
            (Some((value, u)), _) => {
                line(format!("value = {value}"));
                line(format!("standard_uncertainty = {u}"));
            }
            (None, Some(latitude)) => {
                line(format!("latitude_deg = {latitude}"));
                match self.height_m {
                    Some(height) => line(format!("height_m = {height}")),
                    None => {
                        line("height_m = 300 # not known: 300 m ± 300 m".into());
                        line("height_standard_uncertainty_m = 300".into());
                    }
                }
            }
            (None, None) => {
                line("latitude_deg = 45 # yours, and the height above the sea; or value and standard_uncertainty".into());
                line("height_m = 100".into());
            }
        }
    }

    /// The campaign of a recording, without a file.
    ///
    /// # Errors
    /// As [`Draft::text`] and [`Campaign::open`].
    pub fn campaign(&self, recording: &Path) -> Result<Campaign> {
        self.check_time(recording)?;
        let folder = recording.parent().unwrap_or(Path::new(""));
        let store = Drafted {
            text: self.text(recording)?,
            name: format!("{} (as a campaign)", recording.display()),
            folder: Folder::new(folder),
        };
        Campaign::of(CampaignFile::read(Arc::new(store), CAMPAIGN)?)
    }
}

/// Name under which a drafted campaign stands in its store; no file of a person is called so.
const CAMPAIGN: &str = "\u{0}campaign.toml";

/// A folder with a campaign that is not in it.
struct Drafted {
    text: String,
    name: String,
    folder: Folder,
}

impl Store for Drafted {
    fn open(&self, name: &str) -> Result<Source> {
        if name == CAMPAIGN {
            return Source::from_bytes(self.name.clone(), self.text.as_bytes().to_vec());
        }
        self.folder.open(name)
    }

    fn holds(&self, name: &str) -> bool {
        name == CAMPAIGN || self.folder.holds(name)
    }

    fn describe(&self, name: &str) -> PathBuf {
        if name == CAMPAIGN {
            return PathBuf::from(&self.name);
        }
        self.folder.describe(name)
    }
}

/// Three neighbouring headings that differ in x, y, z alone, those that speak of acceleration first; without headings the
/// first three columns, or the three after a time.
fn axes(layout: &Layout) -> Option<[String; 3]> {
    let Some(header) = &layout.header else {
        let first = usize::from(layout.time_column() == Some(0) || layout.columns == 4);
        return (layout.columns >= first + 3)
            .then(|| std::array::from_fn(|i| (first + i + 1).to_string()));
    };
    let names: Vec<String> = header
        .iter()
        .map(|h| split_heading(h).0.to_lowercase())
        .collect();
    let without = |name: &str, letter: char| {
        let at = name.rfind(letter)?;
        Some(format!("{}{}", &name[..at], &name[at + 1..]))
    };
    let mut found: Vec<(bool, usize)> = Vec::new();
    for i in 0..names.len().saturating_sub(2) {
        let stems: Option<Vec<String>> = ['x', 'y', 'z']
            .into_iter()
            .enumerate()
            .map(|(k, letter)| without(&names[i + k], letter))
            .collect();
        if let Some(stems) = stems
            && stems[0] == stems[1]
            && stems[1] == stems[2]
        {
            let rate = ["gyr", "omega", "w", "mag", "rot"];
            let other = rate.iter().any(|word| stems[0].starts_with(word));
            found.push((
                other || !(stems[0].is_empty() || stems[0].starts_with('a')),
                i,
            ));
        }
    }
    let (_, i) = found.into_iter().min()?;
    Some(std::array::from_fn(|k| header[i + k].clone()))
}
