//! Quantities of the surroundings beside the temperature, as they are asked for.

use super::TemperatureData;
use crate::data_sheet::unit::is_unit;
use crate::trouble::{Result, Trouble};
use proofmass_io::{ColumnRef, RecordedColumn, Unit};
use proofmass_static::{EnvironmentalQuantity, TemperatureFit};
use std::str::FromStr;

/// A quantity of the surroundings at every sample: humidity, pressure, supply voltage.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct EnvironmentalColumn {
    /// Its name in those of the coefficients.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Its value at every sample.
    pub values: Vec<f64>,
    /// Value at which its coefficients change nothing; the middle of its range without it.
    pub reference: Option<f64>,
}

impl EnvironmentalColumn {
    /// A quantity by its name and unit.
    pub fn new(name: impl Into<String>, unit: impl Into<String>, values: Vec<f64>) -> Self {
        Self {
            name: name.into(),
            unit: unit.into(),
            values,
            reference: None,
        }
    }
}

/// Which column is a quantity of the surroundings: `humidity`, `humidity:%`, `humidity:%=50`, `7:V=3.3`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct EnvironmentalRequest {
    /// The column.
    pub column: ColumnRef,
    /// Its unit, where the heading does not say it.
    pub unit: Option<String>,
    /// Value at which the coefficients change nothing.
    pub reference: Option<f64>,
}

impl FromStr for EnvironmentalRequest {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (rest, reference) = match text.rsplit_once('=') {
            None => (text, None),
            Some((rest, number)) => {
                let value = number.trim().parse::<f64>().ok().filter(|v| v.is_finite());
                let value = value.ok_or_else(|| {
                    format!("{number:?} is no number: write COLUMN:UNIT=REFERENCE, such as humidity:%=50")
                })?;
                (rest, Some(value))
            }
        };
        let (column, unit) = match rest.rsplit_once(':') {
            None => (rest, None),
            Some((column, unit)) if is_unit(unit.trim()) => (column, Some(unit.trim().to_owned())),
            Some((_, unit)) => {
                return Err(format!(
                    "{unit:?} is no unit: write COLUMN:UNIT, such as pressure:hPa"
                ));
            }
        };
        if column.trim().is_empty() {
            return Err("the column has no name: write COLUMN:UNIT=REFERENCE".to_owned());
        }
        Ok(Self {
            column: ColumnRef::from(column.trim()),
            unit,
            reference,
        })
    }
}

impl EnvironmentalRequest {
    /// The quantity that a heading names, and its unit: that which was read, or one that no recording has signals in, such as the ends
    /// of humidity_% and pressure_hPa.
    pub(crate) fn heading(name: &str, unit: Option<Unit>) -> (String, Option<String>) {
        let (name, unit) = match unit {
            Some(unit) => (name, Some(unit.to_string())),
            None => in_heading(name),
        };
        // The names of coefficients are told apart by points.
        (name.replace(['.', ' '], "_"), unit)
    }

    /// The quantity of a column that was read for it: its unit is what was stated, or what the heading says.
    ///
    /// # Errors
    /// Neither says it, or both and differently.
    pub(super) fn of(&self, column: &RecordedColumn) -> Result<EnvironmentalColumn> {
        let (name, heading) = Self::heading(&column.name, column.unit);
        if let (Some(said), Some(heading)) = (&self.unit, &heading)
            && crate::data_sheet::unit_ratio(said, heading) != Some(1.0)
        {
            return Err(Trouble::data(format!(
                "the heading of {name} says {heading}, {said} is stated"
            ))
            .with_hint("leave the unit out of --environment, or correct the heading"));
        }
        let unit = self.unit.clone().or(heading).ok_or_else(|| {
            Trouble::data(format!("the unit of {name} is not said")).with_hint(format!(
                "add it: --environment {name}:UNIT, such as %, hPa or V; 1 for a pure number"
            ))
        })?;
        Ok(EnvironmentalColumn {
            name,
            unit,
            values: column.data.clone(),
            reference: self.reference,
        })
    }
}

/// A heading without the unit at its end, and the unit.
fn in_heading(heading: &str) -> (&str, Option<String>) {
    let ends = [('(', ')'), ('[', ']')];
    let bracket = ends.into_iter().find_map(|(open, close)| {
        let (name, unit) = heading.strip_suffix(close)?.rsplit_once(open)?;
        Some((name, unit))
    });
    match bracket.or_else(|| heading.rsplit_once(['_', ' '])) {
        // One letter alone may be anything.
        Some((name, unit))
            if !name.trim().is_empty() && (unit.len() > 1 || unit == "%") && is_unit(unit) =>
        {
            (name.trim_end_matches(['_', ' ']), Some(unit.to_owned()))
        }
        _ => (heading, None),
    }
}

