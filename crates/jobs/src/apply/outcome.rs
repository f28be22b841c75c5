//! What became of a compensated recording.

use super::page::CompensationReport;
use super::{ApplyJob, CompensationMethod, CompensationStream};
use crate::outcome::Outcome;
use crate::record::Record;
use proofmass_dynamic::frequency_response::{BandMatrix, CompensationError};
use proofmass_io::{AnyCalibration, CalibrationFile, Input, StatedQuantity};
use proofmass_report::Report;
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};

/// Counts while the rows go by.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Figures {
    pub(super) read: u64,
    pub(super) written: u64,
    pub(super) gaps: u64,
    pub(super) beyond: u64,
    /// Temperatures beyond those of the coefficients, with the lowest and the highest of all.
    pub(super) beyond_temperature: u64,
    pub(super) temperatures: Option<[f64; 2]>,
}

impl Figures {
    /// Counts temperatures beyond those of the coefficients; the first of these that is.
    pub(super) fn temperatures(
        &mut self,
        file: &CalibrationFile,
        temperatures: &[f64],
    ) -> Option<usize> {
        let block = file.temperature.as_ref()?;
        let mut first = None;
        for (row, t) in temperatures.iter().enumerate() {
            let [low, high] = self.temperatures.unwrap_or([*t, *t]);
            self.temperatures = Some([low.min(*t), high.max(*t)]);
            if !block.covers(*t) {
                self.beyond_temperature += 1;
                first = first.or(Some(row));
            }
        }
        first
    }

    /// Counts accelerations beyond the tested range; a tenth more than that of a resting sensor is still at rest.
    ///
    /// The first of these rows that has one.
    pub(super) fn count(
        &mut self,
        calibration: &AnyCalibration,
        values: &[&[f64]],
    ) -> Option<usize> {
        let [low, high] = range(calibration)?;
        let margin = 0.1 * (high - low);
        let (low, high) = (low - margin, high + margin);
        let outside = |i: &usize| values.iter().any(|v| v[*i] < low || v[*i] > high);
        let mut rows = (0..values[0].len()).filter(outside);
        let first = rows.next()?;
        self.beyond += 1 + rows.count() as u64;
        Some(first)
    }
}

fn range(calibration: &AnyCalibration) -> Option<[f64; 2]> {
    match calibration {
        AnyCalibration::Triaxial(file) => file.acceleration_range,
        _ => None,
    }
}

pub(super) fn findings(
    figures: &Figures,
    compensation: Option<&CompensationStream>,
    calibration: &AnyCalibration,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    if let (true, Some([low, high])) = (figures.beyond > 0, range(calibration)) {
        findings.push(
            Finding::new(
                Severity::Note,
                "beyond-tested-range",
                format!(
                    "{} samples lie beyond {low:.1} … {high:.1} m/s², where the calibration was tested; the model is \
                     extrapolated there",
                    figures.beyond
                ),
            )
            .evidence(format!("of {} samples", figures.written)),
        );
    }
    if let (AnyCalibration::Triaxial(file), Some([low, high])) = (calibration, figures.temperatures)
        && let Some(block) = &file.temperature
        && figures.beyond_temperature > 0
    {
        findings.push(
            Finding::new(
                Severity::Warning,
                "beyond-temperature-range",
                format!(
                    "{} samples are beyond {:.1} … {:.1} °C, where the temperature coefficients were measured; the \
                     polynomials are extrapolated there",
                    figures.beyond_temperature, block.range[0], block.range[1]
                ),
            )
            .evidence(format!("{low:.1} to {high:.1} °C in {} samples", figures.read))
            .advice("sweep a larger range, or refuse such samples"),
        );
    }
    let Some(compensation) = compensation else {
        return findings;
    };
    if let Some(filter) = compensation.filter() {
        if !filter.within_tolerance {
            findings.push(
                Finding::new(
                    Severity::Warning,
                    "filter-too-short",
                    "the filter does not follow the inverse of the sensitivity as closely as was asked",
                )
                .evidence(format!(
                    "{} samples, departure {:.2} %",
                    2 * filter.half + 1,
                    100.0 * filter.error.departure
                ))
                .advice("leave out the lowest frequencies with a band, or allow a longer filter; the stated error holds it"),
            );
        }
        if figures.gaps > 0 {
            findings.push(
                Finding::new(
                    Severity::Note,
                    "gaps-in-recording",
                    "samples are missing; the filter begins anew behind each gap",
                )
                .evidence(format!(
                    "{} gaps, {} samples without a result on either side of each",
                    figures.gaps, filter.half
                )),
            );
        }
    }
    if let Some(error) = compensation.error()
        && error.interpolation.is_none()
    {
        findings.push(
            Finding::new(
                Severity::Warning,
                "interpolation-unknown",
                "the calibration has too few frequencies to tell how the sensitivity runs between them",
            )
            .evidence("fewer than three")
            .advice("calibrate at more frequencies, or use the compensation at the calibrated ones alone"),
        );
    }
    findings
}

