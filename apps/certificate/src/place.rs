//! A value of the sheet together with the place where it stands.

use serde_json::Value;

use crate::error::{Error, Result};

/// A value and its place, as `blocks[3].columns[0].unit`.
#[derive(Clone)]
pub struct Place<'a> {
    value: &'a Value,
    path: String,
}

impl<'a> Place<'a> {
    /// The whole sheet.
    pub fn root(value: &'a Value) -> Self {
        Self {
            value,
            path: String::new(),
        }
    }

    /// Where it stands.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// An error here.
    pub fn error(&self, what: impl Into<String>, remedy: impl Into<String>) -> Error {
        Error::new(what, remedy).at(&self.path)
    }

    fn wrong_type(&self, wanted: &str) -> Error {
        let found = match self.value {
            Value::Null => "null",
            Value::Bool(_) => "a truth value",
            Value::Number(_) => "a number",
            Value::String(_) => "a text",
            Value::Array(_) => "a list",
            Value::Object(_) => "an object",
        };
        self.error(
            format!("{wanted} is needed here, not {found}"),
            format!("write {wanted}; the README of the program shows the form of a sheet"),
        )
    }

    /// The value itself, not looked into.
    pub fn value(&self) -> &'a Value {
        self.value
    }

    /// Whether it is null.
    pub fn is_null(&self) -> bool {
        self.value.is_null()
    }

    /// The member of that name, which must be there.
    pub fn member(&self, name: &str) -> Result<Place<'a>> {
        let object = self
            .value
            .as_object()
            .ok_or_else(|| self.wrong_type("an object"))?;
        let value = object.get(name).ok_or_else(|| {
            self.error(
                format!("the field \"{name}\" is missing"),
                format!("add \"{name}\"; null is right only where the form of a sheet says so"),
            )
        })?;
        let path = if self.path.is_empty() {
            name.to_owned()
        } else {
            format!("{}.{name}", self.path)
        };
        Ok(Place { value, path })
    }

    /// The member of that name, `None` where it is missing or null.
    pub fn optional(&self, name: &str) -> Result<Option<Place<'a>>> {
        match self.value.as_object() {
            None => Err(self.wrong_type("an object")),
            Some(object) if object.get(name).is_none_or(Value::is_null) => Ok(None),
            Some(_) => self.member(name).map(Some),
        }
    }

    /// Refuses members of other names: what is not known would not be printed.
    pub fn only(&self, names: &[&str]) -> Result<()> {
        let object = self
            .value
            .as_object()
            .ok_or_else(|| self.wrong_type("an object"))?;
        match object.keys().find(|key| !names.contains(&key.as_str())) {
            None => Ok(()),
            Some(key) => Err(self.error(
                format!("the field \"{key}\" is not known here, and would not be printed"),
                format!("leave it out, or use one of: {}", names.join(", ")),
            )),
        }
    }

    /// The text that stands here.
    pub fn text(&self) -> Result<&'a str> {
        self.value.as_str().ok_or_else(|| self.wrong_type("a text"))
    }

    /// The whole number that stands here.
    pub fn integer(&self) -> Result<i64> {
        self.value
            .as_i64()
            .ok_or_else(|| self.wrong_type("a whole number"))
    }

    /// The entries of the list that stands here.
    pub fn list(&self) -> Result<Vec<Place<'a>>> {
        let entries = self
            .value
            .as_array()
            .ok_or_else(|| self.wrong_type("a list"))?;
        Ok(entries
            .iter()
            .enumerate()
            .map(|(i, value)| Place {
                value,
                path: format!("{}[{i}]", self.path),
            })
            .collect())
    }

    /// The entries of a list of `n`.
    pub fn list_of(&self, n: usize) -> Result<Vec<Place<'a>>> {
        let entries = self.list()?;
        if entries.len() == n {
            Ok(entries)
        } else {
            Err(self.error(
                format!("{n} entries are needed here, not {}", entries.len()),
                "give each its entry; an empty text \"\" leaves a place empty",
            ))
        }
    }

    /// The text that stands here, which must be one of these.
    pub fn one_of(&self, words: &[&str]) -> Result<&'a str> {
        let text = self.text()?;
        if words.contains(&text) {
            Ok(text)
        } else {
            Err(self.error(
                format!("\"{text}\" is not known here"),
                format!("use one of: {}", words.join(", ")),
            ))
        }
    }
}
