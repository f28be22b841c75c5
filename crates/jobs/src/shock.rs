//! Shock: the pulse, the sensitivity against a reference, the shock response spectrum.

mod outcome;
mod page;
mod required;

pub use outcome::{ShockChannel, ShockOutcome, ShockSpectra, SpectrumVerdict};
pub use required::required_spectrum;

use crate::channels::Channel;
use crate::findings;
use crate::outcome::Job;
use crate::response::of_one_size;
use crate::trouble::{Result, Trouble};
use proofmass_core::{Error, Watch};
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_dynamic::shock::{
    FlatStandard, NoCalibration, NoPulse, Pulse, PulseContext, PulseSearch, ShockCalibration,
    ShockReference, SpectrumRequest, SpectrumTolerance, Tolerance, ToleranceResult, pulse_findings,
    required_at,
};
use proofmass_report::number::{plain, scientific};
use proofmass_signal::{Extremes, Peaks, Trace, octaves};
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};

/// What is asked of a recorded shock.
///
/// ```
/// use proofmass_jobs::shock::{ShockData, ShockJob};
/// use proofmass_jobs::{Channel, Job, Outcome, Unwatched};
/// use proofmass_signal::PulseShape;
///
/// // 50 g for 11 ms, with a trace of noise before and after.
/// let pulse = PulseShape::HalfSine.record(490.3325, 0.011, 0.1, 30_000, 100e3);
/// let record: Vec<f64> = pulse.iter().enumerate().map(|(k, a)| a + 1e-3 * (k as f64).sin()).collect();
/// let data = ShockData {
///     reference: None,
///     output: Channel { name: "a", unit: "m/s²", data: &record },
///     rate: 100e3,
///     findings: &[],
///     name: "pulse",
/// };
/// let outcome = ShockJob::default().evaluate(&data, &Unwatched)?;
/// let peak = outcome.quantities().into_iter().find(|q| q.name == "peak").unwrap();
/// assert!((peak.value - 490.33).abs() < 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct ShockJob {
    /// How the pulse is looked for.
    pub search: PulseSearch,
    /// What is known of the reference, or of the one channel where there is none.
    pub reference: ShockReference,
    /// Lowest and highest natural frequency, Hz; chosen by duration and rate when `None`.
    pub frequencies: Option<[f64; 2]>,
    /// Natural frequencies to the octave.
    pub per_octave: u32,
    /// Quality factor Q = 1/(2ζ).
    pub quality: f64,
    /// Where extremes are looked for.
    pub peaks: Peaks,
    /// Nominal pulse and tolerance; its peak in m/s².
    pub tolerance: Option<Tolerance>,
    /// Shock response spectrum that is required, Hz and m/s², ascending; that of the nominal pulse when empty.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub required: Vec<(f64, f64)>,
    /// How far the spectrum may depart from it.
    pub spectrum_tolerance: SpectrumTolerance,
    /// Half-width of the band about the baseline before the pulse into which the device returns, in m/s² or the unit of its output; what
    /// the noise before the pulse gives without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub return_band: Option<f64>,
    /// Calibration over frequency of the reference, whose channel is then in volts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standard: Option<ReferenceTable>,
}

impl Default for ShockJob {
    fn default() -> Self {
        Self {
            search: PulseSearch::default(),
            reference: ShockReference::default(),
            frequencies: None,
            per_octave: 12,
            quality: 10.0,
            peaks: Peaks::AtSamples,
            tolerance: None,
            required: Vec::new(),
            spectrum_tolerance: SpectrumTolerance::default(),
            return_band: None,
            standard: None,
        }
    }
}

/// A recorded shock.
#[derive(Clone, Debug)]
pub struct ShockData<'a> {
    /// Reference acceleration, m/s².
    pub reference: Option<Channel<'a>>,
    /// The device.
    pub output: Channel<'a>,
    /// Samples per second.
    pub rate: f64,
    /// What reading the data found.
    pub findings: &'a [Finding],
    /// What the recording is called in messages.
    pub name: &'a str,
}

fn no_pulse(role: &str, why: NoPulse, name: &str) -> Trouble {
    Trouble::data(format!("there is no pulse in the {role}"))
        .detail(name)
        .detail(format!(
            "the largest excursion is {}, the noise {}: a pulse has to be {} times the noise",
            scientific(why.largest, 4),
            scientific(why.noise, 4),
            why.least_ratio
        ))
        .with_hint("check trigger and columns; the recording must begin with a quiet interval before the pulse")
}

/// By how much a pulse leaves its nominal one.
fn out_of_band(missed: &ToleranceResult) -> String {
    let band = format!(
        "off the nominal pulse by {:.1} % of its peak where {} % are allowed",
        100.0 * missed.largest_departure,
        plain(100.0 * missed.tolerance.band)
    );
    match missed.velocity_departure {
        Some(d) => format!(
            "{band}; velocity change {:+.1} % where ±{} % are",
            100.0 * d,
            plain(100.0 * missed.tolerance.velocity)
        ),
        None => band,
    }
}

