//! Fast draws from Student's t: the ziggurat method with a table of its own for each ν.

use crate::student;
use rand::{Rng, RngExt};
use statrs::function::beta::beta_reg;

const LAYERS: usize = 256;

/// Layers of equal area under (1 + x²/ν)^(−(ν+1)/2), x ≥ 0; the lowest holds the tail.
///
/// Exact, not approximate: a point outside the fast part of its layer is judged by the density itself, the tail by
/// rejection from a power law that touches it at its start. **Source** `[MarsagliaTsang2000]`, applied to t.
pub(crate) struct StudentZiggurat {
    nu: f64,
    /// Right ends of the layers, falling; `x[0]` is the width of a rectangle with the area of the lowest layer.
    x: [f64; LAYERS + 1],
    /// Density at the right ends.
    f: [f64; LAYERS + 1],
}

fn density(x: f64, nu: f64) -> f64 {
    (-0.5 * (nu + 1.0) * (x * x / nu).ln_1p()).exp()
}

impl StudentZiggurat {
    pub fn new(nu: f64) -> Self {
        let whole = (-student::ln_pdf_factor(nu)).exp();
        let area =
            |r: f64| r * density(r, nu) + 0.5 * whole * beta_reg(0.5 * nu, 0.5, nu / (nu + r * r));
        // The right start r makes the 256th layer end at the top of the density.
        let layers = |r: f64| {
            let v = area(r);
            let (mut x, mut f) = ([0.0; LAYERS + 1], [1.0; LAYERS + 1]);
            (x[1], f[1]) = (r, density(r, nu));
            (x[0], f[0]) = (v / f[1], 0.0);
            for i in 1..LAYERS {
                let y = f[i] + v / x[i];
                if y >= 1.0 {
                    return (x, f, (i as f64 - LAYERS as f64) + 1.0 - y);
                }
                f[i + 1] = y;
                x[i + 1] = (nu * (y.powf(-2.0 / (nu + 1.0)) - 1.0)).sqrt();
            }
            let left = 1.0 - f[LAYERS];
            (x[LAYERS], f[LAYERS]) = (0.0, 1.0);
            (x, f, left)
        };
        let (mut low, mut high) = (0f64, 60f64); // ln r
        // Until the ends are neighbours: 60/2⁵⁸ is below the spacing of numbers near one.
        for _ in 0..58 {
            let middle = 0.5 * (low + high);
            if layers(middle.exp()).2 < 0.0 {
                low = middle; // layers too thick: the tail must start farther out
            } else {
                high = middle;
            }
        }
        let (mut x, mut f, _) = layers(high.exp());
        (x[LAYERS], f[LAYERS]) = (0.0, 1.0);
        Self { nu, x, f }
    }

    /// A draw from one random word; `rng` gives more where that one does not decide, about once in a hundred.
    #[inline]
    pub fn shape<R: Rng>(&self, word: u64, rng: &mut R) -> f64 {
        let mut bits = word;
        loop {
            let i = (bits & 0xff) as usize;
            // The upper 53 bits, which the choice of the layer does not use, as a signed number in [−1, 1).
            let u = (bits as i64 >> 11) as f64 * (1.0 / (1u64 << 52) as f64);
            let x = u * self.x[i];
            if x.abs() < self.x[i + 1] {
                return x;
            }
            if i == 0 {
                return self.tail(rng).copysign(u);
            }
            let y = self.f[i] + rng.random::<f64>() * (self.f[i + 1] - self.f[i]);
            if y < density(x, self.nu) {
                return x;
            }
            bits = rng.random();
        }
    }

    /// |x| beyond r: d ln f/d ln x falls with x, so f(r)(x/r)^−s with the slope s at r lies above f.
    #[cold]
    fn tail<R: Rng>(&self, rng: &mut R) -> f64 {
        let (r, nu) = (self.x[1], self.nu);
        let s = (nu + 1.0) * r * r / (nu + r * r);
        loop {
            let u = 1.0 - rng.random::<f64>();
            let x = r * u.powf(-1.0 / (s - 1.0));
            let above = self.f[1] * (x / r).powf(-s);
            if x.is_finite() && rng.random::<f64>() * above < density(x, nu) {
                return x;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Shares below quantiles, against the binomial bound of four standard deviations; tails included.
    #[test]
    fn law_draws_follow_the_quantiles() {
        let n = 200_000;
        for nu in [0.8, 1.0, 2.5, 5.0, 18.0, 300.0, 1e4, 9e5] {
            let ziggurat = StudentZiggurat::new(nu);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
            let draws: Vec<f64> = (0..n)
                .map(|_| ziggurat.shape(rng.random(), &mut rng))
                .collect();
            for p in [
                0.0005, 0.002, 0.01, 0.025, 0.2, 0.5, 0.7, 0.9, 0.975, 0.998, 0.9995,
            ] {
                let q = student::quantile(p, nu);
                let share = draws.iter().filter(|x| **x <= q).count() as f64 / n as f64;
                let bound = 4.0 * (p * (1.0 - p) / n as f64).sqrt();
                assert!((share - p).abs() < bound, "ν {nu} p {p}: {share}");
            }
        }
    }
}
