//! Worked examples that several tests share.
#![allow(dead_code)]

use proofmass_uncertainty::*;

pub fn dof(nu: f64) -> DegreesOfFreedom {
    DegreesOfFreedom::new(nu).unwrap()
}

pub fn normal(name: &str, mean: f64, u: f64) -> Input {
    Input::new(name, "1", Distribution::Normal { mean, u })
}

/// One named output from a function; the function is generic, so it is a macro.
#[macro_export]
macro_rules! model {
    ($type:ident, [$($name:literal $unit:literal),+], |$x:ident, $y:ident, $T:ident| $body:block) => {
        /// A worked example.
        pub struct $type;
        impl Model for $type {
            fn outputs(&self) -> Vec<(String, String)> {
                vec![$(($name.into(), $unit.into())),+]
            }
            fn evaluate<$T: Number>(&self, $x: &[$T], $y: &mut [$T]) $body
        }
    };
}

/// `[GUM] H.1`, δL in nm; lengths in nm, θ in °C.
pub struct EndGauge;

impl Model for EndGauge {
    fn outputs(&self) -> Vec<(String, String)> {
        vec![("length".into(), "nm".into())]
    }
    fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
        let [l_s, d, d1, d2, alpha_s, theta_0, delta, d_alpha, d_theta] =
            x[..9].try_into().unwrap();
        y[0] = l_s + d + d1 + d2
            - l_s * (d_alpha * (theta_0 + delta) + alpha_s * d_theta)
            - T::from(50_000_000.0);
    }
}

fn t(name: &str, location: f64, scale: f64, dof: f64) -> Input {
    Input::new(
        name,
        "nm",
        Distribution::StudentT {
            location,
            scale,
            dof,
        },
    )
}

/// Inputs as `[S1] 9.5.2`, table 10, with the degrees of freedom of `[GUM] H.1`.
pub fn end_gauge() -> Inputs {
    let curvilinear = |lower: f64, upper: f64, inexactness| Distribution::CurvilinearTrapezoid {
        lower,
        upper,
        inexactness,
    };
    Inputs::new()
        .add(t("l_s", 50_000_623.0, 25.0, 18.0))
        .add(t("d", 215.0, 5.8, 24.0))
        .add(t("d_1", 0.0, 3.9, 5.0))
        .add(t("d_2", 0.0, 6.7, 8.0))
        .add(Input::new(
            "alpha_s",
            "1/°C",
            Distribution::Rectangular {
                lower: 9.5e-6,
                upper: 13.5e-6,
            },
        ))
        .add(Input::new(
            "theta_0",
            "°C",
            Distribution::Normal { mean: -0.1, u: 0.2 },
        ))
        .add(Input::new(
            "Delta",
            "°C",
            Distribution::Arcsine {
                lower: -0.5,
                upper: 0.5,
            },
        ))
        .add(Input::new("d_alpha", "1/°C", curvilinear(-1e-6, 1e-6, 0.1e-6)).dof(dof(50.0)))
        .add(Input::new("d_theta", "°C", curvilinear(-0.05, 0.05, 0.025)).dof(dof(2.0)))
}

/// Five simultaneous readings of `[GUM] H.2`, table H.2, SI.
pub fn impedance() -> Inputs {
    Inputs::new()
        .observed(&[
            ("V", "V", &[5.007, 4.994, 5.005, 4.990, 4.999]),
            (
                "I",
                "A",
                &[19.663e-3, 19.639e-3, 19.640e-3, 19.685e-3, 19.678e-3],
            ),
            ("phi", "rad", &[1.0456, 1.0438, 1.0468, 1.0428, 1.0433]),
        ])
        .unwrap()
}

model!(Impedance, ["R" "Ω", "X" "Ω", "Z" "Ω"], |x, y, T| {
    let z = x[0] / x[1];
    y[0] = z * x[2].cos();
    y[1] = z * x[2].sin();
    y[2] = z;
});
