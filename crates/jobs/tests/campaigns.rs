//! Campaigns as people write them.

use proofmass_core::Unwatched;
use proofmass_io::{Result, Unit};
use proofmass_jobs::campaign::{Campaign, Draft, KINDS, MethodModel, example};
use proofmass_jobs::simulate::{SimulateJob, SimulatedShaker};
use proofmass_jobs::{Gathered, Job, Memory, Sink, Store};
use std::path::PathBuf;
use std::sync::Arc;

/// Recordings of others; only tests that are ignored without them ask for them.
fn reference_data() -> PathBuf {
    let data = std::env::var_os("PROOFMASS_REFERENCE_DATA");
    data.expect("PROOFMASS_REFERENCE_DATA names the folder, see docs/reference-data.md")
        .into()
}

fn campaign(text: &str) -> Result<Campaign> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("campaign.toml"), text).unwrap();
    Campaign::open(folder.path())
}

const GOOD: &str = "kind = \"multi-position\"\n[recording]\nfile = \"r.txt\"\ncolumns = { x = 2, y = 3, z = \"acc_z\" }\ntime = 1\nunit = \"count\"\nrange = [0, 65535]\n[gravity]\nvalue = 9.81744\nstandard_uncertainty = 2e-5\n";

#[test]
fn campaign_reads_and_refuses() {
    let Campaign::MultiPosition(c) = campaign(GOOD).unwrap() else {
        panic!()
    };
    assert_eq!(c.method.model, MethodModel::Triangular);
    assert_eq!(c.method.confidence, 0.95);
    for (from, to, line, hint) in [
        (
            "multi-position",
            "multi-positon",
            1,
            "did you mean \"multi-position\"",
        ),
        ("unit =", "unti =", 6, "did you mean `unit`"),
        ("9.81744", "98.1744", 9, "m/s²"),
        ("\"count\"", "\"furlong\"", 6, ""),
    ] {
        let e = campaign(&GOOD.replace(from, to)).unwrap_err();
        assert_eq!(e.line_number(), Some(line), "{e}");
        assert!(
            e.hint().unwrap_or_default().contains(hint),
            "{e}: {:?}",
            e.hint()
        );
    }
    assert!(campaign("").unwrap_err().to_string().contains("empty"));
}

/// A recording of counts with a text column in front, its parts given as segments in a table.
#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn crosscheck_ferraris_sample_through_a_campaign() {
    let data = reference_data();
    let folder = tempfile::tempdir().unwrap();
    let file = data.join("ferraris-imu/annotated_session.csv");
    let campaign = format!(
        "kind = \"multi-position\"\n[recording]\nfile = {file:?}\n\
         columns = {{ x = \"acc_x\", y = \"acc_y\", z = \"acc_z\" }}\nsampling_rate_Hz = 102.4\nunit = \"count\"\n\
         [gravity]\nvalue = 9.81\nstandard_uncertainty = 1e-4\n\
         [standstill]\nsegments = \"segments.csv\"\n[method]\nmodel = \"ferraris\"\n",
    );
    std::fs::write(folder.path().join("campaign.toml"), campaign).unwrap();
    // Where each part begins and ends, from the column `part` of the file.
    let parts = [
        ("x_a", 0, 1061, "-x"),
        ("x_p", 1061, 2089, "+x"),
        ("y_a", 3394, 4242, "-y"),
        ("y_p", 4242, 4976, "+y"),
        ("z_a", 6069, 7113, "-z"),
        ("z_p", 7113, 7994, "+z"),
    ];
    let rows: String = parts
        .iter()
        .map(|(label, start, end, up)| format!("{label},{start},{end},{up}\n"))
        .collect();
    let table = format!("label,start,end,direction\n{rows}");
    std::fs::write(folder.path().join("segments.csv"), table).unwrap();

    let Campaign::MultiPosition(c) = Campaign::open(folder.path()).unwrap() else {
        panic!()
    };
    let recordings = c.read_recordings().unwrap();
    let r = &recordings[0];
    assert_eq!((r.samples(), r.columns[0].unit), (9414, Some(Unit::Count)));
    // Sums of whole numbers are exact; the quotients by Python.
    for (column, mean) in
        r.columns
            .iter()
            .zip([266.04270235818996, 169.45336732526025, 249.73762481410665])
    {
        assert_eq!(column.data.iter().sum::<f64>() / 9414.0, mean);
    }
    let (segments, _) = c.read_segments(r).unwrap().unwrap();
    assert_eq!(segments.len(), 6);
    // Published: K_a 208.54567, 208.00113, 214.78455 counts/(m/s²), b_a −6.01887, −48.28787, −28.96637, g = 9.81, and
    // a rotation of up to 1.4°. So a part reads ±K g + b on its own axis within (1 − cos 1.4°) K g < 1 count, to
    // which axes that were aligned by hand within 2° add as much again: 3 counts in all.
    let k = [208.54567, 208.00113, 214.78455];
    let b = [-6.01887, -48.28787, -28.96637];
    for (segment, (label, ..)) in segments.iter().zip(parts) {
        assert_eq!(segment.label.as_deref(), Some(label));
        let up = segment.attitude.unwrap();
        let axis = up.iter().position(|u| *u != 0.0).unwrap();
        let part = &r.columns[axis].data[segment.start..segment.end];
        let mean = part.iter().sum::<f64>() / part.len() as f64;
        let expected = k[axis] * 9.81 * up[axis] + b[axis];
        assert!((mean - expected).abs() < 3.0, "{label}: {mean}, {expected}");
    }
}

