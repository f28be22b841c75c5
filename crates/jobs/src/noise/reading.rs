//! Recordings of sensors at rest as files have them: which columns, in which unit, on which clock.

use super::stream::{FileBlocks, NoiseStream};
use super::{NoiseData, NoiseSamples};
use crate::block_clock::BlockClock;
use crate::campaign::Unsaid;
use crate::recording::stretch;
use crate::stream_choice::StreamChoice;
use crate::trouble::{Result, Trouble};
use proofmass_io::{
    Absent, ClockUnit, ColumnRef, Gap, Input, Layout, LayoutOptions, Reading, Recording,
    RecordingOptions, RowReader, SaidBy, Source, Thermometer, TimeSource, TimeUnit, Unit,
};
use proofmass_noise::{ChannelName, NoiseChannel, Sensor};
use proofmass_uncertainty::Finding;
use std::collections::VecDeque;

/// How a recording is to be read.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[non_exhaustive]
pub struct NoiseReading {
    /// Columns by name or number (from 1) [default: every column that is neither time nor temperature]
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "A,B,…", value_delimiter = ',')
    )]
    pub columns: Option<Vec<ColumnRef>>,
    /// Unit of these columns, where the headings do not say it: m/s², g, mg, rad/s, °/s, °/h, V, count, 1 (fractional frequency), …
    #[cfg_attr(feature = "clap", arg(long))]
    pub unit: Option<Unit>,
    /// Size of one count (or volt) in that unit, for raw outputs
    #[cfg_attr(feature = "clap", arg(long, value_name = "FACTOR", requires = "unit"))]
    pub scale: Option<f64>,
    /// Time column by name or number
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN"))]
    pub time: Option<ColumnRef>,
    /// Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with --rate)
    #[cfg_attr(feature = "clap", arg(long, value_name = "UNIT"))]
    pub time_unit: Option<TimeUnit>,
    /// Sampling rate in hertz [default: that of the line through the time stamps]
    #[cfg_attr(feature = "clap", arg(long, value_name = "HZ"))]
    pub rate: Option<f64>,
    /// Read the rows from one time on and before another, in seconds
    #[cfg_attr(
        feature = "clap",
        arg(long, num_args = 2, value_names = ["FROM", "TO"], allow_negative_numbers = true)
    )]
    pub between: Option<Vec<f64>>,
    /// Which stream of the file.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub choice: StreamChoice,
    /// The columns hold integrals of the signal: velocities (m/s) of an accelerometer, angles of a gyroscope
    ///
    /// They are differenced. The unit that is stated is that of the rate.
    #[cfg_attr(feature = "clap", arg(long))]
    pub phase: bool,
    /// Column of the temperature (°C, or K or °F by its heading): its effect is fitted together with the noise
    ///
    /// Gives the sensitivity K_T with its interval; the effect of temperature is then not taken for B, K or R. An empty field keeps the last temperature.
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN"))]
    pub temperature: Option<ColumnRef>,
}

/// A recording in memory, in SI.
#[derive(Clone, Debug)]
pub struct NoiseRecording {
    names: Vec<ChannelName>,
    columns: Vec<Vec<f64>>,
    temperature: Option<Vec<f64>>,
    stamps: Option<Vec<f64>>,
    rate: Option<f64>,
    findings: Vec<Finding>,
    input: Input,
    name: String,
}

impl NoiseRecording {
    /// The data of the job.
    pub fn data(&self) -> NoiseData<'_> {
        NoiseData {
            samples: NoiseSamples::Slices {
                channels: self
                    .names
                    .iter()
                    .zip(&self.columns)
                    .map(|(n, rate)| NoiseChannel {
                        name: &n.name,
                        sensor: n.sensor,
                        unit: &n.unit,
                        rate,
                    })
                    .collect(),
                temperature: self.temperature.as_deref(),
                stamps: self.stamps.as_deref(),
                rate: self.rate,
            },
            findings: &self.findings,
            name: &self.name,
        }
    }

    /// The file and its digest.
    pub fn input(&self) -> Input {
        self.input.clone()
    }
}

