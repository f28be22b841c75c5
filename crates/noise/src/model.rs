//! The noise model: seven processes, each with its coefficient, its Allan variance and its density.

use proofmass_core::Error;
use serde::{Deserialize, Serialize};
use std::f64::consts::{LN_2, PI};

/// Allan variance of flicker noise of coefficient 1, at any averaging time.
pub(crate) const FLICKER: f64 = 2.0 * LN_2 / PI;

/// One process of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Term {
    /// Q: quantisation, white noise of the phase. Slope −1.
    Quantisation,
    /// N: white noise of the rate (velocity or angle random walk). Slope −½.
    White,
    /// B: bias instability, flicker noise of the rate. Slope 0.
    Flicker,
    /// K: random walk of the rate. Slope +½.
    RandomWalk,
    /// R: linear drift of the rate. Slope +1.
    Ramp,
    /// First-order Gauss–Markov process of the rate.
    GaussMarkov,
    /// A sinusoid in the rate.
    Sinusoid,
}

impl Term {
    /// Every process.
    pub const ALL: [Self; 7] = [
        Self::Quantisation,
        Self::White,
        Self::Flicker,
        Self::RandomWalk,
        Self::Ramp,
        Self::GaussMarkov,
        Self::Sinusoid,
    ];

    /// The usual letter.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Quantisation => "Q",
            Self::White => "N",
            Self::Flicker => "B",
            Self::RandomWalk => "K",
            Self::Ramp => "R",
            Self::GaussMarkov => "G",
            Self::Sinusoid => "A",
        }
    }

    /// Whether the coefficient may be negative: that of a ramp.
    pub fn is_signed(self) -> bool {
        self == Self::Ramp
    }

    /// The usual words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Quantisation => "quantisation",
            Self::White => "white noise",
            Self::Flicker => "bias instability",
            Self::RandomWalk => "rate random walk",
            Self::Ramp => "ramp",
            Self::GaussMarkov => "Gauss–Markov process",
            Self::Sinusoid => "sinusoid",
        }
    }

    /// Slope of the Allan deviation in logarithmic scales, for the five power laws.
    pub fn slope(self) -> Option<f64> {
        match self {
            Self::Quantisation => Some(-1.0),
            Self::White => Some(-0.5),
            Self::Flicker => Some(0.0),
            Self::RandomWalk => Some(0.5),
            Self::Ramp => Some(1.0),
            Self::GaussMarkov | Self::Sinusoid => None,
        }
    }

    /// Unit of the coefficient for a rate in `unit`.
    ///
    /// ```
    /// use proofmass_noise::Term;
    /// assert_eq!(Term::White.unit("m/s²"), "(m/s²)/√Hz");
    /// assert_eq!(Term::RandomWalk.unit("m/s²"), "(m/s²)·√Hz");
    /// ```
    pub fn unit(self, unit: &str) -> String {
        let bracketed = if unit.contains(['/', '·', ' ']) {
            format!("({unit})")
        } else {
            unit.to_owned()
        };
        match self {
            Self::Quantisation => format!("{bracketed}·s"),
            Self::White => format!("{bracketed}/√Hz"),
            Self::Flicker | Self::GaussMarkov | Self::Sinusoid => unit.to_owned(),
            Self::RandomWalk => format!("{bracketed}·√Hz"),
            Self::Ramp => format!("{bracketed}/s"),
        }
    }
}

/// First-order Gauss–Markov process: autocovariance σ² e^{−|t|/T}.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GaussMarkov {
    /// Stationary standard deviation σ, in the unit of the rate.
    pub standard_deviation: f64,
    /// Correlation time T in s.
    pub correlation_time: f64,
}

/// A sinusoid A sin(2πft + φ).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Sinusoid {
    /// Amplitude A (peak), in the unit of the rate.
    pub amplitude: f64,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Phase φ at t = 0 in rad.
    pub phase: f64,
}

