//! A result rendered again from result.json alone.

use crate::support::{refuse, succeed, text};

const EXAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hand-held");

#[test]
fn law_every_file_comes_back_to_the_byte() {
    let place = tempfile::tempdir().unwrap();
    let first = place.path().join("first");
    let again = place.path().join("again");
    succeed(&["calibrate", EXAMPLE, "-o", text(&first)]);
    succeed(&["render", text(&first), "-o", text(&again)]);
    for name in [
        "result.json",
        "report.html",
        "calibration.json",
        "parameters.csv",
        "standstills.csv",
        "covariance.csv",
    ] {
        let [a, b] = [&first, &again].map(|folder| std::fs::read(folder.join(name)).unwrap());
        assert!(a == b, "{name} differs");
    }
}

#[test]
fn refuses_what_is_no_result() {
    refuse(&["render", EXAMPLE]);
    let said = refuse(&["render", &format!("{EXAMPLE}/campaign.toml")]);
    assert!(said.contains("campaign.toml"), "{said}");
}
