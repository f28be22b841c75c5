//! Two calibrations over frequency, held against each other.

use super::FrequencyResponse;
use super::interpolation::Interpolation;
use crate::findings;
use num_complex::Complex64;
use proofmass_core::{Error, check};
use proofmass_signal::transfer::{polar, turned};
use proofmass_uncertainty::adjustment::{cholesky, solve};
use proofmass_uncertainty::{
    DegreesOfFreedom, En, Finding, Quantity, chi_squared_chance, chi_squared_quantile,
};
use serde::Serialize;
use std::f64::consts::{PI, TAU};

/// One element at one frequency, as both calibrations have it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ComparedPoint {
    /// Hz.
    pub frequency: f64,
    /// Name of the element: `K`, or `K.xy` for output x and acceleration along y.
    pub element: String,
    /// Both values.
    pub value: [Complex64; 2],
    /// (|K₁| − |K₂|)/|K₂|.
    pub modulus_difference: f64,
    /// Its expanded uncertainty.
    pub modulus_expanded: f64,
    /// That over its standard uncertainty: k of the two calibrations, weighted as their uncertainties.
    pub modulus_coverage_factor: f64,
    /// E_n of the moduli.
    pub modulus_en: f64,
    /// The same as if nothing were common, where common causes are taken out here.
    pub modulus_en_independent: Option<f64>,
    /// Of the phases; `None` where moduli alone are compared.
    pub phase: Option<ComparedPhase>,
    /// dᵀ(C₁ + C₂)⁻¹d of real and imaginary part, χ² with two degrees of freedom; of the moduli alone, with one.
    pub chi_square: f64,
}

/// The phases of one element at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ComparedPhase {
    /// Phase of K₁ against that of K₂, rad.
    pub difference: f64,
    /// Its expanded uncertainty.
    pub expanded: f64,
    /// That over its standard uncertainty.
    pub coverage_factor: f64,
    /// E_n of the phases.
    pub en: f64,
    /// The same as if nothing were common, where common causes are taken out here.
    pub en_independent: Option<f64>,
}

/// All differences together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ComparedWhole {
    /// dᵀ C⁻¹ d over all frequencies and elements.
    pub chi_square: f64,
    /// Number of differences.
    pub freedom: usize,
    /// Exceeded by chance once in a hundred.
    pub limit: f64,
}

/// Two calibrations of the same device, held against each other where both are known.
///
/// Compared at the frequencies of the one that has fewer within the range of both; where the other has to be interpolated, the bound
/// of the error of that is among the uncertainties. The whole is judged by χ² when both say what their frequencies have in common; where one does not, by
/// the number of moduli, and of phases, with |E_n| above 1, as if the frequencies were independent, and by the smallest of all chances.
/// Each |E_n| above 1 is named as well, and one factor that all differences have in common.
///
/// **Assumes** nothing in common between the two but what [`ResponseComparison::without_common`] is told: a reference standard that both go
/// back to makes E_n too small.
///
/// **Accuracy** at most 1 % of agreeing pairs raise `calibrations-differ` (`coverage_of_agreeing_calibrations`).
///
/// **Source** E_n `[ISO13528] 9.7`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ResponseComparison {
    /// Frequency by frequency, element by element.
    pub points: Vec<ComparedPoint>,
    /// χ² of everything; `None` where a calibration does not say what its frequencies share.
    pub whole: Option<ComparedWhole>,
    /// Whether they differ by more than chance.
    pub differ: bool,
    /// Probability of the expanded uncertainties.
    pub probability: f64,
    /// Unit of both.
    pub unit: String,
    /// Causes of uncertainty that are one error of both and out of U of the differences.
    pub common: Vec<String>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

/// Chance of the finding where nothing differs: of χ² of the whole, of the count of moduli or of phases that are off, and of the single
/// point that is furthest off.
const OF_WHOLE: f64 = 0.01;
const OF_COUNT: f64 = 0.005;
const OF_POINT: f64 = 1e-3;

/// Elements and what is common to the frequencies, at one of them.
pub(super) struct Seen {
    pub(super) matrix: Vec<Complex64>,
    pub(super) covariance: Vec<f64>,
    /// One per shared effect.
    shared: Vec<Vec<f64>>,
    pub(super) dof: f64,
    /// Its point, where nothing is interpolated.
    place: Option<usize>,
}

impl ResponseComparison {
    /// Compares.
    ///
    /// # Errors
    /// [`Error::Length`] for other outputs and axes, [`Error::OutOfRange`] for a probability outside (0, 1) or ranges that do not
    /// meet, [`Error::NotPositiveDefinite`] where neither states an uncertainty.
    pub fn of(
        first: &FrequencyResponse,
        second: &FrequencyResponse,
        probability: f64,
    ) -> Result<Self, Error> {
        Self::compare(first, second, probability, true, &[])
    }

    /// Compares the moduli alone, where one of the two states no phase. The whole is judged by the count of moduli and the smallest chance.
    ///
    /// # Errors
    /// As [`ResponseComparison::of`].
    pub fn of_moduli(
        first: &FrequencyResponse,
        second: &FrequencyResponse,
        probability: f64,
    ) -> Result<Self, Error> {
        Self::compare(first, second, probability, false, &[])
    }

