//! The uncertainty crate beside numpy, GTC and the Python package `uncertainties`, run in the same minute.
//!
//! The Python interpreter is taken from the variable PROOFMASS_BENCH_PYTHON, else `python3`; it needs numpy, GTC and
//! uncertainties. Peers run alone, on the same machine, before ours; each figure is the best of several runs.
//! One thread is what numpy uses; the second column uses every core the peer leaves idle.

mod peer;

use peer::{Peers, best};
use proofmass_core::Error;
use proofmass_uncertainty::{
    DegreesOfFreedom, Distribution, Input, Inputs, JointInputs, Linear, Model, MonteCarlo, Number,
    Trials, UncertaintyModel, propagate, propagate_independent, propagate_jacobian,
};
use std::hint::black_box;

struct EndGauge;

impl Model for EndGauge {
    fn outputs(&self) -> Vec<(String, String)> {
        vec![("length".into(), "nm".into())]
    }
    fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
        let &[l_s, d, d1, d2, alpha_s, theta_0, delta, d_alpha, d_theta] = x else {
            return;
        };
        y[0] = l_s + d + d1 + d2
            - l_s * (d_alpha * (theta_0 + delta) + alpha_s * d_theta)
            - T::from(50_000_000.0);
    }
}

fn end_gauge() -> Inputs {
    let t = |location, scale, dof| Distribution::StudentT {
        location,
        scale,
        dof,
    };
    let curvilinear = |lower: f64, inexactness| Distribution::CurvilinearTrapezoid {
        lower,
        upper: -lower,
        inexactness,
    };
    let distributions = [
        ("l_s", t(50_000_623.0, 25.0, 18.0)),
        ("d", t(215.0, 5.8, 24.0)),
        ("d_1", t(0.0, 3.9, 5.0)),
        ("d_2", t(0.0, 6.7, 8.0)),
        (
            "alpha_s",
            Distribution::Rectangular {
                lower: 9.5e-6,
                upper: 13.5e-6,
            },
        ),
        ("theta_0", Distribution::Normal { mean: -0.1, u: 0.2 }),
        (
            "Delta",
            Distribution::Arcsine {
                lower: -0.5,
                upper: 0.5,
            },
        ),
        ("d_alpha", curvilinear(-1e-6, 0.1e-6)),
        ("d_theta", curvilinear(-0.05, 0.025)),
    ];
    distributions
        .into_iter()
        .fold(Inputs::new(), |inputs, (name, d)| {
            inputs.add(Input::new(name, "1", d))
        })
}

fn inverse() -> f64 {
    let x = black_box([4.0, 1.0, 0.5, 0.3, 5.0, 0.2, 0.1, 0.7, 6.0]);
    let (_, result) = propagate_independent(
        |[a, b, c, d, e, f, g, h, i]| {
            let (m0, m1, m2) = (e * i - f * h, f * g - d * i, d * h - e * g);
            let s = proofmass_uncertainty::Dual::from(1.0) / (a * m0 + b * m1 + c * m2);
            [
                m0 * s,
                (c * h - b * i) * s,
                (b * f - c * e) * s,
                m1 * s,
                (a * i - c * g) * s,
                (c * d - a * f) * s,
                m2 * s,
                (b * g - a * h) * s,
                (a * e - b * d) * s,
            ]
        },
        x,
        black_box([0.01; 9]),
    );
    black_box(result)[0][0]
}

/// The same with the derivative of an inverse, dB = −B dA B, put in by hand.
fn inverse_analytic() -> f64 {
    let [a, b, c, d, e, f, g, h, i] = black_box([4.0, 1.0, 0.5, 0.3, 5.0, 0.2, 0.1, 0.7, 6.0]);
    let (m0, m1, m2) = (e * i - f * h, f * g - d * i, d * h - e * g);
    let s: f64 = 1.0 / (a * m0 + b * m1 + c * m2);
    let inverse = [
        [m0 * s, (c * h - b * i) * s, (b * f - c * e) * s],
        [m1 * s, (a * i - c * g) * s, (c * d - a * f) * s],
        [m2 * s, (b * g - a * h) * s, (a * e - b * d) * s],
    ];
    let mut jacobian = [[0.0; 9]; 9];
    for (row, line) in jacobian.iter_mut().enumerate() {
        for (column, j) in line.iter_mut().enumerate() {
            *j = -inverse[row / 3][column / 3] * inverse[column % 3][row % 3];
        }
    }
    black_box(propagate_jacobian(&jacobian, &black_box([0.01; 9])))[0][0]
}

