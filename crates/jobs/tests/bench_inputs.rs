//! What a campaign on the shaker says of its bench: gains of the conditioner, uncertainties over frequency.

use num_complex::Complex64;
use proofmass_jobs::campaign::Campaign;
use proofmass_jobs::plan::PlanOutcome;
use proofmass_jobs::{Job as _, Memory, Outcome as _, StoredResult, Trouble, Unwatched};
use proofmass_shaker::geometry::published_plan;
use std::fmt::Write as _;
use std::sync::Arc;

/// 10 mV/(m/s²) along x and y, 12 along z, cross terms of 1 %, at 10 m/s²; the readings are those behind gains of the reference and of x.
pub(crate) fn runs(frequencies: &[f64], gain: impl Fn(usize, f64) -> Complex64) -> String {
    let mut text =
        "run,frequency_Hz,inclination_deg,rotation_deg,reference_m/s2,reference_phase_deg"
            .to_owned();
    for axis in ["x", "y", "z"] {
        let _ = write!(text, ",{axis}_V,{axis}_phase_deg");
    }
    text.push('\n');
    let s = [
        [0.01, 0.0001, -0.0001],
        [0.0001, 0.01, 0.0001],
        [-0.0001, 0.0001, 0.012],
    ];
    for f in frequencies {
        for (k, c) in published_plan().into_iter().step_by(3).enumerate() {
            let d = c.direction();
            let reference = gain(3, *f) * 10.0;
            let _ = write!(
                text,
                "{k} at {f},{f},{},{},{},{}",
                c.inclination.to_degrees(),
                c.rotation.to_degrees(),
                reference.norm(),
                reference.arg().to_degrees()
            );
            for axis in 0..3 {
                let output: f64 = (0..3).map(|i| 10.0 * d[i] * s[i][axis]).sum();
                // A part in a thousand that no budget explains by itself.
                let error =
                    1.0 + 1e-3 * f64::from(((7 * k + 3 * axis) % 11) as u32 as f32 - 5.0) / 5.0;
                let output = gain(axis, *f) * output * error;
                let _ = write!(text, ",{},{}", output.norm(), output.arg().to_degrees());
            }
            text.push('\n');
        }
    }
    text
}

const HEAD: &str = "kind = \"shaker-triaxial\"\n[runs]\nfile = \"runs.csv\"\n[method]\nmethods = [\"joint\"]\ntrials = 0\n\
    [unmeasured_motion]\nacross = 0\nalong = 0\n\
    [[budget]]\nname = \"reading\"\nacts = \"output-modulus\"\nunit = \"%\"\nvaries_with = [\"run\", \"channel\"]\ndistribution = { kind = \"normal\", mean = 0.0, u = 0.1 }\n\
    [[budget]]\nname = \"phase\"\nacts = \"output-phase\"\nunit = \"mrad\"\nvaries_with = [\"run\", \"channel\"]\ndistribution = { kind = \"normal\", mean = 0.0, u = 1.0 }\n\
    [[budget]]\nname = \"noise\"\nacts = \"output-additive\"\nunit = \"µV\"\nvaries_with = [\"run\", \"channel\"]\ndistribution = { kind = \"normal\", mean = 0.0, u = 50.0 }\n";

pub(crate) fn calibrate(
    more: &str,
    runs: &str,
    files: &[(&str, &str)],
) -> Result<StoredResult, Trouble> {
    let mut store = Memory::new()
        .file("campaign.toml", format!("{HEAD}{more}"))
        .file("runs.csv", runs.to_owned());
    for (name, text) in files {
        store = store.file(*name, (*text).to_owned());
    }
    let campaign = Campaign::read(Arc::new(store), "campaign.toml")?;
    campaign.evaluate(Some("2026-01-01".to_owned()), &Unwatched)
}

/// Value and u of a quantity.
pub(crate) fn quantity(result: &StoredResult, name: &str) -> (f64, f64) {
    let q = result.quantities().iter().find(|q| q.name == name);
    let q = q.unwrap_or_else(|| panic!("{name}"));
    (q.value, q.u.expect("u"))
}

