//! Complex least squares of the model, with one covariance of everything.

use super::parameters::Device;
use super::response::{Mode, ModelStructure, TransducerModel};
use crate::findings;
use crate::frequency_response::FrequencyResponse;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_signal::transfer::{ResponseEstimate, Smearing, polar};
use proofmass_uncertainty::adjustment::{Equations, adjust, cholesky, solve};
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding, Influence,
    chi_squared_quantile,
};
use serde::{Deserialize, Serialize};

/// A cause that acts on all points at once: the reference standard, its amplifier, a skew of the converter.
#[derive(Clone, Debug, PartialEq)]
pub struct CommonCause {
    /// Stable name.
    pub key: String,
    /// What it is.
    pub description: String,
    /// Standard uncertainty of the cause.
    pub standard_uncertainty: f64,
    /// Its degrees of freedom; infinite when `None`.
    pub dof: Option<DegreesOfFreedom>,
    /// ∂S/∂cause at each point.
    pub derivative: Vec<Complex64>,
}

/// A measured frequency response: points with the covariance of each, and what is common to all.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ResponsePoints {
    /// Hz.
    pub frequency: Vec<f64>,
    /// S.
    pub value: Vec<Complex64>,
    /// Covariance rr, ri, ii of what is independent between points.
    pub covariance: Vec<[f64; 3]>,
    /// Smallest number of degrees of freedom of these covariances; infinite when `None`.
    pub dof: Option<f64>,
    /// What is common.
    pub common: Vec<CommonCause>,
    /// Unit of S.
    pub unit: String,
    /// What a window made of the response before these points were read: the model is seen through it.
    pub smearing: Option<Smearing>,
}

/// Share of the leakage's variance that stays where the model is seen through the window: for a density of the input that is not
/// quite even.
const UNEVEN: f64 = 1e-3;

impl ResponsePoints {
    /// From an estimated response, thinned to independent lines; two lines apart under a Hann window leave a correlation of
    /// 1/36 to either side, which is added.
    pub fn of(estimate: &ResponseEstimate, unit: &str) -> Self {
        let step = estimate.independent_every.max(1);
        let factor = if step > 1 { 1.0 + 2.0 / 36.0 } else { 1.0 };
        let keep: Vec<usize> = (0..estimate.value.len()).step_by(step).collect();
        Self {
            frequency: keep.iter().map(|k| estimate.frequency[*k]).collect(),
            value: keep.iter().map(|k| estimate.value[*k]).collect(),
            covariance: keep
                .iter()
                .map(|k| estimate.covariance[*k].map(|v| factor * v))
                .collect(),
            dof: estimate.dof.iter().copied().min_by(f64::total_cmp),
            common: Vec::new(),
            unit: unit.to_owned(),
            smearing: None,
        }
    }

    /// What a fit is to see: the model through the window that smoothed the estimate, which these points were thinned from, and
    /// the leakage no longer among the uncertainties.
    #[must_use]
    pub fn seen_through(mut self, estimate: &ResponseEstimate, smearing: Smearing) -> Self {
        let step = estimate.independent_every.max(1);
        let factor = if step > 1 { 1.0 + 2.0 / 36.0 } else { 1.0 };
        let share = (1.0 - UNEVEN) * factor;
        for (c, b) in self
            .covariance
            .iter_mut()
            .zip(estimate.leakage.iter().step_by(step))
        {
            c[0] -= share * b.re * b.re;
            c[1] -= share * b.re * b.im;
            c[2] -= share * b.im * b.im;
        }
        self.smearing = Some(smearing);
        self
    }

    /// What a model shows at a frequency.
    fn of_model(&self, model: &TransducerModel, frequency: f64) -> Complex64 {
        match &self.smearing {
            Some(smearing) => smearing.expected(frequency, |f| model.response(f)),
            None => model.response(frequency),
        }
    }

