//! One limit of a data sheet, as it is written and as it is read.

use super::characteristic::{Characteristic, Known, Measurement, axis_of_channel, characteristics};
use super::unit;
use crate::noise_comparison::meaningful;
use crate::trouble::{Result, Trouble};
use proofmass_noise::{NoiseLimit, Term};
use proofmass_report::number::{minus, scientific};
use proofmass_uncertainty::Limits;
use serde::{Deserialize, Serialize};

/// How a limit is written.
pub(super) const HOW: &str = "write [[limit]] with term = \"N\", most = 30.0, unit = \"µg/√Hz\", and where wanted meaning and channels; \
                              for a quantity that is not noise write characteristic = \"bias\" instead of term";

/// A limit as it stands in a file: of a coefficient of the noise as `term`, of anything else as `characteristic`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct SheetLimit {
    /// Coefficient of the noise: `N`, `B`, `K`, `R` or `Q`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub term: Option<String>,
    /// Characteristic of the device, such as `bias`, `scale`, `misalignment`, `bias-temperature` or `resonance`; a coefficient of the noise too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub characteristic: Option<String>,
    /// Largest value; of what has a sign its largest magnitude.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub most: Option<f64>,
    /// Lower limit, with its sign.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lower: Option<f64>,
    /// Upper limit, with its sign.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub upper: Option<f64>,
    /// Nominal value, with a tolerance about it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nominal: Option<f64>,
    /// Tolerance about the nominal value, to either side.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// The same in per cent of the nominal value.
    #[serde(
        rename = "tolerance_%",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub tolerance_percent: Option<f64>,
    /// Value that a device typically has, by which measurements are planned; with its sign.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub typical: Option<f64>,
    /// Unit of the values; g is standard gravity.
    pub unit: String,
    /// Of noise, what the data sheet means: `one-sided` or `two-sided`, `floor` or `coefficient`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub meaning: Option<String>,
    /// Axes, pairs of axes or channels that it holds for, such as `x`, `xy` or `acc_x`; all without it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub channels: Vec<String>,
    /// Lowest and highest frequency that it holds for, Hz; all without it.
    #[serde(
        rename = "frequency_Hz",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub frequency: Option<[f64; 2]>,
    /// Lowest and highest temperature of the device that it holds for, °C; all without it.
    #[serde(
        rename = "temperature_degC",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub temperature: Option<[f64; 2]>,
}

/// A limit that was read: what it is of, and between which values.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ReadLimit {
    /// What it is of.
    pub characteristic: Characteristic,
    /// The values that it permits, in its unit.
    pub limits: Limits,
    /// Value that a device typically has, in its unit.
    pub typical: Option<f64>,
    /// Its unit.
    pub unit: String,
    /// Of noise, what is meant by it.
    pub meaning: Option<String>,
    /// Axes or channels; all when empty.
    pub channels: Vec<String>,
    /// Frequencies, Hz.
    pub frequency: Option<[f64; 2]>,
    /// Temperatures, °C.
    pub temperature: Option<[f64; 2]>,
}

impl SheetLimit {
    /// A largest value of something.
    pub fn most(characteristic: impl Into<String>, most: f64, unit: impl Into<String>) -> Self {
        Self {
            characteristic: Some(characteristic.into()),
            most: Some(most),
            unit: unit.into(),
            ..Self::default()
        }
    }

    /// A nominal value with a tolerance in per cent of it.
    pub fn about(
        characteristic: impl Into<String>,
        nominal: f64,
        percent: f64,
        unit: impl Into<String>,
    ) -> Self {
        Self {
            characteristic: Some(characteristic.into()),
            nominal: Some(nominal),
            tolerance_percent: Some(percent),
            unit: unit.into(),
            ..Self::default()
        }
    }

    /// The limit, held against what there is.
    ///
    /// # Errors
    /// An unknown characteristic or unit, no values, values that contradict each other.
    pub fn read(&self) -> Result<ReadLimit> {
        let characteristic = self.which()?;
        let name = characteristic.name();
        let limits = match characteristic {
            Characteristic::Noise(_) => self.of_noise(name)?,
            Characteristic::Of(known) => self.values(known)?,
        };
        for (key, range) in [
            ("frequency_Hz", self.frequency),
            ("temperature_degC", self.temperature),
        ] {
            if let Some([low, high]) = range
                && !(low <= high && low.is_finite() && high.is_finite())
            {
                return Err(Trouble::request(format!(
                    "{key} = [{low}, {high}] of the limit of {name} is no range"
                ))
                .with_hint("write the lower end first"));
            }
        }
        if let Some(typical) = self.typical
            && !(typical.is_finite() && limits.contains(typical))
        {
            return Err(Trouble::request(format!(
                "typical = {typical} of the limit of {name} does not lie within the limit"
            ))
            .with_hint("write the value that a device typically has, in the unit of the limit"));
        }
        let limit = ReadLimit {
            characteristic,
            limits,
            typical: self.typical,
            unit: self.unit.trim().to_owned(),
            meaning: self.meaning.clone(),
            channels: self.channels.clone(),
            frequency: self.frequency,
            temperature: self.temperature,
        };
        match limit.noise() {
            Some(noise) => meaningful(&noise)?,
            None => self.has_unit(characteristic)?,
        }
        Ok(limit)
    }

