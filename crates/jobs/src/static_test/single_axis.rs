//! The readings of a campaign of one axis.

use super::{StaticTest, StaticTestData, StaticTestInput, StaticTestJob};
use crate::campaign::SingleAxisCampaign;
use crate::multi_position::{gravity, pauses, state_gravity};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_io::{Input, Layout, RecordedColumn, Recording, SaidBy, Unit};
use proofmass_static::static_test::{KnownAngles, Sensitivity, Tilt};
use proofmass_static::{MeanNoise, Samples, Segment, Standstill};
use proofmass_uncertainty::Finding;

/// Readings of one axis at known angles.
#[derive(Clone, Debug)]
pub struct SingleAxisReadings {
    /// Angles between the axis and the vertical, rad.
    angle: Vec<f64>,
    output: Vec<f64>,
    /// Standard uncertainty of a reading from the noise of its samples, where it is a mean.
    noise: Option<f64>,
    unit: Unit,
    /// What an output in the file is multiplied with.
    factor: f64,
    findings: Vec<Finding>,
    name: String,
    inputs: Vec<Input>,
    /// Angles, or positions where all are up or down.
    input: Vec<f64>,
}

/// Angles this near to up or down are up or down, rad.
const UPRIGHT: f64 = 1e-9;

impl SingleAxisCampaign {
    /// Reads the table, the files or the standstills of one recording.
    ///
    /// # Errors
    /// A file that cannot be read, an unknown unit, another number of standstills than of angles.
    pub fn load(&self, watch: &dyn Watch) -> Result<SingleAxisReadings> {
        watch.step("reading", 0, 0)?;
        let mut recordings = self.read_recordings()?;
        let usual = match self.recording.position {
            Some(_) => Unit::One,
            None => Unit::Degree,
        };
        for recording in &mut recordings {
            let output = recording.columns.len() - 1;
            recording.state_unit(output, self.recording.unit, SaidBy::Person)?;
            recording.state_unit(0, Some(usual).filter(|_| output > 0), SaidBy::Nobody)?;
            recording.need_units(&[Layout::CAMPAIGN; 2])?;
        }
        let names: Vec<String> = recordings
            .iter()
            .map(|r| r.path.display().to_string())
            .collect();
        let Some(first) = recordings.first().and_then(|r| r.columns.last()) else {
            return Err(Trouble::request("the campaign names no recording"));
        };
        let unit = first.unit.unwrap_or(Unit::One);
        let (unit, factor) = unit.si();
        let mut all = SingleAxisReadings {
            angle: Vec::new(),
            output: Vec::new(),
            noise: None,
            unit,
            factor,
            findings: Vec::new(),
            name: names.join(", "),
            inputs: vec![self.source.input.clone()],
            input: Vec::new(),
        };
        for recording in &recordings {
            all.findings.extend(recording.findings().iter().cloned());
            all.inputs.push(recording.input());
        }
        let outputs: Vec<Vec<f64>> = recordings
            .iter()
            .filter_map(|r| r.columns.last())
            .map(|c| c.data.iter().map(|v| v * factor).collect())
            .collect();
        if self.is_table() {
            all.angle = self.angles_of(&recordings[0].columns[0])?;
            all.output = outputs.into_iter().flatten().collect();
        } else {
            let angles = self.position.angles_deg.iter().flatten();
            all.angle = angles.map(|a| a.to_radians()).collect();
            all.means(self, &recordings, outputs)?;
        }
        all.input = match all.is_up_and_down() {
            true => all.angle.iter().map(|a| a.cos().signum()).collect(),
            false => all.angle.clone(),
        };
        Ok(all)
    }

    /// A column of angles or of positions as angles in rad.
    fn angles_of(&self, column: &RecordedColumn) -> Result<Vec<f64>> {
        if self.recording.position.is_some() {
            return column
                .data
                .iter()
                .map(|p| match *p {
                    1.0 => Ok(0.0),
                    -1.0 => Ok(std::f64::consts::PI),
                    other => Err(Trouble::data(format!("a position of {other}"))
                        .detail(format!("column {:?}", column.name))
                        .with_hint("1 is up, -1 is down; other attitudes need a column of angles")),
                })
                .collect();
        }
        let (unit, factor) = column.unit.unwrap_or(Unit::One).si();
        if unit != Unit::Radian {
            return Err(Trouble::data(format!(
                "column {:?} is in {unit}, which is no angle",
                column.name
            )));
        }
        Ok(column.data.iter().map(|v| v * factor).collect())
    }

