//! From a request to an outcome: meshes, modes, uncertainty, transfer.

use super::outcome::{BodyMesh, LineOutcome, ModesOutcome};
use super::{Body, MeshedBody, ModesData, ModesJob, trouble};
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_fixture::{
    Convergence, Design, Face, Fineness, FiniteElementModel, Fixture, Level, Line, LineDirection,
    Material, Mesh, Modes, Support, TransferPoint, WedgeMesh, close_modes, converge,
    convergence_findings, frequency_estimate, lowest_faces, mass_and_centre, modes, refine, search,
    sensitivities, update,
};
use proofmass_io::GmshMesh;
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding, Influence,
    Severity,
};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;

/// A body that was solved.
struct Solved {
    fixture: Fixture,
    wedge: Option<WedgeMesh>,
    modes: Modes,
    levels: Vec<Level>,
    convergence: Vec<Convergence>,
    findings: Vec<Finding>,
    /// Mesh that is drawn and exported.
    coarse: Mesh,
}

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
    let (support, materials, accelerometer) = match &job.body {
        Body::Wedge(d) => (d.support, d.materials(), d.accelerometer),
        Body::Mesh(b) => (b.support, mesh_materials(b, data)?, b.accelerometer),
    };
    let solved = match &job.body {
        Body::Wedge(design) => wedge(job, design, watch)?,
        Body::Mesh(body) => meshed(job, body, &materials, data, watch)?,
    };
    let model = FiniteElementModel {
        fixture: &solved.fixture,
        materials: &materials,
        support: &support,
        accelerometer,
    };
    let sensitivities = sensitivities(&model, solved.wedge.as_ref(), &solved.modes, &job.causes)
        .map_err(trouble)?;
    let frequencies: Vec<f64> = solved.modes.modes.iter().map(|m| m.frequency).collect();
    let errors: Vec<f64> = solved.convergence.iter().map(|c| c.error).collect();
    let mut estimate = frequency_estimate(&frequencies, &sensitivities, &errors)?;
    let mut findings = solved.findings.clone();
    if solved.modes.effort.complete == Some(false) {
        findings.push(
            Finding::new(
                Severity::Decision,
                "mode-missed",
                "the count of modes by the signs of the factorisation disagrees with the modes found",
            )
            .evidence(format!("below {:.1} Hz", frequencies[frequencies.len() - 1]))
            .advice("ask for more modes"),
        );
    }
    findings.extend(close_modes(&estimate));
    let updated = if job.measured.is_empty() {
        None
    } else {
        let updated =
            update(&frequencies, &sensitivities, &errors, &job.measured).map_err(trouble)?;
        findings.extend(updated.findings.iter().cloned());
        estimate = estimate_of(&updated.frequencies, &updated.covariance)?;
        Some(updated)
    };
    let free = matches!(support, Support::Free);
    let n = frequencies.len();
    let mut relative = vec![0.0; n * n];
    for p in 0..n {
        for q in 0..n {
            relative[p * n + q] = estimate.covariance()[(p, q)] / (frequencies[p] * frequencies[q]);
        }
    }
    // Resonances where they were measured, not where the model has them.
    let mut driven = solved.modes.clone();
    if let Some(updated) = &updated {
        driven.set_frequencies(&updated.frequencies);
    }
    let last = frequencies[n - 1];
    let (transfer, plotted, usable) = if free {
        (vec![], vec![], None)
    } else {
        let list = if job.frequencies.is_empty() {
            thirds(10.0, 0.9 * last)
        } else {
            job.frequencies.clone()
        };
        (
            driven.transfer_table(job.damping, &list, Some(&relative)),
            plot_points(&driven, job, last),
            driven.usable_frequency(job.damping.ratio, job.share),
        )
    };
    if let Some(beyond) = transfer.iter().map(|t| t.frequency).find(|f| *f > last) {
        findings.push(
            Finding::new(
                Severity::Decision,
                "beyond-the-last-mode",
                format!("the transfer at {beyond} Hz lies beyond the last mode calculated"),
            )
            .evidence(format!("last mode {last:.0} Hz"))
            .advice("ask for more modes"),
        );
    }
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
    let (mass, centre) = mass_and_centre(&model);
    let places = nearest(solved.coarse.nodes(), solved.fixture.mesh.nodes());
    let body = BodyMesh::new(&solved.coarse, &solved.modes.shapes, &places);
    Ok(ModesOutcome {
        probability: job.probability,
        weight: job.weight,
        share: job.share,
        damping: job.damping,
        free,
        inclination: solved.fixture.inclination(),
        description: description(job, &materials, &solved, mass, centre),
        lines: lines(job, &solved)?,
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
        body,
        search: job.search.clone().zip(found),
        findings,
    })
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
    let refined = refine(design, job.count, &job.refine, &mut |meshes, found| {
        goes_on(
            watch,
            "modes",
            (meshes * job.count + found).min(4 * job.count),
            4 * job.count,
        )
    })
    .map_err(trouble)?;
    let size = job.refine.size.unwrap_or_else(|| design.coarse_size());
    let coarse = WedgeMesh::new(&design.wedge, Fineness { size, parts: 1 }).map_err(trouble)?;
    Ok(Solved {
        fixture: refined.mesh.fixture.clone(),
        wedge: Some(refined.mesh),
        modes: refined.modes,
        levels: refined.levels,
        convergence: refined.convergence,
        findings: refined.findings,
        coarse: coarse.fixture.mesh,
    })
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
            "a scale of {} is impossible",
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
    let given = Fixture::new(mesh, base, body.point, body.footprint).map_err(trouble)?;
    let unknowns = 8 * 3 * given.mesh.nodes().len();
    if unknowns > job.refine.limit {
        return Err(Trouble::request(format!(
            "the mesh cut once to show its error has some {unknowns} unknowns, {} are allowed",
            job.refine.limit
        ))
        .with_hint("raise `unknowns` in [modes], or give a mesh with longer edges: it is cut into eight for the second level"));
    }
    let mut levels = vec![];
    let mut solve = |fixture: &Fixture, size: f64| -> Result<Modes> {
        let model = FiniteElementModel {
            fixture,
            materials,
            support: &body.support,
            accelerometer: body.accelerometer,
        };
        let before = levels.len() * job.count;
        let found = modes(&model, job.count, &mut |found, _| {
            goes_on(watch, "modes", before + found, 2 * job.count)
        })
        .map_err(trouble)?;
        levels.push(Level {
            size,
            elements: found.effort.elements,
            unknowns: found.effort.unknowns,
            frequencies: found.modes.iter().map(|m| m.frequency).collect(),
        });
        Ok(found)
    };
    solve(&given, 1.0)?;
    let fixture = given.split().map_err(trouble)?;
    let modes = solve(&fixture, 0.5)?;
    let convergence = converge(&levels);
    let findings = convergence_findings(&convergence, job.refine.accuracy, &levels);
    Ok(Solved {
        coarse: given.mesh,
        fixture,
        wedge: None,
        modes,
        levels,
        convergence,
        findings,
    })
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
    let key = |x: &[f64; 3]| x.map(f64::to_bits);
    let wanted: BTreeSet<[[u64; 3]; 3]> = file
        .triangles
        .iter()
        .filter(|t| named(t.1))
        .map(|t| {
            let mut corners = t.0.map(|n| key(&nodes[n as usize]));
            corners.sort_unstable();
            corners
        })
        .collect();
    if wanted.is_empty() {
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
    let faces: Vec<Face> = mesh
        .boundary()
        .into_iter()
        .filter(|face| {
            let mut corners = [face[0], face[1], face[2]].map(|n| key(&mesh.nodes()[n as usize]));
            corners.sort_unstable();
            wanted.contains(&corners)
        })
        .collect();
    if faces.len() != wanted.len() {
        return Err(Trouble::data(format!(
            "{} of {} triangles of `{name}` are no faces of the volume",
            wanted.len() - faces.len(),
            wanted.len()
        ))
        .with_hint("export surface and volume from the same mesh"));
    }
    Ok(faces)
}

