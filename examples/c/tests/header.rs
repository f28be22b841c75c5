//! The exported header, compiled by the host compiler, against the desk on 10⁵ random samples.

use proofmass_core::{FixedPoint, FixedRange};
use proofmass_documents::{CalibrationFile, ExportForm, ExportNumber, ExportOptions, export};
use proofmass_example_c::calibration;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const SAMPLES: usize = 100_000;

/// Random outputs over the whole converter and temperatures over the whole range, in 1/256 °C.
fn samples() -> Vec<[i32; 4]> {
    let mut state = 11u64;
    let mut below = |n: u64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % n) as i32
    };
    (0..SAMPLES)
        .map(|_| {
            [
                below(65_536),
                below(65_536),
                below(65_536),
                below(32_000) - 10_240,
            ]
        })
        .collect()
}

fn compiled(folder: &Path, header: &str, main: &str) -> PathBuf {
    std::fs::write(folder.join("example.h"), header).unwrap();
    std::fs::write(folder.join("main.c"), main).unwrap();
    let program = folder.join("main");
    let out = Command::new("cc")
        .args([
            "-std=c99",
            "-O2",
            "-Wall",
            "-Wextra",
            "-pedantic",
            "-Werror",
        ])
        .arg(folder.join("main.c"))
        .arg("-o")
        .arg(&program)
        .output()
        .unwrap();
    assert!(
        out.status.success(),
        "{}\n{header}",
        String::from_utf8_lossy(&out.stderr)
    );
    program
}

