//! The map of velocities beside an accelerometer with a low corner, cut down.

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
