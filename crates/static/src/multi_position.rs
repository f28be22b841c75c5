//! Multi-position calibration: bias, scale factors and misalignments from standstills in many attitudes.

mod assembly;
mod causes;
mod compensated;
mod evidence;
mod findings;
mod fit;
mod misfit;
mod model;
mod next_attitude;
mod observability;
mod problem;
mod scatter_forms;
mod solved;
mod suspects;
mod term_equations;
mod terms;
mod wiring;

pub use compensated::CompensatedReading;
pub use evidence::ModelEvidence;
pub use fit::{BeyondMatrix, MultiPositionFit, PoseResidual, ScatterParts, WithoutSuspects};
pub use misfit::{Misfit, MisfitCause};
pub use model::Model;
pub(crate) use model::{BIAS, ELEMENT};
pub use next_attitude::{Limiting, NextAttitude};
pub(crate) use problem::{Problem, quadratic_form};
pub use scatter_forms::{FormWeight, ScatterForm};
pub(crate) use solved::Solved;
pub use suspects::Suspect;
pub use terms::Terms;

use crate::Pose;
use proofmass_core::{Error, Gravity};
use proofmass_uncertainty::{DegreesOfFreedom, NoiseDof};

/// How well given attitudes are known, standard uncertainties in radians.
#[doc(alias("orientation uncertainty", "levelling error"))]
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct AttitudeUncertainty {
    /// Of each attitude for itself, about any axis across the specific force.
    pub independent: f64,
    /// Of the frame all attitudes are given in, about each of its axes: one draw for the campaign.
    pub common: f64,
}

/// A multi-position fit, ready to run.
///
/// Every standstill gives one equation ‖K⁻¹(m − b)‖ = g where its attitude is unknown, three equations
/// m = K g u + b where it is known. Weights come from the covariance of the means, renewed as K changes.
///
/// What varies between the standstills beyond that noise (hysteresis, wander, a hand that moves) is estimated always,
/// as a variance common to all of them, and the intervals carry how well the residuals fix it
/// ([`BetweenScatter`](proofmass_uncertainty::BetweenScatter)): no test stands between the data and an interval. A
/// common variance is used in place of Birge's common factor because it does not average down with the length of a
/// standstill. Means whose noise is not known have it from the residuals alone.
///
/// ```no_run
/// # use proofmass_static::{MultiPosition, Pose};
/// # fn poses() -> Vec<Pose> { Vec::new() }
/// use proofmass_core::Gravity;
///
/// let fit = MultiPosition::new(Gravity::given(9.81744, 0.0001)?).fit(&poses())?;
/// let bias_x = fit.estimate().get("bias.x");
/// for finding in fit.findings() { println!("{finding}"); }
/// # Ok::<(), proofmass_core::Error>(())
/// ```
///
/// **Units** outputs in any unit; gravity in m/s²; scale factors in output unit per m/s²; misalignments in rad.
///
/// **Accuracy** the coverage of the intervals is mapped in docs/multi-position.md.
///
/// **Source** `[Tedaldi2014]` (unknown attitudes), `[PauleMandel1982]` (excess), `[GUM] 5`.
#[doc(alias("six-position test", "tumble test", "ellipsoid fit", "IEEE 1293"))]
#[derive(Clone, Debug)]
pub struct MultiPosition {
    gravity: Gravity,
    model: Model,
    terms: Terms,
    nominal_sensitivity: Option<f64>,
    attitude: AttitudeUncertainty,
    output_unit: String,
    noise_dof: DegreesOfFreedom,
    probability: f64,
    limit: f64,
    /// Common relative standard uncertainty of true accelerations whose lengths count.
    pub(crate) lengths: Option<f64>,
    /// Of the readings, as many as count as independent.
    effective: Option<f64>,
    /// Standard uncertainty of what a motion adds to every magnitude, m/s².
    lengthening: f64,
}

/// A parameter whose standard uncertainty exceeds this in natural units (of the scale, of g) is not determined:
/// beyond, the first-order propagation itself fails.
const UNDETERMINED: f64 = 0.02;

impl MultiPosition {
    /// With the triangular model, raw outputs of unknown sensitivity, and no attitude uncertainty.
    pub fn new(gravity: Gravity) -> Self {
        Self {
            gravity,
            model: Model::Triangular,
            terms: Terms::default(),
            nominal_sensitivity: None,
            attitude: AttitudeUncertainty::default(),
            output_unit: "count".to_owned(),
            noise_dof: DegreesOfFreedom::INFINITE,
            probability: 0.95,
            limit: UNDETERMINED,
            lengths: None,
            effective: None,
            lengthening: 0.0,
        }
    }

    /// Chooses the model.
    #[must_use]
    pub fn model(mut self, model: Model) -> Self {
        self.model = model;
        self
    }