#[test]
fn law_gains_of_the_conditioner_go_out_and_leave_their_uncertainty() {
    let frequencies = [80.0, 160.0, 320.0];
    let bare = calibrate(
        "",
        &runs(&frequencies, |_, _| Complex64::new(1.0, 0.0)),
        &[],
    )
    .expect("bare");
    // x behind a gain that changes with the frequency and turns the phase, y behind −10, the reference behind 2.
    let turning = |f: f64| Complex64::from_polar(9.0 + (f / 80.0).log2(), -1e-3 * f);
    let behind = runs(&frequencies, |channel, f| match channel {
        0 => turning(f),
        1 => Complex64::new(-10.0, 0.0),
        3 => Complex64::new(2.0, 0.0),
        _ => Complex64::new(1.0, 0.0),
    });
    let mut table = "frequency_Hz,gain,phase_deg,u_relative_%,u_phase_deg\n".to_owned();
    // 160 Hz lies half way between two rows in log f: gain and phase there are their means.
    for f in [80.0, 320.0] {
        let gain = turning(f);
        let mean = |at_80: f64, at_320: f64| if f == 80.0 { at_80 } else { at_320 };
        let _ = writeln!(
            table,
            "{f},{},{},{},0.2",
            gain.norm(),
            gain.arg().to_degrees(),
            mean(0.4, 0.6)
        );
    }
    let stated = "[conditioner]\nx = { file = \"x.csv\" }\ny = { gain = -10.0 }\nreference = { gain = 2.0, relative_standard_uncertainty = 0.003 }\n";
    let behind = calibrate(stated, &behind, &[("x.csv", &table)]).expect("behind gains");
    for f in [80.0, 320.0] {
        for term in ["xx", "xy", "yx", "yy", "zx", "zz"] {
            let name = format!("S.{term}.modulus[frequency={f}]");
            let (a, u_a) = quantity(&bare, &name);
            let (b, u_b) = quantity(&behind, &name);
            assert!((a - b).abs() < 1e-6 * 0.01, "{name}: {a} {b}");
            // The reference is common to all outputs; the gain of x is that of what x reads.
            let own = if term.ends_with('x') {
                if f == 80.0 { 0.004 } else { 0.006 }
            } else {
                0.0
            };
            let expected = (u_a * u_a + a * a * (9e-6 + own * own)).sqrt();
            assert!(
                (u_b / expected - 1.0).abs() < 0.02,
                "{name}: {u_b} {expected}"
            );
        }
    }
    // Half way in log f the gain is the mean, 10, and so is its uncertainty, 0.5 %.
    let (a, u_a) = quantity(&bare, "S.xx.modulus[frequency=160]");
    let (b, u_b) = quantity(&behind, "S.xx.modulus[frequency=160]");
    assert!((a - b).abs() < 1e-6 * 0.01, "{a} {b}");
    let expected = (u_a * u_a + a * a * (9e-6 + 25e-6)).sqrt();
    assert!((u_b / expected - 1.0).abs() < 0.02, "{u_b} {expected}");
    // The budget names each.
    let page = String::from_utf8(
        behind
            .files()
            .expect("files")
            .into_iter()
            .find(|f| f.0 == "budget.csv")
            .expect("a budget")
            .1,
    )
    .expect("text");
    for key in [
        "conditioner.gain.x",
        "conditioner.phase.x",
        "conditioner.gain.reference",
    ] {
        assert!(page.contains(key), "{key}");
    }
    assert!(!page.contains("conditioner.gain.y"));
}

#[test]
fn law_an_uncertainty_over_frequency_is_that_of_each_frequency() {
    let entry = |body: &str| {
        format!(
            "[[budget]]\nname = \"gain\"\nacts = \"output-modulus\"\nunit = \"%\"\nvaries_with = [\"channel\"]\n{body}\n"
        )
    };
    let over = entry("over_frequency = [[80, 0.1], [320, 0.3]]");
    let at = |u: f64| {
        entry(&format!(
            "distribution = {{ kind = \"normal\", mean = 0.0, u = {u} }}"
        ))
    };
    for (f, u) in [(80.0, 0.1), (160.0, 0.2), (320.0, 0.3)] {
        let runs = runs(&[f], |_, _| Complex64::new(1.0, 0.0));
        let a = calibrate(&over, &runs, &[]).expect("over frequency");
        let b = calibrate(&at(u), &runs, &[]).expect("one u");
        let name = format!("S.yy.modulus[frequency={f}]");
        let ((a, u_a), (b, u_b)) = (quantity(&a, &name), quantity(&b, &name));
        assert!(
            (a / b - 1.0).abs() < 1e-9 && (u_a / u_b - 1.0).abs() < 1e-6,
            "{f}: {u_a} {u_b}"
        );
    }
    // Nobody knows it beyond.
    let beyond = runs(&[40.0, 80.0], |_, _| Complex64::new(1.0, 0.0));
    let refused = calibrate(&over, &beyond, &[]).expect_err("40 Hz");
    assert!(
        refused
            .to_string()
            .contains("from 80 to 320 Hz, and a run is at 40 Hz"),
        "{refused}"
    );
}

