//! Units, senses and signs that are wrong in the whole campaign.

use super::super::adjustment::Adjustment;
use super::super::budget::Budget;
use super::super::fit::Fit;
use super::super::matrix::{AXES, Matrix};
use super::super::observation::{PhasorRow, SpuriousTable, ascending};
use super::super::phase_units::may_be_radians;
use super::super::robust::wild;
use crate::findings;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::{Finding, Severity};
use rayon::prelude::*;

/// How rotations are counted.
const CLOCKWISE: &str = "rotation is positive clockwise, seen from above on the device";

/// Phases that nobody measured: all outputs have phase 0 in every run, also where the excitation runs against an axis of the device.
pub(super) fn phases_not_measured(rows: &[PhasorRow]) -> Option<Finding> {
    let mut outputs = rows.iter().flat_map(|r| r.outputs);
    if rows.is_empty() || !outputs.all(|z| z.im == 0.0 && z.re >= 0.0) {
        return None;
    }
    let both = (0..3).any(|j| {
        let along = || rows.iter().map(|r| r.configuration.direction()[j]);
        along().any(|d| d > ALONG) && along().any(|d| d < -ALONG)
    });
    both.then(|| findings::phases_not_measured(rows.len()))
}

/// Component of the excitation along an axis from which on its sign is beyond doubt.
const ALONG: f64 = 0.2;

/// Whether each of reference and outputs is read in degrees where it is in radians, and what they are called.
const IN_RADIANS: [([bool; 4], &str); 6] = [
    ([true; 4], "phases of the table"),
    ([false, true, true, true], "phases of the three outputs"),
    ([true, false, false, false], "phases of the reference"),
    ([false, true, false, false], "phases of output x"),
    ([false, false, true, false], "phases of output y"),
    ([false, false, false, true], "phases of output z"),
];

/// Phases that were radians but read as degrees leave nothing outside ±π/180 rad · π: of all channels, or of one.
pub(super) fn phase_unit(
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
) -> Result<Option<Finding>, Error> {
    let phasors = |r: &PhasorRow| [r.reference, r.outputs[0], r.outputs[1], r.outputs[2]];
    let largest = |which: &[bool; 4]| {
        let of = |r: &PhasorRow| {
            let each = phasors(r).into_iter().zip(which);
            each.filter(|(_, in_radians)| **in_radians)
                .map(|(z, _)| z.arg().abs())
                .fold(0.0, f64::max)
        };
        rows.iter().map(of).fold(0.0, f64::max)
    };
    let candidates = || {
        let of = IN_RADIANS.iter();
        of.filter(|(which, _)| may_be_radians(largest(which)))
    };
    if candidates().next().is_none() {
        return Ok(None);
    }
    let as_given = total_chi_squared(rows, spurious, budget)?;
    if as_given <= SOUND * 6.0 * rows.len() as f64 {
        return Ok(None);
    }
    let turn = |z: Complex64, in_radians: bool| match in_radians {
        true => Complex64::from_polar(z.norm(), z.arg().to_degrees()),
        false => z,
    };
    let mut best: Option<(f64, &[bool; 4], &str)> = None;
    for (which, name) in candidates() {
        let reread: Vec<PhasorRow> = rows
            .iter()
            .map(|r| PhasorRow {
                reference: turn(r.reference, which[0]),
                outputs: std::array::from_fn(|j| turn(r.outputs[j], which[j + 1])),
                ..r.clone()
            })
            .collect();
        let value = total_chi_squared(&reread, spurious, budget)?;
        if value < 0.1 * as_given && best.is_none_or(|b| value < b.0) {
            best = Some((value, which, name));
        }
    }
    Ok(best.map(|(as_radians, which, name)| {
        let runs = match (rows.first(), rows.last()) {
            (Some(a), Some(b)) => format!("runs {} to {}", a.run, b.run),
            _ => String::new(),
        };
        findings::radians_as_degrees(
            name,
            &format!(
                "{runs}: none of these phases exceeds {:.2}°, χ² = {as_given:.0} as declared and {as_radians:.0} as radians",
                largest(which).to_degrees()
            ),
            "declare these phase columns in radians and calibrate again",
        )
    }))
}

