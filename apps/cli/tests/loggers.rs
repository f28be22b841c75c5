//! Files of loggers that were worn, calibrated by the command line alone.

mod support;
#[path = "../../../crates/jobs/examples/worn_logger.rs"]
mod worn_logger;

use std::fs::File;
use std::path::Path;
use support::*;
use worn_logger::{OFFSET, SCALE};

/// Twelve hours, at the lowest rates of the two loggers.
fn recorded(path: &Path) {
    let mut file = File::create(path).unwrap();
    match path.extension().and_then(|e| e.to_str()) {
        Some("cwa") => worn_logger::cwa(&mut file, 4500, 12.5).unwrap(),
        _ => worn_logger::gt3x(&mut file, 12 * 3600, 30).unwrap(),
    }
}

#[test]
fn known_sensitivities_and_offsets_of_loggers_are_found() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["wrist.cwa", "wrist.gt3x"] {
        let path = folder.path().join(name);
        recorded(&path);
        let out = folder.path().join("result");
        succeed(&[
            "calibrate",
            text(&path),
            "--free-living",
            "--latitude",
            "45",
            "-o",
            text(&out),
        ]);
        let result = json(&out.join("result.json"));
        for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let truths = [
                (format!("scale.{axis}"), SCALE[i]),
                (format!("offset.{axis}"), OFFSET[i]),
            ];
            for (quantity_name, truth) in truths {
                let (value, u, _) = quantity(&result, &quantity_name);
                assert!(u < 0.003, "{name} {quantity_name}: ± {u}");
                assert!(
                    (value - truth).abs() < 4.0 * u,
                    "{name} {quantity_name}: {value} ± {u}, {truth}"
                );
            }
        }
        // The same numbers as text give the same result; only the clock is found anew.
        let table = folder.path().join("wrist.csv");
        succeed(&["convert", text(&path), "-o", text(&table), "--force"]);
        succeed(&[
            "calibrate",
            text(&table),
            "--free-living",
            "--latitude",
            "45",
            "-o",
            text(&out),
        ]);
        let again = json(&out.join("result.json"));
        for name in ["scale.x", "offset.y", "scale.z"] {
            let ((a, u, _), (b, _, _)) = (quantity(&result, name), quantity(&again, name));
            assert!((a - b).abs() < 1e-6 * u, "{name}: {a} and {b} ± {u}");
        }
    }
}
