//! The certificate of the reference standard: sensitivity against frequency, between and never beyond its points.

use crate::frequency_response::FrequencyResponse;
use crate::model::ModelFit;
use crate::monotone_cubic::{MonotoneCubic, interval};
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_signal::transfer::polar;
use proofmass_uncertainty::{Component, Covariance, Effect, Estimate, Influence};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// One line of the certificate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ReferencePoint {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Sensitivity modulus in V/(m/s²).
    pub sensitivity: f64,
    /// Phase in radians.
    pub phase: f64,
    /// Relative standard uncertainty of the modulus.
    pub modulus_uncertainty: f64,
    /// Standard uncertainty of the phase in radians.
    pub phase_uncertainty: f64,
}

impl ReferencePoint {
    /// Mean of repeats at one frequency: its variance is the mean of the stated ones and that of the mean by their scatter.
    pub fn mean(group: &[Self]) -> Self {
        let n = group.len() as f64;
        let first = group[0];
        if group.len() == 1 {
            return first;
        }
        let mean = |of: &dyn Fn(&Self) -> f64| group.iter().map(of).sum::<f64>() / n;
        let scatter = |of: &dyn Fn(&Self) -> f64, mean: f64| {
            group.iter().map(|p| (of(p) - mean).powi(2)).sum::<f64>() / (n - 1.0) / n
        };
        // Turns are counted from the first row's phase.
        let turned = |p: &Self| {
            let turn = std::f64::consts::TAU;
            p.phase - turn * ((p.phase - first.phase) / turn).round()
        };
        let sensitivity = mean(&|p| p.sensitivity);
        let phase = mean(&turned);
        let stated = mean(&|p| p.modulus_uncertainty.powi(2));
        let apart = scatter(&|p| p.sensitivity, sensitivity) / (sensitivity * sensitivity);
        let angle = mean(&|p| p.phase_uncertainty.powi(2));
        Self {
            frequency: first.frequency,
            sensitivity,
            phase,
            modulus_uncertainty: (stated + apart).sqrt(),
            phase_uncertainty: (angle + scatter(&turned, phase)).sqrt(),
        }
    }
}

/// A certificate, in ascending frequency.
///
/// What its points have in common is an error of every frequency at once, which no number of frequencies averages away. A
/// document that says nothing of it is taken as wholly common.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ReferenceTable {
    /// Sensitivity at each frequency, in ascending order.
    points: Vec<ReferencePoint>,
    /// Standard uncertainty that each point has for itself alone, of modulus (relative) and phase (rad).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    own: Option<Vec<[f64; 2]>>,
    /// Largest relative error of the curve between each two points, where it was estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    between: Option<Vec<f64>>,
}

/// Relative error of a frequency that is read back from a recording.
const SLACK: f64 = 1e-4;
/// Frequencies of a fitted model between each two points of what it was fitted to.
const BETWEEN: usize = 8;

impl ReferenceTable {
    /// Points in any order; frequencies must differ.
    ///
    /// # Errors
    /// [`Error::TooFew`] without a point, [`Error::NotFinite`], [`Error::OutOfRange`] for a frequency or a
    /// sensitivity that is not positive, or a frequency given twice.
    pub fn new(mut points: Vec<ReferencePoint>) -> Result<Self, Error> {
        if points.is_empty() {
            return Err(Error::TooFew {
                name: "reference table",
                needed: 1,
                got: 0,
            });
        }
        for (index, p) in points.iter().enumerate() {
            let numbers = [
                p.frequency,
                p.sensitivity,
                p.phase,
                p.modulus_uncertainty,
                p.phase_uncertainty,
            ];
            if numbers.iter().any(|v| !v.is_finite()) {
                return Err(Error::NotFinite {
                    name: "reference table",
                    index,
                });
            }
            for (name, value) in [
                ("frequency of the reference table", p.frequency),
                ("sensitivity of the reference table", p.sensitivity),
            ] {
                if value <= 0.0 {
                    return Err(Error::OutOfRange {
                        name,
                        value,
                        min: f64::MIN_POSITIVE,
                        max: f64::MAX,
                    });
                }
            }
        }
        points.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        if let Some(pair) = points.windows(2).find(|p| p[0].frequency == p[1].frequency) {
            return Err(Error::OutOfRange {
                name: "frequency given twice in the reference table",
                value: pair[1].frequency,
                min: pair[0].frequency,
                max: f64::MAX,
            });
        }
        Ok(Self {
            points,
            own: None,
            between: None,
        })
    }

