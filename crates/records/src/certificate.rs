//! What a certificate of a standard says of its uncertainty: typed, or read from its table.

use crate::entry::{FiledCertificate, FiledDevice, spelling};
use proofmass_documents::DigitalCertificate;
use proofmass_dynamic::reference_table::{ReferencePoint, ReferenceTable};
use proofmass_io::Source;
use proofmass_jobs::campaign::{Certificate, CertificateOptions};
use proofmass_jobs::{Result, Trouble};
use proofmass_uncertainty::Finding;
use std::path::Path;

/// Coverage factor of expanded uncertainties in a table that does not say it.
const COVERAGE: f64 = 2.0;
/// Share by which a typed uncertainty may lie beyond those of the table, for rounding.
const ROUNDING: f64 = 0.05;

impl FiledCertificate {
    /// Takes the uncertainties from the file, where it is a table that campaigns read, and all that is not stated from a digital
    /// calibration certificate; a page is left as it is. Beside it what is to be doubted, such as a signature that nobody checked.
    ///
    /// # Errors
    /// A table that cannot be read; a typed uncertainty that is none of the table; another number or serial number than that of the certificate.
    pub fn reading(
        mut self,
        name: &str,
        bytes: &[u8],
        standard: &FiledDevice,
    ) -> Result<(Self, Vec<Finding>)> {
        let is = |end: &str| name.to_lowercase().ends_with(end);
        let is_digital = DigitalCertificate::is_named(Path::new(name));
        if !is(".csv") && !is(".json") && !is_digital {
            return Ok((self, Vec::new()));
        }
        let mut doubts = Vec::new();
        if is_digital {
            let said = DigitalCertificate::from_source(Source::from_bytes(name, bytes.to_vec())?)?;
            doubts = said.findings();
            self.head(name, said, standard)?;
        }
        let read = |coverage| {
            let mut options = CertificateOptions::default();
            options.coverage = coverage;
            // Whoever files it by its number has accepted it.
            options.accept_unchecked_signature = Some(self.number.clone());
            Certificate::from_document(Source::from_bytes(name, bytes.to_vec())?, &options)
        };
        let table = match read(None) {
            Ok(read) => read.table,
            // Where k is what lacks, the second reading says what else does.
            Err(_) => match read(Some(COVERAGE)) {
                Ok(read) => read.table,
                // A certificate of another quantity is kept as it is.
                Err(_) if is_digital => return Ok((self, doubts)),
                Err(other) => return Err(other),
            },
        };
        let each: Vec<[f64; 2]> = table
            .points()
            .iter()
            .map(|p| [p.frequency, p.modulus_uncertainty])
            .collect();
        let least = each.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min);
        let most = each.iter().map(|p| p[1]).fold(0.0, f64::max);
        if let Some(u) = self.u_relative
            && !((1.0 - ROUNDING) * least..=(1.0 + ROUNDING) * most).contains(&u)
        {
            let percent = |u: f64| format!("{:.3}", 200.0 * u);
            let [low, high] = [percent(least), percent(most)];
            let stated = match low == high {
                true => low,
                false => format!("{low} to {high}"),
            };
            return Err(Trouble::request(format!(
                "{name} states U of {stated} % with k = 2, not {} %",
                percent(u)
            ))
            .with_hint("leave the uncertainty out: the table says it; or correct one of the two"));
        }
        if most > 0.0 {
            self.u_relative = self
                .u_relative
                .or((most - least <= ROUNDING * most).then_some(most));
            self.u_at = each;
        }
        Ok((self, doubts))
    }

    /// Takes number, laboratory and first day from a digital calibration certificate, where they are not stated.
    fn head(&mut self, name: &str, said: DigitalCertificate, standard: &FiledDevice) -> Result<()> {
        if let (Some(of), Some(known)) = (&said.item.serial, &standard.serial)
            && spelling(of) != spelling(known)
        {
            return Err(Trouble::request(format!(
                "{name} is the certificate of {}, not of {}",
                said.item.line(),
                standard.line()
            ))
            .with_hint("name the standard that it is of, or the right file"));
        }
        let missing = |what: &str| {
            Trouble::request(format!("{name} does not say {what}"))
                .with_hint("it stands in other words there, or nowhere: say it yourself")
        };
        if self.number.is_empty() {
            self.number = said
                .identifier
                .clone()
                .ok_or_else(|| missing("its number"))?;
        }
        if said.identifier.as_ref().is_some_and(|n| *n != self.number) {
            return Err(Trouble::request(format!(
                "{name} has the number {}, not {}",
                said.identifier.unwrap_or_default(),
                self.number
            ))
            .with_hint("leave the number out: the certificate says it; or name the right file"));
        }
        if self.valid_from.is_empty() {
            let day = said.performed.map(|[_, last]| last).or(said.issued);
            self.valid_from = day.ok_or_else(|| missing("when it was calibrated"))?;
        }
        self.laboratory = self.laboratory.take().or(said.laboratory);
        Ok(())
    }

    /// Relative standard uncertainty at a frequency, or that of all; `None` where the certificate does not say it.
    pub(crate) fn u(&self, frequency: Option<f64>) -> Option<f64> {
        let at = frequency.filter(|_| !self.u_at.is_empty()).and_then(|f| {
            let point = |[frequency, u]: &[f64; 2]| ReferencePoint {
                frequency: *frequency,
                sensitivity: 1.0,
                phase: 0.0,
                modulus_uncertainty: *u,
                phase_uncertainty: 0.0,
            };
            let table = ReferenceTable::new(self.u_at.iter().map(point).collect()).ok()?;
            Some(table.at(f).ok()?.modulus_uncertainty)
        });
        at.or(self.u_relative).filter(|u| *u > 0.0)
    }
}
