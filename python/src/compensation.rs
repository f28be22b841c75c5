//! Compensation of arrays with a calibration.

use crate::buffer::Numbers;
use crate::stored_result::refused;
use proofmass::core;
use proofmass::documents::AnyCalibration;
use proofmass::io::Source;
use proofmass::jobs::Trouble;
use proofmass::signal::AnyCompensation;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;

/// K⁻¹ (output − b) of a triaxial accelerometer, with its terms over temperature and its curvature.
#[pyclass(frozen)]
pub(crate) struct Compensation {
    inner: core::Compensation<f64>,
    units: (String, String),
    temperatures: Option<(f64, f64)>,
    json: Vec<u8>,
}

impl Compensation {
    fn of(calibration: &AnyCalibration) -> PyResult<Self> {
        let AnyCalibration::Constant(file) = calibration else {
            return Err(refused(
                Trouble::request("a calibration over frequency has no single matrix")
                    .with_hint("compensate a recording with proofmass.apply(…, band=(low, high)) or filter=True"),
            ));
        };
        file.at_one_environment().map_err(refused)?;
        let AnyCompensation::ThreeAxes(inner) = file.compensation().map_err(refused)? else {
            return Err(refused(
                Trouble::request("a calibration of one axis compensates no rows of three")
                    .with_hint("compensate a recording with proofmass.apply"),
            ));
        };
        let temperatures = inner.thermal().map(|t| (t.range[0], t.range[1]));
        Ok(Self {
            inner,
            units: (file.input_unit.to_string(), file.output_unit.to_string()),
            temperatures,
            json: calibration.to_json().map_err(refused)?,
        })
    }
}

#[pymethods]
impl Compensation {
    #[staticmethod]
    fn open(path: PathBuf) -> PyResult<Self> {
        let read = Source::open(path).and_then(AnyCalibration::from_source);
        Self::of(&read.map_err(refused)?.0)
    }

    #[staticmethod]
    fn read(json: &[u8]) -> PyResult<Self> {
        Self::of(&AnyCalibration::from_json(json).map_err(refused)?)
    }

    fn json<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.json)
    }

    /// Units of what goes in and of what comes out.
    #[getter]
    fn units(&self) -> (String, String) {
        self.units.clone()
    }

    /// Range of temperatures in which it was measured, where it follows the temperature.
    #[getter]
    fn temperatures(&self) -> Option<(f64, f64)> {
        self.temperatures
    }

    /// Rows x, y, z of float64, and the temperature of each, or of all, or none.
    fn apply<'py>(
        &self,
        py: Python<'py>,
        rows: Bound<'py, PyAny>,
        temperature: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let rows = Numbers::of(&rows)?;
        let temperature = temperature.map(|t| Numbers::of(&t)).transpose()?;
        let bytes = py.detach(|| {
            let mut bytes = Vec::with_capacity(rows.len() * 8);
            for (k, row) in rows.chunks_exact(3).enumerate() {
                let at = match temperature.as_deref() {
                    None => 0.0,
                    Some([one]) => *one,
                    Some(each) => each[k],
                };
                let outputs = self.inner.apply([row[0], row[1], row[2]], at);
                outputs
                    .iter()
                    .for_each(|a| bytes.extend_from_slice(&a.to_ne_bytes()));
            }
            bytes
        });
        Ok(PyBytes::new(py, &bytes))
    }
}
