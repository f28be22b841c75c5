//! Runs whose outputs have phases that nobody knows: of outputs that were sampled by another clock than the reference one in common, of
//! outputs of which the moduli alone were read each its own ([`unread_phases`](super::unread_phases)).
//!
//! With another clock o = e^{jφ} a S with φ of each run free. A common phase of S at a frequency is one with the φ of all runs, so S is
//! stated with a main term that is real and positive; its moduli, and its phases relative to that term, are determined by
//! runs that excite two axes together. The φ are found here well enough for a linear model; in the adjustment the outputs
//! of a run are turned to where they are predicted, and the direction of a turn that is free has no weight.

use super::excitation::{directions, solve};
use super::matrix::{Matrix, row_times};
use super::observation::{OutputPhases, PhasorRow, SpuriousTable, ascending};
use super::unread_phases::restored;
use num_complex::Complex64;

/// Standard deviation of a phase that nobody knows, rad: that of an even one over the whole turn. Beside it every reading is
/// exact, so that its size matters nowhere.
const UNKNOWN: f64 = 1.813_8;
/// Share of the largest main term that the x axis must have for phases to be counted from it.
const FAINT: f64 = 1.0 / 3.0;
/// Share of the excitation along each of two axes with which a run excites them together.
const TOGETHER: f64 = 0.03;
/// Alternations between phases and S.
const ROUNDS: usize = 60;
/// Misfit over signal up to which the phases that the rows come with are a good start.
const NEAR: f64 = 0.1;

impl PhasorRow {
    /// Outputs over the reference, turned by the phases that nobody knows to where they are nearest to a prediction.
    pub(super) fn nearest(&self, prediction: &[Complex64; 3]) -> [Complex64; 3] {
        let y = self.ratios();
        match self.phases {
            OutputPhases::Measured => y,
            OutputPhases::InCommon => nearest(y, prediction),
            OutputPhases::Unread => std::array::from_fn(|j| {
                let size = prediction[j].norm();
                let along = if size > 0.0 {
                    prediction[j] / size
                } else {
                    Complex64::ONE
                };
                along * y[j].norm()
            }),
        }
    }

    /// What no weight may lie on: derivatives of outputs over the reference by what is unknown, of the size of a standard deviation.
    pub(super) fn unknown(&self, y: &[Complex64; 3]) -> Vec<[Complex64; 3]> {
        let turn = Complex64::new(0.0, UNKNOWN);
        let alone = |j: usize, v: Complex64| -> [Complex64; 3] {
            std::array::from_fn(|k| if k == j { v } else { Complex64::ZERO })
        };
        match self.phases {
            OutputPhases::Measured => vec![],
            OutputPhases::InCommon => vec![y.map(|y| turn * y)],
            OutputPhases::Unread => (0..3)
                .flat_map(|j| match self.tells(j) {
                    true => vec![alone(j, turn * y[j])],
                    // Not the size either, whose sense is not told: the unit of y is that of the main terms.
                    false => vec![alone(j, turn), alone(j, Complex64::new(UNKNOWN, 0.0))],
                })
                .collect(),
        }
    }
}

/// The outputs turned by the phase that brings them nearest to a prediction.
fn nearest(y: [Complex64; 3], prediction: &[Complex64; 3]) -> [Complex64; 3] {
    let along: Complex64 = (0..3).map(|j| y[j] * prediction[j].conj()).sum();
    if along.norm() > 0.0 {
        let turn = along.conj() / along.norm();
        y.map(|y| y * turn)
    } else {
        y
    }
}

/// The terms of S whose imaginary part is zero since phases count from them, by their place among its 18 reals: of outputs with one
/// unknown phase the origin, without phases all that is stated.
pub(super) fn real_terms(rows: &[&PhasorRow], s: &Matrix) -> Vec<usize> {
    match rows
        .iter()
        .map(|r| r.phases)
        .find(|p| *p != OutputPhases::Measured)
    {
        None | Some(OutputPhases::Measured) => vec![],
        Some(OutputPhases::InCommon) => vec![8 * origin(s) + 1],
        Some(OutputPhases::Unread) => (0..9).map(|k| 2 * k + 1).collect(),
    }
}

