//! Recordings and campaigns whose truth is known.

mod axis;
mod construction;
mod fault;
mod multi_position;
mod noise;
mod page;
mod primary;
mod sensor;
mod shaker;
mod spurious_motion;
mod transducer;
mod wedge_motion;

pub use axis::{SimulatedAxis, SimulatedMotion};
pub use construction::{
    CantileverTable, CombTable, DeviceConstruction, GaugeTable, PiezoTable, PlateTable,
    ResonantTable, SeriesTable, ShutterTable, ThermalTable, TransducerConstruction,
    TunnellingTable,
};
pub use fault::{Practice, PracticeFault};
pub use multi_position::SimulatedMultiPosition;
pub use noise::{SimulatedKind, SimulatedNoise};
pub use primary::SimulatedPrimary;
pub use shaker::SimulatedShaker;
pub use spurious_motion::SimulatedSpuriousMotion;
pub use transducer::{SimulatedExcitation, SimulatedPrinciple, SimulatedTransducer};

use crate::outcome::{Job, Outcome};
use crate::record::Record;
use crate::store::Sink;
use crate::trouble::{Result, Trouble, TroubleKind};
use proofmass_core::Watch;
use proofmass_documents::StatedQuantity;
use proofmass_io::{Input, sha256};
use proofmass_report::Report;
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

use std::sync::{Mutex, PoisonError};

/// What is to be simulated. The same request makes the same files on every machine.
///
/// ```
/// use proofmass_jobs::campaign::Campaign;
/// use proofmass_jobs::simulate::{SimulateJob, SimulatedMultiPosition};
/// use proofmass_jobs::{Gathered, Job, Sink, Unwatched};
/// use std::sync::Arc;
///
/// let job = SimulateJob::MultiPosition(SimulatedMultiPosition::default());
/// let files = Gathered::default();
/// let outcome = job.evaluate(&(&files as &dyn Sink), &Unwatched)?;
/// assert_eq!(outcome.files().len(), 3);
/// // What was simulated can be calibrated at once, without a disk.
/// let campaign = Campaign::read(Arc::new(files.into_memory()), "campaign.toml")?;
/// let result = campaign.evaluate(None, &Unwatched)?;
/// let scale = result.quantities().into_iter().find(|q| q.name == "scale.x").unwrap();
/// assert!((scale.value - outcome.truth()["K_count_per_m_per_s2"][0][0].as_f64().unwrap()).abs() < 2.0 * scale.expanded);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "scenario", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum SimulateJob {
    /// A triaxial accelerometer turned by hand from rest to rest.
    MultiPosition(SimulatedMultiPosition),
    /// A triaxial accelerometer on wedges on a shaker.
    Shaker(SimulatedShaker),
    /// A vibrometer along the three axes of the table, wedge by wedge.
    SpuriousMotion(SimulatedSpuriousMotion),
    /// An accelerometer before a laser interferometer.
    Primary(SimulatedPrimary),
    /// A driven axis with encoder and accelerometer.
    Axis(SimulatedAxis),
    /// A transducer under a shock, noise, a sweep or a step.
    Transducer(SimulatedTransducer),
    /// A sensor at rest with known noise.
    Noise(SimulatedNoise),
}

/// What was simulated: the files with their digests, and the truth.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulateOutcome {
    scenario: String,
    files: Vec<Input>,
    truth: serde_json::Value,
}

impl SimulateOutcome {
    /// The files that were written.
    pub fn files(&self) -> &[Input] {
        &self.files
    }

    /// What truth.json holds.
    pub fn truth(&self) -> &serde_json::Value {
        &self.truth
    }
}

impl Outcome for SimulateOutcome {
    const KIND: &'static str = "simulate";

    fn title(&self, record: &Record) -> String {
        record.title("Simulation of", "Simulated recordings")
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        Vec::new()
    }

    fn findings(&self) -> &[Finding] {
        &[]
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }
}

impl Job for SimulateJob {
    type Data<'a> = &'a dyn Sink;
    type Outcome = SimulateOutcome;

    fn evaluate(&self, data: &&dyn Sink, watch: &dyn Watch) -> Result<SimulateOutcome> {
        let desk = Desk {
            sink: *data,
            written: Mutex::new(Vec::new()),
            watch,
        };
        watch.step("simulation", 0, 1)?;
        let (scenario, truth) = match self {
            Self::MultiPosition(s) => ("multi-position", s.simulate(&desk)?),
            Self::Shaker(s) => ("shaker", s.simulate(&desk)?),
            Self::SpuriousMotion(s) => ("spurious-motion", s.simulate(&desk)?),
            Self::Primary(s) => ("primary", s.simulate(&desk)?),
            Self::Axis(s) => ("axis", s.simulate(&desk)?),
            Self::Transducer(s) => ("transducer", s.simulate(&desk)?),
            Self::Noise(s) => ("noise", s.simulate(&desk)?),
        };
        watch.step("simulation", 1, 1)?;
        let mut files = desk.written.into_inner().unwrap_or_default();
        files.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(SimulateOutcome {
            scenario: scenario.to_owned(),
            files,
            truth,
        })
    }
}

/// Where a scenario puts its files.
pub(crate) struct Desk<'a> {
    sink: &'a dyn Sink,
    written: Mutex<Vec<Input>>,
    watch: &'a dyn Watch,
}

impl Desk<'_> {
    fn write(&self, name: &str, bytes: Vec<u8>) -> Result<()> {
        let sha256 = sha256(&[&bytes]);
        self.sink.write(name, bytes)?;
        if let Ok(mut written) = self.written.lock() {
            written.push(Input {
                path: name.to_owned(),
                sha256,
                ..Input::default()
            });
        }
        Ok(())
    }

    /// Tells that one more of `of` is behind, whatever thread did it: steps are counted and told in one order.
    fn one_more(&self, stage: &'static str, behind: &Mutex<u64>, of: usize) -> Result<()> {
        let mut behind = behind.lock().unwrap_or_else(PoisonError::into_inner);
        *behind += 1;
        self.watch.step(stage, *behind, of as u64)?;
        Ok(())
    }

    /// Writes truth.json and gives the truth.
    fn truth(&self, truth: &impl Serialize) -> Result<serde_json::Value> {
        let value = proofmass_io::finite::to_value(truth)?;
        let text = serde_json::to_vec_pretty(truth).map_err(|e| {
            Trouble::new(
                TroubleKind::Output,
                format!("the truth cannot be written: {e}"),
            )
        })?;
        self.write("truth.json", text)?;
        Ok(value)
    }
}
