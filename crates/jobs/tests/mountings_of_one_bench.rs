//! A device glued and screwed on one bench: the difference without the reference of both, and the ratio as a correction.

use crate::bench_inputs::{calibrate, quantity, runs};
use num_complex::Complex64;
use proofmass_documents::AnyCalibration;
use proofmass_dynamic::FrequencyResponse;
use proofmass_jobs::comparison::{ComparisonData, ComparisonJob, ComparisonOutcome};
use proofmass_jobs::frequency_response::ResponseDocument;
use proofmass_jobs::{
    Job, Memory, Outcome, Store, StoredResult, Trouble, Unwatched, frequency_response,
};

const F: [f64; 4] = [10.0, 80.0, 160.0, 1000.0];

/// `[Murgia2022]` table 3.1, taken as glued over screwed less one.
fn printed(f: f64) -> f64 {
    let table = include_str!("data/inrim-pcb356a15/adhesive-vs-stud.csv");
    let mut rows = table
        .lines()
        .skip(1)
        .map(|l| l.split_once(',').expect("two columns"));
    let row = rows.find(|r| r.0.parse() == Ok(f)).expect("the frequency");
    0.01 * row.1.parse::<f64>().expect("a number")
}

const REFERENCE: &str = "[[budget]]\nname = \"reference.calibration\"\nacts = \"reference-modulus\"\nunit = \"%\"\nvaries_with = []\n\
    distribution = { kind = \"normal\", mean = 0.0, u = 0.2 }\n";

fn glued(more: &str, files: &[(&str, &str)]) -> StoredResult {
    let runs = runs(&F, |channel, f| {
        Complex64::new(if channel == 3 { 1.0 } else { 1.0 + printed(f) }, 0.0)
    });
    calibrate(&format!("{REFERENCE}{more}"), &runs, files).expect("glued")
}

fn screwed() -> StoredResult {
    let runs = runs(&F, |_, _| Complex64::new(1.0, 0.0));
    calibrate(REFERENCE, &runs, &[]).expect("screwed")
}

fn response(result: &StoredResult) -> FrequencyResponse {
    let files = result.files().expect("files");
    let (_, bytes) = files
        .iter()
        .find(|(name, _)| name == "calibration.json")
        .expect("calibration.json");
    match AnyCalibration::from_json(bytes).expect("a calibration") {
        AnyCalibration::FrequencyResponse(file) => {
            frequency_response::of_file(&file).expect("a response")
        }
        _ => panic!("another kind"),
    }
}

/// Its calibration.json as `compare` reads it.
fn document(result: &StoredResult) -> ResponseDocument {
    let files = result.files().expect("files");
    let (_, bytes) = files
        .iter()
        .find(|(name, _)| name == "calibration.json")
        .expect("calibration.json");
    let store = Memory::new().file("calibration.json", bytes.clone());
    let source = store.open("calibration.json").expect("the file");
    frequency_response::read_document(source, None).expect("a document")
}

fn compare(
    responses: [&FrequencyResponse; 2],
    common: &[&str],
) -> Result<ComparisonOutcome, Trouble> {
    let data = ComparisonData {
        responses: &responses,
        names: &["glued", "screwed"],
        findings: &[],
    };
    let mut job = ComparisonJob::default();
    job.common = common.iter().map(|&c| c.to_owned()).collect();
    job.evaluate(&data, &Unwatched)
}

#[test]
fn published_differences_of_two_mountings_without_the_reference_of_both() {
    let (a, b) = (response(&glued("", &[])), response(&screwed()));
    let plain = compare([&a, &b], &[]).expect("a comparison");
    let asked: Vec<&str> = plain.findings().iter().map(|f| f.code()).collect();
    assert!(asked.contains(&"common-cause-possible"), "{asked:?}");
    let shared = compare([&a, &b], &["reference"]).expect("a comparison");
    let codes: Vec<&str> = shared.findings().iter().map(|f| f.code()).collect();
    assert!(codes.contains(&"common-causes-taken-out"), "{codes:?}");
    assert!(!codes.contains(&"common-cause-possible"), "{codes:?}");
    let main = |outcome: &ComparisonOutcome| {
        let points = outcome.pair().expect("two").points.clone();
        let mains = points
            .into_iter()
            .filter(|p| ["K.xx", "K.yy", "K.zz"].contains(&p.element.as_str()));
        mains.collect::<Vec<_>>()
    };
    for (before, after) in main(&plain).iter().zip(main(&shared)) {
        let difference = printed(before.frequency);
        // The additive noise weighs the runs a little otherwise where the readings are smaller.
        assert!(
            (before.modulus_difference - difference).abs() < 1e-6,
            "{before:?}"
        );
        // 0.2 % of the reference twice: 1.96 · √2 · 0.2 % and the readings, of which alone the rest is.
        assert!(
            (0.0055..0.0062).contains(&before.modulus_expanded),
            "{before:?}"
        );
        let both = 1.0 + (1.0 + difference).powi(2);
        let readings = before.modulus_expanded.powi(2) - both * (1.959_964f64 * 0.002).powi(2);
        let left = after.modulus_expanded.powi(2);
        // What stays of the reference is its share of the difference: 2 % squared of 0.2 %.
        assert!(
            (left / readings - 1.0).abs() < 0.01,
            "{left:e} {readings:e}"
        );
        assert_eq!(after.modulus_en_independent, Some(before.modulus_en));
    }
    // −0.56 % at 10 Hz: E_n about −1 with the reference counted twice, beyond −3 without it.
    let z = main(&shared)
        .into_iter()
        .find(|p| p.frequency == 10.0)
        .expect("10 Hz");
    assert!(
        z.modulus_en < -3.0 && z.modulus_en_independent.is_some_and(|e| e > -1.1),
        "{z:?}"
    );
}