    /// From moduli and phases (rad) with their standard uncertainties.
    ///
    /// # Errors
    /// [`Error::Length`], [`Error::NotFinite`], an uncertainty that is not positive.
    pub fn polar(
        frequency: Vec<f64>,
        modulus: &[f64],
        u_modulus: &[f64],
        phase: &[f64],
        u_phase: &[f64],
        unit: &str,
    ) -> Result<Self, Error> {
        let n = frequency.len();
        for (name, column) in [
            ("moduli", modulus),
            ("uncertainties of the moduli", u_modulus),
            ("phases", phase),
            ("uncertainties of the phases", u_phase),
        ] {
            if column.len() != n {
                return Err(Error::Length {
                    name,
                    expected: n,
                    got: column.len(),
                });
            }
        }
        let mut points = Self {
            unit: unit.to_owned(),
            ..Self::default()
        };
        for k in 0..n {
            let z = Complex64::from_polar(modulus[k], phase[k]);
            let (along, across) = (u_modulus[k], u_phase[k] * modulus[k]);
            let (c, s) = (phase[k].cos(), phase[k].sin());
            points.value.push(z);
            points.covariance.push([
                c * c * along * along + s * s * across * across,
                c * s * (along * along - across * across),
                s * s * along * along + c * c * across * across,
            ]);
        }
        points.frequency = frequency;
        points.check()?;
        Ok(points)
    }

    /// One element of a calibrated frequency response, with what its frequencies have in common.
    ///
    /// Where the response does not say how its frequencies are correlated, both ends are allowed for: their covariance stands as
    /// independent, and modulus and phase once more as errors common to all.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for an element that is not there; covariances that are not positive.
    pub fn of_response(
        response: &FrequencyResponse,
        output: usize,
        axis: usize,
    ) -> Result<Self, Error> {
        let re = response.real_part(output, axis)?;
        let im = re + 1;
        let series = response.series();
        let mut points = Self {
            unit: response.unit().to_owned(),
            ..Self::default()
        };
        for point in series.points() {
            let c = point.estimate.components();
            let v = point.estimate.covariance();
            points.frequency.push(point.at);
            points.value.push(Complex64::new(c[re].value, c[im].value));
            points
                .covariance
                .push([v[(re, re)], v[(re, im)], v[(im, im)]]);
        }
        match series.shared() {
            Some(shared) => {
                for effect in shared {
                    let derivative: Vec<Complex64> = effect
                        .effects
                        .iter()
                        .map(|e| Complex64::new(e[re], e[im]))
                        .collect();
                    for (c, d) in points.covariance.iter_mut().zip(&derivative) {
                        // A thousandth of it is left, lest nothing remain that weighs a point.
                        let share = 0.999;
                        c[0] -= share * d.re * d.re;
                        c[1] -= share * d.re * d.im;
                        c[2] -= share * d.im * d.im;
                    }
                    points.common.push(CommonCause {
                        key: effect.key.clone(),
                        description: "an error that the frequencies of the calibration share"
                            .into(),
                        standard_uncertainty: 1.0,
                        dof: None,
                        derivative,
                    });
                }
            }
            None => {
                let parts = points.value.iter().zip(&points.covariance);
                let (modulus, phase) = parts
                    .map(|(z, c)| {
                        let (u, turn) = polar(*z, *c);
                        (z / z.norm() * u, Complex64::i() * z * turn)
                    })
                    .unzip();
                for (key, derivative) in [
                    ("calibration.modulus", modulus),
                    ("calibration.phase", phase),
                ] {
                    points.common.push(CommonCause {
                        key: key.into(),
                        description:
                            "errors of the calibration, were they the same at all frequencies"
                                .into(),
                        standard_uncertainty: 1.0,
                        dof: None,
                        derivative,
                    });
                }
            }
        }
        points.check()?;
        Ok(points)
    }

