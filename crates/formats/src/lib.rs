//! Recordings of others, read as streams of samples.
//!
//! A [`Container`] is a file that was recognised by its content and gives one or more [`Stream`]s: channels on one clock, with their
//! names, units and scaling. [`Container::rows`] reads one of them block by block.
//!
//! ```
//! use proofmass_formats::Container;
//! use std::io::Cursor;
//!
//! // A WAV file of two samples of 16 bits.
//! let mut file = Vec::new();
//! file.extend(b"RIFF\x28\0\0\0WAVEfmt \x10\0\0\0\x01\0\x01\0");
//! file.extend(8000_u32.to_le_bytes());
//! file.extend(16_000_u32.to_le_bytes());
//! file.extend(b"\x02\0\x10\0data\x04\0\0\0\x01\0\xff\xff");
//! let container = Container::open(Box::new(Cursor::new(file)))?;
//! assert_eq!(container.format().word, "wav");
//! let mut rows = container.rows(0, &[0])?;
//! let mut block = vec![Vec::new()];
//! assert_eq!(rows.next_block(&mut block)?, 2);
//! assert_eq!(block[0], [1.0, -1.0]);
//! # Ok::<(), proofmass_formats::Error>(())
//! ```
//!
//! # Conventions
//! - Whatever a file claims of its size is compared with the bytes that are there, before memory is asked for.
//! - A scaling that the file declares is applied once; [`Container::without_scaling`] leaves it off.
//! - Names of persons, birth dates and positions in headers are not passed on.

mod archive;
mod arrays;
mod bytes;
pub mod calendar;
mod cwa;
mod error;
mod geneactiv;
mod gt3x;
mod hdf5;
mod held_rows;
mod ide;
mod input;
mod lvm;
mod mat;
mod mcap;
mod names;
mod npy;
#[cfg(feature = "parquet")]
mod parquet;
mod raw;
mod recognise;
mod rows;
mod scaling;
mod stream;
mod tdms;
mod text;
mod uff;
mod ulog;
mod unisens;
mod wav;
pub mod write;
mod zip;

pub use error::{Error, Result};
pub use recognise::{FORMATS, Format, recognise};
pub use rows::Rows;
pub use stream::{
    ABSENT, Beside, Channel, Clock, Container, HEAD, Remark, RemarkKind, SeekRead, Stream,
    is_absent,
};

/// The example of the README, so that it stays true.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