/// Noise of a rate as a sum of independent processes; a coefficient of zero leaves its process out.
///
/// σ²(τ) = 3Q²/τ² + N²/τ + (2 ln 2/π) B² + K² τ/3 + R² τ²/2 + Gauss–Markov + sinusoids.
///
/// **Units** for a rate in U: Q in U·s, N in U/√Hz, B in U, K in U·√Hz, R in U/s. N is the **two-sided** root
/// density, the value of the Allan deviation at τ = 1 s: the one-sided amplitude density that data sheets and
/// spectrum analysers give is √2 N. B is the coefficient: the floor of the curve is 0.664 B.
///
/// **Source** `[IEEE952] annex C`, `[IEEE1293]`.
///
/// ```
/// use proofmass_noise::NoiseModel;
/// let model = NoiseModel { white: 2.0e-3, random_walk: 1.0e-4, ..Default::default() };
/// // N²/τ + K²τ/3 at τ = 100 s.
/// assert!((model.allan_variance(100.0) - (4.0e-8 + 1.0e-6 / 3.0)).abs() < 1e-18);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NoiseModel {
    /// Q in U·s.
    pub quantisation: f64,
    /// N in U/√Hz.
    pub white: f64,
    /// B in U.
    pub flicker: f64,
    /// K in U·√Hz.
    pub random_walk: f64,
    /// R in U/s.
    pub ramp: f64,
    /// Gauss–Markov processes.
    pub gauss_markov: Vec<GaussMarkov>,
    /// Sinusoids.
    pub sinusoids: Vec<Sinusoid>,
}

impl NoiseModel {
    /// Allan variance at τ of the continuous processes, U².
    pub fn allan_variance(&self, tau: f64) -> f64 {
        let power_laws = 3.0 * (self.quantisation / tau).powi(2)
            + self.white.powi(2) / tau
            + FLICKER * self.flicker.powi(2)
            + self.random_walk.powi(2) * tau / 3.0
            + 0.5 * (self.ramp * tau).powi(2);
        let markov: f64 = self
            .gauss_markov
            .iter()
            .map(|g| {
                let u = tau / g.correlation_time;
                // σ² (2/u) (1 − (3 − 4e^{−u} + e^{−2u})/(2u)); the series avoids the cancellation at small u.
                let shape = if u < 1e-2 {
                    2.0 * u / 3.0 - 0.5 * u * u + 7.0 / 30.0 * u.powi(3)
                } else {
                    2.0 / u * (1.0 - (3.0 - 4.0 * (-u).exp() + (-2.0 * u).exp()) / (2.0 * u))
                };
                g.standard_deviation.powi(2) * shape
            })
            .sum();
        let lines: f64 = self
            .sinusoids
            .iter()
            .map(|s| {
                let x = PI * s.frequency * tau;
                if x == 0.0 {
                    0.0
                } else {
                    (s.amplitude * x.sin().powi(2) / x).powi(2)
                }
            })
            .sum();
        power_laws + markov + lines
    }

    /// Allan variance at averaging factor m of the sampled processes, U²: what a record shows on average.
    ///
    /// It differs from [`NoiseModel::allan_variance`] at small m: the random walk by 1 + 1/(2m²), flicker noise by its
    /// sampled density.
    pub fn sampled_allan_variance(&self, m: usize, sample_rate: f64) -> f64 {
        let tau = m as f64 / sample_rate;
        let mf = m as f64;
        let continuous = self.allan_variance(tau);
        continuous
            + self.flicker.powi(2) * (sampled_flicker(m) - FLICKER)
            + self.random_walk.powi(2) * tau / (6.0 * mf * mf)
    }