    /// The points as lines of a response, ascending in frequency, without what is common to them.
    pub fn estimate(&self) -> ResponseEstimate {
        let mut order: Vec<usize> = (0..self.frequency.len()).collect();
        order.sort_by(|a, b| self.frequency[*a].total_cmp(&self.frequency[*b]));
        ResponseEstimate {
            frequency: order.iter().map(|k| self.frequency[*k]).collect(),
            value: order.iter().map(|k| self.value[*k]).collect(),
            covariance: order.iter().map(|k| self.covariance[*k]).collect(),
            dof: vec![self.dof.unwrap_or(1e6); order.len()],
            coherence: Vec::new(),
            leakage: Vec::new(),
            independent_every: 1,
        }
    }

    /// Adds an error that is common to all points, in standard uncertainties relative to each point; nothing where it is zero at all.
    ///
    /// # Errors
    /// [`Error::Length`] unless there is one to each point.
    pub fn with_common(
        mut self,
        key: &str,
        description: &str,
        relative: &[Complex64],
    ) -> Result<Self, Error> {
        if relative.len() != self.value.len() {
            return Err(Error::Length {
                name: "common errors of the points",
                expected: self.value.len(),
                got: relative.len(),
            });
        }
        if relative.iter().any(|r| r.norm() > 0.0) {
            self.common.push(CommonCause {
                key: key.into(),
                description: description.into(),
                standard_uncertainty: 1.0,
                dof: None,
                derivative: self
                    .value
                    .iter()
                    .zip(relative)
                    .map(|(s, r)| s * r)
                    .collect(),
            });
        }
        Ok(self)
    }

    /// Adds a relative error of the reference, common to all points: modulus and phase (rad).
    #[must_use]
    pub fn with_reference(
        mut self,
        relative: f64,
        phase: f64,
        dof: Option<DegreesOfFreedom>,
    ) -> Self {
        for (key, u, turn, description) in [
            (
                "reference.modulus",
                relative,
                Complex64::new(-1.0, 0.0),
                "relative error of the reference, the same at every frequency",
            ),
            (
                "reference.phase",
                phase,
                Complex64::new(0.0, -1.0),
                "phase error of the reference, the same at every frequency",
            ),
        ] {
            if u > 0.0 {
                self.common.push(CommonCause {
                    key: key.into(),
                    description: description.into(),
                    standard_uncertainty: u,
                    dof,
                    derivative: self.value.iter().map(|s| turn * s).collect(),
                });
            }
        }
        self
    }

    fn check(&self) -> Result<(), Error> {
        let n = self.frequency.len();
        for got in [self.value.len(), self.covariance.len()]
            .into_iter()
            .chain(self.common.iter().map(|c| c.derivative.len()))
        {
            if got != n {
                return Err(Error::Length {
                    name: "points of the response",
                    expected: n,
                    got,
                });
            }
        }
        for (index, f) in self.frequency.iter().enumerate() {
            let [rr, ri, ii] = self.covariance[index];
            let finite = f.is_finite()
                && self.value[index].is_finite()
                && [rr, ri, ii].iter().all(|v| v.is_finite());
            if !finite {
                return Err(Error::NotFinite {
                    name: "point of the response",
                    index,
                });
            }
            if !(*f > 0.0) {
                return Err(Error::OutOfRange {
                    name: "frequency",
                    value: *f,
                    min: f64::MIN_POSITIVE,
                    max: f64::MAX,
                });
            }
            if !(rr > 0.0 && ii > 0.0 && rr * ii > ri * ri) {
                return Err(Error::NotPositiveDefinite {
                    name: "covariance of a point of the response",
                    row: index,
                    column: index,
                    value: rr * ii - ri * ri,
                });
            }
        }
        Ok(())
    }
}

/// What is fitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct FitProblem {
    /// Elements of the model.
    pub structure: ModelStructure,
    /// Lowest and highest frequency taken, Hz.
    pub band: Option<[f64; 2]>,
}

