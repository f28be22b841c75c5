//! Sine approximation: the complex amplitude of a steady vibration, with the covariance it deserves.

mod basis;
mod noise;
mod pass;
mod residue;
mod short;
mod spectrum;
mod stamped;
mod tables;
mod tones;

pub use spectrum::dominant_frequency;
pub use tones::Tone;

use basis::{Basis, Term};
use faer::Mat;
use num_complex::Complex64;
use pass::Ask;
use proofmass_core::Error;
use proofmass_uncertainty::algebra::{cholesky, product};
use residue::Residue;
use std::cell::OnceCell;
use std::f64::consts::TAU;
use tables::Tables;

/// What is known of the drive frequency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frequency {
    /// The generator and the sampling share a clock: three parameters per channel.
    Known,
    /// One unknown frequency for all channels, started at the nominal one: Gauss–Newton on the projected problem.
    Common,
}

/// Where the covariance of an amplitude comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Residuals {
    /// Residuals are taken as white: σ² (ΦᵀΦ)⁻¹ with all N − p degrees of freedom; a common frequency counts among the p.
    White,
    /// Only the residuals in the bins beside the drive frequency count: right for noise of any colour.
    Coloured,
}

/// The least-squares sine approximation of ISO 16063-11 (method 3) and IEEE 1057, many channels at a time.
///
/// x(t) = c + d t + Re Σ_h X_h e^{j h Ω t}, h = 1 … `harmonics`, t = 0 at the first sample.
///
/// A few blocks give a provisional fit. One reading of the samples then forms the residuals of that fit and their
/// moments, block by block against one short table, each block anchored to its exact phase: nothing accumulates and
/// no buffer as long as the record is made. The fit is the provisional one and a small step, so the variance of the
/// residuals stays right down to rounding, where x² − (fit)² would cancel.
///
/// **Units** frequencies in Hz; amplitudes in the unit of the samples, peak.
///
/// **Assumes** a period and a half in the record at least, and no tone but the harmonics within a few bins of the drive:
/// with [`SineApproximation::tones`] those that stand out are fitted too.
///
/// **Accuracy** phasors of a noise-free record are exact to 1e-12 of the amplitude
/// (`law_noise_free_records_return_the_truth`).
///
/// **Source** `[ISO16063-11]` method 3; `[IEEE1057]` 4.1.4; covariance from the neighbouring bins `[Kay]` 3.7.
///
/// ```
/// use proofmass_signal::sine::SineApproximation;
/// let x: Vec<f64> = (0..1000).map(|n| 2.0 * (0.1 * n as f64 + 0.5).cos()).collect();
/// let frequency = 0.1 / std::f64::consts::TAU * 1000.0;
/// let fit = SineApproximation::new(frequency).fit(1000.0, &[&x]).unwrap();
/// assert!((fit.channels[0].modulus() - 2.0).abs() < 1e-12);
/// assert!((fit.channels[0].phase() - 0.5).abs() < 1e-12);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SineApproximation {
    nominal: f64,
    start: Option<f64>,
    frequency: Frequency,
    drift: bool,
    harmonics: usize,
    residuals: Residuals,
    tones: bool,
}

/// One channel of a [`SineFit`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ChannelSine {
    /// Complex peak amplitude X of x(t) = Re(X e^{jΩt}), t = 0 at the first sample.
    pub amplitude: Complex64,
    /// Covariance of (Re X, Im X), given the frequency: `[rr, ri, ii]`. Below 13 periods what the frequency is not known
    /// by is in it.
    pub covariance: [f64; 3],
    /// Degrees of freedom of that covariance.
    pub dof: f64,
    /// Constant part, at the middle of the record.
    pub offset: f64,
    /// Linear drift in units per second; zero when not fitted.
    pub drift: f64,
    /// Complex amplitudes of the harmonics 2, 3, …
    pub harmonics: Vec<Complex64>,
    /// Root mean square of the residuals.
    pub residual_rms: f64,
}

impl ChannelSine {
    /// Peak amplitude.
    pub fn modulus(&self) -> f64 {
        self.amplitude.norm()
    }

