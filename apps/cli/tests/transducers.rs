//! `proofmass simulate transducer`: the command that it prints runs, whatever the principle and the motion.

use crate::support::{json, proofmass, quantity, stderr, succeed, text};
use std::path::Path;

const PRINCIPLES: [&str; 11] = [
    "capacitive",
    "piezoresistive",
    "strain-gauge",
    "piezoelectric",
    "inductive",
    "hall",
    "thermal",
    "resonant",
    "tunnelling",
    "shutter",
    "interferometer",
];

/// Runs what a simulation says comes next, into a folder.
fn run_next(said: &str, out: &Path) -> std::process::Output {
    let command = said
        .split_once("next: proofmass ")
        .unwrap_or_else(|| panic!("no command in {said}"))
        .1;
    let mut words: Vec<&str> = command.split_whitespace().collect();
    if !command.starts_with("inspect") {
        words.extend(["-o", text(out)]);
    }
    proofmass(&words)
}

#[test]
fn law_the_next_command_runs_for_every_principle_and_motion() {
    let folder = tempfile::tempdir().unwrap();
    let of = |motion: &str| {
        let mut failed = vec![];
        for principle in PRINCIPLES {
            let place = folder.path().join(format!("{principle}-{motion}"));
            let out = succeed(&[
                "simulate",
                "transducer",
                "--principle",
                principle,
                "--motion",
                motion,
                "-o",
                text(&place),
            ]);
            let done = run_next(&stderr(&out), &place.join("result"));
            if !done.status.success() {
                failed.push(format!("{principle} {motion}: {}", stderr(&done)));
            }
        }
        failed
    };
    let failed: Vec<String> = std::thread::scope(|scope| {
        let of = &of;
        let motions = ["shock", "random", "sweep", "step"];
        let runs = motions.map(|motion| scope.spawn(move || of(motion)));
        runs.into_iter()
            .flat_map(|run| run.join().unwrap())
            .collect()
    });
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

const PIEZO: &str = "
name = \"compression, two discs\"
[device]
principle = \"piezoelectric\"
cut = \"compression\"
mass_g = 5
charge_pC_per_N = 370
area_mm2 = 40
thickness_mm = 1
permittivity = 1800
modulus_GPa = 63
elements = 2
cable_pF = 300
leak_GOhm = 1
damping_ratio = 0.05
[uncertainty]
charge_pC_per_N = 4
cable_pF = 10
modulus_GPa = 2
";

/// What noise shows of a device is what its construction says, within both uncertainties.
#[test]
fn law_a_device_by_its_construction_is_found_again() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("device.toml");
    std::fs::write(&file, PIEZO).unwrap();
    let place = folder.path().join("bench");
    let out = succeed(&[
        "simulate",
        "transducer",
        "--construction",
        text(&file),
        "--motion",
        "random",
        "-o",
        text(&place),
    ]);
    let result = place.join("result");
    let done = run_next(&stderr(&out), &result);
    assert!(done.status.success(), "{}", stderr(&done));
    let result = json(&result.join("result.json"));
    let truth = json(&place.join("truth.json"));
    for (found, key) in [
        ("mode.1.frequency", "natural_frequency_hz"),
        ("mode.1.damping", "damping_ratio"),
        ("sensitivity", "sensitivity"),
    ] {
        let (value, u, _) = quantity(&result, found);
        let due = truth[key].as_f64().unwrap();
        assert!(
            (value - due).abs() < 4.0 * u + 2e-3 * due,
            "{found} {value} {u} {due}"
        );
    }
    let model = truth["model"].as_array().unwrap();
    assert_eq!(model.len(), 4);
    let s = &model[0];
    // 370(4) pC/N; 10 pF of 1.57 nF.
    let share = s["u"].as_f64().unwrap() / s["value"].as_f64().unwrap();
    assert!(
        (share - (4.0f64 / 370.0).hypot(10.0 / 1574.8)).abs() < 1e-4,
        "{share}"
    );
}
