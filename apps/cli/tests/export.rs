//! `proofmass export`: the calibration of the example in every form.

use crate::support::*;

const EXAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hand-held");

#[test]
fn law_every_form_is_written_and_wrong_wishes_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("result");
    succeed(&["calibrate", EXAMPLE, "-o", text(&out)]);
    let calibration = out.join("calibration.json");
    for (form, word) in [
        ("--rust", "SensorModel::constant("),
        ("--c", "static inline void"),
        ("--python", "def apply(x, y, z):"),
        ("--json", "\"K_inverse\""),
    ] {
        let file = folder.path().join(form);
        succeed(&["export", text(&calibration), form, "-o", text(&file)]);
        let written = std::fs::read_to_string(&file).unwrap();
        assert!(written.contains(word), "{form}");
        assert!(
            written.contains("calibration.json"),
            "{form} names no source"
        );
    }
    // What it wrote is written anew; a file of somebody stays.
    let again = folder.path().join("--c");
    succeed(&["export", text(&calibration), "--rust", "-o", text(&again)]);
    let own = folder.path().join("recording.csv");
    std::fs::write(&own, "t,x\n0,1\n").unwrap();
    let said = refuse(&["export", text(&calibration), "--c", "-o", text(&own)]);
    assert!(said.contains("was not written by `proofmass`"), "{said}");
    assert_eq!(std::fs::read_to_string(&own).unwrap(), "t,x\n0,1\n");
    let fixed = ["--c", "--number", "fixed"];
    let args = |more: &[&'static str]| -> Vec<String> {
        let mut all = vec!["export".to_owned(), text(&calibration).to_owned()];
        all.extend(fixed.iter().chain(more).map(|s| (*s).to_owned()));
        all
    };
    let run = |args: Vec<String>| {
        let words: Vec<&str> = args.iter().map(String::as_str).collect();
        proofmass(&words)
    };
    let good = run(args(&["--outputs", "0,65535"]));
    assert!(good.status.success());
    assert!(String::from_utf8_lossy(&good.stdout).contains("RESULT_BITS"));
    let bad = run(args(&[]));
    assert_eq!(bad.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&bad.stderr).contains("range of the converter"));
    // No form, or two, is wrong use.
    for forms in [&[][..], &["--c", "--rust"]] {
        let mut words = vec!["export", text(&calibration)];
        words.extend(forms);
        assert_eq!(proofmass(&words).status.code(), Some(2));
    }
}

#[test]
fn law_filters_are_written_with_their_delay() {
    let run = |words: &[&str]| String::from_utf8(succeed(words).stdout).unwrap();
    let c = run(&["filter", "--low-pass", "50", "--rate", "1000", "--c"]);
    assert!(c.contains("static inline float low_pass_step("), "{c}");
    assert!(c.contains("Group delay at low frequency: 4.464497"), "{c}");
    let rust = run(&[
        "filter", "--mean", "5", "--rate", "100", "--rust", "--name", "smooth",
    ]);
    assert!(
        rust.contains("pub type Smooth<T> = MovingAverage<T, 5>;"),
        "{rust}"
    );
    assert!(rust.contains("2.000000 samples"), "{rust}");
    let json: serde_json::Value = serde_json::from_str(&run(&[
        "filter",
        "--low-pass",
        "50",
        "--rate",
        "1000",
        "--json",
    ]))
    .unwrap();
    let sum: f64 = json["block"]["numerator"]
        .as_array()
        .unwrap()
        .iter()
        .map(|v| v.as_f64().unwrap())
        .sum();
    let below: f64 = json["block"]["denominator"]
        .as_array()
        .unwrap()
        .iter()
        .map(|v| v.as_f64().unwrap())
        .sum();
    assert!((sum / below - 1.0).abs() < 1e-12);
    for wrong in [
        &["filter", "--low-pass", "600", "--rate", "1000", "--c"][..],
        &["filter", "--mean", "0", "--rate", "1000", "--c"],
    ] {
        assert_eq!(proofmass(wrong).status.code(), Some(1), "{wrong:?}");
    }
    for wrong in [
        &["filter", "--rate", "1000", "--c"][..],
        &[
            "filter",
            "--low-pass",
            "50",
            "--mean",
            "3",
            "--rate",
            "1000",
            "--c",
        ],
        &["filter", "--low-pass", "-50", "--rate", "1000", "--c"],
        &["filter", "--low-pass", "50", "--c"],
    ] {
        assert_eq!(proofmass(wrong).status.code(), Some(2), "{wrong:?}");
    }
}

