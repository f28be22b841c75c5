//! What a multi-position fit gives: the model, the joint estimate, the residuals, the doubts.

use super::Model;
use super::misfit::Misfit;
use super::scatter_forms::FormWeight;
use super::suspects::Suspect;
use crate::{DirectionCoverage, Pose, Triple};
use proofmass_core::{Compensation, Curvature, Gravity, SensorModel, ThermalTerms};
use proofmass_uncertainty::{BetweenScatter, Estimate, Finding, Quantity};
use serde::Serialize;

/// How one standstill agrees with the fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PoseResidual {
    /// Name of the standstill.
    pub name: String,
    /// First sample and one past the last.
    pub samples: (usize, usize),
    /// Mean output, output units.
    pub output: Triple,
    /// Compensated acceleration, m/s².
    pub acceleration: Triple,
    /// ‖a‖ − g, m/s²; where the lengths of true accelerations count, less the length that was stated.
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
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ScatterParts {
    /// The quantity.
    pub(crate) name: String,
    /// Noise within the standstills.
    pub noise: f64,
    /// Own errors of the given attitudes.
    pub attitude: f64,
    /// What varies between the standstills beyond that.
    pub between: f64,
}

/// The result without the standstills that are suspected.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct WithoutSuspects {
    /// Who is left out.
    pub suspects: Vec<Suspect>,
    /// The quantities then; `None` where the rest does not determine them.
    pub quantities: Option<Vec<Quantity>>,
}

/// Terms beyond ã = K a + b as they were fitted ([`Terms`](super::Terms)).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BeyondMatrix {
    /// What follows the temperature.
    pub thermal: Option<ThermalTerms<f64>>,
    /// Lowest and highest temperature of the standstills, °C, where it does.
    pub range: Option<[f64; 2]>,
    /// What is not linear.
    pub curvature: Option<Curvature<f64>>,
}

/// Result of a [`MultiPosition`](super::MultiPosition) fit.
#[derive(Clone, Debug, PartialEq)]
pub struct MultiPositionFit {
    pub(crate) model: Model,
    pub(crate) sensor: SensorModel<f64>,
    /// What goes beyond the matrix, where that was fitted.
    pub(crate) beyond: Option<BeyondMatrix>,
    pub(crate) estimate: Estimate,
    pub(crate) quantities: Vec<Quantity>,
    pub(crate) parts: Vec<ScatterParts>,
    pub(crate) probability: f64,
    pub(crate) gravity: Gravity,
    pub(crate) output_unit: String,
    pub(crate) are_accelerations: bool,
    pub(crate) attitudes_given: bool,
    pub(crate) lengths_given: bool,
    pub(crate) poses: Vec<Pose>,
    pub(crate) residuals: Vec<PoseResidual>,
    pub(crate) coverage: DirectionCoverage,
    pub(crate) chi_square: Option<f64>,
    pub(crate) degrees_of_freedom: usize,
    pub(crate) scatter: Option<BetweenScatter>,
    pub(crate) forms: Vec<FormWeight>,
    pub(crate) excess: f64,
    pub(crate) condition: f64,
    pub(crate) iterations: usize,
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

    /// Whether the lengths of the given accelerations count, and not gravity.
    pub fn lengths_given(&self) -> bool {
        self.lengths_given
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

    /// How likely each form of the scatter is by the residuals, the likeliest first; empty where they are no larger than the
    /// noise, or tell nothing of its form.
    pub fn scatter_forms(&self) -> &[FormWeight] {
        &self.forms
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
}
