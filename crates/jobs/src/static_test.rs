//! Static tests: inclination, sensitivity, zero-g, orthogonality, linearity, centrifuge, stability over calibrations.

mod calibration;
mod files;
mod page;
mod single_axis;

pub use files::{ReadingColumns, StaticTestFiles};
pub use single_axis::SingleAxisReadings;

use crate::findings;
use crate::outcome::{Job, Outcome, section};
use crate::record::{Record, gravity_of};
use crate::stored_result::read_section;
use crate::trouble::{Result, Trouble};
use proofmass_core::{Error, Watch};
use proofmass_documents::{AnyCalibration, CalibrationFile, ResultDocument, StatedQuantity};
use proofmass_io::{Input, LARGEST_DOCUMENT, ReadGravity, Source, Unit};
use proofmass_report::Report;
use proofmass_static::static_test::{
    Centrifuge, DatedEstimate, Linearity, MountedTurn, Mounting, Orthogonality, Sensitivity,
    Stability, StabilityFit, StaticFit, Tilt, ZeroG,
};
use proofmass_uncertainty::{Estimate, Finding};
use serde::{Deserialize, Serialize};

/// Which test, with its settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum StaticTest {
    /// One axis through known angles.
    Tilt(Tilt),
    /// One axis up and down.
    Sensitivity(Sensitivity),
    /// Three axes at rest on a level surface.
    ZeroG(ZeroG),
    /// Angles between the sensitive axes of a calibration.
    Orthogonality(Orthogonality),
    /// One axis at known accelerations.
    Linearity(Linearity),
    /// One axis on a rotating arm.
    Centrifuge(Centrifuge),
    /// Calibrations over time.
    Stability(Stability),
    /// Three axes on a machine, at rest and in straight accelerations.
    Mounting(Mounting),
}

impl StaticTest {
    /// As in a command and a title.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Tilt(_) => "tilt",
            Self::Sensitivity(_) => "sensitivity",
            Self::ZeroG(_) => "zero-g",
            Self::Orthogonality(_) => "orthogonality",
            Self::Linearity(_) => "linearity",
            Self::Centrifuge(_) => "centrifuge",
            Self::Stability(_) => "stability",
            Self::Mounting(_) => "mounting",
        }
    }

    /// Usual unit of what a test with readings sets: angles, positions, accelerations, speeds.
    pub fn input_unit(&self) -> Option<Unit> {
        match self {
            Self::Tilt(_) => Some(Unit::Degree),
            Self::Sensitivity(_) => Some(Unit::One),
            Self::Linearity(_) => Some(Unit::MetrePerSecondSquared),
            Self::Centrifuge(_) => Some(Unit::TurnPerMinute),
            Self::ZeroG(_) | Self::Orthogonality(_) | Self::Stability(_) | Self::Mounting(_) => {
                None
            }
        }
    }

    fn needs(&self) -> Trouble {
        let needed = match self {
            Self::ZeroG(_) | Self::Mounting(_) => "a recording of three axes",
            Self::Orthogonality(_) => "a calibration",
            Self::Stability(_) => "results of calibrations",
            _ => "readings of one axis",
        };
        Trouble::request(format!("the {} test needs {needed}", self.name()))
    }
}

/// A static test of a device.
///
/// ```
/// use proofmass_static::static_test::Tilt;
/// use proofmass_core::Gravity;
/// use proofmass_jobs::static_test::{StaticTest, StaticTestData, StaticTestInput, StaticTestJob};
/// use proofmass_jobs::{Job, Outcome, Unwatched};
///
/// // 0.1 V/(m/s²) and a bias of 0.2 V, turned through a circle.
/// let angles: Vec<f64> = (0..12).map(|k| f64::from(30 * k).to_radians()).collect();
/// let outputs: Vec<f64> = angles.iter().map(|t| 0.2 + 0.980665 * t.cos() + 1e-4 * (7.0 * t).sin()).collect();
/// let test = StaticTest::Tilt(Tilt::new(Gravity::given(9.80665, 1e-5)?));
/// let input = StaticTestInput::Readings { input: &angles, output: &outputs, temperature: None, uncertainty: None, unit: "V" };
/// let data = StaticTestData { input, findings: &[], name: "tilt" };
/// let outcome = StaticTestJob::new(test).evaluate(&data, &Unwatched)?;
/// let quantities = outcome.quantities();
/// let sensitivity = quantities.iter().find(|q| q.name == "sensitivity").unwrap();
/// assert!((sensitivity.value - 0.1).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct StaticTestJob {
    /// The test.
    pub test: StaticTest,
    /// Coverage probability of the intervals.
    pub probability: f64,
    /// Whether nobody stated the local gravity of the test: standard gravity stands for it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub standard_gravity: bool,
    /// Latitude in degrees and height in metres, where the gravity is the normal one of a place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<[f64; 2]>,
}