/// Gains of a velocity, the map of an encoder: from a recording to a header.
#[test]
fn law_results_of_an_axis_are_written_for_firmware() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let axis = path("axis");
    succeed(&[
        "simulate",
        "axis",
        "-o",
        text(&axis),
        "--radius",
        "0.02",
        "--eccentricity",
        "0.02",
    ]);
    let recording = axis.join("recording.csv");
    let (tuned, map) = (path("tuned"), path("map"));
    let sensors = [
        "--position",
        "encoder",
        "--counts-per-turn",
        "2000",
        "--radius",
        "0.02",
        "--acceleration",
        "acceleration",
    ];
    let mut words = vec!["velocity", "tune", text(&recording), "-o", text(&tuned)];
    words.extend(sensors);
    succeed(&words);
    let result = tuned.join("result.json");
    for (method, word) in [
        (
            "kalman",
            "_step(velocity_state *state, int has_reading, float reading, float acceleration)",
        ),
        ("observer", "k_x, k_v, k_b, half the sample time"),
        ("two-channel", "k1 + k2, k1 k2, half the sample time"),
    ] {
        let said = succeed(&["export", text(&result), "--c", "--method", method]);
        let said = String::from_utf8(said.stdout).unwrap();
        assert!(said.contains(word), "{method}: {said}");
        assert!(said.contains("result.json, SHA-256"), "{said}");
        // The offset is a state from the start, or is subtracted: one of them.
        let begins = said.contains("state->x[2] = velocity_offset;");
        assert_eq!(begins, method == "kalman", "{said}");
        assert_eq!(said.contains("nothing is to be subtracted"), begins);
        assert_eq!(said.contains("subtract it from the acceleration"), !begins);
    }
    let mut words = vec!["velocity", "map", text(&recording), "-o", text(&map)];
    words.extend(sensors);
    succeed(&words);
    let said = succeed(&["export", text(&map.join("result.json")), "--rust"]);
    assert!(
        String::from_utf8_lossy(&said.stdout).contains("pub const ENCODER_MAP: [ErrorLine<f32>;")
    );
    // Of a calibration there are no gains to choose, of a noise result nothing is for firmware.
    let refused = refuse(&["export", text(&result), "--python"]);
    assert!(refused.contains("--c, --rust or --json"), "{refused}");
}

/// The constant matrix of a calibration over frequency, at one frequency of the published case and in a band, run in C and in Python
/// where they are here, against `apply`.
#[test]
fn law_the_matrix_of_a_band_is_that_of_apply() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("result");
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/published-triaxial");
    succeed(&["calibrate", example, "-o", text(&out)]);
    let calibration = out.join("calibration.json");
    let export = |more: &[&str]| -> String {
        let words = [&["export", text(&calibration)], more].concat();
        String::from_utf8(succeed(&words).stdout).unwrap()
    };
    let refused = refuse(&["export", text(&calibration), "--c"]);
    assert!(refused.contains("--band LOW,HIGH"), "{refused}");
    let beyond = refuse(&["export", text(&calibration), "--c", "--band", "1,100000"]);
    assert!(beyond.contains("band in Hz"), "{beyond}");
    // Outputs in volts as they are typed, and what `apply` makes of them.
    let recording = folder.path().join("recording.csv");
    let mut rows = String::from("t_s,x_V,y_V,z_V\n");
    let mut outputs = Vec::new();
    let mut noise = Chance(7);
    for i in 0..100_000 {
        let row: [f64; 3] = std::array::from_fn(|_| (noise.normal() * 1e5).round() / 1e6);
        rows += &format!(
            "{},{},{},{}\n",
            f64::from(i) / 1000.0,
            row[0],
            row[1],
            row[2]
        );
        outputs.push(row);
    }
    std::fs::write(&recording, rows).unwrap();
    const BOUND: f64 = 1e-15;
    let mut exact = Vec::new();
    for band in ["80,160", "160,160"] {
        exact.clear();
        let applied = folder.path().join(format!("{band}.csv"));
        let words = [
            "apply",
            text(&calibration),
            text(&recording),
            "--columns",
            "2,3,4",
            "--band",
            band,
            "-o",
        ];
        let told = succeed(&[&words[..], &[text(&applied)]].concat());
        let told = String::from_utf8(told.stderr).unwrap();
        let json: serde_json::Value =
            serde_json::from_str(&export(&["--json", "--band", band])).unwrap();
        let inverse = |i: usize, j: usize| json["K_inverse"][i][j].as_f64().unwrap();
        // The matrix is told, and kept beside the file.
        let matrix = told.split("M⁻¹ = [").nth(1).expect("a matrix");
        let matrix = matrix.split(']').next().unwrap();
        for (i, row) in matrix.split("; ").enumerate() {
            for (j, number) in row.split(' ').enumerate() {
                let number: f64 = number.parse().unwrap();
                assert!((number / inverse(i, j) - 1.0).abs() < 1e-9, "{matrix}");
            }
        }
        let kept = std::fs::read_to_string(format!("{}.provenance.json", text(&applied))).unwrap();
        assert!(kept.contains(matrix), "{kept}");
        let written = std::fs::read_to_string(&applied).unwrap();
        let mut lines = written.lines().filter(|l| !l.starts_with('#'));
        let heading: Vec<&str> = lines.next().unwrap().split(',').collect();
        let first = heading.len() - 3;
        let mut compared = 0;
        let mut largest = 0.0_f64;
        for (line, output) in lines.zip(&outputs) {
            let fields: Vec<f64> = line
                .split(',')
                .skip(first)
                .map(|f| f.parse().unwrap())
                .collect();
            for (i, there) in fields.iter().enumerate() {
                let terms: [f64; 3] = std::array::from_fn(|j| inverse(i, j) * output[j]);
                let here = terms[0] + terms[1] + terms[2];
                let size: f64 = terms.iter().map(|t| t.abs()).sum();
                largest = largest.max((here - there).abs() / size);
                exact.push(here);
                compared += 1;
            }
        }
        assert_eq!(compared, 300_000);
        // Two inverses of one matrix: a few units in the last place of the terms.
        assert!(largest < BOUND, "{band}: {largest:e}");
        if band == "160,160" {
            // The report has the same, as it is typed.
            let page = std::fs::read_to_string(out.join("report.html")).unwrap();
            for k in 0..9 {
                let typed = format!("{:.6e}", inverse(k / 3, k % 3));
                assert!(page.contains(&typed), "{typed}");
            }
        }
        let notes = json["notes"].to_string();
        assert!(
            notes.contains("Error of the acceleration at most"),
            "{notes}"
        );
        assert!(notes.contains("Without a bias"), "{notes}");
    }
    let header = export(&[
        "--c", "--number", "double", "--band", "160,160", "--name", "shaken",
    ]);
    assert!(header.contains("Constant real matrix for 160 Hz"));
    std::fs::write(folder.path().join("shaken.h"), header).unwrap();
    let program = "#include <stdio.h>\n#include \"shaken.h\"\nint main(void) {\n    double o[3], a[3];\n    if (shaken_self_check()) return 1;\n    while (fread(o, sizeof o[0], 3, stdin) == 3) {\n        shaken_apply(o, a);\n        fwrite(a, sizeof a[0], 3, stdout);\n    }\n    return 0;\n}\n";
    std::fs::write(folder.path().join("main.c"), program).unwrap();
    let cc = std::process::Command::new("cc")
        .args([
            "-std=c99",
            "-Wall",
            "-Werror",
            "-ffp-contract=off",
            "-o",
            "main",
            "main.c",
        ])
        .current_dir(folder.path())
        .status();
    if cc.is_ok_and(|s| s.success()) {
        let bytes: Vec<u8> = outputs
            .iter()
            .flatten()
            .flat_map(|v| v.to_ne_bytes())
            .collect();
        std::fs::write(folder.path().join("outputs"), bytes).unwrap();
        let run = std::process::Command::new(folder.path().join("main"))
            .stdin(std::fs::File::open(folder.path().join("outputs")).unwrap())
            .output()
            .unwrap();
        assert_eq!(run.status.code(), Some(0));
        let numbers = run.stdout.chunks_exact(8);
        let numbers: Vec<f64> = numbers
            .map(|b| f64::from_ne_bytes(b.try_into().unwrap()))
            .collect();
        // The matrix at 160 Hz over 10⁵ samples, bit for bit.
        assert!(
            numbers == exact,
            "{} of {} numbers",
            numbers.len(),
            exact.len()
        );
    }
}

