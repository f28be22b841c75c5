//! Errors of the encoder that repeat with the position: eccentricity once per turn, gears, lines.

use crate::episode::held;
use crate::findings;
use crate::{HighPass, MotionRecord, ReadingSource, speed_increment};
use proofmass_core::Error;
use proofmass_core::numeric::upper_median;
use proofmass_uncertainty::Finding;
use std::f64::consts::{PI, TAU};

/// One repeating error.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RippleLine {
    /// Length (or angle) after which it repeats.
    pub period: f64,
    /// Amplitude of the position error.
    pub amplitude: f64,
    /// Standard uncertainty of the amplitude, from the level of the spectrum around it.
    pub amplitude_uncertainty: f64,
    /// Amplitude of the velocity error per unit velocity: 2π amplitude/period.
    pub relative_velocity: f64,
}

/// Points of the spectrum to either side of a line that tell its level: some twelve lines, of which the line itself takes two.
const AROUND: usize = 48;
/// Standard uncertainties above which the error of a turn is told: one in ten thousand by chance.
const CERTAIN: f64 = 4.3;

/// Repeating errors, largest first.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Ripple {
    /// Lines above five times the median of the spectrum around them.
    pub lines: Vec<RippleLine>,
    /// The line at the given circumference, when one was given and the record covers it.
    pub once_per_turn: Option<RippleLine>,
    /// Distance covered by the samples that were used.
    pub distance: f64,
    /// In words.
    pub findings: Vec<Finding>,
}

