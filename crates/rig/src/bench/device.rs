//! The device under test and the wedge under it.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// A triaxial accelerometer: a seismic resonance per axis, a high-pass corner, and cross terms.
#[derive(Clone, Debug, PartialEq)]
pub struct BenchDevice {
    /// Main sensitivities far below resonance, V/(m/s²).
    pub main: [f64; 3],
    /// Cross terms relative to the main sensitivity of the output they appear on: `cross[i][j]` is the output j
    /// per unit acceleration along i ≠ j.
    pub cross: [[f64; 3]; 3],
    /// Mounted resonance of each output in Hz.
    pub resonance: [f64; 3],
    /// Quality factor of the resonance.
    pub quality: f64,
    /// Low corner frequency in Hz of the charge amplifier; zero for none.
    pub corner: f64,
}

impl Default for BenchDevice {
    /// Ten millivolts per m/s², cross terms of ±3 %, resonances near 3 kHz, a corner at 0.7 Hz.
    fn default() -> Self {
        Self {
            main: [10.4e-3, 10.2e-3, 10.6e-3],
            cross: [[0.0, 0.03, -0.03], [-0.03, 0.0, 0.03], [0.03, -0.03, 0.0]],
            resonance: [2.8e3, 3.1e3, 3.6e3],
            quality: 25.0,
            corner: 0.7,
        }
    }
}

impl BenchDevice {
    /// True S at a frequency in Hz, o = a S, V/(m/s²), complex.
    pub fn sensitivity(&self, frequency: f64) -> [[Complex64; 3]; 3] {
        let j = Complex64::new(0.0, 1.0);
        std::array::from_fn(|i| {
            std::array::from_fn(|k| {
                let x = frequency / self.resonance[k];
                let resonance = Complex64::new(1.0 - x * x, x / self.quality).inv();
                let highpass = (Complex64::new(1.0, 0.0) - j * (self.corner / frequency)).inv();
                let relative = if i == k { 1.0 } else { self.cross[i][k] };
                resonance * highpass * (relative * self.main[k])
            })
        })
    }
}

/// Motion of a wedge beside the excitation: the transverse motion of the shaker, and a bending of the wedge with a
/// resonance of its own along each axis of the table.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BenchWedge {
    /// Transverse motion of the shaker relative to the excitation along x′ and y′.
    pub(crate) transverse: [Complex64; 2],
    /// Resonances of a wedge of 90° along x′, y′ and z′ in Hz; flatter wedges are stiffer.
    pub(crate) resonance: [f64; 3],
    /// Quality factor of the resonances.
    pub(crate) quality: f64,
    /// Motion along x′, y′ and z′ at the height of a wedge of 90°, relative to what the resonance adds.
    pub(crate) participation: [f64; 3],
    /// Bending that was calculated or measured: it takes the place of the resonances at its inclinations.
    pub bending: Vec<Bending>,
}

/// Motion of the top of a wedge beside that of its base, at one inclination and frequency.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Bending {
    /// Inclination in degrees.
    pub inclination_deg: f64,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Along x′, y′ and z′, relative to the motion of the base.
    #[cfg_attr(feature = "schema", schemars(with = "[[f64; 2]; 3]"))]
    pub ratio: [Complex64; 3],
}

impl Default for BenchWedge {
    fn default() -> Self {
        Self {
            transverse: [
                Complex64::from_polar(0.010, 2.2),
                Complex64::from_polar(0.008, -1.1),
            ],
            resonance: [3.2e3, 4.1e3, 3.6e3],
            quality: 30.0,
            participation: [0.6, 0.1, 1.0],
            bending: vec![],
        }
    }
}

impl BenchWedge {
    /// Ratios ε along x′, y′, z′ at an inclination (degrees) and frequency (Hz); along z′ the departure from the
    /// excitation.
    pub fn ratio(&self, inclination_deg: f64, frequency: f64) -> [Complex64; 3] {
        let slope = inclination_deg.to_radians().sin();
        let bending = self
            .tabulated(inclination_deg, frequency)
            .unwrap_or_else(|| {
                std::array::from_fn(|k| {
                    // Stiffness falls with height: the flat table has no bending at all.
                    let x = frequency / (self.resonance[k] * (2.0 - slope));
                    let gain = Complex64::new(1.0 - x * x, x / self.quality).inv() - 1.0;
                    gain * (self.participation[k] * slope)
                })
            });
        [
            self.transverse[0] + bending[0],
            self.transverse[1] + bending[1],
            bending[2],
        ]
    }

    /// Bending from the table of the wedge within half a degree: straight lines between its frequencies, with the square
    /// of the frequency below the lowest (as any motion far below a resonance), the last one above the highest.
    fn tabulated(&self, inclination_deg: f64, frequency: f64) -> Option<[Complex64; 3]> {
        let mut points: Vec<&Bending> = self
            .bending
            .iter()
            .filter(|b| (b.inclination_deg - inclination_deg).abs() < 0.5)
            .collect();
        points.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        let above = points.partition_point(|b| b.frequency < frequency);
        match (above.checked_sub(1).map(|k| points[k]), points.get(above)) {
            (None, None) => None,
            (Some(last), None) => Some(last.ratio),
            (None, Some(first)) => {
                let share = (frequency / first.frequency).powi(2);
                Some(first.ratio.map(|z| z * share))
            }
            (Some(a), Some(b)) => {
                let share = (frequency - a.frequency) / (b.frequency - a.frequency);
                Some(std::array::from_fn(|k| {
                    a.ratio[k] + (b.ratio[k] - a.ratio[k]) * share
                }))
            }
        }
    }

    /// Transverse motion relative to the excitation, as a transverse sensor on the wedge would read it.
    pub fn transverse_motion(&self, inclination_deg: f64, frequency: f64) -> f64 {
        let [x, y, _] = self.ratio(inclination_deg, frequency);
        x.norm().hypot(y.norm())
    }
}
