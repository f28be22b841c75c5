//! What to doubt about a multi-position fit.

use super::MultiPositionFit;
use proofmass_uncertainty::{Finding, Severity};
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Attitudes below which the literature advises more: nine parameters, and a third of that to check them.
const FEW: usize = 12;
/// A hole of this radius leaves an axis to be extrapolated.
const WIDE_HOLE_DEG: f64 = 75.0;
/// Family-wise probability of naming a standstill that is not out of line.
const OUTLIER_LEVEL: f64 = 0.01;
/// A standstill with this many times the median deviation was not still.
const RESTLESS: f64 = 3.0;

pub(super) fn of(fit: &MultiPositionFit) -> Vec<Finding> {
    [
        excess(fit),
        redundancy(fit),
        few_attitudes(fit),
        spread(fit),
        restless(fit),
    ]
    .into_iter()
    .flatten()
    .chain(outliers(fit))
    .collect()
}

fn excess(fit: &MultiPositionFit) -> Option<Finding> {
    let birge = fit.birge_ratio()?;
    (fit.excess() > 0.0).then(|| {
        Finding::new(
            Severity::Note,
            "excess-residuals",
            "the residuals exceed the noise of the standstill means, and the covariance carries the excess",
        )
        .evidence(format!(
            "Birge ratio {birge:.1}: χ² = {:.0} with {} degrees of freedom; {:.2} mm/s² common to all standstills was added",
            fit.chi_square(),
            fit.degrees_of_freedom(),
            1e3 * fit.excess(),
        ))
        .advice("usual for hand-held recordings (hysteresis, wander, a sensor that settles); it averages down with more attitudes, not with longer standstills")
    })
}

fn redundancy(fit: &MultiPositionFit) -> Option<Finding> {
    (fit.degrees_of_freedom() == 0).then(|| {
        Finding::new(
            Severity::Decision,
            "no-redundancy",
            "there are as many equations as parameters: nothing checks the fit",
        )
        .evidence(format!("{} standstills", fit.poses().len()))
        .advice("record more standstills, or choose a smaller model")
    })
}

fn few_attitudes(fit: &MultiPositionFit) -> Option<Finding> {
    let n = fit.poses().len();
    let known = fit.residuals().iter().any(|r| r.vector_residual.is_some());
    (n < FEW && !known).then(|| {
        Finding::new(Severity::Warning, "few-attitudes", "few attitudes")
            .evidence(format!(
                "{n} standstills for {} parameters",
                fit.form().parameters()
            ))
            .advice(format!("record at least {FEW} well-spread attitudes"))
    })
}

fn spread(fit: &MultiPositionFit) -> Option<Finding> {
    let coverage = fit.coverage();
    let severity = match coverage.missing.len() {
        0 if coverage.largest_hole_deg < WIDE_HOLE_DEG => return None,
        0 | 1 => Severity::Warning,
        // Only the bias model comes here: the others refuse.
        _ => Severity::Decision,
    };
    let [x, y, z] = coverage.hole_centre;
    Some(
        Finding::new(severity, "attitudes-badly-spread", "the attitudes leave a part of the sphere open")
            .evidence(format!(
                "{coverage}; no attitude within {:.0}° of ({x:+.2}, {y:+.2}, {z:+.2})",
                coverage.largest_hole_deg
            ))
            .advice("record standstills there; until then bias and scale factor of that axis lean on each other"),
    )
}

fn restless(fit: &MultiPositionFit) -> Option<Finding> {
    let poses = fit.poses();
    let median = |axis: usize| super::median(poses.iter().map(|p| p.deviation[axis]).collect());
    let medians = [median(0), median(1), median(2)];
    let ratio = |i: usize| {
        (0..3)
            .map(|axis| poses[i].deviation[axis] / medians[axis].max(f64::MIN_POSITIVE))
            .fold(0.0, f64::max)
    };
    let (worst, ratio) = (0..poses.len())
        .map(|i| (i, ratio(i)))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    (ratio > RESTLESS && medians.iter().all(|m| *m > 0.0)).then(|| {
        let segment = &poses[worst].segment;
        Finding::new(
            Severity::Warning,
            "restless-standstill",
            format!("standstill {} is not still", poses[worst].name(worst)),
        )
        .evidence(format!(
            "samples {} to {}: {ratio:.1} times the median deviation",
            segment.start, segment.end
        ))
        .advice("lay the sensor down instead of holding it, or leave this standstill out")
    })
}

fn outliers(fit: &MultiPositionFit) -> Vec<Finding> {
    let n = fit.poses().len() as f64;
    let nu = fit.degrees_of_freedom() as f64;
    let upper = 1.0 - 0.5 * OUTLIER_LEVEL / n;
    let limit = if fit.excess() > 0.0 && nu > 1.0 {
        StudentsT::new(0.0, 1.0, nu - 1.0).map(|d| d.inverse_cdf(upper))
    } else {
        Ok(Normal::standard().inverse_cdf(upper))
    };
    let Ok(limit) = limit else { return Vec::new() };
    fit.residuals()
        .iter()
        .filter_map(|r| {
            let t = r.studentised.filter(|t| t.abs() > limit)?;
            Some(
                Finding::new(
                    Severity::Warning,
                    "standstill-out-of-line",
                    format!("standstill {} is out of line", r.name),
                )
                .evidence(format!(
                    "samples {} to {}: ‖a‖ − g = {:+.2} mm/s², studentised residual {t:+.1} (limit {limit:.1})",
                    r.samples.0,
                    r.samples.1,
                    1e3 * r.magnitude_residual
                ))
                .advice("look at the recording there; it was kept in the fit"),
            )
        })
        .collect()
}