    /// One element of a calibrated frequency response; `scale` turns its unit into V/(m/s²).
    ///
    /// What the response says its frequencies share is common, the rest of each frequency alone. The curve between the points
    /// has the error that the points themselves show of it.
    ///
    /// **Accuracy** [`FrequencyResponse::interpolation_error`].
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for an element that is not there, else as [`ReferenceTable::new`].
    pub fn of_response(
        response: &FrequencyResponse,
        output: usize,
        axis: usize,
        scale: f64,
    ) -> Result<Self, Error> {
        let re = response.real_part(output, axis)?;
        let series = response.series();
        let mut points = Vec::new();
        let mut own = Vec::new();
        for (i, point) in series.points().iter().enumerate() {
            let (c, v) = (point.estimate.components(), point.estimate.covariance());
            let z = Complex64::new(c[re].value, c[re + 1].value);
            let (u, turn) = polar(z, [v[(re, re)], v[(re, re + 1)], v[(re + 1, re + 1)]]);
            let u = u / z.norm();
            points.push(ReferencePoint {
                frequency: point.at,
                sensitivity: scale * z.norm(),
                phase: z.arg(),
                modulus_uncertainty: u,
                phase_uncertainty: turn,
            });
            let mut alone = [u * u, turn * turn];
            for effect in series.shared().unwrap_or_default() {
                let e = &effect.effects[i];
                let e = Complex64::new(e[re], e[re + 1]) / z;
                alone[0] -= e.re * e.re;
                alone[1] -= e.im * e.im;
            }
            own.push(alone.map(|v| v.max(0.0).sqrt()));
        }
        let mut table = Self::new(points)?;
        table.own = series.shared().is_some().then_some(own);
        table.between = response.interpolation_error();
        Ok(table)
    }

    /// A fitted model, at the frequencies of what it was fitted to and between them; `scale` turns its unit into V/(m/s²). All of
    /// its uncertainty is that of its parameters, and so in common.
    ///
    /// # Errors
    /// As [`ReferenceTable::new`]; an estimate without the model's parameters.
    pub fn of_model(fit: &ModelFit, scale: f64) -> Result<Self, Error> {
        let mut knots: Vec<f64> = fit.residuals.iter().map(|r| r[0]).collect();
        knots.sort_by(f64::total_cmp);
        knots.dedup();
        let mut frequencies = Vec::new();
        for pair in knots.windows(2) {
            let ratio = pair[1] / pair[0];
            frequencies
                .extend((0..BETWEEN).map(|k| pair[0] * ratio.powf(k as f64 / BETWEEN as f64)));
        }
        frequencies.extend(knots.last());
        let points = fit
            .at(&frequencies)?
            .into_iter()
            .zip(&frequencies)
            .map(|((z, covariance), &frequency)| {
                let (u, turn) = polar(z, covariance);
                ReferencePoint {
                    frequency,
                    sensitivity: scale * z.norm(),
                    phase: z.arg(),
                    modulus_uncertainty: u / z.norm(),
                    phase_uncertainty: turn,
                }
            })
            .collect();
        let mut table = Self::new(points)?;
        // The model is the curve.
        table.between = Some(vec![0.0; table.points.len().saturating_sub(1)]);
        Ok(table)
    }

    /// The points.
    pub fn points(&self) -> &[ReferencePoint] {
        &self.points
    }

    /// Lowest and highest frequency, Hz.
    pub fn range(&self) -> [f64; 2] {
        let end = |p: Option<&ReferencePoint>| p.map_or(0.0, |p| p.frequency);
        [end(self.points.first()), end(self.points.last())]
    }

    /// From where to where it says something of a frequency, Hz: a little beyond its first and its last point, as the clocks of a
    /// generator and a recorder agree (1e-4).
    pub fn reach(&self) -> [f64; 2] {
        let [first, last] = self.range();
        [first * (1.0 - SLACK), last * (1.0 + SLACK)]
    }

