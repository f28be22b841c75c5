//! Nothing is lost: results and recordings of others survive whatever is asked of a place.

use crate::support::*;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// 2000 samples of a sensor at rest, about a second of work for `noise`.
fn recording(at: &Path) {
    let mut text = "time_s,acc_m/s2\n".to_owned();
    let mut state = 1_u64;
    for i in 0..2000 {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let noise = (state >> 40) as f64 / 16_777_216.0;
        text += &format!("{:.2},{:.5}\n", f64::from(i) * 0.01, 9.8 + 0.01 * noise);
    }
    fs::write(at, text).unwrap();
}

/// The shipped example in a folder of its own, calibrated once.
fn calibrated() -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let camp = folder.path().join("camp");
    fs::create_dir(&camp).unwrap();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hand-held");
    for name in ["campaign.toml", "recording.csv"] {
        fs::copy(example.join(name), camp.join(name)).unwrap();
    }
    succeed(&["calibrate", text(&camp)]);
    (folder, camp)
}

fn run_in(folder: &Path, arguments: &[&str]) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_proofmass"))
        .args(arguments)
        .current_dir(folder)
        .env("SOURCE_DATE_EPOCH", "1790000000")
        .output()
        .unwrap()
}

#[test]
fn regress_a_campaign_is_calibrated_from_inside_its_results() {
    let (_folder, camp) = calibrated();
    let result = camp.join("result");
    let before = json(&result.join("result.json"));
    for arguments in [
        &["calibrate", ".."][..],
        &["calibrate", "..", "-o", "../result"],
    ] {
        let output = run_in(&result, arguments);
        assert!(output.status.success(), "{}", stderr(&output));
        // The folder one stands in is the one that was written, not a removed one.
        assert!(names(&result).contains(&"result.json".to_owned()));
        assert_eq!(names(&camp), ["campaign.toml", "recording.csv", "result"]);
    }
    let after = json(&result.join("result.json"));
    assert_eq!(before["quantities"], after["quantities"]);
}

#[test]
fn regress_recordings_and_files_of_others_survive_a_run() {
    let (folder, camp) = calibrated();
    // The campaign names a recording that lies beside earlier results.
    let data = folder.path().join("data");
    fs::rename(camp.join("result"), &data).unwrap();
    fs::rename(camp.join("recording.csv"), data.join("recording.csv")).unwrap();
    let raw = fs::read(data.join("recording.csv")).unwrap();
    let toml = fs::read_to_string(camp.join("campaign.toml")).unwrap();
    let toml = toml.replace("\"recording.csv\"", "\"../data/recording.csv\"");
    fs::write(camp.join("campaign.toml"), toml).unwrap();
    fs::write(data.join("my_evaluation.csv"), "mine").unwrap();
    fs::write(data.join("notes.html"), "mine").unwrap();
    succeed(&[
        "apply",
        text(&data.join("calibration.json")),
        text(&data.join("recording.csv")),
        "-o",
        text(&data.join("compensated.csv")),
    ]);
    let compensated = fs::read(data.join("compensated.csv")).unwrap();
    for force in [&[][..], &["--force"]] {
        let mut arguments = vec!["calibrate", text(&camp), "-o", text(&data)];
        arguments.extend(force);
        succeed(&arguments);
        assert_eq!(fs::read(data.join("recording.csv")).unwrap(), raw);
        assert_eq!(fs::read(data.join("compensated.csv")).unwrap(), compensated);
        for name in ["my_evaluation.csv", "notes.html"] {
            assert_eq!(fs::read_to_string(data.join(name)).unwrap(), "mine");
        }
    }
}

