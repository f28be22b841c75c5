//! Three questions to a record, answered as plain data: estimate, compare, tune.

use crate::edges::on_edges;
use crate::tuning::Constants;
use crate::{
    ComparisonRow, Crossover, Family, Filter, Found, IntegratorRule, KalmanModel, Method,
    MotionRecord, Pairing, Ripple, SlipReport, SlipSearch, Source, Trace, Tuned, Tuning,
    compare_methods, conditions, crossover_by_smoother, kalman_by_smoother, ripple,
};
use proofmass_core::{Error, Watch};
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Answer of [`tune`]: the model and the gains of every fused method, found without a truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TuneResult {
    /// Noise by maximum likelihood; the smoother's model.
    pub tuned: Tuned,
    /// Kalman filter, closest to the smoother.
    pub kalman: Crossover,
    /// Two channels, closest to the smoother.
    pub two_channel: Crossover,
    /// Observer, closest to the smoother.
    pub observer: Crossover,
    /// Samples it was found on.
    pub samples: Range<usize>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl TuneResult {
    /// The tuned methods: Kalman, two channels, observer, smoother.
    pub fn methods(&self) -> Vec<Method> {
        vec![
            self.kalman.method,
            self.two_channel.method,
            self.observer.method,
            Method::Smoother {
                model: self.tuned.model,
            },
        ]
    }
}

/// Finds noise parameters and gains from the record alone.
///
/// The noise is that of the largest likelihood of the longest stretch without slip; the gains of each on-line filter
/// are those that come closest to the smoother with this noise, on the accelerometer with its gain and latency put
/// right. Of more than 20 000 samples the 20 000 with the most motion are used: by then R is known to one per cent.
///
/// # Errors
/// Of the record and of the search ([`Tuning::run`], [`crate::crossover`]).
pub fn tune(
    record: &MotionRecord,
    tuning: &Tuning,
    watch: &dyn Watch,
) -> Result<TuneResult, Error> {
    record.check()?;
    let slip = slip_search(record).ok();
    let pairing = pairing(record, slip.as_ref());
    let (part, samples) = tuning_part(record, slip.as_ref());
    let tuned = paired_tuning(&part, tuning, pairing.as_ref(), watch)?;
    let skip = settle(&part);
    let part = tuned.corrected(&part);
    let kalman = kalman_by_smoother(&tuned.model, &part, skip)?;
    watch.step("gains", 1, 3)?;
    let two_channel = crossover_by_smoother(Filter::TwoChannel, &tuned.model, &part, skip)?;
    watch.step("gains", 2, 3)?;
    let observer = crossover_by_smoother(Filter::Observer, &tuned.model, &part, skip)?;
    watch.step("gains", 3, 3)?;
    // Wrong units and senses first: the gains are worth nothing with them.
    let mut findings = doubts(pairing.as_ref(), Some(&tuned));
    findings.extend(conditions(record));
    findings.extend(part_finding(record, &samples));
    findings.extend(tuned.findings.iter().cloned());
    Ok(TuneResult {
        tuned,
        kalman,
        two_channel,
        observer,
        samples,
        findings,
    })
}

/// Tuning in which a latency of more than half a step is taken off first: the likelihood knows it only as a slope.
fn paired_tuning(
    part: &MotionRecord,
    tuning: &Tuning,
    pairing: Option<&Pairing>,
    watch: &dyn Watch,
) -> Result<Tuned, Error> {
    let half = 0.5 * part.sample_time;
    let told = pairing.filter(|p| {
        tuning.pairing && p.is_clear() && p.latency.abs() > (4.0 * p.latency_uncertainty).max(half)
    });
    let mut before = told.map_or(0.0, |p| p.latency);
    // Once there is a latency, its rest is unknown, however small.
    let run = |shift: f64, late: bool| tuning.search(&part.corrected(1.0, shift), late, watch);
    let mut tuned = run(before, told.is_some())?;
    for _ in 0..2 {
        match tuned.latency {
            Some(rest) if rest.value.abs() > half => {
                before += rest.value;
                tuned = run(before, true)?;
            }
            _ => break,
        }
    }
    tuned.shifted_before(before);
    Ok(tuned)
}

/// What gain and latency between the sensors make one doubt; where they were found and used, that.
fn doubts(pairing: Option<&Pairing>, tuned: Option<&Tuned>) -> Vec<Finding> {
    let gain = tuned.and_then(|t| t.gain);
    let latency = tuned.and_then(|t| t.latency);
    let mut findings: Vec<Finding> = pairing
        .iter()
        .flat_map(|p| &p.findings)
        .filter(|f| match f.code() {
            "gain-mismatch" => gain.is_none() || f.severity() == Severity::Decision,
            "latency" => latency.is_none(),
            _ => true,
        })
        .cloned()
        .collect();
    if let Some(gain) = gain {
        findings.push(
            Finding::new(
                Severity::Warning,
                "gain-mismatch",
                "readings and accelerometer do not agree on the size of the motion; the gain was found and is used",
            )
            .evidence(format!(
                "the accelerometer reads {:.5} (u = {:.5}) times the acceleration of the readings",
                gain.value, gain.uncertainty
            ))
            .advice("calibrate the accelerometer, or check the increment or the radius of the wheel: one of them is wrong by this factor"),
        );
    }
    if let Some(latency) = latency {
        let late = if latency.value > 0.0 {
            "later"
        } else {
            "earlier"
        };
        findings.push(
            Finding::new(
                Severity::Note,
                "latency",
                format!(
                    "the accelerometer is {late} than the readings; the time was found and is used"
                ),
            )
            .evidence(format!(
                "{:.4} ms (u = {:.4} ms)",
                1e3 * latency.value,
                1e3 * latency.uncertainty
            ))
            .advice("state it for methods that are run on line: they do not know it"),
        );
    }
    findings
}

/// A tenth of the record, at most a second: filters that start with a wrong velocity settle there.
fn settle(record: &MotionRecord) -> usize {
    let n = record.reading.len();
    ((1.0 / record.sample_time) as usize).min(n / 10)
}

/// Slip with windows that hold several readings of this record.
fn slip_search(record: &MotionRecord) -> Result<SlipReport, Error> {
    let search = SlipSearch::default();
    let step = record.sample_time;
    let between = record.reading_stride() as f64 * step;
    SlipSearch {
        window: search.window.max(5.0 * step).max(4.0 * between),
        blow: search.blow.max(2.0 * step),
        ..search
    }
    .run(record)
}

/// Samples before and after an episode that its windows still touch.
fn margin(record: &MotionRecord) -> usize {
    let step = record.sample_time;
    let between = record.reading_stride() as f64 * step;
    let window = SlipSearch::default()
        .window
        .max(5.0 * step)
        .max(4.0 * between);
    (window / step).round() as usize
}

/// Gain and latency on the longest stretch without slip. Where that is too short to tell, on the whole record, and
/// then only of one motion beyond doubt: a wrong unit looks like slip all over.
fn pairing(record: &MotionRecord, slip: Option<&SlipReport>) -> Option<Pairing> {
    let margin = margin(record);
    let clean = longest(record.reading.len(), |k| {
        !slip.is_some_and(|s| s.slips(k, margin))
    });
    let whole = clean.len() == record.reading.len();
    let inside = part(record, clean).and_then(|part| Pairing::of(&part).ok());
    if whole || inside.as_ref().is_some_and(Pairing::is_clear) {
        return inside;
    }
    let all = Pairing::of(record).ok();
    all.filter(|p| p.correlation.abs() > 0.97).or(inside)
}

/// Most samples a search for the noise needs.
const ENOUGH: usize = 20_000;

/// The longest stretch without slip, or the liveliest part of it.
fn tuning_part(record: &MotionRecord, slip: Option<&SlipReport>) -> (MotionRecord, Range<usize>) {
    let n = record.reading.len();
    let margin = margin(record);
    let clean = longest(n, |k| !slip.is_some_and(|s| s.slips(k, margin)));
    let range = if clean.len() <= ENOUGH {
        clean
    } else {
        let mut last = None::<f64>;
        let path: Vec<f64> = record.reading[clean.clone()]
            .iter()
            .map(|r| {
                let step = match (r, last) {
                    (Some(r), Some(l)) => (r - l).abs(),
                    _ => 0.0,
                };
                last = r.or(last);
                step
            })
            .collect();
        let block = |k: &usize| path[*k..*k + ENOUGH].iter().sum::<f64>();
        let liveliest = (0..=path.len() - ENOUGH)
            .step_by(ENOUGH / 2)
            .max_by(|a, b| block(a).total_cmp(&block(b)))
            .unwrap_or(0);
        clean.start + liveliest..clean.start + liveliest + ENOUGH
    };
    match part(record, range.clone()) {
        Some(part) => (part, range),
        None => (record.clone(), 0..n),
    }
}

fn part_finding(record: &MotionRecord, samples: &Range<usize>) -> Option<Finding> {
    let n = record.reading.len();
    let dt = record.sample_time;
    (samples.len() < n).then(|| {
        Finding::new(
            Severity::Note,
            "tuned-on-a-part",
            "the noise was found on a part: the longest without slip, of a long record the liveliest",
        )
        .evidence(format!(
            "{:.3} s to {:.3} s of {:.3} s",
            samples.start as f64 * dt,
            samples.end as f64 * dt,
            n as f64 * dt
        ))
    })
}

/// Answer of [`estimate`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EstimateResult {
    /// Velocity by the chosen method.
    pub trace: Trace,
    /// Velocity by the smoother of the same (or the tuned) model, with its uncertainty.
    pub smoother: Trace,
    /// The model the smoother rests on.
    pub model: KalmanModel,
    /// How it was found; `None` when it was given.
    pub tuned: Option<Tuned>,
    /// Offset of the accelerometer by the smoother with its standard uncertainty, when it is a state.
    pub offset: Option<(Vec<f64>, Vec<f64>)>,
    /// Share of the samples away from slip where filter and smoother agree within two standard uncertainties of
    /// their difference, √(u_f² − u_s²); `None` when the method states no uncertainty.
    pub agreement: Option<f64>,
    /// Whether both sensors see one motion; `None` where one of them sees none.
    pub pairing: Option<Pairing>,
    /// Slip and collisions; `None` for a record too short to look.
    pub slip: Option<SlipReport>,
    /// Repeating errors of the encoder; `None` when the axis hardly moves.
    pub ripple: Option<Ripple>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

/// Velocity of a record by a method, or by the Kalman filter with tuned gains when none is given.
///
/// The record is searched for slip and collisions first; noise is tuned on the longest stretch without slip, so
/// that slip does not pass for noise. `circumference` is the distance of one turn, when known.
///
/// # Errors
/// Of the record, the search and the method.
pub fn estimate(
    record: &MotionRecord,
    method: Option<Method>,
    circumference: Option<f64>,
    watch: &dyn Watch,
) -> Result<EstimateResult, Error> {
    record.check()?;
    let slip = slip_search(record).ok();
    let margin = margin(record);
    let slips = |k: usize| slip.as_ref().is_some_and(|s| s.slips(k, margin));
    let mut findings = conditions(record);
    let given = match method {
        Some(
            Method::Kalman { model } | Method::SteadyKalman { model } | Method::Smoother { model },
        ) => Some(model),
        _ => None,
    };
    let pairing = pairing(record, slip.as_ref());
    let smoother_trace = |method: Method, velocity, uncertainty| Trace {
        method,
        label: method.label(),
        velocity,
        standard_uncertainty: Some(uncertainty),
        stated_delay: 0.0,
    };
    let (model, tuned, trace, smoother, offset) = match given {
        Some(model) => {
            let found = Method::Kalman { model };
            let run = model.smooth(record)?;
            let smoother = smoother_trace(
                Method::Smoother { model },
                run.velocity,
                run.velocity_uncertainty,
            );
            let trace = method.unwrap_or(found).run(record)?;
            (model, None, trace, smoother, run.offset)
        }
        None => {
            let (part, samples) = tuning_part(record, slip.as_ref());
            let mut tuned = paired_tuning(&part, &Tuning::default(), pairing.as_ref(), watch)?;
            watch.step("velocity", 0, 2)?;
            let edges = on_edges(&mut tuned, &part, record, watch)?;
            findings.extend(part_finding(record, &samples));
            findings.extend(tuned.findings.iter().cloned());
            watch.step("velocity", 1, 2)?;
            let model = tuned.model;
            if let Some((counted, run)) = edges {
                let trace = match method {
                    Some(method) => method.run(record)?,
                    None => smoother_trace(
                        Method::Counting { model: counted },
                        run.filtered.0,
                        run.filtered.1,
                    ),
                };
                let smoother = smoother_trace(
                    Method::CountingSmoother { model: counted },
                    run.smoothed.0,
                    run.smoothed.1,
                );
                (model, Some(tuned), trace, smoother, None)
            } else {
                let trace = match method {
                    Some(method) => method.run(record)?,
                    None => {
                        let right = tuned.corrected(&part);
                        let kalman = kalman_by_smoother(&model, &right, settle(&part))?;
                        on_line(&tuned, kalman.method, record)?
                    }
                };
                // Slip would pass for an offset.
                let constants = match slip.as_ref().is_some_and(|s| !s.slip.is_empty()) {
                    true => Constants::Held,
                    false => Constants::Fitted,
                };
                let run = tuned.smooth(record, constants)?;
                let smoother =
                    smoother_trace(Method::Smoother { model }, run.velocity, run.uncertainty);
                (model, Some(tuned), trace, smoother, run.offset)
            }
        }
    };
    watch.step("velocity", 2, 2)?;
    // Filter and smoother of one model on one record: what is found beside it is in both.
    let own = match (&tuned, &smoother.method) {
        (Some(tuned), Method::Smoother { .. }) => {
            let run = model.smooth(&tuned.corrected(record))?;
            (run.velocity, run.velocity_uncertainty)
        }
        _ => (
            smoother.velocity.clone(),
            smoother.standard_uncertainty.clone().unwrap_or_default(),
        ),
    };
    let agreement = agreement_share(&trace, &own, &slips);
    if let Some(share) = agreement.filter(|s| *s < 0.8) {
        findings.push(
            Finding::new(
                Severity::Warning,
                "filter-and-smoother-disagree",
                "filter and smoother differ by more than their uncertainties allow",
            )
            .evidence(format!(
                "{:.1} % of the samples away from slip agree within two standard uncertainties; 95 % are expected",
                100.0 * share
            ))
            .advice("tune on this record, or look for slip, latency and gain errors"),
        );
    }
    findings.extend(doubts(pairing.as_ref(), tuned.as_ref()));
    findings.extend(slip.iter().flat_map(|s| s.findings.iter().cloned()));
    let ripple = match record.source {
        // Between two edges of a slow axis the accelerometer's walk is longer than any line.
        Source::Position if matches!(smoother.method, Method::CountingSmoother { .. }) => None,
        Source::Position => ripple(record, circumference, |k| !slips(k)).ok(),
        // A wheel that is not round turns with the distance as well, but a speed shows no place on it.
        Source::Speed => None,
    };
    findings.extend(ripple.iter().flat_map(|r| r.findings.iter().cloned()));
    Ok(EstimateResult {
        trace,
        smoother,
        model,
        tuned,
        offset,
        agreement,
        pairing,
        slip,
        ripple,
        findings,
    })
}

/// An on-line method on the record with gain and latency put right; their uncertainty adds what moving each by it does.
fn on_line(tuned: &Tuned, method: Method, record: &MotionRecord) -> Result<Trace, Error> {
    let mut trace = method.run(&tuned.corrected(record))?;
    let value =
        |found: Option<Found>, other: f64| found.map_or((other, 0.0), |f| (f.value, f.uncertainty));
    let (gain, u_gain) = value(tuned.gain, 1.0);
    let (latency, u_latency) = value(tuned.latency, 0.0);
    for (gain, latency, u) in [
        (gain + u_gain, latency, u_gain),
        (gain, latency + u_latency, u_latency),
    ] {
        if u == 0.0 {
            continue;
        }
        let moved = method.run(&record.corrected(gain, latency))?;
        if let Some(own) = &mut trace.standard_uncertainty {
            for (k, u) in own.iter_mut().enumerate() {
                *u = u.hypot(moved.velocity[k] - trace.velocity[k]);
            }
        }
    }
    Ok(trace)
}

/// Longest run of samples for which `good` holds.
fn longest(n: usize, good: impl Fn(usize) -> bool) -> Range<usize> {
    let (mut best, mut from) = (0..0, 0);
    for k in 0..=n {
        if k == n || !good(k) {
            if k - from > best.len() {
                best = from..k;
            }
            from = k + 1;
        }
    }
    best
}

/// A stretch of a record; the velocity at its start is unknown unless it is the beginning.
fn part(record: &MotionRecord, range: Range<usize>) -> Option<MotionRecord> {
    let part = MotionRecord {
        reading: record.reading.get(range.clone())?.to_vec(),
        acceleration: record.acceleration.get(range.clone())?.to_vec(),
        initial_velocity: record.initial_velocity.filter(|_| range.start == 0),
        ..*record
    };
    (part.reading.iter().flatten().count() >= 100).then_some(part)
}

fn agreement_share(
    trace: &Trace,
    (smooth, us): &(Vec<f64>, Vec<f64>),
    slips: &impl Fn(usize) -> bool,
) -> Option<f64> {
    let uf = trace.standard_uncertainty.as_ref()?;
    let (mut inside, mut all) = (0usize, 0usize);
    for k in 0..trace.velocity.len() {
        if slips(k) {
            continue;
        }
        all += 1;
        // The smoother's error is uncorrelated with what later readings add: Var(f − s) = u_f² − u_s².
        let u = (uf[k] * uf[k] - us[k] * us[k]).max(0.0).sqrt();
        let rounding = 1e-9 * uf[k];
        let d = (trace.velocity[k] - smooth[k]).abs();
        inside += usize::from(d <= 2.0 * u + rounding);
    }
    (all > 0).then(|| inside as f64 / all as f64)
}

/// A reference against which every fused method is late or early alike has a delay of its own.
fn reference_delay(rows: &[ComparisonRow]) -> Option<Finding> {
    let highest = rows.iter().fold(0.0f64, |m, r| m.max(r.rate));
    let fused = |r: &&ComparisonRow| matches!(r.family, Family::Fused | Family::OffLine);
    let mut delays: Vec<f64> = rows
        .iter()
        .filter(|r| r.rate == highest)
        .filter(fused)
        .filter_map(|r| r.agreement.delay)
        .collect();
    delays.sort_by(f64::total_cmp);
    let middle = *delays.get(delays.len() / 2)?;
    let alike = delays
        .iter()
        .all(|d| (d - middle).abs() < 0.2 * middle.abs());
    (delays.len() > 2 && alike && middle.abs() > 2.0 / highest).then(|| {
        let what = if middle < 0.0 { "late" } else { "early" };
        Finding::new(
            Severity::Warning,
            "reference-delay",
            format!(
                "the reference is {what}: every fused velocity differs from it by the same time"
            ),
        )
        .evidence(format!("{:.1} ms", 1e3 * middle.abs()))
        .advice("shift the reference by this time, else the errors are mostly its delay")
    })
}

/// Tuning at one rate of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TunedAtRate {
    /// Sample rate, Hz.
    pub rate: f64,
    /// What was found.
    pub result: TuneResult,
}

