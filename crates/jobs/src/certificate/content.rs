//! What a certificate is made of: the request put together with what the result states, and what is missing to it.

use super::conformity::{self, DecidedEntry};
use super::laboratory::CertificateFile;
use super::results::{StatedResults, method};
use super::standards;
use super::texts::{Language, Text};
use super::{CertificateData, CertificateJob};
use crate::StoredResult;
use crate::measured_within::{MEASURED_WITHIN, MeasuredWithin};
use crate::trouble::{Result, Trouble};
use proofmass_io::ReadGravity;
use proofmass_report::number::{minus, two_digits};
use proofmass_uncertainty::Severity;
use serde::Serialize;

/// The content of a certificate as data.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Content {
    /// Request, with maker, type and serial number of the result where it says none.
    #[serde(flatten)]
    pub(super) file: CertificateFile,
    pub(super) issued: Option<String>,
    #[serde(skip)]
    pub(super) method: Text,
    #[serde(skip)]
    pub(super) norms: Vec<String>,
    /// Normal gravity that the result was held against.
    #[serde(skip)]
    pub(super) gravity: Option<ReadGravity>,
    #[serde(rename = "temperature_of_the_result_degC")]
    temperature: Option<f64>,
    #[serde(rename = "measured_within")]
    measured: MeasuredWithin,
    #[serde(skip)]
    is_of_shaker: bool,
    /// What the terms of its parameters are.
    #[serde(skip)]
    about_terms: Option<Text>,
    pub(super) conditions: Option<String>,
    pub(super) results: StatedResults,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) as_found: Option<StatedResults>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) decisions: Vec<DecidedEntry>,
    /// What is missing to a released certificate.
    pub(super) missing: Vec<String>,
}

impl Content {
    pub(super) fn of(job: &CertificateJob, data: &CertificateData<'_>) -> Result<Self> {
        let (result, as_found) = (data.result, data.as_found);
        let results = StatedResults::of(result)?;
        if let Some(found) = as_found
            && found.kind() != result.kind()
        {
            return Err(Trouble::request(format!(
                "the result as found is of kind `{}`, that as left of kind `{}`",
                found.kind(),
                result.kind()
            )));
        }
        if let Some(found) = as_found {
            let line = |r: &StoredResult| r.record().device.line();
            let (of_found, of_left) = (line(found), line(result));
            if of_found != of_left {
                let named = |s: String| if s.is_empty() { "none".to_owned() } else { s };
                return Err(Trouble::request(format!(
                    "the result as found is of the device {}, that as left of {}",
                    named(of_found),
                    named(of_left)
                ))
                .with_hint("name the result of the same item before it was adjusted"));
            }
            if found.to_json()? == result.to_json()? {
                return Err(
                    Trouble::request("the result as found is the result as left")
                        .with_hint("name the result of the item before it was adjusted"),
                );
            }
        }
        contradiction(job, result)?;
        let (text, norms) = method(result.kind()).unwrap_or((Text::Method, &[]));
        let mut file = job.file.clone();
        let device = &result.record().device;
        let mut item = file.item.unwrap_or_default();
        for (stated, of_result) in [
            (&mut item.manufacturer, &device.manufacturer),
            (&mut item.model, &device.model),
            (&mut item.serial, &device.serial),
        ] {
            if let (Some(a), Some(b)) = (&*stated, of_result)
                && a != b
            {
                return Err(Trouble::request(format!(
                    "the item is {a:?}, but the result is one of {b:?}"
                ))
                .with_hint(
                    "name the result of this item, or leave out what stands in the result",
                ));
            }
            if stated.is_none() {
                stated.clone_from(of_result);
            }
        }
        file.item = Some(item);
        let ambient = &result.record().ambient;
        let mut content = Self {
            decisions: conformity::decide(&file, result, &results)?,
            file,
            issued: job.issued.clone(),
            method: text,
            norms: norms.iter().map(|n| (*n).to_owned()).collect(),
            gravity: standards::normal_gravity(result).cloned(),
            temperature: ambient.temperature_deg_c,
            measured: measured(job, result)?,
            about_terms: match result.kind() {
                "temperature" => Some(Text::TemperatureTerms),
                "multi-position" => Some(Text::ParametersOfModel),
                _ => None,
            },
            is_of_shaker: norms.iter().any(|n| n.starts_with("ISO 16063")),
            conditions: ambient.description.clone(),
            results,
            as_found: as_found.map(StatedResults::of).transpose()?,
            missing: Vec::new(),
        };
        content.missing = content.what_is_missing(data);
        Ok(content)
    }

