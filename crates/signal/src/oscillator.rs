//! One linear oscillator on a moving base, stepped exactly through a record of straight lines.

use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_core::check::positive;

/// z = v − λ̄ x of an oscillator x″ + 2ζω x′ + ω² x = −a, λ = −ζω + jω√(1 − ζ²): one complex state, z′ = λz − a.
///
/// Through a step in which a runs straight from a₀ to a₁, z₁ = e^μ z₀ − T[(φ₁ − φ₂) a₀ + φ₂ a₁], μ = λT,
/// φ₁ = (e^μ − 1)/μ, φ₂ = (e^μ − 1 − μ)/μ²: the ramp-invariant filter, which keeps its digits however low the
/// frequency, where the direct form of its coefficients loses (ωT)⁻² of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Oscillator {
    /// λ in 1/s.
    pub(crate) pole: Complex64,
    /// Duration of a step in s.
    pub(crate) step: f64,
    /// e^{λT}.
    pub(crate) turn: Complex64,
    /// −T(φ₁ − φ₂) and −Tφ₂.
    pub(crate) gains: [Complex64; 2],
}

/// y = Re(κ z), with κ for whatever is asked of the oscillator.
pub(crate) type Reading = Complex64;

impl Oscillator {
    /// Natural frequency in Hz, damping ratio below one, step in s.
    pub(crate) fn new(frequency: f64, damping: f64, step: f64) -> Self {
        let omega = std::f64::consts::TAU * frequency;
        let pole = Complex64::new(-damping * omega, omega * (1.0 - damping * damping).sqrt());
        let mu = pole * step;
        let (phi1, phi2) = phi(mu);
        Self {
            pole,
            step,
            turn: mu.exp(),
            gains: [-(phi1 - phi2) * step, -phi2 * step],
        }
    }

    /// κ of αx + βv.
    pub(crate) fn reading(&self, of_displacement: f64, of_velocity: f64) -> Reading {
        let eta = (of_displacement + of_velocity * self.pole.re) / self.pole.im;
        Complex64::new(of_velocity, -eta)
    }

    /// State after a step.
    pub(crate) fn next(&self, z: Complex64, a0: f64, a1: f64) -> Complex64 {
        self.turn * z + self.gains[0] * a0 + self.gains[1] * a1
    }

    /// Widens [low, high] by what y reaches inside a step, its ends left out.
    ///
    /// There z = H e^{λs} + (a₀ + rs)/λ + r/λ², so y″ = Re(κλ²H e^{λs}) vanishes at known instants; between them y′ is
    /// monotonic and has one root or none.
    pub(crate) fn widen_within(
        &self,
        kappa: Reading,
        z0: Complex64,
        (a0, a1): (f64, f64),
        range: &mut [f64; 2],
    ) {
        let (lambda, t) = (self.pole, self.step);
        let slope = (a1 - a0) / t;
        // y′ = Re(κ z′), y″ = Re(κ z″) at both ends: where neither changes sign within half a period there is no extreme.
        let z1 = self.next(z0, a0, a1);
        let first = |z: Complex64, a: f64| (kappa * (lambda * z - a)).re;
        let second = |z: Complex64, a: f64| (kappa * (lambda * (lambda * z - a) - slope)).re;
        let (d0, d1) = (first(z0, a0), first(z1, a1));
        let same = |p: f64, q: f64| (p > 0.0) == (q > 0.0);
        let short = lambda.im * t < std::f64::consts::PI;
        if short && same(d0, d1) && same(second(z0, a0), second(z1, a1)) {
            return;
        }
        // Of a step far below a period the highest point lies within (ωT)²/8 of an end: nothing is to be gained.
        if lambda.norm() * t < 1e-4 {
            return;
        }
        let free = z0 - a0 / lambda - slope / (lambda * lambda);
        let k = kappa * free;
        let (c0, c1) = (
            (kappa * (a0 / lambda + slope / (lambda * lambda))).re,
            (kappa * slope / lambda).re,
        );
        let value = |s: f64| (k * (lambda * s).exp()).re + c0 + c1 * s;
        let rate = |s: f64| (k * lambda * (lambda * s).exp()).re + c1;
        let bend = k * lambda * lambda;
        let mut edge = 0.0;
        let mut at_edge = rate(0.0);
        for knot in zeros(bend, lambda).take_while(|s| *s < t).chain([t]) {
            let there = rate(knot);
            if !same(at_edge, there) {
                let root = bisect(&rate, edge, knot, at_edge > 0.0);
                widen(range, value(root));
            }
            (edge, at_edge) = (knot, there);
        }
    }

