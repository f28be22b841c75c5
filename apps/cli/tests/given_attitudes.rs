//! Attitudes of a multi-position calibration as a person gives them: words, vectors, angles, or the true acceleration itself.

use crate::support::axis::column;
use crate::support::*;
use std::fmt::Write;
use std::path::Path;

/// Local gravity, m/s², and what the tests say of it.
const GRAVITY: f64 = 9.80665;
const PLACE: [&str; 4] = ["--gravity", "9.80665", "--gravity-uncertainty", "1e-4"];
const K: [[f64; 3]; 3] = [
    [1.012, 0.004, -0.003],
    [-0.005, 0.991, 0.006],
    [0.002, -0.004, 1.021],
];
const B: [f64; 3] = [0.12, -0.25, 0.31];
/// The edges of a cube: twelve oblique positions, each between two axes.
const WORDS: [&str; 12] = [
    "+x+y", "+x-y", "-x+y", "-x-y", "+x+z", "+x-z", "-x+z", "-x-z", "+y+z", "+y-z", "-y+z", "-y-z",
];

fn up(word: &str) -> [f64; 3] {
    let mut v = [0.0; 3];
    let letters: Vec<char> = word.chars().collect();
    for pair in letters.chunks(2) {
        let axis = "xyz".find(pair[1]).unwrap();
        v[axis] = if pair[0] == '+' {
            0.5f64.sqrt()
        } else {
            -0.5f64.sqrt()
        };
    }
    v
}

fn output(a: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| (0..3).map(|j| K[i][j] * a[j]).sum::<f64>() + B[i])
}

/// Headings and fields of one form of the attitudes.
fn form(which: &str, word: &str) -> (&'static str, String) {
    let v = up(word);
    let [x, y, z] = v;
    match which {
        "word" => ("direction", word.to_owned()),
        "vector" => ("up_x,up_y,up_z", format!("{x:.15},{y:.15},{z:.15}")),
        "angles" => {
            let (pitch, roll) = ((-x).asin().to_degrees(), y.atan2(z).to_degrees());
            ("roll_deg,pitch_deg", format!("{roll:.13},{pitch:.13}"))
        }
        "m/s2" => (
            "a_true_x_m/s2,a_true_y_m/s2,a_true_z_m/s2",
            v.map(|c| format!("{:.14}", c * GRAVITY)).join(","),
        ),
        _ => (
            "a_true_x_g,a_true_y_g,a_true_z_g",
            v.map(|c| format!("{c:.15}")).join(","),
        ),
    }
}

/// Twelve means that scatter by 2 mm/s², with attitudes in one form.
fn table(which: &str) -> String {
    table_of(which, &mut Chance(7))
}

fn table_of(which: &str, normal: &mut Chance) -> String {
    let mut text = format!(
        "acc_x_m/s2,acc_y_m/s2,acc_z_m/s2,{}\n",
        form(which, WORDS[0]).0
    );
    for word in WORDS {
        let [x, y, z] = output(up(word).map(|u| GRAVITY * u)).map(|o| o + 2e-3 * normal.normal());
        writeln!(text, "{x:.6},{y:.6},{z:.6},{}", form(which, word).1).unwrap();
    }
    text
}

/// Name, value, u and U of all twelve parameters.
fn parameters(result: &Path) -> Vec<(String, f64, f64, f64)> {
    let result = json(&result.join("result.json"));
    let list = result["quantities"].as_array().unwrap();
    let number = |q: &serde_json::Value, key: &str| q[key].as_f64().unwrap();
    let all = list.iter().map(|q| {
        let name = q["name"].as_str().unwrap().to_owned();
        (name, number(q, "value"), number(q, "u"), number(q, "U"))
    });
    let own = ["bias.", "scale.", "misalignment."];
    all.filter(|q| own.iter().any(|k| q.0.starts_with(k)))
        .collect()
}

