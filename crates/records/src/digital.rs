//! Digital calibration certificates as results: what another laboratory found of a device.

use crate::candidate::Candidate;
use crate::entry::{FiledQuantity, sha256};
use crate::filing::{Filed, Filing, OTHERS};
use crate::ledger::Records;
use proofmass_documents::DigitalCertificate;
use proofmass_io::{LARGEST_DOCUMENT, Source};
use proofmass_jobs::{Result, Trouble};

/// Reads a digital calibration certificate (DCC) as a result of its item: the sensitivity over frequency where it states one, else every
/// quantity with its name, and its number.
///
/// # Errors
/// No certificate; one that names no day; as the reader.
pub fn read_digital(source: Source) -> Result<Candidate> {
    let name = source.name().display().to_string();
    let (bytes, _) = source.into_bytes(LARGEST_DOCUMENT)?;
    let said = DigitalCertificate::from_source(Source::from_bytes(&name, bytes.clone())?)?;
    let day = said.performed.clone().map(|[_, last]| last);
    let date = day.or_else(|| said.issued.clone()).ok_or_else(|| {
        Trouble::data(format!("{name} does not say when it was calibrated"))
            .with_hint("type its values into a table with a column `date`")
    })?;
    let quantities = match said.sensitivity(None) {
        Ok(table) => {
            let unit = format!("{}/(m/s²)", table.output);
            let stated = table.rows.iter().flat_map(|row| {
                let quantity = |what: &str, unit: &str, [value, u]: [f64; 2]| FiledQuantity {
                    name: format!("S.{what}[frequency={}]", row.frequency),
                    unit: unit.to_owned(),
                    value,
                    u: Some(u),
                    ..FiledQuantity::default()
                };
                let modulus = [row.sensitivity, row.sensitivity_uncertainty];
                let phase = row.phase.map(|phase| quantity("phase", "rad", phase));
                [Some(quantity("modulus", &unit, modulus)), phase]
            });
            stated.flatten().collect()
        }
        Err(_) => others(&said),
    };
    Ok(Candidate {
        number: said.identifier.clone(),
        device: said.item.clone(),
        kind: OTHERS.to_owned(),
        title: said
            .laboratory
            .clone()
            .map(|l| format!("Certificate of {l}")),
        date,
        sha256: sha256(&[&bytes]),
        source: name.clone(),
        quantities,
        files: vec![(name, bytes)],
        findings: said.findings(),
        ..Candidate::default()
    })
}

/// Every quantity by its label; those of a list by their place.
fn others(said: &DigitalCertificate) -> Vec<FiledQuantity> {
    let mut found: Vec<FiledQuantity> = Vec::new();
    for q in &said.quantities {
        let named = [q.label.as_deref().unwrap_or_default(), &q.name];
        let label = named.into_iter().find(|l| !l.trim().is_empty());
        let label = label.unwrap_or("quantity");
        for (i, value) in q.values.iter().enumerate() {
            let place = match q.values.len() {
                1 => label.to_owned(),
                _ => format!("{label}[{}]", i + 1),
            };
            let same = found.iter().filter(|f| f.name == place).count();
            found.push(FiledQuantity {
                name: match same {
                    0 => place,
                    n => format!("{place} ({})", n + 1),
                },
                unit: q.unit.symbol(),
                value: *value,
                u: q.uncertainty.as_ref().map(|u| u.standard(i)),
                ..FiledQuantity::default()
            });
        }
    }
    found
}

impl Records {
    /// Files a digital calibration certificate as a result of its item.
    ///
    /// # Errors
    /// As [`read_digital`]; the database refuses.
    pub fn add_digital(&mut self, source: Source, filing: &Filing, today: &str) -> Result<Filed> {
        self.file_candidate(&read_digital(source)?, filing, today)
    }
}
