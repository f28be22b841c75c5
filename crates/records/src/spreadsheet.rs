//! Old calibrations from a spreadsheet: one row for each quantity, columns by their names.

use crate::candidate::Candidate;
use crate::day::day_of;
use crate::entry::{FiledQuantity, sha256};
use crate::filing::{Filed, Filing};
use crate::ledger::Records;
use proofmass_documents::Device;
use proofmass_io::Source;
use proofmass_io::sheet::{
    ACCELERATION_RATIO, COUNT_SENSITIVITY, FREQUENCY, PERCENT, Place, SENSITIVITY, Sheet, SheetRow,
    coherent,
};
use proofmass_jobs::{Result, Trouble};
use std::collections::BTreeMap;

/// Units of a column `sensitivity`, in the order of its kinds.
const UNITS: [&str; 3] = ["V/(m/s²)", "1", "count/(m/s²)"];

/// Where everything stands.
struct Columns {
    texts: BTreeMap<&'static str, Option<Place>>,
    date: Place,
    sensitivity: Option<(usize, Place)>,
    frequency: Option<Place>,
    u_relative: Option<Place>,
    expanded_relative: Option<Place>,
}

const TEXTS: [&str; 11] = [
    "manufacturer",
    "model",
    "serial",
    "owner_number",
    "number",
    "standard",
    "quantity",
    "unit",
    "value",
    "u",
    "U",
];

/// Reads a spreadsheet of old calibrations: one candidate for each device and day, and the standard that each names.
///
/// Columns: `serial` (with `manufacturer`, `model`, `owner_number`), `date`, then either `quantity`, `value`, `unit` with `u` or `U` (and
/// `k`), or `sensitivity_mV/(m/s2)` in any of its units with `frequency_Hz`, `u_relative_%` or `U_relative_%`; `number` of the certificate
/// and `standard` where they are known.
///
/// # Errors
/// An unknown column, a row without device, date or value, a field that is no number: each with its line.
pub fn read_spreadsheet(source: Source) -> Result<Vec<(Candidate, Filing)>> {
    let name = source.name().display().to_string();
    let mut sheet = Sheet::from_source(source, "table of calibrations")?;
    let texts = TEXTS.iter().map(|name| (*name, sheet.text(name))).collect();
    let date = sheet.text("date");
    let k = sheet.text("k");
    let columns = Columns {
        texts,
        date: sheet.required(date, "date")?,
        sensitivity: sheet.one_of(
            "sensitivity",
            &[SENSITIVITY, ACCELERATION_RATIO, COUNT_SENSITIVITY],
        )?,
        frequency: sheet.quantity("frequency", FREQUENCY)?,
        u_relative: sheet.quantity("u_relative", PERCENT)?,
        expanded_relative: sheet.quantity("U_relative", PERCENT)?,
    };
    sheet.finish()?;
    let serial = columns.texts["serial"].or(columns.texts["owner_number"]);
    sheet.required(serial, "serial")?;
    let mut order: Vec<String> = Vec::new();
    let mut found: BTreeMap<String, (Candidate, Filing)> = BTreeMap::new();
    for row in sheet.rows() {
        let text = |column: &str| {
            columns.texts[column]
                .map(|p| row.text(p).trim().to_owned())
                .filter(|t| !t.is_empty())
        };
        let device = Device {
            manufacturer: text("manufacturer"),
            model: text("model"),
            serial: text("serial").or_else(|| text("owner_number")),
            description: None,
        };
        if device.serial.is_none() {
            return Err(row
                .refuse_row("the row names no device")
                .with_hint("write its serial number")
                .into());
        }
        let date = row.text(columns.date).trim().to_owned();
        day_of(&date).map_err(|wrong| {
            Trouble::from(row.refuse(columns.date, wrong.to_string()))
                .with_hint("write year, month and day as in 2026-03-31")
        })?;
        let quantity = quantity(&columns, k, &row)?;
        let key = format!(
            "{}\u{1f}{date}\u{1f}{}",
            device.line(),
            text("number").unwrap_or_default()
        );
        let (candidate, _) = found.entry(key.clone()).or_insert_with(|| {
            order.push(key.clone());
            let candidate = Candidate {
                number: text("number"),
                device,
                kind: "imported".to_owned(),
                date,
                source: format!("{name}, line {}", row.line),
                ..Candidate::default()
            };
            let filing = Filing {
                standard: text("standard").into_iter().collect(),
                ..Filing::default()
            };
            (candidate, filing)
        });
        if candidate.quantities.iter().any(|q| q.name == quantity.name) {
            return Err(row
                .refuse_row(format!(
                    "{} of this device and day stands twice",
                    quantity.name
                ))
                .with_hint("keep one of the two rows")
                .into());
        }
        candidate.quantities.push(quantity);
    }
    let digest = sheet.input.sha256.clone();
    let candidates = order.into_iter().filter_map(|key| {
        let (mut candidate, filing) = found.remove(&key)?;
        // The same rows are the same result, in whatever file.
        let said = serde_json::to_string(&candidate.quantities).unwrap_or_default();
        candidate.sha256 = sha256(&[key.as_bytes(), said.as_bytes()]);
        candidate.inputs = vec![(name.clone(), digest.clone(), None)];
        Some((candidate, filing))
    });
    Ok(candidates.collect())
}

