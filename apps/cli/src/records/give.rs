//! `proofmass records export` and `backup`: the records as files.

use crate::{Failure, console};
use proofmass::io::{AtomicFile, OutputFolder};
use proofmass::records::{Records as Ledger, page};
use std::path::{Path, PathBuf};

/// Write the records as pages, tables, JSON, or a folder from which they are made again
#[derive(clap::Args)]
#[group(id = "export")]
#[command(group = clap::ArgGroup::new("form").required(true))]
pub(super) struct Export {
    /// Folder, or file with --json
    #[arg(short, long, value_name = "PLACE")]
    output: PathBuf,
    /// Pages: list, due, one for each device and standard
    #[arg(long, group = "form")]
    html: bool,
    /// Tables: devices, certificates, results, quantities, checks, events
    #[arg(long, group = "form")]
    csv: bool,
    /// The same tables as Parquet
    #[arg(long, group = "form")]
    parquet: bool,
    /// Every entry in one file
    #[arg(long, group = "form")]
    json: bool,
    /// Everything with every kept file: `records import` makes the same records from it
    #[arg(long, group = "form")]
    folder: bool,
    /// Write into a folder that holds other files
    #[arg(long)]
    force: bool,
}

/// Copy the records into a new file while they are in use
#[derive(clap::Args)]
pub(super) struct Backup {
    /// New file; larger files go into the folder FILE.files
    file: PathBuf,
    /// Copy records that are damaged, as they are
    #[arg(long)]
    damaged: bool,
}

impl Export {
    pub(super) fn run(self, records: &mut Ledger, place: &str, today: &str) -> Result<(), Failure> {
        if self.json {
            return write_file(&self.output, &records.export_json()?, place, self.force);
        }
        let out = OutputFolder::create(&self.output, self.force)?;
        if self.html {
            page::write(records, &out, today)?;
        } else if self.csv {
            records.export_csv(&out)?;
        } else if self.parquet {
            records.export_parquet(&out)?;
        } else {
            records.export_folder(&out)?;
        }
        let place = out.commit()?;
        console::note(format!("written: {}", place.display()));
        Ok(())
    }
}

impl Backup {
    pub(super) fn run(self, records: &mut Ledger) -> Result<(), Failure> {
        match self.damaged {
            true => records.copy_as_it_is(&self.file)?,
            false => records.backup(&self.file)?,
        }
        console::note(format!("written: {}", self.file.display()));
        Ok(())
    }
}

/// How a page begins.
pub(super) const PAGE: &[u8] = b"<!DOCTYPE html>";

/// Writes one file, whole or not at all; never over the records, and over another file only where that was said.
pub(super) fn write_file(
    place: &Path,
    bytes: &[u8],
    records: &str,
    force: bool,
) -> Result<(), Failure> {
    let own: Vec<PathBuf> = ["", "-wal", "-shm"]
        .iter()
        .map(|end| PathBuf::from(format!("{records}{end}")))
        .collect();
    let kept: Vec<&Path> = own.iter().map(PathBuf::as_path).collect();
    let mut file = AtomicFile::create(place, &kept)?;
    console::keep(place, force)?;
    file.write_all(bytes)?;
    file.commit()?;
    console::note(format!("written: {}", place.display()));
    Ok(())
}
