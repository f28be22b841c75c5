//! A sensor at rest with known noise.

use super::Desk;
use crate::trouble::{Result, Trouble};
use proofmass_io::{Cell, Table};
use proofmass_noise::{
    GaussMarkov, LowPass, NoiseModel, Sensor, SimulatedSensor, Sinusoid, Term, simulated_stamps,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Values of a recording at most: axes times samples.
const MOST: f64 = 1e8;

/// A sensor at rest with known noise: recording.csv, truth.json.
///
/// The terms are those of `proofmass noise`, in SI: for an accelerometer N in (m/s²)/√Hz as the Allan deviation at 1 s (data sheets
/// give √2 N). The defaults are near a micromechanical accelerometer of the better kind over seventeen minutes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct SimulatedNoise {
    /// What is at rest
    #[cfg_attr(
        feature = "clap",
        arg(long, value_enum, default_value = "accelerometer")
    )]
    pub sensor: SimulatedKind,
    /// Number of axes, independent of each other
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedNoise::default().axes, value_parser = clap::value_parser!(u8).range(1..=3)))]
    pub axes: u8,
    /// Duration, s
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedNoise::default().duration, value_parser = crate::arguments::positive))]
    pub duration: f64,
    /// Sampling rate, Hz
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedNoise::default().rate, value_parser = crate::arguments::positive))]
    pub rate: f64,
    /// N, white noise
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = SimulatedNoise::default().white))]
    pub white: f64,
    /// B, bias instability: the coefficient, the floor of the curve is 0.664 B
    #[cfg_attr(feature = "clap", arg(long, value_name = "B", default_value_t = SimulatedNoise::default().flicker))]
    pub flicker: f64,
    /// K, random walk
    #[cfg_attr(feature = "clap", arg(long, value_name = "K", default_value_t = SimulatedNoise::default().random_walk))]
    pub random_walk: f64,
    /// Q, quantisation noise
    #[cfg_attr(feature = "clap", arg(long, value_name = "Q", default_value_t = SimulatedNoise::default().quantisation))]
    pub quantisation: f64,
    /// R, ramp
    #[cfg_attr(feature = "clap", arg(long, value_name = "R", default_value_t = SimulatedNoise::default().ramp, allow_negative_numbers = true))]
    pub ramp: f64,
    /// A first-order Gauss–Markov process: standard deviation and correlation time in s; may be given several times
    #[cfg_attr(feature = "clap", arg(long, value_name = "SIGMA,SECONDS", value_parser = gauss_markov))]
    pub gauss_markov: Vec<GaussMarkov>,
    /// A sinusoid: amplitude and frequency in Hz; may be given several times
    #[cfg_attr(feature = "clap", arg(long, value_name = "AMPLITUDE,HZ", value_parser = sinusoid))]
    pub sinusoid: Vec<Sinusoid>,
    /// Corner of a low-pass filter in front of the converter, Hz [default: no filter]
    #[cfg_attr(feature = "clap", arg(long, value_name = "HZ", value_parser = crate::arguments::positive))]
    pub corner: Option<f64>,
    /// Order of that filter
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedNoise::default().order, value_parser = clap::value_parser!(u8).range(1..=2)))]
    pub order: u8,
    /// Smallest step of the converter [default: a millionth of the noise of a sample]
    #[cfg_attr(feature = "clap", arg(long, value_name = "STEP", value_parser = crate::arguments::positive))]
    pub step: Option<f64>,
    /// An interval that is missing, s; may be given several times
    #[cfg_attr(feature = "clap", arg(long, value_name = "FROM,TO", value_parser = crate::arguments::stretch))]
    pub gap: Vec<[f64; 2]>,
    /// Jitter of the time stamps, in intervals of a sample (standard deviation)
    #[cfg_attr(feature = "clap", arg(long, value_name = "SHARE", default_value_t = SimulatedNoise::default().jitter))]
    pub jitter: f64,
    /// Share of the samples that are outliers
    #[cfg_attr(feature = "clap", arg(long, value_name = "SHARE", default_value_t = SimulatedNoise::default().outliers))]
    pub outliers: f64,
    /// Size of the outliers in standard deviations of white noise
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedNoise::default().outlier_size))]
    pub outlier_size: f64,
    /// Seed of the noise
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedNoise::default().seed))]
    pub seed: u64,
}

