//! What the three questions to an axis found.

use super::{AxisData, page};
use crate::firmware::{Firmware, GainsOf, of_method, with_low_corner};
use crate::outcome::{Outcome, section};
use crate::record::Record;
use crate::stored_result::read_section;
use crate::trouble::{Result, Trouble};
use proofmass_documents::StatedQuantity;
use proofmass_motion::{
    CompareResult, EstimateResult, LowCorner, Method, MotionRecord, ReadingSource, TuneResult,
    Tuned, TunedValue, Tuning, VelocityTrace,
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
    pub(super) start: f64,
    /// First and last time of what was recorded, s, where gaps leave a part of it.
    #[serde(default)]
    recorded: Option<[f64; 2]>,
    /// First and last sample of what is left out of the velocity.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    left_out: Vec<[usize; 2]>,
    pub(super) sample_time: f64,
    pub(super) samples: usize,
    readings: usize,
    pub(super) source: ReadingSource,
    /// Whether it is an angle: rad in place of m.
    #[serde(default)]
    pub(super) angular: bool,
    /// Whether there is no accelerometer.
    #[serde(default)]
    pub(super) alone: bool,
    increment: Option<f64>,
    /// What was stated of the encoder, in words.
    #[serde(default)]
    pub(super) encoder: Option<String>,
    initial_velocity: Option<f64>,
    /// Velocity at the first sample by the record: stated, or that of the first readings, with its standard uncertainty.
    #[serde(default)]
    start_velocity: Option<(f64, f64)>,
    /// Latency of the accelerometer that was stated, s.
    #[serde(default)]
    stated_latency: f64,
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
            recorded: data.recorded,
            left_out: Vec::new(),
            sample_time: record.sample_time,
            samples: record.reading.len(),
            readings: record.reading.iter().flatten().count(),
            source: record.source,
            angular: data.angular,
            alone: !record.accelerometer,
            increment: record.increment,
            encoder: data.encoder.map(str::to_owned),
            initial_velocity: record.initial_velocity,
            start_velocity: Some(record.start_velocity()),
            stated_latency: data.latency,
            quantities: quantities
                .into_iter()
                .map(|mut q| {
                    q.unit = page::unit_of(&q.unit, data.angular);
                    StatedQuantity::new(&q, PROBABILITY)
                })
                .collect(),
            findings,
        }
    }

    pub(super) fn title(&self, what: &str, record: &Record) -> String {
        record.title(&format!("{what} of"), &format!("{what}, {}", self.name))
    }

    /// A unit or heading of a length as it is of an angle, where it is one.
    pub(super) fn unit(&self, of_length: &str) -> String {
        page::unit_of(of_length, self.angular)
    }

    /// Time of a sample, s.
    pub(super) fn time(&self, sample: usize) -> f64 {
        self.start + self.sample_time * sample as f64
    }

    /// From when to when samples were used, where gaps leave a part of the recording, and what is left out: sentences behind another.
    pub(super) fn part(&self) -> Option<String> {
        let used = self.recorded.map(|[from, to]| {
            let last = self.time(self.samples.saturating_sub(1));
            format!(
                " Samples are missing: only {:.3} s to {last:.3} s of {from:.3} s to {to:.3} s is used.",
                self.start
            )
        });
        /// Gaps that are named.
        const NAMED: usize = 3;
        let gaps = self.left_out.iter().take(NAMED).map(|[first, last]| {
            let (from, to) = (self.time(*first), self.time(*last));
            format!("{from:.3} s to {to:.3} s")
        });
        let gaps: Vec<String> = gaps.collect();
        let more = match self.left_out.len().saturating_sub(NAMED) {
            0 => String::new(),
            n => format!(" and {n} more"),
        };
        let out = (!gaps.is_empty()).then(|| {
            let gaps = gaps.join(", ");
            format!(" Samples are missing: {gaps}{more} is left out.")
        });
        (used.is_some() || out.is_some()).then(|| [used, out].into_iter().flatten().collect())
    }

    pub(super) fn section(&self) -> Result<(&'static str, serde_json::Value)> {
        let mut told = serde_json::json!({
            "samples": self.samples,
            "readings": self.readings,
            "sample_time_s": self.sample_time,
            "start_s": self.start,
            "recorded_s": self.recorded,
            "source": self.source,
            "unit": self.unit("m"),
            "increment_m": self.increment,
            "encoder": self.encoder,
            "initial_velocity_m_per_s": self.initial_velocity,
            "start_velocity_m_per_s": self.start_velocity.map(|v| v.0),
            "start_velocity_standard_uncertainty_m_per_s": self.start_velocity.map(|v| v.1),
        });
        if !self.left_out.is_empty() {
            let times = self.left_out.iter().map(|out| out.map(|k| self.time(k)));
            told["left_out_s"] = times.collect::<Vec<_>>().into();
        }
        section("record", &told)
    }
}

