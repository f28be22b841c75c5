//! Units or runs side by side: coefficients, curves, limits.

use crate::coefficients::figure;
use crate::findings;
use crate::unit_comparison::equal_coefficients;
use crate::{
    Analysis, ChannelAnalysis, CoefficientFit, Conformity, DeviationCurve, LimitCheck, NoiseLimit,
    Term, TermComparison, Verdict,
};
use proofmass_core::Error;
use proofmass_uncertainty::Finding;

/// The terms with a coefficient that every unit has.
const TERMS: [Term; 5] = [
    Term::Quantisation,
    Term::White,
    Term::Flicker,
    Term::RandomWalk,
    Term::Ramp,
];

/// One coefficient in every unit.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ComparedTerm {
    /// Which coefficient.
    pub term: Term,
    /// Its unit.
    pub unit: String,
    /// What is known of it, in the order of the channel's units.
    pub verdicts: Vec<Verdict>,
    /// Whether it may be the same in all; `None` where fewer than two say something.
    pub equal: Option<TermComparison>,
}

/// One channel in every unit that has it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ComparedChannel {
    /// Name of the channel.
    pub name: String,
    /// Unit of its samples.
    pub unit: String,
    /// Which of the units have it.
    pub units: Vec<usize>,
    /// Coefficients side by side.
    pub terms: Vec<ComparedTerm>,
    /// Curves, in the order of `units`.
    pub curves: Vec<Option<DeviationCurve>>,
}

/// One limit against every unit.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CheckedLimit {
    /// The channel.
    pub channel: String,
    /// The limit.
    pub limit: NoiseLimit,
    /// What exactly is compared with it, as `one-sided amplitude density`.
    pub meaning: String,
    /// One entry for each of the channel's units; `None` where nothing is known of the coefficient.
    pub checks: Vec<(usize, Option<LimitCheck>)>,
}

impl CheckedLimit {
    /// How many pass, fail and are undecided, those of which nothing is known among the last.
    pub fn counts(&self) -> [usize; 3] {
        let count = |wanted: Conformity| {
            let is = |c: &&(usize, Option<LimitCheck>)| {
                c.1.map_or(Conformity::Undecided, |c| c.conformity) == wanted
            };
            self.checks.iter().filter(is).count()
        };
        [Conformity::Pass, Conformity::Fail, Conformity::Undecided].map(count)
    }

    /// Edges and counts of the most likely values in as many bins as the root of their number; `None` for fewer than five units.
    pub fn histogram(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        let values: Vec<f64> = self
            .checks
            .iter()
            .filter_map(|(_, check)| check.and_then(|c| c.value))
            .collect();
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(0.0, f64::max);
        let spread = f64::max(high - low, 1e-9 * high);
        if values.len() < 5 || !(spread > 0.0) {
            return None;
        }
        let bins = (values.len() as f64).sqrt().ceil() as usize;
        let width = spread / bins as f64;
        let edges = (0..=bins).map(|k| low + width * k as f64).collect();
        let mut counts = vec![0.0; bins];
        for v in &values {
            let bin = ((v - low) / width).floor().max(0.0) as usize;
            counts[bin.min(bins - 1)] += 1.0;
        }
        Some((edges, counts))
    }
}

/// Units or runs held against each other and against the limits of a data sheet.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct UnitComparison {
    /// Probability at which at least one coefficient of equal units is called different.
    pub false_alarm_rate: f64,
    /// Channels by name.
    pub channels: Vec<ComparedChannel>,
    /// Limits by channel.
    pub limits: Vec<CheckedLimit>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

