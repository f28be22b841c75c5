//! JSON schemas (draft 2020-12) of the files that people write and programs read, made from the types that read them.

mod page;

pub use page::{keys_page, requests_page};

use crate::StoredResult;
use crate::any_job::{AnyJob, request_schemas};
use crate::campaign::{campaign_schemas, schema_address};
use crate::certificate::CertificateFile;
use crate::data_sheet::DataSheet;
use crate::modes::modes_schema;
use crate::stored_result::result_extra_schemas;
use proofmass_documents::{
    AnyCalibration, CALIBRATION_SCHEMA, CALIBRATION_VERSION, CalibrationFile, FREQUENCY_RESPONSE,
    FrequencyResponseFile, RESULT_VERSION, ResultDocument, SINGLE_AXIS, TRIAXIAL,
};
use proofmass_io::{
    MANIFEST_SCHEMA, MANIFEST_VERSION, Manifest, PROVENANCE_SCHEMA, PROVENANCE_VERSION, Provenance,
    RESULT_SCHEMA,
};
use proofmass_uncertainty::{BudgetEntries, UncertaintyModel};
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};
use std::fmt::Display;

/// The schema of one kind of file or request.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FileSchema {
    /// Name, such as `multi-position`, `result` or `noise-request`.
    pub name: String,
    /// What it is the schema of.
    pub title: String,
    /// The schema.
    pub schema: Value,
    /// Whether the type behind it takes the document, or why not. What a job refuses later is no part of it.
    pub takes: fn(&Value) -> Result<(), String>,
}

impl FileSchema {
    /// The text of the file that holds it.
    pub fn text(&self) -> String {
        format!("{:#}\n", self.schema)
    }
}

/// A type that is read from a file: its schema, and whether it takes a document.
pub(crate) struct Readable {
    schema: Schema,
    takes: fn(&Value) -> Result<(), String>,
}

impl Readable {
    pub(crate) fn of<T: JsonSchema + DeserializeOwned>() -> Self {
        Self {
            schema: generator().into_root_schema_for::<T>(),
            takes: |document| said(T::deserialize(document)),
        }
    }

    /// A request, which is read with its kind.
    pub(crate) fn request<T: JsonSchema>() -> Self {
        Self {
            schema: generator().into_root_schema_for::<T>(),
            takes: |document| said(AnyJob::from_json(document.to_string().as_bytes())),
        }
    }
}

/// Nothing, or why something could not be read.
fn said<T, E: Display>(read: Result<T, E>) -> Result<(), String> {
    read.map(|_| ()).map_err(|e| e.to_string())
}