/// What `init --kind` writes is a campaign of that kind whose tables give a result, or that asks for the measurement by name.
#[test]
fn law_the_example_of_every_kind_runs() {
    for kind in KINDS {
        let files = Gathered::default();
        example(kind, &files, &Unwatched).unwrap_or_else(|e| panic!("{kind}: {e}"));
        let campaign = Campaign::read(Arc::new(files.into_memory()), "campaign.toml");
        let campaign = campaign.unwrap_or_else(|e| panic!("{kind}: {e} {:?}", e.hint()));
        assert_eq!(campaign.kind(), *kind);
        let result = campaign.evaluate(None, &Unwatched);
        let result = result.unwrap_or_else(|e| panic!("{kind}: {e} {:?}", e.hint()));
        // The motion of a table is a table of ratios.
        assert!(
            !result.quantities().is_empty() || *kind == "spurious-motion",
            "{kind}"
        );
        if *kind == "free-living" {
            let scale = result.quantities().iter().find(|q| q.name == "scale.x");
            let scale = scale.expect("a scale factor");
            assert!(
                (scale.value - 1.0 / 1.01).abs() < scale.expanded,
                "{scale:?}"
            );
            assert!(scale.expanded < 2e-3, "{scale:?}");
        }
    }
    let nothing = example("nothing", &Gathered::default(), &Unwatched).unwrap_err();
    assert!(nothing.hint().unwrap().contains("shaker-single"));
}

/// What `init` does not know stands in its campaign as comments, and the campaign asks for all of it at once.
#[test]
fn law_a_drafted_campaign_asks_for_all_that_is_not_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.csv");
    let row = |i: u32| format!("{},0.01,-0.02,{}\n", 10 * i, 1.0 + 1e-3 * f64::from(i % 5));
    let rows: String = (0..500).map(row).collect();
    std::fs::write(&path, format!("timestamp,ax,ay,az\n{rows}")).unwrap();
    let text = Draft::default().text(&path).unwrap();
    for line in [
        "# latitude_deg",
        "# height_m",
        "# unit = \"g\"",
        "# time_unit = \"ms\"",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let read = |text: &str| {
        let files = Memory::new().file("r.csv", std::fs::read(&path).unwrap());
        let files = files.file("campaign.toml", text.to_owned());
        Campaign::read(Arc::new(files), "campaign.toml")
    };
    let asked = read(&text).unwrap_err();
    let hint = asked.hint().unwrap();
    for words in [
        "unit = \"g\"",
        "time_unit = \"ms\"",
        "latitude_deg = DEGREES",
        "height_m",
    ] {
        assert!(hint.contains(words), "{words}: {asked} {hint}");
    }
    // Said in part, the rest is asked for before anything is read.
    let placed = text.replace("# latitude_deg = …", "latitude_deg = 50\nheight_m = 100 #");
    let Campaign::MultiPosition(campaign) = read(&placed).unwrap() else {
        panic!("another kind");
    };
    let asked = campaign.load(&Unwatched).unwrap_err();
    let hint = asked.hint().unwrap();
    assert!(
        hint.contains("unit = \"g\", time_unit = \"ms\""),
        "{asked} {hint}"
    );
    // Without a campaign the command to type has them all.
    let asked = Draft::default().campaign(&path).unwrap_err();
    let hint = asked.hint().unwrap();
    let options = "--latitude DEGREES --height METRES --unit g --time-unit ms";
    assert!(hint.contains(options), "{hint}");
}

/// A campaign of three recordings, whose full scale is stated or not.
#[test]
fn known_recordings_without_full_scale_cannot_be_checked_for_clipping() {
    let mut shaker = SimulatedShaker::default();
    (shaker.configurations, shaker.duration) = (4, 0.2);
    (shaker.frequencies, shaker.repeats) = (vec![160.0], 3);
    let files = Gathered::default();
    let job = SimulateJob::Shaker(shaker);
    job.evaluate(&(&files as &dyn Sink), &Unwatched).unwrap();
    let files = files.into_memory();
    let source = files.open("campaign.toml").unwrap();
    let text = String::from_utf8(source.into_bytes(10_000).unwrap().0).unwrap();
    let told = |text: String| {
        let files = files.clone().file("campaign.toml", text);
        let campaign = Campaign::read(Arc::new(files), "campaign.toml").unwrap();
        let result = campaign.evaluate(None, &Unwatched).unwrap();
        let findings = result.findings();
        let found = findings.iter().find(|f| f.code() == "clipping-unchecked");
        found.is_some()
    };
    let stated = text
        .lines()
        .find(|l| l.starts_with("full_scale_V"))
        .unwrap();
    assert!(told(text.replace(stated, "")));
    assert!(!told(text.clone()));
}