/// `--force` touches what it writes and nothing else.
#[test]
fn regress_force_keeps_what_results_of_another_kind_do_not_write() {
    let (folder, camp) = calibrated();
    let result = camp.join("result");
    let noise = folder.path().join("noise.csv");
    recording(&noise);
    let before = names(&result);
    let bytes = |names: &[String]| -> Vec<Vec<u8>> {
        let read = |name| fs::read(result.join(name)).unwrap();
        names.iter().map(read).collect()
    };
    let own = ["manifest.json", "report.html", "result.json"];
    let kept: Vec<String> = before
        .iter()
        .filter(|n| !own.contains(&n.as_str()))
        .cloned()
        .collect();
    assert!(kept.contains(&"calibration.json".to_owned()), "{kept:?}");
    let old = bytes(&kept);
    succeed(&["noise", text(&noise), "-o", text(&result), "--force"]);
    assert_eq!(bytes(&kept), old);
    assert_eq!(json(&result.join("result.json"))["kind"], "noise");
    // They belong to no list any more, which is said.
    let said = succeed(&["verify", text(&result)]);
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(said.contains("calibration.json"), "{said}");
    // And back again.
    succeed(&["calibrate", text(&camp), "--force"]);
    assert_eq!(json(&result.join("result.json"))["kind"], "multi-position");
}

#[test]
fn regress_results_of_another_kind_are_refused_before_the_work() {
    let (folder, camp) = calibrated();
    let result = camp.join("result");
    let noise = folder.path().join("noise.csv");
    recording(&noise);
    let before = names(&result);
    // A recording that does not exist is noticed only after the place was looked at.
    for input in [text(&noise), "nowhere.csv"] {
        let said = refuse(&["noise", input, "-o", text(&result)]);
        assert!(
            said.contains("multi-position") && said.contains("noise"),
            "{said}"
        );
    }
    let model = folder.path().join("model.toml");
    fs::write(&model, "[[input]]\nname = \"a\"\nunit = \"1\"\nvalue = 1\nU = 0.1\nk = 2\n[[output]]\nname = \"y\"\nunit = \"1\"\nexpression = \"a\"\n").unwrap();
    let said = refuse(&["uncertainty", text(&model), "-o", text(&result)]);
    assert!(said.contains("multi-position"), "{said}");
    assert_eq!(names(&result), before);
}

#[test]
fn regress_force_removes_no_tree() {
    let folder = tempfile::tempdir().unwrap();
    let noise = folder.path().join("noise.csv");
    recording(&noise);
    let out = folder.path().join("archive");
    fs::create_dir_all(out.join("2024/campaign")).unwrap();
    fs::write(out.join("2024/campaign/raw.f32"), "precious").unwrap();
    let said = refuse(&["noise", text(&noise), "-o", text(&out)]);
    assert!(said.contains("not empty"), "{said}");
    succeed(&["noise", text(&noise), "-o", text(&out), "--force"]);
    assert!(out.join("result.json").is_file());
    let raw = fs::read_to_string(out.join("2024/campaign/raw.f32")).unwrap();
    assert_eq!(raw, "precious");
}