/// Compares the channels of the same name of several analyses.
///
/// Every coefficient that two units or more say something of is one comparison; the false-alarm rate is shared among all of them
/// (Bonferroni).
///
/// **Errors** [`Error::OutOfRange`] for a probability or limit without meaning; [`Error::Length`] for names and analyses of different
/// number.
///
/// ```
/// use proofmass_noise::{AnalysisOptions, NoiseChannel, NoiseLimit, NoiseModel, Sensor, SimulatedSensor, Term, analyse, compare_units};
///
/// let unit = |white: f64, seed: u64| {
///     let sensor = SimulatedSensor::new(NoiseModel { white, ..Default::default() });
///     let y = sensor.record(1, 10_000, 100.0, seed).unwrap().remove(0);
///     let channel = NoiseChannel { name: "x", sensor: Some(Sensor::Accelerometer), unit: "m/s²", rate: &y };
///     analyse(&[channel], None, 100.0, &AnalysisOptions::default()).unwrap()
/// };
/// let (a, b) = (unit(1.0e-3, 1), unit(1.1e-3, 2));
/// // 150 µg/√Hz one-sided is N = 1.04e-3.
/// let limit = NoiseLimit::new(Term::White, 150.0, "µg/√Hz");
/// let both = compare_units(&["a", "b"], &[&a, &b], &[limit], 0.01).unwrap();
/// assert_eq!(both.limits[0].counts(), [1, 1, 0]);
/// assert!(both.findings.iter().any(|f| f.code() == "units-differ"));
/// ```
pub fn compare_units(
    names: &[&str],
    analyses: &[&Analysis],
    limits: &[NoiseLimit],
    false_alarm_rate: f64,
) -> Result<UnitComparison, Error> {
    crate::coefficients::check_false_alarm_rate(false_alarm_rate)?;
    if names.len() != analyses.len() {
        return Err(Error::Length {
            name: "names",
            expected: analyses.len(),
            got: names.len(),
        });
    }
    let mut channels: Vec<ComparedChannel> = Vec::new();
    let mut checked = Vec::new();
    for analysis in analyses {
        for channel in &analysis.channels {
            if channels.iter().all(|c| c.name != channel.name) {
                channels.push(compared(&channel.name, &channel.unit, analyses));
            }
        }
    }
    for channel in &channels {
        for limit in limits {
            checked.extend(check(channel, limit, analyses)?);
        }
    }
    channels.retain(|c| c.units.len() > 1);
    let mut findings = Vec::new();
    findings.extend(differing(&channels, names, false_alarm_rate));
    findings.extend(beyond(&checked, names));
    if !limits.is_empty() {
        findings.extend(uncovered(&checked, names));
    }
    Ok(UnitComparison {
        false_alarm_rate,
        channels,
        limits: checked,
        findings,
    })
}

/// The channel of a name, in a unit, with coefficients.
fn channel_of<'a>(
    analysis: &'a Analysis,
    name: &str,
    unit: &str,
) -> Option<(&'a ChannelAnalysis, &'a CoefficientFit)> {
    let channel = analysis
        .channels
        .iter()
        .find(|c| c.name == name && c.unit == unit)?;
    Some((channel, channel.whittle.as_ref()?))
}

fn compared(name: &str, unit: &str, analyses: &[&Analysis]) -> ComparedChannel {
    let members: Vec<(usize, &ChannelAnalysis, &CoefficientFit)> = analyses
        .iter()
        .enumerate()
        .filter_map(|(i, a)| channel_of(a, name, unit).map(|(c, f)| (i, c, f)))
        .collect();
    let fits: Vec<&CoefficientFit> = members.iter().map(|m| m.2).collect();
    let terms = TERMS
        .into_iter()
        .filter(|t| fits.iter().all(|f| f.get(*t).is_some()))
        .map(|term| ComparedTerm {
            term,
            unit: term.unit(unit),
            verdicts: fits
                .iter()
                .filter_map(|f| Some(f.get(term)?.verdict))
                .collect(),
            equal: equal_coefficients(term, &fits),
        })
        .collect();
    ComparedChannel {
        name: name.to_owned(),
        unit: unit.to_owned(),
        units: members.iter().map(|m| m.0).collect(),
        terms,
        curves: members.iter().map(|m| m.1.curve.clone()).collect(),
    }
}

fn check(
    channel: &ComparedChannel,
    limit: &NoiseLimit,
    analyses: &[&Analysis],
) -> Result<Option<CheckedLimit>, Error> {
    let mut meaning = None;
    let mut checks = Vec::new();
    for &unit in &channel.units {
        let Some((of_unit, _)) = channel_of(analyses[unit], &channel.name, &channel.unit) else {
            continue;
        };
        let Some(check) = limit.check(of_unit, analyses[unit].sample_rate)? else {
            return Ok(None);
        };
        meaning.get_or_insert(check.meaning);
        checks.push((unit, check.found));
    }
    Ok(meaning.map(|meaning| CheckedLimit {
        channel: channel.name.clone(),
        limit: limit.clone(),
        meaning,
        checks,
    }))
}

