//! `campaign.toml`: what was measured, with what, and how it is to be evaluated. One file per kind.

mod draft;
mod example;
mod free_living;
mod head;
mod multi_position;
mod shaker;
mod shaker_primary;
mod shaker_single;
mod shaker_triaxial;
mod single_axis;
mod spurious_motion;
mod statement;
mod text_table;
mod transverse;

pub use draft::Draft;
pub(crate) use draft::{Unsaid, axes, no_axes};
pub use example::example;
pub use free_living::FreeLivingCampaign;
pub use multi_position::{MethodModel, MethodTable, MultiPositionCampaign, RowsAre};
pub use shaker::{Certificate, CertificateOptions, SpuriousFile};
pub use shaker_primary::ShakerPrimaryCampaign;
pub use shaker_single::ShakerSingleCampaign;
pub use shaker_triaxial::{ShakerTable, ShakerTriaxialCampaign};
pub use single_axis::SingleAxisCampaign;
pub use spurious_motion::SpuriousMotionCampaign;
pub use transverse::TransverseCampaign;

pub(crate) use free_living::StreamFormat;
pub(crate) use multi_position::{FileIs, GravityInput, Prefixes};
pub(crate) use shaker::{
    Conditioner, Mounting, MountingRatio, OutputRecording, PhasorQuantity, RunData, RunPhasor,
    RunTable, ShakerBudget, ShakerRecording, ShakerRun, SingleAxisSeat,
};

