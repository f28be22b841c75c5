//! A report as data, then one file per output: HTML, terminal, SVG.
//!
//! Results of the other crates are put into a [`Report`] (sections of paragraphs, tables, figures and findings);
//! [`html::render`] turns it into one self-contained page, [`terminal::render`] into text, [`Plot::svg`] a single
//! plot into an SVG file. What is the same report looks alike everywhere.
//!
//! ```
//! use proofmass_report::{Axis, Report, Section, Series, Table, Column, Cell, XyPlot, html, terminal};
//!
//! let plot = XyPlot::new(Axis::linear("time", "s"), Axis::linear("acceleration", "m/s²"))
//!     .series(Series::line("x", &[0.0, 1.0, 2.0], &[9.81, 9.80, 9.82]));
//! let table = Table::new("Parameters", [Column::text("name"), Column::number("value", "m/s²")])
//!     .row([Cell::text("bias.x"), Cell::number("0.0312(14)")]);
//! let report = Report::new("Calibration").section(
//!     Section::new("Results").table(table).figure("The recording", plot),
//! );
//! assert!(html::render(&report)?.contains("<svg"));
//! let text = terminal::render(&report, &terminal::Options { width: 80, colour: false, filed: true, details: true })?;
//! assert!(text.contains("0.0312(14)"));
//! # Ok::<(), proofmass_report::Error>(())
//! ```
//!
//! Only layout is here: what a page of a job says stands beside the job. Nothing is computed and no clock is read:
//! times, versions and digests are texts of the caller. The page needs no network and no font; its one script lets figures be read off and
//! zoomed, and without it everything can be read.

mod columns;
mod document;
mod error;
mod grouping;
pub mod html;
pub mod number;
pub mod plot;
mod subscript;
pub mod terminal;

pub use columns::{Field, Rounding};
pub use document::{
    Alignment, Answer, Block, Cell, Column, Figure, KeyFigure, Place, Report, Section, Table,
};
pub use error::Error;
pub use number::{concise, scientific};
pub use plot::{
    Axis, BarPlot, BodyPlot, BodyState, HistogramPlot, MatrixPlot, Panel, Plot, Scale, SeatPlot,
    Series, SpherePlot, SpherePoint, XyPlot, escape,
};

/// The example of the README, so that it stays true.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
