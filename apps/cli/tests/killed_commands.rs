//! Commands that are killed, run into a full disk or into each other: results are the old ones or the new ones, inputs stay as
//! they are, and after the next run nothing else is left.
//!
//! `PROOFMASS_KILLS` sets how often each of the eleven commands is killed (docs/outputs.md tells what came of it).

#![cfg(unix)]

mod support;

use proofmass::io::{Input, Manifest, Provenance};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use support::*;

fn kills() -> u32 {
    let stated = std::env::var("PROOFMASS_KILLS").ok();
    stated.and_then(|n| n.parse().ok()).unwrap_or(12)
}

/// Instants that differ from run to run of the loop and not from run to run of the test.
struct Instants(u64);

impl Instants {
    fn up_to(&mut self, longest: Duration) -> Duration {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        longest.mul_f64((self.0 >> 33) as f64 / (1_u64 << 31) as f64)
    }
}

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_proofmass"));
    command
        .args(arguments)
        .env("SOURCE_DATE_EPOCH", "1790000000")
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    command
}

/// Digest of every file, folders within included.
fn digests(folder: &Path, all: &mut BTreeMap<PathBuf, String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            digests(&path, all);
        } else {
            all.insert(path.clone(), Input::of(&path).unwrap().sha256);
        }
    }
}

/// Kills a command again and again; `is_whole` looks at what stands there after each kill and says whether it differs from
/// before. The next run then leaves `expected` names in the folder and the inputs as they were.
fn killed(
    folder: &Path,
    inputs: &Path,
    commands: &[Vec<&str>],
    expected: &[&str],
    is_whole: impl Fn(),
) {
    let mut before = BTreeMap::new();
    digests(inputs, &mut before);
    let mut longest = Duration::ZERO;
    for arguments in commands {
        let began = Instant::now();
        assert!(
            command(arguments).status().unwrap().success(),
            "{arguments:?}"
        );
        longest = longest.max(began.elapsed());
    }
    let mut instants = Instants(7);
    let (mut ended, mut litter) = (0, 0);
    for number in 0..kills() {
        let arguments = &commands[number as usize % commands.len()];
        let mut child = command(arguments).spawn().unwrap();
        // Most of what can go wrong goes wrong at the end.
        let part = if number % 2 == 0 { 1.1 } else { 0.3 };
        let late = longest.mul_f64(1.1 - part);
        std::thread::sleep(late + instants.up_to(longest.mul_f64(part)));
        child.kill().unwrap();
        ended += u32::from(child.wait().unwrap().success());
        is_whole();
        litter += u32::from(names(folder) != expected);
        // The next run, every few kills: litter of several must go at once.
        if number % 4 == 3 || number + 1 == kills() {
            assert!(
                command(arguments).status().unwrap().success(),
                "{arguments:?}"
            );
            is_whole();
            assert_eq!(names(folder), expected);
        }
    }
    let mut after = BTreeMap::new();
    digests(inputs, &mut after);
    assert_eq!(before, after, "an input was touched");
    println!(
        "{}: {} kills, {ended} of them too late; litter until the next run {litter} times",
        commands[0][0],
        kills()
    );
}

/// Every listed file stands there as it was written.
fn is_one_result(folder: &Path) {
    let manifest = Manifest::read(folder).unwrap().unwrap();
    for file in &manifest.files {
        assert!(
            file.is_unchanged(folder),
            "{} of {}",
            file.name,
            folder.display()
        );
    }
    assert!(
        !folder.join(".proofmass-complete").exists() || names(folder).len() > manifest.files.len()
    );
}

fn example(folder: &Path) -> PathBuf {
    let inputs = folder.join("inputs");
    fs::create_dir(&inputs).unwrap();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hand-held");
    for name in ["campaign.toml", "recording.csv"] {
        fs::copy(example.join(name), inputs.join(name)).unwrap();
    }
    inputs
}

