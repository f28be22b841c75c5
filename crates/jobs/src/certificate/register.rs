//! The register of released certificates: an append-only file of one line a certificate beside LAB.toml.
//!
//! Numbers follow each other without holes, and each is used once. A line has its own digest and that of the one before, so that a line that was
//! changed, taken out or put in is found.

use super::{Language, Numbering, Replaced};
use crate::trouble::{Result, Trouble};
use proofmass_io::{AppendLog, LARGEST_DOCUMENT, Source, sha256};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A released certificate.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Registered {
    /// Its place, from one.
    pub sequence: u64,
    /// Its number.
    pub number: String,
    /// Day of issue.
    pub issued: String,
    /// Maker, type, serial number and identification of the item.
    pub item: String,
    /// SHA-256 of the digital certificate.
    pub certificate_sha256: String,
    /// SHA-256 of the result.
    pub result_sha256: String,
    /// Language; the first registers do not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub language: Option<Language>,
    /// What it replaces, and why.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub replaces: Option<Replaced>,
    /// SHA-256 of the line before; of the first line, of nothing.
    pub previous: String,
    /// SHA-256 of the line itself, while this stands empty in it.
    pub sha256: String,
}

/// What a released certificate is entered with.
#[derive(Clone, Debug)]
pub struct NewEntry<'a> {
    /// Its number.
    pub number: &'a str,
    /// Day of issue.
    pub issued: &'a str,
    /// The item in one line.
    pub item: &'a str,
    /// The digital certificate.
    pub certificate: &'a [u8],
    /// The result.
    pub result: &'a [u8],
    /// Language.
    pub language: Language,
    /// What it replaces.
    pub replaces: Option<&'a Replaced>,
}

impl Registered {
    /// The digest of the line that this entry is.
    fn digest(&self) -> Option<String> {
        let open = Self {
            sha256: String::new(),
            ..self.clone()
        };
        Some(sha256(&[&serde_json::to_vec(&open).ok()?]))
    }

    /// Whether it is the entry of this digital certificate.
    pub fn is_of(&self, certificate: &[u8]) -> bool {
        self.certificate_sha256 == sha256(&[certificate])
    }
}

/// The entry by which a certificate is replaced.
pub fn replaced_by<'a>(entries: &'a [Registered], number: &str) -> Option<&'a Registered> {
    let of = |e: &Registered| e.replaces.as_ref().is_some_and(|r| r.number == number);
    entries.iter().find(|e| of(e))
}

/// The register: locked for this process until it is dropped, or looked at as it stands.
#[derive(Debug)]
pub struct Register {
    log: Option<AppendLog>,
    entries: Vec<Registered>,
    last: String,
    place: String,
}

impl Register {
    /// Opens and locks the register, and makes it where it is not there yet.
    ///
    /// # Errors
    /// Another process holds it; a line that is none, that was changed, or that does not follow the one before.
    pub fn open(path: &Path) -> Result<Self> {
        let (log, text) = AppendLog::open(path)?;
        Self::read(Some(log), &text, path)
    }

    /// Looks at the register without a lock; one that is not there yet is empty.
    ///
    /// # Errors
    /// As [`Register::open`], but for the lock.
    pub fn look(path: &Path) -> Result<Self> {
        if !path.exists() {
            return Self::read(None, "", path);
        }
        let (bytes, _) = Source::open(path)?.into_bytes(LARGEST_DOCUMENT)?;
        Self::read(None, &String::from_utf8_lossy(&bytes), path)
    }

    fn read(log: Option<AppendLog>, text: &str, path: &Path) -> Result<Self> {
        let place = path.display().to_string();
        let damaged = |line: usize, why: &str| {
            Trouble::data(format!(
                "the register of certificates is damaged: line {line} {why}"
            ))
            .detail(&place)
            .with_hint(
                "take the register from a copy: no certificate is released until it is whole",
            )
        };
        if !text.is_empty() && !text.ends_with('\n') {
            return Err(damaged(
                text.lines().count(),
                "has no end: a writing was cut short",
            ));
        }
        let mut entries: Vec<Registered> = Vec::new();
        let mut last = sha256(&[b""]);
        for (i, line) in text.lines().enumerate() {
            let entry: Registered =
                serde_json::from_str(line).map_err(|_| damaged(i + 1, "is no entry"))?;
            if entry.digest().as_ref() != Some(&entry.sha256) {
                return Err(damaged(i + 1, "was changed"));
            }
            if entry.previous != last {
                return Err(damaged(i + 1, "does not follow the line before"));
            }
            if entry.sequence != i as u64 + 1 {
                return Err(damaged(i + 1, "has another place than its own"));
            }
            if entries.iter().any(|e| e.number == entry.number) {
                return Err(damaged(i + 1, "has a number that is used already"));
            }
            last = sha256(&[line.as_bytes()]);
            entries.push(entry);
        }
        Ok(Self {
            log,
            entries,
            last,
            place,
        })
    }

