//! The steps behind a calibration at work on samples in order.

use super::chain::{Chain, LowPass, LowPassForm};
use crate::bias::TrackedBias;
use crate::findings;
use crate::trouble::{Result, Trouble};
use proofmass_core::{Butterworth, Decimator, DecimatorState, Matrix3, weighted_sum};
use proofmass_documents::{FirmwareBlock, LowPassBehind};
use proofmass_signal::LinearPhase;
use proofmass_uncertainty::{DegreesOfFreedom, Finding};
use serde::Serialize;
use std::collections::VecDeque;

/// What is left of a step when a low-pass counts as settled.
const SETTLED: f64 = 1e-3;

/// What the steps are and what is to be known of them.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ChainFigures {
    /// The steps in their order, in words.
    pub steps: Vec<String>,
    /// Delay of all steps at low frequency, s.
    #[serde(rename = "delay_s")]
    pub delay: f64,
    /// What of it is left when the samples were put to their rows, s: an acceleration comes this much late in its row.
    #[serde(rename = "delay_left_s")]
    pub delay_left: f64,
    /// Samples per second that are written, where a low-pass asked for the rate.
    #[serde(rename = "rate_Hz", skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// Largest difference of the gain from one up to the corner.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ripple: Option<f64>,
    /// Largest gain of what decimation folds into the band up to the corner.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub folded: Option<f64>,
    /// Largest standard uncertainty of the bias that was subtracted, m/s².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bias_uncertainty: Option<f64>,
    /// Largest standard uncertainty by the angles of a component over the acceleration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation_uncertainty: Option<f64>,
}

impl ChainFigures {
    /// What the steps leave to be known, line by line.
    pub fn statements(&self) -> Vec<String> {
        let normal = DegreesOfFreedom::INFINITE.coverage_factor(0.95);
        let mut lines = Vec::new();
        if let Some(u) = self.bias_uncertainty {
            lines.push(format!(
                "uncertainty by the bias: at most {:.3e} m/s² with 95 % probability",
                normal * u
            ));
        }
        if let Some(u) = self.rotation_uncertainty {
            lines.push(format!(
                "uncertainty by the angles: at most {:.3} % of the acceleration with 95 % probability",
                100.0 * normal * u
            ));
        }
        if self.rate.is_some() {
            let left = match self.delay_left {
                0.0 => "all of it is taken out".to_owned(),
                left => format!(
                    "taken out by whole samples; the acceleration is {:.1} µs {} in its row",
                    1e6 * left.abs(),
                    if left > 0.0 { "late" } else { "early" }
                ),
            };
            lines.push(format!(
                "delay of all steps at low frequency: {:.1} µs, {left}",
                1e6 * self.delay
            ));
        }
        if let Some(folded) = self.folded {
            lines.push(format!(
                "what decimation folds into the band is weaker by {:.1} dB",
                -20.0 * folded.log10()
            ));
        }
        lines
    }
}

impl Chain {
    /// Whether the low-pass leaves more than was asked of what decimation folds, at this rate in Hz.
    ///
    /// # Errors
    /// A corner that is not below half of the rate, or a decimation that leaves no room above it.
    pub fn folds(&self, rate: f64) -> Result<Option<Finding>> {
        let mut figures = ChainFigures::default();
        Ok(match self.low_pass {
            Some(_) => Filter::new(self, rate, &mut figures)?.folded(self, rate, &figures),
            None => None,
        })
    }
}

impl Chain {
    /// A low-pass of this chain and its decimation as they run on a chip, at this rate in Hz.
    ///
    /// # Errors
    /// A low-pass that cannot be designed.
    pub fn behind(&self, LowPass { corner, .. }: LowPass, rate: f64) -> Result<LowPassBehind> {
        // It refuses what the desk refuses.
        let filter = Filter::new(self, rate, &mut ChainFigures::default())?;
        let low_pass = match &filter.form {
            Form::Butterworth(..) => FirmwareBlock::LowPass { corner, rate },
            Form::Linear(fir, ..) => FirmwareBlock::LinearPhase {
                taps: fir.taps().to_vec(),
                corner,
                ripple: fir.ripple(),
                stop: self.stop(corner, rate),
                stop_gain: fir.stop_gain(),
                rate,
            },
        };
        Ok(LowPassBehind {
            low_pass,
            factor: self.decimation.unwrap_or(1),
        })
    }