/// Unit of the integral over time of what has this unit.
pub(crate) fn integral_unit(unit: &str) -> String {
    format!("{unit}·s").replace("m/s²·s", "m/s")
}

/// The standard as one number, refused in words.
fn flat(standard: &ReferenceTable, duration: f64) -> Result<FlatStandard> {
    FlatStandard::of(standard, duration).map_err(|e| match e {
        Error::OutOfRange { value: wanted, .. } => {
            let [first, last] = standard.range();
            Trouble::data(
                "the calibration of the reference begins above the band of the pulse",
            )
            .detail(format!(
                "it covers {first} Hz to {last} Hz; a pulse of {duration:.3e} s ends at {wanted:.0} Hz"
            ))
            .with_hint("have the reference calibrated at lower frequencies, or by shock")
        }
        e => e.into(),
    })
}

/// A band that the calibration does not cover.
fn uncovered(flat: &FlatStandard) -> Option<Finding> {
    let ([first, last], wanted) = (flat.range, flat.wanted);
    (!flat.covered).then(|| {
            proofmass_shaker::findings::reference_out_of_range(
                "all of the band of the pulse; beyond it is taken as within",
                &format!(
                    "it covers {first:.1} Hz to {last:.1} Hz, the pulse reaches from rest to {wanted:.0} Hz; sensitivity {:.1} % apart within",
                    200.0 * flat.spread
                ),
            )
            .at(Severity::Warning)
    })
}

/// The part of a record that shows its pulse, from and to in s.
fn window(pulse: &Pulse, rate: f64, samples: usize) -> (f64, f64) {
    let last = samples.saturating_sub(1) as f64 / rate;
    let start = pulse.start.map_or(0.0, |s| s / rate);
    let end = pulse.end.map_or(last, |e| e / rate);
    let duration = (end - start).max(1.0 / rate);
    (
        (start - duration).max(0.0),
        (end + 4.0 * duration).min(last).max(end),
    )
}

impl Job for ShockJob {
    type Data<'a> = ShockData<'a>;
    type Outcome = ShockOutcome;

    fn evaluate(&self, data: &ShockData<'_>, watch: &dyn Watch) -> Result<ShockOutcome> {
        watch.step("pulse", 0, 1)?;
        let Some(standard) = &self.standard else {
            return self.of_acceleration(data, watch);
        };
        let Some(reference) = data.reference else {
            return Err(Trouble::request(
                "the calibration of a reference was given, but no reference",
            )
            .with_hint("name its column"));
        };
        if reference.unit != "V" {
            return Err(Trouble::data(format!(
                "the reference {:?} is in {}: a calibrated reference gives volts",
                reference.name, reference.unit
            ))
            .detail(data.name)
            .with_hint("state its unit (--reference-unit V), or leave --standard out"));
        }
        let found = self.search.find(reference.data);
        let pulse = found
            .map_err(|e| Trouble::from(e).detail(data.name))?
            .map_err(|why| no_pulse("reference", why, data.name))?;
        let duration = pulse.duration_in(reference.data.len()) / data.rate;
        let scale = flat(standard, duration).map_err(|e| e.detail(data.name))?;
        let acceleration: Vec<f64> = reference
            .data
            .iter()
            .map(|v| v / scale.sensitivity)
            .collect();
        let mut findings = data.findings.to_vec();
        findings.extend(uncovered(&scale));
        let mut job = self.clone();
        let stated = self.reference.relative_uncertainty;
        job.reference.relative_uncertainty = stated.hypot(scale.relative_uncertainty);
        let data = ShockData {
            reference: Some(Channel {
                name: reference.name,
                unit: "m/s²",
                data: &acceleration,
            }),
            findings: &findings,
            ..data.clone()
        };
        job.of_acceleration(&data, watch)
    }
}

