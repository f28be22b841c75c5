//! Calibrations of one device by several laboratories: their reference value, and how far each is from it.

use super::FrequencyResponse;
use super::comparison::{Side, common_frequencies, element_names};
use crate::findings;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::{Covariance, DegreesOfFreedom, Finding, MedianValue, WeightedMean};
use serde::Serialize;

/// One element of one laboratory, against a reference value.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Equivalence {
    /// Its value.
    pub value: Complex64,
    /// (|K_i| − |K_ref|)/|K_ref|.
    pub modulus_difference: f64,
    /// Expanded uncertainty of that.
    pub modulus_expanded: f64,
    /// Deviation over its expanded uncertainty.
    pub modulus_en: f64,
    /// Phase against that of the reference, rad.
    pub phase_difference: f64,
    /// Expanded uncertainty of that.
    pub phase_expanded: f64,
    /// Deviation over its expanded uncertainty.
    pub phase_en: f64,
    /// The same two against the median of the laboratories: value, lower, upper limit.
    pub median_modulus: [f64; 3],
    /// As `median_modulus`, of the phase in rad.
    pub median_phase: [f64; 3],
}

/// One element at one frequency, as all laboratories have it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ReferenceElement {
    /// Hz.
    pub frequency: f64,
    /// Name of the element.
    pub element: String,
    /// Weighted mean.
    pub mean: Complex64,
    /// Standard uncertainty of its modulus, relative, and of its phase, rad.
    pub mean_uncertainty: [f64; 2],
    /// Median of the laboratories.
    pub median: Complex64,
    /// Standard uncertainty of its modulus, relative, and of its phase, rad.
    pub median_uncertainty: [f64; 2],
    /// Chance of deviations from the mean as large as these, of all elements at this frequency together.
    pub chance: f64,
    /// k of every expanded uncertainty here.
    pub coverage_factor: f64,
    /// One for each laboratory.
    pub laboratories: Vec<Equivalence>,
}

/// Calibrations of one device by three laboratories or more.
///
/// At every frequency the reference value is the weighted mean of the whole matrices with their covariances (procedure A); the
/// median of modulus and phase of each element by Monte Carlo stands beside it (procedure B), which one laboratory that is off hardly
/// draws along. Of an element that one laboratory has within five standard uncertainties of zero, the parts in phase with the mean and in
/// quadrature to it, relative to its modulus, stand for modulus and phase, which do not hold there.
///
/// **Assumes** laboratories that have nothing in common. **Accuracy** at most 1 % of agreeing laboratories raise `calibrations-differ`
/// (`known_laboratories_that_agree_and_one_that_does_not`). **Source** `[Cox02]`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ReferenceComparison {
    /// Frequency by frequency, element by element.
    pub points: Vec<ReferenceElement>,
    /// Whether the laboratories differ by more than chance.
    pub differ: bool,
    /// Share of the frequencies at which they agree well enough for their mean (a chance of 5 % or more).
    pub consistent: f64,
    /// Laboratories, the one that is furthest from the others first.
    pub furthest: Vec<Apart>,
    /// Probability of the expanded uncertainties.
    pub probability: f64,
    /// Unit of all.
    pub unit: String,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

/// How far one laboratory is from the mean of the others.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Apart {
    /// Its place among the laboratories.
    pub laboratory: usize,
    /// Largest χ² of a frequency.
    pub chi_square: f64,
    /// Chance of one as large at any of the frequencies.
    pub chance: f64,
}

/// Chance of the finding where nothing differs.
const CHANCE: f64 = 1e-3;
/// Trials of the median at a frequency.
const TRIALS: usize = 10_000;

