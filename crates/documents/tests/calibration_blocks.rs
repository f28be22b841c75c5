//! What a calibration holds beyond the linear model is applied and exported as it says.

use proofmass_documents::{
    CalibrationFile, CurvatureBlock, ExportForm, ExportOptions, ThermalBlock, export,
};

const PLAIN: &[u8] = include_bytes!("data/calibration-version-1.json");

fn with_blocks() -> CalibrationFile {
    let mut file = CalibrationFile::from_json(PLAIN).unwrap();
    file.schema.version = proofmass_documents::CALIBRATION_VERSION;
    file.temperature = Some(ThermalBlock {
        reference: 25.0,
        bias: vec![[0.5, -1e-3, 0.0]; 3],
        scale: vec![[1e-4, 0.0, 0.0]; 3],
        range: [-20.0, 70.0],
        hysteresis: Some(vec![0.3, 0.3, 0.4]),
    });
    file.curvature = Some(CurvatureBlock {
        quadratic: vec![1e-5; 3],
        cubic: vec![0.0; 3],
        reach: 80.0,
    });
    file
}

#[test]
fn law_blocks_come_back_as_they_were_written() {
    let file = with_blocks();
    let back = CalibrationFile::from_json(&file.to_json().unwrap()).unwrap();
    assert_eq!(back, file);
    let model = back.compensation().unwrap();
    let model = model.three_axes().unwrap();
    let output = model.invert([1.0, -2.0, 9.0], 60.0);
    let a = model.apply(output, 60.0);
    assert!((a[1] + 2.0).abs() < 1e-12);
    assert!(back.temperature.unwrap().covers(70.0));
}

#[test]
fn refuses_blocks_that_make_no_sense() {
    let mut file = with_blocks();
    file.temperature.as_mut().unwrap().range = [30.0, 20.0];
    assert!(file.to_json().unwrap_err().to_string().contains("range"));
    file = with_blocks();
    file.temperature.as_mut().unwrap().bias[1][0] = f64::INFINITY;
    assert!(file.to_json().is_err());
    file = with_blocks();
    file.curvature.as_mut().unwrap().quadratic[0] = 1e-2;
    let error = file.to_json().unwrap_err().to_string();
    assert!(error.contains("share of curvature"), "{error}");
}

#[test]
fn law_every_export_names_its_source_and_checks_itself() {
    let file = with_blocks();
    for (form, words) in [
        (ExportForm::Rust, ["pub const", "self_check"]),
        (ExportForm::C, ["static inline int", "self_check"]),
        (
            ExportForm::Python,
            [
                "def apply(x, y, z, temperature, hold=False)",
                "def self_check",
            ],
        ),
        (
            ExportForm::Json,
            ["\"proofmass.coefficients\"", "\"check\""],
        ),
    ] {
        let text = export(&file, form, &ExportOptions::default()).unwrap();
        for word in words {
            assert!(text.contains(word), "{form:?} lacks {word}\n{text}");
        }
    }
    // Outside of the temperatures nothing is computed unless it is asked for.
    for (form, refuses, holds) in [
        (
            ExportForm::Rust,
            "pub fn apply(output: [f32; 3], temperature: f32) -> Option<[f32; 3]>",
            "as the nearer end of it",
        ),
        (ExportForm::C, "return 0;", "_HOLD_TEMPERATURE"),
        (ExportForm::Python, "raise ValueError", "if hold:"),
    ] {
        let text = export(&file, form, &ExportOptions::default()).unwrap();
        for word in [refuses, holds] {
            assert!(text.contains(word), "{form:?} lacks {word}\n{text}");
        }
    }
    // Raw outputs have no place in a form for accelerations.
    let error = export(&file, ExportForm::ImuYaml, &ExportOptions::default()).unwrap_err();
    assert!(error.hint().is_some() && error.to_string().contains("count"));
}

#[test]
fn refuses_names_that_are_none_and_text_that_would_end_a_comment() {
    let mut file = with_blocks();
    file.device.model = Some("*/ #include <evil.h>\n//".into());
    let text = export(&file, ExportForm::C, &ExportOptions::default()).unwrap();
    assert_eq!(text.matches("*/").count(), text.matches("/*").count());
    assert!(!text.lines().any(|l| l.trim_start().starts_with("#include")));
    let mut options = ExportOptions::default();
    options.name = Some("a b".into());
    assert!(export(&file, ExportForm::C, &options).is_err());
}