    /// From where on a low-pass of linear phase stops, Hz: what folds to the corner lies as far from the new rate.
    fn stop(&self, corner: f64, rate: f64) -> f64 {
        match self.decimation.unwrap_or(1) {
            1 => (2.0 * corner).min(0.5 * (corner + 0.5 * rate)),
            m => rate / f64::from(m) - corner,
        }
    }
}

/// Steps with their state.
pub(super) struct Steps<'a> {
    bias: Option<BiasStep<'a>>,
    rotation: Option<Matrix3<f64>>,
    filter: Option<Filter>,
    pub(super) figures: ChainFigures,
    pub(super) finding: Option<Finding>,
}

struct BiasStep<'a> {
    track: &'a TrackedBias,
    near: usize,
    /// Times and lines of the rows whose values are still to come.
    rows: VecDeque<(f64, u64)>,
    /// Rows at the beginning of a stretch that have no value.
    skip: usize,
}

/// A low-pass with the decimation behind it.
struct Filter {
    form: Form,
    factor: usize,
    /// Samples before the first result of a stretch.
    skip: usize,
    /// Whole samples of delay.
    late: usize,
}

enum Form {
    Butterworth(Decimator<f64, 1>, Vec<DecimatorState<f64, 1>>),
    Linear(LinearPhase, Vec<Vec<f64>>, usize),
}

impl<'a> Steps<'a> {
    /// For samples of so many axes at this rate, which only a low-pass needs.
    pub(super) fn new(
        chain: &Chain,
        bias: Option<&'a TrackedBias>,
        rate: Option<f64>,
    ) -> Result<Self> {
        let mut figures = ChainFigures {
            steps: vec!["calibration".to_owned()],
            ..ChainFigures::default()
        };
        if let Some(track) = bias {
            figures
                .steps
                .push(format!("bias of {} subtracted", track.name()));
            figures.bias_uncertainty = Some(0.0);
        }
        let rotation = match &chain.rotation {
            Some(rotation) => {
                let [roll, pitch, yaw] = rotation.angles.map(f64::to_degrees);
                let u = rotation.uncertainty.map(f64::to_degrees);
                let told = match (u == [0.0; 3], &rotation.covariance) {
                    (_, Some(_)) => ", as measured".to_owned(),
                    (true, None) => String::new(),
                    (false, None) => {
                        format!(", u {}°, {}°, {}°", short(u[0]), short(u[1]), short(u[2]))
                    }
                };
                figures.steps.push(format!(
                    "turned to the frame of the machine: roll {}°, pitch {}°, yaw {}°{told} (z, y', x'')",
                    short(roll),
                    short(pitch),
                    short(yaw)
                ));
                let largest = rotation.largest_uncertainty();
                figures.rotation_uncertainty = Some(largest).filter(|u| *u > 0.0);
                Some(rotation.matrix()?)
            }
            None => None,
        };
        let mut finding = None;
        let filter = match chain.low_pass {
            Some(_) => {
                let rate = rate.ok_or_else(|| {
                    Trouble::request("a low-pass needs the sampling rate, which nothing states")
                        .with_hint("add --rate or --time")
                })?;
                let filter = Filter::new(chain, rate, &mut figures)?;
                finding = filter.folded(chain, rate, &figures);
                Some(filter)
            }
            None => None,
        };
        Ok(Self {
            bias: bias.map(|track| BiasStep {
                track,
                near: 0,
                rows: VecDeque::new(),
                skip: 0,
            }),
            rotation,
            filter,
            figures,
            finding,
        })
    }

    /// A stretch begins, whose first rows have no value; how many have none behind the steps.
    pub(super) fn begin(&mut self, skip: usize) -> usize {
        if let Some(bias) = &mut self.bias {
            bias.rows.clear();
            bias.skip = skip;
        }
        skip + self.filter.as_mut().map_or(0, Filter::begin)
    }

    /// Every so many rows one has values.
    pub(super) fn every(&self) -> usize {
        self.filter.as_ref().map_or(1, |f| f.factor)
    }

