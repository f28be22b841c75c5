//! `proofmass uncertainty`: published results out, bad model files refused with their line.

use crate::support::*;
use std::path::PathBuf;

fn example(name: &str) -> PathBuf {
    PathBuf::from(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/data/uncertainty"
    ))
    .join(name)
}

/// Runs a model that must be refused, and gives back what was said; nothing may be written.
fn refuse_model(model: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    std::fs::write(&path, model).unwrap();
    let output = folder.path().join("result");
    let said = refuse(&["uncertainty", text(&path), "-o", text(&output)]);
    assert!(
        holds_only(folder.path(), &["model.toml"]),
        "something was left behind"
    );
    assert!(said.contains("hint:"), "no remedy: {said}");
    said
}

fn assert_says(said: &str, words: &[&str]) {
    for word in words {
        assert!(said.contains(word), "{word:?} is missing from: {said}");
    }
}

fn model(distribution: &str, expression: &str) -> String {
    format!(
        "[[input]]\nname = \"a\"\nunit = \"m\"\ndistribution = {distribution}\n\n\
         [[output]]\nname = \"y\"\nunit = \"m\"\nexpression = \"{expression}\"\n"
    )
}

#[test]
fn published_end_gauge_gum_h1() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("result");
    let run = succeed(&[
        "uncertainty",
        "--details",
        text(&example("end-gauge.toml")),
        "-o",
        text(&output),
        "--trials",
        "100000",
    ]);
    let said = String::from_utf8_lossy(&run.stdout).into_owned();
    // Terms of second order and few degrees of freedom move the ends by less than half a unit of one digit.
    assert_says(
        &said,
        &["50000838", "Budget of l", "The law of propagation holds"],
    );
    assert!(!said.contains("not-validated"), "{said}");
    let result = json(&output.join("result.json"));
    let (value, u, _) = quantity(&result, "l");
    assert!((value - 50_000_838.0).abs() < 0.5, "{value}");
    // [GUM] H.1.7: 32 nm, 31.664 before rounding; H.1.6: ν_eff = 16.75 before truncation.
    assert!((u - 31.664).abs() < 5e-3, "{u}");
    let nu = result["quantities"][0]["nu_eff"].as_f64().unwrap();
    assert!((nu - 16.75).abs() < 0.05, "{nu}");
    let csv = std::fs::read_to_string(output.join("budget.csv")).unwrap();
    assert_eq!(csv.lines().count(), 10, "{csv}"); // a heading, eight inputs, the sum
    let page = std::fs::read_to_string(output.join("report.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("Monte Carlo"));
}

#[test]
fn published_impedance_gum_h2_and_mass_s1_9_3() {
    let run = succeed(&[
        "uncertainty",
        text(&example("impedance.toml")),
        "--trials",
        "20000",
        "--json",
    ]);
    let result: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    let (value, u, _) = quantity(&result, "R");
    // [GUM] table H.4
    assert!((value - 127.732).abs() < 5e-4 && (u - 0.071).abs() < 5e-4);

    let run = succeed(&["uncertainty", text(&example("mass.toml")), "--json"]);
    let result: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    // [S1] table 5: u = 0.0754; the law of propagation gives 0.0539 and is not validated.
    let (_, u, _) = quantity(&result, result["quantities"][0]["name"].as_str().unwrap());
    assert!((u - 0.0754).abs() < 5e-4, "{u}");
    assert!(
        codes(&result)
            .iter()
            .any(|c| c == "linear-result-not-validated")
    );
    // The one result is that of the trials: [S1] 9.3.3 gives [1.083, 1.382].
    let interval = &result["quantities"][0]["interval"];
    assert!((interval[0].as_f64().unwrap() - 1.0834).abs() < 2e-3);
    assert!((interval[1].as_f64().unwrap() - 1.3825).abs() < 2e-3);
}

#[test]
fn law_the_same_seed_gives_the_same_bytes() {
    let path = example("end-gauge.toml");
    let run = |seed: &str| {
        let arguments = [
            "uncertainty",
            text(&path),
            "--json",
            "--trials",
            "20000",
            "--seed",
            seed,
        ];
        succeed(&arguments).stdout
    };
    assert_eq!(run("7"), run("7"));
    assert_ne!(run("7"), run("8"));
}

#[test]
fn refuses_an_empty_file() {
    assert_says(&refuse_model(""), &["model.toml:1:", "output"]);
}

#[test]
fn refuses_an_unknown_key() {
    let text = model("{ kind = \"normal\", mean = 1.0, u = 0.1 }", "a")
        .replace("unit = \"m\"\ndist", "colour = \"red\"\nunit = \"m\"\ndist");
    assert_says(&refuse_model(&text), &["model.toml:3:", "colour"]);
}

#[test]
fn refuses_an_unknown_variable() {
    let text = model("{ kind = \"normal\", mean = 1.0, u = 0.1 }", "2 * b");
    assert_says(&refuse_model(&text), &["model.toml:9:", "2 * b", "b"]);
}

#[test]
fn refuses_impossible_uncertainties() {
    for u in ["-0.1", "nan", "inf"] {
        let text = model(
            &format!("{{ kind = \"normal\", mean = 1.0, u = {u} }}"),
            "a",
        );
        assert_says(
            &refuse_model(&text),
            &["model.toml:4:", "distribution", "input a"],
        );
    }
    let text = model("{ kind = \"normal\", mean = nan, u = 0.1 }", "a");
    assert_says(
        &refuse_model(&text),
        &["model.toml:4:", "distribution", "input a"],
    );
}

#[test]
fn refuses_correlations_that_contradict_each_other() {
    let mut text = String::new();
    for name in ["a", "b", "c"] {
        text += &format!(
            "[[input]]\nname = \"{name}\"\nunit = \"1\"\ndistribution = {{ kind = \"normal\", mean = 1.0, u = 0.1 }}\n"
        );
    }
    for (a, b, r) in [("a", "b", 0.9), ("b", "c", 0.9), ("a", "c", -0.9)] {
        text += &format!("[[correlation]]\nbetween = [\"{a}\", \"{b}\"]\ncoefficient = {r}\n");
    }
    text += "[[output]]\nname = \"y\"\nunit = \"1\"\nexpression = \"a + b + c\"\n";
    assert_says(
        &refuse_model(&text),
        &["model.toml:21:", "coefficient", "correlation"],
    );
}

#[test]
fn refuses_coefficients_that_no_pair_has() {
    let start = "[[input]]\nname = \"a\"\nunit = \"1\"\ndistribution = { kind = \"normal\", mean = 1.0, u = 0.1 }\n\
                 [[input]]\nname = \"b\"\nunit = \"1\"\ndistribution = { kind = \"normal\", mean = 1.0, u = 0.1 }\n\
                 [[output]]\nname = \"y\"\nunit = \"1\"\nexpression = \"a + b\"\n";
    let entry = |between: &str, r: &str| {
        format!("[[correlation]]\nbetween = [{between}]\ncoefficient = {r}\n")
    };
    for (entries, wanted) in [
        (entry("\"a\", \"b\"", "1.5"), ["model.toml:15:", "outside"]),
        (entry("\"a\", \"a\"", "0.5"), ["model.toml:15:", "itself"]),
        (
            entry("\"a\", \"b\"", "0.5") + &entry("\"b\", \"a\"", "-0.5"),
            ["model.toml:18:", "twice"],
        ),
        (
            entry("\"a\", \"b\", \"a\"", "0.5"),
            ["model.toml:14:", "not 3"],
        ),
    ] {
        assert_says(&refuse_model(&(start.to_owned() + &entries)), &wanted);
    }
}

#[test]
fn refuses_a_formula_that_is_not_finite() {
    let text = model(
        "{ kind = \"normal\", mean = 0.0, u = 0.1 }",
        "sqrt(-1 - a^2)",
    );
    assert_says(&refuse_model(&text), &["model.toml", "output y", "finite"]);
    let text = model("{ kind = \"normal\", mean = 0.1, u = 0.1 }", "ln(a - 9)");
    assert_says(&refuse_model(&text), &["model.toml", "output y", "finite"]);
}

#[test]
fn law_an_earlier_result_keeps_its_causes() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let input = |name: &str, value: f64, u: f64| {
        format!("[[input]]\nname = \"{name}\"\nunit = \"V\"\nvalue = {value:?}\nu = {u:?}\n")
    };
    for (day, own) in [("monday", 0.01), ("tuesday", 0.02)] {
        let model = input("reference", 5.0, 0.03)
            + &input(day, 0.0, own)
            + &format!(
                "[[output]]\nname = \"gain\"\nunit = \"V\"\nexpression = \"reference + {day}\"\n"
            );
        let path = write(&format!("{day}.toml"), &model);
        let output = folder.path().join(day);
        succeed(&[
            "uncertainty",
            text(&path),
            "-o",
            text(&output),
            "--trials",
            "10000",
        ]);
    }
    let later = "[[earlier]]\nfile = \"monday/result.json\"\nquantities = { g = \"gain\" }\n\
                 [[earlier]]\nfile = \"tuesday/result.json\"\nquantities = { h = \"gain\" }\n\
                 [[output]]\nname = \"d\"\nunit = \"V\"\nexpression = \"h - g\"\n";
    let path = write("later.toml", later);
    let output = folder.path().join("later");
    succeed(&[
        "uncertainty",
        text(&path),
        "-o",
        text(&output),
        "--trials",
        "10000",
    ]);
    let result = json(&output.join("result.json"));
    let (value, u, _) = quantity(&result, "d");
    assert!(
        value.abs() < 1e-12 && (u - 0.01f64.hypot(0.02)).abs() < 1e-12,
        "{value} {u}"
    );
    // Every file it was made from is named with its digest.
    let all = result.to_string();
    assert!(all.contains("monday/result.json") && all.contains("tuesday/result.json"));
    let said = refuse_model(
        "[[earlier]]\nfile = \"absent.json\"\nquantities = { g = \"gain\" }\n[[output]]\nname = \"d\"\nunit = \"V\"\nexpression = \"g\"\n",
    );
    assert_says(&said, &["absent.json"]);
    let wrong = write("wrong.toml", &later.replace("g = \"gain\"", "g = \"gian\""));
    let said = refuse(&[
        "uncertainty",
        text(&wrong),
        "-o",
        text(&folder.path().join("w")),
    ]);
    assert_says(&said, &["wrong.toml:2", "no quantity gian; it has gain"]);
}

