//! Calibration coefficients in the forms of other programs.
//!
//! None of these forms says which unit the outputs are in, and none has an uncertainty: the caller states the unit, and
//! the calibration that comes of it has an estimate without quantities.

use crate::source::LARGEST_DOCUMENT;
use crate::{CalibrationFile, Error, ErrorKind, Input, Result, Source, Unit};
use proofmass_core::Matrix3;
use proofmass_uncertainty::Estimate;

/// A form in which other programs keep coefficients.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CoefficientForm {
    /// Six numbers: bias of x, y, z in output units, then output units per m/s² of x, y, z.
    SixParameters,
    /// Magneto: combined bias b, then the rows of A⁻¹; a = A⁻¹ (output − b) in the unit of the norm it was given.
    Magneto,
    /// imu_tk: the matrices T and K and the vector b of a = T K (output − b), m/s².
    ImuTk,
    /// imucal: JSON with `K_a`, `R_a`, `b_a` of a = R_a⁻¹ K_a⁻¹ (output − b_a), m/s².
    Imucal,
    /// Kalibr: `accelerometers: M:` of output = M a + b in m/s², without the bias, which that program leaves to the filter.
    Kalibr,
}

impl CoefficientForm {
    /// As in messages and in the model of the calibration.
    pub fn name(self) -> &'static str {
        match self {
            Self::SixParameters => "six parameters",
            Self::Magneto => "Magneto",
            Self::ImuTk => "imu_tk",
            Self::Imucal => "imucal",
            Self::Kalibr => "Kalibr",
        }
    }
}

/// Reads coefficients of another program as a calibration.
///
/// `input_unit` is that of the outputs they apply to; `corrected_unit` that of Magneto's norm, m/s² for all others.
///
/// ```
/// use proofmass_io::{CoefficientForm, Source, Unit, import_coefficients};
///
/// let text = "12.5 -3.0 40.0\n0.01 0 0\n0 0.01 0\n0 0 0.0102\n";
/// let source = Source::from_bytes("magneto.txt", text)?;
/// let file = import_coefficients(source, CoefficientForm::Magneto, Unit::Count, Unit::StandardGravity)?;
/// let a = file.compensation()?.apply([12.5, -3.0, 140.0], 25.0);
/// assert!((a[2] - 1.02 * 9.80665).abs() < 1e-12);
/// assert!(file.estimate.components().is_empty()); // nothing is known of its uncertainty
/// # Ok::<(), proofmass_io::Error>(())
/// ```
///
/// # Errors
/// A text of another form (with what was found), a number that is not finite, a matrix that cannot be inverted, a unit
/// that is no acceleration.
pub fn import_coefficients(
    source: Source,
    form: CoefficientForm,
    input_unit: Unit,
    corrected_unit: Unit,
) -> Result<CalibrationFile> {
    let name = source.name().to_path_buf();
    let (bytes, input) = source.into_bytes(LARGEST_DOCUMENT)?;
    read(&bytes, form, input_unit, corrected_unit, input).map_err(|e| e.at(&name))
}

fn read(
    bytes: &[u8],
    form: CoefficientForm,
    input_unit: Unit,
    corrected_unit: Unit,
    input: Input,
) -> Result<CalibrationFile> {
    let text = std::str::from_utf8(bytes)
        .map_err(|e| bad(form, "is not text in UTF-8".into()).because(e))?;
    let (si, factor) = corrected_unit.si();
    if !si.is_acceleration() {
        return Err(bad(form, format!("{corrected_unit} is no acceleration")));
    }
    let inverse = |m: [[f64; 3]; 3]| {
        let inverse = Matrix3(m).inverse();
        inverse.map_err(|e| bad(form, format!("its matrix cannot be inverted: {e}")).because(e))
    };
    let (k, b) = match form {
        CoefficientForm::SixParameters => {
            let n = numbers::<6>(text, form)?;
            (Matrix3::diagonal([n[3], n[4], n[5]]).0, [n[0], n[1], n[2]])
        }
        CoefficientForm::Magneto => {
            let n = numbers::<12>(text, form)?;
            let a = rows(&n[3..]).map(|row| row.map(|v| v * factor));
            (inverse(a)?.0, [n[0], n[1], n[2]])
        }
        CoefficientForm::ImuTk => {
            let n = numbers::<21>(text, form)?;
            let correction = Matrix3(rows(&n[..9])).product(&Matrix3(rows(&n[9..18])));
            (inverse(correction.0)?.0, [n[18], n[19], n[20]])
        }
        CoefficientForm::Imucal => imucal(text, form)?,
        CoefficientForm::Kalibr => (kalibr(text, form)?, [0.0; 3]),
    };
    let estimate =
        Estimate::new(Vec::new(), Vec::new()).map_err(|e| bad(form, e.to_string()).because(e))?;
    // Recordings are compensated in SI, or in their raw unit.
    let (input_unit, to_si) = input_unit.si();
    let mut file = CalibrationFile::new(
        format!("imported from {}", form.name()),
        input_unit,
        k.map(|row| row.map(|v| v * to_si)),
        b.map(|v| v * to_si),
        estimate,
    );
    file.inputs = vec![input];
    // What cannot be written cannot be read either: finite numbers, an invertible matrix.
    file.to_json()?;
    Ok(file)
}

