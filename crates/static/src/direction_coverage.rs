//! Which of the six principal directions a set of attitudes reaches, and the largest hole it leaves.

use crate::{Ellipsoid, Triple};
use proofmass_core::Error;
use std::fmt;

/// One of the six directions a sensor axis can point along or against the specific force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct Direction {
    /// 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Whether the axis points up, so that it reads +g at rest.
    pub up: bool,
}

impl Direction {
    /// +x, −x, +y, −y, +z, −z.
    pub const ALL: [Self; 6] = [
        Self { axis: 0, up: true },
        Self { axis: 0, up: false },
        Self { axis: 1, up: true },
        Self { axis: 1, up: false },
        Self { axis: 2, up: true },
        Self { axis: 2, up: false },
    ];

    /// As a unit vector in the axes of the sensor.
    pub fn unit(self) -> Triple {
        let mut unit = [0.0; 3];
        unit[self.axis] = if self.up { 1.0 } else { -1.0 };
        unit
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}{}",
            if self.up { '+' } else { '-' },
            ["x", "y", "z"][self.axis]
        )
    }
}

/// How well a set of directions covers the sphere.
#[doc(alias("sphere coverage"))]
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct DirectionCoverage {
    /// Principal directions without any attitude within 45°.
    pub missing: Vec<Direction>,
    /// Radius of the largest circle on the sphere without an attitude, degrees.
    pub largest_hole_deg: f64,
    /// Its centre, a unit vector in the axes of the sensor.
    pub hole_centre: Triple,
}

impl DirectionCoverage {
    /// Of directions that need not be normalised; zero vectors do not count.
    pub fn of(directions: &[Triple]) -> Self {
        let units: Vec<Triple> = directions.iter().filter_map(|d| unit(*d)).collect();
        let missing = missing(&units);
        let (mut hole_centre, mut cosine) = ([0.0, 0.0, 1.0], f64::INFINITY);
        for place in PLACES.iter() {
            let mut nearest = -1.0f64;
            for u in &units {
                nearest = nearest.max(proofmass_core::dot(*u, *place));
                // A place nearer to an attitude than the best hole so far is none.
                if nearest >= cosine {
                    break;
                }
            }
            if nearest < cosine {
                (hole_centre, cosine) = (*place, nearest);
            }
        }
        Self {
            missing,
            largest_hole_deg: cosine.clamp(-1.0, 1.0).acos().to_degrees(),
            hole_centre,
        }
    }

    /// Of mean outputs: as they are where they are accelerations, about the centre of their sphere where they are
    /// raw. Good enough to tell which directions are there when a fit could not be made.
    ///
    /// # Errors
    /// Those of [`Ellipsoid::sphere`].
    pub fn of_outputs(means: &[Triple], are_accelerations: bool) -> Result<Self, Error> {
        if are_accelerations {
            return Ok(Self::of(means));
        }
        let centre = Ellipsoid::sphere(means)?.centre;
        let directions: Vec<Triple> = means
            .iter()
            .map(|m| std::array::from_fn(|i| m[i] - centre[i]))
            .collect();
        Ok(Self::of(&directions))
    }

    /// The two ends of an axis that both have no attitude, where there is one.
    pub fn missing_axis(&self) -> Option<usize> {
        (0..3).find(|&axis| self.missing.iter().filter(|d| d.axis == axis).count() == 2)
    }
}

impl fmt::Display for DirectionCoverage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of 6 directions present", 6 - self.missing.len())?;
        if !self.missing.is_empty() {
            let names: Vec<String> = self.missing.iter().map(Direction::to_string).collect();
            write!(f, ", {} missing", names.join(" and "))?;
        }
        Ok(())
    }
}

/// Principal directions without any of these unit vectors within 45°.
fn missing(units: &[Triple]) -> Vec<Direction> {
    Direction::ALL
        .into_iter()
        .filter(|d| {
            let near =
                |u: &Triple| proofmass_core::dot(*u, d.unit()) >= std::f64::consts::FRAC_1_SQRT_2;
            !units.iter().any(near)
        })
        .collect()
}

/// The vector at unit length; `None` for zero and for what is not finite.
pub(crate) fn unit(v: Triple) -> Option<Triple> {
    let norm = proofmass_core::norm(v);
    (norm > 0.0 && norm.is_finite()).then(|| v.map(|x| x / norm))
}

/// Places at which the largest hole is looked for; none is further than 3° from any.
static PLACES: std::sync::LazyLock<Vec<Triple>> =
    std::sync::LazyLock::new(|| spiral(2000).collect());

/// Points spread evenly over the sphere (Fibonacci spiral); with 2000 of them none is further than 3° from any.
pub(crate) fn spiral(n: usize) -> impl Iterator<Item = Triple> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..n).map(move |i| {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / n as f64;
        let r = (1.0 - z * z).sqrt();
        let angle = golden * i as f64;
        [r * angle.cos(), r * angle.sin(), z]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_six_positions_leave_the_corners_of_the_cube() {
        let six: Vec<Triple> = Direction::ALL.iter().map(|d| d.unit()).collect();
        let coverage = DirectionCoverage::of(&six);
        assert!(coverage.missing.is_empty());
        // The corner of the cube lies 54.74° from three axes; the spiral comes within 3° of it.
        assert!((coverage.largest_hole_deg - 54.74).abs() < 3.0);
    }

    #[test]
    fn known_missing_directions_are_named() {
        let coverage = DirectionCoverage::of(&[
            [9.8, 0.1, 0.0],
            [-9.8, 0.0, 0.0],
            [0.0, 9.8, 0.0],
            [0.0, -9.8, 0.3],
            [0.0, 0.0, 9.8],
        ]);
        assert_eq!(
            coverage.to_string(),
            "5 of 6 directions present, -z missing"
        );
        assert_eq!(coverage.missing_axis(), None);
        let flat = DirectionCoverage::of(&[
            [1.0, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, -1.0, 0.0],
        ]);
        assert_eq!(flat.missing_axis(), Some(2));
    }
}
