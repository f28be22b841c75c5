//! `proofmass velocity` and `proofmass simulate axis`: estimates, comparisons, gains and maps of simulated axes; bad files.

use crate::support::axis::*;
use crate::support::*;
use std::fmt::Write as _;
use std::path::Path;

#[test]
fn an_estimate_holds_the_truth_in_its_intervals() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(folder.path(), &["--motion", "motor", "--duration", "4"]);
    let out = folder.path().join("out");
    let result = estimate(
        &place.join("recording.csv"),
        &out,
        &[&SENSORS[..], &["--at-rest"]].concat(),
    );
    assert!(holds_only(
        &out,
        &[
            "manifest.json",
            "report.html",
            "result.json",
            "velocity.csv"
        ]
    ));
    let truth = column(&place.join("truth.csv"), "velocity_m/s");
    let table = out.join("velocity.csv");
    let (v, u) = (
        column(&table, "velocity_m/s"),
        column(&table, "standard_uncertainty_m/s"),
    );
    // 0.02 m/s² of noise and increments of 0.94 mm against a velocity of 0.65 m/s amplitude.
    assert!(rms(&v, &truth, 500) < 0.002, "{}", rms(&v, &truth, 500));
    let smoothed = column(&table, "smoothed_m/s");
    assert!(rms(&smoothed, &truth, 500) < 0.001);
    let inside = (500..v.len())
        .filter(|&k| (v[k] - truth[k]).abs() < 2.5 * u[k])
        .count() as f64
        / (v.len() - 500) as f64;
    // Samples are correlated over some 0.1 s: 35 independent ones; two and a half σ hold 98.8 %.
    assert!(inside > 0.85, "{inside}");
    let gain = result["extra"]["pairing"]["gain"].as_f64().unwrap();
    assert!((gain - 1.0).abs() < 0.01, "{gain}");
    assert!(!codes(&result).iter().any(|c| c == "slip"));
}

/// An accelerometer and a reference in milliseconds beside an encoder in seconds: what is stated holds for the files that do not say it.
#[test]
fn known_time_unit_is_that_of_the_files_without_one() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(folder.path(), &["--duration", "3"]);
    let (first, truth) = (place.join("recording.csv"), place.join("truth.csv"));
    let table = |name: &str, header: &str, scale: f64, values: Vec<f64>| {
        let mut rows = format!("{header}\n");
        for (t, v) in column(&first, "time_s").iter().zip(values) {
            rows += &format!("{:.6},{v}\n", scale * t);
        }
        let path = folder.path().join(name);
        std::fs::write(&path, rows).unwrap();
        path
    };
    let measured = || column(&first, "acceleration_m/s2");
    let second = table("acc_ms.csv", "timestamp,a_m/s2", 1e3, measured());
    let known = table("acc_s.csv", "time_s,a_m/s2", 1.0, measured());
    let velocity = column(&truth, "velocity_m/s");
    let reference = table("ref_ms.csv", "timestamp,v", 1e3, velocity);
    let sensors = |acceleration: &Path, more: &[&str]| {
        let mut all = run("compare", &first, &SENSORS[..6]);
        let file = [
            "--acceleration",
            "a",
            "--acceleration-file",
            text(acceleration),
        ];
        all.extend(file.iter().chain(more).map(|w| (*w).to_owned()));
        all
    };
    let of = |all: Vec<String>| refuse(&all.iter().map(String::as_str).collect::<Vec<_>>());
    let asked = of(sensors(&second, &[]));
    assert!(asked.contains("--time-unit ms"), "{asked}");
    assert!(asked.contains("--acceleration-rate HZ"), "{asked}");
    let out = folder.path().join("out");
    let beside = ["--reference", "v", "--reference-file", text(&reference)];
    let asked = of(sensors(&known, &beside));
    assert!(asked.contains("--reference-rate HZ"), "{asked}");
    let stated = [
        "--reference-unit",
        "m/s",
        "--time-unit",
        "ms",
        "-o",
        text(&out),
    ];
    let all = sensors(&second, &[&beside[..], &stated].concat());
    succeed(&all.iter().map(String::as_str).collect::<Vec<_>>());
    let result = json(&out.join("result.json"));
    let read = |name: &str| {
        let inputs = result["inputs"].as_array().unwrap();
        let path = |i: &&serde_json::Value| i["path"].as_str().unwrap().ends_with(name);
        inputs.iter().find(path).unwrap()["reading"].clone()
    };
    assert_eq!(read("recording.csv")["time"]["by"], "heading");
    for name in ["acc_ms.csv", "ref_ms.csv"] {
        let time = &read(name)["time"];
        assert_eq!(
            (&time["unit"], &time["by"]),
            (&"ms".into(), &"person".into())
        );
        assert!(
            (time["rate_hz"].as_f64().unwrap() - 1000.0).abs() < 1e-6,
            "{time}"
        );
    }
    let column = &read("ref_ms.csv")["columns"][0];
    assert_eq!(
        (&column["unit"], &column["unit_by"]),
        (&"m/s".into(), &"person".into())
    );
    // Where every heading says it, another unit contradicts.
    let refused = of(sensors(&known, &["--time-unit", "ms"]));
    assert!(
        refused.contains("the heading says s, ms is stated"),
        "{refused}"
    );
}