impl NoiseReading {
    /// Reads a recording as a whole. A field that is empty or NaN is a missing sample, not damage.
    ///
    /// # Errors
    /// What the reader refuses, units that contradict each other, no column with a signal.
    pub fn read(&self, source: Source) -> Result<NoiseRecording> {
        let mut source = self.choice.stream_of(source);
        let name = source.name().display().to_string();
        let options = LayoutOptions::default();
        let layout = Layout::of(&mut source, &options)?;
        let clock = self.rate.is_some() || self.time_index(&layout)?.is_some();
        let mut chosen = self.chosen(&layout, &name)?;
        self.ask(&layout, &chosen, &source)?;
        if !clock {
            return Err(layout.ask_clock().at(source.name()).into());
        }
        let thermometer = self.thermometer(&layout, &chosen)?;
        let conversions = self.conversions(&layout, &chosen, &source)?;
        chosen.extend(self.temperature.clone());
        let absent = vec![Absent::EmptyOrNan; chosen.len()];
        let mut recording = Recording::from_source_sparse(
            source,
            &RecordingOptions {
                layout: options,
                columns: chosen,
                time: self.time.clone(),
                time_unit: self.time_unit,
                sampling_rate_hz: self.rate,
                late_stamps: true,
                between: stretch(self.between.as_deref())?,
                ..RecordingOptions::default()
            },
            &absent,
        )?;
        for column in 0..conversions.len() {
            let (unit, by) = self.of_column();
            recording.state_unit(column, unit, by)?;
        }
        if let Some(told) = &thermometer {
            recording.state_unit(conversions.len(), Some(told.unit), told.said_by)?;
        }
        if let Some((factor, unit)) = self.scale.zip(self.unit) {
            recording.state_scale(factor, unit);
        }
        let mut stamps = match recording.time.source() {
            TimeSource::Column(seconds) => Some(seconds.clone()),
            _ => None,
        };
        let rate = self.rate.unwrap_or_else(|| recording.time.rate_hz());
        let mut names = Vec::new();
        let mut columns = Vec::new();
        let mut signals = &recording.columns[..];
        let mut temperature = None;
        if let (Some(told), Some((last, before))) = (&thermometer, signals.split_last()) {
            signals = before;
            let kelvins = last.data.iter().map(|t| told.factor * t);
            temperature = Some(kelvins.collect::<Vec<f64>>());
        }
        for (index, (column, (unit, factor))) in signals.iter().zip(conversions).enumerate() {
            let mut factor = factor;
            let mut data = column.data.clone();
            for &row in recording.missing(index) {
                data[row] = f64::NAN;
            }
            if self.phase {
                // A difference across a gap is no rate.
                data = differences(&data, recording.time.gaps());
                factor *= rate;
            }
            if factor != 1.0 {
                data.iter_mut().for_each(|v| *v *= factor);
            }
            names.push(channel_name(&column.name, unit));
            columns.push(data);
        }
        if self.phase
            && let Some(stamps) = &mut stamps
        {
            // The rate between two integrals belongs to the later stamp.
            stamps.remove(0);
        }
        if self.phase
            && let Some(temperature) = &mut temperature
        {
            *temperature = temperature
                .windows(2)
                .map(|w| 0.5 * (w[0] + w[1]))
                .collect();
        }
        Ok(NoiseRecording {
            names,
            columns,
            temperature,
            stamps,
            rate: Some(rate),
            findings: recording.findings().to_vec(),
            input: recording.input(),
            name,
        })
    }

    /// Opens a recording to be seen once, in memory that does not grow with it.
    ///
    /// # Errors
    /// As [`NoiseReading::read`]; neither rate nor time column.
    pub fn stream(&self, source: Source) -> Result<NoiseStream> {
        let mut source = self.choice.stream_of(source);
        if self.temperature.is_some() {
            return Err(Trouble::request(
                "the effect of a temperature cannot be fitted to a recording that is read as a stream",
            )
            .with_hint("average the recording to a lower rate first, or choose fewer columns with --columns, so that it fits into memory"));
        }
        let name = source.name().display().to_string();
        let layout = Layout::of(&mut source, &LayoutOptions::default())?;
        let chosen = self.chosen(&layout, &name)?;
        self.ask(&layout, &chosen, &source)?;
        let mut selected = chosen
            .iter()
            .map(|c| layout.find(c))
            .collect::<Result<Vec<_>, _>>()?;
        let mut findings = layout.findings();
        let mut factors = Vec::new();
        let mut names = Vec::new();
        let conversions = self.conversions(&layout, &chosen, &source)?;
        for (&index, (unit, factor)) in selected.iter().zip(conversions) {
            factors.push(factor);
            names.push(channel_name(&layout.name(index), unit));
        }
        let signals = selected.len();
        let mut reading = Reading::of(&layout, &selected, None, None, self.rate);
        let counted = self.time_unit == Some(TimeUnit::Index);
        let clock = match (self.rate, self.time_index(&layout)?) {
            (Some(rate), time) if time.is_none() || self.time.is_none() && !counted => {
                BlockClock::steady(rate)
            }
            (rate, Some(index)) => {
                selected.push(index);
                let unit = ClockUnit::of(&layout, index, self.time_unit, rate, false)
                    .map_err(|e| Trouble::from(e.at(source.name())))?;
                findings.extend(unit.finding.clone());
                let of = &selected[..signals];
                reading = Reading::of(&layout, of, None, Some((index, &unit)), self.rate);
                BlockClock::stamped(unit.per_second, rate)
            }
            (_, None) => return Err(layout.ask_clock().at(source.name()).into()),
        };
        for column in 0..signals {
            let (unit, by) = self.of_column();
            reading.state_unit(column, unit, by);
        }
        if let Some((factor, unit)) = self.scale.zip(self.unit) {
            reading.state_scale(factor, unit);
        }
        reading.between_s = stretch(self.between.as_deref())?;
        let window = clock.window(reading.between_s, signals);
        Ok(NoiseStream {
            blocks: FileBlocks {
                reader: RowReader::new(source, layout, &selected)?.between(window),
                factors,
                clock,
                phase: self.phase,
                last: Vec::new(),
                ready: VecDeque::new(),
                name: name.clone(),
            },
            names,
            findings,
            name,
            reading,
        })
    }