    fn which(&self) -> Result<Characteristic> {
        let (word, is_term) = match (&self.term, &self.characteristic) {
            (Some(term), None) => (term, true),
            (None, Some(word)) => (word, false),
            (Some(term), Some(word)) => {
                return Err(Trouble::request(format!(
                    "a limit is of the term {term:?} and of the characteristic {word:?} at once"
                ))
                .with_hint("write one of the two, and a [[limit]] for the other"));
            }
            (None, None) => {
                return Err(Trouble::request("a limit does not say what it is of").with_hint(HOW));
            }
        };
        if is_term {
            let term: Term = word.parse().map_err(|what: String| {
                Trouble::request(format!("the limits cannot be read: {what}")).with_hint(HOW)
            })?;
            return Ok(Characteristic::Noise(term));
        }
        Characteristic::named(word).map_err(|near| {
            let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
            let names: Vec<&str> = characteristics().iter().map(|k| k.name).collect();
            Trouble::request(format!("{word:?} is no characteristic that results state")).with_hint(
                format!("{near}it is N, B, K, R, Q or one of {}", names.join(", ")),
            )
        })
    }

    /// The limits of a coefficient: a largest value, whatever its sign.
    fn of_noise(&self, name: &str) -> Result<Limits> {
        let others = [
            self.lower,
            self.upper,
            self.nominal,
            self.tolerance,
            self.tolerance_percent,
        ];
        let Some(most) = self.most.filter(|_| others.iter().all(Option::is_none)) else {
            return Err(
                Trouble::request(format!("the limit of {name} is no largest value"))
                    .with_hint("a coefficient of the noise has most alone"),
            );
        };
        positive(most, "most", name)?;
        if self.frequency.is_some() {
            return Err(Trouble::request(format!(
                "the limit of {name} has frequency_Hz, and a coefficient of the noise has no frequency"
            ))
            .with_hint("leave frequency_Hz out"));
        }
        Ok(Limits::below(most)?)
    }

    fn values(&self, known: &Known) -> Result<Limits> {
        let name = known.name;
        if self.meaning.is_some() {
            return Err(Trouble::request(format!(
                "the limit of {name} has a meaning, which only noise has"
            ))
            .with_hint("leave meaning out"));
        }
        let finite = |value: Option<f64>, key: &str| match value {
            Some(v) if !v.is_finite() => Err(Trouble::request(format!(
                "{key} = {v} of the limit of {name} is no finite number"
            ))
            .with_hint("write a number")),
            _ => Ok(()),
        };
        for (value, key) in [
            (self.most, "most"),
            (self.lower, "lower"),
            (self.upper, "upper"),
            (self.nominal, "nominal"),
            (self.tolerance, "tolerance"),
            (self.tolerance_percent, "tolerance_%"),
        ] {
            finite(value, key)?;
        }
        let tolerance = (self.tolerance, self.tolerance_percent);
        let limits = match (self.most, self.lower, self.upper, self.nominal, tolerance) {
            (Some(most), None, None, None, (None, None)) => {
                positive(most, "most", name)?;
                match known.signed {
                    true => Limits::between(-most, most)?,
                    false => Limits::below(most)?,
                }
            }
            (None, lower, upper, None, (None, None)) if lower.is_some() || upper.is_some() => {
                match (lower, upper) {
                    (Some(l), Some(u)) if l >= u => {
                        return Err(Trouble::request(format!(
                            "the lower limit {l} of {name} is not below its upper limit {u}"
                        ))
                        .with_hint("write lower = the smaller, upper = the larger value"));
                    }
                    (Some(l), Some(u)) => Limits::between(l, u)?,
                    (Some(l), None) => Limits::above(l)?,
                    (_, Some(u)) => Limits::below(u)?,
                    (None, None) => return Err(self.no_values(name)),
                }
            }
            (None, None, None, Some(nominal), (Some(t), None)) => {
                positive(t, "tolerance", name)?;
                Limits::between(nominal - t, nominal + t)?
            }
            (None, None, None, Some(nominal), (None, Some(percent))) => {
                positive(percent, "tolerance_%", name)?;
                let t = 0.01 * percent * nominal.abs();
                positive(t, "\"tolerance_%\" times nominal", name)?;
                Limits::between(nominal - t, nominal + t)?
            }
            _ => return Err(self.no_values(name)),
        };
        Ok(limits)
    }

    fn no_values(&self, name: &str) -> Trouble {
        Trouble::request(format!(
            "the limit of {name} has no value, or more than one kind of value"
        ))
        .with_hint(
            "give exactly one of: most; lower and upper; nominal with tolerance or \"tolerance_%\"",
        )
    }

