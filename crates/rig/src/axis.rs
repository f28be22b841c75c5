//! A driven axis with an encoder and an accelerometer: exact motion, imperfect sensors.

mod motion;

pub use motion::{AxisMotion, MotionPoint};

use proofmass_core::check::within;
use proofmass_core::{Error, STANDARD_GRAVITY};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// What is simulated.
///
/// **Units** m, s, m/s², Hz, rad. The encoder's angle appears as the arc at `radius`, where the accelerometer sits.
///
/// ```
/// use proofmass_rig::{DrivenAxis, AxisMotion};
/// let recording = DrivenAxis { duration: 2.0, ..DrivenAxis::new(AxisMotion::damped_oscillation()) }.simulate(1)?;
/// assert_eq!(recording.acceleration.len(), 2001);
/// assert!((recording.increment - 0.3 * core::f64::consts::TAU / 2000.0).abs() < 1e-15);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DrivenAxis {
    /// The motion.
    pub motion: AxisMotion,
    /// Duration, s.
    pub duration: f64,
    /// Rate of the accelerometer and of the recording, Hz.
    pub rate: f64,
    /// Encoder.
    pub encoder: AxisEncoder,
    /// Accelerometer.
    pub accelerometer: AxisAccelerometer,
}

/// The encoder of an [`DrivenAxis`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxisEncoder {
    /// Lines per turn; decoded fourfold.
    pub lines: u32,
    /// Radius at which arc and acceleration are taken, m.
    pub radius: f64,
    /// A reading at every n-th sample of the recording; 1 for all.
    pub every: usize,
    /// Probability that a reading is missing.
    pub missing: f64,
    /// Amplitude of the once-per-turn error of an eccentric disc, rad.
    pub eccentricity: f64,
}

/// The accelerometer of an [`DrivenAxis`].
///
/// Signal path: gain and orientation → delay → high-pass of the piezo element → offset → white noise → converter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxisAccelerometer {
    /// Standard deviation of white noise, m/s² per sample.
    pub noise: f64,
    /// Offset as a share of the largest acceleration of the motion; 0.0005 in the reference experiment.
    pub offset: f64,
    /// Relative gain error.
    pub gain_error: f64,
    /// Angle between the sensitive axis and the motion in the vertical plane: adds g sin θ and scales by cos θ.
    pub orientation: f64,
    /// Corner of the first-order roll-off of a piezoelectric device, Hz; zero for a device that measures to DC.
    pub roll_off: f64,
    /// Delay of the accelerometer against the encoder, s.
    pub latency: f64,
    /// Bits of the converter, fitted to the range of the signal with 5 % to spare; zero for none.
    pub bits: u32,
}

/// What the bench recorded, with the truth at every sample.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AxisRecording {
    /// Sample time, s.
    pub sample_time: f64,
    /// Encoder count per sample; `None` where there is no reading.
    pub count: Vec<Option<i64>>,
    /// Arc of one count, m.
    pub increment: f64,
    /// Accelerometer, m/s².
    pub acceleration: Vec<f64>,
    /// Step of the converter, m/s²; zero without one.
    pub converter_step: f64,
    /// Constant error of the accelerometer that was put in (offset and gravity), m/s².
    pub offset: f64,
    /// The truth.
    pub truth: Vec<MotionPoint>,
}

impl AxisRecording {
    /// Encoder position in the middle of the count's increment, m.
    pub fn position(&self) -> Vec<Option<f64>> {
        self.count
            .iter()
            .map(|count| count.map(|n| (n as f64 + 0.5) * self.increment))
            .collect()
    }
}

impl DrivenAxis {
    /// 500 lines at 0.3 m, 16-bit converter, 0.02 m/s² noise, 1 kHz, 5 s, no other error.
    pub fn new(motion: AxisMotion) -> Self {
        Self {
            motion,
            duration: 5.0,
            rate: 1000.0,
            encoder: AxisEncoder {
                lines: 500,
                radius: 0.3,
                every: 1,
                missing: 0.0,
                eccentricity: 0.0,
            },
            accelerometer: AxisAccelerometer {
                noise: 0.02,
                offset: 0.0,
                gain_error: 0.0,
                orientation: 0.0,
                roll_off: 0.0,
                latency: 0.0,
                bits: 16,
            },
        }
    }