    fn temperature(&self) -> Option<[f64; 2]> {
        let stated = self.file.calibration.as_ref().and_then(|c| c.temperature);
        stated.or(self.temperature.map(|t| [t, t]))
    }

    /// Environmental conditions.
    pub(super) fn environment(&self) -> Vec<Span> {
        let humidity = self.file.calibration.as_ref().and_then(|c| c.humidity);
        let ends = |[low, high]: [f64; 2]| vec![low.to_string(), high.to_string()];
        let of = |range: Option<[f64; 2]>, text, unit, ref_type| {
            range.map(|range| Span::new(text, ends(range), unit, ref_type))
        };
        let all = [
            of(
                self.temperature(),
                Text::Temperature,
                "°C",
                "basic_temperature",
            ),
            of(humidity, Text::Humidity, "%", "basic_humidityRelative"),
        ];
        all.into_iter().flatten().collect()
    }

    /// Levels and temperatures within which the item was measured.
    pub(super) fn within(&self) -> Vec<Span> {
        let degrees = |t: f64| format!("{t:.2}");
        let m = &self.measured;
        let all = [
            m.acceleration.map(|range| {
                let ends = three_digits(range).to_vec();
                Span::new(Text::Amplitude, ends, "m/s²", "vib_accelerationAmplitude")
            }),
            m.temperature.map(|range| {
                let ends = range.map(degrees).to_vec();
                Span::new(Text::CalibratedOver, ends, "°C", "vib_itemTemperature")
            }),
            m.reference_temperature.map(|t| {
                let ends = vec![degrees(t)];
                Span::new(
                    Text::ReferenceTemperature,
                    ends,
                    "°C",
                    "vib_referenceTemperature",
                )
            }),
        ];
        all.into_iter().flatten().collect()
    }