fn differing(
    channels: &[ComparedChannel],
    names: &[&str],
    false_alarm_rate: f64,
) -> Option<Finding> {
    let all: Vec<(&ComparedChannel, &ComparedTerm, &TermComparison)> = channels
        .iter()
        .flat_map(|c| c.terms.iter().map(move |t| (c, t)))
        .filter_map(|(c, t)| t.equal.as_ref().map(|e| (c, t, e)))
        .collect();
    let share = false_alarm_rate / all.len().max(1) as f64;
    let evidence: Vec<String> = all
        .iter()
        .filter(|(_, _, e)| e.chance < share)
        .map(|(channel, term, equal)| {
            let place = |wanted: fn(f64, f64) -> bool| {
                let mut best: Option<(usize, f64)> = None;
                for (unit, verdict) in channel.units.iter().zip(&term.verdicts) {
                    if let Some(v) = verdict.estimate()
                        && best.is_none_or(|b| wanted(v, b.1))
                    {
                        best = Some((*unit, v));
                    }
                }
                best.map_or(String::new(), |(unit, v)| {
                    format!("{} in {}", figure(v), names[unit])
                })
            };
            format!(
                "{}.{} from {} to {} {} (χ² = {:.1} with {} degrees of freedom)",
                channel.name,
                term.term.symbol(),
                place(|a, b| a < b),
                place(|a, b| a > b),
                term.unit,
                equal.statistic,
                equal.freedom
            )
        })
        .collect();
    (!evidence.is_empty()).then(|| findings::units_differ(&evidence.join("; ")))
}

/// What fails needs a decision, what is undecided a longer recording.
fn beyond(checked: &[CheckedLimit], names: &[&str]) -> Vec<Finding> {
    let those = |wanted: Conformity| -> Vec<String> {
        let mut list = Vec::new();
        for limit in checked {
            for (unit, check) in &limit.checks {
                let conformity = check.map_or(Conformity::Undecided, |c| c.conformity);
                if conformity == wanted {
                    let interval = check.map_or("unknown".to_owned(), |c| {
                        format!("{} to {}", figure(c.interval.0), figure(c.interval.1))
                    });
                    list.push(format!(
                        "{}: {}.{} {interval} against {} {}",
                        names[*unit],
                        limit.channel,
                        limit.limit.term.symbol(),
                        figure(limit.limit.most),
                        limit.limit.unit
                    ));
                }
            }
        }
        list
    };
    let mut findings = Vec::new();
    let fail = those(Conformity::Fail);
    if !fail.is_empty() {
        findings.push(proofmass_uncertainty::findings::beyond_limit(
            "coefficients of units are",
            &shortened(&fail),
            "the units do not meet the limits; their measurement uncertainty is allowed for",
        ));
    }
    let undecided = those(Conformity::Undecided);
    if !undecided.is_empty() {
        findings.push(proofmass_uncertainty::findings::limit_undecided(
            "coefficients of units",
            &shortened(&undecided),
            "record longer, until the interval lies on one side of the limit",
        ));
    }
    findings
}

/// A unit that no limit covers neither passes nor fails, which a count of failures does not show.
fn uncovered(checked: &[CheckedLimit], names: &[&str]) -> Option<Finding> {
    let without: Vec<String> = names
        .iter()
        .enumerate()
        .filter(|(unit, _)| {
            checked
                .iter()
                .all(|c| c.checks.iter().all(|(checked, _)| checked != unit))
        })
        .map(|(_, name)| (*name).to_owned())
        .collect();
    (!without.is_empty())
        .then(|| findings::no_limit_covers(without.len(), names.len(), &shortened(&without)))
}

fn shortened(list: &[String]) -> String {
    const SHOWN: usize = 12;
    let mut text = list
        .iter()
        .take(SHOWN)
        .cloned()
        .collect::<Vec<_>>()
        .join("; ");
    if list.len() > SHOWN {
        text.push_str(&format!("; {} more in the table", list.len() - SHOWN));
    }
    text
}