/// The call that calibrates a table of readings.
fn call<'a>(file: &'a Path, more: &[&'a str]) -> Vec<&'a str> {
    let beginning = [
        "calibrate",
        text(file),
        "--rows",
        "readings",
        "--model",
        "full",
    ];
    [&beginning[..], &PLACE, more].concat()
}

fn calibrated(folder: &Path, text_of_table: &str, more: &[&str]) -> Vec<(String, f64, f64, f64)> {
    let (file, out) = (folder.join("positions.csv"), folder.join("out"));
    std::fs::write(&file, text_of_table).unwrap();
    succeed(&[&call(&file, more)[..], &["-o", text(&out)]].concat());
    parameters(&out)
}

fn truth(name: &str) -> f64 {
    let (what, axes) = name.split_once('.').unwrap();
    let axis: Vec<usize> = axes.chars().map(|c| "xyz".find(c).unwrap()).collect();
    match what {
        "bias" => B[axis[0]],
        "scale" => K[axis[0]][axis[0]],
        _ => K[axis[0]][axis[1]] / K[axis[0]][axis[0]],
    }
}

/// Twelve oblique positions with the true acceleration beside the measured one, as a table of readings: bias and K are found.
#[test]
fn known_twelve_positions_with_true_accelerations() {
    let folder = tempfile::tempdir().unwrap();
    let all = calibrated(
        folder.path(),
        &table("m/s2"),
        &["--a-true-uncertainty", "0.002"],
    );
    assert_eq!(all.len(), 12);
    for (name, value, u, expanded) in all {
        // One seed, at four standard uncertainties; the map has the coverage.
        assert!(
            (value - truth(&name)).abs() < 4.0 * u,
            "{name}: {value} ± {u}"
        );
        assert!(expanded > u);
    }
    let page = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(page.contains("True accelerations were given for 12 readings"));
}

/// Words, vectors, angles and true accelerations that mean the same give the same numbers: digits of a table are 1e-13.
#[test]
fn law_every_form_of_an_attitude_gives_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    // 0.01° about each transverse axis is g · 0.01 · π/180 across the true acceleration.
    let degrees = ["--attitude-uncertainty", "0.01"];
    let across = format!("{}", GRAVITY * 0.01f64.to_radians());
    let accelerations = ["--a-true-uncertainty", across.as_str()];
    let word = calibrated(folder.path(), &table("word"), &degrees);
    for (which, more) in [
        ("vector", degrees),
        ("angles", degrees),
        ("m/s2", accelerations),
        ("g", accelerations),
    ] {
        let other = calibrated(folder.path(), &table(which), &more);
        for (a, b) in word.iter().zip(&other) {
            for (p, q) in [(a.1, b.1), (a.2, b.2), (a.3, b.3)] {
                assert!(
                    (p - q).abs() < 1e-9 * p.abs().max(1e-3),
                    "{which}: {a:?} {b:?}"
                );
            }
        }
    }
    // The same by a list of a campaign.
    let list: Vec<String> = WORDS
        .iter()
        .enumerate()
        .map(|(i, word)| {
            let [x, y, z] = up(word);
            match i % 3 {
                0 => format!("{word:?}"),
                1 => format!("[{x:.15}, {y:.15}, {z:.15}]"),
                _ => {
                    let (pitch, roll) = ((-x).asin().to_degrees(), y.atan2(z).to_degrees());
                    format!("{{ roll_deg = {roll:.13}, pitch_deg = {pitch:.13} }}")
                }
            }
        })
        .collect();
    let toml = format!(
        "kind = \"multi-position\"\n[recording]\nfile = \"plain.csv\"\ncolumns = {{ x = \"acc_x_m/s2\", y = \"acc_y_m/s2\", z = \"acc_z_m/s2\" }}\nrows = \"readings\"\n[gravity]\nvalue = {GRAVITY}\nstandard_uncertainty = 1e-4\n[standstill]\ndirections = [{}]\n[method]\nmodel = \"full\"\n[attitude]\nstandard_uncertainty_deg = 0.01\n",
        list.join(", ")
    );
    let place = folder.path().join("campaign");
    campaign(&place, &toml);
    let plain: String = table("word")
        .lines()
        .map(|line| format!("{}\n", line.rsplit_once(',').unwrap().0))
        .collect();
    std::fs::write(place.join("plain.csv"), plain).unwrap();
    succeed(&["calibrate", text(&place)]);
    for (a, b) in word.iter().zip(&parameters(&place.join("result"))) {
        assert!(
            (a.1 - b.1).abs() < 1e-9 && (a.3 - b.3).abs() < 1e-9 * a.3,
            "{a:?} {b:?}"
        );
    }
}

