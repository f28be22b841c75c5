//! A resolver over a whole recording: demodulation of its carrier, and its angle.

use crate::findings;
use crate::small_matrix::inverse;
use proofmass_core::Error;
use proofmass_core::encoder::resolver_angle;
use proofmass_uncertainty::Finding;
use std::f64::consts::{PI, TAU};

/// What excites a resolver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Excitation<'a> {
    /// Its voltage, sampled with those of the windings.
    Voltage(&'a [f64]),
    /// Its frequency, Hz. Sine and cosine then may both have the wrong sign: the angle is told but for half a turn.
    Frequency(f64),
}

/// The voltages of a resolver without their carrier, one pair for each block of whole carrier periods.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Demodulated {
    /// Middles of the blocks, s.
    pub time: Vec<f64>,
    /// V sin θ there.
    pub sine: Vec<f64>,
    /// V cos θ there.
    pub cosine: Vec<f64>,
    /// Frequency of the carrier, Hz.
    pub carrier: f64,
    /// Samples of a block.
    pub block: usize,
}

/// Fewest samples of a block: five unknowns, and something left over.
const BLOCK: usize = 8;
/// Fewest samples of a carrier period: below, the curve between them is not told.
const PER_PERIOD: f64 = 4.0;
/// Columns of the fit of a block: cosine, sine, both times the time from the middle, a constant.
const FIT: usize = 5;

/// The windings' voltages V sin ωt sin θ and V sin ωt cos θ, sampled evenly and faster than the carrier, without the carrier.
///
/// In each block of whole periods a carrier whose amplitude changes along a line, and a constant, are fitted to both
/// voltages. The phase of the carrier is that of the windings themselves, half the argument of z_s² + z_c² (it does not
/// depend on θ), followed from block to block, so that a frequency which is a little off does not matter and the lag of
/// the windings behind their excitation takes no amplitude; only its sign is that of the excitation. What is in quadrature
/// (the voltage that rotation induces) drops out.
///
/// **Delay** none: a pair belongs to the middle of its block. **Assumes** less than a quarter turn of the axis within a block.
///
/// # Errors
/// [`Error::Length`]; [`Error::TooFew`] below three blocks; [`Error::OutOfRange`] for a frequency with less than four samples to a
/// period or with no period in the recording, and for a step of time that is not positive; [`Error::Constant`] for an excitation that does not oscillate.
pub fn demodulated(
    start: f64,
    sample_time: f64,
    sine: &[f64],
    cosine: &[f64],
    excitation: Excitation<'_>,
) -> Result<Demodulated, Error> {
    let n = sine.len();
    let lengths = [
        ("cosine", cosine.len()),
        (
            "excitation",
            match excitation {
                Excitation::Voltage(v) => v.len(),
                Excitation::Frequency(_) => n,
            },
        ),
    ];
    for (name, got) in lengths {
        if got != n {
            return Err(Error::Length {
                name,
                expected: n,
                got,
            });
        }
    }
    let positive = |name, value: f64| match value.is_finite() && value > 0.0 {
        true => Ok(()),
        false => Err(Error::OutOfRange {
            name,
            value,
            min: f64::MIN_POSITIVE,
            max: f64::MAX,
        }),
    };
    positive("sample time", sample_time)?;
    let carrier = match excitation {
        Excitation::Voltage(v) => oscillation(v)? / sample_time,
        Excitation::Frequency(f) => f,
    };
    let period = 1.0 / (carrier * sample_time);
    let longest = n as f64;
    if !(PER_PERIOD..=longest).contains(&period) {
        return Err(Error::OutOfRange {
            name: "carrier frequency",
            value: carrier,
            min: 1.0 / (longest * sample_time),
            max: 1.0 / (PER_PERIOD * sample_time),
        });
    }
    let few = |needed| Error::TooFew {
        name: "samples of the windings",
        needed,
        got: n,
    };
    let block = whole_block(period);
    if n < 3 * block {
        return Err(few(3 * block));
    }
    let fit = Fit::new(block, TAU / period).ok_or(Error::Singular {
        name: "fit of the carrier",
        condition: f64::INFINITY,
    })?;
    let count = n / block;
    let of = |values: &[f64]| -> Vec<[f64; 2]> {
        values
            .chunks_exact(block)
            .map(|part| fit.amplitude(part))
            .collect()
    };
    let (s, c) = (of(sine), of(cosine));
    let own = match excitation {
        Excitation::Voltage(v) => Some(of(v)),
        Excitation::Frequency(_) => None,
    };
    let mut found = Demodulated {
        time: Vec::with_capacity(count),
        sine: Vec::with_capacity(count),
        cosine: Vec::with_capacity(count),
        carrier,
        block,
    };
    // By how much the carrier turns from block to block, whole turns left out.
    let turn = block as f64 / period;
    let mut phase: Option<f64> = None;
    for k in 0..count {
        let square = |[x, y]: [f64; 2]| [x * x - y * y, 2.0 * x * y];
        let (a, b) = (square(s[k]), square(c[k]));
        let [x, y] = [a[0] + b[0], a[1] + b[1]];
        let expected = phase.map(|p| p + TAU * turn);
        let here = match (x == 0.0 && y == 0.0, expected) {
            // No signal: the carrier goes on.
            (true, expected) => expected.unwrap_or(0.0),
            (false, None) => 0.5 * y.atan2(x),
            (false, Some(expected)) => {
                let half = 0.5 * y.atan2(x);
                half + PI * ((expected - half) / PI).round()
            }
        };
        let here = match &own {
            // The sense of the excitation, within a quarter of a turn of its lag.
            Some(own) => {
                let along = own[k][0] * here.cos() + own[k][1] * here.sin();
                if along < 0.0 { here + PI } else { here }
            }
            None => here,
        };
        phase = Some(here.rem_euclid(TAU));
        let (q, p) = here.sin_cos();
        found.sine.push(s[k][0] * p + s[k][1] * q);
        found.cosine.push(c[k][0] * p + c[k][1] * q);
        let middle = k as f64 * block as f64 + 0.5 * (block as f64 - 1.0);
        found.time.push(start + sample_time * middle);
    }
    Ok(found)
}

