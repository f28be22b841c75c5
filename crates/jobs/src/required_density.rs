//! The table of a required density: CSV, TOML, or a published profile by its word.

mod judged;

pub use judged::JudgedDensity;

use crate::trouble::{Result, Trouble};
use proofmass_core::STANDARD_GRAVITY;
use proofmass_dynamic::required_density::{RequiredDensity, RequiredPoint};
use proofmass_io::sheet::{ACCELERATION_DENSITY, DECIBEL, FREQUENCY, SLOPE, Sheet};
use proofmass_io::{Input, LARGEST_DOCUMENT, Source};
use serde::Deserialize;
use std::path::Path;

/// A point as it was typed: a density, or the slope of the line that leads to it, or both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct TypedPoint {
    #[serde(rename = "frequency_Hz")]
    frequency: f64,
    #[serde(default)]
    density: Option<f64>,
    /// dB to the octave, from the point before.
    #[serde(default, rename = "slope_dB_per_octave")]
    slope: Option<f64>,
    /// From here on.
    #[serde(default, rename = "tolerance_dB")]
    tolerance: Option<[f64; 2]>,
}

/// The file in TOML.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TypedProfile {
    #[serde(default)]
    name: Option<String>,
    unit: String,
    #[serde(default, rename = "tolerance_dB")]
    tolerance: Option<[f64; 2]>,
    point: Vec<TypedPoint>,
}

/// A required density by the word of a published profile, or from a file; a file has its digest.
///
/// A table has columns `frequency_Hz`, `density_g2/Hz` (or `density_(m/s2)2/Hz`), and may have `slope_dB/oct` of the line that leads
/// to a point, in place of a density, and `lower_dB`, `upper_dB`, the tolerance from there on. TOML has `unit` and a `[[point]]` for
/// each.
///
/// # Errors
/// A word that is no profile and no file; what a file says wrong, with its line; densities and slopes that contradict each other.
pub fn required_density(word: &str) -> Result<(RequiredDensity, Option<Input>)> {
    let path = Path::new(word);
    if let Some(profile) = RequiredDensity::named(&word.to_ascii_lowercase()) {
        return Ok((profile, None));
    }
    if path.extension().is_none() && !path.exists() {
        let names: Vec<&str> = RequiredDensity::names().collect();
        return Err(Trouble::request(format!(
            "there is no published profile {word:?}, and no such file"
        ))
        .with_hint(format!(
            "the profiles are {}; or name a table",
            names.join(", ")
        )));
    }
    let source = Source::open(path)?;
    let toml = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    let (profile, input) = match toml {
        true => of_toml(source)?,
        false => of_table(source)?,
    };
    Ok((profile, Some(input)))
}

fn title(source: &Source) -> String {
    let stem = source.name().file_stem();
    stem.map_or_else(String::new, |s| s.to_string_lossy().into_owned())
}

fn of_toml(source: Source) -> Result<(RequiredDensity, Input)> {
    let (name, place) = (title(&source), source.name().display().to_string());
    let (bytes, input) = source.into_bytes(LARGEST_DOCUMENT)?;
    let within = |t: Trouble| t.detail(place.clone());
    let text = std::str::from_utf8(&bytes)
        .map_err(|_| within(Trouble::data("the file is not text in UTF-8")))?;
    let typed: TypedProfile = toml::from_str(text).map_err(|e| {
        within(Trouble::data(format!("not a required spectrum: {}", crate::campaign::plain_toml(e.message()))).with_hint(
            "write the unit (g2/Hz), tolerance_dB, and [[point]] with frequency_Hz and density or slope_dB_per_octave",
        ))
    })?;
    let factor = match typed.unit.replace('²', "2").replace('^', "").as_str() {
        "g2/Hz" => STANDARD_GRAVITY * STANDARD_GRAVITY,
        "(m/s2)2/Hz" | "m2/s3" => 1.0,
        other => {
            return Err(within(
                Trouble::data(format!(
                    "{other:?} is no unit of a density of an acceleration"
                ))
                .with_hint("write g2/Hz or (m/s2)2/Hz as the unit"),
            ));
        }
    };
    let points: Vec<TypedPoint> = typed
        .point
        .iter()
        .map(|p| TypedPoint {
            density: p.density.map(|d| d * factor),
            ..*p
        })
        .collect();
    let start = typed.tolerance.unwrap_or(RequiredDensity::TOLERANCE);
    let points = solved(&points, start).map_err(within)?;
    let name = typed.name.unwrap_or(name);
    Ok((RequiredDensity { name, points }, input))
}

