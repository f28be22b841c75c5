//! The model: oscillators, a high-pass, a delay, a low-pass.

use num_complex::Complex64;
use proofmass_core::Error;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// One oscillator of a transducer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mode {
    /// Undamped natural frequency, Hz.
    pub frequency: f64,
    /// Damping ratio ζ.
    pub damping: f64,
    /// Share of the static sensitivity; the shares of all modes sum to one.
    pub share: f64,
}

/// Which elements there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct ModelStructure {
    /// Oscillators, from none to four.
    pub modes: usize,
    /// First-order high-pass of a piezoelectric transducer and its amplifier.
    pub high_pass: bool,
    /// Delay of converter and transport.
    pub delay: bool,
    /// Order of a Butterworth low-pass, of an amplifier (1, 2) or against aliases (2 to 10).
    pub low_pass: Option<usize>,
}

impl Default for ModelStructure {
    /// ISO 16063-43: one oscillator, nothing else.
    fn default() -> Self {
        Self {
            modes: 1,
            high_pass: false,
            delay: false,
            low_pass: None,
        }
    }
}

/// As people write it: `1mode`, `1mode+delay`, `2modes+high-pass+low-pass=4`.
impl std::str::FromStr for ModelStructure {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let refused =
            format!("{text:?} is no model such as 1mode, 1mode+delay, 2modes+high-pass+low-pass=4");
        let mut model = Self::modes(0);
        for word in text.split('+').map(str::trim) {
            if let Some(count) = word
                .strip_suffix("modes")
                .or_else(|| word.strip_suffix("mode"))
            {
                let Ok(count) = count.trim().parse::<usize>() else {
                    return Err(refused);
                };
                model.modes = count;
            } else if word == "high-pass" {
                model = model.with_high_pass();
            } else if word == "delay" {
                model = model.with_delay();
            } else if let Some(Ok(order)) = word.strip_prefix("low-pass=").map(str::parse::<usize>)
            {
                model = model.with_low_pass(order);
            } else {
                return Err(refused);
            }
        }
        Ok(model)
    }
}

impl ModelStructure {
    /// Oscillators alone.
    pub fn modes(modes: usize) -> Self {
        Self {
            modes,
            ..Self::default()
        }
    }

    /// With a delay.
    #[must_use]
    pub fn with_delay(mut self) -> Self {
        self.delay = true;
        self
    }

    /// With a high-pass.
    #[must_use]
    pub fn with_high_pass(mut self) -> Self {
        self.high_pass = true;
        self
    }

    /// With a low-pass of this order.
    #[must_use]
    pub fn with_low_pass(mut self, order: usize) -> Self {
        self.low_pass = Some(order);
        self
    }

    /// Number of parameters.
    pub fn parameters(&self) -> usize {
        1 + (3 * self.modes).saturating_sub(usize::from(self.modes > 0))
            + usize::from(self.high_pass)
            + usize::from(self.delay)
            + usize::from(self.low_pass.is_some())
    }

    /// # Errors
    /// More than four modes, an order outside 1 to 10, nothing to fit.
    pub(super) fn check(&self) -> Result<(), Error> {
        if self.modes > 4 {
            return Err(Error::OutOfRange {
                name: "modes of the model",
                value: self.modes as f64,
                min: 0.0,
                max: 4.0,
            });
        }
        match self.low_pass {
            Some(order) if !(1..=10).contains(&order) => Err(Error::OutOfRange {
                name: "order of the low-pass",
                value: order as f64,
                min: 1.0,
                max: 10.0,
            }),
            _ => Ok(()),
        }
    }
}

/// A transducer with its chain.
///
/// S(f) = S₀ Σ_i σ_i/(1 − r_i² + 2jζ_i r_i) · (jf/f_h)/(1 + jf/f_h) · e^{−2πjfτ} · B_n(f/f_c), r_i = f/f_i, B_n the
/// Butterworth low-pass of order n with B_n(0) = 1.
///
/// **Source** one mode `[ISO16063-43] 4.2`.
///
/// ```
/// use proofmass_dynamic::model::{Mode, TransducerModel};
/// let device = TransducerModel {
///     modes: vec![Mode { frequency: 1000.0, damping: 0.05, share: 1.0 }],
///     ..TransducerModel::flat(0.01)
/// };
/// // At resonance −j/(2ζ).
/// let s = device.response(1000.0);
/// assert!(s.re.abs() < 1e-15 && (s.im + 0.1).abs() < 1e-15);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransducerModel {
    /// Static sensitivity, with its sign; output unit per input unit.
    pub sensitivity: f64,
    /// Oscillators.
    pub modes: Vec<Mode>,
    /// Corner of the high-pass, Hz.
    pub high_pass: Option<f64>,
    /// Delay, s.
    pub delay: f64,
    /// Order and corner (Hz) of the low-pass.
    pub low_pass: Option<(usize, f64)>,
}

