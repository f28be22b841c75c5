//! What a shock came to.

use super::ShockJob;
use super::page::{ShockReport, ShockSpectrumCurves};
use crate::outcome::{Outcome, section};
use crate::record::Record;
use crate::trouble::Result;
use proofmass_dynamic::shock::{
    Pulse, PulseMeasures, ShockCalibration, SpectrumToleranceResult, ToleranceResult,
};
use proofmass_io::{Cell, StatedQuantity, Table};
use proofmass_report::Report;
use proofmass_signal::{Extremes, Trace};
use proofmass_uncertainty::{DegreesOfFreedom, Estimate, Finding, Quantity};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// One channel as it is drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShockChannel {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Time in s, values.
    pub trace: Trace,
}

/// Spectra of one channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShockSpectra {
    /// Channel.
    pub name: String,
    /// Unit of the acceleration.
    pub unit: String,
    /// Natural frequencies, Hz.
    pub frequency: Vec<f64>,
    /// Extremes of the acceleration of the mass.
    pub absolute_acceleration: Vec<Extremes>,
    /// Standard uncertainty of its greatest absolute value.
    #[serde(default)]
    pub maximax_uncertainty: Vec<f64>,
    /// Extremes of its displacement against the base, unit × s².
    pub relative_displacement: Vec<Extremes>,
}

/// Whether the spectrum of the first channel keeps its tolerance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpectrumVerdict {
    /// What is required at the natural frequencies, m/s²; zero where nothing is.
    pub required: Vec<f64>,
    /// The verdict.
    pub result: SpectrumToleranceResult,
}

/// The answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShockOutcome {
    request: ShockJob,
    rate: f64,
    channels: Vec<ShockChannel>,
    pulse: Pulse,
    measures: PulseMeasures,
    calibration: Option<ShockCalibration>,
    tolerance: Option<ToleranceResult>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    spectrum_tolerance: Option<SpectrumVerdict>,
    spectra: Vec<ShockSpectra>,
    findings: Vec<Finding>,
}

impl ShockOutcome {
    #[allow(clippy::too_many_arguments)] // The fields, once.
    pub(super) fn new(
        request: ShockJob,
        rate: f64,
        channels: Vec<ShockChannel>,
        pulse: Pulse,
        measures: PulseMeasures,
        calibration: Option<ShockCalibration>,
        tolerance: Option<ToleranceResult>,
        spectrum_tolerance: Option<SpectrumVerdict>,
        spectra: Vec<ShockSpectra>,
        findings: Vec<Finding>,
    ) -> Self {
        Self {
            request,
            rate,
            channels,
            pulse,
            measures,
            calibration,
            tolerance,
            spectrum_tolerance,
            spectra,
            findings,
        }
    }

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

    fn page(&self, record: &Record) -> ShockReport<'_> {
        ShockReport {
            head: record.head(self.title(record), &self.findings),
            rate: self.rate,
            quality: self.request.quality,
            traces: self
                .channels
                .iter()
                .map(|c| (c.name.as_str(), c.unit.as_str(), &c.trace))
                .collect(),
            pulse: &self.pulse,
            measures: &self.measures,
            calibration: self.calibration.as_ref(),
            tolerance: self.tolerance.as_ref(),
            spectrum_tolerance: self
                .spectrum_tolerance
                .as_ref()
                .map(|v| (v.required.as_slice(), &v.result)),
            spectra: self
                .spectra
                .iter()
                .map(|s| ShockSpectrumCurves {
                    name: &s.name,
                    unit: &s.unit,
                    frequency: &s.frequency,
                    acceleration: &s.absolute_acceleration,
                    displacement: &s.relative_displacement,
                    uncertainty: &s.maximax_uncertainty,
                })
                .collect(),
        }
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
            let stated = calibration.estimate.quantities();
            quantities.extend(stated.iter().map(|q| StatedQuantity::new(q, 0.95)));
        }
        if let Some(u) = self.measures.peak_uncertainty {
            let unit = self.channels.first().map_or("U", |c| c.unit.as_str());
            let relative = match &self.calibration {
                Some(_) => self.request.reference.relative_uncertainty,
                None => 0.0,
            };
            let peak = Quantity {
                name: "peak".into(),
                unit: unit.into(),
                value: self.measures.peak,
                standard_uncertainty: u.hypot(relative * self.measures.peak),
                dof: DegreesOfFreedom::INFINITE,
            };
            quantities.push(StatedQuantity::new(&peak, 0.95));
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
            section("tolerance", &self.tolerance)?,
            section("spectrum_tolerance", &self.spectrum_tolerance)?,
        ])
    }

    fn tables(&self) -> Result<Vec<(String, Table)>> {
        let mut tables = Vec::new();
        let roles: &[&str] = match self.spectra.len() {
            1 => &["srs.csv"],
            _ => &["srs_reference.csv", "srs_output.csv"],
        };
        for (spectra, name) in self.spectra.iter().zip(roles) {
            let unit = &spectra.unit;
            let mut table = Table::new([
                "frequency_Hz".to_owned(),
                format!("maximax_{unit}"),
                format!("maximum_{unit}"),
                format!("minimum_{unit}"),
                format!("primary_{unit}"),
                format!("residual_{unit}"),
                format!("relative_displacement_{unit}*s2"),
                format!("pseudo_velocity_{unit}*s"),
                format!("maximax_U95_{unit}"),
            ]);
            let rows = spectra
                .frequency
                .iter()
                .zip(&spectra.absolute_acceleration)
                .zip(&spectra.relative_displacement);
            for (k, ((f, a), x)) in rows.enumerate() {
                let u = spectra.maximax_uncertainty.get(k).copied();
                table.push([
                    Cell::Number(*f),
                    Cell::Number(a.maximax()),
                    Cell::Number(a.max()),
                    Cell::Number(a.min()),
                    Cell::Number(a.primary_maximax()),
                    Cell::Number(a.residual_maximax()),
                    Cell::Number(x.maximax()),
                    Cell::Number(TAU * f * x.maximax()),
                    u.map(|u| 1.96 * u).into(),
                ])?;
            }
            tables.push(((*name).to_owned(), table));
        }
        if let Some(calibration) = &self.calibration
            && !calibration.lines.is_empty()
        {
            let mut table = Table::new([
                "frequency_Hz",
                "modulus",
                "phase_deg",
                "relative_u",
                "reference_spectrum_m/s",
            ]);
            for line in &calibration.lines {
                let s = line.value();
                table.push([
                    Cell::Number(line.frequency),
                    Cell::Number(s.norm()),
                    Cell::Number(s.arg().to_degrees()),
                    Cell::Number(line.relative_uncertainty),
                    Cell::Number(line.reference),
                ])?;
            }
            tables.push(("sensitivity_spectrum.csv".to_owned(), table));
        }
        Ok(tables)
    }

    fn summary(&self, record: &Record) -> Report {
        self.page(record).summary()
    }

    fn report(&self, record: &Record) -> Report {
        self.page(record).full()
    }
}
