//! Writes `docs/findings.md` from the catalogue of findings.

fn main() -> std::io::Result<()> {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/findings.md");
    std::fs::write(page, proofmass_jobs::findings::page())
}
