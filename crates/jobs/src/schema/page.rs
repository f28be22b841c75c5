//! The schemas as pages of the reference: a table of keys for each file or request and each table inside of it.

use super::FileSchema;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// What a page begins with.
const KEYS: &str = "# Keys\n\n\
Every key of every file that people write, and of the documents that proofmass writes. This page is made from the types that read them, as are the JSON schemas \
that editors take: `proofmass schema` lists them, `proofmass schema multi-position` prints one. A campaign whose first line is `#:schema ADDRESS`, as \
`proofmass init` writes it, is completed and checked while it is typed, by editors that know TOML schemas (Taplo, Even Better TOML). What keys are for is told in \
[campaigns](campaigns.md), [fixture](fixture.md), [uncertainty](uncertainty.md), [certificates](certificates.md) and [results](results.md); \
words are explained in the [glossary](glossary.md). A key in bold has to be there.\n";

const REQUESTS: &str = "# Requests\n\n\
A request is a job as JSON: what a program sends instead of typing a command (`AnyJob` of the crate `proofmass-jobs`; the example `server` takes them). Its key `job` \
says which. This page is made from the types that read them, as are their JSON schemas: `proofmass schema noise-request` prints one. A key in bold has to be there; \
words are explained in the [glossary](glossary.md).\n";

/// `docs/keys.md`.
pub fn keys_page(schemas: &[FileSchema]) -> String {
    let files: Vec<&FileSchema> = schemas.iter().filter(|s| !is_request(s)).collect();
    KEYS.to_owned() + &sections(&files)
}

/// `docs/requests.md`.
pub fn requests_page(schemas: &[FileSchema]) -> String {
    let requests: Vec<&FileSchema> = schemas.iter().filter(|s| is_request(s)).collect();
    REQUESTS.to_owned() + &sections(&requests)
}

fn is_request(schema: &FileSchema) -> bool {
    schema.name.ends_with("request")
}

/// Tables of a page by their headings, each with the schema that it comes from.
type Tables<'a> = BTreeMap<String, (&'a Value, &'a Value)>;

/// A section for each schema with the tables that it alone has; behind them those that several have.
fn sections(schemas: &[&FileSchema]) -> String {
    let mut used: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
    let mut tables = Tables::new();
    for schema in schemas {
        for (name, definition) in definitions(&schema.schema) {
            let name = heading(&name, definition, &tables);
            used.entry(name.clone()).or_default().insert(&schema.name);
            tables.insert(name, (definition, &schema.schema));
        }
    }
    let shared = |name: &str| used[name].len() > 1;
    let mut text = String::new();
    for schema in schemas {
        let root = &schema.schema;
        let _ = write!(text, "\n## `{}`\n\n{}.", schema.name, schema.title);
        if let Some(meaning) = root["description"].as_str() {
            let _ = write!(text, " {meaning}");
        }
        text.push_str("\n\n");
        let page = Page {
            tables: &tables,
            root,
        };
        page.keys(&mut text, root);
        for (name, definition) in definitions(root) {
            let name = heading(&name, definition, &tables);
            if !shared(&name) {
                page.table(&mut text, &name, definition);
            }
        }
    }
    if tables.keys().any(|name| shared(name)) {
        text.push_str("\n## Tables that several have\n");
    }
    for (name, (definition, root)) in tables.iter().filter(|(name, _)| shared(name)) {
        Page {
            tables: &tables,
            root,
        }
        .table(&mut text, name, definition);
    }
    text
}

/// The tables inside of a schema: definitions with keys.
fn definitions(schema: &Value) -> impl Iterator<Item = (String, &Value)> {
    let definitions = schema["$defs"].as_object().into_iter().flatten();
    definitions
        .filter(|(_, definition)| has_keys(definition))
        .map(|(name, definition)| (name.clone(), definition))
}

/// The name of a table on the page: its own, with a number where another table has it.
fn heading(name: &str, definition: &Value, tables: &Tables) -> String {
    let own = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let numbered = std::iter::once(own.to_owned()).chain((2..).map(|k| format!("{own} {k}")));
    let mut free = numbered.filter(|n| tables.get(n).is_none_or(|(t, _)| *t == definition));
    free.next().unwrap_or_default()
}

/// Whether a definition is a table with keys, or a choice among such.
fn has_keys(definition: &Value) -> bool {
    definition["properties"].is_object() || !forms_with_keys(definition).is_empty()
}