impl TransducerModel {
    /// The same sensitivity at every frequency.
    pub fn flat(sensitivity: f64) -> Self {
        Self {
            sensitivity,
            modes: Vec::new(),
            high_pass: None,
            delay: 0.0,
            low_pass: None,
        }
    }

    /// S(f), f in Hz.
    pub fn response(&self, f: f64) -> Complex64 {
        let j = Complex64::i();
        let mut s = Complex64::new(self.sensitivity, 0.0);
        if !self.modes.is_empty() {
            s *= self
                .modes
                .iter()
                .map(|m| {
                    let r = f / m.frequency;
                    m.share / (1.0 - r * r + 2.0 * j * m.damping * r)
                })
                .sum::<Complex64>();
        }
        if let Some(corner) = self.high_pass {
            let r = j * f / corner;
            s *= r / (1.0 + r);
        }
        if let Some((order, corner)) = self.low_pass {
            let r = f / corner;
            for k in 0..order / 2 {
                let cosine = (PI * (2 * k + 1) as f64 / (2 * order) as f64).sin();
                s /= 1.0 - r * r + 2.0 * j * cosine * r;
            }
            if order % 2 == 1 {
                s /= 1.0 + j * r;
            }
        }
        s * Complex64::from_polar(1.0, -TAU * f * self.delay)
    }

    /// The elements it has.
    pub fn structure(&self, delay: bool) -> ModelStructure {
        ModelStructure {
            modes: self.modes.len(),
            high_pass: self.high_pass.is_some(),
            delay,
            low_pass: self.low_pass.map(|(order, _)| order),
        }
    }

    /// Parameters of order one: logarithms of what is positive, times in units of `time`.
    pub(crate) fn to_vector(&self, structure: &ModelStructure, time: f64) -> Vec<f64> {
        let mut v = vec![self.sensitivity.abs().ln()];
        for (i, m) in self.modes.iter().enumerate() {
            v.push(m.frequency.ln());
            v.push(m.damping.ln());
            if i > 0 {
                v.push(m.share);
            }
        }
        v.extend(self.high_pass.map(f64::ln));
        v.extend(structure.delay.then_some(self.delay / time));
        v.extend(self.low_pass.map(|(_, c)| c.ln()));
        v
    }

    pub(crate) fn from_vector(v: &[f64], structure: &ModelStructure, sign: f64, time: f64) -> Self {
        let mut it = v.iter().copied();
        let mut next = || it.next().unwrap_or(0.0);
        let sensitivity = sign * next().exp();
        let mut modes: Vec<Mode> = (0..structure.modes)
            .map(|i| Mode {
                frequency: next().exp(),
                damping: next().exp(),
                share: if i > 0 { next() } else { 0.0 },
            })
            .collect();
        let others: f64 = modes.iter().skip(1).map(|m| m.share).sum();
        if let Some(first) = modes.first_mut() {
            first.share = 1.0 - others;
        }
        Self {
            sensitivity,
            modes,
            high_pass: structure.high_pass.then(|| next().exp()),
            delay: if structure.delay { next() * time } else { 0.0 },
            low_pass: structure.low_pass.map(|order| (order, next().exp())),
        }
    }

    /// Dotted names, units and values of the parameters, and d(value)/d(vector).
    pub(crate) fn named(
        &self,
        structure: &ModelStructure,
        unit: &str,
        time: f64,
    ) -> Vec<(String, String, f64, f64)> {
        let mut names = vec![(
            "sensitivity".to_owned(),
            unit.to_owned(),
            self.sensitivity,
            self.sensitivity,
        )];
        let mut push = |name: String, unit: &str, value: f64, slope: f64| {
            names.push((name, unit.to_owned(), value, slope));
        };
        for (i, m) in self.modes.iter().enumerate() {
            let n = i + 1;
            push(
                format!("mode.{n}.frequency"),
                "Hz",
                m.frequency,
                m.frequency,
            );
            push(format!("mode.{n}.damping"), "1", m.damping, m.damping);
            if i > 0 {
                push(format!("mode.{n}.share"), "1", m.share, 1.0);
            }
        }
        if let Some(corner) = self.high_pass {
            push("high_pass.corner".into(), "Hz", corner, corner);
        }
        if structure.delay {
            push("delay".into(), "s", self.delay, time);
        }
        if let Some((_, corner)) = self.low_pass {
            push("low_pass.corner".into(), "Hz", corner, corner);
        }
        names
    }
}
