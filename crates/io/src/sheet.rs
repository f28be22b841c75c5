//! A small table with a header: fields with their lines, and numbers in the unit their column names.

use crate::field::{is_reading, parse_number, shown};
use crate::layout::sniff;
use crate::source::LARGEST_DOCUMENT;
use crate::{Error, ErrorKind, Input, Result, Source};
use proofmass_uncertainty::DecimalMark;
use std::path::{Path, PathBuf};

/// Unit endings of the headings of one quantity, and what a number is multiplied with to be in SI.
pub type Endings = &'static [(&'static str, f64)];

/// One degree in rad.
pub const DEGREE: f64 = std::f64::consts::PI / 180.0;
const G: f64 = proofmass_core::STANDARD_GRAVITY;

/// Frequencies.
pub const FREQUENCY: Endings = &[("Hz", 1.0), ("kHz", 1e3)];
/// Angles.
pub const ANGLE: Endings = &[("deg", DEGREE), ("rad", 1.0)];
/// Voltages.
pub const VOLTAGE: Endings = &[("V", 1.0), ("mV", 1e-3), ("uV", 1e-6)];
/// Accelerations.
pub const ACCELERATION: Endings = &[("m/s2", 1.0), ("g", G), ("mg", 1e-3 * G)];
/// Densities of accelerations.
pub const ACCELERATION_DENSITY: Endings = &[("(m/s2)2/Hz", 1.0), ("m2/s3", 1.0), ("g2/Hz", G * G)];
/// Levels.
pub const DECIBEL: Endings = &[("dB", 1.0)];
/// Slopes of a density.
pub const SLOPE: Endings = &[("dB/oct", 1.0), ("dB/octave", 1.0)];
/// Counts of a converter.
pub const COUNT: Endings = &[("count", 1.0), ("counts", 1.0), ("LSB", 1.0)];
/// Velocities.
pub const VELOCITY: Endings = &[("m/s", 1.0), ("mm/s", 1e-3), ("um/s", 1e-6)];
/// Sensitivities of transducers with voltage output.
pub const SENSITIVITY: Endings = &[
    ("V/(m/s2)", 1.0),
    ("mV/(m/s2)", 1e-3),
    ("V/g", 1.0 / G),
    ("mV/g", 1e-3 / G),
];
/// Sensitivities of sensors that give an acceleration.
pub const ACCELERATION_RATIO: Endings = &[
    ("(m/s2)/(m/s2)", 1.0),
    ("m/s2/(m/s2)", 1.0),
    ("g/g", 1.0),
    ("1", 1.0),
    ("mg/g", 1e-3),
    ("g/(m/s2)", G),
    ("(m/s2)/g", 1.0 / G),
];
/// Sensitivities of sensors that give counts.
pub const COUNT_SENSITIVITY: Endings = &[
    ("count/(m/s2)", 1.0),
    ("LSB/(m/s2)", 1.0),
    ("count/g", 1.0 / G),
    ("LSB/g", 1.0 / G),
];
/// A pure number; the heading may stand without an ending.
pub const RATIO: Endings = &[("", 1.0), ("%", 0.01)];
/// A pure number whose heading must say whether it is in percent.
pub const PERCENT: Endings = &[("%", 0.01), ("1", 1.0)];

/// Units as results state them, each with what is turned into it.
const COHERENT: [(&str, Endings); 8] = [
    ("V/(m/s²)", SENSITIVITY),
    ("count/(m/s²)", COUNT_SENSITIVITY),
    ("m/s²", ACCELERATION),
    ("V", VOLTAGE),
    ("m/s", VELOCITY),
    ("Hz", FREQUENCY),
    ("rad", ANGLE),
    ("1", PERCENT),
];

/// The unit in which results state what has this one, and what a number is multiplied with; a unit that is not known stays as it is.
pub fn coherent(unit: &str) -> (&str, f64) {
    let plain = unit
        .trim()
        .replace('²', "2")
        .replace("^2", "2")
        .replace(['µ', 'μ'], "u");
    let known = COHERENT.iter().find_map(|(coherent, endings)| {
        let (_, factor) = endings.iter().find(|(ending, _)| *ending == plain)?;
        Some((*coherent, *factor))
    });
    known.unwrap_or((unit, 1.0))
}

/// Headings that are for people and never read.
const FREE: &[&str] = &["note", "comment", "operator", "date", "time"];

