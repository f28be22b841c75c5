//! Spurious motion from repeated measurements: complex ratios, and whether they may be averaged at all.

mod pool;

use super::matrix::AXES;
use super::observation::{Spurious, SpuriousTable};
use crate::findings;
use num_complex::Complex64;
use pool::Pool;
pub(crate) use pool::pooled;
use proofmass_core::Error;
use proofmass_uncertainty::{DegreesOfFreedom, Finding, Severity, f_quantile, welch_satterthwaite};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Ratio of a motion to the reference acceleration from a vibrometer: jΩ v/a.
///
/// **Units** v in m/s, a in m/s², frequency in Hz.
pub fn ratio_from_velocity(velocity: Complex64, reference: Complex64, frequency: f64) -> Complex64 {
    Complex64::new(0.0, std::f64::consts::TAU * frequency) * velocity / reference
}

/// The decoder of a vibrometer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Vibrometer {
    /// Sensitivity in V/(m/s).
    pub sensitivity: f64,
    /// Delay behind the motion, s.
    pub delay: f64,
    /// Relative standard uncertainty of the sensitivity.
    #[serde(default)]
    pub sensitivity_uncertainty: f64,
    /// Standard uncertainty of the delay, s.
    #[serde(default)]
    pub delay_uncertainty: f64,
}

impl Vibrometer {
    /// Velocity behind a voltage; the decoder speaks late by its delay.
    pub fn velocity(&self, voltage: Complex64, frequency: f64) -> Complex64 {
        voltage / self.sensitivity * Complex64::from_polar(1.0, TAU * frequency * self.delay)
    }

    /// Standard uncertainties of modulus (relative) and phase (rad) of every velocity at a frequency.
    pub fn standard_uncertainty(&self, frequency: f64) -> [f64; 2] {
        let phase = TAU * frequency * self.delay_uncertainty;
        [self.sensitivity_uncertainty, phase]
    }
}

/// Directions on a circle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CircularStatistics {
    /// Number of directions.
    pub count: usize,
    /// Mean direction in radians.
    pub mean: f64,
    /// Mean resultant length, 0 (scattered) to 1 (equal).
    pub resultant: f64,
    /// Probability of a resultant at least as long, were the directions uniform on the circle.
    pub rayleigh_p: f64,
    /// Circular standard deviation √(−2 ln R̄) in radians.
    pub standard_deviation: f64,
}

/// Mean direction, resultant length and the Rayleigh test of uniformity.
///
/// p = exp(√(1 + 4n + 4(n² − R²)) − (1 + 2n)), R = n R̄.
///
/// **Source** `[MardiaJupp2000]` 6.3.1, `[Zar2010]` 27.1.
///
/// # Errors
/// [`Error::TooFew`] without a direction.
///
/// ```
/// use proofmass_shaker::spurious::circular;
/// let together = circular(&[3.1, -3.1, 3.0, -3.0]).unwrap(); // about π: an ordinary mean would say 0
/// assert!((together.mean.abs() - std::f64::consts::PI).abs() < 1e-12);
/// assert!(together.rayleigh_p < 0.02);
/// ```
pub fn circular(phases: &[f64]) -> Result<CircularStatistics, Error> {
    if phases.is_empty() {
        return Err(Error::TooFew {
            name: "directions",
            needed: 1,
            got: 0,
        });
    }
    let n = phases.len() as f64;
    let sum: Complex64 = phases.iter().map(|&p| Complex64::from_polar(1.0, p)).sum();
    let (r, resultant) = (sum.norm(), (sum.norm() / n).min(1.0));
    let p = ((1.0 + 4.0 * n + 4.0 * (n * n - r * r).max(0.0)).sqrt() - (1.0 + 2.0 * n)).exp();
    Ok(CircularStatistics {
        count: phases.len(),
        mean: sum.arg(),
        resultant,
        rayleigh_p: p.min(1.0),
        standard_deviation: (-2.0 * resultant.max(f64::MIN_POSITIVE).ln())
            .max(0.0)
            .sqrt(),
    })
}