impl Default for SimulatedNoise {
    fn default() -> Self {
        Self {
            sensor: SimulatedKind::Accelerometer,
            axes: 1,
            duration: 1000.0,
            rate: 100.0,
            white: 2.5e-3,
            flicker: 0.0,
            random_walk: 5e-4,
            quantisation: 0.0,
            ramp: 0.0,
            gauss_markov: Vec::new(),
            sinusoid: Vec::new(),
            corner: None,
            order: 2,
            step: None,
            gap: Vec::new(),
            jitter: 0.0,
            outliers: 0.0,
            outlier_size: 10.0,
            seed: 1,
        }
    }
}

/// What a simulated sensor at rest measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SimulatedKind {
    /// Accelerations in m/s²
    Accelerometer,
    /// Angular rates in rad/s
    Gyroscope,
}

/// The truth beside a simulated recording.
#[derive(Serialize)]
struct Truth<'a> {
    scenario: &'static str,
    request: &'a SimulatedNoise,
    /// By the names of the quantities of `proofmass noise`, those that are not zero.
    quantities: BTreeMap<String, Quantity>,
    converter_step: f64,
    samples: usize,
    rows: usize,
}

#[derive(Serialize)]
struct Quantity {
    value: f64,
    unit: String,
}

impl SimulatedNoise {
    /// Names of the columns without their unit.
    fn names(&self) -> Vec<String> {
        let sensor = match self.sensor {
            SimulatedKind::Accelerometer => "acc",
            SimulatedKind::Gyroscope => "gyro",
        };
        let axes = ["x", "y", "z"].iter().take(usize::from(self.axes));
        axes.map(|axis| format!("{sensor}_{axis}")).collect()
    }

    fn unit(&self) -> (&'static str, Sensor) {
        match self.sensor {
            SimulatedKind::Accelerometer => ("m/s2", Sensor::Accelerometer),
            SimulatedKind::Gyroscope => ("rad/s", Sensor::Gyroscope),
        }
    }

    fn model(&self) -> NoiseModel {
        NoiseModel {
            quantisation: self.quantisation,
            white: self.white,
            flicker: self.flicker,
            random_walk: self.random_walk,
            ramp: self.ramp,
            gauss_markov: self.gauss_markov.clone(),
            sinusoids: self.sinusoid.clone(),
        }
    }

    /// A millionth of the noise of a sample as a power of ten, where none is asked for: no digit that counts is lost.
    fn step(&self) -> f64 {
        let markov = self.gauss_markov.iter().map(|g| g.standard_deviation);
        let scale = [
            self.white * self.rate.sqrt(),
            self.quantisation * self.rate,
            self.flicker,
            self.random_walk / self.rate.sqrt(),
        ]
        .into_iter()
        .chain(markov)
        .fold(0.0, f64::max);
        match self.step {
            Some(step) => step,
            None if scale > 0.0 => 10_f64.powi((1e-6 * scale).log10().floor() as i32),
            None => 0.0,
        }
    }

