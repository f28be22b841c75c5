//! `proofmass noise` on recordings with known coefficients and on bad ones.

use crate::support::*;
use std::fmt::Write as _;
use std::path::Path;

/// Gaussian numbers from SplitMix64 by Box and Muller: independent of the generators of the project.
struct Gaussian(u64);

impl Gaussian {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 * f64::EPSILON / 2.0
    }

    fn next(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

const RATE: f64 = 50.0;
const WHITE: f64 = 2.5e-3;
const WALK: f64 = 5.0e-4;

/// Two axes: white noise and random walk in x, white noise alone in y.
fn samples(n: usize) -> Vec<[f64; 2]> {
    let mut gaussian = Gaussian(20);
    let mut bias = 0.0;
    (0..n)
        .map(|_| {
            bias += WALK / RATE.sqrt() * gaussian.next();
            let x = 9.81 + bias + WHITE * RATE.sqrt() * gaussian.next();
            [x, WHITE * RATE.sqrt() * gaussian.next()]
        })
        .collect()
}

/// A recording with a time column; `time` gives the stamp of each row.
fn write(path: &Path, rows: &[[f64; 2]], time: impl Fn(usize) -> f64) {
    let mut lines = "time_s,acc_x_m/s2,acc_y_m/s2\n".to_owned();
    for (i, [x, y]) in rows.iter().enumerate() {
        writeln!(lines, "{:.3},{x:.9},{y:.9}", time(i)).unwrap();
    }
    std::fs::write(path, lines).unwrap();
}

fn steady(i: usize) -> f64 {
    i as f64 / RATE
}

fn codes(result: &serde_json::Value) -> Vec<&str> {
    let findings = result["findings"].as_array().unwrap();
    findings
        .iter()
        .map(|f| f["code"].as_str().unwrap())
        .collect()
}

/// The verdict on a term by maximum likelihood.
fn verdict<'a>(result: &'a serde_json::Value, channel: usize, term: &str) -> &'a serde_json::Value {
    let fit = &result["extra"]["noise"]["channels"][channel]["whittle"];
    let all = fit["coefficients"].as_array().expect("coefficients");
    let found = all.iter().find(|c| c["term"] == term);
    &found.unwrap_or_else(|| panic!("no {term}"))["verdict"]
}

fn assert_within(verdict: &serde_json::Value, truth: f64) {
    assert_eq!(verdict["verdict"], "identified", "{verdict}");
    let limit = |i: usize| verdict["interval"][i].as_f64().unwrap();
    assert!(limit(0) < truth && truth < limit(1), "{truth}: {verdict}");
    // 50 000 samples must give better than a factor of three, or the interval is no statement.
    assert!(limit(1) / limit(0) < 3.0, "{verdict}");
}

#[test]
fn known_coefficients_lie_in_their_intervals() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rest.csv");
    write(&path, &samples(50_000), steady);
    let out = folder.path().join("out");
    let yaml = folder.path().join("imu.yaml");
    let said = succeed(&[
        "noise",
        text(&path),
        "-o",
        text(&out),
        "--imu-yaml",
        text(&yaml),
    ]);
    assert!(holds_only(
        &out,
        &[
            "coefficients.csv",
            "deviation.csv",
            "imu.yaml",
            "kalibr_imu_chain.yaml",
            "manifest.json",
            "readings.csv",
            "report.html",
            "result.json",
            "spectrum.csv",
            "state_space.json"
        ]
    ));
    let result = json(&out.join("result.json"));
    assert_within(verdict(&result, 0, "white"), WHITE);
    assert_within(verdict(&result, 0, "random_walk"), WALK);
    assert_within(verdict(&result, 1, "white"), WHITE);
    for (channel, term) in [
        (0, "flicker"),
        (0, "quantisation"),
        (1, "flicker"),
        (1, "random_walk"),
        (1, "ramp"),
    ] {
        let v = verdict(&result, channel, term);
        assert_ne!(v["verdict"], "identified", "{channel} {term}: {v}");
    }
    let terminal = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(terminal.contains("not identifiable"), "{terminal}");
    assert!(!terminal.contains("NaN"), "{terminal}");
    let yaml = std::fs::read_to_string(yaml).unwrap();
    assert!(
        yaml.contains("accelerometer_noise_density: 2.")
            && yaml.contains("accelerometer_random_walk: ")
            && yaml.contains("rostopic: /imu0\nupdate_rate: 50.0")
            && yaml.contains("m/s^2/sqrt(Hz)"),
        "{yaml}"
    );
    // Stable names in the principal result.
    let white = result["quantities"]
        .as_array()
        .unwrap()
        .iter()
        .find(|q| q["name"] == "acc_x.N")
        .unwrap();
    let (value, u) = (
        white["value"].as_f64().unwrap(),
        white["U"].as_f64().unwrap(),
    );
    assert!(
        (value - WHITE).abs() < u && white["unit"] == "(m/s²)/√Hz",
        "{white}"
    );
    // The first row of x: overlapping Allan deviation at one sample, √(N²·rate) within 2 %.
    let csv = std::fs::read_to_string(out.join("deviation.csv")).unwrap();
    let fields: Vec<&str> = csv.lines().nth(1).unwrap().split(',').collect();
    assert_eq!(&fields[..3], ["acc_x", "m/s²", "OADEV"]);
    let deviation: f64 = fields[5].parse().unwrap();
    assert!((deviation / (WHITE * RATE.sqrt()) - 1.0).abs() < 0.02);
}

