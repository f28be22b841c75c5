//! Where encoder and accelerometer do not see the same motion: slip, and collisions.

mod alternative;
mod collision;

pub(crate) use alternative::Alternative;

use crate::episode::{Episode, episodes, held, largest, others, quiet, shortest, slope};
use crate::findings;
use crate::{MotionRecord, ReadingSource};
use proofmass_core::Error;
use proofmass_core::numeric::upper_median;
use proofmass_uncertainty::Finding;

/// Settings of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SlipSearch {
    /// Window over which velocity changes are compared, s.
    pub window: f64,
    /// Threshold in standard deviations of the quiet part.
    pub threshold: f64,
    /// Duration over which a collision's acceleration is averaged, s.
    pub blow: f64,
}

impl Default for SlipSearch {
    /// 50 ms, eight standard deviations, 20 ms.
    fn default() -> Self {
        Self {
            window: 0.05,
            threshold: 8.0,
            blow: 0.02,
        }
    }
}

/// Slip and collisions of a record, with the standard deviation of the quiet part.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SlipReport {
    /// Encoder and accelerometer disagree.
    pub slip: Vec<Episode>,
    /// Short strong decelerations against the motion; `velocity` is the change of velocity.
    pub collisions: Vec<Episode>,
    /// Standard deviation of the quiet part's disagreement over one window, velocity units.
    pub quiet_deviation: f64,
    /// Share of the record in slip.
    pub slip_share: f64,
    /// In words.
    pub findings: Vec<Finding>,
}

impl SlipReport {
    /// Whether a sample lies in slip, or within `margin` samples of it.
    pub fn slips(&self, sample: usize, margin: usize) -> bool {
        self.slip
            .iter()
            .any(|e| sample + margin >= e.from && sample < e.to + margin)
    }
}

/// Difference of ln L up to which neither of two explanations is preferred for certain.
const CLEAR: f64 = 6.0;

impl SlipReport {
    /// What is slip where gain and latency of the accelerometer may explain it: `beside` is what is left beside them. Collisions
    /// are those of the record as it is.
    pub(crate) fn decided(&self, beside: &Self, other: &Alternative) -> Self {
        let mut decided = match other.gained > 0.0 {
            true => self.with_slip_of(beside),
            false => self.clone(),
        };
        if other.gained.abs() < CLEAR {
            let (gain, latency) = (other.gain, 1e3 * other.latency);
            let doubt = findings::slip_in_doubt(gain, latency, other.gained);
            decided.findings.push(doubt);
        }
        decided
    }

    /// Whether less is slip beside other constants, and the quiet part as quiet: what makes it louder hides slip and explains none.
    pub(crate) fn explained_by(&self, beside: &Self) -> bool {
        beside.slip_share < self.slip_share && beside.quiet_deviation < 1.1 * self.quiet_deviation
    }

    /// The same with another report's slip.
    pub(crate) fn with_slip_of(&self, other: &Self) -> Self {
        let slip = |f: &&Finding| f.code() == "slip";
        let findings = other.findings.iter().filter(slip);
        let own = self.findings.iter().filter(|f| !slip(f));
        Self {
            slip: other.slip.clone(),
            collisions: self.collisions.clone(),
            findings: findings.chain(own).cloned().collect(),
            ..*other
        }
    }
}

