//! XML as a tree of elements with their lines, and XML as text.
//!
//! What certificates need and no more: no document types, so that no entity is declared or expanded; nothing outside of the text is
//! opened; a limit on depth and number of elements.

mod reader;
mod writer;

pub(crate) use reader::{Element, Namespace, XmlTree};
pub(crate) use writer::XmlWriter;