/// Every schema: campaigns by kind and of any kind, the other files of a user, documents of results, requests by job and of any job.
///
/// ```
/// let schemas = proofmass_jobs::schema::schemas();
/// let noise = schemas.iter().find(|s| s.name == "noise-request").unwrap();
/// assert_eq!(noise.schema["properties"]["job"]["const"], "noise");
/// ```
pub fn schemas() -> Vec<FileSchema> {
    let mut all = Vec::new();
    let campaigns = campaign_schemas();
    all.push(one_of(
        "campaign",
        "A campaign of any kind",
        ("kind", ""),
        &campaigns,
        |_| Ok(()),
    ));
    for (kind, readable) in campaigns {
        let title = format!("A campaign of the kind {kind}");
        all.push(tagged(kind.to_owned(), title, ("kind", kind), readable));
    }
    for (name, title, readable) in [
        (
            "budget",
            "A budget file of a campaign on the shaker",
            Readable::of::<BudgetEntries>(),
        ),
        ("modes", "A fixture for proofmass modes", modes_schema()),
        (
            "model",
            "A model for proofmass uncertainty",
            Readable::of::<UncertaintyModel>(),
        ),
        (
            "limits",
            "device.toml, the data sheet of a device for proofmass device check, or limits for proofmass noise compare",
            Readable::of::<DataSheet>(),
        ),
        (
            "laboratory",
            "LAB.toml, the laboratory of certificates, or ORDER.toml, one certificate",
            Readable::of::<CertificateFile>(),
        ),
    ] {
        all.push(file(name.to_owned(), title.to_owned(), readable));
    }
    all.push(result());
    all.push(calibration());
    let manifest = Readable {
        takes: |document| said(Manifest::from_json(document.to_string().as_bytes())),
        ..Readable::of::<Manifest>()
    };
    let form = (MANIFEST_SCHEMA, &[MANIFEST_VERSION][..]);
    let title = "manifest.json, the files of a folder that one run wrote";
    all.push(document("manifest", title, form, manifest));
    let provenance = Readable {
        takes: |document| said(Provenance::from_json(document.to_string().as_bytes())),
        ..Readable::of::<Provenance>()
    };
    let form = (PROVENANCE_SCHEMA, &[PROVENANCE_VERSION][..]);
    let title = "….provenance.json, what a file beside it was written from";
    all.push(document("provenance", title, form, provenance));
    let requests = request_schemas();
    let any = |document: &Value| said(AnyJob::from_json(document.to_string().as_bytes()));
    all.push(one_of(
        "request",
        "A request of any job",
        ("job", "-request"),
        &requests,
        any,
    ));
    for (job, readable) in requests {
        let title = format!("A request of the job {job}");
        let mut request = tagged(format!("{job}-request"), title, ("job", job), readable);
        close(&mut request.schema);
        all.push(request);
    }
    all
}

fn generator() -> SchemaGenerator {
    SchemaSettings::draft2020_12()
        .with_transform(RecursiveTransform(plain))
        .into_generator()
}

/// Without what only a reader of the source understands: widths of numbers, links and examples in Rust; of a meaning its first paragraph.
fn plain(schema: &mut Schema) {
    let Some(object) = schema.as_object_mut() else {
        return;
    };
    object.remove("format");
    if let Some(Value::String(text)) = object.get("description") {
        let paragraph = text.split("\n\n").next().unwrap_or_default();
        let mut words = String::new();
        let mut rest = paragraph.split("```").next().unwrap_or_default();
        // [`Name`] and [`Name`](path) become `Name`.
        while let Some((before, link)) = rest.split_once("[`") {
            let (name, after) = link.split_once("`]").unwrap_or((link, ""));
            words += before;
            words += &format!("`{name}`");
            rest = match after
                .strip_prefix('(')
                .and_then(|path| path.split_once(')'))
            {
                Some((_, after)) => after,
                None => after,
            };
        }
        words += rest;
        let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
        object.insert("description".to_owned(), Value::String(words));
    }
}

fn file(name: String, title: String, readable: Readable) -> FileSchema {
    let mut head = Map::new();
    head.insert(
        "$schema".to_owned(),
        json!("https://json-schema.org/draft/2020-12/schema"),
    );
    head.insert("$id".to_owned(), json!(schema_address(&name)));
    head.insert("title".to_owned(), json!(title));
    for (key, value) in readable.schema.as_object().into_iter().flatten() {
        // What the type is called in the source is no title.
        head.entry(key.clone()).or_insert_with(|| value.clone());
    }
    FileSchema {
        name,
        title,
        schema: Value::Object(head),
        takes: readable.takes,
    }
}

/// A file whose key says of which kind it is.
fn tagged(
    name: String,
    title: String,
    (key, kind): (&str, &str),
    readable: Readable,
) -> FileSchema {
    let mut made = file(name, title, readable);
    let what = json!({ "const": kind, "description": "Says of which kind this is." });
    require(&mut made.schema, key, what);
    made
}

/// Requires a key at the root, and replaces what is known of it.
fn require(schema: &mut Value, key: &str, of: Value) {
    let described = schema["properties"][key]["description"].take();
    schema["properties"][key] = of;
    if described.is_string() && schema["properties"][key]["description"].is_null() {
        schema["properties"][key]["description"] = described;
    }
    let required = &mut schema["required"];
    match required.as_array_mut() {
        Some(keys) if !keys.iter().any(|k| k == key) => keys.insert(0, json!(key)),
        Some(_) => {}
        None => *required = json!([key]),
    }
}

