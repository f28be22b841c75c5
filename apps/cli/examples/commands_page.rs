//! Writes `docs/commands.md` from the declaration of the commands.

fn main() -> std::io::Result<()> {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/commands.md");
    std::fs::write(page, proofmass_cli::reference())
}
