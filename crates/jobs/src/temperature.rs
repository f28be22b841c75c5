//! How does the output of a resting accelerometer follow its temperature?

mod page;
mod recording;
mod surroundings;

pub use recording::TemperatureRecording;
pub use surroundings::{EnvironmentalColumn, EnvironmentalRequest};

use crate::measured_within::MeasuredWithin;
use crate::outcome::{Job, Outcome, section};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_core::{Error, THERMAL_ORDER, Watch};
use proofmass_documents::{
    AnyCalibration, CalibrationFile, EnvironmentBlock, StatedQuantity, ThermalBlock,
};
use proofmass_io::Unit;
use proofmass_report::Report;
use proofmass_static::{SweepData, TemperatureFit, TemperatureSweep};
use proofmass_uncertainty::{Component, Estimate, Finding};
use serde::{Deserialize, Serialize};

/// How the coefficients are fitted.
///
/// ```
/// use proofmass_io::Unit;
/// use proofmass_jobs::temperature::{TemperatureData, TemperatureJob};
/// use proofmass_jobs::{Job, Unwatched};
///
/// // 0 … 40 °C in a hundred seconds, x by 0.5 mg/K.
/// let temperature: Vec<f64> = (0..1000).map(|i| f64::from(i) / 25.0).collect();
/// let noise = |i: usize, k: usize| ((i * (7919 + 104 * k) % 10_007) as f64 / 10_007.0 - 0.5) * 4e-3;
/// let column = |k: usize, level: f64, slope: f64| -> Vec<f64> {
///     temperature.iter().enumerate().map(|(i, t)| level + slope * t + noise(i, k)).collect()
/// };
/// let (x, y, z) = (column(0, 0.01, 5e-4), column(1, 0.0, 0.0), column(2, 1.0, 0.0));
/// let data = TemperatureData {
///     outputs: vec![&x, &y, &z],
///     unit: Unit::StandardGravity,
///     temperature: &temperature,
///     environment: &[],
///     rate: 10.0,
///     calibration: None,
///     findings: &[],
///     name: "sweep",
/// };
/// let outcome = TemperatureJob::default().evaluate(&data, &Unwatched)?;
/// let slope = outcome.fit().estimate.get("slope.x").unwrap();
/// assert!((slope.value / 9.80665e-3 - 0.5).abs() < 0.02);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct TemperatureJob {
    /// The fit.
    pub sweep: TemperatureSweep,
}

/// A recording of a sensor that stands still while its temperature changes, and the calibration it is to complete.
#[derive(Clone, Debug)]
pub struct TemperatureData<'a> {
    /// Outputs x, y, z in `unit`, or that of a single axis.
    pub outputs: Vec<&'a [f64]>,
    /// Unit of the outputs: an acceleration, or what the calibration takes.
    pub unit: Unit,
    /// Temperature of every sample, °C.
    pub temperature: &'a [f64],
    /// Other quantities of the surroundings.
    pub environment: &'a [EnvironmentalColumn],
    /// Samples per second.
    pub rate: f64,
    /// A calibration at one temperature that gets these coefficients.
    pub calibration: Option<&'a CalibrationFile>,
    /// What reading the data found.
    pub findings: &'a [Finding],
    /// What the recording is called in messages.
    pub name: &'a str,
}

impl Job for TemperatureJob {
    type Data<'a> = TemperatureData<'a>;
    type Outcome = TemperatureOutcome;

    fn evaluate(
        &self,
        data: &TemperatureData<'_>,
        watch: &dyn Watch,
    ) -> Result<TemperatureOutcome> {
        watch.step("temperature", 0, 2)?;
        let mut sweep = self.sweep.clone();
        let accelerations = match data.calibration {
            Some(file) => {
                sweep.reference = Some(self.reference(file)?);
                if file.temperature.is_some() {
                    return Err(Trouble::request(
                        "the calibration follows the temperature already",
                    )
                    .detail(data.name)
                    .with_hint("give the one it was made from, without terms of the temperature"));
                }
                compensated(file, data)?
            }
            None => {
                let (si, factor) = data.unit.si();
                if !si.is_acceleration() {
                    return Err(Trouble::data(format!(
                        "the outputs are in {}, which is no acceleration",
                        data.unit
                    ))
                    .detail(data.name)
                    .with_hint("name the calibration that turns them into accelerations"));
                }
                let in_si = |column: &&[f64]| column.iter().map(|v| v * factor).collect();
                data.outputs.iter().map(in_si).collect::<Vec<Vec<f64>>>()
            }
        };
        let swept = SweepData {
            outputs: accelerations.iter().map(Vec::as_slice).collect(),
            temperature: data.temperature,
            rate: data.rate,
        };
        let environment = surroundings::distinct(data)?;
        let fit = sweep
            .fit_beside(&swept, &environment)
            .map_err(|error| refusal(error, data))?;
        surroundings::told(&fit, data)?;
        watch.step("temperature", 1, 2)?;
        let mut findings = data.findings.to_vec();
        findings.extend(fit.findings.iter().cloned());
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        let calibration = data
            .calibration
            .map(|file| completed(file, &fit))
            .transpose()?;
        watch.step("temperature", 2, 2)?;
        Ok(TemperatureOutcome {
            quantities: StatedQuantity::list(&fit.estimate.quantities(), sweep.probability),
            probability: sweep.probability,
            findings,
            fit,
            calibration,
        })
    }
}

