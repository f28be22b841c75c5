//! `[recording]`: how the waveforms of the runs are read.

use crate::campaign::CampaignFile;
use proofmass_io::ColumnRef;
use proofmass_io::{Result, Unit, WaveformFormat, WaveformOptions};
use proofmass_shaker::recording::{Drive, PhasorReading};
use proofmass_signal::sine::Frequency;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What is known of the drive frequency of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum DriveFrequency {
    /// The generator shares the clock of the acquisition: the frequency is that of the table.
    Known,
    /// One frequency for all channels of a run, estimated.
    #[default]
    Common,
}

/// `drive` of `[recording]`: how the shaker is driven while a recording is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum DriveKind {
    /// One frequency from the first sample to the last.
    #[default]
    Sine,
    /// Several frequencies at once.
    MultiSine,
    /// Several frequencies one after another.
    Stepped,
    /// A frequency that never stays, which gives no steady amplitude: refused.
    Swept,
}

/// Delay of a channel of the front end, seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ChannelDelay {
    /// By which the signal is late in the record: a filter, a converter.
    pub(crate) delay_s: f64,
    /// By which the channel is sampled later than the time of its row says: a multiplexer.
    pub(crate) sampled_later_s: f64,
    /// Standard uncertainty of the two together.
    pub(crate) u_s: f64,
}

impl ChannelDelay {
    /// By which the record of the channel lags, s.
    pub fn lag(&self) -> f64 {
        self.delay_s - self.sampled_later_s
    }
}

crate::campaign::text_table::text_table! {
    /// `[recording]`.
    pub struct ShakerRecording {
        /// `f32`, `wav` or `text`; the content of the file tells it, except for `f32`.
        #[serde(default)]
        pub(crate) format: WaveformFormat,
        /// Place of every channel: a number from one, or a heading of a text table.
        pub(crate) channels: BTreeMap<String, ColumnRef>,
        /// Channels in a file of raw floats, when there are more than are named.
        pub(crate) channel_count: Option<usize>,
        /// Full scale of the acquisition in volts.
        #[serde(rename = "full_scale_V", alias = "full_scale_v")]
        pub(crate) full_scale_v: Option<f64>,
        /// Unit of the columns of a text table where the headings do not say it.
        pub(crate) unit: Option<Unit>,
        /// `common` or `known`.
        #[serde(default)]
        pub(crate) frequency: DriveFrequency,
        /// `sine`, `multi-sine` or `stepped`.
        #[serde(default)]
        pub(crate) drive: DriveKind,
        /// Delays of channels of the front end.
        #[serde(default)]
        pub(crate) delays: BTreeMap<String, ChannelDelay>,
        /// Highest harmonic that is fitted.
        #[serde(default = "five")]
        pub(crate) harmonics: usize,
        /// Whether a linear drift is fitted.
        #[serde(default)]
        pub(crate) drift: bool,
    }
}

fn five() -> usize {
    5
}

impl ShakerRecording {
    /// How the phasors of the bench are read at a sampling rate, Hz.
    pub(crate) fn phasor_reading(&self, rate: f64) -> PhasorReading {
        let mut reading = PhasorReading::new(rate);
        reading.frequency = match self.frequency {
            DriveFrequency::Known => Frequency::Known,
            DriveFrequency::Common => Frequency::Common,
        };
        reading.harmonics = self.harmonics;
        reading.drift = self.drift;
        reading.full_scale = self.full_scale_v;
        reading
    }

