//! One block of sines, the phase of every block, and exact sums of their products.

use num_complex::Complex64;
use std::f64::consts::TAU;

/// Samples per block: the tables of a few harmonics stay in the first-level cache.
const BLOCK: usize = 256;

/// cos(hωl) and sin(hωl) for one block, and the exact anchor of every block.
pub(crate) struct Tables {
    pub(crate) omega: f64,
    pub(crate) samples: usize,
    pub(crate) block: usize,
    middle: f64,
    pub(crate) cosine: Vec<Vec<f64>>,
    pub(crate) sine: Vec<Vec<f64>>,
    pub(crate) ramp: Vec<f64>,
    /// l cos(ωl) and l sin(ωl).
    pub(crate) ramped: [Vec<f64>; 2],
    /// e^{jω(n − middle)} for the first sample n of every block.
    anchors: Vec<Complex64>,
    /// Σ_l (scale l)ᵖ e^{jkωl} over a full and over the last block, for k = 0 … 2H.
    inside: [Vec<[Complex64; 3]>; 2],
    /// e^{−j2πb/B} over the B full blocks.
    pub(crate) circle: Vec<Complex64>,
}

impl Tables {
    pub(crate) fn new(omega: f64, samples: usize, harmonics: usize) -> Self {
        // At least sixty-four blocks, so that the demodulated series has bins beside the drive, and what is farther away
        // does not fold onto them.
        let block = (samples / 64).clamp(8, BLOCK);
        let middle = 0.5 * (samples - 1) as f64;
        let scale = 2.0 / samples as f64;
        let unit = |angle: f64| {
            let (s, c) = angle.sin_cos();
            Complex64::new(c, s)
        };
        // Powers of one row of exact phases: k ε at most.
        let first: Vec<Complex64> = (0..block).map(|l| unit(omega * l as f64)).collect();
        let mut power = vec![Complex64::new(1.0, 0.0); block];
        let (mut cosine, mut sine, mut inside) = (vec![], vec![], [vec![], vec![]]);
        for k in 0..=2 * harmonics {
            if k > 0 {
                for (p, e) in power.iter_mut().zip(&first) {
                    *p *= e;
                }
            }
            if (1..=harmonics).contains(&k) {
                cosine.push(power.iter().map(|e| e.re).collect());
                sine.push(power.iter().map(|e| e.im).collect());
            }
            for (inside, length) in inside.iter_mut().zip([block, samples % block]) {
                let mut sums = [Complex64::new(0.0, 0.0); 3];
                for (l, e) in power[..length].iter().enumerate() {
                    let t = scale * l as f64;
                    sums[0] += e;
                    sums[1] += e * t;
                    sums[2] += e * (t * t);
                }
                inside.push(sums);
            }
        }
        let full = samples / block;
        let ramped = [&cosine[0], &sine[0]].map(|row: &Vec<f64>| {
            let places = row.iter().enumerate();
            places.map(|(l, value)| l as f64 * value).collect()
        });
        Self {
            omega,
            samples,
            block,
            middle,
            cosine,
            sine,
            ramp: (0..block).map(|l| l as f64).collect(),
            ramped,
            anchors: (0..samples)
                .step_by(block)
                .map(|start| unit(omega * (start as f64 - middle)))
                .collect(),
            inside,
            circle: (0..full)
                .map(|b| unit(-TAU * b as f64 / full as f64))
                .collect(),
        }
    }

    /// Number of blocks, the last and shorter one included.
    pub(crate) fn blocks(&self) -> usize {
        self.anchors.len()
    }

    /// e^{jkω(n − middle)} for the first sample n of a block.
    pub(crate) fn anchor(&self, k: usize, block: usize) -> Complex64 {
        // Powers of one exact phase: k ε at most.
        (1..k).fold(self.anchors[block], |power, _| power * self.anchors[block])
    }

    /// τ of the first sample of a block: −1 … 1 over the record.
    pub(crate) fn tau(&self, block: usize) -> f64 {
        2.0 * ((block * self.block) as f64 - self.middle) / self.samples as f64
    }

    /// Σ z_b e^{−j2πmb/B} of a value per full block.
    pub(crate) fn bin(&self, series: &[Complex64], m: isize) -> Complex64 {
        let blocks = series.len();
        let m = m.rem_euclid(blocks as isize) as usize;
        let turned = series.iter().enumerate();
        turned.map(|(b, z)| self.circle[(m * b) % blocks] * z).sum()
    }

    /// τ per sample.
    pub(crate) fn scale(&self) -> f64 {
        2.0 / self.samples as f64
    }

    /// Σ τᵖ e^{jkω(n − middle)} over one block, p = 0, 1, 2.
    pub(crate) fn block_sums(&self, k: usize, block: usize) -> [Complex64; 3] {
        let full = (block + 1) * self.block <= self.samples;
        let [zeroth, first, second] = self.inside[usize::from(!full)][k];
        let e = match k {
            0 => Complex64::new(1.0, 0.0),
            _ => self.anchor(k, block),
        };
        let t = self.tau(block);
        [
            e * zeroth,
            e * (first + zeroth * t),
            e * (second + first * (2.0 * t) + zeroth * (t * t)),
        ]
    }

    /// The same over some blocks, for every k up to twice the highest harmonic: `[p][k]`.
    pub(crate) fn power_sums(
        &self,
        blocks: impl Iterator<Item = usize> + Clone,
    ) -> [Vec<Complex64>; 3] {
        let mut result = [vec![], vec![], vec![]];
        for k in 0..self.inside[0].len() {
            let mut sums = [Complex64::new(0.0, 0.0); 3];
            for block in blocks.clone() {
                for (sum, part) in sums.iter_mut().zip(self.block_sums(k, block)) {
                    *sum += part;
                }
            }
            for (r, s) in result.iter_mut().zip(sums) {
                r.push(s);
            }
        }
        result
    }
}