/// A square that Monte Carlo states enters a second model as it was stated, and only with the trials that were written with it.
#[test]
fn law_what_is_read_again_is_what_was_stated() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let square = "[[input]]\nname = \"x\"\nunit = \"1\"\nvalue = 0\nu = 1\n\
                  [[output]]\nname = \"y\"\nunit = \"1\"\nexpression = \"x^2\"\n";
    std::fs::write(at("square.toml"), square).unwrap();
    let first = at("first");
    let square = at("square.toml");
    succeed(&["uncertainty", text(&square), "-o", text(&first)]);
    let result = json(&first.join("result.json"));
    let stated = &result["quantities"][0];
    // An interval that is not y ± k u has neither.
    assert!(
        stated.get("U").is_none() && stated.get("k").is_none(),
        "{stated}"
    );
    assert!(stated["interval"][0].as_f64().unwrap() > 0.0);
    // The linear result is there for information, and the estimate says what is stated.
    assert_eq!(result["extra"]["linear"][0]["u"], 0.0);
    assert_eq!(
        result["estimate"]["components"][0]["value"],
        stated["value"]
    );
    let later = "[[earlier]]\nfile = \"first/result.json\"\nquantities = { q = \"y\" }\n\
                 [[output]]\nname = \"z\"\nunit = \"1\"\nexpression = \"3 * q\"\n";
    std::fs::write(at("later.toml"), later).unwrap();
    let later = at("later.toml");
    succeed(&["uncertainty", text(&later), "-o", text(&at("second"))]);
    let second = json(&at("second/result.json"));
    let linear = &second["extra"]["linear"][0];
    let (value, u) = (
        linear["value"].as_f64().unwrap(),
        linear["u"].as_f64().unwrap(),
    );
    assert!(
        // Mean of 200 000 trials with u = √2, five standard deviations.
        (value - 3.0 * stated["value"].as_f64().unwrap()).abs() < 0.05,
        "{value}"
    );
    assert!(
        // χ² has a kurtosis of 15: their u is known to 0.4 %.
        (u - 3.0 * stated["u"].as_f64().unwrap()).abs() < 0.1,
        "{u}"
    );
    // Both files are inputs, with their digests; rendered elsewhere, the trials go along.
    assert!(second["inputs"].to_string().contains("trials.csv"));
    succeed(&["render", text(&first), "-o", text(&at("again"))]);
    let trials = std::fs::read(first.join("trials.csv")).unwrap();
    assert_eq!(std::fs::read(at("again/trials.csv")).unwrap(), trials);
    // One digit of the trials, then no trials, then a result.json of a version that kept the refuted estimate.
    let mut altered = trials.clone();
    let last = altered.len() - 2;
    altered[last] = if altered[last] == b'1' { b'2' } else { b'1' };
    std::fs::write(first.join("trials.csv"), altered).unwrap();
    let said = refuse(&["uncertainty", text(&later)]);
    assert_says(&said, &["trials.csv", "not the file that was written"]);
    std::fs::remove_file(first.join("trials.csv")).unwrap();
    let said = refuse(&["uncertainty", text(&later)]);
    assert_says(
        &said,
        &["trials.csv", "keep this file beside its result.json"],
    );
    let mut old = result.clone();
    old["extra"].as_object_mut().unwrap().remove("trials");
    old["estimate"]["components"][0]["value"] = 0.0.into();
    std::fs::write(first.join("result.json"), old.to_string()).unwrap();
    let said = refuse(&["uncertainty", text(&later)]);
    assert_says(&said, &["states y as", "evaluate it again"]);
}

