//! Coefficients for any other program.

use super::Plan;
use crate::{CurvatureBlock, Device, NamedCovariance, ThermalBlock};
use proofmass_io::{Input, Result, Schema, Software, Unit};
use serde::Serialize;

#[derive(Serialize)]
struct Coefficients<'a> {
    schema: Schema,
    software: &'a Software,
    #[serde(skip_serializing_if = "Option::is_none")]
    source: Option<&'a Input>,
    device: &'a Device,
    input_unit: Unit,
    output_unit: Unit,
    equation: &'static str,
    #[serde(rename = "K")]
    k: Vec<Vec<f64>>,
    #[serde(rename = "K_inverse")]
    k_inverse: Vec<Vec<f64>>,
    b: Vec<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    temperature: Option<&'a ThermalBlock>,
    #[serde(skip_serializing_if = "Option::is_none")]
    curvature: Option<&'a CurvatureBlock>,
    covariance: NamedCovariance,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    notes: &'a [String],
    check: Check<'a>,
}

#[derive(Serialize)]
struct Check<'a> {
    outputs: &'a [Vec<f64>],
    #[serde(rename = "temperatures_degC")]
    temperatures: &'a [f64],
    accelerations: &'a [Vec<f64>],
    bound: f64,
}

pub(super) fn text(plan: &Plan<'_>) -> Result<String> {
    let (file, check) = (plan.file, &plan.check);
    let bytes = proofmass_io::finite::to_json(&Coefficients {
        schema: Schema::new("proofmass.coefficients", 1),
        software: &file.software,
        source: plan.source,
        device: &file.device,
        input_unit: file.input_unit,
        output_unit: file.output_unit,
        equation: "d = T - reference; v_i = (output_i - b_i - sum_k bias_ik d^k) / (1 + sum_k scale_ik d^k); \
                   x_i + quadratic_i x_i^2 + cubic_i x_i^3 = v_i / K_ii; a = K_inverse (K_ii x_i)",
        k: plan.model.k(),
        k_inverse: plan.model.k_inverse(),
        b: plan.model.bias(),
        temperature: file.temperature.as_ref(),
        curvature: file.curvature.as_ref(),
        covariance: NamedCovariance::of(&file.estimate),
        notes: plan.notes,
        check: Check {
            outputs: &check.outputs,
            temperatures: &check.temperatures,
            accelerations: &check.accelerations,
            bound: check.double_bound,
        },
    })?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
