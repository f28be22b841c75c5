//! `[conditioner]`: gain of each channel between device and acquisition, which the readings are divided by.

use crate::campaign::CampaignFile;
use num_complex::Complex64;
use proofmass_dynamic::log_frequency::place;
use proofmass_io::sheet::{ANGLE, FREQUENCY, PERCENT, Sheet};
use proofmass_io::{Error, ErrorKind, Input, Result};
use proofmass_shaker::{Acts, ShakerInput};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Gain of one channel of the conditioner.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ConditionerTable {
    /// Gain at every frequency, V/V.
    pub(crate) gain: Option<f64>,
    /// Table of gain and phase over frequency, relative to the campaign.
    pub(crate) file: Option<String>,
    /// Relative standard uncertainty of the gain, where no table says it.
    pub(crate) relative_standard_uncertainty: f64,
}

/// One frequency of a response.
#[derive(Clone, Copy, Debug, PartialEq)]
struct GainPoint {
    frequency: f64,
    gain: f64,
    /// Radians; that of a signal which is late is negative.
    phase: f64,
    relative_uncertainty: f64,
    phase_uncertainty: f64,
}

/// Gain of a channel over frequency: one point is a constant.
#[derive(Clone, Debug, PartialEq)]
struct Gain {
    channel: String,
    points: Vec<GainPoint>,
    /// Whether it is the same at every frequency.
    constant: bool,
}

/// Gains of the channels that have one.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Conditioner {
    gains: Vec<Gain>,
    pub(crate) inputs: Vec<Input>,
}

impl Conditioner {
    /// Reads what `[conditioner]` says of these channels.
    ///
    /// # Errors
    /// An unknown channel, a gain that is missing, stated twice or impossible, a table that cannot be read.
    pub(crate) fn read(
        source: &CampaignFile,
        tables: &BTreeMap<String, ConditionerTable>,
        channels: &[&str],
    ) -> Result<Self> {
        let mut conditioner = Self::default();
        for (channel, table) in tables {
            let refuse = |what: String, hint: &str| {
                source.refuse("conditioner", channel, what).with_hint(hint)
            };
            if !channels.contains(&channel.as_str()) {
                return Err(source
                    .refuse(
                        "conditioner",
                        channel,
                        format!("unknown channel \"{channel}\""),
                    )
                    .with_hint(format!("channels of this kind: {}", channels.join(", "))));
            }
            let (points, constant) = match (table.gain, &table.file) {
                (Some(gain), None) => {
                    let u = table.relative_standard_uncertainty;
                    if !(gain.is_finite() && gain != 0.0) {
                        return Err(refuse(
                            format!(
                                "a gain of {gain} is out of range: it must be finite and not zero"
                            ),
                            "volts at the output per volt at the input, such as 10; negative where the conditioner inverts",
                        ));
                    }
                    if !(0.0..0.5).contains(&u) {
                        return Err(refuse(
                            format!(
                                "relative_standard_uncertainty = {u} is out of range: from 0 to below 0.5"
                            ),
                            "of 0.1 % with k = 2 it is 0.0005",
                        ));
                    }
                    let point = GainPoint {
                        frequency: 1.0,
                        gain,
                        phase: 0.0,
                        relative_uncertainty: u,
                        phase_uncertainty: 0.0,
                    };
                    (vec![point], true)
                }
                (None, Some(file)) => {
                    if table.relative_standard_uncertainty != 0.0 {
                        return Err(refuse(
                            "the table states the uncertainty, and relative_standard_uncertainty states it again".to_owned(),
                            "keep the column u_relative_% of the table",
                        ));
                    }
                    let (input, points) = read_response(source, file)?;
                    conditioner.inputs.push(input);
                    (points, false)
                }
                (Some(_), Some(_)) => {
                    return Err(refuse(
                        "`gain` and `file` exclude each other".to_owned(),
                        "a table holds the gain at each of its frequencies",
                    ));
                }
                (None, None) => {
                    return Err(refuse(
                        format!("the gain of channel {channel} is missing"),
                        "gain = 10, or file = \"conditioner.csv\" with frequency_Hz, gain, phase_deg, u_relative_%, u_phase_deg",
                    ));
                }
            };
            conditioner.gains.push(Gain {
                channel: channel.clone(),
                points,
                constant,
            });
        }
        Ok(conditioner)
    }

    /// Complex gain of a channel at a frequency, Hz; `None` of a channel without one.
    ///
    /// # Errors
    /// A frequency that the table does not reach.
    pub(crate) fn gain(&self, channel: &str, frequency: f64) -> Result<Option<Complex64>> {
        let Some(gain) = self.gains.iter().find(|g| g.channel == channel) else {
            return Ok(None);
        };
        let point = gain.at(frequency)?;
        Ok(Some(Complex64::from_polar(1.0, point.phase) * point.gain))
    }

