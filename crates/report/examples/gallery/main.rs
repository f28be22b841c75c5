//! Every kind of block and plot, with invented numbers and the edge cases that break layouts.
//!
//! `cargo run -p proofmass-report --example gallery [FILE]` writes the page (`gallery.html` if no name is given)
//! and prints the terminal form.

mod content;

use proofmass_report::{html, terminal};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let report = content::report()?;
    let file = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "gallery.html".into());
    std::fs::write(&file, html::render(&report)?)?;
    let options = terminal::Options {
        width: 100,
        colour: false,
        filed: true,
        details: true,
    };
    print!("{}", terminal::render(&report, &options)?);
    Ok(())
}