#[test]
fn bench_inputs_that_cannot_be_are_refused_with_their_place() {
    let runs = runs(&[80.0, 160.0], |_, _| Complex64::new(1.0, 0.0));
    let table = "frequency_Hz,gain\n80,10\n100,10.1\n";
    for (more, words) in [
        (
            "[conditioner]\nq = { gain = 10 }\n",
            "unknown channel \"q\"",
        ),
        (
            "[conditioner]\nx = { gain = 0 }\n",
            "a gain of 0 is out of range",
        ),
        (
            "[conditioner]\nx = { }\n",
            "the gain of channel x is missing",
        ),
        (
            "[conditioner]\nx = { gain = 10, file = \"x.csv\" }\n",
            "exclude each other",
        ),
        (
            "[conditioner]\nx = { gain = 10, relative_standard_uncertainty = 5 }\n",
            "out of range",
        ),
        (
            "[conditioner]\nx = { file = \"x.csv\" }\n",
            "stated from 80 to 100 Hz, and a run is at 160 Hz",
        ),
        (
            "[conditioner]\nx = { file = \"back.csv\" }\n",
            "80 Hz behind 160 Hz",
        ),
        (
            "[conditioner]\nx = { file = \"zero.csv\" }\n",
            "a gain of 0 is out of range",
        ),
        (
            "[[budget]]\nname = \"w\"\nacts = \"inclination\"\nunit = \"deg\"\nover_frequency = [[80, 0.1]]\n",
            "an angle is the same at every frequency",
        ),
        (
            "[[budget]]\nname = \"w\"\nacts = \"output-modulus\"\nunit = \"%\"\nover_frequency = []\n",
            "over_frequency is empty",
        ),
        (
            "[[budget]]\nname = \"w\"\nacts = \"output-modulus\"\nunit = \"%\"\nover_frequency = [[160, 0.1], [80, 0.1]]\n",
            "80 Hz behind 160 Hz",
        ),
        (
            "[[budget]]\nname = \"w\"\nacts = \"output-modulus\"\nunit = \"%\"\nover_frequency = [[80, -0.1], [160, 0.1]]\n",
            "must not be negative",
        ),
        (
            "[[budget]]\nname = \"w\"\nacts = \"output-modulus\"\nunit = \"%\"\nover_frequency = [[80, 0.1], [160, 0.1]]\ndistribution = { kind = \"normal\", mean = 0.0, u = 0.1 }\n",
            "say it again",
        ),
        (
            "[conditioner]\nx = { gain = 1, relative_standard_uncertainty = 0.001 }\n[[budget]]\nname = \"conditioner.gain.x\"\nacts = \"output-modulus\"\nunit = \"%\"\nvaries_with = [\"channel\"]\ndistribution = { kind = \"normal\", mean = 0.0, u = 0.1 }\n",
            "[conditioner] states it too",
        ),
    ] {
        let files = [
            ("x.csv", table),
            ("back.csv", "frequency_Hz,gain\n160,10\n80,10\n"),
            ("zero.csv", "frequency_Hz,gain\n80,0\n160,10\n"),
        ];
        let refused = calibrate(more, &runs, &files).expect_err(more);
        let told = format!("{refused} {:?}", refused.place());
        assert!(told.contains(words), "{more}: {told}");
    }
}

