//! What the Python package `proofmass` is made of: commands in the process of the interpreter, results, numbers.
//!
//! Nothing is computed here. Python code in `proofmass/` gives these names their public form.

mod buffer;
mod call;
mod commands;
mod compensation;
mod monte_carlo;
mod signals;
mod stored_result;
mod uncertain;
mod uncertain_complex;

use pyo3::prelude::*;

/// The compiled part of `proofmass`.
#[pymodule(gil_used = false)]
mod _proofmass {
    #[pymodule_export]
    use super::call::{Call, call, campaign, request};
    #[pymodule_export]
    use super::commands::{commands, result_kinds};
    #[pymodule_export]
    use super::compensation::Compensation;
    #[pymodule_export]
    use super::monte_carlo::monte_carlo;
    #[pymodule_export]
    use super::signals::{allan_deviation, fit_sine};
    #[pymodule_export]
    use super::stored_result::StoredResult;
    #[pymodule_export]
    use super::uncertain::Uncertain;
    #[pymodule_export]
    use super::uncertain_complex::UncertainComplex;
}
