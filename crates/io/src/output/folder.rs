//! A folder of results in the making.

use super::manifest::{Listed, MANIFEST, Manifest, RESULT_SCHEMA, SIMULATION, digest, is_plain};
use super::place::{Lock, Place, exchange, move_file, remove_flat, sync};
use super::unfinished::{Unfinished, in_place, sweep};
use crate::signature::SigningKey;
use crate::{Error, ErrorKind, Input, Result, Schema};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Name under which complete files wait inside a folder until they are put in place.
const COMPLETE: &str = ".proofmass-complete";
/// In that folder: which old files go.
const REMOVED: &str = ".removed.json";

/// A folder of results in the making. Dropped without [`OutputFolder::commit`] it leaves no trace.
///
/// An existing folder keeps every file that proofmass did not write or that was changed since; what an earlier run
/// wrote, as its [`Manifest`] tells, is replaced by what this one writes. Where nothing is to be kept the two folders
/// change places at once; otherwise the files do one by one, and a run that is killed in between is completed by the
/// next.
#[derive(Debug)]
pub struct OutputFolder {
    given: PathBuf,
    overwrite: bool,
    // Before the place: folders that were made for it are removed once they are empty.
    unfinished: Unfinished,
    place: Place,
    swept: Vec<PathBuf>,
    protected: Vec<PathBuf>,
    signer: Option<SigningKey>,
    rendered_from: Option<Input>,
}

/// What stands at the place.
struct Standing {
    manifest: Option<Manifest>,
    /// Names of files that an earlier run wrote and nobody changed.
    own: BTreeSet<String>,
    /// Names that an earlier run wrote and somebody changed.
    edited: BTreeSet<String>,
    /// Everything else.
    foreign: BTreeSet<String>,
}

/// What is needed of result.json: kind and inputs.
#[derive(Deserialize)]
struct Head {
    schema: Schema,
    kind: String,
    #[serde(default)]
    inputs: Vec<Input>,
}

#[derive(Serialize, Deserialize)]
struct Removed {
    files: Vec<Listed>,
}

impl OutputFolder {
    /// Begins a folder that will stand at `path`.
    ///
    /// A folder that is not there or empty is taken; so is one with earlier results, whose unchanged files will be
    /// replaced. One without a manifest, with changed files or with results of another kind only with `overwrite`: files that
    /// the new result writes are then replaced, and everything else stays. One that holds a campaign never, unless it was
    /// simulated and not changed since.
    ///
    /// # Errors
    /// The place is taken, or the folder above it cannot be written.
    pub fn create(path: impl AsRef<Path>, overwrite: bool) -> Result<Self> {
        let given = path.as_ref().to_path_buf();
        let place = Place::of(&given, true)?;
        let mut swept = sweep(&place.parent, &place.name);
        if place.path.is_dir() {
            swept.extend(sweep(&place.path, &place.name));
            let _one_at_a_time = Lock::wait(&place.parent).ok();
            complete(&place.path)?;
        }
        if let Some(standing) = Standing::at(&place.path).map_err(|e| e.at(&given))? {
            standing.may_replace(&given, overwrite)?;
        }
        // Beside its place, or inside it where the folder above belongs to somebody else.
        let unfinished = match Unfinished::folder(&place.parent, &place.name) {
            Err(_) if place.path.is_dir() => Unfinished::folder(&place.path, &place.name)?,
            other => other?,
        };
        Ok(Self {
            given,
            place,
            overwrite,
            unfinished,
            swept,
            protected: Vec::new(),
            signer: None,
            rendered_from: None,
        })
    }

    /// Refuses a folder that holds results of another kind, before the work and not after it.
    ///
    /// # Errors
    /// It does, and `overwrite` was not asked for.
    pub fn expect_kind(&self, kind: &str) -> Result<()> {
        match Standing::at(&self.place.path)? {
            Some(standing) => self.check_kind(&standing, kind),
            None => Ok(()),
        }
    }

