//! Whether the records are what was filed: chain, index, files, signatures; and a result computed again.

use crate::candidate::quantities;
use crate::engine::{Engine, Row, Value};
use crate::entry::{Content, FiledQuantity, FiledResult, link, sha256};
use crate::ledger::{Records, append_body, parse};
use crate::schema::DERIVED;
use crate::{files, history};
use proofmass_io::{LARGEST_DOCUMENT, MANIFEST, Manifest, Software, Source};
use proofmass_jobs::campaign::Campaign;
use proofmass_jobs::{Memory, RESULT, Result, StoredResult, Trouble, Unwatched};
use proofmass_uncertainty::En;
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;

/// What a check found.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Check {
    /// Entries in the chain.
    pub entries: u64,
    /// Files that were read.
    pub files: u64,
    /// Lists of files whose signature holds.
    pub signatures: u64,
    /// Digest of the last entry: who keeps it can tell later that no entry at the end was taken away.
    pub head: String,
    /// What is damaged, or was changed.
    pub damage: Vec<String>,
}

impl Check {
    /// Whether nothing is damaged.
    pub fn is_whole(&self) -> bool {
        self.damage.is_empty()
    }
}

/// Refuses to go on with entries from a number on whose chain is broken.
pub(crate) fn need_chain(engine: &mut dyn Engine, from: i64) -> Result<()> {
    let rows = engine.rows(
        "SELECT number, body, previous, digest FROM entry WHERE number >= ?1 ORDER BY number",
        &[from.into()],
    )?;
    match broken(&rows, from <= 1).first() {
        None => Ok(()),
        Some(first) => Err(Trouble::data(format!("the records are damaged: {first}"))
            .with_hint("`proofmass records check` lists what is damaged; take the last backup")),
    }
}

/// The entries in a row (number, body, digest of the one before, own digest) that are not what was filed, or do not follow the one
/// before; `whole` where nothing may stand before the first.
fn broken(rows: &[Row], whole: bool) -> Vec<String> {
    let mut before: Option<(i64, String)> = whole.then(|| (0, String::new()));
    let mut found = Vec::new();
    for row in rows {
        let (number, previous) = (row[0].integer().unwrap_or_default(), row[2].words());
        let follows = before
            .as_ref()
            .is_none_or(|(n, digest)| number == n + 1 && previous == *digest);
        if !follows || link(number, &row[1].words(), &previous) != row[3].words() {
            found.push(format!(
                "entry {number} is not what was filed, or the one before it is gone"
            ));
        }
        before = Some((number, row[3].words()));
    }
    found
}

impl Records {
    /// Checks the chain of the entries, makes the index anew from them and compares it, reads every file, and verifies the signatures.
    ///
    /// # Errors
    /// The database cannot be read at all.
    pub fn check(&mut self) -> Result<Check> {
        let mut check = Check {
            damage: self.engine.damage()?,
            ..Check::default()
        };
        let mut again = Self::in_memory()?;
        let rows = match self.engine.rows(
            "SELECT number, body, previous, digest FROM entry ORDER BY number",
            &[],
        ) {
            Ok(rows) => rows,
            Err(damage) => {
                check.damage.push(damage.to_string());
                return Ok(check);
            }
        };
        again.engine.begin()?;
        check.damage.extend(broken(&rows, true));
        for row in &rows {
            let (number, body) = (row[0].integer().unwrap_or_default(), row[1].words());
            check.entries += 1;
            match parse(number, &body)
                .and_then(|entry| append_body(&mut *again.engine, &body, &entry))
            {
                Ok(_) => {}
                Err(damage) => check.damage.push(damage.to_string()),
            }
        }
        check.head = rows.last().map(|row| row[3].words()).unwrap_or_default();
        again.engine.commit()?;
        // Where the chain is broken the index is made from what is not what was filed.
        if check.is_whole() {
            for table in DERIVED {
                if contents(self, table)? != contents(&mut again, table)? {
                    check
                        .damage
                        .push(format!("the index `{table}` is not what the entries say"));
                }
            }
        }
        self.check_files(&mut check)?;
        let people = self
            .engine
            .rows("SELECT digest, salt, name FROM person", &[])?;
        for row in people {
            if sha256(&[row[1].words().as_bytes(), row[2].words().as_bytes()]) != row[0].words() {
                check
                    .damage
                    .push("the name of a person was changed".to_owned());
            }
        }
        Ok(check)
    }

