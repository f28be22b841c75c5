//! Numbers that carry their uncertainty and its causes.

use crate::stored_result::refused;
use proofmass::uncertainty::{DegreesOfFreedom, Uncertain as Inner};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use std::collections::HashMap;

/// Largest exponent that is multiplied out.
pub(crate) const LARGEST_POWER: u32 = 1024;

/// A value with the causes of its uncertainty.
#[pyclass(frozen, module = "proofmass._proofmass")]
pub(crate) struct Uncertain(pub(crate) Inner);

/// A number of this kind, or one without uncertainty.
struct Operand(Inner);

impl<'py> FromPyObject<'_, 'py> for Operand {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(number) = object.cast::<Uncertain>() {
            return Ok(Self(number.get().0.clone()));
        }
        let value: f64 = object.extract()?;
        match value.is_finite() {
            true => Ok(Self(Inner::exact(value))),
            false => Err(PyValueError::new_err(format!(
                "{value} is no number to calculate with"
            ))),
        }
    }
}

/// A result that is a number, or an error.
pub(crate) fn finite(result: Inner) -> PyResult<Uncertain> {
    if result.value().is_finite() && result.standard_uncertainty().is_finite() {
        return Ok(Uncertain(result));
    }
    Err(PyValueError::new_err(
        "the result is no finite number, or its derivative is none",
    ))
}

/// `block` of `block[7]` and of `block [7]`.
fn whole_of(name: &str) -> Option<&str> {
    let (whole, number) = name.strip_suffix(']')?.rsplit_once('[')?;
    let is_number = !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit());
    is_number.then(|| whole.trim_end())
}

#[pymethods]
impl Uncertain {
    #[staticmethod]
    fn new(cause: String, value: f64, u: f64, dof: f64) -> PyResult<Self> {
        let number = Inner::new(cause, value, u).map_err(refused)?;
        let dof = DegreesOfFreedom::new(dof)
            .ok_or_else(|| PyValueError::new_err(format!("{dof} degrees of freedom are none")))?;
        finite(number.dof(dof))
    }

    /// The value.
    #[getter]
    fn value(&self) -> f64 {
        self.0.value()
    }

    /// The standard uncertainty.
    #[getter]
    fn u(&self) -> f64 {
        self.0.standard_uncertainty()
    }

    /// The effective degrees of freedom.
    #[getter]
    fn dof(&self) -> f64 {
        self.0.effective_dof().get()
    }

    /// The effective degrees of freedom, under the name that results and arrays have for them.
    #[getter]
    fn nu(&self) -> f64 {
        self.dof()
    }

    /// The expanded uncertainty for a coverage probability, by Student's t at the effective degrees of freedom.
    #[pyo3(name = "U", signature = (probability = 0.95))]
    fn expanded(&self, probability: f64) -> PyResult<f64> {
        match probability > 0.0 && probability < 1.0 {
            true => Ok(self.0.expanded(probability)),
            false => Err(PyValueError::new_err(format!(
                "{probability} is no coverage probability: it lies between 0 and 1"
            ))),
        }
    }

    /// The covariance with another number, through the causes that both name.
    fn covariance(&self, other: Operand) -> f64 {
        self.0.covariance(&other.0)
    }

    /// The coefficient of correlation; `None` where one of them is exact.
    fn correlation(&self, other: Operand) -> Option<f64> {
        self.0.correlation(&other.0)
    }

    /// Cause and contribution, the largest first. Elements of an array, and parts of a joint cause, are one line.
    fn budget(&self) -> Vec<(String, f64)> {
        let mut lines: Vec<(String, f64)> = Vec::new();
        let mut known = HashMap::new();
        for (name, contribution, _) in self.0.causes().filter(|cause| cause.1 != 0.0) {
            let whole = whole_of(name).unwrap_or(name);
            let at = *known.entry(whole.to_owned()).or_insert_with(|| {
                lines.push((whole.to_owned(), 0.0));
                lines.len() - 1
            });
            lines[at].1 += contribution * contribution;
        }
        lines.iter_mut().for_each(|line| line.1 = line.1.sqrt());
        lines.sort_by(|a, b| b.1.total_cmp(&a.1));
        lines
    }

    /// Name, contribution with its sign and degrees of freedom of every cause.
    fn causes(&self) -> Vec<(String, f64, f64)> {
        let causes = self.0.causes();
        causes
            .map(|(name, c, dof)| (name.to_owned(), c, dof.get()))
            .collect()
    }

    /// A number of such causes; a name that stands twice is one cause.
    #[staticmethod]
    fn with_causes(value: f64, causes: Vec<(String, f64, f64)>) -> PyResult<Self> {
        let mut number = Inner::exact(value);
        for (name, contribution, dof) in causes {
            let dof = DegreesOfFreedom::new(dof).ok_or_else(|| {
                PyValueError::new_err(format!("{dof} degrees of freedom are none"))
            })?;
            number = number.with_cause(name, contribution, dof);
        }
        finite(number)
    }

    /// value(u) with its unit.
    #[pyo3(signature = (unit = ""))]
    fn text(&self, unit: &str) -> String {
        self.0.in_unit(unit).to_string()
    }

    fn __str__(&self) -> String {
        self.0.to_string()
    }

    fn __repr__(&self) -> String {
        format!("<{}>", self.0)
    }

