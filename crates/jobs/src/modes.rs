//! Natural frequencies and mode shapes of a wedge or another fixture of a shaker.

mod campaign;
mod file;
mod outcome;
mod page;
mod solution;

pub use campaign::{fixture_findings, read_fixtures};
pub use file::ModesFile;
#[cfg(feature = "schema")]
pub(crate) use file::modes_schema;
pub use outcome::{BelowDevice, BesideOutcome, FixtureModes, LayerEnd, ModesOutcome};

use crate::outcome::Job;
use crate::trouble::{Result, Trouble, TroubleKind};
use proofmass_core::Watch;
use proofmass_documents::GmshMesh;
use proofmass_fixture::{
    Accelerometer, Cause, Damping, Design, Device, Fault, Material, MeasuredResonance, Refine,
    Search, Support,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What is calculated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Body {
    /// A wedge by its dimensions.
    Wedge(Box<Design>),
    /// A mesh from elsewhere.
    Mesh(Box<MeshedBody>),
}

/// What belongs to a mesh from elsewhere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MeshedBody {
    /// Metres per unit of the coordinates.
    pub(crate) scale: f64,
    /// Material of every region that has none of its own.
    pub(crate) material: Material,
    /// Materials by name of the region.
    pub(crate) materials: BTreeMap<String, Material>,
    /// Name of the group of triangles that stand on the table; `None` takes the faces in the lowest plane.
    pub(crate) base: Option<String>,
    /// Where the accelerometer is glued, m.
    pub(crate) point: [f64; 3],
    /// Its footprint along the slope and across, m.
    pub(crate) footprint: [f64; 2],
    /// What the body stands on.
    pub(crate) support: Support,
    /// What is glued to it.
    pub(crate) accelerometer: Option<Accelerometer>,
    /// The block it sits on, or is.
    #[serde(default)]
    pub(crate) device: Option<Device>,
}

/// A question inside of another one: as by itself, it has no keys that it does not know.
fn strict<'de, D: serde::Deserializer<'de>>(
    deserializer: D,
) -> std::result::Result<ModesJob, D::Error> {
    use serde::de::Error as _;
    let mut keys = serde_json::Map::<String, serde_json::Value>::deserialize(deserializer)?;
    // Its kind may be said again.
    if let Some(kind) = keys.remove("job")
        && kind != <ModesOutcome as crate::outcome::Outcome>::KIND
    {
        return Err(D::Error::custom(format!(
            "a second fixture cannot be compared for {kind}: it is a request of the same kind"
        )));
    }
    let known = crate::known_keys::known_keys::<ModesJob>().unwrap_or_default();
    if let Some(unknown) = keys.keys().find(|key| !known.contains(&key.as_str())) {
        return Err(D::Error::unknown_field(unknown, known));
    }
    serde_json::from_value(keys.into()).map_err(D::Error::custom)
}

/// Another fixture beside the one that is asked about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Beside {
    /// What the two are called.
    pub names: [String; 2],
    /// The question of the other one, without a further one beside it.
    #[serde(deserialize_with = "strict")]
    pub job: ModesJob,
}

/// The question.
///
/// ```
/// use proofmass_fixture::{Design, Material, Wedge};
/// use proofmass_jobs::{Job, Outcome, Unwatched, modes::{Body, ModesData, ModesJob}};
///
/// let wedge = Wedge::new(35f64.to_radians(), 0.070, 0.060, 0.010);
/// let design = Design::new(wedge, Material::preset("aluminium").unwrap());
/// let mut job = ModesJob::new(Body::Wedge(Box::new(design)));
/// job.count = 4;
/// job.refine.limit = 20_000;
/// let outcome = job.evaluate(&ModesData::default(), &Unwatched)?;
/// let first = &outcome.quantities()[0];
/// assert_eq!(first.name, "mode-1.frequency");
/// assert!(first.expanded < 0.05 * first.value);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ModesJob {
    /// What is calculated.
    pub body: Body,
    /// Number of modes.
    pub count: usize,
    /// Wanted accuracy and how far it may go for it.
    pub refine: Refine,
    /// Modal damping.
    pub damping: Damping,
    /// Frequencies of the table of spurious motion, Hz; empty takes thirds of an octave.
    pub frequencies: Vec<f64>,
    /// Share of spurious motion up to which the fixture counts as usable.
    pub share: f64,
    /// A mode matters when its weight is at least this.
    pub weight: f64,
    /// What is uncertain.
    pub causes: Vec<Cause>,
    /// Resonances found by measurement.
    pub measured: Vec<MeasuredResonance>,
    /// A search over shapes.
    pub search: Option<Search>,
    /// Another fixture, which stands beside this one in the report.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beside: Option<Box<Beside>>,
    /// Probability of the intervals.
    pub probability: f64,
}

