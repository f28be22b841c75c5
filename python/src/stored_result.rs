//! A result, as Python holds it.

use crate::uncertain::Uncertain;
use proofmass::io::OutputFolder;
use proofmass::jobs::{StoredResult as Inner, Trouble};
use proofmass::report::terminal;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;
use std::sync::Arc;

/// A result of whatever command.
#[pyclass(frozen, module = "proofmass._proofmass")]
pub(crate) struct StoredResult(pub(crate) Arc<Inner>);

/// The sentence of an error with its remedy.
pub(crate) fn refused(trouble: impl Into<Trouble>) -> PyErr {
    let trouble = trouble.into();
    let hint = trouble.hint().map(|hint| format!(" ({hint})"));
    PyValueError::new_err(format!("{trouble}{}", hint.unwrap_or_default()))
}

#[pymethods]
impl StoredResult {
    /// Reads a result; `beside` are the files that stand beside it alone.
    #[staticmethod]
    fn read(json: &[u8], beside: Vec<(String, Vec<u8>)>) -> PyResult<Self> {
        let result = Inner::from_json(json).map_err(refused)?;
        let found = |name: &str| {
            let file = beside.iter().find(|(known, _)| known == name);
            file.map(|(_, bytes)| bytes.clone())
                .ok_or_else(|| Trouble::data(format!("{name} is missing beside the result")))
        };
        let result = result.with_files_beside(found).map_err(refused)?;
        Ok(Self(Arc::new(result)))
    }

    fn json<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let json = py.detach(|| self.0.to_json()).map_err(refused)?;
        Ok(PyBytes::new(py, &json))
    }

    fn files<'py>(&self, py: Python<'py>) -> PyResult<Vec<(String, Bound<'py, PyBytes>)>> {
        let files = py.detach(|| self.0.files()).map_err(refused)?;
        let files = files.into_iter();
        Ok(files
            .map(|(name, bytes)| (name, PyBytes::new(py, &bytes)))
            .collect())
    }

    /// Writes the folder that the command writes; where it stands.
    fn write(&self, py: Python<'_>, folder: PathBuf, force: bool) -> PyResult<PathBuf> {
        py.detach(|| {
            let place = OutputFolder::create(folder, force)?;
            place.expect_kind(self.0.kind())?;
            for (name, bytes) in self.0.files()? {
                place.write(&name, bytes)?;
            }
            Ok::<_, Trouble>(place.commit()?)
        })
        .map_err(refused)
    }

    fn html(&self, py: Python<'_>) -> PyResult<String> {
        py.detach(|| self.0.html()).map_err(refused)
    }

    /// The plot that shows the result, as SVG, where there is one.
    fn picture(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let Some(figure) = self.0.report().answer.figure else {
            return Ok(None);
        };
        let drawn = py.detach(|| figure.svg("figure"));
        drawn.map(Some).map_err(refused)
    }

    /// A parameter of the joint estimate, with its causes.
    fn uncertain(&self, name: &str) -> PyResult<Option<Uncertain>> {
        let estimate = self.0.estimate().map_err(refused)?;
        Ok(estimate
            .and_then(|e| proofmass::uncertainty::Uncertain::of(e, name))
            .map(Uncertain))
    }

    /// How each recording was read, in a line.
    fn readings(&self) -> Vec<String> {
        let lines = self.0.record().readings().into_iter();
        lines.map(|(_, line)| line).collect()
    }

    /// Files that stand beside result.json alone.
    fn beside<'py>(&self, py: Python<'py>) -> Vec<(String, Bound<'py, PyBytes>)> {
        let files = self.0.beside().iter();
        files
            .map(|(name, bytes)| (name.clone(), PyBytes::new(py, bytes)))
            .collect()
    }

    /// The summary as a terminal shows it, so many columns wide.
    fn text(&self, width: usize) -> PyResult<String> {
        let options = terminal::Options {
            width,
            colour: false,
            filed: true,
            details: true,
        };
        terminal::render(&self.0.summary(), &options).map_err(refused)
    }

    /// The calibration file, where the result is a calibration.
    fn calibration<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyBytes>>> {
        let json = self.0.calibration().map(|file| file.to_json()).transpose();
        Ok(json.map_err(refused)?.map(|json| PyBytes::new(py, &json)))
    }
}