    /// Compares two calibrations that share causes of uncertainty, such as the calibration of one reference standard: each is one error of
    /// both, and goes out of U of their differences.
    ///
    /// `causes` are keys of influences that both have, or what stands before a dot of them: `reference` is also `reference.calibration`. An
    /// error that changes both by the same factor goes out as a whole; of another, what the symmetric roots of its two covariances, relative
    /// to the values, have in common. Where one of the two is interpolated nothing goes out. The whole is then judged point by point.
    ///
    /// # Errors
    /// As [`ResponseComparison::of`]; [`Error::OutOfRange`] where nothing is left of U of a difference.
    ///
    /// **Source** covariance of two results `[GUM] 5.2.2`.
    pub fn without_common(
        first: &FrequencyResponse,
        second: &FrequencyResponse,
        probability: f64,
        phases: bool,
        causes: &[String],
    ) -> Result<Self, Error> {
        Self::compare(first, second, probability, phases, causes)
    }

    /// Keys of the influences that both calibrations name at some frequency, each once.
    pub fn causes_of_both(first: &FrequencyResponse, second: &FrequencyResponse) -> Vec<String> {
        let [a, b] = [first, second].map(keys);
        a.into_iter().filter(|key| b.contains(key)).collect()
    }

    fn compare(
        first: &FrequencyResponse,
        second: &FrequencyResponse,
        probability: f64,
        phases: bool,
        causes: &[String],
    ) -> Result<Self, Error> {
        check::probability(probability)?;
        let elements = first.outputs().len() * first.axes().len();
        let others = second.outputs().len() * second.axes().len();
        if elements != others || first.outputs().len() != second.outputs().len() {
            return Err(Error::Length {
                name: "elements of the second response",
                expected: elements,
                got: others,
            });
        }
        let frequencies = common_frequencies(&[first, second])?;
        let names = element_names(first);
        let pair = [Side::new(first), Side::new(second)];
        let shared_keys: Vec<String> = match causes.is_empty() {
            true => Vec::new(),
            false => Self::causes_of_both(first, second)
                .into_iter()
                .filter(|key| causes.iter().any(|cause| is_of(key, cause)))
                .collect(),
        };
        let (mut points, mut blocks) = (Vec::new(), Vec::new());
        for f in &frequencies {
            let seen = [pair[0].look(*f)?, pair[1].look(*f)?];
            for (e, name) in names.iter().enumerate() {
                let at = (*f, name.as_str());
                let shared = shared_error([first, second], &seen, e, &shared_keys)?;
                let of = |shared| point(&seen, (e, elements), at, probability, (phases, shared));
                let mut compared = of(shared)?;
                if shared.is_some() {
                    let independent = of(None)?;
                    compared.modulus_en_independent = Some(independent.modulus_en);
                    if let Some(phase) = &mut compared.phase {
                        phase.en_independent = independent.phase.map(|p| p.en);
                    }
                }
                points.push(compared);
            }
            blocks.push(seen);
        }
        let known = first.series().shared().is_some() && second.series().shared().is_some();
        let whole = if known && phases && causes.is_empty() {
            Some(together(&blocks, 2 * elements)?)
        } else {
            None
        };
        let count = points.len() as f64;
        let worst = points
            .iter()
            .max_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
        let off = beyond(&points);
        let limit = binomial_limit(points.len(), 1.0 - probability);
        let differ = match (&whole, worst) {
            (Some(whole), _) => whole.chi_square > whole.limit,
            // Of all points at most their number times the smallest chance.
            (None, Some(worst)) => {
                count * chi_squared_chance(worst.chi_square, if phases { 2.0 } else { 1.0 })
                    < OF_POINT
                    || off.iter().any(|n| *n >= limit)
            }
            (None, None) => false,
        };
        let findings = findings(
            &points,
            whole.as_ref(),
            differ,
            worst,
            (off, limit),
            probability,
            causes,
        );
        Ok(Self {
            common: causes.to_vec(),
            points,
            whole,
            differ,
            probability,
            unit: first.unit().to_owned(),
            findings,
        })
    }
}

/// Keys of the influences of a response, each once.
fn keys(response: &FrequencyResponse) -> Vec<String> {
    let mut keys: Vec<String> = Vec::new();
    for point in response.series().points() {
        for influence in point.estimate.influences() {
            if !keys.contains(&influence.key) {
                keys.push(influence.key.clone());
            }
        }
    }
    keys
}

