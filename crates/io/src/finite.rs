//! JSON without NaN: serde_json writes one as `null` in silence, so values are walked through first.

use crate::{Error, ErrorKind, Result};
use serde::ser::{self, Serialize};
use std::{fmt, io};

/// Indented JSON with a line end, or the place of a number that is not finite.
pub fn to_json(value: &impl Serialize) -> Result<Vec<u8>> {
    check(value)?;
    let mut bytes = serde_json::to_vec_pretty(value).map_err(write_error)?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// The same with the numbers of a list on one line, so that a large matrix is not a column of its elements.
pub fn to_json_with_rows(value: &impl Serialize) -> Result<Vec<u8>> {
    check(value)?;
    let mut bytes = Vec::new();
    let mut serializer = serde_json::Serializer::with_formatter(&mut bytes, Rows::default());
    value.serialize(&mut serializer).map_err(write_error)?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// A JSON value, or the place of a number that is not finite.
pub fn to_value(value: &impl Serialize) -> Result<serde_json::Value> {
    check(value)?;
    serde_json::to_value(value).map_err(write_error)
}

fn write_error(e: serde_json::Error) -> Error {
    Error::new(
        ErrorKind::Output,
        format!("the value has no form in JSON: {e}"),
    )
    .because(e)
}

/// A line for each field of an object, at its depth; none for the elements of a list.
#[derive(Default)]
struct Rows {
    depth: usize,
    /// Whether the object that is being written has a field.
    filled: bool,
}

impl Rows {
    fn next<W: ?Sized + io::Write>(&self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b"\n")?;
        (0..self.depth).try_for_each(|_| writer.write_all(b"  "))
    }
}

impl serde_json::ser::Formatter for Rows {
    fn begin_array_value<W: ?Sized + io::Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        writer.write_all(if first { b"" } else { b"," })
    }

    fn begin_object<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        self.filled = false;
        writer.write_all(b"{")
    }

    fn end_object<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth -= 1;
        if self.filled {
            self.next(writer)?;
        }
        self.filled = true;
        writer.write_all(b"}")
    }

    fn begin_object_key<W: ?Sized + io::Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        if !first {
            writer.write_all(b",")?;
        }
        self.next(writer)
    }

    fn begin_object_value<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }

    fn end_object_value<W: ?Sized + io::Write>(&mut self, _: &mut W) -> io::Result<()> {
        self.filled = true;
        Ok(())
    }
}

fn check(value: &impl Serialize) -> Result<()> {
    value.serialize(&mut Walk::default()).map_err(|fault| {
        let error = Error::new(ErrorKind::Output, fault.what);
        if fault.path.is_empty() {
            error
        } else {
            error.column(fault.path)
        }
    })
}

#[derive(Debug)]
struct Fault {
    what: String,
    path: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)
    }
}

impl std::error::Error for Fault {}

impl ser::Error for Fault {
    fn custom<T: fmt::Display>(what: T) -> Self {
        Self {
            what: what.to_string(),
            path: String::new(),
        }
    }
}

/// Serializer that writes nothing and stops at the first number that is not finite.
#[derive(Default)]
struct Walk {
    path: Vec<Step>,
    index: Vec<usize>,
}

/// One step into a value; words are made of it only where something is wrong.
enum Step {
    Field(&'static str),
    Element(usize),
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Field(name) => write!(f, ".{name}"),
            Self::Element(index) => write!(f, "[{index}]"),
        }
    }
}

impl Walk {
    fn number(&self, v: f64) -> Result<(), Fault> {
        if v.is_finite() {
            return Ok(());
        }
        Err(Fault {
            what: format!("{v} may not be written; a missing value has to be left out"),
            path: self.path.iter().map(Step::to_string).collect(),
        })
    }

    fn inside<T: Serialize + ?Sized>(&mut self, step: Step, value: &T) -> Result<(), Fault> {
        self.path.push(step);
        value.serialize(&mut *self)?;
        self.path.pop();
        Ok(())
    }

    fn element<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Fault> {
        let i = self.index.last_mut().map_or(0, |i| {
            *i += 1;
            *i - 1
        });
        self.inside(Step::Element(i), value)
    }
}

macro_rules! nothing {
    ($($name:ident: $type:ty),*) => { $(fn $name(self, _: $type) -> Result<(), Fault> { Ok(()) })* };
}

