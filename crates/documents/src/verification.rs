//! Whether files are still those that a result was computed from and those that were written: the chain by digests.
//!
//! recording → campaign → result → calibration → compensated recording: every link names its predecessors with their
//! SHA-256, and a folder of results lists its files. One changed byte anywhere is found and named. A signature of the list
//! says who vouches for it: digests alone can be written anew by whoever changes a file.

use crate::{CalibrationFile, ResultDocument};
use proofmass_io::{
    Error, ErrorKind, FORGED, Input, LARGEST_DOCUMENT, MANIFEST, Manifest, Provenance, Result,
    Signature, Software, Source, VerifyingKey, listing,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

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
#[non_exhaustive]
pub struct Link {
    /// The file whose list names it.
    pub named_by: PathBuf,
    /// The file as it is named there.
    pub name: String,
    /// Where it was found: the file that was read.
    pub found: Option<PathBuf>,
    /// Where one lies that is unchanged, though the one that belongs to the result is not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub elsewhere: Option<PathBuf>,
    /// Digest that it should have.
    pub sha256: String,
    /// What became of it.
    pub fate: Fate,
}

/// Whether somebody vouches for a list of files.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Vouching {
    /// The manifest or provenance.
    pub(crate) list: PathBuf,
    /// Public key of the signer in hexadecimal digits; `None` without a signature.
    pub key: Option<String>,
    /// Whether the signature is that of this key over this list.
    pub holds: bool,
}

/// The whole chain.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Verification {
    /// Every link, from the newest file back.
    pub links: Vec<Link>,
    /// Programs that wrote the files.
    pub software: Vec<Software>,
    /// The lists that the links come from, and who signed them.
    #[serde(default)]
    pub lists: Vec<Vouching>,
    /// What stands in the folders of results and no list names.
    #[serde(default)]
    pub foreign: Vec<PathBuf>,
    /// Results and calibrations in the chain that no list names, and those from which files were rendered when none did.
    #[serde(default)]
    pub unlisted: Vec<PathBuf>,
}

impl Verification {
    /// Follows the chain from a folder of results, a result.json, a calibration.json or a compensated recording back as
    /// far as its files are found; `data` is a folder in which inputs are looked for first.
    ///
    /// An input that lies in `data`, or beside the result (in its folder or the one above), is the one that is judged, wherever
    /// else one of that name lies: a result that was copied with its recording is not vouched for by the original.
    ///
    /// # Errors
    /// Nothing there that names its inputs, a list that is damaged.
    pub fn of(path: impl AsRef<Path>, data: Option<&Path>) -> Result<Self> {
        let path = path.as_ref();
        path.metadata()
            .map_err(|e| Error::access(path, "read", e))?;
        let mut chain = Self::default();
        let mut seen = BTreeSet::new();
        chain.follow(path, data, &mut seen)?;
        chain.name_foreign();
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

    /// Why the signatures do not do: one that is not of what its list says now, or, where keys are given, a list that
    /// none of them signed.
    pub fn distrust(&self, keys: &[VerifyingKey]) -> Option<String> {
        if let Some(forged) = self.lists.iter().find(|l| l.key.is_some() && !l.holds) {
            return Some(format!("{}: {FORGED}", forged.list.display()));
        }
        if keys.is_empty() {
            return None;
        }
        let known = |key: &String| keys.iter().any(|k| k.to_string() == *key);
        let stranger = self
            .lists
            .iter()
            .find(|l| !l.key.as_ref().is_some_and(known));
        match stranger {
            Some(Vouching {
                list,
                key: Some(key),
                ..
            }) => Some(format!("{}: signed by another key, {key}", list.display())),
            Some(list) => Some(format!("{}: is not signed", list.list.display())),
            None if self.lists.is_empty() => {
                Some("no list of files was found that could be signed".to_owned())
            }
            None => None,
        }
    }

    fn vouching(&mut self, list: &Path, signature: Option<&Signature>, statement: &str) {
        if self.lists.iter().all(|l| l.list != list) {
            self.lists.push(Vouching {
                list: list.to_path_buf(),
                key: signature.map(|s| s.key.to_ascii_lowercase()),
                holds: signature.is_some_and(|s| s.signer(statement).is_some()),
            });
        }
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
            self.vouching(&list, manifest.signature.as_ref(), &manifest.statement());
            self.rendered(&manifest);
            for file in &manifest.files {
                self.link(
                    &list,
                    &file.name,
                    &file.sha256,
                    Places::one(path.join(&file.name)),
                )?;
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
                self.vouching(
                    &list,
                    provenance.signature.as_ref(),
                    &provenance.statement(),
                );
                let name = path.display().to_string();
                self.link(
                    &list,
                    &name,
                    &provenance.sha256,
                    Places::one(path.to_path_buf()),
                )?;
                provenance.inputs
            }
            None if path.extension().is_some_and(|e| e == "json") && path.is_file() => {
                self.in_its_folder(path)?;
                let (bytes, _) = Source::open(path)?.into_bytes(LARGEST_DOCUMENT)?;
                let (software, inputs) = if let Ok(result) = ResultDocument::from_json(&bytes) {
                    (result.software, result.inputs)
                } else if let Ok(calibration) = CalibrationFile::from_json(&bytes) {
                    (calibration.software, calibration.inputs)
                } else {
                    return Ok(());
                };
                self.wrote(&software);
                if listing(path).is_none() {
                    self.unlisted(path);
                }
                inputs
            }
            None => return Ok(()),
        };
        let inputs: Vec<&Input> = inputs.iter().flat_map(Input::files).collect();
        for input in &inputs {
            let places = Places::of(input, &inputs, path, data);
            if let Some(found) = self.link(path, &input.path, &input.sha256, places)? {
                self.follow(&found, data, seen)?;
                // A file of a folder of results: its neighbours belong to the chain.
                if let Some(folder) = found.parent()
                    && Manifest::read(folder).is_ok_and(|m| {
                        m.is_some_and(|m| {
                            m.vouches() && m.files.iter().any(|f| f.sha256 == input.sha256)
                        })
                    })
                {
                    self.follow(folder, data, seen)?;
                }
            }
        }
        Ok(())
    }

