//! What a noise result says to a filter of the bias.

use crate::trouble::{Result, Trouble};
use proofmass_core::velocity::BiasModel;
use proofmass_io::Unit;
use proofmass_noise::{Analysis, ChannelAnalysis, CoefficientFit, GaussMarkov, Term};
use proofmass_static::BiasNoise;
use serde::{Deserialize, Serialize};
use std::f64::consts::{LN_2, PI};

/// Noise of one axis: what a noise analysis found of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct AxisNoise {
    /// White noise N, (m/s²)/√Hz, two-sided.
    pub white: f64,
    /// Bias instability B, m/s²; 0 without one.
    #[serde(default)]
    pub flicker: f64,
    /// Random walk K, (m/s²)·√Hz; 0 without one.
    #[serde(default)]
    pub walk: f64,
    /// Whether that is an upper limit.
    #[serde(default)]
    pub walk_is_limit: bool,
    /// First-order Gauss–Markov processes.
    #[serde(default)]
    pub markov: Vec<GaussMarkov>,
    /// Relative standard uncertainty of the term that moves the bias most.
    #[serde(default)]
    pub uncertainty: f64,
    /// Standard uncertainty of the bias before the first rest, m/s².
    #[serde(default = "default_initial")]
    pub initial: f64,
}

fn default_initial() -> f64 {
    AxisNoise::INITIAL
}

/// Euler's constant γ.
const EULER_GAMMA: f64 = 0.577_215_664_901_532_9;
/// Smallest and largest number that means something here, in units of m, s and Hz; squares of all between are numbers too.
const SMALLEST: f64 = 1e-15;
const LARGEST: f64 = 1e15;
/// Allan variance of flicker noise over B².
const FLOOR: f64 = 2.0 * LN_2 / PI;

impl AxisNoise {
    /// A bias of which nothing is known: a tenth of g.
    pub const INITIAL: f64 = 1.0;

    /// White noise and a random walk.
    pub fn walk(white: f64, walk: f64) -> Self {
        Self {
            white,
            flicker: 0.0,
            walk,
            walk_is_limit: false,
            markov: Vec::new(),
            uncertainty: 0.0,
            initial: Self::INITIAL,
        }
    }

    /// White noise and one Gauss–Markov process: its standard deviation and correlation time.
    pub fn markov(white: f64, standard_deviation: f64, correlation_time: f64) -> Self {
        Self {
            markov: vec![GaussMarkov {
                standard_deviation,
                correlation_time,
            }],
            ..Self::walk(white, 0.0)
        }
    }

    /// Of the channels of a noise result: those of these names, else its three in their order, else its only one for all.
    ///
    /// # Errors
    /// Channels that cannot be told; units that are no acceleration; an analysis without white noise or a bias that moves.
    pub fn of(analysis: &Analysis, columns: [&str; 3]) -> Result<[Self; 3]> {
        let channels = &analysis.channels;
        let named = columns.map(|name| channels.iter().find(|c| c.name == name));
        let chosen = match (named, channels.as_slice()) {
            ([Some(x), Some(y), Some(z)], _) => [x, y, z],
            (_, [x, y, z]) => [x, y, z],
            (_, [one]) => [one; 3],
            _ => {
                let names: Vec<&str> = channels.iter().map(|c| c.name.as_str()).collect();
                return Err(Trouble::data(format!(
                    "the noise result has the channels {}, the recording {}",
                    names.join(", "),
                    columns.join(", ")
                ))
                .with_hint("analyse the noise of the three axes alone, in the order x, y, z"));
            }
        };
        let [x, y, z] = chosen.map(Self::of_channel);
        Ok([x?, y?, z?])
    }

    /// The coefficients of a channel, and what brings its unit to m/s².
    pub(crate) fn fit_of(channel: &ChannelAnalysis) -> Result<(&CoefficientFit, f64)> {
        let name = &channel.name;
        let factor = match Unit::recognise(&channel.unit) {
            Some(unit) if unit.is_acceleration() => unit.si().1,
            _ => {
                return Err(Trouble::data(format!(
                    "the noise of {name} is in {}, which is no acceleration",
                    channel.unit
                ))
                .with_hint(
                    "analyse a recording in g or m/s², or give proofmass noise --unit and --scale",
                ));
            }
        };
        let Some(fit) = &channel.whittle else {
            return Err(
                Trouble::data(format!("the noise result has no coefficients of {name}")).with_hint(
                    "record the noise for longer: coefficients need thousands of samples",
                ),
            );
        };
        Ok((fit, factor))
    }

