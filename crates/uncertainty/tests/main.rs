//! Tests of this crate in one program: the crates they rest on are compiled and linked into it once.

#[macro_use]
mod common;

mod correlated_inputs;
mod curves;
mod files;
mod findings;
mod language;
mod laws;
mod published;
mod requests;
mod roads;
mod solved_equations;
mod stated;
mod temperatures;
mod trials;
mod worked_examples;
