//! Calibration files, outputs, and recordings of others.

use proofmass_io::*;
use proofmass_uncertainty::{Component, Estimate, EstimateSeries, SeriesPoint};
use std::path::PathBuf;

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
        ("\"version\": 2", "\"version\": 3", "version 3"),
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
    bad.k[2] = vec![0.0; 3];
    assert!(bad.to_json().unwrap_err().to_string().contains("singular"));
    bad.k[2][2] = f64::NAN;
    assert!(bad.to_json().is_err());
}

/// Written by the first version of the form: it stays readable and, copied, what it is.
#[test]
fn regress_version_1_is_read() {
    let bytes = include_bytes!("data/calibration-version-1.json");
    let old = CalibrationFile::from_json(bytes).unwrap();
    assert_eq!((old.schema.version, old.model.as_str()), (1, "triangular"));
    assert_eq!(old.k[0][0].to_bits(), 415.22005013859535f64.to_bits());
    let scale = old.estimate.get("scale.x").unwrap();
    assert_eq!(scale.value.to_bits(), old.k[0][0].to_bits());
    let any = AnyCalibration::from_json(bytes).unwrap();
    assert_eq!(any.kind(), TRIAXIAL);
    assert_eq!(any, AnyCalibration::from(old.clone()));
    assert_eq!(any.to_json().unwrap(), bytes);
}

/// Written by the second version, with temperature and curvature: it stays readable and, copied, what it is.
#[test]
fn regress_version_2_is_read() {
    let bytes = include_bytes!("data/calibration-version-2.json");
    let old = CalibrationFile::from_json(bytes).unwrap();
    assert_eq!((old.schema.version, old.model.as_str()), (2, "triangular"));
    let thermal = old.temperature.as_ref().unwrap();
    assert_eq!(thermal.reference.to_bits(), 25.0f64.to_bits());
    let slope = old.estimate.get("bias.x.T1").unwrap();
    assert_eq!(slope.value.to_bits(), thermal.bias[0][0].to_bits());
    assert!((slope.value - 0.4).abs() < slope.expanded(0.999));
    let curvature = old.curvature.as_ref().unwrap();
    let quadratic = old.estimate.get("curvature.z.2").unwrap();
    assert_eq!(quadratic.value.to_bits(), curvature.quadratic[2].to_bits());
    // What it compensates stays what it was: an output at 50 °C, back and forth.
    let model = old.compensation().unwrap();
    let model = model.three_axes().unwrap();
    let a = model.apply(model.invert([1.0, -2.0, 9.0], 50.0), 50.0);
    assert!((a[0] - 1.0).abs() < 1e-12);
    assert_eq!(
        AnyCalibration::from_json(bytes).unwrap().to_json().unwrap(),
        bytes
    );
}

/// One output, two frequencies.
fn response() -> FrequencyResponseFile {
    let point = |at: f64, re: f64| SeriesPoint {
        at,
        estimate: Estimate::new(
            vec![
                Component::new("K.re", "V/(m/s²)", re),
                Component::new("K.im", "V/(m/s²)", -0.1 * re),
            ],
            vec![],
        )
        .unwrap(),
    };
    let one = vec!["axis".to_owned()];
    let series = EstimateSeries::new(vec![point(10.0, 0.1 + 0.2), point(20.0, 0.3)], None).unwrap();
    FrequencyResponseFile::new("comparison", Unit::Volt, one.clone(), one, series)
}

#[test]
fn law_a_frequency_response_is_read_as_written() {
    let file = response();
    let bytes = file.to_json().unwrap();
    assert_eq!(FrequencyResponseFile::from_json(&bytes).unwrap(), file);
    let any = AnyCalibration::from_json(&bytes).unwrap();
    assert_eq!(any.kind(), FREQUENCY_RESPONSE);
    assert_eq!(any.to_json().unwrap(), bytes);
    // A reader of the other kind says which one it is.
    let e = CalibrationFile::from_json(&bytes).unwrap_err();
    assert!(e.to_string().contains("frequency-response") && e.hint().is_some());
}

#[test]
fn refuses_damaged_frequency_responses() {
    let text = String::from_utf8(response().to_json().unwrap()).unwrap();
    let cut = &text[..text.len() / 2];
    for (damaged, word) in [
        (cut.to_owned(), "damaged"),
        (text.replace("\"frequency-response\"", "\"shock\""), "shock"),
        (text.replace("\"at\": 10.0", "\"at\": -10.0"), "impossible"),
        (text.replace("\"at\": 10.0", "\"at\": 20.0"), "damaged"),
        (text.replace("\"K.im\"", "\"K.x\""), "names"),
        (text.replace("\"m/s²\"", "\"V\""), "m/s²"),
        (text.replacen("\"axis\"", "\"axis\", \"y\"", 1), "elements"),
    ] {
        let e = AnyCalibration::from_json(damaged.as_bytes()).unwrap_err();
        assert!(e.to_string().contains(word), "{e}");
    }
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
