//! Outputs take nothing away but what an earlier run wrote, wherever they stand.

use proofmass_io::{
    AtomicFile, Input, MANIFEST, Manifest, OutputFolder, RESULT_SCHEMA, Result, Schema,
};
use std::fs;
use std::path::{Path, PathBuf};

/// A result.json of which nothing but the head is there.
pub fn result(kind: &str, inputs: &[&Path]) -> Vec<u8> {
    let inputs = inputs.iter().map(|i| Input {
        path: i.display().to_string(),
        sha256: String::new(),
        ..Input::default()
    });
    let head = serde_json::json!({
        "schema": Schema::new(RESULT_SCHEMA, 2),
        "kind": kind,
        "inputs": inputs.collect::<Vec<Input>>(),
    });
    serde_json::to_vec(&head).unwrap()
}

/// Writes result.json and one more file.
fn write(place: &Path, kind: &str, other: (&str, &str), force: bool) -> Result<PathBuf> {
    let folder = OutputFolder::create(place, force)?;
    folder.write("result.json", result(kind, &[]))?;
    folder.write(other.0, other.1)?;
    folder.commit()
}

fn names(folder: &Path) -> Vec<String> {
    let mut all: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    all.sort();
    all
}

fn place() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("result");
    (folder, place)
}

#[test]
fn law_a_result_replaces_exactly_what_the_last_one_wrote() {
    let (above, out) = place();
    write(&out, "noise", ("deviation.csv", "1"), false).unwrap();
    let manifest = Manifest::read(&out).unwrap().unwrap();
    assert_eq!(manifest.kind, "noise");
    assert!(manifest.files.iter().all(|f| f.is_unchanged(&out)));
    assert_eq!(names(&out), ["deviation.csv", MANIFEST, "result.json"]);
    // Another set of files: the old one goes.
    write(&out, "noise", ("curve.csv", "2"), false).unwrap();
    assert_eq!(names(&out), ["curve.csv", MANIFEST, "result.json"]);
    assert_eq!(names(above.path()), ["result"], "nothing else is left");
}

#[test]
fn regress_files_of_others_survive() {
    let (above, out) = place();
    write(&out, "multi-position", ("standstills.csv", "1"), false).unwrap();
    for (name, text) in [
        ("compensated.csv", "a"),
        ("my_evaluation.csv", "b"),
        ("notes.html", "c"),
    ] {
        fs::write(out.join(name), text).unwrap();
    }
    fs::create_dir(out.join("plots")).unwrap();
    fs::write(out.join("plots/one.png"), "d").unwrap();
    write(&out, "multi-position", ("residuals.csv", "2"), false).unwrap();
    assert_eq!(
        names(&out),
        [
            "compensated.csv",
            MANIFEST,
            "my_evaluation.csv",
            "notes.html",
            "plots",
            "residuals.csv",
            "result.json"
        ]
    );
    assert_eq!(fs::read_to_string(out.join("plots/one.png")).unwrap(), "d");
    // A new file in the place of one of them is refused, and all stays as it was.
    let error = write(&out, "multi-position", ("notes.html", "mine"), false).unwrap_err();
    assert!(error.to_string().contains("notes.html"), "{error}");
    assert_eq!(fs::read_to_string(out.join("notes.html")).unwrap(), "c");
    assert!(out.join("residuals.csv").exists());
    // A file that was edited is somebody's now.
    fs::write(out.join("residuals.csv"), "2, and a remark").unwrap();
    let error = write(&out, "multi-position", ("residuals.csv", "3"), false).unwrap_err();
    assert!(error.to_string().contains("was changed since"), "{error}");
    // Force replaces what has the same name and removes nothing else.
    write(&out, "multi-position", ("residuals.csv", "3"), true).unwrap();
    assert_eq!(fs::read_to_string(out.join("residuals.csv")).unwrap(), "3");
    assert!(out.join("plots/one.png").exists() && out.join("notes.html").exists());
    assert_eq!(names(above.path()), ["result"]);
}