/// A table in memory. Comment lines begin with `#`; the separator is comma, semicolon or tabulator.
#[non_exhaustive]
pub struct Sheet {
    path: PathBuf,
    /// Path and digest.
    pub input: Input,
    what: &'static str,
    header: Vec<String>,
    header_line: u64,
    decimal: DecimalMark,
    rows: Vec<(u64, Vec<String>)>,
    claimed: Vec<bool>,
    valid: Vec<String>,
}

/// Where a quantity stands, and its factor to SI.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    column: usize,
    factor: f64,
}

/// One row.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct SheetRow<'a> {
    sheet: &'a Sheet,
    /// Line in the file, counted from one.
    pub line: u64,
    fields: &'a [String],
}

impl Sheet {
    /// Reads a whole table; `what` names it in messages ("table of runs").
    ///
    /// # Errors
    /// A missing or empty file, a header without rows, a heading given twice, a row of another width.
    pub fn read(path: &Path, what: &'static str) -> Result<Self> {
        Self::from_source(Source::open(path)?, what)
    }

    /// Reads a whole table from a source.
    ///
    /// # Errors
    /// As [`Sheet::read`].
    pub fn from_source(source: Source, what: &'static str) -> Result<Self> {
        let name = source.name().to_path_buf();
        Self::read_inner(source, what).map_err(|e| e.at(&name))
    }

