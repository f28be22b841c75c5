//! Do both sensors see the same motion? Gain, sense and latency of one against the other.

use crate::episode::held;
use crate::findings;
use crate::step_input::curve;
use crate::{KalmanModel, MotionRecord, ReadingSource};
use proofmass_core::{Error, STANDARD_GRAVITY};
use proofmass_signal::saturation::rails;
use proofmass_uncertainty::{Finding, Severity};
use serde::Serialize;
use std::f64::consts::TAU;

/// Regression of the motion in the readings on the motion in the accelerometer.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Pairing {
    /// Gain of the accelerometer: its velocity changes over those of the readings, one when units, axes and calibration agree.
    pub gain: f64,
    /// Its standard uncertainty.
    pub gain_uncertainty: f64,
    /// By how much the accelerometer is later than the readings, s; negative when it is earlier.
    pub latency: f64,
    /// Its standard uncertainty, s.
    pub latency_uncertainty: f64,
    /// Correlation of the velocity changes at that latency.
    pub correlation: f64,
    /// Length of the windows over which velocity changes were taken, s.
    pub window: f64,
    /// In words.
    pub findings: Vec<Finding>,
}

/// Factors between units that are mistaken for each other: one over the gain, and what it stands for.
const MISTAKEN: [(f64, &str); 8] = [
    (STANDARD_GRAVITY, "the acceleration is in g, not in m/s²"),
    (
        1.0 / STANDARD_GRAVITY,
        "the acceleration was converted from g twice",
    ),
    (
        STANDARD_GRAVITY / 1000.0,
        "the acceleration is in mg, not in m/s²",
    ),
    (
        1000.0,
        "one of the two is in millimetres (readings) or in km/s²",
    ),
    (
        1e-3,
        "the acceleration is in mm/s², or the readings are in kilometres",
    ),
    (TAU, "turns were taken for radians, or the reverse"),
    (
        180.0 / std::f64::consts::PI,
        "the readings are in degrees, not in radians",
    ),
    (3.6, "the readings are in km/h, not in m/s"),
];

/// Decodings that are mistaken for each other: the gain, and what it stands for.
const DECODINGS: [(f64, &str); 4] = [
    (
        4.0,
        ", as where the lines are counted once (×1) and the counts of fourfold decoding (×4) are stated",
    ),
    (
        2.0,
        ", as where half of the stated counts are counted: ×2 in place of ×4, or ×1 in place of ×2",
    ),
    (
        0.5,
        ", as where twice the stated counts are counted: ×4 in place of ×2, or ×2 in place of ×1",
    ),
    (
        0.25,
        ", as where the edges are counted fourfold (×4) and the lines (×1) are stated",
    ),
];

/// What a radius and the lever of an accelerometer are off by beside a wrong decoding.
const BESIDE_DECODING: f64 = 0.005;

/// The decoding that explains the gain of an accelerometer beside counts.
pub(crate) fn decoding(record: &MotionRecord, gain: f64, u: f64) -> Option<&'static str> {
    let counted = record.increment.is_some() || record.edges.is_some();
    let near = |f: f64| (gain.abs() - f).abs() < (2.0 * u).clamp(BESIDE_DECODING * f, 0.1 * f);
    let found = DECODINGS.iter().find(|(f, _)| near(*f));
    found
        .filter(|_| counted && record.source == ReadingSource::Position)
        .map(|(_, what)| *what)
}

/// The kind of finding of sensors of opposite sense.
pub(crate) const OPPOSITE: &str = "opposite-sense";

/// What a gain is of, in words.
pub(crate) const OVER: &str = "velocity changes of the accelerometer over those of the readings";

