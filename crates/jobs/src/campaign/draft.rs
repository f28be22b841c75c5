//! A campaign written from a recording: what can be seen in it, and what has to be said.

use super::{Campaign, CampaignFile, RowsAre};
use crate::store::{Folder, Store};
use crate::stream_choice::StatedMarks;
use proofmass_io::{
    ClockUnit, ColumnRef, Error, ErrorKind, Layout, LayoutOptions, Result, Source, TimeUnit, Unit,
    split_heading,
};
use proofmass_static::Standstill;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What is known of a recording beside the recording itself.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
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
    /// Stream of a file that holds several.
    pub source: Option<String>,
    /// Marks of its text.
    pub marks: StatedMarks,
    /// Stretch of the recording that is read, s.
    pub between: Option<[f64; 2]>,
    /// Standard uncertainty of a given attitude about each transverse axis, degrees.
    pub attitude_uncertainty_deg: Option<f64>,
    /// Standard uncertainty of each component of a true acceleration, m/s².
    pub a_true_uncertainty: Option<f64>,
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
        let source = Source::open(recording)?;
        let mut source = source.with_stream(self.source.as_deref(), false);
        self.marks.mark(&mut source);
        let layout = Layout::of(&mut source, &LayoutOptions::default())?;
        let columns = self.columns.clone().or_else(|| axes(&layout).ok());
        let signals = columns
            .iter()
            .flatten()
            .map(|column| layout.find(&ColumnRef::from_word(column)))
            .collect::<Result<Vec<_>>>()?;
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
        line(super::schema_line(kind));
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
        match &columns {
            Some([x, y, z]) => line(format!(
                "columns = {{ x = {}, y = {}, z = {} }}",
                column(x),
                column(y),
                column(z)
            )),
            None => line(format!(
                "# columns = {{ x = …, y = …, z = … }}  # by heading or number; {}",
                columns_of(&layout)
            )),
        }
        match (&time, self.rate_hz) {
            (Some(time), _) => {
                line(format!("time = {}", column(time)));
                let likely = || {
                    let index = layout.find(&ColumnRef::from_word(time)).ok()?;
                    ClockUnit::open(&layout, index, None, self.rate_hz)
                };
                if let Some(unit) = self.time_unit {
                    line(format!("time_unit = \"{unit}\""));
                } else if let Some((unit, _)) = likely() {
                    line(format!(
                        "# time_unit = \"{unit}\"             # likely, by the size of the steps; or s, ms, us, ns, min, h, d, index"
                    ));
                }
                // Beside a clock it is refused, as in every other command.
                if let Some(rate) = self.rate_hz {
                    line(format!("sampling_rate_Hz = {rate}"));
                }
            }
            (None, Some(rate)) => line(format!("sampling_rate_Hz = {rate}")),
            (None, None) if self.rows == RowsAre::Readings => {}
            (None, None) => line(
                "# sampling_rate_Hz = …         # no time column was found: say how many samples a second"
                    .into(),
            ),
        }
        if let Some(name) = &self.source {
            line(format!("source = {name:?}"));
        }
        for (key, word) in self.marks.words() {
            line(format!("{key} = \"{word}\""));
        }
        if let Some([from, to]) = self.between {
            line(format!("between_s = [{from:?}, {to:?}]"));
        }
        let first = signals.first().and_then(|&i| layout.unit(i));
        match (self.unit, first) {
            (Some(unit), _) => line(format!("unit = \"{}\"", unit.ascii())),
            (None, Some(unit)) => line(format!("# unit: {unit}, by the heading")),
            (None, None) => line(match layout.likely_unit(&signals) {
                Some(likely) => format!(
                    "# unit = \"{}\"               # likely, by the size of the outputs; or \"m/s²\", \"g\", \"mg\", \"count\", \"V\"",
                    likely.ascii()
                ),
                None => "# unit = \"…\"                  # m/s², g, mg, count, V, …".to_owned(),
            }),
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
            RowsAre::Readings => {
                line("rows = \"readings\"".into());
                line("# attitudes: columns direction (+x, +x+y), up_x … up_z, roll_deg and pitch_deg, or a_true_x_m/s2 … and u_a_true_m/s2".into());
            }
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
        if self.rows == RowsAre::Samples {
            line(format!("# {}", self.shortest_hold()));
        }
        line("# exclude = [13]                # by number, or by label".into());
        line("# segments = \"segments.csv\"    # where standstills and attitudes are known".into());
        line(String::new());
        line("[method]".into());
        match &self.model {
            Some(model) => line(format!("model = {model:?}")),
            None => line("# model = \"triangular\"        # bias, bias-scale, triangular, symmetric, full, six-position".into()),
        }
        let stated = [
            ("standard_uncertainty_deg", self.attitude_uncertainty_deg),
            ("a_true_standard_uncertainty", self.a_true_uncertainty),
        ];
        if stated.iter().any(|(_, u)| u.is_some()) {
            line(String::new());
            line("[attitude]".into());
            for (key, u) in stated {
                if let Some(u) = u {
                    line(format!("{key} = {u:?}"));
                }
            }
        }
        Ok(text)
    }

    /// How long an attitude is held, by the rate where it is known.
    fn shortest_hold(&self) -> String {
        let of = |rate: f64| Standstill::default().shortest_hold(rate);
        match self.rate_hz.filter(|rate| *rate > 0.0 && rate.is_finite()) {
            Some(rate) => format!("hold each attitude for {:.1} s or longer", of(rate)),
            None => format!(
                "hold each attitude for {:.1} s or longer at 50 samples per second and more, {:.1} s at five",
                of(50.0),
                of(5.0)
            ),
        }
    }

    /// Everything that neither the recording nor the draft says, in one refusal with the command to type.
    fn check(&self, recording: &Path) -> Result<()> {
        let source = Source::open(recording)?;
        let mut source = source.with_stream(self.source.as_deref(), false);
        self.marks.mark(&mut source);
        let layout = Layout::of(&mut source, &LayoutOptions::default())?;
        let mut missing: Vec<(String, String)> = Vec::new();
        if !self.free_living && self.gravity.is_none() && self.latitude_deg.is_none() {
            missing.push((
                "where it was made".to_owned(),
                "--latitude DEGREES --height METRES".to_owned(),
            ));
        }
        let columns = match &self.columns {
            Some(columns) => Some(columns.clone()),
            None => match axes(&layout) {
                Ok(columns) => Some(columns),
                Err(several) => {
                    let error = no_axes(&layout, several);
                    missing.push((
                        format!("{error} ({})", columns_of(&layout)),
                        "--columns X,Y,Z".to_owned(),
                    ));
                    None
                }
            },
        };
        let find = |word: &String| {
            let index = layout.find(&ColumnRef::from_word(word));
            index.map_err(|e| e.at(recording))
        };
        let signals: Vec<usize> = columns.iter().flatten().map(find).collect::<Result<_>>()?;
        let unsaid = Unsaid {
            signals: &signals,
            unit: self.unit,
            time: self.time.as_ref().map(find).transpose()?,
            time_unit: self.time_unit,
            rate_hz: self.rate_hz,
            timeless: self.rows == RowsAre::Readings,
        };
        let unknown = match columns {
            None => unsaid.unit_of_unknown(&layout),
            Some(_) => None,
        };
        let list = unsaid.list(&layout).map_err(|e| e.at(recording))?;
        for (what, option, _) in unknown.into_iter().chain(list) {
            missing.push((what, option));
        }
        if missing.is_empty() {
            return Ok(());
        }
        let (what, options): (Vec<_>, Vec<_>) = missing.into_iter().unzip();
        let what = match what.as_slice() {
            [one] if one == "where it was made" => {
                "a recording alone does not say where it was made".to_owned()
            }
            [one] => one.clone(),
            all => format!("a recording alone does not say all: {}", all.join("; ")),
        };
        let words = match options.iter().any(|o| o == "--rate HZ") {
            true => {
                " (--time COLUMN in place of --rate; --rows readings where every row is a mean or a single reading in an attitude of its own)"
            }
            false => "",
        };
        Err(Error::new(ErrorKind::Configuration, what)
            .at(recording)
            .with_hint(format!(
                "add {}{words} to the command; or write a campaign: proofmass init {}",
                options.join(" "),
                recording.display()
            )))
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
                line("# latitude_deg = …             # where it was recorded, degrees north, and the height above the sea".into());
                line("# height_m = …".into());
                line("# value = …                    # or local gravity, m/s²".into());
                line("# standard_uncertainty = …".into());
            }
        }
    }

    /// The campaign of a recording, without a file.
    ///
    /// # Errors
    /// As [`Draft::text`] and [`Campaign::open`].
    pub fn campaign(&self, recording: &Path) -> Result<Campaign> {
        self.check(recording)?;
        let folder = recording.parent().unwrap_or(Path::new(""));
        let store = Drafted {
            text: self.text(recording)?,
            name: format!("{} (as a campaign)", recording.display()),
            folder: Folder::new(folder),
        };
        let mut file = CampaignFile::read(Arc::new(store), CAMPAIGN)?;
        file.drafted_from = Some(recording.to_path_buf());
        Campaign::of(file)
    }
}

