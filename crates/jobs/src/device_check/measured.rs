//! What the results of a device say of a limit, in the unit of the limit.

use super::devices::{CheckedDevice, DeviceResult};
use crate::data_sheet::{
    Characteristic, ReadLimit, SheetOutput, axis_of_channel, characteristic_of, unit,
};
use crate::measured_within::MEASURED_WITHIN;
use crate::trouble::Result;
use proofmass_documents::StatedQuantity;
use proofmass_uncertainty::{DegreesOfFreedom, Limits, Measured, Quantity};

/// A value with its interval.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Candidate {
    pub(super) axis: String,
    pub(super) frequency: Option<f64>,
    pub(super) quantity: String,
    /// Place of its result.
    pub(super) result: usize,
    /// None where the data give an upper limit alone.
    pub(super) value: Option<f64>,
    pub(super) interval: (f64, f64),
    /// Probability of the interval.
    pub(super) probability: f64,
    /// Standard uncertainty with its degrees of freedom, where the interval is symmetric.
    u: Option<(f64, DegreesOfFreedom)>,
}

/// Everything that the results of a device say of a limit.
#[derive(Debug, Default)]
pub(super) struct Found {
    pub(super) candidates: Vec<Candidate>,
    /// Quantities in a unit of another kind, with it.
    pub(super) of_another_unit: Vec<String>,
    /// Results at another temperature than those of the limit, or at an unknown one.
    pub(super) elsewhere: Vec<String>,
}

impl Candidate {
    /// Half of the interval.
    pub(super) fn half(&self) -> f64 {
        0.5 * (self.interval.1 - self.interval.0)
    }

    /// The interval with each side longer by a factor.
    pub(super) fn guarded(&self, r: f64) -> (f64, f64) {
        let (low, high) = self.interval;
        let middle = self.value.unwrap_or(low);
        (middle - r * (middle - low), middle + r * (high - middle))
    }

    /// Standard uncertainty, on the side of a direction where the sides differ.
    pub(super) fn standard(&self, upwards: bool) -> f64 {
        let normal = DegreesOfFreedom::INFINITE.coverage_factor(self.probability);
        match (self.u, self.value) {
            (Some((u, _)), _) => u,
            (None, Some(v)) if upwards => (self.interval.1 - v) / normal,
            (None, Some(v)) => (v - self.interval.0) / normal,
            (None, None) => self.half() / normal,
        }
    }

    /// Probability that the limits hold, where a value is known.
    pub(super) fn conforms(&self, limits: &Limits) -> Option<f64> {
        let value = self.value?;
        // The side of the interval that lies towards the nearer limit.
        let sides = [limits.lower, limits.upper];
        let away = |limit: &f64| (limit - value).abs();
        let nearer = sides.into_iter().flatten();
        let nearer = nearer.min_by(|a, b| away(a).total_cmp(&away(b)))?;
        let upwards = nearer >= value;
        let measured = Measured::of(&Quantity {
            name: self.quantity.clone(),
            unit: String::new(),
            value,
            standard_uncertainty: self.standard(upwards),
            dof: self.u.map_or(DegreesOfFreedom::INFINITE, |(_, dof)| dof),
        });
        Some(limits.probability(&measured))
    }
}

/// What the results of a device say of a limit.
///
/// # Errors
/// A result whose estimate says otherwise than its quantities.
pub(super) fn found(
    limit: &ReadLimit,
    device: &CheckedDevice,
    results: &[DeviceResult],
    zero: Option<&SheetOutput>,
) -> Result<Found> {
    let mut found = Found::default();
    for &at in &device.results {
        let result = &results[at];
        if let Some([low, high]) = limit.temperature {
            let within = temperature(result)
                .is_some_and(|[a, b]| a >= low - THERMOMETER && b <= high + THERMOMETER);
            if !within {
                found.elsewhere.push(result.name.clone());
                continue;
            }
        }
        match limit.characteristic {
            Characteristic::Noise(_) => noise(limit, at, result, &mut found)?,
            Characteristic::Of(known) => {
                let mut all = Vec::new();
                for q in &result.document.quantities {
                    let shown = characteristic_of(result.kind(), &q.name);
                    if let Some((name, axis, frequency)) = shown
                        && name == known.name
                        && limit.is_for(&axis)
                        && limit.holds_at(frequency)
                    {
                        all.push((q, axis, frequency));
                    }
                }
                // The mean slope over the range is what a data sheet means, where the result has it.
                if all.iter().any(|(q, ..)| q.name.starts_with("slope")) {
                    all.retain(|(q, ..)| q.name.starts_with("slope"));
                }
                for (q, axis, frequency) in all {
                    match converted((q, &axis), limit, result, zero)? {
                        Some(c) => found.candidates.push(Candidate {
                            axis,
                            frequency,
                            quantity: q.name.clone(),
                            result: at,
                            ..c
                        }),
                        None => found
                            .of_another_unit
                            .push(format!("{} in {} ({})", q.name, q.unit, result.name)),
                    }
                }
            }
        }
    }
    Ok(found)
}

