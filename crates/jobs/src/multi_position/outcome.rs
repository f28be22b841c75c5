//! What a multi-position calibration found.

use super::page::MultiPositionReport;
use super::{MultiPositionData, MultiPositionJob};
use crate::campaign::MethodModel;
use crate::outcome::{Outcome, section};
use crate::record::Record;
use crate::trouble::Result;
use proofmass_core::Gravity;
use proofmass_io::{
    AnyCalibration, CalibrationFile, Cell, ColumnRef, CurvatureBlock, StatedQuantity, Table,
    ThermalBlock, Unit,
};
use proofmass_report::Report;
use proofmass_signal::Trace;
use proofmass_static::{
    CompensatedReading, DirectionCoverage, Ferraris, Misfit, Model, ModelEvidence, NextAttitude,
    StandstillCalibration, WindowedVariance,
};
use proofmass_uncertainty::{DegreesOfFreedom, Estimate, Finding, Quantity};
use serde::{Deserialize, Serialize};

/// A multi-position calibration: the model with its joint covariance, the standstills, what there is to doubt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MultiPositionOutcome {
    method: MethodModel,
    probability: f64,
    unit: Unit,
    quantities: Vec<StatedQuantity>,
    findings: Vec<Finding>,
    calibration: StandstillCalibration,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    temperature_range: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    columns: Option<[ColumnRef; 3]>,
    figures: Figures,
    /// What a compensated reading is worth over the sphere.
    reading: CompensatedReading,
    /// Where to hold the sensor next.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    next_attitudes: Vec<NextAttitude>,
    /// Other models of the same standstills, with the evidence for each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    models: Vec<ModelEvidence>,
}

/// Attitudes told in advance.
const NEXT: usize = 4;

/// What is drawn of the recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Outputs x, y, z over time, s.
    pub outputs: [Trace; 3],
    /// Windowed variance over its floor against time, where standstills were searched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub windowed: Option<Trace>,
    /// Beginning and end of each standstill, s.
    pub standstills: Vec<(f64, f64)>,
}

impl Figures {
    pub(super) fn new(
        data: &MultiPositionData<'_>,
        windowed: Option<&WindowedVariance>,
        calibration: &StandstillCalibration,
    ) -> Self {
        let steady: Vec<f64>;
        let time = match data.time {
            Some(time) => time,
            None => {
                steady = (0..data.outputs[0].len())
                    .map(|i| i as f64 / data.rate)
                    .collect();
                &steady
            }
        };
        let trace = |values: &[f64]| Trace::new(time, values, Trace::RUNS);
        let at = |sample: usize| time[sample.min(time.len() - 1)];
        let segments = calibration.sweep.segments.iter();
        Self {
            outputs: data.outputs.map(trace),
            windowed: windowed.map(|w| {
                let statistic: Vec<f64> = w.statistic().iter().map(|v| v.max(1e-3)).collect();
                trace(&statistic)
            }),
            standstills: match data.tumble {
                true => Vec::new(),
                false => segments.map(|s| (at(s.start), at(s.end - 1))).collect(),
            },
        }
    }
}

fn gravity_quantity(gravity: Gravity) -> Quantity {
    Quantity {
        name: "gravity".to_owned(),
        unit: "m/s²".to_owned(),
        value: gravity.value(),
        standard_uncertainty: gravity.standard_uncertainty(),
        dof: DegreesOfFreedom::INFINITE,
    }
}

impl MultiPositionOutcome {
    pub(super) fn new(
        job: &MultiPositionJob,
        data: &MultiPositionData<'_>,
        calibration: StandstillCalibration,
        findings: Vec<Finding>,
        figures: Figures,
        models: Vec<ModelEvidence>,
    ) -> Self {
        let fit = &calibration.fit;
        let gravity = gravity_quantity(fit.gravity());
        let quantities = fit.quantities();
        Self {
            method: job.method,
            probability: job.probability,
            unit: data.unit,
            quantities: quantities
                .iter()
                .chain([&gravity])
                .map(|q| StatedQuantity::new(q, job.probability))
                .collect(),
            findings,
            temperature_range: temperature_range(data, &calibration)
                .or(job.temperature.map(|t| [t, t])),
            columns: data.columns.clone(),
            figures,
            reading: fit.compensated_reading(),
            next_attitudes: fit.next_attitudes(NEXT),
            calibration,
            models,
        }
    }

    /// The models that could be fitted, with the evidence for each.
    pub fn models(&self) -> &[ModelEvidence] {
        &self.models
    }

    /// The calibration with everything it went through.
    pub fn calibration(&self) -> &StandstillCalibration {
        &self.calibration
    }

