//! A file as streams, each of them channels on one clock.

use crate::calendar::date_time;
use crate::hdf5::Chunked;
use crate::held_rows::HeldRows;
use crate::names::{shortened, shown};
use crate::raw::{Raw, Window};
use crate::recognise::Reader;
use crate::scaling::Scaling;
use crate::{Error, Format, Result, Rows, recognise};
use std::collections::{HashMap, HashSet};
use std::io::{Read, Seek, SeekFrom};

/// What a file is read from.
pub trait SeekRead: Read + Seek + Send {}

impl<T: Read + Seek + Send> SeekRead for T {}

/// Opens a file that lies beside another, by its name alone; none where no such file is there.
pub type Beside<'a> = dyn FnMut(&str) -> std::io::Result<Option<Box<dyn SeekRead>>> + 'a;

/// A signal of a stream.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Channel {
    /// Name as it stands in the file, without its unit; of a very long one the beginning, and no control characters.
    pub name: String,
    /// Word for the unit as it stands in the file.
    pub unit: Option<String>,
    /// What the file declares to be done to the stored numbers, and was: `linear`, `polynomial`.
    pub scaling: Option<String>,
}

/// Stands where a channel has no number in a row: a NaN that is told from one that was recorded.
pub const ABSENT: f64 = f64::from_bits(0x7FF8_0000_0000_4E41);

/// Whether a number is [`ABSENT`].
pub fn is_absent(value: f64) -> bool {
    value.to_bits() == ABSENT.to_bits()
}

/// What tells the times of the samples of a stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clock {
    /// The file says the rate.
    Rate {
        /// Samples per second.
        hz: f64,
        /// Time of the first sample, s, where the file counts from elsewhere.
        start_s: f64,
    },
    /// The last channel holds the times.
    Times,
    /// Nothing.
    Unsaid,
}

/// What a file says of itself that a reader must know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RemarkKind {
    /// It ends before what it announces; what stands before is whole.
    Cut,
    /// A part is damaged and left out.
    Damaged,
    /// A part is whole and of a kind that is not read.
    PassedOver,
}

/// Letters of a remark.
const LONGEST_REMARK: usize = 1000;

/// A remark about a file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Remark {
    /// Of which kind.
    pub kind: RemarkKind,
    /// One line, with the place.
    pub text: String,
}

impl Remark {
    pub(crate) fn cut(text: impl Into<String>) -> Self {
        let text = shortened(&text.into(), LONGEST_REMARK);
        Self {
            kind: RemarkKind::Cut,
            text,
        }
    }

    pub(crate) fn damaged(text: impl Into<String>) -> Self {
        let text = shortened(&text.into(), LONGEST_REMARK);
        Self {
            kind: RemarkKind::Damaged,
            text,
        }
    }

    pub(crate) fn passed_over(text: impl Into<String>) -> Self {
        let text = shortened(&text.into(), LONGEST_REMARK);
        Self {
            kind: RemarkKind::PassedOver,
            text,
        }
    }
}

/// Channels on one clock.
#[derive(Debug)]
#[non_exhaustive]
pub struct Stream {
    /// What it is chosen by.
    pub name: String,
    /// Its signals in the order of the file.
    pub channels: Vec<Channel>,
    /// Its clock.
    pub clock: Clock,
    /// Samples of each channel.
    pub rows: u64,
    /// Whole numbers out of a converter whose full scale the file does not say: the size of full scale.
    pub full_scale: Option<f64>,
    /// What the clock of the file showed where the times of the stream are zero, ns; where the file says so.
    pub origin_ns: Option<i64>,
    /// The numbers of each channel.
    pub(crate) columns: Vec<Column>,
}

impl Stream {
    /// Without channels.
    pub(crate) fn new(name: impl Into<String>, clock: Clock, rows: u64) -> Self {
        Self {
            name: shown(&name.into()),
            channels: Vec::new(),
            clock,
            rows,
            full_scale: None,
            origin_ns: None,
            columns: Vec::new(),
        }
    }

    /// When its times are zero, by the clock of the file: date and time. Nothing where the file does not say so, or its clock
    /// counts from something else than a date: before 1990, after 2099.
    pub fn start(&self) -> Option<String> {
        const DATES: std::ops::Range<i64> = 631_152_000..4_102_444_800;
        const SECOND: i64 = 1_000_000_000;
        let origin = self.origin_ns?;
        let seconds = origin.div_euclid(SECOND);
        let text = DATES.contains(&seconds).then(|| date_time(seconds))?;
        Some(match origin.rem_euclid(SECOND) {
            0 => text,
            part => format!("{text}.{part:09}").trim_end_matches('0').to_owned(),
        })
    }

    /// One more channel behind the others.
    pub(crate) fn push(&mut self, name: impl Into<String>, unit: Option<String>, column: Column) {
        self.insert(self.columns.len(), name, unit, column);
    }

