//! Quantities of the surroundings beside the temperature: humidity, pressure, supply voltage.

use serde::Serialize;

/// What was recorded beside the temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentalQuantity<'a> {
    /// Its name in the names of the coefficients.
    pub name: &'a str,
    /// Its unit, for those of the coefficients.
    pub unit: &'a str,
    /// Its value at every sample.
    pub values: &'a [f64],
    /// Value at which the coefficients change nothing; the middle of the range without it.
    pub reference: Option<f64>,
}

/// How a quantity of the surroundings went.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct EnvironmentalCourse {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Value at which its coefficients change nothing.
    pub reference: f64,
    /// Lowest and highest block mean.
    pub range: [f64; 2],
    /// Part of its course that temperature, attitudes, branches and the other quantities do not explain, 0 to 1.
    pub own_part: f64,
    /// Whether that part suffices to tell it from them; else it is left out of the model.
    pub determined: bool,
    /// What a deviation of one is divided by in the fit.
    #[serde(skip)]
    pub(super) half: f64,
}

impl EnvironmentalCourse {
    pub(super) fn of(quantity: &EnvironmentalQuantity<'_>, means: &[f64]) -> Self {
        let fold = |f: fn(f64, f64) -> f64, start| means.iter().copied().fold(start, f);
        let range = [
            fold(f64::min, f64::INFINITY),
            fold(f64::max, f64::NEG_INFINITY),
        ];
        let half = 0.5 * (range[1] - range[0]);
        Self {
            name: quantity.name.to_owned(),
            unit: quantity.unit.to_owned(),
            reference: quantity.reference.unwrap_or(0.5 * (range[0] + range[1])),
            range,
            own_part: 0.0,
            determined: true,
            half: if half > 0.0 { half } else { 1.0 },
        }
    }

    /// Deviations of the block means from the reference, of order one.
    pub(super) fn column(&self, means: &[f64]) -> Vec<f64> {
        let deviation = |v: &f64| (v - self.reference) / self.half;
        means.iter().map(deviation).collect()
    }
}
