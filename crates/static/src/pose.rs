//! A standstill as the fits see it: a mean output with its covariance, perhaps a known attitude.

use crate::Triple;
use proofmass_core::{Error, check};

/// Three equally long columns of output samples.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    columns: [&'a [f64]; 3],
    time: Option<&'a [f64]>,
    temperature: Option<&'a [f64]>,
}

impl<'a> Samples<'a> {
    /// From the three outputs x, y, z of one sensor.
    ///
    /// # Errors
    /// [`Error::Length`] for columns of different lengths; [`Error::NotFinite`] with the index of the sample.
    pub fn new(x: &'a [f64], y: &'a [f64], z: &'a [f64]) -> Result<Self, Error> {
        check::lengths(x.len(), [("y", y.len()), ("z", z.len())])?;
        for (name, column) in [("x", x), ("y", y), ("z", z)] {
            check::finite(name, column)?;
        }
        Ok(Self {
            columns: [x, y, z],
            time: None,
            temperature: None,
        })
    }

    /// With the time of every sample, s.
    ///
    /// # Errors
    /// [`Error::Length`]; [`Error::NotFinite`].
    pub fn at_times(mut self, time: &'a [f64]) -> Result<Self, Error> {
        self.check("time", time)?;
        self.time = Some(time);
        Ok(self)
    }

    /// With the temperature of every sample, °C.
    ///
    /// # Errors
    /// [`Error::Length`]; [`Error::NotFinite`].
    pub fn at_temperatures(mut self, temperature: &'a [f64]) -> Result<Self, Error> {
        self.check("temperature", temperature)?;
        self.temperature = Some(temperature);
        Ok(self)
    }

    fn check(&self, name: &'static str, column: &[f64]) -> Result<(), Error> {
        check::column(name, column, self.len())
    }

    /// Time of every sample, s, where it is known.
    pub fn time(&self) -> Option<&'a [f64]> {
        self.time
    }

    /// Temperature of every sample, °C, where it is known.
    pub fn temperature(&self) -> Option<&'a [f64]> {
        self.temperature
    }

    /// Number of samples of each column.
    pub fn len(&self) -> usize {
        self.columns[0].len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.columns[0].is_empty()
    }

    /// The columns in the order x, y, z.
    pub fn columns(&self) -> [&'a [f64]; 3] {
        self.columns
    }

    /// Mean temperature over a half-open range of samples, °C, where it is known.
    pub fn mean_temperature(&self, start: usize, end: usize) -> Option<f64> {
        let segment = &self.temperature?[start..end];
        Some(segment.iter().sum::<f64>() / segment.len().max(1) as f64)
    }

    /// Mean output over a half-open range of samples.
    pub fn mean(&self, start: usize, end: usize) -> Triple {
        // Against the first sample, so that counts on a large pedestal lose no digits.
        self.columns.map(|column| {
            let segment = &column[start..end];
            let pedestal = segment.first().copied().unwrap_or(0.0);
            pedestal
                + segment.iter().map(|v| v - pedestal).sum::<f64>() / segment.len().max(1) as f64
        })
    }
}

/// How well the specific force of one standstill is known: standard uncertainties in units of local gravity.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ForceUncertainty {
    /// Across it, in each of two directions: that of the attitude, rad at rest.
    pub across: f64,
    /// Along it; zero where the length is that of gravity, whose uncertainty is common to all.
    pub along: f64,
}

/// A half-open range of samples during which the sensor stood still.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Segment {
    /// First sample.
    pub start: usize,
    /// One past the last sample.
    pub end: usize,
    /// Direction of the specific force in the axes of the sensor, a unit vector, where it is known; the force itself in units of
    /// local gravity where its length counts ([`MultiPosition::true_accelerations`](crate::MultiPosition::true_accelerations)).
    pub attitude: Option<Triple>,
    /// How well it is known, where that is said of this standstill itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_uncertainty: Option<ForceUncertainty>,
    /// Name for messages and tables.
    pub label: Option<String>,
}

impl Segment {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.end - self.start
    }

    /// Whether the range holds no sample.
    pub fn is_empty(&self) -> bool {
        self.end == self.start
    }
}

/// One standstill reduced to what the fit needs.
#[doc(alias("orientation", "position", "static acceleration mean"))]
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Pose {
    /// Where it lies in the recording.
    pub segment: Segment,
    /// Mean output, output units.
    pub mean: Triple,
    /// Covariance of that mean from the noise of the samples, output units squared; `None` where it is not known.
    pub covariance: Option<[Triple; 3]>,
    /// Standard deviation of the samples about the mean per axis, output units; `None` for a single reading.
    pub deviation: Option<Triple>,
    /// Middle of the standstill, s from any origin, where it is known.
    pub time: Option<f64>,
    /// Mean temperature, °C, where it is known.
    pub temperature: Option<f64>,
}

impl Pose {
    /// A mean output of which nothing else is known.
    pub fn reading(segment: Segment, mean: Triple) -> Self {
        Self {
            segment,
            mean,
            covariance: None,
            deviation: None,
            time: None,
            temperature: None,
        }
    }

    /// What to call it: its label, or its number counted from one.
    pub fn name(&self, index: usize) -> String {
        self.segment
            .label
            .clone()
            .unwrap_or_else(|| format!("{}", index + 1))
    }
}
