//! Horizontal bars: an uncertainty budget, largest first.

use super::svg::{Anchor, Svg, WIDEST, shortened, text_width};
use super::{check_finite, colour};
use crate::Error;
use crate::number::{minus, scientific};
use serde::{Deserialize, Serialize};

/// Named bars, drawn in the order given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BarPlot {
    /// What the length means, under the bars.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) label: String,
    /// The bars.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) bars: Vec<Bar>,
    /// Whether the lengths are shares between 0 and 1, printed in per cent.
    pub(crate) shares: bool,
}

/// One bar.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Bar {
    /// Name, left of the bar.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) name: String,
    /// Length; a negative one, such as the share of inputs that cancel, reaches to the left of zero.
    pub(crate) value: f64,
    /// Words after the number; empty for none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) note: String,
}

impl BarPlot {
    /// Shares of a variance, printed in per cent.
    pub fn shares(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            bars: Vec::new(),
            shares: true,
        }
    }

    /// Lengths in a unit named in the label.
    pub fn lengths(label: impl Into<String>) -> Self {
        Self {
            shares: false,
            ..Self::shares(label)
        }
    }

    /// Adds a bar.
    #[must_use]
    pub fn bar(mut self, name: impl Into<String>, value: f64, note: impl Into<String>) -> Self {
        self.bars.push(Bar {
            name: name.into(),
            value,
            note: note.into(),
        });
        self
    }

    pub(super) fn draw(&self, title: &str, id: &str) -> Result<String, Error> {
        let values: Vec<f64> = self.bars.iter().map(|b| b.value).collect();
        check_finite(&self.label, &values)?;
        let width = 760.0;
        let row = 22.0;
        let names: Vec<Vec<String>> = self.bars.iter().map(|b| wrapped(&b.name, 250.0)).collect();
        let left = names
            .iter()
            .flatten()
            .map(|line| WIDEST * text_width(line, 12.0))
            .fold(0.0, f64::max)
            + 14.0;
        let texts: Vec<String> = self.bars.iter().map(|b| self.printed(b)).collect();
        let right = texts
            .iter()
            .map(|t| WIDEST * text_width(t, 11.0))
            .fold(0.0, f64::max)
            + 14.0;
        let room = (width - left - right).max(80.0);
        let largest = values.iter().copied().fold(0.0, f64::max);
        let smallest = values.iter().copied().fold(0.0, f64::min);
        let scale = if largest > smallest {
            room / (largest - smallest)
        } else {
            0.0
        };
        let zero = left - smallest * scale;
        let height: f64 = names
            .iter()
            .map(|n| row + 14.0 * (n.len() - 1) as f64)
            .sum();
        let mut svg = Svg::new(width.max(left + room + right), height + 32.0, title, id);
        let mut y = 4.0;
        for ((bar, lines), text) in self.bars.iter().zip(&names).zip(&texts) {
            let tall = row + 14.0 * (lines.len() - 1) as f64;
            let middle = y + 0.5 * tall;
            for (i, line) in lines.iter().enumerate() {
                let base = middle + 4.0 + 14.0 * (i as f64 - 0.5 * (lines.len() - 1) as f64);
                svg.text((left - 8.0, base), Anchor::End, line, "fill=\"#222\"");
            }
            let fill = format!("fill=\"{}\"", colour::series(usize::from(bar.value < 0.0)));
            let start = zero + bar.value.min(0.0) * scale;
            svg.rect(
                (start, middle - 7.0),
                (bar.value.abs() * scale, 14.0),
                &fill,
            );
            svg.text(
                (zero + bar.value.max(0.0) * scale + 6.0, middle + 4.0),
                Anchor::Start,
                text,
                "font-size=\"11\" fill=\"#333\"",
            );
            y += tall;
        }
        svg.line((zero, 2.0), (zero, y + 2.0), "stroke=\"#333\"");
        svg.text(
            (left, y + 20.0),
            Anchor::Start,
            &self.label,
            "fill=\"#111\"",
        );
        svg.finish(title)
    }

    fn printed(&self, bar: &Bar) -> String {
        let number = if self.shares {
            let percent = 100.0 * bar.value;
            if percent > 0.0 && percent < 0.05 {
                "< 0.1 %".into()
            } else {
                format!("{} %", minus(&format!("{percent:.1}")))
            }
        } else {
            scientific(bar.value, 3)
        };
        if bar.note.is_empty() {
            number
        } else {
            format!("{number}  ({})", bar.note)
        }
    }
}

/// A text broken at spaces into lines of at most this many pixels; a longer word is shortened.
fn wrapped(text: &str, width: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.len() - 1;
        let joined = format!("{} {word}", lines[last]);
        if lines[last].is_empty() {
            lines[last] = word.into();
        } else if text_width(&joined, 12.0) <= width {
            lines[last] = joined;
        } else {
            lines.push(word.into());
        }
    }
    let fitted = lines.iter().map(|line| shortened(line, 12.0, width));
    fitted.collect()
}