    /// Keeps files of the folder, whoever wrote them: the inputs of the result.
    pub fn protect<'a>(&mut self, inputs: impl IntoIterator<Item = &'a Path>) {
        let resolved = inputs.into_iter().filter_map(|i| i.canonicalize().ok());
        self.protected.extend(resolved);
    }

    /// Signs the list of files with a key.
    pub fn sign_with(&mut self, key: SigningKey) {
        self.signer = Some(key);
    }

    /// States the result.json that the files are rendered from, where no list names it.
    pub fn rendered_from(&mut self, unlisted: Input) {
        self.rendered_from = Some(unlisted);
    }

    /// Key that signed the results which these will replace, where these will not be signed by it.
    pub fn unsigns(&self) -> Option<String> {
        let old = Manifest::read(&self.place.path).ok()??.signature?.key;
        let new = self.signer.as_ref().map(|key| key.public().to_string());
        (new.as_ref() != Some(&old)).then_some(old)
    }

    /// What killed runs had left at this place and was removed.
    pub fn swept(&self) -> &[PathBuf] {
        &self.swept
    }

    /// Where a file of the result is to be written before the commit. `name` must stand directly in the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.unfinished.path().join(name)
    }

    /// Where the folder will stand.
    pub fn target(&self) -> &Path {
        &self.given
    }

    /// Writes one file.
    ///
    /// # Errors
    /// A name that is not that of a file in the folder, a disk that refuses.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> Result<()> {
        if !is_plain(name) {
            return Err(Error::new(
                ErrorKind::Output,
                format!("{name:?} is no name of a file in a folder of results"),
            )
            .at(&self.given));
        }
        fs::write(self.file(name), bytes)
            .map_err(|e| Error::access(&self.given.join(name), "write", e))
    }

    /// Puts the files in their place and returns where that is.
    ///
    /// # Errors
    /// A file would replace one of the inputs or one that proofmass did not write, the kind is another, the disk
    /// refuses: what stood there before is then still there.
    pub fn commit(mut self) -> Result<PathBuf> {
        let mut written = self.seal()?;
        let head = self.head()?;
        let kind = head.as_ref().map_or(SIMULATION, |h| h.kind.as_str());
        let inputs: Vec<PathBuf> = head
            .iter()
            .flat_map(|h| &h.inputs)
            .flat_map(Input::files)
            .map(|i| PathBuf::from(&i.path))
            .collect();
        self.protect(inputs.iter().map(PathBuf::as_path));
        written.sort_by(|a, b| a.name.cmp(&b.name));
        let mut manifest = Manifest::new(kind, written);
        manifest.rendered_from = self.rendered_from.take();
        if let Some(key) = &self.signer {
            manifest = manifest.signed(key);
        }
        let path = self.file(MANIFEST);
        fs::write(&path, manifest.to_json()?)
            .and_then(|()| sync(&path))
            .and_then(|()| sync(self.unfinished.path()))
            .map_err(|e| Error::access(&self.given, "write", e))?;

        let fail = |e| Error::access(&self.given, "put the results in place", e);
        let _one_at_a_time = Lock::wait(&self.place.parent).ok();
        let Some(standing) = Standing::at(&self.place.path)? else {
            let waiting = in_place();
            let renamed = fs::rename(self.unfinished.path(), &self.place.path);
            drop(waiting);
            renamed.map_err(fail)?;
            let _ = sync(&self.place.parent);
            return Ok(self.finished());
        };
        self.check_kind(&standing, kind)?;
        let removed = self.check_names(&standing, &manifest)?;
        if standing.foreign.is_empty()
            && standing.edited.is_empty()
            && removed.len() == standing.own.len()
            && self.may_exchange()
        {
            let waiting = in_place();
            if exchange(self.unfinished.path(), &self.place.path) {
                // The old results stand beside the new ones now; they are ours to the last file.
                let _ = sync(&self.place.parent);
                drop(waiting);
                let old = self.unfinished.path();
                remove_flat(old)
                    .map_err(|e| Error::access(old, "remove the replaced results", e))?;
                return Ok(self.finished());
            }
        }
        self.replace_one_by_one(&removed)?;
        Ok(self.finished())
    }

    fn finished(self) -> PathBuf {
        let Self {
            given,
            mut place,
            unfinished,
            ..
        } = self;
        place.keep();
        unfinished.release();
        given
    }

    /// Synchronises every file that was written, and lists them.
    fn seal(&self) -> Result<Vec<Listed>> {
        let folder = self.unfinished.path();
        let fail = |e| Error::access(&self.given, "write", e);
        let mut listed = Vec::new();
        for entry in fs::read_dir(folder).map_err(fail)? {
            let entry = entry.map_err(fail)?;
            let name = entry.file_name().to_string_lossy().into_owned();
            if !entry.file_type().map_err(fail)?.is_file() || !is_plain(&name) {
                return Err(Error::new(
                    ErrorKind::Output,
                    format!("{name:?} is no file of a result"),
                )
                .at(&self.given));
            }
            sync(&entry.path()).map_err(fail)?;
            let sha256 = digest(&entry.path())?;
            listed.push(Listed { name, sha256 });
        }
        Ok(listed)
    }

    fn head(&self) -> Result<Option<Head>> {
        let path = self.file("result.json");
        if !path.is_file() {
            return Ok(None);
        }
        let bytes = fs::read(&path).map_err(|e| Error::access(&path, "read", e))?;
        let head: Option<Head> = serde_json::from_slice(&bytes).ok();
        Ok(head.filter(|h| h.schema.name == RESULT_SCHEMA))
    }

    fn check_kind(&self, standing: &Standing, kind: &str) -> Result<()> {
        match &standing.manifest {
            Some(manifest) if manifest.kind != kind && !self.overwrite => Err(Error::new(
                ErrorKind::Output,
                format!(
                    "holds results of kind {}, which those of kind {kind} may not replace",
                    manifest.kind
                ),
            )
            .at(&self.given)
            .with_hint("name another folder, or replace them with --force")),
            _ => Ok(()),
        }
    }

    /// The old files that go; refuses a new file in the place of one that may not.
    fn check_names(&self, standing: &Standing, new: &Manifest) -> Result<Vec<Listed>> {
        let refuse = |name: &str, what: &str| {
            Err(
                Error::new(ErrorKind::Output, format!("holds {name:?}, {what}"))
                    .at(&self.given)
                    .with_hint("name another folder for the results"),
            )
        };
        let is_input = |name: &str| self.protected.contains(&self.place.path.join(name));
        for name in new.files.iter().map(|f| f.name.as_str()).chain([MANIFEST]) {
            if is_input(name) {
                return refuse(name, "an input of this result, which it may not replace");
            }
            let foreign = standing.foreign.contains(name) || standing.edited.contains(name);
            if foreign && !(self.overwrite && self.place.path.join(name).is_file()) {
                return refuse(
                    name,
                    "which proofmass did not write or which was changed since",
                );
            }
        }
        // Results of another kind are not replaced by these: only what has the same name is.
        let goes = |old: &Manifest, name: &str| {
            old.kind == new.kind || new.files.iter().any(|f| f.name == name)
        };
        let old = standing.manifest.iter();
        Ok(old
            .flat_map(|m| m.files.iter().filter(|f| goes(m, &f.name)))
            .filter(|f| standing.own.contains(&f.name) && !is_input(&f.name))
            .cloned()
            .collect())
    }

    /// Whether nobody would notice that the folder became another one.
    fn may_exchange(&self) -> bool {
        let inside = std::env::current_dir()
            .and_then(|d| d.canonicalize())
            .is_ok_and(|here| here.starts_with(&self.place.path));
        !inside && self.unfinished.path().parent() == Some(self.place.parent.as_path())
    }

    /// Moves the new files into the folder, then each into its place, then removes what they replace. From the
    /// rename of their folder on, a run that is killed is completed by the next.
    fn replace_one_by_one(&self, removed: &[Listed]) -> Result<()> {
        let folder = &self.place.path;
        let fail = |e| Error::access(&self.given, "put the results in place", e);
        let kept = Removed {
            files: removed.to_vec(),
        };
        let inside = Unfinished::folder(folder, &self.place.name)?;
        for entry in fs::read_dir(self.unfinished.path()).map_err(fail)? {
            let entry = entry.map_err(fail)?;
            if entry.path() != inside.path() {
                move_file(&entry.path(), &inside.path().join(entry.file_name())).map_err(fail)?;
            }
        }
        let list = inside.path().join(REMOVED);
        fs::write(&list, crate::finite::to_json(&kept)?)
            .and_then(|()| sync(&list))
            .and_then(|()| sync(inside.path()))
            .map_err(fail)?;
        let waiting = in_place();
        let renamed = fs::rename(inside.path(), folder.join(COMPLETE)).map_err(fail);
        let replaced = renamed.and_then(|()| {
            let _ = sync(folder);
            complete(folder)
        });
        drop(waiting);
        if replaced.is_ok() || folder.join(COMPLETE).exists() {
            inside.release();
        }
        replaced?;
        // Empty by now.
        let _ = fs::remove_dir(self.unfinished.path());
        Ok(())
    }
}

