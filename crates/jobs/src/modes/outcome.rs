//! What the modes of a fixture are.

use super::page::{ModesLine, ModesReport};
use super::solution::round;
use crate::outcome::Outcome;
use crate::record::Record;
use crate::trouble::Result;
use proofmass_fixture::{
    Convergence, Damping, Effort, Face, Found, FrequencySensitivity, Level, Mesh, NaturalMode,
    Search, TransferPoint, Update,
};
use proofmass_io::{Cell, StatedQuantity, Table, VtuField, vtu};
use proofmass_report::Report;
use proofmass_uncertainty::{Estimate, Finding};
use serde::{Deserialize, Serialize};

/// Modes with their intervals, the motion they give to the gluing point, what there is to doubt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) update: Option<Update>,
    pub(super) transfer: Vec<TransferPoint>,
    pub(super) plotted: Vec<TransferPoint>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) usable: Option<f64>,
    pub(super) lines: Vec<LineOutcome>,
    pub(super) body: BodyMesh,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) search: Option<(Search, Found)>,
    pub(super) findings: Vec<Finding>,
}

/// A line on the face of the gluing point, and what the modes do along it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LineOutcome {
    /// What line it is.
    pub name: String,
    /// Distance from its beginning, m.
    pub distance: Vec<f64>,
    /// Distance of the gluing point, m.
    pub gluing: f64,
    /// Modulus of the displacement per mode, over the largest of the body.
    pub shape: Vec<Vec<f64>>,
    /// Modulus of the displacement at resonance per unit acceleration of the base, per mode, s².
    pub response: Vec<Vec<f64>>,
}

/// A mesh coarse enough to be drawn and handed on, with the modes at its nodes, the largest displacement of each one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyMesh {
    /// Nodes, m.
    pub nodes: Vec<[f64; 3]>,
    /// Ten-node tetrahedra.
    pub elements: Vec<[u32; 10]>,
    /// Region of each.
    pub regions: Vec<u16>,
    /// Outer faces.
    pub faces: Vec<Face>,
    /// Displacement of the nodes, per mode.
    pub shapes: Vec<Vec<[f64; 3]>>,
}

/// Faces up to which each is drawn as four triangles.
const FINE: usize = 700;

impl BodyMesh {
    pub(super) fn new(mesh: &Mesh, shapes: &[Vec<[f64; 3]>], places: &[usize]) -> Self {
        let size = |u: &[f64; 3]| u.iter().map(|c| c * c).sum::<f64>().sqrt();
        Self {
            nodes: mesh
                .nodes()
                .iter()
                .map(|x| x.map(|c| round(c, 9)))
                .collect(),
            elements: mesh.elements().to_vec(),
            regions: mesh.regions().to_vec(),
            faces: mesh.boundary(),
            shapes: shapes
                .iter()
                .map(|shape| {
                    let largest = shape.iter().map(size).fold(f64::MIN_POSITIVE, f64::max);
                    places
                        .iter()
                        .map(|&p| shape[p].map(|u| round(u / largest, 5)))
                        .collect()
                })
                .collect(),
        }
    }

    /// Points and triangles of the surface, and the displacement of the points per mode.
    #[allow(clippy::type_complexity, reason = "three lists that belong together")]
    fn surface(&self) -> (Vec<[f64; 3]>, Vec<[u32; 3]>, Vec<Vec<[f64; 3]>>) {
        let triangles: Vec<[u32; 3]> = self
            .faces
            .iter()
            .flat_map(|f| {
                if self.faces.len() > FINE {
                    vec![[f[0], f[1], f[2]]]
                } else {
                    vec![
                        [f[0], f[3], f[5]],
                        [f[3], f[1], f[4]],
                        [f[5], f[4], f[2]],
                        [f[3], f[4], f[5]],
                    ]
                }
            })
            .collect();
        let mut index = vec![u32::MAX; self.nodes.len()];
        let mut kept: Vec<usize> = vec![];
        let triangles = triangles
            .into_iter()
            .map(|t| {
                t.map(|n| {
                    let n = n as usize;
                    if index[n] == u32::MAX {
                        index[n] = kept.len() as u32;
                        kept.push(n);
                    }
                    index[n]
                })
            })
            .collect();
        let points = kept.iter().map(|&n| self.nodes[n]).collect();
        let shapes = self
            .shapes
            .iter()
            .map(|shape| kept.iter().map(|&n| shape[n]).collect())
            .collect();
        (points, triangles, shapes)
    }
}

