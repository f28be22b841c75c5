//! What the tests file: devices, certificates, results made on the spot.

use proofmass_io::OutputFolder;
use proofmass_jobs::campaign::{Campaign, example};
use proofmass_jobs::{Gathered, Unwatched};
use proofmass_records::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub const TODAY: &str = "2026-06-01";

pub fn device(serial: &str) -> FiledDevice {
    FiledDevice {
        manufacturer: Some("maker".into()),
        model: Some("A1".into()),
        serial: Some(serial.into()),
        ..Default::default()
    }
}

pub fn standard(records: &mut Records, serial: &str) -> i64 {
    let standard = FiledDevice {
        standard: true,
        ..device(serial)
    };
    records.add(TODAY, None, Content::Device(standard)).unwrap()
}

pub fn certificate(
    records: &mut Records,
    standard: i64,
    number: &str,
    [from, until]: [&str; 2],
    u: f64,
) -> i64 {
    let certificate = FiledCertificate {
        standard,
        number: number.into(),
        laboratory: Some("national laboratory".into()),
        valid_from: from.into(),
        valid_until: Some(until.into()),
        u_relative: Some(u),
        ..Default::default()
    };
    records
        .add(TODAY, None, Content::Certificate(certificate))
        .unwrap()
}

/// A result of one sensitivity of a device on a day.
pub fn candidate(serial: &str, date: &str, value: f64, u: f64, u_standard: f64) -> Candidate {
    let q = FiledQuantity {
        name: "S.modulus".into(),
        unit: "V/(m/s²)".into(),
        value,
        u: Some(u),
        expanded: Some(2.0 * u),
        k: Some(2.0),
        probability: Some(0.9545),
        u_standard: Some(u_standard),
        ..Default::default()
    };
    Candidate {
        device: proofmass_documents::Device {
            manufacturer: Some("maker".into()),
            model: Some("A1".into()),
            serial: Some(serial.into()),
            description: None,
        },
        kind: "shaker-single".into(),
        date: date.into(),
        sha256: format!("{serial} {date} {value}"),
        source: "test".into(),
        quantities: vec![q],
        ..Default::default()
    }
}

pub fn file(records: &mut Records, candidate: &Candidate, standard: Option<&str>) -> Filed {
    let filing = Filing {
        standard: standard.into_iter().map(str::to_owned).collect(),
        ..Default::default()
    };
    records.file_candidate(candidate, &filing, TODAY).unwrap()
}

/// As results are filed here: with inputs of up to a megabyte.
pub fn filing() -> Filing {
    Filing {
        largest: 1.0,
        ..Default::default()
    }
}

pub fn codes(filed: &Filed) -> Vec<String> {
    filed.findings.iter().map(|f| f.code().to_owned()).collect()
}

/// A campaign of a comparison with its result, in a folder.
pub fn campaign(folder: &Path) -> PathBuf {
    let gathered = Gathered::default();
    example("shaker-single", &gathered, &Unwatched).unwrap();
    let place = folder.join("single");
    std::fs::create_dir_all(&place).unwrap();
    let memory = gathered.into_memory();
    for name in ["campaign.toml", "runs.csv", "reference.csv"] {
        let source = proofmass_jobs::Store::open(&memory, name).unwrap();
        let (bytes, _) = source.into_bytes(1 << 20).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let text = text.replace("serial = \"…\"", "serial = \"0042\"");
        std::fs::write(place.join(name), text).unwrap();
    }
    evaluate(&place);
    place
}

/// Evaluates a campaign and writes its result.
pub fn evaluate(place: &Path) {
    let campaign = Campaign::open(place).unwrap();
    let result = campaign
        .evaluate(Some("2026-05-01".into()), &Unwatched)
        .unwrap();
    let out = OutputFolder::create(place.join("result"), true).unwrap();
    for (name, bytes) in result.files().unwrap() {
        out.write(&name, bytes).unwrap();
    }
    out.commit().unwrap();
    let _ = Arc::new(());
}