impl ReferenceComparison {
    /// Compares.
    ///
    /// # Errors
    /// [`Error::TooFew`] below three responses, [`Error::Length`] for other outputs and axes, [`Error::OutOfRange`] for a probability
    /// outside (0, 1) or ranges that do not meet, [`Error::NotPositiveDefinite`] where one states no uncertainty.
    pub fn of(responses: &[&FrequencyResponse], probability: f64) -> Result<Self, Error> {
        if responses.len() < 3 {
            return Err(Error::TooFew {
                name: "laboratories",
                needed: 3,
                got: responses.len(),
            });
        }
        let first = responses[0];
        let elements = first.outputs().len() * first.axes().len();
        for other in responses {
            let got = other.outputs().len() * other.axes().len();
            if got != elements || other.outputs().len() != first.outputs().len() {
                return Err(Error::Length {
                    name: "elements of the responses",
                    expected: elements,
                    got,
                });
            }
        }
        let names = element_names(first);
        let sides: Vec<Side<'_>> = responses.iter().map(|r| Side::new(r)).collect();
        let frequencies = common_frequencies(responses)?;
        let mut points = Vec::with_capacity(frequencies.len() * elements);
        let mut furthest: Vec<Apart> = (0..responses.len())
            .map(|laboratory| Apart {
                laboratory,
                chi_square: 0.0,
                chance: 1.0,
            })
            .collect();
        let mut consistent = 0usize;
        for (index, &f) in frequencies.iter().enumerate() {
            let at = Frequency::of(&sides, f, probability, index as u64)?;
            consistent += usize::from(at.mean.is_consistent());
            for apart in &mut furthest {
                let alone = at.alone(apart.laboratory)?;
                apart.chi_square = apart.chi_square.max(alone.chi_square);
                apart.chance = apart.chance.min(alone.chance);
            }
            for (e, name) in names.iter().enumerate() {
                points.push(at.element(e, name));
            }
        }
        let tests = frequencies.len() as f64;
        let smallest = points.iter().map(|p| p.chance).fold(1.0, f64::min);
        // Of all frequencies at most their number times the smallest chance.
        let differ = tests * smallest < CHANCE;
        for apart in &mut furthest {
            apart.chance = (tests * apart.chance).min(1.0);
        }
        // Chances of those that are far off all vanish.
        furthest.sort_by(|a, b| b.chi_square.total_cmp(&a.chi_square));
        Ok(Self {
            findings: Vec::new(),
            consistent: consistent as f64 / tests,
            differ,
            furthest,
            points,
            probability,
            unit: first.unit().to_owned(),
        })
    }

    /// Adds what to doubt, the laboratories called by their names.
    pub fn judged(mut self, names: &[&str]) -> Self {
        if !self.differ {
            return self;
        }
        let name = |i: usize| names.get(i).copied().unwrap_or("a laboratory");
        let first = self.furthest.first().map_or(0, |f| f.laboratory);
        // One that is off is in the mean that the others are held against: the next has to be some thousand times as probable.
        let alone = match &self.furthest[..] {
            [one, next, ..] => one.chi_square - next.chi_square > 2.0 * 1e3f64.ln(),
            _ => true,
        };
        let worst = self
            .points
            .iter()
            .filter_map(|p| p.laboratories.get(first).map(|l| (p, l)))
            .max_by(|a, b| {
                let size = |l: &Equivalence| l.modulus_en.hypot(l.phase_en);
                size(a.1).total_cmp(&size(b.1))
            });
        let evidence = worst.map_or(String::new(), |(p, l)| {
            format!(
                "furthest from the others is {}: at {:.4} Hz, {}, {:+.2} % in modulus and {:+.2}° in phase (E_n {:.1} and {:.1}){}; the mean is fit to be a reference at {:.0} % of the frequencies",
                name(first),
                p.frequency,
                p.element,
                100.0 * l.modulus_difference,
                l.phase_difference.to_degrees(),
                l.modulus_en,
                l.phase_en,
                if alone { "" } else { ", but not it alone" },
                100.0 * self.consistent,
            )
        });
        self.findings.push(findings::calibrations_differ(
            "laboratories",
            &evidence,
            "ask the one that is off; take the median as the reference where the mean does not fit",
        ));
        self
    }
}

/// All laboratories at one frequency.
struct Frequency {
    frequency: f64,
    values: Vec<Vec<f64>>,
    covariances: Vec<Covariance>,
    mean: WeightedMean,
    /// Of the deviations of every element in modulus and phase from the mean.
    median: MedianValue,
    elements: Vec<Deviations>,
    factor: f64,
}

/// How deviations of one element from the mean are taken.
#[derive(Clone, Copy)]
struct Deviations {
    mean: Complex64,
    /// As modulus and phase, or in phase with the mean and in quadrature to it.
    polar: bool,
}