/// Velocities of a table that moves by these ratios, in mm/s at 10 m/s², of one repeat.
fn moved(f: f64, repeat: u32) -> [Complex64; 3] {
    let error = 1e-4 * f64::from(repeat % 3);
    let ratios = [
        Complex64::new(0.012 + error, 0.003),
        Complex64::new(-0.004, 0.006 - error),
        Complex64::new(0.997 + error, 0.002),
    ];
    ratios.map(|r| 1e4 * r / Complex64::new(0.0, std::f64::consts::TAU * f))
}

#[test]
fn law_several_vibrometers_in_one_record_are_a_run_of_each() {
    let head = "kind = \"spurious-motion\"\n[runs]\nfile = \"runs.csv\"\n";
    let evaluate = |head: &str, runs: String| -> Result<StoredResult, Trouble> {
        let store = Memory::new()
            .file("campaign.toml", head.to_owned())
            .file("runs.csv", runs);
        let campaign = Campaign::read(Arc::new(store), "campaign.toml")?;
        campaign.evaluate(Some("2026-01-01".to_owned()), &Unwatched)
    };
    let polar = |z: Complex64| format!("{},{}", z.norm(), z.arg().to_degrees());
    let mut apart = "run,frequency_Hz,inclination_deg,axis,reference_m/s2,reference_phase_deg,velocity_mm/s,velocity_phase_deg\n".to_owned();
    let mut together = "run,frequency_Hz,inclination_deg,reference_m/s2,reference_phase_deg,velocity_x_mm/s,velocity_x_phase_deg,velocity_y_mm/s,velocity_y_phase_deg,velocity_z_mm/s,velocity_z_phase_deg\n".to_owned();
    for f in [80.0, 160.0] {
        for repeat in 0..5 {
            let v = moved(f, repeat);
            for (axis, v) in ["x", "y", "z"].into_iter().zip(v) {
                let _ = writeln!(apart, "{f} {repeat} {axis},{f},35,{axis},10,0,{}", polar(v));
            }
            let _ = writeln!(
                together,
                "{f} {repeat},{f},35,10,0,{},{},{}",
                polar(v[0]),
                polar(v[1]),
                polar(v[2])
            );
        }
    }
    let table = |result: &StoredResult| {
        let files = result.files().expect("files");
        let file = files.into_iter().find(|f| f.0 == "spurious.csv");
        String::from_utf8(file.expect("spurious.csv").1).expect("text")
    };
    let a = evaluate(head, apart.clone()).expect("a row for each axis");
    let b = evaluate(head, together.clone()).expect("a column for each axis");
    assert_eq!(table(&a), table(&b));
    // The axis is said once.
    let twice = together.replacen("inclination_deg,", "inclination_deg,axis,", 1);
    let twice = twice.replace(",35,", ",35,x,");
    let refused = evaluate(head, twice).expect_err("said twice");
    assert!(refused.to_string().contains("says it again"), "{refused}");
    let never = apart.replacen(",axis,", ",", 1);
    let never = never
        .replace(",x,10", ",10")
        .replace(",y,10", ",10")
        .replace(",z,10", ",10");
    let refused = evaluate(head, never).expect_err("never said");
    assert!(
        refused.to_string().contains("no column `axis`"),
        "{refused}"
    );
    // One excluded row takes its runs of every axis out.
    let without = evaluate(
        "kind = \"spurious-motion\"\n[runs]\nfile = \"runs.csv\"\nexclude = [\"80 0\"]\n",
        together,
    )
    .expect("without one");
    assert_ne!(table(&b), table(&without));
}

