//! What the page shows.

use crate::plan::PlannedRun;
use serde::Serialize;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Where the walk stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Phase {
    /// Nothing is measured yet.
    #[default]
    Ready,
    /// The operator mounts the device.
    Mounting,
    /// A run is under way.
    Measuring,
    /// A run ended before its last sample, or somebody stopped.
    Paused,
    /// The plan is done.
    Finished,
}

/// The run that is measured or waited for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunLine {
    /// Name.
    pub name: String,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Inclination in degrees.
    pub inclination: Option<f64>,
    /// Rotation in degrees.
    pub rotation: Option<f64>,
    /// Level in m/s².
    pub target: f64,
}

/// A run that is recorded.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DoneRun {
    /// Name.
    pub name: String,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Level reached, m/s².
    pub level: f64,
    /// Level wanted, m/s².
    pub target: f64,
    /// Time until the level held, s.
    pub settling: f64,
}

/// The state of the walk.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Status {
    /// Where it stands.
    pub phase: Phase,
    /// The present run.
    pub run: Option<RunLine>,
    /// Why it paused.
    pub reason: Option<String>,
    /// Runs that are recorded.
    pub done: usize,
    /// Runs of the plan.
    pub total: usize,
    /// The last runs, the latest first.
    pub recorded: Vec<DoneRun>,
}

impl Status {
    /// Adds a run that is recorded.
    pub fn add(&mut self, run: &PlannedRun, level: f64, settling: f64) {
        self.recorded.insert(
            0,
            DoneRun {
                name: run.name.clone(),
                frequency: run.frequency,
                level,
                target: run.target,
                settling,
            },
        );
        self.recorded.truncate(6);
    }
}

/// A status of several threads.
#[derive(Clone, Debug, Default)]
pub struct SharedStatus(Arc<Mutex<Status>>);

impl SharedStatus {
    /// The status, for a moment.
    pub fn lock(&self) -> MutexGuard<'_, Status> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
