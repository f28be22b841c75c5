//! Densities of the noise terms as a finite record in cosines shows them, with averaging.

use crate::cosine_spectrum::{CosineSpectrum, Node};
use crate::model::markov_density;
use crate::{Term, model};
use std::f64::consts::PI;

/// A process of unit square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Process {
    /// One of Q, N, B, K.
    Power(Term),
    /// First-order Gauss–Markov process of this correlation time in s.
    Markov(f64),
}

/// Density of a process over the bins; `averaged` samples were averaged into each of the record's.
pub(crate) fn column(spectrum: &CosineSpectrum, process: Process, averaged: usize) -> Vec<f64> {
    let rate = spectrum.sample_rate;
    spectrum.average(|node| at(process, node, rate, averaged))
}

fn at(process: Process, node: &Node, rate: f64, averaged: usize) -> f64 {
    match process {
        Process::Markov(time) => markov_density(time, node.frequency, rate),
        Process::Power(term) => {
            let s = 2.0 * rate * (PI * node.frequency / rate).sin();
            let plain = model::term_density(term, node.frequency, rate);
            match term {
                // Differences within the record: the first and the last phase error count once.
                Term::Quantisation => {
                    let cos = (0.5 * PI * node.k / node.n).cos();
                    plain + 8.0 * rate / node.n * cos * cos
                }
                // What the lowest cosines see of flicker noise, from its covariance.
                Term::Flicker => plain * flicker_share(node.k) * folded_flicker(node, averaged),
                // The average of a walk is smoother than the walk, whose steps it shares with its neighbours.
                Term::RandomWalk if averaged > 1 => {
                    let m = averaged as f64;
                    plain * (1.0 - (1.0 - 1.0 / (m * m)) * (s / rate).powi(2) / 6.0)
                }
                _ => plain,
            }
        }
    }
}

/// Variance of cosine k of flicker noise relative to its density.
fn flicker_share(k: f64) -> f64 {
    if k < 1.5 {
        0.7737
    } else if k < 2.5 {
        0.9028
    } else {
        1.0 - 2.0 / (PI * PI * k)
    }
}

/// Density of averages of m samples of flicker noise over that of flicker noise sampled at their rate.
///
/// Σ_j (sin x/(m |sin((x + πj)/m)|))³ over the m aliases, x = πf over the rate of the averages.
fn folded_flicker(node: &Node, averaged: usize) -> f64 {
    if averaged < 2 {
        return 1.0;
    }
    let x = 0.5 * PI * node.k / node.n;
    let m = averaged as f64;
    // Sixteen on either side hold all but 1e-4 of what is folded.
    (0..averaged.min(32))
        .map(|j| {
            let j = if j % 2 == 0 {
                f64::from(j as u32 / 2)
            } else {
                -f64::from(j as u32 / 2) - 1.0
            };
            (x.sin() / (m * ((x + PI * j) / m).sin().abs())).powi(3)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_densities_of_the_first_cosine() {
        let record = vec![0.0; 64];
        let spectrum = CosineSpectrum::new(&[&record], 1.0, &[]);
        for (term, expected) in [
            (Term::Quantisation, 0.129_742_891),
            (Term::White, 2.0),
            (Term::Flicker, 31.526_539_1),
            (Term::RandomWalk, 830.189_823),
        ] {
            let g = column(&spectrum, Process::Power(term), 1)[0];
            // The flicker share is given to four digits.
            let bound = if term == Term::Flicker { 1e-4 } else { 1e-8 };
            assert!((g / expected - 1.0).abs() < bound, "{term:?}: {g}");
        }
    }
}
