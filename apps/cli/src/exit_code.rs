//! What a command ends with, for scripts.

/// Done.
pub(crate) const DONE: u8 = 0;
/// No result.
pub(crate) const FAILED: u8 = 1;
/// Wrong use.
pub(crate) const WRONG_USE: u8 = 2;
/// Done, with a finding that needs a decision.
pub(crate) const DECISION: u8 = 3;

/// Every code with its meaning, as `docs/outputs.md` has it.
#[cfg(test)]
const ALL: [(u8, &str); 4] = [
    (
        DONE,
        "done. Findings may stand in the result, even one that needs a decision",
    ),
    (
        FAILED,
        "failed: no result. Or a command that checks found something: `verify` a changed file, `certificate check` something missing",
    ),
    (
        WRONG_USE,
        "wrong use: an option or an argument that the command does not have",
    ),
    (
        DECISION,
        "done, and a finding needs a decision: with `--strict` only",
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_has_every_code() {
        let page = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/outputs.md");
        let page = std::fs::read_to_string(page).unwrap();
        let rows = ALL.map(|(code, meaning)| format!("| {code} | {meaning} |\n"));
        let table = format!("| code | meaning |\n|---|---|\n{}\n", rows.concat());
        assert!(page.contains(&table), "docs/outputs.md: {table}");
    }
}
