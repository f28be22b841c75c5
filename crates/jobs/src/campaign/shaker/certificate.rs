//! `reference.csv`: what the certificate of the reference standard says.

use crate::campaign::CampaignFile;
use proofmass_calibration::shaker::reference::{ReferencePoint, ReferenceTable};
use proofmass_io::sheet::{ANGLE, FREQUENCY, PERCENT, Place, SENSITIVITY, Sheet, SheetRow};
use proofmass_io::{Error, ErrorKind, Input, Result, Source};
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

/// The certificate of the reference standard.
#[derive(Clone, Debug, PartialEq)]
pub struct Certificate {
    /// Path and digest.
    pub input: Input,
    /// Which standard it is.
    pub description: Option<String>,
    /// Sensitivity against frequency.
    pub table: ReferenceTable,
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
        Self::from_source(
            source.source(&table.file)?,
            table.k,
            table.description.clone(),
        )
    }

    /// Reads the table of a laboratory: `frequency_Hz`, `sensitivity_V/(m/s2)`, `phase_deg` where it is known, and
    /// standard (`u_relative_%`, `u_phase_deg`) or expanded uncertainties (`U_…`, with `k` or a column of it).
    ///
    /// # Errors
    /// A missing column, an expanded uncertainty without its coverage factor, a row that cannot be.
    pub fn from_source(
        source: Source,
        coverage: Option<f64>,
        description: Option<String>,
    ) -> Result<Self> {
        let path = source.name().to_path_buf();
        let mut sheet = Sheet::from_source(source, "certificate of the reference")?;
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
        modulus.complete(&sheet, "relative_%", coverage, k)?;
        if phase.is_some() {
            angle.complete(&sheet, "phase_deg", coverage, k)?;
        }
        let mut points: Vec<(u64, ReferencePoint)> = Vec::new();
        for row in sheet.rows() {
            let factor = match k {
                Some(place) => Some(row.positive(place)?),
                None => coverage,
            };
            let point = ReferencePoint {
                frequency: row.positive(frequency)?,
                sensitivity: row.positive(sensitivity)?,
                phase: row.optional(phase)?.unwrap_or(0.0),
                modulus_uncertainty: modulus.read(&row, factor)?,
                phase_uncertainty: angle.read(&row, factor)?,
            };
            if point.modulus_uncertainty > 0.5 {
                return Err(row
                    .refuse_row(
                        "the uncertainty of the reference is more than half of its sensitivity",
                    )
                    .with_hint("write it in per cent, relative to the sensitivity"));
            }
            if let Some((line, _)) = points.iter().find(|(_, p)| p.frequency == point.frequency) {
                return Err(row
                    .refuse(
                        frequency,
                        format!("{} Hz stands in line {line} already", point.frequency),
                    )
                    .with_hint("keep one of the two lines"));
            }
            points.push((row.line, point));
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
            description,
            table: ReferenceTable::new(points.into_iter().map(|(_, p)| p).collect())
                .map_err(|e| Error::new(ErrorKind::Format, e.to_string()).at(&path))?,
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
