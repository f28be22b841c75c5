//! Two wheels of an axle beside a gyroscope: where they turn the vehicle otherwise than it turns, one of them slips.

use crate::findings;
use crate::several_wheels::smallest_step;

use proofmass_core::{Error, check};
use proofmass_motion::ReadingSource;
use proofmass_motion::episode::{Episode, episodes, held, largest, others, quiet, slope};
use proofmass_uncertainty::Finding;

/// The wheels of an axle and the rate at which the vehicle turns, at equal steps of time.
#[derive(Clone, Copy, Debug)]
pub struct Axle<'a> {
    /// Sample time, s.
    pub sample_time: f64,
    /// Whether the wheels tell ways or speeds.
    pub source: ReadingSource,
    /// Left and right wheel, m or m/s; `None` where there is no reading.
    pub wheels: [&'a [Option<f64>]; 2],
    /// Turning to the left, rad/s; `None` where there is no reading.
    pub yaw_rate: &'a [Option<f64>],
    /// Distance of the wheels, m.
    pub track: f64,
    /// Increment of a wheel's reading, where it is known; else the smallest step of the readings is taken for it.
    pub increment: Option<f64>,
}

/// Where one wheel of an axle slips.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct WheelSlip {
    /// Stretches; `velocity` is how much faster the right wheel became than the turning explains.
    pub slip: Vec<Episode>,
    /// Standard deviation of the quiet part over one window, m/s.
    pub quiet_deviation: f64,
    /// In words.
    pub findings: Vec<Finding>,
}

/// Threshold in standard deviations of the quiet part.
const THRESHOLD: f64 = 8.0;

