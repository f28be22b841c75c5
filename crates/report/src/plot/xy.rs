//! Series over a common horizontal axis, in one panel or several stacked ones.

use super::axis::Axis;
use serde::{Deserialize, Serialize};

/// Panels stacked over one horizontal axis.
///
/// Methods that add something add it to the last panel; [`XyPlot::below`] starts the next one.
///
/// ```
/// use proofmass_report::{Axis, Plot, Series, XyPlot};
/// let bode = XyPlot::new(Axis::log("frequency", "Hz"), Axis::log("modulus", "1"))
///     .series(Series::line("model", &[10.0, 100.0, 1000.0], &[1.0, 1.001, 1.12]))
///     .below(Axis::linear("phase", "°"))
///     .series(Series::line("model", &[10.0, 100.0, 1000.0], &[0.0, -0.5, -7.0]));
/// assert!(Plot::from(bode).svg("Frequency response", "bode")?.starts_with("<svg"));
/// # Ok::<(), proofmass_report::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct XyPlot {
    /// The common horizontal axis.
    pub x: Axis,
    /// From top to bottom.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub panels: Vec<Panel>,
    /// Width in pixels.
    pub(crate) width: f64,
}

/// One rectangle of an [`XyPlot`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Panel {
    /// Vertical axis.
    pub(crate) y: Axis,
    /// What is drawn, first below.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub series: Vec<Series>,
    /// Horizontal reference lines.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) horizontal: Vec<ReferenceLine>,
    /// Vertical reference lines.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub vertical: Vec<ReferenceLine>,
    /// Power laws for comparison.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) slopes: Vec<Slope>,
    /// Shaded intervals of the horizontal axis.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) shades: Vec<Shade>,
    /// Words at a place: x, y, text.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) notes: Vec<(f64, f64, String)>,
    /// Height of the rectangle in pixels.
    pub height: f64,
}

/// Points with what surrounds them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Series {
    /// Name in the legend; empty for none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) name: String,
    /// Abscissae.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) x: Vec<f64>,
    /// Ordinates.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) y: Vec<f64>,
    /// Line, markers or both.
    pub(crate) style: Style,
    /// Lower and upper end of a bar at each point, as ordinates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bars: Option<(Vec<f64>, Vec<f64>)>,
    /// Lower and upper edge of a filled band, as ordinates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) band: Option<(Vec<f64>, Vec<f64>)>,
    /// Colour, dash and marker by number; `None` takes the place in the panel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) look: Option<usize>,
}

/// How the points of a series are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Style {
    /// Joined by straight lines.
    #[default]
    Line,
    /// Each value held until the next.
    Steps,
    /// A marker at each.
    Markers,
    /// Both.
    LineAndMarkers,
}

/// A labelled straight line across a panel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ReferenceLine {
    /// Where.
    pub at: f64,
    /// Label; empty for none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub label: String,
}

/// A power law y = y₀ (x/x₀)ⁿ, straight where both axes are logarithmic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Slope {
    /// Label, such as `τ⁻¹ᐟ²`.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) label: String,
    /// A point it passes through.
    pub(crate) through: (f64, f64),
    /// The exponent n.
    pub(crate) exponent: f64,
}

/// Shaded intervals of the horizontal axis, with one name in the legend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Shade {
    /// Name in the legend; empty for none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) name: String,
    /// From and to.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) intervals: Vec<(f64, f64)>,
}

impl XyPlot {
    /// One empty panel.
    pub fn new(x: Axis, y: Axis) -> Self {
        Self {
            x,
            panels: vec![Panel {
                y,
                height: 300.0,
                ..Panel::default()
            }],
            width: 760.0,
        }
    }

    /// Starts a further panel below; all panels become lower.
    #[must_use]
    pub fn below(mut self, y: Axis) -> Self {
        self.panels.push(Panel {
            y,
            ..Panel::default()
        });
        // Three are hardly higher than two: both fit a screen below the numbers they show.
        let height = if self.panels.len() > 2 { 130.0 } else { 170.0 };
        for panel in &mut self.panels {
            panel.height = height;
        }
        self
    }

