//! Devices, held against their data sheet: every limit, by what the results of a device state with their uncertainty.

mod devices;
mod grades;
mod judged;
mod measured;
mod page;

pub use devices::DeviceResult;
pub use grades::{GradeVerdict, known_grades};
pub use judged::{JudgedLimit, SheetVerdict, Shown};

use crate::data_sheet::{DataSheet, ReadLimit, read_all};
use crate::findings;
use crate::outcome::{Job, Outcome, section};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use devices::{CheckedDevice, devices};
use judged::{Judge, of_axis};
use proofmass_core::Watch;
use proofmass_documents::StatedQuantity;
use proofmass_report::Report;
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

/// Which sheet holds, and how often two results that agree may be said to contradict each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct DeviceCheckJob {
    /// The data sheet.
    pub sheet: DataSheet,
    /// Probability at which two results of one quantity that agree are said to contradict each other.
    pub false_alarm_rate: f64,
}

impl Default for DeviceCheckJob {
    fn default() -> Self {
        Self {
            sheet: DataSheet::default(),
            false_alarm_rate: 0.01,
        }
    }
}

/// Results of devices.
pub struct DeviceCheckData<'a> {
    /// The results, of one device or of several.
    pub results: &'a [DeviceResult],
}

impl Job for DeviceCheckJob {
    type Data<'a> = DeviceCheckData<'a>;
    type Outcome = DeviceCheckOutcome;

    fn evaluate(
        &self,
        data: &DeviceCheckData<'_>,
        watch: &dyn Watch,
    ) -> Result<DeviceCheckOutcome> {
        watch.step("devices", 0, 1)?;
        self.sheet.check()?;
        if !(self.false_alarm_rate > 0.0 && self.false_alarm_rate < 1.0) {
            return Err(Trouble::request(format!(
                "a false-alarm rate of {} is no probability",
                self.false_alarm_rate
            ))
            .with_hint("it lies between 0 and 1"));
        }
        let limits = read_all(&self.sheet.limit, "limit")?;
        let (devices, mut found) = devices(data.results, &self.sheet.device)?;
        let grades = match self.sheet.grade.is_empty() {
            true => known_grades(),
            false => self.sheet.grade.clone(),
        };
        let total = devices.len() as u64;
        let mut checked = Vec::with_capacity(devices.len());
        for (k, device) in devices.into_iter().enumerate() {
            watch.step("devices", k as u64, total)?;
            let mut judge = Judge::new(&device, data.results, self);
            let rows = judge.all(&limits)?;
            let doubts = judge.findings();
            let graded = grades::reached(&grades, &device, data.results, self)?;
            found.extend(doubts);
            checked.push(DeviceVerdict {
                device,
                limits: rows,
                grades: graded,
            });
        }
        watch.step("devices", total, total)?;
        found.extend(summed_up(&checked, &limits));
        found.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        Ok(DeviceCheckOutcome {
            sheet: self.sheet.clone(),
            limits,
            grades,
            devices: checked,
            results: data.results.iter().map(UsedResult::of).collect(),
            findings: found,
        })
    }
}

/// What is beyond, open or not shown, all devices together.
fn summed_up(devices: &[DeviceVerdict], limits: &[ReadLimit]) -> Vec<Finding> {
    let those = |verdict: SheetVerdict| -> Vec<String> {
        let rows = devices
            .iter()
            .flat_map(|d| d.limits.iter().map(move |row| (d, row)));
        rows.filter(|(_, row)| row.verdict == verdict)
            .map(|(d, row)| {
                let limit = &limits[row.limit];
                let what = of_axis(limit.characteristic.name(), &row.axis);
                format!("{}: {what}, {}", d.device.name, limit.words())
            })
            .collect()
    };
    let mut all = Vec::new();
    let fail = those(SheetVerdict::Fail);
    if !fail.is_empty() {
        all.push(proofmass_uncertainty::findings::beyond_limit(
            "devices are",
            &shortened(&fail),
            "the device does not meet its data sheet; the uncertainty is allowed for",
        ));
    }
    let open = those(SheetVerdict::Undecided);
    if !open.is_empty() {
        all.push(proofmass_uncertainty::findings::limit_undecided(
            "devices",
            &shortened(&open),
            "measure again with a smaller U, until the interval lies on one side of the limit",
        ));
    }
    let missing = those(SheetVerdict::NotShown);
    if !missing.is_empty() {
        all.push(findings::limit_not_shown(
            missing.len(),
            &shortened(&missing),
        ));
    }
    all
}

fn shortened(list: &[String]) -> String {
    const MOST: usize = 8;
    let mut text = list.iter().take(MOST).cloned().collect::<Vec<_>>();
    if list.len() > MOST {
        text.push(format!("{} more in the table", list.len() - MOST));
    }
    text.join("; ")
}

/// What became of one device.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct DeviceVerdict {
    pub(crate) device: CheckedDevice,
    /// Its limits, one by one.
    pub limits: Vec<JudgedLimit>,
    /// The grades, the lowest first.
    pub grades: Vec<GradeVerdict>,
}

impl DeviceVerdict {
    /// What it is called: its serial number where one is stated, else its folder.
    pub fn name(&self) -> &str {
        &self.device.name
    }

    /// The verdict over all limits.
    pub fn verdict(&self) -> SheetVerdict {
        SheetVerdict::over(self.limits.iter().map(|row| row.verdict))
    }

    /// How many limits have a verdict.
    pub fn count(&self, verdict: SheetVerdict) -> usize {
        self.limits.iter().filter(|r| r.verdict == verdict).count()
    }

    /// The highest grade all of whose limits are met.
    pub fn grade(&self) -> Option<&str> {
        let reached = self.grades.iter().rev();
        let mut reached = reached.filter(|g| g.verdict == SheetVerdict::Pass);
        reached.next().map(|g| g.name.as_str())
    }
}

/// A result, and whether it could show anything.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct UsedResult {
    name: String,
    kind: String,
    device: String,
    quantities: usize,
}

impl UsedResult {
    fn of(result: &DeviceResult) -> Self {
        Self {
            name: result.name.clone(),
            kind: result.kind().to_owned(),
            device: result.device().line(),
            quantities: result.shown(),
        }
    }
}

/// The answer: a verdict for every device and limit.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceCheckOutcome {
    sheet: DataSheet,
    limits: Vec<ReadLimit>,
    grades: Vec<crate::data_sheet::Grade>,
    devices: Vec<DeviceVerdict>,
    results: Vec<UsedResult>,
    findings: Vec<Finding>,
}

impl DeviceCheckOutcome {
    /// The devices, by name.
    pub fn devices(&self) -> &[DeviceVerdict] {
        &self.devices
    }
}

impl Outcome for DeviceCheckOutcome {
    const KIND: &'static str = "device-check";
    const PRINCIPAL_TABLE: &'static str = "verdicts.csv";

    fn title(&self, record: &Record) -> String {
        if let Some(title) = &record.title {
            return title.clone();
        }
        let device = self.sheet.device.line();
        match (&self.devices[..], device.as_str()) {
            ([one], "") => format!("Device {} against its data sheet", one.name()),
            ([one], device) => format!("Device {} against the data sheet of {device}", one.name()),
            (all, "") => format!("{} devices against their data sheet", all.len()),
            (all, device) => format!("{} devices against the data sheet of {device}", all.len()),
        }
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
            section("devices", &self.devices)?,
        ])
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }
}