/// Each method by its option: linear states u = 0 where it is asked to, and says so in a line.
#[test]
fn known_method_of_the_statement() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    let square = "[[input]]\nname = \"x\"\nunit = \"V\"\nvalue = 1\nu = 0.5\n\
                  [[output]]\nname = \"y\"\nunit = \"V²\"\nexpression = \"x^2\"\n";
    std::fs::write(&path, square).unwrap();
    for (method, line) in [
        (
            "linear",
            "y = (1.0 ± 2.0) V², k = 1.96, p = 95 %, ν = ∞, by law of propagation",
        ),
        (
            "second-order",
            "by law of propagation with terms of second order",
        ),
        (
            "monte-carlo",
            "u = 1.1 V², interval 0.0 to 3.9 V², p = 95 %, by Monte Carlo",
        ),
    ] {
        let run = succeed(&["uncertainty", text(&path), "--method", method, "--details"]);
        let said = String::from_utf8_lossy(&run.stdout).into_owned();
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_says(&said, &[line, "By the law of propagation"]);
    }
    let run = succeed(&["uncertainty", text(&path), "-k", "2", "--details"]);
    let said = String::from_utf8_lossy(&run.stdout).into_owned();
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert_says(&said, &["y = (1.2 ± 2.1) V², k = 2.00", "by Monte Carlo"]);
}

