//! The equations of a multi-position fit in natural units.

use super::observability::observability;
use super::terms::TermsAt;
use super::{AttitudeUncertainty, Model, MultiPosition};
use crate::direction_coverage::unit;
use crate::{Ellipsoid, ForceUncertainty, Pose, Triple};
use faer::Mat;
use proofmass_core::numeric::median;
use proofmass_core::{Error, Matrix3};
use proofmass_uncertainty::adjustment::{Equations, Solution, adjust};
use proofmass_uncertainty::algebra::symmetric_eigen;

/// The fit in natural units: outputs y = (m − c)/(s g), so that y ≈ κ u + β with κ ≈ I and β ≈ 0.
pub(crate) struct Problem<'a> {
    pub(crate) poses: &'a [Pose],
    pub(crate) model: Model,
    /// What is fitted beside the matrix.
    pub(crate) terms: TermsAt,
    /// Given attitudes, when every pose has one: of length one, but where lengths count.
    pub(crate) attitudes: Option<Vec<Triple>>,
    /// Whether the lengths of the attitudes count.
    pub(crate) lengths: bool,
    attitude: AttitudeUncertainty,
    /// Local gravity, m/s².
    pub(crate) gravity: f64,
    /// Centre c, output units.
    pub(crate) centre: Triple,
    /// s g, output units.
    pub(crate) radius: f64,
    points: Vec<Triple>,
    /// Covariances of the points; `None` where that of any pose is not known.
    covariances: Option<Vec<[Triple; 3]>>,
}

/// Variances of the equations, which are turned so that the equations of one standstill are uncorrelated.
#[derive(Clone, Debug, Default)]
pub(crate) struct Weighting {
    /// Rows are the directions along which the three equations of a standstill are taken; empty where there is one.
    pub(crate) rotations: Vec<[Triple; 3]>,
    /// One per equation.
    pub(crate) variances: Vec<f64>,
    /// The part of each variance that comes from the own error of a given attitude.
    pub(crate) tilt: Vec<f64>,
}

impl<'a> Problem<'a> {
    pub(crate) fn new(settings: &MultiPosition, poses: &'a [Pose]) -> Result<Self, Error> {
        let model = settings.model;
        let attitudes: Option<Vec<Triple>> = poses
            .iter()
            .map(|pose| {
                let attitude = pose.segment.attitude?;
                let direction = unit(attitude)?;
                Some(if settings.lengths.is_some() {
                    attitude
                } else {
                    direction
                })
            })
            .collect();
        let each = if attitudes.is_some() { 3 } else { 1 };
        let terms = TermsAt::new(&settings.terms, poses)?;
        model.check_count(poses.len(), each, terms.list.len())?;
        if (model == Model::Full || settings.lengths.is_some()) && attitudes.is_none() {
            // Any rotation of the sensor leaves ‖a‖ as it is.
            return Err(Error::Unobservable {
                parameter: "misalignment.yx",
                condition: f64::INFINITY,
            });
        }
        let g = settings.gravity.value();
        let means: Vec<Triple> = poses.iter().map(|p| p.mean).collect();
        let typical_norm = |all: &[Triple]| {
            let mut norms: Vec<f64> = all.iter().map(|m| proofmass_core::norm(*m)).collect();
            median(&mut norms)
        };
        // Of stated lengths: one where they are those of gravity.
        let length = match settings.lengths {
            Some(_) => attitudes.as_deref().and_then(typical_norm).unwrap_or(1.0),
            None => 1.0,
        };
        let (centre, radius) = match settings.nominal_sensitivity {
            Some(sensitivity) => {
                let radius = sensitivity * g;
                let typical = typical_norm(&means).unwrap_or(0.0) / length;
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
            None => match attitudes.as_deref().filter(|_| settings.lengths.is_some()) {
                // Outputs under forces of different lengths lie on no sphere.
                Some(forces) => by_spread(&means, forces)?,
                None => {
                    let sphere = Ellipsoid::sphere(&means)?;
                    (sphere.centre, sphere.radius())
                }
            },
        };
        let points: Vec<Triple> = means
            .iter()
            .map(|m| std::array::from_fn(|i| (m[i] - centre[i]) / radius))
            .collect();
        let covariances = poses
            .iter()
            .map(|p| Some(p.covariance?.map(|row| row.map(|v| v / radius / radius))))
            .collect();
        Ok(Self {
            poses,
            model,
            terms,
            attitudes,
            lengths: settings.lengths.is_some(),
            attitude: settings.attitude,
            gravity: g,
            centre,
            radius,
            points,
            covariances,
        })
    }

    /// Number of free parameters: of the matrix, then of the terms.
    pub(crate) fn parameters(&self) -> usize {
        self.model.parameters() + self.terms.list.len()
    }

    /// Name of one of them.
    pub(crate) fn parameter_name(&self, index: usize) -> &'static str {
        match index.checked_sub(self.model.parameters()) {
            Some(term) => self.terms.list.get(term).map_or("", |t| t.name()),
            None => self.model.parameter_name(index),
        }
    }

