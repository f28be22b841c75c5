//! Temperature sweeps with known truth, and one that others recorded.

use proofmass_core::Error;
use proofmass_static::{SweepData, TemperatureFit, TemperatureSweep};
use proofmass_uncertainty::Severity;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

const G: f64 = 9.80665;
const MG: f64 = G * 1e-3;
const N: usize = 4000;

/// How the output of one axis follows the temperature, and its noise.
#[derive(Clone, Copy)]
struct Truth {
    slope: [f64; 3],
    quadratic: f64,
    cubic: f64,
    white: f64,
    /// Standard deviation and correlation time, in samples, of a Gauss–Markov wander.
    wander: (f64, f64),
    hysteresis: f64,
}

const QUIET: Truth = Truth {
    slope: [0.05 * MG, -0.2 * MG, 1.0 * MG],
    quadratic: 0.0,
    cubic: 0.0,
    white: 0.05,
    wander: (0.0, 1.0),
    hysteresis: 0.0,
};

struct Recording {
    outputs: [Vec<f64>; 3],
    temperature: Vec<f64>,
}

impl Recording {
    fn data(&self) -> SweepData<'_> {
        let [x, y, z] = &self.outputs;
        SweepData {
            outputs: vec![x, y, z],
            temperature: &self.temperature,
            rate: 1.0,
        }
    }

    fn fit(&self) -> Result<TemperatureFit, Error> {
        TemperatureSweep::default().fit(&self.data())
    }
}

/// −18 … 74 °C, up only, or up and down with rests at the ends and rates that vary.
fn profile(cycle: bool) -> Vec<(f64, f64)> {
    let shape = |s: f64| {
        // Fast at first, slower towards the end, as a chamber does.
        let s = s.clamp(0.0, 1.0);
        (1.0 - (-2.0 * s).exp()) / (1.0 - (-2.0f64).exp())
    };
    (0..N)
        .map(|i| {
            let s = i as f64 / N as f64;
            if cycle {
                if s < 0.5 {
                    (-18.0 + 92.0 * shape((s - 0.02) / 0.45), 1.0)
                } else {
                    (74.0 - 92.0 * shape((s - 0.52) / 0.45), -1.0)
                }
            } else {
                (-18.0 + 92.0 * s, 1.0)
            }
        })
        .collect()
}

fn simulate(truth: &Truth, cycle: bool, seed: u64) -> Recording {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut normal = move || -> f64 { random.sample(StandardNormal) };
    let path = profile(cycle);
    let temperature: Vec<f64> = path.iter().map(|(t, _)| t + 0.06 * normal()).collect();
    let level = [0.01 * G, -0.02 * G, 1.002 * G];
    let outputs = [0, 1, 2].map(|axis| {
        let (deviation, time) = truth.wander;
        let keep = (-1.0 / time).exp();
        let mut wander = deviation * normal();
        path.iter()
            .map(|(t, sign)| {
                let d = t - 28.0;
                wander = keep * wander + deviation * (1.0 - keep * keep).sqrt() * normal();
                // A loop that closes at both ends.
                let loop_shape = 1.0 - (d / 46.0).powi(2);
                level[axis]
                    + truth.slope[axis] * d
                    + truth.quadratic * d * d
                    + truth.cubic * d * d * d
                    + 0.5 * sign * truth.hysteresis * loop_shape.max(0.0)
                    + wander
                    + truth.white * normal()
            })
            .collect()
    });
    Recording {
        outputs,
        temperature,
    }
}

/// Whether the intervals of the mean slope of x and of its coefficients hold the truth.
fn covered(truth: &Truth, seed: u64) -> [bool; 4] {
    // Half the blocks of the default: the same rule in an eighth of the time.
    let mut settings = TemperatureSweep::default();
    settings.blocks = 100;
    settings.reference = Some(28.0);
    let fit = settings.fit(&simulate(truth, false, seed).data()).unwrap();
    // Over −18 … 74 °C the odd powers are 46² c₃ of mean slope; the even one has none about the middle.
    [
        ("slope.x", truth.slope[0] + truth.cubic * 46.0 * 46.0),
        ("output.x.T1", truth.slope[0]),
        ("output.x.T2", truth.quadratic),
        ("output.x.T3", truth.cubic),
    ]
    .map(|(name, value)| {
        let q = fit.estimate.get(name).unwrap();
        (q.value - value).abs() <= q.expanded(0.95)
    })
}

