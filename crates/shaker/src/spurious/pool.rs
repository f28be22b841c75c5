//! The scatter of a reading, pooled over ratios of one kind: a few repeats of each know it together.

use super::{Average, RatioRepeats, average};
use crate::findings;
use crate::observation::{Correction, SpuriousTable};
use proofmass_core::Error;
use proofmass_uncertainty::chi_squared_chance;
use proofmass_uncertainty::{DegreesOfFreedom, Finding};
use std::collections::BTreeMap;

/// Largest degrees of freedom that count as few repeats: with more, u is as good as known, or was judged.
const FEW: f64 = 30.0;
/// Chance below which ratios of one kind do not scatter alike.
const UNEQUAL: f64 = 1e-4;
/// Relative difference below which two covariances are the same: what else is in them may differ so much.
const ALIKE: f64 = 0.01;
/// Ratio of the largest to the smallest u of one kind beyond which somebody should say how well they are known.
const APART: f64 = 4.0;

/// Frequency as bits, and whether along the excitation.
type Kind = (u64, bool);

/// The scatter of all ratios of one kind: across the excitation (x′ and y′) or along it, at one frequency.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pool {
    /// Σ of squares and products about the means.
    pub(super) sum: [f64; 3],
    pub(super) dof: f64,
}

impl Pool {
    pub(super) fn of(repeats: &RatioRepeats) -> Kind {
        (repeats.frequency.to_bits(), repeats.axis == 2)
    }

    pub(super) fn all(campaign: &[RatioRepeats]) -> Result<Pools, Error> {
        let mut pools = BTreeMap::new();
        for repeats in campaign {
            if let Average::Coherent(e) = average(&repeats.ratios)? {
                let pool: &mut Self = pools.entry(Self::of(repeats)).or_default();
                let n = e.repeats as f64;
                for (sum, c) in pool.sum.iter_mut().zip(e.covariance) {
                    *sum += c * n * (n - 1.0);
                }
                pool.dof += e.dof;
            }
        }
        Ok(Pools(pools))
    }
}

pub(super) struct Pools(BTreeMap<Kind, Pool>);

impl std::ops::Index<Kind> for Pools {
    type Output = Pool;
    fn index(&self, kind: Kind) -> &Pool {
        &self.0[&kind]
    }
}

/// One stated uncertainty that rests on few repeats.
#[derive(Clone, Copy)]
struct Stated {
    entry: usize,
    axis: usize,
    covariance: [f64; 3],
    dof: f64,
}

impl Stated {
    /// Covariance of one reading of the ν + 1 behind the mean.
    fn reading(&self) -> [f64; 3] {
        self.covariance.map(|c| c * (self.dof + 1.0))
    }

    fn size(&self) -> f64 {
        let c = self.reading();
        0.5 * (c[0] + c[2])
    }

    /// Real numbers behind the variance: of a modulus alone one for each degree of freedom, of both parts two.
    fn reals(&self) -> f64 {
        if self.isotropic() {
            self.dof
        } else {
            2.0 * self.dof
        }
    }

    fn isotropic(&self) -> bool {
        let [rr, ri, ii] = self.covariance;
        ri.abs() <= 1e-9 * rr && (rr - ii).abs() <= 1e-9 * rr
    }

    /// Whether two of one kind are the same estimate but for the numbers of their repeats.
    fn same_as(&self, other: &Self) -> bool {
        let trace = |c: [f64; 3]| c[0] + c[2];
        let shape = |c: [f64; 3]| c.map(|v| v / trace(c));
        let (a, b) = (shape(self.covariance), shape(other.covariance));
        let alike = (0..3).all(|k| (a[k] - b[k]).abs() < ALIKE);
        // What is round has no shape of its own; there the size tells.
        let round = (a[0] - a[2]).abs() + a[1].abs() < 2.0 * ALIKE;
        let size = trace(self.covariance) / trace(other.covariance);
        alike && (!round || (size - 1.0).abs() < 2.0 * ALIKE)
    }
}

