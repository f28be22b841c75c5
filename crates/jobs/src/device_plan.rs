//! What to measure, and for how long, so that a device is decided by its data sheet.

mod needed;
mod noise;
mod other_tests;
mod page;
mod positions;

pub use noise::SensorNoise;

use crate::data_sheet::{DataSheet, Measurement, ReadLimit, read_all};
use crate::findings;
use crate::outcome::{Job, Outcome, section};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use needed::Needed;
use proofmass_core::Watch;
use proofmass_documents::StatedQuantity;
use proofmass_report::Report;
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

/// Which device is planned for, and what is known before it is measured.
///
/// ```
/// use proofmass_jobs::{Job, Unwatched, data_sheet, device_plan::DevicePlanJob};
/// let mut job = DevicePlanJob::default();
/// job.sheet = data_sheet::sheet("[[limit]]\nterm = \"N\"\nmost = 160\ntypical = 145\nunit = \"µg/√Hz\"\n")?;
/// job.given.rate = Some(100.0);
/// let outcome = job.evaluate(&(), &Unwatched)?;
/// assert!((10.0..60.0).contains(&outcome.limits()[0].duration.unwrap()));
/// # Ok::<(), proofmass_jobs::Trouble>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct DevicePlanJob {
    /// The data sheet.
    pub sheet: DataSheet,
    /// Noise of the sensor, where it was measured; else the typical values of the limits of N, B and K.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<SensorNoise>,
    /// What is known of bench and sensor.
    pub given: PlanConditions,
}

/// What is known of the bench and the sensor before the measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct PlanConditions {
    /// Sampling rate of the recordings, Hz
    #[cfg_attr(feature = "clap", arg(long, value_name = "HZ"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// Standard uncertainty of local gravity, m/s²
    #[cfg_attr(feature = "clap", arg(long, value_name = "M_PER_S2"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity_uncertainty: Option<f64>,
    /// Standard uncertainty of the reference accelerations, of a shaker or of levels, %
    #[cfg_attr(feature = "clap", arg(long, value_name = "PERCENT"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_uncertainty: Option<f64>,
    /// Lowest and highest temperature of the device, °C, where a limit does not say it
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "LOW,HIGH",
            value_delimiter = ',',
            num_args = 1,
            allow_hyphen_values = true
        )
    )]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature_range: Option<Vec<f64>>,
    /// Axes of the device: 3, or 1 that is turned through known angles
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = PlanConditions::default().axes))]
    pub axes: u8,
    /// Standard uncertainty of the angles of a fixture for one axis (lean of its axis of turning, sensitive axis off the plane), °
    #[cfg_attr(feature = "clap", arg(long, value_name = "DEG"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fixture_angle: Option<f64>,
    /// Largest acceleration of the levels for a non-linearity, m/s²
    #[cfg_attr(feature = "clap", arg(long, value_name = "M_PER_S2"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration: Option<f64>,
    /// Standard deviation of what varies from attitude to attitude beside the noise, m/s²
    #[cfg_attr(feature = "clap", arg(long, value_name = "M_PER_S2", default_value_t = PlanConditions::default().wander))]
    pub wander: f64,
    /// Tolerance-to-uncertainty ratio where a limit has no typical value
    #[cfg_attr(feature = "clap", arg(long, default_value_t = PlanConditions::default().ratio))]
    pub ratio: f64,
    /// Probability that a device with the typical value is decided
    #[cfg_attr(feature = "clap", arg(long, value_name = "P", default_value_t = PlanConditions::default().decided))]
    pub decided: f64,
    /// Soak at each temperature before it counts, minutes
    #[cfg_attr(feature = "clap", arg(long, value_name = "MIN", default_value_t = PlanConditions::default().soak))]
    pub soak: f64,
    /// Longest recording of noise, hours
    #[cfg_attr(feature = "clap", arg(long, value_name = "H", default_value_t = PlanConditions::default().longest))]
    pub longest: f64,
}

impl Default for PlanConditions {
    fn default() -> Self {
        Self {
            rate: None,
            gravity_uncertainty: None,
            reference_uncertainty: None,
            temperature_range: None,
            axes: 3,
            fixture_angle: None,
            acceleration: None,
            wander: 0.0,
            ratio: 4.0,
            decided: 0.9,
            soak: 15.0,
            longest: 168.0,
        }
    }
}

/// Probability of the intervals of all results.
const PROBABILITY: f64 = 0.95;