/// Nominal 95 % intervals of the mean slope and of the coefficients, whatever the order and the noise.
#[test]
fn coverage_whatever_order_and_noise() {
    let cases = [
        ("linear, white", QUIET),
        (
            "quadratic, white",
            Truth {
                quadratic: 5e-6,
                ..QUIET
            },
        ),
        (
            "barely cubic",
            Truth {
                cubic: 3e-8,
                ..QUIET
            },
        ),
        (
            "linear, wander over a twentieth of the sweep",
            Truth {
                wander: (0.01, 200.0),
                ..QUIET
            },
        ),
    ];
    for (name, truth) in cases {
        let trials = 120;
        let held: Vec<[bool; 4]> = (0..trials)
            .into_par_iter()
            .map(|seed| covered(&truth, 1000 + seed))
            .collect();
        for quantity in 0..4 {
            let held = held.iter().filter(|h| h[quantity]).count();
            // 95 % of 120 less 3.5 binomial deviations (2.4). Twenty correlation times tell a wander badly: what is
            // stated as 95 % then holds nine times in ten, 108 less four deviations (3.3).
            let least = if truth.wander.0 > 0.0 { 95 } else { 105 };
            assert!(held >= least, "{name}, {quantity}: {held} of {trials}");
        }
    }
}

#[test]
fn known_coefficients_of_a_sweep() {
    let truth = Truth {
        quadratic: 2e-5,
        white: 0.02,
        ..QUIET
    };
    let fit = simulate(&truth, false, 5).fit().unwrap();
    assert!((fit.reference - 28.0).abs() < 0.2);
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let slope = fit.estimate.get(&format!("slope.{name}")).unwrap();
        assert!((slope.value - truth.slope[axis]).abs() < 3.5 * slope.standard_uncertainty);
        assert!(slope.standard_uncertainty < 0.01 * MG);
        let bend = fit.estimate.get(&format!("output.{name}.T2")).unwrap();
        assert!((bend.value - truth.quadratic).abs() < 3.5 * bend.standard_uncertainty);
        // A straight line has no weight where the bend is a hundred times its uncertainty.
        assert!(fit.axes[axis].orders[0].weight < 1e-6);
        let f = fit.axes[axis].orders[1].f.unwrap();
        assert!(f > fit.axes[axis].orders[1].f_limit);
        assert!(
            fit.axes[axis].orders[1].cross_validation < fit.axes[axis].orders[0].cross_validation
        );
    }
    assert!(fit.findings.iter().any(|f| f.code() == "one-direction"));
    assert!(!fit.findings.iter().any(|f| f.code() == "output-step"));
}

/// A full cycle with 11 mg between the branches: shown, not averaged away, and the slope is not bent by it.
#[test]
fn known_hysteresis_of_a_full_cycle() {
    let truth = Truth {
        hysteresis: 11.0 * MG,
        white: 0.02,
        ..QUIET
    };
    let mut gaps = Vec::new();
    for seed in 0..8 {
        let fit = simulate(&truth, true, 70 + seed).fit().unwrap();
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let h = fit.axes[axis].hysteresis.as_ref().unwrap();
            gaps.push(h.difference / MG);
            let slope = fit.estimate.get(&format!("slope.{name}")).unwrap();
            assert!((slope.value - truth.slope[axis]).abs() < 4.0 * slope.standard_uncertainty);
        }
        assert_eq!(
            fit.findings
                .iter()
                .filter(|f| f.code() == "hysteresis")
                .count(),
            3
        );
    }
    let mean = gaps.iter().sum::<f64>() / gaps.len() as f64;
    // The loop is cut where the branches turn: a tenth less is seen of it at most.
    assert!((10.0..11.6).contains(&mean), "{mean} {gaps:?}");
}