/// The uncertainty of the true accelerations reaches the budget: where the noise of a reading is known and small, U grows with it.
#[test]
fn known_uncertainty_of_the_true_acceleration_is_in_the_budget() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("campaign");
    let mut widths = Vec::new();
    for u in [0.001, 0.02] {
        campaign(
            &place,
            &format!(
                "kind = \"multi-position\"\n[recording]\nfile = \"positions.csv\"\ncolumns = {{ x = \"acc_x_m/s2\", y = \"acc_y_m/s2\", z = \"acc_z_m/s2\" }}\nrows = \"readings\"\n[gravity]\nvalue = {GRAVITY}\nstandard_uncertainty = 1e-4\n[standstill]\nreading_standard_uncertainty = 0.002\n[method]\nmodel = \"full\"\n[attitude]\na_true_standard_uncertainty = {u}\nframe_standard_uncertainty_deg = 0.05\n"
            ),
        );
        std::fs::write(place.join("positions.csv"), table("m/s2")).unwrap();
        succeed(&["calibrate", text(&place)]);
        let page = std::fs::read_to_string(place.join("result/report.html")).unwrap();
        for cause in ["each attitude", "orientation of the frame of all attitudes"] {
            assert!(page.contains(cause), "{cause}");
        }
        let all = parameters(&place.join("result"));
        let u = |name: &str| all.iter().find(|p| p.0 == name).unwrap().2;
        // One turn of the frame by 0.05° turns every misalignment by as much, and no residual shows it.
        let frame = 0.05f64.to_radians();
        assert!(u("misalignment.xy") >= frame, "{all:?}");
        widths.push((u("misalignment.xy").powi(2) - frame.powi(2)).sqrt());
    }
    // Eight of twelve positions show a misalignment, across gravity, with (0.002² + u²)^½/g each: 0.08 and 0.7 mrad.
    assert!(widths[1] > 5.0 * widths[0], "{widths:?}");
}

/// On an arm the lengths differ: they count where the campaign says so, with their own common uncertainty in the place of that of gravity.
#[test]
fn known_true_accelerations_of_other_lengths() {
    let folder = tempfile::tempdir().unwrap();
    let mut normal = Chance(3);
    let mut table =
        "acc_x_m/s2,acc_y_m/s2,acc_z_m/s2,a_true_x_g,a_true_y_g,a_true_z_g\n".to_owned();
    for (i, word) in WORDS.iter().enumerate() {
        let a = up(word).map(|u| u * GRAVITY * [1.0, 3.0, 5.0][i % 3]);
        let [x, y, z] = output(a).map(|o| o + 2e-3 * normal.normal());
        let [p, q, r] = a.map(|c| c / GRAVITY);
        writeln!(table, "{x:.6},{y:.6},{z:.6},{p:.9},{q:.9},{r:.9}").unwrap();
    }
    let place = folder.path().join("campaign");
    let toml = |attitude: &str| {
        format!(
            "kind = \"multi-position\"\n[recording]\nfile = \"arm.csv\"\ncolumns = {{ x = \"acc_x_m/s2\", y = \"acc_y_m/s2\", z = \"acc_z_m/s2\" }}\nrows = \"readings\"\n[gravity]\nvalue = {GRAVITY}\nstandard_uncertainty = 1e-4\n[method]\nmodel = \"full\"\n[attitude]\na_true_standard_uncertainty = 0.001\n{attitude}"
        )
    };
    campaign(&place, &toml(""));
    std::fs::write(place.join("arm.csv"), table).unwrap();
    let said = refuse(&["calibrate", text(&place)]);
    assert!(
        said.contains("200.00 %") && said.contains("more than gravity"),
        "{said}"
    );
    assert!(said.contains("reading 2"), "{said}");
    campaign(
        &place,
        &toml("a_true_relative_standard_uncertainty = 0.001\n"),
    );
    succeed(&["calibrate", text(&place)]);
    for (name, value, u, _) in parameters(&place.join("result")) {
        assert!(
            (value - truth(&name)).abs() < 4.0 * u,
            "{name}: {value} ± {u}"
        );
        if name.starts_with("scale") {
            // The common 0.1 % lies under every scale factor.
            assert!(u > 0.99e-3 && u < 1.1e-3, "{name}: {u}");
        }
    }
    let page = std::fs::read_to_string(place.join("result/report.html")).unwrap();
    assert!(page.contains("lengths of all true accelerations"));
}

