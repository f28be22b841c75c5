//! A calibration in the memory of a device: the exported C reader against the reader of `core`, on the same bytes.

use proofmass_core::{
    AxisCompensation, CalibrationMemory, MemoryUnit, StoredCompensation, ThermalTerms,
};
use proofmass_documents::{ExportForm, ExportOptions, MemoryContent, export, export_memory};
use proofmass_example_c::calibration;
use std::io::Write;
use std::process::{Command, Stdio};

const SAMPLES: usize = 20_000;

/// Reads an image and samples from standard input; prints why the image is refused, or the accelerations.
const MAIN: &str = r#"#include <stdio.h>
#include "memory.h"
int main(void)
{
    static uint8_t bytes[4096];
    size_t length;
    memory_t c;
    int answer;
    float o[3], a[3], t;
    unsigned n;
    if (memory_self_check())
        return 1;
    if (scanf("%u", &n) != 1)
        return 2;
    for (length = 0; length < n; length++) {
        unsigned byte;
        if (scanf("%u", &byte) != 1)
            return 2;
        bytes[length] = (uint8_t)byte;
    }
    answer = memory_read(bytes, length, &c);
    printf("%d %s\n", answer, answer == memory_OK ? c.serial : "");
    while (answer == memory_OK && scanf("%f %f %f %f", &o[0], &o[1], &o[2], &t) == 4) {
        a[0] = a[1] = a[2] = 0.0f;
        if (memory_apply(&c, o, t, a))
            printf("%.9g %.9g %.9g\n", (double)a[0], (double)a[1], (double)a[2]);
        else
            printf("beyond\n");
    }
    return 0;
}
"#;

/// The text, the compiled reader and a folder that keeps it.
fn reader(thermal: bool, curvature: bool) -> (tempfile::TempDir, std::path::PathBuf) {
    let mut options = ExportOptions::default();
    options.name = Some("memory".to_owned());
    let file = calibration(thermal, curvature).unwrap();
    let header = export(&file, ExportForm::MemoryReader, &options).unwrap();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("memory.h"), &header).unwrap();
    std::fs::write(folder.path().join("main.c"), MAIN).unwrap();
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
    let said = String::from_utf8_lossy(&out.stderr).into_owned();
    assert!(out.status.success(), "{said}\n{header}");
    (folder, program)
}

fn run(program: &std::path::Path, image: &[u8], samples: &[[f32; 4]]) -> Vec<String> {
    let mut child = Command::new(program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let mut text = image.len().to_string();
    for byte in image {
        text += &format!(" {byte}");
    }
    for [x, y, z, t] in samples {
        text += &format!("\n{x:e} {y:e} {z:e} {t:e}");
    }
    let writer = std::thread::spawn(move || {
        // The reader stops early where it refuses the image.
        let _ = stdin.write_all(text.as_bytes());
    });
    let out = child.wait_with_output().unwrap();
    writer.join().unwrap();
    assert!(out.status.success(), "the self-check fails");
    let text = String::from_utf8(out.stdout).unwrap();
    text.lines().map(str::to_owned).collect()
}

/// Outputs over the whole converter, temperatures within and beyond the calibration.
fn samples() -> Vec<[f32; 4]> {
    let mut state = 5u64;
    let mut below = |n: u64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % n) as f32
    };
    let mut sample = || {
        [
            below(65_536),
            below(65_536),
            below(65_536),
            below(160) - 60.0,
        ]
    };
    (0..SAMPLES).map(|_| sample()).collect()
}

/// Both readers give the same single-precision numbers from the same bytes, and both refuse what lies beyond the temperatures.
#[test]
#[cfg_attr(not(c_compiler), ignore = "needs a C compiler named cc")]
fn crosscheck_the_reader_in_c_against_that_of_the_chip_crate() {
    for (thermal, curvature) in [(false, false), (true, false), (false, true), (true, true)] {
        let file = calibration(thermal, curvature).unwrap();
        let image = export_memory(&file, &ExportOptions::default()).unwrap();
        let memory = CalibrationMemory::read(&image).unwrap();
        let StoredCompensation::ThreeAxes(model) = memory.compensation() else {
            panic!("three axes are stored");
        };
        let (_folder, program) = reader(thermal, curvature);
        let samples = samples();
        let lines = run(&program, &image, &samples);
        assert_eq!(lines[0].trim(), "0");
        assert_eq!(lines.len(), SAMPLES + 1);
        for ([x, y, z, t], line) in samples.iter().zip(&lines[1..]) {
            if model.thermal().is_some_and(|terms| !terms.covers(*t)) {
                assert_eq!(line, "beyond");
                continue;
            }
            let here = model.apply([*x, *y, *z], *t);
            let there: Vec<f32> = line.split(' ').map(|w| w.parse().unwrap()).collect();
            assert_eq!(there, here);
        }
    }
}

/// One reader serves every device: it reads the memory of a single axis in volts, made for another.
#[test]
#[cfg_attr(not(c_compiler), ignore = "needs a C compiler named cc")]
fn known_one_reader_reads_the_memory_of_another_device() {
    let terms = ThermalTerms {
        reference: 23.0f32,
        range: [0.0, 50.0],
        bias: [[1e-4, 0.0, 1e-9]],
        scale: [[1e-4, -1e-6, 0.0]],
    };
    let model = AxisCompensation::new(0.13f32, 2e-3, Some(terms), None, 50.0).unwrap();
    let stored = StoredCompensation::OneAxis(model);
    let memory = CalibrationMemory::new("QA-17", [0; 8], MemoryUnit::Volt, stored).unwrap();
    let mut image = [0xff; 256];
    memory.write(&mut image).unwrap();
    let (_folder, program) = reader(true, true);
    let samples: Vec<[f32; 4]> = (0..100)
        .map(|i| [0.02 * i as f32 - 1.0, 0.0, 0.0, 0.7 * i as f32])
        .collect();
    let lines = run(&program, &image, &samples);
    assert_eq!(lines[0], "0 QA-17");
    for ([x, _, _, t], line) in samples.iter().zip(&lines[1..]) {
        if *t > 50.0 {
            assert_eq!(line, "beyond");
            continue;
        }
        let there: f32 = line.split(' ').next().unwrap().parse().unwrap();
        assert_eq!(there, model.apply(*x, *t));
    }
}

/// The reader in C refuses what that of the chip crate refuses, and says why.
#[test]
#[cfg_attr(not(c_compiler), ignore = "needs a C compiler named cc")]
fn law_a_damaged_memory_is_read_by_nobody() {
    let file = calibration(true, true).unwrap();
    let image = export_memory(&file, &ExportOptions::default()).unwrap();
    let (_folder, program) = reader(true, true);
    let answer = |bytes: &[u8]| run(&program, bytes, &[]).remove(0).trim().to_owned();
    assert_eq!(answer(&image), "0");
    assert_eq!(answer(&[0xff; 256]), "1");
    assert_eq!(answer(&image[..image.len() - 1]), "3");
    assert_eq!(answer(&image[..20]), "3");
    let mut changed = image.clone();
    for place in (4..image.len()).step_by(7) {
        changed[place] ^= 0x10;
        assert!(CalibrationMemory::read(&changed).is_err());
        assert!(MemoryContent::read(&changed).is_err());
        assert_ne!(answer(&changed), "0", "{place}");
        changed[place] ^= 0x10;
    }
}
