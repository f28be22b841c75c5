//! What a multi-position fit gives: the model, the joint estimate, the residuals, the doubts.

use super::causes::{STANDSTILLS, causes, check_determined};
use super::misfit::{self, Misfit};
use super::suspects::{self, Suspect};
use super::terms::TermsAt;
use super::{BIAS, ELEMENT, Model, MultiPosition, Problem, Solved, findings};
use crate::{DirectionCoverage, Pose, Triple};
use faer::Mat;
use proofmass_core::{Compensation, Curvature, Error, Gravity, Matrix3, SensorModel, ThermalTerms};
use proofmass_uncertainty::{BetweenScatter, CommonErrors, Component, Estimate, Finding, Quantity};
use serde::{Deserialize, Serialize};

/// How one standstill agrees with the fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Standard uncertainty of that residual from the noise of the mean alone, m/s²; zero where it is not known.
    pub noise: f64,
    /// a − g u, m/s², where the attitude was given.
    pub vector_residual: Option<Triple>,
    /// Largest residual of this standstill in units of its own standard deviation, the fit's pull on it and
    /// any excess included; `None` where the fit leaves it no freedom.
    pub studentised: Option<f64>,
}

/// Contributions to the standard uncertainty of one quantity from the standstills, in its unit; they add in squares.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScatterParts {
    /// The quantity.
    pub name: String,
    /// Noise within the standstills.
    pub noise: f64,
    /// Own errors of the given attitudes.
    pub attitude: f64,
    /// What varies between the standstills beyond that.
    pub between: f64,
}

/// The result without the standstills that are suspected.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WithoutSuspects {
    /// Who is left out.
    pub suspects: Vec<Suspect>,
    /// The quantities then; `None` where the rest does not determine them.
    pub quantities: Option<Vec<Quantity>>,
}

/// Terms beyond ã = K a + b as they were fitted ([`Terms`](super::Terms)).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BeyondMatrix {
    /// What follows the temperature.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thermal: Option<ThermalTerms<f64>>,
    /// Lowest and highest temperature of the standstills, °C, where it does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// What is not linear.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curvature: Option<Curvature<f64>>,
}

