//! The drive: a sine whose amplitude changes slowly.

use std::f64::consts::TAU;

/// A sine on the clock of the device. Its amplitude goes towards the one wanted along a straight line.
#[derive(Clone, Debug)]
pub struct Tone {
    frequency: f64,
    rate: f64,
    /// Samples since the tone began: the phase is taken from it, so that it is exact for hours.
    sample: u64,
    amplitude: f64,
    wanted: f64,
    /// Largest change of the amplitude per sample, V.
    step: f64,
}

impl Tone {
    /// A silent tone at a frequency and a sampling rate, Hz.
    pub fn new(frequency: f64, rate: f64) -> Self {
        Self {
            frequency,
            rate,
            sample: 0,
            amplitude: 0.0,
            wanted: 0.0,
            step: 0.0,
        }
    }

    /// Sampling rate in Hz.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Amplitude now, V.
    pub fn amplitude(&self) -> f64 {
        self.amplitude
    }

    /// Whether the amplitude is the one wanted.
    pub fn steady(&self) -> bool {
        self.amplitude == self.wanted
    }

    /// Goes to another amplitude in V within some seconds.
    pub fn go_to(&mut self, wanted: f64, seconds: f64) {
        self.wanted = wanted;
        self.step = (wanted - self.amplitude).abs() / (seconds * self.rate).max(1.0);
    }

    /// Goes to zero within this number of samples.
    pub fn fade(&mut self, samples: usize) {
        self.go_to(0.0, samples as f64 / self.rate);
    }

    /// The next samples of the drive.
    pub fn fill(&mut self, drive: &mut [f64]) {
        let turns = self.frequency / self.rate;
        for v in drive {
            let way = self.wanted - self.amplitude;
            self.amplitude = match way.abs() <= self.step * (1.0 + 1e-9) {
                true => self.wanted,
                false => self.amplitude + self.step.copysign(way),
            };
            *v = self.amplitude * (TAU * (turns * self.sample as f64).fract()).sin();
            self.sample += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_the_amplitude_is_reached_in_time_and_fades_within_a_block() {
        let mut tone = Tone::new(100.0, 10_000.0);
        let mut block = [0.0; 400];
        tone.go_to(2.0, 0.08);
        tone.fill(&mut block);
        assert!((tone.amplitude() - 1.0).abs() < 1e-9 && !tone.steady());
        tone.fill(&mut block);
        assert!(tone.steady() && tone.amplitude() == 2.0);
        tone.fade(block.len());
        tone.fill(&mut block);
        assert!(tone.amplitude() == 0.0 && block[399] == 0.0);
        // No sample is further from the one before than the sine and the slope allow.
        let steepest = block.windows(2).map(|w| (w[1] - w[0]).abs());
        assert!(steepest.fold(0.0, f64::max) < 2.0 * TAU * 100.0 / 10_000.0 + 2.0 / 400.0);
    }
}
