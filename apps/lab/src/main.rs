//! `proofmass-lab`: the live bench.

fn main() {}
