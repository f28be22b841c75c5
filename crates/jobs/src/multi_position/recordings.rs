//! The recordings of a campaign as one series.

use super::{MultiPositionData, MultiPositionJob, Readings};
use crate::campaign::{FileIs, GravityInput, MultiPositionCampaign, RowsAre};
use crate::outcome::Job as _;
use crate::record::{Record, read_gravity};
use crate::stored_result::StoredResult;
use crate::trouble::{Result, Trouble};
use proofmass_core::{Error, Gravity, Watch};
use proofmass_io::{ColumnRef, Input, ReadGravity, Recording, SegmentRow, Unit};
use proofmass_static::{Segment, Standstill};
use proofmass_uncertainty::Finding;

/// All recordings of a campaign, one after the other, in SI where their unit has a place in it.
#[derive(Clone, Debug)]
pub struct MultiPositionRecordings {
    outputs: [Vec<f64>; 3],
    time: Vec<f64>,
    /// Whether the times mean something: rows of a table of readings are only numbered.
    timed: bool,
    rate: f64,
    breaks: Vec<usize>,
    unit: Unit,
    temperature: Option<Vec<f64>>,
    segments: Option<Vec<Segment>>,
    readings: Option<Readings>,
    tumble: bool,
    findings: Vec<Finding>,
    name: String,
    columns: [ColumnRef; 3],
    inputs: Vec<Input>,
    /// What a value in the file is multiplied with.
    factor: f64,
}

impl MultiPositionCampaign {
    /// What there is so far, evaluated for what to add to it.
    ///
    /// # Errors
    /// As [`Campaign::evaluate`](crate::campaign::Campaign::evaluate).
    pub fn plan(&self, date: Option<String>, watch: &dyn Watch) -> Result<StoredResult> {
        let files = self.load(watch)?;
        let mut job = self.job(&files)?;
        job.plan = true;
        let record = self.record(&files, date);
        StoredResult::new(record, &job.evaluate(&files.data(), watch)?)
    }

    /// Reads the recordings and the table of standstills.
    ///
    /// # Errors
    /// A file that cannot be read, an unknown unit, recordings that do not fit together.
    pub fn load(&self, watch: &dyn Watch) -> Result<MultiPositionRecordings> {
        watch.step("reading", 0, 0)?;
        self.ask(false)?;
        let recordings = self.read_recordings()?;
        let (rows, table) = self.given_segments(&recordings)?.unzip();
        let mut attitudes = Vec::new();
        let mut segments = match rows {
            Some(rows) => {
                attitudes = rows.iter().map(SegmentRow::given_attitude).collect();
                Some(rows.into_iter().map(segment).collect())
            }
            None => self.single_standstills(&recordings)?,
        };
        if let Some(segments) = &mut segments {
            self.give_attitudes(&recordings, segments, attitudes)?;
        }
        let columns = &self.recording.columns;
        let mut all = MultiPositionRecordings::join(recordings, segments.is_some())?;
        all.segments = segments;
        if self.recording.rows == RowsAre::Readings {
            let uncertainty = self.standstill.reading_standard_uncertainty;
            all.readings = Some(Readings {
                uncertainty: uncertainty.map(|u| u * all.factor),
            });
            all.timed = self.recording.time.is_some();
        }
        all.tumble = self.recording.rows == RowsAre::Tumble;
        all.columns = [columns.x.clone(), columns.y.clone(), columns.z.clone()];
        all.inputs.splice(0..0, self.source.as_inputs());
        all.inputs.extend(table);
        Ok(all)
    }

    fn given_segments(&self, recordings: &[Recording]) -> Result<Option<(Vec<SegmentRow>, Input)>> {
        let given = match recordings {
            [only] => self.read_segments(only)?,
            _ if self.standstill.segments.is_some() => {
                return Err(Trouble::request(
                        "given standstills need a campaign of one recording",
                    )
                    .with_hint("where each file is one standstill, say so: each_file = \"standstill\" in [recording], with `directions` in [standstill] where they are known"));
            }
            _ => None,
        };
        Ok(given)
    }

    /// Standstills that need no search: one per file, or one per row.
    fn single_standstills(&self, recordings: &[Recording]) -> Result<Option<Vec<Segment>>> {
        let table = &self.recording;
        let mut segments = Vec::new();
        let mut start = 0;
        for recording in recordings {
            let end = start + recording.samples();
            if table.rows == RowsAre::Readings {
                segments.extend((start..end).map(|row| Segment {
                    start: row,
                    end: row + 1,
                    attitude: None,
                    force_uncertainty: None,
                    label: None,
                }));
            } else if table.each_file == FileIs::Standstill {
                let stem = recording.path.file_stem();
                segments.push(Segment {
                    start,
                    end,
                    attitude: None,
                    force_uncertainty: None,
                    label: stem.map(|s| s.to_string_lossy().into_owned()),
                });
            } else {
                return Ok(None);
            }
            start = end;
        }
        Ok(Some(segments))
    }

