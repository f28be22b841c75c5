//! Sensitivity of an accelerometer over frequency: complex, with its covariance within and between the frequencies.
//!
//! # One convention
//! K(f) has one row per output and one column per axis of acceleration: õ(f) = K(f) a(f), the column convention of
//! [`SensorModel`](proofmass_core::SensorModel). Phasors turn as e^{+j2πft}: an output that comes late has a negative
//! phase. The row convention o = a S of the published calibrations on shakers is the transpose, K = Sᵀ;
//! [`FrequencyResponse::from_row_convention`] is the one place where the two meet.

mod band;
mod comparison;
mod compensation_error;
mod compensation_filter;
mod complex_matrix;
mod interpolation;
mod reference;

pub use band::BandMatrix;
pub use comparison::{ComparedPhase, ComparedPoint, ComparedWhole, ResponseComparison};
pub use compensation_error::CompensationError;
pub use compensation_filter::{Beyond, CompensationFilter, FilterDesign, FilterStream};
pub use interpolation::Interpolated;
pub use reference::{Apart, Equivalence, ReferenceComparison, ReferenceElement};

use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_core::check::positive;
use proofmass_uncertainty::{Component, Estimate, EstimateSeries, SeriesPoint, SharedEffect};
use serde::{Deserialize, Serialize};

/// Complex sensitivity K(f), outputs × axes, at ascending frequencies.
///
/// **Shapes** the estimate at every frequency has 2·outputs·axes components: real and imaginary part of every
/// element, row by row, named by [`FrequencyResponse::names`] (`K.xy.re`: output x, acceleration along y).
/// **Units** frequencies in Hz, elements in output unit per m/s² (`V/(m/s²)`).
///
/// ```
/// use num_complex::Complex64;
/// use proofmass_dynamic::FrequencyResponse;
/// use proofmass_dynamic::reference_table::{ReferencePoint, ReferenceTable};
///
/// // A certificate: two lines of frequency, modulus, phase and their standard uncertainties.
/// let line = |frequency: f64, sensitivity: f64, phase: f64| ReferencePoint {
///     frequency, sensitivity, phase, modulus_uncertainty: 0.005, phase_uncertainty: 0.005,
/// };
/// let table = ReferenceTable::new(vec![line(100.0, 0.0100, -0.01), line(200.0, 0.0102, -0.02)])?;
/// let response = FrequencyResponse::try_from(&table)?;
/// let k = response.at(150.0)?;
/// assert!((k.matrix[0].norm() - 0.0101).abs() < 1e-4);
/// assert!((k.matrix[0].arg() + 0.015).abs() < 1e-3);
/// assert!(response.at(250.0).is_err(), "a certificate says nothing beyond its points");
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[doc(alias(
    "transfer function",
    "FRF",
    "frequency response function",
    "complex sensitivity"
))]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Parts", into = "Parts")]
pub struct FrequencyResponse {
    outputs: Vec<String>,
    axes: Vec<String>,
    series: EstimateSeries,
}

#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Parts {
    outputs: Vec<String>,
    axes: Vec<String>,
    series: EstimateSeries,
}

impl From<FrequencyResponse> for Parts {
    fn from(response: FrequencyResponse) -> Self {
        Self {
            outputs: response.outputs,
            axes: response.axes,
            series: response.series,
        }
    }
}

impl TryFrom<Parts> for FrequencyResponse {
    type Error = Error;
    fn try_from(parts: Parts) -> Result<Self, Error> {
        Self::new(parts.outputs, parts.axes, parts.series)
    }
}

impl FrequencyResponse {
    /// Names of the components for these outputs and axes, in their order; `K.re`, `K.im` for one of each.
    pub fn names(outputs: &[String], axes: &[String]) -> Vec<String> {
        let element = |o: &String, a: &String| match (outputs.len(), axes.len()) {
            (1, 1) => "K".to_owned(),
            _ => format!("K.{o}{a}"),
        };
        outputs
            .iter()
            .flat_map(|o| axes.iter().map(move |a| element(o, a)))
            .flat_map(|name| [format!("{name}.re"), format!("{name}.im")])
            .collect()
    }