/// A mean ratio.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RatioEstimate {
    /// Mean of the complex ratios.
    pub mean: Complex64,
    /// Covariance `[rr, ri, ii]` of the mean.
    pub covariance: [f64; 3],
    /// Degrees of freedom.
    pub dof: f64,
    /// Number of repeats.
    pub repeats: usize,
}

/// What repeats of one ratio allow.
#[derive(Clone, Debug, PartialEq)]
pub enum Average {
    /// They agree in phase: a mean and its covariance.
    Coherent(RatioEstimate),
    /// Their moduli agree but their phases do not: no common clock. Only the modulus is known.
    Incoherent {
        /// Root mean square of the moduli.
        modulus: f64,
        /// The phases.
        phases: CircularStatistics,
    },
}

/// Rayleigh p above which phases of well defined ratios count as scattered.
const SCATTERED: f64 = 0.01;
/// Relative scatter of the moduli below which a ratio counts as well defined.
const DEFINED: f64 = 0.3;

/// Mean of repeated complex ratios, or the refusal to take one.
///
/// A ratio that is lost in noise scatters in modulus and phase alike, and its mean is rightly near zero. A ratio
/// whose moduli repeat while its phases cover the circle was recorded without a common clock: its mean would
/// be near zero too, and wrong.
///
/// Two repeats know their own scatter with one degree of freedom, which alone is next to nothing: [`table`] pools.
///
/// # Errors
/// [`Error::TooFew`] below two repeats, [`Error::NotFinite`].
pub fn average(ratios: &[Complex64]) -> Result<Average, Error> {
    let n = ratios.len();
    if n < 2 {
        return Err(Error::TooFew {
            name: "repeats",
            needed: 2,
            got: n,
        });
    }
    if let Some(index) = ratios
        .iter()
        .position(|z| !(z.re.is_finite() && z.im.is_finite()))
    {
        return Err(Error::NotFinite {
            name: "ratios",
            index,
        });
    }
    let count = n as f64;
    let mean: Complex64 = ratios.iter().sum::<Complex64>() / count;
    let phases: Vec<f64> = ratios.iter().map(|z| z.arg()).collect();
    let phases = circular(&phases)?;
    let modulus = ratios.iter().map(|z| z.norm()).sum::<f64>() / count;
    let scatter = (ratios
        .iter()
        .map(|z| (z.norm() - modulus).powi(2))
        .sum::<f64>()
        / (count - 1.0))
        .sqrt();
    let scattered = if n < 4 {
        // Too few for a test: more than a right angle apart is not one phase.
        phases.resultant < std::f64::consts::FRAC_PI_4.cos()
    } else {
        phases.rayleigh_p > SCATTERED
    };
    if scattered && scatter < DEFINED * modulus {
        let square = ratios.iter().map(|z| z.norm_sqr()).sum::<f64>() / count;
        return Ok(Average::Incoherent {
            modulus: square.sqrt(),
            phases,
        });
    }
    let mut covariance = [0.0; 3];
    for z in ratios {
        let d = z - mean;
        covariance[0] += d.re * d.re;
        covariance[1] += d.re * d.im;
        covariance[2] += d.im * d.im;
    }
    let covariance = covariance.map(|c| c / (count * (count - 1.0)));
    let dof = count - 1.0;
    Ok(Average::Coherent(RatioEstimate {
        mean,
        covariance,
        dof,
        repeats: n,
    }))
}

/// Repeats of the ratio along one axis, at one inclination and frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct RatioRepeats {
    /// Inclination in radians.
    pub inclination: f64,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Axis of the bench, 0 for x′ to 2 for z′.
    pub axis: usize,
    /// Measured ratios to the reference; along z′ the whole motion, near one.
    pub ratios: Vec<Complex64>,
}

