//! Exported filters, gains and maps: the constants of Rust and the headers of C against `proofmass-core`.

use proofmass_documents::{ExportForm, ExportNumber, ExportOptions, FirmwareBlock, export_block};
use proofmass_example_c::filters;
use std::process::Command;

/// The exported text, as firmware has it.
#[rustfmt::skip]
#[allow(clippy::all, clippy::pedantic)]
mod exported {
    pub mod bias;
    pub mod encoder_map;
    pub mod linear_phase;
    pub mod low_pass;
    pub mod mean;
    pub mod observer;
    pub mod two_channel;
    pub mod velocity;
    pub mod velocity_corner;
    pub mod velocity_offset;
    pub mod velocity_second_order_corner;
}

fn options(name: &str, number: ExportNumber) -> ExportOptions {
    let mut options = ExportOptions::default();
    options.name = Some(name.to_owned());
    options.number = number;
    options
}

#[test]
fn law_the_constants_compute_what_the_desk_computes() {
    let checks = [
        ("bias", exported::bias::self_check as fn() -> Option<usize>),
        ("encoder_map", exported::encoder_map::self_check),
        ("linear_phase", exported::linear_phase::self_check),
        ("low_pass", exported::low_pass::self_check),
        ("mean", exported::mean::self_check),
        ("observer", exported::observer::self_check),
        ("two_channel", exported::two_channel::self_check),
        ("velocity", exported::velocity::self_check),
        ("velocity_corner", exported::velocity_corner::self_check),
        ("velocity_offset", exported::velocity_offset::self_check),
        (
            "velocity_second_order_corner",
            exported::velocity_second_order_corner::self_check,
        ),
    ];
    for (name, check) in checks {
        assert_eq!(check(), None, "{name}");
    }
    assert!(exported::encoder_map::error(0.0) > 5e-3);
}

/// What stands in `tests/exported` is what is exported now, but for the heading and the last digits of the results.
#[test]
fn law_the_compiled_text_is_the_exported_one() {
    for (name, block) in filters().unwrap() {
        let number = if name == "mean" {
            ExportNumber::Double
        } else {
            ExportNumber::Float
        };
        let text = export_block(&block, ExportForm::Rust, &options(name, number)).unwrap();
        let path = format!("{}/tests/exported/{name}.rs", env!("CARGO_MANIFEST_DIR"));
        let kept = std::fs::read_to_string(path).unwrap();
        let body = |text: &str| -> String {
            let told = |l: &&str| !l.starts_with("//!") && !l.contains("const EXPECTED:");
            let lines = text.lines().filter(told);
            lines.map(|l| format!("{l}\n")).collect()
        };
        assert_eq!(
            body(&text),
            body(&kept),
            "{name}: run the example `exported`"
        );
    }
}

/// All headers in one program, single and double precision; every self-check passes, and one with a wrong coefficient does not.
#[test]
#[cfg_attr(not(c_compiler), ignore = "needs a C compiler called cc")]
fn crosscheck_headers_of_filters_against_the_desk() {
    let folder = tempfile::tempdir().unwrap();
    let mut includes = String::new();
    let mut calls = String::new();
    let mut number = 1;
    for (name, block) in filters().unwrap() {
        for (suffix, precision) in [("f", ExportNumber::Float), ("d", ExportNumber::Double)] {
            let name = format!("{name}_{suffix}");
            let header = export_block(&block, ExportForm::C, &options(&name, precision)).unwrap();
            std::fs::write(folder.path().join(format!("{name}.h")), header).unwrap();
            includes += &format!("#include \"{name}.h\"\n");
            calls += &format!("    if ({name}_self_check())\n        return {number};\n");
            number += 1;
        }
    }
    let wrong = FirmwareBlock::LowPass {
        corner: 50.0,
        rate: 1000.0,
    };
    let header = export_block(
        &wrong,
        ExportForm::C,
        &options("wrong", ExportNumber::Float),
    )
    .unwrap();
    let damaged = header.replacen("wrong_b[3] = {", "wrong_b[3] = {1e-4f + ", 1);
    assert_ne!(damaged, header);
    std::fs::write(folder.path().join("wrong.h"), damaged).unwrap();
    let uses = "    (void)low_pass_f_init;\n    (void)encoder_map_f_correct;\n    (void)encoder_map_d_correct;\n";
    let main = format!(
        "{includes}#include \"wrong.h\"\nint main(void)\n{{\n{uses}{calls}    return wrong_self_check() ? 0 : 99;\n}}\n"
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
    assert_eq!(
        out.status.code(),
        Some(0),
        "the check with this number fails"
    );
}

#[test]
fn known_delays_and_forms() {
    let text =
        |block: &FirmwareBlock, form| export_block(block, form, &ExportOptions::default()).unwrap();
    let mean = FirmwareBlock::MovingAverage {
        samples: 9,
        rate: 100.0,
    };
    assert!(
        text(&mean, ExportForm::C)
            .contains("Group delay at low frequency: 4.000000 samples, 4.000000e-2 s.")
    );
    // √2/(2π f_c) for a corner far below the rate.
    let slow = FirmwareBlock::LowPass {
        corner: 1.0,
        rate: 1000.0,
    };
    let delay = slow.group_delay().unwrap().unwrap();
    assert!(
        (delay / (2f64.sqrt() / std::f64::consts::TAU) - 1.0).abs() < 1e-4,
        "{delay}"
    );
    assert!(text(&slow, ExportForm::Json).contains("\"group_delay_s\""));
}

#[test]
fn refuses_filters_without_meaning() {
    let refused =
        |block: &FirmwareBlock, form| export_block(block, form, &ExportOptions::default()).is_err();
    let low = |corner, rate| FirmwareBlock::LowPass { corner, rate };
    for block in [
        low(600.0, 1000.0),
        low(0.0, 1000.0),
        low(f64::NAN, 1000.0),
        low(50.0, f64::INFINITY),
        FirmwareBlock::MovingAverage {
            samples: 0,
            rate: 1.0,
        },
        FirmwareBlock::MovingAverage {
            samples: 1_000_000,
            rate: 1.0,
        },
        FirmwareBlock::Observer {
            k_x: -1.0,
            k_v: 1.0,
            k_b: 0.0,
            sample_time: 1e-3,
        },
        FirmwareBlock::EncoderMap {
            turn: 0.0,
            lines: Vec::new(),
            unit: "m",
        },
    ] {
        for form in [ExportForm::C, ExportForm::Rust, ExportForm::Json] {
            assert!(refused(&block, form), "{block:?}");
        }
    }
    assert!(refused(&low(50.0, 1000.0), ExportForm::Python));
    let mut fixed = ExportOptions::default();
    fixed.number = ExportNumber::Fixed;
    assert!(export_block(&low(50.0, 1000.0), ExportForm::C, &fixed).is_err());
    let mut named = ExportOptions::default();
    named.name = Some("2 bad".into());
    assert!(export_block(&low(50.0, 1000.0), ExportForm::C, &named).is_err());
}
