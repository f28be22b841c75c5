//! Still windows of a stream that is never held.

use crate::Triple;
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// Which windows count as still.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WindowRule {
    /// Length of a window, s.
    pub duration: f64,
    /// Largest standard deviation of each axis, g.
    pub deviation: f64,
    /// Largest magnitude of each mean, g.
    pub magnitude: f64,
    /// A window with a pause longer than this in it is no window, s: a logger that slept may have been moved.
    pub pause: f64,
}

impl Default for WindowRule {
    /// Ten seconds, 13 mg, 2 g. **Source** `[vanHees2014]`.
    fn default() -> Self {
        Self {
            duration: 10.0,
            deviation: 0.013,
            magnitude: 2.0,
            pause: 1.0,
        }
    }
}

/// One still window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StillWindow {
    /// Middle of the window, s.
    pub time: f64,
    /// Mean outputs, g.
    pub mean: Triple,
    /// Mean temperature, °C, where it was recorded.
    pub temperature: Option<f64>,
}

/// Collects the still windows of a stream of samples: memory for the windows, none for the samples.
///
/// Samples that are exactly zero on all three axes are what a logger fills its pauses with: they are no samples. So are windows
/// whose samples on all three axes are one value, or lie on a straight line: the last value repeated, or a gap interpolated.
#[derive(Clone, Debug)]
pub struct StillWindows {
    rule: WindowRule,
    still: Vec<StillWindow>,
    windows: usize,
    filled: usize,
    current: Sums,
}

#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    start: f64,
    last: f64,
    count: f64,
    pedestal: Triple,
    sum: Triple,
    square: Triple,
    /// Σ i v over the samples i of the window.
    moment: Triple,
    temperature: f64,
    temperatures: f64,
}

impl Sums {
    /// Whether the samples of every axis lie on a straight line.
    fn is_filled(&self) -> bool {
        let n = self.count;
        let spread = n * (n * n - 1.0) / 12.0;
        (0..3).all(|axis| {
            let square = self.square[axis] - self.sum[axis].powi(2) / n;
            let slope = self.moment[axis] - 0.5 * (n - 1.0) * self.sum[axis];
            // Sums of squares of up to 1 g lose a few units in the last place.
            let rounding = 1e-13 * self.square[axis];
            square - slope * slope / spread <= n * FILLED * FILLED + rounding
        })
    }
}

/// Standard deviation about a straight line below which no sensor made the samples, g: a thousandth of the quietest.
const FILLED: f64 = 1e-7;

/// Fewest samples of a window: below, its standard deviation tells nothing.
const FEWEST: f64 = 10.0;

impl StillWindows {
    /// Nothing yet.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a limit that is not positive.
    pub fn new(rule: WindowRule) -> Result<Self, Error> {
        for (name, value) in [
            ("duration of a window", rule.duration),
            ("standard deviation of a still window", rule.deviation),
            ("magnitude of a still window", rule.magnitude),
            ("pause in a window", rule.pause),
        ] {
            proofmass_core::check::positive(name, value)?;
        }
        Ok(Self {
            rule,
            still: Vec::new(),
            windows: 0,
            filled: 0,
            current: Sums::default(),
        })
    }

    /// Takes the next sample: time in s, outputs in g, temperature in °C.
    pub fn push(&mut self, time: f64, output: Triple, temperature: Option<f64>) {
        if output == [0.0; 3] || !time.is_finite() || output.iter().any(|v| !v.is_finite()) {
            return;
        }
        let sums = &mut self.current;
        if sums.count > 0.0 {
            let step = time - sums.last;
            if step > self.rule.pause || step < 0.0 {
                *sums = Sums::default();
            } else if time - sums.start >= self.rule.duration {
                self.close();
            }
        }
        let sums = &mut self.current;
        if sums.count == 0.0 {
            sums.start = time;
            sums.pedestal = output;
        }
        sums.last = time;
        sums.count += 1.0;
        for axis in 0..3 {
            let v = output[axis] - sums.pedestal[axis];
            sums.sum[axis] += v;
            sums.square[axis] += v * v;
            sums.moment[axis] += (sums.count - 1.0) * v;
        }
        if let Some(temperature) = temperature.filter(|t| t.is_finite()) {
            sums.temperature += temperature;
            sums.temperatures += 1.0;
        }
    }

