//! What coefficients are fitted to: stretches of one channel on one clock, and the temperature beside them.

use crate::record::{check_count, check_finite};
use proofmass_core::Error;

/// Stretches of one channel without gaps, and what was measured beside them.
#[derive(Clone, Copy, Debug)]
pub struct FitRecord<'a> {
    /// Rate samples of each stretch, U.
    pub stretches: &'a [&'a [f64]],
    /// Place of each stretch's first sample on the sampling clock; empty: one follows the other.
    pub starts: &'a [usize],
    /// Temperature in K (or °C) over the same stretches, sample by sample.
    pub temperature: Option<&'a [&'a [f64]]>,
}

impl<'a> FitRecord<'a> {
    /// Stretches one after the other, nothing beside them.
    pub fn new(stretches: &'a [&'a [f64]]) -> Self {
        Self {
            stretches,
            starts: &[],
            temperature: None,
        }
    }

    /// Lengths of the stretches, and their starts in s.
    pub(crate) fn lengths_and_starts(&self, sample_rate: f64) -> (Vec<usize>, Vec<f64>) {
        let lengths = self.stretches.iter().map(|s| s.len()).collect();
        let starts = self.starts().into_iter();
        (lengths, starts.map(|s| s as f64 / sample_rate).collect())
    }

    /// Starts on the sampling clock.
    pub(crate) fn starts(&self) -> Vec<usize> {
        if !self.starts.is_empty() {
            return self.starts.to_vec();
        }
        let mut next = 0;
        self.stretches
            .iter()
            .map(|s| {
                let start = next;
                next += s.len();
                start
            })
            .collect()
    }

    pub(crate) fn samples(&self) -> usize {
        self.stretches.iter().map(|s| s.len()).sum()
    }

    /// Samples from the first to one past the last, gaps included.
    pub(crate) fn span(&self) -> usize {
        let starts = self.starts();
        let first = starts.first().copied().unwrap_or(0);
        let ends = starts.iter().zip(self.stretches);
        ends.map(|(start, s)| start + s.len())
            .max()
            .unwrap_or(first)
            - first
    }

    pub(crate) fn check(&self, fewest: usize) -> Result<(), Error> {
        for stretch in self.stretches {
            check_finite("rate", stretch)?;
        }
        check_count("rate samples", self.samples(), fewest)?;
        let same = |name, got: usize| -> Result<(), Error> {
            let expected = self.stretches.len();
            if got == expected {
                return Ok(());
            }
            Err(Error::Length {
                name,
                expected,
                got,
            })
        };
        if !self.starts.is_empty() {
            same("starts of the segments", self.starts.len())?;
        }
        if let Some(temperature) = self.temperature {
            same("segments of the temperature", temperature.len())?;
            for (t, s) in temperature.iter().zip(self.stretches) {
                check_finite("temperature", t)?;
                if t.len() != s.len() {
                    return Err(Error::Length {
                        name: "temperature",
                        expected: s.len(),
                        got: t.len(),
                    });
                }
            }
        }
        Ok(())
    }
}