    /// `.2u` digits of u, `.3f` and its like for value and u alike, `S` behind it as value(u).
    pub(crate) fn __format__(&self, py: Python<'_>, spec: &str) -> PyResult<String> {
        if spec.is_empty() {
            return Ok(self.__str__());
        }
        let own = py.import("proofmass._uncertain")?.getattr("formatted")?;
        own.call1((self.value(), self.u(), spec))?.extract()
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let json = serde_json::to_vec(&self.0).map_err(|e| PyValueError::new_err(e.to_string()))?;
        let read = py.get_type::<Self>().getattr("read")?;
        Ok((read, (PyBytes::new(py, &json),)))
    }

    #[staticmethod]
    fn read(json: &[u8]) -> PyResult<Self> {
        let number =
            serde_json::from_slice(json).map_err(|e| PyValueError::new_err(e.to_string()))?;
        finite(number)
    }

    fn __add__(&self, other: Operand) -> PyResult<Self> {
        finite(&self.0 + &other.0)
    }

    fn __radd__(&self, other: Operand) -> PyResult<Self> {
        finite(&other.0 + &self.0)
    }

    fn __sub__(&self, other: Operand) -> PyResult<Self> {
        finite(&self.0 - &other.0)
    }

    fn __rsub__(&self, other: Operand) -> PyResult<Self> {
        finite(&other.0 - &self.0)
    }

    fn __mul__(&self, other: Operand) -> PyResult<Self> {
        finite(&self.0 * &other.0)
    }

    fn __rmul__(&self, other: Operand) -> PyResult<Self> {
        finite(&other.0 * &self.0)
    }

    fn __truediv__(&self, other: Operand) -> PyResult<Self> {
        finite(&self.0 / &other.0)
    }

    fn __rtruediv__(&self, other: Operand) -> PyResult<Self> {
        finite(&other.0 / &self.0)
    }

    fn __pow__(&self, exponent: Bound<'_, PyAny>, modulo: Option<i64>) -> PyResult<Self> {
        if modulo.is_some() {
            return Err(PyTypeError::new_err(
                "a power of an uncertain number has no modulus",
            ));
        }
        if let Ok(n) = exponent.extract::<i32>()
            && n.unsigned_abs() <= LARGEST_POWER
        {
            return finite(self.0.powi(n));
        }
        let exponent: Operand = exponent.extract()?;
        finite(self.0.powf(&exponent.0))
    }

    fn __rpow__(&self, base: Operand, modulo: Option<i64>) -> PyResult<Self> {
        match modulo {
            None => finite(base.0.powf(&self.0)),
            Some(_) => Err(PyTypeError::new_err(
                "a power of an uncertain number has no modulus",
            )),
        }
    }

    fn __neg__(&self) -> Self {
        Self(-&self.0)
    }

    fn __pos__(&self) -> Self {
        Self(self.0.clone())
    }

    fn __abs__(&self) -> PyResult<Self> {
        finite(self.0.abs())
    }

    /// What numpy's functions do with it, alone and beside arrays.
    #[pyo3(signature = (ufunc, method, *inputs, **options))]
    fn __array_ufunc__<'py>(
        slf: &Bound<'py, Self>,
        ufunc: Bound<'py, PyAny>,
        method: Bound<'py, PyAny>,
        inputs: Bound<'py, PyTuple>,
        options: Option<Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        let own = py.import("proofmass._uncertain")?.getattr("number_ufunc")?;
        let all: Vec<Bound<'py, PyAny>> =
            [ufunc, method].into_iter().chain(inputs.iter()).collect();
        own.call(PyTuple::new(py, all)?, options.as_ref())
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other
            .cast::<Self>()
            .is_ok_and(|other| other.get().0 == self.0)
    }

    /// eˣ.
    fn exp(&self) -> PyResult<Self> {
        finite(self.0.exp())
    }

    /// Natural logarithm.
    fn log(&self) -> PyResult<Self> {
        finite(self.0.ln())
    }

    /// Decimal logarithm.
    fn log10(&self) -> PyResult<Self> {
        finite(self.0.log10())
    }

    /// Square root.
    fn sqrt(&self) -> PyResult<Self> {
        finite(self.0.sqrt())
    }

    /// Sine.
    fn sin(&self) -> PyResult<Self> {
        finite(self.0.sin())
    }

    /// Cosine.
    fn cos(&self) -> PyResult<Self> {
        finite(self.0.cos())
    }

    /// Tangent.
    fn tan(&self) -> PyResult<Self> {
        finite(self.0.tan())
    }

    /// Arc sine.
    fn arcsin(&self) -> PyResult<Self> {
        finite(self.0.asin())
    }

    /// Arc cosine.
    fn arccos(&self) -> PyResult<Self> {
        finite(self.0.acos())
    }

    /// Arc tangent.
    fn arctan(&self) -> PyResult<Self> {
        finite(self.0.atan())
    }

    /// Angle of the vector (other, self).
    fn arctan2(&self, other: Operand) -> PyResult<Self> {
        finite(self.0.atan2(&other.0))
    }

    /// Hyperbolic sine.
    fn sinh(&self) -> PyResult<Self> {
        finite(self.0.sinh())
    }

    /// Hyperbolic cosine.
    fn cosh(&self) -> PyResult<Self> {
        finite(self.0.cosh())
    }

    /// Hyperbolic tangent.
    fn tanh(&self) -> PyResult<Self> {
        finite(self.0.tanh())
    }
}
