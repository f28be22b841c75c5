//! Repeats of which one is none: it is off the others by far more than they scatter and than a reading is declared to.

use crate::findings;
use num_complex::Complex64;
use proofmass_core::numeric::median;
use proofmass_uncertainty::{DegreesOfFreedom, Finding, chi_squared_quantile, f_quantile};

/// Probability that anything is said of a sound campaign.
pub(crate) const FALSE_ALARM_RATE: f64 = 1e-3;
/// Departure below which a run is a repeat, if one that scatters.
const SMALLEST: f64 = 0.05;
/// Multiple of the median departure beyond which a run does not belong to those in the middle.
const OUTSIDE: f64 = 10.0;
/// Degrees of freedom from which on a declared uncertainty is taken as known.
const KNOWN: f64 = 1e6;

/// What is declared of a single run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DeclaredReading {
    /// Standard uncertainties of modulus (relative) and phase (rad); zero where nothing is known.
    pub(crate) one: [f64; 2],
    /// Their degrees of freedom.
    pub(crate) dof: DegreesOfFreedom,
    /// Whether moduli alone are compared.
    pub(crate) free_phase: bool,
}

impl DeclaredReading {
    /// Nothing is declared: the scatter of the runs alone says which of them is none.
    pub(crate) const NOTHING: Self = Self {
        one: [0.0; 2],
        dof: DegreesOfFreedom::INFINITE,
        free_phase: false,
    };
}

/// A run that is no repeat of the others.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Departing {
    /// Position of the run.
    pub(crate) index: usize,
    /// Its sensitivity over that of the others.
    pub(crate) factor: Complex64,
    /// Relative scatter of the others, of one part.
    pub(crate) scatter: f64,
    /// How many they are.
    pub(crate) others: usize,
}

impl Departing {
    /// The finding, by the name of the run and what may be the cause.
    pub(crate) fn told(&self, run: &str, frequency: f64, cause: &str) -> Finding {
        let factor = in_words(self.factor);
        let scatter = 100.0 * self.scatter;
        findings::no_repeat(run, frequency, &factor, self.others, scatter, cause)
    }
}

/// What is to be said of the repeats of one frequency.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Repeats {
    /// They belong together.
    Alike,
    /// Some are none.
    Without(Vec<Departing>),
    /// They do not belong together, and no majority says which of them is wrong: ratio of the largest modulus to the smallest, and the
    /// largest difference of two phases, rad.
    Apart(f64, f64),
}

/// Judges the repeats `values` of one frequency of a campaign that has so many frequencies.
///
/// A run is named where it is 5 % or more from the mean of those in the middle, beyond what the declared uncertainty of a reading makes
/// once in a thousand campaigns, and beyond what their own scatter makes once in a thousand frequencies (F test); where nothing is declared, once in a
/// thousand campaigns by their scatter alone. Without a majority the declared uncertainty alone judges.
pub(crate) fn judge(
    values: &[Complex64],
    declared: &DeclaredReading,
    frequencies: usize,
) -> Repeats {
    let moduli = |z: &Complex64| match declared.free_phase {
        true => Complex64::from(z.norm()),
        false => *z,
    };
    let values: Vec<Complex64> = values.iter().map(moduli).collect();
    let n = values.len();
    let tests = (n * frequencies.max(1)) as f64;
    let middle = Complex64::new(
        middle_of(values.iter().map(|z| z.re)),
        middle_of(values.iter().map(|z| z.im)),
    );
    if n < 2 || !(middle.norm() > 0.0) {
        return Repeats::Alike;
    }
    let off = |z: &Complex64| (z / middle - 1.0).norm();
    let typical = middle_of(values.iter().map(off));
    let limit = SMALLEST.max(OUTSIDE * typical);
    let (inside, outside): (Vec<usize>, Vec<usize>) =
        (0..n).partition(|&i| off(&values[i]) <= limit);
    if outside.is_empty() || inside.len() <= outside.len() || inside.len() < 2 {
        return without_majority(&values, declared, tests);
    }
    let m = inside.len() as f64;
    let mean = inside.iter().map(|&i| values[i]).sum::<Complex64>() / m;
    let parts = if declared.free_phase { 1.0 } else { 2.0 };
    let squares: f64 = inside
        .iter()
        .map(|&i| (values[i] / mean - 1.0).norm_sqr())
        .sum();
    let freedom = parts * (m - 1.0);
    let variance = squares / freedom;
    let rate = match is_declared(declared) {
        true => FALSE_ALARM_RATE / n as f64,
        false => FALSE_ALARM_RATE / tests,
    };
    let own = f_quantile(1.0 - rate, parts, freedom);
    let departs = |&i: &usize| {
        let factor = values[i] / mean;
        let d = factor - 1.0;
        let by_scatter = d.norm_sqr() / parts / (1.0 + 1.0 / m) > own * variance;
        let departs = d.norm() >= SMALLEST
            && by_scatter
            && beyond_declared(d, 1.0 + 1.0 / m, declared, FALSE_ALARM_RATE / tests);
        departs.then(|| Departing {
            index: i,
            factor,
            scatter: variance.sqrt(),
            others: inside.len(),
        })
    };
    let list: Vec<Departing> = outside.iter().filter_map(departs).collect();
    match list.is_empty() {
        true => Repeats::Alike,
        false => Repeats::Without(list),
    }
}

