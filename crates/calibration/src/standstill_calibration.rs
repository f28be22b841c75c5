//! The whole way from samples to a multi-position fit.

use crate::{
    MeanNoise, MultiPosition, MultiPositionFit, Samples, Segment, Standstill, ThresholdSweep,
};
use proofmass_core::Error;

/// A multi-position calibration with everything it went through.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct StandstillCalibration {
    /// The standstills and how they were found.
    pub sweep: ThresholdSweep,
    /// The noise of their means.
    pub noise: MeanNoise,
    /// The fit.
    pub fit: MultiPositionFit,
}

/// How the parameters follow from standstills with known attitudes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Estimator {
    /// Weighted least squares on every equation.
    #[default]
    LeastSquares,
    /// The closed form of the six positions.
    SixPositions,
}

impl StandstillCalibration {
    /// Finds the standstills of a recording and fits them.
    ///
    /// `rate` in Hz; `breaks` are samples before which time jumps.
    ///
    /// # Errors
    /// Those of [`ThresholdSweep::run`], [`MeanNoise::estimate`] and [`MultiPosition::fit`].
    pub fn run(
        samples: &Samples<'_>,
        rate: f64,
        breaks: &[usize],
        search: &Standstill,
        settings: &MultiPosition,
    ) -> Result<Self, Error> {
        let sweep = ThresholdSweep::run(samples, rate, breaks, search, settings)?;
        Self::fit(samples, sweep, settings, Estimator::LeastSquares)
    }

    /// Fits given standstills.
    ///
    /// # Errors
    /// Those of [`MeanNoise::estimate`], [`MultiPosition::fit`] and [`MultiPosition::fit_six_positions`].
    pub fn of_segments(
        samples: &Samples<'_>,
        segments: Vec<Segment>,
        settings: &MultiPosition,
        estimator: Estimator,
    ) -> Result<Self, Error> {
        let sweep = ThresholdSweep {
            segments,
            threshold: None,
            candidates: Vec::new(),
        };
        Self::fit(samples, sweep, settings, estimator)
    }

    fn fit(
        samples: &Samples<'_>,
        sweep: ThresholdSweep,
        settings: &MultiPosition,
        estimator: Estimator,
    ) -> Result<Self, Error> {
        let noise = MeanNoise::estimate(samples, &sweep.segments)?;
        let poses = noise.poses(samples, &sweep.segments);
        let settings = settings.clone().noise_dof(noise.dof());
        let fit = match estimator {
            Estimator::LeastSquares => settings.fit(&poses)?,
            Estimator::SixPositions => settings.fit_six_positions(&poses)?,
        };
        Ok(Self { sweep, noise, fit })
    }
}
