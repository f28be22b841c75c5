//! Noise of both sensors, and offset, gain and latency between them, by maximum likelihood.

use crate::counting::CountingTuned;
use crate::diffuse::{ColouredNoise, Noise, Prepared, Solution, Sums, Trajectory, Unknowns};
use crate::filtering::steps;
use crate::floor::{effective_readings, noise_floor, variance};
use crate::search::{line, simplex};
use crate::whiteness::autocorrelation;
use crate::{BiasModel, Hold, KalmanModel, MotionRecord, ProcessNoise, Source, Whiteness};
use proofmass_core::{Error, Watch};
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};

/// Whether R is known or found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "reading-noise")]
pub enum ReadingNoise {
    /// Known: δ²/12, or from a still period.
    Known {
        /// Variance.
        variance: f64,
    },
    /// Found with q; at least δ²/12 where the increment is known.
    Free,
}

/// Whether the accelerometer has an offset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BiasChoice {
    /// No.
    None,
    /// An unknown constant.
    Constant,
    /// A random walk whose density is found too.
    RandomWalk,
    /// The one whose likelihood pays for its parameters.
    Automatic,
}

/// What is tuned.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tuning {
    /// R.
    pub reading_noise: ReadingNoise,
    /// Offset.
    pub bias: BiasChoice,
    /// Whether gain and latency of the accelerometer may be found.
    pub pairing: bool,
    /// Form of q.
    pub noise_form: ProcessNoise,
    /// Acceleration between samples.
    pub interpolation: Hold,
}

impl Default for Tuning {
    fn default() -> Self {
        Self {
            reading_noise: ReadingNoise::Free,
            bias: BiasChoice::Automatic,
            pairing: true,
            noise_form: ProcessNoise::SampleConstant,
            interpolation: Hold::Second,
        }
    }
}

/// A constant that was found, with its standard uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// Value.
    pub value: f64,
    /// Standard uncertainty.
    pub uncertainty: f64,
}

/// The model that makes the readings most probable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tuned {
    /// Noise and offset as a filter on line takes them.
    pub model: KalmanModel,
    /// Offset of the accelerometer (at the start, where it walks), when it has one.
    pub offset: Option<Found>,
    /// Gain of the accelerometer over that of the readings, when it is not one: it reads this times the acceleration.
    pub gain: Option<Found>,
    /// Time by which the accelerometer is later than the readings, s, when it is.
    pub latency: Option<Found>,
    /// Part of the readings' noise that is correlated in time, when there is one.
    pub coloured: Option<ColouredNoise>,
    /// ln L of the chosen model.
    pub log_likelihood: f64,
    /// Variance of an acceleration sample by the quietest part of its spectrum.
    pub noise_floor: Option<f64>,
    /// Readings with a rounding of their own; fewer than there are where it repeats with the motion.
    pub effective_readings: f64,
    /// Half width of ln q at which likelihood and floor together have fallen by 1.92 (95 %), below and above; `None`
    /// at a bound.
    pub log_q_interval: Option<(f64, f64)>,
    /// Profile of the likelihood: q, and ln L (with the floor) below its maximum there.
    pub profile: Vec<(f64, f64)>,
    /// Test of the innovations.
    pub whiteness: Whiteness,
    /// Correlation of the innovations at lags 0, 1, …
    pub autocorrelation: Vec<f64>,
    /// Number of passes over the record.
    pub passes: usize,
    /// What to doubt.
    pub findings: Vec<Finding>,
    /// Noise as likely as the found one is: places at which the smoother is averaged.
    pub(crate) nodes: Vec<NoiseNode>,
    /// Which constants are solved for.
    pub(crate) unknowns: Unknowns,
    /// Part of the latency that was taken off before, s.
    pub(crate) shift: f64,
}

/// Noise of one place around the maximum.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoiseNode {
    /// q
    pub acceleration: f64,
    /// White part of R.
    pub reading: f64,
    /// Density of the walk.
    pub walk: Option<f64>,
    /// Coloured part of the readings.
    pub coloured: Option<ColouredNoise>,
}

impl NoiseNode {
    fn noise(&self, form: ProcessNoise) -> Noise {
        Noise {
            q: self.acceleration,
            form,
            r: self.reading,
            walk: self.walk,
            colour: self.coloured.map(|c| (c.deviation * c.deviation, c.time)),
        }
    }

    fn of(noise: &Noise) -> Self {
        Self {
            acceleration: noise.q,
            reading: noise.r,
            walk: noise.walk,
            coloured: noise.colour.map(|(variance, time)| ColouredNoise {
                deviation: variance.sqrt(),
                time,
            }),
        }
    }
}

