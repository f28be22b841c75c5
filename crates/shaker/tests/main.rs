//! Tests of this crate in one program: the crates they rest on are compiled and linked into it once.

#![allow(
    clippy::duplicate_mod,
    reason = "programs whose tables are tests, and what they share"
)]

mod budgets;
mod drift_delay_map;
mod findings;
mod shaker_campaign;
mod shaker_coverage;
mod shaker_diagnosis;
mod shaker_free_phase;
mod shaker_maps;
mod shaker_plan;
mod shaker_published_case;
mod shaker_sessions;
mod shaker_small_plans;
mod shaker_unread_phases;
mod sine_front_end;