/// Samples of the shortest block that holds whole periods within a fiftieth of one, or of the best of sixteen.
fn whole_block(period: f64) -> usize {
    let mut best = (f64::INFINITY, 0);
    for periods in 1..=16 {
        let length = f64::from(periods) * period;
        let samples = length.round();
        if (samples as usize) < BLOCK {
            continue;
        }
        let off = (samples - length).abs() / period;
        if off < 0.02 {
            return samples as usize;
        }
        if off < best.0 {
            best = (off, samples as usize);
        }
    }
    best.1.max(BLOCK)
}

/// Cycles per sample of an oscillation, from its rising passes through its middle.
///
/// A pass counts when the voltage was below a third of its amplitude before, so that noise makes no passes.
fn oscillation(v: &[f64]) -> Result<f64, Error> {
    let high = v.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = v.iter().copied().fold(f64::INFINITY, f64::min);
    let (middle, third) = (0.5 * (high + low), (high - low) / 6.0);
    let mut armed = false;
    let (mut first, mut last, mut passes) = (0.0, 0.0, 0usize);
    for (k, w) in v.windows(2).enumerate() {
        armed |= w[0] < middle - third;
        if armed && w[0] < middle && w[1] >= middle {
            let at = k as f64 + (middle - w[0]) / (w[1] - w[0]);
            if passes == 0 {
                first = at;
            }
            last = at;
            passes += 1;
            armed = false;
        }
    }
    match passes {
        0..=2 => Err(Error::Constant {
            name: "excitation of the resolver",
            value: v.first().copied().unwrap_or(0.0),
        }),
        n => Ok((n - 1) as f64 / (last - first)),
    }
}

/// Least squares of a carrier over a block, as weights of its samples.
struct Fit {
    weights: [Vec<f64>; 2],
}

impl Fit {
    /// For so many samples, the carrier turning by `step` rad from one to the next.
    fn new(samples: usize, step: f64) -> Option<Self> {
        let middle = 0.5 * (samples as f64 - 1.0);
        let rows: Vec<[f64; FIT]> = (0..samples)
            .map(|k| {
                let t = k as f64 - middle;
                let (s, c) = (step * t).sin_cos();
                let ramp = t / middle;
                [c, s, ramp * c, ramp * s, 1.0]
            })
            .collect();
        let mut normal = [[0.0; FIT]; FIT];
        for row in &rows {
            for i in 0..FIT {
                for j in 0..FIT {
                    normal[i][j] += row[i] * row[j];
                }
            }
        }
        let inverse = inverse(normal)?;
        let of = |i: usize| {
            let weight = |row: &[f64; FIT]| (0..FIT).map(|j| inverse[i][j] * row[j]).sum();
            rows.iter().map(weight).collect()
        };
        Some(Self {
            weights: [of(0), of(1)],
        })
    }

