//! Where a file came from: what stands beside it, and whether it is still what its list says.

use crate::output::{MANIFEST, Manifest};
use crate::signature::{Signature, SigningKey, quoted};
use crate::software::{Schema, Software};
use crate::{Error, ErrorKind, Input, LARGEST_DOCUMENT, Result, Source};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Name of the form.
pub const PROVENANCE_SCHEMA: &str = "proofmass.provenance";
/// Version of the form.
pub const PROVENANCE_VERSION: u32 = 1;
/// Of a signature that does not hold.
pub const FORGED: &str = "the signature is not of what stands there now";
/// Ending of the file that stands beside a compensated recording.
const ENDING: &str = ".provenance.json";

/// Where a single file came from: what stands beside it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Provenance {
    /// Form and version.
    pub(crate) schema: Schema,
    /// Program that wrote it.
    pub software: Software,
    /// SHA-256 of the file in hexadecimal digits.
    pub sha256: String,
    /// Files it was computed from.
    pub inputs: Vec<Input>,
    /// What was done to the samples, step by step in this order, where it is more than a compensation.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<String>,
    /// SHA-256 of the file that stood there before: a run that was killed while it replaced it left that one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub replaces: Option<String>,
    /// Who vouches for all of this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signature: Option<Signature>,
}

impl Provenance {
    /// For a file with this digest.
    pub fn new(sha256: impl Into<String>, inputs: Vec<Input>) -> Self {
        Self {
            schema: Schema::new(PROVENANCE_SCHEMA, PROVENANCE_VERSION),
            software: Software::default(),
            sha256: sha256.into(),
            inputs,
            steps: Vec::new(),
            replaces: None,
            signature: None,
        }
    }

    /// Whether a file with this digest is what was written, or what stood there when it was to be replaced.
    pub fn wrote(&self, sha256: &str) -> bool {
        self.sha256 == sha256 || self.replaces.as_deref() == Some(sha256)
    }

    /// Signed with a key.
    #[must_use]
    pub fn signed(mut self, key: &SigningKey) -> Self {
        self.signature = Some(key.sign(&self.statement()));
        self
    }

    /// What a signature is of: form, program, digest, and a line for each input and each step in order.
    pub fn statement(&self) -> String {
        let mut text = format!(
            "{} {}\nsoftware {} {}\noutput {}\n",
            self.schema.name,
            self.schema.version,
            quoted(&self.software.name),
            quoted(&self.software.version),
            quoted(&self.sha256)
        );
        for input in self.inputs.iter().flat_map(Input::files) {
            text += &format!("input {} {}\n", quoted(&input.sha256), quoted(&input.path));
        }
        for step in &self.steps {
            text += &format!("step {}\n", quoted(step));
        }
        text
    }

    /// Where the provenance of a file stands: beside it, with `.provenance.json` after its name.
    pub fn place(file: &Path) -> PathBuf {
        let mut name = file.as_os_str().to_owned();
        name.push(ENDING);
        PathBuf::from(name)
    }

    /// The provenance of a file, `None` where none stands beside it.
    ///
    /// # Errors
    /// It is damaged or of another form.
    pub fn of(file: &Path) -> Result<Option<Self>> {
        let place = Self::place(file);
        if !place.is_file() {
            return Ok(None);
        }
        let (bytes, _) = Source::open(&place)?.into_bytes(LARGEST_DOCUMENT)?;
        Self::from_json(&bytes).map(Some).map_err(|e| e.at(&place))
    }

    /// Reads the bytes of a provenance.
    ///
    /// # Errors
    /// Another form or version, damage.
    pub fn from_json(bytes: &[u8]) -> Result<Self> {
        let found: Self = serde_json::from_slice(bytes).map_err(|e| {
            let what = format!("is not a provenance of proofmass: {e}");
            Error::new(ErrorKind::Format, what).because(e)
        })?;
        found
            .schema
            .require(PROVENANCE_SCHEMA, PROVENANCE_VERSION)?;
        Ok(found)
    }

    /// The bytes of the file.
    ///
    /// # Errors
    /// None in practice.
    pub fn to_json(&self) -> Result<Vec<u8>> {
        crate::finite::to_json(self)
    }
}

/// Why a file with this digest is not to be trusted: it is not what the list of its folder or the provenance beside it says, or the
/// signature there is not of what it says now. `None` where it is, and where nothing names it.
pub(crate) fn doubt_of(path: &Path, sha256: &str) -> Option<String> {
    // What says so is vouched for by its signature alone.
    let name = path.file_name()?.to_str()?;
    if name == MANIFEST || name.ends_with(ENDING) {
        return None;
    }
    let (list, same, signature, statement) = match listing(path) {
        Some((manifest, listed)) => {
            let statement = manifest.statement();
            let list = path.with_file_name(MANIFEST);
            if !manifest.vouches() {
                return None;
            }
            (list, listed == sha256, manifest.signature, statement)
        }
        None => {
            let beside = Provenance::of(path).ok()??;
            let statement = beside.statement();
            let list = Provenance::place(path);
            (list, beside.wrote(sha256), beside.signature, statement)
        }
    };
    let forged = || signature.is_some_and(|s| s.signer(&statement).is_none());
    match same {
        false => Some(format!(
            "{} was changed since it was written: {} lists another digest",
            path.display(),
            list.display()
        )),
        true => forged().then(|| format!("{}: {FORGED}", list.display())),
    }
}

/// What nobody vouches for in a result.json: itself where no list names it, else what it was rendered from when none did.
pub fn unlisted(path: &Path, input: &Input) -> Option<Input> {
    match listing(path) {
        Some((manifest, _)) => manifest.rendered_from,
        None => Some(input.clone()),
    }
}

/// The list beside a file that names it, and the digest that it has there.
pub fn listing(path: &Path) -> Option<(Manifest, String)> {
    let manifest = Manifest::read(path.parent()?).ok()??;
    let name = path.file_name()?.to_str()?;
    let file = manifest.files.iter().find(|f| f.name == name)?;
    let sha256 = file.sha256.clone();
    Some((manifest, sha256))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps are part of what is signed; a file without them has the statement that it had before there were any.
    #[test]
    fn law_steps_are_part_of_the_statement() {
        let mut provenance = Provenance::new("00", Vec::new());
        let plain = provenance.statement();
        provenance.steps = vec!["calibration".to_owned(), "low-pass".to_owned()];
        let told = provenance.statement();
        assert!(told.starts_with(&plain) && told.len() > plain.len());
        provenance.steps.reverse();
        assert_ne!(provenance.statement(), told);
        let back = Provenance::from_json(&provenance.to_json().unwrap()).unwrap();
        assert_eq!(back, provenance);
    }
}