impl TemperatureJob {
    /// The temperature at which K and b of the calibration hold.
    fn reference(&self, file: &CalibrationFile) -> Result<f64> {
        let own = file.temperature_range.map(|[low, high]| 0.5 * (low + high));
        self.sweep.reference.or(own).ok_or_else(|| {
            Trouble::request("the calibration does not say at which temperature it was made")
                .with_hint("say --reference °C")
        })
    }
}

fn compensated(file: &CalibrationFile, data: &TemperatureData<'_>) -> Result<Vec<Vec<f64>>> {
    let (si, factor) = data.unit.si();
    if si != file.input_unit {
        return Err(Trouble::data(format!(
            "the outputs are in {}, the calibration takes {}",
            data.unit, file.input_unit
        ))
        .detail(data.name));
    }
    let outputs = &data.outputs;
    if outputs.len() != file.axes() {
        return Err(Trouble::data(format!(
            "the recording has {} columns of outputs, the calibration has {}",
            outputs.len(),
            file.axes()
        ))
        .detail(data.name));
    }
    if outputs.iter().any(|c| c.len() != outputs[0].len()) {
        return Err(Trouble::data("the columns x, y and z are not equally long").detail(data.name));
    }
    let scaled: Vec<Vec<f64>> = outputs
        .iter()
        .map(|column| column.iter().map(|v| v * factor).collect())
        .collect();
    let columns: Vec<&[f64]> = scaled.iter().map(Vec::as_slice).collect();
    Ok(file.compensation()?.apply_columns(&columns, None))
}

fn refusal(error: Error, data: &TemperatureData<'_>) -> Trouble {
    let hint = match error {
        Error::Unobservable { .. } => {
            "keep the sensor in one attitude while the temperature changes, or record the change in each attitude"
        }
        Error::Constant { .. } => {
            "record a change of temperature that is well above the noise of the thermometer"
        }
        _ => return Trouble::from(error).detail(data.name),
    };
    Trouble::from(error).detail(data.name).with_hint(hint)
}