#[test]
fn a_comparison_at_three_rates_shows_the_fused_methods_ahead() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(folder.path(), &[]);
    let out = folder.path().join("out");
    let truth = place.join("truth.csv");
    let mut all = run("compare", &place.join("recording.csv"), &SENSORS);
    all.extend(
        [
            "--reference",
            "velocity",
            "--reference-file",
            text(&truth),
            "--rates",
            "1000,100,20",
            "-o",
            text(&out),
        ]
        .map(str::to_owned),
    );
    let all: Vec<&str> = all.iter().map(String::as_str).collect();
    succeed(&all);
    assert!(holds_only(
        &out,
        &[
            "errors.csv",
            "manifest.json",
            "report.html",
            "result.json",
            "velocities.csv"
        ]
    ));
    let result = json(&out.join("result.json"));
    assert_eq!(result["extra"]["reference_is_truth"], true);
    let rows = rows(&out.join("errors.csv"));
    for rate in [1000.0, 100.0, 20.0] {
        let best = |sensors: &[&str], tuned: bool| {
            rows.iter()
                .filter(|r| (number(r, "rate_Hz") / rate - 1.0).abs() < 1e-6)
                .filter(|r| sensors.contains(&field(r, "sensors")))
                .filter(|r| !tuned || field(r, "method").starts_with("Kalman"))
                .map(|r| number(r, "rms_m/s"))
                .fold(f64::INFINITY, f64::min)
        };
        let single = best(&["position", "acceleration"], false);
        let fused = best(&["fused"], true);
        assert!(fused < 0.7 * single, "{rate}: {fused} {single}");
    }
    // Without a reference the smoother stands in, and it is said.
    let output = succeed(
        &run("compare", &place.join("recording.csv"), &SENSORS)
            .iter()
            .map(String::as_str)
            .chain(["--json", "--rates", "100"])
            .collect::<Vec<_>>(),
    );
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(codes(&result).iter().any(|c| c == "smoother-as-reference"));
    let said = refuse(
        &run("compare", &place.join("recording.csv"), &SENSORS)
            .iter()
            .map(String::as_str)
            .chain(["--rates", "300"])
            .collect::<Vec<_>>(),
    );
    assert!(said.contains("333.33") && said.contains("250"), "{said}");
}

