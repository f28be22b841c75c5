//! Tests of this crate in one program: the crates they rest on are compiled and linked into it once.

mod autocalibration;
mod bias_tracking;
mod compensation_gain;
mod coverage_multi_position;
mod findings;
mod hand_held_recordings;
mod misfit;
mod recording_quality;
mod rest_search;
mod scatter_forms;
mod static_tests;
mod temperature;
mod temperature_moved;
mod temperature_surroundings;
mod temperature_walk;
mod terms_beyond_the_matrix;
mod tumble;
mod worn_sensors;