use crate::outcome::{Job as _, Outcome as _};
use crate::static_test::StaticTestOutcome;
use crate::store::{Folder, Memory, Store};
use crate::{StoredResult, trouble};
use proofmass_core::Watch;
use proofmass_io::{Error, ErrorKind, Input, LARGEST_DOCUMENT, Result, Source};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Declares the kinds, each with its word in the file and the way from its files to an outcome.
macro_rules! kinds {
    ($($(#[$doc:meta])* $name:ident($campaign:ty, $kind:literal, |$given:ident, $files:ident, $watching:ident| $outcome:expr),)*) => {
        /// Kinds that can be read, as written after `kind =`.
        pub const KINDS: &[&str] = &[$($kind),*];

        /// A campaign of any kind.
        #[derive(Clone, Debug, PartialEq)]
        #[non_exhaustive]
        pub enum Campaign {
            $($(#[$doc])* $name(Box<$campaign>),)*
        }

        /// The schema of each kind.
        #[cfg(feature = "schema")]
        pub(crate) fn campaign_schemas() -> Vec<(&'static str, crate::schema::Readable)> {
            vec![$(($kind, crate::schema::Readable::of::<$campaign>())),*]
        }

        impl Campaign {
            /// The campaign of a file that says of which kind it is; `None` for a kind that is not known.
            fn of_word(kind: &str, file: &CampaignFile) -> Result<Option<Self>> {
                match kind {
                    $($kind => {
                        let mut campaign: Box<$campaign> = Box::new(file.parse()?);
                        campaign.source = file.clone();
                        campaign.check()?;
                        Ok(Some(Self::$name(campaign)))
                    })*
                    _ => Ok(None),
                }
            }

            /// The kind as written in the file.
            pub fn kind(&self) -> &'static str {
                match self {
                    $(Self::$name(_) => $kind,)*
                }
            }

            /// The file it was read from.
            pub fn source(&self) -> &CampaignFile {
                match self {
                    $(Self::$name(campaign) => &campaign.source,)*
                }
            }

            /// Reads everything the campaign names, evaluates it and files the result: the same path for a folder and
            /// for the parts of a request.
            ///
            /// # Errors
            /// A file that cannot be read, data that do not carry the result, or `watch` wanted it to stop.
            pub fn evaluate(
                &self,
                date: Option<String>,
                watch: &dyn Watch,
            ) -> trouble::Result<StoredResult> {
                match self {
                    $(Self::$name(campaign) => {
                        let files = campaign.load(watch)?;
                        let record = campaign.record(&files, date);
                        let ($given, $files, $watching) = (campaign, &files, watch);
                        let answer = || $outcome;
                        let outcome = answer().map_err(|t| t.read_as(&record.inputs))?;
                        StoredResult::new(record, &outcome)
                    })*
                }
            }
        }
    };
}

kinds! {
    /// A triaxial accelerometer held still in many positions.
    MultiPosition(MultiPositionCampaign, "multi-position", |campaign, files, watch| campaign.job(files)?.evaluate(&files.data(), watch)),
    /// Days of a logger, calibrated from its still moments.
    FreeLiving(FreeLivingCampaign, "free-living", |campaign, files, watch| campaign.job()?.evaluate(files, watch)),
    /// One axis at rest, up and down or at many known angles.
    SingleAxis(SingleAxisCampaign, "single-axis", |campaign, files, watch| campaign.job(files)?.evaluate(&files.data(&files.unit()), watch)),
    /// A triaxial accelerometer on a shaker.
    ShakerTriaxial(ShakerTriaxialCampaign, "shaker-triaxial", |_campaign, files, watch| files.job.evaluate(&files.data(), watch)),
    /// A single-axis accelerometer against a reference.
    ShakerSingle(ShakerSingleCampaign, "shaker-single", |_campaign, files, watch| files.job.evaluate(&files.data(), watch)),
    /// A single-axis accelerometer against a laser interferometer.
    ShakerPrimary(ShakerPrimaryCampaign, "shaker-primary", |_campaign, files, watch| files.job.evaluate(&files.data(), watch)),
    /// A single-axis accelerometer shaken across its axis.
    Transverse(TransverseCampaign, "transverse-sensitivity", |_campaign, files, watch| files.job.evaluate(&files.data(), watch)),
    /// Motion of table and wedges beside the excitation.
    SpuriousMotion(SpuriousMotionCampaign, "spurious-motion", |_campaign, files, watch| files.job.evaluate(&files.data(), watch)),
}

/// The line that tells an editor which keys a campaign of a kind has: a comment, by which it fetches the schema of this version.
pub(crate) fn schema_line(kind: &str) -> String {
    format!("#:schema {}", schema_address(kind))
}

/// Where the schema of a name stands in the project, once this version is published.
pub(crate) fn schema_address(name: &str) -> String {
    format!(
        "{}/raw/v{}/apps/cli/schemas/{name}.json",
        env!("CARGO_PKG_REPOSITORY"),
        env!("CARGO_PKG_VERSION")
    )
}

/// A campaign file as text, with the store of the files that it names: what every kind is read from.
#[derive(Clone)]
#[non_exhaustive]
pub struct CampaignFile {
    /// The file `campaign.toml` itself, as it stands in messages.
    pub path: PathBuf,
    /// Path and digest.
    pub(crate) input: Input,
    text: String,
    store: Arc<dyn Store>,
    /// The recording that it was drafted from: then nobody has seen its lines, and options stand for its keys.
    drafted_from: Option<PathBuf>,
}

impl std::fmt::Debug for CampaignFile {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut form = f.debug_struct("CampaignFile");
        form.field("path", &self.path).field("input", &self.input);
        form.finish_non_exhaustive()
    }
}

impl PartialEq for CampaignFile {
    fn eq(&self, other: &Self) -> bool {
        self.path == other.path && self.input == other.input
    }
}

impl Campaign {
    /// Opens a folder that holds `campaign.toml`, or the file itself.
    ///
    /// # Errors
    /// A missing file, a line that is no TOML, an unknown kind or key (with the nearest valid one), a value outside
    /// its range: each with its line.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        Self::of(CampaignFile::open(path.as_ref())?)
    }

    /// As [`Campaign::open`], but a file outside of the folder of the campaign is refused: for campaigns of strangers.
    ///
    /// # Errors
    /// As [`Campaign::open`]; a file that is named outside, once it is asked for.
    pub fn open_contained(path: impl AsRef<Path>) -> Result<Self> {
        Self::of(CampaignFile::open_in(path.as_ref(), Folder::contained)?)
    }

    /// Reads the campaign of a store; what it names is read from the same store.
    ///
    /// # Errors
    /// As [`Campaign::open`].
    pub fn read(store: Arc<dyn Store>, name: &str) -> Result<Self> {
        Self::of(CampaignFile::read(store, name)?)
    }

    fn of(file: CampaignFile) -> Result<Self> {
        #[derive(Deserialize)]
        struct Kind {
            kind: Option<toml::Spanned<String>>,
        }
        let kind: Kind = file.parse()?;
        let list = KINDS.join(", ");
        let Some(kind) = kind.kind else {
            return Err(Error::new(
                ErrorKind::Configuration,
                "the campaign does not say of which kind it is",
            )
            .at(&file.path)
            .with_hint(format!(
                "begin the file with kind = \"…\"; known kinds: {list}"
            )));
        };
        let word = kind.get_ref().as_str();
        if let Some(campaign) = Self::of_word(word, &file)? {
            return Ok(campaign);
        }
        let near = proofmass_io::spelling::nearest(word, KINDS.iter().copied())
            .map_or(String::new(), |k| format!("did you mean \"{k}\"? "));
        Err(
            Error::new(ErrorKind::Configuration, format!("unknown kind \"{word}\""))
                .at(&file.path)
                .line(file.line_at(kind.span().start))
                .column("kind")
                .with_hint(format!("{near}known kinds: {list}")),
        )
    }
}

impl Campaign {
    /// One campaign for each device, with its name where they are several: each has a result of its own.
    pub fn of_each_device(self) -> Vec<(Option<String>, Self)> {
        match self {
            Self::ShakerSingle(campaign) if campaign.devices.len() > 1 => {
                let each = campaign.of_each_device().into_iter();
                each.map(|c| (Some(c.channel.clone()), Self::ShakerSingle(Box::new(c))))
                    .collect()
            }
            other => vec![(None, other)],
        }
    }

    /// Kind of the result, as `kind` in result.json.
    pub fn result_kind(&self) -> &'static str {
        match self {
            Self::SingleAxis(_) => StaticTestOutcome::KIND,
            _ => self.kind(),
        }
    }
}

