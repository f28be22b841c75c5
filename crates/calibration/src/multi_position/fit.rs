//! What a multi-position fit gives: the model, the joint estimate, the residuals, the doubts.

use super::{BIAS, ELEMENT, Model, MultiPosition, Problem, UNDETERMINED, findings};
use crate::adjustment::Adjustment;
use crate::{DirectionCoverage, Pose, Triple};
use faer::Mat;
use proofmass_core::{Error, Gravity, Matrix3, SensorModel};
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding, Influence,
};

/// How one standstill agrees with the fit.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PoseResidual {
    /// Name of the standstill.
    pub name: String,
    /// First sample and one past the last.
    pub samples: (usize, usize),
    /// Mean output, output units.
    pub output: Triple,
    /// Compensated acceleration, m/s².
    pub acceleration: Triple,
    /// ‖a‖ − g, m/s².
    pub magnitude_residual: f64,
    /// Standard uncertainty of that residual from the noise of the mean alone, m/s².
    pub noise: f64,
    /// a − g u, m/s², where the attitude was given.
    pub vector_residual: Option<Triple>,
    /// Largest residual of this standstill in units of its own standard deviation, the fit's pull on it and
    /// any excess included; `None` where the fit leaves it no freedom.
    pub studentised: Option<f64>,
}

/// Result of a [`MultiPosition`] fit.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct MultiPositionFit {
    pub(crate) model: Model,
    pub(crate) sensor: SensorModel<f64>,
    pub(crate) estimate: Estimate,
    pub(crate) gravity: Gravity,
    pub(crate) output_unit: String,
    pub(crate) poses: Vec<Pose>,
    pub(crate) residuals: Vec<PoseResidual>,
    pub(crate) coverage: DirectionCoverage,
    pub(crate) chi_square: f64,
    pub(crate) degrees_of_freedom: usize,
    pub(crate) excess: f64,
    pub(crate) condition: f64,
    pub(crate) iterations: usize,
    pub(crate) findings: Vec<Finding>,
}

impl MultiPositionFit {
    /// The compensation itself: `Copy`, without covariance; this goes on the chip.
    pub fn model(&self) -> SensorModel<f64> {
        self.sensor
    }

    /// Which elements were free.
    pub fn form(&self) -> Model {
        self.model
    }

    /// All quantities with their joint covariance: `bias.x … z`, `scale.x … z`, `misalignment.xy …`.
    ///
    /// bias in output units; scale K_ii in output units per m/s²; misalignment K_ij/K_ii in rad.
    pub fn estimate(&self) -> &Estimate {
        &self.estimate
    }

    /// Gravity the fit was made with.
    pub fn gravity(&self) -> Gravity {
        self.gravity
    }

    /// Unit of the outputs.
    pub fn output_unit(&self) -> &str {
        &self.output_unit
    }

    /// The standstills.
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// Residuals, one per standstill.
    pub fn residuals(&self) -> &[PoseResidual] {
        &self.residuals
    }

    /// Root mean square of ‖a‖ − g over the standstills, m/s².
    pub fn residual_rms(&self) -> f64 {
        let sum: f64 = self
            .residuals
            .iter()
            .map(|r| r.magnitude_residual.powi(2))
            .sum();
        (sum / self.residuals.len().max(1) as f64).sqrt()
    }

    /// Which directions the attitudes reach.
    pub fn coverage(&self) -> &DirectionCoverage {
        &self.coverage
    }

    /// χ² of the residuals against the noise of the means (and the attitudes' uncertainty).
    pub fn chi_square(&self) -> f64 {
        self.chi_square
    }

    /// Equations less parameters.
    pub fn degrees_of_freedom(&self) -> usize {
        self.degrees_of_freedom
    }

    /// √(χ²/ν): how many times the residuals exceed what the noise of the means explains; `None` without
    /// degrees of freedom.
    pub fn birge_ratio(&self) -> Option<f64> {
        (self.degrees_of_freedom > 0)
            .then(|| (self.chi_square / self.degrees_of_freedom as f64).sqrt())
    }

    /// Standard deviation common to all standstills that was added to meet the residuals, m/s²; zero when the
    /// noise explains them.
    pub fn excess(&self) -> f64 {
        self.excess
    }

