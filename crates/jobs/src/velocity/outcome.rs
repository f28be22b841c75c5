//! What the three questions to an axis found.

use super::AxisData;
use super::page::VelocityReport;
use crate::firmware::{Firmware, GainsOf, of_method};
use crate::outcome::{Outcome, section};
use crate::record::Record;
use crate::trouble::Result;
use proofmass_io::{Cell, StatedQuantity, Table};
use proofmass_motion::{
    CompareResult, EstimateResult, MotionRecord, ReadingSource, TuneResult, Tuned, Tuning,
    VelocityTrace,
};
use proofmass_report::Report;
use proofmass_uncertainty::{DegreesOfFreedom, Finding, Quantity};
use serde::{Deserialize, Serialize};

/// Probability of every stated interval.
const PROBABILITY: f64 = 0.95;

/// What the outcomes of an axis share.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Head {
    /// The recording, for the title.
    name: String,
    /// Time of the first sample, s.
    start: f64,
    sample_time: f64,
    pub(super) samples: usize,
    readings: usize,
    source: ReadingSource,
    /// Whether it is an angle: rad in place of m.
    #[serde(default)]
    pub(super) angular: bool,
    /// Whether there is no accelerometer.
    #[serde(default)]
    alone: bool,
    increment: Option<f64>,
    initial_velocity: Option<f64>,
    pub(super) quantities: Vec<StatedQuantity>,
    pub(super) findings: Vec<Finding>,
}

impl Head {
    pub(super) fn new(data: &AxisData<'_>, quantities: Vec<Quantity>, found: &[Finding]) -> Self {
        let mut findings: Vec<Finding> = data.findings.iter().chain(found).cloned().collect();
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        let record = data.record;
        let name = std::path::Path::new(data.name).file_name();
        Self {
            name: name.map_or(data.name.into(), |n| n.to_string_lossy().into_owned()),
            start: tidy(data.start),
            sample_time: record.sample_time,
            samples: record.reading.len(),
            readings: record.reading.iter().flatten().count(),
            source: record.source,
            angular: data.angular,
            alone: !record.accelerometer,
            increment: record.increment,
            initial_velocity: record.initial_velocity,
            quantities: quantities
                .into_iter()
                .map(|mut q| {
                    q.unit = super::page::unit_of(&q.unit, data.angular);
                    StatedQuantity::new(&q, PROBABILITY)
                })
                .collect(),
            findings,
        }
    }

    pub(super) fn page(&self, title: String, record: &Record) -> VelocityReport<'_> {
        VelocityReport {
            head: record.head(title, &self.findings),
            start: self.start,
            sample_time: self.sample_time,
            angular: self.angular,
            alone: self.alone,
            sensors: None,
        }
    }

    pub(super) fn title(&self, what: &str, record: &Record) -> String {
        record.title(&format!("{what} of"), &format!("{what}, {}", self.name))
    }

    /// A unit or heading of a length as it is of an angle, where it is one.
    pub(super) fn unit(&self, of_length: &str) -> String {
        super::page::unit_of(of_length, self.angular)
    }

    /// Time of a sample, s.
    fn time(&self, sample: usize) -> f64 {
        self.start + self.sample_time * sample as f64
    }

    pub(super) fn section(&self) -> Result<(&'static str, serde_json::Value)> {
        section(
            "record",
            &serde_json::json!({
                "samples": self.samples,
                "readings": self.readings,
                "sample_time_s": self.sample_time,
                "start_s": self.start,
                "source": self.source,
                "unit": self.unit("m"),
                "increment_m": self.increment,
                "initial_velocity_m_per_s": self.initial_velocity,
            }),
        )
    }
}

/// A start that is zero up to the rounding of the clock.
fn tidy(start: f64) -> f64 {
    if start.abs() < 1e-12 { 0.0 } else { start }
}