    /// Least and greatest y = Re k of the free motion from k = κz on, without end; k itself is left out.
    pub(crate) fn free_extremes(&self, k: Complex64) -> Option<[f64; 2]> {
        if k.norm() == 0.0 {
            return None;
        }
        let mut range: Option<[f64; 2]> = None;
        for s in zeros(k * self.pole, self.pole).take(2) {
            let y = (k * (self.pole * s).exp()).re;
            match &mut range {
                Some(range) => widen(range, y),
                None => range = Some([y, y]),
            }
        }
        range
    }
}

/// Displacement of an oscillator's mass against its base, which a record of acceleration moves, from rest: x″ + 2ζω x′ + ω² x =
/// −a, exact for straight lines between samples.
///
/// **Units** acceleration in m/s², rate and natural frequency in Hz, displacement in m.
///
/// # Errors
/// [`Error::OutOfRange`] for a rate or frequency that is not positive, a damping ratio outside [0, 1); [`Error::NotFinite`].
///
/// ```
/// // Slow against the oscillator: x = −a/ω².
/// let x = proofmass_signal::relative_displacement(&vec![1.0; 10_000], 1000.0, 5.0, 0.7).unwrap();
/// let omega = std::f64::consts::TAU * 5.0;
/// assert!((x[9999] * omega * omega + 1.0).abs() < 1e-9);
/// ```
pub fn relative_displacement(
    acceleration: &[f64],
    rate: f64,
    frequency: f64,
    damping: f64,
) -> Result<Vec<f64>, Error> {
    positive("sample rate", rate)?;
    positive("natural frequency", frequency)?;
    if !(0.0..1.0).contains(&damping) {
        return Err(Error::OutOfRange {
            name: "damping ratio",
            value: damping,
            min: 0.0,
            max: 1.0,
        });
    }
    proofmass_core::check::finite("acceleration", acceleration)?;
    let oscillator = Oscillator::new(frequency, damping, 1.0 / rate);
    let mut z = Complex64::new(0.0, 0.0);
    let mut before = acceleration.first().copied().unwrap_or(0.0);
    Ok(acceleration
        .iter()
        .enumerate()
        .map(|(k, &a)| {
            if k > 0 {
                z = oscillator.next(z, before, a);
            }
            before = a;
            z.im / oscillator.pole.im
        })
        .collect())
}

/// Extends an interval to a value.
pub(crate) fn widen(range: &mut [f64; 2], y: f64) {
    range[0] = range[0].min(y);
    range[1] = range[1].max(y);
}

/// The positive times at which Re(c e^{λs}) vanishes, in order.
fn zeros(c: Complex64, lambda: Complex64) -> impl Iterator<Item = f64> {
    let half = std::f64::consts::PI;
    let first = (0.5 * half - c.arg()).rem_euclid(half);
    (0..).map(move |k| (first + f64::from(k) * half) / lambda.im)
}

/// The root of a monotonic function between two points at which its signs differ.
fn bisect(f: &impl Fn(f64) -> f64, mut low: f64, mut high: f64, positive_first: bool) -> f64 {
    // An extreme at the square root of the rounding is exact to the rounding: thirty halvings.
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if (f(middle) > 0.0) == positive_first {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// φ₁ and φ₂, by their series where the quotients would cancel.
fn phi(mu: Complex64) -> (Complex64, Complex64) {
    if mu.norm() > 0.5 {
        let e = mu.exp();
        return ((e - 1.0) / mu, (e - 1.0 - mu) / (mu * mu));
    }
    // φ₂ = Σ μᵏ/(k + 2)!; sixteen terms leave 0.5¹⁶/18! < 1e-20.
    let phi2 = (0..16).rev().fold(Complex64::new(0.0, 0.0), |sum, k| {
        (sum * mu + 1.0) / f64::from(k + 2)
    });
    (phi2 * mu + 1.0, phi2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_series_and_quotients_meet() {
        for angle in [0.0f64, 0.7, 1.5, 3.0] {
            let mu = Complex64::from_polar(0.5, angle);
            let (p1, p2) = phi(mu);
            let (q1, q2) = phi(mu * (1.0 + 1e-15));
            // The quotient for φ₂ loses 1/|μ|² of its digits.
            assert!((p1 - q1).norm() < 1e-14 && (p2 - q2).norm() < 1e-14);
        }
    }

    #[test]
    fn known_a_constant_base_acceleration_deflects_twice_the_static_value() {
        // Undamped, from rest: x = −(a/ω²)(1 − cos ωt), whose extreme lies between samples.
        let oscillator = Oscillator::new(1.0, 0.0, 0.3);
        let kappa = oscillator.reading(oscillator.pole.norm_sqr(), 0.0);
        let (mut z, mut range) = (Complex64::new(0.0, 0.0), [0.0; 2]);
        for _ in 0..10 {
            oscillator.widen_within(kappa, z, (1.0, 1.0), &mut range);
            z = oscillator.next(z, 1.0, 1.0);
        }
        assert!(
            (range[0] + 2.0).abs() < 1e-14 && range[1].abs() < 1e-14,
            "{range:?}"
        );
    }
}
