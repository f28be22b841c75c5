//! Resonances of a measured frequency response, each from the lines around it.

mod peaks;

use num_complex::Complex64;
use peaks::{Curve, Peak};
use proofmass_core::Error;
use proofmass_signal::transfer::{ResponseEstimate, Smearing};
use proofmass_uncertainty::adjustment::{Equations, adjust, cholesky, solve};
use serde::Serialize;

/// One resonance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Resonance {
    /// Undamped natural frequency, Hz.
    pub frequency: f64,
    /// Its standard uncertainty, Hz.
    pub frequency_uncertainty: f64,
    /// Damping ratio.
    pub damping: f64,
    /// Its standard uncertainty.
    pub damping_uncertainty: f64,
    /// Degrees of freedom of both uncertainties.
    pub freedom: f64,
    /// Modulus of the line at the peak.
    pub modulus: f64,
    /// Coherence there.
    pub coherence: Option<f64>,
}

/// Parameters of an oscillator and what is beside it: frequency, damping, three complex terms of the numerator.
const P: usize = 8;
/// Damping from which on nothing is called a resonance: the modulus hardly rises.
const DULL: f64 = 0.5;
/// By how much χ² has to fall, per unit of its scatter, where an oscillator takes the place of a parabola. Noise reaches it once in 10⁶
/// peaks that are looked at.
const TOLD: f64 = 30.0;
/// Lines of a window from which on what the width of a line makes of them is not seen.
const WIDE: usize = 300;
/// Degrees of freedom that variances of neighbouring lines share: those of a few averages scatter too much for weights.
const POOLED: f64 = 30.0;
/// Step of the derivatives, in natural units.
const STEP: f64 = 1e-6;

/// Resonances between two frequencies, the lowest first.
///
/// Peaks are looked for in means of |H|² over 1, 3, 5, 9, 17, … lines, so that neither a peak of one line nor one of thousands is missed: a
/// mean that is the greatest around, rises above the higher of the two valleys beside it by ten standard uncertainties and by a fifth
/// of the modulus. To the lines of each, down to half of its modulus,
///
/// H(f) = (c₀ + c₁x + c₂x²)/(1 − r² + 2jζr), r = f/f₀, x = f/f_peak − 1, c complex,
///
/// is fitted as `smearing` makes it look (as it is, when `None`). The numerator has what other modes, a delay or a filter add. What a
/// parabola describes as well, what is damped by more than a half, or known to half of its damping and worse, is no resonance. Of
/// several fits to one peak that of the narrowest mean is kept.
///
/// **Accuracy** white noise through one mode or two, ζ from 0.002 to 0.3, segments of 1024 to 32 768 samples: see
/// `docs/dynamic-tests.md`.
///
/// **Source** `[Ewins2000] 4.4` for a fit to the lines of one peak.
pub fn resonances(
    response: &ResponseEstimate,
    smearing: Option<&Smearing>,
    low: f64,
    high: f64,
) -> Vec<Resonance> {
    let response = response.within(low, high);
    let curve = Curve::of(&response, POOLED);
    let peaks = curve.peaks();
    let found = peaks.iter();
    let found = found.filter_map(|peak| of_peak(&response, &curve, smearing, peak));
    // Not the one with the least uncertainty: it would be the one that came out too wide.
    let mut kept: Vec<Resonance> = Vec::new();
    for one in found {
        if !kept.iter().any(|other| same(&one, other, curve.step)) {
            kept.push(one);
        }
    }
    kept.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
    kept
}

/// Whether two fits are of one resonance: nearer than the sharper one's half width, than their uncertainties, or than two lines.
fn same(a: &Resonance, b: &Resonance, line: f64) -> bool {
    let width = (a.damping * a.frequency).min(b.damping * b.frequency);
    let u = a.frequency_uncertainty.hypot(b.frequency_uncertainty);
    (a.frequency - b.frequency).abs() <= width.max(2.0 * u).max(2.0 * line)
}

