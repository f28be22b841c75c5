//! Digital sensors with files of their own, delays of a front end, and several frequencies in one recording.

use crate::support::*;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

const FREQUENCIES: [f64; 5] = [20.0, 40.0, 80.0, 160.0, 315.0];
/// Sampling rate of the bench, Hz.
const BENCH: f64 = 5000.0;
const CERTIFICATE: &str = "frequency_Hz,sensitivity_mV/(m/s2),phase_deg,U_relative_%,U_phase_deg\n10,10,0,0.4,0.3\n1000,10,0,0.4,0.3\n";

fn single(folder: &Path, recording: &str, runs: &str) {
    campaign(
        folder,
        &format!(
            "kind = \"shaker-single\"\n[runs]\nfile = \"runs.csv\"\n[recording]\nformat = \"f32\"\nsampling_rate_Hz = {BENCH}\n\
             full_scale_V = 1\n{recording}\n[reference]\nfile = \"reference.csv\"\nk = 2\n[reading]\nu_relative = 0.001\nu_phase_deg = 0.1\n"
        ),
    );
    std::fs::write(folder.join("runs.csv"), runs).unwrap();
    std::fs::write(folder.join("reference.csv"), CERTIFICATE).unwrap();
}

fn floats(folder: &Path, name: &str, channels: &[Vec<f64>]) {
    let bytes: Vec<u8> = (0..channels[0].len())
        .flat_map(|i| {
            channels
                .iter()
                .flat_map(move |c| (c[i] as f32).to_le_bytes())
        })
        .collect();
    std::fs::write(folder.join(name), bytes).unwrap();
}

/// 10 m/s² at each frequency; a sensor of 100 counts per m/s² and 3.3 ms that is `fast` by its own clock, or sampled at uneven
/// steps with stamps that are `fast`.
fn sensor(folder: &Path, clock: &str, fast: f64) {
    let mut noise = Chance(3);
    let own = clock == "own";
    let mut runs = "run,frequency_Hz,transverse_%,file,output_file\n".to_owned();
    for (i, f) in FREQUENCIES.into_iter().enumerate() {
        let turn = TAU * f * (1.0 + 2e-5);
        let reference = (0..5000)
            .map(|k| 0.1 * (turn * f64::from(k) / BENCH + 0.3).cos() + 1e-5 * noise.normal());
        floats(folder, &format!("r{i}.f32"), &[reference.collect()]);
        let rate = if own { 2000.0 * (1.0 + fast) } else { 2000.0 };
        let begin = if own { 0.37 * i as f64 } else { 1e-4 };
        let mut text = if own {
            "acc\n".to_owned()
        } else {
            "time_s,acc\n".to_owned()
        };
        for k in 0..2000 {
            let late = if own {
                0.0
            } else {
                0.03 * noise.normal() / rate
            };
            let t = begin + f64::from(k) / rate + late;
            let count = 1000.0 * (turn * (t - 3.3e-3) + 0.3).cos() + 5000.0 + noise.normal();
            if !own {
                write!(text, "{:.7},", t * (1.0 + fast)).unwrap();
            }
            writeln!(text, "{}", count.round()).unwrap();
        }
        std::fs::write(folder.join(format!("s{i}.csv")), text).unwrap();
        writeln!(runs, "a{i},{f},1,r{i}.f32,s{i}.csv").unwrap();
    }
    let time = if own {
        "sampling_rate_Hz = 2000"
    } else {
        "time = \"time_s\""
    };
    let recording = format!(
        "channels = {{ reference = 1 }}\n[output_recording]\nclock = \"{clock}\"\nunit = \"count\"\n{time}\nchannels = {{ output = \"acc\" }}"
    );
    single(folder, &recording, &runs);
}

#[test]
fn known_sensitivity_of_a_sensor_with_a_clock_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    sensor(folder.path(), "own", 0.02);
    succeed(&["calibrate", text(folder.path())]);
    let out = folder.path().join("result");
    let result = json(&out.join("result.json"));
    assert_eq!(
        codes(&result),
        ["reference-gap", "repeatability-unseen", "own-clock"],
        "{result}"
    );
    for f in FREQUENCIES {
        let (s, _, expanded) = quantity(&result, &format!("S.modulus[frequency={f}]"));
        assert!((s - 100.0).abs() < 0.1 && expanded > 0.4, "{s} {expanded}");
    }
    let (ppm, u, _) = quantity(&result, "clock.error");
    assert!((ppm - 20_000.0).abs() < 4.0 * u && u < 1.0, "{ppm} {u}");
    assert!(!result.to_string().contains("S.phase"));
    // Without a phase there is nothing to compensate with.
    assert!(!out.join("calibration.json").exists());
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("Clock of the sensor"));
    succeed(&["render", text(&out)]);
    assert_eq!(
        page,
        std::fs::read_to_string(out.join("report.html")).unwrap()
    );
}

