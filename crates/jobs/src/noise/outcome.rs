//! What a noise analysis found.

use super::page::NoiseReport;
use super::{NoiseData, NoiseJob};
use crate::outcome::Outcome;
use crate::record::Record;
use crate::trouble::Result;
use proofmass_io::{Cell, ImuSensorNoise, ImuValue, ImuYaml, StatedQuantity, Table};
use proofmass_noise::{
    Analysis, AnalysisOptions, CoefficientFit, Sensor, StateSpace, Term, Verdict, conservative,
};
use proofmass_report::Report;
use proofmass_signal::Trace;
use proofmass_uncertainty::{DegreesOfFreedom, Finding, Quantity};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Curves, spectra and coefficients of every channel, what there is to doubt, and what filters need.
///
/// The quantities are `CHANNEL.Q`, `.N`, `.B`, `.K` and `.R` as far as their interval excludes zero, `.K_T` beside a temperature, and
/// `.robust.N`, `.robust.B`, `.robust.K` of the fit without outliers; all, with limits and reasons, stand in the analysis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoiseOutcome {
    probability: f64,
    options: AnalysisOptions,
    quantities: Vec<StatedQuantity>,
    findings: Vec<Finding>,
    analysis: Analysis,
    traces: Vec<Trace>,
    /// The temperature beside them, where one was recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    temperature: Option<Trace>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    imu: Option<ImuYaml>,
}

impl NoiseOutcome {
    pub(super) fn new(
        job: &NoiseJob,
        data: &NoiseData<'_>,
        analysis: Analysis,
        sensors: Vec<Option<Sensor>>,
        traces: Vec<Trace>,
    ) -> Self {
        let probability = job.options.fit.probability;
        Self {
            probability,
            options: job.options.clone(),
            quantities: quantities(&analysis, probability),
            findings: findings(data.findings, &analysis),
            imu: imu(&analysis, &sensors, &job.rostopic),
            traces,
            temperature: None,
            analysis,
        }
    }

    pub(super) fn with_temperature(self, temperature: Option<Trace>) -> Self {
        Self {
            temperature,
            ..self
        }
    }

    /// The analysis of every channel.
    pub fn analysis(&self) -> &Analysis {
        &self.analysis
    }

    /// What visual–inertial programs read, where accelerations or angular rates were recorded.
    pub fn imu_yaml(&self) -> Option<&ImuYaml> {
        self.imu.as_ref()
    }

