//! `WEDGE.toml`: a fixture, and what is wanted of it.

use super::{Beside, Body, MeshedBody, ModesData, ModesJob};
use crate::campaign::CampaignFile;
use crate::record::Record;
use proofmass_documents::{Ambient, Device, GmshMesh};
use proofmass_fixture::{
    Accelerometer, Bore, Cause, Damping, Design, Device as GluedDevice, Dimension, Foot, Goal,
    JointStiffness, Layer, LayerModulus, Material, MeasuredResonance, Observed, Parameter, Search,
    ShakerTable, Sides, Support, Wedge,
};
use proofmass_io::{Error, Input, Result, Software};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// A fixture read from a file, with the mesh it names.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ModesFile {
    /// The file.
    pub(crate) source: CampaignFile,
    /// Title of the report.
    pub(crate) title: Option<String>,
    /// The question.
    pub job: ModesJob,
    mesh: Option<(GmshMesh, Input)>,
    beside: Option<Box<ModesFile>>,
}

#[cfg(feature = "schema")]
pub(crate) fn modes_schema() -> crate::schema::Readable {
    crate::schema::Readable::of::<File>()
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct File {
    /// One line for the head of the report.
    title: Option<String>,
    /// A wedge by its dimensions.
    wedge: Option<WedgeTable>,
    /// Any body by a mesh, instead of `wedge`.
    mesh: Option<MeshTable>,
    /// Material, aluminium without it; with a mesh of the volumes that `materials` does not name.
    material: Option<MaterialTable>,
    /// Materials of a mesh, by the names of its physical volumes.
    #[serde(default)]
    materials: BTreeMap<String, MaterialTable>,
    /// What the body stands on; clamped without it.
    support: Option<SupportTable>,
    /// What is glued to it.
    accelerometer: Option<AccelerometerTable>,
    /// A block on the gluing point: the accelerometer itself, or what carries it.
    device: Option<DeviceTable>,
    /// Which modes, and how well.
    modes: Option<ModesTable>,
    /// Motion of the mounting point over frequency.
    transfer: Option<TransferTable>,
    /// Standard uncertainties: of a dimension by its key, `young_percent`, `poisson`, `density_percent` and others of the material.
    #[serde(default)]
    uncertainty: BTreeMap<String, f64>,
    /// Resonances from an impact test, by which the parameters are updated.
    #[serde(default)]
    measured: Vec<MeasuredTable>,
    /// A search for a shape with higher resonances.
    search: Option<SearchTable>,
    /// How intervals are stated.
    evaluation: Option<EvaluationTable>,
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct WedgeTable {
    /// Inclination of the upper face, degrees.
    angle_deg: f64,
    /// Length along x, the direction of the slope, mm.
    length_mm: f64,
    /// Width, mm.
    width_mm: f64,
    /// Height of the low end, mm.
    toe_mm: f64,
    /// Height at which the slope is cut off level, mm; without it the slope runs to the high end.
    height_mm: Option<f64>,
    /// Where along x the accelerometer is glued, from the axis of excitation, mm.
    #[serde(default)]
    gluing_mm: f64,
    /// Footprint of the accelerometer along the slope and across, mm.
    footprint_mm: Option<[f64; 2]>,
    /// A base plate; the toe is measured from the base and includes it.
    foot: Option<FootTable>,
    /// Two masses at the sides.
    sides: Option<SidesTable>,
    /// A smooth blind hole in the base.
    bore: Option<BoreTable>,
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct FootTable {
    /// Thickness, mm.
    thickness_mm: f64,
    /// How far it reaches beyond the body, mm.
    overhang_mm: f64,
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct SidesTable {
    /// Thickness of each, mm.
    thickness_mm: f64,
    /// Where along x they begin, mm.
    from_mm: f64,
    /// Where along x they end, mm.
    to_mm: f64,
    /// How far they rise above the slope, vertically, mm.
    rise_mm: f64,
    /// Share of the height, from the slope down, to which they are joined; 1 reaches the foot.
    #[serde(default = "whole")]
    depth: f64,
    /// Their material, where it is another.
    material: Option<MaterialTable>,
}

fn whole() -> f64 {
    1.0
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct BoreTable {
    /// Diameter, mm.
    diameter_mm: f64,
    /// Depth, mm.
    depth_mm: f64,
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct MeshTable {
    /// Mesh from Gmsh, relative to this file.
    file: String,
    /// Unit of its lengths.
    #[serde(default = "millimetre")]
    unit: String,
    /// Name of the physical surface that stands on the support; without it the faces in the lowest plane.
    base: Option<String>,
    /// Where the accelerometer is glued, mm.
    gluing_point_mm: [f64; 3],
    /// Footprint of the accelerometer, mm.
    footprint_mm: Option<[f64; 2]>,
}

fn millimetre() -> String {
    "mm".into()
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct MaterialTable {
    /// A known material, such as `aluminium`, `steel` or `brass`.
    preset: Option<String>,
    /// Name in the report.
    name: Option<String>,
    /// Young's modulus, GPa.
    #[serde(rename = "young_GPa")]
    young_gpa: Option<f64>,
    /// Poisson's ratio.
    poisson: Option<f64>,
    /// Density, kg/m³.
    #[serde(rename = "density_kg_per_m3")]
    density_kg_per_m3: Option<f64>,
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
enum SupportKind {
    Clamped,
    Elastic,
    Table,
    Free,
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct SupportTable {
    /// Kind of support.
    kind: SupportKind,
    /// Stiffness of the whole base, normal to it, N/m.
    #[serde(rename = "normal_N_per_m")]
    normal: Option<f64>,
    /// Stiffness of the whole base, along it, N/m.
    #[serde(rename = "tangential_N_per_m")]
    tangential: Option<f64>,
    /// Moving mass of the table, kg.
    mass_kg: Option<f64>,
    /// Stiffness of its suspension along the excitation, N/m.
    #[serde(rename = "axial_N_per_m")]
    axial: Option<f64>,
    /// Stiffness of its suspension across, N/m.
    #[serde(rename = "lateral_N_per_m")]
    lateral: Option<f64>,
    /// Stiffness against rocking, N m/rad.
    #[serde(rename = "rocking_Nm_per_rad")]
    rocking: Option<f64>,
    /// Radius of gyration of the table, mm.
    gyration_mm: Option<f64>,
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct AccelerometerTable {
    /// Mass, g.
    mass_g: f64,
    /// Height of its centre of mass above the face, mm.
    #[serde(default)]
    height_mm: f64,
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct DeviceTable {
    /// Size up the slope, across, and along the normal of the face, mm.
    size_mm: [f64; 3],
    /// Its material, aluminium without it.
    material: Option<MaterialTable>,
    /// Its mass, g, instead of the density of the material.
    mass_g: Option<f64>,
    /// Where its motion is taken: at its centre, or at its upper face; the upper face where an accelerometer sits on it.
    observed: Option<Observed>,
    /// The adhesive or contact below it; without it the device is one with the fixture.
    layer: Option<LayerTable>,
}

/// A number, or the least and the largest it may be.
#[derive(Clone, Copy, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "a number, or [least, largest]")]
enum Bounded {
    /// As it is.
    Number(f64),
    /// Least and largest.
    Interval([f64; 2]),
}

impl Bounded {
    fn ends(self) -> [f64; 2] {
        match self {
            Self::Number(v) => [v; 2],
            Self::Interval(ends) => ends,
        }
    }
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct LayerTable {
    /// Thickness of the adhesive, mm, or [least, largest].
    thickness_mm: Option<Bounded>,
    /// Young's modulus of the adhesive, GPa, or [least, largest].
    #[serde(rename = "young_GPa")]
    young_gpa: Option<Bounded>,
    /// Poisson's ratio of the adhesive.
    poisson: Option<f64>,
    /// Modulus along the normal: constrained where the layer is thin against its width, or free.
    modulus: Option<LayerModulus>,
    /// Stiffness along the normal over area, N/m³, or [least, largest], instead of an adhesive.
    #[serde(rename = "normal_N_per_m3")]
    normal: Option<Bounded>,
    /// Stiffness along the face over area, N/m³, or [least, largest], instead of an adhesive.
    #[serde(rename = "tangential_N_per_m3")]
    tangential: Option<Bounded>,
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct ModesTable {
    /// How many modes.
    count: Option<usize>,
    /// Accuracy wanted of every frequency, relative.
    accuracy: Option<f64>,
    /// Unknowns of the largest mesh.
    unknowns: Option<usize>,
    /// Size of an element, mm, instead of refining.
    size_mm: Option<f64>,
    /// Weight from which a mode is relevant.
    weight: Option<f64>,
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct TransferTable {
    /// Damping ratio ζ of every mode.
    damping: Option<f64>,
    /// Its standard uncertainty.
    u_damping: Option<f64>,
    /// Frequencies, Hz.
    #[serde(rename = "frequencies_Hz")]
    frequencies_hz: Option<Vec<f64>>,
    /// Spurious motion up to which the wedge counts as usable.
    share: Option<f64>,
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct MeasuredTable {
    /// Number of the mode, from one.
    mode: usize,
    /// Measured natural frequency, Hz.
    #[serde(rename = "frequency_Hz")]
    frequency_hz: f64,
    /// Its standard uncertainty, Hz.
    #[serde(rename = "u_Hz")]
    u_hz: f64,
}

#[derive(Default, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
enum GoalKind {
    #[default]
    FirstMode,
    LeastMotion,
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct SearchTable {
    /// Dimensions that may change, each with its least and largest value.
    vary: BTreeMap<String, [f64; 2]>,
    /// Largest mass, g.
    heaviest_g: Option<f64>,
    /// Shapes that are solved.
    trials: Option<usize>,
    /// What makes a shape better: a higher first relevant mode, or less spurious motion up to `up_to_Hz`.
    #[serde(default)]
    goal: GoalKind,
    /// End of the band of the goal `least-motion`, Hz.
    #[serde(rename = "up_to_Hz")]
    up_to_hz: Option<f64>,
    /// Modes looked at in every shape.
    count: Option<usize>,
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct EvaluationTable {
    /// Coverage probability of the intervals.
    probability: f64,
}

/// Name of a dimension with its unit as in a file, and the factor to SI.
fn dimension_key(d: Dimension) -> (String, f64) {
    let name = d.name().replace('-', "_");
    match d.unit() {
        "m" => (format!("{name}_mm"), 1e-3),
        "rad" => (format!("{name}_deg"), std::f64::consts::PI / 180.0),
        _ => (name, 1.0),
    }
}

fn dimension(key: &str) -> Option<(Dimension, f64)> {
    Dimension::ALL
        .into_iter()
        .map(|d| (d, dimension_key(d)))
        .find(|(_, (name, _))| name == key)
        .map(|(d, (_, factor))| (d, factor))
}

impl ModesFile {
    /// Reads a fixture, and the mesh it names from the same folder.
    ///
    /// # Errors
    /// A missing file, an unknown key (with the nearest valid one), a value that cannot be: with its line.
    pub fn open(path: &Path) -> Result<Self> {
        Self::of(CampaignFile::open(path)?).map_err(|error| match error.hint() {
            Some(_) => error,
            None => error.with_hint("a fixture is described by a TOML file with [wedge] or [mesh]; `proofmass modes --help` tells more"),
        })
    }

    /// Reads a fixture that another file names.
    ///
    /// # Errors
    /// As [`ModesFile::open`].
    pub fn of(source: CampaignFile) -> Result<Self> {
        let file: File = source.parse()?;
        let material = match &file.material {
            Some(table) => material(&source, "material", table)?,
            None => Material::preset("aluminium")
                .ok_or_else(|| source.refuse("", "material", "is missing"))?,
        };
        let support = support(&source, file.support.as_ref())?;
        let accelerometer = file.accelerometer.as_ref().map(|a| Accelerometer {
            mass: 1e-3 * a.mass_g,
            height: 1e-3 * a.height_mm,
        });
        let device = match &file.device {
            Some(table) => Some(device(&source, table, accelerometer.is_some())?),
            None => None,
        };
        let footprint = |table: &str, given: Option<[f64; 2]>| match (&device, given) {
            (Some(device), None) => Ok([device.size[0], device.size[1]]),
            (Some(_), Some(_)) => Err(source
                .refuse(table, "footprint_mm", "the footprint is that of the device")
                .with_hint("leave it out: `size_mm` in [device] gives it")),
            (None, given) => Ok(given.unwrap_or([10.0, 10.0]).map(|v| 1e-3 * v)),
        };
        let mut mesh = None;
        let body = match (&file.wedge, &file.mesh) {
            (Some(w), None) => {
                if !file.materials.is_empty() {
                    return Err(source
                        .refuse("", "materials", "regions by name belong to a mesh")
                        .with_hint("the side masses of a wedge have [wedge.sides.material]"));
                }
                let mut wedge = Wedge::new(
                    w.angle_deg.to_radians(),
                    1e-3 * w.length_mm,
                    1e-3 * w.width_mm,
                    1e-3 * w.toe_mm,
                );
                wedge.height = w.height_mm.map(|h| 1e-3 * h);
                wedge.gluing = 1e-3 * w.gluing_mm;
                wedge.footprint = footprint("wedge", w.footprint_mm)?;
                wedge.foot = w.foot.as_ref().map(|f| Foot {
                    thickness: 1e-3 * f.thickness_mm,
                    overhang: 1e-3 * f.overhang_mm,
                });
                wedge.sides = w.sides.as_ref().map(|s| Sides {
                    thickness: 1e-3 * s.thickness_mm,
                    from: 1e-3 * s.from_mm,
                    to: 1e-3 * s.to_mm,
                    rise: 1e-3 * s.rise_mm,
                    depth: s.depth,
                });
                wedge.bore = w.bore.as_ref().map(|b| Bore {
                    diameter: 1e-3 * b.diameter_mm,
                    depth: 1e-3 * b.depth_mm,
                });
                let mut design = Design::new(wedge, material);
                if let Some(table) = w.sides.as_ref().and_then(|s| s.material.as_ref()) {
                    design.sides = Some(self::material(&source, "wedge.sides.material", table)?);
                }
                design.support = support;
                design.accelerometer = accelerometer;
                design.device = device;
                design
                    .wedge
                    .check()
                    .map_err(|fault| source.refuse("", "wedge", fault.to_string()))?;
                Body::Wedge(Box::new(design))
            }
            (None, Some(m)) => {
                let scale = match m.unit.as_str() {
                    "m" => 1.0,
                    "mm" => 1e-3,
                    other => {
                        return Err(source
                            .refuse("mesh", "unit", format!("`{other}` is not known"))
                            .with_hint("the unit of the coordinates of the mesh: mm or m"));
                    }
                };
                let (text, input) = source.text(&m.file)?;
                mesh = Some((GmshMesh::parse(&text, &source.resolve(&m.file))?, input));
                let materials = file
                    .materials
                    .iter()
                    .map(|(name, table)| {
                        Ok((name.clone(), self::material(&source, "materials", table)?))
                    })
                    .collect::<Result<_>>()?;
                Body::Mesh(Box::new(MeshedBody {
                    scale,
                    material,
                    materials,
                    base: m.base.clone(),
                    point: m.gluing_point_mm.map(|v| 1e-3 * v),
                    footprint: footprint("mesh", m.footprint_mm)?,
                    support,
                    accelerometer,
                    device,
                }))
            }
            _ => {
                return Err(source
                    .refuse("", "wedge", "the file describes no fixture, or two")
                    .with_hint(
                        "give either [wedge] with its dimensions or [mesh] with the file of a mesh",
                    ));
            }
        };
        let mut job = ModesJob::new(body);
        if let Some(m) = &file.modes {
            job.count = m.count.unwrap_or(job.count);
            job.refine.accuracy = m.accuracy.unwrap_or(job.refine.accuracy);
            job.refine.limit = m.unknowns.unwrap_or(job.refine.limit);
            job.refine.size = m.size_mm.map(|s| 1e-3 * s);
            job.weight = m.weight.unwrap_or(job.weight);
        }
        if let Some(t) = &file.transfer {
            let ratio = t.damping.unwrap_or(job.damping.ratio);
            job.damping = Damping {
                ratio,
                // Damping is known to half of it unless somebody measured.
                u: t.u_damping.unwrap_or(0.5 * ratio),
            };
            job.frequencies = t.frequencies_hz.clone().unwrap_or_default();
            job.share = t.share.unwrap_or(job.share);
        }
        for (key, &u) in &file.uncertainty {
            job.causes.push(cause(&source, &job, key, u)?);
        }
        for m in &file.measured {
            let mode = m
                .mode
                .checked_sub(1)
                .ok_or_else(|| source.refuse("measured", "mode", "modes are counted from 1"))?;
            job.measured.push(MeasuredResonance {
                mode,
                frequency: m.frequency_hz,
                u: m.u_hz,
            });
        }
        if let Some(s) = &file.search {
            let mut vary = vec![];
            for (key, [low, high]) in &s.vary {
                let Some((d, factor)) = dimension(key) else {
                    return Err(unknown_dimension(&source, "search.vary", key));
                };
                vary.push((d, factor * low, factor * high));
            }
            let mut search = Search::new(vary);
            search.weight = job.weight;
            search.heaviest = s.heaviest_g.map(|m| 1e-3 * m);
            search.trials = s.trials.unwrap_or(search.trials);
            search.count = s.count.unwrap_or(search.count);
            search.goal = match (&s.goal, s.up_to_hz) {
                (GoalKind::FirstMode, None) => Goal::FirstMode,
                (GoalKind::LeastMotion, Some(up_to)) => Goal::LeastMotion {
                    up_to,
                    damping: job.damping.ratio,
                },
                (GoalKind::FirstMode, Some(_)) => {
                    return Err(source
                        .refuse("search", "up_to_Hz", "belongs to the goal `least-motion`")
                        .with_hint("write goal = \"least-motion\", or leave it out"));
                }
                (GoalKind::LeastMotion, None) => {
                    return Err(source
                        .refuse("search", "goal", "the end of the band is missing")
                        .with_hint("up_to_Hz is the highest frequency at which the gluing point is to keep still"));
                }
            };
            job.search = Some(search);
        }
        if let Some(e) = &file.evaluation {
            job.probability = e.probability;
        }
        Ok(Self {
            title: file.title,
            job,
            mesh,
            beside: None,
            source,
        })
    }

    /// The same with another fixture beside it in the report.
    pub fn beside(mut self, other: Self) -> Self {
        let name = |file: &Self, otherwise: &str| match &file.title {
            Some(title) => title.clone(),
            None => otherwise.to_owned(),
        };
        self.job.beside = Some(Box::new(Beside {
            names: [name(&self, "first"), name(&other, "second")],
            job: other.job.clone(),
        }));
        self.beside = Some(Box::new(other));
        self
    }

    /// The data of the question.
    pub fn data(&self) -> ModesData<'_> {
        ModesData {
            mesh: self.mesh.as_ref().map(|m| &m.0),
            beside: self
                .beside
                .as_ref()
                .and_then(|other| other.mesh.as_ref())
                .map(|m| &m.0),
        }
    }

    /// What a result is filed with.
    pub fn record(&self, date: Option<String>) -> Record {
        let mut inputs = vec![self.source.input.clone()];
        inputs.extend(self.mesh.iter().map(|m| m.1.clone()));
        if let Some(other) = &self.beside {
            inputs.push(other.source.input.clone());
            inputs.extend(other.mesh.iter().map(|m| m.1.clone()));
        }
        Record {
            title: self.title.clone(),
            device: Device::default(),
            ambient: Ambient::default(),
            date,
            inputs,
            software: Software::default(),
        }
    }
}

fn unknown_dimension(source: &CampaignFile, table: &str, key: &str) -> Error {
    let names: Vec<String> = Dimension::ALL
        .into_iter()
        .map(|d| dimension_key(d).0)
        .collect();
    let near = proofmass_io::spelling::nearest(key, names.iter().map(String::as_str))
        .map_or(String::new(), |near| format!("did you mean `{near}`? "));
    source
        .refuse(table, key, "is no dimension of a wedge")
        .with_hint(format!("{near}valid here: {}", names.join(", ")))
}

/// `key = u` of [uncertainty].
fn cause(source: &CampaignFile, job: &ModesJob, key: &str, u: f64) -> Result<Cause> {
    if !(u.is_finite() && u >= 0.0) {
        return Err(source
            .refuse(
                "uncertainty",
                key,
                format!("{u} is out of range: a standard uncertainty must not be negative"),
            )
            .with_hint("give a number from zero up"));
    }
    if let Some((d, factor)) = dimension(key) {
        return Ok(Cause::new(Parameter::Dimension(d), factor * u));
    }
    let (body, sides, support, load) = match &job.body {
        Body::Wedge(d) => (
            Some(&d.material),
            d.wedge
                .sides
                .as_ref()
                .map(|_| d.sides.as_ref().unwrap_or(&d.material)),
            d.support,
            d.accelerometer,
        ),
        Body::Mesh(b) => (Some(&b.material), None, b.support, b.accelerometer),
    };
    let device = match &job.body {
        Body::Wedge(d) => d.device.as_ref(),
        Body::Mesh(b) => b.device.as_ref(),
    };
    let layer = device.and_then(|d| d.layer);
    let adhesive = match layer {
        Some(Layer::Adhesive { young, .. }) => Some(young),
        _ => None,
    };
    let contact = match layer {
        Some(Layer::Contact(k)) => [Some(0.01 * k.normal), Some(0.01 * k.tangential)],
        _ => [None, None],
    };
    // The last region; of a mesh, whose regions are not read yet, its elements have one material each.
    let glued = match &job.body {
        Body::Wedge(d) => device.map(|_| d.materials().len() - 1),
        Body::Mesh(_) => None,
    };
    let of_device = |change: fn(&Material) -> f64| {
        device
            .filter(|_| glued.is_some())
            .map(|d| 0.01 * change(&d.material))
    };
    let glued = glued.unwrap_or(0);
    let springs = match support {
        Support::Elastic { normal, tangential } => [Some(normal), Some(tangential)],
        _ => [None, None],
    };
    let table = match support {
        Support::Table(t) => Some(t),
        _ => None,
    };
    // Name, parameter, and what u is a percentage of; `Some(1.0)` with the factor 1 is absolute.
    let known: Vec<(&str, Parameter, Option<f64>)> = vec![
        (
            "young_percent",
            Parameter::Young(0),
            body.map(|m| 0.01 * m.young),
        ),
        ("poisson", Parameter::Poisson(0), Some(1.0)),
        (
            "density_percent",
            Parameter::Density(0),
            body.map(|m| 0.01 * m.density),
        ),
        (
            "sides_young_percent",
            Parameter::Young(1),
            sides.map(|m| 0.01 * m.young),
        ),
        (
            "sides_density_percent",
            Parameter::Density(1),
            sides.map(|m| 0.01 * m.density),
        ),
        ("size_percent", Parameter::Scale, Some(0.01)),
        (
            "normal_stiffness_percent",
            Parameter::NormalStiffness,
            springs[0].map(|k| 0.01 * k),
        ),
        (
            "tangential_stiffness_percent",
            Parameter::TangentialStiffness,
            springs[1].map(|k| 0.01 * k),
        ),
        (
            "table_mass_percent",
            Parameter::TableMass,
            table.map(|t| 0.01 * t.mass),
        ),
        (
            "table_axial_percent",
            Parameter::TableAxial,
            table.map(|t| 0.01 * t.axial),
        ),
        (
            "table_lateral_percent",
            Parameter::TableLateral,
            table.and_then(|t| t.lateral).map(|k| 0.01 * k),
        ),
        (
            "table_rocking_percent",
            Parameter::TableRocking,
            table.and_then(|t| t.rocking).map(|k| 0.01 * k),
        ),
        (
            "accelerometer_mass_g",
            Parameter::AccelerometerMass,
            load.map(|_| 1e-3),
        ),
        (
            "accelerometer_height_mm",
            Parameter::AccelerometerHeight,
            load.map(|_| 1e-3),
        ),
        (
            "device_young_percent",
            Parameter::Young(glued),
            of_device(|m| m.young),
        ),
        (
            "device_density_percent",
            Parameter::Density(glued),
            of_device(|m| m.density),
        ),
        (
            "layer_young_percent",
            Parameter::LayerYoung,
            adhesive.map(|e| 0.01 * e),
        ),
        (
            "layer_poisson",
            Parameter::LayerPoisson,
            adhesive.map(|_| 1.0),
        ),
        (
            "layer_thickness_mm",
            Parameter::LayerThickness,
            adhesive.map(|_| 1e-3),
        ),
        ("layer_normal_percent", Parameter::LayerNormal, contact[0]),
        (
            "layer_tangential_percent",
            Parameter::LayerTangential,
            contact[1],
        ),
    ];
    match known.iter().find(|k| k.0 == key) {
        Some((_, parameter, Some(factor))) => Ok(Cause::new(parameter.clone(), factor * u)),
        Some((.., None)) => {
            Err(source.refuse("uncertainty", key, "this fixture has no such thing"))
        }
        None => {
            let mut names: Vec<String> = known.iter().map(|k| k.0.to_owned()).collect();
            names.extend(Dimension::ALL.into_iter().map(|d| dimension_key(d).0));
            let near = proofmass_io::spelling::nearest(key, names.iter().map(String::as_str))
                .map_or(String::new(), |near| format!("did you mean `{near}`? "));
            Err(source
                .refuse("uncertainty", key, "is not known")
                .with_hint(format!("{near}valid here: {}", names.join(", "))))
        }
    }
}

fn material(source: &CampaignFile, table: &str, m: &MaterialTable) -> Result<Material> {
    let mut material = match &m.preset {
        Some(name) => Material::preset(name).ok_or_else(|| {
            let names: Vec<&str> = Material::presets().collect();
            source
                .refuse(table, "preset", format!("`{name}` is not known"))
                .with_hint(format!(
                    "known: {}; or give young_GPa, poisson, density_kg_per_m3",
                    names.join(", ")
                ))
        })?,
        None => {
            let (Some(_), Some(_), Some(_)) = (m.young_gpa, m.poisson, m.density_kg_per_m3) else {
                return Err(source
                    .refuse("", table, "the material is not complete")
                    .with_hint("give a preset, or young_GPa, poisson and density_kg_per_m3"));
            };
            Material::new("as given", 0.0, 0.0, 0.0)
        }
    };
    if let Some(name) = &m.name {
        material.name.clone_from(name);
    }
    material.young = m.young_gpa.map_or(material.young, |e| 1e9 * e);
    material.poisson = m.poisson.unwrap_or(material.poisson);
    material.density = m.density_kg_per_m3.unwrap_or(material.density);
    material
        .check()
        .map_err(|fault| source.refuse("", table, fault.to_string()))?;
    Ok(material)
}

fn device(source: &CampaignFile, table: &DeviceTable, loaded: bool) -> Result<GluedDevice> {
    let size = table.size_mm.map(|v| 1e-3 * v);
    let mut material = match &table.material {
        Some(m) => self::material(source, "device.material", m)?,
        None => Material::preset("aluminium")
            .ok_or_else(|| source.refuse("device", "material", "is missing"))?,
    };
    if let Some(mass) = table.mass_g {
        if table
            .material
            .as_ref()
            .is_some_and(|m| m.density_kg_per_m3.is_some())
        {
            return Err(source.refuse("device", "mass_g", "density and mass are both given"));
        }
        material.density = 1e-3 * mass / size.iter().product::<f64>();
    }
    let mut device = GluedDevice::new(size, material);
    device.observed = table.observed.unwrap_or(match loaded {
        true => Observed::Top,
        false => Observed::Centre,
    });
    if let Some(table) = &table.layer {
        let (layer, bounds) = layer(source, table)?;
        device.layer = Some(layer);
        device.bounds = bounds;
    }
    device
        .check()
        .map_err(|fault| source.refuse("", "device", fault.to_string()))?;
    Ok(device)
}

/// The layer in the middle of its bounds, and these where there are any.
fn layer(
    source: &CampaignFile,
    table: &LayerTable,
) -> Result<(Layer, Option<[JointStiffness; 2]>)> {
    let refuse = |key: &str, what: &str| source.refuse("device.layer", key, what);
    let ends = |key: &str, given: Option<Bounded>| {
        let Some(given) = given else {
            return Err(refuse(key, "is missing").with_hint(
                "an adhesive has thickness_mm, young_GPa and poisson; any other contact normal_N_per_m3 and tangential_N_per_m3",
            ));
        };
        let [low, high] = given.ends();
        match low > 0.0 && high.is_finite() && low <= high {
            true => Ok([low, high]),
            false => Err(refuse(
                key,
                "must be a positive number, or an interval [least, largest] of two",
            )),
        }
    };
    // Stiffnesses and thicknesses are known to a factor: the middle is the geometric one.
    let middle = |[low, high]: [f64; 2]| (low * high).sqrt();
    let layers = if table.normal.is_some() || table.tangential.is_some() {
        if table.thickness_mm.is_some()
            || table.young_gpa.is_some()
            || table.poisson.is_some()
            || table.modulus.is_some()
        {
            return Err(refuse(
                "normal_N_per_m3",
                "a layer is given by its adhesive or by its stiffness over area, not by both",
            ));
        }
        let normal = ends("normal_N_per_m3", table.normal)?;
        let tangential = ends("tangential_N_per_m3", table.tangential)?;
        let contact = |normal, tangential| Layer::Contact(JointStiffness { normal, tangential });
        [
            contact(normal[0], tangential[0]),
            contact(middle(normal), middle(tangential)),
            contact(normal[1], tangential[1]),
        ]
    } else {
        let thickness = ends("thickness_mm", table.thickness_mm)?.map(|v| 1e-3 * v);
        let young = ends("young_GPa", table.young_gpa)?.map(|v| 1e9 * v);
        let Some(poisson) = table.poisson else {
            return Err(refuse("poisson", "is missing"));
        };
        let modulus = table.modulus.unwrap_or_default();
        let adhesive = |thickness, young| Layer::Adhesive {
            thickness,
            young,
            poisson,
            modulus,
        };
        [
            adhesive(thickness[1], young[0]),
            adhesive(middle(thickness), middle(young)),
            adhesive(thickness[0], young[1]),
        ]
    };
    let [soft, layer, stiff] = layers;
    let bounds = (soft != stiff).then(|| [soft.stiffness(), stiff.stiffness()]);
    Ok((layer, bounds))
}

fn support(source: &CampaignFile, table: Option<&SupportTable>) -> Result<Support> {
    let Some(t) = table else {
        return Ok(Support::Clamped);
    };
    let need = |value: Option<f64>, key: &str| {
        value.ok_or_else(|| source.refuse("support", key, format!("{key} is missing")))
    };
    let support = match t.kind {
        SupportKind::Clamped => Support::Clamped,
        SupportKind::Free => Support::Free,
        SupportKind::Elastic => Support::Elastic {
            normal: need(t.normal, "normal_N_per_m")?,
            tangential: need(t.tangential, "tangential_N_per_m")?,
        },
        SupportKind::Table => Support::Table(ShakerTable {
            mass: need(t.mass_kg, "mass_kg")?,
            axial: need(t.axial, "axial_N_per_m")?,
            lateral: t.lateral,
            rocking: t.rocking,
            gyration: match t.rocking {
                Some(_) => 1e-3 * need(t.gyration_mm, "gyration_mm")?,
                None => 0.0,
            },
        }),
    };
    support
        .check()
        .map_err(|fault| source.refuse("", "support", fault.to_string()))?;
    Ok(support)
}
