//! Recordings of sensors at rest that are read once.

use super::{NoiseBlock, NoiseBlocks, NoiseData, NoiseSamples};
use crate::block_clock::BlockClock;
use crate::trouble::{Result, Trouble};
use proofmass_io::{Input, Reading, RowReader};
use proofmass_noise::ChannelName;
use proofmass_uncertainty::Finding;
use std::collections::VecDeque;
use std::sync::Mutex;

/// A recording that is read once, block by block, and never held as a whole.
pub struct NoiseStream {
    pub(super) blocks: FileBlocks,
    pub(super) names: Vec<ChannelName>,
    pub(super) findings: Vec<Finding>,
    pub(super) name: String,
    /// How it is read; the rate is known at the end.
    pub(super) reading: Reading,
}

impl NoiseStream {
    /// The data of the job.
    pub fn data(&mut self) -> NoiseData<'_> {
        let channels = self.names.clone();
        NoiseData {
            samples: NoiseSamples::Stream {
                channels,
                blocks: Mutex::new(&mut self.blocks),
            },
            findings: &self.findings,
            name: &self.name,
        }
    }

    /// The file and its digest, once the job is done.
    ///
    /// # Errors
    /// The rest of the file cannot be read.
    pub fn finish(self) -> Result<Input> {
        let mut reading = self.reading;
        reading.time.rate_hz = self.blocks.clock.rate();
        Ok(self.blocks.reader.finish()?.with_reading(reading))
    }
}

/// The rows of a file as blocks of evenly spaced samples.
pub(super) struct FileBlocks {
    pub(super) reader: RowReader,
    pub(super) factors: Vec<f64>,
    pub(super) clock: BlockClock,
    /// Whether the columns are integrals of the rate.
    pub(super) phase: bool,
    /// The last integral of each column, from which the next rate is taken.
    pub(super) last: Vec<f64>,
    pub(super) ready: VecDeque<NoiseBlock>,
    pub(super) name: String,
}

impl NoiseBlocks for FileBlocks {
    fn next_block(&mut self) -> Result<Option<NoiseBlock>> {
        loop {
            if let Some(block) = self.ready.pop_front() {
                return Ok(Some(block));
            }
            let Some(block) = self.reader.next_block()? else {
                return Ok(None);
            };
            let count = self.factors.len();
            let runs = match self.clock.per_second {
                Some(_) => {
                    let breaks = self.clock.breaks(block.column(count)).map_err(|(row, what)| {
                        Trouble::data(what)
                            .detail(format!("{}:{}", self.name, block.line(row)))
                            .with_hint("look for a restart of the clock or a doubled row, or give --rate in place of the time column")
                    })?;
                    let mut edges = vec![0];
                    edges.extend(breaks.iter().copied().filter(|b| *b > 0));
                    edges.push(block.rows());
                    let first = breaks.first() == Some(&0);
                    edges
                        .windows(2)
                        .map(|w| (w[0]..w[1], w[0] > 0 || first))
                        .collect()
                }
                None => vec![(0..block.rows(), false)],
            };
            for (rows, behind_gap) in runs {
                let mut columns: Vec<Vec<f64>> = (0..count)
                    .map(|c| block.column(c)[rows.clone()].to_vec())
                    .collect();
                let mut scale = 1.0;
                if self.phase {
                    if behind_gap {
                        self.last.clear();
                    }
                    columns = self.rates(columns);
                    scale = self.clock.nominal;
                }
                for (column, factor) in columns.iter_mut().zip(&self.factors) {
                    let factor = factor * scale;
                    if factor != 1.0 {
                        column.iter_mut().for_each(|v| *v *= factor);
                    }
                }
                self.ready.push_back(NoiseBlock {
                    behind_gap,
                    columns,
                });
            }
        }
    }

    fn rate(&self) -> Option<f64> {
        self.clock.rate()
    }

    fn gaps(&self) -> u64 {
        self.clock.gaps
    }

    fn progress(&self) -> (u64, u64) {
        (self.reader.bytes_read(), self.reader.size().unwrap_or(0))
    }
}

impl FileBlocks {
    /// Differences of each column, one fewer at the beginning and behind a gap.
    fn rates(&mut self, columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        let ends: Vec<f64> = columns.iter().filter_map(|c| c.last().copied()).collect();
        let rates = columns
            .into_iter()
            .enumerate()
            .map(|(k, mut column)| {
                if let Some(&last) = self.last.get(k) {
                    column.insert(0, last);
                }
                column.windows(2).map(|w| w[1] - w[0]).collect()
            })
            .collect();
        if !ends.is_empty() {
            self.last = ends;
        }
        rates
    }
}
