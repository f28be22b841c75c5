//! Search for the lines of an encoder map in a record.

use super::{EncoderMap, MapLine, check_source, check_turn};
use crate::diffuse::{Prepared, REGRESSORS, Regression};
use crate::findings;
use crate::pairing::OPPOSITE;
use crate::velocity::ground::{
    Ground, doubts, margin, part, part_finding, runs, search_of, sensors,
};
use crate::{MotionRecord, Pairing, SlipReport, Tuned, Tuning, conditions};
use proofmass_core::{Error, Watch};
use proofmass_uncertainty::Finding;
use proofmass_uncertainty::chi_squared_chance;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::ops::Range;

/// Which lines are looked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct MapSearch {
    /// Way or angle of one turn, in the unit of the readings.
    pub turn: f64,
    /// Orders in cycles per turn, each once.
    pub orders: Vec<f64>,
    /// Whether the four quarters of a line may be unequal: one cycle in four counts.
    pub quarters: bool,
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
            quarters: false,
            false_alarm_rate: 1e-3,
            tuning: Tuning::default(),
        }
    }
}

/// What a search found.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FoundMap {
    /// Every line that was looked for.
    pub lines: Vec<MapLine>,
    /// Those that are there, to subtract.
    pub map: EncoderMap,
    /// Turns between the smallest and the largest reading.
    pub turns: f64,
    /// Stretches without slip, samples: only they are used.
    pub stretches: Vec<Range<usize>>,
    /// Slip that is left when the map is subtracted; `None` for a record too short to look.
    pub slip: Option<SlipReport>,
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
    /// covariance counts only the readings that are new. A wheel that slips keeps its map: every stretch without slip is
    /// used, with a start and an offset of its own; what is slip is asked anew with the map subtracted.
    ///
    /// **Accuracy** coverage and false alarms: tests of this module. A line is told from the motion by the accelerometer:
    /// what varies more slowly than its own noise lets it see has a large uncertainty. Quarters are told from rounding
    /// where the axis moves by a count and more per sample.
    /// **Source** `[DeJong91]` for the regressors.
    ///
    /// # Errors
    /// Of the record and the tuning; [`Error::OutOfRange`] for a turn or an order that is not positive, readings of speed;
    /// [`Error::TooMany`] for more than nine orders; [`Error::TooFew`] for quarters of readings that are no counts;
    /// [`Error::Singular`] where the readings do not tell the lines apart.
    pub fn run(&self, record: &MotionRecord, watch: &dyn Watch) -> Result<FoundMap, Error> {
        self.search(record, false, watch)
    }

    /// The same; `cautious` where a line is subtracted that nobody asked for: the noise of the accelerometer is then not taken for
    /// less than its floor, to which a rounding that lasts would draw it.
    pub(crate) fn search(
        &self,
        record: &MotionRecord,
        cautious: bool,
        watch: &dyn Watch,
    ) -> Result<FoundMap, Error> {
        record.check()?;
        check_turn(self.turn)?;
        check_source(record)?;
        let mut map = self.empty(record)?;
        let regressors = self.regressors(record, &map.lines);
        self.start(record, &regressors, &mut map);
        let mut used = Used::of(&map.corrected(record)?, &self.tuning, watch)?;
        for round in 1..=ROUNDS {
            watch.step("encoder map", round as u64, ROUNDS as u64)?;
            let before = map.clone();
            used.cautious = cautious;
            used.fit(record, &regressors, &mut map)?;
            let change = map.lines.iter().zip(&before.lines).all(|(a, b)| {
                let moved = (a.cosine - b.cosine).hypot(a.sine - b.sine);
                moved < 0.05 * a.amplitude_uncertainty()
            });
            if change {
                break;
            }
            // A large map passes for slip until it is subtracted.
            used = Used::of(&map.corrected(record)?, &self.tuning, watch)?;
        }
        watch.step("encoder map", ROUNDS as u64, ROUNDS as u64)?;
        let lines = map.lines.clone();
        let alone = self.false_alarm_rate / lines.len().max(1) as f64;
        map.lines.retain(|line| line.chance < alone);
        let turns = used.way(record) / self.turn;
        let mut findings = findings(&map, turns, self.quarter(record));
        findings.extend(conditions(record));
        let readings = (used.repeated * used.tuned.effective_readings).round() as usize;
        let beside = doubts(record, used.pairing.as_ref(), Some(&used.tuned), readings);
        findings.extend(beside);
        // A large map explains positions of the other sense, so that beside it they do not show.
        if !findings.iter().any(|f| f.code() == OPPOSITE) {
            let plain = sensors(record).1.map_or(Vec::new(), |p| p.findings);
            findings.extend(plain.into_iter().filter(|f| f.code() == OPPOSITE));
        }
        findings.extend(part_finding(record, &used.part));
        findings.extend(used.slip.iter().flat_map(|s| s.findings.iter().cloned()));
        findings.extend(used.tuned.findings.iter().cloned());
        Ok(FoundMap {
            findings,
            lines,
            map,
            turns,
            stretches: used.stretches,
            slip: used.slip,
            tuned: used.tuned,
        })
    }

    /// Whether one of the lines is in a record whose noise was found already: one pass, before a search.
    pub(crate) fn shows(&self, record: &MotionRecord, ground: Ground) -> Result<bool, Error> {
        let mut map = self.empty(record)?;
        let regressors = self.regressors(record, &map.lines);
        let mut used = Used::on(record, ground);
        used.cautious = true;
        used.fit(record, &regressors, &mut map)?;
        let alone = self.false_alarm_rate / map.lines.len().max(1) as f64;
        Ok(map.lines.iter().any(|line| line.chance < alone))
    }

    /// The lines that explain what would be slip: a large map passes for it until it is subtracted.
    fn start(&self, record: &MotionRecord, regressors: &[Vec<f64>], map: &mut EncoderMap) {
        let search = search_of(record);
        let slip = search.run(record).ok();
        let Some(slip) = slip.filter(|s| !s.slip.is_empty()) else {
            return;
        };
        let Some(found) = search.alternative(record, regressors) else {
            return;
        };
        let mut other = map.clone();
        for (line, parts) in other.lines.iter_mut().zip(found.regressors.chunks(2)) {
            (line.cosine, line.sine) = (parts[0], parts[1]);
        }
        if !(found.gained > 0.0 && other.is_map()) {
            return;
        }
        let beside = other.corrected(record).and_then(|less| {
            let right = less.corrected(found.gain, found.latency);
            search.run(&right)
        });
        if beside.is_ok_and(|beside| slip.explained_by(&beside)) {
            *map = other;
        }
    }

    /// The lines that are looked for, before anything was found.
    fn empty(&self, record: &MotionRecord) -> Result<EncoderMap, Error> {
        let line = |order| MapLine {
            order,
            cosine: 0.0,
            sine: 0.0,
            covariance: [[0.0; 2]; 2],
            chance: 1.0,
        };
        Ok(EncoderMap {
            turn: self.turn,
            lines: self.orders(record)?.into_iter().map(line).collect(),
        })
    }

    /// Cycles per turn of the quarters, where counts are read.
    fn quarter(&self, record: &MotionRecord) -> Option<f64> {
        record.increment.map(|count| {
            let order = self.turn / (4.0 * count);
            // A quarter of the counts of a turn, less what the radius was rounded by.
            let whole = order.round();
            match (order / whole - 1.0).abs() < 1e-9 {
                true => whole,
                false => order,
            }
        })
    }

    /// Every order that is looked for.
    fn orders(&self, record: &MotionRecord) -> Result<Vec<f64>, Error> {
        let mut orders = self.orders.clone();
        if self.quarters {
            let quarter = self.quarter(record).ok_or(Error::TooFew {
                name: "counts, whose quarters are asked for",
                needed: 1,
                got: 0,
            })?;
            orders.push(quarter);
        }
        check_orders(&orders)?;
        Ok(orders)
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
}