/// Range of log₁₀(q T⁴/R): from a filter that forgets in 10⁵ samples to one that follows every reading.
const RATIO: (f64, f64) = (-20.0, 5.0);
/// Least number of readings.
const LEAST: usize = 24;
/// Standard deviation of ln q around the floor, below and above it.
const PRIOR: (f64, f64) = (0.8, 0.5);
/// Half the 95 % point of χ²(1).
const FALL: f64 = 1.92;
const LN10: f64 = std::f64::consts::LN_10;

impl Tuning {
    /// Finds noise, offset, gain and latency for a record.
    ///
    /// Start, offset, gain and latency are unknown constants without any prior. The accelerometer's own floor (Welch)
    /// holds q where the readings leave it open: ln q is normal about ln of the floor, 0.8 below and 0.5 above it, and
    /// q never exceeds the variance of the acceleration. Each further parameter has to raise ln L by ½ ln n_e · n/n_e,
    /// with the number n_e of readings whose rounding is new. R is at least δ²/12.
    ///
    /// **Assumes** white noise of the accelerometer, and of readings of position; that of a speed may have a part
    /// that is correlated in time.
    /// **Accuracy** coverage after tuning: `tests/tuned_coverage.rs`.
    /// **Source** `[DeJong91]`, `[Schweppe65]`, `[Schwarz78]`; `[Welch1967]` for the floor.
    ///
    /// # Errors
    /// Of the record; [`Error::TooFew`] below 24 readings; [`Error::OutOfRange`] for a known variance that is
    /// not positive; [`Error::Cancelled`].
    pub fn run(&self, record: &MotionRecord, watch: &dyn Watch) -> Result<Tuned, Error> {
        self.search(record, false, watch)
    }

    /// The same; `late` where a latency is known to be there.
    pub(crate) fn search(
        &self,
        record: &MotionRecord,
        late: bool,
        watch: &dyn Watch,
    ) -> Result<Tuned, Error> {
        record.check()?;
        let readings = record.reading.iter().flatten().count();
        if readings < LEAST {
            return Err(Error::TooFew {
                name: "readings",
                needed: LEAST,
                got: readings,
            });
        }
        let known = match self.reading_noise {
            ReadingNoise::Known { variance } if variance.is_finite() && variance > 0.0 => {
                Some(variance)
            }
            ReadingNoise::Known { variance } => {
                return Err(Error::OutOfRange {
                    name: "reading noise",
                    value: variance,
                    min: f64::MIN_POSITIVE,
                    max: f64::MAX,
                });
            }
            ReadingNoise::Free => None,
        };
        let mut search = Search::new(self, record, known, watch);
        let mut point = search.base(Unknowns::default())?;
        let mut repeats = None;
        if known.is_none()
            && let Some(rounding) = search.rounding
            && point.noise.r < rounding
        {
            repeats = Some(point.noise.r);
            search.known = Some(rounding);
            point = search.base(Unknowns::default())?;
        }
        // Whether gain and latency pay is judged by residuals that know neither.
        let whitened = search.prepared.innovations(&point.noise, &point.solution);
        search.effective = effective_readings(&whitened);
        search.late = late;
        if late || (self.pairing && search.moves()) {
            point = search.base(Unknowns {
                gain: true,
                latency: true,
                ..Unknowns::default()
            })?;
        } else {
            point.value = search.rated(&point);
        }
        if matches!(self.bias, BiasChoice::Automatic | BiasChoice::RandomWalk)
            && let Some(walk) = search.walk(&point)?
            && (walk.value > point.value || self.bias == BiasChoice::RandomWalk)
        {
            point = walk;
        }
        if record.source == Source::Speed
            && let Some(coloured) = search.coloured(&point)?
            && coloured.value > point.value
        {
            point = coloured;
        }
        search.tuned(point, repeats, readings)
    }
}

/// A model with its value: ln L + ln prior − price.
#[derive(Clone)]
struct Point {
    noise: Noise,
    unknowns: Unknowns,
    solution: Solution,
    log_likelihood: f64,
    value: f64,
}

struct Search<'a> {
    tuning: &'a Tuning,
    record: &'a MotionRecord,
    prepared: Prepared<'a>,
    watch: &'a dyn Watch,
    known: Option<f64>,
    /// δ²/12.
    rounding: Option<f64>,
    floor: Option<f64>,
    /// Largest q: the variance of the acceleration.
    ceiling: f64,
    /// Root of the mean square by which the steps differ from those of straight lines, over that of the steps.
    bend: f64,
    effective: f64,
    readings: f64,
    late: bool,
    passes: usize,
}

