use super::super::geometry::published_plan;
use super::super::matrix::Matrix;
use super::super::{Acts, Configuration, Key, ShakerInput, Spurious};
use super::*;
use crate::complex;
use num_complex::Complex64;
use proofmass_uncertainty::{DegreesOfFreedom, Distribution};

fn sensitivity() -> Matrix {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| Complex64::new(if i == j { 0.0104 } else { 3e-4 }, 1e-5))
    })
}

fn rows(plan: &[Configuration], frequencies: &[f64]) -> Vec<PhasorRow> {
    let a = Complex64::new(10.0, 0.0);
    frequencies
        .iter()
        .flat_map(|&f| {
            plan.iter().map(move |&c| {
                let seen = c.direction().map(|d| a * d);
                PhasorRow::new("", f, c, a, row_times(seen, &sensitivity()))
            })
        })
        .collect()
}

/// Spurious motion over that of the table, along each axis.
const MOVES: Complex64 = Complex64::new(0.01, 0.002);

/// A table that moves so on every wedge, measured with this covariance.
fn moving(plan: &[Configuration], frequencies: &[f64], covariance: [f64; 3]) -> SpuriousTable {
    let mut inclinations: Vec<f64> = plan.iter().map(|c| c.inclination).collect();
    inclinations.sort_by(f64::total_cmp);
    inclinations.dedup();
    let at = |frequency: f64| {
        let wedges = inclinations.iter();
        wedges.map(move |&inclination| Spurious {
            basis: Default::default(),
            inclination,
            frequency,
            ratio: [MOVES; 3],
            covariance: [covariance; 3],
            dof: DegreesOfFreedom::INFINITE,
        })
    };
    SpuriousTable::new(frequencies.iter().flat_map(|&f| at(f)).collect())
}

/// What the device shows on such a table.
fn see(rows: &mut [PhasorRow]) {
    for row in rows {
        let m = row.configuration.matrix();
        let seen = std::array::from_fn(|i| {
            row.reference * (m[i][2] + (0..3).map(|k| m[i][k] * MOVES).sum::<Complex64>())
        });
        row.outputs = row_times(seen, &sensitivity());
    }
}

fn options(trials: u64) -> CheckOptions {
    CheckOptions {
        trials,
        ..CheckOptions::default()
    }
}

fn run(
    method: ShakerMethod,
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
    trials: u64,
) -> Vec<FrequencyCheck> {
    validate(
        method,
        rows,
        spurious,
        budget,
        &options(trials),
        &mut |_| ControlFlow::Continue(()),
    )
    .unwrap()
}

fn bench() -> Budget {
    let mut budget = Budget::published_bench();
    budget.inputs.push(ShakerInput::new(
        "noise",
        Acts::OutputAdditive,
        5e-5,
        &[Key::Run, Key::Channel],
    ));
    budget.inputs.push(ShakerInput::new(
        "reference.phase",
        Acts::ReferencePhase,
        0.003,
        &[Key::Frequency],
    ));
    budget
}

#[test]
fn crosscheck_propagation_against_monte_carlo() {
    let rows = rows(&published_plan(), &[160.0]);
    let start = std::time::Instant::now();
    let checks = run(
        ShakerMethod::Complex,
        &rows,
        &SpuriousTable::default(),
        &bench(),
        20_000,
    );
    println!("20 000 trials: {:.2} s", start.elapsed().as_secs_f64());
    for c in &checks[0].components {
        // A standard deviation from 2e4 trials has 0.5 %; three of them, and 0.5 % for Student's t with ν = 20, whose
        // standard deviation is larger by √(20/18) in the share that has it.
        assert!(
            (c.monte_carlo.unwrap() / c.linear - 1.0).abs() < 0.02,
            "{c:?}"
        );
        assert_eq!(c.validation.verdict, Verdict::Validated, "{c:?}");
    }
}

/// One budget input in front of all others: the interval of the trials is that of its shape.
fn gain(distribution: Distribution) -> Budget {
    Budget::new(vec![
        ShakerInput::new(
            "conditioner.gain",
            Acts::OutputModulus,
            0.01,
            &[Key::Channel],
        )
        .distributed(distribution),
        ShakerInput::new(
            "noise",
            Acts::OutputAdditive,
            1e-6,
            &[Key::Run, Key::Channel],
        ),
    ])
    .unwrap()
}

