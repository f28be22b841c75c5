//! Sensitivity of a device from a shock that a reference has measured: by peak, by integral, by spectrum.

use super::pulse::{Functional, Pulse, PulseMeasures, PulseSearch};
use super::quiet::Quiet;
use super::{NoPulse, PulseContext, pulse_findings};
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_signal::{Welch, fourier};
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding, Influence,
};
use serde::{Deserialize, Serialize};

/// What is known of the reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct ShockReference {
    /// Relative standard uncertainty of the reference acceleration.
    pub relative_uncertainty: f64,
    /// Degrees of freedom of that uncertainty; infinite when `None`.
    pub dof: Option<DegreesOfFreedom>,
}

/// Sensitivity at one frequency of the pulse's spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SpectrumLine {
    /// Hz.
    pub frequency: f64,
    /// Output over reference, real part; output unit per m/s².
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// Standard uncertainty of the modulus from the noise, relative; of the phase in rad as well.
    pub relative_uncertainty: f64,
    /// Modulus of the reference spectrum, m/s.
    pub reference: f64,
}

impl SpectrumLine {
    /// The sensitivity as a complex number.
    pub fn value(&self) -> Complex64 {
        Complex64::new(self.re, self.im)
    }
}

/// A shock calibration: the pulse in both channels and the sensitivity three ways.
///
/// S_p = û/â from the tops, S_i = ∫u dt/∫a dt over the pulse, S_s = Σ U A*/Σ|A|² over the lines of the pulse's spectrum above
/// a tenth of its greatest. The three differ where the device does not follow the pulse: the peak sees its resonance, the
/// integral its lowest frequencies.
///
/// **Uncertainty** of the noise by the same weights slid over the quiet stretch of both channels (colour and what they share
/// are in it); the reference as one relative cause common to all three.
///
/// **Accuracy** 95 % intervals of all three cover in 400 simulated shocks with white and coloured noise
/// (`coverage_shock_sensitivity`).
///
/// **Source** `[ISO16063-13]`, `[ISO16063-22]`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ShockCalibration {
    /// Where the pulse is in the reference.
    pub reference_pulse: Pulse,
    /// Its measures, m/s² and s.
    pub reference: PulseMeasures,
    /// Where it is in the output.
    pub output_pulse: Pulse,
    /// Its measures in the output.
    pub output: PulseMeasures,
    /// `sensitivity.peak`, `sensitivity.integral`, `sensitivity.spectrum`; those that the pulse gives.
    pub estimate: Estimate,
    /// Lines of the spectrum.
    pub lines: Vec<SpectrumLine>,
    /// Time by which the output follows the reference, s, with its standard uncertainty.
    pub delay: Option<(f64, f64)>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

/// Why there is no shock calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoCalibration {
    /// No pulse in the reference.
    Reference(NoPulse),
    /// No pulse in the output.
    Output(NoPulse),
    /// The data cannot be worked with.
    Data(Error),
}

impl From<Error> for NoCalibration {
    fn from(error: Error) -> Self {
        Self::Data(error)
    }
}

/// One sensitivity on the way: value, derivative with respect to output and reference readings.
struct Ratio {
    name: &'static str,
    value: f64,
    output: Functional,
    reference: Functional,
    by: f64,
}