impl<'a> Search<'a> {
    fn new(
        tuning: &'a Tuning,
        record: &'a MotionRecord,
        known: Option<f64>,
        watch: &'a dyn Watch,
    ) -> Self {
        let model = KalmanModel {
            interpolation: tuning.interpolation,
            ..KalmanModel::new(0.0, 1.0)
        };
        // A density counts over one sample time.
        let unit = match tuning.noise_form {
            ProcessNoise::SampleConstant => 1.0,
            ProcessNoise::Continuous => record.sample_time,
        };
        let readings = record.reading.iter().flatten().count() as f64;
        Self {
            tuning,
            record,
            prepared: Prepared::new(record, &model),
            watch,
            known,
            rounding: record
                .increment
                .or_else(|| resolution(record))
                .map(|d| d * d / 12.0),
            floor: noise_floor(&record.acceleration)
                .filter(|q| *q > 0.0)
                .map(|q| unit * q),
            ceiling: unit * variance(&record.acceleration).max(f64::MIN_POSITIVE),
            bend: bend(record, &model),
            effective: readings,
            readings,
            late: false,
            passes: 0,
        }
    }

    /// Whether the acceleration stands clear of its own noise, in a motion that the samples follow: at fewer than some
    /// thirteen samples per period what a curve through them loses would pass for gain and latency.
    fn moves(&self) -> bool {
        let noise = self.floor.map_or(0.0, |floor| floor / self.ceiling);
        // White noise alone bends the steps by 0.17.
        let bend = self.bend * self.bend - 0.17 * 0.17 * noise;
        noise < 0.01 && bend < 0.02 * 0.02
    }

    /// What one parameter more has to bring.
    fn price(&self) -> f64 {
        0.5 * self.effective.ln() * self.readings / self.effective
    }

    fn prior(&self, q: f64) -> f64 {
        // Bounds are soft by a rounding, so that the grid's ends count.
        if q > self.ceiling * 1.001 {
            return f64::NEG_INFINITY;
        }
        let Some(floor) = self.floor else { return 0.0 };
        if q < 0.999e-6 * floor {
            return f64::NEG_INFINITY;
        }
        let off = (q / floor).ln();
        let width = if off < 0.0 { PRIOR.0 } else { PRIOR.1 };
        -0.5 * (off / width).powi(2)
    }

    fn sums(&mut self, noise: &Noise) -> Result<Sums, Error> {
        self.passes += 1;
        // The total is not known before the end.
        self.watch.step("likelihood", self.passes as u64, 0)?;
        Ok(self
            .prepared
            .sums(noise, self.tuning.pairing && self.moves()))
    }

    fn subsets(&self, allowed: Unknowns) -> Vec<Unknowns> {
        let offsets: &[bool] = match self.tuning.bias {
            BiasChoice::None => &[false],
            BiasChoice::Automatic => &[false, true],
            BiasChoice::Constant | BiasChoice::RandomWalk => &[true],
        };
        let both: &[bool] = &[false, true];
        let mut list = Vec::new();
        for &offset in offsets {
            for &gain in both.iter().filter(|g| allowed.gain || !**g) {
                for &latency in both.iter().filter(|l| allowed.latency || !**l) {
                    if self.late && !latency {
                        continue;
                    }
                    list.push(Unknowns {
                        offset,
                        gain,
                        latency,
                    });
                }
            }
        }
        list
    }

    /// The best of some subsets for noise up to a common factor, or as it is where R is known.
    fn best(&mut self, noise: &Noise, subsets: &[Unknowns]) -> Result<Option<Point>, Error> {
        let sums = self.sums(noise)?;
        let mut best: Option<Point> = None;
        for &unknowns in subsets {
            let Some(solution) = sums.solve(self.record, unknowns) else {
                continue;
            };
            let (log_likelihood, noise) = if self.known.is_some() {
                (sums.log_likelihood(&solution), *noise)
            } else {
                let (value, factor) = sums.concentrated(&solution);
                (value, noise.scaled(factor))
            };
            let mut point = Point {
                noise,
                unknowns,
                solution,
                log_likelihood,
                value: 0.0,
            };
            point.value = self.rated(&point);
            if point.value.is_finite() && best.as_ref().is_none_or(|b| point.value > b.value) {
                best = Some(point);
            }
        }
        Ok(best)
    }

    fn rated(&self, point: &Point) -> f64 {
        let Unknowns {
            offset,
            gain,
            latency,
        } = point.unknowns;
        let extra = [
            offset,
            gain,
            latency,
            point.noise.walk.is_some(),
            point.noise.colour.is_some(),
            point.noise.colour.is_some(),
        ];
        let k = extra.into_iter().filter(|x| *x).count() as f64;
        point.log_likelihood + self.prior(point.noise.q) - k * self.price()
    }

    /// q in the unit in which R = 1 and T = 1.
    fn unit(&self) -> f64 {
        let dt = self.record.sample_time;
        let form = match self.tuning.noise_form {
            ProcessNoise::SampleConstant => dt.powi(4),
            ProcessNoise::Continuous => dt.powi(3),
        };
        // A speed has one integration less.
        match self.record.source {
            Source::Position => form,
            Source::Speed => form / (dt * dt),
        }
    }

