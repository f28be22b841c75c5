//! Intervals of sensors that were worn: a small seed of the map in `examples/worn_sensors.rs`.

#[allow(dead_code)]
#[path = "../examples/worn_sensors.rs"]
mod program;

use program::PLACES;

/// With hours as blocks, wherever they fell, 95 % intervals of a day's wear held 79 to 88 %, of long postures 78 to 83 %. Three quantities of
/// one sensor are nearly independent: of 120 at 95 %, fewer than 104 hold once in 2000 times.
#[test]
fn coverage_of_a_day_and_of_long_postures() {
    for place in PLACES
        .iter()
        .filter(|p| p.days == 1.0 || p.posture[0] > 2000.0)
    {
        let cell = place.cell(40);
        println!("{place:?} {cell:?}");
        assert_eq!(cell.refused, 0.0, "{place:?}");
        for share in cell.coverage {
            assert!(share >= 103.0 / 120.0, "{place:?}: {cell:?}");
        }
    }
}
