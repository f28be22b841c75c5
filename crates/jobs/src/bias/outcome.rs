//! The bias over a recording, as it is filed.

use super::{AxisNoise, BiasData, BiasJob, page};
use crate::firmware::Firmware;
use crate::outcome::{Outcome, section};
use crate::record::{Record, gravity_of};
use crate::trouble::Result;
use proofmass_core::{BiasFilter, Error};
use proofmass_documents::{FirmwareBlock, StatedQuantity};
use proofmass_io::ReadGravity;
use proofmass_report::Report;
use proofmass_static::{AxisTrack, BiasTrack, Segment};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

/// One rest of the recording.
#[derive(Clone, Debug, PartialEq)]
pub struct BiasRest {
    /// Its name, where it has one.
    pub(crate) label: Option<String>,
    /// Time of its first sample, s.
    pub(crate) start: f64,
    /// Time of its last sample, s.
    pub(crate) end: f64,
}

/// Coefficients of [`BiasFilter`] at the rate of the recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct OnChip {
    /// Samples per second.
    rate: f64,
    /// φ, Q in (m/s²)², R in (m/s²)² of x, y, z.
    coefficients: [[f64; 3]; 3],
    /// Bias and variance at the end of the recording.
    state: [[f64; 2]; 3],
}

impl OnChip {
    /// Section of result.json.
    pub(crate) const SECTION: &'static str = "bias_filter";

    /// Time between samples, s.
    pub(super) fn period(&self) -> f64 {
        1.0 / self.rate
    }

    /// Q over time of x, y, z, (m/s²)²/s: the density of the walk, and more than that of a Gauss–Markov process between two times.
    pub(super) fn walk(&self) -> [f64; 3] {
        self.coefficients.map(|[_, q, _]| q * self.rate)
    }

    /// The filter of the chip, with the state at the end of the recording.
    pub(crate) fn firmware(self) -> Firmware {
        Firmware {
            block: FirmwareBlock::Bias {
                rate: self.rate,
                coefficients: self.coefficients,
                state: self.state,
            },
            notes: vec![
                "predict at every sample, update while the acceleration is known.".to_owned(),
            ],
        }
    }
}

/// The bias over a recording.
///
/// The quantities are the bias of each axis at the end of the recording.
#[derive(Clone, Debug, PartialEq)]
pub struct BiasOutcome {
    quantities: Vec<StatedQuantity>,
    findings: Vec<Finding>,
    pub(super) request: BiasJob,
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
            quantities: StatedQuantity::list(&track.quantities, job.probability),
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

    /// Samples per second, and φ, Q, R of x, y, z at that rate.
    pub(super) fn coefficients(&self) -> (f64, &[[f64; 3]; 3]) {
        (self.firmware.rate, &self.firmware.coefficients)
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

    fn gravity(&self) -> Option<ReadGravity> {
        let BiasJob {
            standard_gravity,
            place,
            ..
        } = self.request;
        let gravity = self.request.gravity;
        gravity.map(|g| gravity_of(g, standard_gravity, place))
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![section(OnChip::SECTION, &self.firmware)?])
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }
}
