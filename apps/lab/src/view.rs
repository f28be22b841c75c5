//! The present as data: what the page is told ten times a second.

use crate::session::Session;
use crate::simulated::{Fault, Switch};
use crate::status::Status;
use serde::Serialize;
use std::collections::VecDeque;

/// Points of a curve that the page draws: two for each of its pixels.
const PIXELS: usize = 600;
/// Periods of a curve, at least two.
const PERIODS: f64 = 6.0;

/// What is seen now.
#[derive(Debug, Serialize)]
pub struct View {
    /// Where the walk stands.
    #[serde(flatten)]
    pub status: Status,
    /// Why nobody can say that the drive is at zero.
    pub alarm: Option<&'static str>,
    /// What the acquisition does.
    pub doing: &'static str,
    /// Acceleration of the reference, m/s².
    pub acceleration: Option<f64>,
    /// Amplitude of the drive, V.
    pub drive: f64,
    /// Share of the recording that is behind.
    pub recorded_share: f64,
    /// Curves of the channels.
    pub curves: Vec<Curve>,
    /// Seconds that the curves show.
    pub seconds: f64,
    /// The result so far.
    pub result: Option<Found>,
    /// Why there is none, or that one is on its way.
    pub result_note: Option<String>,
    /// The fault that is switched on.
    pub fault: Option<&'static str>,
}

/// A channel, thinned to the least and the largest value behind each pixel.
#[derive(Debug, Serialize)]
pub struct Curve {
    /// Name.
    pub name: String,
    /// Least values, V.
    pub low: Vec<f32>,
    /// Largest values, V.
    pub high: Vec<f32>,
}

/// A result.
#[derive(Debug, Serialize)]
pub struct Found {
    /// Runs it is made of.
    pub runs: usize,
    /// Principal quantities as text: name, value with unit, relative expanded uncertainty.
    pub rows: Vec<[String; 3]>,
}

/// The present of a session.
pub fn of(session: &Session, switch: Option<&Switch>) -> View {
    let status = session.status.lock().clone();
    let frequency = status.run.as_ref().map_or(100.0, |r| r.frequency);
    let rate = session.identity.rate;
    let wanted = (PERIODS / frequency).clamp(0.01, 1.0);
    let live = session.shared.live();
    let samples = live
        .channels
        .first()
        .map_or(0, VecDeque::len)
        .min((wanted * rate) as usize);
    let curves = live.channels.iter().zip(&session.identity.channels);
    let curves = curves.map(|(c, name)| thinned(name, c, samples)).collect();
    let (doing, acceleration, drive, recorded_share) =
        (live.phase, live.acceleration, live.drive, live.recorded);
    drop(live);
    let known = session.evaluated().clone();
    let working = known
        .at_work
        .map(|runs| format!("a result of {runs} runs is being calculated"));
    View {
        alarm: session.shared.alarm(),
        doing,
        acceleration,
        drive,
        recorded_share,
        curves,
        seconds: samples as f64 / rate,
        result_note: working.or(known.lacks),
        result: known.result.map(|(result, runs)| Found {
            runs,
            rows: rows(result.quantities()),
        }),
        status,
        fault: switch.map(|s| {
            let found = Fault::ALL.iter().find(|(f, _)| *f == s.get());
            found.map_or("none", |(_, word)| word)
        }),
    }
}

fn thinned(name: &str, samples: &VecDeque<f64>, count: usize) -> Curve {
    let from = samples.len() - count.min(samples.len());
    let bins = PIXELS.min(count);
    let edge = |bin: usize| from + bin * count / bins.max(1);
    let pairs = (0..bins).map(|bin| {
        let part = samples.range(edge(bin)..edge(bin + 1).max(edge(bin) + 1).min(samples.len()));
        part.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(*v), h.max(*v))
        })
    });
    let (low, high) = pairs.map(|(l, h)| (l as f32, h as f32)).unzip();
    Curve {
        name: name.to_owned(),
        low,
        high,
    }
}

/// The main sensitivities: of three axes those on the diagonal.
fn rows(quantities: &[proofmass::documents::StatedQuantity]) -> Vec<[String; 3]> {
    let main = |name: &str| {
        let head = name.split("modulus").next().unwrap_or_default();
        let shown = ["", "S.xx.", "S.yy.", "S.zz."].contains(&head);
        shown && name.contains("modulus")
    };
    let shown = quantities.iter().filter(|q| main(&q.name));
    shown
        .map(|q| {
            let name = q
                .name
                .replace(".modulus", "")
                .replace("[frequency=", " at ")
                .replace(']', " Hz");
            let (value, unit) = match q.unit.as_str() {
                "V/(m/s²)" => (1e3 * q.value, "mV/(m/s²)"),
                unit => (q.value, unit),
            };
            let relative = 100.0 * q.expanded / q.value.abs();
            [
                name,
                format!("{value:.4} {unit}"),
                format!("{relative:.2} %"),
            ]
        })
        .take(60)
        .collect()
}