    /// Equations per standstill.
    pub(crate) fn each(&self) -> usize {
        if self.attitudes.is_some() { 3 } else { 1 }
    }

    /// Number of equations.
    pub(crate) fn rows(&self) -> usize {
        self.each() * self.poses.len()
    }

    /// Whether the noise of the means is known.
    pub(crate) fn noise_is_known(&self) -> bool {
        self.covariances.is_some()
    }

    /// Mean output of one standstill in natural units.
    pub(crate) fn point(&self, index: usize) -> Triple {
        self.points[index]
    }

    /// Replaces the noise of the means by one that shrinks with the number of samples: what a sweep compares with.
    pub(crate) fn weigh_by_samples(&mut self) {
        let samples: usize = self.poses.iter().map(|p| p.segment.len()).sum();
        let typical = samples as f64 / self.poses.len() as f64;
        let weigh = |pose: &Pose| {
            let v = typical / pose.segment.len() as f64;
            [[v, 0.0, 0.0], [0.0, v, 0.0], [0.0, 0.0, v]]
        };
        self.covariances = Some(self.poses.iter().map(weigh).collect());
    }

    /// Fit at given variances of the equations, from a start.
    pub(crate) fn adjust(
        &self,
        start: &[f64],
        weighting: &Weighting,
        weights: &[f64],
    ) -> Result<Solution, Error> {
        adjust("multi-position fit", start, weights, |parameters| {
            self.equations(parameters, weighting)
        })
    }

    /// First fit with the noise alone, and the weighting that belongs to where it ended.
    pub(crate) fn first(&self) -> Result<(Solution, Weighting), Error> {
        let start = self.start();
        let weighting = self.weighting(&start)?;
        let name = |i| self.parameter_name(i);
        let p = self.parameters();
        observability(&self.equations(&start, &weighting)?, p, name)?;
        let weights: Vec<f64> = weighting.variances.iter().map(|v| 1.0 / v).collect();
        let mut solution = self.adjust(&start, &weighting, &weights)?;
        let weighting = self.weighting(&solution.parameters)?;
        // Along the directions of this weighting: what appears in the equations is told along them.
        solution.equations = self.equations(&solution.parameters, &weighting)?;
        Ok((solution, weighting))
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
        start.extend(std::iter::repeat_n(0.0, self.terms.list.len()));
        start
    }

    /// Variances of the equations at a point; 1 for each where the noise is not known.
    fn weighting(&self, parameters: &[f64]) -> Result<Weighting, Error> {
        let rows = self.rows();
        let k = Matrix3(self.model.matrix(parameters));
        let mut weighting = Weighting::default();
        match (&self.attitudes, &self.covariances) {
            (None, None) => weighting.variances = vec![1.0; rows],
            (None, Some(covariances)) => {
                let inverse = k.inverse()?;
                let transpose = inverse.transpose();
                let accelerations = self.accelerations(parameters)?;
                for (index, (a, covariance)) in accelerations.iter().zip(covariances).enumerate() {
                    let variance = match unit(*a) {
                        Some(n) => quadratic_form(covariance, transpose.times(n)),
                        None => 0.0,
                    };
                    check_variance(variance, index)?;
                    weighting.variances.push(variance);
                }
                weighting.tilt = vec![0.0; rows];
            }
            (Some(attitudes), covariances) => {
                for (index, u) in attitudes.iter().enumerate() {
                    let tilt =
                        self.tilt_covariance(&k, *u, self.poses[index].segment.force_uncertainty);
                    let noise = match covariances {
                        Some(covariances) => covariances[index],
                        None => Matrix3::identity().0,
                    };
                    let whole = Mat::from_fn(3, 3, |i, j| noise[i][j] + tilt[i][j]);
                    check_variance(whole[(0, 0)], index)?;
                    let eigen = symmetric_eigen(&whole, "eigenvalues of the covariance")
                        .map_err(|_| not_definite(whole[(0, 0)], index))?;
                    let rotation: [Triple; 3] =
                        std::array::from_fn(|k| std::array::from_fn(|i| eigen.U()[(i, k)]));
                    for (axis, &value) in rotation.iter().zip(eigen.S().column_vector().iter()) {
                        check_variance(value, index)?;
                        weighting.variances.push(value);
                        weighting.tilt.push(quadratic_form(&tilt, *axis));
                    }
                    weighting.rotations.push(rotation);
                }
            }
        }
        Ok(weighting)
    }

