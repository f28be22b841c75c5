//! What a certificate states of a result: values, U, k in the units of the field, as text, so that every output has the same digits.

use super::texts::{Language, Text};
use crate::StoredResult;
use crate::trouble::{Result, Trouble};
use proofmass_documents::{StatedQuantity, at_frequency};
use proofmass_report::number::{plain, rounded_up, two_digits};
use serde::{Deserialize, Serialize};

/// One stated number, rounded.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StatedNumber {
    /// Value.
    pub value: String,
    /// Expanded uncertainty; of an interval that is not symmetric its longer side.
    #[serde(rename = "U")]
    pub expanded: String,
    /// Standard uncertainty, where the distribution has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<String>,
    /// Coverage factor, where the interval is value ± k u.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub k: Option<String>,
    /// The interval, where it is not value ± U.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval: Option<[String; 2]>,
}

/// What a quantity is, for its words and its label.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Meaning {
    Sensitivity,
    Phase,
    /// Against a reference whose phase nobody stated.
    RelativePhase,
    /// Among the axes of a sensor with a clock of its own.
    OwnPhase,
    Transverse,
    Direction,
    Bias,
    Scale,
    Misalignment,
    Gravity,
    Temperature,
    Curvature,
    Other,
}

impl Meaning {
    fn of(name: &str) -> Self {
        match name.split(['.', '[']).next().unwrap_or_default() {
            "S" if name.contains(".phase") => Self::Phase,
            "S" => Self::Sensitivity,
            "transverse" if name.contains(".angle") => Self::Direction,
            "transverse" => Self::Transverse,
            "bias" => Self::Bias,
            "scale" | "sensitivity" => Self::Scale,
            "misalignment" => Self::Misalignment,
            "gravity" => Self::Gravity,
            "curvature" | "quadratic" => Self::Curvature,
            "slope" => Self::Temperature,
            "output" if name.contains(".T") => Self::Temperature,
            name if name.starts_with("temperature") => Self::Temperature,
            _ => Self::Other,
        }
    }

    pub(crate) fn text(self) -> Text {
        match self {
            Self::Sensitivity => Text::Modulus,
            Self::Phase => Text::Phase,
            Self::RelativePhase => Text::RelativePhase,
            Self::OwnPhase => Text::OwnPhase,
            Self::Transverse => Text::TransverseSensitivity,
            Self::Direction => Text::Angle,
            Self::Bias => Text::Bias,
            Self::Scale => Text::ScaleFactor,
            Self::Misalignment => Text::Misalignment,
            Self::Gravity => Text::Gravity,
            Self::Temperature => Text::TemperatureCoefficient,
            Self::Curvature => Text::CurvatureTerm,
            Self::Other => Text::OtherQuantity,
        }
    }

    /// Label of the quantity in a digital certificate; the first two as in the examples of the PTB.
    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::Sensitivity => "sensitivity magnitude",
            Self::Phase => "sensitivity phase",
            // No reader takes these for phases of the sensitivity.
            Self::RelativePhase => "phase relative to the reference",
            Self::OwnPhase => "phase among the axes",
            Self::Transverse => "transverse sensitivity",
            Self::Direction => "transverse sensitivity direction",
            Self::Bias => "bias",
            Self::Scale => "scale factor",
            Self::Misalignment => "misalignment",
            Self::Gravity => "local gravity",
            Self::Temperature => "temperature coefficient",
            Self::Curvature => "second-order coefficient",
            Self::Other => "quantity",
        }
    }

    /// Word of `refType` in a digital certificate, where one is in use.
    pub(crate) fn ref_type(self) -> Option<&'static str> {
        match self {
            Self::Sensitivity => Some("vib_sensitivity"),
            Self::Phase => Some("vib_phase"),
            _ => None,
        }
    }

    /// What the values of these units are multiplied with, and the unit of the certificate.
    fn unit(self, unit: &str, largest: f64) -> (f64, String) {
        match (self, unit) {
            (Self::Phase | Self::RelativePhase | Self::OwnPhase | Self::Direction, "rad") => {
                (180.0 / std::f64::consts::PI, "°".to_owned())
            }
            (Self::Transverse, "1") => (100.0, "%".to_owned()),
            (_, unit) if largest < 1.0 && unit.starts_with("V/") => (1e3, format!("m{unit}")),
            (_, unit) => (1.0, unit.to_owned()),
        }
    }
}

/// One quantity of a table: a number for each frequency.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StatedColumn {
    pub(crate) meaning: Meaning,
    /// Name of the quantity in the result, without its frequency.
    pub name: String,
    /// Unit of the numbers.
    pub unit: String,
    /// One for each frequency.
    pub numbers: Vec<StatedNumber>,
    /// What numbers of the result are multiplied with.
    pub(crate) factor: f64,
}