fn total_chi_squared(
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
) -> Result<f64, Error> {
    let frequencies = ascending(rows.iter().map(|r| r.frequency));
    let mut sum = 0.0;
    for f in frequencies {
        let subset: Vec<PhasorRow> = rows.iter().filter(|r| r.frequency == f).cloned().collect();
        match Adjustment::new(&subset, spurious, budget) {
            Ok(adjustment) => sum += adjustment.chi_squared,
            // Nonsense phases may not even converge: infinitely bad.
            Err(Error::NotConverged { .. }) => return Ok(f64::INFINITY),
            Err(other) => return Err(other),
        }
    }
    Ok(sum)
}

/// How the table of runs and that of the spurious motion are to be read together.
///
/// Reversing a sense of the mounting is the same as reversing signs of the spurious motion and of columns and rows of S:
/// R(−ω) = F_y R(ω) F_y, R(ω + 180°) = F_xy R(ω), R(−α) = F_xy R(α) F_xy, F a diagonal of signs. So χ² sees the signs of
/// the table of spurious motion and whether its phases run as those of the runs; the signs of S tell the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Class {
    /// Signs of the spurious motion along x′ and y′.
    x: bool,
    y: bool,
    /// Phases of the runs are those of the other sense of time.
    conjugate: bool,
}

const AS_IS: Class = Class {
    x: false,
    y: false,
    conjugate: false,
};

/// Largest χ² that one run counts with: a wild one says nothing about the table.
const MOST: f64 = 40.0;
/// Gain in χ² with which another reading of the tables is believed.
const GAIN: f64 = 30.0;
/// χ² per degree of freedom up to which nobody asks.
const SOUND: f64 = 1.3;

/// The tables as they fit together best.
pub(super) struct Reading {
    pub(super) rows: Vec<PhasorRow>,
    pub(super) spurious: SpuriousTable,
    class: Class,
    /// χ² as declared and as read.
    chi_squared: [f64; 2],
}

impl Reading {
    /// # Errors
    /// As [`crate::complex`].
    pub(super) fn of(
        rows: &[PhasorRow],
        spurious: &SpuriousTable,
        budget: &Budget,
    ) -> Result<Self, Error> {
        let declared = Self {
            rows: rows.to_vec(),
            spurious: spurious.clone(),
            class: AS_IS,
            chi_squared: [0.0; 2],
        };
        if spurious.entries.is_empty() {
            return Ok(declared);
        }
        let start = trimmed(rows, spurious, budget)?;
        if start <= SOUND * 6.0 * rows.len() as f64 {
            return Ok(declared);
        }
        let mut best = declared;
        best.chi_squared = [start; 2];
        for (x, y, conjugate) in [
            (false, true, false),
            (true, false, false),
            (true, true, false),
            (false, false, true),
            (false, true, true),
            (true, false, true),
            (true, true, true),
        ] {
            let class = Class { x, y, conjugate };
            let (rows, spurious) = (class.rows(rows), class.table(spurious));
            let value = trimmed(&rows, &spurious, budget)?;
            if value < best.chi_squared[1] && value < start - GAIN {
                best = Self {
                    rows,
                    spurious,
                    class,
                    chi_squared: [start, value],
                };
            }
        }
        Ok(best)
    }

    /// What is wrong throughout, by the class of the tables and the signs of S at the lowest frequency.
    pub(super) fn findings(&self, fit: &Fit) -> Vec<Finding> {
        // Far below resonance the phase of a channel is 0 or π: one frequency, the lowest, tells.
        let Some(lowest) = fit.frequencies.first() else {
            return vec![];
        };
        let s = &lowest.sensitivity;
        let mut found = vec![];
        for j in 0..3 {
            let largest = strongest(s, j);
            if largest != j {
                found.push(swapped(lowest.frequency, s, j, largest));
            }
        }
        let negative: [bool; 3] = std::array::from_fn(|j| strongest(s, j) == j && s[j][j].re < 0.0);
        let together = self.together(negative);
        let explained = together.is_some();
        found.extend(together);
        if !explained {
            for j in (0..3).filter(|&j| negative[j]) {
                found.push(inverted(lowest.frequency, s, j));
            }
        }
        found.extend(mask(lowest.frequency, s, lowest));
        found
    }