fn bad(form: CoefficientForm, what: String) -> Error {
    let expected = match form {
        CoefficientForm::SixParameters => {
            "six numbers: bias x, y, z, output units per m/s² of x, y, z"
        }
        CoefficientForm::Magneto => "twelve numbers: combined bias, then the three rows of A⁻¹",
        CoefficientForm::ImuTk => "21 numbers: the rows of T, the rows of K, b",
        CoefficientForm::Imucal => "JSON with K_a, R_a and b_a",
        CoefficientForm::Kalibr => "YAML with `accelerometers:`, `M:` and three rows `- [a, b, c]`",
    };
    Error::new(ErrorKind::Format, what).with_hint(format!("{} is {expected}", form.name()))
}

/// Exactly N numbers between any words; a word that is no number is one of the form's headings.
fn numbers<const N: usize>(text: &str, form: CoefficientForm) -> Result<[f64; N]> {
    let found: Vec<f64> = text
        .lines()
        .map(|line| line.split('#').next().unwrap_or_default())
        .flat_map(|line| {
            line.split(|c: char| {
                c.is_whitespace() || matches!(c, ',' | ';' | '[' | ']' | '{' | '}')
            })
        })
        .filter_map(|word| word.parse().ok())
        .collect();
    let count = found.len();
    found
        .try_into()
        .map_err(|_| bad(form, format!("holds {count} numbers, {N} are needed")))
}

fn rows(n: &[f64]) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| n.get(3 * i + j).copied().unwrap_or_default()))
}

type Coefficients = ([[f64; 3]; 3], [f64; 3]);

fn imucal(text: &str, form: CoefficientForm) -> Result<Coefficients> {
    #[derive(serde::Deserialize)]
    #[allow(non_snake_case)]
    struct Ferraris {
        K_a: [[f64; 3]; 3],
        R_a: [[f64; 3]; 3],
        b_a: [f64; 3],
        acc_unit: Option<String>,
    }
    let file: Ferraris = serde_json::from_str(text).map_err(|e| {
        bad(form, format!("is not such JSON: {e}"))
            .line(e.line() as u64)
            .because(e)
    })?;
    let unit = file
        .acc_unit
        .as_deref()
        .map_or(Some(Unit::MetrePerSecondSquared), Unit::recognise);
    let Some((Unit::MetrePerSecondSquared, factor)) = unit.map(Unit::si) else {
        return Err(bad(
            form,
            format!(
                "gives accelerations in {:?}",
                file.acc_unit.unwrap_or_default()
            ),
        ));
    };
    // output = K_a R_a a' + b_a with a' in `acc_unit`.
    let k = Matrix3(file.K_a).product(&Matrix3(file.R_a));
    Ok((k.0.map(|row| row.map(|v| v / factor)), file.b_a))
}

/// The three rows below `accelerometers:` and `M:`; a gyroscope's matrix of the same name comes after its own heading.
fn kalibr(text: &str, form: CoefficientForm) -> Result<[[f64; 3]; 3]> {
    let mut found: Vec<f64> = Vec::new();
    let (mut inside, mut matrix) = (false, false);
    for line in text.lines() {
        let line = line.split('#').next().unwrap_or_default().trim();
        if let Some(key) = line.strip_suffix(':') {
            match key {
                "accelerometers" => inside = true,
                "gyroscopes" => inside = false,
                _ => {}
            }
            matrix = inside && key == "M";
        } else if let (true, Some(row)) = (matrix, line.strip_prefix('-')) {
            let row = row.trim().trim_start_matches('[').trim_end_matches(']');
            for word in row.split(',') {
                let number = word.trim().parse();
                found.push(number.map_err(|e| {
                    bad(form, format!("{:?} in M is no number", word.trim())).because(e)
                })?);
            }
        } else if !line.is_empty() {
            matrix = false;
        }
    }
    if found.len() == 9 {
        Ok(rows(&found))
    } else {
        Err(bad(
            form,
            format!(
                "holds {} numbers in M of the accelerometers, 9 are needed",
                found.len()
            ),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let a = file
            .compensation()
            .unwrap()
            .apply([110.0 * mg, 0.0, 0.0], 0.0);
        assert!((a[0] - 1.0).abs() < 1e-12);
    }

    /// What `export --imu-yaml` writes is read back, gyroscopes beside it or not.
    #[test]
    fn law_exported_intrinsics_come_back() {
        let mut file = import("0 0 0 1.02 0.98 1.01", CoefficientForm::SixParameters).unwrap();
        file.k = K;
        let text = crate::export(
            &file,
            crate::ExportForm::ImuYaml,
            &crate::ExportOptions::default(),
        );
        let gyroscopes = "  gyroscopes:\n    M:\n    - [9.0, 9.0, 9.0]\n    - [9.0, 9.0, 9.0]\n    - [9.0, 9.0, 9.0]\n";
        let both = text.unwrap() + gyroscopes;
        assert_eq!(import(&both, CoefficientForm::Kalibr).unwrap().k, K);
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
}
