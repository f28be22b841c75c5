//! The device under test and the wedge under it.

use faer::c64;

/// A triaxial accelerometer: a seismic resonance per axis, a high-pass corner, and cross terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Device {
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

impl Default for Device {
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

impl Device {
    /// True S at a frequency in Hz, o = a S, V/(m/s²), complex.
    pub fn sensitivity(&self, frequency: f64) -> [[c64; 3]; 3] {
        let j = c64::new(0.0, 1.0);
        std::array::from_fn(|i| {
            std::array::from_fn(|k| {
                let x = frequency / self.resonance[k];
                let resonance = c64::new(1.0 - x * x, x / self.quality).inv();
                let highpass = (c64::new(1.0, 0.0) - j * (self.corner / frequency)).inv();
                let relative = if i == k { 1.0 } else { self.cross[i][k] };
                resonance * highpass * (relative * self.main[k])
            })
        })
    }
}

/// Motion of a wedge beside the excitation: a rocking of the table and a bending that grows with frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Wedge {
    /// Transverse motion of the shaker relative to the excitation along x′ and y′.
    pub transverse: [c64; 2],
    /// First bending frequency of a wedge of 90° in Hz; flatter wedges are stiffer.
    pub bending: f64,
    /// Quality factor of the bending.
    pub quality: f64,
}

impl Default for Wedge {
    fn default() -> Self {
        Self {
            transverse: [c64::from_polar(0.010, 2.2), c64::from_polar(0.008, -1.1)],
            bending: 2.4e3,
            quality: 30.0,
        }
    }
}

impl Wedge {
    /// Ratios ε along x′, y′, z′ at an inclination (degrees) and frequency (Hz).
    pub fn ratio(&self, inclination_deg: f64, frequency: f64) -> [c64; 3] {
        let slope = inclination_deg.to_radians().sin();
        // Stiffness falls with height: the flat table has no bending at all.
        let bending = self.bending * (2.0 - slope);
        let x = frequency / bending;
        let gain = c64::new(1.0 - x * x, x / self.quality).inv() - 1.0;
        [
            self.transverse[0] + gain * (0.6 * slope),
            self.transverse[1] + gain * (0.1 * slope),
            gain * slope,
        ]
    }
}