    fn has_unit(&self, characteristic: Characteristic) -> Result<()> {
        let Characteristic::Of(known) = characteristic else {
            return Ok(());
        };
        let fits = match known.unit {
            Some(example) => unit::ratio(&self.unit, example).is_some(),
            None => unit::is_unit(&self.unit),
        };
        if fits {
            return Ok(());
        }
        let example = match known.name {
            "bias" => "mg, µg, m/s² or the unit of the output",
            "scale" => "mV/g, LSB/g, 1 or %",
            "bias-temperature" => "mg/K or µg/°C",
            "bias-drift" => "mg/month or mg/year",
            "misalignment" | "non-orthogonality" => "%, mrad or °",
            "second-order" => "µg/g² or 1/(m/s²)",
            "third-order" => "µg/g³ or 1/(m/s²)²",
            "scale-temperature" => "%/K or ppm/°C",
            _ => known.unit.unwrap_or_default(),
        };
        Err(
            Trouble::request(format!("{:?} is no unit of {}", self.unit, known.name))
                .with_hint(format!("write {example}")),
        )
    }
}

/// A limit as somebody would write it: six digits at most, and none that says nothing.
fn as_written(value: f64) -> String {
    let size = value.abs();
    match size == 0.0 || (1e-3..1e6).contains(&size) {
        true => {
            let rounded = format!("{value:.5e}").parse().unwrap_or(value);
            minus(&f64::to_string(&rounded))
        }
        false => scientific(value, 4),
    }
}

fn positive(value: f64, key: &str, name: &str) -> Result<()> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(
        Trouble::request(format!("{key} = {value} of {name} is not positive"))
            .with_hint("write a number above zero"),
    )
}

impl ReadLimit {
    /// The same as a limit of noise.
    pub fn noise(&self) -> Option<NoiseLimit> {
        let Characteristic::Noise(term) = self.characteristic else {
            return None;
        };
        let mut limit = NoiseLimit::new(term, self.limits.upper?, self.unit.clone());
        limit.meaning = self.meaning.clone();
        limit.channels = self.channels.clone();
        Some(limit)
    }

    /// Whether it is of two axes: their angle, or what one shows of the other.
    pub(crate) fn is_between_axes(&self) -> bool {
        let name = self.characteristic.name();
        self.characteristic.shown_by(self.frequency.is_some()) == Measurement::Positions
            && !matches!(name, "bias" | "scale")
    }

    /// Whether it is for this axis or channel.
    pub(crate) fn is_for(&self, axis: &str) -> bool {
        self.channels.is_empty()
            || self
                .channels
                .iter()
                .any(|c| c == axis || axis_of_channel(axis).is_some_and(|a| a == c))
    }

    /// Whether a frequency is among those that it holds for.
    pub(crate) fn holds_at(&self, frequency: Option<f64>) -> bool {
        match (self.frequency, frequency) {
            (None, _) => true,
            (Some([low, high]), Some(f)) => (low..=high).contains(&f),
            (Some(_), None) => false,
        }
    }

    /// Whether both are of one thing: some axis, frequency and temperature belong to both.
    pub(super) fn is_of_the_same(&self, other: &Self) -> bool {
        let overlap = |a: Option<[f64; 2]>, b: Option<[f64; 2]>| match (a, b) {
            (Some([al, ah]), Some([bl, bh])) => al < bh && bl < ah || (al, ah) == (bl, bh),
            _ => true,
        };
        let shared = self.channels.is_empty()
            || other.channels.is_empty()
            || self.channels.iter().any(|c| other.channels.contains(c));
        self.characteristic == other.characteristic
            && self.meaning == other.meaning
            && (self.unit == other.unit || unit::ratio(&self.unit, &other.unit).is_some())
            && shared
            && overlap(self.frequency, other.frequency)
            && overlap(self.temperature, other.temperature)
    }

    /// The values that it permits, in words.
    pub fn words(&self) -> String {
        let number = as_written;
        let unit = match self.unit.as_str() {
            "1" => String::new(),
            unit => format!(" {unit}"),
        };
        match (self.limits.lower, self.limits.upper) {
            (Some(l), Some(u)) if l == -u => format!("± {}{unit}", number(u)),
            (Some(l), Some(u)) => format!("{} to {}{unit}", number(l), number(u)),
            (Some(l), None) => format!("at least {}{unit}", number(l)),
            (None, Some(u)) => format!("at most {}{unit}", number(u)),
            (None, None) => String::new(),
        }
    }

    /// Where it holds, in words; empty where everywhere.
    pub(crate) fn where_it_holds(&self) -> String {
        let mut all = Vec::new();
        if let Some([low, high]) = self.frequency {
            all.push(format!("{low} to {high} Hz"));
        }
        if let Some([low, high]) = self.temperature {
            all.push(format!("{low} to {high} °C"));
        }
        all.extend(self.meaning.clone());
        all.join(", ")
    }
}
