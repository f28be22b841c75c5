//! What `verify`, `render` and `apply` say of a campaign in which something was moved, altered, removed, replaced or added. The table
//! stands in docs/outputs.md.

use crate::support::*;
use std::fs;
use std::path::{Path, PathBuf};

/// How a command ends.
#[derive(Clone, Copy, Debug)]
enum Says {
    /// Well, and warns of nothing.
    Nothing,
    /// Well, with these words.
    That(&'static str),
    /// With exit code 1 and these words.
    Refuses(&'static str),
}
use Says::{Nothing, Refuses, That};

/// A campaign, its signed result, keys; the place of the result that is looked at.
struct Place {
    folder: tempfile::TempDir,
    result: PathBuf,
}

impl Place {
    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn append(&self, name: &str) {
        let place = self.at(name);
        let text = fs::read_to_string(&place).unwrap();
        // Still JSON, TOML, CSV and HTML.
        fs::write(place, text + "\n").unwrap();
    }

    fn edit_manifest(&self, edit: impl Fn(String) -> String) {
        let place = self.at("camp/result/manifest.json");
        fs::write(&place, edit(fs::read_to_string(&place).unwrap())).unwrap();
    }

    /// A copy of the campaign with its result, which is looked at from then on.
    fn copy(&mut self) {
        for folder in ["new", "new/result"] {
            fs::create_dir(self.at(folder)).unwrap();
            for name in names(&self.at(&folder.replace("new", "camp"))) {
                let from = self.at(&folder.replace("new", "camp")).join(&name);
                if from.is_file() {
                    fs::copy(from, self.at(folder).join(name)).unwrap();
                }
            }
        }
        self.result = self.at("new/result");
    }
}

struct Row {
    what: &'static str,
    tamper: fn(&mut Place),
    verify: Says,
    /// With the key of the laboratory.
    verify_key: Says,
    render: Says,
    apply: Says,
}

const SIGNATURE: &str = "the signature is not of what stands there now";

#[rustfmt::skip]
const ROWS: &[Row] = &[
    Row { what: "nothing", tamper: |_| {}, verify: That("unchanged"), verify_key: That("unchanged"), render: Nothing, apply: Nothing },
    Row { what: "report.html altered", tamper: |p| p.append("camp/result/report.html"),
        verify: Refuses("report.html"), verify_key: Refuses("report.html"), render: Nothing, apply: Nothing },
    Row { what: "a table altered", tamper: |p| p.append("camp/result/covariance.csv"),
        verify: Refuses("covariance.csv"), verify_key: Refuses("covariance.csv"), render: Nothing, apply: Nothing },
    Row { what: "result.json altered", tamper: |p| p.append("camp/result/result.json"),
        verify: Refuses("result.json"), verify_key: Refuses("result.json"), render: That("was changed since it was written"), apply: Nothing },
    Row { what: "calibration.json altered", tamper: |p| p.append("camp/result/calibration.json"),
        verify: Refuses("calibration.json"), verify_key: Refuses("calibration.json"), render: Nothing, apply: That("was changed since it was written") },
    Row { what: "result.json removed", tamper: |p| fs::remove_file(p.at("camp/result/result.json")).unwrap(),
        verify: Refuses("MISSING"), verify_key: Refuses("MISSING"), render: Refuses("result.json"), apply: Nothing },
    Row { what: "calibration.json removed", tamper: |p| fs::remove_file(p.at("camp/result/calibration.json")).unwrap(),
        verify: Refuses("MISSING"), verify_key: Refuses("MISSING"), render: Nothing, apply: Refuses("calibration.json") },
    Row { what: "calibration.json altered, its digest written anew", tamper: |p| {
            let digest = |p: &Place| proofmass::io::Input::of(&p.at("camp/result/calibration.json")).unwrap().sha256;
            let old = digest(p);
            p.append("camp/result/calibration.json");
            let new = digest(p);
            p.edit_manifest(|text| text.replace(&old, &new));
        }, verify: Refuses(SIGNATURE), verify_key: Refuses(SIGNATURE), render: That(SIGNATURE), apply: That(SIGNATURE) },
    Row { what: "signature removed", tamper: |p| p.edit_manifest(|text| {
            let mut list: serde_json::Value = serde_json::from_str(&text).unwrap();
            list.as_object_mut().unwrap().remove("signature");
            list.to_string()
        }), verify: That("by nobody"), verify_key: Refuses("is not signed"), render: Nothing, apply: Nothing },
    Row { what: "signature by another key", tamper: |p| {
            succeed(&["keygen", text(&p.at("other"))]);
            succeed(&["calibrate", text(&p.at("camp")), "--sign", text(&p.at("other.key"))]);
        }, verify: That("unchanged"), verify_key: Refuses("another key"), render: Nothing, apply: Nothing },
    Row { what: "manifest.json removed", tamper: |p| fs::remove_file(p.at("camp/result/manifest.json")).unwrap(),
        verify: That("by nobody"), verify_key: Refuses("no list of files"), render: Nothing, apply: Nothing },
    Row { what: "a file added", tamper: |p| fs::write(p.at("camp/result/notes.txt"), "mine").unwrap(),
        verify: That("notes.txt"), verify_key: That("notes.txt"), render: Nothing, apply: Nothing },
    Row { what: "campaign.toml altered", tamper: |p| p.append("camp/campaign.toml"),
        verify: Refuses("campaign.toml"), verify_key: Refuses("campaign.toml"), render: Nothing, apply: Nothing },
    Row { what: "recording altered", tamper: |p| p.append("camp/recording.csv"),
        verify: Refuses("recording.csv"), verify_key: Refuses("recording.csv"), render: Nothing, apply: Nothing },
    Row { what: "recording moved away", tamper: |p| fs::rename(p.at("camp/recording.csv"), p.at("other.csv")).unwrap(),
        verify: Refuses("MISSING"), verify_key: Refuses("MISSING"), render: Nothing, apply: Nothing },
    Row { what: "recording replaced by another", tamper: |p| fs::write(p.at("camp/recording.csv"), "t_s,x\n0,1\n1,2\n").unwrap(),
        verify: Refuses("recording.csv"), verify_key: Refuses("recording.csv"), render: Nothing, apply: Nothing },
    Row { what: "campaign copied", tamper: Place::copy,
        verify: That("new/recording.csv"), verify_key: That("new/recording.csv"), render: Nothing, apply: Nothing },
    Row { what: "campaign copied, the recording of the copy altered", tamper: |p| { p.copy(); p.append("new/recording.csv") },
        verify: Refuses("new/recording.csv"), verify_key: Refuses("new/recording.csv"), render: Nothing, apply: Nothing },
    Row { what: "campaign copied, its recording left behind", tamper: |p| { p.copy(); fs::remove_file(p.at("new/recording.csv")).unwrap() },
        verify: That("camp/recording.csv"), verify_key: That("camp/recording.csv"), render: Nothing, apply: Nothing },
];

fn expect(what: &str, arguments: &[&str], says: Says) {
    let output = proofmass(arguments);
    let mut said = stderr(&output) + &String::from_utf8_lossy(&output.stdout);
    if arguments[0] == "verify" {
        // A path may be broken over two lines of the table.
        let json = proofmass(&[arguments, &["--json"]].concat());
        said += &String::from_utf8_lossy(&json.stdout);
    }
    let has = |words: &str| said.contains(words);
    let code = output.status.code();
    match says {
        Nothing => assert!(
            code == Some(0) && !said.contains("warning:"),
            "{what}, {arguments:?}: {said}"
        ),
        That(words) => assert!(
            code == Some(0) && has(words),
            "{what}, {arguments:?}: {said}"
        ),
        Refuses(words) => assert!(
            code == Some(1) && has(words),
            "{what}, {arguments:?}: {said}"
        ),
    }
}

#[test]
fn known_what_is_said_of_tampering() {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hand-held");
    let whole = tempfile::tempdir().unwrap();
    let base = |name: &str| whole.path().join(name);
    fs::create_dir(base("camp")).unwrap();
    for name in ["campaign.toml", "recording.csv"] {
        fs::copy(example.join(name), base("camp").join(name)).unwrap();
    }
    succeed(&["keygen", text(&base("lab"))]);
    fs::copy(base("camp/recording.csv"), base("fresh.csv")).unwrap();
    let run = |folder: &Path, arguments: &[&str]| {
        let done = std::process::Command::new(env!("CARGO_BIN_EXE_proofmass"))
            .args(arguments)
            .current_dir(folder)
            .output()
            .unwrap();
        assert!(done.status.success(), "{}", stderr(&done));
    };
    // Inputs are named relative to the folder, so that a copy knows nothing of where the original lies but its name.
    run(whole.path(), &["calibrate", "camp", "--sign", "lab.key"]);
    for row in ROWS {
        let folder = tempfile::tempdir().unwrap();
        for sub in ["", "camp", "camp/result"] {
            fs::create_dir_all(folder.path().join(sub)).unwrap();
            for name in names(&base(sub)) {
                let from = base(sub).join(&name);
                if from.is_file() {
                    fs::copy(from, folder.path().join(sub).join(name)).unwrap();
                }
            }
        }
        let result = folder.path().join("camp/result");
        let mut place = Place { folder, result };
        (row.tamper)(&mut place);
        let result = text(&place.result);
        let (key, calibration) = (place.at("lab.pub"), place.result.join("calibration.json"));
        let (fresh, out) = (place.at("fresh.csv"), place.at("out.csv"));
        expect(row.what, &["verify", result], row.verify);
        expect(
            row.what,
            &["verify", result, "--key", text(&key)],
            row.verify_key,
        );
        expect(row.what, &["render", result], row.render);
        expect(
            row.what,
            &["apply", text(&calibration), text(&fresh), "-o", text(&out)],
            row.apply,
        );
    }
}

/// Whatever reads a file that was changed since it was written says so, and a result made from it asks for a decision.
#[test]
fn known_what_other_commands_say_of_an_altered_file() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hand-held");
    let recording = example.join("recording.csv");
    let (calibrated, output) = (at("calibrated"), at("output"));
    let calibration = calibrated.join("calibration.json");
    succeed(&["calibrate", text(&example), "-o", text(&calibrated)]);
    let compensated = at("compensated.csv");
    let apply = ["apply", text(&calibration), text(&recording)];
    succeed(&[&apply[..], &["-o", text(&compensated)]].concat());
    let validate = ["validate", text(&calibration), text(&recording)];
    let commands: [Vec<&str>; 4] = [
        ["export", "--c", text(&calibration)].to_vec(),
        validate.to_vec(),
        ["test", "orthogonality", text(&calibration)].to_vec(),
        ["test", "motion", text(&compensated), "--column", "acc_x"].to_vec(),
    ];
    for command in &commands {
        let said = stderr(&succeed(command));
        assert!(
            !said.contains("was changed after it was written"),
            "{command:?}: {said}"
        );
    }
    for file in [&calibration, &compensated] {
        let whole = fs::read(file).unwrap();
        fs::write(file, [&whole[..], b"\n"].concat()).unwrap();
    }
    for command in &commands {
        let done = succeed(command);
        let said = stderr(&done) + &String::from_utf8_lossy(&done.stdout);
        assert!(
            said.contains("was changed since it was written")
                || said.contains("was changed after it was written"),
            "{command:?}: {said}"
        );
    }
    let strict = [&validate[..], &["--strict", "-o", text(&output)]].concat();
    assert_eq!(proofmass(&strict).status.code(), Some(3));
    let result = json(&output.join("result.json"));
    assert!(codes(&result).contains(&"input-changed".to_owned()));
}

/// A result that no list names gets no list that hides it, and a list that is missing is named.
#[test]
fn regress_rendering_vouches_for_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hand-held");
    succeed(&["calibrate", text(&example), "-o", text(&at("first"))]);
    let unlisted = "nobody says whether they are as they were computed";
    let verify = |path: &Path| {
        let done = proofmass(&["verify", text(path)]);
        (
            done.status.code(),
            String::from_utf8_lossy(&done.stdout).replace("\n", " "),
        )
    };
    let (code, said) = verify(&at("first"));
    assert!(code == Some(0) && said.contains("that are named are unchanged."));
    assert!(!said.contains(unlisted), "{said}");
    fs::create_dir(at("copy")).unwrap();
    let copy = at("copy/result.json");
    let written = fs::read_to_string(at("first/result.json")).unwrap();
    fs::write(&copy, written).unwrap();
    let (again, other) = (at("again"), at("other"));
    let said = stderr(&succeed(&["render", text(&copy), "-o", text(&again)]));
    assert!(said.contains("warning: no manifest.json"), "{said}");
    for path in [&again, &copy, &again.join("result.json")] {
        let (code, said) = verify(path);
        assert!(code == Some(0) && said.contains(unlisted), "{said}");
    }
    // From a result that is listed nothing is said, and what was rendered first is still said of what is rendered from it.
    let first = at("first/result.json");
    let said = stderr(&succeed(&["render", text(&first), "-o", text(&other)]));
    assert!(
        !said.contains("warning:") && !verify(&other).1.contains(unlisted),
        "{said}"
    );
    let third = at("third");
    succeed(&["render", text(&again), "-o", text(&third)]);
    assert!(verify(&third).1.contains(unlisted));
}