impl Pairing {
    /// Compares velocity changes over adjacent windows.
    ///
    /// From the readings and from the integrated acceleration alike, the slope (of a speed the mean) over the window
    /// after a time minus that over the window before it; both functionals are the same, so that gain and delay pass
    /// through. The delay of largest correlation is the latency; at it, a straight line with Huber's weights gives
    /// the gain, which a slipping wheel or a blow does not pull. The window is the one of largest correlation:
    /// long enough to see through quantisation, short enough to see the motion.
    ///
    /// **Assumes** a latency below one window. **Accuracy** noise of the accelerometer lowers the gain by up to
    /// 1 − ρ²; the findings allow for it. **Source** `[Huber64]` for the weights, `[Efron82]` for leaving out blocks.
    ///
    /// # Errors
    /// Of the record; [`Error::TooFew`] below 64 samples; [`Error::Constant`] when one of the sensors shows no
    /// motion at all.
    pub fn of(record: &MotionRecord) -> Result<Self, Error> {
        record.check()?;
        let n = record.reading.len();
        let stride = record.reading_stride();
        if n < 64 * stride {
            return Err(Error::TooFew {
                name: "samples",
                needed: 64 * stride,
                got: n,
            });
        }
        let dt = record.sample_time;
        let read = held(&record.reading);
        let felt = integrated(record);
        let mut best: Option<(f64, Self)> = None;
        let mut window = 4 * stride;
        while 8 * window <= n {
            if let Some(found) = paired(record.source, &read, &felt, window, dt) {
                // A longer window must be clearly better: it has fewer independent values.
                let score = found.correlation.abs();
                if best.as_ref().is_none_or(|(b, _)| score > b + 0.002) {
                    best = Some((score, found));
                }
            }
            window *= 2;
        }
        let (_, mut found) = best.ok_or(Error::Constant {
            name: "motion of both sensors",
            value: record
                .reading
                .iter()
                .flatten()
                .next()
                .copied()
                .unwrap_or(0.0),
        })?;
        // A motion of few increments is mostly their rounding.
        let known = || record.reading.iter().flatten();
        let low = known().copied().fold(f64::INFINITY, f64::min);
        let high = known().copied().fold(f64::NEG_INFINITY, f64::max);
        let coarse = record.source == ReadingSource::Position
            && record.increment.is_some_and(|d| high - low < 20.0 * d);
        if !coarse {
            found.findings = found.judged(stride as f64 * dt, record);
        }
        Ok(found)
    }

    /// Whether the correlation is worth a judgement on gain and latency.
    pub fn is_clear(&self) -> bool {
        self.correlation.abs() > 0.7
    }

    fn judged(&self, step: f64, record: &MotionRecord) -> Vec<Finding> {
        let mut findings = Vec::new();
        if !self.is_clear() {
            return findings;
        }
        let decoding = decoding(record, self.gain, self.gain_uncertainty);
        let gain_mismatch = || {
            let details = format!(
                "correlation {:.3} in windows of {:.3} s; {OVER}",
                self.correlation, self.window
            );
            let treatment = decoding.unwrap_or_default();
            findings::gain_mismatch(treatment, self.gain, self.gain_uncertainty, &details)
        };
        // Of the readings over the accelerometer.
        let size = 1.0 / self.gain.abs();
        let u = self.gain_uncertainty * size * size;
        let allowed = (4.0 * u + 1.0 - self.correlation * self.correlation).max(0.03);
        if self.gain < -4.0 * self.gain_uncertainty {
            findings.push(findings::opposite_sense(
                self.gain,
                self.gain_uncertainty,
                self.correlation,
                self.window,
            ));
        }
        let near = |f: f64| (size / f - 1.0).abs() < allowed.max(0.08);
        if (size - 1.0).abs() > allowed {
            // One that is cut off shows less of the motion, as much less as it likes.
            let mistaken = MISTAKEN
                .iter()
                .find(|(f, _)| decoding.is_none() && near(*f))
                .filter(|_| rails(&record.acceleration).is_empty());
            findings.push(match mistaken {
                Some((_, what)) => proofmass_uncertainty::findings::unit_suspected(
                    what,
                    &format!(
                        "{OVER}: {:.4} (u = {:.4}), correlation {:.3}, windows of {:.3} s",
                        self.gain, self.gain_uncertainty, self.correlation, self.window
                    ),
                ),
                None if (size - 1.0).abs() > 0.3 => gain_mismatch().at(Severity::Decision),
                None => gain_mismatch(),
            });
        }
        if self.latency.abs() > (4.0 * self.latency_uncertainty).max(0.6 * step) {
            let late = if self.latency > 0.0 {
                "later"
            } else {
                "earlier"
            };
            findings.push(findings::latency(
                late,
                "",
                1e3 * self.latency,
                1e3 * self.latency_uncertainty,
                &format!(", correlation {:.3}", self.correlation),
            ));
        }
        findings
    }
}