    /// Condition number of the problem in natural units (bias in g, scale relative, angles).
    pub fn condition(&self) -> f64 {
        self.condition
    }

    /// Steps of the iteration.
    pub fn iterations(&self) -> usize {
        self.iterations
    }

    /// What to doubt.
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }

    pub(crate) fn assemble(
        settings: &MultiPosition,
        problem: &Problem<'_>,
        adjustment: Adjustment,
        excess: f64,
        chi_square: f64,
    ) -> Result<Self, Error> {
        let model = settings.model;
        let g = settings.gravity.value();
        let kappa = model.matrix(&adjustment.parameters);
        let scale = problem.radius / g;
        let k = kappa.map(|row| row.map(|v| v * scale));
        let bias =
            std::array::from_fn(|i| problem.centre[i] + problem.radius * adjustment.parameters[i]);
        let sensor = SensorModel::new(Matrix3(k), bias)?;

        let causes = causes(settings, problem, &adjustment, excess)?;
        check_determined(model, &causes)?;
        let unit = &settings.output_unit;
        let (components, jacobian) = quantities(model, &k, bias, scale, problem.radius, unit);
        let natural: Vec<Component> = (0..model.parameters())
            .map(|i| Component::new(model.parameter_name(i), "1", adjustment.parameters[i]))
            .collect();
        let estimate = Estimate::new(natural, causes)?.propagate(components, &jacobian)?;

        let residuals = residuals(problem, &sensor, &adjustment, excess, g);
        let directions: Vec<Triple> = residuals.iter().map(|r| r.acceleration).collect();
        let mut fit = Self {
            model,
            sensor,
            estimate,
            gravity: settings.gravity,
            output_unit: unit.clone(),
            poses: problem.poses.to_vec(),
            residuals,
            coverage: DirectionCoverage::of(&directions),
            chi_square,
            degrees_of_freedom: adjustment.degrees_of_freedom,
            excess: excess.sqrt() * g,
            condition: adjustment.condition,
            iterations: adjustment.iterations,
            findings: Vec::new(),
        };
        fit.findings = findings::of(&fit);
        Ok(fit)
    }
}

/// The independent causes of uncertainty as seen in the natural parameters.
fn causes(
    settings: &MultiPosition,
    problem: &Problem<'_>,
    adjustment: &Adjustment,
    excess: f64,
) -> Result<Vec<Influence>, Error> {
    let gain = &adjustment.gain;
    let (p, rows) = (gain.nrows(), gain.ncols());
    let blocks = problem.equations(&adjustment.parameters)?;
    let d = rows / blocks.len();
    let kappa = Matrix3(problem.model.matrix(&adjustment.parameters));
    let mut noise = Mat::<f64>::zeros(p, p);
    let mut tilt = Mat::<f64>::zeros(p, p);
    let mut noise_level = 0.0;
    for (index, block) in blocks.iter().enumerate() {
        let g = gain.subcols(index * d, d);
        let tilt_part = match &problem.attitudes {
            Some(attitudes) => {
                let t = problem.tilt_covariance(&kappa, attitudes[index]);
                Mat::from_fn(3, 3, |i, j| t[i][j])
            }
            None => Mat::zeros(d, d),
        };
        let noise_part = &block.covariance - &tilt_part;
        noise_level += (0..d).map(|i| block.covariance[(i, i)]).sum::<f64>() / rows as f64;
        noise += g * &noise_part * g.transpose();
        tilt += g * &tilt_part * g.transpose();
    }
    let joint = |m: &Mat<f64>| covariance_of(m);
    let nu = adjustment.degrees_of_freedom as f64;
    let mut causes = vec![Influence {
        key: "noise".to_owned(),
        description: "noise of the standstill means".to_owned(),
        evaluation: Evaluation::A,
        distribution: "normal".to_owned(),
        dof: settings.noise_dof,
        effect: Effect::Joint {
            covariance: joint(&noise)?,
        },
    }];
    if excess > 0.0 {
        // The residuals fix the sum of noise and excess with ν degrees of freedom; seen from the excess alone,
        // which is the smaller part of that sum, it is worth fewer.
        let share = excess / (excess + noise_level);
        let gg = gain * gain.transpose() * faer::Scale(excess);
        causes.push(Influence {
            key: "excess".to_owned(),
            description: "residuals beyond the noise of the means".to_owned(),
            evaluation: Evaluation::A,
            distribution: "normal".to_owned(),
            dof: DegreesOfFreedom::new(nu * share * share).unwrap_or(DegreesOfFreedom::INFINITE),
            effect: Effect::Joint {
                covariance: joint(&gg)?,
            },
        });
    }
    causes.push(gravity(settings, problem, gain, &kappa));
    if let Some(attitudes) = &problem.attitudes {
        if settings.attitude.independent > 0.0 {
            causes.push(Influence {
                key: "attitude".to_owned(),
                description: "attitude of each standstill".to_owned(),
                evaluation: Evaluation::B,
                distribution: "normal".to_owned(),
                dof: DegreesOfFreedom::INFINITE,
                effect: Effect::Joint {
                    covariance: joint(&tilt)?,
                },
            });
        }
        if settings.attitude.common > 0.0 {
            causes.push(Influence {
                key: "attitude-common".to_owned(),
                description: "orientation of the frame of all attitudes".to_owned(),
                evaluation: Evaluation::B,
                distribution: "normal".to_owned(),
                dof: DegreesOfFreedom::INFINITE,
                effect: Effect::Joint {
                    covariance: joint(&frame_rotation(
                        gain,
                        &kappa,
                        attitudes,
                        settings.attitude.common,
                    ))?,
                },
            });
        }
    }
    Ok(causes)
}

