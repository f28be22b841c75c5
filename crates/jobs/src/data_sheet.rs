//! The data sheet of a device as a file: who it is, and the limits that it promises.

mod characteristic;
mod limit;
pub(crate) mod unit;

pub use characteristic::{Characteristic, Known, Measurement, characteristics};
pub(crate) use characteristic::{axis_of_channel, is_of_a_device, shown_by as characteristic_of};
pub use limit::{ReadLimit, SheetLimit};
pub use unit::ratio as unit_ratio;

use crate::campaign::{UnknownWord, plain_toml};
use crate::certificate::RuleWord;
use crate::trouble::{Result, Trouble};
use proofmass_documents::Device;
use proofmass_io::{Input, LARGEST_DOCUMENT, Source};
use serde::{Deserialize, Serialize};

/// A data sheet: whose it is, its limits, and the rule by which they are decided.
///
/// ```
/// let text = "[device]\nmodel = \"A-1\"\n\n[[limit]]\ncharacteristic = \"bias\"\nmost = 50\nunit = \"mg\"\n";
/// let sheet = proofmass_jobs::data_sheet::sheet(text)?;
/// assert_eq!((sheet.device.model.as_deref(), sheet.limit[0].most), (Some("A-1"), Some(50.0)));
/// # Ok::<(), proofmass_jobs::Trouble>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct DataSheet {
    /// Which device the sheet is of; a result that says otherwise is refused.
    pub device: Device,
    /// Output at no acceleration by design, where it is not zero, as of a device that gives 2.5 V or the middle of its range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub output: Option<SheetOutput>,
    /// Rule by which it is decided whether a limit is met.
    pub decision: SheetDecision,
    /// The limits, one table each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub limit: Vec<SheetLimit>,
    /// Grades in the place of those that the program knows, the lowest first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub grade: Vec<Grade>,
}

/// What a device is designed to give.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct SheetOutput {
    /// Output at no acceleration; a limit of the bias in an acceleration counts from it.
    pub zero: f64,
    /// Its unit.
    pub unit: String,
}

/// The rule of the decisions of a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct SheetDecision {
    /// `guard-band`: pass within limits narrowed by w = r U, fail beyond limits widened by it, undecided between. `simple`: the
    /// value alone decides, and the risk is shared.
    pub rule: RuleWord,
    /// r of the guard band.
    pub r: f64,
}

impl Default for SheetDecision {
    fn default() -> Self {
        Self {
            rule: RuleWord::GuardBand,
            r: 1.0,
        }
    }
}

/// A grade of sensors: limits that a device of it meets.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Grade {
    /// Name, such as tactical.
    pub name: String,
    /// Who states these limits.
    #[serde(default)]
    pub source: String,
    /// The limits, one table each.
    #[serde(default)]
    pub limit: Vec<SheetLimit>,
}

impl DataSheet {
    /// Refuses limits that contradict themselves or each other, in the words of the file.
    ///
    /// # Errors
    /// What is wrong, with the number of the limit.
    pub fn check(&self) -> Result<()> {
        if self.limit.is_empty() {
            return Err(nothing());
        }
        let r = self.decision.r;
        if !(r > 0.0 && r.is_finite()) {
            return Err(
                Trouble::request(format!("[decision] r = {r} is not positive")).with_hint(
                    "1 makes the guard band as wide as U; rule = \"simple\" has no guard band",
                ),
            );
        }
        if let Some(SheetOutput { zero, unit }) = &self.output
            && !(zero.is_finite() && unit::is_unit(unit))
        {
            return Err(Trouble::request(format!(
                "[output] zero = {zero} in {unit:?} is no output of a device"
            ))
            .with_hint("write zero = 2.5 and unit = \"V\", or zero = 32768 and unit = \"count\""));
        }
        read_all(&self.limit, "limit")?;
        for grade in &self.grade {
            if grade.name.trim().is_empty() {
                return Err(Trouble::request("a [[grade]] has no name")
                    .with_hint("write name = \"tactical\", and whose limits they are as source"));
            }
            if grade.limit.is_empty() {
                return Err(
                    Trouble::request(format!("the grade {} has no limit", grade.name))
                        .with_hint("write [[grade.limit]] with characteristic, most and unit"),
                );
            }
            if self.grade.iter().filter(|g| g.name == grade.name).count() > 1 {
                return Err(
                    Trouble::request(format!("the grade {} stands twice", grade.name))
                        .with_hint("put its limits into one [[grade]]"),
                );
            }
            read_all(&grade.limit, "limit")
                .map_err(|e| e.about(format!("grade {}", grade.name)))?;
        }
        Ok(())
    }
}

