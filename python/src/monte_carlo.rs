//! Monte Carlo through a function of Python that takes columns of trials.

use crate::call::{Call, watched};
use proofmass::jobs::Trouble;
use proofmass::uncertainty::{BudgetEntries, MonteCarlo, Refusal, Trial, Trials};
use proofmass_cli::Host;
use pyo3::buffer::PyBuffer;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyList};
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};

/// The function, and what it raised first.
struct Function {
    function: Py<PyAny>,
    outputs: Vec<(String, String)>,
    raised: Arc<Mutex<Option<PyErr>>>,
}

impl Function {
    /// Values of the outputs for columns of inputs; the function is given their bytes and gives one buffer for each output.
    fn call(&self, py: Python<'_>, x: &[&[f64]], y: &mut [&mut [f64]]) -> PyResult<()> {
        let bytes = |column: &&[f64]| {
            PyBytes::new_with(py, size_of_val(*column), |bytes| {
                for (bytes, value) in bytes.chunks_exact_mut(size_of::<f64>()).zip(*column) {
                    bytes.copy_from_slice(&value.to_ne_bytes());
                }
                Ok(())
            })
        };
        let columns = x.iter().map(bytes).collect::<PyResult<Vec<_>>>()?;
        let columns = PyList::new(py, columns)?;
        let given = self.function.call1(py, (columns,))?;
        let given: Vec<Bound<'_, PyAny>> = given.extract(py)?;
        for (output, values) in y.iter_mut().zip(given) {
            PyBuffer::<f64>::get(&values)?.copy_to_slice(py, output)?;
        }
        Ok(())
    }
}

impl Trial for Function {
    fn names(&self) -> Vec<(String, String)> {
        self.outputs.clone()
    }

    fn trial(&self, x: &[f64], y: &mut [f64]) {
        let columns: Vec<&[f64]> = x.iter().map(std::slice::from_ref).collect();
        let mut outputs: Vec<&mut [f64]> = y.iter_mut().map(std::slice::from_mut).collect();
        self.trials(&columns, &mut outputs);
    }

    fn trials(&self, x: &[&[f64]], y: &mut [&mut [f64]]) {
        let Ok(raised) = self.raised.lock().map(|raised| raised.is_some()) else {
            return;
        };
        let done = match raised {
            true => Ok(()),
            false => Python::attach(|py| self.call(py, x, y)),
        };
        if let Err(error) = done
            && let Ok(mut raised) = self.raised.lock()
        {
            raised.get_or_insert(error);
        }
    }
}

/// Runs the trials; the answer is JSON, or what the function raised.
#[pyfunction]
#[allow(
    clippy::too_many_arguments,
    reason = "called by one function, which names them"
)]
pub(crate) fn monte_carlo(
    py: Python<'_>,
    function: Py<PyAny>,
    inputs: &str,
    outputs: Vec<(String, String)>,
    trials: usize,
    seed: u64,
    probability: f64,
    watch: Option<Bound<'_, PyAny>>,
) -> PyResult<(Vec<String>, Call)> {
    let entries: BudgetEntries = serde_json::from_str(inputs)
        .map_err(|e| PyValueError::new_err(format!("the inputs cannot be read: {e}")))?;
    let joint = entries.inputs().and_then(|inputs| inputs.single());
    let joint = joint.map_err(|refusal| PyValueError::new_err(refusal.to_string()))?;
    let names = entries
        .input
        .iter()
        .map(|entry| entry.name.clone())
        .collect();
    let raised = Arc::new(Mutex::new(None));
    let model = Function {
        function,
        outputs,
        raised: Arc::clone(&raised),
    };
    let call = watched(py, watch, move |listener| {
        let method = MonteCarlo::new(seed)
            .probability(probability)
            .trials(Trials::Fixed(trials));
        let failed = Arc::clone(&model.raised);
        let mut progress = |p: proofmass::uncertainty::Progress| {
            let failed = failed.lock().is_ok_and(|raised| raised.is_some());
            match failed {
                true => ControlFlow::Break(()),
                false => listener.progress("trials", p.done as u64, p.most as u64),
            }
        };
        let sampled = method.run_with(&model, &joint, &mut progress);
        let sampled = sampled.map_err(|refusal: Refusal| Trouble::from(refusal))?;
        let json = serde_json::to_vec(&sampled)
            .map_err(|e| Trouble::data(format!("the result cannot be written: {e}")))?;
        listener.output(&json);
        Ok(())
    })?;
    let raised = raised.lock().ok().and_then(|mut raised| raised.take());
    match raised {
        Some(error) => Err(error),
        None => Ok((names, call)),
    }
}