/// Whether a relative departure whose variance is `grown` times that of a reading is beyond what the reading makes at this rate; with nothing
/// declared, any is.
fn beyond_declared(d: Complex64, grown: f64, declared: &DeclaredReading, rate: f64) -> bool {
    if !is_declared(declared) {
        return true;
    }
    let [u, v] = declared.one;
    let parts = if declared.free_phase { 1.0 } else { 2.0 };
    let phase = match declared.free_phase {
        true => 0.0,
        false => (d.im / v).powi(2),
    };
    let statistic = ((d.re / u).powi(2) + phase) / grown;
    let dof = declared.dof.get();
    statistic
        > match dof < KNOWN {
            true => parts * f_quantile(1.0 - rate, parts, dof),
            false => chi_squared_quantile(1.0 - rate, parts),
        }
}

fn is_declared(declared: &DeclaredReading) -> bool {
    declared.one[0] > 0.0 && (declared.free_phase || declared.one[1] > 0.0)
}

/// Too few belong together to say which is wrong: whether two of them differ beyond the declared uncertainty.
fn without_majority(values: &[Complex64], declared: &DeclaredReading, tests: f64) -> Repeats {
    let n = values.len() as f64;
    let mean = values.iter().sum::<Complex64>() / n;
    if !is_declared(declared) || !(mean.norm() > 0.0) {
        return Repeats::Alike;
    }
    let apart = |z: &Complex64| {
        let d = z / mean - 1.0;
        d.norm() >= 0.5 * SMALLEST
            && beyond_declared(d, 1.0 - 1.0 / n, declared, FALSE_ALARM_RATE / tests)
    };
    if !values.iter().any(apart) {
        return Repeats::Alike;
    }
    let sizes = || values.iter().map(|z| z.norm());
    let largest = sizes().fold(0.0, f64::max);
    let smallest = sizes().fold(f64::INFINITY, f64::min);
    let turn = values
        .iter()
        .flat_map(|a| values.iter().map(move |b| (a * b.conj()).arg().abs()))
        .fold(0.0, f64::max);
    Repeats::Apart(largest / smallest, turn)
}

/// The findings about the repeats of one frequency, by the names of the runs.
pub(crate) fn doubts(
    names: &[&str],
    frequency: f64,
    values: &[Complex64],
    declared: &DeclaredReading,
    frequencies: usize,
) -> Vec<Finding> {
    match judge(values, declared, frequencies) {
        Repeats::Alike => Vec::new(),
        Repeats::Without(list) => list
            .iter()
            .map(|d| d.told(names[d.index], frequency, cause(d.factor)))
            .collect(),
        Repeats::Apart(ratio, turn) => vec![findings::repeats_apart(
            frequency,
            &names.join(", "),
            ratio,
            turn.to_degrees(),
        )],
    }
}

/// A factor with its turn, where it has one.
pub(crate) fn in_words(factor: Complex64) -> String {
    let size = factor.norm();
    let size = match size {
        s if s >= 99.95 => format!("{s:.0}"),
        s if s >= 9.9995 => format!("{s:.1}"),
        s if s >= 0.0995 => format!("{s:.3}"),
        s => format!("{s:.2e}"),
    };
    let turn = factor.arg().to_degrees();
    match turn.abs() < 1.0 {
        true => format!("{size} times"),
        false => format!("{size} times, turned by {turn:+.0}°,"),
    }
}