    /// Where the folder of a file lists it: the file as it is listed, and who vouches for the list.
    fn in_its_folder(&mut self, path: &Path) -> Result<()> {
        let (Some(folder), Some(name)) = (path.parent(), path.file_name().and_then(|n| n.to_str()))
        else {
            return Ok(());
        };
        let Some(manifest) = Manifest::read(folder)? else {
            return Ok(());
        };
        if !manifest.vouches() {
            return Ok(());
        }
        if let Some(file) = manifest.files.iter().find(|f| f.name == name) {
            let list = folder.join(MANIFEST);
            self.wrote(&manifest.software);
            self.vouching(&list, manifest.signature.as_ref(), &manifest.statement());
            self.rendered(&manifest);
            self.link(&list, name, &file.sha256, Places::one(path.to_path_buf()))?;
        }
        Ok(())
    }

    /// What the files of a list were rendered from, where no list named it.
    fn rendered(&mut self, manifest: &Manifest) {
        if let Some(source) = &manifest.rendered_from {
            self.unlisted(Path::new(&source.path));
        }
    }

    fn unlisted(&mut self, path: &Path) {
        if !self.unlisted.iter().any(|p| p == path) {
            self.unlisted.push(path.to_path_buf());
        }
    }

    fn wrote(&mut self, software: &Software) {
        if !self.software.contains(software) {
            self.software.push(software.clone());
        }
    }

    /// Compares a file: the first that lies where it belongs, else one that lies elsewhere, an unchanged one before others.
    fn link(
        &mut self,
        by: &Path,
        name: &str,
        sha256: &str,
        places: Places,
    ) -> Result<Option<PathBuf>> {
        let mut own = None;
        let mut elsewhere = Vec::new();
        for (place, belongs) in places.all() {
            if place.is_file() {
                let same = Input::of(&place)?.sha256 == sha256;
                if belongs && own.is_none() {
                    own = Some((place, same));
                } else {
                    elsewhere.push((place, same));
                }
                if same {
                    break;
                }
            }
        }
        let unchanged = elsewhere.iter().find(|(_, same)| *same).cloned();
        let (found, fate) = match own.or(unchanged.clone()).or(elsewhere.into_iter().next()) {
            Some((place, true)) => (Some(place), Fate::Unchanged),
            Some((place, false)) => (Some(place), Fate::Changed),
            None => (None, Fate::Missing),
        };
        let link = Link {
            named_by: by.to_path_buf(),
            name: name.to_owned(),
            elsewhere: unchanged.map(|u| u.0).filter(|_| fate == Fate::Changed),
            found: found.clone(),
            sha256: sha256.to_owned(),
            fate,
        };
        if !self.links.contains(&link) {
            self.links.push(link);
        }
        Ok(found.filter(|_| fate == Fate::Unchanged))
    }

    /// Names what stands in folders of results and belongs to no list.
    fn name_foreign(&mut self) {
        let real = |p: &Path| p.canonicalize().unwrap_or_else(|_| p.to_path_buf());
        let mut known: BTreeSet<PathBuf> = BTreeSet::new();
        for place in self.links.iter().filter_map(|l| l.found.as_ref()) {
            known.insert(real(&Provenance::place(place)));
            known.insert(real(place));
        }
        known.extend(self.lists.iter().map(|l| real(&l.list)));
        let mut foreign = BTreeSet::new();
        for list in &self.lists {
            if let Some(folder) = list.list.parent()
                && list.list.file_name().is_some_and(|n| n == MANIFEST)
            {
                let found = std::fs::read_dir(folder).into_iter().flatten().flatten();
                foreign.extend(
                    found
                        .map(|e| e.path())
                        .filter(|p| !known.contains(&real(p))),
                );
            }
        }
        self.foreign = foreign.into_iter().collect();
    }
}

/// Where an input may lie.
struct Places {
    /// Where it belongs: the first that is there is it.
    own: Vec<PathBuf>,
    /// Where it was once, and where it might have come to lie.
    other: Vec<PathBuf>,
}