/// A fitted model.
///
/// Weighted complex least squares: each point with the inverse of its own covariance. What is common to all points does not
/// weigh; its effect on the parameters is that of the same least squares, so the covariance holds whatever the weights.
///
/// **Model check** the weighted squares of the residuals against χ², with the spread that the degrees of freedom of the
/// covariances allow, and the relative misfit as the size of the effect: a model that does not describe the device is said so.
///
/// **Accuracy** f_n, ζ, S₀ within their 95 % intervals in 1 000 simulated calibrations (`coverage_model_parameters`).
///
/// **Source** `[ISO16063-43]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ModelFit {
    /// What was asked.
    pub problem: FitProblem,
    /// The fitted model.
    pub model: TransducerModel,
    /// Its parameters by name, with one covariance and its causes.
    pub estimate: Estimate,
    /// Weighted sum of squares.
    pub chi_square: f64,
    /// Equations less parameters.
    pub freedom: usize,
    /// Value beyond which it is by chance in one of a thousand.
    pub limit: f64,
    /// Root mean square of the residuals, relative to the moduli, less what the noise explains.
    pub misfit: f64,
    /// Frequency, real and imaginary residual relative to the modulus, expanded uncertainty of the point relative to it.
    pub residuals: Vec<[f64; 4]>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl ModelFit {
    /// The response of the fitted model at these frequencies (Hz), with the covariance rr, ri, ii that its parameters give it.
    ///
    /// # Errors
    /// [`Error::Length`] for an estimate without the model's parameters.
    pub fn at(&self, frequencies: &[f64]) -> Result<Vec<(Complex64, [f64; 3])>, Error> {
        let highest = frequencies.iter().copied().fold(0.0, f64::max);
        let time = 1.0 / (std::f64::consts::TAU * highest);
        let device = Device::new(&self.model, &self.problem.structure, &self.estimate, time)?;
        Ok(frequencies
            .iter()
            .map(|&f| (self.model.response(f), device.covariance_of(f)))
            .collect())
    }
}

/// Cholesky factor of the inverse of a 2 × 2 covariance, applied to a complex number.
fn whiten([rr, ri, ii]: [f64; 3], z: Complex64) -> [f64; 2] {
    // C = L Lᵀ; y = L⁻¹ z.
    let l11 = rr.sqrt();
    let l21 = ri / l11;
    let l22 = (ii - l21 * l21).sqrt();
    let a = z.re / l11;
    [a, (z.im - l21 * a) / l22]
}

impl FitProblem {
    /// Fits this structure to all points.
    pub fn new(structure: ModelStructure) -> Self {
        Self {
            structure,
            band: None,
        }
    }

