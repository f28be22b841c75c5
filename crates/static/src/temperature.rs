//! Temperature coefficients of a resting accelerometer from plateaus or a continuous sweep.

mod averaged;
mod blocks;
mod branches;
mod coefficients;
mod correlated_noise;
mod environment;
mod findings;
mod fit;
mod joint_estimate;
mod soak;
mod steps;
mod warm_up;

pub use blocks::{Attitude, Blocks};
pub use branches::Hysteresis;
pub use coefficients::{AxisFit, OrderFit, TemperatureFit};
pub use environment::{EnvironmentalCourse, EnvironmentalQuantity};
pub use steps::OutputStep;
pub use warm_up::SelfHeating;

use crate::Triple;
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// How the output of a resting accelerometer follows its temperature.
///
/// The recording is reduced to block means. Each axis is fitted with the intercepts of the attitudes it was found in and
/// powers of d = T − T₀; where the sensor was both heated and cooled, half the difference of the branches is part of the
/// model, so that hysteresis is neither averaged away nor taken for a coefficient; where the rate of the temperature varies
/// enough besides, the lag of the thermometer is. Self-heating after switching on is part of it where it is asked for, at every
/// time constant of a grid. Quantities of the surroundings beside the temperature (E_j: humidity, pressure, supply voltage) are
/// linear in it.
///
/// ```text
/// y(t) = a_s + Σ c_k dᵏ + Σ e_j (E_j − E_j0) ± ½ h(d) + λ Ṫ + A e^{−t/τ} + noise,   noise: white + first-order Gauss–Markov or a random walk
/// ```
///
/// Neither the order nor the noise is chosen. What is stated is the largest order, with the evidence for each order beside it
/// (AICc, F, cross-validation); under every noise of a grid it is fitted, and the average by restricted likelihood is
/// stated with the variance between the noises. So nothing stands between the data and the interval.
///
/// **Assumes** noise that is stationary, or walks. Wander as slow as the whole sweep cannot be told from temperature; a second sweep
/// tells them apart.
/// **Accuracy** coverage in docs/temperature.md.
/// **Source** `[BurnhamAnderson2002]` ch. 2 and 4 (AICc, averaging over models), `[Patterson1971]` (restricted
/// likelihood).
#[doc(alias("TCB", "temperature coefficient of bias", "thermal calibration"))]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct TemperatureSweep {
    /// Largest power of the temperature difference, 1 to 3.
    pub largest_order: usize,
    /// T₀, °C; the middle of the range unless told.
    pub reference: Option<f64>,
    /// Coverage probability.
    pub probability: f64,
    /// Number of blocks that is aimed at.
    pub blocks: usize,
    /// Longest time constant, s, of the sensor's own warming, where it was switched on when the recording began: part of the
    /// model then. A decay as slow as the sweep cannot be told from temperature.
    #[serde(default)]
    pub warm_up: Option<f64>,
    /// Standard uncertainty of the attitude across each jump of the temperature, rad, where the recording was interrupted and
    /// somebody knows how well the sensor was kept in place; without it whatever the outputs leave possible.
    #[serde(default)]
    pub tilt: Option<f64>,
}

impl Default for TemperatureSweep {
    fn default() -> Self {
        Self {
            largest_order: 3,
            reference: None,
            probability: 0.95,
            blocks: 200,
            warm_up: None,
            tilt: None,
        }
    }
}

/// A recording of a sensor that stands still while its temperature changes.
#[derive(Clone, Debug)]
pub struct SweepData<'a> {
    /// Outputs x, y, z as accelerations, m/s²; of a sensor with one axis that alone.
    pub outputs: Vec<&'a [f64]>,
    /// Temperature of every sample, °C.
    pub temperature: &'a [f64],
    /// Samples per second.
    pub rate: f64,
}

/// Means of the columns over a range; axes that there are none of stay at zero.
pub(super) fn means(columns: &[&[f64]], start: usize, end: usize) -> Triple {
    let mut means = [0.0; 3];
    for (mean, c) in means.iter_mut().zip(columns) {
        *mean = c[start..end].iter().sum::<f64>() / (end - start) as f64;
    }
    means
}

impl TemperatureSweep {
    /// Fits the coefficients.
    ///
    /// # Errors
    /// [`Error::Length`], [`Error::NotFinite`], [`Error::TooFew`] for a recording too short for the model,
    /// [`Error::Constant`] for a temperature that does not change, [`Error::Unobservable`] where the sensor was turned and the
    /// temperature did not change while it lay still, [`Error::OutOfRange`] for settings without meaning.
    pub fn fit(&self, data: &SweepData<'_>) -> Result<TemperatureFit, Error> {
        self.fit_beside(data, &[])
    }

    /// Fits the coefficients of the temperature and of other quantities of the surroundings in one model: `bias.x.humidity` … in the
    /// estimate, and `scale.x.humidity` … where attitudes tell them apart.
    ///
    /// A quantity whose course temperature, attitudes, branches and the others explain but for 2 % is left out, which
    /// [`TemperatureFit::environment`] says.
    ///
    /// # Errors
    /// As [`TemperatureSweep::fit`].
    pub fn fit_beside(
        &self,
        data: &SweepData<'_>,
        environment: &[EnvironmentalQuantity<'_>],
    ) -> Result<TemperatureFit, Error> {
        let settings = [
            ("largest order", self.largest_order as f64, 1.0, 3.0),
            ("number of blocks", self.blocks as f64, 40.0, 400.0),
            ("probability", self.probability, 0.5, 0.9999),
            ("sampling rate, Hz", data.rate, 1e-6, 1e9),
        ];
        for (name, value, min, max) in settings {
            if !(min..=max).contains(&value) {
                return Err(Error::OutOfRange {
                    name,
                    value,
                    min,
                    max,
                });
            }
        }
        if let Some(longest) = self.warm_up.filter(|t| !(*t > 0.0 && t.is_finite())) {
            return Err(Error::OutOfRange {
                name: "longest time constant of self-heating, s",
                value: longest,
                min: f64::MIN_POSITIVE,
                max: f64::MAX,
            });
        }
        if let Some(tilt) = self.tilt.filter(|t| !(0.0..=0.5).contains(t)) {
            return Err(Error::OutOfRange {
                name: "standard uncertainty of the attitude, rad",
                value: tilt,
                min: 0.0,
                max: 0.5,
            });
        }
        let blocks = Blocks::of(data, environment, self.blocks)?;
        let courses = environment.iter().zip(&blocks.environment);
        let courses = courses.map(|(quantity, means)| EnvironmentalCourse::of(quantity, means));
        fit::fit(self, &blocks, courses.collect())
    }
}
