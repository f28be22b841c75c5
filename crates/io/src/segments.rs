//! `segments.csv`: standstills given by hand, with or without their attitude.

use crate::attitude::{AttitudeColumns, GivenAttitude, TrueAcceleration};
use crate::field::parse_number;
use crate::sheet::{Place, Sheet, SheetRow};
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
    /// The true acceleration, where the table gives it itself.
    #[serde(skip)]
    pub acceleration: Option<TrueAcceleration>,
    /// Name for the report.
    pub label: Option<String>,
}

impl SegmentRow {
    /// Reads a table of segments and checks it against a recording.
    ///
    /// Columns `start`, `end` are sample indices from zero, the end not included; `start_s`, `end_s` are times in
    /// the scale of the recording. The attitude is one of the forms of [`AttitudeColumns`], left empty where it is not known.
    /// `label` is free.
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

    /// What the row says of the attitude, as it was given.
    pub fn given_attitude(&self) -> Option<GivenAttitude> {
        let direction = self.attitude?;
        Some(GivenAttitude {
            acceleration: self.acceleration,
            ..GivenAttitude::from(direction)
        })
    }

    fn read_inner(source: Source, recording: &Recording) -> Result<(Vec<Self>, Input)> {
        let mut sheet = Sheet::from_source(source, "table of segments")?;
        let table = Header::new(&mut sheet)?;
        let segments = sheet
            .rows()
            .map(|row| match table.segment(&row, recording) {
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
    attitude: Option<AttitudeColumns>,
    label: Option<Place>,
}

impl Header {
    fn new(sheet: &mut Sheet) -> Result<Self> {
        for name in ["start", "end", "start_s", "end_s"] {
            sheet.text(name);
        }
        let attitude = AttitudeColumns::claim(sheet)?;
        let label = sheet.text("label");
        sheet.finish()?;
        let at = |name: &str| sheet.header().iter().position(|h| h == name);
        let (start, end, in_seconds) = match (at("start"), at("end"), at("start_s"), at("end_s")) {
            (Some(start), Some(end), None, None) => (start, end, false),
            (None, None, Some(start), Some(end)) => (start, end, true),
            _ => {
                return Err(Error::new(
                    ErrorKind::Column,
                    "the columns that say where a segment begins and ends are missing or mixed",
                )
                .line(sheet.header_line())
                .with_hint(
                    "give `start` and `end` (sample indices) or `start_s` and `end_s` (seconds)",
                ));
            }
        };
        Ok(Self {
            start,
            end,
            in_seconds,
            attitude,
            label,
        })
    }

    fn segment(&self, row: &SheetRow<'_>, recording: &Recording) -> Result<SegmentRow> {
        let fields = row.fields();
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
        let attitude = match &self.attitude {
            Some(columns) => columns.of(row)?,
            None => None,
        };
        let label = self.label.map(|place| row.text(place).to_owned());
        Ok(SegmentRow {
            start,
            end,
            attitude: attitude.map(|a| a.direction),
            acceleration: attitude.and_then(|a| a.acceleration),
            label: label.filter(|l| !l.is_empty()),
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