    /// Adds terms that follow the temperature, and curvature.
    #[must_use]
    pub fn terms(mut self, terms: Terms) -> Self {
        self.terms = terms;
        self
    }

    /// Declares the outputs to be accelerations already (m/s²), or outputs of a known nominal sensitivity.
    ///
    /// Then the outputs must agree with gravity to a factor of two, and the bias model becomes possible.
    #[must_use]
    pub fn nominal_sensitivity(mut self, sensitivity: f64) -> Self {
        self.nominal_sensitivity = Some(sensitivity);
        self
    }

    /// Declares how well the given attitudes are known.
    #[must_use]
    pub fn attitude_uncertainty(mut self, attitude: AttitudeUncertainty) -> Self {
        self.attitude = attitude;
        self
    }

    /// Declares the attitudes to be true accelerations in units of local gravity whose lengths count, as on a centrifuge;
    /// `common` is the relative standard uncertainty that all lengths share, in the place of that of gravity.
    #[must_use]
    pub fn true_accelerations(mut self, common: f64) -> Self {
        self.lengths = Some(common);
        self
    }

    /// Names the unit of the outputs, for the units of the results.
    #[must_use]
    pub fn output_unit(mut self, unit: impl Into<String>) -> Self {
        self.output_unit = unit.into();
        self
    }

    /// Declares the degrees of freedom of the noise in the poses' covariances.
    #[must_use]
    pub fn noise_dof(mut self, dof: DegreesOfFreedom) -> Self {
        self.noise_dof = dof;
        self
    }

    /// Chooses the probability of the intervals, 0.95 unless told.
    #[must_use]
    pub fn probability(mut self, probability: f64) -> Self {
        self.probability = probability;
        self
    }

    /// Chooses the largest standard uncertainty (scale factors relative, misalignments in rad, biases in units of g)
    /// at which a parameter is a result; 0.02 unless told.
    #[must_use]
    pub fn largest_uncertainty(mut self, limit: f64) -> Self {
        self.limit = limit;
        self
    }

    /// Declares the readings to follow one another in one motion: so many of them count as independent, and that motion adds
    /// to every magnitude with this standard uncertainty, m/s².
    #[must_use]
    pub(crate) fn successive(mut self, effective: f64, lengthening: f64) -> Self {
        self.effective = Some(effective);
        self.lengthening = lengthening;
        self
    }

    /// Fits the model to the standstills.
    ///
    /// Attitudes are used when every pose has one, else ignored; so is the noise of the means.
    ///
    /// # Errors
    /// [`Error::Unobservable`] naming the parameter that the attitudes do not determine, [`Error::TooUncertain`] for
    /// one that they determine too badly, [`Error::TooFew`] for fewer equations than parameters,
    /// [`Error::OutOfRange`] when outputs that should be accelerations are not near gravity,
    /// [`Error::NotConverged`].
    pub fn fit(&self, poses: &[Pose]) -> Result<MultiPositionFit, Error> {
        let problem = Problem::new(self, poses)?;
        let solved = Solved::of(self, &problem)?;
        MultiPositionFit::assemble(self, &problem, solved)
    }

    /// Standstills that do not belong to the others: out of line, or labelled with another attitude than they have.
    ///
    /// Also where a fit is refused because of them. Each is found given those before it, at a family-wise
    /// probability of 1 % of naming one that is not.
    ///
    /// # Errors
    /// Those of [`MultiPosition::fit`], but for [`Error::TooUncertain`].
    pub fn suspects(&self, poses: &[Pose]) -> Result<Vec<Suspect>, Error> {
        let problem = Problem::new(self, poses)?;
        let solved = Solved::of(self, &problem)?;
        Ok(suspects::of(&problem, &solved))
    }

    /// What is known of the noise of the means.
    pub(crate) fn noise(&self) -> NoiseDof {
        match self.noise_dof.is_infinite() {
            true => NoiseDof::Known,
            false => NoiseDof::Pooled(self.noise_dof),
        }
    }

    /// Local gravity, m/s².
    pub(crate) fn gravity_value(&self) -> f64 {
        self.gravity.value()
    }

    /// Number of free parameters of the chosen model.
    pub(crate) fn parameters(&self) -> usize {
        self.model.parameters() + self.terms.list().len()
    }

    /// Sum of squared residuals of a fit weighted by the number of samples, and the mean variance of its
    /// parameters per unit of residual variance, both in natural units: what a threshold sweep compares.
    pub(crate) fn relative_quality(&self, poses: &[Pose]) -> Result<(f64, f64), Error> {
        let mut problem = Problem::new(self, poses)?;
        problem.weigh_by_samples();
        problem.quality()
    }
}