impl Deviations {
    fn size(self) -> f64 {
        self.mean.norm().max(f64::MIN_POSITIVE)
    }

    /// Both parts: of the modulus, relative to that of the mean, and of the phase, rad.
    fn of(self, value: Complex64) -> [f64; 2] {
        let ratio = value * self.turn().conj() / self.size();
        match self.polar {
            true => [ratio.norm() - 1.0, ratio.arg()],
            false => [ratio.re - 1.0, ratio.im],
        }
    }

    /// Derivatives of both parts by real and imaginary part of a value.
    fn slope(self, value: Complex64) -> [[f64; 2]; 2] {
        let along = match self.polar {
            true => value / value.norm(),
            false => self.turn(),
        };
        let across = match self.polar {
            true => value.norm(),
            false => self.size(),
        };
        [
            [along.re / self.size(), along.im / self.size()],
            [-along.im / across, along.re / across],
        ]
    }

    fn back(self, [modulus, phase]: [f64; 2]) -> Complex64 {
        match self.polar {
            true => self.mean * (1.0 + modulus) * Complex64::cis(phase),
            false => self.turn() * self.size() * Complex64::new(1.0 + modulus, phase),
        }
    }

    fn turn(self) -> Complex64 {
        let size = self.mean.norm();
        if size > 0.0 {
            self.mean / size
        } else {
            Complex64::ONE
        }
    }
}

/// An element further than this from zero, in standard uncertainties, has a modulus and a phase.
const CLEAR: f64 = 5.0;