    /// The question of the campaign; a range in the unit of the file is brought to that of the data.
    ///
    /// # Errors
    /// A gravity that cannot be.
    pub fn job(&self, data: &MultiPositionRecordings) -> Result<MultiPositionJob> {
        let table = &self.standstill;
        let default = Standstill::default();
        let mut job = MultiPositionJob::new(gravity(&self.gravity)?);
        job.method = self.method.model;
        job.terms = self.terms;
        job.probability = self.method.confidence;
        job.search = Standstill {
            window: table.window_s.unwrap_or(default.window),
            minimum_duration: table.minimum_duration_s.unwrap_or(default.minimum_duration),
            threshold: table.threshold,
        };
        let attitude = &self.attitude;
        job.attitude_uncertainty = attitude.standard_uncertainty_deg.map(f64::to_radians);
        job.frame_uncertainty = attitude.frame_standard_uncertainty_deg.map(f64::to_radians);
        job.true_accelerations = attitude.a_true_relative_standard_uncertainty;
        job.range = self.recording.range.map(|r| r.map(|v| v * data.factor));
        job.largest_uncertainty = self.method.largest_uncertainty;
        job.exclude = table.exclude.iter().map(ToString::to_string).collect();
        job.temperature = self.ambient.temperature_deg_c;
        Ok(job)
    }

    /// What the result is filed with.
    pub fn record(&self, data: &MultiPositionRecordings, date: Option<String>) -> Record {
        let mut inputs = data.inputs.clone();
        state_gravity(&mut inputs, &self.gravity);
        self.filed(date, inputs)
    }
}

impl MultiPositionRecordings {
    /// Puts recordings of one sensor one after the other.
    ///
    /// `given`: the standstills need no search, and so no common rate.
    fn join(recordings: Vec<Recording>, given: bool) -> Result<Self> {
        let Some(first) = recordings.first() else {
            return Err(Trouble::request("the campaign names no recording"));
        };
        let Some(file_unit) = first.columns[0].unit else {
            let columns = &first.reading().columns;
            let signals: Vec<usize> = columns.iter().map(|c| c.number - 1).collect();
            return Err(first.layout.ask_unit(&signals).at(&first.path).into());
        };
        let (unit, factor) = file_unit.si();
        let names: Vec<String> = recordings
            .iter()
            .map(|r| r.path.display().to_string())
            .collect();
        let mut all = Self {
            outputs: Default::default(),
            time: Vec::new(),
            timed: true,
            rate: first.time.rate_hz(),
            readings: None,
            tumble: false,
            breaks: Vec::new(),
            unit,
            temperature: first.temperature.as_ref().map(|_| Vec::new()),
            segments: None,
            findings: Vec::new(),
            name: names.join(", "),
            columns: [1, 2, 3].map(ColumnRef::Index),
            inputs: Vec::new(),
            factor,
        };
        let mut offset = 0.0;
        for recording in recordings {
            offset = all.append(recording, offset, given)?;
        }
        Ok(all)
    }

    /// Appends a recording that begins at `offset`, s, and returns where it ends.
    fn append(&mut self, recording: Recording, offset: f64, given: bool) -> Result<f64> {
        let (rate, breaks) = (recording.time.rate_hz(), pauses(&recording));
        // A window counts samples: a rate that differs by a fifth makes it a fifth longer.
        if !given && (rate / self.rate - 1.0).abs() > 0.2 {
            return Err(Trouble::data(format!(
                "{}: sampled at {rate:.3} Hz, the recording before at {:.3} Hz",
                recording.path.display(),
                self.rate
            ))
            .with_hint("where each file is one standstill, say so: each_file = \"standstill\" in [recording]; else calibrate recordings of different rates as separate campaigns"));
        }
        let start = self.outputs[0].len();
        if start > 0 {
            self.breaks.push(start);
        }
        self.breaks.extend(breaks.iter().map(|at| start + at));
        let recording = recording.into_si();
        for (all, column) in self.outputs.iter_mut().zip(&recording.columns) {
            if column.unit != Some(self.unit) {
                return Err(Trouble::data(format!(
                    "{}: column {:?} is not in the unit of the other columns",
                    recording.path.display(),
                    column.name
                ))
                .with_hint("x, y and z must share one unit"));
            }
            all.extend(&column.data);
        }
        match (&mut self.temperature, &recording.temperature) {
            (Some(all), Some(column)) => all.extend(&column.data),
            (all, _) => *all = None,
        }
        let first = recording.time.seconds(0);
        self.time
            .extend((0..recording.samples()).map(|i| offset + recording.time.seconds(i) - first));
        self.findings.extend(doubts(&recording, &breaks));
        self.inputs.push(recording.input());
        Ok(offset + recording.duration_s())
    }

