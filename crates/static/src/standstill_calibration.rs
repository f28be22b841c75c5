//! The whole way from samples to a multi-position fit.

use crate::{
    MeanNoise, MultiPosition, MultiPositionFit, Pose, Samples, Segment, Standstill, ThresholdSweep,
};
use proofmass_core::{Error, Gravity, Unwatched};

/// A multi-position calibration with everything it went through.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StandstillCalibration {
    /// The standstills and how they were found.
    pub sweep: ThresholdSweep,
    /// The noise of their means; `None` for a table of readings, which has no samples.
    pub noise: Option<MeanNoise>,
    /// The fit.
    pub fit: MultiPositionFit,
}

/// How the parameters follow from standstills with known attitudes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StandstillEstimator {
    /// Weighted least squares on every equation.
    #[default]
    LeastSquares,
    /// The closed form of the six positions.
    SixPositions,
}

/// Bias, scale and misalignment from a recording of a triaxial accelerometer that rested in some dozen attitudes.
///
/// **Units** outputs x, y, z in any unit; `sampling_rate` in Hz.
///
/// # Errors
/// As [`StandstillCalibration::run`]; columns of different lengths.
///
/// ```
/// use proofmass_core::Gravity;
/// use proofmass_rig::HandHeld;
///
/// let recording = HandHeld::default().simulate(1);
/// let [x, y, z] = &recording.outputs;
/// let fit = proofmass_static::calibrate([x, y, z], recording.rate, Gravity::given(9.80665, 1e-5)?)?;
/// for quantity in fit.quantities() {
///     println!("{quantity}");
/// }
/// let acceleration = fit.model().apply([x[0], y[0], z[0]]);
/// assert!((proofmass_core::norm(acceleration) - 9.80665).abs() < 0.1);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
pub fn calibrate(
    outputs: [&[f64]; 3],
    sampling_rate: f64,
    gravity: Gravity,
) -> Result<MultiPositionFit, Error> {
    let [x, y, z] = outputs;
    let calibration = StandstillCalibration::run(
        &Samples::new(x, y, z)?,
        sampling_rate,
        &[],
        &Standstill::default(),
        &MultiPosition::new(gravity),
    )?;
    Ok(calibration.fit)
}

impl StandstillCalibration {
    /// Finds the standstills of a recording and fits them.
    ///
    /// `rate` in samples per second; `breaks` are samples before which time jumps.
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
        let sweep = ThresholdSweep::run(samples, rate, breaks, search, settings, &Unwatched)?;
        Self::of_sweep(samples, sweep, settings, StandstillEstimator::LeastSquares)
    }

    /// Fits given standstills.
    ///
    /// # Errors
    /// Those of [`StandstillCalibration::of_sweep`].
    pub fn of_segments(
        samples: &Samples<'_>,
        segments: Vec<Segment>,
        settings: &MultiPosition,
        estimator: StandstillEstimator,
    ) -> Result<Self, Error> {
        Self::of_sweep(
            samples,
            ThresholdSweep::given(segments),
            settings,
            estimator,
        )
    }

    /// Fits standstills that were found or given, some perhaps left out.
    ///
    /// # Errors
    /// Those of [`MeanNoise::estimate`], [`MultiPosition::fit`] and [`MultiPosition::fit_six_positions`].
    pub fn of_sweep(
        samples: &Samples<'_>,
        sweep: ThresholdSweep,
        settings: &MultiPosition,
        estimator: StandstillEstimator,
    ) -> Result<Self, Error> {
        let noise = MeanNoise::estimate(samples, &sweep.segments)?;
        let poses = noise.poses(samples, &sweep.segments);
        let settings = settings.clone().noise_dof(noise.dof());
        Ok(Self {
            fit: estimator.fit(&settings, &poses)?,
            noise: Some(noise),
            sweep,
        })
    }

    /// Fits a table of readings or means: every sample is an attitude of its own.
    ///
    /// `uncertainty`: standard uncertainty of each output from its noise, output units; without it their scatter about
    /// the model is all that is known of it.
    ///
    /// # Errors
    /// Those of [`MultiPosition::fit`] and [`MultiPosition::fit_six_positions`].
    pub fn of_readings(
        samples: &Samples<'_>,
        sweep: ThresholdSweep,
        uncertainty: Option<f64>,
        settings: &MultiPosition,
        estimator: StandstillEstimator,
    ) -> Result<Self, Error> {
        let variance = uncertainty.map(|u| u * u);
        let poses: Vec<Pose> = sweep
            .segments
            .iter()
            .map(|segment| Pose {
                covariance: variance.map(|v| [[v, 0.0, 0.0], [0.0, v, 0.0], [0.0, 0.0, v]]),
                temperature: samples.temperature().map(|t| t[segment.start]),
                time: samples.time().map(|t| t[segment.start]),
                ..Pose::reading(segment.clone(), samples.mean(segment.start, segment.end))
            })
            .collect();
        Ok(Self {
            fit: estimator.fit(settings, &poses)?,
            noise: None,
            sweep,
        })
    }
}

impl StandstillEstimator {
    fn fit(self, settings: &MultiPosition, poses: &[Pose]) -> Result<MultiPositionFit, Error> {
        match self {
            Self::LeastSquares => settings.fit(poses),
            Self::SixPositions => settings.fit_six_positions(poses),
        }
    }
}
