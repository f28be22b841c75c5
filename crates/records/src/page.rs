//! Pages of the records: the list, a device, a standard, what is due, a recall, a check. Made of the blocks of every report.

mod cells;
mod check;
mod device;
mod history;
mod list;
mod recall;
mod result;

pub use check::{check, recomputed};
pub use device::device;
pub use history::history;
pub use list::{due, list};
pub use recall::recall;
pub use result::result;

use crate::ledger::Records;
use proofmass_jobs::{Result, Sink};
use proofmass_report::{Cell, Column, Report, Section, Table, html};

/// Writes the pages: index.html with the devices, due.html, and one for each device or standard.
///
/// # Errors
/// The database or the place refuses.
pub fn write(records: &mut Records, sink: &dyn Sink, today: &str) -> Result<()> {
    let put = |name: String, page: Report| -> Result<()> {
        sink.write(&name, html::render(&page)?.into_bytes())?;
        Ok(())
    };
    let leads = |text: &str, page: &str| {
        let table = Table::new("", [Column::text("")]).row([Cell::linked(text, page)]);
        Section::new("Other pages").table(table).summarised()
    };
    let index = list(records, false, today)?.section(leads("What is due", "due.html"));
    put("index.html".to_owned(), index)?;
    let back = || leads("Devices and standards", "index.html");
    put(
        "due.html".to_owned(),
        due(records, today, 366)?.section(back()),
    )?;
    for row in records.devices(false)? {
        let mut page = device(records, row.number, today)?;
        if row.results > 0 {
            let found = records.history(row.number)?;
            let told = history::of(&row.name, &found);
            page = page.findings(found.into_iter().flat_map(|h| h.findings));
            page.answer.figure = told.answer.figure;
            page.sections.extend(told.sections);
        }
        put(format!("device-{}.html", row.number), page.section(back()))?;
    }
    Ok(())
}
