//! Tests of this crate in one program: the crates they rest on are compiled and linked into it once.

mod bad_input;
mod files;
mod inspection;
mod layouts;
mod logs;
mod odd_files;
mod outputs;
mod privacy;
mod properties;
mod rewriter;
mod segments;
mod sources;
mod streams;
mod tables;
mod time_stamps;