/// GUM H.2, from the readings.
struct Impedance;

impl Model for Impedance {
    fn outputs(&self) -> Vec<(String, String)> {
        ["R", "X", "Z"]
            .map(|name| (name.to_owned(), "Ω".to_owned()))
            .into()
    }
    fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
        let &[v, i, phi] = x else {
            return;
        };
        y[0] = v / i * phi.cos();
        y[1] = v / i * phi.sin();
        y[2] = v / i;
    }
}

/// GUM H.1 as a model file, with the same distributions.
const MODEL_FILE: &str = r#"
input = [
    { name = "l_s", unit = "1", distribution = { kind = "student-t", location = 50000623.0, scale = 25.0, dof = 18 } },
    { name = "d", unit = "1", distribution = { kind = "student-t", location = 215.0, scale = 5.8, dof = 24 } },
    { name = "d_1", unit = "1", distribution = { kind = "student-t", location = 0.0, scale = 3.9, dof = 5 } },
    { name = "d_2", unit = "1", distribution = { kind = "student-t", location = 0.0, scale = 6.7, dof = 8 } },
    { name = "alpha_s", unit = "1", distribution = { kind = "rectangular", lower = 9.5e-6, upper = 13.5e-6 } },
    { name = "theta_0", unit = "1", value = -0.1, u = 0.2 },
    { name = "Delta", unit = "1", distribution = { kind = "arcsine", lower = -0.5, upper = 0.5 } },
    { name = "d_alpha", unit = "1", distribution = { kind = "curvilinear-trapezoid", lower = -1e-6, upper = 1e-6, inexactness = 0.1e-6 } },
    { name = "d_theta", unit = "1", distribution = { kind = "curvilinear-trapezoid", lower = -0.05, upper = 0.05, inexactness = 0.025 } },
]
output = [
    { name = "length", unit = "1", expression = "l_s + d + d_1 + d_2 - l_s * (d_alpha * (theta_0 + Delta) + alpha_s * d_theta) - 50000000" },
]
"#;

fn readings() -> Result<Inputs, Box<dyn std::error::Error>> {
    Ok(Inputs::new().observed(&[
        ("V", "V", &[5.007, 4.994, 5.005, 4.990, 4.999]),
        (
            "I",
            "A",
            &[19.663e-3, 19.639e-3, 19.640e-3, 19.685e-3, 19.678e-3],
        ),
        ("phi", "rad", &[1.0456, 1.0438, 1.0468, 1.0428, 1.0433]),
    ])?)
}

/// GUM H.1 with the standard uncertainties and degrees of freedom of the document.
fn end_gauge_budget() -> Inputs {
    [
        ("l_s", 50_000_623.0, 25.0, 18.0),
        ("d", 215.0, 5.8, 24.0),
        ("d_1", 0.0, 3.9, 5.0),
        ("d_2", 0.0, 6.7, 8.0),
        ("alpha_s", 11.5e-6, 2e-6 / 3f64.sqrt(), f64::INFINITY),
        ("theta_0", -0.1, 0.2, f64::INFINITY),
        ("Delta", 0.0, 0.5 / 2f64.sqrt(), f64::INFINITY),
        ("d_alpha", 0.0, 1e-6 / 3f64.sqrt(), 50.0),
        ("d_theta", 0.0, 0.05 / 3f64.sqrt(), 2.0),
    ]
    .into_iter()
    .fold(Inputs::new(), |inputs, (name, mean, u, dof)| {
        let input = Input::new(name, "1", Distribution::Normal { mean, u });
        inputs.add(match DegreesOfFreedom::new(dof) {
            Some(dof) => input.dof(dof),
            None => input,
        })
    })
}

