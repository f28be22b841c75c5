//! The page of all tables that results write, held against results of every kind.

use crate::WALKED;
use proofmass_jobs::StoredResult;
use serde_json::Value;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// A column as the page lists it: its names in the file, and how the page of the result heads it.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Listed {
    names: String,
    heading: String,
}

/// The tables of one kind of job: file, caption, columns.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Tables(Vec<(String, String, Vec<Listed>)>);

thread_local! {
    /// Tables of the results that this thread has checked, by kind of result.
    static SEEN: RefCell<BTreeMap<String, Tables>> = const { RefCell::new(BTreeMap::new()) };
}

/// Remembers the tables of a result.
pub fn remember(kind: &str, result: &StoredResult) {
    let report = serde_json::to_value(result.report()).expect("JSON");
    SEEN.with_borrow_mut(|seen| gather(&report, seen.entry(kind.to_owned()).or_default()));
}

fn gather(value: &Value, tables: &mut Tables) {
    match value {
        Value::Object(map) => {
            if let (Some(file), Some(Value::Array(columns))) = (map.get("file"), map.get("columns"))
            {
                let caption = map.get("caption").and_then(Value::as_str);
                let file = file.as_str().unwrap_or_default();
                tables.add(file, caption.unwrap_or_default(), columns);
            }
            map.values().for_each(|v| gather(v, tables));
        }
        Value::Array(list) => list.iter().for_each(|v| gather(v, tables)),
        _ => {}
    }
}

impl Tables {
    fn add(&mut self, file: &str, caption: &str, columns: &[Value]) {
        // A file of which there are several is one table of the page.
        let at = self.0.iter().position(|(f, ..)| f == file);
        let at = at.unwrap_or_else(|| {
            self.0.push((file.into(), caption.into(), Vec::new()));
            self.0.len() - 1
        });
        let text = |c: &Value, key: &str| c[key].as_str().unwrap_or_default().to_owned();
        for column in columns {
            let (name, u) = (text(column, "name"), text(column, "uncertainty"));
            if name.is_empty() {
                continue;
            }
            let (heading, unit) = (text(column, "heading"), text(column, "unit"));
            let listed = Listed {
                names: match u.is_empty() {
                    true => format!("`{name}`"),
                    false => format!("`{name}`, `{u}`"),
                },
                heading: match unit.is_empty() {
                    true => heading,
                    false => format!("{heading} in {unit}"),
                }
                .replace('|', "\\|"),
            };
            let columns = &mut self.0[at].2;
            if !columns.iter().any(|c| c.names == listed.names) {
                columns.push(listed);
            }
        }
    }

    fn text(&self, job: &str) -> String {
        let mut text = format!("## {job}\n");
        for (file, caption, columns) in &self.0 {
            let caption = match caption.is_empty() {
                true => String::new(),
                false => format!(": {caption}"),
            };
            text += &format!("\n`{file}`{caption}\n\n| column | on the page |\n|---|---|\n");
            for Listed { names, heading } in columns {
                text += &format!("| {names} | {heading} |\n");
            }
        }
        text
    }
}

fn page() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/tables.md")
}

/// The page lists what the results of a kind write. With `PROOFMASS_WRITE_PAGES` set, the page is written instead.
pub fn law_page(job: &str, kind: &str) {
    let tables = SEEN.take().remove(kind).unwrap_or_default();
    let section = match tables.0.is_empty() {
        true => String::new(),
        false => tables.text(job),
    };
    if writes() {
        return write(job, &section);
    }
    let written = std::fs::read_to_string(page()).expect("docs/tables.md");
    let (_, sections) = parts(&written);
    let found = sections.get(job).map_or("", String::as_str).trim();
    assert!(
        found == section.trim(),
        "docs/tables.md does not list what {job} writes: run `PROOFMASS_WRITE_PAGES=1 cargo test --workspace --test every_job`\n{section}"
    );
}

fn writes() -> bool {
    std::env::var_os("PROOFMASS_WRITE_PAGES").is_some()
}

/// What stands before the first job, and the section of each.
fn parts(text: &str) -> (&str, BTreeMap<String, String>) {
    let mut sections = text.split("\n## ");
    let head = sections.next().unwrap_or_default();
    let named = sections.filter_map(|s| Some((s.lines().next()?.to_owned(), format!("## {s}"))));
    (head, named.collect())
}

fn write(job: &str, section: &str) {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _alone = ONE_AT_A_TIME.lock().expect("no writer failed");
    let text = std::fs::read_to_string(page()).expect("docs/tables.md");
    let (head, mut sections) = parts(&text);
    sections.insert(job.to_owned(), section.to_owned());
    let ordered = WALKED.iter().filter_map(|(job, _)| sections.get(*job));
    let sections: Vec<&str> = ordered
        .map(|s| s.trim())
        .filter(|s| !s.is_empty())
        .collect();
    let text = format!("{}\n\n{}\n", head.trim_end(), sections.join("\n\n"));
    std::fs::write(page(), text).expect("docs/tables.md is written");
}

/// No table and no column is declared that no result of these tests has.
#[test]
fn law_every_declared_column_is_listed() {
    if writes() {
        return;
    }
    let listed = std::fs::read_to_string(page()).expect("docs/tables.md");
    let listed: BTreeSet<&str> = listed.split('`').skip(1).step_by(2).collect();
    let mut missing = BTreeSet::new();
    for file in sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src")) {
        let text = std::fs::read_to_string(&file).expect("a source");
        for call in ["Field::new(", "Field::estimate(", ".file("] {
            for rest in text.split(call).skip(1) {
                let names = rest.trim_start().strip_prefix('"');
                let name = names.and_then(|n| n.split('"').next()).unwrap_or_default();
                if !name.is_empty() && !name.contains('{') && !listed.contains(name) {
                    missing.insert(format!("{name} of {}", file.display()));
                }
            }
        }
    }
    let missing: Vec<String> = missing.into_iter().collect();
    assert!(
        missing.is_empty(),
        "{} columns on no page:\n{}",
        missing.len(),
        missing.join("\n")
    );
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("sources");
    let paths = entries.map(|e| e.expect("an entry").path());
    paths
        .flat_map(|path| match path.is_dir() {
            true => sources(&path),
            false => vec![path],
        })
        .collect()
}
