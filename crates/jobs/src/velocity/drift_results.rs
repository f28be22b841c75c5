//! What results say of a drift: the noise of the accelerometer, and what its calibration leaves open.

use super::{SensorAxis, VelocityDriftJob};
use crate::bias::AxisNoise;
use crate::frequency_response::read_calibration;
use crate::noise::noise_of;
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_documents::{AnyCalibration, CalibrationFile, Device};
use proofmass_io::{Input, Source};
use proofmass_noise::{Analysis, ChannelAnalysis, Term};
use proofmass_report::scientific;
use serde::{Deserialize, Serialize};

/// One number of a drift, and where it was taken from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct TakenFrom {
    /// What it is.
    pub(crate) quantity: String,
    /// Its value, or what it is below.
    pub(crate) value: String,
    /// Its unit.
    pub(crate) unit: String,
    /// The file that states it.
    pub(crate) file: String,
}

/// The results that a drift takes its numbers from.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct DriftResults {
    /// Which axis, where a file has three.
    pub axis: Option<SensorAxis>,
    /// Which channel of the noise result, by its name.
    pub channel: Option<String>,
    inputs: Vec<Input>,
    device: Device,
}

/// Processes that a budget has room for.
const PROCESSES: usize = 4;

impl DriftResults {
    /// Of an axis or a channel, where the files have several.
    pub fn of(axis: Option<SensorAxis>, channel: Option<String>) -> Self {
        Self {
            axis,
            channel,
            ..Self::default()
        }
    }

    /// Takes N, B, K and Gauss–Markov processes from a result of `noise`: the most likely values, and the upper ends of their
    /// intervals beside them.
    ///
    /// # Errors
    /// Another file, a channel that cannot be told, a unit that is no acceleration.
    pub fn take_noise(&mut self, source: Source, job: &mut VelocityDriftJob) -> Result<()> {
        let name = source.name().display().to_string();
        let (analysis, input, device) = noise_of(source)?;
        let within = |e: Trouble| e.detail(name.clone());
        let channel = self.channel_of(&analysis).map_err(within)?;
        let (fit, factor) = AxisNoise::fit_of(channel).map_err(within)?;
        if fit.model.gauss_markov.len() > PROCESSES {
            return Err(within(Trouble::data(format!(
                "the noise result has {} Gauss–Markov processes, more than {PROCESSES}",
                fit.model.gauss_markov.len()
            ))));
        }
        let mut upper = job.upper.unwrap_or(job.sources);
        let sources = &mut job.sources;
        for (term, letter, unit, likely) in [
            (Term::White, "white noise N", "(m/s²)/√Hz", fit.model.white),
            (
                Term::Flicker,
                "bias instability B",
                "m/s²",
                fit.model.flicker,
            ),
            (
                Term::RandomWalk,
                "random walk K",
                "(m/s²)·√Hz",
                fit.model.random_walk,
            ),
        ] {
            let verdict = fit.get(term).map(|c| c.verdict);
            let value = factor * likely.max(0.0);
            let high = verdict
                .and_then(|v| v.upper())
                .map_or(value, |u| factor * u);
            let high = high.max(value);
            match term {
                Term::White => {
                    (sources.noise, sources.sample_time) = (value, 1.0);
                    (upper.noise, upper.sample_time) = (high, 1.0);
                }
                Term::Flicker => (sources.flicker, upper.flicker) = (value, high),
                _ => (sources.walk, upper.walk) = (value, high),
            }
            let interval = verdict.and_then(|v| v.interval());
            let text = match interval {
                Some((low, end)) => format!(
                    "{} ({} to {})",
                    scientific(value, 4),
                    scientific(factor * low, 3),
                    scientific(factor * end, 3)
                ),
                None if high > value => format!(
                    "{}, below {} (not identified)",
                    scientific(value, 3),
                    scientific(high, 3)
                ),
                None => scientific(value, 4),
            };
            job.taken.push(TakenFrom {
                quantity: format!("{letter} of {}", channel.name),
                value: text,
                unit: unit.to_owned(),
                file: name.clone(),
            });
        }
        for (process, own) in fit.model.gauss_markov.iter().zip(&mut sources.markov) {
            *own = [
                factor * process.standard_deviation,
                process.correlation_time,
            ];
            job.taken.push(TakenFrom {
                quantity: format!("Gauss–Markov process of {}", channel.name),
                value: format!("{} over {} s", scientific(own[0], 3), scientific(own[1], 3)),
                unit: "m/s²".to_owned(),
                file: name.clone(),
            });
        }
        upper.markov = sources.markov;
        job.upper = Some(upper);
        self.inputs.push(input);
        self.device = device;
        Ok(())
    }