/// What was done to the accelerometer before the filters: it was divided by its gain and shifted back by its latency.
#[derive(Clone, Copy, Debug, Serialize)]
struct Applied {
    gain: f64,
    /// All of it, s.
    latency_s: f64,
    /// What was stated of it, s.
    stated_latency_s: f64,
    /// Corner of which the slow accelerations were given back before.
    #[serde(skip_serializing_if = "Option::is_none")]
    low_corner: Option<LowCorner>,
}

impl Applied {
    fn of(head: &Head, tuned: Option<&Tuned>, low_corner: Option<LowCorner>) -> Self {
        let found = |value: Option<TunedValue>, other| value.map_or(other, |v| v.value);
        Self {
            gain: tuned.map_or(1.0, |t| found(t.gain, 1.0)),
            latency_s: head.stated_latency + tuned.map_or(0.0, |t| found(t.latency, 0.0)),
            stated_latency_s: head.stated_latency,
            low_corner,
        }
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
#[derive(Clone, Debug, PartialEq)]
pub struct VelocityEstimate {
    pub(super) head: Head,
    pub(super) reading: Vec<Option<f64>>,
    pub(super) acceleration: Vec<f64>,
    pub(super) result: EstimateResult,
    /// Whether a method was asked for, whose speed is stated then.
    pub(super) asked: bool,
}

impl VelocityEstimate {
    pub(super) fn new(data: &AxisData<'_>, mut result: EstimateResult, asked: bool) -> Self {
        let largest = match asked {
            true => result.speed_by_method(PROBABILITY),
            false => result.largest_speed(PROBABILITY),
        };
        let (v, u) = (largest.value, largest.standard_uncertainty);
        let quantities = vec![quantity("largest_speed", "m/s", v, u)];
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
        let corner = result.low_corner.iter();
        all.extend(corner.map(|c| quantity("low_corner", "Hz", c.frequency, c.uncertainty)));
        let mut head = Head::new(data, all, &result.findings);
        let out = result.left_out.iter().map(|r| [r.start, r.end - 1]);
        head.left_out = out.collect();
        if let Some(stated) = head.quantities.first_mut().filter(|_| u > 0.0) {
            let [low, high] = largest.interval;
            (stated.k, stated.nu_eff) = (None, None);
            stated.interval = Some([low, high]);
            stated.expanded = (high - v).max(v - low);
        }
        Self {
            head,
            reading,
            acceleration,
            result,
            asked,
        }
    }

    /// By what the largest speed is stated, in words.
    pub(super) fn stated_by(&self) -> String {
        let at = self.head.time(self.result.fastest());
        match self.asked {
            true => format!("the method asked for, at {at:.3} s, where the smoother is fastest"),
            false => format!("the smoother, at {at:.3} s"),
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

/// Largest speed, by the smoother.
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
        Ok(vec![
            self.head.section()?,
            section("pairing", &self.result.pairing)?,
            section(
                "applied",
                &Applied::of(
                    &self.head,
                    self.result.tuned.as_ref(),
                    self.result.low_corner,
                ),
            )?,
            section("agreement", &self.result.agreement)?,
            section("largest_speed_by", &self.stated_by())?,
        ])
    }

    fn page(&self, page: Report) -> Report {
        page::estimate(page, self)
    }
}

/// Errors of many methods side by side.
#[derive(Clone, Debug, PartialEq)]
pub struct VelocityComparison {
    pub(super) head: Head,
    pub(super) result: CompareResult,
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
            section("reference_is_truth", &self.result.reference_is_truth)?,
            section("beside_reference", &self.result.beside_reference)?,
        ])
    }