#[test]
fn known_points_that_a_shaker_does_not_reach() {
    use proofmass_jobs::Job as _;
    let plan = |shaker: &str, targets: [f64; 3]| {
        let mut text = runs(&[5.0, 40.0, 160.0], |_, _| Complex64::new(1.0, 0.0));
        let lines: Vec<String> = text
            .lines()
            .map(|line| match line.split(',').nth(1) {
                Some("frequency_Hz") => format!("{line},target_m/s2"),
                Some("5") => format!("{line},{}", targets[0]),
                Some("40") => format!("{line},{}", targets[1]),
                _ => format!("{line},{}", targets[2]),
            })
            .collect();
        text = lines.join("\n");
        let store = Memory::new()
            .file("campaign.toml", format!("{HEAD}[shaker]\n{shaker}\n"))
            .file("runs.csv", text);
        let Campaign::ShakerTriaxial(campaign) = Campaign::read(Arc::new(store), "campaign.toml")?
        else {
            panic!("another kind");
        };
        let (job, _) = campaign.plan_job(160.0)?;
        let outcome = job.evaluate(&(), &Unwatched)?;
        let findings = outcome.findings().iter();
        let found: Vec<String> = findings
            .filter(|f| f.code().starts_with("beyond"))
            .inspect(|f| assert_eq!(f.code(), "beyond-the-shaker"))
            .map(|f| f.evidence_text().to_owned())
            .collect();
        Ok::<Vec<String>, Trouble>(found)
    };
    // 25.4 mm from peak to peak: 12.7 mm · (2π 5 Hz)² = 12.53 m/s².
    let all = "stroke_mm = 25.4\nvelocity_m_per_s = 1.0\nacceleration_m_per_s2 = 500\nforce_N = 100\ntable_mass_kg = 0.3\npayload_kg = 0.7\nlargest_payload_kg = 1\nhighest_frequency_Hz = 5000";
    assert_eq!(
        plan(all, [12.5, 10.0, 99.0]).expect("within"),
        Vec::<String>::new()
    );
    let found = plan(all, [12.6, 10.0, 101.0]).expect("beyond");
    assert_eq!(
        found,
        [
            "5 Hz at 12.6 m/s²: its stroke allows 12.5 m/s²; 160 Hz at 101 m/s²: its force allows 100 m/s²"
        ]
    );
    // A plan of its own says where, and the runs how strong.
    let planned = format!("{all}\n[plan]\nname = \"published\"");
    assert_eq!(plan(&planned, [12.6, 10.0, 101.0]).expect("planned"), found);
    // 0.04 m/s · 2π 40 Hz = 10.05 m/s².
    let slow = plan("velocity_m_per_s = 0.04", [1.0, 10.1, 10.0]).expect("slow");
    assert_eq!(slow, ["40 Hz at 10.1 m/s²: its velocity allows 10.1 m/s²"]);
    let heavy = plan("payload_kg = 2\nlargest_payload_kg = 1", [1.0, 1.0, 1.0]).expect("heavy");
    assert_eq!(heavy, ["a payload of 2 kg, 1 kg at most"]);
    let low = plan("lowest_frequency_Hz = 10", [1.0, 1.0, 1.0]).expect("low");
    assert_eq!(low, ["5 Hz at 1 m/s²: below its lowest frequency of 10 Hz"]);
    for (shaker, words) in [
        ("stroke_mm = 0", "not a positive number"),
        ("force_N = 10", "by the mass it moves"),
    ] {
        let refused = plan(shaker, [1.0; 3]).expect_err(shaker);
        assert!(refused.to_string().contains(words), "{refused}");
    }
}

fn codes(result: &StoredResult) -> Vec<&str> {
    result.findings().iter().map(|f| f.code()).collect()
}

/// A table of runs without its columns of phases.
fn without_phases(runs: &str) -> String {
    let heading: Vec<&str> = runs.lines().next().expect("heading").split(',').collect();
    let kept = |line: &str| {
        let cells = line.split(',').zip(&heading);
        let cells: Vec<&str> = cells
            .filter(|(_, name)| !name.contains("phase"))
            .map(|(cell, _)| cell)
            .collect();
        cells.join(",") + "\n"
    };
    runs.lines().map(kept).collect()
}

#[test]
fn law_moduli_tell_main_terms_and_the_signs_of_cross_terms() {
    let frequencies = [80.0, 160.0];
    let runs = runs(&frequencies, |_, _| Complex64::new(1.0, 0.0));
    let with = calibrate("", &runs, &[]).expect("phasors");
    let without = calibrate("", &without_phases(&runs), &[]).expect("moduli");
    assert!(
        codes(&without).contains(&"magnitudes-only"),
        "{:?}",
        codes(&without)
    );
    for f in frequencies {
        for (term, sign) in [
            ("xx", 0.0),
            ("yy", 0.0),
            ("zz", 0.0),
            ("xy", 0.0),
            ("xz", 180.0),
            ("yz", 0.0),
            ("zx", 180.0),
            ("zy", 0.0),
        ] {
            let name = format!("S.{term}.modulus[frequency={f}]");
            let (a, u_a) = quantity(&with, &name);
            let (b, u_b) = quantity(&without, &name);
            assert!(
                (a - b).abs() < 2.0 * u_a.hypot(u_b),
                "{name}: {a} {b} {u_b}"
            );
            // Without phases nothing is known better.
            assert!(u_b > 0.9 * u_a, "{name}: {u_a} {u_b}");
            let name = format!("S.{term}.phase[frequency={f}]");
            let stated = without.quantities().iter().find(|q| q.name == name);
            if term.as_bytes()[0] != term.as_bytes()[1] {
                let phase = stated.expect("a sign").value.to_degrees().abs();
                assert!((phase - sign).abs() < 1.0, "{name}: {phase}");
            } else {
                assert!(stated.is_none(), "{name} is not known");
            }
        }
    }
}