/// Without hysteresis: at most the stated three in a hundred (three axes at one in a hundred each).
/// A loop that opens in a fifth of the range only, which a square of the temperature does not follow: 8 mg by the outputs.
#[test]
fn known_loop_beyond_the_model_is_said() {
    let mut recording = simulate(&QUIET, true, 3);
    let path = profile(true);
    for (output, (t, sign)) in recording.outputs[2].iter_mut().zip(&path) {
        *output += 4.0 * MG * sign * (-((t - 50.0) / 9.0).powi(2)).exp();
    }
    let fit = recording.fit().unwrap();
    let h = fit.axes[2].hysteresis.as_ref().unwrap();
    let [temperature, raw, model] = h.disagreement.unwrap();
    assert!((temperature - 50.0).abs() < 12.0, "{h:?}");
    assert!(raw / MG > 5.0 && raw > 1.3 * model, "{raw} {model}");
    assert!(h.of_a_reading() >= 0.5 * raw / 3f64.sqrt());
    assert!(
        fit.findings
            .iter()
            .any(|f| f.code() == "branches-beyond-model")
    );
}

/// At most a hundredth of healthy cycles, with white noise and with a wander of 0.3 mg. (Of 240, a third without wander and the others with one
/// of 1 mg, 17 had it: such a wander does make branches differ.)
#[test]
fn law_raw_branches_agree_with_the_model_where_nothing_is_hidden() {
    let alarms: usize = (0..120u64)
        .into_par_iter()
        .map(|seed| {
            let wander = [(0.0, 1.0), (0.3 * MG, 300.0), (0.3 * MG, 2000.0)][seed as usize % 3];
            let truth = Truth {
                wander,
                hysteresis: [0.0, 2.0 * MG][seed as usize % 2],
                ..QUIET
            };
            let fit = simulate(&truth, true, seed).fit().unwrap();
            let codes = fit.findings.iter().map(|f| f.code());
            usize::from(codes.into_iter().any(|c| c == "branches-beyond-model"))
        })
        .sum();
    // A hundredth of 120 is 1.2; more than 5 once in a thousand times.
    assert!(alarms <= 5, "{alarms}");
}

#[test]
fn law_no_hysteresis_is_found_where_none_is() {
    let found: usize = (0..40u64)
        .into_par_iter()
        .map(|seed| {
            let fit = simulate(&QUIET, true, 300 + seed).fit().unwrap();
            fit.findings
                .iter()
                .filter(|f| f.code() == "hysteresis")
                .count()
        })
        .sum();
    // 120 axes at 1 %: more than 6 once in a thousand times.
    assert!(found <= 6, "{found}");
}

#[test]
fn refuses_a_board_that_was_turned_between_two_temperatures() {
    // Two stretches of constant temperature; between them the board is turned by 90° about x.
    let mut recording = simulate(&QUIET, false, 9);
    for i in 0..N {
        let warm = i >= N / 2;
        let t = if warm { 60.0 } else { -10.0 };
        let noise = recording.temperature[i] - (-18.0 + 92.0 * i as f64 / N as f64);
        recording.temperature[i] = t + noise;
        let keep: [f64; 3] = [0, 1, 2].map(|a| recording.outputs[a][i]);
        if warm {
            recording.outputs[1][i] = keep[2];
            recording.outputs[2][i] = -keep[1];
        }
    }
    let error = recording.fit().unwrap_err();
    assert!(matches!(error, Error::Unobservable { .. }), "{error}");
    assert!(
        error
            .to_string()
            .contains("turned between the temperatures"),
        "{error}"
    );

    // Not turned, but the temperature still jumps: computed, with a decision if the specific force turned by a degree.
    let mut jump = simulate(&QUIET, false, 9);
    for i in 0..N {
        let t = if i >= N / 2 { 60.0 } else { -10.0 };
        for axis in 0..3 {
            jump.outputs[axis][i] += QUIET.slope[axis] * (t - (-18.0 + 92.0 * i as f64 / N as f64));
        }
        jump.temperature[i] = t + 0.01 * f64::from(i as u32 % 7);
    }
    let fit = jump.fit().unwrap();
    assert!(fit.findings.iter().any(|f| f.code() == "temperature-jump"));
}