fn of_peak(
    response: &ResponseEstimate,
    curve: &Curve,
    smearing: Option<&Smearing>,
    peak: &Peak,
) -> Option<Resonance> {
    let lines = peak.from..peak.to + 1;
    let frequency = &response.frequency[lines.clone()];
    let (first, last) = (*frequency.first()?, *frequency.last()?);
    let centre = response.frequency[peak.line];
    let window = Window {
        frequency,
        value: &response.value[lines.clone()],
        sigma: curve.variance[lines].iter().map(|v| v.sqrt()).collect(),
        centre,
        reach: (centre - first).max(last - centre),
        width: (0.3 * (last - first) / centre).clamp(1e-4, 0.4),
        smearing: smearing.filter(|_| frequency.len() <= WIDE),
    };
    let freedom = (2 * frequency.len()).checked_sub(P).filter(|f| *f >= 2)? as f64;
    let fit = window.fit()?;
    // Neighbours repeat each other: fewer readings than lines, whose scatter the stated variances have.
    let every = response.independent_every.max(1) as f64;
    let scatter = every * (fit.cost / freedom).max(1.0);
    let (f, zeta) = (fit.frequency, fit.damping);
    let [uf, uz] = fit.standard.map(|u| u * scatter.sqrt());
    let told = (window.parabola()? - fit.cost) / scatter;
    let rises = f > first && f < last && curve.rises(response, f, zeta);
    (told > TOLD && rises && zeta < DULL && 2.0 * uz < zeta).then(|| Resonance {
        frequency: f,
        frequency_uncertainty: uf,
        damping: zeta,
        damping_uncertainty: uz,
        freedom: freedom / every,
        modulus: response.value[peak.line].norm(),
        coherence: response.coherence.get(peak.line).copied(),
    })
}

/// The lines of one peak.
struct Window<'a> {
    frequency: &'a [f64],
    value: &'a [Complex64],
    /// Standard uncertainty of the parts of each.
    sigma: Vec<f64>,
    centre: f64,
    /// Distance of the farthest line from it.
    reach: f64,
    /// ζ about, by the width of the window.
    width: f64,
    smearing: Option<&'a Smearing>,
}

struct OneMode {
    frequency: f64,
    damping: f64,
    /// Standard uncertainties of both, of independent lines with the stated variances.
    standard: [f64; 2],
    cost: f64,
}