#[test]
fn counts_with_a_scale_give_the_same_coefficients() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("counts.csv");
    let scale = 1e-5;
    let mut lines = "acc_x\n".to_owned();
    for [x, _] in samples(50_000) {
        writeln!(lines, "{}", (x / scale).round()).unwrap();
    }
    std::fs::write(&path, lines).unwrap();
    let arguments = ["noise", text(&path), "--rate", "50", "--json"];
    let scaled = succeed(&[&arguments[..], &["--scale", "1e-5", "--unit", "m/s²"]].concat());
    let result: serde_json::Value = serde_json::from_slice(&scaled.stdout).unwrap();
    assert_within(verdict(&result, 0, "white"), WHITE);
    let raw = succeed(&[&arguments[..], &["--unit", "count"]].concat());
    let result: serde_json::Value = serde_json::from_slice(&raw.stdout).unwrap();
    assert_within(verdict(&result, 0, "white"), WHITE / scale);
    assert_eq!(result["extra"]["noise"]["channels"][0]["unit"], "count");
}

#[test]
fn a_constant_channel_is_a_finding_that_needs_a_decision() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dead.csv");
    let rows: Vec<[f64; 2]> = samples(2000).iter().map(|[x, _]| [*x, 0.5]).collect();
    write(&path, &rows, steady);
    let output = proofmass(&["noise", text(&path), "--json", "--strict"]);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(codes(&result).contains(&"constant-channel"));
    // The other channel is analysed as ever.
    assert_eq!(verdict(&result, 0, "white")["verdict"], "identified");
    let out = folder.path().join("out");
    succeed(&["noise", text(&path), "-o", text(&out)]);
}

#[test]
fn refuses_fewer_than_ten_samples() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("short.csv");
    write(&path, &samples(9), steady);
    let said = refuse(&["noise", text(&path)]);
    for word in ["10", "9", "short.csv", "hint:"] {
        assert!(said.contains(word), "{word:?} is missing from: {said}");
    }
    write(&path, &samples(12), steady);
    succeed(&["noise", text(&path)]);
}

/// Unit and clock are asked for in one refusal, and what is given is not asked for again.
#[test]
fn refuses_without_unit_and_clock_in_one_message() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bare.csv");
    let rows: String = samples(2000)
        .iter()
        .fold(String::new(), |mut rows, [x, y]| {
            let _ = writeln!(rows, "{x},{y},{}", 9.81 + x);
            rows
        });
    std::fs::write(&path, rows).unwrap();
    for stream in [&[][..], &["--stream"]] {
        let said = |options: &[&str]| refuse(&[&["noise", text(&path)], options, stream].concat());
        let all = said(&[]);
        assert!(
            all.contains("hint: add --unit ") && all.contains(" --rate HZ"),
            "{all}"
        );
        assert!(!said(&["--unit", "m/s2"]).contains("--unit"));
        assert!(!said(&["--rate", "50"]).contains("--rate"));
        succeed(
            &[
                &["noise", text(&path), "--unit", "m/s2", "--rate", "50"],
                stream,
            ]
            .concat(),
        );
    }
}

#[test]
fn a_missing_value_is_a_gap_and_damage_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("holes.csv");
    write(&path, &samples(2000), steady);
    let whole = std::fs::read_to_string(&path).unwrap();
    let with = |line: usize, row: &str| {
        let mut lines: Vec<&str> = whole.lines().collect();
        lines[line] = row;
        std::fs::write(&path, lines.join("\n")).unwrap();
    };
    with(1000, "19.980,NaN,");
    let output = succeed(&["noise", text(&path), "--json"]);
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(codes(&result).contains(&"gaps-in-record"));
    assert_eq!(result["extra"]["noise"]["channels"][0]["samples"], 1999);
    with(100, "1.980,rubbish,0.1");
    let out = folder.path().join("out");
    let said = refuse(&["noise", text(&path), "-o", text(&out)]);
    assert!(
        said.contains("holes.csv:101") && said.contains("hint:"),
        "{said}"
    );
    assert!(holds_only(folder.path(), &["holes.csv"]));
}