/// Uncertainties of one kind most of which are multiples of one another are one estimate already, as in a table of
/// [`table`](super::table); a refused axis has a size of its own.
fn one_estimate(list: &[Stated]) -> bool {
    let alike = |s: &Stated| list.iter().filter(|o| s.same_as(o)).count();
    list.len() < 2 || list.iter().map(alike).max() >= Some((2 * list.len()).div_ceil(3).max(2))
}

/// Bartlett's test that the readings of all ratios scatter alike.
///
/// **Source** `[Bartlett1937]`.
fn scatter_alike(list: &[Stated]) -> bool {
    let total: f64 = list.iter().map(Stated::reals).sum();
    let pooled = list.iter().map(|s| s.reals() * s.size()).sum::<f64>() / total;
    let logarithms: f64 = list
        .iter()
        .map(|s| s.reals() * (pooled / s.size().max(1e-12 * pooled)).ln())
        .sum();
    let groups = list.len() as f64 - 1.0;
    let inverse: f64 = list.iter().map(|s| s.reals().recip()).sum();
    let statistic = logarithms / (1.0 + (inverse - total.recip()) / (3.0 * groups));
    chi_squared_chance(statistic, groups) >= UNEQUAL
}

impl SpuriousTable {
    /// The table with uncertainties that may be used as weights, and what was done to them.
    ///
    /// The scatter of two or three repeats is no weight: where it happens to be small, a ratio counts as exact and the runs
    /// contradict it. Uncertainties of ν ≤ 30 degrees of freedom are therefore pooled over all ratios across the excitation at
    /// one frequency, and over those along it, s² = Σ ν (ν + 1) u²/Σ ν, u² = s²/(ν + 1), and have Σ ν degrees of freedom. Where
    /// the readings do not scatter alike (Bartlett, p < 10⁻⁴) each ratio has the larger one of its own and the pooled
    /// uncertainty, with (Σ ν s²)²/Σ ν s⁴ degrees of freedom. Uncertainties that are multiples of one another were pooled
    /// before and stand.
    ///
    /// **Source** `[Bartlett1937]` for the test, `[Satterthwaite1946]` for the degrees of freedom.
    ///
    /// ```
    /// use num_complex::Complex64;
    /// use proofmass_shaker::{Spurious, SpuriousTable};
    /// use proofmass_uncertainty::DegreesOfFreedom;
    ///
    /// // Two repeats each: u of x′ of 0.1 % and of 0.001 %, which only luck made so small.
    /// let row = |inclination: f64, u: f64| Spurious {
    ///     basis: Default::default(),
    ///     inclination,
    ///     frequency: 160.0,
    ///     ratio: [Complex64::new(0.01, 0.0); 3],
    ///     covariance: [[u * u, 0.0, u * u], [0.0; 3], [0.0; 3]],
    ///     dof: DegreesOfFreedom::new(1.0).unwrap(),
    /// };
    /// let (table, _) = SpuriousTable::new(vec![row(0.0, 1e-3), row(0.5, 1e-5)]).pooled("first");
    /// assert!((table.entries[1].covariance[0][0].sqrt() - 1e-3 / 2f64.sqrt()).abs() < 1e-7);
    /// assert_eq!(table.entries[1].dof.get(), 2.0);
    /// ```
    pub fn pooled(&self, label: &str) -> (Self, Vec<Finding>) {
        let mut kinds: BTreeMap<Kind, Vec<Stated>> = BTreeMap::new();
        let mut unsaid: BTreeMap<Kind, [f64; 2]> = BTreeMap::new();
        for (entry, row) in self.entries.iter().enumerate() {
            for (axis, &covariance) in row.covariance.iter().enumerate() {
                let kind = (row.frequency.to_bits(), axis == 2);
                let size = covariance[0] + covariance[2];
                if size > 0.0 && row.dof.is_infinite() {
                    let [least, most] = unsaid.entry(kind).or_insert([f64::INFINITY, 0.0]);
                    (*least, *most) = (least.min(size), most.max(size));
                }
                if size > 0.0 && row.dof.get() <= FEW {
                    kinds.entry(kind).or_default().push(Stated {
                        entry,
                        axis,
                        covariance,
                        dof: row.dof.get(),
                    });
                }
            }
        }
        let mut table = self.clone();
        let (mut pooled_at, mut unequal_at) = (vec![], vec![]);
        // Of each row the fewest of what its axes have now.
        let mut dof: BTreeMap<usize, f64> = BTreeMap::new();
        for (kind, list) in &kinds {
            if one_estimate(list) {
                for s in list {
                    let least = dof.entry(s.entry).or_insert(f64::INFINITY);
                    *least = least.min(s.dof);
                }
                continue;
            }
            let total: f64 = list.iter().map(|s| s.dof).sum();
            let mut reading = [0.0; 3];
            for s in list {
                for (sum, c) in reading.iter_mut().zip(s.reading()) {
                    *sum += s.dof * c / total;
                }
            }
            let alike = scatter_alike(list);
            let known = if alike {
                total
            } else {
                let mean: f64 = list.iter().map(|s| s.dof * s.size()).sum();
                let square: f64 = list.iter().map(|s| s.dof * s.size().powi(2)).sum();
                mean * mean / square
            };
            for s in list {
                let own = s.reading();
                if alike || own[0] + own[2] < reading[0] + reading[2] {
                    table.entries[s.entry].covariance[s.axis] = reading.map(|c| c / (s.dof + 1.0));
                }
                let least = dof.entry(s.entry).or_insert(f64::INFINITY);
                *least = least.min(known);
            }
            let frequency = f64::from_bits(kind.0);
            let at = if alike {
                &mut pooled_at
            } else {
                &mut unequal_at
            };
            let text = format!("{frequency} Hz (ν = {known:.0})");
            if !at.contains(&text) {
                at.push(text);
            }
        }
        for (entry, least) in dof {
            if let Some(least) = DegreesOfFreedom::new(least) {
                table.entries[entry].dof = least;
            }
        }
        let mut findings = vec![];
        if !pooled_at.is_empty() {
            findings.push(findings::spurious_scatter_pooled(
                label,
                &pooled_at.join(", "),
            ));
        }
        if !unequal_at.is_empty() {
            findings.push(findings::spurious_scatter_unequal(
                label,
                &unequal_at.join(", "),
            ));
        }
        unsaid.retain(|_, [least, most]| *most > APART * APART * *least);
        if let Some((kind, [least, most])) = unsaid.first_key_value() {
            findings.push(findings::spurious_dof_unsaid(
                label,
                f64::from_bits(kind.0),
                (most / least).sqrt(),
            ));
        }
        (table, findings)
    }
}

