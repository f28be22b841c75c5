//! `proofmass apply` with the steps behind a calibration, and `proofmass export` with the same: what is told, kept and refused.

use crate::support::*;
use std::fmt::Write;
use std::path::{Path, PathBuf};

const G: f64 = 9.80665;

/// A calibration of three axes in m/s² that changes nothing, as `import` makes it.
fn calibration(folder: &Path, name: &str) -> PathBuf {
    let six = folder.join("six.txt");
    std::fs::write(&six, "0 0 0\n1 1 1\n").unwrap();
    let path = folder.join(name);
    succeed(&[
        "import",
        text(&six),
        "--form",
        "six-parameters",
        "--unit",
        "m/s2",
        "-o",
        text(&path),
    ]);
    path
}

/// Twenty seconds at rest with z up at 100 Hz, with a bias that is known.
fn rest(folder: &Path) -> PathBuf {
    let mut noise = Chance(5);
    let mut table = String::from("t_s,x_m/s2,y_m/s2,z_m/s2,row\n");
    for i in 0..2000 {
        let mut n = || 1e-3 * noise.normal();
        let _ = writeln!(
            table,
            "{},{},{},{},{i}",
            f64::from(i) / 100.0,
            0.05 + n(),
            n(),
            G - 0.02 + n()
        );
    }
    let path = folder.join("rest.csv");
    std::fs::write(&path, table).unwrap();
    path
}

const COLUMNS: [&str; 2] = ["--columns", "x_m/s2,y_m/s2,z_m/s2"];

fn tracked(folder: &Path, recording: &Path) -> PathBuf {
    let out = folder.join("bias");
    let words = ["bias", text(recording), "-o", text(&out), "--up", "+z"];
    let noise = ["--gravity", "9.80665", "--white", "1e-4", "--walk", "1e-6"];
    succeed(&[&words[..], &noise, &COLUMNS].concat());
    out.join("result.json")
}

#[test]
fn known_chain_on_the_terminal_and_beside_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let calibration = calibration(folder.path(), "calibration.json");
    let recording = rest(folder.path());
    let bias = tracked(folder.path(), &recording);
    let out = folder.path().join("out.csv");
    let words = [
        "apply",
        text(&calibration),
        text(&recording),
        "-o",
        text(&out),
    ];
    let steps = [
        "--bias",
        text(&bias),
        "--rotate",
        "0,-90,0",
        "--rotate-uncertainty",
        "0.1,0.1,0.1",
        "--low-pass",
        "5",
        "--linear-phase",
        "--decimate",
        "5",
    ];
    let said = stderr(&succeed(&[&words[..], &steps, &COLUMNS].concat()));
    for part in [
        "steps: calibration; bias of ",
        "pitch -90°",
        "low-pass of linear phase",
        "one of 5 samples kept, 20.000000 Hz",
        "uncertainty by the bias",
        "uncertainty by the angles: at most",
        "all of it is taken out",
        "weaker by 6",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    // Gravity, along z of the sensor, is along −x of the machine; the bias is gone.
    let rows = std::fs::read_to_string(&out).unwrap();
    let mut count = 0;
    for line in rows.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
        assert!(
            (cells[1] + G).abs() < 2e-3 && cells[3].abs() < 2e-3,
            "{line}"
        );
        assert_eq!(cells[4] / 100.0, cells[0]);
        count += 1;
    }
    assert!(count > 300 && count < 400, "{count}");
    let beside = json(&folder.path().join("out.csv.provenance.json"));
    assert_eq!(beside["steps"].as_array().unwrap().len(), 5, "{beside}");
    let inputs = beside["inputs"].as_array().unwrap();
    assert!(inputs.iter().any(|i| i["path"] == text(&bias)), "{beside}");
}

