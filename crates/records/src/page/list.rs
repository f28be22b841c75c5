//! Devices and standards, and what is due.

use super::cells::{date, device, number};
use crate::day::day_of;
use crate::device::DeviceRow;
use crate::due::Due;
use crate::ledger::Records;
use proofmass_jobs::Result;
use proofmass_report::{Field, Report, Section, Table};

/// Every device, or the standards alone, with what is overdue.
///
/// # Errors
/// The database refuses, or `today` is no date.
pub fn list(records: &mut Records, standards_alone: bool, today: &str) -> Result<Report> {
    let day = day_of(today)?;
    let devices = records.devices(standards_alone)?;
    let over = devices
        .iter()
        .filter(|d| d.due.is_some_and(|due| due < day))
        .count();
    let verdict = match over {
        0 => "Nothing is overdue.".to_owned(),
        1 => "One device or standard is overdue.".to_owned(),
        n => format!("{n} devices and standards are overdue."),
    };
    Ok(Report::new("Devices")
        .subtitle(format!(
            "{} devices and standards on {today}",
            devices.len()
        ))
        .question(verdict)
        .section(
            Section::new("Devices")
                .table(device_table(&devices, day))
                .summarised(),
        ))
}

fn device_table(devices: &[DeviceRow], today: i64) -> Table {
    let fields = [
        Field::new("number", |d: &DeviceRow| number(d.number)).page("no.", ""),
        Field::new("device", |d: &DeviceRow| device(d.number, &d.name)).page("device", ""),
        Field::new("owner_number", |d: &DeviceRow| {
            d.owner_number.clone().into()
        })
        .page("owner's no.", ""),
        Field::shown("kind", "", |d: &DeviceRow| {
            if d.standard { "standard" } else { "device" }.into()
        }),
        Field::new("calibrations", |d: &DeviceRow| number(d.results)).page("calibrations", ""),
        Field::new("last", |d: &DeviceRow| date(d.last)).page("last", ""),
        Field::new("due", |d: &DeviceRow| date(d.due)).page("due", ""),
        Field::shown("state", "", move |d: &DeviceRow| {
            match (d.due, d.last) {
                (Some(due), _) if due < today => "OVERDUE",
                (_, None) => "never calibrated",
                _ => "",
            }
            .into()
        }),
    ];
    Table::of("", fields, devices).file("devices.csv")
}

/// What is due within so many days, with the rule of each.
///
/// # Errors
/// The database refuses, or `today` is no date.
pub fn due(records: &mut Records, today: &str, within: i64) -> Result<Report> {
    let day = day_of(today)?;
    let due = records.due(day + within)?;
    let over = due.iter().filter(|d| d.is_over(day)).count();
    let fields = [
        Field::new("device", |d: &Due| device(d.device, &d.name)).page("device", ""),
        Field::new("number", |d: &Due| number(d.device)).page("no.", ""),
        Field::new("due", |d: &Due| date(Some(d.day))).page("due", ""),
        Field::new("days", move |d: &Due| number(d.day - day)).page("in", "d"),
        Field::shown("state", "", move |d: &Due| {
            if d.is_over(day) { "OVERDUE" } else { "" }.into()
        }),
        Field::new("evidence", |d: &Due| d.evidence.as_str().into()).page("by the rule", ""),
    ];
    let table = Table::of("", fields, &due).file("due.csv");
    Ok(Report::new("Due")
        .subtitle(format!("within {within} days of {today}"))
        .question(format!("{} due, {over} of them overdue.", due.len()))
        .section(Section::new("Due").table(table).summarised()))
}