    /// Kept files that are gone or changed, and signatures that do not hold.
    pub(crate) fn damaged_files(&mut self) -> Result<Vec<String>> {
        let mut check = Check::default();
        self.check_files(&mut check)?;
        Ok(check.damage)
    }

    fn check_files(&mut self, check: &mut Check) -> Result<()> {
        let beside = self.engine.beside();
        for row in self
            .engine
            .rows("SELECT digest FROM file ORDER BY digest", &[])?
        {
            let digest = row[0].words();
            check.files += 1;
            match files::get(&mut *self.engine, beside.as_deref(), &digest) {
                Ok(Some(_)) => {}
                Ok(None) => check.damage.push(format!("the file {digest} is not there")),
                Err(damage) => check.damage.push(damage.to_string()),
            }
        }
        // Every file that an entry says is kept is known, and every list that is signed holds.
        let entries = match self.entries(1) {
            Ok(entries) => entries,
            Err(_) => return Ok(()),
        };
        let known = self.engine.rows("SELECT digest FROM file", &[])?;
        let known: std::collections::HashSet<String> =
            known.iter().map(|row| row[0].words()).collect();
        for (number, entry) in entries {
            if let Some(lost) = entry.content.kept().find(|f| !known.contains(&f.sha256)) {
                check
                    .damage
                    .push(format!("{} of the entry {number} is gone", lost.name));
            }
            let Content::Result(result) = &entry.content else {
                continue;
            };
            if result.signer.is_some() {
                match self.signer(result) {
                    Ok(signer) if signer == result.signer => check.signatures += 1,
                    _ => check
                        .damage
                        .push(format!("the signature of result {number} does not hold")),
                }
            }
        }
        Ok(())
    }

    /// Who signed the list of files of a result, where the signature holds.
    fn signer(&mut self, result: &FiledResult) -> Result<Option<String>> {
        let Some(list) = result.files.iter().find(|f| f.name == MANIFEST) else {
            return Ok(None);
        };
        let Some(bytes) = self.file(&list.sha256)? else {
            return Ok(None);
        };
        let manifest = Manifest::from_json(&bytes)?;
        let signer = manifest
            .signature
            .as_ref()
            .and_then(|s| s.signer(&manifest.statement()));
        Ok(signer.map(|key| key.to_string()))
    }
}

/// Every row of a table as text, in a fixed order.
fn contents(records: &mut Records, table: &str) -> Result<Vec<String>> {
    let rows = records
        .engine
        .rows(&format!("SELECT * FROM {table}"), &[])?;
    let mut lines: Vec<String> = rows
        .iter()
        .map(|row| row.iter().map(shown).collect::<Vec<_>>().join("\u{1f}"))
        .collect();
    lines.sort_unstable();
    Ok(lines)
}

fn shown(value: &Value) -> String {
    match value {
        Value::Null => "-".to_owned(),
        Value::Integer(value) => value.to_string(),
        Value::Real(value) => format!("{:016x}", value.to_bits()),
        Value::Text(text) => text.clone(),
        Value::Bytes(bytes) => sha256(&[bytes]),
    }
}

/// What came of computing a result again.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Recomputed {
    /// The same version of the program gave the same bytes.
    Same,
    /// The same version gave other bytes: something is wrong.
    Differs {
        /// The quantities that differ.
        quantities: Vec<Difference>,
    },
    /// Another version: each quantity with its difference, judged by U.
    OtherVersion {
        /// The version that computed it.
        version: String,
        /// Every quantity.
        quantities: Vec<Difference>,
    },
    /// What is stored does not do.
    NotPossible {
        /// What is missing.
        why: String,
    },
}

/// A quantity, stored and computed again.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Difference {
    /// Name of the quantity.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What is stored, and what was computed now.
    pub values: [f64; 2],
    /// The difference over the stored U; `None` without U.
    pub share: Option<f64>,
}

impl Difference {
    /// Whether the difference is within the stored U.
    pub fn is_within(&self) -> bool {
        self.values[0] == self.values[1] || self.share.is_some_and(|s| s.abs() <= 1.0)
    }
}

