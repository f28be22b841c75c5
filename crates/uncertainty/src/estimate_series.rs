//! The same quantities at several values of one coordinate (frequency, temperature), with what is known of their
//! correlation.

use crate::algebra::symmetric_eigenvalues;
use crate::{Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Influence};
use faer::Mat;
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// One error that the points of a series have in common.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SharedEffect {
    /// Name of the cause.
    pub key: String,
    /// Per point, the change of every component by one standard uncertainty of the error.
    pub effects: Vec<Vec<f64>>,
}

/// The estimate at one value of the coordinate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SeriesPoint {
    /// The coordinate.
    pub at: f64,
    /// The components there, with their whole covariance.
    pub estimate: Estimate,
}

/// Estimates of the same components at ascending values of a coordinate.
///
/// cov(x_f, x_g) = Σ_s e_sf e_sgᵀ for f ≠ g, over the [`SharedEffect`]s; within a point the covariance of its
/// estimate holds, which contains them. Where nothing is known of the correlation of the points (`shared` is
/// `None`), whatever is derived from several of them carries the largest uncertainty that any correlation allows.
///
/// ```
/// use proofmass_uncertainty::{
///     Component, Covariance, DegreesOfFreedom, Effect, Estimate, EstimateSeries, Evaluation, Influence, SeriesPoint,
/// };
///
/// let point = |at: f64, value: f64| -> Result<SeriesPoint, proofmass_core::Error> {
///     let covariance = Covariance::from_standard_uncertainties(&[0.02])?;
///     let influence = Influence {
///         key: "reading".into(),
///         description: "reading".into(),
///         evaluation: Evaluation::A,
///         distribution: "normal".into(),
///         dof: DegreesOfFreedom::INFINITE,
///         effect: Effect::Joint { covariance },
///     };
///     let estimate = Estimate::new(vec![Component::new("S", "V", value)], vec![influence])?;
///     Ok(SeriesPoint { at, estimate })
/// };
/// let points = vec![point(10.0, 1.00)?, point(20.0, 1.02)?];
/// let unknown = EstimateSeries::new(points.clone(), None)?;
/// let independent = EstimateSeries::new(points, Some(vec![]))?;
/// let mean = |s: &EstimateSeries| s.combination(&[0.5, 0.5]).map(|e| e.get("S").unwrap().standard_uncertainty);
/// assert!((mean(&unknown)? - 0.02).abs() < 1e-15);
/// assert!((mean(&independent)? - 0.02 / 2f64.sqrt()).abs() < 1e-15);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[doc(alias("spectrum", "curve"))]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(try_from = "Parts", into = "Parts")]
pub struct EstimateSeries {
    points: Vec<SeriesPoint>,
    shared: Option<Vec<SharedEffect>>,
}

#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Parts {
    /// An estimate at each point.
    points: Vec<SeriesPoint>,
    /// Causes that all points share.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    shared: Option<Vec<SharedEffect>>,
}

impl From<EstimateSeries> for Parts {
    fn from(series: EstimateSeries) -> Self {
        Self {
            points: series.points,
            shared: series.shared,
        }
    }
}

impl TryFrom<Parts> for EstimateSeries {
    type Error = Error;
    fn try_from(parts: Parts) -> Result<Self, Error> {
        Self::new(parts.points, parts.shared)
    }
}

/// What rounding may leave of an eigenvalue of a covariance whose components have variance one.
const ROUNDING: f64 = 1e-9;

