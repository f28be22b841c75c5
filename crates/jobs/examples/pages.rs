//! Writes `docs/findings.md` from the catalogue of findings, `docs/errors.md` from the codes of errors, and `docs/units.md` from the units
//! that are understood.

use std::path::Path;

fn main() -> std::io::Result<()> {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    std::fs::write(docs.join("findings.md"), proofmass_jobs::findings::page())?;
    std::fs::write(docs.join("errors.md"), proofmass_jobs::errors_page())?;
    std::fs::write(docs.join("units.md"), proofmass_jobs::units::page())
}
