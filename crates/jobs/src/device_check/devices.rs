//! Which results are of which device.

use crate::certificate::says;
use crate::data_sheet::characteristic_of;
use crate::findings;
use crate::noise::read_noise;
use crate::trouble::{Result, Trouble};
use proofmass_documents::{Device, ResultDocument};
use proofmass_io::{Input, LARGEST_DOCUMENT, Source};
use proofmass_noise::Analysis;
use proofmass_uncertainty::Finding;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// A result.json, with the folder in which it was found.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct DeviceResult {
    /// The folder that was given.
    pub folder: String,
    /// The file.
    pub name: String,
    /// The file and its digest.
    pub input: Input,
    pub(super) document: ResultDocument,
    pub(super) analysis: Option<Analysis>,
}

impl DeviceResult {
    /// A result.json that was found in a folder.
    ///
    /// # Errors
    /// No result of this program, or a damaged one.
    pub fn read(folder: impl Into<String>, source: Source) -> Result<Self> {
        let name = source.name().display().to_string();
        let (bytes, input) = source.into_bytes(LARGEST_DOCUMENT)?;
        Self::from_json(folder, name.clone(), &bytes, input).map_err(|e| e.detail(name))
    }

    /// The same from its bytes.
    ///
    /// # Errors
    /// As [`DeviceResult::read`].
    pub fn from_json(
        folder: impl Into<String>,
        name: impl Into<String>,
        bytes: &[u8],
        input: Input,
    ) -> Result<Self> {
        let (analysis, document) = match ResultDocument::from_json(bytes)? {
            document if document.kind == "noise" => {
                let (analysis, document) = read_noise(bytes)?;
                (Some(analysis), document)
            }
            document => (None, document),
        };
        // What the estimate says is what the quantities say.
        document.stated()?;
        for q in &document.quantities {
            let interval = q.interval.map_or(0.0, |[a, b]| a + b);
            let all = [
                q.value,
                q.expanded,
                q.u.unwrap_or(0.0),
                interval,
                q.probability,
            ];
            let sound = all.iter().all(|v| v.is_finite())
                && q.expanded >= 0.0
                && q.u.is_none_or(|u| u >= 0.0)
                && q.probability > 0.0
                && q.probability < 1.0
                && q.interval.is_none_or(|[low, high]| low <= high);
            if !sound {
                return Err(Trouble::data(format!(
                    "the result states {} with numbers that no quantity has",
                    q.name
                ))
                .detail(format!("quantities: {}", q.name))
                .with_hint("the file was changed: evaluate the result again"));
            }
        }
        Ok(Self {
            folder: folder.into(),
            name: name.into(),
            input,
            document,
            analysis,
        })
    }

    /// Kind of the result.
    pub fn kind(&self) -> &str {
        &self.document.kind
    }

    /// The device that it states.
    pub fn device(&self) -> &Device {
        &self.document.device
    }

    /// How many of its quantities a sheet can ask for.
    pub(super) fn shown(&self) -> usize {
        match &self.analysis {
            Some(analysis) => analysis
                .channels
                .iter()
                .filter_map(|c| c.whittle.as_ref())
                .map(|w| w.coefficients.len())
                .sum(),
            None => {
                let names = self.document.quantities.iter().map(|q| &q.name);
                names
                    .filter(|name| characteristic_of(self.kind(), name).is_some())
                    .count()
            }
        }
    }

    fn serial(&self) -> Option<&str> {
        said(&self.document.device.serial)
    }

    /// Its folder and those above it, up to the one that was given.
    fn folders(&self) -> Vec<&str> {
        let mut all = Vec::new();
        let mut rest = self.name.as_str();
        while let Some((before, _)) = rest.rsplit_once(['/', '\\']) {
            if before.len() < self.folder.len() {
                break;
            }
            all.push(before);
            rest = before;
        }
        if !all.contains(&self.folder.as_str()) {
            all.push(&self.folder);
        }
        all
    }

    fn is_in(&self, folder: &str) -> bool {
        self.name == folder
            || self
                .name
                .strip_prefix(folder)
                .is_some_and(|rest| folder.is_empty() || rest.starts_with(['/', '\\']))
    }
}

/// What a field says, where it says something; the dots of a form do not.
fn said(text: &Option<String>) -> Option<&str> {
    text.as_deref().map(str::trim).filter(|t| says(t))
}

/// A device with its results, by their places.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct CheckedDevice {
    pub(crate) name: String,
    #[serde(skip)]
    pub(crate) results: Vec<usize>,
}

