//! How days, ranges, countries and texts of LAB.toml and an order may be written.

use super::CertificateFile;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt::Formatter;

/// Codes of countries, ISO 3166-1 alpha-2.
#[rustfmt::skip]
pub(super) const COUNTRIES: [&str; 249] = [
    "AD", "AE", "AF", "AG", "AI", "AL", "AM", "AO", "AQ", "AR", "AS", "AT", "AU", "AW", "AX", "AZ",
    "BA", "BB", "BD", "BE", "BF", "BG", "BH", "BI", "BJ", "BL", "BM", "BN", "BO", "BQ", "BR", "BS",
    "BT", "BV", "BW", "BY", "BZ", "CA", "CC", "CD", "CF", "CG", "CH", "CI", "CK", "CL", "CM", "CN",
    "CO", "CR", "CU", "CV", "CW", "CX", "CY", "CZ", "DE", "DJ", "DK", "DM", "DO", "DZ", "EC", "EE",
    "EG", "EH", "ER", "ES", "ET", "FI", "FJ", "FK", "FM", "FO", "FR", "GA", "GB", "GD", "GE", "GF",
    "GG", "GH", "GI", "GL", "GM", "GN", "GP", "GQ", "GR", "GS", "GT", "GU", "GW", "GY", "HK", "HM",
    "HN", "HR", "HT", "HU", "ID", "IE", "IL", "IM", "IN", "IO", "IQ", "IR", "IS", "IT", "JE", "JM",
    "JO", "JP", "KE", "KG", "KH", "KI", "KM", "KN", "KP", "KR", "KW", "KY", "KZ", "LA", "LB", "LC",
    "LI", "LK", "LR", "LS", "LT", "LU", "LV", "LY", "MA", "MC", "MD", "ME", "MF", "MG", "MH", "MK",
    "ML", "MM", "MN", "MO", "MP", "MQ", "MR", "MS", "MT", "MU", "MV", "MW", "MX", "MY", "MZ", "NA",
    "NC", "NE", "NF", "NG", "NI", "NL", "NO", "NP", "NR", "NU", "NZ", "OM", "PA", "PE", "PF", "PG",
    "PH", "PK", "PL", "PM", "PN", "PR", "PS", "PT", "PW", "PY", "QA", "RE", "RO", "RS", "RU", "RW",
    "SA", "SB", "SC", "SD", "SE", "SG", "SH", "SI", "SJ", "SK", "SL", "SM", "SN", "SO", "SR", "SS",
    "ST", "SV", "SX", "SY", "SZ", "TC", "TD", "TF", "TG", "TH", "TJ", "TK", "TL", "TM", "TN", "TO",
    "TR", "TT", "TV", "TW", "TZ", "UA", "UG", "UM", "US", "UY", "UZ", "VA", "VC", "VE", "VG", "VI",
    "VN", "VU", "WF", "WS", "YE", "YT", "ZA", "ZM", "ZW",
];

/// A day: a text, or a date as TOML has it without quotes.
pub(super) fn day<'de, D: Deserializer<'de>>(input: D) -> Result<Option<String>, D::Error> {
    struct Day;
    impl<'de> Visitor<'de> for Day {
        type Value = Option<String>;

        fn expecting(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
            f.write_str("a day, YYYY-MM-DD")
        }

        fn visit_str<E: Error>(self, text: &str) -> Result<Self::Value, E> {
            Ok(Some(text.to_owned()))
        }

        fn visit_none<E: Error>(self) -> Result<Self::Value, E> {
            Ok(None)
        }

        fn visit_unit<E: Error>(self) -> Result<Self::Value, E> {
            Ok(None)
        }

        fn visit_some<D: Deserializer<'de>>(self, input: D) -> Result<Self::Value, D::Error> {
            input.deserialize_any(Self)
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
            let date = serde::de::value::MapAccessDeserializer::new(map);
            toml::value::Datetime::deserialize(date).map(|d| Some(d.to_string()))
        }
    }
    input.deserialize_option(Day)
}

