//! Noise of several units or runs, held against each other and against the limits of a data sheet.

mod page;

use crate::data_sheet::{self, DataSheet, ReadLimit};
use crate::noise::read_noise;
use crate::outcome::{Job, Outcome};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_documents::StatedQuantity;
use proofmass_io::{Input, LARGEST_DOCUMENT, Source};
use proofmass_noise::{
    Analysis, CoefficientFit, NoiseLimit, Sensor, Term, TermSlope, UnitComparison, compare_units,
    slope_over_temperature,
};
use proofmass_report::Report;
use proofmass_uncertainty::{DegreesOfFreedom, Finding, Quantity};
use serde::{Deserialize, Serialize};

/// Which limits hold, and how often equal units may be called different.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct NoiseComparisonJob {
    /// Limits of a data sheet.
    pub limits: Vec<NoiseLimit>,
    /// Probability at which equal units are called different in any coefficient.
    pub false_alarm_rate: f64,
    /// Temperature at which each result was recorded, °C, in their order: of one sensor, the coefficients over them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub temperatures: Vec<f64>,
}

impl Default for NoiseComparisonJob {
    fn default() -> Self {
        Self {
            limits: Vec::new(),
            false_alarm_rate: 0.01,
            temperatures: Vec::new(),
        }
    }
}

/// Results of `proofmass noise`.
pub struct NoiseComparisonData<'a> {
    /// The results.
    pub results: &'a [&'a Analysis],
    /// What they are called.
    pub names: &'a [&'a str],
}

/// A result of `proofmass noise`, read again.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct NoiseDocument {
    /// The result.
    pub analysis: Analysis,
    /// The file and its digest.
    pub input: Input,
}

impl NoiseDocument {
    /// The result.json of a noise analysis.
    ///
    /// # Errors
    /// Another kind of file.
    pub fn read(source: Source) -> Result<Self> {
        let name = source.name().display().to_string();
        let (bytes, input) = source.into_bytes(LARGEST_DOCUMENT)?;
        let (analysis, _) = read_noise(&bytes).map_err(|e| {
            e.detail(name)
                .with_hint("give the folders, or result.json, of `proofmass noise … -o FOLDER`")
        })?;
        Ok(Self { analysis, input })
    }

    /// Refuses a result that is given twice, by whatever name: its unit would count twice.
    ///
    /// # Errors
    /// Two files of the same digest.
    pub fn distinct(documents: &[Self]) -> Result<()> {
        for (k, later) in documents.iter().enumerate() {
            if let Some(first) = documents[..k]
                .iter()
                .find(|d| d.input.sha256 == later.input.sha256)
            {
                return Err(Trouble::request("the same noise result is given twice")
                    .detail(format!("{} and {}", first.input.path, later.input.path))
                    .with_hint("give every result once: its unit would be counted twice"));
            }
        }
        Ok(())
    }
}

/// Limits of noise from the text of a data sheet (TOML): `[[limit]]` with `term`, `most`, `unit`, and where wanted `meaning` and `channels`.
/// Those of other characteristics are left to a check of the device.
///
/// ```
/// let text = "[[limit]]\nterm = \"N\"\nmost = 30\nunit = \"µg/√Hz\"\n";
/// let limits = proofmass_jobs::noise_comparison::limits(text)?;
/// assert_eq!((limits.len(), limits[0].most), (1, 30.0));
/// # Ok::<(), proofmass_jobs::Trouble>(())
/// ```
///
/// # Errors
/// No TOML, an unknown key or term, no limit of noise at all.
pub fn limits(text: &str) -> Result<Vec<NoiseLimit>> {
    of_noise(&data_sheet::sheet(text)?)
}

fn of_noise(sheet: &DataSheet) -> Result<Vec<NoiseLimit>> {
    let read = data_sheet::read_all(&sheet.limit, "limit")?;
    let limits: Vec<NoiseLimit> = read.iter().filter_map(ReadLimit::noise).collect();
    if limits.is_empty() {
        return Err(
            Trouble::request("the limits cannot be read: there is no [[limit]] of noise").with_hint(
                "write [[limit]] with term = \"N\", most = 30.0, unit = \"µg/√Hz\"; the others are for `proofmass device check`",
            ),
        );
    }
    Ok(limits)
}

