//! Campaigns on the shaker through the binary.

mod support;

use std::path::{Path, PathBuf};
use support::{json, quantity, succeed, text};

fn example() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/published-triaxial")
}

/// Rows of a CSV file as (heading, field) pairs.
fn rows(path: &Path) -> Vec<Vec<(String, String)>> {
    let text = std::fs::read_to_string(path).expect("a table");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    lines
        .map(|l| {
            let fields = l.split(',').map(str::to_owned);
            header.iter().map(|h| (*h).to_owned()).zip(fields).collect()
        })
        .collect()
}

fn field<'a>(row: &'a [(String, String)], heading: &str) -> &'a str {
    row.iter()
        .find(|(h, _)| h == heading)
        .map_or_else(|| panic!("no {heading}"), |(_, f)| f.as_str())
}

fn number(row: &[(String, String)], heading: &str) -> f64 {
    field(row, heading).parse().expect("a number")
}

/// Rows of the uncorrected case of the printed matrices.
fn printed() -> Vec<Vec<(String, String)>> {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../reference/inrim-pcb356a15/matrices.csv");
    let mut all = rows(&path);
    all.retain(|r| field(r, "correction") == "uncorrected");
    all
}

#[test]
fn published_example_returns_the_printed_matrices() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("result");
    succeed(&["calibrate", text(&example()), "--output", text(&out)]);
    let sensitivity = rows(&out.join("sensitivity.csv"));
    let exploitation = rows(&out.join("exploitation.csv"));
    let at = |table: &[Vec<(String, String)>], method: &str, f: f64, term: &str| {
        table
            .iter()
            .find(|r| {
                field(r, "method") == method
                    && number(r, "frequency_Hz") == f
                    && field(r, "term") == term
            })
            .cloned()
            .unwrap_or_else(|| panic!("no {method} {f} {term}"))
    };
    let printed = printed();
    assert_eq!(printed.len(), 45);
    for row in &printed {
        let (f, term) = (number(row, "f_Hz"), field(row, "element"));
        let s = 1e-3 * number(row, "S_mV/(m/s2)");
        // runs.csv has nine digits; the signed methods lose none of them.
        for method in ["joint", "complex"] {
            let got = at(&sensitivity, method, f, term);
            assert!(
                (number(&got, "real_V/(m/s2)") - s).abs() < 1e-9 * 0.01,
                "{method} {f} {term}"
            );
            assert!(number(&got, "imaginary_V/(m/s2)").abs() < 1e-11);
        }
        if term.as_bytes()[0] != term.as_bytes()[1] {
            continue;
        }
        // U printed to 0.01 of about 2 (0.25 %) and of 0.2 (2.5 %). Relative to the term, because signed phasors
        // taken as magnitudes move the terms themselves by up to 1 %.
        let a = at(&exploitation, "published", f, term);
        let ratio = number(&a, "U_modulus_(m/s2)/V")
            / number(&a, "modulus_(m/s2)/V")
            / (number(row, "U_A_(m/s2)/V") / number(row, "A_(m/s2)/V"));
        assert!(
            (ratio - 1.0).abs() < 0.015,
            "U(A_{term}) at {f} Hz: {ratio}"
        );
        let got = at(&sensitivity, "published", f, term);
        let expanded = 1e3 * number(&got, "U_modulus_V/(m/s2)");
        assert!(
            (expanded - number(row, "U_S_mV/(m/s2)")).abs() < 0.0055,
            "U(S_{term}) at {f} Hz: {expanded}"
        );
    }
    // Common errors do not average: U of the main terms stays above the 0.4 % of the certificate.
    let result = json(&out.join("result.json"));
    for f in [5, 10, 20, 40, 315] {
        let (s, u, expanded) = quantity(&result, &format!("S.xx.modulus[frequency={f}]"));
        assert!(
            u / s > 0.002 && (0.004..0.0055).contains(&(expanded / s)),
            "{f} Hz"
        );
    }
    assert_eq!(result["kind"], "shaker-triaxial");
    assert_eq!(
        result["extra"]["monte_carlo"].as_array().map(Vec::len),
        Some(5)
    );
    let findings = result["findings"].as_array().expect("findings");
    assert!(
        findings.iter().all(|f| f["severity"] == "note"),
        "{findings:?}"
    );
    // Phasors read back as a table of runs.
    let phasors = rows(&out.join("phasors.csv"));
    assert_eq!(phasors.len(), 220);
}