    fn white(&self, q: f64, r: f64) -> Noise {
        Noise {
            q,
            form: self.tuning.noise_form,
            r,
            walk: None,
            colour: None,
        }
    }

    /// Best q, R and constants of the allowed kinds, without walk and colour.
    fn base(&mut self, allowed: Unknowns) -> Result<Point, Error> {
        let subsets = self.subsets(allowed);
        let unit = self.unit();
        let (low, high) = match (self.known, self.floor) {
            (Some(_), Some(floor)) => ((1e-6 * floor).log10(), self.ceiling.log10()),
            (Some(r), None) => (
                (10f64.powf(RATIO.0) * r / unit).log10(),
                (10f64.powf(RATIO.1) * r / unit).min(self.ceiling).log10(),
            ),
            (None, _) => RATIO,
        };
        let mut best: Option<Point> = None;
        let known = self.known;
        line(low.min(high), high, 1.0, 0.01, |at| {
            let noise = match known {
                Some(r) => self.white(10f64.powf(at), r),
                None => self.white(10f64.powf(at) / unit, 1.0),
            };
            let found = self.best(&noise, &subsets)?;
            let value = found.as_ref().map_or(-1e300, |p| p.value);
            if let Some(point) = found
                && best.as_ref().is_none_or(|b| point.value > b.value)
            {
                best = Some(point);
            }
            Ok(value)
        })?;
        best.ok_or(Error::NotConverged {
            name: "likelihood",
            iterations: self.passes,
            step: f64::INFINITY,
        })
    }

    /// The best random walk of the offset, from places over the whole plane.
    fn walk(&mut self, base: &Point) -> Result<Option<Point>, Error> {
        let unknowns = Unknowns {
            offset: true,
            ..base.unknowns
        };
        let found = base.noise.q.log10();
        let floor = self.floor.map_or(found - 3.0, f64::log10);
        let mut start: Option<([f64; 2], f64)> = None;
        for ratio in [-8.0, -6.0, -4.0, -2.0, 0.0] {
            for q in [found, found - 1.0, found - 2.0, floor] {
                let x = [q, ratio];
                let value = self
                    .walk_at(&x, base, unknowns)?
                    .map_or(-1e300, |p| p.value);
                if start.is_none_or(|(_, v)| value > v) {
                    start = Some((x, value));
                }
            }
        }
        let Some((start, _)) = start else {
            return Ok(None);
        };
        let mut best: Option<Point> = None;
        simplex(start, 0.7, 150, |x| {
            let point = self.walk_at(x, base, unknowns)?;
            let value = point.as_ref().map_or(-1e300, |p| p.value);
            if let Some(point) = point
                && best.as_ref().is_none_or(|b| point.value > b.value)
            {
                best = Some(point);
            }
            Ok(value)
        })?;
        Ok(best)
    }

    /// log₁₀ q (where R is free: in units of the R that was found) and log₁₀ s/q.
    fn walk_at(
        &mut self,
        x: &[f64; 2],
        base: &Point,
        unknowns: Unknowns,
    ) -> Result<Option<Point>, Error> {
        let q = 10f64.powf(x[0]);
        let noise = Noise {
            walk: Some(q * 10f64.powf(x[1])),
            ..self.white(q, base.noise.r)
        };
        self.best(&noise, &[unknowns])
    }

    /// The best coloured noise of the readings. The white part is the rounding, or what was found without colour.
    fn coloured(&mut self, base: &Point) -> Result<Option<Point>, Error> {
        let r = self.known.or(self.rounding).unwrap_or(0.01 * base.noise.r);
        let before = self.known.replace(r);
        let found = self.coloured_beside(base, r);
        self.known = before;
        Ok(found?.filter(|p| {
            p.noise
                .colour
                .is_some_and(|(variance, _)| variance > 10.0 * r)
        }))
    }

    fn coloured_beside(&mut self, base: &Point, r: f64) -> Result<Option<Point>, Error> {
        let dt = self.record.sample_time;
        let duration = dt * self.record.reading.len() as f64;
        let (short, long) = (3.0 * dt, 0.1 * duration);
        if long <= short {
            return Ok(None);
        }
        let q = self.floor.unwrap_or(base.noise.q).log10();
        let unknowns = base.unknowns;
        // Best start of every correlation time.
        let mut starts: Vec<([f64; 3], f64)> = Vec::new();
        for i in 0..5 {
            let time = short.log10() + (long / short).log10() * f64::from(i) / 4.0;
            let mut own: Option<([f64; 3], f64)> = None;
            for decade in 0..7 {
                let x = [q, 0.5 + f64::from(decade) + r.log10(), time];
                let point = self.coloured_at(&x, r, unknowns)?;
                let value = point.map_or(-1e300, |p| p.value);
                if own.is_none_or(|(_, v)| value > v) {
                    own = Some((x, value));
                }
            }
            starts.extend(own);
        }
        starts.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut list: Vec<[f64; 3]> = starts.iter().take(2).map(|(x, _)| *x).collect();
        if let Some(first) = list.first() {
            // From one start alone two of six long records ended far below the maximum.
            list.push([first[0] - 1.0, first[1], first[2]]);
        }
        let mut best: Option<Point> = None;
        for start in list {
            simplex(start, 0.7, 150, |x| {
                let point = self.coloured_at(x, r, unknowns)?;
                let value = point.as_ref().map_or(-1e300, |p| p.value);
                if let Some(point) = point
                    && best.as_ref().is_none_or(|b| point.value > b.value)
                {
                    best = Some(point);
                }
                Ok(value)
            })?;
        }
        Ok(best)
    }