impl PlanConditions {
    fn check(&self) -> Result<()> {
        let given = |name: &str, value: Option<f64>, least: f64, most: f64, hint: &str| match value
        {
            Some(v) if !(v >= least && v <= most) => Err(Trouble::request(format!(
                "--{name} {v} is out of range: from {least} to {most}"
            ))
            .with_hint(hint.to_owned())),
            _ => Ok(()),
        };
        given(
            "rate",
            self.rate,
            1e-3,
            1e7,
            "a sampling rate in Hz, such as 100",
        )?;
        given(
            "gravity-uncertainty",
            self.gravity_uncertainty,
            0.0,
            0.1,
            "in m/s²: 0.0001 from a map, 0.03 where the place is not known",
        )?;
        given(
            "reference-uncertainty",
            self.reference_uncertainty,
            0.0,
            50.0,
            "in per cent, as the certificate of the reference has it for k = 1",
        )?;
        given(
            "acceleration",
            self.acceleration,
            1e-3,
            1e7,
            "in m/s²: the end of the range",
        )?;
        given(
            "fixture-angle",
            self.fixture_angle,
            0.0,
            20.0,
            "in degrees, from zero on",
        )?;
        if !matches!(self.axes, 1 | 3) {
            return Err(
                Trouble::request(format!("--axes {} is not possible", self.axes))
                    .with_hint("a device has one axis or three: --axes 1 or --axes 3"),
            );
        }
        given(
            "wander",
            Some(self.wander),
            0.0,
            10.0,
            "in m/s², from zero on",
        )?;
        given("ratio", Some(self.ratio), 1.0, 1e3, "from 1 on; 4 is usual")?;
        given(
            "decided",
            Some(self.decided),
            0.5,
            0.999,
            "from 0.5 to 0.999",
        )?;
        given("soak", Some(self.soak), 0.0, 1e4, "in minutes; 15 is usual")?;
        given("longest", Some(self.longest), 1e-3, 1e5, "in hours")?;
        match self.temperature_range.as_deref() {
            None => Ok(()),
            Some([low, high]) if low < high && low.is_finite() && high.is_finite() => Ok(()),
            Some(other) => Err(Trouble::request(format!(
                "--temperature-range {other:?} is no range of temperatures"
            ))
            .with_hint("two numbers in °C, the lower one first: --temperature-range=-20,60")),
        }
    }
}

impl Job for DevicePlanJob {
    type Data<'a> = ();
    type Outcome = DevicePlanOutcome;

    fn evaluate(&self, (): &(), watch: &dyn Watch) -> Result<DevicePlanOutcome> {
        self.sheet.check()?;
        self.given.check()?;
        let limits = read_all(&self.sheet.limit, "limit")?;
        let known = needed::Known::of(self, &limits)?;
        let needs: Vec<Needed> = limits
            .iter()
            .map(|limit| known.needed(limit))
            .collect::<Result<_>>()?;
        let shown_by = |limit: &ReadLimit| limit.characteristic.shown_by(limit.frequency.is_some());
        let of_positions =
            |(limit, _): &(&ReadLimit, &Needed)| shown_by(limit) == Measurement::Positions;
        let at_rest: Vec<(&ReadLimit, &Needed)> =
            limits.iter().zip(&needs).filter(of_positions).collect();
        // One choice of attitudes for all limits that they show.
        let mut at_rest = match at_rest[..] {
            [] => Vec::new(),
            _ => known.positions(&at_rest, watch)?,
        }
        .into_iter();
        let mut planned = Vec::with_capacity(limits.len());
        for (k, (limit, needed)) in limits.iter().zip(needs).enumerate() {
            watch.step("limits", k as u64, limits.len() as u64)?;
            let shown_by = shown_by(limit);
            let way = match shown_by {
                Measurement::Noise => known.recording(limit, &needed)?,
                Measurement::Positions => at_rest.next().unwrap_or_else(Way::open),
                _ => known.other(limit, &needed, shown_by)?,
            };
            planned.push(PlannedLimit::new(k, shown_by, needed, way));
        }
        watch.step("limits", limits.len() as u64, limits.len() as u64)?;
        let mut found = Vec::new();
        let of = |k: &PlannedLimit| {
            let limit = &limits[k.limit];
            format!("{}, {}", limit.characteristic.name(), limit.words())
        };
        let told = |those: Vec<&PlannedLimit>| {
            let words: Vec<String> = those.into_iter().map(of).collect();
            (words.len(), words.join("; "))
        };
        let (count, list) = told(planned.iter().filter(|p| !p.reached).collect());
        if count > 0 {
            let why: Vec<&str> = planned
                .iter()
                .filter(|p| !p.reached)
                .map(|p| p.why.as_str())
                .collect();
            found.push(findings::plan_out_of_reach(count, &list, &why.join("; ")));
        }
        let (count, list) = told(
            planned
                .iter()
                .filter(|p| p.needed.typical.is_none())
                .collect(),
        );
        if count > 0 {
            found.push(findings::typical_not_stated(count, self.given.ratio, &list));
        }
        if known.slow_noise_unknown() {
            found.push(findings::slow_noise_not_stated());
        }
        let (noise, measurements) = (known.noise, Measured::of(&planned));
        Ok(DevicePlanOutcome {
            sheet: self.sheet.clone(),
            given: self.given.clone(),
            limits,
            planned,
            measurements,
            noise,
            findings: found,
        })
    }
}

