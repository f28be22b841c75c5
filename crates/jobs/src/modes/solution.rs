//! From a request to an outcome: meshes, modes, uncertainty, transfer.

use super::outcome::{BelowDevice, LayerEnd, ModesOutcome};
use super::{Body, MeshedBody, ModesData, ModesJob, trouble};
use crate::findings;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_documents::GmshMesh;
use proofmass_fixture::{
    BodyMesh, Design, Device, Face, FiniteElementModel, Fixture, JointStiffness, Layer,
    LayerModulus, LineDirection, LineMotion, Material, Mesh, Observed, Solved, Support,
    close_modes, frequency_estimate, layer_range, lowest_faces, mass_and_centre, modes,
    relative_covariance, round, search, sensitivities, thirds_of_octave, update,
};
use proofmass_report::scientific;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;

/// Lines on the face of the gluing point.
const LINES: [(LineDirection, &str); 2] = [
    (
        LineDirection::Slope,
        "Up the slope, from the low edge of the face",
    ),
    (LineDirection::Across, "Across the face"),
];

fn goes_on(watch: &dyn Watch, stage: &'static str, done: usize, of: usize) -> bool {
    watch.progress(stage, done as u64, of as u64) == ControlFlow::Continue(())
}

pub(super) fn solve(
    job: &ModesJob,
    data: &ModesData<'_>,
    watch: &dyn Watch,
) -> Result<ModesOutcome> {
    let found = match (&job.search, &job.body) {
        (Some(wanted), Body::Wedge(design)) => Some(
            search(design, wanted, &mut |done, of| {
                goes_on(watch, "search", done, of)
            })
            .map_err(trouble)?,
        ),
        (Some(_), Body::Mesh(_)) => {
            return Err(Trouble::request("a mesh has no dimensions to search over")
                .with_hint("give the wedge by its dimensions, in [wedge]"));
        }
        (None, _) => None,
    };
    if found.is_some() {
        watch.step("search", 1, 1)?;
    }
    let (support, materials, accelerometer, device) = match &job.body {
        Body::Wedge(d) => (d.support, d.materials(), d.accelerometer, &d.device),
        Body::Mesh(b) => (
            b.support,
            mesh_materials(b, data)?,
            b.accelerometer,
            &b.device,
        ),
    };
    let solved = match &job.body {
        Body::Wedge(design) => wedge(job, design, watch)?,
        Body::Mesh(body) => meshed(job, body, &materials, data, watch)?,
    };
    watch.step("modes", 1, 1)?;
    let model = FiniteElementModel {
        fixture: &solved.fixture,
        materials: &materials,
        support: &support,
        accelerometer,
    };
    let mut sensitivities =
        sensitivities(&model, solved.wedge.as_ref(), &solved.modes, &job.causes)
            .map_err(trouble)?;
    let frequencies: Vec<f64> = solved.modes.modes.iter().map(|m| m.frequency).collect();
    let bounds = device.as_ref().and_then(|d| d.bounds);
    let ends = match bounds {
        Some(bounds) => Some(layer_ends(job, &model, bounds, watch)?),
        None => None,
    };
    if let Some([soft, stiff]) = &ends {
        sensitivities.push(layer_range(
            &frequencies,
            [&soft.frequencies, &stiff.frequencies],
        ));
    }
    let errors: Vec<f64> = solved.convergence.iter().map(|c| c.error).collect();
    let mut estimate = frequency_estimate(&frequencies, &sensitivities, &errors)?;
    let mut findings = solved.findings.clone();
    findings.extend(device.iter().flat_map(Device::layer_findings));
    if solved.modes.effort.complete == Some(false) {
        findings.push(findings::modes_missing(
            "the count by the signs of the factorisation disagrees with the modes found",
            &format!("below {:.1} Hz", frequencies[frequencies.len() - 1]),
        ));
    }
    findings.extend(close_modes(&estimate));
    let updated = if job.measured.is_empty() {
        None
    } else {
        let updated =
            update(&frequencies, &sensitivities, &errors, &job.measured).map_err(trouble)?;
        findings.extend(updated.findings.iter().cloned());
        estimate = updated.estimate()?;
        Some(updated)
    };
    let free = matches!(support, Support::Free);
    let relative = relative_covariance(&estimate, &frequencies);
    // Resonances where they were measured, not where the model has them.
    let mut driven = solved.modes.clone();
    let mut gluing = driven.at_gluing_point();
    if let Some(updated) = &updated {
        driven.set_frequencies(&updated.frequencies);
        if let Some(gluing) = &mut gluing {
            gluing.set_frequencies(&updated.frequencies);
        }
    }
    let last = frequencies[frequencies.len() - 1];
    let (transfer, plotted, usable, below) = if free {
        (vec![], vec![], None, None)
    } else {
        let list = if job.frequencies.is_empty() {
            thirds_of_octave(10.0, 0.9 * last)
        } else {
            job.frequencies.clone()
        };
        (
            driven.transfer_table(job.damping, &list, Some(&relative)),
            driven.plotted_transfer(job.damping, last),
            driven.usable_frequency(job.damping.ratio, job.share),
            gluing.map(|gluing| BelowDevice {
                transfer: gluing.transfer_table(job.damping, &list, Some(&relative)),
                plotted: gluing.plotted_transfer(job.damping, last),
                usable: gluing.usable_frequency(job.damping.ratio, job.share),
            }),
        )
    };
    if let Some(beyond) = transfer.iter().map(|t| t.frequency).find(|f| *f > last) {
        findings.push(findings::modes_missing(
            &format!("the transfer at {beyond} Hz lies beyond the last one calculated"),
            &format!("last mode {last:.0} Hz"),
        ));
    }
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
    let (mass, centre) = mass_and_centre(&model);
    let body = BodyMesh::new(&solved.coarse, &solved.fixture.mesh, &solved.modes.shapes);
    let line = |(direction, name)| {
        let (fixture, modes) = (&solved.fixture, &solved.modes);
        LineMotion::new(name, direction, fixture, modes, job.damping.ratio).map_err(trouble)
    };
    let lines = LINES.into_iter().map(line).collect::<Result<_>>()?;
    Ok(ModesOutcome {
        probability: job.probability,
        weight: job.weight,
        share: job.share,
        damping: job.damping,
        free,
        inclination: solved.fixture.inclination(),
        description: description(job, &materials, &solved, mass, centre),
        lines,
        modes: solved.modes.modes.clone(),
        effort: solved.modes.effort,
        levels: solved.levels,
        convergence: solved.convergence,
        mass,
        centre,
        estimate,
        sensitivities,
        update: updated,
        transfer,
        plotted,
        usable,
        below,
        ends,
        body,
        search: job.search.clone().zip(found),
        beside: None,
        findings,
    })
}