/// Gravity: ∂r/∂g = −1/g per equation (unknown attitudes), −κu/g (known), carried through the gain.
fn gravity(
    settings: &MultiPosition,
    problem: &Problem<'_>,
    gain: &Mat<f64>,
    kappa: &Matrix3<f64>,
) -> Influence {
    let g = settings.gravity.value();
    let by_gravity: Vec<f64> = match &problem.attitudes {
        None => vec![-1.0 / g; gain.ncols()],
        Some(attitudes) => attitudes
            .iter()
            .flat_map(|u| kappa.times(*u).map(|v| -v / g))
            .collect(),
    };
    Influence {
        key: "gravity".to_owned(),
        description: "local gravity".to_owned(),
        evaluation: Evaluation::B,
        distribution: "normal".to_owned(),
        dof: DegreesOfFreedom::INFINITE,
        effect: Effect::Scalar {
            value: g,
            unit: "m/s²".to_owned(),
            standard_uncertainty: settings.gravity.standard_uncertainty(),
            sensitivity: through(gain, &by_gravity),
        },
    }
}

/// −G ∂r/∂x: how an input x appears in the parameters.
fn through(gain: &Mat<f64>, derivative: &[f64]) -> Vec<f64> {
    (0..gain.nrows())
        .map(|i| {
            -derivative
                .iter()
                .enumerate()
                .map(|(j, v)| gain[(i, j)] * v)
                .sum::<f64>()
        })
        .collect()
}

/// Covariance of the parameters from one rotation of all attitudes, `u` rad about each axis.
fn frame_rotation(gain: &Mat<f64>, kappa: &Matrix3<f64>, attitudes: &[Triple], u: f64) -> Mat<f64> {
    let p = gain.nrows();
    let mut sum = Mat::zeros(p, p);
    for axis in 0..3 {
        let by_angle: Vec<f64> = attitudes
            .iter()
            .flat_map(|a| {
                // e_axis × a
                let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut turned = [0.0; 3];
                turned[i] = -a[j];
                turned[j] = a[i];
                kappa.times(turned).map(|v| -v)
            })
            .collect();
        let s = through(gain, &by_angle);
        sum += Mat::from_fn(p, p, |i, j| s[i] * s[j] * u * u);
    }
    sum
}

fn covariance_of(m: &Mat<f64>) -> Result<Covariance, Error> {
    let n = m.nrows();
    let rows: Vec<f64> = (0..n)
        .flat_map(|i| (0..n).map(move |j| 0.5 * (m[(i, j)] + m[(j, i)])))
        .collect();
    Covariance::try_from_rows(n, &rows)
}