    /// What the results are traceable through: sentences, and the numbers that stand in their braces.
    pub(super) fn traceability(&self) -> Vec<(Text, Vec<(&'static str, String)>)> {
        let standards = &self.file.standards;
        let by_standards =
            (!standards.is_empty()).then(|| (Text::TraceabilityStatement, Vec::new()));
        let gravity = self.gravity.as_ref();
        let gravity = gravity.and_then(|g| Some((g, g.normal_at?)));
        let by_gravity = gravity.map(|(g, [latitude, height])| {
            let numbers = vec![
                ("latitude", minus(&format!("{latitude}°"))),
                ("height", minus(&format!("{height} m"))),
                ("g", format!("g = {:.6} m/s²", g.value)),
                ("u", format!("{} m/s²", two_digits(g.standard_uncertainty))),
            ];
            (Text::GravityStatement, numbers)
        });
        by_standards.into_iter().chain(by_gravity).collect()
    }

    /// The statement on uncertainty, sentence by sentence.
    pub(super) fn uncertainty_statement(
        &self,
        language: Language,
        probability: &str,
    ) -> Vec<String> {
        let mut all = vec![
            Text::UncertaintyStatement.with(language, &[("probability", probability)]),
            Text::RoundingStatement.of(language).to_owned(),
        ];
        all.extend(
            self.results
                .about_phases()
                .map(|t| t.of(language).to_owned()),
        );
        if self.results.has_intervals() {
            all.push(Text::IntervalStatement.of(language).to_owned());
        }
        all.extend(self.about_terms.map(|t| t.of(language).to_owned()));
        all.push(Text::CovarianceStatement.of(language).to_owned());
        all
    }

    /// Everything that a released certificate needs and that is not there, each in one line.
    fn what_is_missing(&self, data: &CertificateData<'_>) -> Vec<String> {
        let mut missing = Vec::new();
        let mut need = |there: bool, what: &str| {
            if !there {
                missing.push(what.to_owned());
            }
        };
        let said = |text: Option<&String>| text.is_some_and(|t| says(t));
        for (contact, name) in [
            (&self.file.laboratory, "laboratory"),
            (&self.file.customer, "customer"),
        ] {
            let contact = contact.clone().unwrap_or_default();
            need(
                said(contact.name.as_ref()),
                &format!("{name}.name: name of the {name}"),
            );
            need(
                said(contact.town.as_ref()),
                &format!("{name}.town: address of the {name}"),
            );
            need(
                said(contact.country.as_ref()),
                &format!("{name}.country: country of the {name}, two letters"),
            );
        }
        let item = self.file.item.clone().unwrap_or_default();
        need(
            said(item.serial.as_ref()) || said(item.customer_id.as_ref()),
            "item.serial or item.customer_id: what tells this item from its like",
        );
        need(said(item.model.as_ref()), "item.model: type of the item");
        need(
            said(item.condition.as_ref()),
            "item.condition: condition on receipt",
        );
        let calibration = self.file.calibration.clone().unwrap_or_default();
        need(
            said(calibration.received.as_ref()),
            "calibration.received: date of receipt",
        );
        need(
            said(calibration.begin.as_ref()),
            "calibration.begin: date of the calibration",
        );
        need(
            self.temperature().is_some(),
            "calibration.temperature_degC: environmental conditions",
        );
        if self.is_of_shaker {
            need(
                said(calibration.mounting.as_ref()),
                "calibration.mounting: how the item was mounted",
            );
            need(
                self.measured.acceleration.is_some(),
                "calibration.acceleration_m/s2: amplitude of the acceleration, lowest and highest",
            );
        }
        need(self.issued.is_some(), "the date of issue");
        let sign = &self.file.signatories;
        need(
            !sign.is_empty() && sign.iter().all(|s| says(&s.name) && says(&s.role)),
            "signatories: name and role of who authorises the certificate",
        );
        for entry in &self.file.conformity {
            need(
                said(entry.source.as_ref()),
                &format!(
                    "conformity.source: where the limits of {} come from",
                    entry.quantity
                ),
            );
        }
        need(
            !self.file.standards.is_empty() || self.gravity.is_some(),
            "standards: the standards with their certificates",
        );
        let days = [
            ("calibration.received", &calibration.received),
            ("calibration.begin", &calibration.begin),
            ("calibration.end", &calibration.end),
            ("the date of issue", &self.issued),
        ];
        let known: Vec<(&str, &String)> = days
            .iter()
            .filter_map(|(n, d)| Some((*n, d.as_ref()?)))
            .collect();
        for pair in known.windows(2) {
            if pair[0].1 > pair[1].1 {
                missing.push(format!(
                    "{} ({}) lies after {} ({})",
                    pair[0].0, pair[0].1, pair[1].0, pair[1].1
                ));
            }
        }
        let day = calibration.end.as_ref().or(calibration.begin.as_ref());
        if let (Some(due), Some(day)) = (&calibration.due, day)
            && due <= day
        {
            missing.push(format!(
                "calibration.due ({due}) does not lie after the calibration ({day})"
            ));
        }
        missing.extend(standards::doubts(&self.file, data, day));
        for (result, which) in [(Some(data.result), ""), (data.as_found, " as found")] {
            let findings = result.into_iter().flat_map(|r| r.findings());
            for finding in findings.filter(|f| f.severity() == Severity::Decision) {
                missing.push(format!(
                    "{}{which}: {} [{}]",
                    super::OPEN,
                    finding.what(),
                    finding.code()
                ));
            }
        }
        if let (Some([low, high]), Some(t)) = (self.temperature(), self.temperature)
            && !(low - 0.5..=high + 0.5).contains(&t)
        {
            missing.push(format!("calibration.temperature_degC: {low} to {high} °C, but the result was measured at {t} °C"));
        }
        missing
    }
}

/// A number or a range that is stated with a unit.
pub(super) struct Span {
    pub(super) text: Text,
    pub(super) ends: Vec<String>,
    pub(super) unit: &'static str,
    /// Kind in a digital certificate.
    pub(super) ref_type: &'static str,
}

impl Span {
    fn new(text: Text, ends: Vec<String>, unit: &'static str, ref_type: &'static str) -> Self {
        Self {
            text,
            ends,
            unit,
            ref_type,
        }
    }
}

/// What the result says of its levels; where it says nothing of its amplitude, what the laboratory says.
fn measured(job: &CertificateJob, result: &StoredResult) -> Result<MeasuredWithin> {
    let section = result.section(MEASURED_WITHIN).cloned();
    let mut measured: MeasuredWithin = match section {
        None => MeasuredWithin::default(),
        Some(section) => serde_json::from_value(section)
            .map_err(|e| Trouble::data(format!("{MEASURED_WITHIN} of the result: {e}")))?,
    };
    let stated = job.file.calibration.as_ref().and_then(|c| c.acceleration);
    match (measured.acceleration, stated) {
        (Some(own), Some(stated))
            if own
                .iter()
                .zip(&stated)
                .any(|(a, b)| (a - b).abs() > 0.05 * a) =>
        {
            return Err(Trouble::request(format!(
                "calibration.acceleration_m/s2 is {stated:?}, but the result was measured at {} m/s²",
                three_digits(own).join(" to ")
            ))
            .with_hint("leave it out: the certificate states that of the result"));
        }
        (None, stated) => measured.acceleration = stated,
        _ => {}
    }
    Ok(measured)
}

/// The ends of a range to the place of the third significant digit of the larger.
fn three_digits(range: [f64; 2]) -> [String; 2] {
    let place = (2.0 - range[1].abs().log10().floor()).clamp(0.0, 12.0);
    range.map(|end| format!("{end:.0$}", place as usize))
}

/// Whether a text says something; the dots of a form do not.
pub fn says(text: &str) -> bool {
    text.chars().any(char::is_alphanumeric)
}

/// Refuses a result that contradicts itself, and a k or a probability that it does not have.
fn contradiction(job: &CertificateJob, result: &StoredResult) -> Result<()> {
    result.estimate()?;
    for q in super::results::stated(result) {
        let product = q.k.zip(q.u).map(|(k, u)| k * u);
        if let Some(product) = product.filter(|_| q.interval.is_none())
            && (q.expanded - product).abs() > 1e-6 * product
        {
            return Err(Trouble::data(format!(
                "the result states {} with U = {}, but k u is {product}",
                q.name, q.expanded
            ))
            .with_hint("take a copy of the result, or evaluate it again"));
        }
    }
    let Some(expected) = job.file.statement else {
        return Ok(());
    };
    for (key, value) in [
        ("coverage_factor", expected.coverage_factor),
        ("probability", expected.probability),
    ] {
        if value.is_some_and(|v| !v.is_finite()) {
            return Err(Trouble::request(format!("statement.{key} is no number")));
        }
    }
    for q in super::results::stated(result) {
        if let (Some(k), Some(wanted)) = (q.k, expected.coverage_factor)
            && (k - wanted).abs() > 0.005
        {
            return Err(Trouble::request(format!(
                "the certificate is to state k = {wanted}, but the result states {} with k = {k:.2}",
                q.name
            ))
            .with_hint("calibrate with that k (`-k`), or leave statement.coverage_factor out: words do not change a result"));
        }
        if let Some(wanted) = expected.probability
            && (q.probability - wanted).abs() > 5e-4
        {
            return Err(Trouble::request(format!(
                "the certificate is to state intervals of {wanted}, but the result states {} at {}",
                q.name, q.probability
            ))
            .with_hint("calibrate with that probability, or leave statement.probability out: words do not change a result"));
        }
    }
    Ok(())
}
