//! Subscripts in running text: `S_xx` is read as S with the index xx.

/// Longest index: `eff`, `ref`.
const LONGEST: usize = 3;

/// Pieces of a text in order, with whether each is an index.
///
/// An index is one to three small letters or digits after an underscore that follows a single letter (or a letter
/// with a star); names of files and columns, such as `acc_x` or `a_x.csv`, are left alone.
pub(crate) fn pieces(text: &str) -> Vec<(bool, &str)> {
    let mut pieces = vec![];
    let mut from = 0;
    for (at, _) in text.match_indices('_') {
        if at < from {
            continue;
        }
        if let Some(end) = index_end(text, at) {
            pieces.push((false, &text[from..at]));
            pieces.push((true, &text[at + 1..end]));
            from = end;
        }
    }
    if from < text.len() || pieces.is_empty() {
        pieces.push((false, &text[from..]));
    }
    pieces
}

/// Where the index after the underscore at `at` ends, if it is one.
fn index_end(text: &str, at: usize) -> Option<usize> {
    let word = |c: char| c.is_alphanumeric() || c == '_';
    let mut before = text[..at].chars().rev();
    let mut base = before.next()?;
    if base == '*' {
        base = before.next()?;
    }
    if !base.is_alphabetic() || before.next().is_some_and(word) {
        return None;
    }
    let small = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit();
    let rest = &text[at + 1..];
    let length = rest.find(|c| !small(c)).unwrap_or(rest.len());
    let mut after = rest[length..].chars();
    let file = match after.next() {
        Some('.') => after.next().is_some_and(char::is_alphanumeric),
        Some(c) => word(c),
        None => false,
    };
    ((1..=LONGEST).contains(&length) && !file).then_some(at + 1 + length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_indices_are_found_and_names_left_alone() {
        let indices = |text| -> Vec<&str> {
            let found = pieces(text).into_iter().filter(|p| p.0);
            found.map(|p| p.1).collect()
        };
        assert_eq!(
            indices("|S_xx|, ν_eff and S*_ij = Re(S_ij/S_ii)."),
            ["xx", "eff", "ij", "ij", "ii"]
        );
        for name in [
            "acc_x", "a_x.csv", "u_x_real", "x_V", "_x", "a_", "a_long", "",
        ] {
            assert!(indices(name).is_empty(), "{name}");
        }
        let text: String = pieces("E_n of S_zz").into_iter().map(|p| p.1).collect();
        assert_eq!(text, "En of Szz");
    }
}