/// Tells the devices apart: by serial number, and a result without one belongs to the device whose other results share its folder.
///
/// # Errors
/// No result, one given twice, one of another device than the sheet is of, one that may be of several.
pub(super) fn devices(
    results: &[DeviceResult],
    sheet: &Device,
) -> Result<(Vec<CheckedDevice>, Vec<Finding>)> {
    if results.is_empty() {
        return Err(Trouble::data("there is no result to be judged")
            .with_hint("give folders that `proofmass calibrate`, `noise` or `test` wrote"));
    }
    distinct(results)?;
    for result in results {
        agrees(result, sheet)?;
    }
    let mut by_name: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    let mut assumed: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for (k, result) in results.iter().enumerate() {
        if !crate::data_sheet::is_of_a_device(result.kind()) {
            continue;
        }
        let name = match result.serial() {
            Some(serial) => serial.to_owned(),
            None => {
                let name = neighbour(result, results)?;
                if let Some(serial) = &name {
                    assumed
                        .entry(serial.clone())
                        .or_default()
                        .push(&result.name);
                }
                name.unwrap_or_else(|| said(&sheet.serial).unwrap_or(&result.folder).to_owned())
            }
        };
        by_name.entry(name).or_default().push(k);
    }
    if by_name.is_empty() {
        let kinds: BTreeSet<&str> = results.iter().map(DeviceResult::kind).collect();
        let kinds: Vec<&str> = kinds.into_iter().collect();
        return Err(
            Trouble::data("none of the results measures anything of a device")
                .detail(format!("kinds: {}", kinds.join(", ")))
                .with_hint("give folders that `proofmass calibrate`, `noise` or `test` wrote"),
        );
    }
    let notes = assumed.iter().map(|(serial, files)| {
        findings::device_from_folder(serial, files.len(), &files.join(", "))
    });
    let notes = notes.collect();
    let devices = by_name
        .into_iter()
        .map(|(name, results)| CheckedDevice { name, results });
    Ok((devices.collect(), notes))
}

/// The one serial number that is stated nearest to a result without one; none where its folder states none at all.
fn neighbour(result: &DeviceResult, all: &[DeviceResult]) -> Result<Option<String>> {
    for folder in result.folders() {
        let serials: BTreeSet<&str> = all
            .iter()
            .filter(|r| r.is_in(folder))
            .filter_map(DeviceResult::serial)
            .collect();
        let serials: Vec<&str> = serials.into_iter().collect();
        match serials[..] {
            [] => {}
            [one] => return Ok(Some(one.to_owned())),
            ref several => {
                return Err(Trouble::data(
                    "a result states no serial number, and its folder has results of several devices",
                )
                .detail(format!("{}; {folder}: {}", result.name, several.join(", ")))
                .with_hint(
                    "keep the results of a device in a folder of their own, or state its serial number where the result is computed",
                ));
            }
        }
    }
    Ok(None)
}

/// Refuses a result that is given twice: its quantity would be taken for two that agree.
fn distinct(results: &[DeviceResult]) -> Result<()> {
    for (k, later) in results.iter().enumerate() {
        let digest = &later.input.sha256;
        let first = results[..k].iter().find(|r| &r.input.sha256 == digest);
        if let Some(first) = first.filter(|_| !digest.is_empty()) {
            return Err(Trouble::request("the same result is given twice")
                .detail(format!("{} and {}", first.name, later.name))
                .with_hint(
                    "take the copy out of the folders: it would pass for a second measurement",
                ));
        }
    }
    Ok(())
}

/// Refuses a result of another device than the sheet is of.
fn agrees(result: &DeviceResult, sheet: &Device) -> Result<()> {
    let device = result.device();
    for (what, key, of_sheet, of_result) in [
        (
            "maker",
            "manufacturer",
            &sheet.manufacturer,
            &device.manufacturer,
        ),
        ("model", "model", &sheet.model, &device.model),
        ("serial number", "serial", &sheet.serial, &device.serial),
    ] {
        if let (Some(wanted), Some(found)) = (said(of_sheet), said(of_result))
            && !wanted.eq_ignore_ascii_case(found)
        {
            return Err(Trouble::data(format!(
                "a result is of another device: its {what} is {found}, that of the sheet {wanted}"
            ))
            .detail(format!("{}, device.{key}", result.name))
            .with_hint("take the result out of the folders, or name the sheet of that device"));
        }
    }
    Ok(())
}