/// Rounds to a hundredth of an uncertainty, or to seven digits of the largest value: what is kept in a file.
fn rounded(values: &mut [f64], uncertainty: Option<f64>) {
    let largest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let grain = uncertainty
        .filter(|u| *u > 0.0)
        .map_or(1e-6 * largest, |u| 0.01 * u);
    if !(grain > 0.0 && grain.is_finite()) {
        return;
    }
    let decade = -grain.log10().floor();
    if !(-300.0..300.0).contains(&decade) {
        return;
    }
    let scale = 10f64.powi(decade as i32);
    for v in values {
        let short = (*v * scale).round() / scale;
        if short.is_finite() {
            *v = short;
        }
    }
}

fn rounded_trace(trace: &mut VelocityTrace) {
    let smallest = trace.standard_uncertainty.as_ref().map(|u| {
        let positive = u.iter().copied().filter(|u| *u > 0.0);
        positive.fold(f64::INFINITY, f64::min)
    });
    rounded(&mut trace.velocity, smallest.filter(|u| u.is_finite()));
    if let Some(u) = &mut trace.standard_uncertainty {
        rounded(u, smallest.filter(|u| u.is_finite()));
    }
}

pub(super) fn quantity(name: &str, unit: &str, value: f64, u: f64) -> Quantity {
    Quantity {
        name: name.to_owned(),
        unit: unit.to_owned(),
        value,
        standard_uncertainty: u,
        dof: DegreesOfFreedom::INFINITE,
    }
}

/// What a tuning determined of the sensors.
fn found(tuned: &Tuned) -> Vec<Quantity> {
    let mut list = Vec::new();
    if let Some((below, above)) = tuned.log_q_interval {
        let root = tuned.model.acceleration_noise.sqrt();
        // An interval of 95 % of ln q, as a standard uncertainty of its root.
        let u = root * 0.25 * (below + above) / 1.96;
        list.push(quantity("acceleration_noise", "m/s²", root, u));
    }
    for (name, unit, found) in [
        ("offset", "m/s²", tuned.offset),
        ("gain", "1", tuned.gain),
        ("latency", "s", tuned.latency),
    ] {
        if let Some(found) = found {
            list.push(quantity(name, unit, found.value, found.uncertainty));
        }
    }
    list
}

/// The velocity of an axis with its uncertainty, and what speaks against it.
///
/// Velocities are kept to a hundredth of their smallest uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VelocityEstimate {
    head: Head,
    reading: Vec<Option<f64>>,
    acceleration: Vec<f64>,
    result: EstimateResult,
}

impl VelocityEstimate {
    pub(super) fn new(data: &AxisData<'_>, mut result: EstimateResult) -> Self {
        let quantities = std::iter::once(fastest(&result)).collect::<Vec<_>>();
        rounded_trace(&mut result.trace);
        rounded_trace(&mut result.smoother);
        if let Some((value, u)) = &mut result.offset {
            rounded(value, None);
            rounded(u, None);
        }
        // Three decimals of a standard deviation.
        for z in result.innovations.iter_mut().flatten() {
            *z = (1e3 * *z).round() / 1e3;
        }
        let MotionRecord {
            reading,
            acceleration,
            increment,
            ..
        } = data.record;
        let mut known: Vec<f64> = reading.iter().flatten().copied().collect();
        rounded(&mut known, increment.map(|d| 0.1 * d));
        let mut known = known.into_iter();
        let reading = reading
            .iter()
            .map(|r| r.and_then(|_| known.next()))
            .collect();
        let mut acceleration = acceleration.clone();
        rounded(&mut acceleration, None);
        let mut all = quantities;
        all.extend(result.tuned.iter().flat_map(found));
        Self {
            head: Head::new(data, all, &result.findings),
            reading,
            acceleration,
            result,
        }
    }

    /// The estimate itself.
    pub fn result(&self) -> &EstimateResult {
        &self.result
    }

    /// Time of the first sample and the sample time, s.
    pub fn clock(&self) -> (f64, f64) {
        (self.head.start, self.head.sample_time)
    }
}

/// Largest speed, by the method or, where that has no uncertainty, by the smoother.
fn fastest(result: &EstimateResult) -> Quantity {
    let (v, u) = result.largest_speed();
    quantity("largest_speed", "m/s", v, u)
}