fn check_orders(orders: &[f64]) -> Result<(), Error> {
    let name = "orders of the encoder map";
    let most = REGRESSORS / 2;
    match orders.len() {
        0 => Err(Error::TooFew {
            name,
            needed: 1,
            got: 0,
        }),
        got if got > most => Err(Error::TooMany { name, most, got }),
        _ => match orders.iter().find(|o| !(**o > 0.0 && o.is_finite())) {
            Some(&value) => Err(Error::OutOfRange {
                name: "order of the encoder map",
                value,
                min: f64::MIN_POSITIVE,
                max: f64::MAX,
            }),
            None => Ok(()),
        },
    }
}

/// What of a record is used, and its noise.
struct Used {
    /// Stretches without slip.
    stretches: Vec<Range<usize>>,
    slip: Option<SlipReport>,
    pairing: Option<Pairing>,
    /// Samples the noise was found on.
    part: Range<usize>,
    tuned: Tuned,
    /// Readings for each one whose rounding is new.
    repeated: f64,
    /// Whether the accelerometer has at least the noise of its floor.
    cautious: bool,
}

impl Used {
    fn of(record: &MotionRecord, tuning: &Tuning, watch: &dyn Watch) -> Result<Self, Error> {
        let ground = Ground::of(record, sensors(record), tuning, watch)?;
        Ok(Self::on(record, ground))
    }

