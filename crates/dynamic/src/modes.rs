//! Resonances of a measured frequency response, each from the lines around it.

use num_complex::Complex64;
use proofmass_signal::transfer::{ResponseEstimate, polar};
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
    /// Greatest modulus of the lines.
    pub modulus: f64,
    /// Coherence there.
    pub coherence: Option<f64>,
}

/// Resonances between two frequencies, the lowest first.
///
/// A line is taken for a peak when it is the greatest of nine and stands three expanded uncertainties above the lowest line
/// within ten to either side, and by a half of it. Around it, (s² + a₁s + a₀) H = b₀ + b₁s with real a and complex b is
/// a linear regression, whatever the modes beside it add. Where that gives no stable oscillator within the lines, there is none.
///
/// **Source** `[Ewins2000] 4.4` (line fit), in the form of `[Levy1959]`.
pub fn resonances(response: &ResponseEstimate, low: f64, high: f64) -> Vec<Resonance> {
    let n = response.value.len();
    let m: Vec<f64> = response.value.iter().map(|z| z.norm()).collect();
    let mut found: Vec<Resonance> = Vec::new();
    for k in 4..n.saturating_sub(4) {
        let f = response.frequency[k];
        if !(low..=high).contains(&f) || (k - 4..=k + 4).any(|i| m[i] > m[k]) {
            continue;
        }
        let around = k.saturating_sub(10)..(k + 11).min(n);
        let lowest = around.clone().map(|i| m[i]).fold(f64::INFINITY, f64::min);
        let (u, _) = polar(response.value[k], response.covariance[k]);
        if m[k] - lowest < 6.0 * u || m[k] < 1.5 * lowest {
            continue;
        }
        // As wide as the peak itself: down to a half of it.
        let below = (k.saturating_sub(60)..k).rev().find(|i| m[*i] < 0.5 * m[k]);
        let above = (k + 1..(k + 61).min(n)).find(|i| m[*i] < 0.5 * m[k]);
        let from = below.unwrap_or(k - 4).min(k - 3);
        let to = above.unwrap_or(k + 4).max(k + 3);
        let Some([fr, ufr, zeta, uzeta, freedom]) = local(response, from, to.min(n - 1), f) else {
            continue;
        };
        let inside = fr > response.frequency[from] && fr < response.frequency[to.min(n - 1)];
        if inside && zeta > 0.0 && zeta < 0.7 && uzeta < zeta {
            found.push(Resonance {
                frequency: fr,
                frequency_uncertainty: ufr,
                damping: zeta,
                damping_uncertainty: uzeta,
                freedom,
                modulus: m[k],
                coherence: response.coherence.get(k).copied(),
            });
        }
    }
    found
}

/// f, u(f), ζ, u(ζ) and their degrees of freedom from the lines `from`…`to`.
fn local(response: &ResponseEstimate, from: usize, to: usize, centre: f64) -> Option<[f64; 5]> {
    // s = jf/centre; unknowns a₁, a₀ (real), b₀, b₁ (complex): s² H + a₁ s H + a₀ H − b₀ − b₁ (x) = 0, x = f/centre − 1.
    const P: usize = 6;
    let mut normal = vec![0.0; P * P];
    let mut right = vec![0.0; P];
    let mut rows: Vec<([f64; P], f64)> = Vec::new();
    for k in from..=to {
        let r = response.frequency[k] / centre;
        let h = response.value[k];
        let scale = 1.0 / response.covariance[k][0].max(f64::MIN_POSITIVE).sqrt();
        let s = Complex64::new(0.0, r);
        let x = r - 1.0;
        let (sh, lead) = (s * h, -(s * s) * h);
        rows.push((
            [sh.re, h.re, -1.0, 0.0, -x, 0.0].map(|v| scale * v),
            scale * lead.re,
        ));
        rows.push((
            [sh.im, h.im, 0.0, -1.0, 0.0, -x].map(|v| scale * v),
            scale * lead.im,
        ));
    }
    let freedom = rows.len().checked_sub(P).filter(|f| *f >= 2)?;
    for (row, y) in &rows {
        for a in 0..P {
            right[a] += row[a] * y;
            for b in 0..P {
                normal[a * P + b] += row[a] * row[b];
            }
        }
    }
    let size: Vec<f64> = (0..P).map(|a| normal[a * P + a].sqrt()).collect();
    if size.iter().any(|s| !(*s > 0.0)) {
        return None;
    }
    for k in 0..P * P {
        normal[k] /= size[k / P] * size[k % P];
    }
    proofmass_uncertainty::adjustment::cholesky(&mut normal, P)?;
    let solve = |v: &[f64]| -> Vec<f64> {
        let mut x: Vec<f64> = v.iter().zip(&size).map(|(v, s)| v / s).collect();
        proofmass_uncertainty::adjustment::solve(&normal, &mut x);
        x.iter().zip(&size).map(|(x, s)| x / s).collect()
    };
    let theta = solve(&right);
    let residual: f64 = rows
        .iter()
        .map(|(row, y)| {
            let fit: f64 = row.iter().zip(&theta).map(|(a, b)| a * b).sum();
            (y - fit).powi(2)
        })
        .sum();
    let variance = residual / freedom as f64;
    let (a1, a0) = (theta[0], theta[1]);
    if !(a0 > 0.0 && a1 > 0.0) {
        return None;
    }
    let column = |a: usize| {
        let mut e = vec![0.0; P];
        e[a] = 1.0;
        solve(&e)
    };
    let (c1, c0) = (column(0), column(1));
    let (v11, v10, v00) = (variance * c1[0], variance * c1[1], variance * c0[1]);
    let root = a0.sqrt();
    let zeta = 0.5 * a1 / root;
    // dζ = dζ/da₁ da₁ + dζ/da₀ da₀.
    let (d1, d0) = (0.5 / root, -0.5 * zeta / a0);
    Some([
        centre * root,
        centre * 0.5 * v00.max(0.0).sqrt() / root,
        zeta,
        (d1 * d1 * v11 + 2.0 * d1 * d0 * v10 + d0 * d0 * v00)
            .max(0.0)
            .sqrt(),
        freedom as f64,
    ])
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
        let found = resonances(&response(1, 0.02, &MODES), 10.0, 1600.0);
        assert_eq!(found.len(), 2, "{found:?}");
        for (r, m) in found.iter().zip(MODES) {
            assert!((r.frequency / m.frequency - 1.0).abs() < 2e-3, "{r:?}");
            assert!((r.damping / m.damping - 1.0).abs() < 0.1, "{r:?}");
        }
    }

    #[test]
    fn known_noise_is_no_mode() {
        let listed: usize = (0..20)
            .map(|seed| resonances(&response(seed, 0.2, &[]), 10.0, 1600.0).len())
            .sum();
        // 20 spectra of 800 lines.
        assert!(listed <= 1, "{listed}");
    }
}
