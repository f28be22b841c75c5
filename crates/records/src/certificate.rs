//! What a certificate of a standard says of its uncertainty: typed, or read from its table.

use crate::entry::FiledCertificate;
use proofmass_dynamic::reference_table::{ReferencePoint, ReferenceTable};
use proofmass_io::Source;
use proofmass_jobs::campaign::{Certificate, CertificateOptions};
use proofmass_jobs::{Result, Trouble};

/// Coverage factor of expanded uncertainties in a table that does not say it.
const COVERAGE: f64 = 2.0;
/// Share by which a typed uncertainty may lie beyond those of the table, for rounding.
const ROUNDING: f64 = 0.05;

impl FiledCertificate {
    /// Takes the uncertainties from the file, where it is a table that campaigns read; a page is left as it is.
    ///
    /// # Errors
    /// A table that cannot be read; a typed uncertainty that is none of the table.
    pub fn reading(mut self, name: &str, bytes: &[u8]) -> Result<Self> {
        let is_table = [".csv", ".json"]
            .iter()
            .any(|end| name.to_lowercase().ends_with(end));
        if !is_table {
            return Ok(self);
        }
        let read = |coverage| {
            let mut options = CertificateOptions::default();
            options.coverage = coverage;
            Certificate::from_document(Source::from_bytes(name, bytes.to_vec())?, &options)
        };
        let table = match read(None) {
            Ok(read) => read.table,
            Err(first) => read(Some(COVERAGE)).map_err(|_| first)?.table,
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
        Ok(self)
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