    /// log₁₀ of q, of the variance and of the correlation time.
    fn coloured_at(
        &mut self,
        x: &[f64; 3],
        r: f64,
        unknowns: Unknowns,
    ) -> Result<Option<Point>, Error> {
        let dt = self.record.sample_time;
        let longest = dt * self.record.reading.len() as f64;
        let time = 10f64.powf(x[2]);
        if !(0.1 * dt..longest).contains(&time) {
            return Ok(None);
        }
        let noise = Noise {
            colour: Some((10f64.powf(x[1]), time)),
            ..self.white(10f64.powf(x[0]), r)
        };
        self.best(&noise, &[unknowns])
    }

    /// Value at noise whose parameters are moved by decades.
    fn moved(&mut self, point: &Point, by: &[f64]) -> Result<f64, Error> {
        let noise = shifted(&point.noise, by);
        Ok(self
            .best(&noise, &[point.unknowns])?
            .map_or(-1e300, |p| p.value))
    }

    /// Everything that is told about the chosen model.
    fn tuned(
        mut self,
        mut point: Point,
        repeats: Option<f64>,
        readings: usize,
    ) -> Result<Tuned, Error> {
        if point.noise.colour.is_some() {
            self.known = Some(point.noise.r);
        }
        if self.effective < self.readings {
            point.solution.widen(self.readings / self.effective);
        }
        let profile = self.profile(&point)?;
        let d = parameters(&point.noise);
        let curvature = self.curvature(&point, d)?;
        let interval = if d == 1 {
            self.interval(&point)?
        } else {
            // With the other parameters at their best: the quadratic form.
            curvature.as_ref().map(|spread| {
                let variance: f64 = spread.iter().map(|x| x[0] * x[0]).sum();
                let half = 1.96 * variance.sqrt() * LN10;
                (half, half)
            })
        };
        let mut nodes = Vec::new();
        if let Some(spread) = &curvature {
            for direction in spread {
                for sign in [-1.0, 1.0] {
                    let by: Vec<f64> = direction
                        .iter()
                        .map(|x| sign * (d as f64).sqrt() * x)
                        .collect();
                    let noise = shifted(&point.noise, &by);
                    if let Some(p) = self.best(&noise, &[point.unknowns])? {
                        nodes.push(NoiseNode::of(&p.noise));
                    }
                }
            }
        }
        if nodes.is_empty() {
            nodes.push(NoiseNode::of(&point.noise));
        }
        let innovations = self.prepared.innovations(&point.noise, &point.solution);
        let whiteness = Whiteness::test(&innovations)?;
        let correlation = autocorrelation(&innovations, whiteness.lags);
        let found = |pair: Option<(f64, f64)>| {
            pair.map(|(value, uncertainty)| Found { value, uncertainty })
        };
        let offset = found(point.solution.offset());
        let gain = point.solution.gain().map(|(g, u)| {
            let gain = 1.0 / (1.0 - g);
            Found {
                value: gain,
                uncertainty: u * gain * gain,
            }
        });
        let mut findings = Vec::new();
        if let Some(r) = repeats {
            findings.push(rounding_repeats(r, point.noise.r));
        }
        findings.extend(at_bound(&point.noise, self.unit()));
        findings.extend(resting(self.record));
        findings.extend(not_white(&whiteness, &correlation));
        let model = KalmanModel {
            acceleration_noise: point.noise.q,
            noise_form: point.noise.form,
            // On line the correlated part counts as white.
            reading_noise: point.noise.r + point.noise.colour.map_or(0.0, |(v, _)| v),
            bias: offset.map(|b| BiasModel::RandomWalk {
                density: point.noise.walk.unwrap_or(0.0),
                initial: 3.0 * b.value.abs() + 3.0 * b.uncertainty,
            }),
            interpolation: self.tuning.interpolation,
        };
        Ok(Tuned {
            model,
            offset,
            gain,
            latency: found(point.solution.latency()),
            coloured: NoiseNode::of(&point.noise).coloured,
            log_likelihood: point.log_likelihood,
            noise_floor: self.floor,
            effective_readings: self.effective.min(readings as f64),
            log_q_interval: interval,
            profile,
            whiteness,
            autocorrelation: correlation,
            passes: self.passes,
            findings,
            nodes,
            unknowns: point.unknowns,
            shift: 0.0,
        })
    }