/// A parameter so uncertain that the linear model itself fails is not a result.
fn check_determined(model: Model, causes: &[Influence]) -> Result<(), Error> {
    let p = model.parameters();
    let mut variance = vec![0.0; p];
    for cause in causes {
        let covariance = cause.effect.covariance(p)?;
        for (i, v) in variance.iter_mut().enumerate() {
            *v += covariance[(i, i)];
        }
    }
    let worst = (0..p)
        .max_by(|&a, &b| variance[a].total_cmp(&variance[b]))
        .unwrap_or(0);
    let u = variance[worst].sqrt();
    if u > UNDETERMINED {
        return Err(Error::TooUncertain {
            parameter: model.parameter_name(worst),
            uncertainty: u,
            limit: UNDETERMINED,
        });
    }
    Ok(())
}

/// Reported quantities and their derivatives with respect to the natural parameters.
fn quantities(
    model: Model,
    k: &[Triple; 3],
    bias: Triple,
    scale: f64,
    radius: f64,
    unit: &str,
) -> (Vec<Component>, Vec<f64>) {
    let p = model.parameters();
    let scale_unit = if unit == "m/s²" {
        "1".to_owned()
    } else {
        format!("{unit}/(m/s²)")
    };
    let mut components = Vec::new();
    let mut jacobian = Vec::new();
    let element_row = |i: usize, j: usize| {
        let mut row = vec![0.0; p];
        let twin = |a, b| model == Model::Symmetric && a == j && b == i;
        for (index, &(a, b)) in model.free_elements().iter().enumerate() {
            if (a, b) == (i, j) || twin(a, b) {
                row[3 + index] = scale;
            }
        }
        row
    };
    for axis in 0..3 {
        components.push(Component::new(BIAS[axis], unit, bias[axis]));
        let mut row = vec![0.0; p];
        row[axis] = radius;
        jacobian.extend(row);
    }
    for &(i, j) in model.reported_elements() {
        if i == j {
            components.push(Component::new(ELEMENT[i][i], scale_unit.clone(), k[i][i]));
            jacobian.extend(element_row(i, i));
        } else {
            components.push(Component::new(ELEMENT[i][j], "rad", k[i][j] / k[i][i]));
            let (off, diagonal) = (element_row(i, j), element_row(i, i));
            let ratio = k[i][j] / k[i][i];
            jacobian.extend(
                off.iter()
                    .zip(&diagonal)
                    .map(|(o, d)| (o - ratio * d) / k[i][i]),
            );
        }
    }
    (components, jacobian)
}

fn residuals(
    problem: &Problem<'_>,
    sensor: &SensorModel<f64>,
    adjustment: &Adjustment,
    excess: f64,
    g: f64,
) -> Vec<PoseResidual> {
    let d = adjustment.whitened.len() / problem.poses.len();
    // Scaled by the residuals themselves when they were found to exceed the noise.
    let nu = adjustment.degrees_of_freedom as f64;
    problem
        .poses
        .iter()
        .enumerate()
        .map(|(index, pose)| {
            let a = sensor.apply(pose.mean);
            let n = crate::direction_coverage::unit(a).unwrap_or([0.0; 3]);
            let w = sensor.k_inverse().transpose().times(n);
            let studentised = (index * d..(index + 1) * d)
                .filter_map(|row| {
                    let freedom = 1.0 - adjustment.leverage[row];
                    let internal = adjustment.whitened[row] / freedom.max(0.0).sqrt();
                    if freedom < 1e-6 {
                        None
                    } else if excess > 0.0 && nu > 1.0 {
                        let scale = (nu - internal * internal).max(1e-3) / (nu - 1.0);
                        Some(internal / scale.sqrt())
                    } else {
                        Some(internal)
                    }
                })
                .max_by(|a, b| a.abs().total_cmp(&b.abs()));
            PoseResidual {
                name: pose.name(index),
                samples: (pose.segment.start, pose.segment.end),
                output: pose.mean,
                acceleration: a,
                magnitude_residual: proofmass_core::norm(a) - g,
                noise: super::quadratic_form(&pose.covariance, w).max(0.0).sqrt(),
                vector_residual: problem
                    .attitudes
                    .as_ref()
                    .map(|u| std::array::from_fn(|i| a[i] - g * u[index][i])),
                studentised,
            }
        })
        .collect()
}