impl Outcome for VelocityEstimate {
    const KIND: &'static str = "velocity-estimate";
    const PRINCIPAL_TABLE: &'static str = "velocity.csv";

    fn title(&self, record: &Record) -> String {
        self.head.title("Velocity", record)
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.head.quantities.clone()
    }

    fn findings(&self) -> &[Finding] {
        &self.head.findings
    }

    fn model(&self) -> Option<String> {
        Some(self.result.trace.label.clone())
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![self.head.section()?])
    }

    /// One row per sample.
    fn tables(&self) -> Result<Vec<(String, Table)>> {
        let result = &self.result;
        let headings = [
            "time_s",
            "velocity_m/s",
            "standard_uncertainty_m/s",
            "smoothed_m/s",
            "smoothed_standard_uncertainty_m/s",
            match self.head.source {
                ReadingSource::Position => "position_m",
                ReadingSource::Speed => "speed_m/s",
            },
            "acceleration_m/s2",
            "slip",
        ];
        let mut table = Table::new(headings.map(|h| self.head.unit(h)));
        let at = |u: &Option<Vec<f64>>, k: usize| Cell::from(u.as_ref().map(|u| u[k]));
        for k in 0..self.reading.len() {
            let slips = result.slip.as_ref().is_some_and(|s| s.slips(k, 0));
            table.push([
                Cell::from(self.head.time(k)),
                Cell::from(result.trace.velocity[k]),
                at(&result.trace.standard_uncertainty, k),
                Cell::from(result.smoother.velocity[k]),
                at(&result.smoother.standard_uncertainty, k),
                Cell::from(self.reading[k]),
                Cell::from(self.acceleration[k]),
                Cell::from(usize::from(slips)),
            ])?;
        }
        Ok(vec![("velocity.csv".to_owned(), table)])
    }

    fn summary(&self, record: &Record) -> Report {
        self.head
            .page(self.title(record), record)
            .estimate_summary(&self.result)
    }

    fn report(&self, record: &Record) -> Report {
        let mut page = self.head.page(self.title(record), record);
        page.sensors = Some((self.head.source, &self.reading, &self.acceleration));
        page.estimate(&self.result)
    }
}

/// Errors of many methods side by side.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VelocityComparison {
    head: Head,
    result: CompareResult,
}

impl VelocityComparison {
    pub(super) fn new(data: &AxisData<'_>, mut result: CompareResult) -> Self {
        rounded(&mut result.reference, None);
        for row in &mut result.rows {
            rounded(&mut row.velocity, None);
        }
        Self {
            head: Head::new(data, Vec::new(), &result.findings),
            result,
        }
    }

    /// The comparison itself.
    pub fn result(&self) -> &CompareResult {
        &self.result
    }

    fn errors(&self) -> Result<Table> {
        let headings = [
            "rate_Hz",
            "method",
            "sensors",
            "rms_m/s",
            "max_m/s",
            "mean_m/s",
            "delay_s",
            "stated_delay_s",
            "noise_floor_m/s",
            "drift_m/s2",
        ];
        let mut table = Table::new(headings.map(|h| self.head.unit(h)));
        for row in &self.result.rows {
            let a = &row.agreement;
            table.push([
                Cell::from(row.rate),
                Cell::from(row.label.as_str()),
                Cell::from(row.family.name()),
                Cell::from(a.rms),
                Cell::from(a.max),
                Cell::from(a.bias),
                Cell::from(a.delay),
                Cell::from(row.stated_delay),
                Cell::from(a.noise_floor),
                Cell::from(a.drift),
            ])?;
        }
        Ok(table)
    }

    /// Every velocity at the highest rate, one column per method.
    fn velocities(&self) -> Result<Table> {
        let result = &self.result;
        let highest = result.rows.iter().fold(0.0f64, |m, r| m.max(r.rate));
        let rows: Vec<_> = result.rows.iter().filter(|r| r.rate == highest).collect();
        let stride = (1.0 / (highest * self.head.sample_time)).round().max(1.0) as usize;
        let mut names = vec!["time_s".to_owned(), self.head.unit("reference_m/s")];
        let unit = self.head.unit("m/s");
        names.extend(rows.iter().map(|r| format!("{} ({unit})", r.label)));
        let mut table = Table::new(names);
        for (k, reference) in result.reference.iter().step_by(stride).enumerate() {
            let velocities = rows.iter().map(|r| r.velocity[k]);
            let time = self.head.time(k * stride);
            table.push([time, *reference].into_iter().chain(velocities))?;
        }
        Ok(table)
    }
}