/// The same mesh with the softest and the stiffest layer.
fn layer_ends(
    job: &ModesJob,
    model: &FiniteElementModel<'_>,
    bounds: [JointStiffness; 2],
    watch: &dyn Watch,
) -> Result<[LayerEnd; 2]> {
    let mut fixture = model.fixture.clone();
    let mut end = |stiffness: JointStiffness| -> Result<LayerEnd> {
        if let Some(glued) = &mut fixture.glued {
            glued.stiffness = Some(stiffness);
        }
        let model = FiniteElementModel {
            fixture: &fixture,
            ..*model
        };
        let found = modes(&model, job.count, &mut |done, of| {
            goes_on(watch, "layer", done, of)
        })
        .map_err(trouble)?;
        let free = matches!(model.support, Support::Free);
        let last = found.modes.last().map_or(0.0, |m| m.frequency);
        Ok(LayerEnd {
            stiffness,
            frequencies: found.modes.iter().map(|m| m.frequency).collect(),
            usable: match free {
                true => None,
                false => found.usable_frequency(job.damping.ratio, job.share),
            },
            plotted: match free {
                true => vec![],
                false => found.plotted_transfer(job.damping, last),
            },
        })
    };
    let ends = [end(bounds[0])?, end(bounds[1])?];
    watch.step("layer", 1, 1)?;
    Ok(ends)
}