impl EstimateSeries {
    /// Points in any order; what they share in the order of the points.
    ///
    /// **Shapes** every point has the components of the first, in name, unit and order; `effects` has one vector of
    /// their number per point.
    ///
    /// # Errors
    /// [`Error::TooFew`] without a point, [`Error::NotFinite`], [`Error::NotIncreasing`] for a coordinate given
    /// twice, [`Error::Length`] for another number (or other names) of components,
    /// [`Error::NotPositiveDefinite`] where the shared effects exceed the covariance of a point.
    pub fn new(points: Vec<SeriesPoint>, shared: Option<Vec<SharedEffect>>) -> Result<Self, Error> {
        let Some(first) = points.first() else {
            return Err(Error::TooFew {
                name: "points of a series",
                needed: 1,
                got: 0,
            });
        };
        if let Some(index) = points.iter().position(|p| !p.at.is_finite()) {
            return Err(Error::NotFinite {
                name: "coordinate of a series",
                index,
            });
        }
        let names: Vec<(&str, &str)> = labels(&first.estimate).collect();
        let n = names.len();
        if let Some(other) = points
            .iter()
            .find(|p| !labels(&p.estimate).eq(names.iter().copied()))
        {
            return Err(Error::Length {
                name: "components of a point that the first one has too",
                expected: n,
                got: labels(&other.estimate)
                    .filter(|label| names.contains(label))
                    .count(),
            });
        }
        for effect in shared.iter().flatten() {
            if effect.effects.len() != points.len() {
                return Err(Error::Length {
                    name: "shared effect",
                    expected: points.len(),
                    got: effect.effects.len(),
                });
            }
            for (index, e) in effect.effects.iter().enumerate() {
                if e.len() != n {
                    return Err(Error::Length {
                        name: "shared effect at a point",
                        expected: n,
                        got: e.len(),
                    });
                }
                if e.iter().any(|v| !v.is_finite()) {
                    return Err(Error::NotFinite {
                        name: "shared effect",
                        index,
                    });
                }
            }
        }
        // In ascending order, the effects along.
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by(|&a, &b| points[a].at.total_cmp(&points[b].at));
        let shared = shared.map(|shared| {
            let sorted = |e: SharedEffect| SharedEffect {
                effects: order.iter().map(|&i| e.effects[i].clone()).collect(),
                key: e.key,
            };
            shared.into_iter().map(sorted).collect()
        });
        let points: Vec<SeriesPoint> = order.iter().map(|&i| points[i].clone()).collect();
        if let Some(i) = points.windows(2).position(|p| p[0].at == p[1].at) {
            return Err(Error::NotIncreasing {
                name: "coordinate of a series",
                index: i + 1,
            });
        }
        let series = Self { points, shared };
        for index in 0..series.points.len() {
            series.check_shared(index)?;
        }
        Ok(series)
    }

    /// The points in ascending order.
    pub fn points(&self) -> &[SeriesPoint] {
        &self.points
    }

    /// What the points share; `None` when nothing is known of their correlation, empty when they are independent.
    pub fn shared(&self) -> Option<&[SharedEffect]> {
        self.shared.as_deref()
    }

    /// Number of components.
    pub fn dimension(&self) -> usize {
        self.points[0].estimate.components().len()
    }

    /// Covariance of the components of two points, row-major (rows of the first); `None` where it is unknown.
    pub fn covariance(&self, first: usize, second: usize) -> Option<Vec<f64>> {
        if first == second {
            let covariance = self.points.get(first)?.estimate.covariance();
            return Some(covariance.elements().to_vec());
        }
        let n = self.dimension();
        let shared = self.shared.as_ref()?;
        let mut block = vec![0.0; n * n];
        for effect in shared {
            let (a, b) = (effect.effects.get(first)?, effect.effects.get(second)?);
            for p in 0..n {
                for q in 0..n {
                    block[n * p + q] += a[p] * b[q];
                }
            }
        }
        Some(block)
    }

    /// Σ_f w_f x_f, as for a mean over a band.
    ///
    /// Σ_f w_f² (C_f − Σ_s e_sf e_sfᵀ) + Σ_s (Σ_f w_f e_sf)(…)ᵀ where the correlation is known; otherwise
    /// (Σ|w|) Σ_f |w_f| C_f, which no correlation can exceed (Jensen's inequality).
    ///
    /// **Shapes** one weight per point; points of weight zero do not enter. Degrees of freedom are the smallest of
    /// the points that enter.
    ///
    /// # Errors
    /// [`Error::Length`], [`Error::NotFinite`], [`Error::TooFew`] when all weights are zero.
    pub fn combination(&self, weights: &[f64]) -> Result<Estimate, Error> {
        if weights.len() != self.points.len() {
            return Err(Error::Length {
                name: "weights of a series",
                expected: self.points.len(),
                got: weights.len(),
            });
        }
        proofmass_core::check::finite("weight", weights)?;
        let entering: Vec<(f64, &SeriesPoint)> = weights
            .iter()
            .copied()
            .zip(&self.points)
            .filter(|(w, _)| *w != 0.0)
            .collect();
        if entering.is_empty() {
            return Err(Error::TooFew {
                name: "points with a weight",
                needed: 1,
                got: 0,
            });
        }
        let components = self.points[0]
            .estimate
            .components()
            .iter()
            .enumerate()
            .map(|(i, c)| {
                let value = entering
                    .iter()
                    .map(|(w, p)| w * p.estimate.components()[i].value)
                    .sum();
                Component::new(c.name.clone(), c.unit.clone(), value)
            })
            .collect();
        let influences = match &self.shared {
            None => bounded(&entering, self.dimension())?,
            Some(shared) => self.known(weights, shared)?,
        };
        Estimate::new(components, influences)
    }

