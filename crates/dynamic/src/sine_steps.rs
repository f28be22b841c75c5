//! Stepped sine: where a recording stays at one frequency, and the frequency response from sine approximations there.

mod plateaus;
#[cfg(test)]
mod tests;

pub use plateaus::{NoSteps, Plateau};

use crate::findings;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_signal::saturation::rails;
use proofmass_signal::sine::{Frequency, Residuals, SineApproximation, SineFit};
use proofmass_signal::transfer::ResponseEstimate;
use proofmass_uncertainty::Finding;

/// How steps are looked for and what of each is used.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SineSteps {
    /// Share of a step, from its beginning, that is left to the device to settle.
    pub settling: f64,
    /// Periods that must remain.
    pub periods: usize,
}

impl Default for SineSteps {
    /// The first three tenths of a step are left out; six periods at least remain.
    fn default() -> Self {
        Self {
            settling: 0.3,
            periods: 6,
        }
    }
}

/// One step: input and output as phasors, and what they say together.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SineStep {
    /// Hz, from a fit common to both channels.
    pub frequency: f64,
    /// First sample used and the one after the last.
    pub samples: [usize; 2],
    /// Amplitude of the input, peak.
    pub amplitude: f64,
    /// Output over input.
    pub response: Complex64,
    /// Covariance rr, ri, ii of it, from both fits.
    pub covariance: [f64; 3],
    /// Degrees of freedom of that covariance.
    pub dof: f64,
}

/// Steps of a recording, ascending in time.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FoundSteps {
    /// Those that were fitted.
    pub steps: Vec<SineStep>,
    /// What to doubt, and what was left out.
    pub findings: Vec<Finding>,
}

/// Why there is no response from steps.
#[derive(Clone, Debug, PartialEq)]
pub enum NoResponse {
    /// No steps.
    Steps(NoSteps),
    /// Steps, of which none can be used: they are too short or at the end of the range; what was found of each.
    Unusable(Vec<Finding>),
    /// The data cannot be worked with.
    Data(Error),
}

impl From<Error> for NoResponse {
    fn from(error: Error) -> Self {
        Self::Data(error)
    }
}

/// Where a recording stays at one frequency and amplitude, in order of time.
///
/// # Errors
/// Below 64 samples, and for a sample that is not finite; the inner error where there are no such stretches.
pub fn plateaus(x: &[f64], rate: f64) -> Result<Result<Vec<Plateau>, NoSteps>, Error> {
    plateaus::find(x, rate)
}

/// Samples below which there are no bins for [`Residuals::Coloured`].
const FEW: usize = 256;

impl SineSteps {
    /// Finds the steps of an input, sampled at `rate` together with an output, and fits a sine of common frequency to both in each.
    ///
    /// The ratio of the two phasors has the covariance of both fits, residuals of any colour within the neighbouring bins.
    ///
    /// **Accuracy** 95 % intervals of real and imaginary part hold under noise on both channels
    /// (`coverage_of_stepped_sines`).
    ///
    /// **Source** `[ISO16063-11]` method 3, `[ISO16063-21]`.
    ///
    /// # Errors
    /// No steps, or none of use; [`Error::Length`] for channels of different lengths, [`Error::NotFinite`].
    pub fn evaluate(
        &self,
        input: &[f64],
        output: &[f64],
        rate: f64,
    ) -> Result<FoundSteps, NoResponse> {
        if input.len() != output.len() {
            return Err(Error::Length {
                name: "output beside the input",
                expected: input.len(),
                got: output.len(),
            }
            .into());
        }
        if let Some(index) = output.iter().position(|v| !v.is_finite()) {
            return Err(Error::NotFinite {
                name: "output",
                index,
            }
            .into());
        }
        let plateaus = plateaus::find(input, rate)?.map_err(NoResponse::Steps)?;
        let mut found = FoundSteps::default();
        let (mut short, mut flat, mut restless) = (Vec::new(), Vec::new(), Vec::new());
        for plateau in &plateaus {
            let f = plateau.frequency;
            let period = rate / f;
            let whole = (plateau.to - plateau.from) as f64;
            // One period is left out at the end, where the generator may already be on its way.
            let from = plateau.from as f64 + (self.settling * whole).max(2.0 * period);
            let to = plateau.to as f64 - period;
            let periods = ((to - from) / period).floor();
            if periods < self.periods as f64 {
                short.push(format!("{f:.2} Hz ({:.0} periods)", whole / period));
                continue;
            }
            let from = from as usize;
            let to = (from + (periods * period).round() as usize).min(input.len());
            let (x, y) = (&input[from..to], &output[from..to]);
            let cut = |x: &[f64]| x.iter().all(|v| *v == x[0]) || !rails(x).is_empty();
            if cut(x) || cut(y) {
                flat.push(format!("{f:.2} Hz"));
                continue;
            }
            let step = fitted(x, y, rate, f, [from, to], Residuals::Coloured)?;
            let middle = x.len() / 2;
            // What is not settled lies beside the frequency, where coloured residuals are looked for: they would excuse it.
            let half = |part: std::ops::Range<usize>| {
                let (x, y) = (&x[part.clone()], &y[part]);
                fitted(x, y, rate, f, [0, 0], Residuals::White)
            };
            if let (Ok(a), Ok(b)) = (half(0..middle), half(middle..x.len())) {
                let apart = (a.response - b.response).norm();
                let u = [a.covariance, b.covariance]
                    .iter()
                    .map(|c| c[0] + c[2])
                    .sum::<f64>()
                    .sqrt();
                let share = apart / step.response.norm();
                if apart > 10.0 * u && share > 0.01 {
                    restless.push(format!("{f:.2} Hz ({:.1} %)", 100.0 * share));
                }
            }
            found.steps.push(step);
        }
        let list = |what: &[String]| match what {
            [.., _] if what.len() > 8 => {
                format!("{}, … ({} in all)", what[..8].join(", "), what.len())
            }
            few => few.join(", "),
        };
        if !short.is_empty() {
            found
                .findings
                .push(findings::steps_too_short(&list(&short), self.periods));
        }
        if !flat.is_empty() {
            found
                .findings
                .push(proofmass_uncertainty::findings::clipped(
                    "a channel stays at the end of its range in some steps, which were left out",
                    &list(&flat),
                    "lower the level there",
                ));
        }
        if !restless.is_empty() {
            found
                .findings
                .push(findings::step_not_settled(&list(&restless)));
        }
        if found.steps.is_empty() {
            return Err(NoResponse::Unusable(found.findings));
        }
        Ok(found)
    }
}