    /// Rows at either end of a stretch without values.
    pub(super) fn left_out(&self) -> Option<[usize; 2]> {
        self.filter.as_ref().map(|f| [f.skip - f.late, f.late])
    }

    /// Times of more rows, s, with their lines; only a bias needs them.
    pub(super) fn rows(&mut self, mut rows: impl Iterator<Item = (f64, u64)>) {
        if let Some(bias) = &mut self.bias {
            while bias.skip > 0 && rows.next().is_some() {
                bias.skip -= 1;
            }
            bias.rows.extend(rows);
        }
    }

    /// Calibrated samples in, what comes out of the steps for them.
    pub(super) fn push(&mut self, mut values: Vec<Vec<f64>>, name: &str) -> Result<Vec<Vec<f64>>> {
        if let Some(bias) = &mut self.bias {
            let largest = bias.subtract(&mut values, name)?;
            let known = self.figures.bias_uncertainty.get_or_insert(0.0);
            *known = known.max(largest);
        }
        if let (Some(r), [x, y, z]) = (&self.rotation, values.as_mut_slice()) {
            for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
                [*x, *y, *z] = r.times([*x, *y, *z]);
            }
        }
        Ok(match &mut self.filter {
            Some(filter) => filter.push(values),
            None => values,
        })
    }
}

/// A number as short as it can be told.
fn short(v: f64) -> String {
    let rounded = (v * 1e9).round() / 1e9;
    format!("{rounded}")
}

impl BiasStep<'_> {
    /// The largest standard uncertainty of what was subtracted.
    fn subtract(&mut self, values: &mut [Vec<f64>], name: &str) -> Result<f64> {
        let mut largest = 0.0f64;
        for i in 0..values.first().map_or(0, Vec::len) {
            let Some((time, line)) = self.rows.pop_front() else {
                return Err(Trouble::data("samples have no time").detail(name));
            };
            let Some(bias) = self.track.at(time, &mut self.near) else {
                let [from, to] = self.track.span();
                return Err(Trouble::data(format!(
                    "the bias was tracked from {from} s to {to} s, and the recording is at {time} s here"
                ))
                .detail(format!("{name}:{line}"))
                .with_hint(format!(
                    "track the bias over the whole of this recording, or read the part that it covers: --between {from} {to}"
                )));
            };
            for (column, (b, u)) in values.iter_mut().zip(bias) {
                column[i] -= b;
                largest = largest.max(u);
            }
        }
        Ok(largest)
    }
}

