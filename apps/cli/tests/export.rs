//! `proofmass export`: the calibration of the example in every form.

mod support;

use support::*;

const EXAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/hand-held");

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