impl ModesOutcome {
    /// The modes as calculated; updated frequencies stand in the estimate.
    pub fn modes(&self) -> &[NaturalMode] {
        &self.modes
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

    fn with_page<T>(&self, record: &Record, make: impl FnOnce(&ModesReport<'_>) -> T) -> T {
        let (points, triangles, shapes) = self.body.surface();
        let lines = self.lines.iter().map(|l| ModesLine {
            name: &l.name,
            distance: &l.distance,
            gluing: l.gluing,
            shape: &l.shape,
            response: &l.response,
        });
        make(&ModesReport {
            head: record.head(self.title(record), &self.findings),
            probability: self.probability,
            model: &self.description,
            estimate: &self.estimate,
            modes: &self.modes,
            weight: self.weight,
            convergence: &self.convergence,
            levels: &self.levels,
            effort: self.effort,
            surface: (&points, &triangles),
            shapes: &shapes,
            lines: lines.collect(),
            damping: self.damping,
            transfer: &self.plotted,
            usable: self.usable,
            share: self.share,
            sensitivities: &self.sensitivities,
            update: self.update.as_ref(),
            search: self.search.as_ref().map(|(wanted, found)| (wanted, found)),
            free: self.free,
        })
    }

    fn table_of_modes(&self) -> Result<Table> {
        let mut table = Table::new([
            "mode",
            "frequency_Hz",
            "u_frequency_Hz",
            "U_frequency_Hz",
            "k",
            "mesh_error_Hz",
            "order",
            "participation_x_sqrt(kg)",
            "participation_y_sqrt(kg)",
            "participation_z_sqrt(kg)",
            "weight_x",
            "weight_y",
            "weight_z",
        ]);
        for (m, (mode, q)) in self.modes.iter().zip(self.quantities()).enumerate() {
            let c = self.convergence.get(m);
            let mut row = vec![
                Cell::from((m + 1) as f64),
                Cell::from(q.value),
                Cell::from(q.u),
                Cell::from(q.expanded),
                Cell::from(q.k),
                Cell::from(c.map(|c| c.error)),
                Cell::from(c.and_then(|c| c.order)),
            ];
            row.extend(mode.participation.map(Cell::from));
            row.extend(mode.residue().map(Cell::from));
            table.push(row)?;
        }
        Ok(table)
    }

    fn table_of_transfer(&self) -> Result<Table> {
        let mut columns = vec!["inclination_deg".to_owned(), "frequency_Hz".to_owned()];
        for axis in ["x", "y", "z"] {
            columns.extend(["_real", "_imaginary"].map(|part| format!("{axis}{part}")));
            columns.extend(["_real", "_imaginary"].map(|part| format!("u_{axis}{part}")));
            columns.push(format!("r_{axis}"));
        }
        let mut table = Table::new(columns);
        for point in &self.transfer {
            let mut row = vec![
                Cell::from(round(self.inclination.to_degrees(), 9)),
                Cell::from(point.frequency),
            ];
            for k in 0..3 {
                // Along z′ the departure from the excitation, as vibrometers' tables have it.
                let wanted = f64::from(u8::from(k == 2));
                let [rr, ri, ii] = point.covariance[k];
                let (u, v) = (rr.max(0.0).sqrt(), ii.max(0.0).sqrt());
                let r = if u * v > 0.0 {
                    (ri / (u * v)).clamp(-1.0, 1.0)
                } else {
                    0.0
                };
                row.extend(
                    [point.ratio[k][0] - wanted, point.ratio[k][1], u, v, r].map(Cell::from),
                );
            }
            table.push(row)?;
        }
        Ok(table)
    }

    fn table_of_line(&self, line: &LineOutcome) -> Result<Table> {
        let mut columns = vec!["distance_m".to_owned()];
        for m in 1..=line.shape.len() {
            columns.push(format!("mode_{m}_shape"));
            columns.push(format!("mode_{m}_response_s2"));
        }
        let mut table = Table::new(columns);
        for (i, d) in line.distance.iter().enumerate() {
            let mut row = vec![Cell::from(*d)];
            for (shape, response) in line.shape.iter().zip(&line.response) {
                row.push(Cell::from(shape[i]));
                row.push(Cell::from(response[i]));
            }
            table.push(row)?;
        }
        Ok(table)
    }

    fn table_of_search(&self, wanted: &Search, found: &Found) -> Result<Table> {
        let mut columns: Vec<String> = wanted
            .vary
            .iter()
            .map(|v| {
                let unit = if v.0.unit() == "1" {
                    String::new()
                } else {
                    format!("_{}", v.0.unit())
                };
                format!("{}{unit}", v.0.name().replace('-', "_"))
            })
            .collect();
        columns.extend(
            [
                "first_Hz",
                "first_that_matters_Hz",
                "mass_kg",
                "centre_from_gluing_point_m",
                "better",
            ]
            .map(str::to_owned),
        );
        let mut table = Table::new(columns);
        for trial in &found.trials {
            let mut row: Vec<Cell> = trial.values.iter().map(|v| Cell::from(*v)).collect();
            row.extend([
                Cell::from(trial.first),
                Cell::from(trial.matters),
                Cell::from(trial.mass),
                Cell::from(trial.offset),
                Cell::from(if trial.better { 1.0 } else { 0.0 }),
            ]);
            table.push(row)?;
        }
        Ok(table)
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
        self.estimate
            .quantities()
            .iter()
            .map(|q| StatedQuantity::new(q, self.probability))
            .collect()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn estimate(&self) -> Option<&Estimate> {
        Some(&self.estimate)
    }

    fn tables(&self) -> Result<Vec<(String, Table)>> {
        let mut tables = vec![("modes.csv".to_owned(), self.table_of_modes()?)];
        if !self.free {
            tables.push(("spurious.csv".to_owned(), self.table_of_transfer()?));
        }
        for (line, name) in self.lines.iter().zip(["slope.csv", "across.csv"]) {
            tables.push((name.to_owned(), self.table_of_line(line)?));
        }
        if let Some((wanted, found)) = &self.search {
            tables.push((
                "search.csv".to_owned(),
                self.table_of_search(wanted, found)?,
            ));
        }
        Ok(tables)
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

    fn summary(&self, record: &Record) -> Report {
        self.with_page(record, |page| page.summary())
    }

    fn report(&self, record: &Record) -> Report {
        self.with_page(record, |page| page.full())
    }
}