#[test]
fn tuning_finds_the_noise_that_was_put_in() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(folder.path(), &["--noise", "0.3", "--motion", "motor"]);
    let out = folder.path().join("out");
    let mut all = run("tune", &place.join("recording.csv"), &SENSORS);
    all.extend(["-o".to_owned(), text(&out).to_owned()]);
    let all: Vec<&str> = all.iter().map(String::as_str).collect();
    succeed(&all);
    assert!(holds_only(
        &out,
        &[
            "likelihood.csv",
            "manifest.json",
            "quantities.csv",
            "report.html",
            "result.json"
        ]
    ));
    let result = json(&out.join("result.json"));
    let model = &result["extra"]["model"];
    let q = model["acceleration_noise"].as_f64().unwrap();
    // q of 5000 samples seen through increments of 0.94 mm: its 95 % interval is some ±25 %; twice that.
    assert!((q.sqrt() / 0.3 - 1.0).abs() < 0.3, "{q}");
    let r = model["reading_noise"].as_f64().unwrap();
    let delta = 0.3 * std::f64::consts::TAU / 2000.0;
    assert!((r * 12.0 / (delta * delta) - 1.0).abs() < 0.2, "{r}");
}

#[test]
fn a_wrong_unit_is_a_finding_that_needs_a_decision() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(folder.path(), &["--motion", "motor", "--duration", "3"]);
    let recording = place.join("recording.csv");
    let text_of = std::fs::read_to_string(&recording).unwrap();
    let in_g: String = text_of
        .lines()
        .map(|line| match line.rsplit_once(',') {
            Some((head, a)) if !a.contains('a') => {
                format!("{head},{:.6}\n", a.parse::<f64>().unwrap() / 9.80665)
            }
            _ => format!("{line}\n"),
        })
        .collect();
    std::fs::write(&recording, in_g).unwrap();
    let all = run(
        "estimate",
        &recording,
        &[&SENSORS[..], &["--json", "--strict"]].concat(),
    );
    let output = proofmass(&all.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let findings = result["findings"].as_array().unwrap();
    let found = findings.iter().find(|f| f["code"] == "unit-suspected");
    let what = found.expect("unit-suspected")["what"].as_str().unwrap();
    assert!(what.contains("in g"), "{what}");
}

#[test]
fn bad_files_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(folder.path(), &["--duration", "1"]);
    let good = std::fs::read_to_string(place.join("recording.csv")).unwrap();
    let path = folder.path().join("bad.csv");
    let out = folder.path().join("out");
    let said = |lines: &[String]| {
        std::fs::write(&path, lines.join("\n")).unwrap();
        let mut all = run("estimate", &path, &SENSORS);
        all.extend(["-o".to_owned(), text(&out).to_owned()]);
        let said = refuse(&all.iter().map(String::as_str).collect::<Vec<_>>());
        assert!(said.contains("hint:"), "{said}");
        assert!(!out.exists(), "{said}");
        said
    };
    let lines: Vec<String> = good.lines().map(str::to_owned).collect();
    let with = |at: usize, line: &str| {
        let mut lines = lines.clone();
        lines[at] = line.to_owned();
        lines
    };
    assert!(said(&[]).contains("bad.csv"));
    assert!(said(&lines[..1]).contains("bad.csv"));
    assert!(said(&lines[..4]).contains("bad.csv"));
    // Cut off within a row.
    let mut cut = lines[..500].to_vec();
    cut[499].truncate(4);
    assert!(said(&cut).contains("bad.csv:500"));
    for (line, word) in [
        ("0.199,12,NaN", "NaN"),
        ("0.199,12,inf", "inf"),
        ("0.199,x,0.1", "x"),
        ("0.099,12,0.1", "backwards"),
        ("0.198,12,0.1", "repeats"),
        ("0.199,12.5,0.1", "12.5"),
    ] {
        let said = said(&with(200, line));
        assert!(
            said.contains("bad.csv:201") && said.contains(word),
            "{line}: {said}"
        );
    }
    // A unit that is no acceleration, a column that is not there.
    let renamed = |heading: &str| with(0, heading);
    let volts = said(&renamed("time_s,encoder_count,acceleration_V"));
    assert!(
        volts.contains("V") && volts.contains("calibration"),
        "{volts}"
    );
    let bare = said(&renamed("time_s,encoder_count,acceleration"));
    assert!(bare.contains("--acceleration-unit"), "{bare}");
    let other = said(&renamed("time_s,encoder_count,accel_m/s2"));
    assert!(other.contains("accel_m/s2"), "{other}");
}

