//! `proofmass keygen`: a pair of keys to sign results with.

use crate::{Failure, Outcome, console};
use proofmass::io::SigningKey;
use std::path::PathBuf;

/// Make a pair of keys to sign results with.
///
/// NAME.key signs results (`--sign`), NAME.pub verifies them (`proofmass verify --key`).
/// Ed25519 in the PEM form of OpenSSL. The private key is not encrypted: keep it where only you can read it. A key is never
/// replaced.
#[derive(clap::Args)]
pub(crate) struct Keygen {
    /// Path of both files, without ending
    name: PathBuf,
}

impl Keygen {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let key = SigningKey::generate()?;
        let [private, public] = key.write(&self.name)?;
        console::print(&format!("{}\n", key.public()))?;
        console::note(format!(
            "written: {} (keep it secret), {} (give it away)",
            private.display(),
            public.display()
        ));
        Ok(Outcome::Done)
    }
}
