//! The exported headers, compiled for a Cortex-M4 and run under emulation, against the desk on 10⁵ random samples.

use proofmass_core::{FixedPoint, FixedRange};
use proofmass_documents::{ExportForm, ExportNumber, ExportOptions, export};
use proofmass_example_c::calibration;
use std::process::Command;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/cortex-m4");

fn succeed(command: &mut Command) -> String {
    let out = command.output().unwrap();
    let said = String::from_utf8_lossy(&out.stderr).into_owned();
    assert!(out.status.success(), "{command:?}: {said}");
    // The emulator prints what the chip says to standard error.
    String::from_utf8_lossy(&out.stdout).into_owned() + &said
}

#[test]
#[cfg_attr(
    not(chip_emulated),
    ignore = "needs arm-none-eabi-gcc and qemu-system-arm"
)]
fn crosscheck_headers_on_a_cortex_m4_against_the_desk() {
    for curvature in [false, true] {
        compare(curvature);
    }
}

/// A calibration with temperature, with curvature or without.
fn compare(curvature: bool) {
    let file = calibration(true, curvature).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for (name, number) in [
        ("single", ExportNumber::Float),
        ("real", ExportNumber::Double),
        ("integer", ExportNumber::Fixed),
    ] {
        let mut options = ExportOptions::default();
        options.name = Some(name.into());
        options.number = number;
        options.outputs = Some([0, 65_535]);
        let header = export(&file, ExportForm::C, &options).unwrap();
        std::fs::write(folder.path().join(format!("{name}.h")), header).unwrap();
    }
    let program = folder.path().join("chip.elf");
    succeed(
        Command::new("arm-none-eabi-gcc")
            .args([
                "-mcpu=cortex-m4",
                "-mthumb",
                "-mfloat-abi=hard",
                "-mfpu=fpv4-sp-d16",
            ])
            .args([
                "-std=gnu99",
                "-O2",
                "-ffp-contract=off",
                "-Wall",
                "-Wextra",
                "-Werror",
            ])
            .args(["-ffreestanding", "-nostartfiles", "-nostdlib"])
            .arg("-I")
            .arg(folder.path())
            .arg(format!("{FOLDER}/main.c"))
            .arg("-T")
            .arg(format!("{FOLDER}/link.ld"))
            .arg("-lgcc")
            .arg("-o")
            .arg(&program),
    );
    let said = succeed(
        Command::new("qemu-system-arm")
            .args([
                "-M",
                "mps2-an386",
                "-nographic",
                "-monitor",
                "none",
                "-serial",
                "none",
            ])
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(&program),
    );
    let value = |name: &str| -> u64 {
        let line = said.lines().find_map(|l| l.strip_prefix(name));
        u64::from_str_radix(line.unwrap_or_else(|| panic!("{name}: {said}")).trim(), 16).unwrap()
    };

    let model = file.compensation().unwrap();
    let model = *model.three_axes().unwrap();
    let range = FixedRange {
        outputs: [[0, 65_535]; 3],
        temperature: [-40.0, 85.0],
    };
    let fixed = FixedPoint::new(&model, range).unwrap();
    let mut state = 11u64;
    let mut below = |n: u64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % n) as i32
    };
    let (mut real, mut bits) = (0u64, 0u32);
    for _ in 0..100_000 {
        let output = [below(65_536), below(65_536), below(65_536)];
        let t = below(32_000) - 10_240;
        let a = fixed.apply(output, t).unwrap();
        let exact = model.apply(output.map(f64::from), f64::from(t) / 256.0);
        for axis in 0..3 {
            real = real.wrapping_mul(31).wrapping_add(exact[axis].to_bits());
            bits = bits.wrapping_mul(31).wrapping_add(a[axis] as u32);
        }
    }
    // Double precision and integers: every bit of 300 000 numbers.
    assert_eq!(value("real "), real);
    assert_eq!(value("bits "), u64::from(bits));
    let largest = fixed.bound.into_iter().fold(0.0, f64::max);
    let integer = f64::from_bits(value("integer "));
    assert!(integer > 0.0 && integer <= largest, "{integer} {largest}");
    let bound = 16.0
        * f64::from(f32::EPSILON)
        * 2.0
        * 65_536.0
        * 3f64.sqrt()
        * model.sensor().k_inverse().norm();
    let single = f64::from_bits(value("single "));
    assert!(single > 0.0 && single <= bound, "{single} {bound}");
}
