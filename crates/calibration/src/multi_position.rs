//! Multi-position calibration: bias, scale factors and misalignments from standstills in many attitudes.

mod findings;
mod fit;
mod model;

pub use fit::{MultiPositionFit, PoseResidual};
pub use model::Model;
pub(crate) use model::{BIAS, ELEMENT};

use crate::adjustment::{Adjustment, Equations, adjust, excess_variance};
use crate::direction_coverage::{missing, unit};
use crate::{Ellipsoid, Pose, Triple};
use faer::Mat;
use proofmass_core::{Error, Gravity, Matrix3};
use proofmass_uncertainty::DegreesOfFreedom;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// How well given attitudes are known, standard uncertainties in radians.
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
/// Where the residuals exceed what the noise of the means explains (95 % quantile of χ²), a variance common to
/// all standstills is added until χ² equals its degrees of freedom, and a finding tells the Birge ratio. A
/// common added variance is used in place of Birge's common factor because what makes residuals exceed
/// (hysteresis, wander, a hand that moves) does not average down with the length of a standstill.
///
/// ```no_run
/// # use proofmass_calibration::{MultiPosition, Pose};
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
/// **Source** `[Tedaldi2014]` (unknown attitudes), `[PauleMandel1982]` (excess), `[GUM] 5`.
#[derive(Clone, Debug)]
pub struct MultiPosition {
    gravity: Gravity,
    model: Model,
    nominal_sensitivity: Option<f64>,
    attitude: AttitudeUncertainty,
    output_unit: String,
    noise_dof: DegreesOfFreedom,
}

impl MultiPosition {
    /// With the triangular model, raw outputs of unknown sensitivity, and no attitude uncertainty.
    pub fn new(gravity: Gravity) -> Self {
        Self {
            gravity,
            model: Model::Triangular,
            nominal_sensitivity: None,
            attitude: AttitudeUncertainty::default(),
            output_unit: "count".to_owned(),
            noise_dof: DegreesOfFreedom::INFINITE,
        }
    }

    /// Chooses the model.
    #[must_use]
    pub fn model(mut self, model: Model) -> Self {
        self.model = model;
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

    /// Fits the model to the standstills.
    ///
    /// Attitudes are used when every pose has one, else ignored.
    ///
    /// # Errors
    /// [`Error::Unobservable`] naming the parameter that the attitudes do not determine (two of the six principal
    /// directions without an attitude within 45° count as such), [`Error::TooFew`] for
    /// fewer equations than parameters, [`Error::OutOfRange`] when outputs that should be accelerations are not
    /// near gravity, [`Error::NotConverged`].
    pub fn fit(&self, poses: &[Pose]) -> Result<MultiPositionFit, Error> {
        let problem = Problem::new(self, poses)?;
        let (adjustment, excess, chi_square) = problem.solve()?;
        MultiPositionFit::assemble(self, &problem, adjustment, excess, chi_square)
    }

    /// Number of free parameters of the chosen model.
    pub(crate) fn parameters(&self) -> usize {
        self.model.parameters()
    }

    /// Sum of squared residuals of a fit weighted by the number of samples, and the mean variance of its
    /// parameters per unit of residual variance, both in natural units: what a threshold sweep compares.
    pub(crate) fn relative_quality(&self, poses: &[Pose]) -> Result<(f64, f64), Error> {
        let mut problem = Problem::new(self, poses)?;
        let samples: usize = poses.iter().map(|p| p.segment.len()).sum();
        let typical = samples as f64 / poses.len() as f64;
        for (covariance, pose) in problem.covariances.iter_mut().zip(poses) {
            let v = typical / pose.segment.len() as f64;
            *covariance = [[v, 0.0, 0.0], [0.0, v, 0.0], [0.0, 0.0, v]];
        }
        let adjustment = problem.adjust(0.0)?;
        let g = &adjustment.gain;
        let rows_per_pose = g.ncols() / poses.len();
        let spread: f64 = (0..g.ncols())
            .map(|j| {
                let v = problem.covariances[j / rows_per_pose][0][0];
                (0..g.nrows())
                    .map(|i| v * g[(i, j)] * g[(i, j)])
                    .sum::<f64>()
            })
            .sum();
        Ok((adjustment.chi_square, spread / self.parameters() as f64))
    }

    /// Quantile of χ² beyond which residuals count as exceeding the noise.
    fn excess_quantile(degrees_of_freedom: usize) -> f64 {
        ChiSquared::new(degrees_of_freedom.max(1) as f64)
            .map_or(f64::INFINITY, |d| d.inverse_cdf(0.95))
    }
}

/// A parameter whose standard uncertainty exceeds this in natural units (of the scale, of g) is not determined:
/// beyond, the first-order propagation itself fails.
const UNDETERMINED: f64 = 0.02;

/// The fit in natural units: outputs y = (m − c)/(s g), so that y ≈ κ u + β with κ ≈ I and β ≈ 0.
pub(crate) struct Problem<'a> {
    poses: &'a [Pose],
    model: Model,
    /// Given attitudes, when every pose has one.
    attitudes: Option<Vec<Triple>>,
    attitude: AttitudeUncertainty,
    /// Centre c, output units.
    centre: Triple,
    /// s g, output units.
    radius: f64,
    points: Vec<Triple>,
    covariances: Vec<[Triple; 3]>,
}

