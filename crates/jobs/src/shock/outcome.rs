//! What a shock came to.

use super::ShockJob;
use super::page;
use crate::outcome::{Outcome, section};
use crate::record::Record;
use crate::trouble::Result;
use proofmass_documents::StatedQuantity;
use proofmass_dynamic::shock::{
    Pulse, PulseMeasures, ReturnToBaseline, ShockCalibration, SpectrumToleranceResult,
    ToleranceResult,
};
use proofmass_report::Report;
use proofmass_signal::{Extremes, Trace};
use proofmass_uncertainty::{DegreesOfFreedom, Estimate, Finding, Quantity};
use serde::Serialize;

/// One channel as it is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct ShockChannel {
    /// Name.
    pub(crate) name: String,
    /// Unit.
    pub(crate) unit: String,
    /// Time in s, values.
    pub(crate) trace: Trace,
    /// The same about the pulse alone, thinned for itself: its shape is that of the samples.
    pub(crate) pulse: Trace,
}

/// Spectra of one channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ShockSpectra {
    /// Channel.
    pub(crate) name: String,
    /// Unit of the acceleration.
    pub(crate) unit: String,
    /// Natural frequencies, Hz.
    pub(crate) frequency: Vec<f64>,
    /// Extremes of the acceleration of the mass.
    pub(crate) absolute_acceleration: Vec<Extremes>,
    /// Standard uncertainty of its greatest absolute value.
    pub(crate) maximax_uncertainty: Vec<f64>,
    /// Extremes of its displacement against the base, unit × s².
    pub(crate) relative_displacement: Vec<Extremes>,
}

/// Whether the spectrum of the first channel keeps its tolerance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpectrumVerdict {
    /// What is required at the natural frequencies, m/s²; zero where nothing is.
    pub(crate) required: Vec<f64>,
    /// The verdict.
    pub(crate) result: SpectrumToleranceResult,
}

/// The answer.
#[derive(Clone, Debug, PartialEq)]
pub struct ShockOutcome {
    pub(super) request: ShockJob,
    pub(super) rate: f64,
    pub(super) channels: Vec<ShockChannel>,
    pub(super) pulse: Pulse,
    pub(super) measures: PulseMeasures,
    pub(super) calibration: Option<ShockCalibration>,
    pub(super) back: Option<ReturnToBaseline>,
    pub(super) tolerance: Option<ToleranceResult>,
    pub(super) spectrum_tolerance: Option<SpectrumVerdict>,
    pub(super) spectra: Vec<ShockSpectra>,
    pub(super) findings: Vec<Finding>,
}

impl ShockOutcome {
    /// Measures of the pulse: of the reference where there is one.
    pub fn measures(&self) -> &PulseMeasures {
        &self.measures
    }

    /// Where the pulse lies.
    pub fn pulse(&self) -> &Pulse {
        &self.pulse
    }

    /// Calibration against the reference, where there is one.
    pub fn shock_calibration(&self) -> Option<&ShockCalibration> {
        self.calibration.as_ref()
    }

    /// When the device is back at the baseline before the pulse.
    pub fn return_to_baseline(&self) -> Option<&ReturnToBaseline> {
        self.back.as_ref()
    }

    /// Mean of the device after the pulse less its mean before, unit of its channel, and its standard uncertainty.
    pub fn zero_shift(&self) -> Option<(f64, f64)> {
        match &self.calibration {
            Some(c) => c.output.zero_shift,
            None => self.measures.zero_shift,
        }
    }

    /// Shock response spectra: of the reference, then of the output.
    pub fn spectra(&self) -> &[ShockSpectra] {
        &self.spectra
    }

    /// Whether the pulse keeps its tolerance, where one was given.
    pub fn tolerance(&self) -> Option<&ToleranceResult> {
        self.tolerance.as_ref()
    }

    /// Whether its spectrum keeps a tolerance, where one was given.
    pub fn spectrum_tolerance(&self) -> Option<&SpectrumVerdict> {
        self.spectrum_tolerance.as_ref()
    }
}

impl Outcome for ShockOutcome {
    const KIND: &'static str = "shock";

    fn title(&self, record: &Record) -> String {
        record.title("Shock test of", "Shock test")
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        let mut quantities = Vec::new();
        if let Some(calibration) = &self.calibration {
            quantities = StatedQuantity::list(&calibration.estimate.quantities(), 0.95);
        }
        if let Some(u) = self.measures.peak_uncertainty {
            let unit = self.channels.first().map_or("U", |c| c.unit.as_str());
            let relative = self.request.reference.relative_uncertainty;
            let peak = Quantity {
                name: "peak".into(),
                unit: unit.into(),
                value: self.measures.peak,
                standard_uncertainty: u.hypot(relative * self.measures.peak),
                dof: DegreesOfFreedom::INFINITE,
            };
            quantities.push(StatedQuantity::new(&peak, 0.95));
        }
        if let Some((shift, u)) = self.zero_shift() {
            let unit = self.channels.last().map_or("U", |c| c.unit.as_str());
            let shift = Quantity {
                name: "zero_shift".into(),
                unit: unit.into(),
                value: shift,
                standard_uncertainty: u,
                dof: DegreesOfFreedom::INFINITE,
            };
            quantities.push(StatedQuantity::new(&shift, 0.95));
        }
        quantities
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn estimate(&self) -> Option<&Estimate> {
        self.calibration.as_ref().map(|c| &c.estimate)
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![
            section("pulse", &self.measures)?,
            section("return_to_baseline", &self.back)?,
            section("tolerance", &self.tolerance)?,
            section("spectrum_tolerance", &self.spectrum_tolerance)?,
        ])
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }
}
