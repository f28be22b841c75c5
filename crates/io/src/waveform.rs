//! Recordings of several channels that were sampled together: raw 32-bit floats, a text table, or what is known by its content.

use crate::layout::{ColumnRef, Layout, LayoutOptions};
use crate::output::AtomicFile;
use crate::{
    Error, ErrorKind, Input, Reading, RecordedColumn, Recording, RecordingOptions, Result,
    RowReader, SaidBy, Source, TimeBase, TimeSource, TimeUnit, Unit,
};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Form of the samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum WaveformFormat {
    /// Little-endian 32-bit floats in volts, the channels of one instant side by side, nothing else in the file.
    F32,
    /// WAV, integers or floats, as fractions of the full scale.
    Wav,
    /// A text table, one row per instant, or a file that tells its format by its content: TDMS, WAV, …
    #[default]
    Text,
}

/// How waveforms are read.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveformOptions {
    /// Form of the samples.
    pub format: WaveformFormat,
    /// Sampling rate in Hz; a WAV file says it itself, a text table may have a time column.
    pub sampling_rate_hz: Option<f64>,
    /// Name and place of each channel wanted, numbers from one.
    pub channels: Vec<(String, ColumnRef)>,
    /// Channels in a file of raw floats.
    pub channel_count: usize,
    /// Full scale in volts: what ±1 means in a WAV file.
    pub full_scale_v: Option<f64>,
    /// Shape of a text table.
    pub layout: LayoutOptions,
    /// Unit of the columns of a text table where the headings do not say it.
    pub unit: Option<Unit>,
    /// What the samples are to be, as a unit without prefix: volts of a front end, counts or accelerations of a digital
    /// sensor. Raw floats and WAV files hold numbers of it.
    pub quantity: Unit,
    /// Time column of a text table; without it and without a rate, a column that is named as a time.
    pub time: Option<ColumnRef>,
    /// Unit of the time column where the heading does not say it.
    pub time_unit: Option<TimeUnit>,
    /// The stretch to be read, from one time on and before another, s; all without it.
    pub between: Option<[f64; 2]>,
    /// Stream of a file that holds several.
    pub stream: Option<String>,
}

impl Default for WaveformOptions {
    /// No channels, of whatever format is seen; the samples are to be volts.
    fn default() -> Self {
        Self {
            format: WaveformFormat::default(),
            sampling_rate_hz: None,
            channels: Vec::new(),
            channel_count: 0,
            full_scale_v: None,
            layout: LayoutOptions::default(),
            unit: None,
            quantity: Unit::Volt,
            time: None,
            time_unit: None,
            between: None,
            stream: None,
        }
    }
}

/// When the samples of a recording were taken, by its own time stamps.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SampleTimes {
    /// Where the even grid through the stamps begins, s, by the zero of the time column.
    pub begin_s: f64,
    /// How much later than its place in the grid each sample was stamped, s.
    pub late_s: Vec<f64>,
    /// Standard uncertainty of the rate by scatter and resolution of the stamps, Hz.
    pub rate_u_hz: f64,
}

impl SampleTimes {
    /// Of stamps in seconds and the rate of the line through them.
    fn of(time: &TimeBase, samples: usize) -> Option<Self> {
        let TimeSource::Column(stamps) = time.source() else {
            return None;
        };
        let n = samples as f64;
        // About the first one: stamps may count from long ago.
        let mean = stamps.iter().map(|t| t - stamps[0]).sum::<f64>() / n;
        let begin_s = stamps[0] + mean - 0.5 * (n - 1.0) / time.rate_hz();
        let late_s = stamps.iter().enumerate();
        let late_s = late_s.map(|(i, t)| t - begin_s - i as f64 / time.rate_hz());
        Some(Self {
            begin_s,
            late_s: late_s.collect(),
            rate_u_hz: time.clock().map_or(0.0, |c| c.rate_u_hz),
        })
    }
}

/// Channels of one recording, in the unit asked for.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Waveform {
    /// The file.
    pub path: PathBuf,
    /// Its name and digest.
    pub file: Input,
    /// Sampling rate in Hz.
    pub sampling_rate_hz: f64,
    /// Samples in the order in which the channels were asked for.
    pub channels: Vec<Vec<f64>>,
    /// Time of the first sample, s: by its stamps where the file has them, else by the number of its row.
    pub begin_s: f64,
    /// Time stamps, where the file has them.
    pub times: Option<SampleTimes>,
    /// How it was read, where it is a text table.
    pub reading: Option<Reading>,
    /// What the reader noticed.
    pub findings: Vec<Finding>,
}