    fn of_channel(channel: &ChannelAnalysis) -> Result<Self> {
        let name = &channel.name;
        let (fit, factor) = Self::fit_of(channel)?;
        if fit.model.white <= 0.0 {
            return Err(
                Trouble::data(format!("the noise result has no white noise of {name}")).with_hint(
                    "give --white and --walk, or analyse a recording that resolves the noise",
                ),
            );
        }
        let markov: Vec<GaussMarkov> = fit
            .model
            .gauss_markov
            .iter()
            .filter(|m| m.standard_deviation * factor >= SMALLEST)
            .map(|m| GaussMarkov {
                standard_deviation: m.standard_deviation * factor,
                ..*m
            })
            .collect();
        // Filters take the most likely values, identified or not; a bias that cannot move is never right.
        let (flicker, mut walk) = (fit.model.flicker, fit.model.random_walk);
        let walk_is_limit = walk <= 0.0 && flicker <= 0.0 && markov.is_empty();
        if walk_is_limit {
            walk = fit.random_walk_or_limit().0;
        }
        let noise = Self {
            white: fit.model.white * factor,
            flicker: flicker * factor,
            walk: walk * factor,
            walk_is_limit,
            uncertainty: spread(fit, flicker, walk),
            markov,
            initial: Self::INITIAL,
        };
        if noise.flicker <= 0.0 && noise.walk <= 0.0 && noise.markov.is_empty() {
            return Err(Trouble::data(format!(
                "the noise result does not say how the bias of {name} moves"
            ))
            .with_hint("record the noise for longer, or give --walk"));
        }
        Ok(noise)
    }

    pub(super) fn check(&self) -> Result<()> {
        let mut named = vec![
            ("white noise", self.white, true),
            ("bias instability", self.flicker, false),
            ("random walk", self.walk, false),
            ("relative uncertainty", self.uncertainty, false),
            ("initial uncertainty of the bias", self.initial, true),
        ];
        for m in &self.markov {
            named.push((
                "deviation of a Gauss–Markov process",
                m.standard_deviation,
                true,
            ));
            named.push((
                "correlation time of a Gauss–Markov process",
                m.correlation_time,
                true,
            ));
        }
        for (name, value, positive) in named {
            let least = if positive { SMALLEST } else { 0.0 };
            if !(least..=LARGEST).contains(&value) {
                return Err(Trouble::request(format!(
                    "the {name} of the bias filter cannot be {value:e}"
                ))
                .with_hint("units are those of m, s and Hz; from 1e-15 to 1e15"));
            }
        }
        Ok(())
    }

    /// The process the filter tracks: one Gauss–Markov process where nothing else moves the bias, else the random walk
    /// that moves as much over the time between rests.
    ///
    /// Flicker noise has no process of one state. Over the time T between rests, or where that is longer the time at which
    /// white noise has sunk to its Allan variance (2 ln 2/π) B², it moves by (2/π) B² (γ + ln π f_s T) in the mean square, its
    /// structure function at the rate f_s; the walk does as much.
    pub(super) fn model(&self, spacing: f64, rate: f64) -> BiasNoise {
        match self.markov.as_slice() {
            [m] if self.walk == 0.0 && self.flicker == 0.0 => BiasNoise {
                white: self.white,
                model: BiasModel::GaussMarkov {
                    deviation: m.standard_deviation,
                    time: m.correlation_time,
                },
                offset: self.initial,
            },
            _ => BiasNoise {
                white: self.white,
                model: BiasModel::RandomWalk {
                    density: self.density(spacing, rate),
                    initial: self.initial,
                },
                offset: 0.0,
            },
        }
    }

    fn density(&self, spacing: f64, rate: f64) -> f64 {
        let floor = FLOOR * self.flicker * self.flicker;
        let flicker = if floor > 0.0 {
            let time = spacing.max(self.white * self.white / floor);
            let moves = EULER_GAMMA + (PI * rate * time).max(1.0).ln();
            2.0 / PI * self.flicker * self.flicker * moves / time
        } else {
            0.0
        };
        let markov = |m: &GaussMarkov| {
            2.0 * m.standard_deviation * m.standard_deviation / m.correlation_time
        };
        self.walk * self.walk + flicker + self.markov.iter().map(markov).sum::<f64>()
    }

    /// Time in which the bias moves by as much as it is known, s.
    pub(super) fn moves_in(&self, spacing: f64, rate: f64) -> f64 {
        match self.model(spacing, rate).model {
            BiasModel::GaussMarkov { time, .. } => time,
            BiasModel::RandomWalk { density, .. } => self.white / density.sqrt(),
        }
    }
}

/// Relative standard uncertainty of the term that moves the bias most; of a limit there is none.
fn spread(fit: &CoefficientFit, flicker: f64, walk: f64) -> f64 {
    // Flicker with the Allan variance of a walk is its equal at T = 3 · 0.4413 B²/K²: the one that leads at the time at
    // which white noise has sunk to the other is the one that matters.
    let walks_sooner =
        walk > 0.0 && fit.model.white * walk * 3f64.sqrt() >= 3.0 * FLOOR * flicker * flicker;
    let leading = if !fit.model.gauss_markov.is_empty() {
        Term::GaussMarkov
    } else if walks_sooner {
        Term::RandomWalk
    } else {
        Term::Flicker
    };
    let Some(verdict) = fit.get(leading).map(|c| c.verdict) else {
        return 0.0;
    };
    let relative = match (
        verdict.standard_uncertainty(),
        verdict.estimate(),
        verdict.upper(),
    ) {
        (Some(u), Some(value), _) => u / value,
        // Half of the way to the upper limit of 95 %.
        (None, Some(value), Some(upper)) => 0.5 * (upper - value) / value,
        _ => 0.0,
    };
    if relative.is_finite() {
        relative.clamp(0.0, 1.0)
    } else {
        0.0
    }
}
