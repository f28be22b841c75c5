//! A campaign for practice: the one that `proofmass simulate shaker` writes, small.

use proofmass::jobs::simulate::{SimulateJob, SimulatedShaker};
use proofmass::jobs::{Job, Sink, Unwatched};
use std::path::{Path, PathBuf};

/// Files of a folder; the recordings are left out, for they are what the bench measures.
struct Plans<'a>(&'a Path);

impl Sink for Plans<'_> {
    fn write(&self, name: &str, bytes: Vec<u8>) -> proofmass::io::Result<()> {
        if name.ends_with(".f32") {
            return Ok(());
        }
        let place = self.0.join(name);
        std::fs::write(&place, bytes).map_err(|e| {
            let what = format!("cannot be written: {e}");
            proofmass::io::Error::new(proofmass::io::ErrorKind::Output, what).at(&place)
        })
    }
}

/// Writes a plan of six mountings and three frequencies beside the folder that will be recorded, and names it.
///
/// # Errors
/// A disk that refuses.
pub fn campaign(output: &Path, seed: u64) -> Result<PathBuf, String> {
    let name = output.file_name().unwrap_or_default().to_string_lossy();
    let folder = output.with_file_name(format!("{name}-plan"));
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut shaker = SimulatedShaker::default();
    shaker.seed = seed;
    shaker.frequencies = vec![40.0, 160.0, 630.0];
    shaker.configurations = 6;
    shaker.duration = 0.1;
    let job = SimulateJob::Shaker(shaker);
    job.evaluate(&(&Plans(&folder) as &dyn Sink), &Unwatched)
        .map_err(|e| e.to_string())?;
    Ok(folder)
}