    /// Phase in radians at the first sample, in (−π, π].
    pub fn phase(&self) -> f64 {
        self.amplitude.arg()
    }

    /// Total harmonic distortion √(Σ_{h≥2} |X_h|²)/|X_1| over the fitted harmonics; `None` when none was fitted
    /// or the fundamental is zero.
    pub fn thd(&self) -> Option<f64> {
        let fundamental = self.modulus();
        (!self.harmonics.is_empty() && fundamental > 0.0).then(|| {
            let power: f64 = self.harmonics.iter().map(|h| h.norm_sqr()).sum();
            power.sqrt() / fundamental
        })
    }

    /// Signal-to-noise ratio |X|²/2 over the residual power, in decibels; infinite without residuals.
    pub fn snr_db(&self) -> f64 {
        10.0 * (0.5 * self.amplitude.norm_sqr() / (self.residual_rms * self.residual_rms)).log10()
    }
}

/// What [`SineApproximation::fit`] found.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SineFit {
    /// The frequency of the fit in Hz.
    pub frequency: f64,
    /// Its standard uncertainty in Hz; `None` when it was known.
    ///
    /// An error of the frequency turns the phases of all channels alike, so ratios of channels do not feel it.
    pub frequency_uncertainty: Option<f64>,
    /// Channels in the order given.
    pub channels: Vec<ChannelSine>,
    /// Tones beside the drive that were fitted with it, with [`SineApproximation::tones`].
    pub tones: Vec<Tone>,
}

/// The three-parameter fit: amplitude, phase and offset of a sine whose frequency is known.
///
/// Residuals are taken as white, so that short records can be fitted; [`SineApproximation`] has the choice.
///
/// **Units** `sampling_rate` and `frequency` in Hz.
///
/// **Errors** as [`SineApproximation::fit`].
///
/// **Source** `[IEEE1057]` 4.1.4.1.
///
/// ```
/// use proofmass_signal::sine::{four_parameter_fit, three_parameter_fit};
///
/// let x: Vec<f64> = (0..64).map(|n| 1.5 + 2.0 * (0.7 * f64::from(n) + 0.5).cos()).collect();
/// let frequency = 0.7 / std::f64::consts::TAU * 100.0;
/// let known = three_parameter_fit(&x, 100.0, frequency)?;
/// assert!((known.modulus() - 2.0).abs() < 1e-9 && (known.phase() - 0.5).abs() < 1e-9);
/// let (found, sine) = four_parameter_fit(&x, 100.0)?;
/// assert!((found / frequency - 1.0).abs() < 1e-9 && (sine.offset - 1.5).abs() < 1e-9);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
pub fn three_parameter_fit(
    samples: &[f64],
    sampling_rate: f64,
    frequency: f64,
) -> Result<ChannelSine, Error> {
    let approximation = SineApproximation::new(frequency).residuals(Residuals::White);
    Ok(only(approximation.fit(sampling_rate, &[samples])?)?.1)
}

/// The four-parameter fit: frequency (Hz), and amplitude, phase and offset, started at the strongest line.
///
/// **Errors** as [`SineApproximation::fit`].
///
/// **Source** `[IEEE1057]` 4.1.4.3.
pub fn four_parameter_fit(
    samples: &[f64],
    sampling_rate: f64,
) -> Result<(f64, ChannelSine), Error> {
    let start = dominant_frequency(sampling_rate, samples)?;
    let approximation = SineApproximation::new(start)
        .frequency(Frequency::Common)
        .residuals(Residuals::White);
    only(approximation.fit(sampling_rate, &[samples])?)
}

/// Frequency and sine of the one channel.
fn only(fit: SineFit) -> Result<(f64, ChannelSine), Error> {
    let sine = fit.channels.into_iter().next().ok_or(Error::TooFew {
        name: "channels",
        needed: 1,
        got: 0,
    })?;
    Ok((fit.frequency, sine))
}

