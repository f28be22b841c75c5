//! Every job of the accelerometer laboratory: a request as plain data, its data, one typed outcome.
//!
//! A command line, a server, a notebook and a batch over a thousand sensors ask the same questions. Here each
//! question is a [`Job`]: a request without paths, terminal or clock, evaluated against data in memory, answered by
//! an [`Outcome`] that decides the principal result once and can be written, read again and rendered by anyone.
//! What belongs to the caller comes as an argument: the date in a [`Record`], progress and cancellation as a
//! [`Watch`], files as a [`Store`].

mod any_job;
pub mod apply;
#[cfg(feature = "clap")]
mod arguments;
mod bench_runs;
pub mod bias;
mod block_clock;
pub mod campaign;
pub mod certificate;
mod channels;
pub mod comparison;
pub mod convert;
pub mod data_sheet;
pub mod deconvolution;
mod destination;
pub mod device_check;
mod device_output;
pub mod device_plan;
mod error_code;
pub mod findings;
pub mod firmware;
pub mod free_living;
pub mod frequency_response;
pub mod inspect;
mod known_keys;
mod laboratory_table;
pub mod linearity;
mod measured_within;
pub mod modes;
pub mod motion;
pub mod multi_position;
pub mod noise;
pub mod noise_comparison;
mod observed;
mod outcome;
mod page;
pub mod plan;
mod plural;
mod record;
mod recording;
pub mod required_density;
pub mod response;
#[cfg(feature = "schema")]
pub mod schema;
mod sensor_clock;
pub mod shaker_primary;
pub mod shaker_single;
pub mod shaker_triaxial;
pub mod shock;
pub mod simulate;
pub mod spurious_motion;
mod standstills;
pub mod static_test;
pub mod step;
mod store;
mod stored_result;
mod stream_choice;
pub mod temperature;
pub mod transverse;
mod trouble;
pub mod uncertainty;
pub mod units;
pub mod validation;
mod value_range;
pub mod velocity;
pub mod verification;

pub use any_job::{AnyData, AnyJob, result_kinds};
pub use bench_runs::{BenchFiles, BenchRuns};
pub use channels::{Channel, ChannelReading, RecordedChannel, RecordedChannels, WantedChannel};
pub use destination::{Beside, Destination};
pub use device_output::DeviceOutput;
#[doc(hidden)]
pub use error_code::page as errors_page;
pub use error_code::{ErrorCode, error_codes};
pub use outcome::{Job, Outcome, QUANTITIES, section};
pub use proofmass_core::{Unwatched, Watch};
pub use record::Record;
pub use recording::RecordingReading;
pub use sensor_clock::SensorClock;
pub use store::{Folder, Gathered, Memory, Sink, Store};
pub use stored_result::{CALIBRATION, REPORT, RESULT, StoredResult};
pub use stream_choice::{StatedMarks, StreamChoice};
pub use trouble::{Result, Trouble, TroubleKind};

/// The example of the README, so that it stays true.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
