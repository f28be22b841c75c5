//! Level control at the reference: the drive is changed in steps, each when the amplitude has come to rest.
//!
//! The amplitude is the three-parameter fit over whole periods. Below 60 % of the level the next step aims at 70 % of it
//! and is at most fourfold, so that a resonance that overshoots has room; from there it aims at the level.

use crate::ending::Ending;
use crate::limits::Limits;
use crate::tone::Tone;
use num_complex::Complex64;
use proofmass::signal::sine::three_parameter_fit;
use std::collections::VecDeque;
use std::f64::consts::TAU;

/// Departure from the level within which it is settled, and beyond which a recording is lost, relative.
pub const SETTLED: f64 = 0.01;
const LOST: f64 = 0.03;
/// Change from window to window below which an amplitude is at rest, relative.
const REST: f64 = 0.003;
/// Largest step of the drive, and while the reference shows nothing.
const STEP: f64 = 4.0;
const BLIND: f64 = 2.0;
/// Share of the largest drive up to which a signal must have shown.
const SHOWN: f64 = 0.1;
/// Standard deviations of its amplitude from which on a signal is one.
const SIGNAL: f64 = 8.0;
/// Time of rise of a resonance of this quality is waited for.
const QUALITY: f64 = 60.0;

/// Amplitude over one window.
#[derive(Clone, Copy, Debug)]
struct Reading {
    /// Phasor of the reference in V, against the clock of the tone.
    phasor: Complex64,
    offset: f64,
    /// Standard deviation of the amplitude by the residuals, V.
    noise: f64,
}

/// What the control makes of a block.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// The level is sought.
    Seeking,
    /// The level holds.
    Settled,
    /// The run ends.
    Failed(Ending),
}

/// The control of one run.
pub struct Level {
    frequency: f64,
    rate: f64,
    /// Acceleration wanted, m/s², and volts of the reference for it.
    target: f64,
    sensitivity: f64,
    limits: Limits,
    window: usize,
    buffer: VecDeque<f64>,
    /// Samples of the run so far, and since the drive came to rest.
    samples: u64,
    rested: usize,
    /// Samples at this drive, for the longest wait.
    held: usize,
    last: Option<Reading>,
    steady: Option<Reading>,
    good: usize,
    settled: bool,
}

impl Level {
    /// A control for a frequency in Hz and a level in m/s², by a reference of this sensitivity, V/(m/s²).
    pub fn new(
        (frequency, rate): (f64, f64),
        target: f64,
        sensitivity: f64,
        limits: Limits,
    ) -> Self {
        let periods = (0.1 * frequency).ceil().max(2.0);
        Self {
            frequency,
            rate,
            target,
            sensitivity,
            limits,
            window: (periods * rate / frequency).round() as usize,
            buffer: VecDeque::new(),
            samples: 0,
            rested: 0,
            held: 0,
            last: None,
            steady: None,
            good: 0,
            settled: false,
        }
    }

    /// Begins with the smallest drive.
    pub fn begin(&self, tone: &mut Tone) {
        let first = (0.002 * self.limits.drive).min(0.02);
        self.drive(tone, first);
    }

    /// Amplitude of the last window in m/s².
    pub fn acceleration(&self) -> Option<f64> {
        self.last.map(|r| r.phasor.norm() / self.sensitivity)
    }

    fn drive(&self, tone: &mut Tone, wanted: f64) {
        let wanted = wanted.min(self.limits.drive);
        let slope = self.limits.slope_seconds(wanted - tone.amplitude());
        tone.go_to(wanted, slope.max(self.window as f64 / self.rate));
    }

    /// Takes the reference of a block in V; `tone` had been steady or not while it was made.
    pub fn take(&mut self, reference: &[f64], tone: &mut Tone) -> Verdict {
        if let Some(ending) = self.sudden(reference) {
            return Verdict::Failed(ending);
        }
        self.buffer.extend(reference);
        let surplus = self.buffer.len().saturating_sub(self.window);
        self.buffer.drain(..surplus);
        self.samples += reference.len() as u64;
        if !tone.steady() {
            self.rested = 0;
            return Verdict::Seeking;
        }
        self.rested += reference.len();
        self.held += reference.len();
        if self.rested < self.window || self.buffer.len() < self.window {
            return self.standing();
        }
        self.rested = 0;
        let Some(reading) = self.read() else {
            return Verdict::Failed(Ending::ReferenceLost);
        };
        let before = self.last.replace(reading);
        self.decide(before, reading, tone)
    }