/// What the user says of terms, band and names reaches the fit.
#[test]
fn options_reach_the_fit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rest.csv");
    write(&path, &samples(20_000), steady);
    let output = succeed(&[
        "noise",
        text(&path),
        "--json",
        "--terms",
        "N,K",
        "--report-terms",
        "B",
        "--fix",
        "K=5e-4",
        "--highest-frequency",
        "20",
        "--segment",
        "512",
    ]);
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let fit = &result["extra"]["noise"]["channels"][0]["whittle"];
    assert_eq!(fit["band"]["highest_frequency"], 20.0);
    assert_eq!(fit["coefficients"].as_array().unwrap().len(), 3);
    assert_eq!(verdict(&result, 0, "random_walk")["verdict"], "fixed");
    // Asked for, and nothing there.
    assert_eq!(verdict(&result, 0, "flicker")["verdict"], "reported");
    let said = refuse(&["noise", text(&path), "--fix", "N=1e-3,N=2e-3"]);
    assert!(said.contains("N twice"), "{said}");
    for wrong in [["--terms", "X"], ["--fix", "N"], ["--report-terms", "Q,Z"]] {
        let output = proofmass(&[&["noise", text(&path)][..], &wrong[..]].concat());
        assert_eq!(output.status.code(), Some(2));
    }
}

/// Stamps that jitter by a fifth of the interval keep every sample.
#[test]
fn jittering_stamps_keep_every_sample() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("jitter.csv");
    let mut gaussian = Gaussian(3);
    // A fifth of the interval: some stamps lie before the one before them.
    let jitter: Vec<f64> = (0..20_000).map(|_| 0.2 * gaussian.next()).collect();
    assert!(jitter.windows(2).any(|w| w[1] - w[0] < -1.0));
    write(&path, &samples(20_000), |i| (i as f64 + jitter[i]) / RATE);
    for stream in [false, true] {
        let mut arguments = vec!["noise", text(&path), "--json"];
        arguments.extend(stream.then_some("--stream"));
        let output = succeed(&arguments);
        let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let analysis = &result["extra"]["noise"];
        assert_eq!(
            analysis["channels"][0]["samples"], 20_000,
            "stream {stream}"
        );
        let rate = analysis["sample_rate"].as_f64().unwrap();
        assert!((rate / RATE - 1.0).abs() < 1e-4, "{rate}");
    }
}

#[test]
fn time_stamps_that_jump_are_gaps_and_never_bridged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("jump.csv");
    let rows = samples(3000);
    write(&path, &rows, |i| {
        steady(i) + if i < 1000 { 0.0 } else { 7.0 }
    });
    let output = succeed(&["noise", text(&path), "--json"]);
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(codes(&result).contains(&"gaps-in-record"));
    let analysis = &result["extra"]["noise"];
    assert_eq!(
        analysis["stretches"],
        serde_json::json!([[0, 1000], [1000, 3000]])
    );
    assert_eq!(analysis["channels"][0]["samples"], 3000);
    refuse(&["noise", text(&path), "--refuse-gaps"]);
    // A clock that runs backwards is no gap but an error.
    write(&path, &rows, |i| {
        steady(i) - if i < 1000 { 0.0 } else { 7.0 }
    });
    let said = refuse(&["noise", text(&path)]);
    assert!(said.contains("jump.csv:1002"), "{said}");
}

/// The stream sees what memory sees: the same curve, and coefficients in the same intervals.
#[test]
fn a_stream_gives_the_same_curve_and_coefficients() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rest.csv");
    write(&path, &samples(50_000), steady);
    let run = |arguments: &[&str]| -> serde_json::Value {
        let output = succeed(&[&["noise", text(&path), "--json"], arguments].concat());
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let (memory, stream) = (run(&[]), run(&["--stream"]));
    // A stream does not state yet how it was read.
    for key in ["path", "sha256"] {
        assert_eq!(stream["inputs"][0][key], memory["inputs"][0][key]);
    }
    for channel in 0..2 {
        assert_within(verdict(&stream, channel, "white"), WHITE);
        let points = |r: &serde_json::Value| {
            r["extra"]["noise"]["channels"][channel]["curve"]["points"].clone()
        };
        for k in 0..4 {
            let deviation = |r| points(r)[k]["deviation"].as_f64().unwrap();
            assert!((deviation(&stream) / deviation(&memory) - 1.0).abs() < 1e-9);
        }
        // Same mean and scatter, though never held as a whole.
        for key in ["mean", "standard_deviation"] {
            let value = |r: &serde_json::Value| {
                r["extra"]["noise"]["channels"][channel][key]
                    .as_f64()
                    .unwrap()
            };
            assert!((value(&stream) - value(&memory)).abs() < 1e-9);
        }
    }
    assert_within(verdict(&stream, 0, "random_walk"), WALK);
    // What a stream does not have is refused, not left out.
    let said = refuse(&["noise", text(&path), "--stream", "--statistic", "mdev"]);
    assert!(said.contains("OADEV"), "{said}");
}

