//! `test motion --required`: a recorded acceleration against a required spectrum.

use crate::support::*;
use std::fmt::Write;
use std::path::Path;

const G: f64 = 9.80665;

/// White noise of a density in g²/Hz up to 1 kHz, cut off at a full scale in g where one is given.
fn record(path: &Path, density: f64, seconds: usize, seed: u64, full_scale: f64) {
    let mut chance = Chance(seed);
    let sigma = (density * 1000.0).sqrt();
    let mut text = "t_s,a_g\n".to_owned();
    for i in 0..2000 * seconds {
        let a = (sigma * chance.normal()).clamp(-full_scale, full_scale);
        writeln!(text, "{:.4},{a:.6}", i as f64 / 2000.0).unwrap();
    }
    std::fs::write(path, text).unwrap();
}

/// A call of `test motion` on the channel `a` of a record.
fn motion<'a>(file: &'a Path, out: &'a Path, more: &[&'a str]) -> Vec<&'a str> {
    let beginning = [
        "test",
        "motion",
        text(file),
        "--column",
        "a",
        "-o",
        text(out),
    ];
    [&beginning[..], more].concat()
}

fn judged(file: &Path, required: &str, more: &[&str], out: &Path) -> serde_json::Value {
    // Its response spectrum is not asked for here, and takes longest.
    let own = ["--required", required, "--periods", "0.1"];
    succeed(&motion(file, out, &[&own, more].concat()));
    json(&out.join("result.json"))
}

fn verdict(result: &serde_json::Value) -> (String, f64) {
    let v = &result["extra"]["required_spectrum"]["comparison"]["verdict"];
    let by = v["by"].as_f64().or(v["margin"].as_f64()).unwrap();
    (v["verdict"].as_str().unwrap().to_owned(), by)
}

/// A flat profile as a table with slopes, as TOML, and in the other unit is one profile.
#[test]
fn law_every_form_of_a_profile_is_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.csv");
    record(&file, 0.02, 20, 1, 100.0);
    let g2 = G * G;
    let forms = [
        ("a.csv", "frequency_Hz,density_g2/Hz\n20,0.005\n80,0.02\n700,0.02\n".to_owned()),
        (
            "b.csv",
            "frequency_Hz,density_g2/Hz,slope_dB/oct,lower_dB,upper_dB\n20,,,-3,3\n80,0.02,3.0103,,\n700,,0,,\n".to_owned(),
        ),
        (
            "c.csv",
            format!("frequency_Hz;density_(m/s²)²/Hz\n20;{}\n80;{}\n700;{}\n", 0.005 * g2, 0.02 * g2, 0.02 * g2)
                .replace('.', ","),
        ),
        (
            "d.toml",
            "name = \"own\"\nunit = \"g²/Hz\"\ntolerance_dB = [-3, 3]\n[[point]]\nfrequency_Hz = 20\ndensity = 0.005\n[[point]]\nfrequency_Hz = 80\nslope_dB_per_octave = 3.0103\n[[point]]\nfrequency_Hz = 700\ndensity = 0.02\n".to_owned(),
        ),
    ];
    let mut seen: Vec<(String, f64)> = Vec::new();
    for (name, form) in forms {
        let profile = folder.path().join(format!("profile-{name}"));
        std::fs::write(&profile, form).unwrap();
        let result = judged(&file, text(&profile), &[], &folder.path().join("out"));
        seen.push(verdict(&result));
    }
    // 3.0103 dB to the octave is a factor two to five digits.
    for other in &seen[1..] {
        assert!(
            other.0 == seen[0].0 && (other.1 - seen[0].1).abs() < 1e-4,
            "{seen:?}"
        );
    }
}