impl ShockJob {
    fn of_acceleration(&self, data: &ShockData<'_>, watch: &dyn Watch) -> Result<ShockOutcome> {
        self.check(data)?;
        let output = data.output;
        let mut findings = data.findings.to_vec();
        let (calibration, pulse, measures) = match data.reference {
            Some(reference) => {
                let calibration = ShockCalibration::evaluate(
                    reference.data,
                    output.data,
                    data.rate,
                    output.unit,
                    &self.search,
                    &self.reference,
                )
                .map_err(|e| match e {
                    NoCalibration::Reference(why) => no_pulse("reference", why, data.name),
                    NoCalibration::Output(why) => no_pulse("output", why, data.name),
                    NoCalibration::Data(e) => Trouble::from(e).detail(data.name),
                })?;
                findings.extend(calibration.findings.iter().cloned());
                let gain = calibration.output.peak / calibration.reference.peak;
                findings.extend(of_one_size(output.unit, gain));
                let pulse = calibration.reference_pulse.clone();
                let measures = calibration.reference.clone();
                (Some(calibration), pulse, measures)
            }
            None => {
                let found = self.search.find(output.data);
                let pulse = found
                    .map_err(|e| Trouble::from(e).detail(data.name))?
                    .map_err(|why| no_pulse("output", why, data.name))?;
                let measures = pulse.measure(output.data, data.rate);
                findings.extend(pulse_findings(
                    &pulse,
                    &measures,
                    output.data,
                    &PulseContext {
                        rate: data.rate,
                        unit: output.unit,
                        role: "output",
                    },
                ));
                (None, pulse, measures)
            }
        };
        watch.step("pulse", 1, 1)?;
        let of_output = calibration.as_ref().map_or(&pulse, |c| &c.output_pulse);
        let back = of_output.return_to_baseline(output.data, data.rate, self.return_band);
        if let Some(back) = back.filter(|b| b.time.is_none()) {
            findings.push(findings::not_back_at_baseline(
                output.name,
                back.band,
                output.unit,
                back.looked,
            ));
        }
        let judged = data.reference.unwrap_or(output);
        let tolerance = match &self.tolerance {
            Some(_) if judged.unit != "m/s²" => {
                findings.push(findings::tolerance_not_judged(
                    "pulse",
                    &format!("channel in {}, nominal peak in m/s²", judged.unit),
                    "the channel must be an acceleration: state what it gives to one with --sensitivity",
                ));
                None
            }
            Some(t) => {
                let result = t.judge(&pulse, judged.data, data.rate, measures.velocity_change);
                if result.is_none() {
                    findings.push(findings::tolerance_not_judged(
                        "pulse",
                        "",
                        "the pulse must be whole, the nominal peak and duration positive",
                    ));
                }
                if let Some(missed) = result.as_ref().filter(|r| !r.kept) {
                    findings.push(findings::tolerance_missed("pulse", &out_of_band(missed)));
                }
                result
            }
            None => None,
        };
        let mut spectra = Vec::new();
        let channels = data.reference.into_iter().chain([output]);
        for (role, channel) in channels.clone().enumerate() {
            let (sensitivity, unit, relative) =
                self.as_acceleration(&channel, calibration.as_ref(), role);
            let acceleration: Vec<f64> = channel
                .data
                .iter()
                .map(|v| (v - self.level(calibration.as_ref(), role, pulse.baseline)) / sensitivity)
                .collect();
            spectra.push(self.spectra(
                channel.name,
                unit,
                &acceleration,
                relative,
                &pulse,
                data.rate,
                &mut findings,
                watch,
            )?);
        }
        let spectrum_tolerance = match spectra.first() {
            Some(judged) => self.judge_spectrum(judged, data.rate, &mut findings, watch)?,
            None => None,
        };
        if let Some(missed) = spectrum_tolerance.as_ref().filter(|s| !s.result.kept) {
            let (within, of) = (missed.result.within, missed.result.compared);
            findings.push(findings::tolerance_missed(
                "shock spectrum",
                &format!("{within} of {of} frequencies within the band"),
            ));
        }
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        findings.dedup();
        let channels = channels
            .map(|c| {
                let time: Vec<f64> = (0..c.data.len()).map(|k| k as f64 / data.rate).collect();
                let (from, to) = window(&pulse, data.rate, c.data.len());
                let [from, to] = [(from * data.rate).floor(), (to * data.rate).ceil() + 1.0];
                let cut = (from as usize).min(c.data.len())..(to as usize).min(c.data.len());
                ShockChannel {
                    name: c.name.to_owned(),
                    unit: c.unit.to_owned(),
                    trace: Trace::new(&time, c.data, Trace::RUNS),
                    pulse: Trace::new(&time[cut.clone()], &c.data[cut], Trace::RUNS),
                }
            })
            .collect();
        Ok(ShockOutcome {
            request: self.clone(),
            rate: data.rate,
            channels,
            pulse,
            measures,
            calibration,
            back,
            tolerance,
            spectrum_tolerance,
            spectra,
            findings,
        })
    }

