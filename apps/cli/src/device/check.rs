//! `proofmass device check`: results of devices against the limits of a data sheet.

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::number_arguments::false_alarm_rate;
use crate::{Failure, Outcome, clock, console};
use proofmass::io::{Input, Source};
use proofmass::jobs::data_sheet::{DataSheet, read_sheet};
use proofmass::jobs::device_check::{
    DeviceCheckData, DeviceCheckJob, DeviceCheckOutcome, DeviceResult,
};
use proofmass::jobs::{Job, Outcome as _, RESULT, Record, StoredResult};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Judge devices by their data sheet: pass, fail, undecided or not shown, limit by limit.
///
/// It reads every result.json in the folders and below them: what `proofmass calibrate`, `noise` and `test` wrote. Devices are told
/// apart by the serial number that their results state; a result without one belongs to the device whose results share its folder. The
/// rule of the decision stands in the sheet: a guard band of U where it says nothing.
#[derive(clap::Args)]
pub(crate) struct Check {
    /// Folders of results, of one device or of several
    #[arg(required = true, num_args = 1.., value_name = "FOLDER")]
    folders: Vec<PathBuf>,
    /// Data sheet (TOML), with a [[limit]] for each promise
    #[arg(long, value_name = "FILE", default_value = "device.toml")]
    sheet: PathBuf,
    /// Probability at which two results of one quantity that agree are said to contradict each other
    #[arg(long, value_name = "P", default_value_t = DeviceCheckJob::default().false_alarm_rate, value_parser = false_alarm_rate, allow_negative_numbers = true)]
    false_alarm_rate: f64,
    #[command(flatten)]
    delivery: Delivery,
}

impl Check {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let mut places: Vec<(String, PathBuf)> = Vec::new();
        let mut known = BTreeSet::new();
        for folder in &self.folders {
            let name = folder.display().to_string();
            let name = match name.trim_end_matches('/') {
                "" => name.clone(),
                trimmed => trimmed.to_owned(),
            };
            let found = results_in(folder)?;
            for place in found {
                // A folder inside another one is read once.
                let real = place.canonicalize().unwrap_or_else(|_| place.clone());
                if known.insert(real) {
                    places.push((name.clone(), place));
                }
            }
        }
        let mut inputs: Vec<&Path> = places.iter().map(|(_, place)| place.as_path()).collect();
        inputs.push(&self.sheet);
        let folder = self.delivery.begin(DeviceCheckOutcome::KIND, &inputs)?;
        let (sheet, input) = read_sheet_file(&self.sheet)?;
        let mut files = vec![input];
        let mut job = DeviceCheckJob::default();
        job.sheet = sheet;
        job.false_alarm_rate = self.false_alarm_rate;
        let results = places
            .iter()
            .map(|(folder, place)| DeviceResult::read(folder, Source::open(place)?))
            .collect::<Result<Vec<_>, _>>()?;
        let data = DeviceCheckData { results: &results };
        files.extend(results.iter().map(|r| r.input.clone()));
        let outcome = job.answer(&data, &files, &Progress::new())?;
        console::note(match results.len() {
            1 => "1 result read".to_owned(),
            n => format!("{n} results read"),
        });
        let record = Record {
            device: job.sheet.device.clone(),
            date: Some(clock::today()),
            inputs: files,
            ..Record::default()
        };
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }
}

/// The data sheet of a file.
pub(super) fn read_sheet_file(sheet: &Path) -> Result<(DataSheet, Input), Failure> {
    if !sheet.exists() {
        return Err(Failure::new(format!("there is no {}", sheet.display())).hint(
            "name the data sheet: --sheet FILE, with [[limit]] and in it characteristic, most and unit",
        ));
    }
    Ok(read_sheet(Source::open(sheet)?)?)
}

/// Every result.json of a folder and those below it, in the order of their names; hidden folders and links to folders are left out.
fn results_in(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    if folder.is_file() {
        return Ok(vec![folder.to_path_buf()]);
    }
    if !folder.exists() {
        return Err(proofmass::io::Error::new(
            proofmass::io::ErrorKind::NotFound,
            "there is no such folder",
        )
        .at(folder)
        .with_hint("name a folder of results")
        .into());
    }
    let mut found = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(here) = open.pop() {
        let unreadable = |e: std::io::Error| {
            Failure::new(format!("cannot read the folder {}: {e}", here.display()))
                .hint("name a folder of results")
        };
        for entry in std::fs::read_dir(&here).map_err(unreadable)? {
            let entry = entry.map_err(unreadable)?;
            let kind = entry.file_type().map_err(unreadable)?;
            // What another run has not finished stands in a hidden folder.
            let hidden = entry.file_name().to_string_lossy().starts_with('.');
            if kind.is_dir() && !hidden {
                open.push(entry.path());
            } else if entry.file_name() == RESULT {
                found.push(entry.path());
            }
        }
    }
    found.sort();
    match found.is_empty() {
        false => Ok(found),
        true => Err(
            Failure::new(format!("there is no result in {}", folder.display())).hint(
                "name a folder that `proofmass calibrate`, `proofmass noise` or `proofmass test` wrote with -o",
            ),
        ),
    }
}