    /// Parts along the cosine and the sine of the carrier counted from the middle of the block.
    fn amplitude(&self, block: &[f64]) -> [f64; 2] {
        [0, 1].map(|i| self.weights[i].iter().zip(block).map(|(w, v)| w * v).sum())
    }
}

/// Angles of a resolver over a recording.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ResolverAngles {
    /// Continuous angle, rad; where there is no signal the last one.
    pub angle: Vec<f64>,
    /// Samples without a signal: less than a third of the usual amplitude.
    pub lost: Vec<usize>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

/// Continuous angle in rad from the demodulated voltages of a resolver, V sin θ and V cos θ.
///
/// # Errors
/// [`Error::Length`]; [`Error::Constant`] where there is no signal in most samples.
pub fn resolver(sine: &[f64], cosine: &[f64]) -> Result<ResolverAngles, Error> {
    if sine.len() != cosine.len() {
        return Err(Error::Length {
            name: "cosine",
            expected: sine.len(),
            got: cosine.len(),
        });
    }
    let pairs = || sine.iter().zip(cosine);
    let mut amplitudes: Vec<f64> = pairs().map(|(s, c)| s.hypot(*c)).collect();
    let usual = {
        let mut sorted = amplitudes.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
    };
    let signal = |a: f64| a.is_finite() && a > usual / 3.0;
    let silent = !(usual > 0.0 && usual.is_finite());
    if silent && !sine.is_empty() {
        return Err(Error::Constant {
            name: "voltages of the resolver",
            value: usual,
        });
    }
    let mut found = ResolverAngles {
        angle: Vec::with_capacity(sine.len()),
        lost: Vec::new(),
        findings: Vec::new(),
    };
    let (mut turns, mut last) = (0.0, None::<f64>);
    for (k, (s, c)) in pairs().enumerate() {
        let Some((theta, _)) = resolver_angle(*s, *c).filter(|_| signal(amplitudes[k])) else {
            found.lost.push(k);
            let held = found.angle.last().copied().unwrap_or(0.0);
            found.angle.push(held);
            continue;
        };
        if let Some(last) = last {
            let step = theta - last;
            if step > PI {
                turns -= TAU;
            } else if step < -PI {
                turns += TAU;
            }
        }
        last = Some(theta);
        found.angle.push(theta + turns);
    }
    amplitudes.retain(|a| signal(*a));
    let least = amplitudes.iter().copied().fold(f64::INFINITY, f64::min);
    let most = amplitudes.iter().copied().fold(0.0, f64::max);
    if least < 0.9 * most {
        found
            .findings
            .push(findings::resolver_amplitude(least, most));
    }
    if let Some(first) = found.lost.first() {
        found.findings.push(findings::resolver_signal_lost(
            found.lost.len(),
            found.angle.len(),
            usual,
            *first,
        ));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_resolver_continues_over_turns() {
        let theta: Vec<f64> = (0..500).map(|k| 0.05 * f64::from(k)).collect();
        let (s, c): (Vec<f64>, Vec<f64>) = theta.iter().map(|t| t.sin_cos()).unzip();
        let found = resolver(&s, &c).unwrap();
        assert!(found.findings.is_empty() && found.lost.is_empty());
        for (a, t) in found.angle.iter().zip(&theta) {
            assert!((a - t).abs() < 1e-12);
        }
        let weak: Vec<f64> = s.iter().map(|s| 0.7 * s).collect();
        let found = resolver(&weak, &c).unwrap();
        assert_eq!(found.findings[0].code(), "resolver-amplitude");
        assert!(resolver(&[0.0; 5], &[0.0; 5]).is_err());
        assert!(resolver(&s, &c[1..]).is_err());
    }

    #[test]
    fn law_a_signal_that_is_lost_is_no_reading() {
        let theta: Vec<f64> = (0..500).map(|k| 0.05 * f64::from(k)).collect();
        let (mut s, mut c): (Vec<f64>, Vec<f64>) = theta.iter().map(|t| t.sin_cos()).unzip();
        s[100..120].fill(0.01);
        c[100..120].fill(f64::NAN);
        let found = resolver(&s, &c).unwrap();
        assert_eq!(found.lost, (100..120).collect::<Vec<_>>());
        assert_eq!(found.findings[0].code(), "resolver-signal-lost");
        assert!((found.angle[130] - theta[130]).abs() < 1e-12);
    }

    /// Voltages of the windings at a carrier of 5 kHz that lags its excitation by 0.4 rad, sampled at 96 kHz.
    fn windings(angle: impl Fn(f64) -> f64, carrier: f64) -> [Vec<f64>; 3] {
        let dt = 1.0 / 96_000.0;
        let times = || (0..9600).map(|k| dt * f64::from(k));
        let w = TAU * carrier;
        let at = |t: f64, f: fn(f64) -> f64| 2.0 * (w * t - 0.4).sin() * f(angle(t)) + 0.01;
        [
            times().map(|t| at(t, f64::sin)).collect(),
            times().map(|t| at(t, f64::cos)).collect(),
            times().map(|t| 7.0 * (w * t).sin()).collect(),
        ]
    }

    #[test]
    fn law_the_carrier_leaves_the_angle_at_the_middle_of_its_blocks() {
        let angle = |t: f64| 1.0 + 200.0 * t;
        // Whole and broken numbers of samples to a period; 3 Hz more than is told.
        for carrier in [5000.0, 4950.0] {
            let [s, c, e] = windings(angle, carrier);
            for excitation in [
                Excitation::Voltage(&e),
                Excitation::Frequency(carrier),
                Excitation::Frequency(carrier + 3.0),
            ] {
                let found = demodulated(0.5, 1.0 / 96_000.0, &s, &c, excitation).unwrap();
                assert!(
                    (found.carrier / carrier - 1.0).abs() < 1e-3,
                    "{}",
                    found.carrier
                );
                let angles = resolver(&found.sine, &found.cosine).unwrap();
                let off = |k: usize| angles.angle[k] - angle(found.time[k] - 0.5);
                // Half a turn where the excitation was not seen.
                let zero = (off(0) / PI).round() * PI;
                if matches!(excitation, Excitation::Voltage(_)) {
                    assert!((zero / TAU).fract() == 0.0, "{zero}");
                }
                for k in 0..found.time.len() {
                    assert!((off(k) - zero).abs() < 2e-3, "{k}: {}", off(k) - zero);
                }
                assert!((found.sine[3].hypot(found.cosine[3]) - 2.0).abs() < 0.01);
            }
        }
    }

    #[test]
    fn law_a_voltage_of_rotation_in_quadrature_drops_out() {
        let dt = 1.0 / 96_000.0;
        let (w, speed) = (TAU * 5000.0, 300.0);
        let times = || (0..9600).map(|k| dt * f64::from(k));
        // d/dt (cos ωt sin θ)/ω: the induced voltage has a part θ̇/ω in quadrature.
        let s: Vec<f64> = times()
            .map(|t| {
                (w * t).sin() * (speed * t).sin() - speed / w * (w * t).cos() * (speed * t).cos()
            })
            .collect();
        let c: Vec<f64> = times()
            .map(|t| {
                (w * t).sin() * (speed * t).cos() + speed / w * (w * t).cos() * (speed * t).sin()
            })
            .collect();
        let found = demodulated(0.0, dt, &s, &c, Excitation::Frequency(5000.0)).unwrap();
        let angles = resolver(&found.sine, &found.cosine).unwrap();
        let first = angles.angle[0] - speed * found.time[0];
        for (a, t) in angles.angle.iter().zip(&found.time) {
            assert!(
                (a - speed * t - first).abs() < 3e-4,
                "{}",
                a - speed * t - first
            );
        }
    }

    #[test]
    fn refuses_carriers_that_are_none() {
        let [s, c, e] = windings(|t| t, 5000.0);
        let dt = 1.0 / 96_000.0;
        let run = |x: Excitation<'_>| demodulated(0.0, dt, &s, &c, x);
        assert!(matches!(
            run(Excitation::Voltage(&vec![1.0; s.len()])),
            Err(Error::Constant { .. })
        ));
        assert!(run(Excitation::Voltage(&e[1..])).is_err());
        for f in [0.0, -5.0, f64::NAN, f64::INFINITY, 30_000.0, 1e-3, 1e300] {
            assert!(run(Excitation::Frequency(f)).is_err(), "{f}");
        }
        assert!(demodulated(0.0, dt, &s[..5], &c[..5], Excitation::Frequency(5000.0)).is_err());
    }
}