/// Intervals through the command's door: 60 tables of twelve oblique positions whose true accelerations are stated with errors
/// of their own. Each parameter holds in so many of 60 as 95 % leave once in ten thousand: 50 of 60 (binomial).
#[test]
fn coverage_of_true_accelerations() {
    let folder = tempfile::tempdir().unwrap();
    const RUNS: usize = 60;
    const U: f64 = 0.005;
    let place = folder.path().join("campaign");
    campaign(
        &place,
        &format!(
            "kind = \"multi-position\"\n[recording]\nfile = \"positions.csv\"\ncolumns = {{ x = \"acc_x_m/s2\", y = \"acc_y_m/s2\", z = \"acc_z_m/s2\" }}\nrows = \"readings\"\n[gravity]\nvalue = {GRAVITY}\nstandard_uncertainty = 1e-4\n[standstill]\nreading_standard_uncertainty = 0.002\n[method]\nmodel = \"full\"\n[attitude]\na_true_standard_uncertainty = {U}\n"
        ),
    );
    let mut held: Vec<(String, usize)> = Vec::new();
    let mut normal = Chance(11);
    for _ in 0..RUNS {
        // The real local gravity differs from the stated one by as much as that says.
        let g = GRAVITY + 1e-4 * normal.normal();
        let mut table =
            "acc_x_m/s2,acc_y_m/s2,acc_z_m/s2,a_true_x_m/s2,a_true_y_m/s2,a_true_z_m/s2\n"
                .to_owned();
        for word in WORDS {
            let real = up(word).map(|u| g * u);
            let stated = real.map(|a| a + U * normal.normal());
            let [x, y, z] = output(real).map(|o| o + 2e-3 * normal.normal());
            let [p, q, r] = stated;
            writeln!(table, "{x:.6},{y:.6},{z:.6},{p:.6},{q:.6},{r:.6}").unwrap();
        }
        std::fs::write(place.join("positions.csv"), table).unwrap();
        succeed(&["calibrate", text(&place)]);
        for (name, value, _, expanded) in parameters(&place.join("result")) {
            let holds = usize::from((value - truth(&name)).abs() <= expanded);
            match held.iter_mut().find(|h| h.0 == name) {
                Some((_, sum)) => *sum += holds,
                None => held.push((name, holds)),
            }
        }
    }
    let whole: usize = held.iter().map(|h| h.1).sum();
    println!("{whole} of {}: {held:?}", 12 * RUNS);
    assert!(held.iter().all(|h| h.1 >= 50), "{held:?}");
    // Pooled: 95 % of 720, which scatter by 1 % or somewhat more where parameters share errors; three of them below.
    assert!(
        whole as f64 >= 0.92 * (12 * RUNS) as f64,
        "{whole}: {held:?}"
    );
}