/// The response at the frequencies of steps, those of one frequency [`merged`].
pub fn response_of(steps: Vec<SineStep>) -> ResponseEstimate {
    let steps = merged(steps);
    ResponseEstimate {
        frequency: steps.iter().map(|s| s.frequency).collect(),
        value: steps.iter().map(|s| s.response).collect(),
        covariance: steps.iter().map(|s| s.covariance).collect(),
        dof: steps.iter().map(|s| s.dof).collect(),
        coherence: Vec::new(),
        leakage: vec![Default::default(); steps.len()],
        independent_every: 1,
    }
}

/// The same frequency measured more than once: the mean, with the mean's covariance.
pub fn merged(mut steps: Vec<SineStep>) -> Vec<SineStep> {
    steps.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
    let mut groups: Vec<Vec<SineStep>> = Vec::new();
    for step in steps {
        match groups.last_mut() {
            Some(group) if step.frequency < group[0].frequency * (1.0 + 1e-3) => group.push(step),
            _ => groups.push(vec![step]),
        }
    }
    groups
        .into_iter()
        .map(|group| {
            let n = group.len() as f64;
            let mean = |of: &dyn Fn(&SineStep) -> f64| group.iter().map(of).sum::<f64>() / n;
            SineStep {
                frequency: mean(&|s| s.frequency),
                amplitude: mean(&|s| s.amplitude),
                response: Complex64::new(mean(&|s| s.response.re), mean(&|s| s.response.im)),
                covariance: [0, 1, 2].map(|i| mean(&|s| s.covariance[i]) / n),
                dof: group.iter().map(|s| s.dof).sum(),
                samples: group[0].samples,
            }
        })
        .collect()
}

fn fitted(
    x: &[f64],
    y: &[f64],
    rate: f64,
    frequency: f64,
    samples: [usize; 2],
    residuals: Residuals,
) -> Result<SineStep, Error> {
    let residuals = if x.len() < FEW {
        Residuals::White
    } else {
        residuals
    };
    // Harmonics of a shaker lie among no neighbouring bins, but within few periods they do lean on them.
    let below_nyquist = (0.5 * rate / frequency).ceil() as usize - 1;
    let fit: SineFit = SineApproximation::new(frequency)
        .start(frequency)
        .frequency(Frequency::Common)
        .harmonics(below_nyquist.clamp(1, 3))
        .residuals(residuals)
        .fit(rate, &[x, y])?;
    let [a, b] = fit.channels.as_slice() else {
        return Err(Error::Length {
            name: "channels",
            expected: 2,
            got: fit.channels.len(),
        });
    };
    let response = b.amplitude / a.amplitude;
    let (of_x, of_y) = (
        proofmass_signal::transfer::turned(a.covariance, response / a.amplitude),
        proofmass_signal::transfer::turned(b.covariance, 1.0 / a.amplitude),
    );
    Ok(SineStep {
        frequency: fit.frequency,
        samples,
        amplitude: a.amplitude.norm(),
        response,
        covariance: std::array::from_fn(|i| of_x[i] + of_y[i]),
        dof: a.dof.min(b.dof),
    })
}
