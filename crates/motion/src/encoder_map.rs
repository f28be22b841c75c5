//! Errors of an encoder that repeat with its reading: found with the accelerometer's help, stored, subtracted.

use crate::diffuse::{Prepared, REGRESSORS};
use crate::{MotionRecord, ReadingSource, Tuned, Tuning};
use proofmass_core::encoder::ErrorLine;
use proofmass_core::{Error, Watch};
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::f64::consts::TAU;

/// One line: cosine · cos(2π order r/turn) + sine · sin(2π order r/turn), added to the position at the reading r.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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

/// Which lines are looked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct MapSearch {
    /// Way or angle of one turn, in the unit of the readings.
    pub turn: f64,
    /// Orders in cycles per turn, each once.
    pub orders: Vec<f64>,
    /// Probability at which a line that is not there is subtracted, all orders together.
    pub false_alarm_rate: f64,
    /// How the noise is found.
    pub tuning: Tuning,
}

impl Default for MapSearch {
    /// The first four orders of a turn of 2π rad.
    fn default() -> Self {
        Self {
            turn: TAU,
            orders: vec![1.0, 2.0, 3.0, 4.0],
            false_alarm_rate: 1e-3,
            tuning: Tuning::default(),
        }
    }
}

/// What a search found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FoundMap {
    /// Every line that was looked for.
    pub lines: Vec<MapLine>,
    /// Those that are there, to subtract.
    pub map: EncoderMap,
    /// Turns between the smallest and the largest reading.
    pub turns: f64,
    /// Noise and constants beside the map.
    pub tuned: Tuned,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

/// Most rounds of noise and map; each halves what is left of their influence on one another, and more.
const ROUNDS: usize = 6;