/// Result of a [`MultiPosition`] fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MultiPositionFit {
    pub(crate) model: Model,
    pub(crate) sensor: SensorModel<f64>,
    /// What goes beyond the matrix, where that was fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) beyond: Option<BeyondMatrix>,
    pub(crate) estimate: Estimate,
    pub(crate) quantities: Vec<Quantity>,
    pub(crate) parts: Vec<ScatterParts>,
    pub(crate) probability: f64,
    pub(crate) gravity: Gravity,
    pub(crate) output_unit: String,
    pub(crate) are_accelerations: bool,
    pub(crate) attitudes_given: bool,
    pub(crate) poses: Vec<Pose>,
    pub(crate) residuals: Vec<PoseResidual>,
    pub(crate) coverage: DirectionCoverage,
    pub(crate) chi_square: Option<f64>,
    pub(crate) degrees_of_freedom: usize,
    pub(crate) scatter: Option<BetweenScatter>,
    pub(crate) excess: f64,
    pub(crate) condition: f64,
    pub(crate) iterations: usize,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) effective: Option<f64>,
    pub(crate) misfits: Vec<Misfit>,
    pub(crate) without_suspects: Option<WithoutSuspects>,
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

    /// What goes beyond it, where that was fitted.
    pub fn beyond(&self) -> Option<&BeyondMatrix> {
        self.beyond.as_ref()
    }

    /// The whole compensation, temperature and curvature included.
    pub fn compensation(&self) -> Compensation<f64> {
        let beyond = self.beyond.as_ref();
        Compensation::constant(
            self.sensor,
            beyond.and_then(|b| b.thermal),
            beyond.and_then(|b| b.curvature),
        )
    }

    /// Number of free parameters.
    pub fn parameters(&self) -> usize {
        let components = self.estimate.components().len();
        // A symmetric matrix has nine elements of six parameters.
        components - (self.model.reported_elements().len() - self.model.free_elements().len())
    }

    /// All quantities with their joint covariance: `bias.x … z`, `scale.x … z`, `misalignment.xy …`.
    ///
    /// bias in output units; scale K_ii in output units per m/s²; misalignment K_ij/K_ii in rad.
    pub fn estimate(&self) -> &Estimate {
        &self.estimate
    }

    /// The quantities with their expanded uncertainties at the probability of the fit: the principal result.
    ///
    /// As [`Estimate::quantities`], but that with fewer than four degrees of freedom the scatter of the standstills
    /// and the common errors add as expanded uncertainties
    /// ([`CommonErrors::with_scatter`](proofmass_uncertainty::CommonErrors::with_scatter)).
    pub fn quantities(&self) -> &[Quantity] {
        &self.quantities
    }

    /// One of [`Self::quantities`] by its dotted name.
    pub fn quantity(&self, name: &str) -> Option<&Quantity> {
        self.quantities.iter().find(|q| q.name == name)
    }

    /// The budget row "standstills" of each quantity taken apart.
    pub fn scatter_parts(&self) -> &[ScatterParts] {
        &self.parts
    }

    /// Probability of the intervals of [`Self::quantities`].
    pub fn probability(&self) -> f64 {
        self.probability
    }

    /// Whether outputs are accelerations, so that a bias is one too.
    pub fn are_accelerations(&self) -> bool {
        self.are_accelerations
    }

    /// Whether the attitudes were given; else a rotation and a mirror image of the sensor cannot be seen.
    pub fn attitudes_given(&self) -> bool {
        self.attitudes_given
    }

    /// What was looked for in the residuals, found or not.
    pub fn misfits(&self) -> &[Misfit] {
        &self.misfits
    }

    /// The result without the standstills that are suspected; `None` where none is.
    pub fn without_suspects(&self) -> Option<&WithoutSuspects> {
        self.without_suspects.as_ref()
    }

    /// What the rule for scatter of unknown size says, in natural units (variances in g²); `None` without degrees
    /// of freedom or without known noise.
    pub fn scatter(&self) -> Option<&BetweenScatter> {
        self.scatter.as_ref()
    }

    /// Of the readings of one continuous motion, as many as count as independent; `None` for standstills.
    pub fn effective_readings(&self) -> Option<f64> {
        self.effective
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

    /// χ² of the residuals against the noise of the means (and the attitudes' uncertainty); `None` where the noise is
    /// not known.
    pub fn chi_square(&self) -> Option<f64> {
        self.chi_square
    }

    /// Equations less parameters.
    pub fn degrees_of_freedom(&self) -> usize {
        self.degrees_of_freedom
    }

    /// √(χ²/ν): how many times the residuals exceed what the noise of the means explains; `None` without
    /// degrees of freedom or known noise.
    pub fn birge_ratio(&self) -> Option<f64> {
        let chi_square = self.chi_square.filter(|_| self.degrees_of_freedom > 0)?;
        Some((chi_square / self.degrees_of_freedom as f64).sqrt())
    }

    /// Estimated standard deviation between the standstills beyond the noise, m/s²; zero where the residuals are no
    /// larger than the noise. Where the noise is not known, all of their scatter.
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
        solved: Solved,
    ) -> Result<Self, Error> {
        let model = settings.model;
        let g = settings.gravity.value();
        let parameters = &solved.solution.parameters;
        let kappa = model.matrix(parameters);
        let scale = problem.radius / g;
        let k = kappa.map(|row| row.map(|v| v * scale));
        let bias = std::array::from_fn(|i| problem.centre[i] + problem.radius * parameters[i]);
        let sensor = SensorModel::new(Matrix3(k), bias)?;

        let causes = causes(settings, problem, &solved)?;
        check_determined(problem, settings.limit, &causes)?;
        let unit = &settings.output_unit;
        let beyond = beyond(problem, parameters, sensor)?;
        let (components, jacobian) = quantities(problem, parameters, &k, bias, scale, unit);
        let natural: Vec<Component> = (0..problem.parameters())
            .map(|i| Component::new(problem.parameter_name(i), "1", parameters[i]))
            .collect();
        let estimate = Estimate::new(natural, causes)?.propagate(components, &jacobian)?;
        let quantities = stated(&estimate, &solved, settings.probability);
        let parts = parts(&estimate, &solved, &jacobian);

        let residuals = residuals(problem, &sensor, &solved, g)?;
        let directions: Vec<Triple> = residuals.iter().map(|r| r.acceleration).collect();
        let mut terms = solved.terms();
        let suspects = suspects::accept(problem, &solved, &mut terms);
        let misfits = misfit::of(problem, &solved, &mut terms);
        let mut fit = Self {
            model,
            sensor,
            beyond,
            estimate,
            quantities,
            parts,
            probability: settings.probability,
            gravity: settings.gravity,
            output_unit: unit.clone(),
            are_accelerations: settings.nominal_sensitivity.is_some(),
            attitudes_given: problem.attitudes.is_some(),
            poses: problem.poses.to_vec(),
            residuals,
            coverage: DirectionCoverage::of(&directions),
            chi_square: solved.chi_square,
            degrees_of_freedom: solved.freedom,
            scatter: solved.scatter,
            excess: solved.own.sqrt() * g,
            condition: solved.condition,
            iterations: solved.solution.iterations,
            effective: settings.effective,
            misfits,
            without_suspects: (!suspects.is_empty()).then(|| WithoutSuspects {
                quantities: without(settings, problem.poses, &suspects),
                suspects,
            }),
            findings: Vec::new(),
        };
        fit.findings = findings::of(&fit, &kappa);
        Ok(fit)
    }
}

