//! Block by block through the channels of a stream.

use crate::raw::Window;
use crate::stream::{Column, Source};
use crate::{Container, Error, Result};

/// Rows that are given at once, where a row is short: the numbers of a few channels stay near the processor.
const ROWS: u64 = 1 << 14;
/// Bytes of the file that are fetched at once.
const FETCHED: u64 = 1 << 20;

/// Reads channels of one stream.
pub struct Rows {
    container: Container,
    stream: usize,
    chosen: Vec<usize>,
    rest: u64,
    window: Window,
}

impl Rows {
    pub(crate) fn new(container: Container, stream: usize, channels: &[usize]) -> Result<Self> {
        let mut rows = Self {
            container,
            stream,
            chosen: Vec::new(),
            rest: 0,
            window: Window::default(),
        };
        rows.restart(channels)?;
        Ok(rows)
    }

    /// Begins again with the first row, with other channels.
    ///
    /// # Errors
    /// No such stream or channel.
    pub fn restart(&mut self, channels: &[usize]) -> Result<()> {
        let none = || Error::new("there is no such stream or channel");
        let stream = self
            .container
            .streams
            .get_mut(self.stream)
            .ok_or_else(none)?;
        if channels.iter().any(|c| *c >= stream.channels.len()) {
            return Err(none());
        }
        self.rest = stream.rows;
        self.chosen = channels.to_vec();
        let sources = stream.columns.iter_mut().flat_map(|c| &mut c.sources);
        sources.for_each(Source::rewind);
        Ok(())
    }

    /// The container that is read.
    pub fn container(&self) -> &Container {
        &self.container
    }

    /// The stream that is read.
    pub fn stream(&self) -> &crate::Stream {
        &self.container.streams[self.stream]
    }

    /// Rows that are still to come.
    pub fn rest(&self) -> u64 {
        self.rest
    }

    /// Puts the next rows in place of what stands in `block`, a column for each channel that was chosen in their order; 0 at the end.
    ///
    /// # Errors
    /// The operating system refuses; the file changed.
    pub fn next_block(&mut self, block: &mut [Vec<f64>]) -> Result<usize> {
        block.iter_mut().for_each(Vec::clear);
        let Container {
            streams,
            file,
            scaled,
            ..
        } = &mut self.container;
        let columns = &mut streams[self.stream].columns;
        let strides = self.chosen.iter().flat_map(|&c| &columns[c].sources);
        let strides = strides.map(Source::stride);
        let stride = strides.max().unwrap_or(1).max(1);
        let n = self.rest.min((FETCHED / stride).clamp(1, ROWS)) as usize;
        self.rest -= n as u64;
        for (&number, to) in self.chosen.iter().zip(block) {
            fill(
                &mut columns[number],
                n,
                *scaled,
                &mut self.window,
                &mut **file,
                to,
            )?;
        }
        Ok(n)
    }
}

/// The next numbers of a channel.
fn fill(
    column: &mut Column,
    n: usize,
    scaled: bool,
    window: &mut Window,
    file: &mut dyn crate::SeekRead,
    to: &mut Vec<f64>,
) -> Result<()> {
    match &mut column.sources[..] {
        sources if scaled && !column.scaling.is_chain() => {
            let mut stored = Vec::with_capacity(sources.len());
            for source in sources {
                let mut numbers = Vec::with_capacity(n);
                source.read(window, file, n, &mut numbers)?;
                stored.push(numbers);
            }
            *to = column.scaling.apply(stored);
        }
        [first, ..] => {
            first.read(window, file, n, to)?;
            if scaled {
                column.scaling.apply_chain(to);
            }
        }
        [] => {}
    }
    match to.len() == n {
        true => Ok(()),
        false => Err(Error::new("a channel has fewer samples than its stream")),
    }
}
