//! `segments.csv`: standstills given by hand, with or without their attitude.

use crate::field::parse_number;
use crate::sheet::Sheet;
use crate::{Error, ErrorKind, Input, Recording, Result, Source};
use proofmass_uncertainty::DecimalMark;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// One standstill.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SegmentRow {
    /// First sample.
    pub start: usize,
    /// One past the last sample.
    pub end: usize,
    /// Unit vector of the true specific force in the sensor's frame (the direction that points up).
    pub attitude: Option<[f64; 3]>,
    /// Name for the report.
    pub label: Option<String>,
}

const KEYS: &[&str] = &[
    "start",
    "end",
    "start_s",
    "end_s",
    "up_x",
    "up_y",
    "up_z",
    "direction",
    "label",
];

impl SegmentRow {
    /// Reads a table of segments and checks it against a recording.
    ///
    /// Columns `start`, `end` are sample indices from zero, the end not included; `start_s`, `end_s` are times in
    /// the scale of the recording. The attitude is `up_x`, `up_y`, `up_z` (scaled to length one) or `direction`
    /// (`+x`, `-z`); both may be left empty in a row. `label` is free.
    ///
    /// # Errors
    /// An unknown or missing column, a field that is no number, a segment that is reversed, lies outside the
    /// recording or overlaps another: each with its line.
    pub fn read(path: &Path, recording: &Recording) -> Result<Vec<Self>> {
        Self::from_source(Source::open(path)?, recording).map(|(segments, _)| segments)
    }

    /// Reads a table of segments from a source; its name and digest come with it.
    ///
    /// # Errors
    /// As [`SegmentRow::read`].
    pub fn from_source(source: Source, recording: &Recording) -> Result<(Vec<Self>, Input)> {
        let name = source.name().to_path_buf();
        Self::read_inner(source, recording).map_err(|e| e.at(&name))
    }

    fn read_inner(source: Source, recording: &Recording) -> Result<(Vec<Self>, Input)> {
        let sheet = Sheet::from_source(source, "table of segments")?;
        let table = Header::new(sheet.header()).map_err(|e| e.line(sheet.header_line()))?;
        let segments = sheet
            .rows()
            .map(|row| match table.segment(row.fields(), recording) {
                Ok(segment) => Ok((row.line, segment)),
                Err(e) => Err(e.line(row.line)),
            })
            .collect::<Result<Vec<(u64, Self)>>>()?;
        let mut order: Vec<&(u64, Self)> = segments.iter().collect();
        order.sort_by_key(|(_, s)| s.start);
        for pair in order.windows(2) {
            let ((line_a, a), (line_b, b)) = (pair[0], pair[1]);
            if b.start < a.end {
                return Err(Error::new(
                    ErrorKind::Row,
                    format!(
                        "the segment (samples {} to {}) overlaps that of line {} (samples {} to {})",
                        b.start, b.end, line_a, a.start, a.end
                    ),
                )
                .line(*line_b)
                .with_hint("a sample may belong to one standstill only; the end is not included"));
            }
        }
        Ok((segments.into_iter().map(|(_, s)| s).collect(), sheet.input))
    }
}

struct Header {
    start: usize,
    end: usize,
    in_seconds: bool,
    up: Option<[usize; 3]>,
    direction: Option<usize>,
    label: Option<usize>,
}

impl Header {
    fn new(header: &[String]) -> Result<Self> {
        for name in header {
            if !KEYS.contains(&name.as_str()) {
                let near = crate::spelling::nearest(name, KEYS.iter().copied())
                    .map_or(String::new(), |k| format!("did you mean `{k}`? "));
                return Err(Error::new(ErrorKind::Column, "unknown column")
                    .column(name)
                    .with_hint(format!("{near}valid here: {}", KEYS.join(", "))));
            }
        }
        let at = |name: &str| header.iter().position(|h| h == name);
        let (start, end, in_seconds) = match (at("start"), at("end"), at("start_s"), at("end_s")) {
            (Some(start), Some(end), None, None) => (start, end, false),
            (None, None, Some(start), Some(end)) => (start, end, true),
            _ => {
                return Err(Error::new(
                    ErrorKind::Column,
                    "the columns that say where a segment begins and ends are missing or mixed",
                )
                .with_hint(
                    "give `start` and `end` (sample indices) or `start_s` and `end_s` (seconds)",
                ));
            }
        };
        let up = match (at("up_x"), at("up_y"), at("up_z")) {
            (Some(x), Some(y), Some(z)) => Some([x, y, z]),
            (None, None, None) => None,
            _ => {
                return Err(
                    Error::new(ErrorKind::Column, "of up_x, up_y, up_z some are missing")
                        .with_hint("give all three components, or `direction`"),
                );
            }
        };
        let direction = at("direction");
        if up.is_some() && direction.is_some() {
            return Err(Error::new(
                ErrorKind::Column,
                "`direction` and `up_x` … exclude each other",
            )
            .with_hint("keep one of the two forms; their fields may stay empty in a row"));
        }
        Ok(Self {
            start,
            end,
            in_seconds,
            up,
            direction,
            label: at("label"),
        })
    }