/// Whether a key is that of a cause, or of a part of it behind a dot.
fn is_of(key: &str, cause: &str) -> bool {
    let rest = key.strip_prefix(cause);
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// Covariance of an element in the two calibrations from the errors that both share, relative modulus and phase of the first (rows) against
/// those of the second; `None` where nothing is shared, or one is interpolated.
fn shared_error(
    pair: [&FrequencyResponse; 2],
    seen: &[Seen; 2],
    element: usize,
    keys: &[String],
) -> Result<Option<[[f64; 2]; 2]>, Error> {
    let (Some(first), Some(second)) = (seen[0].place, seen[1].place) else {
        return Ok(None);
    };
    let places = [first, second];
    let mut sum: Option<[[f64; 2]; 2]> = None;
    for key in keys {
        let mut roots = [[[0.0; 2]; 2]; 2];
        for (root, (response, (seen, place))) in roots
            .iter_mut()
            .zip(pair.iter().zip(seen.iter().zip(places)))
        {
            let z = seen.matrix[element];
            *root = square_root(relative(response, place, element, key, z)?);
        }
        let [a, b] = roots;
        let of = sum.get_or_insert([[0.0; 2]; 2]);
        for (i, row) in of.iter_mut().enumerate() {
            for (j, cell) in row.iter_mut().enumerate() {
                *cell += a[i][0] * b[0][j] + a[i][1] * b[1][j];
            }
        }
    }
    Ok(sum)
}

/// Covariance of relative modulus and phase of an element by one influence.
fn relative(
    response: &FrequencyResponse,
    place: usize,
    element: usize,
    key: &str,
    z: Complex64,
) -> Result<[f64; 3], Error> {
    let estimate = &response.series().points()[place].estimate;
    let n = estimate.components().len();
    let p = 2 * element;
    let mut parts = [0.0; 3];
    for influence in estimate.influences().iter().filter(|i| i.key == key) {
        let c = influence.effect.covariance(n)?;
        parts[0] += c[(p, p)];
        parts[1] += c[(p, p + 1)];
        parts[2] += c[(p + 1, p + 1)];
    }
    if z.norm() == 0.0 {
        return Ok([0.0; 3]);
    }
    Ok(turned(parts, 1.0 / z))
}

/// Symmetric root of a covariance of two: (C + √det C · 1)/√(tr C + 2 √det C).
fn square_root([aa, ab, bb]: [f64; 3]) -> [[f64; 2]; 2] {
    let root = (aa * bb - ab * ab).max(0.0).sqrt();
    let size = (aa + bb + 2.0 * root).max(0.0).sqrt();
    if size == 0.0 {
        return [[0.0; 2]; 2];
    }
    [
        [(aa + root) / size, ab / size],
        [ab / size, (bb + root) / size],
    ]
}

/// Frequencies of the sparsest response within the range of all.
pub(super) fn common_frequencies(responses: &[&FrequencyResponse]) -> Result<Vec<f64>, Error> {
    let (mut low, mut high) = (0.0f64, f64::INFINITY);
    for response in responses {
        let [a, b] = response.range();
        (low, high) = (low.max(a), high.min(b));
    }
    let within = low * (1.0 - 1e-9)..=high * (1.0 + 1e-9);
    let each = responses
        .iter()
        .map(|r| -> Vec<f64> { r.frequencies().filter(|f| within.contains(f)).collect() });
    let sparsest = each.filter(|list| !list.is_empty()).min_by_key(Vec::len);
    sparsest.ok_or(Error::TooFew {
        name: "frequencies that all calibrations have in common",
        needed: 1,
        got: 0,
    })
}

pub(super) fn element_names(response: &FrequencyResponse) -> Vec<String> {
    FrequencyResponse::names(response.outputs(), response.axes())
        .into_iter()
        .step_by(2)
        .map(|name| name.trim_end_matches(".re").to_owned())
        .collect()
}

/// One of the calibrations.
pub(super) struct Side<'a> {
    response: &'a FrequencyResponse,
    interpolation: Interpolation<'a>,
    /// Bound of the relative error in every interval.
    error: Vec<f64>,
}

impl<'a> Side<'a> {
    pub(super) fn new(response: &'a FrequencyResponse) -> Self {
        Self {
            response,
            interpolation: Interpolation::new(response),
            error: response.interpolation_error().unwrap_or_default(),
        }
    }

    pub(super) fn look(&self, f: f64) -> Result<Seen, Error> {
        let points = self.response.series().points();
        let (before, after) = self.interpolation.neighbours(f);
        let matrix = self.interpolation.matrix(f);
        let mut covariance = self.interpolation.covariance(f)?.elements().to_vec();
        // Share of the upper neighbour, as the covariance has it.
        let share = if before == after {
            0.0
        } else {
            let ratio = (f / points[before].at).ln();
            (ratio / (points[after].at / points[before].at).ln()).clamp(0.0, 1.0)
        };
        let between = (1e-6..=1.0 - 1e-6).contains(&share);
        if let (true, Some(bound)) = (between, self.error.get(before)) {
            let n = 2 * matrix.len();
            for k in 0..n {
                covariance[n * k + k] += (bound * matrix[k / 2].norm()).powi(2) / 3.0;
            }
        }
        let shared = self.response.series().shared().unwrap_or_default();
        let shared = shared
            .iter()
            .map(|effect| {
                let parts = effect.effects[before].iter().zip(&effect.effects[after]);
                parts.map(|(a, b)| a + share * (b - a)).collect()
            })
            .collect();
        let dof = [(before, 1.0 - share), (after, share)]
            .into_iter()
            .filter(|(_, weight)| *weight > 1e-6)
            .flat_map(|(i, _)| points[i].estimate.quantities())
            .map(|q| q.dof.get())
            .fold(f64::INFINITY, f64::min);
        let place = match share {
            _ if between => None,
            share if share < 0.5 => Some(before),
            _ => Some(after),
        };
        Ok(Seen {
            matrix,
            covariance,
            shared,
            dof,
            place,
        })
    }
}