/// Inside, beyond by as much as was put in, and not shown by a short record: each in words at the top.
#[test]
fn known_verdicts_of_white_noise() {
    let folder = tempfile::tempdir().unwrap();
    let profile = folder.path().join("flat.csv");
    std::fs::write(&profile, "frequency_Hz,density_g2/Hz\n20,0.02\n900,0.02\n").unwrap();
    let (file, out) = (folder.path().join("a.csv"), folder.path().join("out"));
    let at = |density: f64, seconds: usize, seed: u64| {
        record(&file, density, seconds, seed, 100.0);
        let result = judged(&file, text(&profile), &[], &out);
        let page = std::fs::read_to_string(out.join("report.html")).unwrap();
        (result, page)
    };
    let (inside, page) = at(0.02, 120, 2);
    assert_eq!(verdict(&inside).0, "inside");
    assert!(page.contains("The spectrum is inside flat"));
    assert!(!codes(&inside).iter().any(|c| c.starts_with("spectrum-")));
    // 6 dB above what is required is 3 dB above the limit; the largest of 177 lines of ν = 540 is up to 1.4 dB more.
    let (beyond, page) = at(0.02 * 10f64.powf(0.6), 60, 3);
    let (word, by) = verdict(&beyond);
    assert!(word == "beyond" && (3.0..4.5).contains(&by), "{word} {by}");
    assert!(
        page.contains("The spectrum is beyond flat: at "),
        "the answer stands at the top"
    );
    assert!(codes(&beyond).contains(&"spectrum-beyond".to_owned()));
    let (low, _) = at(0.02 * 10f64.powf(-0.6), 60, 4);
    assert!(verdict(&low).0 == "beyond" && verdict(&low).1 < -3.0);
    let (short, page) = at(0.02, 2, 5);
    assert_eq!(verdict(&short).0, "not-shown");
    assert!(codes(&short).contains(&"spectrum-not-shown".to_owned()));
    assert!(page.contains("is not shown"));
    // The sensor's own uncertainty widens what is known.
    record(&file, 0.02, 120, 2, 100.0);
    let loose = judged(&file, text(&profile), &["--uncertainty", "20"], &out);
    assert_eq!(verdict(&loose).0, "not-shown");
    // A published profile that the record does not reach.
    let reach = judged(&file, "gevs-acceptance", &[], &out);
    assert_eq!(verdict(&reach).0, "beyond");
    assert!(out.join("required_spectrum.csv").exists());
}

/// A record that is cut off at 2 g gets a finding, by its samples, or by the full scale that is stated where they are few.
#[test]
fn known_record_cut_off_at_full_scale() {
    let folder = tempfile::tempdir().unwrap();
    let (file, out) = (folder.path().join("a.csv"), folder.path().join("out"));
    let found = |more: &[&str]| {
        succeed(&motion(&file, &out, more));
        codes(&json(&out.join("result.json"))).contains(&"clipped".to_owned())
    };
    // 1 g RMS: one sample of 22 stands at ± 2 g.
    record(&file, 1e-3, 10, 6, 2.0);
    assert!(found(&[]));
    // 0.57 g RMS: nine samples of 20 000, which a whole record might have as its peaks.
    record(&file, 3.25e-4, 10, 7, 2.0);
    assert!(found(&["--full-scale", "2g"]) && found(&["--full-scale", "19.6133"]));
    // Well below it nothing is cut off.
    record(&file, 1e-5, 10, 8, 2.0);
    assert!(!found(&["--full-scale", "2g"]) && !found(&[]));
}

