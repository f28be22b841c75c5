//! What a description says of the files beside it.

use crate::bytes::{self, Order};
use crate::calendar::days;
use crate::names::shown;
use crate::raw::Kind;
use crate::stream::Remark;
use crate::{Error, Result};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::path::{Component, Path};

/// More files beside one description are none.
const MOST_ENTRIES: usize = 10_000;

/// What `unisens.xml` says.
pub(super) struct Description {
    /// What a clock on the wall showed at the first sample, ns since 1970.
    pub(super) start_ns: Option<i64>,
    pub(super) entries: Vec<Entry>,
    pub(super) remarks: Vec<Remark>,
}

/// A file of samples.
pub(super) struct Entry {
    pub(super) file: String,
    pub(super) channels: Vec<String>,
    pub(super) unit: Option<String>,
    pub(super) rate_hz: f64,
    pub(super) slope: f64,
    pub(super) baseline: f64,
    pub(super) form: Form,
    /// The first column counts samples.
    pub(super) stamped: bool,
}

/// How numbers are written.
#[derive(Clone, Copy)]
pub(super) enum Form {
    Binary { kind: Kind, order: Order },
    Text { separator: u8, decimal: u8 },
}

/// An entry as it stands there.
#[derive(Default)]
struct Begun {
    file: String,
    values: bool,
    channels: Vec<String>,
    unit: Option<String>,
    data_type: Option<String>,
    rate: Option<String>,
    slope: Option<String>,
    baseline: Option<String>,
    form: Option<Written>,
}

enum Written {
    Binary {
        order: Option<String>,
    },
    Text {
        separator: Option<String>,
        decimal: Option<String>,
    },
    Other,
}

impl Description {
    pub(super) fn of(text: &[u8]) -> Result<Self> {
        let text = bytes::text(text);
        let mut reader = Reader::from_str(text.strip_prefix('\u{feff}').unwrap_or(&text));
        let mut found = Self {
            start_ns: None,
            entries: Vec::new(),
            remarks: Vec::new(),
        };
        let mut begun: Option<Begun> = None;
        while found.entries.len() <= MOST_ENTRIES {
            let at = reader.buffer_position();
            match reader.read_event() {
                Ok(Event::Start(element)) => found.begin(&element, &mut begun),
                Ok(Event::Empty(element)) => {
                    found.begin(&element, &mut begun);
                    if is_entry(element.local_name().as_ref()) {
                        found.end(begun.take());
                    }
                }
                Ok(Event::End(element)) => {
                    if is_entry(element.local_name().as_ref()) {
                        found.end(begun.take());
                    }
                }
                Ok(Event::Eof) => {
                    if begun.is_some() {
                        let cut = format!("the description ends at byte {at} within an entry");
                        found.remarks.push(Remark::cut(cut));
                    }
                    return Ok(found);
                }
                Ok(_) => {}
                Err(e) => {
                    let cut = format!("the description is no XML from byte {at} on: {e}");
                    found.remarks.push(Remark::cut(cut));
                    return Ok(found);
                }
            }
        }
        Err(Error::new(format!(
            "describes more than {MOST_ENTRIES} files, which no recording has"
        )))
    }

    fn begin(&mut self, element: &BytesStart, begun: &mut Option<Begun>) {
        let of = |key: &str| attribute(element, key);
        match (element.local_name().as_ref(), begun) {
            ("unisens", _) => self.start_ns = of("timestampStart").and_then(|t| nanoseconds(&t)),
            (name, begun) if is_entry(name) => {
                *begun = Some(Begun {
                    file: of("id").unwrap_or_default(),
                    values: name == "valuesEntry",
                    unit: of("unit"),
                    data_type: of("dataType"),
                    rate: of("sampleRate"),
                    slope: of("lsbValue"),
                    baseline: of("baseline"),
                    ..Begun::default()
                });
            }
            ("eventEntry" | "customEntry", _) => {
                let file = shown(&of("id").unwrap_or_default());
                let remark = format!("\"{file}\": events, or of a kind of its own");
                self.remarks.push(Remark::passed_over(remark));
            }
            ("channel", Some(begun)) => begun.channels.push(of("name").unwrap_or_default()),
            ("binFileFormat", Some(begun)) => {
                begun.form = Some(Written::Binary {
                    order: of("endianess"),
                });
            }
            ("csvFileFormat", Some(begun)) => {
                begun.form = Some(Written::Text {
                    separator: of("separator"),
                    decimal: of("decimalSeparator"),
                });
            }
            ("xmlFileFormat" | "customFileFormat", Some(begun)) => {
                begun.form = Some(Written::Other);
            }
            _ => {}
        }
    }

    fn end(&mut self, begun: Option<Begun>) {
        let Some(begun) = begun else {
            return;
        };
        let file = shown(&begun.file);
        match begun.ended() {
            Ok(entry) => self.entries.push(entry),
            Err(why) => {
                let remark = format!("\"{file}\": {why}");
                self.remarks.push(Remark::passed_over(remark));
            }
        }
    }
}

