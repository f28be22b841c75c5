//! What a static test is made of, as files have it.

use super::{StaticTest, StaticTestData, StaticTestInput, dated_document, document};
use crate::channels::by_option;
use crate::findings;
use crate::record::Record;
use crate::recording::RecordingReading;
use crate::trouble::{Result, Trouble};
use proofmass_documents::{CalibrationFile, Device};
use proofmass_io::{
    ColumnRef, Input, LARGEST_DOCUMENT, RecordedColumn, Recording, RecordingOptions, SaidBy,
    Source, Unit,
};
use proofmass_static::static_test::DatedEstimate;
use proofmass_uncertainty::Finding;

/// Columns of a table of readings of one axis.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[non_exhaustive]
pub struct ReadingColumns {
    /// Column of the outputs, by name or number (from 1)
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN"))]
    pub output_column: ColumnRef,
    /// Unit of the outputs, where the heading does not say it
    #[cfg_attr(feature = "clap", arg(long, value_name = "UNIT"))]
    pub output_unit: Option<Unit>,
    /// Column of temperatures in °C
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN"))]
    pub temperature: Option<ColumnRef>,
    /// Column of standard uncertainties of the outputs, which weigh the readings; only their ratios count
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN"))]
    pub uncertainty_column: Option<ColumnRef>,
}

impl ReadingColumns {
    /// The outputs alone.
    pub fn new(output: impl Into<ColumnRef>) -> Self {
        Self {
            output_column: output.into(),
            output_unit: None,
            temperature: None,
            uncertainty_column: None,
        }
    }
}

/// The files of a static test, read.
#[derive(Clone, Debug)]
pub struct StaticTestFiles {
    held: Held,
    findings: Vec<Finding>,
    name: String,
    device: Device,
    inputs: Vec<Input>,
}

#[derive(Clone, Debug)]
enum Held {
    Readings {
        input: Vec<f64>,
        output: Vec<f64>,
        temperature: Option<Vec<f64>>,
        uncertainty: Option<Vec<f64>>,
        unit: String,
    },
    Rest([Vec<f64>; 3]),
    /// With its clock, s.
    Motion([Vec<f64>; 3], Vec<f64>),
    Calibration(Box<CalibrationFile>),
    History(Vec<DatedEstimate>),
}

impl StaticTestFiles {
    /// A table of readings of one axis: `input` is the column of what the test sets (an angle, a position, an
    /// acceleration, a speed), in the unit of its heading, or the usual one of that test.
    ///
    /// # Errors
    /// A table that cannot be read; an input of another kind than the test sets; outputs whose unit nobody says.
    pub fn readings(
        source: Source,
        test: &StaticTest,
        input: &ColumnRef,
        columns: &ReadingColumns,
    ) -> Result<Self> {
        let usual = test.input_unit().ok_or_else(|| test.needs())?;
        let name = source.name().display().to_string();
        let options = RecordingOptions {
            columns: [input, &columns.output_column]
                .into_iter()
                .chain(&columns.uncertainty_column)
                .cloned()
                .collect(),
            temperature: columns.temperature.clone(),
            // Readings have an order, not a clock.
            table: true,
            ..RecordingOptions::default()
        };
        let mut recording = Recording::from_source(source, &options)?;
        let input = recording.columns.first().filter(|c| c.unit.is_none());
        let open = input.and_then(|c| plain(c, usual).err());
        recording.state_unit(0, Some(usual), SaidBy::Nobody)?;
        recording
            .state_unit(1, columns.output_unit, SaidBy::Person)
            .map_err(|e| by_option(e, Some("--output-unit")))?;
        let needed = recording
            .need_units(&["", "--output-unit"])
            .map_err(Trouble::from);
        match (open, needed) {
            (Some(open), Err(needed)) => {
                let hints = [&open, &needed].map(|t| t.hint().unwrap_or_default());
                return Err(
                    Trouble::data(format!("{open}; and {needed}")).with_hint(hints.join("; and "))
                );
            }
            (Some(open), Ok(())) => return Err(open.detail(name)),
            (None, needed) => needed?,
        }
        let [inputs, outputs, uncertainties @ ..] = recording.columns.as_slice() else {
            return Err(Trouble::data("two columns are needed").detail(name));
        };
        let uncertainty = uncertainties.first().map(|c| c.data.clone());
        if let Some((row, u)) = uncertainty
            .iter()
            .flatten()
            .enumerate()
            .find(|(_, u)| !(**u > 0.0))
        {
            return Err(Trouble::data(format!(
                "the standard uncertainty of reading {} is {u}, which gives no weight",
                row + 1
            ))
            .detail(name)
            .with_hint(
                "state a positive one for every reading, or leave --uncertainty-column out",
            ));
        }
        let factor = to_si(inputs, usual).map_err(|e| e.detail(name.clone()))?;
        let unit = outputs.unit.unwrap_or(Unit::One);
        Ok(Self {
            held: Held::Readings {
                input: inputs.data.iter().map(|v| v * factor).collect(),
                output: outputs.data.clone(),
                temperature: recording.temperature.as_ref().map(|t| t.data.clone()),
                uncertainty,
                unit: unit.to_string(),
            },
            findings: recording.findings().to_vec(),
            name,
            device: Device::default(),
            inputs: vec![recording.input()],
        })
    }