fn point(
    seen: &[Seen; 2],
    (element, elements): (usize, usize),
    (frequency, name): (f64, &str),
    probability: f64,
    (phases, shared): (bool, Option<[[f64; 2]; 2]>),
) -> Result<ComparedPoint, Error> {
    let n = 2 * elements;
    let (r, i) = (2 * element, 2 * element + 1);
    let of = |s: &Seen| {
        [
            s.covariance[n * r + r],
            s.covariance[n * r + i],
            s.covariance[n * i + i],
        ]
    };
    let z = [seen[0].matrix[element], seen[1].matrix[element]];
    let c = [of(&seen[0]), of(&seen[1])];
    let quantity = |value: f64, u: f64, s: &Seen| Quantity {
        name: name.to_owned(),
        unit: String::new(),
        value,
        standard_uncertainty: u,
        dof: DegreesOfFreedom::new(s.dof).unwrap_or(DegreesOfFreedom::INFINITE),
    };
    let u = [polar(z[0], c[0]), polar(z[1], c[1])];
    let common = shared.unwrap_or_default();
    // Never more than both have, but for rounding.
    let within = |common: f64, a: f64, b: f64| common.min(a * b);
    let of_modulus = within(z[0].norm() * z[1].norm() * common[0][0], u[0].0, u[1].0);
    let of_phase = within(common[1][1], u[0].1, u[1].1);
    let modulus = En::new(
        &quantity(z[0].norm(), u[0].0, &seen[0]),
        &quantity(z[1].norm(), u[1].0, &seen[1]),
        of_modulus,
        probability,
    )?;
    let spread = |a: f64, b: f64, common: f64| (a * a + b * b - 2.0 * common).sqrt();
    let size = z[1].norm().max(f64::MIN_POSITIVE);
    let of_moduli = ComparedPoint {
        frequency,
        element: name.to_owned(),
        value: z,
        modulus_difference: modulus.difference / size,
        modulus_expanded: modulus.expanded / size,
        modulus_coverage_factor: modulus.expanded / spread(u[0].0, u[1].0, of_modulus),
        modulus_en: modulus.value,
        modulus_en_independent: None,
        phase: None,
        chi_square: ((z[0].norm() - z[1].norm()) / spread(u[0].0, u[1].0, of_modulus)).powi(2),
    };
    if !phases {
        return Ok(of_moduli);
    }
    let turn = (z[0] * z[1].conj()).arg().rem_euclid(TAU);
    let turn = if turn > PI { turn - TAU } else { turn };
    let phase = En::new(
        &quantity(turn, u[0].1, &seen[0]),
        &quantity(0.0, u[1].1, &seen[1]),
        of_phase,
        probability,
    )?;
    let d = z[0] - z[1];
    let out = in_parts(z, common);
    let [rr, ri, ii] = [0, 1, 2].map(|k| c[0][k] + c[1][k] - out[k]);
    let determinant = rr * ii - ri * ri;
    if !(rr > 0.0 && determinant > 0.0) {
        return Err(Error::NotPositiveDefinite {
            name: "covariance of the difference of two responses",
            row: r,
            column: i,
            value: determinant,
        });
    }
    Ok(ComparedPoint {
        phase: Some(ComparedPhase {
            difference: phase.difference,
            expanded: phase.expanded,
            coverage_factor: phase.expanded / spread(u[0].1, u[1].1, of_phase),
            en: phase.value,
            en_independent: None,
        }),
        chi_square: (ii * d.re * d.re - 2.0 * ri * d.re * d.im + rr * d.im * d.im) / determinant,
        ..of_moduli
    })
}

/// What a shared error takes out of the covariance of a difference, rr, ri, ii: X + Xᵀ with X in real and imaginary parts.
fn in_parts(z: [Complex64; 2], common: [[f64; 2]; 2]) -> [f64; 3] {
    // dz = z (d|z|/|z| + j dφ): the columns are those of z and jz.
    let columns = |z: Complex64| [[z.re, -z.im], [z.im, z.re]];
    let [a, b] = z.map(columns);
    let x = |i: usize, j: usize| -> f64 {
        let mut sum = 0.0;
        for (k, row) in common.iter().enumerate() {
            for (l, c) in row.iter().enumerate() {
                sum += a[i][k] * c * b[j][l];
            }
        }
        sum
    };
    [2.0 * x(0, 0), x(0, 1) + x(1, 0), 2.0 * x(1, 1)]
}

/// χ² of all differences: blocks of the frequencies, joined by what each calibration has in common (Woodbury).
fn together(blocks: &[[Seen; 2]], n: usize) -> Result<ComparedWhole, Error> {
    let effects = blocks
        .first()
        .map_or(0, |b| b[0].shared.len() + b[1].shared.len());
    let (mut square, mut inner) = (0.0, vec![0.0; effects * effects]);
    let mut right = vec![0.0; effects];
    for e in 0..effects {
        inner[effects * e + e] = 1.0;
    }
    for [a, b] in blocks {
        let shared: Vec<&Vec<f64>> = a.shared.iter().chain(&b.shared).collect();
        let mut own: Vec<f64> = a
            .covariance
            .iter()
            .zip(&b.covariance)
            .map(|(p, q)| p + q)
            .collect();
        for effect in &shared {
            for r in 0..n {
                for c in 0..n {
                    // A thousandth of it is left, lest nothing remain that weighs a point.
                    own[n * r + c] -= 0.999 * effect[r] * effect[c];
                }
            }
        }
        if cholesky(&mut own, n).is_none() {
            return Err(Error::NotPositiveDefinite {
                name: "covariance of the difference of two responses",
                row: 0,
                column: 0,
                value: 0.0,
            });
        }
        let d: Vec<f64> = a
            .matrix
            .iter()
            .zip(&b.matrix)
            .flat_map(|(p, q)| [(p - q).re, (p - q).im])
            .collect();
        let mut weighted = d.clone();
        solve(&own, &mut weighted);
        square += d.iter().zip(&weighted).map(|(a, b)| a * b).sum::<f64>();
        for (i, effect) in shared.iter().enumerate() {
            right[i] += effect
                .iter()
                .zip(&weighted)
                .map(|(a, b)| a * b)
                .sum::<f64>();
            let mut turned = (*effect).clone();
            solve(&own, &mut turned);
            for (j, other) in shared.iter().enumerate() {
                inner[effects * i + j] +=
                    other.iter().zip(&turned).map(|(a, b)| a * b).sum::<f64>();
            }
        }
    }
    if effects > 0 {
        if cholesky(&mut inner, effects).is_none() {
            return Err(Error::NotPositiveDefinite {
                name: "covariance of what the frequencies share",
                row: 0,
                column: 0,
                value: 0.0,
            });
        }
        let mut explained = right.clone();
        solve(&inner, &mut explained);
        square -= right
            .iter()
            .zip(&explained)
            .map(|(a, b)| a * b)
            .sum::<f64>();
    }
    let freedom = n * blocks.len();
    Ok(ComparedWhole {
        chi_square: square.max(0.0),
        freedom,
        limit: chi_squared_quantile(1.0 - OF_WHOLE, freedom as f64),
    })
}