    /// The certificates, in the order of their release.
    pub fn entries(&self) -> &[Registered] {
        &self.entries
    }

    /// The certificates of a result that replace the same, the last one first; those that were replaced themselves are left out.
    pub fn of_result<'a>(
        &'a self,
        result: &[u8],
        replaces: Option<&'a Replaced>,
    ) -> impl Iterator<Item = &'a Registered> {
        let digest = sha256(&[result]);
        let entries = self.entries.iter().rev();
        entries.filter(move |e| {
            e.result_sha256 == digest
                && e.replaces.as_ref() == replaces
                && replaced_by(&self.entries, &e.number).is_none()
        })
    }

    /// Refuses a second certificate of a result in one language that replaces none.
    ///
    /// # Errors
    /// A certificate of the result that holds.
    pub fn may_state(
        &self,
        result: &[u8],
        language: Language,
        replaces: Option<&Replaced>,
    ) -> Result<()> {
        let digest = sha256(&[result]);
        let of = |e: &&Registered| {
            e.result_sha256 == digest
                && e.language.is_none_or(|l| l == language)
                && replaced_by(&self.entries, &e.number).is_none()
                && replaces.is_none_or(|r| r.number != e.number)
        };
        match self.entries.iter().rev().find(of) {
            None => Ok(()),
            Some(before) => Err(Trouble::request(format!(
                "the result was certified already, as {} of {}",
                before.number, before.issued
            ))
            .with_hint(format!(
                "say --replaces {} and the --reason, where that one was wrong; the same request again writes it once more",
                before.number
            ))),
        }
    }

    /// The certificate of a number.
    pub fn find(&self, number: &str) -> Option<&Registered> {
        self.entries.iter().find(|e| e.number == number)
    }

    /// The number that the next certificate has.
    ///
    /// # Errors
    /// A pattern that makes none, or makes one again that is used already.
    pub fn next(&self, numbering: &Numbering, issued: &str) -> Result<String> {
        let year = issued.split('-').next().unwrap_or_default();
        let number = numbering.number(year, self.entries.len() as u64 + 1)?;
        match self.find(&number) {
            None => Ok(number),
            Some(used) => Err(Trouble::request(format!(
                "the number {number} is used already, of {}",
                used.issued
            ))
            .with_hint("change `pattern` in [numbering]")),
        }
    }

    /// Enters a certificate: it is on the disk when this returns.
    ///
    /// # Errors
    /// A certificate that replaces one that is not there or is replaced already; a register that was only looked at; the disk refuses.
    pub fn enter(&mut self, new: &NewEntry<'_>) -> Result<()> {
        if let Some(replaced) = new.replaces {
            self.may_replace(replaced, new.item)?;
        }
        let cannot = |why: &str| {
            Trouble::data(format!("the entry cannot be written: {why}")).detail(&self.place)
        };
        let mut entry = Registered {
            sequence: self.entries.len() as u64 + 1,
            number: new.number.to_owned(),
            issued: new.issued.to_owned(),
            item: new.item.to_owned(),
            certificate_sha256: sha256(&[new.certificate]),
            result_sha256: sha256(&[new.result]),
            language: Some(new.language),
            replaces: new.replaces.cloned(),
            previous: self.last.clone(),
            sha256: String::new(),
        };
        entry.sha256 = entry.digest().ok_or_else(|| cannot("it has no form"))?;
        let line = serde_json::to_string(&entry).map_err(|e| cannot(&e.to_string()))?;
        let Some(log) = &mut self.log else {
            return Err(cannot("the register is open for reading only"));
        };
        log.append(&format!("{line}\n"))?;
        self.last = sha256(&[line.as_bytes()]);
        self.entries.push(entry);
        Ok(())
    }

    /// Whether a certificate may be replaced by one of this item.
    ///
    /// # Errors
    /// It is not in the register, is replaced already, or is of another item.
    pub fn may_replace(&self, replaced: &Replaced, item: &str) -> Result<()> {
        let Some(before) = self.find(&replaced.number) else {
            let near = proofmass_io::spelling::nearest(
                &replaced.number,
                self.entries.iter().map(|e| e.number.as_str()),
            );
            let trouble = Trouble::request(format!(
                "the register has no certificate {}",
                replaced.number
            ))
            .detail(&self.place);
            return Err(match near {
                Some(near) => trouble.with_hint(format!("did you mean {near}?")),
                None => trouble.with_hint("name the number of a certificate that was released"),
            });
        };
        if before.item != item && !replaced.other_item {
            return Err(Trouble::request(format!(
                "certificate {} is of the item {:?}, and not of {item:?}",
                before.number, before.item
            ))
            .with_hint("name the certificate of this item; where the item was named wrongly there, say --other-item"));
        }
        match replaced_by(&self.entries, &replaced.number) {
            None => Ok(()),
            Some(by) => Err(Trouble::request(format!(
                "certificate {} is replaced already, by {}",
                replaced.number, by.number
            ))
            .with_hint(format!("replace {} instead", by.number))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbering() -> Numbering {
        Numbering {
            pattern: "C-{year}-{number:3}".into(),
            register: "r.jsonl".into(),
        }
    }

    /// An entry of one certificate and result.
    fn entry<'a>(number: &'a str, replaces: Option<&'a Replaced>) -> NewEntry<'a> {
        NewEntry {
            number,
            issued: "2026-11-27",
            item: "Maker A-1 4711",
            certificate: b"x",
            result: b"r",
            language: Language::English,
            replaces,
        }
    }

    #[test]
    fn law_numbers_follow_each_other_and_are_used_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.jsonl");
        for k in 1..=3u64 {
            let mut register = Register::open(&path).unwrap();
            let number = register.next(&numbering(), "2026-11-27").unwrap();
            assert_eq!(number, format!("C-2026-{k:03}"));
            register.enter(&entry(&number, None)).unwrap();
            assert_eq!(register.entries().len() as u64, k);
        }
        let mut register = Register::open(&path).unwrap();
        let again = Replaced {
            number: "C-2026-002".into(),
            reason: "typing error".into(),
            other_item: false,
        };
        let of_another = NewEntry {
            item: "Maker A-1 4712",
            ..entry("C-2026-004", Some(&again))
        };
        let refused = register.enter(&of_another).unwrap_err();
        assert!(refused.to_string().contains("4711"), "{refused}");
        let mistyped = Replaced {
            other_item: true,
            ..again.clone()
        };
        register.may_replace(&mistyped, "Maker A-1 4712").unwrap();
        register.enter(&entry("C-2026-004", Some(&again))).unwrap();
        let twice = register
            .enter(&entry("C-2026-005", Some(&again)))
            .unwrap_err();
        assert!(
            twice
                .to_string()
                .contains("replaced already, by C-2026-004"),
            "{twice}"
        );
        let none = Replaced {
            number: "C-2026-010".into(),
            reason: "x".into(),
            other_item: false,
        };
        assert!(
            register
                .may_replace(&none, "Maker A-1 4711")
                .unwrap_err()
                .hint()
                .unwrap()
                .contains("did you mean C-2026-0")
        );
        // Two at once would take the same number.
        let locked = Register::open(&path).unwrap_err();
        assert!(locked.to_string().contains("another process"), "{locked}");
    }

    #[test]
    fn refuses_a_register_that_was_changed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.jsonl");
        for _ in 0..3 {
            let mut register = Register::open(&path).unwrap();
            let number = register.next(&numbering(), "2026-11-27").unwrap();
            register.enter(&entry(&number, None)).unwrap();
        }
        let whole = std::fs::read_to_string(&path).unwrap();
        let lines: Vec<&str> = whole.lines().collect();
        for changed in [
            format!("{}\n{}\n", lines[0], lines[2]),
            format!("{}\n{}\n{}\n", lines[1], lines[0], lines[2]),
            whole.replacen("2026-11-27", "2026-11-28", 1),
            // The last line has no line behind it, but its own digest.
            whole.replace("C-2026-003", "C-2026-004"),
            whole[..whole.len() - 1].to_owned(),
            whole[..whole.len() - 20].to_owned(),
            format!("{whole}{}\n", lines[2]),
            format!("{whole}x\n"),
        ] {
            std::fs::write(&path, &changed).unwrap();
            let error = Register::open(&path).unwrap_err();
            assert!(error.to_string().contains("damaged"), "{changed}: {error}");
        }
        std::fs::write(&path, &whole).unwrap();
        assert_eq!(Register::open(&path).unwrap().entries().len(), 3);
        // What was only looked at is not written to, and one that is not there is not made.
        let mut looked = Register::look(&path).unwrap();
        assert_eq!(
            looked.next(&numbering(), "2026-11-27").unwrap(),
            "C-2026-004"
        );
        assert!(looked.enter(&entry("C-2026-004", None)).is_err());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), whole);
        let none = folder.path().join("none.jsonl");
        assert!(Register::look(&none).unwrap().entries().is_empty() && !none.exists());
    }
}