impl Filter {
    fn new(chain: &Chain, rate: f64, figures: &mut ChainFigures) -> Result<Self> {
        let Some(low_pass) = chain.low_pass else {
            return Err(Trouble::request("there is no low-pass"));
        };
        let corner = low_pass.corner;
        let factor = chain.decimation.unwrap_or(1);
        let refused = |e: proofmass_core::Error| {
            Trouble::from(e).detail(format!(
                "low-pass with its corner at {corner} Hz, sampling rate {rate:.6} Hz"
            ))
        };
        if !(corner < 0.5 * rate) {
            return Err(Trouble::request(format!(
                "the corner of the low-pass, {corner} Hz, is not below half of the sampling rate, {:.6} Hz",
                0.5 * rate
            ))
            .with_hint("lower the corner, or leave the low-pass out"));
        }
        if factor > 1 && !(corner < 0.5 * rate / f64::from(factor)) {
            return Err(Trouble::request(format!(
                "a decimation by {factor} leaves {:.6} Hz, of which half is not above the corner of {corner} Hz",
                rate / f64::from(factor)
            ))
            .with_hint("lower the corner, or leave out fewer samples"));
        }
        let (filter, delay) = match low_pass.form {
            LowPassForm::Butterworth => {
                let low_pass = Butterworth::<f64>::new(corner, rate).map_err(|e| {
                    refused(e)
                        .with_hint("choose a corner between 1/10000 and 0.49 of the sampling rate")
                })?;
                let delay = low_pass.group_delay();
                let late = delay.round() as usize;
                let decimator = Decimator::new(low_pass, factor)?;
                figures.steps.push(format!(
                    "Butterworth low-pass of second order, -3.01 dB at {corner} Hz, {delay:.3} samples late at low frequency"
                ));
                if factor > 1 {
                    figures.folded = Some(decimator.folded_gain(corner, rate));
                }
                let filter = Self {
                    form: Form::Butterworth(decimator, Vec::new()),
                    factor: factor as usize,
                    skip: (low_pass.settling(SETTLED) as usize).max(late),
                    late,
                };
                (filter, delay)
            }
            LowPassForm::LinearPhase => {
                let stop = chain.stop(corner, rate);
                let fir = LinearPhase::low_pass([corner, stop], rate, chain.attenuation)
                    .map_err(|e| refused(e).with_hint("the low-pass falls too steeply for its length: raise a corner that is far below the rate; lower one that is near the end of the band, or leave out fewer samples"))?;
                let (late, length) = (fir.delay(), fir.taps().len());
                figures.steps.push(format!(
                    "low-pass of linear phase, {length} samples: gain within {:.2e} of one up to {corner} Hz, below {:.2e} from {stop:.6} Hz on, {late} samples late",
                    fir.ripple(),
                    fir.stop_gain()
                ));
                figures.ripple = Some(fir.ripple());
                if factor > 1 {
                    figures.folded = Some(fir.stop_gain());
                }
                let filter = Self {
                    form: Form::Linear(fir, Vec::new(), 0),
                    factor: factor as usize,
                    skip: length - 1,
                    late,
                };
                (filter, late as f64)
            }
        };
        figures.delay = delay / rate;
        figures.delay_left = (delay - filter.late as f64) / rate;
        figures.rate = Some(rate / f64::from(factor));
        if factor > 1 {
            figures.steps.push(format!(
                "one of {factor} samples kept, {:.6} Hz",
                rate / f64::from(factor)
            ));
        }
        Ok(filter)
    }

    /// Whether the low-pass leaves more than was asked of what decimation folds.
    fn folded(&self, chain: &Chain, rate: f64, figures: &ChainFigures) -> Option<Finding> {
        let (gain, low_pass) = (figures.folded?, chain.low_pass?);
        let reached = -20.0 * gain.log10();
        (reached < chain.attenuation - 1e-9).then(|| {
            findings::alias_not_suppressed(
                self.factor as u32,
                reached.max(0.0),
                rate / self.factor as f64 - low_pass.corner,
                low_pass.corner,
                chain.attenuation,
            )
        })
    }

    /// Another stretch; how many rows at its beginning have no value.
    fn begin(&mut self) -> usize {
        match &mut self.form {
            Form::Butterworth(_, states) => states.clear(),
            Form::Linear(_, kept, next) => {
                kept.clear();
                *next = self.skip;
            }
        }
        self.skip - self.late
    }

    fn push(&mut self, values: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        match &mut self.form {
            Form::Butterworth(decimator, states) => {
                if states.is_empty() && values.iter().all(|v| !v.is_empty()) {
                    let wait = u32::try_from(self.skip).unwrap_or(u32::MAX);
                    let at = |v: &Vec<f64>| DecimatorState::at([v[0]], wait);
                    *states = values.iter().map(at).collect();
                }
                let axes = values.into_iter().zip(states);
                axes.map(|(column, state)| {
                    let step = |v| decimator.step(state, [v]).map(|[v]| v);
                    column.into_iter().filter_map(step).collect()
                })
                .collect()
            }
            Form::Linear(filter, kept, next) => {
                let taps = filter.taps();
                kept.resize(values.len(), Vec::new());
                let mut first = *next;
                let out = kept
                    .iter_mut()
                    .zip(values)
                    .map(|(kept, column)| {
                        kept.extend(column);
                        let mut out = Vec::new();
                        first = *next;
                        while first < kept.len() {
                            let over = &kept[first + 1 - taps.len()..=first];
                            out.push(weighted_sum(taps, [over, &[]]));
                            first += self.factor;
                        }
                        // What the next result needs.
                        let done = (first + 1 - taps.len()).min(kept.len());
                        kept.drain(..done);
                        first -= done;
                        out
                    })
                    .collect();
                *next = first;
                out
            }
        }
    }
}
