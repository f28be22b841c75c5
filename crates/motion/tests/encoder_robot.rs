//! Logs of a small robot with two encoders and an accelerometer, 1 kHz, millimetres.

use proofmass_motion::{EstimateResult, MapSearch, MotionRecord, ReadingSource, estimate};
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
fn record(name: &str) -> Option<MotionRecord> {
    let rows = log(name)?;
    let reading = rows.iter().map(|r| Some(0.5e-3 * (r[0] + r[1]))).collect();
    let acceleration = rows.iter().map(|r| 1e-3 * r[3]).collect();
    let mut record =
        MotionRecord::new(1e-3, ReadingSource::Position, reading, acceleration).unwrap();
    record.initial_velocity = Some(0.0);
    Some(record)
}

fn robot(name: &str) -> Option<EstimateResult> {
    let record = record(name)?;
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
    // Increment and noise of the readings are unknown; the wheels do not tell the gain nearer than a tenth, and one that is
    // taken is one.
    if let Some(gain) = result.tuned.and_then(|t| t.gain) {
        assert!(gain.uncertainty < 0.15 && (gain.value - 1.0).abs() < 2.0 * gain.uncertainty);
    }
    assert!(!result.findings.iter().any(|f| f.code() == "gain-mismatch"));
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
    // In the logs that slip few turns are left, whose line does not stand out of the motion around it: there the map of each wheel
    // shows it (`crosscheck_the_map_of_a_wheel_is_found_beside_slip`).
    let Some(result) = robot("t0.2.tab") else {
        return;
    };
    let ripple = result.ripple.expect("the robot moves");
    println!("{:?}", ripple.lines);
    assert!(!ripple.lines.is_empty());
}

/// Each wheel by itself: where one of them slips their phases part, and the mean of both has no map of its own.
#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn crosscheck_the_map_of_a_wheel_is_found_beside_slip() {
    let mut search = MapSearch::default();
    search.turn = 0.0397;
    search.orders = vec![1.0];
    for (wheel, others) in [
        (0, vec!["20190427-v4-t0.3-2.csv"]),
        (1, vec!["0.2-2.tab", "20190427-v4-t0.3-2.csv"]),
    ] {
        let map = |name: &str| {
            let rows = log(name).unwrap();
            let mut record = record(name).unwrap();
            record.reading = rows.iter().map(|r| Some(1e-3 * r[wheel])).collect();
            let found = search.run(&record, &proofmass_core::Unwatched).unwrap();
            let line = found.lines[0];
            println!(
                "wheel {wheel}, {name}: {:?} {:.4} mm, u {:.4} mm, chance {:.1e}",
                found.stretches,
                1e3 * line.amplitude(),
                1e3 * line.amplitude_uncertainty(),
                line.chance
            );
            assert_eq!(found.map.lines.len(), 1, "{name}: {:?}", found.lines);
            found
        };
        // The run without slip.
        let clean = map("t0.2.tab");
        assert_eq!(clean.stretches.first(), Some(&(0..2000)));
        for name in others {
            let found = map(name);
            assert!(!found.slip.unwrap().slip.is_empty());
            let (a, b) = (found.lines[0], clean.lines[0]);
            let u = a.amplitude_uncertainty().hypot(b.amplitude_uncertainty());
            // Three comparisons at three standard uncertainties: one in a hundred by chance.
            assert!((a.amplitude() - b.amplitude()).abs() < 3.0 * u, "{name}");
        }
    }
}
