//! Wedges whose bending was calculated, on the simulated bench.

use crate::campaign::SpuriousFile;
use crate::trouble::{Result, Trouble};
use proofmass_rig::bench::{BenchWedge, Bending};

impl SpuriousFile {
    /// The table as the bending of wedges on the simulated bench.
    pub fn bending(&self) -> Vec<Bending> {
        self.correction
            .table
            .entries
            .iter()
            .map(|e| Bending {
                inclination_deg: e.inclination.to_degrees(),
                frequency: e.frequency,
                ratio: e.ratio,
            })
            .collect()
    }
}

/// The standard wedge with the bending that was asked for.
pub(super) fn bent(
    wedge: Option<BenchWedge>,
    bending: &[Bending],
    frequencies: &[f64],
) -> Result<Option<BenchWedge>> {
    let (false, Some(mut wedge)) = (bending.is_empty(), wedge.clone()) else {
        return Ok(wedge);
    };
    let last = bending.iter().map(|b| b.frequency).fold(0.0, f64::max);
    if let Some(f) = frequencies.iter().find(|f| **f > last) {
        return Err(Trouble::request(format!(
            "the bending of the wedges ends at {last} Hz, below the drive at {f} Hz"
        ))
        .with_hint(
            "calculate it up to there (frequencies_Hz in [transfer]), or leave frequencies out",
        ));
    }
    wedge.bending = bending.to_vec();
    Ok(Some(wedge))
}