fn wedge(job: &ModesJob, design: &Design, watch: &dyn Watch) -> Result<Solved> {
    // Sorted by cause before anything long begins.
    for cause in &job.causes {
        if let proofmass_fixture::Parameter::Dimension(d) = cause.parameter
            && design.wedge.get(d).is_none()
        {
            return Err(Trouble::request(format!(
                "`{}` has an uncertainty, but the wedge has no such part",
                d.name()
            )));
        }
    }
    Solved::of_wedge(design, job.count, &job.refine, &mut |done, of| {
        goes_on(watch, "modes", done, of)
    })
    .map_err(trouble)
}

fn read<'a>(data: &ModesData<'a>) -> Result<&'a GmshMesh> {
    match data.mesh {
        Some(mesh) => Ok(mesh),
        None => Err(Trouble::request("the body is a mesh, but none is given")),
    }
}

/// Names of the regions of a mesh, in the order of their first element.
fn regions(mesh: &GmshMesh) -> (Vec<String>, BTreeMap<usize, u16>) {
    let groups = mesh
        .tetrahedra
        .iter()
        .map(|e| e.1)
        .chain(mesh.quadratic_tetrahedra.iter().map(|e| e.1));
    let (mut names, mut of) = (vec![], BTreeMap::new());
    for group in groups {
        of.entry(group).or_insert_with(|| {
            names.push(mesh.groups[group].clone());
            (names.len() - 1) as u16
        });
    }
    (names, of)
}

fn mesh_materials(body: &MeshedBody, data: &ModesData<'_>) -> Result<Vec<Material>> {
    let (names, _) = regions(read(data)?);
    if let Some(name) = body.materials.keys().find(|name| !names.contains(name)) {
        return Err(Trouble::request(format!(
            "a material is given for `{name}`, but the mesh has no such region"
        ))
        .with_hint(format!("its regions: {}", names.join(", "))));
    }
    Ok(names
        .iter()
        .map(|name| body.materials.get(name).unwrap_or(&body.material).clone())
        .chain(body.device.as_ref().map(|d| d.material.clone()))
        .collect())
}

fn meshed(
    job: &ModesJob,
    body: &MeshedBody,
    materials: &[Material],
    data: &ModesData<'_>,
    watch: &dyn Watch,
) -> Result<Solved> {
    let file = read(data)?;
    if !(body.scale.is_finite() && body.scale > 0.0) {
        return Err(Trouble::request(format!(
            "a scale of {} is out of range: it must be positive",
            body.scale
        )));
    }
    let (names, of) = regions(file);
    let nodes: Vec<[f64; 3]> = file
        .nodes
        .iter()
        .map(|x| x.map(|c| c * body.scale))
        .collect();
    let region = |group: &usize| of.get(group).copied().unwrap_or(0);
    let mesh = match (
        file.tetrahedra.is_empty(),
        file.quadratic_tetrahedra.is_empty(),
    ) {
        (false, false) => {
            return Err(
                Trouble::data("the mesh mixes tetrahedra of first and second order")
                    .with_hint("set one order for all: Mesh.ElementOrder = 2"),
            );
        }
        (true, _) => Mesh::new(
            nodes.clone(),
            file.quadratic_tetrahedra.iter().map(|e| e.0).collect(),
            file.quadratic_tetrahedra
                .iter()
                .map(|e| region(&e.1))
                .collect(),
            names,
        ),
        (false, true) => {
            let corners: Vec<[u32; 4]> = file.tetrahedra.iter().map(|e| e.0).collect();
            let regions = file.tetrahedra.iter().map(|e| region(&e.1)).collect();
            Mesh::from_corners(nodes.clone(), &corners, regions, names)
        }
    }
    .map_err(trouble)?;
    let base = if matches!(body.support, Support::Free) {
        vec![]
    } else {
        base_faces(body, file, &nodes, &mesh)?
    };
    let mut given = Fixture::new(mesh, base, body.point, body.footprint).map_err(trouble)?;
    if let Some(device) = &body.device {
        // As fine as the faces that it stands on.
        let layers = (device.size[2] / given.seat_step()).round().min(1e3) as usize;
        given = given.glue(device, layers).map_err(trouble)?;
    }
    let unknowns = 8 * 3 * given.mesh.nodes().len();
    if unknowns > job.refine.limit {
        return Err(Trouble::request(format!(
            "the mesh cut once to show its error has some {unknowns} unknowns, {} are allowed",
            job.refine.limit
        ))
        .with_hint("raise `unknowns` in [modes], or give a mesh with longer edges: it is cut into eight for the second level"));
    }
    let held = (materials, &body.support, body.accelerometer);
    let accuracy = job.refine.accuracy;
    Solved::of_mesh(given, held, job.count, accuracy, &mut |done, of| {
        goes_on(watch, "modes", done, of)
    })
    .map_err(trouble)
}

