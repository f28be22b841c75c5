//! Records in PostgreSQL, named by a URL.

use crate::engine::{Engine, Row, Value};
use crate::schema::{DERIVED, FILED, VERSION};
use crate::sqlite::Access;
use postgres::types::{IsNull, ToSql, Type, private::BytesMut};
use postgres::{Client, NoTls};
use proofmass_jobs::{Result, Trouble};
use std::path::{Path, PathBuf};

/// A database on a server.
pub(crate) struct Postgresql {
    client: Client,
    /// Statements that were prepared once.
    prepared: std::collections::HashMap<String, postgres::Statement>,
}

impl Postgresql {
    /// Connects to the server; tables are made where they are asked for.
    pub(crate) fn open(url: &str, access: Access) -> Result<Self> {
        let client = Client::connect(url, NoTls).map_err(|e| {
            Trouble::request(format!("no connection to the records: {}", reason(&e)))
                .with_hint("the URL is postgresql://USER:PASSWORD@HOST/DATABASE; the server must run and the database must be there")
        })?;
        let mut records = Self {
            client,
            prepared: Default::default(),
        };
        let version = records.version()?;
        if version > VERSION {
            return Err(Trouble::data(format!(
                "the database has version {version} of the form of records; this program knows version {VERSION}"
            ))
            .with_hint("use a newer proofmass, or let that one write the records out (`records export --folder`) and import them here"));
        }
        if version == 0 && access != Access::Create {
            return Err(Trouble::request("the database holds no records")
                .with_hint("`proofmass records add` makes them"));
        }
        if access == Access::Read {
            records.script("SET default_transaction_read_only = on")?;
        }
        Ok(records)
    }
}

/// What the server says, with its detail.
fn reason(error: &postgres::Error) -> String {
    match error.as_db_error() {
        Some(said) => match said.detail() {
            Some(detail) => format!("{}: {detail}", said.message()),
            None => said.message().to_owned(),
        },
        None => match std::error::Error::source(error) {
            Some(source) => format!("{error}: {source}"),
            None => error.to_string(),
        },
    }
}

fn wrong(error: &postgres::Error) -> Trouble {
    Trouble::data(format!("PostgreSQL: {}", reason(error)))
        .with_hint("`proofmass records check` says whether the records are whole")
}

/// Places as PostgreSQL writes them.
fn dialect(statement: &str) -> String {
    statement.replace('?', "$")
}

impl ToSql for Value {
    fn to_sql(
        &self,
        kind: &Type,
        out: &mut BytesMut,
    ) -> std::result::Result<IsNull, Box<dyn std::error::Error + Sync + Send>> {
        match self {
            Self::Null => Ok(IsNull::Yes),
            Self::Integer(value) if *kind == Type::FLOAT8 => (*value as f64).to_sql(kind, out),
            Self::Integer(value) => value.to_sql(kind, out),
            Self::Real(value) => value.to_sql(kind, out),
            Self::Text(text) => text.to_sql(kind, out),
            Self::Bytes(bytes) => bytes.to_sql(kind, out),
        }
    }

    fn accepts(kind: &Type) -> bool {
        [Type::INT8, Type::FLOAT8, Type::TEXT, Type::BYTEA].contains(kind)
    }

    postgres::types::to_sql_checked!();
}

impl Postgresql {
    fn statement(&mut self, text: &str) -> Result<postgres::Statement> {
        if let Some(known) = self.prepared.get(text) {
            return Ok(known.clone());
        }
        let prepared = self.client.prepare(&dialect(text)).map_err(|e| wrong(&e))?;
        self.prepared.insert(text.to_owned(), prepared.clone());
        Ok(prepared)
    }
}

impl Engine for Postgresql {
    fn run(&mut self, statement: &str, values: &[Value]) -> Result<u64> {
        let statement = self.statement(statement)?;
        let values: Vec<&(dyn ToSql + Sync)> = values.iter().map(|v| v as _).collect();
        self.client
            .execute(&statement, &values)
            .map_err(|e| wrong(&e))
    }

    fn rows(&mut self, question: &str, values: &[Value]) -> Result<Vec<Row>> {
        let question = self.statement(question)?;
        let values: Vec<&(dyn ToSql + Sync)> = values.iter().map(|v| v as _).collect();
        let rows = self
            .client
            .query(&question, &values)
            .map_err(|e| wrong(&e))?;
        let read = |row: &postgres::Row, i: usize| -> std::result::Result<Value, postgres::Error> {
            let kind = row.columns()[i].type_();
            Ok(if *kind == Type::INT8 {
                row.try_get::<_, Option<i64>>(i)?.into()
            } else if *kind == Type::FLOAT8 {
                row.try_get::<_, Option<f64>>(i)?.into()
            } else if *kind == Type::BYTEA {
                row.try_get::<_, Option<Vec<u8>>>(i)?
                    .map_or(Value::Null, Value::Bytes)
            } else {
                row.try_get::<_, Option<String>>(i)?
                    .map_or(Value::Null, Value::Text)
            })
        };
        rows.iter()
            .map(|row| {
                (0..row.len())
                    .map(|i| read(row, i).map_err(|e| wrong(&e)))
                    .collect()
            })
            .collect()
    }

    fn script(&mut self, statements: &str) -> Result<()> {
        self.client.batch_execute(statements).map_err(|e| wrong(&e))
    }

    fn begin(&mut self) -> Result<()> {
        self.script("BEGIN")?;
        // One writer at a time, also while the tables are made; released at the end.
        self.script("SELECT pg_advisory_xact_lock(1886220901)")
    }

    fn commit(&mut self) -> Result<()> {
        self.script("COMMIT")
    }

    fn rollback(&mut self) {
        let _ = self.script("ROLLBACK");
    }

    fn version(&mut self) -> Result<usize> {
        let there = self.rows("SELECT to_regclass('proofmass_form')::text", &[])?;
        if there.first().is_none_or(|row| row[0] == Value::Null) {
            return Ok(0);
        }
        let rows = self.rows("SELECT version FROM proofmass_form", &[])?;
        let version = rows.first().and_then(|row| row[0].integer());
        Ok(version.and_then(|v| usize::try_from(v).ok()).unwrap_or(0))
    }

    fn set_version(&mut self, version: usize) -> Result<()> {
        self.script(&format!(
            "CREATE TABLE IF NOT EXISTS proofmass_form (version BIGINT NOT NULL);\
             DELETE FROM proofmass_form; INSERT INTO proofmass_form VALUES ({version})"
        ))
    }

    fn damage(&mut self) -> Result<Vec<String>> {
        Ok(Vec::new())
    }

    fn copy_to(&mut self, _place: &Path) -> Result<()> {
        Err(
            Trouble::request("a database on a server is not copied by this command")
                .with_hint("use pg_dump, or `proofmass records export --folder`"),
        )
    }

    fn keep_copy(&mut self) -> Result<String> {
        let schema = format!("proofmass_version_{}", self.version()?);
        self.script(&format!("CREATE SCHEMA {schema}"))?;
        for table in FILED.iter().chain(DERIVED) {
            let there = self.rows("SELECT to_regclass(?1::text)::text", &[Value::from(*table)])?;
            if there.first().is_some_and(|row| row[0] != Value::Null) {
                self.script(&format!("CREATE TABLE {schema}.{table} AS TABLE {table}"))?;
            }
        }
        Ok(format!("the schema {schema}"))
    }

    fn beside(&self) -> Option<PathBuf> {
        None
    }
}