fn of_table(source: Source) -> Result<(RequiredDensity, Input)> {
    let (name, place) = (title(&source), source.name().display().to_string());
    let mut sheet = Sheet::from_source(source, "required spectrum")?;
    let frequency = sheet.quantity("frequency", FREQUENCY)?;
    let density = sheet.quantity("density", ACCELERATION_DENSITY)?;
    let slope = sheet.quantity("slope", SLOPE)?;
    let lower = sheet.quantity("lower", DECIBEL)?;
    let upper = sheet.quantity("upper", DECIBEL)?;
    sheet.finish()?;
    let frequency = sheet.required(frequency, "frequency_Hz")?;
    let density = sheet.required(density, "density_g2/Hz")?;
    let mut points = Vec::new();
    for row in sheet.rows() {
        let tolerance = match (row.optional(lower)?, row.optional(upper)?) {
            (Some(low), Some(high)) => Some([low, high]),
            (None, None) => None,
            _ => {
                return Err(row
                    .refuse_row("of lower_dB and upper_dB one is missing")
                    .with_hint("give both, such as -3 and 3")
                    .into());
            }
        };
        points.push(TypedPoint {
            frequency: row.positive(frequency)?,
            density: row.optional(Some(density))?,
            slope: row.optional(slope)?,
            tolerance,
        });
    }
    let points =
        solved(&points, RequiredDensity::TOLERANCE).map_err(|t| t.detail(place.clone()))?;
    Ok((RequiredDensity { name, points }, sheet.input.clone()))
}

/// Fills in the densities that slopes say, from either side.
fn solved(typed: &[TypedPoint], tolerance: [f64; 2]) -> Result<Vec<RequiredPoint>> {
    /// Digits of a typed density against those of a slope, dB.
    const AGREE: f64 = 0.5;
    let number = |k: usize| format!("point {} at {} Hz", k + 1, typed[k].frequency);
    if typed.len() < 2 {
        return Err(Trouble::data("a required spectrum has at least two points")
            .with_hint("its lowest and its highest frequency"));
    }
    for (k, p) in typed.iter().enumerate() {
        if !(p.frequency > 0.0 && p.frequency.is_finite()) {
            return Err(Trouble::data(format!("{} is no frequency", p.frequency))
                .with_hint("frequencies are in Hz, above zero"));
        }
        if k > 0 && typed[k - 1].frequency >= p.frequency {
            return Err(Trouble::data("the frequencies do not ascend")
                .detail(number(k))
                .with_hint("one point for each frequency, in order"));
        }
        if p.density.is_some_and(|d| !(d > 0.0 && d.is_finite())) {
            return Err(Trouble::data("the density is not above zero")
                .detail(number(k))
                .with_hint("correct the number, or leave it empty where a slope says it"));
        }
        if p.slope.is_some_and(|s| !(s.abs() <= 1000.0)) {
            return Err(Trouble::data("the slope is no number of dB to the octave")
                .detail(number(k))
                .with_hint("correct the number, such as 3 or -6"));
        }
    }
    // The ratio that the slope of a line makes between its ends.
    let ratio = |k: usize| {
        let octaves = (typed[k].frequency / typed[k - 1].frequency).log2();
        typed[k].slope.map(|s| 10f64.powf(0.1 * s * octaves))
    };
    let mut density: Vec<Option<f64>> = typed.iter().map(|p| p.density).collect();
    for k in 1..typed.len() {
        if density[k].is_none() {
            density[k] = density[k - 1].zip(ratio(k)).map(|(d, r)| d * r);
        }
    }
    for k in (1..typed.len()).rev() {
        if density[k - 1].is_none() {
            density[k - 1] = density[k].zip(ratio(k)).map(|(d, r)| d / r);
        }
    }
    for k in 1..typed.len() {
        if let (Some(before), Some(here), Some(r)) = (density[k - 1], density[k], ratio(k)) {
            let off = 10.0 * (here / before / r).log10();
            if off.abs() > AGREE {
                return Err(Trouble::data(format!(
                    "density and slope contradict each other by {off:.2} dB"
                ))
                .detail(number(k))
                .with_hint(
                    "the slope is that of the line from the point before; leave one of the two out",
                ));
            }
        }
    }
    let mut now = tolerance;
    let mut points = Vec::new();
    for (k, p) in typed.iter().enumerate() {
        now = p.tolerance.unwrap_or(now);
        if !(now[0] < now[1] && now.iter().all(|d| d.is_finite())) {
            return Err(Trouble::data(format!(
                "a tolerance from {} to {} dB leaves no room",
                now[0], now[1]
            ))
            .detail(number(k))
            .with_hint("the lower limit first, such as -3 and 3"));
        }
        let Some(density) = density[k] else {
            return Err(Trouble::data(
                "neither a density nor slopes from a neighbour say what is required",
            )
            .detail(number(k))
            .with_hint("give a density, or the slope of the line that leads there"));
        };
        if !(density > 0.0 && density.is_finite()) {
            return Err(Trouble::data("the slope leads to no density")
                .detail(number(k))
                .with_hint("correct the slope, or give the density itself"));
        }
        points.push(RequiredPoint {
            frequency: p.frequency,
            density,
            tolerance: now,
        });
    }
    Ok(points)
}