impl Campaign {
    /// States U = k u in the result, instead of U at 95 %: as `coverage_factor` in `[method]` does.
    ///
    /// # Errors
    /// A kind of campaign that is not a calibration on the shaker, or a k that is no coverage factor.
    pub fn state_with(&mut self, k: f64) -> Result<()> {
        statement::coverage_factor(self.source(), Some(k))?;
        let stated = match self {
            Self::ShakerTriaxial(c) => &mut c.method.coverage_factor,
            Self::ShakerSingle(c) => &mut c.method.coverage_factor,
            Self::ShakerPrimary(c) => &mut c.method.coverage_factor,
            Self::Transverse(c) => &mut c.method.coverage_factor,
            other => {
                return Err(other
                    .source()
                    .refuse("", "kind", format!("a coverage factor is not stated of a {} campaign", other.kind()))
                    .with_hint("calibrate it without -k; `confidence` in [method] sets the probability where the kind has it"));
            }
        };
        *stated = Some(k);
        Ok(())
    }
}

/// A word that a file has and its form has not.
pub(crate) struct UnknownWord<'a> {
    /// The word.
    pub(crate) unknown: &'a str,
    /// A question after the one that may be meant, with a blank, or nothing.
    pub(crate) near: String,
    /// All that may stand there.
    pub(crate) valid: String,
}

impl<'a> UnknownWord<'a> {
    /// serde writes: unknown field `a`, expected one of `b`, `c`.
    pub(crate) fn of(message: &'a str) -> Option<Self> {
        let words = message
            .starts_with("unknown ")
            .then(|| message.split('`'))?;
        let mut words = words.skip(1).step_by(2);
        let unknown = words.next()?;
        let valid: Vec<&str> = words.collect();
        let near = proofmass_io::spelling::nearest(unknown, valid.iter().copied());
        Some(Self {
            unknown,
            near: near.map_or(String::new(), |near| format!("did you mean `{near}`? ")),
            valid: valid.join(", "),
        })
    }
}

/// What a reader of TOML complains of, in the words of somebody who wrote the file.
pub(crate) fn plain_toml(message: &str) -> String {
    let kind = |word| match word {
        "f64" | "f32" => "a number",
        "u64" | "u32" | "usize" | "i64" | "i32" => "a whole number",
        other => other,
    };
    if let Some((given, wanted)) = message
        .strip_prefix("invalid type: ")
        .and_then(|rest| rest.split_once(", expected "))
    {
        let quoted = match given.starts_with("string ") && kind(wanted).contains("number") {
            true => " without quotes",
            false => "",
        };
        return format!("{given} stands where {}{quoted} is needed", kind(wanted));
    }
    if message.starts_with("unexpected key or value, expected newline") {
        return "one value is expected, and the line goes on behind it: write one key a line, and a point for the decimals"
            .to_owned();
    }
    if let Some(rest) = message.strip_prefix("invalid length ")
        && rest.ends_with("expected an array of length 2")
    {
        return "two numbers are expected, [LOW, HIGH]".to_owned();
    }
    message.to_owned()
}

impl CampaignFile {
    /// Reads the text of a campaign from a folder or a file.
    ///
    /// # Errors
    /// A missing or empty file, or one that is not UTF-8.
    pub fn open(path: &Path) -> Result<Self> {
        Self::open_in(path, |folder| folder)
    }