    fn page(&self, page: Report) -> Report {
        page::compare(page, self)
    }
}

/// Noise of both sensors and the gains of every fused filter.
#[derive(Clone, Debug, PartialEq)]
pub struct VelocityTuning {
    pub(super) head: Head,
    options: Tuning,
    pub(super) result: TuneResult,
}

impl VelocityTuning {
    pub(super) fn new(data: &AxisData<'_>, options: Tuning, result: TuneResult) -> Self {
        Self {
            head: Head::new(data, found(&result.tuned), &result.findings),
            options,
            result,
        }
    }

    /// The tuning itself.
    pub fn result(&self) -> &TuneResult {
        &self.result
    }
}

/// What firmware needs of a tuning.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct TunedGains {
    source: ReadingSource,
    sample_time: f64,
    kalman: Method,
    observer: Method,
    two_channel: Method,
    offset: Option<TunedValue>,
    gain: Option<TunedValue>,
    latency: Option<TunedValue>,
    /// Latency that was stated, s: what was found is beside it.
    #[serde(default)]
    stated_latency: f64,
    /// Corner of which the slow accelerations were given back before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    low_corner: Option<LowCorner>,
}

impl TunedGains {
    /// Section of result.json.
    pub(crate) const SECTION: &'static str = "gains";

    fn of(head: &Head, result: &TuneResult) -> Self {
        Self {
            source: head.source,
            sample_time: head.sample_time,
            kalman: result.kalman.method,
            observer: result.observer.method,
            two_channel: result.two_channel.method,
            offset: result.tuned.offset,
            gain: result.tuned.gain,
            latency: result.tuned.latency,
            stated_latency: head.stated_latency,
            low_corner: result.low_corner,
        }
    }

    /// The gains from a result.json.
    ///
    /// # Errors
    /// Another kind of result; a field that no tuning writes.
    pub(crate) fn read(bytes: &[u8]) -> Result<Self> {
        let (tuned, _) = read_section::<Self>(bytes, VelocityTuning::KIND, Self::SECTION)?;
        tuned.check()?;
        Ok(tuned)
    }

    /// Refuses what no tuning writes, by the field.
    fn check(&self) -> Result<()> {
        let refuse = |field: &str, what: String| {
            Err(Trouble::data(format!(
                "the field {}.{field} of the tuning is {what}",
                Self::SECTION
            ))
            .with_hint("write the result.json anew with `proofmass velocity tune`"))
        };
        let positive = |x: f64| x.is_finite() && x > 0.0;
        if !positive(self.sample_time) {
            return refuse("sample_time", format!("{}, no time", self.sample_time));
        }
        for (field, value, fits) in [
            ("offset", self.offset, f64::is_finite as fn(f64) -> bool),
            ("gain", self.gain, |g| g.is_finite() && g != 0.0),
            ("latency", self.latency, f64::is_finite),
        ] {
            let Some(TunedValue {
                value, uncertainty, ..
            }) = value
            else {
                continue;
            };
            if !(fits(value) && uncertainty.is_finite() && uncertainty >= 0.0) {
                return refuse(field, format!("{value} with u = {uncertainty}"));
            }
        }
        if !self.stated_latency.is_finite() {
            return refuse("stated_latency", format!("{} s", self.stated_latency));
        }
        if let Some(corner) = &self.low_corner {
            let LowCorner {
                frequency,
                uncertainty,
                order,
                ..
            } = *corner;
            let highest = LowCorner::highest(self.sample_time);
            if !(1..=2).contains(&order) {
                return refuse("low_corner.order", format!("{order}, not 1 or 2"));
            }
            if !(positive(frequency) && frequency <= highest) {
                return refuse(
                    "low_corner.frequency",
                    format!(
                        "{frequency} Hz, not above zero and up to {highest} Hz, a twentieth of the sampling rate"
                    ),
                );
            }
            if LowCorner::new(frequency, uncertainty, order).is_err() {
                return refuse(
                    "low_corner.uncertainty",
                    format!("{uncertainty} Hz, not from zero to half the frequency"),
                );
            }
        }
        let known = |gains: &[f64]| gains.iter().all(|g| positive(*g));
        let fits = [
            (
                "kalman",
                match &self.kalman {
                    Method::Kalman { model } | Method::SteadyKalman { model } => {
                        known(&[model.acceleration_noise, model.reading_noise])
                    }
                    _ => false,
                },
            ),
            (
                "observer",
                matches!(self.observer, Method::Observer { k_x, k_v } if known(&[k_x, k_v])),
            ),
            (
                "two_channel",
                matches!(self.two_channel, Method::TwoChannel { k1, k2 } if k1.is_finite() && k1 >= 0.0 && known(&[k2])),
            ),
        ];
        match fits.iter().find(|(_, fits)| !fits) {
            Some((field, _)) => refuse(field, "no such filter with gains above zero".to_owned()),
            None => Ok(()),
        }
    }