/// The motion as the accelerometer has it: its second integral beside positions, its first beside speeds.
fn integrated(record: &MotionRecord) -> Vec<f64> {
    let dt = record.sample_time;
    // Without its mean the integral stays small: an offset cancels from velocity changes anyway, up to a constant.
    let mean = record.acceleration.iter().sum::<f64>() / record.acceleration.len() as f64;
    let curve = curve(record, &KalmanModel::new(0.0, 1.0));
    let (mut x, mut v) = (0.0, 0.0);
    let mut before = record.acceleration[0];
    let motion = record.acceleration.iter().enumerate().map(|(k, &a)| {
        let [dx, dv] = match &curve {
            Some(curve) => curve.steps[k],
            None => [dt * dt * (before / 3.0 + a / 6.0), 0.5 * dt * (before + a)],
        };
        if k > 0 {
            x += dt * v + dx - 0.5 * mean * dt * dt;
            v += dv - mean * dt;
        }
        before = a;
        match record.source {
            ReadingSource::Position => x,
            ReadingSource::Speed => v,
        }
    });
    motion.collect()
}

/// Velocity change between the windows that meet at a sample: difference of the slopes, or of the means.
fn change(source: ReadingSource, x: &[f64], at: usize, w: usize) -> f64 {
    let origin = x[at];
    let middle = 0.5 * (w - 1) as f64;
    let side = |part: &[f64]| -> f64 {
        let sum = part.iter().enumerate().map(|(k, v)| match source {
            ReadingSource::Position => (k as f64 - middle) * (v - origin),
            ReadingSource::Speed => v - origin,
        });
        sum.sum()
    };
    let scale = match source {
        ReadingSource::Position => (w as f64) * ((w * w) as f64 - 1.0) / 12.0,
        ReadingSource::Speed => w as f64,
    };
    (side(&x[at..at + w]) - side(&x[at - w..at])) / scale
}

/// Lags either way, in steps of an eighth of a window.
const LAGS: usize = 8;

fn paired(source: ReadingSource, read: &[f64], felt: &[f64], w: usize, dt: f64) -> Option<Pairing> {
    let n = read.len();
    let step = (w / LAGS).max(1);
    let places: Vec<usize> = (w..=n - w).step_by(step).collect();
    let e: Vec<f64> = places.iter().map(|&k| change(source, read, k, w)).collect();
    let d: Vec<f64> = places.iter().map(|&k| change(source, felt, k, w)).collect();
    let m = e.len();
    if m < 6 * LAGS {
        return None;
    }
    // The same values of `e` for every lag, so that the ends do not pull the maximum.
    let inner = LAGS..m - LAGS;
    let lagged = |lag: i64| -> Vec<f64> {
        inner
            .clone()
            .map(|k| d[(k as i64 + lag) as usize])
            .collect()
    };
    let centre = e[inner.clone()].to_vec();
    let rho = |lag: i64| correlation(&centre, &lagged(lag));
    let lags: Vec<f64> = (-(LAGS as i64)..=LAGS as i64)
        .map(rho)
        .collect::<Option<_>>()?;
    let lag_of = |i: usize| i as i64 - LAGS as i64;
    // Of peaks that are nearly as high the one nearest to no latency: a periodic motion has many.
    let highest = lags.iter().fold(0.0f64, |m, r| m.max(r.abs()));
    let at = (0..lags.len())
        .filter(|&i| lags[i].abs() > 0.97 * highest)
        .filter(|&i| {
            let side = |j: Option<usize>| {
                j.and_then(|j| lags.get(j))
                    .is_none_or(|r| r.abs() <= lags[i].abs())
            };
            side(i.checked_sub(1)) && side(Some(i + 1))
        })
        .min_by_key(|&i| lag_of(i).abs())?;
    let (mut fine, mut curvature) = (0.0, 0.0);
    if at > 0 && at + 1 < lags.len() {
        let (a, b, c) = (lags[at - 1], lags[at], lags[at + 1]);
        curvature = (a - 2.0 * b + c) / b;
        if curvature < 0.0 {
            fine = (0.5 * (a - c) / (b * curvature)).clamp(-1.0, 1.0);
        }
    }
    let values = shifted(&d, &inner, lag_of(at) as f64 + fine);
    let rho = correlation(&centre, &values)?;
    // Windows overlap: every second one is new.
    let independent = ((m * step) as f64 / (2.0 * w as f64)).max(1.0);
    // The noise is that of the accelerometer's integral: the readings are fitted by it, and its gain is one over the slope.
    let (gain, gain_uncertainty) = huber(&centre, &values, independent)
        .map(|(slope, u)| (1.0 / slope, u / (slope * slope)))
        .filter(|(gain, u)| gain.is_finite() && u.is_finite())?;
    let noise = (1.0 - rho * rho).max(1e-12);
    let per_step = if curvature < 0.0 {
        (noise / (independent * rho * rho * -curvature)).sqrt()
    } else {
        LAGS as f64
    };
    Some(Pairing {
        gain,
        gain_uncertainty,
        latency: (lag_of(at) as f64 + fine) * step as f64 * dt,
        latency_uncertainty: per_step * step as f64 * dt,
        correlation: rho,
        window: w as f64 * dt,
        findings: Vec::new(),
    })
}