    /// Sensitivity at a frequency: monotone cubic in log f for modulus and phase (Fritsch–Carlson), uncertainty
    /// as the weighted sum of those of the two neighbours.
    ///
    /// Points of one certificate share most of their causes, so their uncertainties are taken as fully
    /// correlated: an interpolated value is never better known than its neighbours. To these comes what is not known of the curve
    /// between its points ([`Self::interpolation_at`]).
    ///
    /// Phases are followed from point to point, so neighbours must be less than half a turn apart.
    ///
    /// **Source** `[FritschCarlson1980]`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] beyond the first and the last point: a certificate says nothing there.
    pub fn at(&self, frequency: f64) -> Result<ReferencePoint, Error> {
        let (first, last) = (self.points[0], self.points[self.points.len() - 1]);
        let [low, high] = self.reach();
        if !(low..=high).contains(&frequency) {
            return Err(Error::OutOfRange {
                name: "frequency for the reference table",
                value: frequency,
                min: first.frequency,
                max: last.frequency,
            });
        }
        if self.points.len() == 1 {
            return Ok(ReferencePoint { frequency, ..first });
        }
        let x: Vec<f64> = self.points.iter().map(|p| p.frequency.ln()).collect();
        let (k, t) = interval(&x, frequency.clamp(first.frequency, last.frequency).ln());
        let (a, b) = (self.points[k], self.points[k + 1]);
        let moduli: Vec<f64> = self.points.iter().map(|p| p.sensitivity).collect();
        let mut phases: Vec<f64> = self.points.iter().map(|p| p.phase).collect();
        for i in 1..phases.len() {
            // 179° and −179° are two degrees apart.
            let step = phases[i] - phases[i - 1];
            phases[i] -= TAU * (step / TAU).round();
        }
        let slip = self.slip(k, t);
        Ok(ReferencePoint {
            frequency,
            sensitivity: MonotoneCubic::new(&x, &moduli).at(k, t),
            phase: MonotoneCubic::new(&x, &phases).at(k, t),
            modulus_uncertainty: ((1.0 - t) * a.modulus_uncertainty + t * b.modulus_uncertainty)
                .hypot(slip[0]),
            phase_uncertainty: ((1.0 - t) * a.phase_uncertainty + t * b.phase_uncertainty)
                .hypot(slip[1]),
        })
    }

    /// Standard uncertainties of the curve itself within an interval, from zero at its ends: of modulus (relative) and phase (rad).
    ///
    /// A bound between the points, rectangular; rising and falling as the error of a cubic does. Where nobody estimated it, the bound is half the
    /// step from point to point: the curve is taken to stay between its neighbours, and no better known than that it is there.
    fn slip(&self, k: usize, t: f64) -> [f64; 2] {
        let within = 4.0 * t * (1.0 - t) / 3f64.sqrt();
        let bound = match self.between.as_ref().and_then(|b| b.get(k)) {
            Some(e) => [*e; 2],
            None => {
                let (a, b) = (self.points[k], self.points[k + 1]);
                let turn = b.phase - a.phase;
                let step = [
                    2.0 * (b.sensitivity - a.sensitivity) / (a.sensitivity + b.sensitivity),
                    turn - TAU * (turn / TAU).round(),
                ];
                step.map(|d| 0.5 * d.abs())
            }
        };
        bound.map(|b| within * b)
    }

    /// Where a frequency lies between two points: the place of the lower one, and how far it is to the next in the logarithm.
    fn between_points(&self, frequency: f64) -> Option<(usize, f64)> {
        if self.points.len() < 2 {
            return None;
        }
        let x: Vec<f64> = self.points.iter().map(|p| p.frequency.ln()).collect();
        let [first, last] = self.range();
        Some(interval(&x, frequency.clamp(first, last).ln()))
    }

    /// Standard uncertainties of modulus (relative) and phase (rad) for the curve between the points, which those of [`Self::at`] contain:
    /// zero at a point, and for half the step between the two neighbours in the middle (or the estimated error of a calibrated response),
    /// rectangular.
    pub fn interpolation_at(&self, frequency: f64) -> [f64; 2] {
        self.between_points(frequency)
            .map_or([0.0; 2], |(k, t)| self.slip(k, t))
    }

    /// The two points that a frequency lies between, Hz, where it is none of them itself.
    pub fn neighbours(&self, frequency: f64) -> Option<[f64; 2]> {
        let (k, _) = self.between_points(frequency)?;
        let ends = [self.points[k].frequency, self.points[k + 1].frequency];
        let one = |end: &f64| (frequency / end - 1.0).abs() <= SLACK;
        (!ends.iter().any(one)).then_some(ends)
    }

