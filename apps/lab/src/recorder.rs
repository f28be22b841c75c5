//! The folder of the campaign that is measured: an ordinary one at every moment.
//!
//! The recording of a run grows in a file beside its name and is renamed when it is whole; the table of runs has the
//! runs that are whole. What was cut short is kept under a name of its own, and `lab-log.csv` says why.

use crate::clock::utc;
use crate::files::{Refusal, disk, refuse, replace, sync_folder};
use crate::plan::{PLAN, Plan};
use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The list of all that was begun.
pub const LOG: &str = "lab-log.csv";
const LOCK: &str = "lab.lock";
/// How often a recording is flushed to the disk.
const FLUSH: Duration = Duration::from_secs(1);

struct Part {
    run: usize,
    path: PathBuf,
    file: BufWriter<File>,
    samples: u64,
    flushed: Instant,
}

/// Writes the folder.
pub struct Recorder {
    folder: PathBuf,
    plan: Plan,
    /// Places of the channels of the plan among those of the device.
    places: Vec<usize>,
    done: BTreeSet<usize>,
    part: Option<Part>,
    /// Held while the program runs.
    _lock: File,
}

impl Recorder {
    /// Begins the folder, or goes on where it was left.
    ///
    /// # Errors
    /// A folder of something else, one that another process records into, a device without the channels of the plan.
    pub fn open(folder: &Path, plan: Plan, device: &[String]) -> Result<Self, Refusal> {
        let mut places = Vec::new();
        for name in &plan.channels {
            let place = device.iter().position(|d| d == name).ok_or_else(|| {
                let hint = format!("name a channel of the device {name:?}");
                refuse(
                    plan.folder(),
                    format!(
                        "the device has no channel {name:?}; it has {}",
                        device.join(", ")
                    ),
                    hint,
                )
            })?;
            places.push(place);
        }
        let begun = folder.join(PLAN);
        let fresh = !begun.is_file();
        if fresh && fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some()) {
            return Err(refuse(
                folder,
                "the folder is not empty and was not begun by the live bench",
                "name a new folder",
            ));
        }
        fs::create_dir_all(folder).map_err(disk(folder))?;
        let lock = lock(folder)?;
        if fresh {
            for name in &plan.companions {
                let to = folder.join(name);
                if let Some(parent) = to.parent() {
                    fs::create_dir_all(parent).map_err(disk(parent))?;
                }
                fs::copy(plan.folder().join(name), &to).map_err(disk(&to))?;
            }
            replace(&folder.join("campaign.toml"), plan.text.as_bytes())?;
            replace(&begun, &plan.table)?;
        } else if fs::read(&begun).map_err(disk(&begun))? != plan.table {
            return Err(refuse(
                &begun,
                "the folder was begun with another plan",
                "name a new folder, or the plan it was begun with",
            ));
        }
        let mut recorder = Self {
            folder: folder.to_owned(),
            plan,
            places,
            done: BTreeSet::new(),
            part: None,
            _lock: lock,
        };
        recorder.find_done()?;
        recorder.keep_torn()?;
        recorder.write_runs()?;
        Ok(recorder)
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Whether a run is recorded.
    pub fn is_done(&self, run: usize) -> bool {
        self.done.contains(&run)
    }

    /// Number of runs that are recorded.
    pub fn done(&self) -> usize {
        self.done.len()
    }

    /// Runs whose row and recording are there.
    fn find_done(&mut self) -> Result<(), Refusal> {
        let place = self.folder.join(&self.plan.runs_file);
        if !place.is_file() {
            return Ok(());
        }
        let mut reader = csv::Reader::from_path(&place)
            .map_err(|e| refuse(&place, e.to_string(), "put it aside: the recordings stay"))?;
        let name = reader
            .headers()
            .ok()
            .and_then(|h| h.iter().position(|h| h == "run"));
        for record in reader.records().flatten() {
            let named = name.and_then(|n| record.get(n));
            let run = self
                .plan
                .runs
                .iter()
                .position(|r| Some(r.name.as_str()) == named);
            self.done
                .extend(run.filter(|&r| self.folder.join(&self.plan.runs[r].file).is_file()));
        }
        Ok(())
    }

    /// Recordings that a kill cut short are kept beside, and said.
    fn keep_torn(&mut self) -> Result<(), Refusal> {
        for run in 0..self.plan.runs.len() {
            let part = self.part_path(run);
            if part.is_file() {
                self.keep(run, &part, "killed", "the program ended while it recorded")?;
            }
            // A whole recording whose row was not written any more: measured again, never taken in silence.
            let whole = self.folder.join(&self.plan.runs[run].file);
            if !self.is_done(run) && whole.is_file() {
                self.keep(
                    run,
                    &whole,
                    "killed",
                    "the program ended before the run was in the table",
                )?;
            }
        }
        Ok(())
    }

    fn part_path(&self, run: usize) -> PathBuf {
        self.folder
            .join(format!(".{}.part", self.plan.runs[run].file))
    }

    /// Begins the recording of a run.
    ///
    /// # Errors
    /// A disk that refuses.
    pub fn begin(&mut self, run: usize) -> Result<(), Refusal> {
        let path = self.part_path(run);
        let file = File::create(&path).map_err(disk(&path))?;
        self.part = Some(Part {
            run,
            file: BufWriter::with_capacity(1 << 16, file),
            path,
            samples: 0,
            flushed: Instant::now(),
        });
        Ok(())
    }

