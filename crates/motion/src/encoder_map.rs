//! Errors of an encoder that repeat with its reading: found with the accelerometer's help, stored, subtracted.

mod search;

pub use search::{FoundMap, MapSearch};

use crate::{MotionRecord, ReadingSource};
use proofmass_core::Error;
use proofmass_core::check::{finite, within};
use proofmass_core::encoder::ErrorLine;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// One line: cosine · cos(2π order r/turn) + sine · sin(2π order r/turn), added to the position at the reading r.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MapLine {
    /// Cycles per turn: 1 for an eccentric disc, 2 for an ellipse, the ratio of a gear for its teeth or its turn.
    pub order: f64,
    /// In the unit of the readings.
    pub cosine: f64,
    /// In the unit of the readings.
    pub sine: f64,
    /// Covariance of cosine and sine.
    pub covariance: [[f64; 2]; 2],
    /// Probability of a line at least as large where there is none.
    pub chance: f64,
}

impl MapLine {
    /// √(cosine² + sine²).
    pub fn amplitude(&self) -> f64 {
        self.cosine.hypot(self.sine)
    }

    /// Standard uncertainty of the amplitude, first order; near zero that of either part.
    pub fn amplitude_uncertainty(&self) -> f64 {
        let [[cc, cs], [_, ss]] = self.covariance;
        let a = self.amplitude();
        let either = cc.max(ss).sqrt();
        if a <= either {
            return either;
        }
        let (c, s) = (self.cosine / a, self.sine / a);
        (c * c * cc + 2.0 * c * s * cs + s * s * ss).max(0.0).sqrt()
    }

    /// As a chip subtracts it.
    pub fn chip(&self) -> ErrorLine<f64> {
        ErrorLine {
            order: self.order,
            cosine: self.cosine,
            sine: self.sine,
        }
    }

    /// What a unit of cosine and of sine adds at a reading.
    fn at(&self, reading: f64, turn: f64) -> [f64; 2] {
        let part = |cosine, sine| ErrorLine {
            cosine,
            sine,
            ..self.chip()
        };
        [part(1.0, 0.0), part(0.0, 1.0)].map(|line| line.at(reading / turn))
    }
}

/// The errors of one encoder. They belong to the zero of its readings: an incremental encoder is set to zero at its index.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EncoderMap {
    /// Way or angle of one turn, in the unit of the readings.
    pub turn: f64,
    /// Lines that are subtracted.
    pub lines: Vec<MapLine>,
}

impl EncoderMap {
    /// What the encoder shows too much at a reading.
    pub fn error(&self, reading: f64) -> f64 {
        let turns = reading / self.turn;
        self.lines.iter().map(|line| line.chip().at(turns)).sum()
    }

    /// Standard uncertainty of that.
    pub fn uncertainty(&self, reading: f64) -> f64 {
        let parts = self.lines.iter().map(|line| {
            let [cos, sin] = line.at(reading, self.turn);
            let [[cc, cs], [_, ss]] = line.covariance;
            cos * cos * cc + 2.0 * cos * sin * cs + sin * sin * ss
        });
        parts.sum::<f64>().max(0.0).sqrt()
    }

    /// Turn, orders and coefficients are numbers that a search finds, and the lines together are a map.
    ///
    /// # Errors
    /// [`Error::OutOfRange`], [`Error::NotFinite`] with the name of the field.
    pub fn check(&self) -> Result<(), Error> {
        check_turn(self.turn)?;
        for line in &self.lines {
            within("order of the encoder map", line.order, 1e-6, 1e9)?;
            finite("cosine of the encoder map", &[line.cosine])?;
            finite("sine of the encoder map", &[line.sine])?;
            finite(
                "covariance of the encoder map",
                line.covariance.as_flattened(),
            )?;
        }
        let steepest = self.steepest();
        within("slope of the encoder map", steepest, 0.0, 1.0)
    }

    fn steepest(&self) -> f64 {
        let steepest = |l: &MapLine| TAU * l.order * l.amplitude() / self.turn;
        self.lines.iter().map(steepest).sum()
    }

    /// Whether the reading rises with the position everywhere: what runs backwards is no map.
    pub(crate) fn is_map(&self) -> bool {
        self.steepest() < 1.0
    }

    /// Standard uncertainty of its slope at a reading: of what it adds to a velocity, over that velocity.
    pub(crate) fn slope_uncertainty(&self, reading: f64) -> f64 {
        let parts = self.lines.iter().map(|line| {
            let [cos, sin] = line.at(reading, self.turn);
            let [[cc, cs], [_, ss]] = line.covariance;
            let rate = TAU * line.order / self.turn;
            rate * rate * (sin * sin * cc - 2.0 * cos * sin * cs + cos * cos * ss)
        });
        parts.sum::<f64>().max(0.0).sqrt()
    }

    /// The record with the map subtracted from its positions.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for readings of speed, or a turn that is not positive.
    pub fn corrected(&self, record: &MotionRecord) -> Result<MotionRecord, Error> {
        check_turn(self.turn)?;
        check_source(record)?;
        let mut corrected = record.clone();
        for reading in corrected.reading.iter_mut().flatten() {
            *reading -= self.error(*reading);
        }
        Ok(corrected)
    }
}

fn check_turn(turn: f64) -> Result<(), Error> {
    if turn > 0.0 && turn.is_finite() {
        return Ok(());
    }
    Err(Error::OutOfRange {
        name: "turn of the encoder",
        value: turn,
        min: f64::MIN_POSITIVE,
        max: f64::MAX,
    })
}

fn check_source(record: &MotionRecord) -> Result<(), Error> {
    match record.source {
        ReadingSource::Position => Ok(()),
        ReadingSource::Speed => Err(Error::Length {
            name: "positions",
            expected: record.reading.len(),
            got: 0,
        }),
    }
}
