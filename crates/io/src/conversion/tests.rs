use super::writer::heading;
use crate::{Unit, split_heading};

#[test]
fn law_name_and_unit_are_read_again_from_a_heading() {
    for unit in Unit::all() {
        for name in ["acc_x", "force", "channel 1", "F (left)", "g"] {
            let text = heading(name, Some(unit));
            assert_eq!(split_heading(&text), (name, Some(unit)), "{text}");
        }
    }
    assert_eq!(
        heading("acc_x", Some(Unit::MetrePerSecondSquared)),
        "acc_x_m/s2"
    );
}