impl SlipSearch {
    /// Compares velocity changes over adjacent windows.
    ///
    /// The slope of a line through the readings of the window after a sample minus that before it is a velocity
    /// change; the same functional of the doubly integrated acceleration is another. Their difference is free of
    /// the unknown start and, up to a constant, of an offset. Centre and width of the quiet part come from the
    /// shortest interval that holds 30 % of the differences: up to 70 % of the record may slip.
    ///
    /// # Errors
    /// Of the record; [`Error::TooFew`] when it is shorter than eight windows; [`Error::OutOfRange`] for windows
    /// below four samples.
    pub fn run(&self, record: &MotionRecord) -> Result<SlipReport, Error> {
        record.check()?;
        let dt = record.sample_time;
        let w = (self.window / dt).round() as usize;
        // NaN of a setting lands at zero samples and is refused here.
        if w < 4 {
            return Err(Error::OutOfRange {
                name: "window in samples",
                value: w as f64,
                min: 4.0,
                max: f64::MAX,
            });
        }
        let n = record.reading.len();
        if n < 8 * w {
            return Err(Error::TooFew {
                name: "samples",
                needed: 8 * w,
                got: n,
            });
        }
        let mut difference = changes(&residual(record), w, dt);
        // What was integrated twice drifts by more than an offset.
        if record.behind_two_stages().is_some() {
            take_slow(&mut difference, SLOW * w);
        }
        let judged = judged(record, w, difference.len());
        let known: Vec<f64> = (0..difference.len())
            .filter(|&k| judged[k])
            .map(|k| difference[k])
            .collect();
        let (centre, deviation) = match (record.source, known.is_empty()) {
            (_, true) => quiet(&difference),
            (ReadingSource::Position, _) => quiet(&known),
            // Vibration grows with the speed of a vehicle: the quietest third is not what its drive is like.
            (ReadingSource::Speed, _) => shortest(&known, 0.6, 0.841_621_234),
        };
        let mut difference: Vec<f64> = difference
            .into_iter()
            .zip(&judged)
            .map(|(d, judged)| if *judged { d } else { centre })
            .collect();
        // What is not seen of a change of velocity is no slip.
        for hole in record.holes.iter().filter(|h| h.velocity > 0.5 * deviation) {
            let from = hole.from.saturating_sub(2 * w).min(difference.len());
            let to = (hole.to + 1).clamp(from, difference.len());
            difference[from..to].fill(centre);
        }
        let z = |d: f64| (d - centre) / deviation;
        // Two lines through counts that are each wrong by half an increment at most cannot differ by more.
        let rounding = match record.source {
            ReadingSource::Position => 3.0 * record.increment.unwrap_or(0.0) / (w as f64 * dt),
            ReadingSource::Speed => record.increment.unwrap_or(0.0),
        };
        let slip = episodes(
            &difference,
            |d| z(d).abs() > self.threshold && (d - centre).abs() > rounding,
            w,
            w,
            n,
            |d| (d - centre, z(d)),
        );
        let collisions = self.collisions(record, dt);
        let share = (0..n)
            .filter(|&k| slip.iter().any(|e| (e.from..e.to).contains(&k)))
            .count() as f64
            / n as f64;
        let mut findings = Vec::new();
        for e in largest(&slip) {
            findings.push(findings::slip(
                record.start + e.from as f64 * dt,
                record.start + e.to as f64 * dt,
                1e3 * self.window,
                e.velocity,
                e.deviations,
                deviation,
                &others(&slip),
            ));
        }
        for e in largest(&collisions) {
            findings.push(findings::collision(
                record.start + e.from as f64 * dt,
                record.start + e.to as f64 * dt,
                e.velocity,
                1e3 * self.blow,
                e.deviations,
                &others(&collisions),
            ));
        }
        Ok(SlipReport {
            slip,
            collisions,
            quiet_deviation: deviation,
            slip_share: share,
            findings,
        })
    }
}

/// Windows in a block whose median is what a drift makes there: slip of more than half of it would pass for one.
const SLOW: usize = 20;

/// Takes the line through the medians of neighbouring blocks of a length, each half over the next; the last ends with the values.
fn take_slow(values: &mut [f64], length: usize) {
    let Some(last) = values.len().checked_sub(length + 1) else {
        return;
    };
    let starts = (0..last).step_by((length / 2).max(1)).chain([last]);
    let middle = 0.5 * (length - 1) as f64;
    let medians: Vec<(f64, f64)> = starts
        .filter_map(|from| {
            let mut block = values[from..from + length].to_vec();
            Some((from as f64 + middle, upper_median(&mut block)?))
        })
        .collect();
    let mut i = 0;
    for (k, value) in values.iter_mut().enumerate() {
        let place = k as f64;
        while i + 2 < medians.len() && place > medians[i + 1].0 {
            i += 1;
        }
        if let [(x, a), (y, b), ..] = medians[i..] {
            *value -= a + (place - x) / (y - x) * (b - a);
        }
    }
}

/// Whether there are readings on either side of the windows at each place; of speeds whether they hold readings that change. Where there are none for longer than a window
/// nothing is compared, and a wheel at rest shows no noise.
fn judged(record: &MotionRecord, w: usize, count: usize) -> Vec<bool> {
    let n = record.reading.len();
    let places: Vec<usize> = (0..n).filter(|&k| record.reading[k].is_some()).collect();
    let (first, last) = (places.first().copied(), places.last().copied());
    // Beyond them a reading is held, which is no motion.
    let covered =
        |k: usize| first.is_some_and(|f| f <= k) && last.is_some_and(|l| k + 2 * w <= l + 1);
    // Samples up to each that lie in a gap, and changes of the reading.
    let (mut gaps, mut changes) = (vec![0usize; n + 1], vec![0usize; n + 1]);
    for pair in places.windows(2) {
        if pair[1] - pair[0] > w {
            gaps[pair[0] + 1..pair[1] + 1].fill(1);
        }
        changes[pair[1]] = usize::from(record.reading[pair[0]] != record.reading[pair[1]]);
    }
    for list in [&mut gaps, &mut changes] {
        let mut sum = 0;
        for value in list.iter_mut() {
            sum += *value;
            *value = sum;
        }
    }
    (0..count)
        .map(|k| {
            let within = |list: &[usize]| list[k + 2 * w - 1] - list[k];
            let lively = record.source == ReadingSource::Position || within(&changes) > 0;
            covered(k) && within(&gaps) == 0 && lively
        })
        .collect()
}