    fn read_inner(source: Source, what: &'static str) -> Result<Self> {
        let path = source.name().to_path_buf();
        let (bytes, input) = source.into_bytes(LARGEST_DOCUMENT)?;
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&bytes);
        if bytes.contains(&0) {
            return Err(
                Error::new(ErrorKind::Format, format!("the {what} is not a text"))
                    .with_hint("give a CSV file: a header and one row per line"),
            );
        }
        let first = (1..)
            .zip(bytes.split(|b| *b == b'\n'))
            .find(|(_, l)| !passed_over(l));
        let Some((header_line, first)) = first else {
            return Err(
                Error::new(ErrorKind::Format, format!("the {what} is empty"))
                    .with_hint("write a header and one row per line below it"),
            );
        };
        let delimiter = [b';', b'\t', b',']
            .into_iter()
            .find(|b| first.contains(b))
            .unwrap_or(b',');
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(delimiter)
            .comment(Some(b'#'))
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(bytes);
        let header: Vec<String> = reader
            .byte_headers()
            .map_err(|e| Error::new(ErrorKind::Format, e.to_string()))?
            .iter()
            .map(sniff::decode)
            .collect();
        for (i, name) in header.iter().enumerate() {
            if header[..i].contains(name) && !name.is_empty() {
                return Err(
                    Error::new(ErrorKind::Column, "the column stands twice in the header")
                        .line(header_line)
                        .column(name)
                        .with_hint("keep one of the two"),
                );
            }
        }
        let mut rows: Vec<(u64, Vec<String>)> = Vec::new();
        for record in reader.byte_records() {
            let record = record.map_err(|e| Error::new(ErrorKind::Row, e.to_string()))?;
            let line = record.position().map_or(0, |p| {
                // The position is that before the comments above the record.
                let rest = &bytes[(p.byte() as usize).min(bytes.len())..];
                p.line() + rest.split(|b| *b == b'\n').take_while(passed_over).count() as u64
            });
            let fields: Vec<String> = record.iter().map(sniff::decode).collect();
            if fields.iter().all(String::is_empty) {
                continue;
            }
            if fields.len() != header.len() {
                return Err(Error::new(
                    ErrorKind::Row,
                    format!(
                        "the row has {} fields, the header has {}",
                        fields.len(),
                        header.len()
                    ),
                )
                .line(line)
                .with_hint(
                    "give every row as many fields as the header; a file cut short ends like this",
                ));
            }
            rows.push((line, fields));
        }
        if rows.is_empty() {
            return Err(
                Error::new(ErrorKind::Format, format!("the {what} holds no rows"))
                    .with_hint("write one row per line below the header"),
            );
        }
        Ok(Self {
            path,
            input,
            what,
            claimed: vec![false; header.len()],
            header,
            header_line,
            // A comma that does not separate fields is the decimal mark.
            decimal: if delimiter == b',' {
                DecimalMark::Point
            } else {
                DecimalMark::Comma
            },
            rows,
            valid: Vec::new(),
        })
    }

    /// The column of a text, by its heading.
    pub fn text(&mut self, name: &str) -> Option<Place> {
        self.valid.push(name.to_owned());
        let column = self.header.iter().position(|h| h == name)?;
        self.claimed[column] = true;
        Some(Place {
            column,
            factor: 1.0,
        })
    }

    /// The column of a quantity: its name and one of the endings, as in `x_mV`, `x (mV)` or `x [mV]`.
    ///
    /// # Errors
    /// The quantity stands twice, in two units, or without any.
    pub fn quantity(&mut self, name: &str, endings: Endings) -> Result<Option<Place>> {
        let spell = |ending: &str| match ending {
            "" => name.to_owned(),
            ending => format!("{name}_{ending}"),
        };
        self.valid.extend(endings.iter().map(|(e, _)| spell(e)));
        let mut found: Option<Place> = None;
        for (column, heading) in self.header.iter().enumerate() {
            let plain = plain(heading);
            if let Some(&(_, factor)) = endings.iter().find(|(e, _)| plain == spell(e)) {
                self.claimed[column] = true;
                if found.replace(Place { column, factor }).is_some() {
                    return Err(self
                        .header_error(heading, "the quantity stands in two columns")
                        .with_hint("keep one of the two"));
                }
            } else if plain == name {
                let list: Vec<String> = endings.iter().map(|(e, _)| spell(e)).collect();
                return Err(self
                    .header_error(heading, "the heading does not say the unit")
                    .with_hint(format!("write {}", list.join(" or "))));
            }
        }
        Ok(found)
    }

    /// The column of a quantity that may be of one of several kinds, and which it is.
    ///
    /// # Errors
    /// As [`Sheet::quantity`]; two kinds at once.
    pub fn one_of(&mut self, name: &str, kinds: &[Endings]) -> Result<Option<(usize, Place)>> {
        let bare = self.header.iter().find(|h| plain(h) == name).cloned();
        let unlike = |kind: &Endings| kind.iter().all(|(ending, _)| !ending.is_empty());
        if let Some(heading) = bare.filter(|_| kinds.iter().all(unlike)) {
            let endings = kinds.iter().flat_map(|kind| kind.iter());
            let list: Vec<String> = endings.map(|(e, _)| format!("{name}_{e}")).collect();
            return Err(self
                .header_error(&heading, "the heading does not say the unit")
                .with_hint(format!("write {}", list.join(" or "))));
        }
        let mut found: Option<(usize, Place)> = None;
        for (kind, endings) in kinds.iter().enumerate() {
            let Some(place) = self.quantity(name, endings)? else {
                continue;
            };
            if found.replace((kind, place)).is_some() {
                let heading = self.header[place.column].clone();
                return Err(self
                    .header_error(&heading, "the quantity stands in two columns")
                    .with_hint("keep one of the two"));
            }
        }
        Ok(found)
    }

    /// Refuses headings that nothing asked for.
    ///
    /// # Errors
    /// The first unknown heading, with the nearest valid one.
    pub fn finish(&self) -> Result<()> {
        for (heading, claimed) in self.header.iter().zip(&self.claimed) {
            if *claimed || heading.is_empty() || FREE.contains(&heading.as_str()) {
                continue;
            }
            let near =
                crate::spelling::nearest(&plain(heading), self.valid.iter().map(String::as_str))
                    .map_or(String::new(), |k| format!("did you mean `{k}`? "));
            return Err(self
                .header_error(
                    heading,
                    &format!(
                        "the file is read as a {}, which has no such column",
                        self.what
                    ),
                )
                .with_hint(format!(
                    "{near}valid here: {}",
                    some_of(&self.valid, heading)
                )));
        }
        Ok(())
    }

    /// A column that has to be there.
    ///
    /// # Errors
    /// It is not, with the heading to write.
    pub fn required(&self, place: Option<Place>, heading: &str) -> Result<Place> {
        place.ok_or_else(|| {
            self.header_error(heading, &format!("the {} has no such column", self.what))
                .with_hint(format!(
                    "add a column `{heading}`; the header is: {}",
                    self.header.join(", ")
                ))
        })
    }

    /// An error about the header.
    pub fn header_error(&self, heading: &str, what: &str) -> Error {
        Error::new(ErrorKind::Column, what)
            .at(&self.path)
            .line(self.header_line)
            .column(heading)
    }

    /// Whether something asked for a heading.
    pub(crate) fn is_claimed(&self, heading: &str) -> bool {
        let mut all = self.header.iter().zip(&self.claimed);
        all.any(|(own, claimed)| own == heading && *claimed)
    }

    /// The headings as they stand.
    pub fn header(&self) -> &[String] {
        &self.header
    }

    /// Line of the header.
    pub fn header_line(&self) -> u64 {
        self.header_line
    }

    /// The rows, in their order.
    pub fn rows(&self) -> impl Iterator<Item = SheetRow<'_>> {
        self.rows.iter().map(|(line, fields)| SheetRow {
            sheet: self,
            line: *line,
            fields,
        })
    }
}