    /// How the waveforms are read, channels in this order.
    ///
    /// # Errors
    /// A channel that is missing, unknown or named twice, a number out of place.
    pub(crate) fn options(&self, source: &CampaignFile, names: &[&str]) -> Result<WaveformOptions> {
        for (key, value) in [
            ("sampling_rate_Hz", self.sampling_rate_hz),
            ("full_scale_V", self.full_scale_v),
        ] {
            if let Some(v) = value
                && !(v.is_finite() && v > 0.0)
            {
                return Err(source.refuse(
                    "recording",
                    key,
                    format!("{v} is not a positive number"),
                ));
            }
        }
        if !(1..=50).contains(&self.harmonics) {
            return Err(source
                .refuse(
                    "recording",
                    "harmonics",
                    format!("{} is out of range: from 1 to 50 harmonics", self.harmonics),
                )
                .with_hint("1 is the fundamental alone; 5 is usual"));
        }
        for name in self.channels.keys() {
            if !names.contains(&name.as_str()) {
                return Err(source
                    .refuse(
                        "recording",
                        "channels",
                        format!("unknown channel \"{name}\""),
                    )
                    .with_hint(format!("channels of this kind: {}", names.join(", "))));
            }
        }
        let channels = names
            .iter()
            .map(|name| match self.channels.get(*name) {
                Some(place) => Ok(((*name).to_owned(), place.clone())),
                None => Err(source
                    .refuse(
                        "recording",
                        "channels",
                        format!("the channel \"{name}\" is missing"),
                    )
                    .with_hint(format!(
                        "such as channels = {{ {} }}",
                        names
                            .iter()
                            .enumerate()
                            .map(|(i, n)| format!("{n} = {}", i + 1))
                            .collect::<Vec<_>>()
                            .join(", ")
                    ))),
            })
            .collect::<Result<Vec<_>>>()?;
        for (i, (name, place)) in channels.iter().enumerate() {
            if let Some((other, _)) = channels[..i].iter().find(|(_, p)| p == place) {
                return Err(source.refuse(
                    "recording",
                    "channels",
                    format!("{name} and {other} are both {place}"),
                ));
            }
        }
        self.check_delays(source, names)?;
        source.check_between("recording", self.between_s)?;
        if self.drive == DriveKind::Swept {
            return Err(source
                .refuse("recording", "drive", "a swept sine has no steady amplitude, and none is taken from it here")
                .with_hint("drive in steps (drive = \"stepped\") or with all tones at once (\"multi-sine\"); \
                             `proofmass test sweep` takes the response of one channel from a sweep"));
        }
        let highest = channels
            .iter()
            .map(|(_, place)| match place {
                ColumnRef::Index(i) => *i,
                ColumnRef::Name(_) => 0,
            })
            .max()
            .unwrap_or(0);
        if self.format == WaveformFormat::F32 {
            if self.sampling_rate_hz.is_none() {
                return Err(source
                    .refuse(
                        "recording",
                        "sampling_rate_Hz",
                        "the sampling rate is missing",
                    )
                    .with_hint(
                        "a file of raw floats does not say it: add sampling_rate_Hz = 51200",
                    ));
            }
            if self.channel_count.is_some_and(|c| c < highest) {
                return Err(source.refuse(
                    "recording",
                    "channel_count",
                    format!("channel {highest} is named, and there are fewer"),
                ));
            }
        }
        Ok(WaveformOptions {
            format: self.format,
            sampling_rate_hz: self.sampling_rate_hz,
            channels,
            channel_count: self.channel_count.unwrap_or(highest),
            full_scale_v: self.full_scale_v,
            layout: self.layout(),
            unit: self.unit,
            quantity: Unit::Volt,
            time: self.time.clone(),
            time_unit: self.time_unit,
            between: self.between_s,
            stream: self.source.clone(),
        })
    }

    /// How the shaker was driven.
    pub(crate) fn drive(&self) -> Drive {
        match self.drive {
            DriveKind::Sine | DriveKind::Swept => Drive::Sine,
            DriveKind::MultiSine => Drive::MultiSine,
            DriveKind::Stepped => Drive::Stepped,
        }
    }

    /// Standard uncertainty of the delay of a channel, s; zero where none is stated.
    pub(crate) fn delay_uncertainty(&self, channel: &str) -> f64 {
        self.delays.get(channel).map_or(0.0, |d| d.u_s)
    }

    fn check_delays(&self, source: &CampaignFile, names: &[&str]) -> Result<()> {
        for (name, delay) in &self.delays {
            let field = format!("delays.{name}");
            if !names.contains(&name.as_str()) {
                return Err(source
                    .refuse("recording", &field, format!("unknown channel \"{name}\""))
                    .with_hint(format!("channels of [recording]: {}", names.join(", "))));
            }
            for (key, value) in [
                ("delay_s", delay.delay_s),
                ("sampled_later_s", delay.sampled_later_s),
                ("u_s", delay.u_s),
            ] {
                if !(value.is_finite() && value.abs() < 10.0 && (key != "u_s" || value >= 0.0)) {
                    return Err(source
                        .refuse(
                            "recording",
                            &field,
                            match key {
                                "u_s" => format!("{key} = {value} is out of range: from 0 to 10 s"),
                                _ => format!("{key} = {value} is out of range: from −10 s to 10 s"),
                            },
                        )
                        .with_hint(
                            "seconds, such as x = { sampled_later_s = 2.5e-6, u_s = 1e-8 }",
                        ));
                }
            }
        }
        Ok(())
    }
}