    /// What is uncertain of the gains, as inputs of a budget for a campaign at these ascending frequencies: the reference is common to the
    /// outputs, each output has its own.
    ///
    /// # Errors
    /// A frequency that a table does not reach.
    pub(crate) fn budget(&self, outputs: &[&str], frequencies: &[f64]) -> Result<Vec<ShakerInput>> {
        let mut inputs = Vec::new();
        for gain in &self.gains {
            let points = frequencies
                .iter()
                .map(|f| gain.at(*f))
                .collect::<Result<Vec<_>>>()?;
            let output = outputs.iter().position(|o| *o == gain.channel);
            let [modulus, phase] = match output {
                Some(_) => [Acts::OutputModulus, Acts::OutputPhase],
                None => [Acts::ReferenceModulus, Acts::ReferencePhase],
            };
            type Of = fn(&GainPoint) -> f64;
            let kinds: [(&str, Acts, Of); 2] = [
                ("gain", modulus, |p| p.relative_uncertainty),
                ("phase", phase, |p| p.phase_uncertainty),
            ];
            for (word, acts, u) in kinds {
                let list: Vec<(f64, f64)> = frequencies
                    .iter()
                    .zip(&points)
                    .map(|(f, p)| (*f, u(p)))
                    .collect();
                if list.iter().all(|(_, u)| *u == 0.0) {
                    continue;
                }
                let name = format!("conditioner.{word}.{}", gain.channel);
                let text = format!("{word} of the conditioner of channel {}", gain.channel);
                let mut input = ShakerInput::new(&name, acts, 0.0, &[]).described(&text);
                input = input.over_frequency(list);
                input.output = output;
                inputs.push(input);
            }
        }
        Ok(inputs)
    }
}

impl Gain {
    /// At a frequency, Hz: between two of the table linear in log f.
    fn at(&self, frequency: f64) -> Result<GainPoint> {
        let points = &self.points;
        if let ([only], true) = (points.as_slice(), self.constant) {
            return Ok(*only);
        }
        let Some((k, share)) = place(points, |p| p.frequency, frequency) else {
            let ends = points.first().zip(points.last());
            let (low, high) = ends.map_or((0.0, 0.0), |(a, b)| (a.frequency, b.frequency));
            return Err(Error::new(
                ErrorKind::Configuration,
                format!(
                    "the gain of channel {} is stated from {low} to {high} Hz, and a run is at {frequency} Hz",
                    self.channel
                ),
            )
            .column("conditioner")
            .with_hint("add the frequency to its table: nobody knows the gain beyond it"));
        };
        let a = points[k];
        let b = points.get(k + 1).copied().unwrap_or(a);
        let mix = |of: fn(&GainPoint) -> f64| of(&a) + share * (of(&b) - of(&a));
        Ok(GainPoint {
            frequency,
            gain: mix(|p| p.gain),
            phase: mix(|p| p.phase),
            relative_uncertainty: mix(|p| p.relative_uncertainty),
            phase_uncertainty: mix(|p| p.phase_uncertainty),
        })
    }
}

/// A table: `frequency_Hz`, `gain`, `phase_deg`, `u_relative_%`, `u_phase_deg`.
fn read_response(source: &CampaignFile, file: &str) -> Result<(Input, Vec<GainPoint>)> {
    let mut sheet = Sheet::from_source(source.source(file)?, "table of the conditioner")?;
    let frequency = sheet.quantity("frequency", FREQUENCY)?;
    let gain = sheet.quantity("gain", &[("", 1.0), ("V/V", 1.0), ("1", 1.0)])?;
    let phase = sheet.quantity("phase", ANGLE)?;
    let u_relative = sheet.quantity("u_relative", PERCENT)?;
    let u_phase = sheet.quantity("u_phase", ANGLE)?;
    sheet.finish()?;
    let frequency = sheet.required(frequency, "frequency_Hz")?;
    let gain = sheet.required(gain, "gain")?;
    let mut points: Vec<GainPoint> = Vec::new();
    for row in sheet.rows() {
        let value = row.number(gain)?;
        if value == 0.0 {
            return Err(row
                .refuse(
                    gain,
                    "a gain of 0 is out of range: it must be finite and not zero",
                )
                .with_hint("volts at the output per volt at the input, such as 10"));
        }
        let point = GainPoint {
            frequency: row.positive(frequency)?,
            gain: value,
            phase: row.optional(phase)?.unwrap_or(0.0),
            relative_uncertainty: row.uncertainty(u_relative)?,
            phase_uncertainty: row.uncertainty(u_phase)?,
        };
        if let Some(before) = points.last()
            && before.frequency >= point.frequency
        {
            return Err(row
                .refuse(
                    frequency,
                    format!("{} Hz behind {} Hz", point.frequency, before.frequency),
                )
                .with_hint("list each frequency once, in ascending order"));
        }
        if let Some(before) = points.last()
            && before.gain.signum() != value.signum()
        {
            return Err(row
                .refuse(gain, "the gain changes its sign")
                .with_hint("keep the sign and write an inversion as a phase of 180°"));
        }
        points.push(point);
    }
    Ok((sheet.input.clone(), points))
}
