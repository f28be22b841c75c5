//! Linearity over the level at one frequency.

mod page;

use crate::channels::{Channel, ChannelReading, RecordedChannels, WantedChannel};
use crate::outcome::{Job, Outcome, section};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_documents::StatedQuantity;
use proofmass_dynamic::linearity::LevelLinearity;
use proofmass_io::{Input, Source};
use proofmass_report::Report;
use proofmass_uncertainty::{Estimate, Finding};
use serde::{Deserialize, Serialize};

/// What is asked of outputs over levels.
///
/// ```
/// use proofmass_jobs::linearity::{LinearityData, LinearityJob};
/// use proofmass_jobs::{Channel, Job, Outcome, Unwatched};
///
/// let level: Vec<f64> = (1..=10).map(|k| 10.0 * f64::from(k)).collect();
/// let output: Vec<f64> = level.iter().map(|a| 0.02 * a * (1.0 + 1e-5 * a)).collect();
/// let channel = |name, unit, data| Channel { name, unit, data };
/// let data = LinearityData {
///     level: channel("a", "m/s²", &level),
///     output: channel("u", "V", &output),
///     uncertainty: channel("s", "V", &[1e-5; 10]),
///     findings: &[],
///     name: "levels",
/// };
/// let outcome = LinearityJob::default().evaluate(&data, &Unwatched)?;
/// let sensitivity = &outcome.quantities()[0];
/// assert!((sensitivity.value - 0.02).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct LinearityJob {}

/// Amplitudes at one frequency.
#[derive(Clone, Copy, Debug)]
pub struct LinearityData<'a> {
    /// Levels, m/s².
    pub level: Channel<'a>,
    /// Output amplitudes.
    pub output: Channel<'a>,
    /// Their standard uncertainties, in their unit.
    pub uncertainty: Channel<'a>,
    /// What reading the data found.
    pub findings: &'a [Finding],
    /// What the table is called in messages.
    pub name: &'a str,
}

/// A table of levels as a file has it.
#[derive(Clone, Debug)]
pub struct RecordedLevels {
    table: RecordedChannels,
}

impl RecordedLevels {
    /// Reads levels, output amplitudes and their standard uncertainties.
    ///
    /// # Errors
    /// As [`ChannelReading::read`]; an uncertainty in another unit than its output.
    pub fn read(source: Source, columns: &[WantedChannel; 3]) -> Result<Self> {
        let table = ChannelReading::table().read(source, columns)?;
        if let [_, output, u] = table.channels.as_slice()
            && output.unit != u.unit
        {
            return Err(Trouble::data(format!(
                "the output is in {}, its uncertainty in {}",
                output.unit, u.unit
            ))
            .with_hint("state the unit of both with --output-unit, or correct the headings"));
        }
        Ok(Self { table })
    }

    /// For the job.
    ///
    /// # Errors
    /// Fewer than three columns.
    pub fn data(&self) -> Result<LinearityData<'_>> {
        let [level, output, u] = self.table.channels.as_slice() else {
            return Err(Trouble::data("three columns are needed"));
        };
        Ok(LinearityData {
            level: level.view(),
            output: output.view(),
            uncertainty: u.view(),
            findings: &self.table.findings,
            name: &self.table.name,
        })
    }

    /// The file with its digest.
    pub fn input(&self) -> Input {
        self.table.input.clone()
    }
}

impl Job for LinearityJob {
    type Data<'a> = LinearityData<'a>;
    type Outcome = LinearityOutcome;

    fn evaluate(&self, data: &LinearityData<'_>, watch: &dyn Watch) -> Result<LinearityOutcome> {
        watch.step("linearity", 0, 1)?;
        if data.level.unit != "m/s²" {
            return Err(Trouble::data(format!(
                "the levels {:?} are in {}, not in a unit of acceleration",
                data.level.name, data.level.unit
            ))
            .detail(data.name)
            .with_hint("state their unit with --level-unit"));
        }
        let fit = LevelLinearity::of(
            data.level.data,
            data.output.data,
            data.uncertainty.data,
            data.output.unit,
        )
        .map_err(|e| Trouble::from(e).detail(data.name))?;
        watch.step("linearity", 1, 1)?;
        let mut findings = data.findings.to_vec();
        findings.extend(fit.findings.iter().cloned());
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        Ok(LinearityOutcome { fit, findings })
    }
}

/// The answer.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearityOutcome {
    fit: LevelLinearity,
    findings: Vec<Finding>,
}

impl LinearityOutcome {
    /// The fit.
    pub fn linearity(&self) -> &LevelLinearity {
        &self.fit
    }
}

impl Outcome for LinearityOutcome {
    const KIND: &'static str = "level-linearity";

    fn title(&self, record: &Record) -> String {
        record.title("Linearity of", "Linearity over the level")
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        StatedQuantity::list(&self.fit.estimate.quantities(), 0.95)
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn estimate(&self) -> Option<&Estimate> {
        Some(&self.fit.estimate)
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![section("non_linearity", &self.fit.non_linearity)?])
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, &self.fit)
    }
}