    /// Standard uncertainties of modulus (relative) and phase (rad) at a frequency, of its own and in common with all others.
    ///
    /// # Errors
    /// As [`ReferenceTable::at`].
    pub fn shares_at(&self, frequency: f64) -> Result<ReferenceShares, Error> {
        let p = self.at(frequency)?;
        let whole = [p.modulus_uncertainty, p.phase_uncertainty];
        let own = match (&self.own, self.between_points(frequency)) {
            (Some(own), Some((k, t))) => {
                let slip = self.slip(k, t);
                let of = |i: usize| own.get(i).copied().unwrap_or_default();
                let (a, b) = (of(k), of(k + 1));
                [0, 1].map(|i| ((1.0 - t) * a[i] + t * b[i]).hypot(slip[i]).min(whole[i]))
            }
            (Some(own), None) => own.first().copied().unwrap_or_default(),
            // The course between two points is nobody else's error.
            (None, Some((k, t))) => self.slip(k, t),
            (None, None) => [0.0; 2],
        };
        let common = [0, 1].map(|i| (whole[i] * whole[i] - own[i] * own[i]).max(0.0).sqrt());
        Ok(ReferenceShares { own, common })
    }

    /// Acceleration behind a voltage of the reference, m/s²: V over S e^{jφ}.
    ///
    /// # Errors
    /// As [`ReferenceTable::at`].
    pub fn acceleration(&self, voltage: Complex64, frequency: f64) -> Result<Complex64, Error> {
        let p = self.at(frequency)?;
        Ok(voltage / Complex64::from_polar(p.sensitivity, p.phase))
    }
}

/// Uncertainty of the reference at a frequency by what it has in common with other frequencies: of the modulus (relative) and of the
/// phase (rad).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ReferenceShares {
    /// Of this frequency alone.
    pub own: [f64; 2],
    /// Of all frequencies at once.
    pub common: [f64; 2],
}

/// A certificate says nothing of the correlation of its lines.
impl TryFrom<&ReferenceTable> for FrequencyResponse {
    type Error = Error;

    /// In volts.
    fn try_from(table: &ReferenceTable) -> Result<Self, Error> {
        Self::of_table(table, "V/(m/s²)")
    }
}

