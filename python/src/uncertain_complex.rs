//! Complex numbers that carry their uncertainty.

use crate::uncertain::{LARGEST_POWER, Uncertain, finite};
use proofmass::uncertainty::{Uncertain as Part, UncertainComplex as Inner};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyComplex;

/// A complex value; real and imaginary part carry their causes.
#[pyclass(frozen, module = "proofmass._proofmass")]
pub(crate) struct UncertainComplex(Inner);

/// A number of this kind, a real one, or one without uncertainty.
struct Operand(Inner);

impl<'py> FromPyObject<'_, 'py> for Operand {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(number) = object.cast::<UncertainComplex>() {
            return Ok(Self(number.get().0.clone()));
        }
        if let Ok(number) = object.cast::<Uncertain>() {
            return Ok(Self(Inner::from(number.get().0.clone())));
        }
        let parts = match object.cast::<PyComplex>() {
            Ok(number) => [
                number.getattr("real")?.extract()?,
                number.getattr("imag")?.extract()?,
            ],
            Err(_) => [object.extract::<f64>()?, 0.0],
        };
        match parts.iter().all(|x| x.is_finite()) {
            true => Ok(Self(Inner::new(
                Part::exact(parts[0]),
                Part::exact(parts[1]),
            ))),
            false => Err(PyValueError::new_err("the operand is no finite number")),
        }
    }
}

/// A result that is a number, or an error.
fn checked(result: Inner) -> PyResult<UncertainComplex> {
    finite(result.re.clone())?;
    finite(result.im.clone())?;
    Ok(UncertainComplex(result))
}

#[pymethods]
impl UncertainComplex {
    /// The parts in the format of a real number.
    fn __format__(&self, py: Python<'_>, spec: &str) -> PyResult<String> {
        if spec.is_empty() {
            return Ok(self.__repr__());
        }
        let part = |part: &Part| Uncertain(part.clone()).__format__(py, spec);
        Ok(format!("({})+({})j", part(&self.0.re)?, part(&self.0.im)?))
    }

    #[staticmethod]
    fn new(re: &Bound<'_, Uncertain>, im: &Bound<'_, Uncertain>) -> Self {
        Self(Inner::new(re.get().0.clone(), im.get().0.clone()))
    }

    #[staticmethod]
    fn from_polar(
        magnitude: &Bound<'_, Uncertain>,
        phase: &Bound<'_, Uncertain>,
    ) -> PyResult<Self> {
        checked(Inner::from_polar(&magnitude.get().0, &phase.get().0))
    }

    #[getter]
    fn real(&self) -> Uncertain {
        Uncertain(self.0.re.clone())
    }

    #[getter]
    fn imag(&self) -> Uncertain {
        Uncertain(self.0.im.clone())
    }

    #[getter]
    fn value<'py>(&self, py: Python<'py>) -> Bound<'py, PyComplex> {
        PyComplex::from_doubles(py, self.0.re.value(), self.0.im.value())
    }

    /// The phase in radians.
    fn phase(&self) -> PyResult<Uncertain> {
        finite(self.0.arg())
    }

    fn conjugate(&self) -> Self {
        Self(self.0.conj())
    }

    fn exp(&self) -> PyResult<Self> {
        checked(self.0.exp())
    }

    fn log(&self) -> PyResult<Self> {
        checked(self.0.ln())
    }

    fn sqrt(&self) -> PyResult<Self> {
        checked(self.0.sqrt())
    }

    fn __abs__(&self) -> PyResult<Uncertain> {
        finite(self.0.abs())
    }

    fn __neg__(&self) -> Self {
        Self(-self.0.clone())
    }

    fn __add__(&self, other: Operand) -> PyResult<Self> {
        checked(&self.0 + &other.0)
    }

    fn __radd__(&self, other: Operand) -> PyResult<Self> {
        checked(&other.0 + &self.0)
    }

    fn __sub__(&self, other: Operand) -> PyResult<Self> {
        checked(&self.0 - &other.0)
    }

    fn __rsub__(&self, other: Operand) -> PyResult<Self> {
        checked(&other.0 - &self.0)
    }

    fn __mul__(&self, other: Operand) -> PyResult<Self> {
        checked(&self.0 * &other.0)
    }

    fn __rmul__(&self, other: Operand) -> PyResult<Self> {
        checked(&other.0 * &self.0)
    }

    fn __truediv__(&self, other: Operand) -> PyResult<Self> {
        checked(&self.0 / &other.0)
    }

    fn __rtruediv__(&self, other: Operand) -> PyResult<Self> {
        checked(&other.0 / &self.0)
    }

    fn __pow__(&self, exponent: i32, _modulo: Option<i64>) -> PyResult<Self> {
        match exponent.unsigned_abs() <= LARGEST_POWER {
            true => checked(self.0.powi(exponent)),
            false => Err(PyValueError::new_err(format!(
                "a power of {exponent} is more than the {LARGEST_POWER} that are multiplied out"
            ))),
        }
    }

    fn __complex__<'py>(&self, py: Python<'py>) -> Bound<'py, PyComplex> {
        self.value(py)
    }

    fn __reduce__(slf: &Bound<'_, Self>) -> PyResult<(Py<PyAny>, (Uncertain, Uncertain))> {
        let made = slf.py().get_type::<Self>().getattr("new")?;
        let number = slf.get();
        Ok((made.unbind(), (number.real(), number.imag())))
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other
            .cast::<Self>()
            .is_ok_and(|other| other.get().0 == self.0)
    }

    fn __repr__(&self) -> String {
        format!("<{} + j {}>", self.0.re, self.0.im)
    }
}
