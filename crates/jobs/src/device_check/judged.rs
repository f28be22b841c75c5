//! The verdict on every limit of a device.

use super::DeviceCheckJob;
use super::devices::{CheckedDevice, DeviceResult};
use super::measured::{Candidate, found};
use crate::certificate::RuleWord;
use crate::data_sheet::{ReadLimit, SheetDecision};
use crate::findings;
use crate::trouble::Result;
use proofmass_report::scientific;
use proofmass_uncertainty::{Finding, Judgement, Limits, normal_quantile};
use serde::Serialize;
use std::collections::BTreeMap;

/// How a device stands to a limit of its data sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SheetVerdict {
    /// The limit is met.
    Pass,
    /// No result says anything of it.
    NotShown,
    /// The limit lies within the interval, or two results contradict each other.
    Undecided,
    /// The limit is exceeded.
    Fail,
}

impl SheetVerdict {
    /// In words.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::NotShown => "not shown",
            Self::Undecided => "undecided",
            Self::Fail => "fail",
        }
    }

    /// Over several: the gravest; of none not shown.
    pub(super) fn over(all: impl IntoIterator<Item = Self>) -> Self {
        all.into_iter().max().unwrap_or(Self::NotShown)
    }
}

impl From<Judgement> for SheetVerdict {
    fn from(judgement: Judgement) -> Self {
        match judgement {
            Judgement::Pass => Self::Pass,
            Judgement::Fail => Self::Fail,
            Judgement::Undecided => Self::Undecided,
        }
    }
}

/// The verdict on one limit of one axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct JudgedLimit {
    /// Which limit of the sheet, from zero.
    pub limit: usize,
    /// The axis, the pair of axes or the channel; empty for a device of one.
    pub axis: String,
    /// The verdict.
    pub verdict: SheetVerdict,
    /// What decided it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shown: Option<Shown>,
    /// Why nothing is shown, or nothing is decided.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub why: String,
}

/// A value that a limit was held against, in the unit of the limit.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Shown {
    /// The value; none where an upper limit alone is known.
    pub value: Option<f64>,
    /// Lower end of its interval.
    pub low: f64,
    /// Upper end of its interval.
    pub high: f64,
    /// Probability that the limit holds.
    pub conforms: Option<f64>,
    /// Frequency at which it was decided, Hz.
    #[serde(rename = "frequency_Hz", skip_serializing_if = "Option::is_none")]
    pub frequency: Option<f64>,
    /// Name of the quantity.
    pub quantity: String,
    /// The file.
    pub result: String,
}

/// Judges the limits of one device.
pub(super) struct Judge<'a> {
    device: &'a CheckedDevice,
    results: &'a [DeviceResult],
    job: &'a DeviceCheckJob,
    findings: Vec<Finding>,
}

/// A verdict with what decided it.
struct Decided<'a> {
    verdict: SheetVerdict,
    by: &'a Candidate,
    conforms: Option<f64>,
    why: String,
}

impl<'a> Judge<'a> {
    pub(super) fn new(
        device: &'a CheckedDevice,
        results: &'a [DeviceResult],
        job: &'a DeviceCheckJob,
    ) -> Self {
        Self {
            device,
            results,
            job,
            findings: Vec::new(),
        }
    }

    /// What there is to doubt about the verdicts.
    pub(super) fn findings(self) -> Vec<Finding> {
        self.findings
    }

    /// The verdicts on all limits.
    ///
    /// # Errors
    /// A result that contradicts itself.
    pub(super) fn all(&mut self, limits: &[ReadLimit]) -> Result<Vec<JudgedLimit>> {
        let mut rows = Vec::new();
        for (k, limit) in limits.iter().enumerate() {
            rows.extend(self.one(k, limit)?);
        }
        Ok(rows)
    }

    fn one(&mut self, number: usize, limit: &ReadLimit) -> Result<Vec<JudgedLimit>> {
        let zero = self.job.sheet.output.as_ref();
        let found = found(limit, self.device, self.results, zero)?;
        let name = limit.characteristic.name();
        let mut axes: BTreeMap<&str, Vec<&Candidate>> = BTreeMap::new();
        for c in &found.candidates {
            axes.entry(&c.axis).or_default().push(c);
        }
        let mut rows = Vec::new();
        for (axis, candidates) in &axes {
            let decided = self.axis(limit, candidates);
            self.covers(limit, candidates, &of_axis(name, axis));
            rows.extend(decided.map(|d| JudgedLimit {
                limit: number,
                axis: (*axis).to_owned(),
                verdict: d.verdict,
                shown: Some(Shown {
                    value: d.by.value,
                    low: d.by.interval.0,
                    high: d.by.interval.1,
                    conforms: d.conforms,
                    frequency: d.by.frequency,
                    quantity: d.by.quantity.clone(),
                    result: self.results[d.by.result].name.clone(),
                }),
                why: d.why,
            }));
        }
        let why = match (&found.of_another_unit[..], &found.elsewhere[..]) {
            ([], []) => "no result states it".to_owned(),
            ([], _) => "no result was measured at these temperatures".to_owned(),
            (other, _) => {
                if found.candidates.is_empty() {
                    self.findings.push(findings::limit_not_convertible(
                        &self.device.name,
                        name,
                        &limit.unit,
                        &other.join("; "),
                    ));
                }
                format!("cannot be converted to {}", limit.unit)
            }
        };
        let missing = |axis: &str| JudgedLimit {
            limit: number,
            axis: axis.to_owned(),
            verdict: SheetVerdict::NotShown,
            shown: None,
            why: why.clone(),
        };
        let has = |wanted: &String| {
            found.candidates.iter().any(|c| {
                c.axis == *wanted
                    || c.quantity.strip_suffix(&format!(".{name}")) == Some(wanted.as_str())
            })
        };
        match rows.is_empty() && limit.channels.is_empty() {
            true => rows.push(missing("")),
            false => rows.extend(
                limit
                    .channels
                    .iter()
                    .filter(|c| !has(c))
                    .map(|c| missing(c)),
            ),
        }
        Ok(rows)
    }