impl FrequencyResponse {
    /// A table of modulus and phase, the sensitivities of which are in `unit`.
    ///
    /// # Errors
    /// As [`FrequencyResponse::from_polar`].
    pub fn of_table(table: &ReferenceTable, unit: &str) -> Result<Self, Error> {
        let polar = |p: &ReferencePoint| {
            let u = [p.sensitivity * p.modulus_uncertainty, p.phase_uncertainty];
            let influence = Influence::normal(
                "certificate",
                "uncertainty of the certificate",
                Effect::Joint {
                    covariance: Covariance::from_standard_uncertainties(&u)?,
                },
            );
            let components = vec![
                Component::new("modulus", unit, p.sensitivity),
                Component::new("phase", "rad", p.phase),
            ];
            Ok((p.frequency, Estimate::new(components, vec![influence])?))
        };
        let points = table
            .points
            .iter()
            .map(polar)
            .collect::<Result<Vec<_>, Error>>()?;
        let points: Vec<(f64, &Estimate)> = points.iter().map(|(f, e)| (*f, e)).collect();
        Self::from_polar("axis", &points, None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> ReferenceTable {
        let points = include_str!("../tests/inrim-pcb356a15/reference-accelerometer.csv")
            .lines()
            .skip(1)
            .map(|l| {
                let v: Vec<f64> = l.split(',').map(|f| f.parse().unwrap()).collect();
                ReferencePoint {
                    frequency: v[0],
                    sensitivity: 1e-3 * v[2],
                    phase: 0.0,
                    modulus_uncertainty: v[3] / 200.0,
                    phase_uncertainty: 0.0,
                }
            })
            .collect();
        ReferenceTable::new(points).unwrap()
    }

    #[test]
    fn published_points_are_returned_and_the_curve_is_monotone_between() {
        let t = table();
        assert!((t.at(160.0).unwrap().sensitivity - 9.914e-3).abs() < 1e-15);
        assert!((t.at(160.0).unwrap().modulus_uncertainty - 0.002).abs() < 1e-15);
        let mut last = f64::INFINITY;
        for i in 0..=100 {
            let f = 160.0 * (315f64 / 160.0).powf(f64::from(i) / 100.0);
            let s = t.at(f).unwrap().sensitivity;
            assert!(s <= last && (9.879e-3 - 1e-12..=9.914e-3 + 1e-12).contains(&s));
            last = s;
        }
    }

    #[test]
    fn known_phases_are_followed_through_half_a_turn() {
        // An inverted reference: −179° and 179° are two degrees apart, not 358.
        let point = |frequency: f64, phase: f64| ReferencePoint {
            frequency,
            sensitivity: 0.01,
            phase: phase.to_radians(),
            modulus_uncertainty: 0.0,
            phase_uncertainty: 0.0,
        };
        let t = ReferenceTable::new(vec![point(100.0, 179.0), point(400.0, -179.0)]).unwrap();
        assert!((t.at(200.0).unwrap().phase.to_degrees() - 180.0).abs() < 1e-9);
    }

    #[test]
    fn known_uncertainty_between_two_points() {
        let point = |frequency: f64, sensitivity: f64, phase: f64| ReferencePoint {
            frequency,
            sensitivity,
            phase,
            modulus_uncertainty: 0.002,
            phase_uncertainty: 0.001,
        };
        let points = vec![point(10.0, 0.0100, 0.0), point(1000.0, 0.0104, 0.02)];
        let table = ReferenceTable::new(points).unwrap();
        // In the middle: half the step, rectangular, beside what the points have.
        let [step, turn] = [0.0002 / 0.0102 / 3f64.sqrt(), 0.01 / 3f64.sqrt()];
        let p = table.at(100.0).unwrap();
        assert!((p.modulus_uncertainty - 0.002f64.hypot(step)).abs() < 1e-12);
        assert!((p.phase_uncertainty - 0.001f64.hypot(turn)).abs() < 1e-12);
        let shares = table.shares_at(100.0).unwrap();
        assert!((shares.own[0] - step).abs() < 1e-12 && (shares.common[0] - 0.002).abs() < 1e-12);
        assert_eq!(table.neighbours(100.0), Some([10.0, 1000.0]));
        // At a point nothing is added, nor beside one as the clocks of two devices are.
        for f in [10.0, 1000.0, 1000.01] {
            assert!((table.at(f).unwrap().modulus_uncertainty - 0.002).abs() < 1e-12);
            assert_eq!(table.neighbours(f), None);
        }
    }

    #[test]
    fn law_shares_of_a_response_add_to_its_uncertainty() {
        // 0.3 % in common and 0.4 % of each frequency alone; a phase of which nothing is common.
        let z = Complex64::from_polar(0.01, 0.4);
        let estimate = |at: f64| {
            let (u, v) = (0.005 * z.norm(), 0.002);
            let components = vec![
                Component::new("modulus", "V/(m/s²)", z.norm()),
                Component::new("phase", "rad", z.arg()),
            ];
            let influence = Influence::normal(
                "all",
                "all",
                Effect::Joint {
                    covariance: Covariance::from_standard_uncertainties(&[u, v]).unwrap(),
                },
            );
            (at, Estimate::new(components, vec![influence]).unwrap())
        };
        let points = [10.0, 20.0, 40.0, 80.0].map(estimate);
        let points: Vec<(f64, &Estimate)> = points.iter().map(|(f, e)| (*f, e)).collect();
        let shared = |effect: Complex64| {
            Some(vec![proofmass_uncertainty::SharedEffect {
                key: "standard".into(),
                effects: vec![vec![effect.re, effect.im]; 4],
            }])
        };
        let response = FrequencyResponse::from_polar("z", &points, shared(0.003 * z)).unwrap();
        let table = ReferenceTable::of_response(&response, 0, 0, 1.0).unwrap();
        for f in [10.0, 30.0, 80.0] {
            let shares = table.shares_at(f).unwrap();
            assert!((shares.common[0] - 0.003).abs() < 1e-12, "{shares:?}");
            assert!((shares.own[0] - 0.004).abs() < 1e-12, "{shares:?}");
            assert!(shares.common[1] < 1e-12 && (shares.own[1] - 0.002).abs() < 1e-12);
            assert!((table.at(f).unwrap().phase - 0.4).abs() < 1e-12);
        }
        // What says nothing is common as a whole; in millivolts it is the same device.
        let silent = FrequencyResponse::from_polar("z", &points, None).unwrap();
        let silent = ReferenceTable::of_response(&silent, 0, 0, 1e-3).unwrap();
        let shares = silent.shares_at(30.0).unwrap();
        assert!(shares.own.iter().all(|u| *u < 1e-12));
        assert!((shares.common[0] - 0.005).abs() < 1e-12);
        assert!((silent.at(30.0).unwrap().sensitivity - 1e-5).abs() < 1e-17);
        assert!(ReferenceTable::of_response(&response, 0, 1, 1.0).is_err());
    }

    #[test]
    fn refuses_frequencies_the_table_does_not_reach() {
        // The published certificate starts at 10 Hz; the published plan at 5 Hz.
        assert!(matches!(
            table().at(5.0),
            Err(Error::OutOfRange { value: 5.0, .. })
        ));
        assert!(table().at(5000.0).is_ok() && table().at(5001.0).is_err());
    }
}
