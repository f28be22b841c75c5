//! `proofmass test shock`.

use super::channel_arguments::{SensitivityArguments, StandardArguments};
use crate::clock::{self, record};
use crate::console::Progress;
use crate::delivery::Delivery;
use crate::number_arguments::{band, not_negative, positive};
use crate::{Failure, Outcome};
use proofmass::dynamic::shock::Tolerance;
use proofmass::io::{ColumnRef, Source, Unit};
use proofmass::jobs::shock::{ShockData, ShockJob, ShockOutcome, required_spectrum};
use proofmass::jobs::{ChannelReading, Job, Outcome as _, StoredResult, WantedChannel};
use proofmass::signal::{Peaks, PulseShape};
use std::path::{Path, PathBuf};

/// Peak, duration, velocity change and response spectrum (SRS) of a shock.
///
/// With --reference, the sensitivity of the output by peak, by integral and by spectrum (ISO 16063-13, -22), each with its
/// interval. Pulses that are cut off, doubled, saturated, shifted or ringing are reported. With -o, a folder gets result.json,
/// report.html and tables.
#[derive(clap::Args)]
pub(super) struct Shock {
    /// Recording with the shock
    recording: PathBuf,
    /// Column of the device, by name or number (from 1) [default: the only one that is left]
    #[arg(long, value_name = "COLUMN", aliases = ["output-column", "columns"])]
    column: Option<ColumnRef>,
    /// Unit of the column, where the heading does not say it: V, mV, count, m/s², g, …
    #[arg(long, value_name = "UNIT", alias = "output-unit")]
    unit: Option<Unit>,
    #[command(flatten)]
    by: SensitivityArguments,
    /// Column of the reference acceleration, or of its volts with --standard
    #[arg(long, value_name = "COLUMN", conflicts_with = "sensitivity")]
    reference: Option<ColumnRef>,
    /// Unit of the reference, where the heading does not say it: m/s², g, …
    #[arg(long, value_name = "UNIT", requires = "reference")]
    reference_unit: Option<Unit>,
    /// Relative standard uncertainty of the reference, or of the one channel where there is none, in per cent
    #[arg(long, value_name = "PERCENT", value_parser = not_negative, default_value = "0")]
    reference_uncertainty: f64,
    /// Natural frequencies of the spectrum in hertz: LOW,HIGH [default: by duration and rate]
    #[arg(long, value_name = "LOW,HIGH", value_parser = band)]
    frequencies: Option<[f64; 2]>,
    /// Natural frequencies to the octave
    #[arg(long, default_value_t = 12)]
    per_octave: u32,
    /// Quality factor of the oscillators, 1/(2ζ)
    #[arg(long, value_name = "Q", value_parser = positive, default_value = "10")]
    quality: f64,
    /// Extremes at the samples (ISO 18431-4) or also between them
    #[arg(long, value_enum, default_value = "at-samples")]
    peaks: PeakPlaces,
    /// Nominal pulse for the tolerance band
    #[arg(
        long,
        value_enum,
        requires = "nominal_peak",
        requires = "nominal_duration"
    )]
    nominal: Option<Shape>,
    /// Its peak in m/s²
    #[arg(long, value_name = "M_PER_S2", value_parser = positive, requires = "nominal")]
    nominal_peak: Option<f64>,
    /// Its duration in seconds
    #[arg(long, value_name = "SECONDS", value_parser = positive, requires = "nominal")]
    nominal_duration: Option<f64>,
    /// Half-width of the band in per cent of the nominal peak
    #[arg(long, value_name = "PERCENT", value_parser = positive, default_value = "20")]
    band: f64,
    /// Largest deviation of the velocity change in per cent
    #[arg(long, value_name = "PERCENT", value_parser = positive, default_value = "15")]
    velocity_band: f64,
    /// Shock response spectrum that is required, a table of frequency_Hz and acceleration_m/s2 (or _g) [default: that of the nominal
    /// pulse]
    #[arg(long, value_name = "FILE")]
    required_spectrum: Option<PathBuf>,
    /// Band about it in decibels, at nine tenths of the frequencies (MIL-STD-810, method 516)
    #[arg(long, value_name = "LOW,HIGH", value_parser = decibels, default_value = "-1.5,3", allow_hyphen_values = true)]
    spectrum_band: [f64; 2],
    /// Band for the others
    #[arg(long, value_name = "LOW,HIGH", value_parser = decibels, default_value = "-3,6", allow_hyphen_values = true)]
    spectrum_rest: [f64; 2],
    /// Half-width of the band about the baseline before the pulse into which the device returns, in m/s² or the unit of its output
    /// [default: what the noise before the pulse gives]
    #[arg(long, value_name = "VALUE", value_parser = positive)]
    return_band: Option<f64>,
    #[command(flatten)]
    standard: StandardArguments,
    #[command(flatten)]
    clock: ChannelReading,
    #[command(flatten)]
    delivery: Delivery,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum PeakPlaces {
    AtSamples,
    BetweenSamples,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Shape {
    HalfSine,
    Haversine,
    TerminalPeakSawtooth,
    /// Flanks of a tenth of the duration
    Trapezoid,
}

impl From<Shape> for PulseShape {
    fn from(shape: Shape) -> Self {
        match shape {
            Shape::HalfSine => Self::HalfSine,
            Shape::Haversine => Self::Haversine,
            Shape::TerminalPeakSawtooth => Self::TerminalPeakSawtooth,
            Shape::Trapezoid => Self::Trapezoid { rise: 0.1 },
        }
    }
}

impl Shock {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let mut named: Vec<&Path> = vec![&self.recording];
        named.extend(self.standard.standard.as_deref());
        named.extend(self.required_spectrum.as_deref());
        let folder = self.delivery.begin(ShockOutcome::KIND, &named)?;
        let certificate = self.standard.read()?;
        let mut source = Source::open(&self.recording)?;
        let mut roles = vec![("--column", self.column.as_ref())];
        roles.extend(self.reference.iter().map(|r| ("--reference", Some(r))));
        let columns = self.clock.columns(&mut source, &roles)?;
        let output = columns.into_iter().take(1);
        let output = output.map(|c| self.by.of(WantedChannel::new(c, self.unit, "--unit")));
        let mut channels: Vec<_> = output.collect();
        if let Some(reference) = &self.reference {
            channels.push(WantedChannel::new(
                reference.clone(),
                self.reference_unit,
                "--reference-unit",
            ));
        }
        let recording = self.clock.read(source, &channels)?;
        let views: Vec<_> = recording.channels.iter().map(|c| c.view()).collect();
        let Some((output, reference)) = views.split_first() else {
            return Err(Failure::new("no column was chosen").hint("add --column COLUMN"));
        };
        let mut findings = recording.findings.clone();
        findings.extend(certificate.iter().flat_map(|c| c.findings.clone()));
        let data = ShockData {
            reference: reference.first().copied(),
            output: *output,
            rate: recording.rate,
            findings: &findings,
            name: &recording.name,
        };
        let mut job = self.job();
        job.standard = certificate.as_ref().map(|c| c.table.clone());
        job.spectrum_tolerance.band = self.spectrum_band;
        job.spectrum_tolerance.rest = self.spectrum_rest;
        let mut inputs = vec![recording.input.clone()];
        inputs.extend(certificate.map(|c| c.input));
        if let Some(path) = &self.required_spectrum {
            let (required, input) = required_spectrum(Source::open(path)?)?;
            job.required = required;
            inputs.push(input);
        }
        let outcome = job.answer(&data, &inputs, &Progress::new())?;
        let record = record(
            format!("Shock test, {}", clock::named(&self.recording)),
            inputs,
        );
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }

    fn job(&self) -> ShockJob {
        let mut job = ShockJob::default();
        let by = self.by.relative_uncertainty();
        job.reference.relative_uncertainty = (1e-2 * self.reference_uncertainty).hypot(by);
        job.frequencies = self.frequencies;
        job.return_band = self.return_band;
        job.per_octave = self.per_octave;
        job.quality = self.quality;
        job.peaks = match self.peaks {
            PeakPlaces::AtSamples => Peaks::AtSamples,
            PeakPlaces::BetweenSamples => Peaks::BetweenSamples,
        };
        if let (Some(shape), Some(peak), Some(duration)) =
            (self.nominal, self.nominal_peak, self.nominal_duration)
        {
            let mut tolerance = Tolerance::default();
            tolerance.shape = shape.into();
            tolerance.peak = peak;
            tolerance.duration = duration;
            tolerance.band = 1e-2 * self.band;
            tolerance.velocity = 1e-2 * self.velocity_band;
            job.tolerance = Some(tolerance);
        }
        job
    }
}

/// Two numbers with their signs, the second larger: `-1.5,3`.
fn decibels(text: &str) -> Result<[f64; 2], String> {
    let refused = || format!("{text:?} is no band in decibels such as -1.5,3");
    let (low, high) = text.split_once(',').ok_or_else(refused)?;
    let number = |t: &str| t.trim().parse().ok().filter(|v: &f64| v.is_finite());
    match (number(low), number(high)) {
        (Some(low), Some(high)) if low < 0.0 && high > 0.0 => Ok([low, high]),
        _ => Err(refused()),
    }
}