#[test]
fn known_export_holds_rotation_low_pass_and_decimation() {
    let folder = tempfile::tempdir().unwrap();
    let calibration = calibration(folder.path(), "calibration.json");
    let export = |more: &[&str]| {
        let words = [&["export", text(&calibration), "--name", "board"], more].concat();
        String::from_utf8(succeed(&words).stdout).unwrap()
    };
    let chain = [
        "--rotate",
        "0,0,90",
        "--low-pass",
        "5",
        "--rate",
        "1000",
        "--decimate",
        "5",
    ];
    let c = export(&[&["--c"], &chain[..]].concat());
    assert!(c.contains("board_chain_step("), "{c}");
    assert!(
        c.contains("roll 0.000000, pitch 0.000000, yaw 90.000000 deg"),
        "{c}"
    );
    let rust = export(&[&["--rust"], &chain[..]].concat());
    assert!(
        rust.contains("Decimator::constant(low_pass::BOARD_LOW_PASS, 5)"),
        "{rust}"
    );
    let file = folder.path().join("chain.json");
    export(&[&["--json", "-o", text(&file)], &chain[..]].concat());
    let coefficients = json(&file);
    assert_eq!(coefficients["decimation"], 5);
    assert!(coefficients["low_pass"]["group_delay_s"].as_f64().unwrap() > 0.04);
    // x of the sensor is y of the machine.
    let inverse = &coefficients["K_inverse"];
    assert_eq!(inverse[1][0].as_f64().unwrap().round(), 1.0);
    assert!(inverse[0][0].as_f64().unwrap().abs() < 1e-15);
    let python = export(&["--python", "--rotate", "0,0,90"]);
    assert!(python.contains("yaw 90.000000 deg"), "{python}");
}

#[test]
fn refuses_steps_in_words_and_leaves_nothing_half_written() {
    let folder = tempfile::tempdir().unwrap();
    let calibration = calibration(folder.path(), "calibration.json");
    let recording = rest(folder.path());
    let bias = tracked(folder.path(), &recording);
    let out = folder.path().join("out.csv");
    let (cal, rec) = (text(&calibration), text(&recording));
    let apply = |calibration: &str, recording: &str, more: &[&str]| {
        let words = ["apply", calibration, recording, "-o", text(&out)];
        refuse(&[&words[..], more, &COLUMNS].concat())
    };
    let later = folder.path().join("later.csv");
    let table = std::fs::read_to_string(&recording).unwrap();
    let moved = table
        .lines()
        .enumerate()
        .map(|(i, line)| match line.split_once(',') {
            Some((t, rest)) if i > 0 => format!("{},{rest}\n", t.parse::<f64>().unwrap() + 15.0),
            _ => format!("{line}\n"),
        });
    std::fs::write(&later, moved.collect::<String>()).unwrap();
    let beyond = apply(cal, text(&later), &["--bias", text(&bias)]);
    assert!(beyond.contains("tracked from 0 s to 19.99 s"), "{beyond}");
    assert!(
        beyond.contains("later.csv:50") && beyond.contains("--between"),
        "{beyond}"
    );
    let two = apply(cal, rec, &["--bias", cal]);
    assert!(
        two.contains("is a calibration") && two.contains("one calibration"),
        "{two}"
    );
    let swapped = apply(text(&bias), rec, &[]);
    assert!(
        swapped.contains("a result without a calibration"),
        "{swapped}"
    );
    assert!(swapped.contains("--bias"), "{swapped}");
    for (more, words) in [
        (&["--decimate", "4"][..], "needs a low-pass"),
        (
            &["--low-pass", "5", "--decimate", "1"],
            "whole number from 2 on",
        ),
        (
            &["--low-pass", "5", "--decimate", "0"],
            "whole number from 2 on",
        ),
        (&["--low-pass", "50"], "not below half of the sampling rate"),
        (&["--rotate", "400,0,0"], "400°, more than a turn"),
        (&["--low-pass", "0.01"], "nothing is left"),
        (
            &["--low-pass", "5", "--attenuation", "500"],
            "20 dB to 160 dB",
        ),
    ] {
        let said = apply(cal, rec, more);
        assert!(said.contains(words), "{more:?}: {said}");
    }
    // What is no number is wrong use, in the words of the option.
    for more in [
        ["--rotate", "0,nan,0"],
        ["--rotate", "0,90"],
        ["--decimate", "2.5"],
        ["--low-pass", "-3"],
    ] {
        let words = [&["apply", cal, rec, "-o", text(&out)][..], &more, &COLUMNS].concat();
        let output = proofmass(&words);
        assert_eq!(
            output.status.code(),
            Some(2),
            "{more:?}: {}",
            stderr(&output)
        );
    }
    // A second calibration has no place.
    let second = proofmass(&["apply", cal, cal, rec, "-o", text(&out)]);
    assert_eq!(second.status.code(), Some(2), "{}", stderr(&second));
    assert!(!out.exists() && !folder.path().join("out.csv.provenance.json").exists());

    let export = |more: &[&str]| refuse(&[&["export", cal, "--c"], more].concat());
    let unsaid = export(&["--low-pass", "5"]);
    assert!(unsaid.contains("--rate"), "{unsaid}");
    let linear = [
        "--low-pass",
        "5",
        "--rate",
        "1000",
        "--linear-phase",
        "--decimate",
        "20",
    ];
    let linear = succeed(&[&["export", cal, "--c"][..], &linear].concat());
    let linear = String::from_utf8_lossy(&linear.stdout).into_owned();
    assert!(linear.contains("Low-pass of linear phase, ") && linear.contains("_chain_step("));
    assert!(linear.contains("Group delay at low frequency"), "{linear}");
    let of_bias = refuse(&[
        "export",
        text(&bias),
        "--c",
        "--low-pass",
        "5",
        "--rate",
        "1000",
    ]);
    assert!(of_bias.contains("steps follow a calibration"), "{of_bias}");
}