impl Places {
    fn one(place: PathBuf) -> Self {
        Self {
            own: vec![place],
            other: Vec::new(),
        }
    }

    /// Of one of the inputs that a file names: in the folder of data, in the folder of the file or the one above; there by as much of its
    /// path as there is, since folders of the same names may hold other recordings. Elsewhere: as it was named, further above.
    fn of(input: &Input, inputs: &[&Input], by: &Path, data: Option<&Path>) -> Self {
        let given = Path::new(&input.path);
        // An end of a path that another input has too does not tell which of them it is.
        let (told, shared): (Vec<PathBuf>, Vec<PathBuf>) =
            ends(given).into_iter().partition(|end| {
                inputs
                    .iter()
                    .all(|i| i.path == input.path || !Path::new(&i.path).ends_with(end))
            });
        let here = by.canonicalize().unwrap_or_else(|_| by.to_path_buf());
        let above: Vec<&Path> = here.ancestors().skip(1).take(3).collect();
        let beside = &above[..above.len().min(2)];
        let in_folders = |folders: &[&Path], ends: &[PathBuf]| -> Vec<PathBuf> {
            let each = ends
                .iter()
                .flat_map(|end| folders.iter().map(move |f| f.join(end)));
            each.collect()
        };
        let data: Vec<&Path> = data.into_iter().collect();
        let mut own = in_folders(&data, &told);
        own.extend(in_folders(beside, &told));
        // A file is no input of itself, nor of what was written with it.
        let with: Vec<PathBuf> = above
            .first()
            .and_then(|folder| Some((folder, Manifest::read(folder).ok()??)))
            .map(|(folder, list)| list.files.iter().map(|f| folder.join(&f.name)).collect())
            .unwrap_or_default();
        let with = if with.contains(&here) {
            with
        } else {
            vec![here.clone()]
        };
        own.retain(|p| !with.contains(p));
        let mut other = in_folders(&data, &shared);
        other.push(given.to_path_buf());
        other.extend(in_folders(beside, &shared));
        other.extend(in_folders(&above, &told));
        other.retain(|p| !with.contains(p));
        Self { own, other }
    }

    /// Every place, and whether it belongs there.
    fn all(self) -> impl Iterator<Item = (PathBuf, bool)> {
        let own = self.own.into_iter().map(|p| (p, true));
        own.chain(self.other.into_iter().map(|p| (p, false)))
    }
}

/// The ends of a path, the longest first, without its root and dots.
fn ends(path: &Path) -> Vec<PathBuf> {
    let parts: Vec<_> = path
        .components()
        .filter(|c| matches!(c, Component::Normal(_)))
        .collect();
    (0..parts.len())
        .map(|k| parts[k..].iter().collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_io::{OutputFolder, SigningKey};

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

    #[test]
    fn law_digests_written_anew_do_not_pass_a_signature() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let (mine, other) = (
            SigningKey::generate().unwrap(),
            SigningKey::generate().unwrap(),
        );
        let write = |key: Option<&SigningKey>| {
            let mut out = OutputFolder::create(at("result"), false).unwrap();
            let result = ResultDocument::new("noise").to_json().unwrap();
            out.write("result.json", result).unwrap();
            if let Some(key) = key {
                out.sign_with(key.clone());
            }
            out.commit().unwrap();
        };
        let distrust = |keys: &[VerifyingKey]| {
            let chain = Verification::of(at("result"), None).unwrap();
            assert!(chain.is_whole());
            chain.distrust(keys)
        };
        write(None);
        assert_eq!(distrust(&[]), None);
        assert!(
            distrust(&[mine.public()])
                .unwrap()
                .contains("is not signed")
        );
        write(Some(&mine));
        assert_eq!(distrust(&[]), None);
        assert_eq!(distrust(&[other.public(), mine.public()]), None);
        assert!(distrust(&[other.public()]).unwrap().contains("another key"));
        // One file of the folder is vouched for by the list of its folder.
        let chain = Verification::of(at("result/result.json"), None).unwrap();
        assert_eq!(chain.distrust(&[mine.public()]), None);
        // A file is changed and its digest with it: the chain is whole, the signature is not.
        let manifest = std::fs::read_to_string(at("result/manifest.json")).unwrap();
        let old = Input::of(&at("result/result.json")).unwrap().sha256;
        let result = std::fs::read_to_string(at("result/result.json")).unwrap();
        std::fs::write(at("result/result.json"), result.replace("noise", "Noise")).unwrap();
        let new = Input::of(&at("result/result.json")).unwrap().sha256;
        std::fs::write(at("result/manifest.json"), manifest.replace(&old, &new)).unwrap();
        assert!(distrust(&[]).unwrap().contains("not of what stands there"));
        assert!(distrust(&[mine.public()]).is_some());
        // The same statement in another layout of the JSON is the same.
        std::fs::write(at("result/result.json"), &result).unwrap();
        let spaced = manifest.replace(": ", " :  ");
        std::fs::write(at("result/manifest.json"), spaced).unwrap();
        assert_eq!(distrust(&[mine.public()]), None);
    }
}