/// Seconds of one call, and its figure.
fn time(f: impl Fn() -> f64) -> (f64, f64) {
    let mut value = 0.0;
    let seconds = best(50, || {
        for _ in 0..1000 {
            value = f();
        }
    });
    (seconds / 1000.0, value)
}

fn trials(
    peers: &Peers,
    title: &str,
    model: &(impl Model + Sync),
    joint: &JointInputs,
) -> Result<(), Box<dyn std::error::Error>> {
    let run = MonteCarlo::new(1)
        .probability(0.99)
        .trials(Trials::Fixed(1_000_000));
    let (theirs, their_u) = peers.get("end_gauge")?;
    println!("{title}");
    println!(
        "  numpy      {:8.1} ms               u = {their_u:.3} nm",
        1e3 * theirs
    );
    for threads in [1, std::thread::available_parallelism()?.get()] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        let mut u = 0.0;
        let seconds = best(7, || {
            u = pool
                .install(|| run.run(model, joint))
                .map_or(f64::NAN, |r| {
                    r.outputs[0].standard_uncertainty.unwrap_or(f64::NAN)
                });
        });
        println!(
            "  {threads} thread{} {:8.1} ms   {:6.1} ×    u = {u:.3} nm",
            if threads == 1 { " " } else { "s" },
            1e3 * seconds,
            theirs / seconds
        );
    }
    Ok(())
}

fn compare(
    peers: &Peers,
    title: &str,
    names: &[(&str, &str)],
    ours: &[(&str, &dyn Fn() -> f64)],
) -> Result<(), Box<dyn std::error::Error>> {
    println!("{title}");
    let mut theirs = Vec::new();
    for (name, key) in names {
        let (seconds, value) = peers.get(key)?;
        println!("  {name:18} {:8.1} µs   {value:.10e}", 1e6 * seconds);
        theirs.push(seconds);
    }
    for (name, f) in ours {
        let (seconds, value) = time(f);
        let ratios: Vec<String> = theirs
            .iter()
            .map(|t| format!("{:.0} ×", t / seconds))
            .collect();
        println!(
            "  {name:18} {:8.3} µs   {value:.10e}   {}",
            1e6 * seconds,
            ratios.join(", ")
        );
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let peers = Peers::run("uncertainty_peer.py", &[])?;
    let joint = end_gauge().single()?;
    let (file_joint, file) = toml::from_str::<UncertaintyModel>(MODEL_FILE)?.prepared()?;
    trials(
        &peers,
        "GUM H.1, 10⁶ trials, interval at 99 %",
        &EndGauge,
        &joint,
    )?;
    trials(&peers, "the same from a model file", &file, &file_joint)?;
    let budget = end_gauge_budget().single()?;
    let impedance = readings()?.single()?;
    let u = |linear: Result<Linear, Error>| {
        linear.map_or(f64::NAN, |l| l.estimate().covariance()[(0, 0)])
    };
    compare(
        &peers,
        "inverse of a 3 × 3 matrix with its 9 × 9 covariance",
        &[("uncertainties", "inverse"), ("GTC", "inverse_gtc")],
        &[
            ("dual numbers", &inverse),
            ("analytic Jacobian", &inverse_analytic),
        ],
    )?;
    compare(
        &peers,
        "GUM H.1 by the law of propagation, with budget and ν",
        &[
            ("uncertainties", "gauge_uncertainties"),
            ("GTC", "gauge_gtc"),
        ],
        &[("proofmass", &|| u(propagate(&EndGauge, &budget)).sqrt())],
    )?;
    compare(
        &peers,
        "GUM H.2 by the law of propagation, with budget and ν",
        &[
            ("uncertainties", "impedance_uncertainties"),
            ("GTC", "impedance_gtc"),
        ],
        &[("proofmass", &|| u(propagate(&Impedance, &impedance)))],
    )
}