/// The quantities for the fit.
///
/// # Errors
/// One that is there twice, is none, or bears a name of the temperature.
pub(super) fn distinct<'a>(data: &TemperatureData<'a>) -> Result<Vec<EnvironmentalQuantity<'a>>> {
    for (k, column) in data.environment.iter().enumerate() {
        let name = &column.name;
        if matches!(name.as_str(), "T1" | "T2" | "T3") || name.is_empty() || name.contains('.') {
            return Err(Trouble::request(format!(
                "{name:?} is no name of a quantity of the surroundings"
            ))
            .detail(data.name)
            .with_hint(
                "give the column another heading: T1, T2 and T3 are powers of the temperature",
            ));
        }
        if data.environment[..k].iter().any(|c| c.name == *name) {
            return Err(Trouble::request(format!("{name} is named twice"))
                .detail(data.name)
                .with_hint("name each quantity of the surroundings once"));
        }
    }
    let quantity = |c: &'a EnvironmentalColumn| EnvironmentalQuantity {
        name: &c.name,
        unit: &c.unit,
        values: &c.values,
        reference: c.reference,
    };
    Ok(data.environment.iter().map(quantity).collect())
}

/// Refuses quantities that the recording does not tell from the temperature or from each other.
pub(super) fn told(fit: &TemperatureFit, data: &TemperatureData<'_>) -> Result<()> {
    let not: Vec<_> = fit.environment.iter().filter(|e| !e.determined).collect();
    let Some(first) = not.first() else {
        return Ok(());
    };
    let width = first.range[1] - first.range[0];
    let far = (first.reference - first.reference.clamp(first.range[0], first.range[1])).abs();
    if width > 0.0 && far > 2.0 * width {
        return Err(Trouble::request(format!(
            "the reference of {} lies far from its values",
            first.name
        ))
        .detail(data.name)
        .detail(format!(
            "{} {}, recorded from {} to {} {}",
            proofmass_report::scientific(first.reference, 4),
            first.unit,
            proofmass_report::scientific(first.range[0], 4),
            proofmass_report::scientific(first.range[1], 4),
            first.unit
        ))
        .with_hint(
            "state a reference within them, =REFERENCE behind the column, or none for their middle",
        ));
    }
    let names: Vec<&str> = not.iter().map(|e| e.name.as_str()).collect();
    let mut trouble = Trouble::data(match first.range[0] < first.range[1] {
        true => format!(
            "the recording does not tell {} from the temperature",
            names.join(" and ")
        ),
        false => format!("{} does not change in the recording", first.name),
    })
    .detail(data.name);
    for e in &not {
        trouble = trouble.detail(format!(
            "{}: {} to {} {}, of its course {:.1} % is not that of temperature, attitudes and the others",
            e.name,
            proofmass_report::scientific(e.range[0], 4),
            proofmass_report::scientific(e.range[1], 4),
            e.unit,
            100.0 * e.own_part
        ));
    }
    Err(trouble.with_hint(
        "change one while the others stay: a sweep of the temperature at each of two humidities, or of the supply at one temperature; or leave it out, and the coefficients of the temperature are those of both together",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_requests_are_read() {
        let read = |text: &str| text.parse::<EnvironmentalRequest>();
        let full = read("humidity:%=50").unwrap();
        assert_eq!(
            (full.unit.as_deref(), full.reference),
            (Some("%"), Some(50.0))
        );
        assert_eq!(read("7:V").unwrap().column, ColumnRef::Index(7));
        for (text, word) in [
            ("humidity=damp", "no number"),
            ("p:furlongs/x", "no unit"),
            (":V", "no name"),
        ] {
            assert!(read(text).unwrap_err().contains(word), "{text}");
        }
    }

    #[test]
    fn known_units_of_headings() {
        assert_eq!(in_heading("humidity_%"), ("humidity", Some("%".to_owned())));
        assert_eq!(in_heading("p [hPa]"), ("p", Some("hPa".to_owned())));
        assert_eq!(in_heading("rel_hum"), ("rel_hum", None));
        assert_eq!(in_heading("load_m"), ("load_m", None));
    }
}
