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
use proofmass_report::{Report, Section, html};

/// Writes the pages: index.html with the devices, due.html, and one for each device or standard.
///
/// # Errors
/// The database or the place refuses.
pub fn write(records: &mut Records, sink: &dyn Sink, today: &str) -> Result<()> {
    let put = |name: String, page: Report| -> Result<()> {
        sink.write(&name, html::render(&page)?.into_bytes())?;
        Ok(())
    };
    let mut index = list(records, false, today)?;
    index = index.section(Section::new("Pages").paragraph(
        "due.html has what is due; device-N.html has the device or standard with the number N.",
    ));
    put("index.html".to_owned(), index)?;
    put("due.html".to_owned(), due(records, today, 366)?)?;
    for row in records.devices(false)? {
        let mut page = device(records, row.number, today)?;
        if row.results > 0 {
            let history = history(records, row.number, None)?;
            page = page.findings(history_findings(records, row.number)?);
            page.sections.extend(history.sections);
        }
        put(format!("device-{}.html", row.number), page)?;
    }
    Ok(())
}

fn history_findings(
    records: &mut Records,
    device: i64,
) -> Result<Vec<proofmass_uncertainty::Finding>> {
    Ok(records
        .history(device)?
        .into_iter()
        .flat_map(|h| h.findings)
        .collect())
}