    fn known(&self, weights: &[f64], shared: &[SharedEffect]) -> Result<Vec<Influence>, Error> {
        let n = self.dimension();
        let (mut own, mut common) = (vec![0.0; n * n], vec![0.0; n * n]);
        for (f, (w, point)) in weights.iter().zip(&self.points).enumerate() {
            let covariance = point.estimate.covariance();
            for p in 0..n {
                for q in 0..n {
                    let part: f64 = shared
                        .iter()
                        .map(|s| s.effects[f][p] * s.effects[f][q])
                        .sum();
                    own[n * p + q] += w * w * (covariance[(p, q)] - part);
                }
            }
        }
        for effect in shared {
            let sum: Vec<f64> = (0..n)
                .map(|p| {
                    weights
                        .iter()
                        .zip(&effect.effects)
                        .map(|(w, e)| w * e[p])
                        .sum()
                })
                .collect();
            for p in 0..n {
                for q in 0..n {
                    common[n * p + q] += sum[p] * sum[q];
                }
            }
        }
        // The difference of two nearly equal variances is rounding: never below zero.
        for p in 0..n {
            own[n * p + p] = own[n * p + p].max(0.0);
        }
        let dof = weights
            .iter()
            .zip(&self.points)
            .filter(|(w, _)| **w != 0.0)
            .flat_map(|(_, p)| p.estimate.influences().iter().map(|i| i.dof))
            .fold(DegreesOfFreedom::INFINITE, least);
        let total: Vec<f64> = own.iter().zip(&common).map(|(a, b)| a + b).collect();
        // One joint influence: own and common part need not be semi-definite by themselves to the last digit.
        Ok(vec![Influence {
            key: "points".to_owned(),
            description: "all causes at the points, with their correlation".to_owned(),
            evaluation: Evaluation::B,
            distribution: "normal".to_owned(),
            dof,
            effect: Effect::Joint {
                covariance: Covariance::try_from_rows(n, &total)?,
            },
        }])
    }

    fn check_shared(&self, index: usize) -> Result<(), Error> {
        let shared = self.shared.as_deref().unwrap_or_default();
        if shared.is_empty() {
            return Ok(());
        }
        let covariance = self.points[index].estimate.covariance();
        let n = covariance.dimension();
        let refuse = |row: usize, value: f64| Error::NotPositiveDefinite {
            name: "covariance of a point without what it shares",
            row,
            column: row,
            value,
        };
        for i in 0..n {
            let part: f64 = shared.iter().map(|s| s.effects[index][i].powi(2)).sum();
            if part > covariance[(i, i)] * (1.0 + ROUNDING) {
                return Err(refuse(i, covariance[(i, i)] - part));
            }
        }
        let active: Vec<usize> = (0..n).filter(|&i| covariance[(i, i)] > 0.0).collect();
        let rest = Mat::from_fn(active.len(), active.len(), |a, b| {
            let (p, q) = (active[a], active[b]);
            let part: f64 = shared
                .iter()
                .map(|s| s.effects[index][p] * s.effects[index][q])
                .sum();
            (covariance[(p, q)] - part)
                / (covariance.standard_uncertainty(p) * covariance.standard_uncertainty(q))
        });
        let eigenvalues = symmetric_eigenvalues(&rest, "eigenvalues of the covariance")?;
        match eigenvalues.first() {
            Some(&smallest) if smallest < -ROUNDING * n as f64 => Err(refuse(0, smallest)),
            _ => Ok(()),
        }
    }
}

fn labels(estimate: &Estimate) -> impl Iterator<Item = (&str, &str)> {
    estimate
        .components()
        .iter()
        .map(|c| (c.name.as_str(), c.unit.as_str()))
}

fn least(a: DegreesOfFreedom, b: DegreesOfFreedom) -> DegreesOfFreedom {
    if b.get() < a.get() { b } else { a }
}