/// A table of corrections from repeats, and what was refused.
///
/// The scatter of a reading is pooled over all ratios across the excitation at one frequency, and over those along
/// it: a few repeats of each know it together with ν = Σ (n − 1), and the table carries ν.
///
/// **Assumes** that at one frequency the readings of all wedges and of both transverse axes scatter alike.
///
/// Along z′ what enters is the departure from one. An axis that is refused or was not measured gets no
/// correction; a refused one gets an uncertainty of the size of its modulus in every direction, for that is
/// what is known.
///
/// # Errors
/// As [`average`]; [`Error::OutOfRange`] for an axis beyond z′.
pub fn table(campaign: &[RatioRepeats]) -> Result<(SpuriousTable, Vec<Finding>), Error> {
    let mut entries: Vec<Spurious> = vec![];
    let mut findings = vec![];
    let pools = Pool::all(campaign)?;
    for repeats in campaign {
        if repeats.axis > 2 {
            return Err(Error::OutOfRange {
                name: "axis",
                value: repeats.axis as f64,
                min: 0.0,
                max: 2.0,
            });
        }
        let key = |e: &Spurious| {
            (e.inclination - repeats.inclination).abs() < 1e-6 && e.frequency == repeats.frequency
        };
        let index = entries.iter().position(key).unwrap_or_else(|| {
            entries.push(Spurious {
                basis: Default::default(),
                inclination: repeats.inclination,
                frequency: repeats.frequency,
                ratio: [Complex64::new(0.0, 0.0); 3],
                covariance: [[0.0; 3]; 3],
                dof: DegreesOfFreedom::INFINITE,
            });
            entries.len() - 1
        });
        let entry = &mut entries[index];
        let whole = f64::from(repeats.axis == 2);
        let place = format!(
            "{}′ at inclination {:.0}°, {} Hz",
            AXES[repeats.axis],
            repeats.inclination.to_degrees(),
            repeats.frequency
        );
        match average(&repeats.ratios)? {
            Average::Coherent(estimate) => {
                entry.ratio[repeats.axis] = estimate.mean - whole;
                let pool = &pools[Pool::of(repeats)];
                let n = estimate.repeats as f64;
                entry.covariance[repeats.axis] = pool.sum.map(|s| s / (pool.dof * n));
                if let Some(dof) = DegreesOfFreedom::new(pool.dof)
                    && dof < entry.dof
                {
                    entry.dof = dof;
                }
                if estimate.repeats == 2 {
                    let few = proofmass_uncertainty::findings::few_degrees_of_freedom(
                        &format!("the spurious motion along {place}, from two repeats,"),
                        pool.dof,
                        "it is that of all ratios of its kind at this frequency: measure at least four",
                    );
                    findings.push(few.at(Severity::Note));
                }
            }
            Average::Incoherent { modulus, phases } => {
                // Along z′ only the departure from one is spurious, and of that only the modulus is known.
                let size = if repeats.axis == 2 {
                    (modulus - 1.0).abs()
                } else {
                    modulus
                };
                entry.covariance[repeats.axis] = [0.5 * size * size, 0.0, 0.5 * size * size];
                findings.push(findings::incoherent_repeats(
                    &place,
                    phases.count,
                    phases.resultant,
                    phases.standard_deviation.to_degrees(),
                    phases.rayleigh_p,
                ));
            }
        }
    }
    Ok((SpuriousTable::new(entries), findings))
}

/// Adds a ratio to the repeats of its place, which are begun where there are none: inclination (rad), frequency (Hz), axis; their
/// index.
pub fn gather(
    list: &mut Vec<RatioRepeats>,
    (inclination, frequency, axis): (f64, f64, usize),
    ratio: Complex64,
) -> usize {
    let same = |r: &RatioRepeats| {
        (r.inclination - inclination).abs() < 1e-6 && r.frequency == frequency && r.axis == axis
    };
    let k = list.iter().position(same).unwrap_or_else(|| {
        list.push(RatioRepeats {
            inclination,
            frequency,
            axis,
            ratios: Vec::new(),
        });
        list.len() - 1
    });
    list[k].ratios.push(ratio);
    k
}