    /// Residuals and their derivatives.
    ///
    /// r = ‖κ⁻¹(y − β)‖ − 1, one equation for a standstill of unknown attitude; r = y − β − κ u, three equations
    /// along the directions of the weighting, for a given one.
    pub(crate) fn equations(
        &self,
        parameters: &[f64],
        weighting: &Weighting,
    ) -> Result<Equations, Error> {
        if !self.terms.list.is_empty() {
            return self.equations_of_terms(parameters, &weighting.rotations);
        }
        let k = Matrix3(self.model.matrix(parameters));
        let beta = [parameters[0], parameters[1], parameters[2]];
        let p = self.model.parameters();
        let mut equations = Equations {
            residual: Vec::with_capacity(self.rows()),
            jacobian: vec![0.0; self.rows() * p],
        };
        match &self.attitudes {
            None => {
                let inverse = k.inverse()?;
                let transpose = inverse.transpose();
                for (y, row) in self.points.iter().zip(equations.jacobian.chunks_mut(p)) {
                    let a = inverse.times(std::array::from_fn(|i| y[i] - beta[i]));
                    let n = unit(a).ok_or(Error::NotFinite {
                        name: "acceleration of a standstill",
                        index: 0,
                    })?;
                    equations.residual.push(proofmass_core::norm(a) - 1.0);
                    self.model.derivative(transpose.times(n), a, -1.0, row);
                }
            }
            Some(attitudes) => {
                let mut rows = equations.jacobian.chunks_mut(p);
                for ((y, u), rotation) in
                    self.points.iter().zip(attitudes).zip(&weighting.rotations)
                {
                    let expected = k.times(*u);
                    for axis in rotation {
                        let residual = (0..3).map(|i| axis[i] * (y[i] - beta[i] - expected[i]));
                        equations.residual.push(residual.sum());
                        if let Some(row) = rows.next() {
                            self.model.derivative(*axis, *u, -1.0, row);
                        }
                    }
                }
            }
        }
        Ok(equations)
    }

    /// How an error δ of each mean output (natural units) appears in the equations.
    pub(crate) fn in_equations(
        &self,
        parameters: &[f64],
        weighting: &Weighting,
        error: impl Fn(usize) -> Triple,
    ) -> Option<Vec<f64>> {
        let n = self.poses.len();
        if self.attitudes.is_some() {
            let along = |index: usize| {
                let d = error(index);
                weighting.rotations[index].map(|axis| proofmass_core::dot(axis, d))
            };
            return Some((0..n).flat_map(along).collect());
        }
        let inverse = Matrix3(self.model.matrix(parameters)).inverse().ok()?;
        let transpose = inverse.transpose();
        let accelerations = self.accelerations(parameters).ok()?;
        (0..n)
            .map(|index| {
                let direction = unit(accelerations[index])?;
                Some(proofmass_core::dot(
                    transpose.times(direction),
                    error(index),
                ))
            })
            .collect()
    }

    /// Directions of the specific force in the axes of the sensor: as given, else as the fit has them.
    pub(crate) fn directions(&self, parameters: &[f64]) -> Option<Vec<Triple>> {
        if let Some(attitudes) = &self.attitudes {
            return Some(attitudes.clone());
        }
        let accelerations = self.accelerations(parameters).ok()?;
        accelerations.into_iter().map(unit).collect()
    }

    /// Covariance of κ u from the independent uncertainty of u, with n = u/‖u‖: κ (u_across² (I − n nᵀ) + u_along² n nᵀ) κᵀ.
    fn tilt_covariance(
        &self,
        k: &Matrix3<f64>,
        u: Triple,
        own: Option<ForceUncertainty>,
    ) -> [Triple; 3] {
        let n = unit(u).unwrap_or(u);
        let known = own.unwrap_or(ForceUncertainty {
            across: self.attitude.independent * proofmass_core::norm(u),
            along: 0.0,
        });
        let (across, along) = (known.across.powi(2), known.along.powi(2));
        let of_force = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let parallel = n[i] * n[j];
                across * (if i == j { 1.0 } else { 0.0 } - parallel) + along * parallel
            })
        });
        k.product(&Matrix3(of_force)).product(&k.transpose()).0
    }
}

/// Centre and size of outputs by how they spread about their mean beside the forces that made them.
fn by_spread(means: &[Triple], forces: &[Triple]) -> Result<(Triple, f64), Error> {
    let middle = |all: &[Triple]| -> Triple {
        std::array::from_fn(|i| all.iter().map(|v| v[i]).sum::<f64>() / all.len().max(1) as f64)
    };
    let spread = |all: &[Triple], c: Triple| {
        let off = |v: &Triple| (0..3).map(|i| (v[i] - c[i]).powi(2)).sum::<f64>();
        all.iter().map(off).sum::<f64>().sqrt()
    };
    let (of_means, of_forces) = (middle(means), middle(forces));
    let radius = spread(means, of_means) / spread(forces, of_forces);
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(Error::Singular {
            name: "outputs beside the true accelerations",
            condition: f64::INFINITY,
        });
    }
    Ok((
        std::array::from_fn(|i| of_means[i] - radius * of_forces[i]),
        radius,
    ))
}

fn check_variance(variance: f64, index: usize) -> Result<(), Error> {
    if variance > 0.0 && variance.is_finite() {
        Ok(())
    } else {
        Err(not_definite(variance, index))
    }
}

fn not_definite(value: f64, index: usize) -> Error {
    Error::NotPositiveDefinite {
        name: "covariance of a standstill",
        row: index,
        column: index,
        value,
    }
}

/// vᵀ C v.
pub(crate) fn quadratic_form(c: &[Triple; 3], v: Triple) -> f64 {
    proofmass_core::dot(v, Matrix3(*c).times(v))
}
