//! What one run gives: the acceleration of the table and the three outputs, as phasors.

use super::Configuration;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::DegreesOfFreedom;
use serde::{Deserialize, Serialize};

/// One configuration at one frequency. Volts stand for the unit of the outputs, whatever it is.
#[derive(Clone, Debug, PartialEq)]
pub struct PhasorRow {
    /// Name of the run, for messages.
    pub run: String,
    /// Nominal drive frequency in Hz; rows of one frequency carry the same number.
    pub frequency: f64,
    /// Mounting.
    pub configuration: Configuration,
    /// Acceleration of the table along z′ in m/s², peak, from the reference standard and its certificate.
    pub reference: Complex64,
    /// Outputs x, y, z in V, peak.
    pub outputs: [Complex64; 3],
    /// Covariance `[rr, ri, ii]` of the reference (m/s²)² and of the outputs (V²) from the sine approximation.
    pub covariance: [[f64; 3]; 4],
    /// Whether the outputs were sampled by another clock than the reference, so that their common phase is unknown.
    pub free_phase: bool,
    /// Sensitivity of the reference in V/(m/s²), where it was recorded in volts: cables can be swapped then.
    pub reference_sensitivity: Option<Complex64>,
}

/// Each frequency once, in ascending order.
pub(crate) fn ascending(frequencies: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut all: Vec<f64> = frequencies.into_iter().collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

impl PhasorRow {
    /// A row without noise of its own: the budget carries everything.
    pub fn new(
        run: impl Into<String>,
        frequency: f64,
        configuration: Configuration,
        reference: Complex64,
        outputs: [Complex64; 3],
    ) -> Self {
        Self {
            run: run.into(),
            frequency,
            configuration,
            reference,
            outputs,
            covariance: [[0.0; 3]; 4],
            free_phase: false,
            reference_sensitivity: None,
        }
    }

    /// Outputs per unit acceleration of the table, o/a in V/(m/s²).
    pub(crate) fn ratios(&self) -> [Complex64; 3] {
        self.outputs.map(|o| o / self.reference)
    }

    /// The row as it would have been, had the cables of the reference and of an output not been swapped; `None` where the
    /// reference was no voltage, or the output none either.
    pub(crate) fn with_reference_on(&self, channel: usize) -> Option<Self> {
        let r = self.reference_sensitivity?;
        let round = |c: [f64; 3]| 0.5 * (c[0] + c[2]);
        let mut row = self.clone();
        row.reference = self.outputs[channel] / r;
        row.outputs[channel] = self.reference * r;
        let noise = [
            round(self.covariance[channel + 1]) / r.norm_sqr(),
            round(self.covariance[0]) * r.norm_sqr(),
        ];
        row.covariance[0] = [noise[0], 0.0, noise[0]];
        row.covariance[channel + 1] = [noise[1], 0.0, noise[1]];
        (row.reference.norm() > 0.0).then_some(row)
    }

    /// Reals that the row tells beside a phase that nobody knows.
    pub(crate) fn reals(&self) -> f64 {
        if self.free_phase { 5.0 } else { 6.0 }
    }

    pub(crate) fn check(&self, index: usize) -> Result<(), Error> {
        let finite = |z: &Complex64| z.re.is_finite() && z.im.is_finite();
        if !(finite(&self.reference)
            && self.outputs.iter().all(finite)
            && self.frequency.is_finite()
            && self.configuration.inclination.is_finite()
            && self.configuration.rotation.is_finite())
        {
            return Err(Error::NotFinite {
                name: "phasor table",
                index,
            });
        }
        if self.reference.norm() == 0.0 {
            return Err(Error::OutOfRange {
                name: "reference acceleration",
                value: 0.0,
                min: f64::MIN_POSITIVE,
                max: f64::MAX,
            });
        }
        Ok(())
    }
}

/// Motion of the device's seat beside the excitation, relative to it, at one inclination and frequency.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Spurious {
    /// Inclination in radians.
    pub inclination: f64,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Complex ratios ε along x′, y′, z′; the whole motion is a (ε_x, ε_y, 1 + ε_z).
    #[cfg_attr(feature = "schema", schemars(with = "[[f64; 2]; 3]"))]
    pub ratio: [Complex64; 3],
    /// Covariance `[rr, ri, ii]` of each ratio.
    pub covariance: [[f64; 3]; 3],
    /// Degrees of freedom of these covariances.
    #[serde(default = "known")]
    pub dof: DegreesOfFreedom,
}

fn known() -> DegreesOfFreedom {
    DegreesOfFreedom::INFINITE
}

/// What is known of spurious motion over the bench.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SpuriousTable {
    /// One entry per inclination and frequency that was measured.
    pub entries: Vec<Spurious>,
}

impl SpuriousTable {
    /// The fewest degrees of freedom of an entry at a frequency; infinite where there is none.
    pub fn dof_at(&self, frequency: f64) -> DegreesOfFreedom {
        self.entries
            .iter()
            .filter(|e| (e.frequency / frequency - 1.0).abs() < 1e-6)
            .map(|e| e.dof)
            .fold(DegreesOfFreedom::INFINITE, |a, b| if b < a { b } else { a })
    }

    /// The entry of an inclination and a frequency.
    pub fn get(&self, inclination: f64, frequency: f64) -> Option<&Spurious> {
        self.entries.iter().find(|e| {
            (e.inclination - inclination).abs() < 1e-6
                && (e.frequency / frequency - 1.0).abs() < 1e-6
        })
    }
}

/// One measurement of the spurious motion, or none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Correction {
    /// Label, such as `none` or `second`.
    pub label: String,
    /// The ratios.
    pub table: SpuriousTable,
}