impl Axle<'_> {
    /// Compares the change of the wheels' difference over adjacent windows with that of the turning.
    ///
    /// right − left = track · rate, of the mean speeds of a window after a sample less those of the window before it:
    /// unequal wheels and an offset of the gyroscope drop out. Centre and width of the quiet part are those of the shortest
    /// interval that holds 30 % of the differences. Where both wheels slip alike only the accelerometer tells
    /// ([`SlipSearch`](proofmass_motion::SlipSearch)).
    ///
    /// **Accuracy** healthy axles in curves: tests of this file.
    ///
    /// # Errors
    /// [`Error::Length`] for channels of unequal length; [`Error::TooFew`] below eight windows; [`Error::OutOfRange`] for a
    /// sample time or a track that is not positive; [`Error::NotFinite`].
    pub fn slip(&self) -> Result<WheelSlip, Error> {
        let n = self.yaw_rate.len();
        let [left, right] = self.wheels;
        for (name, channel) in [
            ("left wheel", left),
            ("right wheel", right),
            ("yaw rate", self.yaw_rate),
        ] {
            if channel.len() != n {
                return Err(Error::Length {
                    name,
                    expected: n,
                    got: channel.len(),
                });
            }
            let bad = |r: &Option<f64>| r.is_some_and(|r| !r.is_finite());
            if let Some(index) = channel.iter().position(bad) {
                return Err(Error::NotFinite { name, index });
            }
        }
        for (name, value) in [("sample time", self.sample_time), ("track", self.track)] {
            check::positive(name, value)?;
        }
        let dt = self.sample_time;
        let read = self.wheels[0].iter().flatten().count().max(1);
        // Windows hold several readings of a slower sensor.
        let w = ((0.05 / dt).round() as usize)
            .max(5)
            .max(4 * n.div_ceil(read));
        if n < 8 * w {
            return Err(Error::TooFew {
                name: "samples",
                needed: 8 * w,
                got: n,
            });
        }
        let [left, right, yaw_rate] = [left, right, self.yaw_rate].map(held);
        let apart: Vec<f64> = right.iter().zip(&left).map(|(r, l)| r - l).collect();
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let beyond: Vec<f64> = (0..=n - w)
            .map(|k| {
                let inside = &apart[k..k + w];
                let speed = match self.source {
                    ReadingSource::Position => slope(inside, dt),
                    ReadingSource::Speed => mean(inside),
                };
                speed - self.track * mean(&yaw_rate[k..k + w])
            })
            .collect();
        let change: Vec<f64> = (0..beyond.len() - w)
            .map(|k| beyond[k + w] - beyond[k])
            .collect();
        let (centre, deviation) = quiet(&change);
        let z = |d: f64| (d - centre) / deviation;
        // Two lines through counts that are each wrong by half an increment at most, of two wheels; or two means of them.
        let increment = self.increment.unwrap_or_else(|| {
            let steps = self.wheels.map(smallest_step);
            steps[0].max(steps[1])
        });
        let rounding = match self.source {
            ReadingSource::Position => 6.0 * increment / (w as f64 * dt),
            ReadingSource::Speed => 2.0 * increment,
        };
        let slip = episodes(
            &change,
            |d| z(d).abs() > THRESHOLD && (d - centre).abs() > rounding,
            w,
            w,
            n,
            |d| (d - centre, z(d)),
        );
        let findings = largest(&slip).into_iter().map(|e| {
            findings::wheel_slip(
                "right wheel, beside what turning explains",
                e.from as f64 * dt,
                e.to as f64 * dt,
                e.velocity.abs(),
                if e.velocity > 0.0 { "faster" } else { "slower" },
                1e3 * w as f64 * dt,
                e.deviations,
                &others(&slip),
            )
        });
        Ok(WheelSlip {
            findings: findings.collect(),
            slip,
            quiet_deviation: deviation,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    const DT: f64 = 0.01;
    const N: usize = 6000;
    const TRACK: f64 = 1.5;

    /// A minute of a car that speeds up, brakes and turns: speeds of both wheels in steps of 0.01 m/s, and its gyroscope.
    fn drive(seed: u64, spin: f64) -> ([Vec<Option<f64>>; 2], Vec<Option<f64>>) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let phase = [normal(), normal(), normal()];
        let mut wheels = [Vec::with_capacity(N), Vec::with_capacity(N)];
        let mut yaw = Vec::with_capacity(N);
        for k in 0..N {
            let t = DT * k as f64;
            let v = 12.0 + 6.0 * (0.35 * t + phase[0]).sin();
            let w = 0.3 * (0.5 * t + phase[1]).sin() + 0.1 * (2.1 * t + phase[2]).sin();
            // The left wheel is 0.4 % larger, the right one spins for a second.
            let extra =
                spin * (t - 30.0).clamp(0.0, 0.3) / 0.3 - spin * (t - 31.0).clamp(0.0, 0.3) / 0.3;
            let read = |v: f64| Some(100.0f64.recip() * (100.0 * v).round());
            wheels[0].push(read(0.996 * (v - 0.5 * TRACK * w) + 0.02 * normal()));
            wheels[1].push(read(v + 0.5 * TRACK * w + extra + 0.02 * normal()));
            yaw.push(Some(w + 0.004 + 0.005 * normal()));
        }
        (wheels, yaw)
    }

    fn found(seed: u64, spin: f64) -> WheelSlip {
        let (wheels, yaw) = drive(seed, spin);
        let axle = Axle {
            sample_time: DT,
            source: ReadingSource::Speed,
            wheels: [&wheels[0], &wheels[1]],
            yaw_rate: &yaw,
            track: TRACK,
            increment: None,
        };
        axle.slip().unwrap()
    }

    #[test]
    fn law_a_wheel_that_spins_is_found_where_it_does() {
        for seed in 0..10 {
            let slip = found(seed, 1.5).slip;
            assert!(
                slip.iter().any(|e| e.from > 2990 && e.from < 3040),
                "{slip:?}"
            );
            assert!(
                slip.iter().all(|e| e.from > 2980 && e.to < 3150),
                "{slip:?}"
            );
        }
        assert_eq!(found(1, 1.5).findings[0].code(), "wheel-slip");
    }

    #[test]
    fn known_false_alarms_of_healthy_axles_in_curves() {
        let alarms = (100..200)
            .filter(|s| !found(*s, 0.0).slip.is_empty())
            .count();
        // At one in a hundred: more than four of a hundred by chance in one of 300.
        assert!(alarms <= 4, "{alarms} of 100");
    }

    #[test]
    fn refuses_axles_that_cannot_be() {
        let (wheels, yaw) = drive(1, 0.0);
        let axle = Axle {
            sample_time: DT,
            source: ReadingSource::Speed,
            wheels: [&wheels[0], &wheels[1]],
            yaw_rate: &yaw,
            track: TRACK,
            increment: None,
        };
        assert!(Axle { track: 0.0, ..axle }.slip().is_err());
        assert!(
            Axle {
                sample_time: f64::NAN,
                ..axle
            }
            .slip()
            .is_err()
        );
        assert!(
            Axle {
                yaw_rate: &yaw[1..],
                ..axle
            }
            .slip()
            .is_err()
        );
        let few = [&wheels[0][..20], &wheels[1][..20]];
        assert!(
            Axle {
                wheels: few,
                yaw_rate: &yaw[..20],
                ..axle
            }
            .slip()
            .is_err()
        );
        let bad = vec![Some(f64::NAN); N];
        assert!(
            Axle {
                yaw_rate: &bad,
                ..axle
            }
            .slip()
            .is_err()
        );
        let none = vec![None; N];
        assert!(
            Axle {
                wheels: [&none, &none],
                ..axle
            }
            .slip()
            .is_err()
        );
    }
}
