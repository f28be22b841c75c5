//! From the solution in natural units to the result: estimate, quantities, residuals, doubts.

use super::causes::{STANDSTILLS, causes, check_determined};
use super::fit::{BeyondMatrix, MultiPositionFit, PoseResidual, ScatterParts, WithoutSuspects};
use super::suspects::Suspect;
use super::terms::TermsAt;
use super::{BIAS, ELEMENT, Model, MultiPosition, Problem, Solved, findings, misfit, suspects};
use crate::{DirectionCoverage, Pose, Triple};
use faer::Mat;
use proofmass_core::{Compensation, Error, Matrix3, SensorModel};
use proofmass_uncertainty::{CommonErrors, Component, Estimate, Quantity};

impl MultiPositionFit {
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
            lengths_given: problem.lengths,
            poses: problem.poses.to_vec(),
            residuals,
            coverage: DirectionCoverage::of(&directions),
            chi_square: solved.chi_square,
            degrees_of_freedom: solved.freedom,
            forms: solved.form_weights(g),
            scatter: solved.scatter.clone(),
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
    // The scatter has the form, or the forms, that the residuals speak for.
    let between = solved.covariance() - &noise - &attitude;
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
    // Exactly one, but where lengths count.
    let length = |index: usize| match &problem.attitudes {
        Some(forces) if problem.lengths => proofmass_core::norm(forces[index]),
        _ => 1.0,
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
                magnitude_residual: proofmass_core::norm(a) - g * length(index),
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