    /// Fits.
    ///
    /// # Errors
    /// Points that are no numbers or have no covariance; [`Error::TooFew`] for fewer than half as many as parameters, and two;
    /// [`Error::Unobservable`] for a parameter that the points do not determine, [`Error::NotConverged`].
    pub fn fit(&self, points: &ResponsePoints) -> Result<ModelFit, Error> {
        self.structure.check()?;
        points.check()?;
        let points = self.chosen(points);
        let p = self.structure.parameters();
        let n = points.frequency.len();
        if 2 * n < p + 2 {
            return Err(Error::TooFew {
                name: "points of the response",
                needed: p.div_ceil(2) + 1,
                got: n,
            });
        }
        let highest = points.frequency.iter().copied().fold(0.0, f64::max);
        let time = 1.0 / (std::f64::consts::TAU * highest);
        let mut best: Option<(f64, Vec<f64>, f64, Equations)> = None;
        let mut failure = Error::NotConverged {
            name: "model fit",
            iterations: 0,
            step: f64::INFINITY,
        };
        // The window matters little to where the minimum lies: it is looked for without.
        let clear = ResponsePoints {
            smearing: None,
            ..points.clone()
        };
        for (start, sign) in self.starts(&points) {
            let vector = start.to_vector(&self.structure, time);
            let equations = |v: &[f64]| self.equations(&clear, v, sign, time);
            match adjust("model fit", &vector, &vec![1.0; 2 * n], equations) {
                Ok(solution) => {
                    let cost: f64 = solution.equations.residual.iter().map(|r| r * r).sum();
                    if best.as_ref().is_none_or(|b| cost < b.0) {
                        best = Some((cost, solution.parameters, sign, solution.equations));
                    }
                }
                Err(e) => {
                    if best.is_none() {
                        failure = e;
                    }
                }
            }
        }
        let Some((mut cost, mut vector, sign, mut equations)) = best else {
            return Err(failure);
        };
        let mut points = points;
        if let Some(smearing) = &points.smearing {
            let first = TransducerModel::from_vector(&vector, &self.structure, sign, time);
            for k in 0..n {
                let expected = points.of_model(&first, points.frequency[k]);
                let ratio = smearing.variance_ratio(expected, points.value[k]);
                points.covariance[k] = points.covariance[k].map(|v| ratio * v);
            }
            let seen = |v: &[f64]| self.equations(&points, v, sign, time);
            let solution = adjust("model fit", &vector, &vec![1.0; 2 * n], seen)?;
            cost = solution.equations.residual.iter().map(|r| r * r).sum();
            (vector, equations) = (solution.parameters, solution.equations);
        }
        let mut model = TransducerModel::from_vector(&vector, &self.structure, sign, time);
        let equations = if model.modes.is_sorted_by(|a, b| a.frequency <= b.frequency) {
            equations
        } else {
            // The first mode is the lowest, however the search came upon them.
            model
                .modes
                .sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
            let sorted = model.to_vector(&self.structure, time);
            self.equations(&points, &sorted, sign, time)?
        };
        self.result(&points, model, cost, &equations, time)
    }

    fn chosen(&self, points: &ResponsePoints) -> ResponsePoints {
        let Some([low, high]) = self.band else {
            return points.clone();
        };
        let keep: Vec<usize> = (0..points.frequency.len())
            .filter(|k| (low..=high).contains(&points.frequency[*k]))
            .collect();
        ResponsePoints {
            frequency: keep.iter().map(|k| points.frequency[*k]).collect(),
            value: keep.iter().map(|k| points.value[*k]).collect(),
            covariance: keep.iter().map(|k| points.covariance[*k]).collect(),
            common: points
                .common
                .iter()
                .map(|c| CommonCause {
                    derivative: keep.iter().map(|k| c.derivative[*k]).collect(),
                    ..c.clone()
                })
                .collect(),
            dof: points.dof,
            unit: points.unit.clone(),
            smearing: points.smearing.clone(),
        }
    }

    fn equations(
        &self,
        points: &ResponsePoints,
        v: &[f64],
        sign: f64,
        time: f64,
    ) -> Result<Equations, Error> {
        let p = v.len();
        let n = points.frequency.len();
        let model = TransducerModel::from_vector(v, &self.structure, sign, time);
        let mut equations = Equations {
            residual: vec![0.0; 2 * n],
            jacobian: vec![0.0; 2 * n * p],
        };
        let shifted: Vec<[TransducerModel; 2]> = (0..p)
            .map(|j| {
                [-STEP, STEP].map(|h| {
                    let mut w = v.to_vec();
                    w[j] += h;
                    TransducerModel::from_vector(&w, &self.structure, sign, time)
                })
            })
            .collect();
        for k in 0..n {
            let f = points.frequency[k];
            let r = whiten(
                points.covariance[k],
                points.of_model(&model, f) - points.value[k],
            );
            if !(r[0].is_finite() && r[1].is_finite()) {
                return Err(Error::NotFinite {
                    name: "model",
                    index: k,
                });
            }
            equations.residual[2 * k..2 * k + 2].copy_from_slice(&r);
            for (j, [low, high]) in shifted.iter().enumerate() {
                let d = (points.of_model(high, f) - points.of_model(low, f)) / (2.0 * STEP);
                let [a, b] = whiten(points.covariance[k], d);
                equations.jacobian[2 * k * p + j] = a;
                equations.jacobian[(2 * k + 1) * p + j] = b;
            }
        }
        Ok(equations)
    }

