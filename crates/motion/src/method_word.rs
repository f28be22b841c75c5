//! Methods as words: `observer:5,25`.

use crate::{BiasModel, CountingModel, IntegratorRule, KalmanModel, Method};
use std::str::FromStr;

/// Every method as a word with its settings, for help and messages.
pub const METHODS: &str = "fixed-time, fixed-time:SAMPLES, fixed-position:EDGES, mixed-time:TIMEOUT, backward-difference:ORDER, savitzky-golay:WINDOW,DEGREE, \
    tracking-loop:BANDWIDTH, resolver-loop:BANDWIDTH, speed, trapezoid, simpson, three-eighths, boole, closed-5, closed-6, midpoint, open-3, milne, open-5, open-6, tick, adams-moulton-3 (each also as :OFFSET), newmark:GAMMA,BETA (also as :GAMMA,BETA,OFFSET), high-pass:CORNER,ORDER, zero-phase:CORNER,ORDER (each also behind a rule: tick-high-pass:CORNER,ORDER), two-channel:K1,K2, \
    observer:KX,KV, offset-observer:KX,KV,KB, adaptive-observer:KX,KV,RATE,FLOOR, kalman:Q,R, steady-kalman:Q,R, counting:Q,EDGE,OFFSET, counting-smoother:Q,EDGE,OFFSET, \
    smoother:Q,R (each also as :Q,R,WALK,START with an offset that walks), gauss-markov:Q,R,DEVIATION,TIME (Kalman with an offset that forgets)";

impl FromStr for Method {
    type Err = String;

    /// Reads `name` or `name:number,number`.
    fn from_str(text: &str) -> Result<Self, String> {
        method(text)
    }
}

impl Method {
    /// The word that [`str::parse`] takes, with five digits of each setting where it has them.
    pub fn word(&self) -> Option<String> {
        let noise = |name: &str, model: &KalmanModel| {
            let noise = format!(
                "{name}:{:.4e},{:.4e}",
                model.acceleration_noise, model.reading_noise
            );
            match model.bias {
                Some(BiasModel::RandomWalk { density, initial }) => {
                    Some(format!("{noise},{density:.3e},{initial:.3}"))
                }
                Some(BiasModel::GaussMarkov { deviation, time }) if name == "kalman" => {
                    let noise = noise.replace("kalman", "gauss-markov");
                    Some(format!("{noise},{deviation:.3e},{time:.4}"))
                }
                Some(BiasModel::GaussMarkov { .. }) => None,
                None => Some(noise),
            }
        };
        match self {
            Self::Kalman { model } => noise("kalman", model),
            Self::SteadyKalman { model } => noise("steady-kalman", model),
            Self::Smoother { model } => noise("smoother", model),
            Self::Counting { model } | Self::CountingSmoother { model } => {
                let name = match self {
                    Self::Counting { .. } => "counting",
                    _ => "counting-smoother",
                };
                Some(format!(
                    "{name}:{:.4e},{:.4e},{:.3}",
                    model.acceleration_noise, model.edge, model.offset
                ))
            }
            Self::HighPass {
                rule,
                order,
                corner,
                zero_phase,
            } => {
                let of = match rule {
                    IntegratorRule::Trapezoid => String::new(),
                    rule => format!("{}-", rule.name()),
                };
                let filter = if *zero_phase {
                    "zero-phase"
                } else {
                    "high-pass"
                };
                Some(format!("{of}{filter}:{corner:.5},{order}"))
            }
            Self::Integration { rule, offset } => Some(match *offset {
                0.0 => rule.name().to_owned(),
                offset => format!("{}:{offset:.5}", rule.name()),
            }),
            Self::TwoChannel { k1, k2 } => Some(format!("two-channel:{k1:.5},{k2:.5}")),
            Self::Observer { k_x, k_v } => Some(format!("observer:{k_x:.5},{k_v:.5}")),
            _ => None,
        }
    }
}