/// The option behind a key of a drafted campaign; any other word is a value that was typed.
pub(super) fn option_of(key: &str) -> String {
    const OPTIONS: [(&str, &str); 16] = [
        ("latitude_deg", "--latitude"),
        ("height_m", "--height"),
        ("value", "--gravity"),
        ("standard_uncertainty", "--gravity-uncertainty"),
        ("columns", "--columns"),
        ("time", "--time"),
        ("time_unit", "--time-unit"),
        ("sampling_rate_Hz", "--rate"),
        ("between_s", "--between"),
        ("source", "--source"),
        ("separator", "--separator"),
        ("decimal", "--decimal"),
        ("temperature", "--temperature"),
        ("model", "--model"),
        ("standard_uncertainty_deg", "--attitude-uncertainty"),
        ("a_true_standard_uncertainty", "--a-true-uncertainty"),
    ];
    let name = key.rsplit('.').next().unwrap_or(key);
    let option = OPTIONS.iter().find(|(own, _)| *own == name);
    option.map_or_else(|| format!("{key:?}"), |(_, option)| (*option).to_owned())
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

/// What is said of the unit and the clock of a recording.
pub(crate) struct Unsaid<'a> {
    /// Columns of the outputs.
    pub(crate) signals: &'a [usize],
    /// Their unit.
    pub(crate) unit: Option<Unit>,
    /// Column of the times.
    pub(crate) time: Option<usize>,
    /// Its unit.
    pub(crate) time_unit: Option<TimeUnit>,
    /// Samples per second.
    pub(crate) rate_hz: Option<f64>,
    /// Whether rows have an order and no clock.
    pub(crate) timeless: bool,
}