#[test]
fn crosscheck_every_shape_reaches_the_trials_as_in_the_general_engine() {
    struct Itself;
    impl proofmass_uncertainty::Model for Itself {
        fn outputs(&self) -> Vec<(String, String)> {
            vec![("x".into(), "1".into())]
        }
        fn evaluate<T: proofmass_uncertainty::Number>(&self, x: &[T], y: &mut [T]) {
            y[0] = x[0];
        }
    }
    let u = 0.01;
    let plan: Vec<Configuration> = published_plan().into_iter().step_by(3).collect();
    let rows = rows(&plan, &[160.0]);
    let mut seen = vec![];
    for (distribution, half) in [
        (Distribution::Normal { mean: 0.0, u }, 1.960),
        (
            Distribution::Arcsine {
                lower: -u * 2f64.sqrt(),
                upper: u * 2f64.sqrt(),
            },
            1.410,
        ),
        (
            Distribution::Triangular {
                lower: -u * 6f64.sqrt(),
                upper: u * 6f64.sqrt(),
            },
            1.902,
        ),
        (
            Distribution::Rectangular {
                lower: -u * 3f64.sqrt(),
                upper: u * 3f64.sqrt(),
            },
            1.645,
        ),
        (
            Distribution::StudentT {
                location: 0.0,
                scale: u,
                dof: 3.0,
            },
            3.182,
        ),
    ] {
        let checks = run(
            ShakerMethod::Complex,
            &rows,
            &SpuriousTable::default(),
            &gain(distribution.clone()),
            40_000,
        );
        let c = &checks[0].components[0];
        let reached = 0.5 * (c.interval[1] - c.interval[0]) / (u * 0.0104);
        let general = MonteCarlo::new(5)
            .trials(Trials::Fixed(200_000))
            .run(
                &Itself,
                &proofmass_uncertainty::Inputs::new()
                    .add(proofmass_uncertainty::Input::new(
                        "x",
                        "1",
                        distribution.clone(),
                    ))
                    .single()
                    .unwrap(),
            )
            .unwrap();
        let x = general.get("x").unwrap();
        let expected = 0.5 * x.symmetric.width() / u;
        // An end from 4e4 trials is known to 2.7/√4e4 = 1.3 % of u for a normal, 4 % for t₃; three of them.
        let scatter = 3.0 * (c.validation.scatter / c.linear + x.symmetric_scatter / u);
        println!("{distribution}: {reached:.3}, general {expected:.3}, by the books {half}");
        assert!(
            (reached - expected).abs() < scatter + 0.01,
            "{reached} {expected} ± {scatter}"
        );
        assert!(
            (expected - half).abs() < 3.0 * x.symmetric_scatter / u + 0.005,
            "{expected} {half}"
        );
        seen.push(reached);
        // What is stated is 1.96 u, or the quantile of t with its degrees of freedom. An arcsine is another matter.
        let verdict = c.validation.verdict;
        match distribution {
            Distribution::Arcsine { .. } => assert_eq!(verdict, Verdict::NotValidated),
            Distribution::Normal { .. } | Distribution::StudentT { .. } => {
                assert_ne!(verdict, Verdict::NotValidated, "{c:?}");
            }
            _ => {}
        }
    }
    for (i, a) in seen.iter().enumerate() {
        for b in &seen[..i] {
            assert!((a - b).abs() > 0.02, "two shapes gave one result: {seen:?}");
        }
    }
}

#[test]
fn crosscheck_finite_degrees_of_freedom_reach_the_trials() {
    let mut budget = gain(Distribution::Normal { mean: 0.0, u: 0.01 });
    budget.inputs[0].dof = DegreesOfFreedom::new(4.0).unwrap();
    let rows = rows(&published_plan(), &[160.0]);
    let checks = run(
        ShakerMethod::Complex,
        &rows,
        &SpuriousTable::default(),
        &budget,
        40_000,
    );
    let c = &checks[0].components[0];
    // t with ν = 4: 2.776; an end of 4e4 trials is known to about 3 %.
    let reached = 0.5 * (c.interval[1] - c.interval[0]) / c.linear;
    assert!((reached - 2.776).abs() < 0.1, "{reached}");
    assert_ne!(c.validation.verdict, Verdict::NotValidated);
}