    /// The data as the job wants them.
    pub fn data(&self) -> MultiPositionData<'_> {
        let [x, y, z] = &self.outputs;
        MultiPositionData {
            outputs: [x, y, z],
            time: self.timed.then_some(self.time.as_slice()),
            rate: self.rate,
            breaks: &self.breaks,
            unit: self.unit,
            temperature: self.temperature.as_deref(),
            segments: self.segments.as_deref(),
            readings: self.readings,
            tumble: self.tumble,
            findings: &self.findings,
            name: &self.name,
            columns: Some(self.columns.clone()),
        }
    }

    /// Files it was read from.
    pub fn inputs(&self) -> &[Input] {
        &self.inputs
    }
}

/// What reading found, as far as means of standstills mind: steps shorter than a window are no gaps to them.
fn doubts(recording: &Recording, breaks: &[usize]) -> Vec<Finding> {
    let longest = recording.time.gaps().iter().map(|g| g.step_s);
    let longest = longest.fold(0.0, f64::max);
    let uneven = || {
        proofmass_uncertainty::findings::uneven_stamps(
            "they scatter, or single rows are lost",
            &format!(
                "{} long steps among {}; the longest takes {longest:.3} s",
                recording.time.gaps().len(),
                recording.samples()
            ),
            "nothing for means of standstills; for noise or velocity, take the stamps at the sensor",
        )
    };
    recording
        .findings()
        .iter()
        .map(
            |finding| match finding.code() == "gaps-in-record" && breaks.is_empty() {
                true => uneven(),
                false => finding.clone(),
            },
        )
        .collect()
}

/// A pause that a moving window does not bridge, s: the window of the search for standstills.
const PAUSE: f64 = 1.0;

/// The shortest pause at a rate, s: four samples at least.
pub(crate) fn shortest_pause(rate: f64) -> f64 {
    PAUSE.max(4.0 / rate)
}

/// Samples before which a recording did not run for longer than a window.
pub(crate) fn pauses(recording: &Recording) -> Vec<usize> {
    let shortest = shortest_pause(recording.time.rate_hz());
    let gaps = recording.time.gaps().iter();
    gaps.filter(|g| g.step_s > shortest)
        .map(|g| g.after_sample + 1)
        .collect()
}

/// Gravity as a campaign gives it.
pub(crate) fn gravity(input: &GravityInput) -> Result<Gravity, Error> {
    let given = input.standard_uncertainty;
    if let Some(value) = input.value {
        return Gravity::given(value, given.unwrap_or(f64::NAN));
    }
    let normal = Gravity::normal(
        input.latitude_deg.unwrap_or(f64::NAN),
        input.height_m.unwrap_or(f64::NAN),
        input.latitude_standard_uncertainty_deg.unwrap_or(0.0),
        input.height_standard_uncertainty_m.unwrap_or(0.0),
    )?;
    match given {
        Some(u) => Gravity::given(normal.value(), u),
        None => Ok(normal),
    }
}

/// Tells beside each recording which gravity it was held against, and by what.
pub(crate) fn state_gravity(inputs: &mut [Input], input: &GravityInput) {
    let Ok(local) = gravity(input) else { return };
    let place = input.latitude_deg.zip(input.height_m);
    let place = place.filter(|_| input.value.is_none());
    let by = place.map(|(latitude, height)| {
        let give_or_take = input.height_standard_uncertainty_m;
        let give_or_take = give_or_take.map_or(String::new(), |u| format!(" ± {u} m"));
        format!("by latitude {latitude}° and height {height} m{give_or_take}")
    });
    let read = ReadGravity {
        normal_at: place.map(<[f64; 2]>::from),
        ..read_gravity(local, by.unwrap_or_else(|| "as stated".to_owned()))
    };
    for reading in inputs.iter_mut().filter_map(|i| i.reading.as_mut()) {
        reading.gravity = Some(read.clone());
    }
}

/// A standstill as a table of segments gives it.
pub fn segment(row: SegmentRow) -> Segment {
    Segment {
        start: row.start,
        end: row.end,
        attitude: row.attitude,
        force_uncertainty: None,
        label: row.label,
    }
}
