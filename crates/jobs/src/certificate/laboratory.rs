//! `LAB.toml` and the file of an order: who calibrates, for whom, by which standards, under which rule.

use super::content::says;
use super::stated;
use crate::campaign::CampaignFile;
use crate::trouble::{Result, Trouble};
use proofmass_io::Error;
use proofmass_uncertainty::{DecisionRule, Limits};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What is stated about laboratory and order; a section may stand in either file, and that of the order holds.
///
/// ```
/// use proofmass_jobs::certificate::CertificateFile;
/// let file: CertificateFile = serde_json::from_str(r#"{"laboratory": {"name": "Example", "town": "Pisa", "country": "IT"}}"#).unwrap();
/// assert_eq!(file.laboratory.unwrap().country.as_deref(), Some("IT"));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct CertificateFile {
    /// Who calibrates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub laboratory: Option<Contact>,
    /// Who authorises a certificate, the main signer first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub signatories: Vec<Signatory>,
    /// How certificates are numbered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub numbering: Option<Numbering>,
    /// Certificates of the standards.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub standards: Vec<Standard>,
    /// For whom.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub customer: Option<Contact>,
    /// What was calibrated; maker, type and serial number are those of the result where they are left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub item: Option<Item>,
    /// When and how.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub calibration: Option<Performance>,
    /// Limits and the rule by which it is decided whether they are met.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub conformity: Vec<ConformityEntry>,
    /// What the result is expected to state.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub statement: Option<Statement>,
}

/// A laboratory or a customer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct Contact {
    /// Name.
    pub name: Option<String>,
    /// Street and number.
    pub street: Option<String>,
    /// Post code.
    pub post_code: Option<String>,
    /// Town.
    pub town: Option<String>,
    /// Country, two letters (ISO 3166-1).
    pub country: Option<String>,
    /// Telephone.
    pub phone: Option<String>,
    /// Electronic mail.
    pub email: Option<String>,
    /// Text of the accreditation, as the body that grants it wants it printed.
    pub accreditation: Option<String>,
    /// Code of the laboratory.
    pub code: Option<String>,
    /// Order of the customer.
    pub order: Option<String>,
}

/// Who authorises a certificate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Signatory {
    /// Name.
    pub name: String,
    /// Role.
    pub role: String,
}

/// How certificates are numbered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Numbering {
    /// `{year}` and `{number}` stand for the year of issue and the next number, `{number:4}` for four digits of it.
    pub pattern: String,
    /// File of the register, beside LAB.toml.
    #[serde(default = "register")]
    pub register: String,
}

fn register() -> String {
    "certificates.jsonl".to_owned()
}

/// The certificate of a standard.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Standard {
    /// What it is, with its serial number.
    pub name: String,
    /// Number of its certificate.
    pub certificate: String,
    /// Who issued that.
    pub issuer: String,
    /// Last day on which it holds.
    #[serde(default, deserialize_with = "stated::day")]
    pub valid_until: Option<String>,
    /// Name of the input of the result that it is, or its SHA-256; none where the result was not computed from a file of it.
    pub input: Option<String>,
}

/// The calibrated item.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct Item {
    /// What it is; an accelerometer where nothing else is said.
    pub name: Option<String>,
    /// Maker.
    pub manufacturer: Option<String>,
    /// Type.
    pub model: Option<String>,
    /// Serial number.
    pub serial: Option<String>,
    /// Identification by the customer.
    pub customer_id: Option<String>,
    /// Condition on receipt.
    pub condition: Option<String>,
}

/// Where the calibration was carried out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum CalibrationPlace {
    /// At the laboratory.
    #[default]
    Laboratory,
    /// At the customer's premises.
    Customer,
}

