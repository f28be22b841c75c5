//! Logs of a small robot with two encoders and an accelerometer, 1 kHz, millimetres.

use proofmass_motion::{EstimateResult, MotionRecord, ReadingSource, estimate};
use std::path::PathBuf;

/// Rows of a log.
fn log(name: &str) -> Option<Vec<Vec<f64>>> {
    let root = std::env::var_os("PROOFMASS_REFERENCE_DATA");
    let root = PathBuf::from(
        root.expect("PROOFMASS_REFERENCE_DATA names the folder, see docs/reference-data.md"),
    );
    let path = root.join("encoder-robot").join(name);
    let text = std::fs::read_to_string(path).expect("the log");
    let rows = text.lines().map(|line| {
        line.split_whitespace()
            .map(|field| field.parse().expect("a number"))
            .collect()
    });
    Some(rows.collect())
}

/// Mean of both wheels in metres, acceleration in m/s².
fn robot(name: &str) -> Option<EstimateResult> {
    let rows = log(name)?;
    let reading = rows.iter().map(|r| Some(0.5e-3 * (r[0] + r[1]))).collect();
    let acceleration = rows.iter().map(|r| 1e-3 * r[3]).collect();
    let mut record =
        MotionRecord::new(1e-3, ReadingSource::Position, reading, acceleration).unwrap();
    record.initial_velocity = Some(0.0);
    let result = estimate(&record, None, Some(0.04), &proofmass_core::Unwatched).unwrap();
    println!("{name}: {:?}", result.model);
    println!("  agreement {:?}", result.agreement);
    for f in &result.findings {
        println!("  {f}");
    }
    Some(result)
}

#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn crosscheck_clean_run_agrees_and_has_no_slip() {
    let Some(result) = robot("t0.2.tab") else {
        return;
    };
    let slip = result.slip.unwrap();
    assert!(slip.slip.is_empty(), "{:?}", slip.slip);
    assert!(slip.collisions.is_empty(), "{:?}", slip.collisions);
    // 95 % are expected of a matched model; this one is fitted to quantised, slightly coloured readings.
    assert!(result.agreement.unwrap() > 0.9, "{:?}", result.agreement);
}

#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn crosscheck_slip_and_collision_are_flagged() {
    let Some(result) = robot("0.2-2.tab") else {
        return;
    };
    assert!(result.agreement.unwrap() > 0.9, "{:?}", result.agreement);
    let slip = result.slip.unwrap();
    // The wheels lose grip after some 1.1 s and the robot spins; nothing before 1 s.
    assert!(
        slip.slips(1300, 0) && !slip.slips(700, 0),
        "{:?}",
        slip.slip
    );
    let Some(result) = robot("20190427-v4-t0.3-2.csv") else {
        return;
    };
    let slip = result.slip.unwrap();
    assert!(
        slip.slips(1900, 0) && !slip.slips(1000, 0),
        "{:?}",
        slip.slip
    );
}

#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn crosscheck_once_per_turn_ripple_is_reported() {
    for name in ["t0.2.tab", "0.2-2.tab", "20190427-v4-t0.3-2.csv"] {
        let Some(result) = robot(name) else { return };
        let ripple = result.ripple.expect("the robot moves");
        println!("{name}: {:?}", ripple.lines);
        assert!(!ripple.lines.is_empty());
    }
}
