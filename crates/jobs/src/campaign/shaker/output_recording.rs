//! `[output_recording]`: the file of a digital sensor beside the recording of the bench.

use crate::campaign::CampaignFile;
use crate::device_output::DeviceOutput;
use proofmass_io::ColumnRef;
use proofmass_io::{Result, Unit, WaveformFormat, WaveformOptions};
use proofmass_shaker::sample_clock::SampleClock;
use std::collections::BTreeMap;

crate::campaign::text_table::text_table! {
    /// `[output_recording]`.
    pub struct OutputRecording {
        /// `own`: the sensor samples by a clock of its own; `shared`: times of both files count from one zero, by one clock.
        pub(crate) clock: SampleClock,
        /// `text`, `f32` or `wav`.
        #[serde(default = "text")]
        pub(crate) format: WaveformFormat,
        /// Unit of the samples: `count`, `g`, `m/s²`, `V` and their like.
        pub(crate) unit: Unit,
        /// Place of every channel: a number from one, or a heading of a text table.
        pub(crate) channels: BTreeMap<String, ColumnRef>,
        /// Channels in a file of raw floats, when there are more than are named.
        pub(crate) channel_count: Option<usize>,
        /// Full scale in the unit of the samples.
        pub(crate) full_scale: Option<f64>,
    }
}

fn text() -> WaveformFormat {
    WaveformFormat::Text
}

const TABLE: &str = "output_recording";

impl OutputRecording {
    /// What the sensor gives, by the unit of its samples.
    ///
    /// # Errors
    /// A unit that no accelerometer gives.
    pub(crate) fn output(&self, source: &CampaignFile) -> Result<DeviceOutput> {
        let si = self.unit.si().0;
        let kinds = [
            DeviceOutput::Volt,
            DeviceOutput::Acceleration,
            DeviceOutput::Count,
        ];
        let kind = kinds.into_iter().find(|kind| kind.of_device() == si);
        kind.ok_or_else(|| {
            source
                .refuse(
                    TABLE,
                    "unit",
                    format!("an accelerometer gives no {}", self.unit),
                )
                .with_hint("count, g, mg, m/s2 or V")
        })
    }

    /// Full scale in the unit without prefix.
    pub(crate) fn full_scale(&self) -> Option<f64> {
        self.full_scale.map(|v| v * self.unit.si().1)
    }

    /// How the files are read: the channels of `names` that stand in them, in this order.
    ///
    /// # Errors
    /// A channel that no sensor has, a number out of place.
    pub(crate) fn options(&self, source: &CampaignFile, names: &[&str]) -> Result<WaveformOptions> {
        self.output(source)?;
        source.check_between(TABLE, self.between_s)?;
        for (key, value) in [
            ("sampling_rate_Hz", self.sampling_rate_hz),
            ("full_scale", self.full_scale),
        ] {
            if let Some(v) = value
                && !(v.is_finite() && v > 0.0)
            {
                return Err(source
                    .refuse(TABLE, key, format!("{v} is not a positive number"))
                    .with_hint(match key {
                        "full_scale" => "in the unit of the samples, or leave it out",
                        _ => "the nominal rate of the data sheet will do: its error is found with the sine",
                    }));
            }
        }
        if self.time.is_some() && self.sampling_rate_hz.is_some() {
            return Err(source
                .refuse(TABLE, "time", "a time column and a sampling rate exclude each other")
                .with_hint("keep `time` where the time stamps are those of the samples, else `sampling_rate_Hz`"));
        }
        for name in self.channels.keys() {
            if name == "reference" {
                return Err(source
                    .refuse(TABLE, "channels", "the reference is a channel of the bench")
                    .with_hint("name it in [recording]"));
            }
            if !names.contains(&name.as_str()) {
                return Err(source
                    .refuse(TABLE, "channels", format!("unknown channel \"{name}\""))
                    .with_hint(format!("channels of this kind: {}", names[1..].join(", "))));
            }
        }
        let channels: Vec<(String, ColumnRef)> = names
            .iter()
            .filter_map(|name| Some(((*name).to_owned(), self.channels.get(*name)?.clone())))
            .collect();
        if channels.is_empty() {
            return Err(source
                .refuse(TABLE, "channels", "no channel is named")
                .with_hint("such as channels = { x = \"acc_x\", y = \"acc_y\", z = \"acc_z\" }"));
        }
        for (i, (name, place)) in channels.iter().enumerate() {
            if let Some((other, _)) = channels[..i].iter().find(|(_, p)| p == place) {
                return Err(source.refuse(
                    TABLE,
                    "channels",
                    format!("{name} and {other} are both {place}"),
                ));
            }
        }
        if self.format == WaveformFormat::F32 && self.sampling_rate_hz.is_none() {
            return Err(source
                .refuse(TABLE, "sampling_rate_Hz", "the sampling rate is missing")
                .with_hint(
                    "a file of raw floats does not say it; the nominal rate of the sensor will do",
                ));
        }
        let highest = channels.iter().map(|(_, place)| match place {
            ColumnRef::Index(i) => *i,
            ColumnRef::Name(_) => 0,
        });
        let highest = highest.max().unwrap_or(0);
        Ok(WaveformOptions {
            format: self.format,
            sampling_rate_hz: self.sampling_rate_hz,
            channels,
            channel_count: self.channel_count.unwrap_or(highest),
            full_scale_v: self.full_scale(),
            layout: self.layout(),
            unit: Some(self.unit),
            quantity: self.unit.si().0,
            time: self.time.clone(),
            time_unit: self.time_unit,
            between: self.between_s,
            stream: self.source.clone(),
        })
    }
}
