//! Methods side by side at several rates.

use super::beside_reference::BesideReference;
use super::ground::{check_sensors, sensors, with_blows};
use super::tune::{TuneResult, gains};
use super::{EstimateResult, once, settled};
use crate::findings;
use crate::{
    Family, IntegratorRule, Method, MethodRow, MotionRecord, Pairing, ReadingSource, Tuning,
    agreement, compare_methods, conditions,
};
use proofmass_core::{Error, Watch};
use proofmass_uncertainty::Finding;

/// A reference against which every fused method is late or early alike has a delay of its own. What is told is the delay of
/// least squares: the maximum of a correlation is drawn to the samples of a noisy reference.
fn reference_delay(rows: &[MethodRow], beside: &BesideReference) -> Option<Finding> {
    let highest = rows.iter().fold(0.0f64, |m, r| m.max(r.rate));
    let fused = |r: &&MethodRow| matches!(r.family, Family::Fused | Family::OffLine);
    let delays: Vec<f64> = rows
        .iter()
        .filter(|r| r.rate == highest)
        .filter(fused)
        .filter_map(|r| r.agreement.delay)
        .collect();
    let (delay, u) = (beside.delay, beside.delay_uncertainty);
    // Each within its own lag, and the steps of a correlation.
    let alike = delays
        .iter()
        .all(|d| (d - delay).abs() < 0.2 * delay.abs() + 1.0 / highest);
    let matters = delay.abs() > (4.0 * u).max(2.0 / highest);
    (delays.len() > 2 && alike && matters).then(|| {
        let what = if delay < 0.0 { "late" } else { "early" };
        findings::reference_delay(what, 1e3 * delay.abs(), 1e3 * u)
    })
}

/// The row whose scale is that of the readings and whose noise is least: of the highest rate the smoother.
fn closest(rows: &[MethodRow]) -> Option<&MethodRow> {
    let highest = rows.iter().fold(0.0f64, |m, r| m.max(r.rate));
    let rank = |r: &&MethodRow| match r.family {
        Family::Acceleration => None,
        Family::Position => Some(0),
        Family::Fused => Some(1),
        Family::OffLine => Some(2),
    };
    rows.iter()
        .filter(|r| r.rate == highest && rank(r).is_some())
        .max_by_key(rank)
}

/// Tuning at one rate of a comparison.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TunedAtRate {
    /// Sample rate, Hz.
    pub rate: f64,
    /// What was found.
    pub result: TuneResult,
}

/// Answer of [`compare`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CompareResult {
    /// One row per method and rate.
    pub rows: Vec<MethodRow>,
    /// Seconds at the start that are not compared.
    pub skip: f64,
    /// Whether the reference is a truth that was given, or the smoother at the full rate.
    pub reference_is_truth: bool,
    /// Scale and delay of the smoother, or of the last method that uses readings, beside a truth that was given.
    pub beside_reference: Option<BesideReference>,
    /// The reference at the full rate.
    pub reference: Vec<f64>,
    /// Tuning at each rate at which it was possible: noise, whiteness, gains.
    pub tuned: Vec<TunedAtRate>,
    /// Whether both sensors see one motion; `None` where one of them sees none.
    pub pairing: Option<Pairing>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

/// The settings of the reference experiment: k₂ = 2, 10, 50 and (k_x, k_v) = (2, 4), (5, 25), (10, 100).
pub fn published_sweep() -> Vec<Method> {
    let two = [2.0, 10.0, 50.0].map(|k2| Method::TwoChannel { k1: 0.0, k2 });
    let observer =
        [(2.0, 4.0), (5.0, 25.0), (10.0, 100.0)].map(|(k_x, k_v)| Method::Observer { k_x, k_v });
    two.into_iter().chain(observer).collect()
}

/// Single-sensor methods: differences and a fit of positions, or the speed as read; and the trapezoid.
pub fn single_sensor_methods(source: ReadingSource) -> Vec<Method> {
    let alone = match source {
        ReadingSource::Position => vec![
            Method::FixedTime,
            Method::SavitzkyGolay {
                window: 5,
                degree: 2,
            },
        ],
        ReadingSource::Speed => vec![Method::SpeedReading],
    };
    let integral = Method::Integration {
        rule: IntegratorRule::Trapezoid,
        offset: 0.0,
    };
    alone.into_iter().chain([integral]).collect()
}

/// Compares methods at decimated rates; every rate also gets the fused methods tuned on its own samples.
///
/// `truth` is a velocity per sample, or the smoother of the full rate stands in. An empty `methods` stands for
/// the single-sensor methods and the published sweep. Noise, gains, slip, corner and encoder map are those of [`estimate`](crate::estimate),
/// and at the full rate its filter and its smoother are the tuned rows.
///
/// # Errors
/// Of the record, the search and the methods.
pub fn compare(
    record: &MotionRecord,
    truth: Option<&[f64]>,
    methods: &[Method],
    decimations: &[usize],
    skip: f64,
    watch: &dyn Watch,
) -> Result<CompareResult, Error> {
    compare_turning(record, truth, methods, decimations, (skip, None), watch)
}

