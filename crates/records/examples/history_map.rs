//! Drift and jumps of simulated histories with a shared reference: coverage, false jumps, jumps that are found, risk at the due date.
//!
//! `cargo run --release -p proofmass-records --example history_map [HISTORIES]` prints the tables of docs/records.md.

use proofmass_static::static_test::{DatedValue, Drift, DriftQuestion, Jump, MONTH};
use proofmass_uncertainty::DegreesOfFreedom;
use rand::SeedableRng;
use rand::rngs::StdRng;
use rand_distr::{Distribution, StandardNormal};

const OWN: f64 = 1.0;

/// A history: so many yearly results, a reference with u = `ratio` that is calibrated anew after every `group`, a drift per month, and a
/// jump behind result `at`.
struct Case {
    n: usize,
    ratio: f64,
    group: usize,
    drift: f64,
    jump: f64,
    at: usize,
}

fn simulate(case: &Case, random: &mut StdRng) -> (Vec<DatedValue>, Vec<f64>) {
    let mut normal = || -> f64 { StandardNormal.sample(&mut *random) };
    let mut reference = 0.0;
    let mut truth = Vec::new();
    let values = (0..case.n)
        .map(|k| {
            if k % case.group == 0 {
                reference = case.ratio * OWN * normal();
            }
            let day = 365.25 * k as f64;
            let true_value = case.drift * day / MONTH + if k >= case.at { case.jump } else { 0.0 };
            truth.push(true_value);
            let u = OWN.hypot(case.ratio * OWN);
            let value = true_value + reference + OWN * normal();
            DatedValue::new(day, value, u, DegreesOfFreedom::INFINITE)
                .sharing((k / case.group) as u64, case.ratio * OWN)
        })
        .collect();
    (values, truth)
}

fn main() -> Result<(), proofmass_core::Error> {
    let histories: usize = std::env::args()
        .nth(1)
        .and_then(|t| t.parse().ok())
        .unwrap_or(5_000);
    let mut random = StdRng::seed_from_u64(7);
    let question = DriftQuestion {
        probability: 0.95,
        tolerance: Some(12.0),
        longest_interval: 60.0,
    };
    let lengths = [3, 4, 5, 8, 12, 20, 30];
    println!(
        "| results | u of the reference / own u | drift covered % | false jumps % | late at the due date % |"
    );
    println!("|---|---|---|---|---|---|");
    let (mut all, mut within, mut false_all, mut late_all, mut due_all) = (0, 0, 0, 0, 0);
    for n in lengths {
        for ratio in [0.5, 1.0, 3.0] {
            let (mut covered, mut jumps, mut late, mut dues) = (0, 0, 0, 0);
            let mut ratios = Vec::with_capacity(histories);
            for trial in 0..histories {
                // Half of the devices drift; the reference is calibrated every one to four years, or never.
                let drift = if trial % 2 == 0 { 0.0 } else { 0.3 };
                let group = [1, 2, 3, 4, 100][trial % 5];
                let case = Case {
                    n,
                    ratio,
                    group,
                    drift,
                    jump: 0.0,
                    at: n,
                };
                let (values, _) = simulate(&case, &mut random);
                let found = Drift::of("S", "1", &values, &question)?;
                covered +=
                    usize::from((found.drift.value - drift).abs() <= found.drift.expanded(0.95));
                ratios.push((found.drift.value - drift).abs() / found.drift.expanded(0.95));
                jumps += usize::from(Jump::of(&values)?.is_some());
                // Out of tolerance: the true change since the last value, its error included, beyond the tolerance at the due date.
                if let Some(due) = found.due_in.filter(|d| *d > 0.0 && drift > 0.0) {
                    let last = values[n - 1].value;
                    let then = drift
                        * (values[n - 1].day + due.min(question.longest_interval * MONTH))
                        / MONTH;
                    dues += 1;
                    late += usize::from((then - last).abs() > 12.0);
                }
            }
            let share = |k: usize, of: usize| 100.0 * k as f64 / of.max(1) as f64;
            ratios.sort_by(f64::total_cmp);
            println!(
                "| {n} | {ratio} | {:.1} | {:.2} | {:.2} | {:.1} |",
                share(covered, histories),
                1.0 / ratios[histories * 95 / 100],
                share(jumps, histories),
                share(late, dues)
            );
            all += histories;
            within += covered;
            false_all += jumps;
            late_all += late;
            due_all += dues;
        }
    }
    let share = |k: usize, of: usize| 100.0 * k as f64 / of.max(1) as f64;
    println!(
        "| all | | {:.1} | | {:.2} | {:.1} |\n",
        share(within, all),
        share(false_all, all),
        share(late_all, due_all)
    );
    println!("| results | u of the reference / own u | jumps of 2 U found % |");
    println!("|---|---|---|");
    for n in [8, 10, 12, 16, 20, 30] {
        for ratio in [0.0, 0.5, 1.0, 2.0, 3.0] {
            let mut found = 0;
            for trial in 0..histories {
                let at = 3 + trial % (n - 5);
                let jump = 2.0 * 2.0 * OWN.hypot(ratio * OWN);
                let case = Case {
                    n,
                    ratio,
                    group: 100,
                    drift: 0.0,
                    jump,
                    at,
                };
                let (values, _) = simulate(&case, &mut random);
                found += usize::from(Jump::of(&values)?.is_some());
            }
            println!("| {n} | {ratio} | {:.1} |", share(found, histories));
        }
    }
    Ok(())
}
