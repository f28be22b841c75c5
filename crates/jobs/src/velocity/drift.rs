//! What a velocity from an accelerometer alone drifts, before anything is recorded.

use super::drift_results::TakenFrom;
use super::outcome::quantity;
use super::page;
use crate::outcome::{Job, Outcome, section};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_documents::StatedQuantity;
use proofmass_motion::{AidedDrift, DriftBudget, DriftSources, EncoderAiding};
use proofmass_report::Report;
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};

/// Drift from offset, inclination, gain and noise.
///
/// ```
/// use proofmass_jobs::{Job, Outcome, Unwatched, velocity::VelocityDriftJob};
/// use proofmass_motion::DriftSources;
///
/// let tilt = DriftSources { orientation_uncertainty: 1f64.to_radians(), ..DriftSources::default() };
/// let outcome = VelocityDriftJob::new(tilt, vec![10.0]).evaluate(&(), &Unwatched)?;
/// let drift = &outcome.quantities()[0];
/// assert_eq!(drift.value, 0.0);
/// assert!(drift.u.is_some_and(|u| (u - 1.7116).abs() < 1e-4));
/// # Ok::<(), proofmass_jobs::Trouble>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct VelocityDriftJob {
    /// What is known about the accelerometer.
    pub sources: DriftSources,
    /// The same with every coefficient of the noise at the upper end of its interval, where that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub upper: Option<DriftSources>,
    /// An encoder beside the accelerometer: the drift is stated also with its aiding.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub encoder: Option<EncoderAiding>,
    /// Times after the start, s.
    pub times: Vec<f64>,
    /// What was taken from which result.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub taken: Vec<TakenFrom>,
}

/// Most times of a table.
const MOST: usize = 1000;

impl VelocityDriftJob {
    /// Of these sources after these times.
    pub fn new(sources: DriftSources, times: Vec<f64>) -> Self {
        Self {
            sources,
            times,
            ..Self::default()
        }
    }
}

impl Job for VelocityDriftJob {
    type Data<'a> = ();
    type Outcome = VelocityDrift;

    fn evaluate(&self, (): &(), watch: &dyn Watch) -> Result<VelocityDrift> {
        watch.step("drift", 0, 1)?;
        self.sources.check()?;
        if let Some(upper) = &self.upper {
            upper.check()?;
        }
        if self.times.is_empty() || self.times.len() > MOST {
            return Err(Trouble::request(format!(
                "{} times are named, 1 to {MOST} are needed",
                self.times.len()
            )));
        }
        if let Some(t) = self.times.iter().find(|t| !(t.is_finite() && **t > 0.0)) {
            return Err(Trouble::request(format!("after {t} s there is no drift"))
                .with_hint("times are seconds after the start, above zero"));
        }
        let again = |k: &usize| self.times[..*k].contains(&self.times[*k]);
        if let Some(k) = (1..self.times.len()).find(again) {
            return Err(
                Trouble::request(format!("{} s is named twice", self.times[k]))
                    .with_hint("name each time once"),
            );
        }
        let alone = DriftSources {
            rest: self.sources.rest,
            ..DriftSources::default()
        };
        if self.sources == alone {
            return Err(Trouble::request("no source of a drift is named").with_hint(
                "name an offset, an inclination, a gain or noise, or the uncertainty of one, such as --offset-uncertainty 0.01",
            ));
        }
        let budgets = self.after_all(&self.times)?;
        if budgets
            .iter()
            .flat_map(DriftAfter::all)
            .any(|b| !(b.known().is_finite() && b.combined.is_finite()))
            || budgets
                .iter()
                .filter_map(|b| b.beside_encoder)
                .any(|b| !b.combined.iter().all(|u| u.is_finite()))
        {
            return Err(Trouble::request("the drift overflows")
                .with_hint("check the sizes and units of what is stated"));
        }
        watch.step("drift", 1, 1)?;
        Ok(VelocityDrift::new(self.clone(), budgets))
    }
}

impl VelocityDriftJob {
    /// After every one of some times, in whatever order.
    pub(super) fn after_all(&self, times: &[f64]) -> Result<Vec<DriftAfter>> {
        let mut budgets: Vec<DriftAfter> = times.iter().map(|t| self.after(*t)).collect();
        if let Some(encoder) = &self.encoder {
            let mut order: Vec<usize> = (0..times.len()).collect();
            order.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
            let sorted: Vec<f64> = order.iter().map(|i| times[*i]).collect();
            for (i, aided) in order.iter().zip(encoder.beside(&self.sources, &sorted)?) {
                budgets[*i].beside_encoder = Some(aided);
            }
        }
        Ok(budgets)
    }

