//! Plots as data, drawn as SVG: no script, no external font, nothing fetched.
//!
//! Colours are those of Okabe and Ito, told apart by readers with any colour vision; series differ in dash and
//! marker as well, so that a page printed in black and white can be read.

mod axis;
mod bar;
mod body;
mod colour;
mod decimate;
mod drawing;
mod frame;
mod histogram;
mod labelling;
mod matrix;
mod placing;
mod seat;
mod shortening;
mod sphere;
mod svg;
mod ticks;
mod xy;

pub use axis::{Axis, Scale};
pub use bar::{Bar, BarPlot};
pub use body::{BodyPlot, BodyState};
pub use histogram::HistogramPlot;
pub use matrix::MatrixPlot;
pub use seat::SeatPlot;
pub use sphere::{SpherePlot, SpherePoint};
pub use xy::{Panel, ReferenceLine, Series, Shade, Slope, Style, XyPlot};

use crate::Error;
use serde::{Deserialize, Serialize};

pub use svg::escape;
pub(crate) use svg::text_width;

/// Any plot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Plot {
    /// Series over a common axis, in one or more panels.
    Xy(XyPlot),
    /// Directions on the unit sphere.
    Sphere(SpherePlot),
    /// A correlation matrix.
    Matrix(MatrixPlot),
    /// A histogram.
    Histogram(HistogramPlot),
    /// Horizontal bars.
    Bar(BarPlot),
    /// Deformed bodies.
    Body(BodyPlot),
    /// The frame of a bench with wedges.
    Seat(SeatPlot),
}

impl Plot {
    /// The plot as one SVG element.
    ///
    /// `title` is read aloud by screen readers; `id` prefixes every identifier in the drawing and must be unique
    /// on a page with several.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::NotPositive`] and [`Error::Length`] name the series and the element.
    pub fn svg(&self, title: &str, id: &str) -> Result<String, Error> {
        match self {
            Self::Xy(plot) => plot.draw(title, id),
            Self::Sphere(plot) => plot.draw(title, id),
            Self::Matrix(plot) => plot.draw(title, id),
            Self::Histogram(plot) => plot.draw(title, id),
            Self::Bar(plot) => plot.draw(title, id),
            Self::Body(plot) => plot.draw(title, id),
            Self::Seat(plot) => plot.draw(title, id),
        }
    }

    /// The same for a phone, as wide as its words stay legible there; none of a plot that has one width.
    pub(crate) fn narrow(&self) -> Option<Self> {
        /// Width that a screen of 390 pixels shows at nine tenths.
        const NARROW: f64 = 410.0;
        match self {
            Self::Xy(plot) => Some(Self::Xy(XyPlot {
                width: NARROW,
                ..plot.clone()
            })),
            _ => None,
        }
    }

    /// Whether the drawing is so high that its words would be too small at the height of others on paper.
    pub(crate) fn is_tall(&self) -> bool {
        match self {
            Self::Xy(plot) => plot.panels.iter().map(|panel| panel.height).sum::<f64>() > 360.0,
            Self::Matrix(plot) => plot.names.len() > 8,
            Self::Bar(plot) => plot.bars.len() > 15,
            Self::Body(plot) => plot.states.len() > 3,
            Self::Sphere(_) | Self::Histogram(_) | Self::Seat(_) => false,
        }
    }
}

impl From<XyPlot> for Plot {
    fn from(plot: XyPlot) -> Self {
        Self::Xy(plot)
    }
}
impl From<SpherePlot> for Plot {
    fn from(plot: SpherePlot) -> Self {
        Self::Sphere(plot)
    }
}
impl From<MatrixPlot> for Plot {
    fn from(plot: MatrixPlot) -> Self {
        Self::Matrix(plot)
    }
}
impl From<HistogramPlot> for Plot {
    fn from(plot: HistogramPlot) -> Self {
        Self::Histogram(plot)
    }
}
impl From<SeatPlot> for Plot {
    fn from(plot: SeatPlot) -> Self {
        Self::Seat(plot)
    }
}
impl From<BodyPlot> for Plot {
    fn from(plot: BodyPlot) -> Self {
        Self::Body(plot)
    }
}
impl From<BarPlot> for Plot {
    fn from(plot: BarPlot) -> Self {
        Self::Bar(plot)
    }
}

/// Largest magnitude that is drawn: beyond it the length of an axis could overflow.
const LARGEST: f64 = 1e300;

/// Refuses what cannot be drawn, by name and index.
fn check_finite(series: &str, values: &[f64]) -> Result<(), Error> {
    match values
        .iter()
        .position(|v| !v.is_finite() || v.abs() > LARGEST)
    {
        Some(index) => Err(Error::NotFinite {
            series: series.into(),
            index,
            value: values[index],
        }),
        None => Ok(()),
    }
}

/// Refuses what a logarithmic axis has no place for.
fn check_positive(series: &str, values: &[f64]) -> Result<(), Error> {
    match values.iter().position(|&v| v <= 0.0) {
        Some(index) => Err(Error::NotPositive {
            series: series.into(),
            index,
            value: values[index],
        }),
        None => Ok(()),
    }
}

fn check_length(name: &str, expected: usize, got: usize) -> Result<(), Error> {
    if expected == got {
        Ok(())
    } else {
        Err(Error::Length {
            name: name.into(),
            expected,
            got,
        })
    }
}
