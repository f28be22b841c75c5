//! A calibration with its rotation, a low-pass and a decimation as one step: the exported constants and the header against the desk.

use proofmass_core::{
    Butterworth, Compensation, Decimator, DecimatorState, FirDecimator, FirDecimatorState,
    SensorModel, TaitBryan,
};
use proofmass_documents::{
    ExportForm, ExportNumber, ExportOptions, FirmwareBlock, LowPassBehind, export_chain,
};
use proofmass_example_c::{chain, chained, raised_cosine};
use std::process::Command;

/// The exported text, as firmware has it.
#[rustfmt::skip]
#[allow(clippy::all, clippy::pedantic)]
mod exported {
    pub mod chain;
}

/// Outputs of a sensor that moves.
fn output(i: u32) -> [f64; 3] {
    let wave = |k: f64, size: f64| size * (k * f64::from(i)).sin();
    [
        33_120.0 + wave(0.02, 900.0).round(),
        33_271.0 + wave(0.5, 400.0).round(),
        36_400.0 + wave(0.11, 300.0).round(),
    ]
}

const SAMPLES: u32 = 5000;

fn options(number: ExportNumber) -> ExportOptions {
    let mut options = ExportOptions::default();
    options.name = Some("chain".to_owned());
    options.number = number;
    options
}

fn butterworth() -> Butterworth<f64> {
    match chain().low_pass {
        FirmwareBlock::LowPass { corner, rate } => Butterworth::new(corner, rate).unwrap(),
        other => panic!("{other:?}"),
    }
}

/// What the desk gives: the matrix with the rotation in it, then the low-pass and the decimation of `core`.
fn desk() -> Vec<[f64; 3]> {
    let file = chained().unwrap();
    let model = file.compensation().unwrap();
    let model = *model.three_axes().unwrap();
    let low_pass = butterworth();
    let decimator = Decimator::<f64, 3>::new(low_pass, chain().factor).unwrap();
    let mut state = None;
    (0..SAMPLES)
        .filter_map(|i| {
            let a = model.apply(output(i), 0.0);
            decimator.step(state.get_or_insert(DecimatorState::at(a, 0)), a)
        })
        .collect()
}

/// Rounding of the compensation, 16 ε of the largest number in its sums, and of a step of the low-pass, 20 ε of its largest number; both
/// times the sum of all that a step leaves behind in the recursion, below √2/(1 − |p|) of the poles p.
fn bound(epsilon: f64) -> f64 {
    let file = chained().unwrap();
    let model = file.compensation().unwrap();
    let inverse = model.three_axes().unwrap().sensor().k_inverse().norm();
    let low_pass = butterworth();
    let radius = low_pass.denominator[1].sqrt();
    let largest = 60_000.0 * 2.0;
    let memory = std::f64::consts::SQRT_2 / (1.0 - radius);
    (16.0 * epsilon * largest * inverse + 20.0 * epsilon * 12.0) * memory
}

#[test]
fn law_the_constants_step_as_the_desk_does() {
    assert_eq!(exported::chain::calibration::self_check(), None);
    assert_eq!(exported::chain::low_pass::self_check(), None);
    let mut state = None;
    let got: Vec<[f64; 3]> = (0..SAMPLES)
        .filter_map(|i| exported::chain::step(&mut state, output(i)))
        .collect();
    let desk = desk();
    assert_eq!(got.len(), desk.len());
    for (a, b) in got.iter().zip(&desk) {
        assert_eq!(a, b);
    }
}

/// What stands in `tests/exported` is what is exported now, but for heading and results.
#[test]
fn law_the_compiled_text_is_the_exported_one() {
    let text = export_chain(
        &chained().unwrap(),
        &chain(),
        ExportForm::Rust,
        &options(ExportNumber::Double),
    )
    .unwrap();
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/exported/chain.rs");
    let kept = std::fs::read_to_string(path).unwrap();
    let body = |text: &str| -> String {
        let told = |l: &&str| !l.starts_with("//!") && !l.contains("EXPECTED");
        let lines = text.lines().filter(told);
        lines.map(|l| format!("{l}\n")).collect()
    };
    assert_eq!(body(&text), body(&kept), "run the example `exported`");
}

/// The rotation within the matrix is that behind it.
#[test]
fn law_the_matrix_holds_the_rotation() {
    let own = proofmass_example_c::calibration(false, false).unwrap();
    let own = *own.compensation().unwrap().three_axes().unwrap();
    let turned = chained().unwrap();
    let turned = *turned.compensation().unwrap().three_axes().unwrap();
    let turn = TaitBryan::new(0.1, -0.5, 2.0).unwrap().matrix();
    let kept: &SensorModel<f64> = own.sensor();
    let bound = 32.0 * f64::EPSILON * 120_000.0 * kept.k_inverse().norm();
    for i in 0..500 {
        let of = |m: &Compensation<f64>| m.apply(output(i), 0.0);
        let (one, two) = (of(&turned), turn.times(of(&own)));
        for axis in 0..3 {
            assert!((one[axis] - two[axis]).abs() < bound);
        }
    }
}

