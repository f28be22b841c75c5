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
    let k = [[414.42, 0.1, 0.2], [0.0, 412.03, 0.3], [0.0, 0.0, 414.62]];
    let quantities = vec![
        Component::new("bias.x", "count", b[0]),
        Component::new("misalignment.xy", "rad", 0.1 / 414.42),
        Component::new("misalignment.xz", "rad", 0.2 / 414.42),
        Component::new("misalignment.yz", "rad", 0.3 / 412.03),
    ];
    let estimate = Estimate::new(quantities, vec![]).unwrap();
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
    // Beyond 1e100 a number is no reading and is refused.
    .filter(|r| r.iter().all(|v| v.abs() < 1e100))
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

fn reference_data() -> Option<PathBuf> {
    let data = std::env::var_os("PROOFMASS_REFERENCE_DATA").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    if !data.is_dir() {
        println!("skipped: {} is absent", data.display());
        return None;
    }
    Some(data)
}

/// Extremes, means and deviations of a file of 15 931 rows, from an exactly rounded sum (`math.fsum` of Python).
///
/// Welford's running mean errs by at most n·2⁻⁵³·max|v| ≈ 1.2e-10; in practice by far less.
#[test]
fn crosscheck_statistics_of_mikov_imu1() {
    let Some(data) = reference_data() else { return };
    let i = inspect(data.join("mikov-mpu9150/imu1.log")).unwrap();
    assert_eq!((i.rows, i.bad_count, i.layout.columns), (15_931, 0, 6));
    for (column, min, max, mean, deviation, distinct) in [
        (
            0,
            -67.87009,
            16.64541,
            -0.10661728391186993,
            6.08369273347721,
            2491,
        ),
        (
            2,
            -27.13073,
            21.05226,
            0.2822377126357416,
            5.665255452106561,
            2444,
        ),
        (
            5,
            -4.56998,
            2.44585,
            -0.03722987948025861,
            0.33858917579254877,
            1456,
        ),
    ] {
        let s = i.columns[column].statistics.unwrap();
        assert_eq!((s.min, s.max, s.distinct), (min, max, Some(distinct)));
        assert!((s.mean - mean).abs() < 1.2e-10, "{}", s.mean);
        let found = s.standard_deviation.unwrap();
        assert!((found - deviation).abs() < 1.2e-10, "{found}");
    }
}

/// A recording of counts with a text column in front, its parts given as segments in a table.
#[test]
fn crosscheck_ferraris_sample_through_a_campaign() {
    let Some(data) = reference_data() else { return };
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
    let segments = c.read_segments(r).unwrap().unwrap();
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

#[test]
fn crosscheck_recordings_of_others() {
    let Some(data) = reference_data() else { return };
    for (name, columns, header) in [
        ("xsens-mti/xsens_acc.txt", 4, false),
        ("mikov-mpu9150/imu0.log", 6, false),
        ("mikov-mpu9150/imu1.log", 6, false),
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