    /// From a series over frequency whose components are [`FrequencyResponse::names`].
    ///
    /// # Errors
    /// [`Error::Length`] for another number of components or for names in another order,
    /// [`Error::OutOfRange`] for a frequency that is not positive.
    pub fn new(
        outputs: Vec<String>,
        axes: Vec<String>,
        series: EstimateSeries,
    ) -> Result<Self, Error> {
        let names = Self::names(&outputs, &axes);
        let first = &series.points()[0];
        let alike = first.estimate.components().iter().zip(&names);
        let alike = alike.filter(|(c, name)| c.name == **name).count();
        if names.is_empty() || alike != names.len() || series.dimension() != names.len() {
            return Err(Error::Length {
                name: "components of a frequency response, by name and order",
                expected: names.len(),
                got: alike,
            });
        }
        if first.at <= 0.0 {
            return Err(Error::OutOfRange {
                name: "frequency",
                value: first.at,
                min: f64::MIN_POSITIVE,
                max: f64::MAX,
            });
        }
        Ok(Self {
            outputs,
            axes,
            series,
        })
    }

    /// From estimates of S in the row convention o = a S of a triaxial sensor: K = Sᵀ, element by element.
    ///
    /// **Shapes** every estimate has the 18 reals `S.xx.re`, `S.xx.im`, `S.xy.re` … row by row (row: axis of the
    /// acceleration, column: output); so have the effects in `shared`, one per frequency.
    ///
    /// # Errors
    /// As [`FrequencyResponse::new`] and [`EstimateSeries::new`].
    pub fn from_row_convention(
        points: &[(f64, &Estimate)],
        shared: Option<Vec<SharedEffect>>,
    ) -> Result<Self, Error> {
        let axes = ["x", "y", "z"].map(str::to_owned).to_vec();
        let names = Self::names(&axes, &axes);
        // Place in S of the p-th real of K.
        let transposed: Vec<usize> = (0..18)
            .map(|p| {
                let (output, axis, part) = (p / 6, p / 2 % 3, p % 2);
                2 * (3 * axis + output) + part
            })
            .collect();
        let mut jacobian = vec![0.0; 18 * 18];
        for (p, &s) in transposed.iter().enumerate() {
            jacobian[18 * p + s] = 1.0;
        }
        let points = points
            .iter()
            .map(|&(at, estimate)| {
                let of = estimate.components();
                if of.len() != 18 {
                    return Err(Error::Length {
                        name: "components of S",
                        expected: 18,
                        got: of.len(),
                    });
                }
                let components = transposed
                    .iter()
                    .zip(&names)
                    .map(|(&s, name)| Component::new(name.clone(), of[s].unit.clone(), of[s].value))
                    .collect();
                let estimate = estimate.propagate(components, &jacobian)?;
                Ok(SeriesPoint { at, estimate })
            })
            .collect::<Result<Vec<_>, Error>>()?;
        let turn = |e: Vec<f64>| match e.len() {
            18 => transposed.iter().map(|&s| e[s]).collect(),
            // Of another length: refused with its number by the series.
            _ => e,
        };
        let shared = shared.map(|shared| {
            let turned = |e: SharedEffect| SharedEffect {
                key: e.key,
                effects: e.effects.into_iter().map(turn).collect(),
            };
            shared.into_iter().map(turned).collect()
        });
        Self::new(axes.clone(), axes, EstimateSeries::new(points, shared)?)
    }