    /// ln L + ln prior below its maximum over two decades of q either way, the other parameters held.
    fn profile(&mut self, point: &Point) -> Result<Vec<(f64, f64)>, Error> {
        let mut list = Vec::new();
        for k in -16..=16 {
            let by = 0.125 * f64::from(k);
            let noise = shifted(&point.noise, &[by]);
            if let Some(p) = self.best(&noise, &[point.unknowns])? {
                list.push((p.noise.q, p.value - point.value));
            }
        }
        Ok(list)
    }

    /// Where ln L + ln prior has fallen by half the 95 % point of χ²(1).
    fn interval(&mut self, point: &Point) -> Result<Option<(f64, f64)>, Error> {
        let mut half = [0.0; 2];
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let (mut inside, mut outside) = (0.0, 0.02);
            while point.value - self.moved(point, &[sign * outside])? < FALL {
                inside = outside;
                outside *= 2.0;
                if outside > 4.0 {
                    return Ok(None);
                }
            }
            for _ in 0..8 {
                let middle = 0.5 * (inside + outside);
                if point.value - self.moved(point, &[sign * middle])? < FALL {
                    inside = middle;
                } else {
                    outside = middle;
                }
            }
            half[side] = outside * LN10;
        }
        Ok(Some((half[0], half[1])))
    }

    /// Columns of a square root of the covariance of the log₁₀ parameters, from second differences over a tenth of a
    /// decade. No direction is taken as wider than half a decade. `None` where the maximum is none.
    fn curvature(&mut self, point: &Point, d: usize) -> Result<Option<Vec<Vec<f64>>>, Error> {
        const STEP: f64 = 0.1;
        let unit = |i: usize, s: f64| {
            let mut x = vec![0.0; d];
            x[i] = s * STEP;
            x
        };
        let centre = self.moved(point, &vec![0.0; d])?;
        let mut h = vec![vec![0.0; d]; d];
        for i in 0..d {
            let up = self.moved(point, &unit(i, 1.0))?;
            let down = self.moved(point, &unit(i, -1.0))?;
            h[i][i] = -(up - 2.0 * centre + down) / (STEP * STEP);
            for j in 0..i {
                let mut corner = |a: f64, b: f64| {
                    let mut x = unit(i, a);
                    x[j] = b * STEP;
                    self.moved(point, &x)
                };
                let mixed = corner(1.0, 1.0)? - corner(1.0, -1.0)? - corner(-1.0, 1.0)?
                    + corner(-1.0, -1.0)?;
                h[i][j] = -mixed / (4.0 * STEP * STEP);
                h[j][i] = h[i][j];
            }
        }
        if h.iter()
            .flatten()
            .any(|x| !x.is_finite() || x.abs() > 1e200)
        {
            return Ok(None);
        }
        let (values, vectors) = jacobi(h);
        Ok(Some(
            (0..d)
                .map(|k| {
                    // Half a decade at most: 1/h ≤ ¼, also where the difference found no maximum.
                    let root = (1.0 / values[k].max(4.0)).sqrt();
                    (0..d).map(|i| vectors[i][k] * root).collect()
                })
                .collect(),
        ))
    }
}

/// Step of the digits in which a speed was logged, where its values lie on such steps.
fn resolution(record: &MotionRecord) -> Option<f64> {
    if record.source != Source::Speed {
        return None;
    }
    let values: Vec<f64> = record.reading.iter().flatten().copied().collect();
    let largest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let steps = || {
        values
            .windows(2)
            .map(|w| (w[1] - w[0]).abs())
            .filter(|d| *d > 1e-12 * largest)
    };
    let least = steps().fold(f64::INFINITY, f64::min);
    let off = |d: f64| (d / least - (d / least).round()).abs() > 1e-3 * (d / least).max(1.0).sqrt();
    // Steps of a ten-thousandth of the range are digits of a number, not of a sensor.
    (least.is_finite() && least > 1e-6 * largest && !steps().any(off)).then_some(least)
}

/// Bend of the velocity's steps against straight lines between the samples.
fn bend(record: &MotionRecord, model: &KalmanModel) -> f64 {
    let Some(curve) = steps(record, model) else {
        return 0.0;
    };
    let half = 0.5 * record.sample_time;
    let (mut off, mut all) = (0.0, 0.0);
    for (w, [_, dv]) in record.acceleration.windows(2).zip(&curve[1..]) {
        off += (dv - half * (w[0] + w[1])).powi(2);
        all += dv * dv;
    }
    if all > 0.0 { (off / all).sqrt() } else { 0.0 }
}

