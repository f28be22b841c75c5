//! The whole suite, the same on SQLite and PostgreSQL.

mod bad_input;
mod content;
mod late;
mod places;
mod recorded;
mod survival;
mod year;