/// The quantities of a fit to the others.
fn without(
    settings: &MultiPosition,
    poses: &[Pose],
    suspects: &[Suspect],
) -> Option<Vec<Quantity>> {
    let poses = suspects::others(poses, suspects);
    let problem = Problem::new(settings, &poses).ok()?;
    let solved = Solved::of(settings, &problem).ok()?;
    // Suspects of the rest are not chased any further.
    let causes = causes(settings, &problem, &solved).ok()?;
    check_determined(&problem, settings.limit, &causes).ok()?;
    let (g, parameters) = (settings.gravity.value(), &solved.solution.parameters);
    let scale = problem.radius / g;
    let k = settings
        .model
        .matrix(parameters)
        .map(|row| row.map(|v| v * scale));
    let bias = std::array::from_fn(|i| problem.centre[i] + problem.radius * parameters[i]);
    let unit = &settings.output_unit;
    let (components, jacobian) = quantities(&problem, parameters, &k, bias, scale, unit);
    let natural = (0..problem.parameters())
        .map(|i| Component::new(problem.parameter_name(i), "1", parameters[i]))
        .collect();
    let estimate = Estimate::new(natural, causes)
        .ok()?
        .propagate(components, &jacobian)
        .ok()?;
    Some(stated(&estimate, &solved, settings.probability))
}

/// The quantities with the degrees of freedom of their expanded uncertainties.
fn stated(estimate: &Estimate, solved: &Solved, probability: f64) -> Vec<Quantity> {
    estimate
        .quantities()
        .into_iter()
        .map(|quantity| {
            let mut scatter = 0.0;
            let mut common = CommonErrors::new();
            for line in estimate.budget(&quantity.name).unwrap_or_default() {
                if line.key == STANDSTILLS {
                    scatter = line.contribution;
                } else {
                    common = common.with(line.contribution, line.dof);
                }
            }
            if solved.freedom == 0 {
                return quantity;
            }
            let nu = solved.freedom as f64;
            let whole = common.with_scatter(scatter, solved.dof, nu, probability);
            Quantity {
                dof: whole.dof,
                ..quantity
            }
        })
        .collect()
}

/// Noise, attitude and excess as seen in the reported quantities.
fn parts(estimate: &Estimate, solved: &Solved, jacobian: &[f64]) -> Vec<ScatterParts> {
    let w = &solved.weighting;
    let p = solved.solution.parameters.len();
    let noise = solved.through_gain(|i| w.variances[i] - w.tilt[i]);
    let attitude = solved.through_gain(|i| w.tilt[i]);
    let between = solved.through_gain(|_| solved.excess);
    let along = |row: &[f64], m: &Mat<f64>| {
        let mut sum = 0.0;
        for (a, x) in row.iter().enumerate() {
            for (b, y) in row.iter().enumerate() {
                sum += x * y * m[(a, b)];
            }
        }
        sum.max(0.0).sqrt()
    };
    estimate
        .components()
        .iter()
        .zip(jacobian.chunks(p))
        .map(|(component, row)| ScatterParts {
            name: component.name.clone(),
            noise: along(row, &noise),
            attitude: along(row, &attitude),
            between: along(row, &between),
        })
        .collect()
}

