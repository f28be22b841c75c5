//! A column of temperatures: how its numbers become degrees Celsius.

use crate::{ColumnRef, Error, ErrorKind, Layout, Result, SaidBy, Unit};

/// How the numbers of a column become °C: factor × (number − zero).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Thermometer {
    /// Unit of the numbers.
    pub unit: Unit,
    /// Number at 0 °C.
    pub zero: f64,
    /// Size of one of its degrees, K.
    pub factor: f64,
    /// Who says the unit.
    pub said_by: SaidBy,
}

impl Thermometer {
    /// The column of temperatures, where one is asked for, and how its numbers are read.
    ///
    /// # Errors
    /// A column that is not there; as [`Thermometer::of`].
    pub fn asked(layout: &Layout, column: Option<&ColumnRef>) -> Result<Option<(usize, Self)>> {
        let Some(column) = column else {
            return Ok(None);
        };
        let index = layout.find(column)?;
        Ok(Some((index, Self::of(layout, index)?)))
    }

    /// By the heading; without a unit there it is °C, which the reading tells.
    ///
    /// # Errors
    /// A unit of something else; numbers without a unit that are rather kelvins.
    pub fn of(layout: &Layout, index: usize) -> Result<Self> {
        let name = layout.name(index);
        let plain = name.to_lowercase().replace(['_', ' ', '.'], "");
        // In the heading of a thermometer a last C, F or K is no channel: `T_K`.
        let last = name.rsplit(['_', ' ']).next().filter(|last| *last != name);
        let degrees = [Unit::DegreeCelsius, Unit::DegreeFahrenheit, Unit::Kelvin];
        let last = last
            .and_then(Unit::recognise)
            .filter(|u| degrees.contains(u));
        let (unit, said_by) = match layout.unit(index).or(last) {
            Some(unit) => (unit, SaidBy::Heading),
            None if plain.contains("fahrenheit") => (Unit::DegreeFahrenheit, SaidBy::Heading),
            None => (Unit::DegreeCelsius, SaidBy::Nobody),
        };
        let refuse = |what: String, hint: &str| {
            Err(Error::new(ErrorKind::Column, what)
                .column(name.clone())
                .with_hint(hint))
        };
        // A laboratory in °F or in kelvins.
        let size = layout.norm(&[index]);
        if said_by == SaidBy::Nobody && (45.0..400.0).contains(&size) {
            let likely = if size < 230.0 { "°F or °C" } else { "K" };
            return refuse(
                format!("the unit of the temperatures is not said; they are about {size:.0}"),
                &format!(
                    "likely it is {likely}: write the unit into the heading, as in T_degF, T_degC or T_K"
                ),
            );
        }
        let (zero, factor) = match unit {
            Unit::DegreeCelsius => (0.0, 1.0),
            Unit::Kelvin => (273.15, 1.0),
            Unit::DegreeFahrenheit => (32.0, 5.0 / 9.0),
            other => {
                return refuse(
                    format!("is in {other}, which is no temperature"),
                    "name the column of the thermometer; °C, °F and K are understood",
                );
            }
        };
        Ok(Self {
            unit,
            zero,
            factor,
            said_by,
        })
    }

    /// A number of the column in °C.
    pub fn celsius(&self, number: f64) -> f64 {
        self.factor * (number - self.zero)
    }
}
