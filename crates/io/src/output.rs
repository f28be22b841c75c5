//! Results appear whole or not at all, and take nothing away but what an earlier run wrote.
//!
//! A folder of results has a [`Manifest`]: the files that were written, with their digests. The next run replaces
//! exactly those that are still as they were written; whatever else stands there is kept. New files are written and
//! synchronised beside their place before anything old is touched.

mod file;
mod folder;
mod manifest;
mod place;
mod unfinished;

pub use file::{AtomicFile, not_an_input};
pub use folder::OutputFolder;
pub use manifest::{Listed, MANIFEST, MANIFEST_SCHEMA, MANIFEST_VERSION, Manifest, RESULT_SCHEMA};
pub use unfinished::discard_unfinished;
