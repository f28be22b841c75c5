//! `[mounting]`: from the sensitivity as the device was mounted to that of another mounting, by a stated ratio over frequency.

use crate::campaign::CampaignFile;
use crate::findings;
use proofmass_dynamic::log_frequency::place;
use proofmass_io::sheet::{FREQUENCY, RATIO, Sheet};
use proofmass_io::{Error, ErrorKind, Input, Result};
use proofmass_shaker::{Acts, ShakerInput};
use proofmass_uncertainty::Finding;
use serde::Deserialize;
use std::path::Path;

/// `[mounting]` of a triaxial campaign.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MountingTable {
    /// Table of the ratio over frequency, relative to the campaign: `frequency_Hz`, `ratio` (sensitivity with the mounting that the result
    /// is to be of, over that with the mounting of the runs) and `u_ratio`, its standard uncertainty.
    pub(crate) file: String,
    /// The mounting that the result is to be of, in words.
    pub(crate) description: Option<String>,
}

/// A ratio of two mountings over frequency.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MountingRatio {
    /// Hz, ratio, relative standard uncertainty; ascending.
    points: Vec<[f64; 3]>,
    description: Option<String>,
    pub(crate) input: Input,
}

/// Name of its entry of the budget.
pub(crate) const KEY: &str = "mounting.correction";
/// Largest and least ratio of two mountings; beyond them a percentage or a difference stands in its place.
const POSSIBLE: (f64, f64) = (0.5, 2.0);

impl MountingRatio {
    /// Reads the table.
    ///
    /// # Errors
    /// A table that cannot be read, a ratio or an uncertainty that cannot be, with line and column.
    pub(crate) fn read(source: &CampaignFile, table: &MountingTable) -> Result<Self> {
        let mut sheet = Sheet::from_source(source.source(&table.file)?, "table of the mounting")?;
        let frequency = sheet.quantity("frequency", FREQUENCY)?;
        let ratio = sheet.quantity("ratio", RATIO)?;
        let u = sheet.quantity("u_ratio", RATIO)?;
        sheet.finish()?;
        let frequency = sheet.required(frequency, "frequency_Hz")?;
        let ratio = sheet.required(ratio, "ratio")?;
        let u = sheet.required(u, "u_ratio")?;
        let mut points: Vec<[f64; 3]> = Vec::new();
        for row in sheet.rows() {
            let at = row.positive(frequency)?;
            let value = row.positive(ratio)?;
            if !(POSSIBLE.0..=POSSIBLE.1).contains(&value) {
                return Err(row
                    .refuse(ratio, format!("{value} is no ratio of two mountings"))
                    .with_hint("about 1: of a sensitivity that is 0.5 % larger with the other mounting 1.005; in per cent under the heading ratio_%"));
            }
            let u = row.uncertainty(Some(u))? / value;
            if let Some([before, ..]) = points.last()
                && *before >= at
            {
                return Err(row
                    .refuse(frequency, format!("{at} Hz behind {before} Hz"))
                    .with_hint("list each frequency once, in ascending order"));
            }
            points.push([at, value, u]);
        }
        Ok(Self {
            points,
            description: table.description.clone(),
            input: sheet.input.clone(),
        })
    }

    /// Ratio and its relative standard uncertainty at a frequency, Hz: between two of the table linear in log f.
    ///
    /// # Errors
    /// A frequency that the table does not reach.
    pub(crate) fn at(&self, frequency: f64) -> Result<(f64, f64)> {
        let points = &self.points;
        let Some((k, share)) = place(points, |p| p[0], frequency) else {
            let ends = points.first().zip(points.last());
            let (low, high) = ends.map_or((0.0, 0.0), |(a, b)| (a[0], b[0]));
            return Err(Error::new(
                ErrorKind::Configuration,
                format!(
                    "the ratio of the mountings is stated from {low} to {high} Hz, and a run is at {frequency} Hz"
                ),
            )
            .at(Path::new(&self.input.path))
            .column("mounting")
            .with_hint("add the frequency to its table: nobody knows the ratio beyond it"));
        };
        let a = points[k];
        let b = points.get(k + 1).copied().unwrap_or(a);
        let mix = |i: usize| a[i] + share * (b[i] - a[i]);
        Ok((mix(1), mix(2)))
    }

    /// What is uncertain of it, as one error of all outputs and frequencies; `None` where it is stated as exact.
    ///
    /// # Errors
    /// As [`MountingRatio::at`].
    pub(crate) fn budget(&self, frequencies: &[f64]) -> Result<Option<ShakerInput>> {
        let mut list = Vec::with_capacity(frequencies.len());
        for f in frequencies {
            list.push((*f, self.at(*f)?.1));
        }
        if list.iter().all(|(_, u)| *u == 0.0) {
            return Ok(None);
        }
        let input = ShakerInput::new(KEY, Acts::OutputModulus, 0.0, &[])
            .described("ratio of the mounting of the result to that of the runs");
        Ok(Some(input.over_frequency(list)))
    }

    /// That it was applied.
    ///
    /// # Errors
    /// As [`MountingRatio::at`].
    pub(crate) fn finding(&self, frequencies: &[f64]) -> Result<Finding> {
        let (mut low, mut high, mut u) = (f64::INFINITY, 0.0f64, 0.0f64);
        for f in frequencies {
            let (ratio, relative) = self.at(*f)?;
            (low, high, u) = (low.min(ratio), high.max(ratio), u.max(relative));
        }
        let name = self.description.as_deref();
        Ok(findings::mounting_corrected(
            name.unwrap_or("another mounting than that of the runs"),
            low,
            high,
            100.0 * u,
            &self.input.path,
        ))
    }
}
