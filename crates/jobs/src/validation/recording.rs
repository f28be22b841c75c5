//! A calibration and a new recording as files have them.

use super::ValidationData;
use super::averages::Averages;
use crate::block_clock::{BlockClock, stands_still};
use crate::multi_position::{pauses, segment, shortest_pause};
use crate::record::Record;
use crate::recording::RecordingReading;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_documents::CalibrationFile;
use proofmass_io::{
    ClockUnit, Input, Layout, LayoutOptions, Recording, RowReader, SegmentRow, Source,
};
use proofmass_static::Segment;
use proofmass_uncertainty::Finding;
use proofmass_uncertainty::findings::averaged_record;

/// A calibration, a recording of the same sensor in its unit, and standstills where they are given.
#[derive(Clone, Debug)]
pub struct ValidationRecording {
    calibration: CalibrationFile,
    outputs: [Vec<f64>; 3],
    rate: f64,
    breaks: Vec<usize>,
    segments: Option<Vec<Segment>>,
    findings: Vec<Finding>,
    sha256: String,
    name: String,
    inputs: Vec<Input>,
}

impl ValidationRecording {
    /// Rows, or means of rows, that are kept at most of a recording that is streamed.
    pub const MOST_ROWS: usize = 1 << 20;

    /// Longest mean, s: a quarter of the shortest standstill. A longer one joins rest and motion, and what it reads is neither.
    pub const LONGEST_MEAN: f64 = 0.25;

    /// Reads the calibration, the recording, and the table of standstills where one is given.
    ///
    /// # Errors
    /// A file that cannot be read; columns that the calibration does not know, in a unit that is not its own.
    pub fn read(
        calibration: Source,
        recording: Source,
        reading: &RecordingReading,
        segments: Option<Source>,
    ) -> Result<Self> {
        let name = recording.name().display().to_string();
        let (calibration, of_calibration) = CalibrationFile::from_source(calibration)?;
        let mut recording = recording;
        // A stream that is chosen is opened once, and its columns are looked for by the reader.
        if reading.choice.source.is_none() && !reading.choice.raw {
            reading.choice.marks.mark(&mut recording);
            let layout = Layout::of(&mut recording, &LayoutOptions::default())?;
            let any = calibration.clone().into();
            for column in reading.signals(&any)? {
                let found = layout.find(&column);
                found.map_err(|e| reading.not_of_calibration(e, &any).detail(name.clone()))?;
            }
        }
        let mut recording = Recording::from_source(recording, &reading.options(&calibration)?)?;
        let columns = recording.reading().columns.iter();
        let selected: Vec<usize> = columns.map(|c| c.number - 1).collect();
        let factors = reading
            .factors(calibration.input_unit, &recording.layout, &selected)
            .map_err(|trouble| trouble.detail(name.clone()))?;
        for (column, factor) in recording.columns.iter_mut().zip(factors) {
            column.data.iter_mut().for_each(|v| *v *= factor);
        }
        let given = segments.map(|source| SegmentRow::from_source(source, &recording));
        let (rows, of_segments) = given.transpose()?.unzip();
        let (rate, breaks) = (recording.time.rate_hz(), pauses(&recording));
        let input = recording.input();
        let findings = recording.findings().to_vec();
        let columns: Vec<Vec<f64>> = recording.columns.into_iter().map(|c| c.data).collect();
        let outputs = match columns.as_slice() {
            [one] => [one.clone(), one.clone(), one.clone()],
            _ => <[Vec<f64>; 3]>::try_from(columns)
                .map_err(|_| Trouble::data("three columns are needed").detail(name.clone()))?,
        };
        Ok(Self {
            calibration,
            outputs,
            rate,
            breaks,
            segments: rows.map(|rows| rows.into_iter().map(segment).collect()),
            findings,
            sha256: input.sha256.clone(),
            name,
            inputs: [of_calibration, input]
                .into_iter()
                .chain(of_segments)
                .collect(),
        })
    }