/// What cannot be an attitude is told with its line, and nothing is written.
#[test]
fn refuses_attitudes_that_are_none() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("positions.csv");
    let stated = ["--a-true-uncertainty", "0.01"];
    let with = |from: &str, to: &str| {
        let text = table("m/s2");
        assert!(text.contains(from));
        text.replacen(from, to, 1)
    };
    let head = "a_true_x_m/s2,a_true_y_m/s2,a_true_z_m/s2";
    let half = format!("{:.14}", GRAVITY * 0.5f64.sqrt());
    let cases: Vec<(String, &[&str], &[&str])> = vec![
        (
            table("m/s2"),
            &[],
            &[
                "uncertainty of the true acceleration is missing",
                "u_a_true_m/s2",
            ],
        ),
        (
            with(&format!(",{half},{half},"), &format!(",7.2,{half},")),
            &stated,
            &["more than gravity", "1.93 %", "reading 1"],
        ),
        (
            with(head, "a_true_x,a_true_y,a_true_z"),
            &stated,
            &["does not say the unit", "a_true_x"],
        ),
        (
            with(head, "a_true_x_V,a_true_y_V,a_true_z_V"),
            &stated,
            &["no column of a true acceleration", "a_true_x_m/s2"],
        ),
        (
            with(head, "a_true_x_mg,a_true_y_mg,a_true_z_mg"),
            &stated,
            &["less than gravity", "unit"],
        ),
        (
            table("word").replacen("+x+y", "+x+w", 1),
            &[],
            &["\"+x+w\" is not a direction", "positions.csv:2"],
        ),
        (
            table("word")
                .replacen("+x+y", "", 1)
                .replace("direction", "direction,u_a_true_g")
                .replace('\n', ",\n")
                .replacen(",\n", "\n", 1),
            &[],
            &["stands without"],
        ),
        (
            table("m/s2")
                .lines()
                .enumerate()
                .map(|(i, l)| match i {
                    0 => format!("{l},direction\n"),
                    3 => format!("{l},-z\n"),
                    _ => format!("{l},\n"),
                })
                .collect(),
            &stated,
            &["contradict each other", "90.0° apart", "positions.csv:4"],
        ),
        (
            table("m/s2")
                .lines()
                .enumerate()
                .map(|(i, l)| match i {
                    5 => {
                        let own: Vec<&str> = l.split(',').collect();
                        format!("{},,,\n", own[..3].join(","))
                    }
                    _ => format!("{l}\n"),
                })
                .collect(),
            &stated,
            &["reading 5 has no attitude"],
        ),
    ];
    for (table, more, words) in cases {
        std::fs::write(&file, &table).unwrap();
        let said = refuse(&call(&file, more));
        for word in words {
            assert!(said.contains(word), "{word}: {said}\n{table}");
        }
        assert!(holds_only(folder.path(), &["positions.csv"]), "{said}");
    }
}

/// What `apply` states of each axis holds where it is reached: at a corner of the accelerations of the recording.
#[test]
fn coverage_of_three_axes_through_apply() {
    let folder = tempfile::tempdir().unwrap();
    let (raw, out) = (folder.path().join("raw.csv"), folder.path().join("a.csv"));
    let mut corners = String::from("t_s,acc_x_m/s2,acc_y_m/s2,acc_z_m/s2\n");
    for k in 0..8 {
        let a = [k & 1, k & 2, k & 4].map(|bit| if bit == 0 { 8.0 } else { -8.0 });
        let [x, y, z] = output(a);
        writeln!(corners, "{},{x:.12},{y:.12},{z:.12}", 0.01 * f64::from(k)).unwrap();
    }
    std::fs::write(&raw, corners).unwrap();
    let (mut covered, mut normal) = (0, Chance(7));
    for _ in 0..60 {
        let more = ["--a-true-uncertainty", "1e-6"];
        calibrated(folder.path(), &table_of("m/s2", &mut normal), &more);
        let calibration = folder.path().join("out/calibration.json");
        let words = ["apply", text(&calibration), text(&raw), "-o", text(&out)];
        let said = stderr(&succeed(&words));
        let stated = said.split("by the calibration: at most ").nth(1).unwrap();
        let stated = stated.split(" m/s²").next().unwrap();
        let expanded: Vec<f64> = stated.split(", ").map(|u| u.parse().unwrap()).collect();
        for (axis, u) in ["x", "y", "z"].into_iter().zip(expanded) {
            let a = column(&out, &format!("acc_{axis}_m/s2"))[0];
            // 2 mm/s² in twelve readings: the bias to 0.6 mm/s², each element of K to 0.1 mm/s² for each m/s².
            assert!((1e-3..1e-2).contains(&u), "{u}");
            covered += u32::from((a - 8.0).abs() <= u);
        }
    }
    // Of 180 at 95 %: 171 ± 3 · 2.9, and all of them once in ten thousand.
    assert!((162..180).contains(&covered), "{covered}");
}