#[test]
fn known_files_that_two_calibrations_were_computed_from() {
    let table = "frequency_Hz,ratio,u_ratio\n10,1.01,0.001\n1000,1.01,0.001\n";
    let files = [("mounting.csv", table)];
    let one = document(&glued("[mounting]\nfile = \"mounting.csv\"\n", &files));
    let other = document(&screwed());
    assert!(frequency_response::files_of_both(&[one.clone(), other]).is_none());
    let again = document(&glued(
        "[mounting]\nfile = \"mounting.csv\"\ndescription = \"a stud\"\n",
        &files,
    ));
    let said = frequency_response::files_of_both(&[one, again]).expect("two files");
    assert_eq!(said.code(), "files-of-both");
    assert!(said.what().contains("mounting.csv"), "{said}");
    assert!(!said.what().contains("campaign.toml"), "{said}");
}

#[test]
fn refuses_common_causes_that_are_not_of_both() {
    let (a, b) = (response(&glued("", &[])), response(&screwed()));
    let refused = compare([&a, &b], &["laser"]).expect_err("no laser");
    assert!(
        refused.to_string().contains("\"laser\" is no entry"),
        "{refused}"
    );
    assert!(
        refused
            .hint()
            .is_some_and(|h| h.contains("reference.calibration")),
        "{:?}",
        refused.hint()
    );
    let data = ComparisonData {
        responses: &[&a, &b, &b],
        names: &["a", "b", "c"],
        findings: &[],
    };
    let mut job = ComparisonJob::default();
    job.common = vec!["reference".into()];
    let refused = job.evaluate(&data, &Unwatched).expect_err("three");
    assert!(
        refused.to_string().contains("two calibrations"),
        "{refused}"
    );
}

#[test]
fn law_the_ratio_of_two_mountings_takes_one_to_the_other_with_its_uncertainty() {
    let mut table = "frequency_Hz,ratio_%,u_ratio_%\n".to_owned();
    for f in F {
        table += &format!("{f},{},0.3\n", 100.0 / (1.0 + printed(f)));
    }
    let more = "[mounting]\nfile = \"mounting.csv\"\ndescription = \"a stud\"\n";
    let files = [("mounting.csv", table.as_str())];
    let (corrected, screwed, plain) = (glued(more, &files), screwed(), glued("", &[]));
    for f in F {
        for axis in ["xx", "yy", "zz"] {
            let name = format!("S.{axis}.modulus[frequency={f}]");
            let ((s, u), (t, _), (_, v)) = (
                quantity(&corrected, &name),
                quantity(&screwed, &name),
                quantity(&plain, &name),
            );
            assert!((s / t - 1.0).abs() < 1e-6, "{name}: {s} {t}");
            let more = (s * 0.003 * (1.0 + printed(f))).hypot(v);
            assert!((u / more - 1.0).abs() < 0.01, "{name}: {u} {more}");
        }
    }
    let said = corrected
        .findings()
        .iter()
        .find(|f| f.code() == "mounting-corrected");
    assert!(
        said.is_some_and(|f| f.what().contains("a stud")),
        "{said:?}"
    );
}

#[test]
fn refuses_ratios_that_cannot_be() {
    let runs = runs(&[80.0, 160.0], |_, _| Complex64::new(1.0, 0.0));
    for (table, words) in [
        (
            "frequency_Hz,ratio,u_ratio\n80,1.01,0.001\n",
            "80 to 80 Hz, and a run is at 160 Hz",
        ),
        (
            "frequency_Hz,ratio,u_ratio\n80,99.5,0.001\n160,99.5,0.001\n",
            "no ratio of two mountings",
        ),
        (
            "frequency_Hz,ratio,u_ratio\n80,-0.56,0.001\n160,1,0.001\n",
            "ratio",
        ),
        (
            "frequency_Hz,ratio,u_ratio\n80,1,-0.001\n160,1,0.001\n",
            "u_ratio",
        ),
        (
            "frequency_Hz,ratio,u_ratio\n160,1,0.001\n80,1,0.001\n",
            "80 Hz behind 160 Hz",
        ),
        ("frequency_Hz,ratio\n80,1\n160,1\n", "u_ratio"),
    ] {
        let more = "[mounting]\nfile = \"mounting.csv\"\n";
        let refused = calibrate(more, &runs, &[("mounting.csv", table)]).expect_err(table);
        let told = format!("{refused} {:?}", refused.place());
        assert!(
            told.contains(words) && told.contains("mounting"),
            "{table}: {told}"
        );
        assert!(refused.hint().is_some(), "{table}: no hint in {told}");
    }
    let twice = "[mounting]\nfile = \"mounting.csv\"\n[[budget]]\nname = \"mounting.correction\"\nacts = \"output-modulus\"\nunit = \"%\"\n\
        varies_with = []\ndistribution = { kind = \"normal\", mean = 0.0, u = 0.1 }\n";
    let table = "frequency_Hz,ratio,u_ratio\n80,1.01,0.001\n160,1.01,0.001\n";
    let refused = calibrate(twice, &runs, &[("mounting.csv", table)]).expect_err("twice");
    assert!(
        refused.to_string().contains("[mounting] states it too"),
        "{refused}"
    );
}