impl<'a> Problem<'a> {
    pub(crate) fn new(settings: &MultiPosition, poses: &'a [Pose]) -> Result<Self, Error> {
        let model = settings.model;
        let attitudes: Option<Vec<Triple>> = poses
            .iter()
            .map(|pose| pose.segment.attitude.and_then(unit))
            .collect();
        model.check_count(poses.len(), if attitudes.is_some() { 3 } else { 1 })?;
        if model == Model::Full && attitudes.is_none() {
            // Any rotation of the sensor leaves ‖a‖ as it is.
            return Err(Error::Unobservable {
                parameter: "misalignment.yx",
                condition: f64::INFINITY,
            });
        }
        let g = settings.gravity.value();
        let means: Vec<Triple> = poses.iter().map(|p| p.mean).collect();
        let (centre, radius) = match settings.nominal_sensitivity {
            Some(sensitivity) => {
                let radius = sensitivity * g;
                let typical = median(means.iter().map(|m| proofmass_core::norm(*m)).collect());
                if !(typical > 0.5 * radius && typical < 2.0 * radius) {
                    return Err(Error::OutOfRange {
                        name: "magnitude of the output at rest",
                        value: typical,
                        min: 0.5 * radius,
                        max: 2.0 * radius,
                    });
                }
                ([0.0; 3], radius)
            }
            None if model == Model::Bias => {
                return Err(Error::Unobservable {
                    parameter: "bias of a sensor without nominal sensitivity",
                    condition: f64::INFINITY,
                });
            }
            None => {
                let sphere = Ellipsoid::sphere(&means)?;
                (sphere.centre, sphere.radius())
            }
        };
        let points: Vec<Triple> = means
            .iter()
            .map(|m| std::array::from_fn(|i| (m[i] - centre[i]) / radius))
            .collect();
        let covariances = poses
            .iter()
            .map(|p| p.covariance.map(|row| row.map(|v| v / radius / radius)))
            .collect();
        check_directions(model, attitudes.as_ref().unwrap_or(&points))?;
        Ok(Self {
            poses,
            model,
            attitudes,
            attitude: settings.attitude,
            centre,
            radius,
            points,
            covariances,
        })
    }

    /// Weighted fit; the excess variance; χ² of the residuals before any excess was added.
    pub(crate) fn solve(&self) -> Result<(Adjustment, f64, f64), Error> {
        let first = self.adjust(0.0)?;
        let (chi_square, dof) = (first.chi_square, first.degrees_of_freedom);
        let quantile = MultiPosition::excess_quantile(dof);
        let typical = self
            .covariances
            .iter()
            .map(|c| (c[0][0] + c[1][1] + c[2][2]) / 3.0)
            .sum::<f64>()
            / self.covariances.len() as f64;
        let at = |excess| self.adjust(excess).map(|a| a.chi_square);
        let excess = excess_variance(chi_square, dof, quantile, at, typical)?;
        let last = if excess > 0.0 {
            self.adjust(excess)?
        } else {
            first
        };
        Ok((last, excess, chi_square))
    }

    /// Mean output of one standstill in natural units.
    pub(crate) fn point(&self, index: usize) -> Triple {
        self.points[index]
    }

    fn adjust(&self, excess: f64) -> Result<Adjustment, Error> {
        let name = |i| self.model.parameter_name(i);
        adjust(&self.start(), excess, name, |parameters| {
            self.equations(parameters)
        })
    }