    fn open_in(path: &Path, rule: fn(Folder) -> Folder) -> Result<Self> {
        let path = if path.is_dir() {
            let inside = path.join("campaign.toml");
            if !inside.is_file() {
                return Err(
                    Error::new(ErrorKind::NotFound, "the folder holds no campaign.toml")
                        .at(path)
                        .with_hint(
                            "name the folder of a campaign, or write a campaign.toml into it",
                        ),
                );
            }
            inside
        } else {
            path.to_path_buf()
        };
        let (Some(folder), Some(name)) = (path.parent(), path.file_name().and_then(|n| n.to_str()))
        else {
            return Err(Error::new(ErrorKind::NotFound, "is no campaign").at(&path));
        };
        Self::read(Arc::new(rule(Folder::new(folder))), name)
    }

    /// Reads the text of a campaign from a store.
    ///
    /// # Errors
    /// As [`CampaignFile::open`].
    pub fn read(store: Arc<dyn Store>, name: &str) -> Result<Self> {
        let path = store.describe(name);
        let (bytes, input) = store.open(name)?.into_bytes(LARGEST_DOCUMENT)?;
        let text = String::from_utf8(bytes).map_err(|e| {
            let line = e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|b| **b == b'\n').count();
            Error::new(ErrorKind::Format, "the text is not UTF-8")
                .at(&path)
                .line(line as u64 + 1)
                .with_hint("a campaign is a TOML text in UTF-8; name the folder or its campaign.toml, not a recording")
        })?;
        if text.trim().is_empty() {
            return Err(
                Error::new(ErrorKind::Configuration, "the file is empty")
                    .at(&path)
                    .with_hint(format!(
                        "a campaign begins with kind = \"…\" (known kinds: {}), a fixture for `modes` with [wedge] or [mesh]",
                        KINDS.join(", ")
                    )),
            );
        }
        Ok(Self {
            path,
            input,
            text,
            store,
            drafted_from: None,
        })
    }

    /// The file itself as an input of a result: none where it was drafted from a recording, which is all that there is to fetch.
    pub(crate) fn as_inputs(&self) -> Vec<Input> {
        match self.drafted_from {
            Some(_) => Vec::new(),
            None => vec![self.input.clone()],
        }
    }

    /// Reads the text as the table of one kind.
    ///
    /// # Errors
    /// As TOML says, with line and key; an unknown key comes with the nearest valid one.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T> {
        toml::from_str(&self.text).map_err(|e| {
            let message = e.message().lines().next().unwrap_or_default().to_string();
            let line = e.span().map(|span| self.line_at(span.start));
            let key = line
                .filter(|_| message.starts_with("invalid "))
                .and_then(|line| self.key_at(line));
            let mut error = self.refusal(line, key.as_deref(), plain_toml(&message));
            if let Some(UnknownWord { unknown, near, valid }) = UnknownWord::of(&message) {
                error = match message.starts_with("unknown variant") {
                    true => {
                        let key = line.and_then(|line| self.key_at(line));
                        self.refusal(
                            line,
                            key.as_deref(),
                            format!("the value {unknown:?} is not known"),
                        )
                    }
                    false => self.refusal(line, Some(unknown), "unknown key".to_owned()),
                }
                .with_hint(format!("{near}valid here: {valid}"));
            }
            let missing = message.strip_prefix("missing field `");
            if let Some(missing) = missing.and_then(|rest| rest.split('`').next()) {
                let table = self.table_at(line);
                let heading = table.as_deref().map_or(String::new(), |t| format!("[{t}] "));
                error = self
                    .refusal(line, Some(missing), format!("{heading}needs `{missing}`"))
                    .with_hint(match missing {
                        "columns" => "add columns = { x = …, y = …, z = … } to it, each the heading or the number of a column".to_owned(),
                        _ => format!("add it; `proofmass schema KIND` lists every key of a kind, and `proofmass init --kind KIND -o FOLDER` writes an example ({missing})"),
                    });
            }
            error.because(e)
        })
    }

    /// Key of a line, where the line has one.
    fn key_at(&self, line: u64) -> Option<String> {
        let text = self
            .text
            .lines()
            .nth(usize::try_from(line).ok()?.checked_sub(1)?)?;
        let key = text.split_once('=')?.0.trim().trim_matches('"');
        let plain = |c: char| c.is_alphanumeric() || "_-./%²".contains(c);
        (!key.is_empty() && key.chars().all(plain)).then(|| key.to_owned())
    }

    /// Heading of the table that a line belongs to, where it has one.
    fn table_at(&self, line: Option<u64>) -> Option<String> {
        let before = self.text.lines().take(line? as usize);
        let headings = before.filter_map(|l| {
            let inside = l.trim().strip_prefix('[')?;
            let (name, _) = inside.trim_start_matches('[').split_once(']')?;
            Some(name.trim().to_owned())
        });
        headings.last()
    }

    /// Line of a byte of the text, from one.
    pub fn line_at(&self, byte: usize) -> u64 {
        1 + self.text.as_bytes()[..byte.min(self.text.len())]
            .iter()
            .filter(|b| **b == b'\n')
            .count() as u64
    }

    /// Stands in a campaign until its own file is put in its place.
    fn unread() -> Self {
        Self {
            path: PathBuf::new(),
            input: Input::default(),
            text: String::new(),
            store: Arc::new(Memory::new()),
            drafted_from: None,
        }
    }

    /// Refuses a stretch of time (`between_s` of a table) that ends before it begins.
    pub(crate) fn check_between(&self, table: &str, between: Option<[f64; 2]>) -> Result<()> {
        match between {
            Some([from, to]) if !(from < to && from.is_finite() && to.is_finite()) => Err(self
                .refuse(
                    table,
                    "between_s",
                    "a stretch of time ends before it begins",
                )
                .with_hint("write between_s = [FROM, TO] in seconds, FROM before TO")),
            _ => Ok(()),
        }
    }

    /// A file named in the campaign, as it stands in messages.
    pub fn resolve(&self, name: &str) -> PathBuf {
        self.store.describe(name)
    }

    /// Opens a file named in the campaign.
    ///
    /// # Errors
    /// No such file, or it cannot be read.
    pub fn source(&self, name: &str) -> Result<Source> {
        self.store.open(name)
    }

    /// A text named in the campaign, and its digest.
    ///
    /// # Errors
    /// As [`CampaignFile::source`]; a text that is not UTF-8.
    pub fn text(&self, name: &str) -> Result<(String, Input)> {
        let (bytes, input) = self.source(name)?.into_bytes(LARGEST_DOCUMENT)?;
        let text = String::from_utf8(bytes).map_err(|_| {
            Error::new(ErrorKind::Format, "the text is not UTF-8").at(&self.resolve(name))
        })?;
        Ok((text, input))
    }

    /// Whether there is a file that the campaign names.
    pub fn holds(&self, name: &str) -> bool {
        self.store.holds(name)
    }

    /// An error about the value of a key of a table.
    pub(crate) fn refuse(&self, table: &str, key: &str, what: impl Into<String>) -> Error {
        self.refuse_at(table, None, key, what.into())
    }

    /// The same of one of several tables of a name, counted from zero.
    pub(crate) fn refuse_in(
        &self,
        (table, nth, key): (&str, usize, &str),
        what: impl Into<String>,
    ) -> Error {
        self.refuse_at(table, Some(nth), key, what.into())
    }

    fn refuse_at(&self, table: &str, nth: Option<usize>, key: &str, what: String) -> Error {
        let mut inside = table.is_empty();
        let mut before = 0;
        let line = self.text.lines().position(|line| {
            let line = line.trim();
            if line.starts_with('[') {
                let here = line.trim_matches(['[', ']']).trim() == table;
                inside = here && nth.is_none_or(|n| n == before);
                before += usize::from(here);
            }
            inside
                && line
                    .split(['=', '.'])
                    .next()
                    .is_some_and(|k| k.trim().trim_matches('"') == key)
        });
        let key = match table {
            "" => key.to_owned(),
            table => format!("{table}.{key}"),
        };
        self.refusal(line.map(|line| line as u64 + 1), Some(&key), what)
    }

    /// An error at a line and a key or value of the text; of a drafted one about the recording and the option.
    fn refusal(&self, line: Option<u64>, key: Option<&str>, what: String) -> Error {
        let error = |what: String| Error::new(ErrorKind::Configuration, what);
        if let Some(recording) = &self.drafted_from {
            let what = match key {
                Some(key) => format!("{}: {what}", draft::option_of(key)),
                None => what,
            };
            return error(what).at(recording);
        }
        let error = error(what).at(&self.path);
        let error = match key {
            Some(key) => error.column(key),
            None => error,
        };
        match line {
            Some(line) => error.line(line),
            None => error,
        }
    }
}
