//! Figures read from a frequency response: bandwidths, resonance, damping by several ways.

use super::fit::ResponsePoints;
use crate::findings;
use num_complex::Complex64;
use proofmass_signal::transfer::polar;
use proofmass_uncertainty::Finding;
use serde::Serialize;

/// How far up the modulus stays within a departure from its reference value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Bandwidth {
    /// Relative departure: −0.292893 for −3 dB, ±0.05, ±0.1.
    pub departure: f64,
    /// Frequency of the first passage above the reference frequency, Hz; `None` when the band is not left.
    pub upper: Option<f64>,
    /// The last passage below it, Hz.
    pub lower: Option<f64>,
}

/// A damping ratio and where it is from.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct DampingReading {
    /// `half-power width`, `peak`, `phase at resonance`, `fit`.
    pub method: String,
    /// ζ.
    pub damping: f64,
    /// Standard uncertainty from the points.
    pub standard_uncertainty: f64,
}

/// What is read from the points without a model.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ResponseFigures {
    /// Frequency to which departures refer, Hz.
    pub reference_frequency: f64,
    /// Modulus there.
    pub reference: f64,
    /// −3 dB, ±5 %, ±10 %.
    pub bandwidths: Vec<Bandwidth>,
    /// Frequency of the greatest modulus, Hz, and how often it exceeds the reference; `None` without a peak.
    pub resonance: Option<(f64, f64)>,
    /// ζ, each its own way.
    pub damping: Vec<DampingReading>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl ResponseFigures {
    /// Reads the figures; departures refer to the modulus nearest to `reference_frequency` (the lowest point when `None`).
    /// `fitted` is ζ of the fitted model with its standard uncertainty.
    pub fn of(
        points: &ResponsePoints,
        reference_frequency: Option<f64>,
        fitted: Option<(f64, f64)>,
    ) -> Option<Self> {
        let mut order: Vec<usize> = (0..points.frequency.len()).collect();
        order.sort_by(|a, b| points.frequency[*a].total_cmp(&points.frequency[*b]));
        let f: Vec<f64> = order.iter().map(|k| points.frequency[*k]).collect();
        let s: Vec<Complex64> = order.iter().map(|k| points.value[*k]).collect();
        let c: Vec<[f64; 3]> = order.iter().map(|k| points.covariance[*k]).collect();
        let n = f.len();
        if n < 3 {
            return None;
        }
        let modulus: Vec<f64> = s.iter().map(|z| z.norm()).collect();
        let at = match reference_frequency {
            Some(wanted) => {
                (0..n).min_by(|a, b| (f[*a] - wanted).abs().total_cmp(&(f[*b] - wanted).abs()))?
            }
            None => 0,
        };
        let reference = modulus[at];
        if !(reference > 0.0) {
            return None;
        }
        let half_power = 1.0 - 0.5f64.sqrt();
        let bandwidths = [-half_power, 0.05, 0.1]
            .into_iter()
            .map(|departure| {
                // −3 dB is left downwards only; a tolerance to either side.
                let out = |k: usize| {
                    let d = modulus[k] / reference - 1.0;
                    if departure < 0.0 {
                        d < departure
                    } else {
                        d.abs() > departure
                    }
                };
                let cross = |inside: usize, outside: usize| {
                    let d = modulus[outside] / reference - 1.0;
                    let edge = reference * (1.0 + departure.abs() * d.signum());
                    let share = (edge - modulus[inside]) / (modulus[outside] - modulus[inside]);
                    f[inside] + share * (f[outside] - f[inside])
                };
                Bandwidth {
                    departure,
                    upper: (at + 1..n).find(|k| out(*k)).map(|k| cross(k - 1, k)),
                    lower: (0..at).rev().find(|k| out(*k)).map(|k| cross(k + 1, k)),
                }
            })
            .collect();
        let mut figures = Self {
            reference_frequency: f[at],
            reference,
            bandwidths,
            ..Self::default()
        };
        figures.resonance(&f, &s, &c, &modulus, fitted);
        Some(figures)
    }

    /// Without the greatest modulus and the dampings read from it, where no signal stands behind it.
    pub fn without_the_peak(&mut self) {
        self.resonance = None;
        self.damping.retain(|reading| reading.method == "fit");
        self.findings.clear();
    }

    /// Holds every damping that was read by itself against that of an oscillator fitted to the lines of the same peak: one that is twice as
    /// large, or half, is named where nothing else disagrees.
    pub fn beside(&mut self, damping: f64, standard_uncertainty: f64) {
        let apart_from_fit = |reading: &&DampingReading| {
            let u = reading.standard_uncertainty.hypot(standard_uncertainty);
            let ratio = reading.damping / damping;
            !(0.5..=2.0).contains(&ratio) && (reading.damping - damping).abs() > 3.0 * u
        };
        let (true, Some(reading)) = (
            self.findings.is_empty(),
            self.damping.iter().find(apart_from_fit),
        ) else {
            return;
        };
        let u = reading.standard_uncertainty.hypot(standard_uncertainty);
        let (own, fit) = (
            (reading.method.as_str(), reading.damping),
            ("fit to its lines", damping),
        );
        let (least, most) = if own.1 < fit.1 {
            (own, fit)
        } else {
            (fit, own)
        };
        let finding = findings::dampings_disagree(least.0, least.1, most.0, most.1, u);
        self.findings.push(finding);
    }

    fn resonance(
        &mut self,
        f: &[f64],
        s: &[Complex64],
        c: &[[f64; 3]],
        modulus: &[f64],
        fitted: Option<(f64, f64)>,
    ) {
        let n = f.len();
        let Some(top) = (0..n).max_by(|a, b| modulus[*a].total_cmp(&modulus[*b])) else {
            return;
        };
        let u = |k: usize| polar(s[k], c[k]).0;
        let gain = modulus[top] / self.reference;
        // A peak has two sides, and stands above its uncertainty.
        if top > 0 && top + 1 < n && gain > 1.02 && modulus[top] - self.reference > 3.0 * u(top) {
            let (x, y) = vertex(
                [f[top - 1], f[top], f[top + 1]],
                [modulus[top - 1], modulus[top], modulus[top + 1]],
            );
            let gain = y / self.reference;
            self.resonance = Some((x, gain));
            let relative = u(top) / modulus[top];
            // |S|max/S₀ = 1/(2ζ√(1 − ζ²)).
            let over_static = y / self.at_rest(x);
            let of_peak = (1.0 - 1.0 / (over_static * over_static)).max(0.0);
            let of_peak = (0.5 * (1.0 - of_peak.sqrt())).sqrt();
            // Distance of the lines in half of the half-power width. A parabola through 1/√(1 + δ²) at three points so far apart is too
            // low by 8 % of its cube at most; beyond one the lines step over the peak.
            let apart = 0.5 * (f[top + 1] - f[top - 1]) / (of_peak * x);
            let resolved = apart <= 1.0;
            let missed = 0.08 * apart.powi(3) / 3f64.sqrt();
            if gain > 1.2 && resolved {
                self.push("peak", of_peak, of_peak * relative.hypot(missed));
            }
            if gain > 2.0 && resolved {
                let edge = y * 0.5f64.sqrt();
                let below = (0..top).rev().find(|k| modulus[*k] < edge);
                let above = (top + 1..n).find(|k| modulus[*k] < edge);
                if let (Some(b), Some(a)) = (below, above) {
                    let line = |p: usize, q: usize| {
                        f[p] + (edge - modulus[p]) / (modulus[q] - modulus[p]) * (f[q] - f[p])
                    };
                    let width = line(a - 1, a) - line(b + 1, b);
                    let zeta = 0.5 * width / x;
                    // Passages through straight lines between points: a tenth of their distance.
                    let grid = 0.1 * ((f[a] - f[a - 1]).hypot(f[b + 1] - f[b])) / width;
                    self.push(
                        "half-power width",
                        zeta,
                        zeta * relative.hypot(grid).hypot(2.0 * missed),
                    );
                }
            }
        }
        // S₀/S = 1 − r² + 2jζr: where the phase passes −90° it is 2jζ.
        if let Some(k) = (1..n).find(|k| {
            let turned = |k: usize| s[k] * self.sign(s[0]);
            turned(*k).re <= 0.0 && turned(k - 1).re > 0.0 && turned(*k).im < 0.0
        }) {
            // Its inverse is nearly straight from line to line, however far they are apart.
            let [p, q] = [s[k - 1].inv(), s[k].inv()];
            let share = p.re / (p.re - q.re);
            let inverse = p + (q - p) * share;
            let at = f[k - 1] + (f[k] - f[k - 1]) * share;
            let zeta = 0.5 * self.at_rest(at) * inverse.norm();
            let of_line = |k: usize| u(k) / s[k].norm_sqr() / inverse.norm();
            let relative = of_line(k).max(of_line(k - 1));
            // 1 − r² is not straight: its passage is off by h²/(8 f).
            let bent = ((f[k] - f[k - 1]) / at).powi(2) / (8.0 * 3f64.sqrt());
            self.push("phase at resonance", zeta, zeta * relative.hypot(bent));
        }
        if let Some((zeta, u)) = fitted {
            self.push("fit", zeta, u);
        }
        let least = self
            .damping
            .iter()
            .min_by(|a, b| a.damping.total_cmp(&b.damping));
        let most = self
            .damping
            .iter()
            .max_by(|a, b| a.damping.total_cmp(&b.damping));
        if let (Some(least), Some(most)) = (least, most) {
            let u = least.standard_uncertainty.hypot(most.standard_uncertainty);
            let difference = most.damping - least.damping;
            if difference > 3.0 * u && difference > 0.05 * most.damping {
                let finding = findings::dampings_disagree(
                    &least.method,
                    least.damping,
                    &most.method,
                    most.damping,
                    u,
                );
                self.findings.push(finding);
            }
        }
    }

    /// S₀ by the modulus at the reference frequency, which a resonance has raised by 1/(1 − r²).
    fn at_rest(&self, resonance: f64) -> f64 {
        let r = self.reference_frequency / resonance;
        self.reference * if r < 0.5 { 1.0 - r * r } else { 1.0 }
    }

    fn sign(&self, first: Complex64) -> f64 {
        if first.re < 0.0 { -1.0 } else { 1.0 }
    }

    fn push(&mut self, method: &str, damping: f64, u: f64) {
        if damping.is_finite() && u.is_finite() && damping > 0.0 {
            self.damping.push(DampingReading {
                method: method.to_owned(),
                damping,
                standard_uncertainty: u,
            });
        }
    }
}

/// Vertex of the parabola through three points; the middle one when they lie on a line.
fn vertex(x: [f64; 3], y: [f64; 3]) -> (f64, f64) {
    let (a, b) = (x[0] - x[1], x[2] - x[1]);
    let (p, q) = (y[0] - y[1], y[2] - y[1]);
    let curvature = (p / a - q / b) / (a - b);
    if !(curvature < 0.0) {
        return (x[1], y[1]);
    }
    let slope = p / a - curvature * a;
    let shift = (-0.5 * slope / curvature).clamp(a, b);
    (
        x[1] + shift,
        y[1] + slope * shift + curvature * shift * shift,
    )
}