#[test]
fn dead_channels_need_a_decision_and_a_standstill_cannot_be_tuned() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dead.csv");
    let mut lines = "time_s,encoder_count,acceleration_m/s2\n".to_owned();
    for k in 0..2000 {
        writeln!(lines, "{:.3},{},0.5", 0.001 * f64::from(k), k / 3).unwrap();
    }
    std::fs::write(&path, lines).unwrap();
    let all = run(
        "estimate",
        &path,
        &[&SENSORS[..], &["--json", "--strict"]].concat(),
    );
    let output = proofmass(&all.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(codes(&result).iter().any(|c| c == "constant-channel"));
    let place = axis(
        folder.path(),
        &["--motion", "standstill", "--duration", "2"],
    );
    let recording = place.join("recording.csv");
    let out = folder.path().join("out");
    let result = estimate(&recording, &out, &[&SENSORS[..], &["--at-rest"]].concat());
    assert!(codes(&result).iter().any(|c| c == "readings-never-change"));
    let v = column(&out.join("velocity.csv"), "smoothed_m/s");
    assert!(v.iter().all(|v| v.abs() < 0.01));
    let all = run("tune", &recording, &SENSORS);
    let said = refuse(&all.iter().map(String::as_str).collect::<Vec<_>>());
    assert!(said.contains("standstill"), "{said}");
}

/// One corrupted word in four seconds: left out and told, the velocity stays where it was.
#[test]
fn law_a_glitch_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(folder.path(), &["--motion", "motor", "--duration", "4"]);
    let recording = place.join("recording.csv");
    let lines = std::fs::read_to_string(&recording).unwrap();
    let bad: String = lines
        .lines()
        .enumerate()
        .map(|(k, line)| {
            let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
            if k == 2001 {
                let count: i64 = fields[1].parse().unwrap();
                fields[1] = (count ^ 0x100).to_string();
            }
            fields.join(",") + "\n"
        })
        .collect();
    std::fs::write(&recording, bad).unwrap();
    let out = folder.path().join("out");
    let result = estimate(&recording, &out, &[&SENSORS[..], &["--at-rest"]].concat());
    let found = codes(&result);
    assert!(found.iter().any(|c| c == "glitches"), "{found:?}");
    assert!(!found.iter().any(|c| c == "slip"), "{found:?}");
    let truth = column(&place.join("truth.csv"), "velocity_m/s");
    let v = column(&out.join("velocity.csv"), "velocity_m/s");
    assert!(rms(&v, &truth, 500) < 0.002, "{}", rms(&v, &truth, 500));
}

