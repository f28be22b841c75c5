//! Hall sensors of a motor: six sectors of an electrical turn, and their true widths.

use crate::{Error, Float};

/// Where three Hall sensors stand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HallSpacing {
    /// 120° electrical: levels (U, V, W) run 101, 100, 110, 010, 011, 001; all alike are illegal.
    #[default]
    Wide,
    /// 60° electrical: levels run 000, 100, 110, 111, 011, 001; 010 and 101 are illegal.
    Narrow,
}

impl HallSpacing {
    /// Sector 0…5 of these levels; `None` for levels that no rotor makes.
    pub fn sector(self, u: bool, v: bool, w: bool) -> Option<u8> {
        let levels = u8::from(u) << 2 | u8::from(v) << 1 | u8::from(w);
        match (self, levels) {
            (Self::Wide, 0b101) | (Self::Narrow, 0b000) => Some(0),
            (_, 0b100) => Some(1),
            (_, 0b110) => Some(2),
            (Self::Wide, 0b010) | (Self::Narrow, 0b111) => Some(3),
            (_, 0b011) => Some(4),
            (_, 0b001) => Some(5),
            _ => None,
        }
    }
}

/// Decoder of three Hall sensors: sectors of 60° electrical, counted in both senses.
///
/// A step over two sectors has a sense and is counted; one over three has none, and levels that no rotor makes (a broken wire, a
/// glitch) say nothing: both are left uncounted and told. With p pole pairs a sector is an increment of π/(3p) of the
/// shaft: [`Counter`](crate::velocity::Counter), M/T and the estimators take the count as that of an encoder.
///
/// ```
/// use proofmass_core::encoder::{Hall, HallSpacing};
/// let mut hall = Hall::new(HallSpacing::Wide);
/// for levels in [[true, false, true], [true, false, false], [true, true, false]] { hall.update(levels); }
/// assert_eq!((hall.count(), hall.sector()), (2, Some(2)));
/// assert_eq!(hall.update([true, true, true]), None); // no rotor does that
/// assert_eq!(hall.illegal(), 1);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hall {
    spacing: HallSpacing,
    sector: Option<u8>,
    count: i32,
    illegal: u32,
}

impl Hall {
    /// Starts at count zero in the sector of the first legal levels.
    pub fn new(spacing: HallSpacing) -> Self {
        Self {
            spacing,
            sector: None,
            count: 0,
            illegal: 0,
        }
    }

    /// Takes the levels U, V, W; returns the step of the count, or `None` for one that cannot be told.
    pub fn update(&mut self, [u, v, w]: [bool; 3]) -> Option<i32> {
        let Some(to) = self.spacing.sector(u, v, w) else {
            self.illegal = self.illegal.saturating_add(1);
            return None;
        };
        let from = self.sector.replace(to).unwrap_or(to);
        let step = match (6 + to - from) % 6 {
            0 => 0,
            1 => 1,
            2 => 2,
            4 => -2,
            5 => -1,
            _ => {
                self.illegal = self.illegal.saturating_add(1);
                return None;
            }
        };
        self.count = self.count.wrapping_add(step);
        Some(step)
    }

    /// Sectors since the start, modulo 2³².
    pub fn count(&self) -> i32 {
        self.count
    }

    /// The sector of the last legal levels.
    pub fn sector(&self) -> Option<u8> {
        self.sector
    }

    /// Levels and steps that could not be, since the start.
    pub fn illegal(&self) -> u32 {
        self.illegal
    }
}

