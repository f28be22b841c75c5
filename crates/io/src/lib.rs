//! Files of proofmass: recordings of every format, tables, and the folders that results go into.
//!
//! The mathematics consumes plain arrays; this crate turns files into them and results into files.
//!
//! ```
//! use proofmass_io::{Recording, RecordingOptions};
//!
//! # let folder = tempfile::tempdir().unwrap();
//! # let path = folder.path().join("hand-held.csv");
//! std::fs::write(&path, "time_s;acc_x_g;acc_y_g;acc_z_g\n0,00;0,01;0,02;1,00\n0,01;0,02;0,02;0,99\n").unwrap();
//! let options = RecordingOptions {
//!     columns: vec!["acc_x".into(), "acc_y".into(), "acc_z".into()],
//!     ..RecordingOptions::default()
//! };
//! let recording = Recording::read(&path, &options)?.into_si();
//! assert!((recording.time.rate_hz() - 100.0).abs() < 1e-9);
//! assert_eq!(recording.columns[2].data[0], 9.80665);
//! assert_eq!(recording.columns[2].unit.unwrap().to_string(), "m/s²");
//! # Ok::<(), proofmass_io::Error>(())
//! ```
//!
//! # Conventions
//! - A field is a finite number or an error that names file, line, column and remedy; nothing is filled in.
//! - Lines and columns are counted from one in messages and in campaigns, samples from zero in Rust.
//! - Outputs appear whole or not at all.
//!
//! # Not covered
//! Missing rows, UTF-16 without a byte order mark, binary recordings other than raw 32-bit floats and those of [`formats`].

mod addressed;
mod append_log;
mod attitude;
mod clock;
mod clock_findings;
mod column_head;
mod conversion;
mod digest;
mod error;
pub mod field;
mod findings;
pub mod finite;
mod inspection;
mod layout;
mod loan;
mod output;
mod provenance;
mod reading;
mod recording;
mod rewriter;
mod rows;
mod segments;
mod sensitivity;
pub mod sheet;
mod signature;
mod software;
mod source;
pub mod spelling;
mod stamp;
mod stream;
mod table;
mod thermometer;
mod time_base;
mod time_unit;
mod time_window;
mod trace;
mod unit;
mod unit_ratio;
mod waiting_rows;
mod waveform;
mod written;

pub use addressed::Addressee;
pub use append_log::AppendLog;
pub use attitude::{AttitudeColumns, GivenAttitude, TrueAcceleration, check_agreement};
pub use clock::{Clock, Gap};
pub use clock_findings::doubtful_times;
pub use conversion::{
    Conversion, ConversionPlan, Filling, RowClock, Survey, Surveyed, TargetForm, TimedLayout,
    TimedRows,
};
pub use digest::sha256;
pub use error::{Error, ErrorKind, Result};
pub use findings::CATALOGUE;
pub use inspection::{
    BadEntry, ColumnSummary, Inspection, Statistics, TimeSummary, inspect, inspect_source,
    inspect_traced,
};
pub use layout::{ColumnRef, Layout, LayoutOptions, Separator};
pub use loan::{Content, Loan, is_lent, lend};
pub use output::{
    AtomicFile, Listed, MANIFEST, MANIFEST_SCHEMA, MANIFEST_VERSION, Manifest, OutputFolder,
    RESULT_SCHEMA, discard_unfinished, not_an_input,
};
pub use proofmass_formats as formats;
pub use proofmass_uncertainty::DecimalMark;
pub use provenance::{
    FORGED, PROVENANCE_SCHEMA, PROVENANCE_VERSION, Provenance, listing, unlisted,
};
pub use reading::{ReadColumn, ReadGravity, ReadQuantity, ReadStream, ReadTime, Reading};
pub use recording::{Absent, Input, RecordedColumn, Recording, RecordingOptions};
pub use rewriter::Rewriter;
pub use rows::{BadRow, RowBlock, RowReader};
pub use segments::SegmentRow;
pub use sensitivity::Sensitivity;
pub use signature::{Signature, SigningKey, VerifyingKey};
pub use software::{Schema, Software};
pub use source::{LARGEST_DOCUMENT, Source};
pub use stamp::Stamp;
pub use stream::{StreamLayout, StreamSummary};
pub use table::{Cell, RowWriter, Table};
pub use thermometer::Thermometer;
pub use time_base::{TimeBase, TimeSource, backwards};
pub use time_unit::{ClockUnit, SaidBy, TimeUnit};
pub use time_window::{TimeWindow, zero_of_times};
pub use trace::Trace;
pub use unit::{Unit, split_heading};
pub use unit_ratio::UnitRatio;
pub use waiting_rows::{ReadyRows, WaitingRows, rows_outside};
pub use waveform::{SampleTimes, Waveform, WaveformFormat, WaveformOptions, f32_bytes, write_f32};
pub use written::Written;

/// The example of the README, so that it stays true.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