impl StaticTestJob {
    /// With intervals of 95 %.
    pub fn new(test: StaticTest) -> Self {
        Self {
            test,
            probability: 0.95,
            standard_gravity: false,
            place: None,
        }
    }
}

/// What a test is made of.
#[derive(Clone, Copy, Debug)]
pub enum StaticTestInput<'a> {
    /// Readings of one axis: inputs (angles in rad, positions ±1, accelerations in m/s², speeds in rad/s), outputs in any
    /// unit, temperatures in °C where the model has them.
    Readings {
        /// Inputs.
        input: &'a [f64],
        /// Outputs.
        output: &'a [f64],
        /// Temperatures, °C.
        temperature: Option<&'a [f64]>,
        /// Standard uncertainties of the outputs, which weigh the readings; only their ratios count.
        uncertainty: Option<&'a [f64]>,
        /// Unit of the outputs as printed.
        unit: &'a str,
    },
    /// Outputs x, y, z of a resting sensor, m/s².
    Recording([&'a [f64]; 3]),
    /// A calibration.
    Calibration(&'a CalibrationFile),
    /// Results of calibrations with their days.
    History(&'a [DatedEstimate]),
}

/// The data of a static test.
#[derive(Clone, Debug)]
pub struct StaticTestData<'a> {
    /// What the test is made of.
    pub input: StaticTestInput<'a>,
    /// What reading the data found.
    pub findings: &'a [Finding],
    /// What it is called in messages.
    pub name: &'a str,
}

impl Job for StaticTestJob {
    type Data<'a> = StaticTestData<'a>;
    type Outcome = StaticTestOutcome;

    fn evaluate(&self, data: &StaticTestData<'_>, watch: &dyn Watch) -> Result<StaticTestOutcome> {
        watch.step("fit", 0, 1)?;
        if !(self.probability > 0.0 && self.probability < 1.0) {
            return Err(Trouble::request(format!(
                "a probability of {} lies not between 0 and 1",
                self.probability
            )));
        }
        let found = self.found(data)?;
        let mut findings = data.findings.to_vec();
        let quantities = match &found {
            StaticTestFit::Test(fit) | StaticTestFit::Mounting(fit, _) => {
                findings.extend(fit.findings.iter().cloned());
                fit.estimate.quantities()
            }
            StaticTestFit::History(fit) => {
                findings.extend(fit.findings.iter().cloned());
                fit.drifts.iter().map(|d| d.drift.clone()).collect()
            }
        };
        let calibration = match &found {
            StaticTestFit::Test(fit) => {
                calibration::calibration(&self.test, fit, &data.input, self.probability)
                    .unwrap_or_else(|trouble| {
                        findings.push(findings::calibration_not_made(&trouble.to_string()));
                        None
                    })
            }
            StaticTestFit::History(_) | StaticTestFit::Mounting(..) => None,
        };
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        watch.step("fit", 1, 1)?;
        Ok(StaticTestOutcome {
            calibration,
            test: self.test.clone(),
            standard_gravity: self.standard_gravity,
            place: self.place,
            probability: self.probability,
            quantities: StatedQuantity::list(&quantities, self.probability),
            findings,
            found,
        })
    }
}

impl StaticTestJob {
    fn found(&self, data: &StaticTestData<'_>) -> Result<StaticTestFit> {
        use StaticTestInput::{Calibration, History, Readings, Recording};
        let fit = match (&self.test, data.input) {
            (StaticTest::ZeroG(t), Recording(outputs)) => t.fit(outputs),
            (StaticTest::Orthogonality(t), Calibration(file)) => {
                let sensor = file
                    .sensor()
                    .map_err(|e| Trouble::from(e).detail(data.name))?;
                t.fit(&sensor.k().0, &file.estimate)
            }
            (StaticTest::Mounting(t), Recording(outputs)) => {
                let (fit, turn) = t.fit(outputs).map_err(|e| {
                    Trouble::from(e).detail(data.name).with_hint(
                        "a rest of a hundred samples and more, and accelerations of 0.1 m/s² and more on a straight line, are needed",
                    )
                })?;
                return Ok(StaticTestFit::Mounting(Box::new(fit), turn));
            }
            (StaticTest::Stability(t), History(history)) => {
                known_tolerances(t, history)?;
                let fit = t.fit(history).map_err(|e| no_drift(e).detail(data.name))?;
                return Ok(StaticTestFit::History(fit));
            }
            (
                test,
                Readings {
                    input,
                    output,
                    temperature,
                    uncertainty: u,
                    unit,
                },
            ) => match test {
                StaticTest::Tilt(t) => t.fit_weighed(input, output, u, unit),
                StaticTest::Sensitivity(t) => t.fit_weighed(input, output, u, unit),
                StaticTest::Centrifuge(t) => t.fit_weighed(input, output, u, unit),
                StaticTest::Linearity(t) => t.fit_weighed(input, output, temperature, u, unit),
                other => return Err(other.needs()),
            },
            (test, _) => return Err(test.needs()),
        };
        Ok(StaticTestFit::Test(Box::new(
            fit.map_err(|e| Trouble::from(e).detail(data.name))?,
        )))
    }
}

/// Why calibrations tell no drift.
fn no_drift(error: Error) -> Trouble {
    let hint = "give the result.json of calibrations of three days and more; each says its day";
    match error {
        Error::Constant { .. } => {
            Trouble::data("all calibrations are of one day, and a drift takes time").with_hint(hint)
        }
        Error::TooFew { .. } => Trouble::from(error).with_hint(hint),
        error => Trouble::from(error),
    }
}

/// A tolerance of a quantity that no calibration has would never be exceeded.
fn known_tolerances(test: &Stability, history: &[DatedEstimate]) -> Result<()> {
    let Some(first) = history.first() else {
        return Ok(());
    };
    let mut names = test.tolerances.iter().map(|t| &t.0);
    match names.find(|n| first.estimate.index_of(n).is_none()) {
        Some(name) => Err(Trouble::request(format!(
            "the calibrations have no quantity {name:?}"
        ))),
        None => Ok(()),
    }
}

/// The quantities of a result.json with the day of its evaluation.
///
/// # Errors
/// Another file, a result without date or without a joint estimate.
pub fn dated(bytes: &[u8], name: &str) -> Result<DatedEstimate> {
    dated_document(&document(bytes, name)?, name)
}

/// A result by its bytes, with the name of its file in what is wrong with it.
fn document(bytes: &[u8], name: &str) -> Result<ResultDocument> {
    ResultDocument::from_json(bytes).map_err(|e| Trouble::from(e).detail(name))
}

/// As [`dated`], of a result that was read.
fn dated_document(document: &ResultDocument, name: &str) -> Result<DatedEstimate> {
    let date = document.extra.get("date").and_then(|d| d.as_str());
    let day = date.and_then(day_of).ok_or_else(|| {
        Trouble::data("the result does not say on which day it was made")
            .detail(name)
            .with_hint("name result.json files of calibrations")
    })?;
    let stated = document
        .stated()
        .map_err(|e| Trouble::from(e).detail(name))?;
    let estimate = stated.cloned().ok_or_else(|| {
        Trouble::data("the result has no quantities with one covariance")
            .detail(name)
            .with_hint("name result.json files of calibrations")
    })?;
    Ok(DatedEstimate {
        day,
        estimate,
        name: name.to_owned(),
    })
}

/// Days since 1970-01-01 of a date `YYYY-MM-DD`, in the Gregorian calendar.
fn day_of(date: &str) -> Option<f64> {
    let mut parts = date
        .get(..10)?
        .splitn(3, '-')
        .map(|p| p.parse::<i64>().ok());
    let (year, month, day) = (parts.next()??, parts.next()??, parts.next()??);
    if !((1..=12).contains(&month) && (1..=31).contains(&day)) {
        return None;
    }
    // Years begin in March, so that the leap day is the last.
    let shifted = if month <= 2 { year - 1 } else { year };
    let era = shifted.div_euclid(400);
    let of_era = shifted.rem_euclid(400);
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    let days = era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468;
    Some(days as f64)
}

/// What a test found.
#[derive(Clone, Debug, PartialEq)]
pub enum StaticTestFit {
    /// Quantities of one test.
    Test(Box<StaticFit>),
    /// Drifts over calibrations.
    History(StabilityFit),
    /// Angles of a sensor on a machine, with the turn that `apply` takes.
    Mounting(Box<StaticFit>, MountedTurn),
}

/// Section of a result with the turn of a mounting.
const MOUNTING: &str = "mounting";

/// The turn of a result.json of the mounting test.
///
/// # Errors
/// Another file or another result.
pub fn mounted_turn(source: Source) -> Result<(MountedTurn, Input)> {
    let name = source.name().display().to_string();
    let (bytes, input) = source.into_bytes(LARGEST_DOCUMENT)?;
    let (turn, _): (MountedTurn, _) =
        read_section(&bytes, StaticTestOutcome::KIND, MOUNTING).map_err(|e| {
            e.detail(name.clone())
                .with_hint("give roll, pitch and yaw as three angles, or the result.json of `proofmass test mounting`")
        })?;
    match turn.is_sound() {
        true => Ok((turn, input)),
        false => Err(
            Trouble::data("the covariance matrix of the mounting is not valid")
                .detail(name)
                .with_hint("do not edit the file by hand; run `proofmass test mounting` again"),
        ),
    }
}

/// The result of a static test.
#[derive(Clone, Debug, PartialEq)]
pub struct StaticTestOutcome {
    test: StaticTest,
    standard_gravity: bool,
    place: Option<[f64; 2]>,
    probability: f64,
    quantities: Vec<StatedQuantity>,
    findings: Vec<Finding>,
    found: StaticTestFit,
    /// Of tests of one axis.
    calibration: Option<CalibrationFile>,
}

impl StaticTestOutcome {
    /// The fit itself.
    pub fn found(&self) -> &StaticTestFit {
        &self.found
    }
}

impl Outcome for StaticTestOutcome {
    const KIND: &'static str = "static-test";

    fn title(&self, record: &Record) -> String {
        let what = match &self.test {
            StaticTest::Tilt(_) => "Tilt test",
            StaticTest::Sensitivity(_) => "Sensitivity",
            StaticTest::ZeroG(_) => "Zero-g bias",
            StaticTest::Orthogonality(_) => "Orthogonality",
            StaticTest::Linearity(_) => "Linearity",
            StaticTest::Centrifuge(_) => "Centrifuge test",
            StaticTest::Stability(_) => "Stability",
            StaticTest::Mounting(_) => "Mounting",
        };
        record.title(
            &format!("{what} of"),
            &format!("{what} of an accelerometer"),
        )
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.quantities.clone()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn estimate(&self) -> Option<&Estimate> {
        match &self.found {
            StaticTestFit::Test(fit) | StaticTestFit::Mounting(fit, _) => Some(&fit.estimate),
            StaticTestFit::History(_) => None,
        }
    }

    fn gravity(&self) -> Option<ReadGravity> {
        let gravity = match &self.test {
            StaticTest::Tilt(t) => t.gravity,
            StaticTest::Sensitivity(t) => t.gravity,
            StaticTest::ZeroG(t) => t.gravity,
            _ => return None,
        };
        Some(gravity_of(gravity, self.standard_gravity, self.place))
    }

    fn model(&self) -> Option<String> {
        Some(self.test.name().to_owned())
    }

    fn calibration(&self, record: &Record) -> Result<Option<AnyCalibration>> {
        Ok(self.calibration.clone().map(|mut file| {
            file.software = record.software.clone();
            file.device = record.device.clone();
            file.inputs = record.inputs.clone();
            file.into()
        }))
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(match &self.found {
            StaticTestFit::Test(fit) => vec![
                section("nonlinearity", &fit.nonlinearity)?,
                section("orders", &fit.orders)?,
                section("departures", &fit.departures)?,
                section("harmonics", &fit.harmonics)?,
            ],
            StaticTestFit::History(fit) => vec![section("due_in_days", &fit.due_in)?],
            StaticTestFit::Mounting(_, turn) => vec![section(MOUNTING, turn)?],
        })
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }
}

#[cfg(test)]
mod tests {
    use super::day_of;

    #[test]
    fn known_days() {
        assert_eq!(day_of("1970-01-01"), Some(0.0));
        assert_eq!(day_of("2000-03-01"), Some(11_017.0));
        assert_eq!(day_of("2024-02-29T12:00"), Some(19_782.0));
        assert_eq!(day_of("2024-13-01"), None);
        assert_eq!(day_of("yesterday"), None);
    }
}