/// Refuses a unit that the coefficient of a limit does not have, and a meaning that there is not or that the unit does not have.
pub(crate) fn meaningful(limit: &NoiseLimit) -> Result<()> {
    let symbol = limit.term.symbol();
    let sensors = [Sensor::Accelerometer, Sensor::Gyroscope];
    if let Some(meaning) = &limit.meaning
        && !NoiseLimit::MEANINGS.contains(&meaning.as_str())
    {
        return Err(Trouble::request(format!(
            "meaning = {meaning:?} of the limit of {symbol} is not known"
        ))
        .with_hint(format!("it is one of {}", NoiseLimit::MEANINGS.join(", "))));
    }
    if !sensors.iter().any(|s| limit.has_unit(*s)) {
        return Err(Trouble::request(format!(
            "{:?} is no unit of {symbol} that limits are known in",
            limit.unit
        ))
        .with_hint(
            "of N µg/√Hz, m/s/√h, (°/s)/√Hz, °/√h; of B µg, °/h; of K µg/√s, °/h/√h; of Q m/s, ″; of R µg/h, °/h²; or the SI unit",
        ));
    }
    for sensor in sensors {
        if limit.conversion(sensor, 1.0)?.is_some() {
            return Ok(());
        }
    }
    Err(Trouble::request(format!(
        "a limit of {symbol} in {} cannot be {}",
        limit.unit,
        limit.meaning.as_deref().unwrap_or_default()
    ))
    .with_hint(
        "one-sided and two-sided are for root densities (µg/√Hz), floor and coefficient for B; leave meaning out for what the unit means by itself",
    ))
}

/// Refuses results of which too few have coefficients, such as those of constant channels.
fn with_coefficients(names: &[&str], analyses: &[&Analysis], least: usize) -> Result<()> {
    let without: Vec<&str> = names
        .iter()
        .zip(analyses)
        .filter(|(_, a)| a.channels.iter().all(|c| c.whittle.is_none()))
        .map(|(name, _)| *name)
        .collect();
    if analyses.len() - without.len() >= least {
        return Ok(());
    }
    Err(Trouble::data(format!(
        "{} of {} noise results have no coefficients: there is nothing to compare",
        without.len(),
        analyses.len()
    ))
    .detail(without.join("; "))
    .with_hint(
        "a channel that never changes or is too short has none: see the findings of these results",
    ))
}

/// Refuses a limit for a channel that no result has.
fn known_channels(limit: &NoiseLimit, analyses: &[&Analysis]) -> Result<()> {
    let mut all: Vec<&str> = Vec::new();
    for channel in analyses.iter().flat_map(|a| &a.channels) {
        if !all.contains(&channel.name.as_str()) {
            all.push(&channel.name);
        }
    }
    match limit.channels.iter().find(|c| !all.contains(&c.as_str())) {
        None => Ok(()),
        Some(unknown) => Err(Trouble::request(format!(
            "the limit of {} in {} is for channel {unknown:?}, which no result has",
            limit.term.symbol(),
            limit.unit
        ))
        .with_hint(format!("the channels are {}", all.join(", ")))),
    }
}

/// [`limits`] from a file.
///
/// # Errors
/// As [`limits`], with the name of the file.
pub fn read_limits(source: Source) -> Result<(Vec<NoiseLimit>, Input)> {
    let name = source.name().display().to_string();
    let (sheet, input) = data_sheet::read_sheet(source)?;
    Ok((of_noise(&sheet).map_err(|e| e.detail(name))?, input))
}

impl Job for NoiseComparisonJob {
    type Data<'a> = NoiseComparisonData<'a>;
    type Outcome = NoiseComparisonOutcome;

    fn evaluate(
        &self,
        data: &NoiseComparisonData<'_>,
        watch: &dyn Watch,
    ) -> Result<NoiseComparisonOutcome> {
        watch.step("comparison", 0, 1)?;
        let least = if self.limits.is_empty() { 2 } else { 1 };
        if data.results.len() < least || data.names.len() != data.results.len() {
            return Err(Trouble::request(
                "a comparison needs two noise results or more, or one and limits",
            )
            .with_hint("give each of them with its name"));
        }
        let analyses = data.results;
        with_coefficients(data.names, analyses, least)?;
        for limit in &self.limits {
            meaningful(limit)?;
            known_channels(limit, analyses)?;
        }
        let slopes = self.slopes(data)?;
        let comparison = compare_units(data.names, analyses, &self.limits, self.false_alarm_rate)?;
        if comparison.channels.is_empty() && self.limits.is_empty() {
            let channels: Vec<String> = analyses
                .iter()
                .zip(data.names)
                .map(|(a, name)| {
                    let all: Vec<String> = a
                        .channels
                        .iter()
                        .map(|c| format!("{} in {}", c.name, c.unit))
                        .collect();
                    format!("{name}: {}", all.join(", "))
                })
                .collect();
            return Err(Trouble::data(
                "no two of the results have coefficients of a channel of the same name and unit",
            )
            .detail(channels.join("; "))
            .with_hint("analyse them with the same --columns and --unit"));
        }
        for limit in &self.limits {
            if comparison.limits.iter().all(|c| c.limit != *limit) {
                return Err(Trouble::request(format!(
                    "the limit of {} in {} fits no channel",
                    limit.term.symbol(),
                    limit.unit
                ))
                .with_hint(
                    "limits are for accelerations (µg/√Hz, m/s/√h, µg, µg/√s) and angular rates (°/√h, (°/s)/√Hz, °/h, °/h/√h), \
                     with meaning one-sided, two-sided, floor or coefficient; channels go by their names",
                ));
            }
        }
        watch.step("comparison", 1, 1)?;
        let probability = analyses
            .iter()
            .flat_map(|a| &a.channels)
            .find_map(|c| c.whittle.as_ref())
            .map_or(0.95, |f| f.probability);
        Ok(NoiseComparisonOutcome {
            names: data.names.iter().map(|&n| n.to_owned()).collect(),
            probability,
            comparison,
            slopes,
        })
    }
}