    /// From modulus and phase of one output and one axis: estimates with the components `modulus` and `phase`
    /// (rad).
    ///
    /// # Errors
    /// [`Error::Length`] for an estimate without these two, else as [`FrequencyResponse::new`].
    pub fn from_polar(
        axis: &str,
        points: &[(f64, &Estimate)],
        shared: Option<Vec<SharedEffect>>,
    ) -> Result<Self, Error> {
        let axis = vec![axis.to_owned()];
        let points = points
            .iter()
            .map(|&(at, estimate)| {
                let of = estimate.components();
                let (Some(m), Some(p)) = (
                    estimate.index_of("modulus"),
                    estimate.index_of("phase").filter(|_| of.len() == 2),
                ) else {
                    return Err(Error::Length {
                        name: "modulus and phase",
                        expected: 2,
                        got: of.len(),
                    });
                };
                let k = Complex64::from_polar(of[m].value, of[p].value);
                let turn = k / of[m].value;
                let components = vec![
                    Component::new("K.re", of[m].unit.clone(), k.re),
                    Component::new("K.im", of[m].unit.clone(), k.im),
                ];
                let mut jacobian = [0.0; 4];
                (jacobian[m], jacobian[p]) = (turn.re, -k.im);
                (jacobian[2 + m], jacobian[2 + p]) = (turn.im, k.re);
                let estimate = estimate.propagate(components, &jacobian)?;
                Ok(SeriesPoint { at, estimate })
            })
            .collect::<Result<Vec<_>, Error>>()?;
        Self::new(axis.clone(), axis, EstimateSeries::new(points, shared)?)
    }

    /// Names of the outputs: rows of K.
    pub fn outputs(&self) -> &[String] {
        &self.outputs
    }

    /// Names of the directions of acceleration: columns of K.
    pub fn axes(&self) -> &[String] {
        &self.axes
    }

    /// Estimates over frequency, with what the frequencies share.
    pub fn series(&self) -> &EstimateSeries {
        &self.series
    }

    /// Frequencies in Hz, ascending.
    pub fn frequencies(&self) -> impl ExactSizeIterator<Item = f64> {
        self.series.points().iter().map(|p| p.at)
    }

    /// Lowest and highest frequency, Hz.
    pub fn range(&self) -> [f64; 2] {
        let points = self.series.points();
        [points[0].at, points[points.len() - 1].at]
    }

    /// Index of the real part of an element among the components; its imaginary part follows.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for an element that is not there.
    pub fn real_part(&self, output: usize, axis: usize) -> Result<usize, Error> {
        let (outputs, axes) = (self.outputs.len(), self.axes.len());
        if output >= outputs || axis >= axes {
            return Err(Error::OutOfRange {
                name: "element of the frequency response",
                value: (output * axes + axis) as f64,
                min: 0.0,
                max: (outputs * axes) as f64 - 1.0,
            });
        }
        Ok(2 * (output * axes + axis))
    }

    /// Unit of the elements, such as `V/(m/s²)`.
    pub fn unit(&self) -> &str {
        &self.series.points()[0].estimate.components()[0].unit
    }

    /// The same response in another unit, one of the old being `factor` of the new.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a factor that is not positive.
    pub fn in_unit(&self, unit: &str, factor: f64) -> Result<Self, Error> {
        positive("factor between units", factor)?;
        let n = self.series.dimension();
        let jacobian: Vec<f64> = (0..n * n)
            .map(|at| if at % (n + 1) == 0 { factor } else { 0.0 })
            .collect();
        let points = self.series.points().iter().map(|point| {
            let components = point.estimate.components().iter();
            let components =
                components.map(|c| Component::new(c.name.clone(), unit, factor * c.value));
            Ok(SeriesPoint {
                at: point.at,
                estimate: point.estimate.propagate(components.collect(), &jacobian)?,
            })
        });
        let shared = self.series.shared().map(|effects| {
            let scaled = |effect: &SharedEffect| SharedEffect {
                key: effect.key.clone(),
                effects: effect
                    .effects
                    .iter()
                    .map(|row| row.iter().map(|e| factor * e).collect())
                    .collect(),
            };
            effects.iter().map(scaled).collect()
        });
        let series = EstimateSeries::new(points.collect::<Result<_, Error>>()?, shared)?;
        Self::new(self.outputs.clone(), self.axes.clone(), series)
    }

