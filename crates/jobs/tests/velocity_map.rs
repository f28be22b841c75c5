//! The map of velocities beside an accelerometer with a low corner and of logs with rows missing, cut down.

#[path = "../examples/velocity_map.rs"]
#[allow(dead_code, reason = "its printed tables")]
mod velocity_map;

use velocity_map::{cells, run};

/// Five motions, a corner of half a hertz that nobody states: the intervals hold, and the velocity is far nearer than the best integral of the
/// accelerometer behind a high-pass.
#[test]
fn coverage_beside_a_low_corner() {
    let (mut inside, mut records) = (0.0, 0);
    for cell in cells().iter().filter(|c| c.name.ends_with("corner 0.5 Hz")) {
        for seed in [400, 401] {
            let one = run(cell, seed).unwrap_or_else(|| panic!("{} {seed}", cell.name));
            inside += one.smoother.inside;
            records += 1;
            let ratio = (one.smoother.square / one.integrator).sqrt();
            assert!(ratio < 0.1, "{} {seed}: {ratio}", cell.name);
        }
    }
    assert_eq!(records, 10);
    // Eight seconds hold some thirty independent values: 0.95 ± 3 · 0.22/√300.
    let pooled = inside / f64::from(records);
    assert!(pooled > 0.91, "{pooled}");
}

/// Five motions of twenty seconds behind two stages at half a hertz, stated: filter and smoother hold, and neither is carried away by what an
/// offset behind both becomes.
#[test]
fn coverage_behind_two_stages() {
    let (mut inside, mut records) = ([0.0; 2], 0);
    let wanted = |name: &str| name.ends_with("two stages at 0.5 Hz");
    for cell in cells().iter().filter(|c| wanted(&c.name)) {
        for seed in [500, 501] {
            let one = run(cell, seed).unwrap_or_else(|| panic!("{} {seed}", cell.name));
            inside[0] += one.filter.inside;
            inside[1] += one.smoother.inside;
            records += 1;
            let ratio = (one.smoother.square / one.integrator).sqrt();
            assert!(ratio < 0.01, "{} {seed}: {ratio}", cell.name);
        }
    }
    assert_eq!(records, 10);
    // Twenty seconds hold some eighty independent values: 0.95 ± 3 · 0.22/√800.
    for pooled in inside.map(|sum| sum / f64::from(records)) {
        assert!(pooled > 0.92, "{inside:?}");
    }
}

/// Four motions whose logs lose cells and rows: the whole record is used, but for what a long gap takes, that is said, and the intervals hold.
#[test]
fn coverage_where_rows_are_missing() {
    let lost = [
        ("% of the cells empty", 8000),
        // Among so many some dozen follow one another, which is a gap.
        ("half of the cells empty", 7900),
        ("% of the rows lost", 8000),
        ("bursts of 10 rows lost", 7800),
        ("3 ms lost", 8000),
        ("50 ms lost", 7950),
        ("1 s lost", 7000),
    ];
    for (what, stated) in lost {
        let (mut inside, mut records) = ([0.0; 2], 0);
        for cell in cells().iter().filter(|c| c.name.ends_with(what)) {
            for seed in [600, 601] {
                let one = run(cell, seed).unwrap_or_else(|| panic!("{} {seed}", cell.name));
                inside[0] += one.filter.inside;
                inside[1] += one.smoother.inside;
                records += 1;
                // A row at an end may be among the lost ones.
                assert!(
                    (stated - 2..=8000).contains(&one.stated),
                    "{}: {}",
                    cell.name,
                    one.stated
                );
                let mut codes = one.findings.iter();
                assert!(codes.any(|f| f.0 == "gaps-in-record"), "{}", cell.name);
            }
        }
        assert!(records >= 8, "{what}");
        // Eight seconds hold some thirty independent values: 0.95 − 3 · 0.22/√240. Where half is missing the finding says that it may be less.
        let least = if what.starts_with("half") { 0.8 } else { 0.907 };
        for pooled in inside.map(|sum| sum / f64::from(records)) {
            assert!(pooled > least, "{what}: {inside:?}");
        }
    }
}