    /// The channel of the noise result that is meant.
    fn channel_of<'a>(&self, analysis: &'a Analysis) -> Result<&'a ChannelAnalysis> {
        let all = analysis.channels.as_slice();
        let names = || {
            let names: Vec<&str> = all.iter().map(|c| c.name.as_str()).collect();
            names.join(", ")
        };
        if let Some(name) = &self.channel {
            let found = all.iter().find(|c| c.name == *name);
            return found.ok_or_else(|| {
                Trouble::request(format!("the noise result has no channel {name:?}"))
                    .with_hint(format!("its channels are {}", names()))
            });
        }
        match (all, self.axis) {
            ([one], _) => Ok(one),
            ([x, y, z], Some(axis)) => Ok([x, y, z][axis.index()]),
            _ => Err(Trouble::request(format!(
                "which channel of the noise result is meant is not said: it has {}",
                names()
            ))
            .with_hint(
                "add --axis x, y or z of three channels in this order, or --noise-channel NAME",
            )),
        }
    }

    /// Takes what a calibration at rest leaves open of bias and scale factor, with their covariance.
    ///
    /// The compensated acceleration is off by δb/k + (δk/k) a.
    ///
    /// # Errors
    /// Another file, one over frequency, an axis that is not said.
    pub fn take_calibration(&mut self, source: Source, job: &mut VelocityDriftJob) -> Result<()> {
        let name = source.name().display().to_string();
        let (any, input, _) = read_calibration(source, None).map_err(|e| {
            let hint = e.hint().map_or(String::new(), |h| format!("{h}; "));
            e.with_hint(format!(
                "{hint}a result of `proofmass noise` is named by --noise-result"
            ))
        })?;
        let AnyCalibration::Constant(file) = any else {
            return Err(Trouble::request(
                "the calibration is one over frequency: a shaker measures no bias",
            )
            .detail(name)
            .with_hint("name a calibration at rest: of `proofmass calibrate` from positions, or a static test"));
        };
        let within = |e: Trouble| e.detail(name.clone());
        let axis = self.axis_of(&file).map_err(within)?;
        let (row, ending) = match axis {
            Some(axis) => (axis.index(), [".x", ".y", ".z"][axis.index()]),
            None => (0, ""),
        };
        let estimate = &file.estimate;
        let place = |what: &str| estimate.index_of(&format!("{what}{ending}"));
        let (Some(bias), Some(scale)) = (place("bias"), place("scale")) else {
            return Err(within(Trouble::data(
                "the calibration states no bias and scale factor with their uncertainties",
            )
            .with_hint("name a calibration.json or result.json of `proofmass calibrate` or a static test")));
        };
        if estimate.influences().is_empty() {
            return Err(within(Trouble::data(
                "the calibration states no uncertainties",
            )
            .with_hint("coefficients of others have none: say --offset-uncertainty and --gain-uncertainty")));
        }
        let k = file.k[row][row].abs();
        let covariance = estimate.covariance();
        let u_bias = covariance[(bias, bias)].max(0.0).sqrt();
        let u_scale = covariance[(scale, scale)].max(0.0).sqrt();
        let product = u_bias * u_scale;
        let correlation = match product > 0.0 {
            true => (covariance[(bias, scale)] / product).clamp(-1.0, 1.0),
            false => 0.0,
        };
        for sources in [Some(&mut job.sources), job.upper.as_mut()]
            .into_iter()
            .flatten()
        {
            sources.offset_uncertainty = u_bias / k;
            sources.gain_uncertainty = u_scale / k;
            sources.offset_gain_correlation = correlation;
        }
        let of = |what: &str| match axis {
            Some(_) => format!("{what}{ending}"),
            None => what.to_owned(),
        };
        job.taken.extend([
            TakenFrom {
                quantity: format!("u of {}", of("bias")),
                value: scientific(u_bias / k, 3),
                unit: "m/s²".to_owned(),
                file: name.clone(),
            },
            TakenFrom {
                quantity: format!("u of {}, relative", of("scale")),
                value: scientific(u_scale / k, 3),
                unit: "1".to_owned(),
                file: name.clone(),
            },
            TakenFrom {
                quantity: "correlation of both".to_owned(),
                value: format!("{correlation:.2}"),
                unit: "1".to_owned(),
                file: name,
            },
        ]);
        self.inputs.push(input);
        self.device = file.device.clone();
        Ok(())
    }

    /// The axis of a calibration of three, `None` of one.
    fn axis_of(&self, file: &CalibrationFile) -> Result<Option<SensorAxis>> {
        match (file.axes(), self.axis) {
            (1, _) => Ok(None),
            (_, Some(axis)) => Ok(Some(axis)),
            (_, None) => Err(Trouble::request(
                "which axis of the calibration lies along the motion is not said",
            )
            .with_hint("add --axis x, --axis y or --axis z")),
        }
    }

    /// What a result is filed with.
    pub fn record(&self, date: Option<String>) -> Record {
        Record {
            date,
            device: self.device.clone(),
            inputs: self.inputs.clone(),
            ..Record::default()
        }
    }
}
