//! The results as files: calibration.json, result.json and tables.

use super::data::Data;
use super::title;
use crate::{Failure, clock};
use proofmass::calibration::{DirectionCoverage, Ferraris, StandstillCalibration};
use proofmass::core::Gravity;
use proofmass::io::{CalibrationFile, Cell, ResultDocument, Table};
use proofmass::jobs::campaign::{MethodModel, MultiPositionCampaign};
use proofmass::uncertainty::{DegreesOfFreedom, Finding, Quantity};
use serde::Serialize;

fn gravity_quantity(gravity: Gravity) -> Quantity {
    Quantity {
        name: "gravity".to_owned(),
        unit: "m/s²".to_owned(),
        value: gravity.value(),
        standard_uncertainty: gravity.standard_uncertainty(),
        dof: DegreesOfFreedom::INFINITE,
    }
}

pub(super) fn calibration_file(
    campaign: &MultiPositionCampaign,
    data: &Data,
    calibration: &StandstillCalibration,
) -> CalibrationFile {
    let fit = &calibration.fit;
    let sensor = fit.model();
    let mut file = CalibrationFile::new(
        campaign.method.model.name(),
        data.unit,
        sensor.k().0,
        sensor.bias(),
        fit.estimate().clone(),
    );
    let columns = &campaign.recording.columns;
    file.columns = Some([columns.x.clone(), columns.y.clone(), columns.z.clone()]);
    file.device = campaign.device.clone();
    file.gravity = Some(gravity_quantity(fit.gravity()));
    file.repeatability = Some(fit.excess());
    file.temperature_range = temperature_range(data, calibration).or_else(|| {
        let t = campaign.ambient.temperature_deg_c?;
        Some([t, t])
    });
    let reached = fit.residuals().iter().flat_map(|r| r.acceleration);
    let low = reached.clone().fold(f64::INFINITY, f64::min);
    let high = reached.fold(f64::NEG_INFINITY, f64::max);
    file.acceleration_range = Some([low, high]);
    file.inputs = data.inputs(campaign);
    file
}

fn temperature_range(data: &Data, calibration: &StandstillCalibration) -> Option<[f64; 2]> {
    let temperature = data.temperature.as_ref()?;
    let used = calibration
        .sweep
        .segments
        .iter()
        .flat_map(|s| &temperature[s.start..s.end]);
    let low = used.clone().copied().fold(f64::INFINITY, f64::min);
    let high = used.copied().fold(f64::NEG_INFINITY, f64::max);
    Some([low, high])
}

/// What only this kind of result has.
#[derive(Serialize)]
struct Fit<'a> {
    #[serde(rename = "K")]
    k: [[f64; 3]; 3],
    b: [f64; 3],
    chi_square: f64,
    degrees_of_freedom: usize,
    birge_ratio: Option<f64>,
    excess_m_per_s2: f64,
    condition_number: f64,
    iterations: usize,
    residual_rms_m_per_s2: f64,
    ferraris: Option<Ferraris>,
    direction_coverage: &'a DirectionCoverage,
}

pub(super) fn result(
    campaign: &MultiPositionCampaign,
    data: &Data,
    calibration: &StandstillCalibration,
    findings: &[Finding],
) -> Result<ResultDocument, Failure> {
    let fit = &calibration.fit;
    let mut document = ResultDocument::new("multi-position")
        .title(title(campaign))
        .device(&campaign.device)
        .model(campaign.method.model.name())
        .findings(findings)
        .estimate(fit.estimate(), campaign.method.confidence)
        .quantity(&gravity_quantity(fit.gravity()), campaign.method.confidence);
    for input in data.inputs(campaign) {
        document = document.input(input);
    }
    let sensor = fit.model();
    Ok(document
        .section("date", &clock::today())?
        .section(
            "fit",
            &Fit {
                k: sensor.k().0,
                b: sensor.bias(),
                chi_square: fit.chi_square(),
                degrees_of_freedom: fit.degrees_of_freedom(),
                birge_ratio: fit.birge_ratio(),
                excess_m_per_s2: fit.excess(),
                condition_number: fit.condition(),
                iterations: fit.iterations(),
                residual_rms_m_per_s2: fit.residual_rms(),
                ferraris: (campaign.method.model == MethodModel::Ferraris)
                    .then(|| Ferraris::of(&sensor.k().0)),
                direction_coverage: fit.coverage(),
            },
        )?
        .section("standstills", &fit.residuals())?
        .section("threshold", &calibration.sweep.threshold)?
        .section("threshold_sweep", &calibration.sweep.candidates)?)
}

pub(super) fn parameters(
    campaign: &MultiPositionCampaign,
    calibration: &StandstillCalibration,
) -> Result<Table, Failure> {
    let p = campaign.method.confidence;
    let mut table = Table::new(["quantity", "value", "unit", "u", "U", "k", "nu_eff"]);
    for q in calibration.fit.estimate().quantities() {
        let nu = q.dof.get();
        table.push([
            Cell::from(q.name.as_str()),
            Cell::from(q.value),
            Cell::from(q.unit.as_str()),
            Cell::from(q.standard_uncertainty),
            Cell::from(q.expanded(p)),
            Cell::from(q.coverage_factor(p)),
            Cell::from(nu.is_finite().then_some(nu)),
        ])?;
    }
    Ok(table)
}

pub(super) fn standstills(
    data: &Data,
    calibration: &StandstillCalibration,
) -> Result<Table, Failure> {
    let unit = data.unit.ascii();
    let mut columns = vec![
        "standstill".to_owned(),
        "first_sample".to_owned(),
        "end_sample".to_owned(),
    ];
    columns.extend(["x", "y", "z"].map(|a| format!("output_{a}_{unit}")));
    columns.extend(["x", "y", "z"].map(|a| format!("acceleration_{a}_m/s2")));
    columns.extend(
        [
            "residual_m/s2",
            "residual_noise_m/s2",
            "studentised_residual",
        ]
        .map(str::to_owned),
    );
    let mut table = Table::new(columns);
    for r in calibration.fit.residuals() {
        let mut row = vec![
            Cell::from(r.name.as_str()),
            Cell::from(r.samples.0 as f64),
            Cell::from(r.samples.1 as f64),
        ];
        row.extend(
            r.output
                .iter()
                .chain(&r.acceleration)
                .map(|v| Cell::from(*v)),
        );
        row.push(Cell::from(r.magnitude_residual));
        row.push(Cell::from(r.noise));
        row.push(Cell::from(r.studentised));
        table.push(row)?;
    }
    Ok(table)
}

pub(super) fn covariance(calibration: &StandstillCalibration) -> Result<Table, Failure> {
    let estimate = calibration.fit.estimate();
    let names = estimate.components().iter().map(|c| c.name.clone());
    let mut table = Table::new(std::iter::once("quantity".to_owned()).chain(names));
    let n = estimate.components().len();
    for (i, component) in estimate.components().iter().enumerate() {
        let mut row = vec![Cell::from(component.name.as_str())];
        row.extend((0..n).map(|j| Cell::from(estimate.covariance()[(i, j)])));
        table.push(row)?;
    }
    Ok(table)
}