impl ShockCalibration {
    /// Calibrates `output`, in `unit`, against `reference` in m/s², sampled together at `rate`.
    ///
    /// # Errors
    /// No pulse in either channel; lengths that differ; what [`PulseSearch::find`] refuses; no quiet stretch of 16 samples
    /// before the pulse, without which nothing is known of baseline and noise.
    pub fn evaluate(
        reference: &[f64],
        output: &[f64],
        rate: f64,
        unit: &str,
        search: &PulseSearch,
        known: &ShockReference,
    ) -> Result<Self, NoCalibration> {
        if reference.len() != output.len() {
            return Err(NoCalibration::Data(Error::Length {
                name: "output",
                expected: reference.len(),
                got: output.len(),
            }));
        }
        let mut pulse_r = search.find(reference)?.map_err(NoCalibration::Reference)?;
        let mut pulse_o = search.find(output)?.map_err(NoCalibration::Output)?;
        let before = pulse_r.quiet.min(pulse_o.quiet);
        let quiet =
            Quiet::new(&[&output[..before], &reference[..before]]).ok_or(Error::TooFew {
                name: "quiet samples before the pulse",
                needed: Quiet::SHORTEST,
                got: before,
            })?;
        pulse_o.baseline = quiet.baseline[0];
        pulse_r.baseline = quiet.baseline[1];
        (pulse_r.quiet, pulse_o.quiet) = (before, before);
        let measures_r = pulse_r.measure(reference, rate);
        let measures_o = pulse_o.measure(output, rate);
        let mut ratios = vec![ratio(
            "sensitivity.peak",
            pulse_o.peak_functional(output).0,
            pulse_r.peak_functional(reference).0,
            (output, pulse_o.baseline),
            (reference, pulse_r.baseline),
        )];
        let whole = pulse_r.whole(reference).zip(pulse_o.whole(output));
        if let Some(((r0, r1), (o0, o1))) = whole {
            // One interval for both, that of the longer: what the device adds by its delay is in it.
            let range = (r0.min(o0), r1.max(o1));
            ratios.push(ratio(
                "sensitivity.integral",
                Pulse::integral_functional(range),
                Pulse::integral_functional(range),
                (output, pulse_o.baseline),
                (reference, pulse_r.baseline),
            ));
        }
        let spectrum = Spectrum::of(reference, output, rate, &pulse_r, &pulse_o, &quiet);
        let estimate = estimate(&ratios, spectrum.as_ref(), &quiet, unit, known)?;
        let delay = spectrum.as_ref().and_then(|s| s.delay(&quiet));
        let lines = spectrum.map_or_else(Vec::new, |s| s.lines);
        let context = PulseContext {
            rate,
            unit: "m/s²",
            role: "reference",
        };
        let mut findings = pulse_findings(&pulse_r, &measures_r, reference, &context);
        findings.extend(pulse_findings(
            &pulse_o,
            &measures_o,
            output,
            &PulseContext {
                rate,
                unit,
                role: "output",
            },
        ));
        let mut result = Self {
            reference_pulse: pulse_r,
            reference: measures_r,
            output_pulse: pulse_o,
            output: measures_o,
            estimate,
            lines,
            delay,
            findings,
        };
        let pair = result.pair_findings(rate, unit);
        result.findings.extend(pair);
        result
            .findings
            .sort_by_key(|f| std::cmp::Reverse(f.severity()));
        Ok(result)
    }
}

fn ratio(
    name: &'static str,
    output: Functional,
    reference: Functional,
    (o, o_base): (&[f64], f64),
    (r, r_base): (&[f64], f64),
) -> Ratio {
    let (top, below) = (output.read(o, o_base), reference.read(r, r_base));
    Ratio {
        name,
        value: top / below,
        output,
        reference,
        by: below,
    }
}

/// The joint estimate: noise of all readings together, the reference as one cause.
fn estimate(
    ratios: &[Ratio],
    spectrum: Option<&Spectrum>,
    quiet: &Quiet,
    unit: &str,
    known: &ShockReference,
) -> Result<Estimate, Error> {
    let unit = format!("{unit}/(m/s²)");
    let mut components: Vec<Component> = ratios
        .iter()
        .map(|r| Component::new(r.name, unit.clone(), r.value))
        .collect();
    let mut variances = Vec::new();
    for r in ratios {
        let first = r.output.first.min(r.reference.first);
        let last = |f: &Functional| f.first + f.weights.len();
        let length = last(&r.output).max(last(&r.reference)) - first;
        let placed = |f: &Functional| {
            let mut w = vec![0.0; length];
            w[f.first - first..f.first - first + f.weights.len()].copy_from_slice(&f.weights);
            w
        };
        let noise = quiet.covariance(&[placed(&r.output), placed(&r.reference)]);
        let [oo, or, _, rr] = noise.covariance[..] else {
            continue;
        };
        let v = (oo - 2.0 * r.value * or + r.value * r.value * rr) / (r.by * r.by);
        variances.push((v.max(0.0), noise.dof));
    }
    if let Some(s) = spectrum {
        components.push(Component::new("sensitivity.spectrum", unit.clone(), s.gain));
        variances.push((s.gain_variance, s.dof));
    }
    let n = components.len();
    let mut influences = Vec::new();
    // The three read the same noise, but with degrees of freedom of their own; each stands as a cause by itself.
    for (i, (v, dof)) in variances.iter().enumerate() {
        let mut rows = vec![0.0; n * n];
        rows[i * n + i] = *v;
        influences.push(Influence {
            key: format!(
                "noise.{}",
                components[i].name.trim_start_matches("sensitivity.")
            ),
            description: "noise of both channels, from the baseline before the pulse".into(),
            evaluation: Evaluation::A,
            distribution: "normal".into(),
            dof: DegreesOfFreedom::new(*dof).unwrap_or(DegreesOfFreedom::INFINITE),
            effect: Effect::Joint {
                covariance: Covariance::try_from_rows(n, &rows)?,
            },
        });
    }
    if known.relative_uncertainty > 0.0 {
        influences.push(Influence {
            key: "reference".into(),
            description: "relative error of the reference acceleration".into(),
            evaluation: Evaluation::B,
            distribution: "normal".into(),
            dof: known.dof.unwrap_or(DegreesOfFreedom::INFINITE),
            effect: Effect::of_zero(
                "1",
                known.relative_uncertainty,
                components.iter().map(|c| -c.value).collect(),
            ),
        });
    }
    Estimate::new(components, influences)
}