/// A table over frequency.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StatedTable {
    /// Element of the sensitivity matrix, `xy`: acceleration along x, output along y; none for one axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub element: Option<String>,
    /// Frequencies, Hz.
    #[serde(rename = "frequency_Hz")]
    pub frequency: Vec<String>,
    /// Quantities.
    pub columns: Vec<StatedColumn>,
}

/// A single quantity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StatedSingle {
    pub(crate) meaning: Meaning,
    /// Name of the quantity in the result.
    pub name: String,
    /// Unit of the number.
    pub unit: String,
    /// The number.
    pub number: StatedNumber,
}

/// Everything that is stated of a result.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StatedResults {
    /// Tables over frequency.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tables: Vec<StatedTable>,
    /// Single quantities.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub singles: Vec<StatedSingle>,
    /// Probability of every interval, such as `0.95`.
    pub probability: String,
}

/// Kinds of results that a certificate can state, and how they are obtained.
pub(crate) fn method(kind: &str) -> Option<(Text, &'static [&'static str])> {
    Some(match kind {
        "shaker-single" => (Text::ByComparison, &["ISO 16063-21"]),
        "shaker-primary" => (Text::ByInterferometer, &["ISO 16063-11"]),
        "shaker-triaxial" => (Text::TriaxialShaker, &["ISO 16063-21"]),
        "transverse-sensitivity" => (Text::TransverseMethod, &["ISO 16063-31"]),
        "multi-position" => (Text::ByGravity, &[]),
        "temperature" => (Text::OverTemperature, &[]),
        "static-test" => (Text::StaticTestMethod, &[]),
        _ => return None,
    })
}

/// What a certificate states of a result: everything with an uncertainty; of a triaxial accelerometer on a shaker the elements of its matrix,
/// since the rest follows from them and stands in the embedded result.
pub(crate) fn stated(result: &StoredResult) -> impl Iterator<Item = &StatedQuantity> {
    let elements = result.kind() == "shaker-triaxial";
    let all = result.quantities().iter();
    all.filter(move |q| q.expanded > 0.0 && (!elements || q.name.starts_with("S.")))
}

/// What probabilities may differ by and be one: those of a fixed k differ with their degrees of freedom. The smallest is stated.
const SAME: f64 = 0.01;

impl StatedResults {
    /// What a certificate states of a result.
    ///
    /// # Errors
    /// A kind that is no calibration; no quantity with an uncertainty; intervals of different probabilities.
    pub fn of(result: &StoredResult) -> Result<Self> {
        if method(result.kind()).is_none() {
            return Err(Trouble::request(format!(
                "a certificate is not made of a result of kind `{}`",
                result.kind()
            ))
            .with_hint("name the result of a calibration: shaker-triaxial, shaker-single, shaker-primary, transverse-sensitivity, multi-position, temperature or static-test"));
        }
        let all: Vec<&StatedQuantity> = stated(result).collect();
        let Some(first) = all.first() else {
            return Err(Trouble::data(
                "the result states no quantity with an uncertainty",
            ));
        };
        if let Some(other) = all
            .iter()
            .find(|q| (q.probability - first.probability).abs() > SAME)
        {
            return Err(Trouble::data(format!(
                "the result states intervals of different probabilities: {} at {}, {} at {}",
                first.name, first.probability, other.name, other.probability
            ))
            .with_hint("calibrate with one probability"));
        }
        let least = all.iter().map(|q| q.probability).fold(1.0, f64::min);
        let found = |code: &str| result.findings().iter().any(|f| f.code() == code);
        let phases = match (found("own-clock"), found("phase-not-stated")) {
            (true, _) => Some(Meaning::OwnPhase),
            (false, true) => Some(Meaning::RelativePhase),
            (false, false) => None,
        };
        let mut stated = Self {
            probability: plain_probability(least),
            ..Self::default()
        };
        let mut families: Vec<(String, Vec<(f64, &StatedQuantity)>)> = Vec::new();
        for q in &all {
            match at_frequency(&q.name) {
                Some((name, f)) => match families.iter_mut().find(|(n, _)| *n == name) {
                    Some((_, list)) => list.push((f, q)),
                    None => families.push((name, vec![(f, q)])),
                },
                None => stated.singles.push(single(q)),
            }
        }
        for (name, list) in families {
            let frequencies: Vec<String> = list.iter().map(|(f, _)| plain(*f)).collect();
            let quantities: Vec<&StatedQuantity> = list.into_iter().map(|(_, q)| q).collect();
            let mut column = column(name, &quantities);
            if let (Meaning::Phase, Some(phases)) = (column.meaning, phases) {
                column.meaning = phases;
            }
            let element = element(&column.name);
            let same = stated
                .tables
                .iter_mut()
                .find(|t| t.element == element && t.frequency == frequencies);
            match same {
                Some(table) => table.columns.push(column),
                None => stated.tables.push(StatedTable {
                    element,
                    frequency: frequencies,
                    columns: vec![column],
                }),
            }
        }
        Ok(stated)
    }