/// Puts files that wait complete inside a folder in their place; nothing where none do.
fn complete(folder: &Path) -> Result<()> {
    let waiting = folder.join(COMPLETE);
    if !waiting.is_dir() {
        return Ok(());
    }
    let fail = |e| {
        Error::access(&waiting, "put the results in place", e).with_hint(
            "the new results wait complete in that folder; run again once the cause is gone",
        )
    };
    let removed = match fs::read(waiting.join(REMOVED)) {
        Ok(bytes) => serde_json::from_slice(&bytes)
            .map_err(|e| Error::new(ErrorKind::Format, format!("is damaged: {e}")).at(&waiting))?,
        // It is the last to go.
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Removed { files: Vec::new() },
        Err(e) => return Err(fail(e)),
    };
    // It is the last to be moved.
    let new = match Manifest::read(&waiting)? {
        None => Manifest::read(folder)?,
        some => some,
    };
    let names: BTreeSet<&str> = new
        .iter()
        .flat_map(|m| &m.files)
        .map(|f| f.name.as_str())
        .collect();
    for name in &names {
        if waiting.join(name).is_file() {
            fs::rename(waiting.join(name), folder.join(name)).map_err(fail)?;
        }
    }
    for old in &removed.files {
        if !names.contains(old.name.as_str()) && old.is_unchanged(folder) {
            fs::remove_file(folder.join(&old.name)).map_err(fail)?;
        }
    }
    if waiting.join(MANIFEST).is_file() {
        fs::rename(waiting.join(MANIFEST), folder.join(MANIFEST)).map_err(fail)?;
    }
    let _ = sync(folder);
    remove_flat(&waiting).map_err(fail)?;
    let _ = sync(folder);
    Ok(())
}