#[test]
fn law_calibrate_is_killed() {
    let above = tempfile::tempdir().unwrap();
    let inputs = example(above.path());
    let out = above.path().join("result");
    let arguments = vec!["calibrate", text(&inputs), "-o", text(&out)];
    killed(
        above.path(),
        &inputs,
        &[arguments],
        &["inputs", "result"],
        || is_one_result(&out),
    );
}

#[test]
fn law_apply_is_killed() {
    let above = tempfile::tempdir().unwrap();
    let inputs = example(above.path());
    let out = above.path().join("result");
    succeed(&["calibrate", text(&inputs), "-o", text(&out)]);
    fs::rename(
        out.join("calibration.json"),
        inputs.join("calibration.json"),
    )
    .unwrap();
    fs::remove_dir_all(&out).unwrap();
    // Two recordings into one file: it is one or the other.
    let lines = fs::read_to_string(inputs.join("recording.csv")).unwrap();
    let half: Vec<&str> = lines.lines().take(2000).collect();
    fs::write(inputs.join("short.csv"), half.join("\n") + "\n").unwrap();
    let (calibration, long, short) = (
        inputs.join("calibration.json"),
        inputs.join("recording.csv"),
        inputs.join("short.csv"),
    );
    let file = above.path().join("out.csv");
    let apply = |recording| vec!["apply", text(&calibration), recording, "-o", text(&file)];
    let mut known = Vec::new();
    for recording in [&long, &short] {
        succeed(&apply(text(recording)));
        known.push(Input::of(&file).unwrap().sha256);
    }
    killed(
        above.path(),
        &inputs,
        &[apply(text(&long)), apply(text(&short))],
        &["inputs", "out.csv", "out.csv.provenance.json"],
        || {
            assert!(known.contains(&Input::of(&file).unwrap().sha256));
            let provenance = Provenance::of(&file).unwrap().unwrap();
            assert!(known.contains(&provenance.sha256));
        },
    );
}

#[test]
fn law_simulate_is_killed() {
    let above = tempfile::tempdir().unwrap();
    let inputs = above.path().join("inputs");
    fs::create_dir(&inputs).unwrap();
    let out = above.path().join("campaign");
    let arguments = vec!["simulate", "multi-position", "-o", text(&out)];
    killed(
        above.path(),
        &inputs,
        &[arguments],
        &["campaign", "inputs"],
        || is_one_result(&out),
    );
}

#[test]
fn law_noise_is_killed() {
    let above = tempfile::tempdir().unwrap();
    let inputs = example(above.path());
    let out = above.path().join("result");
    let recording = inputs.join("recording.csv");
    let arguments = vec!["noise", text(&recording), "-o", text(&out)];
    // A file of somebody in the folder: the files change places one by one, and a killed run is completed by the next.
    succeed(&arguments);
    fs::write(out.join("notes.txt"), "mine").unwrap();
    killed(
        above.path(),
        &inputs,
        &[arguments],
        &["inputs", "result"],
        || assert_eq!(fs::read_to_string(out.join("notes.txt")).unwrap(), "mine"),
    );
    is_one_result(&out);
    assert!(!names(&out).iter().any(|n| n.starts_with('.')));
}

/// A folder of results from each of `uncertainty`, `plan`, `validate` and `render`.
#[test]
fn law_other_commands_with_a_folder_are_killed() {
    let model = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/data/uncertainty/mass.toml"
    );
    for command in ["uncertainty", "plan", "validate", "render"] {
        let above = tempfile::tempdir().unwrap();
        let inputs = example(above.path());
        let out = above.path().join("result");
        succeed(&["calibrate", text(&inputs), "-o", text(&out)]);
        for name in ["calibration.json", "result.json"] {
            fs::rename(out.join(name), inputs.join(name)).unwrap();
        }
        fs::remove_dir_all(&out).unwrap();
        let place = |name: &str| text(&inputs.join(name)).to_owned();
        let given = match command {
            "uncertainty" => vec![model.to_owned()],
            "plan" => vec![text(&inputs).to_owned()],
            "validate" => vec![place("calibration.json"), place("recording.csv")],
            _ => vec![place("result.json")],
        };
        let mut arguments = vec![command];
        arguments.extend(given.iter().map(String::as_str));
        arguments.extend(["-o", text(&out)]);
        killed(
            above.path(),
            &inputs,
            &[arguments],
            &["inputs", "result"],
            || is_one_result(&out),
        );
    }
}

