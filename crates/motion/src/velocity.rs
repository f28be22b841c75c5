//! Three questions to a record, answered as plain data: estimate, compare, tune.

use crate::{
    BiasChoice, ComparisonRow, Crossover, Family, Filter, KalmanModel, Method, MotionRecord,
    Ripple, Rule, SlipReport, SlipSearch, Trace, Tuned, Tuning, compare_methods,
    crossover_by_smoother, ripple,
};
use proofmass_core::Error;
use proofmass_uncertainty::{Finding, Severity};
use serde::Serialize;

/// Answer of [`tune`]: the model and the gains of every fused method, found without a truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TuneResult {
    /// Kalman model by maximum likelihood.
    pub tuned: Tuned,
    /// Two channels, closest to the smoother.
    pub two_channel: Crossover,
    /// Observer, closest to the smoother.
    pub observer: Crossover,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl TuneResult {
    /// The tuned methods: Kalman, its steady form, two channels, observer, smoother.
    pub fn methods(&self) -> Vec<Method> {
        let model = self.tuned.model;
        vec![
            Method::Kalman { model },
            self.two_channel.method,
            self.observer.method,
            Method::Smoother { model },
        ]
    }
}

/// Finds noise parameters and gains from the record alone.
///
/// # Errors
/// Of the record and of the search ([`Tuning::run`], [`crate::crossover`]).
pub fn tune(record: &MotionRecord, tuning: &Tuning) -> Result<TuneResult, Error> {
    let tuned = tuning.run(record)?;
    let skip = settle(record);
    let two_channel = crossover_by_smoother(Filter::TwoChannel, &tuned.model, record, skip)?;
    let observer = crossover_by_smoother(Filter::Observer, &tuned.model, record, skip)?;
    let findings = tuned.findings.clone();
    Ok(TuneResult {
        tuned,
        two_channel,
        observer,
        findings,
    })
}

/// A tenth of the record, at most a second: filters that start with a wrong velocity settle there.
fn settle(record: &MotionRecord) -> usize {
    let n = record.reading.len();
    ((1.0 / record.sample_time) as usize).min(n / 10)
}

/// Answer of [`estimate`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EstimateResult {
    /// Times of the samples, s.
    pub time: Vec<f64>,
    /// Velocity by the chosen method.
    pub trace: Trace,
    /// Velocity by the smoother of the same (or the tuned) model, with its uncertainty.
    pub smoother: Trace,
    /// The model the uncertainty rests on.
    pub model: KalmanModel,
    /// Share of the samples away from slip where filter and smoother agree within two standard uncertainties of
    /// their difference, √(u_f² − u_s²); `None` when the method states no uncertainty.
    pub agreement: Option<f64>,
    /// Slip and collisions; `None` for a record too short to look.
    pub slip: Option<SlipReport>,
    /// Repeating errors of the encoder; `None` when the axis hardly moves.
    pub ripple: Option<Ripple>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