    fn page(&self, record: &Record) -> NoiseReport<'_> {
        NoiseReport {
            head: record.head(self.title(record), &self.findings),
            traces: &self.traces,
            temperature: self.temperature.as_ref(),
        }
    }

    /// The curve of every window.
    fn windows(&self) -> Result<Table> {
        let mut table = Table::new([
            "channel",
            "unit",
            "from_s",
            "to_s",
            "factor",
            "tau_s",
            "deviation",
            "low",
            "high",
        ]);
        for channel in &self.analysis.channels {
            for window in &channel.windows {
                for p in &window.curve.points {
                    table.push([
                        Cell::from(channel.name.as_str()),
                        Cell::from(channel.unit.as_str()),
                        Cell::from(window.from),
                        Cell::from(window.to),
                        Cell::from(p.factor),
                        Cell::from(p.tau),
                        Cell::from(p.deviation),
                        Cell::from(p.interval.map(|i| i.0)),
                        Cell::from(p.interval.map(|i| i.1)),
                    ])?;
                }
            }
        }
        Ok(table)
    }

    /// The variance of each of three sensors by itself.
    fn separated(&self) -> Result<Table> {
        let mut table = Table::new([
            "sensor",
            "factor",
            "tau_s",
            "variance",
            "u_variance",
            "deviation",
        ]);
        for (k, name) in self.separated_names().into_iter().enumerate() {
            for p in &self.analysis.separated {
                table.push([
                    Cell::from(name.as_str()),
                    Cell::from(p.factor),
                    Cell::from(p.tau),
                    Cell::from(p.variances[k]),
                    Cell::from(p.uncertainties[k]),
                    Cell::from(p.deviation(k)),
                ])?;
            }
        }
        Ok(table)
    }

    /// The channels, and the clock they were measured against.
    fn separated_names(&self) -> [String; 3] {
        let name = |k: usize| {
            let channel = self.analysis.channels.get(k);
            channel.map_or_else(|| "reference".to_owned(), |c| c.name.clone())
        };
        [name(0), name(1), name(2)]
    }

    /// The fitted noise of every channel as states of a filter.
    fn states(&self) -> Result<Option<Vec<u8>>> {
        let all: BTreeMap<&str, &StateSpace> = self
            .analysis
            .channels
            .iter()
            .filter_map(|c| Some((c.name.as_str(), c.states.as_ref()?)))
            .collect();
        if all.is_empty() {
            return Ok(None);
        }
        Ok(Some(proofmass_io::finite::to_json(&all)?))
    }

    fn deviations(&self) -> Result<Table> {
        let mut table = Table::new([
            "channel",
            "unit",
            "statistic",
            "factor",
            "tau_s",
            "deviation",
            "low",
            "high",
            "edf",
            "model",
            "inside",
        ]);
        for channel in &self.analysis.channels {
            let modelled = channel.compensated.as_ref().or(channel.curve.as_ref());
            let curves = channel
                .curve
                .iter()
                .chain(&channel.compensated)
                .chain(&channel.further);
            for (index, curve) in curves.enumerate() {
                let beside = modelled.is_some_and(|m| std::ptr::eq(m, curve));
                let mut name = curve.statistic.abbreviation().to_owned();
                if index == 1 && channel.compensated.is_some() {
                    name += " without temperature";
                }
                let unit = curve.statistic.unit(&channel.unit);
                for (k, p) in curve.points.iter().enumerate() {
                    let fitted = channel.fitted.get(k).filter(|_| beside);
                    table.push([
                        Cell::from(channel.name.as_str()),
                        Cell::from(unit.as_str()),
                        Cell::from(name.as_str()),
                        Cell::from(p.factor),
                        Cell::from(p.tau),
                        Cell::from(p.deviation),
                        Cell::from(p.interval.map(|i| i.0)),
                        Cell::from(p.interval.map(|i| i.1)),
                        Cell::from(p.edf),
                        Cell::from(fitted.map(|f| f.deviation)),
                        Cell::from(fitted.map(|f| f64::from(u8::from(f.inside)))),
                    ])?;
                }
            }
        }
        Ok(table)
    }

    fn spectra(&self) -> Result<Table> {
        let mut table = Table::new([
            "channel",
            "unit",
            "frequency_Hz",
            "density_one_sided",
            "low",
            "high",
            "model",
        ]);
        for channel in &self.analysis.channels {
            let unit = format!("({})²/Hz", channel.unit);
            for p in &channel.spectrum {
                table.push([
                    Cell::from(channel.name.as_str()),
                    Cell::from(unit.as_str()),
                    Cell::from(p.frequency),
                    Cell::from(p.density),
                    Cell::from(p.interval.map(|i| i.0)),
                    Cell::from(p.interval.map(|i| i.1)),
                    Cell::from(p.model),
                ])?;
            }
        }
        Ok(table)
    }

    fn coefficients(&self) -> Result<Table> {
        let mut table = Table::new([
            "channel",
            "term",
            "verdict",
            "value",
            "unit",
            "u",
            "low",
            "high",
            "parameter",
        ]);
        for channel in &self.analysis.channels {
            let mut row = |symbol: &str,
                           signed: bool,
                           verdict: &Verdict,
                           unit: &str,
                           parameter: Option<f64>| {
                let (low, high) = match (verdict.interval(), verdict.upper()) {
                    (Some((low, high)), _) => (Some(low), Some(high)),
                    // A limit of what may have either sign is one of its size.
                    (None, Some(limit)) if signed => (Some(-limit), Some(limit)),
                    (None, limit) => (None, limit),
                };
                table.push([
                    Cell::from(channel.name.as_str()),
                    Cell::from(symbol),
                    Cell::from(word(verdict)),
                    Cell::from(verdict.value()),
                    Cell::from(unit),
                    Cell::from(verdict.standard_uncertainty()),
                    Cell::from(low),
                    Cell::from(high),
                    Cell::from(parameter),
                ])
            };
            for c in channel.whittle.iter().flat_map(|f| &f.coefficients) {
                let parameter = c.parameter.map(|p| p.value);
                row(
                    c.term.symbol(),
                    c.term.is_signed(),
                    &c.verdict,
                    &c.unit,
                    parameter,
                )?;
            }
            if let Some(t) = channel
                .whittle
                .as_ref()
                .and_then(|f| f.temperature.as_ref())
            {
                row("K_T", true, &t.verdict, &t.unit, Some(t.lag))?;
            }
            for c in channel.robust.iter().flat_map(|r| &r.fit.coefficients) {
                let parameter = c.parameter.map(|p| p.value);
                let symbol = format!("{} robust", c.term.symbol());
                row(&symbol, c.term.is_signed(), &c.verdict, &c.unit, parameter)?;
            }
        }
        Ok(table)
    }
}

