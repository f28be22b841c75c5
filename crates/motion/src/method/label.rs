//! Methods with their settings as short texts, for legends and tables.

use super::Method;
use crate::{BiasModel, IntegratorRule, KalmanModel};

impl Method {
    /// Short text with the settings.
    pub fn label(&self) -> String {
        match self {
            Self::SpeedReading => "speed as read".into(),
            Self::FixedTime => "fixed time (M)".into(),
            Self::LongWindow { samples } => format!("fixed time (M), {samples} samples"),
            Self::FixedPosition { edges } => format!("fixed position (T), {edges} edges"),
            Self::MixedTime { timeout } => {
                format!("mixed (M/T), standstill after {} s", digits(*timeout))
            }
            Self::BackwardDifference { order } => format!("backward difference, order {order}"),
            Self::SavitzkyGolay { window, degree } => {
                format!("Savitzky-Golay, {window} points, degree {degree}")
            }
            Self::TrackingLoop { bandwidth } => {
                format!("tracking loop, b = {} rad/s", digits(*bandwidth))
            }
            Self::ResolverLoop { bandwidth } => {
                format!("resolver loop, b = {} rad/s", digits(*bandwidth))
            }
            Self::Integration { rule, offset } => {
                let name = rule.name();
                if *offset == 0.0 {
                    format!("integration, {name}")
                } else {
                    format!("integration, {name}, offset {} removed", digits(*offset))
                }
            }
            Self::Newmark {
                gamma,
                beta,
                offset,
            } => {
                let name = format!("Newmark, γ = {}, β = {}", digits(*gamma), digits(*beta));
                if *offset == 0.0 {
                    name
                } else {
                    format!("{name}, offset {} removed", digits(*offset))
                }
            }
            Self::HighPass {
                rule,
                order,
                corner,
                zero_phase,
            } => format!(
                "integration{}, high-pass of order {order} at {} Hz{}",
                match rule {
                    IntegratorRule::Trapezoid => String::new(),
                    rule => format!(", {}", rule.label()),
                },
                digits(*corner),
                if *zero_phase { ", zero-phase" } else { "" }
            ),
            Self::TwoChannel { k1, k2 } => {
                format!("two channels, k1 = {}, k2 = {}", digits(*k1), digits(*k2))
            }
            Self::Observer { k_x, k_v } => {
                format!("observer, kx = {}, kv = {}", digits(*k_x), digits(*k_v))
            }
            Self::OffsetObserver { k_x, k_v, k_b } => format!(
                "observer with offset, kx = {}, kv = {}, kb = {}",
                digits(*k_x),
                digits(*k_v),
                digits(*k_b)
            ),
            Self::AdaptiveObserver { k_x, k_v, rate, .. } => format!(
                "adaptive observer, kx = {}, kv = {}, rate {}",
                digits(*k_x),
                digits(*k_v),
                digits(*rate)
            ),
            Self::Kalman { model } => format!("Kalman, {}", settings(model)),
            Self::SteadyKalman { model } => format!("Kalman, steady gain, {}", settings(model)),
            Self::Counting { model } => {
                format!("Kalman on edges, q = {}", digits(model.acceleration_noise))
            }
            Self::CountingSmoother { model } => {
                format!(
                    "smoother on edges, q = {}",
                    digits(model.acceleration_noise)
                )
            }
            Self::Smoother { model } => format!("smoother, {}", settings(model)),
        }
    }
}

fn settings(model: &KalmanModel) -> String {
    let bias = match model.bias {
        None => "",
        Some(BiasModel::RandomWalk { density: 0.0, .. }) => ", offset constant",
        Some(BiasModel::RandomWalk { .. }) => ", offset random walk",
        Some(BiasModel::GaussMarkov { .. }) => ", offset Gauss-Markov",
    };
    format!(
        "q = {}, R = {}{bias}",
        digits(model.acceleration_noise),
        digits(model.reading_noise)
    )
}

/// Four digits, without the zeros that say nothing.
fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    if rounded == 0.0 || (1e-3..1e5).contains(&rounded.abs()) {
        rounded.to_string()
    } else {
        format!("{rounded:e}")
    }
}
