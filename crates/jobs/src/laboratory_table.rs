//! The table of a laboratory: sensitivity of one axis over frequency, as certificates print it.

use crate::certificate;
use crate::device_output::DeviceOutput;
use crate::findings;
use proofmass_documents::{DigitalCertificate, SensitivityRow};
use proofmass_dynamic::FrequencyResponse;
use proofmass_dynamic::reference_table::{ReferencePoint, ReferenceTable};
use proofmass_io::sheet::{
    ACCELERATION_RATIO, ANGLE, COUNT_SENSITIVITY, Endings, FREQUENCY, PERCENT, Place, SENSITIVITY,
    Sheet, SheetRow,
};
use proofmass_io::{Error, ErrorKind, Input, Result, Source};
use proofmass_uncertainty::Finding;
use std::ffi::OsStr;
use std::path::Path;

/// Headings of the sensitivity, in the order of `OUTPUTS`.
const KINDS: [Endings; 3] = [SENSITIVITY, ACCELERATION_RATIO, COUNT_SENSITIVITY];

/// What the headings are those of.
const OUTPUTS: [DeviceOutput; 3] = [
    DeviceOutput::Volt,
    DeviceOutput::Acceleration,
    DeviceOutput::Count,
];

/// Whether a file is the table of a laboratory by its name: rows (`.csv`) or a digital calibration certificate (`.xml`).
pub(crate) fn is_table(name: &Path) -> bool {
    let is_csv = |e: &OsStr| e.eq_ignore_ascii_case("csv");
    DigitalCertificate::is_named(name) || name.extension().is_some_and(is_csv)
}

/// A table that was read.
pub(crate) struct LaboratoryTable {
    pub(crate) input: Input,
    pub(crate) output: DeviceOutput,
    /// Sensitivities in the unit of the output.
    pub(crate) table: ReferenceTable,
    pub(crate) phase_stated: bool,
    pub(crate) findings: Vec<Finding>,
    /// Who it is of, and which certificate, where the table says it.
    pub(crate) description: Option<String>,
    /// Number of a certificate with a signature that nobody checked.
    pub(crate) signed: Option<String>,
}

impl LaboratoryTable {
    /// A digital calibration certificate by its name, else rows.
    ///
    /// # Errors
    /// As [`LaboratoryTable::of_rows`] and [`DigitalCertificate::sensitivity`].
    pub(crate) fn from_source(
        source: Source,
        coverage: Option<f64>,
        result: Option<&str>,
    ) -> Result<Self> {
        if !DigitalCertificate::is_named(source.name()) {
            return Self::of_rows(source, coverage);
        }
        let path = source.name().to_path_buf();
        if coverage.is_some() {
            return Err(Error::new(
                ErrorKind::Configuration,
                "a coverage factor is stated for a digital calibration certificate, which states its own",
            )
            .at(&path)
            .with_hint("leave it out"));
        }
        Self::of_certificate(&DigitalCertificate::from_source(source)?, result)
            .map_err(|e| e.at(&path))
    }

    fn of_certificate(read: &DigitalCertificate, result: Option<&str>) -> Result<Self> {
        if read.version.is_none() {
            return Err(
                Error::new(ErrorKind::Format, "holds quantities, but is no certificate").with_hint(
                    "name a digital calibration certificate: who states a value has to be said",
                ),
            );
        }
        if read
            .identifier
            .as_deref()
            .is_some_and(certificate::is_draft)
        {
            return Err(Error::new(
                ErrorKind::Format,
                "is the draft of a certificate, and no certificate",
            )
            .with_hint("release it: `proofmass certificate release`"));
        }
        let stated = read.sensitivity(result)?;
        let point = |row: &SensitivityRow| {
            let [phase, phase_uncertainty] = row.phase.unwrap_or_default();
            ReferencePoint {
                frequency: row.frequency,
                sensitivity: row.sensitivity,
                phase,
                modulus_uncertainty: row.sensitivity_uncertainty / row.sensitivity,
                phase_uncertainty,
            }
        };
        let table = ReferenceTable::new(stated.rows.iter().map(point).collect())
            .map_err(|e| Error::new(ErrorKind::Format, e.to_string()))?;
        let number = read.identifier.as_deref().unwrap_or("without a number");
        let who = [
            read.item.line(),
            format!("certificate {number}"),
            read.laboratory.clone().unwrap_or_default(),
        ];
        let who: Vec<String> = who.into_iter().filter(|w| !w.is_empty()).collect();
        let output = OUTPUTS.into_iter().find(|o| o.of_device() == stated.output);
        Ok(Self {
            input: read.input.clone(),
            output: output.unwrap_or_default(),
            table,
            phase_stated: stated.rows.iter().all(|r| r.phase.is_some()),
            findings: [read.findings(), stated.findings].concat(),
            description: Some(who.join(", ")),
            signed: (!read.signatures.is_empty()).then(|| number.to_owned()),
        })
    }