    /// A recording of three axes at rest, in a unit of acceleration.
    ///
    /// # Errors
    /// A recording that cannot be read, columns that are not named, another unit.
    pub fn rest(source: Source, reading: &RecordingReading) -> Result<Self> {
        Self::three_axes(source, reading, |axes, _| Held::Rest(axes))
    }

    /// A recording of three axes with its clock, in a unit of acceleration.
    ///
    /// # Errors
    /// As [`Self::rest`]; a recording without a clock.
    pub fn motion(source: Source, reading: &RecordingReading) -> Result<Self> {
        Self::three_axes(source, reading, |axes, recording| {
            let samples = 0..axes[0].len();
            let clock = samples.map(|k| recording.time.seconds(k)).collect();
            Held::Motion(axes, clock)
        })
    }

    fn three_axes(
        mut source: Source,
        reading: &RecordingReading,
        held: impl FnOnce([Vec<f64>; 3], &Recording) -> Held,
    ) -> Result<Self> {
        let name = source.name().display().to_string();
        let recording = {
            let options = reading.options_alone(&mut source)?;
            Recording::from_source(source, &options)?
        };
        let [x, y, z] = recording.columns.as_slice() else {
            return Err(Trouble::data("three columns are needed").detail(name));
        };
        let (si, factor) = reading.common_unit(&recording)?.si();
        if !si.is_acceleration() {
            return Err(Trouble::data(format!(
                "the outputs are in {si}, which is no acceleration"
            ))
            .detail(name)
            .with_hint("apply a calibration first, or convert with the nominal sensitivity"));
        }
        let in_si = |c: &RecordedColumn| c.data.iter().map(|v| v * factor).collect();
        Ok(Self {
            held: held([x, y, z].map(in_si), &recording),
            findings: recording.findings().to_vec(),
            name,
            device: Device::default(),
            inputs: vec![recording.input()],
        })
    }

    /// The samples from one time on and before another, s, by the clock of a recording of [`Self::motion`].
    ///
    /// # Errors
    /// A stretch outside of the recording.
    pub fn samples(&self, [from, to]: [f64; 2]) -> Result<[usize; 2]> {
        let none: &[f64] = &[];
        let clock = match &self.held {
            Held::Motion(_, clock) => clock.as_slice(),
            _ => none,
        };
        let at = |t: f64| clock.partition_point(|c| *c < t);
        let (first, past) = (at(from), at(to));
        if past > first && from < to {
            return Ok([first, past]);
        }
        let span = match (clock.first(), clock.last()) {
            (Some(first), Some(last)) => format!("{first:.3} s to {last:.3} s"),
            _ => "nothing".to_owned(),
        };
        Err(Trouble::data(format!(
            "no sample lies from {from} s on and before {to} s; the recording has {span}"
        ))
        .detail(self.name.clone())
        .with_hint("give two times of the recording, the earlier one first"))
    }