impl<'a> ser::Serializer for &'a mut Walk {
    type Ok = ();
    type Error = Fault;
    type SerializeSeq = &'a mut Walk;
    type SerializeTuple = &'a mut Walk;
    type SerializeTupleStruct = &'a mut Walk;
    type SerializeTupleVariant = &'a mut Walk;
    type SerializeMap = &'a mut Walk;
    type SerializeStruct = &'a mut Walk;
    type SerializeStructVariant = &'a mut Walk;

    nothing!(serialize_bool: bool, serialize_i8: i8, serialize_i16: i16, serialize_i32: i32, serialize_i64: i64,
        serialize_u8: u8, serialize_u16: u16, serialize_u32: u32, serialize_u64: u64, serialize_char: char,
        serialize_str: &str, serialize_bytes: &[u8], serialize_unit_struct: &'static str);

    fn serialize_f32(self, v: f32) -> Result<(), Fault> {
        self.number(f64::from(v))
    }
    fn serialize_f64(self, v: f64) -> Result<(), Fault> {
        self.number(v)
    }
    fn serialize_none(self) -> Result<(), Fault> {
        Ok(())
    }
    fn serialize_unit(self) -> Result<(), Fault> {
        Ok(())
    }
    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), Fault> {
        value.serialize(self)
    }
    fn serialize_unit_variant(self, _: &'static str, _: u32, _: &'static str) -> Result<(), Fault> {
        Ok(())
    }
    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), Fault> {
        value.serialize(self)
    }
    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        name: &'static str,
        value: &T,
    ) -> Result<(), Fault> {
        self.inside(Step::Field(name), value)
    }
    fn serialize_seq(self, _: Option<usize>) -> Result<Self, Fault> {
        self.index.push(0);
        Ok(self)
    }
    fn serialize_tuple(self, _: usize) -> Result<Self, Fault> {
        self.serialize_seq(None)
    }
    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Self, Fault> {
        self.serialize_seq(None)
    }
    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self, Fault> {
        self.serialize_seq(None)
    }
    fn serialize_map(self, _: Option<usize>) -> Result<Self, Fault> {
        self.serialize_seq(None)
    }
    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Self, Fault> {
        Ok(self)
    }
    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self, Fault> {
        Ok(self)
    }
}

macro_rules! elements {
    ($($trait:ident $method:ident),*) => { $(
        impl ser::$trait for &mut Walk {
            type Ok = ();
            type Error = Fault;
            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Fault> {
                self.element(value)
            }
            fn end(self) -> Result<(), Fault> {
                self.index.pop();
                Ok(())
            }
        }
    )* };
}

elements!(SerializeSeq serialize_element, SerializeTuple serialize_element, SerializeTupleStruct serialize_field,
    SerializeTupleVariant serialize_field);

impl ser::SerializeMap for &mut Walk {
    type Ok = ();
    type Error = Fault;
    fn serialize_key<T: Serialize + ?Sized>(&mut self, _: &T) -> Result<(), Fault> {
        Ok(())
    }
    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Fault> {
        self.element(value)
    }
    fn end(self) -> Result<(), Fault> {
        self.index.pop();
        Ok(())
    }
}

macro_rules! fields {
    ($($trait:ident),*) => { $(
        impl ser::$trait for &mut Walk {
            type Ok = ();
            type Error = Fault;
            fn serialize_field<T: Serialize + ?Sized>(&mut self, name: &'static str, value: &T) -> Result<(), Fault> {
                self.inside(Step::Field(name), value)
            }
            fn end(self) -> Result<(), Fault> {
                Ok(())
            }
        }
    )* };
}

fields!(SerializeStruct, SerializeStructVariant);

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn known_lists_stand_on_one_line() {
        let value = json!({"a": [[1.5, -2.0], []], "b": [{"c": null}, {}], "d": {}});
        let text = String::from_utf8(to_json_with_rows(&value).unwrap()).unwrap();
        let expected = "{\n  \"a\": [[1.5,-2.0],[]],\n  \"b\": [{\n    \"c\": null\n  },{}],\n  \"d\": {}\n}\n";
        assert_eq!(text, expected);
        let back: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(back, value);
    }

    #[test]
    fn refuses_what_is_not_finite_with_its_place() {
        #[derive(serde::Serialize)]
        struct Point {
            at: Vec<(f64, Option<f64>)>,
        }
        let point = Point {
            at: vec![(1.0, None), (2.0, Some(f64::NAN))],
        };
        for written in [to_json(&point), to_json_with_rows(&point)] {
            assert_eq!(written.unwrap_err().field(), Some(".at[1][1]"));
        }
    }
}
