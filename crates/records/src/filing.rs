//! A result is filed: its device, what it rests on, and what is to be doubted at that moment.

use crate::candidate::Candidate;
use crate::day::{date_of, day_of};
use crate::engine::Engine;
use crate::entry::{
    Content, FiledDevice, FiledFile, FiledResult, FiledSupersession, UsedStandard, spelling,
};
use crate::ledger::{Records, append, entry, keep, person};
use crate::used;
use proofmass_documents::Device;
use proofmass_jobs::findings::filing as findings;
use proofmass_jobs::{Result, Trouble};
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
    /// Day of the measurement [default: that of the evaluation]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DATE"))]
    pub date: Option<String>,
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
        arg(long, value_name = "MB", default_value = "100", value_parser = megabytes)
    )]
    pub largest: f64,
    /// Folder in which inputs are looked for that are not where they were
    #[cfg_attr(feature = "clap", arg(long, value_name = "FOLDER"))]
    pub data: Option<std::path::PathBuf>,
    /// Who files it: the name stands apart and can be removed
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    pub by: Option<String>,
}

/// A size in megabytes.
#[cfg(feature = "clap")]
fn megabytes(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(size) if size >= 0.0 && size.is_finite() => Ok(size),
        _ => Err(format!("{text:?} is no size in megabytes, such as 100")),
    }
}

/// Kind of a result that is the certificate of another laboratory.
pub(crate) const OTHERS: &str = "certificate-of-others";
/// Kind of a certificate that was made of a result: it is a document, and no calibration of its own.
pub(crate) const CERTIFICATE: &str = "certificate";

/// What became of a result.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Filed {
    /// Its number here.
    pub number: i64,
    /// Whether it was here already.
    pub known: bool,
    /// The device that was filed with it, where it was new.
    pub new_device: Option<i64>,
    /// What is to be doubted.
    pub findings: Vec<Finding>,
}

impl Records {
    /// Files a result from its folder or its result.json; the same result twice is one.
    ///
    /// # Errors
    /// As [`Candidate::read`] and [`Records::file_candidate`].
    pub fn add_result(&mut self, place: &Path, filing: &Filing, today: &str) -> Result<Filed> {
        self.file_candidate(&Candidate::read(place, filing, today)?, filing, today)
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
        let number = filing.number.as_ref().or(c.number.as_ref());
        let date = filing.date.as_ref().unwrap_or(&c.date);
        self.writing(|engine, beside| {
            let known = engine.rows("SELECT entry FROM result WHERE digest = ?1 ORDER BY entry DESC", &[(&c.sha256).into()])?;
            let known = known.first().and_then(|row| row[0].integer());
            if let Some(number) = known.filter(|n| Some(*n) != filing.supersedes) {
                return Ok(Filed {
                    number,
                    known: true,
                    new_device: None,
                    findings: Vec::new(),
                });
            }
            let by = filing.by.as_deref().map(|name| person(engine, name)).transpose()?;
            let mut doubts = Vec::new();
            let mut new_device = None;
            let device = match device {
                Some(device) => device,
                None => {
                    let (found, doubt) = device_of(engine, &c.device, filing.new_device)?;
                    doubts.extend(doubt);
                    match found {
                        Some(device) => device,
                        None => {
                            let content = Content::Device(made(&c.device));
                            let number = append(engine, &entry(today, by.clone(), content))?;
                            new_device = Some(number);
                            number
                        }
                    }
                }
            };
            let day = day_of(date)?;
            let uses = used::of(engine, c, &standards, day)?;
            for used in &uses {
                doubts.extend(used::doubts(engine, used, day)?);
            }
            doubts.extend(used::superseded(engine, c)?);
            // The certificate of another laboratory has its standards there.
            if uses.is_empty() && ![CERTIFICATE, OTHERS].contains(&c.kind.as_str()) {
                doubts.push(findings::standard_not_named(&c.kind));
            }
            if used::is_withdrawn(engine, device, day)? {
                doubts.push(findings::device_withdrawn(&name_of(engine, device)?));
            }
            doubts.extend(told_otherwise(engine, device, c)?);
            if let Some(number) = number {
                let others = engine.rows("SELECT entry FROM result WHERE number = ?1 AND entry NOT IN (SELECT old FROM supersession)", &[number.into()])?;
                let mut others = others.iter().filter_map(|row| row[0].integer());
                doubts.extend(
                    others
                        .find(|other| Some(*other) != filing.supersedes)
                        .map(|other| findings::number_taken(number, &other.to_string())),
                );
            }
            if let Some(due) = due_before(engine, device, day)? {
                doubts.push(findings::device_overdue(&name_of(engine, device)?, &date_of(due), date));
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
                date: date.clone(),
                number: number.cloned(),
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
            doubts.extend(c.findings.iter().cloned());
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
                new_device,
                findings: doubts,
            })
        })
    }
}