/// What the repeats of one ratio say, for a reader who wants to see why they were averaged or refused.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RatioSummary {
    /// Inclination in radians.
    pub inclination: f64,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Axis of the bench, `x` for x′.
    pub axis: String,
    /// Moduli of the repeats.
    pub moduli: Vec<f64>,
    /// Their phases on the circle.
    pub phases: CircularStatistics,
    /// The mean, or why there is none.
    pub average: Average,
}

/// Statistics of every ratio of a campaign, in its order.
///
/// # Errors
/// As [`table`].
pub fn summaries(campaign: &[RatioRepeats]) -> Result<Vec<RatioSummary>, Error> {
    campaign
        .iter()
        .map(|repeats| {
            let axis = AXES.get(repeats.axis).ok_or(Error::OutOfRange {
                name: "axis",
                value: repeats.axis as f64,
                min: 0.0,
                max: 2.0,
            })?;
            let phases: Vec<f64> = repeats.ratios.iter().map(|z| z.arg()).collect();
            Ok(RatioSummary {
                inclination: repeats.inclination,
                frequency: repeats.frequency,
                axis: (*axis).to_owned(),
                moduli: repeats.ratios.iter().map(|z| z.norm()).collect(),
                average: average(&repeats.ratios)?,
                phases: circular(&phases)?,
            })
        })
        .collect()
}

/// Two measurements of the same spurious motion.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Comparison {
    /// Inclination in radians.
    pub inclination: f64,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Axis, `x` for x′.
    pub axis: String,
    /// Modulus of the difference of the two ratios.
    pub difference: f64,
    /// E_n for a complex quantity: √(dᵀ (C₁ + C₂)⁻¹ d/T²), T² = 2 ν/(ν − 1) F₀.₉₅(2, ν − 1) with the effective degrees of
    /// freedom of the difference (Hotelling); above one the two disagree at 95 %. `None` when neither has an
    /// uncertainty, or one that so few repeats do not tell.
    pub e_n: Option<f64>,
}

/// Hotelling's 95 % limit of T² for the difference of two complex ratios; `None` below two degrees of freedom.
///
/// **Source** `[Hotelling1931]`; degrees of freedom after Welch and Satterthwaite, by the traces.
fn limit(a: &Spurious, b: &Spurious, k: usize) -> Option<f64> {
    let size = |s: &Spurious| {
        (
            (s.covariance[k][0] + s.covariance[k][2]).max(0.0).sqrt(),
            s.dof,
        )
    };
    let nu = welch_satterthwaite(&[size(a), size(b)]);
    if nu.is_infinite() {
        return Some(5.991_465);
    }
    let nu = nu.get();
    (nu > 1.5).then(|| 2.0 * nu / (nu - 1.0) * f_quantile(0.95, 2.0, nu - 1.0))
}

/// Compares two tables where both have an entry.
pub fn compare(first: &SpuriousTable, second: &SpuriousTable) -> Vec<Comparison> {
    let mut result = vec![];
    for a in &first.entries {
        let Some(b) = second.get(a.inclination, a.frequency) else {
            continue;
        };
        for k in 0..3 {
            let d = a.ratio[k] - b.ratio[k];
            let [rr, ri, ii]: [f64; 3] =
                std::array::from_fn(|p| a.covariance[k][p] + b.covariance[k][p]);
            let determinant = rr * ii - ri * ri;
            let q = (d.re * d.re * ii - 2.0 * d.re * d.im * ri + d.im * d.im * rr) / determinant;
            result.push(Comparison {
                inclination: a.inclination,
                frequency: a.frequency,
                axis: AXES[k].to_owned(),
                difference: d.norm(),
                e_n: limit(a, b, k)
                    .filter(|_| determinant > 0.0)
                    .map(|t| (q / t).sqrt()),
            });
        }
    }
    result
}