impl Begun {
    fn ended(self) -> Result<Entry, String> {
        let mut parts = Path::new(&self.file).components();
        let alone = matches!(
            (parts.next(), parts.next()),
            (Some(Component::Normal(name)), None) if name == self.file.as_str()
        );
        if !alone || self.file.contains('\\') {
            return Err("is no name of a file beside the description".into());
        }
        if self.channels.is_empty() {
            return Err("has no channels".into());
        }
        let form = match self.form {
            Some(Written::Binary { .. }) if self.values => {
                return Err("values with stamps in binary".into());
            }
            Some(Written::Binary { order }) => Form::Binary {
                kind: kind(self.data_type.as_deref())?,
                order: match order.as_deref() {
                    None => Order::Little,
                    Some(word) if word.eq_ignore_ascii_case("little") => Order::Little,
                    Some(word) if word.eq_ignore_ascii_case("big") => Order::Big,
                    Some(word) => return Err(format!("byte order \"{word}\"")),
                },
            },
            Some(Written::Text { separator, decimal }) => {
                let separator = mark("separator", separator, b';')?;
                let decimal = mark("decimalSeparator", decimal, b'.')?;
                if separator == decimal {
                    return Err("the separator of its columns is its decimal mark too".into());
                }
                Form::Text { separator, decimal }
            }
            Some(Written::Other) => return Err("neither binary nor delimited text".into()),
            None => return Err("the description does not say how it is written".into()),
        };
        let rate_hz = number("sampleRate", self.rate)?.ok_or("has no sampleRate")?;
        if !(rate_hz > 0.0) {
            return Err(format!("sampleRate is {rate_hz}"));
        }
        Ok(Entry {
            channels: self.channels,
            unit: self.unit.filter(|u| !u.trim().is_empty()),
            rate_hz,
            slope: number("lsbValue", self.slope)?.unwrap_or(1.0),
            baseline: number("baseline", self.baseline)?.unwrap_or(0.0),
            form,
            stamped: self.values,
            file: self.file,
        })
    }
}

fn is_entry(name: &str) -> bool {
    matches!(name, "signalEntry" | "valuesEntry")
}

fn attribute(element: &BytesStart, key: &str) -> Option<String> {
    let found = element.try_get_attribute(key).ok().flatten()?;
    let plain = quick_xml::escape::unescape(&found.value).map(String::from);
    Some(plain.unwrap_or_else(|_| found.value.to_string()))
}

fn number(key: &str, text: Option<String>) -> Result<Option<f64>, String> {
    let Some(text) = text else {
        return Ok(None);
    };
    match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(Some(number)),
        _ => Err(format!("{key} \"{text}\" is no number")),
    }
}

fn mark(key: &str, text: Option<String>, usual: u8) -> Result<u8, String> {
    match text.as_deref().map(str::as_bytes) {
        None => Ok(usual),
        Some(b"\\t") => Ok(b'\t'),
        Some([byte]) if byte.is_ascii() => Ok(*byte),
        Some(_) => {
            let text = text.unwrap_or_default();
            Err(format!("{key} \"{text}\" is no character"))
        }
    }
}

fn kind(word: Option<&str>) -> Result<Kind, String> {
    let Some(word) = word else {
        return Err("has no dataType".into());
    };
    Ok(match word.to_ascii_lowercase().as_str() {
        "int8" => Kind::I8,
        "uint8" => Kind::U8,
        "int16" => Kind::I16,
        "uint16" => Kind::U16,
        "int32" => Kind::I32,
        "uint32" => Kind::U32,
        "int64" => Kind::I64,
        "uint64" => Kind::U64,
        "float" => Kind::F32,
        "double" => Kind::F64,
        _ => return Err(format!("dataType \"{word}\"")),
    })
}

/// Nanoseconds since 1970 of `2008-07-04T13:27:57.250`.
fn nanoseconds(text: &str) -> Option<i64> {
    let (date, time) = text.trim().split_once('T')?;
    let three = |text: &str, by: char| -> Option<[i64; 3]> {
        let parts: Vec<i64> = text.split(by).map_while(|p| p.parse().ok()).collect();
        parts.try_into().ok()
    };
    let (whole, fraction) = time.split_once('.').unwrap_or((time, ""));
    let ([year, month, day], [hour, minute, second]) = (three(date, '-')?, three(whole, ':')?);
    let there = (1..=12).contains(&month)
        && (1..=31).contains(&day)
        && (0..24).contains(&hour)
        && (0..60).contains(&minute)
        && (0..=60).contains(&second)
        && (1900..2200).contains(&year)
        && fraction.len() <= 9
        && fraction.bytes().all(|b| b.is_ascii_digit());
    if !there {
        return None;
    }
    let day = days(year, month, day);
    let second = day * 86_400 + (hour * 60 + minute) * 60 + second;
    let part: i64 = format!("{fraction:0<9}").parse().ok()?;
    second.checked_mul(1_000_000_000)?.checked_add(part)
}

#[cfg(test)]
mod tests {
    use super::nanoseconds;

    #[test]
    fn known_times() {
        // `date -u -d 2008-07-04T13:27:57 +%s` says 1215178077.
        let whole = 1_215_178_077_000_000_000;
        assert_eq!(nanoseconds("2008-07-04T13:27:57"), Some(whole));
        let part = nanoseconds("2008-07-04T13:27:57.25");
        assert_eq!(part, Some(whole + 250_000_000));
        for none in [
            "",
            "2008-07-04",
            "2008-13-04T13:27:57",
            "2008-07-04T13:27:57.x",
        ] {
            assert_eq!(nanoseconds(none), None, "{none}");
        }
    }
}