#[test]
fn law_the_joint_estimator_is_tried_with_the_spurious_motion() {
    // Six configurations and an uncertain motion along x′ that is most of the uncertainty of the cross terms: the
    // joint method states it, and the trials of its own estimator agree.
    let plan: Vec<Configuration> = published_plan().into_iter().step_by(3).collect();
    let frequencies = [80.0, 160.0];
    let table = moving(&plan, &frequencies, [4e-5, 1e-5, 3e-5]);
    let budget = bench();
    let mut rows = rows(&plan, &frequencies);
    see(&mut rows);
    let with = run(ShakerMethod::Joint, &rows, &table, &budget, 20_000);
    assert_eq!(with.len(), 2);
    let mut certain = table.clone();
    for e in &mut certain.entries {
        e.covariance = [[0.0; 3]; 3];
    }
    let without = run(ShakerMethod::Joint, &rows, &certain, &budget, 20_000);
    for (c, d) in with[1].components.iter().zip(&without[1].components) {
        // Scatter of a standard deviation from 2e4 trials: 0.5 %; four of them, and the share of t.
        assert!(
            (c.monte_carlo.unwrap() / c.linear - 1.0).abs() < 0.03,
            "{c:?}"
        );
        assert!(
            c.monte_carlo.unwrap() > d.monte_carlo.unwrap() * 0.98,
            "{c:?} {d:?}"
        );
    }
    let sum = |checks: &[FrequencyCheck]| {
        let all = checks[1].components.iter();
        all.map(|c| c.monte_carlo.unwrap().powi(2)).sum::<f64>()
    };
    assert!(sum(&with) > sum(&without));
}

#[test]
fn law_large_angles_go_through_the_estimator_itself() {
    // Gluings of ±5°: with the gains frozen at the drawing the trials would scatter by the square of the angles more.
    let budget = bench().scaled("gluing.angle", 5.0);
    let plan: Vec<Configuration> = published_plan().into_iter().step_by(3).collect();
    let checks = run(
        ShakerMethod::Complex,
        &rows(&plan, &[160.0]),
        &SpuriousTable::default(),
        &budget,
        10_000,
    );
    for c in &checks[0].components {
        // Scatter of a standard deviation from 1e4 trials: 0.7 %; four of them, t, and what is left of the curvature.
        assert!(
            (0.95..1.08).contains(&(c.monte_carlo.unwrap() / c.linear)),
            "{c:?}"
        );
    }
}

/// The published plan with all that can move: tilts, leans, and a spurious motion with a phase.
fn everything() -> (Vec<PhasorRow>, SpuriousTable, Budget) {
    let mut budget = bench();
    let degree = 1f64.to_radians();
    for (key, acts, by) in [
        ("tilt", Acts::Tilt, &[Key::Inclination, Key::Rotation][..]),
        ("lean", Acts::Lean, &[Key::Inclination][..]),
    ] {
        budget
            .inputs
            .push(ShakerInput::new(key, acts, 0.3 * degree, by));
    }
    let plan = published_plan();
    let table = moving(&plan, &[160.0], [4e-6, 1e-6, 3e-6]);
    let mut rows = rows(&plan, &[160.0]);
    see(&mut rows);
    (rows, table, budget)
}

/// Draws of standard normal numbers times `size`, a column per input.
fn draws(simulation: &Simulation, count: usize, size: f64) -> Vec<Vec<f64>> {
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(3);
    let inputs = simulation.errors.inputs();
    let mut column = |u: f64| -> Vec<f64> {
        let draws = (&mut rng).sample_iter(StandardNormal);
        draws.take(count).map(|z: f64| u * size * z).collect()
    };
    let draws = inputs.draws().iter();
    draws.map(|d| column(d.standard_uncertainty)).collect()
}

#[test]
fn law_a_trial_does_not_know_its_neighbours() {
    let (rows, table, budget) = everything();
    let fits = complex(&rows, &table, &budget).unwrap().frequencies;
    let simulation = Simulation::new(&rows, &table, &budget, &fits).unwrap();
    // Eleven trials fill no register; in one of them the angles are beyond what series hold.
    let mut columns = draws(&simulation, 11, 1.0);
    for column in &mut columns {
        column[4] *= 30.0;
    }
    let mut together = vec![vec![0.0; 11]; 18];
    let x: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let mut y: Vec<&mut [f64]> = together.iter_mut().map(Vec::as_mut_slice).collect();
    simulation.trials(&x, &mut y);
    for k in 0..11 {
        let x: Vec<f64> = columns.iter().map(|c| c[k]).collect();
        let mut alone = vec![0.0; 18];
        simulation.trial(&x, &mut alone);
        for (p, alone) in alone.iter().enumerate() {
            assert_eq!(together[p][k].to_bits(), alone.to_bits(), "trial {k}, {p}");
        }
    }
    // Nor how wide the registers are.
    let mut narrow = vec![vec![0.0; 11]; 18];
    let mut y: Vec<&mut [f64]> = narrow.iter_mut().map(Vec::as_mut_slice).collect();
    let batch = Batch {
        simulation: &simulation,
        x: &x,
        y: &mut y,
    };
    batch.with_simd(pulp::Scalar::new());
    assert_eq!(narrow, together);
}