/// Turned while the temperature goes on: each stretch tells the slope, the turn does not spoil it; with z both ways up
/// bias and scale come apart on every axis that was turned far enough.
#[test]
fn known_sweeps_in_several_attitudes_tell_scale_from_bias() {
    let (bias, scale) = ([1e-3, -5e-4, 2e-3], [2e-4, -1e-4, 3e-4]);
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    let directions = [
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
    ];
    let mut outputs: [Vec<f64>; 3] = Default::default();
    let mut temperature = Vec::new();
    for (s, u) in directions.iter().enumerate() {
        for i in 0..1500 {
            let up = i as f64 / 1500.0;
            let t = if s % 2 == 0 {
                -20.0 + 80.0 * up
            } else {
                60.0 - 80.0 * up
            };
            let d = t - 20.0;
            temperature.push(t);
            for axis in 0..3 {
                let noise: f64 = random.sample(StandardNormal);
                outputs[axis].push(
                    0.02 * G * (axis as f64 - 1.0)
                        + bias[axis] * d
                        + G * u[axis] * (1.0 + scale[axis] * d)
                        + 0.01 * noise,
                );
            }
        }
    }
    let fit = Recording {
        outputs,
        temperature,
    }
    .fit()
    .unwrap();
    assert!(fit.scale);
    assert_eq!(fit.attitudes().len(), 6);
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        for (kind, truth) in [("bias", bias[axis]), ("scale", scale[axis])] {
            let q = fit.estimate.get(&format!("{kind}.{name}.T1")).unwrap();
            // The bias of the intercepts makes u g of the scale uncertain by 2 %: the attitude is taken from the output.
            let allowed = 4.0 * q.standard_uncertainty + 0.025 * truth.abs();
            assert!(
                (q.value - truth).abs() < allowed,
                "{kind}.{name}: {} {truth}",
                q.value
            );
        }
    }
}

/// Switched on at the beginning: A e^{−t/τ} on every axis; the thermometer is `lag` seconds late.
fn switched_on(amplitude: [f64; 3], tau: f64, lag: usize, cycle: bool, seed: u64) -> Recording {
    let mut recording = simulate(&QUIET, cycle, seed);
    for (column, amplitude) in recording.outputs.iter_mut().zip(amplitude) {
        for (i, v) in column.iter_mut().enumerate() {
            *v += amplitude * (-(i as f64) / tau).exp();
        }
    }
    let t = recording.temperature.clone();
    recording.temperature[lag..].copy_from_slice(&t[..t.len() - lag]);
    recording
}

fn warm_up() -> TemperatureSweep {
    let mut settings = TemperatureSweep::default();
    settings.blocks = 100;
    settings.reference = Some(28.0);
    settings.warm_up = Some(600.0);
    settings
}

/// Forty cycles with 3, −2 and 5 mg of self-heating and a thermometer 15 s late, forty without. Of 120 intervals at 95 % 114 ± 4 · 2.4
/// hold, of forty 38 ± 4 · 1.4; self-heating is reported where there is none in one of a hundred recordings.
#[test]
fn coverage_of_self_heating_and_lag() {
    let amplitude = [3.0 * MG, -2.0 * MG, 5.0 * MG];
    let truths: Vec<[usize; 4]> = (0..40u64)
        .into_par_iter()
        .map(|seed| {
            let data = switched_on(amplitude, 200.0, 15, true, seed);
            let fit = warm_up().fit(&data.data()).unwrap();
            let mut count = [0; 4];
            for (axis, (name, a)) in fit
                .axes
                .iter()
                .zip(["x", "y", "z"].into_iter().zip(amplitude))
            {
                let found = axis.self_heating.unwrap();
                assert!(found.determined, "{found:?}");
                let off = (found.amplitude - a).abs() / found.standard_uncertainty;
                count[0] += usize::from(off < 1.96);
                let slope = fit.estimate.get(&format!("slope.{name}")).unwrap();
                let truth = QUIET.slope[["x", "y", "z"].iter().position(|n| *n == name).unwrap()];
                count[1] += usize::from((slope.value - truth).abs() < slope.expanded(0.95));
            }
            let [lag, u] = fit.thermometer_lag().unwrap();
            count[2] += usize::from((lag - 15.0).abs() < 1.96 * u);
            let healthy = switched_on([0.0; 3], 200.0, 0, true, 1000 + seed);
            let healthy = warm_up().fit(&healthy.data()).unwrap();
            count[3] += usize::from(healthy.findings.iter().any(|f| f.code() == "warm-up"));
            count
        })
        .collect();
    let total = |k: usize| truths.iter().map(|c| c[k]).sum::<usize>();
    let [amplitudes, slopes, lags, alarms] = [0, 1, 2, 3].map(total);
    println!("{amplitudes} and {slopes} of 120, {lags} of 40; {alarms} of 40 told");
    assert!(amplitudes >= 104, "{amplitudes} of 120");
    assert!(slopes >= 104, "{slopes} of 120");
    assert!(lags >= 32, "{lags} of 40");
    assert!(alarms <= 3, "{alarms} of 40");
}