impl ModesJob {
    /// Ten modes to 0.5 %, ζ = 0.005, usable below 2 % spurious motion, 95 % intervals.
    pub fn new(body: Body) -> Self {
        Self {
            body,
            count: 10,
            refine: Refine::default(),
            damping: Damping::default(),
            frequencies: vec![],
            share: 0.02,
            weight: 0.01,
            causes: vec![],
            measured: vec![],
            search: None,
            beside: None,
            probability: 0.95,
        }
    }

    fn check(&self) -> Result<()> {
        let refuse = |what: String| Err(Trouble::request(what));
        if !(1..=200).contains(&self.count) {
            return refuse(format!(
                "{} modes are asked for, 1 to 200 are possible",
                self.count
            ));
        }
        if !(self.probability > 0.0 && self.probability < 1.0) {
            return refuse(format!(
                "a probability of {} is out of range: above 0 and below 1",
                self.probability
            ));
        }
        if !(self.damping.ratio > 0.0 && self.damping.ratio < 0.5) {
            return refuse(format!(
                "a damping ratio of {} is out of range: above 0 and below 0.5; metal has 0.002 to 0.02",
                self.damping.ratio
            ));
        }
        if !(self.damping.u >= 0.0 && self.damping.u.is_finite()) {
            return refuse(format!(
                "a standard uncertainty of the damping ratio of {} is out of range: it must not be negative",
                self.damping.u
            ));
        }
        for (name, value) in [("share", self.share), ("weight", self.weight)] {
            if !(value > 0.0 && value < 1.0) {
                return refuse(format!(
                    "a {name} of {value} is out of range: above 0 and below 1"
                ));
            }
        }
        if let Some(f) = self
            .frequencies
            .iter()
            .find(|f| !(f.is_finite() && **f > 0.0))
        {
            return refuse(format!(
                "a frequency of {f} Hz is out of range: it must be positive"
            ));
        }
        Ok(())
    }
}

/// The mesh, where the body is one.
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub struct ModesData<'a> {
    /// As read.
    pub mesh: Option<&'a GmshMesh>,
    /// That of the fixture beside it.
    pub beside: Option<&'a GmshMesh>,
}

impl Job for ModesJob {
    type Data<'a> = ModesData<'a>;
    type Outcome = ModesOutcome;

    fn evaluate(&self, data: &ModesData<'_>, watch: &dyn Watch) -> Result<ModesOutcome> {
        self.check()?;
        let Some(beside) = &self.beside else {
            return solution::solve(self, data, watch);
        };
        beside.job.check()?;
        if beside.job.beside.is_some() {
            return Err(Trouble::request(
                "a third fixture is to stand beside the second: two are compared at a time",
            ));
        }
        let mut outcome = solution::solve(self, data, watch)?;
        let other = ModesData {
            mesh: data.beside,
            beside: None,
        };
        outcome.beside = Some(Box::new(BesideOutcome {
            names: beside.names.clone(),
            other: solution::solve(&beside.job, &other, watch)?,
        }));
        Ok(outcome)
    }
}

/// A fault as trouble of a job.
pub(crate) fn trouble(fault: Fault) -> Trouble {
    let kind = match &fault {
        Fault::Cancelled => TroubleKind::Cancelled,
        Fault::Parameter { .. } | Fault::Search { .. } | Fault::NoMaterial { .. } => {
            TroubleKind::Request
        }
        _ => TroubleKind::Data,
    };
    Trouble::new(kind, fault.to_string())
}