#[test]
fn law_a_map_that_is_subtracted_is_not_found_again() {
    let temporary = tempfile::tempdir().expect("a folder");
    let folder = temporary.path();
    // A wheel of 2 cm swings through several turns on a disc that is 0.02 rad off its axis.
    let place = axis(
        folder,
        &[
            "--radius",
            "0.02",
            "--eccentricity",
            "0.02",
            "--duration",
            "4",
        ],
    );
    let recording = place.join("recording.csv");
    let mut sensors = SENSORS.to_vec();
    sensors[5] = "0.02";
    let ask = |question: &str, more: &[&str]| {
        let mut all = vec!["velocity", question, text(&recording)];
        all.extend(&sensors);
        all.extend(more);
        all.into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let run = |arguments: Vec<String>| {
        let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
        succeed(&words);
    };
    let (first, second) = (folder.join("first"), folder.join("second"));
    run(ask("map", &["--orders", "1,2", "-o", text(&first)]));
    let result = first.join("result.json");
    let (amplitude, u, _) = quantity(&json(&result), "amplitude.1");
    assert!((amplitude - 4e-4).abs() < 4.0 * u, "{amplitude} {u}");
    run(ask(
        "map",
        &[
            "--orders",
            "1,2",
            // The folder stands for the result in it.
            "--encoder-map",
            text(&first),
            "-o",
            text(&second),
        ],
    ));
    let left = json(&second.join("result.json"));
    assert_eq!(left["quantities"].as_array().map(Vec::len), Some(0));
    // Equal quarters are no line.
    let third = folder.join("third");
    run(ask(
        "map",
        &["--orders", "1", "--quarters", "-o", text(&third)],
    ));
    let quarters = json(&third.join("result.json"));
    assert_eq!(quarters["quantities"].as_array().map(Vec::len), Some(1));
    assert!(
        std::fs::read_to_string(third.join("lines.csv"))
            .unwrap()
            .contains("\n500.0,")
    );
    // Another file is no map, and a map of lengths none of angles.
    let mut wrong = ask("estimate", &["--encoder-map", text(&recording)]);
    let words: Vec<&str> = wrong.iter().map(String::as_str).collect();
    assert!(refuse(&words).contains("velocity map"));
    wrong.pop();
    wrong.extend([text(&result).to_owned(), "--angular".to_owned()]);
    let words: Vec<&str> = wrong.iter().map(String::as_str).collect();
    assert!(refuse(&words).contains("the map is in m"));
}

/// The table of rules of docs/velocity.md is that of the program, and the choice is one that `estimate` takes.
#[test]
fn known_rules_and_the_choice_of_an_integrator() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("choice");
    let task = [
        "velocity",
        "integrator",
        "--band",
        "2,40",
        "--rate",
        "200",
        "--bias",
        "0.02",
        "--noise",
        "1e-3",
        "--speed",
        "0.5",
    ];
    let kept = ["--error", "0.01", "-o", text(&out)];
    let said = succeed(&[&task[..], &kept].concat());
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(said.contains("tick-zero-phase:"), "{said}");
    let page = include_str!("data/velocity.md");
    for row in rows(&out.join("rules.csv")) {
        let accuracy =
            ["5", "15", "30", "45", "60"].map(|s| number(&row, &format!("accuracy_{s}_%")));
        let accuracy = accuracy.map(|a| format!("{a:.4}")).join(" | ");
        let pole = field(&row, "next_pole_Nyquist");
        let pole = pole
            .parse::<f64>()
            .map_or("–".to_owned(), |p| format!("{p:.2}"));
        let line = format!(
            "| {} | {:.0} | {accuracy} | {:.3} | {pole} |",
            field(&row, "rule"),
            number(&row, "steps"),
            number(&row, "noise_walk")
        );
        assert!(page.contains(&line), "{line}");
    }
    // Ranked by their total; on line none that is run backward.
    let ranked = rows(&out.join("integrators.csv"));
    let totals: Vec<f64> = ranked.iter().map(|r| number(r, "total_m/s")).collect();
    assert!(
        totals.len() > 15 && totals.windows(2).all(|w| w[0] <= w[1]),
        "{totals:?}"
    );
    let method = field(&ranked[0], "method").to_owned();
    let on_line = succeed(&[&task[..], &["--on-line", "--json"]].concat());
    let on_line: serde_json::Value = serde_json::from_slice(&on_line.stdout).unwrap();
    let designs = on_line["extra"]["ranked"].as_array().unwrap();
    assert!(designs.iter().all(|d| d["high_pass"]["zero_phase"] != true));
    // A rule by itself is one of them; its bias grows with the time.
    let plain = designs.iter().find(|d| d["high_pass"].is_null()).unwrap();
    let bias = plain["bias"].as_f64().unwrap();
    assert!((bias - 0.02 * 60.0 / 3f64.sqrt()).abs() < 1e-9, "{bias}");
    // The word is one that a recording of the accelerometer alone takes.
    let mut table = String::from("t_s,a_m/s2\n");
    for k in 0..4000 {
        let t = f64::from(k) / 200.0;
        let moves = f64::from(u8::from(t > 2.0));
        table += &format!(
            "{t},{}\n",
            moves * 0.5 * 62.83 * (62.83 * (t - 2.0)).cos() + 0.02
        );
    }
    let recording = folder.path().join("a.csv");
    std::fs::write(&recording, table).unwrap();
    let run = folder.path().join("run");
    let words = [
        "velocity",
        "estimate",
        text(&recording),
        "--acceleration",
        "a",
        "--still",
        "0,1.9",
    ];
    succeed(&[&words[..], &["--method", &method, "-o", text(&run)]].concat());
    let refused = refuse(
        &[
            &task[..4],
            &[
                "--rate", "70", "--bias", "0", "--noise", "0", "--speed", "1",
            ],
        ]
        .concat(),
    );
    assert!(refused.contains("0.49 of the sampling rate"), "{refused}");
}