/// Frequencies after an update with their joint covariance.
fn estimate_of(frequencies: &[f64], covariance: &[f64]) -> Result<Estimate> {
    let components = frequencies
        .iter()
        .enumerate()
        .map(|(m, &f)| Component::new(format!("mode-{}.frequency", m + 1), "Hz", f))
        .collect();
    let influence = Influence {
        key: "model and measured resonances".into(),
        description: "what is left of the model's uncertainty after the measured resonances".into(),
        evaluation: Evaluation::B,
        distribution: "normal".into(),
        dof: DegreesOfFreedom::INFINITE,
        effect: Effect::Joint {
            covariance: Covariance::try_from_rows(frequencies.len(), covariance)?,
        },
    };
    Ok(Estimate::new(components, vec![influence])?)
}

/// Thirds of an octave as they are named, [IEC61260] base ten.
fn thirds(low: f64, high: f64) -> Vec<f64> {
    const NAMES: [f64; 10] = [1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0];
    let mut list = vec![];
    for decade in -1..7 {
        for name in NAMES {
            // Written as a person would: 31.5, not 31.500000000000004.
            let f = (name * 10f64.powi(decade) * 1e4).round() / 1e4;
            if f >= low && f <= high {
                list.push(f);
            }
        }
    }
    if list.is_empty() {
        list.push(high);
    }
    list
}