    /// `frequency_Hz`, `sensitivity_V/(m/s2)` (or another unit), `phase_deg` where it is known, and standard (`u_relative_%` or
    /// `u_sensitivity_…`, `u_phase_deg`) or expanded uncertainties (`U_…`, with `k` or a column of it).
    ///
    /// Rows of one frequency are repeats of one measurement: their mean, whose variance is the mean of the stated ones and
    /// that of the mean by their scatter.
    ///
    /// # Errors
    /// A missing column, an expanded uncertainty without its coverage factor, a row that cannot be.
    fn of_rows(source: Source, coverage: Option<f64>) -> Result<Self> {
        let path = source.name().to_path_buf();
        let mut sheet = Sheet::from_source(source, "table of the laboratory")?;
        let frequency = sheet.quantity("frequency", FREQUENCY)?;
        let sensitivity = sheet.one_of("sensitivity", &KINDS)?;
        let kind = sensitivity.map_or(0, |(kind, _)| kind);
        let phase = sheet.quantity("phase", ANGLE)?;
        let relative = Stated {
            standard: sheet.quantity("u_relative", PERCENT)?,
            expanded: sheet.quantity("U_relative", PERCENT)?,
        };
        let absolute = Stated {
            standard: sheet.quantity("u_sensitivity", KINDS[kind])?,
            expanded: sheet.quantity("U_sensitivity", KINDS[kind])?,
        };
        let angle = Stated {
            standard: sheet.quantity("u_phase", ANGLE)?,
            expanded: sheet.quantity("U_phase", ANGLE)?,
        };
        let k = sheet.text("k");
        sheet.finish()?;
        let frequency = sheet.required(frequency, "frequency_Hz")?;
        let sensitivity = sheet.required(sensitivity.map(|s| s.1), "sensitivity_V/(m/s2)")?;
        if relative.is_there() && absolute.is_there() {
            return Err(sheet
                .header_error(
                    "u_sensitivity",
                    "the uncertainty of the sensitivity stands twice, relative and in its unit",
                )
                .with_hint("keep one of the two columns"));
        }
        if absolute.is_there() {
            absolute.complete(&sheet, "sensitivity", coverage, k)?;
        } else {
            relative.complete(&sheet, "relative_%", coverage, k)?;
        }
        if phase.is_some() {
            angle.complete(&sheet, "phase_deg", coverage, k)?;
        }
        let mut groups: Vec<Vec<ReferencePoint>> = Vec::new();
        for row in sheet.rows() {
            let factor = match k {
                Some(place) => Some(row.positive(place)?),
                None => coverage,
            };
            let value = row.positive(sensitivity)?;
            let point = ReferencePoint {
                frequency: row.positive(frequency)?,
                sensitivity: value,
                phase: row.optional(phase)?.unwrap_or(0.0),
                modulus_uncertainty: if absolute.is_there() {
                    absolute.read(&row, factor)? / value
                } else {
                    relative.read(&row, factor)?
                },
                phase_uncertainty: angle.read(&row, factor)?,
            };
            if point.modulus_uncertainty > 0.5 {
                return Err(row
                    .refuse_row("the uncertainty is more than half of the sensitivity")
                    .with_hint(
                        "u_relative_% is in per cent of the sensitivity, u_sensitivity in its unit",
                    ));
            }
            match groups
                .iter_mut()
                .find(|g| g[0].frequency == point.frequency)
            {
                Some(group) => group.push(point),
                None => groups.push(vec![point]),
            }
        }
        let mut findings = Vec::new();
        let most = groups.iter().map(Vec::len).max().unwrap_or(0);
        if most > 1 {
            findings.push(findings::repeats_averaged(
                &path.display().to_string(),
                most,
                groups.len(),
            ));
        }
        let table = ReferenceTable::new(groups.iter().map(|g| ReferencePoint::mean(g)).collect())
            .map_err(|e| Error::new(ErrorKind::Format, e.to_string()).at(&path))?;
        Ok(Self {
            input: sheet.input.clone(),
            output: OUTPUTS[kind],
            table,
            phase_stated: phase.is_some(),
            findings,
            description: None,
            signed: None,
        })
    }

    /// The table as a frequency response.
    pub(crate) fn response(&self) -> Result<FrequencyResponse, proofmass_core::Error> {
        FrequencyResponse::of_table(&self.table, self.output.unit())
    }
}

/// An uncertainty as the table states it: standard or expanded.
struct Stated {
    standard: Option<Place>,
    expanded: Option<Place>,
}

impl Stated {
    fn is_there(&self) -> bool {
        self.standard.is_some() || self.expanded.is_some()
    }

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
                .with_hint(
                    "add a column `k` to the table, such as 2 in every row; or give it beside the table: in a campaign as k = 2 in [reference], else as the coverage factor that the help of the command names",
                )),
            (None, None) => Err(sheet
                .header_error(&format!("u_{ending}"), "the table has no such column")
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