/// The folder that is named, and the one beside the result, are what is judged, though the original lies where it lay.
#[test]
fn regress_an_altered_copy_is_not_vouched_for_by_the_original() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hand-held");
    fs::create_dir_all(at("camp")).unwrap();
    for name in ["campaign.toml", "recording.csv"] {
        fs::copy(example.join(name), at("camp").join(name)).unwrap();
    }
    succeed(&["calibrate", text(&at("camp"))]);
    let mut place = Place {
        result: at("camp/result"),
        folder,
    };
    place.copy();
    let (result, new) = (place.at("new/result"), place.at("new"));
    for arguments in [
        vec!["verify", text(&result)],
        vec!["verify", text(&result), "--data", text(&new)],
    ] {
        succeed(&arguments);
    }
    place.append("new/recording.csv");
    for arguments in [
        vec!["verify", text(&result)],
        vec!["verify", text(&result), "--data", text(&new)],
    ] {
        let output = proofmass(&arguments);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1));
        assert!(
            said.contains("new/recording.csv") && said.contains("camp/recording.csv is unchanged"),
            "{said}"
        );
    }
    // Whoever names the folder of the original has it judged.
    succeed(&["verify", text(&result), "--data", text(&place.at("camp"))]);
}

#[test]
fn regress_a_signature_does_not_go_without_a_word() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hand-held");
    for name in ["lab", "other"] {
        succeed(&["keygen", text(&at(name))]);
    }
    let (result, out) = (at("result"), at("out.csv"));
    let calibration = at("result/calibration.json");
    let recording = example.join("recording.csv");
    let calibrate = ["calibrate", text(&example), "-o", text(&result)];
    let apply = [
        "apply",
        text(&calibration),
        text(&recording),
        "-o",
        text(&out),
    ];
    for command in [&calibrate[..], &apply[..]] {
        let run = |key: Option<&str>| {
            let key = key.map(|k| text(&at(k)).to_owned());
            let mut arguments = command.to_vec();
            if let Some(key) = &key {
                arguments.extend(["--sign", key]);
            }
            stderr(&succeed(&arguments))
        };
        assert!(!run(Some("lab.key")).contains("warning:"));
        assert!(
            !run(Some("lab.key")).contains("warning:"),
            "the same key again"
        );
        let said = run(Some("other.key"));
        assert!(
            said.contains("warning:") && said.contains("another key"),
            "{said}"
        );
        let said = run(None);
        assert!(
            said.contains("warning:") && said.contains("--sign"),
            "{said}"
        );
        assert!(!run(None).contains("warning:"), "there is none any more");
    }
}

/// An example is written to be changed: its result has no doubt about it, and the chain behind it holds.
#[test]
fn law_an_example_may_be_changed() {
    let folder = tempfile::tempdir().unwrap();
    let place = text(&folder.path().join("single")).to_owned();
    succeed(&["init", "--kind", "shaker-single", "-o", &place]);
    let campaign = folder.path().join("single/campaign.toml");
    let toml = std::fs::read_to_string(&campaign).unwrap();
    std::fs::write(
        &campaign,
        toml.replace("serial = \"…\"", "serial = \"0042\""),
    )
    .unwrap();
    succeed(&["calibrate", &place]);
    let result = folder.path().join("single/result");
    assert!(!codes(&json(&result.join("result.json"))).contains(&"input-changed".to_owned()));
    succeed(&["verify", text(&result)]);
    // What is changed after the calibration is found, as ever.
    std::fs::write(&campaign, toml).unwrap();
    refuse(&["verify", text(&result)]);
}
