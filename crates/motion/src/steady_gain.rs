//! The gain that a Kalman filter settles to, also where it settles too slowly to be iterated.

use crate::ReadingSource;
use crate::small_matrix::{Square, inverse, matrix, product, sum};
use proofmass_core::Error;
use proofmass_core::velocity::{Kalman, SteadyKalman};
use std::array::from_fn;

/// Steps of doubling: 2⁶⁰ samples.
const STEPS: usize = 60;

/// The filter with its steady gain for readings of this kind at every sample.
///
/// An offset that hardly walks settles in more steps than [`Kalman::steady_for`] iterates; doubling gets there in some thirty.
///
/// # Errors
/// [`Error::NotConverged`]: a gain that does not settle, as without noise of the acceleration.
pub fn steady_gain<const N: usize>(
    kalman: &Kalman<f64, N>,
    source: ReadingSource,
) -> Result<SteadyKalman<f64, N>, Error> {
    let component = usize::from(source == ReadingSource::Speed);
    match kalman.steady_for(component) {
        Err(Error::NotConverged { .. }) if component == 0 => doubled(kalman),
        iterated => iterated,
    }
}

/// Steady gain for readings of the position, by the structure-preserving doubling algorithm of the Riccati equation: after k
/// steps the covariance is that after 2ᵏ samples.
///
/// **Source** `[Anderson78]`.
fn doubled<const N: usize>(kalman: &Kalman<f64, N>) -> Result<SteadyKalman<f64, N>, Error> {
    // In units of the sample time the states are of one size: a position, velocities, and an offset behind the second.
    let t = kalman.f[0][1];
    let size: [f64; N] = from_fn(|i| match i {
        0 => 1.0,
        _ if i == N - 1 && N > 2 => 1.0 / (t * t),
        _ => 1.0 / t,
    });
    let unit = matrix::<N>(|i, j| f64::from(u8::from(i == j)));
    let mut a = matrix::<N>(|i, j| kalman.f[j][i] * size[i] / size[j]);
    let mut p = matrix::<N>(|i, j| kalman.q[i][j] / (size[i] * size[j] * kalman.r));
    let mut g = matrix::<N>(|i, j| f64::from(u8::from(i == 0 && j == 0)));
    let mut change = f64::INFINITY;
    for _ in 0..STEPS {
        let Some(w) = inverse(sum(&unit, &product(&g, &p))) else {
            break;
        };
        let aw = product(&a, &w);
        let across: Square<N> = matrix(|i, j| a[j][i]);
        let more = product(&product(&product(&across, &p), &w), &a);
        g = sum(&g, &product(&product(&aw, &g), &across));
        a = product(&aw, &a);
        change = (0..N)
            .map(|i| more[i][i].abs() / p[i][i].abs().max(f64::MIN_POSITIVE))
            .fold(0.0, f64::max);
        p = sum(&p, &more);
        if change < 1e-12 {
            let k: [f64; N] = from_fn(|i| p[i][0] / (p[0][0] + 1.0));
            let left = p[1][1] - k[1] * p[0][1];
            return Ok(SteadyKalman {
                f: kalman.f,
                g: kalman.g,
                k: from_fn(|i| k[i] * size[i]),
                component: 0,
                velocity_variance: left * kalman.r * size[1] * size[1],
            });
        }
    }
    Err(Error::NotConverged {
        name: "steady gain",
        iterations: STEPS,
        step: change,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_core::velocity::{BiasModel, Hold, MotionNoise, ProcessNoise};

    const NOISE: MotionNoise = MotionNoise {
        acceleration: 1e-3,
        form: ProcessNoise::SampleConstant,
        position: 1e-9,
    };

    fn kalman(density: f64) -> Result<Kalman<f64, 3>, Error> {
        let walk = BiasModel::RandomWalk {
            density,
            initial: 0.1,
        };
        Kalman::<f64, 3>::with_bias(&NOISE, walk, Hold::Second, 1e-3)
    }

    fn agree<const N: usize>(kalman: &Kalman<f64, N>) -> Result<(), Error> {
        let (fast, slow) = (doubled(kalman)?, kalman.steady()?);
        for i in 0..N {
            assert!(
                (fast.k[i] / slow.k[i] - 1.0).abs() < 1e-6,
                "{fast:?} {slow:?}"
            );
        }
        assert!((fast.velocity_variance / slow.velocity_variance - 1.0).abs() < 1e-6);
        Ok(())
    }

    #[test]
    fn law_doubling_and_iteration_agree() -> Result<(), Error> {
        for density in [1e-4, 1e-5, 1e-6] {
            agree(&kalman(density)?)?;
        }
        for corner in [0.5, 2.0] {
            let first = Kalman::<f64, 4>::with_low_corner(&NOISE, 1e-6, corner, Hold::Second, 1e-3);
            agree(&first?)?;
            let second = Kalman::<f64, 5>::with_second_order_corner(
                &NOISE,
                1e-6,
                corner,
                Hold::Second,
                1e-3,
            );
            agree(&second?)?;
        }
        Ok(())
    }

    /// A walk ten times as small is followed ten times as slowly.
    #[test]
    fn known_an_offset_that_hardly_walks_settles() -> Result<(), Error> {
        let slow = doubled(&kalman(1e-12)?)?;
        let slower = doubled(&kalman(1e-14)?)?;
        assert!(
            (slow.k[2] / slower.k[2] - 10.0).abs() < 0.1,
            "{slow:?} {slower:?}"
        );
        Ok(())
    }

    /// Corners over three decades and both orders settle, at noise of ordinary sensors.
    #[test]
    fn known_every_corner_settles() -> Result<(), Error> {
        for corner in [0.01, 0.05, 0.5, 2.0, 10.0] {
            for rate in [200.0, 1000.0, 10_000.0] {
                let w = 0.1 * std::f64::consts::TAU * corner;
                let walk = w * w * NOISE.acceleration / rate;
                let (hold, t) = (Hold::Second, 1.0 / rate);
                let one = Kalman::<f64, 4>::with_low_corner(&NOISE, walk, corner, hold, t)?;
                let two =
                    Kalman::<f64, 5>::with_second_order_corner(&NOISE, walk, corner, hold, t)?;
                let one = steady_gain(&one, ReadingSource::Position)?.velocity_variance;
                let two = steady_gain(&two, ReadingSource::Position)?.velocity_variance;
                assert!(
                    one > 0.0 && two > one,
                    "{corner} Hz, {rate} Hz: {one} {two}"
                );
            }
        }
        Ok(())
    }
}
