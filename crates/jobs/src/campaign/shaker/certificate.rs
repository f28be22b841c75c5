//! `reference.csv`: what the certificate of the reference standard says.

use crate::campaign::CampaignFile;
use proofmass_io::sheet::{ANGLE, FREQUENCY, PERCENT, Place, SENSITIVITY, Sheet, SheetRow};
use proofmass_io::{Input, Result};
use proofmass_uncertainty::{Finding, Severity};
use serde::Deserialize;

/// `[reference]`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertificateTable {
    /// The table, relative to the campaign.
    pub file: String,
    /// Coverage factor of the columns `U_…`.
    pub k: Option<f64>,
    /// Which standard it is and who calibrated it, for the report.
    pub description: Option<String>,
}

/// One line of the certificate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CertificatePoint {
    /// Line of the table.
    pub line: u64,
    /// Frequency in Hz.
    pub frequency_hz: f64,
    /// Sensitivity in V/(m/s²).
    pub sensitivity: f64,
    /// Phase in radians.
    pub phase: f64,
    /// Relative standard uncertainty of the sensitivity.
    pub u_relative: f64,
    /// Standard uncertainty of the phase in radians.
    pub u_phase: f64,
}

/// The certificate of the reference standard.
#[derive(Clone, Debug, PartialEq)]
pub struct Certificate {
    /// Path and digest.
    pub input: Input,
    /// Which standard it is.
    pub description: Option<String>,
    /// Points in the order of the table.
    pub points: Vec<CertificatePoint>,
    /// What it does not say.
    pub findings: Vec<Finding>,
}

impl Certificate {
    pub(crate) fn read(source: &CampaignFile, table: &CertificateTable) -> Result<Self> {
        if let Some(k) = table.k
            && !(1.0..=5.0).contains(&k)
        {
            return Err(source
                .refuse(
                    "reference",
                    "k",
                    format!("a coverage factor of {k} is out of place"),
                )
                .with_hint(
                    "certificates state k = 2 for 95 %; leave it out for standard uncertainties",
                ));
        }
        let path = source.resolve(&table.file);
        let mut sheet =
            Sheet::from_source(source.source(&table.file)?, "certificate of the reference")?;
        let frequency = sheet.quantity("frequency", FREQUENCY)?;
        let sensitivity = sheet.quantity("sensitivity", SENSITIVITY)?;
        let phase = sheet.quantity("phase", ANGLE)?;
        let modulus = Stated {
            standard: sheet.quantity("u_relative", PERCENT)?,
            expanded: sheet.quantity("U_relative", PERCENT)?,
        };
        let angle = Stated {
            standard: sheet.quantity("u_phase", ANGLE)?,
            expanded: sheet.quantity("U_phase", ANGLE)?,
        };
        let k = sheet.text("k");
        sheet.finish()?;
        let frequency = sheet.required(frequency, "frequency_Hz")?;
        let sensitivity = sheet.required(sensitivity, "sensitivity_V/(m/s2)")?;
        modulus.complete(&sheet, "relative_%", table.k, k)?;
        if phase.is_some() {
            angle.complete(&sheet, "phase_deg", table.k, k)?;
        }
        let mut points: Vec<CertificatePoint> = Vec::new();
        for row in sheet.rows() {
            let factor = match k {
                Some(place) => Some(row.positive(place)?),
                None => table.k,
            };
            let point = CertificatePoint {
                line: row.line,
                frequency_hz: row.positive(frequency)?,
                sensitivity: row.positive(sensitivity)?,
                phase: row.optional(phase)?.unwrap_or(0.0),
                u_relative: modulus.read(&row, factor)?,
                u_phase: angle.read(&row, factor)?,
            };
            if point.u_relative > 0.5 {
                return Err(row
                    .refuse_row(
                        "the uncertainty of the reference is more than half of its sensitivity",
                    )
                    .with_hint("write it in per cent, relative to the sensitivity"));
            }
            if let Some(other) = points.iter().find(|p| p.frequency_hz == point.frequency_hz) {
                return Err(row
                    .refuse(
                        frequency,
                        format!(
                            "{} Hz stands in line {} already",
                            point.frequency_hz, other.line
                        ),
                    )
                    .with_hint("keep one of the two lines"));
            }
            points.push(point);
        }
        let mut findings = Vec::new();
        if phase.is_none() {
            findings.push(
                Finding::new(
                    Severity::Note,
                    "reference-phase-unknown",
                    "the certificate states no phase of the reference, so phases are relative to it",
                )
                .evidence(format!("{} has no column phase_deg", path.display()))
                .advice("moduli do not need it; add the phase and its uncertainty where phases count"),
            );
        }
        Ok(Self {
            input: sheet.input.clone(),
            description: table.description.clone(),
            points,
            findings,
        })
    }
}

/// An uncertainty as the certificate states it: standard or expanded.
struct Stated {
    standard: Option<Place>,
    expanded: Option<Place>,
}

impl Stated {
    fn complete(
        &self,
        sheet: &Sheet,
        ending: &str,
        common: Option<f64>,
        column: Option<Place>,
    ) -> Result<()> {
        match (self.standard, self.expanded) {
            (Some(_), Some(_)) => Err(sheet
                .header_error(
                    &format!("U_{ending}"),
                    "standard and expanded uncertainty exclude each other",
                )
                .with_hint("keep one of the two columns")),
            (None, Some(_)) if common.is_none() && column.is_none() => Err(sheet
                .header_error(
                    &format!("U_{ending}"),
                    "an expanded uncertainty needs its coverage factor",
                )
                .with_hint("add `k = 2` to [reference], or a column `k`")),
            (None, None) => Err(sheet
                .header_error(&format!("u_{ending}"), "the certificate has no such column")
                .with_hint(format!(
                    "add u_{ending} (standard uncertainty), or U_{ending} (expanded) with k"
                ))),
            _ => Ok(()),
        }
    }

    fn read(&self, row: &SheetRow, k: Option<f64>) -> Result<f64> {
        match (self.standard, self.expanded, k) {
            (None, Some(expanded), Some(k)) => Ok(row.uncertainty(Some(expanded))? / k),
            (standard, ..) => row.uncertainty(standard),
        }
    }
}