    fn segment(&self, fields: &[String], recording: &Recording) -> Result<SegmentRow> {
        let number = |i: usize, name: &str| {
            parse_number(fields[i].as_bytes(), DecimalMark::Point)
                .filter(|v| v.is_finite())
                .ok_or_else(|| {
                    Error::new(
                        ErrorKind::Field,
                        format!("\"{}\" is not a finite number", fields[i]),
                    )
                    .column(name)
                    .with_hint("write a number with a decimal point; only an attitude and a label may be left out")
                })
        };
        let samples = recording.samples();
        let [start, end] = if self.in_seconds {
            let time = |i: usize, name: &str| {
                let plain = number(i, name)?;
                // Exactly, where the times of the recording count from a far origin.
                Ok(recording
                    .time
                    .at(&fields[i], DecimalMark::Point)
                    .unwrap_or(plain))
            };
            let [a, b] = [time(self.start, "start_s")?, time(self.end, "end_s")?];
            let step = 1.0 / recording.time.rate_hz();
            let first = recording.time.seconds(0);
            let last = recording.time.seconds(samples - 1) + step;
            // Half a step of grace: times in a table are rounded.
            for (t, name) in [(a, "start_s"), (b, "end_s")] {
                if t < first - 0.5 * step || t > last + 0.5 * step {
                    return Err(Error::new(
                        ErrorKind::Row,
                        format!(
                            "{} s lies outside the recording, which lasts from {first} s to {last} s{}",
                            t,
                            match recording.time.origin().value() {
                                0.0 => String::new(),
                                _ => " counted from its first time stamp".into(),
                            }
                        ),
                    )
                    .column(name)
                    .with_hint("times are in the scale of the recording's own time, in seconds"));
                }
            }
            if b <= a {
                return Err(reversed(&format!("{a} s"), &format!("{b} s")));
            }
            [recording.time.index_at(a), recording.time.index_at(b)]
        } else {
            let index = |i, name| {
                let v = number(i, name)?;
                if v < 0.0 || v.fract() != 0.0 || v > samples as f64 {
                    return Err(Error::new(
                        ErrorKind::Row,
                        format!("{v} is not a sample of the recording, which has samples 0 to {}", samples - 1),
                    )
                    .column(name)
                    .with_hint("give whole numbers from zero, the end not included; for seconds name the columns start_s and end_s"));
                }
                Ok(v as usize)
            };
            [index(self.start, "start")?, index(self.end, "end")?]
        };
        if end <= start {
            return Err(reversed(&start.to_string(), &end.to_string()));
        }
        let attitude = match (self.up, self.direction) {
            (Some(up), _) if up.iter().any(|&i| !fields[i].is_empty()) => {
                let v = [
                    number(up[0], "up_x")?,
                    number(up[1], "up_y")?,
                    number(up[2], "up_z")?,
                ];
                let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
                // Directions are often typed with three digits; a length far from one is a mistake.
                if (length - 1.0).abs() > 0.01 {
                    return Err(Error::new(ErrorKind::Row, format!("the direction ({}, {}, {}) has the length {length:.4}", v[0], v[1], v[2]))
                        .column("up_x")
                        .with_hint("give a unit vector: the direction of the true specific force in the sensor's frame"));
                }
                Some(v.map(|c| c / length))
            }
            (_, Some(i)) if !fields[i].is_empty() => Some(direction(&fields[i])?),
            _ => None,
        };
        let label = self
            .label
            .map(|i| fields[i].clone())
            .filter(|l| !l.is_empty());
        Ok(SegmentRow {
            start,
            end,
            attitude,
            label,
        })
    }
}

fn reversed(start: &str, end: &str) -> Error {
    Error::new(
        ErrorKind::Row,
        format!("the segment ends at {end}, not after its start at {start}"),
    )
    .with_hint("the end is not included, so it must be larger than the start")
}

fn direction(word: &str) -> Result<[f64; 3]> {
    let text = word.to_ascii_lowercase().replace('−', "-");
    let (sign, axis) = match text.strip_prefix('-') {
        Some(axis) => (-1.0, axis),
        None => (1.0, text.strip_prefix('+').unwrap_or(&text)),
    };
    let mut v = [0.0; 3];
    match axis {
        "x" => v[0] = sign,
        "y" => v[1] = sign,
        "z" => v[2] = sign,
        _ => {
            return Err(
                Error::new(ErrorKind::Field, format!("\"{word}\" is not a direction"))
                    .column("direction")
                    .with_hint(
                        "write +x, -x, +y, -y, +z or -z: the axis of the sensor that points up",
                    ),
            );
        }
    }
    Ok(v)
}
