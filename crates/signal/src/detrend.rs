//! Removing a trend, by name.

use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// What is taken out of a signal before it is analysed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Detrend {
    /// Nothing.
    None,
    /// The mean.
    #[default]
    Constant,
    /// The least-squares straight line.
    Linear,
    /// The least-squares parabola.
    Quadratic,
}

impl std::str::FromStr for Detrend {
    type Err = String;

    /// By its name: none, constant, linear, quadratic.
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "none" => Ok(Self::None),
            "constant" => Ok(Self::Constant),
            "linear" => Ok(Self::Linear),
            "quadratic" => Ok(Self::Quadratic),
            _ => Err(format!(
                "{text:?} is no trend (none, constant, linear, quadratic)"
            )),
        }
    }
}

/// The trend a signal was freed from, on the time axis t_k = (k − (n − 1)/2)/rate centred on the record.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trend {
    /// Mean value, U.
    pub mean: f64,
    /// Slope at the centre, U/s.
    pub slope: f64,
    /// Coefficient of t² − ⟨t²⟩, U/s².
    pub curvature: f64,
}

impl Detrend {
    /// Subtracts the trend in place and says what it was.
    ///
    /// Least squares on the discrete orthogonal polynomials 1, t, t² − ⟨t²⟩, one pass to measure and one to
    /// subtract. Points too few for the degree leave the higher coefficients at zero.
    ///
    /// **Errors** [`Error::NotFinite`] for NaN or infinity, [`Error::TooFew`] for an empty signal.
    ///
    /// ```
    /// use proofmass_signal::Detrend;
    /// let mut signal: Vec<f64> = (0..100).map(|k| 3.0 + 0.5 * f64::from(k)).collect();
    /// let trend = Detrend::Linear.remove(&mut signal, 10.0).unwrap();
    /// assert!((trend.slope - 5.0).abs() < 1e-12);
    /// assert!(signal.iter().all(|v| v.abs() < 1e-12));
    /// ```
    pub fn remove(self, signal: &mut [f64], rate: f64) -> Result<Trend, Error> {
        if signal.is_empty() {
            return Err(Error::TooFew {
                name: "samples",
                needed: 1,
                got: 0,
            });
        }
        proofmass_core::check::finite("signal", signal)?;
        Ok(self.subtract(signal, rate))
    }

    /// [`Detrend::remove`] for a signal known to be finite and not empty.
    pub(crate) fn subtract(self, signal: &mut [f64], rate: f64) -> Trend {
        let mut trend = Trend {
            mean: 0.0,
            slope: 0.0,
            curvature: 0.0,
        };
        if self == Self::None {
            return trend;
        }
        let n = signal.len() as f64;
        let mean = signal.iter().sum::<f64>() / n;
        trend.mean = mean;
        if self == Self::Constant {
            signal.iter_mut().for_each(|v| *v -= mean);
            return trend;
        }
        let centre = 0.5 * (n - 1.0);
        let spread = (n * n - 1.0) / 12.0;
        // Σ t² and Σ (t² − ⟨t²⟩)² over the centred points.
        let w1 = n * spread;
        let w2 = n * (n * n - 1.0) * (n * n - 4.0) / 180.0;
        let (mut s1, mut s2) = (0.0, 0.0);
        for (k, v) in signal.iter().enumerate() {
            let t = k as f64 - centre;
            s1 += (v - mean) * t;
            s2 += (v - mean) * (t * t - spread);
        }
        let slope = if w1 > 0.0 { s1 / w1 } else { 0.0 };
        let curvature = if self == Self::Quadratic && w2 > 0.0 {
            s2 / w2
        } else {
            0.0
        };
        for (k, v) in signal.iter_mut().enumerate() {
            let t = k as f64 - centre;
            *v -= mean + slope * t + curvature * (t * t - spread);
        }
        trend.slope = slope * rate;
        trend.curvature = curvature * rate * rate;
        trend
    }
}
