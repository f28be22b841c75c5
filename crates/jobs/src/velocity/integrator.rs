//! Which integration rule and which high-pass, before anything is recorded.

use super::outcome::quantity;
use super::page;
use crate::outcome::{Job, Outcome, section};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_documents::StatedQuantity;
use proofmass_motion::{IntegratorDesign, IntegratorTask};
use proofmass_report::Report;
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

/// Integration rules, by themselves and with the high-pass that fits each, ranked for a band, a bias and a noise.
///
/// ```
/// use proofmass_jobs::{Job, Outcome, Unwatched, velocity::VelocityIntegratorJob};
/// use proofmass_motion::IntegratorTask;
///
/// let task = IntegratorTask { band: [2.0, 40.0], rate: 200.0, bias: 0.02, noise: 1e-3, speed: 0.5, duration: 60.0 };
/// let outcome = VelocityIntegratorJob::new(task).evaluate(&(), &Unwatched)?;
/// assert_eq!(outcome.ranked()[0].rule.name(), "tick");
/// # Ok::<(), proofmass_jobs::Trouble>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct VelocityIntegratorJob {
    /// What the velocity is integrated for.
    pub task: IntegratorTask,
    /// Error of the velocity that is allowed, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub allowed: Option<f64>,
    /// Only what runs while the record comes in.
    #[serde(default)]
    pub on_line: bool,
}

impl VelocityIntegratorJob {
    /// For a task, without a limit.
    pub fn new(task: IntegratorTask) -> Self {
        Self {
            task,
            allowed: None,
            on_line: false,
        }
    }
}

impl Job for VelocityIntegratorJob {
    type Data<'a> = ();
    type Outcome = VelocityIntegrator;

    fn evaluate(&self, (): &(), watch: &dyn Watch) -> Result<VelocityIntegrator> {
        watch.step("integrators", 0, 1)?;
        if let Some(allowed) = self.allowed.filter(|a| !(a.is_finite() && *a > 0.0)) {
            return Err(Trouble::request(format!(
                "an allowed error of {allowed} m/s is not above zero"
            ))
            .with_hint("state metres per second above zero"));
        }
        let mut ranked = self.task.ranked().map_err(|e| {
            Trouble::from(e).with_hint(
                "the band lies below 0.49 of the sampling rate, and the record holds four periods of its lowest frequency",
            )
        })?;
        ranked.retain(|d| !(self.on_line && d.off_line()));
        if ranked.is_empty() {
            return Err(Trouble::request(
                "no rule has a finite error for this, with or without a high-pass",
            )
            .with_hint(
                "check the units: bias and noise in m/s², the amplitude of the velocity in m/s",
            ));
        }
        watch.step("integrators", 1, 1)?;
        Ok(VelocityIntegrator {
            request: *self,
            ranked,
        })
    }
}

/// The rules, the best first.
#[derive(Clone, Debug, PartialEq)]
pub struct VelocityIntegrator {
    pub(super) request: VelocityIntegratorJob,
    ranked: Vec<IntegratorDesign>,
}

impl VelocityIntegrator {
    /// Every rule by itself and with its high-passes, the smallest total first.
    pub fn ranked(&self) -> &[IntegratorDesign] {
        &self.ranked
    }

    /// The word by which `velocity estimate --method` takes a design.
    pub fn method(design: &IntegratorDesign) -> String {
        design.method().word().unwrap_or_default()
    }
}

impl Outcome for VelocityIntegrator {
    const KIND: &'static str = "velocity-integrator";
    const PRINCIPAL_TABLE: &'static str = "integrators.csv";

    fn title(&self, record: &Record) -> String {
        record.title(
            "Integration of",
            "Integration of an acceleration: rule and high-pass",
        )
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        let best = self.ranked.iter().take(1);
        let of = |d: &IntegratorDesign| quantity("velocity_error", "m/s", 0.0, d.total);
        best.map(|d| StatedQuantity::new(&of(d), 0.95)).collect()
    }

    fn findings(&self) -> &[Finding] {
        &[]
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![
            section("task", &self.request)?,
            section("ranked", &self.ranked)?,
        ])
    }

    fn page(&self, page: Report) -> Report {
        page::integrator(page, self)
    }
}