#[test]
fn known_published_method_alone() {
    let runs = runs(&[80.0], |_, _| Complex64::new(1.0, 0.0));
    let runs = without_phases(&runs);
    let head = HEAD.replace("\"joint\"", "\"published\"");
    let store = Memory::new()
        .file("campaign.toml", head)
        .file("runs.csv", runs.clone());
    let campaign = Campaign::read(Arc::new(store), "campaign.toml").expect("campaign");
    let alone = campaign.evaluate(None, &Unwatched).expect("published");
    let joint = calibrate("", &runs, &[]).expect("joint");
    assert!(
        codes(&alone).contains(&"published-alone"),
        "{:?}",
        codes(&alone)
    );
    let name = "S.xx.modulus[frequency=80]";
    assert_eq!(quantity(&alone, name), quantity(&joint, name));
}

#[test]
fn phases_of_some_runs_are_refused() {
    let runs = runs(&[80.0], |_, _| Complex64::new(1.0, 0.0));
    let mut lines: Vec<String> = runs.lines().map(str::to_owned).collect();
    for line in lines.iter_mut().skip(5) {
        let cells: Vec<&str> = line.split(',').collect();
        let heading = ["reference_phase_deg", "x_phase_deg"];
        let names: Vec<&str> = runs.lines().next().expect("heading").split(',').collect();
        let cells: Vec<&str> = cells
            .iter()
            .zip(&names)
            .map(|(cell, name)| if heading.contains(name) { "" } else { *cell })
            .collect();
        *line = cells.join(",");
    }
    let error = calibrate("", &lines.join("\n"), &[]).expect_err("phases of some runs");
    let text = error.to_string();
    assert!(text.contains("has no phase"), "{text}");
    // One channel without phases is no table of moduli.
    let one = runs.replacen("x_phase_deg", "note", 1);
    let error = calibrate("", &one, &[]).expect_err("phases of some channels");
    assert!(error.to_string().contains("x_phase"), "{error}");
}

/// The same runs with a column `session` in front, by the place of the run.
fn in_sessions(runs: &str, of: impl Fn(usize) -> &'static str) -> String {
    let line = |(k, l): (usize, &str)| match k {
        0 => format!("session,{l}\n"),
        k => format!("{},{l}\n", of(k - 1)),
    };
    runs.lines().enumerate().map(line).collect()
}

const BETWEEN: &str = "[[budget]]\nname = \"session.gain\"\nacts = \"output-modulus\"\nunit = \"%\"\nvaries_with = [\"session\", \"channel\"]\n\
    distribution = { kind = \"normal\", mean = 0.0, u = 0.3 }\n";

#[test]
fn law_sessions_of_a_table_reach_budget_and_report() {
    let bare = runs(&[80.0, 160.0], |_, _| Complex64::new(1.0, 0.0));
    let table = in_sessions(&bare, |k| ["2026-03-01", "2026-03-02"][k / 2 % 2]);
    let whole = calibrate(BETWEEN, &table, &[]).expect("two sessions");
    let name = "S.xx.modulus[frequency=80]";
    let (value, u) = quantity(&whole, name);
    let (_, without) = quantity(&calibrate("", &bare, &[]).expect("none"), name);
    // Half of the runs each: u/√2, the sessions being told worse than their readings nowhere.
    let between = (u * u - without * without).sqrt() / value;
    assert!(
        (between / (0.003 / 2f64.sqrt()) - 1.0).abs() < 0.05,
        "{between}"
    );
    let files = whole.files().expect("files");
    let file = |name: &str| -> String {
        let found = files.iter().find(|f| f.0 == name).expect(name);
        String::from_utf8(found.1.clone()).expect("text")
    };
    assert!(file("sessions.csv").contains("2026-03-02"));
    for name in ["phasors.csv", "residuals.csv", "applied.csv"] {
        assert!(
            file(name)
                .lines()
                .next()
                .expect("a heading")
                .contains(",session,"),
            "{name}"
        );
    }
    assert!(file("report.html").contains("Reproducibility between sessions"));
    assert!(file("budget.csv").contains("session.gain"));
    // What nobody declares is in no budget without sessions.
    assert!(
        whole
            .findings()
            .iter()
            .all(|f| f.code() != "sessions-differ")
    );
}