    /// On a record whose noise was found.
    fn on(record: &MotionRecord, ground: Ground) -> Self {
        let Ground {
            slip,
            pairing,
            part: quiet,
            samples,
            tuned,
        } = ground;
        let margin = margin(record);
        let clean = |k: usize| !slip.as_ref().is_some_and(|s| s.slips(k, margin));
        let n = record.reading.len();
        let mut stretches = runs(n, clean);
        stretches.retain(|range| part(record, range.clone()).is_some());
        if stretches.is_empty() {
            stretches.push(0..n);
        }
        let readings = quiet.reading.iter().flatten().count() as f64;
        Self {
            repeated: (readings / tuned.effective_readings).max(1.0),
            stretches,
            slip,
            pairing,
            part: samples,
            tuned,
            cautious: false,
        }
    }

    /// From the smallest to the largest reading that is used.
    fn way(&self, record: &MotionRecord) -> f64 {
        let used = self
            .stretches
            .iter()
            .flat_map(|s| &record.reading[s.clone()]);
        let (low, high) = used
            .flatten()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), r| {
                (a.min(*r), b.max(*r))
            });
        (high - low).max(0.0)
    }

    fn fit(
        &self,
        record: &MotionRecord,
        regressors: &[Vec<f64>],
        map: &mut EncoderMap,
    ) -> Result<(), Error> {
        let mut noise = self.tuned.noise();
        if let Some(floor) = self.tuned.noise_floor.filter(|_| self.cautious) {
            noise.q = noise.q.max(floor);
        }
        let unknowns = self.tuned.unknowns;
        let early = record.corrected(1.0, self.tuned.shift);
        let mut sums = Regression::new(regressors.len());
        for range in &self.stretches {
            let stretch = part(&early, range.clone());
            let stretch = stretch.as_ref().unwrap_or(&early);
            let inside: Vec<&[f64]> = regressors.iter().map(|r| &r[range.clone()]).collect();
            let prepared = Prepared::new(stretch, &self.tuned.model);
            sums.add(&prepared, &noise, unknowns, &inside);
        }
        let found = sums.solve(unknowns).ok_or(Error::Singular {
            name: "lines of the encoder map",
            condition: 1e13,
        })?;
        for (k, line) in map.lines.iter_mut().enumerate() {
            let (i, j) = (2 * k, 2 * k + 1);
            (line.cosine, line.sine) = (found.coefficients[i], found.coefficients[j]);
            // Readings whose rounding repeats tell nothing new.
            let c = |a: usize, b: usize| found.covariance[a][b] * self.repeated;
            line.covariance = [[c(i, i), c(i, j)], [c(j, i), c(j, j)]];
            let [[cc, cs], [_, ss]] = line.covariance;
            let determinant = cc * ss - cs * cs;
            let (x, y) = (line.cosine, line.sine);
            let square = (ss * x * x - 2.0 * cs * x * y + cc * y * y) / determinant;
            line.chance = chi_squared_chance(square.max(0.0), 2.0);
        }
        Ok(())
    }
}

fn findings(map: &EncoderMap, turns: f64, quarter: Option<f64>) -> Vec<Finding> {
    let mut list = Vec::new();
    if turns < 1.0 {
        list.push(findings::encoder_map_part_of_a_turn(turns));
    }
    if !map.lines.is_empty() {
        let told: Vec<String> = map
            .lines
            .iter()
            .map(|l| {
                format!(
                    "{}{} per turn: {:.3e} (u = {:.1e}), {:.2} % of the velocity",
                    if quarter == Some(l.order) {
                        "unequal quarters, "
                    } else {
                        ""
                    },
                    l.order,
                    l.amplitude(),
                    l.amplitude_uncertainty(),
                    100.0 * TAU * l.order * l.amplitude() / map.turn
                )
            })
            .collect();
        list.push(findings::encoder_ripple(&told.join("; ")));
    }
    list
}