impl SpuriousTable {
    /// What is not known of the delay between the channels (s) turns every ratio: along z′ the whole motion, of which the departure
    /// from the excitation is the small part.
    pub fn delayed(&mut self, delay: f64) {
        for entry in &mut self.entries {
            let phase = TAU * entry.frequency * delay;
            for (axis, (z, c)) in entry.ratio.iter().zip(&mut entry.covariance).enumerate() {
                // An axis that was not measured has no ratio to turn.
                if c[0] + c[2] > 0.0 {
                    let turn = Complex64::new(0.0, phase) * (z + f64::from(axis == 2));
                    c[0] += turn.re * turn.re;
                    c[1] += turn.re * turn.im;
                    c[2] += turn.im * turn.im;
                }
            }
        }
    }
}

/// P(X ≥ `count`) of `of` ratios that each lie beyond their 95 % limit by chance.
fn by_chance(count: usize, of: usize) -> f64 {
    let mut probability = 0.95f64.powi(of as i32);
    let mut below = 0.0;
    for k in 0..count {
        below += probability;
        probability *= (of - k) as f64 / (k + 1) as f64 * 0.05 / 0.95;
    }
    1.0 - below
}

/// How many ratios of two measurements lie apart (E_n > 1), and the worst of them, where they are more than chance has in one campaign
/// of two hundred, or one lies far apart (E_n above 3).
pub fn disagreeing(list: &[Comparison]) -> Option<(usize, &Comparison)> {
    let apart: Vec<&Comparison> = list
        .iter()
        .filter(|c| c.e_n.is_some_and(|e| e > 1.0))
        .collect();
    let worst = apart
        .iter()
        .max_by(|a, b| a.e_n.unwrap_or(0.0).total_cmp(&b.e_n.unwrap_or(0.0)))?;
    if by_chance(apart.len(), list.len()) > 0.005 && worst.e_n.unwrap_or(0.0) <= 3.0 {
        return None;
    }
    Some((apart.len(), worst))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_phase_scatter_is_refused() {
        // Ten repeats of 0.9 % whose moduli agree to 3 % and whose phases cover the circle: no common clock.
        let ratios: Vec<Complex64> = (0..10)
            .map(|i| {
                Complex64::from_polar(0.009 * (1.0 + 0.003 * f64::from(i)), 2.4 * f64::from(i))
            })
            .collect();
        assert!(matches!(
            average(&ratios).unwrap(),
            Average::Incoherent { .. }
        ));
        let (table, findings) = table(&[RatioRepeats {
            inclination: 1.0,
            frequency: 5.0,
            axis: 1,
            ratios,
        }])
        .unwrap();
        assert_eq!(findings[0].code(), "incoherent-repeats");
        assert_eq!(table.entries[0].ratio[1], Complex64::new(0.0, 0.0));
        assert!((table.entries[0].covariance[1][0].sqrt() - 0.0091 / 2f64.sqrt()).abs() < 1e-4);
    }

    #[test]
    fn published_phases_at_the_cut_have_a_direction() {
        // Seven repeats just above −180° and three just below +180°: linear mean −71° and standard deviation
        // 171°, as printed along z′ (−69.3°, 173.6°). On the circle they agree to a few degrees.
        let degrees: Vec<f64> = [
            -177.0, -176.0, -178.0, -175.0, -177.5, -176.5, -178.5, 177.0, 178.0, 176.0,
        ]
        .to_vec();
        let mean = degrees.iter().sum::<f64>() / 10.0;
        let s = (degrees.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / 9.0).sqrt();
        assert!(
            (mean + 71.0).abs() < 1.0 && (s - 171.0).abs() < 1.0,
            "{mean} {s}"
        );
        let phases: Vec<f64> = degrees.iter().map(|d| d.to_radians()).collect();
        let c = circular(&phases).unwrap();
        assert!(c.standard_deviation.to_degrees() < 4.0 && c.rayleigh_p < 1e-3);
        let ratios: Vec<Complex64> = phases
            .iter()
            .map(|&p| Complex64::from_polar(0.006, p))
            .collect();
        assert!(matches!(average(&ratios).unwrap(), Average::Coherent(_)));
    }

    #[test]
    fn law_noise_about_zero_is_averaged() {
        // A ratio lost in noise: moduli scatter too, the mean is near zero and that is right.
        let ratios: Vec<Complex64> = (0..10)
            .map(|i| {
                Complex64::from_polar(0.001 * (1.0 + f64::from(i * 7 % 10)), 2.4 * f64::from(i))
            })
            .collect();
        let Average::Coherent(e) = average(&ratios).unwrap() else {
            panic!("refused");
        };
        assert!(e.mean.norm() < 3.0 * (e.covariance[0] + e.covariance[2]).sqrt());
    }

    #[test]
    fn law_two_repeats_have_one_degree_of_freedom() {
        let Average::Coherent(e) =
            average(&[Complex64::new(0.010, 0.002), Complex64::new(0.012, 0.002)]).unwrap()
        else {
            panic!("refused");
        };
        assert!((e.covariance[0].sqrt() - 0.001).abs() < 1e-12);
        assert_eq!(e.dof, 1.0);
    }

    /// Six wedges, three axes, n repeats of one motion with normal noise.
    fn measured(n: usize, rng: &mut rand_xoshiro::Xoshiro256PlusPlus) -> SpuriousTable {
        use rand_distr::{Distribution, StandardNormal};
        let mut campaign = vec![];
        for wedge in 0..6 {
            for axis in 0..3 {
                let whole = f64::from(axis == 2);
                let ratios = (0..n)
                    .map(|_| {
                        let mut normal = || -> f64 { StandardNormal.sample(rng) };
                        Complex64::new(whole + 0.01 + 1e-3 * normal(), 1e-3 * normal())
                    })
                    .collect();
                campaign.push(RatioRepeats {
                    inclination: 0.2 * f64::from(wedge),
                    frequency: 160.0,
                    axis: axis as usize,
                    ratios,
                });
            }
        }
        table(&campaign).unwrap().0
    }

    #[test]
    fn coverage_of_two_measurements_of_one_motion() {
        use rand::SeedableRng;
        let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(11);
        for n in [2, 3, 10] {
            let campaigns = 120;
            let (mut apart, mut all) = (0.0, 0.0);
            for _ in 0..campaigns {
                let (a, b) = (measured(n, &mut rng), measured(n, &mut rng));
                for c in compare(&a, &b) {
                    apart += f64::from(u8::from(c.e_n.is_some_and(|e| e > 1.0)));
                    all += 1.0;
                }
            }
            println!("{n} repeats: {:.3} of {all} above one", apart / all);
            // 5 % of 2160; pooled ratios of one campaign are not independent, so twice the binomial deviation, four
            // times.
            let half = 4.0 * 2.0 * (0.05f64 * 0.95 / all).sqrt();
            assert!((apart / all - 0.05).abs() < half, "{n}: {}", apart / all);
        }
    }

    #[test]
    fn published_rayleigh_critical_values() {
        // Critical R̄ for n = 10: 0.540 at 5 % and 0.656 at 1 % (`[Zar2010]` table B.34: z = 2.919 and 4.298).
        for (z, p) in [(2.919f64, 0.05), (4.298, 0.01)] {
            let (n, r) = (10.0f64, (z * 10.0).sqrt());
            let approximate =
                ((1.0 + 4.0 * n + 4.0 * (n * n - r * r)).sqrt() - (1.0 + 2.0 * n)).exp();
            assert!(
                (approximate / p - 1.0).abs() < 0.03,
                "{approximate} for {p}"
            );
        }
    }

    #[test]
    fn law_velocity_becomes_a_ratio() {
        let (f, a) = (40.0, Complex64::from_polar(1.0, 0.7));
        let v =
            Complex64::from_polar(0.01, -0.4) * a / Complex64::new(0.0, std::f64::consts::TAU * f);
        assert!((ratio_from_velocity(v, a, f) - Complex64::from_polar(0.01, -0.4)).norm() < 1e-15);
    }
}
