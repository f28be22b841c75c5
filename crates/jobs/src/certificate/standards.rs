//! The standards of a certificate held against the inputs of the result, their own certificates and the register.

use super::CertificateData;
use super::content::says;
use super::laboratory::{CertificateFile, Item, Standard, is_day};
use super::register::{Registered, replaced_by};
use crate::StoredResult;
use proofmass_documents::DigitalCertificate;
use proofmass_io::{Input, ReadGravity};
use std::path::Path;

/// Normal gravity that a result was held against, where a recording was: it is a reference that has no certificate.
pub(super) fn normal_gravity(result: &StoredResult) -> Option<&ReadGravity> {
    let mut read = files(result).filter_map(|i| i.reading.as_ref()?.gravity.as_ref());
    read.find(|g| g.normal_at.is_some())
}

/// SHA-256 of the input that a standard names.
pub(super) fn digest_of(stated: &str, result: &StoredResult) -> Option<String> {
    files(result)
        .find(|i| is(i, stated))
        .map(|i| i.sha256.clone())
}

/// Standards that had expired, that name no input of the result, that are not as their own certificates say, or are the item itself; and
/// inputs that are standards and have no entry. Each in one line.
pub(super) fn doubts(
    file: &CertificateFile,
    data: &CertificateData<'_>,
    day: Option<&String>,
) -> Vec<String> {
    let mut doubts = Vec::new();
    // An input that is not there cannot be compared.
    let lost = data.lost.iter().filter(|name| is_standard(name));
    doubts.extend(lost.map(|name| {
        format!("a lost input: {name}, from which the result was computed, is not there any more")
    }));
    for (n, standard) in file.standards.iter().enumerate() {
        for (key, text) in [
            ("name", &standard.name),
            ("certificate", &standard.certificate),
            ("issuer", &standard.issuer),
        ] {
            if !says(text) {
                doubts.push(format!("standards.{key} of entry {}: what it is", n + 1));
            }
        }
        let same = |s: &&Standard| s.input.is_some() && s.input == standard.input;
        if file.standards[..n].iter().any(|s| same(&s)) {
            doubts.push(format!(
                "an input with two standards: {}",
                standard.input.as_deref().unwrap_or_default()
            ));
        }
        if let (Some(until), Some(day)) = (&standard.valid_until, day)
            && until < day
        {
            doubts.push(format!("an expired standard: the certificate {} of {} was valid until {until}, before {day}", standard.certificate, standard.name));
        }
        if let Some(stated) = &standard.input
            && !files(data.result).any(|i| is(i, stated))
        {
            doubts.push(format!(
                "an unknown standard: the result was not computed from {stated:?}, which {} names",
                standard.name
            ));
        }
        let item = file.item.clone().unwrap_or_default();
        let digest = standard.input.as_deref();
        let digest = digest.and_then(|stated| digest_of(stated, data.result));
        let own = data.certificates.iter();
        let mut own = own.filter(|c| Some(&c.input.sha256) == digest.as_ref());
        if let Some(certificate) = own.next() {
            doubts.extend(otherwise(standard, certificate, &item));
            doubts.extend(later(standard, certificate, day));
        }
        doubts.extend(in_register(
            standard,
            digest.as_deref(),
            data.released,
            &item,
        ));
    }
    let as_found = data.as_found.into_iter().flat_map(files);
    for input in files(data.result)
        .chain(as_found)
        .filter(|i| is_standard(&i.path))
    {
        let known = file.standards.iter().filter_map(|s| s.input.as_deref());
        let mut known = known.filter(|stated| is(input, stated));
        if known.next().is_none() {
            doubts.push(format!(
                "an unknown standard: the result was computed from {}, which no entry of [[standards]] names as its `input`",
                name_of(&input.path)
            ));
        }
    }
    doubts
}

/// What of the days of a standard's certificate cannot be.
fn later(
    standard: &Standard,
    certificate: &DigitalCertificate,
    day: Option<&String>,
) -> Option<String> {
    let (number, name) = (&standard.certificate, &standard.name);
    let performed = certificate.performed.as_ref();
    let days = [
        ("its calibration began on", performed.map(|p| &p[0])),
        ("it was calibrated until", performed.map(|p| &p[1])),
        ("it was issued on", certificate.issued.as_ref()),
    ];
    let days: Vec<(&str, &String)> = days
        .into_iter()
        .filter_map(|(what, day)| Some((what, day?)))
        .collect();
    if let Some((what, wrong)) = days.iter().find(|d| !is_day(d.1)) {
        return Some(format!(
            "a standard without a day: {what} {wrong:?} by the certificate {number} of {name}"
        ));
    }
    if let Some(pair) = days.windows(2).find(|pair| pair[0].1 > pair[1].1) {
        return Some(format!(
            "contradicting days of a standard: {} {}, but {} {}, by the certificate {number} of {name}",
            pair[0].0, pair[0].1, pair[1].0, pair[1].1
        ));
    }
    let (what, last) = days.last()?;
    let day = day.filter(|day| last > day)?;
    Some(format!(
        "a later standard: {what} {last}, after {day}, by the certificate {number} of {name}"
    ))
}