#[test]
fn refuses_sessions_that_are_not_said() {
    let bare = runs(&[80.0, 160.0], |_, _| Complex64::new(1.0, 0.0));
    // The key without the column, by the line of the entry.
    let trouble = calibrate(BETWEEN, &bare, &[]).expect_err("no session");
    let said = format!("{trouble:?} {}", trouble.hint().unwrap_or_default());
    assert!(trouble.to_string().contains("session.gain"), "{said}");
    assert!(
        said.contains("add a column `session`") && said.contains("runs.csv"),
        "{said}"
    );
    // Empty in some rows.
    let gaps = in_sessions(&bare, |k| if k == 4 { "" } else { "one" });
    let trouble = calibrate("", &gaps, &[]).expect_err("a run without a session");
    let said = format!("{trouble:?} {}", trouble.hint().unwrap_or_default());
    assert!(
        said.contains("names no session") && said.contains("runs.csv"),
        "{said}"
    );
    // A slip of the word.
    let slip = BETWEEN.replace("\"session\"", "\"sesion\"");
    let one = in_sessions(&bare, |_| "one");
    let trouble = calibrate(&slip, &one, &[]).expect_err("no such key");
    let said = format!("{trouble:?} {}", trouble.hint().unwrap_or_default());
    assert!(said.contains("did you mean \"session\""), "{said}");
    // Other kinds have no such key.
    for kind in ["shaker-single", "shaker-primary"] {
        let text = format!("kind = \"{kind}\"\n[runs]\nfile = \"runs.csv\"\n{BETWEEN}");
        let store = Memory::new()
            .file("campaign.toml", text)
            .file("runs.csv", bare.clone());
        let refused = Campaign::read(Arc::new(store), "campaign.toml");
        let trouble = refused.map(|_| ()).expect_err(kind);
        let said = trouble.to_string();
        assert!(
            said.contains("unknown") && said.contains("campaign.toml"),
            "{said}"
        );
    }
}

#[test]
fn known_plan_of_two_sessions() {
    let plan = |sessions: &[&str]| {
        let mut text = "inclination_deg,rotation_deg,session\n".to_owned();
        for session in sessions {
            for c in published_plan().iter().step_by(3) {
                let [a, w] = [c.inclination, c.rotation].map(f64::to_degrees);
                let _ = writeln!(text, "{a},{w},{session}");
            }
        }
        let store = Memory::new()
            .file(
                "campaign.toml",
                format!("{HEAD}{BETWEEN}[plan]\nfile = \"plan.csv\"\n"),
            )
            .file("plan.csv", text);
        let campaign = Campaign::read(Arc::new(store), "campaign.toml").expect("a campaign");
        let Campaign::ShakerTriaxial(campaign) = campaign else {
            panic!("triaxial");
        };
        let (job, _) = campaign.plan_job(160.0).expect("a plan");
        job.evaluate(&(), &Unwatched).expect("a prediction")
    };
    let (one, two) = (plan(&["a", "a"]), plan(&["a", "b"]));
    let main = |outcome: &PlanOutcome| outcome.predicted()[0].relative_real;
    let less = main(&one).powi(2) - main(&two).powi(2);
    assert!(
        (less / (0.5 * 0.003f64.powi(2)) - 1.0).abs() < 0.02,
        "{less}"
    );
    let told = |o: &PlanOutcome| {
        let said = o
            .findings()
            .iter()
            .find(|f| f.code() == "plan-of-one-session");
        said.is_some()
    };
    assert!(told(&one) && !told(&two));
}
