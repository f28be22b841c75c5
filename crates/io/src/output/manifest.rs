//! `manifest.json`: which files of a folder were written by which run.

use crate::signature::{Signature, SigningKey, quoted};
use crate::software::{Schema, Software};
use crate::{Error, ErrorKind, Input, Result, Source};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Name of the manifest in a folder of results.
pub const MANIFEST: &str = "manifest.json";
/// Name of the form.
pub const MANIFEST_SCHEMA: &str = "proofmass.manifest";
/// Version of the form.
pub const MANIFEST_VERSION: u32 = 1;

/// Name of the form of the result.json that a folder of results has.
pub const RESULT_SCHEMA: &str = "proofmass.result";

/// A file that was written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Listed {
    /// Name in the folder.
    pub name: String,
    /// SHA-256 in hexadecimal digits.
    pub sha256: String,
}

/// Kind of a folder without result.json.
pub(crate) const SIMULATION: &str = "simulation";

/// The files of a folder that belong to one result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Manifest {
    /// Form and version.
    pub(crate) schema: Schema,
    /// Program that wrote them.
    pub software: Software,
    /// Kind of the result, as `kind` in result.json.
    pub kind: String,
    /// The files, the manifest itself left out.
    pub files: Vec<Listed>,
    /// The result.json that they were rendered from, where no list named it: nobody says that it is as it was computed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rendered_from: Option<Input>,
    /// Who vouches for all of this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signature: Option<Signature>,
}

impl Manifest {
    /// For the files of a result.
    pub fn new(kind: impl Into<String>, files: Vec<Listed>) -> Self {
        Self {
            schema: Schema::new(MANIFEST_SCHEMA, MANIFEST_VERSION),
            software: Software::default(),
            kind: kind.into(),
            files,
            rendered_from: None,
            signature: None,
        }
    }

    /// Signed with a key.
    #[must_use]
    pub fn signed(mut self, key: &SigningKey) -> Self {
        self.signature = Some(key.sign(&self.statement()));
        self
    }

    /// What a signature is of: form, kind, program, a line for each file in order and one for what no list named.
    pub fn statement(&self) -> String {
        let mut text = format!(
            "{} {}\nkind {}\nsoftware {} {}\n",
            self.schema.name,
            self.schema.version,
            quoted(&self.kind),
            quoted(&self.software.name),
            quoted(&self.software.version)
        );
        for file in &self.files {
            text += &format!("file {} {}\n", quoted(&file.sha256), quoted(&file.name));
        }
        if let Some(source) = &self.rendered_from {
            text += &format!(
                "rendered-from {} {}\n",
                quoted(&source.sha256),
                quoted(&source.path)
            );
        }
        text
    }

    /// Whether it says that its files are as they were written: an example or a simulated campaign is there to be changed, unless signed.
    pub fn vouches(&self) -> bool {
        self.kind != SIMULATION || self.signature.is_some()
    }

    /// The manifest of a folder, `None` where there is none.
    ///
    /// # Errors
    /// A file of that name which is no manifest, or damaged.
    pub fn read(folder: &Path) -> Result<Option<Self>> {
        let path = folder.join(MANIFEST);
        if !path.is_file() {
            return Ok(None);
        }
        let (bytes, _) = Source::open(&path)?.into_bytes(crate::LARGEST_DOCUMENT)?;
        Self::from_json(&bytes).map(Some).map_err(|e| e.at(&path))
    }

    /// Reads the bytes of a manifest.
    ///
    /// # Errors
    /// Another form or version, a name that is not that of a file in the folder.
    pub fn from_json(bytes: &[u8]) -> Result<Self> {
        let wrong = |what: String| Error::new(ErrorKind::Format, what);
        let manifest: Self = serde_json::from_slice(bytes)
            .map_err(|e| wrong(format!("is not a manifest of proofmass: {e}")).because(e))?;
        manifest.schema.require(MANIFEST_SCHEMA, MANIFEST_VERSION)?;
        match manifest.files.iter().find(|f| !is_plain(&f.name)) {
            Some(file) => Err(wrong(format!(
                "names {:?}, which is no file of this folder",
                file.name
            ))),
            None => Ok(manifest),
        }
    }

    /// The bytes of the file.
    ///
    /// # Errors
    /// None in practice.
    pub fn to_json(&self) -> Result<Vec<u8>> {
        crate::finite::to_json(self)
    }
}

impl Listed {
    /// Whether the file of this name is still the one that was written.
    pub fn is_unchanged(&self, folder: &Path) -> bool {
        let path = folder.join(&self.name);
        std::fs::symlink_metadata(&path).is_ok_and(|m| m.is_file())
            && digest(&path).is_ok_and(|d| d == self.sha256)
    }
}

/// Digest of a file that is there.
pub(super) fn digest(path: &Path) -> Result<String> {
    Ok(Source::open(path)?.finish()?.sha256)
}

/// Whether a name is that of a file directly in a folder.
pub(super) fn is_plain(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    matches!(
        (parts.next(), parts.next()),
        (Some(std::path::Component::Normal(_)), None)
    ) && name != MANIFEST
        && !name.contains(['/', '\\', '\0'])
}