    /// Without a rest and, where there is one, with it.
    pub(super) fn after(&self, time: f64) -> DriftAfter {
        let unaided = |sources: &DriftSources| DriftSources {
            rest: 0.0,
            ..*sources
        };
        let of = |s: &DriftSources| [s.after(time), s.place_after(time)];
        let rested = self.sources.rest > 0.0;
        DriftAfter {
            alone: of(&unaided(&self.sources)),
            aided: rested.then(|| of(&self.sources)),
            upper: self.upper.as_ref().map(|u| of(&unaided(u))),
            aided_upper: self.upper.as_ref().filter(|_| rested).map(of),
            beside_encoder: None,
        }
    }
}

/// What is off after a time: velocity and place.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct DriftAfter {
    /// With what is known before alone.
    pub alone: [DriftBudget; 2],
    /// With the mean of a rest before the start taken off.
    pub aided: Option<[DriftBudget; 2]>,
    /// The first with the noise at the upper ends of its intervals.
    pub upper: Option<[DriftBudget; 2]>,
    /// The second so.
    pub aided_upper: Option<[DriftBudget; 2]>,
    /// With an encoder beside the accelerometer.
    pub beside_encoder: Option<AidedDrift>,
}

impl DriftAfter {
    fn all(&self) -> impl Iterator<Item = &DriftBudget> {
        let others = [&self.aided, &self.upper, &self.aided_upper];
        self.alone
            .iter()
            .chain(others.into_iter().flatten().flatten())
    }
}

/// The drift after each of some times.
#[derive(Clone, Debug, PartialEq)]
pub struct VelocityDrift {
    pub(super) request: VelocityDriftJob,
    budgets: Vec<DriftAfter>,
    findings: Vec<Finding>,
}

impl VelocityDrift {
    fn new(request: VelocityDriftJob, budgets: Vec<DriftAfter>) -> Self {
        let sources = request.sources;
        // A rest before the start takes the inclination off with the offset.
        let silent = sources.orientation == 0.0
            && sources.orientation_uncertainty == 0.0
            && sources.rest == 0.0;
        let findings = silent.then(|| {
            proofmass_uncertainty::findings::level_taken_as_exact(
                "the axis",
                "an inclination of a tenth of a degree is 17 mm/s² of gravity",
                "state --tilt or --tilt-uncertainty",
            )
            .at(Severity::Note)
        });
        Self {
            request,
            budgets,
            findings: findings.into_iter().collect(),
        }
    }

    /// One budget for each time.
    pub fn budgets(&self) -> &[DriftAfter] {
        &self.budgets
    }
}

impl Outcome for VelocityDrift {
    const KIND: &'static str = "velocity-drift";
    const PRINCIPAL_TABLE: &'static str = "drift.csv";

    fn title(&self, record: &Record) -> String {
        record.title(
            "Drift of",
            "Drift of a velocity from an accelerometer alone",
        )
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        let one = |what: &str, unit: &str, b: &DriftBudget| {
            let name = format!("{what}.{}s", b.time);
            StatedQuantity::new(&quantity(&name, unit, b.known(), b.combined), 0.95)
        };
        let budgets = self.budgets.iter();
        let all = budgets.flat_map(|after| {
            let [v, p] = &after.alone;
            let mut list = vec![one("drift", "m/s", v), one("place", "m", p)];
            if let Some([v, p]) = &after.aided {
                list.extend([one("drift_aided", "m/s", v), one("place_aided", "m", p)]);
            }
            if let Some(aided) = &after.beside_encoder {
                for (what, unit, u) in [
                    ("drift_beside_encoder", "m/s", aided.combined[0]),
                    ("place_beside_encoder", "m", aided.combined[1]),
                ] {
                    let name = format!("{what}.{}s", aided.time);
                    list.push(StatedQuantity::new(&quantity(&name, unit, 0.0, u), 0.95));
                }
            }
            list
        });
        all.collect()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![
            section("sources", &self.request.sources)?,
            section("taken", &self.request.taken)?,
            section("encoder", &self.request.encoder)?,
        ])
    }

    fn page(&self, page: Report) -> Report {
        page::drift(page, self)
    }
}
