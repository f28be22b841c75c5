//! Coefficients of other programs: all forms of one sensor compensate alike.

use proofmass_core::Matrix3;
use proofmass_documents::{
    CalibrationFile, CoefficientForm, ExportForm, ExportOptions, export, import_coefficients,
};
use proofmass_io::{Result, Source, Unit};

/// output = K a + b of one sensor, in every form.
const K: [[f64; 3]; 3] = [[1.02, 0.01, 0.0], [0.0, 0.98, -0.02], [0.0, 0.0, 1.01]];
const B: [f64; 3] = [0.1, -0.2, 0.3];

fn import(text: &str, form: CoefficientForm) -> Result<CalibrationFile> {
    let source = Source::from_bytes("coefficients", text)?;
    let unit = Unit::MetrePerSecondSquared;
    import_coefficients(source, form, unit, unit)
}

fn text_of(m: [[f64; 3]; 3]) -> String {
    m.map(|r| format!("{} {} {}", r[0], r[1], r[2])).join("\n")
}

#[test]
fn law_all_forms_compensate_alike() {
    let inverse = Matrix3(K).inverse().unwrap().0;
    let b = format!("{} {} {}", B[0], B[1], B[2]);
    // T K with K the diagonal of the inverse.
    let scale = [0, 1, 2].map(|i| inverse[i][i]);
    let t = inverse.map(|row| [row[0] / scale[0], row[1] / scale[1], row[2] / scale[2]]);
    let json = |m: [[f64; 3]; 3]| {
        let rows = m.map(|r| format!("[{}, {}, {}]", r[0], r[1], r[2]));
        format!("[{}]", rows.join(", "))
    };
    let k_a = Matrix3::diagonal([K[0][0], K[1][1], K[2][2]]).0;
    let r_a: [[f64; 3]; 3] = std::array::from_fn(|i| K[i].map(|v| v / K[i][i]));
    let texts = [
        (
            CoefficientForm::Magneto,
            format!(
                "Combined bias (b):\n{b}\n\nCorrection (A-1):\n{}\n",
                text_of(inverse)
            ),
        ),
        (
            CoefficientForm::ImuTk,
            format!(
                "{}\n\n{}\n\n{b}\n",
                text_of(t),
                text_of(Matrix3::diagonal(scale).0)
            ),
        ),
        (
            CoefficientForm::Imucal,
            format!(
                "{{\"cal_type\": \"ferraris\", \"K_a\": {}, \"R_a\": {}, \"b_a\": [{}, {}, {}], \"acc_unit\": \"m/s^2\"}}",
                json(k_a),
                json(r_a),
                B[0],
                B[1],
                B[2]
            ),
        ),
    ];
    for (form, text) in texts {
        let file = import(&text, form).unwrap();
        for i in 0..3 {
            assert!((file.b[i] - B[i]).abs() < 1e-12, "{form:?}");
            for j in 0..3 {
                assert!(
                    (file.k[i][j] - K[i][j]).abs() < 1e-12,
                    "{form:?} {:?}",
                    file.k
                );
            }
        }
    }
    let six = import(
        "0.1 -0.2 0.3\n1.02 0.98 1.01\n",
        CoefficientForm::SixParameters,
    )
    .unwrap();
    assert_eq!((six.k[1][1], six.b[2]), (0.98, 0.3));
}

/// Outputs in mg are compensated in m/s².
#[test]
fn known_units_are_those_of_the_compensation() {
    let source = Source::from_bytes("six", "10 0 0 100 100 100").unwrap();
    let form = CoefficientForm::SixParameters;
    let file = import_coefficients(
        source,
        form,
        Unit::MilliGravity,
        Unit::MetrePerSecondSquared,
    )
    .unwrap();
    assert_eq!(file.input_unit, Unit::MetrePerSecondSquared);
    let mg = 9.806_65e-3;
    let a = file.sensor().unwrap().apply([110.0 * mg, 0.0, 0.0]);
    assert!((a[0] - 1.0).abs() < 1e-12);
}

/// What `export --imu-yaml` writes is read back, gyroscopes beside it or not.
#[test]
fn law_exported_intrinsics_come_back() {
    let mut file = import("0 0 0 1.02 0.98 1.01", CoefficientForm::SixParameters).unwrap();
    file.k = K.map(|row| row.to_vec()).to_vec();
    let text = export(&file, ExportForm::ImuYaml, &ExportOptions::default());
    let gyroscopes = "  gyroscopes:\n    M:\n    - [9.0, 9.0, 9.0]\n    - [9.0, 9.0, 9.0]\n    - [9.0, 9.0, 9.0]\n";
    let both = text.unwrap() + gyroscopes;
    assert_eq!(import(&both, CoefficientForm::Kalibr).unwrap().k, file.k);
}

#[test]
fn refuses_other_texts_and_says_what_is_needed() {
    for (text, form) in [
        ("1 2 3", CoefficientForm::SixParameters),
        ("1 2 3 0 0 0", CoefficientForm::SixParameters),
        ("0 0 0  1 0 0  1 0 0  0 0 1", CoefficientForm::Magneto),
        ("1 2", CoefficientForm::ImuTk),
        ("{}", CoefficientForm::Imucal),
        (
            "accelerometers:\n M:\n - [1, 0, x]\n",
            CoefficientForm::Kalibr,
        ),
        ("M:\n - [1, 0, 0]\n", CoefficientForm::Kalibr),
        ("inf 0 0 1 1 1", CoefficientForm::SixParameters),
    ] {
        let error = import(text, form).unwrap_err();
        assert!(error.hint().is_some(), "{form:?}: {error}");
    }
}