    /// The question of the campaign: up and down alone is a test of two positions, other angles fit a cosine.
    ///
    /// # Errors
    /// A gravity that cannot be.
    pub fn job(&self, data: &SingleAxisReadings) -> Result<StaticTestJob> {
        let gravity = gravity(&self.gravity)?;
        let position = &self.position;
        let given = position.reading_standard_uncertainty;
        let reading = given.map(|u| u * data.factor).or(data.noise);
        let test = if data.is_up_and_down() {
            let mut test = Sensitivity::new(gravity);
            test.levelling = position.levelling_deg.to_radians();
            test.reading = reading;
            StaticTest::Sensitivity(test)
        } else {
            let mut test = Tilt::new(gravity);
            test.zero_uncertainty = position.zero_deg.to_radians();
            test.lean = position.lean_deg.to_radians();
            test.out_of_plane = position.out_of_plane_deg.to_radians();
            test.reading = reading;
            StaticTest::Tilt(test)
        };
        let mut job = StaticTestJob::new(test);
        job.probability = self.method.confidence;
        Ok(job)
    }

    /// What the result is filed with.
    pub fn record(&self, data: &SingleAxisReadings, date: Option<String>) -> Record {
        let mut inputs = data.inputs.clone();
        state_gravity(&mut inputs, &self.gravity);
        self.filed(date, inputs)
    }
}

impl SingleAxisReadings {
    /// Means of the files, or of the standstills of one recording.
    fn means(
        &mut self,
        campaign: &SingleAxisCampaign,
        recordings: &[Recording],
        outputs: Vec<Vec<f64>>,
    ) -> Result<()> {
        let mut segments = Vec::new();
        let mut start = 0;
        for output in &outputs {
            let end = start + output.len();
            segments.push(Segment {
                start,
                end,
                attitude: None,
                force_uncertainty: None,
                label: None,
            });
            start = end;
        }
        let output: Vec<f64> = outputs.into_iter().flatten().collect();
        let samples = Samples::new(&output, &output, &output)?;
        if let (Some(_), [recording]) = (&campaign.recording.file, recordings) {
            segments = self.found(campaign, &output, recording)?;
        }
        let mean = |s: &Segment| samples.mean(s.start, s.end)[0];
        self.output = segments.iter().map(mean).collect();
        let shortest = segments.iter().map(Segment::len).min().unwrap_or(0);
        if shortest > 1 {
            let noise = MeanNoise::estimate(&samples, &segments)?;
            // The largest of them for all: with more readings than parameters the scatter about the model counts.
            self.noise = Some(noise.of_mean(shortest)[0][0].sqrt());
        }
        Ok(())
    }

    /// As many rests as there are angles.
    fn found(
        &mut self,
        campaign: &SingleAxisCampaign,
        output: &[f64],
        recording: &Recording,
    ) -> Result<Vec<Segment>> {
        let mut search = Standstill::default();
        if let Some(duration) = campaign.position.minimum_duration_s {
            search.minimum_duration = duration;
        }
        let (rate, pauses) = (recording.time.rate_hz(), pauses(recording));
        let found = KnownAngles::find(output, rate, &pauses, &search, &self.angle)
            .map_err(|e| Trouble::from(e).detail(self.name.clone()))?;
        match found {
            Ok(found) => {
                self.findings.extend(found.findings);
                Ok(found.segments)
            }
            Err([low, high]) => {
                let wanted = self.angle.len();
                Err(Trouble::data(format!(
                    "{wanted} angles are given, but {low} to {high} standstills are found"
                ))
                .detail(self.name.clone())
                .with_hint(format!(
                    "list one angle for each rest of {:.1} s or more, in order; or cut the recording into one file per angle (`files`)",
                    search.shortest_hold(rate)
                )))
            }
        }
    }

    fn is_up_and_down(&self) -> bool {
        self.angle.iter().all(|a| a.sin().abs() < UPRIGHT)
    }

    /// The data as the job wants them.
    pub fn data<'a>(&'a self, unit: &'a str) -> StaticTestData<'a> {
        StaticTestData {
            input: StaticTestInput::Readings {
                input: &self.input,
                output: &self.output,
                temperature: None,
                uncertainty: None,
                unit,
            },
            findings: &self.findings,
            name: &self.name,
        }
    }

    /// Unit of the outputs as printed.
    pub fn unit(&self) -> String {
        self.unit.to_string()
    }
}