    /// Where the search begins: resonances at the peaks of what is measured or beyond its end, dampings from sharp to dull.
    fn starts(&self, points: &ResponsePoints) -> Vec<(TransducerModel, f64)> {
        let n = points.frequency.len();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|a, b| points.frequency[*a].total_cmp(&points.frequency[*b]));
        let f = |k: usize| points.frequency[order[k]];
        let s = |k: usize| points.value[order[k]];
        let (lowest, highest) = (f(0), f(n - 1));
        // A high-pass hides the static value: the middle of the band in the logarithm shows it then.
        let level = if self.structure.high_pass { n / 2 } else { 0 };
        let near: Vec<f64> = (level.saturating_sub(2)..(level + 3).min(n))
            .map(|k| s(k).norm())
            .collect();
        let s0 = near.iter().sum::<f64>() / near.len() as f64;
        let mut peaks: Vec<(f64, f64)> = (1..n.saturating_sub(1))
            .filter(|k| {
                let from = k.saturating_sub(3);
                (from..(k + 4).min(n)).all(|m| s(m).norm() <= s(*k).norm())
            })
            .map(|k| (s(k).norm(), f(k)))
            .collect();
        peaks.sort_by(|a, b| b.0.total_cmp(&a.0));
        // The slope of the phase over the lower half of the band.
        let middle = (n / 2).max(1);
        let turn: f64 = (1..=middle.min(n - 1))
            .map(|k| (s(k) / s(k - 1)).arg())
            .sum();
        let slope =
            -turn / (std::f64::consts::TAU * (f(middle.min(n - 1)) - lowest).max(1e-12 * highest));
        let mut first: Vec<f64> = peaks.iter().take(2).map(|p| p.1).collect();
        first.extend([0.7 * highest, 1.5 * highest, 4.0 * highest]);
        let delays: &[f64] = if self.structure.delay {
            &[0.0, 0.5, 1.0]
        } else {
            &[0.0]
        };
        let mut starts = Vec::new();
        for sign in [1.0, -1.0] {
            // The sign is that of the first point, unless a delay or a high-pass has turned it.
            if sign * s(level.min(n - 1)).re < -0.2 * s0 {
                continue;
            }
            for fn_ in &first {
                for damping in [0.01, 0.1, 0.6] {
                    for delay in delays {
                        let modes = (0..self.structure.modes)
                            .map(|i| match i {
                                0 => Mode {
                                    frequency: *fn_,
                                    damping,
                                    share: 1.0,
                                },
                                _ => Mode {
                                    frequency: peaks
                                        .iter()
                                        .filter(|p| (p.1 / fn_ - 1.0).abs() > 0.02)
                                        .nth(i - 1)
                                        .map_or(1.3 * highest * i as f64, |p| p.1),
                                    damping: damping.min(0.05),
                                    share: 0.05,
                                },
                            })
                            .collect();
                        starts.push((
                            TransducerModel {
                                sensitivity: sign * s0,
                                modes,
                                high_pass: self.structure.high_pass.then_some(0.5 * lowest),
                                delay: delay * slope.max(0.0),
                                low_pass: self.structure.low_pass.map(|o| (o, 1.5 * highest)),
                            },
                            sign,
                        ));
                        if self.structure.modes == 0 {
                            break;
                        }
                    }
                }
            }
        }
        starts
    }

    fn result(
        &self,
        points: &ResponsePoints,
        model: TransducerModel,
        chi_square: f64,
        equations: &Equations,
        time: f64,
    ) -> Result<ModelFit, Error> {
        let n = points.frequency.len();
        let named = model.named(&self.structure, &points.unit, time);
        let p = named.len();
        let mut normal = vec![0.0; p * p];
        for row in equations.jacobian.chunks_exact(p) {
            for a in 0..p {
                for b in 0..p {
                    normal[a * p + b] += row[a] * row[b];
                }
            }
        }
        // In natural units of order one; scaled so that the condition is that of the correlations.
        let scale: Vec<f64> = (0..p).map(|a| normal[a * p + a].sqrt()).collect();
        if let Some(a) = scale.iter().position(|s| !(*s > 0.0)) {
            return Err(unobservable(&named[a].0, f64::INFINITY));
        }
        let mut factor: Vec<f64> = (0..p * p)
            .map(|k| normal[k] / (scale[k / p] * scale[k % p]))
            .collect();
        if cholesky(&mut factor, p).is_none() {
            return Err(unobservable(&named[p - 1].0, f64::INFINITY));
        }
        let weakest = (0..p)
            .min_by(|a, b| factor[a * p + a].total_cmp(&factor[b * p + b]))
            .unwrap_or(0);
        // The pivot is 1 − R²: a parameter that the others explain to ten digits is none.
        if factor[weakest * p + weakest] < 1e-5 {
            return Err(unobservable(
                &named[weakest].0,
                factor[weakest * p + weakest].powi(-2),
            ));
        }
        let solve_scaled = |right: &[f64]| -> Vec<f64> {
            let mut x: Vec<f64> = right.iter().zip(&scale).map(|(r, s)| r / s).collect();
            solve(&factor, &mut x);
            x.iter().zip(&scale).map(|(x, s)| x / s).collect()
        };
        // Weights that are the inverse of variances with ν degrees of freedom scatter themselves, which makes the variance of a
        // weighted mean E w²/(E w)² = (ν − 2)/(ν − 4) of the best there is, where Σ w promises (ν − 2)/ν of it.
        let spread = points
            .dof
            .map_or(1.0, |nu| nu.max(6.0) / (nu.max(6.0) - 4.0));
        let mut rows = vec![0.0; p * p];
        for a in 0..p {
            let unit: Vec<f64> = (0..p).map(|b| f64::from(u8::from(a == b))).collect();
            for (b, v) in solve_scaled(&unit).into_iter().enumerate() {
                rows[a * p + b] = spread * v * named[a].3 * named[b].3;
            }
        }
        for a in 0..p {
            for b in 0..a {
                let mean = 0.5 * (rows[a * p + b] + rows[b * p + a]);
                rows[a * p + b] = mean;
                rows[b * p + a] = mean;
            }
        }
        let dof = points.dof.and_then(|d| DegreesOfFreedom::new(d * n as f64));
        let mut influences = vec![Influence {
            key: "points".into(),
            description: "what is independent between the points of the response".into(),
            evaluation: Evaluation::A,
            distribution: "normal".into(),
            dof: dof.unwrap_or(DegreesOfFreedom::INFINITE),
            effect: Effect::Joint {
                covariance: Covariance::try_from_rows(p, &rows)?,
            },
        }];
        for cause in &points.common {
            let mut right = vec![0.0; p];
            for (k, d) in cause.derivative.iter().enumerate() {
                let w = whiten(points.covariance[k], *d);
                for a in 0..p {
                    right[a] += equations.jacobian[2 * k * p + a] * w[0]
                        + equations.jacobian[(2 * k + 1) * p + a] * w[1];
                }
            }
            let sensitivity = solve_scaled(&right)
                .iter()
                .zip(&named)
                .map(|(x, n)| x * n.3)
                .collect();
            influences.push(Influence {
                key: cause.key.clone(),
                description: cause.description.clone(),
                evaluation: Evaluation::B,
                distribution: "normal".into(),
                dof: cause.dof.unwrap_or(DegreesOfFreedom::INFINITE),
                effect: Effect::of_zero("1", cause.standard_uncertainty, sensitivity),
            });
        }
        let components = named
            .iter()
            .map(|(name, unit, value, _)| Component::new(name.clone(), unit.clone(), *value))
            .collect();
        let estimate = Estimate::new(components, influences)?;
        let freedom = 2 * n - p;
        let limit = chi_limit(freedom, points.dof);
        let mut squares = 0.0;
        let mut explained = 0.0;
        let residuals: Vec<[f64; 4]> = (0..n)
            .map(|k| {
                let s = points.value[k];
                let d = (points.of_model(&model, points.frequency[k]) - s) / s;
                let [rr, _, ii] = points.covariance[k];
                squares += d.norm_sqr();
                explained += (rr + ii) / s.norm_sqr();
                let (u, _) = polar(s, points.covariance[k]);
                [points.frequency[k], -d.re, -d.im, 2.0 * u / s.norm()]
            })
            .collect();
        let misfit = ((squares - explained).max(0.0) / (2 * n) as f64).sqrt();
        let findings = findings(
            chi_square, freedom, limit, misfit, &residuals, &estimate, points,
        );
        Ok(ModelFit {
            problem: *self,
            model,
            estimate,
            chi_square,
            freedom,
            limit,
            misfit,
            residuals,
            findings,
        })
    }
}