#[test]
fn refuses_profiles_that_are_none() {
    let folder = tempfile::tempdir().unwrap();
    let (file, out) = (folder.path().join("a.csv"), folder.path().join("out"));
    record(&file, 0.02, 4, 1, 100.0);
    for (name, form, why) in [
        (
            "a.csv",
            "frequency_Hz,density_g2/Hz\n20,0.02\n20,0.02\n",
            "do not ascend",
        ),
        (
            "b.csv",
            "frequency_Hz,density_g2/Hz\n20,0.02\n",
            "at least two points",
        ),
        (
            "h.csv",
            "frequency_Hz,density_g2/Hz\n1e-320,0.02\n80,0.02\n",
            "has no lines",
        ),
        (
            "c.csv",
            "frequency_Hz,density\n20,0.02\n80,0.02\n",
            "does not say the unit",
        ),
        (
            "d.csv",
            "frequency_Hz,density_g2/Hz\n20,-0.02\n80,0.02\n",
            "above zero",
        ),
        (
            "e.csv",
            "frequency_Hz,density_g2/Hz,slope_dB/oct\n20,0.02,\n80,0.02,3\n",
            "contradict each other by -6.00 dB",
        ),
        (
            "f.csv",
            "frequency_Hz,density_g2/Hz\n20,0.02\n80,\n",
            "neither a density nor slopes",
        ),
        (
            "g.csv",
            "frequency_Hz,density_g2/Hz,lower_dB,upper_dB\n20,0.02,3,-3\n80,0.02,,\n",
            "leaves no room",
        ),
        (
            "h.csv",
            "frequency_Hz,density_g2/Hz,lower_dB\n20,0.02,3\n80,0.02,\n",
            "one is missing",
        ),
        (
            "i.csv",
            "frequency_Hz,density_g2/Hz\n2000,0.02\n4000,0.02\n",
            "begins at 2000 Hz",
        ),
        (
            "j.toml",
            "unit = \"V2/Hz\"\n[[point]]\nfrequency_Hz = 20\ndensity = 1\n",
            "no unit of a density",
        ),
        (
            "k.toml",
            "unit = \"g2/Hz\"\n[[pont]]\nfrequency_Hz = 20\n",
            "not a required spectrum",
        ),
        (
            "l.toml",
            "unit = \"g2/Hz\"\n[[point]]\nfrequency_Hz = nan\ndensity = 1\n[[point]]\nfrequency_Hz = 20\ndensity = 1\n",
            "no frequency",
        ),
    ] {
        let profile = folder.path().join(format!("profile-{name}"));
        std::fs::write(&profile, form).unwrap();
        let said = refuse(&motion(&file, &out, &["--required", text(&profile)]));
        assert!(said.contains(why), "{why}: {said}");
        assert!(!out.exists(), "{name}");
    }
    let said = refuse(&motion(&file, &out, &["--required", "navmat"]));
    assert!(said.contains("navmat-p-9492"), "{said}");
    let fine = ["--required", "gevs-acceptance", "--resolution", "0.001"];
    let said = refuse(&motion(&file, &out, &fine));
    assert!(said.contains("no lines 0.001 Hz apart"), "{said}");
    let wrong = proofmass(&motion(&file, &out, &["--full-scale", "-2g"]));
    assert_eq!(wrong.status.code(), Some(2));
}

/// `test random` holds its input against the spectrum: the same answer as `test motion` gives of that column.
#[test]
fn law_the_input_of_a_random_test_is_judged_alike() {
    let folder = tempfile::tempdir().unwrap();
    let (file, out) = (folder.path().join("a.csv"), folder.path().join("out"));
    record(&file, 0.02, 20, 9, 100.0);
    let text_of = std::fs::read_to_string(&file).unwrap();
    let mut two = "t_s,a_g,out_V\n".to_owned();
    for line in text_of.lines().skip(1) {
        let a: f64 = line.rsplit_once(',').unwrap().1.parse().unwrap();
        writeln!(two, "{line},{:.6}", 0.1 * a + 1e-4 * (37.0 * a).sin()).unwrap();
    }
    std::fs::write(&file, two).unwrap();
    let profile = folder.path().join("flat.csv");
    std::fs::write(&profile, "frequency_Hz,density_g2/Hz\n20,0.08\n900,0.08\n").unwrap();
    let motion = judged(&file, text(&profile), &[], &out);
    let random = folder.path().join("random");
    succeed(&[
        "test",
        "random",
        text(&file),
        "--input",
        "a",
        "--output-column",
        "out_V",
        "--required",
        text(&profile),
        "-o",
        text(&random),
    ]);
    let result = json(&random.join("result.json"));
    assert_eq!(verdict(&result), verdict(&motion));
    assert!(codes(&result).contains(&"spectrum-beyond".to_owned()));
    let page = std::fs::read_to_string(random.join("report.html")).unwrap();
    assert!(page.contains("The spectrum is beyond flat"));
    let said = refuse(&[
        "test",
        "random",
        text(&file),
        "--input",
        "out_V",
        "--output-column",
        "a",
        "--required",
        text(&profile),
    ]);
    assert!(said.contains("is one of an acceleration"), "{said}");
}
