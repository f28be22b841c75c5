//! A gyroscope beside the two wheels of an axle.

use super::reading::Reading;
use super::sensors::{stated_unit, unknown_unit};
use crate::trouble::Trouble;
use proofmass_io::{ColumnRef, Recording, Unit};
use proofmass_motion::interval;
use proofmass_odometry::Axle;
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

/// The gyroscope that tells whether two wheels turn a vehicle as it turns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[serde(default)]
#[non_exhaustive]
pub struct Turning {
    /// Column of a gyroscope's yaw rate, positive to the left: finds where one of two wheels (left,right) slips
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN", requires = "track"))]
    pub yaw_rate: Option<String>,
    /// Unit of the yaw rate, where the heading does not say it: rad/s, °/s, …
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "UNIT", requires = "yaw_rate")
    )]
    pub yaw_rate_unit: Option<Unit>,
    /// Distance of the two wheels, m
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "METRES", requires = "yaw_rate")
    )]
    pub track: Option<f64>,
}

impl Turning {
    /// The column it needs.
    pub(super) fn column(&self) -> Option<ColumnRef> {
        self.yaw_rate.as_deref().map(ColumnRef::from_word)
    }

    /// What is to be said of the wheels; `index` is that of the yaw rate's column.
    ///
    /// # Errors
    /// Not two wheels in metres, a track that is not told, a unit that is no rate.
    pub(super) fn findings(
        &self,
        reading: &Reading,
        recording: &Recording,
        clock: &[f64],
        index: usize,
    ) -> Result<Vec<Finding>, Trouble> {
        let track = self.track.ok_or_else(|| {
            Trouble::request("the distance of the wheels is not known")
                .with_hint("add --track METRES")
        })?;
        let wheels = reading.wheels(recording)?;
        let column = &recording.columns[index];
        let unit = stated_unit(recording, column, (self.yaw_rate_unit, "--yaw-rate-unit"))?
            .ok_or_else(|| {
                unknown_unit(recording, column, "add --yaw-rate-unit rad/s, deg/s, …")
            })?;
        let (si, factor) = unit.si();
        if si != Unit::RadianPerSecond {
            return Err(Trouble::data(format!(
                "column {:?} is in {unit}, which is no rate of turning",
                column.name
            ))
            .detail(recording.path.display().to_string()));
        }
        let mut yaw: Vec<Option<f64>> = column.data.iter().map(|v| Some(factor * v)).collect();
        for &k in recording.missing(index) {
            yaw[k] = None;
        }
        // Rows come evenly, but for the jitter of a logger.
        let axle = Axle {
            sample_time: interval(clock).unwrap_or(0.0),
            source: reading.source(),
            wheels: [&wheels[0], &wheels[1]],
            yaw_rate: &yaw,
            track,
            increment: reading.increment(),
        };
        let found = axle
            .slip()
            .map_err(|e| Trouble::from(e).detail(recording.path.display().to_string()))?;
        Ok(found.findings)
    }
}
