//! Campaigns, calibration files, outputs, and recordings of others.

use proofmass_io::*;
use proofmass_uncertainty::{Component, Estimate};
use std::path::PathBuf;

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

#[test]
fn calibration_file_round_trip_and_refusals() {
    let b = [0.1 + 0.2, 1.0 / 3.0, 5e-324];
    let estimate = Estimate::new(vec![Component::new("bias.x", "count", b[0])], vec![]).unwrap();
    let k = [[414.42, 0.1, 0.2], [0.0, 412.03, 0.3], [0.0, 0.0, 414.62]];
    let file = CalibrationFile::new("triangular", Unit::Count, k, b, estimate);
    let bytes = file.to_json().unwrap();
    assert_eq!(CalibrationFile::from_json(&bytes).unwrap(), file);
    let text = String::from_utf8(bytes).unwrap();
    for (from, to, word) in [
        ("\"version\": 1", "\"version\": 2", "version 2"),
        ("\"triaxial\"", "\"shaker\"", "kind"),
        (
            "proofmass.calibration",
            "proofmass.result",
            "proofmass.result",
        ),
    ] {
        let e = CalibrationFile::from_json(text.replace(from, to).as_bytes()).unwrap_err();
        assert!(e.to_string().contains(word) && e.hint().is_some(), "{e}");
    }
    let mut bad = file.clone();
    bad.k[2] = [0.0; 3];
    assert!(bad.to_json().unwrap_err().to_string().contains("singular"));
    bad.k[2][2] = f64::NAN;
    assert!(bad.to_json().is_err());
}

#[test]
fn output_appears_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("results");
    {
        let out = OutputFolder::create(&target, false).unwrap();
        out.write("result.json", "x").unwrap();
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    let json = ResultDocument::new("multi-position").to_json().unwrap();
    for _ in 0..2 {
        let out = OutputFolder::create(&target, false).unwrap();
        out.write("result.json", &json).unwrap();
        out.commit().unwrap();
    }
    std::fs::write(target.join("notes.txt"), "mine").unwrap();
    assert_eq!(
        OutputFolder::create(&target, false).unwrap_err().kind(),
        ErrorKind::Output
    );
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    assert!(AtomicFile::create(target.join("notes.txt"), &[&target.join("notes.txt")]).is_err());
    let e = ResultDocument::new("x")
        .section("residuals", &[0.0, f64::NAN])
        .unwrap_err();
    assert_eq!(e.field(), Some("residuals[1]"));
}

#[test]
fn law_rows_read_back_as_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("w.csv");
    let mut bits = 0x9E37_79B9_7F4A_7C15_u64;
    let rows: Vec<[f64; 2]> = std::iter::repeat_with(|| {
        [(); 2].map(|()| {
            bits ^= bits << 13;
            bits ^= bits >> 7;
            bits ^= bits << 17;
            f64::from_bits(bits)
        })
    })
    .filter(|r| r.iter().all(|v| v.is_finite()))
    .take(20_000)
    .collect();
    let mut w = RowWriter::create(&path, &["a".into(), "b_m/s2".into()], &[]).unwrap();
    rows.iter().for_each(|r| w.row(r).unwrap());
    assert!(w.row(&[f64::NAN, 0.0]).is_err());
    w.commit().unwrap();
    let options = RecordingOptions {
        columns: vec!["a".into(), "b".into()],
        sampling_rate_hz: Some(1.0),
        ..Default::default()
    };
    let r = Recording::read(&path, &options).unwrap();
    for (i, row) in rows.iter().enumerate() {
        assert_eq!(
            [
                r.columns[0].data[i].to_bits(),
                r.columns[1].data[i].to_bits()
            ],
            row.map(f64::to_bits)
        );
    }
}

#[test]
fn crosscheck_recordings_of_others() {
    let data = std::env::var_os("PROOFMASS_REFERENCE_DATA").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    if !data.is_dir() {
        println!("skipped: {} is absent", data.display());
        return;
    }
    for (name, columns, header) in [
        ("xsens-mti/xsens_acc.txt", 4, false),
        ("mikov-mpu9150/imu0.log", 6, false),
        ("ferraris-imu/annotated_session.csv", 8, true),
        ("ferraris-imu/example_ferraris_session.csv", 7, true),
        ("icm42652-temperature/sample.csv", 5, false),
        ("encoder-robot/t0.2.tab", 6, false),
        ("encoder-robot/20190427-v4-t0.3-2.csv", 8, false),
        ("hammer-frf/measurements_1.csv", 3, true),
        ("formats/labview_sample.lvm", 7, true),
    ] {
        let i = inspect(data.join(name)).unwrap_or_else(|e| panic!("{e}"));
        let lines = std::fs::read(data.join(name))
            .unwrap()
            .split(|b| *b == b'\n')
            .filter(|l| !l.trim_ascii().is_empty())
            .count() as u64;
        assert_eq!(
            (i.layout.columns, i.layout.header.is_some()),
            (columns, header),
            "{name}"
        );
        if !name.ends_with("lvm") {
            assert_eq!(
                (i.rows + u64::from(header), i.bad_count),
                (lines, 0),
                "{name}"
            );
        }
        println!(
            "{name}: {} rows, rate {:?}",
            i.rows,
            i.time.map(|t| t.rate_hz)
        );
    }
}