impl Frequency {
    fn of(sides: &[Side<'_>], f: f64, probability: f64, seed: u64) -> Result<Self, Error> {
        let seen = sides
            .iter()
            .map(|side| side.look(f))
            .collect::<Result<Vec<_>, Error>>()?;
        let count = seen[0].matrix.len();
        let n = 2 * count;
        let values: Vec<Vec<f64>> = seen
            .iter()
            .map(|s| s.matrix.iter().flat_map(|z| [z.re, z.im]).collect())
            .collect();
        let covariances = seen
            .iter()
            .map(|s| Covariance::try_from_rows(n, &s.covariance))
            .collect::<Result<Vec<_>, Error>>()?;
        let mean = WeightedMean::of(&values, &covariances)?;
        let clear = |z: Complex64, c: &Covariance, e: usize| {
            let u = c[(2 * e, 2 * e)].max(c[(2 * e + 1, 2 * e + 1)]).sqrt();
            z.norm() > CLEAR * u
        };
        let elements: Vec<Deviations> = (0..count)
            .map(|e| {
                let reference = Complex64::new(mean.value[2 * e], mean.value[2 * e + 1]);
                let all = seen.iter().zip(&covariances);
                Deviations {
                    mean: reference,
                    polar: clear(reference, &mean.covariance, e)
                        && all.into_iter().all(|(s, c)| clear(s.matrix[e], c, e)),
                }
            })
            .collect();
        let (mut parts, mut spreads) = (Vec::new(), Vec::new());
        for (s, c) in seen.iter().zip(&covariances) {
            let mut jacobian = vec![0.0; n * n];
            for (e, (element, z)) in elements.iter().zip(&s.matrix).enumerate() {
                for (i, row) in element.slope(*z).iter().enumerate() {
                    let at = n * (2 * e + i) + 2 * e;
                    jacobian[at..at + 2].copy_from_slice(row);
                }
            }
            let both = elements.iter().zip(&s.matrix).flat_map(|(d, z)| d.of(*z));
            parts.push(both.collect::<Vec<f64>>());
            spreads.push(c.propagate(&jacobian)?);
        }
        let median = MedianValue::of(&parts, &spreads, probability, TRIALS, seed)?;
        let dof = seen.iter().map(|s| s.dof).fold(f64::INFINITY, f64::min);
        let factor = DegreesOfFreedom::new(dof)
            .unwrap_or(DegreesOfFreedom::INFINITE)
            .coverage_factor(probability);
        Ok(Self {
            frequency: f,
            values,
            covariances,
            mean,
            median,
            elements,
            factor,
        })
    }

    /// One laboratory against the mean of all others.
    fn alone(&self, i: usize) -> Result<WeightedMean, Error> {
        let without = |k: &usize| *k != i;
        let others: Vec<usize> = (0..self.values.len()).filter(without).collect();
        let values: Vec<Vec<f64>> = others.iter().map(|&k| self.values[k].clone()).collect();
        let covariances: Vec<Covariance> = others
            .iter()
            .map(|&k| self.covariances[k].clone())
            .collect();
        let rest = WeightedMean::of(&values, &covariances)?;
        WeightedMean::of(
            &[self.values[i].clone(), rest.value],
            &[self.covariances[i].clone(), rest.covariance],
        )
    }

    fn element(&self, e: usize, name: &str) -> ReferenceElement {
        let (r, i) = (2 * e, 2 * e + 1);
        let element = self.elements[e];
        let block = |c: &Covariance| [[c[(r, r)], c[(r, i)]], [c[(i, r)], c[(i, i)]]];
        let form = |a: [f64; 2], c: [[f64; 2]; 2], b: [f64; 2]| -> f64 {
            (0..2)
                .map(|k| (0..2).map(|l| a[k] * c[k][l] * b[l]).sum::<f64>())
                .sum()
        };
        let c = block(&self.mean.covariance);
        let own = element.slope(element.mean);
        let ratio = |d: f64, u: f64| if u > 0.0 { d / u } else { 0.0 };
        let laboratories = self.values.iter().enumerate().map(|(k, x)| {
            let value = Complex64::new(x[r], x[i]);
            let d = element.of(value);
            let (v, slope) = (block(&self.covariances[k]), element.slope(value));
            // The laboratory is part of the mean: their covariance is that of the mean.
            let expanded: [f64; 2] = std::array::from_fn(|part| {
                let (a, b) = (slope[part], own[part]);
                let variance = form(a, v, a) + form(b, c, b) - 2.0 * form(a, c, b);
                self.factor * variance.max(0.0).sqrt()
            });
            let beside = |part: usize| {
                let m = self.median.deviations[k][part];
                [m.value, m.lower, m.upper]
            };
            Equivalence {
                value,
                modulus_difference: d[0],
                modulus_expanded: expanded[0],
                modulus_en: ratio(d[0], expanded[0]),
                phase_difference: d[1],
                phase_expanded: expanded[1],
                phase_en: ratio(d[1], expanded[1]),
                median_modulus: beside(r),
                median_phase: beside(i),
            }
        });
        ReferenceElement {
            frequency: self.frequency,
            element: name.to_owned(),
            mean: element.mean,
            mean_uncertainty: own.map(|a| form(a, c, a).max(0.0).sqrt()),
            median: element.back([self.median.value[r], self.median.value[i]]),
            median_uncertainty: [r, i].map(|part| self.median.uncertainty[part]),
            chance: self.mean.chance,
            coverage_factor: self.factor,
            laboratories: laboratories.collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference_table::{ReferencePoint, ReferenceTable};
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Laboratories with these relative uncertainties, the first off by a factor.
    fn laboratories(uncertainties: &[f64], shift: f64, seed: u64) -> Vec<FrequencyResponse> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let each = uncertainties.iter().enumerate().map(|(i, &u)| {
            let line = |k: i32| {
                let frequency = 10.0 * 1.5f64.powi(k);
                let off = if i == 0 { shift } else { 0.0 };
                ReferencePoint {
                    frequency,
                    sensitivity: 0.01 * (1.0 + off + u * normal()),
                    phase: -1e-4 * frequency + u * normal(),
                    modulus_uncertainty: u,
                    phase_uncertainty: u,
                }
            };
            let table = ReferenceTable::new((0..17).map(line).collect()).unwrap();
            FrequencyResponse::try_from(&table).unwrap()
        });
        each.collect()
    }

    #[test]
    fn known_laboratories_that_agree_and_one_that_does_not() {
        let (mut false_alarms, mut inside, mut all) = (0, 0, 0);
        let rounds = 60;
        for seed in 0..rounds {
            let list = laboratories(&[0.002, 0.004, 0.003, 0.005], 0.0, 500 + seed);
            let list: Vec<&FrequencyResponse> = list.iter().collect();
            let healthy = ReferenceComparison::of(&list, 0.95).unwrap();
            false_alarms += usize::from(healthy.differ);
            for p in &healthy.points {
                let truth = Complex64::from_polar(0.01, -1e-4 * p.frequency);
                let off = (p.mean / truth - 1.0) / Complex64::ONE;
                for (d, u) in [off.re, off.im].into_iter().zip(p.mean_uncertainty) {
                    all += 1;
                    inside += usize::from(d.abs() < 1.959_964 * u);
                }
            }
        }
        println!("mean {inside} of {all}, {false_alarms} false alarms of {rounds}");
        // Binomial: 1938 of 2040, three deviations.
        assert!(
            (1908..1968).contains(&inside) && all == 2040,
            "{inside} of {all}"
        );
        assert!(false_alarms <= 1, "{false_alarms}");
        for seed in 0..10 {
            let list = laboratories(&[0.002, 0.004, 0.003, 0.005], 0.03, seed);
            let list: Vec<&FrequencyResponse> = list.iter().collect();
            let names = ["one", "two", "three", "four"];
            let off = ReferenceComparison::of(&list, 0.95).unwrap().judged(&names);
            assert!(
                off.differ && off.furthest[0].laboratory == 0,
                "{:?}",
                off.furthest
            );
            assert!(
                off.findings[0]
                    .to_string()
                    .contains("furthest from the others is one:")
            );
            // The median stays with the three that agree.
            for p in &off.points {
                let drawn = (p.median.norm() / 0.01 - 1.0) / p.median_uncertainty[0];
                assert!(drawn.abs() < 5.0, "{drawn}");
            }
        }
    }

    /// Phases of one laboratory with the wrong sign: named whatever the order, and its modulus is right.
    #[test]
    fn known_laboratory_far_off_in_phase() {
        let of = |s: f64, phase: f64| {
            let line = |frequency: f64| ReferencePoint {
                frequency,
                sensitivity: s,
                phase: phase * frequency / 100.0,
                modulus_uncertainty: 0.002,
                phase_uncertainty: 0.0035,
            };
            let lines = vec![line(50.0), line(100.0), line(200.0)];
            FrequencyResponse::try_from(&ReferenceTable::new(lines).unwrap()).unwrap()
        };
        let mut list = [
            of(1.0, -0.5),
            of(1.001, -0.5),
            of(0.999, -0.5),
            of(1.0, 0.5),
        ];
        for place in (0..4).rev() {
            let all: Vec<&FrequencyResponse> = list.iter().collect();
            let found = ReferenceComparison::of(&all, 0.95).unwrap();
            assert!(found.differ);
            assert_eq!(found.furthest[0].laboratory, place, "{:?}", found.furthest);
            for p in &found.points {
                let l = &p.laboratories[place];
                // Against the median, which stays with the others.
                assert!(l.median_modulus[0].abs() < 0.01, "{:?}", l.median_modulus);
                let turned = l.median_phase[0];
                assert!((turned - 0.01 * p.frequency).abs() < 0.02, "{turned}");
            }
            if place > 0 {
                list.swap(place, place - 1);
            }
        }
    }

    /// χ² of the mean by hand: three equal laboratories at one frequency.
    #[test]
    fn known_mean_of_equal_laboratories() {
        let of = |s: f64| {
            let line = ReferencePoint {
                frequency: 100.0,
                sensitivity: s,
                phase: 0.0,
                modulus_uncertainty: 1e-3 / s,
                phase_uncertainty: 1e-3 / s,
            };
            FrequencyResponse::try_from(&ReferenceTable::new(vec![line]).unwrap()).unwrap()
        };
        let list = [of(1.0), of(1.001), of(1.002)];
        let list: Vec<&FrequencyResponse> = list.iter().collect();
        let found = ReferenceComparison::of(&list, 0.95).unwrap();
        let p = &found.points[0];
        assert!((p.mean.norm() - 1.001).abs() < 1e-12);
        assert!((p.mean_uncertainty[0] - 1e-3 / 3f64.sqrt() / 1.001).abs() < 1e-9);
        // χ² = 2 of four degrees of freedom.
        assert!((p.chance - 0.735_758_882).abs() < 1e-6, "{}", p.chance);
        // u²(d) = u² (1 − 1/3).
        let expected = 1.959_964 * 1e-3 * (2.0f64 / 3.0).sqrt() / 1.001;
        assert!((p.laboratories[0].modulus_expanded - expected).abs() < 1e-8);
    }
}
