//! The classical six positions, each axis up and down, in closed form; and Ferraris' way to write the result.

use crate::multi_position::{Model, MultiPosition, MultiPositionFit, Problem, Solved};
use crate::{Direction, Pose, Triple};
use faer::Mat;
use proofmass_core::Error;

impl MultiPosition {
    /// The six-position test in closed form: all twelve elements from each axis up and down.
    ///
    /// b_i = (ã₊ᵢ + ã₋ᵢ)_i / 2, and column j of K = (ã₊ⱼ − ã₋ⱼ) / 2g. Standstills of the same direction are
    /// averaged. χ², the excess and the degrees of freedom are those of the weighted least-squares fit to the same
    /// standstills; the covariance is that of the closed form.
    ///
    /// **Assumes** attitudes along the axes of the fixture; how far they may be off is declared through
    /// [`MultiPosition::attitude_uncertainty`].
    ///
    /// # Errors
    /// [`Error::Unobservable`] naming the scale factor of an axis of which one end is missing; the others of
    /// [`MultiPosition::fit`].
    ///
    /// **Source** `[Ferraris1995]`; `[IEEE1293]` (multi-point test).
    pub fn fit_six_positions(&self, poses: &[Pose]) -> Result<MultiPositionFit, Error> {
        let mut settings = self.clone().model(Model::Full);
        // The closed form takes every position for one of gravity.
        settings.lengths = None;
        let positions = positions(poses)?;
        let nominal: Vec<Pose> = poses
            .iter()
            .zip(&positions)
            .map(|(pose, direction)| {
                let mut pose = pose.clone();
                pose.segment.attitude = Some(direction.unit());
                pose
            })
            .collect();
        let problem = Problem::new(&settings, &nominal)?;
        let mut solved = Solved::independent(&settings, &problem)?;
        let estimator = closed_form(&positions);
        let (p, rows) = (estimator.nrows(), estimator.ncols());
        solved.solution.parameters = (0..p)
            .map(|i| {
                (0..rows)
                    .map(|j| estimator[(i, j)] * problem.point(j / 3)[j % 3])
                    .sum()
            })
            .collect();
        solved.solution.equations =
            problem.equations(&solved.solution.parameters, &solved.weighting)?;
        // Residuals are y − β − κu along the directions of the weighting; the parameters move by −G r.
        solved.gain = (0..p)
            .flat_map(|i| (0..rows).map(move |row| (i, row)))
            .map(|(i, row)| {
                let axis = solved.weighting.rotations[row / 3][row % 3];
                -(0..3)
                    .map(|k| estimator[(i, row / 3 * 3 + k)] * axis[k])
                    .sum::<f64>()
            })
            .collect();
        MultiPositionFit::assemble(&settings, &problem, solved)
    }
}

/// The direction of each standstill; every one of the six must occur.
fn positions(poses: &[Pose]) -> Result<Vec<Direction>, Error> {
    let positions: Vec<Option<Direction>> = poses
        .iter()
        .map(|pose| {
            let u = crate::direction_coverage::unit(pose.segment.attitude?)?;
            // Within 20° of a principal direction; further away the closed form means something else.
            Direction::ALL
                .into_iter()
                .find(|d| proofmass_core::dot(d.unit(), u) > 0.94)
        })
        .collect();
    for direction in Direction::ALL {
        if !positions.contains(&Some(direction)) {
            return Err(Error::Unobservable {
                parameter: crate::multi_position::ELEMENT[direction.axis][direction.axis],
                condition: f64::INFINITY,
            });
        }
    }
    positions
        .into_iter()
        .enumerate()
        .map(|(index, direction)| {
            direction.ok_or(Error::OutOfRange {
                name: "standstill outside of the six positions, number",
                value: index as f64 + 1.0,
                min: 0.0,
                max: 0.0,
            })
        })
        .collect()
}

/// The linear estimator: parameters (12) from stacked outputs (three per standstill).
fn closed_form(positions: &[Direction]) -> Mat<f64> {
    let weight = |direction: Direction| {
        let same = positions.iter().filter(|d| **d == direction).count();
        0.5 / same as f64
    };
    let mut estimator = Mat::zeros(Model::Full.parameters(), 3 * positions.len());
    for (pose, direction) in positions.iter().enumerate() {
        let w = weight(*direction);
        let axis = direction.axis;
        estimator[(axis, 3 * pose + axis)] = w;
        for (index, &(i, j)) in Model::Full.free_elements().iter().enumerate() {
            if j == axis {
                estimator[(3 + index, 3 * pose + i)] = if direction.up { w } else { -w };
            }
        }
    }
    estimator
}

/// Sensitivity matrix as Ferraris factors it, K = diag(k) R: scale of each output and its sensitive direction.
///
/// ```
/// use proofmass_static::Ferraris;
/// let f = Ferraris::of(&[[3.0, 4.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]]);
/// assert_eq!(f.scale, [5.0, 2.0, 1.0]);
/// assert_eq!(f.directions[0], [0.6, 0.8, 0.0]);
/// ```
///
/// **Source** `[Ferraris1995]`.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Ferraris {
    /// Length of each row of K, output unit per m/s².
    pub scale: Triple,
    /// Rows: unit vectors along the sensitive axes in the frame of the fixture.
    pub directions: [Triple; 3],
}

impl Ferraris {
    /// From the sensitivity matrix K (of a [`SensorModel`](proofmass_core::SensorModel), so no row is zero).
    pub fn of(k: &[Triple; 3]) -> Self {
        let scale = k.map(proofmass_core::norm);
        Self {
            scale,
            directions: std::array::from_fn(|i| k[i].map(|v| v / scale[i])),
        }
    }
}
