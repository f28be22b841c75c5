//! The machine: an electrodynamic shaker between the drive voltage and the motion of its table.

use num_complex::Complex64;

/// An electrodynamic shaker with its power amplifier, in small motion.
///
/// Acceleration per volt of drive: the table hangs in a suspension (a second-order high-pass at its resonance) and
/// its armature has an axial resonance; beyond a fraction of full travel the gain falls.
#[derive(Clone, Debug, PartialEq)]
pub struct Shaker {
    /// Acceleration per volt between the two resonances, (m/s²)/V.
    pub(crate) gain: f64,
    /// Resonance of the suspension in Hz.
    pub(crate) suspension: f64,
    /// Its quality factor.
    pub(crate) suspension_quality: f64,
    /// Axial resonance of the armature in Hz.
    pub(crate) armature: f64,
    /// Its quality factor.
    pub(crate) armature_quality: f64,
    /// Relative loss of gain per m/s² of amplitude.
    pub(crate) compression: f64,
    /// Second and third harmonic of the force, relative to the fundamental.
    pub(crate) distortion: [f64; 2],
}

impl Default for Shaker {
    fn default() -> Self {
        Self {
            gain: 37.0,
            suspension: 14.0,
            suspension_quality: 0.8,
            armature: 5.2e3,
            armature_quality: 18.0,
            compression: 4e-4,
            distortion: [0.004, 0.0015],
        }
    }
}

impl Shaker {
    /// Acceleration per volt at a frequency in Hz, for small drives.
    pub fn response(&self, frequency: f64) -> Complex64 {
        let j = Complex64::new(0.0, 1.0);
        let s = frequency / self.suspension;
        let suspension = -s * s / (1.0 - s * s + j * (s / self.suspension_quality));
        let a = frequency / self.armature;
        let armature = (1.0 - a * a + j * (a / self.armature_quality)).inv();
        -suspension * armature * self.gain
    }

    /// Motion of the table for a drive amplitude in V: complex amplitudes in m/s² of the fundamental, second and
    /// third harmonic.
    pub fn motion(&self, drive: f64, frequency: f64) -> [Complex64; 3] {
        let linear = self.response(frequency) * drive;
        let loss = 1.0 / (1.0 + self.compression * linear.norm());
        // Harmonics of the force pass through the machine at their own frequencies.
        std::array::from_fn(|h| {
            let share = if h == 0 { 1.0 } else { self.distortion[h - 1] };
            self.response((h + 1) as f64 * frequency) * (drive * loss * share)
        })
    }
}

/// A drive that reaches its target, as the closed loop of a laboratory finds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levelled {
    /// Drive amplitude in V.
    pub(crate) drive: f64,
    /// Amplitude read in the last step, m/s².
    pub(crate) reading: f64,
    /// Readings that were taken.
    pub(crate) steps: usize,
}

/// Closed-loop levelling: measure with the reference, correct the drive, until within a tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levelling {
    /// Relative tolerance of the amplitude.
    pub(crate) tolerance: f64,
    /// Most readings taken.
    pub(crate) attempts: usize,
    /// Drive of the first reading in V, small enough for any resonance.
    pub(crate) first: f64,
    /// Largest drive in V.
    pub(crate) largest: f64,
}

impl Default for Levelling {
    fn default() -> Self {
        Self {
            tolerance: 0.01,
            attempts: 20,
            first: 0.02,
            largest: 10.0,
        }
    }
}

impl Levelling {
    /// Finds the drive at which `reading_at` (drive in V to amplitude in m/s²) gives the target; `None` when it is not
    /// reached.
    pub fn run(&self, target: f64, mut reading_at: impl FnMut(f64) -> f64) -> Option<Levelled> {
        let mut drive = self.first;
        for step in 1..=self.attempts {
            let reading = reading_at(drive);
            if (reading / target - 1.0).abs() <= self.tolerance {
                return Some(Levelled {
                    drive,
                    reading,
                    steps: step,
                });
            }
            if !(reading > 0.0) {
                return None;
            }
            // Never more than a factor of four at once, as one protects a shaker.
            drive = (drive * (target / reading).clamp(0.25, 4.0)).min(self.largest);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_the_drive_reaches_its_target_at_every_frequency() {
        let shaker = Shaker::default();
        for frequency in [5.0, 14.0, 160.0, 1000.0, 5200.0] {
            let found = Levelling::default()
                .run(10.0, |drive| shaker.motion(drive, frequency)[0].norm())
                .unwrap();
            assert!((found.reading - 10.0).abs() <= 0.1, "{frequency} Hz");
        }
        // A dead amplifier, and a target beyond the amplifier.
        assert!(Levelling::default().run(10.0, |_| 0.0).is_none());
        let weak = |drive: f64| 0.1 * shaker.motion(drive, 5.0)[0].norm();
        assert!(Levelling::default().run(100.0, weak).is_none());
    }

    #[test]
    fn law_distortion_rises_below_the_suspension() {
        // Below its resonance the suspension passes the second harmonic four times better.
        let shaker = Shaker::default();
        let relative = |f: f64| {
            let m = shaker.motion(1.0, f);
            m[1].norm() / m[0].norm()
        };
        assert!(relative(2.0) / 0.004 > 3.5 && (relative(200.0) / 0.004 - 1.0).abs() < 0.05);
    }
}
