//! Calibration coefficients in the forms of other programs.
//!
//! None of these forms says which unit the outputs are in, and none has an uncertainty: the caller states the unit, and
//! the calibration that comes of it has an estimate without quantities.

use crate::CalibrationFile;
use proofmass_core::Matrix3;
use proofmass_io::{Error, ErrorKind, Input, LARGEST_DOCUMENT, Result, Source, Unit};
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
/// use proofmass_documents::{CoefficientForm, import_coefficients};
/// use proofmass_io::{Source, Unit};
///
/// let text = "12.5 -3.0 40.0\n0.01 0 0\n0 0.01 0\n0 0 0.0102\n";
/// let source = Source::from_bytes("magneto.txt", text)?;
/// let file = import_coefficients(source, CoefficientForm::Magneto, Unit::Count, Unit::StandardGravity)?;
/// let a = file.sensor()?.apply([12.5, -3.0, 140.0]);
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
    #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
