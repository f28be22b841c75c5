//! A start that no wild run can pull: which runs of one frequency most of the others agree about.

use super::budget::{Acts, Budget};
use super::excitation::{directions, solve};
use super::matrix::{Matrix, row_times};
use super::observation::{PhasorRow, SpuriousTable};

/// Triples of runs that a first S is taken from.
const TRIPLES: usize = 400;
/// Concentration steps of the trimmed fit.
const STEPS: usize = 5;
/// A run this many times the trimmed scatter away is wild: more than any error of a sound run adds up to.
const WILD: f64 = 12.0;

/// For each row of one frequency, whether it is far from what most of the others say.
///
/// Least trimmed squares: the S of the triple whose h = ⌊(n + 4)/2⌋ smallest misfits are least, improved by five
/// concentration steps; a run is wild when its misfit exceeds twelve times the trimmed root mean square and ten times
/// what the angles of the budget can do.
///
/// **Source** `[Rousseeuw1984]`; concentration steps `[Rousseeuw2006]`.
pub(super) fn wild(rows: &[PhasorRow], spurious: &SpuriousTable, budget: &Budget) -> Vec<bool> {
    strangeness(rows, spurious, budget)
        .iter()
        .map(|s| *s > 1.0)
        .collect()
}

/// Square of the misfit of every row of one frequency over the one from which on it is [`wild`]; zero where too few
/// runs are there to tell.
pub(super) fn strangeness(
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
) -> Vec<f64> {
    let n = rows.len();
    let sound = vec![0.0; n];
    if n < 6 {
        return sound;
    }
    let turned;
    let rows = if rows.iter().any(|r| r.is_free()) {
        turned = super::free_phase::aligned(rows, spurious);
        &turned
    } else {
        rows
    };
    let (d, y) = (
        directions(rows, spurious),
        rows.iter().map(PhasorRow::ratios).collect::<Vec<_>>(),
    );
    let h = (n + 4) / 2;
    let misfits = |s: &Matrix| -> Vec<f64> {
        (0..n)
            .map(|i| {
                let m = row_times(d[i], s);
                (0..3).map(|j| (y[i][j] - m[j]).norm_sqr()).sum::<f64>()
            })
            .collect()
    };
    let nearest = |q: &[f64], count: usize| -> Vec<usize> {
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| q[a].total_cmp(&q[b]));
        order.truncate(count);
        order
    };
    let trimmed = |q: &[f64]| -> f64 { nearest(q, h).iter().map(|&i| q[i]).sum() };
    // A fixed sequence: the same runs give the same answer.
    let mut state = 0x9E37_79B9_7F4A_7C15u64;
    let mut draw = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as usize) % n
    };
    let mut best: Option<(f64, Matrix)> = None;
    for _ in 0..TRIPLES {
        let three = [draw(), draw(), draw()];
        let plane = |i: usize| d[i].map(|z| z.re);
        let [a, b, c] = three.map(plane);
        let volume = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0]);
        if volume.abs() < 0.1 {
            continue;
        }
        let Some(s) = solve(&d, &y, &three) else {
            continue;
        };
        let size = trimmed(&misfits(&s));
        if best.as_ref().is_none_or(|(least, _)| size < *least) {
            best = Some((size, s));
        }
    }
    let Some((_, mut s)) = best else {
        return sound;
    };
    for _ in 0..STEPS {
        let q = misfits(&s);
        // In a plan of few runs six more would be all of them, the wild one too.
        match solve(&d, &y, &nearest(&q, h + ((n - h) / 2).min(6))) {
            Some(next) => s = next,
            None => break,
        }
    }
    let q = misfits(&s);
    let scatter = trimmed(&q) / h as f64;
    let main = s.iter().flatten().map(|z| z.norm_sqr()).sum::<f64>() / 3.0;
    let angles: f64 = budget
        .inputs
        .iter()
        .filter(|i| i.acts.is_angle())
        .map(|i| i.standard_uncertainty().powi(2) * if i.acts == Acts::Tilt { 2.0 } else { 1.0 })
        .sum();
    let limit = (WILD * WILD * scatter).max(100.0 * angles * main);
    q.iter().map(|&q| q / limit).collect()
}