/// Values at places moved by a lag that is not whole, on straight lines.
fn shifted(d: &[f64], inner: &std::ops::Range<usize>, lag: f64) -> Vec<f64> {
    let (whole, part) = (lag.floor(), lag - lag.floor());
    let last = d.len() as i64 - 1;
    inner
        .clone()
        .map(|k| {
            let j = (k as i64 + whole as i64).clamp(0, last);
            let (a, b) = (d[j as usize], d[(j + 1).min(last) as usize]);
            a * (1.0 - part) + b * part
        })
        .collect()
}

fn correlation(x: &[f64], y: &[f64]) -> Option<f64> {
    let n = x.len() as f64;
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
    for (x, y) in x.iter().zip(y) {
        xx += (x - mx) * (x - mx);
        yy += (y - my) * (y - my);
        xy += (x - mx) * (y - my);
    }
    let scale = (xx * yy).sqrt();
    (scale > 0.0 && scale.is_finite()).then(|| xy / scale)
}

/// Slope of y = g x + c with Huber's weights, and its standard uncertainty.
///
/// That is the larger of two: from the residuals as if `independent` of them were new, and from leaving out blocks, which tells when a single blow carries the whole slope.
fn huber(y: &[f64], x: &[f64], independent: f64) -> Option<(f64, f64)> {
    let n = y.len();
    let mut weight = vec![1.0; n];
    let level = y.iter().sum::<f64>() / n as f64;
    let y_size = (y.iter().map(|y| (y - level) * (y - level)).sum::<f64>() / n as f64).sqrt();
    let mut gain = 0.0;
    let (mut xx, mut xy, mut rms) = (vec![0.0; n], vec![0.0; n], 0.0);
    for _ in 0..20 {
        let total: f64 = weight.iter().sum();
        let mean = |v: &[f64]| v.iter().zip(&weight).map(|(v, w)| v * w).sum::<f64>() / total;
        let (mx, my) = (mean(x), mean(y));
        for k in 0..n {
            xx[k] = weight[k] * (x[k] - mx) * (x[k] - mx);
            xy[k] = weight[k] * (x[k] - mx) * (y[k] - my);
        }
        let bottom: f64 = xx.iter().sum();
        if !(bottom > 0.0) {
            return None;
        }
        let last = gain;
        gain = xy.iter().sum::<f64>() / bottom;
        let residual: Vec<f64> = x
            .iter()
            .zip(y)
            .map(|(x, y)| y - my - gain * (x - mx))
            .collect();
        let mut size: Vec<f64> = residual.iter().map(|r| r.abs()).collect();
        size.sort_by(f64::total_cmp);
        // Median of |normal| is 0.6745 σ. A motion that is short against its rest leaves a median of the rest's
        // noise; a twentieth of the motion's own size is no outlier.
        let sigma = (size[n / 2] / 0.6745)
            .max(0.05 * y_size)
            .max(f64::MIN_POSITIVE);
        let square: f64 = residual.iter().zip(&weight).map(|(r, w)| w * r * r).sum();
        rms = (square / bottom).sqrt();
        for (w, r) in weight.iter_mut().zip(&residual) {
            *w = (1.345 * sigma / r.abs().max(f64::MIN_POSITIVE)).min(1.0);
        }
        if (gain - last).abs() < 1e-6 * gain.abs() {
            break;
        }
    }
    let blocks = (independent / 2.0).clamp(8.0, 40.0) as usize;
    // Two neighbours at a time: a blow may lie on a boundary. Each time with its own means.
    let sums = |part: std::ops::Range<usize>| -> [f64; 5] {
        part.fold([0.0; 5], |s, k| {
            let (w, x, y) = (weight[k], x[k], y[k]);
            [
                s[0] + w,
                s[1] + w * x,
                s[2] + w * y,
                s[3] + w * x * x,
                s[4] + w * x * y,
            ]
        })
    };
    let all = sums(0..n);
    let without: Vec<f64> = (0..blocks - 1)
        .map(|b| {
            let part = sums(b * n / blocks..(b + 2) * n / blocks);
            let [w, x, y, xx, xy]: [f64; 5] = std::array::from_fn(|i| all[i] - part[i]);
            (xy - x * y / w) / (xx - x * x / w).max(f64::MIN_POSITIVE)
        })
        .collect();
    let pairs = without.len() as f64;
    let centre = without.iter().sum::<f64>() / pairs;
    let spread: f64 = without.iter().map(|g| (g - centre) * (g - centre)).sum();
    let jackknife = (spread * (blocks - 2) as f64 / (2.0 * pairs)).sqrt();
    Some((gain, jackknife.max(rms / independent.sqrt())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_rig::{AxisMotion, DrivenAxis};

    fn record(axis: &DrivenAxis, seed: u64, factor: f64) -> MotionRecord {
        let r = axis.simulate(seed).unwrap();
        let acceleration = r.acceleration.iter().map(|a| factor * a).collect();
        let mut record = MotionRecord::new(
            r.sample_time,
            ReadingSource::Position,
            r.position(),
            acceleration,
        )
        .unwrap();
        record.increment = Some(r.increment);
        record
    }

    fn codes(pairing: &Pairing) -> Vec<&str> {
        pairing.findings.iter().map(Finding::code).collect()
    }

    #[test]
    fn law_matched_sensors_have_gain_one_and_no_latency() {
        for (seed, motion) in [
            AxisMotion::damped_oscillation(),
            AxisMotion::servo(5.0),
            AxisMotion::servo(15.0),
            AxisMotion::impact(),
        ]
        .into_iter()
        .enumerate()
        {
            let p = Pairing::of(&record(&DrivenAxis::new(motion), seed as u64 + 20, 1.0)).unwrap();
            println!("{motion:?}: {p:?}");
            assert!(p.findings.is_empty(), "{motion:?} {p:?}");
        }
    }

    #[test]
    fn law_a_wrong_unit_is_named() {
        let axis = DrivenAxis::new(AxisMotion::servo(5.0));
        for (factor, word) in [(1.0 / STANDARD_GRAVITY, "in g"), (1000.0, "mm/s²")] {
            let p = Pairing::of(&record(&axis, 21, factor)).unwrap();
            assert_eq!(codes(&p), ["unit-suspected"], "{p:?}");
            assert!(p.findings[0].what().contains(word), "{p:?}");
        }
        let p = Pairing::of(&record(&axis, 21, -1.0)).unwrap();
        assert_eq!(codes(&p), ["opposite-sense"], "{p:?}");
        let p = Pairing::of(&record(&axis, 21, 1.0 / 1.1)).unwrap();
        assert_eq!(codes(&p), ["gain-mismatch"]);
        assert!((p.gain * 1.1 - 1.0).abs() < 0.01, "{p:?}");
    }

    #[test]
    fn law_latency_is_measured_either_way() {
        for latency in [-0.004, 0.003, 0.010] {
            let mut axis = DrivenAxis::new(AxisMotion::servo(5.0));
            axis.accelerometer.latency = latency;
            let p = Pairing::of(&record(&axis, 22, 1.0)).unwrap();
            assert_eq!(codes(&p), ["latency"], "{p:?}");
            assert!((p.latency - latency).abs() < 0.5e-3, "{latency}: {p:?}");
        }
    }

    #[test]
    fn law_a_standstill_judges_nothing() {
        let p = Pairing::of(&record(&DrivenAxis::new(AxisMotion::Standstill), 23, 1.0));
        assert!(p.is_err() || p.is_ok_and(|p| p.findings.is_empty()));
    }
}
