//! What is filed: one entry after another, each with the digest of the one before. No entry is ever changed.

use crate::check::check_measurement;
pub(crate) use proofmass_io::sha256;
use proofmass_io::sheet::coherent;
use proofmass_jobs::Result;
use proofmass_static::static_test::RecalibrationRule;
use serde::{Deserialize, Serialize};

/// An entry as it is filed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Entry {
    /// Day it was filed on, ISO 8601.
    pub filed: String,
    /// Who filed it: the digest of a name that stands apart and can be removed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<String>,
    /// What it says.
    #[serde(flatten)]
    pub content: Content,
}

/// What an entry says. A number names an earlier entry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Content {
    /// A device, or a reference standard.
    Device(FiledDevice),
    /// A certificate of a standard.
    Certificate(FiledCertificate),
    /// A result.
    Result(Box<FiledResult>),
    /// A check measurement.
    Check(FiledCheck),
    /// Something that happened to a device.
    Event(FiledEvent),
    /// A result that no longer counts.
    Supersession(FiledSupersession),
    /// When devices are due, and what is tolerated.
    Rule(FiledRule),
    /// A campaign.
    Campaign(FiledCampaign),
    /// The calibration that a device is used with from now on.
    InUse(FiledUse),
}

impl Content {
    /// The files that are kept here with the entry.
    pub(crate) fn kept(&self) -> impl Iterator<Item = &FiledFile> {
        let (many, one) = match self {
            Self::Result(r) => (Some(r.files.iter().chain(&r.inputs)), None),
            Self::Certificate(c) => (None, c.file.as_ref()),
            _ => (None, None),
        };
        many.into_iter().flatten().chain(one).filter(|f| f.kept)
    }
}

/// Who made a device, which one it is, whose number it has.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[serde(default)]
pub struct FiledDevice {
    /// Maker
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    pub manufacturer: Option<String>,
    /// Type
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "TYPE"))]
    pub model: Option<String>,
    /// Serial number
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NUMBER"))]
    pub serial: Option<String>,
    /// Number that the owner has given it
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NUMBER"))]
    pub owner_number: Option<String>,
    /// Its axes, such as x,y,z
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "AXES"))]
    pub axes: Option<String>,
    /// Anything else worth filing
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "TEXT"))]
    pub description: Option<String>,
    /// Whether it is a reference standard.
    #[cfg_attr(feature = "clap", arg(skip))]
    pub standard: bool,
}

/// A certificate of a standard.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FiledCertificate {
    /// The standard.
    pub standard: i64,
    /// Number of the certificate.
    pub number: String,
    /// Laboratory that issued it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub laboratory: Option<String>,
    /// First day on which it is valid.
    pub valid_from: String,
    /// Last day on which it is valid; without an end where none is stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid_until: Option<String>,
    /// Relative standard uncertainty of the sensitivity of the standard.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_relative: Option<f64>,
    /// Frequency in Hz and relative standard uncertainty there, as its table has them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub u_at: Vec<[f64; 2]>,
    /// Its file: the table that campaigns read, or a page.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<FiledFile>,
}

/// A file by its digest.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FiledFile {
    /// Its name in the folder, or its path as the result names it.
    pub name: String,
    /// SHA-256 in hexadecimal digits.
    pub sha256: String,
    /// Whether its bytes are kept here too.
    pub kept: bool,
}

/// A result: what is needed to find it; the whole stands in its files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FiledResult {
    /// The device.
    pub device: i64,
    /// Kind, as in result.json.
    pub result_kind: String,
    /// Title.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// Day of the evaluation, ISO 8601.
    pub date: String,
    /// Number of its certificate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number: Option<String>,
    /// SHA-256 of result.json; of what was read of a row of a spreadsheet.
    pub sha256: String,
    /// Program that computed it, or the spreadsheet with its line.
    pub source: String,
    /// Its files.
    pub files: Vec<FiledFile>,
    /// What it was computed from.
    pub inputs: Vec<FiledFile>,
    /// The stated quantities.
    pub quantities: Vec<FiledQuantity>,
    /// Standards that it rests on, with the certificate that was valid.
    pub uses: Vec<UsedStandard>,
    /// The campaign it belongs to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub campaign: Option<i64>,
    /// Public key of who signed its list of files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signer: Option<String>,
}

/// A quantity of a result. Missing is unknown: a value without u counts for no drift.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FiledQuantity {
    /// Stable dotted name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value.
    pub value: f64,
    /// Standard uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<f64>,
    /// Expanded uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expanded: Option<f64>,
    /// Coverage factor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub k: Option<f64>,
    /// Degrees of freedom; without a number where they are unlimited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nu: Option<f64>,
    /// Probability of the interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probability: Option<f64>,
    /// Standard uncertainty from the reference standard alone, where the budget of the result tells it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_standard: Option<f64>,
}

/// A standard behind a result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct UsedStandard {
    /// The standard.
    pub standard: i64,
    /// Its certificate on that day.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub certificate: Option<i64>,
}

/// A check measurement against a known value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FiledCheck {
    /// The device that was checked.
    pub device: i64,
    /// Day, ISO 8601.
    pub date: String,
    /// What was measured.
    pub quantity: String,
    /// Unit of all numbers.
    pub unit: String,
    /// Measured value.
    pub value: f64,
    /// Its standard uncertainty.
    pub u: f64,
    /// Known value.
    pub reference: f64,
    /// Its standard uncertainty.
    pub u_reference: f64,
    /// E_n with k = 2.
    pub en: f64,
}