    /// The times, which are the last channel.
    pub(crate) fn push_times(&mut self, times: Source) {
        self.push("time", Some("s".to_owned()), Column::of(times));
    }

    /// One more channel at a place.
    pub(crate) fn insert(
        &mut self,
        at: usize,
        name: impl Into<String>,
        unit: Option<String>,
        column: Column,
    ) {
        let channel = Channel {
            name: shown(&name.into()),
            unit: unit.map(|unit| shown(&unit)),
            scaling: column.scaling.words(),
        };
        self.channels.insert(at, channel);
        self.columns.insert(at, column);
    }
}

/// The numbers of one channel.
#[derive(Debug)]
pub(crate) struct Column {
    /// As stored; several where a scaling joins them.
    pub(crate) sources: Vec<Source>,
    pub(crate) scaling: Scaling,
}

/// Numbers as stored.
#[derive(Debug)]
pub(crate) enum Source {
    /// In the file.
    Raw(Raw),
    /// In chunks of the file.
    Chunked(Box<Chunked>),
    /// Read from text or unpacked, and how far reading has come.
    Held(Vec<f64>, usize),
    /// In rows that were unpacked.
    HeldRows(HeldRows),
    /// Straight lines one after the other.
    Lines(Lines),
    /// Of a column of a Parquet file.
    #[cfg(feature = "parquet")]
    Parquet(Box<crate::parquet::Chunks>),
}

/// Numbers on straight lines, and how far reading has come.
#[derive(Debug, Default)]
pub(crate) struct Lines {
    pub(crate) pieces: Vec<Line>,
    pub(crate) piece: usize,
    pub(crate) number: u64,
}

/// So many numbers from one on in equal steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub(crate) count: u64,
    pub(crate) first: f64,
    pub(crate) step: f64,
}

impl Lines {
    fn read(&mut self, most: usize, to: &mut Vec<f64>) {
        let mut wanted = most as u64;
        while let Some(line) = self.pieces.get(self.piece).filter(|_| wanted > 0) {
            let n = wanted.min(line.count - self.number);
            let numbers = self.number..self.number + n;
            to.extend(numbers.map(|i| line.first + i as f64 * line.step));
            wanted -= n;
            self.number += n;
            if self.number == line.count {
                (self.piece, self.number) = (self.piece + 1, 0);
            }
        }
    }
}

impl Source {
    pub(crate) fn held(numbers: Vec<f64>) -> Self {
        Self::Held(numbers, 0)
    }

    pub(crate) fn lines(pieces: Vec<Line>) -> Self {
        Self::Lines(Lines {
            pieces,
            ..Lines::default()
        })
    }

    pub(crate) fn rows(&self) -> u64 {
        match self {
            Self::Raw(raw) => raw.rows(),
            Self::Chunked(chunked) => chunked.rows(),
            Self::Held(numbers, _) => numbers.len() as u64,
            Self::HeldRows(rows) => rows.rows(),
            Self::Lines(lines) => lines.pieces.iter().map(|l| l.count).sum(),
            #[cfg(feature = "parquet")]
            Self::Parquet(chunks) => chunks.rows(),
        }
    }

    pub(crate) fn rewind(&mut self) {
        match self {
            Self::Raw(raw) => raw.rewind(),
            Self::Chunked(chunked) => chunked.rewind(),
            Self::Held(_, at) => *at = 0,
            Self::HeldRows(rows) => rows.rewind(),
            Self::Lines(lines) => (lines.piece, lines.number) = (0, 0),
            #[cfg(feature = "parquet")]
            Self::Parquet(chunks) => chunks.rewind(),
        }
    }

    /// Longest distance between two numbers in the file.
    pub(crate) fn stride(&self) -> u64 {
        match self {
            Self::Raw(raw) => raw.stride(),
            Self::Chunked(chunked) => chunked.stride(),
            Self::Held(..) | Self::HeldRows(_) | Self::Lines(_) => 1,
            #[cfg(feature = "parquet")]
            Self::Parquet(_) => 1,
        }
    }

    /// Appends the next numbers, at most so many.
    pub(crate) fn read(
        &mut self,
        window: &mut Window,
        file: &mut dyn SeekRead,
        most: usize,
        to: &mut Vec<f64>,
    ) -> Result<()> {
        match self {
            Self::Raw(raw) => raw.read(window, file, most, to),
            Self::HeldRows(rows) => {
                rows.read(most, to);
                Ok(())
            }
            #[cfg(feature = "parquet")]
            Self::Parquet(chunks) => chunks.read(file, most, to),
            Self::Chunked(chunked) => chunked.read(window, file, most, to),
            Self::Lines(lines) => {
                lines.read(most, to);
                Ok(())
            }
            Self::Held(numbers, at) => {
                let end = numbers.len().min(*at + most);
                to.extend_from_slice(&numbers[*at..end]);
                *at = end;
                Ok(())
            }
        }
    }
}

