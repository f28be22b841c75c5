//! The map of deconvolved shocks of docs/dynamic-tests.md, cut down.

#[path = "../examples/deconvolution_map.rs"]
#[allow(dead_code, reason = "its printed table")]
mod program;

use program::{Answer, Group, place};

#[test]
fn coverage_of_peaks_durations_and_velocity_changes_over_the_map() {
    let all: Vec<_> = (0..60).map(|k| (place(k), place(k).answer(k))).collect();
    let group = Group::of(&all, |_| true);
    // One in seven is refused; of 45 and more intervals of 95 %, more than an eighth is missed once in 1000.
    assert!(group.answers >= 45, "{group:?}");
    let least = group.answers - group.answers / 8;
    assert!(group.held[0] >= least, "{group:?}");
    // Of 19 durations five or more are missed in one set of 500, of fifty velocity changes eight or more in one of 300.
    let (stated, held, _) = group.duration;
    assert!(stated >= 19 && held + 4 >= stated, "{group:?}");
    let (stated, held, _) = group.velocity_change;
    assert!(stated >= 40 && held + 7 >= stated, "{group:?}");
    let refused = all.iter().filter_map(|(_, answer)| match answer {
        Answer::Refused(why) => Some(why),
        Answer::Stated { .. } => None,
    });
    for why in refused {
        assert!(why.contains("quiet") || why.contains("peak"), "{why}");
    }
}
