//! The worked examples of the GUM, its supplements and the complex Welch–Satterthwaite paper, a row per case;
//! tolerances are half a unit of the last printed digit, or say why not.
use crate::common::*;
use proofmass_uncertainty::*;

struct Row {
    case: &'static str,
    got: f64,
    expected: f64,
    tolerance: f64,
}

fn row(case: &'static str, got: f64, expected: f64, tolerance: f64) -> Row {
    Row {
        case,
        got,
        expected,
        tolerance,
    }
}

fn check(rows: Vec<Row>) {
    let wrong: Vec<String> = rows
        .iter()
        .filter(|r| !((r.got - r.expected).abs() <= r.tolerance))
        .map(|r| format!("{}: {} but {} ± {}", r.case, r.got, r.expected, r.tolerance))
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn published_gum_h1_end_gauge() {
    // The GUM takes u(δα) = 0.58e-6 and u(δθ) = 0.029 without the doubt about the limits, which it puts into ν.
    let mut inputs = Inputs::new();
    for input in end_gauge().inputs() {
        inputs = inputs.add(match input.name() {
            "d_alpha" => Input::new(
                "d_alpha",
                "1/°C",
                Distribution::Rectangular {
                    lower: -1e-6,
                    upper: 1e-6,
                },
            )
            .dof(dof(50.0)),
            "d_theta" => Input::new(
                "d_theta",
                "°C",
                Distribution::Rectangular {
                    lower: -0.05,
                    upper: 0.05,
                },
            )
            .dof(dof(2.0)),
            _ => input.clone(),
        });
    }
    let linear = propagate(&EndGauge, &inputs.single().unwrap()).unwrap();
    let length = linear.get("length").unwrap();
    check(vec![
        row("l", length.value, 838.0, 0.5),
        row("u", length.standard_uncertainty, 31.664, 0.05), // the GUM rounds each contribution first
        row("ν", length.dof.get(), 16.75, 0.1),              // likewise
        row("U99", length.dof.coverage_factor(0.99), 2.92, 0.02),
    ]);
    // `[GUM]` H.1.7: terms of second order bring u from 32 to 34 nm.
    let second = propagate_second_order(&EndGauge, &inputs.single().unwrap()).unwrap();
    check(vec![row(
        "u second order",
        second.second_order()[0].unwrap().standard_uncertainty,
        34.0,
        0.5,
    )]);
}

#[test]
fn published_gum_h2_impedance() {
    let joint = impedance().single().unwrap();
    let linear = propagate(&Impedance, &joint).unwrap();
    let e = linear.estimate();
    let q = |name| linear.get(name).unwrap();
    let r = |i, j| e.covariance().correlation(i, j).unwrap();
    let x = |i, j| joint.covariance().correlation(i, j).unwrap();
    check(vec![
        row("r(V,I)", x(0, 1), -0.36, 0.005),
        row("r(V,φ)", x(0, 2), 0.86, 0.005),
        row("r(I,φ)", x(1, 2), -0.65, 0.005),
        row("R", q("R").value, 127.732, 0.0005),
        row("u(R)", q("R").standard_uncertainty, 0.071, 0.0005),
        row("X", q("X").value, 219.847, 0.0005),
        row("u(X)", q("X").standard_uncertainty, 0.295, 0.0006), // 0.29558 is printed as 0.295
        row("Z", q("Z").value, 254.260, 0.0005),
        row("u(Z)", q("Z").standard_uncertainty, 0.236, 0.0005),
        row("r(R,X)", r(0, 1), -0.588, 0.0005),
        row("r(R,Z)", r(0, 2), -0.485, 0.0005),
        row("r(X,Z)", r(1, 2), 0.993, 0.0005),
        row("ν(R)", q("R").dof.get(), 4.0, 1e-9),
        row("ν(X)", q("X").dof.get(), 4.0, 1e-9),
        row("ν(R) by estimate", e.get("R").unwrap().dof.get(), 4.0, 1e-9),
    ]);
    assert_eq!(q("R").to_string(), "127.732(71) Ω");
}

/// `[GUM] H.3`: a straight line through eleven thermometer corrections, b = y₁ + y₂ (t − 20 °C).
struct Thermometer;

const T: [f64; 11] = [
    21.521, 22.012, 22.512, 23.003, 23.507, 23.999, 24.513, 25.002, 25.503, 26.010, 26.511,
];
const B: [f64; 11] = [
    -0.171, -0.169, -0.166, -0.159, -0.164, -0.165, -0.156, -0.157, -0.159, -0.161, -0.160,
];

impl LeastSquares for Thermometer {
    fn outputs(&self) -> Vec<(String, String)> {
        vec![
            ("intercept".into(), "°C".into()),
            ("slope".into(), "1".into()),
        ]
    }
    fn residuals(&self) -> usize {
        11
    }
    fn residual<N: Number>(&self, y: &[N], x: &[N], r: &mut [N]) {
        for i in 0..11 {
            r[i] = N::from(B[i]) + x[i] - y[0] - y[1] * N::from(T[i] - 20.0);
        }
    }
}

#[test]
fn published_gum_h3_thermometer() {
    let scatter = |u| {
        let readings: Vec<Labels> = (0..11).map(|i| Labels::new().with("reading", i)).collect();
        let d = Distribution::StudentT {
            location: 0.0,
            scale: u,
            dof: 9.0,
        };
        Inputs::new()
            .add(Input::new("scatter", "°C", d).varies_with(["reading"]))
            .joint(&readings)
            .unwrap()
    };
    let first = propagate_least_squares(&Thermometer, &[0.0, 0.0], &scatter(1.0)).unwrap();
    let (y1, y2) = (
        first.get("intercept").unwrap().value,
        first.get("slope").unwrap().value,
    );
    let squares: f64 = (0..11)
        .map(|i| (B[i] - y1 - y2 * (T[i] - 20.0)).powi(2))
        .sum();
    let s = (squares / 9.0).sqrt();
    let fit = propagate_least_squares(&Thermometer, &[0.0, 0.0], &scatter(s)).unwrap();
    let at_30 = fit
        .estimate()
        .propagate(
            vec![Component::new("b(30)", "°C", y1 + 10.0 * y2)],
            &[1.0, 10.0],
        )
        .unwrap();
    let u = |name: &str| fit.get(name).unwrap().standard_uncertainty;
    check(vec![
        row("intercept", y1, -0.1712, 0.00005),
        row("u(intercept)", u("intercept"), 0.0029, 0.00005),
        row("slope", y2, 0.00218, 0.000005),
        row("u(slope)", u("slope"), 0.00067, 0.000005),
        row(
            "r",
            fit.estimate().covariance().correlation(0, 1).unwrap(),
            -0.930,
            0.0005,
        ),
        row("s", s, 0.0035, 0.00005),
        row("b(30)", at_30.get("b(30)").unwrap().value, -0.1494, 0.00005),
        row(
            "u(b(30))",
            at_30.get("b(30)").unwrap().standard_uncertainty,
            0.0041,
            0.00005,
        ),
        row("ν", at_30.get("b(30)").unwrap().dof.get(), 9.0, 1e-9),
        row(
            "ν of the fit",
            fit.get("slope").unwrap().dof.get(),
            9.0,
            1e-9,
        ),
    ]);
}

#[test]
fn published_gum_g41_welch_satterthwaite() {
    let contributions = [(0.25, dof(9.0)), (0.57, dof(4.0)), (0.82, dof(14.0))];
    let u = contributions.iter().map(|(u, _)| u * u).sum::<f64>().sqrt();
    check(vec![
        row("u", u, 1.03, 0.005),
        row("ν", welch_satterthwaite(&contributions).get(), 19.0, 0.05),
    ]);
}

model!(Sum, ["y" "1"], |x, y, T| {
    y[0] = x[0] + x[1] + x[2] + x[3];
});

fn additive(distribution: impl Fn(usize) -> Distribution) -> SampledOutput {
    let mut inputs = Inputs::new();
    for i in 0..4 {
        inputs = inputs.add(Input::new(format!("x_{i}"), "1", distribution(i)));
    }
    let run = MonteCarlo::new(9).trials(Trials::Fixed(1_000_000));
    run.run(&Sum, &inputs.single().unwrap())
        .unwrap()
        .outputs
        .remove(0)
}

/// The standard error of a quantile end, √(p(1−p)/M)/f, is 0.004 u at 2.5 % and M = 10⁶; of u, u/√(2M).
#[test]
fn published_s1_92_additive() {
    let normal = additive(|_| Distribution::Normal { mean: 0.0, u: 1.0 });
    let a = 3f64.sqrt();
    let flat = additive(|_| Distribution::Rectangular {
        lower: -a,
        upper: a,
    });
    let dominated = additive(|i| {
        let a = if i == 3 { 10.0 * a } else { a };
        Distribution::Rectangular {
            lower: -a,
            upper: a,
        }
    });
    check(vec![
        row(
            "normal u",
            normal.standard_uncertainty.unwrap(),
            2.00,
            0.008,
        ),
        row("normal lower", normal.symmetric.lower, -3.92, 0.025),
        row("normal upper", normal.symmetric.upper, 3.92, 0.025),
        row("normal shortest", normal.shortest.width(), 7.84, 0.05),
        row("flat u", flat.standard_uncertainty.unwrap(), 2.00, 0.008),
        row("flat upper", flat.symmetric.upper, 3.88, 0.025),
        row("flat lower", flat.symmetric.lower, -3.88, 0.025),
        row(
            "dominated u",
            dominated.standard_uncertainty.unwrap(),
            10.15,
            0.025,
        ),
        row("dominated upper", dominated.symmetric.upper, 17.0, 0.06),
        row("dominated lower", dominated.symmetric.lower, -17.0, 0.06),
    ]);
}

model!(Mass, ["m" "mg"], |x, y, T| {
    let one = T::from(1.0);
    let buoyancy = one + (x[2] - T::from(1.2)) * (one / x[3] - one / x[4]);
    y[0] = (x[0] + x[1]) * buoyancy - T::from(100_000.0);
});

#[test]
fn published_s1_93_mass() {
    let flat = |name: &str, lower, upper| {
        Input::new(name, "kg/m³", Distribution::Rectangular { lower, upper })
    };
    let joint = Inputs::new()
        .add(normal("m_R", 100_000.0, 0.050))
        .add(normal("dm_R", 1.234, 0.020))
        .add(flat("rho_a", 1.10, 1.30))
        .add(flat("rho_W", 7_000.0, 9_000.0))
        .add(flat("rho_R", 7_950.0, 8_050.0))
        .single()
        .unwrap();
    let run = MonteCarlo::new(3).trials(Trials::Fixed(1_000_000));
    let sampled = run.run(&Mass, &joint).unwrap();
    let m = sampled.get("m").unwrap();
    let linear = propagate_second_order(&Mass, &joint).unwrap();
    check(vec![
        row("mean", m.mean, 1.2340, 0.0003), // four standard errors u/√M
        row("u", m.standard_uncertainty.unwrap(), 0.0754, 0.0003),
        row("lower", m.shortest.lower, 1.084, 0.004), // the shortest interval is flat about its minimum
        row("upper", m.shortest.upper, 1.383, 0.004),
        row(
            "GUM first order u",
            linear.get("m").unwrap().standard_uncertainty,
            0.0539,
            0.00005,
        ),
        row(
            "GUM second order u",
            linear.second_order()[0].unwrap().standard_uncertainty,
            0.0750,
            0.00005,
        ),
    ]);
    assert_eq!(
        sampled.validate(&linear, 1)[0].verdict,
        Verdict::NotValidated
    );
    // The terms of second order say the same by the same rule.
    let second = linear.second_order()[0].unwrap();
    assert!(!second.agrees(&linear.get("m").unwrap(), 0.95, 1));
}

model!(Squares, ["y" "1"], |x, y, T| {
    y[0] = x[0] * x[0] + x[1] * x[1];
});

#[test]
fn published_s1_94_comparison_loss() {
    // x₁, r, mean and u in 10⁻⁶ (`[S1]` tables 6 to 8)
    for (x1, r, mean, u) in [
        (0.0, 0.0, 50.0, 50.0),
        (0.010, 0.0, 150.0, 112.0),
        (0.050, 0.0, 2550.0, 502.5),
        (0.0, 0.9, 50.0, 67.0),
        (0.010, 0.9, 150.0, 121.0),
        (0.050, 0.9, 2550.0, 504.5),
    ] {
        let mut inputs = Inputs::new()
            .add(normal("x_1", x1, 0.005))
            .add(normal("x_2", 0.0, 0.005));
        if r != 0.0 {
            inputs = inputs.correlate("x_1", "x_2", r);
        }
        let joint = inputs.single().unwrap();
        let sampled = MonteCarlo::new(4)
            .trials(Trials::Fixed(1_000_000))
            .run(&Squares, &joint)
            .unwrap();
        let linear = propagate_second_order(&Squares, &joint).unwrap();
        let second = linear.second_order()[0].unwrap();
        check(vec![
            row(
                "mean",
                1e6 * sampled.outputs[0].mean,
                mean,
                4.0 * u / 1e3 + 0.5,
            ),
            row(
                "u",
                1e6 * sampled.outputs[0].standard_uncertainty.unwrap(),
                u,
                0.9,
            ),
            row(
                "mean, second order",
                1e6 * (linear.get("y").unwrap().value + second.shift),
                mean,
                0.5,
            ),
            row("u, second order", 1e6 * second.standard_uncertainty, u, 0.5),
        ]);
    }
}

#[test]
fn published_s1_95_gauge_block() {
    // `[S1]` table 10 differs from the GUM in u(d̄) = 6, u(d₁) = 4, u(d₂) = 7 nm.
    let t = |name: &str, location, scale, dof| {
        Input::new(
            name,
            "nm",
            Distribution::StudentT {
                location,
                scale,
                dof,
            },
        )
    };
    let mut inputs = Inputs::new();
    for input in end_gauge().inputs() {
        inputs = inputs.add(match input.name() {
            "d" => t("d", 215.0, 6.0, 24.0),
            "d_1" => t("d_1", 0.0, 4.0, 5.0),
            "d_2" => t("d_2", 0.0, 7.0, 8.0),
            _ => input.clone(),
        });
    }
    let run = MonteCarlo::new(5)
        .probability(0.99)
        .trials(Trials::Fixed(1_000_000));
    let sampled = run.run(&EndGauge, &inputs.single().unwrap()).unwrap();
    let l = sampled.get("length").unwrap();
    check(vec![
        row("mean", l.mean, 838.0, 0.5),
        row("u", l.standard_uncertainty.unwrap(), 36.0, 0.5),
        row("lower", l.shortest.lower, 745.0, 2.0), // the published run used 1.3e6 trials; ends repeat to 1–2 nm
        row("upper", l.shortest.upper, 932.0, 2.0),
    ]);
}

#[test]
fn published_complex_welch_satterthwaite() {
    let s11 = [
        (0.0242, -0.0101),
        (-0.0023, 0.2229),
        (0.0599, 0.0601),
        (0.0433, 0.2100),
        (-0.0026, 0.0627),
    ];
    let g = [
        (0.1648, -0.0250),
        (0.1568, -0.0179),
        (0.1598, -0.1367),
        (0.1198, -0.0045),
        (0.3162, -0.1310),
    ];
    let parts = |z: [(f64, f64); 5]| (z.map(|z| z.0), z.map(|z| z.1));
    let ((g_re, g_im), (s_re, s_im)) = (parts(g), parts(s11));
    model!(Difference, ["G.re" "1", "G.im" "1"], |x, y, T| {
        y[0] = x[0] - x[2];
        y[1] = x[1] - x[3];
    });
    let joint = Inputs::new()
        .observed(&[("g.re", "1", &g_re), ("g.im", "1", &g_im)])
        .unwrap()
        .observed(&[("s.re", "1", &s_re), ("s.im", "1", &s_im)])
        .unwrap()
        .single()
        .unwrap();
    let linear = propagate(&Difference, &joint).unwrap();
    let contributions: Vec<_> = linear
        .estimate()
        .influences()
        .iter()
        .map(|i| (i.effect.covariance(2).unwrap(), i.dof))
        .collect();
    check(vec![
        row("re", linear.get("G.re").unwrap().value, 0.15898, 0.000005),
        row("im", linear.get("G.im").unwrap().value, -0.17214, 0.000005),
        row(
            "ν",
            willink_hall(&contributions).unwrap().get(),
            6.85,
            0.005,
        ),
    ]);
}

#[test]
fn published_matrix_inverse() {
    let mut covariance = [[0.0; 4]; 4];
    for (i, u) in [0.1f64, 0.2, 0.3, 0.4].into_iter().enumerate() {
        covariance[i][i] = u * u;
    }
    let (y, c) = propagate_fixed(
        |[a, b, c, d]| {
            let determinant = a * d - b * c;
            [
                d / determinant,
                -b / determinant,
                -c / determinant,
                a / determinant,
            ]
        },
        [1.0, 2.0, 3.0, 4.0],
        covariance,
    );
    let expected = [
        (-2.0, 1.11355),
        (1.0, 0.45826),
        (1.5, 0.68739),
        (-0.5, 0.27839),
    ];
    for (k, (value, u)) in expected.into_iter().enumerate() {
        check(vec![
            row("element", y[k], value, 1e-12),
            row("u", c[k][k].sqrt(), u, 0.000005),
        ]);
    }
}
