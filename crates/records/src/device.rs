//! Devices: found by what people call them.

use crate::day::as_date;
use crate::engine::Value;
use crate::entry::{Content, FiledDevice, spelling};
use crate::ledger::Records;
use crate::schema::CALIBRATIONS;
use proofmass_jobs::{Result, Trouble};
use serde::Serialize;

/// A device in a list.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct DeviceRow {
    /// Its number here.
    pub number: i64,
    /// Maker, type and serial number, or the owner's number.
    pub name: String,
    /// The owner's number.
    pub owner_number: Option<String>,
    /// Whether it is a reference standard.
    pub standard: bool,
    /// Calibrations that count.
    pub results: i64,
    /// Day of the last one, or from which its last certificate is valid; days from 1970-01-01.
    #[serde(serialize_with = "as_date::option")]
    pub last: Option<i64>,
    /// Day on which it is due, days from 1970-01-01.
    #[serde(serialize_with = "as_date::option")]
    pub due: Option<i64>,
}

/// Maker, type, serial number and the owner's number of a row in a line.
pub(crate) fn line(row: &[Value]) -> String {
    let text = |i: usize| row[i].text().map(str::to_owned);
    let device = FiledDevice {
        manufacturer: text(0),
        model: text(1),
        serial: text(2),
        owner_number: text(3),
        ..Default::default()
    };
    device.line()
}

impl Records {
    /// Every device, or every standard, in the order of their numbers.
    ///
    /// # Errors
    /// The database refuses.
    pub fn devices(&mut self, standards_alone: bool) -> Result<Vec<DeviceRow>> {
        let rows = self.engine.rows(
            &format!("SELECT device.entry, manufacturer, model, serial, owner_number, device.standard, calibrated.number, calibrated.last, due.day, certified.last
             FROM device
             LEFT JOIN (SELECT device, count(*) AS number, max(day) AS last FROM {CALIBRATIONS} GROUP BY device) AS calibrated
               ON calibrated.device = device.entry
             LEFT JOIN (SELECT standard, max(valid_from) AS last FROM certificate GROUP BY standard) AS certified
               ON certified.standard = device.entry
             LEFT JOIN due ON due.device = device.entry
             WHERE device.standard >= ?1 ORDER BY device.entry"),
            &[i64::from(standards_alone).into()],
        )?;
        let devices = rows.iter().map(|row| DeviceRow {
            number: row[0].integer().unwrap_or_default(),
            name: line(&row[1..5]),
            owner_number: row[4].text().map(str::to_owned),
            standard: row[5].integer() == Some(1),
            results: row[6].integer().unwrap_or_default(),
            last: row[7].integer().max(row[9].integer()),
            due: row[8].integer(),
        });
        Ok(devices.collect())
    }

    /// The number of a device of the same maker, type and numbers, where it is here already.
    ///
    /// # Errors
    /// The database refuses.
    pub fn same_device(&mut self, device: &FiledDevice) -> Result<Option<i64>> {
        let rows = self.engine.rows(
            "SELECT entry FROM device WHERE coalesce(serial, '') = ?1 AND coalesce(owner_number, '') = ?2
                AND coalesce(manufacturer, '') = ?3 AND coalesce(model, '') = ?4",
            &[&device.serial, &device.owner_number, &device.manufacturer, &device.model]
                .map(|word| word.as_deref().unwrap_or_default().into()),
        )?;
        Ok(rows.first().and_then(|row| row[0].integer()))
    }

    /// The device that is called so: its number here, the owner's number, or its serial number, also with the type before it.
    ///
    /// # Errors
    /// No such device, or several.
    pub fn device(&mut self, called: &str) -> Result<i64> {
        let called = called.trim();
        if let Some(number) = called.strip_prefix('#') {
            let number: i64 = number.parse().map_err(|_| {
                Trouble::request(format!("{called:?} is no number of a device"))
                    .with_hint("write it as in #12, or give the serial number")
            })?;
            self.filed_device(number)?;
            return Ok(number);
        }
        let rows = self.engine.rows(
            "SELECT entry, manufacturer, model, serial, owner_number FROM device WHERE serial = ?1 OR owner_number = ?1 ORDER BY entry",
            &[called.into()],
        )?;
        let mut found: Vec<(i64, String)> = rows.iter().map(|row| named(row)).collect();
        if found.is_empty() {
            // The end of the words is the serial number.
            let last = called.rsplit(' ').next().unwrap_or_default();
            let rows = self.engine.rows(
                "SELECT entry, manufacturer, model, serial, owner_number FROM device WHERE serial = ?1 OR spelling = ?2 ORDER BY entry",
                &[last.into(), (&spelling(called)).into()],
            )?;
            found = rows.iter().map(|row| named(row)).collect();
            if found.len() > 1 {
                let exact: Vec<_> = found
                    .iter()
                    .filter(|(_, name)| name.ends_with(called))
                    .cloned()
                    .collect();
                found = if exact.is_empty() { found } else { exact };
            }
        }
        match &found[..] {
            [(number, _)] => Ok(*number),
            [] => Err(Trouble::request(format!("no device is called {called:?}"))
                .with_hint("`proofmass records list` has serial numbers, owner's numbers and the numbers here; `records add device` adds one")),
            several => {
                let list: Vec<String> = several.iter().map(|(n, name)| format!("{n} ({name})")).collect();
                Err(Trouble::request(format!("several devices are called {called:?}"))
                    .detail(list.join(", "))
                    .with_hint("name one by its number here, such as #12"))
            }
        }
    }

    /// What is filed of a device.
    ///
    /// # Errors
    /// There is no device of this number.
    pub fn filed_device(&mut self, number: i64) -> Result<FiledDevice> {
        match self.entry(number)?.content {
            Content::Device(device) => Ok(device),
            _ => Err(Trouble::request(format!("entry {number} is no device"))
                .with_hint("`proofmass records list` has the devices")),
        }
    }
}

fn named(row: &[Value]) -> (i64, String) {
    (row[0].integer().unwrap_or_default(), line(&row[1..5]))
}