const ITERATIONS: usize = 30;
/// Iterations in which the weights of the channels are taken anew.
const REWEIGHTED: usize = 4;
/// Step of the frequency, in units of its u, that ends the search: a thousandth of u cannot be told from the minimum.
const NEAR: f64 = 1e-3;

impl SineApproximation {
    /// Three parameters at a known frequency in Hz: offset, cosine, sine; residuals of any colour.
    pub fn new(frequency: f64) -> Self {
        Self {
            nominal: frequency,
            start: None,
            frequency: Frequency::Known,
            drift: false,
            harmonics: 1,
            residuals: Residuals::Coloured,
            tones: false,
        }
    }

    /// Known or common unknown frequency.
    #[must_use]
    pub fn frequency(mut self, frequency: Frequency) -> Self {
        self.frequency = frequency;
        self
    }

    /// Where the search for a common unknown frequency begins, Hz: the strongest line of the record
    /// ([`dominant_frequency`]), which is within a fraction of a bin of it. Without one it begins at the nominal
    /// frequency, and a generator that is off by more than half a bin may not be found.
    #[must_use]
    pub fn start(mut self, frequency: f64) -> Self {
        self.start = Some(frequency);
        self
    }

    /// Fits a linear drift beside the offset.
    #[must_use]
    pub fn drift(mut self, drift: bool) -> Self {
        self.drift = drift;
        self
    }

    /// Highest harmonic that is fitted; 1 is the fundamental alone.
    #[must_use]
    pub fn harmonics(mut self, highest: usize) -> Self {
        self.harmonics = highest;
        self
    }

    /// How residuals become a covariance.
    #[must_use]
    pub fn residuals(mut self, residuals: Residuals) -> Self {
        self.residuals = residuals;
        self
    }

    /// Looks for tones beside the drive, such as hum of the mains, and fits those that stand out with it.
    #[must_use]
    pub fn tones(mut self, tones: bool) -> Self {
        self.tones = tones;
        self
    }

    /// Fits all channels, which were sampled together at `sampling_frequency` (Hz).
    ///
    /// **Shapes** every channel has the same length.
    ///
    /// # Errors
    /// [`Error::Length`] for channels of different length, [`Error::TooFew`] for less than four samples per
    /// parameter or none at all (128 for [`Residuals::Coloured`]), [`Error::OutOfRange`] for a harmonic at or
    /// above the Nyquist frequency or less than one period in the record, [`Error::NotFinite`] for a channel
    /// with a NaN, [`Error::NotConverged`] when there is no line within a bin of the start.
    pub fn fit(&self, sampling_frequency: f64, channels: &[&[f64]]) -> Result<SineFit, Error> {
        let first = self.plain(sampling_frequency, channels)?;
        if self.tones {
            return self.with_tones(sampling_frequency, channels, first);
        }
        Ok(first.0)
    }