impl NoiseComparisonJob {
    /// The lines over the temperature, channel by channel.
    fn slopes(&self, data: &NoiseComparisonData<'_>) -> Result<Vec<(String, TermSlope)>> {
        let temperatures = &self.temperatures;
        if temperatures.is_empty() {
            return Ok(Vec::new());
        }
        let all = data.results.len();
        let usable = temperatures.iter().all(|t| (-273.15..1e4).contains(t));
        let spread = temperatures.iter().any(|t| *t != temperatures[0]);
        if temperatures.len() != all || !usable || !spread {
            return Err(Trouble::request(match (temperatures.len() == all, usable) {
                (false, _) => format!("{} temperatures are stated for {all} results", temperatures.len()),
                (true, false) => "a temperature is not a number".to_owned(),
                (true, true) => "all results are at one temperature: there is no line over it".to_owned(),
            })
            .with_hint("give one temperature in °C for each result, in their order: --temperatures=-20,20,60"));
        }
        let mut names: Vec<&str> = Vec::new();
        for channel in data.results.iter().flat_map(|a| &a.channels) {
            if !names.contains(&channel.name.as_str()) {
                names.push(&channel.name);
            }
        }
        let mut lines = Vec::new();
        for name in names {
            let of =
                |analysis: &'_ &Analysis| analysis.channels.iter().position(|c| c.name == name);
            let fits: Vec<(&CoefficientFit, f64)> = data
                .results
                .iter()
                .zip(temperatures)
                .filter_map(|(analysis, t)| {
                    let channel = &analysis.channels[of(analysis)?];
                    Some((channel.whittle.as_ref()?, *t))
                })
                .collect();
            let terms = [
                Term::Quantisation,
                Term::White,
                Term::Flicker,
                Term::RandomWalk,
            ];
            let found = terms
                .into_iter()
                .filter_map(|term| slope_over_temperature(term, &fits));
            lines.extend(found.map(|line| (name.to_owned(), line)));
        }
        Ok(lines)
    }
}

/// The answer: coefficients side by side, whether they are equal, and how they stand to the limits.
///
/// The quantities are `CHANNEL.N` and so on: the value that suits all units, where its interval excludes zero.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseComparisonOutcome {
    names: Vec<String>,
    probability: f64,
    comparison: UnitComparison,
    slopes: Vec<(String, TermSlope)>,
}

impl NoiseComparisonOutcome {
    /// Lines of the coefficients over the temperature, by channel.
    pub fn slopes(&self) -> &[(String, TermSlope)] {
        &self.slopes
    }

    /// What was compared.
    pub fn comparison(&self) -> &UnitComparison {
        &self.comparison
    }
}

impl Outcome for NoiseComparisonOutcome {
    const KIND: &'static str = "noise-comparison";

    fn title(&self, record: &Record) -> String {
        let title = record.title.clone();
        title.unwrap_or_else(|| match &self.names[..] {
            [one] => format!("Noise of {one} against its limits"),
            [all @ .., last] if all.len() < 4 => {
                format!("Noise of {} and {last}", all.join(", "))
            }
            all => format!("Noise of {} units", all.len()),
        })
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        let mut all = Vec::new();
        for channel in &self.comparison.channels {
            for term in &channel.terms {
                let Some(equal) = &term.equal else { continue };
                let (low, high) = equal.interval;
                if low * high > 0.0 {
                    let half = 0.5 * (high - low);
                    let normal = DegreesOfFreedom::INFINITE.coverage_factor(self.probability);
                    all.push(StatedQuantity::new(
                        &Quantity {
                            name: format!("{}.{}", channel.name, term.term.symbol()),
                            unit: term.unit.clone(),
                            value: equal.common,
                            standard_uncertainty: half / normal,
                            dof: DegreesOfFreedom::INFINITE,
                        },
                        self.probability,
                    ));
                }
            }
        }
        let normal = DegreesOfFreedom::INFINITE.coverage_factor(self.probability);
        for (channel, line) in &self.slopes {
            let half = 0.5 * (line.interval.1 - line.interval.0);
            all.push(StatedQuantity::new(
                &Quantity {
                    name: format!("{channel}.{}.slope", line.term.symbol()),
                    unit: format!("{}/K", line.unit),
                    value: line.slope,
                    standard_uncertainty: half / normal,
                    dof: DegreesOfFreedom::INFINITE,
                },
                self.probability,
            ));
        }
        all
    }

    fn findings(&self) -> &[Finding] {
        &self.comparison.findings
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }
}