impl MapSearch {
    /// Finds the lines in a record with encoder and accelerometer, in either sense of motion.
    ///
    /// The reading is position plus map plus noise, the position follows the acceleration: coefficients of the map, start,
    /// offset, gain and latency of the accelerometer by generalised least squares through the filter, with the noise of the
    /// tuning on the record less the map, in turn until both stand still. Where roundings repeat with the motion the
    /// covariance counts only the readings that are new.
    ///
    /// **Accuracy** coverage and false alarms: tests of this file. A line is told from the motion by the accelerometer: what
    /// varies more slowly than its own noise lets it see has a large uncertainty.
    /// **Source** `[DeJong91]` for the regressors.
    ///
    /// # Errors
    /// Of the record and the tuning; [`Error::OutOfRange`] for a turn or an order that is not positive, readings of speed;
    /// [`Error::TooMany`] for more than nine orders; [`Error::Singular`] where the readings do not tell the lines apart.
    pub fn run(&self, record: &MotionRecord, watch: &dyn Watch) -> Result<FoundMap, Error> {
        record.check()?;
        check_turn(self.turn)?;
        check_source(record)?;
        self.check_orders()?;
        let lines: Vec<MapLine> = self
            .orders
            .iter()
            .map(|&order| MapLine {
                order,
                cosine: 0.0,
                sine: 0.0,
                covariance: [[0.0; 2]; 2],
                chance: 1.0,
            })
            .collect();
        let regressors = self.regressors(record, &lines);
        let mut map = EncoderMap {
            turn: self.turn,
            lines,
        };
        let mut tuned = self.tuning.run(record, watch)?;
        for round in 1..=ROUNDS {
            watch.step("encoder map", round as u64, ROUNDS as u64)?;
            let before = map.clone();
            self.fit(record, &tuned, &regressors, &mut map)?;
            let change = map.lines.iter().zip(&before.lines).all(|(a, b)| {
                let moved = (a.cosine - b.cosine).hypot(a.sine - b.sine);
                moved < 0.05 * a.amplitude_uncertainty()
            });
            if change {
                break;
            }
            tuned = self.tuning.run(&map.corrected(record)?, watch)?;
        }
        let lines = map.lines.clone();
        let alone = self.false_alarm_rate / lines.len().max(1) as f64;
        map.lines.retain(|line| line.chance < alone);
        let (low, high) = record
            .reading
            .iter()
            .flatten()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), r| {
                (a.min(*r), b.max(*r))
            });
        let turns = (high - low) / self.turn;
        let mut findings = findings(&map, turns);
        findings.extend(tuned.findings.iter().cloned());
        Ok(FoundMap {
            findings,
            lines,
            map,
            turns,
            tuned,
        })
    }

    fn check_orders(&self) -> Result<(), Error> {
        if 2 * self.orders.len() > REGRESSORS {
            return Err(Error::TooMany {
                name: "orders of the encoder map",
                most: REGRESSORS / 2,
                got: self.orders.len(),
            });
        }
        if self.orders.is_empty() {
            return Err(Error::TooFew {
                name: "orders of the encoder map",
                needed: 1,
                got: 0,
            });
        }
        let bad = self.orders.iter().find(|o| !(**o > 0.0 && o.is_finite()));
        match bad {
            Some(&value) => Err(Error::OutOfRange {
                name: "order of the encoder map",
                value,
                min: f64::MIN_POSITIVE,
                max: f64::MAX,
            }),
            None => Ok(()),
        }
    }

    /// Cosine and sine of every order at every sample; zero where there is no reading.
    fn regressors(&self, record: &MotionRecord, lines: &[MapLine]) -> Vec<Vec<f64>> {
        let column = |line: &MapLine, part: usize| {
            let at = |r: &Option<f64>| r.map_or(0.0, |r| line.at(r, self.turn)[part]);
            record.reading.iter().map(at).collect()
        };
        lines
            .iter()
            .flat_map(|line| [column(line, 0), column(line, 1)])
            .collect()
    }

    fn fit(
        &self,
        record: &MotionRecord,
        tuned: &Tuned,
        regressors: &[Vec<f64>],
        map: &mut EncoderMap,
    ) -> Result<(), Error> {
        let prepared = Prepared::new(record, &tuned.model);
        let noise = tuned.noise();
        let found =
            prepared
                .regress(&noise, tuned.unknowns, regressors)
                .ok_or(Error::Singular {
                    name: "lines of the encoder map",
                    condition: 1e13,
                })?;
        // Readings whose rounding repeats tell nothing new.
        let readings = record.reading.iter().flatten().count() as f64;
        let repeated = (readings / tuned.effective_readings).max(1.0);
        for (k, line) in map.lines.iter_mut().enumerate() {
            let (i, j) = (2 * k, 2 * k + 1);
            (line.cosine, line.sine) = (found.coefficients[i], found.coefficients[j]);
            let c = |a: usize, b: usize| found.covariance[a][b] * repeated;
            line.covariance = [[c(i, i), c(i, j)], [c(j, i), c(j, j)]];
            let [[cc, cs], [_, ss]] = line.covariance;
            let determinant = cc * ss - cs * cs;
            let (x, y) = (line.cosine, line.sine);
            let square = (ss * x * x - 2.0 * cs * x * y + cc * y * y) / determinant;
            line.chance = ChiSquared::new(2.0).map_or(1.0, |d| d.sf(square.max(0.0)));
        }
        Ok(())
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

fn findings(map: &EncoderMap, turns: f64) -> Vec<Finding> {
    let mut list = Vec::new();
    if turns < 1.0 {
        list.push(
            Finding::new(
                Severity::Warning,
                "encoder-map-part-of-a-turn",
                "the recording covers less than a turn: elsewhere the map is a guess",
            )
            .evidence(format!("{turns:.2} turns"))
            .advice("turn the axis through two turns or more, in both senses"),
        );
    }
    if !map.lines.is_empty() {
        let told: Vec<String> = map
            .lines
            .iter()
            .map(|l| {
                format!(
                    "{} per turn: {:.3e} (u = {:.1e}), {:.2} % of the velocity",
                    l.order,
                    l.amplitude(),
                    l.amplitude_uncertainty(),
                    100.0 * TAU * l.order * l.amplitude() / map.turn
                )
            })
            .collect();
        list.push(
            Finding::new(
                Severity::Note,
                "encoder-map-found",
                "the encoder has errors that repeat with its reading",
            )
            .evidence(told.join("; "))
            .advice("subtract the map; an incremental encoder is set to zero at its index first"),
        );
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate;
    use proofmass_core::Unwatched;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    const RADIUS: f64 = 0.005;
    const DT: f64 = 1e-3;

    /// A wheel of 5 mm that rolls ±0.14 m, eight turns and a half, there and back; 2000 counts per turn, an eccentric disc.
    fn wheel(eccentricity: f64, phase: f64, seed: u64) -> (MotionRecord, Vec<f64>) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let count = TAU * RADIUS / 2000.0;
        // Two sines whose periods have no common multiple in the record: the roundings differ every time.
        let parts = [(0.12, 0.31, 0.4 * normal()), (0.02, 0.97, 0.4 * normal())];
        let place = |t: f64, order: u32| -> f64 {
            let part = |&(a, f, p): &(f64, f64, f64)| {
                let w = TAU * f;
                match order {
                    0 => a * (w * t + p).sin(),
                    1 => a * w * (w * t + p).cos(),
                    _ => -a * w * w * (w * t + p).sin(),
                }
            };
            parts.iter().map(part).sum()
        };
        let time = |k: usize| DT * k as f64;
        let reading = (0..8000).map(|k| {
            let x = place(time(k), 0);
            let shown = x + RADIUS * eccentricity * (x / RADIUS + phase).sin();
            Some((shown / count).round() * count)
        });
        let acceleration = (0..8000).map(|k| place(time(k), 2) + 0.05 + 0.02 * normal());
        let mut record = MotionRecord::new(
            DT,
            ReadingSource::Position,
            reading.collect(),
            acceleration.collect(),
        )
        .unwrap();
        record.increment = Some(count);
        (record, (0..8000).map(|k| place(time(k), 1)).collect())
    }

    fn search() -> MapSearch {
        MapSearch {
            turn: TAU * RADIUS,
            orders: vec![1.0, 2.0],
            ..MapSearch::default()
        }
    }

    #[test]
    fn coverage_of_an_eccentric_disc() {
        let phase = 0.7f64;
        let (mut inside, mut all) = (0, 0);
        for (eccentricity, seeds) in [(0.01, 0..15), (0.03, 15..30)] {
            for seed in seeds {
                let (record, _) = wheel(eccentricity, phase, seed);
                let found = search().run(&record, &Unwatched).unwrap();
                assert_eq!(found.map.lines[0].order, 1.0, "{found:?}");
                let line = found.map.lines[0];
                let size = RADIUS * eccentricity;
                for (value, truth, axis) in [
                    (line.cosine, size * phase.sin(), 0),
                    (line.sine, size * phase.cos(), 1),
                ] {
                    let u = line.covariance[axis][axis].sqrt();
                    all += 1;
                    inside += u32::from((value - truth).abs() < 1.96 * u);
                }
            }
        }
        // Binomial at 0.95: 57 of 60 expected, below 51 in one of a thousand.
        assert!(inside >= 51, "{inside} of {all}");
    }

    #[test]
    fn law_the_subtracted_map_makes_the_encoder_ideal() {
        let rms = |record: &MotionRecord, truth: &[f64]| {
            let trace = estimate(record, None, None, &Unwatched).unwrap().smoother;
            let inner = 500..7500;
            let square: f64 = inner
                .clone()
                .map(|k| (trace.velocity[k] - truth[k]).powi(2))
                .sum();
            (square / inner.len() as f64).sqrt()
        };
        let (ideal, truth) = wheel(0.0, 0.0, 3);
        let (record, _) = wheel(0.03, 0.7, 3);
        let found = search().run(&record, &Unwatched).unwrap();
        let mended = found.map.corrected(&record).unwrap();
        let (before, after, best) = (
            rms(&record, &truth),
            rms(&mended, &truth),
            rms(&ideal, &truth),
        );
        assert!(after < 1.5 * best, "{before} {after} {best}");
        assert!(before > 5.0 * after, "{before} {after}");
    }

    #[test]
    fn known_false_alarms_of_ideal_encoders() {
        let found = (100..140)
            .filter(|&seed| {
                let (record, _) = wheel(0.0, 0.0, seed);
                let found = search().run(&record, &Unwatched).unwrap();
                !found.map.lines.is_empty()
            })
            .count();
        // One in a thousand is stated: two of forty come by chance in one of 1300.
        assert!(found <= 1, "{found} of 40");
    }

    #[test]
    fn refuses_orders_and_turns_that_cannot_be() {
        let (record, _) = wheel(0.0, 0.0, 1);
        let refused = |search: MapSearch| search.run(&record, &Unwatched).is_err();
        assert!(refused(MapSearch {
            turn: 0.0,
            ..search()
        }));
        assert!(refused(MapSearch {
            orders: vec![],
            ..search()
        }));
        assert!(refused(MapSearch {
            orders: vec![1.0, f64::NAN],
            ..search()
        }));
        assert!(refused(MapSearch {
            orders: vec![1.0, 1.0],
            ..search()
        }));
        assert!(refused(MapSearch {
            orders: vec![1.0; 10],
            ..search()
        }));
        let mut speed = record.clone();
        speed.source = ReadingSource::Speed;
        assert!(search().run(&speed, &Unwatched).is_err());
    }
}