/// With an encoder the velocity is bounded; the place follows the length of a count.
#[test]
fn known_drift_beside_an_encoder() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("drift");
    let words = [
        "velocity",
        "drift",
        "--noise",
        "0.02",
        "--rate",
        "1000",
        "--offset-uncertainty",
        "0.05",
        "--speed",
        "2",
        "--times",
        "60,1",
        "--encoder-increment",
        "1e-3",
        "--encoder-scale-uncertainty",
        "0.1",
        "-o",
        text(&out),
    ];
    let said = succeed(&words);
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(said.contains("With the encoder: U ="), "{said}");
    let table = rows(&out.join("drift.csv"));
    let of = |row: usize, name: &str| number(&table[row], name);
    assert!(of(0, "standard_uncertainty_m/s") > 2.9);
    let beside = of(0, "u_drift_beside_encoder_m/s");
    assert!((2e-3..3e-3).contains(&beside), "{beside}");
    // A thousandth of sixty metres.
    let place = of(0, "u_place_beside_encoder_m");
    assert!((place - 0.06).abs() < 1e-3, "{place}");
    let unsaid = refuse(&[
        "velocity",
        "drift",
        "--offset",
        "1",
        "--encoder-increment",
        "1e-3",
    ]);
    assert!(unsaid.contains("--encoder-rate"), "{unsaid}");
}

/// Counts with their index in a column: three are lost, and put back; the position is zero at the pulse.
#[test]
fn known_counts_put_back_at_the_index() {
    let folder = tempfile::tempdir().unwrap();
    let write = |lost: i64| {
        let mut noise = Chance(3);
        let mut table = String::from("t_s,count,z,a_m/s2\n");
        for k in 0..6000 {
            let t = f64::from(k) / 1000.0;
            // Two turns there and back.
            let w = std::f64::consts::TAU / 6.0;
            let turns = 1.2 * (1.0 - (w * t).cos());
            let count = (400.0 * turns).floor() as i64;
            let z = u8::from((count - 100).rem_euclid(400) < 4);
            let shown = if t > 1.5 { count - lost } else { count };
            let a = 1.2 * w * w * (w * t).cos() * std::f64::consts::TAU * 0.05;
            table += &format!("{t},{shown},{z},{}\n", a + 0.02 * noise.normal());
        }
        let path = folder.path().join("axis.csv");
        std::fs::write(&path, table).unwrap();
        path
    };
    let out = folder.path().join("out");
    let run = |lost: i64, more: &[&str]| -> serde_json::Value {
        let recording = write(lost);
        let words = [
            "velocity",
            "estimate",
            text(&recording),
            "--position",
            "count",
            "--counts-per-turn",
            "400",
            "--radius",
            "0.05",
            "--index",
            "z",
            "--acceleration",
            "a",
            "--force",
            "-o",
            text(&out),
        ];
        succeed(&[&words[..], more].concat());
        json(&out.join("result.json"))
    };
    let healthy = run(0, &[]);
    assert!(codes(&healthy).iter().any(|c| c == "zero-at-index"));
    assert!(!codes(&healthy).iter().any(|c| c == "counts-put-back"));
    let truth = column(&out.join("velocity.csv"), "smoothed_m/s");
    let lost = run(3, &[]);
    let findings = lost["findings"].as_array().unwrap();
    let told = findings
        .iter()
        .find(|f| f["code"] == "counts-put-back")
        .unwrap();
    assert!(told.to_string().contains("3 lost before"), "{told}");
    let found = column(&out.join("velocity.csv"), "smoothed_m/s");
    let worst = found
        .iter()
        .zip(&truth)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    assert!(worst < 0.01, "{worst}");
    let recording = write(0);
    let wrong = [
        "velocity",
        "estimate",
        text(&recording),
        "--position",
        "count",
        "--counts-per-turn",
        "400.5",
        "--radius",
        "0.05",
        "--index",
        "z",
    ];
    assert!(refuse(&wrong).contains("no whole number"));
}