    /// Adds samples, channel by channel of the device. They are on the disk a second later.
    ///
    /// # Errors
    /// A disk that refuses.
    pub fn samples(&mut self, channels: &[Vec<f64>]) -> Result<(), Refusal> {
        let Some(part) = &mut self.part else {
            return Ok(());
        };
        let chosen: Vec<&[f64]> = self
            .places
            .iter()
            .filter_map(|&p| channels.get(p))
            .map(Vec::as_slice)
            .collect();
        let bytes = proofmass::io::f32_bytes(&chosen).map_err(|e| {
            refuse(
                &part.path,
                e.to_string(),
                "the device gives what cannot be recorded",
            )
        })?;
        part.file.write_all(&bytes).map_err(disk(&part.path))?;
        part.samples += chosen.first().map_or(0, |c| c.len() as u64);
        if part.flushed.elapsed() >= FLUSH {
            part.flush().map_err(disk(&part.path))?;
        }
        Ok(())
    }

    /// The recording is whole: it gets its name and its row.
    ///
    /// # Errors
    /// A disk that refuses.
    pub fn finish(&mut self, level: f64) -> Result<(), Refusal> {
        let Some(mut part) = self.part.take() else {
            return Ok(());
        };
        let name = self.plan.runs[part.run].file.clone();
        let place = self.folder.join(&name);
        let mut put = || {
            part.flush()?;
            fs::rename(&part.path, &place)?;
            sync_folder(&place)
        };
        put().map_err(disk(&place))?;
        self.done.insert(part.run);
        self.write_runs()?;
        self.log(
            part.run,
            "done",
            &name,
            part.samples,
            &format!("{level:.5} m/s²"),
        )
    }

    /// The run ended before its last sample: what there is is kept and marked.
    ///
    /// # Errors
    /// A disk that refuses.
    pub fn mark(&mut self, run: usize, word: &str, why: &str) -> Result<(), Refusal> {
        match self.part.take() {
            Some(mut part) => {
                part.flush().map_err(disk(&part.path))?;
                self.keep(part.run, &part.path.clone(), word, why)
            }
            None => self.log(run, word, "", 0, why),
        }
    }

    fn keep(&self, run: usize, path: &Path, word: &str, why: &str) -> Result<(), Refusal> {
        let stem = Path::new(&self.plan.runs[run].file)
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let free = (1..)
            .map(|k| format!("{stem}.ended-{k}.f32"))
            .find(|n| !self.folder.join(n).exists());
        let name = free.unwrap_or_default();
        let width = 4 * self.places.len() as u64;
        let samples = fs::metadata(path).map_or(0, |m| m.len() / width);
        fs::rename(path, self.folder.join(&name)).map_err(disk(path))?;
        // A torn last row of samples is cut off.
        let file = OpenOptions::new().write(true).open(self.folder.join(&name));
        file.and_then(|f| f.set_len(samples * width))
            .map_err(disk(path))?;
        self.log(run, word, &name, samples, why)
    }

    fn write_runs(&self) -> Result<(), Refusal> {
        let place = self.folder.join(&self.plan.runs_file);
        let mut writer = csv::Writer::from_writer(Vec::new());
        let odd = |e: csv::Error| refuse(&place, e.to_string(), "");
        writer.write_record(&self.plan.header).map_err(odd)?;
        for &run in &self.done {
            writer.write_record(&self.plan.runs[run].row).map_err(odd)?;
        }
        let bytes = writer
            .into_inner()
            .map_err(|e| refuse(&place, e.to_string(), ""))?;
        replace(&place, &bytes)
    }

    fn log(
        &self,
        run: usize,
        word: &str,
        file: &str,
        samples: u64,
        why: &str,
    ) -> Result<(), Refusal> {
        let place = self.folder.join(LOG);
        let fresh = !place.exists();
        let mut writer = csv::Writer::from_writer(Vec::new());
        let odd = |e: csv::Error| refuse(&place, e.to_string(), "");
        if fresh {
            writer
                .write_record(["time", "run", "outcome", "file", "samples", "reason"])
                .map_err(odd)?;
        }
        let name = &self.plan.runs[run].name;
        writer
            .write_record([utc().as_str(), name, word, file, &samples.to_string(), why])
            .map_err(odd)?;
        let bytes = writer
            .into_inner()
            .map_err(|e| refuse(&place, e.to_string(), ""))?;
        let mut file = OpenOptions::new()
            .create(true)
            .append(true)
            .open(&place)
            .map_err(disk(&place))?;
        file.write_all(&bytes)
            .and_then(|()| file.sync_data())
            .map_err(disk(&place))
    }
}

impl Part {
    fn flush(&mut self) -> std::io::Result<()> {
        self.flushed = Instant::now();
        self.file.flush()?;
        self.file.get_ref().sync_data()
    }
}

/// One process records into a folder.
fn lock(folder: &Path) -> Result<File, Refusal> {
    let place = folder.join(LOCK);
    let file = File::create(&place).map_err(disk(&place))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(_) => Err(refuse(
            folder,
            "another live bench records into this folder",
            "look at its page, or end it first",
        )),
    }
}