    /// Sets the height of the last panel in pixels.
    #[must_use]
    pub fn height(self, height: f64) -> Self {
        self.with(|panel| panel.height = height)
    }

    /// Adds a series to the last panel.
    #[must_use]
    pub fn series(self, series: Series) -> Self {
        self.with(|panel| panel.series.push(series))
    }

    /// Adds a horizontal reference line to the last panel.
    #[must_use]
    pub fn horizontal(self, at: f64, label: impl Into<String>) -> Self {
        let label = label.into();
        self.with(|panel| panel.horizontal.push(ReferenceLine { at, label }))
    }

    /// Adds a vertical reference line to the last panel.
    #[must_use]
    pub fn vertical(self, at: f64, label: impl Into<String>) -> Self {
        let label = label.into();
        self.with(|panel| panel.vertical.push(ReferenceLine { at, label }))
    }

    /// Adds the power law through a point to the last panel.
    #[must_use]
    pub fn slope(self, label: impl Into<String>, through: (f64, f64), exponent: f64) -> Self {
        let label = label.into();
        self.with(|panel| {
            panel.slopes.push(Slope {
                label,
                through,
                exponent,
            });
        })
    }

    /// Shades intervals of the last panel.
    #[must_use]
    pub fn shade(self, name: impl Into<String>, intervals: &[(f64, f64)]) -> Self {
        let name = name.into();
        let intervals = intervals.to_vec();
        self.with(|panel| panel.shades.push(Shade { name, intervals }))
    }

    /// Writes words at a place of the last panel.
    #[must_use]
    pub fn note(self, x: f64, y: f64, text: impl Into<String>) -> Self {
        let text = text.into();
        self.with(|panel| panel.notes.push((x, y, text)))
    }

    fn with(mut self, change: impl FnOnce(&mut Panel)) -> Self {
        if let Some(panel) = self.panels.last_mut() {
            change(panel);
        }
        self
    }
}

impl Series {
    /// Points joined by lines.
    pub fn line(name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        Self {
            name: name.into(),
            x: x.to_vec(),
            y: y.to_vec(),
            ..Self::default()
        }
    }

    /// Points as markers.
    pub fn markers(name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        Self::line(name, x, y).style(Style::Markers)
    }

    /// Markers joined by lines, each with a bar of its value plus and minus an expanded uncertainty: (x, y, U).
    pub fn intervals(name: impl Into<String>, points: &[(f64, f64, f64)]) -> Self {
        let column = |f: fn(&(f64, f64, f64)) -> f64| points.iter().map(f).collect::<Vec<f64>>();
        Self::line(name, &column(|p| p.0), &column(|p| p.1))
            .style(Style::LineAndMarkers)
            .bars(&column(|p| p.1 - p.2), &column(|p| p.1 + p.2))
    }

    /// Changes how the points are shown.
    #[must_use]
    pub fn style(mut self, style: Style) -> Self {
        self.style = style;
        self
    }

    /// Adds bars from `lower` to `upper` (ordinates). On a logarithmic axis a lower end of zero or less runs to
    /// the foot of the plot.
    #[must_use]
    pub fn bars(mut self, lower: &[f64], upper: &[f64]) -> Self {
        self.bars = Some((lower.to_vec(), upper.to_vec()));
        self
    }

    /// Adds a filled band from `lower` to `upper` (ordinates), with the same rule for logarithmic axes.
    #[must_use]
    pub fn band(mut self, lower: &[f64], upper: &[f64]) -> Self {
        self.band = Some((lower.to_vec(), upper.to_vec()));
        self
    }

    /// Adds a band of the values plus and minus these.
    #[must_use]
    pub fn within(self, half: &[f64]) -> Self {
        let edge = |sign: f64| -> Vec<f64> {
            let pairs = self.y.iter().zip(half);
            pairs.map(|(y, half)| y + sign * half).collect()
        };
        let (lower, upper) = (edge(-1.0), edge(1.0));
        self.band(&lower, &upper)
    }

    /// Fixes colour, dash and marker, so that the same thing looks alike in two panels.
    #[must_use]
    pub fn look(mut self, number: usize) -> Self {
        self.look = Some(number);
        self
    }
}
