//! A result is filed: what is taken from its folder, what it rests on, and what is to be doubted at that moment.

use crate::contribution::from_standards;
use crate::day::{date_of, day_of};
use crate::engine::Engine;
use crate::entry::{
    Content, FiledDevice, FiledFile, FiledQuantity, FiledResult, FiledSupersession, UsedStandard,
    sha256, spelling,
};
use crate::ledger::{Records, append, entry, keep, person};
use proofmass_io::{
    Device, Fate, LARGEST_DOCUMENT, MANIFEST, Manifest, Source, StatedQuantity, Verification,
};
use proofmass_jobs::findings::filing as findings;
use proofmass_jobs::{RESULT, Result, StoredResult, Trouble};
use proofmass_uncertainty::Finding;
use std::path::Path;

/// How a result is filed.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Filing {
    /// Device that it is of [default: the one that the result names]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DEVICE"))]
    pub device: Option<String>,
    /// The serial number is that of a new device, though another has it in another spelling
    #[cfg_attr(feature = "clap", arg(long))]
    pub new_device: bool,
    /// Standard behind it; may be repeated [default: those whose certificate or result is among its inputs]
    #[cfg_attr(feature = "clap", arg(long, value_name = "STANDARD"))]
    pub standard: Vec<String>,
    /// Number of its certificate
    #[cfg_attr(feature = "clap", arg(long, value_name = "NUMBER"))]
    pub number: Option<String>,
    /// Campaign that it belongs to, by its number here
    #[cfg_attr(feature = "clap", arg(long, value_name = "NUMBER"))]
    pub campaign: Option<i64>,
    /// Result that it takes the place of; needs --reason
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "NUMBER", requires = "reason")
    )]
    pub supersedes: Option<i64>,
    /// Why the other result no longer counts
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "TEXT", requires = "supersedes")
    )]
    pub reason: Option<String>,
    /// Inputs larger than this are kept by their digest alone, in megabytes
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "MB", default_value_t = 100.0)
    )]
    pub largest: f64,
    /// Folder in which inputs are looked for that are not where they were
    #[cfg_attr(feature = "clap", arg(long, value_name = "FOLDER"))]
    pub data: Option<std::path::PathBuf>,
    /// Who files it: the name stands apart and can be removed
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    pub by: Option<String>,
}

/// What became of a result.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Filed {
    /// Its number here.
    pub number: i64,
    /// Whether it was here already.
    pub known: bool,
    /// What is to be doubted.
    pub findings: Vec<Finding>,
}

/// A result in memory, ready to be filed.
#[derive(Clone, Debug, Default)]
pub struct Candidate {
    /// The device as the result names it.
    pub device: Device,
    /// Kind, as in result.json.
    pub kind: String,
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
}