impl Standing {
    /// Looks at a place; `None` where nothing or an empty folder stands.
    fn at(folder: &Path) -> Result<Option<Self>> {
        let meta = match fs::symlink_metadata(folder) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(Error::access(folder, "look at the place for results", e)),
            Ok(meta) => meta,
        };
        if !meta.is_dir() {
            return Err(
                Error::new(ErrorKind::Output, "is there already and is not a folder")
                    .at(folder)
                    .with_hint("name another folder for the results"),
            );
        }
        let mut names = fs::read_dir(folder)
            .and_then(|all| {
                all.map(|e| Ok(e?.file_name().to_string_lossy().into_owned()))
                    .collect::<std::io::Result<BTreeSet<String>>>()
            })
            .map_err(|e| Error::access(folder, "look at the place for results", e))?;
        // What this run is writing, where it has to write inside.
        names.retain(|n| !n.ends_with(".unfinished"));
        if names.is_empty() {
            // A folder that is there is kept, so that it may be a mount.
            return Ok(Some(Self {
                manifest: None,
                own: BTreeSet::new(),
                edited: BTreeSet::new(),
                foreign: BTreeSet::new(),
            }));
        }
        let manifest = Manifest::read(folder)?;
        let (mut own, mut edited) = (BTreeSet::new(), BTreeSet::new());
        for file in manifest.iter().flat_map(|m| &m.files) {
            if !names.remove(&file.name) {
                continue;
            }
            if file.is_unchanged(folder) {
                own.insert(file.name.clone());
            } else {
                edited.insert(file.name.clone());
            }
        }
        if manifest.is_some() {
            names.remove(MANIFEST);
        }
        Ok(Some(Self {
            manifest,
            own,
            edited,
            foreign: names,
        }))
    }

    fn may_replace(&self, given: &Path, overwrite: bool) -> Result<()> {
        let taken = |what: String, hint: &str| {
            Err(Error::new(ErrorKind::Output, what)
                .at(given)
                .with_hint(hint))
        };
        let foreign = |name: &str| self.foreign.contains(name) || self.edited.contains(name);
        if foreign("campaign.toml") {
            return taken(
                "holds a campaign, which results may not replace".into(),
                "name another folder, such as one inside it",
            );
        }
        if overwrite {
            return Ok(());
        }
        if let Some(name) = self.edited.first() {
            return taken(
                format!("holds {name:?}, which was changed since proofmass wrote it"),
                "move it away or rename it, name another folder, or replace it with --force",
            );
        }
        if self.manifest.is_none() && !self.foreign.is_empty() {
            return taken(
                "is not empty and holds no results of proofmass".into(),
                "name another folder, or add to what is there with --force: files of the same name are then replaced",
            );
        }
        Ok(())
    }
}