impl Unsaid<'_> {
    /// What neither the recording nor anybody says: what it is, the option and the line of a campaign that say it.
    pub(crate) fn list(&self, layout: &Layout) -> Result<Vec<(String, String, String)>> {
        let mut list = Vec::new();
        // Of those alone whose heading does not say it.
        let signals = self.signals.iter().copied();
        let open: Vec<usize> = signals.filter(|i| layout.unit(*i).is_none()).collect();
        if self.unit.is_none() && !open.is_empty() {
            let likely = layout.likely_unit(&open);
            let word = likely.map_or("UNIT", Unit::ascii);
            list.push((
                layout.ask_unit(&open).to_string(),
                format!("--unit {word}"),
                format!("unit = \"{word}\""),
            ));
        }
        let time = match self.rate_hz {
            Some(_) => self.time,
            None => self.time.or_else(|| layout.time_column()),
        };
        match time {
            None if self.rate_hz.is_none() && !self.timeless => list.push((
                layout.ask_clock().to_string(),
                "--rate HZ".to_owned(),
                "sampling_rate_Hz = HZ".to_owned(),
            )),
            Some(index) => {
                if let Err(error) =
                    ClockUnit::of(layout, index, self.time_unit, self.rate_hz, false)
                {
                    let open = ClockUnit::open(layout, index, self.time_unit, self.rate_hz);
                    let Some((unit, rates)) = open else {
                        return Err(error);
                    };
                    let mut said = [
                        format!("--time-unit {unit}"),
                        format!("time_unit = \"{unit}\""),
                    ];
                    if unit == TimeUnit::Index {
                        said[0].push_str(" --rate HZ");
                        said[1].push_str(", sampling_rate_Hz = HZ");
                    }
                    let [option, key] = said;
                    list.push((format!("{error}, which is {rates}"), option, key));
                }
            }
            None => {}
        }
        Ok(list)
    }

    /// The unit of columns that nobody named: asked for where no heading says that of an acceleration.
    fn unit_of_unknown(&self, layout: &Layout) -> Option<(String, String, String)> {
        let says = |i| {
            layout
                .unit(i)
                .is_some_and(|u| u.is_acceleration() || u.is_raw())
        };
        let asked = self.unit.is_none() && !(0..layout.columns).any(says);
        asked.then(|| {
            (
                "their unit is not said".to_owned(),
                "--unit UNIT".to_owned(),
                "unit = \"UNIT\"".to_owned(),
            )
        })
    }

    /// One refusal for all of it where more than one thing is missing, with the options that say it.
    pub(crate) fn ask(&self, layout: &Layout) -> Result<()> {
        self.ask_beside(layout, None)
    }

    /// The same beside columns that are not known, with the refusal and the option that names them.
    pub(crate) fn ask_beside(
        &self,
        layout: &Layout,
        columns: Option<(&Error, &str)>,
    ) -> Result<()> {
        let mut list = Vec::new();
        if let Some((error, option)) = columns {
            list.push((error.to_string(), option.to_owned(), String::new()));
            list.extend(self.unit_of_unknown(layout));
        }
        list.extend(self.list(layout)?);
        if list.len() < 2 {
            return Ok(());
        }
        let what: Vec<&str> = list.iter().map(|l| l.0.as_str()).collect();
        let options: Vec<&str> = list.iter().map(|l| l.1.as_str()).collect();
        let words = match options.contains(&"--rate HZ") {
            true => " (--time COLUMN in place of --rate)",
            false => "",
        };
        Err(Error::new(
            ErrorKind::Configuration,
            format!(
                "some properties of the recording are missing: {}",
                what.join("; ")
            ),
        )
        .with_hint(format!("add {}{words}", options.join(" "))))
    }

    /// One refusal for all of it, with the lines to write into the campaign; `place` is what is not known of gravity.
    pub(crate) fn refuse(&self, layout: &Layout, place: bool) -> Result<()> {
        let list = self.list(layout)?;
        if list.is_empty() && !place {
            return Ok(());
        }
        let mut what: Vec<String> = list.iter().map(|l| l.0.clone()).collect();
        let lines: Vec<&str> = list.iter().map(|l| l.2.as_str()).collect();
        let mut hints = Vec::new();
        if !lines.is_empty() {
            hints.push(format!("{} to [recording]", lines.join(", ")));
        }
        if place {
            what.push("local gravity is not known".to_owned());
            hints.push(
                "latitude_deg = DEGREES and height_m = METRES (or value = … and standard_uncertainty = …) to [gravity]"
                    .to_owned(),
            );
        }
        let what = match what.as_slice() {
            [one] => one.clone(),
            all => format!(
                "some properties of the recording are missing: {}",
                all.join("; ")
            ),
        };
        Err(Error::new(ErrorKind::Configuration, what)
            .with_hint(format!("in the campaign add {}", hints.join(", and "))))
    }
}

