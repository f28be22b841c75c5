//! `proofmass verify`: whether a result and everything it came from are unchanged.

use crate::{Failure, Outcome, console};
use proofmass::documents::Verification;
use proofmass::io::VerifyingKey;
use proofmass::jobs::verification;
use std::path::PathBuf;

/// Check by digests that a result and the files behind it are unchanged.
///
/// From a folder of results, a result.json, a calibration.json or a recording that `proofmass apply` wrote, back to the raw
/// recordings as far as they are found. Ends with exit code 1 where a file was changed or is missing, a signature does not hold,
/// or, with --key, a list of files is not signed by one of the keys.
#[derive(clap::Args)]
pub(crate) struct Verify {
    /// Folder of results, result.json, calibration.json or compensated recording
    result: PathBuf,
    /// Folder in which inputs are looked for that are not where they were
    #[arg(long, value_name = "FOLDER")]
    data: Option<PathBuf>,
    /// Public key that must have signed every list of files (PEM, Ed25519); may be given several times
    #[arg(long, value_name = "FILE")]
    key: Vec<PathBuf>,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

impl Verify {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let keys = self
            .key
            .iter()
            .map(|path| VerifyingKey::read(path))
            .collect::<Result<Vec<_>, _>>()?;
        let chain = Verification::of(&self.result, self.data.as_deref())?;
        if self.json {
            let json = serde_json::to_vec_pretty(&chain)
                .map_err(|e| Failure::new(format!("the verification cannot be written: {e}")))?;
            console::print_json(&json)?;
        } else {
            console::show(&verification::page(&self.result, &chain))?;
        }
        verification::judge(&chain, &keys)?;
        Ok(Outcome::Done)
    }
}