/// When and how the calibration was carried out; days are written YYYY-MM-DD.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct Performance {
    /// Day of receipt.
    #[serde(deserialize_with = "stated::day")]
    pub received: Option<String>,
    /// First day.
    #[serde(deserialize_with = "stated::day")]
    pub begin: Option<String>,
    /// Last day; the first one where it is left out.
    #[serde(deserialize_with = "stated::day")]
    pub end: Option<String>,
    /// Where.
    pub place: CalibrationPlace,
    /// Procedure of the laboratory.
    pub procedure: Option<String>,
    /// How the item was mounted.
    pub mounting: Option<String>,
    /// Amplitude of the acceleration, lowest and highest, m/s²; that of the result where it states one.
    #[serde(rename = "acceleration_m/s2", deserialize_with = "stated::range")]
    pub acceleration: Option<[f64; 2]>,
    /// Deviations from the method.
    pub deviations: Option<String>,
    /// Temperature, lowest and highest, °C; that of the result where it is left out.
    #[serde(rename = "temperature_degC", deserialize_with = "stated::range")]
    pub temperature: Option<[f64; 2]>,
    /// Relative humidity, lowest and highest, per cent.
    #[serde(rename = "humidity_%", deserialize_with = "stated::range")]
    pub humidity: Option<[f64; 2]>,
    /// Further conditions.
    pub conditions: Option<String>,
    /// Next calibration, where the customer asked for one.
    #[serde(deserialize_with = "stated::day")]
    pub due: Option<String>,
    /// Remarks.
    pub remarks: Option<String>,
}

/// Limits of a quantity and the rule of the decision.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct ConformityEntry {
    /// Name of the quantity in the result; of a quantity over frequency without the frequency, for all of them: `S.modulus`.
    pub quantity: String,
    /// Lower limit, in the unit of the certificate.
    pub lower: Option<f64>,
    /// Upper limit, in the unit of the certificate.
    pub upper: Option<f64>,
    /// `simple`, or `guard-band` with `r`.
    pub rule: RuleWord,
    /// r of the guard band w = r U.
    pub r: Option<f64>,
    /// Where the limits come from.
    pub source: Option<String>,
}

/// The word of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum RuleWord {
    /// The value lies within the limits.
    Simple,
    /// The value lies within limits that are narrowed by w = r U.
    GuardBand,
}

/// What a result is expected to state: what contradicts it is refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct Statement {
    /// Coverage factor of every number.
    pub coverage_factor: Option<f64>,
    /// Probability of the intervals.
    pub probability: Option<f64>,
}

impl ConformityEntry {
    pub(crate) fn limits(&self) -> Result<Limits> {
        let limits = match (self.lower, self.upper) {
            (Some(lower), Some(upper)) if lower >= upper => {
                return Err(Trouble::request(format!(
                    "conformity of {}: the lower limit {lower} is not below the upper limit {upper}",
                    self.quantity
                ))
                .with_hint("state the lower one first, in the unit of the certificate"));
            }
            (Some(lower), Some(upper)) => Limits::between(lower, upper),
            (Some(lower), None) => Limits::above(lower),
            (None, Some(upper)) => Limits::below(upper),
            (None, None) => {
                return Err(Trouble::request(format!(
                    "conformity of {}: no limit is stated",
                    self.quantity
                ))
                .with_hint("state `lower`, `upper` or both, in the unit of the certificate"));
            }
        };
        limits.map_err(|e| Trouble::from(e).about(format!("conformity of {}", self.quantity)))
    }

    pub(crate) fn decision_rule(&self) -> Result<DecisionRule> {
        match (self.rule, self.r) {
            (RuleWord::Simple, None) => Ok(DecisionRule::SimpleAcceptance),
            (RuleWord::GuardBand, Some(factor)) if (0.0..=10.0).contains(&factor) => {
                Ok(DecisionRule::GuardBand { factor })
            }
            (RuleWord::GuardBand, None) => Err(Trouble::request(format!(
                "conformity of {}: a guard band needs its r",
                self.quantity
            ))
            .with_hint("w = r U: write r = 1 for a guard band of U")),
            (_, r) => Err(Trouble::request(format!(
                "conformity of {}: r = {} does not go with this rule",
                self.quantity,
                r.unwrap_or_default()
            ))
            .with_hint("`simple` has no r; `guard-band` has one from 0 to 10")),
        }
    }
}