/// All corrections with uncertainties that may be used as weights.
pub(crate) fn pooled(corrections: &[Correction]) -> (Vec<Correction>, Vec<Finding>) {
    let mut findings = vec![];
    let list = corrections
        .iter()
        .map(|c| {
            let (table, about) = c.table.pooled(&c.label);
            findings.extend(about);
            Correction {
                label: c.label.clone(),
                table,
            }
        })
        .collect();
    (list, findings)
}

#[cfg(test)]
mod tests {
    use super::super::table;
    use super::*;
    use crate::observation::Spurious;
    use num_complex::Complex64;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Six wedges, x′, y′ and z′, `n` repeats; wedge k has (1 + growth k) of the noise.
    fn repeats(n: usize, growth: f64, seed: u64) -> Vec<RatioRepeats> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = move || -> f64 { StandardNormal.sample(&mut rng) };
        let mut list = vec![];
        for wedge in 0..6 {
            for axis in 0..3 {
                let noise = 1e-3 * (1.0 + growth * f64::from(wedge));
                let whole = Complex64::new(0.01 + f64::from(axis == 2), 0.0);
                let read = |_| whole + noise * Complex64::new(normal(), normal());
                list.push(RatioRepeats {
                    inclination: 0.2 * f64::from(wedge),
                    frequency: 160.0,
                    axis: axis as usize,
                    ratios: (0..n).map(read).collect(),
                });
            }
        }
        list
    }

    fn own(campaign: &[RatioRepeats]) -> SpuriousTable {
        let (mut pooled, _) = table(campaign).unwrap();
        for r in campaign {
            let Average::Coherent(e) = average(&r.ratios).unwrap() else {
                panic!("refused");
            };
            let here = |s: &&mut Spurious| s.inclination == r.inclination;
            let entry = pooled.entries.iter_mut().find(here).unwrap();
            entry.covariance[r.axis] = e.covariance;
            entry.dof = DegreesOfFreedom::new(e.dof).unwrap();
        }
        pooled
    }

    fn codes(findings: &[Finding]) -> Vec<&str> {
        findings.iter().map(Finding::code).collect()
    }

    #[test]
    fn law_scatter_of_each_ratio_pools_to_what_the_repeats_pool_to() {
        for n in [2, 3, 10] {
            let campaign = repeats(n, 0.0, 5);
            let (expected, _) = table(&campaign).unwrap();
            let (pooled, findings) = own(&campaign).pooled("own");
            assert_eq!(codes(&findings), ["spurious-scatter-pooled"]);
            for (a, b) in expected.entries.iter().zip(&pooled.entries) {
                assert!((a.dof.get() / b.dof.get() - 1.0).abs() < 1e-12);
                for (a, b) in a.covariance.iter().zip(&b.covariance) {
                    for k in 0..3 {
                        assert!((a[k] - b[k]).abs() < 1e-12 * a[0], "{a:?} {b:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn law_a_pooled_table_stands() {
        let mut campaign = repeats(3, 0.0, 6);
        // A ratio of more repeats than the others.
        let more = campaign[4].ratios.clone();
        campaign[4].ratios.extend(more);
        let (expected, _) = table(&campaign).unwrap();
        let (again, findings) = expected.pooled("table");
        assert_eq!(again, expected);
        assert!(findings.is_empty());
    }

    #[test]
    fn law_ratios_that_scatter_unlike_keep_the_larger_uncertainty() {
        let campaign = repeats(10, 3.0, 7);
        let stated = own(&campaign);
        let (pooled, findings) = stated.pooled("own");
        assert_eq!(codes(&findings), ["spurious-scatter-unequal"]);
        for (a, b) in stated.entries.iter().zip(&pooled.entries) {
            for (a, b) in a.covariance.iter().zip(&b.covariance) {
                assert!(b[0] + b[2] >= (a[0] + a[2]) * (1.0 - 1e-12));
            }
        }
        // 6 wedges of 9 each along z′, of which the noisiest count most.
        let nu = pooled.entries[0].dof.get();
        assert!(nu > 9.0 && nu < 54.0, "{nu}");
    }

    #[test]
    fn known_false_alarm_rate_of_unequal_scatter() {
        for n in [2, 3, 10] {
            let said = (0..400).filter(|seed| {
                let (_, findings) = own(&repeats(n, 0.0, 100 + seed)).pooled("own");
                codes(&findings).contains(&"spurious-scatter-unequal")
            });
            let said = said.count();
            println!("{n} repeats: {said} of 400");
            // Two tests of 1e-4 each.
            assert!(said <= 1, "{n}: {said}");
        }
    }

    #[test]
    fn law_uncertainties_of_unsaid_dof_are_told() {
        let mut stated = own(&repeats(2, 0.0, 8));
        for entry in &mut stated.entries {
            entry.dof = DegreesOfFreedom::INFINITE;
        }
        let (same, findings) = stated.pooled("own");
        assert_eq!(same, stated);
        assert_eq!(codes(&findings), ["spurious-dof-unsaid"]);
    }
}