fn forms_with_keys(schema: &Value) -> Vec<&Value> {
    let forms = ["oneOf", "anyOf"]
        .iter()
        .filter_map(|k| schema[*k].as_array())
        .flatten();
    forms
        .filter(|form| form["properties"].is_object())
        .collect()
}

struct Page<'a> {
    tables: &'a Tables<'a>,
    root: &'a Value,
}

impl Page<'_> {
    fn table(&self, text: &mut String, name: &str, definition: &Value) {
        let _ = write!(text, "\n### {name}\n\n");
        if let Some(meaning) = definition["description"].as_str() {
            let _ = write!(text, "{meaning}\n\n");
        }
        self.keys(text, definition);
    }

    /// The keys of a table, or of each form that it can have.
    fn keys(&self, text: &mut String, schema: &Value) {
        if !has_keys(schema) {
            return;
        }
        text.push_str("| key | value | meaning |\n|---|---|---|\n");
        self.rows(text, schema, None);
        for form in forms_with_keys(schema) {
            self.rows(text, form, form["description"].as_str());
        }
    }

    /// A row for each key; one without a meaning of its own has that of its form.
    fn rows(&self, text: &mut String, schema: &Value, form: Option<&str>) {
        let needed = schema["required"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_str);
        let needed: BTreeSet<&str> = needed.collect();
        for (key, value) in schema["properties"].as_object().into_iter().flatten() {
            let bold = if needed.contains(key.as_str()) {
                "**"
            } else {
                ""
            };
            let mut meaning = cell(value["description"].as_str().or(form).unwrap_or_default());
            let default = &value["default"];
            let empty = default.as_array().is_some_and(Vec::is_empty);
            if !(default.is_null() || default.is_object() || empty) {
                let _ = write!(meaning, " Default: `{}`.", bare(default));
            }
            let _ = writeln!(
                text,
                "| {bold}`{key}`{bold} | {} | {} |",
                cell(&self.kind(value)),
                meaning.trim()
            );
        }
    }

    /// What a value is, in words.
    fn kind(&self, schema: &Value) -> String {
        let list = |key: &str| schema[key].as_array();
        if let Some(name) = schema["$ref"].as_str().and_then(|r| r.rsplit('/').next()) {
            let definition = &self.root["$defs"][name];
            if !has_keys(definition) {
                return self.kind(definition);
            }
            let heading = heading(name, definition, self.tables);
            let anchor = heading.to_lowercase().replace(' ', "-");
            return format!("[{heading}](#{anchor})");
        }
        if let Some(word) = schema.get("const") {
            return format!("`{}`", bare(word));
        }
        if let Some(words) = list("enum") {
            let words: Vec<String> = words
                .iter()
                .filter(|w| !w.is_null())
                .map(|w| format!("`{}`", bare(w)))
                .collect();
            return words.join(", ");
        }
        if let Some(forms) = list("oneOf").or_else(|| list("anyOf")) {
            let forms = forms.iter().filter(|f| f["type"] != "null");
            let mut forms: Vec<String> = forms.map(|f| self.kind(f)).collect();
            forms.dedup();
            return forms.join(", ");
        }
        let types: Vec<&str> = match &schema["type"] {
            Value::String(one) => vec![one],
            Value::Array(several) => several
                .iter()
                .filter_map(Value::as_str)
                .filter(|t| *t != "null")
                .collect(),
            _ => Vec::new(),
        };
        match types[..] {
            ["array"] => {
                let items = &schema["items"];
                let of = if items.is_object() {
                    self.kind(items)
                } else {
                    "any".to_owned()
                };
                match (list("prefixItems"), schema["minItems"].as_u64()) {
                    (Some(items), _) => format!("list of {}", items.len()),
                    (None, Some(n)) if schema["maxItems"].as_u64() == Some(n) => {
                        format!("list of {n}: {of}")
                    }
                    _ => format!("list: {of}"),
                }
            }
            ["object"] => match &schema["additionalProperties"] {
                of @ Value::Object(_) => format!("by name: {}", self.kind(of)),
                _ => "table".to_owned(),
            },
            ["string"] => "text".to_owned(),
            ["integer"] => "whole number".to_owned(),
            ["boolean"] => "`true`, `false`".to_owned(),
            [] => "any".to_owned(),
            ref several => several.join(", "),
        }
    }
}

/// A word or a number without quotes.
fn bare(value: &Value) -> String {
    value
        .as_str()
        .map_or_else(|| value.to_string(), str::to_owned)
}

/// As a cell of a table has it.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}