/// Temperatures this near to the end of a range are at its end, K.
const THERMOMETER: f64 = 0.5;

/// Lowest and highest temperature at which a result was measured, as far as it says.
fn temperature(result: &DeviceResult) -> Option<[f64; 2]> {
    let extra = &result.document.extra;
    let range = extra
        .get(MEASURED_WITHIN)
        .and_then(|within| within.get("temperature_degC"))
        .and_then(|range| Some([range.get(0)?.as_f64()?, range.get(1)?.as_f64()?]));
    range.or_else(|| {
        let ambient = extra.get("ambient")?.get("temperature_degC")?.as_f64()?;
        Some([ambient, ambient])
    })
}

/// The channels of a noise result.
fn noise(limit: &ReadLimit, at: usize, result: &DeviceResult, found: &mut Found) -> Result<()> {
    let (Some(analysis), Some(mut wanted)) = (&result.analysis, limit.noise()) else {
        return Ok(());
    };
    // Axes and channels are told apart here.
    wanted.channels.clear();
    for channel in &analysis.channels {
        if !limit.is_for(&channel.name) {
            continue;
        }
        let probability = channel.whittle.as_ref().map_or(0.95, |w| w.probability);
        let check = wanted.check(channel, analysis.sample_rate)?;
        let Some(check) = check.and_then(|c| c.found) else {
            continue;
        };
        found.candidates.push(Candidate {
            axis: axis_of_channel(&channel.name)
                .map_or_else(|| channel.name.clone(), str::to_owned),
            frequency: None,
            quantity: format!("{}.{}", channel.name, limit.characteristic.name()),
            result: at,
            value: check
                .value
                .filter(|v| *v >= check.interval.0 && *v <= check.interval.1),
            interval: check.interval,
            probability,
            u: None,
        });
    }
    Ok(())
}

/// A quantity in the unit of a limit: by a factor, or of an output by its scale.
fn converted(
    (q, axis): (&StatedQuantity, &str),
    limit: &ReadLimit,
    result: &DeviceResult,
    zero: Option<&SheetOutput>,
) -> Result<Option<Candidate>> {
    let of = |value: f64, interval: (f64, f64), u: Option<(f64, DegreesOfFreedom)>| Candidate {
        axis: String::new(),
        frequency: None,
        quantity: String::new(),
        result: 0,
        value: Some(value),
        interval,
        probability: q.probability,
        u,
    };
    let dof = q.nu_eff.unwrap_or(DegreesOfFreedom::INFINITE);
    if let Some(factor) = unit::ratio(&q.unit, &limit.unit) {
        let interval = match q.interval {
            Some([low, high]) => (low, high),
            None => (q.value - q.expanded, q.value + q.expanded),
        };
        let u = q.u.filter(|_| q.interval.is_none());
        return Ok(Some(of(
            factor * q.value,
            (factor * interval.0, factor * interval.1),
            u.map(|u| (factor * u, dof)),
        )));
    }
    if !limit.characteristic.name().starts_with("bias") {
        return Ok(None);
    }
    let Some(estimate) = result.document.stated()? else {
        return Ok(None);
    };
    let scales = match axis {
        "" => vec!["scale".to_owned(), "sensitivity".to_owned()],
        axis => vec![format!("scale.{axis}")],
    };
    let scale = scales.iter().find_map(|name| estimate.index_of(name));
    let (Some(bias), Some(scale)) = (estimate.index_of(&q.name), scale) else {
        return Ok(None);
    };
    let (b, s) = (&estimate.components()[bias], &estimate.components()[scale]);
    // b − zero = x S, with x in the unit of the limit.
    let product = match limit.unit.split_once('/') {
        // A calendar unit stays outside of the brackets.
        Some((before, after @ ("month" | "year"))) => format!("({before})·({})/{after}", s.unit),
        _ => format!("({})·({})", limit.unit, s.unit),
    };
    let Some(factor) = unit::ratio(&b.unit, &product) else {
        return Ok(None);
    };
    // A coefficient of the temperature or of time knows no zero.
    let zero = match zero.filter(|_| limit.characteristic.name() == "bias") {
        None => 0.0,
        Some(zero) => match unit::ratio(&zero.unit, &b.unit) {
            Some(ratio) => ratio * zero.zero,
            None => return Ok(None),
        },
    };
    if !(s.value.abs() > 0.0) {
        return Ok(None);
    }
    let over = b.value - zero;
    let covariance = estimate.covariance();
    let (db, ds) = (1.0 / s.value, -over / (s.value * s.value));
    let variance = db * db * covariance[(bias, bias)]
        + 2.0 * db * ds * covariance[(bias, scale)]
        + ds * ds * covariance[(scale, scale)];
    let value = factor * over / s.value;
    let u = factor * variance.max(0.0).sqrt();
    let half = u * q.k.unwrap_or_else(|| dof.coverage_factor(q.probability));
    if !(value.is_finite() && half.is_finite()) {
        return Ok(None);
    }
    Ok(Some(of(
        value,
        (value - half, value + half),
        Some((u, dof)),
    )))
}
