//! Two calibrations of one device over frequency, held against each other.

use crate::outcome::{Job, Outcome, section};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_calibration::FrequencyResponse;
use proofmass_calibration::frequency_response::ResponseComparison;
use proofmass_core::Watch;
use proofmass_io::{Cell, StatedQuantity, Table};
use proofmass_report::{ComparisonReport, Report};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

/// How two calibrations are compared.
///
/// ```
/// use proofmass_calibration::FrequencyResponse;
/// use proofmass_calibration::shaker::reference::{ReferencePoint, ReferenceTable};
/// use proofmass_jobs::comparison::{ComparisonData, ComparisonJob};
/// use proofmass_jobs::{Job, Unwatched};
///
/// let certificate = |sensitivity: f64| {
///     let line = |frequency: f64| ReferencePoint {
///         frequency, sensitivity, phase: 0.0, modulus_uncertainty: 0.005, phase_uncertainty: 0.005,
///     };
///     let table = ReferenceTable::new(vec![line(10.0), line(100.0), line(1000.0)])?;
///     FrequencyResponse::try_from(&table)
/// };
/// let (ours, theirs) = (certificate(0.01002)?, certificate(0.01)?);
/// let data = ComparisonData { responses: [&ours, &theirs], names: ["ours", "theirs"], findings: &[] };
/// let outcome = ComparisonJob::default().evaluate(&data, &Unwatched)?;
/// // 0.2 % with U = 1.96 · 0.5 % · √2.
/// assert!((outcome.comparison().points[0].modulus_en - 0.144).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct ComparisonJob {
    /// Probability of the expanded uncertainties in E_n.
    pub probability: f64,
}

impl Default for ComparisonJob {
    fn default() -> Self {
        Self { probability: 0.95 }
    }
}

/// Two calibrations.
#[derive(Clone, Copy, Debug)]
pub struct ComparisonData<'a> {
    /// Both; differences are the first less the second.
    pub responses: [&'a FrequencyResponse; 2],
    /// What they are called.
    pub names: [&'a str; 2],
    /// What reading them found.
    pub findings: &'a [Finding],
}

impl Job for ComparisonJob {
    type Data<'a> = ComparisonData<'a>;
    type Outcome = ComparisonOutcome;

    fn evaluate(&self, data: &ComparisonData<'_>, watch: &dyn Watch) -> Result<ComparisonOutcome> {
        watch.step("comparison", 0, 1)?;
        let [first, second] = data.responses;
        let [a, b] = data.names;
        if first.unit() != second.unit() {
            return Err(Trouble::data(format!(
                "{a} is in {}, {b} in {}",
                first.unit(),
                second.unit()
            ))
            .with_hint("calibrations of one device have one unit: bring both to the same"));
        }
        let comparison = ResponseComparison::of(first, second, self.probability).map_err(|e| {
            Trouble::from(e).detail(format!("{a} and {b}")).with_hint(
                "the same outputs and axes, ranges that meet and stated uncertainties are needed",
            )
        })?;
        watch.step("comparison", 1, 1)?;
        let mut findings = data.findings.to_vec();
        findings.extend(comparison.findings.iter().cloned());
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        Ok(ComparisonOutcome {
            names: data.names.map(str::to_owned),
            comparison,
            findings,
        })
    }
}

/// The answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ComparisonOutcome {
    names: [String; 2],
    comparison: ResponseComparison,
    findings: Vec<Finding>,
}

impl ComparisonOutcome {
    /// Point by point and as a whole.
    pub fn comparison(&self) -> &ResponseComparison {
        &self.comparison
    }

    fn page(&self, record: &Record) -> ComparisonReport<'_> {
        ComparisonReport {
            head: record.head(self.title(record), &self.findings),
            names: &self.names,
            comparison: &self.comparison,
        }
    }
}

impl Outcome for ComparisonOutcome {
    const KIND: &'static str = "comparison";

    fn title(&self, record: &Record) -> String {
        let [a, b] = &self.names;
        let title = record.title.clone();
        title.unwrap_or_else(|| format!("Comparison of {a} and {b}"))
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        Vec::new()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![section("whole", &self.comparison.whole)?])
    }

    fn tables(&self) -> Result<Vec<(String, Table)>> {
        let unit = &self.comparison.unit;
        let mut table = Table::new([
            "frequency_Hz".to_owned(),
            "element".to_owned(),
            format!("modulus_first_{unit}"),
            format!("modulus_second_{unit}"),
            "difference_percent".to_owned(),
            "U_percent".to_owned(),
            "E_n".to_owned(),
            "phase_first_deg".to_owned(),
            "phase_second_deg".to_owned(),
            "phase_difference_deg".to_owned(),
            "phase_U_deg".to_owned(),
            "phase_E_n".to_owned(),
            "chi_squared".to_owned(),
        ]);
        for p in &self.comparison.points {
            table.push([
                Cell::Number(p.frequency),
                Cell::Text(p.element.clone()),
                Cell::Number(p.value[0].norm()),
                Cell::Number(p.value[1].norm()),
                Cell::Number(100.0 * p.modulus_difference),
                Cell::Number(100.0 * p.modulus_expanded),
                Cell::Number(p.modulus_en),
                Cell::Number(p.value[0].arg().to_degrees()),
                Cell::Number(p.value[1].arg().to_degrees()),
                Cell::Number(p.phase_difference.to_degrees()),
                Cell::Number(p.phase_expanded.to_degrees()),
                Cell::Number(p.phase_en),
                Cell::Number(p.chi_square),
            ])?;
        }
        Ok(vec![("comparison.csv".to_owned(), table)])
    }

    fn summary(&self, record: &Record) -> Report {
        self.page(record).summary()
    }

    fn report(&self, record: &Record) -> Report {
        self.page(record).full()
    }
}