/// One way only, and a decay that may be as slow as the sweep: nobody can tell it from temperature, and that is said.
#[test]
fn refuses_self_heating_as_slow_as_the_sweep() {
    let data = switched_on([20.0 * MG; 3], 2000.0, 0, false, 3);
    let mut settings = warm_up();
    settings.warm_up = Some(4000.0);
    let fit = settings.fit(&data.data()).unwrap();
    let found = fit
        .findings
        .iter()
        .find(|f| f.code() == "self-heating-not-determined");
    assert!(
        found.is_some_and(|f| f.severity() == Severity::Decision),
        "{:?}",
        fit.findings
    );
    assert!(fit.thermometer_lag().is_none());
    for longest in [0.0, -1.0, f64::NAN] {
        settings.warm_up = Some(longest);
        assert!(settings.fit(&data.data()).is_err());
    }
}

#[test]
fn refuses_what_carries_no_coefficient() {
    let mut flat = simulate(&QUIET, false, 1);
    flat.temperature.iter_mut().for_each(|t| *t = 21.0);
    assert!(matches!(flat.fit(), Err(Error::Constant { .. })));
    let mut short = simulate(&QUIET, false, 1);
    short.temperature.truncate(20);
    short.outputs.iter_mut().for_each(|o| o.truncate(20));
    assert!(matches!(short.fit(), Err(Error::TooFew { .. })));
    let mut broken = simulate(&QUIET, false, 1);
    broken.outputs[1][7] = f64::NAN;
    assert!(matches!(
        broken.fit(),
        Err(Error::NotFinite {
            name: "y",
            index: 7
        })
    ));
    let mut settings = TemperatureSweep::default();
    settings.largest_order = 4;
    assert!(settings.fit(&simulate(&QUIET, false, 1).data()).is_err());
}

/// ICM-42652 in a chamber, −18 → −13 °C: an independent straight line gives +1.165(46) mg/K on z.
#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn crosscheck_icm42652_slope() {
    let folder = std::env::var("PROOFMASS_REFERENCE_DATA").unwrap();
    let path = std::path::Path::new(&folder).join("icm42652-temperature/sample.csv");
    let text = std::fs::read_to_string(path).unwrap();
    let rows: Vec<Vec<f64>> = text
        .lines()
        .map(|l| l.split(',').map(|w| w.trim().parse().unwrap()).collect())
        .collect();
    let column = |i: usize, factor: f64| rows.iter().map(|r| factor * r[i]).collect::<Vec<f64>>();
    let recording = Recording {
        outputs: [column(1, MG), column(2, MG), column(3, MG)],
        temperature: column(4, 1.0),
    };
    let mut data = recording.data();
    data.rate = 500.0;
    let fit = TemperatureSweep::default().fit(&data).unwrap();
    let z = fit.estimate.get("slope.z").unwrap();
    let apart = (z.value / MG - 1.165).abs();
    assert!(
        apart <= (z.expanded(0.95) / MG).hypot(2.0 * 0.046),
        "{} {}",
        z.value / MG,
        apart
    );
    assert!((0.046..0.4).contains(&(z.standard_uncertainty / MG)));
}