    /// One-sided density at frequency f of the sampled processes, U²/Hz, without ramp and sinusoids.
    ///
    /// Sampled forms: with s = 2 sin(πf/rate)·rate in place of 2πf, quantisation 2Q² s²/rate, white 2N², flicker
    /// 2B²/s, random walk 2K²/s², Gauss–Markov that of a first-order autoregression. They are exactly those
    /// of [`simulate`](crate::simulate).
    pub fn density(&self, frequency: f64, sample_rate: f64) -> f64 {
        let basis = |term| term_density(term, frequency, sample_rate);
        self.quantisation.powi(2) * basis(Term::Quantisation)
            + self.white.powi(2) * basis(Term::White)
            + self.flicker.powi(2) * basis(Term::Flicker)
            + self.random_walk.powi(2) * basis(Term::RandomWalk)
            + self
                .gauss_markov
                .iter()
                .map(|g| {
                    g.standard_deviation.powi(2)
                        * markov_density(g.correlation_time, frequency, sample_rate)
                })
                .sum::<f64>()
    }

    /// Refuses coefficients that are negative or not finite and times that are not positive.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let scalars = [
            ("quantisation", self.quantisation),
            ("white", self.white),
            ("flicker", self.flicker),
            ("random walk", self.random_walk),
        ];
        let markov = self.gauss_markov.iter().flat_map(|g| {
            [
                ("standard deviation", g.standard_deviation),
                ("correlation time", g.correlation_time),
            ]
        });
        let lines = self.sinusoids.iter().map(|s| ("frequency", s.frequency));
        for (name, value) in scalars.into_iter().chain(markov).chain(lines) {
            let positive = value > 0.0 || (value == 0.0 && name != "correlation time");
            if !(positive && value.is_finite()) {
                return Err(Error::OutOfRange {
                    name,
                    value,
                    min: 0.0,
                    max: f64::MAX,
                });
            }
        }
        Ok(())
    }
}

/// Density of a unit coefficient of one of the four stationary-increment power laws.
pub(crate) fn term_density(term: Term, frequency: f64, sample_rate: f64) -> f64 {
    let s = 2.0 * (PI * frequency / sample_rate).sin() * sample_rate;
    match term {
        Term::Quantisation => 2.0 * s * s / sample_rate,
        Term::White => 2.0,
        Term::Flicker => 2.0 / s,
        Term::RandomWalk => 2.0 / (s * s),
        Term::Ramp | Term::GaussMarkov | Term::Sinusoid => 0.0,
    }
}

/// Density of a sampled Gauss–Markov process of unit variance.
pub(crate) fn markov_density(correlation_time: f64, frequency: f64, sample_rate: f64) -> f64 {
    let decay = 1.0 / (correlation_time * sample_rate);
    let phi = (-decay).exp();
    // 1 − φ² and |1 − φe^{iω}|² without cancellation for long correlation times.
    let gain = -(-2.0 * decay).exp_m1();
    let gap = -(-decay).exp_m1();
    let half = (PI * frequency / sample_rate).sin();
    2.0 / sample_rate * gain / (gap * gap + 4.0 * phi * half * half)
}

/// ∫ 2/s |H|² df for the sampled flicker density; 2 ln 2/π for m beyond 64, within 1e-4 (4/π · ½ at m = 1).
fn sampled_flicker(m: usize) -> f64 {
    if m > 64 {
        return FLICKER;
    }
    let points = 256 * m;
    let step = 0.5 / points as f64;
    (0..points)
        .map(|k| {
            let f = (k as f64 + 0.5) * step;
            term_density(Term::Flicker, f, 1.0) * allan_response(m, f, 1.0) * step
        })
        .sum()
}

/// Response of the Allan variance of factor m to a one-sided density: σ² = ∫ S |H|² df over 0 … rate/2.
///
/// |H|² = 2 sin⁴(πmf/rate)/(m sin(πf/rate))²; for continuous processes 2 sin⁴(πfτ)/(πfτ)², twice that for a
/// two-sided density.
pub(crate) fn allan_response(m: usize, frequency: f64, sample_rate: f64) -> f64 {
    let x = PI * frequency / sample_rate;
    let m = m as f64;
    let ratio = if x == 0.0 {
        0.0
    } else {
        (m * x).sin().powi(2) / (m * x.sin())
    };
    2.0 * ratio * ratio
}