/// True widths of the six sectors, learnt while the motor runs evenly.
///
/// Sensors stand off by some degrees, so that a velocity from one sector repeats with the turn. At an even speed a sector's
/// share of the time of the turn around it is its share of the turn. Shares are taken of whole turns alone that lasted as long as the
/// one before, to the tolerance; each moves the widths by a fraction of what differs. What a speed that changes by the
/// tolerance over a turn does to a width is at most half of the tolerance of it.
///
/// **Memory** 17 numbers. **Delay** of the velocity half a sector.
///
/// ```
/// use proofmass_core::encoder::HallSectors;
/// let mut sectors = HallSectors::<f32>::new(0.2, 0.02)?;
/// // A sensor that stands off by 4°: the first two sectors are 64° and 56°, at one degree a millisecond.
/// for turn in 0..40 {
///     for (k, ms) in [64.0, 56.0, 60.0, 60.0, 60.0, 60.0].into_iter().enumerate() {
///         sectors.passed(k as u8, ms * 1e-3, true);
///     }
/// }
/// // Electrical degrees per second, of the longest sector.
/// let v = sectors.velocity(0, 64e-3).to_degrees();
/// assert!((v - 1000.0).abs() < 1.0, "{v}");
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HallSectors<T> {
    /// Electrical rad.
    width: [T; 6],
    /// Times of the last six sectors, s.
    time: [T; 6],
    /// Sectors that were passed in one sense and order.
    passed: u8,
    last: Option<(u8, bool)>,
    /// Time of the turn before.
    before: T,
    fraction: T,
    tolerance: T,
}

impl<T: Float> HallSectors<T> {
    /// Even widths; each turn moves them by `fraction` of what differs, where it lasted as long as the one before to `tolerance`
    /// (relative).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a fraction or tolerance that is not positive, or above one.
    pub fn new(fraction: f64, tolerance: f64) -> Result<Self, Error> {
        for (name, value) in [("fraction", fraction), ("tolerance", tolerance)] {
            if !(value > 0.0 && value <= 1.0) {
                return Err(Error::OutOfRange {
                    name,
                    value,
                    min: 0.0,
                    max: 1.0,
                });
            }
        }
        Ok(Self {
            width: [T::from_f64(core::f64::consts::FRAC_PI_3); 6],
            time: [T::ZERO; 6],
            passed: 0,
            last: None,
            before: T::ZERO,
            fraction: T::from_f64(fraction),
            tolerance: T::from_f64(tolerance),
        })
    }

    /// A sector 0…5 was crossed from edge to edge in this time, s. Anything but the next sector in the same sense begins anew.
    pub fn passed(&mut self, sector: u8, time: T, forward: bool) {
        if sector > 5 || !time.is_finite() || time <= T::ZERO {
            self.forget();
            return;
        }
        let next = |from: u8| {
            if forward {
                (from + 1) % 6
            } else {
                (from + 5) % 6
            }
        };
        if self
            .last
            .is_none_or(|(from, sense)| sense != forward || next(from) != sector)
        {
            self.forget();
        }
        self.last = Some((sector, forward));
        self.time[usize::from(sector)] = time;
        self.passed += 1;
        if self.passed < 6 {
            return;
        }
        self.passed = 0;
        let mut turn = T::ZERO;
        for t in self.time {
            turn += t;
        }
        let even = (turn - self.before).abs() <= self.tolerance * turn;
        self.before = turn;
        if !even {
            return;
        }
        let scale = T::from_f64(core::f64::consts::TAU) / turn;
        for (width, time) in self.width.iter_mut().zip(self.time) {
            *width += self.fraction * (scale * time - *width);
        }
    }

    fn forget(&mut self) {
        self.passed = 0;
        self.last = None;
        self.before = T::ZERO;
    }

    /// Electrical angular speed, rad/s, over a sector that was crossed in this time; zero for no time.
    pub fn velocity(&self, sector: u8, time: T) -> T {
        match self.width.get(usize::from(sector)) {
            Some(&width) if time > T::ZERO => width / time,
            _ => T::ZERO,
        }
    }

