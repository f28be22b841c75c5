//! The published case recomputed: figures quoted in `docs/published-triaxial-case.md`.

use crate::budgets;
use num_complex::Complex64;
use proofmass_shaker::derived::{expanded, inconsistency, intrinsic};
use proofmass_shaker::geometry::published_plan;
use proofmass_shaker::matrix::{Matrix, row_times};
use proofmass_shaker::plan::conditioning;
use proofmass_shaker::published::{MagnitudeBudget, MagnitudeRow, fit};
use proofmass_shaker::{Budget, PhasorRow, SpuriousTable, complex, joint};

/// (frequency, S in V/(m/s²), A in (m/s²)/V) of a published case.
fn published(case: &str) -> Vec<(f64, Matrix, Matrix)> {
    let text = include_str!("inrim-pcb356a15/matrices.csv");
    let rows: Vec<Vec<&str>> = text
        .lines()
        .skip(1)
        .map(|l| l.split(',').collect())
        .collect();
    let rows: Vec<&Vec<&str>> = rows.iter().filter(|f| f[0] == case).collect();
    rows.chunks(9)
        .map(|nine| {
            let read = |column: usize, unit: f64| -> Matrix {
                std::array::from_fn(|i| {
                    std::array::from_fn(|j| {
                        Complex64::new(unit * nine[3 * i + j][column].parse::<f64>().unwrap(), 0.0)
                    })
                })
            };
            (nine[0][1].parse().unwrap(), read(5, 1e-3), read(3, 1.0))
        })
        .collect()
}

/// Noise-free phasors of the published plan and amplitudes: an instrument that has the printed S.
fn regenerated(s: &Matrix, frequency: f64) -> Vec<PhasorRow> {
    let amplitude = if frequency < 10.0 { 3.0 } else { 10.0 };
    published_plan()
        .into_iter()
        .enumerate()
        .map(|(i, c)| {
            let a = c.direction().map(|d| Complex64::new(amplitude * d, 0.0));
            PhasorRow::new(
                format!("{frequency}-{}", i + 1),
                frequency,
                c,
                Complex64::new(amplitude, 0.0),
                row_times(a, s),
            )
        })
        .collect()
}

fn budget() -> Budget {
    let mut budget = Budget::published_bench();
    budget.inputs.push(budgets::noise());
    budget
}

#[test]
fn published_matrices_come_back_from_signed_phasors() {
    // Noise-free: the signed fit returns the printed S to rounding, and its inverse.
    for case in ["uncorrected", "corrected-first", "corrected-second"] {
        for (frequency, s, a) in published(case) {
            let fit = complex(
                &regenerated(&s, frequency),
                &SpuriousTable::default(),
                &budget(),
            )
            .unwrap();
            let f = &fit.frequencies[0];
            let worst = (0..9)
                .map(|k| (f.sensitivity[k / 3][k % 3] - s[k / 3][k % 3]).norm() / s[0][0].norm())
                .fold(0.0, f64::max);
            assert!(worst < 1e-9, "{case} {frequency}: {worst}");
            // The two published regressions are inverse to each other to some 0.5 %, not exactly; at high frequencies, and with the second
            // measurement of the motion, they are not.
            let gap = inconsistency(&s, &a).unwrap();
            println!(
                "{case} {frequency} Hz: S⁻¹ and A differ by up to {:.2} % of A_xx",
                100.0 * gap
            );
            let most = match (case, frequency) {
                ("corrected-second", 630.0 | 1000.0) => 0.27,
                (_, 1000.0) | ("corrected-second", 315.0) => 0.04,
                _ => 0.013,
            };
            assert!(gap < most, "{case} {frequency}: {gap}");
        }
    }
}

#[test]
fn published_case_with_keys_and_signs() {
    let c = conditioning(&published_plan()).unwrap();
    println!(
        "plan: condition {:.4}, D {:.4}, A {:.4}, correlations {:?}",
        c.condition, c.d_efficiency, c.a_efficiency, c.correlation
    );
    let cases = published("uncorrected");
    let rows: Vec<PhasorRow> = cases
        .iter()
        .flat_map(|(f, s, _)| regenerated(s, *f))
        .collect();
    let apart = complex(&rows, &SpuriousTable::default(), &budget()).unwrap();
    let together = joint(&rows, &SpuriousTable::default(), &budget()).unwrap();
    for (k, (frequency, s, _)) in cases.iter().enumerate() {
        let magnitudes: Vec<MagnitudeRow> = regenerated(s, *frequency)
            .iter()
            .map(|r| MagnitudeRow {
                reference: r.reference.norm(),
                configuration: r.configuration,
                outputs: r.outputs.map(|o| o.norm()),
                spurious: None,
            })
            .collect();
        let printed = fit(&magnitudes, &MagnitudeBudget::published(0.0035)).unwrap();
        let (a, b) = (
            &apart.frequencies[k].estimate,
            &together.frequencies[k].estimate,
        );
        let u = |e: &proofmass_uncertainty::Estimate, name: &str| {
            100.0 * e.get(name).unwrap().expanded(0.95) / s[0][0].re
        };
        println!(
            "{frequency} Hz, U/S_xx in %: xx {:.3} → {:.3}, xy {:.3} → {:.3}, zx {:.3} → {:.3}, zz {:.3} → {:.3}; magnitudes {:.2} %, S_xy {:.3} for {:.3}, S_xx {:.3} for {:.3} mV",
            u(a, "S.xx.re"),
            u(b, "S.xx.re"),
            u(a, "S.xy.re"),
            u(b, "S.xy.re"),
            u(a, "S.zx.re"),
            u(b, "S.zx.re"),
            u(a, "S.zz.re"),
            u(b, "S.zz.re"),
            100.0 * printed.sensitivity_expanded[0][0].unwrap() / printed.sensitivity[0][0],
            1e3 * printed.sensitivity[0][1],
            1e3 * s[0][1].re,
            1e3 * printed.sensitivity[0][0],
            1e3 * s[0][0].re,
        );
        for name in ["S.xx.re", "S.xy.re"] {
            for (label, e) in [("complex", a), ("joint", b)] {
                let lines: Vec<String> = e
                    .budget(name)
                    .unwrap()
                    .iter()
                    .take(4)
                    .map(|l| format!("{} {:.0} %", l.key, 100.0 * l.share))
                    .collect();
                if k == 1 {
                    println!("  {name} {label}: {}", lines.join(", "));
                }
            }
        }
        if k == 1 {
            for (label, e) in [("complex", a), ("joint", b)] {
                for q in expanded(&intrinsic(e).unwrap()) {
                    println!(
                        "  {label} {} = {:.6} ± {:.6} {}",
                        q.name, q.value, q.expanded, q.unit
                    );
                }
            }
        }
        // The reference calibration is common to all 44 runs: 0.4 % (k = 2) cannot be averaged away.
        let relative = a.get("S.xx.re").unwrap().expanded(0.95) / s[0][0].re;
        assert!((0.004..0.006).contains(&relative), "{relative}");
    }
}