    fn check(&self, data: &ShockData<'_>) -> Result<()> {
        if !(self.quality > 0.5 && self.quality.is_finite()) {
            return Err(Trouble::request(format!(
                "a quality factor of {} is too small: Q is larger than 0.5",
                self.quality
            )));
        }
        if let Some(band) = self.return_band.filter(|b| !(*b > 0.0 && b.is_finite())) {
            return Err(Trouble::request(format!(
                "a band of ± {band} about the baseline is not above zero"
            ))
            .with_hint("give a number above zero, in m/s² or the unit of the output"));
        }
        if self.per_octave == 0 || self.per_octave > 192 {
            return Err(Trouble::request(format!(
                "{} natural frequencies to the octave: 1 to 192 are possible",
                self.per_octave
            )));
        }
        if let Some(reference) = data.reference
            && reference.unit != "m/s²"
        {
            let hint = if data.output.unit == "m/s²" {
                "the output is in m/s²: the two columns may be swapped"
            } else {
                "give its unit, such as --reference-unit m/s2, or the column of an acceleration"
            };
            return Err(Trouble::data(format!(
                "the reference {:?} is in {}, not in a unit of acceleration",
                reference.name, reference.unit
            ))
            .detail(data.name)
            .with_hint(hint));
        }
        Ok(())
    }

    /// The spectrum of the reference, or of the one channel, against what is required of it.
    fn judge_spectrum(
        &self,
        judged: &ShockSpectra,
        rate: f64,
        findings: &mut Vec<Finding>,
        watch: &dyn Watch,
    ) -> Result<Option<SpectrumVerdict>> {
        let frequency = &judged.frequency;
        let required: Vec<f64> = if self.required.is_empty() {
            let Some(t) = &self.tolerance else {
                return Ok(None);
            };
            if !(t.peak > 0.0 && t.duration > 0.0) {
                return Ok(None);
            }
            t.spectrum(frequency, self.quality, self.peaks, rate, watch)?
        } else {
            let at = |f: &f64| required_at(&self.required, *f).unwrap_or(0.0);
            frequency.iter().map(at).collect()
        };
        let measured: Vec<f64> = judged
            .absolute_acceleration
            .iter()
            .map(Extremes::maximax)
            .collect();
        let result =
            self.spectrum_tolerance
                .judge(&required, &measured, &judged.maximax_uncertainty);
        if judged.unit != "m/s²" || result.is_none() {
            findings.push(findings::tolerance_not_judged(
                "spectrum",
                &format!("spectrum in {}", judged.unit),
                "the channel must be an acceleration, and its natural frequencies (--frequencies) among those required",
            ));
            return Ok(None);
        }
        Ok(result.map(|result| SpectrumVerdict { required, result }))
    }

    fn as_acceleration(
        &self,
        channel: &Channel<'_>,
        calibration: Option<&ShockCalibration>,
        role: usize,
    ) -> (f64, String, f64) {
        let reference = calibration.is_some() && role == 0;
        let gain = calibration.filter(|_| !reference).and_then(|c| {
            let by = |name: &str| c.estimate.get(name);
            by("sensitivity.integral").or_else(|| by("sensitivity.peak"))
        });
        match gain {
            Some(q) if q.value != 0.0 && channel.unit != "m/s²" => (
                q.value,
                "m/s²".to_owned(),
                (q.standard_uncertainty / q.value).abs(),
            ),
            // An output that is already an acceleration beside a reference says nothing of its own scale.
            Some(_) => (1.0, channel.unit.to_owned(), 0.0),
            None => (
                1.0,
                channel.unit.to_owned(),
                self.reference.relative_uncertainty,
            ),
        }
    }

    fn level(&self, calibration: Option<&ShockCalibration>, role: usize, baseline: f64) -> f64 {
        match calibration {
            Some(c) if role == 1 => c.output_pulse.baseline,
            _ => baseline,
        }
    }

    #[allow(clippy::too_many_arguments)] // One call: everything it takes is one pulse.
    fn spectra(
        &self,
        name: &str,
        unit: String,
        acceleration: &[f64],
        relative: f64,
        pulse: &proofmass_dynamic::shock::Pulse,
        rate: f64,
        findings: &mut Vec<Finding>,
        watch: &dyn Watch,
    ) -> Result<ShockSpectra> {
        let request = SpectrumRequest {
            band: self.frequencies,
            per_octave: self.per_octave,
            quality: self.quality,
            peaks: self.peaks,
        };
        let [low, high] = request.band_of(pulse, acceleration.len(), rate);
        let frequencies = octaves(low, high, self.per_octave);
        if frequencies.is_empty() {
            return Err(Trouble::request(format!(
                "natural frequencies from {low} Hz to {high} Hz do not ascend from above zero"
            )));
        }
        if high > 0.1 * rate && self.peaks == Peaks::AtSamples {
            findings.push(findings::few_samples_per_oscillation(
                high,
                rate,
                (50.0 * (std::f64::consts::PI * high / rate).powi(2)).min(100.0),
            ));
        }
        let found = request.of(acceleration, frequencies, pulse, rate, relative, watch)?;
        Ok(ShockSpectra {
            name: name.to_owned(),
            unit,
            maximax_uncertainty: found.maximax_uncertainty,
            absolute_acceleration: found.absolute_acceleration,
            relative_displacement: found.relative_displacement,
            frequency: found.frequency,
        })
    }
}
