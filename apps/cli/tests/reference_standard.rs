//! A calibration over frequency as the reference standard of what comes after: of a campaign, of `test steps|random|shock`.

use crate::support;
use crate::support::*;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const RATE: f64 = 8000.0;
/// Sensitivity of the transducer that becomes the standard, V/(m/s²), and of the device calibrated with it.
const STANDARD: f64 = 0.01;
const DEVICE: f64 = 0.05;

/// Forty periods at each frequency in two channels that follow at once, with a trace of noise.
fn stepped(path: &Path, header: &str, gains: [f64; 2]) {
    let mut chance = Chance(1);
    let mut noise = || chance.uniform() - 0.5;
    let mut text = format!("{header}\n");
    let (mut k, mut phase) = (0u32, 0.0f64);
    for f in [40.0, 80.0, 160.0, 320.0, 640.0] {
        for _ in 0..(40.0 * RATE / f) as usize {
            let a = 20.0 * phase.sin();
            let (n, m) = (1e-3 * noise(), 1e-3 * noise());
            let t = f64::from(k) / RATE;
            writeln!(
                text,
                "{t:.6},{:.9},{:.9}",
                gains[0] * (a + n),
                gains[1] * (a + m)
            )
            .unwrap();
            (k, phase) = (k + 1, phase + TAU * f / RATE);
        }
    }
    std::fs::write(path, text).unwrap();
}

/// The standard against a laser: 0.5 % of the laser are common to all frequencies.
fn standard(folder: &Path) -> PathBuf {
    let recording = folder.join("standard.csv");
    stepped(&recording, "time_s,laser_m/s2,out_V", [1.0, STANDARD]);
    let place = folder.join("standard");
    let output = ["-o", text(&place)];
    let columns = ["--input", "laser", "--output-column", "out"];
    let asked = [
        "test",
        "steps",
        text(&recording),
        "--input-uncertainty",
        "0.5",
    ];
    succeed(&[&asked[..], &columns, &output].concat());
    place
}

fn table(path: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap();
    let row = |l: &str| l.split(',').filter_map(|f| f.parse().ok()).collect();
    text.lines().skip(1).map(row).collect()
}

#[test]
fn law_a_standard_hands_its_sensitivity_and_uncertainty_on() {
    let folder = tempfile::tempdir().unwrap();
    let standard = standard(folder.path());
    assert_eq!(table(&standard.join("response.csv")).len(), 5);
    let recording = folder.path().join("device.csv");
    stepped(&recording, "time_s,ref_V,dut_V", [STANDARD, DEVICE]);
    for (document, model) in [
        ("calibration.json", None),
        ("result.json", None),
        ("calibration.json", Some("0modes")),
    ] {
        let place = folder.path().join("device");
        let document = standard.join(document);
        let mut asked = vec![
            "test",
            "steps",
            text(&recording),
            "--input",
            "ref",
            "--column",
            "dut",
            "--standard",
            text(&document),
            "--model",
            "0modes",
            "--force",
            "-o",
            text(&place),
        ];
        asked.extend(model.iter().flat_map(|m| ["--standard-model", *m]));
        succeed(&asked);
        let result = json(&place.join("result.json"));
        let (value, u, _) = quantity(&result, "sensitivity");
        assert!((value / DEVICE - 1.0).abs() < 1e-4, "{value}");
        // The laser's 0.5 % comes through whole: five frequencies do not average it away.
        assert!((u / value / 5e-3 - 1.0).abs() < 0.02, "{}", u / value);
        assert!(codes(&result).is_empty(), "{:?}", codes(&result));
        assert_eq!(result["inputs"].as_array().unwrap().len(), 2);
        succeed(&["verify", text(&place)]);
        // And on to what is calibrated with this one.
        let calibration = json(&place.join("calibration.json"));
        assert!(calibration.to_string().contains("reference.modulus"));
        // An altered standard is found out.
        let whole = std::fs::read(&document).unwrap();
        std::fs::write(&document, [&whole[..], b"\n"].concat()).unwrap();
        succeed(&asked);
        let result = json(&place.join("result.json"));
        assert_eq!(codes(&result), ["input-changed"], "{document:?}");
        std::fs::write(&document, whole).unwrap();
    }
}