/// Velocity of a record by a method, or by the Kalman filter with likelihood tuning when none is given.
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
) -> Result<EstimateResult, Error> {
    record.check()?;
    let n = record.reading.len();
    let mut findings = rate_findings(record);
    let window = SlipSearch::default().window.max(5.0 * record.sample_time);
    let blow = SlipSearch::default().blow.max(2.0 * record.sample_time);
    let search = SlipSearch {
        window,
        blow,
        ..SlipSearch::default()
    };
    let slip = search.run(record).ok();
    let margin = (window / record.sample_time).round() as usize;
    let slips = |k: usize| slip.as_ref().is_some_and(|s| s.slips(k, margin));
    let model = match method {
        Some(
            Method::Kalman { model } | Method::SteadyKalman { model } | Method::Smoother { model },
        ) => model,
        _ => {
            let stretch = longest(n, |k| !slips(k));
            let quiet = part(record, stretch.clone()).unwrap_or_else(|| record.clone());
            if quiet.reading.len() < n {
                findings.push(
                    Finding::new(
                        Severity::Note,
                        "tuned-on-a-part",
                        "the noise was found on the longest stretch without slip",
                    )
                    .evidence(format!(
                        "{:.3} s to {:.3} s of {:.3} s",
                        stretch.start as f64 * record.sample_time,
                        stretch.end as f64 * record.sample_time,
                        n as f64 * record.sample_time
                    )),
                );
            }
            let tuned = Tuning::default().run(&quiet)?;
            findings.extend(tuned.findings);
            tuned.model
        }
    };
    let method = method.unwrap_or(Method::Kalman { model });
    let trace = method.run(record)?;
    let smoother = Method::Smoother { model }.run(record)?;
    let agreement = agreement_share(&trace, &smoother, &slips);
    if let Some(share) = agreement.filter(|s| *s < 0.9) {
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
    if let Some(slip) = &slip {
        findings.extend(slip.findings.iter().cloned());
    }
    let ripple = ripple(record, circumference, |k| !slips(k)).ok();
    if let Some(ripple) = &ripple {
        findings.extend(ripple.findings.iter().cloned());
    }
    Ok(EstimateResult {
        time: record.times(),
        trace,
        smoother,
        model,
        agreement,
        slip,
        ripple,
        findings,
    })
}

/// Missing readings and a start in motion.
fn rate_findings(record: &MotionRecord) -> Vec<Finding> {
    let mut findings = Vec::new();
    let stride = record.reading_stride();
    let at: Vec<usize> = (0..record.reading.len())
        .filter(|&k| record.reading[k].is_some())
        .collect();
    let (first, last) = (
        at.first().copied().unwrap_or(0),
        at.last().copied().unwrap_or(0),
    );
    let due = (last - first) / stride + 1;
    if at.len() < due {
        findings.push(
            Finding::new(Severity::Note, "missing-readings", "readings are missing")
                .evidence(format!("{} of {due} readings missing", due - at.len()))
                .advice(
                    "fused methods coast on the acceleration there; the uncertainty grows with it",
                ),
        );
    }
    let Some(v0) = record.initial_velocity else {
        return findings;
    };
    // Slope of the first readings against the claim, in units of what quantisation explains.
    let early: Vec<usize> = at.iter().copied().take(20).collect();
    if early.len() == 20 {
        let positions = record.positions();
        let x = |k: usize| positions[k].unwrap_or(0.0);
        let span = (early[19] - early[0]) as f64 * record.sample_time;
        let mean = (x(early[19]) - x(early[0])) / span;
        let fastest = record.acceleration[..=early[19]]
            .iter()
            .fold(0.0f64, |m, a| m.max(a.abs()));
        let explained = record.increment.unwrap_or(0.0) / span + fastest * span;
        if (mean - v0).abs() > 3.0 * explained {
            findings.push(
                Finding::new(
                    Severity::Warning,
                    "start-in-motion",
                    "the record does not start at the stated velocity",
                )
                .evidence(format!(
                    "{mean:.4} over the first {span:.3} s, stated {v0:.4}"
                ))
                .advice("leave the initial velocity unknown"),
            );
        }
    }
    findings
}

/// Longest run of samples for which `good` holds.
fn longest(n: usize, good: impl Fn(usize) -> bool) -> std::ops::Range<usize> {
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
fn part(record: &MotionRecord, range: std::ops::Range<usize>) -> Option<MotionRecord> {
    let part = MotionRecord {
        reading: record.reading.get(range.clone())?.to_vec(),
        acceleration: record.acceleration.get(range.clone())?.to_vec(),
        initial_velocity: record.initial_velocity.filter(|_| range.start == 0),
        ..*record
    };
    (part.reading.iter().flatten().count() >= 100).then_some(part)
}

fn agreement_share(trace: &Trace, smoother: &Trace, slips: &impl Fn(usize) -> bool) -> Option<f64> {
    let (uf, us) = (
        trace.standard_uncertainty.as_ref()?,
        smoother.standard_uncertainty.as_ref()?,
    );
    let (mut inside, mut all) = (0usize, 0usize);
    for k in 0..trace.velocity.len() {
        if slips(k) {
            continue;
        }
        all += 1;
        // The smoother's error is uncorrelated with what later readings add: Var(f − s) = u_f² − u_s².
        let u = (uf[k] * uf[k] - us[k] * us[k]).max(0.0).sqrt();
        let rounding = 1e-9 * uf[k];
        let d = (trace.velocity[k] - smoother.velocity[k]).abs();
        inside += usize::from(d <= 2.0 * u + rounding);
    }
    (all > 0).then(|| inside as f64 / all as f64)
}

/// Answer of [`compare`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CompareResult {
    /// One row per method and rate.
    pub rows: Vec<ComparisonRow>,
    /// Whether the reference is a truth that was given, or the smoother at the full rate.
    pub reference_is_truth: bool,
    /// The reference at the full rate.
    pub reference: Vec<f64>,
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

/// Single-sensor methods: differences, a fit, and the trapezoid.
pub fn single_sensor_methods() -> Vec<Method> {
    vec![
        Method::FixedTime,
        Method::SavitzkyGolay {
            window: 5,
            degree: 2,
        },
        Method::Integration {
            rule: Rule::Trapezoid,
            offset: 0.0,
        },
    ]
}

/// Compares methods at decimated rates; every rate also gets the fused methods tuned on its own samples.
///
/// `truth` is a velocity per sample, or the smoother of the full rate stands in. An empty `methods` stands for
/// the single-sensor methods and the published sweep.
///
/// # Errors
/// Of the record, the search and the methods.
pub fn compare(
    record: &MotionRecord,
    truth: Option<&[f64]>,
    methods: &[Method],
    decimations: &[usize],
    skip: f64,
) -> Result<CompareResult, Error> {
    let mut findings = rate_findings(record);
    let chosen: Vec<Method> = if methods.is_empty() {
        single_sensor_methods()
            .into_iter()
            .chain(published_sweep())
            .collect()
    } else {
        methods.to_vec()
    };
    let reference = match truth {
        Some(truth) => truth.to_vec(),
        None => {
            let tuned = Tuning::default().run(record)?;
            findings.extend(tuned.findings);
            findings.push(Finding::new(
                Severity::Note,
                "smoother-as-reference",
                "no true velocity was given: errors are differences to the smoother at the full rate",
            ));
            tuned.model.smooth(record)?.velocity
        }
    };
    let mut rows = compare_methods(record, &reference, &chosen, decimations, skip)?;
    for &n in decimations {
        let slow = record.decimated(n)?;
        match tune(
            &slow,
            &Tuning {
                bias: BiasChoice::Automatic,
                ..Tuning::default()
            },
        ) {
            Ok(tuned) => {
                rows.extend(compare_methods(
                    record,
                    &reference,
                    &tuned.methods(),
                    &[n],
                    skip,
                )?);
            }
            Err(error) => findings.push(
                Finding::new(
                    Severity::Note,
                    "not-tuned",
                    "too little is recorded to tune at this rate",
                )
                .evidence(format!("{:.3} Hz: {error}", 1.0 / slow.sample_time)),
            ),
        }
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
        reference_is_truth: truth.is_some(),
        reference,
        findings,
    })
}