    /// The drive and its harmonics alone.
    fn plain(
        &self,
        sampling_frequency: f64,
        channels: &[&[f64]],
    ) -> Result<(SineFit, State), Error> {
        let n = self.check(sampling_frequency, channels)?;
        let first = match (self.frequency, self.start) {
            (Frequency::Common, Some(start)) => start,
            _ => self.nominal,
        };
        let mut omega = TAU * first / sampling_frequency;
        let mut state = self.solve(omega, n, channels, None)?;
        let mut information = 0.0;
        if self.frequency == Frequency::Common {
            let start = omega;
            let mut converged = false;
            let mut step = f64::INFINITY;
            let mut weights = state.weights();
            // No farther at once than the main lobe is nearly a straight line, and less once the step turns round.
            let mut reach = 0.25 * TAU / n as f64;
            let mut before = 0.0;
            for iteration in 0..ITERATIONS {
                if iteration < REWEIGHTED {
                    // The noise beside the line is known once the line is; then the weights stay, so that the end is a
                    // minimum and not a walk about it.
                    weights = state.weights();
                }
                (step, information) = state.frequency_step(&weights);
                if !step.is_finite() {
                    break;
                }
                // Not worth another reading of the samples: the state is that of the minimum to a thousandth of u.
                if (step * information.sqrt()).abs() < NEAR && (step * n as f64).abs() < 1e-6 {
                    converged = true;
                    break;
                }
                if step * before < 0.0 {
                    reach = reach.min(0.5 * before.abs());
                }
                step = step.clamp(-reach, reach);
                before = step;
                if ((omega + step - start) * n as f64).abs() > TAU {
                    break;
                }
                omega += step;
                state = self.solve(omega, n, channels, Some(state.fitted))?;
                // Phase error left over the whole record, and the same in units of u: the next step is far shorter.
                if (step * n as f64).abs() < 1e-9 || (step * information.sqrt()).abs() < NEAR {
                    converged = true;
                    break;
                }
            }
            converged |= (step * information.sqrt()).abs() < NEAR;
            if !converged {
                return Err(Error::NotConverged {
                    name: "common frequency of the sine approximation",
                    iterations: ITERATIONS,
                    step: step / omega,
                });
            }
        }
        if self.frequency == Frequency::Common && self.residuals == Residuals::White {
            // The frequency is a parameter too: the channels share its degree of freedom as they share what is known of it.
            state.lost = state.shares(&state.weights());
            (_, information) = state.frequency_step(&state.weights());
        }
        let hertz = sampling_frequency / TAU;
        let fit = SineFit {
            frequency: omega * hertz,
            frequency_uncertainty: (self.frequency == Frequency::Common)
                .then(|| hertz / information.sqrt()),
            channels: state.channels(
                sampling_frequency,
                (self.frequency == Frequency::Common).then_some(information),
            ),
            tones: vec![],
        };
        Ok((fit, state))
    }

    fn check(&self, sampling_frequency: f64, channels: &[&[f64]]) -> Result<usize, Error> {
        let n = channels.first().map_or(0, |c| c.len());
        for channel in channels {
            if channel.len() != n {
                return Err(Error::Length {
                    name: "channel",
                    expected: n,
                    got: channel.len(),
                });
            }
        }
        let parameters = 1 + usize::from(self.drift) + 2 * self.harmonics.max(1);
        let needed = match self.residuals {
            Residuals::White => 4 * parameters,
            Residuals::Coloured => 128.max(4 * parameters),
        };
        if n < needed {
            return Err(Error::TooFew {
                name: "samples",
                needed,
                got: n,
            });
        }
        proofmass_core::check::positive("sampling frequency", sampling_frequency)?;
        let lowest = sampling_frequency / n as f64;
        let highest = 0.5 * sampling_frequency / self.harmonics.max(1) as f64;
        if !(self.nominal >= lowest && self.nominal < highest) {
            return Err(Error::OutOfRange {
                name: "frequency",
                value: self.nominal,
                min: lowest,
                max: highest,
            });
        }
        Ok(n)
    }

    fn solve(
        &self,
        omega: f64,
        n: usize,
        channels: &[&[f64]],
        provisional: Option<Vec<Coefficients>>,
    ) -> Result<State, Error> {
        let harmonics = self.harmonics.max(1);
        let tables = Tables::new(omega, n, harmonics);
        let basis = Basis::new(&tables, self.drift, harmonics, 0..tables.blocks());
        let gram = basis.gram();
        let llt = cholesky(&gram).map_err(|_| Error::Singular {
            name: "sine approximation",
            condition: f64::INFINITY,
        })?;
        let inverse = llt.inverse();
        let provisional = provisional
            .unwrap_or_else(|| residue::sketch(&tables, channels, self.drift, harmonics));
        let ask = Ask {
            drift: self.drift,
            weighted: self.frequency == Frequency::Common,
        };
        let (fitted, residues) =
            residue::refine(&tables, &basis, &llt, channels, provisional, ask)?;
        Ok(State {
            tables,
            basis,
            inverse,
            fitted,
            residues,
            residuals: self.residuals,
            lost: vec![0.0; channels.len()],
            left: OnceCell::new(),
        })
    }
}