/// Number of parameters of the noise beside a common scale.
fn parameters(noise: &Noise) -> usize {
    1 + usize::from(noise.walk.is_some()) + 2 * usize::from(noise.colour.is_some())
}

/// Noise with q, then the walk or the coloured variance and time, moved by decades.
fn shifted(noise: &Noise, by: &[f64]) -> Noise {
    let factor = |i: usize| 10f64.powf(by.get(i).copied().unwrap_or(0.0));
    Noise {
        q: noise.q * factor(0),
        // The walk keeps its place when q moves.
        walk: noise.walk.map(|s| s * factor(1)),
        colour: noise.colour.map(|(v, t)| (v * factor(1), t * factor(2))),
        ..*noise
    }
}

/// Eigenvalues and vectors (in columns) of a small symmetric matrix by Jacobi's rotations.
fn jacobi(mut a: Vec<Vec<f64>>) -> (Vec<f64>, Vec<Vec<f64>>) {
    let n = a.len();
    let mut v: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect())
        .collect();
    for _ in 0..50 {
        let off: f64 = (0..n)
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .map(|(i, j)| a[i][j].abs())
            .sum();
        if off < 1e-300 {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                if a[p][q] == 0.0 {
                    continue;
                }
                let theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
                let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let t = if theta == 0.0 { 1.0 } else { t };
                let c = 1.0 / t.hypot(1.0);
                let s = t * c;
                for k in 0..n {
                    let (x, y) = (a[k][p], a[k][q]);
                    (a[k][p], a[k][q]) = (c * x - s * y, s * x + c * y);
                }
                for k in 0..n {
                    let (x, y) = (a[p][k], a[q][k]);
                    (a[p][k], a[q][k]) = (c * x - s * y, s * x + c * y);
                }
                for row in &mut v {
                    let (x, y) = (row[p], row[q]);
                    (row[p], row[q]) = (c * x - s * y, s * x + c * y);
                }
            }
        }
    }
    ((0..n).map(|i| a[i][i]).collect(), v)
}

/// What a smoother does with offset, gain and latency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Constants {
    /// Found from the record it smooths.
    Fitted,
    /// Held as they were tuned.
    Held,
}

impl Tuned {
    /// Puts the noise that was found from the edges of counts in place of that of all readings.
    pub(crate) fn counted(
        &mut self,
        found: &CountingTuned,
        innovations: &[f64],
    ) -> Result<(), Error> {
        self.model.acceleration_noise = found.model.acceleration_noise;
        self.log_q_interval = found.log_q_interval;
        self.findings
            .retain(|f| !matches!(f.code(), "innovations-not-white" | "rounding-repeats"));
        if innovations.len() >= 20 {
            self.whiteness = Whiteness::test(innovations)?;
            self.autocorrelation = autocorrelation(innovations, self.whiteness.lags);
        }
        Ok(())
    }

    /// Takes back a shift of the accelerometer that was made before the tuning: what is told is all of the latency, and
    /// the smoother starts from the shift.
    pub(crate) fn shifted_before(&mut self, shift: f64) {
        self.shift = shift;
        if let Some(latency) = &mut self.latency {
            latency.value += shift;
        }
    }

    /// The record with gain and latency of the accelerometer put right as found.
    pub fn corrected(&self, record: &MotionRecord) -> MotionRecord {
        record.corrected(
            self.gain.map_or(1.0, |g| g.value),
            self.latency.map_or(0.0, |t| t.value),
        )
    }

