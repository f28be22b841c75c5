//! Which program wrote a file, and in which version of which form.

use crate::{Error, ErrorKind, Result};
use serde::{Deserialize, Serialize};

/// Program and version that wrote a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Software {
    /// Name.
    pub(crate) name: String,
    /// Version.
    pub(crate) version: String,
}

impl Software {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its version.
    pub fn version(&self) -> &str {
        &self.version
    }
}

impl Default for Software {
    fn default() -> Self {
        Self {
            name: "proofmass".into(),
            version: env!("CARGO_PKG_VERSION").into(),
        }
    }
}

impl std::fmt::Display for Software {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.name, self.version)
    }
}

/// Name and version of the form of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Schema {
    /// Dotted name.
    pub(crate) name: String,
    /// Version, counted up when a reader of the old form could no longer read the new one.
    pub version: u32,
}

impl Schema {
    /// A form in a version.
    pub fn new(name: impl Into<String>, version: u32) -> Self {
        Self {
            name: name.into(),
            version,
        }
    }

    /// Its dotted name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Refuses another form, or another version of it.
    pub(crate) fn require(&self, name: &str, version: u32) -> Result<()> {
        if self.name == name && self.version == version {
            return Ok(());
        }
        Err(Error::new(
            ErrorKind::Format,
            format!(
                "is {} version {}; this program reads {name} version {version}",
                self.name, self.version
            ),
        ))
    }
}