    /// Gains for firmware at the rate of the recording, with what is done to the accelerometer before.
    pub(crate) fn firmware(&self, gains: GainsOf) -> Result<Firmware> {
        let method = match gains {
            GainsOf::Kalman => &self.kalman,
            GainsOf::Observer => &self.observer,
            GainsOf::TwoChannel => &self.two_channel,
        };
        let tuned = self;
        let mut notes = Vec::new();
        // Of the steady Kalman filter the corner is a state.
        let own = match (gains, method, &tuned.low_corner) {
            (
                GainsOf::Kalman,
                Method::Kalman { model } | Method::SteadyKalman { model },
                Some(corner),
            ) => Some(with_low_corner(
                model,
                self.source,
                corner,
                self.sample_time,
            )?),
            _ => None,
        };
        if let Some(corner) = tuned.low_corner.filter(|_| own.is_none()) {
            let times = if corner.order == 1 { "" } else { ", twice" };
            notes.push(format!(
                "The gains are for an acceleration whose slow part was given back: a = y + {:e} 1/s times the integral of y{times}; do that before.",
                std::f64::consts::TAU * corner.frequency
            ));
        }
        if let Some(gain) = tuned.gain {
            notes.push(format!(
                "The accelerometer reads {:e} times the acceleration: divide by that before.",
                gain.value
            ));
        }
        let block = match own {
            Some(block) => block,
            None => {
                let offset = tuned.offset.map_or(0.0, |o| o.value);
                if let Some(TunedValue { uncertainty, .. }) = tuned.offset {
                    let todo = match gains {
                        GainsOf::Kalman => {
                            "the filter begins with it as its third state, and nothing is to be subtracted."
                        }
                        _ => {
                            "the filter does not know it: subtract it from the acceleration before."
                        }
                    };
                    notes.push(format!(
                        "Offset of the accelerometer at the start: {offset:e}(+-{uncertainty:e}); {todo}"
                    ));
                }
                of_method(method, self.source, offset, self.sample_time)?
            }
        };
        let latency = tuned.stated_latency + tuned.latency.map_or(0.0, |t| t.value);
        if latency > 0.0 {
            notes.push(format!(
                "The accelerometer is {latency:e} s later than the readings: delay these by that."
            ));
        } else if latency < 0.0 {
            notes.push(format!(
                "The accelerometer is {:e} s earlier than the readings: delay it by that.",
                -latency
            ));
        }
        Ok(Firmware { block, notes })
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
            section("model", &self.result.tuned.model)?,
            section(
                "applied",
                &Applied::of(&self.head, Some(&self.result.tuned), self.result.low_corner),
            )?,
            section(
                TunedGains::SECTION,
                &TunedGains::of(&self.head, &self.result),
            )?,
        ])
    }

    fn page(&self, page: Report) -> Report {
        page::tune(page, self)
    }
}