impl Column {
    pub(crate) fn of(source: Source) -> Self {
        Self::scaled(source, Scaling::none())
    }

    pub(crate) fn scaled(source: Source, scaling: Scaling) -> Self {
        Self {
            sources: vec![source],
            scaling,
        }
    }

    pub(crate) fn raw(raw: Raw) -> Self {
        Self::of(Source::Raw(raw))
    }
}

/// A recognised file.
pub struct Container {
    pub(crate) format: &'static Format,
    pub(crate) streams: Vec<Stream>,
    pub(crate) remarks: Vec<Remark>,
    pub(crate) file: Box<dyn SeekRead>,
    pub(crate) scaled: bool,
}

/// What a reader gives of a file.
pub(crate) struct Contents {
    pub(crate) streams: Vec<Stream>,
    pub(crate) remarks: Vec<Remark>,
}

/// So many bytes at the beginning tell every format.
pub const HEAD: usize = 4096;

impl Container {
    /// Opens a file by its content.
    ///
    /// # Errors
    /// A format that is not known or not read here, a file without samples, damage in its index.
    pub fn open(file: Box<dyn SeekRead>) -> Result<Self> {
        Self::open_beside(file, &mut |_| Ok(None))
    }

    /// Opens a file by its content, where it may name others that lie beside it.
    ///
    /// # Errors
    /// Those of [`Container::open`].
    pub fn open_beside(mut file: Box<dyn SeekRead>, beside: &mut Beside) -> Result<Self> {
        let mut head = Vec::new();
        file.seek(SeekFrom::Start(0))?;
        (&mut file).take(HEAD as u64).read_to_end(&mut head)?;
        let format =
            recognise(&head).ok_or_else(|| Error::new("is of no format that is known here"))?;
        let Some(read) = format.reader else {
            return Err(format.refusal());
        };
        let size = file.seek(SeekFrom::End(0))?;
        let (contents, file) = match read {
            Reader::Alone(read) => (read(&mut *file, size)?, file),
            Reader::WithOthers(read) => read(file, size, beside)?,
        };
        let Contents {
            mut streams,
            mut remarks,
        } = contents;
        streams.retain(|s| s.rows > 0 && !s.channels.is_empty());
        believable(&mut streams, &mut remarks);
        if streams.is_empty() {
            let more = remarks.first().map(|r| format!("; {}", r.text));
            return Err(Error::new(format!(
                "is {} without a single sample{}",
                format.name,
                more.unwrap_or_default()
            ))
            .with_hint("check that the recording was finished and holds numbers"));
        }
        distinct(&mut streams);
        Ok(Self {
            format,
            streams,
            remarks,
            file,
            scaled: true,
        })
    }

    /// Leaves off the scaling that the file declares: the numbers come as stored, and what the file says of their unit does not
    /// hold for them.
    #[must_use]
    pub fn without_scaling(mut self) -> Self {
        self.scaled = false;
        let channels = self.streams.iter_mut().flat_map(|s| &mut s.channels);
        for channel in channels.filter(|c| c.scaling.is_some()) {
            (channel.unit, channel.scaling) = (None, None);
        }
        self
    }

    /// Which format it is.
    pub fn format(&self) -> &'static Format {
        self.format
    }

    /// Its streams; at least one.
    pub fn streams(&self) -> &[Stream] {
        &self.streams
    }

    /// What the reader noticed about the file.
    pub fn remarks(&self) -> &[Remark] {
        &self.remarks
    }

    /// Reads channels of a stream, both by their number from zero, block by block.
    ///
    /// # Errors
    /// No such stream or channel.
    pub fn rows(self, stream: usize, channels: &[usize]) -> Result<Rows> {
        Rows::new(self, stream, channels)
    }
}

/// A rate that cannot be one is left away, and remarked.
fn believable(streams: &mut [Stream], remarks: &mut Vec<Remark>) {
    for stream in streams {
        let Clock::Rate { hz, start_s } = stream.clock else {
            continue;
        };
        let there = hz.is_finite() && hz > 0.0 && (1.0 / hz).is_finite();
        if !there || !start_s.is_finite() {
            stream.clock = Clock::Unsaid;
            remarks.push(Remark::damaged(format!(
                "the clock of the stream {}: {hz} samples per second from {start_s} s on, which cannot be",
                stream.name
            )));
        }
    }
}

/// Streams of one name get a number, so that each can be chosen.
fn distinct(streams: &mut [Stream]) {
    let mut taken: HashSet<String> = HashSet::new();
    let mut numbers: HashMap<String, u64> = HashMap::new();
    for stream in streams {
        let name = stream.name.clone();
        let number = numbers.entry(name.clone()).or_insert(1);
        while !taken.insert(stream.name.clone()) {
            *number += 1;
            stream.name = format!("{name} {number}").trim_start().to_owned();
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