/// Cause by cause, (Σ|w|) Σ |w_f| C_f.
fn bounded(entering: &[(f64, &SeriesPoint)], n: usize) -> Result<Vec<Influence>, Error> {
    let all: f64 = entering.iter().map(|(w, _)| w.abs()).sum();
    let mut sums: Vec<(Influence, Covariance)> = Vec::new();
    for (w, point) in entering {
        for influence in point.estimate.influences() {
            let part = influence.effect.covariance(n)?.scaled(all * w.abs())?;
            match sums.iter_mut().find(|(i, _)| i.key == influence.key) {
                Some((first, sum)) => {
                    *sum = sum.plus(&part)?;
                    first.dof = least(first.dof, influence.dof);
                }
                None => sums.push((influence.clone(), part)),
            }
        }
    }
    Ok(sums
        .into_iter()
        .map(|(influence, covariance)| Influence {
            effect: Effect::Joint { covariance },
            ..influence
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(at: f64, value: f64, covariance: &[f64]) -> SeriesPoint {
        let influence = Influence::normal(
            "all",
            "all",
            Effect::Joint {
                covariance: Covariance::try_from_rows(2, covariance).unwrap(),
            },
        );
        let components = vec![
            Component::new("re", "V", value),
            Component::new("im", "V", -value),
        ];
        SeriesPoint {
            at,
            estimate: Estimate::new(components, vec![influence]).unwrap(),
        }
    }

    fn shared() -> Vec<SharedEffect> {
        vec![SharedEffect {
            key: "angle".into(),
            effects: vec![vec![0.3, 0.1], vec![0.2, -0.1]],
        }]
    }

    fn points() -> Vec<SeriesPoint> {
        vec![
            point(20.0, 2.0, &[0.10, 0.03, 0.03, 0.05]),
            point(10.0, 1.0, &[0.08, -0.02, -0.02, 0.04]),
        ]
    }

    #[test]
    fn law_a_difference_of_correlated_points_loses_what_they_share() {
        let series = EstimateSeries::new(points(), Some(shared())).unwrap();
        // Sorted: the first point is now that of 10, with the second effect.
        assert_eq!(series.points()[0].at, 10.0);
        let block = series.covariance(0, 1).unwrap();
        let expected = [0.2 * 0.3, 0.2 * 0.1, -0.1 * 0.3, -0.1 * 0.1];
        for (b, e) in block.iter().zip(expected) {
            assert!((b - e).abs() < 1e-15);
        }
        let difference = series.combination(&[-1.0, 1.0]).unwrap();
        let u = difference.get("re").unwrap().standard_uncertainty;
        // var(x_g − x_f) = C_f + C_g − 2 cov.
        let direct: f64 = 0.08 + 0.10 - 2.0 * 0.06;
        assert!((u - direct.sqrt()).abs() < 1e-12);
        assert_eq!(difference.get("re").unwrap().value, 1.0);
    }

    #[test]
    fn law_no_correlation_exceeds_the_bound() {
        let unknown = EstimateSeries::new(points(), None).unwrap();
        assert!(unknown.covariance(0, 1).is_none() && unknown.covariance(1, 1).is_some());
        let known = EstimateSeries::new(points(), Some(shared())).unwrap();
        for weights in [[0.5, 0.5], [0.2, 0.8], [1.0, -1.0], [0.0, 1.0]] {
            let (a, b) = (
                unknown.combination(&weights).unwrap(),
                known.combination(&weights).unwrap(),
            );
            for name in ["re", "im"] {
                let (a, b) = (a.get(name).unwrap(), b.get(name).unwrap());
                assert_eq!(a.value, b.value);
                assert!(a.standard_uncertainty >= b.standard_uncertainty * (1.0 - 1e-12));
            }
        }
    }

    #[test]
    fn refuses_what_does_not_fit_together() {
        let mut large = shared();
        large[0].effects[0] = vec![0.4, 0.0];
        assert!(matches!(
            EstimateSeries::new(points(), Some(large)),
            Err(Error::NotPositiveDefinite { .. })
        ));
        assert!(EstimateSeries::new(vec![], None).is_err());
        let twice = vec![points()[0].clone(), points()[0].clone()];
        assert!(matches!(
            EstimateSeries::new(twice, None),
            Err(Error::NotIncreasing { .. })
        ));
        let series = EstimateSeries::new(points(), Some(shared())).unwrap();
        assert!(series.combination(&[1.0]).is_err());
        assert!(series.combination(&[0.0, 0.0]).is_err());
        let text = serde_json::to_string(&series).unwrap();
        assert_eq!(
            serde_json::from_str::<EstimateSeries>(&text).unwrap(),
            series
        );
    }
}