#[test]
fn regress_force_removes_no_tree() {
    let (_above, out) = place();
    fs::create_dir_all(out.join("other-campaign")).unwrap();
    fs::write(out.join("other-campaign/raw.f32"), "precious").unwrap();
    fs::write(out.join("thesis.txt"), "years").unwrap();
    let error = write(&out, "noise", ("a.csv", "1"), false).unwrap_err();
    assert!(error.to_string().contains("not empty"), "{error}");
    write(&out, "noise", ("a.csv", "1"), true).unwrap();
    assert_eq!(
        fs::read_to_string(out.join("other-campaign/raw.f32")).unwrap(),
        "precious"
    );
    assert_eq!(fs::read_to_string(out.join("thesis.txt")).unwrap(), "years");
}

#[test]
fn regress_inputs_are_never_replaced_nor_removed() {
    let (_above, out) = place();
    // A recording lies beside earlier results, one of which is an input too.
    write(&out, "spurious-motion", ("spurious.csv", "table"), false).unwrap();
    fs::write(out.join("recording.csv"), "raw").unwrap();
    for force in [false, true] {
        let folder = OutputFolder::create(&out, force).unwrap();
        let inputs = [out.join("recording.csv"), out.join("spurious.csv")];
        let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
        folder
            .write("result.json", result("spurious-motion", &inputs))
            .unwrap();
        folder.commit().unwrap();
        assert_eq!(
            fs::read_to_string(out.join("recording.csv")).unwrap(),
            "raw"
        );
        assert_eq!(
            fs::read_to_string(out.join("spurious.csv")).unwrap(),
            "table"
        );
        // Even forced, none is written over.
        let folder = OutputFolder::create(&out, force).unwrap();
        folder
            .write("result.json", result("spurious-motion", &inputs))
            .unwrap();
        folder.write("recording.csv", "new").unwrap();
        let error = folder.commit().unwrap_err();
        assert!(error.to_string().contains("recording.csv"), "{error}");
        assert_eq!(
            fs::read_to_string(out.join("recording.csv")).unwrap(),
            "raw"
        );
    }
}

#[test]
fn regress_another_kind_is_not_replaced() {
    let (_above, out) = place();
    write(&out, "multi-position", ("calibration.json", "{}"), false).unwrap();
    let early = OutputFolder::create(&out, false).unwrap();
    assert!(early.expect_kind("multi-position").is_ok());
    let error = early.expect_kind("noise").unwrap_err();
    assert!(error.to_string().contains("multi-position"), "{error}");
    drop(early);
    let error = write(&out, "noise", ("deviation.csv", "1"), false).unwrap_err();
    assert!(error.to_string().contains("multi-position"), "{error}");
    assert_eq!(names(&out), ["calibration.json", MANIFEST, "result.json"]);
    write(&out, "noise", ("deviation.csv", "1"), true).unwrap();
    // Even then what the other kind wrote under another name stays.
    assert_eq!(
        names(&out),
        ["calibration.json", "deviation.csv", MANIFEST, "result.json"]
    );
}

