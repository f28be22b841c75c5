//! The drawing of a certificate: what its tables over frequency state. Axes have symbols, which are the same in every language.

use super::results::{Meaning, StatedColumn, StatedResults, StatedTable};
use crate::trouble::Result;
use proofmass_report::{Axis, Plot, Series, XyPlot};

/// Height of the only panel, of each of two, in pixels.
const HEIGHTS: [f64; 2] = [240.0, 150.0];

impl Meaning {
    /// Symbol on an axis; none for what is not drawn.
    fn symbol(self) -> Option<&'static str> {
        match self {
            Self::Sensitivity => Some("|S|"),
            Self::Phase | Self::RelativePhase | Self::OwnPhase => Some("φ"),
            Self::Transverse => Some("T"),
            _ => None,
        }
    }
}

/// What is drawn of one quantity: tables of one element or, of a matrix, those on its diagonal.
fn panel(results: &StatedResults, meaning: Meaning) -> Vec<(&StatedTable, &StatedColumn)> {
    let main = |t: &&StatedTable| {
        let mut letters = t.element.as_deref().unwrap_or_default().chars();
        letters.next() == letters.next()
    };
    let tables = results.tables.iter().filter(main);
    tables
        .filter_map(|t| Some((t, t.columns.iter().find(|c| c.meaning == meaning)?)))
        .collect()
}

/// The drawing, with its words for a reader who cannot see it; none where nothing is stated over several frequencies.
pub(super) fn drawing(
    results: &StatedResults,
    words: &str,
    digits: impl Fn(&str) -> String,
) -> Result<Option<String>> {
    let meanings = [
        Meaning::Sensitivity,
        Meaning::Phase,
        Meaning::RelativePhase,
        Meaning::OwnPhase,
        Meaning::Transverse,
    ];
    let mut plot: Option<XyPlot> = None;
    let mut panels = 0;
    for meaning in meanings {
        let drawn = panel(results, meaning);
        let (Some((table, first)), Some(symbol)) = (drawn.first(), meaning.symbol()) else {
            continue;
        };
        if table.frequency.len() < 2 || drawn.iter().any(|(_, c)| c.unit != first.unit) {
            continue;
        }
        let axis = Axis::linear(symbol, first.unit.clone());
        panels += 1;
        let mut with = match plot.take() {
            None => XyPlot::new(Axis::log("f", "Hz"), axis),
            Some(plot) => plot.below(axis),
        };
        for (look, (table, column)) in drawn.iter().enumerate() {
            let name = table
                .element
                .as_ref()
                .map_or(String::new(), |e| format!("S_{e}"));
            with = with.series(Series::intervals(name, &points(table, column)).look(look));
        }
        plot = Some(with);
    }
    let Some(mut plot) = plot else {
        return Ok(None);
    };
    for panel in &mut plot.panels {
        panel.height = HEIGHTS[usize::from(panels > 1)];
    }
    let svg = Plot::from(plot).svg(words, "result")?;
    Ok(Some(relabelled(&svg, digits)))
}

/// The same drawing with its numbers in other digits.
fn relabelled(svg: &str, digits: impl Fn(&str) -> String) -> String {
    let mut out = String::with_capacity(svg.len());
    let mut rest = svg;
    while let Some(end) = rest.find("</text>") {
        // What is printed stands between the last bracket and this one.
        let start = rest[..end].rfind('>').map_or(0, |at| at + 1);
        out.push_str(&rest[..start]);
        out.push_str(&digits(&rest[start..end]));
        out.push_str("</text>");
        rest = &rest[end + "</text>".len()..];
    }
    out + rest
}

/// Frequency, value and U as they are printed.
fn points(table: &StatedTable, column: &StatedColumn) -> Vec<(f64, f64, f64)> {
    let rows = table.frequency.iter().zip(&column.numbers);
    rows.filter_map(|(f, n)| {
        Some((
            f.parse().ok()?,
            n.value.parse().ok()?,
            n.expanded.parse().ok()?,
        ))
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::super::texts::persian_digits;
    use super::*;

    #[test]
    fn known_digits_of_axes() {
        let svg =
            "<svg width=\"10\"><text x=\"1\">2.5</text><path d=\"M0 1\"/><text>a</text></svg>";
        let persian = svg.replace("2.5", "۲٫۵");
        assert_eq!(relabelled(svg, persian_digits), persian);
        assert_eq!(relabelled(svg, str::to_owned), svg);
    }
}
