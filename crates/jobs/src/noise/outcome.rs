//! What a noise analysis found.

use super::{NoiseData, NoiseJob, page};
use crate::outcome::{Outcome, section};
use crate::record::Record;
use crate::stored_result::read_section;
use crate::trouble::Result;
use proofmass_core::STANDARD_GRAVITY;
use proofmass_documents::{
    Device, ImuSensorNoise, ImuValue, ImuYaml, ResultDocument, StatedQuantity,
};
use proofmass_io::{Input, LARGEST_DOCUMENT, Source, Unit};
use proofmass_noise::{
    Analysis, AnalysisOptions, CoefficientFit, Sensor, StateSpace, Term, conservative,
};
use proofmass_report::Report;
use proofmass_signal::Trace;
use proofmass_uncertainty::findings::unit_suspected;
use proofmass_uncertainty::{DegreesOfFreedom, Finding, Quantity};
use std::collections::BTreeMap;

/// Curves, spectra and coefficients of every channel, what there is to doubt, and what filters need.
///
/// The quantities are `CHANNEL.Q`, `.N`, `.B`, `.K` and `.R` as far as their interval excludes zero, `.K_T` beside a temperature, and
/// `.robust.N`, `.robust.B`, `.robust.K` of the fit without outliers; all, with limits and reasons, stand in the analysis.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseOutcome {
    probability: f64,
    options: AnalysisOptions,
    quantities: Vec<StatedQuantity>,
    findings: Vec<Finding>,
    analysis: Analysis,
    traces: Vec<Trace>,
    /// The temperature beside them, where one was recorded.
    temperature: Option<Trace>,
    imu: Option<ImuYaml>,
}

/// How near a norm at rest comes to gravity in another unit where that is meant, relative: scale factors and biases are off by less.
const GRAVITY_WITHIN: f64 = 0.15;
/// Section of result.json that other jobs read.
const SECTION: &str = "noise";

/// The analysis in the result.json of a noise job.
///
/// # Errors
/// Another kind of file, a damaged one.
pub(crate) fn read_noise(bytes: &[u8]) -> Result<(Analysis, ResultDocument)> {
    read_section(bytes, NoiseOutcome::KIND, SECTION)
}

/// The noise result of a file: what it states, the file, its device.
pub(crate) fn noise_of(source: Source) -> Result<(Analysis, Input, Device)> {
    let name = source.name().display().to_string();
    let (bytes, input) = source.into_bytes(LARGEST_DOCUMENT)?;
    let (analysis, document) = read_noise(&bytes).map_err(|e| {
        let hint = e.hint().map(str::to_owned);
        let hint = hint.unwrap_or_else(|| "name a result.json of `proofmass noise`".to_owned());
        e.detail(name).with_hint(hint)
    })?;
    Ok((analysis, input, document.device))
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
        .filter(|f| f.code() != "gaps-in-record")
        .cloned()
        .collect();
    findings.extend(analysis.findings.iter().cloned());
    findings.extend(unit_of_gravity(analysis));
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
            first
                .clone()
                .with_evidence(|_| evidence.join("; "))
                .of_part(names.join(", ")),
        );
    }
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
    findings
}

/// Three axes in m/s² at rest, whose means together are gravity in another unit.
fn unit_of_gravity(analysis: &Analysis) -> Option<Finding> {
    let [x, y, z] = &analysis.channels[..] else {
        return None;
    };
    let all = [x, y, z];
    if all.iter().any(|c| c.unit != "m/s²") {
        return None;
    }
    let norm = all.iter().map(|c| c.mean * c.mean).sum::<f64>().sqrt();
    let said = match Unit::of_gravity(norm, GRAVITY_WITHIN) {
        Some(Unit::MetrePerSecondSquared) => return None,
        Some(unit) => format!("which is gravity in {unit}"),
        // Numbers in m/s² or mg that were taken for g.
        None => {
            let raw = norm / STANDARD_GRAVITY;
            let unit = Unit::of_gravity(raw, GRAVITY_WITHIN)?;
            format!("which is gravity where the numbers are in {unit} and were taken for g")
        }
    };
    Some(unit_suspected(
        &format!("at rest the three axes measure {norm:.4} m/s² together, {said}"),
        &format!("norm of the means {norm:.4} m/s²; gravity is {STANDARD_GRAVITY} m/s²"),
    ))
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

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![section(SECTION, &self.analysis)?])
    }

    fn page(&self, page: Report) -> Report {
        page::add(
            page,
            &self.analysis,
            &self.traces,
            self.temperature.as_ref(),
            &self.quantities,
        )
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
}
