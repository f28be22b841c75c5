//! Whether files are still those that a result was computed from and those that were written: the chain by digests.
//!
//! recording → campaign → result → calibration → compensated recording: every link names its predecessors with their
//! SHA-256, and a folder of results lists its files. One changed byte anywhere is found and named.

use crate::output::{MANIFEST, Manifest};
use crate::software::{Schema, Software};
use crate::{
    CalibrationFile, Error, ErrorKind, Input, LARGEST_DOCUMENT, Result, ResultDocument, Source,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Name of the form.
pub const PROVENANCE_SCHEMA: &str = "proofmass.provenance";
/// Version of the form.
pub const PROVENANCE_VERSION: u32 = 1;
/// Ending of the file that stands beside a compensated recording.
const ENDING: &str = ".provenance.json";

/// Where a single file came from: what stands beside it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// Form and version.
    pub schema: Schema,
    /// Program that wrote it.
    pub software: Software,
    /// SHA-256 of the file in hexadecimal digits.
    pub sha256: String,
    /// Files it was computed from.
    pub inputs: Vec<Input>,
}

impl Provenance {
    /// For a file with this digest.
    pub fn new(sha256: impl Into<String>, inputs: Vec<Input>) -> Self {
        Self {
            schema: Schema {
                name: PROVENANCE_SCHEMA.into(),
                version: PROVENANCE_VERSION,
            },
            software: Software::default(),
            sha256: sha256.into(),
            inputs,
        }
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
        let wrong = |what: String| Error::new(ErrorKind::Format, what);
        let found: Self = serde_json::from_slice(bytes)
            .map_err(|e| wrong(format!("is not a provenance of proofmass: {e}")).because(e))?;
        if found.schema.name != PROVENANCE_SCHEMA || found.schema.version != PROVENANCE_VERSION {
            return Err(wrong(format!(
                "is {} version {}; this program reads {PROVENANCE_SCHEMA} version {PROVENANCE_VERSION}",
                found.schema.name, found.schema.version
            )));
        }
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

/// What became of one file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fate {
    /// It is the one that was read or written.
    Unchanged,
    /// It is another one now.
    Changed,
    /// It was not found.
    Missing,
}

/// One link of the chain.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Link {
    /// The file whose list names it.
    pub named_by: PathBuf,
    /// The file as it is named there.
    pub name: String,
    /// Where it was found.
    pub found: Option<PathBuf>,
    /// Digest that it should have.
    pub sha256: String,
    /// What became of it.
    pub fate: Fate,
}

/// The whole chain.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Verification {
    /// Every link, from the newest file back.
    pub links: Vec<Link>,
    /// Programs that wrote the files.
    pub software: Vec<Software>,
}

impl Verification {
    /// Follows the chain from a folder of results, a result.json, a calibration.json or a compensated recording back as
    /// far as its files are found; `data` is a folder in which inputs are looked for too.
    ///
    /// # Errors
    /// Nothing there that names its inputs, a list that is damaged.
    pub fn of(path: impl AsRef<Path>, data: Option<&Path>) -> Result<Self> {
        let path = path.as_ref();
        let mut chain = Self::default();
        let mut seen = BTreeSet::new();
        chain.follow(path, data, &mut seen)?;
        if chain.links.is_empty() {
            return Err(Error::new(
                ErrorKind::Format,
                "names no files that could be verified",
            )
            .at(path)
            .with_hint(
                "name a folder of results, its result.json or calibration.json, or a file that `proofmass apply` wrote",
            ));
        }
        Ok(chain)
    }

    /// Whether every file that was found is unchanged, and all were found.
    pub fn is_whole(&self) -> bool {
        self.links.iter().all(|l| l.fate == Fate::Unchanged)
    }

    fn follow(
        &mut self,
        path: &Path,
        data: Option<&Path>,
        seen: &mut BTreeSet<PathBuf>,
    ) -> Result<()> {
        if !seen.insert(path.canonicalize().unwrap_or_else(|_| path.to_path_buf())) {
            return Ok(());
        }
        if path.is_dir() {
            let Some(manifest) = Manifest::read(path)? else {
                let result = path.join("result.json");
                return match result.is_file() {
                    true => self.follow(&result, data, seen),
                    false => Ok(()),
                };
            };
            self.wrote(&manifest.software);
            let list = path.join(MANIFEST);
            for file in &manifest.files {
                self.link(&list, &file.name, &file.sha256, &[path.join(&file.name)])?;
            }
            for file in &manifest.files {
                if file.name.ends_with(".json") {
                    self.follow(&path.join(&file.name), data, seen)?;
                }
            }
            return Ok(());
        }
        let inputs = match Provenance::of(path)? {
            Some(provenance) => {
                self.wrote(&provenance.software);
                let list = Provenance::place(path);
                let name = path.display().to_string();
                self.link(&list, &name, &provenance.sha256, &[path.to_path_buf()])?;
                provenance.inputs
            }
            None if path.extension().is_some_and(|e| e == "json") && path.is_file() => {
                let (bytes, _) = Source::open(path)?.into_bytes(LARGEST_DOCUMENT)?;
                if let Ok(result) = ResultDocument::from_json(&bytes) {
                    self.wrote(&result.software);
                    result.inputs
                } else if let Ok(calibration) = CalibrationFile::from_json(&bytes) {
                    self.wrote(&calibration.software);
                    calibration.inputs
                } else {
                    return Ok(());
                }
            }
            None => return Ok(()),
        };
        for input in &inputs {
            let places = places(&input.path, path, data);
            if let Some(found) = self.link(path, &input.path, &input.sha256, &places)? {
                self.follow(&found, data, seen)?;
                // A file of a folder of results: its neighbours belong to the chain.
                if let Some(folder) = found.parent()
                    && Manifest::read(folder).is_ok_and(|m| {
                        m.is_some_and(|m| m.files.iter().any(|f| f.sha256 == input.sha256))
                    })
                {
                    self.follow(folder, data, seen)?;
                }
            }
        }
        Ok(())
    }

