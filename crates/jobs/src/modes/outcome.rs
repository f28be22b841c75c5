//! What the modes of a fixture are.

use super::page;
use crate::outcome::{Outcome, section};
use crate::record::Record;
use crate::trouble::Result;
use proofmass_documents::{StatedQuantity, VtuField, vtu};
use proofmass_fixture::{
    BodyMesh, Convergence, Damping, Effort, Found, FrequencySensitivity, JointStiffness, Level,
    LineMotion, NaturalMode, Search, TransferPoint, Update, round,
};
use proofmass_report::Report;
use proofmass_uncertainty::{Estimate, Finding};
use serde::{Deserialize, Serialize};

/// Modes with their intervals, the motion they give to the gluing point, what there is to doubt.
#[derive(Clone, Debug, PartialEq)]
pub struct ModesOutcome {
    pub(super) probability: f64,
    pub(super) weight: f64,
    pub(super) share: f64,
    pub(super) damping: Damping,
    pub(super) free: bool,
    pub(super) inclination: f64,
    pub(super) description: Vec<(String, String)>,
    pub(super) modes: Vec<NaturalMode>,
    pub(super) effort: Effort,
    pub(super) levels: Vec<Level>,
    pub(super) convergence: Vec<Convergence>,
    pub(super) mass: f64,
    pub(super) centre: [f64; 3],
    pub(super) estimate: Estimate,
    pub(super) sensitivities: Vec<FrequencySensitivity>,
    pub(super) update: Option<Update>,
    pub(super) transfer: Vec<TransferPoint>,
    pub(super) plotted: Vec<TransferPoint>,
    pub(super) usable: Option<f64>,
    pub(super) below: Option<BelowDevice>,
    pub(super) ends: Option<[LayerEnd; 2]>,
    pub(super) lines: Vec<LineMotion>,
    pub(super) body: BodyMesh,
    pub(super) search: Option<(Search, Found)>,
    pub(super) beside: Option<Box<BesideOutcome>>,
    pub(super) findings: Vec<Finding>,
}

/// Another fixture in the same report.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BesideOutcome {
    /// What the two are called.
    pub names: [String; 2],
    /// The other one.
    pub other: ModesOutcome,
}

/// Motion of the gluing point under a device.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BelowDevice {
    /// At the frequencies that were asked for.
    pub transfer: Vec<TransferPoint>,
    pub(super) plotted: Vec<TransferPoint>,
    /// Highest frequency with less spurious motion than the share asked for; `None` beyond the last mode.
    pub usable: Option<f64>,
}

/// The fixture with the softest or the stiffest layer that is possible.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LayerEnd {
    /// Stiffness over area.
    pub stiffness: JointStiffness,
    /// Frequencies, Hz.
    pub frequencies: Vec<f64>,
    /// Highest frequency with less spurious motion of the device than the share asked for; `None` beyond the last mode.
    pub usable: Option<f64>,
    pub(super) plotted: Vec<TransferPoint>,
}

/// What a campaign on a fixture needs of its modes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FixtureModes {
    /// Inclination of the face of the gluing point, rad.
    pub(crate) inclination: f64,
    /// Frequencies with their standard uncertainties and weights: Hz, Hz, share.
    pub resonances: Vec<[f64; 3]>,
    /// Smallest weight of a resonance that matters.
    pub(crate) weight: f64,
    /// Damping ratio.
    pub(crate) damping_ratio: f64,
    /// Share of spurious motion that was asked for.
    pub(crate) share: f64,
    /// Highest frequency with less spurious motion than that; `None` beyond the last mode.
    pub(crate) usable: Option<f64>,
}

impl FixtureModes {
    /// Section of result.json.
    pub(super) const SECTION: &'static str = "fixture";
}

impl ModesOutcome {
    /// What a campaign on the fixture needs.
    pub fn fixture(&self) -> FixtureModes {
        FixtureModes {
            inclination: self.inclination,
            resonances: self.resonances(),
            weight: self.weight,
            damping_ratio: self.damping.ratio,
            share: self.share,
            usable: self.usable,
        }
    }

    /// The modes as calculated; updated frequencies stand in the estimate.
    pub fn modes(&self) -> &[NaturalMode] {
        &self.modes
    }

    /// The meshes, from coarse to fine.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// What the meshes say about the accuracy of each.
    pub fn convergence(&self) -> &[Convergence] {
        &self.convergence
    }

    /// Spurious motion at the frequencies that were asked for.
    pub fn transfer(&self) -> &[TransferPoint] {
        &self.transfer
    }

    /// Highest frequency with less spurious motion than the share asked for; `None` beyond the last mode.
    pub fn usable(&self) -> Option<f64> {
        self.usable
    }

    /// Motion of the gluing point under the device; `None` where nothing is glued on.
    pub fn below(&self) -> Option<&BelowDevice> {
        self.below.as_ref()
    }

    /// The fixture with the softest and the stiffest layer, where its stiffness has bounds.
    pub fn layer_ends(&self) -> Option<&[LayerEnd; 2]> {
        self.ends.as_ref()
    }

    /// The other fixture of the report, where one was given.
    pub fn beside(&self) -> Option<&BesideOutcome> {
        self.beside.as_deref()
    }

    /// Inclination of the face of the gluing point, rad.
    pub fn inclination(&self) -> f64 {
        self.inclination
    }

    /// The search, where one was asked for.
    pub fn search(&self) -> Option<&Found> {
        self.search.as_ref().map(|s| &s.1)
    }

    /// Frequencies with their standard uncertainties and weights, for what is planned before a fixture is used: Hz, Hz, share.
    pub fn resonances(&self) -> Vec<[f64; 3]> {
        self.estimate
            .quantities()
            .iter()
            .zip(&self.modes)
            .map(|(q, m)| [q.value, q.standard_uncertainty, m.weight()])
            .collect()
    }

    pub(super) fn stated(&self) -> Vec<StatedQuantity> {
        let quantities = self.estimate.quantities();
        let stated = quantities
            .iter()
            .map(|q| StatedQuantity::new(q, self.probability));
        stated.collect()
    }
}

impl Outcome for ModesOutcome {
    const KIND: &'static str = "modes";

    fn title(&self, record: &Record) -> String {
        record.title(
            "Modes of",
            &format!(
                "Modes of a fixture of {}°",
                round(self.inclination.to_degrees(), 1)
            ),
        )
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.stated()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn estimate(&self) -> Option<&Estimate> {
        Some(&self.estimate)
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        let mut sections = vec![section(FixtureModes::SECTION, &self.fixture())?];
        if let Some(beside) = &self.beside {
            sections.push(section("beside", &beside.other.fixture())?);
        }
        Ok(sections)
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }

    fn attachments(&self, _record: &Record) -> Result<Vec<(String, Vec<u8>)>> {
        let quantities = self.estimate.quantities();
        let fields: Vec<VtuField<'_>> = self
            .body
            .shapes
            .iter()
            .zip(&quantities)
            .enumerate()
            .map(|(m, (values, q))| VtuField {
                name: format!("mode {} at {:.1} Hz", m + 1, q.value),
                values,
            })
            .collect();
        let body = &self.body;
        Ok(vec![(
            "modes.vtu".to_owned(),
            vtu(&body.nodes, &body.elements, &body.regions, &fields),
        )])
    }
}