/// A factor that is asked for has another probability at each number of degrees of freedom, and each is said.
#[test]
fn known_probability_of_a_fixed_factor() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    std::fs::write(
        &path,
        "input = [\n\
         { name = \"a\", unit = \"V\", observations = [1.0, 1.1, 0.9] },\n\
         { name = \"b\", unit = \"V\", value = 2, u = 0.01 },\n\
         { name = \"n\", unit = \"1\", value = 3 },\n]\n\
         output = [{ name = \"y\", unit = \"V\", expression = \"a\" }, { name = \"z\", unit = \"V\", expression = \"n * b\" }]\n",
    )
    .unwrap();
    let run = succeed(&[
        "uncertainty",
        text(&path),
        "--coverage-factor",
        "2",
        "--details",
    ]);
    let said = String::from_utf8_lossy(&run.stdout);
    // Two-sided probabilities of 2 u at ν = 2 and of the normal distribution.
    assert_says(
        &said,
        &["Results with k = 2", "p / %", "81.6", "95.4", "constant"],
    );
}

/// Readings from a table, conformity, a sweep, a target and the trials, in one run.
#[test]
fn what_is_asked_beside_the_outputs() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("readings.csv"), "n;V\n1;4,9\n2;5,1\n3;5,0\n4;5,0\n").unwrap();
    std::fs::write(
        at("model.toml"),
        "[[input]]\nname = \"V\"\nunit = \"V\"\nfile = \"readings.csv\"\ncolumn = \"V\"\n\
         [[input]]\nname = \"R\"\nunit = \"Ω\"\nvalue = 100\nu = 3\n\
         [[output]]\nname = \"P\"\nunit = \"W\"\nexpression = \"V^2 / R\"\n\
         [[conformity]]\noutput = \"P\"\nupper = 0.3\nguard_band = 1\n",
    )
    .unwrap();
    let (model, output, draws) = (at("model.toml"), at("result"), at("draws.csv"));
    let asked = [
        "uncertainty",
        text(&model),
        "-k",
        "2",
        "--trials",
        "20000",
        "--sweep",
        "R=50:200:4",
        "--target",
        "P=0.014",
        "--draws",
        text(&draws),
    ];
    let run = succeed(&[&asked[..], &["-o", text(&output), "--details"]].concat());
    let said = String::from_utf8_lossy(&run.stdout).into_owned();
    assert_says(
        &said,
        &[
            "Conformity",
            "accepted",
            "Sweep of R",
            "Target uncertainty of P",
        ],
    );
    let result = json(&output.join("result.json"));
    let inputs = result["inputs"].as_array().unwrap();
    assert!(
        inputs
            .iter()
            .any(|i| i["path"].as_str().unwrap().ends_with("readings.csv"))
    );
    assert_eq!(
        result["extra"]["sweeps"][0]["points"]
            .as_array()
            .unwrap()
            .len(),
        4
    );
    // u(P)² = (2 V/R u(V))² + (V²/R² u(R))², with u(V) = √(0.02/12) V and u(R) = 3 Ω; 0.007 W are wanted.
    let readings = (0.1f64 * (0.02f64 / 12.0).sqrt()).powi(2);
    let needed = ((0.007f64.powi(2) - readings) / 0.0025f64.powi(2)).sqrt();
    let target = &result["extra"]["targets"][0]["inputs"][1];
    assert_eq!(target["input"], "R");
    assert!(
        (target["needed"].as_f64().unwrap() / needed - 1.0).abs() < 1e-5,
        "{target}"
    );
    for name in ["conformity.csv", "sweep.csv", "target_P.csv"] {
        assert!(output.join(name).is_file(), "{name}");
    }
    let sweep = std::fs::read_to_string(output.join("sweep.csv")).unwrap();
    assert_eq!(sweep.lines().count(), 5, "{sweep}");
    // The trials are those of the result.
    let table = std::fs::read_to_string(&draws).unwrap();
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("P_W"));
    let values: Vec<f64> = lines.map(|line| line.parse().unwrap()).collect();
    assert_eq!(values.len(), 20_000);
    let mean = values.iter().sum::<f64>() / 20_000.0;
    assert!((mean - 0.2505).abs() < 0.0005, "{mean}");

    // What cannot be answered is said, and nothing is written.
    for (option, value, word, code) in [
        ("--sweep", "R=50:200", "FROM:TO:STEPS", 2),
        ("--sweep", "Q=50:200:4", "no input is called Q", 1),
        ("--target", "P=much", "OUTPUT=U", 2),
        ("--target", "Q=1", "no output is called Q", 1),
    ] {
        let other = at("other");
        let run = proofmass(&[
            "uncertainty",
            text(&model),
            option,
            value,
            "-o",
            text(&other),
        ]);
        let said = stderr(&run);
        assert_eq!(run.status.code(), Some(code), "{said}");
        assert!(said.contains(word) && !other.exists(), "{said}");
    }
    // A field that is no number, with file, line and column.
    std::fs::write(at("readings.csv"), "n;V\n1;4,9\n2;five\n").unwrap();
    let said = refuse(&["uncertainty", text(&model)]);
    assert_says(&said, &["readings.csv:3", "five"]);
    // A draws file may not replace an input.
    std::fs::write(at("readings.csv"), "n;V\n1;4,9\n2;5,0\n").unwrap();
    refuse(&[
        "uncertainty",
        text(&model),
        "--trials",
        "10000",
        "--draws",
        text(&at("readings.csv")),
    ]);
}
