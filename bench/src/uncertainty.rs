//! The uncertainty crate beside numpy and the Python package `uncertainties`, run in the same minute.
//!
//! The Python interpreter is taken from the variable PROOFMASS_BENCH_PYTHON, else `python3`; it needs numpy and
//! uncertainties. Peers run alone, on the same machine, before ours; each figure is the best of several runs.
//! One thread is what numpy uses; the second column uses every core the peer leaves idle.

mod peer;

use peer::{Peers, best};
use proofmass_uncertainty::{
    Distribution, Input, Inputs, Model, MonteCarlo, Number, Trials, propagate_independent,
    propagate_jacobian,
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

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let peers = Peers::run("uncertainty_peer.py")?;
    let joint = end_gauge().single()?;
    let run = MonteCarlo::new(1)
        .probability(0.99)
        .trials(Trials::Fixed(1_000_000));
    let mut u = 0.0;
    let mut seconds = Vec::new();
    for threads in [1, std::thread::available_parallelism()?.get()] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        seconds.push(best(5, || {
            u = pool
                .install(|| run.run(&EndGauge, &joint))
                .map_or(f64::NAN, |r| {
                    r.outputs[0].standard_uncertainty.unwrap_or(f64::NAN)
                });
        }));
    }
    let (theirs, their_u) = peers.get("end_gauge")?;
    println!("GUM H.1, 10⁶ trials, interval at 99 %");
    println!(
        "  numpy      {:8.1} ms               u = {their_u:.3} nm",
        1e3 * theirs
    );
    println!(
        "  1 thread   {:8.1} ms   {:6.1} ×    u = {u:.3} nm",
        1e3 * seconds[0],
        theirs / seconds[0]
    );
    println!(
        "  all cores  {:8.1} ms   {:6.1} ×",
        1e3 * seconds[1],
        theirs / seconds[1]
    );

    let time = |f: fn() -> f64| {
        let mut value = 0.0;
        let seconds = best(50, || {
            for _ in 0..1000 {
                value = f();
            }
        });
        (seconds / 1000.0, value)
    };
    let (theirs, their_value) = peers.get("inverse")?;
    println!("inverse of a 3 × 3 matrix with its 9 × 9 covariance");
    println!(
        "  uncertainties      {:8.1} µs            u² = {their_value:.10e}",
        1e6 * theirs
    );
    for (name, f) in [
        ("dual numbers", inverse as fn() -> f64),
        ("analytic Jacobian", inverse_analytic),
    ] {
        let (ours, value) = time(f);
        println!(
            "  {name:18} {:8.3} µs  {:6.0} ×  u² = {value:.10e}",
            1e6 * ours,
            theirs / ours
        );
    }
    Ok(())
}