/// What an entry says otherwise than the certificate of its standard.
fn otherwise(standard: &Standard, certificate: &DigitalCertificate, item: &Item) -> Vec<String> {
    let mut doubts = Vec::new();
    let name = &standard.name;
    if let Some(number) = &certificate.identifier
        && *number != standard.certificate
    {
        doubts.push(format!(
            "another certificate: {name} names {}, but its digital certificate has the number {number}",
            standard.certificate
        ));
    }
    if let Some(laboratory) = &certificate.laboratory
        && !names(&standard.issuer, laboratory)
    {
        doubts.push(format!(
            "another issuer: {name} names {}, but its digital certificate was issued by {laboratory}",
            standard.issuer
        ));
    }
    let own = &certificate.item;
    let is_item = |a: &Option<String>, b: &Option<String>| match (a, b) {
        (Some(a), Some(b)) => Some(plain_name(a) == plain_name(b)),
        _ => None,
    };
    let maker = is_item(&own.manufacturer, &item.manufacturer).unwrap_or(true);
    let model = is_item(&own.model, &item.model).unwrap_or(true);
    let mut numbers = [&item.serial, &item.customer_id].into_iter();
    if numbers.any(|number| is_item(&own.serial, number) == Some(true)) && maker && model {
        doubts.push(format!(
            "the item as its own standard: the certificate {} of {name} is that of the item ({})",
            standard.certificate,
            own.line()
        ));
    }
    doubts
}

/// What the own register says of a standard that was calibrated here.
fn in_register(
    standard: &Standard,
    digest: Option<&str>,
    released: &[Registered],
    item: &Item,
) -> Vec<String> {
    let number = standard.certificate.trim();
    let is_it = |e: &&Registered| e.number.eq_ignore_ascii_case(number);
    let Some(entry) = released.iter().find(is_it) else {
        return Vec::new();
    };
    let changed = digest.filter(|d| *d != entry.certificate_sha256);
    let changed = changed.map(|_| {
        format!(
            "a changed certificate: the digital certificate of {} is not the one that was released as {}",
            standard.name, entry.number
        )
    });
    let by = replaced_by(released, &entry.number);
    let replaced = by.map(|by| {
        format!(
            "a replaced certificate: {} of {} was replaced by {}",
            entry.number, standard.name, by.number
        )
    });
    let own = (plain_name(&entry.item) == plain_name(&item.line())).then(|| {
        format!(
            "the item as its own standard: the certificate {} of {} is that of the item ({})",
            entry.number, standard.name, entry.item
        )
    });
    changed.into_iter().chain(replaced).chain(own).collect()
}

/// A name or number by what tells it from another: letters and digits, without the zeros that a number may begin with and without what says
/// that it is one.
fn plain_name(text: &str) -> String {
    const WORDS: [&str; 8] = ["s", "n", "sn", "no", "nr", "ser", "serial", "number"];
    let words = text.split(|c: char| !c.is_alphanumeric());
    let words = words.filter(|w| !WORDS.contains(&w.to_lowercase().as_str()));
    let words = words.map(|word| match word.chars().all(|c| c.is_ascii_digit()) {
        true => word.trim_start_matches('0').to_owned(),
        false => word.to_lowercase(),
    });
    words.collect()
}

/// Whether an issuer is named: by the name or a part of it, or by its initials, as PTB is.
fn names(issuer: &str, laboratory: &str) -> bool {
    let letters = |text: &str| -> String {
        let all = text.chars().filter(|c| c.is_alphanumeric());
        all.flat_map(char::to_lowercase).collect()
    };
    let words = laboratory.split(|c: char| !c.is_alphanumeric());
    let initials: String = words.filter_map(|w| w.chars().next()).collect();
    let (issuer, laboratory, initials) = (letters(issuer), letters(laboratory), letters(&initials));
    // One or two letters are a part of nearly every name.
    let is_part = issuer.chars().count() > 2 && laboratory.contains(&issuer);
    let has_initials = initials.chars().count() > 1 && issuer.contains(&initials);
    is_part || issuer == laboratory || issuer.contains(&laboratory) || has_initials
}

/// Tables of sensitivity and certificates among the inputs are standards.
fn is_standard(path: &str) -> bool {
    let name = name_of(path).to_ascii_lowercase();
    name.starts_with("reference") || name.ends_with(".xml") || name == "calibration.json"
}

fn files(result: &StoredResult) -> impl Iterator<Item = &Input> {
    result.record().inputs.iter().flat_map(Input::files)
}

/// The name of the file at a path.
fn name_of(path: &str) -> String {
    let name = Path::new(path).file_name();
    name.map_or_else(|| path.to_owned(), |n| n.to_string_lossy().into_owned())
}

/// Whether an input is the one that is stated by its digest, its path or its name.
fn is(input: &Input, stated: &str) -> bool {
    input.sha256 == stated || input.path == stated || name_of(&input.path) == stated
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_numbers_of_one_item() {
        for (a, b) in [
            ("0077", "77"),
            ("SN-0077", "77"),
            ("S/N 77", "77"),
            (" A 1", "a1"),
            ("4711", "4711 "),
        ] {
            assert_eq!(plain_name(a), plain_name(b), "{a} {b}");
        }
        for (a, b) in [("770", "77"), ("A0077", "77"), ("A-1", "A-11")] {
            assert!(plain_name(a) != plain_name(b), "{a} {b}");
        }
    }

    #[test]
    fn known_issuers() {
        let ptb = "Physikalisch-Technische Bundesanstalt";
        for issuer in [
            "PTB",
            "ptb",
            "PTB Braunschweig",
            ptb,
            "Physikalisch-Technische Bundesanstalt (PTB), Berlin",
            "Bundesanstalt",
        ] {
            assert!(names(issuer, ptb), "{issuer}");
        }
        for issuer in ["INRIM", "PT", "Physikalische Anstalt"] {
            assert!(!names(issuer, ptb), "{issuer}");
        }
    }
}