/// One header in one program, in both precisions: as many results as the desk, within the derived bound.
#[test]
#[cfg_attr(not(c_compiler), ignore = "needs a C compiler called cc")]
fn crosscheck_the_header_against_the_desk() {
    let folder = tempfile::tempdir().unwrap();
    let desk = desk();
    for (real, number, epsilon) in [
        ("float", ExportNumber::Float, f64::from(f32::EPSILON)),
        ("double", ExportNumber::Double, f64::EPSILON),
    ] {
        let header = export_chain(
            &chained().unwrap(),
            &chain(),
            ExportForm::C,
            &options(number),
        )
        .unwrap();
        std::fs::write(folder.path().join("chain.h"), &header).unwrap();
        let list: Vec<String> = (0..SAMPLES)
            .map(|i| output(i).map(|v| format!("{v}")).join(","))
            .map(|row| format!("{{{row}}}"))
            .collect();
        let main = format!(
            "#include <stdio.h>\n#include \"chain.h\"\nstatic const {real} samples[][3] = {{{}}};\nint main(void)\n{{\n    \
             chain_chain_state state;\n    {real} a[3];\n    int i;\n    \
             if (chain_self_check() || chain_low_pass_self_check())\n        return 1;\n    chain_chain_init(&state);\n    \
             for (i = 0; i < {SAMPLES}; i++)\n        if (chain_chain_step(&state, samples[i], a))\n            \
             printf(\"%.17g %.17g %.17g\\n\", (double)a[0], (double)a[1], (double)a[2]);\n    return 0;\n}}\n",
            list.join(",")
        );
        std::fs::write(folder.path().join("main.c"), main).unwrap();
        let program = folder.path().join(real);
        let out = Command::new("cc")
            .args([
                "-std=c99",
                "-O2",
                "-Wall",
                "-Wextra",
                "-pedantic",
                "-Werror",
            ])
            .arg(folder.path().join("main.c"))
            .arg("-o")
            .arg(&program)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.success(), "{said}\n{header}");
        let out = Command::new(&program).output().unwrap();
        assert!(out.status.success(), "the self-check fails");
        let text = String::from_utf8(out.stdout).unwrap();
        assert_eq!(text.lines().count(), desk.len());
        let mut worst = 0.0f64;
        for (line, a) in text.lines().zip(&desk) {
            for (got, a) in line.split(' ').zip(a) {
                worst = worst.max((got.parse::<f64>().unwrap() - a).abs());
            }
        }
        assert!(
            worst <= bound(epsilon),
            "{real}: {worst} {}",
            bound(epsilon)
        );
    }
}

