//! Files of others, and what is written.

use crate::outputs::result;
use proofmass_io::*;
use std::path::PathBuf;

#[test]
fn output_appears_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("results");
    {
        let out = OutputFolder::create(&target, false).unwrap();
        out.write("result.json", "x").unwrap();
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    let json = result("multi-position", &[]);
    for _ in 0..2 {
        let out = OutputFolder::create(&target, false).unwrap();
        out.write("result.json", &json).unwrap();
        out.commit().unwrap();
    }
    std::fs::write(target.join("notes.txt"), "mine").unwrap();
    OutputFolder::create(&target, false)
        .unwrap()
        .commit()
        .unwrap_err();
    assert_eq!(
        std::fs::read_to_string(target.join("notes.txt")).unwrap(),
        "mine"
    );
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    assert!(AtomicFile::create(target.join("notes.txt"), &[&target.join("notes.txt")]).is_err());
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

/// Recordings of others; only tests that are ignored without them ask for them.
fn reference_data() -> PathBuf {
    let data = std::env::var_os("PROOFMASS_REFERENCE_DATA");
    data.expect("PROOFMASS_REFERENCE_DATA names the folder, see docs/reference-data.md")
        .into()
}

/// Extremes, means and deviations of a file of 15 931 rows, from an exactly rounded sum (`math.fsum` of Python).
///
/// Welford's running mean errs by at most n·2⁻⁵³·max|v| ≈ 1.2e-10; in practice by far less.
#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn crosscheck_statistics_of_mikov_imu1() {
    let data = reference_data();
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

#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn crosscheck_recordings_of_others() {
    let data = reference_data();
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
        assert_eq!(
            (i.rows + u64::from(header), i.bad_count),
            (lines, 0),
            "{name}"
        );
        println!(
            "{name}: {} rows, rate {:?}",
            i.rows,
            i.time.map(|t| t.rate_hz)
        );
    }
}