/// Step of the central differences, in logarithms: an error of 1e-10.
const STEP: f64 = 1e-5;

fn unobservable(name: &str, condition: f64) -> Error {
    let parameter = match name {
        "sensitivity" => "sensitivity",
        "delay" => "delay",
        "high_pass.corner" => "high_pass.corner",
        "low_pass.corner" => "low_pass.corner",
        n if n.ends_with("damping") => "mode.damping",
        n if n.ends_with("share") => "mode.share",
        _ => "mode.frequency",
    };
    Error::Unobservable {
        parameter,
        condition,
    }
}

/// Beyond this the weighted squares come by chance once in a thousand, when the covariances have ν degrees of freedom: their
/// mean is then ν/(ν − 2) and their variance 2ν²(ν − 1)/((ν − 2)²(ν − 4)) per equation.
fn chi_limit(freedom: usize, dof: Option<f64>) -> f64 {
    let f = freedom.max(1) as f64;
    match dof {
        Some(nu) if nu < 1e4 => {
            let nu = nu.max(5.0);
            let mean = nu / (nu - 2.0);
            let variance = 2.0 * nu * nu * (nu - 1.0) / ((nu - 2.0).powi(2) * (nu - 4.0));
            f * mean + 3.3 * (f * variance).sqrt()
        }
        _ => chi_squared_quantile(0.999, f),
    }
}