/// The image of a memory is written, shown again with the coefficients of the calibration, and refused when a bit has changed.
#[test]
fn law_a_calibration_goes_to_the_memory_of_a_device_and_back() {
    let folder = tempfile::tempdir().unwrap();
    let result = folder.path().join("result");
    succeed(&["calibrate", EXAMPLE, "-o", text(&result)]);
    let calibration = result.join("calibration.json");
    let image = folder.path().join("memory.bin");
    succeed(&["export", text(&calibration), "--memory", "-o", text(&image)]);
    let bytes = std::fs::read(&image).unwrap();
    assert_eq!(bytes.len(), 128);
    let output = succeed(&["inspect", text(&image), "--json"]);
    let seen: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let file: serde_json::Value =
        serde_json::from_slice(&std::fs::read(&calibration).unwrap()).unwrap();
    assert_eq!(seen["serial"], file["device"]["serial"]);
    for i in 0..3 {
        let stored = |v: &serde_json::Value| v.as_f64().unwrap() as f32;
        assert_eq!(stored(&seen["b"][i]), stored(&file["b"][i]));
        for j in 0..3 {
            assert_eq!(stored(&seen["K"][i][j]), stored(&file["K"][i][j]));
        }
    }
    let digest = proofmass::io::sha256(&[&std::fs::read(&calibration).unwrap()]);
    assert!(digest.starts_with(seen["source_sha256_begins"].as_str().unwrap()));
    // A dump of the whole memory, longer than the image.
    let mut dump = bytes.clone();
    dump.resize(256, 0xff);
    std::fs::write(&image, &dump).unwrap();
    let shown = String::from_utf8(succeed(&["inspect", text(&image)]).stdout).unwrap();
    assert!(shown.contains("checksum right") && shown.contains("128 bytes behind it"));
    succeed(&["export", text(&calibration), "--memory", "-o", text(&image)]);
    dump[60] ^= 4;
    std::fs::write(&image, &dump[..128]).unwrap();
    let said = refuse(&["inspect", text(&image)]);
    assert!(said.contains("memory.bin") && said.contains("checksum") && said.contains("hint:"));
    let output = proofmass(&["export", text(&calibration), "--memory"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--output"));
}