#[test]
fn known_delay_of_a_sensor_that_the_bench_stamps() {
    let folder = tempfile::tempdir().unwrap();
    sensor(folder.path(), "shared", 0.0);
    succeed(&["calibrate", text(folder.path())]);
    let out = folder.path().join("result");
    let result = json(&out.join("result.json"));
    assert_eq!(
        codes(&result),
        ["reference-gap", "uneven-stamps", "repeatability-unseen"],
        "{result}"
    );
    let (delay, _, expanded) = quantity(&result, "delay");
    assert!(
        (delay - 3.3e-3).abs() < expanded && expanded < 2e-5,
        "{delay} {expanded}"
    );
    let (phase, _, _) = quantity(&result, "S.phase[frequency=20]");
    // The delay stays in the phase.
    assert!((phase + TAU * 20.0 * 3.3e-3).abs() < 2e-3, "{phase}");
    assert!(out.join("calibration.json").exists());
    // Said to be one clock, and is none.
    sensor(folder.path(), "shared", 1e-3);
    succeed(&["calibrate", text(folder.path())]);
    let result = json(&out.join("result.json"));
    assert!(
        codes(&result).contains(&"clocks-differ".to_owned()),
        "{result}"
    );
}

/// All tones at once, or one after another with a pause, of a device of 10 mV/(m/s²) whose channel is 0.1 ms late.
fn several(folder: &Path, drive: &str, list: &str) {
    let mut noise = Chance(5);
    let wave = |f: f64, k: usize, late: f64| {
        let t = k as f64 / BENCH;
        0.02 * (TAU * f * (1.0 + 5e-5) * (t - late) + f).cos()
    };
    let mut channels = vec![vec![], vec![]];
    for (c, late) in [(0, 0.0), (1, 1e-4)] {
        if drive == "stepped" {
            for f in FREQUENCIES {
                channels[c].extend((0..5000).map(|k| wave(f, k, late)));
                channels[c].extend([0.0; 500]);
            }
        } else {
            let sum = |k| FREQUENCIES.map(|f| wave(f, k, late)).iter().sum::<f64>();
            channels[c].extend((0..10_000).map(sum));
        }
        for v in &mut channels[c] {
            *v += 2e-6 * noise.normal();
        }
    }
    floats(folder, "r.f32", &channels);
    let recording = format!(
        "drive = \"{drive}\"\nchannels = {{ reference = 1, output = 2 }}\ndelays = {{ output = {{ delay_s = 1e-4, u_s = 1e-5 }} }}"
    );
    single(
        folder,
        &recording,
        &format!("run,frequency_Hz,transverse_%,file\na,{list},1,r.f32\n"),
    );
}

#[test]
fn known_sensitivity_of_several_frequencies_in_one_recording() {
    for drive in ["multi-sine", "stepped"] {
        let folder = tempfile::tempdir().unwrap();
        several(folder.path(), drive, "20 40 80 160 315");
        succeed(&["calibrate", text(folder.path())]);
        let out = folder.path().join("result");
        let result = json(&out.join("result.json"));
        assert_eq!(
            codes(&result),
            ["reference-gap", "repeatability-unseen"],
            "{result}"
        );
        for f in FREQUENCIES {
            let (s, _, _) = quantity(&result, &format!("S.modulus[frequency={f}]"));
            assert!((s / 0.01 - 1.0).abs() < 2e-4, "{drive} {f}: {s}");
            let (phase, u, _) = quantity(&result, &format!("S.phase[frequency={f}]"));
            assert!(phase.abs() < 5e-4, "{drive} {f}: {phase}");
            // 0.15° of the certificate, 0.1° of a reading, 10 µs of the front end.
            let due = (0.15f64.powi(2) + 0.1f64.powi(2)).sqrt().to_radians();
            let due = due.hypot(TAU * f * 1e-5);
            assert!((u / due - 1.0).abs() < 1e-3, "{u} {due}");
        }
        several(folder.path(), drive, "20 40 80 100 160 315");
        succeed(&["calibrate", text(folder.path())]);
        let result = json(&out.join("result.json"));
        assert_eq!(
            codes(&result),
            ["tone-missing", "reference-gap", "repeatability-unseen"],
            "{result}"
        );
        // The name of the row stands for all of its frequencies.
        let toml = folder.path().join("campaign.toml");
        let old = std::fs::read_to_string(&toml).unwrap();
        std::fs::write(
            &toml,
            old.replace("\"runs.csv\"", "\"runs.csv\"\nexclude = [\"a@100\"]"),
        )
        .unwrap();
        succeed(&["calibrate", text(folder.path())]);
    }
    let folder = tempfile::tempdir().unwrap();
    several(folder.path(), "multi-sine", "20 40 80 160 160.4 315");
    succeed(&["calibrate", text(folder.path())]);
    let result = json(&folder.path().join("result/result.json"));
    assert_eq!(
        codes(&result),
        [
            "tones-unresolved",
            "tones-unresolved",
            "reference-gap",
            "repeatability-unseen"
        ],
        "{result}"
    );
}