fn findings(
    chi_square: f64,
    freedom: usize,
    limit: f64,
    misfit: f64,
    residuals: &[[f64; 4]],
    estimate: &Estimate,
    points: &ResponsePoints,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    if chi_square > limit {
        let worst = residuals
            .iter()
            .max_by(|a, b| a[1].hypot(a[2]).total_cmp(&b[1].hypot(b[2])));
        let place = worst.map_or(String::new(), |w| {
            format!(
                ", largest {:.2} % at {:.4} Hz",
                100.0 * w[1].hypot(w[2]),
                w[0]
            )
        });
        findings.push(
            findings::model_does_not_describe(
                "the device within the stated uncertainty of the points",
                &format!(
                    "χ² = {chi_square:.1} with {freedom} degrees of freedom, at most {limit:.1}; misfit {:.3} % of the modulus{place}",
                    100.0 * misfit
                ),
                "the intervals of its parameters say nothing then: add what is missing (a delay, a low-pass, a second mode), fit a narrower band, or check the stated uncertainties",
            ),
        );
    }
    let highest = points.frequency.iter().copied().fold(0.0, f64::max);
    for q in estimate.quantities() {
        if q.name.ends_with("frequency") && q.value > highest {
            findings.push(findings::model_extrapolated(
                &q.name,
                q.value,
                highest,
                "measure the response at higher frequencies",
            ));
        }
        let relative = (q.standard_uncertainty / q.value).abs();
        if relative > 0.2
            && (q.name.ends_with("damping")
                || q.name.ends_with("frequency")
                || q.name.ends_with("corner"))
        {
            findings.push(findings::parameter_ill_determined(
                &q.name,
                100.0 * relative,
            ));
        }
    }
    findings
}
