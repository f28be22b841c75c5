//! Grades of accelerometers, by limits that publications state.

use super::DeviceCheckJob;
use super::devices::{CheckedDevice, DeviceResult};
use super::judged::{Judge, SheetVerdict};
use crate::data_sheet::{Grade, SheetLimit, read_all};
use crate::trouble::Result;
use serde::Serialize;

/// Whether a device reaches a grade.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct GradeVerdict {
    /// Name of the grade.
    pub name: String,
    /// Its limits, all together.
    pub verdict: SheetVerdict,
    /// What speaks against it.
    pub why: String,
}

/// The grades that the program knows, the lowest first. No standard fixes them; these limits are those of two publications.
///
/// N is the two-sided root density of the simulated sensors of `[Groves2013]`, bias the accelerometer bias of Table 1 of
/// `[ElSheimy2020]`, the larger end of its range. Neither states limits of an industrial grade.
///
/// ```
/// let grades = proofmass_jobs::device_check::known_grades();
/// let tactical = grades.iter().find(|g| g.name == "tactical").unwrap();
/// assert_eq!(tactical.limit[0].most, Some(5.0));
/// ```
///
/// **Source** `[ElSheimy2020]`, `[Groves2013]`.
pub fn known_grades() -> Vec<Grade> {
    let noise = |most: f64| SheetLimit {
        meaning: Some("two-sided".to_owned()),
        ..SheetLimit::most("N", most, "µg/√Hz")
    };
    let bias = |most: f64| SheetLimit::most("bias", most, "mg");
    let grade = |name: &str, source: &str, limit: Vec<SheetLimit>| Grade {
        name: name.to_owned(),
        source: source.to_owned(),
        limit,
    };
    let both = "bias: El-Sheimy and Youssef 2020, Table 1; N: Groves 2013";
    vec![
        grade("consumer", "N: Groves 2013", vec![noise(1000.0)]),
        grade("industrial", "", Vec::new()),
        grade("tactical", both, vec![bias(5.0), noise(100.0)]),
        grade("navigation", both, vec![bias(0.1), noise(20.0)]),
    ]
}

/// The verdict on every grade.
///
/// # Errors
/// A result that contradicts itself.
pub(super) fn reached(
    grades: &[Grade],
    device: &CheckedDevice,
    results: &[DeviceResult],
    job: &DeviceCheckJob,
) -> Result<Vec<GradeVerdict>> {
    let mut all = Vec::with_capacity(grades.len());
    for grade in grades {
        let limits = read_all(&grade.limit, "limit")?;
        let rows = Judge::new(device, results, job).all(&limits)?;
        let against = rows.iter().filter(|r| r.verdict != SheetVerdict::Pass);
        let against = against.map(|row| {
            let name = limits[row.limit].characteristic.name();
            let axis = match row.axis.as_str() {
                "" => String::new(),
                axis => format!(" of {axis}"),
            };
            format!("{name}{axis}: {}", row.verdict.word())
        });
        let why = match limits.is_empty() {
            true => "no limits are published".to_owned(),
            false => against.collect::<Vec<_>>().join(", "),
        };
        all.push(GradeVerdict {
            name: grade.name.clone(),
            verdict: SheetVerdict::over(rows.iter().map(|r| r.verdict)),
            why,
        });
    }
    Ok(all)
}