    /// The columns asked for, else every numeric one that is neither a time nor a temperature.
    fn chosen(&self, layout: &Layout, name: &str) -> Result<Vec<ColumnRef>> {
        if let Some(columns) = &self.columns {
            return Ok(layout.matching(columns)?);
        }
        layout
            .refuse_mixed_marks()
            .map_err(|e| e.at(std::path::Path::new(name)))?;
        let time = self.time_index(layout)?;
        let temperature = self
            .temperature
            .as_ref()
            .map(|c| layout.find(c))
            .transpose()?;
        let is_signal = |i: &usize| {
            let other = |u: Unit| {
                u.is_time()
                    || matches!(
                        u,
                        Unit::DegreeCelsius | Unit::DegreeFahrenheit | Unit::Kelvin
                    )
            };
            layout.numeric[*i]
                && !layout.counts_rows(*i)
                && Some(*i) != time
                && Some(*i) != temperature
                && !layout.unit(*i).is_some_and(other)
        };
        let signals: Vec<usize> = (0..layout.columns).filter(is_signal).collect();
        // One unit that is stated, or asked for, does not hold for a gyroscope beside an accelerometer, a counter or a thermometer.
        let unsaid = signals.iter().filter(|&&i| layout.unit(i).is_none());
        let unsaid: Vec<String> = unsaid.map(|&i| layout.name(i)).collect();
        if unsaid.len() > 3 {
            return Err(Trouble::data(format!(
                "{} columns have no unit in their headings, and may not all be of one kind: {}",
                unsaid.len(),
                unsaid.join(", ")
            ))
            .detail(name)
            .with_hint("choose those of one sensor with --columns A,B,C"));
        }
        if signals.is_empty() {
            return Err(Trouble::data("no column holds a signal")
                .detail(name)
                .with_hint("name the columns with --columns"));
        }
        Ok(signals.iter().map(|i| ColumnRef::Index(i + 1)).collect())
    }

    /// Unit and clock are asked for together where both are missing.
    fn ask(&self, layout: &Layout, chosen: &[ColumnRef], source: &Source) -> Result<()> {
        if self.phase {
            return Ok(());
        }
        let signals = chosen
            .iter()
            .map(|c| layout.find(c))
            .collect::<Result<Vec<_>, _>>()?;
        let unsaid = Unsaid {
            signals: &signals,
            unit: self.unit,
            time: self.time_index(layout)?,
            time_unit: self.time_unit,
            rate_hz: self.rate,
            timeless: false,
        };
        Ok(unsaid.ask(layout).map_err(|e| e.at(source.name()))?)
    }

    /// How the temperature column is read, where one is named.
    fn thermometer(&self, layout: &Layout, chosen: &[ColumnRef]) -> Result<Option<Thermometer>> {
        let Some(column) = &self.temperature else {
            return Ok(None);
        };
        let index = layout.find(column)?;
        for other in chosen {
            if layout.find(other)? == index {
                return Err(Trouble::request(format!(
                    "column {:?} is the temperature and cannot be a channel as well",
                    layout.name(index)
                ))
                .with_hint("leave it out of --columns"));
            }
        }
        Ok(Some(Thermometer::of(layout, index)?))
    }