#[test]
fn refuses_campaigns_files_and_names_that_lead_out() {
    let (above, out) = place();
    fs::create_dir(&out).unwrap();
    fs::write(out.join("campaign.toml"), "kind = 1").unwrap();
    for force in [false, true] {
        let error = OutputFolder::create(&out, force).unwrap_err();
        assert!(error.to_string().contains("campaign"), "{error}");
    }
    let file = above.path().join("file");
    fs::write(&file, "x").unwrap();
    assert!(OutputFolder::create(&file, true).is_err());
    assert!(OutputFolder::create("/", true).is_err());
    let folder = OutputFolder::create(above.path().join("new"), false).unwrap();
    for name in ["../x", "a/b", ".", "..", "", MANIFEST, "/etc/passwd"] {
        assert!(folder.write(name, "x").is_err(), "{name}");
    }
    drop(folder);
    // A manifest may not name files elsewhere.
    let manifest = Manifest::new("noise", vec![]).to_json().unwrap();
    let text = String::from_utf8(manifest).unwrap();
    let bad = text.replace("[]", r#"[{"name": "../../precious", "sha256": ""}]"#);
    assert!(Manifest::from_json(bad.as_bytes()).is_err());
}

#[test]
fn law_a_run_that_fails_leaves_no_folders() {
    let above = tempfile::tempdir().unwrap();
    let folder = OutputFolder::create(above.path().join("a/b/out"), false).unwrap();
    folder.write("x", "1").unwrap();
    drop(folder);
    assert_eq!(names(above.path()), [""; 0]);
    let folder = OutputFolder::create(above.path().join("a/b/out"), false).unwrap();
    folder.commit().unwrap();
    assert_eq!(names(&above.path().join("a/b")), ["out"]);
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};
    use std::process::Command;

    #[test]
    fn regress_through_a_link_the_folder_behind_it_is_written() {
        let (above, out) = place();
        write(&out, "noise", ("a.csv", "1"), false).unwrap();
        let link = above.path().join("link");
        symlink(&out, &link).unwrap();
        for place in [link.clone(), link.join(".")] {
            write(&place, "noise", ("a.csv", "2"), false).unwrap();
        }
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(out.join("a.csv")).unwrap(), "2");
        symlink(above.path().join("nothing"), above.path().join("dangling")).unwrap();
        assert!(OutputFolder::create(above.path().join("dangling"), false).is_err());
        // The same for a file.
        let file = above.path().join("file.csv");
        fs::write(&file, "old").unwrap();
        let to_file = above.path().join("to-file");
        symlink(&file, &to_file).unwrap();
        let mut out = AtomicFile::create(&to_file, &[]).unwrap();
        out.write_all(b"new").unwrap();
        out.commit().unwrap();
        assert!(fs::symlink_metadata(&to_file).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&file).unwrap(), "new");
    }

    #[test]
    fn regress_modes_follow_the_umask_and_not_the_folder() {
        // The umask belongs to the process: asked for in one of its own.
        let mask = Command::new("sh").args(["-c", "umask"]).output().unwrap();
        let mask = u32::from_str_radix(String::from_utf8(mask.stdout).unwrap().trim(), 8).unwrap();
        let above = tempfile::tempdir().unwrap();
        let open = above.path().join("open");
        fs::create_dir(&open).unwrap();
        fs::set_permissions(&open, fs::Permissions::from_mode(0o1777)).unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o7777;
        let out = open.join("result");
        write(&out, "noise", ("a.csv", "1"), false).unwrap();
        assert_eq!(mode(&out), 0o777 & !mask);
        assert_eq!(mode(&out.join("a.csv")), 0o666 & !mask);
        let mut file = AtomicFile::create(open.join("o.csv"), &[]).unwrap();
        file.write_all(b"1").unwrap();
        file.commit().unwrap();
        assert_eq!(mode(&open.join("o.csv")), 0o666 & !mask);
    }

    #[test]
    fn regress_devices_and_pipes_are_written_into() {
        use std::os::unix::fs::FileTypeExt;
        let above = tempfile::tempdir().unwrap();
        let mut null = AtomicFile::create("/dev/null", &[]).unwrap();
        null.write_all(b"gone").unwrap();
        null.commit().unwrap();
        assert!(
            fs::metadata("/dev/null")
                .unwrap()
                .file_type()
                .is_char_device()
        );
        let pipe = above.path().join("pipe");
        assert!(
            Command::new("mkfifo")
                .arg(&pipe)
                .status()
                .unwrap()
                .success()
        );
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read_to_string(pipe).unwrap()
        });
        let mut file = AtomicFile::create(&pipe, &[]).unwrap();
        file.write_all(b"through").unwrap();
        file.commit().unwrap();
        assert_eq!(reader.join().unwrap(), "through");
        assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
        assert_eq!(names(above.path()), ["pipe"]);
    }

    /// The folder of a mount cannot be renamed, nor can one be made beside it: here its parent is closed.
    #[test]
    fn regress_a_folder_whose_parent_is_closed_is_written_inside() {
        let above = tempfile::tempdir().unwrap();
        let closed = above.path().join("closed");
        let out = closed.join("out");
        fs::create_dir_all(&out).unwrap();
        fs::set_permissions(&closed, fs::Permissions::from_mode(0o555)).unwrap();
        let root = fs::File::create(closed.join("probe")).is_ok();
        if root {
            // Permissions do not bind the super-user; the file is removed again.
            fs::remove_file(closed.join("probe")).unwrap();
        }
        for text in ["1", "2"] {
            write(&out, "noise", ("a.csv", text), false).unwrap();
            assert_eq!(fs::read_to_string(out.join("a.csv")).unwrap(), text);
            assert_eq!(names(&out), ["a.csv", MANIFEST, "result.json"]);
        }
        fs::set_permissions(&closed, fs::Permissions::from_mode(0o755)).unwrap();
    }
}
