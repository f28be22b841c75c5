//! A histogram with a curve over it and marks of an interval.

use super::axis::{Axis, Scale};
use super::xy::{Series, XyPlot};
use super::{check_finite, check_length};
use crate::Error;
use serde::{Deserialize, Serialize};

/// Bins with given heights; nothing is counted here.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HistogramPlot {
    /// Horizontal axis.
    pub(crate) x: Axis,
    /// Vertical axis: counts or density.
    pub(crate) y: Axis,
    /// Edges of the bins, rising, one more than heights.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) edges: Vec<f64>,
    /// Heights of the bins.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) heights: Vec<f64>,
    /// Curves over the bins.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) curves: Vec<Series>,
    /// Marks with labels, such as the ends of a coverage interval.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) marks: Vec<(f64, String)>,
}

impl HistogramPlot {
    /// Bins between edges.
    pub fn new(x: Axis, y: Axis, edges: &[f64], heights: &[f64]) -> Self {
        Self {
            x,
            y,
            edges: edges.to_vec(),
            heights: heights.to_vec(),
            curves: Vec::new(),
            marks: Vec::new(),
        }
    }

    /// Adds a curve.
    #[must_use]
    pub fn curve(mut self, series: Series) -> Self {
        self.curves.push(series);
        self
    }

    /// Adds a vertical mark.
    #[must_use]
    pub fn mark(mut self, at: f64, label: impl Into<String>) -> Self {
        self.marks.push((at, label.into()));
        self
    }

    pub(super) fn draw(&self, title: &str, id: &str) -> Result<String, Error> {
        check_finite("edges", &self.edges)?;
        check_finite("heights", &self.heights)?;
        if !(self.edges.is_empty() && self.heights.is_empty()) {
            check_length("edges", self.heights.len() + 1, self.edges.len())?;
        }
        if let Some(w) = self.edges.windows(2).find(|w| w[0] >= w[1]) {
            return Err(Error::EmptyRange {
                name: "bin".into(),
                low: w[0],
                high: w[1],
            });
        }
        // The outline of the bins over a filled band from zero is an XyPlot; a bin is a step.
        let mut x = Vec::new();
        let mut y = Vec::new();
        for (edge, &height) in self.edges.windows(2).zip(&self.heights) {
            x.extend([edge[0], edge[0], edge[1], edge[1]]);
            y.extend([0.0, height, height, 0.0]);
        }
        let foot = vec![0.0; y.len()];
        let bins = Series::line("", &x, &y).band(&foot, &y).look(4);
        let mut plot = XyPlot::new(self.x.clone(), self.y.clone())
            .height(260.0)
            .series(bins);
        if plot.panels[0].y.range.is_none() && self.y.scale == Scale::Linear {
            let curves = self.curves.iter().flat_map(|c| c.y.iter());
            let top = self
                .heights
                .iter()
                .chain(curves)
                .copied()
                .fold(0.0, f64::max);
            if top > 0.0 && top <= super::LARGEST / 2.0 {
                plot.panels[0].y.range = Some((0.0, 1.06 * top));
            }
        }
        for (i, curve) in self.curves.iter().enumerate() {
            let look = curve.look.unwrap_or(i + 1);
            plot = plot.series(curve.clone().look(look));
        }
        for (at, label) in &self.marks {
            plot = plot.vertical(*at, label.as_str());
        }
        plot.draw(title, id)
    }
}