    /// The gravest verdict over the frequencies of an axis.
    fn axis<'c>(&mut self, limit: &ReadLimit, candidates: &[&'c Candidate]) -> Option<Decided<'c>> {
        let mut at: BTreeMap<u64, Vec<&'c Candidate>> = BTreeMap::new();
        for c in candidates {
            let key = c.frequency.unwrap_or(0.0).to_bits();
            at.entry(key).or_default().push(c);
        }
        let mut worst: Option<Decided<'c>> = None;
        for same in at.values() {
            let Some(decided) = self.of_repeats(limit, same) else {
                continue;
            };
            let graver = |w: &Decided<'c>| {
                let chance = |d: &Decided<'c>| d.conforms.unwrap_or(0.5);
                decided.verdict > w.verdict
                    || decided.verdict == w.verdict && chance(&decided) < chance(w)
            };
            if worst.as_ref().is_none_or(graver) {
                worst = Some(decided);
            }
        }
        if let Some(worst) = &worst {
            self.can_pass(limit, worst.by);
        }
        worst
    }

    /// The verdict by the value with the smallest interval, unless two results contradict each other.
    fn of_repeats<'c>(&mut self, limit: &ReadLimit, same: &[&'c Candidate]) -> Option<Decided<'c>> {
        let best = *same.iter().min_by(|a, b| a.half().total_cmp(&b.half()))?;
        let (verdict, conforms) = decide(limit, best, self.job.sheet.decision);
        let other = same
            .iter()
            .find(|c| contradict(best, c, self.job.false_alarm_rate));
        let Some(other) = other else {
            return Some(Decided {
                verdict,
                by: best,
                conforms,
                why: String::new(),
            });
        };
        let told = |c: &Candidate| {
            let value = c.value.map_or_else(
                || format!("at most {}", scientific(c.interval.1, 4)),
                |v| format!("{} ± {}", scientific(v, 4), scientific(c.half(), 2)),
            );
            format!("{value} {} in {}", limit.unit, self.results[c.result].name)
        };
        let evidence = format!("{}, {}", told(best), told(other));
        let name = of_axis(limit.characteristic.name(), &best.axis);
        let doubt = findings::results_contradict(&self.device.name, &name, &evidence);
        self.findings.push(doubt);
        Some(Decided {
            verdict: SheetVerdict::Undecided,
            by: best,
            conforms,
            why: "two results contradict each other".to_owned(),
        })
    }

    /// Says where the guard bands leave nothing.
    fn can_pass(&mut self, limit: &ReadLimit, by: &Candidate) {
        let SheetDecision { rule, r } = self.job.sheet.decision;
        if let (RuleWord::GuardBand, Some(lower), Some(upper)) =
            (rule, limit.limits.lower, limit.limits.upper)
            && 2.0 * r * by.half() >= upper - lower
        {
            self.findings.push(findings::guard_band_too_wide(
                &self.device.name,
                &of_axis(limit.characteristic.name(), &by.axis),
                r * by.half(),
                &limit.words(),
            ));
        }
    }

    /// Says where a band was measured in part.
    fn covers(&mut self, limit: &ReadLimit, candidates: &[&Candidate], name: &str) {
        let Some([low, high]) = limit.frequency else {
            return;
        };
        let all = candidates.iter().filter_map(|c| c.frequency);
        let (first, last) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), f| {
            (a.min(f), b.max(f))
        });
        if first > low || last < high {
            self.findings.push(findings::limit_band_not_covered(
                &self.device.name,
                name,
                low,
                high,
                first,
                last,
            ));
        }
    }
}

/// A characteristic with its axis, in words.
pub(super) fn of_axis(name: &str, axis: &str) -> String {
    match axis {
        "" => name.to_owned(),
        axis => format!("{name} of {axis}"),
    }
}

/// The verdict on a value, and the probability that the limit holds.
fn decide(
    limit: &ReadLimit,
    c: &Candidate,
    decision: SheetDecision,
) -> (SheetVerdict, Option<f64>) {
    let limits: &Limits = &limit.limits;
    let verdict = match (decision.rule, c.value) {
        (RuleWord::Simple, Some(value)) => match limits.contains(value) {
            true => SheetVerdict::Pass,
            false => SheetVerdict::Fail,
        },
        // Of an upper limit alone no value can be taken: it passes where all below it does.
        (RuleWord::Simple, None) => limits.judge(c.interval).into(),
        (RuleWord::GuardBand, _) => limits.judge(c.guarded(decision.r)).into(),
    };
    (verdict, c.conforms(limits))
}

/// Whether two values differ by more than chance lets those that agree.
fn contradict(a: &Candidate, b: &Candidate, rate: f64) -> bool {
    if a.result == b.result {
        return false;
    }
    match (a.value, b.value) {
        (Some(x), Some(y)) => {
            let u = a.standard(y > x).hypot(b.standard(x > y));
            (x - y).abs() > normal_quantile(1.0 - 0.5 * rate) * u
        }
        // An upper limit below the interval of the other.
        _ => a.interval.1 < b.interval.0 || b.interval.1 < a.interval.0,
    }
}
