//! Missing rows and time stamps that jump.

use crate::record::check_sample_rate;
use proofmass_core::Error;
use proofmass_signal::clock;
use serde::{Deserialize, Serialize};

/// What is done about gaps. Nothing here bridges them.
#[doc(alias("missing samples"))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Gaps {
    /// A gap is an error.
    Refuse,
    /// Only the longest stretch without a gap is analysed, and a finding says what was left out.
    LongestStretch,
    /// Every stretch is analysed, each with a mean of its own.
    #[default]
    AllStretches,
}

/// Why the record is interrupted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GapKind {
    /// A value is missing (NaN) in at least one channel.
    Missing,
    /// The time stamps stay later from here on: samples were lost.
    Jump,
    /// The time stamps stay earlier from here on: a clock was set, or rows stand twice.
    Backwards,
}

/// One interruption of the record.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RecordGap {
    /// Why.
    pub kind: GapKind,
    /// First row of missing values, or the first row behind the jump.
    pub row: usize,
    /// Rows that are missing: counted for missing values, by the line of the stamps for a jump.
    pub rows: usize,
}

/// First row and one past the last of each stretch without interruption, and the gaps between them.
pub type Stretches = (Vec<(usize, usize)>, Vec<RecordGap>);

/// Stretches of rows without interruption, and what lies between them.
///
/// Stamps are compared with the line of their clock ([`proofmass_signal::clock`]): jitter and bursts interrupt nothing.
///
/// **Shapes** `channels` of equal length, `stamps` (s) of that length when given.
///
/// **Errors** [`Error::Length`] for lengths that differ, [`Error::OutOfRange`] for the sample rate.
pub fn stretches(
    channels: &[&[f64]],
    stamps: Option<&[f64]>,
    sample_rate: f64,
) -> Result<Stretches, Error> {
    check_sample_rate(sample_rate)?;
    let n = channels.first().map_or(0, |c| c.len());
    for c in channels {
        if c.len() != n {
            return Err(Error::Length {
                name: "channel",
                expected: n,
                got: c.len(),
            });
        }
    }
    if let Some(stamps) = stamps
        && stamps.len() != n
    {
        return Err(Error::Length {
            name: "time stamps",
            expected: n,
            got: stamps.len(),
        });
    }
    let finite = |s: &&[f64]| s.len() > 2 && s.iter().all(|t| t.is_finite());
    let mut slips = match stamps.filter(finite) {
        Some(stamps) => clock::read(stamps, Some(sample_rate)).map_or_else(|_| Vec::new(), |c| c.1),
        None => Vec::new(),
    }
    .into_iter()
    .peekable();
    let mut runs = Vec::new();
    let mut gaps: Vec<RecordGap> = Vec::new();
    let mut start = 0;
    let mut missing_from: Option<usize> = None;
    for row in 0..n {
        let slip = slips.next_if(|s| s.row == row);
        let stamped = stamps.is_none_or(|s| s[row].is_finite());
        if !stamped || channels.iter().any(|c| !c[row].is_finite()) {
            if missing_from.is_none() {
                missing_from = Some(row);
                if row > start {
                    runs.push((start, row));
                }
            }
            start = row + 1;
            continue;
        }
        if let Some(first) = missing_from.take() {
            gaps.push(RecordGap {
                kind: GapKind::Missing,
                row: first,
                rows: row - first,
            });
        }
        if let Some(slip) = slip {
            gaps.push(RecordGap {
                kind: if slip.samples > 0 {
                    GapKind::Jump
                } else {
                    GapKind::Backwards
                },
                row,
                rows: usize::try_from(slip.samples).unwrap_or(0),
            });
            if row > start {
                runs.push((start, row));
            }
            start = row;
        }
    }
    if let Some(first) = missing_from {
        gaps.push(RecordGap {
            kind: GapKind::Missing,
            row: first,
            rows: n - first,
        });
    }
    if start < n {
        runs.push((start, n));
    }
    Ok((runs, gaps))
}

/// The stretches to analyse under a policy.
///
/// **Errors** under [`Gaps::Refuse`]: [`Error::NotFinite`] at a missing row, [`Error::TooMany`] with the number of
/// gaps where stamps jump.
pub(crate) fn choose(
    policy: Gaps,
    runs: Vec<(usize, usize)>,
    gaps: &[RecordGap],
) -> Result<Vec<(usize, usize)>, Error> {
    if policy == Gaps::Refuse
        && let Some(gap) = gaps.first()
    {
        return Err(match gap.kind {
            GapKind::Missing => Error::NotFinite {
                name: "rate",
                index: gap.row,
            },
            GapKind::Jump | GapKind::Backwards => Error::TooMany {
                name: "gaps",
                most: 0,
                got: gaps.len(),
            },
        });
    }
    Ok(match policy {
        Gaps::LongestStretch => runs
            .into_iter()
            .max_by_key(|(a, b)| (b - a, usize::MAX - a))
            .into_iter()
            .collect(),
        _ => runs,
    })
}