/// A counter of twelve bits that rolls over: what is said of it can be typed, and --wraps is about angles.
#[test]
fn known_options_of_a_counter_that_rolls_over() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("axis.csv");
    let mut text = String::from("time_s,enc,acc_m/s2\n");
    for k in 0..4000 {
        let t = 1e-3 * f64::from(k);
        let count = (9000.0 + 6000.0 * (2.0 * t).sin()).floor() as i64 % 4096;
        let wobble = 0.01 * f64::from(k * 7919 % 101 - 50) / 50.0;
        let a = -6000.0 * 4.0 * (2.0 * t).sin() / 8192.0 + wobble;
        writeln!(text, "{t:.3},{count},{a:.4}").unwrap();
    }
    std::fs::write(&file, text).unwrap();
    let scale = ["--position", "enc", "--counts-per-metre", "8192"];
    let out = folder.path().join("out");
    let result = estimate(
        &file,
        &out,
        &[&scale[..], &["--acceleration", "acc"]].concat(),
    );
    let found = result["findings"].as_array().unwrap();
    let told = found.iter().find(|f| f["code"] == "rollover-suspected");
    let told = told.expect("rollover-suspected").to_string();
    assert!(told.contains("--bits 12"), "{told}");
    let result = estimate(
        &file,
        &out,
        &[&scale[..], &["--acceleration", "acc", "--bits", "12"]].concat(),
    );
    assert!(!codes(&result).iter().any(|c| c == "rollover-suspected"));
    let mut all = run("estimate", &file, &scale);
    all.push("--wraps".to_owned());
    let said = refuse(&all.iter().map(String::as_str).collect::<Vec<_>>());
    assert!(said.contains("--wraps is about angles"), "{said}");
    // Nothing is named: the columns are offered.
    let all = run("estimate", &file, &[]);
    let said = refuse(&all.iter().map(String::as_str).collect::<Vec<_>>());
    assert!(said.contains("--position enc --acceleration acc"), "{said}");
    let all = run(
        "estimate",
        &file,
        &[&scale[..], &["--between", "10", "20"]].concat(),
    );
    let said = refuse(&all.iter().map(String::as_str).collect::<Vec<_>>());
    assert!(said.contains("the last time is 3.999 s"), "{said}");
}

/// The speed that is stated is that of the method that was asked for, at the sample where the smoother is fastest.
#[test]
fn law_the_stated_speed_is_that_of_the_method() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(folder.path(), &["--motion", "motor", "--duration", "4"]);
    let recording = place.join("recording.csv");
    let out = folder.path().join("out");
    let of = |with: &[&str], columns: [&str; 2]| {
        let result = estimate(&recording, &out, &[&SENSORS[..], with].concat());
        let largest = &result["quantities"][0];
        assert_eq!(largest["name"], "largest_speed");
        let stated = largest["value"].as_f64().unwrap();
        let end = |i: usize| largest["interval"][i].as_f64().unwrap();
        let table = out.join("velocity.csv");
        let smoothed = column(&table, "smoothed_m/s");
        let u = column(&table, "smoothed_standard_uncertainty_m/s");
        let sure = |k: &usize| smoothed[*k].abs() - 2.0 * u[*k];
        let at = (0..u.len())
            .max_by(|i, j| sure(i).total_cmp(&sure(j)))
            .unwrap();
        let (v, u) = (
            column(&table, columns[0])[at],
            column(&table, columns[1])[at],
        );
        // The table is rounded to a hundredth of its smallest uncertainty.
        assert!((stated - v.abs()).abs() < 0.02 * u, "{stated} {v} {u}");
        // Below by the factor of all samples that may be the fastest, above by that of one and more.
        let (below, above) = ((stated - end(0)) / u, (end(1) - stated) / u);
        assert!((1.95..5.0).contains(&below), "{below}");
        assert!(above > 1.94, "{above}");
        result["extra"]["largest_speed_by"]
            .as_str()
            .unwrap()
            .to_owned()
    };
    let by = of(
        &["--method", "savitzky-golay:9,2"],
        ["velocity_m/s", "standard_uncertainty_m/s"],
    );
    assert!(by.contains("the method asked for"), "{by}");
    let by = of(&[], ["smoothed_m/s", "smoothed_standard_uncertainty_m/s"]);
    assert!(by.contains("the smoother"), "{by}");
}