fn quantity(columns: &Columns, k: Option<Place>, row: &SheetRow<'_>) -> Result<FiledQuantity> {
    let k = row.optional(k)?;
    if let Some((kind, place)) = columns.sensitivity {
        let value = row.number(place)?;
        let name = match row.optional(columns.frequency)? {
            Some(frequency) => format!("S.modulus[frequency={frequency}]"),
            None => "S.modulus".to_owned(),
        };
        let of = |share: Option<f64>| share.map(|s| s * value.abs());
        return Ok(with_k(FiledQuantity {
            name,
            unit: UNITS[kind].to_owned(),
            value,
            u: of(row.optional(columns.u_relative)?),
            expanded: of(row.optional(columns.expanded_relative)?),
            k,
            ..FiledQuantity::default()
        }));
    }
    let column = |name: &str| {
        columns.texts[name].ok_or_else(|| {
            Trouble::from(row.refuse_row(format!("the table has no column `{name}`")))
                .with_hint("give quantity, value and unit, or sensitivity with its unit, such as sensitivity_mV/(m/s2)")
        })
    };
    let unit = row.text(column("unit")?).trim().to_owned();
    let name = row.text(column("quantity")?).trim().to_owned();
    if unit.is_empty() || name.is_empty() {
        return Err(
            Trouble::from(row.refuse_row("the row says no quantity or no unit"))
                .with_hint("write 1 for a pure number"),
        );
    }
    let (unit, factor) = coherent(&unit);
    let si = |number: f64| factor * number;
    Ok(with_k(FiledQuantity {
        name,
        unit: unit.to_owned(),
        value: si(row.number(column("value")?)?),
        u: row.optional(columns.texts["u"])?.map(si),
        expanded: row.optional(columns.texts["U"])?.map(si),
        k,
        ..FiledQuantity::default()
    }))
}

/// u of U, where k is stated or is the usual 2; U of u is left open.
fn with_k(mut q: FiledQuantity) -> FiledQuantity {
    if let (None, Some(expanded)) = (q.u, q.expanded) {
        let k = q.k.unwrap_or(2.0);
        (q.u, q.k) = (Some(expanded / k), Some(k));
    }
    q
}

impl Records {
    /// Files every calibration of a spreadsheet. A standard that is named but not here is an error before anything is filed.
    ///
    /// # Errors
    /// As [`read_spreadsheet`]; the database refuses.
    pub fn add_spreadsheet(
        &mut self,
        source: Source,
        by: Option<&str>,
        today: &str,
    ) -> Result<Vec<Filed>> {
        let rows = read_spreadsheet(source)?;
        for (candidate, filing) in &rows {
            for standard in &filing.standard {
                self.device(standard)
                    .map_err(|t| t.detail(candidate.source.clone()))?;
            }
        }
        let filed = rows.into_iter().map(|(candidate, filing)| {
            let filing = Filing {
                by: by.map(str::to_owned),
                ..filing
            };
            self.file_candidate(&candidate, &filing, today)
        });
        filed.collect()
    }
}