    /// The numbers with what is stated of each.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = &StatedNumber> {
        let tables = self
            .tables
            .iter()
            .flat_map(|t| &t.columns)
            .flat_map(|c| &c.numbers);
        tables.chain(self.singles.iter().map(|s| &s.number))
    }

    /// What a quantity is, in words; a name of a column stands for all its frequencies.
    pub(crate) fn name_of(&self, name: &str, language: Language) -> String {
        let mut tables = self.tables.iter();
        let column = tables.find_map(|t| Some((t, t.columns.iter().find(|c| c.name == name)?)));
        if let Some((table, column)) = column {
            let text = column.meaning.text().of(language);
            let element = table.element.as_deref().unwrap_or_default();
            return format!("{text} {element}").trim_end().to_owned();
        }
        let single = self.singles.iter().find(|s| s.name == name);
        single.map_or_else(|| name.to_owned(), |s| s.words(language))
    }

    /// What is said of its phases, where they are none of the sensitivity.
    pub(crate) fn about_phases(&self) -> Option<Text> {
        let columns = self.tables.iter().flat_map(|t| &t.columns);
        let mut of = columns.filter_map(|c| match c.meaning {
            Meaning::RelativePhase => Some(Text::RelativePhaseStatement),
            Meaning::OwnPhase => Some(Text::OwnPhaseStatement),
            _ => None,
        });
        of.next()
    }

    /// Whether an interval is not symmetric.
    pub(crate) fn has_intervals(&self) -> bool {
        self.numbers().any(|n| n.interval.is_some())
    }

    /// Probability in per cent, as texts state it.
    pub(crate) fn per_cent(&self) -> String {
        let p: f64 = self.probability.parse().unwrap_or(0.0);
        format!("{} %", plain(100.0 * p))
    }
}

/// A probability downwards to a tenth of a per cent.
fn plain_probability(p: f64) -> String {
    let text = format!("{:.3}", (1e3 * p + 1e-6).floor() / 1e3);
    text.trim_end_matches('0').to_owned()
}

/// The element of a sensitivity matrix in a name, `S.xy.modulus`.
fn element(name: &str) -> Option<String> {
    let middle = name.strip_prefix("S.")?.split('.').next()?;
    (middle != "modulus" && middle != "phase").then(|| middle.to_owned())
}

fn column(name: String, quantities: &[&StatedQuantity]) -> StatedColumn {
    let meaning = Meaning::of(&name);
    let largest = quantities.iter().map(|q| q.value.abs()).fold(0.0, f64::max);
    let (factor, unit) = meaning.unit(&quantities[0].unit, largest);
    StatedColumn {
        meaning,
        name,
        unit,
        numbers: quantities.iter().map(|q| number(q, factor)).collect(),
        factor,
    }
}

fn single(q: &StatedQuantity) -> StatedSingle {
    let meaning = Meaning::of(&q.name);
    let (factor, unit) = meaning.unit(&q.unit, q.value.abs());
    StatedSingle {
        meaning,
        name: q.name.clone(),
        unit,
        number: number(q, factor),
    }
}

fn number(q: &StatedQuantity, factor: f64) -> StatedNumber {
    let (value, expanded) = rounded_up(q.value * factor, q.expanded * factor);
    // Ends of an interval to the place of U.
    let end = |end: f64| rounded_up(end * factor, q.expanded * factor).0;
    StatedNumber {
        value,
        expanded,
        u: q.u.map(|u| two_digits(u * factor)),
        k: q.k
            .filter(|_| q.interval.is_none())
            .map(|k| format!("{k:.2}")),
        interval: q.interval.map(|i| i.map(end)),
    }
}

impl StatedSingle {
    /// What a number of the result is multiplied with.
    pub(crate) fn factor(&self, q: &StatedQuantity) -> f64 {
        self.meaning.unit(&q.unit, q.value.abs()).0
    }

    /// What it is, in words, with the part of its name that tells it from its like: `x`, `xy`.
    pub(crate) fn words(&self, language: Language) -> String {
        let text = self.meaning.text().of(language);
        match self.name.split_once('.') {
            _ if self.meaning == Meaning::Other => format!("{text}: {}", self.name),
            Some((_, which)) => format!("{text} {}", which.replace('.', ", ")),
            None => text.to_owned(),
        }
    }
}
