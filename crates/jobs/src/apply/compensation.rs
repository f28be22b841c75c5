//! Samples in, accelerations out: the one compensation behind every kind of calibration.

use crate::frequency_response;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_documents::AnyCalibration;
use proofmass_dynamic::frequency_response::{
    BandMatrix, CompensationError, CompensationFilter, FilterDesign, FilterStream,
};
use proofmass_signal::AnyCompensation;
use serde::{Deserialize, Serialize};

/// How a calibration is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum CompensationMethod {
    /// a = K⁻¹(õ − b) of a calibration by one matrix, with temperature and curvature where it has them.
    #[default]
    Model,
    /// The constant real matrix of a band of a calibration over frequency, from the first to the second frequency in Hz.
    Band([f64; 2]),
    /// A filter that undoes a calibration over frequency.
    Filter(FilterDesign),
}

/// A calibration at work on samples in order.
///
/// ```
/// use proofmass_dynamic::FrequencyResponse;
/// use proofmass_dynamic::reference_table::{ReferencePoint, ReferenceTable};
/// use proofmass_io::Unit;
/// use proofmass_jobs::apply::{CompensationStream, CompensationMethod};
/// use proofmass_jobs::{Record, Unwatched, frequency_response};
///
/// let line = |frequency: f64| ReferencePoint {
///     frequency, sensitivity: 0.01, phase: 0.0, modulus_uncertainty: 0.005, phase_uncertainty: 0.005,
/// };
/// let table = ReferenceTable::new(vec![line(10.0), line(1000.0)])?;
/// let response = FrequencyResponse::try_from(&table)?;
/// let file = frequency_response::to_file(&response, "certificate", Unit::Volt, &Record::default());
/// let method = CompensationMethod::Band([20.0, 500.0]);
/// let mut compensation = CompensationStream::new(&file.into(), method, None, &Unwatched)?;
/// let a = compensation.push(&[&[0.1, 0.2]]);
/// assert!((a[0][1] - 20.0).abs() < 1e-9);
/// let error = compensation.error().unwrap();
/// assert!((0.5..2.0).contains(&(100.0 * error.stated)), "{} %", 100.0 * error.stated);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct CompensationStream {
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    Model(Box<AnyCompensation>),
    Band(BandMatrix),
    Filter(Box<CompensationFilter>, FilterStream),
}

impl CompensationStream {
    /// A calibration used in this way, for samples at this rate in Hz (which only a filter needs).
    ///
    /// # Errors
    /// A way that the calibration does not have, a band or a rate beyond it, a missing rate, cancellation.
    pub fn new(
        calibration: &AnyCalibration,
        method: CompensationMethod,
        rate: Option<f64>,
        watch: &dyn Watch,
    ) -> Result<Self> {
        let kind = match (calibration, method) {
            (AnyCalibration::Constant(file), CompensationMethod::Model) => {
                Kind::Model(Box::new(file.compensation()?))
            }
            (AnyCalibration::FrequencyResponse(file), CompensationMethod::Band(band)) => {
                Kind::Band(frequency_response::of_file(file)?.band_matrix(band)?)
            }
            (AnyCalibration::FrequencyResponse(file), CompensationMethod::Filter(design)) => {
                let rate = rate.ok_or_else(|| {
                    Trouble::request("a filter needs the sampling rate, which nothing states")
                        .with_hint("add --rate or --time")
                })?;
                let response = frequency_response::of_file(file)?;
                let filter = response.compensation_filter(rate, &design, watch)?;
                let stream = filter.stream();
                Kind::Filter(Box::new(filter), stream)
            }
            (AnyCalibration::FrequencyResponse(file), CompensationMethod::Model) => {
                let points = file.series.points();
                let [low, high] = [points[0].at, points[points.len() - 1].at];
                return Err(Trouble::request(
                    "the calibration is one over frequency: no single matrix compensates it",
                )
                .detail(format!("it covers {low} Hz to {high} Hz"))
                .with_hint(
                    "add --band LOW,HIGH for the constant matrix of a band, or --filter for all of it",
                ));
            }
            _ => {
                return Err(Trouble::request(
                    "the calibration is one matrix for all frequencies: it has no bands",
                )
                .with_hint("remove --band and --filter"));
            }
        };
        Ok(Self { kind })
    }

    /// Takes samples of every output and gives the accelerations they complete, in order. A filter gives its first for
    /// the sample of index [`half`](Self::half).
    ///
    /// **Shapes** one slice per output, of one length.
    ///
    /// A model that follows the temperature is taken at its reference; [`push_at`](Self::push_at) takes temperatures.
    pub fn push(&mut self, outputs: &[&[f64]]) -> Vec<Vec<f64>> {
        match &mut self.kind {
            Kind::Model(model) => model.apply_columns(outputs, None),
            Kind::Band(matrix) => matrix.apply_columns(outputs),
            Kind::Filter(_, stream) => stream.push(outputs),
        }
    }

    /// The same with the temperature of every sample in °C, which matters to a model that follows it.
    pub fn push_at(&mut self, outputs: &[&[f64]], temperature: &[f64]) -> Vec<Vec<f64>> {
        match &mut self.kind {
            Kind::Model(model) => model.apply_columns(outputs, Some(temperature)),
            _ => self.push(outputs),
        }
    }

    /// What was still to come when no more samples follow; ready for another stretch.
    pub fn finish(&mut self) -> Vec<Vec<f64>> {
        match &mut self.kind {
            Kind::Filter(_, stream) => stream.finish(),
            _ => Vec::new(),
        }
    }

    /// Samples at the beginning and at the end of a stretch that have no result.
    pub fn half(&self) -> usize {
        self.filter().map_or(0, |f| f.half)
    }

    /// The filter, where it is one.
    pub fn filter(&self) -> Option<&CompensationFilter> {
        match &self.kind {
            Kind::Filter(filter, _) => Some(filter),
            _ => None,
        }
    }

    /// The constant matrix of a band, where it is one.
    pub fn band(&self) -> Option<&BandMatrix> {
        match &self.kind {
            Kind::Band(matrix) => Some(matrix),
            _ => None,
        }
    }

    /// What the compensation states about itself; `None` where the calibration says it (its covariance).
    pub fn error(&self) -> Option<CompensationError> {
        match &self.kind {
            Kind::Model(_) => None,
            Kind::Band(matrix) => Some(matrix.error),
            Kind::Filter(filter, _) => Some(filter.error),
        }
    }
}
