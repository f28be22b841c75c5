//! The table that says which recording is of which device.

use crate::trouble::Result;
use proofmass_io::sheet::Sheet;
use proofmass_io::{Input, Source};
use std::collections::BTreeSet;

/// The device of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Device {
    /// Name of the recording, as the table has it.
    pub file: String,
    /// Serial number.
    pub(crate) serial: String,
    /// Batch that it was made in, where the table has batches; empty where nobody knows it.
    pub(crate) batch: Option<String>,
}

impl Device {
    /// Columns of a data set, and what stands in them.
    pub(super) fn words(&self) -> Vec<(String, String)> {
        let serial = ("serial".to_owned(), self.serial.clone());
        let batch = self.batch.clone().map(|batch| ("batch".to_owned(), batch));
        let file = ("recording".to_owned(), self.file.clone());
        [Some(serial), batch, Some(file)]
            .into_iter()
            .flatten()
            .collect()
    }
}

/// A table of devices that was read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DeviceTable {
    /// The table itself, with its digest.
    pub(crate) input: Input,
    /// Its rows.
    pub devices: Vec<Device>,
}

impl DeviceTable {
    /// Columns `file`, `serial` and, where it is known, `batch`.
    ///
    /// # Errors
    /// A missing column, a recording without a name or a serial number, one that stands twice, no row.
    pub fn read(source: Source) -> Result<Self> {
        let mut sheet = Sheet::from_source(source, "table of devices")?;
        let (file, serial, batch) = (
            sheet.text("file"),
            sheet.text("serial"),
            sheet.text("batch"),
        );
        sheet.finish()?;
        let file = sheet.required(file, "file")?;
        let serial = sheet.required(serial, "serial")?;
        let (mut devices, mut seen) = (Vec::new(), BTreeSet::new());
        for row in sheet.rows() {
            let text = |place| match row.text(place).trim() {
                word if word.chars().any(char::is_control) => Err(row
                    .refuse(
                        place,
                        "the field holds a line break or another control character",
                    )
                    .with_hint("a quotation mark may not be closed")),
                word => Ok(word.to_owned()),
            };
            let word = |place| match text(place)? {
                none if none.is_empty() => Err(row.refuse(place, "the field is empty")),
                word => Ok(word),
            };
            let device = Device {
                file: word(file)?,
                serial: word(serial)?,
                batch: batch.map(text).transpose()?,
            };
            if !seen.insert(device.file.clone()) {
                return Err(row.refuse(file, "the recording stands twice").into());
            }
            devices.push(device);
        }
        Ok(Self {
            input: sheet.input.clone(),
            devices,
        })
    }
}
