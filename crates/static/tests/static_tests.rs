//! Static tests on simulated readings with known truth: coverage of nominal 95 % intervals.

use proofmass_core::{Error, Gravity, TaitBryan};
use proofmass_static::static_test::*;
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Influence, Severity,
};
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;
use std::collections::BTreeMap;

const G: f64 = 9.80665;
const TRIALS: u64 = 2000;

struct Normal(Xoshiro256PlusPlus);

impl Normal {
    fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    fn draw(&mut self) -> f64 {
        self.0.sample(StandardNormal)
    }
}

/// Counts how often the interval of each named truth holds it.
fn coverage(
    mut trial: impl FnMut(u64) -> (Estimate, Vec<(&'static str, f64)>),
) -> BTreeMap<&'static str, f64> {
    let mut held: BTreeMap<&'static str, u64> = BTreeMap::new();
    for seed in 0..TRIALS {
        let (estimate, truths) = trial(seed);
        for (name, truth) in truths {
            let q = estimate.get(name).unwrap();
            let inside = (q.value - truth).abs() <= q.expanded(0.95);
            *held.entry(name).or_default() += u64::from(inside);
        }
    }
    held.into_iter()
        .map(|(name, n)| (name, n as f64 / TRIALS as f64))
        .collect()
}

/// 95 % of 2000 less four binomial deviations (0.5 %); at most what a safe rule may add.
fn check(coverage: BTreeMap<&'static str, f64>, upper: f64) {
    for (name, share) in coverage {
        assert!((0.93..=upper).contains(&share), "{name}: {share}");
    }
}

fn gravity() -> Gravity {
    Gravity::given(G, 2e-4).unwrap()
}

/// The errors common to all readings are drawn with each trial: their uncertainty counts as what it says.
#[test]
fn coverage_tilt() {
    let (b, s, phase) = (0.3, 0.7, 0.4f64.to_radians());
    check(
        coverage(|seed| {
            let mut n = Normal::new(seed);
            let (g, zero) = (G + 2e-4 * n.draw(), 1e-3 * n.draw());
            let angle: Vec<f64> = (0..12).map(|i| f64::from(30 * i).to_radians()).collect();
            let output: Vec<f64> = angle
                .iter()
                .map(|t| b + s * g * (t + zero + phase).cos() + 2e-3 * n.draw())
                .collect();
            let mut test = Tilt::new(gravity());
            test.zero_uncertainty = 1e-3;
            let fit = test.fit(&angle, &output, "V").unwrap();
            (
                fit.estimate,
                vec![("bias", b), ("sensitivity", s), ("misalignment", phase)],
            )
        }),
        0.97,
    );
}

#[test]
fn law_a_straight_axis_shows_no_second_harmonic() {
    let mut alarms = 0;
    for seed in 0..500 {
        let mut n = Normal::new(seed);
        let angle: Vec<f64> = (0..24).map(|i| f64::from(15 * i).to_radians()).collect();
        let output: Vec<f64> = angle
            .iter()
            .map(|t| 2.0 + t.cos() + 1e-3 * n.draw())
            .collect();
        let fit = Tilt::new(gravity()).fit(&angle, &output, "V").unwrap();
        alarms += fit.findings.len();
    }
    // 1 % of 500 is 5; more than 14 once in four thousand times.
    assert!(alarms <= 14, "{alarms}");
}

#[test]
fn known_curved_axis_shows_a_second_harmonic() {
    let mut n = Normal::new(1);
    let angle: Vec<f64> = (0..24).map(|i| f64::from(15 * i).to_radians()).collect();
    let output: Vec<f64> = angle
        .iter()
        .map(|t| 2.0 + t.cos() + 0.02 * (2.0 * t).cos() + 1e-3 * n.draw())
        .collect();
    let fit = Tilt::new(gravity()).fit(&angle, &output, "V").unwrap();
    assert_eq!(fit.findings[0].code(), "second-harmonic");
}

/// V = a + 0.002 a²: ±20 m/s², over both ends the chord is 0.8 above, the middle of the best fit two thirds … of it.
#[test]
fn known_linearity_by_its_definitions() {
    let a: Vec<f64> = (0..41).map(|i| f64::from(i) - 20.0).collect();
    let read = |seed: u64, size: f64, loops: f64| {
        let mut n = Normal::new(seed);
        let way: Vec<f64> = a.iter().chain(a.iter().rev()).copied().collect();
        let output: Vec<f64> = way
            .iter()
            .enumerate()
            .map(|(i, a)| {
                let side = if i < 41 { 0.5 } else { -0.5 };
                a + 0.002 * a * a + loops * side + size * n.draw()
            })
            .collect();
        Linearity::default().fit(&way, &output, None, "V").unwrap()
    };
    let fit = read(1, 1e-9, 0.0);
    let share = |line: &str| {
        let found = fit.departures.iter().find(|d| d.line == line);
        found.unwrap().share
    };
    // 0.002 · 400 = 0.8 of 20; the mean of a² over the readings is 140, so that the ends are 260 · 0.002 off; zero based all 0.8.
    assert!((share("end point") - 0.04).abs() < 1e-8);
    assert!((share("best fit") - 0.026).abs() < 1e-8);
    assert!((share("zero based") - 0.04).abs() < 1e-8);
    let codes = read(1, 1e-3, 0.02).findings;
    assert!(codes.iter().any(|f| f.code() == "rising-and-falling"));
    let (mut held, mut seen, mut alarms) = (0, 0, 0);
    for seed in 0..300 {
        let fit = read(seed, 0.02, 0.0);
        let off = fit.departures.iter().map(|d| {
            let truth = if d.line == "best fit" { 0.026 } else { 0.04 };
            (d.share - truth).abs() <= d.expanded
        });
        held += off.filter(|h| *h).count();
        let named = |fit: &StaticFit| {
            let codes = fit.findings.iter().map(|f| f.code());
            usize::from(codes.into_iter().any(|c| c == "rising-and-falling"))
        };
        alarms += named(&fit);
        // 0.1 % of full scale between rising and falling beside a scatter of 0.1 %.
        seen += named(&read(seed, 0.02, 0.02));
    }
    assert!(held >= 3 * 280, "{held}");
    // A hundredth of 300 is 3; more than 9 once in a thousand times.
    assert!(alarms <= 9, "{alarms}");
    assert!(seen >= 270, "{seen}");
}

/// A cube of 1 % at 1 g lies in the sensitivity by 0.75 %: found from ten readings on, by its size, and in U with fewer.
#[test]
fn known_cube_is_found_or_lies_within_u() {
    let read = |count: u32, cube: f64, seed: u64| {
        let mut n = Normal::new(seed);
        let step = 360.0 / f64::from(count);
        let angle: Vec<f64> = (0..count)
            .map(|i| (step * f64::from(i)).to_radians())
            .collect();
        let output: Vec<f64> = angle
            .iter()
            .map(|t| 2.0 + t.cos() + cube * t.cos().powi(3) + 5e-4 * n.draw())
            .collect();
        Tilt::new(gravity()).fit(&angle, &output, "V").unwrap()
    };
    let said = (0..200).map(|seed| read(12, 0.0, seed).harmonics[1].found);
    let said = said.sum::<f64>() / 200.0;
    let (mut found, mut large) = (0, 0);
    for seed in 0..200 {
        let fit = read(12, 9.6e-3, seed);
        let third = fit.findings.iter().find(|f| f.code() == "third-harmonic");
        found += usize::from(third.is_some());
        let size = fit.harmonics[1].size;
        assert!((size - 2.4e-3).abs() < 4.0 * 5e-4 / 6f64.sqrt(), "{size}");
        // What is said to be found in nine of ten is.
        let again = read(12, 4.0 * said, seed + 1000);
        large += usize::from(again.findings.iter().any(|f| f.code() == "third-harmonic"));
    }
    // A third harmonic of 2.4 mV beside 0.5 mV of scatter in twelve readings.
    assert!(found > 190, "{found}");
    // Nine of ten of 200 is 180, and four deviations; the mean of an estimated scatter is 5 % short with five degrees of freedom.
    assert!((155..=197).contains(&large), "{large}");
    let mut held = 0;
    for seed in 0..200 {
        let quantity = read(8, 9.6e-3, seed).estimate.get("sensitivity").unwrap();
        held += usize::from((quantity.value - 1.0 / G).abs() <= quantity.expanded(0.95));
    }
    assert!(held > 180, "{held}");
    let fit = read(4, 9.6e-3, 1);
    assert!(fit.findings.iter().any(|f| f.code() == "cubic-not-tested"));
}

/// Tilts about two axes lower every reading in the mean and shift the bias where up and down tilt differently.
#[test]
fn coverage_levelling() {
    let (b, s, u) = (5e-4, 10e-3 / G, 1f64.to_radians());
    check(
        coverage(|seed| {
            let mut n = Normal::new(seed);
            let position = [1.0, -1.0];
            let output = position.map(|p| {
                let tilt = (u * n.draw()).hypot(u * n.draw());
                b + s * p * G * tilt.cos() + 1e-9 * n.draw()
            });
            let mut test = Sensitivity::new(Gravity::given(G, 0.0).unwrap());
            test.levelling = u;
            test.reading = Some(1e-9);
            let fit = test.fit(&position, &output, "V").unwrap();
            (fit.estimate, vec![("bias", b), ("sensitivity", s)])
        }),
        // U is that of positions that tilt alike.
        1.0,
    );
}

#[test]
fn known_level_that_was_not_stated() {
    let mut n = Normal::new(4);
    let [x, y, z] = [0.01, 0.0, G].map(|level| -> Vec<f64> {
        let noise = std::iter::repeat_with(|| 1e-3 * n.draw());
        noise.take(200).map(|v| level + v).collect()
    });
    let mut test = ZeroG::new(gravity());
    let codes = |test: &ZeroG| -> Vec<String> {
        let found = test.fit([&x, &y, &z]).unwrap().findings;
        found.iter().map(|f| f.code().to_owned()).collect()
    };
    assert_eq!(codes(&test), ["level-taken-as-exact"]);
    test.levelling = 1e-3;
    assert!(codes(&test).is_empty());
}

#[test]
fn coverage_sensitivity() {
    let (b, s) = (5e-4, 10e-3 / G);
    check(
        coverage(|seed| {
            let mut n = Normal::new(seed);
            let g = G + 2e-4 * n.draw();
            let position: Vec<f64> = (0..6)
                .map(|i| if i % 2 == 0 { 1.0 } else { -1.0 })
                .collect();
            let output: Vec<f64> = position
                .iter()
                .map(|p| b + s * p * g + 2e-7 * n.draw())
                .collect();
            let fit = Sensitivity::new(gravity())
                .fit(&position, &output, "V")
                .unwrap();
            (fit.estimate, vec![("bias", b), ("sensitivity", s)])
        }),
        0.97,
    );
}

/// Correlated noise and a level that is not level.
#[test]
fn coverage_zero_g() {
    let truth = [3e-3, -2e-3, 4e-3];
    let tilt = 0.02f64.to_radians();
    check(
        coverage(|seed| {
            let mut n = Normal::new(seed);
            let level = [G * tilt * n.draw(), G * tilt * n.draw(), G];
            let outputs: [Vec<f64>; 3] = std::array::from_fn(|axis| {
                let mut wander = 0.0;
                (0..600)
                    .map(|_| {
                        wander = 0.8 * wander + 0.6 * n.draw();
                        truth[axis] + level[axis] + 0.02 * wander
                    })
                    .collect()
            });
            let mut test = ZeroG::new(gravity());
            test.levelling = tilt;
            let [x, y, z] = &outputs;
            let fit = test.fit([x, y, z]).unwrap();
            (
                fit.estimate,
                vec![
                    ("bias.x", truth[0]),
                    ("bias.y", truth[1]),
                    ("bias.z", truth[2]),
                ],
            )
        }),
        0.97,
    );
}

/// Columns in another order, or mg taken as m/s²: somebody has to decide; a bias of 0.1 g is one.
#[test]
fn known_gravity_elsewhere() {
    let told = |level: [f64; 3]| {
        let mut n = Normal::new(3);
        let outputs: [Vec<f64>; 3] =
            level.map(|l| (0..200).map(|_| l + 1e-3 * n.draw()).collect::<Vec<f64>>());
        let [x, y, z] = &outputs;
        let fit = ZeroG::new(gravity()).fit([x, y, z]).unwrap();
        let mut findings = fit.findings.iter();
        let elsewhere = findings.find(|f| f.code() == "gravity-elsewhere");
        elsewhere.is_some_and(|f| f.severity() == Severity::Decision)
    };
    assert!(told([0.01, G, 0.0]));
    assert!(told([0.0, 0.0, -G]));
    assert!(told([0.0, 0.0, 1e-3 * G]));
    assert!(told([0.0, 0.0, 1e3 * G]));
    assert!(!told([0.1 * G, -0.1 * G, 1.1 * G]));
}

/// Straight, curved, and curved just enough to be doubtful.
#[test]
fn coverage_linearity_whatever_the_order() {
    for (k2, k3) in [(0.0, 0.0), (2e-3, 0.0), (1e-4, 2e-5), (1e-3, 2e-4)] {
        let (b, k1) = (0.02, 0.1);
        let levels = [-1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0];
        let result = coverage(|seed| {
            let mut n = Normal::new(seed);
            let a: Vec<f64> = levels.iter().chain(&levels).map(|l| l * G).collect();
            let t: Vec<f64> = (0..a.len()).map(|i| 20.0 + i as f64).collect();
            let output: Vec<f64> = a
                .iter()
                .zip(&t)
                .map(|(a, t)| {
                    b + k1 * (a + k2 * a * a + k3 * a * a * a) + 1e-4 * (t - 28.5) + 2e-3 * n.draw()
                })
                .collect();
            let fit = Linearity::default()
                .fit(&a, &output, Some(&t), "V")
                .unwrap();
            (
                fit.estimate,
                vec![
                    ("bias", b),
                    ("sensitivity", k1),
                    ("curvature.2", k2),
                    ("curvature.3", k3),
                    ("temperature", 1e-4),
                ],
            )
        });
        check(result, 0.97);
    }
}

#[test]
fn coverage_centrifuge() {
    let (b, k1, k2) = (1e-3, 7e-3 / G, 2e-6);
    let result = coverage(|seed| {
        let mut n = Normal::new(seed);
        let mut test = Centrifuge::new(0.5);
        test.radius_uncertainty = 1e-4;
        test.speed_uncertainty = 1e-4;
        test.inclination = 1e-3;
        let (radius, speed_error) = (0.5 + 1e-4 * n.draw(), 1.0 + 1e-4 * n.draw());
        let lean = G * 1e-3 * n.draw();
        let speed: Vec<f64> = (0..20).map(|i| 10.0 + 4.5 * f64::from(i)).collect();
        let output: Vec<f64> = speed
            .iter()
            .map(|w| {
                let a = radius * (w * speed_error).powi(2) + lean;
                b + k1 * (a + k2 * a * a) + 2e-4 * n.draw()
            })
            .collect();
        let fit = test.fit(&speed, &output, "V").unwrap();
        assert!(fit.nonlinearity.unwrap() < 0.02);
        (
            fit.estimate,
            vec![("bias", b), ("sensitivity", k1), ("curvature.2", k2)],
        )
    });
    check(result, 0.97);
}

fn calibrated(value: f64, u: f64, dof: f64) -> Estimate {
    Estimate::new(
        vec![Component::new("bias.x", "m/s²", value)],
        vec![Influence {
            key: "noise".into(),
            description: "noise".into(),
            evaluation: Evaluation::A,
            distribution: "t".into(),
            dof: DegreesOfFreedom::new(dof).unwrap(),
            effect: Effect::Joint {
                covariance: Covariance::try_from_rows(1, &[u * u]).unwrap(),
            },
        }],
    )
    .unwrap()
}

fn history(n: &mut Normal, drift: f64, between: f64) -> Vec<DatedEstimate> {
    (0..6)
        .map(|i| {
            let day = 90.0 * f64::from(i);
            let value = 0.05 + drift * day / MONTH + (1e-3f64).hypot(between) * n.draw();
            DatedEstimate {
                day,
                estimate: calibrated(value, 1e-3, 30.0),
                name: format!("{i}"),
            }
        })
        .collect()
}

/// Drift with and without scatter between the calibrations; the rule is safe where there is none.
#[test]
fn coverage_stability() {
    for between in [0.0, 3e-3] {
        let mut held = 0;
        let mut alarms = 0;
        for seed in 0..TRIALS {
            let mut n = Normal::new(seed);
            let drift = 2e-4;
            let fit = Stability::default()
                .fit(&history(&mut n, drift, between))
                .unwrap();
            let q = &fit.drifts[0].drift;
            held += u64::from((q.value - drift).abs() <= q.expanded(0.95));
            let fit = Stability::default()
                .fit(&history(&mut n, 0.0, between))
                .unwrap();
            alarms += u64::from(!fit.findings.is_empty());
        }
        let share = held as f64 / TRIALS as f64;
        assert!((0.93..=0.995).contains(&share), "{between}: {share}");
        // One in a hundred: 20, and four deviations.
        assert!(alarms <= 38, "{alarms}");
    }
}

#[test]
fn known_due_date_of_a_drifting_bias() {
    let exact = |day: f64, value: f64| DatedEstimate {
        day,
        estimate: calibrated(value, 1e-9, 1e9),
        name: String::new(),
    };
    // 1 mm/s² per month without scatter: 5 mm/s² are used up after five months.
    let values: Vec<DatedEstimate> = (0..5)
        .map(|i| exact(f64::from(i) * MONTH, 1e-3 * f64::from(i)))
        .collect();
    let mut test = Stability::default();
    test.tolerances = vec![("bias.x".to_owned(), 5e-3)];
    let fit = test.fit(&values).unwrap();
    assert!(
        (fit.due_in / MONTH - 5.0).abs() < 0.01,
        "{}",
        fit.due_in / MONTH
    );
    assert!(fit.findings.iter().any(|f| f.code() == "calibration-drift"));
    test.tolerances[0].1 = 1e-12;
    let spent = test.fit(&values).unwrap().findings;
    assert!(spent.iter().any(|f| f.code() == "tolerance-exhausted"));
    test.tolerances[0].1 = 1.0;
    assert_eq!(test.fit(&values).unwrap().due_in, 12.0 * MONTH);
    assert!(matches!(test.fit(&values[..2]), Err(Error::TooFew { .. })));
}

#[test]
fn refuses_readings_that_do_not_carry_the_test() {
    let g = gravity();
    let same = [0.0; 6];
    let y = [1.0, 1.1, 0.9, 1.0, 1.0, 1.1];
    assert!(Tilt::new(g).fit(&same, &y, "V").unwrap_err().is_data());
    assert!(Tilt::new(g).fit(&[0.0, 1.0, 2.0], &y[..3], "V").is_err());
    assert!(
        Sensitivity::new(g)
            .fit(&[1.0; 6], &y, "V")
            .unwrap_err()
            .is_data()
    );
    assert!(Sensitivity::new(g).fit(&[1.0, 0.5], &y[..2], "V").is_err());
    let two = Sensitivity::new(g).fit(&[1.0, -1.0], &y[..2], "V");
    assert!(
        two.unwrap_err()
            .to_string()
            .contains("standard uncertainty")
    );
    assert!(
        Linearity::default()
            .fit(&[1.0; 12], &[1.0; 12], None, "V")
            .is_err()
    );
    assert!(
        Linearity::default()
            .fit(&y, &[1.0, f64::NAN, 1.0, 1.0, 1.0, 1.0], None, "V")
            .is_err()
    );
    assert!(Centrifuge::new(-1.0).fit(&y, &y, "V").is_err());
    assert!(ZeroG::new(g).fit([&y, &y, &y]).unwrap_err().is_data());
}

/// One degree between two axes is 17 mg, 0.05° less than 1 mg.
#[test]
fn published_misalignment_of_one_degree_is_seventeen_mg() {
    for (degrees, mg) in [(1.0f64, 17.45), (0.05, 0.873)] {
        let m = degrees.to_radians().tan();
        let k = [[2.0, 2.0 * m, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 5.0]];
        let covariance = Covariance::try_from_rows(1, &[1e-10]).unwrap();
        let estimate = Estimate::new(
            vec![Component::new("misalignment.xy", "rad", m)],
            vec![Influence {
                key: "noise".into(),
                description: "noise".into(),
                evaluation: Evaluation::A,
                distribution: "normal".into(),
                dof: DegreesOfFreedom::INFINITE,
                effect: Effect::Joint { covariance },
            }],
        )
        .unwrap();
        let fit = Orthogonality::default().fit(&k, &estimate).unwrap();
        let q = fit.estimate.get("cross_axis.xy").unwrap();
        assert!(
            (q.value / 9.80665e-3 - mg).abs() < 0.005,
            "{}",
            q.value / 9.80665e-3
        );
        // ∂(g sin δ)/∂m = g cos³ δ.
        let u = 1e-5 * G * degrees.to_radians().cos().powi(3);
        assert!((q.standard_uncertainty - u).abs() < 1e-9);
        assert_eq!(fit.findings.is_empty(), degrees < 0.06);
        if let Some(finding) = fit.findings.first() {
            assert_eq!(finding.code(), "not-orthogonal");
        }
    }
}

/// One recording under two names, positions exchanged, g under the name of m/s²: each is a decision with its name.
#[test]
fn known_two_positions_that_cannot_be_have_names() {
    let mut test = Sensitivity::new(Gravity::given(9.80665, 1e-5).unwrap());
    test.reading = Some(1e-3);
    let codes = |up: f64, down: f64| -> Vec<String> {
        let fit = test.fit(&[1.0, -1.0], &[up, down], "m/s²").unwrap();
        fit.findings.iter().map(|f| f.code().to_owned()).collect()
    };
    assert_eq!(codes(9.91, 9.91), ["no-response"]);
    assert_eq!(codes(-9.71, 9.91), ["axis-inverted"]);
    assert_eq!(codes(1.01, -0.99), ["unit-suspected"]);
    assert!(codes(9.91, -9.71).is_empty());
}

/// Readings of which every other scatters ten times as much: with weights intervals hold as well and are a third as wide or less.
#[test]
fn coverage_linearity_with_weights() {
    let a: Vec<f64> = (0..24).map(|i| G * (f64::from(i) / 11.5 - 1.0)).collect();
    let u: Vec<f64> = (0..24)
        .map(|i| if i % 2 == 0 { 1e-4 } else { 1e-3 })
        .collect();
    let (mut held, mut ratio, trials) = (0, 0.0, 1000);
    for seed in 0..trials {
        let mut n = Normal(Xoshiro256PlusPlus::seed_from_u64(seed));
        let output: Vec<f64> = a
            .iter()
            .zip(&u)
            .map(|(a, u)| 0.1 + 0.02 * a + u * n.draw())
            .collect();
        let of = |u: Option<&[f64]>| {
            let fit = Linearity::default()
                .fit_weighed(&a, &output, None, u, "V")
                .unwrap();
            let q = fit.estimate.get("sensitivity").unwrap();
            (q.value, q.expanded(0.95))
        };
        // In any unit: only ratios count.
        let percent: Vec<f64> = u.iter().map(|u| 1e4 * u).collect();
        let (value, expanded) = of(Some(&percent));
        held += usize::from((value - 0.02).abs() <= expanded);
        ratio += expanded / of(None).1 / trials as f64;
    }
    // 95 % of 1000 less four deviations (6.9).
    assert!(held > 922 && held < 978, "{held}");
    assert!(ratio < 0.33, "{ratio}");
    assert!(
        Linearity::default()
            .fit_weighed(&a, &a, None, Some(&[1.0; 3]), "V")
            .is_err()
    );
    assert!(
        Linearity::default()
            .fit_weighed(&a, &a, None, Some(&[0.0; 24]), "V")
            .is_err()
    );
}

/// A vehicle that stands, accelerates twice and brakes once on a straight road; the outputs of a sensor at these angles, and the stretches.
fn driven(seed: u64, angles: [f64; 3], wander: f64) -> ([Vec<f64>; 3], Mounting) {
    let mut n = Normal::new(seed);
    let turn = TaitBryan::new(angles[0], angles[1], angles[2])
        .unwrap()
        .matrix::<f64>();
    let level = [n.draw(), n.draw()].map(|d| 0.2f64.to_radians() * d);
    let straight = 0.3f64.to_radians() * n.draw();
    let bias: [f64; 3] = std::array::from_fn(|_| 0.01 * n.draw());
    let mut outputs: [Vec<f64>; 3] = Default::default();
    let mut sway = [0.0; 2];
    for k in 0..4000 {
        let forward = match k {
            1000..1500 => 1.5 + 0.5 * (0.01 * f64::from(k)).sin(),
            2000..2400 => 2.0,
            3000..3300 => -3.0,
            _ => 0.0,
        };
        // Lateral accelerations of the road, and vibration of the body while it moves.
        let moving = f64::from(u8::from(forward != 0.0));
        sway = sway.map(|s| 0.9 * s + wander * moving * n.draw());
        let a = [
            forward * straight.cos() - G * level[1],
            forward * straight.sin() + sway[0] + G * level[0],
            G + sway[1],
        ];
        let own = turn.transpose().times(a);
        for axis in 0..3 {
            outputs[axis].push(own[axis] + bias[axis] + 0.02 * n.draw());
        }
    }
    let mut test = Mounting::default();
    test.rest = [0, 900];
    test.forward = vec![[1000, 1500], [2000, 2400]];
    test.braking = vec![[3000, 3300]];
    test.levelling = 0.2f64.to_radians();
    test.straightness = 0.3f64.to_radians();
    test.bias = 0.01;
    (outputs, test)
}

/// Level, oblique, upside down.
#[test]
fn coverage_mounting() {
    for angles in [
        [0.0, 0.0, 0.0],
        [0.3, -0.4, 2.5],
        [3.0, 0.2, -1.0],
        [0.1, 1.2, 0.5],
    ] {
        let mut held = [0; 3];
        for seed in 0..300 {
            let (outputs, test) = driven(seed, angles, 0.05);
            let [x, y, z] = &outputs;
            let (fit, turn) = test.fit([x, y, z]).unwrap();
            assert!(fit.findings.is_empty(), "{:?}", fit.findings);
            assert_eq!(turn.angles[0], fit.estimate.get("roll").unwrap().value);
            let truths = ["roll", "pitch", "yaw"].into_iter().zip(angles);
            for (held, (name, truth)) in held.iter_mut().zip(truths) {
                let q = fit.estimate.get(name).unwrap();
                *held += usize::from((q.value - truth).abs() <= q.expanded(0.95));
            }
        }
        // 300 of 95 %: 285 ± 4 · 3.8.
        assert!(
            held.iter().all(|h| (270..=300).contains(h)),
            "{angles:?} {held:?}"
        );
    }
}

/// Near the vertical roll and yaw turn about one axis, and each by itself means little: the turn itself is as well known as ever.
#[test]
fn law_the_turn_is_known_where_its_angles_are_not() {
    let mut inside = 0;
    for seed in 0..200 {
        let angles = [0.0, -std::f64::consts::FRAC_PI_2 + 1e-4, 0.4];
        let (outputs, test) = driven(seed, angles, 0.05);
        let [x, y, z] = &outputs;
        let (_, turn) = test.fit([x, y, z]).unwrap();
        let [r, p, w] = turn.angles;
        let found = TaitBryan::new(r, p, w).unwrap().matrix::<f64>();
        let truth = TaitBryan::new(angles[0], angles[1], angles[2])
            .unwrap()
            .matrix::<f64>();
        let off = found.product(&truth.transpose()).0;
        let about = [
            0.5 * (off[2][1] - off[1][2]),
            0.5 * (off[0][2] - off[2][0]),
            0.5 * (off[1][0] - off[0][1]),
        ];
        for axis in 0..3 {
            let u = turn.covariance[axis][axis].sqrt();
            assert!(u < 0.02, "{u}");
            inside += usize::from(about[axis].abs() < 1.96 * u);
        }
    }
    // 600: 95 % ± 4 · 0.9 %.
    assert!((548..=592).contains(&inside), "{inside}");
}

#[test]
fn known_doubts_of_a_mounting() {
    let codes = |change: &dyn Fn(&mut [Vec<f64>; 3], &mut Mounting), wander: f64| -> Vec<String> {
        let (mut outputs, mut test) = driven(1, [0.1, 0.2, 0.3], wander);
        change(&mut outputs, &mut test);
        let [x, y, z] = &outputs;
        let (fit, _) = test.fit([x, y, z]).unwrap();
        fit.findings.iter().map(|f| f.code().to_owned()).collect()
    };
    assert_eq!(
        codes(&|_, t| t.levelling = 0.0, 0.05),
        ["level-taken-as-exact"]
    );
    let half =
        |o: &mut [Vec<f64>; 3], _: &mut Mounting| o.iter_mut().flatten().for_each(|v| *v *= 0.5);
    assert_eq!(codes(&half, 0.05), ["rest-is-not-gravity"]);
    assert_eq!(codes(&|_, _| (), 1.0), ["travel-not-straight"]);
    // The road rises where it accelerates: the nose points up by a tenth.
    let rising = |o: &mut [Vec<f64>; 3], _: &mut Mounting| {
        let turn = TaitBryan::new(0.1, 0.2, 0.3).unwrap().matrix::<f64>();
        let up = turn.transpose().times([0.0, 0.0, 1.0]);
        for axis in 0..3 {
            o[axis][1000..1500].iter_mut().for_each(|v| *v += up[axis]);
            o[axis][2000..2400].iter_mut().for_each(|v| *v += up[axis]);
        }
    };
    assert_eq!(codes(&rising, 0.05), ["travel-leaves-the-level"]);
    // Somebody gets in after half of the rest: the body leans by half a degree.
    let leans = |o: &mut [Vec<f64>; 3], t: &mut Mounting| {
        let middle = (t.rest[0] + t.rest[1]) / 2;
        o[0][middle..t.rest[1]].iter_mut().for_each(|v| *v += 0.085);
    };
    assert_eq!(codes(&leans, 0.05), ["rest-moves"]);
    // Stretches that overlap, and ground without a level.
    for change in [
        (|t: &mut Mounting| t.forward.push(t.braking[0])) as fn(&mut Mounting),
        |t| t.forward[0][0] = t.rest[0],
        |t| t.levelling = 3.0,
    ] {
        let (outputs, mut test) = driven(1, [0.0; 3], 0.05);
        change(&mut test);
        let [x, y, z] = &outputs;
        assert!(matches!(test.fit([x, y, z]), Err(Error::OutOfRange { .. })));
    }
    let (outputs, mut test) = driven(1, [0.0; 3], 0.05);
    let [x, y, z] = &outputs;
    test.forward = vec![[2500, 2900]];
    test.braking.clear();
    assert!(matches!(
        test.fit([x, y, z]),
        Err(Error::Unobservable { .. })
    ));
    test.forward = vec![[3900, 4100]];
    assert!(matches!(test.fit([x, y, z]), Err(Error::OutOfRange { .. })));
    test.forward.clear();
    assert!(matches!(test.fit([x, y, z]), Err(Error::TooFew { .. })));
}
