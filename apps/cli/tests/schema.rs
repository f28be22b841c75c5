//! JSON schemas: those that the program prints are those of the types that it reads.

use crate::support::{proofmass, stderr, succeed};
use proofmass_jobs::schema::{keys_page, requests_page, schemas};

/// A key of a file or a request that is new, gone or of another type changes its schema. The files are written anew by
/// `cargo run -p proofmass-jobs --features schema --example schemas`.
#[test]
fn law_the_schemas_are_those_of_the_types() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas");
    let made = schemas();
    for schema in &made {
        let file = folder.join(format!("{}.json", schema.name));
        let text = std::fs::read_to_string(&file).unwrap_or_default();
        assert!(
            text == schema.text(),
            "{} is not what the types say: write it anew, as above",
            file.display()
        );
    }
    let pages = folder.join("../tests/data");
    for (page, text) in [
        ("keys.md", keys_page(&made)),
        ("requests.md", requests_page(&made)),
    ] {
        let written = std::fs::read_to_string(pages.join(page)).unwrap_or_default();
        assert!(
            written == text,
            "docs/{page} is not what the types say: write it anew, as above"
        );
    }
    assert_eq!(
        std::fs::read_dir(&folder).unwrap().count(),
        made.len(),
        "a file without a type"
    );
    // The list of the command is complete, in their order, with a title each.
    let list = String::from_utf8(succeed(&["schema"]).stdout).unwrap();
    let listed: Vec<(&str, &str)> = list
        .lines()
        .filter_map(|line| line.split_once("  "))
        .map(|(n, t)| (n, t.trim()))
        .collect();
    let wanted: Vec<(&str, &str)> = made
        .iter()
        .map(|s| (s.name.as_str(), s.title.as_str()))
        .collect();
    assert_eq!(listed, wanted);
    let printed = succeed(&["schema", "multi-position"]).stdout;
    assert_eq!(String::from_utf8(printed).unwrap(), made[1].text());
}

#[test]
fn a_schema_that_there_is_not_is_refused_with_the_nearest() {
    let output = proofmass(&["schema", "multi-positon"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("'multi-position'"),
        "{}",
        stderr(&output)
    );
}

/// Editors take keys and meanings from it, so that a key without a meaning is one that nobody is told about.
#[test]
fn law_every_key_has_a_meaning() {
    let mut without = Vec::new();
    for schema in &schemas() {
        let root = std::iter::once(("", &schema.schema));
        let inner = schema.schema["$defs"]
            .as_object()
            .into_iter()
            .flatten()
            .map(|(name, s)| (name.as_str(), s));
        for (name, of) in root.chain(inner) {
            for (key, of) in of["properties"].as_object().into_iter().flatten() {
                // Its own, or that of the type that it has.
                let named = of["$ref"].as_str().and_then(|r| r.rsplit('/').next());
                let behind = named.map(|name| &schema.schema["$defs"][name]["description"]);
                let told = !of["description"].is_null() || behind.is_some_and(|d| !d.is_null());
                if !told && of["const"].is_null() {
                    without.push(format!("{} {name}.{key}", schema.name));
                }
            }
        }
    }
    assert!(
        without.is_empty(),
        "{} keys without a meaning:\n{}",
        without.len(),
        without.join("\n")
    );
}
