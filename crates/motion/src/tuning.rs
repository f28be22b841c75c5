//! Noise of both sensors, and offset, gain and latency between them, by maximum likelihood.

mod answer;
mod colour;
mod doubt;
mod likelihood;
mod smoothing;
mod spread;
mod walk;

pub(crate) use likelihood::PRIOR;
pub(crate) use smoothing::Constants;

use crate::diffuse::{ColouredNoise, Noise, Prepared, Solution, Unknowns};
use crate::floor::effective_readings;
use crate::search::simplex;
use crate::{BiasModel, Hold, KalmanModel, MotionRecord, ProcessNoise, ReadingSource, Whiteness};
use proofmass_core::{Error, Watch};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

/// Whether R is known or found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
#[non_exhaustive]
pub struct TunedValue {
    /// Value.
    pub value: f64,
    /// Standard uncertainty.
    pub uncertainty: f64,
}

/// The model that makes the readings most probable.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Tuned {
    /// Noise and offset as a filter on line takes them.
    pub model: KalmanModel,
    /// Offset of the accelerometer (at the start, where it walks), when it has one.
    pub offset: Option<TunedValue>,
    /// Slope of the offset over time, where the acceleration was integrated.
    pub(crate) ramp: Option<TunedValue>,
    /// Bend of the offset over time, where it was integrated twice.
    pub(crate) bend: Option<TunedValue>,
    /// Gain of the accelerometer over that of the readings, when it is not one: it reads this times the acceleration.
    pub gain: Option<TunedValue>,
    /// Time by which the accelerometer is later than the readings, s, when it is.
    pub latency: Option<TunedValue>,
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseNode {
    /// q
    pub(crate) acceleration: f64,
    /// White part of R.
    pub(crate) reading: f64,
    /// Density of the walk.
    pub(crate) walk: Option<f64>,
    /// Coloured part of the readings.
    pub(crate) coloured: Option<ColouredNoise>,
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

impl Tuned {
    /// The noise of the model that was found.
    pub(crate) fn noise(&self) -> Noise {
        let colour = self.coloured.map(|c| (c.deviation * c.deviation, c.time));
        Noise {
            q: self.model.acceleration_noise,
            form: self.model.noise_form,
            r: self.model.reading_noise - colour.map_or(0.0, |(variance, _)| variance),
            walk: match self.model.bias {
                Some(BiasModel::RandomWalk { density, .. }) if density > 0.0 => Some(density),
                _ => None,
            },
            colour,
        }
    }
}

/// Least number of readings.
const LEAST: usize = 24;

impl Tuning {
    /// Finds noise, offset, gain and latency for a record.
    ///
    /// Start, offset, gain and latency are unknown constants without any prior. The accelerometer's own floor (Welch)
    /// holds q where the readings leave it open: ln q is normal about ln of the floor, 0.4 below and 0.5 above it, and
    /// q never exceeds the variance of the acceleration. Each further parameter has to raise ln L by ½ ln n_e · n/n_e,
    /// with the number n_e of readings whose rounding is new; beside the floor the likelihood is taken to be √(n/n_e) times too sure. A gain whose uncertainty the record states is in every model, held
    /// by it. R is at least δ²/12; without an increment no reading is
    /// taken to be nearer than a millionth of the largest speed, or a hundred-millionth of the way.
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
        self.search(record, false, &record.acceleration, watch)
    }

    /// The same; `late` where a latency is known to be there. The floor is that of what was `heard`: between its samples a curve
    /// takes the highest frequencies from the noise of the accelerometer, and leaves what moves the velocity.
    pub(crate) fn search(
        &self,
        record: &MotionRecord,
        late: bool,
        heard: &[f64],
        watch: &dyn Watch,
    ) -> Result<Tuned, Error> {
        record.check()?;
        if !record.accelerometer && self.pairing {
            // What is an offset beside an accelerometer is the axis' own acceleration here.
            let alone = Self {
                pairing: false,
                ..*self
            };
            return alone.search(record, late, heard, watch);
        }
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
        let mut search = Search::new(self, record, known, heard, watch);
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
        if record.source == ReadingSource::Position {
            let whitened = search.prepared.innovations(&point.noise, &point.solution);
            let placed = record.in_places(&whitened);
            let share = whitened.len() as f64 / placed.len().max(1) as f64;
            search.effective = share * effective_readings(&placed);
        }
        search.late = late;
        let moves = late || (self.pairing && search.moves());
        if moves || search.held().is_some() {
            point = search.base(Unknowns {
                gain: true,
                latency: moves,
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
        if record.source == ReadingSource::Speed {
            let coloured = search.coloured(&point)?;
            let joint = match self.bias {
                BiasChoice::Automatic | BiasChoice::RandomWalk => {
                    search.joint(&point, coloured.as_ref())?
                }
                BiasChoice::None | BiasChoice::Constant => None,
            };
            match (joint, coloured) {
                (Some(joint), _) => point = joint,
                (None, Some(coloured)) if coloured.value > point.value => point = coloured,
                _ => {}
            }
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
    /// Other maxima that are as likely.
    alike: Vec<Noise>,
}

/// The highest point that simplexes of a size and a number of passes meet, from one start after another.
fn highest<const D: usize>(
    starts: impl IntoIterator<Item = [f64; D]>,
    (size, passes): (f64, usize),
    mut at: impl FnMut(&[f64; D]) -> Result<Option<Point>, Error>,
) -> Result<Option<Point>, Error> {
    let mut best: Option<Point> = None;
    for start in starts {
        simplex(start, size, passes, |x| {
            let point = at(x)?;
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

struct Search<'a> {
    tuning: &'a Tuning,
    record: &'a MotionRecord,
    prepared: Prepared<'a>,
    watch: &'a dyn Watch,
    known: Option<f64>,
    /// δ²/12.
    rounding: Option<f64>,
    /// Least R: no reading is taken to be nearer than this, whatever its digits.
    least: f64,
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