/// The main term from which the phases of S are counted: that of x, unless it is faint beside another.
pub(super) fn origin(s: &Matrix) -> usize {
    let main = [0, 1, 2].map(|k| s[k][k].norm());
    let largest = main.iter().copied().fold(0.0, f64::max);
    (0..3).find(|&k| main[k] >= FAINT * largest).unwrap_or(0)
}

/// Rows of all frequencies with the free phases of their runs taken out: those that agree best with one S at each
/// frequency, whose origin of phase is real.
pub(super) fn aligned(rows: &[PhasorRow], spurious: &SpuriousTable) -> Vec<PhasorRow> {
    let mut rows = rows.to_vec();
    let frequencies = ascending(rows.iter().map(|r| r.frequency));
    for f in frequencies {
        let here: Vec<usize> = (0..rows.len())
            .filter(|&i| rows[i].frequency == f)
            .collect();
        if here.len() < 3 || !here.iter().all(|&i| rows[i].is_free()) {
            continue;
        }
        let of: Vec<PhasorRow> = here.iter().map(|&i| rows[i].clone()).collect();
        let d = directions(&of, spurious);
        let y: Vec<[Complex64; 3]> = of.iter().map(PhasorRow::ratios).collect();
        let unread = of.iter().any(|r| r.phases == OutputPhases::Unread);
        let found = match unread {
            true => restored(&of, &d, &y),
            false => best(&d, &y),
        };
        let Some((turned, s)) = found else {
            continue;
        };
        let k = origin(&s);
        let common = if s[k][k].norm() > 0.0 && !unread {
            s[k][k].conj() / s[k][k].norm()
        } else {
            Complex64::ONE
        };
        for (&i, y) in here.iter().zip(turned) {
            let reference = rows[i].reference;
            rows[i].outputs = y.map(|y| y * common * reference);
        }
    }
    rows
}

/// Whether the runs of every frequency with a phase in common tie the phases of the three axes to each other: each axis is excited
/// together with another one.
pub(super) fn tied(rows: &[PhasorRow], spurious: &SpuriousTable) -> bool {
    let common = |r: &&PhasorRow| r.phases == OutputPhases::InCommon;
    let frequencies = ascending(rows.iter().filter(common).map(|r| r.frequency));
    frequencies.iter().all(|f| {
        let here: Vec<PhasorRow> = rows.iter().filter(|r| r.frequency == *f).cloned().collect();
        let mut pairs = [false; 3];
        for d in directions(&here, spurious) {
            for (k, pair) in pairs.iter_mut().enumerate() {
                *pair |= d[k].norm().min(d[(k + 1) % 3].norm()) > TOGETHER;
            }
        }
        pairs.iter().filter(|p| **p).count() >= 2
    })
}

/// Turned outputs and the S they agree with.
type Agreement = (Vec<[Complex64; 3]>, Matrix);