/// A file from each of `export` and `import`: it is one or the other.
#[test]
fn law_other_commands_with_a_file_are_killed() {
    for command in ["export", "import"] {
        let above = tempfile::tempdir().unwrap();
        let inputs = example(above.path());
        let result = inputs.join("result");
        succeed(&["calibrate", text(&inputs)]);
        let calibration = result.join("calibration.json");
        let coefficients = inputs.join("six.txt");
        fs::write(&coefficients, "0.1 0.2 0.3\n100 101 102\n").unwrap();
        let file = above.path().join("out");
        let (given, forms) = match command {
            "export" => (&calibration, ["--rust", "--c"]),
            _ => (&coefficients, ["--unit=count", "--unit=V"]),
        };
        let commands = forms.map(|form| {
            let mut arguments = vec![command, text(given), form, "-o", text(&file)];
            if command == "import" {
                arguments.extend(["--form", "six-parameters"]);
            }
            arguments
        });
        let known = commands.each_ref().map(|arguments| {
            succeed(arguments);
            Input::of(&file).unwrap().sha256
        });
        assert_ne!(known[0], known[1]);
        killed(above.path(), &inputs, &commands, &["inputs", "out"], || {
            assert!(known.contains(&Input::of(&file).unwrap().sha256))
        });
    }
}

#[test]
fn law_convert_is_killed() {
    let above = tempfile::tempdir().unwrap();
    let inputs = example(above.path());
    let (recording, file) = (inputs.join("recording.csv"), above.path().join("out"));
    // A file of two forms: it is one or the other.
    let commands = ["--to=csv", "--to=uff"]
        .map(|form| vec!["convert", text(&recording), form, "-o", text(&file)]);
    let known = commands.each_ref().map(|arguments| {
        succeed(arguments);
        Input::of(&file).unwrap().sha256
    });
    assert_ne!(known[0], known[1]);
    let expected = ["inputs", "out", "out.provenance.json"];
    killed(above.path(), &inputs, &commands, &expected, || {
        assert!(known.contains(&Input::of(&file).unwrap().sha256));
        let provenance = Provenance::of(&file).unwrap().unwrap();
        assert!(known.contains(&provenance.sha256));
    });
}

/// The exit code tells the signal, as a shell does.
#[test]
fn known_exit_codes_of_signals() {
    let above = tempfile::tempdir().unwrap();
    example(above.path());
    let out = above.path().join("result");
    for (signal, code) in [("INT", 130), ("TERM", 143), ("HUP", 129)] {
        // A recording that does not end: the pipe stays open until the signal has come.
        let mut child = Command::new(env!("CARGO_BIN_EXE_proofmass"))
            .args(["noise", "-", "-o", text(&out)])
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // Waiting would close it.
        let pipe = child.stdin.take();
        // Signals are taken once the folder is begun.
        let began = Instant::now();
        while names(above.path()) == ["inputs"] && began.elapsed() < Duration::from_secs(30) {
            std::thread::sleep(Duration::from_millis(5));
        }
        let sent = Command::new("kill")
            .args(["-s", signal, &child.id().to_string()])
            .status()
            .unwrap();
        assert!(sent.success());
        assert_eq!(child.wait().unwrap().code(), Some(code), "{signal}");
        drop(pipe);
        assert_eq!(names(above.path()), ["inputs"], "{signal}");
    }
}