    fn wrote(&mut self, software: &Software) {
        if !self.software.contains(software) {
            self.software.push(software.clone());
        }
    }

    /// Compares a file, wherever it is found: the first place with the right digest, else the first with any.
    fn link(
        &mut self,
        by: &Path,
        name: &str,
        sha256: &str,
        places: &[PathBuf],
    ) -> Result<Option<PathBuf>> {
        let mut other = None;
        let mut found = None;
        for place in places.iter().filter(|p| p.is_file()) {
            if Input::of(place)?.sha256 == sha256 {
                found = Some(place.clone());
                break;
            }
            other.get_or_insert_with(|| place.clone());
        }
        let fate = match (&found, &other) {
            (Some(_), _) => Fate::Unchanged,
            (None, Some(_)) => Fate::Changed,
            (None, None) => Fate::Missing,
        };
        let link = Link {
            named_by: by.to_path_buf(),
            name: name.to_owned(),
            found: found.clone().or(other),
            sha256: sha256.to_owned(),
            fate,
        };
        if !self.links.contains(&link) {
            self.links.push(link);
        }
        Ok(found)
    }
}

/// Where an input may stand: as it was named, from the folders above the file that names it, in the folder of data.
fn places(name: &str, by: &Path, data: Option<&Path>) -> Vec<PathBuf> {
    let given = Path::new(name);
    let file = given.file_name().map(PathBuf::from).unwrap_or_default();
    let mut places = Vec::new();
    for folder in data.into_iter() {
        if given.is_relative() {
            places.push(folder.join(given));
        }
        places.push(folder.join(&file));
    }
    places.push(given.to_path_buf());
    let here = by.canonicalize().unwrap_or_else(|_| by.to_path_buf());
    for folder in here.ancestors().skip(1).take(3) {
        places.push(folder.join(&file));
        if given.is_relative() {
            places.push(folder.join(given));
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OutputFolder;

    #[test]
    fn law_one_flipped_byte_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("recording.csv"), "t,a\n0,1\n1,2\n").unwrap();
        let inputs = [Input::of(&at("recording.csv")).unwrap()];
        let out = OutputFolder::create(at("result"), false).unwrap();
        let result = ResultDocument::new("noise").input(inputs[0].clone());
        out.write("result.json", result.to_json().unwrap()).unwrap();
        out.write("table.csv", "x\n1\n").unwrap();
        out.commit().unwrap();
        // A file that came from that result and another recording.
        std::fs::write(at("compensated.csv"), "a\n1\n").unwrap();
        let from = vec![
            Input::of(&at("result/result.json")).unwrap(),
            inputs[0].clone(),
        ];
        let own = Input::of(&at("compensated.csv")).unwrap().sha256;
        let provenance = Provenance::new(own, from).to_json().unwrap();
        std::fs::write(Provenance::place(&at("compensated.csv")), provenance).unwrap();

        let chain = Verification::of(at("compensated.csv"), None).unwrap();
        assert!(chain.is_whole(), "{chain:?}");
        let names: BTreeSet<String> = chain
            .links
            .iter()
            .filter_map(|l| l.found.as_ref()?.file_name()?.to_str().map(str::to_owned))
            .collect();
        for name in [
            "compensated.csv",
            "recording.csv",
            "result.json",
            "table.csv",
        ] {
            assert!(names.contains(name), "{name}: {names:?}");
        }
        for name in [
            "compensated.csv",
            "recording.csv",
            "result/result.json",
            "result/table.csv",
        ] {
            let mut bytes = std::fs::read(at(name)).unwrap();
            let good = bytes.clone();
            let middle = bytes.len() / 2;
            bytes[middle] ^= 1;
            std::fs::write(at(name), &bytes).unwrap();
            let chain = Verification::of(at("compensated.csv"), None).unwrap();
            let changed: Vec<_> = chain
                .links
                .iter()
                .filter(|l| l.fate == Fate::Changed)
                .map(|l| l.found.clone().unwrap().canonicalize().unwrap())
                .collect();
            // What lies behind a changed result is no longer part of the chain.
            assert!(
                changed.contains(&at(name).canonicalize().unwrap()) || name == "result/table.csv",
                "{name}: {chain:?}"
            );
            let of_result = Verification::of(at("result"), None).unwrap();
            assert_eq!(of_result.is_whole(), name == "compensated.csv", "{name}");
            std::fs::write(at(name), good).unwrap();
        }
        // Moved data are found where one says they are.
        std::fs::create_dir(at("archive")).unwrap();
        std::fs::rename(at("recording.csv"), at("archive/recording.csv")).unwrap();
        let lost = Verification::of(at("result"), None).unwrap();
        assert!(lost.links.iter().any(|l| l.fate == Fate::Missing));
        assert!(
            Verification::of(at("result"), Some(&at("archive")))
                .unwrap()
                .is_whole()
        );
        assert!(Verification::of(at("archive"), None).is_err());
    }
}