impl Records {
    /// Computes a result again from its campaign and recordings, where all of them are kept here.
    ///
    /// # Errors
    /// There is no such result, a file is damaged, or the data no longer carry the result.
    pub fn recompute(&mut self, number: i64) -> Result<Recomputed> {
        let Content::Result(filed) = self.entry(number)?.content else {
            return Err(Trouble::request(format!("entry {number} is no result"))
                .with_hint("`proofmass records list` has the results"));
        };
        let not = |why: &str| {
            Ok(Recomputed::NotPossible {
                why: why.to_owned(),
            })
        };
        let Some(stored) = filed.files.iter().find(|f| f.name == RESULT) else {
            return not("it has no result.json: it was imported from a spreadsheet");
        };
        let Some(bytes) = self.file(&stored.sha256)? else {
            return not("its result.json is not kept here");
        };
        let is_campaign = |name: &str| name.ends_with(".toml");
        let Some(campaign) = filed.inputs.iter().find(|f| is_campaign(&f.name)) else {
            return not(
                "it does not come from a campaign: the options of its command are not stored",
            );
        };
        if let Some(missing) = filed.inputs.iter().find(|f| !f.kept) {
            return not(&format!("{} is kept by its digest alone", missing.name));
        }
        // The campaign names its files relative to its own folder.
        let folder = Path::new(&campaign.name).parent().unwrap_or(Path::new(""));
        let mut store = InFolder {
            folder: folder.to_path_buf(),
            files: Memory::new(),
        };
        for input in &filed.inputs {
            let bytes = self.file(&input.sha256)?.unwrap_or_default();
            let path = Path::new(&input.name);
            let name = path.strip_prefix(folder).unwrap_or(path);
            store.files = store.files.file(name.to_string_lossy(), bytes);
        }
        let name = Path::new(&campaign.name)
            .strip_prefix(folder)
            .unwrap_or(Path::new(&campaign.name))
            .to_string_lossy()
            .into_owned();
        let old = StoredResult::from_json(&bytes)?;
        let campaign = Campaign::read(Arc::new(store), &name)?;
        let mut candidates = campaign.of_each_device();
        let place = candidates
            .iter()
            .position(|(_, c)| c.result_kind() == old.kind())
            .unwrap_or_default();
        let several = candidates.len() > 1;
        let date = old.record().date.clone();
        let mut new = None;
        for (_, campaign) in if several {
            candidates
        } else {
            vec![candidates.swap_remove(place)]
        } {
            let result = campaign.evaluate(date.clone(), &Unwatched)?;
            if new.is_none() || result.record().device == old.record().device {
                new = Some(result);
            }
        }
        let Some(new) = new else {
            return not("its campaign names no device");
        };
        if new.to_json()? == bytes {
            return Ok(Recomputed::Same);
        }
        let differences = differences(&quantities(&old)?, &quantities(&new)?);
        let own = Software::default().to_string();
        Ok(match old.record().software.to_string() {
            version if version == own => Recomputed::Differs {
                quantities: differences,
            },
            version => Recomputed::OtherVersion {
                version,
                quantities: differences,
            },
        })
    }
}

/// Files in memory under the names that they had.
struct InFolder {
    folder: std::path::PathBuf,
    files: Memory,
}

impl proofmass_jobs::Store for InFolder {
    fn open(&self, name: &str) -> proofmass_io::Result<Source> {
        let (bytes, _) = self.files.open(name)?.into_bytes(LARGEST_DOCUMENT)?;
        Source::from_bytes(self.describe(name), bytes)
    }

    fn holds(&self, name: &str) -> bool {
        self.files.holds(name)
    }

    fn describe(&self, name: &str) -> std::path::PathBuf {
        self.folder.join(name)
    }
}

fn differences(old: &[FiledQuantity], new: &[FiledQuantity]) -> Vec<Difference> {
    let pairs = old.iter().filter_map(|a| {
        Some((
            a,
            new.iter().find(|b| b.name == a.name && b.unit == a.unit)?,
        ))
    });
    let differences = pairs.map(|(a, b)| Difference {
        name: a.name.clone(),
        unit: a.unit.clone(),
        values: [a.value, b.value],
        share: a
            .expanded
            .filter(|u| *u > 0.0)
            .map(|u| (b.value - a.value) / u),
    });
    differences.collect()
}

/// E_n with k = 2 of a check measurement: measured value and reference with their standard uncertainties.
///
/// # Errors
/// Uncertainties that are not positive.
pub fn check_measurement(
    quantity: &str,
    unit: &str,
    measured: (f64, f64),
    reference: (f64, f64),
) -> Result<En> {
    let q = |(value, u): (f64, f64)| proofmass_uncertainty::Quantity {
        name: quantity.to_owned(),
        unit: unit.to_owned(),
        value,
        standard_uncertainty: u,
        dof: history::freedom(None),
    };
    // The probability of k = 2 for a normal distribution.
    Ok(En::new(
        &q(measured),
        &q(reference),
        0.0,
        0.954_499_736_103_642,
    )?)
}