    fn standing(&self) -> Verdict {
        match self.settled {
            true => Verdict::Settled,
            false => Verdict::Seeking,
        }
    }

    fn read(&self) -> Option<Reading> {
        let samples: Vec<f64> = self.buffer.iter().copied().collect();
        let fit = three_parameter_fit(&samples, self.rate, self.frequency).ok()?;
        let first = self.samples - samples.len() as u64;
        let turns = (self.frequency / self.rate * first as f64).fract();
        Some(Reading {
            phasor: fit.amplitude * Complex64::from_polar(1.0, -TAU * turns),
            offset: fit.offset,
            noise: fit.residual_rms * (2.0 / samples.len() as f64).sqrt(),
        })
    }

    fn decide(&mut self, before: Option<Reading>, now: Reading, tone: &mut Tone) -> Verdict {
        let amplitude = now.phasor.norm();
        if amplitude < SIGNAL * now.noise || amplitude == 0.0 {
            let seen = self.settled || self.steady.is_some();
            if seen || tone.amplitude() >= SHOWN * self.limits.drive {
                return Verdict::Failed(Ending::ReferenceLost);
            }
            self.step(tone, BLIND);
            return Verdict::Seeking;
        }
        let share = amplitude / (self.sensitivity * self.target);
        let change = before.map_or(1.0, |b| (now.phasor - b.phasor).norm() / amplitude);
        if change < 0.1 {
            self.steady = Some(now);
        }
        if self.settled {
            return match (share - 1.0).abs() > LOST {
                true => Verdict::Failed(Ending::LevelLost { by: share - 1.0 }),
                false => Verdict::Settled,
            };
        }
        let slowest = QUALITY / (std::f64::consts::PI * self.frequency) * 6.0;
        let patience = self.held as f64 / self.rate > slowest;
        let before = before.map(|b| b.phasor.norm());
        let at_rest = before.is_some_and(|b| (amplitude / b - 1.0).abs() < REST);
        if !(at_rest || patience) {
            self.good = 0;
            return Verdict::Seeking;
        }
        if (share - 1.0).abs() <= 0.6 * SETTLED {
            self.good += 1;
            self.settled = self.good >= 2;
            return self.standing();
        }
        self.good = 0;
        if tone.amplitude() >= self.limits.drive && share < 1.0 {
            return Verdict::Failed(Ending::NotReached {
                reached: share * self.target,
                wanted: self.target,
                why: "the drive is at its limit; look at the power amplifier and its gain",
            });
        }
        let wanted = if share < 0.6 { 0.7 } else { 1.0 };
        self.step(tone, (wanted / share).clamp(1.0 / STEP, STEP));
        Verdict::Seeking
    }

    fn step(&mut self, tone: &mut Tone, factor: f64) {
        self.drive(tone, tone.amplitude() * factor);
        (self.last, self.steady) = (None, None);
        (self.rested, self.held, self.good) = (0, 0, 0);
    }

    /// A steady reference goes on as it went: a cable that came off or a sign that changed shows in one block.
    fn sudden(&self, reference: &[f64]) -> Option<Ending> {
        let steady = self.steady?;
        if steady.phasor.norm() < 3.0 * SIGNAL * steady.noise {
            return None;
        }
        let turns = self.frequency / self.rate;
        let (mut of_both, mut of_expected) = (0.0, 0.0);
        for (i, v) in reference.iter().enumerate() {
            let angle = TAU * (turns * (self.samples + i as u64) as f64).fract();
            let expected = (steady.phasor * Complex64::from_polar(1.0, angle)).re;
            of_both += expected * (v - steady.offset);
            of_expected += expected * expected;
        }
        // Near its zero a slow sine says nothing.
        if of_expected < 0.02 * reference.len() as f64 * steady.phasor.norm_sqr() {
            return None;
        }
        match of_both / of_expected {
            share if share < -0.3 => Some(Ending::Reversed),
            share if share < 0.3 => Some(Ending::ReferenceLost),
            _ => None,
        }
    }
}
