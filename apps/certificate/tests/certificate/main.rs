//! The program from outside: what it makes of the sheets in `tests/sheets`, read back, and what it refuses.
//!
//! The words are read back by `pdftotext` of poppler; where that is not installed, the tests that need it say so.

mod alignment;
mod attachments;
mod refusals;
mod same_bytes;
mod typesetter;
mod words;
