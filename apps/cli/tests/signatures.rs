//! Who vouches for what: keys, signatures, and the chain from the raw recording to the compensated one.

use crate::support::*;
use std::fs;
use std::path::{Path, PathBuf};

struct Chain {
    _folder: tempfile::TempDir,
    at: PathBuf,
}

impl Chain {
    /// recording → campaign → result → calibration → compensated recording, every list signed.
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path().to_path_buf();
        let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hand-held");
        fs::create_dir(at.join("camp")).unwrap();
        for name in ["campaign.toml", "recording.csv"] {
            fs::copy(example.join(name), at.join("camp").join(name)).unwrap();
        }
        let chain = Self {
            _folder: folder,
            at,
        };
        succeed(&["keygen", &chain.place("lab")]);
        let (camp, key) = (chain.place("camp"), chain.place("lab.key"));
        succeed(&["calibrate", &camp, "--sign", &key]);
        succeed(&[
            "apply",
            &chain.place("camp/result/calibration.json"),
            &chain.place("camp/recording.csv"),
            "-o",
            &chain.place("compensated.csv"),
            "--sign",
            &key,
        ]);
        chain
    }

    fn place(&self, name: &str) -> String {
        text(&self.at.join(name)).to_owned()
    }
}

#[test]
fn law_one_flipped_byte_anywhere_in_the_chain_is_named() {
    let chain = Chain::new();
    let (compensated, key) = (chain.place("compensated.csv"), chain.place("lab.pub"));
    let shown = succeed(&["verify", &compensated, "--key", &key]);
    let shown = String::from_utf8(shown.stdout).unwrap();
    for name in [
        "compensated.csv",
        "calibration.json",
        "result.json",
        "campaign.toml",
        "recording.csv",
        "report.html",
    ] {
        assert!(shown.contains(name), "{name}: {shown}");
    }
    assert!(shown.contains("signed"), "{shown}");
    for name in [
        "compensated.csv",
        "camp/recording.csv",
        "camp/campaign.toml",
        "camp/result/result.json",
        "camp/result/report.html",
        "camp/result/calibration.json",
    ] {
        let place = chain.at.join(name);
        let good = fs::read(&place).unwrap();
        for at in [0, good.len() / 2, good.len() - 1] {
            let mut bad = good.clone();
            bad[at] ^= 1;
            fs::write(&place, &bad).unwrap();
            let said = refuse(&["verify", &compensated, "--key", &key]);
            let file = Path::new(name).file_name().unwrap().to_str().unwrap();
            assert!(said.contains(file), "{name}, byte {at}: {said}");
        }
        fs::write(&place, good).unwrap();
    }
    succeed(&["verify", &compensated, "--key", &key]);
}

#[test]
fn law_a_list_written_anew_does_not_verify() {
    let chain = Chain::new();
    let key = chain.place("lab.pub");
    let (manifest, report) = (
        chain.at.join("camp/result/manifest.json"),
        chain.at.join("camp/result/report.html"),
    );
    // Somebody changes a file and its digest with it.
    let digest = |path: &Path| proofmass::io::Input::of(path).unwrap().sha256;
    let old = digest(&report);
    let good = fs::read_to_string(&report).unwrap();
    fs::write(&report, good.replace("<h1", "<h1 ")).unwrap();
    let list = fs::read_to_string(&manifest).unwrap();
    fs::write(&manifest, list.replace(&old, &digest(&report))).unwrap();
    let result = chain.place("camp/result");
    let said = refuse(&["verify", &result]);
    assert!(
        said.contains("manifest.json") && said.contains("signature"),
        "{said}"
    );
    // Signed anew with another key: it holds, but is not that of the laboratory.
    fs::write(&report, good).unwrap();
    fs::write(&manifest, list).unwrap();
    succeed(&["verify", &result, "--key", &key]);
    succeed(&["keygen", &chain.place("other")]);
    let said = refuse(&["verify", &result, "--key", &chain.place("other.pub")]);
    assert!(said.contains("another key"), "{said}");
    succeed(&[
        "verify",
        &result,
        "--key",
        &chain.place("other.pub"),
        "--key",
        &key,
    ]);
    // Without a signature a list is whole, but nobody vouches for it.
    succeed(&["calibrate", &chain.place("camp")]);
    succeed(&["verify", &result]);
    let said = refuse(&["verify", &result, "--key", &key]);
    assert!(said.contains("is not signed"), "{said}");
}

#[test]
fn refuses_keys_that_are_none_and_never_replaces_one() {
    let folder = tempfile::tempdir().unwrap();
    let name = folder.path().join("lab");
    succeed(&["keygen", text(&name)]);
    let private = fs::read(folder.path().join("lab.key")).unwrap();
    let said = refuse(&["keygen", text(&name)]);
    assert!(said.contains("never replaced"), "{said}");
    assert_eq!(fs::read(folder.path().join("lab.key")).unwrap(), private);
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hand-held");
    let out = folder.path().join("out");
    let public = folder.path().join("lab.pub");
    let said = refuse(&[
        "calibrate",
        example,
        "-o",
        text(&out),
        "--sign",
        text(&public),
    ]);
    assert!(said.contains("public key"), "{said}");
    assert!(!out.exists());
    let model = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/data/uncertainty/mass.toml"
    );
    let key = folder.path().join("lab.key");
    let said = refuse(&["uncertainty", model, "--sign", text(&key)]);
    assert!(said.contains("-o"), "{said}");
    let said = refuse(&["verify", model, "--key", text(&key)]);
    assert!(said.contains("private key"), "{said}");
}