fn method(text: &str) -> Result<Method, String> {
    let (name, rest) = text.split_once(':').unwrap_or((text, ""));
    let numbers: Vec<f64> = rest
        .split(',')
        .map(str::trim)
        .filter(|n| !n.is_empty())
        .map(|n| {
            n.parse::<f64>()
                .ok()
                .filter(|v| v.is_finite())
                .ok_or_else(|| format!("{n:?} in {text:?} is no number"))
        })
        .collect::<Result<_, _>>()?;
    let whole = |v: f64| -> Result<usize, String> {
        if v >= 0.0 && v.fract() == 0.0 && v < 1e6 {
            Ok(v as usize)
        } else {
            Err(format!("{v} in {text:?} must be a whole number"))
        }
    };
    let integration = |rule| match numbers[..] {
        [] => Some(Method::Integration { rule, offset: 0.0 }),
        [offset] => Some(Method::Integration { rule, offset }),
        _ => None,
    };
    let found = match (name, &numbers[..]) {
        ("fixed-time", []) => Some(Method::FixedTime),
        ("fixed-time", &[samples]) => Some(Method::LongWindow {
            samples: whole(samples)?,
        }),
        ("fixed-position", &[edges]) => Some(Method::FixedPosition {
            edges: whole(edges)?,
        }),
        ("mixed-time", &[timeout]) => Some(Method::MixedTime { timeout }),
        ("newmark", &[gamma, beta]) => Some(Method::Newmark {
            gamma,
            beta,
            offset: 0.0,
        }),
        ("newmark", &[gamma, beta, offset]) => Some(Method::Newmark {
            gamma,
            beta,
            offset,
        }),
        _ if name.ends_with("high-pass") || name.ends_with("zero-phase") => {
            let (of, zero_phase) = match name.strip_suffix("zero-phase") {
                Some(of) => (of, true),
                None => (name.trim_end_matches("high-pass"), false),
            };
            let rule = match of.strip_suffix('-') {
                Some(of) => rule_of(of),
                None => of.is_empty().then_some(IntegratorRule::Trapezoid),
            };
            match (rule, &numbers[..]) {
                (Some(rule), &[corner, order]) => Some(Method::HighPass {
                    rule,
                    order: whole(order)?,
                    corner,
                    zero_phase,
                }),
                _ => None,
            }
        }
        ("gauss-markov", &[q, r, deviation, time]) => Some(Method::Kalman {
            model: KalmanModel {
                bias: Some(BiasModel::GaussMarkov { deviation, time }),
                ..KalmanModel::new(q, r)
            },
        }),
        ("speed", []) => Some(Method::SpeedReading),
        ("backward-difference", &[order]) => Some(Method::BackwardDifference {
            order: whole(order)?,
        }),
        ("savitzky-golay", &[window, degree]) => Some(Method::SavitzkyGolay {
            window: whole(window)?,
            degree: whole(degree)?,
        }),
        ("tracking-loop", &[bandwidth]) => Some(Method::TrackingLoop { bandwidth }),
        ("resolver-loop", &[bandwidth]) => Some(Method::ResolverLoop { bandwidth }),
        ("two-channel", &[k1, k2]) => Some(Method::TwoChannel { k1, k2 }),
        ("observer", &[k_x, k_v]) => Some(Method::Observer { k_x, k_v }),
        ("offset-observer", &[k_x, k_v, k_b]) => Some(Method::OffsetObserver { k_x, k_v, k_b }),
        ("adaptive-observer", &[k_x, k_v, rate, floor]) => Some(Method::AdaptiveObserver {
            k_x,
            k_v,
            rate,
            floor,
        }),
        ("counting" | "counting-smoother", &[acceleration_noise, edge, offset]) => {
            let model = CountingModel {
                acceleration_noise,
                edge,
                offset,
                walk: 0.0,
            };
            Some(match name {
                "counting" => Method::Counting { model },
                _ => Method::CountingSmoother { model },
            })
        }
        ("kalman", noise) => model(noise).map(|model| Method::Kalman { model }),
        ("steady-kalman", noise) => model(noise).map(|model| Method::SteadyKalman { model }),
        ("smoother", noise) => model(noise).map(|model| Method::Smoother { model }),
        _ => rule_of(name).and_then(integration),
    };
    found.ok_or_else(|| match form(name) {
        Some(form) => format!("{text:?} has not the numbers of this method: write {form}"),
        None => format!(
            "unknown method {name:?}: usual ones are fixed-time, savitzky-golay:WINDOW,DEGREE, trapezoid, high-pass:CORNER,ORDER, observer:KX,KV, kalman:Q,R and smoother:Q,R"
        ),
    })
}

/// How a method of this name is written with its settings; of several forms the last, which has the most settings.
fn form(name: &str) -> Option<&'static str> {
    let forms = METHODS
        .split(", ")
        .map(|form| form.split(" (").next().unwrap_or(form).trim());
    forms
        .filter(|form| form.split(':').next() == Some(name))
        .last()
}

/// The integration rule of a name.
fn rule_of(name: &str) -> Option<IntegratorRule> {
    IntegratorRule::ALL.into_iter().find(|r| r.name() == name)
}

/// q and R, and of an offset that walks its density and its deviation at the start.
fn model(numbers: &[f64]) -> Option<KalmanModel> {
    match *numbers {
        [q, r] => Some(KalmanModel::new(q, r)),
        [q, r, density, initial] => Some(KalmanModel {
            bias: Some(BiasModel::RandomWalk { density, initial }),
            ..KalmanModel::new(q, r)
        }),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_become_methods() {
        assert_eq!(
            method("observer:5,25"),
            Ok(Method::Observer {
                k_x: 5.0,
                k_v: 25.0
            })
        );
        assert_eq!(method("fixed-time"), Ok(Method::FixedTime));
        assert_eq!(
            method("fixed-time:20"),
            Ok(Method::LongWindow { samples: 20 })
        );
        let word = "gauss-markov:4.0000e-4,1.0000e-8,2.000e-2,30.0000";
        assert_eq!(method(word).unwrap().word().unwrap(), word);
        for wrong in [
            "high-pass:1",
            "newmark:1",
            "fixed-position:1.5",
            "mixed-time",
            "gauss-markov:1,2,3",
            "observer",
            "observer:5",
            "observer:5,x",
            "savitzky-golay:5.5,2",
            "nothing",
            "kalman:nan,1",
            "kalman:1,2,3",
            "resolver-loop",
        ] {
            assert!(method(wrong).is_err(), "{wrong}");
        }
    }
}