/// Everything known at one frequency.
struct State {
    tables: Tables,
    basis: Basis,
    inverse: Mat<f64>,
    fitted: Vec<Coefficients>,
    residues: Vec<Residue>,
    residuals: Residuals,
    /// Degrees of freedom of each channel that a common frequency took.
    lost: Vec<f64>,
    /// Of a short record, once it is asked for.
    left: OnceCell<short::Left>,
}

/// Offset, drift per unit of τ, and the complex amplitudes about the middle of the record.
#[derive(Clone, Debug)]
pub(crate) struct Coefficients {
    pub(crate) offset: f64,
    pub(crate) drift: f64,
    pub(crate) amplitudes: Vec<Complex64>,
}

impl Coefficients {
    pub(crate) fn zero(harmonics: usize) -> Self {
        Self {
            offset: 0.0,
            drift: 0.0,
            amplitudes: vec![Complex64::new(0.0, 0.0); harmonics],
        }
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.offset += other.offset;
        self.drift += other.drift;
        for (a, b) in self.amplitudes.iter_mut().zip(&other.amplitudes) {
            *a += b;
        }
    }

    pub(crate) fn is_finite(&self) -> bool {
        let parts = self.amplitudes.iter().flat_map(|a| [a.re, a.im]);
        parts.chain([self.offset, self.drift]).all(f64::is_finite)
    }
}

impl State {
    fn variance(&self, channel: usize) -> f64 {
        let fit = &self.fitted[channel];
        let size = fit.offset.abs() + fit.amplitudes[0].norm();
        // Rounding of the samples themselves: an exact record is not infinitely sure.
        let floor = (f64::EPSILON * size).powi(2).max(f64::MIN_POSITIVE);
        (self.residues[channel].power / self.dof(channel)).max(floor)
    }

    /// Degrees of freedom of the residuals of a channel.
    fn dof(&self, channel: usize) -> f64 {
        let parameters = self.basis.terms().len() as f64 + self.lost[channel];
        self.tables.samples as f64 - parameters
    }

    /// Whether the bins beside the drive are those of offset and mirror too.
    fn is_short(&self) -> bool {
        self.tables.omega * (self.tables.samples as f64) < short::FEW * TAU
    }

    /// Covariance of the amplitude from the noise beside it, about the middle of the record.
    fn coloured(&self, channel: usize) -> ([f64; 3], f64) {
        let residue = &self.residues[channel];
        if self.is_short() {
            let (tables, basis, inverse) = (&self.tables, &self.basis, &self.inverse);
            let left = self
                .left
                .get_or_init(|| short::Left::new(tables, basis, inverse));
            short::covariance(residue, tables, basis, inverse, left)
        } else {
            noise::local(residue, &self.tables)
        }
    }

    /// In a short record, or few bins from Nyquist, an error of the frequency changes amplitudes even about the middle: its part
    /// of the covariance.
    fn with_frequency(&self, channel: usize, [rr, ri, ii]: [f64; 3], information: f64) -> [f64; 3] {
        let cross = self.cross(channel);
        let step = &self.inverse * &cross;
        let (c, s) = self.basis.fundamental();
        let (a, b) = (step[(c, 0)], -step[(s, 0)]);
        let v = 1.0 / information;
        [rr + v * a * a, ri + v * a * b, ii + v * b * b]
    }

    /// ∂x/∂ω = Re (N/2) τ j X e^{jωn} of a channel. Harmonics know the frequency h times better than the drive does, but only
    /// where they are its own: hum beside one would pull the drive along with it.
    fn slope(&self, channel: usize) -> Term {
        let half = 0.5 * self.tables.samples as f64;
        Term::new(
            Complex64::new(0.0, half) * self.fitted[channel].amplitudes[0],
            1,
            1,
        )
    }

    /// ⟨basis, ∂x/∂ω⟩ of a channel.
    fn cross(&self, channel: usize) -> Mat<f64> {
        let slope = self.slope(channel);
        Mat::from_fn(self.basis.terms().len(), 1, |i, _| {
            self.basis.inner(&self.basis.terms()[i], &slope)
        })
    }

