//! The arrows of ARCHITECTURE.md: which crate may use which.

use std::collections::BTreeMap;
use std::process::Command;

/// Room and what it may use. `proofmass` (the façade) may use all, `proofmass-cli` the façade alone.
const ROOMS: [(&str, &[&str]); 17] = [
    ("core", &[]),
    ("uncertainty", &["core"]),
    ("signal", &["core", "uncertainty"]),
    ("noise", &["core", "uncertainty", "signal"]),
    ("static", &["core", "uncertainty"]),
    ("dynamic", &["core", "uncertainty", "signal"]),
    ("shaker", &["core", "uncertainty", "signal", "dynamic"]),
    ("motion", &["core", "uncertainty", "signal", "noise"]),
    (
        "odometry",
        &["core", "uncertainty", "signal", "noise", "motion"],
    ),
    ("rig", &["core", "signal"]),
    ("fixture", &["core", "uncertainty"]),
    ("formats", &["core"]),
    ("io", &["core", "uncertainty", "signal", "formats"]),
    ("documents", &["core", "uncertainty", "signal", "io"]),
    ("report", &["core", "uncertainty"]),
    (
        "jobs",
        &[
            "core",
            "uncertainty",
            "signal",
            "noise",
            "static",
            "dynamic",
            "shaker",
            "motion",
            "odometry",
            "rig",
            "fixture",
            "formats",
            "io",
            "documents",
            "report",
        ],
    ),
    (
        "records",
        &[
            "core",
            "uncertainty",
            "dynamic",
            "static",
            "io",
            "documents",
            "report",
            "jobs",
        ],
    ),
];

/// Ordinary dependencies within the workspace, by short name.
fn dependencies() -> BTreeMap<String, Vec<String>> {
    let output = Command::new(env!("CARGO"))
        .args([
            "metadata",
            "--format-version",
            "1",
            "--no-deps",
            "--offline",
        ])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs");
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("metadata");
    let short = |name: &str| name.trim_start_matches("proofmass-").to_owned();
    let packages = metadata["packages"].as_array().expect("packages");
    let ours = packages.iter().map(|package| {
        let name = short(package["name"].as_str().expect("name"));
        let uses = package["dependencies"]
            .as_array()
            .expect("dependencies")
            .iter();
        let uses = uses
            .filter(|d| d["kind"].is_null())
            .filter_map(|d| d["name"].as_str())
            .filter(|d| d.starts_with("proofmass"))
            .map(short);
        (name, uses.collect())
    });
    ours.collect()
}

#[test]
fn law_arrows_point_down_only() {
    let dependencies = dependencies();
    for (room, allowed) in ROOMS {
        let uses = dependencies
            .get(room)
            .unwrap_or_else(|| panic!("no crate {room}"));
        for used in uses {
            assert!(
                allowed.contains(&used.as_str()),
                "{room} must not use {used}"
            );
        }
    }
    assert_eq!(
        dependencies["cli"],
        ["proofmass"],
        "the command line uses the façade alone"
    );
}

/// Lines of code, without those of tests, of a room, each with its file.
fn lines(room: &str) -> Vec<(String, String)> {
    let mut all = vec![];
    let mut folders = vec![format!("{}/../{room}/src", env!("CARGO_MANIFEST_DIR"))];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("folder") {
            let path = entry.expect("entry").path();
            if path.is_dir() {
                folders.push(path.display().to_string());
                continue;
            }
            if path.file_stem().is_some_and(|name| name == "tests") {
                continue;
            }
            let text = std::fs::read_to_string(&path).expect("source");
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            let lines = code.lines().filter(|l| !l.trim_start().starts_with("//"));
            all.extend(lines.map(|line| (path.display().to_string(), line.to_owned())));
        }
    }
    all
}

/// Mathematics crates know no files, no terminal, no clock.
#[test]
fn law_mathematics_has_no_outside_world() {
    for room in [
        "core",
        "uncertainty",
        "signal",
        "noise",
        "static",
        "dynamic",
        "shaker",
        "motion",
        "odometry",
        "rig",
        "fixture",
        "formats",
    ] {
        for (path, line) in lines(room) {
            for word in [
                "println!(",
                "std::fs",
                "std::time",
                "std::net",
                "File::open",
            ] {
                assert!(!line.contains(word), "{path}: {line}");
            }
        }
    }
}

/// Factorisations of dense matrices are compiled in one room; called by faer's methods each crate compiles them anew.
#[test]
fn law_matrices_are_factorised_in_one_room() {
    for (room, _) in ROOMS {
        for (path, line) in lines(room) {
            if path.ends_with("algebra.rs") {
                continue;
            }
            for call in [
                ".llt(",
                ".self_adjoint_eigen",
                ".thin_svd(",
                ".partial_piv_lu(",
                ".qr()",
                "PartialPivLu",
            ] {
                assert!(
                    !line.contains(call),
                    "{path}: {line}: `uncertainty::algebra` has it"
                );
            }
        }
    }
}