/// A filter, but for its taps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FilterFigures {
    /// Sampling rate, Hz.
    pub rate: f64,
    /// Length of its impulse response, samples.
    pub length: usize,
    /// Samples without a result at the beginning and at the end of every stretch.
    pub half: usize,
}

/// Counts, digest and stated error of a compensated recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ApplyOutcome {
    method: CompensationMethod,
    read: u64,
    written: u64,
    gaps: u64,
    beyond: u64,
    columns: Vec<String>,
    recording: Input,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sha256: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    band: Option<BandMatrix>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    filter: Option<FilterFigures>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    error: Option<CompensationError>,
    findings: Vec<Finding>,
}

impl ApplyOutcome {
    pub(super) fn new(
        job: &ApplyJob,
        compensation: Option<&CompensationStream>,
        figures: Figures,
        columns: Vec<String>,
        (recording, sha256): (Input, Option<String>),
        mut findings: Vec<Finding>,
    ) -> Self {
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        Self {
            method: job.method,
            read: figures.read,
            written: figures.written,
            gaps: figures.gaps,
            beyond: figures.beyond,
            columns,
            recording,
            sha256,
            band: compensation.and_then(|c| c.band().cloned()),
            filter: compensation
                .and_then(CompensationStream::filter)
                .map(|f| FilterFigures {
                    rate: f.rate,
                    length: 2 * f.half + 1,
                    half: f.half,
                }),
            error: compensation.and_then(CompensationStream::error),
            findings,
        }
    }

    /// Rows written.
    pub fn rows(&self) -> u64 {
        self.written
    }

    /// Samples beyond the tested range.
    pub fn beyond(&self) -> u64 {
        self.beyond
    }

    /// Headings of the compensated columns.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The recording with its digest.
    pub fn recording(&self) -> &Input {
        &self.recording
    }

    /// SHA-256 of what was written, where a file of it stays.
    pub fn sha256(&self) -> Option<&str> {
        self.sha256.as_deref()
    }

    /// What the compensation states about itself, where it is one over frequency.
    pub fn error(&self) -> Option<&CompensationError> {
        self.error.as_ref()
    }

    /// The stated error in one line, where the compensation is one over frequency.
    pub fn statement(&self) -> Option<String> {
        let error = self.error.as_ref()?;
        let [low, high] = error.band;
        let delay = match &self.filter {
            Some(_) => "the delay of sensor and filter is taken out".to_owned(),
            None => format!(
                "after a delay of {:.1} µs; {:.3} % where that is not taken into account",
                1e6 * error.delay,
                100.0 * error.stated_with_delay
            ),
        };
        Some(format!(
            "stated error: {:.3} % of the acceleration at any frequency from {low} Hz to {high} Hz with 95 % \
             probability, {delay}",
            100.0 * error.stated
        ))
    }

    /// The filter, where it was one.
    pub fn filter(&self) -> Option<&FilterFigures> {
        self.filter.as_ref()
    }

    fn page(&self, record: &Record) -> CompensationReport<'_> {
        CompensationReport {
            head: record.head(self.title(record), &self.findings),
            written: self.written,
            left_out: self.read - self.written,
            error: self.error.as_ref(),
            band: self.band.as_ref(),
            filter: self.filter.map(|f| (f.length, f.rate)),
        }
    }
}

impl Outcome for ApplyOutcome {
    const KIND: &'static str = "apply";

    fn title(&self, record: &Record) -> String {
        record.title("Compensated recording of", "Compensated recording")
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        let Some(error) = &self.error else {
            return Vec::new();
        };
        // A relative error that is zero as far as anyone knows, and within the stated one.
        let statement = |name: &str, unit: &str, value: f64, expanded: f64| StatedQuantity {
            name: name.to_owned(),
            unit: unit.to_owned(),
            value,
            u: None,
            expanded,
            k: None,
            nu_eff: None,
            probability: 0.95,
            interval: None,
            method: None,
        };
        vec![statement("relative_error", "1", 0.0, error.stated)]
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn summary(&self, record: &Record) -> Report {
        self.page(record).summary()
    }

    fn report(&self, record: &Record) -> Report {
        self.page(record).full()
    }
}