    fn close(&mut self) {
        let sums = std::mem::take(&mut self.current);
        if sums.count < FEWEST {
            return;
        }
        self.windows += 1;
        let n = sums.count;
        if sums.is_filled() {
            self.filled += 1;
            return;
        }
        let mut mean = [0.0; 3];
        for axis in 0..3 {
            mean[axis] = sums.pedestal[axis] + sums.sum[axis] / n;
            let variance = (sums.square[axis] - sums.sum[axis].powi(2) / n).max(0.0) / (n - 1.0);
            if variance.sqrt() >= self.rule.deviation || mean[axis].abs() >= self.rule.magnitude {
                return;
            }
        }
        self.still.push(StillWindow {
            time: sums.start + 0.5 * self.rule.duration,
            mean,
            temperature: (sums.temperatures > 0.0).then(|| sums.temperature / sums.temperatures),
        });
    }

    /// Windows seen so far, still or not.
    pub fn seen(&self) -> usize {
        self.windows
    }

    /// Windows that a logger or a converter filled: one value or a straight line on all axes.
    pub fn filled(&self) -> usize {
        self.filled
    }

    /// The still windows; a last window that is not full does not count.
    pub fn finish(self) -> Vec<StillWindow> {
        self.still
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An hour of sleep, filled with the last value, with zeros, or by a straight line between both ends, beside ten still windows.
    #[test]
    fn law_sleep_is_no_stillness_however_it_is_filled() {
        type Fill = fn(f64) -> Triple;
        let fills: [(&str, Fill); 3] = [
            ("repeats", |_| [0.6, 0.8, 0.0]),
            ("zeros", |_| [0.0; 3]),
            ("line", |share| [0.6 - 0.6 * share, 0.8, share]),
        ];
        for (name, fill) in fills {
            let mut windows = StillWindows::new(WindowRule::default()).unwrap();
            for i in 0..(3700 * 20) {
                let time = f64::from(i) / 20.0;
                let noise = [3e-3, -1e-3, -2e-3, 1e-3, -1e-3][i as usize % 5];
                let output = match time {
                    t if t < 3600.0 => fill(t / 3600.0),
                    _ => [0.6 + noise, 0.8 - noise, noise],
                };
                windows.push(time, output, None);
            }
            let filled = windows.filled();
            assert_eq!(filled, if name == "zeros" { 0 } else { 360 }, "{name}");
            assert!((9..=10).contains(&windows.finish().len()), "{name}");
        }
    }

    #[test]
    fn known_windows_of_a_stream() {
        let mut windows = StillWindows::new(WindowRule::default()).unwrap();
        let mut push = |from: f64, to: f64, shake: f64| {
            let n = ((to - from) * 50.0) as usize;
            for i in 0..n {
                let s = if i % 2 == 0 { shake } else { -shake };
                windows.push(from + i as f64 / 50.0, [0.6 + s, 0.8, 0.0], Some(25.0));
            }
        };
        push(0.0, 20.0, 0.001); // Two still windows.
        push(20.0, 30.1, 0.1); // One that is not.
        push(40.0, 45.0, 0.001); // After a pause, not full …
        push(60.0, 71.0, 0.001); // … and one still window after another.
        assert_eq!(windows.seen(), 4);
        let still = windows.finish();
        assert_eq!(still.len(), 3);
        assert!((still[0].mean[0] - 0.6).abs() < 1e-12 && still[0].temperature == Some(25.0));
        assert!((still[2].time - 65.0).abs() < 1e-9);
    }
}