fn word(verdict: &Verdict) -> &'static str {
    match verdict {
        Verdict::Identified { .. } => "identified",
        Verdict::Present { .. } => "present",
        Verdict::Reported { .. } => "reported",
        Verdict::NotIdentifiable { .. } => "not identifiable",
        Verdict::Fixed { .. } => "given",
    }
}

/// Coefficients whose interval excludes zero: U is half the interval.
fn quantities(analysis: &Analysis, probability: f64) -> Vec<StatedQuantity> {
    let mut all = Vec::new();
    for channel in &analysis.channels {
        let mut seen: Vec<Term> = Vec::new();
        for c in channel.whittle.iter().flat_map(|f| &f.coefficients) {
            let (Some(value), Some(u)) = (c.verdict.value(), c.verdict.standard_uncertainty())
            else {
                continue;
            };
            let before = seen.iter().filter(|t| **t == c.term).count();
            seen.push(c.term);
            let name = match (c.term, before) {
                (Term::GaussMarkov | Term::Sinusoid, n) => {
                    format!("{}.{}{}", channel.name, c.term.symbol(), n + 1)
                }
                _ => format!("{}.{}", channel.name, c.term.symbol()),
            };
            all.push(stated(name, &c.unit, value, u, probability));
        }
        let temperature = channel
            .whittle
            .as_ref()
            .and_then(|f| f.temperature.as_ref());
        if let Some(t) = temperature
            && let (Some(value), Some(u)) = (t.verdict.value(), t.verdict.standard_uncertainty())
        {
            let name = format!("{}.K_T", channel.name);
            all.push(stated(name, &t.unit, value, u, probability));
        }
        for c in channel.robust.iter().flat_map(|r| &r.fit.coefficients) {
            if !matches!(c.term, Term::White | Term::Flicker | Term::RandomWalk) {
                continue;
            }
            if let (Some(value), Some(u)) = (c.verdict.value(), c.verdict.standard_uncertainty()) {
                let name = format!("{}.robust.{}", channel.name, c.term.symbol());
                all.push(stated(name, &c.unit, value, u, probability));
            }
        }
    }
    all
}

fn stated(name: String, unit: &str, value: f64, u: f64, probability: f64) -> StatedQuantity {
    StatedQuantity::new(
        &Quantity {
            name,
            unit: unit.to_owned(),
            value,
            standard_uncertainty: u,
            dof: DegreesOfFreedom::INFINITE,
        },
        probability,
    )
}

