//! Sinusoids in a record: found in the multitaper spectrum, taken out of the samples.

use crate::NoiseModel;
use crate::spectrum_bins::SpectrumBins;
use crate::unit_comparison::minimum;
use proofmass_signal::Detrend;
use std::f64::consts::PI;

/// One sinusoid A sin(2πft + φ), t from the start of the longest stretch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    pub(crate) amplitude: f64,
    pub(crate) frequency: f64,
    pub(crate) phase: f64,
}

/// The sinusoids of a record.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lines {
    pub(crate) found: Vec<Found>,
    sample_rate: f64,
    /// Half width of what a line spoils, Hz.
    width: f64,
}

impl Lines {
    /// Frequencies near the lines, where something of them may be left.
    pub(crate) fn neighbourhoods(&self) -> Vec<(f64, f64)> {
        self.found
            .iter()
            .map(|l| (l.frequency - self.width, l.frequency + self.width))
            .collect()
    }

    /// A stretch without the lines, each at the amplitude and phase that fit this stretch best.
    pub(crate) fn remove(&self, rate: &[f64]) -> Vec<f64> {
        let mut left = rate.to_vec();
        for line in &self.found {
            let cycles = line.frequency * rate.len() as f64 / self.sample_rate;
            if cycles < 3.0 {
                continue;
            }
            let (c, s) = phasor(&left, cycles);
            let step = 2.0 * PI * cycles / rate.len() as f64;
            for (i, y) in left.iter_mut().enumerate() {
                let (sin, cos) = (step * i as f64).sin_cos();
                *y -= c * cos + s * sin;
            }
        }
        left
    }
}

/// Lines of the longest stretch that stand out of a model, those above a frequency in Hz.
pub(crate) fn find(
    stretches: &[&[f64]],
    sample_rate: f64,
    model: &NoiseModel,
    false_alarm_rate: f64,
    above: f64,
) -> Lines {
    let Some(longest) = stretches.iter().max_by_key(|s| s.len()) else {
        return Lines::default();
    };
    let mut detrended = longest.to_vec();
    if Detrend::Linear.remove(&mut detrended, sample_rate).is_err() {
        return Lines::default();
    }
    let bins = SpectrumBins::new(detrended.clone(), sample_rate);
    let found = bins
        .lines(model, false_alarm_rate)
        .into_iter()
        .filter(|index| bins.frequency(*index as f64) > above)
        .map(|index| line_at(&detrended, sample_rate, index))
        .collect();
    Lines {
        found,
        sample_rate,
        width: 4.0 * sample_rate / longest.len() as f64,
    }
}

/// Cosine and sine amplitude at so many cycles in the record.
fn phasor(rate: &[f64], cycles: f64) -> (f64, f64) {
    let n = rate.len() as f64;
    let mean = rate.iter().sum::<f64>() / n;
    let step = 2.0 * PI * cycles / n;
    let (mut c, mut s) = (0.0, 0.0);
    for (k, y) in rate.iter().enumerate() {
        let (sin, cos) = (step * k as f64).sin_cos();
        c += (y - mean) * cos;
        s += (y - mean) * sin;
    }
    (2.0 * c / n, 2.0 * s / n)
}

/// Amplitude, frequency and phase of the line near a Fourier index, by maximising the periodogram.
fn line_at(rate: &[f64], sample_rate: f64, index: usize) -> Found {
    let power = |cycles: f64| {
        let (c, s) = phasor(rate, cycles);
        c * c + s * s
    };
    // Coarse search over the tapers' bandwidth, then golden sections within one coarse step.
    let centre = index as f64;
    let coarse = (-8..=8)
        .map(|k| centre + 0.25 * f64::from(k))
        .max_by(|a, b| power(*a).total_cmp(&power(*b)))
        .unwrap_or(centre);
    let cycles = minimum(&|x| -power(x), coarse - 0.25, coarse + 0.25, 16);
    let (c, s) = phasor(rate, cycles);
    Found {
        amplitude: c.hypot(s),
        frequency: cycles * sample_rate / rate.len() as f64,
        phase: c.atan2(s),
    }
}
