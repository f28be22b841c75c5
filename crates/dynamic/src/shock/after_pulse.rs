//! When a device is back at its baseline after a pulse.

use super::pulse::Pulse;
use super::quiet::Quiet;
use proofmass_uncertainty::normal_quantile;
use serde::Serialize;

/// Probability that a record at its baseline leaves the band that its noise gives.
const FALSE_ALARM: f64 = 0.01;

/// By how many standard deviations of the noise the band is wider and narrower for the ends of the interval. The last sample outside is
/// the one that the noise lifts most, so that the way to the early end is the longer.
const WIDER: f64 = 4.0;
const NARROWER: f64 = 2.0;

/// How long a device takes to come back to the baseline before a pulse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ReturnToBaseline {
    /// Half-width of the band about the baseline, unit of the record.
    pub band: f64,
    /// Whether it was stated; else it is what the noise before the pulse gives.
    pub stated: bool,
    /// From the end of the pulse (its passage through a tenth of the peak) to the last sample outside of the band, s; `None` where
    /// the record ends, or another pulse comes, before.
    #[serde(rename = "time_s")]
    pub time: Option<f64>,
    /// The same for a band that is wider by four standard deviations of the noise, and one that is narrower by two, s: what it would be
    /// without noise lies between.
    #[serde(rename = "interval_s")]
    pub interval: Option<[f64; 2]>,
    /// How long was looked, s after the end of the pulse.
    #[serde(rename = "looked_s")]
    pub looked: f64,
}

impl Pulse {
    /// Time to return into a band about the baseline and to stay there; the band in the unit of the record.
    ///
    /// Without a stated band it is z σ, with the standard deviation σ of the quiet samples before the pulse and z such that one record
    /// in a hundred at its baseline leaves it, all samples after the pulse together: (1 − 2Φ(−z))ⁿ = 0.99 `[Sidak1967]`.
    ///
    /// **Assumes** noise after the pulse as before it, independent or nearly. `None` without an end of the pulse, without a quiet
    /// stretch of 16 samples before it, or without 16 samples after it.
    pub fn return_to_baseline(
        &self,
        record: &[f64],
        rate: f64,
        band: Option<f64>,
    ) -> Option<ReturnToBaseline> {
        let (start, end) = (self.start?, self.end?);
        let duration = end - start;
        if self.quiet < Quiet::SHORTEST {
            return None;
        }
        let others = self.others.iter().filter(|k| **k > self.top).min();
        let stop = others.map_or(record.len(), |k| {
            ((*k as f64 - 2.0 * duration).max(0.0) as usize).min(record.len())
        });
        let from = end as usize + 1;
        if stop < from + Quiet::SHORTEST {
            return None;
        }
        let samples = (stop - from) as f64;
        // ln(1 − p)/n, so that long records keep their digits.
        let each = -((-FALSE_ALARM).ln_1p() / samples).exp_m1();
        let chance = normal_quantile(1.0 - 0.5 * each) * self.noise;
        let own = band.unwrap_or(chance);
        let last_outside = |width: f64| -> Option<f64> {
            let outside = |k: &usize| (record[*k] - self.baseline).abs() > width;
            match (from..stop).rev().find(outside) {
                // Nothing is known of what comes after the last samples.
                Some(k) if k + Quiet::SHORTEST >= stop => None,
                Some(k) => Some((k as f64 + 1.0 - end) / rate),
                None => Some(0.0),
            }
        };
        let time = last_outside(own);
        // A band narrower than the noise is left by chance.
        let narrow = (own - NARROWER * self.noise).max(chance.min(own));
        let interval = last_outside(own + WIDER * self.noise).zip(last_outside(narrow));
        Some(ReturnToBaseline {
            band: own,
            stated: band.is_some(),
            time,
            interval: time.and(interval).map(|(early, late)| [early, late]),
            looked: samples / rate,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shock::PulseSearch;
    use proofmass_signal::PulseShape;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    const RATE: f64 = 50e3;

    /// A half-sine of 1000 over 1 ms, a tail A e^{−t/τ} from its end on, white noise of deviation 1.
    fn shock(tail: f64, tau: f64, seed: u64) -> Vec<f64> {
        let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(seed);
        let pulse = PulseShape::HalfSine.record(1000.0, 1e-3, 0.02, 20_000, RATE);
        pulse
            .iter()
            .enumerate()
            .map(|(k, v)| {
                let t = k as f64 / RATE - 0.021;
                let left = if t > 0.0 {
                    tail * (-t / tau).exp()
                } else {
                    0.0
                };
                let w: f64 = StandardNormal.sample(&mut rng);
                v + left + w
            })
            .collect()
    }

    fn returned(record: &[f64], band: Option<f64>) -> ReturnToBaseline {
        let pulse = PulseSearch::default().find(record).unwrap().unwrap();
        pulse.return_to_baseline(record, RATE, band).unwrap()
    }

    /// 50 e^{−t/τ} is back within ± 10 after τ ln 5 = 16.09 ms, counted from the passage through a tenth: 0.968 ms of the pulse.
    #[test]
    fn known_time_of_an_exponential_tail() {
        let mut held = 0;
        for seed in 0..40 {
            let r = returned(&shock(50.0, 0.01, seed), Some(10.0));
            let truth =
                0.01 * 5f64.ln() + 1e-3 * (1.0 - 0.5 - (0.1f64.acos()) / std::f64::consts::PI);
            let [early, late] = r.interval.unwrap();
            let time = r.time.unwrap();
            assert!(early <= time && time <= late, "{r:?}");
            // Noise of 1 on a slope of 10/τ is 1 ms, and the last sample outside is lifted by two to four of it.
            assert!((time - truth).abs() < 7e-3, "{time} {truth}");
            held += usize::from(early <= truth && truth <= late);
        }
        assert!(held >= 36, "{held}");
    }

    /// A healthy record is back at once, but for one in a hundred.
    #[test]
    fn known_false_alarms_of_the_band_of_the_noise() {
        let late = (0..200).filter(|seed| {
            let r = returned(&shock(0.0, 1.0, 1000 + seed), None);
            // The flank below a tenth takes 32 µs.
            r.time.is_none_or(|t| t > 1e-4)
        });
        let late = late.count();
        assert!(late <= 8, "{late}");
    }

    #[test]
    fn known_shift_beyond_the_band_never_returns() {
        let mut record = shock(0.0, 1.0, 7);
        record[1060..].iter_mut().for_each(|v| *v += 30.0);
        let r = returned(&record, None);
        assert_eq!((r.time, r.interval), (None, None));
        assert!(returned(&record, Some(40.0)).time.is_some());
    }
}