impl CertificateFile {
    /// Reads a file of a laboratory or an order.
    ///
    /// # Errors
    /// A missing file, a line that is no TOML, an unknown key (with the nearest valid one) with its line; a day that is none.
    pub fn open(path: &Path) -> Result<Self> {
        let text = CampaignFile::open(path).map_err(|e| {
            e.with_hint("LAB.toml and the file of an order are TOML texts in UTF-8; `proofmass certificate template` prints one to fill in")
        })?;
        let file: Self = text.parse()?;
        file.check(&text)?;
        Ok(file)
    }

    fn check(&self, text: &CampaignFile) -> Result<(), Error> {
        if let Some((table, key, why)) = stated::unprintable(self) {
            return Err(text.refuse(&table, &key, why).with_hint(
                "write it again, in a few lines, without control characters and marks of direction",
            ));
        }
        let days = self.calibration.iter().flat_map(|c| {
            [
                ("received", &c.received),
                ("begin", &c.begin),
                ("end", &c.end),
                ("due", &c.due),
            ]
        });
        for (key, day) in days {
            if let Some(day) = day.as_deref().filter(|d| !is_day(d)) {
                return Err(text
                    .refuse("calibration", key, format!("{day:?} is no day"))
                    .with_hint("write YYYY-MM-DD"));
            }
        }
        for (n, entry) in self.conformity.iter().enumerate() {
            let same = |e: &ConformityEntry| {
                (&e.quantity, &e.source, e.rule, e.r)
                    == (&entry.quantity, &entry.source, entry.rule, entry.r)
            };
            if self.conformity[..n].iter().any(same) {
                return Err(text
                    .refuse(
                        "[conformity]",
                        "quantity",
                        format!("{:?} stands twice with one rule and source", entry.quantity),
                    )
                    .with_hint("limits are decided once by a rule: take one of the entries out, or name the source of each"));
            }
        }
        for standard in &self.standards {
            if let Some(day) = standard.valid_until.as_deref().filter(|d| !is_day(d)) {
                return Err(text
                    .refuse("[standards]", "valid_until", format!("{day:?} is no day"))
                    .with_hint("write YYYY-MM-DD"));
            }
        }
        for (table, contact) in [
            ("laboratory", &self.laboratory),
            ("customer", &self.customer),
        ] {
            let country = contact.as_ref().and_then(|c| c.country.as_deref());
            if let Some(country) = country.filter(|c| !stated::COUNTRIES.contains(c)) {
                return Err(text
                    .refuse(
                        table,
                        "country",
                        format!("{country:?} is no code of a country"),
                    )
                    .with_hint("two capital letters (ISO 3166-1), such as IT"));
            }
        }
        let ranges = self.calibration.iter().flat_map(|c| {
            [
                (
                    "temperature_degC",
                    c.temperature,
                    -273.15..=1000.0,
                    "from −273.15 °C to 1000 °C",
                ),
                ("humidity_%", c.humidity, 0.0..=100.0, "from 0 % to 100 %"),
                (
                    "acceleration_m/s2",
                    c.acceleration,
                    f64::MIN_POSITIVE..=1e7,
                    "above 0 m/s², up to 1e7 m/s²",
                ),
            ]
        });
        for (key, range, all, said) in ranges {
            if let Some([low, high]) = range
                && !(low <= high && all.contains(&low) && all.contains(&high))
            {
                return Err(text
                    .refuse(
                        "calibration",
                        key,
                        format!("[{low}, {high}] is out of range: {said}, the lowest first"),
                    )
                    .with_hint("write [LOWEST, HIGHEST]"));
            }
        }
        Ok(())
    }

    /// This file with the sections of an order in the place of its own.
    #[must_use]
    pub fn with_order(self, order: Self) -> Self {
        let list = |own: Vec<_>, new: Vec<_>| if new.is_empty() { own } else { new };
        Self {
            laboratory: order.laboratory.or(self.laboratory),
            signatories: if order.signatories.is_empty() {
                self.signatories
            } else {
                order.signatories
            },
            numbering: order.numbering.or(self.numbering),
            standards: if order.standards.is_empty() {
                self.standards
            } else {
                order.standards
            },
            customer: order.customer.or(self.customer),
            item: order.item.or(self.item),
            calibration: order.calibration.or(self.calibration),
            conformity: list(self.conformity, order.conformity),
            statement: order.statement.or(self.statement),
        }
    }
}