/// Those of the recording, of the whole analysis, and of the channels, of which the same doubt is said once; gravest first.
fn findings(recording: &[Finding], analysis: &Analysis) -> Vec<Finding> {
    // What the stamps say of gaps was looked at again, against the line of their clock.
    let mut findings: Vec<Finding> = recording
        .iter()
        .filter(|f| f.code() != "time-gaps")
        .cloned()
        .collect();
    findings.extend(analysis.findings.iter().cloned());
    let mut groups: Vec<(&Finding, Vec<(&str, &Finding)>)> = Vec::new();
    for channel in &analysis.channels {
        for finding in &channel.findings {
            let same = |g: &&mut (&Finding, Vec<(&str, &Finding)>)| {
                g.0.code() == finding.code()
                    && g.0.what() == finding.what()
                    && g.0.severity() == finding.severity()
            };
            match groups.iter_mut().find(same) {
                Some(group) => group.1.push((&channel.name, finding)),
                None => groups.push((finding, vec![(&channel.name, finding)])),
            }
        }
    }
    for (first, members) in groups {
        let names: Vec<&str> = members.iter().map(|m| m.0).collect();
        let evidence: Vec<String> = match members[..] {
            [(_, one)] => vec![one.evidence_text().to_owned()],
            _ => members
                .iter()
                .map(|(name, f)| format!("{name}: {}", f.evidence_text()))
                .collect(),
        };
        findings.push(
            Finding::new(
                first.severity(),
                first.code(),
                format!("{}: {}", names.join(", "), first.what()),
            )
            .evidence(evidence.join("; "))
            .advice(first.advice_text()),
        );
    }
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
    findings
}

fn imu(analysis: &Analysis, sensors: &[Option<Sensor>], rostopic: &str) -> Option<ImuYaml> {
    let noise = |wanted: Sensor| {
        let fits: Vec<&CoefficientFit> = sensors
            .iter()
            .zip(&analysis.channels)
            .filter(|(sensor, _)| **sensor == Some(wanted))
            .filter_map(|(_, channel)| channel.whittle.as_ref())
            .collect();
        let value = |term| {
            conservative(term, &fits).map(|c| ImuValue {
                value: c.value,
                reason: c.reason,
            })
        };
        Some(ImuSensorNoise {
            noise_density: value(Term::White)?,
            random_walk: value(Term::RandomWalk)?,
        })
    };
    let file = ImuYaml {
        rostopic: rostopic.to_owned(),
        update_rate: analysis.sample_rate,
        accelerometer: noise(Sensor::Accelerometer),
        gyroscope: noise(Sensor::Gyroscope),
    };
    (file.accelerometer.is_some() || file.gyroscope.is_some()).then_some(file)
}

impl Outcome for NoiseOutcome {
    const KIND: &'static str = "noise";
    const PRINCIPAL_TABLE: &'static str = "coefficients.csv";

    fn title(&self, record: &Record) -> String {
        record.title("Noise of", "Noise of a sensor at rest")
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.quantities.clone()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn tables(&self) -> Result<Vec<(String, Table)>> {
        let mut list = vec![
            ("coefficients.csv".to_owned(), self.coefficients()?),
            ("deviation.csv".to_owned(), self.deviations()?),
            ("spectrum.csv".to_owned(), self.spectra()?),
        ];
        if self.analysis.channels.iter().any(|c| !c.windows.is_empty()) {
            list.push(("dynamic.csv".to_owned(), self.windows()?));
        }
        if !self.analysis.separated.is_empty() {
            list.push(("separated.csv".to_owned(), self.separated()?));
        }
        Ok(list)
    }

    fn attachments(&self, _record: &Record) -> Result<Vec<(String, Vec<u8>)>> {
        let mut list = match &self.imu {
            Some(imu) => vec![
                ("imu.yaml".to_owned(), imu.to_text().into_bytes()),
                (
                    "kalibr_imu_chain.yaml".to_owned(),
                    imu.to_chain_text().into_bytes(),
                ),
            ],
            None => Vec::new(),
        };
        if let Some(bytes) = self.states()? {
            list.push(("state_space.json".to_owned(), bytes));
        }
        Ok(list)
    }

    fn summary(&self, record: &Record) -> Report {
        self.page(record).summary(&self.analysis)
    }

    fn report(&self, record: &Record) -> Report {
        self.page(record).full(&self.analysis)
    }
}