    /// Weight of each channel in the search for the frequency. Colour changes the noise near the drive by a factor; it
    /// weighs channels and scales the answer.
    fn weights(&self) -> Vec<f64> {
        (0..self.fitted.len())
            .map(|channel| match self.residuals {
                Residuals::White => 1.0 / self.variance(channel),
                Residuals::Coloured => {
                    let (covariance, _) = self.coloured(channel);
                    let density =
                        0.25 * self.tables.samples as f64 * (covariance[0] + covariance[2]);
                    1.0 / density
                        .max(f64::EPSILON * f64::EPSILON * self.variance(channel))
                        .max(f64::MIN_POSITIVE)
                }
            })
            .collect()
    }

    /// What each channel says of the frequency, with the linear parameters projected out.
    fn informations(&self, weights: &[f64]) -> Vec<f64> {
        (0..weights.len())
            .map(|channel| {
                let (slope, cross) = (self.slope(channel), self.cross(channel));
                let square = self.basis.inner(&slope, &slope);
                weights[channel]
                    * (square
                        - product([cross.transpose(), self.inverse.as_ref(), cross.as_ref()])
                            [(0, 0)])
            })
            .collect()
    }

    /// The part of each channel in what is known of the frequency.
    fn shares(&self, weights: &[f64]) -> Vec<f64> {
        let informations = self.informations(weights);
        let total: f64 = informations.iter().sum();
        informations.iter().map(|i| i / total).collect()
    }

    /// Gauss–Newton step of the angular frequency (rad per sample) and the information about it, with the
    /// linear parameters projected out.
    fn frequency_step(&self, weights: &[f64]) -> (f64, f64) {
        let (mut gradient, mut information) = (0.0, 0.0);
        for (channel, own) in self.informations(weights).into_iter().enumerate() {
            let slope = self.slope(channel);
            let along = (slope.coefficient * self.residues[channel].weighted[0].conj()).re;
            gradient += weights[channel] * along;
            information += own;
        }
        (gradient / information, information)
    }

    fn channels(&self, sampling_frequency: f64, information: Option<f64>) -> Vec<ChannelSine> {
        let n = self.tables.samples as f64;
        let middle = 0.5 * (n - 1.0);
        let (c, s) = self.basis.fundamental();
        (0..self.fitted.len())
            .map(|channel| {
                let fit = &self.fitted[channel];
                let (centred, dof) = match self.residuals {
                    Residuals::White => {
                        let v = self.variance(channel);
                        let q = &self.inverse;
                        // X = a − j b for x = a cos + b sin.
                        let covariance = [v * q[(c, c)], -v * q[(c, s)], v * q[(s, s)]];
                        (covariance, self.dof(channel))
                    }
                    Residuals::Coloured => self.coloured(channel),
                };
                let centred = match information {
                    Some(information) => self.with_frequency(channel, centred, information),
                    None => centred,
                };
                let turn = |h: usize| {
                    let phase = -(h as f64) * self.tables.omega * middle;
                    Complex64::new(phase.cos(), phase.sin())
                };
                ChannelSine {
                    amplitude: fit.amplitudes[0] * turn(1),
                    covariance: rotate(centred, turn(1)),
                    dof,
                    offset: fit.offset,
                    drift: fit.drift * 2.0 * sampling_frequency / n,
                    harmonics: fit.amplitudes[1..]
                        .iter()
                        .enumerate()
                        .map(|(i, a)| a * turn(i + 2))
                        .collect(),
                    residual_rms: (self.residues[channel].power / n).sqrt(),
                }
            })
            .collect()
    }
}

/// Covariance of (Re, Im) after a turn by the unit phasor w.
fn rotate([rr, ri, ii]: [f64; 3], w: Complex64) -> [f64; 3] {
    let (c, s) = (w.re, w.im);
    [
        c * c * rr - 2.0 * c * s * ri + s * s * ii,
        c * s * (rr - ii) + (c * c - s * s) * ri,
        s * s * rr + 2.0 * c * s * ri + c * c * ii,
    ]
}

#[cfg(test)]
mod tests;
