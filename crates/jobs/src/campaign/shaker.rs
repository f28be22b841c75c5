//! What the campaigns on the shaker share: runs, waveforms, certificate, spurious motion, budget.

mod budget;
mod certificate;
mod conditioner;
mod datasheet;
mod mounting;
mod output_recording;
mod recording;
mod runs;
mod seat;
mod spurious;

pub(crate) use budget::BudgetSource;
pub use budget::ShakerBudget;
pub use certificate::{Certificate, CertificateOptions, CertificateTable};
pub(crate) use conditioner::{Conditioner, ConditionerTable};
pub(crate) use datasheet::{Datasheet, TriaxialDatasheet};
pub(crate) use mounting::{MountingRatio, MountingTable};
pub use output_recording::OutputRecording;
pub use recording::ShakerRecording;
pub(crate) use runs::read_runs;
pub use runs::{PhasorQuantity, RunData, RunPhasor, RunTable, RunsTable, ShakerRun};
pub(crate) use seat::{CampaignPlan, read_plan};
pub use seat::{Mounting, SingleAxisSeat, SpuriousSeat, TransverseSeat};
pub use spurious::SpuriousFile;