/// The calibration with the coefficients in its own unit, and one estimate of all.
///
/// A change Δa of the compensated reading is K Δa of the output; relative changes of scale are those of the axes, for
/// misalignment of a hundredth times a difference of 10⁻⁴ is beyond any uncertainty.
fn completed(file: &CalibrationFile, fit: &TemperatureFit) -> Result<CalibrationFile> {
    let mut file = file.clone();
    let top = fit.largest_order;
    let kind = if fit.scale { "bias" } else { "output" };
    let source = &fit.estimate;
    let base = file.estimate.components().len();
    let width = source.components().len();
    let index = |name: &str| {
        source
            .index_of(name)
            .ok_or_else(|| Trouble::data(format!("the fit lacks {name}")))
    };
    let mut components = file.estimate.components().to_vec();
    let mut rows: Vec<Vec<f64>> = vec![vec![0.0; width]; base];
    let mut block = ThermalBlock {
        reference: fit.reference,
        bias: vec![[0.0; THERMAL_ORDER]; file.axes()],
        scale: vec![[0.0; THERMAL_ORDER]; file.axes()],
        range: fit.range,
        hysteresis: None,
    };
    let unit = file.input_unit;
    let named = |kind: &str, axis: usize| fit.blocks.parameter(kind, axis);
    // A term of the bias of an axis, by what it is called and the unit it is per.
    let of_bias = |i: usize, term: &str, per: &str| -> Result<(Component, Vec<f64>)> {
        let mut row = vec![0.0; width];
        for j in 0..file.axes() {
            row[index(&format!("{}.{term}", named(kind, j)))?] = file.k[i][j];
        }
        let terms = row.iter().zip(source.components());
        let value = terms.map(|(r, c)| r * c.value).sum();
        let unit = match per {
            "1" => unit.to_string(),
            per => format!("{unit}/{per}"),
        };
        let name = format!("{}.{term}", named("bias", i));
        Ok((Component::new(name, unit, value), row))
    };
    // A term of the relative scale, which is that of the fit.
    let of_scale = |i: usize, term: &str| -> Result<(Component, Vec<f64>)> {
        let at = index(&format!("{}.{term}", named("scale", i)))?;
        let mut row = vec![0.0; width];
        row[at] = 1.0;
        Ok((source.components()[at].clone(), row))
    };
    let mut around: Vec<EnvironmentBlock> = fit
        .environment
        .iter()
        .map(|course| EnvironmentBlock {
            name: course.name.clone(),
            unit: course.unit.clone(),
            reference: course.reference,
            bias: vec![0.0; file.axes()],
            scale: vec![0.0; file.axes()],
            range: course.range,
        })
        .collect();
    for i in 0..file.axes() {
        let mut add = |(component, row): (Component, Vec<f64>)| {
            let value = component.value;
            components.push(component);
            rows.push(row);
            value
        };
        for power in 1..=top {
            let per = ["K", "K²", "K³"][power - 1];
            block.bias[i][power - 1] = add(of_bias(i, &format!("T{power}"), per)?);
        }
        for power in (1..=top).filter(|_| fit.scale) {
            block.scale[i][power - 1] = add(of_scale(i, &format!("T{power}"))?);
        }
        for quantity in &mut around {
            quantity.bias[i] = add(of_bias(i, &quantity.name, &quantity.unit)?);
            if fit.scale {
                quantity.scale[i] = add(of_scale(i, &quantity.name)?);
            }
        }
    }
    let total = components.len();
    let mut identity = vec![0.0; total * base];
    for i in 0..base {
        identity[i * base + i] = 1.0;
    }
    let own = file.estimate.propagate(components.clone(), &identity)?;
    let thermal = source.propagate(components.clone(), &rows.concat())?;
    let mut influences = own.influences().to_vec();
    influences.extend(thermal.influences().iter().map(|influence| {
        let mut influence = influence.clone();
        influence.key = format!("temperature.{}", influence.key);
        influence
    }));
    file.estimate = Estimate::new(components, influences)?;
    let hysteresis = fit.axes.iter().enumerate().map(|(i, axis)| {
        let h = axis.hysteresis.as_ref()?;
        Some(h.of_a_reading() * file.k[i][i].abs())
    });
    block.hysteresis = hysteresis.collect();
    file.temperature = Some(block);
    file.environment = around;
    file.temperature_range = Some(fit.range);
    Ok(file)
}

/// Temperature coefficients, and the calibration they complete.
#[derive(Clone, Debug, PartialEq)]
pub struct TemperatureOutcome {
    quantities: Vec<StatedQuantity>,
    probability: f64,
    findings: Vec<Finding>,
    fit: TemperatureFit,
    calibration: Option<CalibrationFile>,
}

impl TemperatureOutcome {
    /// The fit itself.
    pub fn fit(&self) -> &TemperatureFit {
        &self.fit
    }
}

impl Outcome for TemperatureOutcome {
    const KIND: &'static str = "temperature";

    fn title(&self, record: &Record) -> String {
        record.title(
            "Temperature coefficients of",
            "Temperature coefficients of an accelerometer",
        )
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.quantities.clone()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn estimate(&self) -> Option<&Estimate> {
        Some(&self.fit.estimate)
    }

    fn model(&self) -> Option<String> {
        Some(format!("polynomial up to order {}", self.fit.largest_order))
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        let within = MeasuredWithin {
            temperature: Some(self.fit.range),
            reference_temperature: Some(self.fit.reference),
            ..MeasuredWithin::default()
        };
        Ok(vec![
            within.section()?,
            section("axes", &self.fit.axes)?,
            section("environment", &self.fit.environment)?,
            section("thermometer_lag_s", &self.fit.thermometer_lag())?,
        ])
    }

    fn calibration(&self, record: &Record) -> Result<Option<AnyCalibration>> {
        Ok(self.calibration.clone().map(|mut file| {
            file.schema = CalibrationFile::schema();
            file.software = record.software.clone();
            file.inputs.extend(record.inputs.iter().cloned());
            file.into()
        }))
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }
}
