//! A simulated campaign from its recordings to its results, held against its truth.

use crate::support::{json, refuse, succeed, text};
use std::collections::HashMap;
use std::path::Path;

/// Rows of a CSV file by heading.
fn rows(path: &Path) -> Vec<HashMap<String, String>> {
    let text = std::fs::read_to_string(path).expect("a table");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let row = |line: &str| {
        let fields = line.split(',').map(str::to_owned);
        header.iter().map(|h| (*h).to_owned()).zip(fields).collect()
    };
    lines.map(row).collect()
}

fn number(row: &HashMap<String, String>, heading: &str) -> f64 {
    let field = row.get(heading).unwrap_or_else(|| panic!("no {heading}"));
    field.parse().expect("a number")
}

fn simulated(folder: &Path, seed: &str, more: &[&str]) -> Vec<String> {
    let campaign = folder.join("campaign");
    let mut arguments = vec![
        "simulate",
        "shaker",
        "--output",
        text(&campaign),
        "--seed",
        seed,
    ];
    arguments.extend(more);
    succeed(&arguments);
    let out = campaign.join("result");
    succeed(&["calibrate", text(&campaign), "--output", text(&out)]);
    let findings = json(&out.join("result.json"))["findings"].clone();
    let list = findings.as_array().expect("findings").iter();
    list.map(|f| format!("{} {}", f["code"], f["what"]))
        .collect()
}

#[test]
fn coverage_of_the_truth_by_a_recorded_campaign() {
    let folder = tempfile::tempdir().expect("folder");
    let few = ["--frequencies", "80,160,800", "--configurations", "20"];
    simulated(
        folder.path(),
        "5",
        &[&few[..], &["--duration", "0.1"]].concat(),
    );
    let campaign = folder.path().join("campaign");
    let truth = json(&campaign.join("truth.json"));
    let (mut terms, mut inside) = (0, 0);
    for row in rows(&campaign.join("result/sensitivity.csv")) {
        if row["method"] != "joint" || row["correction"] != "vibrometer" {
            continue;
        }
        let f = number(&row, "frequency_Hz");
        let mut all = truth["frequencies"].as_array().expect("truth").iter();
        let at = all.find(|t| t["frequency_Hz"] == f).expect("the frequency");
        let place = |c: u8| (c - b'x') as usize;
        let term = row["term"].as_bytes();
        let s = &at["S_V_per_m_per_s2"][place(term[0])][place(term[1])];
        let part = |k: usize| s[k].as_f64().expect("a number");
        let error = number(&row, "modulus_V/(m/s2)") - part(0).hypot(part(1));
        terms += 1;
        inside += usize::from(error.abs() < number(&row, "U_modulus_V/(m/s2)"));
        // Four standard uncertainties: 6e-5 per term.
        assert!(
            error.abs() < 4.0 * number(&row, "u_modulus_V/(m/s2)"),
            "{row:?}: {error:e}"
        );
    }
    // 27 terms at 95 %: below 20 by chance in 2e-5 were they independent, and they are nearly so.
    assert!(terms == 27 && inside >= 20, "{inside} of {terms}");
}

#[test]
fn law_the_seed_alone_decides_and_faults_are_found() {
    let folder = tempfile::tempdir().expect("folder");
    let small = [
        "--phasors",
        "--frequencies",
        "80,160",
        "--configurations",
        "24",
    ];
    let once = |name: &str| {
        let place = folder.path().join(name);
        let head = ["simulate", "shaker", "--output", text(&place)];
        succeed(&[&head[..], &small].concat());
        std::fs::read(place.join("runs.csv")).expect("runs.csv")
    };
    assert_eq!(once("first"), once("second"));
    let faulty = folder.path().join("faulty");
    let fault = ["--fault", "swapped-cables:30"];
    let findings = simulated(&faulty, "5", &[&small[..], &fault].concat());
    assert!(
        findings.iter().any(|f| f.contains("run-30")),
        "{findings:?}"
    );
    let said = refuse(&[
        "simulate",
        "shaker",
        "--phasors",
        "--fault",
        "clipped",
        "--output",
        text(&folder.path().join("third")),
    ]);
    assert!(said.contains("recordings"), "{said}");
}

#[test]
fn regress_a_run_that_nothing_reconciles_is_in_neither_the_fit_nor_its_trials() {
    let folder = tempfile::tempdir().expect("folder");
    let place = folder.path().join("campaign");
    let small = ["--phasors", "--frequencies", "80,160"];
    let fault = ["--configurations", "24", "--fault", "swapped-cables:10"];
    let findings = simulated(&place, "1", &[&small[..], &fault].concat());
    assert!(
        findings.iter().any(|f| f.contains("runs-set-aside")),
        "{findings:?}"
    );
    // With the run, the residuals would exceed the budget and the trials could not tell the stated intervals apart.
    for grave in ["excess-residuals", "linear-result-not-validated"] {
        assert!(
            !findings.iter().any(|f| f.contains(grave)),
            "{grave}: {findings:?}"
        );
    }
}

#[test]
fn refuses_to_average_without_a_common_clock() {
    let folder = tempfile::tempdir().expect("folder");
    let campaign = folder.path().join("campaign");
    let head = ["simulate", "spurious-motion", "--output", text(&campaign)];
    let small = ["--frequencies", "160,630", "--no-common-clock"];
    succeed(&[&head[..], &small].concat());
    let out = folder.path().join("result");
    succeed(&["calibrate", text(&campaign), "--output", text(&out)]);
    let findings = json(&out.join("result.json"))["findings"].to_string();
    assert!(findings.contains("incoherent-repeats"), "{findings}");
}
