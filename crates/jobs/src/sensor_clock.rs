//! The clock of a digital sensor beside that of the bench, as a result states it.

use crate::findings;
use proofmass_documents::StatedQuantity;
use proofmass_shaker::derived::PROBABILITY;
use proofmass_shaker::recording::Quality;
use proofmass_shaker::sample_clock::{ClockError, Latency, SampleClock};
use proofmass_uncertainty::{DegreesOfFreedom, Finding, Quantity};

/// What a result with a sensor's own file says about its clock.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SensorClock {
    /// Whose clock it is.
    pub(crate) clock: SampleClock,
    /// Error of its rate against the bench.
    pub(crate) error: Option<ClockError>,
    /// Delay of its samples, where the clock is shared.
    pub(crate) delay: Option<Latency>,
}

impl SensorClock {
    /// Error of the device's clock from the runs that were used, and its delay from phases (frequency, phase, standard
    /// uncertainty) where the clock is shared; `own` says what a clock of its own costs.
    pub(crate) fn of<'a>(
        clock: SampleClock,
        runs: impl Iterator<Item = (&'a str, &'a Quality)>,
        phases: impl FnOnce() -> Vec<(f64, f64, f64)>,
        own: [&str; 2],
        findings: &mut Vec<Finding>,
    ) -> Self {
        let (error, about) = ClockError::of(clock, runs);
        findings.extend(about);
        let delay = match clock {
            SampleClock::Own => {
                findings.push(findings::own_clock(own[0], own[1]));
                None
            }
            SampleClock::Shared => {
                let (delay, about) = Latency::of(&phases());
                findings.extend(about);
                delay
            }
        };
        Self {
            clock,
            error,
            delay,
        }
    }

    pub(crate) fn quantities(&self) -> Vec<StatedQuantity> {
        let error = self.error.as_ref().map(error);
        error
            .into_iter()
            .chain(self.delay.as_ref().map(delay))
            .collect()
    }

    /// Lines for the head of a report.
    pub(crate) fn lines(&self) -> Vec<(String, String)> {
        let mut lines = vec![];
        if let Some(e) = &self.error {
            let q = error(e);
            lines.push((
                "Clock of the sensor".to_owned(),
                format!(
                    "{:+.2} ppm ± {:.2} ppm (U) against that of the bench, mean of {} runs; {}",
                    q.value,
                    q.expanded,
                    e.runs,
                    match self.clock {
                        SampleClock::Own => "its own: no phase against the reference",
                        SampleClock::Shared => "declared as one clock",
                    }
                ),
            ));
        }
        if let Some(d) = &self.delay {
            let q = delay(d);
            lines.push((
                "Delay of the samples".to_owned(),
                format!(
                    "({:.6} ± {:.6}) ms, from the phases of {} frequencies; it is in the phases that are stated",
                    1e3 * q.value,
                    1e3 * q.expanded,
                    d.frequencies
                ),
            ));
        }
        lines
    }
}

fn error(error: &ClockError) -> StatedQuantity {
    StatedQuantity::new(
        &Quantity {
            name: "clock.error".to_owned(),
            unit: "ppm".to_owned(),
            value: 1e6 * error.relative,
            standard_uncertainty: 1e6 * error.standard_uncertainty,
            dof: error.dof,
        },
        PROBABILITY,
    )
}

fn delay(latency: &Latency) -> StatedQuantity {
    StatedQuantity::new(
        &Quantity {
            name: "delay".to_owned(),
            unit: "s".to_owned(),
            value: latency.delay,
            standard_uncertainty: latency.standard_uncertainty,
            dof: DegreesOfFreedom::INFINITE,
        },
        PROBABILITY,
    )
}