    pub(super) fn simulate(&self, desk: &Desk<'_>) -> Result<serde_json::Value> {
        let refused = |e: proofmass_core::Error| {
            Trouble::from(e)
                .with_hint("see `proofmass simulate noise --help` for what each setting means")
        };
        let count = (self.duration * self.rate).round();
        if !(2.0..=MOST).contains(&(count * f64::from(self.axes))) {
            return Err(Trouble::request(format!(
                "{} s at {} Hz on {} axes are {count:.0} samples each",
                self.duration, self.rate, self.axes
            ))
            .with_hint("from two values to a hundred million, all axes together"));
        }
        if let Some(fast) = self.sinusoid.iter().find(|s| s.frequency > 0.5 * self.rate) {
            return Err(Trouble::request(format!(
                "a sinusoid of {} Hz cannot be sampled at {} Hz: it would appear at another frequency",
                fast.frequency, self.rate
            ))
            .with_hint(format!(
                "at most half the sampling rate, {} Hz; raise --rate or lower the frequency of --sinusoid",
                0.5 * self.rate
            )));
        }
        let n = count as usize;
        let mut sensor = SimulatedSensor::new(self.model());
        sensor.low_pass = self.corner.map(|corner| LowPass {
            order: i32::from(self.order),
            corner,
        });
        sensor.outliers = self.outliers;
        sensor.outlier_size = self.outlier_size;
        sensor.step = self.step();
        let axes = sensor
            .record(usize::from(self.axes), n, self.rate, self.seed)
            .map_err(refused)?;
        let stamps = simulated_stamps(n, self.rate, self.jitter, self.seed).map_err(refused)?;
        let (unit, kind) = self.unit();
        let names = self.names();
        let mut headings = vec!["time_s".to_owned()];
        headings.extend(names.iter().map(|name| format!("{name}_{unit}")));
        let mut table = Table::new(headings);
        let mut rows = 0;
        for (i, stamp) in stamps.iter().enumerate() {
            let at = i as f64 / self.rate;
            if self.gap.iter().any(|[from, to]| *from <= at && at < *to) {
                continue;
            }
            let mut row = vec![Cell::from((stamp * 1e9).round() * 1e-9)];
            row.extend(axes.iter().map(|axis| printed(axis[i], sensor.step)));
            table.push(row)?;
            rows += 1;
        }
        desk.write("recording.csv", table.to_csv()?)?;
        desk.truth(&Truth {
            scenario: "noise",
            request: self,
            quantities: self.quantities(&names, kind),
            converter_step: sensor.step,
            samples: n,
            rows,
        })
    }

    fn quantities(&self, names: &[String], sensor: Sensor) -> BTreeMap<String, Quantity> {
        let mut all = BTreeMap::new();
        for name in names {
            let powers = [
                (Term::Quantisation, self.quantisation),
                (Term::White, self.white),
                (Term::Flicker, self.flicker),
                (Term::RandomWalk, self.random_walk),
                (Term::Ramp, self.ramp),
            ];
            let mut put = |term: Term, number: String, value: f64| {
                if value != 0.0 {
                    let unit = term.unit(sensor.unit());
                    let name = format!("{name}.{}{number}", term.symbol());
                    all.insert(name, Quantity { value, unit });
                }
            };
            for (term, value) in powers {
                put(term, String::new(), value);
            }
            for (i, g) in self.gauss_markov.iter().enumerate() {
                put(Term::GaussMarkov, (i + 1).to_string(), g.standard_deviation);
            }
            for (i, s) in self.sinusoid.iter().enumerate() {
                put(Term::Sinusoid, (i + 1).to_string(), s.amplitude);
            }
        }
        all
    }
}

/// With the digits that the step of the converter has, where it is a power of ten.
fn printed(value: f64, step: f64) -> Cell {
    let digits = -step.log10();
    if step > 0.0 && (digits - digits.round()).abs() < 1e-9 && (0.0..=18.0).contains(&digits) {
        Cell::Text(format!("{value:.*}", digits.round() as usize))
    } else {
        Cell::from(value)
    }
}

#[cfg(feature = "clap")]
fn pair(text: &str, what: &str) -> std::result::Result<[f64; 2], String> {
    let wrong = || format!("{text:?} is no {what}");
    let (first, second) = text.split_once(',').ok_or_else(wrong)?;
    let number = |t: &str| {
        t.trim()
            .parse::<f64>()
            .ok()
            .filter(|v| *v > 0.0 && v.is_finite())
    };
    match (number(first), number(second)) {
        (Some(first), Some(second)) => Ok([first, second]),
        _ => Err(wrong()),
    }
}

#[cfg(feature = "clap")]
fn gauss_markov(text: &str) -> std::result::Result<GaussMarkov, String> {
    let [standard_deviation, correlation_time] = pair(
        text,
        "Gauss–Markov process: write its standard deviation and its correlation time in seconds, 1e-3,30",
    )?;
    Ok(GaussMarkov {
        standard_deviation,
        correlation_time,
    })
}

#[cfg(feature = "clap")]
fn sinusoid(text: &str) -> std::result::Result<Sinusoid, String> {
    let [amplitude, frequency] = pair(
        text,
        "sinusoid: write its amplitude and its frequency in hertz, 1e-3,0.02",
    )?;
    Ok(Sinusoid {
        amplitude,
        frequency,
        phase: 0.0,
    })
}