impl<'a> SheetRow<'a> {
    /// All fields as they stand.
    pub fn fields(&self) -> &'a [String] {
        self.fields
    }

    /// The text of a field.
    pub fn text(&self, place: Place) -> &'a str {
        &self.fields[place.column]
    }

    /// A number in SI.
    ///
    /// # Errors
    /// An empty field, a field that is not a finite number.
    pub fn number(&self, place: Place) -> Result<f64> {
        let field = &self.fields[place.column];
        if field.is_empty() {
            return Err(self
                .refuse(place, "the field is empty")
                .with_hint("every row needs this number; nothing is filled in"));
        }
        parse_number(field.as_bytes(), self.sheet.decimal)
            .filter(|v| is_reading(*v))
            .map(|v| v * place.factor)
            .ok_or_else(|| {
                self.refuse(
                    place,
                    format!("\"{}\" is not a finite number", shown(field.as_bytes())),
                )
                .with_hint(match self.sheet.decimal {
                    DecimalMark::Comma => "the numbers of this table have a decimal comma: write it as 9,81; or take the row out",
                    _ => "write it as 9.81 or 9.81e-3, or take the row out; nothing is filled in",
                })
            })
    }

    /// A number in SI; `None` for an empty field or a column that is not there.
    ///
    /// # Errors
    /// A field that is not a finite number.
    pub fn optional(&self, place: Option<Place>) -> Result<Option<f64>> {
        match place {
            Some(place) if !self.fields[place.column].is_empty() => self.number(place).map(Some),
            _ => Ok(None),
        }
    }

    /// A number above zero.
    ///
    /// # Errors
    /// As [`SheetRow::number`], and one that is not above zero.
    pub fn positive(&self, place: Place) -> Result<f64> {
        let value = self.number(place)?;
        if value > 0.0 {
            return Ok(value);
        }
        Err(self
            .refuse(
                place,
                format!("{} is not above zero", self.fields[place.column]),
            )
            .with_hint("correct the number, or take the row out"))
    }

    /// Numbers above zero with blanks between them; of one number, that alone.
    ///
    /// # Errors
    /// As [`SheetRow::positive`], number by number.
    pub fn positives(&self, place: Place) -> Result<Vec<f64>> {
        let field = &self.fields[place.column];
        if field.split_whitespace().count() < 2 {
            return Ok(vec![self.positive(place)?]);
        }
        field
            .split_whitespace()
            .map(|word| {
                parse_number(word.as_bytes(), self.sheet.decimal)
                    .filter(|v| is_reading(*v) && *v > 0.0)
                    .map(|v| v * place.factor)
                    .ok_or_else(|| {
                        self.refuse(
                            place,
                            format!("\"{}\" is not a number above zero", shown(word.as_bytes())),
                        )
                        .with_hint(
                            "several numbers stand with blanks between them, as in \"10 20 40\"",
                        )
                    })
            })
            .collect()
    }

    /// A standard uncertainty: from zero up; zero without column or field.
    ///
    /// # Errors
    /// A negative number, or none.
    pub fn uncertainty(&self, place: Option<Place>) -> Result<f64> {
        let Some(value) = self.optional(place)? else {
            return Ok(0.0);
        };
        match place {
            Some(place) if value < 0.0 => Err(self
                .refuse(
                    place,
                    format!(
                        "an uncertainty of {} is out of range: it must not be negative",
                        self.fields[place.column]
                    ),
                )
                .with_hint("give a number from zero up")),
            _ => Ok(value),
        }
    }

    /// An error about a field.
    pub fn refuse(&self, place: Place, what: impl Into<String>) -> Error {
        Error::new(ErrorKind::Field, what)
            .at(&self.sheet.path)
            .line(self.line)
            .column(&self.sheet.header[place.column])
    }

    /// An error about a field, with where it stands.
    pub(crate) fn in_field(&self, place: Place, error: Error) -> Error {
        error
            .at(&self.sheet.path)
            .line(self.line)
            .column(&self.sheet.header[place.column])
    }

    /// An error about the row.
    pub fn refuse_row(&self, what: impl Into<String>) -> Error {
        Error::new(ErrorKind::Row, what)
            .at(&self.sheet.path)
            .line(self.line)
    }
}

