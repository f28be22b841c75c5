//! A result in memory as it is filed, read from its folder.

use crate::contribution::from_standards;
use crate::day::day_of;
use crate::entry::{FiledQuantity, sha256};
use crate::filing::{CERTIFICATE, Filing};
use proofmass_documents::{Device, Fate, StatedQuantity, Verification};
use proofmass_io::{LARGEST_DOCUMENT, MANIFEST, Manifest, Source};
use proofmass_jobs::{RESULT, Result, StoredResult, Trouble};
use proofmass_uncertainty::Finding;
use std::path::Path;

/// A result in memory, ready to be filed.
#[derive(Clone, Debug, Default)]
pub struct Candidate {
    /// The device as the result names it.
    pub device: Device,
    /// Kind, as in result.json.
    pub kind: String,
    /// Number of its certificate, where it is one.
    pub number: Option<String>,
    /// Title.
    pub title: Option<String>,
    /// Day of the evaluation, ISO 8601.
    pub date: String,
    /// SHA-256 of what it is told by.
    pub sha256: String,
    /// What wrote it.
    pub source: String,
    /// The quantities.
    pub quantities: Vec<FiledQuantity>,
    /// Name and bytes of its files.
    pub files: Vec<(String, Vec<u8>)>,
    /// Path and digest of its inputs, and their bytes where they are kept.
    pub inputs: Vec<(String, String, Option<Vec<u8>>)>,
    /// Who signed its list of files.
    pub signer: Option<String>,
    /// What was to be doubted when it was read.
    pub findings: Vec<Finding>,
}

impl Candidate {
    /// A result from its folder or its result.json. Files that were changed since are refused.
    ///
    /// # Errors
    /// No result, a changed file, a signature that does not hold, a result without a date.
    pub fn read(place: &Path, filing: &Filing, today: &str) -> Result<Self> {
        let path = StoredResult::place(place);
        let (bytes, input) = Source::open(&path)?.into_bytes(LARGEST_DOCUMENT)?;
        if let Some(doubt) = &input.doubt {
            return Err(Trouble::data(doubt.clone())
                .with_hint("file the result as it was computed: fetch its folder from there, or evaluate it again"));
        }
        let result =
            StoredResult::from_json(&bytes).map_err(|t| t.detail(path.display().to_string()))?;
        let folder = path.parent().unwrap_or_else(|| Path::new("."));
        let manifest = Manifest::read(folder)?;
        let listed = manifest
            .as_ref()
            .is_some_and(|m| m.files.iter().any(|f| f.name == RESULT));
        // A folder is judged as a whole.
        let whole = listed && path.ends_with(RESULT);
        let mut files = vec![(RESULT.to_owned(), bytes.clone())];
        let mut signer = None;
        if let (true, Some(manifest)) = (whole, &manifest) {
            for file in manifest.files.iter().filter(|f| f.name != RESULT) {
                files.push((file.name.clone(), bytes_of(&folder.join(&file.name))?));
            }
            files.push((MANIFEST.to_owned(), bytes_of(&folder.join(MANIFEST))?));
            signer = manifest.signature.as_ref().map(|s| s.key.clone());
        }
        let chain = Verification::of(if whole { folder } else { &path }, filing.data.as_deref())?;
        let list = folder.join(MANIFEST);
        let changed = chain
            .links
            .iter()
            .find(|l| whole && l.fate == Fate::Changed && l.named_by == list);
        if let Some(changed) = changed {
            return Err(Trouble::data(format!(
                "{} was changed since it was written: {} lists another",
                folder.join(&changed.name).display(),
                list.display()
            ))
            .with_hint("file the result as it was computed: fetch its folder from there, or evaluate it again"));
        }
        if let Some(why) = chain.distrust(&[]) {
            return Err(Trouble::data(why).with_hint("ask whoever made the result"));
        }
        let record = result.record();
        let mut inputs = Vec::new();
        for file in record.inputs.iter().flat_map(proofmass_io::Input::files) {
            // The chain says where an unchanged one lies.
            let link = chain
                .links
                .iter()
                .find(|l| l.sha256 == file.sha256 && l.fate == Fate::Unchanged);
            let found = link.and_then(|l| l.found.as_deref());
            let kept = match found.and_then(|p| Some((p, std::fs::metadata(p).ok()?.len()))) {
                Some((place, size)) if size as f64 <= 1e6 * filing.largest => {
                    Some(bytes_of(place)?)
                }
                _ => None,
            };
            let kept = kept.filter(|bytes| sha256(&[bytes]) == file.sha256);
            inputs.push((file.path.clone(), file.sha256.clone(), kept));
        }
        let date = record.date.clone().unwrap_or_else(|| today.to_owned());
        day_of(&date)?;
        // A certificate is the document of a result, whose quantities are filed with that.
        let is_certificate = result.kind() == CERTIFICATE;
        let section = result.section(CERTIFICATE).filter(|_| is_certificate);
        let number = section
            .and_then(|s| s["number"].as_str())
            .map(str::to_owned);
        if is_certificate && number.is_none() {
            return Err(Trouble::request("a draft is no certificate")
                .with_hint("`proofmass certificate release` gives it its number; file the result itself until then"));
        }
        Ok(Self {
            device: record.device.clone(),
            kind: result.kind().to_owned(),
            title: record.title.clone(),
            date,
            sha256: sha256(&[&bytes]),
            source: record.software.to_string(),
            quantities: match is_certificate {
                true => Vec::new(),
                false => quantities(&result)?,
            },
            number,
            files,
            inputs,
            signer,
            findings: Vec::new(),
        })
    }
}

/// Bytes of a file.
pub(crate) fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|e| Trouble::data(format!("{}: {e}", path.display())))
}

/// The quantities of a result as they are filed, with what the standard behind it has to do with each.
pub(crate) fn quantities(result: &StoredResult) -> Result<Vec<FiledQuantity>> {
    let shares = from_standards(result)?;
    let filed = |q: &StatedQuantity| FiledQuantity {
        name: q.name.clone(),
        unit: q.unit.clone(),
        value: q.value,
        u: q.u,
        expanded: Some(q.expanded),
        k: q.k,
        nu: q.nu_eff.filter(|nu| !nu.is_infinite()).map(|nu| nu.get()),
        probability: Some(q.probability),
        u_standard: shares.get(&q.name).copied(),
    };
    Ok(result.quantities().iter().map(filed).collect())
}