fn findings(
    points: &[ComparedPoint],
    whole: Option<&ComparedWhole>,
    differ: bool,
    worst: Option<&ComparedPoint>,
    (off, limit): ([usize; 2], usize),
    probability: f64,
    causes: &[String],
) -> Vec<Finding> {
    let mut findings = Vec::new();
    let phases = points.iter().any(|p| p.phase.is_some());
    let counted = match phases {
        true => format!(
            "|E_n| above 1 at {} moduli and {} phases of {}",
            off[0],
            off[1],
            points.len()
        ),
        false => format!("|E_n| above 1 at {} moduli of {}", off[0], points.len()),
    };
    let scale = common_factor(points).map_or(String::new(), |(factor, rest)| {
        format!(
            "; one scale of {:+.2} % explains the moduli but {rest}",
            100.0 * factor
        )
    });
    if let (true, Some(worst)) = (differ, worst) {
        let evidence = match whole {
            Some(w) => format!(
                "χ² = {:.1} of {} differences, at most {:.1}",
                w.chi_square, w.freedom, w.limit
            ),
            None => format!(
                "{counted}, at most {} by chance; χ² = {:.1} at one of them",
                limit - 1,
                worst.chi_square
            ),
        };
        findings.push(findings::calibrations_differ(
            "two calibrations",
            &format!(
                "{evidence}{scale}; most at {:.4} Hz, {}: {:+.2} % in modulus (E_n {:.1}){}",
                worst.frequency,
                worst.element,
                100.0 * worst.modulus_difference,
                worst.modulus_en,
                worst.phase.map_or(String::new(), |p| format!(
                    ", {:+.2}° in phase ({:.1})",
                    p.difference.to_degrees(),
                    p.en
                ))
            ),
            "look at the course of the differences over frequency",
        ));
    }
    if off[0] + off[1] > 0 {
        let mut worst: Vec<&ComparedPoint> =
            points.iter().filter(|p| p.largest_en() > 1.0).collect();
        worst.sort_by(|a, b| b.largest_en().total_cmp(&a.largest_en()));
        let listed = worst.iter().take(6).map(|p| {
            let phase = p.phase.map_or(String::new(), |p| format!(", {:.2}", p.en));
            format!(
                "{:.4} Hz {} ({:.2}{phase})",
                p.frequency, p.element, p.modulus_en
            )
        });
        let mut listed: Vec<String> = listed.collect();
        if worst.len() > listed.len() {
            listed.push("…".to_owned());
        }
        let by_chance = (1.0 - probability) * points.len() as f64;
        findings.push(findings::normalised_error_above_one(
            &format!(
                "{counted}, {by_chance:.1}{} are expected by chance{scale}",
                if phases { " of each" } else { "" }
            ),
            &listed.join(", "),
        ));
    }
    if !causes.is_empty() {
        let shared = points.iter().filter(|p| p.modulus_en_independent.is_some());
        let largest = |of: fn(&ComparedPoint) -> f64| points.iter().map(of).fold(0.0, f64::max);
        findings.push(findings::common_causes_taken_out(
            &causes.join(", "),
            shared.count(),
            points.len(),
            largest(ComparedPoint::largest_en),
            largest(ComparedPoint::largest_independent_en),
        ));
    } else if whole.is_none() {
        findings.push(findings::correlation_not_stated(
            "a calibration",
            &format!("{} points, each judged alone", points.len()),
            "differences that are the same at all frequencies may be one error seen many times",
        ));
    }
    findings
}

impl ComparedPoint {
    /// The larger |E_n| of modulus and phase.
    pub fn largest_en(&self) -> f64 {
        let phase = self.phase.map_or(0.0, |p| p.en);
        self.modulus_en.abs().max(phase.abs())
    }

    /// The same as if nothing were common.
    pub fn largest_independent_en(&self) -> f64 {
        let modulus = self.modulus_en_independent.unwrap_or(self.modulus_en);
        let phase = |p: ComparedPhase| p.en_independent.unwrap_or(p.en);
        let phase = self.phase.map_or(0.0, phase);
        modulus.abs().max(phase.abs())
    }
}