fn nothing() -> Trouble {
    Trouble::request("the limits cannot be read: there is no [[limit]]").with_hint(limit::HOW)
}

/// Every limit, read; and no limit of one thing twice.
pub(crate) fn read_all(limits: &[SheetLimit], word: &str) -> Result<Vec<ReadLimit>> {
    let mut read: Vec<ReadLimit> = Vec::with_capacity(limits.len());
    for (k, limit) in limits.iter().enumerate() {
        let one = limit
            .read()
            .map_err(|e| e.detail(format!("{word} {} of {}", k + 1, limits.len())))?;
        if let Some(first) = read.iter().position(|r| r.is_of_the_same(&one)) {
            return Err(Trouble::request(format!(
                "there are two limits of {}",
                one.characteristic.name()
            ))
            .detail(format!("{word} {} and {word} {}", first + 1, k + 1))
            .with_hint(
                "leave one of them out, or part them by channels, frequency_Hz, temperature_degC or meaning",
            ));
        }
        read.push(one);
    }
    Ok(read)
}

/// A sheet from the text of a TOML file.
///
/// # Errors
/// No TOML, an unknown key or characteristic, a limit that contradicts itself or another one, no limit at all; with the line.
pub fn sheet(text: &str) -> Result<DataSheet> {
    let sheet: DataSheet = toml::from_str(text).map_err(|e| no_sheet(&e, text))?;
    sheet.check().map_err(|e| in_line(e, text))?;
    Ok(sheet)
}

/// Why a text is no sheet: what, and the line.
fn no_sheet(error: &toml::de::Error, text: &str) -> Trouble {
    let number = error.span().map(|span| {
        let before = &text.as_bytes()[..span.start.min(text.len())];
        before.iter().filter(|b| **b == b'\n').count()
    });
    let line = number.and_then(|n| text.lines().nth(n));
    let section = line.is_some_and(|line| line.trim_start().starts_with('['));
    let message = error.message();
    let field = UnknownWord::of(message).filter(|_| message.starts_with("unknown field "));
    let trouble = match field {
        Some(UnknownWord {
            unknown,
            near,
            valid,
        }) => {
            let what = match section {
                true => format!("unknown section [{unknown}]"),
                false => format!("unknown key {unknown}"),
            };
            Trouble::request(what).with_hint(format!("{near}known: {valid}"))
        }
        _ => Trouble::request(format!(
            "the limits cannot be read: {}",
            plain_toml(message)
        ))
        .with_hint(limit::HOW),
    };
    match number {
        Some(number) => trouble.detail(format!("line {}", number + 1)),
        None => trouble,
    }
}

/// The trouble with the line at which its limit begins, where the limit is one of the sheet itself.
fn in_line(trouble: Trouble, text: &str) -> Trouble {
    let number = trouble.place().iter().find_map(|place| {
        let rest = place.strip_prefix("limit ")?;
        rest.split(' ').next()?.parse::<usize>().ok()
    });
    let headings = text.lines().enumerate().filter(|(_, line)| {
        let bare: String = line.chars().filter(|c| !c.is_whitespace()).collect();
        bare.starts_with("[[limit]]")
    });
    let line = number.and_then(|n| headings.map(|(k, _)| k + 1).nth(n.checked_sub(1)?));
    match line {
        Some(line) if !trouble.to_string().starts_with("grade ") => {
            trouble.detail(format!("line {line}"))
        }
        _ => trouble,
    }
}

/// [`sheet`] from a file.
///
/// # Errors
/// As [`sheet`], with the name of the file.
pub fn read_sheet(source: Source) -> Result<(DataSheet, Input)> {
    let name = source.name().display().to_string();
    let (bytes, input) = source.into_bytes(LARGEST_DOCUMENT)?;
    let text = String::from_utf8(bytes).map_err(|_| {
        Trouble::request("the limits cannot be read: the file is no text in UTF-8")
            .detail(name.clone())
            .with_hint(limit::HOW)
    })?;
    let found = sheet(&text).map_err(|e| e.detail(name))?;
    Ok((found, input))
}
