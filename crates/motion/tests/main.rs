//! Tests of this crate in one program: the crates they rest on are compiled and linked into it once.

mod blows;
mod coverage;
mod drift;
mod encoder_map;
mod encoder_robot;
mod faults;
mod findings;
mod healthy_errors;
mod held_gain;
mod largest_speed;
mod low_corner;
mod method_coverage;
mod motions;
mod reference_experiment;
mod slow_counts;
mod start_velocity;
mod timed_edges;
mod tuned_coverage;
