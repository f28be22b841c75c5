//! `proofmass records` from the first standard to the recall.
#![cfg(feature = "records")]

use crate::support::*;
use proofmass::jobs::findings::filing::check_failed;
use std::path::Path;

/// Arguments with the place of the records in front.
fn records<'a>(place: &'a str, rest: &[&'a str]) -> Vec<&'a str> {
    [&["records", "--records", place], rest].concat()
}

fn printed(arguments: &[&str]) -> String {
    String::from_utf8(succeed(arguments).stdout).unwrap()
}

#[test]
fn law_from_the_standard_to_the_recall() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| text(&folder.path().join(name)).to_owned();
    let (place, campaign) = (at("lab.records"), at("single"));
    succeed(&["init", "--kind", "shaker-single", "-o", &campaign]);
    let written = folder.path().join("single/campaign.toml");
    let example = std::fs::read_to_string(&written).unwrap();
    // The device of the example has no name, and a result without one is asked for it.
    succeed(&["calibrate", &campaign]);
    let unnamed = proofmass(&records(&place, &["add", "result", &at("single/result")]));
    assert!(
        stderr(&unnamed).contains("which device it is of"),
        "{unnamed:?}"
    );
    std::fs::write(
        &written,
        example.replace("serial = \"…\"", "serial = \"0042\""),
    )
    .unwrap();
    succeed(&["calibrate", &campaign]);
    let (reference, result) = (at("single/reference.csv"), at("single/result"));
    assert_eq!(
        printed(&records(&place, &["add", "standard", "--serial", "R-7"])),
        "#1\n"
    );
    let certificate = [
        "add",
        "certificate",
        "R-7",
        "--number",
        "C-1",
        "--valid-from",
        "2020-01-01",
        "--expanded-relative",
        "0.5",
        "--file",
        &reference,
    ];
    succeed(&records(&place, &certificate));
    let added = printed(&records(&place, &["add", "result", &result]));
    assert!(added.ends_with("is result 4\n"), "{added}");
    let again = printed(&records(&place, &["add", "result", &result]));
    assert!(again.ends_with("is here already as result 4\n"), "{again}");
    succeed(&records(&place, &["add", "rule", "--months", "6"]));
    let due: serde_json::Value = serde_json::from_str(&printed(&records(
        &place,
        &["due", "--within", "400", "--json"],
    )))
    .unwrap();
    let due: Vec<_> = due
        .as_array()
        .unwrap()
        .iter()
        .map(|d| d["name"].clone())
        .collect();
    assert_eq!(due, ["R-7", "… … 0042"]);
    let recall: serde_json::Value = serde_json::from_str(&printed(&records(
        &place,
        &["recall", "R-7", "--error", "1", "--json"],
    )))
    .unwrap();
    let effect = recall["results"][0]["effects"][0]["effect"]
        .as_f64()
        .unwrap();
    assert!(
        (effect / -1e-4 - 1.0).abs() < 0.01,
        "one per cent of 10 mV/(m/s²): {effect}"
    );
    let check = printed(&records(&place, &["check", "--recompute", "4"]));
    assert!(
        check.contains("whole") && check.contains("same bytes"),
        "{check}"
    );
    assert!(printed(&records(&place, &["show", "R-7"])).contains("C-1"));
    // A check measurement that does not agree needs a decision.
    let failed = [
        "add",
        "check",
        "R-7",
        "--value",
        "1.02",
        "--u",
        "0.002",
        "--reference",
        "1",
        "--u-reference",
        "0.002",
        "--unit",
        "1",
        "--strict",
    ];
    let done = proofmass(&records(&place, &failed));
    assert_eq!(done.status.code(), Some(3));
    let kind = check_failed("R-7", "S", 3.5, 0.02, 0.006, "1");
    assert_eq!(kind.code(), "check-failed");
    assert!(String::from_utf8_lossy(&done.stderr).contains("does not agree with its reference"));
    // Pages, tables, and the same records from a folder.
    succeed(&records(&place, &["export", "--html", "-o", &at("pages")]));
    for name in ["index.html", "due.html", "device-1.html", "device-3.html"] {
        assert!(folder.path().join("pages").join(name).is_file(), "{name}");
    }
    succeed(&records(&place, &["export", "--folder", "-o", &at("dump")]));
    let copy = at("copy.records");
    succeed(&records(&copy, &["import", &at("dump")]));
    let [a, b] = [&place, &copy].map(|place| printed(&records(place, &["check", "--json"])));
    assert_eq!(a, b);
    succeed(&records(&place, &["backup", &at("backup.records")]));
    assert!(Path::new(&at("backup.records")).is_file());
    // A damaged file of the records is told with exit code 1.
    let kept = std::fs::read(&copy).unwrap();
    std::fs::write(&copy, &kept[..kept.len() / 2]).unwrap();
    assert_eq!(proofmass(&records(&copy, &["list"])).status.code(), Some(1));
}

#[test]
fn refuses_a_device_twice_and_what_is_not_there() {
    let folder = tempfile::tempdir().unwrap();
    let lab = folder.path().join("lab.records");
    let add = ["records", "add", "device", "--records", text(&lab)];
    let device = [&add[..], &["--serial", "7", "--manufacturer", "M"]].concat();
    succeed(&device);
    assert!(refuse(&device).contains("here already as #1"));
    assert!(
        refuse(&[&add[..], &["--serial", ""]].concat()).contains("a number by which it is found")
    );
    let gone = folder.path().join("gone.csv");
    let import = ["records", "import", text(&gone), "--records", text(&lab)];
    assert!(refuse(&import).contains("no such file or folder"));
}

#[test]
fn law_a_page_never_replaces_the_records_nor_a_file_of_others() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| text(&folder.path().join(name)).to_owned();
    let place = at("lab.records");
    succeed(&records(&place, &["add", "standard", "--serial", "R-7"]));
    let before = std::fs::read(&place).unwrap();
    let refused = refuse(&records(&place, &["recall", "R-7", "--html", &place]));
    assert!(refused.contains("lab.records"), "{refused}");
    let forced = ["export", "--json", "--force", "-o", &place];
    refuse(&records(&place, &forced));
    assert_eq!(std::fs::read(&place).unwrap(), before);
    let other = at("other.txt");
    std::fs::write(&other, "mine").unwrap();
    refuse(&records(&place, &["recall", "R-7", "--html", &other]));
    assert_eq!(std::fs::read_to_string(&other).unwrap(), "mine");
    let page = at("recall.html");
    for _ in 0..2 {
        succeed(&records(&place, &["recall", "R-7", "--html", &page]));
    }
    // A command that fails leaves no empty records behind, and empty ones are not taken for new.
    let empty = at("empty.records");
    refuse(&records(
        &empty,
        &[
            "add",
            "check",
            "R",
            "--value",
            "1",
            "--u",
            "1",
            "--reference",
            "1",
            "--u-reference",
            "1",
            "--unit",
            "V",
        ],
    ));
    assert!(!Path::new(&empty).exists());
    std::fs::write(&empty, "").unwrap();
    let refused = refuse(&records(&empty, &["add", "device", "--serial", "1"]));
    assert!(refused.contains("is empty"), "{refused}");
}
