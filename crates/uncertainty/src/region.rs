//! Joint coverage regions of several outputs.

use crate::Covariance;
use crate::algebra::{cholesky, symmetric_eigenvalues};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Joint coverage regions of all outputs. **Source** `[S2] 7.7`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Region {
    /// k_p of the hyper-ellipsoid (y − ȳ)ᵀ U⁻¹ (y − ȳ) ≤ k_p².
    pub ellipsoid_factor: f64,
    /// Area (volume) of the hyper-ellipsoid.
    pub ellipsoid_content: f64,
    /// Area (volume) of the smallest region, from a mesh; two and three outputs only.
    pub smallest_content: Option<f64>,
}

/// Trials whose distances are found at a time.
const TOGETHER: usize = 1024;

/// The hyper-ellipsoid that holds the share p of the trials, and the smallest region; `None` for a singular
/// covariance.
pub(crate) fn region(
    columns: &[&Vec<f64>],
    moments: &[(f64, f64)],
    covariance: &Covariance,
    p: f64,
) -> Option<Region> {
    let (m, trials) = (columns.len(), columns[0].len());
    // Outputs that follow from one another span no region: all that is left is rounding and curvature.
    let mut correlation = covariance.to_mat();
    for i in 0..m {
        for j in 0..m {
            correlation[(i, j)] /= moments[i].1 * moments[j].1;
        }
    }
    let spread = symmetric_eigenvalues(&correlation, "eigenvalues of the correlation").ok()?;
    if !(spread.iter().copied().fold(f64::INFINITY, f64::min) > 1e-4) {
        return None;
    }
    let llt = cholesky(&covariance.to_mat()).ok()?;
    let l = llt.lower();
    // ‖L⁻¹(y − ȳ)‖², some trials at a time.
    let mut distances = vec![0.0; trials];
    distances
        .par_chunks_mut(TOGETHER)
        .enumerate()
        .for_each(|(chunk, distances)| {
            let first = chunk * TOGETHER;
            let mut z = Mat::from_fn(m, distances.len(), |i, t| {
                columns[i][first + t] - moments[i].0
            });
            solve_lower_triangular_in_place(l, z.as_mut(), Par::Seq);
            for (distance, z) in distances.iter_mut().zip(z.col_iter()) {
                *distance = z.squared_norm_l2();
            }
        });
    let q = ((p * trials as f64).ceil() as usize).clamp(1, trials) - 1;
    let (_, k2, _) = distances.select_nth_unstable_by(q, f64::total_cmp);
    let ellipsoid_factor = k2.sqrt();
    let root_determinant: f64 = (0..m).map(|i| l[(i, i)]).product();
    let half = 0.5 * m as f64;
    let unit_ball = std::f64::consts::PI.powf(half) / statrs::function::gamma::gamma(half + 1.0);
    let ellipsoid_content = unit_ball * ellipsoid_factor.powi(m as i32) * root_determinant;
    Some(Region {
        ellipsoid_factor,
        ellipsoid_content,
        // A mesh too coarse for the shape would say more than the ellipsoid does.
        smallest_content: (m <= 3)
            .then(|| smallest_region(columns, moments, p))
            .filter(|smallest| *smallest <= ellipsoid_content),
    })
}

/// The fullest cells of a mesh that together hold the share p of the trials. **Source** `[S2] 7.7.4`.
///
/// The mesh has about (trials/50)^(1/m) cells a side over ± 5 u, so that a cell near the middle holds enough to be
/// ranked.
fn smallest_region(columns: &[&Vec<f64>], moments: &[(f64, f64)], p: f64) -> f64 {
    let (m, trials) = (columns.len(), columns[0].len());
    let side = ((trials as f64 / 50.0).powf(1.0 / m as f64) as usize).clamp(4, 200);
    let mut counts = vec![0usize; side.pow(m as u32)];
    for t in 0..trials {
        let place = (0..m).try_fold(0, |place, i| {
            let (mean, u) = moments[i];
            let cell = (columns[i][t] - mean + 5.0 * u) / (10.0 * u) * side as f64;
            (cell >= 0.0 && cell < side as f64).then_some(place * side + cell as usize)
        });
        if let Some(place) = place {
            counts[place] += 1;
        }
    }
    counts.sort_unstable_by(|a, b| b.cmp(a));
    let wanted = (p * trials as f64) as usize;
    let mut held = 0;
    let cells = counts
        .iter()
        .take_while(|&&c| {
            let more = held < wanted;
            held += c;
            more
        })
        .count();
    let cell: f64 = moments
        .iter()
        .map(|(_, u)| 10.0 * u / side as f64)
        .product();
    cells as f64 * cell
}
