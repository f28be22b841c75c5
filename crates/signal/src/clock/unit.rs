//! The unit of which all steps between stamps are multiples.

/// Decimals of a second that are told apart.
const DECIMALS: i32 = 12;

#[derive(Debug)]
pub(super) struct CommonUnit {
    /// Last digit, s, and whether it was stated.
    digit: f64,
    stated: bool,
    decimals: i32,
    /// Largest common unit of the steps, in digits.
    common: u64,
    /// The last two different steps, s.
    recent: [f64; 2],
    different: bool,
    repeats: bool,
}

impl Default for CommonUnit {
    fn default() -> Self {
        Self {
            digit: 1.0,
            stated: false,
            decimals: 0,
            common: 0,
            recent: [0.0; 2],
            different: false,
            repeats: false,
        }
    }
}

impl CommonUnit {
    pub(super) fn state(&mut self, digit: f64) {
        if !self.stated || digit < self.digit {
            self.refine(digit);
            self.stated = true;
        }
    }

    fn refine(&mut self, digit: f64) {
        self.common = (self.common as f64 * self.digit / digit).round() as u64;
        self.digit = digit;
    }

    /// A stamp since the first one, its step, and how far from zero it was.
    pub(super) fn add(&mut self, since: f64, step: f64, far: f64) {
        if step == 0.0 {
            self.repeats = true;
            return;
        }
        if self.recent.contains(&step) {
            return;
        }
        self.different |=
            self.recent[0] != 0.0 && (step - self.recent[0]).abs() > 1e-9 * step.abs();
        self.recent = [step, self.recent[0]];
        if !self.stated {
            // Stamps of an absolute clock have no finer digits than the double they are held in.
            let coarse = 8.0 * f64::EPSILON * far.max(since.abs());
            while self.decimals < DECIMALS {
                let off = |t: f64| (t / self.digit - (t / self.digit).round()).abs() * self.digit;
                if off(since).max(off(step)) <= 1e-6 * self.digit + coarse {
                    break;
                }
                self.decimals += 1;
                self.refine(10_f64.powi(-self.decimals));
            }
        }
        if self.common != 1 {
            self.common = gcd((step.abs() / self.digit).round() as u64, self.common);
        }
    }

    /// The unit by the steps alone; the last digit where they are all alike.
    pub(super) fn common(&self) -> f64 {
        if (self.different || self.repeats) && self.common > 0 {
            self.common as f64 * self.digit
        } else {
            self.digit
        }
    }

    /// The unit beside an interval: whole intervals tell nothing about it.
    pub(super) fn of(&self, interval: f64, grid: bool) -> f64 {
        let common = self.common();
        if grid && common > 0.99 * interval {
            self.digit
        } else {
            common
        }
    }
}

fn gcd(mut a: u64, mut b: u64) -> u64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}