impl Waveform {
    /// Reads the channels of a file.
    ///
    /// ```
    /// use proofmass_io::{ColumnRef, Waveform, WaveformFormat, WaveformOptions, write_f32};
    /// # let folder = tempfile::tempdir().unwrap();
    /// # let path = folder.path().join("r1.f32");
    /// write_f32(&path, &[&[1.0, 2.0], &[-0.5, 0.25]])?;
    /// let waveform = Waveform::read(&path, &WaveformOptions {
    ///     format: WaveformFormat::F32,
    ///     sampling_rate_hz: Some(51_200.0),
    ///     channels: vec![("x".into(), ColumnRef::Index(2))],
    ///     channel_count: 2,
    ///     full_scale_v: Some(10.0),
    ///     ..WaveformOptions::default()
    /// })?;
    /// assert_eq!(waveform.channels, [[-0.5, 0.25]]);
    /// # Ok::<(), proofmass_io::Error>(())
    /// ```
    ///
    /// # Errors
    /// A missing or empty file, one that ends inside a sample, a channel that is not there, a sample that is not
    /// finite (with its number), a unit other than volts, no sampling rate.
    pub fn read(path: &Path, options: &WaveformOptions) -> Result<Self> {
        Self::from_source(Source::open(path)?, options)
    }

    /// Reads the channels of a source: a pipe, bytes in memory.
    ///
    /// # Errors
    /// As [`Waveform::read`].
    pub fn from_source(mut source: Source, options: &WaveformOptions) -> Result<Self> {
        let name = source.name().to_path_buf();
        let format = match options.format {
            WaveformFormat::Text if is_wav(&mut source).map_err(|e| e.at(&name))? => {
                WaveformFormat::Wav
            }
            stated => stated,
        };
        match format {
            WaveformFormat::F32 => Self::read_f32(source, options).and_then(|w| w.cut(options)),
            WaveformFormat::Wav => Self::read_wav(source, options).and_then(|w| w.cut(options)),
            WaveformFormat::Text => Self::read_text(source, options),
        }
        .map(|w| w.named(options))
        .map_err(|e| e.at(&name))
    }

    /// With the roles of its columns in what tells how it was read.
    fn named(mut self, options: &WaveformOptions) -> Self {
        let number = |place: &ColumnRef| match place {
            ColumnRef::Index(number) => *number,
            ColumnRef::Name(_) => 0,
        };
        let numbers: Vec<usize> = options.channels.iter().map(|c| number(&c.1)).collect();
        let rate_by = match options.sampling_rate_hz {
            Some(_) => SaidBy::Person,
            None => SaidBy::File,
        };
        let rate = self.sampling_rate_hz;
        let reading = self
            .reading
            .get_or_insert_with(|| Reading::of_volts(&numbers, rate, rate_by));
        reading.between_s = options.between;
        reading.name_roles(options.channels.iter().map(|c| c.0.as_str()));
        self
    }

    /// The stretch that was asked for, by the number of the row and the rate.
    fn cut(mut self, options: &WaveformOptions) -> Result<Self> {
        let Some([from, to]) = options.between else {
            return Ok(self);
        };
        let (rate, samples) = (self.sampling_rate_hz, self.samples());
        let row = |t: f64| (t * rate).ceil().clamp(0.0, samples as f64) as usize;
        let rows = row(from)..row(to);
        if rows.len() < 2 {
            let until = (samples as f64 - 1.0) / rate;
            return Err(Error::new(
                ErrorKind::Time,
                format!("no row lies between {from} s and {to} s; the last time is {until} s"),
            )
            .with_hint("correct `between_s` in [recording]"));
        }
        for channel in &mut self.channels {
            *channel = channel[rows.clone()].to_vec();
        }
        self.begin_s = rows.start as f64 / rate;
        Ok(self)
    }

    /// Number of samples of each channel.
    pub fn samples(&self) -> usize {
        self.channels.first().map_or(0, Vec::len)
    }

    /// Duration in seconds.
    pub fn duration_s(&self) -> f64 {
        self.samples() as f64 / self.sampling_rate_hz
    }

    /// Path and digest, for the list of inputs of a result.
    pub fn input(&self) -> Input {
        Input {
            reading: self.reading.clone().map(Box::new),
            ..self.file.clone()
        }
    }

