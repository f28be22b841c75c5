//! `proofmass modes`: natural frequencies and mode shapes of a wedge.

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::{Failure, Outcome, clock};
use proofmass::jobs::modes::{ModesFile, ModesOutcome};
use proofmass::jobs::{Job, Outcome as _, StoredResult};
use std::path::PathBuf;

/// Natural frequencies and mode shapes of a wedge, by finite elements.
///
/// The file gives a wedge by its dimensions or names a Gmsh mesh, and states its support. Results: frequencies with their
/// intervals, deformed shapes, the spurious motion (spurious.csv, in the form of a vibrometer's table), modes.vtu for ParaView.
/// With [search], the shape whose first relevant mode is highest, or whose gluing point moves least. With two files, both in one report.
#[derive(clap::Args)]
pub(crate) struct Modes {
    /// Description of the fixture, a TOML file
    wedge: PathBuf,
    /// Another fixture, which stands beside it in the report
    beside: Option<PathBuf>,
    #[command(flatten)]
    delivery: Delivery,
}

impl Modes {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let mut file = ModesFile::open(&self.wedge)?;
        let mut read = vec![self.wedge.as_path()];
        if let Some(other) = &self.beside {
            file = file.beside(ModesFile::open(other)?);
            read.push(other);
        }
        let folder = self.delivery.begin(ModesOutcome::KIND, &read)?;
        let record = file.record(Some(clock::today()));
        let outcome = (file.job).answer(&file.data(), &record.inputs, &Progress::new())?;
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }
}
