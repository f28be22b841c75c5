//! The register of released certificates: an append-only file of one line a certificate beside LAB.toml.
//!
//! Numbers follow each other without holes, and each is used once. A line has the digest of the one before, so that a line that was changed,
//! taken out or put in is found.

use super::{Numbering, Replaced};
use crate::trouble::{Result, Trouble};
use proofmass_io::{AppendLog, sha256};
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
    /// SHA-256 of the digital certificate.
    pub certificate_sha256: String,
    /// SHA-256 of the result.
    pub result_sha256: String,
    /// What it replaces, and why.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub replaces: Option<Replaced>,
    /// SHA-256 of the line before; of the first line, of nothing.
    pub previous: String,
}

impl Registered {
    /// Whether it is the entry of this digital certificate.
    pub fn is_of(&self, certificate: &[u8]) -> bool {
        self.certificate_sha256 == sha256(&[certificate])
    }
}

/// The register, locked for this process until it is dropped.
#[derive(Debug)]
pub struct Register {
    log: AppendLog,
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
                && !self.is_replaced(&e.number)
        })
    }

    fn is_replaced(&self, number: &str) -> bool {
        let replaced = self.entries.iter().filter_map(|e| e.replaces.as_ref());
        replaced.into_iter().any(|r| r.number == number)
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
    /// A certificate that replaces one that is not there or is replaced already; the disk refuses.
    pub fn enter(
        &mut self,
        number: &str,
        issued: &str,
        certificate: &[u8],
        result: &[u8],
        replaces: Option<Replaced>,
    ) -> Result<()> {
        if let Some(replaced) = &replaces {
            self.may_replace(replaced)?;
        }
        let entry = Registered {
            sequence: self.entries.len() as u64 + 1,
            number: number.to_owned(),
            issued: issued.to_owned(),
            certificate_sha256: sha256(&[certificate]),
            result_sha256: sha256(&[result]),
            replaces,
            previous: self.last.clone(),
        };
        let line = serde_json::to_string(&entry).map_err(|e| {
            Trouble::data(format!("the entry cannot be written: {e}")).detail(&self.place)
        })?;
        self.log.append(&format!("{line}\n"))?;
        self.last = sha256(&[line.as_bytes()]);
        self.entries.push(entry);
        Ok(())
    }

    /// Whether a certificate may be replaced.
    ///
    /// # Errors
    /// It is not in the register, or is replaced already.
    pub fn may_replace(&self, replaced: &Replaced) -> Result<()> {
        if self.find(&replaced.number).is_none() {
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
        }
        let by = self.entries.iter().find(|e| {
            e.replaces
                .as_ref()
                .is_some_and(|r| r.number == replaced.number)
        });
        match by {
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

    #[test]
    fn law_numbers_follow_each_other_and_are_used_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.jsonl");
        for k in 1..=3u64 {
            let mut register = Register::open(&path).unwrap();
            let number = register.next(&numbering(), "2026-11-27").unwrap();
            assert_eq!(number, format!("C-2026-{k:03}"));
            register
                .enter(&number, "2026-11-27", b"x", b"r", None)
                .unwrap();
            assert_eq!(register.entries().len() as u64, k);
        }
        let mut register = Register::open(&path).unwrap();
        let again = Replaced {
            number: "C-2026-002".into(),
            reason: "typing error".into(),
        };
        register
            .enter("C-2026-004", "2026-11-27", b"x", b"r", Some(again.clone()))
            .unwrap();
        let twice = register
            .enter("C-2026-005", "2026-11-27", b"x", b"r", Some(again))
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
        };
        assert!(
            register
                .may_replace(&none)
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
            register
                .enter(&number, "2026-11-27", b"x", b"r", None)
                .unwrap();
        }
        let whole = std::fs::read_to_string(&path).unwrap();
        let lines: Vec<&str> = whole.lines().collect();
        for changed in [
            format!("{}\n{}\n", lines[0], lines[2]),
            format!("{}\n{}\n{}\n", lines[1], lines[0], lines[2]),
            whole.replacen("2026-11-27", "2026-11-28", 1),
            whole[..whole.len() - 1].to_owned(),
            whole[..whole.len() - 20].to_owned(),
            format!("{whole}{}\n", lines[2]),
            format!("{whole}x\n"),
        ] {
            std::fs::write(&path, &changed).unwrap();
            let error = Register::open(&path).unwrap_err();
            assert!(error.to_string().contains("damaged"), "{changed}: {error}");
        }
        // The last line alone has no line behind it that would show a change: its number and place are still checked.
        std::fs::write(&path, &whole).unwrap();
        assert_eq!(Register::open(&path).unwrap().entries().len(), 3);
    }
}