    fn read_f32(source: Source, options: &WaveformOptions) -> Result<Self> {
        let path = source.name().to_path_buf();
        let (bytes, input) = bytes(source)?;
        let count = options.channel_count;
        let frame = 4 * count;
        if count == 0 || bytes.len() % frame != 0 {
            return Err(Error::new(
                ErrorKind::Format,
                format!(
                    "the {} bytes are no whole number of samples of {count} channels of 4 bytes",
                    bytes.len()
                ),
            )
            .with_hint("the file was cut short, or [recording] says another number of channels than it has"));
        }
        let places = numbers(options, count)?;
        let factor = options.unit.map_or(1.0, |unit| unit.si().1);
        let mut channels = vec![Vec::with_capacity(bytes.len() / frame); places.len()];
        // Some frames at a time, so that the channels after the first find them in the cache.
        for frames in bytes.chunks(FRAMES * frame) {
            for (channel, place) in channels.iter_mut().zip(&places) {
                let samples = frames
                    .chunks_exact(frame)
                    .map(|b| &b[4 * place..4 * place + 4]);
                channel.extend(
                    samples
                        .map(|b| factor * f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))),
                );
            }
        }
        finite(&channels, options)?;
        Ok(Self {
            path,
            file: input,
            sampling_rate_hz: rate(options.sampling_rate_hz)?,
            channels,
            begin_s: 0.0,
            times: None,
            reading: None,
            findings: Vec::new(),
        })
    }

    fn read_wav(mut source: Source, options: &WaveformOptions) -> Result<Self> {
        let path = source.name().to_path_buf();
        if !is_wav(&mut source)? {
            return Err(Error::new(ErrorKind::Format, "is no WAV file")
                .with_hint("correct `format` in [recording], or leave it out: a file tells its format by its content"));
        }
        let layout = Layout::of(&mut source, &options.layout)?;
        let Some(stream) = layout.stream.clone() else {
            return Err(Error::new(ErrorKind::Format, "is no WAV file"));
        };
        let stated = stream.rate_hz.unwrap_or(f64::NAN);
        let places = numbers(options, layout.columns - usize::from(stream.timed))?;
        let Some(full_scale) = options.full_scale_v else {
            return Err(Error::new(
                ErrorKind::Configuration,
                "the full scale of the recording is not known",
            )
            .with_hint("add `full_scale_V = …` to [recording]: a WAV file holds fractions of it"));
        };
        if let Some(given) = options.sampling_rate_hz
            && given != stated
        {
            return Err(Error::new(
                ErrorKind::Configuration,
                format!("the file was sampled at {stated} Hz, the campaign says {given} Hz"),
            )
            .with_hint("correct `sampling_rate_Hz`, or leave it out: the file counts"));
        }
        let scale = match stream.full_scale {
            Some(counts) => full_scale / counts,
            None => full_scale,
        };
        let findings = layout.findings();
        let mut channels = vec![Vec::new(); places.len()];
        let mut reader = RowReader::new(source, layout, &places)?;
        while let Some(block) = reader.next_block()? {
            for (i, channel) in channels.iter_mut().enumerate() {
                channel.extend(block.column(i).iter().map(|v| scale * v));
            }
            if channels.len() * channels[0].len() > Recording::MOST_VALUES {
                return Err(Error::new(
                    ErrorKind::Format,
                    "holds more samples than are held in memory",
                )
                .with_hint("cut the recording into parts"));
            }
        }
        finite(&channels, options)?;
        Ok(Self {
            path,
            file: reader.finish()?,
            sampling_rate_hz: stated,
            channels,
            begin_s: 0.0,
            times: None,
            reading: None,
            findings,
        })
    }

    fn read_text(source: Source, options: &WaveformOptions) -> Result<Self> {
        let path = source.name().to_path_buf();
        let recording = Recording::from_source(
            source,
            &RecordingOptions {
                layout: options.layout.clone(),
                columns: options.channels.iter().map(|c| c.1.clone()).collect(),
                sampling_rate_hz: options.sampling_rate_hz,
                unit: options.unit,
                time: options.time.clone(),
                time_unit: options.time_unit,
                between: options.between,
                stream: options.stream.clone(),
                ..RecordingOptions::default()
            },
        )?
        .into_si();
        if let Some(gap) = recording.time.gaps().first() {
            return Err(Error::new(
                ErrorKind::Time,
                format!(
                    "samples are missing: {:.6} s without one after {:.6} s",
                    gap.step_s, gap.at_s
                ),
            )
            .line(gap.line)
            .with_hint("a sine approximation needs an unbroken recording; measure the run again"));
        }
        let other = |c: &&RecordedColumn| c.unit != Some(options.quantity);
        for column in recording.columns.iter().filter(other) {
            let wanted = options.quantity;
            let Some(unit) = column.unit else {
                let campaign = vec![Layout::CAMPAIGN; options.channels.len()];
                recording.need_units(&campaign)?;
                continue;
            };
            let what = format!("is in {unit}, not in {wanted}");
            let hint = match wanted {
                Unit::Volt => "write the unit in the heading (x_V, x_mV) or `unit = \"V\"` in [recording]; a digital \
                               sensor has a file of its own, described by [output_recording]"
                    .to_owned(),
                _ => "correct the heading, or `unit` in [output_recording]".to_owned(),
            };
            return Err(Error::new(ErrorKind::Column, what)
                .column(&column.name)
                .with_hint(hint));
        }
        let times = SampleTimes::of(&recording.time, recording.samples());
        // The rows of a stated rate are counted from the first that was read.
        let rate = recording.time.rate_hz();
        let first = |[from, _]: [f64; 2]| (from.max(0.0) * rate).ceil() / rate;
        let first = options.between.map_or(0.0, first);
        Ok(Self {
            path,
            sampling_rate_hz: rate,
            begin_s: times.as_ref().map_or(first, |t| t.begin_s),
            times,
            reading: Some(recording.reading().clone()),
            findings: recording.findings().to_vec(),
            file: recording.file,
            channels: recording.columns.into_iter().map(|c| c.data).collect(),
        })
    }
}