impl Window<'_> {
    fn frequency(&self, p: f64) -> f64 {
        self.centre * (1.0 + self.width * p)
    }

    fn oscillator(&self, frequency: f64, [place, damping]: [f64; 2]) -> Complex64 {
        let r = frequency / self.frequency(place);
        Complex64::new(1.0 - r * r, 2.0 * damping.exp() * r).inv()
    }

    fn seen(&self, frequency: f64, of: impl Fn(f64) -> Complex64) -> Complex64 {
        match self.smearing {
            Some(smearing) => smearing.expected(frequency, of),
            None => of(frequency),
        }
    }

    /// Powers of the distance from the peak.
    fn powers(&self, frequency: f64) -> [f64; 3] {
        let x = (frequency - self.centre) / self.reach;
        [1.0, x, x * x]
    }

    /// The numerator that suits an oscillator (`None`: a parabola alone), and what is left.
    fn numerator(&self, shape: Option<[f64; 2]>) -> Option<([f64; 6], f64)> {
        let rows: Vec<[f64; 7]> = (0..self.frequency.len())
            .flat_map(|k| {
                let (f, h, w) = (self.frequency[k], self.value[k], 1.0 / self.sigma[k]);
                let mut row = [[0.0; 7]; 2];
                for (i, power) in self.powers(f).into_iter().enumerate() {
                    let basis = match shape {
                        // For H₁ as it is; for the others near enough to begin with.
                        Some(shape) => match self.smearing {
                            Some(s) => {
                                s.cross(f, |f| self.powers(f)[i] * self.oscillator(f, shape))
                            }
                            None => power * self.oscillator(f, shape),
                        },
                        None => Complex64::new(power, 0.0),
                    } * w;
                    (row[0][2 * i], row[0][2 * i + 1]) = (basis.re, -basis.im);
                    (row[1][2 * i], row[1][2 * i + 1]) = (basis.im, basis.re);
                }
                (row[0][6], row[1][6]) = (w * h.re, w * h.im);
                row
            })
            .collect();
        let mut normal = vec![0.0; 36];
        let mut right = vec![0.0; 6];
        for row in &rows {
            for a in 0..6 {
                right[a] += row[a] * row[6];
                for b in 0..6 {
                    normal[a * 6 + b] += row[a] * row[b];
                }
            }
        }
        let size: Vec<f64> = (0..6).map(|a| normal[a * 7].sqrt()).collect();
        if size.iter().any(|s| !(*s > 0.0 && s.is_finite())) {
            return None;
        }
        (0..36).for_each(|k| normal[k] /= size[k / 6] * size[k % 6]);
        (0..6).for_each(|a| right[a] /= size[a]);
        cholesky(&mut normal, 6)?;
        solve(&normal, &mut right);
        let c: [f64; 6] = std::array::from_fn(|a| right[a] / size[a]);
        let left = rows.iter().map(|row| {
            let fit: f64 = row.iter().zip(&c).map(|(a, b)| a * b).sum();
            (row[6] - fit).powi(2)
        });
        Some((c, left.sum()))
    }

    /// χ² of a parabola in place of the oscillator.
    fn parabola(&self) -> Option<f64> {
        self.numerator(None).map(|n| n.1)
    }

    fn fit(&self) -> Option<OneMode> {
        let mut best: Option<([f64; 2], [f64; 6], f64)> = None;
        for share in [0.1, 0.25, 0.5, 1.0, 1.5] {
            for place in [-0.6, -0.2, 0.0, 0.2, 0.6] {
                let shape = [share * place, (share * self.width).ln()];
                if let Some((c, cost)) = self.numerator(Some(shape))
                    && best.as_ref().is_none_or(|b| cost < b.2)
                {
                    best = Some((shape, c, cost));
                }
            }
        }
        let (shape, c, _) = best?;
        let scale = c.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let mut start = vec![shape[0], shape[1]];
        start.extend(c.iter().map(|v| v / scale));
        let weights = vec![1.0; 2 * self.frequency.len()];
        let equations = |v: &[f64]| self.equations(v, scale);
        let solution = adjust("resonance", &start, &weights, equations).ok()?;
        let e = &solution.equations;
        let mut normal = vec![0.0; P * P];
        for row in e.jacobian.chunks_exact(P) {
            for a in 0..P {
                for b in 0..P {
                    normal[a * P + b] += row[a] * row[b];
                }
            }
        }
        let size: Vec<f64> = (0..P).map(|a| normal[a * P + a].sqrt()).collect();
        (0..P * P).for_each(|k| normal[k] /= size[k / P] * size[k % P]);
        cholesky(&mut normal, P)?;
        let standard = [0, 1].map(|a| {
            let mut unit = vec![0.0; P];
            unit[a] = 1.0;
            solve(&normal, &mut unit);
            unit[a].sqrt() / size[a]
        });
        let damping = solution.parameters[1].exp();
        Some(OneMode {
            frequency: self.frequency(solution.parameters[0]),
            damping,
            standard: [
                self.centre * self.width * standard[0],
                damping * standard[1],
            ],
            cost: e.residual.iter().map(|r| r * r).sum(),
        })
    }

    fn equations(&self, v: &[f64], scale: f64) -> Result<Equations, Error> {
        let n = self.frequency.len();
        let mut e = Equations {
            residual: vec![0.0; 2 * n],
            jacobian: vec![0.0; 2 * n * P],
        };
        let near: Vec<[Vec<f64>; 2]> = (0..P)
            .map(|j| {
                [-STEP, STEP].map(|h| {
                    let mut w = v.to_vec();
                    w[j] += h;
                    w
                })
            })
            .collect();
        let model = |f: f64, v: &[f64]| {
            self.seen(f, |f| {
                let c = self.powers(f);
                let sum: Complex64 = (0..3)
                    .map(|i| c[i] * Complex64::new(v[2 + 2 * i], v[3 + 2 * i]))
                    .sum();
                scale * sum * self.oscillator(f, [v[0], v[1]])
            })
        };
        for k in 0..n {
            let (f, w) = (self.frequency[k], 1.0 / self.sigma[k]);
            let r = w * (model(f, v) - self.value[k]);
            if !(r.re.is_finite() && r.im.is_finite()) {
                return Err(Error::NotFinite {
                    name: "resonance",
                    index: k,
                });
            }
            (e.residual[2 * k], e.residual[2 * k + 1]) = (r.re, r.im);
            for (j, [low, high]) in near.iter().enumerate() {
                let d = w * (model(f, high) - model(f, low)) / (2.0 * STEP);
                e.jacobian[2 * k * P + j] = d.re;
                e.jacobian[(2 * k + 1) * P + j] = d.im;
            }
        }
        Ok(e)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Mode, TransducerModel};
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn response(seed: u64, noise: f64, modes: &[Mode]) -> ResponseEstimate {
        let model = TransducerModel {
            modes: modes.to_vec(),
            ..TransducerModel::flat(1.0)
        };
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut e = ResponseEstimate {
            independent_every: 1,
            ..ResponseEstimate::default()
        };
        for k in 1..800 {
            let f = 2.0 * f64::from(k);
            e.frequency.push(f);
            e.value
                .push(model.response(f) + noise * Complex64::new(normal(), normal()));
            e.covariance.push([noise * noise, 0.0, noise * noise]);
            e.dof.push(100.0);
        }
        e
    }

    const MODES: [Mode; 2] = [
        Mode {
            frequency: 310.0,
            damping: 0.02,
            share: 0.7,
        },
        Mode {
            frequency: 905.0,
            damping: 0.01,
            share: 0.3,
        },
    ];

    #[test]
    fn known_two_modes_are_listed() {
        let found = resonances(&response(1, 0.02, &MODES), None, 10.0, 1600.0);
        assert_eq!(found.len(), 2, "{found:?}");
        for (r, m) in found.iter().zip(MODES) {
            assert!((r.frequency / m.frequency - 1.0).abs() < 2e-3, "{r:?}");
            assert!((r.damping / m.damping - 1.0).abs() < 0.1, "{r:?}");
        }
    }

    #[test]
    fn known_modes_of_every_width() {
        // 2 Hz from line to line: from two lines to the half-power width to four hundred and fifty.
        for damping in [0.002, 0.005, 0.02, 0.05, 0.1, 0.2, 0.3] {
            let mode = Mode {
                frequency: 750.0,
                damping,
                share: 1.0,
            };
            for seed in 0..5 {
                let found = resonances(&response(seed, 0.1, &[mode]), None, 10.0, 1600.0);
                let [r] = found.as_slice() else {
                    panic!("ζ = {damping}: {found:?}");
                };
                // Four standard uncertainties: one of seventy readings in 200 such tests.
                let [f, z] = [r.frequency - 750.0, r.damping - damping];
                assert!(f.abs() < 4.0 * r.frequency_uncertainty, "{r:?}");
                assert!(z.abs() < 4.0 * r.damping_uncertainty, "{r:?}");
            }
        }
    }

    #[test]
    fn known_flank_of_a_filter_is_no_mode() {
        // A low-pass of fourth order, whose sharper poles have ζ = 0.38, behind a high-pass.
        let mut e = response(3, 0.02, &[]);
        for (z, f) in e.value.iter_mut().zip(&e.frequency) {
            let s = Complex64::new(0.0, f / 800.0);
            let low = (s * s + 0.765_37 * s + 1.0) * (s * s + 1.847_76 * s + 1.0);
            *z *= s / (s + 0.05) / low;
        }
        assert_eq!(resonances(&e, None, 2.0, 1600.0), []);
    }

    #[test]
    fn known_noise_is_no_mode() {
        let listed: usize = (0..20)
            .map(|seed| resonances(&response(seed, 0.2, &[]), None, 10.0, 1600.0).len())
            .sum();
        // 20 spectra of 800 lines.
        assert!(listed <= 1, "{listed}");
    }
}