/// The lowest and the highest value, and nothing more.
pub(super) fn range<'de, D: Deserializer<'de>>(input: D) -> Result<Option<[f64; 2]>, D::Error> {
    let Some(values) = Option::<Vec<f64>>::deserialize(input)? else {
        return Ok(None);
    };
    let n = values.len();
    let pair = <[f64; 2]>::try_from(values);
    pair.map(Some).map_err(|_| {
        D::Error::custom(format!(
            "{n} values are stated, where the lowest and the highest are asked for"
        ))
    })
}

/// Characters of the longest text that a certificate prints: a page of it.
const LONGEST: usize = 4000;

/// Section and key of the first text that no certificate prints, and why: with controls or marks that turn the direction of what follows, or
/// longer than a page.
pub(super) fn unprintable(file: &CertificateFile) -> Option<(String, String, String)> {
    let all = serde_json::to_value(file).ok()?;
    let bad = |c: char| {
        (c.is_control() && !matches!(c, '\n' | '\r' | '\t'))
            || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}' | '\u{fffe}' | '\u{ffff}')
    };
    for (section, content) in all.as_object()? {
        let (name, tables) = match content {
            serde_json::Value::Array(list) => (format!("[{section}]"), list.iter().collect()),
            table => (section.clone(), vec![table]),
        };
        let fields = tables.into_iter().filter_map(|t| t.as_object()).flatten();
        let mut texts = fields.filter_map(|(key, value)| Some((key, value.as_str()?)));
        let why = |text: &str| match (text.chars().any(bad), text.chars().count()) {
            (true, _) => Some("holds characters that are not printed".to_owned()),
            (false, n) if n > LONGEST => Some(format!("is {n} characters long, of {LONGEST}")),
            _ => None,
        };
        if let Some((key, why)) = texts.find_map(|(key, text)| Some((key, why(text)?))) {
            return Some((name, key.clone(), why));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_days_and_ranges() {
        let read = |text: &str| toml::from_str::<CertificateFile>(text);
        let file = read("[calibration]\nbegin = 2026-01-03\nend = \"2026-01-04\"\n[[standards]]\nname = \"s\"\ncertificate = \"1\"\nissuer = \"i\"\nvalid_until = 2027-01-01").unwrap();
        let calibration = file.calibration.unwrap();
        assert_eq!(calibration.begin.as_deref(), Some("2026-01-03"));
        assert_eq!(calibration.end.as_deref(), Some("2026-01-04"));
        assert_eq!(calibration.received, None);
        assert_eq!(file.standards[0].valid_until.as_deref(), Some("2027-01-01"));
        for no in [
            "begin = 3",
            "begin = [1]",
            "begin = {a = 1}",
            "temperature_degC = [1, 2, 3]",
            "temperature_degC = [1]",
        ] {
            assert!(read(&format!("[calibration]\n{no}")).is_err(), "{no}");
        }
        let file: CertificateFile = serde_json::from_str(r#"{"calibration": {"begin": "2026-01-03", "due": null, "temperature_degC": [22, 23]}}"#).unwrap();
        let calibration = file.calibration.unwrap();
        assert_eq!(
            (calibration.due, calibration.temperature),
            (None, Some([22.0, 23.0]))
        );
    }

    #[test]
    fn known_unprintable_texts() {
        let file = |text: &str| CertificateFile {
            customer: Some(super::super::Contact {
                name: Some(text.to_owned()),
                ..Default::default()
            }),
            ..Default::default()
        };
        for text in ["a\u{0}b", "a\u{1b}[1m", "\u{202e}17", "a\u{feff}"] {
            let (table, key, why) = unprintable(&file(text)).unwrap();
            assert_eq!((table.as_str(), key.as_str()), ("customer", "name"));
            assert!(why.contains("not printed"), "{text:?}");
        }
        let long = unprintable(&file(&"é".repeat(5000))).unwrap();
        assert_eq!(long.2, "is 5000 characters long, of 4000");
        assert_eq!(unprintable(&file("Società «Ω»\n\u{200c}گواهی‌ها")), None);
    }
}