/// Spectrum over position of reading minus doubly integrated acceleration.
///
/// `use_sample` leaves samples out (slip); samples slower than a fifth of the fastest are left out too. What is
/// slower than a period of 1/16 of the distance is removed by a zero-phase high-pass.
///
/// # Errors
/// Of the record; [`Error::TooFew`] when fewer than 200 samples remain or the axis does not move.
pub fn ripple(
    record: &MotionRecord,
    circumference: Option<f64>,
    use_sample: impl Fn(usize) -> bool,
) -> Result<Ripple, Error> {
    record.check()?;
    let dt = record.sample_time;
    let x = held(&record.positions());
    let n = x.len();
    // Longest run of usable samples: a spectrum over a gap would show the gap.
    let step = ((0.05 / dt) as usize).clamp(2, n / 4);
    let speed = |k: usize| {
        let (a, b) = (k.saturating_sub(step), (k + step).min(n - 1));
        (x[b] - x[a]) / ((b - a) as f64 * dt)
    };
    let fastest = (0..n).fold(0.0f64, |m, k| m.max(speed(k).abs()));
    let usable = |k: usize| use_sample(k) && speed(k).abs() > 0.2 * fastest;
    let (mut best, mut from) = (0..0, None);
    for k in 0..=n {
        match (k < n && usable(k), from) {
            (true, None) => from = Some(k),
            (false, Some(start)) => {
                if k - start > best.len() {
                    best = start..k;
                }
                from = None;
            }
            _ => {}
        }
    }
    let m = best.len();
    let distance = if m > 0 {
        (x[best.end - 1] - x[best.start]).abs()
    } else {
        0.0
    };
    if m < 200 || distance <= 0.0 {
        return Err(Error::TooFew {
            name: "samples in motion",
            needed: 200,
            got: m,
        });
    }
    let mean_speed = distance / (m as f64 * dt);
    let longest = distance / 16.0;
    // A period of `longest` appears at mean speed / longest in time; the filter keeps three tenths of it.
    let corner = (0.3 * mean_speed / longest).min(0.2 / dt);
    let (mut own, mut v) = (0.0, 0.0);
    let mut before = record.acceleration[best.start];
    let residual: Vec<f64> = best
        .clone()
        .map(|k| {
            let a = record.acceleration[k];
            own += dt * v + dt * dt * (before / 3.0 + a / 6.0);
            v += 0.5 * dt * (before + a);
            before = a;
            x[k] - own
        })
        .collect();
    let filter = HighPass::butterworth(4, corner, dt)?;
    let e = filter.zero_phase(&residual, (1.0 / (corner * dt)) as usize);
    // Hann window over distance, weighted by the distance a sample covers.
    let place = |k: usize| (x[best.start + k] - x[best.start]).abs() / distance;
    let weight: Vec<f64> = (0..m)
        .map(|k| {
            let covered = if k == 0 {
                0.0
            } else {
                (place(k) - place(k - 1)).abs()
            };
            covered * (0.5 - 0.5 * (TAU * place(k)).cos())
        })
        .collect();
    let total: f64 = weight.iter().sum();
    let amplitude = |frequency: f64| {
        let (mut c, mut s) = (0.0, 0.0);
        for k in 0..m {
            let (sin, cos) = (TAU * frequency * x[best.start + k]).sin_cos();
            c += weight[k] * e[k] * cos;
            s += weight[k] * e[k] * sin;
        }
        2.0 * c.hypot(s) / total
    };
    // From half of the lowest frequency that is sought to four samples per period at mean speed, four points per line width.
    let high = (0.25 / (mean_speed * dt)).min(400.0 / distance);
    let (low, df) = (0.5 / longest, 0.25 / distance);
    let count = ((high - low) / df).max(0.0) as usize + 1;
    let spectrum: Vec<f64> = (0..count).map(|i| amplitude(low + df * i as f64)).collect();
    // What is integrated twice has no even spectrum: each line is held against its own surroundings.
    let level = |i: usize| {
        let around = i.saturating_sub(AROUND)..(i + AROUND + 1).min(count);
        let mut around = spectrum[around].to_vec();
        upper_median(&mut around).unwrap_or(0.0)
    };
    let line = |frequency: f64| {
        let amplitude = amplitude(frequency);
        let level = level((((frequency - low) / df).max(0.0) as usize).min(count - 1));
        RippleLine {
            period: 1.0 / frequency,
            amplitude,
            // The median of a Rayleigh variable is 1.1774 of the σ of one component.
            amplitude_uncertainty: level / 1.1774,
            relative_velocity: TAU * frequency * amplitude,
        }
    };
    // Whatever stays within half an increment has no line above 2/π of one: a regular motion makes nearly that of an ideal encoder.
    let rounding = match record.source {
        ReadingSource::Position => {
            let increment = record.increment.or_else(|| speed_increment(&x));
            2.0 / PI * increment.unwrap_or(0.0)
        }
        ReadingSource::Speed => 0.0,
    };
    let first = (1.0 / longest - low) / df;
    let mut lines: Vec<RippleLine> = (first as usize..count.saturating_sub(1))
        .filter(|&i| {
            spectrum[i] > rounding
                && spectrum[i] >= spectrum[i - 1]
                && spectrum[i] > spectrum[i + 1]
                && spectrum[i] > 5.0 * level(i)
        })
        .map(|i| line(low + df * i as f64))
        .collect();
    lines.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    lines.truncate(8);
    let once_per_turn = circumference
        .filter(|c| c.is_finite() && *c > 0.0 && *c <= longest)
        .map(|c| line(1.0 / c));
    let mut findings = Vec::new();
    let shown = once_per_turn
        .filter(|l| l.amplitude > CERTAIN * l.amplitude_uncertainty && l.amplitude > rounding);
    let told: Vec<String> = shown
        .iter()
        .chain(lines.iter().take(3))
        .map(|l| {
            format!(
                "period {:.5}, amplitude {:.2e} (u = {:.1e}), {:.2} % of the velocity, {:.0} periods recorded",
                l.period,
                l.amplitude,
                l.amplitude_uncertainty,
                100.0 * l.relative_velocity,
                distance / l.period
            )
        })
        .collect();
    if !told.is_empty() {
        findings.push(findings::encoder_ripple(&told.join("; ")));
    }
    Ok(Ripple {
        lines,
        once_per_turn,
        distance,
        findings,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ReadingSource;
    use proofmass_rig::{AxisMotion, DrivenAxis};

    #[test]
    fn law_eccentricity_is_measured() {
        // Constant speed; one turn is 2π · 0.3 m = 1.885 m, and 0.5 mrad there are 0.15 mm.
        let mut axis = DrivenAxis::new(AxisMotion::Ramp {
            velocity: 10.0,
            acceleration: 1000.0,
        });
        axis.encoder.lines = 5000;
        axis.encoder.eccentricity = 5e-4;
        axis.accelerometer.bits = 0;
        let r = axis.simulate(13).unwrap();
        let record =
            MotionRecord::new(1e-3, ReadingSource::Position, r.position(), r.acceleration).unwrap();
        let turn = TAU * 0.3;
        let found = ripple(&record, Some(turn), |_| true).unwrap();
        let line = found.once_per_turn.unwrap();
        assert!((line.amplitude - 1.5e-4).abs() < 1e-5, "{line:?}");
        assert!(
            (found.lines[0].period / turn - 1.0).abs() < 0.03,
            "{:?}",
            found.lines
        );
        assert_eq!(found.findings[0].code(), "encoder-ripple");
    }

    /// Ideal encoders of different lines and motions, with and without a stated increment, beside an accelerometer with noise
    /// and offset: no line. At a rate of one in a thousand, two of 48 have a chance of 0.001.
    #[test]
    fn coverage_an_ideal_encoder_has_no_lines() {
        let mut told = Vec::new();
        let mut runs = 0;
        for seed in 0..4 {
            for lines in [50, 500, 5000] {
                for (name, motion) in [
                    (
                        "ramp",
                        AxisMotion::Ramp {
                            velocity: 10.0,
                            acceleration: 20.0,
                        },
                    ),
                    (
                        "servo",
                        AxisMotion::Servo {
                            amplitude: 10.0,
                            frequency: 0.1,
                            loop_frequency: 2.0,
                            loop_damping: 0.7,
                        },
                    ),
                ] {
                    let mut axis = DrivenAxis::new(motion);
                    axis.encoder.lines = lines;
                    axis.accelerometer.noise = 0.05;
                    let r = axis.simulate(seed).unwrap();
                    let mut record = MotionRecord::new(
                        1.0 / axis.rate,
                        ReadingSource::Position,
                        r.position(),
                        r.acceleration.clone(),
                    )
                    .unwrap();
                    for increment in [None, Some(r.increment)] {
                        record.increment = increment;
                        runs += 1;
                        if let Ok(found) =
                            ripple(&record, Some(TAU * axis.encoder.radius), |_| true)
                            && !found.findings.is_empty()
                        {
                            told.push(format!(
                                "{name} {lines} {seed} {increment:?}: {:?}",
                                found.lines
                            ));
                        }
                    }
                }
            }
        }
        assert!(
            told.len() <= 1,
            "{} of {runs}:\n{}",
            told.len(),
            told.join("\n")
        );
    }
}
