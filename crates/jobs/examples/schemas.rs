//! The JSON schemas of all files and requests, made from the types that read them.
//!
//! `schemas` writes them into apps/cli/schemas and their pages into docs; `schemas --take` says of documents on standard input, a line
//! `{"schema": NAME, "document": …}` each, whether the program takes them: a line with nothing, or why not.

use proofmass_jobs::schema::{FileSchema, keys_page, requests_page, schemas};
use serde_json::Value;
use std::io::{BufRead, Write};
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let schemas = schemas();
    match std::env::args().nth(1).as_deref() {
        Some("--take") => take(&schemas),
        _ => write(&schemas),
    }
}

fn take(schemas: &[FileSchema]) -> Result<(), Box<dyn std::error::Error>> {
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    for line in std::io::stdin().lock().lines() {
        let asked: Value = serde_json::from_str(&line?)?;
        let schema = schemas.iter().find(|s| asked["schema"] == s.name.as_str());
        let schema = schema.ok_or_else(|| format!("there is no schema {}", asked["schema"]))?;
        let why = (schema.takes)(&asked["document"]).err().unwrap_or_default();
        writeln!(out, "{}", why.replace('\n', " "))?;
    }
    Ok(())
}

fn write(schemas: &[FileSchema]) -> Result<(), Box<dyn std::error::Error>> {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for schema in schemas {
        let file = format!("apps/cli/schemas/{}.json", schema.name);
        std::fs::write(workspace.join(file), schema.text())?;
        // As apps/cli/src/schema.rs lists them.
        println!("    {:?},", schema.name);
    }
    std::fs::write(workspace.join("docs/keys.md"), keys_page(schemas))?;
    std::fs::write(workspace.join("docs/requests.md"), requests_page(schemas))?;
    Ok(())
}