/// Writes channels of volts as raw little-endian 32-bit floats, side by side; the file appears whole or not at all.
///
/// # Errors
/// Channels of different length, a value that is not finite, a disk that refuses.
pub fn write_f32(path: &Path, channels: &[&[f64]]) -> Result<()> {
    let bytes = f32_bytes(channels).map_err(|e| e.at(path))?;
    let mut file = AtomicFile::create(path, &[])?;
    file.write_all(&bytes)?;
    file.commit()
}

/// The bytes of channels of volts as raw little-endian 32-bit floats, side by side.
///
/// # Errors
/// Channels of different length, a value that is not finite.
pub fn f32_bytes(channels: &[&[f64]]) -> Result<Vec<u8>> {
    let samples = channels.first().map_or(0, |c| c.len());
    if let Some(other) = channels.iter().find(|c| c.len() != samples) {
        return Err(Error::new(
            ErrorKind::Output,
            format!(
                "a channel has {} samples, the first has {samples}",
                other.len()
            ),
        ));
    }
    let mut bytes = Vec::with_capacity(4 * samples * channels.len());
    for i in 0..samples {
        for channel in channels {
            let value = channel[i] as f32;
            if !value.is_finite() {
                return Err(Error::new(
                    ErrorKind::Output,
                    format!("sample {i} is {value} and may not be written"),
                ));
            }
            bytes.extend_from_slice(&value.to_le_bytes());
        }
    }
    Ok(bytes)
}

/// Whether what lies ahead is a WAV file, whose samples are fractions of a full scale.
fn is_wav(source: &mut Source) -> Result<bool> {
    let (head, _) = source.ahead(proofmass_formats::HEAD)?;
    Ok(proofmass_formats::recognise(head).is_some_and(|f| f.word == "wav"))
}

/// Most bytes of a recording that has to be held whole.
const LARGEST: u64 = 4 << 30;

fn bytes(source: Source) -> Result<(Vec<u8>, Input)> {
    let (bytes, input) = source.into_bytes(LARGEST)?;
    if bytes.is_empty() {
        return Err(Error::new(ErrorKind::Format, "the recording is empty")
            .with_hint("measure the run again, or take its row out of the table of runs"));
    }
    Ok((bytes, input))
}

fn rate(given: Option<f64>) -> Result<f64> {
    given.ok_or_else(|| {
        Error::new(ErrorKind::Configuration, "the sampling rate is not known")
            .with_hint("add `sampling_rate_Hz = …` to [recording]")
    })
}

/// Channel numbers from zero, for formats without headings.
fn numbers(options: &WaveformOptions, count: usize) -> Result<Vec<usize>> {
    options
        .channels
        .iter()
        .map(|(name, place)| match place {
            ColumnRef::Index(i) if (1..=count).contains(i) => Ok(i - 1),
            other => Err(Error::new(
                ErrorKind::Configuration,
                format!(
                    "channel {name} is declared as {other}, the file has channels 1 to {count}"
                ),
            )
            .with_hint("correct `channels` in [recording]; channels are counted from 1")),
        })
        .collect()
}

/// Frames whose channels are taken apart at a time.
const FRAMES: usize = 512;