/// A tuning that somebody wrote into is refused, and the field is named.
#[test]
fn refuses_a_tuning_that_was_changed() {
    let folder = tempfile::tempdir().unwrap();
    let place = axis(folder.path(), &["--motion", "motor", "--duration", "2"]);
    let out = folder.path().join("tuned");
    let mut all = run("tune", &place.join("recording.csv"), &SENSORS);
    let more = ["--low-corner", "0.05", "-o", text(&out)];
    all.extend(more.map(str::to_owned));
    succeed(&all.iter().map(String::as_str).collect::<Vec<_>>());
    let sound = json(&out.join("result.json"));
    let changed = folder.path().join("changed.json");
    let export = |field: &[&str], value: serde_json::Value| {
        let mut other = sound.clone();
        let gains = &mut other["extra"]["gains"];
        *field.iter().fold(gains, |at, key| &mut at[*key]) = value;
        std::fs::write(&changed, other.to_string()).unwrap();
        refuse(&["export", text(&changed), "--c"])
    };
    for (field, value) in [
        (&["low_corner", "order"][..], serde_json::json!(3)),
        (&["low_corner", "frequency"][..], serde_json::json!(1e5)),
        (&["low_corner", "uncertainty"][..], serde_json::json!(-1.0)),
        (&["sample_time"][..], serde_json::json!(-1.0)),
        (&["observer", "k_x"][..], serde_json::json!(-3.0)),
    ] {
        let said = export(field, value);
        let name = match field[0] {
            "observer" => "gains.observer".to_owned(),
            _ => format!("gains.{}", field.join(".")),
        };
        assert!(said.contains(&name), "{said}");
    }
    succeed(&["export", text(&out.join("result.json")), "--c"]);
}

/// The map tells what the estimate tells of a sensor that is dead, and of one that is the other way round.
#[test]
fn law_a_map_tells_dead_and_reversed_accelerometers() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--duration", "8", "--radius", "0.02"];
    let place = axis(folder.path(), &arguments);
    let recording = place.join("recording.csv");
    let lines = std::fs::read_to_string(&recording).unwrap();
    let with = |change: &dyn Fn(f64) -> f64| -> String {
        let row = |(k, line): (usize, &str)| {
            let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
            if k > 0 {
                fields[2] = change(fields[2].parse().unwrap()).to_string();
            }
            fields.join(",") + "\n"
        };
        lines.lines().enumerate().map(row).collect()
    };
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
    for (change, said) in [
        (&(|_| 0.1) as &dyn Fn(f64) -> f64, "constant-channel"),
        (&|a: f64| -a, "--reverse"),
    ] {
        std::fs::write(&recording, with(change)).unwrap();
        let all = run("map", &recording, &sensors);
        let output = proofmass(&all.iter().map(String::as_str).collect::<Vec<_>>());
        let shown = [&output.stdout[..], &output.stderr[..]].concat();
        let shown = String::from_utf8_lossy(&shown).into_owned();
        assert!(shown.contains(said), "{said}: {shown}");
    }
}