/// Refuses keys that are not named, where one object is described.
fn close(schema: &mut Value) {
    let by_alternatives = ["oneOf", "anyOf", "allOf", "$ref"]
        .iter()
        .any(|k| schema.get(k).is_some());
    let word = if by_alternatives {
        "unevaluatedProperties"
    } else {
        "additionalProperties"
    };
    schema[word] = json!(false);
}

/// Whatever kind a key says, by the schemas of the kinds beside this one.
fn one_of(
    name: &str,
    title: &str,
    (key, ending): (&str, &str),
    kinds: &[(&'static str, Readable)],
    takes: fn(&Value) -> Result<(), String>,
) -> FileSchema {
    let words: Vec<&str> = kinds.iter().map(|(kind, _)| *kind).collect();
    let branches: Vec<Value> = words
        .iter()
        .map(|kind| {
            json!({
                "if": { "properties": { key: { "const": kind } }, "required": [key] },
                "then": { "$ref": format!("{kind}{ending}.json") }
            })
        })
        .collect();
    let schema = json!({
        "type": "object",
        "properties": { key: { "enum": words, "description": "Of which kind it is." } },
        "required": [key],
        "allOf": branches
    });
    let schema = Schema::try_from(schema).unwrap_or_default();
    file(
        name.to_owned(),
        title.to_owned(),
        Readable { schema, takes },
    )
}

/// A document that names its form and version.
fn document(
    name: &str,
    title: &str,
    (form, versions): (&str, &[u32]),
    readable: Readable,
) -> FileSchema {
    let mut made = file(name.to_owned(), title.to_owned(), readable);
    let form = json!({
        "type": "object",
        "properties": { "name": { "const": form }, "version": { "enum": versions } },
        "required": ["name", "version"],
        "description": "Form of the file and its version."
    });
    require(&mut made.schema, "schema", form);
    made
}

/// result.json with the sections that other jobs read.
fn result() -> FileSchema {
    let mut generator = generator();
    let mut sections = result_extra_schemas(&mut generator);
    sections.push(("calibration", calibrations(&mut generator)));
    let readable = Readable {
        schema: generator.into_root_schema_for::<ResultDocument>(),
        takes: |document| said(StoredResult::from_json(document.to_string().as_bytes())),
    };
    let form = (RESULT_SCHEMA, &[RESULT_VERSION][..]);
    let mut made = document("result", "result.json, what a job found", form, readable);
    let extra = &mut made.schema["properties"]["extra"];
    for (name, schema) in sections {
        extra["properties"][name] = schema.to_value();
    }
    extra["required"] = json!(["shown", "date", "ambient"]);
    made
}

fn calibration() -> FileSchema {
    let mut generator = generator();
    let mut schema = calibrations(&mut generator);
    schema.insert(
        "$defs".to_owned(),
        Value::Object(generator.take_definitions(true)),
    );
    let readable = Readable {
        schema,
        takes: |document| said(AnyCalibration::from_json(document.to_string().as_bytes())),
    };
    let form = (CALIBRATION_SCHEMA, &[1, CALIBRATION_VERSION][..]);
    document(
        "calibration",
        "calibration.json, what compensation needs",
        form,
        readable,
    )
}

/// A calibration of any kind, which the key `kind` says.
fn calibrations(generator: &mut SchemaGenerator) -> Schema {
    let constant = generator.subschema_for::<CalibrationFile>();
    let response = generator.subschema_for::<FrequencyResponseFile>();
    json_schema!({
        "type": "object",
        "properties": { "kind": {
            "enum": [TRIAXIAL, SINGLE_AXIS, FREQUENCY_RESPONSE],
            "description": "Kind of the calibration."
        } },
        "required": ["kind"],
        "if": { "properties": { "kind": { "const": FREQUENCY_RESPONSE } }, "required": ["kind"] },
        "then": response,
        "else": constant
    })
}