/// Faces of the base: those of the named group, found on the mesh by where they lie.
fn base_faces(
    body: &MeshedBody,
    file: &GmshMesh,
    nodes: &[[f64; 3]],
    mesh: &Mesh,
) -> Result<Vec<Face>> {
    let Some(name) = &body.base else {
        return lowest_faces(mesh).map_err(trouble);
    };
    let named = |group: usize| file.groups[group] == *name;
    let triangles = file.triangles.iter().filter(|t| named(t.1));
    let (faces, wanted) = mesh.faces_at(triangles.map(|t| t.0.map(|n| nodes[n as usize])));
    if wanted == 0 {
        let groups: BTreeSet<&str> = file
            .triangles
            .iter()
            .map(|t| file.groups[t.1].as_str())
            .collect();
        let groups: Vec<&str> = groups.into_iter().collect();
        return Err(
            Trouble::request(format!("the mesh has no group of triangles `{name}`"))
                .with_hint(format!("its groups of triangles: {}", groups.join(", "))),
        );
    }
    if faces.len() != wanted {
        return Err(Trouble::data(format!(
            "{} of {} triangles of `{name}` are no faces of the volume",
            wanted - faces.len(),
            wanted
        ))
        .with_hint("export surface and volume from the same mesh"));
    }
    Ok(faces)
}

