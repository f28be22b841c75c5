//! The independent causes of the uncertainty of a multi-position fit.

use super::{MultiPosition, Problem, Solved};
use crate::Triple;
use faer::Mat;
use proofmass_core::{Error, Matrix3};
use proofmass_uncertainty::{Covariance, Effect, Evaluation, Influence};

/// Key of the influence that holds everything the residuals show.
pub(crate) const STANDSTILLS: &str = "standstills";

/// The independent causes of uncertainty as seen in the natural parameters.
pub(super) fn causes(
    settings: &MultiPosition,
    problem: &Problem<'_>,
    solved: &Solved,
) -> Result<Vec<Influence>, Error> {
    let kappa = Matrix3(problem.model.matrix(&solved.solution.parameters));
    let mut causes = vec![
        Influence {
            key: STANDSTILLS.to_owned(),
            description: "standstills: noise of their means and what varies between them"
                .to_owned(),
            evaluation: Evaluation::A,
            distribution: "normal".to_owned(),
            dof: solved.dof,
            effect: Effect::Joint {
                covariance: covariance_of(&solved.covariance())?,
            },
        },
        gravity(settings, problem, solved, &kappa),
    ];
    if settings.lengthening > 0.0 {
        // As a larger gravity, that nobody measured.
        let mut motion = gravity(settings, problem, solved, &kappa);
        motion.key = "motion".to_owned();
        motion.description = "accelerations across gravity, which lengthen a reading".to_owned();
        if let Effect::Scalar {
            value,
            standard_uncertainty,
            ..
        } = &mut motion.effect
        {
            (*value, *standard_uncertainty) = (0.0, settings.lengthening);
        }
        causes.push(motion);
    }
    if let Some(attitudes) = &problem.attitudes
        && settings.attitude.common > 0.0
    {
        let turned = frame_rotation(problem, solved, &kappa, attitudes, settings.attitude.common);
        causes.push(Influence::normal(
            "attitude-common",
            "orientation of the frame of all attitudes",
            Effect::Joint {
                covariance: covariance_of(&turned)?,
            },
        ));
    }
    Ok(causes)
}

/// Gravity: ∂r/∂g = −1/g per equation (unknown attitudes), −κu/g (known), carried through the gain; what takes its place where
/// the lengths of true accelerations count.
fn gravity(
    settings: &MultiPosition,
    problem: &Problem<'_>,
    solved: &Solved,
    kappa: &Matrix3<f64>,
) -> Influence {
    let g = settings.gravity.value();
    if let (Some(common), Some(forces)) = (settings.lengths, &problem.attitudes) {
        let by_length = along_rotations(solved, forces, |u| kappa.times(u).map(|v| -v));
        return Influence::normal(
            "true-acceleration",
            "lengths of all true accelerations",
            Effect::Scalar {
                value: 1.0,
                unit: "1".to_owned(),
                standard_uncertainty: common,
                sensitivity: solved.through(&by_length),
            },
        );
    }
    let by_gravity: Vec<f64> = match &problem.attitudes {
        None => vec![-1.0 / g; problem.rows()],
        Some(attitudes) => along_rotations(solved, attitudes, |u| kappa.times(u).map(|v| -v / g)),
    };
    Influence::normal(
        "gravity",
        "local gravity",
        Effect::Scalar {
            value: g,
            unit: "m/s²".to_owned(),
            standard_uncertainty: settings.gravity.standard_uncertainty(),
            sensitivity: solved.through(&by_gravity),
        },
    )
}

/// What f makes of each given attitude, along the directions in which the equations are taken.
fn along_rotations(
    solved: &Solved,
    attitudes: &[Triple],
    f: impl Fn(Triple) -> Triple,
) -> Vec<f64> {
    let pairs = attitudes.iter().zip(&solved.weighting.rotations);
    pairs
        .flat_map(|(u, rotation)| {
            let d = f(*u);
            rotation.map(|axis| proofmass_core::dot(axis, d))
        })
        .collect()
}

/// Covariance of the parameters from one rotation of all attitudes, `u` rad about each axis.
fn frame_rotation(
    problem: &Problem<'_>,
    solved: &Solved,
    kappa: &Matrix3<f64>,
    attitudes: &[Triple],
    u: f64,
) -> Mat<f64> {
    let p = problem.parameters();
    let mut sum = Mat::zeros(p, p);
    for axis in 0..3 {
        let by_angle = along_rotations(solved, attitudes, |a| {
            // e_axis × a
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut turned = [0.0; 3];
            turned[i] = -a[j];
            turned[j] = a[i];
            kappa.times(turned).map(|v| -v)
        });
        let s = solved.through(&by_angle);
        sum += Mat::from_fn(p, p, |i, j| s[i] * s[j] * u * u);
    }
    sum
}

fn covariance_of(m: &Mat<f64>) -> Result<Covariance, Error> {
    let n = m.nrows();
    let rows: Vec<f64> = (0..n)
        .flat_map(|i| (0..n).map(move |j| 0.5 * (m[(i, j)] + m[(j, i)])))
        .collect();
    Covariance::try_from_rows(n, &rows)
}

/// A parameter so uncertain that the linear model itself fails is not a result.
pub(super) fn check_determined(
    problem: &Problem<'_>,
    limit: f64,
    causes: &[Influence],
) -> Result<(), Error> {
    let p = problem.parameters();
    let mut variance = vec![0.0; p];
    for cause in causes {
        let covariance = cause.effect.covariance(p)?;
        for (i, v) in variance.iter_mut().enumerate() {
            *v += covariance[(i, i)];
        }
    }
    let worst = (0..p)
        .max_by(|&a, &b| variance[a].total_cmp(&variance[b]))
        .unwrap_or(0);
    let u = variance[worst].sqrt();
    if !(u <= limit) {
        return Err(Error::TooUncertain {
            parameter: problem.parameter_name(worst),
            uncertainty: u,
            limit,
        });
    }
    Ok(())
}
