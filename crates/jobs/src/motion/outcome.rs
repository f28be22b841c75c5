//! What a recorded acceleration came to.

use super::MotionJob;
use super::page::MotionReport;
use crate::outcome::{Outcome, section};
use crate::record::Record;
use crate::trouble::Result;
use proofmass_io::{StatedQuantity, Table};
use proofmass_report::Report;
use proofmass_signal::{StrongMotion, Trace, Vibration};
use proofmass_uncertainty::{DegreesOfFreedom, Finding, Quantity};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Response spectrum of the record.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MotionSpectrum {
    /// s.
    pub period: Vec<f64>,
    /// Greatest relative displacement at any instant, m.
    pub displacement: Vec<f64>,
    /// The same looked for at the samples alone, m.
    pub displacement_at_samples: Vec<f64>,
    /// Greatest relative velocity, m/s.
    pub velocity: Vec<f64>,
    /// Greatest absolute acceleration, m/s².
    pub acceleration: Vec<f64>,
}

impl MotionSpectrum {
    /// Pseudo-acceleration ω² × displacement, m/s².
    pub fn pseudo_acceleration(&self) -> Vec<f64> {
        let pairs = self.period.iter().zip(&self.displacement);
        pairs.map(|(t, x)| (TAU / t).powi(2) * x).collect()
    }
}

/// The answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MotionOutcome {
    request: MotionJob,
    channel: String,
    figures: StrongMotion,
    peaks: [f64; 2],
    traces: [Trace; 3],
    spectrum: MotionSpectrum,
    vibration: Option<Vibration>,
    findings: Vec<Finding>,
}

impl MotionOutcome {
    #[allow(clippy::too_many_arguments)] // The fields, once.
    pub(super) fn new(
        request: MotionJob,
        channel: String,
        figures: StrongMotion,
        peaks: [f64; 2],
        traces: [Trace; 3],
        spectrum: MotionSpectrum,
        vibration: Option<Vibration>,
        findings: Vec<Finding>,
    ) -> Self {
        Self {
            request,
            channel,
            figures,
            peaks,
            traces,
            spectrum,
            vibration,
            findings,
        }
    }

    /// Intensity and durations.
    pub fn figures(&self) -> &StrongMotion {
        &self.figures
    }

    /// Response spectrum.
    pub fn spectrum(&self) -> &MotionSpectrum {
        &self.spectrum
    }

    /// Figures of the vibration, where the band could be resolved.
    pub fn vibration(&self) -> Option<&Vibration> {
        self.vibration.as_ref()
    }

    fn page(&self, record: &Record) -> MotionReport<'_> {
        MotionReport {
            head: record.head(self.title(record), &self.findings),
            quantities: self.all(),
            damping: self.request.damping,
            traces: &self.traces,
            period: &self.spectrum.period,
            pseudo_acceleration: self.spectrum.pseudo_acceleration(),
            acceleration: &self.spectrum.acceleration,
            displacement: &self.spectrum.displacement,
            durations: [
                Some(self.figures.duration_5_75),
                Some(self.figures.duration_5_95),
                self.figures.bracketed_duration,
            ],
        }
    }

    /// What is proportional to the acceleration carries its relative uncertainty, the intensity twice.
    fn all(&self) -> Vec<Quantity> {
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
        self.all()
            .iter()
            .map(|q| StatedQuantity::new(q, 0.95))
            .collect()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![
            section("strong_motion", &self.figures)?,
            section("vibration", &self.vibration)?,
        ])
    }

    fn tables(&self) -> Result<Vec<(String, Table)>> {
        let mut table = Table::new([
            "period_s",
            "displacement_m",
            "velocity_m/s",
            "acceleration_m/s2",
            "pseudo_velocity_m/s",
            "pseudo_acceleration_m/s2",
            "pseudo_acceleration_at_samples_m/s2",
        ]);
        let s = &self.spectrum;
        let rows = s
            .period
            .iter()
            .zip(&s.displacement)
            .zip(&s.displacement_at_samples)
            .zip(&s.velocity)
            .zip(&s.acceleration);
        for ((((t, x), at_samples), v), a) in rows {
            let w = TAU / t;
            table.push([*t, *x, *v, *a, w * x, w * w * x, w * w * at_samples])?;
        }
        Ok(vec![("response_spectrum.csv".to_owned(), table)])
    }

    fn summary(&self, record: &Record) -> Report {
        self.page(record).summary()
    }

    fn report(&self, record: &Record) -> Report {
        self.page(record).full()
    }
}