#[test]
fn refuses_what_a_file_of_its_own_cannot_be() {
    let folder = tempfile::tempdir().unwrap();
    let toml = folder.path().join("campaign.toml");
    let fresh = || sensor(folder.path(), "own", 0.02);
    let say = || refuse(&["calibrate", text(folder.path())]);
    for (from, to, word) in [
        ("clock = \"own\"", "clock = \"mine\"", "own"),
        ("unit = \"count\"", "unit = \"degC\"", "no °C"),
        (
            "sampling_rate_Hz = 2000",
            "sampling_rate_Hz = 0",
            "positive",
        ),
        ("sampling_rate_Hz = 2000", "sampling_rate_Hz = 900", "8.8"),
        (
            "output = \"acc\"",
            "output = \"acceleration\"",
            "acceleration",
        ),
        ("output = \"acc\"", "reference = \"acc\"", "bench"),
        ("output = \"acc\"", "z = \"acc\"", "unknown channel"),
        (
            "[output_recording]",
            "[output_recordings]",
            "output_recording",
        ),
        (
            "[recording]",
            "[recording]\ndrive = \"swept\"",
            "swept sine",
        ),
        (
            "[recording]",
            "[recording]\ndelays = { output = { delay_s = 1 } }",
            "delays.output",
        ),
        (
            "[recording]",
            "[recording]\ndelays = { reference = { delay_s = nan } }",
            "delays.reference",
        ),
    ] {
        fresh();
        let old = std::fs::read_to_string(&toml).unwrap();
        assert!(old.contains(from));
        std::fs::write(&toml, old.replace(from, to)).unwrap();
        let said = say();
        assert!(said.contains(word), "{to}: {said}");
        assert!(said.contains("hint"), "{to}: {said}");
    }
    let file = folder.path().join("s2.csv");
    for (content, word) in [
        ("", "s2.csv"),
        ("acc\n", "s2.csv"),
        ("acc\n1\n2\n", "s2.csv"),
        ("acc\n1\nnan\n3\n", "s2.csv:3"),
    ] {
        fresh();
        std::fs::write(&file, content).unwrap();
        let said = say();
        assert!(said.contains(word), "{content:?}: {said}");
    }
    // A constant, and one period alone.
    for counts in [vec![7; 2000], [1, 2, 1, 0].repeat(7)] {
        fresh();
        let lines: String = counts.iter().map(|c| format!("{c}\n")).collect();
        std::fs::write(&file, format!("acc\n{lines}")).unwrap();
        let said = say();
        assert!(said.contains("s2.csv"), "{said}");
    }
    // Time that runs back, and times of another day.
    sensor(folder.path(), "shared", 0.0);
    let old = std::fs::read_to_string(&file).unwrap();
    let mut lines: Vec<&str> = old.lines().collect();
    lines.swap(100, 101);
    std::fs::write(&file, lines.join("\n")).unwrap();
    assert!(say().contains("backwards"));
    let later: String = old
        .lines()
        .map(|l| match l.split_once(',') {
            Some((t, v)) if t != "time_s" => {
                format!("{},{v}\n", t.parse::<f64>().unwrap() + 1000.0)
            }
            _ => format!("{l}\n"),
        })
        .collect();
    std::fs::write(&file, later).unwrap();
    assert!(say().contains("after the bench"), "{}", say());
    // Files without their description, and the other way about.
    fresh();
    let runs = folder.path().join("runs.csv");
    let table = std::fs::read_to_string(&runs).unwrap();
    std::fs::write(&runs, table.replace("s3.csv", "s2.csv")).unwrap();
    assert!(say().contains("a recording of its own"));
    std::fs::write(&runs, table.replace("40,1", "40 60,1")).unwrap();
    assert!(say().contains("multi-sine"));
    std::fs::write(&runs, table.replace("40,1", "40 x,1")).unwrap();
    assert!(say().contains("runs.csv:3"));
    let plain = table.lines().map(|l| l.rsplit_once(',').unwrap().0);
    std::fs::write(&runs, plain.collect::<Vec<_>>().join("\n")).unwrap();
    assert!(say().contains("output_file"));
    assert!(!folder.path().join("result").exists());
}