    /// Velocity by the smoother of the found model, the uncertainty of its parameters and constants included.
    ///
    /// Mean over the nodes around the maximum; the variance is the mean variance plus the spread of the values. Offset,
    /// gain and latency are found anew from all of the record, or held as they were found (a record with slip).
    ///
    /// # Errors
    /// Of the record; [`Error::TooFew`] when its readings do not determine the constants; [`Error::NotFinite`].
    pub(crate) fn smooth(
        &self,
        record: &MotionRecord,
        constants: Constants,
    ) -> Result<Trajectory, Error> {
        record.check()?;
        let walks = self.nodes.iter().any(|n| n.walk.is_some());
        let (unknowns, corrected) = match constants {
            Constants::Fitted if self.shift == 0.0 => (self.unknowns, None),
            Constants::Fitted => (self.unknowns, Some(record.corrected(1.0, self.shift))),
            Constants::Held => {
                let mut corrected = self.corrected(record);
                if !walks {
                    let offset = self.offset.map_or(0.0, |b| b.value);
                    corrected.acceleration.iter_mut().for_each(|a| *a -= offset);
                }
                let unknowns = Unknowns {
                    offset: walks,
                    ..Unknowns::default()
                };
                (unknowns, Some(corrected))
            }
        };
        let record = corrected.as_ref().unwrap_or(record);
        let prepared = Prepared::new(record, &self.model);
        let n = record.reading.len();
        let share = 1.0 / self.nodes.len() as f64;
        let few = || Error::TooFew {
            name: "readings for the constants of the model",
            needed: 8,
            got: record.reading.iter().flatten().count(),
        };
        let mut runs = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let noise = node.noise(self.model.noise_form);
            let sums = prepared.sums(&noise, unknowns.gain || unknowns.latency);
            let mut solution = sums.solve(record, unknowns).ok_or_else(few)?;
            solution.widen((sums.n as f64 / self.effective_readings).max(1.0));
            runs.push(prepared.smooth(&noise, &solution)?);
        }
        let mix = |value: &dyn Fn(&Trajectory) -> (&[f64], &[f64])| {
            let (mut mean, mut u) = (vec![0.0; n], vec![0.0; n]);
            for run in &runs {
                for (m, v) in mean.iter_mut().zip(value(run).0) {
                    *m += share * v;
                }
            }
            for run in &runs {
                let (v, own) = value(run);
                for k in 0..n {
                    u[k] += share * (own[k] * own[k] + (v[k] - mean[k]).powi(2));
                }
            }
            u.iter_mut().for_each(|u| *u = u.sqrt());
            (mean, u)
        };
        let (velocity, uncertainty) = mix(&|t| (&t.velocity, &t.uncertainty));
        let offset = runs[0].offset.is_some().then(|| {
            mix(&|t| match &t.offset {
                Some((v, u)) => (v, u),
                None => (&t.velocity, &t.uncertainty),
            })
        });
        Ok(Trajectory {
            velocity,
            uncertainty,
            offset,
            innovations: runs.swap_remove(0).innovations,
        })
    }
}

/// Rounding that repeats with the motion (whole samples per period, or an axis that rests) passes for motion: the
/// readings then fit better than their increment allows.
fn rounding_repeats(found: f64, rounding: f64) -> Finding {
    Finding::new(
        Severity::Note,
        "rounding-repeats",
        "the readings seem better than their increment: its rounding repeats with the motion, and the noise of a reading was set to it",
    )
    .evidence(format!(
        "found {:.2e}, increment over the root of twelve {:.2e}",
        found.sqrt(),
        rounding.sqrt()
    ))
    .advice("a sample rate that is no multiple of the motion's frequency lets the rounding average")
}

fn at_bound(noise: &Noise, unit: f64) -> Option<Finding> {
    let ratio = (noise.q * unit / noise.r).log10();
    (ratio <= RATIO.0 + 0.1 || ratio >= RATIO.1 - 0.1).then(|| {
        Finding::new(
            Severity::Warning,
            "likelihood-at-bound",
            "one sensor is ignored: the likelihood has no maximum inside the searched range",
        )
        .evidence(format!("log10(q T^4/R) = {ratio:.1} of {RATIO:?}"))
        .advice("check that both sensors move and share unit and sense")
    })
}

/// Equal readings in a row that count as resting.
const LONG_RUN: usize = 20;

/// Readings that mostly stand in long runs of equal ones.
fn resting(record: &MotionRecord) -> Option<Finding> {
    let readings: Vec<f64> = record.reading.iter().flatten().copied().collect();
    let resting: usize = readings
        .chunk_by(|a, b| a == b)
        .map(<[f64]>::len)
        .filter(|&n| n >= LONG_RUN)
        .sum();
    let share = resting as f64 / readings.len().max(1) as f64;
    (share > 0.3).then(|| {
        Finding::new(
            Severity::Note,
            "slow-quantised-readings",
            "the readings rest on one value for long stretches: they were used at the edges, where they change",
        )
        .evidence(format!(
            "{:.0} % of the readings lie in runs of {LONG_RUN} and more equal ones",
            100.0 * share
        ))
        .advice("timed edges know more where the axis is slow")
    })
}

/// Largest inflation of a variance by correlation that is still called white: the standard uncertainty is then wrong
/// by less than half.
const INFLATION: f64 = 2.25;

/// Correlated innovations, where the correlation is large enough to matter, whatever its significance.
fn not_white(whiteness: &Whiteness, correlation: &[f64]) -> Option<Finding> {
    let sum: f64 = correlation.iter().skip(1).sum();
    let inflation = 1.0 + 2.0 * sum;
    let matters = inflation > INFLATION;
    (whiteness.p_white < 1e-3 && matters).then(|| {
        let (lag, rho) = whiteness.largest_correlation;
        Finding::new(
            Severity::Warning,
            "innovations-not-white",
            "the innovations are correlated: the model does not describe both sensors",
        )
        .evidence(format!(
            "the variance of their mean over {} lags is {inflation:.2} times that of white ones; correlation {rho:.3} at lag {lag} (Ljung-Box p = {:.1e})",
            whiteness.lags, whiteness.p_white
        ))
        .advice("look for slip, a gain error, a latency that changes, or an error of the encoder that repeats; the stated uncertainty is then a lower bound")
    })
}