/// The same for an encoder whose turn is known, as [`estimate_turning`](crate::estimate_turning) has it.
///
/// # Errors
/// As [`compare`].
pub fn compare_turning(
    record: &MotionRecord,
    truth: Option<&[f64]>,
    methods: &[Method],
    decimations: &[usize],
    (skip, turn): (f64, Option<f64>),
    watch: &dyn Watch,
) -> Result<CompareResult, Error> {
    record.check()?;
    check_sensors(record, methods)?;
    // Of a record that is not to be tuned a truth still tells the errors.
    let shared = match settled(record, turn, &Tuning::default(), watch) {
        Ok(shared) => Ok(shared),
        Err(error) if error.is_cancelled() || truth.is_none() => return Err(error),
        Err(error) => Err(error),
    };
    let mut findings = Vec::new();
    let (base, pairing) = match &shared {
        Ok(shared) => {
            let first = ["low-corner-found", "encoder-map-subtracted"];
            let told = shared.result.findings.iter();
            findings.extend(told.filter(|f| first.contains(&f.code())).cloned());
            (shared.record.clone(), shared.result.pairing.clone())
        }
        Err(_) => {
            let (slip, pairing) = sensors(record);
            (with_blows(record, slip.as_ref()), pairing)
        }
    };
    findings.extend(conditions(record));
    findings.extend(pairing.iter().flat_map(|p| p.findings.iter().cloned()));
    let slip = shared.as_ref().ok().and_then(|s| s.result.slip.as_ref());
    findings.extend(slip.iter().flat_map(|s| s.findings.iter().cloned()));
    let record = &base;
    let chosen: Vec<Method> = if methods.is_empty() {
        let alone = single_sensor_methods(record.source).into_iter();
        if record.rests_only() {
            let rules = [
                IntegratorRule::Trapezoid,
                IntegratorRule::Simpson,
                IntegratorRule::Tick,
            ];
            rules
                .map(|rule| Method::Integration { rule, offset: 0.0 })
                .to_vec()
        } else if record.accelerometer {
            alone.chain(published_sweep()).collect()
        } else {
            let loops = [10.0, 50.0, 200.0].map(|bandwidth| Method::TrackingLoop { bandwidth });
            let positions = alone.filter(|m| !m.needs_accelerometer());
            match record.source {
                ReadingSource::Position => positions.chain(loops).collect(),
                ReadingSource::Speed => positions.collect(),
            }
        }
    } else {
        methods.to_vec()
    };
    let reference = match (truth, &shared) {
        (Some(truth), _) => truth.to_vec(),
        (None, Ok(shared)) => {
            if !record.rests_only() {
                findings.push(findings::smoother_as_reference());
            }
            shared.result.smoother.velocity.clone()
        }
        (None, Err(error)) => return Err(*error),
    };
    watch.step("methods", 0, 2)?;
    let mut rows = compare_methods(record, &reference, &chosen, decimations, skip)?;
    watch.step("methods", 2, 2)?;
    let mut tuned = Vec::new();
    for &n in decimations {
        if !record.accelerometer || record.rests_only() {
            break;
        }
        let slow = record.decimated(n)?;
        let rate = 1.0 / slow.sample_time;
        let named = (1e4 * rate).round() / 1e4;
        // At the full rate the tuning is the one of the estimate; a slower one is of the same record.
        let slower;
        let at_rate = match (n, &shared) {
            (1, Ok(shared)) => Ok(shared),
            (1, Err(error)) => Err(*error),
            _ => {
                slower = once(&slow, None, None, &Tuning::default(), watch);
                slower.as_ref().map_err(Error::clone)
            }
        };
        match at_rate.and_then(|s| gains(s, watch).map(|g| (s, g))) {
            Ok((settled, result)) => {
                let right = result.tuned.corrected(record);
                let mut own = compare_methods(&right, &reference, &result.methods(), &[n], skip)?;
                let truth: Vec<f64> = reference.iter().step_by(n).copied().collect();
                let first = (skip / slow.sample_time).ceil().max(0.0) as usize;
                // Smoother and filter of the estimate, with all that it knows of noise and constants.
                let EstimateResult {
                    trace, smoother, ..
                } = &settled.result;
                for row in &mut own {
                    let run = match row.family {
                        Family::OffLine => smoother,
                        _ if row.method == trace.method => trace,
                        _ => continue,
                    };
                    row.agreement = agreement(&run.velocity, &truth, slow.sample_time, first)?;
                    row.velocity.clone_from(&run.velocity);
                }
                rows.extend(own);
                let at_rate = result.tuned.findings.iter().cloned();
                let at_rate = at_rate.map(|f| f.of_part(format_args!("{named} Hz")));
                findings.extend(at_rate);
                tuned.push(TunedAtRate { rate, result });
            }
            Err(error) if error.is_cancelled() => return Err(error),
            Err(error) => {
                findings.push(findings::not_tuned(&named.to_string(), &error.to_string()))
            }
        }
    }
    let mut beside = None;
    if truth.is_some() {
        beside = closest(&rows).and_then(|row| {
            let n = (1.0 / (row.rate * record.sample_time)).round().max(1.0) as usize;
            let slow: Vec<f64> = reference.iter().step_by(n).copied().collect();
            let first = (skip * row.rate).ceil().max(0.0) as usize;
            let first = first.min(slow.len());
            BesideReference::of(&row.velocity[first..], &slow[first..], 1.0 / row.rate)
        });
        findings.extend(beside.and_then(|b| reference_delay(&rows, &b)));
        findings.extend(beside.and_then(|b| b.finding()));
    }
    let rank = |f: Family| match f {
        Family::Position => 0,
        Family::Acceleration => 1,
        Family::Fused => 2,
        Family::OffLine => 3,
    };
    rows.sort_by(|a, b| {
        b.rate
            .total_cmp(&a.rate)
            .then(rank(a.family).cmp(&rank(b.family)))
    });
    Ok(CompareResult {
        rows,
        skip,
        reference_is_truth: truth.is_some(),
        beside_reference: beside,
        reference,
        tuned,
        pairing,
        findings,
    })
}