/// A drive: a rest, two accelerations and a braking on a straight road, of a sensor at these angles in degrees.
fn drive(folder: &Path, seed: u64, angles: [f64; 3]) -> PathBuf {
    let [r, p, y] = angles.map(f64::to_radians);
    let rows = [
        [
            y.cos() * p.cos(),
            y.cos() * p.sin() * r.sin() - y.sin() * r.cos(),
            y.cos() * p.sin() * r.cos() + y.sin() * r.sin(),
        ],
        [
            y.sin() * p.cos(),
            y.sin() * p.sin() * r.sin() + y.cos() * r.cos(),
            y.sin() * p.sin() * r.cos() - y.cos() * r.sin(),
        ],
        [-p.sin(), p.cos() * r.sin(), p.cos() * r.cos()],
    ];
    let mut noise = Chance(seed);
    let mut table = String::from("t_s,x_m/s2,y_m/s2,z_m/s2\n");
    for k in 0..3000 {
        let t = f64::from(k) / 100.0;
        let forward = match k {
            1000..1400 => 2.0,
            1700..2000 => -3.0,
            2300..2600 => 1.5,
            _ => 0.0,
        };
        let a = [
            forward,
            if forward == 0.0 {
                0.0
            } else {
                0.1 * noise.normal()
            },
            G,
        ];
        let own: [f64; 3] = std::array::from_fn(|j| (0..3).map(|i| rows[i][j] * a[i]).sum());
        let own = own.map(|v| v + 0.02 * noise.normal());
        let _ = writeln!(table, "{t},{},{},{}", own[0], own[1], own[2]);
    }
    let path = folder.join("drive.csv");
    std::fs::write(&path, table).unwrap();
    path
}

const STRETCHES: [&str; 8] = [
    "--rest",
    "0,9",
    "--forward",
    "10,14",
    "--braking",
    "17,20",
    "--forward",
    "23,26",
];

