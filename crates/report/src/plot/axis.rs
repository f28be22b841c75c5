//! An axis: what it measures, in which unit, on which scale, and over which range.

use super::svg::power_of_ten;
use super::ticks::{self, Ticks, widened};
use crate::Error;
use crate::number::quotient;
use serde::{Deserialize, Serialize};

/// Division of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// Equal steps.
    #[default]
    Linear,
    /// Equal ratios; every value must be positive.
    Log,
}

/// What an axis measures.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Axis {
    /// Name of the quantity.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) label: String,
    /// Its unit; empty or `1` for a pure number.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) unit: String,
    /// Linear or logarithmic.
    pub(crate) scale: Scale,
    /// Range shown; `None` for that of the data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) range: Option<(f64, f64)>,
    /// Positions with their labels, such as dates; those of the division where there are none.
    #[serde(default, skip_serializing_if = "<[_]>::is_empty")]
    pub(crate) marks: Box<[(f64, String)]>,
}

impl Axis {
    /// A linear axis over the range of the data.
    pub fn linear(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            unit: unit.into(),
            ..Self::default()
        }
    }

    /// A logarithmic axis over the range of the data.
    pub fn log(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            scale: Scale::Log,
            ..Self::linear(label, unit)
        }
    }

    /// Shows this range, whatever the data.
    #[must_use]
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }

    /// Labels these positions instead of round numbers.
    #[must_use]
    pub fn marked(mut self, marks: impl IntoIterator<Item = (f64, String)>) -> Self {
        self.marks = marks.into_iter().collect();
        self
    }

    /// The printed label: quantity / unit, with what the tick labels left out.
    pub(super) fn title(&self, ticks: &Ticks) -> String {
        let unit = if self.unit == "1" {
            ""
        } else {
            self.unit.as_str()
        };
        let mut quantity = self.label.clone();
        if let Some(offset) = &ticks.offset {
            quantity = match offset.strip_prefix('−') {
                Some(size) => format!("{quantity} + {size}"),
                None => format!("{quantity} − {offset}"),
            };
        }
        // A difference is divided as a whole.
        let divided = !unit.is_empty() || ticks.exponent != 0;
        if ticks.offset.is_some() || (divided && quantity.contains(" − ")) {
            quantity = format!("({quantity})");
        }
        let power = match (ticks.exponent, unit.is_empty()) {
            (0, _) => String::new(),
            (e, true) => power_of_ten(e),
            (e, false) => format!("{} ", power_of_ten(e)),
        };
        quotient(&quantity, &format!("{power}{unit}"))
    }

    /// The range shown for data between `low` and `high`, with a margin; (0, 1) or (1, 10) without data.
    pub(super) fn shown(&self, data: Option<(f64, f64)>, margin: f64) -> Result<(f64, f64), Error> {
        if let Some((low, high)) = self.range {
            let fits = low < high && low.abs() <= super::LARGEST && high.abs() <= super::LARGEST;
            if !fits || (self.scale == Scale::Log && low <= 0.0) {
                return Err(Error::EmptyRange {
                    name: self.label.clone(),
                    low,
                    high,
                });
            }
            return Ok((low, high));
        }
        Ok(match (self.scale, data) {
            (Scale::Linear, None) => (0.0, 1.0),
            (Scale::Log, None) => (1.0, 10.0),
            (Scale::Linear, Some((low, high))) => {
                let (low, high) = widened(low, high);
                let pad = margin * (high - low);
                (low - pad, high + pad)
            }
            (Scale::Log, Some((low, high))) => {
                let (a, b) = (low.log10(), high.log10());
                let pad = if b - a < 0.05 { 0.3 } else { margin * (b - a) };
                (10f64.powf(a - pad), 10f64.powf(b + pad))
            }
        })
    }

    pub(super) fn ticks(&self, (low, high): (f64, f64), most: usize) -> Ticks {
        if !self.marks.is_empty() {
            let inside = self
                .marks
                .iter()
                .filter(|(at, _)| (low..=high).contains(at));
            return Ticks::at(inside.cloned().collect());
        }
        match self.scale {
            Scale::Linear => ticks::linear(low, high, most),
            Scale::Log => ticks::logarithmic(low, high, most),
        }
    }
}

/// From data to pixels along one axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mapping {
    scale: Scale,
    low: f64,
    per_unit: f64,
    start: f64,
    end: f64,
}

impl Mapping {
    pub(super) fn new(scale: Scale, (low, high): (f64, f64), start: f64, end: f64) -> Self {
        let (low, high) = match scale {
            Scale::Linear => (low, high),
            Scale::Log => (low.log10(), high.log10()),
        };
        Self {
            scale,
            low,
            per_unit: (end - start) / (high - low),
            start,
            end,
        }
    }

    /// Pixel of a value, held within ten axis lengths so that a far-away end of a line stays drawable.
    pub(super) fn at(&self, value: f64) -> f64 {
        let v = match self.scale {
            Scale::Linear => value,
            // A bound at or below zero lies below every logarithmic axis.
            Scale::Log if value <= 0.0 => return self.start - 10.0 * (self.end - self.start),
            Scale::Log => value.log10(),
        };
        let far = 10.0 * (self.end - self.start).abs();
        (self.start + (v - self.low) * self.per_unit).clamp(
            self.start.min(self.end) - far,
            self.start.max(self.end) + far,
        )
    }

    /// Value at a pixel.
    pub(super) fn value(&self, pixel: f64) -> f64 {
        let v = self.low + (pixel - self.start) / self.per_unit;
        match self.scale {
            Scale::Linear => v,
            Scale::Log => 10f64.powf(v),
        }
    }

    pub(super) fn inside(&self, value: f64) -> bool {
        let p = self.at(value);
        p >= self.start.min(self.end) - 0.01 && p <= self.start.max(self.end) + 0.01
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_titles_are_quotients_of_quantity_and_unit() {
        let title = |unit: &str, high: f64| {
            let axis = Axis::linear("q", unit);
            axis.title(&axis.ticks((0.0, high), 5))
        };
        assert_eq!(title("", 1.0), "q");
        assert_eq!(title("1", 1e-6), "q / 10⁻⁶");
        assert_eq!(title("s", 1.0), "q / s");
        assert_eq!(title("m/s²", 1.0), "q / (m/s²)");
        assert_eq!(title("m/s²", 1e-6), "q / (10⁻⁶ m/s²)");
        assert_eq!(title("(m/s²)/√Hz", 1.0), "q / [(m/s²)/√Hz]");
        assert_eq!(title("count/(m/s²)", 1e6), "q / [10⁶ count/(m/s²)]");
    }
}
