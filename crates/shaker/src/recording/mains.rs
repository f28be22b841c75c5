//! Lines of the mains far from the drive: not fitted with it, but what they say is needed where another drive hides them.

use super::RecordedTone;
use crate::hum::{HEARD, MAINS, WANDERS};
use crate::observation::ascending;
use proofmass_signal::{Window, fourier::forward_owned};

/// Bins on either side of the drive and of its harmonics within which tones are fitted, or hidden.
const FAR: f64 = 12.0;
/// Half width of the main lobe of the window, bins.
const LOBE: f64 = 4.0;
/// Bins of noise on either side, from the end of the lobe on.
const NOISE: usize = 16;
/// Power over that of the noise from which on a line is heard: noise reaches it in less than one of a million lines.
const STANDS_OUT: f64 = 30.0;
/// Samples below which nothing can be said.
const FEW: usize = 1024;

/// Every line of the mains that is far from the drive and its harmonics, with its amplitude in each channel: zero where it
/// does not stand out from the noise.
///
/// The window is the four-term one of Blackman and Harris, whose side lobes of −92 dB leave nothing of the drive there.
///
/// **Source** `[Harris1978]` for the window.
pub(super) fn listen(
    sampling_frequency: f64,
    channels: &[&[f64]],
    drive: f64,
) -> Vec<RecordedTone> {
    let n = channels.first().map_or(0, |c| c.len());
    if n < FEW {
        return vec![];
    }
    let resolution = sampling_frequency / n as f64;
    let hidden = |f: f64| {
        let harmonic = (f / drive).round() * drive;
        (f - harmonic).abs() < FAR * resolution + WANDERS * f
    };
    let lines = ascending(
        MAINS
            .iter()
            .flat_map(|mains| (1..=HEARD).map(move |k| k as f64 * mains))
            .filter(|f| *f < 0.45 * sampling_frequency && !hidden(*f)),
    );
    if lines.is_empty() {
        return vec![];
    }
    let window = Window::BlackmanHarris.weights(n);
    let spectra: Vec<Vec<f64>> = channels
        .iter()
        .map(|x| {
            let mean = x.iter().sum::<f64>() / n as f64;
            let weighted = x.iter().zip(&window).map(|(v, w)| (v - mean) * w);
            let spectrum = forward_owned(weighted.collect());
            spectrum.iter().map(|z| z.norm_sqr()).collect()
        })
        .collect();
    let sum: f64 = window.iter().sum();
    lines
        .into_iter()
        .map(|frequency| {
            let amplitudes = spectra.iter().map(|power| {
                let peak = stands_out(power, frequency / resolution, WANDERS);
                peak.map_or(0.0, |p| 2.0 * p.sqrt() / sum)
            });
            RecordedTone {
                frequency,
                amplitudes: amplitudes.collect(),
            }
        })
        .collect()
}

/// The largest power near a place in bins, where it stands out from the noise on both sides.
fn stands_out(power: &[f64], place: f64, wanders: f64) -> Option<f64> {
    let reach = 1.5 + wanders * place;
    let (low, high) = ((place - reach).floor(), (place + reach).ceil());
    let end = power.len() as f64 - LOBE - NOISE as f64 - 1.0;
    if low < LOBE + NOISE as f64 + 1.0 || high > end {
        return None;
    }
    let (low, high) = (low as usize, high as usize);
    let best = (low..=high).max_by(|&a, &b| power[a].total_cmp(&power[b]))?;
    let gap = LOBE as usize;
    let left = &power[best - gap - NOISE..best - gap];
    let right = &power[best + gap + 1..=best + gap + NOISE];
    // The quieter side: on the other one may stand another line.
    let mean = |side: &[f64]| side.iter().sum::<f64>() / NOISE as f64;
    let noise = mean(left).min(mean(right));
    (power[best] > STANDS_OUT * noise && noise > 0.0).then_some(power[best])
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;
    use std::f64::consts::TAU;

    fn record(rng: &mut Xoshiro256PlusPlus, drive: f64, hum: &[(f64, f64)]) -> Vec<f64> {
        (0..10_240)
            .map(|i| {
                let t = f64::from(i) / 10_240.0;
                let noise: f64 = StandardNormal.sample(rng);
                let lines = hum.iter().map(|(f, a)| a * (TAU * f * t + 0.4).cos());
                0.1 * (TAU * drive * t).cos()
                    + 1e-4 * (2.0 * TAU * drive * t).cos()
                    + lines.sum::<f64>()
                    + 1e-4 * noise
            })
            .collect()
    }

    #[test]
    fn known_hum_far_from_the_drive_is_heard() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let x = record(&mut rng, 163.7, &[(60.02, 4e-5), (180.06, 2e-5)]);
        let heard = listen(10_240.0, &[&x], 163.7);
        let at = |f: f64| {
            let line = heard.iter().find(|t| t.frequency == f);
            line.map(|t| t.amplitudes[0])
        };
        assert!(
            (at(60.0).unwrap() / 4e-5 - 1.0).abs() < 0.2,
            "{:?}",
            at(60.0)
        );
        assert!(
            (at(180.0).unwrap() / 2e-5 - 1.0).abs() < 0.3,
            "{:?}",
            at(180.0)
        );
        assert_eq!(at(120.0), Some(0.0));
        // Beside the drive tones are fitted; on its harmonics nothing can be heard.
        let on = listen(10_240.0, &[&x], 59.9);
        assert!(
            on.iter()
                .all(|t| t.frequency != 60.0 && t.frequency != 120.0)
        );
    }

    #[test]
    fn law_healthy_records_have_no_hum() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
        let (mut lines, mut told) = (0, 0);
        for k in 0..150 {
            let drive = 20.0 + 3.7 * f64::from(k);
            let x = record(&mut rng, drive, &[]);
            for tone in listen(10_240.0, &[&x], drive) {
                lines += 1;
                told += usize::from(tone.amplitudes[0] > 0.0);
            }
        }
        assert!(lines > 3000, "{lines}");
        assert_eq!(told, 0, "of {lines}");
    }
}