/// By gravity and travel: angles inside their intervals, and the recording turned by the result is one of the vehicle.
#[test]
fn coverage_mounting_by_the_command_and_its_use() {
    let folder = tempfile::tempdir().unwrap();
    let (mut inside, mut all) = (0, 0);
    let angles = [12.0, -35.0, 140.0];
    let out = folder.path().join("mounted");
    for seed in 1..=12 {
        let recording = drive(folder.path(), seed, angles);
        let words = [
            "test",
            "mounting",
            text(&recording),
            "-o",
            text(&out),
            "--force",
        ];
        succeed(&[&words[..], &STRETCHES, &COLUMNS, &["--levelling", "0.01"]].concat());
        let result = json(&out.join("result.json"));
        for (name, truth) in ["roll", "pitch", "yaw"].into_iter().zip(angles) {
            let (value, _, expanded) = quantity(&result, name);
            all += 1;
            inside += usize::from((value - truth.to_radians()).abs() <= expanded);
            assert!(expanded < 0.02, "{name}: {expanded}");
        }
    }
    // 36 intervals of 95 %: 30 and more (1e-3).
    assert!(inside >= 30, "{inside} of {all}");

    let recording = drive(folder.path(), 20, angles);
    let calibration = calibration(folder.path(), "calibration.json");
    let turned = folder.path().join("turned.csv");
    let result = out.join("result.json");
    let rotate = ["--rotate", text(&result)];
    let words = [
        "apply",
        text(&calibration),
        text(&recording),
        "-o",
        text(&turned),
    ];
    let done = succeed(&[&words[..], &rotate, &COLUMNS].concat());
    let said = String::from_utf8_lossy(&done.stdout).into_owned() + &stderr(&done);
    assert!(said.contains("as measured"), "{said}");
    assert!(said.contains("uncertainty by the angles"), "{said}");
    let mean = |of: std::ops::Range<usize>| -> [f64; 3] {
        let table = rows(&turned);
        let headings: Vec<String> = table[0].iter().map(|(h, _)| h.clone()).collect();
        let columns: Vec<&String> = headings.iter().filter(|h| !h.starts_with('t')).collect();
        std::array::from_fn(|i| {
            let sum: f64 = table[of.clone()]
                .iter()
                .map(|r| number(r, columns[i]))
                .sum();
            sum / of.len() as f64
        })
    };
    for (of, truth) in [
        (0..900, [0.0, 0.0, G]),
        (1000..1400, [2.0, 0.0, G]),
        (1700..2000, [-3.0, 0.0, G]),
    ] {
        let found = mean(of);
        for axis in 0..3 {
            assert!(
                (found[axis] - truth[axis]).abs() < 0.1,
                "{found:?} {truth:?}"
            );
        }
    }
    let header = succeed(&[&["export", text(&calibration), "--c"][..], &rotate].concat());
    let header = String::from_utf8_lossy(&header.stdout).into_owned();
    assert!(header.contains("In the frame of the machine"), "{header}");
    // The mounting is filed with both, and is not written over.
    assert!(
        header.contains("Turned by") && header.contains("result.json"),
        "{header}"
    );
    let beside = std::fs::read_to_string(folder.path().join("turned.csv.provenance.json"));
    assert!(beside.unwrap().contains("result.json"));

    // Beside typed uncertainties, of another result, and of a stretch that is not there.
    let both = [
        &words[..],
        &rotate,
        &COLUMNS,
        &["--rotate-uncertainty", "1,1,1", "--force"],
    ]
    .concat();
    assert!(refuse(&both).contains("leave out --rotate-uncertainty"));
    let other = ["--rotate", text(&calibration)];
    let other = refuse(&[&words[..], &other, &COLUMNS, &["--force"]].concat());
    assert!(other.contains("test mounting"), "{other}");
    let beyond = [
        "test",
        "mounting",
        text(&recording),
        "--rest",
        "0,9",
        "--forward",
        "100,120",
    ];
    assert!(refuse(&[&beyond[..], &COLUMNS].concat()).contains("the recording has"));
}
