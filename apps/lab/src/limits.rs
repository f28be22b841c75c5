//! What the bench may do, checked before the first sample leaves and at every block.

use std::f64::consts::TAU;

/// Largest drive and motion of a bench.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest drive, V.
    pub drive: f64,
    /// Largest change of the amplitude of the drive, V/s.
    pub drive_rate: f64,
    /// Largest acceleration, m/s².
    pub acceleration: f64,
    /// Largest velocity, m/s, where one is stated.
    pub velocity: Option<f64>,
    /// Largest displacement to one side, m, where one is stated.
    pub displacement: Option<f64>,
}

/// By how much an amplitude may exceed the level wanted, while the level is sought.
const ABOVE: f64 = 1.25;

impl Limits {
    /// Largest acceleration at a frequency in Hz, by all limits of motion, and which one it is.
    pub fn acceleration_at(&self, frequency: f64) -> (f64, &'static str) {
        let omega = TAU * frequency;
        let mut least = (self.acceleration, "acceleration");
        for (limit, name) in [
            (self.velocity.map(|v| v * omega), "velocity"),
            (self.displacement.map(|d| d * omega * omega), "displacement"),
        ] {
            if let Some(a) = limit.filter(|a| *a < least.0) {
                least = (a, name);
            }
        }
        least
    }

    /// Acceleration at which a run at this level ends: a quarter above it, or the limit of the bench.
    pub fn trip(&self, frequency: f64, target: f64) -> f64 {
        self.acceleration_at(frequency).0.min(ABOVE * target)
    }

    /// Refuses a level before any drive leaves.
    ///
    /// # Errors
    /// What is beyond which limit, and what to do.
    pub fn check(&self, frequency: f64, target: f64) -> Result<(), String> {
        let (most, which) = self.acceleration_at(frequency);
        match target <= most {
            true => Ok(()),
            false => Err(format!(
                "{target} m/s² at {frequency} Hz is above the limit of {which}, which allows {most:.4} m/s²: lower the target in the plan, or state the true limit in [shaker]"
            )),
        }
    }

    /// Shortest time in s in which the drive may change by this much, V.
    pub fn slope_seconds(&self, change: f64) -> f64 {
        change.abs() / self.drive_rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_limits_of_motion() {
        let limits = Limits {
            drive: 5.0,
            drive_rate: 10.0,
            acceleration: 100.0,
            velocity: Some(0.5),
            displacement: Some(5e-3),
        };
        // ω² d at 5 Hz, ω v at 20 Hz, a itself at 1 kHz.
        assert!((limits.acceleration_at(5.0).0 - 4.934_802).abs() < 1e-5);
        assert_eq!(limits.acceleration_at(5.0).1, "displacement");
        assert_eq!(limits.acceleration_at(20.0).1, "velocity");
        assert_eq!(limits.acceleration_at(1000.0), (100.0, "acceleration"));
        assert!(limits.check(5.0, 3.0).is_ok());
        let refused = limits.check(5.0, 10.0).unwrap_err();
        assert!(refused.contains("displacement") && refused.contains("4.9348"));
        assert_eq!(limits.slope_seconds(-5.0), 0.5);
    }
}