/// How far single trials end from the adjustment of their campaigns at most, in units of u.
fn apart(rows: &[PhasorRow], table: &SpuriousTable, budget: &Budget) -> f64 {
    let fits = complex(rows, table, budget).unwrap().frequencies;
    let simulation = Simulation::new(rows, table, budget, &fits).unwrap();
    let truth: Vec<Matrix> = simulation.estimator.truths().copied().collect();
    let u: Vec<f64> = fits[0]
        .estimate
        .quantities()
        .iter()
        .map(|q| q.standard_uncertainty)
        .collect();
    let columns = draws(&simulation, 20, 1.0);
    let mut worst = 0f64;
    for k in 0..20 {
        let x: Vec<f64> = columns.iter().map(|c| c[k]).collect();
        let mut change = vec![0.0; 18];
        simulation.trial(&x, &mut change);
        let columns: Vec<&[f64]> = x.chunks(1).collect();
        let mut campaign = rows.to_vec();
        for (i, row) in campaign.iter_mut().enumerate() {
            let simd = pulp::Scalar::new();
            let seen = simulation.errors.observe(simd, i, &columns, 0, &truth[i]);
            row.outputs = seen.map(|z| {
                let [mut re, mut im] = [[0.0]; 2];
                z.re.store(&mut re);
                z.im.store(&mut im);
                Complex64::new(re[0], im[0]) * row.reference
            });
        }
        let adjusted = Adjustment::new(&campaign, table, budget).unwrap();
        let found = super::super::matrix::to_real(&adjusted.sensitivity(0));
        let true_s = super::super::matrix::to_real(&truth[0]);
        for p in 0..18 {
            worst = worst.max((found[p] - true_s[p] - change[p]).abs() / u[p]);
        }
    }
    worst
}

#[test]
fn crosscheck_a_trial_ends_where_the_adjustment_of_its_campaign_does() {
    let (rows, mut table, mut budget) = everything();
    let worst = apart(&rows, &table, &budget);
    assert!(worst < 0.1, "{worst} u");
    // Spurious motion that is certain, of which the fit takes the derivatives by S as it was measured.
    for entry in &mut table.entries {
        entry.covariance = [[0.0; 3]; 3];
    }
    // Nothing proportional to a reading, which would weigh the runs by what each of the two predicts.
    budget
        .inputs
        .retain(|i| !i.within_a_run() || i.acts == Acts::OutputAdditive);
    // 0.002 u where a trial stops, and what else the derivatives by S of the fit leave out: factors of 0.2 %.
    let worst = apart(&rows, &table, &budget);
    assert!(worst < 0.01, "{worst} u");
}

#[test]
fn law_the_seed_alone_decides() {
    let rows = rows(&published_plan(), &[160.0]);
    let budget = bench();
    let go = || {
        run(
            ShakerMethod::Complex,
            &rows,
            &SpuriousTable::default(),
            &budget,
            10_000,
        )
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    assert_eq!(go(), pool.install(go));
}

#[test]
fn law_a_watcher_stops_the_trials() {
    let rows = rows(&published_plan(), &[160.0]);
    let stopped = validate(
        ShakerMethod::Complex,
        &rows,
        &SpuriousTable::default(),
        &bench(),
        &options(10_000),
        &mut |_| ControlFlow::Break(()),
    );
    assert!(matches!(stopped, Err(Refusal::Cancelled)));
}

#[test]
fn law_a_verdict_has_a_consequence() {
    let rows = rows(&published_plan(), &[160.0]);
    let arcsine = Distribution::Arcsine {
        lower: -0.01 * 2f64.sqrt(),
        upper: 0.01 * 2f64.sqrt(),
    };
    let checks = run(
        ShakerMethod::Complex,
        &rows,
        &SpuriousTable::default(),
        &gain(arcsine),
        20_000,
    );
    let findings = findings(&checks, 1);
    assert_eq!(findings[0].code(), "linear-result-not-validated");
    assert_eq!(findings[0].severity(), Severity::Decision);
}