/// Something that happened to a device.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FiledEvent {
    /// The device.
    pub device: i64,
    /// Day, ISO 8601.
    pub date: String,
    /// What happened.
    pub event: EventKind,
    /// In words.
    pub text: String,
}

/// What happens to devices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum EventKind {
    /// A repair: the history begins anew
    Repair,
    /// An adjustment: the history begins anew
    Adjustment,
    /// A drop or another shock
    Drop,
    /// Out of use
    Withdrawal,
    /// In use again
    Return,
    /// Anything else
    Other,
}

impl EventKind {
    /// As it is filed.
    pub fn word(self) -> &'static str {
        match self {
            Self::Repair => "repair",
            Self::Adjustment => "adjustment",
            Self::Drop => "drop",
            Self::Withdrawal => "withdrawal",
            Self::Return => "return",
            Self::Other => "other",
        }
    }
}

impl FiledCheck {
    /// A measurement with its standard uncertainty, and the known value with its own; units that are known become those of SI.
    ///
    /// # Errors
    /// Uncertainties that are not positive, a difference that is no number.
    pub fn measured(
        device: i64,
        date: String,
        (quantity, unit): (String, String),
        [value, u]: [f64; 2],
        [reference, u_reference]: [f64; 2],
    ) -> Result<Self> {
        let (unit, factor) = coherent(&unit);
        let [value, u, reference, u_reference] =
            [value, u, reference, u_reference].map(|number| factor * number);
        let en = check_measurement(&quantity, unit, (value, u), (reference, u_reference))?.value;
        Ok(Self {
            device,
            date,
            quantity,
            unit: unit.to_owned(),
            value,
            u,
            reference,
            u_reference,
            en,
        })
    }
}

/// A result, check, event, certificate, use or supersession that no longer counts, and why.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FiledSupersession {
    /// The entry that no longer counts.
    pub old: i64,
    /// The one in its place, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub new: Option<i64>,
    /// Why.
    pub reason: String,
}

/// When a device, or every device without a rule of its own, is due again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FiledRule {
    /// The device; all without a rule of their own where none is named.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub device: Option<i64>,
    /// The rule.
    #[serde(flatten)]
    pub rule: RecalibrationRule,
    /// What is tolerated.
    pub tolerances: Vec<Tolerance>,
}

/// What is tolerated of a quantity; `S.modulus` stands for every `S.modulus[frequency=…]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tolerance {
    /// Name of the quantity.
    pub quantity: String,
    /// Largest change since the last calibration, in its unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub change: Option<f64>,
    /// Lower and upper limit of the value, in its unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<[f64; 2]>,
}

impl FiledRule {
    /// The rule in words.
    pub fn words(&self) -> String {
        let interval = match self.rule {
            RecalibrationRule::Fixed { months } => format!("due after {months} months"),
            RecalibrationRule::Drift { longest } => {
                format!("due by the drift, at most after {longest} months")
            }
            RecalibrationRule::Staircase { first, longest } => {
                format!("due by the staircase from {first} months, at most after {longest}")
            }
            _ => "due by a rule".to_owned(),
        };
        let tolerated = self.tolerances.iter().map(|t| {
            let change = t.change.map(|c| format!(" may change by {c}"));
            let limits = t.limits.map(|[low, high]| format!(" from {low} to {high}"));
            let words: Vec<String> = change.into_iter().chain(limits).collect();
            format!("; {}{}", t.quantity, words.join(","))
        });
        interval + &tolerated.collect::<String>()
    }
}

impl Tolerance {
    /// Whether it is that of a quantity; a name without a frequency is that of every frequency.
    pub fn is_of(&self, quantity: &str) -> bool {
        let rest = quantity.strip_prefix(self.quantity.as_str());
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('['))
    }
}

/// A campaign.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FiledCampaign {
    /// Its title.
    pub title: String,
    /// Anything else worth filing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
}

/// The calibration that a device is used with.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FiledUse {
    /// The device.
    pub device: i64,
    /// The result whose calibration.json is in use.
    pub result: i64,
    /// From this day on, ISO 8601.
    pub date: String,
}

/// Digest of an entry with this number and body behind one with the digest `previous`.
pub(crate) fn link(number: i64, body: &str, previous: &str) -> String {
    sha256(&[
        format!("{previous}\n{number}\n").as_bytes(),
        body.as_bytes(),
    ])
}

/// A serial number without what people write differently: capitals, blanks, dashes, leading zeros.
pub(crate) fn spelling(serial: &str) -> String {
    let plain: String = serial
        .chars()
        .filter(|c| c.is_alphanumeric())
        .flat_map(char::to_lowercase)
        .collect();
    match plain.trim_start_matches('0') {
        "" if !plain.is_empty() => "0".to_owned(),
        short => short.to_owned(),
    }
}

impl FiledDevice {
    /// Maker, type and serial number in a line, or what there is.
    pub fn line(&self) -> String {
        let words = [&self.manufacturer, &self.model, &self.serial];
        let words: Vec<&str> = words.into_iter().flatten().map(String::as_str).collect();
        match (words.is_empty(), &self.owner_number) {
            (false, _) => words.join(" "),
            (true, Some(number)) => number.clone(),
            (true, None) => self
                .description
                .clone()
                .unwrap_or_else(|| "device without a name".to_owned()),
        }
    }
}
