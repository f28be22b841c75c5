//! Linearity over the level at one frequency.

use crate::findings;
use proofmass_core::{Error, check};
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding, Influence,
    chi_squared_quantile,
};

/// Output amplitudes over levels, as y = S a (1 + κ a).
///
/// Weighted least squares of y on a and a², each output with its own standard uncertainty. The non-linearity is the largest departure
/// of the measured points from the best straight line through zero, as a share of that line at the highest level.
///
/// **Units** levels in m/s², outputs and their uncertainties in one unit.
///
/// **Errors** [`Error::TooFew`] below four levels, [`Error::Length`], [`Error::NotFinite`], [`Error::OutOfRange`] for a level or an
/// uncertainty that is not positive, [`Error::Unobservable`] when all levels are alike.
///
/// **Accuracy** S and κ within their 95 % intervals in 500 simulated series (`coverage_linearity`).
///
/// **Source** `[ISO16063-21]`, clause on amplitude linearity by levels.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LevelLinearity {
    /// `sensitivity` and `amplitude_coefficient` κ in 1/(m/s²).
    pub estimate: Estimate,
    /// Largest departure from the best straight line through zero, as a share of it at the highest level.
    pub non_linearity: f64,
    /// Level, output over the best straight line less one, its standard uncertainty.
    pub departures: Vec<[f64; 3]>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl LevelLinearity {
    /// Fits.
    ///
    /// # Errors
    /// Those of the type.
    pub fn of(level: &[f64], output: &[f64], u: &[f64], unit: &str) -> Result<Self, Error> {
        let n = level.len();
        if n < 4 {
            return Err(Error::TooFew {
                name: "levels",
                needed: 4,
                got: n,
            });
        }
        for (name, column, positive) in [
            ("levels", level, true),
            ("outputs", output, false),
            ("uncertainties", u, true),
        ] {
            check::column(name, column, n)?;
            if let Some(value) = column.iter().find(|v| positive && !(**v > 0.0)) {
                return Err(Error::OutOfRange {
                    name,
                    value: *value,
                    min: f64::MIN_POSITIVE,
                    max: f64::MAX,
                });
            }
        }
        let top = level.iter().copied().fold(0.0, f64::max);
        // In shares of the highest level: y = p x + q x², κ = q/(p top).
        let (mut xx, mut xq, mut qq, mut xy, mut qy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for k in 0..n {
            let (x, w) = (level[k] / top, 1.0 / (u[k] * u[k]));
            xx += w * x * x;
            xq += w * x * x * x;
            qq += w * x * x * x * x;
            xy += w * x * output[k];
            qy += w * x * x * output[k];
        }
        let determinant = xx * qq - xq * xq;
        if !(determinant > 1e-9 * xx * qq) {
            return Err(Error::Unobservable {
                parameter: "amplitude_coefficient",
                condition: xx * qq / determinant.max(f64::MIN_POSITIVE),
            });
        }
        let (p, q) = (
            (qq * xy - xq * qy) / determinant,
            (xx * qy - xq * xy) / determinant,
        );
        let line = xy / xx;
        let chi: f64 = (0..n)
            .map(|k| {
                let x = level[k] / top;
                ((output[k] - p * x - q * x * x) / u[k]).powi(2)
            })
            .sum();
        let (vp, vq, vpq) = (qq / determinant, xx / determinant, -xq / determinant);
        let kappa = q / (p * top);
        // dS = dp/top; dκ = dq/(p top) − q dp/(p² top).
        let (sp, kp, kq) = (1.0 / top, -q / (p * p * top), 1.0 / (p * top));
        let rows = [
            sp * sp * vp,
            sp * (kp * vp + kq * vpq),
            sp * (kp * vp + kq * vpq),
            kp * kp * vp + 2.0 * kp * kq * vpq + kq * kq * vq,
        ];
        let estimate = Estimate::new(
            vec![
                Component::new("sensitivity", format!("{unit}/(m/s²)"), p / top),
                Component::new("amplitude_coefficient", "1/(m/s²)", kappa),
            ],
            vec![Influence {
                key: "outputs".into(),
                description: "stated uncertainties of the outputs".into(),
                evaluation: Evaluation::A,
                distribution: "normal".into(),
                dof: DegreesOfFreedom::INFINITE,
                effect: Effect::Joint {
                    covariance: Covariance::try_from_rows(2, &rows)?,
                },
            }],
        )?;
        let departures: Vec<[f64; 3]> = (0..n)
            .map(|k| {
                let straight = line * level[k] / top;
                [level[k], output[k] / straight - 1.0, u[k] / straight.abs()]
            })
            .collect();
        let non_linearity = (0..n)
            .map(|k| ((output[k] - line * level[k] / top) / line).abs())
            .fold(0.0, f64::max);
        let mut findings = Vec::new();
        let limit = chi_squared_quantile(0.999, (n - 2) as f64);
        if chi > limit {
            findings.push(findings::model_does_not_describe(
                "the outputs over level: they depart from a slope with one curvature by more than stated",
                &format!("χ² = {chi:.1}, at most {limit:.1} with {} degrees of freedom", n - 2),
                "look at the levels one by one: a threshold, a saturation, or too small uncertainties",
            ));
        }
        let uk = estimate.covariance().standard_uncertainty(1);
        if kappa.abs() > 3.3 * uk && (kappa * top).abs() > 1e-3 {
            findings.push(findings::sensitivity_depends_on_level(
                100.0 * kappa * top,
                (kappa / uk).abs(),
            ));
        }
        Ok(Self {
            estimate,
            non_linearity,
            departures,
            findings,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn series(seed: u64, kappa: f64, cubic: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let level: Vec<f64> = (1..=12).map(|k| 10.0 * f64::from(k)).collect();
        let u: Vec<f64> = level.iter().map(|a| 1e-3 + 2e-5 * a).collect();
        let output = level
            .iter()
            .zip(&u)
            .map(|(a, u)| {
                let e: f64 = StandardNormal.sample(&mut rng);
                0.01 * a * (1.0 + kappa * a + cubic * a * a) + u * e
            })
            .collect();
        (level, output, u)
    }

    #[test]
    fn coverage_linearity() {
        let (mut inside, mut alarms) = ([0; 2], 0);
        for seed in 0..500 {
            let (a, y, u) = series(seed, 1e-4, 0.0);
            let fit = LevelLinearity::of(&a, &y, &u, "V").unwrap();
            for (count, (q, t)) in inside
                .iter_mut()
                .zip(fit.estimate.quantities().iter().zip([0.01, 1e-4]))
            {
                *count += usize::from((q.value - t).abs() <= q.expanded(0.95));
            }
            let (a, y, u) = series(10_000 + seed, 0.0, 0.0);
            alarms += usize::from(
                !LevelLinearity::of(&a, &y, &u, "V")
                    .unwrap()
                    .findings
                    .is_empty(),
            );
        }
        // 95 % of 500 at 0.1 %: 459 to 490.
        assert!(inside.iter().all(|c| (459..=490).contains(c)), "{inside:?}");
        // Two findings of one in a thousand each.
        assert!(alarms <= 5, "{alarms}");
    }

    #[test]
    fn known_departures_are_named() {
        let code = |kappa, cubic| {
            let (a, y, u) = series(3, kappa, cubic);
            let fit = LevelLinearity::of(&a, &y, &u, "V").unwrap();
            fit.findings
                .iter()
                .map(|f| f.code().to_owned())
                .collect::<Vec<_>>()
        };
        assert!(code(1e-3, 0.0).contains(&"sensitivity-depends-on-level".to_owned()));
        assert!(code(0.0, -2e-4).contains(&"model-does-not-describe".to_owned()));
    }

    #[test]
    fn refuses_levels_that_say_nothing() {
        let ones = [1.0; 5];
        assert!(LevelLinearity::of(&ones, &ones, &ones, "V").is_err());
        assert!(LevelLinearity::of(&ones[..3], &ones[..3], &ones[..3], "V").is_err());
        assert!(LevelLinearity::of(&ones, &ones[..4], &ones, "V").is_err());
        assert!(LevelLinearity::of(&[1.0, 2.0, 3.0, 4.0, -5.0], &ones, &ones, "V").is_err());
        assert!(LevelLinearity::of(&[1.0, 2.0, 3.0, 4.0, 5.0], &ones, &[0.0; 5], "V").is_err());
    }
}
