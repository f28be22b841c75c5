//! The bias over a recording, as it is filed.

use super::page::{BiasLine, BiasReport};
use super::{AxisNoise, BiasData, BiasJob};
use crate::firmware::Firmware;
use crate::outcome::{Outcome, section};
use crate::record::Record;
use crate::trouble::Result;
use proofmass_core::{BiasFilter, Error};
use proofmass_io::{Cell, FirmwareBlock, StatedQuantity, Table};
use proofmass_report::Report;
use proofmass_static::{AxisTrack, BiasTrack, Segment};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

/// One rest of the recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BiasRest {
    /// Its name, where it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Time of its first sample, s.
    pub start: f64,
    /// Time of its last sample, s.
    pub end: f64,
}

/// Coefficients of [`BiasFilter`] at the rate of the recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct OnChip {
    /// Samples per second.
    rate: f64,
    /// φ, Q in (m/s²)², R in (m/s²)² of x, y, z.
    coefficients: [[f64; 3]; 3],
    /// Bias and variance at the end of the recording.
    state: [[f64; 2]; 3],
}

/// The bias over a recording.
///
/// The quantities are the bias of each axis at the end of the recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BiasOutcome {
    quantities: Vec<StatedQuantity>,
    findings: Vec<Finding>,
    request: BiasJob,
    rests: Vec<BiasRest>,
    track: BiasTrack,
    firmware: OnChip,
}

impl BiasOutcome {
    pub(super) fn new(
        job: &BiasJob,
        data: &BiasData<'_>,
        rests: &[Segment],
        track: BiasTrack,
        findings: Vec<Finding>,
    ) -> Result<Self> {
        let quantities = track.quantities.iter();
        let period = 1.0 / data.rate;
        let coefficients = |axis: &AxisTrack| {
            let noise = &axis.noise;
            let variance = noise.white * noise.white * data.rate;
            let (filter, _) = BiasFilter::<f64>::new(noise.model, variance, period)?;
            Ok::<_, Error>(filter.coefficients())
        };
        let [x, y, z] = &track.axes;
        let firmware = OnChip {
            rate: data.rate,
            coefficients: [coefficients(x)?, coefficients(y)?, coefficients(z)?],
            state: [x, y, z].map(|a| [a.end().bias, a.end().u * a.end().u]),
        };
        Ok(Self {
            quantities: quantities
                .map(|q| StatedQuantity::new(q, job.probability))
                .collect(),
            findings,
            request: job.clone(),
            rests: rests
                .iter()
                .map(|rest| BiasRest {
                    label: rest.label.clone(),
                    start: data.time[rest.start],
                    end: data.time[rest.end - 1],
                })
                .collect(),
            firmware,
            track,
        })
    }

    /// The filter of the chip, with the state at the end of the recording.
    pub(crate) fn firmware(&self) -> Firmware {
        Firmware {
            block: FirmwareBlock::Bias {
                rate: self.firmware.rate,
                coefficients: self.firmware.coefficients,
                state: self.firmware.state,
            },
            notes: vec![
                "predict at every sample, update while the acceleration is known.".to_owned(),
            ],
        }
    }

    /// The track itself.
    pub fn track(&self) -> &BiasTrack {
        &self.track
    }

    /// The rests it was tracked from.
    pub fn rests(&self) -> &[BiasRest] {
        &self.rests
    }

    /// Noise that it was tracked with, as it was given.
    pub fn noise(&self) -> &[AxisNoise; 3] {
        &self.request.noise
    }

    fn page(&self, record: &Record) -> BiasReport<'_> {
        BiasReport {
            head: record.head(self.title(record), &self.findings),
            probability: self.request.probability,
            gravity: self.request.gravity.map(|g| g.value()),
            rests: self
                .rests
                .iter()
                .enumerate()
                .map(|(i, rest)| BiasLine {
                    name: rest.label.clone().unwrap_or_else(|| (i + 1).to_string()),
                    span: [rest.start, rest.end],
                })
                .collect(),
            rate: self.firmware.rate,
            coefficients: &self.firmware.coefficients,
        }
    }
}

impl Outcome for BiasOutcome {
    const KIND: &'static str = "bias";

    fn title(&self, record: &Record) -> String {
        record.title("Bias over time of", "Bias of an accelerometer over time")
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.quantities.clone()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![section("bias_filter", &self.firmware)?])
    }

    fn tables(&self) -> Result<Vec<(String, Table)>> {
        let mut heads = vec!["time_s".to_owned(), "rest".to_owned()];
        for kind in ["filtered", "smoothed"] {
            for axis in ["x", "y", "z"] {
                heads.push(format!("{kind}_{axis}_m/s2"));
                heads.push(format!("u_{kind}_{axis}_m/s2"));
            }
        }
        let mut table = Table::new(heads);
        let axes = &self.track.axes;
        for (i, time) in self.track.time.iter().enumerate() {
            let rest = self.track.rest[i].map(|r| r as f64 + 1.0);
            let mut row = vec![Cell::from(*time), Cell::from(rest)];
            for estimate in axes
                .iter()
                .map(|a| &a.filtered[i])
                .chain(axes.iter().map(|a| &a.smoothed[i]))
            {
                row.push(Cell::from(estimate.bias));
                row.push(Cell::from(estimate.u));
            }
            table.push(row)?;
        }
        let mut innovations = Table::new([
            "time_s",
            "rest",
            "innovation_x_m/s2",
            "innovation_y_m/s2",
            "innovation_z_m/s2",
            "normalised_x",
            "normalised_y",
            "normalised_z",
        ]);
        let updates = self
            .track
            .time
            .iter()
            .zip(&self.track.rest)
            .filter(|(_, rest)| rest.is_some());
        for (k, (time, rest)) in updates.enumerate() {
            let mut row = vec![Cell::from(*time), Cell::from(rest.map(|r| r as f64 + 1.0))];
            row.extend(axes.iter().map(|a| Cell::from(a.innovations[k])));
            row.extend(axes.iter().map(|a| Cell::from(a.normalised[k])));
            innovations.push(row)?;
        }
        Ok(vec![
            ("bias.csv".to_owned(), table),
            ("innovations.csv".to_owned(), innovations),
        ])
    }

    fn summary(&self, record: &Record) -> Report {
        self.page(record).summary(&self.track)
    }

    fn report(&self, record: &Record) -> Report {
        self.page(record).full(&self.track)
    }
}