    /// Runs the bench: the same recording for the same settings and seed on every machine.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for settings outside what the bench can do.
    pub fn simulate(&self, seed: u64) -> Result<AxisRecording, Error> {
        self.check()?;
        let (encoder, device) = (&self.encoder, &self.accelerometer);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let dt = 1.0 / self.rate;
        let n = (self.duration * self.rate).round() as usize + 1;
        let truth: Vec<MotionPoint> = (0..n).map(|k| self.motion.at(k as f64 * dt)).collect();
        let largest = truth
            .iter()
            .fold(0.0f64, |m, p| m.max(p.acceleration.abs()));

        let increment = TAU * encoder.radius / (4.0 * f64::from(encoder.lines));
        // Where in an increment the axis starts is nobody's choice.
        let phase: f64 = rng.random();
        let turn: f64 = rng.random::<f64>() * TAU;
        let mut count = Vec::with_capacity(n);
        for (k, point) in truth.iter().enumerate() {
            let angle = point.position / encoder.radius;
            let seen = point.position
                + encoder.radius
                    * encoder.eccentricity
                    * (libm::sin(angle + turn) - libm::sin(turn));
            let lost = rng.random::<f64>() < encoder.missing;
            let read = k % encoder.every == 0 && !lost;
            count.push(read.then(|| (seen / increment + phase).floor() as i64));
        }

        let offset = device.offset * largest;
        let gravity = STANDARD_GRAVITY * libm::sin(device.orientation);
        let analogue = self.piezo(n, dt, gravity);
        let mut acceleration: Vec<f64> = analogue
            .iter()
            .map(|a| {
                let noise: f64 = StandardNormal.sample(&mut rng);
                a + offset + device.noise * noise
            })
            .collect();
        let range = 1.05 * acceleration.iter().fold(0.0f64, |m, a| m.max(a.abs()));
        let step = if device.bits == 0 || range == 0.0 {
            0.0
        } else {
            2.0 * range / 2f64.powi(device.bits as i32)
        };
        if step > 0.0 {
            for a in &mut acceleration {
                *a = (*a / step).round() * step;
            }
        }
        Ok(AxisRecording {
            sample_time: dt,
            count,
            increment,
            acceleration,
            converter_step: step,
            offset: offset + gravity,
            truth,
        })
    }

    /// Signal of the element at every sample: gain, orientation, latency and roll-off.
    fn piezo(&self, n: usize, dt: f64, gravity: f64) -> Vec<f64> {
        let device = &self.accelerometer;
        let scale = (1.0 + device.gain_error) * libm::cos(device.orientation);
        let input = |t: f64| scale * self.motion.at(t - device.latency).acceleration + gravity;
        if device.roll_off == 0.0 {
            return (0..n).map(|k| input(k as f64 * dt)).collect();
        }
        // y' = a' − ω_c y by the trapezoid at sixteen times the rate: its warp, (ω_c T/16)²/12, is far below any
        // other error here.
        const OVER: usize = 16;
        let h = 0.5 * TAU * device.roll_off * dt / OVER as f64;
        let (mut y, mut before) = (0.0, input(0.0));
        let mut output = Vec::with_capacity(n);
        for k in 0..n {
            output.push(y);
            for j in 1..=OVER {
                let now = input((k as f64 + j as f64 / OVER as f64) * dt);
                y = (y * (1.0 - h) + now - before) / (1.0 + h);
                before = now;
            }
        }
        output
    }