#[test]
fn a_stream_leaves_gaps_out_and_refuses_a_clock_that_runs_backwards() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("jump.csv");
    let rows = samples(3000);
    write(&path, &rows, |i| {
        steady(i) + if i < 1000 { 0.0 } else { 7.0 }
    });
    let output = succeed(&["noise", text(&path), "--stream", "--json"]);
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(codes(&result).contains(&"gaps-in-record"));
    let noise = &result["extra"]["noise"];
    assert!((noise["sample_rate"].as_f64().unwrap() / RATE - 1.0).abs() < 1e-6);
    assert_eq!(noise["channels"][0]["samples"], 3000);
    refuse(&["noise", text(&path), "--stream", "--refuse-gaps"]);
    write(&path, &rows, |i| {
        steady(i) - if i < 1000 { 0.0 } else { 7.0 }
    });
    let said = refuse(&["noise", text(&path), "--stream"]);
    assert!(said.contains("jump.csv:1002"), "{said}");
}

/// Velocities give the noise of the acceleration, in memory and as a stream.
#[test]
fn integrated_data_are_differenced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("velocity.csv");
    let mut lines = "time_s,v_x_m/s\n".to_owned();
    let mut velocity = 0.0;
    for (i, [x, _]) in samples(50_000).iter().enumerate() {
        velocity += (x - 9.81) / RATE;
        writeln!(lines, "{:.3},{velocity:.12}", steady(i)).unwrap();
    }
    std::fs::write(&path, lines).unwrap();
    for more in [&[][..], &["--stream"]] {
        let output = succeed(&[&["noise", text(&path), "--phase", "--json"], more].concat());
        let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(result["extra"]["noise"]["channels"][0]["unit"], "m/s²");
        assert_within(verdict(&result, 0, "white"), WHITE);
        assert_within(verdict(&result, 0, "random_walk"), WALK);
    }
}

#[test]
fn averaging_times_and_statistics_are_chosen_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rest.csv");
    write(&path, &samples(2000), steady);
    let out = folder.path().join("out");
    let arguments = [
        "noise",
        text(&path),
        "-o",
        text(&out),
        "--statistic",
        "oadev,mdev,hdev",
    ];
    succeed(&[&arguments[..], &["--taus", "0.1,1,10"]].concat());
    let csv = std::fs::read_to_string(out.join("deviation.csv")).unwrap();
    let rows: Vec<Vec<&str>> = csv
        .lines()
        .skip(1)
        .map(|l| l.split(',').collect())
        .collect();
    assert_eq!(rows.len(), 2 * 3 * 3);
    for statistic in ["OADEV", "MDEV", "HDEV"] {
        let taus: Vec<f64> = rows
            .iter()
            .filter(|r| r[0] == "acc_y" && r[2] == statistic)
            .map(|r| r[4].parse().unwrap())
            .collect();
        // The rate is read from stamps of a millisecond.
        assert_eq!(taus.len(), 3);
        for (tau, asked) in taus.iter().zip([0.1, 1.0, 10.0]) {
            assert!((tau / asked - 1.0).abs() < 1e-9, "{tau}");
        }
    }
    // 40 s of samples have no averaging time of 30 s, and 0.03 s is no whole number of intervals.
    for tau in ["30", "0.03"] {
        let said = refuse(&["noise", text(&path), "--taus", tau]);
        for word in ["tau", tau, "20", "hint:"] {
            assert!(said.contains(word), "{word:?} is missing from: {said}");
        }
    }
    let wrong = proofmass(&["noise", text(&path), "--taus", "often"]);
    assert_eq!(wrong.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&wrong.stderr).contains("octave"));
}

#[test]
fn law_the_folder_of_the_input_keeps_it() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("rest.csv");
    let rows: String = (0..2000)
        .map(|i| format!("{},{}\n", f64::from(i) * 0.01, (i * 7919) % 13))
        .collect();
    std::fs::write(&path, format!("time_s,a_m/s2\n{rows}")).expect("recording");
    let before = std::fs::read(&path).expect("recording");
    let said = refuse(&["noise", text(&path), "-o", text(folder.path())]);
    assert!(said.contains("not empty"), "{said}");
    succeed(&["noise", text(&path), "-o", text(folder.path()), "--force"]);
    assert!(folder.path().join("result.json").is_file());
    assert_eq!(std::fs::read(&path).expect("recording"), before);
}