/// The simulated triaxial device as a sensor with files of its own, against its truth.
fn simulated(folder: &Path, more: &[&str]) -> (serde_json::Value, serde_json::Value) {
    let place = folder.join("campaign");
    let head = [
        "simulate",
        "shaker",
        "--output",
        text(&place),
        "--frequencies",
        "80,160",
    ];
    let small = [
        "--configurations",
        "16",
        "--duration",
        "0.5",
        "--sampling-rate",
        "10000",
    ];
    succeed(&[&head[..], &small, more].concat());
    succeed(&["calibrate", text(&place)]);
    (
        json(&place.join("truth.json")),
        json(&place.join("result/result.json")),
    )
}

#[test]
fn coverage_of_the_truth_by_a_triaxial_sensor_with_files_of_its_own() {
    for clock in ["own", "shared"] {
        let folder = tempfile::tempdir().unwrap();
        let (truth, result) = simulated(folder.path(), &["--sensor", clock]);
        let scale = truth["sensor"]["counts_per_V"].as_f64().unwrap();
        let mut inside = 0;
        for at in truth["frequencies"].as_array().unwrap() {
            let f = at["frequency_Hz"].as_f64().unwrap();
            for (i, a) in ["x", "y", "z"].iter().enumerate() {
                for (j, b) in ["x", "y", "z"].iter().enumerate() {
                    let s = &at["S_V_per_m_per_s2"][i][j];
                    let size = s[0].as_f64().unwrap().hypot(s[1].as_f64().unwrap());
                    let name = format!("S.{a}{b}.modulus[frequency={f}]");
                    let (value, _, expanded) = quantity(&result, &name);
                    let off = (value - scale * size).abs();
                    assert!(off < 2.2 * expanded, "{clock} {name}: {off} {expanded}");
                    inside += usize::from(off < expanded);
                }
            }
        }
        // 18 at 95 %: fewer than 13 by chance in 2e-4 were they independent.
        assert!(inside >= 13, "{clock}: {inside}");
        let (ppm, u, _) = quantity(&result, "clock.error");
        let due = truth["sensor"]["clock_error_ppm"].as_f64().unwrap();
        assert!((ppm - due).abs() < 5.0 * u.max(0.02), "{clock}: {ppm} {u}");
        if clock == "shared" {
            let (delay, u, _) = quantity(&result, "delay");
            // The phases of the device itself are small beside it.
            assert!((delay - 1.7e-3).abs() < 5.0 * u.max(5e-5), "{delay} {u}");
        }
        let grave: Vec<&str> = result["findings"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|f| f["severity"] == "decision")
            .filter_map(|f| f["code"].as_str())
            .collect();
        assert!(grave.is_empty(), "{clock}: {grave:?}");
    }
}

#[test]
fn law_several_frequencies_of_a_triaxial_campaign_come_from_one_recording() {
    for drive in ["multi-sine", "stepped"] {
        let folder = tempfile::tempdir().unwrap();
        let (_, result) = simulated(folder.path(), &["--drive", drive]);
        let (_, alone) = simulated(&folder.path().join("alone"), &[]);
        for f in [80, 160] {
            for term in ["xx", "yy", "zz", "xy"] {
                let name = format!("S.{term}.modulus[frequency={f}]");
                let (a, u, _) = quantity(&result, &name);
                let (b, ..) = quantity(&alone, &name);
                // The same phasors, once one by one.
                assert!((a - b).abs() < 0.3 * u, "{drive} {name}: {a} {b} {u}");
            }
        }
    }
}