    fn check(&self) -> Result<(), Error> {
        let (e, a) = (&self.encoder, &self.accelerometer);
        within("rate", self.rate, 1e-3, 1e8)?;
        within("duration", self.duration, 0.0, 1e8 / self.rate)?;
        within("lines", f64::from(e.lines), 1.0, 1e9)?;
        within("radius", e.radius, 1e-9, 1e9)?;
        within("every", e.every as f64, 1.0, 1e9)?;
        within("missing", e.missing, 0.0, 1.0)?;
        within("eccentricity", e.eccentricity, -1.0, 1.0)?;
        within("noise", a.noise, 0.0, 1e9)?;
        within("offset", a.offset, -1.0, 1.0)?;
        within("gain_error", a.gain_error, -1.0, 10.0)?;
        within("orientation", a.orientation, -1.6, 1.6)?;
        within("roll_off", a.roll_off, 0.0, self.rate)?;
        within("latency", a.latency, -10.0, 10.0)?;
        within("bits", f64::from(a.bits), 0.0, 32.0)?;
        self.motion.check()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motions() -> [AxisMotion; 6] {
        [
            AxisMotion::damped_oscillation(),
            AxisMotion::servo(5.0),
            AxisMotion::servo(15.0),
            AxisMotion::impact(),
            AxisMotion::ramp(),
            AxisMotion::Standstill,
        ]
    }

    #[test]
    fn law_truth_is_its_own_derivative() {
        for motion in motions() {
            let h = 1e-5;
            for k in 1..400 {
                let t = 0.0123 * k as f64;
                let (a, b, c) = (motion.at(t - h), motion.at(t), motion.at(t + h));
                let v = (c.position - a.position) / (2.0 * h);
                let d = (c.velocity - a.velocity) / (2.0 * h);
                // Third derivatives up to 10⁷ m/s³ (impact) over h²/6, and rounding.
                assert!((v - b.velocity).abs() < 1e-5, "{motion:?} {t}");
                assert!(
                    (d - b.acceleration).abs() < 0.02 + 1e-5 * d.abs(),
                    "{motion:?} {t} {d}"
                );
            }
        }
    }

    #[test]
    fn law_perfect_sensors_show_the_truth() {
        let mut axis = DrivenAxis::new(AxisMotion::servo(10.0));
        axis.accelerometer.noise = 0.0;
        axis.accelerometer.bits = 0;
        let r = axis.simulate(3).unwrap();
        for (k, p) in r.truth.iter().enumerate() {
            assert_eq!(r.acceleration[k], p.acceleration);
        }
        let shift = r.position()[0].unwrap() - r.truth[0].position;
        for (p, truth) in r.position().iter().zip(&r.truth) {
            assert!((p.unwrap() - shift - truth.position).abs() <= r.increment);
        }
    }

    #[test]
    fn law_errors_have_the_stated_size() {
        let mut axis = DrivenAxis::new(AxisMotion::Standstill);
        axis.accelerometer.orientation = 0.01;
        axis.accelerometer.bits = 0;
        axis.duration = 20.0;
        let r = axis.simulate(4).unwrap();
        let mean = r.acceleration.iter().sum::<f64>() / r.acceleration.len() as f64;
        // Mean of 20 001 samples of 0.02: 1.4e-4.
        assert!((mean - STANDARD_GRAVITY * 0.01f64.sin()).abs() < 6e-4);
        // A 2 Hz roll-off at 5 Hz: gain 1/√(1 + (2/5)²).
        let mut axis = DrivenAxis::new(AxisMotion::servo(5.0));
        axis.accelerometer = AxisAccelerometer {
            noise: 0.0,
            roll_off: 2.0,
            bits: 0,
            ..axis.accelerometer
        };
        let r = axis.simulate(5).unwrap();
        let square = |f: &dyn Fn(usize) -> f64| (4001..5001).map(|k| f(k).powi(2)).sum::<f64>();
        let gain = (square(&|k| r.acceleration[k]) / square(&|k| r.truth[k].acceleration)).sqrt();
        assert!((gain - 1.0 / 1.16f64.sqrt()).abs() < 1e-3, "{gain}");
    }

    #[test]
    fn law_seed_decides_everything() {
        let mut axis = DrivenAxis::new(AxisMotion::impact());
        axis.encoder.missing = 0.1;
        axis.encoder.every = 2;
        let a = axis.simulate(7).unwrap();
        assert_eq!(a, axis.simulate(7).unwrap());
        assert_ne!(a.acceleration, axis.simulate(8).unwrap().acceleration);
        let read = a.count.iter().flatten().count() as f64 / a.count.len() as f64;
        assert!((read - 0.45).abs() < 0.03); // binomial, σ = 0.0042 per 5001 samples
    }

    #[test]
    fn refuses_impossible_settings() {
        let mut axis = DrivenAxis::new(AxisMotion::Standstill);
        axis.rate = f64::NAN;
        assert!(axis.simulate(1).is_err());
        let mut axis = DrivenAxis::new(AxisMotion::servo(-1.0));
        axis.duration = 1.0;
        assert!(axis.simulate(1).is_err());
    }
}