/// Spectra of both channels over one window around the pulse.
struct Spectrum {
    lines: Vec<SpectrumLine>,
    gain: f64,
    gain_variance: f64,
    dof: f64,
}

impl Spectrum {
    fn of(
        reference: &[f64],
        output: &[f64],
        rate: f64,
        pulse_r: &Pulse,
        pulse_o: &Pulse,
        quiet: &Quiet,
    ) -> Option<Self> {
        let (start, end) = (pulse_r.start?, pulse_r.end?);
        let (_, output_end) = (pulse_o.start?, pulse_o.end?);
        let duration = end - start;
        let from = (start - 0.5 * duration).max(0.0) as usize;
        let to = ((output_end.max(end) + 3.0 * duration) as usize).min(reference.len());
        let window =
            |x: &[f64], base: f64| -> Vec<f64> { x[from..to].iter().map(|v| v - base).collect() };
        let n = to - from;
        let a = fourier::forward(&window(reference, pulse_r.baseline));
        let u = fourier::forward(&window(output, pulse_o.baseline));
        // E|noise line|² = n f_s G/2 for a one-sided density G.
        let segment = (quiet.len() / 4).clamp(8, 4096);
        let welch = Welch::new(segment);
        let densities = [0, 1].map(|c| welch.density(quiet.channel(c), rate));
        let [Ok(noise_u), Ok(noise_a)] = densities else {
            return None;
        };
        let at = |d: &proofmass_signal::Density, f: f64| {
            let k = ((f / d.bin_width).round() as usize).clamp(1, d.density.len() - 1);
            (0.5 * n as f64 * rate * d.density[k], d.dof[k])
        };
        let greatest = a.iter().skip(1).map(|z| z.norm()).fold(0.0, f64::max);
        let mut lines = Vec::new();
        let (mut cross, mut auto, mut variance, mut dof) = (0.0, 0.0, 0.0, f64::INFINITY);
        let mut kept = Vec::new();
        for k in 1..a.len() {
            let f = k as f64 * rate / n as f64;
            let (va, vu) = (at(&noise_a, f), at(&noise_u, f));
            // Contiguous from below: beyond the first gap the pulse has lobes that the noise governs.
            if a[k].norm() < 0.1 * greatest || a[k].norm_sqr() < 100.0 * va.0 {
                break;
            }
            let s = u[k] / a[k];
            let relative = 0.5 * (vu.0 / u[k].norm_sqr() + va.0 / a[k].norm_sqr());
            lines.push(SpectrumLine {
                frequency: f,
                re: s.re,
                im: s.im,
                relative_uncertainty: relative.sqrt(),
                reference: a[k].norm() / rate,
            });
            cross += (u[k] * a[k].conj()).re;
            auto += a[k].norm_sqr();
            kept.push((a[k].norm_sqr(), va.0, vu.0));
            dof = dof.min(vu.1);
        }
        if lines.is_empty() {
            return None;
        }
        let gain = cross / auto;
        for (power, va, vu) in kept {
            variance += 0.5 * power * (vu + gain * gain * va);
        }
        Some(Self {
            lines,
            gain,
            gain_variance: variance / (auto * auto),
            dof,
        })
    }

    /// Delay from the phase against frequency, weighted by what is known of it.
    fn delay(&self, quiet: &Quiet) -> Option<(f64, f64)> {
        // A baseline that wanders turns the lowest lines; too few lines give no slope.
        if self.lines.len() < 2 || quiet.len() < Quiet::SHORTEST {
            return None;
        }
        let (mut sum, mut weight) = (0.0, 0.0);
        for line in &self.lines {
            let omega = std::f64::consts::TAU * line.frequency;
            // The sign of the sensitivity is no delay.
            let s = line.value() * self.gain.signum();
            let w = (omega / line.relative_uncertainty.max(1e-9)).powi(2);
            sum += w * (-s.arg() / omega);
            weight += w;
        }
        Some((sum / weight, weight.recip().sqrt()))
    }
}