/// A system that gives no threads is an error and no panic.
#[test]
fn refuses_to_calculate_without_threads() {
    let above = tempfile::tempdir().unwrap();
    let inputs = example(above.path());
    let program = env!("CARGO_BIN_EXE_proofmass");
    // Room for the program and not for the stacks of many threads; what is left when the last stack does not fit is room enough for an
    // error.
    let script = format!(
        "ulimit -v 2000000; exec {program} calibrate {}",
        text(&inputs)
    );
    let output = Command::new("sh")
        .args(["-c", &script])
        .env("RAYON_NUM_THREADS", "2000")
        .env("RUST_MIN_STACK", "268435456")
        .output()
        .unwrap();
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("no threads to calculate with"), "{said}");
    assert!(!said.contains("panicked"), "{said}");
    assert_eq!(names(&inputs), ["campaign.toml", "recording.csv"]);
}

/// Trials for which there is no memory are refused before the first is made.
#[test]
fn refuses_trials_without_memory() {
    let above = tempfile::tempdir().unwrap();
    let model = above.path().join("model.toml");
    let input = "[[input]]\nname = \"x\"\nunit = \"1\"\nvalue = 1\nu = 0.1\n";
    let output = "[[output]]\nname = \"y\"\nunit = \"1\"\nexpression = \"x\"\n";
    std::fs::write(&model, format!("{input}{output}")).unwrap();
    let program = env!("CARGO_BIN_EXE_proofmass");
    let script = format!(
        "ulimit -v 700000; exec {program} uncertainty {} --trials 100000000",
        text(&model)
    );
    let output = Command::new("sh").args(["-c", &script]).output().unwrap();
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("memory that this process may have"), "{said}");
    assert_eq!(names(above.path()), ["model.toml"]);
}

/// A file may have no more than so many blocks: the disk is full at another place each time.
#[test]
fn law_a_full_disk_loses_nothing() {
    let above = tempfile::tempdir().unwrap();
    let inputs = example(above.path());
    let out = above.path().join("result");
    succeed(&["calibrate", text(&inputs), "-o", text(&out)]);
    let file = above.path().join("out.csv");
    let recording = inputs.join("recording.csv");
    let calibration = out.join("calibration.json");
    succeed(&[
        "apply",
        text(&calibration),
        text(&recording),
        "-o",
        text(&file),
    ]);
    let mut before = BTreeMap::new();
    digests(above.path(), &mut before);
    let program = env!("CARGO_BIN_EXE_proofmass");
    for blocks in [0, 1, 8, 64, 256] {
        for (what, fits) in [
            (
                format!("calibrate {} -o {}", text(&inputs), text(&out)),
                false,
            ),
            (
                format!(
                    "apply {} {} -o {}",
                    text(&calibration),
                    text(&recording),
                    text(&file)
                ),
                false,
            ),
        ] {
            let script = format!("ulimit -f {blocks}; exec {program} {what}");
            let output = Command::new("sh")
                .args(["-c", &script])
                .env("SOURCE_DATE_EPOCH", "1790000001")
                .output()
                .unwrap();
            let said = stderr(&output);
            assert_eq!(output.status.success(), fits, "{blocks}, {what}: {said}");
            assert_eq!(output.status.code(), Some(1), "{said}");
            assert!(
                said.contains("error[") && !said.contains("panicked"),
                "{said}"
            );
            let mut after = BTreeMap::new();
            digests(above.path(), &mut after);
            assert_eq!(before, after, "{blocks}, {what}");
        }
    }
}

#[test]
fn law_two_writers_leave_one_whole_result() {
    let above = tempfile::tempdir().unwrap();
    let inputs = example(above.path());
    let out = above.path().join("result");
    let recording = inputs.join("recording.csv");
    for _ in 0..3 {
        let start = || {
            command(&["noise", text(&recording), "-o", text(&out)])
                .spawn()
                .unwrap()
        };
        let mut both = [start(), start()];
        let good = both
            .iter_mut()
            .filter_map(|c| c.wait().ok())
            .filter(|s| s.success())
            .count();
        assert!(good >= 1);
        is_one_result(&out);
        assert_eq!(names(above.path()), ["inputs", "result"]);
    }
}
