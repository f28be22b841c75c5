//! What a model says that reads an earlier result in which something was altered, or which is another one. The table stands in
//! docs/uncertainty.md.

use crate::support::*;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// What is said of an earlier result.
#[derive(Clone, Copy, Debug)]
enum Says {
    /// Exit code 1 and these words.
    Refuses(&'static str),
    /// A decision is asked for, with these words in its evidence.
    Doubts(&'static str),
    /// A note that no list of files vouches for it.
    Unlisted,
    /// Nothing.
    Nothing,
}
use Says::{Doubts, Nothing, Refuses, Unlisted};

struct Row {
    what: &'static str,
    tamper: fn(&Path),
    /// With the manifest.json of the folder, and without it.
    listed: Says,
    alone: Says,
}

const LINEAR: &str = "lin/result.json";
const SQUARE: &str = "sq/result.json";
const CHANGED: &str = "was changed since";

fn edit(folder: &Path, name: &str, change: impl Fn(&mut Value)) {
    let place = folder.join(name);
    let mut result = json(&place);
    change(&mut result);
    fs::write(place, result.to_string()).unwrap();
}

fn scale_covariance(matrix: &mut Value, factor: f64) {
    for x in matrix.as_array_mut().unwrap() {
        for x in x.as_array_mut().unwrap() {
            *x = json!(x.as_f64().unwrap() * factor);
        }
    }
}

/// u, U, the causes and both covariances a tenth of what they were: nothing contradicts anything.
fn shrink(result: &mut Value) {
    for q in result["quantities"].as_array_mut().unwrap() {
        for key in ["u", "U"] {
            q[key] = json!(q[key].as_f64().unwrap() / 10.0);
        }
    }
    for i in result["estimate"]["influences"].as_array_mut().unwrap() {
        let u = &mut i["effect"]["standard_uncertainty"];
        *u = json!(u.as_f64().unwrap() / 10.0);
    }
    scale_covariance(&mut result["estimate"]["covariance"], 0.01);
    scale_covariance(&mut result["covariance"]["matrix"], 0.01);
}

fn alter_trials(folder: &Path, change: impl Fn(f64) -> f64, digest_anew: bool) {
    let place = folder.join("sq/trials.csv");
    let text = fs::read_to_string(&place).unwrap();
    let (heading, rows) = text.split_once('\n').unwrap();
    let line = |row: &str| {
        let of = |field: &str| change(field.parse().unwrap()).to_string();
        row.split(',').map(of).collect::<Vec<_>>().join(",") + "\n"
    };
    let rows: String = rows.lines().map(line).collect();
    fs::write(&place, format!("{heading}\n{rows}")).unwrap();
    if digest_anew {
        let digest = proofmass::io::Input::of(&place).unwrap().sha256;
        edit(folder, SQUARE, |r| {
            r["extra"]["trials"]["sha256"] = json!(digest)
        });
    }
}

fn column(folder: &Path, key: &str, value: &Value) {
    edit(folder, SQUARE, |r| {
        r["extra"]["trials"]["columns"][0][key] = value.clone()
    });
}

#[rustfmt::skip]
const ROWS: &[Row] = &[
    Row { what: "nothing", tamper: |_| {}, listed: Nothing, alone: Unlisted },
    Row { what: "an empty line at the end", tamper: |d| {
            let text = fs::read_to_string(d.join(LINEAR)).unwrap();
            fs::write(d.join(LINEAR), text + "\n").unwrap();
        }, listed: Doubts(CHANGED), alone: Unlisted },
    Row { what: "a value", tamper: |d| edit(d, LINEAR, |r| r["quantities"][0]["value"] = json!(7.5)),
        listed: Refuses("states a as 7.5"), alone: Refuses("states a as 7.5") },
    Row { what: "a value, and the estimate with it", tamper: |d| edit(d, LINEAR, |r| {
            r["quantities"][0]["value"] = json!(7.5);
            r["estimate"]["components"][0]["value"] = json!(7.5);
        }), listed: Doubts(CHANGED), alone: Unlisted },
    Row { what: "u", tamper: |d| edit(d, LINEAR, |r| r["quantities"][0]["u"] = json!(0.005)),
        listed: Refuses("with u = 0.005"), alone: Refuses("with u = 0.005") },
    Row { what: "u in the causes", tamper: |d| edit(d, LINEAR, |r| r["estimate"]["influences"][0]["effect"]["standard_uncertainty"] = json!(0.003)),
        listed: Refuses("states a as"), alone: Refuses("states a as") },
    Row { what: "u everywhere", tamper: |d| edit(d, LINEAR, shrink), listed: Doubts(CHANGED), alone: Unlisted },
    Row { what: "U in the place of u", tamper: |d| edit(d, LINEAR, |r| r["quantities"][0]["u"] = r["quantities"][0]["U"].clone()),
        listed: Refuses("states a as"), alone: Refuses("states a as") },
    Row { what: "U alone", tamper: |d| edit(d, LINEAR, |r| r["quantities"][0]["U"] = json!(0.01)),
        listed: Refuses("but k u is"), alone: Refuses("but k u is") },
    Row { what: "k alone", tamper: |d| edit(d, LINEAR, |r| r["quantities"][0]["k"] = json!(3.0)),
        listed: Refuses("but k u is"), alone: Refuses("but k u is") },
    Row { what: "a unit", tamper: |d| edit(d, LINEAR, |r| r["quantities"][0]["unit"] = json!("mV")),
        listed: Refuses("states a as 7 mV"), alone: Refuses("states a as 7 mV") },
    Row { what: "the covariance", tamper: |d| edit(d, LINEAR, |r| {
            r["covariance"]["matrix"][0][1] = json!(0.0);
            r["covariance"]["matrix"][1][0] = json!(0.0);
        }), listed: Refuses("states the covariance of"), alone: Refuses("states the covariance of") },
    Row { what: "the covariance removed", tamper: |d| edit(d, LINEAR, |r| { r.as_object_mut().unwrap().remove("covariance"); }),
        listed: Doubts(CHANGED), alone: Unlisted },
    Row { what: "a cause removed", tamper: |d| edit(d, LINEAR, |r| { r["estimate"]["influences"].as_array_mut().unwrap().pop(); }),
        listed: Refuses("states a as"), alone: Refuses("states a as") },
    Row { what: "the estimate removed", tamper: |d| edit(d, LINEAR, |r| { r.as_object_mut().unwrap().remove("estimate"); }),
        listed: Refuses("has no estimate"), alone: Refuses("has no estimate") },
    Row { what: "the quantities removed", tamper: |d| edit(d, LINEAR, |r| r["quantities"] = json!([])),
        listed: Refuses("no quantity that it states"), alone: Refuses("no quantity that it states") },
    Row { what: "a quantity renamed", tamper: |d| edit(d, LINEAR, |r| r["quantities"][0]["name"] = json!("alpha")),
        listed: Refuses("no quantity that it states"), alone: Refuses("no quantity that it states") },
    Row { what: "two quantities renamed for each other", tamper: |d| edit(d, LINEAR, |r| {
            r["quantities"][0]["name"] = json!("b");
            r["quantities"][1]["name"] = json!("a");
        }), listed: Refuses("states a as 3"), alone: Refuses("states a as 3") },
    Row { what: "a finding that needs a decision", tamper: |d| edit(d, LINEAR, |r| r["findings"] = json!([{
            "code": "linear-result-not-validated", "severity": "decision", "evidence": "", "advice": "",
            "what": "the linear result of 3 of 18 components differs",
        }])), listed: Doubts("3 of 18 components"), alone: Doubts("3 of 18 components") },
    Row { what: "the date", tamper: |d| edit(d, LINEAR, |r| r["extra"]["date"] = json!("1999-01-01")),
        listed: Doubts(CHANGED), alone: Unlisted },
    Row { what: "the device", tamper: |d| edit(d, LINEAR, |r| r["device"]["serial"] = json!("77")),
        listed: Doubts(CHANGED), alone: Unlisted },
    Row { what: "the version of the form", tamper: |d| edit(d, LINEAR, |r| r["schema"]["version"] = json!(3)),
        listed: Refuses("version 3"), alone: Refuses("version 3") },
    Row { what: "the model that it was computed from", tamper: |d| {
            let text = fs::read_to_string(d.join("lin.toml")).unwrap();
            fs::write(d.join("lin.toml"), text.replace("value = 5", "value = 6")).unwrap();
        }, listed: Doubts(CHANGED), alone: Doubts(CHANGED) },
    Row { what: "its folder moved away", tamper: |d| fs::rename(d.join("lin"), d.join("away")).unwrap(),
        listed: Refuses("lin/result.json"), alone: Refuses("lin/result.json") },
    Row { what: "another result in its place", tamper: |d| { fs::copy(d.join(SQUARE), d.join(LINEAR)).unwrap(); },
        listed: Refuses("trials.csv"), alone: Refuses("trials.csv") },
    Row { what: "trials.csv cut off", tamper: |d| {
            let text = fs::read_to_string(d.join("sq/trials.csv")).unwrap();
            fs::write(d.join("sq/trials.csv"), &text[..text.len() / 2]).unwrap();
        }, listed: Refuses("not the file that was written"), alone: Refuses("not the file that was written") },
    Row { what: "trials.csv removed", tamper: |d| fs::remove_file(d.join("sq/trials.csv")).unwrap(),
        listed: Refuses("keep this file beside"), alone: Refuses("keep this file beside") },
    Row { what: "trials a tenth as wide", tamper: |d| alter_trials(d, |y| 0.1 * y, false),
        listed: Refuses("not the file that was written"), alone: Refuses("not the file that was written") },
    Row { what: "trials a tenth as wide, with their digest", tamper: |d| alter_trials(d, |y| 0.1 * y, true),
        listed: Refuses("not of what the result states"), alone: Refuses("not of what the result states") },
    Row { what: "the value of a column of trials", tamper: |d| column(d, "value", &json!(0.0)),
        listed: Refuses("not of what the result states"), alone: Refuses("not of what the result states") },
    Row { what: "the u of a column of trials", tamper: |d| column(d, "scale", &json!(0.1)),
        listed: Refuses("not of what the result states"), alone: Refuses("not of what the result states") },
    Row { what: "the unit of a column of trials", tamper: |d| column(d, "unit", &json!("mV")),
        listed: Refuses("not of what the result states"), alone: Refuses("not of what the result states") },
    Row { what: "a column of trials called linear", tamper: |d| column(d, "by_trials", &json!(false)),
        listed: Refuses("not of what the result states"), alone: Refuses("not of what the result states") },
    Row { what: "the method", tamper: |d| edit(d, SQUARE, |r| r["quantities"][0]["method"] = json!("law-of-propagation")),
        listed: Refuses("not of what the result states"), alone: Refuses("not of what the result states") },
    Row { what: "the section of the trials and the interval removed, U and k put there", tamper: |d| edit(d, SQUARE, |r| {
            r["extra"].as_object_mut().unwrap().remove("trials");
            let q = r["quantities"][0].as_object_mut().unwrap();
            q.remove("interval");
            let u = q["u"].as_f64().unwrap();
            q.insert("U".to_owned(), json!(2.0 * u));
            q.insert("k".to_owned(), json!(2.0));
        }), listed: Refuses("stated by Monte Carlo"), alone: Refuses("stated by Monte Carlo") },
];

fn run(folder: &Path, arguments: &[&str]) -> std::process::Output {
    std::process::Command::new(env!("CARGO_BIN_EXE_proofmass"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn expect(what: &str, folder: &Path, says: Says) {
    let done = run(
        folder,
        &["uncertainty", "later.toml", "--json", "--trials", "10000"],
    );
    let said = stderr(&done);
    if let Refuses(words) = says {
        let refused = done.status.code() == Some(1) && done.stdout.is_empty();
        assert!(refused && said.contains(words), "{what}: {said}");
        return;
    }
    assert!(done.status.success(), "{what}: {said}");
    let result: Value = serde_json::from_slice(&done.stdout).unwrap();
    let all = result["findings"].as_array().unwrap();
    let doubt = all.iter().find(|f| f["code"] == "earlier-result-in-doubt");
    let unlisted = all.iter().find(|f| f["code"] == "earlier-result-unlisted");
    match says {
        Doubts(words) => {
            let doubt = doubt
                .unwrap_or_else(|| panic!("{what}: no doubt"))
                .to_string();
            assert!(doubt.contains(words), "{what}: {doubt}");
        }
        Unlisted => assert!(doubt.is_none() && unlisted.is_some(), "{what}: {result}"),
        _ => assert!(doubt.is_none() && unlisted.is_none(), "{what}: {result}"),
    }
}

#[test]
fn known_what_is_said_of_an_altered_earlier_result() {
    let input = |name: &str, value: f64, u: f64| {
        format!("[[input]]\nname = \"{name}\"\nunit = \"V\"\nvalue = {value:?}\nu = {u:?}\n")
    };
    let output = |name: &str, unit: &str, formula: &str| {
        format!("[[output]]\nname = \"{name}\"\nunit = \"{unit}\"\nexpression = \"{formula}\"\n")
    };
    let whole = tempfile::tempdir().unwrap();
    let linear = input("r", 5.0, 0.03)
        + &input("s", 2.0, 0.04)
        + &output("a", "V", "r + s")
        + &output("b", "V", "r - s");
    fs::write(whole.path().join("lin.toml"), linear).unwrap();
    let square = input("x", 0.0, 1.0) + &output("y", "V^2", "x^2");
    fs::write(whole.path().join("sq.toml"), square).unwrap();
    for name in ["lin", "sq"] {
        let model = format!("{name}.toml");
        let arguments = ["uncertainty", &model, "-o", name, "--trials", "20000"];
        let done = run(whole.path(), &arguments);
        assert!(done.status.success(), "{}", stderr(&done));
    }
    let later = "[[earlier]]\nfile = \"lin/result.json\"\nquantities = { A = \"a\", B = \"b\" }\n\
                 [[earlier]]\nfile = \"sq/result.json\"\nquantities = { Y = \"y\" }\n"
        .to_owned()
        + &output("total", "V", "A + B")
        + &output("double", "V^2", "2 * Y");
    fs::write(whole.path().join("later.toml"), later).unwrap();
    for row in ROWS {
        for (says, listed) in [(row.listed, true), (row.alone, false)] {
            let folder = tempfile::tempdir().unwrap();
            copy(whole.path(), folder.path(), None);
            if !listed {
                for name in ["lin", "sq"] {
                    fs::remove_file(folder.path().join(name).join("manifest.json")).unwrap();
                }
            }
            (row.tamper)(folder.path());
            expect(row.what, folder.path(), says);
        }
    }
}

/// A result that was altered is not written again as one that nobody changed, and no list beside it speaks for another file.
#[test]
fn refuses_to_write_an_altered_result_anew() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let model = "[[input]]\nname = \"r\"\nunit = \"V\"\nvalue = 2\nu = 0.1\n\
                 [[output]]\nname = \"y\"\nunit = \"V\"\nexpression = \"r\"\n";
    fs::write(here.join("m.toml"), model).unwrap();
    let make = |arguments: &[&str]| run(here, arguments);
    assert!(make(&["uncertainty", "m.toml", "-o", "s"]).status.success());
    assert!(make(&["keygen", "lab"]).status.success());
    assert!(
        make(&["render", "s", "-o", "again", "--sign", "lab.key"])
            .status
            .success()
    );
    edit(here, "s/result.json", |r| {
        r["quantities"][0]["value"] = json!(2.7);
        r["estimate"]["components"][0]["value"] = json!(2.7);
    });
    let refused = make(&["render", "s", "-o", "washed"]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(stderr(&refused).contains(CHANGED), "{}", stderr(&refused));
    assert!(!here.join("washed").exists());
    assert!(
        make(&["render", "s"]).status.success(),
        "it may be looked at"
    );
    fs::remove_file(here.join("s/manifest.json")).unwrap();
    let refused = make(&["render", "s", "-o", "washed", "--sign", "lab.key"]);
    assert!(
        stderr(&refused).contains("manifest.json"),
        "{}",
        stderr(&refused)
    );
    // Beside a list that does not name it.
    fs::copy(here.join("s/result.json"), here.join("again/monday.json")).unwrap();
    let later = "[[earlier]]\nfile = \"again/monday.json\"\nquantities = { Y = \"y\" }\n\
                 [[output]]\nname = \"z\"\nunit = \"V\"\nexpression = \"Y\"\n";
    fs::write(here.join("later.toml"), later).unwrap();
    let said = make(&["uncertainty", "later.toml", "--json", "--trials", "10000"]);
    let result: Value = serde_json::from_slice(&said.stdout).unwrap();
    let all = result["findings"].as_array().unwrap();
    assert!(all.iter().any(|f| f["code"] == "earlier-result-unlisted"));
    // Draws replace nothing that is there.
    fs::write(here.join("notes.txt"), "mine").unwrap();
    let refused = make(&[
        "uncertainty",
        "m.toml",
        "--draws",
        "notes.txt",
        "--trials",
        "10000",
    ]);
    assert!(stderr(&refused).contains("--force"), "{}", stderr(&refused));
    assert_eq!(fs::read_to_string(here.join("notes.txt")).unwrap(), "mine");
}

/// Warnings of an earlier result are said where it is used.
#[test]
fn known_warnings_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let model = "[[input]]\nname = \"x\"\nunit = \"1\"\nvalues = [0, 1, 2, 3]\n\
                 [[input]]\nname = \"y\"\nunit = \"1\"\nvalues = [1, 5, 3, 9]\nu = 0.1\n\
                 [[fit]]\nname = \"line\"\nx = \"x\"\ny = \"y\"\nparameters = [\"a\", \"b\"]\n\
                 [[output]]\nname = \"b\"\nunit = \"1\"\n";
    fs::write(here.join("m.toml"), model).unwrap();
    assert!(
        run(here, &["uncertainty", "m.toml", "-o", "s"])
            .status
            .success()
    );
    let later = "[[earlier]]\nfile = \"s/result.json\"\nquantities = { B = \"b\" }\n\
                 [[output]]\nname = \"z\"\nunit = \"1\"\nexpression = \"2 * B\"\n";
    fs::write(here.join("later.toml"), later).unwrap();
    let said = run(
        here,
        &["uncertainty", "later.toml", "--json", "--trials", "10000"],
    );
    let result: Value = serde_json::from_slice(&said.stdout).unwrap();
    let all = result["findings"].as_array().unwrap();
    let warned = all.iter().find(|f| f["code"] == "earlier-result-warned");
    assert!(warned.is_some_and(|f| f.to_string().contains("residuals of line")));
}