    fn page(&self, record: &Record) -> MultiPositionReport<'_> {
        MultiPositionReport {
            head: record.head(self.title(record), &self.findings),
            method: self.method.name().to_owned(),
            probability: self.probability,
            outputs: Some(&self.figures.outputs),
            windowed: self.figures.windowed.as_ref(),
            standstills: &self.figures.standstills,
            reading: Some(&self.reading),
            next: &self.next_attitudes,
            models: &self.models,
        }
    }

    fn parameters(&self) -> Result<Table> {
        let mut table = Table::new(["quantity", "value", "unit", "u", "U", "k", "nu_eff"]);
        let parameters = self.calibration.fit.estimate().components().len();
        for q in &self.quantities[..parameters] {
            let nu = q.nu_eff.map(|nu| nu.get());
            table.push([
                Cell::from(q.name.as_str()),
                Cell::from(q.value),
                Cell::from(q.unit.as_str()),
                Cell::from(q.u),
                Cell::from(q.expanded),
                Cell::from(q.k),
                Cell::from(nu.filter(|nu| nu.is_finite())),
            ])?;
        }
        Ok(table)
    }

    fn standstills(&self) -> Result<Table> {
        let unit = self.unit.ascii();
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
        for r in self.calibration.fit.residuals() {
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

    fn covariance(&self) -> Result<Table> {
        let estimate = self.calibration.fit.estimate();
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
}

fn temperature_range(
    data: &MultiPositionData<'_>,
    calibration: &StandstillCalibration,
) -> Option<[f64; 2]> {
    let temperature = data.temperature?;
    let segments = calibration.sweep.segments.iter();
    let used = segments.flat_map(|s| &temperature[s.start..s.end]).copied();
    let low = used.clone().fold(f64::INFINITY, f64::min);
    let high = used.fold(f64::NEG_INFINITY, f64::max);
    (low <= high).then_some([low, high])
}

/// Section `fit` of result.json.
#[derive(Serialize)]
struct Fit<'a> {
    #[serde(rename = "K")]
    k: [[f64; 3]; 3],
    #[serde(rename = "K_inverse")]
    k_inverse: [[f64; 3]; 3],
    b: [f64; 3],
    /// "given", or the convention by which the model chooses it.
    frame: &'static str,
    misfits: &'a [Misfit],
    compensated_reading_m_per_s2: &'a CompensatedReading,
    chi_square: Option<f64>,
    degrees_of_freedom: usize,
    birge_ratio: Option<f64>,
    excess_m_per_s2: f64,
    condition_number: f64,
    iterations: usize,
    residual_rms_m_per_s2: f64,
    ferraris: Option<Ferraris>,
    direction_coverage: &'a DirectionCoverage,
}

impl Outcome for MultiPositionOutcome {
    const KIND: &'static str = "multi-position";
    const PRINCIPAL_TABLE: &'static str = "parameters.csv";

    fn title(&self, record: &Record) -> String {
        record.title("Calibration of", "Calibration of a triaxial accelerometer")
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.quantities.clone()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn estimate(&self) -> Option<&Estimate> {
        Some(self.calibration.fit.estimate())
    }

    fn model(&self) -> Option<String> {
        Some(self.method.name().to_owned())
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        let fit = &self.calibration.fit;
        let sensor = fit.model();
        let summary = Fit {
            k: sensor.k().0,
            k_inverse: sensor.k_inverse().0,
            b: sensor.bias(),
            frame: match (fit.attitudes_given(), fit.form()) {
                (true, _) => "given",
                (false, Model::Symmetric) => "symmetric K",
                (false, _) => "upper-triangular K",
            },
            misfits: fit.misfits(),
            compensated_reading_m_per_s2: &self.reading,
            chi_square: fit.chi_square(),
            degrees_of_freedom: fit.degrees_of_freedom(),
            birge_ratio: fit.birge_ratio(),
            excess_m_per_s2: fit.excess(),
            condition_number: fit.condition(),
            iterations: fit.iterations(),
            residual_rms_m_per_s2: fit.residual_rms(),
            ferraris: (self.method == MethodModel::Ferraris).then(|| Ferraris::of(&sensor.k().0)),
            direction_coverage: fit.coverage(),
        };
        let sweep = &self.calibration.sweep;
        Ok(vec![
            section("fit", &summary)?,
            section("standstills", &fit.residuals())?,
            section("models", &self.models)?,
            section("threshold", &sweep.threshold)?,
            section("threshold_sweep", &sweep.candidates)?,
        ])
    }

    fn tables(&self) -> Result<Vec<(String, Table)>> {
        Ok(vec![
            ("parameters.csv".to_owned(), self.parameters()?),
            ("standstills.csv".to_owned(), self.standstills()?),
            ("covariance.csv".to_owned(), self.covariance()?),
        ])
    }

    fn calibration(&self, record: &Record) -> Result<Option<AnyCalibration>> {
        let fit = &self.calibration.fit;
        let sensor = fit.model();
        let mut file = CalibrationFile::new(
            self.method.name(),
            self.unit,
            sensor.k().0,
            sensor.bias(),
            fit.estimate().clone(),
        );
        file.software = record.software.clone();
        file.columns = self.columns.clone();
        file.device = record.device.clone();
        file.gravity = Some(gravity_quantity(fit.gravity()));
        file.repeatability = Some(fit.excess());
        file.temperature_range = self.temperature_range;
        let reached = fit.residuals().iter().flat_map(|r| r.acceleration);
        let low = reached.clone().fold(f64::INFINITY, f64::min);
        let high = reached.fold(f64::NEG_INFINITY, f64::max);
        file.acceleration_range = Some([low, high]);
        if let Some(beyond) = fit.beyond() {
            if let (Some(thermal), Some(range)) = (beyond.thermal, beyond.range) {
                file.temperature = Some(ThermalBlock {
                    reference: thermal.reference,
                    bias: thermal.bias,
                    scale: thermal.scale,
                    range,
                    hysteresis: None,
                });
                file.temperature_range = Some(range);
            }
            file.curvature = beyond.curvature.map(|c| CurvatureBlock {
                quadratic: c.quadratic,
                cubic: c.cubic,
                reach: low.abs().max(high.abs()),
            });
        }
        file.inputs = record.inputs.clone();
        Ok(Some(file.into()))
    }

    fn summary(&self, record: &Record) -> Report {
        self.page(record).summary(&self.calibration)
    }

    fn report(&self, record: &Record) -> Report {
        self.page(record).full(&self.calibration)
    }
}