/// Points dense enough for a plot: a grid, and around each resonance by its width.
fn plot_points(modes: &Modes, job: &ModesJob, last: f64) -> Vec<TransferPoint> {
    let first = 0.01 * modes.modes[0].frequency;
    let steps = 160;
    let mut list: Vec<f64> = (0..=steps)
        .map(|k| first * (last / first).powf(f64::from(k) / f64::from(steps)))
        .collect();
    for mode in &modes.modes {
        for k in -6i32..=6 {
            let offset = f64::from(k) * f64::from(k.abs()) / 6.0;
            list.push(mode.frequency * (1.0 + 2.0 * job.damping.ratio * offset));
        }
    }
    list.retain(|f| *f > 0.0 && *f <= last);
    list.sort_by(f64::total_cmp);
    modes.transfer_table(
        proofmass_fixture::Damping {
            u: 0.0,
            ..job.damping
        },
        &list,
        None,
    )
}

fn lines(job: &ModesJob, solved: &Solved) -> Result<Vec<LineOutcome>> {
    let directions = [
        (
            LineDirection::Slope,
            "Up the slope, from the low edge of the face",
        ),
        (LineDirection::Across, "Across the face"),
    ];
    let mut result = vec![];
    for (direction, name) in directions {
        let line = Line::new(&solved.fixture, direction).map_err(trouble)?;
        let every = (line.distance.len() / 60).max(1);
        let size = |u: &[f64; 3]| u.iter().map(|c| c * c).sum::<f64>().sqrt();
        let (mut shape, mut response) = (vec![], vec![]);
        for (mode, nodes) in solved.modes.modes.iter().zip(&solved.modes.shapes) {
            let along = line.displacement(&solved.fixture.mesh, nodes);
            let largest = nodes.iter().map(size).fold(f64::MIN_POSITIVE, f64::max);
            let omega = std::f64::consts::TAU * mode.frequency;
            let drive = mode.participation[2].abs() / (2.0 * job.damping.ratio * omega * omega);
            let thin = || along.iter().step_by(every).map(size);
            shape.push(thin().map(|u| round(u / largest, 5)).collect());
            response.push(thin().map(|u| u * drive).collect());
        }
        result.push(LineOutcome {
            name: name.into(),
            distance: line.distance.iter().step_by(every).copied().collect(),
            gluing: line.gluing,
            shape,
            response,
        });
    }
    Ok(result)
}

/// To so many decimals: what a picture shows, and short in a file.
pub(super) fn round(value: f64, decimals: i32) -> f64 {
    let unit = 10f64.powi(decimals);
    (value * unit).round() / unit + 0.0
}

/// For each of `few`, the nearest of `many`.
fn nearest(few: &[[f64; 3]], many: &[[f64; 3]]) -> Vec<usize> {
    few.iter()
        .map(|x| {
            let distance = |y: &[f64; 3]| -> f64 { (0..3).map(|c| (x[c] - y[c]).powi(2)).sum() };
            many.iter()
                .enumerate()
                .map(|(i, y)| (i, distance(y)))
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .map_or(0, |p| p.0)
        })
        .collect()
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
    let (support, accelerometer) = match &job.body {
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
            say(
                "footprint of the accelerometer",
                format!("{} × {}", mm(w.footprint[0]), mm(w.footprint[1])),
            );
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
            (design.support, design.accelerometer)
        }
        Body::Mesh(body) => {
            say("shape", "from a mesh".into());
            (body.support, body.accelerometer)
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