impl Records {
    /// The results that a certificate stands behind, in their order.
    ///
    /// # Errors
    /// The database refuses.
    pub fn results_behind(&mut self, certificate: i64) -> Result<Vec<i64>> {
        let rows = self.engine.rows(
            "SELECT result FROM used WHERE certificate = ?1 ORDER BY result",
            &[certificate.into()],
        )?;
        Ok(rows.iter().filter_map(|row| row[0].integer()).collect())
    }

    /// What is to be doubted about a result as the records are now: its standards on that day, and limits that it does not keep.
    ///
    /// # Errors
    /// The database refuses.
    pub(crate) fn doubts_about(
        &mut self,
        filed: &FiledResult,
        number: i64,
    ) -> Result<Vec<Finding>> {
        let engine = &mut *self.engine;
        let day = day_of(&filed.date)?;
        let rows = engine.rows(
            "SELECT standard, certificate FROM used WHERE result = ?1 ORDER BY standard",
            &[number.into()],
        )?;
        let mut doubts = Vec::new();
        for row in rows {
            let used = UsedStandard {
                standard: row[0].integer().unwrap_or_default(),
                certificate: row[1].integer(),
            };
            doubts.extend(used::doubts(engine, &used, day)?);
        }
        doubts.extend(crate::tolerance::doubts(engine, filed.device, filed)?);
        Ok(doubts)
    }
}

/// What a result says otherwise than its device: the serial number, units of known quantities.
fn told_otherwise(engine: &mut dyn Engine, device: i64, c: &Candidate) -> Result<Vec<Finding>> {
    let mut doubts = Vec::new();
    let filed = engine.rows(
        "SELECT serial FROM device WHERE entry = ?1",
        &[device.into()],
    )?;
    let known = filed.first().map(|row| spelling(&row[0].words()));
    let named = c
        .device
        .serial
        .as_deref()
        .map(spelling)
        .filter(|s| !s.is_empty());
    if let (Some(known), Some(named)) = (known, named)
        && known != named
    {
        doubts.push(findings::device_named_otherwise(
            &name_of(engine, device)?,
            &c.device.line(),
        ));
    }
    let rows = engine.rows(
        "SELECT DISTINCT name, unit FROM quantity JOIN result ON result.entry = quantity.result
         WHERE device = ?1 AND result.entry NOT IN (SELECT old FROM supersession)",
        &[device.into()],
    )?;
    for q in &c.quantities {
        let mut known = rows
            .iter()
            .filter(|row| row[0].text() == Some(q.name.as_str()))
            .peekable();
        let other = known.peek().map(|row| row[1].words());
        if let Some(other) =
            other.filter(|_| known.all(|row| row[1].text() != Some(q.unit.as_str())))
        {
            let name = name_of(engine, device)?;
            doubts.push(findings::unit_otherwise(&name, &q.name, &q.unit, &other));
            break;
        }
    }
    Ok(doubts)
}

/// The device that a result names, `None` where it is new; a serial number in another spelling is a doubt.
fn device_of(
    engine: &mut dyn Engine,
    device: &Device,
    new: bool,
) -> Result<(Option<i64>, Option<Finding>)> {
    let serial = device.serial.as_deref();
    // Without letters and figures it is the blank of an example.
    let Some(serial) = serial.filter(|s| !spelling(s).is_empty()) else {
        return Err(Trouble::request("the result does not say which device it is of")
            .with_hint("name the device with --device, or evaluate with its serial number; `records add device` adds one"));
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
    let doubt = alike
        .first()
        .copied()
        .or(rows.first())
        .filter(|_| !new)
        .map(|row| {
            let number = row[0].integer().unwrap_or_default().to_string();
            findings::serial_spelled_otherwise(serial, &row[2].words(), &number)
        });
    Ok((None, doubt))
}

fn made(device: &Device) -> FiledDevice {
    FiledDevice {
        manufacturer: device.manufacturer.clone(),
        model: device.model.clone(),
        serial: device.serial.clone(),
        description: device.description.clone(),
        ..Default::default()
    }
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