/// Whether a text is a day of the calendar, `YYYY-MM-DD`.
pub(crate) fn is_day(text: &str) -> bool {
    proofmass_io::formats::calendar::day_of(text).is_some()
}

impl Item {
    /// What tells it from its like, in one line: maker, type, serial number, identification by the customer.
    pub fn line(&self) -> String {
        let all = [
            &self.manufacturer,
            &self.model,
            &self.serial,
            &self.customer_id,
        ];
        let all: Vec<&str> = all.into_iter().flatten().map(|w| w.trim()).collect();
        all.join(" ")
    }
}

impl Contact {
    /// Street, then post code, town and country, as lines.
    pub(crate) fn lines(&self) -> Vec<String> {
        let joined = |parts: [Option<&str>; 2], between: &str| {
            let parts: Vec<&str> = parts.into_iter().flatten().collect();
            (!parts.is_empty()).then(|| parts.join(between))
        };
        let post_code = self.post_code.as_deref().filter(|p| says(p));
        let town = joined([post_code, self.town.as_deref()], " ");
        let lines = [
            self.street.clone(),
            joined([town.as_deref(), self.country.as_deref()], ", "),
            self.phone.clone(),
            self.email.clone(),
        ];
        lines.into_iter().flatten().filter(|l| says(l)).collect()
    }
}

impl Numbering {
    /// The number of a certificate.
    ///
    /// # Errors
    /// A pattern without `{number}`, or with other words in braces.
    pub fn number(&self, year: &str, number: u64) -> Result<String> {
        let wrong = || {
            Trouble::request(format!("numbering.pattern: {:?} is no pattern of a number", self.pattern))
                .with_hint("such as \"CAL-{year}-{number:4}\"; a number is used once, so {number} has to be in it")
        };
        let mut out = String::new();
        let mut rest = self.pattern.as_str();
        let mut has_number = false;
        while let Some(start) = rest.find('{') {
            let end = rest[start..].find('}').ok_or_else(wrong)? + start;
            out.push_str(&rest[..start]);
            match rest[start + 1..end].split_once(':') {
                None if &rest[start + 1..end] == "year" => out.push_str(year),
                None if &rest[start + 1..end] == "number" => {
                    out.push_str(&number.to_string());
                    has_number = true;
                }
                Some(("number", digits)) => {
                    let digits: usize = digits.parse().map_err(|_| wrong())?;
                    if digits > 12 {
                        return Err(wrong());
                    }
                    out.push_str(&format!("{number:0digits$}"));
                    has_number = true;
                }
                _ => return Err(wrong()),
            }
            rest = &rest[end + 1..];
        }
        out.push_str(rest);
        let plain = |c: char| c.is_alphanumeric() || "-_./ ".contains(c);
        let is_path = out.starts_with('/') || out.split('/').any(|part| part.starts_with('.'));
        match has_number && out.chars().all(plain) && !out.trim().is_empty() && !is_path {
            true => Ok(out),
            false => Err(wrong()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_days() {
        for day in ["2026-02-28", "2024-02-29", "2026-12-31"] {
            assert!(is_day(day), "{day}");
        }
        for no in [
            "2026-02-29",
            "2026-13-01",
            "26-01-01",
            "2026-1-1",
            "2026-01-00",
            "heute",
            "",
        ] {
            assert!(!is_day(no), "{no}");
        }
    }

    #[test]
    fn known_numbers() {
        let of = |pattern: &str| {
            let numbering = Numbering {
                pattern: pattern.into(),
                register: register(),
            };
            numbering.number("2026", 42)
        };
        assert_eq!(of("CAL-{year}-{number:4}").unwrap(), "CAL-2026-0042");
        assert_eq!(of("{number}").unwrap(), "42");
        for no in [
            "CAL",
            "{year}",
            "{number",
            "{number:x}",
            "{nummer}",
            "<{number}>",
        ] {
            assert!(of(no).is_err(), "{no}");
        }
    }
}
