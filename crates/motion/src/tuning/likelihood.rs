//! Likelihood of noise and constants, and where it is largest.

use super::{BiasChoice, Point, Search, Tuning};
use crate::diffuse::{Noise, Prepared, Sums, Unknowns};
use crate::floor::{noise_floor, variance};
use crate::search::line;
use crate::step_input::curve;
use crate::threshold::speed_increment;
use crate::velocity::tied;
use crate::{KalmanModel, MotionRecord, ProcessNoise, ReadingSource};
use proofmass_core::{Error, Watch};

/// Range of log₁₀(q T⁴/R): from a filter that forgets in 10⁵ samples to one that follows every reading.
pub(super) const RATIO: (f64, f64) = (-20.0, 5.0);
/// Highest log₁₀(q T⁴/R) where nothing but q moves the axis: readings of eight digits are followed exactly.
const EXACT: f64 = 17.0;
/// Standard deviation of ln q around the floor, below and above it.
pub(crate) const PRIOR: (f64, f64) = (0.4, 0.5);

impl<'a> Search<'a> {
    pub(super) fn new(
        tuning: &'a Tuning,
        record: &'a MotionRecord,
        known: Option<f64>,
        heard: &[f64],
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
        // A channel that never changes says nothing of its noise.
        let largest = record
            .acceleration
            .iter()
            .fold(0.0f64, |m, a| m.max(a.abs()));
        let shown = variance(&record.acceleration);
        let alive = shown > (1e-12 * largest).powi(2);
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
            least: least(record),
            floor: alive
                .then(|| noise_floor(heard))
                .flatten()
                .filter(|q| *q > 0.0)
                .map(|q| unit * q),
            ceiling: if alive { unit * shown } else { f64::INFINITY },
            bend: bend(record, &model),
            effective: readings,
            readings,
            late: false,
            passes: 0,
        }
    }

    /// Whether the acceleration stands clear of its own noise, in a motion that the samples follow: at fewer than some
    /// thirteen samples per period what a curve through them loses would pass for gain and latency.
    pub(super) fn moves(&self) -> bool {
        if !self.ceiling.is_finite() {
            return false;
        }
        let noise = self.floor.map_or(0.0, |floor| floor / self.ceiling);
        // White noise alone bends the steps by 0.17.
        let bend = self.bend * self.bend - 0.17 * 0.17 * noise;
        noise < 0.01 && bend < 0.02 * 0.02
    }

    /// What holds the gain: its stated standard uncertainty.
    pub(super) fn held(&self) -> Option<f64> {
        self.record.gain_uncertainty.filter(|_| self.tuning.pairing)
    }

    /// What one parameter more has to bring.
    pub(super) fn price(&self) -> f64 {
        0.5 * self.effective.ln() * self.repeats()
    }

    /// What a gain or a latency has to bring: of few readings that are new ½ ln n_e would take two in a hundred by chance, and
    /// what they do to the velocity is large. At least the point of χ²(1) that one in a thousand passes.
    fn price_of_pairing(&self) -> f64 {
        0.5 * self.effective.ln().max(10.83) * self.repeats()
    }

    pub(super) fn prior(&self, q: f64) -> f64 {
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
        -0.5 * self.excess() * (off / width).powi(2)
    }

    /// How much too sure the likelihood is beside the floor: the root of how often the same rounding comes, since a part of
    /// what the readings tell (a start, a stop) comes once. Where the samples do not follow the motion, the floor is not all
    /// of q.
    pub(super) fn excess(&self) -> f64 {
        match self.rounding.is_some() && self.moves() {
            true => self.repeats().sqrt(),
            false => 1.0,
        }
    }

    /// How often the same rounding comes.
    fn repeats(&self) -> f64 {
        (self.readings / self.effective).max(1.0)
    }

    pub(super) fn sums(&mut self, noise: &Noise) -> Result<Sums, Error> {
        self.passes += 1;
        // The total is not known before the end.
        self.watch.step("likelihood", self.passes as u64, 0)?;
        let motion = self.late || self.held().is_some() || (self.tuning.pairing && self.moves());
        Ok(self.prepared.sums(noise, motion))
    }

    pub(super) fn subsets(&self, allowed: Unknowns) -> Vec<Unknowns> {
        let offsets: &[bool] = match self.tuning.bias {
            // The states of two stages before the first sample are a slope, which nothing else takes.
            _ if self.record.behind_two_stages().is_some() => &[true],
            BiasChoice::None => &[false],
            BiasChoice::Automatic => &[false, true],
            BiasChoice::Constant | BiasChoice::RandomWalk => &[true],
        };
        let both: &[bool] = &[false, true];
        let held = allowed.gain && self.held().is_some();
        let mut list = Vec::new();
        for &offset in offsets {
            for &gain in both.iter().filter(|g| allowed.gain || !**g) {
                for &latency in both.iter().filter(|l| allowed.latency || !**l) {
                    if self.late && !latency || held && !gain {
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
    pub(super) fn best(
        &mut self,
        noise: &Noise,
        subsets: &[Unknowns],
    ) -> Result<Option<Point>, Error> {
        let sums = self.sums(noise)?;
        let mut best: Option<Point> = None;
        for &unknowns in subsets {
            let found = if self.known.is_some() {
                let solution = sums.solve(self.record, unknowns);
                solution.map(|s| {
                    let value = sums.log_likelihood(&s);
                    (s, value, *noise)
                })
            } else {
                let least = self.least / noise.r;
                let found = sums.solve_concentrated(self.record, unknowns, least);
                found.map(|(solution, value, factor)| (solution, value, noise.scaled(factor)))
            };
            let Some((solution, log_likelihood, noise)) = found else {
                continue;
            };
            let mut point = Point {
                noise,
                unknowns,
                solution,
                log_likelihood,
                value: 0.0,
                alike: Vec::new(),
            };
            point.value = self.rated(&point);
            if point.value.is_finite() && best.as_ref().is_none_or(|b| point.value > b.value) {
                best = Some(point);
            }
        }
        Ok(best)
    }

    pub(super) fn rated(&self, point: &Point) -> f64 {
        let Unknowns {
            offset,
            gain,
            latency,
        } = point.unknowns;
        // A gain that is held is in every model.
        let pairing = [gain && self.held().is_none(), latency];
        let extra = [
            offset,
            point.noise.walk.is_some() && self.record.given_back.is_none(),
            point.noise.colour.is_some(),
            point.noise.colour.is_some(),
        ];
        let k = extra.into_iter().filter(|x| *x).count() as f64;
        point.log_likelihood + self.prior(point.noise.q)
            - k * self.price()
            - pairing.into_iter().filter(|x| *x).count() as f64 * self.price_of_pairing()
    }

    /// q in the unit in which R = 1 and T = 1.
    pub(super) fn unit(&self) -> f64 {
        let dt = self.record.sample_time;
        let form = match self.tuning.noise_form {
            ProcessNoise::SampleConstant => dt.powi(4),
            ProcessNoise::Continuous => dt.powi(3),
        };
        // A speed has one integration less.
        match self.record.source {
            ReadingSource::Position => form,
            ReadingSource::Speed => form / (dt * dt),
        }
    }

    pub(super) fn white(&self, q: f64, r: f64) -> Noise {
        Noise {
            q,
            form: self.tuning.noise_form,
            r,
            walk: tied(self.record, q, self.tuning.noise_form),
            colour: None,
        }
    }

    /// Best q, R and constants of the allowed kinds, without walk and colour.
    pub(super) fn base(&mut self, allowed: Unknowns) -> Result<Point, Error> {
        let subsets = self.subsets(allowed);
        let unit = self.unit();
        let ratio = match self.record.accelerometer {
            true => RATIO,
            false => (RATIO.0, EXACT),
        };
        let (low, high) = match (self.known, self.floor) {
            (Some(_), Some(floor)) => ((1e-6 * floor).log10(), self.ceiling.log10()),
            (Some(r), None) => (
                (10f64.powf(ratio.0) * r / unit).log10(),
                (10f64.powf(ratio.1) * r / unit).min(self.ceiling).log10(),
            ),
            (None, _) => ratio,
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
        if best.is_none() && known.is_none() {
            best = self.worst_readings(&subsets)?;
        }
        best.ok_or(Error::NotConverged {
            name: "likelihood",
            iterations: self.passes,
            step: f64::INFINITY,
        })
    }

    /// Readings so wrong beside the accelerometer (a counter that rolls over) that every R in the range of ratios would
    /// need a q the accelerometer does not show: q at its floor, and R alone is found.
    fn worst_readings(&mut self, subsets: &[Unknowns]) -> Result<Option<Point>, Error> {
        let q = self.floor.unwrap_or(self.ceiling).min(self.ceiling);
        let path: Vec<f64> = self.record.reading.iter().flatten().copied().collect();
        let high = variance(&path);
        if !(q.is_finite() && high > 0.0) {
            return Ok(None);
        }
        let low = self.rounding.unwrap_or(1e-24 * high).min(high);
        let mut best: Option<Point> = None;
        line(low.log10(), high.log10() + 1.0, 1.0, 0.01, |at| {
            let r = 10f64.powf(at);
            self.known = Some(r);
            let found = self.best(&self.white(q, r), subsets);
            self.known = None;
            let found = found?;
            let value = found.as_ref().map_or(-1e300, |p| p.value);
            if let Some(point) = found
                && best.as_ref().is_none_or(|b| point.value > b.value)
            {
                best = Some(point);
            }
            Ok(value)
        })?;
        Ok(best)
    }
}

/// Step of the digits of a speed.
fn resolution(record: &MotionRecord) -> Option<f64> {
    if record.source != ReadingSource::Speed {
        return None;
    }
    let values: Vec<f64> = record.reading.iter().flatten().copied().collect();
    speed_increment(&values)
}

/// Variance of the best reading that is believed. Readings of a simulation have no noise at all, and those of a sensor
/// that never moves show none: without a bound every variance would go to zero together.
fn least(record: &MotionRecord) -> f64 {
    let values = || record.reading.iter().flatten().copied();
    let largest = values().fold(0.0f64, |m, v| m.max(v.abs()));
    let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    });
    let step = match record.source {
        ReadingSource::Speed => 1e-6 * largest,
        ReadingSource::Position => (1e-8 * (high - low)).max(4.0 * f64::EPSILON * largest),
    };
    // Where nothing moves: a nanometre, or a nanometre per second.
    if step > 0.0 {
        step * step / 12.0
    } else {
        1e-18 / 12.0
    }
}

/// Bend of the velocity's steps against straight lines between the samples.
fn bend(record: &MotionRecord, model: &KalmanModel) -> f64 {
    let Some(curve) = curve(record, model) else {
        return 0.0;
    };
    let half = 0.5 * record.sample_time;
    let (mut off, mut all) = (0.0, 0.0);
    for (w, [_, dv]) in record.acceleration.windows(2).zip(&curve.steps[1..]) {
        off += (dv - half * (w[0] + w[1])).powi(2);
        all += dv * dv;
    }
    if all > 0.0 { (off / all).sqrt() } else { 0.0 }
}