    /// K at the frequency of this index, row by row.
    ///
    /// `None` beyond the last frequency.
    pub fn matrix(&self, index: usize) -> Option<Vec<Complex64>> {
        let components = self.series.points().get(index)?.estimate.components();
        Some(
            components
                .chunks_exact(2)
                .map(|c| Complex64::new(c[0].value, c[1].value))
                .collect(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_uncertainty::{Covariance, Effect, Influence};

    fn with_covariance(components: Vec<Component>, u: &[f64]) -> Estimate {
        let influence = Influence::normal(
            "reading",
            "reading",
            Effect::Joint {
                covariance: Covariance::from_standard_uncertainties(u).unwrap(),
            },
        );
        Estimate::new(components, vec![influence]).unwrap()
    }

    #[test]
    fn law_rows_and_columns_change_places_with_their_uncertainty() {
        // S: acceleration along x shows in output y as 0.3 + 0.4j, u of its real part alone is 0.07.
        let mut values = [0.0; 18];
        (values[0], values[8], values[16]) = (10.0, 11.0, 12.0);
        (values[2], values[3]) = (0.3, 0.4);
        let mut u = [0.01; 18];
        u[2] = 0.07;
        let axes = ["x", "y", "z"].map(str::to_owned);
        let names = FrequencyResponse::names(&axes, &axes);
        let components = names
            .iter()
            .zip(values)
            .map(|(n, v)| Component::new(n.replace("K.", "S."), "mV/(m/s²)", v))
            .collect();
        let s = with_covariance(components, &u);
        let mut effect = vec![0.0; 18];
        effect[2] = 0.05;
        let shared = SharedEffect {
            key: "angle".into(),
            effects: vec![effect],
        };
        let response =
            FrequencyResponse::from_row_convention(&[(160.0, &s)], Some(vec![shared])).unwrap();
        let k = response.matrix(0).unwrap();
        // o = K a for a along x is the first column: outputs x and y.
        assert_eq!(k[0], Complex64::new(10.0, 0.0));
        assert_eq!(k[3], Complex64::new(0.3, 0.4));
        assert_eq!(k[1], Complex64::new(0.0, 0.0));
        let point = &response.series().points()[0].estimate;
        assert_eq!(point.get("K.yx.re").unwrap().standard_uncertainty, 0.07);
        let effects = &response.series().shared().unwrap()[0].effects[0];
        assert_eq!(effects[6], 0.05);
        let text = serde_json::to_string(&response).unwrap();
        assert_eq!(
            serde_json::from_str::<FrequencyResponse>(&text).unwrap(),
            response
        );
    }

    #[test]
    fn law_modulus_and_phase_become_parts_with_the_same_ellipse() {
        let components = vec![
            Component::new("modulus", "V/(m/s²)", 2.0),
            Component::new("phase", "rad", 0.5),
        ];
        let polar = with_covariance(components, &[0.01, 0.002]);
        let response = FrequencyResponse::from_polar("z", &[(80.0, &polar)], None).unwrap();
        let k = &response.series().points()[0].estimate;
        let (s, c) = 0.5f64.sin_cos();
        // Along the phasor 0.01, across it 2 × 0.002.
        let var_re = (0.01 * c).powi(2) + (0.004 * s).powi(2);
        let cov = (0.01f64.powi(2) - 0.004f64.powi(2)) * s * c;
        assert!((k.covariance()[(0, 0)] - var_re).abs() < 1e-18);
        assert!((k.covariance()[(0, 1)] - cov).abs() < 1e-18);
        assert!((k.components()[1].value - 2.0 * s).abs() < 1e-15);
    }

    #[test]
    fn refuses_components_of_another_order() {
        let components = vec![
            Component::new("K.im", "V/(m/s²)", 2.0),
            Component::new("K.re", "V/(m/s²)", 0.5),
        ];
        let estimate = with_covariance(components, &[0.01, 0.002]);
        let series = EstimateSeries::new(vec![SeriesPoint { at: 1.0, estimate }], None).unwrap();
        let one = vec!["z".to_owned()];
        assert!(matches!(
            FrequencyResponse::new(one.clone(), one, series),
            Err(Error::Length { got: 0, .. })
        ));
    }
}