    /// A calibration.json of a triaxial sensor.
    ///
    /// # Errors
    /// Another file.
    pub fn calibration(source: Source) -> Result<Self> {
        let name = source.name().display().to_string();
        let (file, input) = CalibrationFile::from_source(source)?;
        Ok(Self {
            device: file.device.clone(),
            held: Held::Calibration(Box::new(file)),
            findings: Vec::new(),
            name,
            inputs: vec![input],
        })
    }

    /// The result.json of calibrations of one device.
    ///
    /// # Errors
    /// As [`dated`](super::dated).
    pub fn history(sources: impl IntoIterator<Item = Source>) -> Result<Self> {
        let mut history = Vec::new();
        let mut inputs = Vec::new();
        let mut serials: Vec<(String, String)> = Vec::new();
        for source in sources {
            let name = source.name().display().to_string();
            let (bytes, input) = source.into_bytes(LARGEST_DOCUMENT)?;
            let result = document(&bytes, &name)?;
            history.push(dated_document(&result, &name)?);
            serials.extend(result.device.serial.map(|serial| (serial, name)));
            inputs.push(input);
        }
        let others = serials.iter().skip(1).filter(|s| s.0 != serials[0].0);
        let others: Vec<&(String, String)> = others.collect();
        let findings = others.first().map(|(serial, name)| {
            findings::devices_differ(
                "a drift is that of one",
                &format!("serial number {}", serials[0].0),
                &serials[0].1,
                &format!("serial number {serial}"),
                name,
                others.len(),
                "name results of one device, or correct its serial number in the campaigns",
            )
        });
        Ok(Self {
            held: Held::History(history),
            findings: findings.into_iter().collect(),
            name: "the calibrations".to_owned(),
            device: Device::default(),
            inputs,
        })
    }

    /// For the job.
    pub fn data(&self) -> StaticTestData<'_> {
        let input = match &self.held {
            Held::Readings {
                input,
                output,
                temperature,
                uncertainty,
                unit,
            } => StaticTestInput::Readings {
                input,
                output,
                temperature: temperature.as_deref(),
                uncertainty: uncertainty.as_deref(),
                unit,
            },
            Held::Rest([x, y, z]) | Held::Motion([x, y, z], _) => {
                StaticTestInput::Recording([x, y, z])
            }
            Held::Calibration(file) => StaticTestInput::Calibration(file),
            Held::History(history) => StaticTestInput::History(history),
        };
        StaticTestData {
            input,
            findings: &self.findings,
            name: &self.name,
        }
    }

    /// What a result is filed with.
    pub fn record(&self, date: Option<String>) -> Record {
        Record {
            device: self.device.clone(),
            date,
            inputs: self.inputs.clone(),
            ..Record::default()
        }
    }
}

/// Whether the numbers of an input are so plainly in the usual unit that it need not be said: angles in degrees are, unless a turn
/// would hold them in radians.
fn plain(column: &RecordedColumn, usual: Unit) -> Result<()> {
    let turn = std::f64::consts::TAU;
    let parts_of_a_turn = column.data.iter().any(|v| v.fract() != 0.0)
        && column.data.iter().all(|v| v.abs() <= 1.01 * turn);
    let kind = usual.si().0;
    match kind {
        Unit::Radian if !parts_of_a_turn => Ok(()),
        Unit::Radian | Unit::MetrePerSecondSquared | Unit::RadianPerSecond => {
            let example = match kind {
                Unit::Radian => "angle_deg or angle_rad",
                Unit::RadianPerSecond => "speed_r/min or speed_rad/s",
                _ => "acceleration_g or acceleration_m/s2",
            };
            Err(Trouble::data(format!(
                "the unit of column {:?} is not said, and its numbers fit more than one",
                column.name
            ))
            .with_hint(format!("write it into the heading, as in {example}")))
        }
        _ => Ok(()),
    }
}

