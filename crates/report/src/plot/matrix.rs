//! A correlation matrix as a map of coloured cells with their numbers.

use super::svg::{Anchor, Svg, WIDEST, shortened, text_width};
use super::{check_finite, check_length, colour};
use crate::Error;
use crate::number::minus;
use proofmass_uncertainty::Covariance;
use serde::{Deserialize, Serialize};

/// A square matrix of numbers between −1 and 1 with names of rows and columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MatrixPlot {
    /// Names, one per row.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub names: Vec<String>,
    /// Row-major, n × n; `None` where there is no correlation to speak of.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub elements: Vec<Option<f64>>,
}

impl MatrixPlot {
    /// The correlation coefficients of a covariance; empty cells where a component is exactly known.
    pub fn correlation(names: &[impl AsRef<str>], covariance: &Covariance) -> Self {
        let n = covariance.dimension();
        Self {
            names: names.iter().map(|name| name.as_ref().into()).collect(),
            elements: (0..n * n)
                .map(|k| covariance.correlation(k / n, k % n))
                .collect(),
        }
    }

    pub(super) fn draw(&self, title: &str, id: &str) -> Result<String, Error> {
        let n = self.names.len();
        check_length("correlation matrix", n * n, self.elements.len())?;
        for (index, element) in self.elements.iter().enumerate() {
            if let Some(value) = *element {
                check_finite("correlation matrix", &[value]).map_err(|_| Error::NotFinite {
                    series: "correlation matrix".into(),
                    index,
                    value,
                })?;
            }
        }
        let names = self.names.iter().map(|name| shortened(name, 11.0, 180.0));
        let names: Vec<String> = names.collect();
        let widest = names
            .iter()
            .map(|s| WIDEST * text_width(s, 11.0))
            .fold(0.0, f64::max);
        let left = widest + 16.0;
        let cell = ((760.0 - left - 90.0) / n.max(1) as f64).clamp(12.0, 46.0);
        let side = cell * n as f64;
        // Column names stand upright where they fit across a cell, else turned.
        let turned = widest + 6.0 > cell;
        let top = if turned { widest + 16.0 } else { 24.0 };
        let width = (left + side + 80.0).max(200.0);
        let mut svg = Svg::new(width, (top + side + 8.0).max(60.0), title, id);
        let ink = "font-size=\"11\" fill=\"#222\"";
        for (i, name) in names.iter().enumerate() {
            let middle = (i as f64 + 0.5) * cell;
            svg.text((left - 6.0, top + middle + 4.0), Anchor::End, name, ink);
            if turned {
                svg.text_upwards((left + middle + 4.0, top - 6.0), Anchor::Start, name, ink);
            } else {
                svg.text((left + middle, top - 7.0), Anchor::Middle, name, ink);
            }
        }
        let size = (cell * 0.30).clamp(7.0, 11.5);
        for (k, element) in self.elements.iter().enumerate() {
            let (row, column) = (k / n, k % n);
            let at = (left + column as f64 * cell, top + row as f64 * cell);
            let Some(value) = *element else {
                svg.rect(at, (cell, cell), "fill=\"#fff\" stroke=\"#ddd\"");
                continue;
            };
            let style = format!("fill=\"{}\" stroke=\"#fff\"", colour::diverging(value));
            svg.rect(at, (cell, cell), &style);
            if cell >= 20.0 {
                let text = if row == column {
                    "1".into()
                } else {
                    short(value)
                };
                let style = format!(
                    "font-size=\"{size:.1}\" fill=\"{}\"",
                    colour::on_diverging(value)
                );
                svg.text(
                    (at.0 + 0.5 * cell, at.1 + 0.5 * cell + 0.35 * size),
                    Anchor::Middle,
                    &text,
                    &style,
                );
            }
        }
        let (x, height) = (left + side + 24.0, side.clamp(30.0, 180.0));
        for i in 0..40 {
            let value = 1.0 - (f64::from(i) + 0.5) / 20.0;
            let style = format!("fill=\"{}\"", colour::diverging(value));
            svg.rect(
                (x, top + height * f64::from(i) / 40.0),
                (12.0, height / 40.0 + 0.4),
                &style,
            );
        }
        svg.rect((x, top), (12.0, height), "fill=\"none\" stroke=\"#333\"");
        for (value, label) in [
            (1.0, "1"),
            (0.5, "0.5"),
            (0.0, "0"),
            (-0.5, "−0.5"),
            (-1.0, "−1"),
        ] {
            let y = top + height * 0.5 * (1.0 - value);
            // Three marks where five would touch.
            if height < 70.0 && label.len() > 4 - usize::from(value > 0.0) * 2 {
                continue;
            }
            svg.line((x + 12.0, y), (x + 15.0, y), "stroke=\"#333\"");
            svg.text(
                (x + 18.0, y + 4.0),
                Anchor::Start,
                label,
                "font-size=\"10\" fill=\"#333\"",
            );
        }
        svg.finish(title)
    }
}

/// Two decimals; `1.00` is kept for what rounds to it, the diagonal prints `1`.
fn short(value: f64) -> String {
    minus(&format!("{value:.2}"))
}