fn finite(channels: &[Vec<f64>], options: &WaveformOptions) -> Result<()> {
    for (channel, (name, _)) in channels.iter().zip(&options.channels) {
        // Without a way out between them: nearly every recording is read to its end.
        let sound = channel.iter().filter(|v| crate::field::is_reading(**v));
        if sound.count() == channel.len() {
            continue;
        }
        if let Some(i) = channel.iter().position(|v| !crate::field::is_reading(*v)) {
            return Err(Error::new(
                ErrorKind::Field,
                format!(
                    "sample {i} is {}, which is no reading; the file has {} samples per channel",
                    channel[i],
                    channel.len()
                ),
            )
            .column(name)
            .with_hint("the file is damaged, or is not of the declared format; measure the run again or take its row out"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(format: WaveformFormat) -> WaveformOptions {
        WaveformOptions {
            format,
            sampling_rate_hz: Some(1000.0),
            channels: vec![("reference".into(), 1.into()), ("x".into(), 2.into())],
            channel_count: 2,
            full_scale_v: Some(10.0),
            unit: Some(Unit::Volt),
            ..WaveformOptions::default()
        }
    }

    #[test]
    fn known_stretch_of_every_form() {
        let folder = tempfile::tempdir().unwrap();
        let ramp: Vec<f64> = (0..100).map(f64::from).collect();
        let raw = folder.path().join("r.f32");
        write_f32(&raw, &[&ramp, &ramp]).unwrap();
        let text = folder.path().join("r.csv");
        let rows: String = ramp.iter().map(|v| format!("{v},{v}\n")).collect();
        std::fs::write(&text, format!("a_V,b_V\n{rows}")).unwrap();
        for (path, format) in [(&raw, WaveformFormat::F32), (&text, WaveformFormat::Text)] {
            let cut = |between| {
                let between = Some(between);
                Waveform::read(
                    path,
                    &WaveformOptions {
                        between,
                        ..options(format)
                    },
                )
            };
            let part = cut([0.0205, 0.03]).unwrap();
            assert_eq!(part.channels[0], ramp[21..30], "{format:?}");
            assert_eq!(part.begin_s, 0.021, "{format:?}");
            assert!(
                cut([0.2, 0.3])
                    .unwrap_err()
                    .to_string()
                    .contains("no row lies")
            );
        }
    }

    #[test]
    fn law_what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = ([0.5, -1.25, 3.0], [1.0, 2.0, -4.0]);
        let raw = folder.path().join("r.f32");
        write_f32(&raw, &[&a, &b]).unwrap();
        let wav = folder.path().join("r.wav");
        let spec = hound::WavSpec {
            channels: 2,
            sample_rate: 1000,
            bits_per_sample: 24,
            sample_format: hound::SampleFormat::Int,
        };
        let mut writer = hound::WavWriter::create(&wav, spec).unwrap();
        for i in 0..3 {
            for v in [a[i], b[i]] {
                writer
                    .write_sample((v / 10.0 * 8_388_608.0) as i32)
                    .unwrap();
            }
        }
        writer.finalize().unwrap();
        let text = folder.path().join("r.csv");
        std::fs::write(&text, "reference,x\n0.5,1\n-1.25,2\n3,-4\n").unwrap();
        for (path, format) in [
            (&raw, WaveformFormat::F32),
            (&wav, WaveformFormat::Wav),
            (&text, WaveformFormat::Text),
        ] {
            let w = Waveform::read(path, &options(format)).unwrap();
            assert_eq!((w.samples(), w.sampling_rate_hz), (3, 1000.0));
            for (got, want) in w.channels.iter().zip([a, b]) {
                for (g, v) in got.iter().zip(want) {
                    // Half a step of 24 bits over ±10 V is 6e-7 V; the integer is cut, not rounded: 1.2e-6.
                    assert!((g - v).abs() < 1.2e-6, "{format:?}: {g} for {v}");
                }
            }
        }
    }

    #[test]
    fn refuses_files_that_are_empty_cut_or_damaged() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.f32");
        let read = || Waveform::read(&path, &options(WaveformFormat::F32));
        std::fs::write(&path, b"").unwrap();
        assert!(read().unwrap_err().to_string().contains("empty"));
        std::fs::write(&path, [0; 13]).unwrap();
        assert!(read().unwrap_err().to_string().contains("13 bytes"));
        let mut bytes = vec![0; 16];
        bytes[12..].copy_from_slice(&f32::NAN.to_le_bytes());
        std::fs::write(&path, bytes).unwrap();
        let error = read().unwrap_err();
        assert!(error.field() == Some("x") && error.to_string().contains("sample 1"));
        let mut three = options(WaveformFormat::F32);
        three.channels.push(("y".into(), 3.into()));
        assert!(Waveform::read(&path, &three).is_err());
    }
}