    /// The time column, as asked for or as its heading says.
    fn time_index(&self, layout: &Layout) -> Result<Option<usize>> {
        Ok(match &self.time {
            Some(column) => Some(layout.find(column)?),
            None => layout.time_column(),
        })
    }

    /// What the reading tells of a column without a unit in its heading, and who says so.
    fn of_column(&self) -> (Option<Unit>, SaidBy) {
        match (self.scale, self.phase) {
            // A scale turns counts into the unit that is stated.
            (Some(_), _) => (Some(Unit::Count), SaidBy::Person),
            // The unit that is stated is that of the rate.
            (None, true) => (None, SaidBy::Nobody),
            (None, false) => (self.unit, SaidBy::Person),
        }
    }

    /// SI unit and factor of every chosen column.
    fn conversions(
        &self,
        layout: &Layout,
        chosen: &[ColumnRef],
        source: &Source,
    ) -> Result<Vec<(Unit, f64)>> {
        let mut conversions = Vec::new();
        let mut open = Vec::new();
        for column in chosen {
            let index = layout.find(column)?;
            match self.conversion(&layout.name(index), layout.unit(index))? {
                Some(conversion) => {
                    let grouped = layout.refuse_grouped(&[index], Some(conversion.0));
                    grouped.map_err(|e| e.at(source.name()))?;
                    conversions.push(conversion);
                }
                None => open.push(index),
            }
        }
        if open.is_empty() {
            return Ok(conversions);
        }
        if self.phase {
            let names: Vec<String> = open.iter().map(|&i| layout.name(i)).collect();
            return Err(Trouble::request(format!(
                "the unit of the rate whose integral is {} is not said",
                names.join(", ")
            ))
            .detail(source.name().display().to_string())
            .with_hint(
                "say it with --unit: m/s2, rad/s, 1 for a fractional frequency (integral in s), …",
            ));
        }
        Err(layout.ask_unit(&open).at(source.name()).into())
    }

    /// SI unit of the rate in a column, and the factor that brings its numbers there; `stated` stands in its heading. None
    /// where nobody says the unit.
    fn conversion(&self, name: &str, stated: Option<Unit>) -> Result<Option<(Unit, f64)>> {
        let raw = stated.is_none_or(Unit::is_raw);
        match (self.scale, self.unit) {
            (Some(scale), Some(unit)) => {
                if let Some(stated) = stated.filter(|_| !raw) {
                    return Err(Trouble::request(format!(
                        "column {name:?} is in {stated} by its heading: a scale is for raw outputs"
                    ))
                    .with_hint("remove --scale and --unit, or correct the heading"));
                }
                if !(scale.is_finite() && scale > 0.0) {
                    return Err(Trouble::request(format!(
                        "a scale of {scale} is out of range: it must be positive"
                    ))
                    .with_hint("give the size of one count in the unit of --unit"));
                }
                let (si, factor) = unit.si();
                Ok(Some((si, scale * factor)))
            }
            (_, given) if self.phase => Ok(match (stated.map(Unit::si), given) {
                (Some((Unit::MetrePerSecond, factor)), _) => {
                    Some((Unit::MetrePerSecondSquared, factor))
                }
                (Some((Unit::Radian, factor)), _) => Some((Unit::RadianPerSecond, factor)),
                // Time against a better clock: its rate is the fractional frequency.
                (Some((Unit::Second, factor)), _) => Some((Unit::One, factor)),
                // Counts times seconds have no name.
                (_, given) => given.map(Unit::si),
            }),
            (_, given) => {
                if let (Some(stated), Some(given)) = (stated, given)
                    && stated != given
                {
                    return Err(Trouble::request(format!(
                        "column {name:?} is in {stated} by its heading, in {given} by --unit"
                    ))
                    .with_hint("remove --unit, or correct the heading"));
                }
                Ok(stated.or(given).map(Unit::si))
            }
        }
    }
}

fn channel_name(name: &str, unit: Unit) -> ChannelName {
    ChannelName {
        name: name.to_owned(),
        sensor: match unit {
            Unit::MetrePerSecondSquared => Some(Sensor::Accelerometer),
            Unit::RadianPerSecond => Some(Sensor::Gyroscope),
            _ => None,
        },
        unit: unit.to_string(),
    }
}

/// Differences of neighbours, missing where either is, or where samples between them are.
fn differences(phase: &[f64], gaps: &[Gap]) -> Vec<f64> {
    let mut rate: Vec<f64> = phase.windows(2).map(|w| w[1] - w[0]).collect();
    for gap in gaps {
        rate[gap.after_sample] = f64::NAN;
    }
    rate
}
