//! A recording that is read once, block by block, and never held as a whole.

use super::{Found, Noise, columns, sensor, tables, unit_name};
use crate::{Failure, console};
use proofmass::io::{Block, Input, Layout, LayoutOptions, RowReader, TimeUnit};
use proofmass::noise::{ChannelName, LongRecord};
use proofmass::uncertainty::{Finding, Severity};
use std::ops::Range;

/// A step longer than this many nominal steps is a gap.
const GAP: f64 = 1.5;

/// Consecutive rows of a block without a gap between them.
struct Run {
    behind_gap: bool,
    rows: Range<usize>,
}

/// What is known of the times while the recording goes by.
struct Clock {
    /// Units of the time column in a second; none for a stated rate.
    per_second: Option<f64>,
    /// Samples per second: as stated, or of the first block.
    nominal: f64,
    last: Option<f64>,
    /// Steps that are not gaps, and the time they took.
    steps: u64,
    seconds: f64,
    gaps: u64,
}

impl Clock {
    fn new(per_second: Option<f64>, nominal: f64) -> Self {
        Self {
            per_second,
            nominal,
            last: None,
            steps: 0,
            seconds: 0.0,
            gaps: 0,
        }
    }

    /// Runs of rows between gaps; the times stand in `column`.
    fn runs(&mut self, noise: &Noise, block: &Block, column: usize) -> Result<Vec<Run>, Failure> {
        let Some(per_second) = self.per_second else {
            return Ok(vec![Run {
                behind_gap: false,
                rows: 0..block.rows(),
            }]);
        };
        let times: Vec<f64> = block
            .column(column)
            .iter()
            .map(|t| t / per_second)
            .collect();
        if self.last.is_none() && times.len() > 1 {
            let mut steps: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
            let middle = steps.len() / 2;
            let median = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
            let even: Vec<f64> = steps.into_iter().filter(|s| *s <= GAP * median).collect();
            self.nominal = even.len() as f64 / even.iter().sum::<f64>();
        }
        let mut runs = Vec::new();
        let (mut first, mut behind_gap) = (0, false);
        for (row, &time) in times.iter().enumerate() {
            let Some(last) = self.last.replace(time) else {
                continue;
            };
            let step = time - last;
            if step <= 0.0 {
                return Err(Failure::new(format!(
                    "the time does not advance, from {last} s to {time} s"
                ))
                .detail(format!("{}:{}", noise.recording.display(), block.line(row)))
                .hint("look for a restart of the clock or a doubled row, or give --rate in place of the time column"));
            }
            if step * self.nominal > GAP {
                if row > 0 {
                    runs.push(Run {
                        behind_gap,
                        rows: first..row,
                    });
                }
                (first, behind_gap) = (row, true);
                self.gaps += 1;
            } else {
                self.steps += 1;
                self.seconds += step;
            }
        }
        runs.push(Run {
            behind_gap,
            rows: first..times.len(),
        });
        Ok(runs)
    }

    /// Samples per second, over all steps that are not gaps.
    fn rate(&self) -> f64 {
        if self.steps > 0 {
            self.steps as f64 / self.seconds
        } else {
            self.nominal
        }
    }
}

/// The last integral of each column, from which the next rate is taken.
#[derive(Default)]
struct Integrals {
    last: Vec<f64>,
}

impl Integrals {
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

pub(super) fn analyse(noise: &Noise) -> Result<Found, Failure> {
    let layout = Layout::sniff_with(&noise.recording, &LayoutOptions::default())?;
    let mut selected = columns::chosen(noise, &layout)?
        .iter()
        .map(|c| layout.find(c))
        .collect::<Result<Vec<_>, _>>()?;
    let mut factors = Vec::new();
    let mut names = Vec::new();
    for &index in &selected {
        let name = layout.name(index);
        let (unit, factor) = columns::conversion(noise, &name, layout.unit(index))?;
        factors.push(factor);
        names.push(ChannelName {
            name,
            sensor: sensor(unit),
            unit: unit_name(unit),
        });
    }
    let mut clock = match (noise.rate, columns::time(noise, &layout)?) {
        (Some(rate), time) if time.is_none() || noise.time.is_none() => Clock::new(None, rate),
        (rate, Some(index)) => {
            selected.push(index);
            let unit = noise
                .time_unit
                .or_else(|| layout.unit(index).and_then(TimeUnit::of))
                .unwrap_or(TimeUnit::Second);
            Clock::new(Some(unit.per_second(rate).unwrap_or(1.0)), f64::NAN)
        }
        (_, None) => {
            return Err(
                Failure::new("neither a time column nor a sampling rate is known")
                    .detail(noise.recording.display().to_string())
                    .hint("add --rate or --time"),
            );
        }
    };
    let sensors = names.iter().map(|n| n.sensor).collect();
    let mut record = LongRecord::new(names);
    let mut integrals = noise.phase.then(Integrals::default);
    let mut reader = RowReader::open(&noise.recording, layout.clone(), &selected)?;
    let size = std::fs::metadata(&noise.recording)?.len();
    let bar = console::progress(size, "reading the recording");
    while let Some(block) = reader.next_block()? {
        for run in clock.runs(noise, &block, factors.len())? {
            if run.behind_gap {
                record.gap();
                if let Some(integrals) = &mut integrals {
                    integrals.last.clear();
                }
            }
            let mut piece: Vec<Vec<f64>> = (0..factors.len())
                .map(|c| block.column(c)[run.rows.clone()].to_vec())
                .collect();
            let mut scale = 1.0;
            if let Some(integrals) = &mut integrals {
                piece = integrals.rates(piece);
                scale = clock.nominal;
            }
            for (column, factor) in piece.iter_mut().zip(&factors) {
                let factor = factor * scale;
                if factor != 1.0 {
                    column.iter_mut().for_each(|v| *v *= factor);
                }
            }
            let slices: Vec<&[f64]> = piece.iter().map(Vec::as_slice).collect();
            record.push(&slices).map_err(|e| noise.failure(e))?;
        }
        bar.set_position(reader.bytes_read());
    }
    bar.finish_and_clear();
    let sha256 = reader.sha256()?;
    if noise.refuse_gaps && clock.gaps > 0 {
        return Err(
            Failure::new(format!("the recording has {} gaps in time", clock.gaps))
                .detail(noise.recording.display().to_string())
                .hint("leave out --refuse-gaps: no statistic reaches across them"),
        );
    }
    let mut analysis = record
        .analyse(clock.rate(), &noise.options())
        .map_err(|e| noise.failure(e))?;
    if clock.gaps > 0 {
        analysis.findings.retain(|f| f.code() != "gaps-in-record");
        analysis.findings.push(
            Finding::new(
                Severity::Warning,
                "gaps-in-record",
                "the record is interrupted; the Allan curve leaves the gaps out, the rest is that of the longest stretch",
            )
            .evidence(format!("{} gaps; {} samples in all", clock.gaps, record.samples()))
            .advice("look for lost packets or a logger that pauses"),
        );
    }
    let samples = (0..factors.len())
        .map(|c| {
            let kept = record.averages(c);
            let (from, to) = (
                analysis.rows.0 / analysis.averaged,
                (analysis.rows.1 / analysis.averaged).min(kept.len()),
            );
            kept[from..to].to_vec()
        })
        .collect();
    Ok(Found {
        input: Input {
            path: noise.recording.display().to_string(),
            sha256,
        },
        findings: tables::findings(&layout.findings(), &analysis),
        sensors,
        samples,
        analysis,
    })
}