fn best(d: &[[Complex64; 3]], y: &[[Complex64; 3]]) -> Option<Agreement> {
    let all: Vec<usize> = (0..y.len()).collect();
    let power: f64 = y.iter().flatten().map(|y| y.norm_sqr()).sum();
    // As they are: rows that were aligned before stay where they are.
    if let Some(start) = solve(d, y, &all) {
        let (turned, s, misfit) = alternate(d, y, start, &all)?;
        if misfit < NEAR * NEAR * power {
            return Some((turned, s));
        }
    }
    // Any channel on any axis, in either sense: S is near one of these.
    let orders = [
        [0, 1, 2],
        [1, 0, 2],
        [2, 1, 0],
        [0, 2, 1],
        [1, 2, 0],
        [2, 0, 1],
    ];
    let mut best: Option<(f64, Agreement)> = None;
    for order in orders {
        for bits in 0..4u8 {
            let mut s: Matrix = [[Complex64::ZERO; 3]; 3];
            for (j, axis) in order.into_iter().enumerate() {
                let inverted = j > 0 && bits >> (j - 1) & 1 == 1;
                s[axis][j] = Complex64::new(if inverted { -1.0 } else { 1.0 }, 0.0);
            }
            let Some((turned, s, misfit)) = alternate(d, y, s, &all) else {
                continue;
            };
            if best.as_ref().is_none_or(|(least, _)| misfit < *least) {
                best = Some((misfit, (turned, s)));
            }
        }
    }
    best.map(|b| b.1)
}

/// Phases for S, S for phases, in turn; the misfit is that of the better half of the runs, twice, so that a wild one says
/// nothing.
fn alternate(
    d: &[[Complex64; 3]],
    y: &[[Complex64; 3]],
    start: Matrix,
    all: &[usize],
) -> Option<(Vec<[Complex64; 3]>, Matrix, f64)> {
    let mut s = start;
    let turn = |s: &Matrix| -> Vec<[Complex64; 3]> {
        let pairs = d.iter().zip(y);
        pairs.map(|(d, y)| nearest(*y, &row_times(*d, s))).collect()
    };
    let half = all.len().div_ceil(2);
    let mut misfit = f64::INFINITY;
    let mut turned = turn(&s);
    for _ in 0..ROUNDS {
        s = solve(d, &turned, all)?;
        turned = turn(&s);
        let mut misfits: Vec<f64> = (0..d.len())
            .map(|i| {
                let m = row_times(d[i], &s);
                (0..3).map(|j| (turned[i][j] - m[j]).norm_sqr()).sum()
            })
            .collect();
        misfits.sort_by(f64::total_cmp);
        let next = 2.0 * misfits[..half].iter().sum::<f64>();
        if !(next < misfit * (1.0 - 1e-6)) {
            misfit = misfit.min(next);
            break;
        }
        misfit = next;
    }
    Some((turned, s, misfit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::published_plan;

    #[test]
    fn law_free_phases_are_found() {
        // Two channels swapped, one inverted, complex cross terms of 5 %, and every run at a phase of its own.
        let c = Complex64::new;
        let s: Matrix = [
            [c(0.05, 0.02), c(-1.1, 0.1), c(0.03, 0.0)],
            [c(0.9, 0.2), c(0.02, -0.05), c(0.0, 0.01)],
            [c(-0.04, 0.01), c(0.01, 0.03), c(1.2, -0.3)],
        ];
        let rows: Vec<PhasorRow> = published_plan()
            .into_iter()
            .enumerate()
            .map(|(i, configuration)| {
                let d = configuration.direction().map(|d| c(d, 0.0));
                let turn = Complex64::from_polar(1.0, 2.4 * i as f64);
                PhasorRow {
                    phases: OutputPhases::InCommon,
                    ..PhasorRow::new(
                        "r",
                        80.0,
                        configuration,
                        c(10.0, 0.0),
                        row_times(d, &s).map(|o| 10.0 * o * turn),
                    )
                }
            })
            .collect();
        let spurious = SpuriousTable::default();
        let rows = aligned(&rows, &spurious);
        let (d, y) = (
            directions(&rows, &spurious),
            rows.iter().map(PhasorRow::ratios).collect::<Vec<_>>(),
        );
        let all: Vec<usize> = (0..rows.len()).collect();
        let found = solve(&d, &y, &all).unwrap();
        // Relative to S_zz, the only main term of some size.
        let turn = s[2][2].conj() / s[2][2].norm();
        for i in 0..3 {
            for j in 0..3 {
                assert!((found[i][j] - s[i][j] * turn).norm() < 1e-3, "{found:?}");
            }
        }
    }
}