/// Label and value of the model.
fn description(
    job: &ModesJob,
    materials: &[Material],
    solved: &Solved,
    mass: f64,
    centre: [f64; 3],
) -> Vec<(String, String)> {
    let mm = |v: f64| format!("{} mm", round(1e3 * v, 3));
    let mut list: Vec<(String, String)> = vec![];
    let mut say = |label: &str, value: String| list.push((label.to_owned(), value));
    let degrees = round(solved.fixture.inclination().to_degrees(), 3);
    say("inclination", format!("{degrees}°"));
    let (support, accelerometer, device) = match &job.body {
        Body::Wedge(design) => {
            let w = &design.wedge;
            say(
                "length × width",
                format!("{} × {}", mm(w.length), mm(w.width)),
            );
            say(
                "height of low and high end",
                format!("{} and {}", mm(w.toe), mm(w.surface(0.5 * w.length))),
            );
            say("gluing point along the base, from the axis", mm(w.gluing));
            if design.device.is_none() {
                say(
                    "footprint of the accelerometer",
                    format!("{} × {}", mm(w.footprint[0]), mm(w.footprint[1])),
                );
            }
            if let Some(foot) = &w.foot {
                say(
                    "foot",
                    format!(
                        "{} thick, {} beyond the body",
                        mm(foot.thickness),
                        mm(foot.overhang)
                    ),
                );
            }
            if let Some(s) = &w.sides {
                say(
                    "side masses",
                    format!(
                        "{} thick, from {} to {}, {} above the slope, joined over {} % of the height",
                        mm(s.thickness),
                        mm(s.from),
                        mm(s.to),
                        mm(s.rise),
                        round(1e2 * s.depth, 1)
                    ),
                );
            }
            if let Some(bore) = &w.bore {
                say(
                    "bore",
                    format!("{} wide, {} deep", mm(bore.diameter), mm(bore.depth)),
                );
            }
            (design.support, design.accelerometer, &design.device)
        }
        Body::Mesh(body) => {
            say("shape", "from a mesh".into());
            (body.support, body.accelerometer, &body.device)
        }
    };
    for (name, m) in solved.fixture.mesh.region_names().iter().zip(materials) {
        say(
            &format!("material of `{name}`"),
            format!(
                "{}: E = {} GPa, ν = {}, ρ = {} kg/m³",
                m.name,
                round(1e-9 * m.young, 3),
                m.poisson,
                m.density
            ),
        );
    }
    say(
        "base",
        match support {
            Support::Clamped => "clamped all over".into(),
            Support::Elastic { normal, tangential } => format!(
                "on springs, {} N/µm along z, {} N/µm along x and y",
                round(1e-6 * normal, 3),
                round(1e-6 * tangential, 3)
            ),
            Support::Table(t) => {
                let other = |what: &str, k: Option<f64>, unit: &str| match k {
                    Some(k) => format!(", {what} {k} {unit}"),
                    None => format!(", {what} guided"),
                };
                format!(
                    "on a rigid table of {} kg, axial stiffness {} N/m{}{}",
                    t.mass,
                    t.axial,
                    other("lateral", t.lateral, "N/m"),
                    other("rocking", t.rocking, "N m/rad")
                )
            }
            Support::Free => "free".into(),
            _ => "other".into(),
        },
    );
    if let Some(a) = accelerometer {
        say(
            "accelerometer",
            format!(
                "{} g, its centre {} above the face",
                round(1e3 * a.mass, 3),
                mm(a.height)
            ),
        );
    }
    if let Some(device) = device {
        let [a, b, h] = device.size.map(mm);
        say(
            "device",
            format!(
                "{a} up the slope, {b} across, {h} high, {} g, its motion taken at {}",
                round(1e3 * device.mass(), 3),
                match device.observed {
                    Observed::Centre => "its centre",
                    Observed::Top => "its upper face",
                }
            ),
        );
        say("layer below it", layer_words(device));
    }
    say(
        "mass, accelerometer included",
        format!("{} g", round(1e3 * mass, 1)),
    );
    let point = solved.fixture.seat.point;
    let offset = (0..3)
        .map(|a| (centre[a] - point[a]).powi(2))
        .sum::<f64>()
        .sqrt();
    say("centre of mass from the gluing point", mm(offset));
    list
}

fn layer_words(device: &Device) -> String {
    let Some(layer) = &device.layer else {
        return "none, it is one with the fixture".into();
    };
    let over_area = |k: &JointStiffness| {
        format!(
            "{} N/m³ along the normal and {} N/m³ along the face",
            scientific(k.normal, 3),
            scientific(k.tangential, 3)
        )
    };
    let mut words = match layer {
        Layer::Adhesive {
            thickness,
            young,
            poisson,
            modulus,
        } => format!(
            "{} mm of E = {} GPa, ν = {poisson}, {} modulus: ",
            round(1e3 * thickness, 4),
            round(1e-9 * young, 4),
            match modulus {
                LayerModulus::Constrained => "constrained",
                LayerModulus::Free => "free",
            }
        ),
        Layer::Contact(_) => String::new(),
    };
    words.push_str(&over_area(&layer.stiffness()));
    if let Some([soft, stiff]) = &device.bounds {
        words.push_str(&format!(
            "; softest {}, stiffest {}",
            over_area(soft),
            over_area(stiff)
        ));
    }
    words
}