/// Moduli and phases with |E_n| above 1.
fn beyond(points: &[ComparedPoint]) -> [usize; 2] {
    let count = |of: fn(&ComparedPoint) -> f64| points.iter().filter(|p| of(p).abs() > 1.0).count();
    [
        count(|p| p.modulus_en),
        count(|p| p.phase.map_or(0.0, |p| p.en)),
    ]
}

/// The smallest number of `n` independent events of probability `p` that comes by chance less often than [`OF_COUNT`].
fn binomial_limit(n: usize, p: f64) -> usize {
    let mut chance = (1.0 - p).powf(n as f64);
    let mut above = 1.0 - chance;
    for k in 1..=n {
        if above < OF_COUNT {
            return k;
        }
        chance *= (n - k + 1) as f64 / k as f64 * p / (1.0 - p);
        above -= chance;
    }
    n + 1
}

/// A factor that the moduli have in common, and how many stay above |E_n| = 1 without it: the weighted mean of their relative
/// differences, where it stands out as if they were independent and leaves less than half of those.
fn common_factor(points: &[ComparedPoint]) -> Option<(f64, usize)> {
    let (mut sum, mut weight) = (0.0, 0.0);
    for p in points {
        let w = p.modulus_expanded.powi(-2);
        sum += w * p.modulus_difference;
        weight += w;
    }
    let factor = sum / weight;
    let stays = |p: &&ComparedPoint| (p.modulus_difference - factor).abs() > p.modulus_expanded;
    let rest = points.iter().filter(stays).count();
    let off = beyond(points)[0];
    (points.len() > 2 && factor.abs() * weight.sqrt() > 2.0 && 2 * rest < off)
        .then_some((factor, rest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference_table::{ReferencePoint, ReferenceTable};
    use proofmass_uncertainty::{
        Component, Covariance, Effect, Estimate, EstimateSeries, Influence, SeriesPoint,
        SharedEffect,
    };
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn truth(f: f64) -> Complex64 {
        let r = f / 8000.0;
        0.01 / Complex64::new(1.0 - r * r, 0.04 * r)
    }

    /// A calibration off by a common relative error and by independent ones, as it says.
    fn calibration(f: &[f64], common: f64, own: f64, shift: f64, seed: u64) -> FrequencyResponse {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let scale = 1.0 + common * normal() + shift;
        let (mut points, mut effects) = (Vec::new(), Vec::new());
        for &at in f {
            let k = truth(at) * scale;
            let u = own * k.norm();
            let z = k + Complex64::new(u * normal(), u * normal());
            let joint = |key: &str, rows: [f64; 4]| {
                Influence::normal(
                    key,
                    key,
                    Effect::Joint {
                        covariance: Covariance::try_from_rows(2, &rows).unwrap(),
                    },
                )
            };
            let e = [common * z.re, common * z.im];
            let outer = [e[0] * e[0], e[0] * e[1], e[0] * e[1], e[1] * e[1]];
            let estimate = Estimate::new(
                vec![
                    Component::new("K.re", "V/(m/s²)", z.re),
                    Component::new("K.im", "V/(m/s²)", z.im),
                ],
                vec![
                    joint("noise", [u * u, 0.0, 0.0, u * u]),
                    joint("reference", outer),
                ],
            )
            .unwrap();
            points.push(SeriesPoint { at, estimate });
            effects.push(e.to_vec());
        }
        let shared = SharedEffect {
            key: "reference".into(),
            effects,
        };
        let axis = vec!["axis".to_owned()];
        let series = EstimateSeries::new(points, Some(vec![shared])).unwrap();
        FrequencyResponse::new(axis.clone(), axis, series).unwrap()
    }

    fn grid(n: usize) -> Vec<f64> {
        (0..n)
            .map(|k| 10.0 * 500f64.powf(k as f64 / (n - 1) as f64))
            .collect()
    }

    #[test]
    fn coverage_of_agreeing_calibrations() {
        let f = grid(24);
        let (mut alarms, mut outside, mut points) = (0, 0, 0);
        let runs = 400;
        for seed in 0..runs {
            let a = calibration(&f, 0.01, 0.002, 0.0, seed);
            let b = calibration(&f, 0.005, 0.003, 0.0, 5000 + seed);
            let c = ResponseComparison::of(&a, &b, 0.95).unwrap();
            alarms += usize::from(c.differ);
            outside += c.points.iter().filter(|p| p.modulus_en.abs() > 1.0).count();
            points += c.points.len();
            assert_eq!(c.whole.unwrap().freedom, 48);
        }
        // One in a hundred by design: twelve of 400 would come by chance once in 900.
        assert!(alarms < 12, "{alarms}");
        // Neighbours are not independent: 5 % within 2 %.
        let share = outside as f64 / points as f64;
        assert!((0.03..0.07).contains(&share), "{share}");
        // A shift that single points do not show: 0.5 % of independent error at 24 frequencies.
        let differ = (0..40u64)
            .filter(|s| {
                let a = calibration(&f, 1e-4, 0.005, 0.01, *s);
                let b = calibration(&f, 1e-4, 0.005, 0.0, 900 + s);
                ResponseComparison::of(&a, &b, 0.95).unwrap().differ
            })
            .count();
        assert!(differ >= 25, "{differ}");
    }

    #[test]
    fn known_limits_of_a_count() {
        // Binomial: of 17 at 5 %, four or more in 0.88 %, five or more in 0.12 %; two of one never suffice.
        assert_eq!(binomial_limit(17, 0.05), 5);
        assert_eq!(binomial_limit(1, 0.05), 2);
        assert_eq!(binomial_limit(3, 0.05), 3);
    }

    #[test]
    fn known_scale_of_two_certificates() {
        let f = grid(17);
        let certificate = |own: f64, shift: f64, seed: u64| {
            let r = calibration(&f, 0.0, own, shift, seed);
            // A certificate that says nothing of its correlation.
            let series = EstimateSeries::new(r.series().points().to_vec(), None).unwrap();
            FrequencyResponse::new(r.outputs().to_vec(), r.axes().to_vec(), series).unwrap()
        };
        let (mut decided, mut healthy) = (0, 0);
        for seed in 0..400 {
            let b = certificate(0.002, 0.0, 7000 + seed);
            let c = ResponseComparison::of(&certificate(0.002, 0.0, seed), &b, 0.95).unwrap();
            healthy += usize::from(c.differ);
            let c = ResponseComparison::of(&certificate(0.002, 0.007, seed), &b, 0.95).unwrap();
            decided += usize::from(c.differ);
            if seed == 0 {
                assert_eq!(c.findings[0].code(), "calibrations-differ");
                assert_eq!(c.findings[1].code(), "normalised-error-above-one");
                assert!(
                    c.findings[0].evidence_text().contains("one scale of +0."),
                    "{:?}",
                    c.findings
                );
            }
        }
        // At most 1 %: eleven of 400 would come once in 300; 0.7 % is 2.5 standard uncertainties of a difference.
        assert!(healthy < 11 && decided > 395, "{healthy} {decided}");
    }

    #[test]
    fn known_certificates_of_moduli_alone() {
        let f = grid(17);
        let certificate = |shift: f64, seed: u64| {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
            let lines = f.iter().map(|&frequency| ReferencePoint {
                frequency,
                sensitivity: truth(frequency).norm() * (1.0 + shift + 0.002 * normal()),
                phase: 0.0,
                modulus_uncertainty: 0.002,
                phase_uncertainty: 0.0,
            });
            FrequencyResponse::try_from(&ReferenceTable::new(lines.collect()).unwrap()).unwrap()
        };
        let (mut healthy, mut found, mut outside) = (0, 0, 0);
        for seed in 0..400 {
            let own = certificate(0.0, 7000 + seed);
            let c = ResponseComparison::of_moduli(&certificate(0.0, seed), &own, 0.95).unwrap();
            assert!(c.whole.is_none() && c.points.iter().all(|p| p.phase.is_none()));
            healthy += usize::from(c.differ);
            outside += c.points.iter().filter(|p| p.largest_en() > 1.0).count();
            let c = ResponseComparison::of_moduli(&certificate(0.007, seed), &own, 0.95).unwrap();
            found += usize::from(c.differ);
        }
        // 0.12 % by the count and 0.1 % by the smallest chance: six of 400 come once in 2000.
        assert!(healthy < 6 && found > 390, "{healthy} {found}");
        // 5 % of 6800 within four standard deviations.
        assert!((268..412).contains(&outside), "{outside}");
    }

    #[test]
    fn known_two_certificates_at_other_frequencies() {
        let certificate = |f: &[f64], factor: f64| {
            let lines = f
                .iter()
                .map(|&frequency| ReferencePoint {
                    frequency,
                    sensitivity: truth(frequency).norm() * factor,
                    phase: truth(frequency).arg(),
                    modulus_uncertainty: 0.005,
                    phase_uncertainty: 0.005,
                })
                .collect();
            FrequencyResponse::try_from(&ReferenceTable::new(lines).unwrap()).unwrap()
        };
        let (a, b) = (certificate(&grid(40), 1.0), certificate(&grid(9), 1.002));
        let c = ResponseComparison::of(&a, &b, 0.95).unwrap();
        assert_eq!(c.points.len(), 9);
        assert!(!c.differ && c.whole.is_none());
        assert_eq!(c.findings[0].code(), "correlation-not-stated");
        for p in &c.points {
            assert!((p.modulus_difference + 0.002).abs() < 1e-3, "{p:?}");
            // 0.002 over 1.96 · 0.005 · √2.
            assert!((p.modulus_en.abs() - 0.144).abs() < 0.08, "{p:?}");
        }
        let far = certificate(&grid(9), 1.2);
        let c = ResponseComparison::of(&a, &far, 0.95).unwrap();
        assert_eq!(c.findings[0].code(), "calibrations-differ");
        let elsewhere = certificate(&[9000.0, 9500.0], 1.0);
        assert!(ResponseComparison::of(&a, &elsewhere, 0.95).is_err());
        assert!(ResponseComparison::of(&a, &b, 1.0).is_err());
    }

    /// Two calibrations with a reference of 0.2 % that is one error of both, and `own` of each alone, relative.
    fn of_one_bench(f: &[f64], apart: impl Fn(usize) -> f64, own: f64) -> [FrequencyResponse; 2] {
        let of = |shift: &dyn Fn(usize) -> f64, turn: f64| {
            let estimates: Vec<(f64, Estimate)> = f
                .iter()
                .enumerate()
                .map(|(k, &at)| {
                    let modulus = 0.0105 * (1.0 + shift(k));
                    let components = vec![
                        Component::new("modulus", "V/(m/s²)", modulus),
                        Component::new("phase", "rad", -2e-4 * at + turn),
                    ];
                    let influence = |key: &str, u: f64| {
                        let u = [u * modulus, 0.5 * u];
                        let covariance = Covariance::from_standard_uncertainties(&u).unwrap();
                        Influence::normal(key, key, Effect::Joint { covariance })
                    };
                    let influences = vec![
                        influence("reference.calibration", 0.002),
                        influence("reading", own),
                    ];
                    (at, Estimate::new(components, influences).unwrap())
                })
                .collect();
            let points: Vec<(f64, &Estimate)> = estimates.iter().map(|(f, e)| (*f, e)).collect();
            FrequencyResponse::from_polar("z", &points, Some(vec![])).unwrap()
        };
        [of(&apart, 0.001), of(&|_| 0.0, 0.0)]
    }

    #[test]
    fn published_adhesive_against_stud_without_the_reference_of_both() {
        // `[Murgia2022]` table 3.1: relative difference of the sensitivity glued and screwed, along z, per cent, 5 to 3000 Hz.
        let table = include_str!("../../tests/inrim-pcb356a15/adhesive-vs-stud.csv");
        let (f, percent): (Vec<f64>, Vec<f64>) = table
            .lines()
            .skip(1)
            .map(|line| line.split_once(',').unwrap())
            .map(|(f, d)| -> (f64, f64) { (f.parse().unwrap(), d.parse().unwrap()) })
            .unzip();
        assert_eq!((f[1], percent[1]), (10.0, -0.56));
        // U of the reference is 0.4 % at k = 2; 0.2 % of each mounting and its readings are assumed here.
        let [glued, screwed] = of_one_bench(&f, |k| 0.01 * percent[k], 0.002);
        let both = ["reference".to_owned()];
        let c = ResponseComparison::without_common(&glued, &screwed, 0.95, true, &both).unwrap();
        let plain = ResponseComparison::of(&glued, &screwed, 0.95).unwrap();
        let k = 1.959_964;
        for (point, (old, percent)) in c.points.iter().zip(plain.points.iter().zip(&percent)) {
            let independent =
                0.01 * percent / (k * 0.002 * (2.0 + 0.01 * percent).sqrt() * 2f64.sqrt());
            assert!((point.modulus_difference - 0.01 * percent).abs() < 1e-12);
            // To first order in the difference, which shifts U of the first by up to 2 % of itself.
            assert!((old.modulus_en / independent - 1.0).abs() < 0.01, "{old:?}");
            assert_eq!(point.modulus_en_independent, Some(old.modulus_en));
            // Without the reference √2 · 0.2 % remain: E_n is √2 times as large. What is left of the reference is its share of the difference.
            let ratio = point.modulus_en / old.modulus_en;
            assert!((ratio - 2f64.sqrt()).abs() < 0.005 * 2f64.sqrt(), "{ratio}");
            let phase = point.phase.unwrap();
            assert!((phase.en / phase.en_independent.unwrap() - 2f64.sqrt()).abs() < 1e-6);
            assert!((point.modulus_coverage_factor - k).abs() < 1e-5);
        }
        // −0.56 % at 10 Hz: within U with the reference counted twice, beyond it without.
        assert!((plain.points[1].modulus_en + 0.72).abs() < 0.01);
        assert!((c.points[1].modulus_en + 1.01).abs() < 0.01);
        assert!(c.whole.is_none() && plain.whole.is_some());
        assert!(
            c.findings
                .iter()
                .any(|f| f.code() == "common-causes-taken-out")
        );
        // χ² of a point: of two numbers whose covariance is that of the readings alone.
        let d = c.points[1].modulus_difference / (0.002 * 2f64.sqrt());
        let p = c.points[1].phase.unwrap().difference / (0.001 * 2f64.sqrt());
        assert!((c.points[1].chi_square / (d * d + p * p) - 1.0).abs() < 0.01);
    }

    #[test]
    fn law_common_causes_are_named_by_both_and_never_interpolated() {
        let [a, b] = of_one_bench(&[10.0, 40.0, 160.0], |_| 0.001, 0.002);
        let keys = ResponseComparison::causes_of_both(&a, &b);
        assert_eq!(keys, ["reference.calibration", "reading"]);
        // A part of a word is no entry.
        let refer = ["refer".to_owned()];
        let c = ResponseComparison::without_common(&a, &b, 0.95, true, &refer).unwrap();
        assert!(c.points.iter().all(|p| p.modulus_en_independent.is_none()));
        // All of it: nothing is left.
        assert!(
            ResponseComparison::without_common(&a, &b, 0.95, true, &keys).is_err_and(|e| {
                matches!(
                    e,
                    Error::OutOfRange { .. } | Error::NotPositiveDefinite { .. }
                )
            })
        );
        let [_, between] = of_one_bench(&[10.0, 20.0, 160.0], |_| 0.0, 0.002);
        let both = ["reference".to_owned()];
        let c = ResponseComparison::without_common(&a, &between, 0.95, true, &both).unwrap();
        let out: Vec<bool> = c
            .points
            .iter()
            .map(|p| p.modulus_en_independent.is_some())
            .collect();
        assert_eq!(out.iter().filter(|o| **o).count(), 2, "{out:?}");
    }
}