/// Slope of a line through the window from each sample on, minus that through the window before it: value k compares the windows
/// that meet at sample k + w.
pub(crate) fn changes(x: &[f64], w: usize, dt: f64) -> Vec<f64> {
    let slopes: Vec<f64> = x.windows(w).map(|part| slope(part, dt)).collect();
    (0..slopes.len() - w)
        .map(|k| slopes[k + w] - slopes[k])
        .collect()
}

/// Doubly integrated acceleration.
fn felt(record: &MotionRecord) -> Vec<f64> {
    let dt = record.sample_time;
    let (mut x, mut v) = (0.0, 0.0);
    let mut before = record.acceleration[0];
    let motion = record.acceleration.iter().map(|a| {
        x += dt * v + dt * dt * (before / 3.0 + a / 6.0);
        v += 0.5 * dt * (before + a);
        before = *a;
        x
    });
    motion.collect()
}

/// Reading minus doubly integrated acceleration; missing readings on a line between their neighbours.
pub(crate) fn residual(record: &MotionRecord) -> Vec<f64> {
    let positions = held(&record.positions());
    let felt = felt(record);
    positions.iter().zip(felt).map(|(p, x)| p - x).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_rig::{AxisMotion, DrivenAxis};

    #[test]
    fn law_slip_is_found_where_it_is_and_nowhere_else() {
        let recording = DrivenAxis::new(AxisMotion::servo(5.0))
            .simulate(11)
            .unwrap();
        let mut position = recording.position();
        let clean = MotionRecord::new(
            1e-3,
            ReadingSource::Position,
            position.clone(),
            recording.acceleration.clone(),
        )
        .unwrap();
        let report = SlipSearch::default().run(&clean).unwrap();
        assert!(report.slip.is_empty(), "{report:?}");
        // The wheel spins 0.3 m/s faster from 2.0 s to 2.2 s.
        for (k, p) in position.iter_mut().enumerate() {
            let t = 1e-3 * k as f64;
            *p = p.map(|p| p + 0.3 * (t - 2.0).clamp(0.0, 0.2));
        }
        let slipping = MotionRecord::new(
            1e-3,
            ReadingSource::Position,
            position,
            recording.acceleration,
        )
        .unwrap();
        let report = SlipSearch::default().run(&slipping).unwrap();
        assert!(!report.slip.is_empty());
        for e in &report.slip {
            assert!(e.from > 1950 && e.to < 2250, "{e:?}");
        }
        assert!(report.slips(2000, 0) && report.slips(2200, 0) && !report.slips(1000, 50));
        let largest = report
            .slip
            .iter()
            .fold(0.0f64, |m, e| m.max(e.velocity.abs()));
        assert!((largest - 0.3).abs() < 0.06, "{largest}");
        assert!(report.findings.iter().any(|f| f.code() == "slip"));
    }

    /// Two explanations that are as likely: the one taken is the likelier, and the doubt is told; a clear one is not doubted.
    #[test]
    fn law_a_doubt_between_slip_and_a_gain_is_told() {
        let report = |slips: bool| SlipReport {
            slip: match slips {
                true => vec![Episode {
                    from: 100,
                    to: 200,
                    velocity: 0.1,
                    deviations: 20.0,
                }],
                false => Vec::new(),
            },
            collisions: Vec::new(),
            quiet_deviation: 0.01,
            slip_share: f64::from(u8::from(slips)) * 0.1,
            findings: Vec::new(),
        };
        let decided = |gained: f64| {
            let other = Alternative {
                gain: 1.02,
                latency: 0.003,
                regressors: Vec::new(),
                gained,
            };
            let decided = report(true).decided(&report(false), &other);
            let doubted = decided.findings.iter().any(|f| f.code() == "slip-in-doubt");
            (decided.slip.is_empty(), doubted)
        };
        assert_eq!(decided(100.0), (true, false));
        assert_eq!(decided(2.0), (true, true));
        assert_eq!(decided(-2.0), (false, true));
        assert_eq!(decided(-100.0), (false, false));
        let doubt = findings::slip_in_doubt(1.02, 3.0, 2.0);
        assert_eq!(doubt.code(), "slip-in-doubt");
    }
}