/// The columns of x, y and z have to be named.
pub(crate) fn no_axes(layout: &Layout, several: bool) -> Error {
    let what = match (several, &layout.header) {
        (true, Some(_)) => "more than one sensor may be meant by x, y and z",
        (true, None) => "without headings it is not known which columns x, y and z are",
        (false, _) => "it is not known which columns are x, y and z",
    };
    Error::new(ErrorKind::Column, what).with_hint(format!(
        "name them with --columns X,Y,Z, by heading or number; {}",
        columns_of(layout)
    ))
}

/// The columns of a file, for somebody who has to choose.
fn columns_of(layout: &Layout) -> String {
    let names = layout.header.as_ref();
    format!(
        "the file has {} columns{}",
        layout.columns,
        names.map_or(String::new(), |h| format!(": {}", h.join(", ")))
    )
}

/// Three neighbouring headings that differ in x, y, z alone, an acceleration before others, and no gyroscope or magnetometer;
/// without headings the three columns there are, beside a time. `Err` tells whether several sensors may be meant.
pub(crate) fn axes(layout: &Layout) -> std::result::Result<[String; 3], bool> {
    let Some(header) = &layout.header else {
        return match layout.columns {
            3 => Ok(std::array::from_fn(|i| (i + 1).to_string())),
            columns => Err(columns > 3),
        };
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
            && !is_other_sensor(&stems[0], layout.unit(i))
        {
            let acceleration = layout.unit(i).is_some_and(Unit::is_acceleration)
                || words(&stems[0]).any(|w| w.starts_with("acc") || w == "a");
            found.push((!acceleration, i));
        }
    }
    let first = found.iter().map(|f| f.0).min().ok_or(false)?;
    let mut alike = found.iter().filter(|f| f.0 == first);
    match (alike.next(), alike.next()) {
        (Some(&(_, i)), None) => Ok(std::array::from_fn(|k| header[i + k].clone())),
        _ => Err(true),
    }
}

/// Words of a heading: `imu.gyro.` are two.
fn words(heading: &str) -> impl Iterator<Item = &str> {
    heading
        .split(|c: char| !c.is_alphabetic())
        .filter(|word| !word.is_empty())
}

/// Whether the headings are those of a gyroscope, a magnetometer or something else that is no accelerometer.
fn is_other_sensor(stem: &str, unit: Option<Unit>) -> bool {
    const OTHERS: [&str; 14] = [
        "gyr", "omega", "mag", "rot", "angular", "ang", "rate", "quat", "euler", "vel", "pos",
        "field", "compass", "b_",
    ];
    let other = unit.is_some_and(|u| !u.is_acceleration() && !u.is_raw());
    other
        || words(stem).any(|word| {
            matches!(word, "w" | "g" | "m" | "q" | "true" | "up")
                || OTHERS.iter().any(|o| word.starts_with(o))
        })
}
