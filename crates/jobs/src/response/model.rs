//! A model fitted to a frequency response that was measured elsewhere: a laboratory's table, a file of ours.

use super::{Excitation, ResponseJob, ResponseOutcome};
use crate::outcome::Job;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_dynamic::model::{FitProblem, ModelStructure, ResponseFigures, ResponsePoints};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

/// What is asked of points of a frequency response.
///
/// ```
/// use proofmass_dynamic::model::{ModelStructure, ResponsePoints, TransducerModel};
/// use proofmass_jobs::response::{ModelData, ModelJob};
/// use proofmass_jobs::{Job, Unwatched};
///
/// let f = vec![10.0, 20.0, 40.0, 80.0];
/// let n = f.len();
/// let points = ResponsePoints::polar(f, &[2.0; 4], &[1e-3; 4], &[0.0; 4], &[1e-3; 4], "V/(m/s²)")?;
/// let job = ModelJob::new(ModelStructure::modes(0));
/// let outcome = job.evaluate(&ModelData { points: &points, findings: &[], name: "table" }, &Unwatched)?;
/// let s = outcome.fit().unwrap().estimate.get("sensitivity").unwrap();
/// assert!((s.value - 2.0).abs() < 1e-9 && (s.standard_uncertainty - 1e-3 / (n as f64).sqrt()).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ModelJob {
    /// Elements of the model.
    pub structure: ModelStructure,
    /// Lowest and highest frequency taken, Hz.
    #[serde(default)]
    pub band: Option<[f64; 2]>,
    /// Frequency to which departures refer, Hz.
    #[serde(default)]
    pub reference_frequency: Option<f64>,
}

impl ModelJob {
    /// This structure over all points.
    pub fn new(structure: ModelStructure) -> Self {
        Self {
            structure,
            band: None,
            reference_frequency: None,
        }
    }
}

/// Points of a frequency response.
#[derive(Clone, Copy, Debug)]
pub struct ModelData<'a> {
    /// The points, with what is common to them.
    pub points: &'a ResponsePoints,
    /// What reading them found.
    pub findings: &'a [Finding],
    /// What they are called in messages.
    pub name: &'a str,
}

impl Job for ModelJob {
    type Data<'a> = ModelData<'a>;
    type Outcome = ResponseOutcome;

    fn evaluate(&self, data: &ModelData<'_>, watch: &dyn Watch) -> Result<ResponseOutcome> {
        watch.step("model", 0, 1)?;
        let mut problem = FitProblem::new(self.structure);
        problem.band = self.band;
        let fit = problem
            .fit(data.points)
            .map_err(|e| Trouble::from(e).about("the model").detail(data.name))?;
        watch.step("model", 1, 1)?;
        let mut findings = data.findings.to_vec();
        findings.extend(fit.findings.iter().cloned());
        let fitted = fit
            .estimate
            .get("mode.1.damping")
            .map(|q| (q.value, q.standard_uncertainty));
        let figures = ResponseFigures::of(data.points, self.reference_frequency, fitted);
        if let Some(figures) = &figures {
            findings.extend(figures.findings.iter().cloned());
        }
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        let p = data.points;
        let mut request = ResponseJob::new(Excitation::Points);
        request.model = Some(self.structure);
        request.band = self.band;
        request.reference_frequency = self.reference_frequency;
        Ok(ResponseOutcome {
            request,
            channels: ["reference", "device"].map(|name| (name.into(), String::new())),
            unit: p.unit.clone(),
            independent: 0.0,
            response: p.estimate(),
            judged: None,
            input_noise: None,
            power: None,
            modes: Vec::new(),
            figures,
            fit: Some(fit),
            findings,
        })
    }
}