impl Outcome for VelocityComparison {
    const KIND: &'static str = "velocity-comparison";

    fn title(&self, record: &Record) -> String {
        self.head.title("Comparison of velocities", record)
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.head.quantities.clone()
    }

    fn findings(&self) -> &[Finding] {
        &self.head.findings
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![
            self.head.section()?,
            section("skip_s", &self.result.skip)?,
        ])
    }

    fn tables(&self) -> Result<Vec<(String, Table)>> {
        Ok(vec![
            ("errors.csv".to_owned(), self.errors()?),
            ("velocities.csv".to_owned(), self.velocities()?),
        ])
    }

    fn summary(&self, record: &Record) -> Report {
        self.head
            .page(self.title(record), record)
            .compare_summary(&self.result)
    }

    fn report(&self, record: &Record) -> Report {
        self.head
            .page(self.title(record), record)
            .compare(&self.result)
    }
}

/// Noise of both sensors and the gains of every fused filter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VelocityTuning {
    head: Head,
    options: Tuning,
    result: TuneResult,
}

impl VelocityTuning {
    pub(super) fn new(data: &AxisData<'_>, options: Tuning, result: TuneResult) -> Self {
        Self {
            head: Head::new(data, found(&result.tuned), &result.findings),
            options,
            result,
        }
    }

    /// Gains for firmware at the rate of the recording, with what is done to the accelerometer before.
    pub(crate) fn firmware(&self, gains: GainsOf) -> Result<Firmware> {
        let method = match gains {
            GainsOf::Kalman => &self.result.kalman.method,
            GainsOf::Observer => &self.result.observer.method,
            GainsOf::TwoChannel => &self.result.two_channel.method,
        };
        let tuned = &self.result.tuned;
        let mut notes = Vec::new();
        if let Some(offset) = tuned.offset {
            notes.push(format!(
                "Offset of the accelerometer at the start: {:e}(+-{:e}); subtract it before, unless the filter has it as a state.",
                offset.value, offset.uncertainty
            ));
        }
        if let Some(gain) = tuned.gain {
            notes.push(format!(
                "The accelerometer reads {:e} times the acceleration: divide by that before.",
                gain.value
            ));
        }
        if let Some(latency) = tuned.latency {
            notes.push(format!(
                "The accelerometer is {:e} s later than the readings: delay these by that.",
                latency.value
            ));
        }
        Ok(Firmware {
            block: of_method(method, self.head.source, self.head.sample_time)?,
            notes,
        })
    }

    /// The tuning itself.
    pub fn result(&self) -> &TuneResult {
        &self.result
    }
}

impl Outcome for VelocityTuning {
    const KIND: &'static str = "velocity-tuning";

    fn title(&self, record: &Record) -> String {
        self.head.title("Tuning", record)
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.head.quantities.clone()
    }

    fn findings(&self) -> &[Finding] {
        &self.head.findings
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![
            self.head.section()?,
            section("options", &self.options)?,
        ])
    }

    fn tables(&self) -> Result<Vec<(String, Table)>> {
        let q = self.head.unit("q_(m/s2)2");
        let mut table = Table::new([q, "log_likelihood_below_maximum".to_owned()]);
        for (q, value) in &self.result.tuned.profile {
            table.push([*q, *value])?;
        }
        Ok(vec![("likelihood.csv".to_owned(), table)])
    }

    fn summary(&self, record: &Record) -> Report {
        self.head
            .page(self.title(record), record)
            .tune_summary(&self.result)
    }

    fn report(&self, record: &Record) -> Report {
        self.head
            .page(self.title(record), record)
            .tune(&self.result)
    }
}
