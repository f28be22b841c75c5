//! Tests of this crate in one program: the crates they rest on are compiled and linked into it once.

#![allow(
    clippy::duplicate_mod,
    reason = "programs whose tables are tests, and what they share"
)]

mod any_recording;
mod apply;
mod apply_chain;
mod bench_inputs;
mod bias;
mod campaigns;
mod chains;
mod clock_map;
mod constructions;
mod convert;
mod convert_reference;
mod data_sheet;
mod deconvolution_map;
mod deconvolved_shocks;
mod device_check;
mod device_plan;
mod dynamic_inputs;
mod modes;
mod mountings_of_one_bench;
mod multi_position;
mod noise;
mod odd_recordings;
mod old_results;
mod one_clock;
mod other_recordings;
mod primary;
mod recorded_comparison;
mod shaker;
mod single_axis;
mod step_map;
mod support;
mod temperature_job;
mod triaxial_datasheet;
mod uncertainty;
mod velocity;