    /// The same in memory that does not grow with the recording: rows are averaged in pairs, as often as it takes to keep
    /// [`MOST_ROWS`](Self::MOST_ROWS) of them. Standstills are found.
    ///
    /// # Errors
    /// As [`ValidationRecording::read`]; stamps that run backwards, neither rate nor time column; a recording so long that a
    /// mean would take more than [`LONGEST_MEAN`](Self::LONGEST_MEAN), some seventy hours.
    pub fn stream(
        calibration: Source,
        recording: Source,
        reading: &RecordingReading,
        watch: &dyn Watch,
    ) -> Result<Self> {
        let name = recording.name().display().to_string();
        let mut recording = reading.choice.stream_of(recording);
        let (calibration, of_calibration) = CalibrationFile::from_source(calibration)?;
        let layout = Layout::of(&mut recording, &LayoutOptions::default())?;
        let mut selected = Vec::new();
        let any = calibration.clone().into();
        for column in reading.signals(&any)? {
            let index = layout.find(&column).map_err(|e| {
                let trouble = reading.not_of_calibration(e, &any);
                trouble.detail(name.clone())
            })?;
            selected.push(index);
        }
        let factors = reading
            .factors(calibration.input_unit, &layout, &selected)
            .map_err(|trouble| trouble.detail(name.clone()))?;
        let signals = selected.len();
        let mut findings = layout.findings();
        let time = match (&reading.time, reading.rate) {
            (Some(column), _) => Some(layout.find(column)?),
            (None, Some(_)) => None,
            (None, None) => layout.time_column(),
        };
        let mut read = reading.of_stream(&layout, &selected, None)?;
        let mut clock = match (time, reading.rate) {
            (Some(index), rate) => {
                let unit = ClockUnit::of(&layout, index, reading.time_unit, rate, false)
                    .map_err(|e| Trouble::from(e.at(recording.name())))?;
                findings.extend(unit.finding.clone());
                read = reading.of_stream(&layout, &selected, Some((index, &unit)))?;
                BlockClock::stamped(unit.per_second, rate).in_order()
            }
            (None, Some(rate)) => BlockClock::steady(rate),
            (None, None) => {
                return Err(layout.ask_clock().at(recording.name()).into());
            }
        };
        selected.extend(time);
        let window = clock.window(read.between_s, signals);
        let mut reader = RowReader::new(recording, layout, &selected)?.between(window);
        let size = reader.size().unwrap_or(0);
        let mut averages = Averages::new(Self::MOST_ROWS);
        let mut rows = 0;
        while let Some(block) = reader.next_block()? {
            watch.step("reading", reader.bytes_read(), size)?;
            let mut breaks = Vec::new();
            if time.is_some() {
                breaks = clock.pauses(block.column(signals), shortest_pause).map_err(|(row, what)| {
                    Trouble::data(what)
                        .detail(format!("{name}:{}", block.line(row)))
                        .with_hint("look for a restart of the clock or a doubled row, or give --rate in place of the time column")
                })?;
            }
            let mut breaks = breaks.into_iter().peekable();
            for row in 0..block.rows() {
                if breaks.next_if_eq(&row).is_some() {
                    averages.pause();
                }
                let of = |k: usize| block.column(k)[row] * factors[k];
                averages.push([0, 1, 2].map(|k| of(k.min(signals - 1))));
            }
            rows += block.rows();
            let mean = clock
                .rate()
                .map_or(0.0, |rate| averages.rows_of_one() as f64 / rate);
            if averages.rows_of_one() > 1 && mean > Self::LONGEST_MEAN {
                return Err(
                    Trouble::data("the recording is too long to be validated at once")
                        .detail(format!(
                            "{name}: {rows} rows so far, of which means of {mean:.2} s would be kept; standstills of a second need {} s",
                            Self::LONGEST_MEAN
                        ))
                        .with_hint("validate a part of it, with --between FROM TO"),
                );
            }
        }
        findings.extend(reader.findings());
        read.time.rate_hz = clock.rate();
        let input = reader.finish()?.with_reading(read);
        let (outputs, breaks, per) = averages.finish();
        let rate = clock.rate().ok_or_else(|| stands_still(&name))? / per as f64;
        if per > 1 {
            findings.push(averaged_record(
                &format!("means of {per} rows stand for them"),
                &format!("{rows} rows, {rate:.3} means in a second"),
                "standstills of fewer than five means are not seen: validate a part by itself where they are short",
            ));
        }
        Ok(Self {
            calibration,
            outputs,
            rate,
            breaks,
            segments: None,
            findings,
            sha256: input.sha256.clone(),
            name,
            inputs: vec![of_calibration, input],
        })
    }

    /// For the job.
    pub fn data(&self) -> ValidationData<'_> {
        let [x, y, z] = &self.outputs;
        ValidationData {
            calibration: &self.calibration,
            outputs: [x, y, z],
            rate: self.rate,
            breaks: &self.breaks,
            segments: self.segments.as_deref(),
            findings: &self.findings,
            sha256: Some(&self.sha256),
            name: &self.name,
        }
    }

    /// What a result is filed with.
    pub fn record(&self, date: Option<String>) -> Record {
        Record {
            device: self.calibration.device.clone(),
            date,
            inputs: self.inputs.clone(),
            ..Record::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_core::Unwatched;
    use proofmass_io::Unit;
    use proofmass_uncertainty::Estimate;

    fn calibration() -> Source {
        let k = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let estimate = Estimate::new(vec![], vec![]).expect("nothing");
        let file = CalibrationFile::new("full", Unit::Count, k, [0.0; 3], estimate);
        Source::from_bytes("c.json", file.to_json().expect("a document")).expect("bytes")
    }

    fn streamed(rate: f64) -> Result<ValidationRecording> {
        let rows = ValidationRecording::MOST_ROWS + 70_000;
        let mut text = String::from("x_count,y_count,z_count\n");
        for k in 0..rows {
            text.push_str(["1,2,3\n", "3,2,1\n"][k % 2]);
        }
        let reading = RecordingReading {
            columns: Some(vec!["x".into(), "y".into(), "z".into()]),
            rate: Some(rate),
            ..RecordingReading::default()
        };
        let recording = Source::from_bytes("long.csv", text).expect("bytes");
        ValidationRecording::stream(calibration(), recording, &reading, &Unwatched)
    }

    #[test]
    fn known_means_stand_for_more_than_a_million_rows() {
        let long = streamed(100.0).expect("three hours");
        let data = long.data();
        assert_eq!(
            data.outputs[0].len(),
            (ValidationRecording::MOST_ROWS + 70_000) / 2
        );
        assert!(data.outputs.iter().all(|o| o.iter().all(|v| *v == 2.0)));
        assert!((data.rate - 50.0).abs() < 1e-9);
        assert_eq!(data.findings[0].code(), "averaged-record");
    }

    #[test]
    fn refuses_means_that_would_join_rest_and_motion() {
        // Two samples at 5 Hz are 0.4 s.
        let refused = streamed(5.0).map(|_| ());
        assert!(refused.is_err_and(|e| e.to_string().contains("too long")));
    }
}
