//! A recording that a command writes: its place, what may stand there before, and the provenance beside it.

use crate::{Failure, console};
use proofmass::io::{AtomicFile, Input, Provenance, SigningKey, not_an_input};
use std::path::{Path, PathBuf};

/// Options of every command that writes a recording.
#[derive(clap::Args)]
pub(crate) struct WrittenFile {
    /// File for the new recording, replaced if proofmass wrote it; `-` is standard output
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Replace a file that proofmass did not write or that was changed since
    #[arg(long)]
    force: bool,
    /// Sign where the file came from with a private key (PEM, Ed25519), as `proofmass keygen` makes it
    #[arg(long, value_name = "KEY")]
    sign: Option<PathBuf>,
}

/// What was settled before the work.
pub(crate) struct Replacement {
    /// Digest of what stands there.
    replaced: Option<String>,
    signer: Option<SigningKey>,
}

impl WrittenFile {
    /// Refuses a place that may not be taken, one of the inputs first, and says so where a signature goes with what is replaced.
    pub(crate) fn begin(&self, inputs: &[&Path]) -> Result<Replacement, Failure> {
        not_an_input(&self.output, inputs)?;
        let replaced = self.may_replace()?;
        self.list_may_stand()?;
        let signer = self.sign.as_deref().map(SigningKey::read).transpose()?;
        let replaced_key = Provenance::of(&self.output)
            .ok()
            .flatten()
            .and_then(|p| Some(p.signature?.key));
        let key = signer.as_ref().map(|s| s.public().to_string());
        if let Some(old) = replaced_key.filter(|old| key.as_ref() != Some(old)) {
            console::unsigned(&self.output.display().to_string(), &old, key.is_some());
        }
        Ok(Replacement { replaced, signer })
    }

    /// Whether what stands at the place may go: what an earlier run wrote there and nobody changed, or what the user says.
    /// Its digest, where something stands there.
    fn may_replace(&self) -> Result<Option<String>, Failure> {
        if !console::stands(&self.output) || self.output == Path::new("-") {
            return Ok(None);
        }
        let there = Input::of(&self.output)?.sha256;
        let own = match Provenance::of(&self.output) {
            Ok(Some(provenance)) => provenance.wrote(&there),
            _ => false,
        };
        if console::may_replace(&self.output, self.force || own) {
            return Ok(Some(there));
        }
        Err(Failure::new(format!(
            "{} is there, and was not written by `proofmass` or was changed since",
            self.output.display()
        ))
        .hint("name another file, or replace it with --force"))
    }

    /// Refuses to replace what stands where the list goes and is none.
    fn list_may_stand(&self) -> Result<(), Failure> {
        let place = Provenance::place(&self.output);
        let to_stdout = self.output == Path::new("-");
        if to_stdout
            || !console::stands(&place)
            || matches!(Provenance::of(&self.output), Ok(Some(_)))
        {
            return Ok(());
        }
        if console::may_replace(&place, self.force) {
            return Ok(());
        }
        Err(Failure::new(format!(
            "{} is there, and is no provenance that `proofmass` wrote; it would be replaced",
            place.display()
        ))
        .hint("name another output, or replace both with --force"))
    }

    /// The list beside the file, signed where there is a key. It is written before the file itself: a run that is killed in between
    /// leaves one that the next may replace.
    pub(crate) fn write_beside(
        &self,
        replacement: &Replacement,
        inputs: &[&Path],
        read: Vec<Input>,
        (sha256, steps): (&str, &[String]),
    ) -> proofmass::io::Result<()> {
        let mut provenance = Provenance::new(sha256, read);
        provenance.steps = steps.to_vec();
        provenance.replaces.clone_from(&replacement.replaced);
        if let Some(key) = &replacement.signer {
            provenance = provenance.signed(key);
        }
        let mut beside = AtomicFile::create(Provenance::place(&self.output), inputs)?;
        beside.write_all(&provenance.to_json()?)?;
        beside.commit()
    }
}

/// Says how a recording was read.
pub(crate) fn read(input: &Input) {
    console::doubt(input);
    if let Some(reading) = &input.reading {
        console::note(format!("read: {}", reading.line(&input.path)));
    }
}