/// How a limit is measured: what, for how long, whether that suffices.
#[derive(Clone, Debug, PartialEq)]
struct Way {
    what: String,
    duration: Option<f64>,
    positions: Option<(usize, f64)>,
    reached: bool,
    why: String,
}

impl Way {
    fn open() -> Self {
        Self::of(String::new(), None)
    }

    fn of(what: String, duration: Option<f64>) -> Self {
        Self {
            what,
            duration,
            positions: None,
            reached: true,
            why: String::new(),
        }
    }

    fn out_of_reach(what: String, why: impl Into<String>) -> Self {
        Self {
            what,
            duration: None,
            positions: None,
            reached: false,
            why: why.into(),
        }
    }
}

/// What one limit needs.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PlannedLimit {
    /// Which limit of the sheet, from zero.
    pub limit: usize,
    /// The command that shows it.
    pub command: &'static str,
    #[serde(skip)]
    shown_by: Measurement,
    #[serde(flatten)]
    needed: Needed,
    /// What to measure.
    pub what: String,
    /// Time that it takes, s, where that is known.
    #[serde(rename = "duration_s", skip_serializing_if = "Option::is_none")]
    pub duration: Option<f64>,
    /// Number of attitudes, and the rest in each, s.
    #[serde(
        rename = "attitudes_and_rest_s",
        skip_serializing_if = "Option::is_none"
    )]
    pub positions: Option<(usize, f64)>,
    /// Whether a device with the typical value will be decided.
    pub reached: bool,
    /// Why it will not.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub why: String,
}

impl PlannedLimit {
    fn new(limit: usize, shown_by: Measurement, needed: Needed, way: Way) -> Self {
        Self {
            limit,
            command: shown_by.command(),
            shown_by,
            needed,
            what: way.what,
            duration: way.duration,
            positions: way.positions,
            reached: way.reached,
            why: way.why,
        }
    }

    /// Largest expanded uncertainty with which it is decided, in the unit of the limit.
    pub fn expanded(&self) -> f64 {
        self.needed.expanded
    }
}

/// One measurement, for all limits that it shows.
#[derive(Clone, Debug, PartialEq)]
struct Measured {
    shown_by: Measurement,
    what: String,
    duration: Option<f64>,
    limits: usize,
}

impl Measured {
    /// The longest of each measurement that suffices for something.
    fn of(planned: &[PlannedLimit]) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for p in planned.iter().filter(|p| p.reached) {
            match all
                .iter_mut()
                .find(|m| m.shown_by == p.shown_by && p.shown_by.is_one_for_all())
            {
                Some(m) => {
                    m.limits += 1;
                    if p.duration > m.duration {
                        (m.what, m.duration) = (p.what.clone(), p.duration);
                    }
                }
                None => all.push(Self {
                    shown_by: p.shown_by,
                    what: p.what.clone(),
                    duration: p.duration,
                    limits: 1,
                }),
            }
        }
        all
    }
}

/// The answer: what every limit needs, and the measurements for all of them.
#[derive(Clone, Debug, PartialEq)]
pub struct DevicePlanOutcome {
    sheet: DataSheet,
    given: PlanConditions,
    limits: Vec<ReadLimit>,
    planned: Vec<PlannedLimit>,
    measurements: Vec<Measured>,
    noise: Option<SensorNoise>,
    findings: Vec<Finding>,
}

impl DevicePlanOutcome {
    /// The limits, in the order of the sheet.
    pub fn limits(&self) -> &[PlannedLimit] {
        &self.planned
    }
}

impl Outcome for DevicePlanOutcome {
    const KIND: &'static str = "device-plan";
    const PRINCIPAL_TABLE: &'static str = "planned.csv";

    fn title(&self, record: &Record) -> String {
        record.title_of(
            &self.sheet.device,
            "Plan of the measurements for the data sheet of",
            "Plan of the measurements for a data sheet",
        )
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        Vec::new()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![
            section("sheet", &self.sheet)?,
            section("given", &self.given)?,
            section("planned", &self.planned)?,
        ])
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_measurements_are_told_once_for_all_their_limits() {
        let planned = |shown_by, duration| {
            let way = Way::of("so".to_owned(), duration);
            PlannedLimit::new(0, shown_by, Needed::nothing(), way)
        };
        let all = [
            planned(Measurement::Noise, Some(10.0)),
            planned(Measurement::Noise, Some(30.0)),
            planned(Measurement::Shaker, None),
            planned(Measurement::Shaker, None),
        ];
        let measured = Measured::of(&all);
        assert_eq!(measured.len(), 3);
        assert_eq!((measured[0].limits, measured[0].duration), (2, Some(30.0)));
    }
}
