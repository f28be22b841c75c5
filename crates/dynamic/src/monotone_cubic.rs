//! Interpolation that makes no extremum of its own.

/// The interval of ascending knots in which x lies, and where in it from 0 to 1; the first or last one beyond them.
///
/// **Shapes** at least two knots.
pub(crate) fn interval(knots: &[f64], x: f64) -> (usize, f64) {
    let k = knots
        .partition_point(|&knot| knot <= x)
        .clamp(1, knots.len() - 1)
        - 1;
    let t = (x - knots[k]) / (knots[k + 1] - knots[k]);
    (k, t.clamp(0.0, 1.0))
}

/// Monotone cubic through (x, y), tangents by the weighted harmonic mean of the secants.
///
/// **Source** `[FritschCarlson1980]`.
pub(crate) struct MonotoneCubic {
    x: Vec<f64>,
    y: Vec<f64>,
    tangent: Vec<f64>,
}

impl MonotoneCubic {
    /// **Shapes** ascending x and as many y, two or more.
    pub(crate) fn new(x: &[f64], y: &[f64]) -> Self {
        let secant = |i: usize| (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
        let n = x.len();
        let tangent = |i: usize| -> f64 {
            if i == 0 {
                return secant(0);
            }
            if i == n - 1 {
                return secant(n - 2);
            }
            let (a, b) = (secant(i - 1), secant(i));
            if a * b <= 0.0 {
                return 0.0;
            }
            let (h0, h1) = (x[i] - x[i - 1], x[i + 1] - x[i]);
            let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
            (w0 + w1) / (w0 / a + w1 / b)
        };
        Self {
            tangent: (0..n).map(tangent).collect(),
            x: x.to_vec(),
            y: y.to_vec(),
        }
    }

    /// Between knots k and k + 1 at t in [0, 1].
    pub(crate) fn at(&self, k: usize, t: f64) -> f64 {
        let h = self.x[k + 1] - self.x[k];
        let (m0, m1) = (self.tangent[k] * h, self.tangent[k + 1] * h);
        let (t2, t3) = (t * t, t * t * t);
        self.y[k] * (2.0 * t3 - 3.0 * t2 + 1.0)
            + m0 * (t3 - 2.0 * t2 + t)
            + self.y[k + 1] * (3.0 * t2 - 2.0 * t3)
            + m1 * (t3 - t2)
    }
}
