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
//! let text = terminal::render(&report, &terminal::Options { width: 80, colour: false })?;
//! assert!(text.contains("0.0312(14)"));
//! # Ok::<(), proofmass_report::Error>(())
//! ```
//!
//! Nothing is computed here and no clock is read: times, versions and digests are texts of the caller. The page
//! needs no network, no font and no script.

mod bias;
mod columns;
mod comparison;
mod compensation;
mod coverage;
mod deconvolution;
mod document;
mod error;
mod head;
pub mod html;
mod linearity;
mod modes;
mod motion;
mod multi_position;
mod noise;
mod noise_comparison;
mod number;
mod parameters;
mod plan;
pub mod plot;
mod response;
mod shaker;
mod shock;
mod simulation;
mod single_axis;
mod spurious;
mod static_test;
mod step;
mod subscript;
mod temperature;
pub mod terminal;
mod transverse;
mod uncertainty;
mod validation;
mod velocity;

pub use bias::{BiasLine, BiasReport};
pub use columns::{Field, Rounding};
pub use comparison::ComparisonReport;
pub use compensation::CompensationReport;
pub use deconvolution::DeconvolutionReport;
pub use document::{
    Alignment, Block, Cell, Column, Figure, KeyFigure, Place, Report, Section, Table,
};
pub use error::Error;
pub use head::Head;
pub use linearity::LinearityReport;
pub use modes::{ModesLine, ModesReport};
pub use motion::MotionReport;
pub use multi_position::MultiPositionReport;
pub use noise::NoiseReport;
pub use noise_comparison::NoiseComparisonReport;
pub use number::{concise, scientific};
pub use plan::PlanReport;
pub use plot::{
    Axis, BarPlot, BodyPlot, BodyState, HistogramPlot, MatrixPlot, Panel, Plot, Scale, SeatPlot,
    Series, SpherePlot, SpherePoint, XyPlot,
};
pub use response::ResponseReport;
pub use shaker::ShakerReport;
pub use shock::{ShockReport, ShockSpectrumCurves};
pub use simulation::SimulationReport;
pub use single_axis::SingleAxisReport;
pub use spurious::SpuriousReport;
pub use static_test::StaticTestReport;
pub use step::StepReport;
pub use temperature::TemperatureReport;
pub use transverse::TransverseReport;
pub use uncertainty::{GivenInput, UncertaintyReport};
pub use validation::ValidationReport;
pub use velocity::{DriftReport, Entered, VelocityReport, unit_of};