/// Answer of [`compare`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CompareResult {
    /// One row per method and rate.
    pub rows: Vec<ComparisonRow>,
    /// Seconds at the start that are not compared.
    pub skip: f64,
    /// Whether the reference is a truth that was given, or the smoother at the full rate.
    pub reference_is_truth: bool,
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
pub fn single_sensor_methods(source: Source) -> Vec<Method> {
    let alone = match source {
        Source::Position => vec![
            Method::FixedTime,
            Method::SavitzkyGolay {
                window: 5,
                degree: 2,
            },
        ],
        Source::Speed => vec![Method::SpeedReading],
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
/// the single-sensor methods and the published sweep. The start of integration alone is the record's, or the
/// first reference when it is unknown: it is the drift that counts.
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
    let mut findings = conditions(record);
    let slip = slip_search(record).ok();
    let pairing = pairing(record, slip.as_ref());
    findings.extend(pairing.iter().flat_map(|p| p.findings.iter().cloned()));
    findings.extend(slip.iter().flat_map(|s| s.findings.iter().cloned()));
    let chosen: Vec<Method> = if methods.is_empty() {
        single_sensor_methods(record.source)
            .into_iter()
            .chain(published_sweep())
            .collect()
    } else {
        methods.to_vec()
    };
    let reference = match truth {
        Some(truth) => truth.to_vec(),
        None => {
            findings.push(
                Finding::new(
                    Severity::Note,
                    "smoother-as-reference",
                    "no true velocity was given: errors are differences to the smoother at the full rate",
                )
                .advice("what both sensors have wrong alike does not show"),
            );
            let (part, _) = tuning_part(record, slip.as_ref());
            let mut tuned = paired_tuning(&part, &Tuning::default(), pairing.as_ref(), watch)?;
            match on_edges(&mut tuned, &part, record, watch)? {
                Some((_, run)) => run.smoothed.0,
                None => {
                    let constants = match slip.as_ref().is_some_and(|s| !s.slip.is_empty()) {
                        true => Constants::Held,
                        false => Constants::Fitted,
                    };
                    tuned.smooth(record, constants)?.velocity
                }
            }
        }
    };
    let mut started = record.clone();
    if started.initial_velocity.is_none() {
        started.initial_velocity = reference.first().copied();
    }
    let (alone, others): (Vec<Method>, Vec<Method>) = chosen
        .into_iter()
        .partition(|m| m.family() == Family::Acceleration);
    let mut rows = compare_methods(record, &reference, &others, decimations, skip)?;
    rows.extend(compare_methods(
        &started,
        &reference,
        &alone,
        decimations,
        skip,
    )?);
    let mut tuned = Vec::new();
    for &n in decimations {
        let slow = record.decimated(n)?;
        let rate = 1.0 / slow.sample_time;
        let named = (1e4 * rate).round() / 1e4;
        match tune(&slow, &Tuning::default(), watch) {
            Ok(result) => {
                rows.extend(compare_methods(
                    &result.tuned.corrected(record),
                    &reference,
                    &result.methods(),
                    &[n],
                    skip,
                )?);
                let at_rate = result.tuned.findings.iter().map(|f| {
                    Finding::new(f.severity(), f.code(), format!("{named} Hz: {}", f.what()))
                        .evidence(f.evidence_text())
                        .advice(f.advice_text())
                });
                findings.extend(at_rate);
                tuned.push(TunedAtRate { rate, result });
            }
            Err(error) if error.is_cancelled() => return Err(error),
            Err(error) => findings.push(
                Finding::new(
                    Severity::Note,
                    "not-tuned",
                    "too little is recorded to tune at this rate",
                )
                .evidence(format!("{named} Hz: {error}")),
            ),
        }
    }
    if truth.is_some() {
        findings.extend(reference_delay(&rows));
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
        reference,
        tuned,
        pairing,
        findings,
    })
}
