//! What a recorded acceleration came to.

use super::MotionJob;
use super::page;
use crate::outcome::{Outcome, section};
use crate::record::Record;
use crate::required_density::JudgedDensity;
use crate::trouble::Result;
use proofmass_documents::StatedQuantity;
use proofmass_report::Report;
use proofmass_signal::{StrongMotion, Trace, Vibration};
use proofmass_uncertainty::{DegreesOfFreedom, Finding, Quantity};
use std::f64::consts::TAU;

/// Response spectrum of the record.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionSpectrum {
    /// s.
    pub(crate) period: Vec<f64>,
    /// Greatest relative displacement at any instant, m.
    pub(crate) displacement: Vec<f64>,
    /// The same looked for at the samples alone, m.
    pub(crate) displacement_at_samples: Vec<f64>,
    /// Greatest relative velocity, m/s.
    pub(crate) velocity: Vec<f64>,
    /// Greatest absolute acceleration, m/s².
    pub(crate) acceleration: Vec<f64>,
}

impl MotionSpectrum {
    /// Pseudo-acceleration ω² × displacement, m/s².
    pub fn pseudo_acceleration(&self) -> Vec<f64> {
        self.pseudo(2, &self.displacement)
    }

    /// A power of ω times these displacements.
    pub(super) fn pseudo(&self, power: i32, displacement: &[f64]) -> Vec<f64> {
        let pairs = self.period.iter().zip(displacement);
        pairs.map(|(t, x)| (TAU / t).powi(power) * x).collect()
    }
}

/// The answer.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionOutcome {
    pub(super) request: MotionJob,
    pub(super) figures: StrongMotion,
    pub(super) peaks: [f64; 2],
    pub(super) traces: [Trace; 3],
    pub(super) spectrum: MotionSpectrum,
    pub(super) vibration: Option<Vibration>,
    pub(super) required: Option<JudgedDensity>,
    pub(super) findings: Vec<Finding>,
}

impl MotionOutcome {
    /// Intensity and durations.
    pub fn figures(&self) -> &StrongMotion {
        &self.figures
    }

    /// Response spectrum.
    pub fn spectrum(&self) -> &MotionSpectrum {
        &self.spectrum
    }

    /// What the density says of the required one, where one is.
    pub fn required(&self) -> Option<&JudgedDensity> {
        self.required.as_ref()
    }

    /// Figures of the vibration, where the band could be resolved.
    pub fn vibration(&self) -> Option<&Vibration> {
        self.vibration.as_ref()
    }

    /// What is proportional to the acceleration carries its relative uncertainty, the intensity twice.
    pub(super) fn all(&self) -> Vec<Quantity> {
        let u = self.request.relative_uncertainty;
        let quantity = |name: &str, unit: &str, value: f64, relative: f64| Quantity {
            name: name.into(),
            unit: unit.into(),
            value,
            standard_uncertainty: (relative * value).abs(),
            dof: DegreesOfFreedom::INFINITE,
        };
        let f = &self.figures;
        let mut all = vec![
            quantity("peak_acceleration", "m/s²", f.peak_acceleration, u),
            quantity("peak_velocity", "m/s", self.peaks[0], u),
            quantity("peak_displacement", "m", self.peaks[1], u),
            quantity("arias_intensity", "m/s", f.arias_intensity, 2.0 * u),
            quantity(
                "cumulative_absolute_velocity",
                "m/s",
                f.cumulative_absolute_velocity,
                u,
            ),
        ];
        if let Some(v) = &self.vibration {
            all.extend([
                quantity("rms", "m/s²", v.rms, u),
                quantity("crest_factor", "1", v.crest_factor, 0.0),
                quantity("kurtosis", "1", v.kurtosis, 0.0),
                quantity(
                    "velocity_rms",
                    "m/s",
                    v.velocity_rms,
                    u.hypot(v.velocity_scatter),
                ),
            ]);
        }
        all
    }
}

impl Outcome for MotionOutcome {
    const KIND: &'static str = "motion";

    fn title(&self, record: &Record) -> String {
        record.title("Motion recorded by", "Recorded motion")
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        StatedQuantity::list(&self.all(), 0.95)
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![
            section("strong_motion", &self.figures)?,
            section("vibration", &self.vibration)?,
            section("required_spectrum", &self.required)?,
        ])
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }
}