    /// One cause for the class and several signs.
    fn together(&self, negative: [bool; 3]) -> Option<Finding> {
        let Class { x, y, conjugate } = self.class;
        let evidence = &match self.class == AS_IS {
            true => "by the signs of S at the lowest frequency".to_owned(),
            false => format!(
                "χ² = {:.0} as declared and {:.0} so, and the signs of S at the lowest frequency",
                self.chi_squared[0], self.chi_squared[1]
            ),
        };
        let sign = |axes, check| findings::spurious_sign(axes, evidence, check);
        let finding = match (conjugate, x, y, negative) {
            (true, ..) => findings::phases_conjugated(evidence),
            (_, false, false, [true, true, false]) => findings::mask_reversed(evidence),
            (_, false, false, [true, true, true]) => findings::reference_inverted(evidence),
            (_, false, true, [false, true, false]) => {
                findings::angle_sense("rotations", evidence, CLOCKWISE)
            }
            (_, true, false, [false, true, false]) => findings::angle_sense(
                "rotations, from the opposite mark,",
                evidence,
                &format!("{CLOCKWISE}, from the mark of x"),
            ),
            (_, true, true, [true, true, false]) => findings::angle_sense(
                "inclinations",
                evidence,
                "inclination is positive where the +x side of the face climbs",
            ),
            (_, false, true, _) => sign("y′", "y′ × z′ = x′: check the sense of y′"),
            (_, true, false, _) => {
                sign("x′", "x′ points to where the wedge climbs: check its sense")
            }
            (_, true, true, _) => sign(
                "x′ and y′",
                "x′ points to where the wedge climbs: check the azimuth",
            ),
            _ => return None,
        };
        Some(match self.class == AS_IS {
            true => finding.at(Severity::Warning),
            false => finding,
        })
    }
}

impl Class {
    fn rows(self, rows: &[PhasorRow]) -> Vec<PhasorRow> {
        if !self.conjugate {
            return rows.to_vec();
        }
        rows.iter()
            .map(|r| PhasorRow {
                reference: r.reference.conj(),
                outputs: r.outputs.map(|o| o.conj()),
                covariance: r.covariance.map(|[rr, ri, ii]| [rr, -ri, ii]),
                ..r.clone()
            })
            .collect()
    }

    fn table(self, spurious: &SpuriousTable) -> SpuriousTable {
        let mut table = spurious.clone();
        for e in &mut table.entries {
            for (k, flip) in [self.x, self.y].into_iter().enumerate() {
                if flip {
                    e.ratio[k] = -e.ratio[k];
                }
            }
        }
        table
    }
}

/// Σ over the runs of their χ² against the others, none with more than [`MOST`].
fn trimmed(rows: &[PhasorRow], spurious: &SpuriousTable, budget: &Budget) -> Result<f64, Error> {
    let frequencies = ascending(rows.iter().map(|r| r.frequency));
    let parts: Vec<f64> = frequencies
        .par_iter()
        .map(|f| {
            let here: Vec<PhasorRow> = rows.iter().filter(|r| r.frequency == *f).cloned().collect();
            let wild = wild(&here, spurious, budget);
            let kept: Vec<PhasorRow> = (0..here.len())
                .filter(|&i| !wild[i])
                .map(|i| here[i].clone())
                .collect();
            let out = (here.len() - kept.len()) as f64 * MOST;
            match Adjustment::new(&kept, spurious, budget).and_then(|a| a.deletions()) {
                Ok(deletions) => {
                    let all = deletions.iter().map(|d| d.statistic.min(MOST));
                    Ok(out + all.sum::<f64>())
                }
                // Nonsense phases may not even converge: as bad as can be.
                Err(Error::NotConverged { .. }) => Ok(here.len() as f64 * MOST),
                // A plan in which no run can be spared says nothing.
                Err(Error::Unobservable { .. } | Error::TooFew { .. }) => Ok(0.0),
                Err(other) => Err(other),
            }
        })
        .collect::<Result<_, Error>>()?;
    Ok(parts.iter().sum())
}

fn strongest(s: &Matrix, j: usize) -> usize {
    (0..3)
        .max_by(|&a, &b| s[a][j].norm().total_cmp(&s[b][j].norm()))
        .unwrap_or(j)
}

fn swapped(frequency: f64, s: &Matrix, j: usize, largest: usize) -> Finding {
    findings::swapped_channels(
        &format!(
            "channel {} follows the {} axis in every run",
            AXES[j], AXES[largest]
        ),
        &format!(
            "at {frequency} Hz: |S_{}{}| = {:.4e}, |S_{}{}| = {:.4e} V/(m/s²)",
            AXES[largest],
            AXES[j],
            s[largest][j].norm(),
            AXES[j],
            AXES[j],
            s[j][j].norm()
        ),
    )
}