/// What makes such a factor.
fn cause(factor: Complex64) -> &'static str {
    let near = |value: f64| (factor.norm() / value - 1.0).abs() < 0.02;
    if factor.arg().abs() > 3.0 && near(1.0) {
        "that is a channel with the opposite polarity"
    } else if factor.arg().abs() > 0.03 {
        "look at cable, mounting and frequency of that run"
    } else if [10.0, 0.1, 100.0, 0.01, 1000.0, 0.001]
        .into_iter()
        .any(near)
    {
        "that is a gain or a range of another decade, or a slip of the decimal point"
    } else if [2.0, 0.5, 5.0, 0.2].into_iter().any(near) {
        "that is a gain or a range of another step"
    } else if near(std::f64::consts::SQRT_2) || near(std::f64::consts::FRAC_1_SQRT_2) {
        "that is a root mean square taken for an amplitude, or the other way round"
    } else {
        "look at gain, range, mounting and frequency of that run"
    }
}

fn middle_of(values: impl Iterator<Item = f64>) -> f64 {
    median(&mut values.collect::<Vec<_>>()).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    fn declared(u: f64) -> DeclaredReading {
        DeclaredReading {
            one: [u, u],
            dof: DegreesOfFreedom::INFINITE,
            free_phase: false,
        }
    }

    fn sound(n: usize, u: f64, rng: &mut rand_xoshiro::Xoshiro256PlusPlus) -> Vec<Complex64> {
        let s = Complex64::from_polar(0.01, -0.4);
        (0..n)
            .map(|_| {
                let mut draw = || -> f64 { StandardNormal.sample(rng) };
                s * (1.0 + u * Complex64::new(draw(), draw()))
            })
            .collect()
    }

    #[test]
    fn known_factors_of_one_run_and_of_two() {
        let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(5);
        for n in [3, 4, 7] {
            for factor in [10.0, 0.1, 1.2, -1.0] {
                for u in [0.0, 0.001] {
                    // The scatter of two others alone tells a factor of 1.2 in 94 of 100.
                    if (n, factor, u) == (3, 1.2, 0.0) {
                        continue;
                    }
                    let mut values = sound(n, 0.0005, &mut rng);
                    values[1] *= factor;
                    let Repeats::Without(list) = judge(&values, &declared(u), 9) else {
                        panic!("{n} {factor} {u}");
                    };
                    assert_eq!((list.len(), list[0].index), (1, 1));
                    assert!((list[0].factor - factor).norm() < 0.05 * factor.abs());
                }
            }
        }
        // Two of seven do not hide each other.
        let mut values = sound(7, 0.0005, &mut rng);
        values[0] *= 10.0;
        values[4] *= 10.0;
        assert!(matches!(judge(&values, &declared(0.001), 9), Repeats::Without(l) if l.len() == 2));
        // Of two nobody says which.
        let mut values = sound(2, 0.0005, &mut rng);
        values[0] *= 10.0;
        assert!(matches!(judge(&values, &declared(0.001), 9), Repeats::Apart(r, _) if r > 9.0));
        assert_eq!(judge(&values, &declared(0.0), 9), Repeats::Alike);
    }

    /// Campaigns of nine frequencies with scatter as declared, with three times as much, and with nothing declared.
    #[test]
    fn known_false_alarm_rate_of_repeats() {
        let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(6);
        let campaigns = 2000;
        for (scatter, said) in [(0.001, 0.001), (0.03, 0.03), (0.03, 0.01), (0.03, 0.0)] {
            for n in [2, 3, 5, 10] {
                let mut alarms = 0;
                for _ in 0..campaigns {
                    let told = (0..9).any(|_| {
                        let values = sound(n, scatter, &mut rng);
                        match judge(&values, &declared(said), 9) {
                            Repeats::Alike => false,
                            Repeats::Without(_) => true,
                            // Scatter three times the declared one is a fault of the declaration.
                            Repeats::Apart(..) => said == scatter,
                        }
                    });
                    alarms += u32::from(told);
                }
                println!("{scatter} {said} {n}: {alarms} of {campaigns}");
                // One in a thousand campaigns, or frequencies where more scatter than is declared; two, and four standard deviations.
                let most = if said > 0.0 && said < scatter { 40 } else { 9 };
                assert!(alarms <= most, "{scatter} {said} {n}: {alarms}");
            }
        }
    }
}
