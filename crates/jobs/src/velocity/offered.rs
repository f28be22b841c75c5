//! The columns of a recording in which nobody named one, and what they may be by their headings.

use crate::trouble::Trouble;
use proofmass_io::{Layout, LayoutOptions, Source, Unit, split_heading};

/// Most columns that are listed.
const MOST: usize = 24;

/// What a column may hold.
#[derive(Clone, Copy, PartialEq)]
enum Sense {
    Position,
    Speed,
    Acceleration,
}

impl Sense {
    /// By its unit, else by the words of its heading.
    fn of(heading: &str, unit: Option<Unit>) -> Option<Self> {
        let name = split_heading(heading).0.to_lowercase();
        let words: Vec<&str> = name
            .split(|c: char| !c.is_alphanumeric())
            .filter(|w| !w.is_empty())
            .collect();
        let begins = |list: &[&str]| {
            let any = |w: &&str| list.iter().any(|l| w.starts_with(l));
            words.iter().any(any)
        };
        match unit.map(|u| u.si().0) {
            Some(Unit::MetrePerSecondSquared) => return Some(Self::Acceleration),
            Some(Unit::MetrePerSecond | Unit::RadianPerSecond) => return Some(Self::Speed),
            Some(Unit::Metre | Unit::Radian | Unit::Count) => return Some(Self::Position),
            Some(_) => return None,
            None => {}
        }
        if begins(&["speed", "vel", "rpm", "tacho", "wheel", "kmh"]) {
            Some(Self::Speed)
        } else if begins(&["acc", "beschl"])
            || words.first().is_some_and(|w| ["a", "ax"].contains(w))
        {
            Some(Self::Acceleration)
        } else if begins(&["enc", "count", "pos", "angle", "tick", "dist"]) {
            Some(Self::Position)
        } else {
            None
        }
    }
}

/// "columns of the file: t, enc, acc; such as --position enc --acceleration acc"; of several streams one has to be
/// chosen before.
pub(super) fn offered(mut source: Source) -> Result<String, Trouble> {
    let layout = Layout::of(&mut source, &LayoutOptions::default())?;
    let time = layout.time_column();
    let bare = |i: usize| split_heading(&layout.name(i)).0.to_owned();
    let all: Vec<String> = (0..layout.columns.min(MOST)).map(bare).collect();
    let more = if layout.columns > MOST { ", …" } else { "" };
    let first = |sense: Sense| {
        (0..layout.columns)
            .filter(|i| Some(*i) != time)
            .find(|&i| Sense::of(&layout.name(i), layout.unit(i)) == Some(sense))
    };
    let option = |word: &str, sense: Sense| {
        let name = bare(first(sense)?);
        Some(match name.contains(char::is_whitespace) {
            true => format!("--{word} \"{name}\""),
            false => format!("--{word} {name}"),
        })
    };
    let reading = option("position", Sense::Position).or_else(|| option("speed", Sense::Speed));
    let told: Vec<String> = reading
        .into_iter()
        .flat_map(|r| [Some(r), option("acceleration", Sense::Acceleration)])
        .flatten()
        .collect();
    let such = match told.is_empty() {
        true => String::new(),
        false => format!("; such as {}", told.join(" ")),
    };
    Ok(format!(
        "columns of the file: {}{more}{such}",
        all.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(header: &str) -> String {
        let rows = "\n1,2,3\n2,3,4\n3,4,5\n";
        let bytes = format!("{header}{rows}").into_bytes();
        offered(Source::from_bytes("axis.csv", bytes).unwrap()).unwrap()
    }

    #[test]
    fn known_columns_are_offered_by_their_headings() {
        assert_eq!(
            of("time_us,enc,acc"),
            "columns of the file: time, enc, acc; such as --position enc --acceleration acc"
        );
        assert!(of("t,speed_kmh,a").ends_with("; such as --speed speed --acceleration a"));
        assert!(of("t,position_m,counts").ends_with("; such as --position position"));
        assert_eq!(of("p,q,r"), "columns of the file: p, q, r");
    }
}