    /// The parameters of the identity; the algebraic ellipsoid where it exists and is near.
    fn start(&self) -> Vec<f64> {
        let mut start = vec![0.0; 3];
        let elements = self.model.free_elements();
        start.extend(elements.iter().map(|(i, j)| if i == j { 1.0 } else { 0.0 }));
        if self.model == Model::Symmetric
            && self.attitudes.is_none()
            && let Ok(ellipsoid) = Ellipsoid::algebraic(&self.points)
        {
            start[..3].copy_from_slice(&ellipsoid.centre);
            for (value, &(i, j)) in start[3..].iter_mut().zip(elements) {
                *value = ellipsoid.shape[i][j];
            }
        }
        start
    }

    fn equations(&self, parameters: &[f64]) -> Result<Vec<Equations>, Error> {
        let k = Matrix3(self.model.matrix(parameters));
        let beta = [parameters[0], parameters[1], parameters[2]];
        match &self.attitudes {
            Some(attitudes) => Ok(self.known_attitudes(&k, beta, attitudes)),
            None => self.unknown_attitudes(&k, beta),
        }
    }

    /// r = ‖κ⁻¹(y − β)‖ − 1, one equation each.
    fn unknown_attitudes(&self, k: &Matrix3<f64>, beta: Triple) -> Result<Vec<Equations>, Error> {
        let inverse = k.inverse()?;
        let inverse_transpose = inverse.transpose();
        let p = self.model.parameters();
        self.points
            .iter()
            .zip(&self.covariances)
            .map(|(y, covariance)| {
                let a = inverse.times(std::array::from_fn(|i| y[i] - beta[i]));
                let length = proofmass_core::norm(a);
                let n = unit(a).ok_or(Error::NotFinite {
                    name: "acceleration of a standstill",
                    index: 0,
                })?;
                let w = inverse_transpose.times(n);
                let mut row = vec![0.0; p];
                self.model.derivative(w, a, -1.0, &mut row);
                let variance = quadratic_form(covariance, w);
                Ok(Equations {
                    residual: vec![length - 1.0],
                    jacobian: vec![row],
                    covariance: Mat::from_fn(1, 1, |_, _| variance),
                })
            })
            .collect()
    }

    /// r = y − β − κ u, three equations each.
    fn known_attitudes(
        &self,
        k: &Matrix3<f64>,
        beta: Triple,
        attitudes: &[Triple],
    ) -> Vec<Equations> {
        let p = self.model.parameters();
        self.points
            .iter()
            .zip(&self.covariances)
            .zip(attitudes)
            .map(|((y, covariance), u)| {
                let expected = k.times(*u);
                let residual = (0..3).map(|i| y[i] - beta[i] - expected[i]).collect();
                let jacobian = (0..3)
                    .map(|i| {
                        let mut axis = [0.0; 3];
                        axis[i] = 1.0;
                        let mut row = vec![0.0; p];
                        self.model.derivative(axis, *u, -1.0, &mut row);
                        row
                    })
                    .collect();
                let tilt = self.tilt_covariance(k, *u);
                Equations {
                    residual,
                    jacobian,
                    covariance: Mat::from_fn(3, 3, |i, j| covariance[i][j] + tilt[i][j]),
                }
            })
            .collect()
    }

    /// Covariance of κ u from the independent uncertainty of u: u_θ² κ (I − u uᵀ) κᵀ.
    fn tilt_covariance(&self, k: &Matrix3<f64>, u: Triple) -> [Triple; 3] {
        let across = std::array::from_fn(|i| {
            std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 } - u[i] * u[j])
        });
        let variance = self.attitude.independent.powi(2);
        k.product(&Matrix3(across))
            .product(&k.transpose())
            .0
            .map(|row| row.map(|v| v * variance))
    }
}

/// Refuses a scale factor that would be extrapolated: two or more of the six principal directions without an
/// attitude within 45°. A linear model might still be fitted, but nothing would check it where it is used.
fn check_directions(model: Model, directions: &[Triple]) -> Result<(), Error> {
    if model == Model::Bias {
        return Ok(());
    }
    let units: Vec<Triple> = directions.iter().filter_map(|d| unit(*d)).collect();
    let missing = missing(&units);
    if missing.len() < 2 {
        return Ok(());
    }
    let both_ends = missing.windows(2).find(|pair| pair[0].axis == pair[1].axis);
    let axis = both_ends.map_or(missing[0].axis, |pair| pair[0].axis);
    Err(Error::Unobservable {
        parameter: ELEMENT[axis][axis],
        condition: f64::INFINITY,
    })
}

/// vᵀ C v.
pub(crate) fn quadratic_form(c: &[Triple; 3], v: Triple) -> f64 {
    proofmass_core::dot(v, Matrix3(*c).times(v))
}

pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 {
        values[middle]
    } else {
        0.5 * (values[middle - 1] + values[middle])
    }
}
