//! `proofmass explain`.

use crate::support::{refuse, succeed};

fn stdout(arguments: &[&str]) -> String {
    String::from_utf8(succeed(arguments).stdout).expect("text in UTF-8")
}

#[test]
fn a_code_is_explained_and_all_are_listed() {
    let one = stdout(&["explain", "gaps-in-record"]);
    assert!(
        one.contains("gaps-in-record (uncertainty)") && one.contains("advice: "),
        "{one}"
    );
    let json: serde_json::Value =
        serde_json::from_str(&stdout(&["explain", "gaps-in-record", "--json"])).expect("JSON");
    assert_eq!(json["severities"], serde_json::json!(["warning", "note"]));
    assert_eq!(json["evidence_fields"][1], "evidence");

    let all = stdout(&["explain"]);
    let list: serde_json::Value =
        serde_json::from_str(&stdout(&["explain", "--json"])).expect("JSON");
    assert_eq!(all.lines().count(), list.as_array().expect("a list").len());
}

#[test]
fn refuses_a_misspelt_code_with_the_nearest() {
    let said = refuse(&["explain", "gap-in-record"]);
    assert!(said.contains("did you mean `gaps-in-record`?"), "{said}");
}
