//! Writes the exported constants that `tests/filters.rs` and `tests/chain.rs` compile: `cargo run -p proofmass-example-c --example exported`.

use proofmass_documents::{ExportForm, ExportNumber, ExportOptions, export_block, export_chain};
use proofmass_example_c::{chain, chained, filters};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/exported"));
    std::fs::create_dir_all(folder)?;
    for (name, block) in filters()? {
        let mut options = ExportOptions::default();
        options.name = Some(name.to_owned());
        options.number = if name == "mean" {
            ExportNumber::Double
        } else {
            ExportNumber::Float
        };
        let text = export_block(&block, ExportForm::Rust, &options)?;
        std::fs::write(folder.join(format!("{name}.rs")), text)?;
    }
    let mut options = ExportOptions::default();
    options.name = Some("chain".to_owned());
    options.number = ExportNumber::Double;
    let text = export_chain(&chained()?, &chain(), ExportForm::Rust, &options)?;
    std::fs::write(folder.join("chain.rs"), text)?;
    Ok(())
}