/// Factor of a column to SI; its heading wins over the usual unit, and must be of the same kind.
fn to_si(column: &RecordedColumn, usual: Unit) -> Result<f64> {
    let (unit, factor) = column.unit.unwrap_or(usual).si();
    if unit == usual.si().0 {
        Ok(factor)
    } else {
        let stated = column.unit.unwrap_or(usual);
        let (wanted, hint) = match usual.si().0 {
            Unit::One => (
                "a position is +1 (up) or -1 (down)".to_owned(),
                match unit {
                    Unit::Radian => "for angles use `proofmass test tilt --angle COLUMN`",
                    _ => "name the column of the positions, or correct its heading",
                },
            ),
            Unit::Radian => (
                "an angle is needed".to_owned(),
                "write its unit into the heading: angle_deg or angle_rad",
            ),
            unit => (
                format!("a column in {unit} is needed, or in another unit of that quantity"),
                "name another column, or correct its heading",
            ),
        };
        Err(Trouble::data(format!(
            "column {:?} is in {stated}, and {wanted}",
            column.name
        ))
        .with_hint(hint))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_core::Gravity;
    use proofmass_static::static_test::Tilt;

    fn tilt() -> Result<StaticTest> {
        Ok(StaticTest::Tilt(Tilt::new(Gravity::given(9.80665, 1e-4)?)))
    }

    #[test]
    fn known_headings_win_over_the_usual_unit() -> Result<()> {
        for (heading, angle, radians) in [
            ("angle", "90", std::f64::consts::FRAC_PI_2),
            ("angle_rad", "0.25", 0.25),
        ] {
            let text = format!("{heading},out_mV\n{angle},1.5\n{angle},1.6\n");
            let source = Source::from_bytes("t.csv", text.into_bytes())?;
            let files = StaticTestFiles::readings(
                source,
                &tilt()?,
                &"angle".into(),
                &ReadingColumns::new("out"),
            )?;
            let StaticTestInput::Readings { input, unit, .. } = files.data().input else {
                return Err(Trouble::data("no readings"));
            };
            assert_eq!((input[0], unit), (radians, "mV"));
        }
        Ok(())
    }

    #[test]
    fn known_column_that_is_called_by_its_unit() -> Result<()> {
        let read = |heading: &str| -> Result<StaticTestFiles> {
            let text = format!("angle_deg,{heading}\n90,1.5\n270,1.6\n");
            let source = Source::from_bytes("t.csv", text.into_bytes())?;
            let columns = ReadingColumns::new(heading);
            StaticTestFiles::readings(source, &tilt()?, &"angle_deg".into(), &columns)
        };
        for heading in ["V", "mV"] {
            let files = read(heading)?;
            let StaticTestInput::Readings { unit, .. } = files.data().input else {
                return Err(Trouble::data("no readings"));
            };
            assert_eq!(unit, heading);
        }
        let asked = read("output")
            .err()
            .and_then(|e| e.hint().map(str::to_owned));
        assert!(asked.is_some_and(|hint| hint.contains("--output-unit")));
        Ok(())
    }

    #[test]
    fn known_uncertainties_weigh_the_readings_and_must_be_positive() -> Result<()> {
        let read = |last: &str| {
            let text = format!("angle_deg,out_mV,u\n0,1.5,1\n90,1.6,2\n180,1.4,{last}\n");
            let source = Source::from_bytes("t.csv", text.into_bytes())?;
            let columns = ReadingColumns {
                uncertainty_column: Some("u".into()),
                ..ReadingColumns::new("out")
            };
            StaticTestFiles::readings(source, &tilt()?, &"angle".into(), &columns)
        };
        let files = read("0.5")?;
        let StaticTestInput::Readings { uncertainty, .. } = files.data().input else {
            return Err(Trouble::data("no readings"));
        };
        assert_eq!(uncertainty, Some(&[1.0, 2.0, 0.5][..]));
        assert!(read("0").is_err_and(|e| e.to_string().contains("reading 3 is 0")));
        Ok(())
    }

    #[test]
    fn refuses_an_input_of_another_kind() -> Result<()> {
        let source = Source::from_bytes("t.csv", "angle_V,out_mV\n1,1.5\n2,1.6\n")?;
        let columns = ReadingColumns::new("out");
        let refused = StaticTestFiles::readings(source, &tilt()?, &"angle".into(), &columns);
        assert!(refused.is_err_and(|e| e.to_string().contains("an angle is needed")));
        Ok(())
    }
}
