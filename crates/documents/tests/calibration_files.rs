//! Calibrations and results read back as they were written, and older forms too.

use proofmass_documents::*;
use proofmass_io::*;
use proofmass_uncertainty::{Component, Estimate, EstimateSeries, SeriesPoint};

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
        (
            text.replace("\"at\": 10.0", "\"at\": -10.0"),
            "out of range",
        ),
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
fn refuses_numbers_that_are_not_finite() {
    let e = ResultDocument::new("x")
        .section("residuals", &[0.0, f64::NAN])
        .unwrap_err();
    assert_eq!(e.field(), Some("residuals[1]"));
}