#[test]
fn law_a_campaign_takes_a_calibration_as_its_reference() {
    let folder = tempfile::tempdir().unwrap();
    let standard = standard(folder.path());
    let campaign = folder.path().join("campaign");
    let toml = |reference: &str| {
        support::campaign(
            &campaign,
            &format!(
                "kind = \"shaker-single\"\n[runs]\nfile = \"runs.csv\"\n[reference]\n{reference}\n\
                 [reading]\nu_relative = 0.001\nu_phase_deg = 0.1\n"
            ),
        );
    };
    toml("file = \"standard.json\"");
    std::fs::copy(
        standard.join("calibration.json"),
        campaign.join("standard.json"),
    )
    .unwrap();
    let runs = "run,frequency_Hz,transverse_%,reference_V,reference_phase_deg,output_V,output_phase_deg\n\
                a,80,1,0.1,0,0.5,-10\nb,200,1,0.1,0,0.5,-10\nc,2000,1,0.1,0,0.5,-10\n";
    std::fs::write(campaign.join("runs.csv"), runs).unwrap();
    succeed(&["calibrate", text(&campaign)]);
    let result = json(&campaign.join("result/result.json"));
    for f in ["80", "200"] {
        let (value, u, _) = quantity(&result, &format!("S.modulus[frequency={f}]"));
        assert!((value / DEVICE - 1.0).abs() < 1e-4, "{value}");
        // √(0.5² + 0.1²) %.
        assert!((u / value / 0.0051 - 1.0).abs() < 0.01, "{}", u / value);
    }
    // 2 kHz is beyond it, and verify follows the document.
    assert_eq!(
        codes(&result),
        ["reference-out-of-range", "repeatability-unseen"]
    );
    toml(&format!("file = {:?}", text(&standard.join("result.json"))));
    let altered = standard.join("result.json");
    let whole = std::fs::read(&altered).unwrap();
    std::fs::write(&altered, [&whole[..], b"\n"].concat()).unwrap();
    let other = folder.path().join("altered");
    succeed(&["calibrate", text(&campaign), "-o", text(&other)]);
    let result = json(&other.join("result.json"));
    assert!(
        codes(&result).contains(&"input-changed".to_owned()),
        "{:?}",
        codes(&result)
    );
    toml("file = \"standard.json\"");
    succeed(&["verify", text(&campaign.join("result"))]);
    let before = std::fs::read(campaign.join("standard.json")).unwrap();
    let other = String::from_utf8(before)
        .unwrap()
        .replace("\"noise\"", "\"noises\"");
    std::fs::write(campaign.join("standard.json"), other).unwrap();
    refuse(&["verify", text(&campaign.join("result"))]);
    // Out of place: an axis that is not there, a model that is none, a file that is something else.
    for (reference, words) in [
        (
            "file = \"standard.json\"\naxis = \"q\"",
            "no output along an axis",
        ),
        (
            "file = \"standard.json\"\nmodel = \"two\"",
            "is no model such as",
        ),
        ("file = \"campaign.toml\"", "campaign.toml"),
        ("file = \"nothing.json\"", "nothing.json"),
    ] {
        toml(reference);
        let said = refuse(&["calibrate", text(&campaign), "--force"]);
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn refuses_a_standard_that_does_not_fit() {
    let folder = tempfile::tempdir().unwrap();
    let standard = standard(folder.path()).join("calibration.json");
    let recording = folder.path().join("device.csv");
    // The channel is in m/s² already.
    stepped(&recording, "time_s,ref_m/s2,dut_V", [1.0, DEVICE]);
    let asked = [
        "test",
        "steps",
        text(&recording),
        "--input",
        "ref",
        "--column",
        "dut",
    ];
    let said = refuse(&[&asked[..], &["--standard", text(&standard)]].concat());
    assert!(said.contains("gives volts"), "{said}");
    // A table of a laboratory without its coverage factor, and with it.
    let table = folder.path().join("laboratory.csv");
    std::fs::write(
        &table,
        "frequency_Hz,sensitivity_mV/(m/s2),phase_deg,U_relative_%,U_phase_deg\n20,10,0,1,0.4\n700,10,0,1,0.4\n",
    )
    .unwrap();
    stepped(&recording, "time_s,ref_V,dut_V", [STANDARD, DEVICE]);
    let with_table = [&asked[..], &["--standard", text(&table)]].concat();
    let said = refuse(&with_table);
    assert!(said.contains("coverage factor"), "{said}");
    let place = folder.path().join("out");
    let more = [
        "--standard-coverage",
        "2",
        "--model",
        "0modes",
        "-o",
        text(&place),
    ];
    succeed(&[&with_table[..], &more].concat());
    let (value, u, _) = quantity(&json(&place.join("result.json")), "sensitivity");
    // 1 % at k = 2, common to all frequencies for want of a word about it.
    assert!((u / value / 5e-3 - 1.0).abs() < 0.02, "{}", u / value);
}

#[test]
fn law_a_shock_is_read_through_the_calibration_of_its_reference() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("laboratory.csv");
    let certificate = |first: &str| {
        let head = "frequency_Hz,sensitivity_V/(m/s2),u_relative_%\n";
        std::fs::write(
            &table,
            format!("{head}{first},0.01,0.4\n1000,0.0101,0.4\n3000,0.0102,0.4\n"),
        )
        .unwrap();
    };
    let recording = folder.path().join("shock.csv");
    let mut text_of = "time_s,ref_V,dut_V\n".to_owned();
    for k in 0..4000u32 {
        let t = f64::from(k) / 50e3;
        let s = (t - 0.04) / 2e-3;
        let pulse = if (0.0..=1.0).contains(&s) {
            1000.0 * (0.5 * TAU * s).sin()
        } else {
            0.0
        };
        let n = f64::from((k * 7919) % 101) / 101.0 - 0.5;
        writeln!(
            text_of,
            "{t:.6},{:.8},{:.8}",
            0.01005 * (pulse + n),
            0.02 * (pulse - n)
        )
        .unwrap();
    }
    std::fs::write(&recording, text_of).unwrap();
    let place = folder.path().join("out");
    let asked = [
        "test",
        "shock",
        text(&recording),
        "--column",
        "dut",
        "--reference",
        "ref",
        "--standard",
        text(&table),
        "--force",
        "-o",
        text(&place),
    ];
    certificate("5");
    succeed(&asked);
    let result = json(&place.join("result.json"));
    let (value, u, expanded) = quantity(&result, "sensitivity.peak");
    assert!((value - 0.02).abs() < expanded, "{value} {expanded}");
    // 0.4 %, half of 1 % of spread over √3 = 0.29 %, and as much for the curve between the points: 0.57 %.
    assert!((u / value / 5.7e-3 - 1.0).abs() < 0.03, "{}", u / value);
    assert!(!codes(&result).contains(&"reference-out-of-range".to_owned()));
    // From 200 Hz on: what an integral needs is not calibrated.
    certificate("200");
    succeed(&asked);
    let result = json(&place.join("result.json"));
    assert!(codes(&result).contains(&"reference-out-of-range".to_owned()));
    certificate("1500");
    std::fs::write(
        &table,
        std::fs::read_to_string(&table)
            .unwrap()
            .replace("1000,0.0101,0.4\n", ""),
    )
    .unwrap();
    let said = refuse(&asked);
    assert!(said.contains("begins above the band"), "{said}");
}

#[test]
fn refuses_recordings_without_steps() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("recording.csv");
    let write = |a: &dyn Fn(f64) -> f64| {
        let mut text = "time_s,ref_m/s2,dut_V\n".to_owned();
        for k in 0..16_000u32 {
            let t = f64::from(k) / RATE;
            let v = a(t);
            writeln!(text, "{t:.6},{v:.9},{:.9}", 0.02 * v).unwrap();
        }
        std::fs::write(&recording, text).unwrap();
    };
    let asked = [
        "test",
        "steps",
        text(&recording),
        "--input",
        "ref",
        "--column",
        "dut",
    ];
    write(&|t| (TAU * (20.0 * t + 200.0 * t * t)).sin());
    let said = refuse(&asked);
    assert!(
        said.contains("never stays") && said.contains("test sweep"),
        "{said}"
    );
    write(&|_| 1.0);
    let said = refuse(&asked);
    assert!(said.contains("is constant"), "{said}");
    // Five periods at each frequency.
    write(&|t| {
        let f = if t < 1.0 { 4.0 } else { 9.0 };
        if (t % 1.0) * f < 5.0 {
            (TAU * f * t).sin()
        } else {
            0.0
        }
    });
    let said = refuse(&asked);
    assert!(
        said.contains("error[") && said.contains("periods"),
        "{said}"
    );
    // Swapped: the input in volts and the output an acceleration.
    stepped(&recording, "time_s,dut_V,ref_m/s2", [DEVICE, 1.0]);
    let swapped = [
        "test",
        "steps",
        text(&recording),
        "--input",
        "dut",
        "--column",
        "ref",
        "--json",
    ];
    let said = String::from_utf8(succeed(&swapped).stdout).unwrap();
    assert!(said.contains("input-in-volts"), "{said}");
}