    /// Widths of the sectors, electrical rad; they add up to a turn.
    pub fn widths(&self) -> [T; 6] {
        self.width
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDE: [[bool; 3]; 6] = [
        [true, false, true],
        [true, false, false],
        [true, true, false],
        [false, true, false],
        [false, true, true],
        [false, false, true],
    ];

    /// The levels of three sensors 120° (or 60°) apart, each high for half a turn.
    #[test]
    fn law_sectors_are_those_of_three_sensors() {
        for (spacing, apart) in [(HallSpacing::Wide, 120.0), (HallSpacing::Narrow, 60.0)] {
            let mut hall = Hall::new(spacing);
            let mut last = None;
            for tenth in 0..72_000 {
                let degrees = f64::from(tenth) * 0.1 + 0.05;
                let high = |at: f64| (degrees - at).rem_euclid(360.0) < 180.0;
                let step = hall.update([high(0.0), high(apart), high(2.0 * apart)]);
                assert!(
                    matches!(step, Some(0 | 1)),
                    "{spacing:?} {degrees}: {step:?}"
                );
                last = hall.sector();
            }
            assert!(last.is_some() && hall.illegal() == 0);
            // Twenty turns of six.
            assert!((119..=120).contains(&hall.count()), "{}", hall.count());
        }
    }

    #[test]
    fn known_senses_skips_and_faults() {
        let mut hall = Hall::new(HallSpacing::Wide);
        for k in (0..60).rev() {
            hall.update(WIDE[k % 6]);
        }
        assert_eq!(hall.count(), -59);
        // Two sectors at once have a sense, three have none.
        let at = usize::from(hall.sector().unwrap());
        assert_eq!(hall.update(WIDE[(at + 2) % 6]), Some(2));
        assert_eq!(hall.update(WIDE[(at + 5) % 6]), None);
        assert_eq!((hall.count(), hall.illegal()), (-57, 1));
        // A glitch leaves the sector.
        assert_eq!(hall.update([false; 3]), None);
        assert_eq!(hall.update(WIDE[(at + 5) % 6]), Some(0));
    }

    /// Sensors off by up to 5°, a speed that wanders: the velocity of single sectors errs by 8 % before and 0.5 % after.
    #[test]
    fn known_widths_are_learnt_and_the_ripple_goes() {
        let truth = [63.0f64, 55.0, 60.0, 65.0, 57.0, 60.0];
        let mut sectors = HallSectors::<f32>::new(0.1, 0.02).unwrap();
        let mut t = 0.0f64;
        let mut worst = [0.0f64; 2];
        for turn in 0..600 {
            for (k, degrees) in truth.iter().enumerate() {
                // 5 Hz of mechanical speed, wandering by 1 % over some hundred turns.
                let speed = 1800.0 * (1.0 + 0.01 * (0.05 * t).sin());
                let time = degrees / speed;
                t += time;
                let off =
                    f64::from(sectors.velocity(k as u8, time as f32)).to_degrees() / speed - 1.0;
                let phase = usize::from(turn >= 300);
                if !(1..300).contains(&turn) {
                    worst[phase] = worst[phase].max(off.abs());
                }
                sectors.passed(k as u8, time as f32, true);
            }
        }
        assert!(worst[0] > 0.08 && worst[1] < 0.005, "{worst:?}");
        let sum: f32 = sectors.widths().iter().sum();
        assert!((sum - core::f32::consts::TAU).abs() < 1e-5);
        // Backwards the same sectors are met in the other order.
        let before = sectors.widths();
        for _ in 0..20 {
            for k in (0..6u8).rev() {
                let time = truth[usize::from(k)] / 1800.0;
                sectors.passed(k, time as f32, false);
            }
        }
        for (a, b) in before.iter().zip(sectors.widths()) {
            assert!((a - b).abs() < 2e-4);
        }
    }

    #[test]
    fn known_uneven_turns_and_wrong_orders_teach_nothing() {
        let even = HallSectors::<f64>::new(0.5, 0.02).unwrap();
        let mut sectors = even;
        // A start: every turn half as long as the one before.
        let mut time = 1.0;
        for _ in 0..10 {
            for k in 0..6u8 {
                sectors.passed(k, time, true);
                time *= 0.9;
            }
        }
        // To and fro, with a sector left out, with times that are none.
        for (k, t, forward) in [
            (0, 1.0, true),
            (1, 1.0, true),
            (1, 1.0, false),
            (3, 1.0, true),
            (9, 1.0, true),
            (2, f64::NAN, true),
            (2, -1.0, true),
        ]
        .into_iter()
        .cycle()
        .take(100)
        {
            sectors.passed(k, t, forward);
        }
        assert_eq!(sectors.widths(), even.widths());
        assert!(HallSectors::<f64>::new(0.0, 0.02).is_err());
        assert_eq!(even.velocity(7, 1.0), 0.0);
        assert_eq!(even.velocity(0, 0.0), 0.0);
    }
}