fn inverted(frequency: f64, s: &Matrix, j: usize) -> Finding {
    findings::inverted_channel(
        &format!("channel {} is inverted in every run", AXES[j]),
        &format!(
            "at {frequency} Hz: phase of S_{}{} {:.1}°",
            AXES[j],
            AXES[j],
            s[j][j].arg().to_degrees()
        ),
    )
    .at(Severity::Warning)
}

/// Turn of x and y together that nobody asks about: what a good device has of itself.
const TURNED: f64 = 0.05;
/// t with five degrees of freedom beyond which one in a hundred healthy devices lies: their axes are as they are, and a turn
/// of both is one way among six to be askew.
const ASKEW: f64 = 4.032;

/// The turn of x and y together, rad, and its size over that of the five other ways in which axes of this device are askew.
///
/// Without a mask that is off, the difference of S_xy and S_yx is to their sum and to the four terms with z as one cross term
/// to the others.
fn turned(s: &Matrix) -> (f64, f64) {
    let of = |i: usize, j: usize| (s[i][j] / s[j][j]).re;
    let angle = (of(0, 1) - of(1, 0)).atan2(2.0);
    let together = (of(0, 1) - of(1, 0)) / 2f64.sqrt();
    let others = [
        (of(0, 1) + of(1, 0)) / 2f64.sqrt(),
        of(0, 2),
        of(2, 0),
        of(1, 2),
        of(2, 1),
    ];
    let scatter = (others.iter().map(|c| c * c).sum::<f64>() / 5.0).sqrt();
    (angle, together.abs() / scatter.max(f64::MIN_POSITIVE))
}

/// x and y turned together against the marks, by more than the axes of the device are askew otherwise.
fn mask(frequency: f64, s: &Matrix, fit: &super::super::FrequencyFit) -> Option<Finding> {
    if strongest(s, 0) != 0 || strongest(s, 1) != 1 {
        return None;
    }
    let of = |i: usize, j: usize| (s[i][j] / s[j][j]).re;
    let (angle, askew) = turned(s);
    let covariance = fit.estimate.covariance();
    let u = covariance
        .standard_uncertainty(2)
        .hypot(covariance.standard_uncertainty(6))
        / (2.0 * s[1][1].norm().min(s[0][0].norm()));
    (angle.tan().abs() > TURNED && angle.abs() > 4.0 * u && askew > ASKEW).then(|| {
        findings::mask_offset(
            angle.to_degrees(),
            frequency,
            of(0, 1),
            of(1, 0),
            u.to_degrees(),
            askew,
            ASKEW,
        )
    })
}

#[cfg(test)]
mod tests {
    use super::{ASKEW, Matrix, TURNED, turned};
    use num_complex::Complex64;
    use rand::{RngExt, SeedableRng};
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// A device whose cross terms are drawn by `cross`, read under a mask that is off by an angle.
    fn device(angle: f64, mut cross: impl FnMut() -> f64) -> Matrix {
        let s: Matrix = std::array::from_fn(|i| {
            std::array::from_fn(|j| Complex64::from(if i == j { 1.0 } else { cross() }))
        });
        let (sin, cos) = angle.sin_cos();
        let turn = [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]];
        std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| s[k][j] * turn[i][k]).sum()))
    }

    fn said(s: &Matrix) -> bool {
        let (angle, askew) = turned(s);
        angle.tan().abs() > TURNED && askew > ASKEW
    }

    #[test]
    fn known_false_alarm_rate_and_power_of_a_mask_offset() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        let n = 20_000;
        let mut share = |half: f64, normal: bool, angle: f64| {
            let mut told = 0;
            for _ in 0..n {
                let s = device(angle, || match normal {
                    true => {
                        let z: f64 = StandardNormal.sample(&mut rng);
                        half / 3f64.sqrt() * z
                    }
                    false => half * (2.0 * rng.random::<f64>() - 1.0),
                });
                told += usize::from(said(&s));
            }
            told as f64 / f64::from(n)
        };
        for half in [0.03, 0.1, 0.2] {
            for normal in [false, true] {
                let rate = share(half, normal, 0.0);
                println!("±{half}, normal {normal}: {:.2} %", 100.0 * rate);
                // One per cent, and four standard deviations of so many devices.
                assert!(rate < 0.013, "±{half}: {rate}");
            }
        }
        let power = [0.03, 0.1].map(|half| share(half, false, 10f64.to_radians()));
        println!("10° off: {power:?}");
        assert!(power[0] > 0.97, "{power:?}");
    }
}