#[test]
fn law_apply_writes_to_standard_output_and_to_pipes() {
    let (folder, camp) = calibrated();
    let calibration = camp.join("result/calibration.json");
    let raw = camp.join("recording.csv");
    let file = folder.path().join("out.csv");
    succeed(&["apply", text(&calibration), text(&raw), "-o", text(&file)]);
    let whole = fs::read(&file).unwrap();
    let output = run_in(
        folder.path(),
        &["apply", text(&calibration), text(&raw), "-o", "-"],
    );
    assert!(output.status.success());
    assert_eq!(output.stdout, whole);
    // From standard input to standard output, as between two programs that pack and unpack.
    let output = Command::new(env!("CARGO_BIN_EXE_proofmass"))
        .args(["apply", text(&calibration), "-", "-o", "-"])
        .stdin(fs::File::open(&raw).unwrap())
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(output.stdout, whole);
    // Nothing is called `-`, nor is there a provenance of it.
    assert_eq!(
        names(folder.path()),
        ["camp", "out.csv", "out.csv.provenance.json"]
    );
    // A file that is not ours is not replaced unasked.
    fs::write(&file, "edited").unwrap();
    let said = refuse(&["apply", text(&calibration), text(&raw), "-o", text(&file)]);
    assert!(said.contains("--force"), "{said}");
    assert_eq!(fs::read_to_string(&file).unwrap(), "edited");
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::os::unix::fs::{FileTypeExt, PermissionsExt};

    #[test]
    fn regress_modes_follow_the_umask() {
        let (folder, camp) = calibrated();
        let open = folder.path().join("open");
        fs::create_dir(&open).unwrap();
        fs::set_permissions(&open, fs::Permissions::from_mode(0o1777)).unwrap();
        let noise = folder.path().join("noise.csv");
        recording(&noise);
        let program = env!("CARGO_BIN_EXE_proofmass");
        for (mask, file, directory) in [("022", 0o644, 0o755), ("077", 0o600, 0o700)] {
            let script = format!(
                "umask {mask} && {program} apply {} {} -o {}/o{mask}.csv && {program} noise {} -o {}/n{mask} --imu-yaml {}/i{mask}.yaml",
                text(&camp.join("result/calibration.json")),
                text(&camp.join("recording.csv")),
                text(&open),
                text(&noise),
                text(&open),
                text(&open),
            );
            let output = Command::new("sh").args(["-c", &script]).output().unwrap();
            assert!(output.status.success(), "{}", stderr(&output));
            let mode =
                |name: String| fs::metadata(open.join(name)).unwrap().permissions().mode() & 0o7777;
            assert_eq!(mode(format!("o{mask}.csv")), file);
            assert_eq!(mode(format!("o{mask}.csv.provenance.json")), file);
            assert_eq!(mode(format!("i{mask}.yaml")), file);
            assert_eq!(mode(format!("n{mask}")), directory);
            assert_eq!(mode(format!("n{mask}/result.json")), file);
            assert_eq!(mode(format!("n{mask}/manifest.json")), file);
        }
    }

    #[test]
    fn regress_devices_and_links_are_not_replaced() {
        let (folder, camp) = calibrated();
        let calibration = camp.join("result/calibration.json");
        let raw = camp.join("recording.csv");
        // A device: here one that swallows all; in a private place so that a fault could not hurt the machine.
        let null = folder.path().join("null");
        std::os::unix::fs::symlink("/dev/null", &null).unwrap();
        for target in [text(&null), "/dev/null"] {
            succeed(&["apply", text(&calibration), text(&raw), "-o", target]);
        }
        assert!(fs::symlink_metadata(&null).unwrap().is_symlink());
        let device = fs::metadata("/dev/null").unwrap().file_type();
        assert!(device.is_char_device());
        assert_eq!(names(folder.path()), ["camp", "null"]);
        // A link to a folder, and a folder with a slash behind it.
        let real = folder.path().join("real");
        fs::create_dir(&real).unwrap();
        let link = folder.path().join("link");
        std::os::unix::fs::symlink(&real, &link).unwrap();
        for place in [text(&link).to_owned(), format!("{}/", text(&link))] {
            succeed(&["calibrate", text(&camp), "-o", &place]);
            assert!(real.join("result.json").is_file());
            assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        }
    }

    #[test]
    fn regress_a_full_or_closed_standard_error_is_no_panic() {
        let (folder, camp) = calibrated();
        let program = env!("CARGO_BIN_EXE_proofmass");
        let said = folder.path().join("said.txt");
        for (redirect, code) in [
            ("2>/dev/full", "0"),
            ("2>&-", "0"),
            (">&- 2>&-", "any"),
            (">/dev/full 2>/dev/full", "1"),
        ] {
            let script = format!(
                "{program} calibrate {} {redirect}; echo $? > {}",
                text(&camp),
                text(&said)
            );
            Command::new("sh")
                .args(["-c", &script])
                .stdout(Stdio::null())
                .status()
                .unwrap();
            let found = fs::read_to_string(&said).unwrap();
            assert_ne!(found.trim(), "101", "{redirect}");
            if code != "any" {
                assert_eq!(found.trim(), code, "{redirect}");
            }
            assert!(camp.join("result/result.json").is_file());
        }
    }
}
