//! What the fit of a temperature sweep gives: coefficients of every axis with one joint covariance.

use super::steps::OutputStep;
use super::warm_up::SelfHeating;
use super::{Attitude, Blocks, EnvironmentalCourse, Hysteresis};
use proofmass_core::THERMAL_ORDER;
use proofmass_uncertainty::{Estimate, Finding, Quantity};
use serde::Serialize;

/// One order of the polynomial on one axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct OrderFit {
    /// Largest power.
    pub order: usize,
    /// Akaike's criterion, corrected for the number of blocks, less that of the best order.
    pub aicc: f64,
    /// Weight by AICc among the orders.
    pub weight: f64,
    /// RMS error of blocks that were left out, ten stretches of time in turn, m/s².
    pub cross_validation: f64,
    /// F of the last power against the order below, correlated noise accounted for; `None` for the first.
    pub f: Option<f64>,
    /// Value of F that one in twenty such tests exceeds without such a power.
    pub f_limit: f64,
    /// Mean slope over the range, m/s² per K.
    pub slope: f64,
    /// Its standard uncertainty at this order.
    pub slope_uncertainty: f64,
}

/// One axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AxisFit {
    /// Every order that was fitted.
    pub orders: Vec<OrderFit>,
    /// Coefficients of d, d², d³ of the bias (of the output, in one attitude), m/s² per Kᵏ.
    pub bias: [f64; THERMAL_ORDER],
    /// Coefficients of d, d², d³ of the relative scale, 1/Kᵏ, where attitudes tell them apart.
    pub scale: Option<[f64; THERMAL_ORDER]>,
    /// What heating and cooling do differently, where both are there.
    pub hysteresis: Option<Hysteresis>,
    /// λ: output per rate of the temperature (the mean slope times the time by which the thermometer lags), m/s² per K/s,
    /// and its standard uncertainty, where it can be told.
    pub lag: Option<[f64; 2]>,
    /// Self-heating after switching on, where it is part of the model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub self_heating: Option<SelfHeating>,
    /// The loudest step that no temperature makes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<OutputStep>,
    /// Mean of the fitted change over the blocks, m/s².
    pub mean_change: f64,
    /// Residuals of the blocks, m/s².
    pub residuals: Vec<f64>,
}

impl AxisFit {
    /// Change of the bias (of the output, in one attitude) from the reference, m/s².
    pub fn change(&self, d: f64) -> f64 {
        let [a, b, c] = self.bias;
        d * (a + d * (b + d * c))
    }
}

/// Temperature coefficients with one joint covariance.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TemperatureFit {
    /// T₀, °C.
    pub reference: f64,
    /// Lowest and highest temperature, °C.
    pub range: [f64; 2],
    /// Largest order.
    pub largest_order: usize,
    /// Whether scale and bias could be told apart: the sensor was swept in attitudes far enough from each other.
    pub scale: bool,
    /// The axes: three, or one.
    pub axes: Vec<AxisFit>,
    /// `slope.x` … (mean over the range), `bias.x.T1` … (`output.x.T1` … in one attitude), `scale.x.T1` …; of one axis `slope`,
    /// `bias.T1` …; of other quantities of the surroundings `bias.x.humidity` …
    pub estimate: Estimate,
    /// Other quantities of the surroundings, in the order in which they were given.
    pub environment: Vec<EnvironmentalCourse>,
    /// The block means.
    pub blocks: Blocks,
    /// What to doubt.
    pub findings: Vec<Finding>,
    /// +1 heating, −1 cooling of every block.
    pub direction: Vec<f64>,
}

impl TemperatureFit {
    /// Time by which the thermometer lags behind what the outputs follow, s, with its standard uncertainty: the lag of the
    /// outputs over their mean slopes, all axes together; `None` where the recording does not tell it.
    pub fn thermometer_lag(&self) -> Option<[f64; 2]> {
        let (mut product, mut square) = (0.0, 0.0);
        for (a, axis) in self.axes.iter().enumerate() {
            let [lag, u] = axis.lag?;
            let slope = self.slope(a)?.value;
            if u > 0.0 {
                product += slope * lag / (u * u);
                square += slope * slope / (u * u);
            }
        }
        (square > 0.0).then(|| [product / square, 1.0 / square.sqrt()])
    }

    /// Mean slope of an axis over the range.
    pub fn slope(&self, axis: usize) -> Option<Quantity> {
        self.estimate.get(&self.blocks.parameter("slope", axis))
    }

    /// The axes with their names for people.
    pub fn named_axes(&self) -> impl Iterator<Item = (&'static str, &AxisFit)> {
        self.blocks.names().iter().copied().zip(&self.axes)
    }

    /// The attitudes the sensor was found in.
    pub fn attitudes(&self) -> &[Attitude] {
        &self.blocks.attitudes
    }
}