/// Whether a line is blank or a comment.
fn passed_over(line: &&[u8]) -> bool {
    line.trim_ascii().is_empty() || line.starts_with(b"#")
}

/// `x (mV)` and `x [mV]` as `x_mV`; signs that have an ASCII form in it.
pub(crate) fn plain(heading: &str) -> String {
    let mut text: String = heading
        .trim()
        .chars()
        .filter(|c| *c != '^')
        .map(|c| match c {
            '²' => '2',
            'µ' | 'μ' => 'u',
            c => c,
        })
        .collect();
    for (open, close) in [(" (", ')'), (" [", ']'), ("_[", ']'), ("[", ']')] {
        if let Some(inner) = text.strip_suffix(close)
            && let Some(at) = inner.find(open)
        {
            text = format!("{}_{}", &inner[..at], &inner[at + open.len()..]);
            break;
        }
    }
    let text = match text.strip_suffix('°') {
        Some(stem) => format!("{stem}deg"),
        None => text,
    };
    text.replace(' ', "_")
}

/// Headings for a message; of many those first that begin like the one that stands there, as `U_` does.
fn some_of(valid: &[String], heading: &str) -> String {
    const MOST: usize = 12;
    let alike = |name: &&String| {
        let same = name
            .chars()
            .zip(heading.chars())
            .take_while(|(a, b)| a == b);
        std::cmp::Reverse(same.count())
    };
    let mut valid: Vec<&String> = valid.iter().collect();
    valid.sort_by_key(alike);
    let shown = valid.len().min(MOST);
    let list: Vec<&str> = valid[..shown].iter().map(|name| name.as_str()).collect();
    let list = list.join(", ");
    match valid.len() - shown {
        0 => list,
        more => format!("{list} and {more} more, each with its unit"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(text: &str) -> Result<Sheet> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        std::fs::write(&path, text).unwrap();
        Sheet::read(&path, "table")
    }

    #[test]
    fn headings_of_all_shapes() {
        for heading in ["x_mV", "x (mV)", "x [mV]", "x_[mV]", "x[mV]"] {
            assert_eq!(plain(heading), "x_mV");
        }
        assert_eq!(plain("sensitivity_V/(m/s²)"), "sensitivity_V/(m/s2)");
        assert_eq!(plain("phase [°]"), "phase_deg");
        let mut s = sheet("# a comment\nx (mV);y\n1,5;2\n").unwrap();
        let x = s.quantity("x", VOLTAGE).unwrap().unwrap();
        let row = s.rows().next().unwrap();
        assert_eq!((row.line, row.number(x).unwrap()), (3, 1.5e-3));
        let unknown = s.finish().unwrap_err();
        assert_eq!(
            (unknown.line_number(), unknown.field()),
            (Some(2), Some("y"))
        );
    }

    #[test]
    fn headings_like_the_one_that_is_refused_are_named_first() {
        let mut s = sheet("frequency_Hz,U_%\n1,2\n").unwrap();
        s.quantity("frequency", FREQUENCY).unwrap();
        s.quantity("sensitivity", SENSITIVITY).unwrap();
        s.quantity("u_sensitivity", ACCELERATION_RATIO).unwrap();
        s.quantity("U_relative", PERCENT).unwrap();
        let refused = s.finish().unwrap_err();
        let hint = refused.hint().unwrap();
        assert!(
            hint.contains("valid here: U_relative_%, U_relative_1, "),
            "{hint}"
        );
    }

    #[test]
    fn refuses_with_line_and_column() {
        let mut s = sheet("x_V,y\n1,2\nNaN,3\n").unwrap();
        let x = s.quantity("x", VOLTAGE).unwrap().unwrap();
        let bad = s.rows().nth(1).unwrap().number(x).unwrap_err();
        assert_eq!((bad.line_number(), bad.field()), (Some(3), Some("x_V")));
        assert!(s.quantity("y", VOLTAGE).is_err(), "no unit");
        assert!(s.required(None, "z_V").is_err());
        let short = sheet("x_V,y_V\n1,2\n1\n").err().unwrap();
        assert_eq!(short.line_number(), Some(3));
        assert!(sheet("").is_err() && sheet("x_V\n").is_err() && sheet("x_V,x_V\n1,2\n").is_err());
    }
}