impl Candidate {
    /// A result from its folder or its result.json. Files that were changed since are refused.
    ///
    /// # Errors
    /// No result, a changed file, a signature that does not hold, a result without a date.
    pub fn read(place: &Path, filing: &Filing, today: &str) -> Result<Self> {
        let path = match place.is_dir() {
            true => place.join(RESULT),
            false => place.to_path_buf(),
        };
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
        Ok(Self {
            device: record.device.clone(),
            kind: result.kind().to_owned(),
            title: record.title.clone(),
            date,
            sha256: sha256(&[&bytes]),
            source: record.software.to_string(),
            quantities: quantities(&result)?,
            files,
            inputs,
            signer,
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

impl Records {
    /// Files a result from its folder or its result.json; the same result twice is one.
    ///
    /// # Errors
    /// As [`Candidate::read`] and [`Records::file_candidate`].
    pub fn add_result(&mut self, place: &Path, filing: &Filing, today: &str) -> Result<Filed> {
        let candidate = Candidate::read(place, filing, today)?;
        self.file_candidate(&candidate, filing, today)
    }

    /// Files a result that was read.
    ///
    /// # Errors
    /// A device, standard or campaign that is not here; the database refuses.
    pub fn file_candidate(&mut self, c: &Candidate, filing: &Filing, today: &str) -> Result<Filed> {
        let device = filing
            .device
            .as_deref()
            .map(|called| self.device(called))
            .transpose()?;
        let standards = filing.standard.iter().map(|called| self.device(called));
        let standards = standards.collect::<Result<Vec<i64>>>()?;
        self.writing(|engine, beside| {
            let known = engine.rows("SELECT entry FROM result WHERE digest = ?1 ORDER BY entry DESC", &[(&c.sha256).into()])?;
            let known = known.first().and_then(|row| row[0].integer());
            if let Some(number) = known.filter(|n| Some(*n) != filing.supersedes) {
                return Ok(Filed {
                    number,
                    known: true,
                    findings: Vec::new(),
                });
            }
            let by = filing.by.as_deref().map(|name| person(engine, name)).transpose()?;
            let mut doubts = Vec::new();
            let device = match device {
                Some(device) => device,
                None => {
                    let (found, doubt) = device_of(engine, &c.device, filing.new_device)?;
                    doubts.extend(doubt);
                    match found {
                        Some(device) => device,
                        None => append(engine, &entry(today, by.clone(), Content::Device(new_device(&c.device))))?,
                    }
                }
            };
            let day = day_of(&c.date)?;
            let uses = uses(engine, c, &standards, day)?;
            for used in &uses {
                doubts.extend(doubts_of(engine, used, day)?);
            }
            if uses.is_empty() {
                doubts.push(findings::standard_not_named(&c.kind));
            }
            if let Some(number) = &filing.number {
                let others = engine.rows("SELECT entry FROM result WHERE number = ?1 AND entry NOT IN (SELECT old FROM supersession)", &[number.into()])?;
                let mut others = others.iter().filter_map(|row| row[0].integer());
                doubts.extend(
                    others
                        .find(|other| Some(*other) != filing.supersedes)
                        .map(|other| findings::number_taken(number, &other.to_string())),
                );
            }
            if let Some(due) = due_before(engine, device, day)? {
                doubts.push(findings::device_overdue(&name_of(engine, device)?, &date_of(due), &c.date));
            }
            let bare = c.quantities.iter().filter(|q| q.u.is_none() && q.expanded.is_none()).count();
            if bare > 0 {
                doubts.push(findings::uncertainty_not_stated(&c.source, bare as u64));
            }
            let files = c.files.iter().map(|(name, bytes)| keep(engine, beside, name, bytes));
            let files = files.collect::<Result<Vec<_>>>()?;
            let mut inputs = Vec::new();
            for (path, digest, bytes) in &c.inputs {
                inputs.push(match bytes {
                    Some(bytes) => keep(engine, beside, path, bytes)?,
                    None => FiledFile {
                        name: path.clone(),
                        sha256: digest.clone(),
                        kept: false,
                    },
                });
            }
            let result = FiledResult {
                device,
                result_kind: c.kind.clone(),
                title: c.title.clone(),
                date: c.date.clone(),
                number: filing.number.clone(),
                sha256: c.sha256.clone(),
                source: c.source.clone(),
                files,
                inputs,
                quantities: c.quantities.clone(),
                uses,
                campaign: filing.campaign,
                signer: c.signer.clone(),
            };
            doubts.extend(crate::tolerance::doubts(engine, device, &result)?);
            let number = append(engine, &entry(today, by.clone(), Content::Result(Box::new(result))))?;
            if let (Some(old), Some(reason)) = (filing.supersedes, &filing.reason) {
                let superseded = FiledSupersession {
                    old,
                    new: Some(number),
                    reason: reason.clone(),
                };
                append(engine, &entry(today, by, Content::Supersession(superseded)))?;
            }
            Ok(Filed {
                number,
                known: false,
                findings: doubts,
            })
        })
    }
}

/// The device that a result names, `None` where it is new; a serial number in another spelling is a doubt.
fn device_of(
    engine: &mut dyn Engine,
    device: &Device,
    new: bool,
) -> Result<(Option<i64>, Option<Finding>)> {
    let Some(serial) = device.serial.as_deref().filter(|s| !spelling(s).is_empty()) else {
        // Without a serial number the same words are the same device.
        let rows = engine.rows(
            "SELECT entry FROM device WHERE serial IS NULL AND COALESCE(manufacturer, '') = ?1 AND COALESCE(model, '') = ?2 ORDER BY entry LIMIT 1",
            &[device.manufacturer.as_deref().unwrap_or_default().into(), device.model.as_deref().unwrap_or_default().into()],
        )?;
        return Ok((rows.first().and_then(|row| row[0].integer()), None));
    };
    let rows = engine.rows(
        "SELECT entry, model, serial, manufacturer FROM device WHERE spelling = ?1 ORDER BY entry",
        &[(&spelling(serial)).into()],
    )?;
    let same = |a: Option<&str>, b: Option<&str>| {
        a.is_none() || b.is_none() || a.map(spelling) == b.map(spelling)
    };
    let alike: Vec<_> = rows
        .iter()
        .filter(|row| same(row[1].text(), device.model.as_deref()))
        .collect();
    if let Some(exact) = alike.iter().find(|row| row[2].text() == Some(serial)) {
        return Ok((exact[0].integer(), None));
    }
    let doubt = alike.first().filter(|_| !new).map(|row| {
        let number = row[0].integer().unwrap_or_default().to_string();
        findings::serial_spelled_otherwise(serial, &row[2].words(), &number)
    });
    Ok((None, doubt))
}

fn new_device(device: &Device) -> FiledDevice {
    FiledDevice {
        manufacturer: device.manufacturer.clone(),
        model: device.model.clone(),
        serial: device.serial.clone(),
        description: device.description.clone(),
        ..Default::default()
    }
}

/// Standards behind a result: those that are named, and those of whose certificates or results an input is the file.
fn uses(
    engine: &mut dyn Engine,
    c: &Candidate,
    named: &[i64],
    day: i64,
) -> Result<Vec<UsedStandard>> {
    let mut uses: Vec<UsedStandard> = Vec::new();
    let mut add = |used: UsedStandard| {
        if !uses.iter().any(|u| u.standard == used.standard) {
            uses.push(used);
        }
    };
    for (_, digest, _) in &c.inputs {
        let rows = engine.rows(
            "SELECT standard, entry FROM certificate WHERE digest = ?1 ORDER BY valid_from DESC LIMIT 1",
            &[digest.into()],
        )?;
        for row in rows {
            add(UsedStandard {
                standard: row[0].integer().unwrap_or_default(),
                certificate: row[1].integer(),
            });
        }
        // A result that was calibrated here and is the reference of this one.
        let rows = engine.rows(
            "SELECT result.device FROM output JOIN result ON result.entry = output.result
             JOIN device ON device.entry = result.device WHERE output.digest = ?1 AND device.standard = 1 LIMIT 1",
            &[digest.into()],
        )?;
        if let Some(standard) = rows.first().and_then(|row| row[0].integer()) {
            let certificate = certificate_on(engine, standard, day)?;
            add(UsedStandard {
                standard,
                certificate,
            });
        }
    }
    for standard in named {
        let certificate = certificate_on(engine, *standard, day)?;
        add(UsedStandard {
            standard: *standard,
            certificate,
        });
    }
    Ok(uses)
}

/// The certificate of a standard on a day: the last one that was valid from then or before.
fn certificate_on(engine: &mut dyn Engine, standard: i64, day: i64) -> Result<Option<i64>> {
    let rows = engine.rows(
        "SELECT entry FROM certificate WHERE standard = ?1 AND valid_from <= ?2 ORDER BY valid_from DESC, entry DESC LIMIT 1",
        &[standard.into(), day.into()],
    )?;
    Ok(rows.first().and_then(|row| row[0].integer()))
}

/// What is to be doubted about a standard on the day of its use.
fn doubts_of(engine: &mut dyn Engine, used: &UsedStandard, day: i64) -> Result<Vec<Finding>> {
    let mut doubts = Vec::new();
    let name = name_of(engine, used.standard)?;
    if let Some(certificate) = used.certificate {
        let rows = engine.rows(
            "SELECT number, valid_from, valid_until FROM certificate WHERE entry = ?1",
            &[certificate.into()],
        )?;
        if let Some(row) = rows.first() {
            let from = row[1].integer().unwrap_or(i64::MIN);
            let until = row[2].integer();
            if day < from || until.is_some_and(|until| day > until) {
                doubts.push(findings::certificate_not_valid(
                    &name,
                    &row[0].words(),
                    &date_of(from),
                    &until.map_or_else(|| "no stated end".to_owned(), date_of),
                    &date_of(day),
                ));
            }
        }
    }
    let rows = engine.rows(
        "SELECT day, en, good FROM checked WHERE device = ?1 AND day <= ?2 ORDER BY day DESC, entry DESC LIMIT 1",
        &[used.standard.into(), day.into()],
    )?;
    if let Some(row) = rows.first().filter(|row| row[2].integer() == Some(0)) {
        let checked = date_of(row[0].integer().unwrap_or_default());
        doubts.push(findings::standard_in_question(
            &name,
            &checked,
            row[1].real().unwrap_or_default(),
        ));
    }
    Ok(doubts)
}

/// The day on which a device was due, where that is before this day.
fn due_before(engine: &mut dyn Engine, device: i64, day: i64) -> Result<Option<i64>> {
    let rows = engine.rows(
        "SELECT day FROM due WHERE device = ?1 AND day < ?2",
        &[device.into(), day.into()],
    )?;
    Ok(rows.first().and_then(|row| row[0].integer()))
}

/// Maker, type and serial number of a device.
pub(crate) fn name_of(engine: &mut dyn Engine, device: i64) -> Result<String> {
    let rows = engine.rows(
        "SELECT manufacturer, model, serial, owner_number FROM device WHERE entry = ?1",
        &[device.into()],
    )?;
    Ok(rows
        .first()
        .map(|row| crate::device::line(row))
        .unwrap_or_default())
}