/// What the program prints for all samples, one line each.
fn run(program: &Path, samples: &[[i32; 4]]) -> Vec<String> {
    let mut child = Command::new(program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let text: String = samples
        .iter()
        .map(|s| format!("{} {} {} {}\n", s[0], s[1], s[2], s[3]))
        .collect();
    let writer = std::thread::spawn(move || stdin.write_all(text.as_bytes()).unwrap());
    let out = child.wait_with_output().unwrap();
    writer.join().unwrap();
    assert!(out.status.success(), "the self-check fails");
    let text = String::from_utf8(out.stdout).unwrap();
    text.lines().map(str::to_owned).collect()
}

fn options(number: ExportNumber) -> ExportOptions {
    let mut options = ExportOptions::default();
    options.number = number;
    options.outputs = Some([0, 65_535]);
    options
}

fn main_of(real: &str, thermal: bool) -> String {
    let temperature = if thermal { "t / 256, " } else { "" };
    format!(
        r#"#include <stdio.h>
#include "example.h"
int main(void)
{{
    {real} o[3], a[3];
    double x, y, z, t;
    if (example_self_check())
        return 1;
    while (scanf("%lf %lf %lf %lf", &x, &y, &z, &t) == 4) {{
        o[0] = ({real})x; o[1] = ({real})y; o[2] = ({real})z;
        (void)example_apply(o, {cast}a);
        printf("%.17g %.17g %.17g\n", (double)a[0], (double)a[1], (double)a[2]);
    }}
    return 0;
}}
"#,
        cast = if thermal {
            format!("({real})({})", temperature.trim_end_matches(", ")) + ", "
        } else {
            String::new()
        }
    )
}

/// Largest difference of one precision from the desk, in units of its stated bound.
fn worst(file: &CalibrationFile, number: ExportNumber) -> f64 {
    let header = export(file, ExportForm::C, &options(number)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let single = number == ExportNumber::Float;
    let real = if single { "float" } else { "double" };
    let main = main_of(real, file.temperature.is_some());
    let program = compiled(folder.path(), &header, &main);
    let samples = samples();
    let lines = run(&program, &samples);
    assert_eq!(lines.len(), SAMPLES);
    let model = file.compensation().unwrap();
    let model = *model.three_axes().unwrap();
    // Sixteen roundings relative to the largest number in the sum, as in the self-check.
    let epsilon = f64::from(f32::EPSILON).max(f64::EPSILON);
    let epsilon = if single { epsilon } else { f64::EPSILON };
    let bound = 16.0 * epsilon * 2.0 * 65_536.0 * 3f64.sqrt() * model.sensor().k_inverse().norm();
    let mut worst = 0.0f64;
    for (sample, line) in samples.iter().zip(&lines) {
        let outputs = [0, 1, 2].map(|i| f64::from(sample[i]));
        let exact = model.apply(outputs, f64::from(sample[3]) / 256.0);
        let got = line.split(' ').map(|w| w.parse::<f64>().unwrap());
        for (g, e) in got.zip(exact) {
            worst = worst.max((g - e).abs() / bound);
        }
    }
    worst
}

#[test]
#[cfg_attr(not(c_compiler), ignore = "needs a C compiler named cc")]
fn crosscheck_floating_point_in_c_against_the_desk() {
    for (thermal, curvature) in [(false, false), (true, false), (true, true)] {
        let file = calibration(thermal, curvature).unwrap();
        for number in [ExportNumber::Float, ExportNumber::Double] {
            let worst = worst(&file, number);
            assert!(worst < 1.0, "{number:?} {thermal} {curvature}: {worst}");
        }
    }
}

/// Integers agree with `core::FixedPoint` to the last bit, and with exact arithmetic within the stated bound.
#[test]
#[cfg_attr(not(c_compiler), ignore = "needs a C compiler named cc")]
fn crosscheck_integers_in_c_against_the_desk() {
    for (thermal, curvature) in [(false, false), (true, false), (false, true), (true, true)] {
        let file = calibration(thermal, curvature).unwrap();
        let header = export(&file, ExportForm::C, &options(ExportNumber::Fixed)).unwrap();
        let main = format!(
            r#"#include <stdio.h>
#include "example.h"
int main(void)
{{
    int32_t o[3], a[3];
    long x, y, z, t;
    if (example_self_check())
        return 1;
    while (scanf("%ld %ld %ld %ld", &x, &y, &z, &t) == 4) {{
        o[0] = (int32_t)x; o[1] = (int32_t)y; o[2] = (int32_t)z;
        if (!example_apply(o, {}a))
            return 2;
        printf("%ld %ld %ld\n", (long)a[0], (long)a[1], (long)a[2]);
    }}
    return 0;
}}
"#,
            if thermal { "(int32_t)t, " } else { "" }
        );
        let folder = tempfile::tempdir().unwrap();
        let program = compiled(folder.path(), &header, &main);
        let samples = samples();
        let lines = run(&program, &samples);
        assert_eq!(lines.len(), SAMPLES);
        let model = file.compensation().unwrap();
        let model = *model.three_axes().unwrap();
        let range = FixedRange {
            outputs: [[0, 65_535]; 3],
            temperature: [-40.0, 85.0],
        };
        let fixed = FixedPoint::new(&model, range).unwrap();
        for (sample, line) in samples.iter().zip(&lines) {
            let outputs = [sample[0], sample[1], sample[2]];
            let here = fixed.apply(outputs, sample[3]).unwrap();
            let there: Vec<i32> = line.split(' ').map(|w| w.parse().unwrap()).collect();
            assert_eq!(there, here);
            let exact = model.apply(outputs.map(f64::from), f64::from(sample[3]) / 256.0);
            let si = fixed.to_si(here);
            for axis in 0..3 {
                assert!((si[axis] - exact[axis]).abs() <= fixed.bound[axis]);
            }
        }
    }
}

/// The program that ships, with the header it names.
#[test]
#[cfg_attr(not(c_compiler), ignore = "needs a C compiler named cc")]
fn known_the_example_program_runs() {
    let file = calibration(true, true).unwrap();
    let mut options = options(ExportNumber::Float);
    options.name = Some("accelerometer".into());
    let header = export(&file, ExportForm::C, &options).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let main = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/accelerometer.c"));
    std::fs::write(folder.path().join("accelerometer.h"), &header).unwrap();
    let program = compiled(folder.path(), &header, &main.unwrap());
    let lines = run(
        &program,
        &[[33_120, 33_271, 36_436, 23], [33_120, 33_271, 36_436, 99]],
    );
    let model = file.compensation().unwrap();
    let model = *model.three_axes().unwrap();
    let exact = model.apply([33_120.0, 33_271.0, 36_436.0], 23.0);
    let first: Vec<f64> = lines[0].split(' ').map(|w| w.parse().unwrap()).collect();
    for axis in 0..3 {
        assert!((first[axis] - exact[axis]).abs() < 1e-3);
    }
    assert!(lines[1].ends_with(" extrapolated"), "{}", lines[1]);
}