/// Reported quantities and their derivatives with respect to the natural parameters.
fn quantities(
    problem: &Problem<'_>,
    parameters: &[f64],
    k: &[Triple; 3],
    bias: Triple,
    scale: f64,
    unit: &str,
) -> (Vec<Component>, Vec<f64>) {
    let (model, radius) = (problem.model, problem.radius);
    let p = problem.parameters();
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
    let first = model.parameters();
    for (number, term) in problem.terms.list.iter().enumerate() {
        let size = problem.terms.unit(*term, radius, problem.gravity);
        components.push(Component::new(
            term.name(),
            term.unit_name(unit),
            parameters[first + number] * size,
        ));
        let mut row = vec![0.0; p];
        row[first + number] = size;
        jacobian.extend(row);
    }
    (components, jacobian)
}

/// The terms in the units of the outputs; curvature that would make too much of a reading is refused.
fn beyond(
    problem: &Problem<'_>,
    parameters: &[f64],
    sensor: SensorModel<f64>,
) -> Result<Option<BeyondMatrix>, Error> {
    let TermsAt {
        list,
        curvature,
        reference,
        range,
        ..
    } = &problem.terms;
    if list.is_empty() {
        return Ok(None);
    }
    let extra = &parameters[problem.model.parameters()..];
    let in_units: Vec<f64> = list
        .iter()
        .zip(extra)
        .map(|(t, v)| v * problem.terms.unit(*t, problem.radius, problem.gravity))
        .collect();
    let (mut thermal, curved) = problem.terms.coefficients(&in_units);
    thermal.reference = *reference;
    let follows = range[1] > range[0];
    let beyond = BeyondMatrix {
        thermal: follows.then_some(thermal),
        range: follows.then_some(*range),
        curvature: curvature.then_some(curved),
    };
    Compensation::new(sensor, beyond.thermal, beyond.curvature, problem.gravity)?;
    Ok(Some(beyond))
}

fn residuals(
    problem: &Problem<'_>,
    sensor: &SensorModel<f64>,
    solved: &Solved,
    g: f64,
) -> Result<Vec<PoseResidual>, Error> {
    let d = problem.each();
    let p = problem.parameters();
    let accelerations = problem.accelerations(&solved.solution.parameters)?;
    let n = problem.rows();
    let equations = &solved.solution.equations;
    // 1 − leverage of each equation, and its residual in units of its own standard deviation.
    let internal = |row: usize| {
        let jacobian = &equations.jacobian[row * p..(row + 1) * p];
        let leverage: f64 = (0..p).map(|c| jacobian[c] * solved.gain[c * n + row]).sum();
        let variance = solved.weighting.variances[row] + solved.own;
        let freedom = 1.0 - leverage;
        (freedom > 1e-6).then(|| equations.residual[row] / (freedom * variance).sqrt())
    };
    // Scaled by the other residuals when they were found to exceed the noise.
    let nu = solved.freedom as f64;
    let external = |t: f64| {
        if solved.excess > 0.0 && nu > 1.0 {
            t / ((nu - t * t).max(1e-3) / (nu - 1.0)).sqrt()
        } else {
            t
        }
    };
    let all = problem
        .poses
        .iter()
        .enumerate()
        .map(|(index, pose)| {
            let a = match problem.terms.list.is_empty() {
                true => sensor.apply(pose.mean),
                false => accelerations[index].map(|v| v * g),
            };
            let direction = crate::direction_coverage::unit(a).unwrap_or([0.0; 3]);
            let w = sensor.k_inverse().transpose().times(direction);
            let noise = pose
                .covariance
                .map_or(0.0, |c| super::quadratic_form(&c, w));
            PoseResidual {
                name: pose.name(index),
                samples: (pose.segment.start, pose.segment.end),
                output: pose.mean,
                acceleration: a,
                magnitude_residual: proofmass_core::norm(a) - g,
                noise: noise.max(0.0).sqrt(),
                vector_residual: problem
                    .attitudes
                    .as_ref()
                    .map(|u| std::array::from_fn(|i| a[i] - g * u[index][i])),
                studentised: (index * d..(index + 1) * d)
                    .filter_map(|row| internal(row).map(external))
                    .max_by(|a, b| a.abs().total_cmp(&b.abs())),
            }
        })
        .collect();
    Ok(all)
}