/// With a low-pass of linear phase behind it: the header gives as many results as the desk, the first when the response is full, in double
/// precision within the roundings of its sum.
#[test]
#[cfg_attr(not(c_compiler), ignore = "needs a C compiler called cc")]
fn crosscheck_the_header_of_linear_phase_against_the_desk() {
    let taps: [f64; 17] = raised_cosine().try_into().unwrap();
    let behind = LowPassBehind {
        low_pass: FirmwareBlock::LinearPhase {
            taps: taps.to_vec(),
            corner: 20.0,
            ripple: 0.1,
            stop: 125.0,
            stop_gain: 3e-3,
            rate: 1000.0,
        },
        factor: 5,
    };
    let file = chained().unwrap();
    let model = *file.compensation().unwrap().three_axes().unwrap();
    let filter = FirDecimator::<f64, 3, 17>::new(taps, 5).unwrap();
    let mut state = FirDecimatorState::new();
    let desk: Vec<[f64; 3]> = (0..SAMPLES)
        .filter_map(|i| filter.step(&mut state, model.apply(output(i), 0.0)))
        .collect();
    assert_eq!(desk.len(), (SAMPLES as usize - 16).div_ceil(5));
    let rust = export_chain(
        &file,
        &behind,
        ExportForm::Rust,
        &options(ExportNumber::Double),
    )
    .unwrap();
    assert!(
        rust.contains(
            "FirDecimator<f64, 3, 17> = FirDecimator::constant(low_pass::CHAIN_LOW_PASS_TAPS, 5)"
        ),
        "{rust}"
    );
    let folder = tempfile::tempdir().unwrap();
    let header = export_chain(
        &file,
        &behind,
        ExportForm::C,
        &options(ExportNumber::Double),
    )
    .unwrap();
    std::fs::write(folder.path().join("chain.h"), &header).unwrap();
    let list: Vec<String> = (0..SAMPLES)
        .map(|i| format!("{{{}}}", output(i).map(|v| format!("{v}")).join(",")))
        .collect();
    let main = format!(
        "#include <stdio.h>\n#include \"chain.h\"\nstatic const double samples[][3] = {{{}}};\nint main(void)\n{{\n    \
         chain_chain_state state;\n    double a[3];\n    int i;\n    \
         if (chain_self_check() || chain_low_pass_self_check())\n        return 1;\n    chain_chain_init(&state);\n    \
         for (i = 0; i < {SAMPLES}; i++)\n        if (chain_chain_step(&state, samples[i], a))\n            \
         printf(\"%.17g %.17g %.17g\\n\", a[0], a[1], a[2]);\n    return 0;\n}}\n",
        list.join(",")
    );
    std::fs::write(folder.path().join("main.c"), main).unwrap();
    let program = folder.path().join("main");
    let out = Command::new("cc")
        .args([
            "-std=c99",
            "-O2",
            "-Wall",
            "-Wextra",
            "-pedantic",
            "-Werror",
        ])
        .arg(folder.path().join("main.c"))
        .arg("-o")
        .arg(&program)
        .output()
        .unwrap();
    assert!(
        out.status.success(),
        "{}",
        String::from_utf8_lossy(&out.stderr)
    );
    let out = Command::new(&program).output().unwrap();
    assert!(out.status.success(), "the self-check fails");
    let text = String::from_utf8(out.stdout).unwrap();
    assert_eq!(text.lines().count(), desk.len());
    for (line, a) in text.lines().zip(&desk) {
        for (got, a) in line.split(' ').zip(a) {
            let off = (got.parse::<f64>().unwrap() - a).abs();
            assert!(off <= bound(f64::EPSILON), "{off}");
        }
    }
}

/// One axis and temperatures: the text is one that a compiler takes, and a step without a temperature in range gives nothing.
#[test]
#[cfg_attr(not(c_compiler), ignore = "needs a C compiler called cc")]
fn law_every_kind_of_calibration_is_written_with_its_chain() {
    let folder = tempfile::tempdir().unwrap();
    for (k, file) in [
        proofmass_example_c::calibration(true, false).unwrap(),
        proofmass_example_c::calibration(true, true).unwrap(),
    ]
    .into_iter()
    .enumerate()
    {
        let header = export_chain(
            &file,
            &chain(),
            ExportForm::C,
            &options(ExportNumber::Float),
        )
        .unwrap();
        std::fs::write(folder.path().join("chain.h"), &header).unwrap();
        let main = "#include \"chain.h\"\nint main(void)\n{\n    chain_chain_state state;\n    \
                    const float o[3] = {33120.0f, 33271.0f, 36400.0f};\n    float a[3] = {0};\n    \
                    chain_chain_init(&state);\n    if (chain_chain_step(&state, o, 200.0f, a))\n        return 1;\n    \
                    return chain_chain_step(&state, o, 20.0f, a) == 1 && a[2] > 5.0f ? 0 : 2;\n}\n";
        std::fs::write(folder.path().join("main.c"), main).unwrap();
        let program = folder.path().join(format!("main{k}"));
        let out = Command::new("cc")
            .args(["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror"])
            .arg(folder.path().join("main.c"))
            .arg("-o")
            .arg(&program)
            .output()
            .unwrap();
        assert!(
            out.status.success(),
            "{}",
            String::from_utf8_lossy(&out.stderr)
        );
        assert_eq!(Command::new(&program).status().unwrap().code(), Some(0));
    }
}

#[test]
fn refuses_forms_without_a_filter() {
    for form in [ExportForm::Python, ExportForm::ImuYaml] {
        let refused = export_chain(
            &chained().unwrap(),
            &chain(),
            form,
            &options(ExportNumber::Float),
        );
        assert!(refused.unwrap_err().to_string().contains("C, Rust or JSON"));
    }
    let mut none = chain();
    none.factor = 0;
    let refused = export_chain(
        &chained().unwrap(),
        &none,
        ExportForm::C,
        &options(ExportNumber::Float),
    );
    assert!(refused.unwrap_err().to_string().contains("factor is 0"));
    let curved = proofmass_example_c::calibration(false, true).unwrap();
    let turn = TaitBryan::new(0.1, 0.0, 0.0).unwrap().matrix();
    let refused = curved.turned(&turn).unwrap_err().to_string();
    assert!(refused.contains("curvature"), "{refused}");
}
